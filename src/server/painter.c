#include "server/painter.h"
#include "core/memory.h"
#include "core/os.h"
#include "core/status.h"
#include "server/camera.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>
#include <volvis/render.h>
#include <volvis/sys/scene.h>

enum { MOVING_QUALITY = 82, RESTING_QUALITY = 92, READY_SIDE = 32 };
/* Between pictures at rest that are not the last, so that encoding does not hold up rendering. */
#define SECONDS_BETWEEN 0.15
/* A picture at rest has so many seconds of its own at first, and those that move so many times that before it. */
#define SLICE 0.06
#define MOVING_SHARE 3

typedef struct slot {
    bool wanted, fresh;
    vvi_wish wish;
    vvi_painted painted; /* the newest that nobody has taken */
    uint64_t resolved;   /* scene that was told worked out */
    double slice;        /* seconds before the next picture at rest steps aside */
} slot;

struct vvi_painter {
    vv_runtime *runtime;
    void (*wake)(void *user);
    void *user;
    pthread_t thread;
    pthread_mutex_t lock; /* of all that follows */
    pthread_cond_t changed;
    bool ends;
    slot slots[VVI_PAINTER_VIEWS];
    int n_slots;  /* that were ever used */
    int last;     /* view that was rendered last */
    int now;      /* view that is rendered; -1: none */
    bool resting; /* it is at rest */
    bool stale;   /* what is rendered is for nobody any more */
    vv_job *job;
    uint64_t ready; /* scene that quick frames need nothing more for */
    double moved;   /* seconds of moving frames since the last picture at rest */
};

/* One wish being rendered; the painter's thread alone. */
typedef struct painting {
    vvi_painter *painter;
    int at;
    vvi_wish wish;
    vv_world *world; /* with the camera */
    vv_job *job;
    double begin, last;
    bool aside; /* it made room for those that move */
    bool done;  /* nothing better will come */
    bool has_stand;
    vvi_stand stand;
    const char *method;
} painting;

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

/* Frames ---------------------------------------------------------------------------------------------------------- */

/* What an older frame told of poses and scenes is handed on by the one that takes its place. */
static void hand_on(vvi_painted *to, vvi_painted *from)
{
    if (!to->resolved) {
        to->resolved = from->resolved;
        from->resolved = NULL;
    }
    if (!to->has_stand && from->has_stand && to->commit == from->commit) {
        to->has_stand = true;
        to->stand = from->stand;
    }
    vvi_painted_free(from);
}

static void leave(painting *p, vvi_painted *painted)
{
    vvi_painter *painter = p->painter;
    slot *s = &painter->slots[p->at];
    pthread_mutex_lock(&painter->lock);
    const bool wanted = !painter->stale;
    if (wanted && s->fresh && painted->resolved && !painted->bytes) { /* the frame itself still waits */
        free(s->painted.resolved);
        s->painted.resolved = painted->resolved;
    } else if (wanted) {
        hand_on(painted, &s->painted);
        s->painted = *painted;
        s->fresh = true;
    }
    pthread_mutex_unlock(&painter->lock);
    if (wanted)
        painter->wake(painter->user);
    else
        vvi_painted_free(painted);
}

/* Rough frames while something moves; planes need none. */
static bool is_quick(const vvi_wish *wish)
{
    return wish->moving && !wish->plane;
}

static vvi_painted frame_of(const painting *p)
{
    return (vvi_painted){.full = {p->wish.width, p->wish.height},
                         .moving = is_quick(&p->wish),
                         .commit = p->wish.commit,
                         .event = p->wish.event,
                         .has_stand = p->has_stand,
                         .stand = p->stand,
                         .method = p->method};
}

static vv_status encode(painting *p, const vvi_painted *told, const vv_image *image)
{
    vvi_painted painted = *told;
    vv_image_options options;
    vv_image_options_init(&options, sizeof options);
    painted.kind = painted.final ? VVI_PICTURE_PNG : VVI_PICTURE_JPEG;
    options.quality = painted.moving ? MOVING_QUALITY : RESTING_QUALITY;
    options.fast = true;
    painted.size[0] = image->width;
    painted.size[1] = image->height;
    const vv_status st =
        vv_image_encode(&painted.bytes, &painted.n, painted.final ? ".png" : ".jpg", image, &options, p->job);
    if (st != VV_OK)
        return st;
    painted.seconds = vvi_os_seconds() - p->begin;
    leave(p, &painted);
    p->last = vvi_os_seconds();
    return VV_OK;
}

static void show(void *user, const vv_refinement *r)
{
    painting *p = user;
    if (r->final || (r->level < 2 && !p->wish.coarse) ||
        (r->level >= 2 && vvi_os_seconds() - p->last < SECONDS_BETWEEN && p->last > p->begin))
        return;
    vvi_painted painted = frame_of(p);
    painted.level = r->level;
    painted.passes = r->passes;
    encode(p, &painted, r->image);
}

static vv_status render(painting *p)
{
    vv_render_options options;
    vv_render_report report;
    vv_image *image = NULL;
    vv_render_options_init(&options, sizeof options);
    options.on_refined = p->wish.moving ? NULL : show;
    options.user = p;
    vv_status st = vv_render(&image, &report, p->world, p->wish.view, &options, p->job);
    if (st != VV_OK)
        return st;
    vvi_painted painted = frame_of(p);
    painted.level = 2;
    painted.passes = report.passes;
    painted.final = !is_quick(&p->wish);
    painted.method = report.method;
    st = encode(p, &painted, image);
    vv_image_release(image);
    return st;
}

/* Wishes ---------------------------------------------------------------------------------------------------------- */

static vv_status look(painting *p)
{
    const vvi_wish *w = &p->wish;
    const bool quick = is_quick(w);
    vv_status st = VV_OK;
    if (!w->has_pose) {
        st = vvi_camera_world(&p->world, w->world, w->view, NULL, w->width, w->height);
        if (st == VV_OK)
            st = vvi_camera_stand(&p->stand, p->world, w->view, p->job);
        p->has_stand = st == VV_OK;
        if (st == VV_OK && quick) {
            vv_object_release(&p->world->base);
            p->world = NULL;
        }
    }
    if (st != VV_OK || p->world)
        return st;
    const int32_t *size = quick ? w->frame_size : &w->width;
    const int32_t height = quick ? w->frame_size[1] : w->height;
    st = vvi_camera_world(&p->world, w->world, w->view, w->has_pose ? &w->pose : &p->stand.pose, size[0], height);
    return st == VV_OK && quick ? vvi_camera_quick(&p->world, w->view, (double)size[0] / w->width) : st;
}

/* The scene as it is shown, once for each commit but those of cameras. */
static void tell_resolved(painting *p)
{
    vvi_painter *painter = p->painter;
    vvi_painted painted = frame_of(p);
    vv_scene *scene = NULL;
    vv_world *fixed = NULL;
    pthread_mutex_lock(&painter->lock);
    const bool known = painter->slots[p->at].resolved == p->wish.scene;
    pthread_mutex_unlock(&painter->lock);
    if (p->wish.moving || known)
        return;
    if (vv_scene_resolve(&scene, p->world, p->wish.view, p->job) == VV_OK && vv_scene_fix(&fixed, scene) == VV_OK &&
        vv_scene_print(&painted.resolved, fixed, NULL) == VV_OK) {
        pthread_mutex_lock(&painter->lock);
        painter->slots[p->at].resolved = p->wish.scene;
        pthread_mutex_unlock(&painter->lock);
        leave(p, &painted);
    }
    if (fixed)
        vv_object_release(&fixed->base);
    vv_scene_release(scene);
}

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

static bool is_idle(vvi_painter *painter)
{
    pthread_mutex_lock(&painter->lock);
    const bool idle = !painter->ends && next_wish(painter) < 0;
    pthread_mutex_unlock(&painter->lock);
    return idle;
}

/* What only quick frames need (fewer samples, tables) is made while nobody waits, by a small one that nobody sees: the
 * first motion finds it there. */
static void make_ready(painting *p)
{
    vvi_painter *painter = p->painter;
    const vvi_wish *w = &p->wish;
    vv_world *world = NULL;
    vv_image *image = NULL;
    if (w->moving || painter->ready == w->scene || !is_idle(painter))
        return;
    if (vvi_camera_world(&world, w->world, w->view, w->has_pose ? &w->pose : &p->stand.pose, READY_SIDE, READY_SIDE) ==
            VV_OK &&
        vvi_camera_quick(&world, w->view, (double)READY_SIDE / w->width) == VV_OK &&
        vv_render(&image, NULL, world, w->view, NULL, p->job) == VV_OK)
        painter->ready = w->scene;
    vv_image_release(image);
    if (world)
        vv_object_release(&world->base);
}

static void tell_failure(painting *p, vv_status st)
{
    vvi_painted painted = frame_of(p);
    if (st == VV_OK || st == VV_E_CANCELLED)
        return;
    painted.error = vvi_strdup(vv_error_last()->message);
    leave(p, &painted);
}

static void paint(painting *p)
{
    p->begin = p->last = vvi_os_seconds();
    vv_status st = look(p);
    if (st == VV_OK && !p->wish.unseen) {
        st = render(p);
    } else if (st == VV_OK) {
        vvi_painted painted = frame_of(p);
        leave(p, &painted);
    }
    tell_failure(p, st);
    if (st == VV_OK) {
        p->done = true;
        tell_resolved(p);
        make_ready(p);
    }
    if (p->world)
        vv_object_release(&p->world->base);
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
            paint(&p);
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
        return vv_fail(VV_E_MEMORY, "the system gives no thread to render with");
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
