/* Adaptive image sampling (algorithms: section 2.11): squares between four rays that agree are filled in, the others
 * get a ray for every pixel.
 *
 * Four corners do not see what passes between them, a thin vessel say. So a square whose pixels, once they are known,
 * are not what its corners said along one of its sides has its neighbour on that side looked at as well, and so on
 * along whatever it is: what is seen anywhere is followed to its end.
 */
#include "core/memory.h"
#include "core/status.h"
#include "render/picture.h"
#include <math.h>
#include <string.h>

/* Light is compared by its square root, near to what a display shows: 18 of 255. More, and lines break into dashes;
 * less, and hardly a ray is saved that would have met something (docs/ray-casting.md). */
#define CONTRAST (1.0f / 14)

/* Four pixels of whatever is followed in each round. */
enum { MOST_ROUNDS = 16 };

/* What a square is: filled in; to get its rays in this round; has got them in this round; or before. */
enum { LINEAR, WANTED, FRESH, KNOWN };
enum { LEFT, RIGHT, TOP, BOTTOM };

typedef struct adaptive {
    vv_image *canvas;
    uint8_t *square; /* of n_across x n_down: one of the above */
    int32_t n_across, n_down;
    bool any_wanted; /* atomic */
} adaptive;

static float difference(const float a[4], const float b[4])
{
    float most = 0;
    for (int c = 0; c < 4; c++)
        most = fmaxf(most, fabsf(sqrtf(fmaxf(a[c], 0)) - sqrtf(fmaxf(b[c], 0))));
    return most;
}

static size_t pixel(const adaptive *a, int32_t x, int32_t y)
{
    return (size_t)y * (size_t)a->canvas->width + (size_t)x;
}

/* Whether the corners of a square differ: in light, or in what is hit and what is missed. */
static bool differs(const adaptive *a, int32_t i, int32_t j)
{
    const float *rgba = a->canvas->rgba, *depth = a->canvas->depth;
    size_t at[4];
    for (int k = 0; k < 4; k++)
        at[k] = pixel(a, (i + k % 2) * VVI_COARSE, (j + k / 2) * VVI_COARSE);
    for (int k = 1; k < 4; k++) {
        const bool hit = rgba[4 * at[0] + 3] > 0, near = isfinite(depth[at[0]]);
        if (hit != (rgba[4 * at[k] + 3] > 0) || near != (bool)isfinite(depth[at[k]]))
            return true;
        for (int l = 0; l < k; l++)
            if (difference(rgba + 4 * at[k], rgba + 4 * at[l]) > CONTRAST)
                return true;
    }
    return false;
}

/* Whether a square that has its rays is not what its corners said, along one of its sides. */
static bool surprises(const adaptive *a, int32_t i, int32_t j, int side)
{
    for (int32_t k = 0; k < VVI_COARSE; k++) {
        const int32_t x = i * VVI_COARSE + (side == LEFT ? 0 : side == RIGHT ? VVI_COARSE - 1 : k);
        const int32_t y = j * VVI_COARSE + (side == TOP ? 0 : side == BOTTOM ? VVI_COARSE - 1 : k);
        float guess[4], depth;
        vvi_preview_row(guess, &depth, a->canvas, VVI_COARSE, x, y, 1);
        if (difference(guess, a->canvas->rgba + 4 * pixel(a, x, y)) > CONTRAST)
            return true;
    }
    return false;
}

/* Squares of a tile; tiles begin at squares. */
#define EACH_SQUARE(a, tile, i, j)                                                                                     \
    for (int32_t j = (tile)->y0 / VVI_COARSE; j < (a)->n_down && j * VVI_COARSE < (tile)->y1; j++)                     \
        for (int32_t i = (tile)->x0 / VVI_COARSE; i < (a)->n_across && i * VVI_COARSE < (tile)->x1; i++)

static vv_status compare_corners(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                                 vv_render_counts *counts)
{
    const adaptive *a = user;
    EACH_SQUARE(a, tile, i, j)
    {
        a->square[(size_t)j * (size_t)a->n_across + (size_t)i] = differs(a, i, j) ? WANTED : LINEAR;
    }
    return VV_OK;
}

static uint8_t state_of(const adaptive *a, int32_t i, int32_t j)
{
    if (i < 0 || j < 0 || i >= a->n_across || j >= a->n_down)
        return LINEAR;
    return __atomic_load_n(&a->square[(size_t)j * (size_t)a->n_across + (size_t)i], __ATOMIC_RELAXED);
}

static void set_state(const adaptive *a, int32_t i, int32_t j, uint8_t state)
{
    __atomic_store_n(&a->square[(size_t)j * (size_t)a->n_across + (size_t)i], state, __ATOMIC_RELAXED);
}

static bool is_surprised(const adaptive *a, int32_t i, int32_t j)
{
    return (state_of(a, i + 1, j) == FRESH && surprises(a, i + 1, j, LEFT)) ||
           (state_of(a, i - 1, j) == FRESH && surprises(a, i - 1, j, RIGHT)) ||
           (state_of(a, i, j + 1) == FRESH && surprises(a, i, j + 1, TOP)) ||
           (state_of(a, i, j - 1) == FRESH && surprises(a, i, j - 1, BOTTOM));
}

/* What a fresh neighbour showed makes a square wanted. Neighbours in other tiles may become wanted at the same time;
 * whether they are fresh does not change here. */
static vv_status compare_sides(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                               vv_render_counts *counts)
{
    adaptive *a = user;
    EACH_SQUARE(a, tile, i, j)
    {
        if (state_of(a, i, j) == LINEAR && is_surprised(a, i, j)) {
            set_state(a, i, j, WANTED);
            __atomic_store_n(&a->any_wanted, true, __ATOMIC_RELAXED);
        }
    }
    return VV_OK;
}

/* The rays of squares i0 .. i1 - 1 of one row. */
static vv_status render_run(vv_picture *picture, adaptive *a, int32_t i0, int32_t i1, int32_t j, vv_image *scratch,
                            vv_render_counts *counts)
{
    const int32_t x = i0 * VVI_COARSE, y = j * VVI_COARSE, right = i1 * VVI_COARSE, bottom = y + VVI_COARSE;
    const vv_tile tile = {x, y, right < picture->scene->width ? right : picture->scene->width,
                          bottom < picture->scene->rows ? bottom : picture->scene->rows};
    return vvi_preview_render(picture, &tile, scratch, counts);
}

static vv_status render_wanted(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                               vv_render_counts *counts)
{
    adaptive *a = user;
    vv_status st = VV_OK;
    EACH_SQUARE(a, tile, i, j)
    {
        if (state_of(a, i, j) == FRESH)
            set_state(a, i, j, KNOWN);
        if (state_of(a, i, j) != WANTED)
            continue;
        int32_t end = i;
        while (end * VVI_COARSE < tile->x1 && state_of(a, end, j) == WANTED)
            set_state(a, end++, j, FRESH);
        if ((st = render_run(picture, a, i, end, j, scratch, counts)) != VV_OK)
            return st;
        i = end - 1;
    }
    return VV_OK;
}

static vv_status fill_in(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                         vv_render_counts *counts)
{
    const adaptive *a = user;
    EACH_SQUARE(a, tile, i, j)
    {
        if (state_of(a, i, j) >= FRESH)
            continue;
        for (int32_t k = 0; k < VVI_COARSE; k++) {
            const int32_t from = k == 0; /* all but the corner, which neighbours read */
            const size_t at = pixel(a, i * VVI_COARSE + from, j * VVI_COARSE + k);
            vvi_preview_row(a->canvas->rgba + 4 * at, a->canvas->depth + at, a->canvas, VVI_COARSE,
                            i * VVI_COARSE + from, j * VVI_COARSE + k, VVI_COARSE - from);
        }
    }
    return VV_OK;
}

static vv_status run(vv_picture *picture, adaptive *a)
{
    vvi_tiles tiles = {.width = a->n_across * VVI_COARSE, .height = a->n_down * VVI_COARSE, .user = a, .quiet = true};
    vv_status st;
    tiles.tile = compare_corners;
    if ((st = vvi_picture_loop(picture, &tiles)) != VV_OK)
        return st;
    a->any_wanted = true;
    for (int round = 0; round < MOST_ROUNDS && a->any_wanted; round++) {
        a->any_wanted = false;
        tiles.tile = render_wanted;
        tiles.scratch = true;
        tiles.quiet = round > 0; /* the first has nearly all of the work */
        if ((st = vvi_picture_loop(picture, &tiles)) != VV_OK)
            return st;
        tiles.tile = compare_sides;
        tiles.scratch = false;
        tiles.quiet = true;
        if ((st = vvi_picture_loop(picture, &tiles)) != VV_OK)
            return st;
    }
    tiles.tile = fill_in;
    return vvi_picture_loop(picture, &tiles);
}

vv_status vvi_adaptive_finish(vv_picture *picture)
{
    vv_image *canvas = picture->got.canvas;
    adaptive a = {
        .canvas = canvas, .n_across = (canvas->width - 1) / VVI_COARSE, .n_down = (canvas->height - 1) / VVI_COARSE};
    const size_t n = (size_t)a.n_across * (size_t)a.n_down;
    a.square = vvi_alloc_zeroed(picture->job, n, VVI_MEM_SCRATCH);
    if (!a.square)
        return vv_fail_memory(n);
    const vv_status st = run(picture, &a);
    vvi_free(a.square);
    return st;
}
