/* Median: each sample becomes the middle one of those in the window around it. */
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/median_kernel.h"
#include "filter/median_rank.h"
#include "filter/sample_keys.h"
#include "filter/window.h"
#include "grid/making.h"
#include "registry.h"

#include <string.h>

#define WINDOW_MOST 32767 /* samples: what a tile can have in it, and a histogram can count */

static const vv_property properties[] = {VVI_WINDOW_PROPERTIES, {0}};

static const vv_class median_class = {
    .name = "median",
    .doc = "parameters of median",
    .size = sizeof(vvi_window_params),
    .properties = properties,
    .check = vvi_window_check,
};

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    int64_t radius[3];
    *out = inputs[0];
    if (inputs[0].meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "median: labels are names, not amounts, and none is in the middle of others");
    return vvi_window_radius(radius, &inputs[0], params, "median", WINDOW_MOST);
}

typedef struct shared {
    vvi_making making;
    const vv_field_info *info;
    const vvi_median_kernels *kernels;
    int64_t radius[3];
    bool small; /* at most three samples along each axis */
    vv_job *job;
} shared;

typedef struct tile {
    vv_box box;   /* of the result */
    int64_t n[3]; /* samples with the margin; beyond the volume's border they are the border's */
    int64_t component;
} tile;

typedef struct scratch {
    void *keys; /* of a tile with its margin */
    void *row;  /* of keys */
    vvi_median_ranks *ranks;
} scratch;

static void finish(void *scratch_in, void *user)
{
    scratch *s = scratch_in;
    if (!s)
        return;
    vvi_free(s->keys);
    vvi_free(s->row);
    vvi_median_ranks_free(s->ranks);
    vvi_free(s);
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t each = vv_type_bytes(s->info->type), bytes = (VVI_MEDIAN_TILE_MOST + VVI_MEDIAN_GUARD) * each;
    scratch *own = vvi_alloc_zeroed(s->job, sizeof *own, VVI_MEM_SCRATCH);
    if (!own)
        return vv_fail_memory(sizeof *own);
    own->keys = vvi_alloc_zeroed(s->job, bytes, VVI_MEM_SCRATCH);
    own->row = vvi_alloc_zeroed(s->job, bytes, VVI_MEM_SCRATCH);
    if (!own->keys || !own->row) {
        finish(own, user);
        return vv_fail_memory(bytes);
    }
    *scratch_out = own;
    return VV_OK;
}

static int64_t clamp(int64_t v, int64_t lo, int64_t n)
{
    return v < lo ? lo : v >= lo + n ? lo + n - 1 : v;
}

/* Row (j, k) of a tile with its margin. */
static void gather_row(char *keys, const shared *s, const tile *t, int64_t j, int64_t k)
{
    const vv_brick *b = &s->making.brick;
    const vv_type type = s->info->type;
    const int64_t *lo = b->box.lo, *n = b->box.n;
    const int64_t y = clamp(t->box.lo[1] - s->radius[1] + j, lo[1], n[1]) - lo[1];
    const int64_t z = clamp(t->box.lo[2] - s->radius[2] + k, lo[2], n[2]) - lo[2];
    const int64_t each = (int64_t)vv_type_bytes(type), x = t->box.lo[0] - s->radius[0];
    const int64_t first = clamp(x, lo[0], n[0]), last = clamp(x + t->n[0] - 1, lo[0], n[0]);
    const char *row = (const char *)b->data + y * b->stride[1] + z * b->stride[2] + t->component * each;
    char *inside = keys + (first - x) * each;
    vvi_keys_of_samples(inside, row + (first - lo[0]) * b->stride[0], b->stride[0], type, last - first + 1);
    for (int64_t i = x; i < first; i++)
        memcpy(keys + (i - x) * each, inside, (size_t)each);
    for (int64_t i = last + 1; i < x + t->n[0]; i++)
        memcpy(keys + (i - x) * each, inside + (last - first) * each, (size_t)each);
}

static bool any_missing(const void *keys, int64_t n, vv_type type)
{
    int64_t lo, hi;
    if (!vvi_keys_bounds(&lo, &hi, type))
        return false;
    for (int64_t i = 0; i < n; i++) {
        const int64_t key = vvi_key_at(keys, i, type);
        if (key < lo || key > hi)
            return true;
    }
    return false;
}

static void write_by_rows(char *out, scratch *own, const shared *s, const tile *t, int64_t j, int64_t k)
{
    const int64_t each = (int64_t)vv_type_bytes(s->info->type);
    vvi_median_row *row = s->kernels->of_bytes[each == 8 ? 3 : each / 2];
    const void *rows[9];
    int n = 0;
    for (int64_t z = k; z <= k + 2 * s->radius[2]; z++)
        for (int64_t y = j; y <= j + 2 * s->radius[1]; y++)
            rows[n++] = (const char *)own->keys + (z * t->n[1] + y) * t->n[0] * each;
    row(own->row, rows, n, (int)(2 * s->radius[0] + 1), t->box.n[0]);
    vvi_samples_of_keys(out, each * s->info->components, own->row, s->info->type, t->box.n[0]);
}

static void write_by_ranks(char *out, scratch *own, const shared *s, const tile *t, int64_t j, int64_t k)
{
    const int64_t stride[2] = {t->n[0], t->n[0] * t->n[1]};
    const int64_t size[3] = {2 * s->radius[0] + 1, 2 * s->radius[1] + 1, 2 * s->radius[2] + 1};
    vvi_median_ranks_row(out, (int64_t)vv_type_bytes(s->info->type) * s->info->components, own->ranks,
                         k * stride[1] + j * stride[0], stride, size, t->box.n[0]);
}

static vv_status write_tile(scratch *own, const shared *s, const tile *t)
{
    const vv_type type = s->info->type;
    const size_t each = vv_type_bytes(type);
    const int64_t all = t->n[0] * t->n[1] * t->n[2];
    for (int64_t k = 0; k < t->n[2]; k++)
        for (int64_t j = 0; j < t->n[1]; j++)
            gather_row((char *)own->keys + (size_t)((k * t->n[1] + j) * t->n[0]) * each, s, t, j, k);
    const bool by_rows = s->small && !any_missing(own->keys, all, type);
    vv_status st = VV_OK;
    if (!by_rows && !own->ranks)
        st = vvi_median_ranks_new(&own->ranks, type, s->job);
    if (st == VV_OK && !by_rows)
        vvi_median_ranks_of(own->ranks, own->keys, all);
    for (int64_t k = 0; k < t->box.n[2] && st == VV_OK; k++)
        for (int64_t j = 0; j < t->box.n[1] && st == VV_OK; j++) {
            const int64_t at = vvi_slabs_row(&s->making.slabs, &t->box, j, k) * s->info->components + t->component;
            (by_rows ? write_by_rows : write_by_ranks)(s->making.out + (size_t)at * each, own, s, t, j, k);
            st = vvi_job_poll(s->job);
        }
    return st;
}

static vv_status item(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    tile t = {.box = vvi_slabs_item(&s->making.slabs, index)};
    vv_status st = VV_OK;
    for (int a = 0; a < 3; a++)
        t.n[a] = t.box.n[a] + 2 * s->radius[a];
    for (; t.component < s->info->components && st == VV_OK; t.component++)
        st = write_tile(scratch_in, s, &t);
    return st;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "median", .start = start, .item = item, .finish = finish};
    vv_field_info info;
    shared s = {.making = {.in = inputs[0]}, .info = &info, .job = job};
    *out = NULL;
    vv_status st = plan(&info, vv_field_get_info(inputs[0]), n_inputs, params);
    if (st == VV_OK)
        st = vvi_window_radius(s.radius, &info, params, "median", WINDOW_MOST);
    if (st != VV_OK)
        return st;
    s.kernels = vvi_median_kernels_for(vvi_job_cpu(job));
    s.small = s.radius[0] <= 1 && s.radius[1] <= 1 && s.radius[2] <= 1;
    s.making.slabs = vvi_window_tiles(box, s.radius, VVI_MEDIAN_TILE_MOST);
    const vv_box needed = vvi_window_reach(box, s.radius, info.grid.dims);
    return vvi_making_run(out, &s.making, &info, box, &needed, &work, &s, job);
}

const vv_operation vvi_operation_median = {
    .api = VV_OPERATION_API,
    .name = "median",
    .component = "filter",
    .group = "smoothing",
    .doc = "the median of a box around each sample: noise goes, edges stay; beyond the border are the values of "
           "the border; each channel separately",
    .example = "volvis median head.nrrd -o clean.nrrd --radius 1.5mm",
    .params = &median_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
};
