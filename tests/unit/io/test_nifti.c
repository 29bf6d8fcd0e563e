/* What NIfTI headers say in the cases that our own writer does not make. */
#include "fields.h"
#include "io_test.h"

static uint8_t *make(void **state, size_t *n)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 3;
    info.grid.dims[1] = 4;
    info.grid.dims[2] = 5;
    info.type = VV_TYPE_I16;
    strcpy(info.grid.unit, "mm");
    info.grid.space = VV_SPACE_RAS;
    vv_field *field = test_field_random(&info, 4, NULL);
    io_write(io_path(state, "made.nii"), field, NULL, false);
    vv_field_release(field);
    return io_get(io_path(state, "made.nii"), n);
}

static void put_short(uint8_t *bytes, int at, int value)
{
    const int16_t v = (int16_t)value;
    memcpy(bytes + at, &v, 2);
}

static void put_float(uint8_t *bytes, int at, float value)
{
    memcpy(bytes + at, &value, 4);
}

static vv_file *open_bytes(void **state, const uint8_t *bytes, size_t n)
{
    const char *path = io_path(state, "changed.nii");
    io_put(path, bytes, n);
    return io_open(path);
}

static void the_sform_wins_over_the_qform_and_both_over_pixdim(void **state)
{
    size_t n;
    uint8_t *bytes = make(state, &n);
    put_float(bytes, 280, 2);   /* srow_x[0] */
    put_float(bytes, 268, 100); /* qoffset_x */
    put_float(bytes, 80, 7);    /* pixdim[1] */
    vv_file *file = open_bytes(state, bytes, n);
    assert_float_equal(vv_file_info(file)->grid.index_to_world.axis[0].x, 2, 0);
    assert_non_null(strstr(vv_file_warning(file, 0), "sform and qform disagree"));
    vv_file_close(file);
    put_short(bytes, 254, 0); /* no sform */
    file = open_bytes(state, bytes, n);
    assert_float_equal(vv_file_info(file)->grid.index_to_world.axis[0].x, 7, 1e-6);
    assert_float_equal(vv_file_info(file)->grid.index_to_world.origin.x, 100, 0);
    assert_null(vv_file_warning(file, 0));
    vv_file_close(file);
    put_short(bytes, 252, 0); /* no qform either */
    file = open_bytes(state, bytes, n);
    assert_float_equal(vv_file_info(file)->grid.index_to_world.axis[0].x, 7, 0);
    assert_float_equal(vv_file_info(file)->grid.index_to_world.origin.x, 0, 0);
    assert_non_null(strstr(vv_file_warning(file, 0), "no orientation"));
    vv_file_close(file);
    free(bytes);
}

static void a_useless_sform_gives_way_with_a_warning(void **state)
{
    size_t n;
    uint8_t *bytes = make(state, &n);
    memset(bytes + 280, 0, 48);
    vv_file *file = open_bytes(state, bytes, n);
    assert_float_equal(vv_file_info(file)->grid.index_to_world.axis[0].x, 1, 0);
    assert_non_null(strstr(vv_file_warning(file, 0), "sform is singular"));
    vv_file_close(file);
    free(bytes);
}

static void a_quaternion_of_a_quarter_turn_and_qfac_mirror(void **state)
{
    size_t n;
    uint8_t *bytes = make(state, &n);
    put_short(bytes, 254, 0);
    put_float(bytes, 76, -1);           /* qfac: the third axis is mirrored */
    put_float(bytes, 264, sqrtf(0.5f)); /* d: a quarter turn about z */
    vv_file *file = open_bytes(state, bytes, n);
    const vv_affine *a = &vv_file_info(file)->grid.index_to_world;
    assert_float_equal(a->axis[0].y, 1, 1e-6);
    assert_float_equal(a->axis[1].x, -1, 1e-6);
    assert_float_equal(a->axis[2].z, -1, 1e-6);
    char letters[16];
    vv_grid_orientation(letters, &vv_file_info(file)->grid);
    assert_string_equal(letters, "ALI");
    vv_file_close(file);
    free(bytes);
}

static void units_slopes_and_labels_are_read(void **state)
{
    size_t n;
    uint8_t *bytes = make(state, &n);
    bytes[123] = 3; /* um */
    put_short(bytes, 68, 1002);
    put_float(bytes, 112, 0); /* a slope of 0 is none */
    put_float(bytes, 116, 55);
    vv_file *file = open_bytes(state, bytes, n);
    assert_string_equal(vv_file_info(file)->grid.unit, "um");
    assert_int_equal(vv_file_info(file)->meaning, VV_MEANING_LABEL);
    assert_true(vv_file_info(file)->value_scale == 1 && vv_file_info(file)->value_offset == 0);
    vv_file_close(file);
    bytes[123] = 0; /* not said: millimetres, as everybody takes it */
    put_float(bytes, 112, -2);
    file = open_bytes(state, bytes, n);
    assert_string_equal(vv_file_info(file)->grid.unit, "mm");
    assert_true(vv_file_info(file)->value_scale == 1 && vv_file_info(file)->value_offset == 0); /* they are stored */
    vv_file_close(file);
    put_short(bytes, 68, 0);
    file = open_bytes(state, bytes, n);
    assert_true(vv_file_info(file)->value_scale == -2 && vv_file_info(file)->value_offset == 55);
    vv_file_close(file);
    static const float no_slopes[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < sizeof no_slopes / sizeof *no_slopes; i++) {
        put_float(bytes, 112, no_slopes[i]);
        put_float(bytes, 116, no_slopes[i]);
        file = open_bytes(state, bytes, n);
        assert_true(vv_file_info(file)->value_scale == 1 && vv_file_info(file)->value_offset == 0);
        assert_non_null(strstr(vv_file_warning(file, 0), "scl_slope"));
        vv_file_close(file);
    }
    free(bytes);
}

static void zero_and_negative_pixdims_are_steps_too(void **state)
{
    size_t n;
    uint8_t *bytes = make(state, &n);
    put_short(bytes, 252, 0);
    put_short(bytes, 254, 0);
    put_float(bytes, 80, 0);
    put_float(bytes, 84, -2);
    vv_file *file = open_bytes(state, bytes, n);
    assert_float_equal(vv_grid_spacing(&vv_file_info(file)->grid, 0), 1, 0);
    assert_float_equal(vv_grid_spacing(&vv_file_info(file)->grid, 1), 2, 0);
    vv_file_close(file);
    free(bytes);
}

static void a_header_without_magic_is_analyze_or_refused(void **state)
{
    size_t n;
    uint8_t *bytes = make(state, &n);
    memset(bytes + 344, 0, 4);
    put_float(bytes, 108, 0); /* where the samples begin in the other file */
    io_put(io_path(state, "old.hdr"), bytes, 348);
    io_refused(io_path(state, "old.hdr"), VV_E_READ, "old.img");
    io_put(io_path(state, "old.img"), bytes + 352, n - 352);
    vv_file *file = io_open(io_path(state, "old.img"));
    const char *key, *value;
    assert_true(vv_file_metadata(file, 0, &key, &value));
    assert_string_equal(value, "Analyze 7.5");
    assert_non_null(strstr(vv_file_warning(file, 0), "does not specify which side is left"));
    vv_file_close(file);
    put_short(bytes, 40, 9);
    io_put(io_path(state, "old.hdr"), bytes, 348);
    io_refused(io_path(state, "old.hdr"), VV_E_FORMAT, "dim[0] would be 1 to 7");
    memcpy(bytes + 344, "n+9", 4);
    io_put(io_path(state, "bad.nii"), bytes, n);
    io_refused(io_path(state, "bad.nii"), VV_E_FORMAT, "magic");
    io_put_text(io_path(state, "text.nii"), "this is no image");
    io_refused(io_path(state, "text.nii"), VV_E_FORMAT, "not a NIfTI");
    free(bytes);
}

/* Codes 0 to 5: which way x, y and z run. */
static void analyze_runs_as_its_orientation_code_says(void **state)
{
    static const char *const letters[] = {"LAS", "LSA", "ASL", "LPS", "LIA", "ASR", "LAS"};
    size_t n;
    uint8_t *bytes = make(state, &n);
    memset(bytes + 344, 0, 4);
    put_float(bytes, 108, 0);
    io_put(io_path(state, "o.img"), bytes + 352, n - 352);
    for (int code = 0; code < 7; code++) {
        char found[16];
        memset(bytes + 252, 0, 12);
        bytes[252] = (uint8_t)code;
        io_put(io_path(state, "o.hdr"), bytes, 348);
        vv_file *file = io_open(io_path(state, "o.hdr"));
        const vv_grid *grid = &vv_file_info(file)->grid;
        vv_grid_orientation(found, grid);
        assert_string_equal(found, letters[code]);
        const vv_vec3 centre = vv_affine_point(grid->index_to_world, (vv_vec3){1, 1.5, 2});
        assert_true(fabs(centre.x) < 1e-9 && fabs(centre.y) < 1e-9 && fabs(centre.z) < 1e-9);
        assert_true((code > 5) == (strstr(vv_file_warning(file, 0), "code is 6") != NULL));
        vv_file_close(file);
    }
    free(bytes);
}

static void pairs_are_opened_by_either_half_coded_or_not(void **state)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 9;
    info.type = VV_TYPE_F32;
    vv_field *field = test_field_random(&info, 4, NULL);
    io_write(io_path(state, "plain.hdr"), field, NULL, true);
    io_write(io_path(state, "coded.hdr.gz"), field, NULL, false);
    static const char *const names[] = {"plain.hdr", "plain.img", "coded.hdr.gz", "coded.img.gz"};
    for (int i = 0; i < 4; i++) {
        vv_file *file = io_open(io_path(state, names[i]));
        vv_field *back = io_frame(file, 0);
        io_same_samples(field, back);
        vv_field_release(back);
        vv_file_close(file);
    }
    assert_int_equal(remove(io_path(state, "plain.img")), 0);
    io_refused(io_path(state, "plain.hdr"), VV_E_READ, "plain.img");
    vv_field_release(field);
}

static void samples_that_are_not_numbers_pass_through(void **state)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 4;
    info.type = VV_TYPE_F32;
    const float values[4] = {NAN, INFINITY, -INFINITY, 1};
    vv_field *field;
    io_ok(vv_field_new(&field, &info, values, 0, NULL, NULL, NULL));
    static const char *const names[] = {"n.nii", "n.nii.gz", "n.nrrd", "n.npy"};
    for (int i = 0; i < 4; i++) {
        io_write(io_path(state, names[i]), field, NULL, false);
        vv_file *file = io_open(io_path(state, names[i]));
        vv_field *back = io_frame(file, 0);
        io_same_samples(field, back);
        vv_field_release(back);
        vv_file_close(file);
    }
    vv_field_release(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sform_wins_over_the_qform_and_both_over_pixdim),
        cmocka_unit_test(a_useless_sform_gives_way_with_a_warning),
        cmocka_unit_test(a_quaternion_of_a_quarter_turn_and_qfac_mirror),
        cmocka_unit_test(units_slopes_and_labels_are_read),
        cmocka_unit_test(zero_and_negative_pixdims_are_steps_too),
        cmocka_unit_test(a_header_without_magic_is_analyze_or_refused),
        cmocka_unit_test(analyze_runs_as_its_orientation_code_says),
        cmocka_unit_test(pairs_are_opened_by_either_half_coded_or_not),
        cmocka_unit_test(samples_that_are_not_numbers_pass_through),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
