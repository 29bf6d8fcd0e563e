/* Chains of steps where memory does not hold their samples: the same bytes as in memory, and each step makes each of
 * its samples once, however many steps there are behind it. */
#include "../io/io_test.h"
#include "fields.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"
#include "run/run_impl.h"

enum { STEPS_MOST = 5, SHARE_FEWEST = 4 };

typedef struct chain {
    const vv_operation *operation[STEPS_MOST];
    const char *settings[STEPS_MOST];
} chain;

/* What looks around samples, what goes through slice by slice, what changes grid, type and components, what comes in
 * another order and what has passes of its own. */
static const chain chains[] = {
    {{&vvi_operation_gaussian, &vvi_operation_median, &vvi_operation_unsharp, &vvi_operation_clamp,
      &vvi_operation_gradient},
     {"sigma_voxels=[1,1,1]", NULL, NULL, "range=-100..100", "vector=true"}},
    {{&vvi_operation_mean, &vvi_operation_dilate, &vvi_operation_erode, &vvi_operation_threshold, &vvi_operation_close},
     {NULL, "radius=2", "radius=2", "range=-50..50", "radius=1"}},
    {{&vvi_operation_resample, &vvi_operation_laplacian, &vvi_operation_close, &vvi_operation_clamp,
      &vvi_operation_unsharp},
     {"spacing=\"1.2,0.9,1.1\"", NULL, "radius=1", "range=-300..300", NULL}},
    {{&vvi_operation_gradient, &vvi_operation_gaussian, &vvi_operation_channel, &vvi_operation_pad,
      &vvi_operation_flip},
     {"vector=true", "sigma_voxels=[1,1,1]", "components=\"1\"", "all=\"2\"", "axes=\"z\""}},
    {{&vvi_operation_median, &vvi_operation_threshold, &vvi_operation_distance, &vvi_operation_gaussian,
      &vvi_operation_gradient},
     {NULL, "range=0..50", NULL, "sigma_voxels=[1,1,1]", NULL}},
    {{&vvi_operation_clamp, &vvi_operation_rescale, &vvi_operation_clamp, &vvi_operation_rescale, &vvi_operation_clamp},
     {"range=-90..90", "to=[0,1]", "range=0.1..0.9", "type=\"u8\"", "range=9..200"}},
};

/* Nobody looks at samples before the work, or around any. */
static const chain in_order = {
    {&vvi_operation_clamp, &vvi_operation_crop, &vvi_operation_threshold, &vvi_operation_channel, &vvi_operation_crop},
    {"range=-90..90", "x=\"3:\"", "range=0..9", NULL, "z=\"1:90\""}};

static const int64_t shapes[][3] = {{113, 127, 149}, {601, 71, 53}}; /* and one with a long x axis */

static uint64_t samples_of(const vv_field_info *info)
{
    const int64_t *n = info->grid.dims;
    return (uint64_t)(n[0] * n[1] * n[2]);
}

/* Each once, but for slabs that memory did not hold and that were made anew, thinner. Files are read more than once, by
 * the share of a slab that is around it; the less memory there is, the thinner it gets. */
static void check_work(const vv_run *run, const vv_field *result, uint64_t share)
{
    for (size_t s = 0; s < run->n_steps; s++) {
        const bool last = s + 1 == run->n_steps;
        const vv_field_info *info = last ? vv_field_get_info(result) : &run->nodes[VVI_RUN_INPUTS + s].info;
        const uint64_t made = vvi_lazy_pool_made(run->stream.pools[run->stream.n_inputs + s]);
        if (made > samples_of(info) * 11 / 10)
            fail_msg("step %zu, %s, made %llu samples of %llu", s, run->steps[s].operation->name,
                     (unsigned long long)made, (unsigned long long)samples_of(info));
    }
    uint64_t read = 0, written = 0;
    for (size_t s = 0; s < run->n_steps; s++) {
        bool seen = false;
        for (size_t i = 0; i < s; i++)
            seen |= run->stream.spools[i] == run->stream.spools[s];
        if (run->stream.spools[s])
            written += run->ways[s].bytes;
        if (run->stream.spools[s] && !seen)
            read += vvi_spool_read(run->stream.spools[s]);
    }
    assert_true(2 * read <= 3 * share * written);
}

static vv_field *make_volume(const int64_t n[3])
{
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    memcpy(info.grid.dims, n, sizeof info.grid.dims);
    return test_field_random(&info, 5, NULL);
}

static vv_run *plan(const chain *c, vv_step *steps, vv_file *file, vv_job *job)
{
    const vv_run_input input = {.file = file, .frame = -1, .name = "in"};
    vv_run *run;
    for (size_t s = 0; s < STEPS_MOST; s++) {
        steps[s] = (vv_step){c->operation[s], test_params(c->operation[s], c->settings[s], &vv_file_info(file)->grid)};
        if (!steps[s].params)
            fail_msg("%s: %s", c->operation[s]->name, vv_error_last()->message);
    }
    io_ok(vv_run_new(&run, &input, 1, steps, STEPS_MOST, &(vv_run_output){.path = NULL}, "chain", job));
    return run;
}

static void finish(vv_run *run, vv_step *steps)
{
    vv_run_release(run);
    for (size_t s = 0; s < STEPS_MOST; s++)
        vv_object_release(steps[s].params);
}

/* Slice by slice, as writers ask. */
static void check_same(const vv_field *a, const vv_field *b, vv_job *job)
{
    const int64_t *n = vv_field_get_info(a)->grid.dims;
    const size_t each = vv_type_bytes(vv_field_get_info(a)->type) * (size_t)vv_field_get_info(a)->components;
    assert_memory_equal(n, vv_field_get_info(b)->grid.dims, 3 * sizeof *n);
    assert_int_equal(each, vv_type_bytes(vv_field_get_info(b)->type) * (size_t)vv_field_get_info(b)->components);
    for (int64_t k = 0; k < n[2]; k++) {
        const vv_box slice = {{0, 0, k}, {n[0], n[1], 1}};
        vv_brick x, y;
        io_ok(vv_field_brick(&x, a, &slice, NULL));
        io_ok(vv_field_brick(&y, b, &slice, job));
        for (int64_t j = 0; j < n[1]; j++)
            assert_memory_equal((const char *)x.data + j * x.stride[1], (const char *)y.data + j * y.stride[1],
                                (size_t)n[0] * each);
        vv_brick_release(&x);
        vv_brick_release(&y);
    }
}

static void check_chain(const chain *c, vv_file *file, uint64_t bytes, uint64_t share)
{
    vv_step whole_steps[STEPS_MOST], steps[STEPS_MOST];
    vv_job *plenty = test_job(2, 0), *job = test_job(2, bytes / share);
    vv_run *whole = plan(c, whole_steps, file, plenty), *run = plan(c, steps, file, job);
    assert_true(vv_run_get_about(run)->streamed && !vv_run_get_about(whole)->streamed);
    io_ok(vv_run_make(whole));
    io_ok(vv_run_make(run));
    check_same(vv_run_field(whole, 0), vv_run_field(run, 0), job);
    check_work(run, vv_run_field(run, 0), share);
    finish(whole, whole_steps);
    finish(run, steps);
    vv_job_release(plenty);
    vv_job_release(job);
}

static void a_chain_makes_each_sample_once_in_a_quarter_and_an_eighth_of_the_memory(void **state)
{
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        const char *path = io_path(state, "in.nrrd");
        vv_field *field = make_volume(shapes[i]);
        const uint64_t bytes = samples_of(vv_field_get_info(field)) * sizeof(float);
        io_write(path, field, "raw", false);
        vv_field_release(field);
        for (size_t c = 0; c < sizeof chains / sizeof *chains; c++)
            for (uint64_t share = SHARE_FEWEST; share <= 2 * SHARE_FEWEST; share *= 2) {
                vv_file *file = io_open(path);
                check_chain(&chains[c], file, bytes, share);
                vv_file_close(file);
            }
    }
}

static void what_goes_through_in_order_needs_no_files(void **state)
{
    const char *path = io_path(state, "in.nrrd");
    vv_field *field = make_volume(shapes[0]);
    vv_step steps[STEPS_MOST];
    vv_job *job = test_job(1, 2 << 20);
    io_write(path, field, "raw", false);
    vv_field_release(field);
    vv_file *file = io_open(path);
    vv_run *run = plan(&in_order, steps, file, job);
    assert_true(vv_run_get_about(run)->streamed && vv_run_get_about(run)->scratch == 0);
    finish(run, steps);
    run = plan(&chains[0], steps, file, job); /* two of them take turns */
    assert_true(vv_run_get_about(run)->scratch == 2 * sizeof(float) * samples_of(vv_file_info(file)));
    finish(run, steps);
    vv_file_close(file);
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_chain_makes_each_sample_once_in_a_quarter_and_an_eighth_of_the_memory,
                                        io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_goes_through_in_order_needs_no_files, io_setup, io_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
