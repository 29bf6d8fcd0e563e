/* The shading reference against values worked out by hand. */
#include "render/common/shade_ref.h"
#include "scene/lens.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct stage {
    vv_scene scene;
    vv_lamp lamp;
    vv_actor actor;
} stage;

static const double white[3] = {1, 1, 1};

/* One lamp that shines along -z; ambient 0.1 of 0.5, diffuse 0.6, specular 0.3. */
static void set(stage *s)
{
    *s = (stage){.lamp = {.kind = VV_LIGHT_DIRECTIONAL, .direction = {0, 0, -1}, .color = {1, 1, 1}},
                 .scene = {.n_lamps = 1, .ambient = {0.5f, 0.5f, 0.5f}},
                 .actor = {.shading_model = VV_SHADING_BLINN,
                           .ambient = 0.1f,
                           .diffuse = 0.6f,
                           .specular = 0.3f,
                           .shininess = 8,
                           .two_sided = true}};
    s->scene.lamps = &s->lamp;
}

static double shade(const stage *s, vv_vec3 gradient, vv_vec3 to_eye)
{
    double out[3];
    vvi_unit(&to_eye);
    vvi_shade_ref(out, &s->scene, &s->actor, white, vvi_vec(0, 0, 0), gradient, to_eye, 1e-6, NULL);
    return out[0];
}

#define NEAR(found, expected)                                                                                          \
    do {                                                                                                               \
        const double f_ = (found), e_ = (expected);                                                                    \
        if (fabs(f_ - e_) > 1e-6)                                                                                      \
            fail_msg("%.9g is not %.9g", f_, e_);                                                                      \
    } while (0)

static void light_and_eye_on_the_normal_add_up(void **state)
{
    stage s;
    set(&s);
    NEAR(shade(&s, vvi_vec(0, 0, -5), vvi_vec(0, 0, 1)), 0.05 + 0.6 + 0.3);
    s.actor.shading_model = VV_SHADING_PHONG;
    NEAR(shade(&s, vvi_vec(0, 0, -5), vvi_vec(0, 0, 1)), 0.05 + 0.6 + 0.3);
    s.actor.shading_model = VV_SHADING_NONE;
    NEAR(shade(&s, vvi_vec(0, 0, -5), vvi_vec(0, 0, 1)), 1);
}

static void oblique_angles_follow_the_formulas(void **state)
{
    stage s;
    set(&s);
    const vv_vec3 gradient = {0, -1, -1}, eye = {1, 0, 1}; /* n at 45 degrees to the light, eye too */
    const double n_l = sqrt(0.5);
    vv_vec3 h = {sqrt(0.5), 0, 1 + sqrt(0.5)};
    vvi_unit(&h);
    const double blinn = pow(vvi_dot(h, vvi_vec(0, n_l, n_l)), 8);
    NEAR(shade(&s, gradient, eye), 0.05 + 0.6 * n_l + 0.3 * blinn);
    s.actor.shading_model = VV_SHADING_PHONG; /* r = (0, 1, 0), no highlight towards (1, 0, 1) */
    NEAR(shade(&s, gradient, eye), 0.05 + 0.6 * n_l);
    NEAR(shade(&s, gradient, vvi_vec(0, 1, 1)), 0.05 + 0.6 * n_l + 0.3 * pow(sqrt(0.5), 8));
}

static void two_sided_surfaces_look_the_same_from_inside(void **state)
{
    stage s;
    set(&s);
    const vv_vec3 g = {0.3, -0.5, -1}, eye = {0.2, 0.1, 1};
    NEAR(shade(&s, g, eye), shade(&s, vvi_scaled(g, -1), eye));
    s.actor.two_sided = false;
    assert_true(shade(&s, g, eye) > 0.3);
    NEAR(shade(&s, vvi_scaled(g, -1), eye), 0.05);
}

static void flat_places_face_the_viewer_without_highlight(void **state)
{
    stage s;
    set(&s);
    NEAR(shade(&s, vvi_vec(0, 0, 1e-7), vvi_vec(0, 0, 1)), 0.05 + 0.6);
    NEAR(shade(&s, vvi_vec(0, 0, 0), vvi_vec(0, 1, 1)), 0.05 + 0.6 * sqrt(0.5));
}

/* A gradient counts by what the nodes tell apart, and not by what lies far outside. */
static void what_is_flat_follows_the_nodes(void **state)
{
    static const double opacity[] = {0, 0, 30, 1};
    vv_field_info info = vv_field_info_default();
    void *data;
    vv_field *field;
    info.type = VV_TYPE_F32;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    vv_statistics s = {.min = -1e30, .max = 30, .count = 9};
    vv_actor actor = {.field = field, .statistics = &s};
    actor.classes = (vv_classification){.kind = VV_SEGMENT_TRANSFER, .opacity = opacity, .n_opacity = 2};
    NEAR(vvi_shade_range(&actor), 30);
    s.min = -5;
    s.max = 1e6;
    NEAR(vvi_shade_range(&actor), 30);
    s.max = 10; /* the last node is beyond the data */
    NEAR(vvi_shade_range(&actor), 10);
    actor.classes.n_opacity = 0;
    NEAR(vvi_shade_range(&actor), 15);
    actor.classes = (vv_classification){.kind = VV_SEGMENT_THRESHOLD, .lo = 2, .hi = INFINITY};
    s.max = 1e6;
    NEAR(vvi_shade_range(&actor), 2);
    actor.cubic = true;
    NEAR(vvi_shade_range(&actor), 1000005);
    vv_field_release(field);
}

static void point_lights_fall_off_and_spots_have_an_edge(void **state)
{
    vv_lamp lamp = {.kind = VV_LIGHT_POINT, .position = {0, 0, 3}, .color = {1, 1, 1}, .falloff = {1, 0, 1}};
    vv_vec3 to_lamp;
    double light[3];
    vvi_lamp_at(&to_lamp, light, &lamp, vvi_vec(0, 0, 0));
    NEAR(light[0], 0.1);
    NEAR(to_lamp.z, 1);
    lamp.kind = VV_LIGHT_SPOT;
    lamp.falloff = vvi_vec(1, 0, 0);
    lamp.direction = vvi_vec(0, 0, -1);
    lamp.cos_outer = cos(0.5);
    lamp.cos_inner = cos(0.3);
    const double angle[] = {0, 0.29, 0.51};
    const double expected[] = {1, 1, 0};
    for (int i = 0; i < 3; i++) {
        vvi_lamp_at(&to_lamp, light, &lamp, vvi_vec(3 * tan(angle[i]), 0, 0));
        NEAR(light[1], expected[i]);
    }
    const double half = acos((cos(0.5) + cos(0.3)) / 2);
    vvi_lamp_at(&to_lamp, light, &lamp, vvi_vec(0, 3 * tan(half), 0));
    NEAR(light[2], 0.5);
    vvi_lamp_at(&to_lamp, light, &lamp, lamp.position); /* in the lamp itself */
    assert_true(isfinite(light[0]) && isfinite(to_lamp.z));
}

static void lamps_add(void **state)
{
    stage s;
    set(&s);
    const double one = shade(&s, vvi_vec(0, -1, -1), vvi_vec(0, 0, 1));
    const vv_lamp two[2] = {s.lamp, s.lamp};
    s.scene.lamps = (vv_lamp *)two;
    s.scene.n_lamps = 2;
    NEAR(shade(&s, vvi_vec(0, -1, -1), vvi_vec(0, 0, 1)) - one, one - 0.05);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_and_eye_on_the_normal_add_up),
        cmocka_unit_test(oblique_angles_follow_the_formulas),
        cmocka_unit_test(two_sided_surfaces_look_the_same_from_inside),
        cmocka_unit_test(flat_places_face_the_viewer_without_highlight),
        cmocka_unit_test(what_is_flat_follows_the_nodes),
        cmocka_unit_test(point_lights_fall_off_and_spots_have_an_edge),
        cmocka_unit_test(lamps_add),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
