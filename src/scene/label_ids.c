/* Labels come in runs, so that each is looked for once a run. */
#include "scene/label_ids.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "grid/label_set.h"
#include <math.h>

typedef struct finding {
    const vv_field *field;
    vv_brick brick;
    int component;
    vvi_label_set set;
    void *to; /* numbers: u16, or f32 */
    bool wide;
    vv_job *job;
} finding;

static vv_status add(finding *f, vv_label_id id)
{
    const vv_status st = vvi_label_set_add(NULL, &f->set, id, f->job);
    if (st != VV_OK || f->set.n <= VVI_LABEL_IDS_MOST)
        return st;
    return vv_fail(VV_E_LIMIT,
                   "more than %d different labels, the most that can be told apart; if these are not labels, "
                   "segmentation.kind=transfer shows them as amounts",
                   VVI_LABEL_IDS_MOST);
}

static void read_row(vv_label_id *out, const finding *f, int64_t j, int64_t k)
{
    vvi_label_read(out, &f->brick, f->component, vv_field_get_info(f->field), j, k);
}

static vv_status find_all(finding *f)
{
    const int64_t *n = f->brick.box.n;
    vv_status st = VV_OK;
    vv_label_id *row = vvi_alloc(f->job, (size_t)n[0] * sizeof *row, VVI_MEM_SCRATCH);
    if (!row)
        return vv_fail_memory((size_t)n[0] * sizeof *row);
    for (int64_t k = 0; k < n[2] && st == VV_OK; k++) {
        for (int64_t j = 0; j < n[1] && st == VV_OK; j++) {
            read_row(row, f, j, k);
            for (int64_t i = 0; i < n[0] && st == VV_OK; i++)
                if (i == 0 || row[i] != row[i - 1])
                    st = add(f, row[i]);
        }
        st = st == VV_OK ? vvi_job_poll(f->job) : st;
    }
    vvi_free(row);
    return st;
}

/* Numbers --------------------------------------------------------------------------------------------------------- */

static vv_status start(void **scratch, void *user, int worker)
{
    const finding *f = user;
    const size_t bytes = (size_t)f->brick.box.n[0] * sizeof(vv_label_id);
    (void)worker;
    *scratch = vvi_alloc(f->job, bytes, VVI_MEM_SCRATCH);
    return *scratch ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

/* Item: one slice. */
static vv_status number_slice(void *scratch, void *user, size_t k)
{
    const finding *f = user;
    const int64_t *n = f->brick.box.n;
    vv_label_id *row = scratch;
    for (int64_t j = 0; j < n[1]; j++) {
        const size_t first = (k * (size_t)n[1] + (size_t)j) * (size_t)n[0];
        read_row(row, f, j, (int64_t)k);
        uint32_t number = 0;
        for (int64_t i = 0; i < n[0]; i++) {
            if (i == 0 || row[i] != row[i - 1])
                number = vvi_label_set_find(&f->set, row[i]);
            if (f->wide)
                ((float *)f->to)[first + (size_t)i] = (float)number;
            else
                ((uint16_t *)f->to)[first + (size_t)i] = (uint16_t)number;
        }
    }
    return vvi_job_poll(f->job);
}

static vv_status number_all(vvi_label_ids *out, finding *f)
{
    static const vvi_work work = {.stage = "labels", .start = start, .item = number_slice, .finish = finish};
    vv_field_info info = *vv_field_get_info(f->field);
    f->wide = out->n > 65536;
    info.type = f->wide ? VV_TYPE_F32 : VV_TYPE_U16;
    info.components = 1;
    info.meaning = VV_MEANING_SCALAR;
    info.value_scale = 1;
    info.value_offset = 0;
    const vv_status st = vv_field_new_empty(&out->numbers, &f->to, &info, f->job);
    return st == VV_OK ? vvi_parallel_for(f->job, &work, f, (size_t)info.grid.dims[2]) : st;
}

/* The whole ------------------------------------------------------------------------------------------------------- */

static void drop(void *value)
{
    vvi_label_ids *ids = value;
    vv_field_release(ids->numbers);
    vvi_free(ids->id);
    vvi_free(ids);
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    finding *f = user;
    const vv_box all = vv_field_box(f->field);
    vvi_label_ids *ids = vvi_alloc_zeroed(job, sizeof *ids, VVI_MEM_DERIVED);
    if (!ids)
        return vv_fail_memory(sizeof *ids);
    ids->is_unsigned = vvi_label_is_unsigned(vv_field_get_info(f->field)->type);
    vv_status st = vv_field_brick(&f->brick, f->field, &all, job);
    if (st == VV_OK)
        st = find_all(f);
    if (st == VV_OK)
        st = vvi_label_set_sort(&ids->id, &f->set, ids->is_unsigned, job);
    ids->n = f->set.n;
    ids->statistics = (vv_statistics){.count = 1, .max = (double)ids->n - 1};
    if (st == VV_OK)
        st = number_all(ids, f);
    vv_brick_release(&f->brick);
    vvi_label_set_finish(&f->set);
    if (st != VV_OK) {
        drop(ids);
        return st;
    }
    *bytes_out =
        sizeof *ids + ids->n * sizeof *ids->id + (uint64_t)(all.n[0] * all.n[1] * all.n[2]) * (f->wide ? 4 : 2);
    *value_out = ids;
    return VV_OK;
}

bool vvi_label_ids_needed(const vv_field_info *info, const vv_statistics *s)
{
    const bool long_type = info->type == VV_TYPE_I64 || info->type == VV_TYPE_U64;
    return s->max - s->min >= VVI_LABEL_IDS_MOST || (long_type && fmax(fabs(s->min), fabs(s->max)) >= 0x1p53);
}

vv_status vvi_label_ids_get(vvi_cached **out, const vv_field *field, int component, vv_job *job)
{
    finding f = {.field = field, .component = component, .job = job};
    const vvi_cache_key key = {"label ids", vv_field_identity(field), (uint64_t)component};
    return vvi_cache_get(out, &key, make, drop, &f, job);
}

void vvi_label_ids_actor(vv_actor *out, const vv_actor *actor, const vvi_label_ids *ids)
{
    *out = *actor;
    out->field = vv_field_retain(ids->numbers);
    out->component = 0;
    out->statistics = (vv_statistics *)(uintptr_t)&ids->statistics;
    out->classes.ids = ids->id;
    out->classes.n_ids = ids->n;
    out->classes.ids_unsigned = ids->is_unsigned;
}
