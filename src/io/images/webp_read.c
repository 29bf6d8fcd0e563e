/* Reading WebP: a picture that stands still, lossless or not; texts from XMP. */
#include "io/images/webp.h"

#include "core/job.h"
#include "core/memory.h"
#include "io/images/image_bytes.h"
#include "io/images/xmp.h"
#include "io/source.h"

#include <webp/decode.h>
#include <webp/mux.h>

/* The library calls a file damaged where it is refused memory. At most, measured: 5 bytes a pixel and 2 MiB. */
#define NEEDS ((size_t)4 << 20)
#define NEEDS_PIXEL 8

typedef struct reader {
    vv_source *source;
    vv_job *job;
    uint8_t *data;
    size_t n;
    int width, height;
    uint8_t *pixels; /* RGBA */
    bool straight;   /* colours are not multiplied by alpha */
} reader;

static vv_status bad(const reader *r, const char *what)
{
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL, "the WebP is damaged: %s", what);
}

/* What cannot be read of a text is no reason to refuse the picture: other programs write there as well. */
static vv_status take_text(vv_text **text_out, size_t *n_text_out, const reader *r)
{
    const WebPData file = {r->data, r->n};
    WebPData packet = {0};
    WebPMux *mux = WebPMuxCreate(&file, 0);
    vv_status st = VV_OK;
    if (mux && WebPMuxGetChunk(mux, "XMP ", &packet) == WEBP_MUX_OK)
        st = vvi_xmp_read_memory(text_out, n_text_out, packet.bytes, packet.size, vvi_source_name(r->source), r->job);
    WebPMuxDelete(mux);
    return st == VV_E_FORMAT || st == VV_E_UNSUPPORTED ? VV_OK : st;
}

/* What the first bytes say of its length: libwebp would decode a picture whose texts are cut off. */
static bool is_whole(const reader *r)
{
    const uint8_t *b = r->data + 4;
    return r->n >= 12 && ((uint64_t)b[3] << 24 | (uint64_t)b[2] << 16 | (uint64_t)b[1] << 8 | b[0]) + 8 <= r->n;
}

/* A few bytes may be a large picture of one colour: the memory that may be held is the only limit. */
static vv_status decode(reader *r)
{
    WebPBitstreamFeatures about;
    if (WebPGetFeatures(r->data, r->n, &about) != VP8_STATUS_OK)
        return bad(r, "its header cannot be read");
    if (!is_whole(r))
        return bad(r, "it ends too early");
    if (about.has_animation)
        return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(r->source), NULL,
                          "is an animated WebP; only single pictures can be read");
    r->width = about.width;
    r->height = about.height;
    const size_t pixels = (size_t)r->width * (size_t)r->height;
    vv_status st = vvi_memory_plan(r->job, pixels * 20, "the image");
    if (st == VV_OK && !(r->pixels = vvi_alloc(r->job, pixels * 4, VVI_MEM_SCRATCH)))
        st = vv_fail_memory(pixels * 4);
    if (st == VV_OK)
        st = vvi_memory_is_there(NEEDS + NEEDS_PIXEL * pixels);
    if (st != VV_OK)
        return st;
    WebPDecoderConfig config;
    if (!WebPInitDecoderConfig(&config))
        return vv_fail(VV_E_INTERNAL, "libwebp is not the version that VolVis was built with");
    config.output.colorspace = MODE_RGBA;
    config.output.is_external_memory = 1;
    config.output.u.RGBA = (WebPRGBABuffer){.rgba = r->pixels, .stride = 4 * r->width, .size = pixels * 4};
    const VP8StatusCode code = WebPDecode(r->data, r->n, &config);
    return code == VP8_STATUS_OK              ? VV_OK
           : code == VP8_STATUS_OUT_OF_MEMORY ? vv_fail_memory(pixels * 16)
                                              : bad(r, "it holds what no encoder writes");
}

static vv_status to_image(vv_image **out, const reader *r)
{
    float linear[256];
    const size_t n = (size_t)r->width * (size_t)r->height;
    vv_image *image;
    const vv_status st = vv_image_new(&image, r->width, r->height, 0, r->job);
    if (st != VV_OK)
        return st;
    for (int code = 0; code < 256; code++)
        linear[code] = (float)vv_srgb_decode(code / 255.0);
    for (size_t i = 0; i < n; i++) {
        const uint8_t *p = r->pixels + 4 * i;
        const float a = (float)p[3] / 255;
        for (int c = 0; c < 3; c++)
            image->rgba[4 * i + (size_t)c] = linear[p[c]] * (r->straight ? 1 : a);
        image->rgba[4 * i + 3] = a;
    }
    *out = image;
    return VV_OK;
}

vv_status vvi_webp_read(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    reader r = {.source = source, .job = job};
    *out = NULL;
    vv_status st = vvi_image_bytes(&r.data, &r.n, source, job);
    if (st == VV_OK && (st = decode(&r)) == VV_OK)
        st = to_image(out, &r);
    if (st == VV_OK && text_out && n_text_out && (st = take_text(text_out, n_text_out, &r)) != VV_OK) {
        vv_image_release(*out);
        *out = NULL;
    }
    vvi_free(r.pixels);
    vvi_free(r.data);
    return st;
}

vv_status vvi_webp_read_straight(vv_image **out, vv_source *source, vv_job *job)
{
    reader r = {.source = source, .job = job, .straight = true};
    *out = NULL;
    vv_status st = vvi_image_bytes(&r.data, &r.n, source, job);
    if (st == VV_OK && (st = decode(&r)) == VV_OK)
        st = to_image(out, &r);
    vvi_free(r.pixels);
    vvi_free(r.data);
    return st;
}

vv_status vvi_webp_read_text(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    reader r = {.source = source, .job = job};
    *text_out = NULL;
    *n_text_out = 0;
    vv_status st = vvi_image_bytes(&r.data, &r.n, source, job);
    if (st == VV_OK)
        st = take_text(text_out, n_text_out, &r);
    vvi_free(r.data);
    return st;
}
