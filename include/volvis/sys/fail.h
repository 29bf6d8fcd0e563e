/** @file
 * Making failures. vv_fail is the only way to make a failing status, so none is without text.
 */
#ifndef VOLVIS_SYS_FAIL_H
#define VOLVIS_SYS_FAIL_H
#include <volvis/status.h>
VV_BEGIN_DECLS

/** Sets the thread's error and returns `status`. The text is one sentence without a full stop or line end. */
VV_API vv_status vv_fail(vv_status status, const char *format, ...) VV_PRINTF(2, 3);
/** The same with the file and the place inside it (either may be NULL); the text becomes "file:where: text". */
VV_API vv_status vv_fail_at(vv_status status, const char *file, const char *where, const char *format, ...)
    VV_PRINTF(4, 5);
/** Adds what only the caller knows in front of the thread's text: "volume 'head': ...". Returns `status`. */
VV_API vv_status vv_fail_in(vv_status status, const char *format, ...) VV_PRINTF(2, 3);
/** "needs N bytes; ..." for memory that the system did not give: VV_E_MEMORY, or the status of a refused vv_alloc(). */
VV_API vv_status vv_fail_memory(size_t bytes);

VV_END_DECLS
#endif
