/* Writing OpenEXR: one part of scan lines, ZIP, one channel a number of a pixel. The file is made in memory and then
 * sent, since the library fills in its table of chunks last. */
#include "io/images/exr.h"

#include "core/job.h"
#include "core/memory.h"
#include "image/image_layer.h"
#include "io/sink.h"

#include <stdio.h>
#include <string.h>

typedef struct writer {
    vv_sink *sink;
    const vv_image *image;
    const vv_image_options *options;
    vv_job *job;
    vvi_exr_file file;
    exr_context_t context;
    exr_encode_pipeline_t pipe;
    bool piped; /* the pipeline holds something */
} writer;

static vv_status failure(const writer *w, exr_result_t code)
{
    if (w->file.status != VV_OK)
        return w->file.status;
    if (w->file.refused)
        return vv_fail_memory(w->file.refused);
    return vv_fail_at(VV_E_WRITE, vvi_sink_name(w->sink), NULL, "OpenEXR: %s",
                      w->file.text[0] ? w->file.text : exr_get_default_error_message(code));
}

static bool is_written(const writer *w, const vvi_exr_channel *c)
{
    return c->layer < 0 || (w->options->layers >> c->layer & 1);
}

static exr_pixel_type_t type_of(const writer *w, const vvi_exr_channel *c)
{
    if (c->layer >= 0 && vvi_layer_nth((size_t)c->layer)->whole)
        return EXR_PIXEL_UINT;
    return c->layer < 0 && w->options->bits == 16 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT; /* half is too short for depths */
}

static exr_result_t declare(writer *w)
{
    int part = 0;
    exr_result_t rc;
    if ((rc = exr_set_longname_support(w->context, 1)) != EXR_ERR_SUCCESS ||
        (rc = exr_add_part(w->context, NULL, EXR_STORAGE_SCANLINE, &part)) != EXR_ERR_SUCCESS ||
        (rc = exr_initialize_required_attr_simple(w->context, part, w->image->width, w->image->height,
                                                  EXR_COMPRESSION_ZIP)) != EXR_ERR_SUCCESS)
        return rc;
    for (const vvi_exr_channel *c = vvi_exr_channels; c->name && rc == EXR_ERR_SUCCESS; c++)
        if (is_written(w, c))
            rc = exr_add_channel(w->context, part, c->name, type_of(w, c), EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    for (size_t i = 0; i < w->options->n_text && rc == EXR_ERR_SUCCESS; i++)
        rc = exr_attr_set_string(w->context, part, w->options->text[i].key, w->options->text[i].value);
    return rc == EXR_ERR_SUCCESS ? exr_write_header(w->context) : rc;
}

/* Where the pipeline finds the numbers of the chunk that begins at row y. */
static void aim(writer *w, int32_t y)
{
    const size_t width = (size_t)w->image->width;
    for (int16_t i = 0; i < w->pipe.channel_count; i++) {
        exr_coding_channel_info_t *to = &w->pipe.channels[i];
        const vvi_exr_channel *c = vvi_exr_channels;
        while (strcmp(c->name, to->channel_name) != 0)
            c++;
        const size_t stride = c->layer < 0 ? 4 : vvi_layer_nth((size_t)c->layer)->channels;
        const void *numbers = c->layer < 0 ? w->image->rgba : vvi_image_layer(w->image, (size_t)c->layer);
        to->user_bytes_per_element = 4;
        to->user_data_type = type_of(w, c) == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        to->user_pixel_stride = (int32_t)(4 * stride);
        to->user_line_stride = (int32_t)(4 * stride * width);
        to->encode_from_ptr = (const uint8_t *)numbers + 4 * (stride * width * (size_t)y + c->number);
    }
}

static exr_result_t write_chunk(writer *w, int32_t y)
{
    exr_chunk_info_t chunk;
    exr_result_t rc = exr_write_scanline_chunk_info(w->context, 0, y, &chunk);
    if (rc != EXR_ERR_SUCCESS)
        return rc;
    rc = w->piped ? exr_encoding_update(w->context, 0, &chunk, &w->pipe)
                  : exr_encoding_initialize(w->context, 0, &chunk, &w->pipe);
    if (rc != EXR_ERR_SUCCESS)
        return rc;
    aim(w, y);
    if (!w->piped)
        rc = exr_encoding_choose_default_routines(w->context, 0, &w->pipe);
    w->piped = true;
    return rc == EXR_ERR_SUCCESS ? exr_encoding_run(w->context, 0, &w->pipe) : rc;
}

static vv_status write_chunks(writer *w)
{
    int32_t rows = 0;
    exr_result_t rc = exr_get_scanlines_per_chunk(w->context, 0, &rows);
    vv_status st = VV_OK;
    for (int32_t y = 0; y < w->image->height && rc == EXR_ERR_SUCCESS && st == VV_OK; y += rows) {
        rc = write_chunk(w, y);
        st = vvi_job_poll(w->job);
    }
    return rc != EXR_ERR_SUCCESS ? failure(w, rc) : st;
}

static vv_status write_file(writer *w)
{
    const exr_context_initializer_t start = vvi_exr_initializer(&w->file);
    exr_result_t rc = exr_start_write(&w->context, vvi_sink_name(w->sink), EXR_WRITE_FILE_DIRECTLY, &start);
    if (rc != EXR_ERR_SUCCESS)
        return failure(w, rc);
    rc = declare(w);
    vv_status st = rc == EXR_ERR_SUCCESS ? write_chunks(w) : failure(w, rc);
    if (w->piped)
        exr_encoding_destroy(w->context, &w->pipe);
    rc = exr_finish(&w->context);
    return st == VV_OK && rc != EXR_ERR_SUCCESS ? failure(w, rc) : st;
}

vv_status vvi_exr_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job)
{
    writer w = {.sink = sink, .image = image, .options = options, .job = job, .file.job = job};
    vv_status st = write_file(&w);
    if (st == VV_OK)
        st = vvi_sink_write(sink, w.file.data, w.file.n);
    vvi_exr_file_finish(&w.file);
    return st;
}
