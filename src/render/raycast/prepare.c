/* What a frame of the ray caster needs before its first pixel: samples, blocks to skip, tables, light. */
#include "core/cache.h"
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "render/common/resolve.h"
#include "render/common/skip.h"
#include "render/common/transfer.h"
#include "render/raycast/raycast.h"
#include <math.h>
#include <string.h>

enum { SHIFT_SMALL = 2, SHIFT_LARGE = 3, GUARD_FLOATS = 16, MOST_STEPS = 1 << 20 };

typedef struct quality_row {
    double step_vox, opaque;
} quality_row;
static const quality_row by_quality[] = {
    [VV_QUALITY_DRAFT] = {2, 1.0 / 64},
    [VV_QUALITY_NORMAL] = {1, 1.0 / 512},
    [VV_QUALITY_HIGH] = {0.5, 1.0 / 4096},
    [VV_QUALITY_REFERENCE] = {0.125, 0},
};

/* The longest ray's steps; more than MOST_STEPS of them no float counts, and nobody waits for. */
static vv_status check_step(vvi_ray_frame *f, const vv_actor *actor, const vv_scene *scene)
{
    const int64_t *n = vv_field_get_info(actor->field)->grid.dims;
    double diagonal = 0;
    for (int a = 0; a < 3; a++)
        diagonal += vvi_length(actor->index_to_world.axis[a]) * (double)n[a];
    if (diagonal / f->step > MOST_STEPS)
        return vv_fail(VV_E_ARGUMENT,
                       "render.raycast.step: %g %s makes %.0f steps through the volume; take at least %.3g", f->step,
                       scene->world && scene->world->unit ? scene->world->unit : "", diagonal / f->step,
                       diagonal / MOST_STEPS);
    f->steps = (float)(diagonal / f->step);
    return VV_OK;
}

static bool solid(const vv_actor *actor, const vvi_raycast_params *p)
{
    return p->mode == VVI_RAYCAST_ISOSURFACE ||
           (p->mode == VVI_RAYCAST_COMPOSITE && actor->classes.kind == VV_SEGMENT_THRESHOLD);
}

/* Placement ----------------------------------------------------------------------------------------------------- */

static vv_status place(vvi_ray_frame *f, const vv_actor *actor)
{
    const vv_affine m = actor->index_to_world;
    vv_affine i;
    if (!vv_affine_invert(&i, m))
        return vv_fail(VV_E_ARGUMENT, "volumes.%s.place: flattens the volume; give it a scale other than 0", actor->id);
    const double forward[3][4] = {{m.axis[0].x, m.axis[1].x, m.axis[2].x, m.origin.x},
                                  {m.axis[0].y, m.axis[1].y, m.axis[2].y, m.origin.y},
                                  {m.axis[0].z, m.axis[1].z, m.axis[2].z, m.origin.z}};
    const double back[3][4] = {{i.axis[0].x, i.axis[1].x, i.axis[2].x, i.origin.x},
                               {i.axis[0].y, i.axis[1].y, i.axis[2].y, i.origin.y},
                               {i.axis[0].z, i.axis[1].z, i.axis[2].z, i.origin.z}};
    memcpy(f->world_to_index, back, sizeof back);
    for (int a = 0; a < 3; a++) {
        for (int b = 0; b < 4; b++)
            f->index_to_world[a][b] = (float)forward[a][b];
        for (int b = 0; b < 3; b++)
            f->gradient_to_world[a][b] = (float)back[b][a];
        /* a flat axis, and nearest samples, own half a voxel to each side */
        const bool thick = actor->nearest || f->lattice.n[a] == 1;
        f->lo[a] = thick ? -0.5 : 0;
        f->hi[a] = f->lattice.n[a] - (thick ? 0.5 : 1);
    }
    if (actor->n_planes > VVI_RAY_PLANES)
        return vv_fail(VV_E_UNSUPPORTED, "volumes.%s: %zu cut planes; ray casting takes at most %d", actor->id,
                       actor->n_planes, VVI_RAY_PLANES);
    f->n_planes = actor->n_planes;
    for (size_t p = 0; p < actor->n_planes; p++) {
        const vv_plane *plane = &actor->planes[p];
        const double row[4] = {plane->normal.x, plane->normal.y, plane->normal.z, plane->offset};
        memcpy(f->planes[p], row, sizeof row);
    }
    return VV_OK;
}

/* Light --------------------------------------------------------------------------------------------------------- */

/* Gradients in ranges of the values a voxel, whatever unit the values have: their squares must be floats as well. */
static void scale_gradients(vvi_ray_frame *f, const vv_actor *actor, double value_scale)
{
    const double range = (actor->statistics->max - actor->statistics->min) / value_scale;
    const double voxel = vvi_actor_voxel(actor);
    const double factor = range != 0 && isfinite(range) ? voxel / range : 1;
    for (int a = 0; a < 9; a++)
        f->gradient_to_world[a / 3][a % 3] = (float)((double)f->gradient_to_world[a / 3][a % 3] * factor);
    f->flat_gradient = 1e-6f;
    f->solid_unit = range != 0 && isfinite(range) ? (float)(1 / fabs(range)) : 1;
}

static vv_status light(vvi_ray_frame *f, const vv_scene *scene, const vv_actor *actor)
{
    if (scene->n_lamps > VVI_RAY_LAMPS)
        return vv_fail(VV_E_UNSUPPORTED, "lights: %zu are on; ray casting takes at most %d, so switch some off",
                       scene->n_lamps, VVI_RAY_LAMPS);
    f->shaded = actor->shading_model != VV_SHADING_NONE;
    f->phong = actor->shading_model == VV_SHADING_PHONG;
    f->two_sided = actor->two_sided;
    f->diffuse = actor->diffuse;
    f->specular = actor->specular;
    f->shininess = actor->shininess;
    for (int c = 0; c < 3; c++)
        f->light_ambient[c] = scene->ambient[c] * actor->ambient;
    f->n_lamps = scene->n_lamps;
    for (size_t i = 0; i < scene->n_lamps; i++) {
        const vv_lamp *from = &scene->lamps[i];
        vvi_ray_lamp *to = &f->lamps[i];
        *to = (vvi_ray_lamp){
            .kind = from->kind,
            .position = {(float)from->position.x, (float)from->position.y, (float)from->position.z},
            .to_light = {(float)-from->direction.x, (float)-from->direction.y, (float)-from->direction.z},
            .color = {from->color[0], from->color[1], from->color[2]},
            .cos_outer = (float)from->cos_outer,
            .inverse_fade = (float)(1 / fmax(from->cos_inner - from->cos_outer, 1e-6)),
            .falloff = {(float)from->falloff.x, (float)from->falloff.y, (float)from->falloff.z},
        };
    }
    return VV_OK;
}

/* Classification ------------------------------------------------------------------------------------------------ */

/* Stored numbers are looked up where they are: entry = stored * scale + shift is the table's place for their value. */
static vv_status classify(vvi_raycast_state *s, vvi_transfer_table *table, const vv_actor *actor, vv_job *job)
{
    vvi_ray_frame *f = &s->frame;
    const vv_field_info *info = vv_field_get_info(actor->field);
    double lo, hi;
    size_t n;
    vv_status st = vvi_transfer_domain(&lo, &hi, &n, &actor->classes, info, actor->statistics);
    if (st != VV_OK)
        return st;
    if (!actor->nearest && n > 1 && n < VVI_TRANSFER_ROWS) /* between stored values as well, each of them on a row */
        n = (n - 1) * ((VVI_TRANSFER_ROWS - 1 + n - 2) / (n - 1)) + 1;
    if ((st = vvi_transfer_table_init(table, &actor->classes, lo, hi, n, job)) != VV_OK)
        return st;
    const size_t rows = table->n;
    s->alpha = vvi_alloc(job, (rows + GUARD_FLOATS) * sizeof *s->alpha, VVI_MEM_SCRATCH);
    s->color = vvi_alloc(job, (rows * 4 + GUARD_FLOATS) * sizeof *s->color, VVI_MEM_SCRATCH);
    if (!s->alpha || !s->color)
        return vv_fail_memory(rows * 5 * sizeof(float));
    for (size_t i = 0; i < rows; i++) {
        s->alpha[i] = (float)-expm1(-(double)table->rgbk[4 * i + 3] * f->step);
        memcpy(s->color + 4 * i, table->rgbk + 4 * i, 3 * sizeof *s->color);
        s->color[4 * i + 3] = (float)((double)table->rgbk[4 * i + 3] * f->step);
    }
    f->alpha = s->alpha;
    f->color = s->color;
    f->n_entries = (int32_t)rows;
    f->entry_scale = (float)(s->hold.value_scale * table->scale);
    f->entry_shift = (float)(s->hold.value_offset * table->scale + table->offset + 0.5);
    return VV_OK;
}

/* Skipping ------------------------------------------------------------------------------------------------------ */

typedef struct visibility {
    const vvi_transfer_table *table; /* NULL: a solid */
    double scale, offset;
    float solid_lo, solid_hi;
} visibility;

static bool visible(const void *user, float lo, float hi)
{
    const visibility *v = user;
    if (!v->table)
        return lo <= v->solid_hi && hi >= v->solid_lo;
    const double a = lo * v->scale + v->offset, b = hi * v->scale + v->offset;
    return vvi_transfer_occupancy(v->table, fmin(a, b), fmax(a, b));
}

typedef struct minmax_request {
    const vv_brick *brick;
    int shift;
} minmax_request;

static vv_status make_minmax(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const minmax_request *r = user;
    vvi_minmax *m = NULL;
    const vv_status st = vvi_minmax_build(&m, r->brick, 0, r->shift, job);
    if (st == VV_OK)
        *bytes_out = (uint64_t)m->n[0] * (uint64_t)m->n[1] * (uint64_t)m->n[2] * 2 * sizeof(float);
    *value_out = m;
    return st;
}

typedef struct skip_request {
    const vvi_minmax *minmax;
    const visibility *visibility;
} skip_request;

static vv_status make_skip(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const skip_request *r = user;
    vvi_skip *skip = NULL;
    const vv_status st = vvi_skip_build(&skip, r->minmax, visible, r->visibility, job);
    *bytes_out = (uint64_t)r->minmax->n[0] * (uint64_t)r->minmax->n[1] * (uint64_t)r->minmax->n[2];
    *value_out = skip;
    return st;
}

static uint64_t hash_visibility(const visibility *v)
{
    const float range[2] = {v->solid_lo, v->solid_hi};
    uint64_t h = vvi_hash(range, sizeof range, 0);
    if (v->table) {
        const double place[4] = {v->table->lo, v->table->hi, v->scale, v->offset};
        h = vvi_hash(place, sizeof place, h);
        h = vvi_hash(v->table->running, (v->table->n + 1) * sizeof *v->table->running, h);
    }
    return h;
}

static vv_status find_blocks(vvi_raycast_state *s, const vv_actor *actor, const visibility *v, int mode, vv_job *job)
{
    vvi_ray_frame *f = &s->frame;
    const int64_t *n = s->hold.brick.box.n;
    minmax_request mr = {.brick = &s->hold.brick};
    /* small blocks fit a surface closer; beyond some millions of them they would no longer fit a cache */
    mr.shift = n[0] * n[1] * n[2] <= (int64_t)1 << 25 ? SHIFT_SMALL : SHIFT_LARGE;
    const uint64_t identity = vv_field_identity(actor->field);
    const vvi_cache_key key = {"minmax", identity, (uint64_t)mr.shift << 32 | (uint32_t)actor->component};
    vv_status st = vvi_cache_get(&s->minmax, &key, make_minmax, vvi_minmax_free, &mr, job);
    if (st != VV_OK)
        return st;
    const vvi_minmax *m = vvi_cached_value(s->minmax);
    memcpy(f->blocks, m->n, sizeof f->blocks);
    f->shift = m->shift;
    if (mode == VVI_RAYCAST_MAXIMUM) {
        f->block_hi = m->hi;
        return VV_OK;
    }
    skip_request sr = {m, v};
    const vvi_cache_key skip_key = {"skip", identity, hash_visibility(v) ^ key.parameters};
    if ((st = vvi_cache_get(&s->skip, &skip_key, make_skip, vvi_skip_free, &sr, job)) != VV_OK)
        return st;
    const vvi_skip *skip = vvi_cached_value(s->skip);
    f->distance = skip->distance;
    if (!skip->n_occupied)
        s->kernel = NULL;
    return VV_OK;
}

/* Putting it together ------------------------------------------------------------------------------------------- */

static void find_solid(vvi_raycast_state *s, const vv_actor *actor, const vvi_raycast_params *p)
{
    vvi_ray_frame *f = &s->frame;
    const bool iso = p->mode == VVI_RAYCAST_ISOSURFACE;
    const double from = !iso ? actor->classes.lo : vv_object_is_set(&p->base, "iso") ? p->iso : actor->iso;
    const double to = iso ? INFINITY : actor->classes.hi;
    const double a = (from - s->hold.value_offset) / s->hold.value_scale;
    const double b = (to - s->hold.value_offset) / s->hold.value_scale;
    f->solid_lo = (float)fmin(a, b);
    f->solid_hi = (float)fmax(a, b);
    memcpy(f->surface_color, actor->color, sizeof f->surface_color);
}

static void choose_kernel(vvi_raycast_state *s, const vv_actor *actor, const vvi_raycast_params *p, vv_job *job)
{
    const vvi_raycast_kernels *k = vvi_raycast_kernels_for(vvi_job_cpu(job));
    const int type = s->frame.lattice.sample_type, nearest = actor->nearest;
    s->kernel = solid(actor, p)                  ? k->surface[type][nearest]
                : p->mode == VVI_RAYCAST_MAXIMUM ? k->maximum[type][nearest]
                : s->frame.shaded                ? k->composite_shaded[type][nearest]
                                                 : k->composite[type][nearest];
    vvi_log(job, VV_LOG_INFO, "raycast", "%s kernels, %d rays at once", k->isa, k->width);
}

static vv_status prepare_actor(vvi_raycast_state *s, const vv_scene *scene, const vv_actor *actor, vv_job *job)
{
    const vvi_raycast_params *p = (const vvi_raycast_params *)scene->params;
    vvi_ray_frame *f = &s->frame;
    vvi_transfer_table table = {0};
    vv_status st = vvi_lattice_open(&s->hold, actor->field, actor->component, job);
    if (st != VV_OK)
        return st;
    f->lattice = s->hold.lattice;
    f->lens = scene->lens;
    f->width = scene->width;
    f->height = scene->height;
    f->row = scene->width;
    f->pixel_x = f->pixel_y = 0.5;
    f->stride = 1;
    const quality_row *q = &by_quality[scene->quality];
    f->step = vv_object_is_set(&p->base, "step") ? p->step : q->step_vox * vvi_actor_voxel(actor);
    f->opaque = (float)(vv_object_is_set(&p->base, "opaque") ? p->opaque : q->opaque);
    if ((st = place(f, actor)) != VV_OK || (st = light(f, scene, actor)) != VV_OK)
        return st;
    scale_gradients(f, actor, s->hold.value_scale);
    if ((st = check_step(f, actor, scene)) != VV_OK)
        return st;
    visibility v = {.scale = s->hold.value_scale, .offset = s->hold.value_offset};
    if (solid(actor, p)) {
        find_solid(s, actor, p);
        v.solid_lo = f->solid_lo;
        v.solid_hi = f->solid_hi;
    } else {
        st = classify(s, &table, actor, job);
        v.table = &table;
    }
    choose_kernel(s, actor, p, job);
    if (st == VV_OK && p->skipping)
        st = find_blocks(s, actor, &v, p->mode, job);
    vvi_transfer_table_finish(&table);
    return st;
}

vv_status vvi_raycast_prepare(void **state_out, const vv_scene *scene, vv_job *job)
{
    *state_out = NULL;
    vvi_raycast_state *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_SCRATCH);
    if (!s)
        return vv_fail_memory(sizeof *s);
    if (scene->n_actors) {
        const vv_status st = prepare_actor(s, scene, &scene->actors[0], job);
        if (st != VV_OK) {
            vvi_raycast_finish(s);
            return st;
        }
    }
    *state_out = s;
    return VV_OK;
}

void vvi_raycast_finish(void *state)
{
    vvi_raycast_state *s = state;
    if (!s)
        return;
    vvi_cache_release(s->skip);
    vvi_cache_release(s->minmax);
    vvi_lattice_close(&s->hold);
    vvi_free(s->alpha);
    vvi_free(s->color);
    vvi_free(s);
}
