/* The worked example of docs/adding-a-renderer.md does what the page says. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
/* cmocka wants those first */
#include "renderer_film.h"
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/volvis.h>

static const vv_renderer *const renderers[] = {&renderer_film, NULL};

static vv_job *job_with_film(int threads)
{
    const vv_registry mine = {.renderers = renderers};
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.more = &mine;
    options.threads = threads;
    vv_runtime *runtime;
    vv_job *job;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    vv_runtime_release(runtime);
    return job;
}

/* A cube of edge 8 that grows from 0 (z = 0) to 1 (z = 8), seen from above by parallel rays: the film's formula is
 * known. The depth of a ray down the middle is strength / diagonal * 8 / 2. */
static vv_image *film_of_a_ramp(int threads, const char *strength)
{
    static float samples[9 * 9 * 9];
    for (int i = 0; i < 9 * 9 * 9; i++)
        samples[i] = (float)(i / 81) / 8.0f;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    memcpy(info.grid.dims, (int64_t[3]){9, 9, 9}, sizeof info.grid.dims);
    vv_job *job = job_with_film(threads);
    vv_runtime *runtime = vv_job_runtime(job);
    vv_field *field;
    vv_world *world;
    vv_model *model;
    vv_image *image;
    char settings[256];
    snprintf(
        settings, sizeof settings,
        "{\"projection\": \"parallel\", \"height\": 16, \"eye\": [4, 4, 20], \"at\": [4, 4, 4], \"up\": [0, 1, 0]}");
    assert_int_equal(vv_field_new(&field, &info, samples, 0, NULL, NULL, job), VV_OK);
    assert_int_equal(vv_world_for_field(&world, "ramp", field, job), VV_OK);
    assert_int_equal(vv_model_new(&model, runtime), VV_OK);
    assert_int_equal(vv_model_replace(model, NULL, world), VV_OK);
    vv_object_release((vv_object *)world);
    assert_int_equal(vv_model_set(model, NULL, "background", "[0, 0, 0, 0]"), VV_OK);
    assert_int_equal(vv_model_set(model, NULL, "views.main.width", "17"), VV_OK);
    assert_int_equal(vv_model_set(model, NULL, "views.main.height", "17"), VV_OK);
    assert_int_equal(vv_model_set(model, NULL, "views.main.camera", settings), VV_OK);
    assert_int_equal(vv_model_set(model, NULL, "views.main.render.method", "film"), VV_OK);
    assert_int_equal(vv_model_set(model, NULL, "views.main.render.film.strength", strength), VV_OK);
    world = vv_model_snapshot(model);
    assert_int_equal(vv_render(&image, NULL, world, "main", NULL, job), VV_OK);
    vv_object_release((vv_object *)world);
    vv_model_release(model);
    vv_field_release(field);
    vv_job_release(job);
    return image;
}

static void the_film_of_a_ramp_is_its_closed_form(void **state)
{
    vv_image *image = film_of_a_ramp(1, "5");
    const double expected = 1 - exp(-5 / (8 * sqrt(3)) * 4);
    const float *middle = image->rgba + 4 * (8 * 17 + 8), *corner = image->rgba;
    assert_true(fabs(middle[0] - expected) < 1e-5);
    assert_true(middle[3] == middle[0]);
    assert_true(corner[0] == 0 && corner[3] == 0);
    vv_image_release(image);
}

static void the_film_is_the_same_for_any_number_of_threads(void **state)
{
    vv_image *one = film_of_a_ramp(1, "2"), *three = film_of_a_ramp(3, "2");
    assert_memory_equal(one->rgba, three->rgba, 17 * 17 * 4 * sizeof(float));
    vv_image_release(one);
    vv_image_release(three);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_film_of_a_ramp_is_its_closed_form),
        cmocka_unit_test(the_film_is_the_same_for_any_number_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
