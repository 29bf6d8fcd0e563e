/** @file
 * How samples are fetched: one row for each way that they may lie in memory. For kernels only.
 *
 * What is made of samples (values, gradients, corners of cells) is written once, in lattice_simd.h, for samples that
 * have *places*: three offsets, by which a sample's neighbours along an axis are found by addition. A way to fetch says
 * which place a sample has, and which words are there:
 *
 *     <name>_place(out, g, i, j, k, m)       the offsets of samples i, j, k; any of them in lanes that are not in m.
 *                                            From there one sample before and two behind it on every axis, as far as
 *                                            the lattice goes, are one offset apart
 *     <name>_slice(g)                        the offset from z to z + 1; from y to y + 1 it is g->row
 *     <name>_words(low, high, g, type, s, m) the 4 bytes from sample s on, and the 4 behind these (high NULL: not
 *                                            asked for); 0 in lanes that are not in m
 *     <name>_near                            constant: places are offsets from g->data, which gathers take
 *
 * A new way is a file with these four, a row here, and one in VVI_FETCH_* (grid/lattice.h).
 */
#ifndef VVI_RENDER_MARCH_FETCH_H
#define VVI_RENDER_MARCH_FETCH_H
#include "render/march/fetch_bricks.h"
#include "render/march/fetch_linear.h"
#include "render/march/fetch_wide.h"

#define FETCH_ROWS(ROW)                                                                                                \
    ROW(LINEAR, linear)                                                                                                \
    ROW(WIDE, wide)                                                                                                    \
    ROW(BRICKS, bricks)

/* A kernel's way to sample is a number that it has as a constant: sample type and way to fetch, or VVI_SAMPLE_ANY,
 * which asks the lattice. Those that are fetched as one array have the numbers of their types. */
enum { FETCH_SHIFT = 4, TYPE_MASK = (1 << FETCH_SHIFT) - 1 };

VV_INLINE int type_of(int how)
{
    return how & TYPE_MASK;
}

VV_INLINE int lattice_how(const vvi_lattice *g)
{
    return g->sample_type | g->fetch << FETCH_SHIFT;
}

/** `case`s of all that there are: CALL(how) for each. */
#define EACH_TYPE_(NAME, name)                                                                                         \
    CASE_(VVI_SAMPLE_U8, NAME)                                                                                         \
    CASE_(VVI_SAMPLE_U16, NAME)                                                                                        \
    CASE_(VVI_SAMPLE_I16, NAME)                                                                                        \
    CASE_(VVI_SAMPLE_F32, NAME)
#define CASE_(type, NAME)                                                                                              \
    case type | VVI_FETCH_##NAME << FETCH_SHIFT:                                                                       \
        CALL(type | VVI_FETCH_##NAME << FETCH_SHIFT);                                                                  \
        break;
#define EACH_HOW FETCH_ROWS(EACH_TYPE_)

VV_INLINE void fetch_place(sample_place *out, const vvi_lattice *g, int fetch, vi i, vi j, vi k, vm m)
{
#define PLACE(NAME, name)                                                                                              \
    case VVI_FETCH_##NAME:                                                                                             \
        name##_place(out, g, i, j, k, m);                                                                              \
        break;
    switch (fetch) {
        FETCH_ROWS(PLACE)
    }
#undef PLACE
}

VV_INLINE vi fetch_slice(const vvi_lattice *g, int fetch)
{
#define SLICE(NAME, name)                                                                                              \
    case VVI_FETCH_##NAME:                                                                                             \
        return vi_set1(name##_slice(g));
    switch (fetch) {
        FETCH_ROWS(SLICE)
    }
#undef SLICE
    return vi_set1(0);
}

VV_INLINE bool fetch_is_near(int fetch)
{
#define NEAR(NAME, name)                                                                                               \
    case VVI_FETCH_##NAME:                                                                                             \
        return name##_near;
    switch (fetch) {
        FETCH_ROWS(NEAR)
    }
#undef NEAR
    return false;
}

VV_INLINE void fetch_words(vi *low, vi *high, const vvi_lattice *g, int how, const spot *s, vm m)
{
#define WORDS(NAME, name)                                                                                              \
    case VVI_FETCH_##NAME:                                                                                             \
        name##_words(low, high, g, type_of(how), s, m);                                                                \
        break;
    switch (how >> FETCH_SHIFT) {
        FETCH_ROWS(WORDS)
    default:
        *low = vi_set1(0);
        if (high)
            *high = *low;
    }
#undef WORDS
}

#endif
