/* Reading TIFF pictures: the first page as a volume of one slice, whose samples are then taken as colours: integers as
 * codes of sRGB, floats as light. */
#include "io/images/tiff_image.h"

#include "core/job.h"
#include "core/memory.h"
#include "io/formats/tiff/tiff.h"
#include "io/images/xmp.h"
#include "io/source.h"

#include <string.h>

enum { MULTIPLIED = 1, SEPARATE = 2 }; /* ExtraSamples: what alpha is */

typedef struct reader {
    vv_source *source;
    vv_job *job;
    vvi_tiff *tiff;
    vvi_tiff_reader file;
    vv_field_info info;
    float *linear; /* by code */
    int alpha;     /* 0: none */
    bool straight; /* colours are not to be multiplied by it */
} reader;

static const vvi_tiff_page *page_of(const reader *r)
{
    return &r->tiff->pages[0];
}

static vv_status open_page(reader *r)
{
    r->info = vv_field_info_default();
    r->tiff = vvi_alloc_zeroed(r->job, sizeof *r->tiff, VVI_MEM_SCRATCH);
    if (!r->tiff)
        return vv_fail_memory(sizeof *r->tiff);
    const vv_status st = vvi_source_spool(r->source, r->job);
    return st == VV_OK ? vvi_tiff_read_first_page(r->tiff, &r->file, r->source, r->job) : st;
}

/* What cannot be read of a text is no reason to refuse the picture: other programs write there as well. */
static vv_status take_text(vv_text **text_out, size_t *n_text_out, const reader *r)
{
    char *packet;
    const vvi_tiff_array *xmp = &page_of(r)->xmp;
    vv_status st = vvi_tiff_text(&packet, &r->file, xmp, VVI_XMP_MOST);
    if (st != VV_OK || !packet)
        return st;
    const size_t n = (size_t)(xmp->n < VVI_XMP_MOST ? xmp->n : VVI_XMP_MOST);
    st = vvi_xmp_read_memory(text_out, n_text_out, packet, n, vvi_source_name(r->source), r->job);
    vvi_free(packet);
    return st == VV_E_FORMAT || st == VV_E_UNSUPPORTED ? VV_OK : st;
}

static vv_status describe(reader *r, vv_notes *notes)
{
    const vvi_tiff_page *p = page_of(r);
    const char *name = vvi_source_name(r->source);
    vv_status st = vvi_tiff_check_page(p, r->source);
    if (st != VV_OK)
        return st;
    r->tiff->planes = vvi_alloc_zeroed(r->job, sizeof *r->tiff->planes, VVI_MEM_MODEL);
    if (!r->tiff->planes)
        return vv_fail_memory(sizeof *r->tiff->planes);
    r->tiff->channels = r->tiff->slices = r->tiff->frames = 1;
    if ((st = vvi_tiff_describe(&r->info, r->tiff, r->source, notes, r->job)) != VV_OK)
        return st;
    const bool colors = p->photometric == VVI_TIFF_RGB || p->photometric == VVI_TIFF_YCBCR;
    if (!colors && p->photometric != VVI_TIFF_BLACK_IS_ZERO)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "its PhotometricInterpretation is %d; pictures of grey or RGB can be read", p->photometric);
    if (r->info.type != VV_TYPE_U8 && r->info.type != VV_TYPE_U16 && r->info.type != VV_TYPE_F32)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "has samples of type %s; pictures of u8, u16 and f32 can be read",
                          vv_type_name(r->info.type));
    const int plain = colors ? 3 : 1;
    if (p->samples != plain && p->samples != plain + 1)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "has %d samples per pixel; a picture has %d, or one more: alpha", p->samples, plain);
    r->alpha = p->samples == plain ? 0 : p->n_extra == 0 ? SEPARATE : p->extra;
    return VV_OK;
}

/* Colours and alpha of a pixel, each from 0 to 1 where they are codes. */
static void take_pixel(float *rgba, const reader *r, const float *v, int n)
{
    const int colors = n < 3 ? 1 : 3;
    const bool known = n > colors && (r->alpha == MULTIPLIED || r->alpha == SEPARATE);
    const float a = known ? v[colors] : 1;
    for (int c = 0; c < 3; c++) {
        float light = v[colors == 3 ? c : 0];
        if (r->info.type != VV_TYPE_F32 && r->alpha == MULTIPLIED && a > 0) /* the codes were multiplied */
            light = (float)vv_srgb_decode(light < a ? light / a : 1) * a;
        else if (known && r->alpha == SEPARATE && !r->straight)
            light *= a;
        if (r->straight && r->alpha == MULTIPLIED && a > 0)
            light /= a;
        rgba[c] = light;
    }
    rgba[3] = a;
}

static void take_row(float *rgba, const reader *r, const uint8_t *row, int64_t step)
{
    const int n = r->info.components;
    const bool light = r->info.type != VV_TYPE_F32 && r->alpha != MULTIPLIED;
    const int colors = n < 3 ? 1 : 3;
    for (int64_t x = 0; x < r->info.grid.dims[0]; x++, rgba += 4, row += step) {
        float v[4] = {0};
        uint16_t code;
        for (int c = 0; c < n; c++) {
            const bool is_code = light && c < colors;
            if (r->info.type == VV_TYPE_U8) {
                v[c] = is_code ? r->linear[row[c]] : (float)row[c] / 255;
            } else if (r->info.type == VV_TYPE_U16) {
                memcpy(&code, row + 2 * c, 2);
                v[c] = is_code ? r->linear[code] : (float)code / 65535;
            } else {
                memcpy(&v[c], row + 4 * c, 4);
            }
        }
        take_pixel(rgba, r, v, n);
    }
}

static vv_status make_table(reader *r)
{
    const size_t n = r->info.type == VV_TYPE_U16 ? 65536 : 256;
    r->linear = vvi_alloc(r->job, n * sizeof *r->linear, VVI_MEM_SCRATCH);
    if (!r->linear)
        return vv_fail_memory(n * sizeof *r->linear);
    for (size_t i = 0; i < n; i++)
        r->linear[i] = (float)vv_srgb_decode((double)i / (double)(n - 1));
    return VV_OK;
}

static vv_status to_image(vv_image **out, const reader *r, const vv_field *field)
{
    vv_brick brick;
    const int64_t *dims = r->info.grid.dims;
    const vv_box all = {{0, 0, 0}, {dims[0], dims[1], dims[2]}};
    vv_image *image;
    vv_status st = vv_image_new(&image, (int32_t)dims[0], (int32_t)dims[1], 0, r->job);
    if (st != VV_OK)
        return st;
    if ((st = vv_field_brick(&brick, field, &all, r->job)) != VV_OK) {
        vv_image_release(image);
        return st;
    }
    for (int64_t y = 0; y < dims[1]; y++)
        take_row(image->rgba + y * dims[0] * 4, r, (const uint8_t *)brick.data + y * brick.stride[1], brick.stride[0]);
    vv_brick_release(&brick);
    *out = image;
    return VV_OK;
}

static vv_status read_samples(vv_image **out, reader *r)
{
    vv_field *field = NULL;
    vv_status st = make_table(r);
    if (st == VV_OK)
        st = vvi_tiff_read(&field, &r->info, r->tiff, r->source, 0, NULL, r->job);
    if (st == VV_OK)
        st = to_image(out, r, field);
    vv_field_release(field);
    return st;
}

static vv_status read_image(vv_image **out, reader *r)
{
    vv_notes *notes;
    vv_status st = vvi_notes_new(&notes, r->job);
    if (st != VV_OK)
        return st;
    if ((st = describe(r, notes)) == VV_OK)
        st = read_samples(out, r);
    vvi_notes_free(notes);
    return st;
}

vv_status vvi_tiff_image_read(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    reader r = {.source = source, .job = job};
    *out = NULL;
    vv_status st = open_page(&r);
    if (st == VV_OK && (st = read_image(out, &r)) == VV_OK && text_out && n_text_out &&
        (st = take_text(text_out, n_text_out, &r)) != VV_OK) {
        vv_image_release(*out);
        *out = NULL;
    }
    vvi_tiff_free(r.tiff);
    vvi_free(r.linear);
    return st;
}

vv_status vvi_tiff_image_read_straight(vv_image **out, vv_source *source, vv_job *job)
{
    reader r = {.source = source, .job = job, .straight = true};
    *out = NULL;
    vv_status st = open_page(&r);
    if (st == VV_OK)
        st = read_image(out, &r);
    vvi_tiff_free(r.tiff);
    vvi_free(r.linear);
    return st;
}

vv_status vvi_tiff_image_read_text(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    reader r = {.source = source, .job = job};
    *text_out = NULL;
    *n_text_out = 0;
    vv_status st = open_page(&r);
    if (st == VV_OK)
        st = take_text(text_out, n_text_out, &r);
    vvi_tiff_free(r.tiff);
    return st;
}
