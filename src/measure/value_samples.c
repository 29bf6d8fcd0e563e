/* Passes over all samples of a field, or slice by slice over those of an object. */
#include "measure/value_samples.h"

#include "core/job.h"
#include "core/memory.h"
#include "measure/sums.h"

#include <string.h>

typedef struct shared {
    const vvi_value_samples *samples;
    const vvi_pass *pass;
} shared;

typedef struct worker {
    uint64_t *bits; /* of a slice */
    void *scratch;  /* of the pass */
} worker;

static vv_status start(void **scratch_out, void *user, int number)
{
    (void)number;
    const shared *s = user;
    const vvi_object *o = s->samples->object;
    const size_t bits = ((size_t)o->n[1] * o->words + 7) / 8 * 64;
    const size_t bytes = sizeof(worker) + 64 + bits + s->pass->scratch_bytes;
    char *const memory = vvi_alloc_zeroed(s->samples->job, bytes, VVI_MEM_SCRATCH);
    *scratch_out = memory;
    if (!memory)
        return vv_fail_memory(bytes);
    worker *w = *scratch_out;
    w->bits = (uint64_t *)(memory + 64);
    w->scratch = s->pass->scratch_bytes ? memory + 64 + bits : NULL;
    return VV_OK;
}

static void finish(void *scratch, void *user)
{
    const shared *s = user;
    const worker *w = scratch;
    if (w && s->pass->finish)
        s->pass->finish(s->pass->user, w->scratch);
    vvi_free(scratch);
}

static void take_row(const shared *s, worker *w, size_t item, const uint64_t *bits, vvi_interval in,
                     const vv_brick *brick, const char *row)
{
    double run[VVI_PASS_RUN];
    size_t n = 0;
    for (int64_t word = 0; word < (int64_t)s->samples->object->words; word++)
        for (uint64_t left = bits[word] & vvi_interval_bits(in, word); left; left &= left - 1) {
            vvi_samples_to_f64(&run[n++], row + (64 * word + __builtin_ctzll(left)) * brick->stride[0], brick->type, 1);
            if (n == VVI_PASS_RUN) {
                s->pass->take(s->pass->user, w->scratch, item, run, n);
                n = 0;
            }
        }
    if (n)
        s->pass->take(s->pass->user, w->scratch, item, run, n);
}

static vv_status slice_item(void *scratch, void *user, size_t index)
{
    worker *w = scratch;
    const shared *s = user;
    const vvi_value_samples *v = s->samples;
    const vvi_object *o = v->object;
    const vv_box box = {{0, 0, (int64_t)index}, {o->n[0], o->n[1], 1}};
    vv_brick brick;
    vv_status st = vvi_object_slice(w->bits, o, (int64_t)index);
    if (st != VV_OK || (st = vv_field_brick(&brick, v->field, &box, v->job)) != VV_OK)
        return st;
    const char *first = (const char *)brick.data + (size_t)v->component * vv_type_bytes(brick.type);
    for (int64_t j = 0; j < o->n[1]; j++) {
        const vvi_interval in = vvi_region_points(v->region, (vv_vec3){0, 0, 0}, j, (int64_t)index, 0, o->n[0]);
        take_row(s, w, index, w->bits + (size_t)j * o->words, in, &brick, first + j * brick.stride[1]);
    }
    vv_brick_release(&brick);
    return VV_OK;
}

static vv_status run_object(const vvi_value_samples *samples, const vvi_pass *pass)
{
    static const vvi_work work = {.stage = "values", .start = start, .item = slice_item, .finish = finish};
    shared s = {samples, pass};
    return vvi_parallel_for(samples->job, &work, &s, (size_t)samples->object->n[2]);
}

size_t vvi_value_samples_items(const vvi_value_samples *samples)
{
    return samples->object ? (size_t)samples->object->n[2] : vvi_pass_slabs(samples->field).n;
}

vv_status vvi_value_samples_run(const vvi_value_samples *samples, const vvi_pass *passes, int n)
{
    vvi_pass_group group = {.n = n};
    memcpy(group.pass, passes, (size_t)n * sizeof *passes);
    const vvi_pass pass = n > 1 ? vvi_pass_of_group(&group) : passes[0];
    return samples->object ? run_object(samples, &pass)
                           : vvi_pass_run(&pass, samples->field, samples->component, samples->job);
}
