#include "meshes.h"
#include "grid/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

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

/* Marsaglia's xorshift, from 0 to 1. */
static float next_random(uint32_t *seed)
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 17;
    *seed ^= *seed << 5;
    return (float)(*seed >> 8) / (float)(1 << 24);
}

static void fill_vertex(const vvi_mesh_arrays *a, size_t i, uint32_t *seed)
{
    float n[3], square = 0;
    for (size_t c = 0; c < 3; c++) {
        a->positions[3 * i + c] = 100 * next_random(seed) - 30;
        n[c] = next_random(seed) - 0.5F;
        square += n[c] * n[c];
    }
    for (size_t c = 0; a->normals && c < 3; c++)
        a->normals[3 * i + c] = n[c] / sqrtf(square);
    if (a->values)
        a->values[i] = 1e4F * next_random(seed) - 5e3F;
    for (size_t c = 0; a->colors && c < 4; c++)
        a->colors[4 * i + c] = c == 3 ? 255 : (uint8_t)(255.9F * next_random(seed));
}

static void fill_parts(vv_mesh_part *parts, size_t n)
{
    static const char *const names[] = {"bone", "grey matter", "skin <&> \"hair\""};
    for (size_t i = 0; i < 3; i++) {
        strcpy(parts[i].name, names[i]);
        parts[i].color = (vv_color){vv_srgb_decode((double)(80 * i) / 255), vv_srgb_decode(200.0 / 255), 1, 1};
        parts[i].first_triangle = i * n / 3;
        parts[i].n_triangles = (i + 1) * n / 3 - i * n / 3;
    }
}

static void add_textures(vv_mesh *mesh, vv_mesh_part *parts)
{
    static const uint8_t red[4 * 3 * 2] = {255, 0, 0, 255, 200, 10, 20, 255, 5, 6, 7, 255}, blue[4] = {1, 2, 250, 255};
    const vv_mesh_texture both[2] = {{.name = "red.png", .width = 3, .height = 2, .pixels = red},
                                     {.name = "blue.png", .width = 1, .height = 1, .pixels = blue}};
    vvi_mesh_textures *textures;
    if (vvi_mesh_textures_copy(&textures, &(vv_mesh_info){.n_textures = 2, .textures = both}, NULL) != VV_OK)
        abort();
    vvi_mesh_set_textures(mesh, textures);
    parts[0].texture = 2;
    parts[1].texture = 1;
}

vv_mesh *test_mesh_strip(size_t n, unsigned with)
{
    vv_mesh *mesh = NULL;
    vvi_mesh_arrays a;
    uint32_t seed = 2463534242u;
    vv_mesh_info info = {
        .n_vertices = n ? n + 2 : 0, .n_triangles = n, .n_parts = with & TEST_MESH_PARTS && n > 2 ? 3 : 0};
    strcpy(info.unit, "mm");
    strcpy(info.value_name, "density");
    strcpy(info.value_unit, "HU");
    if (with & TEST_MESH_FAR)
        info.origin = (vv_vec3){1e6, -2e6, 3e6};
    const bool placed = with & TEST_MESH_TEXTURES && info.n_parts, cornered = placed && with & TEST_MESH_CORNERS;
    info.n_coordinates = cornered ? 3 * n : info.n_vertices;
    if (vvi_mesh_new(&mesh, &a, &info,
                     (with & 7) | (placed ? VVI_MESH_COORDINATES : 0u) | (cornered ? VVI_MESH_CORNERS : 0u),
                     NULL) != VV_OK)
        return NULL;
    for (size_t i = 0; placed && i < 2 * info.n_coordinates; i++)
        a.coordinates[i] = 3 * next_random(&seed) - 1;
    for (size_t i = 0; cornered && i < 3 * n; i++)
        a.coordinate_of[i] = (uint32_t)(i * 7 % (3 * n));
    for (size_t i = 0; i < info.n_vertices; i++)
        fill_vertex(&a, i, &seed);
    for (size_t t = 0; t < n; t++)
        for (size_t k = 0; k < 3; k++)
            a.triangles[3 * t + k] = (uint32_t)(t + k);
    if (info.n_parts)
        fill_parts(a.parts, n);
    if (placed)
        add_textures(mesh, a.parts);
    return mesh;
}
