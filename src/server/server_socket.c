/* WebSockets: messages in, texts and frames out. */
#include "core/memory.h"
#include "io/scan.h"
#include "server/handshake.h"
#include "server/server_impl.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <volvis/image.h>

/* Those of an address that have not said hello: after this time so many may wait, before it HURRIED. */
#define SILENT (INT64_C(2) * 1000000000)
enum { SILENT_MOST = 16, HURRIED_MOST = 256, HELLO_MOST = 4096 };
enum { PIECES_MOST = 16 };                /* frames, or parts of them, that may come before hello is whole */
#define HELLO (INT64_C(20) * 1000000000)  /* within which who comes says hello */
#define TURN (INT64_C(30) * 1000000000)   /* the same where nothing was taken from it yet */
#define WHOLE (INT64_C(120) * 1000000000) /* within which a message comes: 1 MiB, 10 kB a second */
#define FLOODS (INT64_C(30) * 1000000000) /* for which more waited for us all the time than we took */
/* What the system keeps of what has not left yet: all else waits here, where news take the place of older ones. */
#define UNSENT 16384
#define VISIT (INT64_C(5) * 1000000000) /* who stays no longer has come and gone */
#define END_SECONDS 2                   /* for the sentence to leave, where nothing is taken any more */
enum { REST_MOST = 1 << 16 };
/* A picture on a line of which nothing is known leaves in parts of so many bytes, and is broken off behind one of them
 * where the rest would take longer than so many seconds, by what left since it was looked at last. */
enum { PART = 16384, PART_HEAD = 4, TOO_LONG = 5 };
#define LOOK (INT64_C(1) * 1000000000)
/* How long a page may leave what was sent unread; be silent until it is asked whether it is there; and until it is not.
 */
#define STANDS (INT64_C(25) * 1000000000)
#define QUIET (INT64_C(30) * 1000000000)
#define GONE (INT64_C(60) * 1000000000)

/* What others have to do for it is its own cost. Who comes and goes has paid by an account that nobody draws on any
 * more: it is paid by those who come, who wait the longer. */
static void leave(vvi_peer *peer)
{
    vvi_socket *socket = peer->socket;
    double since = vvi_ration_clock();
    if (!socket->client)
        return;
    vvi_client_leave(socket->client);
    socket->client = NULL;
    vvi_peer_pay(peer, &since, 0);
    const int64_t now = vvi_now();
    if (now - socket->came < VISIT)
        vvi_doors_pay_visit(peer->server, socket->cost, peer->calls, now);
}

void vvi_socket_end(vvi_peer *peer, int code, const char *why)
{
    vvi_socket *socket = peer->socket;
    if (socket->code)
        return;
    socket->code = code;
    snprintf(socket->why, sizeof socket->why, "%.*s", (int)vvi_utf8_cut(why, strlen(why), sizeof socket->why - 1), why);
    leave(peer);
    vvi_peer_expects(peer, END_SECONDS);
    lws_callback_on_writable(peer->wsi);
}

/* The upgrade ---------------------------------------------------------------------------------------------------- */

int vvi_socket_check(const char **why, const vvi_head *head)
{
    *why = "This is no way into this server.\n";
    if (strcmp(head->path, "/ws") != 0 || head->method != VVI_METHOD_GET || head->length > 0 || head->has_query)
        return HTTP_STATUS_BAD_REQUEST;
    *why = "Here is a WebSocket of version 13 and the protocol volvis, and nothing else.\n";
    if (!head->upgrade || !vvi_head_lists(head->upgrade, "websocket") || strchr(head->upgrade, ','))
        return head->upgrade ? HTTP_STATUS_BAD_REQUEST : 426;
    if (!vvi_head_lists(head->connection, "upgrade") || !head->socket_key ||
        strlen(head->socket_key) != VVI_KEY_LETTERS)
        return HTTP_STATUS_BAD_REQUEST;
    if (!head->socket_version || strcmp(head->socket_version, "13") != 0)
        return 426;
    return vvi_head_lists(head->socket_protocols, "volvis") ? HTTP_STATUS_OK : HTTP_STATUS_BAD_REQUEST;
}

static bool is_coming(const vvi_peer *peer, const vvi_peer *like)
{
    const vvi_socket *s = peer->socket;
    return s && s->client && !vvi_client_looks(s->client) && strcmp(peer->address, like->address) == 0;
}

/* Whether it may have said hello: nothing was taken of what it said. */
static bool waits(const vvi_socket *socket)
{
    return socket->paused && !socket->spoke;
}

/* Who comes and says nothing takes no place of those who look, and few of the connections: the one that has been silent
 * for longest goes. False: all may have said hello, and wait for their turn; so many are enough. */
static bool make_room(const vvi_peer *newcomer, int64_t now)
{
    vvi_peer *oldest = NULL;
    int coming = 0, silent = 0;
    for (vvi_peer *p = newcomer->server->peers; p; p = p->next) {
        if (p == newcomer || !is_coming(p, newcomer))
            continue;
        coming++;
        if (waits(p->socket))
            continue;
        silent += now - p->socket->came > SILENT;
        oldest = oldest && oldest->socket->came <= p->socket->came ? oldest : p;
    }
    if (oldest && (silent >= SILENT_MOST || coming >= HURRIED_MOST))
        vvi_socket_end(oldest, VVI_CLOSE_TRY_LATER, "others come, and this page has not said hello");
    return oldest || coming < HURRIED_MOST;
}

static void join(vvi_peer *peer)
{
    vvi_socket *socket = peer->socket;
    const int unsent = UNSENT;
    setsockopt(lws_get_socket_fd(peer->wsi), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &unsent, sizeof unsent);
    if (!make_room(peer, socket->came))
        vvi_socket_end(peer, VVI_CLOSE_TRY_LATER, "too many come at once; try again soon");
    else if (vvi_client_join(&socket->client, peer->server->session, peer) != VV_OK)
        vvi_socket_end(peer, VVI_CLOSE_TRY_LATER, vv_error_last()->message);
    else
        vvi_client_comes_from(socket->client, peer->address);
}

int vvi_socket_begin(vvi_peer *peer, const vvi_head *head)
{
    char key[VVI_ACCEPT_TEXT], answer[256];
    const int64_t now = vvi_now();
    double since = vvi_ration_clock();
    if (!vvi_peer_ration(peer, now) || !(peer->socket = vvi_calloc(1, sizeof *peer->socket)))
        return -1;
    vvi_handshake_accept(key, head->socket_key);
    *peer->socket = (vvi_socket){
        .framing = {.most = HELLO_MOST, .shared = &peer->server->shared}, .came = now, .heard = now, .drained = now};
    const int n = snprintf(answer, sizeof answer,
                           "HTTP/1.1 101 Switching Protocols\r\nupgrade: websocket\r\nconnection: Upgrade\r\n"
                           "sec-websocket-accept: %s\r\nsec-websocket-protocol: volvis\r\n\r\n",
                           key);
    vvi_http_free(peer);
    peer->state = VVI_PEER_SOCKET;
    peer->deadline = 0;
    if (!vvi_peer_put(peer, answer, (size_t)n, NULL, 0))
        return -1;
    join(peer);
    vvi_peer_pay(peer, &since, 0);
    return 0;
}

/* In ------------------------------------------------------------------------------------------------------------- */

/* Nothing is taken from one who asks and does not read, or who has cost too much. */
static void set_flow(vvi_peer *peer)
{
    vvi_socket *socket = peer->socket;
    const bool full = socket->client && (peer->resumes || vvi_client_is_full(socket->client));
    if (full != socket->paused)
        lws_rx_flow_control(peer->wsi, full ? 0 : 1);
    socket->paused = full;
}

static void take_message(vvi_peer *peer)
{
    vvi_framing *f = &peer->socket->framing;
    const vv_status st = vvi_client_message(peer->socket->client, f->message, f->n_message, vvi_now());
    vvi_framing_forget(f);
    if (st == VV_OK && f->most) { /* the first one was hello */
        f->most = 0;
        vvi_ration_greeted(&peer->ration, vvi_now());
    }
    if (st != VV_OK)
        vvi_socket_end(peer, st == VV_E_LIMIT || st == VV_E_MEMORY ? VVI_CLOSE_TRY_LATER : VVI_CLOSE_POLICY,
                       vv_error_last()->message);
}

static void take_frame(vvi_peer *peer, vvi_framed what)
{
    vvi_socket *socket = peer->socket;
    const vvi_framing *f = &socket->framing;
    if (what == VVI_FRAMED_BAD)
        vvi_socket_end(peer, f->code, f->why);
    else if (what == VVI_FRAMED_CLOSE)
        vvi_socket_end(peer, f->code ? f->code : VVI_CLOSE_GOES, "");
    else if (what == VVI_FRAMED_MESSAGE)
        take_message(peer);
    else if (what == VVI_FRAMED_PING) {
        memcpy(socket->pong, f->control, f->n_control);
        socket->n_pong = f->n_control;
        socket->pongs = true; /* to the last one, if several came */
        lws_callback_on_writable(peer->wsi);
    }
}

/* Up to where nothing more is taken from it; returns the bytes that were. */
static size_t take_frames(vvi_peer *peer, const uint8_t *in, size_t n)
{
    vvi_socket *socket = peer->socket;
    const uint8_t *at = in, *end = in + n;
    double since = vvi_ration_clock();
    while (at < end && !socket->code && !vvi_client_is_full(socket->client) && vvi_peer_may_send(peer, vvi_now())) {
        const uint8_t *begin = at;
        const vvi_framed what = vvi_framing_take(&socket->framing, &at, end);
        if (what != VVI_FRAMED_MORE)
            take_frame(peer, what);
        if (socket->framing.most && ++socket->pieces > PIECES_MOST)
            vvi_socket_end(peer, VVI_CLOSE_POLICY, "this page says much, but not hello");
        vvi_peer_pay(peer, &since, (size_t)(at - begin));
    }
    socket->spoke |= at > in;
    socket->begun = !socket->framing.in_message ? 0 : socket->begun ? socket->begun : socket->heard;
    return (size_t)(at - in);
}

/* What came while nothing was taken any more waits here: less than one reading, since none follows. */
static bool keep(vvi_socket *socket, const uint8_t *in, size_t n)
{
    uint8_t *more = n ? vvi_realloc_plain(socket->rest, socket->n_rest + n) : NULL;
    if (!more)
        return n == 0;
    memcpy(more + socket->n_rest, in, n);
    socket->rest = more;
    socket->n_rest += n;
    return socket->n_rest <= REST_MOST;
}

/* Of what it sent while nothing was taken any more. False: none of it can be taken now. */
static bool take_rest(vvi_peer *peer)
{
    vvi_socket *socket = peer->socket;
    const size_t used = socket->n_rest ? take_frames(peer, socket->rest, socket->n_rest) : 0;
    if (used == 0)
        return false;
    memmove(socket->rest, socket->rest + used, socket->n_rest - used);
    socket->n_rest -= used;
    return true;
}

/* Who waits for answers leaves nothing behind what was taken, however long each question is: that is no flood. */
static void note_drained(const vvi_peer *peer, int64_t now)
{
    int n = 0;
    vvi_socket *socket = peer->socket;
    if (socket->n_rest == 0 && ioctl(lws_get_socket_fd(peer->wsi), FIONREAD, &n) == 0 && n == 0)
        socket->drained = now;
}

int vvi_socket_take(vvi_peer *peer, const uint8_t *in, size_t n)
{
    vvi_socket *socket = peer->socket;
    socket->heard = vvi_now();
    socket->ponders = false;
    const size_t used = socket->n_rest ? 0 : take_frames(peer, in, n);
    if (socket->code)
        peer->passed += n - used;
    else if (!keep(socket, in + used, n - used))
        return -1;
    note_drained(peer, socket->heard);
    set_flow(peer);
    vvi_server_go_soon(peer->server);
    if (socket->client && vvi_client_has_more(socket->client, socket->heard))
        lws_callback_on_writable(peer->wsi);
    return peer->passed > VVI_MESSAGE_MOST ? -1 : 0;
}

/* Out ------------------------------------------------------------------------------------------------------------ */

static int put_frame(vvi_peer *peer, int kind, const void *head, size_t n_head, const void *bytes, size_t n)
{
    uint8_t start[10 + 32];
    const size_t n_start = vvi_framing_head(start, kind, n_head + n);
    if (n_head)
        memcpy(start + n_start, head, n_head);
    return vvi_peer_put(peer, start, n_start + n_head, bytes, n) ? 0 : -1;
}

static int put_farewell(vvi_peer *peer, bool *done)
{
    vvi_socket *socket = peer->socket;
    const uint8_t code[2] = {(uint8_t)(socket->code >> 8), (uint8_t)socket->code};
    *done = socket->parted;
    if (socket->parted)
        return 0;
    socket->parted = true;
    return put_frame(peer, VVI_FRAME_CLOSE, code, sizeof code, socket->why, strlen(socket->why));
}

/* All but the last part have PART bytes with their heads. */
static int put_parts(vvi_peer *peer, const vvi_outgoing *out)
{
    enum { HEAD = sizeof out->head, BYTES = PART - PART_HEAD };
    const size_t all = HEAD + out->n, n_parts = (all + BYTES - 1) / BYTES;
    uint8_t *to = vvi_peer_room(peer, all + n_parts * PART_HEAD);
    if (!to)
        return -1;
    const uint8_t *end = to + all + n_parts * PART_HEAD;
    for (size_t i = 0, at = 0; i < n_parts; i++) {
        const size_t n = all - at < BYTES ? all - at : BYTES, of_head = i == 0 ? HEAD : 0;
        const size_t n_start = vvi_framing_part(to, i == 0 ? VVI_FRAME_BINARY : VVI_FRAME_MORE, n, i + 1 == n_parts);
        memcpy(to + n_start, out->head, of_head);
        memcpy(to + n_start + of_head, out->bytes + (at + of_head - HEAD), n - of_head);
        to += n_start + n;
        at += n;
    }
    peer->n_out -= (size_t)(end - to); /* the last may have a shorter head */
    peer->socket->breaks = true;
    peer->socket->seen_at = 0;
    return 0;
}

static bool takes_more(const vvi_peer *peer)
{
    struct pollfd line = {.fd = lws_get_socket_fd(peer->wsi), .events = POLLOUT};
    return poll(&line, 1, 0) > 0;
}

/* What the system has not taken is left out. A line that takes more just now is not what it waits for. */
static void look_at_line(vvi_peer *peer, int64_t now)
{
    static const uint8_t end[2] = {0x80, 0};
    vvi_socket *socket = peer->socket;
    const int64_t passed = now - socket->seen_at;
    if (!peer->out || !socket->breaks || (socket->seen_at && passed < LOOK))
        return;
    const double rate = (double)(peer->at_out - socket->seen) / (1e-9 * (double)passed);
    const size_t left = peer->n_out - peer->at_out, parts = (peer->at_out + PART - 1) / PART, at = parts * PART;
    if (socket->seen_at && parts > 1 && at + PART < peer->n_out && (double)left > TOO_LONG * rate &&
        !takes_more(peer)) {
        const size_t before = (peer->n_out - at + PART - 1) / PART * PART_HEAD;
        vvi_client_broke(socket->client, peer->n_out - at - before);
        vvi_peer_cut(peer, at, end, sizeof end);
        socket->breaks = false;
    }
    socket->seen_at = now;
    socket->seen = peer->at_out;
}

static int put_news(vvi_peer *peer)
{
    vvi_socket *socket = peer->socket;
    vvi_outgoing out;
    if (!vvi_client_next(&out, socket->client, vvi_now()))
        return 0;
    socket->breaks = false;
    const int result = out.text ? put_frame(peer, VVI_FRAME_TEXT, NULL, 0, out.text, out.n)
                       : out.breaks && out.n
                           ? put_parts(peer, &out)
                           : put_frame(peer, VVI_FRAME_BINARY, out.head, sizeof out.head, out.bytes, out.n);
    free(out.text);
    vv_image_bytes_free(out.bytes);
    const bool taken = take_rest(peer);
    set_flow(peer);
    if (taken)
        vvi_server_go_soon(peer->server);
    return result;
}

int vvi_socket_next(vvi_peer *peer, bool *done)
{
    vvi_socket *socket = peer->socket;
    if (socket->code)
        return put_farewell(peer, done);
    if (socket->pongs) {
        socket->pongs = false;
        return put_frame(peer, VVI_FRAME_PONG, NULL, 0, socket->pong, socket->n_pong);
    }
    if (socket->pings) {
        socket->pings = false;
        return put_frame(peer, VVI_FRAME_PING, NULL, 0, NULL, 0);
    }
    return socket->client ? put_news(peer) : -1;
}

/* Time ----------------------------------------------------------------------------------------------------------- */

/* Whether it is there still is asked for, and not of one that nothing is taken from. */
static void listen_for(vvi_peer *peer, int64_t now)
{
    vvi_socket *socket = peer->socket;
    const int64_t silence = socket->paused ? 0 : now - socket->heard;
    if (silence > GONE)
        vvi_socket_end(peer, VVI_CLOSE_POLICY, "nothing was heard of this page for a minute");
    else if (silence > QUIET && !socket->ponders)
        socket->pings = socket->ponders = true;
}

/* Why it should end; NULL: it goes on. */
static const char *is_bad(const vvi_peer *peer, int64_t now)
{
    const vvi_socket *socket = peer->socket;
    if (!vvi_client_looks(socket->client) && now - socket->came > (waits(socket) ? TURN : HELLO))
        return "this page has not said hello";
    if (socket->begun && now - socket->begun > WHOLE)
        return "a message of this page does not come to its end";
    if (vvi_ration_persists(&peer->ration, now) && now - socket->drained > FLOODS)
        return "this page sends more than the server can take";
    return vvi_client_stuck(socket->client, now);
}

/* It may send again. False: it may not yet, or might all the time. */
static bool resume(vvi_peer *peer, int64_t now)
{
    if (!peer->resumes || now < peer->resumes)
        return false;
    peer->resumes = 0;
    take_rest(peer);
    note_drained(peer, now);
    set_flow(peer);
    return true;
}

int64_t vvi_socket_tick(vvi_peer *peer, int64_t now)
{
    vvi_socket *socket = peer->socket;
    if (socket->code)
        return INT64_MAX;
    const bool resumed = resume(peer, now);
    const char *why = socket->code ? NULL : is_bad(peer, now);
    if (socket->code)
        return INT64_MAX;
    if (why)
        vvi_socket_end(peer, VVI_CLOSE_POLICY, why);
    else if (peer->out && now - peer->moved > STANDS)
        vvi_socket_end(peer, VVI_CLOSE_POLICY, "this page has read nothing for half a minute");
    else {
        listen_for(peer, now);
        look_at_line(peer, now);
    }
    if (!socket->code && (socket->pings || vvi_client_has_more(socket->client, now)))
        lws_callback_on_writable(peer->wsi);
    return resumed ? 0 : peer->resumes ? peer->resumes - now : INT64_MAX; /* what it said may concern others */
}

void vvi_socket_free(vvi_peer *peer)
{
    vvi_socket *socket = peer->socket;
    if (!socket)
        return;
    leave(peer);
    vvi_framing_clear(&socket->framing);
    free(socket->rest);
    free(socket);
    peer->socket = NULL;
}
