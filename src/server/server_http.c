/* HTTP: the page, the exchange of the token, files that go. */
#include "core/json_text.h"
#include "core/memory.h"
#include "server/audit.h"
#include "server/server_impl.h"

#include <jansson.h>
#include <netdb.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>

enum { BODY_SECONDS = 5 }; /* in which a token must come */
enum { HERE_TEXT = 80 };

void vvi_http_note(const vvi_peer *peer, const char *what, const char *object, bool refused)
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
    const int fd = vvi_session_open_result(server->session, path + strlen("/files/"), &name);
    struct stat info;
    vvi_http_note(peer, "download", name, fd < 0);
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
    vvi_json_flaw flaw;
    json_t *body = vvi_json_decode(peer->http->body, peer->http->n_body, 0, &flaw);
    if (!body && flaw.fault == VVI_JSON_MEMORY) /* no wrong token */
        return vvi_answer_refusal(peer, HTTP_STATUS_SERVICE_UNAVAILABLE, "The server is short of memory; try again.\n");
    const char *token = json_string_value(json_object_get(body, "token"));
    /* who may send it was checked with its head */
    const vvi_request r = {.host = gate->host[0], .address = peer->address};
    const vvi_pass pass = vvi_gate_exchange(gate, &r, token ? token : "", vvi_now());
    json_decref(body);
    vvi_http_note(peer, "token", NULL, pass != VVI_PASS_ALL);
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
    vvi_http_note(peer, "end all", NULL, false);
    if (vvi_server_renew(peer->server) != VV_OK)
        return vvi_answer_refusal(peer, HTTP_STATUS_INTERNAL_SERVER_ERROR,
                                  "There are no random numbers for a new token.\n");
    return answer_cookie(peer);
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

/* The number and port by which it has come; "" for a Unix socket. */
static void write_here(char out[HERE_TEXT], const vvi_peer *peer)
{
    struct sockaddr_storage at = {.ss_family = AF_UNSPEC};
    socklen_t n = sizeof at;
    char number[NI_MAXHOST], port[NI_MAXSERV];
    *out = 0;
    if (getsockname(lws_get_socket_fd(peer->wsi), (struct sockaddr *)&at, &n) != 0 ||
        (at.ss_family != AF_INET && at.ss_family != AF_INET6) ||
        getnameinfo((struct sockaddr *)&at, n, number, sizeof number, port, sizeof port,
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0)
        return;
    const bool mapped = strncmp(number, "::ffff:", 7) == 0 && strchr(number, '.'); /* IPv4 by a socket of both */
    snprintf(out, HERE_TEXT, !mapped && at.ss_family == AF_INET6 ? "[%.60s]:%.8s" : "%.60s:%.8s",
             mapped ? number + 7 : number, port);
}

static vvi_pass check(const vvi_peer *peer, const vvi_head *head)
{
    char here[HERE_TEXT] = "";
    if (peer->server->options.listen)
        write_here(here, peer);
    const bool bearer = head->authorization && strncmp(head->authorization, "Bearer ", 7) == 0;
    vvi_request r = {.host = head->host,
                     .origin = head->origin,
                     .fetch_site = head->fetch_site,
                     .bearer = bearer ? head->authorization + 7 : NULL,
                     .cookie = head->cookie,
                     .address = peer->address,
                     .here = here};
    if (is_followed_link(head))
        r = (vvi_request){.host = r.host, .origin = r.origin, .address = r.address, .here = here};
    if (head->upgrade && !r.origin)
        r.cookie = NULL; /* a browser names its page with each upgrade; who is none has the token */
    return vvi_gate_check(&peer->server->gate, &r, vvi_now());
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
    if (puts && vvi_upload_begin(peer, head->path + strlen("/files/")) != 0)
        return -1;
    if (head->waits && head->length > 0 && peer->state == VVI_PEER_BODY && !vvi_answer_go_on(peer))
        return -1;
    if (puts)
        return 0;
    return head->length == 0 ? exchange(peer) : 0;
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
    if (pass == VVI_PASS_ALL)
        vvi_peer_let_in(peer);
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
    if (http->upload)
        return vvi_upload_take(peer, in, n);
    const size_t left = (size_t)http->length - http->n_body;
    n = n < left ? n : left;
    memcpy(http->body + http->n_body, in, n);
    http->n_body += n;
    return n == left ? exchange(peer) : 0;
}

void vvi_http_free(vvi_peer *peer)
{
    vvi_http *http = peer->http;
    if (!http)
        return;
    vvi_answer_clear(http);
    vvi_upload_drop(peer);
    free(http);
    peer->http = NULL;
}
