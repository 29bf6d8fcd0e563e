#include "grid/mesh_normals.h"
#include "core/job.h"
#include "core/memory.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

typedef struct side {
    double x, y, z, square;
} side;

static side from_to(const float *p, const float *q)
{
    side s = {(double)q[0] - (double)p[0], (double)q[1] - (double)p[1], (double)q[2] - (double)p[2], 0};
    s.square = s.x * s.x + s.y * s.y + s.z * s.z;
    return s;
}

/* Sides a and b leave the corner. */
static void add(float *normal, const double cut[3], const side *a, const side *b)
{
    const double weights = a->square * b->square;
    const double w = weights > 0 ? 1 / weights : 0;
    for (int i = 0; i < 3; i++)
        normal[i] += (float)(cut[i] * w);
}

static void add_triangle(float *out, const float *positions, const uint32_t *t)
{
    const float *p[3] = {positions + 3 * (size_t)t[0], positions + 3 * (size_t)t[1], positions + 3 * (size_t)t[2]};
    const side a = from_to(p[0], p[1]), b = from_to(p[1], p[2]), c = from_to(p[2], p[0]);
    const double cut[3] = {a.z * c.y - a.y * c.z, a.x * c.z - a.z * c.x, a.y * c.x - a.x * c.y};
    add(out + 3 * (size_t)t[0], cut, &a, &c);
    add(out + 3 * (size_t)t[1], cut, &b, &a);
    add(out + 3 * (size_t)t[2], cut, &c, &b);
}

static void make_unit(float *n)
{
    const double x = (double)n[0], y = (double)n[1], z = (double)n[2], length = sqrt(x * x + y * y + z * z);
    const double scale = length > 0 && isfinite(length) ? 1 / length : 0;
    for (int i = 0; i < 3; i++)
        n[i] = scale > 0 ? (float)((double)n[i] * scale) : 0;
}

vv_status vvi_normals_of(float *out, const float *positions, size_t n_vertices, const uint32_t *triangles,
                         size_t n_triangles, vv_job *job)
{
    enum { OFTEN = 1 << 16 };
    vv_status st = VV_OK;
    memset(out, 0, 3 * n_vertices * sizeof *out);
    for (size_t t = 0; t < n_triangles && st == VV_OK; t++) {
        add_triangle(out, positions, triangles + 3 * t);
        if (t % OFTEN == 0)
            st = vvi_job_poll(job);
    }
    for (size_t i = 0; i < n_vertices && st == VV_OK; i++)
        make_unit(out + 3 * i);
    return st;
}

/* Normals that are missing ---------------------------------------------------------------------------------------- */

typedef struct filling {
    float *normals;
    const float *positions;
    size_t n_vertices;
    const uint32_t *triangles;
    size_t n_triangles;
    atomic_bool some; /* a normal is missing */
    uint32_t *vertex; /* those without, in order */
    double *sum;      /* three for each of them */
    size_t n;
} filling;

enum { CHUNK = 1 << 16 };

static bool is_missing(const float *n)
{
    return n[0] == 0 && n[1] == 0 && n[2] == 0;
}

static vv_status look(void *scratch, void *user, size_t item)
{
    (void)scratch;
    filling *f = user;
    const size_t begin = item * CHUNK, end = begin + CHUNK < f->n_vertices ? begin + CHUNK : f->n_vertices;
    bool some = false;
    for (size_t v = begin; v < end; v++)
        some |= is_missing(f->normals + 3 * v);
    if (some)
        atomic_store_explicit(&f->some, true, memory_order_relaxed);
    return VV_OK;
}

static vv_status list_missing(filling *f, vv_job *job)
{
    f->n = 0;
    for (size_t v = 0; v < f->n_vertices; v++)
        f->n += is_missing(f->normals + 3 * v);
    f->vertex = vvi_alloc(job, f->n * sizeof *f->vertex, VVI_MEM_SCRATCH);
    f->sum = vvi_alloc_zeroed(job, 3 * f->n * sizeof *f->sum, VVI_MEM_SCRATCH);
    if (!f->vertex || !f->sum)
        return vv_fail_memory(3 * f->n * sizeof *f->sum);
    f->n = 0;
    for (size_t v = 0; v < f->n_vertices; v++)
        if (is_missing(f->normals + 3 * v))
            f->vertex[f->n++] = (uint32_t)v;
    return VV_OK;
}

static double *sum_of(const filling *f, uint32_t vertex)
{
    size_t low = 0, high = f->n;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        *(f->vertex[middle] <= vertex ? &low : &high) = middle;
    }
    return f->sum + 3 * low;
}

/* Twice the area along the normal; or, where triangles have no area, the normals at their corners. */
static void add_to_missing(const filling *f, const uint32_t *t, bool of_neighbours)
{
    const float *p[3] = {f->positions + 3 * (size_t)t[0], f->positions + 3 * (size_t)t[1],
                         f->positions + 3 * (size_t)t[2]};
    const side a = from_to(p[0], p[1]), c = from_to(p[2], p[0]);
    double add[3] = {a.z * c.y - a.y * c.z, a.x * c.z - a.z * c.x, a.y * c.x - a.x * c.y};
    for (int i = 0; i < 3 && of_neighbours; i++)
        add[i] = (double)f->normals[3 * (size_t)t[0] + (size_t)i] + (double)f->normals[3 * (size_t)t[1] + (size_t)i] +
                 (double)f->normals[3 * (size_t)t[2] + (size_t)i];
    for (size_t k = 0; k < 3; k++) {
        if (!is_missing(f->normals + 3 * (size_t)t[k]))
            continue;
        double *sum = sum_of(f, t[k]);
        for (int i = 0; i < 3; i++)
            sum[i] += add[i];
    }
}

static bool has_missing(const filling *f)
{
    for (size_t k = 0; k < f->n; k++)
        if (is_missing(f->normals + 3 * (size_t)f->vertex[k]))
            return true;
    return false;
}

static vv_status fill_from(filling *f, bool of_neighbours, vv_job *job)
{
    for (size_t t = 0; t < f->n_triangles; t++) {
        const uint32_t *v = f->triangles + 3 * t;
        if (t % CHUNK == 0 && vvi_job_poll(job) != VV_OK)
            return VV_E_CANCELLED;
        if (is_missing(f->normals + 3 * (size_t)v[0]) || is_missing(f->normals + 3 * (size_t)v[1]) ||
            is_missing(f->normals + 3 * (size_t)v[2]))
            add_to_missing(f, v, of_neighbours);
    }
    for (size_t k = 0; k < f->n; k++) {
        const double *s = f->sum + 3 * k, length = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
        for (size_t i = 0; i < 3 && length > 0 && isfinite(length); i++)
            f->normals[3 * (size_t)f->vertex[k] + i] = (float)(s[i] / length);
    }
    return VV_OK;
}

vv_status vvi_normals_fill(float *normals, const vv_mesh *mesh, vv_job *job)
{
    static const vvi_work work = {.item = look};
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    filling f = {normals, m->positions, m->n_vertices, m->triangles, m->n_triangles, .n = 0};
    if (!normals)
        return VV_OK;
    atomic_init(&f.some, false);
    vv_status st = vvi_parallel_for(job, &work, &f, (m->n_vertices + CHUNK - 1) / CHUNK);
    if (st != VV_OK || !atomic_load_explicit(&f.some, memory_order_relaxed))
        return st;
    if ((st = list_missing(&f, job)) == VV_OK && (st = fill_from(&f, false, job)) == VV_OK && has_missing(&f))
        st = fill_from(&f, true, job);
    for (size_t k = 0; k < f.n && st == VV_OK; k++) /* nothing says where to: any direction is as right */
        if (is_missing(normals + 3 * (size_t)f.vertex[k]))
            normals[3 * (size_t)f.vertex[k] + 2] = 1;
    vvi_free(f.vertex);
    vvi_free(f.sum);
    return st;
}
