#include "filter/stream.h"
#include "core/memory.h"
#include "filter/operation.h"
#include "grid/store.h"
#include <string.h>

enum {
    THIN = 8,    /* slices: fewer make more work of what steps look at around them than pieces of slices do */
    NARROW = 32, /* samples along x and y of such pieces, at least */
    LEAST = 8    /* the same of a single slice */
};

typedef struct stream {
    const vv_operation *operation;
    vv_object *params;
    vv_field_info info;
    int64_t piece[2]; /* of slices, along x and y, that memory holds with what is around them */
    vv_field *whole;  /* of an operation that knows no boxes, once it has run */
    void *found;      /* by the passes of one that has them */
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

static vv_status make_at_once(vv_field **out, const stream *s, const vv_box *box, vv_job *job)
{
    const vv_field *const *inputs = (const vv_field *const *)s->inputs;
    *out = NULL;
    const vv_passes *passes = s->operation->passes;
    vv_status st = VV_E_INTERNAL; /* make() asks for one of the two */
    if (s->found && passes)
        st = passes->make(out, s->found, inputs, s->n_inputs, s->params, box, job);
    else if (s->operation->run_box)
        st = s->operation->run_box(out, inputs, s->n_inputs, s->params, box, job);
    return vvi_operation_check(out, inputs, s->n_inputs, st);
}

static int64_t smaller(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* A piece of a box, to where it belongs in the samples of the whole of it. */
static vv_status make_piece(char *to, const stream *s, const vv_box *box, const vv_box *piece, vv_job *job)
{
    const int64_t each = (int64_t)vv_type_bytes(s->info.type) * s->info.components;
    const vv_box all = {{0, 0, 0}, {piece->n[0], piece->n[1], piece->n[2]}};
    vv_field *part;
    vv_brick brick;
    vv_status st = make_at_once(&part, s, piece, job);
    if (st != VV_OK || (st = vv_field_brick(&brick, part, &all, job)) != VV_OK) {
        vv_field_release(part);
        return st;
    }
    for (int64_t k = 0; k < piece->n[2]; k++)
        for (int64_t j = 0; j < piece->n[1]; j++) {
            const int64_t row = (k + piece->lo[2] - box->lo[2]) * box->n[1] + j + piece->lo[1] - box->lo[1];
            memcpy(to + (row * box->n[0] + piece->lo[0] - box->lo[0]) * each,
                   (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2], (size_t)(piece->n[0] * each));
        }
    vv_brick_release(&brick);
    vv_field_release(part);
    return st;
}

static vv_status make_pieces(char *to, const stream *s, const vv_box *box, vv_job *job)
{
    vv_status st = VV_OK;
    for (int64_t j = 0; j < box->n[1]; j += s->piece[1])
        for (int64_t i = 0; i < box->n[0] && st == VV_OK; i += s->piece[0]) {
            const vv_box piece = {
                {box->lo[0] + i, box->lo[1] + j, box->lo[2]},
                {smaller(s->piece[0], box->n[0] - i), smaller(s->piece[1], box->n[1] - j), box->n[2]}};
            st = make_piece(to, s, box, &piece, job);
        }
    return st;
}

/* False: they are as small as may be. */
static bool halve_pieces(stream *s, const vv_box *box)
{
    const int a = s->piece[0] < s->piece[1];
    const bool smaller_ones = s->piece[a] > (box->n[2] > 1 ? NARROW : LEAST);
    if (smaller_ones)
        s->piece[a] = (s->piece[a] + 1) / 2;
    return smaller_ones;
}

/* Thin slabs that do not fit with what steps look at around them are made in pieces, each with what is around it. */
static vv_status make_box(vv_field **out, stream *s, const vv_box *box, vv_job *job)
{
    const bool cut = s->piece[0] < box->n[0] || s->piece[1] < box->n[1];
    vv_status st = cut ? VV_E_LIMIT : make_at_once(out, s, box, job);
    vv_field_info info = s->info;
    void *data;
    if (st != VV_E_LIMIT || s->found || (!cut && (box->n[2] > THIN || !halve_pieces(s, box))))
        return st;
    info.grid = vv_grid_crop(&s->info.grid, box);
    if ((st = vv_field_new_empty(out, &data, &info, job)) != VV_OK)
        return st;
    do
        st = make_pieces(data, s, box, job);
    while (st == VV_E_LIMIT && halve_pieces(s, box));
    if (st != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}

static vv_status prepare(void *user, vv_job *job)
{
    const stream *s = user;
    vv_status st = VV_OK;
    for (size_t i = 0; i < s->n_inputs && st == VV_OK; i++)
        if (s->inputs[i])
            st = vvi_field_prepare(s->inputs[i], job);
    return st;
}

static vv_status make(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    stream *s = user;
    const vv_field *const *inputs = (const vv_field *const *)s->inputs;
    *out = NULL;
    vv_status st = prepare(s, job);
    if (st != VV_OK)
        return st;
    if (s->operation->run_box || s->found)
        return make_box(out, s, box, job);
    /* boxes are slabs of whole slices here: see the pool */
    if (!s->whole)
        st = vv_operation_run(&s->whole, s->operation, inputs, s->n_inputs, s->params, job);
    return st == VV_OK ? vvi_field_slices(out, s->whole, box->lo[2], box->n[2], job) : st;
}

/* What the result really is: those that look at the samples may know their scale only then. */
static vv_status find_info(vv_field_info *info, stream *s, vv_job *job)
{
    const vv_box first = {{0, 0, 0}, {1, 1, 1}};
    vv_field *corner = NULL;
    vv_status st = vvi_operation_plan(info, s->operation, (const vv_field *const *)s->inputs, s->n_inputs, s->params);
    const bool looks = s->operation->looks && s->operation->looks(s->params);
    if (st != VV_OK || !looks || !s->operation->run_box || s->operation->passes)
        return st;
    if ((st = make_at_once(&corner, s, &first, job)) != VV_OK)
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
    vv_status st = find_info(&s->info, s, job);
    memcpy(s->piece, s->info.grid.dims, sizeof s->piece);
    if (st == VV_OK && operation->passes && (st = prepare(s, job)) == VV_OK)
        st = operation->passes->find(&s->found, inputs, n_inputs, params, job);
    if (st != VV_OK) {
        drop(s);
        return st;
    }
    const vvi_lazy_source source = {make, drop, s, prepare, operation->in_order};
    return vvi_field_lazy(out, &s->info, &source, pool, job);
}
