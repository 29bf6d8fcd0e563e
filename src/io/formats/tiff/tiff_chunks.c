/* Chunks of a batch to samples of the output, on all threads. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/tiff/tiff_read.h"
#include "io/sample_writer.h"
#include <stdio.h>
#include <string.h>

/* One decoded row to the output ----------------------------------------------------------------------------------- */

/* Numbers of 1 to 15 bits, the highest bit first. */
static void unpack(uint8_t *out, const uint8_t *row, uint64_t first, size_t n, int bits)
{
    uint64_t at = first * (uint64_t)bits;
    for (size_t i = 0; i < n; i++, at += (uint64_t)bits) {
        uint32_t v = 0;
        for (int left = bits, got; left > 0; left -= got) {
            const uint64_t bit = at + (uint64_t)(bits - left);
            const int room = 8 - (int)(bit % 8);
            got = left < room ? left : room;
            v = v << got | (uint32_t)(row[bit / 8] >> (room - got) & ((1 << got) - 1));
        }
        if (bits < 8)
            out[i] = (uint8_t)v;
        else
            ((uint16_t *)(void *)out)[i] = (uint16_t)v;
    }
}

#define SCATTER(T)                                                                                                     \
    do {                                                                                                               \
        const T *from = (const T *)(const void *)row;                                                                  \
        T *to = (T *)(void *)out;                                                                                      \
        for (size_t i = 0; i < n; i++)                                                                                 \
            for (size_t s = 0; s < samples; s++)                                                                       \
                to[i * components + s] = from[i * samples + s];                                                        \
    } while (0)

static void scatter(uint8_t *out, const uint8_t *row, size_t n, size_t samples, size_t components, size_t bytes)
{
    if (samples == components)
        memcpy(out, row, n * samples * bytes);
    else if (bytes == 1)
        SCATTER(uint8_t);
    else if (bytes == 2)
        SCATTER(uint16_t);
    else if (bytes == 4)
        SCATTER(uint32_t);
    else
        SCATTER(uint64_t);
}

/* Samples [first, first + n) of a decoded row as elements of the field, in `line` where they have to change. */
static const uint8_t *elements(uint8_t *line, const uint8_t *row, uint64_t first, size_t n, const vvi_tiff_reading *r,
                               const vvi_tiff_page *p)
{
    if (r->tiff->half) {
        for (size_t i = 0; i < n; i++) {
            uint16_t half;
            memcpy(&half, row + (first + i) * 2, 2);
            ((float *)(void *)line)[i] = vvi_half_to_float(half);
        }
        return line;
    }
    if (p->bits % 8 != 0) {
        unpack(line, row, first, n, p->bits);
        return line;
    }
    memcpy(line, row + first * r->element, n * r->element);
    return line;
}

vvi_tiff_window vvi_tiff_window_of(const vvi_tiff_reading *r, const vvi_tiff_chunk *c)
{
    const vvi_tiff_page *p = c->page;
    const uint64_t across = vvi_tiff_chunks_across(p), down = vvi_tiff_chunks_down(p);
    const uint64_t left = c->number % across * p->chunk_width, top = c->number / across % down * p->chunk_height;
    const uint64_t lo_x = (uint64_t)r->box->lo[0], lo_y = (uint64_t)r->box->lo[1];
    const uint64_t hi_x = lo_x + (uint64_t)r->box->n[0], hi_y = lo_y + (uint64_t)r->box->n[1];
    return (vvi_tiff_window){.x0 = left > lo_x ? left : lo_x,
                             .x1 = left + p->chunk_width < hi_x ? left + p->chunk_width : hi_x,
                             .y0 = top > lo_y ? top : lo_y,
                             .y1 = top + p->chunk_height < hi_y ? top + p->chunk_height : hi_y,
                             .left = left,
                             .top = top};
}

static uint8_t *place_of(const vvi_tiff_reading *r, const vvi_tiff_chunk *c, uint64_t x, uint64_t y)
{
    const int64_t *n = r->box->n;
    const uint64_t at = ((uint64_t)c->slice * (uint64_t)n[1] + (y - (uint64_t)r->box->lo[1])) * (uint64_t)n[0] +
                        (x - (uint64_t)r->box->lo[0]);
    return r->out + at * r->pixel + (size_t)c->component * r->element;
}

/* Nothing is known of a pixel: NaN, or 0 in integers; 0 where the file leaves out what is blank. */
static void fill(const vvi_tiff_reading *r, const vvi_tiff_chunk *c, uint64_t y0, bool blank)
{
    const vvi_tiff_window a = vvi_tiff_window_of(r, c);
    const int byte = !blank && vv_type_is_float(r->info->type) ? 0xff : 0;
    const size_t bytes = vvi_tiff_chunk_samples(c->page) * r->element;
    for (uint64_t y = a.y0 > y0 ? a.y0 : y0; y < a.y1; y++)
        for (uint64_t x = a.x0; x < a.x1; x++)
            memset(place_of(r, c, x, y), byte, bytes);
}

/* Decoding -------------------------------------------------------------------------------------------------------- */

typedef struct scratch {
    uint8_t *decoded, *line;
} scratch;

static void reverse_bits(uint8_t *data, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        uint8_t b = data[i];
        b = (uint8_t)(b >> 4 | b << 4);
        b = (uint8_t)((b >> 2 & 0x33) | (b & 0x33) << 2);
        data[i] = (uint8_t)((b >> 1 & 0x55) | (b & 0x55) << 1);
    }
}

/* Decoders fill in for what a cut JPEG file lacks; a whole one has its end marker, with little or nothing after it. */
static bool has_jpeg_end(const uint8_t *coded, size_t n)
{
    for (size_t i = n; i-- > 2;)
        if (coded[i - 1] == 0xff && coded[i] == 0xd9)
            return true;
        else if (coded[i - 1] == 0xff && coded[i] == 0xda) /* the last scan begins */
            return false;
    return false;
}

/* Whole rows that a chunk gives; its bytes lie at *data afterwards. */
static uint64_t decode(const uint8_t **data, scratch *s, vvi_tiff_reading *r, vvi_tiff_chunk *c)
{
    const vvi_tiff_page *p = c->page;
    const uint32_t rows = vvi_tiff_chunk_rows(p, c->number);
    const uint64_t row = vvi_tiff_chunk_row_bytes(p);
    uint8_t *coded = r->batch + c->at;
    *data = coded;
    if (p->compression == VVI_TIFF_PLAIN) {
        if (p->fill_order == 2)
            reverse_bits(coded, c->n);
        if (p->bits > 8 && p->bits % 8 == 0 && vvi_order_swapped(p->big_endian))
            vvi_swap_bytes(coded, p->bits / 8u, c->n / (p->bits / 8u));
        return c->n / row < rows ? c->n / row : rows;
    }
    if (!s->decoded)
        return 0;
    *data = s->decoded;
    if (p->compression == VVI_TIFF_PNG)
        return vvi_slices_decode_png(s->decoded, (size_t)(row * rows), p, coded, c->n, c->why, sizeof c->why) ? rows
                                                                                                              : 0;
    if (p->is_file && p->compression == VVI_TIFF_JPEG && !has_jpeg_end(coded, c->n)) {
        snprintf(c->why, sizeof c->why, "the JPEG data end too early");
        return 0;
    }
    return vvi_tiff_decode(s->decoded, (size_t)(row * rows), p, rows, coded, c->n, r->tables, r->n_tables, c->why,
                           sizeof c->why)
               ? rows
               : 0;
}

static void finish(void *user, void *shared)
{
    scratch *s = user;
    (void)shared;
    if (!s)
        return;
    vvi_free(s->line);
    vvi_free(s->decoded);
    vvi_free(s);
}

static vv_status start(void **out, void *shared, int worker)
{
    vvi_tiff_reading *r = shared;
    uint64_t decoded = 0, line = 0;
    (void)worker;
    for (size_t i = 0; i < r->n_chunks; i++) {
        const vvi_tiff_page *p = r->chunks[i].page;
        const uint64_t bytes = vvi_tiff_chunk_row_bytes(p) * p->chunk_height;
        const uint64_t wide = (uint64_t)p->chunk_width * vvi_tiff_chunk_samples(p) * 8;
        decoded = p->compression != VVI_TIFF_PLAIN && bytes > decoded ? bytes : decoded;
        line = wide > line ? wide : line;
    }
    scratch *s = vvi_alloc_zeroed(r->job, sizeof *s, VVI_MEM_SCRATCH);
    if (!s)
        return vv_fail_memory(sizeof *s);
    s->line = vvi_alloc(r->job, (size_t)line, VVI_MEM_SCRATCH);
    s->decoded = decoded > 0 ? vvi_alloc(r->job, (size_t)decoded, VVI_MEM_SCRATCH) : NULL;
    if (!s->line || (decoded > 0 && !s->decoded)) {
        finish(s, shared);
        return vv_fail_memory((size_t)(line + decoded));
    }
    *out = s;
    return VV_OK;
}

static vv_status decode_item(void *user, void *shared, size_t index)
{
    scratch *s = user;
    vvi_tiff_reading *r = shared;
    vvi_tiff_chunk *c = &r->chunks[index];
    const vvi_tiff_page *p = c->page;
    const vvi_tiff_window a = vvi_tiff_window_of(r, c);
    const uint8_t *data;
    const size_t samples = vvi_tiff_chunk_samples(p), n = (size_t)(a.x1 - a.x0);
    if (c->blank) {
        fill(r, c, 0, true);
        return VV_OK;
    }
    const uint64_t row = vvi_tiff_chunk_row_bytes(p), rows = c->n > 0 ? decode(&data, s, r, c) : 0;
    uint64_t y = a.y0;
    for (; y < a.y1 && y - a.top < rows; y++) {
        const uint8_t *from = elements(s->line, data + (y - a.top) * row, (a.x0 - a.left) * samples, n * samples, r, p);
        scatter(place_of(r, c, a.x0, y), from, n, samples, (size_t)r->info->components, r->element);
    }
    if (y < a.y1) {
        fill(r, c, y, false);
        c->missing = (a.y1 - y) * n * samples;
    }
    return VV_OK;
}

vv_status vvi_tiff_flush(vvi_tiff_reading *r)
{
    const vvi_work work = {.start = start, .item = decode_item, .finish = finish};
    if (r->n_chunks == 0)
        return VV_OK;
    vv_status st = vvi_parallel_for(r->job, &work, r, r->n_chunks);
    for (size_t i = 0; i < r->n_chunks; i++) {
        const vvi_tiff_chunk *c = &r->chunks[i];
        const vvi_tiff_window a = vvi_tiff_window_of(r, c);
        r->missing += c->missing;
        r->done += (a.x1 - a.x0) * (a.y1 - a.y0) * vvi_tiff_chunk_samples(c->page);
        if (!r->why[0])
            memcpy(r->why, c->why, sizeof r->why);
    }
    r->n_chunks = r->used = 0;
    return st == VV_OK ? vvi_job_progress(r->job, "read", r->done, r->total) : st;
}
