#include "render/common/transfer_plane.h"
#include "core/memory.h"
#include <math.h>

enum { SIDE = VVI_PLANE_SIDE };

/* How far inside a region: 0 outside, 1 in its middle and wherever its edge does not reach. */
static double share_inside(const vv_region *r, double value, double gradient, double top)
{
    const double up = isfinite(r->gradient_hi) ? r->gradient_hi : top;
    if (gradient < r->gradient_lo || gradient > r->gradient_hi)
        return 0;
    const double t = up > r->gradient_lo ? fmin((gradient - r->gradient_lo) / (up - r->gradient_lo), 1) : 0;
    const double lo = r->value_lo + t * (r->top_lo - r->value_lo), hi = r->value_hi + t * (r->top_hi - r->value_hi);
    const double half = (hi - lo) / 2;
    if (!(half > 0) || value < lo || value > hi)
        return 0;
    const double in = 1 - fabs(value - (lo + hi) / 2) / half;
    return r->edge > 0 ? fmin(in / r->edge, 1) : 1;
}

void vvi_transfer_plane_evaluate(double out[4], const vv_classification *c, double value, double gradient)
{
    for (int i = 0; i < 4; i++)
        out[i] = 0;
    for (size_t i = 0; i < c->n_regions; i++) {
        const vv_region *r = &c->regions[i];
        const double alpha = r->opacity * share_inside(r, value, gradient, c->gradient_top);
        const double kappa = vvi_transfer_kappa(alpha, c->opacity_length) * c->opacity_scale;
        for (int x = 0; x < 3; x++)
            out[x] += kappa * r->color[x];
        out[3] += kappa;
    }
}

/* From a little below all regions to a little above: the first and the last column are clear. */
static void find_columns(vvi_transfer_plane *out, const vv_classification *c)
{
    out->lo = INFINITY;
    out->hi = -INFINITY;
    for (size_t i = 0; i < c->n_regions; i++) {
        out->lo = fmin(out->lo, fmin(c->regions[i].value_lo, c->regions[i].top_lo));
        out->hi = fmax(out->hi, fmax(c->regions[i].value_hi, c->regions[i].top_hi));
    }
    const double margin = out->hi > out->lo ? (out->hi - out->lo) / (SIDE - 3) : 1;
    out->lo -= margin;
    out->hi += margin;
    out->top = c->gradient_top;
}

static void fill(vvi_transfer_plane *out, uint32_t *running, const vv_classification *c)
{
    running[0] = 0;
    for (size_t u = 0; u < SIDE; u++) {
        bool any = false;
        for (size_t v = 0; v < SIDE; v++) {
            const double value = out->lo + (out->hi - out->lo) * (double)u / (SIDE - 1);
            const double gradient = out->top * (double)v / (SIDE - 1);
            double rgbk[4];
            vvi_transfer_plane_evaluate(rgbk, c, value, gradient);
            for (int i = 0; i < 4; i++)
                out->rgbk[4 * (v * SIDE + u) + (size_t)i] = u == 0 || u == SIDE - 1 ? 0 : (float)rgbk[i];
            any |= out->rgbk[4 * (v * SIDE + u) + 3] > 0;
        }
        running[u + 1] = running[u] + any;
    }
}

vv_status vvi_transfer_plane_init(vvi_transfer_plane *out, vvi_transfer_table *columns, const vv_classification *c,
                                  vv_job *job)
{
    const size_t bytes = (size_t)SIDE * SIDE * 4 * sizeof(float);
    *out = (vvi_transfer_plane){0};
    *columns = (vvi_transfer_table){.n = SIDE};
    find_columns(out, c);
    columns->lo = out->lo;
    columns->hi = out->hi;
    columns->scale = (SIDE - 1) / (out->hi - out->lo);
    columns->offset = -out->lo * columns->scale;
    out->rgbk = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    columns->running = vvi_alloc(job, (SIDE + 1) * sizeof *columns->running, VVI_MEM_DERIVED);
    if (!out->rgbk || !columns->running) {
        vvi_transfer_plane_finish(out);
        vvi_transfer_table_finish(columns);
        return vv_fail_memory(bytes);
    }
    fill(out, columns->running, c);
    for (size_t u = 0; u < SIDE; u++)
        out->any[u] = columns->running[u + 2 < SIDE ? u + 2 : SIDE] > columns->running[u];
    return VV_OK;
}

void vvi_transfer_plane_finish(vvi_transfer_plane *plane)
{
    vvi_free(plane->rgbk);
    *plane = (vvi_transfer_plane){0};
}
