/** @file
 * MetaImage: a text header of keys, and samples behind it or in files that it names. Parts: metaimage.c (header to
 * plan, samples), metaimage_place.c (where samples lie), metaimage_write.c.
 */
#ifndef VVI_IO_METAIMAGE_H
#define VVI_IO_METAIMAGE_H
#include "io/header_keys.h"

#define VVI_METAIMAGE_AXES 4

/** What the format has no key for: own keys, which other readers pass over. */
#define VVI_METAIMAGE_SPACE "VolVisSpace" /* "plain": its axes are not those of a body */
#define VVI_METAIMAGE_UNIT "VolVisUnit"
#define VVI_METAIMAGE_MEANING "VolVisMeaning" /* "scalar", "rgb", "rgba", "vector" or "label" */
#define VVI_METAIMAGE_VALUE_UNIT "VolVisValueUnit"
#define VVI_METAIMAGE_FRAME_UNIT "VolVisFrameUnit"

/** Space, placement and unit of a header with `n_dims` axes of these sizes. */
vv_status vvi_metaimage_place(vv_field_info *info, vvi_keys *keys, int n_dims, vv_notes *notes);
/** For each axis the side that it comes from, as the format writes it: "RAI" runs to the left, back and top. */
void vvi_metaimage_letters(char out[4], const vv_affine *lps);
vv_status vvi_metaimage_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                              const vv_write_options *options, vv_job *job);
extern const char *const vvi_metaimage_encodings[];
#endif
