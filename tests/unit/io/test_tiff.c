/* TIFF, MRC: boxes, mapping, headers that lie. What other programs write and read is in oracle_tiff.py, oracle_mrc.py.
 */
#include "fields.h"
#include "io_test.h"
#include "jobs.h"

static vv_field *some_field(const int64_t dims[3], vv_type type, int components)
{
    vv_field_info info = vv_field_info_default();
    memcpy(info.grid.dims, dims, sizeof info.grid.dims);
    info.type = type;
    info.components = components;
    return test_field_random(&info, 5, NULL);
}

static void check_box(const vv_field *whole, const vv_field *part, const vv_box *box)
{
    const vv_field_info *info = vv_field_get_info(whole);
    assert_memory_equal(vv_field_get_info(part)->grid.dims, box->n, sizeof box->n);
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            for (int64_t i = 0; i < box->n[0]; i++)
                for (int c = 0; c < info->components; c++)
                    assert_float_equal(vv_field_value(part, i, j, k, c),
                                       vv_field_value(whole, box->lo[0] + i, box->lo[1] + j, box->lo[2] + k, c), 0);
}

static void boxes_are_parts_of_the_whole(void **state)
{
    static const struct {
        const char *name, *encoding;
        int components;
        vv_type type;
    } files[] = {{"a.tif", "raw", 1, VV_TYPE_U16},     {"b.tif", "deflate", 1, VV_TYPE_U8},
                 {"c.tif", "lzw", 3, VV_TYPE_U16},     {"d.ome.tif", "zstd", 2, VV_TYPE_F32},
                 {"e.ome.tif", "raw", 2, VV_TYPE_I16}, {"f.mrc", NULL, 1, VV_TYPE_F32}};
    static const int64_t dims[3] = {401, 397, 5};
    static const vv_box boxes[] = {{{0, 0, 0}, {401, 397, 5}},
                                   {{400, 396, 4}, {1, 1, 1}},
                                   {{3, 2, 1}, {11, 390, 3}},
                                   {{0, 395, 0}, {401, 2, 5}},
                                   {{7, 0, 2}, {1, 397, 1}}};
    for (size_t f = 0; f < sizeof files / sizeof *files; f++) {
        vv_field *field = some_field(dims, files[f].type, files[f].components);
        io_write(io_path(state, files[f].name), field, files[f].encoding, f % 2);
        vv_file *file = io_open(io_path(state, files[f].name));
        for (size_t b = 0; b < sizeof boxes / sizeof *boxes; b++) {
            vv_field *part;
            io_ok(vv_file_read(&part, file, 0, &boxes[b], NULL));
            check_box(field, part, &boxes[b]);
            vv_field_release(part);
        }
        vv_file_close(file);
        vv_field_release(field);
    }
}

/* Damaged pages do not hurt a box that does not touch them. */
static void boxes_read_their_pages_alone(void **state)
{
    static const int64_t dims[3] = {61, 67, 9};
    const char *path = io_path(state, "p.tif");
    vv_field *field = some_field(dims, VV_TYPE_U16, 1), *part;
    io_write(path, field, "deflate", false);
    size_t n;
    uint8_t *bytes = io_get(path, &n);
    memset(bytes + n - 2000, 0x55, 2000); /* in the last page */
    io_put(path, bytes, n);
    free(bytes);
    vv_file *file = io_open(path);
    const vv_box good = {{0, 0, 0}, {61, 67, 8}}, last = {{0, 0, 8}, {61, 67, 1}};
    vv_job *job;
    io_ok(vv_job_new(&job, NULL, NULL, NULL));
    io_ok(vv_file_read(&part, file, 0, &good, job));
    check_box(field, part, &good);
    assert_false(vv_job_damaged(job));
    vv_field_release(part);
    assert_int_equal(vv_file_read(&part, file, 0, &last, job), VV_E_FORMAT);
    io_ok(vv_file_read(&part, file, 0, NULL, job));
    assert_true(vv_job_damaged(job));
    vv_field_release(part);
    vv_job_release(job);
    vv_file_close(file);
    vv_field_release(field);
}

static void uncompressed_files_are_mapped(void **state)
{
    static const int64_t dims[3] = {7, 5, 3};
    static const char *const names[] = {"m.tif", "m.ome.tif", "m.mrc"};
    for (size_t i = 0; i < 3; i++) {
        vv_field *field = some_field(dims, VV_TYPE_F32, 1);
        io_write(io_path(state, names[i]), field, "raw", false);
        vv_file *file = io_open(io_path(state, names[i]));
        assert_true(vv_file_mappable(file));
        vv_field *back = io_frame(file, 0);
        io_same_samples(field, back);
        vv_field_release(back);
        vv_file_close(file);
        vv_field_release(field);
    }
}

/* Headers that lie ------------------------------------------------------------------------------------------------- */

/* Where the value of a tag lies in the first directory of a little-endian file. */
static size_t value_of(const uint8_t *bytes, unsigned tag)
{
    const size_t at = bytes[4] | (size_t)bytes[5] << 8, n = bytes[at] | (size_t)bytes[at + 1] << 8;
    for (size_t i = 0; i < n; i++) {
        const size_t entry = at + 2 + 12 * i;
        if ((bytes[entry] | (unsigned)bytes[entry + 1] << 8) == tag)
            return entry + 8;
    }
    fail_msg("no tag %u", tag);
    return 0;
}

static void tiff_headers_that_lie(void **state)
{
    static const struct {
        unsigned tag;
        uint32_t value;
        vv_status status;
        const char *words;
    } lies[] = {
        {256, 0, VV_E_FORMAT, "0 x 5 pixels"},
        {256, 0xffffffffu, VV_E_FORMAT, "pixels"},
        {257, 0, VV_E_FORMAT, "7 x 0 pixels"},
        {258, 24, VV_E_UNSUPPORTED, "24-bit"},
        {258, 0, VV_E_UNSUPPORTED, "0-bit"},
        {259, 6, VV_E_UNSUPPORTED, "JPEG of TIFF 6.0"},
        {259, 34712, VV_E_UNSUPPORTED, "34712"},
        {262, 6, VV_E_UNSUPPORTED, "YCbCr"},
        {277, 0, VV_E_FORMAT, "0 samples"},
        {277, 60000, VV_E_FORMAT, "60000 samples"},
        {278, 0, VV_E_FORMAT, "strips"},
        {278, 1, VV_E_FORMAT, "1 of the 5"},
        {284, 3, VV_E_FORMAT, "PlanarConfiguration"},
        {339, 6, VV_E_UNSUPPORTED, "complex"},
    };
    static const int64_t dims[3] = {7, 5, 1};
    const char *path = io_path(state, "l.tif");
    vv_field *field = some_field(dims, VV_TYPE_U16, 1);
    io_write(path, field, "raw", false);
    vv_field_release(field);
    size_t n;
    uint8_t *bytes = io_get(path, &n), *lie = malloc(n);
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        memcpy(lie, bytes, n);
        const size_t at = value_of(bytes, lies[i].tag);
        for (int b = 0; b < (bytes[at - 6] == 3 ? 2 : 4); b++)
            lie[at + (size_t)b] = (uint8_t)(lies[i].value >> 8 * b);
        io_put(path, lie, n);
        io_refused(path, lies[i].status, lies[i].words);
    }
    free(lie);
    free(bytes);
}

static void tiff_chains_that_lie(void **state)
{
    const char *path = io_path(state, "c.tif");
    io_put(path, "II*\0\0\0\0\0", 8);
    io_refused(path, VV_E_FORMAT, "without pages");
    io_put(path, "II*\0\xff\xff\0\0", 8);
    io_refused(path, VV_E_FORMAT, "byte 65535");
    io_put(path, "II*\0\x08\0\0\0\0\0\0\0\0\0", 14);
    io_refused(path, VV_E_FORMAT, "0 entries");
    io_put(path, "II+\0\x04\0\0\0\x10\0\0\0\0\0\0\0", 16);
    io_refused(path, VV_E_FORMAT, "instead of 8");
    static const int64_t dims[3] = {7, 5, 2};
    vv_field *field = some_field(dims, VV_TYPE_U8, 1);
    io_write(path, field, "raw", false);
    size_t n;
    uint8_t *bytes = io_get(path, &n);
    const size_t first = bytes[4] | (size_t)bytes[5] << 8, entries = bytes[first];
    memcpy(bytes + first + 2 + 12 * entries, bytes + 4, 4); /* the next page is the first */
    io_put(path, bytes, n);
    vv_file *file = io_open(path);
    assert_true(vv_file_info(file)->grid.dims[2] <= 2);
    assert_non_null(vv_file_warning(file, 0));
    vv_file_close(file);
    free(bytes);
    vv_field_release(field);
}

static void mrc_headers_that_lie(void **state)
{
    static const struct {
        int at;
        uint32_t value;
        vv_status status;
        const char *words;
    } lies[] = {
        {0, 0, VV_E_FORMAT, "dims 0"},
        {4, 0x80000000u, VV_E_FORMAT, "either byte order"},
        {12, 3, VV_E_UNSUPPORTED, "complex"},
        {12, 4, VV_E_UNSUPPORTED, "complex"},
        {12, 5, VV_E_UNSUPPORTED, "mode 5"},
        {12, 77, VV_E_FORMAT, "mode 77"},
        {8, 90000, VV_E_FORMAT, "expected"},
        {92, 100000, VV_E_FORMAT, "expected"},
        {92, 0xfffffff0u, VV_E_FORMAT, "either byte order"},
        {64, 3, VV_E_FORMAT, "either byte order"},
    };
    static const int64_t dims[3] = {7, 5, 3};
    const char *path = io_path(state, "l.mrc");
    vv_field *field = some_field(dims, VV_TYPE_F32, 1);
    io_write(path, field, NULL, false);
    vv_field_release(field);
    size_t n;
    uint8_t *bytes = io_get(path, &n), *lie = malloc(n);
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        memcpy(lie, bytes, n);
        for (int b = 0; b < 4; b++)
            lie[lies[i].at + b] = (uint8_t)(lies[i].value >> 8 * b);
        io_put(path, lie, n);
        io_refused(path, lies[i].status, lies[i].words);
    }
    free(lie);
    free(bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(boxes_are_parts_of_the_whole, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(boxes_read_their_pages_alone, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(uncompressed_files_are_mapped, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(tiff_headers_that_lie, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(tiff_chains_that_lie, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(mrc_headers_that_lie, io_setup, io_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
