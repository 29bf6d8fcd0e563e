#include "mesh_pieces.h"
#include "meshes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static uint32_t root(uint32_t *of, uint32_t v)
{
    while (of[v] != v)
        v = of[v] = of[of[v]];
    return v;
}

uint32_t *test_mesh_pieces(const vv_mesh *mesh, size_t *n_out)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    uint32_t *of = malloc((m->n_vertices + 1) * sizeof *of);
    *n_out = 0;
    for (uint32_t v = 0; v < m->n_vertices; v++)
        of[v] = v;
    for (size_t i = 0; i < 3 * m->n_triangles; i++) {
        const uint32_t a = root(of, m->triangles[i]), b = root(of, m->triangles[i / 3 * 3]);
        of[a < b ? b : a] = a < b ? a : b;
    }
    for (uint32_t v = 0; v < m->n_vertices; v++) {
        of[v] = root(of, v);
        *n_out += of[v] == v;
    }
    return of;
}

static int compare(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(test_triangle));
}

static test_triangle triangle(const vv_mesh_info *m, size_t t)
{
    test_triangle out = {{{0}}}, best = out;
    for (size_t first = 0; first < 3; first++) {
        for (size_t i = 0; i < 3; i++) {
            const size_t v = m->triangles[3 * t + (first + i) % 3];
            memcpy(out.corner[i], m->positions + 3 * v, 3 * sizeof(float));
            if (m->normals)
                memcpy(out.corner[i] + 3, m->normals + 3 * v, 3 * sizeof(float));
        }
        if (first == 0 || compare(&out, &best) < 0)
            best = out;
    }
    return best;
}

test_triangle *test_mesh_triangles(const vv_mesh *mesh, const uint32_t *pieces, uint32_t piece, size_t *n_out)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    test_triangle *out = malloc((m->n_triangles + 1) * sizeof *out);
    *n_out = 0;
    for (size_t t = 0; t < m->n_triangles; t++)
        if (piece == UINT32_MAX || pieces[m->triangles[3 * t]] == piece)
            out[(*n_out)++] = triangle(m, t);
    qsort(out, *n_out, sizeof *out, compare);
    return out;
}

uint32_t test_mesh_nearest(const vv_mesh *mesh, vv_vec3 place)
{
    uint32_t best = 0;
    double least = INFINITY;
    for (uint32_t v = 0; v < vv_mesh_get_info(mesh)->n_vertices; v++) {
        const vv_vec3 p = test_mesh_vertex(mesh, v);
        const double d = hypot(hypot(p.x - place.x, p.y - place.y), p.z - place.z);
        if (d < least) {
            least = d;
            best = v;
        }
    }
    return best;
}
