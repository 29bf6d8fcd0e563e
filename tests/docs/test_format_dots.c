/* The worked example of docs/adding-a-format.md does what the page says. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
/* cmocka wants those first */
#include "format_dots.h"
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <volvis/volvis.h>

static const vv_format *const formats[] = {&format_dots, NULL};

/* One more format beside those that are built in: how a program of your own adds it without touching the library. */
static vv_job *job_with_dots(void)
{
    const vv_registry mine = {.formats = formats};
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.more = &mine;
    vv_runtime *runtime;
    vv_job *job;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    vv_runtime_release(runtime);
    return job;
}

static void path_in_tmp(char out[256], const char *name)
{
    const char *folder = getenv("TMPDIR");
    snprintf(out, 256, "%s/volvis-%d-%s", folder ? folder : "/tmp", (int)getpid(), name);
}

static void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
}

static void what_is_written_is_read_back_and_any_box_of_it(void **state)
{
    uint8_t samples[5 * 4 * 3 + 8];
    for (size_t i = 0; i < sizeof samples; i++)
        samples[i] = (uint8_t)(i * 7);
    vv_field_info info = vv_field_info_default();
    memcpy(info.grid.dims, (int64_t[3]){5, 4, 3}, sizeof info.grid.dims);
    vv_job *job = job_with_dots();
    vv_field *field, *again, *part;
    char path[256];
    path_in_tmp(path, "a.dots");
    assert_int_equal(vv_field_new(&field, &info, samples, 8, NULL, NULL, job), VV_OK);
    assert_int_equal(vv_field_write(path, (const vv_field *const[]){field}, 1, NULL, job), VV_OK);

    vv_file *file;
    assert_int_equal(vv_file_open(&file, path, NULL, job), VV_OK);
    assert_string_equal(vv_file_format(file), "dots");
    assert_int_equal(vv_file_read(&again, file, 0, NULL, job), VV_OK);
    const vv_box box = {{1, 2, 1}, {3, 2, 2}};
    assert_int_equal(vv_file_read(&part, file, 0, &box, job), VV_OK);
    for (int64_t k = 0; k < 3; k++)
        for (int64_t j = 0; j < 4; j++)
            for (int64_t i = 0; i < 5; i++)
                assert_true(vv_field_value(again, i, j, k, 0) == samples[(k * 4 + j) * 5 + i]);
    assert_true(vv_field_value(part, 2, 1, 1, 0) == samples[(2 * 4 + 3) * 5 + 3]);
    vv_field_release(part);
    vv_field_release(again);
    vv_file_close(file);
    vv_field_release(field);
    vv_job_release(job);
    remove(path);
}

static void expect_refusal(const char *text, const char *sentence)
{
    vv_job *job = job_with_dots();
    vv_file *file = NULL;
    char path[256];
    path_in_tmp(path, "bad.dots");
    write_text(path, text);
    assert_int_equal(vv_file_open(&file, path, NULL, job), VV_E_FORMAT);
    assert_null(file);
    if (!strstr(vv_error_last()->message, sentence))
        fail_msg("'%s' does not say '%s'", vv_error_last()->message, sentence);
    vv_job_release(job);
    remove(path);
}

static void a_header_without_three_sizes_is_refused(void **state)
{
    expect_refusal("DOTS 4 4\nxxxxxxxxxxxxxxxx", "three sizes");
    expect_refusal("DOTS 4 0 4\nxxxxxxxxxxxxxxxx", "three sizes");
    expect_refusal("DOTS 1.5 4 4\nxxxxxxxxxxxxxxxx", "three sizes");
}

static void a_header_that_promises_more_than_the_file_holds_is_refused_at_once(void **state)
{
    expect_refusal("DOTS 1000 1000 1000\nxxxx", "1000000000 bytes of samples");
}

static void a_field_that_the_format_cannot_hold_is_refused_before_a_file_appears(void **state)
{
    static const float samples[8] = {0};
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = 8;
    vv_job *job = job_with_dots();
    vv_field *field;
    char path[256];
    path_in_tmp(path, "f32.dots");
    assert_int_equal(vv_field_new(&field, &info, samples, 0, NULL, NULL, job), VV_OK);
    assert_int_equal(vv_field_write(path, (const vv_field *const[]){field}, 1, NULL, job), VV_E_UNSUPPORTED);
    assert_int_not_equal(access(path, F_OK), 0);
    vv_field_release(field);
    vv_job_release(job);
}

static void expect_no_runtime(const vv_format *format, vv_status status, const char *sentence)
{
    const vv_format *const rows[] = {&format_dots, format, NULL};
    const vv_registry mine = {.formats = rows};
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.more = &mine;
    vv_runtime *runtime = (vv_runtime *)&options;
    assert_int_equal(vv_runtime_new(&runtime, &options), status);
    assert_null(runtime);
    if (!strstr(vv_error_last()->message, sentence))
        fail_msg("'%s' does not say '%s'", vv_error_last()->message, sentence);
}

static void a_row_that_cannot_stand_in_the_table_is_refused(void **state)
{
    vv_format row = format_dots;
    expect_no_runtime(&row, VV_E_ARGUMENT, "two of the name 'dots'");
    row.name = "nrrd";
    expect_no_runtime(&row, VV_E_ARGUMENT, "two of the name 'nrrd'");
    row.name = NULL;
    expect_no_runtime(&row, VV_E_ARGUMENT, "no name");
    row.name = "dots2";
    row.api = VV_FORMAT_API + 1;
    expect_no_runtime(&row, VV_E_UNSUPPORTED, "the format 'dots2' is built for version 2 of its table");
}

static void rows_stand_behind_those_that_are_built_in(void **state)
{
    vv_job *job = job_with_dots();
    const vv_registry *registry = vv_job_registry(job), *builtin = vv_registry_builtin();
    size_t n = 0;
    for (; builtin->formats[n]; n++)
        assert_ptr_equal(registry->formats[n], builtin->formats[n]);
    assert_ptr_equal(registry->formats[n], &format_dots);
    assert_null(registry->formats[n + 1]);
    for (n = 0; builtin->renderers[n]; n++)
        assert_ptr_equal(registry->renderers[n], builtin->renderers[n]);
    assert_null(registry->renderers[n]);
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_written_is_read_back_and_any_box_of_it),
        cmocka_unit_test(a_header_without_three_sizes_is_refused),
        cmocka_unit_test(a_header_that_promises_more_than_the_file_holds_is_refused_at_once),
        cmocka_unit_test(a_row_that_cannot_stand_in_the_table_is_refused),
        cmocka_unit_test(rows_stand_behind_those_that_are_built_in),
        cmocka_unit_test(a_field_that_the_format_cannot_hold_is_refused_before_a_file_appears),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
