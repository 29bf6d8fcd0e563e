#include "filter/mean_lines.h"
#include "core/memory.h"
#include "grid/field.h"

#include <string.h>

vvi_mean_number vvi_mean_number_for(vv_type type, int64_t samples)
{
    if (vv_type_is_float(type) || vv_type_bytes(type) == 8)
        return VVI_MEAN_F64;
    return vv_type_bytes(type) <= 2 && samples <= 32767 ? VVI_MEAN_I32 : VVI_MEAN_I64;
}

size_t vvi_mean_number_bytes(vvi_mean_number number)
{
    return number == VVI_MEAN_I32 ? sizeof(int32_t) : sizeof(int64_t);
}

#define EACH(number, ctype, bytes)                                                                                     \
    for (int64_t i = 0; i < n; i++) {                                                                                  \
        ctype v;                                                                                                       \
        memcpy(&v, in + i * (bytes), sizeof v);                                                                        \
        to[i] = (number)v;                                                                                             \
    }
/* Packed samples become vectors. */
#define LOAD(number, ctype)                                                                                            \
    {                                                                                                                  \
        if (step == sizeof(ctype))                                                                                     \
            EACH(number, ctype, (int64_t)sizeof(ctype))                                                                \
        else                                                                                                           \
            EACH(number, ctype, step)                                                                                  \
        break;                                                                                                         \
    }

static void load_i32(int32_t *to, const char *in, int64_t step, vv_type type, int64_t n)
{
    switch (type) {
    case VV_TYPE_U8:
        LOAD(int32_t, uint8_t)
    case VV_TYPE_I8:
        LOAD(int32_t, int8_t)
    case VV_TYPE_U16:
        LOAD(int32_t, uint16_t)
    default:
        LOAD(int32_t, int16_t)
    }
}

static void load_i64(int64_t *to, const char *in, int64_t step, vv_type type, int64_t n)
{
    switch (type) {
    case VV_TYPE_U8:
        LOAD(int64_t, uint8_t)
    case VV_TYPE_I8:
        LOAD(int64_t, int8_t)
    case VV_TYPE_U16:
        LOAD(int64_t, uint16_t)
    case VV_TYPE_I16:
        LOAD(int64_t, int16_t)
    case VV_TYPE_U32:
        LOAD(int64_t, uint32_t)
    default:
        LOAD(int64_t, int32_t)
    }
}

static void load_f64(double *to, const char *in, int64_t step, vv_type type, int64_t n)
{
    switch (type) {
    case VV_TYPE_U64:
        LOAD(double, uint64_t)
    case VV_TYPE_I64:
        LOAD(double, int64_t)
    case VV_TYPE_F32:
        LOAD(double, float)
    default:
        LOAD(double, double)
    }
}

void vvi_mean_load(void *out, vvi_mean_number number, const char *in, int64_t step, vv_type type, int64_t n)
{
    if (number == VVI_MEAN_I32)
        load_i32(out, in, step, type, n);
    else if (number == VVI_MEAN_I64)
        load_i64(out, in, step, type, n);
    else
        load_f64(out, in, step, type, n);
}

/* Runs of `width` of n numbers, `step` bytes from one to the next, from the highest binary digit of width to the
 * lowest. */
static void run(char *out, const char *in, int64_t n, int64_t step, int64_t width, vvi_mean_join *join, int64_t bytes)
{
    const char *from = in;
    int64_t done = 1;
    int digit = 0;
    while (width >> (digit + 1))
        digit++;
    for (digit--; digit >= 0; digit--) {
        const int64_t odd = width >> digit & 1, next = 2 * done + odd;
        join(out, from, from + done * step, odd ? in + 2 * done * step : NULL, n - (next - 1) * (step / bytes));
        from = out;
        done = next;
    }
}

static void swap(char **a, char **b)
{
    char *const other = *a;
    *a = *b;
    *b = other;
}

static void find_levels(vvi_mean_stack *s)
{
    const int64_t width = 2 * s->radius[2] + 1;
    int digit = 0;
    while (width >> (digit + 1))
        digit++;
    s->levels = digit;
    for (int l = 0; l <= s->levels; l++)
        s->width[l] = width >> (digit - l);
    for (int l = 0; l < s->levels; l++) /* from the first of the next level's sum to the last of this level's */
        s->slots[l] = s->width[l + 1] - s->width[l] + 1;
}

vv_status vvi_mean_stack_init(vvi_mean_stack *s, vvi_mean_number number, const int64_t dims[2], const int64_t radius[3],
                              const vvi_mean_kernels *kernels, vv_job *job)
{
    const int64_t bytes = (int64_t)vvi_mean_number_bytes(number);
    *s = (vvi_mean_stack){.number = number, .kernels = kernels};
    memcpy(s->radius, radius, sizeof s->radius);
    find_levels(s);
    s->plane = dims[0] * (dims[1] - 2 * radius[1]) * bytes + VVI_MEAN_GUARD;
    const int64_t slice = dims[0] * dims[1] * bytes + VVI_MEAN_GUARD;
    int64_t all = 2 * slice + s->plane;
    for (int l = 0; l < s->levels; l++)
        all += s->slots[l] * s->plane;
    s->block = vvi_alloc_zeroed(job, (size_t)all, VVI_MEM_SCRATCH);
    if (!s->block)
        return vv_fail_memory((size_t)all);
    s->room = s->block + slice;
    s->sums = s->room + slice;
    char *at = s->sums + s->plane;
    for (int l = 0; l < s->levels; at += s->slots[l] * s->plane, l++)
        s->ring[l] = at;
    return VV_OK;
}

void vvi_mean_stack_finish(vvi_mean_stack *s)
{
    vvi_free(s->block);
    s->block = NULL;
}

void vvi_mean_stack_begin(vvi_mean_stack *s, const int64_t dims[2])
{
    memcpy(s->dims, dims, sizeof s->dims);
    s->next = 0;
}

static char *slot(const vvi_mean_stack *s, int level, int64_t k)
{
    return s->ring[level] + k % s->slots[level] * s->plane;
}

static int64_t kept_numbers(const vvi_mean_stack *s)
{
    return s->dims[0] * (s->dims[1] - 2 * s->radius[1]);
}

void vvi_mean_stack_ones(vvi_mean_stack *s, int64_t slices)
{
    const int64_t box = (2 * s->radius[0] + 1) * (2 * s->radius[1] + 1);
    s->next = slices;
    for (int l = 0; l < s->levels; l++)
        for (int64_t k = 0; k < s->slots[l]; k++)
            for (int64_t i = 0; i < kept_numbers(s); i++)
                ((double *)(void *)slot(s, l, k))[i] = (double)(box * s->width[l]);
}

/* Of a slice, along x and along y: a run of 2 m or 2 m + 1 of two of m. */
static const char *sum_slice(const vvi_mean_stack *s, int64_t bytes)
{
    const int64_t n = s->dims[0] * s->dims[1];
    char *in = s->block, *out = s->room;
    for (int a = 0; a < 2; a++) {
        if (s->radius[a] == 0)
            continue;
        run(out, in, n, (a ? s->dims[0] : 1) * bytes, 2 * s->radius[a] + 1, s->kernels->join[s->number], bytes);
        swap(&in, &out);
    }
    return in;
}

const void *vvi_mean_stack_add(vvi_mean_stack *s, bool again)
{
    const int64_t bytes = (int64_t)vvi_mean_number_bytes(s->number), n = kept_numbers(s), last = s->next++;
    if (s->levels == 0)
        return sum_slice(s, bytes);
    memcpy(slot(s, 0, last), again ? slot(s, 0, last - 1) : sum_slice(s, bytes), (size_t)(n * bytes));
    for (int l = 0; l < s->levels; l++) {
        const int64_t width = s->width[l], first = last - s->width[l + 1] + 1;
        const bool odd = s->width[l + 1] & 1;
        if (first < 0)
            return NULL;
        s->kernels->join[s->number](l + 1 < s->levels ? slot(s, l + 1, first) : s->sums, slot(s, l, first),
                                    slot(s, l, first + width), odd ? slot(s, 0, last) : NULL, n);
    }
    return s->sums;
}

void vvi_mean_give(double *out, const void *sums, vvi_mean_number number, int64_t at, int64_t n)
{
    if (number == VVI_MEAN_F64)
        memcpy(out, (const double *)sums + at, (size_t)n * sizeof *out);
    else if (number == VVI_MEAN_I32)
        for (int64_t i = 0; i < n; i++)
            out[i] = (double)((const int32_t *)sums)[at + i];
    else
        for (int64_t i = 0; i < n; i++)
            out[i] = (double)((const int64_t *)sums)[at + i];
}

/* Above 2^51 the last bit of a double is worth 1. */
#define STORE(ctype, wide, magic)                                                                                      \
    for (int64_t i = 0; i < n; i++) {                                                                                  \
        const ctype v = (ctype)(wide)((means[i] + (magic)) - (magic));                                                 \
        memcpy(out + i * step, &v, sizeof v);                                                                          \
    }                                                                                                                  \
    break

void vvi_mean_store(char *out, int64_t step, const double *means, vv_type type, int64_t n)
{
    const double to_whole = 0x1.8p52;
    switch (type) {
    case VV_TYPE_U8:
        STORE(uint8_t, int32_t, to_whole);
    case VV_TYPE_I8:
        STORE(int8_t, int32_t, to_whole);
    case VV_TYPE_U16:
        STORE(uint16_t, int32_t, to_whole);
    case VV_TYPE_I16:
        STORE(int16_t, int32_t, to_whole);
    case VV_TYPE_U32:
        STORE(uint32_t, int64_t, to_whole);
    case VV_TYPE_I32:
        STORE(int32_t, int32_t, to_whole);
    case VV_TYPE_F32:
        STORE(float, double, 0);
    case VV_TYPE_U64:
    case VV_TYPE_I64:
    case VV_TYPE_F64:
        for (int64_t i = 0; i < n; i++)
            vvi_samples_from_f64(out + i * step, means + i, type, 1);
    }
}
