#include "scene/preview_colors.h"
#include "core/status.h"
#include "grid/field.h"
#include "grid/fill_value.h"
#include "grid/label_color.h"
#include "grid/label_id.h"
#include "grid/percentile.h"
#include "io/channel_colors.h"
#include "io/file_stream.h"
#include "scene/colors.h"
#include "scene/two_sided.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>
#include <volvis/render.h>

enum { SEEN_MOST = 1 << 20 }; /* values kept for percentiles, of each channel */

typedef enum mode { MODE_CHANNELS, MODE_LENGTH, MODE_LABELS, MODE_COLORS } mode;

typedef struct window {
    bool given;
    double lo, hi;
    double rgb[3];   /* encoded */
    bool about_zero; /* seen in a map whose middle is zero */
    vvi_fills fills; /* values that stand for none */
    float *seen;
    size_t n_seen;
} window;

struct vvi_preview_colors {
    mode mode;
    vv_field_info info;
    vv_type type;
    int components; /* that are shown */
    double scale, offset, full;
    bool padded; /* values from padding[0] to padding[1] are padding, as the file says */
    double padding[2];
    window windows[VVI_CHANNELS_SHOWN];
    vv_label *labels; /* by value */
    size_t n_labels;
};

static double clamp(double v)
{
    return v > 0 ? v < 1 ? v : 1 : 0; /* NaN is none */
}

static void encode(double out[3], vv_color c)
{
    out[0] = vv_srgb_encode(clamp(c.r));
    out[1] = vv_srgb_encode(clamp(c.g));
    out[2] = vv_srgb_encode(clamp(c.b));
}

static int by_value(const void *a, const void *b)
{
    return vvi_label_compare(((const vv_label *)a)->value, ((const vv_label *)b)->value, false);
}

static vv_status take_labels(vvi_preview_colors *c, const vv_file *file)
{
    const vv_label *labels = vv_file_labels(file, &c->n_labels);
    if (c->n_labels == 0)
        return VV_OK;
    c->labels = malloc(c->n_labels * sizeof *labels);
    if (!c->labels)
        return vv_fail_memory(c->n_labels * sizeof *labels);
    memcpy(c->labels, labels, c->n_labels * sizeof *labels);
    qsort(c->labels, c->n_labels, sizeof *labels, by_value);
    return VV_OK;
}

static vv_status take_channels(vvi_preview_colors *c, const vv_field_info *info, const vv_file *file)
{
    size_t n;
    const vv_channel *channels = vv_file_channels(file, &n);
    const bool many = c->mode == MODE_CHANNELS && vvi_has_channels(info);
    for (int i = 0; i < (many ? c->components : 1); i++) {
        window *w = &c->windows[i];
        const bool own = (size_t)i < n && channels[i].has_color;
        encode(w->rgb, many || own ? vvi_channel_color(channels, n, (size_t)i) : (vv_color){1, 1, 1, 1});
        w->given = (size_t)i < n && channels[i].lo < channels[i].hi;
        w->lo = w->given ? channels[i].lo : 0;
        w->hi = w->given ? channels[i].hi : 1;
        w->seen = w->given ? NULL : malloc(SEEN_MOST * sizeof *w->seen);
        if (!w->given && !w->seen)
            return vv_fail_memory(SEEN_MOST * sizeof *w->seen);
    }
    return VV_OK;
}

vv_status vvi_preview_colors_new(vvi_preview_colors **out, const vv_file *file)
{
    const vv_field_info *info = vv_file_info(file);
    vvi_preview_colors *c = calloc(1, sizeof *c);
    *out = c;
    if (!c)
        return vv_fail_memory(sizeof *c);
    c->info = *info;
    c->type = info->type;
    c->scale = info->value_scale;
    c->offset = info->value_offset;
    c->full = vv_type_is_float(info->type) ? 1 : vvi_type_max(info->type);
    c->mode = vvi_field_has_colors(info)                                                     ? MODE_COLORS
              : info->meaning == VV_MEANING_LABEL                                            ? MODE_LABELS
              : info->meaning == VV_MEANING_VECTOR && info->components <= VVI_CHANNELS_SHOWN ? MODE_LENGTH
                                                                                             : MODE_CHANNELS;
    c->components = c->mode == MODE_CHANNELS && !vvi_has_channels(info) ? 1 : info->components;
    c->padded = vvi_file_padding(c->padding, file);
    for (int i = 0; i < 2; i++)
        c->padding[i] = c->padding[i] * c->scale + c->offset;
    if (c->mode == MODE_LABELS)
        return take_labels(c, file);
    return c->mode == MODE_COLORS ? VV_OK : take_channels(c, info, file);
}

void vvi_preview_colors_free(vvi_preview_colors *c)
{
    if (!c)
        return;
    for (int i = 0; i < VVI_CHANNELS_SHOWN; i++)
        free(c->windows[i].seen);
    free(c->labels);
    free(c);
}

bool vvi_preview_colors_nearest(const vvi_preview_colors *c)
{
    return c->mode == MODE_LABELS;
}

/* What the windows are over: each channel, or the length of the vector. Returns how many. */
static int values_of(double out[VVI_CHANNELS_SHOWN], const vvi_preview_colors *c, const char *sample)
{
    double square = 0;
    vvi_samples_to_f64(out, sample, c->type, (size_t)c->components);
    for (int i = 0; i < c->components; i++) {
        out[i] = out[i] * c->scale + c->offset;
        square += out[i] * out[i];
    }
    if (c->mode != MODE_LENGTH)
        return c->components;
    out[0] = sqrt(square);
    return 1;
}

void vvi_preview_colors_look(vvi_preview_colors *c, const char *sample)
{
    double v[VVI_CHANNELS_SHOWN];
    if (c->mode != MODE_CHANNELS && c->mode != MODE_LENGTH)
        return;
    const int n = values_of(v, c, sample);
    for (int i = 0; i < n; i++) {
        window *w = &c->windows[i];
        if (!w->given && isfinite(v[i]) && w->n_seen < SEEN_MOST)
            w->seen[w->n_seen++] = (float)v[i];
    }
}

static int ascending(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static double percentile_of(const window *w, double percent)
{
    const vvi_quantile q = vvi_quantile_at(percent, w->n_seen);
    return vvi_quantile_between(&q, w->seen[q.low], w->seen[q.high]);
}

/* The samples that were seen, as a field. */
static vv_status field_of(vv_field **out, const window *w, vv_job *job)
{
    vv_field_info seen = vv_field_info_default();
    seen.type = VV_TYPE_F32;
    seen.grid.dims[0] = (int64_t)w->n_seen;
    seen.grid.dims[1] = seen.grid.dims[2] = 1;
    return vv_field_new(out, &seen, w->seen, 0, NULL, NULL, job);
}

/* By the rule for whole fields; they are seen no more. */
static vv_status leave_fills_out(window *w, const vvi_preview_colors *c, vv_job *job)
{
    vv_field *field = NULL;
    size_t n = 0;
    if (vv_type_bytes(c->type) < 2 && !c->padded)
        return VV_OK;
    vv_status st = field_of(&field, w, job);
    if (st == VV_OK && c->padded)
        vvi_field_set_padding(field, c->padding[0], c->padding[1]);
    if (st == VV_OK)
        st = vvi_fills_of(&w->fills, field, 0, job);
    vv_field_release(field);
    for (size_t i = 0; i < w->n_seen && w->fills.n; i++)
        if (!vvi_fills_have(&w->fills, w->seen[i]))
            w->seen[n++] = w->seen[i];
    w->n_seen = w->fills.n ? n : w->n_seen;
    return st;
}

static void settle_window(window *w)
{
    const size_t last = w->n_seen - 1;
    qsort(w->seen, w->n_seen, sizeof *w->seen, ascending);
    w->lo = percentile_of(w, 1);
    w->hi = percentile_of(w, 99.8);
    if (!(w->hi > w->lo)) { /* nearly all alike: what differs is to be seen all the same */
        w->lo = w->seen[0];
        w->hi = w->seen[last] > w->lo ? w->seen[last] : w->lo + 1;
    }
}

/* As pictures show them: by the rule for whole fields, of the samples that were seen. */
static vv_status settle_about_zero(window *w, const vv_field_info *info, vv_job *job)
{
    vv_field *field = NULL;
    vvi_value_fit fit;
    vv_statistics *s = malloc(sizeof *s);
    vv_status st = s ? field_of(&field, w, job) : vv_fail_memory(sizeof *s);
    if (st == VV_OK)
        st = vv_field_statistics(s, field, 0, job);
    if (st == VV_OK && vvi_two_sided(&fit, info, s)) {
        w->about_zero = true;
        w->hi = vvi_two_sided_end(&fit, s);
        w->lo = -w->hi;
    }
    vv_field_release(field);
    free(s);
    return st;
}

vv_status vvi_preview_colors_settle(vvi_preview_colors *c, vv_job *job)
{
    vv_status st = VV_OK;
    for (int i = 0; i < VVI_CHANNELS_SHOWN && st == VV_OK; i++)
        if (c->windows[i].n_seen > 0 && (st = leave_fills_out(&c->windows[i], c, job)) == VV_OK)
            settle_window(&c->windows[i]);
    window *w = &c->windows[0];
    const bool grey = w->rgb[0] == w->rgb[1] && w->rgb[1] == w->rgb[2];
    if (st == VV_OK && c->mode == MODE_CHANNELS && c->components == 1 && grey && w->n_seen > 0)
        st = settle_about_zero(w, &c->info, job);
    return st;
}

static void label_color(float rgb[3], const vvi_preview_colors *c, const char *sample)
{
    double own[3], encoded[3];
    const vv_label key = {.value = vvi_label_of(sample, c->type)};
    const vv_label *label = c->n_labels ? bsearch(&key, c->labels, c->n_labels, sizeof *c->labels, by_value) : NULL;
    if (label && label->has_color) {
        encode(encoded, label->color.a > 0 ? label->color : (vv_color){0, 0, 0, 1});
    } else {
        vvi_label_color(own, key.value);
        encode(encoded, key.value == 0 ? (vv_color){0, 0, 0, 1} : (vv_color){own[0], own[1], own[2], 1});
    }
    for (int i = 0; i < 3; i++)
        rgb[i] = (float)encoded[i];
}

static void own_color(float rgb[3], const vvi_preview_colors *c, const char *sample)
{
    double v[4] = {0, 0, 0, c->full};
    vvi_samples_to_f64(v, sample, c->type, (size_t)c->components);
    for (int i = 0; i < 3; i++) {
        const double part = clamp(v[i] / c->full);
        rgb[i] = (float)((vv_type_is_float(c->type) ? vv_srgb_encode(part) : part) * clamp(v[3] / c->full));
    }
}

void vvi_preview_color(float rgb[3], const vvi_preview_colors *c, const char *sample)
{
    double v[VVI_CHANNELS_SHOWN], sum[3] = {0};
    if (c->mode == MODE_LABELS || c->mode == MODE_COLORS) {
        (c->mode == MODE_LABELS ? label_color : own_color)(rgb, c, sample);
        return;
    }
    const int n = values_of(v, c, sample);
    for (int i = 0; i < n; i++) {
        const window *w = &c->windows[i];
        if (vvi_fills_have(&w->fills, (double)(float)v[i]))
            v[i] = NAN;
        const double t = clamp((v[i] - w->lo) / (w->hi - w->lo));
        double seen[3] = {t * w->rgb[0], t * w->rgb[1], t * w->rgb[2]};
        vv_color mapped;
        if (w->about_zero && isfinite(v[i]) && vv_colormap_sample(&mapped, VVI_TWO_SIDED_MAP, t))
            encode(seen, mapped);
        for (int k = 0; k < 3; k++)
            sum[k] += seen[k];
    }
    for (int k = 0; k < 3; k++)
        rgb[k] = (float)clamp(sum[k]);
}
