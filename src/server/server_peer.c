/* A connection: bytes in, bytes out, and how long it may take. */
#include "core/memory.h"
#include "server/server_impl.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

/* HEAD_SECONDS: for a whole head. ANSWER_SECONDS: for each piece of an answer. END_SECONDS: for the other side to
 * close. */
enum { HEAD_SECONDS = 5, ANSWER_SECONDS = 20, END_SECONDS = 2, PIECE = 32768, LEAST_HEAD = 1024 };
/* Of a file that was refused, much may be on its way: who sends all of it before it listens hears why. */
enum { REFUSED_MOST = 64 << 20, REFUSED_SECONDS = 10 };
enum { STRANGERS_MOST = 256 }; /* of an address, that have shown no right to be here */
#define SECOND INT64_C(1000000000)

void vvi_peer_expects(vvi_peer *peer, int seconds)
{
    peer->deadline = vvi_now() + seconds * SECOND;
}

void vvi_peer_kill(vvi_peer *peer)
{
    peer->ends = true;
    lws_set_timeout(peer->wsi, PENDING_TIMEOUT_USER_REASON_BASE, LWS_TO_KILL_ASYNC);
}

/* What it costs --------------------------------------------------------------------------------------------------- */

bool vvi_peer_ration(vvi_peer *peer, int64_t now)
{
    return peer->ration.place || vvi_ration_begin(&peer->ration, &peer->server->rations, peer->address, now);
}

void vvi_peer_pay(vvi_peer *peer, double *since, size_t n)
{
    const double now = vvi_ration_clock();
    if (peer->ration.place)
        vvi_ration_pay(&peer->ration, now - *since, n, vvi_now());
    if (peer->socket)
        peer->socket->cost += now - *since;
    peer->server->paid += now - *since;
    *since = now;
}

bool vvi_peer_may_send(vvi_peer *peer, int64_t now)
{
    int64_t wait = peer->ration.place ? vvi_ration_wait(&peer->ration, now) : 0;
    if (wait == 0 && peer->socket && peer->socket->client && !vvi_client_looks(peer->socket->client))
        wait = vvi_ration_wait_hello(&peer->ration, now);
    peer->resumes = wait ? now + wait : 0;
    return wait == 0;
}

/* Nothing is read from who has to wait, and so it is not read that he has gone. */
bool vvi_peer_has_gone(const vvi_peer *peer)
{
    struct tcp_info info;
    socklen_t n = sizeof info;
    return peer->resumes && getsockopt(lws_get_socket_fd(peer->wsi), IPPROTO_TCP, TCP_INFO, &info, &n) == 0 &&
           info.tcpi_state != TCP_ESTABLISHED;
}

void vvi_peer_resume(vvi_peer *peer, int64_t now)
{
    if (!peer->resumes || now < peer->resumes || peer->state != VVI_PEER_BODY)
        return;
    peer->resumes = 0;
    vvi_peer_expects(peer, ANSWER_SECONDS);
    lws_rx_flow_control(peer->wsi, 1);
    double since = vvi_ration_clock();
    if (vvi_http_take(peer, NULL, 0) != 0) /* all of it may be there */
        vvi_peer_kill(peer);
    vvi_peer_pay(peer, &since, 0);
}

/* Out ------------------------------------------------------------------------------------------------------------ */

uint8_t *vvi_peer_room(vvi_peer *peer, size_t n)
{
    uint8_t *room = vvi_realloc_plain(NULL, LWS_PRE + n);
    if (!room)
        return NULL;
    free(peer->out);
    peer->out = room;
    peer->n_out = n;
    peer->at_out = 0;
    peer->moved = vvi_now();
    lws_callback_on_writable(peer->wsi);
    return room + LWS_PRE;
}

bool vvi_peer_put(vvi_peer *peer, const void *head, size_t n_head, const void *bytes, size_t n)
{
    uint8_t *room = vvi_peer_room(peer, n_head + n);
    if (!room)
        return false;
    memcpy(room, head, n_head);
    if (n)
        memcpy(room + n_head, bytes, n);
    return true;
}

void vvi_peer_cut(vvi_peer *peer, size_t at, const void *end, size_t n)
{
    memcpy(peer->out + LWS_PRE + at, end, n);
    peer->n_out = at + n;
}

/* Everything has left. To close with bytes that nobody has read would take the answer back: so the other side closes.
 */
static int begin_end(vvi_peer *peer)
{
    peer->state = VVI_PEER_ENDS;
    vvi_peer_expects(peer, peer->uploads ? REFUSED_SECONDS : END_SECONDS);
    vvi_http_free(peer);
    vvi_socket_free(peer);
    return lws_is_ssl(peer->wsi) || shutdown(lws_get_socket_fd(peer->wsi), SHUT_WR) == 0 ? 0 : -1;
}

/* In pieces, so that it is seen whether anything leaves at all. */
static int send_piece(vvi_peer *peer)
{
    const size_t left = peer->n_out - peer->at_out, n = left < PIECE ? left : PIECE;
    if (lws_write(peer->wsi, peer->out + LWS_PRE + peer->at_out, n, LWS_WRITE_RAW) < 0)
        return -1;
    peer->at_out += n;
    peer->moved = vvi_now();
    if (peer->state == VVI_PEER_ANSWER)
        vvi_peer_expects(peer, ANSWER_SECONDS);
    if (peer->at_out == peer->n_out) {
        free(peer->out);
        peer->out = NULL;
    }
    if (peer->state == VVI_PEER_ANSWER && vvi_answer_has_left(peer))
        return begin_end(peer);
    lws_callback_on_writable(peer->wsi); /* for the rest, and to know that this has left */
    return 0;
}

static int send_more(vvi_peer *peer)
{
    bool done = false;
    if (peer->out)
        return send_piece(peer);
    if (peer->state == VVI_PEER_ANSWER && vvi_answer_next(peer, &done) != 0)
        return -1;
    if (peer->state == VVI_PEER_SOCKET && vvi_socket_next(peer, &done) != 0)
        return -1;
    return peer->out ? send_piece(peer) : done ? begin_end(peer) : 0;
}

/* In ------------------------------------------------------------------------------------------------------------- */

static int take(vvi_peer *peer, const uint8_t *in, size_t n);

static bool grow(vvi_peer *peer, size_t n)
{
    size_t room = peer->room_in ? peer->room_in : LEAST_HEAD;
    while (room < peer->n_in + n)
        room *= 2;
    if (room == peer->room_in)
        return true;
    char *more = vvi_realloc_plain(peer->in, room);
    peer->in = more ? more : peer->in;
    peer->room_in = more ? room : peer->room_in;
    return more != NULL;
}

static int take_head(vvi_peer *peer, const uint8_t *in, size_t n)
{
    const size_t before = peer->n_in, most = VVI_HEAD_MOST - before, part = n < most ? n : most;
    vvi_head head;
    const char *why = NULL;
    size_t used;
    if (!grow(peer, part))
        return -1;
    memcpy(peer->in + before, in, part);
    peer->n_in += part;
    const int status = vvi_head_read(&head, &why, &used, peer->in, peer->n_in);
    if (status == 0)
        return 0;
    const int result = vvi_http_begin(peer, &head, status, why);
    free(peer->in);
    peer->in = NULL;
    const size_t skip = used > before ? used - before : 0;
    return result != 0 || skip >= n ? result : take(peer, in + skip, n - skip);
}

static int pass_over(vvi_peer *peer, size_t n)
{
    double since = vvi_ration_clock();
    peer->passed += n;
    vvi_peer_pay(peer, &since, n);
    return peer->passed > (peer->uploads ? REFUSED_MOST : VVI_MESSAGE_MOST) ? -1 : 0;
}

/* A file in many small pieces costs more than its bytes. */
static int take_body(vvi_peer *peer, const uint8_t *in, size_t n)
{
    double since = vvi_ration_clock();
    if (vvi_http_take(peer, in, n) != 0)
        return -1;
    vvi_peer_pay(peer, &since, 0);
    if (peer->state == VVI_PEER_BODY && !vvi_peer_may_send(peer, vvi_now()))
        lws_rx_flow_control(peer->wsi, 0);
    return 0;
}

static int take(vvi_peer *peer, const uint8_t *in, size_t n)
{
    switch (peer->state) {
    case VVI_PEER_HEAD:
        return take_head(peer, in, n);
    case VVI_PEER_BODY:
        return take_body(peer, in, n);
    case VVI_PEER_SOCKET:
        return vvi_socket_take(peer, in, n);
    case VVI_PEER_ANSWER:
    case VVI_PEER_ENDS:
        return pass_over(peer, n);
    }
    return -1;
}

/* Coming and going ----------------------------------------------------------------------------------------------- */

void vvi_peer_let_in(vvi_peer *peer)
{
    peer->server->strangers -= !peer->let_in;
    peer->let_in = true;
}

/* Of two, the newer one first: who has said nothing goes before who is answered, and of those the older one. */
static vvi_peer *first_to_go(vvi_peer *newer, vvi_peer *older)
{
    const bool is_silent = older->state <= VVI_PEER_BODY;
    return !newer || is_silent || newer->state > VVI_PEER_BODY ? older : newer;
}

/* Those who have shown no right to be here are few of each address, and no more than half of all: one of them goes for
 * each that comes. Who has a right shows it at once. */
static void make_way(vvi_server *server, const vvi_peer *newcomer)
{
    const int most = server->sockets_most / 2, share = most / 2 < STRANGERS_MOST ? most / 2 : STRANGERS_MOST;
    vvi_peer *neighbour = NULL, *any = NULL;
    int near = 0, all = 0;
    if (server->strangers <= share)
        return;
    for (vvi_peer *p = newcomer->next; p; p = p->next) { /* newer ones first */
        if (p->let_in || p->ends)
            continue;
        all++;
        any = first_to_go(any, p);
        if (strcmp(p->address, newcomer->address) != 0)
            continue;
        near++;
        neighbour = first_to_go(neighbour, p);
    }
    vvi_peer *goes = near >= share ? neighbour : all >= most ? any : NULL;
    if (goes)
        vvi_peer_kill(goes);
}

static void come(vvi_peer *peer, vvi_server *server, struct lws *wsi)
{
    *peer = (vvi_peer){.server = server, .wsi = wsi, .next = server->peers, .link = &server->peers};
    if (peer->next)
        peer->next->link = &peer->next;
    server->peers = peer;
    lws_get_peer_simple(wsi, peer->address, sizeof peer->address);
    vvi_peer_expects(peer, HEAD_SECONDS);
    server->strangers++;
    make_way(server, peer);
}

static void go(vvi_peer *peer)
{
    if (!peer->link)
        return;
    *peer->link = peer->next;
    if (peer->next)
        peer->next->link = peer->link;
    vvi_socket_free(peer);
    vvi_http_free(peer);
    vvi_peer_let_in(peer); /* and is no stranger any more */
    vvi_ration_end(&peer->ration, vvi_now());
    free(peer->in);
    free(peer->out);
    *peer = (vvi_peer){.link = NULL};
}

static int called(struct lws *wsi, enum lws_callback_reasons reason, vvi_peer *peer, void *in, size_t n)
{
    switch (reason) {
    case LWS_CALLBACK_FILTER_NETWORK_CONNECTION:
        return vvi_doors_admit(vvi_server_of(wsi), wsi, vvi_now()) ? 0 : 1;
    case LWS_CALLBACK_WSI_CREATE:
        vvi_server_of(wsi)->sockets++;
        return 0;
    case LWS_CALLBACK_WSI_DESTROY:
        vvi_server_of(wsi)->sockets--;
        vvi_doors_stay(vvi_server_of(wsi));
        return 0;
    case LWS_CALLBACK_RAW_ADOPT:
        if (peer)
            come(peer, vvi_server_of(wsi), wsi);
        return 0;
    case LWS_CALLBACK_RAW_RX:
        return peer && peer->link ? take(peer, in, n) : -1;
    case LWS_CALLBACK_RAW_WRITEABLE:
        return peer && peer->link ? send_more(peer) : -1;
    case LWS_CALLBACK_RAW_CLOSE:
        if (peer)
            go(peer);
        return 0;
    default:
        return 0;
    }
}

/* Others have something else for `user`: of a certificate, what OpenSSL keeps. */
static bool is_of_peer(enum lws_callback_reasons reason)
{
    return reason == LWS_CALLBACK_RAW_ADOPT || reason == LWS_CALLBACK_RAW_RX || reason == LWS_CALLBACK_RAW_WRITEABLE ||
           reason == LWS_CALLBACK_RAW_CLOSE;
}

/* Of those that have brought somebody, or bring a file, that pays. */
int vvi_peer_callback(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t n)
{
    vvi_peer *peer = is_of_peer(reason) ? user : NULL;
    const bool pays =
        peer && peer->link && (peer->state == VVI_PEER_SOCKET || peer->state == VVI_PEER_BODY || peer->ration.place);
    if (peer)
        vvi_server_of(wsi)->calls++;
    if (pays)
        peer->calls++;
    if (pays || !peer)
        return called(wsi, reason, user, in, n);
    const double since = vvi_ration_clock();
    const int result = called(wsi, reason, user, in, n);
    vvi_doors_pay(vvi_server_of(wsi), since, vvi_now());
    return result;
}
