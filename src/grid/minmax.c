/* Min-max cells. Each row of blocks is one item: every sample row that it covers is folded into the running smallest
 * and largest row, then the folded rows are reduced along x. Rows are folded as arrays, so the compiler makes vectors
 * of it. */
#include "grid/minmax.h"
#include "core/job.h"
#include "core/memory.h"
#include <math.h>

typedef struct build {
    vvi_minmax *m;
    const vv_brick *brick;
    size_t component;
    size_t row_bytes; /* of one folded row */
    vv_job *job;
} build;

/* A float that is not above v: what floats do not have is rounded outwards, so that a range still holds it. Integers
 * beyond 2^53 are no doubles either. */
static float below(double v)
{
    const float f = (float)v;
    const bool exact = (double)f <= v && (fabs(v) <= 0x1p53 || isinf(v));
    return exact ? f : nextafterf(f, -INFINITY);
}

/* One type: fold a row of n samples into lo and hi (first: it is the first), and reduce folded rows to blocks. NaN
 * never compares, so it is left out; a float row starts at the empty range for that. */
#define FOLD(T, name, EMPTY_LO, EMPTY_HI)                                                                              \
    static void fold_##name(void *lo_row, void *hi_row, const void *data, size_t n, size_t stride, bool first)         \
    {                                                                                                                  \
        T *restrict lo = lo_row, *restrict hi = hi_row;                                                                \
        const T *restrict v = data;                                                                                    \
        if (first)                                                                                                     \
            for (size_t i = 0; i < n; i++) {                                                                           \
                lo[i] = EMPTY_LO;                                                                                      \
                hi[i] = EMPTY_HI;                                                                                      \
            }                                                                                                          \
        if (stride == 1) {                                                                                             \
            for (size_t i = 0; i < n; i++) {                                                                           \
                lo[i] = v[i] < lo[i] ? v[i] : lo[i];                                                                   \
                hi[i] = v[i] > hi[i] ? v[i] : hi[i];                                                                   \
            }                                                                                                          \
            return;                                                                                                    \
        }                                                                                                              \
        for (size_t i = 0; i < n; i++) {                                                                               \
            lo[i] = v[i * stride] < lo[i] ? v[i * stride] : lo[i];                                                     \
            hi[i] = v[i * stride] > hi[i] ? v[i * stride] : hi[i];                                                     \
        }                                                                                                              \
    }                                                                                                                  \
    static void reduce_##name(float *out_lo, float *out_hi, const void *lo_row, const void *hi_row, int64_t n,         \
                              int32_t blocks, int shift)                                                               \
    {                                                                                                                  \
        const T *restrict lo = lo_row, *restrict hi = hi_row;                                                          \
        for (int32_t b = 0; b < blocks; b++) {                                                                         \
            const int64_t from = (int64_t)b << shift, end = from + ((int64_t)1 << shift);                              \
            T l = EMPTY_LO, h = EMPTY_HI;                                                                              \
            for (int64_t i = from; i <= end && i < n; i++) {                                                           \
                l = lo[i] < l ? lo[i] : l;                                                                             \
                h = hi[i] > h ? hi[i] : h;                                                                             \
            }                                                                                                          \
            out_lo[b] = below((double)l);                                                                              \
            out_hi[b] = -below(-(double)h);                                                                            \
        }                                                                                                              \
    }

FOLD(uint8_t, u8, UINT8_MAX, 0)
FOLD(int8_t, i8, INT8_MAX, INT8_MIN)
FOLD(uint16_t, u16, UINT16_MAX, 0)
FOLD(int16_t, i16, INT16_MAX, INT16_MIN)
FOLD(uint32_t, u32, UINT32_MAX, 0)
FOLD(int32_t, i32, INT32_MAX, INT32_MIN)
FOLD(uint64_t, u64, UINT64_MAX, 0)
FOLD(int64_t, i64, INT64_MAX, INT64_MIN)
FOLD(double, f64, INFINITY, -INFINITY)
FOLD(float, f32, INFINITY, -INFINITY)

typedef void fold_fn(void *lo, void *hi, const void *data, size_t n, size_t stride, bool first);
typedef void reduce_fn(float *out_lo, float *out_hi, const void *lo, const void *hi, int64_t n, int32_t blocks,
                       int shift);

static const struct {
    fold_fn *fold;
    reduce_fn *reduce;
} of_type[VV_TYPE_COUNT] = {
    [VV_TYPE_U8] = {fold_u8, reduce_u8},    [VV_TYPE_I8] = {fold_i8, reduce_i8},
    [VV_TYPE_U16] = {fold_u16, reduce_u16}, [VV_TYPE_I16] = {fold_i16, reduce_i16},
    [VV_TYPE_U32] = {fold_u32, reduce_u32}, [VV_TYPE_I32] = {fold_i32, reduce_i32},
    [VV_TYPE_U64] = {fold_u64, reduce_u64}, [VV_TYPE_I64] = {fold_i64, reduce_i64},
    [VV_TYPE_F32] = {fold_f32, reduce_f32}, [VV_TYPE_F64] = {fold_f64, reduce_f64},
};

static vv_status start(void **scratch, void *shared, int worker)
{
    const build *b = shared;
    (void)worker;
    *scratch = vvi_alloc(b->job, 2 * b->row_bytes, VVI_MEM_SCRATCH);
    return *scratch ? VV_OK : vv_fail_memory(2 * b->row_bytes);
}

static void finish(void *scratch, void *shared)
{
    (void)shared;
    vvi_free(scratch);
}

/* Item: the blocks of one (y, z). */
static vv_status item(void *scratch, void *shared, size_t index)
{
    const build *b = shared;
    const vvi_minmax *m = b->m;
    const int64_t *n = b->brick->box.n;
    const int64_t by = (int64_t)index % m->n[1], bz = (int64_t)index / m->n[1], side = (int64_t)1 << m->shift;
    char *lo = scratch, *hi = lo + b->row_bytes;
    const size_t bytes = vv_type_bytes(b->brick->type);
    const size_t stride = (size_t)b->brick->stride[0] / bytes;
    bool first = true;
    for (int64_t k = bz * side; k <= (bz + 1) * side && k < n[2]; k++)
        for (int64_t j = by * side; j <= (by + 1) * side && j < n[1]; j++) {
            const char *row = (const char *)b->brick->data + k * b->brick->stride[2] + j * b->brick->stride[1];
            of_type[b->brick->type].fold(lo, hi, row + b->component * bytes, (size_t)n[0], stride, first);
            first = false;
        }
    const size_t at = index * (size_t)m->n[0];
    of_type[b->brick->type].reduce(m->lo + at, m->hi + at, lo, hi, n[0], m->n[0], m->shift);
    return VV_OK;
}

static int32_t count_blocks(int64_t samples, int shift)
{
    const int64_t cells = samples > 1 ? samples - 1 : 1;
    return (int32_t)((cells + ((int64_t)1 << shift) - 1) >> shift);
}

vv_status vvi_minmax_new(vvi_minmax **out, const int64_t dims[3], int shift, vv_job *job)
{
    *out = NULL;
    vvi_minmax *m = vvi_alloc_zeroed(job, sizeof *m, VVI_MEM_DERIVED);
    if (!m)
        return vv_fail_memory(sizeof *m);
    m->shift = shift;
    size_t n_blocks = 0, bytes = 0;
    vv_status st = VV_OK;
    for (int a = 0; a < 3; a++)
        m->n[a] = count_blocks(dims[a], shift);
    if ((st = vvi_mul3_size(&n_blocks, (size_t)m->n[0], (size_t)m->n[1], (size_t)m->n[2])) != VV_OK ||
        (st = vvi_mul_size(&bytes, n_blocks, sizeof(float))) != VV_OK)
        goto fail;
    m->lo = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    m->hi = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    if (!m->lo || !m->hi) {
        st = vv_fail_memory(bytes);
        goto fail;
    }
    *out = m;
    return VV_OK;
fail:
    vvi_minmax_free(m);
    return st;
}

static vv_status fill_blocks(vvi_minmax *m, const vv_brick *brick, int component, vv_job *job)
{
    build b = {.m = m, .brick = brick, .component = (size_t)component, .job = job};
    b.row_bytes = ((size_t)brick->box.n[0] * vv_type_bytes(brick->type) + 63) & ~(size_t)63;
    const vvi_work work = {.stage = NULL, .start = start, .item = item, .finish = finish};
    return vvi_parallel_for(job, &work, &b, (size_t)m->n[1] * (size_t)m->n[2]);
}

vv_status vvi_minmax_build(vvi_minmax **out, const vv_brick *brick, int component, int shift, vv_job *job)
{
    vv_status st = vvi_minmax_new(out, brick->box.n, shift, job);
    if (st != VV_OK || (st = fill_blocks(*out, brick, component, job)) == VV_OK)
        return st;
    vvi_minmax_free(*out);
    *out = NULL;
    return st;
}

/* Layers ---------------------------------------------------------------------------------------------------------- */

/* The slices of one layer of blocks as numbers of the lattice: rows packed, to `room`. */
static vv_brick layer_numbers(char *room, const vv_brick *brick, const vvi_lattice_numbers *numbers)
{
    const size_t each = vv_type_bytes(numbers->to), row = (size_t)brick->box.n[0];
    vv_brick out = {.data = room, .box = brick->box, .type = numbers->to, .components = 1};
    out.stride[0] = (int64_t)each;
    out.stride[1] = (int64_t)(row * each);
    out.stride[2] = out.stride[1] * brick->box.n[1];
    for (int64_t k = 0; k < brick->box.n[2]; k++)
        for (int64_t j = 0; j < brick->box.n[1]; j++)
            vvi_lattice_convert_row(room + k * out.stride[2] + j * out.stride[1], numbers,
                                    (const char *)brick->data + k * brick->stride[2] + j * brick->stride[1],
                                    brick->stride[0], row);
    return out;
}

static vv_status fill_layer(vvi_minmax *m, const vvi_lattice_hold *hold, int32_t k, char *room, vv_job *job)
{
    vv_box box = vv_field_box(hold->field);
    const int64_t side = (int64_t)1 << m->shift, end = box.n[2];
    const size_t at = (size_t)k * (size_t)m->n[0] * (size_t)m->n[1];
    vvi_minmax layer = {.n = {m->n[0], m->n[1], 1}, .shift = m->shift, .lo = m->lo + at, .hi = m->hi + at};
    vv_brick brick;
    box.lo[2] = k * side;
    box.n[2] = end - box.lo[2] < side + 1 ? end - box.lo[2] : side + 1;
    vv_status st = vv_field_brick(&brick, hold->field, &box, job);
    if (st != VV_OK)
        return st;
    const vv_brick numbers = layer_numbers(room, &brick, &hold->numbers);
    st = fill_blocks(&layer, &numbers, 0, job);
    vv_brick_release(&brick);
    return st;
}

static vv_status build_layers(vvi_minmax **out, const vvi_lattice_hold *hold, int shift, vv_job *job)
{
    const int64_t *dims = vv_field_get_info(hold->field)->grid.dims;
    vv_status st = vvi_minmax_new(out, dims, shift, job);
    if (st != VV_OK)
        return st;
    const size_t slices = ((size_t)1 << shift) + 1;
    const size_t bytes = (size_t)dims[0] * (size_t)dims[1] * slices * vv_type_bytes(hold->numbers.to);
    char *room = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!room)
        st = vv_fail_memory(bytes);
    for (int32_t k = 0; k < (*out)->n[2] && st == VV_OK; k++)
        st = fill_layer(*out, hold, k, room, job);
    vvi_free(room);
    if (st == VV_OK)
        return VV_OK;
    vvi_minmax_free(*out);
    *out = NULL;
    return st;
}

void vvi_minmax_free(void *minmax)
{
    vvi_minmax *m = minmax;
    if (!m)
        return;
    vvi_free(m->lo);
    vvi_free(m->hi);
    vvi_free(m);
}

typedef struct request {
    const vv_brick *brick;
    const vvi_lattice_hold *in_bricks; /* NULL: not */
    int component, shift;
} request;

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    vvi_minmax *m = NULL;
    const vv_status st = r->in_bricks ? build_layers(&m, r->in_bricks, r->shift, job)
                                      : vvi_minmax_build(&m, r->brick, r->component, r->shift, job);
    if (st == VV_OK)
        *bytes_out = (uint64_t)m->n[0] * (uint64_t)m->n[1] * (uint64_t)m->n[2] * 2 * sizeof(float);
    *value_out = m;
    return st;
}

vvi_cache_key vvi_minmax_key(const char *what, const vv_field *field, int component, int shift)
{
    return (vvi_cache_key){what, vv_field_identity(field), (uint64_t)shift << 32 | (uint32_t)component};
}

vv_status vvi_minmax_get(vvi_cached **out, const vvi_cache_key *key, const vv_brick *brick, int component, int shift,
                         vv_job *job)
{
    request r = {brick, NULL, component, shift};
    return vvi_cache_get(out, key, make, vvi_minmax_free, &r, job);
}

vv_status vvi_minmax_get_lattice(vvi_cached **out, const vvi_cache_key *key, const vvi_lattice_hold *hold, int shift,
                                 vv_job *job)
{
    request r = {&hold->brick, hold->lattice.fetch == VVI_FETCH_BRICKS ? hold : NULL, 0, shift};
    return vvi_cache_get(out, key, make, vvi_minmax_free, &r, job);
}
