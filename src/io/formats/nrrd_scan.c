/* What labels there are in samples, and where: looked up before they are written as segments. */
#include "io/formats/nrrd_scan.h"
#include "core/job.h"
#include "core/memory.h"
#include <stdlib.h>
#include <string.h>

#define SLOTS (4 * (size_t)VVI_NRRD_NAMES_MOST) /* a power of two, and more than are kept */

static int64_t sample_at(const uint8_t *at, vv_type type)
{
    union {
        uint8_t u8;
        int8_t i8;
        uint16_t u16;
        int16_t i16;
        uint32_t u32;
        int32_t i32;
        int64_t i64;
    } v = {0};
    memcpy(&v, at, vv_type_bytes(type));
    switch (type) {
    case VV_TYPE_U8:
        return v.u8;
    case VV_TYPE_I8:
        return v.i8;
    case VV_TYPE_U16:
        return v.u16;
    case VV_TYPE_I16:
        return v.i16;
    case VV_TYPE_U32:
        return v.u32;
    case VV_TYPE_I32:
        return v.i32;
    default:
        return v.i64;
    }
}

/* A set of values, in which 0 marks what is free: it is no label. */
static void add_value(vvi_nrrd_scan *s, int64_t value)
{
    size_t slot = (size_t)((uint64_t)value * UINT64_C(0x9e3779b97f4a7c15) >> 40) & (SLOTS - 1);
    while (s->slot[slot] != 0 && s->slot[slot] != value)
        slot = (slot + 1) & (SLOTS - 1);
    if (s->slot[slot] == value)
        return;
    s->many |= s->n_values == VVI_NRRD_NAMES_MOST;
    if (s->many)
        return;
    s->slot[slot] = value;
    s->value[s->n_values++] = value;
}

static void widen(int64_t box[6], int64_t first, int64_t last, int64_t j, int64_t k)
{
    const int64_t lo[3] = {first, j, k}, hi[3] = {last, j, k};
    for (int a = 0; a < 3; a++) {
        box[2 * a] = lo[a] < box[2 * a] ? lo[a] : box[2 * a];
        box[2 * a + 1] = hi[a] > box[2 * a + 1] ? hi[a] : box[2 * a + 1];
    }
}

static void look_at_row(vvi_nrrd_scan *s, const vv_brick *b, int64_t j, int64_t k)
{
    const uint8_t *row = (const uint8_t *)b->data + j * b->stride[1];
    const int64_t n = b->box.n[0];
    for (int64_t i = 0, end = 0; i < n; i = end) {
        const int64_t value = sample_at(row + i * b->stride[0], b->type);
        for (end = i + 1; end < n && sample_at(row + end * b->stride[0], b->type) == value;)
            end++;
        if (value == 0)
            continue;
        add_value(s, value);
        widen(s->box, i, end - 1, j, k);
        s->n_labelled += (uint64_t)(end - i);
        s->n_alone += end == i + 1;
    }
}

static int by_value(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

vv_status vvi_nrrd_scan_labels(vvi_nrrd_scan **out, const vv_field *field, vv_job *job)
{
    const int64_t *dims = vv_field_get_info(field)->grid.dims;
    vv_status st = VV_OK;
    vvi_nrrd_scan *s = vvi_alloc_zeroed(job, sizeof *s + SLOTS * sizeof(int64_t), VVI_MEM_SCRATCH);
    *out = s;
    if (!s)
        return vv_fail_memory(sizeof *s);
    s->slot = (int64_t *)(void *)(s + 1);
    for (int a = 0; a < 3; a++)
        s->box[2 * a] = INT64_MAX;
    for (int64_t k = 0; k < dims[2] && st == VV_OK; k++) {
        const vv_box slice = {{0, 0, k}, {dims[0], dims[1], 1}};
        vv_brick brick;
        if ((st = vvi_job_poll(job)) != VV_OK || (st = vv_field_brick(&brick, field, &slice, job)) != VV_OK)
            break;
        for (int64_t j = 0; j < dims[1]; j++)
            look_at_row(s, &brick, j, k);
        vv_brick_release(&brick);
    }
    qsort(s->value, s->n_values, sizeof *s->value, by_value);
    if (s->n_labelled == 0)
        memcpy(s->box, (const int64_t[6]){0, -1, 0, -1, 0, -1}, sizeof s->box);
    return st;
}
