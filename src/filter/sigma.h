/** @file
 * Standard deviations in space: how far a filter with a Gaussian reaches.
 */
#ifndef VVI_FILTER_SIGMA_H
#define VVI_FILTER_SIGMA_H
#include "core/status.h"
#include <volvis/field.h>
#include <volvis/property.h>

/** What such filters are told of it: all of their parameters, or the first member of them. */
typedef struct vvi_sigma_params {
    vv_object object;
    double sigma;
    vv_vec3 sigma_voxels;
} vvi_sigma_params;

/** Their rows, the first two of the class. */
#define VVI_SIGMA_PROPERTIES                                                                                           \
    {VV_PROP(vvi_sigma_params, sigma),                                                                                 \
     .kind = VV_KIND_F64,                                                                                              \
     .quantity = VV_Q_LENGTH,                                                                                          \
     .limited = true,                                                                                                  \
     .min = 0,                                                                                                         \
     .max = 1e12,                                                                                                      \
     .automatic = "one voxel along each axis",                                                                         \
     .doc = "standard deviation, a length: 1.5mm, 2vox; 0 changes nothing"},                                           \
    {                                                                                                                  \
        VV_PROP(vvi_sigma_params, sigma_voxels), .kind = VV_KIND_VEC3, .automatic = "from sigma",                      \
                                                 .doc = "instead of sigma: standard deviations along x, y, z in "      \
                                                        "voxels of each axis"                                          \
    }

/** For vv_class.check. */
vv_status vvi_sigma_check(const vv_object *params, const char *path);
/** In voxels along x, y, z, at most `most`; 0 along axes of one sample. Errors have the filter's name. */
vv_status vvi_sigma_voxels(double sigma[3], const vv_field_info *info, const vv_object *params, const char *name,
                           double most);
#endif
