/* Components that memory does not hold. In a pass over the input each slab's parts get provisional numbers, in the
 * order of their first samples, and those that touch across the face between two slabs are united: the first number of
 * a part is that of its first sample, so that parts come in the same order as at once. Slabs of the result are made
 * from the runs of the input's, which are found again: provisional numbers are the same each time. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/scratch_file.h"
#include "segment/components.h"
#include "segment/label_result.h"

#include <math.h>
#include <string.h>

#define SHARE 8   /* of the memory, for the samples and bits of a slab */
#define SLICES 16 /* of a slab, at most */
#define ROOM_LEAST 1024
#define WRITING ((uint64_t)640 << 10) /* bytes, about */

/* By provisional number, of all there are. Larger than a share of the memory it lies in a temporary file. */
typedef struct table {
    vvi_scratch_file *file; /* NULL: in memory */
    void *data;             /* all three */
    uint64_t *size;         /* while they are found */
    uint32_t *label;        /* one that it is united with, itself at last; then the label */
    uint32_t *rank;
    uint32_t room;
} table;

typedef struct slab {
    int64_t lo, n;  /* slices */
    uint32_t first; /* provisional number of its first part */
} slab;

typedef struct passes {
    const vv_field *in;
    const vv_field_info *info;
    const vvi_components_params *params;
    slab *slabs;
    size_t n_slabs;
    table table;
    uint32_t n; /* provisional numbers */
    void *kept; /* for slabs of the result and for writing them, while numbers are found */
    vv_job *job;
} passes;

/* The runs of the last slice so far; its parts have numbers from `first` on. */
typedef struct face {
    vvi_runs runs;
    uint32_t first;
} face;

/* Union-find over provisional numbers ------------------------------------------------------------------------------ */

static uint32_t root_of(uint32_t *label, uint32_t part)
{
    while (label[part] != part)
        part = label[part] = label[label[part]];
    return part;
}

static void unite(uint32_t *label, uint32_t a, uint32_t b)
{
    a = root_of(label, a);
    b = root_of(label, b);
    if (a < b)
        label[b] = a;
    else
        label[a] = b;
}

/* Two rows on both sides of the face. */
typedef struct row_pair {
    const passes *p;
    const face *before;
    const vvi_runs *now;
    uint32_t first; /* number of the first part of `now` */
    int32_t reach;
} row_pair;

static void unite_runs(const row_pair *r, uint32_t a, uint32_t b)
{
    const vvi_runs *was = &r->before->runs, *now = r->now;
    if (was->lo[a] < now->end[b] + r->reach && now->lo[b] < was->end[a] + r->reach &&
        (!was->key || was->key[a] == now->key[b]))
        unite(r->p->table.label, r->before->first + was->part[a], r->first + now->part[b]);
}

/* Row j of the last slice before with row i of the first one behind it. */
static void unite_rows(const row_pair *r, int64_t j, int64_t i)
{
    const vvi_runs *was = &r->before->runs, *now = r->now;
    const uint32_t a_end = was->first[j + 1], b_end = now->first[i + 1];
    uint32_t a = was->first[j], b = now->first[i];
    while (a < a_end && b < b_end) {
        unite_runs(r, a, b);
        if (was->end[a] == now->end[b] && a + 1 < a_end) /* that may begin where both end */
            unite_runs(r, a + 1, b);
        if (was->end[a] < now->end[b])
            a++;
        else
            b++;
    }
}

static vv_status unite_face(const passes *p, const face *before, const vvi_runs *now, uint32_t first)
{
    const int axes = p->params->connectivity + 1;
    const row_pair same = {p, before, now, first, axes > 1}, next = {p, before, now, first, axes > 2};
    const int64_t ny = now->n[1];
    for (int64_t i = 0; i < ny; i++) {
        unite_rows(&same, i, i);
        if (axes > 1 && i > 0)
            unite_rows(&next, i - 1, i);
        if (axes > 1 && i + 1 < ny)
            unite_rows(&next, i + 1, i);
    }
    return vvi_job_poll(p->job);
}

/* The first pass --------------------------------------------------------------------------------------------------- */

static void table_free(table *t)
{
    if (t->file)
        vvi_scratch_file_free(t->file);
    else
        vvi_free(t->data);
    *t = (table){0};
}

static vv_status table_new(table *out, uint32_t room, vv_job *job)
{
    const size_t bytes = room * (sizeof *out->size + sizeof *out->label + sizeof *out->rank);
    vv_status st = VV_OK;
    *out = (table){.room = room};
    if (!job || bytes <= vv_runtime_memory_limit(vv_job_runtime(job)) / SHARE)
        out->data = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!out->data && (st = vvi_scratch_file_new(&out->file, bytes, "components", job)) == VV_OK)
        st = vvi_scratch_file_map(&out->data, out->file);
    if (st != VV_OK) {
        table_free(out);
        return st;
    }
    out->size = out->data;
    out->label = (uint32_t *)(out->size + room);
    out->rank = out->label + room;
    return VV_OK;
}

static vv_status grow(passes *p, uint32_t more)
{
    table wider;
    if (more >= UINT32_MAX / 2 - p->n)
        return vv_fail(VV_E_LIMIT, "components: there are more than 2e9 parts of slabs; crop the volume");
    if (p->n + more <= p->table.room)
        return VV_OK;
    const vv_status st = table_new(&wider, p->n + more + p->table.room / 2 + ROOM_LEAST, p->job);
    if (st != VV_OK)
        return st;
    if (p->n > 0) {
        memcpy(wider.label, p->table.label, p->n * sizeof *wider.label);
        memcpy(wider.size, p->table.size, p->n * sizeof *wider.size);
    }
    table_free(&p->table);
    p->table = wider;
    return VV_OK;
}

static vv_status number(passes *p, const vvi_runs *runs)
{
    const vv_status st = grow(p, runs->n_parts);
    if (st != VV_OK)
        return st;
    for (uint32_t i = p->n; i < p->n + runs->n_parts; i++) {
        p->table.label[i] = i;
        p->table.size[i] = 0;
    }
    for (size_t i = 0; i < runs->n_runs; i++)
        p->table.size[p->n + runs->part[i]] += (uint64_t)(runs->end[i] - runs->lo[i]);
    return VV_OK;
}

static vv_status runs_of(vvi_runs *out, const passes *p, int64_t lo, int64_t n)
{
    const int64_t *d = p->info->grid.dims;
    const vv_box box = {{0, 0, lo}, {d[0], d[1], n}};
    vv_brick brick;
    vv_status st = vv_field_brick(&brick, p->in, &box, p->job);
    if (st != VV_OK)
        return st;
    st = vvi_components_runs(out, &brick, p->info, p->params, p->job);
    vv_brick_release(&brick);
    return st;
}

static int64_t slices_at_once(const passes *p)
{
    const int64_t *d = p->info->grid.dims;
    const double limit = p->job ? (double)vv_runtime_memory_limit(vv_job_runtime(p->job)) : INFINITY;
    const double slice = (double)(d[0] * d[1]) * ((double)vv_type_bytes(p->info->type) + 0.25);
    const double n = fmin(floor(limit / SHARE / slice), SLICES);
    return n < 1 ? 1 : (int64_t)n;
}

static void *copy_of(const void *from, size_t bytes, vv_job *job)
{
    void *to = vvi_alloc(job, bytes + 1, VVI_MEM_SCRATCH);
    if (to && bytes > 0)
        memcpy(to, from, bytes);
    return to;
}

/* The last slice alone. */
static vv_status last_of(vvi_runs *out, const vvi_runs *runs, vv_job *job)
{
    const size_t rows = (size_t)runs->n[1], row = runs->n_rows - rows;
    const uint32_t from = runs->first[row], n = runs->first[runs->n_rows] - from;
    *out = (vvi_runs){.n = {runs->n[0], runs->n[1], 1}, .n_rows = rows, .n_runs = n, .n_parts = runs->n_parts};
    out->first = copy_of(runs->first + row, (rows + 1) * sizeof *out->first, job);
    out->lo = copy_of(runs->lo + from, n * sizeof *out->lo, job);
    out->end = copy_of(runs->end + from, n * sizeof *out->end, job);
    out->part = copy_of(runs->part + from, n * sizeof *out->part, job);
    out->key = runs->key ? copy_of(runs->key + from, n * sizeof *out->key, job) : NULL;
    const bool all = out->first && out->lo && out->end && out->part && (out->key || !runs->key);
    for (size_t i = 0; i <= rows && all; i++)
        out->first[i] -= from;
    if (!all)
        vvi_runs_finish(out);
    return all ? VV_OK : vv_fail_memory((n + rows) * sizeof *out->part);
}

/* The runs of a slab and, for the face to the next one, of its last slice. */
static vv_status find_runs(vvi_runs *runs, vvi_runs *last, const passes *p, const slab *s)
{
    vv_status st = runs_of(runs, p, s->lo, s->n);
    if (st == VV_OK && (st = last_of(last, runs, p->job)) != VV_OK)
        vvi_runs_finish(runs);
    return st;
}

static vv_status fail_slice(int64_t k)
{
    return vv_fail_in(VV_E_LIMIT, "components: slice %lld is in more pieces than the memory limit holds", (long long)k);
}

/* The next slab, thinner where it is in more pieces than memory holds. */
static vv_status take_slab(passes *p, face *before, int64_t lo, int64_t *step)
{
    const int64_t left = p->info->grid.dims[2] - lo;
    vvi_runs runs, last;
    slab *s = &p->slabs[p->n_slabs];
    vv_status st;
    for (;; *step /= 2) {
        *s = (slab){lo, left < *step ? left : *step, p->n};
        st = find_runs(&runs, &last, p, s);
        if (st != VV_E_LIMIT || *step < 2)
            break;
    }
    if (st != VV_OK)
        return st == VV_E_LIMIT ? fail_slice(lo) : st;
    if ((st = number(p, &runs)) == VV_OK && lo > 0)
        st = unite_face(p, before, &runs, p->n);
    p->n += runs.n_parts;
    p->n_slabs++;
    vvi_runs_finish(&runs);
    vvi_runs_finish(&before->runs);
    *before = (face){last, s->first};
    return st;
}

static vv_status take_slabs(passes *p)
{
    const int64_t n = p->info->grid.dims[2];
    int64_t step = slices_at_once(p);
    face before = {.first = 0};
    vv_status st = VV_OK;
    for (int64_t k = 0; k < n && st == VV_OK;) {
        vvi_job_hush(p->job, 1);
        st = take_slab(p, &before, k, &step);
        vvi_job_hush(p->job, -1);
        k = st == VV_OK ? p->slabs[p->n_slabs - 1].lo + p->slabs[p->n_slabs - 1].n : k;
        if (st == VV_OK)
            st = vvi_job_progress(p->job, "components", (uint64_t)k, (uint64_t)n);
    }
    vvi_runs_finish(&before.runs);
    return st;
}

/* Numbers become labels -------------------------------------------------------------------------------------------- */

/* Parts instead of provisional numbers, in the same order: roots come before all that lead to them. */
static uint32_t number_parts(uint32_t *label, uint64_t *sizes, uint32_t n_all)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < n_all; i++) {
        const bool is_root = label[i] == i;
        const uint64_t size = sizes[i];
        const uint32_t part = is_root ? n++ : label[label[i]];
        label[i] = part;
        sizes[part] = is_root ? size : sizes[part] + size;
    }
    return n;
}

static vv_status find_labels(passes *p)
{
    table *t = &p->table;
    vvi_part_sizes sizes = {.rank = t->rank};
    double least;
    uint32_t most;
    vv_status st = vvi_components_kept(&least, &most, p->info, p->params);
    if (st == VV_OK)
        st = vvi_part_sizes_rank(&sizes, t->size, number_parts(t->label, t->size, p->n), least, most, p->job);
    for (uint32_t i = 0; i < p->n && st == VV_OK; i++)
        t->label[i] = t->rank[t->label[i]];
    if (st == VV_OK)
        vvi_components_tell(&sizes, p->job);
    return st;
}

/* The row's functions ---------------------------------------------------------------------------------------------- */

static void drop(void *state)
{
    passes *p = state;
    if (!p)
        return;
    vvi_free(p->slabs);
    vvi_free(p->kept);
    table_free(&p->table);
    vvi_free(p);
}

/* So that slabs will fit beside results. */
static size_t kept_bytes(const vv_runtime *runtime)
{
    const uint64_t limit = vv_runtime_memory_limit(runtime), most = limit / 2, some = limit / 8 + WRITING;
    return (size_t)(some < most ? some : most);
}

static vv_status find(void **state_out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                      vv_job *job)
{
    passes *p = vvi_alloc_zeroed(job, sizeof *p, VVI_MEM_SCRATCH);
    *state_out = NULL;
    if (!p)
        return vv_fail_memory(sizeof *p);
    p->in = inputs[0];
    p->info = vv_field_get_info(inputs[0]);
    p->params = (const vvi_components_params *)params;
    p->job = job;
    const size_t bytes = (size_t)p->info->grid.dims[2] * sizeof *p->slabs;
    p->slabs = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    p->kept = job ? vvi_alloc(job, kept_bytes(vv_job_runtime(job)), VVI_MEM_SCRATCH) : NULL;
    vv_status st = p->slabs ? take_slabs(p) : vv_fail_memory(bytes);
    vvi_free(p->kept);
    p->kept = NULL;
    if (st == VV_OK && (st = find_labels(p)) == VV_OK)
        st = vv_field_health(p->in);
    if (st == VV_OK)
        *state_out = p;
    else
        drop(p);
    return st;
}

/* Slices [lo, lo + n) of a slab. */
static vv_status paint(uint32_t *out, const passes *p, const slab *s, int64_t lo, int64_t n)
{
    vvi_runs runs;
    vv_status st = runs_of(&runs, p, s->lo, s->n);
    if (st != VV_OK)
        return st;
    vvi_runs part = runs;
    part.n[2] = n;
    part.n_rows = (size_t)(n * part.n[1]);
    part.first += (lo - s->lo) * part.n[1];
    st = vvi_runs_paint(out, VV_TYPE_U32, &part, p->table.label + s->first, p->job);
    vvi_runs_finish(&runs);
    return st;
}

static vv_status make(vv_field **out, void *state, const vv_field *const *inputs, size_t n_inputs,
                      const vv_object *params, const vv_box *box, vv_job *job)
{
    const passes *p = state;
    const int64_t slice = box->n[0] * box->n[1], end = box->lo[2] + box->n[2];
    vv_field_info info = vvi_label_result(p->info, VV_TYPE_U32);
    void *data;
    info.grid = vv_grid_crop(&info.grid, box);
    vv_status st = vv_field_new_empty(out, &data, &info, job);
    for (size_t i = 0; i < p->n_slabs && st == VV_OK; i++) {
        const slab *s = &p->slabs[i];
        const int64_t first = s->lo > box->lo[2] ? s->lo : box->lo[2], last = s->lo + s->n < end ? s->lo + s->n : end;
        if (first < last)
            st = paint((uint32_t *)data + (first - box->lo[2]) * slice, p, s, first, last - first);
    }
    return st;
}

const vv_passes vvi_components_passes = {.find = find, .make = make, .drop = drop};
