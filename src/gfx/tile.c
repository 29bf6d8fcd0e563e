/* One tile: samples of all opaque triangles, their light, then everything else over it. */
#include "core/job.h"
#include "gfx/software.h"
#include <string.h>

vv_status vvi_gfx_tile_room_new(vvi_gfx_tile_room **out, const vvi_gfx *gfx)
{
    const vvi_gfx_pattern *pattern = vvi_gfx_pattern_for(gfx->target.samples);
    const size_t n = (size_t)VVI_GFX_TILE * VVI_GFX_TILE * (size_t)pattern->samples,
                 row = (size_t)VVI_GFX_TILE / (size_t)pattern->width * 16;
    vvi_gfx_tile_room *r = vvi_alloc_zeroed(gfx->job, sizeof *r, VVI_MEM_SCRATCH);
    *out = r;
    if (!r)
        return vv_fail_memory(sizeof *r);
    r->samples = (vvi_gfx_samples){.pattern = pattern,
                                   .near = vvi_alloc(gfx->job, n * sizeof(float), VVI_MEM_SCRATCH),
                                   .id = vvi_alloc(gfx->job, n * sizeof(uint32_t), VVI_MEM_SCRATCH)};
    r->fragments = vvi_alloc(gfx->job, row * sizeof *r->fragments, VVI_MEM_SCRATCH);
    r->pixel = vvi_alloc(gfx->job, row * sizeof *r->pixel, VVI_MEM_SCRATCH);
    r->weight = vvi_alloc(gfx->job, row * sizeof *r->weight, VVI_MEM_SCRATCH);
    if (r->samples.near && r->samples.id && r->fragments && r->pixel && r->weight)
        return VV_OK;
    *out = NULL;
    vvi_gfx_tile_room_free(r);
    return vv_fail_memory(n * sizeof(float));
}

void vvi_gfx_tile_room_free(vvi_gfx_tile_room *r)
{
    if (!r)
        return;
    vvi_free(r->samples.near);
    vvi_free(r->samples.id);
    vvi_free(r->fragments);
    vvi_free(r->pixel);
    vvi_free(r->weight);
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
    memset(s->id, 0, n * sizeof *s->id);
}

/* Samples become fragments ---------------------------------------------------------------------------------------- */

/* The triangles that the samples of one pixel see. */
static size_t pixel_fragments(vvi_gfx_tile_room *r, size_t n, const uint32_t *id, int lane, int32_t x, int32_t y)
{
    const vvi_gfx_pattern *p = r->samples.pattern;
    const float unit = (float)(1 << p->shift) / VVI_GFX_STEPS;
    uint32_t left = 0;
    for (int s = 0; s < p->samples; s++)
        left |= (uint32_t)(id[s] != 0) << s;
    while (left) {
        const uint32_t one = id[__builtin_ctz(left)];
        int32_t sum_x = 0, sum_y = 0, count = 0;
        for (int s = 0; s < p->samples; s++)
            if (id[s] == one) {
                sum_x += p->x[lane + s];
                sum_y += p->y[lane + s];
                count++;
                left &= ~(1u << s);
            }
        r->fragments[n] = (vvi_gfx_fragment){.triangle = one,
                                             .x = (float)x + unit * (float)sum_x / (float)count,
                                             .y = (float)y + unit * (float)sum_y / (float)count};
        r->weight[n++] = (float)count / (float)p->samples;
    }
    return n;
}

/* Of a row of blocks. */
static size_t row_fragments(vvi_gfx_tile_room *r, const vvi_gfx_area *area, int32_t row)
{
    const vvi_gfx_pattern *p = r->samples.pattern;
    const int32_t across = VVI_GFX_TILE / p->width;
    size_t n = 0;
    for (int32_t b = 0; b < across * 16; b += p->samples) {
        const uint32_t *id = r->samples.id + (ptrdiff_t)row * across * 16 + b;
        const int32_t x0 = b / 16 * p->width, y0 = row * p->height, in_block = b % 16 / p->samples;
        const int32_t x = x0 + in_block % p->width, y = y0 + in_block / p->width;
        const size_t before = n;
        n = pixel_fragments(r, n, id, b % 16, area->x0 + x0, area->y0 + y0);
        for (size_t i = before; i < n; i++)
            r->pixel[i] = y * VVI_GFX_TILE + x;
    }
    return n;
}

/* Light ----------------------------------------------------------------------------------------------------------- */

static const vvi_gfx_draw *draw_of(const vvi_gfx_software_picture *p, uint32_t id)
{
    for (size_t i = 0; i < p->commands.n; i++) {
        const vvi_gfx_draw *draw = ((const vvi_gfx_command *)p->commands.item[i])->draw;
        if (draw && id - draw->first < draw->surface.mesh->n_triangles)
            return draw;
    }
    return NULL;
}

static void set_layers(vv_image *image, size_t at, const vvi_gfx_fragment *f, uint32_t id)
{
    if (image->id)
        image->id[at] = id;
    if (image->value)
        image->value[at] = NAN;
    if (image->normal)
        memcpy(image->normal + 3 * at, f->normal, sizeof f->normal);
}

/* Fragments first .. first + n - 1 are those of one pixel. */
static void resolve(vvi_gfx_tile_room *r, size_t first, size_t n, const vvi_gfx_area *area, vv_image *image,
                    const vvi_gfx_software_picture *p)
{
    const int32_t pixel = r->pixel[first];
    const size_t at =
        (size_t)(area->y0 + pixel / VVI_GFX_TILE) * (size_t)image->width + (size_t)(area->x0 + pixel % VVI_GFX_TILE);
    float *rgba = image->rgba + 4 * at, *there = &r->depth[pixel];
    float before[4] = {0}, behind[4] = {0};
    size_t most = first;
    for (size_t i = first; i < first + n; i++) {
        const vvi_gfx_fragment *f = &r->fragments[i];
        float *sum = f->depth < *there ? before : behind;
        for (int c = 0; c < 3; c++)
            sum[c] += r->weight[i] * f->rgba[c];
        sum[3] += r->weight[i];
        if (f->depth < *there && (r->fragments[most].depth >= *there || r->weight[i] > r->weight[most]))
            most = i;
    }
    const float through = 1 - rgba[3];
    for (int c = 0; c < 4; c++)
        rgba[c] = before[c] + (1 - before[3]) * rgba[c] + through * behind[c];
    if (before[3] >= 0.5f) {
        *there = r->fragments[most].depth;
        set_layers(image, at, &r->fragments[most], draw_of(p, r->fragments[most].triangle)->state.id);
    }
}

static void light_row(vvi_gfx_tile_room *r, const vvi_gfx_area *area, int32_t row, vv_image *image,
                      const vvi_gfx_software_picture *p)
{
    const size_t n = row_fragments(r, area, row);
    for (size_t i = 0; i < n; i++) {
        vvi_gfx_fragment *f = &r->fragments[i];
        const uint32_t id = f->triangle;
        const vvi_gfx_draw *draw = draw_of(p, id);
        f->triangle -= draw->first;
        vvi_gfx_shade_ref(f, draw);
        f->triangle = id;
    }
    for (size_t i = 0, m; i < n; i += m) {
        for (m = 1; i + m < n && r->pixel[i + m] == r->pixel[i]; m++)
            ;
        resolve(r, i, m, area, image, p);
    }
}

/* The tile -------------------------------------------------------------------------------------------------------- */

static vvi_gfx_area clipped(const vvi_gfx_area *area, const double window[4])
{
    const int32_t w[4] = {(int32_t)floor(window[0]), (int32_t)floor(window[1]), (int32_t)ceil(window[2]),
                          (int32_t)ceil(window[3])};
    return (vvi_gfx_area){w[0] > area->x0 ? w[0] : area->x0, w[1] > area->y0 ? w[1] : area->y0,
                          w[2] < area->x1 ? w[2] : area->x1, w[3] < area->y1 ? w[3] : area->y1};
}

/* The triangles of one draw, or of all opaque ones for NULL. */
static bool raster(vvi_gfx_samples *s, const vvi_gfx_software_picture *p, const vvi_gfx_area *area, size_t tile)
{
    bool any = false;
    for (size_t b = 0; b < p->n_bins; b++) {
        const vvi_gfx_bin *bin = &p->bins[b];
        const vvi_gfx_area window = clipped(area, bin->draw->state.window);
        for (uint32_t e = bin->begin[tile]; e < bin->begin[tile + 1]; e++) {
            vvi_gfx_triangle t;
            if (!any)
                clear_samples(s);
            any = true;
            vvi_gfx_bin_triangle(&t, bin, bin->entry[e]);
            vvi_gfx_raster_ref(s, &window, &t);
        }
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
    if (raster(&r->samples, p, &area, tile))
        for (int32_t row = 0; row < VVI_GFX_TILE / r->samples.pattern->height; row++)
            light_row(r, &area, row, image, p);
    for (size_t i = 0; i < p->commands.n; i++) {
        const vvi_gfx_command *c = p->commands.item[i];
        if (c->shape)
            vvi_gfx_shape_draw(c->shape, &area, image, r->depth);
    }
    store_depth(r, &area, image);
    return vvi_job_poll(gfx->job);
}
