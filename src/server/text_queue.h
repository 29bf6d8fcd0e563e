/** @file
 * Texts that wait to be sent to one client. Of those that tell how things stand, the newest of a kind alone waits: who
 * reads slowly misses what was true meanwhile, and costs no more than others.
 */
#ifndef VVI_SERVER_TEXT_QUEUE_H
#define VVI_SERVER_TEXT_QUEUE_H
#include <stdbool.h>
#include <stddef.h>

/** A text may be longer than the first; but where so many bytes of those that are kept wait beside the longest of them,
 * no more are taken: a page ends of what it asks for itself, and never of what others do. */
enum { VVI_LINES_MOST = 256 << 10, VVI_LINES_NOTICES = 16 };

typedef enum vvi_line_kind {
    VVI_LINE_KEPT,    /**< answers: all of them are sent */
    VVI_LINE_NOTICE,  /**< the newest VVI_LINES_NOTICES are */
    VVI_LINE_ENDED,   /**< ends of jobs: the same */
    VVI_LINE_CLIENTS, /**< the newest alone is, of this and the next kinds */
    VVI_LINE_JOB,
    VVI_LINE_FAILED,
    VVI_LINE_RESOLVED
} vvi_line_kind;

typedef struct vvi_line {
    struct vvi_line *next;
    vvi_line_kind kind;
    char *text;
    size_t n;
} vvi_line;

/** Zeros: none. */
typedef struct vvi_text_queue {
    vvi_line *first;
} vvi_text_queue;

/** Takes the text, always. False: NULL was given, there is no memory, or it is to be kept and VVI_LINES_MOST wait
 * beside the longest. */
bool vvi_text_queue_put(vvi_text_queue *lines, vvi_line_kind kind, char *text);
/** The one to send next, free() it; NULL: none. urgent: those that nothing newer will replace alone. */
char *vvi_text_queue_take(size_t *n_out, vvi_text_queue *lines, bool urgent);
bool vvi_text_queue_any(const vvi_text_queue *lines, bool urgent);
void vvi_text_queue_clear(vvi_text_queue *lines);
#endif
