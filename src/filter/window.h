/** @file
 * Windows: the box of samples around each sample that a filter looks at.
 */
#ifndef VVI_FILTER_WINDOW_H
#define VVI_FILTER_WINDOW_H
#include "grid/field.h"
#include "grid/slabs.h"
#include <volvis/property.h>

/** What filters with a window are told of it: all of their parameters, or the first member of them. */
typedef struct vvi_window_params {
    vv_object object;
    double radius;
    vv_vec3 radius_voxels;
} vvi_window_params;

/** Their rows, the first two of the class. */
#define VVI_WINDOW_PROPERTIES                                                                                          \
    {VV_PROP(vvi_window_params, radius),                                                                               \
     .kind = VV_KIND_F64,                                                                                              \
     .quantity = VV_Q_LENGTH,                                                                                          \
     .limited = true,                                                                                                  \
     .min = 0,                                                                                                         \
     .max = 1e12,                                                                                                      \
     .automatic = "one voxel along each axis",                                                                         \
     .doc = "how far the window reaches to each side, a length: 1.5mm, 2vox; rounded to whole voxels of each axis; "   \
            "0 changes nothing"},                                                                                      \
    {                                                                                                                  \
        VV_PROP(vvi_window_params, radius_voxels), .kind = VV_KIND_VEC3, .automatic = "from radius",                   \
                                                   .doc = "instead of radius: whole voxels along x, y, z"              \
    }

/** For vv_class.check. */
vv_status vvi_window_check(const vv_object *params, const char *path);
/** Voxels to each side along x, y, z; none along axes of one sample. VV_E_ARGUMENT, with the filter's name, for windows
 * of more than `most` samples. */
vv_status vvi_window_radius(int64_t radius[3], const vv_field_info *info, const vv_object *params, const char *name,
                            int64_t most);
/** The samples of a field that the windows of a box's samples have in them. */
vv_box vvi_window_reach(const vv_box *box, const int64_t radius[3], const int64_t dims[3]);
/** A box cut into tiles, each of which has at most `most` samples with its margin of `radius`, where that can be. */
vvi_slabs vvi_window_tiles(const vv_box *box, const int64_t radius[3], int64_t most);
/** Tiles of which most is not margin, however wide that is. */
vvi_slabs vvi_window_wide_tiles(const vv_box *box, const int64_t radius[3]);
/** A box cut into columns: pieces of rows, of at most `row` samples, of about `slice` samples of a slice, in at most
 * `rows_most` rows; through all slices, unless there would be too few of them for several threads. */
vvi_slabs vvi_window_columns(const vv_box *box, const int64_t radius[3], int64_t row, int64_t slice, int64_t rows_most);
#endif
