#include "server/ration.h"
#include "core/memory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Of a core. Two cores that render lose a tenth to an address that takes all it can. A page that turns takes 0.2 %, and
 * is left as much however many are there. */
#define RATE 0.1
#define RATE_LEAST 0.004
#define RATE_OF_ADDRESS 0.2
/* Seconds that may be spent at once. */
#define BURST 0.25
#define BURST_OF_ADDRESS 1.0
#define SPARING (BURST / 2) /* who has as much left has spent little of late */
#define FULL (0.98 * BURST) /* or next to nothing */
#define BURST_OF_NEWCOMER (SPARING + 0.02)
/* Seconds, of what no clock of this thread sees: the system's work, and others' who are told. */
#define OF_MESSAGE 20e-6
#define OF_BYTE 50e-9
#define OF_CONNECTION 100e-6
/* Of a core, for connections, and seconds at once: a page and its files are a dozen of some 100 microseconds. */
#define RATE_OF_COMING 0.1
#define BURST_OF_COMING 0.25
/* Who says hello is given a view, and pictures of it: an address brings as many at once as look where many do, and then
 * so many a second. */
#define HELLOS_AT_ONCE 200
#define HELLOS 5
#define PERSISTS (INT64_C(30) * 1000000000)
#define SECOND 1e9

typedef struct vvi_ration_place {
    struct vvi_ration_place *next;
    char address[48];
    int n, drawing; /* clients; those of them whose account is not full */
    double left, hellos;
    double spare; /* seconds that those who have spent little may spend though there is nothing left */
    int64_t at;
} place;

double vvi_ration_clock(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Accounts ------------------------------------------------------------------------------------------------------- */

/* What an address gets is shared by those who draw. */
static double rate_of(const vvi_ration *r)
{
    return fmax(RATE_LEAST, fmin(RATE, RATE_OF_ADDRESS / (r->place->drawing > 0 ? r->place->drawing : 1)));
}

static void fill_place(place *p, int64_t now)
{
    const double seconds = (double)(now - p->at) / SECOND;
    p->left = fmin(BURST_OF_ADDRESS, p->left + seconds * RATE_OF_ADDRESS);
    p->spare = fmin(BURST_OF_ADDRESS, p->spare + seconds * RATE_OF_ADDRESS);
    p->hellos = fmin(HELLOS_AT_ONCE, p->hellos + seconds * HELLOS);
    p->at = now;
}

static void set_draws(vvi_ration *r, bool draws)
{
    r->place->drawing += draws - r->draws;
    r->draws = draws;
}

static void fill(vvi_ration *r, int64_t now)
{
    fill_place(r->place, now);
    if (r->greeted)
        r->left = fmin(BURST, r->left + (double)(now - r->at) / SECOND * rate_of(r));
    r->at = now;
    set_draws(r, r->greeted && r->left < BURST);
    if (r->left >= SPARING)
        r->short_since = 0;
}

void vvi_ration_pay(vvi_ration *r, double seconds, size_t bytes, int64_t now)
{
    const double cost = fmax(seconds, 0) + OF_MESSAGE + OF_BYTE * (double)bytes;
    fill(r, now);
    if (r->place->left <= 0)
        r->place->spare = fmax(r->place->spare - cost, 0);
    /* nobody owes more than is soon paid: who was alone has paid nobody */
    r->left = fmax(r->left - cost, -BURST);
    r->place->left = fmax(r->place->left - cost, -BURST_OF_ADDRESS);
    set_draws(r, r->greeted);
}

/* What one must have left to pass though its address has nothing: the more of those there are, the less they may have
 * spent. Else many connections would each spend half of what they may at once. */
static double sparing_of(const place *p)
{
    return FULL - (FULL - SPARING) * fmin(1, p->spare / BURST_OF_ADDRESS);
}

/* Nanoseconds until an account has more than so much. */
static double until(double left, double wanted, double rate)
{
    return left > wanted ? 0 : (wanted - left) / rate * SECOND + 1;
}

int64_t vvi_ration_wait(vvi_ration *r, int64_t now)
{
    fill(r, now);
    const double rate = rate_of(r), own = until(r->left, 0, rate), sparing = until(r->left, sparing_of(r->place), rate),
                 shared = until(r->place->left, 0, RATE_OF_ADDRESS);
    const double wait = r->greeted ? fmax(own, fmin(sparing, shared)) : shared;
    if (wait <= 0 || r->all->n == 1)
        return 0;
    r->short_since = r->short_since ? r->short_since : now;
    return (int64_t)wait + 1000000;
}

int64_t vvi_ration_wait_hello(vvi_ration *r, int64_t now)
{
    fill_place(r->place, now);
    return r->place->hellos >= 1 ? 0 : (int64_t)((1 - r->place->hellos) / HELLOS * SECOND) + 1000000;
}

void vvi_ration_greeted(vvi_ration *r, int64_t now)
{
    fill_place(r->place, now);
    r->place->hellos = fmax(r->place->hellos - 1, 0);
    r->all->n_greeted += !r->greeted;
    r->greeted = true;
    r->at = now;
}

bool vvi_ration_persists(const vvi_ration *r, int64_t now)
{
    return r->short_since && now - r->short_since > PERSISTS;
}

/* Connections ---------------------------------------------------------------------------------------------------- */

static void forgive(vvi_rations *all, int64_t now)
{
    all->owed = fmax(all->owed - (double)(now - all->at) / SECOND * RATE_OF_COMING, 0);
    all->at = now;
}

/* No more than a second's wait: what came while nobody looked holds up nobody. */
void vvi_rations_pay_coming(vvi_rations *all, double seconds, int n, int64_t now)
{
    forgive(all, now);
    all->owed = fmin(all->owed + fmax(seconds, 0) + OF_CONNECTION * n, BURST_OF_COMING + RATE_OF_COMING);
}

int64_t vvi_rations_wait_coming(vvi_rations *all, int64_t now)
{
    forgive(all, now);
    if (all->n_greeted == 0 || all->owed <= BURST_OF_COMING)
        return 0;
    return (int64_t)((all->owed - BURST_OF_COMING) / RATE_OF_COMING * SECOND) + 1000000;
}

/* Places --------------------------------------------------------------------------------------------------------- */

/* Those that nobody is at, and that owe nothing. */
static void drop_places(vvi_rations *all, int64_t now)
{
    for (place **at = &all->first; *at;) {
        place *p = *at;
        fill_place(p, now);
        if (p->n == 0 && fmin(p->left, p->spare) >= BURST_OF_ADDRESS && p->hellos >= HELLOS_AT_ONCE) {
            *at = p->next;
            free(p);
        } else
            at = &p->next;
    }
}

void vvi_rations_clear(vvi_rations *all)
{
    while (all->first) {
        place *next = all->first->next;
        free(all->first);
        all->first = next;
    }
}

static place *place_of(vvi_rations *all, const char *address, int64_t now)
{
    drop_places(all, now);
    for (place *p = all->first; p; p = p->next)
        if (strncmp(p->address, address, sizeof p->address - 1) == 0)
            return p;
    place *p = vvi_calloc(1, sizeof *p);
    if (!p)
        return NULL;
    *p = (place){
        .next = all->first, .left = BURST_OF_ADDRESS, .spare = BURST_OF_ADDRESS, .hellos = HELLOS_AT_ONCE, .at = now};
    snprintf(p->address, sizeof p->address, "%s", address);
    return all->first = p;
}

bool vvi_ration_begin(vvi_ration *r, vvi_rations *all, const char *address, int64_t now)
{
    place *p = place_of(all, address, now);
    if (!p)
        return false;
    *r = (vvi_ration){.all = all, .place = p, .left = BURST_OF_NEWCOMER, .at = now};
    p->n++;
    all->n++;
    return true;
}

void vvi_ration_end(vvi_ration *r, int64_t now)
{
    if (!r->place)
        return;
    set_draws(r, false);
    r->place->n--;
    r->all->n--;
    r->all->n_greeted -= r->greeted;
    drop_places(r->all, now);
    *r = (vvi_ration){.at = now};
}
