/* The port, and the loop. */
#include "core/memory.h"
#include "server/server_impl.h"
#include "server/unix_socket.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

enum { THREADS = 1, HEADER_BYTES = 8192, HEADER_SECONDS = 5, IDLE_SECONDS = 60, CONNECTIONS = 4096, OTHER_FILES = 256 };

vvi_server *vvi_server_of(struct lws *wsi)
{
    return lws_context_user(lws_get_context(wsi));
}

/* Requests -------------------------------------------------------------------------------------------------------- */

static const char *header(struct lws *wsi, enum lws_token_indexes which, char *room, size_t n)
{
    const int length = lws_hdr_total_length(wsi, which);
    return length > 0 && (size_t)length < n && lws_hdr_copy(wsi, room, (int)n, which) >= 0 ? room : NULL;
}

static const char *custom(struct lws *wsi, const char *name, char *room, size_t n)
{
    const int length = lws_hdr_custom_length(wsi, name, (int)strlen(name));
    return length > 0 && (size_t)length < n && lws_hdr_custom_copy(wsi, room, (int)n, name, (int)strlen(name)) >= 0
               ? room
               : NULL;
}

vvi_pass vvi_server_check(vvi_server *server, struct lws *wsi)
{
    char host[300], origin[300], site[64], authorization[256], cookie[4096], address[64] = "";
    vvi_request r = {.host = header(wsi, WSI_TOKEN_HOST, host, sizeof host),
                     .origin = header(wsi, WSI_TOKEN_ORIGIN, origin, sizeof origin),
                     .fetch_site = custom(wsi, "sec-fetch-site:", site, sizeof site),
                     .cookie = header(wsi, WSI_TOKEN_HTTP_COOKIE, cookie, sizeof cookie),
                     .address = address};
    const char *bearer = header(wsi, WSI_TOKEN_HTTP_AUTHORIZATION, authorization, sizeof authorization);
    if (bearer && strncmp(bearer, "Bearer ", 7) == 0)
        r.bearer = bearer + 7;
    lws_get_peer_simple(wsi, address, sizeof address);
    return vvi_gate_check(&server->gate, &r, vvi_now());
}

/* The loop -------------------------------------------------------------------------------------------------------- */

static void wake(void *user)
{
    vvi_server *server = user;
    pthread_mutex_lock(&server->waking);
    if (!server->gone)
        lws_cancel_service(server->context);
    pthread_mutex_unlock(&server->waking);
}

static void tick(lws_sorted_usec_list_t *due);

static void go_round(vvi_server *server)
{
    const int64_t now = vvi_now(), wait = vvi_session_tick(server->session, now);
    for (vvi_client *c = vvi_session_client(server->session, NULL); c; c = vvi_session_client(server->session, c)) {
        struct lws *wsi = vvi_client_user(c);
        const char *why = vvi_client_stuck(c, now);
        if (why)
            vvi_socket_end(wsi, why);
        else if (vvi_client_has_more(c, now))
            lws_callback_on_writable(wsi);
    }
    const int64_t most = INT64_C(1000000000);
    lws_sul_schedule(server->context, 0, &server->due, tick, (wait < most ? wait : most) / 1000 + 1000);
}

static void tick(lws_sorted_usec_list_t *due)
{
    vvi_server *server = lws_container_of(due, vvi_server, due);
    vvi_session_serve(server->session);
    go_round(server);
}

static int serve_protocol(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t n)
{
    if (reason == LWS_CALLBACK_EVENT_WAIT_CANCELLED) {
        vvi_server *server = vvi_server_of(wsi);
        if (server->session) {
            vvi_session_serve(server->session);
            go_round(server);
        }
        return 0;
    }
    return vvi_http_callback(wsi, reason, user, in, n);
}

static int serve_socket(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t n)
{
    const int result = vvi_socket_callback(wsi, reason, user, in, n);
    if (reason == LWS_CALLBACK_RECEIVE && result == 0)
        go_round(vvi_server_of(wsi));
    return result;
}

static const struct lws_protocols protocols[] = {
    {.name = "http", .callback = serve_protocol, .per_session_data_size = sizeof(vvi_http), .rx_buffer_size = 16384},
    {.name = "volvis", .callback = serve_socket, .per_session_data_size = sizeof(vvi_socket), .rx_buffer_size = 8192},
    {0},
};

/* Life ------------------------------------------------------------------------------------------------------------ */

/* Connections that there may be; some files more are open then. */
static int sockets_most(void)
{
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0)
        return CONNECTIONS / 8;
    if (limit.rlim_cur < CONNECTIONS + OTHER_FILES) {
        limit.rlim_cur = limit.rlim_max < CONNECTIONS + OTHER_FILES ? limit.rlim_max : CONNECTIONS + OTHER_FILES;
        setrlimit(RLIMIT_NOFILE, &limit);
    }
    const rlim_t n = limit.rlim_cur > 2 * OTHER_FILES ? limit.rlim_cur - OTHER_FILES : limit.rlim_cur / 2;
    return n < CONNECTIONS ? (int)n : CONNECTIONS;
}

enum { NEAR_PORT = 8080 }; /* of a tunnel to a Unix socket */

/* A Unix socket is made for its owner alone: no moment passes in which others could reach it. */
static struct lws_vhost *listen_there(vvi_server *server, const struct lws_context_creation_info *info)
{
    const bool is_file = server->options.socket != NULL;
    const mode_t before = is_file ? umask(0177) : 0;
    struct lws_vhost *vhost = lws_create_vhost(server->context, info);
    if (is_file) {
        umask(before);
        server->has_socket = vhost && chmod(server->options.socket, 0600) == 0;
    }
    return is_file && !server->has_socket ? NULL : vhost;
}

static vv_status check_readable(const char *path, const char *what)
{
    return !path || access(path, R_OK) == 0
               ? VV_OK
               : vv_fail_at(VV_E_READ, path, NULL, "the %s cannot be read: %s", what, strerror(errno));
}

vv_status vvi_server_options_check(const vvi_server_options *o)
{
    vv_status st = o->token ? vvi_token_check(o->token) : VV_OK;
    if (st == VV_OK)
        st = check_readable(o->certificate, "certificate");
    if (st == VV_OK)
        st = check_readable(o->key, "certificate's key");
    return st == VV_OK && o->socket ? vvi_unix_socket_check(o->socket) : st;
}

static vv_status open_port(vvi_server *server)
{
    const vvi_server_options *o = &server->options;
    struct lws_context_creation_info info = {0};
    vv_status st = vvi_server_options_check(o);
    if (st == VV_OK && o->socket)
        st = vvi_unix_socket_prepare(o->socket);
    if (st != VV_OK)
        return st;
    lws_set_log_level(0, NULL);
    server->sockets_most = sockets_most();
    info.port = o->port ? o->port : 0;
    info.iface = o->listen ? o->listen : "127.0.0.1";
    info.protocols = protocols;
    info.user = server;
    info.gid = info.uid = (gid_t)-1;
    info.max_http_header_data = HEADER_BYTES;
    info.timeout_secs = HEADER_SECONDS;
    info.keepalive_timeout = IDLE_SECONDS;
    info.fd_limit_per_thread = CONNECTIONS;
    info.vhost_name = "volvis";
    info.options = LWS_SERVER_OPTION_DISABLE_IPV6 | LWS_SERVER_OPTION_EXPLICIT_VHOSTS;
    info.alpn = "http/1.1"; /* the checks of requests are of its headers */
    if (o->socket) {
        info.options |= LWS_SERVER_OPTION_UNIX_SOCK;
        info.port = 0;
        info.iface = o->socket;
    }
    if (o->certificate) {
        info.options |= LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT;
        info.ssl_cert_filepath = o->certificate;
        info.ssl_private_key_filepath = o->key ? o->key : o->certificate;
    }
    server->context = lws_create_context(&info);
    struct lws_vhost *vhost = server->context ? listen_there(server, &info) : NULL;
    if (!vhost)
        return vv_fail(VV_E_ARGUMENT, "cannot listen on %s, port %d; is the port used by another program%s?",
                       info.iface, o->port,
                       o->certificate ? ", or is the certificate not a PEM file with its key" : "");
    const int port = !o->socket ? lws_get_vhost_listen_port(vhost) : o->port ? o->port : NEAR_PORT;
    st = vvi_gate_open(&server->gate, port, o->token, o->certificate != NULL);
    if (st == VV_OK && o->listen)
        st = vvi_gate_add_host(&server->gate, o->listen, port);
    if (st == VV_OK && o->host)
        st = vvi_gate_add_host(&server->gate, o->host, port);
    const bool everywhere = o->listen && strcmp(o->listen, "0.0.0.0") == 0;
    snprintf(server->link, sizeof server->link, "http%s://%s:%d/#%s", o->certificate ? "s" : "",
             o->host                    ? o->host
             : o->listen && !everywhere ? o->listen
                                        : "localhost",
             port, server->gate.token);
    return st;
}

vv_status vvi_server_new(vvi_server **out, const vvi_server_options *options)
{
    vvi_server *server = vvi_calloc(1, sizeof *server);
    *out = NULL;
    if (!server)
        return vv_fail_memory(sizeof *server);
    pthread_mutex_init(&server->waking, NULL);
    server->options = *options;
    server->options.session.wake = wake;
    server->options.session.user = server;
    vv_status st = open_port(server);
    if (st == VV_OK)
        st = vvi_session_new(&server->session, &server->options.session);
    if (st == VV_OK)
        *out = server;
    else
        vvi_server_free(server, true);
    return st;
}

void vvi_server_free(vvi_server *server, bool keep)
{
    if (!server)
        return;
    pthread_mutex_lock(&server->waking);
    server->gone = true;
    pthread_mutex_unlock(&server->waking);
    if (server->context)
        lws_context_destroy(server->context); /* sockets leave the session */
    if (server->has_socket)
        unlink(server->options.socket);
    vvi_session_free(server->session, keep);
    pthread_mutex_destroy(&server->waking);
    free(server);
}

const char *vvi_server_link(const vvi_server *server)
{
    return server->link;
}

vvi_session *vvi_server_session(vvi_server *server)
{
    return server->session;
}

vv_status vvi_server_run(vvi_server *server, const vv_job *job)
{
    lws_sul_schedule(server->context, 0, &server->due, tick, 1);
    while (!atomic_load(&server->stops) && !vv_job_cancelled(job) && lws_service(server->context, 0) >= 0)
        ;
    lws_sul_cancel(&server->due);
    return VV_OK;
}

void vvi_server_stop(vvi_server *server)
{
    atomic_store(&server->stops, true);
    lws_cancel_service(server->context);
}
