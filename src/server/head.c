#include "server/head.h"
#include "core/text.h"

#include <string.h>

enum {
    OK = 200,
    BAD = 400,
    NO_LENGTH = 411,
    NO_EXPECTATION = 417,
    TOO_LARGE = 431,
    NO_VERSION = 505,
    LENGTH_DIGITS = 15
};

typedef struct reader {
    vvi_head *head;
    const char *why;
} reader;

static int refuse(reader *r, int status, const char *why)
{
    r->why = why;
    return status;
}

static bool is_letter_or_digit(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

/* Letters of names and methods (RFC 9110, "token"). */
static bool is_token(char c)
{
    return is_letter_or_digit(c) || (c && strchr("!#$%&'*+-.^_`|~", c));
}

static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c + 'a' - 'A') : c;
}

static bool equal(const char *a, size_t n, const char *b)
{
    for (size_t i = 0; i < n; i++)
        if (lower(a[i]) != lower(b[i]) || !b[i])
            return false;
    return !b[n];
}

bool vvi_head_lists(const char *list, const char *word)
{
    while (list && *list) {
        list += strspn(list, " \t,");
        size_t n = strcspn(list, ",");
        const char *next = list + n;
        while (n > 0 && (list[n - 1] == ' ' || list[n - 1] == '\t'))
            n--;
        if (n > 0 && equal(list, n, word))
            return true;
        list = next;
    }
    return false;
}

/* The first line ------------------------------------------------------------------------------------------------- */

static int digit(char c)
{
    const char low = lower(c);
    return c >= '0' && c <= '9' ? c - '0' : low >= 'a' && low <= 'f' ? low - 'a' + 10 : -1;
}

static bool is_text(const char *s, size_t n)
{
    for (size_t i = 0; i < n;) {
        const size_t length = vvi_utf8_length(s + i);
        if (length == 0 || (unsigned char)s[i] < 0x20 || s[i] == 0x7f)
            return false;
        i += length;
    }
    return true;
}

/* In its place. */
static bool decode(char *path)
{
    char *out = path;
    for (const char *s = path; *s; s++, out++) {
        *out = *s;
        if (*s != '%')
            continue;
        const int high = digit(s[1]), low = high < 0 ? -1 : digit(s[2]);
        if (low < 0)
            return false;
        *out = (char)(high * 16 + low);
        s += 2;
    }
    *out = 0;
    return is_text(path, (size_t)(out - path));
}

static int read_target(reader *r, char *target)
{
    char *query = strchr(target, '?');
    r->head->has_query = query != NULL;
    if (query)
        *query = 0;
    r->head->path = target;
    return *target == '/' && decode(target) ? OK
                                            : refuse(r, BAD, "The place that this request names cannot be read.\n");
}

static vvi_method method_of(const char *word)
{
    static const struct {
        const char *word;
        vvi_method method;
    } rows[] = {
        {"GET", VVI_METHOD_GET}, {"POST", VVI_METHOD_POST}, {"PUT", VVI_METHOD_PUT}, {"DELETE", VVI_METHOD_DELETE}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (strcmp(rows[i].word, word) == 0)
            return rows[i].method;
    return VVI_METHOD_OTHER;
}

/* "GET /app.js HTTP/1.1" */
static int read_first(reader *r, char *line)
{
    char *target = strchr(line, ' '), *version = target ? strchr(target + 1, ' ') : NULL;
    if (!version || target == line)
        return refuse(r, BAD, "This is no request of HTTP/1.1.\n");
    *target++ = *version++ = 0;
    for (const char *s = line; *s; s++)
        if (!is_token(*s))
            return refuse(r, BAD, "This is no request of HTTP/1.1.\n");
    for (const char *s = target; *s; s++)
        if (*s <= ' ' || *s > '~' || *s == '#')
            return refuse(r, BAD, "The place that this request names cannot be read.\n");
    if (strcmp(version, "HTTP/1.1") != 0)
        return strncmp(version, "HTTP/", 5) == 0
                   ? refuse(r, NO_VERSION, "This server speaks no other version than HTTP 1.1.\n")
                   : refuse(r, BAD, "This is no request of HTTP/1.1.\n");
    r->head->method = method_of(line);
    r->head->without_body = strcmp(line, "HEAD") == 0;
    return read_target(r, target);
}

/* Headers -------------------------------------------------------------------------------------------------------- */

/* Where the value of a header is kept; NULL: nobody asks for it. */
static char **place_of(vvi_head *h, const char *name, size_t n)
{
    const struct {
        const char *name;
        char **place;
    } rows[] = {{"host", &h->host},
                {"origin", &h->origin},
                {"sec-fetch-site", &h->fetch_site},
                {"sec-fetch-mode", &h->fetch_mode},
                {"sec-fetch-dest", &h->fetch_dest},
                {"authorization", &h->authorization},
                {"cookie", &h->cookie},
                {"connection", &h->connection},
                {"upgrade", &h->upgrade},
                {"sec-websocket-key", &h->socket_key},
                {"sec-websocket-version", &h->socket_version},
                {"sec-websocket-protocol", &h->socket_protocols},
                {"content-length", &h->length_text},
                {"transfer-encoding", &h->coding},
                {"expect", &h->expect}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (equal(name, n, rows[i].name))
            return rows[i].place;
    return NULL;
}

/* No blanks before the colon, no line that goes on with the one before: both are read in more than one way. */
static int read_header(reader *r, char *line)
{
    size_t n = 0;
    while (is_token(line[n]))
        n++;
    if (n == 0 || line[n] != ':')
        return refuse(r, BAD, "A header of this request cannot be read.\n");
    char *value = line + n + 1 + strspn(line + n + 1, " \t"), *end = value + strlen(value);
    while (end > value && (end[-1] == ' ' || end[-1] == '\t'))
        *--end = 0;
    for (const char *s = value; *s; s++)
        if (((unsigned char)*s < ' ' && *s != '\t') || *s == 0x7f)
            return refuse(r, BAD, "A header of this request cannot be read.\n");
    char **place = place_of(r->head, line, n);
    if (place && *place)
        return refuse(r, BAD, "A header of this request is there twice.\n");
    if (place)
        *place = value;
    return OK;
}

/* What names a machine and its port (RFC 9112, 3.2); whether it is this one is for others to say. */
static int read_host(reader *r)
{
    static const char signs[] = "-._~!$&'()*+,;=%:[]";
    const char *host = r->head->host;
    if (!host)
        return refuse(r, BAD, "This request does not say which host it is for.\n");
    for (; *host; host++)
        if (!is_letter_or_digit(*host) && !strchr(signs, *host))
            return refuse(r, BAD, "The host that this request is for cannot be read.\n");
    return OK;
}

static int read_expectation(reader *r)
{
    vvi_head *h = r->head;
    if (!h->expect)
        return OK;
    h->waits = equal(h->expect, strlen(h->expect), "100-continue");
    return h->waits ? OK : refuse(r, NO_EXPECTATION, "This server does not do what this request expects.\n");
}

static int read_length(reader *r)
{
    vvi_head *h = r->head;
    if (h->coding)
        return h->length_text ? refuse(r, BAD, "This request has two lengths.\n")
                              : refuse(r, NO_LENGTH, "A body needs a Content-Length.\n");
    if (!h->length_text)
        return OK;
    const size_t n = strlen(h->length_text);
    if (n == 0 || n > LENGTH_DIGITS || strspn(h->length_text, "0123456789") != n)
        return refuse(r, BAD, "The Content-Length of this request is no number of bytes.\n");
    for (size_t i = 0; i < n; i++)
        h->length = 10 * h->length + (uint64_t)(h->length_text[i] - '0');
    h->has_length = true;
    return OK;
}

/* Lines end by CR LF, and neither is anywhere else; no byte is 0. Ends the lines by 0. */
static int read_lines(reader *r, char *bytes, size_t n)
{
    int n_lines = 0, status = OK;
    for (char *line = bytes, *end = bytes + n; line < end && status == OK; n_lines++) {
        char *stop = memchr(line, '\r', (size_t)(end - line));
        if (!stop || stop[1] != '\n' || memchr(line, '\n', (size_t)(stop - line)) ||
            memchr(line, 0, (size_t)(stop - line)))
            return refuse(r, BAD, "The lines of this request cannot be told apart.\n");
        *stop = 0;
        if (stop - line > VVI_HEAD_LINE || n_lines > VVI_HEAD_LINES)
            return refuse(r, TOO_LARGE, "The head of this request is too large.\n");
        status = n_lines == 0 ? read_first(r, line) : read_header(r, line);
        line = stop + 2;
    }
    return status;
}

/* The end of a head in n bytes; NULL: it has not come. Lines that no end will make right are refused at once. */
static const char *find_end(reader *r, int *status, const char *bytes, size_t n)
{
    const char *at = bytes;
    *status = n == 0 || is_token(*bytes) ? 0 : refuse(r, BAD, "This is no request of HTTP/1.1.\n");
    while (*status == 0 && (at = memchr(at, '\n', (size_t)(bytes + n - at)))) {
        if (at == bytes || at[-1] != '\r')
            *status = refuse(r, BAD, "The lines of this request cannot be told apart.\n");
        if (at - bytes >= 3 && memcmp(at - 3, "\r\n\r\n", 4) == 0)
            return at + 1;
        at++;
    }
    return NULL;
}

int vvi_head_read(vvi_head *out, const char **why, size_t *used, char *bytes, size_t n)
{
    reader r = {.head = out};
    *out = (vvi_head){.path = NULL};
    int status;
    const size_t most = n < VVI_HEAD_MOST ? n : VVI_HEAD_MOST;
    const char *end = find_end(&r, &status, bytes, most);
    if (end && status == 0)
        status = read_lines(&r, bytes, (size_t)(end - bytes) - 2);
    else if (status == 0 && most == VVI_HEAD_MOST)
        status = refuse(&r, TOO_LARGE, "The head of this request is too large.\n");
    *used = end ? (size_t)(end - bytes) : 0;
    if (status == OK)
        status = read_host(&r);
    if (status == OK)
        status = read_length(&r);
    if (status == OK)
        status = read_expectation(&r);
    *why = r.why;
    return status;
}
