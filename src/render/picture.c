/* A picture: a scene, the renderer's preparation, what was gathered, and in which order its stages come. */
#include "render/picture.h"
#include "core/cpu.h"
#include "core/cpu_select.h"
#include "core/job.h"
#include "core/memory.h"
#include "gfx/gfx.h"
#include "render/decorate/decorate.h"
#include "scene/resolve.h"
#include <math.h>
#include <string.h>

/* What it gathers ------------------------------------------------------------------------------------------------- */

static vvi_stage first_stage(const vv_picture *picture)
{
    const vv_scene *scene = picture->scene;
    const bool coarse = scene->adaptive || (picture->coarse && !scene->renderer->plane);
    return scene->renderer->draw ? VVI_STAGE_DRAW : coarse ? VVI_STAGE_GRID : VVI_STAGE_FIRST;
}

vv_status vvi_gathered_begin(vvi_gathered *got, const vv_scene *scene, vvi_stage stage, vv_job *job)
{
    const int32_t w = scene->width, h = scene->height;
    *got = (vvi_gathered){.stage = stage, .n_tiles = vvi_picture_tiles_most(w, h)};
    vv_status st = vv_image_new(&got->image, w, h, scene->layers, job);
    if (st == VV_OK && stage <= VVI_STAGE_SQUARES)
        st = vv_image_new(&got->canvas, vvi_preview_size(w), vvi_preview_size(h), scene->layers, job);
    got->done = vvi_alloc_zeroed(job, got->n_tiles, VVI_MEM_SCRATCH);
    return st == VV_OK && !got->done ? vv_fail_memory(got->n_tiles) : st;
}

vv_status vvi_gathered_begin_passes(vvi_gathered *got, const vv_scene *scene, vv_job *job)
{
    const size_t n = (size_t)scene->width * (size_t)scene->height, half_bytes = n * 4 * sizeof *got->half;
    got->n_across = (scene->width + VVI_BLOCK - 1) / VVI_BLOCK;
    got->n_down = (scene->height + VVI_BLOCK - 1) / VVI_BLOCK;
    const size_t n_blocks = (size_t)got->n_across * (size_t)got->n_down;
    const vv_status st = vv_image_new(&got->shifted, scene->width + 1, scene->height + 1, 0, job);
    if (st != VV_OK)
        return st;
    got->active = vvi_alloc(job, n_blocks, VVI_MEM_SCRATCH);
    if (scene->noise > 0)
        got->half = vvi_alloc_zeroed(job, half_bytes, VVI_MEM_IMAGE);
    if (!got->active || (scene->noise > 0 && !got->half))
        return vv_fail_memory(half_bytes + n_blocks);
    memset(got->active, 1, n_blocks);
    return VV_OK;
}

static void finish_passes(vvi_gathered *got)
{
    vv_image_release(got->shifted);
    vvi_free(got->half);
    vvi_free(got->active);
    got->shifted = NULL;
    got->half = NULL;
    got->active = NULL;
}

void vvi_gathered_finish(vvi_gathered *got)
{
    finish_passes(got);
    vv_image_release(got->image);
    vv_image_release(got->canvas);
    vvi_free(got->done);
    *got = (vvi_gathered){.image = NULL};
}

/* Stages ---------------------------------------------------------------------------------------------------------- */

double vvi_picture_spent(const vv_picture *picture)
{
    return picture->got.spent_s + (vvi_render_clock() - picture->began_s);
}

/* A pass of a ray for each pixel is there. */
static void end_first_pass(vv_picture *picture)
{
    vv_image_release(picture->got.canvas);
    picture->got.canvas = NULL;
    picture->got.passes = 1;
    picture->got.stage = VVI_STAGE_JUDGE;
}

static vv_status show_canvas(vv_picture *picture)
{
    const vv_status st = vvi_preview_show(picture, picture->got.image, 1);
    if (st == VV_OK)
        end_first_pass(picture);
    return st;
}

/* From coarse to fine, for who waits; and with squares filled in where that does. */
static vv_status do_grid(vv_picture *picture)
{
    vvi_gathered *got = &picture->got;
    bool whole = got->grid == VVI_GRIDS;
    vv_status st = whole ? VV_OK : vvi_preview_go_on(&whole, picture);
    if (st != VV_OK || !whole)
        return st;
    got->grid += got->grid < VVI_GRIDS;
    if (picture->scene->adaptive)
        got->stage = VVI_STAGE_SQUARES;
    return got->grid == VVI_GRIDS ? show_canvas(picture) : VV_OK;
}

static vv_status do_squares(vv_picture *picture)
{
    const vv_status st = vvi_adaptive_finish(picture);
    return st == VV_OK ? show_canvas(picture) : st;
}

static vv_status first_tile(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                            vv_render_counts *counts)
{
    const vv_pass pass = vvi_picture_pass(picture, 0.5, 0.5, 1, 0);
    return vvi_picture_render(picture, &pass, tile, picture->got.image, counts);
}

static vv_status do_first(vv_picture *picture)
{
    bool whole;
    const vv_status st = vvi_picture_go_on(
        &whole, picture,
        &(vvi_tiles){.width = picture->scene->width, .height = picture->scene->height, .tile = first_tile});
    if (st == VV_OK && whole)
        end_first_pass(picture);
    return st;
}

/* On an image that is clear: what was drawn before a cancel is no part of it. */
static vv_status do_draw(vv_picture *picture)
{
    const vv_scene *scene = picture->scene;
    vvi_gathered *got = &picture->got;
    vv_image *image = NULL;
    vv_render_counts counts = {0};
    int64_t samples = 1;
    vv_image_release(got->image);
    got->image = NULL;
    vv_status st = vv_image_new(&image, scene->width, scene->height, scene->layers, picture->job);
    got->image = image;
    if (st != VV_OK)
        return st;
    st = scene->renderer->draw(picture->state, image, scene->samples, &samples, &counts, picture->job);
    if (st != VV_OK)
        return st;
    const size_t n = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; image->samples && i < n; i++)
        image->samples[i] = (uint32_t)samples;
    got->counts = counts;
    got->passes = samples;
    got->ended_by = VV_END_SAMPLES;
    got->stage = VVI_STAGE_END;
    return VV_OK;
}

static vv_status do_rays(vv_picture *picture)
{
    bool whole;
    const vv_status st = vvi_pass_cast(&whole, picture);
    if (st == VV_OK && whole)
        picture->got.stage = VVI_STAGE_ADD;
    return st;
}

static vv_status do_add(vv_picture *picture)
{
    bool whole;
    const vv_status st = vvi_pass_add(&whole, picture);
    if (st != VV_OK || !whole)
        return st;
    picture->got.passes++;
    picture->got.stage = VVI_STAGE_JUDGE;
    return VV_OK;
}

/* A pass that would not end in time is not begun: it takes as long as the last one. Tells the progress how many there
 * will be, too. */
static bool is_time_over(vv_picture *picture)
{
    const vvi_gathered *got = &picture->got;
    const double spent_s = vvi_picture_spent(picture), left_s = picture->scene->budget_s - spent_s;
    if (!(picture->scene->budget_s > 0))
        return false;
    const double passes = left_s / (spent_s - got->pass_began_s);
    const double tiles = (double)picture->n_done / (double)got->passes;
    picture->n_ahead = (uint64_t)fmin((double)picture->n_ahead, fmax(passes * tiles, 0));
    return passes < 1;
}

/* After 1, 5, 9, ... passes: rarely enough to cost nothing, and there they lie evenly about the centres. */
static vv_status check_noise(vv_picture *picture)
{
    return picture->scene->noise > 0 && picture->got.passes % 4 == 1 ? vvi_noise_check(picture) : VV_OK;
}

static vv_status do_judge(vv_picture *picture)
{
    const vv_scene *scene = picture->scene;
    vvi_gathered *got = &picture->got;
    vv_status st = VV_OK;
    if (scene->samples > 1 && !got->shifted) {
        finish_passes(got); /* of a try that had no memory */
        st = vvi_gathered_begin_passes(got, scene, picture->job);
    }
    if (st == VV_OK && scene->samples > 1)
        st = check_noise(picture);
    if (st != VV_OK)
        return st;
    got->ended_by = scene->samples > 1 && vvi_blocks_active(got) == 0 ? VV_END_NOISE
                    : got->passes >= scene->samples                   ? VV_END_SAMPLES
                    : is_time_over(picture)                           ? VV_END_BUDGET
                                                                      : VV_END_NONE;
    got->pass_began_s = vvi_picture_spent(picture);
    got->stage = got->ended_by == VV_END_NONE ? VVI_STAGE_RAYS : VVI_STAGE_END;
    return VV_OK;
}

static vv_status (*const stages[])(vv_picture *picture) = {
    [VVI_STAGE_GRID] = do_grid,   [VVI_STAGE_SQUARES] = do_squares, [VVI_STAGE_FIRST] = do_first,
    [VVI_STAGE_DRAW] = do_draw,   [VVI_STAGE_RAYS] = do_rays,       [VVI_STAGE_ADD] = do_add,
    [VVI_STAGE_JUDGE] = do_judge,
};

/* Its end --------------------------------------------------------------------------------------------------------- */

/* A picture of nothing is rarely what was meant, and says nothing of why. */
static void warn_of_nothing(const vv_picture *picture)
{
    if (picture->got.counts.covered)
        return;
    vvi_log(picture->job, VV_LOG_WARNING, "render", "%s",
            picture->scene->n_actors + picture->scene->n_mesh_actors
                ? "nothing is seen: every value is transparent, cut away or outside the view; check the transfer "
                  "function or iso value, the cuts and the camera"
                : "nothing is seen: no volume is visible");
}

static bool is_translucent(const vv_mesh_actor *shape)
{
    vv_mesh_info shown = *vv_mesh_get_info(shape->mesh);
    if (shape->parts)
        shown.parts = shape->parts;
    if (shape->colors)
        shown.colors = shape->colors;
    return vvi_gfx_is_translucent(
        &(vvi_gfx_surface){.mesh = &shown, .color.a = shape->opacity, .one_color = shape->one_color});
}

/* They are blended over what the layers tell of, which is the first opaque thing. Said once, of the first of them. */
static void warn_of_layers(const vv_picture *picture)
{
    const vv_scene *scene = picture->scene;
    const vv_render_choice *choice = (const vv_render_choice *)(const void *)scene->view->render;
    const vv_layer_choice *layers = (const vv_layer_choice *)(const void *)choice->layers;
    size_t i = 0;
    if (!(layers->depth || layers->normal || layers->id || layers->value))
        return;
    while (i < scene->n_mesh_actors && !is_translucent(&scene->mesh_actors[i]))
        i++;
    if (i < scene->n_mesh_actors)
        vvi_log(picture->job, VV_LOG_WARNING, "render",
                "volumes.%s: is a translucent mesh: the layers hold what is seen behind such meshes; 'volvis pick' "
                "reports them too, and a colour without transparency puts them into the layers",
                scene->mesh_actors[i].look.id);
}

static vv_status count_covered(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                               vv_render_counts *counts)
{
    const vv_image *image = picture->got.image;
    for (int32_t y = tile->y0; y < tile->y1; y++) {
        const float *light = image->rgba + 4 * ((size_t)y * (size_t)image->width + (size_t)tile->x0);
        for (int32_t x = tile->x0; x < tile->x1; x++, light += 4)
            counts->covered += light[3] > 0;
    }
    return VV_OK;
}

static vv_status end_whole(vv_picture *picture)
{
    const vv_image *image = picture->got.image;
    finish_passes(&picture->got);
    const vv_status st = vvi_picture_loop(
        picture, &(vvi_tiles){.width = image->width, .height = image->height, .tile = count_covered, .quiet = true});
    if (st != VV_OK)
        return st;
    warn_of_nothing(picture);
    warn_of_layers(picture);
    return VV_OK;
}

/* Samples that went while they were drawn were drawn as 0. */
vv_status vvi_scene_health(const vv_scene *scene)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < scene->n_actors && st == VV_OK; i++) {
        const vv_actor *actor = &scene->actors[i];
        st = vv_field_health(actor->field);
        if (st == VV_OK && actor->colors)
            st = vv_field_health(actor->colors);
        if (st != VV_OK)
            st = vv_fail_in(st, "volumes.%s", actor->id);
    }
    return st;
}

static void work_in(vv_picture *picture, vv_job *job)
{
    picture->job = job;
    picture->isa = vvi_cpu_name(vvi_job_cpu(job));
    picture->threads = vvi_job_threads(job);
}

/* Steps ----------------------------------------------------------------------------------------------------------- */

void vv_picture_until_init(vv_picture_until *until, size_t size)
{
    const vv_picture_until all = {.size = size};
    memcpy(until, &all, size < sizeof all ? size : sizeof all);
}

bool vv_picture_is_whole(const vv_picture *picture)
{
    return picture->got.stage == VVI_STAGE_END;
}

int vv_picture_level(const vv_picture *picture)
{
    const vvi_gathered *got = &picture->got;
    return got->passes > 0 ? 2 : got->grid > 3 ? 1 : got->grid > 0 ? 0 : -1;
}

static vv_status is_enough(bool *out, vv_picture *picture, const vv_picture_until *until, int64_t seen)
{
    const vvi_gathered *got = &picture->got;
    const bool judged = got->stage != VVI_STAGE_JUDGE;
    *out = got->stage == VVI_STAGE_END || (picture->deadline_s > 0 && vvi_render_clock() > picture->deadline_s) ||
           (until->better && judged && got->passes + vv_picture_level(picture) > seen) ||
           (until->passes > 0 && judged && got->passes >= until->passes);
    return !*out && until->noise > 0 && got->stage == VVI_STAGE_RAYS ? vvi_noise_is_below(out, picture, until->noise)
                                                                     : VV_OK;
}

vv_status vv_picture_step(vv_picture *picture, const vv_picture_until *until, vv_job *job)
{
    vv_picture_until all;
    const int64_t seen = picture->got.passes + vv_picture_level(picture);
    vv_status st = VV_OK;
    bool enough = vv_picture_is_whole(picture);
    vv_picture_until_init(&all, sizeof all);
    if (until)
        memcpy(&all, until, until->size < sizeof all ? until->size : sizeof all);
    if (all.noise > 0 && !(picture->scene->noise > 0))
        return vv_fail(VV_E_ARGUMENT, "the noise of this picture is not known: set render.noise of its view");
    work_in(picture, job);
    picture->began_s = vvi_render_clock();
    picture->deadline_s = all.seconds > 0 ? picture->began_s + all.seconds : 0;
    while (st == VV_OK && !enough) {
        st = stages[picture->got.stage](picture);
        if (st == VV_OK && vv_picture_is_whole(picture))
            st = end_whole(picture);
        if (st == VV_OK)
            st = is_enough(&enough, picture, &all, seen);
    }
    picture->got.spent_s = vvi_picture_spent(picture);
    return st == VV_OK ? vvi_scene_health(picture->scene) : st;
}

void vv_picture_report(vv_render_report *out, const vv_picture *picture)
{
    const vvi_gathered *got = &picture->got;
    *out = (vv_render_report){
        .method = picture->scene->renderer->name,
        .isa = picture->isa,
        .threads = picture->threads,
        .load_s = picture->load_s,
        .prepare_s = picture->prepare_s,
        .render_s = got->spent_s,
        .rays = got->counts.rays,
        .samples = got->counts.samples,
        .passes = got->passes,
        .ended_by = got->ended_by,
    };
}

/* New and gone ---------------------------------------------------------------------------------------------------- */

vv_status vvi_accepts(const vv_scene *scene)
{
    const vv_renderer *renderer = scene->renderer;
    if (!renderer->render && !renderer->draw)
        return vv_fail(VV_E_UNSUPPORTED, "method '%s' draws nothing", renderer->name);
    if (scene->n_mesh_actors && !renderer->mesh_actors)
        return vv_fail(VV_E_UNSUPPORTED, "volumes.%s: is a mesh, which method '%s' does not draw; use method=surface",
                       scene->mesh_actors[0].look.id, renderer->name);
    return renderer->accepts ? renderer->accepts(scene) : VV_OK;
}

/* At most: noise and time may end it before. */
void vvi_picture_foresee(vv_picture *picture)
{
    const vv_scene *scene = picture->scene;
    const uint64_t across = ((uint64_t)scene->width + VVI_TILE - 1) / VVI_TILE;
    const uint64_t tiles = across * (((uint64_t)scene->height + VVI_TILE - 1) / VVI_TILE);
    const uint64_t passes = (uint64_t)picture->got.passes, all = (uint64_t)scene->samples;
    picture->n_done = tiles * passes;
    picture->n_ahead = all > passes ? tiles * (all - passes) : 0;
}

static vv_status prepare(vv_picture *picture)
{
    const vv_scene *scene = picture->scene;
    vv_status st = vvi_accepts(scene);
    if (st == VV_OK)
        st = vvi_decorate_check(scene);
    if (st == VV_OK)
        st = vvi_gathered_begin(&picture->got, scene, first_stage(picture), picture->job);
    if (st == VV_OK && scene->renderer->prepare)
        st = scene->renderer->prepare(&picture->state, scene, picture->job);
    return st;
}

vv_status vv_picture_new(vv_picture **out, vv_world *world, const char *view, bool coarse, vv_job *job)
{
    const double start_s = vvi_render_clock();
    *out = NULL;
    vv_picture *picture = vvi_alloc_zeroed(job, sizeof *picture, VVI_MEM_MODEL);
    if (!picture)
        return vv_fail_memory(sizeof *picture);
    picture->coarse = coarse;
    work_in(picture, job);
    vv_status st = vv_scene_resolve(&picture->scene, world, view, job);
    if (st == VV_OK && (st = prepare(picture)) != VV_OK) {
        vv_scene_release(picture->scene); /* the renderer has prepared nothing */
        picture->scene = NULL;
    }
    if (st != VV_OK) {
        vv_picture_free(picture);
        return st;
    }
    picture->load_s = ((const vvi_resolved *)(const void *)picture->scene)->load_s;
    picture->prepare_s = vvi_render_clock() - start_s - picture->load_s;
    vvi_picture_foresee(picture);
    *out = picture;
    return VV_OK;
}

void vv_picture_free(vv_picture *picture)
{
    if (!picture)
        return;
    if (picture->scene && picture->scene->renderer->finish)
        picture->scene->renderer->finish(picture->state);
    vvi_gathered_finish(&picture->got);
    vv_scene_release(picture->scene);
    vvi_free(picture);
}
