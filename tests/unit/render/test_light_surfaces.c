/* Shadows on surfaces: what is alone is lit as if there were none, and what stands in the way shades. */
#include "fields.h"
#include "ray_scene.h"
#include "render/common/mesh_tree.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#define RADIUS 20.3 /* of balls: their places have nothing to do with those of cells */
#define HALF 32

enum { ROUND = 96, UP = 48, SIDES = ROUND * UP };

static const vv_vec3 ways[] = {{0, 0, -1}, {0.6, 0.2, -0.7}, {-0.3, 0.8, 0.1}, {0.5, 0.6, 0.62}};
enum { WAYS = sizeof ways / sizeof *ways };

/* Corners and triangles of a test's own. */
typedef struct shape {
    float p[(UP + 1) * (ROUND + 1) + 4][3];
    uint32_t t[2 * SIDES + 2][3];
    uint32_t n_p, n_t;
} shape;

static void add_quad(shape *s, const vv_vec3 corner[4])
{
    const uint32_t first = s->n_p;
    for (int i = 0; i < 4; i++) {
        float *p = s->p[s->n_p++];
        p[0] = (float)corner[i].x, p[1] = (float)corner[i].y, p[2] = (float)corner[i].z;
    }
    const uint32_t t[2][3] = {{first, first + 1, first + 2}, {first, first + 2, first + 3}};
    memcpy(s->t[s->n_t], t, sizeof t);
    s->n_t += 2;
}

static vv_vec3 on_ball(double u, double v)
{
    return vvi_vec(sin(v) * cos(u), sin(v) * sin(u), cos(v));
}

static void add_ball(shape *s)
{
    const uint32_t first = s->n_p;
    for (uint32_t j = 0; j <= UP; j++)
        for (uint32_t i = 0; i <= ROUND; i++) {
            const vv_vec3 at = vvi_scaled(on_ball(2 * M_PI * i / ROUND, M_PI * j / UP), RADIUS);
            float *p = s->p[s->n_p++];
            p[0] = (float)at.x, p[1] = (float)at.y, p[2] = (float)at.z;
        }
    for (uint32_t j = 0; j < UP; j++)
        for (uint32_t i = 0; i < ROUND; i++) {
            const uint32_t a = first + j * (ROUND + 1) + i, b = a + 1, c = a + ROUND + 1, d = c + 1;
            const uint32_t t[2][3] = {{a, d, b}, {a, c, d}};
            memcpy(s->t[s->n_t], t, sizeof t);
            s->n_t += 2;
        }
}

/* A scene under one lamp that casts shadows. */
typedef struct shaded {
    test_ray_scene s;
    vv_field *field;
    vv_mesh_actor actor;
    vvi_raycast_state *frame;
} shaded;

static double inside(vv_vec3 p)
{
    return RADIUS - vvi_length(p);
}
static const test_form ball_form = {"ball", inside, NULL};

static void begin(shaded *f)
{
    memset(f, 0, sizeof *f);
    f->field = test_field_cube(&ball_form, 2 * HALF + 1, -HALF, HALF, NULL);
    assert_non_null(f->field);
    test_ray_scene_init(&f->s, f->field, 2 * HALF);
    test_ray_scene_light(&f->s);
    f->s.scene.n_lamps = 1;
    test_ray_scene_set(&f->s, "shadows", "true");
}

static void show_mesh(shaded *f, const shape *s)
{
    const vv_mesh_info info = {.n_vertices = s->n_p, .n_triangles = s->n_t, .positions = s->p[0], .triangles = s->t[0]};
    f->actor = (vv_mesh_actor){
        .look = {.id = "mesh", .color = {1, 1, 1}}, .place = vv_affine_identity(), .opacity = 1, .one_color = true};
    assert_int_equal(vv_mesh_new(&f->actor.mesh, &info, NULL), VV_OK);
    f->s.scene.n_actors = 0;
    f->s.scene.mesh_actors = &f->actor;
    f->s.scene.n_mesh_actors = 1;
}

static void light_from(shaded *f, vv_vec3 travel)
{
    void *prepared = NULL;
    assert_true(vvi_unit(&travel));
    f->s.lamps[0].direction = travel;
    vvi_raycast_finish(f->frame);
    assert_int_equal(vvi_raycast_prepare(&prepared, &f->s.scene, NULL), VV_OK);
    f->frame = prepared;
}

static void finish(shaded *f)
{
    vvi_raycast_finish(f->frame);
    vv_mesh_release(f->actor.mesh);
    test_ray_scene_finish(&f->s);
    vv_field_release(f->field);
}

static double share_at(const shaded *f, vv_vec3 at, vv_vec3 normal)
{
    double shares[VVI_LIGHT_SHARES];
    vvi_light_volume_at(shares, &f->frame->light, at, normal);
    return shares[1];
}

/* Where light falls on it at all: all of it. */
static void assert_lit(const shaded *f, vv_vec3 at, vv_vec3 normal)
{
    const double cosine = -vvi_dot(normal, f->s.lamps[0].direction), share = share_at(f, at, normal);
    if (cosine > 0.2 && share < 0.985)
        fail_msg("at %.2f %.2f %.2f, cosine %.2f: %.4f of the light", at.x, at.y, at.z, cosine, share);
}

static void assert_ball_is_lit(shaded *f)
{
    for (int w = 0; w < WAYS; w++) {
        light_from(f, ways[w]);
        for (uint64_t i = 0; i < 20000; i++) {
            const vv_vec3 n =
                on_ball(2 * M_PI * test_random_unit(3, 2 * i), acos(1 - 2 * test_random_unit(3, 2 * i + 1)));
            assert_lit(f, vvi_scaled(n, RADIUS), n);
        }
    }
}

static void a_ball_of_triangles_alone_has_no_shadow_where_light_falls(void **state)
{
    (void)state;
    static shape s;
    shaded f;
    begin(&f);
    add_ball(&s);
    show_mesh(&f, &s);
    assert_ball_is_lit(&f);
    finish(&f);
}

static void an_isosurface_alone_has_no_shadow_where_light_falls(void **state)
{
    (void)state;
    shaded f;
    begin(&f);
    test_ray_scene_set(&f.s, "mode", "\"isosurface\"");
    test_ray_scene_set(&f.s, "iso", "0");
    assert_ball_is_lit(&f);
    finish(&f);
}

/* However it leans, on both sides. */
static void a_leaning_quad_alone_has_no_shadow(void **state)
{
    (void)state;
    static const vv_vec3 normals[] = {{0, 0, 1}, {-0.2, -0.18, 1}, {1, 0.3, 0.05}, {1, 1, 1}, {0.4, -0.7, 0.5}};
    for (size_t k = 0; k < sizeof normals / sizeof *normals; k++) {
        static shape s;
        shaded f;
        vv_vec3 n = normals[k], u = {0.3, 0.9, -0.4};
        begin(&f);
        assert_true(vvi_unit(&n));
        u = vvi_sub(u, vvi_scaled(n, vvi_dot(u, n)));
        assert_true(vvi_unit(&u));
        const vv_vec3 v = vvi_cross(n, u), all = vvi_add(u, v), across = vvi_sub(u, v);
        const vv_vec3 corner[4] = {vvi_scaled(all, -15), vvi_scaled(across, 15), vvi_scaled(all, 15),
                                   vvi_scaled(across, -15)};
        s.n_p = s.n_t = 0;
        add_quad(&s, corner);
        show_mesh(&f, &s);
        for (int w = 0; w < WAYS; w++) {
            light_from(&f, ways[w]);
            const vv_vec3 side = vvi_scaled(n, vvi_dot(n, f.s.lamps[0].direction) > 0 ? -1 : 1);
            for (uint64_t i = 0; i < 10000; i++)
                assert_lit(&f,
                           vvi_add(vvi_scaled(u, 30 * test_random_unit(5, 2 * i) - 15),
                                   vvi_scaled(v, 30 * test_random_unit(5, 2 * i + 1) - 15)),
                           side);
        }
        finish(&f);
    }
}

/* How far a shadow's edge is soft at a distance behind what casts it: by the lamp's disc, and by the cells, where light
 * strays by up to a half, in the mean square, from slice to slice; twice that leaves out less than 0.03 of it. */
static double rim_at(double distance, double cosine, double cell)
{
    return tan(10 * M_PI / 180 / 2) * distance + cell * (1 + sqrt(distance * cosine / cell));
}

/* A ball that lies on a plate, and a lamp that shines down at a slant: its shadow is an ellipse about the place where
 * its middle's shadow falls, that reaches to where it lies. */
static void a_ball_on_a_plate_shades_it_to_where_it_touches(void **state)
{
    (void)state;
    static shape s;
    shaded f;
    const double cell = 120.0 / 72, z = -RADIUS;
    const vv_vec3 up = {0, 0, 1};
    const vv_vec3 corner[4] = {{-60, -60, z}, {60, -60, z}, {60, 60, z}, {-60, 60, z}};
    begin(&f);
    add_ball(&s);
    add_quad(&s, corner);
    show_mesh(&f, &s);
    light_from(&f, vvi_vec(0.6, 0.2, -0.7));
    const vv_vec3 way = f.s.lamps[0].direction, ahead = vvi_scaled(up, f.frame->light.ahead[2].z);
    for (uint64_t i = 0; i < 20000; i++) {
        const vv_vec3 at = {110 * test_random_unit(6, 2 * i) - 55, 110 * test_random_unit(6, 2 * i + 1) - 55, z};
        const vv_vec3 place = vvi_add(at, ahead);
        const double aside = vvi_length(vvi_cross(place, way)), share = share_at(&f, at, up);
        const double rim = rim_at(fmax(vvi_dot(place, way), 0), -way.z, cell);
        if (aside < RADIUS - rim && share > 0.05)
            fail_msg("%.3f of the light arrives in the shadow, at %.2f %.2f", share, at.x, at.y);
        if (aside > RADIUS + rim && share < 0.95)
            fail_msg("%.3f of the light arrives beside the shadow, at %.2f %.2f", share, at.x, at.y);
    }
    /* It touches the ball, and goes on to below where the ball is as wide. */
    for (int i = 0; i < 50; i++) {
        const vv_vec3 along = {0.6 / sqrt(0.4), 0.2 / sqrt(0.4), 0};
        assert_true(share_at(&f, vvi_add(vvi_scaled(along, RADIUS * i / 50), vvi_vec(0, 0, z)), up) < 0.05);
    }
    finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_isosurface_alone_has_no_shadow_where_light_falls),
        cmocka_unit_test(a_ball_of_triangles_alone_has_no_shadow_where_light_falls),
        cmocka_unit_test(a_leaning_quad_alone_has_no_shadow),
        cmocka_unit_test(a_ball_on_a_plate_shades_it_to_where_it_touches),
    };
    if (!vvi_mesh_tree_exists()) {
        print_message("skipped: this build has no Embree\n");
        return 77;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
