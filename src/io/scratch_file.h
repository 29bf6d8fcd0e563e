/** @file
 * Temporary files for what memory does not hold between two passes: without a name, so that nothing is left of them,
 * however the program ends.
 */
#ifndef VVI_IO_SCRATCH_FILE_H
#define VVI_IO_SCRATCH_FILE_H
#include "core/status.h"
#include <volvis/runtime.h>

typedef struct vvi_scratch_file vvi_scratch_file;

/** Room for `bytes`, in $TMPDIR or /tmp; VV_E_WRITE, before any work, where the disk has less. `name` stands in errors.
 */
vv_status vvi_scratch_file_new(vvi_scratch_file **out, uint64_t bytes, const char *name, vv_job *job);
void vvi_scratch_file_free(vvi_scratch_file *file); /* NULL is fine */
/** n bytes at a place; one thread at a time. */
vv_status vvi_scratch_file_write(vvi_scratch_file *file, uint64_t at, const void *data, size_t n, vv_job *job);
vv_status vvi_scratch_file_read(vvi_scratch_file *file, uint64_t at, void *out, size_t n, vv_job *job);
/** All of it as memory that is no burden, as the system may put it on the disk at any time: zeros at first, there until
 * the file is freed. VV_E_MEMORY where there are no addresses for it. */
vv_status vvi_scratch_file_map(void **out, vvi_scratch_file *file);
#endif
