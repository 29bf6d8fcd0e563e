#include "surface/normals.h"
#include "core/job.h"

#include <math.h>
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
