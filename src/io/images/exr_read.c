/* Reading OpenEXR: the first part, where it is of scan lines, with R, G, B (or Y), A and the layers that we write. */
#include "io/images/exr.h"

#include "core/job.h"
#include "core/memory.h"
#include "image/image_layer.h"
#include "io/images/image_bytes.h"
#include "io/images/image_text.h"
#include "io/source.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define EXPANSION_MOST 1100 /* of deflate: 1032, and a little for the headers */

typedef struct reader {
    vv_source *source;
    vv_job *job;
    vvi_exr_file file;
    exr_context_t context;
    exr_decode_pipeline_t pipe;
    bool piped;
    const exr_attr_chlist_t *channels;
    exr_attr_box2i_t window;
    bool grey, opaque; /* Y for R, G and B; no A */
    int32_t rows;      /* of a chunk */
    uint8_t *chunk;    /* its channels, plane by plane */
    vv_image *image;
} reader;

static vv_status failure(const reader *r, exr_result_t code)
{
    if (r->file.refused)
        return vv_fail_memory(r->file.refused);
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL,
                      "the EXR is damaged or of a kind that is not read: %s",
                      r->file.text[0] ? r->file.text : exr_get_default_error_message(code));
}

static vv_status open_reader(reader *r)
{
    const vv_status st = vvi_image_bytes(&r->file.data, &r->file.n, r->source, r->job);
    if (st != VV_OK)
        return st;
    const exr_context_initializer_t start = vvi_exr_initializer(&r->file);
    const exr_result_t rc = exr_start_read(&r->context, vvi_source_name(r->source), &start);
    return rc == EXR_ERR_SUCCESS ? VV_OK : failure(r, rc);
}

static void close_reader(reader *r)
{
    if (r->piped)
        exr_decoding_destroy(r->context, &r->pipe);
    if (r->context)
        exr_finish(&r->context);
    vvi_exr_file_finish(&r->file);
    vvi_free(r->chunk);
}

/* Text ----------------------------------------------------------------------------------------------------------- */

static vv_status add_text(vv_text *text, size_t *n, const exr_attribute_t *attribute)
{
    const exr_attr_string_t *value = attribute->string;
    text[*n] = (vv_text){vvi_strdup(attribute->name), vvi_text_utf8(value->str, (size_t)value->length)};
    (*n)++;
    return text[*n - 1].key && text[*n - 1].value ? VV_OK : vv_fail_memory((size_t)value->length);
}

static vv_status take_text(vv_text **text_out, size_t *n_text_out, const reader *r)
{
    int32_t count = 0;
    const exr_attribute_t *attribute;
    size_t n = 0;
    vv_status st = VV_OK;
    if (exr_get_attribute_count(r->context, 0, &count) != EXR_ERR_SUCCESS || count <= 0)
        return VV_OK;
    vv_text *text = vvi_calloc((size_t)count, sizeof *text);
    if (!text)
        return vv_fail_memory((size_t)count * sizeof *text);
    for (int32_t i = 0; i < count && st == VV_OK; i++)
        if (exr_get_attribute_by_index(r->context, 0, EXR_ATTR_LIST_FILE_ORDER, i, &attribute) == EXR_ERR_SUCCESS &&
            attribute->type == EXR_ATTR_STRING && attribute->string->str)
            st = add_text(text, &n, attribute);
    if (st != VV_OK) {
        vv_text_free(text, n);
        return st;
    }
    *text_out = text;
    *n_text_out = n;
    return VV_OK;
}

/* Channels -------------------------------------------------------------------------------------------------------- */

static const exr_attr_chlist_entry_t *find(const reader *r, const char *name)
{
    for (int i = 0; i < r->channels->num_channels; i++)
        if (strcmp(r->channels->entries[i].name.str, name) == 0)
            return &r->channels->entries[i];
    return NULL;
}

static bool fits(const vvi_exr_channel *c, const exr_attr_chlist_entry_t *entry)
{
    const bool whole = vvi_layer_nth((size_t)c->layer)->whole;
    return entry && (entry->pixel_type == EXR_PIXEL_UINT) == whole;
}

/* A layer is there when all its channels are. */
static unsigned layers_of(const reader *r)
{
    unsigned layers = (1u << VV_LAYER_COUNT) - 1;
    for (const vvi_exr_channel *c = vvi_exr_channels; c->name; c++)
        if (c->layer >= 0 && !fits(c, find(r, c->name)))
            layers &= ~(1u << c->layer);
    return layers;
}

static vv_status check_channels(reader *r)
{
    const char *name = vvi_source_name(r->source);
    for (int i = 0; i < r->channels->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &r->channels->entries[i];
        if (entry->x_sampling != 1 || entry->y_sampling != 1)
            return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "channel '%s' has fewer samples than pixels: not read",
                              entry->name.str);
    }
    r->grey = find(r, "Y") && !find(r, "R") && !find(r, "G") && !find(r, "B");
    r->opaque = !find(r, "A");
    if (!r->grey && !find(r, "R") && !find(r, "G") && !find(r, "B"))
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "the EXR has neither R, G, B nor Y, so no picture");
    return VV_OK;
}

/* No more memory than the bytes of the file can fill. */
static vv_status check_size(const reader *r)
{
    const int64_t width = (int64_t)r->window.max.x - r->window.min.x + 1;
    const int64_t height = (int64_t)r->window.max.y - r->window.min.y + 1;
    uint64_t pixel = 0;
    for (int i = 0; i < r->channels->num_channels; i++)
        pixel += r->channels->entries[i].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
    if (width < 1 || height < 1 || width > 65536 || height > 65536 ||
        (uint64_t)width * (uint64_t)height * pixel / EXPANSION_MOST > r->file.n)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL,
                          "the EXR says %lld x %lld pixels, which its %zu bytes cannot hold", (long long)width,
                          (long long)height, r->file.n);
    return VV_OK;
}

static vv_status read_head(reader *r)
{
    exr_storage_t storage;
    exr_result_t rc = exr_get_storage(r->context, 0, &storage);
    if (rc == EXR_ERR_SUCCESS && storage != EXR_STORAGE_SCANLINE)
        return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(r->source), NULL,
                          "the EXR is tiled or has several samples per pixel; only scan lines are read");
    if (rc != EXR_ERR_SUCCESS || (rc = exr_get_channels(r->context, 0, &r->channels)) != EXR_ERR_SUCCESS ||
        (rc = exr_get_data_window(r->context, 0, &r->window)) != EXR_ERR_SUCCESS)
        return failure(r, rc);
    vv_status st;
    if ((st = check_size(r)) != VV_OK || (st = check_channels(r)) != VV_OK)
        return st;
    return vv_image_new(&r->image, r->window.max.x - r->window.min.x + 1, r->window.max.y - r->window.min.y + 1,
                        layers_of(r), r->job);
}

/* Pixels --------------------------------------------------------------------------------------------------------- */

static const vvi_exr_channel *channel_of(const reader *r, const char *name)
{
    const vvi_exr_channel *c = vvi_exr_channels;
    if (r->grey && strcmp(name, "Y") == 0)
        name = "R";
    while (c->name && strcmp(c->name, name) != 0)
        c++;
    return c->name && (c->layer < 0 || vvi_image_layer(r->image, (size_t)c->layer)) ? c : NULL;
}

static float from_half(uint16_t h)
{
    const double sign = h & 0x8000 ? -1 : 1;
    const int exponent = h >> 10 & 31, fraction = h & 1023;
    if (exponent == 31)
        return (float)(fraction ? (double)NAN : sign * (double)INFINITY);
    return (float)(sign * (exponent ? ldexp(1024 + fraction, exponent - 25) : ldexp(fraction, -24)));
}

static float number_at(const uint8_t *line, size_t x, uint16_t type)
{
    uint16_t half;
    uint32_t whole;
    float v;
    switch (type) {
    case EXR_PIXEL_HALF:
        memcpy(&half, line + 2 * x, sizeof half);
        return from_half(half);
    case EXR_PIXEL_UINT:
        memcpy(&whole, line + 4 * x, sizeof whole);
        return (float)whole;
    default:
        memcpy(&v, line + 4 * x, sizeof v);
        return v;
    }
}

/* One row of one channel to where its numbers belong; y counts from the top of the image. */
static void place_line(const reader *r, const exr_coding_channel_info_t *from, const uint8_t *line, size_t y)
{
    const vvi_exr_channel *c = channel_of(r, from->channel_name);
    const vvi_layer *layer = c && c->layer >= 0 ? vvi_layer_nth((size_t)c->layer) : NULL;
    const size_t stride = layer ? layer->channels : 4, width = (size_t)r->image->width;
    if (!c)
        return;
    float *to = layer ? vvi_image_layer(r->image, (size_t)c->layer) : r->image->rgba;
    to += stride * width * y + c->number;
    for (size_t x = 0; x < width; x++, to += stride) {
        if (layer && layer->whole)
            memcpy(to, line + 4 * x, sizeof *to);
        else
            *to = number_at(line, x, from->data_type);
    }
}

/* Channels as they lie in the file, each a plane of its own: version 3.1 of the library mistakes their order when it is
 * to interleave four, and does not always pass over those without a place. */
static void aim(reader *r)
{
    uint8_t *plane = r->chunk;
    for (int16_t i = 0; i < r->pipe.channel_count; i++) {
        exr_coding_channel_info_t *c = &r->pipe.channels[i];
        c->user_bytes_per_element = (uint8_t)c->bytes_per_element;
        c->user_data_type = c->data_type;
        c->user_pixel_stride = (uint8_t)c->bytes_per_element;
        c->user_line_stride = (uint8_t)c->bytes_per_element * r->image->width;
        c->decode_to_ptr = plane;
        plane += (size_t)c->user_line_stride * (size_t)r->rows;
    }
}

static void place_chunk(const reader *r, int32_t y, int32_t n_rows)
{
    for (int16_t i = 0; i < r->pipe.channel_count; i++) {
        const exr_coding_channel_info_t *c = &r->pipe.channels[i];
        for (int32_t row = 0; row < n_rows; row++)
            place_line(r, c, c->decode_to_ptr + (size_t)row * (size_t)c->user_line_stride,
                       (size_t)(y - r->window.min.y) + (size_t)row);
    }
}

static exr_result_t read_chunk(reader *r, int32_t y)
{
    exr_chunk_info_t chunk;
    exr_result_t rc = exr_read_scanline_chunk_info(r->context, 0, y, &chunk);
    if (rc != EXR_ERR_SUCCESS)
        return rc;
    rc = r->piped ? exr_decoding_update(r->context, 0, &chunk, &r->pipe)
                  : exr_decoding_initialize(r->context, 0, &chunk, &r->pipe);
    if (rc != EXR_ERR_SUCCESS)
        return rc;
    const bool first = !r->piped;
    r->piped = true;
    aim(r);
    if (first)
        rc = exr_decoding_choose_default_routines(r->context, 0, &r->pipe);
    if (rc == EXR_ERR_SUCCESS)
        rc = exr_decoding_run(r->context, 0, &r->pipe);
    const int64_t left = (int64_t)r->window.max.y - y + 1;
    if (rc == EXR_ERR_SUCCESS)
        place_chunk(r, y, left < r->rows ? (int32_t)left : r->rows);
    return rc;
}

static vv_status take_chunk_room(reader *r)
{
    size_t line = 0, bytes;
    for (int i = 0; i < r->channels->num_channels; i++)
        line += (size_t)r->image->width * (r->channels->entries[i].pixel_type == EXR_PIXEL_HALF ? 2 : 4);
    const vv_status st = vvi_mul_size(&bytes, line, (size_t)r->rows);
    if (st != VV_OK)
        return st;
    r->chunk = vvi_alloc_zeroed(r->job, bytes, VVI_MEM_SCRATCH);
    return r->chunk ? VV_OK : vv_fail_memory(bytes);
}

static vv_status read_chunks(reader *r)
{
    exr_result_t rc = exr_get_scanlines_per_chunk(r->context, 0, &r->rows);
    if (rc != EXR_ERR_SUCCESS || r->rows < 1)
        return failure(r, rc);
    vv_status st = take_chunk_room(r);
    for (int64_t y = r->window.min.y; y <= r->window.max.y && rc == EXR_ERR_SUCCESS && st == VV_OK; y += r->rows) {
        rc = read_chunk(r, (int32_t)y);
        st = vvi_job_poll(r->job);
    }
    return rc != EXR_ERR_SUCCESS ? failure(r, rc) : st;
}

static void complete(const reader *r)
{
    const size_t n = (size_t)r->image->width * (size_t)r->image->height;
    float *rgba = r->image->rgba;
    for (size_t i = 0; i < n && (r->grey || r->opaque); i++, rgba += 4) {
        if (r->grey)
            rgba[1] = rgba[2] = rgba[0];
        if (r->opaque)
            rgba[3] = 1;
    }
}

vv_status vvi_exr_read(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    reader r = {.source = source, .job = job, .file.job = job};
    *out = NULL;
    vv_status st;
    if ((st = open_reader(&r)) == VV_OK && (st = read_head(&r)) == VV_OK && (st = read_chunks(&r)) == VV_OK) {
        complete(&r);
        if (text_out && n_text_out)
            st = take_text(text_out, n_text_out, &r);
    }
    close_reader(&r);
    if (st == VV_OK)
        *out = r.image;
    else
        vv_image_release(r.image);
    return st;
}

vv_status vvi_exr_read_text(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    reader r = {.source = source, .job = job, .file.job = job};
    *text_out = NULL;
    *n_text_out = 0;
    vv_status st = open_reader(&r);
    if (st == VV_OK)
        st = take_text(text_out, n_text_out, &r);
    close_reader(&r);
    return st;
}
