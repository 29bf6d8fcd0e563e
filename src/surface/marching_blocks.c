#include "surface/marching_blocks.h"
#include "core/memory.h"

#include <string.h>

static double threshold_of(const vvi_march *m)
{
    switch (m->type) {
#define THRESHOLD(march_type, ctype)                                                                                   \
    case march_type: {                                                                                                 \
        ctype t;                                                                                                       \
        memcpy(&t, m->threshold, sizeof t);                                                                            \
        return (double)t;                                                                                              \
    }
        THRESHOLD(VVI_MARCH_U8, uint8_t)
        THRESHOLD(VVI_MARCH_U16, uint16_t)
        THRESHOLD(VVI_MARCH_I16, int16_t)
#undef THRESHOLD
    default: {
        float t;
        memcpy(&t, m->threshold, sizeof t);
        return (double)t;
    }
    }
}

/* Blocks [begin, end) of a row; a block without numbers may be either. */
static uint8_t state_of(const float *lo, const float *hi, int64_t begin, int64_t end, double threshold)
{
    bool some_in = false, some_out = false;
    for (int64_t b = begin; b < end; b++) {
        some_in |= (double)hi[b] >= threshold;
        some_out |= (double)lo[b] < threshold;
    }
    return some_in && some_out ? VVI_MARCH_MIXED : some_in ? VVI_MARCH_INSIDE : VVI_MARCH_OUTSIDE;
}

vv_status vvi_march_blocks(vvi_march *m, const vvi_minmax *minmax)
{
    const double threshold = threshold_of(m);
    const int64_t words = (int64_t)m->words - 1, each = 64 >> minmax->shift, nx = minmax->n[0];
    const int64_t rows = (int64_t)minmax->n[1] * minmax->n[2];
    m->blocks = vvi_alloc(m->job, (size_t)(rows * words), VVI_MEM_SCRATCH);
    if (!m->blocks)
        return vv_fail_memory((size_t)(rows * words));
    m->block_shift = minmax->shift;
    m->n_blocks[0] = minmax->n[1];
    m->n_blocks[1] = minmax->n[2];
    for (int64_t r = 0; r < rows; r++)
        for (int64_t w = 0; w < words; w++) { /* the block before has the word's first sample as its last */
            const int64_t begin = w > 0 ? w * each - 1 : 0, end = (w + 1) * each < nx ? (w + 1) * each : nx;
            m->blocks[r * words + w] =
                state_of(minmax->lo + r * nx, minmax->hi + r * nx, begin < end ? begin : end - 1, end, threshold);
        }
    return VV_OK;
}

/* Rows of blocks that a sample lies in: two where it is their border. */
static int touched(int64_t out[2], int64_t at, int shift, int64_t n)
{
    const int64_t b = at >> shift, low = (at & (((int64_t)1 << shift) - 1)) == 0 && b > 0 ? b - 1 : b;
    out[0] = low < n ? low : n - 1;
    out[1] = b < n ? b : n - 1;
    return out[0] == out[1] ? 1 : 2;
}

bool vvi_march_words(uint8_t *out, const vvi_march *m, int64_t j, int64_t k)
{
    const size_t words = m->words - 1;
    int64_t y[2], z[2];
    const int ny = touched(y, j, m->block_shift, m->n_blocks[0]), nz = touched(z, k, m->block_shift, m->n_blocks[1]);
    bool mixed = false;
    for (int b = 0; b < nz; b++)
        for (int a = 0; a < ny; a++) {
            const uint8_t *row = m->blocks + (size_t)(z[b] * m->n_blocks[0] + y[a]) * words;
            for (size_t w = 0; w < words; w++) {
                out[w] = a + b > 0 && out[w] != row[w] ? VVI_MARCH_MIXED : row[w];
                mixed |= out[w] == VVI_MARCH_MIXED;
            }
        }
    return mixed;
}
