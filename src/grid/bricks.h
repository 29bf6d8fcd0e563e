/** @file
 * Samples in bricks that are brought when somebody asks for them, and dropped when there is no more room: what rays do
 * not meet is never read, and what they do need not fit in memory all at once.
 *
 * A brick has 32 x 32 x 32 cells and all samples that these, their gradients and splines ask for: one before and two
 * behind on every axis (35^3 samples, a third more than 32^3). A table of pages says where each is. Bricks in which all
 * samples are the same share one place for each such value.
 *
 * Kernels read pages without a lock and bring what is absent. Where that does not fit, they get samples of 0, and go
 * on; whoever called them learns it by vvi_bricks_leave() and does the work again, alone with all of the memory.
 */
#ifndef VVI_GRID_BRICKS_H
#define VVI_GRID_BRICKS_H
#include "core/status.h"
#include <volvis/field.h>

enum {
    VVI_BRICK_SHIFT = 5,
    VVI_BRICK_CELLS = 1 << VVI_BRICK_SHIFT,
    VVI_BRICK_BEFORE = 1,
    VVI_BRICK_BEHIND = 2,
    VVI_BRICK_SIDE = VVI_BRICK_BEFORE + VVI_BRICK_CELLS + VVI_BRICK_BEHIND
};

/** What kernels read. */
typedef struct vvi_bricks {
    int32_t n[3];    /**< bricks along each axis */
    int32_t side[3]; /**< samples of one: fewer where the grid has fewer cells */
    int32_t *page;   /**< of each brick: its first sample among those of `data`; negative: it is not there */
    char *data;
} vvi_bricks;

/** Where the samples come from. */
typedef struct vvi_brick_source {
    /** Samples of a box, which lies in the grid: row (j, k) of it goes to `to` + j * row + k * slice, in bytes. Any
     * thread, one at a time. */
    vv_status (*fill)(char *to, size_t row, size_t slice, void *user, const vv_box *box, vv_job *job);
    void (*drop)(void *user); /**< once, also when making the bricks fails */
    void *user;
} vvi_brick_source;

/** Of a grid of `dims` samples of `sample_bytes`; none is there yet. */
vv_status vvi_bricks_new(vvi_bricks **out, const int64_t dims[3], size_t sample_bytes, const vvi_brick_source *source,
                         vv_job *job);
void vvi_bricks_free(void *bricks); /* NULL is fine */

/** Between these two a thread may run kernels that bring bricks. Stores in the order of their addresses, so that nobody
 * waits for ever. `alone`: nobody else is inside, and all bricks are dropped first. */
void vvi_bricks_enter(vvi_bricks *const *stores, size_t n, bool alone, vv_job *job);
/** Errors: of what brought them. *lacking_out: bricks did not fit, so that what was made of them is void. */
vv_status vvi_bricks_leave(bool *lacking_out, vvi_bricks *const *stores, size_t n);

/** For kernels: a brick's page, brought if it is absent; one with samples of 0 where that fails. */
int32_t vvi_bricks_bring(const vvi_bricks *bricks, int32_t brick);
/** How many have their samples in memory, and how many places these take. */
void vvi_bricks_count(size_t *there_out, size_t *places_out, const vvi_bricks *bricks);

#endif
