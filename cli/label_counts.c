#include "label_counts.h"
#include "core/job.h"
#include <stdlib.h>
#include <string.h>

enum { MOST = 1 << 22 };

/* Open addressing over a power of two of slots; a slot with count 0 is free. */
typedef struct table {
    cli_label_count *slot;
    size_t room, n;
} table;

static size_t place_of(const table *t, int64_t value)
{
    size_t at = (size_t)((uint64_t)value * UINT64_C(0x9e3779b97f4a7c15) >> 20) & (t->room - 1);
    while (t->slot[at].count && t->slot[at].value != value)
        at = (at + 1) & (t->room - 1);
    return at;
}

static vv_status grow(table *t)
{
    const table old = *t;
    t->room = old.room ? old.room * 2 : 1024;
    t->slot = calloc(t->room, sizeof *t->slot);
    if (!t->slot) {
        *t = old;
        return vv_fail_memory(old.room * 2 * sizeof *t->slot);
    }
    for (size_t i = 0; i < old.room; i++)
        if (old.slot[i].count)
            t->slot[place_of(t, old.slot[i].value)] = old.slot[i];
    free(old.slot);
    return VV_OK;
}

static vv_status add(table *t, int64_t value, uint64_t count)
{
    vv_status st = 2 * t->n >= t->room ? grow(t) : VV_OK;
    if (st != VV_OK)
        return st;
    cli_label_count *slot = &t->slot[place_of(t, value)];
    t->n += slot->count == 0;
    *slot = (cli_label_count){value, slot->count + count};
    return t->n <= MOST ? VV_OK : vv_fail(VV_E_LIMIT, "the field has more than %d different labels", MOST);
}

static int64_t stored(const char *at, vv_type type)
{
    int64_t v = 0;
    memcpy(&v, at, vv_type_bytes(type));
    const unsigned bits = 8 * (unsigned)vv_type_bytes(type);
    const bool is_signed = type == VV_TYPE_I8 || type == VV_TYPE_I16 || type == VV_TYPE_I32;
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    v = (int64_t)((uint64_t)v >> (64 - bits));
#endif
    if (is_signed && (v >> (bits - 1) & 1))
        v |= (int64_t)(~UINT64_C(0) << bits);
    return v;
}

/* Neighbours are mostly alike: runs are counted, not samples. */
static vv_status add_row(table *t, const char *row, int64_t n, int64_t stride, vv_type type)
{
    vv_status st = VV_OK;
    const size_t bytes = vv_type_bytes(type);
    for (int64_t i = 0, end; i < n && st == VV_OK; i = end) {
        const char *first = row + i * stride;
        for (end = i + 1; end < n && memcmp(first, row + end * stride, bytes) == 0;)
            end++;
        st = add(t, stored(first, type), (uint64_t)(end - i));
    }
    return st;
}

static vv_status add_slice(table *t, const vv_field *field, int64_t k, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    const vv_box box = {{0, 0, k}, {info->grid.dims[0], info->grid.dims[1], 1}};
    vv_brick brick;
    vv_status st = vv_field_brick(&brick, field, &box, job);
    if (st != VV_OK)
        return st;
    for (int64_t j = 0; j < box.n[1] && st == VV_OK; j++)
        st = add_row(t, (const char *)brick.data + j * brick.stride[1], box.n[0], brick.stride[0], info->type);
    vv_brick_release(&brick);
    return st == VV_OK && vv_job_cancelled(job) ? vv_fail(VV_E_CANCELLED, "interrupted while counting labels") : st;
}

static int by_value(const void *a, const void *b)
{
    const int64_t x = ((const cli_label_count *)a)->value, y = ((const cli_label_count *)b)->value;
    return (x > y) - (x < y);
}

vv_status cli_count_labels(cli_label_count **out, size_t *n_out, const vv_field *field, vv_job *job)
{
    table t = {0};
    vv_status st = VV_OK;
    *out = NULL;
    *n_out = 0;
    for (int64_t k = 0; k < vv_field_get_info(field)->grid.dims[2] && st == VV_OK; k++)
        st = add_slice(&t, field, k, job);
    if (st != VV_OK) {
        free(t.slot);
        return st;
    }
    for (size_t i = 0; i < t.room; i++)
        if (t.slot[i].count)
            t.slot[(*n_out)++] = t.slot[i];
    if (t.slot)
        qsort(t.slot, *n_out, sizeof *t.slot, by_value);
    *out = t.slot;
    return VV_OK;
}
