/* PVM volumes, plain and packed by an encoder of our own that uses every width of difference. */
#include "io_test.h"
#include "jobs.h"

#define MOST 4096

typedef struct packer {
    uint8_t out[2 * MOST];
    size_t n_bits;
} packer;

static void put_bits(packer *p, unsigned value, int n)
{
    for (int i = n - 1; i >= 0; i--, p->n_bits++)
        if (value >> i & 1)
            p->out[p->n_bits / 8] |= (uint8_t)(128 >> p->n_bits % 8);
}

/* The code of the format's description; runs are of 1, 2, 3, ... bytes and as wide as they must be, or wider. */
static size_t pack(uint8_t *out, const uint8_t *in, size_t n, unsigned sample, unsigned row, int version)
{
    packer p = {{0}, 0};
    uint8_t apart[MOST];
    size_t used = 0, run = 0;
    for (unsigned part = 0; part < sample; part++)
        for (size_t i = part; i < n; i += sample)
            apart[used++] = in[i];
    put_bits(&p, sample - 1, 2);
    put_bits(&p, row - 1, 16);
    for (size_t at = 0; at < n;) {
        const size_t count = run % 127 + 1 < n - at ? run % 127 + 1 : n - at;
        int code = (int)(run % 3), width = 0;
        uint8_t difference[127];
        for (size_t i = 0; i < count; i++) {
            const size_t j = at + i;
            int guess = j ? apart[j - 1] : 0;
            if (row > 1 && j > row)
                guess += apart[j - row] - apart[j - row - 1];
            difference[i] = (uint8_t)(apart[j] - guess);
        }
        for (;; code++) { /* the narrowest that holds all of them, from run % 3 on */
            bool fits = true;
            width = code ? code + 1 : 0;
            for (size_t i = 0; i < count; i++) {
                const int d = (int8_t)difference[i], half = width ? 1 << (width - 1) : 0;
                fits &= width ? d >= -half && d < half : d == 0;
            }
            if (fits)
                break;
        }
        put_bits(&p, (unsigned)count, 7);
        put_bits(&p, (unsigned)code, 3);
        for (size_t i = 0; i < count; i++)
            put_bits(&p, (unsigned)((int8_t)difference[i] + (width ? 1 << (width - 1) : 0)), width);
        at += count;
        run++;
    }
    put_bits(&p, 0, 7);
    memcpy(out, version == 1 ? "DDS v3d\n" : "DDS v3e\n", 8);
    memcpy(out + 8, p.out, (p.n_bits + 7) / 8);
    return 8 + (p.n_bits + 7) / 8;
}

/* A header, smooth and rough samples, and the texts of PVM3. */
static size_t make(uint8_t *out, int version, int bytes)
{
    int n = snprintf((char *)out, MOST, "PVM%s\n7 5 3\n%s%d\n",
                     version == 3   ? "3"
                     : version == 2 ? "2"
                                    : "",
                     version > 1 ? "1 1.5 2\n" : "", bytes);
    for (int i = 0; i < 105 * bytes; i++)
        out[n + i] = (uint8_t)(i < 60 ? i * 3 : i * i * 17 + i / 7);
    n += 105 * bytes;
    if (version == 3) {
        memcpy(out + n, "what\0who\0\0said", 15);
        n += 15;
    }
    return (size_t)n;
}

static void expect_samples(vv_field *field, const uint8_t *samples, int bytes)
{
    for (int i = 0; i < 105; i++)
        for (int c = 0; c < (bytes == 2 ? 1 : bytes); c++)
            assert_float_equal(vv_field_value(field, i % 7, i / 7 % 5, i / 35, c),
                               bytes == 2 ? samples[2 * i] * 256 + samples[2 * i + 1] : samples[i * bytes + c], 0);
}

static void plain_and_packed_volumes_are_read(void **state)
{
    uint8_t plain[MOST], packed[2 * MOST];
    for (int version = 1; version <= 3; version++)
        for (int bytes = 1; bytes <= 4; bytes++)
            for (int dds = 0; dds <= 2; dds++) {
                const size_t n = make(plain, version, bytes);
                const size_t n_packed = dds ? pack(packed, plain, n, (unsigned)bytes, bytes % 2 ? 7 : 1, dds) : n;
                io_put(io_path(state, "t.pvm"), dds ? packed : plain, n_packed);
                vv_file *file = io_open(io_path(state, "t.pvm"));
                vv_field *field = io_frame(file, 0);
                const char *key, *value;
                assert_int_equal(vv_file_info(file)->type, bytes == 2 ? VV_TYPE_U16 : VV_TYPE_U8);
                assert_int_equal(vv_file_info(file)->components, bytes > 2 ? bytes : 1);
                assert_float_equal(vv_grid_spacing(&vv_file_info(file)->grid, 1), version > 1 ? 1.5 : 1, 0);
                expect_samples(field, plain + n - (version == 3 ? 15 : 0) - (size_t)(105 * bytes), bytes);
                assert_int_equal(vv_file_metadata(file, 2, &key, &value), version == 3);
                assert_true(version < 3 || (strcmp(key, "comment") == 0 && strcmp(value, "said") == 0));
                vv_field_release(field);
                vv_file_close(file);
            }
}

static void a_header_that_ends_as_a_c_string_is_read(void **state)
{
    io_put(io_path(state, "z.pvm"), "PVM\n2 1 1\n1\n\0\5\6", 15);
    vv_file *file = io_open(io_path(state, "z.pvm"));
    vv_field *field = io_frame(file, 0);
    assert_float_equal(vv_field_value(field, 0, 0, 0, 0), 5, 0);
    vv_field_release(field);
    vv_file_close(file);
}

static void a_stream_that_is_cut_short_gives_what_is_there(void **state)
{
    uint8_t plain[MOST], packed[2 * MOST];
    const size_t n = make(plain, 2, 1), n_packed = pack(packed, plain, n, 1, 7, 1);
    int whole = 0, damaged = 0;
    for (size_t keep = 0; keep < n_packed; keep++) {
        vv_job *job;
        vv_file *file;
        vv_field *field;
        io_put(io_path(state, "c.pvm"), packed, keep);
        io_ok(vv_job_new(&job, NULL, NULL, NULL));
        if (vv_file_open(&file, io_path(state, "c.pvm"), NULL, job) == VV_OK) {
            if (vv_file_read(&field, file, 0, NULL, job) == VV_OK) {
                assert_memory_equal(vv_field_get_info(field)->grid.dims, ((int64_t[]){7, 5, 3}), 24);
                whole += !vv_job_damaged(job);
                damaged += vv_job_damaged(job);
                vv_field_release(field);
            }
            vv_file_close(file);
        } else {
            assert_null(strchr(vv_error_last()->message, '\n'));
        }
        vv_job_release(job);
    }
    assert_true(whole <= 2 && damaged > 10); /* the stop mark may be cut */
}

static void each_lie_is_one_sentence(void **state)
{
    static const struct {
        const char *text, *words;
    } lies[] = {
        {"PVM\n0 1 1\n1\nab", "'0 1 1' should be the samples"},
        {"PVM\n1 1\n1\nab", "'1 1' should be"},
        {"PVM\n9999999 1 1\n1\nab", "9999999"},
        {"PVM\n1000 1000 1000\n1\nab", "were expected"},
        {"PVM\n2 1 1\n5\nab", "bytes of a sample"},
        {"PVM2\n2 1 1\n1 0 1\n1\nab", "more than 0"},
        {"PVM2\n2 1 1\n1 nan 1\n1\nab", "spacing"},
        {"PVM3\n2 1 1\n1 1 1\n", "ends before the bytes of a sample"},
        {"DDS v3d\n", "ends before its first line"},
        {"DDS v3d\nxyzzyxyzzyxyzzyxyzzy", ""},
    };
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        io_put_text(io_path(state, "l.pvm"), lies[i].text);
        io_refused(io_path(state, "l.pvm"), VV_E_FORMAT, lies[i].words);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plain_and_packed_volumes_are_read),
        cmocka_unit_test(a_header_that_ends_as_a_c_string_is_read),
        cmocka_unit_test(a_stream_that_is_cut_short_gives_what_is_there),
        cmocka_unit_test(each_lie_is_one_sentence),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
