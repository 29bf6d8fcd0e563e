/* Names, colours and windows of channels and labels: through our writers and back, and in files that lie. */
#include "fail_alloc.h"
#include "fields.h"
#include "io_test.h"
#include <volvis/image.h>

static const vv_label labels[] = {
    {0, "nothing <at> all & more", true, {1, 1, 1, 0}},
    {2, "with \\ and \n in it", true, {0.5, 0, 0.25, 0.5}},
    {3, "", true, {0, 1, 0, 1}},
    {65000, "no colour", false, {0, 0, 0, 0}},
};
#define N_LABELS (sizeof labels / sizeof *labels)

static const vv_channel channels[] = {
    {"nuclei", true, {0, 0, 1, 1}, 100, 4000.5},
    {"", false, {0, 0, 0, 0}, 0, 0},
    {"membrane", true, {1, 0, 0.5, 1}, -5, 1e9},
};
#define N_CHANNELS (sizeof channels / sizeof *channels)

static vv_field *make_field(int components, vv_meaning meaning)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 5, info.grid.dims[1] = 3, info.grid.dims[2] = 2;
    info.type = VV_TYPE_U16;
    info.components = components;
    info.meaning = meaning;
    return test_field_random(&info, 11, NULL);
}

static vv_status write_names(const char *path, const vv_field *field)
{
    vv_write_options options;
    vv_write_options_init(&options, sizeof options);
    options.labels = labels;
    options.n_labels = N_LABELS;
    options.channels = channels;
    options.n_channels = N_CHANNELS;
    return vv_field_write(path, &field, 1, &options, NULL);
}

static void assert_color(vv_color got, vv_color want)
{
    assert_true(fabs(got.r - want.r) < 1e-5 && fabs(got.g - want.g) < 1e-5 && fabs(got.b - want.b) < 1e-5 &&
                fabs(got.a - want.a) < 1e-5);
}

static void labels_come_back_from_nrrd_and_nifti(void **state)
{
    static const char *const names[] = {"l.nrrd", "l.nhdr", "l.nii", "l.nii.gz", "l.hdr"};
    vv_field *field = make_field(1, VV_MEANING_LABEL);
    for (size_t f = 0; f < sizeof names / sizeof *names; f++) {
        size_t n;
        io_ok(write_names(io_path(state, names[f]), field));
        vv_file *file = io_open(io_path(state, names[f]));
        assert_int_equal(vv_file_info(file)->meaning, VV_MEANING_LABEL);
        const vv_label *got = vv_file_labels(file, &n);
        assert_int_equal(n, N_LABELS);
        for (size_t i = 0; i < n; i++) {
            assert_int_equal(got[i].value, labels[i].value);
            if (i == 1 && strncmp(names[f], "l.n", 3) == 0 && strstr(names[f], "r"))
                assert_string_equal(got[i].name, labels[i].name);
            if (i != 1)
                assert_string_equal(got[i].name, labels[i].name);
            assert_int_equal(got[i].has_color, labels[i].has_color);
            if (labels[i].has_color)
                assert_color(got[i].color, labels[i].color);
        }
        vv_field *back = io_frame(file, 0);
        io_same_samples(back, field);
        vv_field_release(back);
        vv_file_close(file);
    }
    vv_field_release(field);
}

static void channels_come_back_from_nrrd(void **state)
{
    size_t n;
    vv_field *field = make_field((int)N_CHANNELS, VV_MEANING_SCALAR);
    io_ok(write_names(io_path(state, "c.nrrd"), field));
    vv_file *file = io_open(io_path(state, "c.nrrd"));
    const vv_channel *got = vv_file_channels(file, &n);
    assert_int_equal(n, N_CHANNELS);
    for (size_t i = 0; i < n; i++) {
        assert_string_equal(got[i].name, channels[i].name);
        assert_int_equal(got[i].has_color, channels[i].has_color);
        if (channels[i].has_color)
            assert_color(got[i].color, channels[i].color);
        assert_true(got[i].lo == channels[i].lo && got[i].hi == channels[i].hi);
    }
    vv_file_close(file);
    vv_field_release(field);
}

/* Segments ----------------------------------------------------------------------------------------------------------
 */

/* Three layers of 2 x 1 x 1 in a list that is the fastest axis: their samples are 10 and 13, 11 and 14, 12 and 15. */
static void put_layers(void **state)
{
    io_put_text(io_path(state, "s.nrrd"),
                "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 2 1 1\nkinds: list domain domain domain\n"
                "encoding: ascii\nSegment0_ID:=a\nSegment0_Layer:=1\nSegment0_LabelValue:=14\nSegment0_Name:=left\n"
                "Segment1_ID:=b\nSegment1_Layer:=1\nSegment1_LabelValue:=14\nSegment1_Name:=again\n"
                "Segment7_ID:=c\nSegment7_Name:=old\nSegment7_Color:=1 0 0\n\n10 11 12 13 14 15\n");
}

static vv_file *open_part(const char *path, const char *part)
{
    vv_read_options options;
    vv_file *file;
    vv_read_options_init(&options, sizeof options);
    options.part = part;
    return vv_file_open(&file, path, &options, NULL) == VV_OK ? file : NULL;
}

static void layers_of_segments_are_parts_of_the_file(void **state)
{
    vv_part part;
    size_t n;
    put_layers(state);
    for (int layer = 0; layer < 3; layer++) {
        char name[16];
        snprintf(name, sizeof name, "layer%d", layer);
        vv_file *file = open_part(io_path(state, "s.nrrd"), layer ? name : NULL);
        assert_non_null(file);
        assert_int_equal(vv_file_info(file)->meaning, VV_MEANING_LABEL);
        assert_int_equal(vv_file_info(file)->components, 1);
        for (size_t i = 0; i < 3; i++)
            assert_true(vv_file_part(file, i, &part) && part.chosen == (i == (size_t)layer));
        assert_false(vv_file_part(file, 3, &part));
        vv_field *field = io_frame(file, 0);
        assert_int_equal(vv_field_value(field, 0, 0, 0, 0), 10 + layer);
        assert_int_equal(vv_field_value(field, 1, 0, 0, 0), 13 + layer);
        const vv_label *got = vv_file_labels(file, &n);
        assert_int_equal(n, layer == 2 ? 0 : 1);
        if (layer == 0) { /* a segment of an older Slicer has the number after its own as its label */
            assert_int_equal(got[0].value, 8);
            assert_string_equal(got[0].name, "old");
            assert_true(got[0].has_color && got[0].color.r == 1);
        } else if (layer == 1) {
            assert_string_equal(got[0].name, "left"); /* the other of its label is left out with a warning */
            assert_non_null(strstr(vv_file_warning(file, 0), "label 14"));
        }
        vv_field_release(field);
        vv_file_close(file);
    }
    assert_null(open_part(io_path(state, "s.nrrd"), "layer3"));
    assert_non_null(strstr(vv_error_last()->message, "layer0 to layer2"));
}

static void a_part_that_a_file_does_not_have_is_an_error(void **state)
{
    vv_field *field = make_field(1, VV_MEANING_SCALAR);
    io_ok(write_names(io_path(state, "p.nrrd"), field));
    assert_null(open_part(io_path(state, "p.nrrd"), "raw"));
    assert_non_null(strstr(vv_error_last()->message, "one data set"));
    vv_field_release(field);
}

/* Files that lie ----------------------------------------------------------------------------------------------------
 */

static vv_status read_names(const char *path)
{
    vv_file *file;
    vv_field *field = NULL;
    size_t n;
    vv_status st = vv_file_open(&file, path, NULL, NULL);
    if (st != VV_OK)
        return st;
    const vv_label *got = vv_file_labels(file, &n);
    for (size_t i = 0; i < n; i++)
        assert_true(memchr(got[i].name, 0, sizeof got[i].name) != NULL && got[i].color.r >= 0 && got[i].color.r <= 1);
    st = vv_file_read(&field, file, 0, NULL, NULL);
    vv_field_release(field);
    vv_file_close(file);
    return st;
}

static void put_afni(const char *path)
{
    static const char table[] =
        "<AFNI_attributes>\n<AFNI_atr\n ni_type=\"String\"\n atr_name=\"VALUE_LABEL_DTABLE\" >\n \"&lt;VALUE_LABEL_"
        "DTABLE&#x0a; ni_dimen=&quot;2&quot; &gt;&#x0a;&quot;1&quot; &quot;left &amp;amp; right&quot; &quot;2&quot; "
        "'&#233;' \"1\" \"twice\" 77 bare &lt;/VALUE_LABEL_DTABLE&gt;\"\n</AFNI_atr>\n</AFNI_attributes>\n";
    uint8_t bytes[352 + 400 + 2] = {0x5c, 1, [40] = 3, [42] = 2, [44] = 1, [46] = 1, [48] = 1, [70] = 2, [72] = 8};
    const float offset = 352 + 400;
    memcpy(bytes + 108, &offset, 4);
    memcpy(bytes + 344, "n+1", 4);
    for (int i = 0; i < 4; i++)
        memcpy(bytes + 76 + 4 * i, &(float){1}, 4);
    bytes[348] = 1;
    bytes[352] = 400 % 256, bytes[353] = 400 / 256, bytes[356] = 4;
    memcpy(bytes + 360, table, sizeof table - 1);
    io_put(path, bytes, sizeof bytes);
}

static void the_table_of_afni_names_labels(void **state)
{
    size_t n;
    put_afni(io_path(state, "afni.nii"));
    vv_file *file = io_open(io_path(state, "afni.nii"));
    assert_int_equal(vv_file_info(file)->meaning, VV_MEANING_LABEL);
    const vv_label *got = vv_file_labels(file, &n);
    assert_int_equal(n, 3);
    assert_string_equal(got[0].name, "left & right");
    assert_string_equal(got[1].name, "\xc3\xa9");
    assert_int_equal(got[2].value, 77);
    assert_string_equal(got[2].name, "bare");
    vv_file_close(file);
}

static void make_seed(void **state, int which, char path[4096])
{
    static const char *const names[] = {"m.nrrd", "m.nii", "afni.nii", "s.nrrd"};
    snprintf(path, 4096, "%s", io_path(state, names[which]));
    vv_field *field = make_field(1, VV_MEANING_LABEL);
    if (which < 2)
        io_ok(write_names(path, field));
    else if (which == 2)
        put_afni(path);
    else
        put_layers(state);
    vv_field_release(field);
}

static void mutated_and_cut_files_are_read_or_refused(void **state)
{
    const uint64_t random = test_seed();
    uint64_t next = 0;
    for (int which = 0; which < 4; which++) {
        size_t n;
        char path[4096];
        make_seed(state, which, path);
        uint8_t *bytes = io_get(path, &n), *mutant = malloc(n);
        for (size_t m = 0; m < 2000; m++) {
            const size_t keep = m < n ? m : n;
            memcpy(mutant, bytes, n);
            for (int changes = (int)(test_random(random, next++) % 5); changes > 0; changes--) {
                const size_t at = test_random(random, next++) % n;
                mutant[at] = (uint8_t)test_random(random, next++);
            }
            io_put(path, mutant, m % 2 ? n : keep);
            if (read_names(path) != VV_OK)
                assert_true(vv_error_last()->message[0]);
        }
        free(mutant);
        free(bytes);
    }
}

typedef struct acting {
    char path[4096];
    const vv_field *field;
} acting;

static vv_status act_read(void *user)
{
    return read_names(((acting *)user)->path);
}

static vv_status act_write(void *user)
{
    return write_names(((acting *)user)->path, ((acting *)user)->field);
}

static void every_allocation_may_fail(void **state)
{
    vv_field *field = make_field(1, VV_MEANING_LABEL);
    acting a = {.field = field};
    for (int which = 0; which < 4; which++) {
        make_seed(state, which, a.path);
        assert_true(test_fail_each_alloc(act_read, &a) > 3);
        assert_true(which >= 2 || test_fail_each_alloc(act_write, &a) >= 1);
    }
    vv_field_release(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(labels_come_back_from_nrrd_and_nifti),
        cmocka_unit_test(channels_come_back_from_nrrd),
        cmocka_unit_test(layers_of_segments_are_parts_of_the_file),
        cmocka_unit_test(a_part_that_a_file_does_not_have_is_an_error),
        cmocka_unit_test(the_table_of_afni_names_labels),
        cmocka_unit_test(mutated_and_cut_files_are_read_or_refused),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
