/* One tile: samples of all opaque triangles, their light, then everything else over it. */
#include "core/job.h"
#include "gfx/software.h"
#include <string.h>

/* Arrays of a number of fragments each in one piece of memory. */
enum { ARRAYS = 11 };
static void lay_out(vvi_gfx_fragments *f, float *numbers, size_t n)
{
    float **const array[ARRAYS - 1] = {&f->x,       &f->y,     &f->rgba[0],   &f->rgba[1],   &f->rgba[2],
                                       &f->rgba[3], &f->depth, &f->normal[0], &f->normal[1], &f->normal[2]};
    for (size_t i = 0; i < ARRAYS - 1; i++)
        *array[i] = numbers + i * n;
    f->triangle = (uint32_t *)(void *)(numbers + (ARRAYS - 1) * n);
}

vv_status vvi_gfx_tile_room_new(vvi_gfx_tile_room **out, const vvi_gfx *gfx)
{
    const vvi_gfx_pattern *pattern = vvi_gfx_pattern_for(gfx->target.samples);
    const size_t n = (size_t)VVI_GFX_TILE * VVI_GFX_TILE * (size_t)pattern->samples,
                 row = (size_t)VVI_GFX_TILE / (size_t)pattern->width * 16 + VVI_GFX_SPARE;
    vvi_gfx_tile_room *r = vvi_alloc_zeroed(gfx->job, sizeof *r, VVI_MEM_SCRATCH);
    *out = r;
    if (!r)
        return vv_fail_memory(sizeof *r);
    r->pattern = vvi_gfx_pattern_turned(gfx->target.samples, gfx->target.turn);
    r->samples = (vvi_gfx_samples){.pattern = &r->pattern,
                                   .near = vvi_alloc(gfx->job, n * sizeof(float), VVI_MEM_SCRATCH),
                                   .id = vvi_alloc(gfx->job, n * sizeof(uint32_t), VVI_MEM_SCRATCH),
                                   .far = vvi_alloc(gfx->job, n / 16 * sizeof(float), VVI_MEM_SCRATCH)};
    r->numbers = vvi_alloc_zeroed(gfx->job, (2 * ARRAYS + 4) * row * sizeof *r->numbers, VVI_MEM_SCRATCH);
    if (!r->samples.near || !r->samples.id || !r->samples.far || !r->numbers) {
        *out = NULL;
        vvi_gfx_tile_room_free(r);
        return vv_fail_memory(n * sizeof(float));
    }
    lay_out(&r->fragments, r->numbers, row);
    lay_out(&r->some, r->numbers + ARRAYS * row, row);
    r->weight = r->numbers + 2 * ARRAYS * row;
    r->id = (uint32_t *)(void *)(r->weight + row);
    r->pixel = (int32_t *)(void *)(r->weight + 2 * row);
    r->mask = (uint32_t *)(void *)(r->weight + 3 * row);
    r->n_most = row - VVI_GFX_SPARE;
    return VV_OK;
}

void vvi_gfx_tile_room_free(vvi_gfx_tile_room *r)
{
    if (!r)
        return;
    vvi_free(r->samples.near);
    vvi_free(r->samples.id);
    vvi_free(r->samples.far);
    vvi_free(r->numbers);
    vvi_free(r);
}

static void load_depth(vvi_gfx_tile_room *r, const vvi_gfx_area *area, const vv_image *image)
{
    for (int32_t y = area->y0; y < area->y1; y++)
        for (int32_t x = area->x0; x < area->x1; x++)
            r->depth[(y - area->y0) * VVI_GFX_TILE + x - area->x0] =
                image->depth ? image->depth[(size_t)y * (size_t)image->width + (size_t)x] : INFINITY;
}

static void store_depth(const vvi_gfx_tile_room *r, const vvi_gfx_area *area, const vv_image *image)
{
    for (int32_t y = area->y0; y < area->y1 && image->depth; y++)
        memcpy(image->depth + (size_t)y * (size_t)image->width + (size_t)area->x0,
               r->depth + (ptrdiff_t)(y - area->y0) * VVI_GFX_TILE, (size_t)(area->x1 - area->x0) * sizeof(float));
}

static void clear_samples(vvi_gfx_samples *s)
{
    const size_t n = (size_t)VVI_GFX_TILE * VVI_GFX_TILE * (size_t)s->pattern->samples;
    for (size_t i = 0; i < n; i++)
        s->near[i] = -INFINITY;
    for (size_t i = 0; i < n / 16; i++)
        s->far[i] = -INFINITY;
    memset(s->id, 0, n * sizeof *s->id);
}

/* Samples become fragments ---------------------------------------------------------------------------------------- */

static size_t put(vvi_gfx_tile_room *r, size_t n, uint32_t id, float x, float y, int32_t pixel, float weight)
{
    r->id[n] = id;
    r->fragments.x[n] = x;
    r->fragments.y[n] = y;
    r->pixel[n] = pixel;
    r->weight[n] = weight;
    return n + 1;
}

/* The triangles that the samples of one pixel see; lane: the first of them in its block, whose corner is (x, y). */
static size_t pixel_fragments(vvi_gfx_tile_room *r, size_t n, const uint32_t *id, int lane, int32_t x, int32_t y,
                              int32_t pixel)
{
    const vvi_gfx_pattern *p = r->samples.pattern;
    const float unit = (float)(1 << p->shift) / VVI_GFX_STEPS;
    uint32_t left = 0;
    for (int s = 0; s < p->samples; s++)
        left |= (uint32_t)(id[s] != 0) << s;
    while (left) {
        const uint32_t one = id[__builtin_ctz(left)];
        int32_t sum_x = 0, sum_y = 0, count = 0;
        for (int s = 0; s < p->samples; s++) {
            const int32_t same = id[s] == one;
            sum_x += same * p->x[lane + s];
            sum_y += same * p->y[lane + s];
            count += same;
            left &= ~((uint32_t)same << s);
        }
        const float mean = unit / (float)count;
        n = put(r, n, one, (float)x + mean * (float)sum_x, (float)y + mean * (float)sum_y, pixel,
                (float)count / (float)p->samples);
    }
    return n;
}

static bool all_clear(const uint32_t id[16])
{
    uint32_t any = 0;
    for (int l = 0; l < 16; l++)
        any |= id[l];
    return !any;
}

/* Of a row of blocks, those in the picture. */
static void row_fragments(vvi_gfx_tile_room *r, const vvi_gfx_area *area, int32_t row)
{
    const vvi_gfx_pattern *p = r->samples.pattern;
    const int32_t across = VVI_GFX_TILE / p->width;
    size_t n = 0;
    for (int32_t b = 0; b < across; b++) {
        const uint32_t *id = r->samples.id + (ptrdiff_t)(row * across + b) * 16;
        const int32_t x0 = b * p->width, y0 = row * p->height;
        if (all_clear(id))
            continue;
        for (int lane = 0; lane < 16; lane += p->samples) {
            const int32_t x = x0 + lane / p->samples % p->width, y = y0 + lane / p->samples / p->width;
            if (x < area->x1 - area->x0 && y < area->y1 - area->y0)
                n = pixel_fragments(r, n, id + lane, lane, area->x0 + x0, area->y0 + y0, y * VVI_GFX_TILE + x);
        }
    }
    r->fragments.n = n;
}

/* Pixels -------------------------------------------------------------------------------------------------------------
 */

static void set_layers(vv_image *image, size_t at, const vvi_gfx_fragments *f, size_t i, uint32_t id)
{
    if (image->id)
        image->id[at] = id;
    if (image->value)
        image->value[at] = NAN;
    for (size_t c = 0; image->normal && c < 3; c++)
        image->normal[3 * at + c] = f->normal[c][i];
}

/* Fragments first .. first + n - 1 are those of one pixel. */
static void resolve(vvi_gfx_tile_room *r, size_t first, size_t n, const vvi_gfx_area *area, vv_image *image,
                    const vvi_gfx_software_picture *p)
{
    const vvi_gfx_fragments *f = &r->fragments;
    const int32_t pixel = r->pixel[first];
    const size_t at =
        (size_t)(area->y0 + pixel / VVI_GFX_TILE) * (size_t)image->width + (size_t)(area->x0 + pixel % VVI_GFX_TILE);
    float *rgba = image->rgba + 4 * at, *there = &r->depth[pixel];
    float before[4] = {0}, behind[4] = {0};
    size_t most = first;
    for (size_t i = first; i < first + n; i++) {
        float *sum = f->depth[i] < *there ? before : behind;
        for (int c = 0; c < 3; c++)
            sum[c] += r->weight[i] * f->rgba[c][i];
        sum[3] += r->weight[i];
        if (f->depth[i] < *there && (f->depth[most] >= *there || r->weight[i] > r->weight[most]))
            most = i;
    }
    const float through = 1 - rgba[3];
    for (int c = 0; c < 4; c++)
        rgba[c] = before[c] + (1 - before[3]) * rgba[c] + through * behind[c];
    if (before[3] >= 0.5f) {
        *there = f->depth[most];
        if (image->id || image->value || image->normal)
            set_layers(image, at, f, most, vvi_gfx_draw_of(p, r->id[most])->state.id);
    }
}

static void light_row(vvi_gfx_tile_room *r, const vvi_gfx_area *area, int32_t row, vv_image *image,
                      const vvi_gfx_software_picture *p)
{
    row_fragments(r, area, row);
    vvi_gfx_light(r, p);
    const size_t n = r->fragments.n;
    for (size_t i = 0, m; i < n; i += m) {
        for (m = 1; i + m < n && r->pixel[i + m] == r->pixel[i]; m++)
            ;
        resolve(r, i, m, area, image, p);
    }
}

/* The tile -------------------------------------------------------------------------------------------------------- */

vvi_gfx_area vvi_gfx_clipped(const vvi_gfx_area *area, const double window[4])
{
    const int32_t w[4] = {(int32_t)floor(window[0]), (int32_t)floor(window[1]), (int32_t)ceil(window[2]),
                          (int32_t)ceil(window[3])};
    return (vvi_gfx_area){w[0] > area->x0 ? w[0] : area->x0, w[1] > area->y0 ? w[1] : area->y0,
                          w[2] < area->x1 ? w[2] : area->x1, w[3] < area->y1 ? w[3] : area->y1};
}

/* Opaque triangles. False: there are none. */
static bool raster(vvi_gfx_samples *s, const vvi_gfx_software_picture *p, const vvi_gfx_area *area, size_t tile,
                   const vv_job *job)
{
    bool any = false;
    for (size_t b = 0; b < p->n_bins && !vv_job_cancelled(job); b++) {
        const vvi_gfx_bin *bin = &p->bins[b];
        const uint32_t begin = bin->begin[tile], end = bin->begin[tile + 1];
        const vvi_gfx_area window = vvi_gfx_clipped(area, bin->draw->state.window);
        if (begin == end || bin->draw->translucent)
            continue;
        if (!any)
            clear_samples(s);
        any = true;
        const vvi_gfx_rastering work = {.entry = bin->entry + begin,
                                        .n = end - begin,
                                        .triangles = bin->draw->surface.mesh->triangles + 3 * (size_t)bin->first,
                                        .vertices = bin->draw->vertices,
                                        .pieces = bin->pieces,
                                        .first = bin->draw->first + bin->first,
                                        .window = window,
                                        .partly = memcmp(&window, area, sizeof window) != 0};
        p->kernels->raster(s, &work);
    }
    return any;
}

vv_status vvi_gfx_tile_draw(vvi_gfx *gfx, vvi_gfx_tile_room *r, size_t tile)
{
    const vvi_gfx_software_picture *p = gfx->own;
    const int32_t x = (int32_t)(tile % (size_t)p->tiling.across) * VVI_GFX_TILE,
                  y = (int32_t)(tile / (size_t)p->tiling.across) * VVI_GFX_TILE;
    const vvi_gfx_area area = {x, y, x + VVI_GFX_TILE < p->tiling.width ? x + VVI_GFX_TILE : p->tiling.width,
                               y + VVI_GFX_TILE < p->tiling.height ? y + VVI_GFX_TILE : p->tiling.height};
    vv_image *image = gfx->target.image;
    r->samples.x0 = x;
    r->samples.y0 = y;
    load_depth(r, &area, image);
    vv_status st = VV_OK;
    const bool opaque = raster(&r->samples, p, &area, tile, gfx->job);
    for (int32_t row = 0; opaque && row < VVI_GFX_TILE / r->samples.pattern->height; row++)
        light_row(r, &area, row, image, p);
    if (p->translucent) {
        if (!opaque)
            clear_samples(&r->samples);
        st = vvi_gfx_translucent(gfx, r, &area, tile);
    }
    for (size_t i = 0; i < p->commands.n && st == VV_OK; i++) {
        const vvi_gfx_command *c = p->commands.item[i];
        if (c->shape && (st = vvi_gfx_flat_draw(c->shape, &area, image, r->depth, gfx->job)) == VV_OK)
            st = vvi_job_poll(gfx->job);
    }
    store_depth(r, &area, image);
    return st == VV_OK ? vvi_job_poll(gfx->job) : st;
}
