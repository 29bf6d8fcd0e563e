#include "label_counts.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/label_set.h"
#include <stdlib.h>

enum { MOST = 1 << 22 };

typedef struct counting {
    vvi_label_set set;
    uint64_t *count; /* by number */
    size_t room;
    vv_label_id *row;
    vv_job *job;
} counting;

static vv_status grow(counting *c)
{
    const size_t room = c->room ? 2 * c->room : 1024;
    uint64_t *grown = vvi_realloc(c->job, c->count, room * sizeof *grown, VVI_MEM_SCRATCH);
    if (!grown)
        return vv_fail_memory(room * sizeof *grown);
    c->count = grown;
    c->room = room;
    return VV_OK;
}

static vv_status add(counting *c, vv_label_id id, uint64_t count)
{
    const size_t n = c->set.n;
    uint32_t number;
    vv_status st = n < c->room ? VV_OK : grow(c);
    if (st != VV_OK || (st = vvi_label_set_add(&number, &c->set, id, c->job)) != VV_OK)
        return st;
    c->count[number] = c->set.n > n ? count : c->count[number] + count;
    return c->set.n <= MOST ? VV_OK : vv_fail(VV_E_LIMIT, "the field has more than %d different labels", MOST);
}

/* Neighbours are mostly alike: runs are counted, not samples. */
static vv_status add_row(counting *c, int64_t n)
{
    vv_status st = VV_OK;
    for (int64_t i = 0, end; i < n && st == VV_OK; i = end) {
        for (end = i + 1; end < n && c->row[end] == c->row[i];)
            end++;
        st = add(c, c->row[i], (uint64_t)(end - i));
    }
    return st;
}

static vv_status add_slice(counting *c, const vv_field *field, int64_t k)
{
    const vv_field_info *info = vv_field_get_info(field);
    const vv_box box = {{0, 0, k}, {info->grid.dims[0], info->grid.dims[1], 1}};
    vv_brick brick;
    vv_status st = vv_field_brick(&brick, field, &box, c->job);
    if (st != VV_OK)
        return st;
    for (int64_t j = 0; j < box.n[1] && st == VV_OK; j++) {
        vvi_label_read(c->row, &brick, 0, NULL, j, 0);
        st = add_row(c, box.n[0]);
    }
    vv_brick_release(&brick);
    return st == VV_OK && vv_job_cancelled(c->job) ? vv_fail(VV_E_CANCELLED, "interrupted while counting labels") : st;
}

static vv_status count(counting *c, const vv_field *field)
{
    const int64_t *n = vv_field_get_info(field)->grid.dims;
    vv_status st = VV_OK;
    c->row = vvi_alloc(c->job, (size_t)n[0] * sizeof *c->row, VVI_MEM_SCRATCH);
    if (!c->row)
        return vv_fail_memory((size_t)n[0] * sizeof *c->row);
    for (int64_t k = 0; k < n[2] && st == VV_OK; k++)
        st = add_slice(c, field, k);
    return st;
}

/* By ascending label. */
static vv_status collect(cli_label_count **out, counting *c, bool is_unsigned)
{
    const uint64_t *counts = c->count;
    vvi_label_set sorted = {0};
    vv_label_id *ids = NULL;
    vv_status st = vvi_label_set_join(&sorted, &c->set, c->job);
    if (st == VV_OK)
        st = vvi_label_set_sort(&ids, &sorted, is_unsigned, c->job);
    if (st == VV_OK && !(*out = malloc((sorted.n + 1) * sizeof **out)))
        st = vv_fail_memory(sorted.n * sizeof **out);
    for (size_t i = 0; st == VV_OK && counts && i < sorted.n; i++)
        (*out)[i] = (cli_label_count){ids[i], counts[vvi_label_set_find(&c->set, ids[i])]};
    vvi_free(ids);
    vvi_label_set_finish(&sorted);
    return st;
}

vv_status cli_count_labels(cli_label_count **out, size_t *n_out, const vv_field *field, vv_job *job)
{
    counting c = {.job = job};
    *out = NULL;
    vv_status st = count(&c, field);
    if (st == VV_OK)
        st = collect(out, &c, vvi_label_is_unsigned(vv_field_get_info(field)->type));
    *n_out = st == VV_OK ? c.set.n : 0;
    vvi_label_set_finish(&c.set);
    vvi_free(c.count);
    vvi_free(c.row);
    return st;
}
