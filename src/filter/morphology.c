/* Least and greatest samples of amounts, tile by tile. */
#include "filter/morphology.h"
#include "core/cpu.h"
#include "core/memory.h"
#include "filter/dilation.h"
#include "filter/sample_keys.h"
#include "grid/making.h"

#include <string.h>

#define ALONG 16 /* boxes that reach farther are done axis by axis, so that margins stay small */

typedef struct shared {
    vvi_making making;
    const vv_field_info *info;
    const vvi_element *element;
    int turn; /* -1: keys with their bits turned round, so that the least are the greatest */
    int64_t lo, hi;
    int64_t tile[3]; /* the largest */
    const vvi_dilate_kernels *kernels;
    vv_job *job;
} shared;

typedef struct scratch {
    char *keys;  /* of a tile with its margin */
    char *row;   /* one of them */
    char *least; /* one of what does not count */
    vvi_dilation dilation;
} scratch;

static int64_t key_bytes(const shared *s)
{
    return (int64_t)vv_type_bytes(s->info->type);
}

static vvi_dilate_prepare *prepare_of(const shared *s)
{
    return s->kernels->prepare[key_bytes(s) == 8 ? 3 : key_bytes(s) / 2];
}

static void finish(void *scratch_in, void *user)
{
    scratch *own = scratch_in;
    if (!own)
        return;
    vvi_free(own->keys);
    vvi_free(own->row);
    vvi_free(own->least);
    vvi_dilation_finish(&own->dilation);
    vvi_free(own);
}

static void fill_least(char *row, int64_t n, const shared *s)
{
    memset(row, 0, (size_t)(n * key_bytes(s)));
    if (key_bytes(s) > 1) /* below all that there is: made so */
        prepare_of(s)(row, n, 0, 1, 2);
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const int64_t row = s->tile[0] + 2 * s->element->radius[0];
    const size_t row_bytes = (size_t)(row * key_bytes(s)) + VVI_DILATE_GUARD;
    const size_t bytes = (size_t)(vvi_dilation_keys(s->element, s->tile) * key_bytes(s)) + VVI_DILATE_GUARD;
    scratch *own = vvi_alloc_zeroed(s->job, sizeof *own, VVI_MEM_SCRATCH);
    if (!own)
        return vv_fail_memory(sizeof *own);
    own->keys = vvi_alloc_zeroed(s->job, bytes, VVI_MEM_SCRATCH);
    own->row = vvi_alloc_zeroed(s->job, row_bytes, VVI_MEM_SCRATCH);
    own->least = vvi_alloc_zeroed(s->job, row_bytes, VVI_MEM_SCRATCH);
    vv_status st = own->keys && own->row && own->least ? VV_OK : vv_fail_memory(bytes + 2 * row_bytes);
    if (st == VV_OK)
        st = vvi_dilation_init(&own->dilation, s->element, s->tile, (int)key_bytes(s), s->job);
    if (st != VV_OK) {
        finish(own, user);
        return st;
    }
    fill_least(own->least, row, s);
    *scratch_out = own;
    return VV_OK;
}

/* Samples [x, x + n) of row (y, z), all of which lie in the brick. */
static const char *samples_at(const shared *s, int64_t x, int64_t y, int64_t z, int64_t component)
{
    const vv_brick *b = &s->making.brick;
    return (const char *)b->data + (x - b->box.lo[0]) * b->stride[0] + (y - b->box.lo[1]) * b->stride[1] +
           (z - b->box.lo[2]) * b->stride[2] + component * key_bytes(s);
}

/* One row of a tile with its margin; true if there are samples in it that do not count. */
static bool gather_row(char *keys, const scratch *own, const shared *s, int64_t x, int64_t y, int64_t z, int64_t n,
                       int64_t component)
{
    const vv_brick *b = &s->making.brick;
    const int64_t *lo = b->box.lo, each = key_bytes(s);
    const int64_t end[3] = {lo[0] + b->box.n[0], lo[1] + b->box.n[1], lo[2] + b->box.n[2]};
    const bool outside = y < lo[1] || y >= end[1] || z < lo[2] || z >= end[2];
    const int64_t first = outside ? x + n : x < lo[0] ? lo[0] : x, last = x + n < end[0] ? x + n : end[0];
    memcpy(keys, own->least, (size_t)((first - x) * each));
    if (outside)
        return false;
    char *inside = keys + (first - x) * each;
    vvi_keys_of_samples(inside, samples_at(s, first, y, z, component), b->stride[0], s->info->type, last - first);
    const bool odd =
        (s->turn || vv_type_is_float(s->info->type)) && prepare_of(s)(inside, last - first, s->turn, s->lo, s->hi);
    memcpy(keys + (last - x) * each, own->least, (size_t)((x + n - last) * each));
    return odd;
}

/* NaN stay. */
static void restore_row(char *out, char *row, const shared *s, const vv_box *box, int64_t j, int64_t k, int64_t c)
{
    const int64_t each = key_bytes(s), step = each * s->info->components, in_step = s->making.brick.stride[0];
    const char *in = samples_at(s, box->lo[0], box->lo[1] + j, box->lo[2] + k, c);
    vvi_keys_of_samples(row, in, in_step, s->info->type, box->n[0]);
    for (int64_t i = 0; i < box->n[0]; i++) {
        const int64_t key = vvi_key_at(row, i, s->info->type);
        if (key < s->lo || key > s->hi)
            memcpy(out + i * step, in + i * in_step, (size_t)each);
    }
}

static void write_tile(const scratch *own, const shared *s, const vv_box *box, const vvi_dilated *from, bool odd,
                       int64_t c)
{
    const int64_t each = key_bytes(s), step = each * s->info->components;
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++) {
            char *out = s->making.out + vvi_slabs_row(&s->making.slabs, box, j, k) * step + c * each;
            const char *keys = from->keys + (j * from->stride[0] + k * from->stride[1]) * each;
            if (s->turn) {
                memcpy(own->row, keys, (size_t)(box->n[0] * each));
                prepare_of(s)(own->row, box->n[0], -1, INT64_MIN, INT64_MAX);
                keys = own->row;
            }
            vvi_samples_of_keys(out, step, keys, s->info->type, box->n[0]);
            if (odd)
                restore_row(out, own->row, s, box, j, k, c);
        }
}

static vv_status item(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    scratch *own = scratch_in;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const int64_t *r = s->element->radius;
    const int64_t n[3] = {box.n[0] + 2 * r[0], box.n[1] + 2 * r[1], box.n[2] + 2 * r[2]};
    vv_status st = VV_OK;
    for (int64_t c = 0; c < s->info->components && st == VV_OK; c++) {
        bool odd = false;
        vvi_dilated out;
        for (int64_t k = 0; k < n[2]; k++)
            for (int64_t j = 0; j < n[1]; j++)
                odd |= gather_row(own->keys + (k * n[1] + j) * n[0] * key_bytes(s), own, s, box.lo[0] - r[0],
                                  box.lo[1] - r[1] + j, box.lo[2] - r[2] + k, n[0], c);
        st = vvi_dilation_run(&out, &own->dilation, own->keys, box.n);
        if (st == VV_OK)
            write_tile(own, s, &box, &out, odd, c);
    }
    return st;
}

/* One dilation or erosion, by one element. */
typedef struct pass {
    vvi_element element;
    bool erodes;
} pass;

static vv_status run_pass(vv_field **out, const vv_field *in, const vv_box *box, const pass *p, const char *name,
                          vv_job *job)
{
    const vvi_work work = {.stage = name, .start = start, .item = item, .finish = finish};
    const vv_field_info *info = vv_field_get_info(in);
    const vv_box needed = vvi_window_reach(box, p->element.radius, info->grid.dims);
    shared s = {
        .making = {.in = in}, .info = info, .element = &p->element, .lo = INT64_MIN, .hi = INT64_MAX, .job = job};
    s.turn = p->erodes != (info->value_scale < 0) ? -1 : 0;
    s.kernels = vvi_dilate_kernels_for(vvi_job_cpu(job));
    vvi_keys_bounds(&s.lo, &s.hi, info->type);
    s.making.slabs = vvi_window_wide_tiles(box, p->element.radius);
    for (int a = 0; a < 3; a++)
        s.tile[a] = s.making.slabs.step[a];
    return vvi_making_run(out, &s.making, info, box, &needed, &work, &s, job);
}

/* The passes before the last, over all that the last looks at, and then the last. */
static vv_status run_passes(vv_field **out, const vv_field *in, const vv_box *box, const pass *passes, int n,
                            const char *name, vv_job *job)
{
    const pass *last = &passes[n - 1];
    if (n == 1)
        return run_pass(out, in, box, last, name, job);
    const vv_box middle = vvi_window_reach(box, last->element.radius, vv_field_get_info(in)->grid.dims);
    vv_box there = *box;
    vv_field *part = NULL;
    for (int a = 0; a < 3; a++)
        there.lo[a] -= middle.lo[a];
    vv_status st = run_passes(&part, in, &middle, passes, n - 1, name, job);
    if (st == VV_OK)
        st = run_pass(out, part, &there, last, name, job);
    vv_field_release(part);
    return st;
}

vv_status vvi_morphology_of_values(vv_field **out, const vv_field *in, const vv_box *box, const vvi_morphology *m,
                                   vv_job *job)
{
    const int64_t *r = m->element.radius;
    const bool along = m->element.box && (r[0] > ALONG || r[1] > ALONG || r[2] > ALONG);
    pass passes[6];
    int n = 0;
    for (int step = 0; step < m->n_steps; step++)
        for (int a = 0; a < (along ? 3 : 1); a++) {
            passes[n] = (pass){.element = m->element, .erodes = m->erodes[step]};
            if (along)
                passes[n].element = vvi_element_along(&m->element, a);
            n++;
        }
    *out = NULL;
    return run_passes(out, in, box, passes, n, m->name, job);
}
