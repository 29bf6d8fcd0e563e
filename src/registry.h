/** @file
 * The rows that src/registry.c assembles. A new row is declared here by its own component's header and listed there.
 */
#ifndef VVI_REGISTRY_H
#define VVI_REGISTRY_H
#include "model/made_data.h"
#include <volvis/sys/registry.h>

extern const vv_format vvi_format_seg_nrrd, vvi_format_nrrd, vvi_format_nifti, vvi_format_npy, vvi_format_npz,
    vvi_format_raw;
extern const vv_format vvi_format_ome_tiff, vvi_format_tiff;
extern const vv_format vvi_format_mrc, vvi_format_slices, vvi_format_steps, vvi_format_pvd;
extern const vv_format vvi_format_dicom;
extern const vv_format vvi_format_metaimage, vvi_format_slc;
extern const vv_format vvi_format_vvh, vvi_format_dat, vvi_format_inr, vvi_format_pvm;
extern const vv_format vvi_format_ome_zarr, vvi_format_ome_zarr_0_5;
extern const vv_format vvi_format_vti, vvi_format_vtr, vvi_format_vtk, vvi_format_dx, vvi_format_cube;
extern const vv_format vvi_format_hdf5, vvi_format_netcdf, vvi_format_minc, vvi_format_imaris, vvi_format_bdv;
extern const vv_image_format vvi_image_format_png, vvi_image_format_jpeg, vvi_image_format_exr, vvi_image_format_pfm;
extern const vv_image_format vvi_image_format_tiff, vvi_image_format_webp, vvi_image_format_pdf;
extern const vv_mesh_format vvi_mesh_format_ply, vvi_mesh_format_stl, vvi_mesh_format_off, vvi_mesh_format_obj;
extern const vv_mesh_format vvi_mesh_format_gltf, vvi_mesh_format_glb, vvi_mesh_format_vtp;
extern const vv_operation vvi_operation_channel;
extern const vv_operation vvi_operation_merge;
extern const vv_operation vvi_operation_join;
extern const vv_operation vvi_operation_crop;
extern const vv_operation vvi_operation_pad;
extern const vv_operation vvi_operation_flip;
extern const vv_operation vvi_operation_reorient;
extern const vv_operation vvi_operation_resample;
extern const vv_operation vvi_operation_project;
extern const vv_operation vvi_operation_rescale;
extern const vv_operation vvi_operation_clamp;
extern const vv_operation vvi_operation_equalize;
extern const vv_operation vvi_operation_match;
extern const vv_operation vvi_operation_gaussian;
extern const vv_operation vvi_operation_median;
extern const vv_operation vvi_operation_mean;
extern const vv_operation vvi_operation_dilate;
extern const vv_operation vvi_operation_erode;
extern const vv_operation vvi_operation_open;
extern const vv_operation vvi_operation_close;
extern const vv_operation vvi_operation_top_hat;
extern const vv_operation vvi_operation_unsharp;
extern const vv_operation vvi_operation_gradient;
extern const vv_operation vvi_operation_laplacian;
extern const vv_operation vvi_operation_vesselness;
extern const vv_operation vvi_operation_threshold;
extern const vv_operation vvi_operation_components;
extern const vv_operation vvi_operation_fill_holes;
extern const vv_operation vvi_operation_calc;
extern const vv_operation vvi_operation_mask;
extern const vv_operation vvi_operation_bilateral;
extern const vv_operation vvi_operation_diffuse;
extern const vv_operation vvi_operation_denoise;
extern const vv_operation vvi_operation_add_noise;
extern const vv_operation vvi_operation_bias;
extern const vv_operation vvi_operation_distance;
extern const vv_operation vvi_operation_grow;
extern const vv_operation vvi_operation_watershed;
extern const vv_operation vvi_operation_voxelize;
extern const vv_operation vvi_operation_skeleton;
extern const vv_operation vvi_operation_isosurface;
extern const vv_operation vvi_operation_simplify;
extern const vv_operation vvi_operation_smooth;
extern const vv_renderer vvi_renderer_raycast, vvi_renderer_surface, vvi_renderer_reduced, vvi_renderer_boxes,
    vvi_renderer_slice;
extern const vv_data_kind vvi_data_kind_regular, vvi_data_kind_mesh;
extern const vvi_made_data vvi_made_data_by_runs;
#endif
