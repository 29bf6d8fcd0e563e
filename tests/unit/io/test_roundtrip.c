/* What is written is read back the same: samples, types, placement, units, scale, meaning, frames; in all 48 axis
 * orientations, by odd sizes. */
#include "fields.h"
#include "io/sink.h"
#include "io/source.h"
#include "io_test.h"

static const char *const words[VV_TYPE_COUNT] = {"u8", "i8", "u16", "i16", "u32", "i32", "u64", "i64", "f32", "f64"};

typedef struct target {
    const char *name, *encoding;
    double tolerance; /* of positions: 0 exact, else what single floats keep */
} target;

static const target targets[] = {
    {"a.nrrd", "raw", 0},      {"a.nrrd", "gzip", 0},    {"a.nrrd", "bzip2", 0},     {"a.nrrd", "ascii", 0},
    {"a.nrrd", "hex", 0},      {"a.nhdr", "raw", 0},     {"a.nhdr", "gzip", 0},      {"a.nhdr", "ascii", 0},
    {"a.nrrd.gz", "raw", 0},   {"a.nii", NULL, 1e-6},    {"a.nii.gz", NULL, 1e-6},   {"a.hdr", NULL, 1e-6},
    {"a.nii.zst", NULL, 1e-6}, {"a.nrrd.bz2", "raw", 0}, {"a.mhd", "raw", 1e-15},    {"a.mhd", "zlib", 1e-15},
    {"a.mha", "raw", 1e-15},   {"a.mha", "zlib", 1e-15}, {"a.mha.gz", "raw", 1e-15}, {"a.vvh", "raw", 1e-15},
    {"a.vvh", "gzip", 1e-15},
};

static vv_field_info placed_info(int orientation, vv_type type)
{
    static const double spacing[3] = {0.7, 1.1, 2.3};
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 7;
    info.grid.dims[1] = 5;
    info.grid.dims[2] = 3;
    info.grid.index_to_world = io_orientation(orientation, spacing);
    info.grid.space = VV_SPACE_RAS;
    strcpy(info.grid.unit, "mm");
    info.type = type;
    return info;
}

static void check_same(const vv_field *field, const char *path, double tolerance)
{
    vv_file *file = io_open(path);
    vv_field *back = io_frame(file, 0);
    io_same_samples(field, back);
    io_same_info(vv_field_get_info(field), vv_field_get_info(back));
    io_same_positions(&vv_field_get_info(field)->grid, &vv_field_get_info(back)->grid, tolerance);
    vv_field_release(back);
    vv_file_close(file);
}

static void every_orientation_and_type_comes_back_from_every_format(void **state)
{
    for (size_t t = 0; t < sizeof targets / sizeof *targets; t++)
        for (int o = 0; o < 48; o++)
            for (int type = 0; type < VV_TYPE_COUNT; type++) {
                const vv_field_info info = placed_info(o, (vv_type)type);
                vv_field *field = test_field_random(&info, (uint64_t)(o * 100 + type), NULL);
                const char *path = io_path(state, targets[t].name);
                io_write(path, field, targets[t].encoding, (o + type) % 2);
                check_same(field, path, targets[t].tolerance);
                vv_field_release(field);
            }
}

static void samples_keep_their_world_positions_from_nrrd_to_nifti_and_back(void **state)
{
    for (int o = 0; o < 48; o++) {
        const vv_field_info info = placed_info(o, VV_TYPE_I16);
        vv_field *field = test_field_random(&info, (uint64_t)o, NULL);
        io_write(io_path(state, "1.nrrd"), field, NULL, false);
        const char *const names[] = {"1.nrrd", "2.nii.gz", "3.nhdr", "4.hdr", "5.nrrd"};
        for (int step = 0; step + 1 < 5; step++) {
            vv_file *file = io_open(io_path(state, names[step]));
            vv_field *now = io_frame(file, 0);
            io_write(io_path(state, names[step + 1]), now, NULL, step % 2);
            vv_field_release(now);
            vv_file_close(file);
        }
        check_same(field, io_path(state, "5.nrrd"), 1e-6);
        vv_field_release(field);
    }
}

static void sheared_and_oblique_placements_come_back(void **state)
{
    vv_field_info info = placed_info(0, VV_TYPE_U16);
    info.grid.index_to_world = (vv_affine){{{0.9, 0.1, -0.2}, {-0.3, 1.4, 0.25}, {0.1, 0.7, 2.2}}, {-91.5, 12, 3}};
    vv_field *field = test_field_random(&info, 5, NULL);
    for (size_t t = 0; t < sizeof targets / sizeof *targets; t++) {
        io_write(io_path(state, targets[t].name), field, targets[t].encoding, false);
        check_same(field, io_path(state, targets[t].name), targets[t].tolerance);
    }
    vv_field_release(field);
}

static void rotations_come_back_through_the_quaternion_alone(void **state)
{
    for (int turn = 0; turn < 24; turn++) {
        const double a = turn * 0.7, b = turn * 1.3;
        const double ca = cos(a), sa = sin(a), cb = cos(b), sb = sin(b);
        vv_field_info info = placed_info(0, VV_TYPE_U8);
        const double f = turn % 2 ? -2 : 2; /* every other one mirrored */
        info.grid.index_to_world = (vv_affine){
            {{ca * cb * 0.5, sa * cb * 0.5, -sb * 0.5}, {-sa, ca, 0}, {ca * sb * f, sa * sb * f, cb * f}}, {1, 2, 3}};
        vv_field *field = test_field_random(&info, 5, NULL);
        const char *path = io_path(state, "q.nii");
        io_write(path, field, NULL, false);
        size_t n;
        uint8_t *bytes = io_get(path, &n);
        bytes[254] = bytes[255] = 0; /* sform_code: the qform has to do */
        io_put(path, bytes, n);
        free(bytes);
        check_same(field, path, 1e-5);
        vv_field_release(field);
    }
}

static void frames_scale_units_and_names_come_back(void **state)
{
    vv_field_info info = placed_info(11, VV_TYPE_I16);
    info.value_scale = 0.25;
    info.value_offset = -1024;
    strcpy(info.value_unit, "HU");
    strcpy(info.name, "a name that is longer than sixteen");
    strcpy(info.grid.unit, "um");
    info.frame_step = 2.5;
    strcpy(info.frame_unit, "s");
    vv_field *frame[3];
    for (int f = 0; f < 3; f++)
        frame[f] = test_field_random(&info, (uint64_t)f, NULL);
    for (size_t t = 0; t < sizeof targets / sizeof *targets; t++) {
        vv_write_options options;
        vv_write_options_init(&options, sizeof options);
        options.encoding = targets[t].encoding;
        options.stored = true;
        io_ok(vv_field_write(io_path(state, targets[t].name), (const vv_field *const *)frame, 3, &options, NULL));
        vv_file *file = io_open(io_path(state, targets[t].name));
        assert_int_equal(vv_file_info(file)->n_frames, 3);
        assert_float_equal(vv_file_info(file)->frame_step, 2.5, 0);
        assert_string_equal(vv_file_info(file)->frame_unit, "s");
        for (int f = 2; f >= 0; f--) {
            vv_field *back = io_frame(file, f);
            io_same_samples(frame[f], back);
            io_same_info(&info, vv_field_get_info(back));
            assert_int_equal(vv_field_get_info(back)->frame, f);
            vv_field_release(back);
        }
        vv_file_close(file);
    }
    for (int f = 0; f < 3; f++)
        vv_field_release(frame[f]);
}

static void meanings_come_back(void **state)
{
    static const struct {
        vv_meaning meaning;
        int components;
        vv_type type;
    } cases[] = {
        {VV_MEANING_LABEL, 1, VV_TYPE_U8},   {VV_MEANING_LABEL, 1, VV_TYPE_I32},  {VV_MEANING_RGB, 3, VV_TYPE_U8},
        {VV_MEANING_RGBA, 4, VV_TYPE_U8},    {VV_MEANING_RGB, 3, VV_TYPE_U16},    {VV_MEANING_RGBA, 4, VV_TYPE_F32},
        {VV_MEANING_VECTOR, 3, VV_TYPE_F32}, {VV_MEANING_VECTOR, 2, VV_TYPE_F64}, {VV_MEANING_SCALAR, 2, VV_TYPE_I16},
        {VV_MEANING_SCALAR, 3, VV_TYPE_F32}, {VV_MEANING_SCALAR, 7, VV_TYPE_U8},
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        vv_field_info info = placed_info(29, cases[c].type);
        info.meaning = cases[c].meaning;
        info.components = cases[c].components;
        vv_field *field = test_field_random(&info, c, NULL);
        for (size_t t = 0; t < sizeof targets / sizeof *targets; t++) {
            io_write(io_path(state, targets[t].name), field, targets[t].encoding, c % 2);
            check_same(field, io_path(state, targets[t].name), targets[t].tolerance);
        }
        vv_field_release(field);
    }
}

static void plain_spaces_and_their_units_come_back(void **state)
{
    static const char *const units[] = {"voxels", "units", "mm", "nm", "parsec"};
    for (size_t u = 0; u < 5; u++)
        for (int placed = 0; placed < 2; placed++) {
            vv_field_info info = placed_info(3, VV_TYPE_U8);
            info.grid.space = VV_SPACE_PLAIN;
            strcpy(info.grid.unit, units[u]);
            if (!placed)
                info.grid.index_to_world = vv_affine_identity();
            vv_field *field = test_field_random(&info, u, NULL);
            for (size_t t = 0; t < sizeof targets / sizeof *targets; t++) {
                io_write(io_path(state, targets[t].name), field, targets[t].encoding, false);
                check_same(field, io_path(state, targets[t].name), targets[t].tolerance);
            }
            vv_field_release(field);
        }
}

static void raw_and_npy_keep_samples_of_every_shape(void **state)
{
    for (int type = 0; type < VV_TYPE_COUNT; type++)
        for (int64_t nx = 1; nx <= 6; nx++)
            for (int components = 1; components <= 5; components++) {
                vv_field_info info = vv_field_info_default();
                info.grid.dims[0] = nx;
                info.grid.dims[1] = 5;
                info.grid.dims[2] = 2;
                info.type = (vv_type)type;
                info.components = components;
                const bool colour = type == VV_TYPE_U8 && (components == 3 || components == 4);
                info.meaning = !colour ? VV_MEANING_SCALAR : components == 3 ? VV_MEANING_RGB : VV_MEANING_RGBA;
                vv_field *field = test_field_random(&info, 1, NULL);
                char name[64];
                snprintf(name, sizeof name, "a_%dx5x2_%sx%d.raw", (int)nx, words[type], components);
                io_write(io_path(state, name), field, NULL, false);
                check_same(field, io_path(state, name), 0);
                io_write(io_path(state, "a.npy"), field, NULL, nx % 2);
                check_same(field, io_path(state, "a.npy"), 0);
                const vv_field *two[2] = {field, field};
                io_ok(vv_field_write(io_path(state, "b.npy"), two, 2, NULL, NULL));
                vv_file *file = io_open(io_path(state, "b.npy"));
                assert_int_equal(vv_file_info(file)->n_frames, 2);
                vv_field *second = io_frame(file, 1);
                io_same_samples(field, second);
                vv_field_release(second);
                vv_file_close(file);
                vv_field_release(field);
            }
}

static void extreme_samples_come_back_from_text(void **state)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 6;
    for (int type = 0; type < VV_TYPE_COUNT; type++) {
        info.type = (vv_type)type;
        uint64_t bits[6] = {0, UINT64_MAX, UINT64_C(0x8000000000000000), UINT64_C(0x7fffffffffffffff), 1, 12345};
        float f[6] = {0.1f, INFINITY, -INFINITY, 3.4028235e38f, 1e-45f, NAN};
        double d[6] = {0.1, INFINITY, -INFINITY, 1.7976931348623157e308, 5e-324, NAN};
        const void *data = type == VV_TYPE_F32 ? (const void *)f : type == VV_TYPE_F64 ? (const void *)d : bits;
        vv_field *field;
        io_ok(vv_field_new(&field, &info, data, 0, NULL, NULL, NULL));
        io_write(io_path(state, "t.nrrd"), field, "ascii", false);
        check_same(field, io_path(state, "t.nrrd"), 0);
        vv_field_release(field);
    }
}

static void a_coded_file_of_coded_samples_is_read(void **state)
{
    const vv_field_info info = placed_info(21, VV_TYPE_U16);
    vv_field *field = test_field_random(&info, 9, NULL);
    io_write(io_path(state, "inner.nrrd"), field, "gzip", false);
    size_t n;
    uint8_t *bytes = io_get(io_path(state, "inner.nrrd"), &n);
    vv_sink *sink;
    io_ok(vvi_sink_open(&sink, io_path(state, "outer.nrrd.gz"), NULL));
    io_ok(vvi_sink_coding(sink, VVI_CODING_GZIP, 0));
    io_ok(vvi_sink_write(sink, bytes, n));
    io_ok(vvi_sink_commit(sink));
    free(bytes);
    check_same(field, io_path(state, "outer.nrrd.gz"), 0);
    vv_write_options options;
    vv_write_options_init(&options, sizeof options);
    options.encoding = "gzip";
    const vv_field *frames[] = {field};
    assert_int_equal(vv_field_write(io_path(state, "twice.nrrd.gz"), frames, 1, &options, NULL), VV_E_ARGUMENT);
    vv_field_release(field);
}

static void boxes_are_the_same_samples_from_every_format(void **state)
{
    const vv_field_info info = placed_info(21, VV_TYPE_U16);
    vv_field *field = test_field_random(&info, 9, NULL);
    static const vv_box boxes[] = {{{0, 0, 0}, {7, 5, 3}},
                                   {{2, 1, 1}, {4, 3, 2}},
                                   {{6, 4, 2}, {1, 1, 1}},
                                   {{0, 0, 1}, {7, 5, 1}},
                                   {{0, 2, 0}, {7, 2, 3}}};
    for (size_t t = 0; t < sizeof targets / sizeof *targets; t++) {
        io_write(io_path(state, targets[t].name), field, targets[t].encoding, false);
        vv_file *file = io_open(io_path(state, targets[t].name));
        for (size_t b = 0; b < sizeof boxes / sizeof *boxes; b++) {
            vv_field *part;
            io_ok(vv_file_read(&part, file, 0, &boxes[b], NULL));
            const vv_grid want = vv_grid_crop(&info.grid, &boxes[b]);
            io_same_positions(&want, &vv_field_get_info(part)->grid, 1e-6);
            for (int64_t k = 0; k < boxes[b].n[2]; k++)
                for (int64_t j = 0; j < boxes[b].n[1]; j++)
                    for (int64_t i = 0; i < boxes[b].n[0]; i++)
                        assert_true(vv_field_value(part, i, j, k, 0) == vv_field_value(field, i + boxes[b].lo[0],
                                                                                       j + boxes[b].lo[1],
                                                                                       k + boxes[b].lo[2], 0));
            vv_field_release(part);
        }
        vv_file_close(file);
    }
    vv_field_release(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_orientation_and_type_comes_back_from_every_format),
        cmocka_unit_test(samples_keep_their_world_positions_from_nrrd_to_nifti_and_back),
        cmocka_unit_test(sheared_and_oblique_placements_come_back),
        cmocka_unit_test(rotations_come_back_through_the_quaternion_alone),
        cmocka_unit_test(frames_scale_units_and_names_come_back),
        cmocka_unit_test(meanings_come_back),
        cmocka_unit_test(plain_spaces_and_their_units_come_back),
        cmocka_unit_test(raw_and_npy_keep_samples_of_every_shape),
        cmocka_unit_test(extreme_samples_come_back_from_text),
        cmocka_unit_test(a_coded_file_of_coded_samples_is_read),
        cmocka_unit_test(boxes_are_the_same_samples_from_every_format),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
