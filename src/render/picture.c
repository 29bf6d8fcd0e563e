/* What all parts of a picture need: loops over tiles, tiles of a pass, the background. */
#include "render/picture.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/status.h"
#include "image/image_layer.h"
#include "render/decorate/decorate.h"
#include <string.h>

/* Tiles ---------------------------------------------------------------------------------------------------------- */

typedef struct loop {
    vvi_picture *picture;
    const vvi_tiles *tiles;
    size_t n_across;
    vv_render_counts *counts; /* by tile: summed in their order */
} loop;

static vv_status start(void **scratch_out, void *shared, int worker)
{
    const loop *l = shared;
    vv_image *image = NULL;
    vv_status st = VV_OK;
    (void)worker;
    if (l->tiles->scratch)
        st = vv_image_new(&image, VVI_TILE, VVI_TILE, l->picture->scene->layers, l->picture->job);
    *scratch_out = image;
    return st;
}

static void finish(void *scratch, void *shared)
{
    (void)shared;
    vv_image_release(scratch);
}

static vv_status do_tile(void *scratch, void *shared, size_t index)
{
    loop *l = shared;
    const int32_t x = (int32_t)(index % l->n_across) * VVI_TILE, y = (int32_t)(index / l->n_across) * VVI_TILE;
    const int32_t right = x + VVI_TILE, bottom = y + VVI_TILE;
    const vv_tile tile = {x, y, right < l->tiles->width ? right : l->tiles->width,
                          bottom < l->tiles->height ? bottom : l->tiles->height};
    return l->tiles->tile(l->picture, l->tiles->user, &tile, scratch, &l->counts[index]);
}

vv_status vvi_picture_loop(vvi_picture *picture, const vvi_tiles *tiles)
{
    loop l = {.picture = picture, .tiles = tiles, .n_across = ((size_t)tiles->width + VVI_TILE - 1) / VVI_TILE};
    const size_t n = l.n_across * (((size_t)tiles->height + VVI_TILE - 1) / VVI_TILE);
    vvi_work work = {.stage = "render", .start = start, .item = do_tile, .finish = finish, .yields = true};
    work.n_before = picture->n_done;
    work.n_after = picture->n_ahead > n ? picture->n_ahead - n : 0;
    if (tiles->quiet)
        work = (vvi_work){.start = start, .item = do_tile, .finish = finish, .yields = true};
    l.counts = vvi_alloc_zeroed(picture->job, n * sizeof *l.counts, VVI_MEM_SCRATCH);
    if (!l.counts)
        return vv_fail_memory(n * sizeof *l.counts);
    const vv_status st = vvi_parallel_for(picture->job, &work, &l, n);
    for (size_t i = 0; i < n; i++) {
        picture->counts.rays += l.counts[i].rays;
        picture->counts.samples += l.counts[i].samples;
        picture->counts.covered += l.counts[i].covered;
    }
    vvi_free(l.counts);
    if (!tiles->quiet) {
        picture->n_done += n;
        picture->n_ahead = work.n_after;
    }
    return st;
}

/* Passes --------------------------------------------------------------------------------------------------------- */

static void clear_layer(vv_image *image, size_t index, const vv_tile *tile)
{
    const vvi_layer *row = vvi_layer_nth(index);
    float *layer = vvi_image_layer(image, index);
    const size_t n = (size_t)(tile->x1 - tile->x0) * row->channels;
    for (int32_t y = tile->y0; layer && y < tile->y1; y++) {
        float *p = layer + ((size_t)y * (size_t)image->width + (size_t)tile->x0) * row->channels;
        for (size_t i = 0; i < n; i++)
            p[i] = row->empty;
    }
}

vv_status vvi_picture_render(vvi_picture *picture, const vv_pass *pass, const vv_tile *tile, vv_image *image,
                             vv_render_counts *counts)
{
    for (int32_t y = tile->y0; y < tile->y1; y++)
        memset(image->rgba + 4 * ((size_t)y * (size_t)image->width + (size_t)tile->x0), 0,
               (size_t)(tile->x1 - tile->x0) * 4 * sizeof(float));
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        clear_layer(image, i, tile);
    const vv_status st = picture->scene->renderer->render(picture->state, pass, tile, image, counts, picture->job);
    for (int32_t y = tile->y0; image->samples && y < tile->y1; y++)
        for (int32_t x = tile->x0; x < tile->x1; x++)
            image->samples[(size_t)y * (size_t)image->width + (size_t)x] = 1;
    return st;
}

/* One step of the splitmix64 sequence: every pass has a seed that tells nothing of the others. */
static uint64_t mixed(uint64_t seed, uint64_t number)
{
    uint64_t z = seed + (number + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

vv_pass vvi_picture_pass(const vvi_picture *picture, double x, double y, int32_t stride, uint64_t number)
{
    return (vv_pass){.x = x, .y = y, .stride = stride, .number = number, .seed = mixed(picture->scene->seed, number)};
}

/* The background ------------------------------------------------------------------------------------------------- */

/* Light that came from elsewhere stands in the image then; and where something is seen is counted. */
static vv_status put_tile(vvi_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                          vv_render_counts *counts)
{
    const float *light = user;
    const vv_image *image = picture->image;
    for (int32_t y = tile->y0; y < tile->y1; y++) {
        const size_t at = 4 * ((size_t)y * (size_t)image->width + (size_t)tile->x0);
        const size_t n = 4 * (size_t)(tile->x1 - tile->x0);
        if (light != image->rgba)
            memcpy(image->rgba + at, light + at, n * sizeof *light);
        for (size_t i = 3; i < n; i += 4)
            counts->covered += light[at + i] > 0;
    }
    return VV_OK;
}

static vv_status show_tile(vvi_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                           vv_render_counts *counts)
{
    const float *back = picture->scene->background;
    const vv_image *image = picture->image;
    for (int32_t y = tile->y0; y < tile->y1; y++) {
        for (int32_t x = tile->x0; x < tile->x1; x++) {
            float *light = image->rgba + 4 * ((size_t)y * (size_t)image->width + (size_t)x);
            const float through = 1 - light[3];
            for (size_t c = 0; c < 4; c++) /* premultiplied and linear; a transparent one changes nothing */
                light[c] += through * back[c];
        }
    }
    return VV_OK;
}

vv_status vvi_picture_show(vvi_picture *picture, const float *light)
{
    vvi_tiles tiles = {
        .width = picture->image->width, .height = picture->image->height, .tile = put_tile, .quiet = true};
    tiles.user = (void *)(light ? light : picture->image->rgba);
    vv_status st = vvi_picture_loop(picture, &tiles);
    if (picture->bare)
        return st;
    if (st == VV_OK && vvi_decorate_wanted(picture->scene))
        st = vvi_decorate(picture->image, picture->scene, picture->job);
    tiles.tile = show_tile;
    return st == VV_OK ? vvi_picture_loop(picture, &tiles) : st;
}

void vvi_picture_tell(vvi_picture *picture, int level, bool final)
{
    const vv_render_options *options = picture->options;
    const vv_refinement refinement = {
        .image = picture->image, .level = level, .passes = picture->passes, .final = final};
    if (options->on_refined)
        options->on_refined(options->user, &refinement);
}
