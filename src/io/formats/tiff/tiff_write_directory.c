/* Directories of pages that are written. */
#include "io/formats/tiff/tiff.h"
#include "io/formats/tiff/tiff_write.h"
#include <math.h>
#include <string.h>

static void put(vvi_text *out, const vvi_tiff_writing *w, uint64_t v, int bytes)
{
    char b[8];
    for (int i = 0; i < bytes; i++)
        b[i] = (char)(v >> 8 * (w->big_endian ? bytes - 1 - i : i));
    vvi_text_add_n(out, b, (size_t)bytes);
}

enum { BYTE = 1, ASCII = 2, SHORT = 3, LONG = 4, RATIO = 5, LONG8 = 16 };

typedef struct directory {
    const vvi_tiff_writing *w;
    vvi_text *out;
    vvi_text apart; /* values that do not fit into their entry */
    uint64_t apart_at;
} directory;

static int bytes_of(int type)
{
    return type == ASCII ? 1 : type == SHORT ? 2 : type == LONG ? 4 : 8;
}

static void put_value(vvi_text *out, const vvi_tiff_writing *w, int type, uint64_t v)
{
    if (type == RATIO) { /* numerator above, denominator below */
        put(out, w, v >> 32, 4);
        put(out, w, v & UINT32_MAX, 4);
    } else {
        put(out, w, v, bytes_of(type));
    }
}

/* Values: a table, or one value that all n have. */
static void add(directory *d, int tag, int type, uint64_t n, const uint64_t *table, uint64_t value)
{
    const uint64_t bytes = n * (uint64_t)bytes_of(type), room = d->w->big ? 8 : 4;
    vvi_text *to = bytes > room ? &d->apart : d->out;
    put(d->out, d->w, (uint64_t)tag, 2);
    put(d->out, d->w, (uint64_t)type, 2);
    put(d->out, d->w, n, (int)room);
    if (bytes > room)
        put(d->out, d->w, d->apart_at + d->apart.n, (int)room);
    for (uint64_t i = 0; i < n; i++)
        put_value(to, d->w, type, table ? table[i] : value);
    for (uint64_t i = bytes; i < room; i++)
        put(d->out, d->w, 0, 1);
    if (d->apart.n % 2)
        put(&d->apart, d->w, 0, 1);
}

static void add_bytes(directory *d, int tag, int type, const char *text, uint64_t n)
{
    const uint64_t room = d->w->big ? 8 : 4;
    put(d->out, d->w, (uint64_t)tag, 2);
    put(d->out, d->w, (uint64_t)type, 2);
    put(d->out, d->w, n, (int)room);
    if (n > room)
        put(d->out, d->w, d->apart_at + d->apart.n, (int)room);
    vvi_text_add_n(n > room ? &d->apart : d->out, text, (size_t)n);
    for (uint64_t i = n; i < room; i++)
        put(d->out, d->w, 0, 1);
    if (d->apart.n % 2)
        put(&d->apart, d->w, 0, 1);
}

/* The nearest ratio of whole numbers, by continued fractions. */
static uint64_t ratio(double v)
{
    uint64_t p0 = 0, q0 = 1, p1 = 1, q1 = 0;
    double x = v;
    for (int i = 0; i < 32; i++) {
        const double whole = floor(x);
        if (whole > UINT32_MAX)
            break;
        const uint64_t a = (uint64_t)whole, p = a * p1 + p0, q = a * q1 + q0;
        if (p > UINT32_MAX || q > UINT32_MAX)
            break;
        p0 = p1;
        q0 = q1;
        p1 = p;
        q1 = q;
        if (x - whole < 1e-12 * v || fabs((double)p / (double)q - v) < 1e-12 * v)
            break;
        x = 1 / (x - whole);
    }
    return q1 > 0 ? p1 << 32 | q1 : (uint64_t)UINT32_MAX << 32 | 1;
}

static int sample_format(vv_type type)
{
    if (vv_type_is_float(type))
        return VVI_TIFF_FLOAT;
    return type == VV_TYPE_I8 || type == VV_TYPE_I16 || type == VV_TYPE_I32 || type == VV_TYPE_I64 ? VVI_TIFF_SIGNED
                                                                                                   : VVI_TIFF_UNSIGNED;
}

/* Entries go up by their numbers. */
static int add_entries(directory *d, bool first, const uint64_t *offsets, const uint64_t *counts)
{
    const vvi_tiff_writing *w = d->w;
    const uint64_t samples = (uint64_t)w->samples;
    const int place = w->big ? LONG8 : LONG;
    int n = 16;
    add(d, 254, LONG, 1, NULL, 0);
    add(d, 256, LONG, 1, NULL, (uint64_t)w->turn.grid.dims[0]);
    add(d, 257, LONG, 1, NULL, (uint64_t)w->turn.grid.dims[1]);
    add(d, 258, SHORT, samples, NULL, vv_type_bytes(w->info->type) * 8);
    add(d, 259, SHORT, 1, NULL, (uint64_t)w->compression);
    add(d, 262, SHORT, 1, NULL, w->samples > 1 ? VVI_TIFF_RGB : VVI_TIFF_BLACK_IS_ZERO);
    if (first && w->description) {
        add_bytes(d, 270, ASCII, w->description, strlen(w->description) + 1);
        n++;
    }
    add(d, 273, place, w->n_strips, offsets, 0);
    add(d, 277, SHORT, 1, NULL, samples);
    add(d, 278, LONG, 1, NULL, w->rows);
    add(d, 279, place, w->n_strips, counts, 0);
    add(d, 282, RATIO, 1, NULL, ratio(w->resolution[0]));
    add(d, 283, RATIO, 1, NULL, ratio(w->resolution[1]));
    add(d, 284, SHORT, 1, NULL, 1);
    add(d, 296, SHORT, 1, NULL, (uint64_t)w->resolution_unit);
    if (first && w->software) {
        add_bytes(d, 305, ASCII, w->software, strlen(w->software) + 1);
        n++;
    }
    add(d, 317, SHORT, 1, NULL, (uint64_t)w->predictor);
    if (w->samples == 4) {
        add(d, 338, SHORT, 1, NULL, w->multiplied ? 1 : 2); /* alpha */
        n++;
    }
    add(d, 339, SHORT, samples, NULL, (uint64_t)sample_format(w->info->type));
    if (first && w->xmp.n > 0) {
        add_bytes(d, 700, BYTE, w->xmp.s, w->xmp.n);
        n++;
    }
    if (first && w->extras.n_lengths > 0) {
        add(d, 50838, LONG, w->extras.n_lengths, w->extras.length, 0);
        add_bytes(d, 50839, BYTE, w->extras.data.s, w->extras.data.n);
        n += 2;
    }
    return n;
}

static int count_entries(const vvi_tiff_writing *w, bool first)
{
    const bool extras = w->extras.n_lengths > 0;
    const int once = (w->description != NULL) + (w->software != NULL) + (w->xmp.n > 0) + (extras ? 2 : 0);
    return 16 + (w->samples == 4) + (first ? once : 0);
}

void vvi_tiff_put_directory(vvi_text *out, const vvi_tiff_writing *w, bool first, uint64_t where,
                            const uint64_t *offsets, const uint64_t *counts, uint64_t next)
{
    const int n = count_entries(w, first);
    directory d = {
        .w = w, .out = out, .apart_at = where + (w->big ? 8 + 20 * (uint64_t)n + 8 : 2 + 12 * (uint64_t)n + 4)};
    put(out, w, (uint64_t)n, w->big ? 8 : 2);
    out->bad = out->bad || add_entries(&d, first, offsets, counts) != n;
    put(out, w, next, w->big ? 8 : 4);
    vvi_text_add_n(out, d.apart.s ? d.apart.s : "", d.apart.n);
    out->bad = out->bad || d.apart.bad;
    vvi_text_free(&d.apart);
}

void vvi_tiff_put_head(vvi_text *out, const vvi_tiff_writing *w, uint64_t first)
{
    vvi_text_add(out, w->big_endian ? "MM" : "II");
    put(out, w, w->big ? 43 : 42, 2);
    if (w->big) {
        put(out, w, 8, 2);
        put(out, w, 0, 2);
    }
    put(out, w, first, w->big ? 8 : 4);
}
