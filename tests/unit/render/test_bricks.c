/* Samples in bricks: pictures equal to the bit to those of the same samples in one array, whatever is drawn, by every
 * build and any number of threads; what is not seen is not brought; and what does not fit is brought again. */
#include "core/cpu.h"
#include "core/job.h"
#include "fields.h"
#include "grid/bricks.h"
#include "grid/lazy.h"
#include "ray_scene.h"
#include "registry.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void set(test_ray_scene *s, const char *path, const char *json)
{
    vv_object *params = &s->params->base;
    assert_int_equal(vv_path_set(&params, path, json, NULL), VV_OK);
    s->params = (vvi_raycast_params *)params;
    s->scene.params = params;
}

/* A field of the same samples that are made when they are asked for. */
static vv_status make_box(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    const vv_field *from = user;
    vv_field_info info = *vv_field_get_info(from);
    vv_brick brick;
    void *data;
    info.grid = vv_grid_crop(&info.grid, box);
    const vv_status st = vv_field_new_empty(out, &data, &info, job);
    if (st != VV_OK)
        return st;
    assert_int_equal(vv_field_brick(&brick, from, box, NULL), VV_OK);
    const size_t row = (size_t)box->n[0] * vv_type_bytes(info.type) * (size_t)info.components;
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            memcpy((char *)data + (size_t)(k * box->n[1] + j) * row,
                   (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2], row);
    vv_brick_release(&brick);
    return VV_OK;
}

static vv_field *on_request(const vv_field *field)
{
    vvi_lazy_pool *pool;
    vv_field *out;
    const vvi_lazy_source source = {.make = make_box, .user = (void *)(uintptr_t)field};
    assert_int_equal(vvi_lazy_pool_new(&pool, 1 << 16, 0, NULL), VV_OK);
    assert_int_equal(vvi_field_lazy(&out, vv_field_get_info(field), &source, pool, NULL), VV_OK);
    vvi_lazy_pool_release(pool);
    return out;
}

static vv_field *random_field(vv_type type, const int64_t dims[3])
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    memcpy(info.grid.dims, dims, sizeof info.grid.dims);
    info.grid.index_to_world.axis[0] = (vv_vec3){-1.1, 0.1, 0};
    info.grid.index_to_world.axis[1] = (vv_vec3){0.2, 0.9, 0.1};
    info.grid.index_to_world.axis[2] = (vv_vec3){0, -0.3, 1.4};
    vv_field *field = test_field_random(&info, test_seed(), NULL);
    assert_non_null(field);
    return field;
}

/* Ramps and jumps, seen from aside; light and cuts, so that gradients count, at the border too. */
static void look(test_ray_scene *s, const vv_field *field, const char *mode, bool lit)
{
    const vv_bounds b = vv_grid_bounds(&vv_field_get_info(field)->grid);
    const vv_vec3 at = vvi_scaled(vvi_add(b.lo, b.hi), 0.5), from = {0.6, -0.5, 0.4};
    const double size = vvi_length(vvi_sub(b.hi, b.lo)) + 2;
    test_ray_scene_init(s, field, 10);
    s->scene.width = 37;
    s->scene.height = s->scene.rows = 35;
    test_ray_scene_look(s, vvi_add(at, vvi_scaled(from, 2 * size)), at, 0.5, size);
    const double lo = s->statistics.min, w = s->statistics.max - lo;
    test_ray_scene_opacity(s, (const double[]){lo, 0, lo + 0.3 * w, 0, lo + 0.5 * w, 0.1, lo + 0.9 * w, 0.02}, 4);
    test_ray_scene_color(s, (const double[]){lo, 0.1, 0.9, 0.2, lo + 0.5 * w, 0.9, 0.3, 0.1, lo + w, 0.2, 0.3, 1}, 3);
    s->actor.iso = lo + 0.7 * w;
    set(s, "mode", mode);
    set(s, "step", "0.6");
    if (!lit)
        return;
    test_ray_scene_light(s);
    s->actor.n_planes = 1;
    s->planes[0] = (vv_plane){{0.6, 0, 0.8}, vvi_dot((vv_vec3){0.6, 0, 0.8}, at) - 1};
}

static void assert_same(const vv_image *a, const vv_image *b, const char *what)
{
    const size_t n = (size_t)a->width * (size_t)a->height;
    if (memcmp(a->rgba, b->rgba, 4 * n * sizeof(float)) != 0 || memcmp(a->depth, b->depth, n * sizeof(float)) != 0)
        fail_msg("%s: bricks make another picture", what);
}

static const char *const modes[] = {"composite", "maximum", "minimum", "mean", "sum", "local-maximum", "isosurface"};
enum { MODES = sizeof modes / sizeof *modes };
/* What only the general kernel draws is the same loop with other classifications. */
static const char *const variants[][2] = {
    {"gradient", "central"}, {"gradient", "cell"}, {"preintegrated", "true"}, {"lighting", "cinematic"}};

/* One picture of the array; of the bricks, one by each of two numbers of threads. */
static void compare(const vv_field *field, const vv_field *bricks, const char *mode, int lit, int nearest, int variant,
                    const char *cpu, const char *name)
{
    static const int threads[] = {1, 1, 2, 3};
    vv_image *image[3];
    char what[128];
    snprintf(what, sizeof what, "%s, %s%s%s, %s %s, %s", name, mode, lit ? ", lit" : "", nearest ? ", nearest" : "",
             variants[variant][0], variants[variant][1], cpu);
    for (int i = 0; i < 3; i++) {
        test_ray_scene s;
        look(&s, i ? bricks : field, mode, lit);
        s.actor.nearest = nearest;
        if (nearest == 0 || strcmp(variants[variant][0], "gradient") == 0)
            set(&s, variants[variant][0], variants[variant][1]);
        image[i] = test_ray_picture(&s, cpu, threads[i < 2 ? i : 2 + lit]);
        test_ray_scene_finish(&s);
        assert_same(image[0], image[i], what);
    }
    for (int i = 0; i < 3; i++)
        vv_image_release(image[i]);
}

static void compare_modes(const vv_field *field, const vv_field *bricks, size_t turn, const char *cpu, const char *name)
{
    const int variant = (int)(turn % 4), nearest = (int)(turn / 2 % 2);
    compare(field, bricks, "composite", true, 0, variant, cpu, name);
    compare(field, bricks, "composite", turn % 3 == 0, 1 - nearest, (variant + 1) % 4, cpu, name);
    compare(field, bricks, "isosurface", true, nearest, variant % 2, cpu, name);
    compare(field, bricks, modes[1 + turn % 5], false, nearest, 0, cpu, name);
}

static void pictures_are_equal_to_the_bit(void **state)
{
    static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_U16, VV_TYPE_I16, VV_TYPE_F32, VV_TYPE_I8, VV_TYPE_F64};
    static const int64_t sizes[][3] = {{67, 37, 41}, {1, 1, 1}, {1, 67, 34}, {33, 1, 3}, {32, 65, 2}, {31, 32, 33}};
    size_t turn = 0;
    (void)state;
    for (size_t t = 0; t < sizeof types / sizeof *types; t++)
        for (size_t z = 0; z < sizeof sizes / sizeof *sizes; z++) {
            vv_field *field = random_field(types[t], sizes[z]), *bricks = on_request(field);
            char name[64];
            snprintf(name, sizeof name, "%s %lldx%lldx%lld", vv_type_name(types[t]), (long long)sizes[z][0],
                     (long long)sizes[z][1], (long long)sizes[z][2]);
            for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
                compare_modes(field, bricks, turn++, *cpu, name);
            vv_field_release(bricks);
            vv_field_release(field);
        }
}

/* All that the loop can do, of one field. */
static void every_mode_is_equal_to_the_bit(void **state)
{
    const int64_t dims[3] = {67, 37, 41};
    vv_field *field = random_field(VV_TYPE_U8, dims), *bricks = on_request(field);
    const char *cpu = *test_ray_cpus();
    (void)state;
    for (int mode = 0; mode < MODES; mode++)
        for (int nearest = 0; nearest < 2; nearest++)
            compare(field, bricks, modes[mode], 0, nearest, 0, cpu, "u8");
    for (int variant = 0; variant < 4; variant++)
        compare(field, bricks, "composite", 1, 0, variant, cpu, "u8");
    vv_field_release(bricks);
    vv_field_release(field);
}

/* Splines: coefficients in bricks -------------------------------------------------------------------------------------
 */

static vv_status fill_numbers(char *to, size_t row, size_t slice, void *user, const vv_box *box, vv_job *job)
{
    const vvi_lattice *g = user;
    (void)job;
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            memcpy(to + (size_t)j * row + (size_t)k * slice,
                   (const float *)g->data + (box->lo[2] + k) * g->slice + (box->lo[1] + j) * g->row + box->lo[0],
                   (size_t)box->n[0] * sizeof(float));
    return VV_OK;
}

static void drop_nothing(void *user)
{
    (void)user;
}

static vv_image *cubic_picture(const test_ray_scene *s, const char *cpu, bool in_bricks)
{
    const vv_tile all = {0, 0, s->scene.width, s->scene.height};
    const vv_pass centres = {.x = 0.5, .y = 0.5, .stride = 1};
    vv_render_counts counts = {0};
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_job *job;
    vv_image *image;
    void *prepared;
    vvi_bricks *bricks = NULL;
    vv_runtime_options_init(&options, sizeof options);
    options.cpu = cpu;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    assert_int_equal(vv_image_new(&image, s->scene.width, s->scene.height, VV_LAYER_DEPTH, job), VV_OK);
    assert_int_equal(vvi_raycast_prepare(&prepared, &s->scene, job), VV_OK);
    vvi_raycast_state *state = prepared;
    vvi_lattice *g = &state->volume[0].ray.sampler.lattice;
    const vvi_lattice array = *g;
    if (in_bricks) {
        const int64_t dims[3] = {g->n[0], g->n[1], g->n[2]};
        const vvi_brick_source source = {fill_numbers, drop_nothing, (void *)(uintptr_t)&array};
        assert_int_equal(vvi_bricks_new(&bricks, dims, sizeof(float), &source, job), VV_OK);
        g->data = bricks->data;
        g->fetch = VVI_FETCH_BRICKS;
        g->bricks = bricks;
        g->row = bricks->side[0];
        g->slice = (int64_t)bricks->side[0] * bricks->side[1];
        state->blend.volume[0].sampler.lattice = *g;
        state->bricks[state->n_bricks++] = bricks;
    }
    assert_int_equal(vvi_renderer_raycast.render(state, &centres, &all, image, &counts, job), VV_OK);
    vvi_raycast_finish(state);
    vvi_bricks_free(bricks);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return image;
}

static void splines_are_equal_to_the_bit(void **state)
{
    static const int64_t sizes[][3] = {{67, 37, 41}, {33, 64, 2}, {1, 5, 34}, {31, 32, 33}};
    (void)state;
    for (size_t z = 0; z < sizeof sizes / sizeof *sizes; z++)
        for (int iso = 0; iso < 2; iso++) {
            vv_field *field = random_field(VV_TYPE_U8, sizes[z]);
            test_ray_scene s;
            look(&s, field, iso ? "isosurface" : "composite", true);
            s.actor.cubic = true;
            for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
                vv_image *a = cubic_picture(&s, *cpu, false), *b = cubic_picture(&s, *cpu, true);
                assert_same(a, b, *cpu);
                vv_image_release(a);
                vv_image_release(b);
            }
            test_ray_scene_finish(&s);
            vv_field_release(field);
        }
}

/* What is there -------------------------------------------------------------------------------------------------------
 */

static vv_status fill_and_count(char *to, size_t row, size_t slice, void *user, const vv_box *box, vv_job *job)
{
    (void)job;
    atomic_fetch_add((atomic_int *)user, 1);
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            for (int64_t i = 0; i < box->n[0]; i++)
                to[(size_t)i + (size_t)j * row + (size_t)k * slice] = box->lo[0] + i < 48 ? 7 : (char)(i + j + k);
    return VV_OK;
}

static void bricks_of_one_value_take_one_place(void **state)
{
    (void)state;
    atomic_int fills = 0;
    const vvi_brick_source source = {fill_and_count, drop_nothing, &fills};
    vvi_bricks *bricks;
    size_t there, places;
    bool lacking;
    assert_int_equal(vvi_bricks_new(&bricks, (const int64_t[3]){163, 99, 99}, 1, &source, NULL), VV_OK);
    assert_int_equal(bricks->n[0], 6);
    vvi_bricks_enter(&bricks, 1, false, NULL);
    for (int twice = 0; twice < 2; twice++)
        for (int32_t b = 0; b < 6 * 4 * 4; b++) {
            const int32_t page = vvi_bricks_bring(bricks, b);
            assert_true(page > 0 && bricks->page[b] == page);
        }
    assert_int_equal(vvi_bricks_leave(&lacking, &bricks, 1), VV_OK);
    assert_false(lacking);
    vvi_bricks_count(&there, &places, bricks);
    assert_int_equal(fills, 96); /* none was brought twice */
    assert_int_equal(there, 96);
    assert_int_equal(places, 96 - 16 + 1); /* samples 0 to 33 of the first 16 are 7 */
    vvi_bricks_enter(&bricks, 1, true, NULL);
    assert_int_equal(vvi_bricks_leave(&lacking, &bricks, 1), VV_OK);
    vvi_bricks_count(&there, &places, bricks);
    assert_true(there == 0 && places == 0);
    vvi_bricks_free(bricks);
}

static void what_is_not_seen_is_not_brought(void **state)
{
    (void)state;
    const int64_t dims[3] = {200, 200, 200};
    vv_field *field = random_field(VV_TYPE_U8, dims), *lazy = on_request(field);
    test_ray_scene s;
    vv_runtime *runtime;
    vv_job *job;
    void *prepared;
    size_t there, places;
    vv_image *image;
    vv_render_counts counts = {0};
    const vv_tile all = {0, 0, 37, 35};
    const vv_pass centres = {.x = 0.5, .y = 0.5, .stride = 1};
    look(&s, lazy, "isosurface", true); /* noise is a wall: rays end near where they enter */
    assert_int_equal(vv_runtime_new(&runtime, NULL), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    assert_int_equal(vv_image_new(&image, 37, 35, VV_LAYER_DEPTH, job), VV_OK);
    assert_int_equal(vvi_raycast_prepare(&prepared, &s.scene, job), VV_OK);
    vvi_raycast_state *frame = prepared;
    assert_int_equal(frame->n_bricks, 1);
    assert_int_equal(vvi_renderer_raycast.render(frame, &centres, &all, image, &counts, job), VV_OK);
    vvi_bricks_count(&there, &places, frame->bricks[0]);
    assert_true(there > 20 && there < 7 * 7 * 7 * 3 / 4); /* three faces and the cut, of 343 */
    vvi_raycast_finish(frame);
    vv_image_release(image);
    vv_job_release(job);
    vv_runtime_release(runtime);
    test_ray_scene_finish(&s);
    vv_field_release(lazy);
    vv_field_release(field);
}

/* Strips of the picture, each by whichever thread. */
typedef struct drawing {
    void *state;
    vv_image *image;
    vv_job *job;
} drawing;

static vv_status draw_strip(void *scratch, void *user, size_t index)
{
    const drawing *d = user;
    const vv_tile strip = {0, (int32_t)index * 7, d->image->width, (int32_t)index * 7 + 7};
    const vv_pass centres = {.x = 0.5, .y = 0.5, .stride = 1};
    vv_render_counts counts = {0};
    (void)scratch;
    return vvi_renderer_raycast.render(d->state, &centres, &strip, d->image, &counts, d->job);
}

/* With a limit on the memory of a runtime; bricks at the end, and the status. */
static vv_status draw_within(vv_image **out, size_t *there_out, const test_ray_scene *s, uint64_t limit, int threads)
{
    static const vvi_work work = {.item = draw_strip};
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_job *job;
    drawing d;
    size_t places;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = threads;
    options.memory_bytes = limit;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    assert_int_equal(vv_image_new(&d.image, s->scene.width, s->scene.height, VV_LAYER_DEPTH, NULL), VV_OK);
    if (vvi_raycast_prepare(&d.state, &s->scene, job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    d.job = job;
    const vv_status st = vvi_parallel_for(job, &work, &d, (size_t)s->scene.height / 7);
    vvi_raycast_state *state = d.state;
    vvi_bricks_count(there_out, &places, state->bricks[0]);
    assert_true(vv_runtime_memory_peak(runtime) <= limit);
    vvi_raycast_finish(d.state);
    vv_job_release(job);
    vv_runtime_release(runtime);
    *out = d.image;
    return st;
}

static void what_does_not_fit_is_brought_again(void **state)
{
    (void)state;
    const int64_t dims[3] = {130, 129, 161}; /* cells of 5 x 4 x 5 bricks, of 43 kB each */
    vv_field *field = random_field(VV_TYPE_U8, dims), *lazy = on_request(field);
    test_ray_scene s, whole;
    size_t there;
    vv_image *image;
    look(&whole, field, "mean", false);
    look(&s, lazy, "mean", false);
    vv_image *want = test_ray_picture(&whole, NULL, 1);
    for (int threads = 1; threads <= 3; threads++) {
        assert_int_equal(draw_within(&image, &there, &s, 16 << 20, threads), VV_OK);
        assert_int_equal(there, 100); /* they fit */
        assert_same(want, image, "with room for all");
        vv_image_release(image);
        if (draw_within(&image, &there, &s, 3 << 20, threads) != VV_OK)
            fail_msg("%s", vv_error_last()->message);
        assert_true(there > 0 && there < 100);
        assert_same(want, image, "with room for some");
        vv_image_release(image);
    }
    assert_int_equal(draw_within(&image, &there, &s, 1 << 20, 2), VV_E_LIMIT);
    assert_non_null(strstr(vv_error_last()->message, "do not fit in memory together"));
    vv_image_release(image);
    vv_image_release(want);
    test_ray_scene_finish(&whole);
    test_ray_scene_finish(&s);
    vv_field_release(lazy);
    vv_field_release(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_equal_to_the_bit),   cmocka_unit_test(every_mode_is_equal_to_the_bit),
        cmocka_unit_test(splines_are_equal_to_the_bit),    cmocka_unit_test(bricks_of_one_value_take_one_place),
        cmocka_unit_test(what_is_not_seen_is_not_brought), cmocka_unit_test(what_does_not_fit_is_brought_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
