/* Writing JPEG: baseline, colours at full resolution but where speed counts more, sRGB as JFIF readers take it. */
#include "io/images/jpeg.h"

#include "core/job.h"
#include "core/memory.h"
#include "image/image_layer.h"
#include "image/image_srgb.h"
#include "io/sink.h"

#include <math.h>
#include <string.h>

#define ROOM ((size_t)64 << 10)
#define SEGMENT_MOST 65533 /* bytes that a marker's length can say, without the length itself */

typedef struct writer {
    struct jpeg_compress_struct jpeg;
    struct jpeg_destination_mgr destination;
    vvi_jpeg_error error;
    vv_sink *sink;
    vv_job *job;
    const vv_image *image;
    const vv_image_options *options;
    vvi_srgb_table table;
    uint8_t *room, *row, *segment;
} writer;

static writer *of(j_compress_ptr jpeg)
{
    return jpeg->client_data;
}

static void begin(j_compress_ptr jpeg)
{
    writer *w = of(jpeg);
    w->destination.next_output_byte = w->room;
    w->destination.free_in_buffer = ROOM;
}

static void put(writer *w, size_t n)
{
    const vv_status st = vvi_sink_write(w->sink, w->room, n);
    if (st != VV_OK)
        vvi_jpeg_leave((j_common_ptr)&w->jpeg, st);
}

static boolean flush(j_compress_ptr jpeg)
{
    put(of(jpeg), ROOM);
    begin(jpeg);
    return TRUE;
}

static void end(j_compress_ptr jpeg)
{
    put(of(jpeg), ROOM - of(jpeg)->destination.free_in_buffer);
}

/* A value that is longer than one segment goes on in others. */
static void write_text(writer *w, const vv_text *text)
{
    const size_t n_key = strlen(text->key), n = strlen(text->value);
    size_t at = 0;
    do {
        size_t head = n_key;
        memcpy(w->segment, text->key, n_key);
        if (at > 0)
            w->segment[head++] = '+';
        w->segment[head++] = '=';
        const size_t part = n - at < SEGMENT_MOST - head ? n - at : SEGMENT_MOST - head;
        memcpy(w->segment + head, text->value + at, part);
        jpeg_write_marker(&w->jpeg, JPEG_COM, w->segment, (unsigned)(head + part));
        at += part;
    } while (at < n);
}

static void write_rows(writer *w)
{
    const size_t width = (size_t)w->image->width;
    while (w->jpeg.next_scanline < w->jpeg.image_height) {
        const float *rgba = w->image->rgba + (size_t)w->jpeg.next_scanline * width * 4;
        for (size_t x = 0; x < width; x++)
            for (size_t c = 0; c < 3; c++)
                w->row[3 * x + c] = vvi_srgb_code(&w->table, rgba[4 * x + c]);
        JSAMPROW row = w->row;
        jpeg_write_scanlines(&w->jpeg, &row, 1);
        const vv_status st = vvi_job_poll(w->job);
        if (st != VV_OK)
            vvi_jpeg_leave((j_common_ptr)&w->jpeg, st);
    }
}

static void write_all(void *user)
{
    writer *w = user;
    jpeg_create_compress(&w->jpeg);
    w->jpeg.client_data = w;
    w->destination =
        (struct jpeg_destination_mgr){.init_destination = begin, .empty_output_buffer = flush, .term_destination = end};
    w->jpeg.dest = &w->destination;
    w->jpeg.image_width = (JDIMENSION)w->image->width;
    w->jpeg.image_height = (JDIMENSION)w->image->height;
    w->jpeg.input_components = 3;
    w->jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&w->jpeg);
    if (w->options->dpi > 0) {
        w->jpeg.density_unit = 1;
        w->jpeg.X_density = w->jpeg.Y_density = (UINT16)fmin(lround(w->options->dpi), UINT16_MAX);
    }
    jpeg_set_quality(&w->jpeg, w->options->quality, TRUE);
    for (int c = 0; c < 3; c++)
        w->jpeg.comp_info[c].h_samp_factor = w->jpeg.comp_info[c].v_samp_factor = c == 0 && w->options->fast ? 2 : 1;
    w->jpeg.optimize_coding = !w->options->fast;
    w->jpeg.dct_method = JDCT_ISLOW;
    jpeg_start_compress(&w->jpeg, TRUE);
    for (size_t i = 0; i < w->options->n_text; i++)
        write_text(w, &w->options->text[i]);
    write_rows(w);
    jpeg_finish_compress(&w->jpeg);
}

static vv_status check(const writer *w)
{
    const char *name = vvi_sink_name(w->sink);
    for (size_t i = 0; i < w->options->n_text; i++) {
        const char *key = w->options->text[i].key;
        if (!vvi_jpeg_is_key(key, strlen(key)))
            return vv_fail(
                VV_E_ARGUMENT,
                "the text key '%.90s' cannot be used in a JPEG: 1 to %d plain characters, no space, '=' or '+'", key,
                VVI_JPEG_KEY_MOST);
    }
    if (w->options->alpha && vvi_image_transparent(w->image))
        vvi_log(w->job, VV_LOG_WARNING, "io", "%s: JPEG has no transparency: the picture is written on black", name);
    return VV_OK;
}

static vv_status run(writer *w)
{
    if (vvi_jpeg_guard(&w->error, write_all, w))
        return VV_OK;
    if (w->error.status != VV_OK)
        return w->error.status;
    return vv_fail_at(VV_E_WRITE, vvi_sink_name(w->sink), NULL, "libjpeg: %s", w->error.text);
}

vv_status vvi_jpeg_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job)
{
    const size_t row = (size_t)image->width * 3, bytes = ROOM + row + SEGMENT_MOST;
    writer *w = vvi_alloc_zeroed(job, sizeof *w, VVI_MEM_SCRATCH);
    uint8_t *room = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    vv_status st = w && room ? VV_OK : vv_fail_memory(bytes);
    if (st == VV_OK) {
        w->sink = sink;
        w->job = job;
        w->image = image;
        w->options = options;
        w->room = room;
        w->row = room + ROOM;
        w->segment = w->row + row;
        w->jpeg.err = vvi_jpeg_error_init(&w->error);
        vvi_srgb_table_init(&w->table);
        if ((st = check(w)) == VV_OK)
            st = run(w);
        jpeg_destroy_compress(&w->jpeg); /* zeroed is fine */
    }
    vvi_free(room);
    vvi_free(w);
    return st;
}
