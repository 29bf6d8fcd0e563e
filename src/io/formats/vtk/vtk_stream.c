#include "io/formats/vtk/vtk_stream.h"
#include <ctype.h>
#include <stdio.h>

#define CHARACTERS ((size_t)16384) /* of base64 decoded at once; a multiple of 4 */

static int base64_digit(unsigned char c)
{
    return c >= 'A' && c <= 'Z'   ? c - 'A'
           : c >= 'a' && c <= 'z' ? c - 'a' + 26
           : c >= '0' && c <= '9' ? c - '0' + 52
           : c == '+'             ? 62
           : c == '/'             ? 63
                                  : -1;
}

/* Four characters to at most three bytes; how many, 0 when they are no base64. */
static size_t decode_group(uint8_t out[3], const unsigned char in[4])
{
    int d[4];
    for (int i = 0; i < 4; i++)
        d[i] = base64_digit(in[i]);
    const size_t n = in[3] != '=' ? 3 : in[2] != '=' ? 2 : 1;
    for (size_t i = 0; i <= n; i++)
        if (d[i] < 0)
            return 0;
    out[0] = (uint8_t)(d[0] << 2 | d[1] >> 4);
    out[1] = (uint8_t)(d[1] << 4 | (n > 1 ? d[2] >> 2 : 0));
    out[2] = (uint8_t)(n > 2 ? d[2] << 6 | d[3] : 0);
    return n;
}

static vv_status fail_base64(const vvi_vtk_stream *s, uint64_t at)
{
    char where[32];
    snprintf(where, sizeof where, "byte %llu", (unsigned long long)at);
    return vv_fail_at(VV_E_FORMAT, s->name, where,
                      "its array '%.60s' is not base64 here; line ends inside of it are not allowed", s->array->name);
}

/* Bytes [from, from + n) of the stream that begins at byte `begin`; fewer where the array or the file ends. */
static vv_status read_base64(const vvi_vtk_stream *s, uint64_t begin, uint64_t from, uint8_t *out, size_t n,
                             size_t *n_got)
{
    unsigned char text[CHARACTERS];
    uint64_t at = begin + from / 3 * 4;
    size_t lead = (size_t)(from % 3);
    *n_got = 0;
    while (*n_got < n) {
        const uint64_t want = (n - *n_got + lead + 2) / 3 * 4, left = at < s->array->end ? s->array->end - at : 0;
        size_t m = want < CHARACTERS ? (size_t)want : CHARACTERS, got = 0;
        m = m < left ? m : (size_t)left;
        vv_status st = m ? vvi_source_seek(s->source, at) : VV_OK;
        if (st == VV_OK && m)
            st = vvi_source_read_whole(s->source, text, m, &got);
        if (st != VV_OK || got < 4)
            return st;
        for (size_t i = 0; i + 4 <= got && *n_got < n; i += 4, lead = 0) {
            uint8_t group[3] = {0};
            const size_t k = decode_group(group, text + i);
            if (k == 0 && isspace(text[i]) && *n_got + 3 >= n)
                return VV_OK;
            if (k == 0)
                return fail_base64(s, at + i);
            for (size_t b = lead; b < k && *n_got < n; b++)
                out[(*n_got)++] = group[b];
            if (k < 3)
                return VV_OK;
        }
        at += got / 4 * 4;
    }
    return VV_OK;
}

vv_status vvi_vtk_stream_read(const vvi_vtk_stream *s, uint64_t begin, uint64_t from, void *out, size_t n,
                              size_t *n_got)
{
    *n_got = 0;
    if (n == 0)
        return VV_OK;
    if (s->array->form == VVI_VTK_BASE64)
        return read_base64(s, begin, from, out, n, n_got);
    if (from > UINT64_MAX - begin)
        return VV_OK;
    const uint64_t at = begin + from;
    const uint64_t left = at < s->array->end ? s->array->end - at : 0;
    vv_status st = left ? vvi_source_seek(s->source, at) : VV_OK;
    return st == VV_OK && left ? vvi_source_read_whole(s->source, out, n < left ? n : (size_t)left, n_got) : st;
}

uint64_t vvi_vtk_stream_length(const vvi_vtk_array *array, uint64_t n)
{
    return array->form == VVI_VTK_BASE64 ? (n / 3 + (n % 3 != 0)) * 4 : n;
}
