#include "filter/few_labels.h"
#include "core/findings.h"
#include "core/memory.h"
#include "grid/label_id.h"
#include "grid/label_sense.h"

#include <string.h>

enum { FEW = 6, VALUES = 256 };
#define EQUAL_SHARE 0.8

/* Rows of an even grid. */
typedef struct look {
    bool there[VALUES];
    int n; /* of them, without 0 */
    uint64_t pairs, equal;
    bool more; /* than few, or others */
} look;

static void look_at_row(look *l, const vv_label_id *row, int64_t n)
{
    for (int64_t i = 0; i < n && !l->more; i++) {
        const vv_label_id v = row[i];
        if (v == 0)
            continue;
        if (v < 0 || v >= VALUES) {
            l->more = true;
            return;
        }
        l->n += !l->there[v];
        l->there[v] = true;
        l->more = l->n > FEW;
        if (i > 0 && row[i - 1] != 0) {
            l->pairs++;
            l->equal += row[i - 1] == v;
        }
    }
}

static vv_status look_at_slice(look *l, vv_label_id *row, const vv_field *field, int64_t k, vv_job *job)
{
    vv_box box = vv_field_box(field);
    vv_brick brick;
    box.lo[2] = k;
    box.n[2] = 1;
    const vv_status st = vv_field_brick(&brick, field, &box, job);
    if (st != VV_OK)
        return st;
    for (int64_t j = 0; j < box.n[1] && !l->more; j += vvi_label_sense_step(box.n[1])) {
        vvi_label_read(row, &brick, 0, NULL, j, 0);
        look_at_row(l, row, box.n[0]);
    }
    vv_brick_release(&brick);
    return vvi_job_poll(job);
}

static vv_status are_few(bool *out, const vv_field *field, vv_job *job)
{
    const int64_t *dims = vv_field_get_info(field)->grid.dims;
    vv_label_id *row = vvi_alloc(job, (size_t)dims[0] * sizeof *row, VVI_MEM_SCRATCH);
    look l = {.n = 0};
    vv_status st = row ? VV_OK : vv_fail_memory((size_t)dims[0] * sizeof *row);
    for (int64_t k = 0; k < dims[2] && st == VV_OK && !l.more; k += vvi_label_sense_step(dims[2]))
        st = look_at_slice(&l, row, field, k, job);
    vvi_free(row);
    *out = !l.more && l.n >= 2 && (double)l.equal >= EQUAL_SHARE * (double)l.pairs;
    return st;
}

static bool is_told(const vv_job *job, const char *note)
{
    vv_finding found;
    for (size_t i = 0; vv_job_finding(&found, job, i); i++)
        if (found.note && strcmp(found.note, note) == 0)
            return true;
    return false;
}

vv_status vvi_advise_labels(const vv_field *field, vv_job *job)
{
    static const char note[] = "these samples are taken as amounts; if they are labels, 'volvis convert FILE -o "
                               "labels.seg.nrrd' makes a file that says so";
    const vv_field_info *info = vv_field_get_info(field);
    size_t n = 0;
    bool few = false;
    if (info->meaning != VV_MEANING_SCALAR || info->components > 1 || info->value_scale != 1 ||
        info->value_offset != 0 || !vvi_label_sense_may(info) || is_told(job, note))
        return VV_OK;
    vv_status st = vvi_label_sense(&n, field, 0, job);
    if (st == VV_OK && n == 0)
        st = are_few(&few, field, job);
    if (st == VV_OK && (n || few))
        vvi_find_note(job, "%s", note);
    return st == VV_E_LIMIT || st == VV_E_MEMORY ? VV_OK : st;
}
