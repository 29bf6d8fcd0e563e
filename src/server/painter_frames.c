/* One wish: what is looked at, rendered, encoded and left for whoever takes it. */
#include "core/memory.h"
#include "core/os.h"
#include "core/status.h"
#include "render/picture_depends.h"
#include "server/painter_impl.h"

#include <math.h>
#include <stdlib.h>
#include <volvis/image.h>
#include <volvis/render.h>
#include <volvis/sys/scene.h>

enum { MOVING_QUALITY = 82, RESTING_QUALITY = 92, READY_SIDE = 32 };
/* What a picture takes while it is drawn and encoded; those of a screen of 5120 x 2880 are drawn as they are. */
enum { PIXEL_BYTES = 56, PIXELS_MOST = 1 << 24, PIXELS_SHARED = 3 << 20, PIXELS_LEAST = 1 << 16 };
/* Of the memory limit: what is kept of pictures that were left. */
enum { SHELF_SHARE = 16 };
/* Between pictures at rest that are not the last, so that encoding does not hold up rendering. */
#define SECONDS_BETWEEN 0.15

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
    vvi_warnings_add(&to->warnings, from->warnings);
    from->warnings = NULL;
    vvi_painted_free(from);
}

static void leave(painting *p, vvi_painted *painted)
{
    vvi_painter *painter = p->painter;
    slot *s = &painter->slots[p->at];
    pthread_mutex_lock(&painter->lock);
    const bool wanted = !p->brush->stale;
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

/* Rough frames while something moves, and drafts; planes need none but drafts. */
static bool is_quick(const painting *p)
{
    return p->draft || (p->wish.moving && !p->wish.plane);
}

static vvi_painted frame_of(const painting *p)
{
    return (vvi_painted){.full = {p->wish.width, p->wish.height},
                         .moving = is_quick(p) && !p->draft,
                         .commit = p->wish.commit,
                         .number = p->wish.number,
                         .event = p->wish.event,
                         .has_stand = p->has_stand,
                         .stand = p->stand,
                         .method = p->method};
}

static vv_status encode_as(vvi_painted *painted, vvi_picture_kind kind, int quality, const vv_image *image, vv_job *job)
{
    vv_image_options options;
    vv_image_options_init(&options, sizeof options);
    options.quality = quality;
    options.fast = true;
    vv_image_bytes_free(painted->bytes);
    painted->bytes = NULL;
    painted->kind = kind;
    return vv_image_encode(&painted->bytes, &painted->n, kind == VVI_PICTURE_PNG ? ".png" : ".jpg", image, &options,
                           job);
}

/* For a thin line: the best picture that it carries in a fifth of the time that it may take without loss. */
static vv_status reduce(vvi_painted *painted, size_t most, const vv_image *image, vv_job *job)
{
    static const int qualities[] = {RESTING_QUALITY, 70, 40, 20};
    vv_status st = VV_OK;
    for (size_t i = 0; i < sizeof qualities / sizeof *qualities && st == VV_OK && (!i || painted->n > most); i++)
        st = encode_as(painted, VVI_PICTURE_JPEG, qualities[i], image, job);
    return st;
}

static vv_status encode(painting *p, const vvi_painted *told, const vv_image *image)
{
    vvi_painted painted = *told;
    painted.size[0] = image->width;
    painted.size[1] = image->height;
    vv_status st = encode_as(&painted, painted.final ? VVI_PICTURE_PNG : VVI_PICTURE_JPEG,
                             painted.moving ? MOVING_QUALITY : RESTING_QUALITY, image, p->job);
    painted.whole = painted.n;
    const size_t soon = p->wish.bytes_most / 5, most = painted.final ? p->wish.bytes_most : soon;
    painted.reduced = st == VV_OK && !painted.moving && soon && painted.n > most;
    if (painted.reduced)
        st = reduce(&painted, soon, image, p->job);
    if (st != VV_OK)
        return st;
    painted.seconds = vvi_os_seconds() - p->begin;
    leave(p, &painted);
    p->last = vvi_os_seconds();
    return VV_OK;
}

/* What is there, unless the last one was shown just now, or is better than that. */
static vv_status show(painting *p, vv_picture *picture)
{
    vv_render_report report;
    vv_image *image;
    const int level = vv_picture_level(picture);
    if (level < 0 || (level < 2 && !p->wish.coarse) ||
        (level == 2 && vvi_os_seconds() - p->last < SECONDS_BETWEEN && p->last > p->begin))
        return VV_OK;
    vv_status st = vv_picture_look(&image, picture, p->job);
    if (st != VV_OK)
        return st;
    vvi_painted painted = frame_of(p);
    vv_picture_report(&report, picture);
    painted.level = level;
    painted.passes = report.passes;
    st = encode(p, &painted, image);
    vv_image_release(image);
    return st;
}

static vv_status leave_last(painting *p, const vv_image *image, const vv_render_report *report)
{
    vvi_painted painted = frame_of(p);
    painted.level = p->draft ? 0 : 2;
    painted.passes = report->passes;
    painted.final = !is_quick(p);
    painted.method = report->method;
    return encode(p, &painted, image);
}

static vv_status render_at_once(painting *p)
{
    vv_render_report report;
    vv_image *image = NULL;
    vv_status st = vv_render(&image, &report, p->world, p->wish.view, NULL, p->job);
    if (st == VV_OK)
        st = leave_last(p, image, &report);
    vv_image_release(image);
    return st;
}

static void count_rays(vvi_painter *painter, uint64_t kept, uint64_t cast)
{
    pthread_mutex_lock(&painter->lock);
    painter->n_kept += kept;
    painter->n_cast += cast;
    pthread_mutex_unlock(&painter->lock);
}

static vv_status step(painting *p, vv_picture *picture)
{
    vv_picture_until until;
    const uint64_t before = picture->got.counts.rays;
    vv_picture_until_init(&until, sizeof until);
    until.better = true;
    const vv_status st = vv_picture_step(picture, &until, p->job);
    count_rays(p->painter, 0, picture->got.counts.rays - before);
    return st;
}

/* Better and better ones, to the last. */
static vv_status refine(painting *p, vv_picture *picture)
{
    vv_render_report report;
    vv_image *image;
    vv_status st = vv_picture_is_whole(picture) ? VV_OK : show(p, picture); /* of one that is taken up */
    while (st == VV_OK && !vv_picture_is_whole(picture))
        if ((st = step(p, picture)) == VV_OK && !vv_picture_is_whole(picture))
            st = show(p, picture);
    if (st != VV_OK || (st = vv_picture_look(&image, picture, p->job)) != VV_OK)
        return st;
    vv_picture_report(&report, picture);
    st = leave_last(p, image, &report);
    vv_image_release(image);
    return st;
}

/* Where memory is short, for what is kept of others none is there. */
static vv_status new_picture(vv_picture **out, painting *p)
{
    const vv_status st = vv_picture_new(out, p->world, p->wish.view, true, p->job);
    if (st != VV_E_LIMIT && st != VV_E_MEMORY)
        return st;
    vvi_shelf_clear(&p->painter->shelf);
    return vv_picture_new(out, p->world, p->wish.view, true, p->job);
}

/* A picture at rest: goes on with one that was left, and is left for the next one. */
static vv_status render_at_rest(painting *p)
{
    vvi_shelf *shelf = &p->painter->shelf;
    vv_picture *picture;
    uint64_t depends = 0;
    vv_status st = new_picture(&picture, p);
    if (st != VV_OK)
        return st;
    if ((st = vvi_picture_depends(&depends, picture, false, p->job)) == VV_OK) {
        if (vvi_shelf_take(shelf, depends, picture))
            count_rays(p->painter, picture->got.counts.rays, 0);
        st = refine(p, picture);
        if (st == VV_OK || st == VV_E_CANCELLED)
            vvi_shelf_put(shelf, depends, picture, vv_runtime_memory_limit(p->painter->runtime) / SHELF_SHARE);
    }
    vv_picture_free(picture);
    return st;
}

/* Looking -------------------------------------------------------------------------------------------------------- */

/* Of the frame: a picture takes a quarter of the memory that there may be at most, and 900 MiB, which all that look
 * share, down to what a window on most screens needs. What is larger is drawn smaller, as what moves is. */
static void size_frame(int32_t out[2], const painting *p)
{
    const vvi_wish *w = &p->wish;
    const int32_t at_rest[2] = {w->width, w->height};
    const int32_t *size = p->draft ? p->draft_size : is_quick(p) ? w->frame_size : at_rest;
    const double room = (double)vv_runtime_memory_limit(p->painter->runtime) / 4 / PIXEL_BYTES;
    const double shared = fmax((double)PIXELS_MOST / (p->n_looking > 1 ? p->n_looking : 1), PIXELS_SHARED);
    const double most = fmax(fmin(room, shared), PIXELS_LEAST), pixels = (double)size[0] * size[1];
    const double scale = fmin(1, sqrt(most / pixels));
    for (int a = 0; a < 2; a++)
        out[a] = scale < 1 ? (int32_t)fmax(1, floor(scale * size[a])) : size[a];
}

static vv_status look(painting *p)
{
    const vvi_wish *w = &p->wish;
    const bool quick = is_quick(p);
    vv_status st = VV_OK;
    int32_t size[2];
    size_frame(size, p);
    const bool smaller = size[0] != w->width || size[1] != w->height;
    if (!w->has_pose) {
        st = vvi_camera_world(&p->world, w->world, w->view, NULL, w->width, w->height);
        if (st == VV_OK)
            st = vvi_camera_stand(&p->stand, p->world, w->view, p->job);
        p->has_stand = st == VV_OK;
        if (st == VV_OK && (quick || smaller)) {
            vv_object_release(&p->world->base);
            p->world = NULL;
        }
    }
    if (st != VV_OK || p->world)
        return st;
    const double scale = (double)size[0] / w->width;
    st = vvi_camera_world(&p->world, w->world, w->view, w->has_pose ? &w->pose : &p->stand.pose, size[0], size[1]);
    if (st == VV_OK && quick)
        st = vvi_camera_quick(&p->world, w->view, scale);
    else if (st == VV_OK && smaller)
        st = vvi_camera_scale(&p->world, w->view, scale);
    return st;
}

/* The scene as it is shown, once for each commit but those of cameras. */
static void tell_resolved(painting *p)
{
    vvi_painter *painter = p->painter;
    vvi_painted painted = frame_of(p);
    vv_scene *scene = NULL;
    vv_world *fixed = NULL, *whole = NULL; /* as large as it is looked at */
    pthread_mutex_lock(&painter->lock);
    const bool known = painter->slots[p->at].resolved == p->wish.scene;
    pthread_mutex_unlock(&painter->lock);
    if (p->wish.moving || known)
        return;
    if (vvi_camera_world(&whole, p->wish.world, p->wish.view, p->wish.has_pose ? &p->wish.pose : NULL, p->wish.width,
                         p->wish.height) == VV_OK &&
        vv_scene_resolve(&scene, whole, p->wish.view, p->job) == VV_OK && vv_scene_fix(&fixed, scene) == VV_OK &&
        vv_scene_print(&painted.resolved, fixed, NULL) == VV_OK) {
        pthread_mutex_lock(&painter->lock);
        painter->slots[p->at].resolved = p->wish.scene;
        pthread_mutex_unlock(&painter->lock);
        leave(p, &painted);
    }
    if (fixed)
        vv_object_release(&fixed->base);
    vv_scene_release(scene);
    if (whole)
        vv_object_release(&whole->base);
}

/* What only quick frames need (fewer samples, tables) is made while nobody waits, by a small one that nobody sees: the
 * first motion finds it there. */
static void make_ready(painting *p)
{
    vvi_painter *painter = p->painter;
    const vvi_wish *w = &p->wish;
    vv_world *world = NULL;
    vv_image *image = NULL;
    if (w->moving || painter->ready == w->scene || !vvi_painter_is_idle(painter))
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
    const vv_error *error = vv_error_last();
    if (st == VV_OK || st == VV_E_CANCELLED)
        return;
    painted.error = vvi_strdup(error->message);
    painted.where = error->where && !error->file ? vvi_strdup(error->where) : NULL;
    leave(p, &painted);
}

/* With the frame that waits, or without one. */
static void tell_warnings(painting *p)
{
    vvi_painter *painter = p->painter;
    slot *s = &painter->slots[p->at];
    if (!p->warnings)
        return;
    pthread_mutex_lock(&painter->lock);
    const bool wanted = !p->brush->stale;
    if (wanted) {
        vvi_warnings_add(&s->painted.warnings, p->warnings);
        s->fresh = true;
    }
    pthread_mutex_unlock(&painter->lock);
    if (wanted)
        painter->wake(painter->user);
    else
        free(p->warnings);
    p->warnings = NULL;
}

void vvi_painting_paint(painting *p)
{
    vvi_warnings_gather(&p->warnings, p->job);
    p->begin = p->last = vvi_os_seconds();
    vv_status st = look(p);
    if (st == VV_OK && !p->wish.unseen) {
        st = p->wish.moving || p->draft ? render_at_once(p) : render_at_rest(p);
    } else if (st == VV_OK) {
        vvi_painted painted = frame_of(p);
        leave(p, &painted);
    }
    tell_failure(p, st);
    if (st == VV_OK) {
        if (!p->draft)
            tell_resolved(p);
        if (p->brush == &p->painter->brushes[FINE])
            make_ready(p);
    }
    tell_warnings(p);
    if (p->world)
        vv_object_release(&p->world->base);
}
