/* A picture: a scene, the renderer's preparation, what was gathered, and in which order its stages come. */
#include "render/picture.h"
#include "core/cpu.h"
#include "core/cpu_select.h"
#include "core/job.h"
#include "core/memory.h"
#include "gfx/mesh_look.h"
#include "render/decorate/decorate.h"
#include "scene/resolve.h"
#include <string.h>

/* Its end --------------------------------------------------------------------------------------------------------- */

/* A picture of nothing is rarely what was meant, and says nothing of why. */
void vvi_warn_of_nothing(const vv_scene *scene, uint64_t covered, vv_job *job)
{
    if (covered)
        return;
    vvi_log(job, VV_LOG_WARNING, "render", "%s",
            scene->n_actors + scene->n_mesh_actors
                ? "nothing is seen: every value is transparent, cut away or outside the view; check the transfer "
                  "function or iso value, the cuts and the camera"
                : "nothing is seen: no volume is visible");
}

static bool is_translucent(const vv_mesh_actor *shape)
{
    vv_mesh_info shown;
    const vvi_gfx_surface surface = vvi_gfx_surface_of(&shown, shape);
    return vvi_gfx_is_translucent(&surface);
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
    vvi_gathered_finish_passes(&picture->got);
    const vv_status st = vvi_picture_loop(
        picture, &(vvi_tiles){.width = image->width, .height = image->height, .tile = count_covered, .quiet = true});
    if (st != VV_OK)
        return st;
    if (picture->scene->rows == picture->scene->height)
        vvi_warn_of_nothing(picture->scene, picture->got.counts.covered, picture->job);
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

double vvi_picture_spent(const vv_picture *picture)
{
    return picture->got.spent_s + (vvi_render_clock() - picture->began_s);
}

void vv_picture_until_init(vv_picture_until *until, size_t size)
{
    const vv_picture_until all = {.size = size};
    memcpy(until, &all, size < sizeof all ? size : sizeof all);
}

bool vv_picture_is_whole(const vv_picture *picture)
{
    return picture->got.stage == VVI_STAGE_END;
}

double vv_picture_done(const vv_picture *picture)
{
    const double done = (double)picture->n_done, all = done + (double)picture->n_ahead;
    return vv_picture_is_whole(picture) ? 1 : all > 0 ? done / all : 0;
}

int vv_picture_level(const vv_picture *picture)
{
    const vvi_gathered *got = &picture->got;
    return got->passes > 0 ? 2 : got->grid > 3 ? 1 : got->grid > 0 ? 0 : -1;
}

static vv_status is_enough(bool *out, vv_picture *picture, const vv_picture_until *until, int64_t seen)
{
    const vvi_gathered *got = &picture->got;
    const bool judged = got->stage != VVI_STAGE_JUDGE && got->stage != VVI_STAGE_WEIGH;
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
        st = vvi_picture_do_stage(picture);
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

/* What looks at all of a picture at once cannot be made part by part. */
vv_status vvi_has_parts(const vv_scene *scene)
{
    const char *why = scene->renderer->draw        ? "its method makes the picture at once; use method raycast"
                      : vvi_decorate_wanted(scene) ? "decorations are placed by the whole picture; omit them"
                      : scene->noise > 0    ? "noise is judged on the whole picture; give a number of rays (samples)"
                      : scene->budget_s > 0 ? "a budget of time is for the whole picture; give a number of rays "
                                              "(samples)"
                                            : NULL;
    return why ? vv_fail(VV_E_UNSUPPORTED,
                         "a picture of %d x %d pixels is more than the memory limit allows at once, and %s",
                         scene->width, scene->height, why)
               : VV_OK;
}

/* New and gone ---------------------------------------------------------------------------------------------------- */

/* One that takes what this one does not, with the rest where there is one. */
static const char *other_method(const vv_scene *scene, unsigned contents)
{
    const vv_registry *registry = ((const vvi_resolved *)(const void *)scene)->registry;
    const unsigned all = (scene->n_actors ? VV_CONTENT_SAMPLES : 0u) | (scene->n_mesh_actors ? VV_CONTENT_MESHES : 0u);
    const vv_renderer *row = vv_registry_renderer_for(registry, all);
    return (row->takes & contents ? row : vv_registry_renderer_for(registry, contents))->name;
}

vv_status vvi_accepts(const vv_scene *scene)
{
    const vv_renderer *renderer = scene->renderer;
    if (!renderer->render && !renderer->draw)
        return vv_fail(VV_E_UNSUPPORTED, "method '%s' draws nothing", renderer->name);
    if (scene->n_mesh_actors && !(renderer->takes & VV_CONTENT_MESHES) && !(renderer->can & VV_CAN_LEAVE_OUT))
        return vv_fail(VV_E_UNSUPPORTED, "volumes.%s: is a mesh, which method '%s' does not draw; use method=%s",
                       scene->mesh_actors[0].look.id, renderer->name, other_method(scene, VV_CONTENT_MESHES));
    if (scene->n_actors && !(renderer->takes & VV_CONTENT_SAMPLES) && !(renderer->can & VV_CAN_LEAVE_OUT))
        return vv_fail(VV_E_UNSUPPORTED, "volumes.%s: is no mesh, and method '%s' draws nothing else; use method=%s",
                       scene->actors[0].id, renderer->name, other_method(scene, VV_CONTENT_SAMPLES));
    return renderer->accepts ? renderer->accepts(scene) : VV_OK;
}

/* Tiles behind and ahead; at most: noise and time may end it before. */
static void foresee(vv_picture *picture)
{
    const vv_scene *scene = picture->scene;
    const uint64_t across = ((uint64_t)scene->width + VVI_TILE - 1) / VVI_TILE;
    const uint64_t tiles = across * (((uint64_t)scene->rows + VVI_TILE - 1) / VVI_TILE);
    const uint64_t passes = (uint64_t)picture->got.passes, all = (uint64_t)scene->samples;
    uint64_t begun = 0;
    const bool quiet = picture->got.stage == VVI_STAGE_ADD || picture->got.stage == VVI_STAGE_WEIGH;
    for (size_t i = 0; i < picture->got.n_tiles; i++)
        begun += !quiet && picture->got.done[i];
    picture->n_done = tiles * passes + begun;
    picture->n_ahead = tiles * all > picture->n_done ? tiles * all - picture->n_done : 0;
    picture->n_done += across * (uint64_t)(scene->top / VVI_TILE) * all; /* of other parts of it */
    picture->n_ahead += across * (uint64_t)((scene->height - scene->top - scene->rows + VVI_TILE - 1) / VVI_TILE) * all;
}

static vvi_stage first_stage(const vv_picture *picture)
{
    const vv_scene *scene = picture->scene;
    const bool coarse = scene->adaptive || (picture->coarse && !scene->renderer->plane);
    return scene->renderer->draw ? VVI_STAGE_DRAW : coarse ? VVI_STAGE_GRID : VVI_STAGE_FIRST;
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

static vv_status choose_rows(vv_scene *scene, int32_t top, int32_t rows)
{
    if (rows == 0)
        return VV_OK;
    if (top % VVI_TILE || top < 0 || rows < 1 || rows > scene->height - top)
        return vv_fail(VV_E_ARGUMENT, "rows %d to %d of a picture that has %d: they begin at a multiple of %d", top,
                       top + rows - 1, scene->height, VVI_TILE);
    scene->top = top;
    scene->rows = rows;
    scene->adaptive = false; /* it looks at neighbours, which another part may have */
    return vvi_has_parts(scene);
}

static vv_status new_picture(vv_picture **out, vv_world *world, const char *view, bool coarse, int32_t top,
                             int32_t rows, vv_job *job)
{
    const double start_s = vvi_render_clock();
    *out = NULL;
    vv_picture *picture = vvi_alloc_zeroed(job, sizeof *picture, VVI_MEM_MODEL);
    if (!picture)
        return vv_fail_memory(sizeof *picture);
    picture->coarse = coarse;
    work_in(picture, job);
    vv_status st = vv_scene_resolve(&picture->scene, world, view, job);
    if (st == VV_OK && ((st = choose_rows(picture->scene, top, rows)) != VV_OK || (st = prepare(picture)) != VV_OK)) {
        vv_scene_release(picture->scene); /* the renderer has prepared nothing */
        picture->scene = NULL;
    }
    if (st != VV_OK) {
        vv_picture_free(picture);
        return st;
    }
    picture->load_s = ((const vvi_resolved *)(const void *)picture->scene)->load_s;
    picture->prepare_s = vvi_render_clock() - start_s - picture->load_s;
    foresee(picture);
    *out = picture;
    return VV_OK;
}

vv_status vv_picture_new(vv_picture **out, vv_world *world, const char *view, bool coarse, vv_job *job)
{
    return new_picture(out, world, view, coarse, 0, 0, job);
}

vv_status vvi_picture_new_rows(vv_picture **out, vv_world *world, const char *view, int32_t top, int32_t rows,
                               vv_job *job)
{
    return new_picture(out, world, view, false, top, rows, job);
}

void vvi_picture_adopt(vv_picture *picture, vvi_gathered *got)
{
    vvi_gathered_finish(&picture->got);
    picture->got = *got;
    *got = (vvi_gathered){.image = NULL};
    foresee(picture);
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
