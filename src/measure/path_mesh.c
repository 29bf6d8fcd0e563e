#include "measure/path_mesh.h"
#include "core/job.h"
#include "core/memory.h"
#include "measure/triangle.h"
#include "surface/vertex_places.h"

#include <math.h>
#include <string.h>

enum { MORE = 16 }; /* room for the triangles and vertices that two more places make */

static vv_status take(void *out, size_t n, size_t each, vv_job *job)
{
    size_t bytes;
    const vv_status st = vvi_mul_size(&bytes, n + MORE, each);
    if (st != VV_OK)
        return st;
    void *memory = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    *(void **)out = memory;
    return memory ? VV_OK : vv_fail_memory(bytes);
}

/* Triangles of which two corners are at the same place are left out: nobody sees them. */
static vv_status copy(vvi_path_mesh *m, const vv_mesh_info *mesh, const vv_affine *map, vv_job *job)
{
    uint32_t *number;
    vv_status st = vvi_number_places(&number, mesh->positions, mesh->n_vertices, job);
    if (st != VV_OK)
        return st;
    m->origin = vv_affine_point(*map, mesh->origin);
    m->n_vertices = mesh->n_vertices;
    for (size_t v = 0; v < mesh->n_vertices; v++) {
        const float *p = mesh->positions + 3 * v;
        m->place[v] = vv_affine_vector(*map, vvi_vec((double)p[0], (double)p[1], (double)p[2]));
        if (!vvi_finite(m->place[v]))
            st = vv_fail(VV_E_ARGUMENT, "a vertex of the mesh is not finite; there are no paths along it");
    }
    for (size_t t = 0; t < mesh->n_triangles && st == VV_OK; t++) {
        uint32_t *to = m->triangle + 3 * m->n_triangles;
        for (size_t k = 0; k < 3; k++)
            to[k] = number[mesh->triangles[3 * t + k]];
        m->n_triangles += to[0] != to[1] && to[1] != to[2] && to[2] != to[0];
    }
    vvi_free(number);
    if (st == VV_OK && m->n_triangles == 0)
        st = vv_fail(VV_E_ARGUMENT, "the mesh has no triangles; there are no paths along it");
    return st;
}

/* The ends of the path ----------------------------------------------------------------------------------------------
 */

static void add_triangle(vvi_path_mesh *m, uint32_t a, uint32_t b, uint32_t c)
{
    memcpy(m->triangle + 3 * m->n_triangles++, (const uint32_t[3]){a, b, c}, 3 * sizeof *m->triangle);
}

/* Every triangle with the edge becomes two; v lies on the edge. */
static void split_edge(vvi_path_mesh *m, uint32_t a, uint32_t b, uint32_t v)
{
    const size_t n = m->n_triangles;
    int room = MORE / 4; /* more triangles at an edge cannot be crossed anyway */
    for (size_t e = 0; e < 3 * n && room > 0; e++) {
        const uint32_t edge = (uint32_t)e, p = vvi_edge_start(m, edge), q = vvi_edge_end(m, edge);
        if (!((p == a && q == b) || (p == b && q == a)))
            continue;
        add_triangle(m, v, q, vvi_edge_apex(m, edge));
        m->triangle[vvi_edge_next(edge)] = v;
        room--;
    }
}

static void split_triangle(vvi_path_mesh *m, size_t triangle, uint32_t v)
{
    uint32_t *t = m->triangle + 3 * triangle;
    add_triangle(m, t[1], t[2], v);
    add_triangle(m, t[2], t[0], v);
    t[2] = v;
}

/* The vertex of the nearest place to p, made when there is none. */
static uint32_t add_place(vvi_path_mesh *m, vv_vec3 p)
{
    const double close = 1e-9; /* part of a triangle within which a place is on its side or corner */
    double least = INFINITY;
    size_t best = 0;
    vvi_triangle corners = {{0}};
    for (size_t t = 0; t < m->n_triangles; t++) {
        const uint32_t *k = m->triangle + 3 * t;
        const vvi_triangle c = {m->place[k[0]], m->place[k[1]], m->place[k[2]]};
        const double square = vvi_triangle_square(p, &c);
        if (square < least) {
            least = square;
            best = t;
            corners = c;
        }
    }
    const vv_vec3 w = vvi_nearest_weights(p, &corners);
    const uint32_t *k = m->triangle + 3 * best, v = (uint32_t)m->n_vertices;
    const bool zero[3] = {w.x < close, w.y < close, w.z < close};
    for (int i = 0; i < 3; i++)
        if (zero[(i + 1) % 3] && zero[(i + 2) % 3])
            return k[i];
    m->place[m->n_vertices++] = vvi_triangle_at(&corners, w);
    for (int i = 0; i < 3; i++)
        if (zero[i]) {
            split_edge(m, k[(i + 1) % 3], k[(i + 2) % 3], v);
            return v;
        }
    split_triangle(m, best, v);
    return v;
}

/* Neighbours --------------------------------------------------------------------------------------------------------
 */

static void list_corners(vvi_path_mesh *m)
{
    size_t *next = m->first + 1;
    for (size_t e = 0; e < 3 * m->n_triangles; e++)
        next[m->triangle[e] + 1]++;
    for (size_t v = 1; v <= m->n_vertices; v++)
        next[v] += next[v - 1];
    for (size_t e = 0; e < 3 * m->n_triangles; e++)
        m->corner[next[m->triangle[e]]++] = (uint32_t)e;
}

/* The only other edge between two vertices. */
static uint32_t find_twin(const vvi_path_mesh *m, uint32_t edge)
{
    const uint32_t a = vvi_edge_start(m, edge), b = vvi_edge_end(m, edge);
    const uint32_t v = m->first[a + 1] - m->first[a] <= m->first[b + 1] - m->first[b] ? a : b;
    uint32_t found = VVI_NONE;
    int n = 0;
    for (size_t i = m->first[v]; i < m->first[v + 1]; i++) {
        const uint32_t out = m->corner[i], in = vvi_edge_next(vvi_edge_next(out));
        const uint32_t around[2] = {out, in};
        for (int k = 0; k < 2; k++) {
            const uint32_t e = around[k], p = vvi_edge_start(m, e), q = vvi_edge_end(m, e);
            if (e != edge && ((p == a && q == b) || (p == b && q == a))) {
                found = e;
                n++;
            }
        }
    }
    return n == 1 ? found : VVI_NONE;
}

static bool may_turn_at(const vvi_path_mesh *m, size_t v)
{
    double angles = 0;
    for (size_t i = m->first[v]; i < m->first[v + 1]; i++) {
        const uint32_t out = m->corner[i], far = vvi_edge_next(out), in = vvi_edge_next(far);
        const double a = m->length[out], b = m->length[in], c = m->length[far];
        if (m->twin[out] == VVI_NONE || m->twin[in] == VVI_NONE)
            return true;
        angles += acos(fmax(-1, fmin(1, (a * a + b * b - c * c) / (2 * a * b))));
    }
    return angles > 2 * M_PI * (1 + 1e-12);
}

static void find_neighbours(vvi_path_mesh *m)
{
    list_corners(m);
    for (size_t e = 0; e < 3 * m->n_triangles; e++) {
        const uint32_t edge = (uint32_t)e;
        m->length[e] = vvi_length(vvi_sub(m->place[vvi_edge_end(m, edge)], m->place[vvi_edge_start(m, edge)]));
        m->twin[e] = find_twin(m, edge);
    }
    for (size_t v = 0; v < m->n_vertices; v++)
        m->turning[v] = may_turn_at(m, v);
}

vv_status vvi_path_mesh_init(vvi_path_mesh *out, const vv_mesh_info *mesh, const vv_affine *to_world, vv_vec3 from,
                             vv_vec3 to, vv_job *job)
{
    const size_t v = mesh->n_vertices, e = 3 * mesh->n_triangles;
    vv_status st;
    *out = (vvi_path_mesh){0};
    if (mesh->n_triangles > UINT32_MAX / 3 - MORE)
        return vv_fail(VV_E_LIMIT, "the mesh has %zu triangles; paths can be measured along at most %u",
                       mesh->n_triangles, UINT32_MAX / 3 - MORE);
    if ((st = take(&out->place, v, sizeof *out->place, job)) != VV_OK ||
        (st = take(&out->triangle, mesh->n_triangles, 3 * sizeof *out->triangle, job)) != VV_OK ||
        (st = take(&out->length, e + 3 * MORE, sizeof *out->length, job)) != VV_OK ||
        (st = take(&out->twin, e + 3 * MORE, sizeof *out->twin, job)) != VV_OK ||
        (st = take(&out->first, v, sizeof *out->first, job)) != VV_OK ||
        (st = take(&out->corner, e + 3 * MORE, sizeof *out->corner, job)) != VV_OK ||
        (st = take(&out->turning, v, sizeof *out->turning, job)) != VV_OK ||
        (st = copy(out, mesh, to_world, job)) != VV_OK)
        return st;
    out->from = add_place(out, vvi_sub(from, out->origin));
    out->to = add_place(out, vvi_sub(to, out->origin));
    find_neighbours(out);
    return vvi_job_poll(job);
}

void vvi_path_mesh_finish(vvi_path_mesh *m)
{
    vvi_free(m->place);
    vvi_free(m->triangle);
    vvi_free(m->length);
    vvi_free(m->twin);
    vvi_free(m->first);
    vvi_free(m->corner);
    vvi_free(m->turning);
    *m = (vvi_path_mesh){0};
}
