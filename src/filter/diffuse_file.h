/** @file
 * Diffusion of more samples than memory holds: as many steps as it has room for go through all slices as a wave, and
 * what they leave lies in a temporary file, from which the next ones begin.
 */
#ifndef VVI_FILTER_DIFFUSE_FILE_H
#define VVI_FILTER_DIFFUSE_FILE_H
#include "filter/diffuse_wave.h"

typedef struct vvi_diffuse_file vvi_diffuse_file;

/** Bytes on the disk. */
uint64_t vvi_diffuse_file_bytes(const vv_field_info *info);
/** Of a field, which outlives it. */
vv_status vvi_diffuse_file_new(vvi_diffuse_file **out, const vv_field *in, vv_job *job);
void vvi_diffuse_file_free(vvi_diffuse_file *file); /* NULL is fine */
/** All steps of the wave for its component, of all samples: the same numbers as at once. */
vv_status vvi_diffuse_file_run(vvi_diffuse_file *file, const vvi_diffuse_wave *wave);
/** Whole slices of the result, once all components have run. */
vv_status vvi_diffuse_file_slices(vv_field **out, vvi_diffuse_file *file, const vv_box *box, vv_job *job);
#endif
