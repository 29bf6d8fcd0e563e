/* WebSockets: messages in, texts and frames out. */
#include "core/memory.h"
#include "server/server_impl.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

/* Messages a second that a page may send for long, and at once. A hand makes 120 events, and a page bundles them. */
#define RATE 500.0
#define BURST 2000.0
/* What the system keeps of what has not left yet: all else waits here, where news take the place of older ones. */
#define UNSENT 16384
#define END_SECONDS 2 /* for the sentence to leave, where nothing is taken any more */

#define CLOSE_TRY_LATER 1013 /* of the registry of WebSocket; the library has no name for it */

static int end_with(struct lws *wsi, int code, const char *why)
{
    char text[121];
    snprintf(text, sizeof text, "%s", why);
    size_t n = strlen(text);
    while (n > 0 && ((unsigned char)why[n] & 0xc0) == 0x80)
        n--; /* whole characters */
    lws_close_reason(wsi, (enum lws_close_status)code, (unsigned char *)text, n);
    return -1;
}

static int end(struct lws *wsi, const char *why)
{
    return end_with(wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION, why);
}

static int join(struct lws *wsi, vvi_socket *socket)
{
    vvi_server *server = vvi_server_of(wsi);
    const int unsent = UNSENT;
    *socket = (vvi_socket){.budget = BURST, .budget_at = vvi_now()};
    setsockopt(lws_get_socket_fd(wsi), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &unsent, sizeof unsent);
    char address[48] = "";
    lws_get_peer_simple(wsi, address, sizeof address);
    if (vvi_client_join(&socket->client, server->session, wsi) != VV_OK)
        return end_with(wsi, CLOSE_TRY_LATER, vv_error_last()->message);
    vvi_client_comes_from(socket->client, address);
    return 0;
}

void vvi_socket_end(struct lws *wsi, const char *why)
{
    vvi_socket *socket = lws_wsi_user(wsi);
    if (socket->ends)
        return;
    socket->ends = why;
    lws_set_timeout(wsi, PENDING_TIMEOUT_USER_REASON_BASE, END_SECONDS);
    lws_callback_on_writable(wsi);
}

/* Nothing is taken from one who asks and does not read. */
static void set_flow(struct lws *wsi, vvi_socket *socket)
{
    const bool full = vvi_client_is_full(socket->client);
    if (full != socket->paused)
        lws_rx_flow_control(wsi, full ? 0 : 1);
    socket->paused = full;
}

static bool has_budget(vvi_socket *socket)
{
    const int64_t now = vvi_now();
    socket->budget += (double)(now - socket->budget_at) * 1e-9 * RATE;
    socket->budget = socket->budget > BURST ? BURST : socket->budget;
    socket->budget_at = now;
    return socket->budget-- >= 1;
}

static int take(struct lws *wsi, vvi_socket *socket, const char *in, size_t n)
{
    if (lws_frame_is_binary(wsi))
        return end(wsi, "binary messages are not accepted");
    if (socket->n_message + n + lws_remaining_packet_payload(wsi) > VVI_MESSAGE_MOST)
        return end(wsi, "a message is longer than 1 MiB");
    char *more = vvi_realloc_plain(socket->message, socket->n_message + n + 1);
    if (!more)
        return end(wsi, "there is not enough memory for this message");
    memcpy(more + socket->n_message, in, n);
    socket->message = more;
    socket->n_message += n;
    if (!lws_is_final_fragment(wsi) || lws_remaining_packet_payload(wsi))
        return 0;
    if (!has_budget(socket))
        return end(wsi, "too many messages");
    const vv_status st = vvi_client_message(socket->client, socket->message, socket->n_message, vvi_now());
    free(socket->message);
    socket->message = NULL;
    socket->n_message = 0;
    if (st != VV_OK)
        return end(wsi, vv_error_last()->message);
    set_flow(wsi, socket);
    return 0;
}

static int send_next(struct lws *wsi, vvi_socket *socket)
{
    vvi_outgoing out;
    if (socket->ends)
        return end(wsi, socket->ends);
    if (!vvi_client_next(&out, socket->client, vvi_now()))
        return 0;
    const size_t head = out.text ? 0 : sizeof out.head;
    uint8_t *room = malloc(LWS_PRE + head + out.n);
    int result = -1;
    if (room) {
        memcpy(room + LWS_PRE, out.head, head);
        if (out.n)
            memcpy(room + LWS_PRE + head, out.text ? (const void *)out.text : (const void *)out.bytes, out.n);
        result = lws_write(wsi, room + LWS_PRE, head + out.n, out.text ? LWS_WRITE_TEXT : LWS_WRITE_BINARY);
    }
    free(room);
    free(out.text);
    vv_image_bytes_free(out.bytes);
    if (vvi_client_has_more(socket->client, vvi_now()))
        lws_callback_on_writable(wsi);
    set_flow(wsi, socket);
    return result < 0 ? -1 : 0;
}

static void leave(vvi_socket *socket)
{
    if (socket->client)
        vvi_client_leave(socket->client);
    free(socket->message);
    *socket = (vvi_socket){.client = NULL};
}

int vvi_socket_callback(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t n)
{
    vvi_socket *socket = user;
    switch (reason) {
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
        return vvi_server_check(vvi_server_of(wsi), wsi) == VVI_PASS_ALL ? 0 : 1;
    case LWS_CALLBACK_ESTABLISHED:
        return join(wsi, socket);
    case LWS_CALLBACK_RECEIVE:
        return socket->client ? take(wsi, socket, in, n) : -1;
    case LWS_CALLBACK_SERVER_WRITEABLE:
        return socket->client ? send_next(wsi, socket) : -1;
    case LWS_CALLBACK_CLOSED:
        leave(socket);
        return 0;
    default:
        return 0;
    }
}
