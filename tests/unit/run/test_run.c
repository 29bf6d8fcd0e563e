/* Steps on files: what goes along of what the file says, time steps, samples in memory; the truth is counted. */
#include "../io/io_test.h"
#include "fields.h"
#include "grid/lazy.h"
#include "io/file_stream.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"
#include <math.h>

enum { N = 6 };

/* Two channels of N^3: sample i has i + 1000 t and 2 i. */
static vv_field *make_frame(int t)
{
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    info.type = VV_TYPE_U16;
    info.components = 2;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = N;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    for (int i = 0; i < N * N * N; i++) {
        ((uint16_t *)data)[2 * i] = (uint16_t)(i + 1000 * t);
        ((uint16_t *)data)[2 * i + 1] = (uint16_t)(2 * i);
    }
    return field;
}

static vv_file *make_file(void **state, int n_frames)
{
    const vv_channel channels[2] = {{.name = "nuclei", .lo = 5, .hi = 90}, {.name = "walls", .lo = 1, .hi = 2}};
    vv_field *frames[4];
    vv_write_options options;
    const char *path = io_path(state, "in.nrrd");
    vv_write_options_init(&options, sizeof options);
    options.channels = channels;
    options.n_channels = 2;
    for (int t = 0; t < n_frames; t++)
        frames[t] = make_frame(t);
    assert_int_equal(vv_field_write(path, (const vv_field *const *)frames, (size_t)n_frames, &options, NULL), VV_OK);
    for (int t = 0; t < n_frames; t++)
        vv_field_release(frames[t]);
    return io_open(path);
}

static vv_step step_of(const vv_operation *operation, const char *settings)
{
    const vv_grid grid = test_cube(N, 0, N - 1);
    const vv_step step = {operation, test_params(operation, settings, &grid)};
    assert_non_null(step.params);
    return step;
}

/* What is written of the channels after one step. */
static void check_carried(const vv_file *file, const vv_operation *operation, const char *settings, int components,
                          const char *first, double lo, bool new_values)
{
    const vv_step step = step_of(operation, settings);
    vv_field_info result = *vv_file_info(file);
    vv_write_options options;
    vv_carry carry;
    vv_write_options_init(&options, sizeof options);
    result.components = components;
    assert_int_equal(vv_carry_begin(&carry, &options, file, &step, 1, &result), VV_OK);
    assert_ptr_equal(options.origin, file);
    assert_int_equal(options.new_values, new_values);
    assert_int_equal(options.n_channels, components);
    assert_string_equal(options.channels[0].name, first);
    assert_true(options.channels[0].lo == lo);
    vv_carry_finish(&carry);
    vv_object_release(step.params);
}

static void each_row_says_what_of_the_file_still_holds(void **state)
{
    vv_file *file = make_file(state, 1);
    vv_operation foreign = vvi_operation_crop; /* a row that says nothing */
    foreign.carry = NULL;
    check_carried(file, &vvi_operation_crop, "x=\"1:\"", 2, "nuclei", 5, false);
    check_carried(file, &vvi_operation_gaussian, "sigma_voxels=[1,1,1]", 2, "nuclei", 5, false);
    check_carried(file, &vvi_operation_channel, "components=\"1\"", 1, "walls", 1, false);
    check_carried(file, &vvi_operation_channel, "components=\"1,0\"", 2, "walls", 1, false);
    check_carried(file, &vvi_operation_rescale, "type=\"u8\"", 2, "nuclei", 0, true);
    check_carried(file, &vvi_operation_rescale, "type=\"u8\";keep_values=true", 2, "nuclei", 5, false);
    check_carried(file, &vvi_operation_rescale, "from=[0,1];to=[0,1];clamp=false", 2, "nuclei", 5, false);
    check_carried(file, &vvi_operation_rescale, "from=[0,1];to=[0,1]", 2, "nuclei", 0, true);
    check_carried(file, &foreign, NULL, 2, "nuclei", 0, true);
    vv_file_close(file);
}

static void what_a_caller_says_of_channels_stands(void **state)
{
    const vv_channel own[2] = {{.name = "mine"}, {.name = "yours"}};
    vv_file *file = make_file(state, 1);
    const vv_step step = step_of(&vvi_operation_crop, NULL);
    vv_write_options options;
    vv_carry carry;
    vv_write_options_init(&options, sizeof options);
    options.channels = own;
    options.n_channels = 2;
    assert_int_equal(vv_carry_begin(&carry, &options, file, &step, 1, vv_file_info(file)), VV_OK);
    assert_ptr_equal(options.channels, own);
    vv_carry_finish(&carry);
    assert_int_equal(vv_carry_begin(&carry, &options, NULL, &step, 1, vv_file_info(file)), VV_OK); /* of no file */
    vv_carry_finish(&carry);
    vv_object_release(step.params);
    vv_file_close(file);
}

static void labels_in_another_type_are_labels(void **state)
{
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_U8;
    info.meaning = VV_MEANING_LABEL;
    info.grid.dims[0] = 9;
    vv_field *in = test_field_random(&info, 3, NULL), *out;
    assert_int_equal(test_apply(&out, &vvi_operation_rescale, in, "type=\"i32\"", NULL), VV_E_UNSUPPORTED);
    const char *itself = "type=\"i32\";from=[0,1];to=[0,1];clamp=false";
    assert_int_equal(test_apply(&out, &vvi_operation_rescale, in, itself, NULL), VV_OK);
    assert_int_equal(vv_field_get_info(out)->meaning, VV_MEANING_LABEL);
    for (int i = 0; i < 9; i++)
        assert_true(vv_field_value(out, i, 0, 0, 0) == vv_field_value(in, i, 0, 0, 0));
    vv_field_release(out);
    vv_field_release(in);
}

/* Runs one step from the file, or from samples, to out.nrrd, and opens that. */
static vv_file *run_step(void **state, const vv_run_input *input, const vv_operation *operation, const char *settings,
                         vv_job *job)
{
    const vv_step step = step_of(operation, settings);
    const char *path = io_path(state, "out.nrrd");
    const vv_run_output output = {.path = path};
    vv_run *run;
    assert_int_equal(vv_run_new(&run, input, 1, &step, 1, &output, operation->name, job), VV_OK);
    const vv_field_info planned = vv_run_get_about(run)->info;
    assert_int_equal(vv_run_write(run), VV_OK);
    assert_memory_equal(vv_run_get_about(run)->written.grid.dims, planned.grid.dims, sizeof planned.grid.dims);
    assert_int_equal(vv_run_write(run), VV_E_ARGUMENT); /* once */
    vv_run_release(run);
    vv_object_release(step.params);
    return io_open(path);
}

static double value_at(vv_file *file, int64_t frame, int64_t i, int component)
{
    vv_field *field;
    assert_int_equal(vv_file_read(&field, file, frame, NULL, NULL), VV_OK);
    const double value = vv_field_value(field, i, 0, 0, component);
    vv_field_release(field);
    return value;
}

static void every_time_step_goes_through_with_its_names(void **state)
{
    size_t n;
    vv_job *job = test_job(1, 0);
    vv_file *in = make_file(state, 3);
    const vv_run_input all = {.file = in, .frame = -1, .name = "in"}, second = {.file = in, .frame = 1, .name = "in"};
    vv_file *out = run_step(state, &all, &vvi_operation_crop, "x=\"2:\"", job);
    assert_int_equal(vv_file_info(out)->n_frames, 3);
    assert_string_equal(vv_file_channels(out, &n)[1].name, "walls");
    for (int t = 0; t < 3; t++)
        assert_true(value_at(out, t, 1, 0) == 3 + 1000 * t);
    vv_file_close(out);
    out = run_step(state, &second, &vvi_operation_crop, "x=\"2:\"", job);
    assert_int_equal(vv_file_info(out)->n_frames, 1);
    assert_true(value_at(out, 0, 0, 0) == 1002);
    vv_file_close(out);
    /* one window for all: what the last time step has at most becomes 1, what the first has at least 0 */
    out = run_step(state, &all, &vvi_operation_rescale, "type=\"f64\"", job);
    assert_true(value_at(out, 0, 0, 0) == 0);
    assert_float_equal(value_at(out, 2, 0, 0), 2000.0 / (2000 + N * N * N - 1), 1e-12);
    vv_file_close(out);
    vv_file_close(in);
    vv_job_release(job);
}

static void volumes_in_memory_and_series_become_one_series(void **state)
{
    vv_run *run;
    vv_file *file = make_file(state, 3);
    vv_field *alone = make_frame(7);
    const vv_step step = step_of(&vvi_operation_join, "period=0.5");
    const vv_run_input inputs[] = {{.field = alone, .name = "alone"}, {.file = file, .frame = -1, .name = "series"}};
    assert_int_equal(vv_run_new(&run, inputs, 2, &step, 1, &(vv_run_output){.path = NULL}, "join", NULL), VV_OK);
    assert_int_equal(vv_run_get_about(run)->n_frames, 4);
    assert_int_equal(vv_run_make(run), VV_OK);
    static const int first[] = {7, 0, 1, 2};
    for (int f = 0; f < 4; f++) {
        const vv_field *got = vv_run_field(run, f);
        const vv_box corner = {{0, 0, 0}, {1, 1, 1}};
        vv_brick brick;
        assert_true(vv_field_get_info(got)->frame_step == 0.5);
        assert_int_equal(vv_field_brick(&brick, got, &corner, NULL), VV_OK);
        assert_int_equal(*(const uint16_t *)brick.data, 1000 * first[f]);
        vv_brick_release(&brick);
    }
    assert_null(vv_run_field(run, 4));
    vv_run_release(run);
    /* volumes by themselves have no time steps to become */
    vv_field *none;
    const vv_field *both[] = {alone, alone};
    assert_int_equal(vv_operation_run(&none, step.operation, both, 2, step.params, NULL), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "vv_run_new()"));
    vv_object_release(step.params);
    vv_field_release(alone);
    vv_file_close(file);
}

static void samples_in_memory_are_taken_as_they_are(void **state)
{
    vv_job *job = test_job(1, 0);
    vv_file *in = make_file(state, 1);
    vv_field *held = make_frame(3); /* not those of the file */
    const vv_run_input beside = {.file = in, .frame = -1, .field = held, .name = "in"};
    const vv_run_input alone = {.frame = -1, .field = held, .name = "memory"};
    size_t n;
    vv_file *out = run_step(state, &beside, &vvi_operation_flip, "axes=\"x\"", job);
    assert_true(value_at(out, 0, 0, 0) == 3000 + N - 1);
    assert_string_equal(vv_file_channels(out, &n)[0].name, "nuclei");
    vv_file_close(out);
    out = run_step(state, &alone, &vvi_operation_flip, "axes=\"x\"", job);
    assert_true(value_at(out, 0, 0, 0) == 3000 + N - 1);
    assert_true(!vv_file_channels(out, &n) || !vv_file_channels(out, &n)[0].name[0]);
    vv_file_close(out);
    vv_field_release(held);
    vv_file_close(in);
    vv_job_release(job);
}

/* Label 1 where x < 4, label 2 where x > 1: they overlap. */
static vv_file *make_segments(void **state)
{
    const vv_label labels[2] = {{.value = 1, .name = "low", .layer = 0}, {.value = 2, .name = "high", .layer = 1}};
    const char *path = io_path(state, "in.seg.nrrd");
    vv_field_info info = vv_field_info_default();
    vv_field *layer[2];
    vv_write_options options;
    vv_write_options_init(&options, sizeof options);
    options.labels = labels;
    options.n_labels = 2;
    options.layers = true;
    info.type = VV_TYPE_U8;
    info.meaning = VV_MEANING_LABEL;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = N;
    for (int l = 0; l < 2; l++) {
        void *data;
        assert_int_equal(vv_field_new_empty(&layer[l], &data, &info, NULL), VV_OK);
        for (int i = 0; i < N * N * N; i++)
            ((uint8_t *)data)[i] = l == 0 ? i % N < 4 : i % N > 1 ? 2 : 0;
    }
    assert_int_equal(vv_field_write(path, (const vv_field *const *)layer, 2, &options, NULL), VV_OK);
    for (int l = 0; l < 2; l++)
        vv_field_release(layer[l]);
    return io_open(path);
}

/* Crops to x > 0 in out.seg.nrrd: how many layers that says it has. */
static size_t crop_segments(void **state, const vv_run_input *input, vv_job *job)
{
    const vv_step step = step_of(&vvi_operation_crop, "x=\"1:\"");
    const vv_run_output output = {.path = io_path(state, "out.seg.nrrd")};
    vv_run *run;
    assert_int_equal(vv_run_new(&run, input, 1, &step, 1, &output, "crop", job), VV_OK);
    const vv_run_about *about = vv_run_get_about(run);
    const size_t n_layers = about->n_layers;
    assert_int_equal(about->n_frames, 1);
    assert_int_equal(about->info.meaning, VV_MEANING_LABEL);
    assert_int_equal(vv_run_write(run), VV_OK);
    assert_int_equal(about->result.meaning, VV_MEANING_LABEL);
    vv_run_release(run);
    vv_object_release(step.params);
    return n_layers;
}

static void all_layers_of_a_segmentation_go_through(void **state)
{
    size_t n;
    vv_job *job = test_job(1, 0);
    vv_file *in = make_segments(state);
    const char *path = io_path(state, "in.seg.nrrd");
    const vv_run_input all = {.file = in, .frame = -1, .name = "in", .path = path};
    const vv_run_input one = {.file = in, .frame = -1, .name = "in", .path = path, .part = "layer0"};
    assert_int_equal(crop_segments(state, &all, job), 2);
    for (int l = 0; l < 2; l++) {
        vv_read_options options;
        vv_file *out;
        vv_read_options_init(&options, sizeof options);
        options.part = l ? "layer1" : "layer0";
        assert_int_equal(vv_file_open(&out, io_path(state, "out.seg.nrrd"), &options, NULL), VV_OK);
        assert_string_equal(vv_file_labels(out, &n)[0].name, l ? "high" : "low");
        assert_int_equal(n, 1);
        for (int x = 0; x < N - 1; x++)
            assert_true(value_at(out, 0, x, 0) == (l == 0 ? x + 1 < 4 : x + 1 > 1 ? 2 : 0));
        vv_file_close(out);
    }
    assert_int_equal(crop_segments(state, &one, job), 0);
    vv_file_close(in);
    vv_job_release(job);
}

static void whole_numbers_are_labels_in_a_format_of_labels(void **state)
{
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_U8;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = N;
    vv_job *job = test_job(1, 0);
    void *data;
    vv_field *field;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    memset(data, 7, N * N * N);
    const vv_run_input input = {.frame = -1, .field = field, .name = "memory"};
    assert_int_equal(crop_segments(state, &input, job), 0);
    vv_field_release(field);
    vv_job_release(job);
}

static void rows_without_samples_are_refused(void **state)
{
    vv_run *run;
    vv_field *field = make_frame(0);
    const vv_run_input input = {.frame = -1, .field = field, .name = "memory"};
    const vv_run_output output = {.path = "out.nrrd"};
    const vv_step steps[] = {step_of(&vvi_operation_isosurface, "iso=3"), step_of(&vvi_operation_crop, "x=\"1:2\"")};
    assert_int_equal(vv_run_new(&run, &input, 1, steps, 2, &output, "crop", NULL), VV_E_ARGUMENT);
    assert_null(run);
    assert_int_equal(vv_run_new(&run, &input, 0, steps, 1, &output, "isosurface", NULL), VV_E_ARGUMENT);
    vv_object_release(steps[0].params);
    vv_object_release(steps[1].params);
    vv_field_release(field);
}

static vv_field *make_ball(vv_job *job)
{
    enum { SIDE = 16 };
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = SIDE;
    void *data;
    vv_field *field;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, job), VV_OK);
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        const int at[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
        ((float *)data)[i] = 5 - (float)hypot(hypot(at[0] - 7.5, at[1] - 7.5), at[2] - 7.5);
    }
    return field;
}

/* Every other voxel, so that there is a piece each. */
static vv_field *make_board(int64_t side)
{
    vv_field_info info = vv_field_info_default();
    void *data;
    vv_field *field;
    info.type = VV_TYPE_U8;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = side;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    for (int64_t i = 0; i < side * side * side; i++)
        ((uint8_t *)data)[i] = (i % side + i / side % side + i / side / side) % 2 == 0;
    return field;
}

static void assert_counts_up(const vv_field *field)
{
    const vv_box all = vv_field_box(field);
    const int64_t side = all.n[0];
    for (int64_t k = 0; k < side; k++) {
        const vv_box slice = {{0, 0, k}, {side, side, 1}};
        vv_brick brick;
        assert_int_equal(vv_field_brick(&brick, field, &slice, NULL), VV_OK);
        for (int64_t i = 0; i < side * side; i++) {
            const bool inside = (i % side + i / side + k) % 2 == 0;
            const uint32_t *row = (const uint32_t *)brick.data;
            assert_int_equal(row[i], inside ? (k * side * side + i) / 2 + 1 : 0);
        }
        vv_brick_release(&brick);
    }
}

/* How many pieces there are is known when they are counted: what was to fit begins again slab by slab. */
static void samples_that_need_more_than_was_foretold_are_made_in_slabs(void **state)
{
    enum { SIDE = 64 };
    vv_field *board = make_board(SIDE);
    const vv_step step = step_of(&vvi_operation_components, NULL);
    const vv_run_input input = {.frame = -1, .field = board, .name = "board"};
    int begun_again = 0;
    for (uint64_t limit = 1 << 20; limit < 16 << 20; limit += limit / 8) {
        vv_job *job = test_job(2, limit);
        vv_run *run;
        assert_int_equal(vv_run_new(&run, &input, 1, &step, 1, &(vv_run_output){.path = NULL}, "components", job),
                         VV_OK);
        const bool planned = vv_run_get_about(run)->streamed;
        assert_int_equal(vv_run_make(run), VV_OK);
        begun_again += !planned && vv_run_get_about(run)->streamed;
        assert_counts_up(vv_run_field(run, 0));
        vv_run_release(run);
        vv_job_release(job);
    }
    assert_true(begun_again > 0);
    vv_object_release(step.params);
    vv_field_release(board);
}

static const char *found(const vv_job *job, const char *name)
{
    vv_finding f;
    for (size_t i = 0; vv_job_finding(&f, job, i); i++)
        if (f.name && strcmp(f.name, name) == 0)
            return f.json;
    return NULL;
}

/* From samples to a surface with fewer triangles, in one run; what the steps found is told by name. */
static void steps_lead_from_samples_to_a_mesh(void **state)
{
    vv_job *job = test_job(2, 0);
    vv_field *field = make_ball(job);
    const vv_step steps[] = {step_of(&vvi_operation_gaussian, "sigma=1"), step_of(&vvi_operation_isosurface, NULL),
                             step_of(&vvi_operation_simplify, "share=0.5")};
    const vv_run_input input = {.frame = -1, .field = field, .name = "ball"};
    const char *path = io_path(state, "ball.ply");
    vv_run *run;
    vv_mesh *read;
    assert_int_equal(vv_run_new(&run, &input, 1, steps, 3, &(vv_run_output){.path = path}, "simplify", job), VV_OK);
    assert_int_equal(vv_run_get_about(run)->makes, VV_IS_MESH);
    assert_int_equal(vv_run_make(run), VV_OK);
    assert_int_equal(vv_run_make(run), VV_E_ARGUMENT); /* once */
    const size_t n = vv_mesh_get_info(vv_run_mesh(run))->n_triangles;
    assert_true(n > 100);
    assert_string_equal(found(job, "value_found"), "true");
    assert_string_equal(found(job, "pieces_before"), "1");
    assert_null(found(job, "pieces"));
    assert_int_equal(vv_run_write(run), VV_OK);
    assert_int_equal(vv_run_write(run), VV_E_ARGUMENT);
    assert_int_equal(vv_mesh_read(&read, path, NULL, job), VV_OK);
    assert_int_equal(vv_mesh_get_info(read)->n_triangles, n);
    vv_mesh_release(read);
    vv_run_release(run);
    for (int i = 0; i < 3; i++)
        vv_object_release(steps[i].params);
    vv_job_forget_findings(job);
    assert_null(found(job, "value_found"));
    vv_field_release(field);
    vv_job_release(job);
}

/* Files that shrink ----------------------------------------------------------------------------------------------- */

enum { SIDE = 128 };

static vv_file *make_large_file(void **state)
{
    const char *path = io_path(state, "shrinks.nrrd");
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = SIDE;
    vv_field *field = test_field_random(&info, 3, NULL);
    io_write(path, field, NULL, false);
    vv_field_release(field);
    return io_open(path);
}

static void run_while_it_shrinks(void **state, const vv_operation *operation, const char *settings, uint64_t memory)
{
    vv_job *job = test_job(2, memory);
    vv_run *run;
    vv_file *file = make_large_file(state);
    vv_field *mapped = io_frame(file, 0);
    const vv_run_input input = {.frame = -1, .field = mapped, .name = "shrinks.nrrd"};
    char out[4096];
    snprintf(out, sizeof out, "%s", io_path(state, "made.nrrd"));
    const vv_run_output output = {.path = out};
    const vv_grid grid = test_cube(SIDE, 0, SIDE - 1);
    const vv_step step = {operation, test_params(operation, settings, &grid)};
    assert_int_equal(vv_run_new(&run, &input, 1, &step, 1, &output, operation->name, job), VV_OK);
    assert_int_equal(vv_run_get_about(run)->streamed, memory > 0 && operation->run_box);
    assert_int_equal(truncate(io_path(state, "shrinks.nrrd"), 20000), 0);
    const vv_status st = vv_run_write(run);
    if (st != VV_E_READ)
        fail_msg("%s %s: %s of samples that are gone", operation->name, settings,
                 st == VV_OK ? "makes a result" : vv_error_last()->message);
    assert_non_null(strstr(vv_error_last()->message, "shrank"));
    assert_int_not_equal(access(out, F_OK), 0);
    vv_run_release(run);
    vv_object_release(step.params);
    vv_field_release(mapped);
    vv_file_close(file);
    vv_job_release(job);
}

static void no_step_makes_a_result_of_a_file_that_shrinks(void **state)
{
    static const struct {
        const vv_operation *operation;
        const char *settings;
    } cases[] = {
        {&vvi_operation_channel, "components=\"0\""},
        {&vvi_operation_crop, "z=\"1:\""},
        {&vvi_operation_flip, "axes=\"z\""},
        {&vvi_operation_gaussian, "sigma_voxels=[1,1,1]"},
        {&vvi_operation_gaussian, "sigma_voxels=[0,0,0]"},
        {&vvi_operation_reorient, "order=\"-zxy\""},
        {&vvi_operation_rescale, "type=\"f32\""},
        {&vvi_operation_resample, "dims=[140,140,140]"},
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++)
        for (int streamed = 0; streamed < 2; streamed++)
            run_while_it_shrinks(state, cases[c].operation, cases[c].settings, streamed ? 4000000 : 0);
}

static void a_streamed_file_that_shrinks_says_so(void **state)
{
    vv_file *file = make_large_file(state);
    vvi_lazy_pool *pool;
    vv_field *field;
    assert_int_equal(vvi_lazy_pool_new(&pool, SIDE * SIDE * SIDE, 0, NULL), VV_OK);
    assert_int_equal(vvi_file_stream(&field, file, 0, pool, NULL), VV_OK);
    vv_field_value(field, 0, 0, 0, 0);
    io_ok(vv_field_health(field));
    assert_int_equal(truncate(io_path(state, "shrinks.nrrd"), 20000), 0);
    assert_true(vv_field_value(field, 0, 0, SIDE - 1, 0) == 0);
    assert_int_equal(vv_field_health(field), VV_E_READ);
    vv_field_release(field);
    vvi_lazy_pool_release(pool);
    vv_file_close(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(each_row_says_what_of_the_file_still_holds, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_a_caller_says_of_channels_stands, io_setup, io_teardown),
        cmocka_unit_test(labels_in_another_type_are_labels),
        cmocka_unit_test_setup_teardown(every_time_step_goes_through_with_its_names, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(volumes_in_memory_and_series_become_one_series, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(samples_in_memory_are_taken_as_they_are, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(all_layers_of_a_segmentation_go_through, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(whole_numbers_are_labels_in_a_format_of_labels, io_setup, io_teardown),
        cmocka_unit_test(rows_without_samples_are_refused),
        cmocka_unit_test(samples_that_need_more_than_was_foretold_are_made_in_slabs),
        cmocka_unit_test_setup_teardown(steps_lead_from_samples_to_a_mesh, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(no_step_makes_a_result_of_a_file_that_shrinks, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(a_streamed_file_that_shrinks_says_so, io_setup, io_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
