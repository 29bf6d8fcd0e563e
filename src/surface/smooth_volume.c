#include "surface/smooth_volume.h"
#include "core/memory.h"
#include "grid/mesh.h"

#include <math.h>
#include <string.h>

/* Of the volume: a piece that the filter alone changes by more is filtered less. And how exactly it is kept. */
static const double MOST = .05, EXACT = 1e-5;

static double det(const double a[3], const double b[3], const double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* Twice the area, along the normal. */
static void cross_of(double out[3], double p[3][3])
{
    double u[3], v[3];
    for (int c = 0; c < 3; c++)
        u[c] = p[1][c] - p[0][c], v[c] = p[2][c] - p[0][c];
    out[0] = u[1] * v[2] - u[2] * v[1];
    out[1] = u[2] * v[0] - u[0] * v[2];
    out[2] = u[0] * v[1] - u[1] * v[0];
}

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Finding them ------------------------------------------------------------------------------------------------------
 */

/* Pieces by the order of their first vertices. */
static size_t number(uint32_t *of, size_t n_vertices)
{
    size_t n = 0;
    for (size_t v = 0; v < n_vertices; v++)
        of[v] = of[v] == v ? (uint32_t)n++ : of[of[v]];
    return n;
}

static void add_up(vvi_smooth_pieces *p, const vv_mesh_info *m)
{
    for (size_t t = 0; t < m->n_triangles; t++) {
        const uint32_t *corner = m->triangles + 3 * t;
        vvi_smooth_piece *piece = &p->all[p->of[corner[0]]];
        double q[3][3], n[3];
        for (size_t k = 0; k < 3; k++)
            for (size_t c = 0; c < 3; c++)
                q[k][c] = (double)m->positions[3 * (size_t)corner[k] + c] - piece->origin[c];
        cross_of(n, q);
        piece->volume += det(q[0], q[1], q[2]) / 6;
        piece->area += length(n) / 2;
    }
    for (size_t i = 0; i < p->n; i++) /* of a ball it is 0.094 */
        p->all[i].open = !(fabs(p->all[i].volume) > 1e-5 * pow(p->all[i].area, 1.5));
}

vv_status vvi_smooth_pieces_find(vvi_smooth_pieces *p, const vv_mesh_info *m, const uint32_t *place, vv_job *job)
{
    vv_status st = vvi_mesh_number_placed_pieces(&p->of, m, place, job);
    if (st != VV_OK)
        return st;
    p->n = number(p->of, m->n_vertices);
    p->all = vvi_alloc_zeroed(job, (p->n + 1) * sizeof *p->all, VVI_MEM_SCRATCH);
    if (!p->all)
        return vv_fail_memory((p->n + 1) * sizeof *p->all);
    for (size_t v = 0; v < m->n_vertices; v++)
        for (size_t c = 0; c < 3; c++)
            p->all[p->of[v]].origin[c] = (double)m->positions[3 * v + c];
    add_up(p, m);
    return VV_OK;
}

void vvi_smooth_pieces_finish(vvi_smooth_pieces *p)
{
    vvi_free(p->all);
    vvi_free(p->of);
    *p = (vvi_smooth_pieces){0};
}

/* Mending ---------------------------------------------------------------------------------------------------------- */

static bool is_looked_at(const vvi_smooth_piece *p)
{
    return !p->open && !p->done;
}

static void take_corners(double out[3][3], const double *from, const uint32_t *corner, const uint32_t *place)
{
    for (size_t k = 0; k < 3; k++)
        memcpy(out[k], from + 3 * (size_t)place[corner[k]], sizeof out[k]);
}

static void make_normals(const vvi_smooth_pieces *p, double *normals, const double *positions, const vv_mesh_info *m,
                         const uint32_t *place)
{
    memset(normals, 0, 3 * m->n_vertices * sizeof *normals);
    for (size_t t = 0; t < m->n_triangles; t++) {
        const uint32_t *corner = m->triangles + 3 * t;
        double q[3][3], n[3];
        if (!is_looked_at(&p->all[p->of[corner[0]]]))
            continue;
        take_corners(q, positions, corner, place);
        cross_of(n, q);
        for (size_t i = 0; i < 9; i++)
            normals[3 * (size_t)place[corner[i / 3]] + i % 3] += n[i % 3];
    }
    for (size_t v = 0; v < m->n_vertices; v++) {
        const double l = length(normals + 3 * v);
        for (size_t c = 0; c < 3 && l > 0; c++)
            normals[3 * v + c] /= l;
    }
}

/* The volume over a triangle as its corners move. q: corners from a place near the piece. */
static void add_polynomial(double a[4], double q[3][3], double n[3][3])
{
    a[0] += det(q[0], q[1], q[2]) / 6;
    a[1] += (det(n[0], q[1], q[2]) + det(q[0], n[1], q[2]) + det(q[0], q[1], n[2])) / 6;
    a[2] += (det(q[0], n[1], n[2]) + det(n[0], q[1], n[2]) + det(n[0], n[1], q[2])) / 6;
    a[3] += det(n[0], n[1], n[2]) / 6;
}

static void make_polynomials(vvi_smooth_pieces *p, const double *positions, const double *normals,
                             const vv_mesh_info *m, const uint32_t *place)
{
    for (size_t i = 0; i < p->n; i++)
        memset(p->all[i].a, 0, sizeof p->all[i].a);
    for (size_t t = 0; t < m->n_triangles; t++) {
        const uint32_t *corner = m->triangles + 3 * t;
        vvi_smooth_piece *piece = &p->all[p->of[corner[0]]];
        double q[3][3], n[3][3];
        if (!is_looked_at(piece))
            continue;
        take_corners(q, positions, corner, place);
        take_corners(n, normals, corner, place);
        add_polynomial(piece->a, q, n);
    }
}

static double at(const double a[4], double d)
{
    return a[0] + d * (a[1] + d * (a[2] + d * a[3]));
}

/* Newton's method from 0, where a piece is nearly what it was. */
static bool solve(vvi_smooth_piece *p)
{
    if (!(fabs(p->a[0] - p->volume) <= MOST * fabs(p->volume)))
        return false;
    p->shift = 0;
    for (int i = 0; i < 20; i++)
        p->shift -= (at(p->a, p->shift) - p->volume) / (p->a[1] + p->shift * (2 * p->a[2] + p->shift * 3 * p->a[3]));
    /* no farther than as a layer all over the piece would be thick */
    return fabs(at(p->a, p->shift) - p->volume) <= EXACT * fabs(p->volume) &&
           fabs(p->shift) * p->area <= 2 * MOST * fabs(p->volume);
}

void vvi_smooth_pieces_mend(vvi_smooth_pieces *p, double *positions, double *normals, const vv_mesh_info *m,
                            const uint32_t *place)
{
    make_normals(p, normals, positions, m, place);
    make_polynomials(p, positions, normals, m, place);
    for (size_t i = 0; i < p->n; i++)
        p->all[i].mended = is_looked_at(&p->all[i]) && solve(&p->all[i]);
    for (size_t v = 0; v < m->n_vertices; v++)
        for (size_t c = 0; c < 3 && p->all[p->of[v]].mended; c++)
            positions[3 * v + c] += p->all[p->of[v]].shift * normals[3 * v + c];
    for (size_t i = 0; i < p->n; i++)
        p->all[i].done |= p->all[i].mended || p->all[i].open;
}
