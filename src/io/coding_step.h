/** @file
 * What decoders and encoders do with a step.
 */
#ifndef VVI_IO_CODING_STEP_H
#define VVI_IO_CODING_STEP_H
#include "io/coding.h"
#include <limits.h>

/** As much as a library that counts in unsigned can take at once. */
static inline unsigned vvi_clamp_uint(size_t n)
{
    return n > UINT_MAX / 2 ? UINT_MAX / 2 : (unsigned)n;
}

static inline void vvi_coding_advance(vvi_coding_step *step, size_t in, size_t out)
{
    if (in > 0) /* there may be no input at all while a stream is ended */
        step->in += in;
    step->n_in -= in;
    step->out += out;
    step->n_out -= out;
}
#endif
