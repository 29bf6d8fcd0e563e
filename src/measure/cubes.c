/* Marching Cubes without a mesh: area, volume and centroid of what is inside, cell by cell. Volume is the divergence
 * theorem in each cell, its origin in the cell's first corner: then only the triangles and three faces of the cell
 * count, nothing large cancels, and the volume's border needs no cap. Cells that planes cut are polyhedra of their own.
 */
#include "measure/cell.h"
#include "measure/sums.h"

#include "core/job.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>

typedef struct shared {
    const vvi_object *object;
    const vvi_region *region; /* where every step-th sample counts */
    const int64_t *inner;
    vv_affine to_world;
    double side[3]; /* world lengths of a cell */
    double face[3]; /* world area of a cell's face across each axis */
    vvi_cubes_sums *part;
} shared;

typedef struct worker {
    vvi_chain chain, other;
    uint64_t *slice[2];
} worker;

/* The cell at hand. */
typedef struct place {
    int64_t at[3];
    double depth[8];
    unsigned pattern;
    bool inner;
} place;

static vv_status start(void **scratch_out, void *user, int number)
{
    (void)number;
    const shared *s = user;
    const size_t slice = (size_t)s->object->n[1] * s->object->words;
    const size_t bytes = sizeof(worker) + 2 * slice * sizeof(uint64_t);
    worker *w = vvi_alloc(s->object->job, bytes, VVI_MEM_SCRATCH);
    *scratch_out = w;
    if (!w)
        return vv_fail_memory(bytes);
    w->slice[0] = (uint64_t *)(w + 1);
    w->slice[1] = w->slice[0] + slice;
    return VV_OK;
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

static vv_vec3 cell_origin(const place *c)
{
    return vvi_vec((double)c->at[0], (double)c->at[1], (double)c->at[2]);
}

/* Bit f: face f of the cell lies on the volume's border. */
static unsigned border_faces(const shared *s, const place *c)
{
    unsigned faces = 0;
    for (int a = 0; a < 3; a++) {
        faces |= (unsigned)(c->at[a] == 0) << (2 * a);
        faces |= (unsigned)(c->at[a] == s->object->n[a] - 2) << (2 * a + 1);
    }
    return faces;
}

static void add_volume(vvi_cubes_sums *t, const place *c, double volume, const double moment[3])
{
    t->volume += volume;
    t->inner_volume += c->inner ? volume : 0;
    for (int a = 0; a < 3; a++)
        t->moment[a] += moment[a] + volume * (double)c->at[a];
}

static void add_area(vvi_cubes_sums *t, const place *c, double area)
{
    t->area += area;
    t->inner_area += c->inner ? area : 0;
}

static double world_area(const vv_affine *m, const vv_vec3 p[3])
{
    const vv_vec3 u = vv_affine_vector(*m, vvi_sub(p[1], p[0])), v = vv_affine_vector(*m, vvi_sub(p[2], p[0]));
    const vv_vec3 n = vvi_cross(u, v);
    return sqrt(vvi_dot(n, n)) / 2;
}

/* Cells that are whole ----------------------------------------------------------------------------------------------
 */

/* The mean of u^2 over a triangle, times 6. */
static double squares(double a, double b, double c)
{
    return a * a + b * b + c * c + a * b + a * c + b * c;
}

/* A sixth of p . n times twice the area, and the flux of (x^2, y^2, z^2) / 2. */
static double add_flux(double moment[3], const vv_vec3 p[3])
{
    const vv_vec3 n = vvi_cross(vvi_sub(p[1], p[0]), vvi_sub(p[2], p[0]));
    moment[0] += n.x / 24 * squares(p[0].x, p[1].x, p[2].x);
    moment[1] += n.y / 24 * squares(p[0].y, p[1].y, p[2].y);
    moment[2] += n.z / 24 * squares(p[0].z, p[1].z, p[2].z);
    return vvi_dot(p[0], n) / 6;
}

static void add_surface_point(vvi_cubes_sums *t, const shared *s, const place *c, vv_vec3 p)
{
    const vv_vec3 at = vv_affine_point(s->to_world, vvi_add(p, cell_origin(c)));
    vvi_bounds_add(&t->bounds, at);
    vvi_bounds_add(&t->surface, at);
}

static void take_whole(vvi_cubes_sums *t, const shared *s, const place *c)
{
    vvi_cell cell;
    double area = 0, volume = 0, moment[3] = {0, 0, 0};
    const unsigned border = border_faces(s, c);
    vvi_cell_triangles(&cell, c->depth, c->pattern);
    for (int i = 0; i < cell.n; i++) {
        const uint8_t *corner = cell.triangle + 3 * i;
        const vv_vec3 p[3] = {cell.point[corner[0]], cell.point[corner[1]], cell.point[corner[2]]};
        area += world_area(&s->to_world, p);
        volume += add_flux(moment, p);
    }
    for (int f = 0; f < 6; f++) {
        if (!(f & 1) && !(border >> f & 1))
            continue;
        const double part = vvi_cell_face_area(c->depth, c->pattern, f);
        t->cut_area += border >> f & 1 ? part * s->face[f / 2] : 0;
        volume += f & 1 ? part / 3 : 0;
        moment[f / 2] += f & 1 ? part / 2 : 0;
    }
    for (unsigned left = cell.points; left; left &= left - 1)
        add_surface_point(t, s, c, cell.point[__builtin_ctz(left)]);
    add_area(t, c, area);
    add_volume(t, c, volume, moment);
}

/* Cells that planes cut ---------------------------------------------------------------------------------------------
 */

/* Of a triangle of the cap: negative where it takes back what another gave too much. */
static double signed_area(const vv_affine *m, const vvi_chain_triangle *t)
{
    const vv_vec3 n = vvi_cross(vvi_sub(t->p[1], t->p[0]), vvi_sub(t->p[2], t->p[0]));
    return copysign(world_area(m, t->p), vvi_dot(n, t->outwards));
}

static void add_chain(vvi_cubes_sums *t, const shared *s, const place *c, const vvi_chain *chain)
{
    double area = 0, volume = 0, moment[3] = {0, 0, 0};
    for (int i = 0; i < chain->n; i++) {
        const vvi_chain_triangle *now = &chain->triangle[i];
        volume += add_flux(moment, now->p);
        area += now->part == VVI_CHAIN_SURFACE ? world_area(&s->to_world, now->p) : 0;
        t->cut_area += now->part == VVI_CHAIN_BORDER ? world_area(&s->to_world, now->p) : 0;
        t->cut_area += now->part == VVI_CHAIN_CUT ? signed_area(&s->to_world, now) : 0;
        for (int k = 0; k < 3 && now->part == VVI_CHAIN_SURFACE; k++)
            add_surface_point(t, s, c, now->p[k]);
        for (int k = 0; k < 3 && now->part != VVI_CHAIN_CUT; k++) /* cuts lie between the others */
            vvi_bounds_add(&t->bounds, vv_affine_point(s->to_world, vvi_add(now->p[k], cell_origin(c))));
    }
    add_area(t, c, area);
    add_volume(t, c, volume, moment);
}

static void fill_chain(vvi_chain *chain, const shared *s, const place *c)
{
    vvi_cell cell = {0};
    const unsigned border = border_faces(s, c);
    chain->n = 0;
    chain->full = false;
    if (c->pattern != 255)
        vvi_cell_triangles(&cell, c->depth, c->pattern);
    for (int i = 0; i < cell.n; i++)
        vvi_chain_add(chain, VVI_CHAIN_SURFACE, cell.point[cell.triangle[3 * i]], cell.point[cell.triangle[3 * i + 1]],
                      cell.point[cell.triangle[3 * i + 2]]);
    for (int f = 0; f < 6; f++)
        vvi_cell_face(chain, border >> f & 1 ? VVI_CHAIN_BORDER : VVI_CHAIN_WALL, c->depth, c->pattern, f);
}

static bool meets(const vv_plane *plane, const vvi_chain *chain)
{
    for (int i = 0; i < chain->n; i++)
        for (int k = 0; k < 3; k++)
            if (vvi_dot(plane->normal, chain->triangle[i].p[k]) < plane->offset + 1e-8)
                return true;
    return false;
}

static vv_status take_cut(vvi_cubes_sums *t, worker *w, const shared *s, const place *c)
{
    fill_chain(&w->chain, s, c);
    for (int p = 0; p < s->region->n; p++) {
        vv_plane plane = s->region->plane[p];
        plane.offset -= vvi_dot(plane.normal, cell_origin(c));
        if (meets(&plane, &w->chain))
            vvi_chain_cut(&w->chain, &w->other, &plane);
    }
    if (w->chain.full)
        return vv_fail(VV_E_LIMIT, "too many cut planes meet in one cell");
    add_chain(t, s, c, &w->chain);
    return VV_OK;
}

/* Rows of cells -----------------------------------------------------------------------------------------------------
 */

/* Whether all samples around an edge that is crossed are one of two numbers: then nothing lies in between. */
static void note_values(vvi_cubes_sums *t, const place *c)
{
    for (int i = 0; i < 8 && !t->between; i++) {
        const bool in = c->pattern >> i & 1;
        double *const seen = in ? &t->most : &t->least;
        if (isnan(*seen))
            *seen = c->depth[i];
        t->between = *seen != c->depth[i];
    }
}

/* How many an item reads that begins there. */
static int64_t slices_from(const vvi_object *o, int64_t first)
{
    const int64_t left = o->n[2] - first;
    return left < VVI_MEASURE_LAYERS + 1 ? left : VVI_MEASURE_LAYERS + 1;
}

/* Whether an edge that is crossed is a step: the neighbours beyond both ends have the values of the ends, so there is
 * no ramp. Each edge belongs to the cell that begins with it; those at the border have no neighbours to ask. */
static void note_steps(vvi_cubes_sums *t, const shared *s, const place *c, const vv_brick *brick, int64_t first_slice)
{
    const vvi_object *o = s->object;
    for (int a = 0; a < 3; a++) {
        double d[4];
        const int64_t at = c->at[a] - (a == 2 ? first_slice : 0), n = a == 2 ? slices_from(o, first_slice) : o->n[a];
        if ((c->pattern & 1) == (c->pattern >> (1 << a) & 1) || at < 1 || at + 2 >= n)
            continue;
        for (int i = 0; i < 4; i++)
            d[i] = vvi_object_depth(o, brick, c->at[0] + (a == 0 ? i - 1 : 0), c->at[1] + (a == 1 ? i - 1 : 0),
                                    c->at[2] - first_slice + (a == 2 ? i - 1 : 0));
        t->crossed++;
        t->stepped += (d[0] == d[1] || d[0] == d[2]) && (d[3] == d[1] || d[3] == d[2]);
    }
}

/* Below that an edge or a corner passes through a cell: spheres of three voxels are above it (docs/measurement.md). */
#define SMOOTH 0.96

/* Whether the gradients at the corners point different ways: the length of their sum is much less than their lengths'
 * sum. */
static bool is_sharp(const shared *s, const double depth[8])
{
    vv_vec3 sum = {0, 0, 0};
    double lengths = 0;
    for (int i = 0; i < 8; i++) {
        const vv_vec3 g = {(depth[i | 1] - depth[i & ~1]) / s->side[0], (depth[i | 2] - depth[i & ~2]) / s->side[1],
                           (depth[i | 4] - depth[i & ~4]) / s->side[2]};
        sum = vvi_add(sum, g);
        lengths += vvi_length(g);
    }
    return vvi_length(sum) < SMOOTH * lengths;
}

/* What belongs to another piece than the tracked one is outside, however deep it is. */
static bool fetch(place *c, const shared *s, const vv_brick *brick, int64_t first_slice)
{
    for (int i = 0; i < 8; i++) {
        const double d = vvi_object_depth(s->object, brick, c->at[0] + (i & 1), c->at[1] + (i >> 1 & 1),
                                          c->at[2] - first_slice + (i >> 2));
        if (isnan(d))
            return false;
        c->depth[i] = c->pattern >> i & 1 ? fmin(fmax(d, 0), 1e150) : d < 0 ? fmax(d, -1e150) : d > 0 ? -d : -1e-150;
    }
    return true;
}

/* Cells inside all over, none of them cut: bits of word w. */
static void take_full(vvi_cubes_sums *t, const shared *s, uint64_t full, int64_t w, const place *row)
{
    const vvi_interval inner = {0, row->inner ? s->inner[0] : 0};
    const int64_t n = __builtin_popcountll(full), places = 64 * w * n + vvi_sum_of_places(full);
    place c = *row;
    if (!n)
        return;
    t->volume += (double)n;
    t->inner_volume += __builtin_popcountll(full & vvi_interval_bits(inner, w));
    t->moment[0] += (double)places + 0.5 * (double)n;
    t->moment[1] += ((double)row->at[1] + 0.5) * (double)n;
    t->moment[2] += ((double)row->at[2] + 0.5) * (double)n;
    c.at[0] = -1; /* of the row: faces across y and z */
    for (unsigned left = border_faces(s, &c) & ~3u; left; left &= left - 1)
        t->cut_area += (double)n * s->face[__builtin_ctz(left) / 2];
    const int64_t ends[2] = {0, s->object->n[0] - 2};
    for (int e = 0; e < 2; e++)
        t->cut_area += ends[e] >> 6 == w && full >> (ends[e] & 63) & 1 ? s->face[0] : 0;
    const int64_t x[2] = {64 * w + __builtin_ctzll(full), 64 * w + 64 - __builtin_clzll(full)};
    for (int i = 0; i < 8; i++)
        vvi_bounds_add(&t->bounds,
                       vv_affine_point(s->to_world, vvi_vec((double)x[i & 1], (double)(row->at[1] + (i >> 1 & 1)),
                                                            (double)(row->at[2] + (i >> 2)))));
}

typedef struct row_of_cells {
    const uint64_t *bits[4];
    vvi_interval whole, touched;
} row_of_cells;

static vv_status take_active(vvi_cubes_sums *t, worker *w, const shared *s, place *c, bool whole)
{
    const double before = t->area;
    vv_status st = VV_OK;
    if (c->pattern != 255)
        note_values(t, c);
    if (!whole)
        st = take_cut(t, w, s, c);
    else
        take_whole(t, s, c);
    t->sharp_area += t->area > before && is_sharp(s, c->depth) ? t->area - before : 0;
    return st;
}

static vv_status take_row(vvi_cubes_sums *t, worker *w, const shared *s, const row_of_cells *r, const vv_brick *brick,
                          int64_t first_slice, const place *row)
{
    const int64_t words = (int64_t)s->object->words - 1;
    const vvi_interval cells = {0, s->object->n[0] - 1};
    vv_status st = VV_OK;
    for (int64_t word = 0; word < words; word++) {
        uint64_t b[8], any = 0, all = ~(uint64_t)0;
        for (int i = 0; i < 4; i++) {
            b[2 * i] = r->bits[i][word];
            b[2 * i + 1] = r->bits[i][word] >> 1 | r->bits[i][word + 1] << 63;
            any |= b[2 * i] | b[2 * i + 1];
            all &= b[2 * i] & b[2 * i + 1];
        }
        const uint64_t whole = vvi_interval_bits(r->whole, word) & vvi_interval_bits(cells, word);
        const uint64_t touched = vvi_interval_bits(r->touched, word) & vvi_interval_bits(cells, word);
        take_full(t, s, all & whole, word, row);
        for (uint64_t left = any & touched & ~(all & whole); left && st == VV_OK; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            place c = *row;
            c.at[0] = 64 * word + bit;
            c.inner = row->inner && c.at[0] < s->inner[0];
            c.pattern = 0;
            for (int i = 0; i < 8; i++)
                c.pattern |= (unsigned)(b[i] >> bit & 1) << i;
            if (!fetch(&c, s, brick, first_slice)) {
                t->unknown++;
                continue;
            }
            note_steps(t, s, &c, brick, first_slice);
            st = take_active(t, w, s, &c, whole >> bit & 1);
        }
    }
    return st;
}

static vv_status take_layer(vvi_cubes_sums *t, worker *w, const shared *s, const vv_brick *brick, int64_t first_slice,
                            int64_t k)
{
    const vvi_object *o = s->object;
    vv_status st = VV_OK;
    for (int64_t j = 0; j + 1 < o->n[1] && st == VV_OK; j++) {
        const uint64_t *const low = w->slice[0] + (size_t)j * o->words, *const high =
                                                                            w->slice[1] + (size_t)j * o->words;
        const row_of_cells r = {.bits = {low, low + o->words, high, high + o->words},
                                .whole = vvi_region_cells(s->region, false, j, k, 0, o->n[0] - 1),
                                .touched = vvi_region_cells(s->region, true, j, k, 0, o->n[0] - 1)};
        const place row = {.at = {0, j, k}, .inner = j < s->inner[1] && k < s->inner[2]};
        if (r.touched.lo < r.touched.end)
            st = take_row(t, w, s, &r, brick, first_slice, &row);
    }
    return st;
}

static vv_status item(void *scratch, void *user, size_t index)
{
    worker *w = scratch;
    shared *s = user;
    const vvi_object *o = s->object;
    vvi_cubes_sums *t = &s->part[index];
    const int64_t first = (int64_t)index * VVI_MEASURE_LAYERS, n_slices = slices_from(o, first);
    const int64_t end = first + n_slices - 1;
    vv_brick brick;
    t->bounds = t->surface = vvi_bounds_none();
    t->least = t->most = NAN;
    vv_status st = vvi_object_brick(&brick, o, first, n_slices);
    if (st != VV_OK)
        return st;
    st = vvi_object_slice(w->slice[0], o, first);
    for (int64_t k = first; k < end && st == VV_OK; k++) {
        st = vvi_object_slice(w->slice[1], o, k + 1);
        if (st == VV_OK)
            st = take_layer(t, w, s, &brick, first, k);
        uint64_t *const next = w->slice[0];
        w->slice[0] = w->slice[1];
        w->slice[1] = next;
    }
    vv_brick_release(&brick);
    return st;
}

/* Joining -----------------------------------------------------------------------------------------------------------
 */

static void join_value(vvi_cubes_sums *t, double *seen, double other)
{
    if (isnan(other))
        return;
    t->between |= !isnan(*seen) && *seen != other;
    *seen = other;
}

static void join(vvi_cubes_sums *t, const vvi_cubes_sums *part)
{
    t->area += part->area;
    t->cut_area += part->cut_area;
    t->volume += part->volume;
    t->inner_area += part->inner_area;
    t->inner_volume += part->inner_volume;
    for (int a = 0; a < 3; a++)
        t->moment[a] += part->moment[a];
    t->unknown += part->unknown;
    t->sharp_area += part->sharp_area;
    t->crossed += part->crossed;
    t->stepped += part->stepped;
    t->between |= part->between;
    join_value(t, &t->least, part->least);
    join_value(t, &t->most, part->most);
    vvi_bounds_join(&t->bounds, &part->bounds);
    vvi_bounds_join(&t->surface, &part->surface);
}

static void make_frame(shared *s)
{
    s->to_world = vv_field_get_info(s->object->field)->grid.index_to_world;
    for (int a = 0; a < 3; a++)
        s->to_world.axis[a] = vvi_scaled(s->to_world.axis[a], (double)s->object->step);
    for (int a = 0; a < 3; a++)
        s->side[a] = vvi_length(s->to_world.axis[a]);
    for (int a = 0; a < 3; a++)
        s->face[a] = vvi_length(vvi_cross(s->to_world.axis[(a + 1) % 3], s->to_world.axis[(a + 2) % 3]));
}

/* From cells of `step` samples to those of one. */
static void scale(vvi_cubes_sums *t, double step)
{
    const double cell = step * step * step;
    t->volume *= cell;
    t->inner_volume *= cell;
    for (int a = 0; a < 3; a++)
        t->moment[a] *= cell * step;
}

vv_status vvi_cubes_object(vvi_cubes_sums *out, const vvi_object *object, const vvi_region *region,
                           const int64_t inner[3])
{
    static const vvi_work work = {.stage = "surface", .start = start, .item = item, .finish = finish};
    const vvi_region coarse = vvi_region_coarse(region, object->step);
    shared s = {.object = object, .region = &coarse, .inner = inner};
    *out = (vvi_cubes_sums){.bounds = vvi_bounds_none(), .surface = vvi_bounds_none(), .least = NAN, .most = NAN};
    if (object->n[0] < 2 || object->n[1] < 2 || object->n[2] < 2)
        return VV_OK;
    const size_t n = (size_t)(object->n[2] - 2) / VVI_MEASURE_LAYERS + 1;
    make_frame(&s);
    s.part = vvi_alloc_zeroed(object->job, n * sizeof *s.part, VVI_MEM_SCRATCH);
    if (!s.part)
        return vv_fail_memory(n * sizeof *s.part);
    const vv_status st = vvi_parallel_for(object->job, &work, &s, n);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        join(out, &s.part[i]);
    scale(out, (double)object->step);
    vvi_free(s.part);
    return st;
}
