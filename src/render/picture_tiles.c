/* What all parts of a picture need: loops over tiles, and tiles of a pass. */
#include "core/job.h"
#include "core/memory.h"
#include "core/status.h"
#include "image/image_layer.h"
#include "render/picture.h"
#include "scene/resolve.h"
#include <string.h>

/* Tiles ---------------------------------------------------------------------------------------------------------- */

typedef struct loop {
    vv_picture *picture;
    const vvi_tiles *tiles;
    size_t n_across;
    const uint32_t *index;    /* of the tiles that are not done; NULL: all of them */
    vv_render_counts *counts; /* by item: summed in their order */
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

/* The first one is always done, so that every step comes further. */
static bool is_late(const loop *l, size_t item)
{
    const double deadline_s = l->picture->deadline_s;
    return l->index && !l->tiles->quiet && item > 0 && deadline_s > 0 && vvi_render_clock() > deadline_s;
}

static vv_status do_tile(void *scratch, void *shared, size_t item)
{
    loop *l = shared;
    const size_t index = l->index ? l->index[item] : item;
    const int32_t x = (int32_t)(index % l->n_across) * VVI_TILE, y = (int32_t)(index / l->n_across) * VVI_TILE;
    const int32_t right = x + VVI_TILE, bottom = y + VVI_TILE;
    const vv_tile tile = {x, y, right < l->tiles->width ? right : l->tiles->width,
                          bottom < l->tiles->height ? bottom : l->tiles->height};
    vv_render_counts counts = {0};
    if (is_late(l, item))
        return VV_OK;
    const vv_status st = l->tiles->tile(l->picture, l->tiles->user, &tile, scratch, &counts);
    if (st != VV_OK)
        return st;
    l->counts[item] = counts;
    if (l->index)
        l->picture->got.done[index] = 1;
    return VV_OK;
}

static vv_status run_items(loop *l, size_t n)
{
    vv_picture *picture = l->picture;
    vvi_work work = {.stage = "render", .start = start, .item = do_tile, .finish = finish, .yields = true};
    work.n_before = picture->n_done;
    work.n_after = picture->n_ahead > n ? picture->n_ahead - n : 0;
    if (l->tiles->quiet)
        work = (vvi_work){.start = start, .item = do_tile, .finish = finish, .yields = true};
    l->counts = vvi_alloc_zeroed(picture->job, n * sizeof *l->counts, VVI_MEM_SCRATCH);
    if (!l->counts)
        return vv_fail_memory(n * sizeof *l->counts);
    const vv_status st = vvi_parallel_for(picture->job, &work, l, n);
    for (size_t i = 0; i < n; i++) {
        picture->got.counts.rays += l->counts[i].rays;
        picture->got.counts.samples += l->counts[i].samples;
        picture->got.counts.covered += l->counts[i].covered;
    }
    vvi_free(l->counts);
    return st;
}

static size_t count_tiles(size_t *across_out, int32_t width, int32_t height)
{
    *across_out = ((size_t)width + VVI_TILE - 1) / VVI_TILE;
    return *across_out * (((size_t)height + VVI_TILE - 1) / VVI_TILE);
}

size_t vvi_picture_tiles_most(int32_t width, int32_t height)
{
    size_t across;
    return count_tiles(&across, vvi_preview_size(width), vvi_preview_size(height)); /* shifted ones are no larger */
}

static void tell_done(vv_picture *picture, size_t n)
{
    picture->n_done += n;
    picture->n_ahead = picture->n_ahead > n ? picture->n_ahead - n : 0;
}

vv_status vvi_picture_loop(vv_picture *picture, const vvi_tiles *tiles)
{
    loop l = {.picture = picture, .tiles = tiles};
    const size_t n = count_tiles(&l.n_across, tiles->width, tiles->height);
    const vv_status st = run_items(&l, n);
    if (!tiles->quiet)
        tell_done(picture, n);
    return st;
}

/* Indices 0 .. n - 1 in an order whose beginnings lie all over: steps of the golden section, made coprime to n. */
static size_t scattered(size_t i, size_t n)
{
    size_t stride = (size_t)(0.6180339887 * (double)n) | 1, a = n, b = stride;
    for (;; stride += 2, a = n, b = stride) {
        for (size_t rest; b; a = b, b = rest)
            rest = a % b;
        if (a == 1)
            return i * stride % n;
    }
}

vv_status vvi_picture_go_on(bool *whole_out, vv_picture *picture, const vvi_tiles *tiles)
{
    loop l = {.picture = picture, .tiles = tiles};
    uint8_t *done = picture->got.done;
    const size_t n = count_tiles(&l.n_across, tiles->width, tiles->height);
    size_t n_left = 0, n_done = 0;
    *whole_out = false;
    uint32_t *index = vvi_alloc(picture->job, n * sizeof *index, VVI_MEM_SCRATCH);
    if (!index)
        return vv_fail_memory(n * sizeof *index);
    for (size_t i = 0; i < n; i++) {
        const size_t at = picture->scattered ? scattered(i, n) : i;
        if (!done[at])
            index[n_left++] = (uint32_t)at;
    }
    l.index = index;
    const vv_status st = n_left ? run_items(&l, n_left) : VV_OK;
    vvi_free(index);
    for (size_t i = 0; i < n; i++)
        n_done += done[i];
    if (!tiles->quiet)
        tell_done(picture, n_done - (n - n_left));
    *whole_out = n_done == n;
    if (*whole_out)
        memset(done, 0, n);
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

vv_status vvi_picture_render(vv_picture *picture, const vv_pass *pass, const vv_tile *tile, vv_image *image,
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

vv_pass vvi_picture_pass(const vv_picture *picture, double x, double y, int32_t stride, uint64_t number)
{
    return (vv_pass){.x = x,
                     .y = y,
                     .stride = stride,
                     .top = picture->scene->top,
                     .number = number,
                     .seed = mixed(picture->scene->seed, number)};
}
