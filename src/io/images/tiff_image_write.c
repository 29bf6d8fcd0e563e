/* Writing TIFF pictures: header, mark, directory, strips, which are made side by side. Bytes do not depend on the
 * number of threads. */
#include "io/images/tiff_image.h"

#include "core/job.h"
#include "core/memory.h"
#include "image/image_layer.h"
#include "io/formats/tiff/tiff.h"
#include "io/formats/tiff/tiff_write.h"
#include "io/images/image_codes.h"
#include "io/images/xmp.h"
#include "io/sample_writer.h"

#include <string.h>

#define STRIP_BYTES ((size_t)256 << 10)

typedef struct writer {
    vvi_tiff_writing tiff;
    vv_field_info info; /* of its samples */
    vv_write_options options;
    vvi_codes codes;
    uint8_t *rows, *coded; /* of all strips, raw_room and coded_room apart */
    size_t raw_room, coded_room;
    uint64_t *offsets, *counts;
} writer;

/* Floats of TIFF are linear and multiplied, as those of the image. */
static void float_row(uint8_t *out, const vv_image *image, int channels, int32_t y)
{
    const float *rgba = image->rgba + (size_t)y * (size_t)image->width * 4;
    for (int32_t x = 0; x < image->width; x++, rgba += 4, out += 4 * channels)
        memcpy(out, rgba, 4 * (size_t)channels);
}

/* Codes have their high byte first; the file's numbers are the machine's. */
static void fill_row(uint8_t *out, const writer *w, int32_t y)
{
    if (w->codes.bits == 32) {
        float_row(out, w->codes.image, w->codes.channels, y);
        return;
    }
    vvi_codes_row(out, &w->codes, y);
    if (w->codes.bits == 16 && vvi_order_swapped(true))
        vvi_swap_bytes(out, 2, w->tiff.row_bytes / 2);
}

static vv_status strip_item(void *scratch, void *user, size_t index)
{
    (void)scratch;
    const writer *w = user;
    const int32_t height = w->codes.image->height, rows = (int32_t)w->tiff.rows, y0 = (int32_t)index * rows;
    const int32_t y1 = height - y0 < rows ? height : y0 + rows;
    const size_t row = w->tiff.row_bytes;
    uint8_t *raw = w->rows + index * w->raw_room;
    size_t n = 0;
    for (int32_t y = y0; y < y1; y++)
        fill_row(raw + (size_t)(y - y0) * row, w, y);
    const vv_status st =
        vvi_tiff_encode(w->coded + index * w->coded_room, w->coded_room, &n, raw, (size_t)(y1 - y0) * row, &w->tiff);
    w->counts[index] = n;
    return st;
}

static void plan(writer *w, const vv_image *image, const vv_image_options *options)
{
    vvi_tiff_writing *t = &w->tiff;
    w->info = vv_field_info_default();
    w->info.type = options->bits == 32 ? VV_TYPE_F32 : options->bits == 16 ? VV_TYPE_U16 : VV_TYPE_U8;
    vv_write_options_init(&w->options, sizeof w->options);
    t->info = &w->info;
    t->options = &w->options;
    t->big_endian = !vvi_order_swapped(true);
    t->samples = w->codes.channels;
    t->turn.grid.dims[0] = image->width;
    t->turn.grid.dims[1] = image->height;
    t->compression = VVI_TIFF_DEFLATE;
    t->predictor = options->bits == 32 ? 1 : 2;
    t->multiplied = options->bits == 32;
    t->row_bytes = (size_t)image->width * (size_t)t->samples * (size_t)(options->bits / 8);
    t->rows = (uint32_t)(STRIP_BYTES / t->row_bytes + 1);
    t->rows = t->rows < (uint32_t)image->height ? t->rows : (uint32_t)image->height;
    t->n_strips = ((uint64_t)image->height + t->rows - 1) / t->rows;
    t->page_bytes = t->row_bytes * (size_t)image->height;
    t->big = t->page_bytes > (size_t)1 << 31;
    t->resolution[0] = t->resolution[1] = options->dpi > 0 ? options->dpi : 1;
    t->resolution_unit = options->dpi > 0 ? 2 : 1;
    for (size_t i = 0; i < options->n_text; i++)
        if (strcmp(options->text[i].key, "Software") == 0)
            t->software = options->text[i].value;
    vvi_xmp_write(&t->xmp, options->text, options->n_text);
    w->raw_room = t->rows * t->row_bytes;
    w->coded_room = vvi_tiff_encode_bound(t->compression, w->raw_room);
}

static vv_status make_strips(writer *w)
{
    static const vvi_work work = {.stage = "write image", .item = strip_item};
    const size_t n = (size_t)w->tiff.n_strips, bytes = n * (w->raw_room + w->coded_room);
    vv_status st = vvi_memory_plan(w->tiff.job, bytes, "the strips of the image");
    if (st != VV_OK)
        return st;
    w->rows = vvi_alloc(w->tiff.job, bytes, VVI_MEM_SCRATCH);
    w->offsets = vvi_alloc_zeroed(w->tiff.job, 2 * n * sizeof *w->offsets, VVI_MEM_SCRATCH);
    if (!w->rows || !w->offsets)
        return vv_fail_memory(bytes);
    w->coded = w->rows + n * w->raw_room;
    w->counts = w->offsets + n;
    return vvi_parallel_for(w->tiff.job, &work, w, n);
}

/* The directory's length does not depend on where strips lie. */
static vv_status write_head(writer *w)
{
    vvi_text head = {0}, directory = {0};
    const uint64_t where = (w->tiff.big ? 16 : 8) + VVI_TIFF_IMAGE_MARK_BYTES;
    vvi_tiff_put_head(&head, &w->tiff, where);
    vvi_text_add_n(&head, VVI_TIFF_IMAGE_MARK, VVI_TIFF_IMAGE_MARK_BYTES);
    vvi_tiff_put_directory(&directory, &w->tiff, true, where, w->offsets, w->counts, 0);
    uint64_t at = where + directory.n;
    for (uint64_t i = 0; i < w->tiff.n_strips; at += w->counts[i++])
        w->offsets[i] = at;
    vvi_text_cut(&directory, 0);
    vvi_tiff_put_directory(&directory, &w->tiff, true, where, w->offsets, w->counts, 0);
    vv_status st = head.bad || directory.bad || w->tiff.xmp.bad ? vv_fail_memory(directory.n) : VV_OK;
    if (st == VV_OK && (st = vvi_sink_write(w->tiff.sink, head.s, head.n)) == VV_OK)
        st = vvi_sink_write(w->tiff.sink, directory.s, directory.n);
    vvi_text_free(&head);
    vvi_text_free(&directory);
    return st;
}

vv_status vvi_tiff_image_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job)
{
    vvi_srgb_table table;
    writer w = {.tiff = {.sink = sink, .job = job}};
    vvi_srgb_table_init(&table);
    w.codes = (vvi_codes){
        .image = image,
        .channels = options->alpha && vvi_image_transparent(image) ? 4 : 3,
        .bits = options->bits,
        .table = &table,
    };
    plan(&w, image, options);
    vv_status st = make_strips(&w);
    if (st == VV_OK)
        st = write_head(&w);
    for (uint64_t i = 0; i < w.tiff.n_strips && st == VV_OK; i++)
        if ((st = vvi_sink_write(sink, w.coded + i * w.coded_room, (size_t)w.counts[i])) == VV_OK)
            st = vvi_job_poll(job);
    vvi_free(w.rows);
    vvi_free(w.offsets);
    vvi_text_free(&w.tiff.xmp);
    return st;
}
