/* Time steps in files of their own: files that are replaced, cut or gone between opening and reading, and names. */
#include "io/formats/steps/steps.h"
#include "io_test.h"

static void put_step(const char *path, int n, int value)
{
    char header[256];
    uint8_t samples[512];
    memset(samples, value, sizeof samples);
    const int m = snprintf(header, sizeof header,
                           "NRRD0004\ntype: uint8\ndimension: 3\nsizes: %d %d %d\nencoding: raw\n\n", n, n, n);
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    fwrite(header, 1, (size_t)m, f);
    fwrite(samples, 1, (size_t)(n * n * n), f);
    fclose(f);
}

static void put_steps(void **state)
{
    mkdir(io_path(state, "run"), 0777);
    put_step(io_path(state, "run/t2.nrrd"), 8, 2);
    put_step(io_path(state, "run/t10.nrrd"), 8, 10);
    put_step(io_path(state, "run/t9.nrrd"), 8, 9);
}

static int first_sample(vv_file *file, int64_t frame)
{
    vv_field *field;
    vv_brick brick;
    const vv_box box = {{0, 0, 0}, {1, 1, 1}};
    io_ok(vv_file_read(&field, file, frame, NULL, NULL));
    assert_int_equal(vv_field_get_info(field)->frame, frame);
    assert_int_equal(vv_field_get_info(field)->n_frames, 3);
    io_ok(vv_field_brick(&brick, field, &box, NULL));
    const int value = *(const uint8_t *)brick.data;
    vv_brick_release(&brick);
    vv_field_release(field);
    return value;
}

static void steps_are_read_when_they_are_asked_for(void **state)
{
    vv_file *file;
    put_steps(state);
    io_ok(vv_file_open(&file, io_path(state, "run"), NULL, NULL));
    assert_int_equal(vv_file_info(file)->n_frames, 3);
    put_step(io_path(state, "run/t9.nrrd"), 8, 77); /* of the same kind: nothing of it was read before */
    assert_int_equal(first_sample(file, 0), 2);
    assert_int_equal(first_sample(file, 1), 77);
    assert_int_equal(first_sample(file, 2), 10);
    assert_int_equal(first_sample(file, 0), 2);
    vv_file_close(file);
}

static void steps_that_are_gone_or_replaced_are_told(void **state)
{
    vv_file *file;
    vv_field *field;
    put_steps(state);
    io_ok(vv_file_open(&file, io_path(state, "run"), NULL, NULL));
    put_step(io_path(state, "run/t9.nrrd"), 4, 9);
    remove(io_path(state, "run/t10.nrrd"));
    assert_int_equal(vv_file_read(&field, file, 1, NULL, NULL), VV_E_READ);
    assert_non_null(strstr(vv_error_last()->message, "'t9.nrrd' has been replaced"));
    assert_int_equal(vv_file_read(&field, file, 2, NULL, NULL), VV_E_READ);
    assert_non_null(strstr(vv_error_last()->message, "'t10.nrrd' cannot be opened"));
    assert_int_equal(first_sample(file, 0), 2);
    vv_file_close(file);
}

static void check_group(void **state, const char *const *names, size_t n_groups, const char *key, vvi_steps_sure sure)
{
    vvi_steps_groups groups;
    vv_source *folder;
    const char *path = io_path(state, "names");
    nftw(path, io_remove_one, 16, FTW_DEPTH | FTW_PHYS);
    mkdir(path, 0777);
    for (; *names; names++) {
        char one[256];
        snprintf(one, sizeof one, "names/%s", *names);
        io_put(io_path(state, one), "", 0);
    }
    io_ok(vvi_source_open_input(&folder, path, NULL));
    io_ok(vvi_steps_find(&groups, folder, NULL, NULL));
    assert_int_equal(groups.n_groups, n_groups);
    assert_string_equal(groups.group[0].key, key);
    assert_int_equal(groups.group[0].sure, sure);
    vvi_steps_groups_free(&groups);
    vvi_source_close(folder);
}

#define NAMES(...) ((const char *const[]){__VA_ARGS__, NULL})

static void names_say_what_are_steps(void **state)
{
    check_group(state, NAMES("a1.vti", "a2.vti", "a10.vti", "a.txt", ".a3.vti"), 1, "a{t}.vti", VVI_STEPS_SURE);
    check_group(state, NAMES("t000.nii.gz", "t001.nii.gz"), 1, "t{t}.nii.gz", VVI_STEPS_SURE);
    check_group(state, NAMES("x64_1.h5", "x64_2.h5"), 1, "x64_{t}.h5", VVI_STEPS_SURE);
    check_group(state, NAMES("a1.mhd", "a1.raw", "a2.mhd", "a2.raw"), 1, "a{t}.mhd", VVI_STEPS_SURE);
    check_group(state, NAMES("a1.hdr", "a1.img.gz", "a2.hdr", "a2.img.gz"), 1, "a{t}.hdr", VVI_STEPS_SURE);
    check_group(state, NAMES("a1.vti"), 1, "a1.vti", VVI_STEPS_ALONE);
    check_group(state, NAMES("1_a1.vti", "1_a2.vti", "2_a1.vti"), 1, "*_a{t}.vti", VVI_STEPS_UNCLEAR);
    check_group(state, NAMES("case_1.nii", "case_2.nii"), 1, "case_{t}.nii", VVI_STEPS_UNCLEAR);
    check_group(state, NAMES("img_ch0.nrrd", "img_ch1.nrrd"), 1, "img_ch{t}.nrrd", VVI_STEPS_UNCLEAR);
    check_group(state, NAMES("a1.vti", "a2.vti", "b1.vti", "b2.vti"), 2, "a{t}.vti", VVI_STEPS_SURE);
    check_group(state, NAMES("a1.vti", "a2.vti", "mask.nii"), 2, "a{t}.vti", VVI_STEPS_SURE);
    check_group(state, NAMES("99999999999999999999999.vti", "1.vti"), 1, "{t}.vti", VVI_STEPS_SURE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(steps_are_read_when_they_are_asked_for, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(steps_that_are_gone_or_replaced_are_told, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(names_say_what_are_steps, io_setup, io_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
