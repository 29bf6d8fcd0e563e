/* Reading any PNG: palettes, grey, 1 to 16 bits, interlaced, transparent. Everything without a profile that we know is
 * taken as sRGB. */
#include "io/images/png.h"

#include "core/job.h"
#include "core/memory.h"
#include "io/images/image_text.h"
#include "io/source.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIDE_MOST 65536
#define EXPANSION_MOST 1100 /* of deflate: 1032, and a little for the headers */

typedef struct reader {
    vv_source *source;
    vv_job *job;
    png_structp png;
    png_infop info;
    vvi_png_error error;
    int32_t width, height;
    bool wide;        /* 16 bits a channel */
    bool straight;    /* colours are not multiplied by alpha */
    size_t coded_row; /* bytes of a row in the file, before deflate */
    uint8_t *pixels;
    png_bytep *row;
} reader;

static void read_bytes(png_structp png, png_bytep out, size_t n)
{
    reader *r = png_get_io_ptr(png);
    r->error.status = vvi_source_read(r->source, out, n, "PNG data");
    if (r->error.status == VV_OK)
        r->error.status = vvi_job_poll(r->job);
    if (r->error.status != VV_OK)
        png_error(png, "read");
}

static vv_status failure(const reader *r)
{
    if (r->error.refused)
        return vv_fail_memory(r->error.refused);
    if (r->error.status != VV_OK)
        return r->error.status;
    char where[48];
    snprintf(where, sizeof where, "byte %llu", (unsigned long long)vvi_source_tell(r->source));
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), where, "the PNG is damaged: %s", r->error.text);
}

static vv_status open_reader(reader *r)
{
    r->png = vvi_png_begin_read(&r->error);
    r->info = r->png ? png_create_info_struct(r->png) : NULL;
    if (!r->info)
        return vv_fail_memory(4096);
    png_set_read_fn(r->png, r, read_bytes);
    png_set_user_limits(r->png, SIDE_MOST, SIDE_MOST);
    png_set_chunk_malloc_max(r->png, VVI_PNG_TEXT_MOST);
    return VV_OK;
}

static void close_reader(reader *r)
{
    png_destroy_read_struct(&r->png, &r->info, NULL);
    vvi_free(r->pixels);
    vvi_free(r->row);
}

static char *to_utf8(const char *s)
{
    return vvi_text_utf8(s, strlen(s));
}

static vv_status take_text(vv_text **text_out, size_t *n_text_out, const reader *r)
{
    png_textp text = NULL;
    const int n = png_get_text(r->png, r->info, &text, NULL);
    if (n <= 0)
        return VV_OK;
    vv_text *all = calloc((size_t)n, sizeof *all);
    bool bad = !all;
    for (int i = 0; !bad && i < n; i++) {
        all[i].key = to_utf8(text[i].key);
        all[i].value = to_utf8(text[i].text ? text[i].text : "");
        bad = !all[i].key || !all[i].value;
    }
    if (bad) {
        vv_text_free(all, all ? (size_t)n : 0);
        return vv_fail_memory((size_t)n * sizeof *all);
    }
    *text_out = all;
    *n_text_out = (size_t)n;
    return VV_OK;
}

/* Pixels --------------------------------------------------------------------------------------------------------- */

static void read_head(void *user)
{
    reader *r = user;
    png_read_info(r->png, r->info);
    r->width = (int32_t)png_get_image_width(r->png, r->info);
    r->height = (int32_t)png_get_image_height(r->png, r->info);
    r->wide = png_get_bit_depth(r->png, r->info) == 16;
    r->coded_row = png_get_rowbytes(r->png, r->info);
    png_set_expand(r->png);
    png_set_gray_to_rgb(r->png);
    png_set_add_alpha(r->png, r->wide ? 65535 : 255, PNG_FILLER_AFTER);
    png_set_interlace_handling(r->png);
    png_read_update_info(r->png, r->info);
}

/* No allocation larger than the bytes that can still arrive. */
static vv_status take_room(reader *r)
{
    bool exact;
    const uint64_t left = vvi_source_left(r->source, &exact);
    const size_t row = (size_t)r->width * (r->wide ? 8 : 4), bytes = row * (size_t)r->height;
    if ((uint64_t)r->coded_row * (uint64_t)r->height / EXPANSION_MOST > left)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL,
                          "the PNG says %d x %d pixels, but the %llu bytes that follow cannot hold them", r->width,
                          r->height, (unsigned long long)left);
    if (png_get_rowbytes(r->png, r->info) != row)
        return vv_fail_at(VV_E_INTERNAL, vvi_source_name(r->source), NULL, "libpng makes rows of %zu bytes, not %zu",
                          png_get_rowbytes(r->png, r->info), row);
    vv_status st = vvi_memory_plan(r->job, (uint64_t)bytes, "the image");
    if (st != VV_OK)
        return st;
    r->pixels = vvi_alloc(r->job, bytes, VVI_MEM_SCRATCH);
    r->row = vvi_alloc(r->job, (size_t)r->height * sizeof *r->row, VVI_MEM_SCRATCH);
    if (!r->pixels || !r->row)
        return vv_fail_memory(bytes);
    for (int32_t y = 0; y < r->height; y++)
        r->row[y] = r->pixels + (size_t)y * row;
    return VV_OK;
}

static void read_pixels(void *user)
{
    reader *r = user;
    png_read_image(r->png, r->row);
    png_read_end(r->png, r->info);
}

typedef struct conversion {
    const reader *reader;
    vv_image *image;
    float *linear; /* by code */
} conversion;

static vv_status convert_row(void *scratch, void *user, size_t y)
{
    (void)scratch;
    const conversion *c = user;
    const reader *r = c->reader;
    float *out = c->image->rgba + y * (size_t)r->width * 4;
    const uint8_t *in = r->row[y];
    for (int32_t x = 0; x < 4 * r->width; x += 4) {
        unsigned code[4];
        for (int k = 0; k < 4; k++)
            code[k] = r->wide ? (unsigned)in[2 * (x + k)] << 8 | in[2 * (x + k) + 1] : in[x + k];
        const float a = (float)code[3] / (r->wide ? 65535 : 255);
        for (int k = 0; k < 3; k++)
            out[x + k] = c->linear[code[k]] * (r->straight ? 1 : a);
        out[x + 3] = a;
    }
    return VV_OK;
}

static vv_status to_image(vv_image **out, const reader *r)
{
    static const vvi_work work = {.stage = "read image", .item = convert_row};
    conversion c = {.reader = r};
    vv_status st = vv_image_new(&c.image, r->width, r->height, 0, r->job);
    if (st != VV_OK)
        return st;
    const size_t codes = r->wide ? 65536 : 256;
    c.linear = vvi_alloc(r->job, codes * sizeof *c.linear, VVI_MEM_SCRATCH);
    if (!c.linear)
        st = vv_fail_memory(codes * sizeof *c.linear);
    for (size_t i = 0; c.linear && i < codes; i++)
        c.linear[i] = (float)vv_srgb_decode((double)i / (double)(codes - 1));
    if (st == VV_OK)
        st = vvi_parallel_for(r->job, &work, &c, (size_t)r->height);
    vvi_free(c.linear);
    if (st == VV_OK)
        *out = c.image;
    else
        vv_image_release(c.image);
    return st;
}

static vv_status read_image(vv_image **out, reader *r)
{
    vv_status st = open_reader(r);
    if (st != VV_OK)
        return st;
    if (!vvi_png_guard(r->png, read_head, r))
        return failure(r);
    if ((st = take_room(r)) != VV_OK)
        return st;
    if (!vvi_png_guard(r->png, read_pixels, r))
        return failure(r);
    return to_image(out, r);
}

vv_status vvi_png_read(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    reader r = {.source = source, .job = job};
    *out = NULL;
    vv_status st = read_image(out, &r);
    if (st == VV_OK && text_out && n_text_out && (st = take_text(text_out, n_text_out, &r)) != VV_OK) {
        vv_image_release(*out);
        *out = NULL;
    }
    close_reader(&r);
    return st;
}

vv_status vvi_png_read_straight(vv_image **out, vv_source *source, vv_job *job)
{
    reader r = {.source = source, .job = job, .straight = true};
    *out = NULL;
    const vv_status st = read_image(out, &r);
    close_reader(&r);
    return st;
}
