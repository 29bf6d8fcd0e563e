/* Where connections come: no more of them are taken than others are left frames beside, but nobody waits long. */
#include "server/server_impl.h"

#include <math.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

/* What TLS takes of a connection before it says anything, seconds. */
#define OF_TLS 1e-3
/* Of a call, where a thousand look; and how fast the newest ones are learned. */
#define OF_CALL_MOST 500e-6
#define NEW_OF_CALL 0.05
/* That are taken before others are looked at: who comes is heard before the next ones could push him out. */
enum { AT_ONCE = 64 };
/* Nanoseconds that who has come waits, at most: then all that wait are taken, whatever that costs. Requests one after
 * the other gain nothing by it, since only one waits at a time; of thousands at once the system keeps those who are
 * let in behind the others, for seconds. */
#define WAIT_MOST (INT64_C(100) * 1000000)

static void open_doors(vvi_server *server, bool open)
{
    server->is_shut = !open;
    for (int i = 0; i < VVI_DOORS && server->doors[i]; i++)
        lws_rx_flow_control(server->doors[i], open);
}

static void know(vvi_server *server, struct lws *door)
{
    int i = 0;
    while (i < VVI_DOORS && server->doors[i] && server->doors[i] != door)
        i++;
    if (i < VVI_DOORS)
        server->doors[i] = door;
}

bool vvi_doors_admit(vvi_server *server, struct lws *door, int64_t now)
{
    know(server, door);
    vvi_rations_pay_coming(&server->rations, server->options.certificate ? OF_TLS : 0, 1, now);
    server->waiting -= server->waiting > 0;
    if (++server->at_once >= AT_ONCE || (server->waiting == 0 && vvi_rations_wait_coming(&server->rations, now) > 0)) {
        open_doors(server, false);
        vvi_server_go_soon(server);
    }
    return server->sockets < server->sockets_most;
}

void vvi_doors_pay(vvi_server *server, double since, int64_t now)
{
    const double seconds = vvi_ration_clock() - since;
    server->paid += seconds;
    vvi_rations_pay_coming(&server->rations, seconds + server->of_call, 0, now);
}

void vvi_doors_pay_visit(vvi_server *server, double seconds, int calls, int64_t now)
{
    vvi_rations_pay_coming(&server->rations, seconds + calls * server->of_call, 0, now);
}

/* What nobody has paid: the system looks at all connections for each call, and more is done for all of them. */
static void learn_of_calls(vvi_server *server)
{
    const double now = vvi_ration_clock(), unpaid = now - server->clock - server->paid;
    if (server->calls > 0 && server->clock > 0 && unpaid > 0)
        server->of_call += NEW_OF_CALL * (fmin(unpaid / server->calls, OF_CALL_MOST) - server->of_call);
    server->clock = now;
    server->paid = 0;
    server->calls = 0;
}

/* libwebsockets opens them whenever a connection has closed. */
void vvi_doors_stay(vvi_server *server)
{
    if (server->is_shut)
        open_doors(server, false);
}

/* Connections that wait in the system's queues. */
static int waiting_at(vvi_server *server)
{
    int n = 0;
    for (int i = 0; i < VVI_DOORS && server->doors[i]; i++) {
        struct tcp_info info;
        socklen_t size = sizeof info;
        const bool is_told = /* a Unix socket, which is its owner's alone, is not asked that */
            getsockopt(lws_get_socket_fd(server->doors[i]), IPPROTO_TCP, TCP_INFO, &info, &size) == 0;
        n += is_told ? (int)info.tcpi_unacked : AT_ONCE; /* of a socket that listens */
    }
    return n;
}

/* Nanoseconds until they may be opened. */
static int64_t wait_at_doors(vvi_server *server, int64_t now)
{
    const int64_t wait = server->waiting > 0 ? 0 : vvi_rations_wait_coming(&server->rations, now),
                  patience = server->emptied + WAIT_MOST - now;
    if (wait <= 0 || patience > 0)
        return wait <= 0 || wait < patience ? wait : patience;
    server->emptied = now;
    server->waiting = waiting_at(server);
    return server->waiting > 0 ? 0 : wait < WAIT_MOST ? wait : WAIT_MOST;
}

int64_t vvi_doors_tick(vvi_server *server, int64_t now)
{
    learn_of_calls(server);
    const int64_t wait = server->is_shut ? wait_at_doors(server, now) : 0;
    if (wait > 0)
        return wait;
    server->at_once = 0;
    if (server->is_shut)
        open_doors(server, true);
    return INT64_MAX;
}
