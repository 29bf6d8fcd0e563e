/* DICOM files that are cut, changed or lie: read, or one sentence; never other dims, never a crash. */
#include "config.h"
#include "dicoms.h"
#include "fields.h"
#include "io_test.h"
#include "registry.h"

static bool is_possible(test_dicom kind)
{
#if VV_HAVE_GDCM
    return true;
#else
    return kind < TEST_DICOM_JPEG_LS;
#endif
}

static vv_status read_file(const char *path, vv_field **out, vv_job *job)
{
    vv_file *file;
    *out = NULL;
    vv_status st = vv_file_open(&file, path, NULL, job);
    if (st == VV_OK) {
        st = vv_file_read(out, file, vv_file_info(file)->n_frames - 1, NULL, job);
        vv_file_close(file);
    }
    return st;
}

static const char *put_seed(void **state, const uint8_t *bytes, size_t n)
{
    const char *path = io_path(state, "s.dcm");
    io_put(path, bytes, n);
    return path;
}

static void every_dialect_has_its_samples(void **state)
{
    for (int kind = 0; kind < TEST_DICOMS; kind++) {
        size_t n;
        vv_field *field;
        if (!is_possible((test_dicom)kind))
            continue;
        uint8_t *bytes = test_dicom_make((test_dicom)kind, NULL, &n);
        io_ok(read_file(put_seed(state, bytes, n), &field, NULL));
        const vv_field_info *info = vv_field_get_info(field);
        const bool stacked = kind == TEST_DICOM_ENHANCED || kind == TEST_DICOM_NESTED || kind == TEST_DICOM_DOSE;
        assert_int_equal(info->grid.dims[2], stacked ? 2 : 1);
        assert_int_equal(info->n_frames, kind == TEST_DICOM_CINE ? 2 : 1);
        for (int i = 0; i < 64; i++)
            assert_float_equal(vv_field_value(field, i % 8, i / 8, info->grid.dims[2] - 1, 0), 9 * (i % 8 + i / 8),
                               kind == TEST_DICOM_BASELINE ? 5 : 0);
        assert_float_equal(vv_grid_spacing(&info->grid, 0), 0.75, 1e-12);
        if (stacked)
            assert_float_equal(vv_grid_spacing(&info->grid, 2), 2, 1e-12);
        if (kind != TEST_DICOM_CINE) {
            assert_float_equal(info->grid.index_to_world.origin.x, -1, 1e-12);
            assert_float_equal(info->grid.index_to_world.origin.z, 3, 1e-12);
        }
        vv_field_release(field);
        free(bytes);
    }
}

static void every_truncation_is_told(void **state)
{
    for (int kind = 0; kind < TEST_DICOMS; kind++) {
        size_t n;
        if (!is_possible((test_dicom)kind))
            continue;
        uint8_t *bytes = test_dicom_make((test_dicom)kind, NULL, &n);
        for (size_t keep = 0; keep < n; keep += 1 + (keep < 128) * 16) {
            vv_job *job;
            vv_field *field;
            io_ok(vv_job_new(&job, NULL, NULL, NULL));
            const vv_status st = read_file(put_seed(state, bytes, keep), &field, job);
            /* behind the last piece of packed pixels stands a mark that nobody needs */
            if (st == VV_OK && !vv_job_damaged(job) && (kind < TEST_DICOM_RLE || keep + 40 < n))
                fail_msg("%s: %zu of %zu bytes are read as a whole file", test_dicom_names[kind], keep, n);
            if (st == VV_OK)
                assert_int_equal(vv_field_get_info(field)->grid.dims[0] * vv_field_get_info(field)->grid.dims[1], 64);
            else
                assert_null(strchr(vv_error_last()->message, '\n'));
            assert_true(st == VV_OK || st == VV_E_FORMAT || st == VV_E_UNSUPPORTED);
            vv_field_release(field);
            vv_job_release(job);
        }
        free(bytes);
    }
}

static void mutate(uint8_t *bytes, size_t n, uint64_t random, uint64_t *next)
{
    for (int changes = 1 + (int)(test_random(random, (*next)++) % 4); changes > 0; changes--) {
        const size_t at = 128 + test_random(random, (*next)++) % (n - 128);
        const uint64_t how = test_random(random, (*next)++);
        bytes[at] = (uint8_t)(how & 1 ? bytes[at] ^ UINT64_C(1) << (how >> 8) % 8 : how >> 8);
    }
}

/* What GDCM unpacks is changed in the same ways each time: what its decoders do then is theirs. */
static void mutations_are_read_or_refused(void **state)
{
    for (int kind = 0; kind < TEST_DICOM_JPEG_LS; kind++) {
        size_t n;
        const uint64_t random = test_seed();
        uint64_t next = (uint64_t)kind << 32;
        uint8_t *bytes = test_dicom_make((test_dicom)kind, NULL, &n), *mutant = malloc(n);
        for (int m = 0; m < 600; m++) {
            vv_field *field;
            memcpy(mutant, bytes, n);
            mutate(mutant, n, random, &next);
            const vv_status st = read_file(put_seed(state, mutant, n), &field, NULL);
            assert_true(st == VV_OK || vv_error_last()->message[0]);
            assert_int_not_equal(st, VV_E_INTERNAL);
            vv_field_release(field);
        }
        free(mutant);
        free(bytes);
    }
}

static const struct {
    test_dicom kind;
    test_dicom_change change;
    vv_status status;
    const char *words;
} lies[] = {
    {TEST_DICOM_EXPLICIT, {0x00280010, "0", true}, VV_E_FORMAT, "number of rows is 0"},
    {TEST_DICOM_EXPLICIT, {0x00280010, NULL, true}, VV_E_FORMAT, "does not give its number of rows"},
    {TEST_DICOM_EXPLICIT, {0x00280011, "0", true}, VV_E_FORMAT, "number of columns is 0"},
    {TEST_DICOM_EXPLICIT, {0x00280010, "65535", true}, VV_E_FORMAT, "were expected for pixels"},
    {TEST_DICOM_EXPLICIT, {0x00280002, "2", true}, VV_E_UNSUPPORTED, "2 samples per pixel"},
    {TEST_DICOM_EXPLICIT, {0x00280002, "3", true}, VV_E_FORMAT, "were expected for pixels"},
    {TEST_DICOM_EXPLICIT, {0x00280100, "12", true}, VV_E_UNSUPPORTED, "12 bits per sample"},
    {TEST_DICOM_EXPLICIT, {0x00280100, NULL, true}, VV_E_FORMAT, "BitsAllocated"},
    {TEST_DICOM_EXPLICIT, {0x00280100, "64", true}, VV_E_FORMAT, "were expected for pixels"},
    {TEST_DICOM_CINE, {0x00280008, "0", false}, VV_E_FORMAT, "NumberOfFrames is 0"},
    {TEST_DICOM_CINE, {0x00280008, "9000000", false}, VV_E_FORMAT, "were expected for pixels"},
    {TEST_DICOM_CINE, {0x00280008, "99999999999", false}, VV_E_FORMAT, "NumberOfFrames is 1e+11"},
    {TEST_DICOM_EXPLICIT, {0x00020010, "1.2.3", false}, VV_E_UNSUPPORTED, "transfer syntax 1.2.3"},
    {TEST_DICOM_EXPLICIT, {0x00020010, "1.2.840.10008.1.2.5", false}, VV_E_FORMAT, "plain pixel data"},
    {TEST_DICOM_RLE, {0x00020010, "1.2.840.10008.1.2.1", false}, VV_E_FORMAT, "fragmented pixel data"},
    {TEST_DICOM_RLE, {0x00280010, "9", true}, VV_E_FORMAT, "RLE picture of frame 0 is damaged"},
    {TEST_DICOM_RLE, {0x00280011, "60000", true}, VV_E_FORMAT, "RLE picture of frame 0 is damaged"},
    {TEST_DICOM_LOSSLESS, {0x00280010, "9", true}, VV_E_FORMAT, "JPEG picture of frame 0 is damaged"},
    {TEST_DICOM_LOSSLESS, {0x00280008, "x", false}, VV_OK, ""},
    {TEST_DICOM_EXPLICIT, {0x00200032, "1e300\\1\\1", false}, VV_OK, ""},
    {TEST_DICOM_EXPLICIT, {0x00280030, "0\\0", false}, VV_OK, ""},
    {TEST_DICOM_EXPLICIT, {0x00280030, "nan\\inf", false}, VV_OK, ""},
    {TEST_DICOM_EXPLICIT, {0x00200037, "0\\0\\0\\0\\0\\0", false}, VV_OK, ""},
};

static void each_lie_of_a_header_is_one_sentence(void **state)
{
    for (size_t c = 0; c < sizeof lies / sizeof *lies; c++) {
        size_t n;
        vv_field *field;
        uint8_t *bytes = test_dicom_make(lies[c].kind, &lies[c].change, &n);
        const char *path = put_seed(state, bytes, n);
        if (lies[c].status != VV_OK) {
            io_refused(path, lies[c].status, lies[c].words);
        } else {
            io_ok(read_file(path, &field, NULL));
            vv_field_release(field);
        }
        free(bytes);
    }
}

/* An element of an undefined length inside each other, 40 deep. */
static void sequences_nest_to_a_depth(void **state)
{
    size_t n;
    uint8_t *bytes = test_dicom_make(TEST_DICOM_EXPLICIT, NULL, &n), deep[8192];
    static const uint8_t level[] = {8,    0,    0x40, 0x11, 'S', 'Q',  0,    0,    0xff, 0xff,
                                    0xff, 0xff, 0xfe, 0xff, 0,   0xe0, 0xff, 0xff, 0xff, 0xff};
    size_t at = 160;
    memcpy(deep, bytes, at);
    for (int i = 0; i < 40; i++, at += sizeof level)
        memcpy(deep + at, level, sizeof level);
    io_refused(put_seed(state, deep, at), VV_E_FORMAT, "nested more than 32 deep");
    free(bytes);
}

static void a_length_beyond_the_file_is_told(void **state)
{
    size_t n;
    uint8_t *bytes = test_dicom_make(TEST_DICOM_IMPLICIT, NULL, &n);
    for (size_t i = 0; i + 8 < n; i++)
        if (memcmp(bytes + i, "\x08\0\x60\0", 4) == 0)
            memcpy(bytes + i + 4, "\xfe\xff\xff\xff", 4);
    io_refused(put_seed(state, bytes, n), VV_E_FORMAT, "(0008,0060)");
    free(bytes);
}

/* Folders ------------------------------------------------------------------------------------------------------- */

static void a_folder_with_damaged_files_is_read_without_them(void **state)
{
    char name[32];
    for (int k = 0; k < 4; k++) {
        size_t n;
        snprintf(name, sizeof name, "1\\2\\%d", 2 * k);
        const test_dicom_change change = {0x00200032, name, false};
        uint8_t *bytes = test_dicom_make(TEST_DICOM_EXPLICIT, &change, &n);
        snprintf(name, sizeof name, "%d", k);
        /* the last lies */
        io_put(io_path(state, name), bytes, k == 3 ? n - 90 : n);
        free(bytes);
    }
    io_put_text(io_path(state, "note.txt"), "nothing");
    io_put_text(io_path(state, "empty"), "");
    vv_file *file = io_open((const char *)*state);
    assert_int_equal(vv_file_info(file)->grid.dims[2], 3);
    assert_non_null(vv_file_warning(file, 0));
    assert_non_null(strstr(vv_file_warning(file, 0), "ignored"));
    vv_field *field = io_frame(file, 0);
    vv_field_release(field);
    vv_file_close(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_dialect_has_its_samples, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(every_truncation_is_told, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(mutations_are_read_or_refused, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(each_lie_of_a_header_is_one_sentence, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(sequences_nest_to_a_depth, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(a_length_beyond_the_file_is_told, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(a_folder_with_damaged_files_is_read_without_them, io_setup, io_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
