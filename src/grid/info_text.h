/** @file
 * Samples and values in a few words, for people.
 */
#ifndef VVI_GRID_INFO_TEXT_H
#define VVI_GRID_INFO_TEXT_H
#include <volvis/mesh.h>

enum { VVI_SAMPLES_TEXT = 128, VVI_MESH_TEXT = 128, VVI_SCALED_TEXT = 96, VVI_VALUE_TEXT = 32 };

/** "64 x 64 x 32 f32, 3 channels, 4 time steps" */
void vvi_samples_print(char out[VVI_SAMPLES_TEXT], const vv_field_info *info, int64_t n_frames);
/** "8 vertices, 12 triangles, normals" */
void vvi_mesh_print(char out[VVI_MESH_TEXT], const vv_mesh_info *mesh);
/** What makes values of stored numbers, as in "i16 * 0.5 + 3", "stored - 1024". */
void vvi_scaled_print(char out[VVI_SCALED_TEXT], const char *stored, double scale, double offset);
/** A value among values from lo to hi with as many digits as tell them apart: 1000000015 where 1000000000 is near.
 * Whole numbers have all their digits. */
void vvi_value_print(char out[VVI_VALUE_TEXT], double value, double lo, double hi);
#endif
