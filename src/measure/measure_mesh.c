#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/mesh.h"
#include "grid/mesh_normals.h"
#include "measure/mass_kernel.h"
#include "surface/vertex_places.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/measure_mesh.h>

enum { BLOCK = VVI_MASS_BLOCK };

/* A run of a mesh's triangles while it is measured. */
typedef struct run {
    const vv_mesh_info *mesh;
    const vv_mesh_measure_options *options;
    const uint32_t *triangles;
    size_t n;
    bool whole;
    vvi_mass_block block; /* of all; an item sets triangles and n */
    const vvi_mass_kernels *kernels;
    vv_affine map;    /* of positions to the world */
    vv_bounds *boxes; /* one a block of vertices, in the world or, first, of positions */
    bool in_world;
    double (*sums)[VVI_MASS_SUMS]; /* one row a block of triangles */
    uint64_t *edges;
} run;

static size_t blocks_of(size_t n)
{
    return n / BLOCK + (n % BLOCK != 0);
}

/* Boxes -------------------------------------------------------------------------------------------------------------
 */

static size_t n_corners(const run *r)
{
    return r->whole ? r->mesh->n_vertices : 3 * r->n;
}

static void widen(vv_bounds *b, vv_vec3 p)
{
    b->lo.x = p.x < b->lo.x ? p.x : b->lo.x;
    b->lo.y = p.y < b->lo.y ? p.y : b->lo.y;
    b->lo.z = p.z < b->lo.z ? p.z : b->lo.z;
    b->hi.x = p.x > b->hi.x ? p.x : b->hi.x;
    b->hi.y = p.y > b->hi.y ? p.y : b->hi.y;
    b->hi.z = p.z > b->hi.z ? p.z : b->hi.z;
}

static vv_bounds nothing(void)
{
    return (vv_bounds){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

static vv_status box_item(void *scratch, void *shared, size_t item)
{
    (void)scratch;
    const run *r = shared;
    vv_bounds b = nothing();
    const size_t end = (item + 1) * BLOCK < n_corners(r) ? (item + 1) * BLOCK : n_corners(r);
    double known = 0;
    for (size_t i = item * BLOCK; i < end; i++) {
        const size_t vertex = r->whole ? i : r->triangles[i];
        const float *at = r->mesh->positions + 3 * vertex;
        const vv_vec3 p = {(double)at[0], (double)at[1], (double)at[2]};
        known += (p.x + p.y + p.z) * 0;
        widen(&b, r->in_world ? vv_affine_point(r->map, p) : p);
    }
    if (known != 0) /* infinities and what is no number times 0 */
        return vv_fail(VV_E_ARGUMENT, "a vertex of the mesh is not finite; the mesh cannot be measured");
    r->boxes[item] = b;
    return VV_OK;
}

static vv_status find_box(vv_bounds *out, run *r, bool in_world, vv_job *job)
{
    const vvi_work work = {.item = box_item};
    const size_t n = blocks_of(n_corners(r));
    *out = nothing();
    r->in_world = in_world;
    const vv_status st = vvi_parallel_for(job, &work, r, n);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        widen(out, r->boxes[i].lo);
        widen(out, r->boxes[i].hi);
    }
    return st;
}

/* Sums --------------------------------------------------------------------------------------------------------------
 */

static vv_status sum_item(void *scratch, void *shared, size_t item)
{
    (void)scratch;
    const run *r = shared;
    vvi_mass_block b = r->block;
    b.triangles = r->triangles + 3 * BLOCK * item;
    b.n = r->n - BLOCK * item < BLOCK ? r->n - BLOCK * item : BLOCK;
    r->edges[item] = 0;
    r->kernels->sum(r->sums[item], &r->edges[item], &b);
    return VV_OK;
}

/* Neumaier 1974. */
static void add_compensated(double *sum, double *rest, double x)
{
    const double s = *sum + x;
    *rest += fabs(*sum) >= fabs(x) ? (*sum - s) + x : (x - s) + *sum;
    *sum = s;
}

static vv_status sum_all(double sums[VVI_MASS_SUMS], uint64_t *edges, run *r, vv_job *job)
{
    const vvi_work work = {.stage = "measure", .item = sum_item};
    const size_t n = blocks_of(r->n);
    const vv_status st = vvi_parallel_for(job, &work, r, n);
    *edges = 0;
    for (int s = 0; s < VVI_MASS_SUMS; s++) {
        double rest = 0;
        sums[s] = 0;
        for (size_t i = 0; i < n && st == VV_OK; i++)
            add_compensated(&sums[s], &rest, r->sums[i][s]);
        sums[s] += rest;
    }
    for (size_t i = 0; i < n && st == VV_OK; i++)
        *edges += r->edges[i];
    return st;
}

/* Normals of the mesh, or new ones in *made. */
static vv_status find_normals(float **made, run *r, vv_job *job)
{
    *made = NULL;
    if (!r->options->sampled || r->n == 0)
        return VV_OK;
    r->block.normals = r->mesh->normals;
    if (r->mesh->normals)
        return VV_OK;
    *made = vvi_alloc(job, 3 * r->mesh->n_vertices * sizeof **made, VVI_MEM_SCRATCH);
    if (!*made)
        return vv_fail_memory(3 * r->mesh->n_vertices * sizeof **made);
    r->block.normals = *made;
    return vvi_normals_of(*made, r->mesh->positions, r->mesh->n_vertices, r->triangles, r->n, job);
}

/* Results -----------------------------------------------------------------------------------------------------------
 */

static vv_figure figure(double value, double error, const char *unit, int power)
{
    vv_figure f = {.value = value, .error = error};
    if (power == 1 || !unit[0])
        snprintf(f.unit, sizeof f.unit, "%s", unit);
    else
        snprintf(f.unit, sizeof f.unit, "%s^%d", unit, power);
    return f;
}

/* Distances that go into the errors. */
typedef struct extent {
    double rounding; /* of a vertex */
    double radius;   /* of the box around all */
} extent;

static bool is_linear_identity(vv_affine a)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if ((&a.axis[i].x)[j] != (i == j))
                return false;
    return true;
}

static double largest_stretch(vv_affine a)
{
    if (is_linear_identity(a))
        return 1;
    double sum = 0; /* Frobenius norm: no less than the largest stretch */
    for (int i = 0; i < 3; i++)
        sum += a.axis[i].x * a.axis[i].x + a.axis[i].y * a.axis[i].y + a.axis[i].z * a.axis[i].z;
    return sqrt(sum);
}

static double length(vv_vec3 v)
{
    return sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

static extent find_reach(const run *r, vv_bounds positions, vv_bounds world)
{
    extent out;
    const vv_vec3 most = {fmax(fabs(positions.lo.x), fabs(positions.hi.x)),
                          fmax(fabs(positions.lo.y), fabs(positions.hi.y)),
                          fmax(fabs(positions.lo.z), fabs(positions.hi.z))};
    out.rounding = length(most) * (double)FLT_EPSILON / 2 * largest_stretch(r->map);
    out.radius = length((vv_vec3){world.hi.x - world.lo.x, world.hi.y - world.lo.y, world.hi.z - world.lo.z}) / 2;
    return out;
}

static void measure_area(vv_mesh_measures *out, const double *s, extent reach, const char *unit)
{
    const double area = s[VVI_MASS_AREA] / 2;
    const double error = s[VVI_MASS_CHORD_AREA] + s[VVI_MASS_OFFSET_AREA] + s[VVI_MASS_PERIMETER] / 2 * reach.rounding +
                         4 * DBL_EPSILON * area;
    out->area = figure(area, error, unit, 2);
}

/* Second moments about the center to the inertia about the centroid c, which is relative to the center. */
static void find_inertia(double out[6], const double *s, double volume, double sign, const double c[3])
{
    double m[6];
    static const int ij[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    for (int i = 0; i < 6; i++)
        m[i] = sign * s[VVI_MASS_SECOND + i] / 120 - volume * c[ij[i][0]] * c[ij[i][1]];
    out[0] = m[1] + m[2];
    out[1] = m[0] + m[2];
    out[2] = m[0] + m[1];
    for (int i = 3; i < 6; i++)
        out[i] = -m[i];
}

/* Places, and so volumes, may be off by the chords' height twice (middle and vertices) and by the rounding. */
static void measure_solid(vv_mesh_measures *out, const double *s, extent reach, const char *unit, const run *r)
{
    const bool mirrored = vv_affine_determinant(r->map) < 0;
    const double signed_volume = (mirrored ? -s[VVI_MASS_VOLUME] : s[VVI_MASS_VOLUME]) / 6;
    const double volume = fabs(signed_volume), sign = s[VVI_MASS_VOLUME] < 0 ? -1 : 1;
    const double shell = s[VVI_MASS_AREA] / 2 * reach.rounding;
    const double error = 2 * s[VVI_MASS_CHORD] + shell + 4 * DBL_EPSILON * s[VVI_MASS_AREA] * reach.radius;
    const double error_r = 2 * s[VVI_MASS_CHORD_R] + shell * reach.radius;
    const double error_rr = 2 * s[VVI_MASS_CHORD_RR] + shell * reach.radius * reach.radius;
    out->inside_out = signed_volume < 0;
    out->volume = figure(volume, error, unit, 3);
    const double *const k = r->block.center;
    const vv_vec3 center = vv_affine_point(r->map, (vv_vec3){k[0], k[1], k[2]});
    double c[3], inertia[6];
    for (int i = 0; i < 3; i++) {
        c[i] = volume > 0 ? sign * s[VVI_MASS_FIRST + i] / 24 / volume : NAN;
        const double at = (&center.x)[i] + c[i];
        out->centroid[i] = figure(
            at, volume > 0 ? (error_r + fabs(c[i]) * error) / volume + 4 * DBL_EPSILON * fabs(at) : INFINITY, unit, 1);
    }
    find_inertia(inertia, s, volume, sign, c);
    for (int i = 0; i < 6; i++)
        out->inertia[i] = figure(inertia[i], volume > 0 ? error_rr : INFINITY, unit, 5);
}

static void measure_no_solid(vv_mesh_measures *out, const char *unit)
{
    out->volume = figure(NAN, INFINITY, unit, 3);
    for (int i = 0; i < 3; i++)
        out->centroid[i] = figure(NAN, INFINITY, unit, 1);
    for (int i = 0; i < 6; i++)
        out->inertia[i] = figure(NAN, INFINITY, unit, 5);
}

/* Of vertices at the same place one stands for all. */
static vv_status count_edges(vvi_mesh_edges *out, const run *r, vv_job *job)
{
    vv_mesh_info part = *r->mesh;
    uint32_t *place;
    part.triangles = r->triangles;
    part.n_triangles = r->n;
    vv_status st = vvi_number_places(&place, part.positions, part.n_vertices, job);
    if (st == VV_OK)
        st = vvi_mesh_count_edges(out, &part, place, job);
    vvi_free(place);
    return st;
}

static vv_status find_openings(vv_mesh_measures *out, const run *r, const char *unit, vv_job *job)
{
    vvi_mesh_edges edges;
    const vv_status st = count_edges(&edges, r, job);
    if (st != VV_OK)
        return st;
    out->n_open_edges = edges.uneven;
    out->n_turned_edges = edges.turned;
    out->closed = edges.uneven == 0;
    if (out->closed)
        return VV_OK;
    const float *p = r->mesh->positions + 3 * (size_t)edges.first[0],
                *q = r->mesh->positions + 3 * (size_t)edges.first[1];
    const vv_vec3 middle = {((double)p[0] + (double)q[0]) / 2, ((double)p[1] + (double)q[1]) / 2,
                            ((double)p[2] + (double)q[2]) / 2};
    out->open_at = vv_affine_point(r->map, middle);
    if (r->options->open)
        return VV_OK;
    if (edges.turned == edges.uneven)
        return vv_fail(VV_E_ARGUMENT,
                       "the mesh has no holes, but some triangles are flipped, so it has no inside and no volume: at "
                       "%zu edges both triangles have the same direction, the first at (%.6g, %.6g, %.6g)%s%s; flip "
                       "them, or ask for its area only",
                       edges.turned, out->open_at.x, out->open_at.y, out->open_at.z, unit[0] ? " " : "", unit);
    return vv_fail(VV_E_ARGUMENT,
                   "the mesh is open, so it encloses no volume: %zu edges have a triangle on one side only, the first "
                   "at (%.6g, %.6g, %.6g)%s%s; close it there, or ask for its area only",
                   out->n_open_edges, out->open_at.x, out->open_at.y, out->open_at.z, unit[0] ? " " : "", unit);
}

/* The whole ---------------------------------------------------------------------------------------------------------
 */

static void set_block(run *r, vv_bounds box)
{
    vvi_mass_block *b = &r->block;
    b->positions = r->mesh->positions;
    for (int i = 0; i < 3; i++) {
        const double lo = (&box.lo.x)[i], hi = (&box.hi.x)[i];
        b->center[i] = lo <= hi ? lo + (hi - lo) / 2 : 0;
        for (int j = 0; j < 3; j++)
            b->matrix[i][j] = (&r->map.axis[j].x)[i];
    }
    b->determinant = fabs(vv_affine_determinant(r->map));
}

static vv_status choose_run(run *r, const vv_mesh_info *mesh, const vv_mesh_measure_options *o)
{
    *r = (run){.mesh = mesh, .options = o, .triangles = mesh->triangles, .n = mesh->n_triangles, .whole = true};
    const vv_affine placed = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .origin = mesh->origin};
    r->map = vv_affine_compose(o->to_world, placed);
    if (o->part == SIZE_MAX)
        return VV_OK;
    const size_t n_parts = mesh->parts ? mesh->n_parts : 1;
    if (o->part >= n_parts)
        return vv_fail(VV_E_ARGUMENT, "part %zu does not exist; the mesh has %zu, counted from 0", o->part, n_parts);
    if (!mesh->parts)
        return VV_OK;
    r->whole = false;
    r->triangles += 3 * mesh->parts[o->part].first_triangle;
    r->n = mesh->parts[o->part].n_triangles;
    return VV_OK;
}

static vv_status take_rows(run *r, vv_job *job)
{
    const size_t n = blocks_of(r->n) + 1, n_boxes = blocks_of(n_corners(r)) + 1;
    r->boxes = vvi_alloc(job, n_boxes * sizeof *r->boxes, VVI_MEM_SCRATCH);
    r->sums = vvi_alloc(job, n * sizeof *r->sums, VVI_MEM_SCRATCH);
    r->edges = vvi_alloc(job, n * sizeof *r->edges, VVI_MEM_SCRATCH);
    return r->boxes && r->sums && r->edges ? VV_OK : vv_fail_memory(n * sizeof *r->sums);
}

static vv_status measure(vv_mesh_measures *out, run *r, vv_job *job)
{
    const char *unit = r->options->unit[0] ? r->options->unit : r->mesh->unit;
    double sums[VVI_MASS_SUMS];
    uint64_t edges;
    vv_bounds box;
    float *normals = NULL;
    vv_status st;
    if ((st = find_box(&box, r, false, job)) != VV_OK)
        return st;
    out->n_triangles = r->n;
    out->bounds = box;
    if (is_linear_identity(r->map)) {
        for (int i = 0; i < 3; i++) {
            (&out->bounds.lo.x)[i] += (&r->map.origin.x)[i];
            (&out->bounds.hi.x)[i] += (&r->map.origin.x)[i];
        }
    } else if ((st = find_box(&out->bounds, r, true, job)) != VV_OK) {
        return st;
    }
    set_block(r, box);
    if ((st = find_normals(&normals, r, job)) == VV_OK)
        st = sum_all(sums, &edges, r, job);
    vvi_free(normals);
    if (st != VV_OK)
        return st;
    out->closed = edges == 0;
    if (!out->closed && (st = find_openings(out, r, unit, job)) != VV_OK)
        return st;
    const extent reach = find_reach(r, box, out->bounds);
    measure_area(out, sums, reach, unit);
    if (out->closed)
        measure_solid(out, sums, reach, unit, r);
    else
        measure_no_solid(out, unit);
    return VV_OK;
}

void vv_mesh_measure_options_init(vv_mesh_measure_options *options, size_t size)
{
    const vv_mesh_measure_options all = {.size = size, .to_world = vv_affine_identity(), .part = SIZE_MAX};
    memcpy(options, &all, size < sizeof all ? size : sizeof all);
}

vv_status vv_mesh_measure(vv_mesh_measures *out, const vv_mesh *mesh, const vv_mesh_measure_options *options,
                          vv_job *job)
{
    vv_mesh_measure_options o;
    run r;
    vv_status st;
    vv_mesh_measure_options_init(&o, sizeof o);
    if (options)
        memcpy(&o, options, options->size < sizeof o ? options->size : sizeof o);
    *out = (vv_mesh_measures){.bounds = nothing()};
    if ((st = choose_run(&r, vv_mesh_get_info(mesh), &o)) != VV_OK)
        return st;
    r.kernels = vvi_mass_kernels_for(vvi_job_cpu(job));
    if ((st = take_rows(&r, job)) == VV_OK)
        st = measure(out, &r, job);
    vvi_free(r.boxes);
    vvi_free(r.sums);
    vvi_free(r.edges);
    return st;
}
