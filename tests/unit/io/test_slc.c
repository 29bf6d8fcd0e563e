/* The .slc files of VolVis: plain and coded slices, slices that end early, headers that lie. */
#include "io_test.h"
#include "jobs.h"

#define HEADER "11111\n3 2 2 8\n1.500000 1 2\n1 6 0 %d\n2 1 X\xff\xfe\xfd\xfc\xfb\xfa"

/* A file of 3 x 2 x 2 voxels with these bytes behind its icon. */
static const char *write_file(void **state, int compression, const char *data, size_t n)
{
    char bytes[512];
    const char *path = io_path(state, "t.slc");
    const int head = snprintf(bytes, sizeof bytes, HEADER, compression);
    memcpy(bytes + head, data, n);
    io_put(path, bytes, (size_t)head + n);
    return path;
}

static void expect_voxels(const vv_field *field, const uint8_t expected[12])
{
    for (int i = 0; i < 12; i++)
        assert_float_equal(vv_field_value(field, i % 3, i / 3 % 2, i / 6, 0), expected[i], 0);
}

static const char coded[] = "5 X\x83\1\2\3\0"       /* three as they are: the slice ends early */
                            "7\nX\4\x09\x82\5\6\0"; /* four nines, then two */
#define N_CODED (sizeof coded - 1)

static void plain_slices_are_bytes(void **state)
{
    static const uint8_t voxels[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    vv_file *file = io_open(write_file(state, 0, (const char *)voxels, 12));
    const vv_field_info *info = vv_file_info(file);
    assert_string_equal(vv_file_format(file), "slc");
    assert_string_equal(info->grid.unit, "mm");
    assert_float_equal(vv_grid_spacing(&info->grid, 0), 1.5, 0);
    assert_float_equal(vv_grid_spacing(&info->grid, 2), 2, 0);
    assert_true(vv_file_mappable(file));
    vv_field *field = io_frame(file, 0);
    expect_voxels(field, voxels);
    vv_field_release(field);
    vv_file_close(file);
}

static void coded_slices_are_runs_and_what_is_missing_is_0(void **state)
{
    static const uint8_t voxels[] = {1, 2, 3, 0, 0, 0, 9, 9, 9, 9, 5, 6};
    vv_job *job;
    vv_file *file;
    vv_field *field;
    io_ok(vv_job_new(&job, NULL, NULL, NULL));
    io_ok(vv_file_open(&file, write_file(state, 1, coded, N_CODED), NULL, job));
    const vv_box second = {{1, 0, 1}, {2, 2, 1}}, first = {{0, 0, 0}, {2, 1, 1}};
    io_ok(vv_file_read(&field, file, 0, &second, job));
    assert_float_equal(vv_field_value(field, 1, 1, 0, 0), 6, 0);
    vv_field_release(field);
    io_ok(vv_file_read(&field, file, 0, &first, job)); /* backwards, and before the gap */
    assert_float_equal(vv_field_value(field, 1, 0, 0, 0), 2, 0);
    vv_field_release(field);
    assert_false(vv_job_damaged(job));
    io_ok(vv_file_read(&field, file, 0, NULL, job));
    assert_true(vv_job_damaged(job));
    expect_voxels(field, voxels);
    vv_field_release(field);
    vv_file_close(file);
    vv_job_release(job);
}

static void a_run_past_the_end_of_its_slice_harms_no_other(void **state)
{
    static const char data[] = "3 X\x7f\7\0"
                               "3 X\6\1\0";
    vv_file *file = io_open(write_file(state, 1, data, sizeof data - 1));
    vv_field *field = io_frame(file, 0);
    expect_voxels(field, (const uint8_t[]){7, 7, 7, 7, 7, 7, 1, 1, 1, 1, 1, 1});
    vv_field_release(field);
    vv_file_close(file);
}

static void each_lie_of_a_header_is_one_sentence(void **state)
{
    static const struct {
        const char *text, *words;
        vv_status status;
    } lies[] = {
        {"11111\n0 2 2 8\n1 1 1\n1 6 0 0\n0 0 X", "the width is 0", VV_E_FORMAT},
        {"11111\n3 -2 2 8\n1 1 1\n1 6 0 0\n0 0 X", "the height is -2", VV_E_FORMAT},
        {"11111\n3 2 2.5 8\n1 1 1\n1 6 0 0\n0 0 X", "slices is 2.5", VV_E_FORMAT},
        {"11111\n3 2 9999999 8\n1 1 1\n1 6 0 0\n0 0 X", "9999999", VV_E_FORMAT},
        {"11111\n3 2 2 16\n1 1 1\n1 6 0 0\n0 0 X012345678901", "16 bits", VV_E_UNSUPPORTED},
        {"11111\n3 2 2 8\n1 0 1\n1 6 0 0\n0 0 X", "along y is 0", VV_E_FORMAT},
        {"11111\n3 2 2 8\n1 nan 1\n1 6 0 0\n0 0 X", "along y is nan", VV_E_FORMAT},
        {"11111\n3 2 2 8\n1 1 1\n1 6 0 2\n0 0 X", "compression is 2", VV_E_FORMAT},
        {"11111\n3 2 two 8\n1 1 1\n1 6 0 0\n0 0 X", "'two' where the number of slices", VV_E_FORMAT},
        {"11111\n3 2 2 8\n1 1 1\n1 6 0 0\n0 0 Y", "no X", VV_E_FORMAT},
        {"11111\n3 2 2 8\n1 1 1\n1 6 0 0\n0", "''", VV_E_FORMAT},
        {"11111\n3 2 2 8\n1 1 1\n1 6 0 0\n9999 9999 X0123456789", "were expected", VV_E_FORMAT},
        {"11111\n1048576 1048576 1048576 8\n1 1 1\n1 6 0 1\n0 0 X2 X\x7f\1", "were expected", VV_E_FORMAT},
        {"11111\n1024 1024 1024 8\n1 1 1\n1 6 0 1\n0 0 X2 X\x7f\1", "were expected", VV_E_FORMAT},
        {"11111\n3 2 2 8\n1 1 1\n1 6 0 1\n0 0 X2 Y\x7f\1 3 Xabcdefgh", "less than half", VV_E_FORMAT},
    };
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        io_put_text(io_path(state, "lie.slc"), lies[i].text);
        io_refused(io_path(state, "lie.slc"), lies[i].status, lies[i].words);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plain_slices_are_bytes),
        cmocka_unit_test(coded_slices_are_runs_and_what_is_missing_is_0),
        cmocka_unit_test(a_run_past_the_end_of_its_slice_harms_no_other),
        cmocka_unit_test(each_lie_of_a_header_is_one_sentence),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
