/* One pass over a component of a field, as doubles. */
#include "grid/value_pass.h"

#include "core/job.h"
#include "core/memory.h"

#define ITEM_SAMPLES ((int64_t)1 << 19)
#define BRICK_SAMPLES ((int64_t)1 << 16) /* that are asked for at once: gathered, where they lie in several slabs */

typedef struct shared {
    const vvi_pass *pass;
    const vv_field *field;
    int component;
    vvi_slabs slabs;
    vv_job *job;
} shared;

vvi_slabs vvi_pass_slabs(const vv_field *field)
{
    const vv_box all = vv_field_box(field);
    return vvi_slabs_of(&all, ITEM_SAMPLES);
}

/* Samples that lie apart (several components) are taken one by one. */
static void take_row(const shared *s, void *scratch, size_t index, const vv_brick *brick, const char *row)
{
    double run[VVI_PASS_RUN];
    const size_t bytes = vv_type_bytes(brick->type);
    const bool dense = brick->stride[0] == (int64_t)bytes;
    const int64_t n = brick->box.n[0];
    for (int64_t at = 0; at < n; at += VVI_PASS_RUN) {
        const int64_t now = n - at < VVI_PASS_RUN ? n - at : VVI_PASS_RUN;
        const char *p = row + at * brick->stride[0];
        if (dense)
            vvi_samples_to_f64(run, p, brick->type, (size_t)now);
        else
            for (int64_t i = 0; i < now; i++)
                vvi_samples_to_f64(run + i, p + i * brick->stride[0], brick->type, 1);
        s->pass->take(s->pass->user, scratch, index, run, (size_t)now);
    }
}

static vv_status take_box(const shared *s, void *scratch, size_t index, const vv_box *box)
{
    vv_brick brick;
    const vv_status st = vv_field_brick(&brick, s->field, box, s->job);
    if (st != VV_OK)
        return st;
    const char *first = (const char *)brick.data + (size_t)s->component * vv_type_bytes(brick.type);
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            take_row(s, scratch, index, &brick, first + j * brick.stride[1] + k * brick.stride[2]);
    vv_brick_release(&brick);
    return VV_OK;
}

static vv_status pass_item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->slabs, index);
    const vvi_slabs parts = vvi_slabs_of(&box, BRICK_SAMPLES);
    vv_status st = VV_OK;
    for (size_t i = 0; i < parts.n && st == VV_OK; i++) {
        const vv_box part = vvi_slabs_item(&parts, i);
        st = take_box(s, scratch, index, &part);
    }
    return st;
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    (void)worker;
    const shared *s = user;
    *scratch_out = NULL;
    if (s->pass->scratch_bytes == 0)
        return VV_OK;
    *scratch_out = vvi_alloc_zeroed(s->job, s->pass->scratch_bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(s->pass->scratch_bytes);
}

static void finish(void *scratch, void *user)
{
    const shared *s = user;
    if (s->pass->finish)
        s->pass->finish(s->pass->user, scratch);
    vvi_free(scratch);
}

vv_status vvi_pass_run(const vvi_pass *pass, const vv_field *field, int component, vv_job *job)
{
    const vvi_work work = {.stage = pass->stage, .start = start, .item = pass_item, .finish = finish};
    shared s = {.pass = pass, .field = field, .component = component, .slabs = vvi_pass_slabs(field), .job = job};
    return vvi_parallel_for(job, &work, &s, s.slabs.n);
}

static size_t room_of(const vvi_pass *pass)
{
    return (pass->scratch_bytes + 63) / 64 * 64;
}

static void take_group(void *user, void *scratch, size_t item, const double *values, size_t n)
{
    const vvi_pass_group *g = user;
    char *own = scratch;
    for (int p = 0; p < g->n; own = own ? own + room_of(&g->pass[p]) : NULL, p++)
        g->pass[p].take(g->pass[p].user, own, item, values, n);
}

static void finish_group(void *user, void *scratch)
{
    const vvi_pass_group *g = user;
    char *own = scratch;
    for (int p = 0; p < g->n; own = own ? own + room_of(&g->pass[p]) : NULL, p++)
        if (g->pass[p].finish)
            g->pass[p].finish(g->pass[p].user, own);
}

vvi_pass vvi_pass_of_group(const vvi_pass_group *group)
{
    size_t bytes = 0;
    for (int p = 0; p < group->n; p++)
        bytes += room_of(&group->pass[p]);
    return (vvi_pass){.stage = group->pass[0].stage,
                      .scratch_bytes = bytes,
                      .take = take_group,
                      .finish = finish_group,
                      .user = (void *)(uintptr_t)group};
}
