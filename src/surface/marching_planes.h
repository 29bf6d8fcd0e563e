/** @file
 * Slices of samples as rows of bits, and their crossed edges.
 */
#ifndef VVI_SURFACE_MARCHING_PLANES_H
#define VVI_SURFACE_MARCHING_PLANES_H
#include "surface/marching_plan.h"

static inline const uint64_t *vvi_march_bits(const uint64_t *bits, const vvi_march *m, int64_t j)
{
    return bits + (size_t)j * m->words;
}

static inline vvi_march_row_count *vvi_march_counts(const vvi_march *m, int64_t k)
{
    return m->rows + (size_t)(k * m->n[1]);
}

/** Words with all that two spans have. */
static inline vvi_march_span vvi_march_join(vvi_march_span a, vvi_march_span b)
{
    if (a.begin == a.end)
        return b;
    if (b.begin == b.end)
        return a;
    return (vvi_march_span){a.begin < b.begin ? a.begin : b.begin, a.end > b.end ? a.end : b.end};
}

/** With the word before, in whose last bit a row may begin to differ. */
static inline vvi_march_span vvi_march_one_before(vvi_march_span a)
{
    return (vvi_march_span){a.begin > 0 && a.begin < a.end ? (uint16_t)(a.begin - 1) : a.begin, a.end};
}

/** Classifies slice k as w->plane[1]. `counted`: the rows that the surface passes are known, and their spans. */
void vvi_march_first_plane(vvi_march_worker *w, const vvi_march *m, int64_t k, bool counted);
/** The same, after what was w->plane[1] has become w->plane[0]. */
void vvi_march_next_plane(vvi_march_worker *w, const vvi_march *m, int64_t k, bool counted);
/** Samples of a plane that are no numbers. */
size_t vvi_march_count_unknown(const vvi_march_plane *p, const vvi_march *m);

/** Bit x of out, in the words of *span: the edge from sample x of row j to the next is crossed. How many. */
size_t vvi_march_along(uint64_t *out, vvi_march_span *span, const vvi_march_plane *p, int64_t j, const vvi_march *m);
/** The same for edges from row j of one plane to row i of the same or another. */
size_t vvi_march_between(uint64_t *out, vvi_march_span *span, const vvi_march_plane *p, int64_t j,
                         const vvi_march_plane *q, int64_t i, const vvi_march *m);
/** Counts the crossed edges that begin in slice k, which is p, row by row, and marks those rows; their sum. q: the
 * slice after; NULL: there is none. */
size_t vvi_march_count_edges(const vvi_march_plane *p, const vvi_march_plane *q, const vvi_march_worker *w,
                             const vvi_march *m, int64_t k);
/** Numbers the vertices on the edges within slice k from `first` on, once they are counted; how many there are. */
size_t vvi_march_number_plane(vvi_march_plane *p, const vvi_march *m, int64_t k, size_t first);
/** The same for the edges from slice k to the next. */
size_t vvi_march_number_between(vvi_march_worker *w, const vvi_march *m, int64_t k, size_t first);
#endif
