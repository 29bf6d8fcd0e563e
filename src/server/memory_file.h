/** @file
 * Files that are on no disk: what pages fetch where they may write nothing.
 */
#ifndef VVI_SERVER_MEMORY_FILE_H
#define VVI_SERVER_MEMORY_FILE_H
#include <stddef.h>
#include <stdint.h>
#include <volvis/status.h>

/** One with these bytes, yours to close(); it is counted nowhere. VV_E_MEMORY. */
vv_status vvi_memory_file_new(int *fd_out, const uint8_t *bytes, size_t n);
/** Opened once more, from its beginning; -1: it cannot be. */
int vvi_memory_file_open(int fd);
#endif
