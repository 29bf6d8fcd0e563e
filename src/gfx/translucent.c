/* Translucent triangles of one tile: all that is seen of each pixel is kept, sorted by depth, lit, and blended from the
 * back to the front, for each sample alone, so that triangles with a common edge leave no line. */
#include "core/job.h"
#include "gfx/software.h"

/* Of one pixel and one triangle. */
typedef struct layer {
    uint32_t id;
    float near, x, y; /* mean of the samples; place in pixels */
    uint32_t samples; /* bits */
    uint32_t next;    /* 1 + number of another one of this pixel; 0: none */
} layer;

typedef struct layers {
    layer *layer;
    size_t n, room;
    uint32_t first[VVI_GFX_TILE * VVI_GFX_TILE]; /* 1 + number */
    uint32_t *order;                             /* of one pixel, the furthest first */
    size_t order_room;
    vv_job *job;
} layers;

/* Collecting ------------------------------------------------------------------------------------------------------ */

static vv_status add(layers *l, int32_t pixel, const layer *one)
{
    if (l->n == l->room) {
        const size_t room = l->room ? 2 * l->room : 4096;
        layer *more = vvi_realloc(l->job, l->layer, room * sizeof *more, VVI_MEM_SCRATCH);
        if (!more)
            return vv_fail_memory(room * sizeof *more);
        l->layer = more;
        l->room = room;
    }
    l->layer[l->n] = *one;
    l->layer[l->n++].next = l->first[pixel];
    l->first[pixel] = (uint32_t)l->n;
    return VV_OK;
}

/* A triangle with its inside to the right of its edges. */
typedef struct turned {
    int64_t x[3], y[3], dx[3], dy[3], bias[3]; /* edge k is opposite of corner k */
    double near[3], area;
    float lo, hi;
} turned;

static bool turn(turned *out, const vvi_gfx_triangle *t)
{
    const int64_t area =
        (int64_t)(t->x[1] - t->x[0]) * (t->y[2] - t->y[0]) - (int64_t)(t->y[1] - t->y[0]) * (t->x[2] - t->x[0]);
    for (int k = 0; k < 3; k++) {
        const int from = area < 0 ? (3 - k) % 3 : k;
        out->x[k] = t->x[from];
        out->y[k] = t->y[from];
        out->near[k] = (double)t->near[from];
    }
    for (int k = 0; k < 3; k++) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        out->dx[k] = out->x[b] - out->x[a];
        out->dy[k] = out->y[b] - out->y[a];
        out->bias[k] = out->dy[k] < 0 || (out->dy[k] == 0 && out->dx[k] > 0) ? 0 : -1;
    }
    out->area = fabs((double)area);
    out->lo = fminf(t->near[0], fminf(t->near[1], t->near[2]));
    out->hi = fmaxf(t->near[0], fmaxf(t->near[1], t->near[2]));
    return area != 0;
}

/* Nearness at a place in steps; false: outside. As vvi_gfx_raster_ref(). */
static bool meets(float *near, const turned *t, int64_t x, int64_t y)
{
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        const int a = (k + 1) % 3;
        const int64_t e = t->dx[k] * (y - t->y[a]) - t->dy[k] * (x - t->x[a]);
        if (e + t->bias[k] < 0)
            return false;
        sum += (double)e * t->near[k];
    }
    *near = fminf(fmaxf((float)(sum / t->area), t->lo), t->hi);
    return true;
}

static vv_status add_pixel(layers *l, const vvi_gfx_samples *s, const turned *t, int32_t x, int32_t y, uint32_t id)
{
    const vvi_gfx_pattern *p = s->pattern;
    const int32_t tx = x - s->x0, ty = y - s->y0, bx = tx / p->width, by = ty / p->height;
    const int first = ((ty % p->height) * p->width + tx % p->width) * p->samples;
    const float *there = s->near + 16 * (ptrdiff_t)(by * (VVI_GFX_TILE / p->width) + bx);
    layer one = {.id = id};
    int n = 0;
    for (int k = first; k < first + p->samples; k++) {
        const int64_t px = (int64_t)(s->x0 + bx * p->width) * VVI_GFX_STEPS + ((int64_t)p->x[k] << p->shift),
                      py = (int64_t)(s->y0 + by * p->height) * VVI_GFX_STEPS + ((int64_t)p->y[k] << p->shift);
        float near;
        if (!meets(&near, t, px, py) || !(near > there[k]))
            continue;
        one.samples |= 1u << (k - first);
        one.near += near;
        one.x += (float)px / VVI_GFX_STEPS;
        one.y += (float)py / VVI_GFX_STEPS;
        n++;
    }
    if (!n)
        return VV_OK;
    one.near /= (float)n;
    one.x /= (float)n;
    one.y /= (float)n;
    return add(l, ty * VVI_GFX_TILE + tx, &one);
}

static int32_t clamp(int64_t v, int32_t lo, int32_t hi)
{
    return v < lo ? lo : v > hi ? hi : (int32_t)v;
}

static vv_status add_triangle(layers *l, const vvi_gfx_samples *s, const vvi_gfx_triangle *triangle,
                              const vvi_gfx_area *window)
{
    turned t;
    vv_status st = VV_OK;
    if (!turn(&t, triangle))
        return VV_OK;
    int64_t x0 = t.x[0], x1 = t.x[0], y0 = t.y[0], y1 = t.y[0];
    for (int k = 1; k < 3; k++) {
        x0 = t.x[k] < x0 ? t.x[k] : x0;
        x1 = t.x[k] > x1 ? t.x[k] : x1;
        y0 = t.y[k] < y0 ? t.y[k] : y0;
        y1 = t.y[k] > y1 ? t.y[k] : y1;
    }
    const int32_t left = clamp(x0 >> 8, window->x0, window->x1), right = clamp((x1 >> 8) + 1, window->x0, window->x1);
    const int32_t top = clamp(y0 >> 8, window->y0, window->y1), bottom = clamp((y1 >> 8) + 1, window->y0, window->y1);
    for (int32_t y = top; y < bottom; y++)
        for (int32_t x = left; x < right && st == VV_OK; x++)
            st = add_pixel(l, s, &t, x, y, triangle->id);
    return st;
}

static vv_status collect(layers *l, vvi_gfx_tile_room *r, const vvi_gfx_software_picture *p, const vvi_gfx_area *area,
                         size_t tile)
{
    vv_status st = VV_OK;
    for (size_t b = 0; b < p->n_bins && st == VV_OK; b++) {
        const vvi_gfx_bin *bin = &p->bins[b];
        if (!bin->draw->translucent)
            continue;
        const vvi_gfx_area window = vvi_gfx_clipped(area, bin->draw->state.window);
        for (uint32_t e = bin->begin[tile]; e < bin->begin[tile + 1] && st == VV_OK; e++) {
            vvi_gfx_triangle t;
            vvi_gfx_bin_triangle(&t, bin, bin->entry[e]);
            st = add_triangle(l, &r->samples, &t, &window);
        }
        if (st == VV_OK)
            st = vvi_job_poll(l->job);
    }
    return st;
}

/* Blending -------------------------------------------------------------------------------------------------------- */

/* The pixel that is worked on: what its samples have, before and behind what the image has there; premultiplied. */
typedef struct stack {
    int32_t pixel; /* -1: none */
    float before[8][4], behind[8][4];
} stack;

static void over(float below[4], const float color[4])
{
    for (int c = 0; c < 4; c++)
        below[c] = color[c] + (1 - color[3]) * below[c];
}

static void finish_pixel(stack *k, const vvi_gfx_tile_room *r, const vvi_gfx_area *area, const vv_image *image)
{
    if (k->pixel < 0)
        return;
    const size_t at = (size_t)(area->y0 + k->pixel / VVI_GFX_TILE) * (size_t)image->width +
                      (size_t)(area->x0 + k->pixel % VVI_GFX_TILE);
    float *rgba = image->rgba + 4 * at, before[4] = {0}, behind[4] = {0};
    const int n = r->samples.pattern->samples;
    for (int s = 0; s < n; s++)
        for (int c = 0; c < 4; c++) {
            before[c] += k->before[s][c] / (float)n;
            behind[c] += k->behind[s][c] / (float)n;
        }
    const float through = 1 - rgba[3];
    for (int c = 0; c < 4; c++)
        rgba[c] += through * behind[c];
    over(rgba, before);
}

/* The fragments that were put together, in order. */
static void blend(stack *k, vvi_gfx_tile_room *r, const vvi_gfx_software_picture *p, const vvi_gfx_area *area,
                  const vv_image *image)
{
    const vvi_gfx_fragments *f = &r->fragments;
    vvi_gfx_light(r, p);
    for (size_t i = 0; i < f->n; i++) {
        if (r->pixel[i] != k->pixel) {
            finish_pixel(k, r, area, image);
            *k = (stack){.pixel = r->pixel[i]};
        }
        const float a = fminf(1, fmaxf(0, f->rgba[3][i]));
        const float color[4] = {a * f->rgba[0][i], a * f->rgba[1][i], a * f->rgba[2][i], a};
        for (int s = 0; s < r->samples.pattern->samples; s++)
            if (r->mask[i] >> s & 1)
                over(f->depth[i] < r->depth[k->pixel] ? k->before[s] : k->behind[s], color);
    }
    r->fragments.n = 0;
}

/* Whether a is to be blended before b: the further first; of equal ones the later first. */
static bool comes_first(const layer *a, const layer *b)
{
    return a->near < b->near || (a->near == b->near && a->id > b->id);
}

/* Heap sort: pixels may have many layers, and none may take long. */
static void sift(uint32_t *order, size_t i, size_t n, const layer *all)
{
    for (size_t child; (child = 2 * i + 1) < n; i = child) {
        if (child + 1 < n && comes_first(&all[order[child]], &all[order[child + 1]]))
            child++;
        if (!comes_first(&all[order[i]], &all[order[child]]))
            return;
        const uint32_t swap = order[i];
        order[i] = order[child];
        order[child] = swap;
    }
}

static vv_status sort_pixel(size_t *n_out, layers *l, int32_t pixel)
{
    size_t n = 0;
    for (uint32_t i = l->first[pixel]; i; i = l->layer[i - 1].next, n++)
        ;
    if (n > l->order_room) {
        uint32_t *more = vvi_realloc(l->job, l->order, 2 * n * sizeof *more, VVI_MEM_SCRATCH);
        if (!more)
            return vv_fail_memory(2 * n * sizeof *more);
        l->order = more;
        l->order_room = 2 * n;
    }
    n = 0;
    for (uint32_t i = l->first[pixel]; i; i = l->layer[i - 1].next)
        l->order[n++] = i - 1;
    for (size_t i = n / 2; i-- > 0;)
        sift(l->order, i, n, l->layer);
    for (size_t i = n; i-- > 1;) {
        const uint32_t swap = l->order[0];
        l->order[0] = l->order[i];
        l->order[i] = swap;
        sift(l->order, 0, i, l->layer);
    }
    *n_out = n;
    return VV_OK;
}

static vv_status blend_all(layers *l, vvi_gfx_tile_room *r, const vvi_gfx_software_picture *p, const vvi_gfx_area *area,
                           const vv_image *image)
{
    stack k = {.pixel = -1};
    r->fragments.n = 0;
    for (int32_t pixel = 0; pixel < VVI_GFX_TILE * VVI_GFX_TILE; pixel++) {
        size_t n = 0;
        const vv_status st = l->first[pixel] ? sort_pixel(&n, l, pixel) : VV_OK;
        if (st != VV_OK)
            return st;
        for (size_t i = 0; i < n; i++) {
            const layer *one = &l->layer[l->order[i]];
            const size_t at = r->fragments.n++;
            r->id[at] = one->id;
            r->fragments.x[at] = one->x;
            r->fragments.y[at] = one->y;
            r->pixel[at] = pixel;
            r->mask[at] = one->samples;
            if (r->fragments.n == r->n_most)
                blend(&k, r, p, area, image);
        }
    }
    blend(&k, r, p, area, image);
    finish_pixel(&k, r, area, image);
    return VV_OK;
}

vv_status vvi_gfx_translucent(vvi_gfx *gfx, vvi_gfx_tile_room *r, const vvi_gfx_area *area, size_t tile)
{
    const vvi_gfx_software_picture *p = gfx->own;
    layers *l = vvi_alloc_zeroed(gfx->job, sizeof *l, VVI_MEM_SCRATCH);
    if (!l)
        return vv_fail_memory(sizeof *l);
    l->job = gfx->job;
    vv_status st = collect(l, r, p, area, tile);
    if (st == VV_OK && l->n)
        st = blend_all(l, r, p, area, gfx->target.image);
    vvi_free(l->layer);
    vvi_free(l->order);
    vvi_free(l);
    return st;
}
