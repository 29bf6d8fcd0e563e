#include "together.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>

#include <cmocka.h>

test_ray_scene *test_together_add(test_together *t, vv_field *field)
{
    static const char *const ids[TEST_TOGETHER_MOST] = {"a", "b", "c", "d"};
    test_ray_scene *s = &t->part[t->n];
    assert_non_null(field);
    test_ray_scene_init(s, field, 1);
    s->actor.id = ids[t->n];
    t->field[t->n++] = field;
    return s;
}

test_ray_scene *test_together_all(test_together *t)
{
    for (size_t i = 0; i < t->n; i++) {
        t->actors[i] = t->part[i].actor;
        if (t->own)
            t->actors[i].params = &t->part[i].params->base;
    }
    t->part[0].scene.actors = t->actors;
    t->part[0].scene.n_actors = t->n;
    return &t->part[0];
}

void test_together_finish(test_together *t)
{
    for (size_t i = 0; i < t->n; i++) {
        test_ray_scene_finish(&t->part[i]);
        vv_field_release(t->field[i]);
        vv_field_release(t->extra[i]);
    }
}

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

const test_form test_form_one = {"one", one_value, no_gradient};

double test_opacity_of(double kappa)
{
    return 1 - exp(-kappa);
}

test_ray_scene *test_together_box(test_together *t, double lo, double hi, double kappa, const double rgb[3])
{
    test_ray_scene *s = test_together_add(t, test_field_cube(&test_form_one, 4, lo, hi, NULL));
    test_ray_scene_opacity(s, (const double[]){1, test_opacity_of(kappa)}, 1);
    test_ray_scene_color(s, (const double[]){1, rgb[0], rgb[1], rgb[2]}, 1);
    return s;
}
