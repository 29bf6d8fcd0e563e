/** @file
 * Which voxels are neighbours, as people say it.
 */
#ifndef VVI_SEGMENT_CONNECTIVITY_H
#define VVI_SEGMENT_CONNECTIVITY_H
#include <volvis/property.h>

/** By number: 6, 18, 26; one more than it is how many axes neighbours differ by at most. */
extern const char *const vvi_connectivity_names[];
extern const char *const vvi_connectivity_aliases[];

/** Its row. `whose`: the neighbours of which voxels are meant. */
#define VVI_CONNECTIVITY_PROPERTY(type, field, whose)                                                                  \
    {                                                                                                                  \
        VV_PROP(type, field), .kind = VV_KIND_ENUM, .names = vvi_connectivity_names,                                   \
                              .aliases = vvi_connectivity_aliases,                                                     \
                              .doc = "how voxels of " whose " touch: at faces (6, in an image 4), at edges too (18), " \
                                     "at corners too (26, in an image 8)"                                              \
    }
#endif
