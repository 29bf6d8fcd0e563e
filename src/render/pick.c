/* Picking: one ray for each pixel by the view's renderer, then what is at its depth. */
#include "core/job.h"
#include "core/vec.h"
#include "render/sight.h"
#include <math.h>
#include <string.h>
#include <volvis/pick.h>

typedef struct picking {
    const vv_scene *scene;
    void *state; /* the renderer's */
    vvi_sight sight;
    vv_image *whole; /* of renderers that make a picture at once; else NULL */
    vv_picked *out;
    const vv_pixel *pixels;
    vv_job *job;
} picking;

static void describe(vv_picked *out, const picking *p)
{
    vvi_seen seen;
    vvi_sight_at(&seen, &p->sight, out->pixel.x + 0.5, out->pixel.y + 0.5, out->depth);
    out->world = seen.world;
    out->value = seen.value;
    if (!seen.actor)
        return;
    out->volume = seen.actor->id;
    out->id = seen.id;
    out->index = seen.index;
    out->gradient = seen.gradient;
    out->normal = seen.normal;
    out->labelled = seen.actor->classes.kind == VV_SEGMENT_LABELS ||
                    vv_field_get_info(seen.actor->field)->meaning == VV_MEANING_LABEL;
    if (out->labelled && fabs(seen.value) < 0x1p62)
        out->label = (int64_t)floor(seen.value + 0.5);
}

static void take_pixel(vv_picked *out, const vv_image *image, size_t at)
{
    memcpy(out->rgba, image->rgba + 4 * at, sizeof out->rgba);
    out->depth = (double)image->depth[at];
    out->hit = isfinite(out->depth);
}

static vv_vec3 normal_at(const vv_image *image, size_t at)
{
    const float *n = image->normal + 3 * at;
    return vvi_vec((double)n[0], (double)n[1], (double)n[2]);
}

static vv_status pick_drawn(const picking *p, vv_picked *out)
{
    const size_t at = (size_t)out->pixel.y * (size_t)p->whole->width + (size_t)out->pixel.x;
    take_pixel(out, p->whole, at);
    if (out->hit)
        describe(out, p);
    if (out->hit && p->whole->normal)
        out->normal = normal_at(p->whole, at);
    return VV_OK;
}

/* An image of one pixel, whose ray goes where the pass says. */
static vv_status pick_one(void *scratch, void *user, size_t index)
{
    const picking *p = user;
    const vv_pixel pixel = p->pixels[index];
    const vv_pass pass = {.x = pixel.x + 0.5, .y = pixel.y + 0.5, .stride = 1, .seed = p->scene->seed};
    vv_render_counts counts = {0};
    vv_image *image;
    vv_picked *out = &p->out[index];
    (void)scratch;
    *out = (vv_picked){.pixel = pixel, .depth = INFINITY, .value = NAN};
    if (p->whole)
        return pick_drawn(p, out);
    vv_status st = vv_image_new(&image, 1, 1, VV_LAYER_DEPTH, p->job);
    if (st != VV_OK)
        return st;
    st = p->scene->renderer->render(p->state, &pass, &(vv_tile){0, 0, 1, 1}, image, &counts, p->job);
    if (st == VV_OK)
        take_pixel(out, image, 0);
    vv_image_release(image);
    if (st == VV_OK && out->hit)
        describe(out, p);
    return st;
}

static vv_status check_pixels(const picking *p, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const vv_pixel *at = &p->pixels[i];
        if (at->x < 0 || at->y < 0 || at->x >= p->scene->width || at->y >= p->scene->height)
            return vv_fail(VV_E_ARGUMENT, "pixel %d,%d lies outside the view, which has %d x %d, counted from 0", at->x,
                           at->y, p->scene->width, p->scene->height);
    }
    return VV_OK;
}

static vv_status draw_whole(picking *p)
{
    vv_render_counts counts = {0};
    int64_t samples;
    const unsigned layers = VV_LAYER_DEPTH | (p->scene->renderer->normals ? VV_LAYER_NORMAL : 0);
    const vv_status st = vv_image_new(&p->whole, p->scene->width, p->scene->height, layers, p->job);
    return st == VV_OK ? p->scene->renderer->draw(p->state, p->whole, 1, &samples, &counts, p->job) : st;
}

static vv_status pick_scene(picking *p, size_t n)
{
    static const vvi_work work = {.item = pick_one};
    const vv_renderer *renderer = p->scene->renderer;
    vv_status st;
    if (!renderer->render && !renderer->draw)
        return vv_fail(VV_E_UNSUPPORTED, "method '%s' draws nothing", renderer->name);
    if ((st = check_pixels(p, n)) != VV_OK || (renderer->accepts && (st = renderer->accepts(p->scene)) != VV_OK) ||
        (st = vvi_sight_open(&p->sight, p->scene, p->job)) != VV_OK)
        return st;
    if (!renderer->prepare || (st = renderer->prepare(&p->state, p->scene, p->job)) == VV_OK) {
        st = renderer->draw ? draw_whole(p) : VV_OK;
        if (st == VV_OK)
            st = vvi_parallel_for(p->job, &work, p, n);
        vv_image_release(p->whole);
        if (renderer->finish)
            renderer->finish(p->state);
    }
    vvi_sight_close(&p->sight);
    return st;
}

vv_status vv_pick(vv_picked *out, const vv_pixel *pixels, size_t n, vv_world *world, const char *view, vv_job *job)
{
    vv_scene *scene = NULL;
    vv_status st = vv_scene_resolve(&scene, world, view, job);
    if (st != VV_OK)
        return st;
    st = pick_scene(&(picking){.scene = scene, .out = out, .pixels = pixels, .job = job}, n);
    vv_scene_release(scene);
    return st;
}
