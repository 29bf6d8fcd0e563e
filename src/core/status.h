/** @file
 * Failures inside the library, beside the making of them (volvis/sys/fail.h).
 */
#ifndef VVI_CORE_STATUS_H
#define VVI_CORE_STATUS_H
#include <stdarg.h>
#include <volvis/status.h>
#include <volvis/sys/fail.h>

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
