/* Answers to requests: heads, and what follows them in pieces. */
#include "core/memory.h"
#include "core/text.h"
#include "server/server_impl.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ANSWER_SECONDS: in which the first piece must leave. */
enum { PIECE = 65536, ANSWER_SECONDS = 20 };

/* Of everything that is answered. */
static const char *const headers[][2] = {
    {"content-security-policy",
     "default-src 'self'; img-src 'self' blob: data:; object-src 'none'; base-uri 'none'; form-action 'none'; "
     "frame-ancestors 'none'; connect-src 'self'"},
    {"x-content-type-options", "nosniff"},
    {"x-frame-options", "DENY"},
    {"referrer-policy", "no-referrer"},
    {"cross-origin-opener-policy", "same-origin"},
    {"cross-origin-resource-policy", "same-origin"},
    {"cache-control", "no-store"},
    {"connection", "close"},
};

static const char *reason_of(int status)
{
    static const struct {
        int status;
        const char *reason;
    } rows[] = {{200, "OK"},
                {201, "Created"},
                {204, "No Content"},
                {400, "Bad Request"},
                {403, "Forbidden"},
                {404, "Not Found"},
                {405, "Method Not Allowed"},
                {411, "Length Required"},
                {413, "Content Too Large"},
                {417, "Expectation Failed"},
                {426, "Upgrade Required"},
                {429, "Too Many Requests"},
                {431, "Request Header Fields Too Large"},
                {500, "Internal Server Error"},
                {503, "Service Unavailable"},
                {505, "HTTP Version Not Supported"},
                {507, "Insufficient Storage"}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (rows[i].status == status)
            return rows[i].reason;
    return "Refused";
}

static void add(vvi_text *text, const char *name, const char *value)
{
    if (value)
        vvi_text_printf(text, "%s: %s\r\n", name, value);
}

/* Begins an answer of http->n bytes; few of them leave with its head. */
static int begin(vvi_peer *peer, int status, const char *type, const char *extra, const char *value)
{
    vvi_text text = {0};
    vvi_text_printf(&text, "HTTP/1.1 %d %s\r\n", status, reason_of(status));
    for (size_t i = 0; i < sizeof headers / sizeof *headers; i++)
        add(&text, headers[i][0], headers[i][1]);
    if (peer->http->secure_name)
        add(&text, "strict-transport-security", "max-age=31536000");
    add(&text, "content-type", type);
    add(&text, extra, value);
    if (status != HTTP_STATUS_NO_CONTENT)
        vvi_text_printf(&text, "content-length: %zu\r\n", peer->http->n);
    vvi_text_add(&text, "\r\n");
    char *head = vvi_text_take(&text);
    vvi_http *http = peer->http;
    const bool is_short = http->bytes && !http->without_body && http->n <= PIECE;
    http->at = is_short ? http->n : 0;
    const bool fine = head && vvi_peer_put(peer, head, strlen(head), http->bytes, http->at);
    free(head);
    peer->state = VVI_PEER_ANSWER;
    vvi_peer_expects(peer, ANSWER_SECONDS);
    return fine ? 0 : -1;
}

void vvi_answer_clear(vvi_http *http)
{
    free(http->owned);
    if (http->file)
        close(http->file);
    http->owned = NULL;
    http->bytes = NULL;
    http->file = 0;
    http->n = http->at = 0;
}

int vvi_answer_empty(vvi_peer *peer, int status, const char *extra, const char *value)
{
    vvi_answer_clear(peer->http);
    return begin(peer, status, NULL, extra, value);
}

static bool read_piece(uint8_t *out, size_t n, int fd)
{
    while (n > 0) {
        const ssize_t done = read(fd, out, n);
        if (done == 0 || (done < 0 && errno != EINTR))
            return false;
        out += done > 0 ? done : 0;
        n -= done > 0 ? (size_t)done : 0;
    }
    return true;
}

static size_t left_of(const vvi_http *http)
{
    return http->without_body ? 0 : http->n - http->at;
}

bool vvi_answer_has_left(const vvi_peer *peer)
{
    return !peer->out && left_of(peer->http) == 0 && !lws_partial_buffered(peer->wsi);
}

int vvi_answer_next(vvi_peer *peer, bool *done)
{
    vvi_http *http = peer->http;
    const size_t left = left_of(http), n = left < PIECE ? left : PIECE;
    uint8_t room[PIECE];
    *done = n == 0;
    if (n == 0)
        return 0;
    if (!http->bytes && !read_piece(room, n, http->file))
        return -1;
    const bool fine = vvi_peer_put(peer, http->bytes ? http->bytes + http->at : room, n, NULL, 0);
    http->at += n;
    return fine ? 0 : -1;
}

int vvi_answer_bytes(vvi_peer *peer, int status, const char *type, const void *bytes, size_t n)
{
    peer->http->bytes = bytes;
    peer->http->n = n;
    return begin(peer, status, type, NULL, NULL);
}

bool vvi_answer_go_on(vvi_peer *peer)
{
    static const char line[] = "HTTP/1.1 100 Continue\r\n\r\n";
    return vvi_peer_put(peer, line, strlen(line), NULL, 0);
}

int vvi_answer_later(vvi_peer *peer)
{
    static const char sentence[] = "This server has too many connections; try again in a few seconds.\n";
    peer->http->bytes = (const uint8_t *)sentence;
    peer->http->n = strlen(sentence);
    return begin(peer, HTTP_STATUS_SERVICE_UNAVAILABLE, "text/plain; charset=utf-8", "retry-after", "5");
}

int vvi_answer_text(vvi_peer *peer, int status, const char *type, char *text)
{
    free(peer->http->owned);
    peer->http->owned = (uint8_t *)text;
    return text ? vvi_answer_bytes(peer, status, type, text, strlen(text)) : -1;
}

int vvi_answer_refusal(vvi_peer *peer, int status, const char *sentence)
{
    return vvi_answer_bytes(peer, status, "text/plain; charset=utf-8", sentence, strlen(sentence));
}
