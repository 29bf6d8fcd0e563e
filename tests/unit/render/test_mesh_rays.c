/* Meshes in clouds against closed forms: fog of one density around spheres and planes. */
#include "fields.h"
#include "ray_scene.h"
#include "render/common/mesh_tree.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define KAPPA 0.35
#define MIDDLE 3.5

enum { MOST = 3 };

static const double fog_color[3] = {0.2, 0.4, 0.9};

/* Fog of extinction KAPPA over [0, 7]^3, seen along -z from far above by a parallel camera that sees 8 x 8, and meshes
 * in it. */
typedef struct foggy {
    test_ray_scene s;
    vv_field *field;
    vv_mesh_actor actors[MOST];
    vv_plane planes[2];
} foggy;

static double one_value(vv_vec3 p)
{
    (void)p;
    return 1;
}
static vv_vec3 no_gradient(vv_vec3 p)
{
    (void)p;
    return (vv_vec3){0, 0, 0};
}

static void begin(foggy *f, double kappa)
{
    static const test_form one = {"one", one_value, no_gradient};
    memset(f, 0, sizeof *f);
    f->field = test_field_cube(&one, 8, 0, 7, NULL);
    assert_non_null(f->field);
    test_ray_scene_init(&f->s, f->field, 8);
    test_ray_scene_look(&f->s, (vv_vec3){MIDDLE, MIDDLE, 50}, (vv_vec3){MIDDLE, MIDDLE, 0}, 0, 8);
    test_ray_scene_opacity(&f->s, (const double[]){1, 1 - exp(-kappa)}, 1);
    test_ray_scene_color(&f->s, (const double[]){1, fog_color[0], fog_color[1], fog_color[2]}, 1);
    f->s.scene.mesh_actors = f->actors;
}

static void finish(foggy *f)
{
    for (size_t i = 0; i < f->s.scene.n_mesh_actors; i++)
        vv_mesh_release(f->actors[i].mesh);
    test_ray_scene_finish(&f->s);
    vv_field_release(f->field);
}

/* Unlit, of one colour and opacity. */
static vv_mesh_actor *add(foggy *f, vv_mesh *mesh, const float color[3], double opacity)
{
    vv_mesh_actor *a = &f->actors[f->s.scene.n_mesh_actors++];
    *a = (vv_mesh_actor){.look = {.id = "mesh", .shading_model = VV_SHADING_NONE, .planes = f->planes},
                         .mesh = mesh,
                         .place = vv_affine_identity(),
                         .opacity = opacity,
                         .one_color = true};
    memcpy(a->look.color, color, sizeof a->look.color);
    return a;
}

static vv_mesh *new_mesh(const float *positions, size_t n_vertices, const uint32_t *triangles, size_t n_triangles)
{
    vv_mesh *mesh = NULL;
    const vv_mesh_info info = {
        .n_vertices = n_vertices, .n_triangles = n_triangles, .positions = positions, .triangles = triangles};
    assert_int_equal(vv_mesh_new(&mesh, &info, NULL), VV_OK);
    return mesh;
}

/* The unit square [0, 7]^2 at a height, of 2 x 14 x 14 triangles, whose edges rays go through. */
static vv_mesh *new_plane(double z)
{
    enum { N = 14 };
    static float p[(N + 1) * (N + 1)][3];
    static uint32_t t[2 * N * N][3];
    for (uint32_t j = 0; j <= N; j++)
        for (uint32_t i = 0; i <= N; i++) {
            float *at = p[j * (N + 1) + i];
            at[0] = (float)i * 7 / N, at[1] = (float)j * 7 / N, at[2] = (float)z;
        }
    for (uint32_t j = 0; j < N; j++)
        for (uint32_t i = 0; i < N; i++) {
            const uint32_t a = j * (N + 1) + i, b = a + 1, c = a + N + 1, d = c + 1;
            uint32_t *q = t[2 * (j * N + i)];
            q[0] = a, q[1] = b, q[2] = d;
            q[3] = a, q[4] = d, q[5] = c;
        }
    return new_mesh(p[0], (N + 1) * (N + 1), t[0], 2 * N * N);
}

/* About a middle, by longitude and latitude; poles are rings of triangles without area on one side. */
static vv_mesh *new_sphere(double radius)
{
    enum { N = 512, M = 256 };
    static float p[(M + 1) * (N + 1)][3];
    static uint32_t t[2 * M * N][3];
    for (uint32_t j = 0; j <= M; j++)
        for (uint32_t i = 0; i <= N; i++) {
            const double u = 2 * M_PI * i / N, v = M_PI * j / M;
            float *at = p[j * (N + 1) + i];
            at[0] = (float)(MIDDLE + radius * sin(v) * cos(u));
            at[1] = (float)(MIDDLE + radius * sin(v) * sin(u));
            at[2] = (float)(MIDDLE + radius * cos(v));
        }
    for (uint32_t j = 0; j < M; j++)
        for (uint32_t i = 0; i < N; i++) {
            const uint32_t a = j * (N + 1) + i, b = a + 1, c = a + N + 1, d = c + 1;
            uint32_t *q = t[2 * (j * N + i)];
            q[0] = a, q[1] = d, q[2] = b;
            q[3] = a, q[4] = c, q[5] = d;
        }
    return new_mesh(p[0], (M + 1) * (N + 1), t[0], 2 * M * N);
}

static double place(int32_t i)
{
    return MIDDLE + ((i + 0.5) / 64 - 0.5) * 8;
}

static void assert_pixel(const vv_image *image, int32_t x, int32_t y, const double want[4], double tolerance)
{
    const float *got = image->rgba + 4 * (y * image->width + x);
    for (int c = 0; c < 4; c++)
        if (!(fabs((double)got[c] - want[c]) <= tolerance))
            fail_msg("pixel %d,%d channel %d: %.7f, expected %.7f", x, y, c, (double)got[c], want[c]);
}

/* Fog of a thickness in front of light with a coverage. */
static void put_fog(double rgba[4], double thickness)
{
    const double through = exp(-KAPPA * thickness);
    for (int c = 0; c < 3; c++)
        rgba[c] = fog_color[c] * (1 - through) + through * rgba[c];
    rgba[3] = 1 - through * (1 - rgba[3]);
}

static void a_sphere_in_fog_is_dimmed_by_what_lies_before_it(void **state)
{
    (void)state;
    foggy f;
    begin(&f, KAPPA);
    const float color[3] = {0.9f, 0.5f, 0.1f};
    add(&f, new_sphere(2.5), color, 1);
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        vv_image *image = test_ray_picture(&f.s, *cpu, 2);
        for (int32_t j = 0; j < 64; j++)
            for (int32_t i = 0; i < 64; i++) {
                const double x = place(i), y = 7 - place(j), r = hypot(x - MIDDLE, y - MIDDLE);
                const double depth = (double)image->depth[j * 64 + i];
                double want[4] = {0};
                if (fabs(r - 2.5) < 0.02 || fmax(fabs(x - MIDDLE), fabs(y - MIDDLE)) > 3.5 - 0.02)
                    continue; /* the rim is one of flat triangles */
                if (r < 2.5) {
                    const double height = MIDDLE + sqrt(2.5 * 2.5 - r * r);
                    for (int c = 0; c < 3; c++)
                        want[c] = (double)color[c];
                    want[3] = 1;
                    put_fog(want, 7 - height);
                    assert_true(fabs(depth - (exp(-KAPPA * (7 - height)) > 0.5 ? 50 - height : depth)) < 2e-3);
                } else if (fmax(fabs(x - MIDDLE), fabs(y - MIDDLE)) < 3.5) {
                    put_fog(want, 7);
                }
                assert_pixel(image, i, j, want, r < 2.4 ? 1e-4 : 1e-3);
            }
        vv_image_release(image);
    }
    finish(&f);
}

/* ln 2 / kappa behind its front, wherever samples lie and however many there are. */
static void half_of_fog_is_gone_where_the_formula_says(void **state)
{
    static const char *const steps[] = {"2", "1", "0.37", "0.05"};
    (void)state;
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (int i = 0; i < 16; i++) {
            foggy f;
            begin(&f, KAPPA);
            test_ray_scene_set(&f.s, "step", steps[i % 4]);
            test_ray_scene_set(&f.s, "jitter", i & 4 ? "true" : "false");
            if (i & 8)
                test_ray_scene_light(&f.s);
            vv_image *image = test_ray_picture(&f.s, *cpu, 2);
            for (int32_t y = 5; y < 59; y++)
                for (int32_t x = 5; x < 59; x++)
                    assert_true(fabs((double)image->depth[y * 64 + x] - 43 - log(2) / KAPPA) < 2e-3);
            vv_image_release(image);
            finish(&f);
        }
}

/* Two sheets, given from far to near, and an opaque floor: fog in every gap. No ray through an edge counts twice. */
static void translucent_sheets_and_fog_alternate(void **state)
{
    (void)state;
    foggy f;
    begin(&f, KAPPA);
    const float red[3] = {1, 0, 0}, green[3] = {0, 1, 0}, white[3] = {1, 1, 1};
    add(&f, new_plane(2), red, 0.5);
    add(&f, new_plane(5), green, 0.25);
    add(&f, new_plane(0.5), white, 1);
    vv_image *image = test_ray_picture(&f.s, NULL, 2);
    double want[4] = {1, 1, 1, 1};
    put_fog(want, 1.5);
    for (int c = 0; c < 3; c++)
        want[c] = 0.5 * (double)red[c] + 0.5 * want[c];
    put_fog(want, 3);
    for (int c = 0; c < 3; c++)
        want[c] = 0.25 * (double)green[c] + 0.75 * want[c];
    put_fog(want, 2);
    for (int32_t j = 5; j < 59; j++)
        for (int32_t i = 5; i < 59; i++)
            assert_pixel(image, i, j, want, 1e-5);
    vv_image_release(image);
    finish(&f);
}

static void cuts_open_meshes_as_they_open_clouds(void **state)
{
    (void)state;
    foggy f;
    begin(&f, KAPPA);
    const float white[3] = {1, 1, 1};
    vv_mesh_actor *a = add(&f, new_plane(5), white, 1);
    f.planes[0] = (vv_plane){.normal = {1, 0, 0}, .offset = MIDDLE};
    a->look.n_planes = 1;
    vv_image *image = test_ray_picture(&f.s, NULL, 1);
    double there[4] = {1, 1, 1, 1}, away[4] = {0};
    put_fog(there, 2);
    put_fog(away, 7);
    assert_pixel(image, 40, 32, there, 1e-5);
    assert_pixel(image, 24, 32, away, 1e-5);
    vv_image_release(image);
    finish(&f);
}

/* The same mesh in other numbers, far from zero, turned by its place. */
static void placed_meshes_are_where_they_are_put(void **state)
{
    (void)state;
    foggy f;
    begin(&f, KAPPA);
    const float white[3] = {1, 1, 1};
    vv_mesh_actor *a = add(&f, new_plane(0), white, 1);
    a->place = (vv_affine){.axis = {{0, 1e-3, 0}, {-1e-3, 0, 0}, {0, 0, 1}}, .origin = {7, 0, 4}};
    a->place = vv_affine_compose(a->place, (vv_affine){.axis = {{1e3, 0, 0}, {0, 1e3, 0}, {0, 0, 1}}});
    vv_image *image = test_ray_picture(&f.s, NULL, 1);
    double want[4] = {1, 1, 1, 1};
    put_fog(want, 3);
    for (int32_t j = 6; j < 58; j++)
        assert_pixel(image, 63 - j, j, want, 1e-5);
    vv_image_release(image);
    finish(&f);
}

/* Light on a plane that faces the eye: one lamp from the eye, ambient and diffuse. */
static void meshes_are_lit_by_the_definition(void **state)
{
    (void)state;
    foggy f;
    begin(&f, 0);
    const float color[3] = {0.5f, 0.25f, 1};
    vv_mesh_actor *a = add(&f, new_plane(3), color, 1);
    a->look.shading_model = VV_SHADING_BLINN;
    a->look.ambient = 0.2f, a->look.diffuse = 0.6f, a->look.specular = 0, a->look.shininess = 8;
    f.s.scene.n_lamps = 1;
    f.s.lamps[0] = (vv_lamp){.kind = VV_LIGHT_DIRECTIONAL, .direction = {0, 0.6, -0.8}, .color = {1, 1, 1}};
    for (int c = 0; c < 3; c++)
        f.s.scene.ambient[c] = 1;
    vv_image *image = test_ray_picture(&f.s, NULL, 1);
    double want[4] = {0, 0, 0, 1};
    for (int c = 0; c < 3; c++)
        want[c] = (double)color[c] * (0.2 + 0.6 * 0.8);
    assert_pixel(image, 20, 40, want, 1e-6);
    vv_image_release(image);
    finish(&f);
}

/* Random rays among random triangles: the tree's nearest hit is that of all triangles, tried one by one in doubles. */
static double hit_triangle(const float *p, const uint32_t v[3], const double o[3], const double d[3])
{
    double e[3], g[3], q[3], h[3], s[3];
    for (int a = 0; a < 3; a++) {
        e[a] = (double)p[3 * v[1] + (uint32_t)a] - (double)p[3 * v[0] + (uint32_t)a];
        g[a] = (double)p[3 * v[2] + (uint32_t)a] - (double)p[3 * v[0] + (uint32_t)a];
        s[a] = o[a] - (double)p[3 * v[0] + (uint32_t)a];
    }
    for (int a = 0; a < 3; a++)
        h[a] = d[(a + 1) % 3] * g[(a + 2) % 3] - d[(a + 2) % 3] * g[(a + 1) % 3];
    for (int a = 0; a < 3; a++)
        q[a] = s[(a + 1) % 3] * e[(a + 2) % 3] - s[(a + 2) % 3] * e[(a + 1) % 3];
    const double det = e[0] * h[0] + e[1] * h[1] + e[2] * h[2];
    const double u = (s[0] * h[0] + s[1] * h[1] + s[2] * h[2]) / det;
    const double w = (d[0] * q[0] + d[1] * q[1] + d[2] * q[2]) / det;
    const double t = (g[0] * q[0] + g[1] * q[1] + g[2] * q[2]) / det;
    return u >= 0 && w >= 0 && u + w <= 1 && t >= 0 ? t : INFINITY;
}

static double roll(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 9007199254740992.0;
}

static void trees_find_what_trying_all_triangles_finds(void **state)
{
    (void)state;
    enum { TRIANGLES = 300, RAYS = 2000 };
    static float p[9 * TRIANGLES];
    static uint32_t t[3 * TRIANGLES];
    uint64_t dice = 7;
    vvi_cached *tree = NULL;
    for (size_t i = 0; i < 9 * TRIANGLES; i++)
        p[i] = (float)(4 * roll(&dice) + (double)(p[i / 9 * 9 + i % 3]) / 4);
    for (uint32_t i = 0; i < 3 * TRIANGLES; i++)
        t[i] = i;
    vv_mesh *mesh = new_mesh(p, 3 * TRIANGLES, t, TRIANGLES);
    assert_int_equal(vvi_mesh_tree_get(&tree, mesh, NULL), VV_OK);
    int n_hits = 0;
    for (int i = 0; i < RAYS; i++) {
        double o[3], d[3], nearest = INFINITY;
        vvi_mesh_ray ray = {.near = 0, .far = INFINITY};
        vvi_mesh_hit hit;
        for (int a = 0; a < 3; a++) {
            o[a] = (double)(ray.origin[a] = (float)(6 * roll(&dice) - 1));
            d[a] = (double)(ray.direction[a] = (float)(2 * roll(&dice) - 1));
        }
        for (size_t k = 0; k < TRIANGLES; k++)
            nearest = fmin(nearest, hit_triangle(p, t + 3 * k, o, d));
        const bool found = vvi_mesh_tree_hit(&hit, tree, &ray, NULL, NULL);
        n_hits += found;
        if (found != isfinite(nearest) || (found && fabs((double)hit.distance - nearest) > 1e-4 * (1 + nearest)))
            fail_msg("ray %d: %g, expected %g", i, found ? (double)hit.distance : (double)INFINITY, nearest);
    }
    assert_in_range(n_hits, RAYS / 4, RAYS - 10);
    vvi_cache_release(tree);
    vv_mesh_release(mesh);
}

/* A sheet across fog that is next to clear, under a lamp from above: light above it, and its share below. */
static void meshes_cast_shadows_by_their_opacity(void **state)
{
    (void)state;
    static const double opacities[] = {1, 0.5};
    for (size_t k = 0; k < 2; k++) {
        foggy f;
        begin(&f, 1e-6);
        const float white[3] = {1, 1, 1};
        add(&f, new_plane(3.4), white, opacities[k]);
        test_ray_scene_light(&f.s);
        f.s.scene.n_lamps = 1;
        f.s.lamps[0].direction = vvi_vec(0, 0, -1);
        vv_object *params = &f.s.params->base;
        assert_int_equal(vv_path_set(&params, "shadows", "true", NULL), VV_OK);
        f.s.params = (vvi_raycast_params *)params;
        f.s.scene.params = params;
        void *prepared = NULL;
        double shares[VVI_LIGHT_SHARES];
        assert_int_equal(vvi_raycast_prepare(&prepared, &f.s.scene, NULL), VV_OK);
        const vvi_raycast_state *frame = prepared;
        vvi_light_volume_at(shares, &frame->light, (vv_vec3){MIDDLE, MIDDLE, 6}, (vv_vec3){0, 0, 0});
        assert_float_equal(shares[1], 1, 0.01);
        vvi_light_volume_at(shares, &frame->light, (vv_vec3){MIDDLE, MIDDLE, 1}, (vv_vec3){0, 0, 0});
        assert_float_equal(shares[1], 1 - opacities[k], 0.05);
        vvi_raycast_finish(prepared);
        finish(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sphere_in_fog_is_dimmed_by_what_lies_before_it),
        cmocka_unit_test(half_of_fog_is_gone_where_the_formula_says),
        cmocka_unit_test(translucent_sheets_and_fog_alternate),
        cmocka_unit_test(cuts_open_meshes_as_they_open_clouds),
        cmocka_unit_test(placed_meshes_are_where_they_are_put),
        cmocka_unit_test(meshes_are_lit_by_the_definition),
        cmocka_unit_test(meshes_cast_shadows_by_their_opacity),
        cmocka_unit_test(trees_find_what_trying_all_triangles_finds),
    };
    if (!vvi_mesh_tree_exists()) {
        print_message("skipped: this build has no Embree\n");
        return 77;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
