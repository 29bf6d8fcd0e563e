/* How much light arrives where: the grid, what is kept of it between frames, and who is told. */
#include "render/raycast/prepare_light.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Cells along the longest side, and altogether at most. */
enum { CELLS_ALONG = 72, MOST_CELLS = 1 << 20 };
#define RADIUS (1.0 / 20) /* of the diagonal */
/* From a surface to the place whose light it gets, in cells along the normal, each as long as it is that way. */
#define AHEAD 2

vvi_lighting vvi_raycast_lighting_of(const vvi_raycast_params *p)
{
    static const vvi_lighting all[] = {
        [VVI_LIGHTING_LOCAL] = {false, false, 1},
        [VVI_LIGHTING_CINEMATIC] = {true, true, 3},
    };
    vvi_lighting l = all[p->lighting];
    if (vvi_raycast_projects(p->mode))
        return all[VVI_LIGHTING_LOCAL];
    if (vv_object_is_set(&p->base, "shadows"))
        l.shadows = p->shadows;
    if (vv_object_is_set(&p->base, "ambient_occlusion"))
        l.ambient_occlusion = p->ambient_occlusion;
    return l;
}

/* The grid ----------------------------------------------------------------------------------------------------------
 */

static void include(double lo[3], double hi[3], const vv_affine *to_frame, vv_vec3 world)
{
    const vv_vec3 p = vv_affine_point(*to_frame, world);
    const double at[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; a++) {
        lo[a] = fmin(lo[a], at[a]);
        hi[a] = fmax(hi[a], at[a]);
    }
}

static vv_vec3 corner(const double lo[3], const double hi[3], int i)
{
    return vvi_vec(i & 1 ? hi[0] : lo[0], i & 2 ? hi[1] : lo[1], i & 4 ? hi[2] : lo[2]);
}

/* Layers are no things in space. */
static bool takes_light(const vvi_raycast_volume *v)
{
    return v->visible && !v->layer;
}

/* All that is drawn, in the frame's indices; false: nothing is. */
static bool find_box(double lo[3], double hi[3], const vvi_light_frame *f, const vvi_raycast_state *s)
{
    vv_affine to_frame, from_mesh;
    bool any = false;
    if (!vv_affine_invert(&to_frame, f->to_world))
        return false;
    for (int a = 0; a < 3; a++) {
        lo[a] = INFINITY;
        hi[a] = -INFINITY;
    }
    for (size_t i = 0; i < s->n_volumes; i++) {
        const vvi_raycast_volume *v = &s->volume[i];
        const int32_t *n = v->hold.lattice.n;
        const double from[3] = {-0.5, -0.5, -0.5}, to[3] = {n[0] - 0.5, n[1] - 0.5, n[2] - 0.5};
        for (int c = 0; c < 8 && takes_light(v); c++)
            include(lo, hi, &to_frame, vv_affine_point(v->actor->index_to_world, corner(from, to, c)));
        any |= takes_light(v);
    }
    for (size_t i = 0; i < s->meshes.n; i++) {
        const vvi_ray_mesh *m = &s->meshes.mesh[i];
        if (!vv_affine_invert(&from_mesh, m->to_mesh))
            continue;
        for (int c = 0; c < 8; c++)
            include(lo, hi, &to_frame, vv_affine_point(from_mesh, corner(m->lo, m->hi, c)));
        any = true;
    }
    return any;
}

static void place_cells(vvi_light_frame *f, const double lo[3], const double hi[3], double length)
{
    for (int a = 0; a < 3; a++) {
        const double voxel = vvi_length(f->to_world.axis[a]);
        f->side[a] = (int32_t)fmin(fmax(round(length / voxel), 1), 1 << 24);
        const double first = floor((lo[a] + 0.5 + 1e-6) / f->side[a]), end = ceil((hi[a] + 0.5 - 1e-6) / f->side[a]);
        f->n[a] = (int32_t)fmin(fmax(end - first, 1) + 2, 1 << 20);
        f->lo[a] = (first - 1) * f->side[a] - 0.5;
    }
}

static double cell_length(const vvi_light_frame *f, const double lo[3], const double hi[3])
{
    double longest = 0;
    for (int a = 0; a < 3; a++)
        longest = fmax(longest, (hi[a] - lo[a]) * vvi_length(f->to_world.axis[a]));
    return fmax(longest, 1e-30) / CELLS_ALONG;
}

/* A grid around a box in the frame's indices, of cells about as long, or longer. */
static void divide(vvi_light_frame *f, const double lo[3], const double hi[3], double length)
{
    place_cells(f, lo, hi, length);
    while ((double)f->n[0] * f->n[1] * f->n[2] > MOST_CELLS)
        place_cells(f, lo, hi, length *= 1.25);
}

uint64_t vvi_raycast_light_bytes(const vv_grid *grid, vvi_lighting lighting)
{
    vvi_light_frame f = {.to_world = grid->index_to_world};
    double lo[3] = {-0.5, -0.5, -0.5}, hi[3];
    if (!lighting.shadows && !lighting.ambient_occlusion)
        return 0;
    for (int a = 0; a < 3; a++)
        hi[a] = (double)grid->dims[a] - 0.5;
    divide(&f, lo, hi, cell_length(&f, lo, hi));
    /* extinction; shares of the ambient light, of lamps; all of them packed, and summed */
    const uint64_t lamps = lighting.shadows ? VVI_LIGHT_LAMPS : 0;
    return vvi_light_cells(f.n) * (sizeof(float) * (2 + lamps) + ((lamps + 4) / 4 + 1) * sizeof(uint32_t));
}

static bool find_frame(vvi_light_frame *f, const vvi_raycast_state *s)
{
    double lo[3], hi[3];
    *f = (vvi_light_frame){.to_world = vv_affine_identity()};
    for (size_t i = 0; i < s->n_volumes && !f->first; i++)
        f->first = takes_light(&s->volume[i]) ? &s->volume[i] : NULL;
    if (f->first)
        f->to_world = f->first->actor->index_to_world;
    if (!find_box(lo, hi, f, s))
        return false;
    const double length = cell_length(f, lo, hi);
    for (int a = 0; a < 3 && !f->first; a++) { /* there are no voxels: cells are */
        f->to_world.axis[a] = vvi_scaled(f->to_world.axis[a], length);
        lo[a] /= length;
        hi[a] /= length;
    }
    divide(f, lo, hi, length);
    return true;
}

static vv_affine cells_to_world(const vvi_light_frame *f)
{
    vv_affine m = f->to_world;
    vv_vec3 first = vvi_vec(f->lo[0] + 0.5 * f->side[0], f->lo[1] + 0.5 * f->side[1], f->lo[2] + 0.5 * f->side[2]);
    m.origin = vv_affine_point(f->to_world, first);
    for (int a = 0; a < 3; a++)
        m.axis[a] = vvi_scaled(m.axis[a], f->side[a]);
    return m;
}

/* What is kept ------------------------------------------------------------------------------------------------------
 */

typedef struct request {
    const vvi_raycast_state *state;
    const vv_scene *scene;
    vvi_light_frame frame;
    vvi_lighting lighting;
    double radius, disc;
    uint64_t identity, hash, light; /* of the extinction, and of the shares */
    vvi_cached *extinction, *ambient;
} request;

static uint64_t hash_volume(const vvi_raycast_volume *v, uint64_t h)
{
    const vvi_march_volume *f = &v->ray;
    const vvi_classifier *b = &f->classifier;
    const uint64_t identity = vv_field_identity(v->actor->field);
    const int kinds[4] = {v->actor->component, v->solid, b->kind, f->sampler.cubic};
    const float numbers[] = {f->solid.lo,
                             f->solid.hi,
                             f->classifier.entry_scale,
                             f->classifier.entry_shift,
                             b->modulate_scale,
                             b->modulate_power,
                             b->plane_scale,
                             b->plane_shift,
                             b->plane_gradient};
    h = vvi_hash(&identity, sizeof identity, h);
    h = vvi_hash(kinds, sizeof kinds, h);
    h = vvi_hash(numbers, sizeof numbers, h);
    h = vvi_hash(&f->step, sizeof f->step, h);
    h = vvi_hash(f->sampler.world_to_index, sizeof f->sampler.world_to_index, h);
    h = vvi_hash(f->sampler.planes, f->sampler.n_planes * sizeof *f->sampler.planes, h);
    if (v->solid)
        return h;
    if (b->kind == VVI_CLASSIFY_PLANE)
        return vvi_hash(b->plane, 4 * sizeof(float) * VVI_PLANE_SIDE * VVI_PLANE_SIDE, h);
    for (size_t i = 0; i < v->n_rows; i++) /* colours do not matter */
        h = vvi_hash(&f->classifier.color[4 * i + 3], sizeof *f->classifier.color, h);
    return h;
}

static uint64_t hash_mesh(const vvi_ray_mesh *m, uint64_t h)
{
    const vv_mesh_actor *a = m->actor;
    const uint32_t checksum = vv_mesh_checksum(a->mesh);
    h = vvi_hash(&checksum, sizeof checksum, h);
    h = vvi_hash(&m->to_mesh, sizeof m->to_mesh, h);
    h = vvi_hash(&a->opacity, sizeof a->opacity, h);
    h = vvi_hash(&a->one_color, sizeof a->one_color, h);
    for (size_t i = 0; i < a->look.n_planes; i++)
        h = vvi_hash(&a->look.planes[i], sizeof a->look.planes[i], h);
    if (m->translucent && a->colors)
        h = vvi_hash(a->colors, 4 * m->shown.n_vertices, h);
    return h;
}

static void hash_extinction(request *r)
{
    const vvi_raycast_state *s = r->state;
    uint64_t h = vvi_hash(r->frame.n, sizeof r->frame.n, 0);
    h = vvi_hash(r->frame.side, sizeof r->frame.side, h);
    h = vvi_hash(r->frame.lo, sizeof r->frame.lo, h);
    for (size_t i = 0; i < s->n_volumes; i++)
        if (takes_light(&s->volume[i]))
            h = hash_volume(&s->volume[i], h);
    for (size_t i = 0; i < s->meshes.n; i++)
        h = hash_mesh(&s->meshes.mesh[i], h);
    r->hash = h;
    r->identity = r->frame.first ? vv_field_identity(r->frame.first->actor->field) : 0;
}

static uint64_t floats_of(const request *r)
{
    return vvi_light_cells(r->frame.n) * sizeof(float);
}

static vv_status make_extinction(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    *bytes_out = floats_of(r);
    float *cells = *value_out = vvi_alloc(job, *bytes_out, VVI_MEM_DERIVED);
    if (!cells)
        return vv_fail_memory(*bytes_out);
    vvi_light_grid grid = {.cell_to_world = cells_to_world(&r->frame)};
    memcpy(grid.n, r->frame.n, sizeof grid.n);
    vv_status st = vvi_raycast_fill_extinction(cells, &r->frame, r->state, job);
    if (st == VV_OK)
        st = vvi_raycast_add_meshes(cells, &grid, &r->state->meshes, job);
    if (st != VV_OK) {
        vvi_free(cells);
        *value_out = NULL;
    }
    return st;
}

static vv_status get_grid(vvi_light_grid *g, request *r, vv_job *job)
{
    const vvi_cache_key key = {"light extinction", r->identity, r->hash};
    const vv_status st = r->extinction ? VV_OK : vvi_cache_get(&r->extinction, &key, make_extinction, vvi_free, r, job);
    if (st != VV_OK)
        return st;
    memcpy(g->n, r->frame.n, sizeof g->n);
    g->cell_to_world = cells_to_world(&r->frame);
    g->extinction = vvi_cached_value(r->extinction);
    return VV_OK;
}

static vv_status make_ambient(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    request *r = user;
    vvi_light_grid grid;
    *bytes_out = floats_of(r);
    vv_status st = get_grid(&grid, r, job);
    if (st != VV_OK)
        return st;
    float *cells = *value_out = vvi_alloc(job, *bytes_out, VVI_MEM_DERIVED);
    if (!cells)
        return vv_fail_memory(*bytes_out);
    if ((st = vvi_light_ambient(cells, &grid, r->radius, job)) != VV_OK) {
        vvi_free(cells);
        *value_out = NULL;
    }
    return st;
}

static size_t lamps_of(const request *r)
{
    return r->lighting.shadows ? r->scene->n_lamps : 0;
}

static vv_status fill_cells(uint32_t *cells, request *r, vv_job *job)
{
    const size_t n_cells = vvi_light_cells(r->frame.n), n = lamps_of(r), bytes = n * n_cells * sizeof(float);
    const float *shares[VVI_LIGHT_SHARES] = {r->ambient ? vvi_cached_value(r->ambient) : NULL};
    float *of_lamps[VVI_LIGHT_LAMPS] = {0};
    vvi_light_grid grid;
    vv_status st = n ? get_grid(&grid, r, job) : VV_OK;
    float *room = st == VV_OK && n ? vvi_alloc(job, bytes, VVI_MEM_SCRATCH) : NULL;
    if (st == VV_OK && n && !room)
        st = vv_fail_memory(bytes);
    for (size_t i = 0; i < n && room; i++)
        shares[i + 1] = of_lamps[i] = room + i * n_cells;
    if (room)
        st = vvi_light_lamps(of_lamps, &grid, r->scene->lamps, n, r->disc, job);
    if (st == VV_OK)
        vvi_light_pack(cells, shares, (int)n + 1, n_cells);
    vvi_free(room);
    return st;
}

static uint64_t cells_bytes(const request *r)
{
    return vvi_light_cells(r->frame.n) * (lamps_of(r) + 4) / 4 * sizeof(uint32_t);
}

static vv_status make_cells(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    request *r = user;
    uint64_t h = vvi_hash(&r->radius, sizeof r->radius, r->hash);
    const vvi_cache_key key = {"light ambient", r->identity, h};
    vv_status st = VV_OK;
    *bytes_out = cells_bytes(r);
    if (r->lighting.ambient_occlusion)
        st = vvi_cache_get(&r->ambient, &key, make_ambient, vvi_free, r, job);
    if (st != VV_OK)
        return st;
    uint32_t *cells = *value_out = vvi_alloc(job, *bytes_out, VVI_MEM_DERIVED);
    if (!cells)
        return vv_fail_memory(*bytes_out);
    if ((st = fill_cells(cells, r, job)) != VV_OK) {
        vvi_free(cells);
        *value_out = NULL;
    }
    return st;
}

static vv_status get_cells(vvi_cached **out, request *r, vv_job *job)
{
    uint64_t h = vvi_hash(&r->radius, sizeof r->radius, r->hash);
    h = vvi_hash(&r->disc, sizeof r->disc, h);
    h = vvi_hash(&(int[2]){r->lighting.shadows, r->lighting.ambient_occlusion}, 2 * sizeof(int), h);
    for (size_t i = 0; i < lamps_of(r); i++) {
        const vv_lamp *l = &r->scene->lamps[i];
        const double place[7] = {l->kind,        l->position.x,  l->position.y, l->position.z,
                                 l->direction.x, l->direction.y, l->direction.z};
        h = vvi_hash(place, sizeof place, h);
    }
    r->light = h;
    const vvi_cache_key key = {"light", r->identity, h};
    const vv_status st = vvi_cache_get(out, &key, make_cells, vvi_free, r, job);
    vvi_cache_release(r->extinction);
    vvi_cache_release(r->ambient);
    return st;
}

/* Who is told -------------------------------------------------------------------------------------------------------
 */

static double brightness(const float rgb[3])
{
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
}

/* What is not shaded scatters all light alike. */
static void weigh(vvi_light_volume *l, const vv_scene *scene)
{
    double sum = brightness(scene->ambient) * (double)l->ambient;
    for (size_t i = 0; i < scene->n_lamps; i++)
        sum += brightness(scene->lamps[i].color);
    const double each = sum > 0 ? 1 / sum : 0;
    l->scatter[0] = (float)(brightness(scene->ambient) * each);
    double rest = sum > 0 ? 1 - brightness(scene->ambient) * (double)l->ambient * each : 1;
    for (int i = 1; i < l->n_shares; i++) {
        l->scatter[i] = (float)(brightness(scene->lamps[i - 1].color) * each);
        rest -= (double)l->scatter[i];
    }
    l->scatter_rest = (float)fmax(rest, 0);
}

static bool is_any_unlit(const vvi_raycast_state *s)
{
    bool any = false;
    for (size_t i = 0; i < s->n_volumes; i++)
        any |= s->volume[i].ray.light.unlit;
    for (size_t i = 0; i < s->meshes.n; i++)
        any |= s->meshes.mesh[i].actor->look.shading_model == VV_SHADING_NONE;
    return any;
}

static vv_status make_scattered(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const vvi_light_volume *l = user;
    *bytes_out = vvi_light_cells(l->n) * sizeof(uint32_t);
    uint32_t *cells = *value_out = vvi_alloc(job, *bytes_out, VVI_MEM_DERIVED);
    if (!cells)
        return vv_fail_memory(*bytes_out);
    vvi_light_pack_scattered(cells, l);
    return VV_OK;
}

/* Lamps that only get brighter or darker leave the shares, but not their sum. */
static vv_status get_scattered(vvi_raycast_state *s, const request *r, vv_job *job)
{
    vvi_light_volume *l = &s->light;
    uint64_t h = vvi_hash(l->scatter, sizeof l->scatter, r->light);
    h = vvi_hash((float[2]){l->scatter_rest, l->ambient}, 2 * sizeof(float), h);
    const vvi_cache_key key = {"light scattered", r->identity, h};
    const vv_status st = vvi_cache_get(&s->scattered, &key, make_scattered, vvi_free, l, job);
    if (st == VV_OK)
        l->scattered = vvi_cached_value(s->scattered);
    return st;
}

static void tell(vvi_raycast_volume *v, const vvi_light_volume *l, const vv_affine *to_cell)
{
    vvi_light *light = &v->ray.light;
    const vv_affine m = vv_affine_compose(*to_cell, v->actor->index_to_world);
    light->volume = *l;
    for (int a = 0; a < 3; a++) {
        const double axis[3] = {l->ahead[a].x, l->ahead[a].y, l->ahead[a].z};
        for (int b = 0; b < 3; b++)
            light->ahead[a][b] = (float)axis[b];
    }
    for (int b = 0; b < 4; b++) {
        const vv_vec3 from = b < 3 ? m.axis[b] : m.origin, ahead = b < 3 ? to_cell->axis[b] : vvi_vec(0, 0, 0);
        const double column[3] = {from.x, from.y, from.z}, way[3] = {ahead.x, ahead.y, ahead.z};
        for (int a = 0; a < 3; a++) {
            light->cell_from_index[a][b] = (float)column[a];
            if (b < 3)
                light->cell_from_world[a][b] = (float)way[a];
        }
    }
}

static vv_status tell_all(vvi_raycast_state *s, const request *r, vv_job *job)
{
    const vv_affine to_world = cells_to_world(&r->frame);
    vvi_light_volume *l = &s->light;
    vv_affine to_cell;
    if (!vv_affine_invert(&to_cell, to_world))
        return vv_fail(VV_E_ARGUMENT, "light: the cells of its grid have no volume");
    l->cells = vvi_cached_value(s->cells);
    memcpy(l->n, r->frame.n, sizeof l->n);
    l->n_shares = 1 + (int)lamps_of(r);
    l->n_words = (l->n_shares + 3) / 4;
    l->ambient = r->lighting.ambient;
    for (int a = 0; a < 3; a++)
        l->ahead[a] = vvi_scaled(to_world.axis[a], AHEAD);
    for (int a = 0; a < 3; a++) {
        const vv_affine *m = &to_cell;
        const double row[3][4] = {{m->axis[0].x, m->axis[1].x, m->axis[2].x, m->origin.x},
                                  {m->axis[0].y, m->axis[1].y, m->axis[2].y, m->origin.y},
                                  {m->axis[0].z, m->axis[1].z, m->axis[2].z, m->origin.z}};
        memcpy(l->world_to_cell[a], row[a], sizeof row[a]);
    }
    weigh(l, s->meshes.scene);
    const vv_status st = is_any_unlit(s) ? get_scattered(s, r, job) : VV_OK;
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < s->n_volumes; i++)
        tell(&s->volume[i], l, &to_cell);
    s->meshes.light = l;
    return VV_OK;
}

/* Of what is lit: volumes have their own mode. */
static const vvi_raycast_params *lit_params(const vvi_raycast_state *s, const vv_scene *scene)
{
    for (size_t i = 0; i < s->n_volumes; i++)
        if (!s->volume[i].layer)
            return s->volume[i].params;
    return (const vvi_raycast_params *)scene->params;
}

vv_status vvi_raycast_find_light(vvi_raycast_state *s, const vv_scene *scene, vv_job *job)
{
    const vvi_raycast_params *p = lit_params(s, scene);
    request r = {.state = s, .scene = scene, .lighting = vvi_raycast_lighting_of(p), .disc = p->lamp_size};
    if ((!r.lighting.shadows && !r.lighting.ambient_occlusion) || !find_frame(&r.frame, s))
        return VV_OK;
    if (lamps_of(&r) > VVI_LIGHT_LAMPS)
        return vv_fail(VV_E_UNSUPPORTED,
                       "lights: %zu are on and cast shadows; ray casting takes at most %d with shadows, so switch some "
                       "off",
                       scene->n_lamps, VVI_LIGHT_LAMPS);
    vv_vec3 diagonal = {0, 0, 0};
    for (int a = 0; a < 3; a++)
        diagonal =
            vvi_add(diagonal, vvi_scaled(r.frame.to_world.axis[a], (double)(r.frame.n[a] - 2) * r.frame.side[a]));
    r.radius = vv_object_is_set(&p->base, "occlusion_radius") ? p->occlusion_radius : RADIUS * vvi_length(diagonal);
    hash_extinction(&r);
    const vv_status st = get_cells(&s->cells, &r, job);
    return st == VV_OK ? tell_all(s, &r, job) : st;
}
