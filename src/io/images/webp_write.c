/* Writing WebP: lossless, or lossy where a quality is asked for; texts as XMP. */
#include "io/images/webp.h"

#include "core/job.h"
#include "core/memory.h"
#include "image/image_layer.h"
#include "io/images/image_codes.h"
#include "io/images/xmp.h"
#include "io/sink.h"

#include <webp/decode.h>
#include <webp/encode.h>
#include <webp/mux.h>

#define LEVEL 4  /* of 9: half a second for 1920 x 1080 shaded pixels, a quarter smaller than our PNG */
#define EFFORT 4 /* of 6, lossy: the library's own */

typedef struct writer {
    vv_sink *sink;
    vv_job *job;
    const vv_image *image;
    const vv_image_options *options;
    vv_status stopped; /* by the job */
} writer;

static int go_on(int percent, const WebPPicture *picture)
{
    writer *w = picture->user_data;
    (void)percent;
    w->stopped = vvi_job_poll(w->job);
    return w->stopped == VV_OK;
}

/* The library's pixels: 0xAARRGGBB. */
static vv_status fill(WebPPicture *picture, const writer *w)
{
    vvi_srgb_table table;
    const size_t width = (size_t)w->image->width;
    const int channels = w->options->alpha && vvi_image_transparent(w->image) ? 4 : 3;
    const vvi_codes codes = {.image = w->image, .channels = channels, .bits = 8, .table = &table};
    uint8_t *row = vvi_alloc(w->job, width * 4, VVI_MEM_SCRATCH);
    if (!row)
        return vv_fail_memory(width * 4);
    vvi_srgb_table_init(&table);
    for (int32_t y = 0; y < w->image->height; y++) {
        uint32_t *to = picture->argb + (size_t)y * (size_t)picture->argb_stride;
        vvi_codes_row(row, &codes, y);
        for (size_t x = 0; x < width; x++) {
            const uint8_t *p = row + x * (size_t)channels;
            const uint32_t a = channels == 4 ? p[3] : 255;
            to[x] = a << 24 | (uint32_t)p[0] << 16 | (uint32_t)p[1] << 8 | p[2];
        }
    }
    vvi_free(row);
    return VV_OK;
}

/* The library crashes where it is refused memory. At most, measured: 33 bytes a pixel and 15 MiB. */
#define NEEDS ((size_t)16 << 20)
#define NEEDS_PIXEL 40

/* It also takes some pictures that it had no memory for as written: they cannot be read. A fiftieth of the time. */
static vv_status prove(const WebPMemoryWriter *out, const writer *w)
{
    const size_t stride = (size_t)w->image->width * 4, n = stride * (size_t)w->image->height;
    uint8_t *pixels = vvi_alloc(w->job, n, VVI_MEM_SCRATCH);
    const bool fine = pixels && WebPDecodeBGRAInto(out->mem, out->size, pixels, n, (int)stride);
    vvi_free(pixels);
    return fine ? VV_OK : vv_fail_memory(n);
}

/* Without memory it does not always say that it is that. */
static vv_status fail_encode(const writer *w, const WebPPicture *picture, size_t n)
{
    if (w->stopped != VV_OK)
        return w->stopped;
    return picture->error_code == VP8_ENC_OK || picture->error_code == VP8_ENC_ERROR_OUT_OF_MEMORY ||
                   picture->error_code == VP8_ENC_ERROR_BITSTREAM_OUT_OF_MEMORY ||
                   picture->error_code == VP8_ENC_ERROR_BAD_WRITE /* into memory */
               ? vv_fail_memory(n)
               : vv_fail_at(VV_E_WRITE, vvi_sink_name(w->sink), NULL, "libwebp: error %d", picture->error_code);
}

static vv_status encode(WebPMemoryWriter *out, writer *w)
{
    WebPConfig config;
    WebPPicture picture;
    if (!WebPConfigInit(&config) || !WebPPictureInit(&picture))
        return vv_fail(VV_E_INTERNAL, "libwebp is not the version that VolVis was built with");
    if (w->options->quality > 0) {
        config.quality = (float)w->options->quality;
        config.method = EFFORT;
    } else if (!WebPConfigLosslessPreset(&config, LEVEL)) {
        return vv_fail(VV_E_INTERNAL, "libwebp has no level %d", LEVEL);
    }
    picture.use_argb = 1;
    picture.width = w->image->width;
    picture.height = w->image->height;
    picture.writer = WebPMemoryWrite;
    picture.custom_ptr = out;
    picture.progress_hook = go_on;
    picture.user_data = w;
    vv_status st = VV_OK;
    if (!WebPPictureAlloc(&picture))
        return vv_fail_memory((size_t)picture.width * (size_t)picture.height * 4);
    if ((st = fill(&picture, w)) == VV_OK)
        st = vvi_memory_is_there(NEEDS + NEEDS_PIXEL * (size_t)picture.width * (size_t)picture.height);
    if (st == VV_OK && !WebPEncode(&config, &picture))
        st = fail_encode(w, &picture, out->size);
    WebPPictureFree(&picture);
    return st == VV_OK ? prove(out, w) : st;
}

/* With texts the picture is a chunk among others. */
static vv_status assemble(WebPData *file, const WebPMemoryWriter *picture, const vvi_text *xmp)
{
    const WebPData image = {picture->mem, picture->size}, packet = {(const uint8_t *)xmp->s, xmp->n};
    WebPMux *mux = WebPMuxNew();
    const bool made = mux && WebPMuxSetImage(mux, &image, 0) == WEBP_MUX_OK &&
                      WebPMuxSetChunk(mux, "XMP ", &packet, 0) == WEBP_MUX_OK &&
                      WebPMuxAssemble(mux, file) == WEBP_MUX_OK;
    WebPMuxDelete(mux);
    return made ? VV_OK : vv_fail_memory(picture->size + xmp->n);
}

vv_status vvi_webp_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job)
{
    writer w = {.sink = sink, .job = job, .image = image, .options = options};
    WebPMemoryWriter picture;
    WebPData file = {0};
    vvi_text xmp = {0};
    WebPMemoryWriterInit(&picture);
    vvi_xmp_write(&xmp, options->text, options->n_text);
    vv_status st = xmp.bad ? vv_fail_memory(xmp.n) : encode(&picture, &w);
    if (st == VV_OK && xmp.n > 0 && (st = assemble(&file, &picture, &xmp)) == VV_OK)
        st = vvi_sink_write(sink, file.bytes, file.size);
    else if (st == VV_OK)
        st = vvi_sink_write(sink, picture.mem, picture.size);
    WebPDataClear(&file);
    WebPMemoryWriterClear(&picture);
    vvi_text_free(&xmp);
    return st;
}
