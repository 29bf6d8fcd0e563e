/* Blocks of deflate against zlib's own answer: whole, cut short, with flipped bits, and with too little room. */
#include "fields.h"
#include "io/inflate.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <zlib.h>

#define MOST 70000
#define GUARD 64

typedef struct block {
    uint8_t plain[MOST], coded[2 * MOST], damaged[2 * MOST], out[MOST + GUARD], expected[MOST];
    size_t n, n_coded;
    vvi_inflate_wrapper wrapper;
} block;

/* Bytes that compress a little, a lot, or not at all; every level and strategy of zlib. */
static void make(block *b, uint64_t seed)
{
    const uint64_t kind = test_random(seed, 0) % 3;
    const int level = (int)(test_random(seed, 1) % 10), strategy = (int)(test_random(seed, 2) % 5);
    z_stream z = {0};
    b->n = seed % 8 == 0 ? seed / 8 % 40 : test_random(seed, 3) % MOST;
    b->wrapper = test_random(seed, 4) % 3 == 0 ? VVI_INFLATE_GZIP : VVI_INFLATE_ZLIB;
    for (size_t i = 0; i < b->n; i++)
        b->plain[i] = (uint8_t)(kind == 0   ? test_random(seed, i + 9)
                                : kind == 1 ? test_random(seed, i / 50 + 9) % 7
                                            : (i * i >> 9) + test_random(seed, i + 9) % 3);
    const int bits = (int)(9 + test_random(seed, 5) % 7) + (b->wrapper == VVI_INFLATE_GZIP ? 16 : 0);
    assert_int_equal(deflateInit2(&z, level, Z_DEFLATED, bits, 8, strategy), Z_OK);
    z.next_in = b->plain;
    z.avail_in = (uInt)b->n;
    z.next_out = b->coded;
    z.avail_out = sizeof b->coded;
    assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
    b->n_coded = sizeof b->coded - z.avail_out;
    deflateEnd(&z);
}

/* zlib's answer: bytes made, or -1. */
static long expected(block *b, const uint8_t *in, size_t n_in, size_t room)
{
    z_stream z = {0};
    assert_int_equal(inflateInit2(&z, b->wrapper == VVI_INFLATE_GZIP ? 31 : 15), Z_OK);
    z.next_in = (Bytef *)(uintptr_t)in;
    z.avail_in = (uInt)n_in;
    z.next_out = b->expected;
    z.avail_out = (uInt)room;
    const int code = inflate(&z, Z_FINISH);
    const bool whole = code == Z_STREAM_END && (b->wrapper == VVI_INFLATE_ZLIB || z.avail_in == 0);
    const long n = whole ? (long)z.total_out : -1;
    inflateEnd(&z);
    return n;
}

/* The input lies at the very end of its memory and the output before bytes that must stay. */
static bool check(block *b, const uint8_t *in, size_t n_in, size_t room)
{
    size_t n = 0;
    uint8_t *tight = malloc(n_in > 0 ? n_in : 1);
    assert_non_null(tight);
    memcpy(tight, in, n_in);
    memset(b->out, 0xa5, sizeof b->out);
    const bool good = vvi_inflate_block(b->out, room, &n, tight, n_in, b->wrapper);
    const long want = expected(b, in, n_in, room);
    free(tight);
    for (size_t i = 0; i < GUARD; i++)
        assert_int_equal(b->out[room + i], 0xa5);
    assert_int_equal(good, want >= 0);
    if (good) {
        assert_int_equal(n, want);
        assert_memory_equal(b->out, b->expected, n);
    }
    return good;
}

static void whole_blocks_are_what_was_packed(void **state)
{
    block *b = *state;
    for (uint64_t seed = 0; seed < 400; seed++) {
        make(b, seed);
        assert_true(check(b, b->coded, b->n_coded, b->n));
        assert_memory_equal(b->out, b->plain, b->n);
        assert_true(check(b, b->coded, b->n_coded, MOST));
        memset(b->coded + b->n_coded, (int)seed, 30);
        assert_int_equal(check(b, b->coded, b->n_coded + 30, b->n), b->wrapper == VVI_INFLATE_ZLIB);
        if (b->n > 0)
            assert_false(check(b, b->coded, b->n_coded, b->n - 1 - test_random(seed, 6) % b->n));
    }
}

static void truncated_blocks_are_refused(void **state)
{
    block *b = *state;
    for (uint64_t seed = 1; seed < 120; seed++) {
        make(b, seed);
        for (size_t cut = 1; cut <= b->n_coded; cut += cut < 40 ? 1 : b->n_coded / 9 + 1)
            assert_false(check(b, b->coded, b->n_coded - cut, b->n));
        assert_false(check(b, b->coded, 0, b->n));
    }
}

static void flipped_bits_are_found_as_zlib_finds_them(void **state)
{
    block *b = *state;
    for (uint64_t seed = 1; seed < 3000; seed++) {
        if (seed % 30 == 1)
            make(b, seed);
        memcpy(b->damaged, b->coded, b->n_coded);
        for (uint64_t i = 0; i <= seed % 3; i++) {
            const uint64_t bit = test_random(seed, 20 + i) % (seed % 4 ? b->n_coded * 8 : 160);
            if (bit / 8 < b->n_coded)
                b->damaged[bit / 8] ^= (uint8_t)(1u << bit % 8);
        }
        check(b, b->damaged, b->n_coded, b->n);
    }
}

static int set_up(void **state)
{
    *state = malloc(sizeof(block));
    return *state ? 0 : -1;
}

static int tear_down(void **state)
{
    free(*state);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_blocks_are_what_was_packed),
        cmocka_unit_test(truncated_blocks_are_refused),
        cmocka_unit_test(flipped_bits_are_found_as_zlib_finds_them),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
