/** @file
 * Making failures. vv_fail is the only way to make a failing status, so none is without text.
 */
#ifndef VVI_CORE_STATUS_H
#define VVI_CORE_STATUS_H
#include <stdarg.h>
#include <volvis/status.h>

/** Sets the thread's error and returns `status`. The text is one sentence without a full stop or line end. */
vv_status vv_fail(vv_status status, const char *format, ...) VV_PRINTF(2, 3);
/** The same with the file and the place inside it (either may be NULL); the text becomes "file:where: text". */
vv_status vv_fail_at(vv_status status, const char *file, const char *where, const char *format, ...) VV_PRINTF(4, 5);
/** Adds what only the caller knows in front of the thread's text: "volume 'head': ...". Returns `status`. */
vv_status vv_fail_in(vv_status status, const char *format, ...) VV_PRINTF(2, 3);
/** "needs N bytes; ..." for a failed allocation of the system: VV_E_MEMORY, or the status of a refused vvi_alloc. */
vv_status vv_fail_memory(size_t bytes);

#if defined(__clang_analyzer__) && !defined(VVI_MAKES_FAILURES)
/* The analyzer sees no further than a declaration: this tells it that making a failure never gives VV_OK. */
#define vv_fail(...) ((void)(vv_fail)(__VA_ARGS__), VV_E_INTERNAL)
#define vv_fail_at(...) ((void)(vv_fail_at)(__VA_ARGS__), VV_E_INTERNAL)
#define vv_fail_in(...) ((void)(vv_fail_in)(__VA_ARGS__), VV_E_INTERNAL)
#define vv_fail_memory(bytes) ((void)(vv_fail_memory)(bytes), VV_E_MEMORY)
#endif

/** An error lifted out of its thread: how a worker's failure reaches the thread that waits for the job. */
typedef struct vvi_error_copy {
    vv_status status;
    char *message, *file, *where;
} vvi_error_copy;
void vvi_error_take(vvi_error_copy *out);      /* this thread's last error, copied */
vv_status vvi_error_put(vvi_error_copy *copy); /* becomes this thread's last error; frees the copy; its status */
void vvi_error_copy_free(vvi_error_copy *copy);

/** A broken promise inside the library; on in debug builds and tests. Never for outside input. */
#ifdef NDEBUG
#define vvi_check(condition) ((void)sizeof(condition))
#else
#define vvi_check(condition) ((condition) ? (void)0 : vvi_check_failed(#condition, __FILE__, __LINE__))
#endif
_Noreturn void vvi_check_failed(const char *condition, const char *file, int line);

#endif
