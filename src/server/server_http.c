/* HTTP: the page, the exchange of the token, files that come and go. */
#include "core/memory.h"
#include "server/audit.h"
#include "server/server_impl.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* UPLOADS: how many of the largest files that are taken, all those of a session together may weigh. */
enum { PIECE = 32768, HEAD_ROOM = 4096, UPLOADS = 4 };

/* Of everything that is answered. */
static const char *const headers[][2] = {
    {"content-security-policy:",
     "default-src 'self'; img-src 'self' blob: data:; object-src 'none'; base-uri 'none'; form-action 'none'; "
     "frame-ancestors 'none'; connect-src 'self'"},
    {"x-content-type-options:", "nosniff"},
    {"x-frame-options:", "DENY"},
    {"referrer-policy:", "no-referrer"},
    {"cross-origin-opener-policy:", "same-origin"},
    {"cross-origin-resource-policy:", "same-origin"},
    {"cache-control:", "no-store"},
};

static bool add(struct lws *wsi, const char *name, const char *value, unsigned char **at, unsigned char *end)
{
    return lws_add_http_header_by_name(wsi, (const unsigned char *)name, (const unsigned char *)value,
                                       (int)strlen(value), at, end) == 0;
}

/* Begins an answer of n bytes; -1 ends the connection. */
static int begin(struct lws *wsi, unsigned code, const char *type, size_t n, const char *extra, const char *value)
{
    unsigned char room[LWS_PRE + HEAD_ROOM], *at = room + LWS_PRE, *end = room + sizeof room - 1;
    bool fine = lws_add_http_header_status(wsi, code, &at, end) == 0;
    for (size_t i = 0; i < sizeof headers / sizeof *headers && fine; i++)
        fine = add(wsi, headers[i][0], headers[i][1], &at, end);
    if (fine && type)
        fine = add(wsi, "content-type:", type, &at, end);
    if (fine && extra)
        fine = add(wsi, extra, value, &at, end);
    if (fine)
        fine = lws_add_http_header_content_length(wsi, n, &at, end) == 0;
    return fine && lws_finalize_write_http_header(wsi, room + LWS_PRE, &at, end) == 0 ? 0 : -1;
}

static void release(vvi_http *http)
{
    free(http->owned);
    if (http->file)
        close(http->file);
    http->owned = NULL;
    http->bytes = NULL;
    http->file = 0;
}

/* What belongs to a request is not kept until the next one of its connection: then it may be lost. */
static int finish(struct lws *wsi, vvi_http *http)
{
    release(http);
    http->answered = true;
    return http->closes || lws_http_transaction_completed(wsi) ? -1 : 0;
}

static int answer_empty(struct lws *wsi, vvi_http *http, unsigned code, const char *extra, const char *value)
{
    return begin(wsi, code, NULL, 0, extra, value) != 0 ? -1 : finish(wsi, http);
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

static int send_piece(struct lws *wsi, vvi_http *http)
{
    unsigned char room[LWS_PRE + PIECE];
    const size_t n = http->n - http->at < PIECE ? http->n - http->at : PIECE;
    const bool last = http->at + n == http->n;
    if (n && http->bytes)
        memcpy(room + LWS_PRE, http->bytes + http->at, n);
    else if (n && !read_piece(room + LWS_PRE, n, http->file))
        return -1;
    http->at += n;
    if (lws_write(wsi, room + LWS_PRE, n, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < 0)
        return -1;
    if (!last)
        lws_callback_on_writable(wsi);
    return last ? finish(wsi, http) : 0;
}

static int answer_bytes(struct lws *wsi, vvi_http *http, unsigned code, const char *type, const void *bytes, size_t n)
{
    http->bytes = bytes;
    http->n = n;
    http->at = 0;
    if (begin(wsi, code, type, n, NULL, NULL) != 0)
        return -1;
    lws_callback_on_writable(wsi);
    return 0;
}

/* Another time: the server has as many connections as it can have. */
static int answer_later(struct lws *wsi, vvi_http *http)
{
    static const char sentence[] = "This server has too many connections; try again in a few seconds.\n";
    http->bytes = (const uint8_t *)sentence;
    http->n = strlen(sentence);
    http->at = 0;
    http->closes = true;
    if (begin(wsi, HTTP_STATUS_SERVICE_UNAVAILABLE, "text/plain; charset=utf-8", http->n, "retry-after:", "5") != 0)
        return -1;
    lws_callback_on_writable(wsi);
    return 0;
}

static int answer_text(struct lws *wsi, vvi_http *http, unsigned code, const char *type, char *text)
{
    free(http->owned);
    http->owned = (uint8_t *)text;
    return text ? answer_bytes(wsi, http, code, type, text, strlen(text)) : -1;
}

static int refuse(struct lws *wsi, vvi_http *http, unsigned code, const char *sentence)
{
    return answer_bytes(wsi, http, code, "text/plain; charset=utf-8", sentence, strlen(sentence));
}

static void note(struct lws *wsi, const char *what, const char *object, bool refused)
{
    char address[48] = "";
    lws_get_peer_simple(wsi, address, sizeof address);
    vvi_audit_note(vvi_session_audit(vvi_server_of(wsi)->session), (vvi_actor){.address = address}, what, object,
                   refused);
}

/* GET ------------------------------------------------------------------------------------------------------------- */

static int get_asset(struct lws *wsi, vvi_http *http, const char *path)
{
    if (strcmp(path, "/") == 0)
        path = "/index.html";
    for (const vvi_asset *a = vvi_assets; a->path; a++)
        if (strcmp(a->path, path) == 0)
            return answer_bytes(wsi, http, HTTP_STATUS_OK, a->type, a->bytes, a->n);
    if (!vvi_assets[0].path && strcmp(path, "/index.html") == 0)
        return refuse(wsi, http, HTTP_STATUS_OK,
                      "This VolVis was built without its page, because node and npm were missing.\n");
    return refuse(wsi, http, HTTP_STATUS_NOT_FOUND, "There is nothing here.\n");
}

static int get_file(struct lws *wsi, vvi_http *http, const char *path)
{
    const vvi_server *server = vvi_server_of(wsi);
    const char *name = NULL,
               *file = vvi_session_result(server->session, strtoll(path + strlen("/files/"), NULL, 10), &name);
    struct stat info;
    note(wsi, "download", name, !file);
    const int fd = file ? open(file, O_RDONLY | O_CLOEXEC | O_NOFOLLOW) : -1;
    if (fd <= 0)
        return refuse(wsi, http, HTTP_STATUS_NOT_FOUND, "This file no longer exists.\n");
    http->file = fd;
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode))
        return refuse(wsi, http, HTTP_STATUS_INTERNAL_SERVER_ERROR, "The file cannot be read.\n");
    return answer_bytes(wsi, http, HTTP_STATUS_OK, "application/octet-stream", NULL, (size_t)info.st_size);
}

/* POST /session --------------------------------------------------------------------------------------------------- */

static int exchange(struct lws *wsi, vvi_http *http)
{
    vvi_server *server = vvi_server_of(wsi);
    char address[64] = "", cookie[256];
    json_t *body = json_loadb(http->body, http->n_body, 0, NULL);
    const char *token = json_string_value(json_object_get(body, "token"));
    lws_get_peer_simple(wsi, address, sizeof address);
    /* who may send it was checked with its head */
    const vvi_request r = {.host = server->gate.host[0], .address = address};
    const vvi_pass pass = vvi_gate_exchange(&server->gate, &r, token ? token : "", vvi_now());
    json_decref(body);
    note(wsi, "token", NULL, pass != VVI_PASS_ALL);
    if (pass == VVI_PASS_SLOWER)
        return refuse(wsi, http, 429, "Too many wrong tokens; wait a second.\n");
    if (pass != VVI_PASS_ALL)
        return refuse(wsi, http, HTTP_STATUS_FORBIDDEN, "This is not the token that the server printed.\n");
    vvi_gate_cookie(cookie, &server->gate);
    return answer_empty(wsi, http, HTTP_STATUS_NO_CONTENT, "set-cookie:", cookie);
}

/* PUT /files/NAME ------------------------------------------------------------------------------------------------- */

static int begin_upload(struct lws *wsi, vvi_http *http, const char *path)
{
    vvi_server *server = vvi_server_of(wsi);
    const char *folder = vvi_session_uploads(server->session), *name = path + strlen("/files/");
    char length[32] = "";
    lws_hdr_copy(wsi, length, sizeof length, WSI_TOKEN_HTTP_CONTENT_LENGTH);
    if (!folder || server->options.session.read_only)
        return refuse(wsi, http, HTTP_STATUS_FORBIDDEN, "This server accepts no files.\n");
    if (!*name || strchr(name, '/') || *name == '.' || strlen(name) >= sizeof http->upload_name)
        return refuse(wsi, http, HTTP_STATUS_BAD_REQUEST, "A file needs a plain name of at most 127 letters.\n");
    const uint64_t promised = strtoull(length, NULL, 10), most = server->options.upload_most;
    if (!*length || promised > most)
        return refuse(wsi, http, HTTP_STATUS_REQ_ENTITY_TOO_LARGE,
                      "The file is larger than this server accepts; open it from a folder of the server.\n");
    if (promised + server->uploaded > UPLOADS * most)
        return refuse(wsi, http, HTTP_STATUS_REQ_ENTITY_TOO_LARGE,
                      "This server has accepted as many files as it may; open the file from a folder of the server.\n");
    note(wsi, "upload", name, false);
    snprintf(http->upload_name, sizeof http->upload_name, "%s", name);
    for (int i = 0; i < 1000; i++) {
        snprintf(http->upload_path, sizeof http->upload_path, i ? "%.3900s/%d-%s" : "%.3900s/%.0d%s", folder, i,
                 http->upload_name);
        http->upload = open(http->upload_path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
        if (http->upload > 0) {
            http->reserved = promised;
            server->uploaded += promised;
            return 0;
        }
        if (errno != EEXIST)
            break;
    }
    http->upload = 0;
    return refuse(wsi, http, HTTP_STATUS_INTERNAL_SERVER_ERROR, "The file cannot be stored on the server.\n");
}

static int take_upload(vvi_http *http, const uint8_t *in, size_t n)
{
    http->n_upload += n;
    if (http->n_upload > http->reserved)
        return -1;
    while (n > 0) {
        const ssize_t done = write(http->upload, in, n);
        if (done < 0 && errno != EINTR)
            return -1;
        in += done > 0 ? done : 0;
        n -= done > 0 ? (size_t)done : 0;
    }
    return 0;
}

static int end_upload(struct lws *wsi, vvi_http *http)
{
    if (http->n_upload != http->reserved)
        return -1;
    const int closed = close(http->upload);
    http->upload = 0;
    if (closed != 0) {
        unlink(http->upload_path);
        return -1;
    }
    json_t *value = json_pack("{s:s}", "path", http->upload_path);
    char *text = value ? json_dumps(value, 0) : NULL;
    json_decref(value);
    return answer_text(wsi, http, 201, "application/json", text);
}

/* Requests -------------------------------------------------------------------------------------------------------- */

static int begin_request(struct lws *wsi, vvi_http *http, const char *path)
{
    vvi_server *server = vvi_server_of(wsi);
    const vvi_pass pass = vvi_server_check(server, wsi);
    if (server->sockets > server->sockets_most / 8 * 7)
        return answer_later(wsi, http);
    if (pass == VVI_PASS_NONE)
        return refuse(wsi, http, HTTP_STATUS_FORBIDDEN, "This request does not come from VolVis's own page.\n");
    if (pass == VVI_PASS_SLOWER)
        return refuse(wsi, http, 429, "Too many wrong tokens; wait a second.\n");
    if (lws_hdr_total_length(wsi, WSI_TOKEN_HTTP_TRANSFER_ENCODING) > 0) {
        http->closes = true; /* nobody shall wonder where this request ends */
        return refuse(wsi, http, HTTP_STATUS_LENGTH_REQUIRED, "A body needs a Content-Length.\n");
    }
    if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) > 0) {
        const bool file = strncmp(path, "/files/", 7) == 0;
        if (file && pass != VVI_PASS_ALL)
            return refuse(wsi, http, HTTP_STATUS_FORBIDDEN, "Open the link that the server printed first.\n");
        return file ? get_file(wsi, http, path) : get_asset(wsi, http, path);
    }
    if (lws_hdr_total_length(wsi, WSI_TOKEN_POST_URI) > 0 && strcmp(path, "/session") == 0) {
        http->takes_session = true;
        return 0;
    }
    if (lws_hdr_total_length(wsi, WSI_TOKEN_PUT_URI) > 0 && strncmp(path, "/files/", 7) == 0)
        return pass == VVI_PASS_ALL
                   ? begin_upload(wsi, http, path)
                   : refuse(wsi, http, HTTP_STATUS_FORBIDDEN, "Open the link that the server printed first.\n");
    return refuse(wsi, http, HTTP_STATUS_METHOD_NOT_ALLOWED, "This server does not offer that.\n");
}

static int take_body(struct lws *wsi, vvi_http *http, const uint8_t *in, size_t n)
{
    if (http->upload)
        return take_upload(http, in, n);
    if (http->bytes || http->file || http->answered) { /* answered already: what was on its way is passed over */
        http->n_upload += n;
        return http->n_upload > VVI_MESSAGE_MOST ? -1 : 0;
    }
    if (!http->takes_session || http->n_body + n > VVI_BODY_MOST)
        return -1;
    if (n)
        memcpy(http->body + http->n_body, in, n);
    http->n_body += n;
    return 0;
}

/* Of the request before, on the same connection or on one that ends. */
static void forget(vvi_server *server, vvi_http *http)
{
    release(http);
    if (http->upload) { /* broken off */
        close(http->upload);
        unlink(http->upload_path);
        server->uploaded -= http->reserved;
    }
    *http = (vvi_http){.bytes = NULL};
}

int vvi_http_callback(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t n)
{
    vvi_http *http = user;
    switch (reason) {
    case LWS_CALLBACK_FILTER_NETWORK_CONNECTION:
        return vvi_server_of(wsi)->sockets < vvi_server_of(wsi)->sockets_most ? 0 : 1;
    case LWS_CALLBACK_WSI_CREATE:
        vvi_server_of(wsi)->sockets++;
        return 0;
    case LWS_CALLBACK_WSI_DESTROY:
        vvi_server_of(wsi)->sockets--;
        return 0;
    case LWS_CALLBACK_HTTP:
        forget(vvi_server_of(wsi), http);
        return begin_request(wsi, http, in);
    case LWS_CALLBACK_HTTP_BODY:
        return take_body(wsi, http, in, n);
    case LWS_CALLBACK_HTTP_BODY_COMPLETION:
        return http->upload ? end_upload(wsi, http) : http->takes_session ? exchange(wsi, http) : 0;
    case LWS_CALLBACK_HTTP_WRITEABLE:
        return http->bytes || http->file ? send_piece(wsi, http) : 0;
    case LWS_CALLBACK_CLOSED_HTTP:
        if (http)
            forget(vvi_server_of(wsi), http);
        return 0;
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
        return 1;                /* a WebSocket without the protocol volvis */
    case LWS_CALLBACK_RAW_ADOPT: /* CONNECT: the library keeps such connections, and no limit of time ends them */
    case LWS_CALLBACK_RAW_RX:
        return -1;
    default:
        return 0;
    }
}
