#include "filter/diffuse_wave.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/real_samples.h"
#include "filter/window.h"

#include <string.h>

#define ROWS 16 /* of an item */

/* Level 0 are the samples, level i those after i steps. Once slice s + 1 of a level is there, slice s of the next one
 * can be made: of each level the last two slices are held, and what flows into the later one from below. A level has
 * fewer slices around the box than the one before it. */
typedef struct running {
    const vvi_diffuse_wave *w;
    const vv_field_info *info;
    vv_box area;   /* of level 0 */
    int64_t row_n; /* of a row, with what fills it up to whole steps */
    char *room;
    int64_t level, slice; /* that are being made */
    bool flows;           /* only what flows into the next slice is wanted */
    vv_brick brick;       /* a slice of the samples */
} running;

static size_t row_bytes(const running *r)
{
    return (size_t)r->row_n * vvi_reals_bytes(r->w->wide);
}

static int64_t step_rows(const vvi_diffuse_wave *w, vv_box *area)
{
    const int64_t *dims = vv_field_get_info(w->in)->grid.dims, h = w->iterations;
    const int64_t halo[3] = {dims[0] > 1 ? h : 0, dims[1] > 1 ? h : 0, dims[2] > 1 ? h : 0};
    *area = vvi_window_reach(&w->box, halo, dims);
    return (area->n[0] + VVI_SMOOTHING_STEP - 1) / VVI_SMOOTHING_STEP * VVI_SMOOTHING_STEP;
}

double vvi_diffuse_wave_bytes(const vvi_diffuse_wave *w)
{
    vv_box area;
    const double row = (double)step_rows(w, &area) * (double)vvi_reals_bytes(w->wide);
    return 3 * row * (double)area.n[1] * (double)w->iterations + VVI_SMOOTHING_GUARD * sizeof(double);
}

/* Row j of a level: of one of its two slices, or (part 2) what flows into the later one. */
static char *row_of(const running *r, int64_t level, int64_t part, int64_t j)
{
    return r->room + (size_t)((level * 3 + part) * r->area.n[1] + j) * row_bytes(r);
}

static char *row_at(const running *r, int64_t level, int64_t slice, int64_t j)
{
    return row_of(r, level, slice & 1, j);
}

static void flux(char *out, const running *r, int axis, const char *a, const char *b)
{
    if (a && b)
        r->w->kernels->flux[r->w->wide](out, a, b, r->w->inverse[axis], r->w->rational, r->row_n);
    else
        memset(out, 0, row_bytes(r));
}

/* Fluxes along x, behind a number 0; along y of the last row and this one; along z; and what comes of it. */
typedef struct scratch {
    char *x, *y[2], *z, *row;
} scratch;

static vv_status start(void **scratch_out, void *user, int worker)
{
    const running *r = user;
    const size_t row = row_bytes(r), margin = VVI_SMOOTHING_GUARD * sizeof(double);
    const size_t bytes = sizeof(scratch) + 2 * margin + 5 * row;
    scratch *own = vvi_alloc_zeroed(r->w->job, bytes, VVI_MEM_SCRATCH);
    if (!own)
        return vv_fail_memory(bytes);
    own->x = (char *)(own + 1) + margin;
    own->y[0] = own->x + row;
    own->y[1] = own->y[0] + row;
    own->z = own->y[1] + row;
    own->row = own->z + row;
    *scratch_out = own;
    return VV_OK;
}

static void finish(void *scratch_in, void *user)
{
    vvi_free(scratch_in);
}

static void store(const running *r, const char *row, int64_t j)
{
    const vvi_diffuse_wave *w = r->w;
    const vv_box *box = &w->box;
    const int64_t y = r->area.lo[1] + j - box->lo[1], z = r->slice - box->lo[2];
    if (y < 0 || y >= box->n[1])
        return;
    vvi_samples_of_reals(w->out + ((w->take ? 0 : z) * box->n[1] + y) * box->n[0] * w->step, w->step, w->type,
                         row + (size_t)(box->lo[0] - r->area.lo[0]) * vvi_reals_bytes(w->wide), w->wide, box->n[0]);
}

static void step_row(const running *r, scratch *own, int64_t j)
{
    const vvi_diffuse_wave *w = r->w;
    const size_t each = vvi_reals_bytes(w->wide);
    const int64_t from = r->level - 1;
    const bool above = r->slice + 1 < r->info->grid.dims[2], is_last = r->level == w->iterations;
    const char *row = row_at(r, from, r->slice, j),
               *next = j + 1 < r->area.n[1] ? row_at(r, from, r->slice, j + 1) : NULL;
    char *below = row_of(r, from, 2, j), *y = own->y[j & 1], *y_before = own->y[!(j & 1)];
    char *out = is_last ? own->row : row_at(r, r->level, r->slice, j);
    flux(own->z, r, 2, row, above ? row_at(r, from, r->slice + 1, j) : NULL);
    if (!r->flows) {
        flux(own->x, r, 0, row, row + each);
        memset(own->x + (size_t)(r->area.n[0] - 1) * each, 0, each);
        flux(y, r, 1, row, next);
        const void *const all[6] = {own->x - each, own->x, y_before, y, below, own->z};
        w->kernels->spread[w->wide](out, row, all, w->rate, r->row_n);
    }
    if (is_last && !r->flows)
        store(r, out, j);
    memcpy(below, own->z, row_bytes(r));
}

static vv_status step_item(void *scratch_in, void *user, size_t index)
{
    const running *r = user;
    scratch *own = scratch_in;
    const int64_t first = (int64_t)index * ROWS, end = first + ROWS < r->area.n[1] ? first + ROWS : r->area.n[1];
    flux(own->y[!(first & 1)], r, 1, first > 0 ? row_at(r, r->level - 1, r->slice, first - 1) : NULL,
         row_at(r, r->level - 1, r->slice, first));
    for (int64_t j = first; j < end; j++)
        step_row(r, own, j);
    return vvi_job_poll(r->w->job);
}

static vv_status load_item(void *scratch_in, void *user, size_t index)
{
    const running *r = user;
    const vv_brick *b = &r->brick;
    const int64_t first = (int64_t)index * ROWS, end = first + ROWS < r->area.n[1] ? first + ROWS : r->area.n[1];
    for (int64_t j = first; j < end; j++) {
        char *row = row_at(r, 0, r->slice, j);
        vvi_reals_of_samples(row, r->w->wide,
                             (const char *)b->data + j * b->stride[1] +
                                 r->w->component * (int64_t)vv_type_bytes(b->type),
                             b->stride[0], b->type, b->box.n[0]);
    }
    return vvi_job_poll(r->w->job);
}

static vv_status load(running *r, size_t items)
{
    static const vvi_work work = {.stage = "diffuse", .item = load_item};
    vv_box box = r->area;
    box.lo[2] = r->slice;
    box.n[2] = 1;
    vv_status st = vv_field_brick(&r->brick, r->w->in, &box, r->w->job);
    if (st == VV_OK)
        st = vvi_parallel_for(r->w->job, &work, r, items);
    vv_brick_release(&r->brick);
    return st;
}

/* Slice t of the samples, and what can be made once it is there: a slice of each level. */
static vv_status advance(running *r, int64_t t)
{
    static const vvi_work work = {.stage = "diffuse", .start = start, .item = step_item, .finish = finish};
    const vvi_diffuse_wave *w = r->w;
    const size_t items = (size_t)((r->area.n[1] - 1) / ROWS + 1);
    const int64_t n = r->info->grid.dims[2];
    vv_status st = VV_OK;
    r->slice = t;
    if (t < r->area.lo[2] + r->area.n[2])
        st = load(r, items);
    for (r->level = 1; r->level <= w->iterations && st == VV_OK; r->level++) {
        const int64_t around = n > 1 ? w->iterations - r->level : 0, s = t - (n > 1 ? r->level : 0);
        const int64_t lo = w->box.lo[2] - around, end = w->box.lo[2] + w->box.n[2] + around;
        const int64_t first = lo > 0 ? lo : 0;
        r->slice = s;
        r->flows = s == first - 1;
        if (s >= 0 && s >= first - 1 && s < (end < n ? end : n))
            st = vvi_parallel_for(w->job, &work, r, items);
        if (st == VV_OK && w->take && r->level == w->iterations && s >= w->box.lo[2] && s < w->box.lo[2] + w->box.n[2])
            st = w->take(w->user, s);
    }
    return st;
}

vv_status vvi_diffuse_wave_run(const vvi_diffuse_wave *w)
{
    running r = {.w = w, .info = vv_field_get_info(w->in)};
    const size_t bytes = (size_t)vvi_diffuse_wave_bytes(w);
    r.row_n = step_rows(w, &r.area);
    r.room = vvi_alloc_zeroed(w->job, bytes, VVI_MEM_SCRATCH);
    vv_status st = r.room ? VV_OK : vv_fail_memory(bytes);
    const int64_t first = r.area.lo[2], end = w->box.lo[2] + w->box.n[2] + w->iterations;
    for (int64_t t = first; t < end && st == VV_OK; t++) {
        vvi_job_hush(w->job, 1);
        st = advance(&r, t);
        vvi_job_hush(w->job, -1);
        if (st == VV_OK)
            st = vvi_job_progress(w->job, "diffuse", w->before + (uint64_t)(t + 1 - first),
                                  w->all ? w->all : (uint64_t)(end - first));
    }
    vvi_free(r.room);
    return st;
}
