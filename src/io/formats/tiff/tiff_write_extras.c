/* What ImageJ keeps of channels beside its description: tags 50838 and 50839 (tiff_imagej_extras.c says what is in
 * them). */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/tiff/tiff_write.h"
#include <math.h>
#include <string.h>
#include <volvis/image.h>

#define LABELS_MOST 20000 /* pages whose texts are kept: each has one, though it only names its channel */

static void put_word(vvi_text *t, uint32_t v, bool big_endian)
{
    char b[4];
    for (int i = 0; i < 4; i++)
        b[i] = (char)(v >> 8 * (big_endian ? 3 - i : i));
    vvi_text_add_n(t, b, 4);
}

static void put_kind(vvi_text *t, const char *kind, uint64_t n, bool big_endian)
{
    uint32_t name = 0;
    for (int i = 0; i < 4; i++)
        name = name << 8 | (uint8_t)kind[i];
    put_word(t, name, big_endian);
    put_word(t, (uint32_t)n, big_endian);
}

static void put_real(vvi_text *t, double v, bool big_endian)
{
    uint64_t u;
    memcpy(&u, &v, 8);
    put_word(t, (uint32_t)(big_endian ? u >> 32 : u), big_endian);
    put_word(t, (uint32_t)(big_endian ? u : u >> 32), big_endian);
}

/* UTF-8 to UTF-16; what lies beyond its first plane becomes '?'. */
static void put_label(vvi_text *t, const char *s, bool big_endian)
{
    for (size_t n; (n = vvi_utf8_length(s)) > 0; s += n) {
        const uint8_t *b = (const uint8_t *)s;
        const uint32_t c = n == 1   ? b[0]
                           : n == 2 ? (b[0] & 31u) << 6 | (b[1] & 63u)
                           : n == 3 ? (b[0] & 15u) << 12 | (b[1] & 63u) << 6 | (b[2] & 63u)
                                    : '?';
        const char pair[2] = {(char)(c >> 8), (char)c}, swapped[2] = {pair[1], pair[0]};
        vvi_text_add_n(t, big_endian ? pair : swapped, 2);
    }
}

/* A ramp from black to the colour: red, green, blue of 256 values; grey where there is none. */
static void put_lut(vvi_text *t, const vv_channel *channel)
{
    const double linear[3] = {channel->color.r, channel->color.g, channel->color.b};
    char ramp[768];
    for (int c = 0; c < 3; c++) {
        const double code = channel->has_color ? vv_srgb_encode(fmin(fmax(linear[c], 0), 1)) : 1;
        const int last = (int)(code * 255 + 0.5);
        for (int i = 0; i < 256; i++)
            ramp[256 * c + i] = (char)(uint8_t)((last * i + 127) / 255);
    }
    vvi_text_add_n(t, ramp, sizeof ramp);
}

/* What is known of the channels, and can be kept. */
typedef struct known {
    bool names, colors, ranges;
} known;

static known what_is_known(const vvi_tiff_writing *w)
{
    const vv_write_options *o = w->options;
    known k = {.ranges = true};
    for (size_t c = 0; c < o->n_channels; c++) {
        k.names = k.names || o->channels[c].name[0];
        k.colors = k.colors || o->channels[c].has_color;
        k.ranges = k.ranges && o->channels[c].lo < o->channels[c].hi; /* of all or of none */
    }
    k.names = k.names && w->channels > 1;
    if (k.names && w->n_pages > LABELS_MOST) {
        vvi_log(w->job, VV_LOG_WARNING, "io",
                "%s: has too many pages to name its channels; write .ome.tif to keep the names",
                vvi_sink_name(w->sink));
        k.names = false;
    }
    return k;
}

static void end_item(vvi_tiff_extras *x)
{
    x->length[x->n_lengths++] = x->data.n - x->ended;
    x->ended = x->data.n;
}

vv_status vvi_tiff_extras_build(vvi_tiff_extras *x, const vvi_tiff_writing *w)
{
    const vv_write_options *o = w->options;
    const vv_field_info *info = w->info;
    const bool big = w->big_endian;
    if (!o->channels || o->n_channels != (size_t)w->channels || w->samples > 1)
        return VV_OK;
    const known k = what_is_known(w);
    if (!k.names && !k.colors && !k.ranges)
        return VV_OK;
    const size_t room = 2 + (k.names ? (size_t)w->n_pages : 0) + o->n_channels;
    x->length = vvi_alloc(w->job, room * sizeof *x->length, VVI_MEM_SCRATCH);
    if (!x->length)
        return vv_fail_memory(room * sizeof *x->length);
    put_word(&x->data, 0x494a494a, big); /* "IJIJ" */
    if (k.names)
        put_kind(&x->data, "labl", w->n_pages, big);
    if (k.ranges)
        put_kind(&x->data, "rang", 1, big);
    if (k.colors)
        put_kind(&x->data, "luts", o->n_channels, big);
    end_item(x);
    for (uint64_t i = 0; i < w->n_pages && k.names; i++) {
        put_label(&x->data, o->channels[i % o->n_channels].name, big);
        end_item(x);
    }
    for (size_t c = 0; c < o->n_channels && k.ranges; c++) {
        put_real(&x->data, (o->channels[c].lo - info->value_offset) / info->value_scale, big);
        put_real(&x->data, (o->channels[c].hi - info->value_offset) / info->value_scale, big);
    }
    if (k.ranges)
        end_item(x);
    for (size_t c = 0; c < o->n_channels && k.colors; c++) {
        put_lut(&x->data, &o->channels[c]);
        end_item(x);
    }
    return x->data.bad ? vv_fail_memory(x->data.n) : VV_OK;
}

void vvi_tiff_extras_free(vvi_tiff_extras *x)
{
    vvi_text_free(&x->data);
    vvi_free(x->length);
    *x = (vvi_tiff_extras){0};
}
