/** @file
 * Raw samples with a header to write by hand. Parts: vvh.c (reading), vvh_write.c.
 */
#ifndef VVI_IO_VVH_H
#define VVI_IO_VVH_H
#include "io/header_keys.h"

vv_status vvi_vvh_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                        vv_job *job);
extern const char *const vvi_vvh_encodings[];
#endif
