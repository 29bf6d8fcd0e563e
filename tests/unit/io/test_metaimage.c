/* MetaImage: each way in which a header can be wrong; lists that lack files; vectors; what its keys say. Other
 * programs' files are the subject of oracle_metaimage.py. */
#include "fields.h"
#include "io_test.h"
#include "jobs.h"

#define HEAD "NDims = 3\nDimSize = 2 2 3\nElementType = MET_UCHAR\n"
#define LOCAL "ElementDataFile = LOCAL\n123456789abc"

static const struct {
    const char *text, *words;
    vv_status status;
} lies[] = {
    {"NDims = 3\nDimSize = 2 2 3\n" LOCAL, "no 'ElementType'", VV_E_FORMAT},
    {"DimSize = 2 2 3\nNDims = \nElementType = MET_UCHAR\n" LOCAL, "t.mha:2: 'NDims' is ''", VV_E_FORMAT},
    {"NDims = 5\nDimSize = 1 1 1 1 1\nElementType = MET_UCHAR\n" LOCAL, "'NDims' has 5; 1 to 4", VV_E_FORMAT},
    {"NDims = 3\nDimSize = 2 2\nElementType = MET_UCHAR\n" LOCAL, "expected 3 whole numbers", VV_E_FORMAT},
    {"NDims = 3\nDimSize = 2 2 3 4\nElementType = MET_UCHAR\n" LOCAL, "and nothing more", VV_E_FORMAT},
    {"NDims = 3\nDimSize = 2 0 3\nElementType = MET_UCHAR\n" LOCAL, "'DimSize' has 0", VV_E_FORMAT},
    {"NDims = 3\nDimSize = 2 -2 3\nElementType = MET_UCHAR\n" LOCAL, "'DimSize' has -2", VV_E_FORMAT},
    {"NDims = 3\nDimSize = 1048577 1 1\nElementType = MET_UCHAR\n" LOCAL, "1048577", VV_E_FORMAT},
    {"NDims = 4\nDimSize = 1048576 1048576 1048576 1048576\nElementType = MET_UCHAR\n" LOCAL, "more than", VV_E_FORMAT},
    {"NDims = 3\nDimSize = 1024 1024 1024\nElementType = MET_UCHAR\n" LOCAL, "were expected", VV_E_FORMAT},
    {HEAD "NDims = 3\n" LOCAL, "twice", VV_E_FORMAT},
    {"NDims = 3\nDimSize = 2 2 3\nElementType = MET_UCHR\n" LOCAL, "did you mean 'MET_UCHAR'? There are MET_CHAR, ",
     VV_E_FORMAT},
    {"NDims = 3\nDimSize = 2 2 3\nElementType = MET_STRING\n" LOCAL, "not a type of numbers", VV_E_FORMAT},
    {"ObjectType = Tube\n" HEAD LOCAL, "only an Image", VV_E_UNSUPPORTED},
    {HEAD "no value\n" LOCAL, "t.mha:4: 'no value' is not 'Key = value'", VV_E_FORMAT},
    {HEAD "CompressedData = maybe\n" LOCAL, "True or False", VV_E_FORMAT},
    {HEAD "CompressedData = True\n" LOCAL, "incorrect header check", VV_E_FORMAT},
    {HEAD "HeaderSize = -2\n" LOCAL, "-2", VV_E_FORMAT},
    {HEAD "HeaderSize = -1\nBinaryData = False\n" LOCAL, "'HeaderSize' is -1", VV_E_FORMAT},
    {HEAD "HeaderSize = 1000\n" LOCAL, "were expected", VV_E_FORMAT},
    {HEAD "BinaryData = False\nElementDataFile = LOCAL\n1 2 3 4 5 6 7 8 9 10 11 x", "'x', which is not u8",
     VV_E_FORMAT},
    {HEAD "BinaryData = False\nElementDataFile = LOCAL\n1 2 3 4 5 6 7 8 9 10 11 256", "'256', which is not u8",
     VV_E_FORMAT},
    {HEAD "ElementSpacing = 1 0 1\n" LOCAL, "spacing is 0", VV_E_FORMAT},
    {HEAD "ElementSpacing = 1 nan 1\n" LOCAL, "finite", VV_E_FORMAT},
    {HEAD "Offset = 1 1e999 1\n" LOCAL, "finite", VV_E_FORMAT},
    {HEAD "TransformMatrix = 1 0 0 0 1 0 0 0\n" LOCAL, "expected 9", VV_E_FORMAT},
    {HEAD "TransformMatrix = 1 0 0 1 0 0 0 0 1\n" LOCAL, "one plane", VV_E_FORMAT},
    {HEAD "ElementNumberOfChannels = 0\n" LOCAL, "'ElementNumberOfChannels' has 0", VV_E_FORMAT},
    {HEAD "ElementToIntensityFunctionSlope = 0\n" LOCAL, "is 0; write 1", VV_E_FORMAT},
    {HEAD, "no 'ElementDataFile'", VV_E_FORMAT},
    {HEAD "ElementDataFile =\n", "names no file", VV_E_FORMAT},
    {HEAD "ElementDataFile = missing.raw\n", "missing.raw", VV_E_READ},
    {HEAD "ElementDataFile = ../x.raw\n", "--allow-outside", VV_E_READ},
    {HEAD "ElementDataFile = /etc/passwd\n", "--allow-outside", VV_E_READ},
    {HEAD "ElementDataFile = http://a/b.raw\n", "address", VV_E_READ},
    {HEAD "ElementDataFile = LIST\na\nb\n", "2 names follow; DimSize asks for 3", VV_E_FORMAT},
    {HEAD "ElementDataFile = LIST 7\na\n", "1 to 3", VV_E_FORMAT},
    {HEAD "ElementDataFile = LIST\n../a\n../b\n../c\n", "--allow-outside", VV_E_READ},
    {HEAD "ElementDataFile = s%s.raw 1 3 1\n", "needs one %d", VV_E_FORMAT},
    {HEAD "ElementDataFile = s%d%n.raw 1 3 1\n", "needs one %d", VV_E_FORMAT},
    {HEAD "ElementDataFile = s%d.raw 1 4 1\n", "makes 4 names; DimSize asks for 3", VV_E_FORMAT},
    {HEAD "ElementDataFile = s%d.raw 1 3 0\n", "never leads", VV_E_FORMAT},
    {HEAD "ElementDataFile = s%d.raw 1 999999999 1\n", "more names", VV_E_FORMAT},
    {HEAD "ElementDataFile = s%d.raw 1 3 1 5\n", "FIRST LAST STEP", VV_E_FORMAT},
};

static void each_lie_of_a_header_is_one_sentence(void **state)
{
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        io_put_text(io_path(state, "t.mha"), lies[i].text);
        io_refused(io_path(state, "t.mha"), lies[i].status, lies[i].words);
        assert_null(strchr(vv_error_last()->message, '\n'));
    }
}

static void a_list_that_lacks_files_gives_those_that_are_there(void **state)
{
    vv_job *job;
    vv_file *file;
    vv_field *field;
    const char *path = io_path(state, "list.mhd");
    io_put_text(path, "NDims = 3\nDimSize = 2 1 4\nElementType = MET_SHORT\nElementDataFile = LIST\np1\np2\np3\np4\n");
    io_put(io_path(state, "p1"), "\1\0\2\0", 4);
    io_put(io_path(state, "p2"), "\3\0", 2); /* half of it */
    io_put(io_path(state, "p4"), "\7\0\10\0", 4);
    io_ok(vv_job_new(&job, NULL, NULL, NULL));
    io_ok(vv_file_open(&file, path, NULL, job));
    io_ok(vv_file_read(&field, file, 0, NULL, job));
    assert_true(vv_job_damaged(job));
    const double expected[8] = {1, 2, 3, 0, 0, 0, 7, 8};
    for (int i = 0; i < 8; i++)
        assert_float_equal(vv_field_value(field, i % 2, 0, i / 2, 0), expected[i], 0);
    vv_field_release(field);
    const vv_box gap = {{0, 0, 2}, {2, 1, 1}}; /* nothing of it is there */
    assert_int_equal(vv_file_read(&field, file, 0, &gap, job), VV_E_READ);
    assert_null(field);
    vv_file_close(file);
    vv_job_release(job);
    remove(io_path(state, "p4"));
    io_refused(path, VV_E_FORMAT, "p2");
}

static void a_file_that_is_cut_short_is_filled(void **state)
{
    vv_job *job;
    vv_file *file;
    vv_field *field;
    io_put_text(io_path(state, "cut.mhd"), HEAD "ElementDataFile = cut.raw\n");
    io_put(io_path(state, "cut.raw"), "\1\2\3\4\5\6\7", 7);
    io_ok(vv_job_new(&job, NULL, NULL, NULL));
    io_ok(vv_file_open(&file, io_path(state, "cut.mhd"), NULL, job));
    io_ok(vv_file_read(&field, file, 0, NULL, job));
    assert_true(vv_job_damaged(job));
    assert_float_equal(vv_field_value(field, 0, 1, 1, 0), 7, 0);
    assert_float_equal(vv_field_value(field, 1, 1, 2, 0), 0, 0);
    vv_field_release(field);
    vv_file_close(file);
    vv_job_release(job);
    io_put(io_path(state, "cut.raw"), "\1\2\3\4\5", 5);
    io_refused(io_path(state, "cut.mhd"), VV_E_FORMAT, "ends after 5 bytes; 12 were expected");
}

static void data_that_end_a_file_that_is_cut_are_not_shifted(void **state)
{
    static const char text[] = HEAD "HeaderSize = -1\n" LOCAL;
    vv_job *job;
    vv_file *file;
    vv_field *field;
    const size_t n = sizeof text - 1; /* the last 12 are the samples */
    for (size_t cut = 0; cut < 6; cut++) {
        io_put(io_path(state, "end.mha"), text, n - cut);
        io_ok(vv_job_new(&job, NULL, NULL, NULL));
        io_ok(vv_file_open(&file, io_path(state, "end.mha"), NULL, job));
        io_ok(vv_file_read(&field, file, 0, NULL, job));
        assert_int_equal(vv_job_damaged(job), cut > 0);
        for (int i = 0; i < 12; i++)
            assert_float_equal(vv_field_value(field, i % 2, i / 2 % 2, i / 4, 0),
                               i < 12 - (int)cut ? text[n - 12 + (size_t)i] : 0, 0);
        vv_field_release(field);
        vv_file_close(file);
        vv_job_release(job);
    }
}

static vv_grid grid_of(void **state, const char *text)
{
    char whole[1024];
    snprintf(whole, sizeof whole, "%s" HEAD LOCAL, text);
    io_put_text(io_path(state, "g.mha"), whole);
    vv_file *file = io_open(io_path(state, "g.mha"));
    const vv_grid grid = vv_file_info(file)->grid;
    vv_file_close(file);
    return grid;
}

static void what_is_anatomical_comes_to_right_front_top(void **state)
{
    static const struct {
        const char *text, *letters, *unit;
    } cases[] = {
        {"", "+x+y+z", "voxels"},
        {"ElementSpacing = 1 2 3\nOffset = 4 5 6\n", "+x+y+z", "units"},
        {"AnatomicalOrientation = RAI\n", "LPS", "mm"},
        {"AnatomicalOrientation = LPI\n", "RAS", "mm"},
        {"AnatomicalOrientation = SAL\n", "IPR", "mm"},
        {"AnatomicalOrientation = ???\nElementSpacing = 1 1 1\n", "+x+y+z", "units"},
        {"AnatomicalOrientation = RRI\nElementSpacing = 1 1 1\n", "+x+y+z", "units"},
        {"TransformMatrix = 1 0 0 0 1 0 0 0 1\nAnatomicalOrientation = ???\n", "+x+y+z", "voxels"},
        {"TransformMatrix = 1 0 0 0 1 0 0 0 1\n", "LPS", "mm"},
        {"Rotation = -1 0 0 0 -1 0 0 0 1\n", "RAS", "mm"},
        {"Orientation = 0 0 -1 0 1 0 1 0 0\nAnatomicalOrientation = ???\n", "IPL", "mm"},
        {"TransformMatrix = -1 0 0 0 1 0 0 0 -1\nAnatomicalOrientation = RAI\nDistanceUnits = um\n", "RPI", "um"},
        {"TransformMatrix = 1 0 0 0 1 0 0 0 1\nVolVisSpace = plain\nVolVisUnit = nanometers\n", "+x+y+z", "nm"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char letters[16];
        const vv_grid grid = grid_of(state, cases[i].text);
        vv_grid_orientation(letters, &grid);
        assert_string_equal(letters, cases[i].letters);
        assert_string_equal(grid.unit, cases[i].unit);
    }
    const vv_grid placed =
        grid_of(state, "Position = 4 5 6\nElementSize = 1 2 3\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n");
    assert_float_equal(placed.index_to_world.origin.x, -4, 0);
    assert_float_equal(placed.index_to_world.origin.y, -5, 0);
    assert_float_equal(placed.index_to_world.axis[1].y, -2, 0);
}

static void vectors_turn_with_the_axes(void **state)
{
    vv_field_info info = vv_field_info_default();
    const float in[3] = {1, 2, 3};
    info.type = VV_TYPE_F32;
    info.components = 3;
    info.meaning = VV_MEANING_VECTOR;
    info.grid.space = VV_SPACE_RAS;
    vv_field *field;
    io_ok(vv_field_new(&field, &info, in, 0, NULL, NULL, NULL));
    io_write(io_path(state, "v.mhd"), field, "raw", false);
    vv_field_release(field);
    size_t n;
    uint8_t *bytes = io_get(io_path(state, "v.raw"), &n);
    const float lps[3] = {-1, -2, 3};
    assert_int_equal(n, sizeof lps);
    assert_memory_equal(bytes, lps, sizeof lps);
    free(bytes);
    vv_file *file = io_open(io_path(state, "v.mhd"));
    vv_field *back = io_frame(file, 0);
    assert_int_equal(vv_file_info(file)->meaning, VV_MEANING_VECTOR);
    for (int c = 0; c < 3; c++)
        assert_float_equal(vv_field_value(back, 0, 0, 0, c), in[c], 0);
    vv_field_release(back);
    vv_file_close(file);
}

static void doubts_are_said_and_other_keys_are_kept(void **state)
{
    io_put_text(io_path(state, "k.mha"), "Comment = a = b\nCenterOfRotation = 1 2 3\nAnatomicalOrientation = RAI\n"
                                         "TransformMatrix = 0 1 0 1 0 0 0 0 1\nBinaryDataByteOrderMSB = True\n"
                                         "ElementByteOrderMSB = False\nModality = MET_MOD_MR\n" HEAD LOCAL);
    vv_file *file = io_open(io_path(state, "k.mha"));
    const char *key, *value;
    int comments = 0, n = 0;
    for (size_t i = 0; vv_file_metadata(file, i, &key, &value); i++) {
        comments += strcmp(key, "Comment") == 0 && strcmp(value, "a = b") == 0;
        n++;
    }
    assert_int_equal(comments, 1);
    assert_int_equal(n, 3); /* the centre and the modality as well */
    assert_non_null(strstr(vv_file_warning(file, 0), "disagree"));
    assert_non_null(strstr(vv_file_warning(file, 1), "the matrix is used"));
    assert_non_null(strstr(vv_file_warning(file, 2), "CenterOfRotation"));
    assert_null(vv_file_warning(file, 3));
    vv_file_close(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_lie_of_a_header_is_one_sentence),
        cmocka_unit_test(a_list_that_lacks_files_gives_those_that_are_there),
        cmocka_unit_test(a_file_that_is_cut_short_is_filled),
        cmocka_unit_test(data_that_end_a_file_that_is_cut_are_not_shifted),
        cmocka_unit_test(what_is_anatomical_comes_to_right_front_top),
        cmocka_unit_test(vectors_turn_with_the_axes),
        cmocka_unit_test(doubts_are_said_and_other_keys_are_kept),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
