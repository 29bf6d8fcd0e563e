/* Whose turn it is, and the threads. */
#include "core/job.h"
#include "core/memory.h"
#include "core/os.h"
#include "core/status.h"
#include "server/painter_impl.h"

#include <math.h>
#include <stdlib.h>
#include <volvis/image.h>

enum {
    PLANE_MOST = 1 << 22, /* pixels of a plane that is drawn exactly at once */
    DRAFT_MOST = 1 << 18, /* of a draft, where few wait for one */
    DRAFT_LEAST = 1 << 14,
    FEW = 4
};

void vvi_painted_free(vvi_painted *painted)
{
    vv_image_bytes_free(painted->bytes);
    free(painted->resolved);
    free(painted->error);
    free(painted->where);
    free(painted->warnings);
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

/* What is quickly done, and urgent: frames of views that move, planes, and cameras alone. */
static bool is_light(const vvi_wish *w)
{
    return w->unseen || (w->moving && (!w->plane || (int64_t)w->width * w->height <= PLANE_MOST));
}

/* A view that shows nothing yet gets a draft where the brush for pictures at rest is busy with others, would have to
 * leave its threads to quick frames, or takes long for the coarsest. */
static bool needs_draft(const vvi_painter *painter, const vvi_wish *w)
{
    return !is_light(w) && w->coarse &&
           (painter->brushes[FINE].now >= 0 || painter->hurries || (int64_t)w->width * w->height > PLANE_MOST);
}

typedef enum wish_kind { LIGHT, DRAFT, ANY } wish_kind;

static bool is_of(const vvi_painter *painter, int at, wish_kind kind)
{
    const vvi_wish *w = &painter->slots[at].wish;
    if (!painter->slots[at].wanted || painter->brushes[QUICK].now == at || painter->brushes[FINE].now == at)
        return false; /* frames of one view come in the order of its wishes */
    return kind == LIGHT   ? is_light(w)
           : kind == DRAFT ? needs_draft(painter, w)
                           : !is_light(w) && !needs_draft(painter, w);
}

/* Whether quick frames are being made, or wished. */
static bool hurries(const vvi_painter *painter)
{
    bool found = painter->brushes[QUICK].now >= 0;
    for (int i = 0; i < painter->n_slots && !found; i++)
        found = painter->slots[i].wanted && is_light(&painter->slots[i].wish);
    return found;
}

/* The next view in turn that wishes something of a kind; -1: none. */
static int next_of(const vvi_painter *painter, int last, wish_kind kind)
{
    for (int i = 1; i <= painter->n_slots; i++)
        if (is_of(painter, (last + i) % painter->n_slots, kind))
            return (last + i) % painter->n_slots;
    return -1;
}

/* The one of them that has had least of the thread's time; of those who have had as much, the next in turn. */
static int thriftiest_of(const vvi_painter *painter, int last, wish_kind kind)
{
    int found = -1;
    for (int i = 1; i <= painter->n_slots; i++) {
        const int at = (last + i) % painter->n_slots;
        if (is_of(painter, at, kind) && (found < 0 || painter->slots[at].used < painter->slots[found].used))
            found = at;
    }
    return found;
}

static int next_wish(bool *draft_out, const brush *b)
{
    vvi_painter *painter = b->painter;
    painter->hurries = hurries(painter);
    *draft_out = false;
    if (b == &painter->brushes[FINE])
        return next_of(painter, b->last, ANY);
    const int light = thriftiest_of(painter, b->last, LIGHT), draft = next_of(painter, b->last, DRAFT);
    *draft_out = draft >= 0 && (light < 0 || !b->drafted);
    return *draft_out ? draft : light;
}

bool vvi_painter_is_idle(vvi_painter *painter)
{
    pthread_mutex_lock(&painter->lock);
    bool idle = !painter->ends;
    for (int i = 0; i < painter->n_slots; i++)
        idle &= !painter->slots[i].wanted;
    pthread_mutex_unlock(&painter->lock);
    return idle;
}

/* The threads ----------------------------------------------------------------------------------------------------- */

/* Smaller where many wait: all see something soon. */
static void size_draft(painting *p)
{
    const vvi_painter *painter = p->painter;
    int n = 1;
    for (int i = 0; i < painter->n_slots; i++)
        n += is_of(painter, i, DRAFT);
    const double most = fmax(DRAFT_MOST / fmax(1, (double)n / FEW), DRAFT_LEAST);
    const double scale = fmin(1, sqrt(most / ((double)p->wish.width * p->wish.height)));
    p->draft_size[0] = (int32_t)fmax(1, round(scale * p->wish.width));
    p->draft_size[1] = (int32_t)fmax(1, round(scale * p->wish.height));
}

static int count_looking(const vvi_painter *painter)
{
    int n = 0;
    for (int i = 0; i < painter->n_slots; i++)
        n += painter->slots[i].wanted || painter->slots[i].resolved != 0;
    return n;
}

/* Waits for a wish and takes it; false at the end. */
static bool take_wish(painting *p, brush *b)
{
    vvi_painter *painter = b->painter;
    bool found = false;
    pthread_mutex_lock(&painter->lock);
    while (!painter->ends && !found) {
        bool draft;
        const int at = next_wish(&draft, b);
        found = at >= 0;
        if (!found) {
            pthread_cond_wait(&painter->changed, &painter->lock);
            continue;
        }
        slot *s = &painter->slots[at];
        *p = (painting){.painter = painter, .brush = b, .at = at, .wish = s->wish, .draft = draft};
        p->n_looking = count_looking(painter);
        s->wish.world = NULL;
        s->wanted = false;
        b->last = b->now = at;
        b->drafted = draft;
        if (b == &painter->brushes[QUICK])
            painter->reached = fmax(painter->reached, s->used);
        b->began = vvi_os_seconds();
        b->moving = p->wish.moving;
        b->stale = false;
        if (draft)
            size_draft(p);
        if (vv_job_new(&b->job, painter->runtime, NULL, NULL) != VV_OK)
            b->job = NULL;
        if (b == &painter->brushes[QUICK])
            vvi_job_set_urgent(b->job);
        p->job = b->job;
        pthread_cond_broadcast(&painter->changed); /* others need drafts now */
    }
    pthread_mutex_unlock(&painter->lock);
    return found;
}

/* What was drafted is painted, unless something else is wished by now. Under the lock. */
static void wish_for_all_of_it(painting *p, slot *s)
{
    s->wish = p->wish;
    s->wish.coarse = false;
    s->wanted = true;
    p->wish.world = NULL;
}

static void end_wish(painting *p)
{
    brush *b = p->brush;
    vvi_painter *painter = p->painter;
    slot *s = &painter->slots[p->at];
    pthread_mutex_lock(&painter->lock);
    if (p->draft && !s->wanted && !b->stale && !vv_job_cancelled(p->job))
        wish_for_all_of_it(p, s);
    if (b == &painter->brushes[QUICK])
        s->used += vvi_os_seconds() - b->began;
    b->now = -1;
    b->job = NULL;
    pthread_cond_broadcast(&painter->changed);
    pthread_mutex_unlock(&painter->lock);
    vv_job_release(p->job);
    if (p->wish.world)
        vv_object_release(&p->wish.world->base);
}

static void *run(void *user)
{
    painting p;
    const brush *b = user;
    vvi_os_name_thread(b == &b->painter->brushes[QUICK] ? "vv-quick" : "vv-fine");
    while (take_wish(&p, user)) {
        if (p.job)
            vvi_painting_paint(&p);
        end_wish(&p);
    }
    return NULL;
}

/* Ends the first n threads. */
static void end_threads(vvi_painter *painter, int n)
{
    pthread_mutex_lock(&painter->lock);
    painter->ends = true;
    for (int i = 0; i < n; i++) {
        painter->brushes[i].stale = true;
        if (painter->brushes[i].job)
            vv_job_cancel(painter->brushes[i].job);
    }
    pthread_cond_broadcast(&painter->changed);
    pthread_mutex_unlock(&painter->lock);
    for (int i = 0; i < n; i++)
        pthread_join(painter->brushes[i].thread, NULL);
}

static void destroy(vvi_painter *painter)
{
    for (int i = 0; i < painter->n_slots; i++) {
        drop_wish(&painter->slots[i]);
        vvi_painted_free(&painter->slots[i].painted);
    }
    vvi_shelf_clear(&painter->shelf);
    pthread_mutex_destroy(&painter->lock);
    pthread_cond_destroy(&painter->changed);
    vv_runtime_release(painter->runtime);
    free(painter);
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
    pthread_mutex_init(&painter->lock, NULL);
    pthread_cond_init(&painter->changed, NULL);
    for (int i = 0; i < BRUSHES; i++)
        painter->brushes[i] = (brush){.painter = painter, .now = -1};
    for (int i = 0; i < BRUSHES; i++) {
        if (pthread_create(&painter->brushes[i].thread, NULL, run, &painter->brushes[i]) == 0)
            continue;
        end_threads(painter, i);
        destroy(painter);
        return vv_fail(VV_E_MEMORY, "the system cannot start a thread to render with");
    }
    *out = painter;
    return VV_OK;
}

void vvi_painter_free(vvi_painter *painter)
{
    if (!painter)
        return;
    end_threads(painter, BRUSHES);
    destroy(painter);
}

/* A picture at rest, or the draft of one, that is being rendered for a view is not wanted any more. A quick frame is
 * worth its end: else a hand that moves all the time would see none. Under the lock. */
static void leave_off(vvi_painter *painter, int at)
{
    for (int i = 0; i < BRUSHES; i++)
        if (painter->brushes[i].now == at && !painter->brushes[i].moving && painter->brushes[i].job)
            vv_job_cancel(painter->brushes[i].job);
}

void vvi_painter_want(vvi_painter *painter, int at, const vvi_wish *wish)
{
    pthread_mutex_lock(&painter->lock);
    slot *s = &painter->slots[at];
    if (!s->wanted) /* what it did not use while it wished nothing is nobody's */
        s->used = fmax(s->used, painter->reached);
    drop_wish(s);
    s->wish = *wish;
    vv_object_retain(&wish->world->base);
    s->wanted = true;
    painter->n_slots = at >= painter->n_slots ? at + 1 : painter->n_slots;
    leave_off(painter, at);
    pthread_cond_broadcast(&painter->changed);
    pthread_mutex_unlock(&painter->lock);
}

void vvi_painter_rest(vvi_painter *painter, int at)
{
    pthread_mutex_lock(&painter->lock);
    drop_wish(&painter->slots[at]);
    leave_off(painter, at);
    pthread_mutex_unlock(&painter->lock);
}

bool vvi_painter_is_free(vvi_painter *painter, int at)
{
    pthread_mutex_lock(&painter->lock);
    const bool is_free = painter->brushes[QUICK].now != at && painter->brushes[FINE].now != at;
    pthread_mutex_unlock(&painter->lock);
    return is_free;
}

void vvi_painter_forget(vvi_painter *painter, int at)
{
    pthread_mutex_lock(&painter->lock);
    drop_wish(&painter->slots[at]);
    vvi_painted_free(&painter->slots[at].painted);
    painter->slots[at].fresh = false;
    painter->slots[at].resolved = 0;
    painter->slots[at].used = 0;
    for (int i = 0; i < BRUSHES; i++) {
        if (painter->brushes[i].now != at)
            continue;
        painter->brushes[i].stale = true;
        if (painter->brushes[i].job)
            vv_job_cancel(painter->brushes[i].job);
    }
    pthread_mutex_unlock(&painter->lock);
}

void vvi_painter_count_rays(vvi_painter_rays *out, vvi_painter *painter)
{
    pthread_mutex_lock(&painter->lock);
    *out = (vvi_painter_rays){painter->n_cast, painter->n_kept};
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
