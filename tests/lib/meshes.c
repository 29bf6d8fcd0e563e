#include "meshes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int compare(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Each directed edge as lower vertex, higher vertex, direction: sorted, the two directions of an edge are neighbours.
 */
static uint64_t *sorted_edges(const vv_mesh_info *m)
{
    uint64_t *edges = malloc((3 * m->n_triangles + 1) * sizeof *edges);
    for (size_t t = 0; t < m->n_triangles; t++)
        for (size_t i = 0; i < 3; i++) {
            const uint64_t a = m->triangles[3 * t + i], b = m->triangles[3 * t + (i + 1) % 3];
            edges[3 * t + i] = a < b ? a << 33 | b << 1 : b << 33 | a << 1 | 1;
        }
    qsort(edges, 3 * m->n_triangles, sizeof *edges, compare);
    return edges;
}

size_t test_mesh_bad_edges(const vv_mesh *mesh)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    uint64_t *edges = sorted_edges(m);
    size_t bad = 0;
    const size_t n = 3 * m->n_triangles;
    for (size_t i = 0; i < n;) {
        size_t end = i + 1;
        while (end < n && edges[end] >> 1 == edges[i] >> 1)
            end++;
        if (end != i + 2 || edges[i] == edges[i + 1])
            bad += end - i;
        i = end;
    }
    free(edges);
    return bad;
}

int64_t test_mesh_euler(const vv_mesh *mesh)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    return (int64_t)m->n_vertices - (int64_t)(3 * m->n_triangles / 2) + (int64_t)m->n_triangles;
}

static vv_vec3 cross(vv_vec3 a, vv_vec3 b)
{
    return (vv_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static vv_vec3 minus(vv_vec3 a, vv_vec3 b)
{
    return (vv_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

vv_vec3 test_mesh_vertex(const vv_mesh *mesh, size_t vertex)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    const float *p = m->positions + 3 * vertex;
    return (vv_vec3){m->origin.x + (double)p[0], m->origin.y + (double)p[1], m->origin.z + (double)p[2]};
}

static void corners(vv_vec3 out[3], const vv_mesh *mesh, size_t triangle)
{
    for (size_t i = 0; i < 3; i++)
        out[i] = test_mesh_vertex(mesh, vv_mesh_get_info(mesh)->triangles[3 * triangle + i]);
}

double test_mesh_area(const vv_mesh *mesh)
{
    double sum = 0;
    for (size_t t = 0; t < vv_mesh_get_info(mesh)->n_triangles; t++) {
        vv_vec3 p[3];
        corners(p, mesh, t);
        const vv_vec3 n = cross(minus(p[1], p[0]), minus(p[2], p[0]));
        sum += 0.5 * sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    }
    return sum;
}

double test_mesh_volume(const vv_mesh *mesh)
{
    double sum = 0;
    for (size_t t = 0; t < vv_mesh_get_info(mesh)->n_triangles; t++) {
        vv_vec3 p[3];
        corners(p, mesh, t);
        const vv_vec3 n = cross(p[0], p[1]);
        sum += (n.x * p[2].x + n.y * p[2].y + n.z * p[2].z) / 6;
    }
    return sum;
}
