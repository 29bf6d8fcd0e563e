/** @file
 * Samples in bricks that a table of pages finds (grid/bricks.h). For kernels only.
 *
 * A brick has all that its cells ask for, their gradients and splines included, so that the table is asked once for
 * each cell, and what follows are the gathers of one array.
 */
#ifndef VVI_RENDER_MARCH_FETCH_BRICKS_H
#define VVI_RENDER_MARCH_FETCH_BRICKS_H
#include "grid/bricks.h"
#include "render/march/fetch_linear.h"

enum { bricks_near = true };

/* Pages are written by other threads. */
VV_INLINE vi bricks_pages(const vvi_bricks *b, vi brick, vm m)
{
#ifdef __SANITIZE_THREAD__
    int32_t at[VV_WIDTH], page[VV_WIDTH] = {0};
    vi_store(at, brick);
    for (int l = 0; l < VV_WIDTH; l++)
        if (vm_bits(m) >> l & 1)
            page[l] = __atomic_load_n(&b->page[at[l]], __ATOMIC_ACQUIRE);
    return vi_load(page);
#else
    return vi_gather(b->page, vi_shl(brick, 2), m);
#endif
}

/* Bricks that are not there yet, one after the other. */
static __attribute__((noinline)) void bricks_bring(vi *page, const vvi_bricks *b, const vi *brick, vm absent)
{
    int32_t at[VV_WIDTH], pages[VV_WIDTH];
    vi_store(at, *brick);
    vi_store(pages, *page);
    for (int l = 0; l < VV_WIDTH; l++)
        if (vm_bits(absent) >> l & 1)
            pages[l] = vvi_bricks_bring(b, at[l]);
    *page = vi_load(pages);
}

VV_INLINE void bricks_place(sample_place *out, const vvi_lattice *g, vi i, vi j, vi k, vm m)
{
    const vvi_bricks *b = g->bricks;
    const vi inside = vi_set1(VVI_BRICK_CELLS - 1), before = vi_set1(VVI_BRICK_BEFORE);
    const vi row = vi_shr_by(k, VVI_BRICK_SHIFT) * vi_set1(b->n[1]) + vi_shr_by(j, VVI_BRICK_SHIFT);
    const vi brick = row * vi_set1(b->n[0]) + vi_shr_by(i, VVI_BRICK_SHIFT);
    vi page = bricks_pages(b, brick, m);
    const vm absent = vm_and(m, vi_lt(page, vi_set1(0)));
    if (vm_any(absent))
        bricks_bring(&page, b, &brick, absent);
    out->x = page + (i & inside) + before;
    out->y = ((j & inside) + before) * vi_set1(g->row);
    out->z = ((k & inside) + before) * vi_set1((int32_t)g->slice);
}

VV_INLINE int32_t bricks_slice(const vvi_lattice *g)
{
    return (int32_t)g->slice;
}

VV_INLINE void bricks_words(vi *low, vi *high, const vvi_lattice *g, int type, const spot *s, vm m)
{
    linear_words(low, high, g, type, s, m);
}

#endif
