/** @file
 * Status codes and the sentence behind the last failure of a thread.
 *
 * A function that can fail returns vv_status: VV_OK or a negative code. Codes exist for what a caller can act on; the
 * text, from vv_error_last(), is one sentence for people: place, expected, found, what to do.
 */
#ifndef VOLVIS_STATUS_H
#define VOLVIS_STATUS_H
#include <volvis/base.h>
VV_BEGIN_DECLS

typedef enum vv_status {
    VV_OK = 0,
    VV_E_ARGUMENT = -1,    /**< the words were wrong: an unknown name, a value out of range, a wrong type */
    VV_E_MEMORY = -2,      /**< the system gave no memory */
    VV_E_LIMIT = -3,       /**< it would exceed the memory limit; of a World's text and paths also a limit on size */
    VV_E_READ = -4,        /**< an input cannot be opened or read */
    VV_E_FORMAT = -5,      /**< an input was read but its contents are not what its format says */
    VV_E_WRITE = -6,       /**< an output cannot be written */
    VV_E_UNSUPPORTED = -7, /**< valid, but not available here; the text says why */
    VV_E_CANCELLED = -8,   /**< stopped by vv_job_cancel() or by a progress callback */
    VV_E_NOT_FOUND = -9,   /**< no object of that name */
    VV_E_INTERNAL = -10    /**< a broken promise inside the library: please report it */
} vv_status;

/** The last failure of the calling thread. The strings live until the thread's next failing call. */
typedef struct vv_error {
    vv_status status;    /**< VV_OK when nothing has failed yet */
    const char *message; /**< one sentence, never NULL */
    const char *file;    /**< the input or output it is about, or NULL */
    const char *where;   /**< line, byte offset or property path inside it, or NULL */
} vv_error;

/** Never NULL. Threads: each sees its own. */
VV_API const vv_error *vv_error_last(void);

/** "argument", "memory", ...: the stable word for a status that scripts may test. */
VV_API const char *vv_status_name(vv_status status);

VV_END_DECLS
#endif
