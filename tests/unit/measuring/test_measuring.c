/* Rows of measurements, asked as a program in C asks them: what is found is what formulas say. */
#include "fail_alloc.h"
#include "fields.h"
#include "jobs.h"
#include "meshes.h"
#include "model/classes.h"

#include <jansson.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/about.h>
#include <volvis/compare.h>

#include <cmocka.h>

#define PI 3.14159265358979323846

static vv_measurement *question(const char *json)
{
    vv_object *o = NULL;
    if (vv_object_from_json(&o, &vvi_measurement_class, json, strlen(json), NULL) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return (vv_measurement *)(void *)o;
}

static vv_measured_data of_field(const vv_field *field)
{
    return (vv_measured_data){.name = "ball.nrrd", .field = field, .place = vv_affine_identity()};
}

static vv_status ask_of(vv_answer **out, const char *json, const vv_measured_inputs *inputs, vv_job *job)
{
    vv_measurement *q = question(json);
    const vv_status st = vv_measure_run(out, q, inputs, job);
    vv_object_release(&q->base);
    return st;
}

static vv_answer *answer_of(const char *json, const vv_field *field, vv_job *job)
{
    const vv_measured_data data = of_field(field);
    vv_answer *a = NULL;
    if (ask_of(&a, json, &(vv_measured_inputs){.size = sizeof(vv_measured_inputs), .input = &data, .n_inputs = 1},
               job) != VV_OK)
        fail_msg("%s: %s", json, vv_error_last()->message);
    return a;
}

static const vv_answer_item *figure(const vv_answer *a, const char *name)
{
    const vv_answer_item *item;
    for (size_t i = 0; (item = vv_answer_nth(a, i)); i++)
        if (item->kind == VV_ANSWER_FIGURE && strcmp(item->name, name) == 0)
            return item;
    fail_msg("there is no figure '%s'", name);
    return NULL;
}

static const vv_answer_table *table(const vv_answer *a)
{
    const vv_answer_item *item;
    for (size_t i = 0; (item = vv_answer_nth(a, i)); i++)
        if (item->kind == VV_ANSWER_TABLE)
            return item->table;
    fail_msg("there is no table");
    return NULL;
}

static void assert_figure(const vv_answer *a, const char *name, double expected, double tolerance, const char *unit)
{
    const vv_answer_item *f = figure(a, name);
    if (!(fabs(f->value - expected) <= tolerance))
        fail_msg("%s: %.9g is not within %g of %.9g", name, f->value, tolerance, expected);
    assert_string_equal(f->unit, unit);
}

/* A ball of radius 5 about (7, 8, 9), of values up to 0, half a voxel a sample. */
static vv_field *ball(void)
{
    vv_field *f = test_field_cube(&test_form_sphere, 33, 0, 16, NULL);
    assert_non_null(f);
    return f;
}

/* Rows ------------------------------------------------------------------------------------------------------------ */

static void each_kind_of_the_model_has_a_row_and_each_row_a_kind(void **state)
{
    (void)state;
    const char *const *names = vv_class_find(&vvi_measurement_class, "what")->names;
    vv_measurement *q = question("{}");
    size_t n = 0;
    for (; names[n]; n++) {
        q->what = (int)n;
        assert_string_equal(vv_measure_kind_of(q)->name, names[n]);
    }
    size_t n_rows = 0;
    while (vv_measure_kind_nth(n_rows))
        n_rows++;
    assert_int_equal(n, n_rows);
    assert_null(vv_measure_kind_find("stored"));
    vv_object_release(&q->base);
}

static void what_a_form_uses_are_properties_of_measurements(void **state)
{
    (void)state;
    for (size_t i = 0; vv_measure_kind_nth(i); i++)
        for (const vv_measure_form *form = vv_measure_kind_nth(i)->forms; form->run; form++) {
            char words[512], *rest;
            snprintf(words, sizeof words, "%s", form->uses);
            for (char *word = strtok_r(words, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
                if (!vv_class_find(&vvi_measurement_class, word))
                    fail_msg("%s uses '%s'", vv_measure_kind_nth(i)->name, word);
        }
}

static void the_form_follows_from_data_and_points(void **state)
{
    (void)state;
    const vv_measure_kind *distance = vv_measure_kind_find("distance");
    const vv_measure_form *points = vv_measure_form_of(distance, VV_MEASURED_VOLUME, 0, 2);
    const vv_measure_form *surface = vv_measure_form_of(distance, VV_MEASURED_VOLUME, 0, 1);
    assert_non_null(points);
    assert_non_null(surface);
    assert_ptr_not_equal(points, surface);
    assert_non_null(strstr(surface->uses, "iso"));
    assert_null(strstr(points->uses, "iso"));
    assert_non_null(vv_measure_form_of(distance, VV_MEASURED_MESH, VV_MEASURED_VOLUME, 0));
    assert_non_null(vv_measure_form_of(distance, VV_MEASURED_SHOWN, 0, 1));
    assert_null(vv_measure_form_of(distance, VV_MEASURED_SHOWN, VV_MEASURED_SHOWN, 0));
    assert_non_null(vv_measure_form_of(vv_measure_kind_find("angle"), VV_MEASURED_MESH, 0, 3));
    assert_null(vv_measure_form_of(vv_measure_kind_find("profile"), VV_MEASURED_MESH, 0, 2));
}

/* Answers --------------------------------------------------------------------------------------------------------- */

static void a_ball_has_its_area_volume_and_place(void **state)
{
    (void)state;
    vv_field *f = ball();
    vv_answer *a = answer_of("{\"what\": \"summary\", \"threshold_hi\": 0}", f, NULL);
    assert_figure(a, "area", 4 * PI * 25, 0.01 * 4 * PI * 25, "mm^2");
    assert_figure(a, "volume", 4 * PI / 3 * 125, 0.01 * 4 * PI / 3 * 125, "mm^3");
    assert_figure(a, "centroid_x", 7, 0.01, "mm");
    assert_figure(a, "centroid_y", 8, 0.01, "mm");
    assert_figure(a, "centroid_z", 9, 0.01, "mm");
    assert_true(fabs(figure(a, "volume")->value - 4 * PI / 3 * 125) <= 2 * figure(a, "volume")->error);
    assert_string_equal(vv_answer_object(a), "values of 0 or less");
    assert_string_equal(vv_answer_region(a), "");
    vv_answer_release(a);
    vv_field_release(f);
}

static void a_box_and_planes_leave_half_a_ball(void **state)
{
    (void)state;
    static const char *const halves[] = {
        "{\"what\": \"volume\", \"threshold_hi\": 0, \"box\": \"0..14,..,..\"}",
        "{\"what\": \"volume\", \"threshold_hi\": 0, \"cut_planes\": [{\"normal\": [-2, 0, 0], \"offset\": -7}]}"};
    vv_field *f = ball();
    for (size_t i = 0; i < 2; i++) {
        vv_answer *a = answer_of(halves[i], f, NULL);
        assert_figure(a, "volume", 2 * PI / 3 * 125, 0.01 * 2 * PI / 3 * 125, "mm^3");
        assert_string_not_equal(vv_answer_region(a), "");
        vv_answer_release(a);
    }
    vv_field_release(f);
}

static void what_the_scene_shows_is_the_object_unless_another_is_asked_for(void **state)
{
    (void)state;
    vv_field *f = ball();
    vv_measured_data data = of_field(f);
    const vv_measured_inputs inputs = {.size = sizeof inputs, .input = &data, .n_inputs = 1};
    vv_answer *a = NULL;
    data.ranged = true;
    data.lo = -INFINITY;
    data.hi = -1;
    assert_int_equal(ask_of(&a, "{\"what\": \"volume\"}", &inputs, NULL), VV_OK);
    assert_figure(a, "volume", 4 * PI / 3 * 64, 0.01 * 4 * PI / 3 * 64, "mm^3");
    assert_non_null(strstr(vv_answer_object(a), "as in the scene"));
    vv_answer_release(a);
    assert_int_equal(ask_of(&a, "{\"what\": \"volume\", \"threshold_hi\": 0}", &inputs, NULL), VV_OK);
    assert_figure(a, "volume", 4 * PI / 3 * 125, 0.01 * 4 * PI / 3 * 125, "mm^3");
    vv_answer_release(a);
    vv_field_release(f);
}

static void a_profile_of_a_ramp_is_the_ramp(void **state)
{
    (void)state;
    vv_field *f = test_field_cube(&test_form_ramp, 9, 0, 8, NULL);
    vv_answer *a = answer_of("{\"what\": \"profile\", \"points\": [[0, 1, 2], [8, 5, 2]], \"samples\": 17}", f, NULL);
    const vv_answer_table *t = table(a);
    assert_int_equal(t->n_rows, 17);
    assert_int_equal(t->n_columns, 6);
    for (size_t i = 0; i < t->n_rows; i++) {
        const vv_cell *row = t->cells + i * t->n_columns;
        const double at = (double)i / 16, x = 8 * at, y = 1 + 4 * at, z = 2;
        assert_true(fabs(row[0].number - at * sqrt(80)) < 1e-9);
        assert_true(fabs(row[1].number - x) < 1e-9 && fabs(row[2].number - y) < 1e-9 && row[3].number == z);
        assert_true(fabs(row[4].number - (3 + 2 * x - y + 0.5 * z)) < 1e-5);
    }
    assert_figure(a, "length", sqrt(80), 1e-9, "mm");
    vv_answer_release(a);
    vv_field_release(f);
}

static void a_place_has_the_value_that_is_there(void **state)
{
    (void)state;
    vv_field *f = test_field_cube(&test_form_ramp, 9, 0, 8, NULL);
    vv_answer *a = answer_of("{\"what\": \"point\", \"points\": [[1.25, 2.5, 3]]}", f, NULL);
    assert_figure(a, "value", 3 + 2 * 1.25 - 2.5 + 0.5 * 3, 1e-5, "");
    vv_answer_release(a);
    a = answer_of("{\"what\": \"point\", \"points\": [[-3, 0, 0]]}", f, NULL);
    assert_true(isnan(figure(a, "value")->value));
    assert_non_null(vv_answer_note(a, 0));
    vv_answer_release(a);
    vv_field_release(f);
}

/* Of a right angle, of what goes back the way it came, and of places that are one: errors of places add up as their
 * moves along the line do. */
static void the_length_along_several_places_is_the_sum(void **state)
{
    (void)state;
    vv_field *f = ball();
    const double place = 0.5 / sqrt(12);
    vv_answer *a = answer_of("{\"what\": \"distance\", \"points\": [[0, 0, 0], [6, 0, 0], [6, 8, 0]]}", f, NULL);
    assert_figure(a, "distance", 7, 1e-9, "mm");
    assert_true(fabs(figure(a, "distance")->error - sqrt(1 + 2 + 1) * place) < 1e-9);
    vv_answer_release(a);
    a = answer_of("{\"what\": \"distance\", \"points\": [[0, 0, 0], [6, 0, 0], [0, 0, 0], [0, 0, 0]]}", f, NULL);
    assert_figure(a, "distance", 6, 1e-9, "mm");
    vv_answer_release(a);
    vv_field_release(f);
}

static void distances_and_angles_are_those_of_the_places(void **state)
{
    (void)state;
    vv_field *f = ball();
    vv_answer *a =
        answer_of("{\"what\": \"distance\", \"points\": [[0, 0, 0], [3, 4, 12]], \"space\": \"world\"}", f, NULL);
    assert_figure(a, "distance", 13, 1e-9, "mm");
    vv_answer_release(a);
    a = answer_of("{\"what\": \"distance\", \"points\": [[0, 0, 0], [6, 8, 24]]}", f, NULL); /* samples of a half */
    assert_figure(a, "distance", 13, 1e-9, "mm");
    vv_answer_release(a);
    a = answer_of("{\"what\": \"angle\", \"points\": [[5, 1, 1], [1, 1, 1], [3, 3, 1]]}", f, NULL);
    assert_figure(a, "angle", 45, 1e-9, "deg");
    vv_answer_release(a);
    a = answer_of("{\"what\": \"distance\", \"iso\": 0, \"points\": [[7, 8, 2]], \"space\": \"world\"}", f, NULL);
    assert_figure(a, "distance", 2, 0.02, "mm"); /* to the ball's surface */
    vv_answer_release(a);
    vv_field_release(f);
}

static void shells_are_as_far_apart_as_their_radii(void **state)
{
    (void)state;
    vv_field *f = ball();
    const vv_measured_data data = of_field(f);
    const vv_measured_inputs inputs = {.size = sizeof inputs, .input = &data, .n_inputs = 1, .other = &data};
    vv_answer *a = NULL;
    assert_int_equal(ask_of(&a, "{\"what\": \"distance\", \"iso\": 0, \"other_iso\": 1}", &inputs, NULL), VV_OK);
    assert_figure(a, "distance", 1, 0.05, "mm");
    assert_figure(a, "a_to_b_mean", 1, 0.02, "mm");
    assert_figure(a, "b_to_a_rms", 1, 0.02, "mm");
    assert_non_null(strstr(vv_answer_object(a), "values of 0 or more and values of 1 or more"));
    vv_answer_release(a);
    vv_field_release(f);
}

static void bins_hold_every_sample(void **state)
{
    (void)state;
    vv_field *f = ball();
    vv_answer *a = answer_of("{\"what\": \"histogram\", \"bins\": 7, \"range\": [[-2, 5]]}", f, NULL);
    const vv_answer_table *t = table(a);
    uint64_t sum = 0;
    assert_int_equal(t->n_rows, 9); /* below, seven, above */
    for (size_t i = 0; i < t->n_rows; i++) {
        sum += t->cells[i * 4 + 2].count;
        assert_int_equal(t->cells[i * 4 + 3].count, sum);
        assert_true(t->cells[i * 4].number == (i ? -3 + (double)i : -INFINITY));
    }
    assert_int_equal(sum, 33 * 33 * 33);
    assert_figure(a, "count", 33 * 33 * 33, 0, "");
    vv_answer_release(a);
    vv_field_release(f);
}

/* A box of 3 x 4 x 5 voxels of label 7 in zeros. */
static double block(vv_vec3 p)
{
    return p.x >= 2 && p.x < 5 && p.y >= 3 && p.y < 7 && p.z >= 1 && p.z < 6 ? 7 : 0;
}

static vv_field *labels(void)
{
    const test_form form = {.name = "block", .value = block};
    vv_field_info info = vv_field_info_default();
    info.grid = test_cube(10, 0, 9);
    info.type = VV_TYPE_U8;
    info.meaning = VV_MEANING_LABEL;
    return test_field(&form, &info, NULL);
}

static void a_label_is_a_row_with_its_name(void **state)
{
    (void)state;
    vv_field *f = labels();
    vv_measured_data data = of_field(f);
    const vv_label names[] = {{.value = 7, .name = "a \"block\""}};
    data.labels = names;
    data.n_labels = 1;
    const vv_measured_inputs inputs = {.size = sizeof inputs, .input = &data, .n_inputs = 1, .values = &data};
    vv_answer *a = NULL;
    char *json = NULL;
    assert_int_equal(ask_of(&a, "{\"what\": \"labels\", \"values\": \"ball.nrrd\"}", &inputs, NULL), VV_OK);
    assert_int_equal(vv_answer_json(&json, a), VV_OK);
    json_t *all = json_loads(json, 0, NULL), *row = json_array_get(json_object_get(all, "labels"), 0);
    assert_int_equal(json_array_size(json_object_get(all, "labels")), 1);
    assert_int_equal(json_integer_value(json_object_get(row, "label")), 7);
    assert_int_equal(json_integer_value(json_object_get(row, "count")), 60);
    assert_string_equal(json_string_value(json_object_get(row, "name")), names[0].name);
    assert_true(json_number_value(json_object_get(row, "volume")) == 60);
    assert_true(json_number_value(json_object_get(row, "mean")) == 7);
    static const double middle[] = {3, 4.5, 3};
    for (size_t i = 0; i < 3; i++)
        assert_true(json_number_value(json_array_get(json_object_get(row, "centroid"), i)) == middle[i]);
    json_decref(all);
    free(json);
    vv_answer_release(a);
    vv_field_release(f);
}

static void json_has_the_figures_and_scenes_read_them_back(void **state)
{
    (void)state;
    vv_field *f = ball();
    vv_answer *a = answer_of("{\"what\": \"area\", \"threshold_hi\": 0}", f, NULL);
    char *json = NULL, *figures = NULL;
    assert_int_equal(vv_answer_json(&json, a), VV_OK);
    json_t *all = json_loads(json, 0, NULL);
    assert_true(json_number_value(json_object_get(all, "area")) == figure(a, "area")->value);
    assert_true(json_number_value(json_object_get(all, "area_error")) == figure(a, "area")->error);
    assert_string_equal(json_string_value(json_object_get(all, "area_unit")), "mm^2");
    assert_int_equal(vv_answer_figures(&figures, a), VV_OK);
    vv_object *kept = &question("{}")->base;
    assert_int_equal(vv_path_set(&kept, "figures", figures, NULL), VV_OK);
    const vv_collection *list = ((const vv_measurement *)(const void *)kept)->figures;
    const vv_measured_figure *first = (const vv_measured_figure *)(const void *)list->entry[0].object;
    assert_string_equal(first->name, "area");
    assert_true(first->value == figure(a, "area")->value && first->error == figure(a, "area")->error);
    json_decref(all);
    free(json);
    free(figures);
    vv_object_release(kept);
    vv_answer_release(a);
    vv_field_release(f);
}

static void threads_change_no_answer(void **state)
{
    (void)state;
    static const char *const asked[] = {"{\"what\": \"summary\"}", "{\"what\": \"joint\"}", "{\"what\": \"labels\"}"};
    vv_field *fields[] = {ball(), ball(), labels()};
    for (size_t i = 0; i < 3; i++) {
        char *json[2] = {NULL, NULL};
        for (int t = 0; t < 2; t++) {
            vv_job *job = test_job(t ? 3 : 1, 0);
            vv_answer *a = answer_of(asked[i], fields[i], job);
            assert_int_equal(vv_answer_json(&json[t], a), VV_OK);
            vv_answer_release(a);
            vv_job_release(job);
        }
        assert_string_equal(json[0], json[1]);
        free(json[0]);
        free(json[1]);
        vv_field_release(fields[i]);
    }
}

/* What goes wrong ------------------------------------------------------------------------------------------------- */

static void assert_refused(const char *json, const vv_measured_inputs *inputs, const char *why)
{
    vv_answer *a = NULL;
    assert_int_equal(ask_of(&a, json, inputs, NULL), VV_E_ARGUMENT);
    if (!strstr(vv_error_last()->message, why))
        fail_msg("'%s' does not say '%s'", vv_error_last()->message, why);
    vv_answer_release(a);
}

static void questions_that_make_no_sense_are_refused_in_words(void **state)
{
    (void)state;
    vv_field *f = ball();
    vv_mesh *mesh = test_mesh_strip(5, 0);
    const vv_measured_data volume = of_field(f), strip = {.name = "a.ply", .mesh = mesh};
    const vv_measured_inputs nothing = {.size = sizeof nothing};
    const vv_measured_inputs of_mesh = {.size = sizeof of_mesh, .input = &strip, .n_inputs = 1};
    const vv_measured_inputs of_volume = {.size = sizeof of_volume, .input = &volume, .n_inputs = 1};
    assert_refused("{\"what\": \"area\"}", &nothing, "nothing to measure");
    assert_refused("{\"what\": \"histogram\"}", &of_mesh,
                   "a.ply is a mesh, which has area, volume, box, distance, angle and geodesic; no histogram");
    assert_refused("{\"what\": \"area\", \"iso\": 1, \"label\": 2}", &of_volume, "give one of them");
    assert_refused("{\"what\": \"area\", \"mask\": \"m.nrrd\"}", &of_volume, "mask");
    assert_refused("{\"what\": \"labels\", \"values\": \"v.nrrd\"}", &of_volume, "real numbers");
    assert_refused("{\"what\": \"area\", \"box\": \"1..2\"}", &of_volume, "--box");
    assert_refused("{\"what\": \"area\", \"seed\": [99, 0, 0]}", &of_volume, "99,0,0 is outside");
    assert_refused("{\"what\": \"angle\", \"points\": [[1, 2, 3]]}", &of_volume, "three times; there are 1");
    assert_refused("{\"what\": \"area\", \"component\": 3}", &of_volume, "");
    assert_refused("{\"what\": \"labels\", \"seed\": [1, 1, 1]}", &of_volume, "'seed' has no effect on the labels of");
    assert_refused(
        "{\"what\": \"labels\", \"region\": {\"kind\": \"ellipse\", \"center\": [1, 1, 1], \"size\": [2, 2, 0]}}",
        &of_volume, "'region' has no effect");
    assert_refused("{\"what\": \"area\", \"seed\": [1, 1, 1]}", &of_mesh,
                   "'seed' has no effect on the area of a.ply, a mesh");
    vv_mesh_release(mesh);
    vv_field_release(f);
}

typedef struct asked {
    const char *json;
    const vv_field *field;
} asked;

static vv_status ask_once(void *user)
{
    const asked *q = user;
    const vv_measured_data data = of_field(q->field);
    vv_object *o = NULL;
    vv_answer *a = NULL;
    char *json = NULL;
    vv_status st = vv_object_from_json(&o, &vvi_measurement_class, q->json, strlen(q->json), NULL);
    if (st == VV_OK)
        st = vv_measure_run(&a, (const vv_measurement *)(const void *)o,
                            &(vv_measured_inputs){.size = sizeof(vv_measured_inputs), .input = &data, .n_inputs = 1},
                            NULL);
    if (st == VV_OK)
        st = vv_answer_json(&json, a);
    free(json);
    vv_answer_release(a);
    vv_object_release(o);
    return st;
}

static void without_memory_every_kind_fails_in_words(void **state)
{
    (void)state;
    vv_field *values = test_field_cube(&test_form_sphere, 9, 0, 16, NULL), *l = labels();
    const asked all[] = {{"{\"what\": \"summary\"}", values},
                         {"{\"what\": \"histogram\", \"bins\": 4}", values},
                         {"{\"what\": \"joint\", \"bins\": 4}", values},
                         {"{\"what\": \"profile\", \"points\": [[0, 0, 0], [8, 8, 8]], \"samples\": 5}", values},
                         {"{\"what\": \"labels\"}", l}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        assert_true(test_fail_each_alloc(ask_once, (void *)(uintptr_t)&all[i]) > 10);
    vv_field_release(values);
    vv_field_release(l);
}

/* The item of that key; of a number its value. */
static double number(const vv_answer *a, const char *key)
{
    const vv_answer_item *item;
    for (size_t i = 0; (item = vv_answer_nth(a, i)); i++)
        if (item->key && strcmp(item->key, key) == 0)
            return item->kind == VV_ANSWER_NUMBER ? item->value : (double)item->count;
    fail_msg("there is no '%s'", key);
    return NAN;
}

/* A ramp, and the same half a unit higher: 3 + 2 x - y + 0.5 z over [0, 6]^3 goes from -3 to 18. */
static void what_is_half_a_unit_higher_differs_by_that(void **state)
{
    vv_field *a = test_field_cube(&test_form_ramp, 7, 0, 6, NULL), *b = NULL;
    vv_field_info info = *vv_field_get_info(a);
    vv_compare_limits limits;
    vv_answer *answer;
    bool exceeded;
    info.value_offset = 0.5;
    const vv_box all = vv_field_box(a);
    vv_brick brick;
    assert_int_equal(vv_field_brick(&brick, a, &all, NULL), VV_OK);
    assert_int_equal(vv_field_new(&b, &info, brick.data, 0, NULL, NULL, NULL), VV_OK);
    vv_compare_limits_init(&limits, sizeof limits);
    limits.max_difference = 0.5;
    assert_int_equal(vv_compare_fields(&answer, &exceeded, a, b, &limits, NULL), VV_OK);
    assert_true(fabs(number(answer, "max_difference") - 0.5) < 1e-12 && fabs(number(answer, "rms") - 0.5) < 1e-12);
    assert_true(fabs(number(answer, "psnr") - 20 * log10(21 / 0.5)) < 1e-9);
    assert_true(number(answer, "different_samples") == 343 && number(answer, "identical") == 0 && !exceeded);
    vv_answer_release(answer);
    limits.max_difference = 0.499;
    assert_int_equal(vv_compare_fields(&answer, &exceeded, a, b, &limits, NULL), VV_OK);
    assert_true(exceeded && number(answer, "differs") == 1);
    vv_answer_release(answer);
    assert_int_equal(vv_compare_fields(&answer, &exceeded, a, a, NULL, NULL), VV_OK);
    assert_true(!exceeded && number(answer, "identical") == 1 && isinf(number(answer, "psnr")));
    vv_answer_release(answer);
    vv_brick_release(&brick);
    vv_field_release(b);
    vv_field_release(a);
    (void)state;
}

static const char *line(const vv_answer *a, const char *label)
{
    const vv_answer_item *item;
    for (size_t i = 0; (item = vv_answer_nth(a, i)); i++)
        if (item->kind == VV_ANSWER_LINE && strcmp(item->label, label) == 0)
            return item->text;
    fail_msg("there is no line '%s'", label);
    return NULL;
}

/* Steps of half a unit along x, turned by a right angle about z. */
static void a_header_says_where_its_samples_lie(void **state)
{
    vv_field_info info = vv_field_info_default();
    vv_answer *answer;
    char *json;
    info.grid.dims[0] = 4;
    info.grid.dims[1] = 5;
    info.grid.dims[2] = 6;
    info.type = VV_TYPE_I16;
    info.grid.index_to_world.axis[0] = (vv_vec3){0, 0.5, 0};
    info.grid.index_to_world.axis[1] = (vv_vec3){-2, 0, 0};
    assert_int_equal(vv_about_samples(&answer, &info), VV_OK);
    assert_true(number(answer, "memory_bytes") == 4 * 5 * 6 * 2 && number(answer, "components") == 1);
    assert_string_equal(line(answer, "samples"), "4 x 5 x 6 i16, scalar");
    assert_int_equal(vv_answer_json(&json, answer), VV_OK);
    assert_non_null(strstr(json, "\"spacing\": [0.5, 2, 1]"));
    assert_non_null(strstr(json, "[-1, 0, 0]"));
    free(json);
    vv_answer_release(answer);
    (void)state;
}

static void a_mesh_and_a_world_say_what_they_are(void **state)
{
    vv_mesh *mesh = test_mesh_strip(5, 0);
    vv_object *world = NULL;
    vv_answer *answer;
    assert_int_equal(vv_about_mesh(&answer, mesh, NULL), VV_OK);
    assert_true(number(answer, "closed") == 0 && number(answer, "pieces") == 1 && isnan(number(answer, "volume")));
    assert_true(fabs(number(answer, "area") - test_mesh_area(mesh)) < 1e-5);
    vv_answer_release(answer);
    vv_mesh_release(mesh);
    assert_int_equal(vv_object_new(&world, &vv_world_class, NULL), VV_OK);
    assert_int_equal(vv_path_add(&world, "lights", "key", NULL, NULL), VV_OK);
    assert_int_equal(vv_about_world(&answer, (const vv_world *)(const void *)world), VV_OK);
    assert_string_equal(line(answer, "lights"), "key");
    assert_string_equal(line(answer, "volumes"), "none");
    vv_answer_release(answer);
    vv_object_release(world);
    (void)state;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_kind_of_the_model_has_a_row_and_each_row_a_kind),
        cmocka_unit_test(what_a_form_uses_are_properties_of_measurements),
        cmocka_unit_test(the_form_follows_from_data_and_points),
        cmocka_unit_test(a_ball_has_its_area_volume_and_place),
        cmocka_unit_test(a_box_and_planes_leave_half_a_ball),
        cmocka_unit_test(what_the_scene_shows_is_the_object_unless_another_is_asked_for),
        cmocka_unit_test(a_profile_of_a_ramp_is_the_ramp),
        cmocka_unit_test(a_place_has_the_value_that_is_there),
        cmocka_unit_test(the_length_along_several_places_is_the_sum),
        cmocka_unit_test(distances_and_angles_are_those_of_the_places),
        cmocka_unit_test(shells_are_as_far_apart_as_their_radii),
        cmocka_unit_test(bins_hold_every_sample),
        cmocka_unit_test(a_label_is_a_row_with_its_name),
        cmocka_unit_test(json_has_the_figures_and_scenes_read_them_back),
        cmocka_unit_test(threads_change_no_answer),
        cmocka_unit_test(questions_that_make_no_sense_are_refused_in_words),
        cmocka_unit_test(without_memory_every_kind_fails_in_words),
        cmocka_unit_test(what_is_half_a_unit_higher_differs_by_that),
        cmocka_unit_test(a_header_says_where_its_samples_lie),
        cmocka_unit_test(a_mesh_and_a_world_say_what_they_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
