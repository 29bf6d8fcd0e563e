/* JPEG in DICOM: what a picture says of itself, the part of it that a decoder may see, and lossless JPEG (process 14 of
 * ITU-T T.81, annex H), in which most packed series are. */
#include "io/formats/dicom/dicom.h"
#include <string.h>

static uint32_t big(const uint8_t *b, size_t n)
{
    uint32_t out = 0;
    for (size_t i = 0; i < n; i++)
        out = out << 8 | b[i];
    return out;
}

/* Whether the end is there, padding behind it: what decoders make of a picture that is cut short is as it may be, and
 * slow. */
static bool has_end(const uint8_t *in, size_t n)
{
    for (size_t i = n; i >= 2 && n - i < 64; i--)
        if (in[i - 2] == 0xff && in[i - 1] == 0xd9)
            return true;
    return false;
}

/* Segments ------------------------------------------------------------------------------------------------------- */

enum { SOF0 = 0xc0, SOF1, SOF3 = 0xc3, DHT, SOS = 0xda, DQT, DRI = 0xdd, APP14 = 0xee, SOF55 = 0xf7, LSE };

typedef struct segment {
    uint8_t marker;
    const uint8_t *data; /* behind the length */
    size_t n;
} segment;

/* The segment at *at, which moves behind it. Only fill bytes may stand between segments. */
static bool next_segment(segment *out, size_t *at, const uint8_t *in, size_t n)
{
    while (*at + 1 < n && in[*at] == 0xff && in[*at + 1] == 0xff)
        ++*at;
    if (*at + 4 > n || in[*at] != 0xff)
        return false;
    const size_t length = big(in + *at + 2, 2);
    *out = (segment){in[*at + 1], in + *at + 4, length - 2};
    *at += 2 + length;
    return length >= 2 && *at <= n;
}

static bool is_frame(uint8_t marker)
{
    return marker == SOF0 || marker == SOF1 || marker == SOF3 || marker == SOF55;
}

static bool read_frame(vvi_dicom_picture *out, const segment *s)
{
    if (s->n < 6 || s->n != 6 + 3 * (size_t)s->data[5])
        return false;
    out->process = s->marker;
    out->bits = s->data[0];
    out->rows = big(s->data + 1, 2);
    out->columns = big(s->data + 3, 2);
    out->components = s->data[5];
    return true;
}

/* The components and the spectrum of the first scan; those of sequential ones are said in one way only, but some
 * writers do not know it. */
static bool scan_fits(const vvi_dicom_picture *p, const segment *s)
{
    return s->n >= 4 && s->n == 4 + 2 * (size_t)s->data[0] && s->data[0] >= 1 && s->data[0] <= p->components;
}

static bool is_needed(const segment *s)
{
    if (s->marker == APP14) /* says whether colours are luma and chroma */
        return s->n == 12 && memcmp(s->data, "Adobe", 5) == 0 && s->data[11] <= 1;
    return is_frame(s->marker) || s->marker == DHT || s->marker == DQT || s->marker == DRI || s->marker == LSE ||
           s->marker == SOS;
}

static void put_segment(uint8_t *out, size_t *at, const segment *s)
{
    const uint8_t head[] = {0xff, s->marker, (uint8_t)((s->n + 2) >> 8), (uint8_t)(s->n + 2)};
    memcpy(out + *at, head, sizeof head);
    memcpy(out + *at + sizeof head, s->data, s->n);
    *at += sizeof head + s->n;
}

size_t vvi_dicom_clean_jpeg(uint8_t *out, vvi_dicom_picture *picture, const uint8_t *in, size_t n)
{
    size_t at = 2, to = 2;
    segment s;
    *picture = (vvi_dicom_picture){0};
    if (n < 4 || in[0] != 0xff || in[1] != 0xd8)
        return 0;
    memcpy(out, in, 2);
    while (next_segment(&s, &at, in, n)) {
        if (is_frame(s.marker) ? picture->process || !read_frame(picture, &s)
                               : s.marker >= 0xc0 && s.marker <= 0xcf && s.marker != DHT)
            return 0;
        if (!is_needed(&s))
            continue;
        put_segment(out, &to, &s);
        if (s.marker != SOS)
            continue;
        if (!picture->process || !scan_fits(picture, &s) || (picture->process != SOF3 && !has_end(in + at, n - at)))
            return 0;
        if (picture->process == SOF0 || picture->process == SOF1)
            memcpy(out + to - 3, (const uint8_t[]){0, 63, 0}, 3);
        memcpy(out + to, in + at, n - at);
        return to + n - at;
    }
    return 0;
}

/* JPEG 2000 ------------------------------------------------------------------------------------------------------- */

static bool size_of_codestream(vvi_dicom_picture *out, const uint8_t *in, size_t n)
{
    if (n < 43 || memcmp(in, "\xff\x4f\xff\x51", 4) != 0)
        return false;
    const uint32_t x = big(in + 8, 4), y = big(in + 12, 4), x0 = big(in + 16, 4), y0 = big(in + 20, 4);
    const uint32_t tile_x = big(in + 24, 4), tile_y = big(in + 28, 4);
    *out = (vvi_dicom_picture){x - x0, y - y0, big(in + 40, 2), (in[42] & 0x7fu) + 1, 0x51};
    /* tiles as small as pixels make decoders slow and large */
    return x0 < x && y0 < y && tile_x > 0 && tile_y > 0 && ((uint64_t)(x / tile_x) + 1) * (y / tile_y + 1) <= 65535;
}

/* A codestream, or the boxes of JP2 around one. */
bool vvi_dicom_size_of_jpeg_2000(vvi_dicom_picture *out, const uint8_t *in, size_t n)
{
    size_t at = 0;
    *out = (vvi_dicom_picture){0};
    if (n >= 12 && memcmp(in, "\0\0\0\x0cjP", 6) == 0) {
        while (at + 8 <= n && memcmp(in + at + 4, "jp2c", 4) != 0) {
            const uint32_t length = big(in + at, 4);
            if (length < 8)
                return false;
            at += length;
        }
        at += 8;
    }
    return at < n && has_end(in + at, n - at) && size_of_codestream(out, in + at, n - at);
}

/* Lossless JPEG: tables and bits ----------------------------------------------------------------------------------- */

#define FAST 9

typedef struct huffman {
    uint16_t fast[1 << FAST];             /* length << 8 | value of the code that begins with these bits; 0: longer */
    int32_t first[17], limit[17], at[17]; /* of codes of a length: the first, behind the last, where their values are */
    uint8_t value[256];
    bool there;
} huffman;

typedef struct lossless {
    const uint8_t *in, *end;
    uint64_t bits;      /* the next n_bits, at the top */
    int n_bits, n_zero; /* how many of them are only the zeros behind the end */
    huffman table[4];
    uint32_t interval; /* rows between restarts; 0: none */
    int predictor, shift, n_components, precision;
    uint8_t table_of[3];
    size_t columns;
} lossless;

static bool build_table(huffman *h, const uint8_t counts[16], const uint8_t *values, size_t n)
{
    int32_t code = 0;
    size_t at = 0;
    memset(h, 0, sizeof *h);
    for (int length = 1; length <= 16; length++, code <<= 1) {
        h->first[length] = code;
        h->at[length] = (int32_t)at;
        for (int i = 0; i < counts[length - 1]; i++, code++, at++) {
            if (at >= n || code >= 1 << length || values[at] > 16)
                return false;
            h->value[at] = values[at];
            for (int j = 0; length <= FAST && j < 1 << (FAST - length); j++)
                h->fast[(code << (FAST - length)) + j] = (uint16_t)(length << 8 | values[at]);
        }
        h->limit[length] = code;
    }
    h->there = true;
    return true;
}

static bool read_tables(lossless *l, const segment *s)
{
    for (size_t at = 0; at < s->n;) {
        size_t n = 0;
        if (s->n - at < 17 || s->data[at] > 3)
            return false;
        for (int i = 0; i < 16; i++)
            n += s->data[at + 1 + (size_t)i];
        if (n > 256 || n > s->n - at - 17 ||
            !build_table(&l->table[s->data[at]], s->data + at + 1, s->data + at + 17, n))
            return false;
        at += 17 + n;
    }
    return true;
}

/* Bytes until the next marker; then zeros. */
static void fill_bits(lossless *l)
{
    while (l->n_bits <= 56) {
        uint64_t byte = 0;
        if (l->in < l->end && (l->in[0] != 0xff || (l->in + 1 < l->end && l->in[1] == 0))) {
            byte = l->in[0];
            l->in += byte == 0xff ? 2 : 1;
        } else {
            l->n_zero += 8;
        }
        l->bits |= byte << (56 - l->n_bits);
        l->n_bits += 8;
    }
}

static void drop_bits(lossless *l, int n)
{
    l->bits <<= n;
    l->n_bits -= n;
}

/* The difference of a sample from its prediction; false where the data is no code. Needs 32 bits. */
static bool difference(lossless *l, const huffman *h, int32_t *out)
{
    if (l->n_bits < 32)
        fill_bits(l);
    const uint16_t fast = h->fast[l->bits >> (64 - FAST)];
    int length = fast >> 8, size = fast & 255;
    if (!fast) {
        for (length = FAST + 1; length <= 16; length++) {
            const int32_t code = (int32_t)(l->bits >> (64 - length));
            if (code < h->limit[length]) {
                size = h->value[h->at[length] + code - h->first[length]];
                break;
            }
        }
        if (length > 16)
            return false;
    }
    drop_bits(l, length);
    if (size == 0 || size == 16) {
        *out = size ? 32768 : 0;
        return true;
    }
    const int32_t v = (int32_t)(l->bits >> (64 - size));
    drop_bits(l, size);
    *out = v < 1 << (size - 1) ? v - (1 << size) + 1 : v;
    return true;
}

/* Lossless JPEG: samples --------------------------------------------------------------------------------------------
 */

static int32_t predict(int predictor, int32_t a, int32_t b, int32_t c)
{
    switch (predictor) {
    case 1:
        return a;
    case 2:
        return b;
    case 3:
        return c;
    case 4:
        return a + b - c;
    case 5:
        return a + ((b - c) >> 1);
    case 6:
        return b + ((a - c) >> 1);
    default:
        return (a + b) >> 1;
    }
}

/* One row; above NULL: the first one behind the start or a restart. */
static bool unpack_row(lossless *l, uint16_t *row, const uint16_t *above)
{
    const size_t nc = (size_t)l->n_components, n = l->columns * nc;
    for (size_t i = 0; i < n; i++) {
        int32_t d = 0, guess;
        if (!difference(l, &l->table[l->table_of[i % nc]], &d))
            return false;
        if (i < nc)
            guess = above ? above[i] : 1 << (l->precision - l->shift - 1);
        else if (!above)
            guess = row[i - nc];
        else
            guess = predict(l->predictor, row[i - nc], above[i], above[i - nc]);
        row[i] = (uint16_t)(guess + d);
    }
    return l->n_bits >= l->n_zero; /* none of the zeros was used */
}

/* Behind the last code of an interval stands RST0 .. RST7. */
static bool restart(lossless *l)
{
    l->bits = 0;
    l->n_bits = l->n_zero = 0;
    while (l->in + 1 < l->end && !(l->in[0] == 0xff && l->in[1] >= 0xd0 && l->in[1] <= 0xd7))
        l->in++;
    l->in += 2;
    return l->in < l->end;
}

static void put_row(uint8_t *out, const uint16_t *row, size_t n, size_t bytes, int shift)
{
    for (size_t i = 0; i < n; i++) {
        const uint16_t v = (uint16_t)(row[i] << shift);
        out[i * bytes] = (uint8_t)v;
        if (bytes == 2)
            out[i * 2 + 1] = (uint8_t)(v >> 8);
    }
}

static bool unpack_rows(lossless *l, uint8_t *out, uint16_t *rows, uint32_t n_rows, size_t bytes)
{
    const size_t n = l->columns * (size_t)l->n_components;
    for (uint32_t j = 0; j < n_rows; j++) {
        uint16_t *row = rows + (j & 1) * n, *above = rows + (~j & 1) * n;
        const bool again = l->interval && j > 0 && j % l->interval == 0;
        if ((again && !restart(l)) || !unpack_row(l, row, j == 0 || again ? NULL : above))
            return false;
        put_row(out + (size_t)j * n * bytes, row, n, bytes, l->shift);
    }
    return true;
}

static bool read_scan(lossless *l, const segment *s)
{
    for (int c = 0; c < l->n_components; c++) {
        l->table_of[c] = s->data[2 + 2 * c] >> 4;
        if (l->table_of[c] > 3 || !l->table[l->table_of[c]].there)
            return false;
    }
    l->predictor = s->data[s->n - 3];
    l->shift = s->data[s->n - 1] & 15;
    return s->data[0] == l->n_components && l->predictor >= 1 && l->predictor <= 7 && l->shift < l->precision;
}

static bool read_interval(lossless *l, const segment *s)
{
    if (s->n != 2 || big(s->data, 2) % l->columns != 0)
        return false; /* restarts stand between rows (H.1.1) */
    l->interval = big(s->data, 2) / (uint32_t)l->columns;
    return true;
}

bool vvi_dicom_unpack_lossless(uint8_t *out, size_t bytes, const vvi_dicom_picture *picture, void *rows,
                               const uint8_t *in, size_t n)
{
    static const lossless none;
    lossless l = none;
    segment s;
    size_t at = 2;
    if (picture->components > 3 || picture->bits < 2 || picture->bits > 8 * bytes || bytes > 2)
        return false;
    l.columns = picture->columns;
    l.n_components = (int)picture->components;
    l.precision = (int)picture->bits;
    while (next_segment(&s, &at, in, n)) {
        if (s.marker == SOF3)
            for (uint32_t c = 0; c < picture->components; c++)
                if (s.data[7 + 3 * c] != 0x11)
                    return false;
        if ((s.marker == DHT && !read_tables(&l, &s)) || (s.marker == DRI && !read_interval(&l, &s)))
            return false;
        if (s.marker == SOS) {
            l.in = in + at;
            l.end = in + n;
            return read_scan(&l, &s) && unpack_rows(&l, out, rows, picture->rows, bytes);
        }
    }
    return false;
}
