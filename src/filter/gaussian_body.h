/* The loops of gaussian_lines.h for one type of number. Before it: REAL and NAME(x), which names a function for it. */
#include "core/job.h"
#include "filter/gaussian_lines.h"

#include <math.h>
#include <string.h>

#define BLOCK 256 /* numbers of a row that stay in the first-level cache while all weights pass over them */

static void add_pair(REAL *restrict sum, const REAL *restrict c, const REAL *restrict a, const REAL *restrict b, REAL w,
                     int64_t n)
{
    for (int64_t i = 0; i < n; i++)
        sum[i] += w * ((a[i] - c[i]) + (b[i] - c[i]));
}

void NAME(vvi_gaussian_row)(REAL *out, const REAL *rows, int64_t k, int64_t n_rows, int64_t stride, int64_t n,
                            const vvi_gaussian_weights *weights)
{
    for (int64_t at = 0; at < n; at += BLOCK) {
        const int64_t now = n - at < BLOCK ? n - at : BLOCK;
        const REAL *c = rows + k * stride + at;
        REAL sum[BLOCK] = {0};
        for (int64_t r = 1; r <= weights->radius; r++) {
            const int64_t below = k - r < 0 ? 0 : k - r, above = k + r >= n_rows ? n_rows - 1 : k + r;
            add_pair(sum, c, rows + below * stride + at, rows + above * stride + at, (REAL)weights->w[r], now);
        }
        for (int64_t i = 0; i < now; i++)
            out[at + i] = c[i] + sum[i];
    }
}

/* Along x the neighbours lie in the same row, `step` numbers apart; the row has a margin of radius * step. */
static void smooth_x(REAL *out, const REAL *row, int64_t n, int64_t step, const vvi_gaussian_weights *weights)
{
    for (int64_t at = 0; at < n; at += BLOCK) {
        const int64_t now = n - at < BLOCK ? n - at : BLOCK;
        const REAL *c = row + at;
        REAL sum[BLOCK] = {0};
        for (int64_t r = 1; r <= weights->radius; r++)
            add_pair(sum, c, c - r * step, c + r * step, (REAL)weights->w[r], now);
        for (int64_t i = 0; i < now; i++)
            out[at + i] = c[i] + sum[i];
    }
}

#define CONVERT(ctype)                                                                                                 \
    for (int64_t i = 0; i < n; i++) {                                                                                  \
        ctype v;                                                                                                       \
        memcpy(&v, in + (size_t)i * sizeof v, sizeof v);                                                               \
        out[i] = (REAL)v;                                                                                              \
    }                                                                                                                  \
    break

static void load(REAL *out, const char *in, vv_type type, int64_t n)
{
    switch (type) {
    case VV_TYPE_U8:
        CONVERT(uint8_t);
    case VV_TYPE_I8:
        CONVERT(int8_t);
    case VV_TYPE_U16:
        CONVERT(uint16_t);
    case VV_TYPE_I16:
        CONVERT(int16_t);
    case VV_TYPE_U32:
        CONVERT(uint32_t);
    case VV_TYPE_I32:
        CONVERT(int32_t);
    case VV_TYPE_U64:
        CONVERT(uint64_t);
    case VV_TYPE_I64:
        CONVERT(int64_t);
    case VV_TYPE_F32:
        CONVERT(float);
    case VV_TYPE_F64:
        CONVERT(double);
    }
}

static void only_finite(REAL *row, int64_t n, vvi_gaussian_source source, bool *odd)
{
    for (int64_t i = 0; i < n; i++) {
        const bool finite = isfinite(row[i]);
        *odd |= !finite;
        if (source == VVI_GAUSSIAN_MASK)
            row[i] = finite;
        else if (!finite)
            row[i] = 0;
    }
}

/* Margins repeat the samples at the ends. */
static void pad(REAL *row, int64_t n, int64_t step, int64_t margin)
{
    for (int64_t i = 1; i <= margin; i++) {
        row[-i] = row[-i + step];
        row[n - 1 + i] = row[n - 1 + i - step];
    }
}

vv_status NAME(vvi_gaussian_slice)(REAL *out, bool *odd, REAL *room, const vv_brick *brick, vvi_gaussian_source source,
                                   const vvi_gaussian_weights *x, const vvi_gaussian_weights *y, vv_job *job)
{
    const int64_t step = brick->components, n = brick->box.n[0] * step, margin = x->radius * step;
    const int64_t ny = brick->box.n[1];
    REAL *row = room + margin, *smooth = room + n + 2 * margin;
    vv_status st = VV_OK;
    for (int64_t j = 0; j < ny && st == VV_OK; j++) {
        load(row, (const char *)brick->data + j * brick->stride[1], brick->type, n);
        if (vv_type_is_float(brick->type))
            only_finite(row, n, source, odd);
        pad(row, n, step, margin);
        smooth_x(smooth + j * n, row, n, step, x);
        st = vvi_job_poll(job);
    }
    for (int64_t j = 0; j < ny && st == VV_OK; j++) {
        NAME(vvi_gaussian_row)(out + j * n, smooth, j, ny, n, n, y);
        st = vvi_job_poll(job);
    }
    return st;
}
