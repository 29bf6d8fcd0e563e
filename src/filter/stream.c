#include "filter/stream.h"
#include "core/memory.h"
#include "filter/operation.h"
#include <string.h>

typedef struct stream {
    const vv_operation *operation;
    vv_object *params;
    vv_field *whole; /* of an operation that knows no boxes, once it has run */
    void *found;     /* by the passes of one that has them */
    size_t n_inputs;
    vv_field *inputs[];
} stream;

static void drop(void *user)
{
    stream *s = user;
    if (s->found)
        s->operation->passes->drop(s->found);
    for (size_t i = 0; i < s->n_inputs; i++)
        vv_field_release(s->inputs[i]);
    vv_field_release(s->whole);
    vv_object_release(s->params);
    vvi_free(s);
}

static vv_status make(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    stream *s = user;
    const vv_field *const *inputs = (const vv_field *const *)s->inputs;
    *out = NULL;
    vv_status st = VV_OK;
    if (s->operation->run_box || s->found) {
        st = s->found ? s->operation->passes->make(out, s->found, inputs, s->n_inputs, s->params, box, job)
                      : s->operation->run_box(out, inputs, s->n_inputs, s->params, box, job);
        return vvi_operation_check(out, inputs, s->n_inputs, st);
    }
    /* boxes are slabs of whole slices here: see the pool */
    if (!s->whole)
        st = vv_operation_run(&s->whole, s->operation, inputs, s->n_inputs, s->params, job);
    return st == VV_OK ? vvi_field_slices(out, s->whole, box->lo[2], box->n[2], job) : st;
}

/* What the result really is: some know their scale only once they have looked at the samples. */
static vv_status find_info(vv_field_info *info, stream *s, vv_job *job)
{
    const vv_box first = {{0, 0, 0}, {1, 1, 1}};
    vv_field *corner = NULL;
    vv_status st = vvi_operation_plan(info, s->operation, (const vv_field *const *)s->inputs, s->n_inputs, s->params);
    if (st != VV_OK || !s->operation->run_box)
        return st;
    if ((st = make(&corner, s, &first, job)) != VV_OK)
        return st;
    const vv_grid grid = info->grid;
    *info = *vv_field_get_info(corner);
    info->grid = grid;
    vv_field_release(corner);
    return VV_OK;
}

vv_status vvi_operation_stream(vv_field **out, const vv_operation *operation, const vv_field *const *inputs,
                               size_t n_inputs, const vv_object *params, vvi_lazy_pool *pool, vv_job *job)
{
    *out = NULL;
    const size_t bytes = sizeof(stream) + n_inputs * sizeof(vv_field *);
    stream *s = vvi_alloc_zeroed(job, bytes, VVI_MEM_MODEL);
    if (!s)
        return vv_fail_memory(bytes);
    s->operation = operation;
    s->params = vv_object_retain(params);
    s->n_inputs = n_inputs;
    for (size_t i = 0; i < n_inputs; i++)
        s->inputs[i] = inputs[i] ? vv_field_retain(inputs[i]) : NULL;
    vv_field_info info;
    vv_status st = find_info(&info, s, job);
    if (st == VV_OK && operation->passes)
        st = operation->passes->find(&s->found, inputs, n_inputs, params, job);
    if (st != VV_OK) {
        drop(s);
        return st;
    }
    const vvi_lazy_source source = {make, drop, s};
    return vvi_field_lazy(out, &info, &source, pool, job);
}
