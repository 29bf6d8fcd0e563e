/** @file
 * A resolved scene made by hand, and its picture by the ray caster: for tests of pixels against formulas.
 */
#ifndef TEST_RAY_SCENE_H
#define TEST_RAY_SCENE_H
#include "render/raycast/raycast.h"
#include <volvis/sys/scene.h>

/** All that one volume needs; change what the test is about between init and the picture. */
typedef struct test_ray_scene {
    vv_scene scene;
    vv_actor actor;
    vv_statistics statistics;
    vv_plane planes[VVI_RAY_PLANES];
    vv_lamp lamps[4];
    vvi_raycast_params *params;
    double opacity[2 * 16], color[4 * 16];
} test_ray_scene;

/** The field where it stands, seen along -z of the world by a parallel camera whose image is `height` high, at 64 x 64;
 * composite, unshaded, step 1, opaque 0, opacity 0 at every value. */
void test_ray_scene_init(test_ray_scene *s, const vv_field *field, double height);
void test_ray_scene_finish(test_ray_scene *s);
/** A parameter of the picture, as JSON. */
void test_ray_scene_set(test_ray_scene *s, const char *path, const char *json);
/** Opacity rows (value, opacity for a length of 1), and colour rows (value, r, g, b), ascending. */
void test_ray_scene_opacity(test_ray_scene *s, const double *rows, size_t n);
void test_ray_scene_color(test_ray_scene *s, const double *rows, size_t n);
/** Look from `eye` at `at` with z (or y, when looking along z) up. fov 0: parallel of that height. */
void test_ray_scene_look(test_ray_scene *s, vv_vec3 eye, vv_vec3 at, double fov, double height);
/** Blinn shading by a key and a fill from the viewer's side. */
void test_ray_scene_light(test_ray_scene *s);

/** The picture with kernels `cpu` ("base", "avx2", ...; NULL: the best) on that many threads; with depth. Fails the
 * test on an error. */
vv_image *test_ray_picture(const test_ray_scene *s, const char *cpu, int threads);
/** The same by the kernels of one table, whatever the machine's choice would be. */
vv_image *test_ray_picture_by(const test_ray_scene *s, const vvi_ray_kernels *kernels);
/** All pixels by the reference: rgba and depth of each, yours to free(). */
double *test_ray_reference(const test_ray_scene *s);
/** Names of the kernel builds that this machine runs, ending with NULL. */
const char *const *test_ray_cpus(void);

#endif
