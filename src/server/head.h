/** @file
 * The head of a request as bytes, read in one way alone: what could be read in two is refused. Apart from any socket.
 */
#ifndef VVI_SERVER_HEAD_H
#define VVI_SERVER_HEAD_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Bytes of a head, of its first line, and lines of headers, at most. Other servers of the same host name share its
 * cookies, which makes heads long. */
enum { VVI_HEAD_MOST = 16384, VVI_HEAD_LINE = 8192, VVI_HEAD_LINES = 100 };

typedef enum vvi_method {
    VVI_METHOD_OTHER,
    VVI_METHOD_GET,
    VVI_METHOD_POST,
    VVI_METHOD_PUT,
    VVI_METHOD_DELETE
} vvi_method;

/** Texts are parts of the bytes that were read; NULL: the request does not say. */
typedef struct vvi_head {
    vvi_method method;
    bool without_body; /**< HEAD: its answer has none */
    char *path;        /**< without what follows '?', and with %41 as "A": UTF-8 without control characters */
    bool has_query;
    char *host, *origin, *fetch_site, *fetch_mode, *fetch_dest, *authorization, *cookie;
    char *connection, *upgrade, *socket_key, *socket_version, *socket_protocols;
    char *length_text, *coding, *expect;
    bool waits; /**< for a word that the body may come (Expect: 100-continue) */
    bool has_length;
    uint64_t length; /**< Content-Length */
} vvi_head;

/** Reads a head at the beginning of n bytes, and changes them. Returns 0 where its end has not come (nothing is changed
 * then), 200 where it is read, or the status of a refusal with its sentence in `why`. used: its bytes. */
int vvi_head_read(vvi_head *out, const char **why, size_t *used, char *bytes, size_t n);
/** Whether a list of a header ("keep-alive, Upgrade") has a word, in whatever case. */
bool vvi_head_lists(const char *list, const char *word);
#endif
