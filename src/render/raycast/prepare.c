/* What a frame of the ray caster needs before its first pixel: every volume, and which kernels draw them. */
#include "core/cache.h"
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "model/contents.h"
#include "render/common/half_volume.h"
#include "render/raycast/prepare_light.h"
#include "scene/label_ids.h"
#include "scene/resolve.h"
#include <math.h>
#include <stdio.h>

/* What a picture that moves is made of: as many as a few milliseconds pass over. */
#define DRAFT_SAMPLES (INT64_C(1) << 25)

typedef struct quality_row {
    double step_vox, opaque;
} quality_row;
static const quality_row by_quality[] = {
    [VV_QUALITY_DRAFT] = {2, 1.0 / 64},
    [VV_QUALITY_NORMAL] = {1, 1.0 / 512},
    [VV_QUALITY_HIGH] = {0.5, 1.0 / 4096},
    [VV_QUALITY_REFERENCE] = {0.125, 0},
};

static const vvi_raycast_params *params_of(const vv_scene *scene)
{
    return (const vvi_raycast_params *)scene->params;
}

bool vvi_raycast_solid(double *lo, double *hi, const vvi_raycast_params *p, const vv_actor *actor)
{
    const bool iso = p->mode == VV_RAY_ISOSURFACE;
    *lo = !iso ? actor->classes.lo : vv_object_is_set(&p->base, "iso") ? p->iso : actor->iso;
    *hi = iso ? INFINITY : actor->classes.hi;
    return iso || (p->mode == VV_RAY_COMPOSITE && actor->classes.kind == VV_SEGMENT_THRESHOLD);
}

static double find_step(const vvi_raycast_volume *v, const vv_scene *scene)
{
    const vvi_raycast_params *p = v->params;
    return vv_object_is_set(&p->base, "step") ? p->step
                                              : by_quality[scene->quality].step_vox * vvi_actor_voxel(v->actor);
}

static int halvings_of(const vv_actor *actor, const vv_scene *scene)
{
    const vvi_raycast_params *p = params_of(scene);
    if (actor->colors || actor->nearest || actor->classes.kind == VV_SEGMENT_LABELS ||
        vv_field_get_info(actor->field)->meaning == VV_MEANING_LABEL)
        return 0;
    if (vv_object_is_set(&p->base, "halvings"))
        return (int)p->halvings;
    return scene->quality == VV_QUALITY_DRAFT ? vvi_halvings_to(actor->field, DRAFT_SAMPLES) : 0;
}

/* Says of which file. */
static vv_status fail_of(const vv_actor *actor, const vv_scene *scene, vv_status st)
{
    char path[160];
    const vv_dataset *dataset = NULL;
    const vv_volume *volume = scene->world ? vvi_volume_named(scene->world, actor->id) : NULL;
    snprintf(path, sizeof path, "volumes.%.128s", actor->id);
    const vv_error *last = vv_error_last();
    char text[512];
    snprintf(text, sizeof text, "%s", last->message);
    if (!volume || vvi_find_dataset(&dataset, scene->world, volume, path) != VV_OK || !dataset->path)
        return vv_fail_at(st, NULL, path, "%s", text);
    return vv_fail_at(st, dataset->path, path, "%s", text);
}

/* Labels that are no rows of a table get numbers, which are. */
static vv_status number_labels(vvi_raycast_volume *v, const vv_scene *scene, vv_job *job)
{
    const vv_actor *actor = v->actor;
    if (actor->classes.kind != VV_SEGMENT_LABELS || v->params->mode == VV_RAY_ISOSURFACE ||
        !vvi_label_ids_needed(vv_field_get_info(actor->field), actor->statistics))
        return VV_OK;
    const vv_status st = vvi_label_ids_get(&v->ids, actor->field, actor->component, job);
    if (st != VV_OK)
        return fail_of(actor, scene, st);
    vvi_label_ids_actor(&v->halved, actor, vvi_cached_value(v->ids));
    v->actor = &v->halved;
    return VV_OK;
}

/* The scene's actor, or what stands for it; where there is no memory for that, it does not. */
static vv_status choose_actor(vvi_raycast_volume *v, const vv_actor *actor, const vv_scene *scene, vv_job *job)
{
    static const vvi_halving halving[] = {[VV_RAY_MAXIMUM] = VVI_HALVE_LARGEST,
                                          [VV_RAY_MINIMUM] = VVI_HALVE_SMALLEST,
                                          [VV_RAY_LOCAL_MAXIMUM] = VVI_HALVE_LARGEST,
                                          [VV_RAY_ISOSURFACE] = VVI_HALVE_MEAN};
    const int times = halvings_of(actor, scene);
    v->actor = actor;
    v->params = (const vvi_raycast_params *)vv_actor_params(scene, actor);
    if (!times)
        return number_labels(v, scene, job);
    const vv_status st = vvi_actor_halve(&v->halved, actor, times, halving[v->params->mode], job);
    if (st == VV_OK)
        v->actor = &v->halved;
    return st == VV_E_MEMORY || st == VV_E_LIMIT ? VV_OK : st;
}

/* Whether colours are more than the table says. */
static bool takes_light(const vvi_march_volume *f)
{
    return f->light.shaded || f->paint.kind != VVI_PAINT_NONE || f->texture;
}

/* What the kernel that draws a volume by itself does. */
static int kernel_of(const vvi_raycast_volume *v)
{
    if (v->solid)
        return VVI_RAY_SURFACE;
    switch (v->params->mode) {
    case VV_RAY_MAXIMUM:
    case VV_RAY_MINIMUM:
        return VVI_RAY_EXTREMUM;
    case VV_RAY_MEAN:
    case VV_RAY_SUM:
        return VVI_RAY_AVERAGE;
    case VV_RAY_LOCAL_MAXIMUM:
        return VVI_RAY_LOCAL_MAXIMUM;
    default:
        if (vvi_raycast_needs_more(v))
            return VVI_RAY_COMPOSITE_CLASSIFIED;
        return takes_light(&v->ray) ? VVI_RAY_COMPOSITE_LIT : VVI_RAY_COMPOSITE;
    }
}

static vvi_ray_kernel *own_kernel(const vvi_raycast_volume *v, const vvi_ray_kernels *k)
{
    if (v->ray.sampler.cubic && !v->layer)
        return v->solid ? k->surface_cubic : k->composite_cubic;
    return k->of[kernel_of(v)][vvi_lattice_kernel(&v->hold.lattice)];
}

/* Grain instead of rings, where there are rays enough to even it out and steps long enough to show rings. */
static bool jitters(const vv_scene *scene)
{
    const vvi_raycast_params *p = params_of(scene);
    if (vv_object_is_set(&p->base, "jitter"))
        return p->jitter;
    return scene->samples > 1 && scene->quality < VV_QUALITY_REFERENCE;
}

static vv_status prepare_volume(vvi_raycast_volume *v, const vv_scene *scene, vv_job *job)
{
    const vvi_raycast_params *p = v->params;
    vvi_transfer_table table = {0};
    double lo, hi;
    vv_status st = vvi_raycast_open_volume(v, scene, find_step(v, scene), job);
    if (st != VV_OK)
        return st;
    v->ray.opaque = (float)(vv_object_is_set(&p->base, "opaque") ? p->opaque : by_quality[scene->quality].opaque);
    v->ray.sampler.cell_gradient =
        vv_object_is_set(&p->base, "gradient") ? p->gradient == VVI_GRADIENT_CELL : scene->quality == VV_QUALITY_DRAFT;
    v->solid = vvi_raycast_solid(&lo, &hi, p, v->actor);
    v->layer = vvi_raycast_projects(p->mode);
    v->visible = true;
    if (v->solid)
        vvi_raycast_find_solid(v, p);
    else
        st = vvi_raycast_classify(v, &table, scene, job);
    if (v->layer)
        vvi_raycast_find_projection(v, p);
    if (st == VV_OK && !v->layer)
        st = vvi_raycast_find_paint(v, job);
    if (st == VV_OK && v->actor->texture.kind != VV_TEXTURE_NONE && !v->layer) {
        st = vvi_texture_open(&v->texture, v->actor, scene, job);
        v->ray.texture = &v->texture;
    }
    if (st == VV_OK && p->skipping)
        st = vvi_raycast_find_blocks(v, v->solid ? NULL : &table, job);
    if (st == VV_OK && p->parc && !v->layer && v->visible)
        st = vvi_raycast_bound_rays(v, scene, v->solid ? NULL : &table, job);
    vvi_transfer_table_finish(&table);
    return st;
}

/* Who draws what is no solid. */
static void choose_clouds(vvi_raycast_state *s)
{
    vvi_blend_setup *f = &s->blend;
    bool any = false;
    for (size_t i = 0; i < s->n_volumes; i++) {
        const vvi_raycast_volume *v = &s->volume[i];
        if (v->solid || v->layer) {
            s->n_surfaces += v->solid && v->visible;
            continue;
        }
        any |= v->visible;
        f->volume[f->n_volumes++] = v->ray; /* steps begin where the first volume does, seen or not */
        s->cloud = f->n_volumes == 1 ? v : NULL;
    }
    f->opaque = s->volume[0].ray.opaque;
    if (s->cloud || !any)
        f->n_volumes = 0;
    if (!any)
        s->cloud = NULL;
}

static vv_status prepare_volumes(vvi_raycast_state *s, const vv_scene *scene, vv_job *job)
{
    const vvi_ray_kernels *k = s->kernels;
    for (size_t i = 0; i < scene->n_actors; i++) {
        s->volume[i].ray.number = (int32_t)i;
        const vv_status st = choose_actor(&s->volume[s->n_volumes++], &scene->actors[i], scene, job);
        if (st != VV_OK)
            return st;
    }
    for (size_t i = 0; i < s->n_volumes; i++) {
        vvi_raycast_volume *v = &s->volume[i];
        const vv_status st = prepare_volume(v, scene, job);
        if (st != VV_OK)
            return st;
        v->kernel = own_kernel(v, k);
        s->n_layers += v->layer;
    }
    /* where layers are all there is, the first lies over nothing: it is as dense as if it were alone */
    for (size_t i = 0; i < s->n_volumes; i++)
        s->volume[i].ray.projection.by_value = i > 0 || s->n_layers < s->n_volumes || scene->n_mesh_actors;
    vvi_log(job, VV_LOG_INFO, "raycast", "%s kernels, %d rays at once", k->isa, k->width);
    return VV_OK;
}

/* Bricks that kernels bring. */
static void list_bricks(vvi_raycast_state *s)
{
    for (size_t i = 0; i < s->n_volumes; i++) {
        const vvi_raycast_volume *v = &s->volume[i];
        if (v->hold.lattice.fetch != VVI_FETCH_BRICKS)
            continue;
        vvi_bricks *bricks = vvi_cached_value(v->hold.cached);
        size_t at = 0;
        while (at < s->n_bricks && (uintptr_t)s->bricks[at] < (uintptr_t)bricks)
            at++;
        if (at < s->n_bricks && s->bricks[at] == bricks)
            continue;
        for (size_t k = s->n_bricks++; k > at; k--)
            s->bricks[k] = s->bricks[k - 1];
        s->bricks[at] = bricks;
    }
}

vv_status vvi_raycast_prepare(void **state_out, const vv_scene *scene, vv_job *job)
{
    *state_out = NULL;
    vvi_raycast_state *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_SCRATCH);
    if (!s)
        return vv_fail_memory(sizeof *s);
    s->kernels = vvi_ray_kernels_for(vvi_job_cpu(job));
    s->eye = (vvi_eye){.lens = scene->lens,
                       .width = scene->width,
                       .height = scene->height,
                       .rows = scene->rows,
                       .jitter = jitters(scene)};
    vv_status st = prepare_volumes(s, scene, job);
    if (st == VV_OK)
        st = vvi_ray_meshes_open(&s->meshes, scene, job);
    if (st == VV_OK)
        st = vvi_raycast_find_light(s, scene, job);
    if (st != VV_OK) {
        vvi_raycast_finish(s);
        return st;
    }
    choose_clouds(s);
    list_bricks(s);
    *state_out = s;
    return VV_OK;
}

void vvi_raycast_finish(void *state)
{
    vvi_raycast_state *s = state;
    if (!s)
        return;
    for (size_t i = 0; i < s->n_volumes; i++) {
        vvi_raycast_volume *v = &s->volume[i];
        vvi_parc_finish(&v->parc);
        vvi_cache_release(v->boxes);
        if (v->integral)
            vvi_transfer_integral_finish(v->integral);
        vvi_free(v->integral);
        vvi_transfer_plane_finish(&v->plane);
        vv_brick_release(&v->colors_brick);
        vvi_cache_release(v->colors);
        vvi_lattice_close(&v->paint);
        vvi_free(v->paint_color);
        vvi_texture_close(&v->texture);
        vvi_cache_release(v->skip);
        vvi_cache_release(v->minmax);
        vvi_lattice_close(&v->hold);
        vvi_free(v->alpha);
        vvi_free(v->seen);
        vvi_free(v->color);
        vvi_cache_release(v->ids);
        vv_field_release((vv_field *)v->halved.field);
    }
    vvi_ray_meshes_close(&s->meshes);
    vvi_cache_release(s->cells);
    vvi_cache_release(s->scattered);
    vvi_free(s);
}
