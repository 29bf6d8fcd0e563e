/** @file
 * Records of a reduced surface: written and read as bits, the lowest first.
 */
#ifndef VVI_SURFACE_REDUCED_RECORDS_H
#define VVI_SURFACE_REDUCED_RECORDS_H
#include "surface/cases.h"
#include "surface/reduced.h"

enum { VVI_REDUCED_RECORD_BYTES = 6 /* at most */ };

typedef struct vvi_reduced_bits {
    uint8_t *at;
    uint64_t bits;
    int n;
} vvi_reduced_bits;

static inline void vvi_reduced_put(vvi_reduced_bits *b, uint64_t value, int n)
{
    b->bits |= value << b->n;
    for (b->n += n; b->n >= 8; b->n -= 8, b->bits >>= 8)
        *b->at++ = (uint8_t)b->bits;
}

/** The last bits of a brick, to the end of their byte. */
static inline void vvi_reduced_end(vvi_reduced_bits *b)
{
    if (b->n > 0)
        *b->at++ = (uint8_t)b->bits;
    b->bits = 0;
    b->n = 0;
}

typedef struct vvi_reduced_reader {
    const uint8_t *at;
    uint64_t bits;
    int n;
} vvi_reduced_reader;

static inline unsigned vvi_reduced_get(vvi_reduced_reader *r, int n)
{
    while (r->n < n) {
        r->bits |= (uint64_t)*r->at++ << r->n;
        r->n += 8;
    }
    const unsigned value = (unsigned)(r->bits & (((uint64_t)1 << n) - 1));
    r->bits >>= n;
    r->n -= n;
    return value;
}

/** A record that was read. */
typedef struct vvi_reduced_cell {
    int32_t at[3]; /**< in the brick */
    const vvi_case *k;
    uint8_t q[12]; /**< of the edges that are crossed */
} vvi_reduced_cell;

static inline const vvi_case *vvi_reduced_case(unsigned pattern)
{
    return &vvi_cases[vvi_case_first[pattern]];
}

static inline void vvi_reduced_read(vvi_reduced_cell *c, vvi_reduced_reader *r)
{
    const unsigned local = vvi_reduced_get(r, 3 * VVI_REDUCED_SHIFT);
    c->k = vvi_reduced_case(vvi_reduced_get(r, 8));
    for (int a = 0; a < 3; a++)
        c->at[a] = (int32_t)(local >> a * VVI_REDUCED_SHIFT & (VVI_REDUCED_SIDE - 1));
    for (unsigned rest = c->k->edges; rest; rest &= rest - 1)
        c->q[__builtin_ctz(rest)] = (uint8_t)vvi_reduced_get(r, 2);
}

/** The triangles of a cell. */
void vvi_reduced_triangles(vvi_reduced_triangle *out, const vvi_reduced_cell *cell);
#endif
