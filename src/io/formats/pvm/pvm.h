/** @file
 * PVM volumes. Parts: pvm.c (header and samples), pvm_dds.c (the code that most of them are packed in).
 */
#ifndef VVI_IO_PVM_H
#define VVI_IO_PVM_H
#include "io/source.h"

/** Whether these first bytes begin a DDS stream: 1 (v3d), 2 (v3e), 0. */
int vvi_pvm_dds_version(const uint8_t *head, size_t n);
/** All bytes of a DDS stream, as far as they are there; free with vvi_free(). */
vv_status vvi_pvm_decode_dds(uint8_t **out, size_t *n_out, vv_source *source, int version, vv_job *job);
#endif
