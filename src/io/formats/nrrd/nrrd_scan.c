/* What labels there are in samples, and where: looked up before they are written as segments. */
#include "io/formats/nrrd/nrrd_scan.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/label_set.h"
#include <string.h>

typedef struct scanning {
    vvi_nrrd_scan *scan;
    vvi_label_set set;
    vv_label_id *row;
    vv_job *job;
} scanning;

/* 0 is no label. */
static vv_status add_value(scanning *c, vv_label_id value)
{
    const vv_status st = c->scan->many ? VV_OK : vvi_label_set_add(NULL, &c->set, value, c->job);
    c->scan->many |= c->set.n > VVI_NRRD_NAMES_MOST;
    return st;
}

static void widen(int64_t box[6], int64_t first, int64_t last, int64_t j, int64_t k)
{
    const int64_t lo[3] = {first, j, k}, hi[3] = {last, j, k};
    for (int a = 0; a < 3; a++) {
        box[2 * a] = lo[a] < box[2 * a] ? lo[a] : box[2 * a];
        box[2 * a + 1] = hi[a] > box[2 * a + 1] ? hi[a] : box[2 * a + 1];
    }
}

static vv_status look_at_row(scanning *c, int64_t n, int64_t j, int64_t k)
{
    vvi_nrrd_scan *s = c->scan;
    vv_status st = VV_OK;
    for (int64_t i = 0, end = 0; i < n && st == VV_OK; i = end) {
        const vv_label_id value = c->row[i];
        for (end = i + 1; end < n && c->row[end] == value;)
            end++;
        if (value == 0)
            continue;
        st = add_value(c, value);
        widen(s->box, i, end - 1, j, k);
        s->n_labelled += (uint64_t)(end - i);
        s->n_alone += end == i + 1;
    }
    return st;
}

static vv_status look_at_slice(scanning *c, const vv_field *field, int64_t k)
{
    const int64_t *dims = vv_field_get_info(field)->grid.dims;
    const vv_box slice = {{0, 0, k}, {dims[0], dims[1], 1}};
    vv_brick brick;
    vv_status st = vvi_job_poll(c->job);
    if (st != VV_OK || (st = vv_field_brick(&brick, field, &slice, c->job)) != VV_OK)
        return st;
    for (int64_t j = 0; j < dims[1] && st == VV_OK; j++) {
        vvi_label_read(c->row, &brick, 0, NULL, j, 0);
        st = look_at_row(c, dims[0], j, k);
    }
    vv_brick_release(&brick);
    return st;
}

static vv_status look(scanning *c, const vv_field *field)
{
    const vv_field_info *info = vv_field_get_info(field);
    const size_t bytes = (size_t)info->grid.dims[0] * sizeof *c->row;
    vv_status st = VV_OK;
    c->row = vvi_alloc(c->job, bytes, VVI_MEM_SCRATCH);
    if (!c->row)
        return vv_fail_memory(bytes);
    for (int64_t k = 0; k < info->grid.dims[2] && st == VV_OK; k++)
        st = look_at_slice(c, field, k);
    if (st == VV_OK)
        st = vvi_label_set_sort(&c->scan->value, &c->set, vvi_label_is_unsigned(info->type), c->job);
    return st;
}

vv_status vvi_nrrd_scan_labels(vvi_nrrd_scan *out, const vv_field *field, vv_job *job)
{
    scanning c = {.scan = out, .job = job};
    *out = (vvi_nrrd_scan){.box = {INT64_MAX, 0, INT64_MAX, 0, INT64_MAX, 0}};
    const vv_status st = look(&c, field);
    out->n_values = c.set.n;
    if (out->n_labelled == 0)
        memcpy(out->box, (const int64_t[6]){0, -1, 0, -1, 0, -1}, sizeof out->box);
    vvi_label_set_finish(&c.set);
    vvi_free(c.row);
    return st;
}

void vvi_nrrd_scan_finish(vvi_nrrd_scan *scan)
{
    vvi_free(scan->value);
    *scan = (vvi_nrrd_scan){0};
}
