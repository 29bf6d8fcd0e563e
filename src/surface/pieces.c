#include "surface/pieces.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { POLL = 1 << 16 };
#define NO_PIECE UINT32_MAX

/* Sizes ----------------------------------------------------------------------------------------------------------- */

typedef struct measuring {
    const vv_mesh_info *mesh;
    uint32_t *first; /* by vertex: the first of its piece */
    uint32_t *of;    /* by first vertex: number of the piece, in the order of these */
    vvi_piece *pieces;
    size_t n;
} measuring;

/* A vertex from another one: places far from zero lose nothing. */
static void from(double out[3], const vv_mesh_info *m, uint32_t vertex, uint32_t base)
{
    for (size_t a = 0; a < 3; a++)
        out[a] = (double)m->positions[3 * (size_t)vertex + a] - (double)m->positions[3 * (size_t)base + a];
}

static void add_triangle(vvi_piece *p, const vv_mesh_info *m, const uint32_t v[3])
{
    double a[3], b[3], c[3], n[3];
    from(a, m, v[0], p->first_vertex);
    from(b, m, v[1], v[0]);
    from(c, m, v[2], v[0]);
    for (int i = 0; i < 3; i++)
        n[i] = b[(i + 1) % 3] * c[(i + 2) % 3] - b[(i + 2) % 3] * c[(i + 1) % 3];
    p->area += 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    p->volume += (a[0] * n[0] + a[1] * n[1] + a[2] * n[2]) / 6;
    p->n_triangles++;
}

/* Numbers the pieces that have triangles. */
static vv_status number(measuring *s, vv_job *job)
{
    const vv_mesh_info *m = s->mesh;
    const size_t bytes = (m->n_vertices + 1) * sizeof *s->of;
    s->of = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!s->of)
        return vv_fail_memory(bytes);
    memset(s->of, 0xff, bytes);
    for (size_t t = 0; t < m->n_triangles; t++)
        s->of[s->first[m->triangles[3 * t]]] = 0;
    for (size_t v = 0; v < m->n_vertices; v++)
        if (s->of[v] != NO_PIECE)
            s->of[v] = (uint32_t)s->n++;
    s->pieces = vvi_alloc_zeroed(job, s->n * sizeof *s->pieces + 1, VVI_MEM_SCRATCH);
    return s->pieces ? VV_OK : vv_fail_memory(s->n * sizeof *s->pieces);
}

static vv_status measure(measuring *s, vv_job *job)
{
    const vv_mesh_info *m = s->mesh;
    vv_status st = number(s, job);
    if (st != VV_OK)
        return st;
    for (size_t v = 0; v < m->n_vertices; v++) {
        const uint32_t piece = s->of[s->first[v]];
        if (piece == NO_PIECE)
            continue;
        if (s->first[v] == v)
            s->pieces[piece].first_vertex = (uint32_t)v;
        s->pieces[piece].n_vertices++;
    }
    for (size_t t = 0; t < m->n_triangles && st == VV_OK; t++) {
        add_triangle(&s->pieces[s->of[s->first[m->triangles[3 * t]]]], m, m->triangles + 3 * t);
        if (t % POLL == 0)
            st = vvi_job_poll(job);
    }
    return st;
}

static double size_of(const vvi_piece *p, vvi_piece_size by)
{
    return by == VVI_PIECE_VOLUME ? fabs(p->volume) : p->area;
}

/* The largest first; of equals that with the first vertex. */
static int compare(double a, double b, const vvi_piece *p, const vvi_piece *q)
{
    if (a != b)
        return a > b ? -1 : 1;
    return p->first_vertex < q->first_vertex ? -1 : p->first_vertex > q->first_vertex;
}

static int by_area(const void *a, const void *b)
{
    return compare(size_of(a, VVI_PIECE_AREA), size_of(b, VVI_PIECE_AREA), a, b);
}

static int by_volume(const void *a, const void *b)
{
    return compare(size_of(a, VVI_PIECE_VOLUME), size_of(b, VVI_PIECE_VOLUME), a, b);
}

static void choose(measuring *s, const vvi_pieces_options *o)
{
    size_t n = 0;
    for (size_t i = 0; i < s->n; i++)
        if (!(size_of(&s->pieces[i], o->size) < o->least))
            s->pieces[n++] = s->pieces[i];
    qsort(s->pieces, n, sizeof *s->pieces, o->size == VVI_PIECE_VOLUME ? by_volume : by_area);
    s->n = o->most && o->most < n ? o->most : n;
}

static vv_status find(measuring *s, const vv_mesh *mesh, const vvi_pieces_options *o, vv_job *job)
{
    *s = (measuring){.mesh = vv_mesh_get_info(mesh)};
    if (isnan(o->least))
        return vv_fail(VV_E_ARGUMENT, "the smallest size of a piece is not a number");
    vv_status st = vvi_mesh_number_pieces(&s->first, mesh, job);
    if (st == VV_OK)
        st = measure(s, job);
    if (st == VV_OK)
        choose(s, o);
    return st;
}

static void finish(measuring *s)
{
    vvi_free(s->first);
    vvi_free(s->of);
    vvi_free(s->pieces);
}

vv_status vvi_find_pieces(vvi_piece **out, size_t *n_out, const vv_mesh *mesh, const vvi_pieces_options *o, vv_job *job)
{
    measuring s;
    const vv_status st = find(&s, mesh, o, job);
    *out = NULL;
    *n_out = 0;
    if (st == VV_OK) {
        *out = s.pieces;
        *n_out = s.n;
        s.pieces = NULL;
    }
    finish(&s);
    return st;
}

/* Mesh ------------------------------------------------------------------------------------------------------------ */

static void copy_vertex(const vvi_mesh_arrays *to, size_t at, const vv_mesh_info *m, size_t v)
{
    memcpy(to->positions + 3 * at, m->positions + 3 * v, 3 * sizeof(float));
    if (m->normals)
        memcpy(to->normals + 3 * at, m->normals + 3 * v, 3 * sizeof(float));
    if (m->values)
        to->values[at] = m->values[v];
    if (m->colors)
        memcpy(to->colors + 4 * at, m->colors + 4 * v, 4);
}

/* The part that a triangle belongs to; NULL: none. */
static const vv_mesh_part *part_of(const vv_mesh_info *m, size_t triangle)
{
    size_t lo = 0, hi = m->parts ? m->n_parts : 0;
    while (lo + 1 < hi) {
        const size_t mid = lo + (hi - lo) / 2;
        if (m->parts[mid].first_triangle <= triangle)
            lo = mid;
        else
            hi = mid;
    }
    return lo < hi ? &m->parts[lo] : NULL;
}

static void name_part(vv_mesh_part *part, size_t number_of_it, const vv_mesh_part *was)
{
    const char *name = was ? was->name : "";
    if (was)
        part->color = was->color;
    snprintf(part->name, sizeof part->name, "%.40s%spiece %zu", name, *name ? ", " : "", number_of_it);
}

/* Where each piece's vertices and triangles go on. of[first vertex]: which of the pieces that are kept. */
typedef struct place {
    size_t vertex, triangle;
} place;

static void fill(const vvi_mesh_arrays *to, const measuring *s, place *next, uint32_t *vertex)
{
    const vv_mesh_info *m = s->mesh;
    for (size_t v = 0; v < m->n_vertices; v++) {
        const uint32_t piece = s->of[s->first[v]];
        if (piece == NO_PIECE)
            continue;
        vertex[v] = (uint32_t)next[piece].vertex;
        copy_vertex(to, next[piece].vertex++, m, v);
    }
    for (size_t t = 0; t < m->n_triangles; t++) {
        const uint32_t piece = s->of[s->first[m->triangles[3 * t]]];
        if (piece == NO_PIECE)
            continue;
        if (next[piece].triangle == to->parts[piece].first_triangle)
            name_part(&to->parts[piece], (size_t)piece + 1, part_of(m, t));
        uint32_t *out = to->triangles + 3 * next[piece].triangle++;
        for (size_t i = 0; i < 3; i++)
            out[i] = vertex[m->triangles[3 * t + i]];
    }
}

static vv_status make_mesh(vv_mesh **out, measuring *s, vv_job *job)
{
    const vv_mesh_info *m = s->mesh;
    const unsigned with =
        (m->normals ? VVI_MESH_NORMALS : 0) | (m->values ? VVI_MESH_VALUES : 0) | (m->colors ? VVI_MESH_COLORS : 0);
    vv_mesh_info info = *m;
    vvi_mesh_arrays to;
    info.n_vertices = info.n_triangles = 0;
    info.n_parts = s->n;
    place *next = vvi_alloc(job, (s->n + 1) * sizeof *next, VVI_MEM_SCRATCH);
    uint32_t *vertex = vvi_alloc(job, (m->n_vertices + 1) * sizeof *vertex, VVI_MEM_SCRATCH);
    vv_status st = next && vertex ? VV_OK : vv_fail_memory((m->n_vertices + 1) * sizeof *vertex);
    memset(s->of, 0xff, m->n_vertices * sizeof *s->of);
    for (size_t i = 0; i < s->n && st == VV_OK; i++) {
        next[i] = (place){info.n_vertices, info.n_triangles};
        s->of[s->pieces[i].first_vertex] = (uint32_t)i;
        info.n_vertices += s->pieces[i].n_vertices;
        info.n_triangles += s->pieces[i].n_triangles;
    }
    if (st == VV_OK && (st = vvi_mesh_new(out, &to, &info, with, job)) == VV_OK) {
        for (size_t i = 0; i < s->n; i++) {
            to.parts[i].first_triangle = next[i].triangle;
            to.parts[i].n_triangles = s->pieces[i].n_triangles;
        }
        fill(&to, s, next, vertex);
    }
    vvi_free(next);
    vvi_free(vertex);
    return st;
}

vv_status vvi_mesh_pieces(vv_mesh **out, const vv_mesh *mesh, const vvi_pieces_options *o, vv_job *job)
{
    measuring s;
    *out = NULL;
    vv_status st = find(&s, mesh, o, job);
    if (st == VV_OK)
        st = make_mesh(out, &s, job);
    finish(&s);
    return st;
}
