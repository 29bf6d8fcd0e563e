/* Decoders fed in pieces of every size: the same bytes, and members that end where they end. */
#include "fields.h"
#include "io/coding.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define MOST 200000

/* Bytes that compress a little, a lot, or not at all. */
static void fill(uint8_t *out, size_t n, uint64_t seed)
{
    const uint64_t kind = test_random(seed, 0) % 3;
    for (size_t i = 0; i < n; i++)
        out[i] = (uint8_t)(kind == 0   ? test_random(seed, i)
                           : kind == 1 ? test_random(seed, i / 50) % 7
                                       : (i * i >> 9) + test_random(seed, i) % 3);
}

static size_t encode(uint8_t *out, vvi_coding coding, const uint8_t *in, size_t n, int level)
{
    vvi_encoder *encoder;
    bool done = false;
    vvi_coding_step step = {.in = in, .n_in = n, .out = out, .n_out = 2 * MOST};
    assert_int_equal(vvi_encoder_new(&encoder, coding, level, NULL), VV_OK);
    while (!done)
        assert_true(vvi_encoder_run(encoder, &step, true, &done));
    vvi_encoder_free(encoder);
    return 2 * MOST - step.n_out;
}

typedef struct feed {
    const uint8_t *coded;
    size_t n, at;
    uint8_t *out;
    size_t made;
} feed;

/* One member, in pieces of random sizes. */
static void decode_member(vvi_decoder *decoder, feed *f, uint64_t seed)
{
    bool end = false;
    for (uint64_t i = 0; !end; i++) {
        const size_t left = f->n - f->at;
        size_t in = 1 + test_random(seed, 2 * i) % (i % 7 ? 13 : 5000);
        const size_t room = 1 + test_random(seed, 2 * i + 1) % (i % 5 ? 9000 : 3);
        in = in < left ? in : left;
        vvi_coding_step step = {f->coded + f->at, in, f->out + f->made, room};
        assert_null(vvi_decoder_run(decoder, &step, &end));
        f->at += in - step.n_in;
        f->made += room - step.n_out;
        assert_true(i < 10000000);
    }
}

static void members_end_where_they_end_whatever_the_pieces(void **state)
{
    (void)state;
    static const vvi_coding codings[] = {VVI_CODING_GZIP, VVI_CODING_BZIP2, VVI_CODING_ZSTD};
    const uint64_t random = test_seed();
    uint8_t *plain = malloc(2 * MOST), *coded = malloc(4 * MOST), *out = malloc(2 * MOST + 10000);
    assert_true(plain && coded && out);
    for (int round = 0; round < 90; round++) {
        const vvi_coding coding = codings[round % 3];
        const uint64_t seed = test_random(random, (uint64_t)round);
        size_t n[2], ends[2], at = 0, total = 0;
        vvi_decoder *decoder;
        if (vvi_coding_available(coding) != VV_OK)
            continue;
        for (int m = 0; m < 2; m++) {
            n[m] = test_random(seed, 900 + (uint64_t)m) % (round % 4 ? MOST : 20);
            fill(plain + total, n[m], seed + (uint64_t)m);
            at += encode(coded + at, coding, plain + total, n[m], 1 + round % 9);
            ends[m] = at;
            total += n[m];
        }
        feed f = {.coded = coded, .n = at, .out = out};
        assert_int_equal(vvi_decoder_new(&decoder, coding, NULL), VV_OK);
        decode_member(decoder, &f, seed);
        assert_int_equal(f.at, ends[0]);
        assert_int_equal(f.made, n[0]);
        assert_true(vvi_decoder_reset(decoder));
        decode_member(decoder, &f, seed + 1);
        assert_int_equal(f.at, ends[1]);
        assert_int_equal(f.made, total);
        assert_memory_equal(out, plain, total);
        vvi_decoder_free(decoder);
    }
    free(plain);
    free(coded);
    free(out);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(members_end_where_they_end_whatever_the_pieces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
