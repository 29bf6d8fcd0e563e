/* The port, and the loop. */
#include "core/memory.h"
#include "server/server_impl.h"
#include "server/tls.h"
#include "server/unix_socket.h"

#include <errno.h>
#include <netdb.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

/* SHAKE_SECONDS: for the beginning of TLS. READ_BYTES: at once, of one connection. */
enum { SHAKE_SECONDS = 5, READ_BYTES = 16384, CONNECTIONS = 4096, OTHER_FILES = 256 };
#define SOON 1000 /* microseconds: however many messages come meanwhile, others are looked at once */
#define SWEEP (INT64_C(500) * 1000000)
#define SWEEP_OFTEN (INT64_C(50) * 1000000)
enum { FEW_COME = 8 };

vvi_server *vvi_server_of(struct lws *wsi)
{
    return lws_context_user(lws_get_context(wsi));
}

/* The loop -------------------------------------------------------------------------------------------------------- */

static void wake(void *user)
{
    vvi_server *server = user;
    pthread_mutex_lock(&server->waking);
    atomic_store(&server->woken, true);
    if (!server->gone)
        lws_cancel_service(server->context);
    pthread_mutex_unlock(&server->waking);
}

static void tick(lws_sorted_usec_list_t *due);

/* Of all connections, whether they take too long, and whether they may send again. */
static void sweep(vvi_server *server, int64_t now)
{
    /* who has gone before it was his turn is no longer waited for in each round */
    const bool many_come = server->rations.n - server->rations.n_greeted > FEW_COME;
    if (now - server->swept < (many_come ? SWEEP_OFTEN : SWEEP))
        return;
    server->swept = now;
    for (vvi_peer *p = server->peers; p; p = p->next) {
        vvi_peer_resume(p, now);
        if ((p->deadline && now > p->deadline) || vvi_peer_has_gone(p))
            vvi_peer_kill(p);
    }
}

/* What is due for all. */
static void go_round(vvi_server *server)
{
    const int64_t now = vvi_now();
    int64_t wait = vvi_session_tick(server->session, now);
    vvi_client *c = vvi_session_client(server->session, NULL);
    while (c) {
        vvi_peer *peer = vvi_client_user(c);
        c = vvi_session_client(server->session, c); /* the one before may leave now */
        const int64_t due = vvi_socket_tick(peer, now);
        wait = due < wait ? due : wait;
    }
    sweep(server, now);
    const int64_t shut = vvi_doors_tick(server, now);
    wait = shut < wait ? shut : wait;
    const int64_t most = INT64_C(1000000000);
    server->soon = false;
    lws_sul_schedule(server->context, 0, &server->due, tick, (wait < most ? wait : most) / 1000 + SOON);
}

void vvi_server_go_soon(vvi_server *server)
{
    if (!server->soon)
        lws_sul_schedule(server->context, 0, &server->due, tick, SOON);
    server->soon = true;
}

static void tick(lws_sorted_usec_list_t *due)
{
    vvi_server *server = lws_container_of(due, vvi_server, due);
    vvi_session_serve(server->session);
    go_round(server);
}

static int serve(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t n)
{
    if (reason == LWS_CALLBACK_EVENT_WAIT_CANCELLED) { /* at each door; and libwebsockets does it for each connection */
        vvi_server *server = vvi_server_of(wsi);
        if (server->session && atomic_exchange(&server->woken, false)) {
            vvi_session_serve(server->session);
            go_round(server);
        }
        return 0;
    }
    return vvi_peer_callback(wsi, reason, user, in, n);
}

static const struct lws_protocols protocols[] = {
    {.name = "volvis", .callback = serve, .per_session_data_size = sizeof(vvi_peer), .rx_buffer_size = READ_BYTES},
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

/* NEAR_PORT: of a tunnel to a Unix socket. */
enum { NEAR_PORT = 8080, PORT_TRIES = 16 };

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

/* 0: this machine has the address, or that cannot be known; else an error's number. */
static int try_address(const char *address)
{
    struct addrinfo *at = NULL;
    const struct addrinfo numbers = {.ai_flags = AI_NUMERICHOST, .ai_socktype = SOCK_STREAM};
    if (getaddrinfo(address, NULL, &numbers, &at) != 0)
        return EINVAL;
    const int fd = socket(at->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int error = fd >= 0 && bind(fd, at->ai_addr, at->ai_addrlen) != 0 ? errno : 0;
    if (fd >= 0)
        close(fd);
    freeaddrinfo(at);
    return error;
}

static vv_status check_address(const char *address)
{
    const int error = try_address(address);
    if (error == EINVAL)
        return vv_fail(VV_E_ARGUMENT,
                       "--listen takes the number of an address, as in 127.0.0.1, ::1 or 0.0.0.0 (all of this "
                       "machine); \"%.80s\" is none",
                       address);
    return error == EADDRNOTAVAIL
               ? vv_fail(VV_E_ARGUMENT, "%.80s is not an address of this machine; 0.0.0.0 means all that are", address)
               : VV_OK;
}

vv_status vvi_server_options_check(const vvi_server_options *o)
{
    vv_status st = o->token ? vvi_token_check(o->token) : VV_OK;
    if (st == VV_OK && o->listen)
        st = check_address(o->listen);
    if (st == VV_OK && o->key && !o->certificate)
        st = vv_fail_at(VV_E_ARGUMENT, o->key, NULL,
                        "a TLS key without its certificate: give that too (--tls-cert), or the page would be served "
                        "without TLS");
    if (st == VV_OK && o->certificate)
        st = vvi_tls_check(o->certificate, o->key);
    return st == VV_OK && o->socket ? vvi_unix_socket_check(o->socket) : st;
}

/* TLS 1.2 with ephemeral keys and authenticated ciphers, and 1.3. */
static void set_tls(struct lws_context_creation_info *info, const vvi_server_options *o)
{
    if (!o->certificate)
        return;
    info->options |= LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT;
    info->ssl_cert_filepath = o->certificate;
    info->ssl_private_key_filepath = o->key ? o->key : o->certificate;
    info->ssl_options_set = SSL_OP_NO_SSLv3 | SSL_OP_NO_TLSv1 | SSL_OP_NO_TLSv1_1 | SSL_OP_NO_COMPRESSION |
                            SSL_OP_NO_RENEGOTIATION | SSL_OP_CIPHER_SERVER_PREFERENCE;
    info->ssl_cipher_list = "ECDHE+AESGCM:ECDHE+CHACHA20";
    info->alpn = "http/1.1";
}

static struct lws_context_creation_info settings(vvi_server *server)
{
    struct lws_context_creation_info info = {.protocols = protocols,
                                             .user = server,
                                             .gid = (gid_t)-1,
                                             .uid = (uid_t)-1,
                                             .timeout_secs = SHAKE_SECONDS,
                                             .fd_limit_per_thread = CONNECTIONS,
                                             .pt_serv_buf_size = READ_BYTES,
                                             .vhost_name = "volvis",
                                             .listen_accept_role = "raw-skt",
                                             .listen_accept_protocol = "volvis"};
    info.options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS | LWS_SERVER_OPTION_ADOPT_APPLY_LISTEN_ACCEPT_CONFIG |
                   LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND;
    set_tls(&info, &server->options);
    return info;
}

/* At this address and the loopback one of IPv6, at one port: whoever had the other one would be taken for this server
 * where a name stands for both. In `both`, whether it is so. */
static struct lws_vhost *listen_at_both(vvi_server *server, struct lws_context_creation_info *info, bool *both)
{
    struct lws_context_creation_info other = *info;
    struct lws_vhost *vhost = NULL;
    info->iface = server->options.listen ? server->options.listen : "127.0.0.1";
    info->options |= LWS_SERVER_OPTION_DISABLE_IPV6;
    *both = false;
    for (int i = 0; i < PORT_TRIES && !*both; i++) {
        if (vhost)
            lws_vhost_destroy(vhost);
        if (!(vhost = listen_there(server, info)))
            return NULL;
        other.iface = "::1";
        other.vhost_name = "volvis6";
        other.port = lws_get_vhost_listen_port(vhost);
        *both = lws_create_vhost(server->context, &other) != NULL;
        if (info->port)
            break;
    }
    return vhost;
}

static struct lws_vhost *listen_anywhere(vvi_server *server, bool *both)
{
    const vvi_server_options *o = &server->options;
    struct lws_context_creation_info info = settings(server);
    info.port = o->port;
    if (!(server->context = lws_create_context(&info)))
        return NULL;
    if (!o->socket && (!o->listen || strcmp(o->listen, "0.0.0.0") == 0))
        return listen_at_both(server, &info, both);
    *both = true;
    info.iface = o->socket ? o->socket : o->listen;
    if (o->socket) {
        info.options |= LWS_SERVER_OPTION_UNIX_SOCK;
        info.port = 0;
    }
    if (!strchr(info.iface, ':'))
        info.options |= LWS_SERVER_OPTION_DISABLE_IPV6;
    return listen_there(server, &info);
}

/* An address as it stands in a link: those with colons have brackets. */
static void write_address(char out[80], const char *address)
{
    snprintf(out, 80, strchr(address, ':') && *address != '[' ? "[%.70s]" : "%.70s", address);
}

/* What the link calls the machine. */
static void write_origin(vvi_server *server, bool both)
{
    const vvi_server_options *o = &server->options;
    const bool everywhere = o->listen && (strcmp(o->listen, "0.0.0.0") == 0 || strcmp(o->listen, "::") == 0);
    char address[80] = "";
    if (o->listen && !everywhere)
        write_address(address, o->listen);
    snprintf(server->origin, sizeof server->origin, "http%s://%.300s:%d", o->certificate ? "s" : "",
             o->host    ? o->host
             : *address ? address
             : both     ? "localhost"
                        : "127.0.0.1",
             server->port);
}

static void make_link(vvi_server *server)
{
    snprintf(server->link, sizeof server->link, "%s/#%s", server->origin, server->gate.token);
}

static vv_status open_port(vvi_server *server)
{
    const vvi_server_options *o = &server->options;
    bool both = false;
    vv_status st = vvi_server_options_check(o);
    if (st == VV_OK && o->socket)
        st = vvi_unix_socket_prepare(o->socket);
    if (st != VV_OK)
        return st;
    lws_set_log_level(0, NULL);
    server->sockets_most = sockets_most();
    struct lws_vhost *vhost = listen_anywhere(server, &both);
    if (!vhost)
        return vv_fail(VV_E_ARGUMENT, "cannot listen on %s, port %d; is the port used by another program?",
                       o->socket   ? o->socket
                       : o->listen ? o->listen
                                   : "127.0.0.1",
                       o->port);
    server->port = !o->socket ? lws_get_vhost_listen_port(vhost) : o->port ? o->port : NEAR_PORT;
    st = vvi_gate_open(&server->gate, server->port, o->token, o->certificate != NULL);
    if (st == VV_OK && o->listen) {
        char address[80];
        write_address(address, o->listen);
        st = vvi_gate_add_host(&server->gate, address, server->port);
    }
    if (st == VV_OK && o->host)
        st = vvi_gate_add_host(&server->gate, o->host, server->port);
    write_origin(server, both);
    make_link(server);
    return st;
}

vv_status vvi_server_renew(vvi_server *server)
{
    const vv_status st = vvi_gate_renew(&server->gate);
    if (st != VV_OK)
        return st;
    vvi_server_forget_launch(server);
    make_link(server);
    for (vvi_peer *p = server->peers; p; p = p->next)
        if (p->socket)
            vvi_socket_end(p, VVI_CLOSE_POLICY, "all sessions were ended; the program has printed another link");
    if (server->options.renewed)
        server->options.renewed(server->options.user, server->link);
    return VV_OK;
}

vv_status vvi_server_launch(char out[512], vvi_server *server, const char *file)
{
    vvi_server_forget_launch(server);
    if (!(server->launch_file = vvi_strdup(file)))
        return vv_fail_memory(strlen(file));
    const vv_status st = vvi_gate_launch(&server->gate);
    snprintf(out, 512, "%s/#%s", server->origin, server->gate.launch);
    return st;
}

void vvi_server_forget_launch(vvi_server *server)
{
    if (server->launch_file)
        unlink(server->launch_file);
    free(server->launch_file);
    server->launch_file = NULL;
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

vv_status vvi_server_free(vvi_server *server, bool keep)
{
    if (!server)
        return VV_OK;
    pthread_mutex_lock(&server->waking);
    server->gone = true;
    pthread_mutex_unlock(&server->waking);
    server->is_shut = false; /* the doors go before those who have come in */
    if (server->context)
        lws_context_destroy(server->context); /* sockets leave the session */
    if (server->has_socket)
        unlink(server->options.socket);
    vvi_server_forget_launch(server);
    vvi_rations_clear(&server->rations);
    const vv_status st = vvi_session_free(server->session, keep);
    pthread_mutex_destroy(&server->waking);
    free(server);
    return st;
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
