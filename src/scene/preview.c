#include "core/status.h"
#include "io/file_stream.h"
#include "scene/preview_slices.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/preview.h>

/* Pixels as a screen has them, three floats each, 0..1; row 0 is the top. */
typedef struct thumbnail {
    int width, height;
    float *rgb;
} thumbnail;

/* Which samples along one axis make a pixel: [first, first + n), each with its weight. */
typedef struct taps {
    int64_t first;
    int n;
    float *weight; /* in `weights` */
} taps;

typedef struct axis_taps {
    taps *at;
    float *weights;
} axis_taps;

static void free_taps(axis_taps *t)
{
    free(t->at);
    free(t->weights);
}

/* Pixels wider than samples are means of them, narrower ones lie on the line between two, or are the nearest. */
static void fill_taps(taps *t, int pixel, double scale, int64_t n, bool nearest)
{
    const double lo = pixel * scale, hi = lo + scale, middle = (lo + hi) / 2 - 0.5;
    if (scale > 1) {
        t->first = (int64_t)floor(lo);
        int64_t end = (int64_t)ceil(hi);
        end = end > n ? n : end;
        t->n = (int)(end - t->first);
        for (int i = 0; i < t->n; i++) {
            const double a = (double)(t->first + i), part = fmin(hi, a + 1) - fmax(lo, a);
            t->weight[i] = (float)(part / scale);
        }
        return;
    }
    const double at = nearest ? floor((lo + hi) / 2) : fmin(fmax(middle, 0), (double)(n - 1));
    t->first = (int64_t)at;
    t->n = t->first + 1 < n && !nearest ? 2 : 1;
    t->weight[0] = t->n == 1 ? 1 : (float)(1 - (at - floor(at)));
    t->weight[1] = 1 - t->weight[0];
}

static vv_status make_taps(axis_taps *out, int pixels, int64_t n, bool nearest)
{
    const double scale = (double)n / pixels;
    const size_t most = (size_t)ceil(scale) + 2;
    *out = (axis_taps){calloc((size_t)pixels, sizeof *out->at), malloc((size_t)pixels * most * sizeof(float))};
    if (!out->at || !out->weights)
        return vv_fail_memory((size_t)pixels * most * sizeof(float));
    for (int p = 0; p < pixels; p++) {
        out->at[p].weight = out->weights + (size_t)p * most;
        fill_taps(&out->at[p], p, scale, n, nearest);
    }
    return VV_OK;
}

static void mix(float out[3], const vvi_preview_slice *slice, const taps *x, const taps *y)
{
    float sum[3] = {0};
    for (int j = 0; j < y->n; j++)
        for (int i = 0; i < x->n; i++) {
            const float *from = slice->rgb + 3 * ((y->first + j) * slice->n[0] + x->first + i);
            const float w = x->weight[i] * y->weight[j];
            for (int k = 0; k < 3; k++)
                sum[k] += w * from[k];
        }
    memcpy(out, sum, sizeof sum);
}

/* A slice into a rectangle of the picture. */
static vv_status put_slice(thumbnail *t, const vvi_preview_slice *slice, int x0, int y0, int width, int height)
{
    axis_taps x = {0}, y = {0};
    vv_status st = make_taps(&x, width, slice->n[0], slice->nearest);
    if (st == VV_OK)
        st = make_taps(&y, height, slice->n[1], slice->nearest);
    for (int j = 0; j < height && st == VV_OK; j++)
        for (int i = 0; i < width; i++)
            mix(t->rgb + 3 * ((size_t)(y0 + j) * (size_t)t->width + (size_t)(x0 + i)), slice, &x.at[i], &y.at[j]);
    free_taps(&x);
    free_taps(&y);
    return st;
}

static int pixels_of(double length)
{
    return length < 1 ? 1 : (int)(length + 1e-6); /* rounded down, so that all fit */
}

/* The slices at one scale, as large as fits, on black. */
static vv_status make(thumbnail *out, const vvi_preview_slice *slices, int n, const vv_preview_options *o)
{
    const int gap = o->width / 100 > 0 ? o->width / 100 : 1;
    double across = 0, down = 0;
    vv_status st = VV_OK;
    for (int i = 0; i < n; i++) {
        across += (double)slices[i].n[0] * slices[i].step[0];
        down = fmax(down, (double)slices[i].n[1] * slices[i].step[1]);
    }
    const double room = fmax(o->width - (n - 1) * gap, n), scale = fmin(room / across, o->height * o->aspect / down);
    int w[VVI_SLICE_WAYS] = {0}, h[VVI_SLICE_WAYS] = {0}, used = (n - 1) * gap, tallest = 1;
    for (int i = 0; i < n; i++) {
        w[i] = pixels_of((double)slices[i].n[0] * slices[i].step[0] * scale);
        h[i] = pixels_of((double)slices[i].n[1] * slices[i].step[1] * scale / o->aspect);
        used += w[i];
        tallest = h[i] > tallest ? h[i] : tallest;
    }
    out->width = o->exact && o->width > used ? o->width : used;
    out->height = o->exact && o->height > tallest ? o->height : tallest;
    out->rgb = calloc((size_t)out->width * (size_t)out->height, 3 * sizeof *out->rgb);
    if (!out->rgb)
        return vv_fail_memory((size_t)out->width * (size_t)out->height * 3 * sizeof *out->rgb);
    int x = (out->width - used) / 2;
    for (int i = 0; i < n && st == VV_OK; x += w[i] + gap, i++)
        st = put_slice(out, &slices[i], x, (out->height - h[i]) / 2, w[i], h[i]);
    return st;
}

static vv_status make_image(vv_image **out, const thumbnail *t, vv_job *job)
{
    const vv_status st = vv_image_new(out, t->width, t->height, 0, job);
    if (st != VV_OK)
        return st;
    for (size_t p = 0; p < (size_t)t->width * (size_t)t->height; p++) {
        for (int k = 0; k < 3; k++)
            (*out)->rgba[4 * p + (size_t)k] = (float)vv_srgb_decode(t->rgb[3 * p + (size_t)k]);
        (*out)->rgba[4 * p + 3] = 1;
    }
    return VV_OK;
}

void vv_preview_options_init(vv_preview_options *options, size_t size)
{
    const vv_preview_options defaults = {.size = size, .width = 1024, .height = 512, .aspect = 1};
    memset(options, 0, size);
    memcpy(options, &defaults, size < sizeof defaults ? size : sizeof defaults);
}

vv_status vv_preview_new(vv_image **out, vv_file *file, const vv_preview_options *options, vv_job *job)
{
    vv_preview_options o;
    vvi_preview_slice slices[VVI_SLICE_WAYS] = {0};
    thumbnail t = {0};
    int n = 0;
    *out = NULL;
    vv_preview_options_init(&o, sizeof o);
    if (options)
        memcpy(&o, options, options->size < sizeof o ? options->size : sizeof o);
    const int longer = o.width > o.height ? o.width : o.height;
    if (o.width < 1 || o.height < 1 || longer > VV_PREVIEW_SIDE_MOST || !(o.aspect > 0))
        return vv_fail(VV_E_ARGUMENT, "a preview of %d x %d pixels: expected 1 to %d on either side", o.width, o.height,
                       VV_PREVIEW_SIDE_MOST);
    vv_status st = o.field ? VV_OK : vvi_file_make_repeatable(file, job);
    if (st == VV_OK || st == VV_E_UNSUPPORTED) /* some samples were read before: what is left may be enough */
        st = vvi_preview_slices_read(slices, &n, file, o.field, o.frame, o.detail > 0 ? o.detail : longer, job);
    if (st == VV_OK && (st = make(&t, slices, n, &o)) == VV_OK)
        st = make_image(out, &t, job);
    vvi_preview_slices_finish(slices);
    free(t.rgb);
    return st;
}
