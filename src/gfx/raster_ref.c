/* One triangle, every sample of the tile: the slow, obvious way. */
#include "gfx/raster.h"

/* Places of samples as in other rasterisers (Direct3D's standard patterns): on every row and column one, so that nearly
 * horizontal and vertical edges have as many steps as samples. */
static const vvi_gfx_pattern patterns[] = {
    {.samples = 1,
     .width = 4,
     .height = 4,
     .shift = 7,
     .x = {1, 3, 5, 7, 1, 3, 5, 7, 1, 3, 5, 7, 1, 3, 5, 7},
     .y = {1, 1, 1, 1, 3, 3, 3, 3, 5, 5, 5, 5, 7, 7, 7, 7}},
    {.samples = 4,
     .width = 2,
     .height = 2,
     .shift = 5,
     .x = {3, 7, 1, 5, 11, 15, 9, 13, 3, 7, 1, 5, 11, 15, 9, 13},
     .y = {1, 3, 5, 7, 1, 3, 5, 7, 9, 11, 13, 15, 9, 11, 13, 15}},
    {.samples = 8,
     .width = 2,
     .height = 1,
     .shift = 4,
     .x = {9, 7, 13, 5, 3, 1, 11, 15, 25, 23, 29, 21, 19, 17, 27, 31},
     .y = {5, 11, 9, 3, 13, 7, 15, 1, 5, 11, 9, 3, 13, 7, 15, 1}},
};

const vvi_gfx_pattern *vvi_gfx_pattern_for(int samples)
{
    return &patterns[samples == 1 ? 0 : samples == 4 ? 1 : 2];
}

vvi_gfx_pattern vvi_gfx_pattern_turned(int samples, int turn)
{
    enum { PIXEL = 16 /* units of the pattern of 8 */ };
    vvi_gfx_pattern p = *vvi_gfx_pattern_for(samples);
    for (int i = 0; i < 16 && p.samples == 8; i++)
        p.y[i] = (p.y[i] + PIXEL / 8 * turn) % PIXEL;
    return p;
}

/* Twice the area to the left of the way from a to b as one sees it with y down and the inside having more than 0. */
static int64_t edge(int64_t ax, int64_t ay, int64_t bx, int64_t by, int64_t x, int64_t y)
{
    return (bx - ax) * (y - ay) - (by - ay) * (x - ax);
}

/* With the inside to the right of the way (y down, area above 0): an upper edge goes to the right, a left one up. */
static bool owns_edge(int64_t dx, int64_t dy)
{
    return dy < 0 || (dy == 0 && dx > 0);
}

static bool covers(double share[3], const vvi_gfx_triangle *t, bool turned, int64_t x, int64_t y)
{
    const int order[2][3] = {{0, 1, 2}, {0, 2, 1}};
    for (int i = 0; i < 3; i++) {
        const int a = order[turned][(i + 1) % 3], b = order[turned][(i + 2) % 3];
        const int64_t e = edge(t->x[a], t->y[a], t->x[b], t->y[b], x, y);
        if (e < 0 || (e == 0 && !owns_edge((int64_t)t->x[b] - t->x[a], (int64_t)t->y[b] - t->y[a])))
            return false;
        share[order[turned][i]] = (double)e;
    }
    return true;
}

void vvi_gfx_raster_ref(vvi_gfx_samples *s, const vvi_gfx_area *window, const vvi_gfx_triangle *t)
{
    const vvi_gfx_pattern *p = s->pattern;
    const int64_t area = edge(t->x[0], t->y[0], t->x[1], t->y[1], t->x[2], t->y[2]);
    const int32_t across = VVI_GFX_TILE / p->width;
    for (int32_t i = 0; area && i < VVI_GFX_TILE * VVI_GFX_TILE * p->samples; i++) {
        const int32_t block = i / 16, lane = i % 16, in_block = lane / p->samples;
        const int32_t x0 = s->x0 + block % across * p->width, y0 = s->y0 + block / across * p->height;
        const int32_t px = x0 + in_block % p->width, py = y0 + in_block / p->width;
        double share[3];
        if (px < window->x0 || px >= window->x1 || py < window->y0 || py >= window->y1 ||
            !covers(share, t, area < 0, (int64_t)x0 * VVI_GFX_STEPS + ((int64_t)p->x[lane] << p->shift),
                    (int64_t)y0 * VVI_GFX_STEPS + ((int64_t)p->y[lane] << p->shift)))
            continue;
        double near = 0;
        for (int k = 0; k < 3; k++)
            near += share[k] / fabs((double)area) * (double)t->near[k];
        if ((float)near > s->near[i]) {
            s->near[i] = (float)near;
            s->id[i] = t->id;
        }
    }
}
