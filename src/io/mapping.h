/** @file
 * Mapped files that may shrink while they are mapped.
 */
#ifndef VVI_IO_MAPPING_H
#define VVI_IO_MAPPING_H
#include "io/source.h"

/** Bytes [offset, offset + n) of an open regular file, and at least VVI_MAPPING_GUARD readable bytes after them. */
vv_status vvi_mapping_new(vvi_mapping **out, const void **data_out, size_t *guard_out, int fd, uint64_t offset,
                          uint64_t n, const char *name, vv_job *job);
#endif
