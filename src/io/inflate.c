#include "io/inflate.h"
#include "config.h"
#include <limits.h>
#include <stdint.h>
#include <zlib.h>
#if VV_HAVE_ISAL
#include <isa-l/igzip_lib.h>
#endif

static unsigned piece(size_t n)
{
    return n < UINT_MAX ? (unsigned)n : UINT_MAX;
}

/* Blocks of any size, and all of them where there is no faster library. */
static bool inflate_plainly(uint8_t *out, size_t room, size_t *n_out, const uint8_t *in, size_t n_in,
                            vvi_inflate_wrapper wrapper)
{
    z_stream z = {0};
    size_t left_in = n_in, left_out = room;
    int code = inflateInit2(&z, wrapper == VVI_INFLATE_GZIP ? 15 + 16 : 15);
    if (code != Z_OK)
        return false;
    while (code == Z_OK) {
        const unsigned some_in = piece(left_in), some_out = piece(left_out);
        z.next_in = (Bytef *)(uintptr_t)(in + (n_in - left_in)); /* not written, but zlib does not say const */
        z.avail_in = some_in;
        z.next_out = out + (room - left_out);
        z.avail_out = some_out;
        code = inflate(&z, Z_NO_FLUSH);
        left_in -= some_in - z.avail_in;
        left_out -= some_out - z.avail_out;
    }
    inflateEnd(&z);
    *n_out = room - left_out;
    return code == Z_STREAM_END && (wrapper == VVI_INFLATE_ZLIB || left_in == 0);
}

#if VV_HAVE_ISAL
/* Twice as fast as zlib. The state is large but for the most part not touched, so it costs little on the stack and
 * would cost page faults anew for every block elsewhere. */
static bool inflate_fast(uint8_t *out, size_t room, size_t *n_out, const uint8_t *in, size_t n_in,
                         vvi_inflate_wrapper wrapper)
{
    struct inflate_state s;
    if (wrapper == VVI_INFLATE_GZIP && n_in > 3 && (in[3] & 0xe0) != 0) /* flags that it passes over */
        return false;
    isal_inflate_init(&s);
    s.crc_flag = wrapper == VVI_INFLATE_GZIP ? ISAL_GZIP : ISAL_ZLIB;
    s.next_in = (uint8_t *)(uintptr_t)in; /* not written, but the library does not say const */
    s.avail_in = (uint32_t)n_in;
    s.next_out = out;
    s.avail_out = (uint32_t)room;
    const int code = isal_inflate_stateless(&s);
    *n_out = room - s.avail_out;
    return code == ISAL_DECOMP_OK && (wrapper == VVI_INFLATE_ZLIB || s.avail_in == 0);
}
#endif

bool vvi_inflate_block(void *out, size_t room, size_t *n_out, const void *in, size_t n_in, vvi_inflate_wrapper wrapper)
{
#if VV_HAVE_ISAL
    if (room > 0 && room <= INT32_MAX && n_in <= INT32_MAX)
        return inflate_fast(out, room, n_out, in, n_in, wrapper);
#endif
    return inflate_plainly(out, room, n_out, in, n_in, wrapper);
}

bool vvi_inflate_is_whole(const void *in, size_t n_in)
{
    enum { WINDOW = 1 << 14 };
    uint8_t thrown_away[WINDOW];
    z_stream z = {0};
    size_t left = n_in;
    int code = inflateInit2(&z, 15);
    if (code != Z_OK)
        return false;
    while (code == Z_OK) {
        const unsigned some = piece(left);
        z.next_in = (Bytef *)(uintptr_t)((const uint8_t *)in + (n_in - left)); /* as above */
        z.avail_in = some;
        z.next_out = thrown_away;
        z.avail_out = WINDOW;
        code = inflate(&z, Z_NO_FLUSH);
        left -= some - z.avail_in;
    }
    inflateEnd(&z);
    return code == Z_STREAM_END;
}
