/* Boxes of results by themselves are boxes of the whole; volumes that are made when they are asked for are the same. */
#include "fields.h"
#include "filter/stream.h"
#include "grid/lazy.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static const struct {
    const vv_operation *operation;
    const char *settings;
} cases[] = {
    {&vvi_operation_channel, "components=\"0\""},
    {&vvi_operation_crop, "x=\"2:9\";z=\"1:\""},
    {&vvi_operation_flip, "axes=\"xz\""},
    {&vvi_operation_flip, "axes=\"y\";mirror=true"},
    {&vvi_operation_rescale, "type=\"f32\""},
    {&vvi_operation_rescale, "type=\"u8\";percentile=[5,95];keep_values=true"},
    {&vvi_operation_gaussian, "sigma_voxels=[1,0.5,1.3]"},
    {&vvi_operation_gaussian, "sigma_voxels=[0,0,0]"},
    {&vvi_operation_bilateral, "sigma_voxels=[1,0.5,0.7];value_sigma=100"},
    {&vvi_operation_bilateral, "sigma=0.7"},
    {&vvi_operation_denoise, "search_voxels=[1,2,1];patch_voxels=[1,0,2]"},
    {&vvi_operation_diffuse, "iterations=2;edge=50"},
    {&vvi_operation_diffuse, "conductance=\"rational\";iterations=3"},
    {&vvi_operation_reorient, "order=\"-zxy\""},
    {&vvi_operation_resample, "dims=[7,20,5]"},
    {&vvi_operation_resample, "dims=[30,3,31];interpolation=\"cubic\""},
    {&vvi_operation_resample, "dims=[5,6,7];interpolation=\"nearest\""},
};
#define N_CASES (sizeof cases / sizeof *cases)

static vv_field_info info_of(vv_type type, int components)
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    info.components = components;
    info.grid.dims[0] = 11, info.grid.dims[1] = 5, info.grid.dims[2] = 13;
    info.grid.index_to_world.axis[0].x = 0.5;
    info.grid.index_to_world.axis[2].z = 2;
    return info;
}

static vv_field *cut(const vv_field *field, const vv_box *box)
{
    vv_field_info info = *vv_field_get_info(field);
    vv_field *out;
    vv_brick brick;
    void *data;
    info.grid = vv_grid_crop(&info.grid, box);
    assert_int_equal(vv_field_new_empty(&out, &data, &info, NULL), VV_OK);
    assert_int_equal(vv_field_brick(&brick, field, box, NULL), VV_OK);
    const size_t row = (size_t)box->n[0] * vv_type_bytes(info.type) * (size_t)info.components;
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            memcpy((char *)data + (size_t)(k * box->n[1] + j) * row,
                   (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2], row);
    vv_brick_release(&brick);
    return out;
}

static vv_box random_box(const int64_t dims[3], uint64_t seed, uint64_t at)
{
    vv_box box;
    for (int a = 0; a < 3; a++) {
        box.lo[a] = (int64_t)(test_random(seed, at * 6 + (uint64_t)a) % (uint64_t)dims[a]);
        box.n[a] = 1 + (int64_t)(test_random(seed, at * 6 + 3 + (uint64_t)a) % (uint64_t)(dims[a] - box.lo[a]));
    }
    return box;
}

static void a_box_of_a_result_is_that_box_of_the_whole(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    for (size_t c = 0; c < N_CASES; c++)
        for (int t = 0; t < VV_TYPE_COUNT; t++) {
            const vv_field_info info = info_of((vv_type)t, 1 + t % 3);
            vv_field *in = test_field_random(&info, 5, NULL), *whole;
            vv_object *params = test_params(cases[c].operation, cases[c].settings, &info.grid);
            assert_non_null(params);
            assert_int_equal(test_apply(&whole, cases[c].operation, in, cases[c].settings, NULL), VV_OK);
            for (uint64_t b = 0; b < 6; b++) {
                const vv_box box =
                    random_box(vv_field_get_info(whole)->grid.dims, seed, (c * 97 + (uint64_t)t) * 6 + b);
                const vv_field *const inputs[1] = {in};
                vv_field *part, *expected = cut(whole, &box);
                assert_int_equal(cases[c].operation->run_box(&part, inputs, 1, params, &box, NULL), VV_OK);
                assert_true(test_same_samples(part, expected));
                assert_memory_equal(&vv_field_get_info(part)->grid, &vv_field_get_info(expected)->grid,
                                    sizeof(vv_grid));
                assert_true(vv_field_get_info(part)->value_scale == vv_field_get_info(whole)->value_scale);
                vv_field_release(part);
                vv_field_release(expected);
            }
            vv_object_release(params);
            vv_field_release(whole);
            vv_field_release(in);
        }
}

typedef struct counted {
    const vv_field *field;
    int made, dropped;
    int64_t most; /* slices at once */
} counted;

static vv_status make_part(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    (void)job;
    counted *c = user;
    c->made++;
    c->most = box->n[2] > c->most ? box->n[2] : c->most;
    *out = cut(c->field, box);
    return VV_OK;
}

static void drop_part(void *user)
{
    ((counted *)user)->dropped++;
}

/* Two operations one after the other, and what they make of whole volumes. */
typedef struct chain {
    const vv_operation *first, *second;
    const char *settings[2];
    vv_field *in, *one, *two; /* two NULL: the second refuses */
    vv_status status;
} chain;

static void stream_chain(const chain *c, uint64_t slices, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(c->in);
    counted count = {.field = c->in};
    const vvi_lazy_source source = {make_part, drop_part, &count};
    vvi_lazy_pool *pools[3];
    vv_field *fields[3];
    for (int p = 0; p < 3; p++)
        assert_int_equal(vvi_lazy_pool_new(&pools[p], slices * 11 * 5 * 2 * 2, 0, job), VV_OK);
    assert_int_equal(vvi_field_lazy(&fields[0], info, &source, pools[0], job), VV_OK);
    vv_object *pa = test_params(c->first, c->settings[0], &info->grid);
    vv_object *pb = test_params(c->second, c->settings[1], &vv_field_get_info(c->one)->grid);
    const vv_field *const first[1] = {fields[0]};
    assert_int_equal(vvi_operation_stream(&fields[1], c->first, first, 1, pa, pools[1], job), VV_OK);
    const vv_field *const second[1] = {fields[1]};
    assert_int_equal(vvi_operation_stream(&fields[2], c->second, second, 1, pb, pools[2], job), c->status);
    if (c->status == VV_OK) {
        /* without a job nothing is remembered: what asks for the range of the whole does so for each few slices */
        assert_true(test_same_samples_by(fields[2], c->two, slices < 6 ? job : NULL));
        vv_field_release(fields[2]);
    }
    vv_field_release(fields[1]);
    vv_field_release(fields[0]);
    assert_int_equal(count.dropped, 1);
    assert_true(count.made > 0);
    vv_object_release(pa);
    vv_object_release(pb);
    for (int p = 0; p < 3; p++)
        vvi_lazy_pool_release(pools[p]);
}

static void chains_of_streams_give_the_same_samples_from_few_slices(void **state)
{
    (void)state;
    vv_job *job = test_job(3, 0);
    const vv_field_info info = info_of(VV_TYPE_U16, 2);
    vv_field *in = test_field_random(&info, 7, job);
    int n = 0;
    for (size_t a = 0; a < N_CASES; a++) {
        chain c = {.first = cases[a].operation, .settings[0] = cases[a].settings, .in = in};
        assert_int_equal(test_apply(&c.one, c.first, in, c.settings[0], job), VV_OK);
        for (size_t b = 0; b < N_CASES; b += 2) {
            c.second = cases[b].operation;
            c.settings[1] = cases[b].settings;
            c.two = NULL;
            c.status = test_apply(&c.two, c.second, c.one, c.settings[1], job);
            for (uint64_t slices = 0; slices < 16; slices += 3, n++)
                stream_chain(&c, slices, job);
            vv_field_release(c.two);
        }
        vv_field_release(c.one);
    }
    print_message("%d chains\n", n);
    vv_field_release(in);
    vv_job_release(job);
}

static void slices_in_order_are_made_once_and_few_at_a_time(void **state)
{
    (void)state;
    const vv_field_info info = info_of(VV_TYPE_U8, 1);
    vv_field *in = test_field_random(&info, 7, NULL), *field;
    counted count = {.field = in};
    const vvi_lazy_source source = {make_part, drop_part, &count};
    vvi_lazy_pool *pool;
    assert_int_equal(vvi_lazy_pool_new(&pool, 4 * 11 * 5, 0, NULL), VV_OK);
    assert_int_equal(vvi_field_lazy(&field, &info, &source, pool, NULL), VV_OK);
    for (int64_t k = 0; k < 13; k++)
        for (int64_t j = 0; j < 5; j++) {
            const vv_box box = {{3, j, k}, {4, 1, 1}};
            vv_brick brick;
            assert_int_equal(vv_field_brick(&brick, field, &box, NULL), VV_OK);
            assert_true(*(const uint8_t *)brick.data == (uint8_t)vv_field_value(in, 3, j, k, 0));
            vv_brick_release(&brick);
        }
    assert_int_equal(count.made, 4); /* 4 + 4 + 4 + 1 slices */
    assert_int_equal(count.most, 4);
    vv_field_release(field);
    vvi_lazy_pool_release(pool);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_of_a_result_is_that_box_of_the_whole),
        cmocka_unit_test(chains_of_streams_give_the_same_samples_from_few_slices),
        cmocka_unit_test(slices_in_order_are_made_once_and_few_at_a_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
