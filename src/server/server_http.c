/* HTTP: the page, the exchange of the token, files that come and go. */
#include "core/memory.h"
#include "server/audit.h"
#include "server/server_impl.h"

#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* UPLOADS: how many of the largest files that are taken, all those of a session together may weigh. */
enum { UPLOADS = 4, BATCH_LEAST = 16, BATCH_MOST = 64 };
/* Seconds in which a body must come that is short, and 64 KiB of one that is long: who trickles is ended. */
enum { BODY_SECONDS = 5, UPLOAD_SECONDS = 20, UPLOAD_WINDOW = 65536 };

static void note(const vvi_peer *peer, const char *what, const char *object, bool refused)
{
    vvi_audit_note(vvi_session_audit(peer->server->session), (vvi_actor){.address = peer->address}, what, object,
                   refused);
}

/* GET ------------------------------------------------------------------------------------------------------------- */

static int get_asset(vvi_peer *peer, const char *path)
{
    if (strcmp(path, "/") == 0)
        path = "/index.html";
    for (const vvi_asset *a = vvi_assets; a->path; a++)
        if (strcmp(a->path, path) == 0)
            return vvi_answer_bytes(peer, HTTP_STATUS_OK, a->type, a->bytes, a->n);
    if (!vvi_assets[0].path && strcmp(path, "/index.html") == 0)
        return vvi_answer_refusal(peer, HTTP_STATUS_OK,
                                  "This VolVis was built without its page, because node and npm were missing.\n");
    return vvi_answer_refusal(peer, HTTP_STATUS_NOT_FOUND, "There is nothing here.\n");
}

static int get_file(vvi_peer *peer, const char *path)
{
    const vvi_server *server = peer->server;
    const char *name = NULL;
    const int fd = vvi_session_open_result(server->session, strtoll(path + strlen("/files/"), NULL, 10), &name);
    struct stat info;
    note(peer, "download", name, fd < 0);
    if (fd <= 0)
        return vvi_answer_refusal(peer, HTTP_STATUS_NOT_FOUND, "This file no longer exists.\n");
    peer->http->file = fd;
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode))
        return vvi_answer_refusal(peer, HTTP_STATUS_INTERNAL_SERVER_ERROR, "The file cannot be read.\n");
    return vvi_answer_bytes(peer, HTTP_STATUS_OK, "application/octet-stream", NULL, (size_t)info.st_size);
}

/* POST /session --------------------------------------------------------------------------------------------------- */

static int answer_cookie(vvi_peer *peer)
{
    char cookie[256];
    vvi_gate_cookie(cookie, &peer->server->gate);
    return vvi_answer_empty(peer, HTTP_STATUS_NO_CONTENT, "set-cookie", cookie);
}

static int exchange(vvi_peer *peer)
{
    vvi_gate *gate = &peer->server->gate;
    const bool launches = *gate->launch;
    json_t *body = json_loadb(peer->http->body, peer->http->n_body, 0, NULL);
    const char *token = json_string_value(json_object_get(body, "token"));
    /* who may send it was checked with its head */
    const vvi_request r = {.host = gate->host[0], .address = peer->address};
    const vvi_pass pass = vvi_gate_exchange(gate, &r, token ? token : "", vvi_now());
    json_decref(body);
    note(peer, "token", NULL, pass != VVI_PASS_ALL);
    if (launches && !*gate->launch)
        vvi_server_forget_launch(peer->server);
    if (pass == VVI_PASS_SLOWER)
        return vvi_answer_refusal(peer, 429, "Too many wrong tokens; wait a second.\n");
    if (pass != VVI_PASS_ALL)
        return vvi_answer_refusal(peer, HTTP_STATUS_FORBIDDEN, "This is not the token that the server printed.\n");
    return answer_cookie(peer);
}

/* DELETE /session: everybody has to come again with the link that is printed now, but who asked. Those who may but look
 * cannot send others away. */
static int end_all(vvi_peer *peer)
{
    if (peer->server->options.session.read_only)
        return vvi_answer_refusal(peer, HTTP_STATUS_FORBIDDEN,
                                  "This server is read-only: start it anew for another link.\n");
    note(peer, "end all", NULL, false);
    if (vvi_server_renew(peer->server) != VV_OK)
        return vvi_answer_refusal(peer, HTTP_STATUS_INTERNAL_SERVER_ERROR,
                                  "There are no random numbers for a new token.\n");
    return answer_cookie(peer);
}

/* PUT /files/NAME ------------------------------------------------------------------------------------------------- */

/* What files that come together have before their name: a word of 16 letters and digits or more, which the page made
 * up. The name behind it. */
static const char *take_batch(char out[BATCH_MOST + 1], const char *name)
{
    static const char letters[] = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    const size_t n = strspn(name, letters);
    if (n < BATCH_LEAST || n > BATCH_MOST || name[n] != '/')
        return name;
    memcpy(out, name, n);
    out[n] = 0;
    return name + n + 1;
}

/* A name that no other file has, for a new file or for one that has none; false: errno says why not. */
static bool name_upload(vvi_http *http)
{
    char own[32];
    snprintf(own, sizeof own, "/proc/self/fd/%d", http->upload);
    for (int i = 0; i < 1000; i++) {
        snprintf(http->upload_path, sizeof http->upload_path, i ? "%.3900s/%d-%s" : "%.3900s/%.0d%s",
                 http->upload_folder, i, http->upload_name);
        if (http->nameless && linkat(AT_FDCWD, own, AT_FDCWD, http->upload_path, AT_SYMLINK_FOLLOW) == 0)
            return true;
        if (!http->nameless)
            http->upload = open(http->upload_path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
        if (!http->nameless && http->upload > 0)
            return true;
        if (errno != EEXIST)
            return false;
    }
    return false;
}

/* The folder goes where nothing is in it. */
static void leave_folder(vvi_http *http)
{
    if (http->upload_folder)
        rmdir(http->upload_folder);
    free(http->upload_folder);
    http->upload_folder = NULL;
}

/* Without a name until all of it is there, so that nothing is left of it when the program is killed; where the file
 * system has no such files, with one. */
static bool open_upload(vvi_http *http, vvi_session *session, const char *batch)
{
    if (vvi_session_upload_folder(&http->upload_folder, session, batch) != VV_OK)
        return false;
    http->upload = open(http->upload_folder, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
    http->nameless = http->upload > 0;
    if (http->nameless || name_upload(http))
        return true;
    http->upload = 0;
    leave_folder(http);
    return false;
}

static int begin_upload(vvi_peer *peer, const char *path)
{
    vvi_server *server = peer->server;
    const char *name = path + strlen("/files/");
    char batch[BATCH_MOST + 1] = "";
    vvi_http *http = peer->http;
    if (!vvi_session_uploads(server->session) || server->options.session.read_only)
        return vvi_answer_refusal(peer, HTTP_STATUS_FORBIDDEN, "This server accepts no files.\n");
    name = take_batch(batch, name);
    if (!*name || strchr(name, '/') || *name == '.' || strlen(name) >= sizeof http->upload_name)
        return vvi_answer_refusal(peer, HTTP_STATUS_BAD_REQUEST, "A file needs a plain name of at most 127 letters.\n");
    const uint64_t promised = http->length, most = server->options.upload_most;
    if (promised > most)
        return vvi_answer_refusal(
            peer, HTTP_STATUS_REQ_ENTITY_TOO_LARGE,
            "The file is larger than this server accepts; open it from a folder of the server.\n");
    if (promised + server->uploaded > UPLOADS * most)
        return vvi_answer_refusal(
            peer, HTTP_STATUS_REQ_ENTITY_TOO_LARGE,
            "This server has accepted as many files as it may; open the file from a folder of the server.\n");
    if (vvi_session_promise(server->session, promised, true) != VV_OK)
        return vvi_answer_refusal(
            peer, HTTP_STATUS_REQ_ENTITY_TOO_LARGE,
            "There is no room for the file beside the results and files that are there; open it from a folder of the "
            "server.\n");
    note(peer, "upload", name, false);
    snprintf(http->upload_name, sizeof http->upload_name, "%s", name);
    if (!open_upload(http, server->session, batch)) {
        vvi_session_promise(server->session, promised, false);
        return vvi_answer_refusal(peer, HTTP_STATUS_INTERNAL_SERVER_ERROR,
                                  "The file cannot be stored on the server.\n");
    }
    vvi_peer_ration(peer, vvi_now());
    http->reserved = promised;
    server->uploaded += promised;
    vvi_peer_expects(peer, UPLOAD_SECONDS);
    return 0;
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

static int end_upload(vvi_peer *peer)
{
    vvi_http *http = peer->http;
    if (http->n_upload != http->reserved)
        return -1;
    if (http->nameless && !name_upload(http))
        return -1;
    const int closed = close(http->upload);
    http->upload = 0;
    vvi_session_promise(peer->server->session, http->reserved, false); /* it is there */
    if (closed != 0) {
        vvi_files_remove(http->upload_path);
        return -1;
    }
    json_t *value = json_pack("{s:s}", "path", http->upload_path);
    char *text = value ? json_dumps(value, 0) : NULL;
    json_decref(value);
    return vvi_answer_text(peer, 201, "application/json", text);
}

/* Requests -------------------------------------------------------------------------------------------------------- */

static bool is_text(const char *text, const char *expected)
{
    return text && strcmp(text, expected) == 0;
}

/* Somebody has clicked on a link to this server, in a mail or a file: the empty page comes, and that cookies and tokens
 * were sent along counts for nothing. */
static bool is_followed_link(const vvi_head *head)
{
    return head->method == VVI_METHOD_GET && strcmp(head->path, "/") == 0 && is_text(head->fetch_mode, "navigate") &&
           is_text(head->fetch_dest, "document") && !head->upgrade;
}

static vvi_pass check(const vvi_peer *peer, const vvi_head *head)
{
    const bool bearer = head->authorization && strncmp(head->authorization, "Bearer ", 7) == 0;
    vvi_request r = {.host = head->host,
                     .origin = head->origin,
                     .fetch_site = head->fetch_site,
                     .bearer = bearer ? head->authorization + 7 : NULL,
                     .cookie = head->cookie,
                     .address = peer->address};
    if (is_followed_link(head))
        r = (vvi_request){.host = r.host, .origin = r.origin, .address = r.address};
    const vvi_pass pass = vvi_gate_check(&peer->server->gate, &r, vvi_now());
    /* a browser names its page with each upgrade; who is none has the token */
    return pass == VVI_PASS_ALL && head->upgrade && !r.origin && !r.bearer ? VVI_PASS_NONE : pass;
}

static int end_body(vvi_peer *peer)
{
    return peer->http->upload ? end_upload(peer) : exchange(peer);
}

/* Of one that may pass. */
static int begin_place(vvi_peer *peer, const vvi_head *head, vvi_pass pass)
{
    static const char first[] = "Open the link that the server printed first.\n";
    const bool file = strncmp(head->path, "/files/", 7) == 0, session = strcmp(head->path, "/session") == 0;
    const bool puts = head->method == VVI_METHOD_PUT && file, posts = head->method == VVI_METHOD_POST && session;
    if (head->method == VVI_METHOD_GET && head->length > 0)
        return vvi_answer_refusal(peer, HTTP_STATUS_BAD_REQUEST, "A GET request has no body.\n");
    if (pass != VVI_PASS_ALL && (file || (session && !posts)))
        return vvi_answer_refusal(peer, HTTP_STATUS_FORBIDDEN, first);
    if (head->method == VVI_METHOD_GET)
        return file ? get_file(peer, head->path) : get_asset(peer, head->path);
    if (head->method == VVI_METHOD_DELETE && session)
        return end_all(peer);
    if (!puts && !posts)
        return vvi_answer_refusal(peer, HTTP_STATUS_METHOD_NOT_ALLOWED, "This server does not offer that.\n");
    if (!head->has_length)
        return vvi_answer_refusal(peer, HTTP_STATUS_LENGTH_REQUIRED, "A body needs a Content-Length.\n");
    if (posts && head->length > VVI_BODY_MOST)
        return vvi_answer_refusal(peer, HTTP_STATUS_REQ_ENTITY_TOO_LARGE, "This is longer than a token may be.\n");
    peer->state = VVI_PEER_BODY;
    peer->http->length = head->length;
    vvi_peer_expects(peer, BODY_SECONDS);
    if (puts && begin_upload(peer, head->path) != 0)
        return -1;
    return peer->state == VVI_PEER_BODY && head->length == 0 ? end_body(peer) : 0;
}

int vvi_http_begin(vvi_peer *peer, const vvi_head *head, int status, const char *why)
{
    const vvi_server *server = peer->server;
    if (!(peer->http = vvi_calloc(1, sizeof *peer->http)))
        return -1;
    peer->http->without_body = head->without_body;
    if (status != HTTP_STATUS_OK)
        return vvi_answer_refusal(peer, status, why);
    peer->http->secure_name = server->options.certificate && head->host && !vvi_gate_is_loopback(head->host);
    const vvi_pass pass = check(peer, head);
    if (server->sockets > server->sockets_most / 8 * 7)
        return vvi_answer_later(peer);
    if (pass == VVI_PASS_NONE)
        return vvi_answer_refusal(peer, HTTP_STATUS_FORBIDDEN, "This request does not come from VolVis's own page.\n");
    if (pass == VVI_PASS_SLOWER)
        return vvi_answer_refusal(peer, 429, "Too many wrong tokens; wait a second.\n");
    if (!head->upgrade && strcmp(head->path, "/ws") != 0)
        return begin_place(peer, head, pass);
    if (pass != VVI_PASS_ALL)
        return vvi_answer_refusal(peer, HTTP_STATUS_FORBIDDEN, "Open the link that the server printed first.\n");
    status = vvi_socket_check(&why, head);
    return status == HTTP_STATUS_OK ? vvi_socket_begin(peer, head) : vvi_answer_refusal(peer, status, why);
}

/* What comes behind the body is nobody's: the answer ends the connection. */
int vvi_http_take(vvi_peer *peer, const uint8_t *in, size_t n)
{
    vvi_http *http = peer->http;
    const uint64_t came = http->upload ? http->n_upload : http->n_body, left = http->length - came;
    n = n < left ? n : (size_t)left;
    if (http->upload && take_upload(http, in, n) != 0)
        return -1;
    if (!http->upload) {
        memcpy(http->body + http->n_body, in, n);
        http->n_body += n;
    } else if ((http->window += n) >= UPLOAD_WINDOW) {
        http->window = 0;
        vvi_peer_expects(peer, UPLOAD_SECONDS);
    }
    return n == left ? end_body(peer) : 0;
}

void vvi_http_free(vvi_peer *peer)
{
    vvi_http *http = peer->http;
    if (!http)
        return;
    vvi_answer_clear(http);
    if (http->upload) { /* broken off */
        close(http->upload);
        if (!http->nameless)
            unlink(http->upload_path);
        peer->server->uploaded -= http->reserved;
        vvi_session_promise(peer->server->session, http->reserved, false);
    }
    leave_folder(http);
    free(http);
    peer->http = NULL;
}
