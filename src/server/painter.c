/* Whose turn it is, and the thread. */
#include "core/memory.h"
#include "core/os.h"
#include "core/status.h"
#include "server/painter_impl.h"

#include <stdlib.h>
#include <volvis/image.h>

/* A picture at rest has so many seconds of its own at first, and those that move so many times that before it. */
#define SLICE 0.06
#define MOVING_SHARE 3

void vvi_painted_free(vvi_painted *painted)
{
    vv_image_bytes_free(painted->bytes);
    free(painted->resolved);
    free(painted->error);
    *painted = (vvi_painted){.n = 0};
}

static void drop_wish(slot *s)
{
    if (s->wish.world)
        vv_object_release(&s->wish.world->base);
    s->wish = (vvi_wish){.world = NULL};
    s->wanted = false;
}

/* Wishes ---------------------------------------------------------------------------------------------------------- */

/* The next view in turn that wishes a frame of a kind; -1: none. Under the lock. */
static int next_of(const vvi_painter *painter, bool moving)
{
    for (int i = 1; i <= painter->n_slots; i++) {
        const int at = (painter->last + i) % painter->n_slots;
        if (painter->slots[at].wanted && painter->slots[at].wish.moving == moving)
            return at;
    }
    return -1;
}

/* Under the lock. */
static int next_wish(const vvi_painter *painter)
{
    const int moving = next_of(painter, true), resting = next_of(painter, false);
    if (moving < 0 || resting < 0)
        return moving < 0 ? resting : moving;
    return painter->moved >= MOVING_SHARE * painter->slots[resting].slice ? resting : moving;
}

bool vvi_painter_is_idle(vvi_painter *painter)
{
    pthread_mutex_lock(&painter->lock);
    const bool idle = !painter->ends && next_wish(painter) < 0;
    pthread_mutex_unlock(&painter->lock);
    return idle;
}

/* The thread ------------------------------------------------------------------------------------------------------ */

static bool keeps_on(void *user, const vv_progress *progress)
{
    painting *p = user;
    vvi_painter *painter = p->painter;
    (void)progress;
    if (p->wish.moving || p->done)
        return true;
    pthread_mutex_lock(&painter->lock);
    p->aside = vvi_os_seconds() - p->begin > painter->slots[p->at].slice && next_of(painter, true) >= 0;
    pthread_mutex_unlock(&painter->lock);
    return !p->aside;
}

/* Waits for a wish and takes it; false at the end. */
static bool take_wish(painting *p, vvi_painter *painter)
{
    bool found = false;
    pthread_mutex_lock(&painter->lock);
    while (!painter->ends && !found) {
        const int at = next_wish(painter);
        found = at >= 0;
        if (!found) {
            pthread_cond_wait(&painter->changed, &painter->lock);
            continue;
        }
        slot *s = &painter->slots[at];
        *p = (painting){.painter = painter, .at = at, .wish = s->wish};
        s->wish.world = NULL;
        s->wanted = false;
        painter->last = painter->now = at;
        painter->resting = !p->wish.moving;
        painter->stale = false;
        if (vv_job_new(&painter->job, painter->runtime, keeps_on, p) != VV_OK)
            painter->job = NULL;
        p->job = painter->job;
    }
    pthread_mutex_unlock(&painter->lock);
    return found;
}

/* Under the lock. */
static void put_back(painting *p, slot *s)
{
    s->slice *= 2;
    s->wish = p->wish;
    s->wish.coarse &= p->last <= p->begin; /* else it was shown */
    s->wanted = true;
    p->wish.world = NULL;
}

static void end_wish(painting *p)
{
    vvi_painter *painter = p->painter;
    slot *s = &painter->slots[p->at];
    pthread_mutex_lock(&painter->lock);
    if (p->wish.moving)
        painter->moved += vvi_os_seconds() - p->begin;
    else
        painter->moved = 0;
    if (p->aside && !p->done && !s->wanted && !painter->stale)
        put_back(p, s);
    painter->now = -1;
    painter->job = NULL;
    pthread_mutex_unlock(&painter->lock);
    vv_job_release(p->job);
    if (p->wish.world)
        vv_object_release(&p->wish.world->base);
}

static void *run(void *user)
{
    painting p;
    vvi_os_name_thread("vv-painter");
    while (take_wish(&p, user)) {
        if (p.job)
            vvi_painting_paint(&p);
        end_wish(&p);
    }
    return NULL;
}

vv_status vvi_painter_new(vvi_painter **out, vv_runtime *runtime, void (*wake)(void *user), void *user)
{
    vvi_painter *painter = vvi_calloc(1, sizeof *painter);
    *out = NULL;
    if (!painter)
        return vv_fail_memory(sizeof *painter);
    painter->runtime = vv_runtime_retain(runtime);
    painter->wake = wake;
    painter->user = user;
    painter->now = -1;
    pthread_mutex_init(&painter->lock, NULL);
    pthread_cond_init(&painter->changed, NULL);
    if (pthread_create(&painter->thread, NULL, run, painter) != 0) {
        vv_runtime_release(runtime);
        free(painter);
        return vv_fail(VV_E_MEMORY, "the system cannot start a thread to render with");
    }
    *out = painter;
    return VV_OK;
}

void vvi_painter_free(vvi_painter *painter)
{
    if (!painter)
        return;
    pthread_mutex_lock(&painter->lock);
    painter->ends = painter->stale = true;
    if (painter->job)
        vv_job_cancel(painter->job);
    pthread_cond_signal(&painter->changed);
    pthread_mutex_unlock(&painter->lock);
    pthread_join(painter->thread, NULL);
    for (int i = 0; i < painter->n_slots; i++) {
        drop_wish(&painter->slots[i]);
        vvi_painted_free(&painter->slots[i].painted);
    }
    pthread_mutex_destroy(&painter->lock);
    pthread_cond_destroy(&painter->changed);
    vv_runtime_release(painter->runtime);
    free(painter);
}

void vvi_painter_want(vvi_painter *painter, int at, const vvi_wish *wish)
{
    pthread_mutex_lock(&painter->lock);
    slot *s = &painter->slots[at];
    drop_wish(s);
    s->wish = *wish;
    vv_object_retain(&wish->world->base);
    s->wanted = true;
    s->slice = SLICE;
    painter->n_slots = at >= painter->n_slots ? at + 1 : painter->n_slots;
    /* a quick frame is worth its end: else a hand that moves all the time would see none */
    if (painter->now == at && painter->resting && painter->job)
        vv_job_cancel(painter->job);
    pthread_cond_signal(&painter->changed);
    pthread_mutex_unlock(&painter->lock);
}

void vvi_painter_rest(vvi_painter *painter, int at)
{
    pthread_mutex_lock(&painter->lock);
    drop_wish(&painter->slots[at]);
    if (painter->now == at && painter->resting && painter->job)
        vv_job_cancel(painter->job);
    pthread_mutex_unlock(&painter->lock);
}

void vvi_painter_forget(vvi_painter *painter, int at)
{
    pthread_mutex_lock(&painter->lock);
    drop_wish(&painter->slots[at]);
    vvi_painted_free(&painter->slots[at].painted);
    painter->slots[at].fresh = false;
    painter->slots[at].resolved = 0;
    if (painter->now == at) {
        painter->stale = true;
        if (painter->job)
            vv_job_cancel(painter->job);
    }
    pthread_mutex_unlock(&painter->lock);
}

bool vvi_painter_take(vvi_painted *out, vvi_painter *painter, int at)
{
    pthread_mutex_lock(&painter->lock);
    slot *s = &painter->slots[at];
    const bool fresh = s->fresh;
    if (fresh) {
        *out = s->painted;
        s->painted = (vvi_painted){.n = 0};
        s->fresh = false;
    }
    pthread_mutex_unlock(&painter->lock);
    return fresh;
}
