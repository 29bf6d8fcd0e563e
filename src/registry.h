/** @file
 * The rows that src/registry.c assembles. A new row is declared here by its own component's header and listed there.
 */
#ifndef VVI_REGISTRY_H
#define VVI_REGISTRY_H
#include <volvis/sys/registry.h>

extern const vv_format vvi_format_nrrd, vvi_format_nifti, vvi_format_npy, vvi_format_raw;
extern const vv_image_format vvi_image_format_png, vvi_image_format_jpeg, vvi_image_format_exr, vvi_image_format_pfm;
extern const vv_operation vvi_operation_crop, vvi_operation_flip, vvi_operation_rescale, vvi_operation_gaussian;
extern const vv_renderer vvi_renderer_raycast;
extern const vv_data_kind vvi_data_kind_regular;
#endif
