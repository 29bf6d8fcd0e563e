#include "shapes.h"
#include "fields.h"
#include "grid/mesh.h"
#include "surface/marching.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

vv_mesh *test_mesh_new(const float *positions, size_t n_vertices, const uint32_t *triangles, size_t n_triangles)
{
    vv_mesh *mesh;
    vvi_mesh_arrays arrays;
    const vv_mesh_info info = {.n_vertices = n_vertices, .n_triangles = n_triangles, .unit = "mm"};
    assert_int_equal(vvi_mesh_new(&mesh, &arrays, &info, 0, NULL), VV_OK);
    if (n_vertices)
        memcpy(arrays.positions, positions, 3 * n_vertices * sizeof *positions);
    if (n_triangles)
        memcpy(arrays.triangles, triangles, 3 * n_triangles * sizeof *triangles);
    return mesh;
}

vv_mesh *test_mesh_box(double x, double y, double z, vv_vec3 origin)
{
    static const uint32_t faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                          {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    float p[8][3];
    for (int i = 0; i < 8; i++) {
        p[i][0] = (float)(origin.x + (i & 1 ? x : 0));
        p[i][1] = (float)(origin.y + (i & 2 ? y : 0));
        p[i][2] = (float)(origin.z + (i & 4 ? z : 0));
    }
    return test_mesh_new(p[0], 8, faces[0], 12);
}

/* A number for the middle of each edge, found again by its ends in a list for each lower vertex. */
typedef struct middles {
    uint32_t (*other)[8], (*number)[8];
} middles;

static uint32_t middle(middles *m, float *p, uint32_t *n, uint32_t a, uint32_t b)
{
    const uint32_t low = a < b ? a : b, high = a < b ? b : a;
    int i = 0;
    while (m->other[low][i] && m->other[low][i] != high)
        i++;
    if (!m->other[low][i]) {
        m->other[low][i] = high;
        m->number[low][i] = *n;
        for (int c = 0; c < 3; c++)
            p[3 * (size_t)*n + (size_t)c] = (p[3 * (size_t)a + (size_t)c] + p[3 * (size_t)b + (size_t)c]) / 2;
        (*n)++;
    }
    return m->number[low][i];
}

static void split(float *p, uint32_t *n_vertices, uint32_t *t, size_t n_triangles)
{
    middles m = {calloc(*n_vertices, sizeof *m.other), calloc(*n_vertices, sizeof *m.number)};
    uint32_t *more = t + 3 * n_triangles;
    for (size_t i = 0; i < n_triangles; i++, more += 9) {
        const uint32_t a = t[3 * i], b = t[3 * i + 1], c = t[3 * i + 2];
        const uint32_t ab = middle(&m, p, n_vertices, a, b), bc = middle(&m, p, n_vertices, b, c),
                       ca = middle(&m, p, n_vertices, c, a);
        const uint32_t made[12] = {ab, bc, ca, a, ab, ca, ab, b, bc, ca, bc, c};
        memcpy(t + 3 * i, made, 3 * sizeof *t);
        memcpy(more, made + 3, 9 * sizeof *t);
    }
    free(m.other);
    free(m.number);
}

vv_mesh *test_mesh_sphere(vv_vec3 center, double radius, int splits)
{
    static const uint32_t faces[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                          {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                          {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                          {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    const float g = (float)((1 + sqrt(5)) / 2);
    const float corners[12][3] = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                  {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    const size_t n_triangles = (size_t)20 << 2 * splits;
    float *p = calloc(n_triangles / 2 + 2, 3 * sizeof *p);
    uint32_t *t = calloc(n_triangles, 3 * sizeof *t), n = 12;
    memcpy(p, corners, sizeof corners);
    memcpy(t, faces, sizeof faces);
    for (int s = 0; s < splits; s++)
        split(p, &n, t, (size_t)20 << 2 * s);
    for (size_t i = 0; i < n; i++) {
        double v[3] = {(double)p[3 * i], (double)p[3 * i + 1], (double)p[3 * i + 2]};
        const double scale = radius / sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        for (size_t c = 0; c < 3; c++)
            p[3 * i + c] = (float)((&center.x)[c] + scale * v[c]);
    }
    vv_mesh *mesh = test_mesh_new(p, n, t, n_triangles);
    free(p);
    free(t);
    return mesh;
}

vv_mesh *test_mesh_square(double size, uint32_t n)
{
    float *p = calloc((size_t)(n + 1) * (n + 1), 3 * sizeof *p);
    uint32_t *t = calloc(2 * (size_t)n * n, 3 * sizeof *t), *next = t;
    for (uint32_t j = 0; j <= n; j++)
        for (uint32_t i = 0; i <= n; i++) {
            p[3 * (j * (n + 1) + i)] = (float)(size * i / n);
            p[3 * (j * (n + 1) + i) + 1] = (float)(size * j / n);
        }
    for (uint32_t j = 0; j < n; j++)
        for (uint32_t i = 0; i < n; i++, next += 6) {
            const uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
            memcpy(next, (const uint32_t[6]){a, b, d, a, d, c}, 6 * sizeof *next);
        }
    vv_mesh *mesh = test_mesh_new(p, (size_t)(n + 1) * (n + 1), t, 2 * (size_t)n * n);
    free(p);
    free(t);
    return mesh;
}

static const vv_vec3 middle_of_all = {.13, .27, .41};
static double wanted_radius, wanted_major;

static double sphere(vv_vec3 p)
{
    const double x = p.x - middle_of_all.x, y = p.y - middle_of_all.y, z = p.z - middle_of_all.z;
    return wanted_radius - sqrt(x * x + y * y + z * z);
}

static double torus(vv_vec3 p)
{
    const double x = p.x - middle_of_all.x, y = p.y - middle_of_all.y, z = p.z - middle_of_all.z;
    return wanted_radius - hypot(hypot(x, y) - wanted_major, z);
}

static vv_mesh *march(double (*value)(vv_vec3), double reach, bool normals)
{
    const test_form form = {.name = "shape", .value = value};
    const int64_t half = (int64_t)ceil(reach) + 2;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    info.grid = test_cube(2 * half + 1, (double)-half, (double)half);
    vv_field *field = test_field(&form, &info, NULL);
    vv_mesh *mesh;
    const vvi_marching_options options = {.value = 0, .no_normals = !normals};
    assert_int_equal(vvi_marching_cubes(&mesh, field, &options, NULL), VV_OK);
    vv_field_release(field);
    return mesh;
}

vv_mesh *test_mesh_marched_sphere(double radius, bool normals)
{
    wanted_radius = radius;
    return march(sphere, radius, normals);
}

vv_mesh *test_mesh_marched_torus(double major, double minor)
{
    wanted_radius = minor;
    wanted_major = major;
    return march(torus, major + minor, true);
}

vv_mesh *test_mesh_unshared(const vv_mesh *mesh)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    const size_t n = 3 * m->n_triangles;
    float *p = calloc(n + 1, 3 * sizeof *p);
    uint32_t *t = calloc(n + 1, sizeof *t);
    for (size_t i = 0; i < n; i++) {
        t[i] = (uint32_t)i;
        memcpy(p + 3 * i, m->positions + 3 * (size_t)m->triangles[i], 3 * sizeof *p);
    }
    vv_mesh *out = test_mesh_new(p, n, t, m->n_triangles);
    free(p);
    free(t);
    return out;
}

vv_mesh *test_mesh_less(const vv_mesh *mesh, size_t n_triangles)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    return test_mesh_new(m->positions, m->n_vertices, m->triangles, m->n_triangles - n_triangles);
}
