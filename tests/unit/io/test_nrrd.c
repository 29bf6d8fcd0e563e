/* The dialects of NRRD that our own writer does not write: hand-made headers whose samples and places are known. */
#include "io_test.h"

/* Eight samples 0 .. 7 after the header. */
static vv_file *open_text(void **state, const char *header, const char *samples, size_t n)
{
    char text[8192];
    const size_t n_header = strlen(header);
    memcpy(text, header, n_header);
    memcpy(text + n_header, samples, n);
    const char *path = io_path(state, "t.nrrd");
    io_put(path, text, n_header + n);
    return io_open(path);
}

static const char eight[] = {0, 1, 2, 3, 4, 5, 6, 7};

#define U8_3D "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n"

static void check_place(const vv_file *file, double xx, double yy, double zz, double ox, double oy, double oz)
{
    const vv_affine *a = &vv_file_info(file)->grid.index_to_world;
    assert_float_equal(a->axis[0].x, xx, 1e-12);
    assert_float_equal(a->axis[1].y, yy, 1e-12);
    assert_float_equal(a->axis[2].z, zz, 1e-12);
    assert_float_equal(a->origin.x, ox, 1e-12);
    assert_float_equal(a->origin.y, oy, 1e-12);
    assert_float_equal(a->origin.z, oz, 1e-12);
}

static void spaces_come_to_right_front_up(void **state)
{
    static const struct {
        const char *space;
        double sx, sy, sz;
        vv_space kind;
        const char *unit;
    } spaces[] = {
        {"right-anterior-superior", 1, 1, 1, VV_SPACE_RAS, "mm"},
        {"RAS", 1, 1, 1, VV_SPACE_RAS, "mm"},
        {"left-anterior-superior", -1, 1, 1, VV_SPACE_RAS, "mm"},
        {"LAS", -1, 1, 1, VV_SPACE_RAS, "mm"},
        {"left-posterior-superior", -1, -1, 1, VV_SPACE_RAS, "mm"},
        {"LPS", -1, -1, 1, VV_SPACE_RAS, "mm"},
        {"scanner-xyz", 1, 1, 1, VV_SPACE_PLAIN, "units"},
        {"3D-right-handed", 1, 1, 1, VV_SPACE_PLAIN, "units"},
        {"3D-left-handed", 1, 1, -1, VV_SPACE_PLAIN, "units"},
    };
    for (size_t i = 0; i < sizeof spaces / sizeof *spaces; i++) {
        char header[400];
        snprintf(header, sizeof header,
                 U8_3D "space: %s\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\n\n",
                 spaces[i].space);
        vv_file *file = open_text(state, header, eight, 8);
        check_place(file, 2 * spaces[i].sx, 3 * spaces[i].sy, 4 * spaces[i].sz, 10 * spaces[i].sx, 20 * spaces[i].sy,
                    30 * spaces[i].sz);
        assert_int_equal(vv_file_info(file)->grid.space, spaces[i].kind);
        assert_string_equal(vv_file_info(file)->grid.unit, spaces[i].unit);
        vv_file_close(file);
    }
}

static void spacings_mins_and_maxs_place_nodes_and_cells(void **state)
{
    vv_file *file = open_text(state, U8_3D "spacings: 0.5 1.5 nan\nunits: \"microns\" \"um\" \"\"\n\n", eight, 8);
    check_place(file, 0.5, 1.5, 1, 0, 0, 0);
    assert_string_equal(vv_file_info(file)->grid.unit, "um");
    vv_file_close(file);
    file =
        open_text(state, U8_3D "axis mins: 10 10 nan\naxis maxs: 14 14 nan\ncenterings: node cell none\n\n", eight, 8);
    check_place(file, 4, 2, 1, 10, 11, 0); /* two nodes span 4; two cells of 2 have their centres at 11 and 13 */
    vv_file_close(file);
    file = open_text(state, U8_3D "\n", eight, 8);
    check_place(file, 1, 1, 1, 0, 0, 0);
    assert_string_equal(vv_file_info(file)->grid.unit, "voxels");
    vv_file_close(file);
}

static void axes_of_components_and_time_may_stand_anywhere(void **state)
{
    /* 2 components, 2 x 2 x 1 of space, 2 frames: 16 samples in the order of the sizes */
    static const char *const orders[] = {"vector domain domain domain time", "domain vector domain domain time",
                                         "time domain domain domain vector", "domain domain time vector domain",
                                         "domain time domain domain vector"};
    char samples[16];
    for (int i = 0; i < 16; i++)
        samples[i] = (char)i;
    for (size_t o = 0; o < 5; o++) {
        char header[400], kinds[64], sizes[32] = "";
        int role_of[5], at = 0, n_space = 0, stride[5], step = 1;
        strcpy(kinds, orders[o]);
        for (char *rest = kinds, *word; (word = strsep(&rest, " ")) != NULL; at++) {
            role_of[at] = word[0] == 'v' ? 3 : word[0] == 't' ? 4 : n_space++;
            const int n = role_of[at] == 2 ? 1 : 2;
            stride[role_of[at]] = step;
            step *= n;
            sprintf(sizes + strlen(sizes), "%d ", n);
        }
        snprintf(header, sizeof header, "NRRD0004\ntype: uchar\ndimension: 5\nsizes: %s\nkinds: %s\nencoding: raw\n\n",
                 sizes, orders[o]);
        vv_file *file = open_text(state, header, samples, 16);
        assert_int_equal(vv_file_info(file)->components, 2);
        assert_int_equal(vv_file_info(file)->n_frames, 2);
        for (int f = 0; f < 2; f++) {
            vv_field *field = io_frame(file, f);
            for (int c = 0; c < 2; c++)
                for (int j = 0; j < 2; j++)
                    for (int i = 0; i < 2; i++)
                        assert_true(vv_field_value(field, i, j, 0, c) ==
                                    i * stride[0] + j * stride[1] + c * stride[3] + f * stride[4]);
            vv_field_release(field);
        }
        vv_file_close(file);
    }
}

static void directions_of_none_are_components_first_and_time_last(void **state)
{
    char samples[24] = {0};
    vv_file *file = open_text(state,
                              "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 2 2 2\nspace: RAS\nspace directions: none "
                              "(1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n\n",
                              samples, 24);
    assert_int_equal(vv_file_info(file)->components, 3);
    vv_file_close(file);
    file =
        open_text(state,
                  "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 2 2 3\nspace: RAS\nspace directions: (1,0,0) (0,1,0) "
                  "(0,0,1) none\nencoding: raw\n\n",
                  samples, 24);
    assert_int_equal(vv_file_info(file)->n_frames, 3);
    vv_file_close(file);
}

static void vectors_of_flipped_spaces_point_the_same_way_in_ours(void **state)
{
    const float v[3] = {1, 2, 3};
    vv_file *file =
        open_text(state,
                  "NRRD0004\ntype: float\ndimension: 4\nsizes: 3 1 1 1\nspace: LPS\nspace directions: none "
                  "(1,0,0) (0,1,0) (0,0,1)\nkinds: 3-vector domain domain domain\nendian: little\nmeasurement "
                  "frame: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n\n",
                  (const char *)v, 12);
    vv_field *field = io_frame(file, 0);
    assert_int_equal(vv_field_get_info(field)->meaning, VV_MEANING_VECTOR);
    assert_true(vv_field_value(field, 0, 0, 0, 0) == -1 && vv_field_value(field, 0, 0, 0, 1) == -2 &&
                vv_field_value(field, 0, 0, 0, 2) == 3);
    assert_non_null(strstr(vv_file_warning(file, 0), "measurement frame"));
    vv_field_release(field);
    vv_file_close(file);
}

static void check_eight(vv_file *file)
{
    vv_field *field = io_frame(file, 0);
    for (int i = 0; i < 8; i++)
        assert_true(vv_field_value(field, i & 1, i >> 1 & 1, i >> 2, 0) == i);
    vv_field_release(field);
    vv_file_close(file);
}

static void lines_and_bytes_are_skipped(void **state)
{
    check_eight(open_text(state, U8_3D "line skip: 2\n\none\ntwo\n", eight, 8));
    check_eight(open_text(state, U8_3D "byte skip: 3\n\nxyz", eight, 8));
    check_eight(open_text(state, U8_3D "line skip: 1\nbyte skip: 3\n\none\nxyz", eight, 8));
    check_eight(open_text(state, U8_3D "byte skip: -1\n\nsome foreign header of unknown length", eight, 8));
}

static void data_lie_in_one_file_in_a_list_or_in_a_pattern_of_files(void **state)
{
    io_put(io_path(state, "all.raw"), "skip01234567", 12);
    for (int i = 0; i < 2; i++) {
        char name[32], slice[8];
        snprintf(name, sizeof name, "slice%03d.raw", 5 + 5 * i);
        memcpy(slice, "zz", 2);
        memcpy(slice + 2, eight + 4 * i, 4);
        io_put(io_path(state, name), slice, 6);
        snprintf(name, sizeof name, "down %d.raw", 1 - i);
        io_put(io_path(state, name), slice, 6);
    }
    const char *path = io_path(state, "h.nhdr");
    io_put(io_path(state, "eight.raw"), eight, 8);
    io_put_text(path, U8_3D "data file: eight.raw\n");
    check_eight(io_open(path));
    io_put_text(path, U8_3D "byte skip: 2\ndata file: LIST\nslice005.raw\nslice010.raw\n");
    check_eight(io_open(path));
    io_put_text(path, U8_3D "byte skip: -1\ndata file: LIST 2\nslice005.raw\nslice010.raw\n");
    check_eight(io_open(path));
    io_put_text(path, U8_3D "byte skip: 2\ndatafile: slice%03d.raw 5 10 5\n");
    check_eight(io_open(path));
    io_put_text(path, U8_3D "byte skip: 2\ndata file: ./down %d.raw 1 0 -1 2\n");
    check_eight(io_open(path));
    io_put_text(path, U8_3D "byte skip: 2\ndata file: LIST 3\nslice005.raw\nslice010.raw\n");
    check_eight(io_open(path));
    io_put_text(path, U8_3D "byte skip: 4\ndata file: LIST\nslice005.raw\n");
    io_refused(path, VV_E_FORMAT, "ends after 6 bytes; 12");
    io_put_text(path, U8_3D "data file: LIST\nslice005.raw\nslice010.raw\neight.raw\n");
    io_refused(path, VV_E_FORMAT, "do not divide");
    io_put_text(path, U8_3D "data file: LIST\nslice005.raw\nslice011.raw\n");
    io_refused(path, VV_E_READ, "slice011.raw");
    io_put(io_path(state, "slice010.raw"), "zz012", 5);
    io_put_text(path, U8_3D "byte skip: 2\ndata file: LIST\nslice005.raw\nslice010.raw\n");
    io_refused(path, VV_E_FORMAT, "slice010.raw");
}

static void text_takes_commas_and_hex_takes_spaces(void **state)
{
    vv_file *file = open_text(state, "NRRD0001\ntype: double\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n",
                              "0,1, 2\n3\t4 5e0\r\n6 7.0", 22);
    check_eight(file);
    check_eight(open_text(state, "NRRD0001\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: hex\n\n",
                          "0001 0203\n04 05 0607", 21));
}

static void keys_comments_and_units_are_metadata(void **state)
{
    vv_file *file =
        open_text(state,
                  "NRRD0005\r\n# a comment\r\ntype: uchar\r\ndimension: 3\r\nsizes: 2 2 2\r\ncontent: a head\r\n"
                  "sample units: \"HU\"\r\nDICOM_0008:x:=a\\nb\\\\c\r\nencoding: raw\r\n\r\n",
                  eight, 8);
    const char *key, *value;
    bool found = false;
    for (size_t i = 0; vv_file_metadata(file, i, &key, &value); i++)
        if (strcmp(key, "DICOM_0008:x") == 0) {
            assert_string_equal(value, "a\nb\\c");
            found = true;
        }
    assert_true(found);
    assert_string_equal(vv_file_info(file)->name, "a head");
    assert_string_equal(vv_file_info(file)->value_unit, "HU");
    check_eight(file);
}

static void a_segmentation_of_slicer_is_of_labels(void **state)
{
    vv_file *file = open_text(state, U8_3D "Segment0_ID:=Segment_1\nSegment0_LabelValue:=1\n\n", eight, 8);
    assert_int_equal(vv_file_info(file)->meaning, VV_MEANING_LABEL);
    vv_file_close(file);
}

static void one_and_two_axes_are_a_line_and_a_slice(void **state)
{
    vv_file *file = open_text(state,
                              "NRRD0004\ntype: uchar\ndimension: 2\nsizes: 4 2\nspace dimension: 3\nspace directions: "
                              "(0,2,0) (0,0,3)\nspace origin: (1,2,3)\nencoding: raw\n\n",
                              eight, 8);
    const vv_grid *grid = &vv_file_info(file)->grid;
    assert_int_equal(grid->dims[2], 1);
    assert_float_equal(grid->index_to_world.axis[2].x, 2, 1e-12); /* right-handed, as thick as the finer step */
    assert_true(vv_affine_determinant(grid->index_to_world) > 0);
    vv_file_close(file);
    file = open_text(state, "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 8\nspacings: 2\nencoding: raw\n\n", eight, 8);
    assert_int_equal(vv_file_info(file)->grid.dims[0], 8);
    assert_float_equal(vv_grid_spacing(&vv_file_info(file)->grid, 2), 2, 1e-12);
    vv_file_close(file);
}

static void plain_samples_are_mapped_where_they_lie(void **state)
{
    vv_file *file = open_text(state, U8_3D "\n", eight, 8);
    assert_true(vv_file_mappable(file));
    vv_file_close(file);
    file = open_text(state, "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: hex\n\n", "0001020304050607",
                     16);
    assert_false(vv_file_mappable(file));
    vv_file_close(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spaces_come_to_right_front_up),
        cmocka_unit_test(spacings_mins_and_maxs_place_nodes_and_cells),
        cmocka_unit_test(axes_of_components_and_time_may_stand_anywhere),
        cmocka_unit_test(directions_of_none_are_components_first_and_time_last),
        cmocka_unit_test(vectors_of_flipped_spaces_point_the_same_way_in_ours),
        cmocka_unit_test(lines_and_bytes_are_skipped),
        cmocka_unit_test(data_lie_in_one_file_in_a_list_or_in_a_pattern_of_files),
        cmocka_unit_test(text_takes_commas_and_hex_takes_spaces),
        cmocka_unit_test(keys_comments_and_units_are_metadata),
        cmocka_unit_test(a_segmentation_of_slicer_is_of_labels),
        cmocka_unit_test(one_and_two_axes_are_a_line_and_a_slice),
        cmocka_unit_test(plain_samples_are_mapped_where_they_lie),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
