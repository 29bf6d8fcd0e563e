/* Every table of the library, in one place. Order decides ties: best first. */
#include "registry.h"

/* clang-format off */
static const vv_format *const formats[] = {
    &vvi_format_seg_nrrd, &vvi_format_nrrd, &vvi_format_nifti,  &vvi_format_dicom,    &vvi_format_metaimage,
    &vvi_format_slc,  &vvi_format_vvh,    &vvi_format_dat,      &vvi_format_inr,
    &vvi_format_pvm,  &vvi_format_npy,    &vvi_format_ome_tiff, &vvi_format_tiff,
    &vvi_format_mrc,  &vvi_format_hdf5,   &vvi_format_minc,     &vvi_format_imaris,
    &vvi_format_bdv,  &vvi_format_netcdf, &vvi_format_ome_zarr, &vvi_format_ome_zarr_0_5,
    &vvi_format_pvd,  &vvi_format_vti,    &vvi_format_vtr,      &vvi_format_vtk,
    &vvi_format_dx,   &vvi_format_cube,   &vvi_format_slices,   &vvi_format_steps,
    &vvi_format_npz,  &vvi_format_raw,    NULL,
};
/* clang-format on */

static const vv_image_format *const image_formats[] = {
    &vvi_image_format_png, &vvi_image_format_jpeg, &vvi_image_format_tiff, &vvi_image_format_webp,
    &vvi_image_format_exr, &vvi_image_format_pdf,  &vvi_image_format_pfm,  NULL,
};

static const vv_mesh_format *const mesh_formats[] = {
    &vvi_mesh_format_ply, &vvi_mesh_format_stl,  &vvi_mesh_format_off, &vvi_mesh_format_obj,
    &vvi_mesh_format_glb, &vvi_mesh_format_gltf, &vvi_mesh_format_vtp, NULL,
};

/* clang-format off */
static const vv_operation *const operations[] = {
    &vvi_operation_channel,
    &vvi_operation_merge,
    &vvi_operation_join,
    &vvi_operation_crop,
    &vvi_operation_pad,
    &vvi_operation_flip,
    &vvi_operation_reorient,
    &vvi_operation_resample,
    &vvi_operation_project,
    &vvi_operation_rescale,
    &vvi_operation_clamp,
    &vvi_operation_equalize,
    &vvi_operation_match,
    &vvi_operation_gaussian,
    &vvi_operation_median,
    &vvi_operation_mean,
    &vvi_operation_dilate,
    &vvi_operation_erode,
    &vvi_operation_open,
    &vvi_operation_close,
    &vvi_operation_top_hat,
    &vvi_operation_unsharp,
    &vvi_operation_gradient,
    &vvi_operation_laplacian,
    &vvi_operation_vesselness,
    &vvi_operation_threshold,
    &vvi_operation_components,
    &vvi_operation_fill_holes,
    &vvi_operation_calc,
    &vvi_operation_mask,
    &vvi_operation_bilateral,
    &vvi_operation_diffuse,
    &vvi_operation_denoise,
    &vvi_operation_add_noise,
    &vvi_operation_bias,
    &vvi_operation_distance,
    &vvi_operation_grow,
    &vvi_operation_watershed,
    &vvi_operation_skeleton,
    &vvi_operation_voxelize,
    &vvi_operation_isosurface,
    &vvi_operation_simplify,
    &vvi_operation_smooth,
    NULL,
};
/* clang-format on */

static const vv_renderer *const renderers[] = {
    &vvi_renderer_raycast, &vvi_renderer_surface, &vvi_renderer_reduced, &vvi_renderer_boxes, &vvi_renderer_slice, NULL,
};

static const vv_data_kind *const data_kinds[] = {
    &vvi_data_kind_regular,
    &vvi_data_kind_mesh,
    NULL,
};

static const vv_registry builtin = {
    .formats = formats,
    .image_formats = image_formats,
    .mesh_formats = mesh_formats,
    .operations = operations,
    .renderers = renderers,
    .data_kinds = data_kinds,
    .made_data = &vvi_made_data_by_runs,
};

const vv_registry *vv_registry_builtin(void)
{
    return &builtin;
}
