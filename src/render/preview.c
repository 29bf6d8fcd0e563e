/* A picture from a coarse grid of rays, which grows finer until it has one ray a pixel: no ray is cast twice. */
#include "core/job.h"
#include "image/image_layer.h"
#include "render/picture.h"
#include <math.h>
#include <string.h>

/* One set of pixels: (x + i * stride, y + j * stride) of the canvas. */
typedef struct grid {
    vv_image *canvas;
    int32_t x, y, stride;
} grid;

static void scatter(const grid *g, const vv_tile *tile, const vv_image *from)
{
    const int32_t w = tile->x1 - tile->x0, h = tile->y1 - tile->y0;
    for (size_t i = 0; i <= VV_LAYER_COUNT; i++) { /* the last: colours */
        const size_t channels = i < VV_LAYER_COUNT ? vvi_layer_nth(i)->channels : 4;
        const float *source = i < VV_LAYER_COUNT ? vvi_image_layer(from, i) : from->rgba;
        float *target = i < VV_LAYER_COUNT ? vvi_image_layer(g->canvas, i) : g->canvas->rgba;
        for (int32_t p = 0; target && p < w * h; p++) {
            const size_t x = (size_t)(g->x + (tile->x0 + p % w) * g->stride);
            const size_t y = (size_t)(g->y + (tile->y0 + p / w) * g->stride);
            memcpy(target + (y * (size_t)g->canvas->width + x) * channels,
                   source + ((size_t)(p / w) * (size_t)from->width + (size_t)(p % w)) * channels,
                   channels * sizeof *target);
        }
    }
}

/* Tiles of the grid; scratch: room for its rays. */
static vv_status render_tile(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                             vv_render_counts *counts)
{
    const grid *g = user;
    const vv_tile here = {0, 0, tile->x1 - tile->x0, tile->y1 - tile->y0};
    const vv_pass pass =
        vvi_picture_pass(picture, g->x + tile->x0 * g->stride + 0.5, g->y + tile->y0 * g->stride + 0.5, g->stride, 0);
    const vv_status st = vvi_picture_render(picture, &pass, &here, scratch, counts);
    if (st == VV_OK)
        scatter(g, tile, scratch);
    return st;
}

vv_status vvi_preview_render(vv_picture *picture, const vv_tile *tile, vv_image *scratch, vv_render_counts *counts)
{
    return render_tile(picture, &(grid){picture->got.canvas, 0, 0, 1}, tile, scratch, counts);
}

/* Whole squares of VVI_COARSE for n pixels, and where the last one ends. */
int32_t vvi_preview_size(int32_t n)
{
    return (n + VVI_COARSE - 1) / VVI_COARSE * VVI_COARSE + 1;
}

int32_t vvi_preview_stride(int32_t grids)
{
    int32_t stride = VVI_COARSE;
    for (int32_t whole = 4; grids >= whole && stride > 1; whole += 3)
        stride /= 2;
    return stride;
}

/* The first has all of its pixels; of each three that follow one has the columns, one the rows and one the middles
 * between those that are there. */
static grid grid_nth(vv_image *canvas, int32_t n)
{
    const int32_t stride = n ? vvi_preview_stride(n) : VVI_COARSE, i = n ? (n - 1) % 3 + 1 : 0;
    return (grid){canvas, i % 2 * stride / 2, i / 2 * stride / 2, stride};
}

vv_status vvi_preview_go_on(bool *whole_out, vv_picture *picture)
{
    grid g = grid_nth(picture->got.canvas, picture->got.grid);
    const vvi_tiles tiles = {.width = (g.canvas->width - 1 - g.x) / g.stride + 1,
                             .height = (g.canvas->height - 1 - g.y) / g.stride + 1,
                             .tile = render_tile,
                             .user = &g,
                             .scratch = true};
    *whole_out = true; /* a canvas of one pixel has nothing between */
    return g.x < g.canvas->width && g.y < g.canvas->height ? vvi_picture_go_on(whole_out, picture, &tiles) : VV_OK;
}

/* Showing it ----------------------------------------------------------------------------------------------------- */

typedef struct showing {
    const vv_image *canvas;
    vv_image *image;
    int32_t stride;
} showing;

/* Colour and depth of n pixels from x on, between two rows of four corners. */
void vvi_preview_row(float *rgba, float *depth, const vv_image *canvas, int32_t stride, int32_t x, int32_t y, int32_t n)
{
    const int32_t y0 = y / stride * stride;
    const size_t row = (size_t)canvas->width, below = y > y0 ? (size_t)stride * row : 0;
    const float fy = (float)(y - y0) / (float)stride;
    for (int32_t i = 0; i < n; i++) {
        const int32_t x0 = (x + i) / stride * stride;
        const size_t at = (size_t)y0 * row + (size_t)x0, beside = x + i > x0 ? (size_t)stride : 0;
        const float fx = (float)(x + i - x0) / (float)stride;
        const size_t corner[4] = {at, at + beside, at + below, at + below + beside};
        const float weight[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
        for (size_t c = 0; c < 4; c++)
            rgba[4 * i + (int32_t)c] =
                weight[0] * canvas->rgba[4 * corner[0] + c] + weight[1] * canvas->rgba[4 * corner[1] + c] +
                weight[2] * canvas->rgba[4 * corner[2] + c] + weight[3] * canvas->rgba[4 * corner[3] + c];
        const float *d = canvas->depth;
        depth[i] =
            weight[0] * d[corner[0]] + weight[1] * d[corner[1]] + weight[2] * d[corner[2]] + weight[3] * d[corner[3]];
        if (!isfinite(depth[i])) /* what is nearest, then: 0 * infinity is no distance */
            depth[i] = d[corner[(fx >= 0.5f) + 2 * (fy >= 0.5f)]];
    }
}

/* Layers beside the depth are there once every pixel has its ray. */
static void copy_tile(const vv_image *to, const vv_image *from, const vv_tile *tile)
{
    for (size_t i = 0; i <= VV_LAYER_COUNT; i++) { /* the last: colours */
        const size_t channels = i < VV_LAYER_COUNT ? vvi_layer_nth(i)->channels : 4;
        const float *source = i < VV_LAYER_COUNT ? vvi_image_layer(from, i) : from->rgba;
        float *target = i < VV_LAYER_COUNT ? vvi_image_layer(to, i) : to->rgba;
        for (int32_t y = tile->y0; target && y < tile->y1; y++)
            memcpy(target + ((size_t)y * (size_t)to->width + (size_t)tile->x0) * channels,
                   source + ((size_t)y * (size_t)from->width + (size_t)tile->x0) * channels,
                   (size_t)(tile->x1 - tile->x0) * channels * sizeof *target);
    }
}

static vv_status show_tile(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                           vv_render_counts *counts)
{
    const showing *s = user;
    const vv_image *image = s->image;
    if (s->stride == 1) {
        copy_tile(image, s->canvas, tile);
        return VV_OK;
    }
    for (int32_t y = tile->y0; y < tile->y1; y++) {
        const size_t at = (size_t)y * (size_t)image->width + (size_t)tile->x0;
        vvi_preview_row(image->rgba + 4 * at, image->depth + at, s->canvas, s->stride, tile->x0, y,
                        tile->x1 - tile->x0);
    }
    return VV_OK;
}

vv_status vvi_preview_show(vv_picture *picture, vv_image *image, int32_t stride)
{
    showing s = {picture->got.canvas, image, stride};
    const vvi_tiles tiles = {
        .width = image->width, .height = image->height, .tile = show_tile, .user = &s, .quiet = true};
    return vvi_picture_loop(picture, &tiles);
}
