/* Chunks as they lie in HDF5 files to samples: every filter that needs no library of its own kind, undone by us. The
 * library's own way reads past the end of a chunk that unpacks to less than it should; here each step is capped, and
 * what comes out has the size of a chunk or is damaged. How a chunk is packed: the registered filters of the HDF Group.
 */
#include "config.h"
#include "io/formats/hdf5/hdf5.h"
#include "io/inflate.h"
#include <string.h>
#if VV_HAVE_BLOSC
#include <blosc.h>
#endif
#if VV_HAVE_LZ4
#include <lz4.h>
#endif
#if VV_HAVE_ZSTD
#include <zstd.h>
#endif

#define FILTER_LZF 32000
#define FILTER_BLOSC 32001
#define FILTER_LZ4 32004
#define FILTER_ZSTD 32015

bool vvi_h5_filter_is_ours(H5Z_filter_t id)
{
    switch (id) {
    case H5Z_FILTER_DEFLATE:
    case H5Z_FILTER_SHUFFLE:
    case H5Z_FILTER_FLETCHER32:
    case FILTER_LZF:
        return true;
    case FILTER_BLOSC:
        return VV_HAVE_BLOSC;
    case FILTER_LZ4:
        return VV_HAVE_LZ4;
    case FILTER_ZSTD:
        return VV_HAVE_ZSTD;
    default:
        return false;
    }
}

/* Each gives how many bytes it has made, at most `room`; 0 is failure. */

/* Runs of letters (0 .. 31: one more than the number) and copies from before (3 bits of length, 13 of distance). */
static size_t unpack_lzf(uint8_t *out, size_t room, const uint8_t *in, size_t n)
{
    size_t at = 0, made = 0;
    while (at < n) {
        const size_t control = in[at++];
        size_t length = control + 1;
        if (control < 32) {
            if (length > n - at || length > room - made)
                return 0;
            memcpy(out + made, in + at, length);
            at += length;
            made += length;
            continue;
        }
        length = control >> 5;
        if (length == 7 && at < n)
            length += in[at++];
        if (at >= n)
            return 0;
        const size_t back = ((control & 31) << 8 | in[at++]) + 1;
        length += 2;
        if (back > made || length > room - made)
            return 0;
        for (size_t i = 0; i < length; i++, made++) /* may overlap itself: that is how runs are kept */
            out[made] = out[made - back];
    }
    return made;
}

static size_t unpack_deflate(uint8_t *out, size_t room, const uint8_t *in, size_t n)
{
    size_t made;
    return vvi_inflate_block(out, room, &made, in, n, VVI_INFLATE_ZLIB) ? made : 0;
}

static size_t unpack_zstd(uint8_t *out, size_t room, const uint8_t *in, size_t n)
{
#if VV_HAVE_ZSTD
    const size_t made = ZSTD_decompress(out, room, in, n);
    return ZSTD_isError(made) ? 0 : made;
#else
    return 0;
#endif
}

static size_t unpack_blosc(uint8_t *out, size_t room, const uint8_t *in, size_t n)
{
#if VV_HAVE_BLOSC
    size_t made;
    if (blosc_cbuffer_validate(in, n, &made) < 0 || made > room)
        return 0;
    const int got = blosc_decompress_ctx(in, out, room, 1);
    return got > 0 ? (size_t)got : 0;
#else
    return 0;
#endif
}

static uint64_t big_endian(const uint8_t *at, int n)
{
    uint64_t v = 0;
    for (int i = 0; i < n; i++)
        v = v << 8 | at[i];
    return v;
}

#if VV_HAVE_LZ4
static bool unpack_lz4_block(uint8_t *out, size_t want, const uint8_t *in, size_t packed)
{
    if (packed == want) { /* not worth packing */
        memcpy(out, in, want);
        return true;
    }
    return LZ4_decompress_safe((const char *)in, (char *)out, (int)packed, (int)want) == (int)want;
}
#else
static bool unpack_lz4_block(uint8_t *out, size_t want, const uint8_t *in, size_t packed)
{
    return false;
}
#endif

/* The bytes of all, the bytes of a block, then blocks with their packed size before them; all big-endian. */
static size_t unpack_lz4(uint8_t *out, size_t room, const uint8_t *in, size_t n)
{
    const uint64_t all = n >= 16 ? big_endian(in, 8) : 0, block = n >= 16 ? big_endian(in + 8, 4) : 0;
    size_t at = 12, made = 0;
    if (all == 0 || all > room || block == 0 || all > INT32_MAX)
        return 0;
    while (made < all) {
        const size_t want = all - made < block ? (size_t)all - made : (size_t)block;
        if (n - at < 4)
            return 0;
        const size_t packed = (size_t)big_endian(in + at, 4);
        at += 4;
        if (packed > n - at || !unpack_lz4_block(out + made, want, in + at, packed))
            return 0;
        at += packed;
        made += want;
    }
    return made;
}

/* Of the sizes that are common: the compiler makes vectors of these. */
static void interleave2(uint8_t *restrict out, const uint8_t *restrict in, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        out[2 * i] = in[i];
        out[2 * i + 1] = in[count + i];
    }
}

static void interleave4(uint8_t *restrict out, const uint8_t *restrict in, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        out[4 * i] = in[i];
        out[4 * i + 1] = in[count + i];
        out[4 * i + 2] = in[2 * count + i];
        out[4 * i + 3] = in[3 * count + i];
    }
}

/* Bytes of equal weight lie together; what is no whole element follows. */
static size_t unshuffle(uint8_t *out, size_t room, const uint8_t *in, size_t n, size_t element)
{
    if (n > room || element == 0)
        return 0;
    const size_t count = n / element, whole = count * element;
    if (element == 2)
        interleave2(out, in, count);
    else if (element == 4)
        interleave4(out, in, count);
    else
        for (size_t b = 0; b < element && count > 0; b++)
            for (size_t i = 0; i < count; i++)
                out[i * element + b] = in[b * count + i];
    memcpy(out + whole, in + whole, n - whole);
    return n;
}

/* Fletcher's sum of big-endian words of 16 bits; the last four bytes are it. */
static size_t check_fletcher(const uint8_t *in, size_t n)
{
    uint32_t a = 0, b = 0;
    if (n < 5)
        return 0;
    const size_t length = n - 4;
    for (size_t i = 0; i + 1 < length; i += 2) {
        a = (a + ((uint32_t)in[i] << 8 | in[i + 1])) % 65535;
        b = (b + a) % 65535;
    }
    if (length % 2) {
        a = (a + ((uint32_t)in[length - 1] << 8)) % 65535;
        b = (b + a) % 65535;
    }
    const uint8_t *end = in + length;
    const uint32_t stored_a = (uint32_t)end[0] | (uint32_t)end[1] << 8,
                   stored_b = (uint32_t)end[2] | (uint32_t)end[3] << 8;
    /* zero is also 65535 in this arithmetic */
    return stored_a % 65535 == a && stored_b % 65535 == b ? length : 0;
}

const uint8_t *vvi_h5_unpack(const vvi_h5_set *set, const uint8_t *in, size_t n, unsigned mask, size_t n_out,
                             uint8_t *const scratch[2])
{
    const size_t room = n_out + VVI_H5_UNPACK_SLACK;
    int turn = 0;
    for (int i = set->n_filters - 1; i >= 0; i--) {
        uint8_t *out = scratch[turn];
        size_t made = 0;
        if (mask >> i & 1)
            continue;
        switch (set->filter[i].id) {
        case H5Z_FILTER_FLETCHER32:
            n = check_fletcher(in, n);
            if (n == 0)
                return NULL;
            continue;
        case H5Z_FILTER_SHUFFLE:
            made = unshuffle(out, room, in, n, set->filter[i].parameter);
            break;
        case H5Z_FILTER_DEFLATE:
            made = unpack_deflate(out, room, in, n);
            break;
        case FILTER_LZF:
            made = unpack_lzf(out, room, in, n);
            break;
        case FILTER_ZSTD:
            made = unpack_zstd(out, room, in, n);
            break;
        case FILTER_BLOSC:
            made = unpack_blosc(out, room, in, n);
            break;
        case FILTER_LZ4:
            made = unpack_lz4(out, room, in, n);
            break;
        default:
            break;
        }
        if (made == 0)
            return NULL;
        in = out;
        n = made;
        turn = !turn;
    }
    return n == n_out ? in : NULL;
}
