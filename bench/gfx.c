/* Times the software back end on an isosurface: gfx FILE VALUE [SIZE [FRAMES [PICTURE.png]]]
 *
 * The surface of a volume, or a mesh of few large triangles for FILE "-", is drawn at SIZE x SIZE pixels (1024), from
 * 30 degrees to the side and 20 above, the camera turning 3 degrees a frame. One JSON line for each number of samples a
 * pixel: the first frame (cold), median and best of the others. */
#include "gfx/gfx.h"
#include "bench.h"
#include "core/memory.h"
#include "grid/mesh.h"
#include "surface/marching.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

static vv_status surface_of(vv_mesh **out, const char *path, double value, vv_job *job)
{
    const vvi_marching_options options = {.value = value, .topology = VVI_MARCHING_APART};
    vv_field *field;
    vv_status st = bench_read(&field, path, job);
    if (st != VV_OK)
        return st;
    st = vvi_marching_cubes(out, field, &options, job);
    vv_field_release(field);
    return st;
}

/* A ball of n x 2n quadrangles. */
static vv_status ball(vv_mesh **out, uint32_t n, vv_job *job)
{
    const uint32_t across = 2 * n;
    const vv_mesh_info info = {.n_vertices = (size_t)(n + 1) * (across + 1), .n_triangles = (size_t)2 * n * across};
    vvi_mesh_arrays a;
    const vv_status st = vvi_mesh_new(out, &a, &info, VVI_MESH_NORMALS, job);
    if (st != VV_OK)
        return st;
    for (uint32_t j = 0, v = 0; j <= n; j++)
        for (uint32_t i = 0; i <= across; i++, v++) {
            const double p = PI * j / n, q = 2 * PI * i / across;
            const double at[3] = {sin(p) * cos(q), sin(p) * sin(q), cos(p)};
            for (int c = 0; c < 3; c++) {
                a.normals[3 * v + (uint32_t)c] = (float)at[c];
                a.positions[3 * v + (uint32_t)c] = (float)(100 * at[c]);
            }
        }
    for (uint32_t j = 0, t = 0; j < n; j++)
        for (uint32_t i = 0; i < across; i++, t += 6) {
            const uint32_t v = j * (across + 1) + i,
                           six[6] = {v, v + across + 1, v + 1, v + 1, v + across + 1, v + across + 2};
            memcpy(a.triangles + t, six, sizeof six);
        }
    return VV_OK;
}

static vv_vec3 unit(vv_vec3 v)
{
    const double s = 1 / sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    return (vv_vec3){v.x * s, v.y * s, v.z * s};
}

static vv_vec3 cross(vv_vec3 a, vv_vec3 b)
{
    return (vv_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* 20 degrees wide, so far away that the box's ball fits. */
static vv_lens lens_for(vv_bounds box, double azimuth)
{
    const vv_vec3 half = {(box.hi.x - box.lo.x) / 2, (box.hi.y - box.lo.y) / 2, (box.hi.z - box.lo.z) / 2};
    const double r = sqrt(half.x * half.x + half.y * half.y + half.z * half.z), far = r / sin(10 * PI / 180);
    const double a = azimuth * PI / 180, e = 20 * PI / 180;
    const vv_vec3 out = {cos(e) * sin(a), -cos(e) * cos(a), sin(e)};
    vv_lens lens = {.forward = {-out.x, -out.y, -out.z}, .half_width = tan(10 * PI / 180)};
    lens.half_height = lens.half_width;
    lens.eye =
        (vv_vec3){box.lo.x + half.x + far * out.x, box.lo.y + half.y + far * out.y, box.lo.z + half.z + far * out.z};
    lens.right = unit(cross(lens.forward, (vv_vec3){0, 0, 1}));
    lens.up = cross(lens.right, lens.forward);
    return lens;
}

static vv_status draw(vv_image *image, const vv_mesh *mesh, vv_bounds box, double azimuth, int samples, vv_job *job)
{
    const vv_lens lens = lens_for(box, azimuth);
    const vv_lamp lamp = {.kind = VV_LIGHT_DIRECTIONAL, .direction = lens.forward, .color = {1, 1, 1}};
    const float ambient[3] = {1, 1, 1};
    const size_t n = (size_t)image->width * (size_t)image->height;
    const vvi_gfx_target target = {.image = image, .samples = samples};
    const vvi_gfx_surface surface = {
        .mesh = vv_mesh_get_info(mesh), .place = vv_affine_identity(), .color = {0.9, 0.8, 0.65, 1}};
    vvi_gfx *gfx;
    memset(image->rgba, 0, n * 4 * sizeof(float));
    for (size_t i = 0; i < n; i++)
        image->depth[i] = INFINITY;
    vv_status st = vvi_gfx_begin(&gfx, &vvi_gfx_software, &target, job);
    if (st != VV_OK)
        return st;
    vvi_gfx_camera(gfx, &lens);
    st = vvi_gfx_lights(gfx, &lamp, 1, ambient);
    if (st != VV_OK || (st = vvi_gfx_mesh(gfx, &surface)) != VV_OK) {
        vvi_gfx_abandon(gfx);
        return st;
    }
    return vvi_gfx_end(gfx);
}

static vv_status time_frames(const vv_mesh *mesh, int32_t size, int frames, const char *path, vv_job *job)
{
    static const int samples[] = {1, 4, 8};
    const vv_mesh_info *info = vv_mesh_get_info(mesh);
    const vv_bounds box = vv_mesh_bounds(mesh);
    vv_image *image;
    vv_status st = vv_image_new(&image, size, size, VV_LAYER_DEPTH, job);
    for (size_t s = 0; s < sizeof samples / sizeof *samples && st == VV_OK; s++) {
        bench_times times = {0};
        for (int i = -1; i < frames && st == VV_OK; i++) {
            bench_begin(&times);
            st = draw(image, mesh, box, 30 + 3 * i, samples[s], job);
            bench_end(&times);
        }
        bench_sort(&times);
        const double median = times.seconds[frames / 2];
        if (st == VV_OK)
            printf("{\"triangles\": %zu, \"vertices\": %zu, \"size\": %d, \"samples\": %d, \"isa\": \"%s\", \"n\": %d, "
                   "\"cold_s\": %.5f, \"median_s\": %.5f, \"min_s\": %.5f, \"cpu_s\": %.5f, \"mtriangles_s\": %.1f, "
                   "\"mpixels_s\": %.1f}\n",
                   info->n_triangles, info->n_vertices, size, samples[s], vv_runtime_isa(vv_job_runtime(job)), frames,
                   times.first, median, times.seconds[0], times.processor[frames / 2],
                   (double)info->n_triangles / median * 1e-6, (double)size * size / median * 1e-6);
    }
    if (st == VV_OK && path && (st = draw(image, mesh, box, 30, 4, job)) == VV_OK)
        st = vv_image_write(path, image, NULL, job);
    vv_image_release(image);
    return st;
}

static vv_status run(int argc, char **argv, vv_job *job)
{
    vv_mesh *mesh = NULL;
    const int32_t size = argc > 3 ? atoi(argv[3]) : 1024;
    const int frames = bench_runs(argc > 4 ? atoi(argv[4]) : 15);
    vv_status st = strcmp(argv[1], "-") ? surface_of(&mesh, argv[1], atof(argv[2]), job) : ball(&mesh, 12, job);
    if (st == VV_OK)
        st = time_frames(mesh, size, frames, argc > 5 ? argv[5] : NULL, job);
    vv_mesh_release(mesh);
    return st;
}

int main(int argc, char **argv)
{
    return bench_main(argc, argv, 2, "gfx FILE|- VALUE [SIZE [FRAMES [PICTURE.png]]]", run);
}
