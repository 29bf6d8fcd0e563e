#include "server/handshake.h"
#include "io/base64.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

static uint32_t rotate(uint32_t x, int n)
{
    return x << n | x >> (32 - n);
}

/* One block of SHA-1 (FIPS 180-4, 6.1.2). */
static void add_block(uint32_t h[5], const uint8_t block[64])
{
    uint32_t w[80], a = h[0], b = h[1], c = h[2], d = h[3], e = h[4];
    for (int t = 0; t < 16; t++)
        w[t] = (uint32_t)block[4 * t] << 24 | (uint32_t)block[4 * t + 1] << 16 | (uint32_t)block[4 * t + 2] << 8 |
               block[4 * t + 3];
    for (int t = 16; t < 80; t++)
        w[t] = rotate(w[t - 3] ^ w[t - 8] ^ w[t - 14] ^ w[t - 16], 1);
    for (int t = 0; t < 80; t++) {
        const uint32_t f = t < 20   ? ((b & c) | (~b & d)) + 0x5a827999
                           : t < 40 ? (b ^ c ^ d) + 0x6ed9eba1
                           : t < 60 ? ((b & c) | (b & d) | (c & d)) + 0x8f1bbcdc
                                    : (b ^ c ^ d) + 0xca62c1d6;
        const uint32_t next = rotate(a, 5) + f + e + w[t];
        e = d;
        d = c;
        c = rotate(b, 30);
        b = a;
        a = next;
    }
    h[0] += a;
    h[1] += b;
    h[2] += c;
    h[3] += d;
    h[4] += e;
}

void vvi_handshake_accept(char out[VVI_ACCEPT_TEXT], const char *key)
{
    static const char salt[] = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
    enum { N = VVI_KEY_LETTERS + sizeof salt - 1 }; /* 60 bytes: the padding makes it two blocks */
    uint32_t h[5] = {0x67452301, 0xefcdab89, 0x98badcfe, 0x10325476, 0xc3d2e1f0};
    uint8_t bytes[128] = {0}, digest[21] = {0};
    memcpy(bytes, key, VVI_KEY_LETTERS);
    memcpy(bytes + VVI_KEY_LETTERS, salt, sizeof salt - 1);
    bytes[N] = 0x80;
    bytes[126] = (8 * N) >> 8;
    bytes[127] = (8 * N) & 255;
    add_block(h, bytes);
    add_block(h, bytes + 64);
    for (int i = 0; i < 20; i++)
        digest[i] = (uint8_t)(h[i / 4] >> (24 - 8 * (i % 4)));
    for (size_t i = 0; i < 7; i++)
        vvi_base64_group(out + 4 * i, digest + 3 * i, i < 6 ? 3 : 2);
    out[VVI_ACCEPT_TEXT - 1] = 0;
}
