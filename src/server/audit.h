/** @file
 * A file that tells who came and what they opened and wrote: a line of JSON each. Neither secrets nor what is in files
 * is ever in it.
 *
 * Threads: that of the session.
 */
#ifndef VVI_SERVER_AUDIT_H
#define VVI_SERVER_AUDIT_H
#include "core/status.h"
#include <jansson.h>

typedef struct vvi_audit vvi_audit;

/** Who does something: where he is, and his number among all clients of the session; 0: he is none. */
typedef struct vvi_actor {
    const char *address;
    uint64_t client;
} vvi_actor;

/** Goes on behind what the file has; it is made for its owner alone. VV_E_WRITE. */
vv_status vvi_audit_open(vvi_audit **out, const char *path);
void vvi_audit_close(vvi_audit *audit); /* NULL is fine */
/** A sentence why the last lines are not there, yours to free(); NULL: all are. The file tells how many are missing as
 * soon as it can be written again. */
char *vvi_audit_problem(const vvi_audit *audit);
/** what: one word; object: what it was done with, NULL: nothing. No audit: nothing is done. */
void vvi_audit_note(vvi_audit *audit, vvi_actor who, const char *what, const char *object, bool refused);
/** The same for a message of a page, if it is one that opens, writes or makes files. */
void vvi_audit_message(vvi_audit *audit, vvi_actor who, const json_t *message, bool refused);
#endif
