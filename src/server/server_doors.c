/* Where connections come: no more of them are taken than others are left frames beside. */
#include "server/server_impl.h"

#include <math.h>

/* What TLS takes of a connection before it says anything, seconds. */
#define OF_TLS 1e-3
/* Of a call, where a thousand look; and how fast the newest ones are learned. */
#define OF_CALL_MOST 500e-6
#define NEW_OF_CALL 0.05
/* That are taken before others are looked at: who comes is heard before the next ones could push him out. */
enum { AT_ONCE = 64 };

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
    if (++server->at_once >= AT_ONCE || vvi_rations_wait_coming(&server->rations, now) > 0) {
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

int64_t vvi_doors_tick(vvi_server *server, int64_t now)
{
    learn_of_calls(server);
    const int64_t wait = server->is_shut ? vvi_rations_wait_coming(&server->rations, now) : 0;
    if (wait > 0)
        return wait;
    server->at_once = 0;
    if (server->is_shut)
        open_doors(server, true);
    return INT64_MAX;
}
