/* PFM: "PF" or "Pf", width and height, a scale whose sign says the byte order, then rows from the bottom up.
 * https://www.pauldebevec.com/Research/HDR/PFM/ */
#include "io/images/pfm.h"

#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "image/image_layer.h"
#include "io/sink.h"
#include "io/source.h"
#include "registry.h"

#include <math.h>
#include <string.h>

#define SIDE_MOST 65536
#define WORD_MOST 32

/* Writing --------------------------------------------------------------------------------------------------------- */

/* Rows of a picture or of one of its layers. */
typedef struct plane {
    const vv_image *image;
    size_t channels;     /* written: 1 or 3 */
    const void *numbers; /* a pixel has `stride` of them */
    size_t stride;
    bool whole; /* uint32_t, else float */
} plane;

static void fill_row(uint8_t *out, const plane *p, int32_t y)
{
    const size_t n = (size_t)p->image->width, first = (size_t)y * n * p->stride;
    for (size_t x = 0; x < n; x++) {
        for (size_t c = 0; c < p->channels; c++, out += 4) {
            const size_t at = first + x * p->stride + c;
            const float v = p->whole ? (float)((const uint32_t *)p->numbers)[at] : ((const float *)p->numbers)[at];
            uint32_t bits;
            memcpy(&bits, &v, sizeof bits);
            for (int b = 0; b < 4; b++)
                out[b] = (uint8_t)(bits >> 8 * b);
        }
    }
}

static vv_status write_plane(vv_sink *sink, const plane *p, vv_job *job)
{
    const vv_image *image = p->image;
    const size_t bytes = (size_t)image->width * p->channels * 4;
    uint8_t *row = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!row)
        return vv_fail_memory(bytes);
    vv_status st =
        vvi_sink_printf(sink, "%s\n%d %d\n-1.0\n", p->channels == 3 ? "PF" : "Pf", image->width, image->height);
    for (int32_t y = image->height - 1; y >= 0 && st == VV_OK; y--) {
        fill_row(row, p, y);
        if ((st = vvi_sink_write(sink, row, bytes)) == VV_OK)
            st = vvi_job_poll(job);
    }
    vvi_free(row);
    return st;
}

vv_status vvi_pfm_write_layer(vv_sink *sink, const vv_image *image, size_t index, vv_job *job)
{
    const vvi_layer *layer = vvi_layer_nth(index);
    const plane p = {
        .image = image,
        .channels = layer->channels,
        .numbers = vvi_image_layer(image, index),
        .stride = layer->channels,
        .whole = layer->whole,
    };
    return write_plane(sink, &p, job);
}

static vv_status write_image(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job)
{
    const plane p = {.image = image, .channels = 3, .numbers = image->rgba, .stride = 4};
    if (options->alpha && vvi_image_transparent(image))
        vvi_log(job, VV_LOG_WARNING, "io", "%s: PFM has no transparency: the picture is written on black",
                vvi_sink_name(sink));
    return write_plane(sink, &p, job);
}

/* Reading --------------------------------------------------------------------------------------------------------- */

typedef struct head {
    size_t channels;
    int32_t width, height;
    bool big_endian;
} head;

static vv_status bad(const vv_source *source, const char *expected, const char *found)
{
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), "header", "expected %s, found '%s'", expected, found);
}

/* One word and the single white space after it: what follows the last one are numbers that may look like any. */
static vv_status read_word(char word[WORD_MOST], vv_source *source)
{
    size_t n = 0;
    for (;;) {
        char c;
        const vv_status st = vvi_source_read(source, &c, 1, "the PFM header");
        if (st != VV_OK)
            return st;
        const bool blank = c == ' ' || c == '\t' || c == '\n' || c == '\r';
        if (blank && n > 0)
            break;
        if (blank)
            continue;
        if (n + 1 == WORD_MOST || c < 33 || c > 126)
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), "header",
                              "has a word that does not belong in a PFM header");
        word[n++] = c;
    }
    word[n] = 0;
    return VV_OK;
}

static vv_status read_number(double *out, vv_source *source, const char *what, double lo, double hi)
{
    char word[WORD_MOST];
    const char *end = NULL;
    const vv_status st = read_word(word, source);
    if (st != VV_OK)
        return st;
    if (!vvi_scan_number(out, word, &end) || *end || !(*out >= lo && *out <= hi))
        return bad(source, what, word);
    return VV_OK;
}

static vv_status read_head(head *out, vv_source *source)
{
    char word[WORD_MOST];
    double width, height, scale;
    vv_status st = read_word(word, source);
    if (st != VV_OK)
        return st;
    if (strcmp(word, "PF") != 0 && strcmp(word, "Pf") != 0)
        return bad(source, "PF or Pf", word);
    out->channels = word[1] == 'F' ? 3 : 1;
    if ((st = read_number(&width, source, "a width of 1 to 65536", 1, SIDE_MOST)) != VV_OK ||
        (st = read_number(&height, source, "a height of 1 to 65536", 1, SIDE_MOST)) != VV_OK ||
        (st = read_number(&scale, source, "a scale other than 0", -1e30, 1e30)) != VV_OK)
        return st;
    if (width != floor(width) || height != floor(height) || scale == 0)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), "header",
                          "expected whole sizes and a scale other than 0");
    out->width = (int32_t)width;
    out->height = (int32_t)height;
    out->big_endian = scale > 0;
    return VV_OK;
}

static void take_row(float *rgba, const uint8_t *in, const head *h)
{
    for (int32_t x = 0; x < h->width; x++, rgba += 4) {
        for (size_t c = 0; c < 3; c++) {
            const uint8_t *b = in + 4 * ((size_t)x * h->channels + (h->channels == 3 ? c : 0));
            const uint32_t bits = h->big_endian
                                      ? (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3]
                                      : (uint32_t)b[3] << 24 | (uint32_t)b[2] << 16 | (uint32_t)b[1] << 8 | b[0];
            memcpy(&rgba[c], &bits, sizeof bits);
        }
        rgba[3] = 1;
    }
}

static vv_status read_rows(vv_image *image, const head *h, vv_source *source, vv_job *job)
{
    const size_t bytes = (size_t)h->width * h->channels * 4;
    uint8_t *row = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    vv_status st = row ? VV_OK : vv_fail_memory(bytes);
    for (int32_t y = h->height - 1; y >= 0 && st == VV_OK; y--) {
        if ((st = vvi_source_read(source, row, bytes, "pixels")) != VV_OK)
            break;
        take_row(image->rgba + (size_t)y * (size_t)h->width * 4, row, h);
        st = vvi_job_poll(job);
    }
    vvi_free(row);
    return st;
}

/* NOLINTNEXTLINE(readability-non-const-parameter): the table has one type for all readers */
static vv_status read_image(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    head h = {0};
    bool exact;
    (void)text_out; /* it holds none */
    (void)n_text_out;
    *out = NULL;
    vv_status st = read_head(&h, source);
    if (st != VV_OK)
        return st;
    const uint64_t need = (uint64_t)h.width * (uint64_t)h.height * h.channels * 4;
    const uint64_t left = vvi_source_left(source, &exact);
    if (need > left)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                          "the PFM says %d x %d pixels, which are %llu bytes, but at most %llu follow", h.width,
                          h.height, (unsigned long long)need, (unsigned long long)left);
    vv_image *image;
    if ((st = vv_image_new(&image, h.width, h.height, 0, job)) != VV_OK)
        return st;
    if ((st = read_rows(image, &h, source, job)) == VV_OK)
        *out = image;
    else
        vv_image_release(image);
    return st;
}

static int probe(const uint8_t *head_bytes, size_t n, const char *path)
{
    (void)path;
    const bool mark = n >= 4 && head_bytes[0] == 'P' && (head_bytes[1] == 'F' || head_bytes[1] == 'f');
    return mark && (head_bytes[2] == '\n' || head_bytes[2] == ' ') && head_bytes[3] >= '0' && head_bytes[3] <= '9' ? 2
                                                                                                                   : 0;
}

static const char *const suffixes[] = {".pfm", NULL};
static const int bits[] = {32, 0};

const vv_image_format vvi_image_format_pfm = {
    .api = VV_IMAGE_FORMAT_API,
    .name = "pfm",
    .doc = "PFM: linear 32-bit floats, premultiplied, no transparency and no text",
    .suffixes = suffixes,
    .probe = probe,
    .write = write_image,
    .read = read_image,
    .bits = bits,
};
