/* A table of all labels: where they are, how much there is, and the values of another volume there. */
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "grid/label_set.h"
#include "grid/same_grid.h"
#include "grid/slabs.h"
#include "grid/statistics.h"
#include "measure/configurations.h"
#include "measure/label_areas.h"
#include "measure/label_medians.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define MOST ((size_t)1 << 22)
#define ITEM_SAMPLES ((int64_t)1 << 21)
#define RUN 1024

typedef struct entry {
    vv_label_id label;
    uint64_t count;
    double index[3];
    vv_bounds bounds;
    vvi_moments moments;
} entry;

typedef struct table {
    vvi_label_set set;
    entry *entry; /* by number */
    size_t room;
} table;

typedef struct shared {
    const vv_field *labels, *values;
    int component;
    vv_affine to_world;
    vvi_region region;
    vvi_slabs slabs;
    vv_job *job;
    table *part; /* of each item */
    const table *all;
    vvi_label_medians medians; /* by numbers of `all` */
    bool again;                /* after the first look: for the medians */
    bool no_areas;
    _Atomic uint64_t *pattern; /* VVI_CONFIGURATIONS of each label; NULL: no memory for them */
} shared;

static void free_table(table *t)
{
    vvi_label_set_finish(&t->set);
    vvi_free(t->entry);
}

static vv_status grow(table *t, vv_job *job)
{
    const size_t room = t->room ? 2 * t->room : 32;
    entry *grown = vvi_realloc(job, t->entry, room * sizeof *grown, VVI_MEM_SCRATCH);
    if (!grown)
        return vv_fail_memory(room * sizeof *grown);
    t->entry = grown;
    t->room = room;
    return VV_OK;
}

static vv_status find(entry **out, table *t, vv_label_id label, vv_job *job)
{
    const size_t n = t->set.n;
    uint32_t number;
    vv_status st = n < t->room ? VV_OK : grow(t, job);
    if (st != VV_OK || (st = vvi_label_set_add(&number, &t->set, label, job)) != VV_OK)
        return st;
    if (t->set.n > MOST)
        return vv_fail(VV_E_LIMIT, "the field has more than %zu different labels", MOST);
    if (t->set.n > n) {
        t->entry[number] = (entry){.label = label, .bounds = vvi_bounds_none()};
        vvi_moments_init(&t->entry[number].moments);
    }
    *out = &t->entry[number];
    return VV_OK;
}

static void add_values(entry *e, const char *at, int64_t stride, vv_type type, int64_t n)
{
    double run[RUN];
    while (n > 0) {
        const int64_t now = n < RUN ? n : RUN;
        for (int64_t i = 0; i < now; i++)
            vvi_samples_to_f64(&run[i], at + i * stride, type, 1);
        vvi_moments_add(&e->moments, run, (size_t)now);
        at += now * stride;
        n -= now;
    }
}

/* Samples i .. i + n - 1 of a row, all of one label. */
static void add_run(entry *e, const shared *s, int64_t i, int64_t n, int64_t j, int64_t k)
{
    const double y = (double)j, z = (double)k, first = (double)i, last = (double)(i + n - 1);
    e->count += (uint64_t)n;
    e->index[0] += (first + last) / 2 * (double)n;
    e->index[1] += y * (double)n;
    e->index[2] += z * (double)n;
    vvi_bounds_add(&e->bounds, vv_affine_point(s->to_world, vvi_vec(first, y, z)));
    vvi_bounds_add(&e->bounds, vv_affine_point(s->to_world, vvi_vec(last, y, z)));
}

/* A row of labels, and of values where there are some, run by run. */
typedef struct rows {
    const char *label, *value;
    int64_t label_stride, value_stride;
    vv_type label_type, value_type;
    int64_t begin, n; /* of the row lie in the region: from begin to n - 1 */
} rows;

static vv_label_id label_at(const rows *r, int64_t i)
{
    return vvi_label_of(r->label + i * r->label_stride, r->label_type);
}

static int64_t end_of_run(const rows *r, int64_t i)
{
    const size_t bytes = vv_type_bytes(r->label_type);
    const char *first = r->label + i * r->label_stride;
    int64_t end = i + 1;
    while (end < r->n && memcmp(first, r->label + end * r->label_stride, bytes) == 0)
        end++;
    return end;
}

static vv_status take_row(table *t, const shared *s, const rows *r, const vv_box *box, int64_t j, int64_t k)
{
    vv_status st = VV_OK;
    for (int64_t i = r->begin, end; i < r->n && st == VV_OK; i = end) {
        const vv_label_id label = label_at(r, i);
        entry *e;
        end = end_of_run(r, i);
        if (label == 0 || (st = find(&e, t, label, s->job)) != VV_OK)
            continue;
        add_run(e, s, box->lo[0] + i, end - i, box->lo[1] + j, box->lo[2] + k);
        if (r->value)
            add_values(e, r->value + i * r->value_stride, r->value_stride, r->value_type, end - i);
    }
    return st;
}

/* Second look: where among the values of its label each one is. */
static void bin_row(shared *s, const rows *r)
{
    for (int64_t i = r->begin, end; i < r->n; i = end) {
        const vv_label_id label = label_at(r, i);
        end = end_of_run(r, i);
        if (label == 0)
            continue;
        const size_t slot = vvi_label_set_find(&s->all->set, label);
        vvi_label_medians_take(&s->medians, slot, r->value + i * r->value_stride, r->value_stride, end - i);
    }
}

static vv_status open_rows(rows *r, vv_brick brick[2], const shared *s, const vv_box *box)
{
    vv_status st = vv_field_brick(&brick[0], s->labels, box, s->job);
    *r = (rows){0};
    if (st != VV_OK)
        return st;
    r->label_stride = brick[0].stride[0];
    r->label_type = brick[0].type;
    if (!s->values)
        return VV_OK;
    if ((st = vv_field_brick(&brick[1], s->values, box, s->job)) != VV_OK) {
        vv_brick_release(&brick[0]);
        return st;
    }
    r->value_stride = brick[1].stride[0];
    r->value_type = brick[1].type;
    return VV_OK;
}

static vv_status item(void *scratch, void *user, size_t index)
{
    (void)scratch;
    shared *s = user;
    const vv_box box = vvi_slabs_item(&s->slabs, index);
    vv_brick brick[2] = {{0}, {0}};
    rows r;
    vv_status st = open_rows(&r, brick, s, &box);
    if (st != VV_OK)
        return st;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1] && st == VV_OK; j++) {
            const vvi_interval in = vvi_region_points(&s->region, vvi_vec(0, 0, 0), box.lo[1] + j, box.lo[2] + k,
                                                      box.lo[0], box.lo[0] + box.n[0]);
            r.begin = in.lo - box.lo[0];
            r.n = in.end - box.lo[0];
            r.label = (const char *)brick[0].data + j * brick[0].stride[1] + k * brick[0].stride[2];
            if (s->values)
                r.value = (const char *)brick[1].data + (size_t)s->component * vv_type_bytes(r.value_type) +
                          j * brick[1].stride[1] + k * brick[1].stride[2];
            if (s->again)
                bin_row(s, &r);
            else
                st = take_row(&s->part[index], s, &r, &box, j, k);
        }
    vv_brick_release(&brick[0]);
    if (s->values)
        vv_brick_release(&brick[1]);
    return st;
}

static vv_status join(table *all, const table *part, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < part->set.n && st == VV_OK; i++) {
        const entry *from = &part->entry[i];
        entry *to;
        if ((st = find(&to, all, from->label, job)) != VV_OK)
            break;
        to->count += from->count;
        for (int a = 0; a < 3; a++)
            to->index[a] += from->index[a];
        vvi_bounds_add(&to->bounds, from->bounds.lo);
        vvi_bounds_add(&to->bounds, from->bounds.hi);
        vvi_moments_join(&to->moments, &from->moments);
    }
    return st;
}

static vv_status first_look(table *all, shared *s)
{
    static const vvi_work work = {.stage = "labels", .item = item};
    vv_status st;
    s->part = vvi_alloc_zeroed(s->job, s->slabs.n * sizeof *s->part, VVI_MEM_SCRATCH);
    if (!s->part)
        return vv_fail_memory(s->slabs.n * sizeof *s->part);
    st = vvi_parallel_for(s->job, &work, s, s->slabs.n);
    for (size_t i = 0; i < s->slabs.n; i++) {
        if (st == VV_OK)
            st = join(all, &s->part[i], s->job);
        free_table(&s->part[i]);
    }
    vvi_free(s->part);
    return st;
}

static vv_label_measures make(const shared *s, size_t slot)
{
    const vv_field_info *info = s->values ? vv_field_get_info(s->values) : vv_field_get_info(s->labels);
    const entry *e = &s->all->entry[slot];
    const double n = (double)e->count;
    vv_label_measures out = {.label = e->label,
                             .count = e->count,
                             .n_values = e->moments.count,
                             .bounds = e->bounds,
                             .area = NAN,
                             .area_error = NAN,
                             .volume_error = NAN,
                             .min = NAN,
                             .max = NAN,
                             .mean = NAN,
                             .deviation = NAN,
                             .median = NAN,
                             .within = NAN};
    const double voxel = fabs(vv_affine_determinant(s->to_world));
    out.volume = n * voxel;
    if (s->pattern) {
        uint64_t pattern[VVI_CONFIGURATIONS];
        vv_measured counted = {.size = sizeof counted};
        for (size_t p = 0; p < VVI_CONFIGURATIONS; p++)
            pattern[p] = atomic_load_explicit(&s->pattern[slot * VVI_CONFIGURATIONS + p], memory_order_relaxed);
        vvi_count_areas(&counted, pattern, &s->to_world, voxel);
        out.area = counted.area;
        out.area_error = counted.area_error;
        out.volume_error = vvi_count_spread(pattern) * voxel;
    }
    out.centroid = vv_affine_point(s->to_world, vvi_vec(e->index[0] / n, e->index[1] / n, e->index[2] / n));
    for (int a = 0; a < 3; a++) {
        const vv_vec3 half =
            vvi_vec(fabs(s->to_world.axis[a].x) / 2, fabs(s->to_world.axis[a].y) / 2, fabs(s->to_world.axis[a].z) / 2);
        out.bounds.lo = vvi_sub(out.bounds.lo, half);
        out.bounds.hi = vvi_add(out.bounds.hi, half);
    }
    if (!e->moments.count)
        return out;
    const double scale = info->value_scale, offset = info->value_offset;
    out.min = (scale > 0 ? e->moments.min : e->moments.max) * scale + offset;
    out.max = (scale > 0 ? e->moments.max : e->moments.min) * scale + offset;
    out.mean = (double)e->moments.mean * scale + offset;
    out.deviation = (double)sqrtl(e->moments.m2 / (long double)e->moments.count) * fabs(scale);
    out.within = 0;
    out.median = vvi_label_medians_get(&s->medians, slot) * scale + offset;
    return out;
}

static int by_label(const void *a, const void *b)
{
    return vvi_label_compare(((const vv_label_measures *)a)->label, ((const vv_label_measures *)b)->label, false);
}

static int by_unsigned_label(const void *a, const void *b)
{
    return vvi_label_compare(((const vv_label_measures *)a)->label, ((const vv_label_measures *)b)->label, true);
}

static vv_status second_look(shared *s)
{
    static const vvi_work work = {.stage = "medians", .item = item};
    const table *t = s->all;
    vv_status st = VV_OK;
    if (!s->values || !t->set.n)
        return VV_OK;
    st = vvi_label_medians_begin(&s->medians, t->set.n, vv_field_get_info(s->values)->type, s->job);
    for (size_t i = 0; i < t->set.n && st == VV_OK; i++) {
        const vvi_moments *m = &t->entry[i].moments;
        vvi_label_medians_set(&s->medians, i, m->count, m->min, m->max);
    }
    s->again = true;
    while (st == VV_OK && vvi_label_medians_next(&s->medians))
        st = vvi_parallel_for(s->job, &work, s, s->slabs.n);
    return st;
}

static vv_status collect(vv_label_measures **out, size_t *n_out, shared *s)
{
    const table *t = s->all;
    vv_status st = second_look(s);
    if (st == VV_OK && !s->no_areas)
        st = vvi_label_patterns(&s->pattern, s->labels, &s->region, &t->set, s->job);
    if (st == VV_OK) {
        *out = vvi_alloc(s->job, (t->set.n + 1) * sizeof **out, VVI_MEM_DERIVED);
        if (!*out)
            return vv_fail_memory((t->set.n + 1) * sizeof **out);
        for (size_t i = 0; i < t->set.n; i++)
            (*out)[(*n_out)++] = make(s, i);
        const bool is_unsigned = vvi_label_is_unsigned(vv_field_get_info(s->labels)->type);
        qsort(*out, *n_out, sizeof **out, is_unsigned ? by_unsigned_label : by_label);
    }
    return st;
}

static vv_status check(const vv_field *labels, const vv_field *values, int component)
{
    const vv_field_info *a = vv_field_get_info(labels), *b = values ? vv_field_get_info(values) : NULL;
    if (b && vvi_grid_alike(&a->grid, &b->grid, "values") != VV_OK)
        return VV_E_ARGUMENT;
    if (b && (component < 0 || component >= b->components))
        return vv_fail(VV_E_ARGUMENT, "channel %d does not exist; the values have %d, counted from 0", component,
                       b->components);
    return VV_OK;
}

void vv_label_measures_free(vv_label_measures *measures)
{
    vvi_free(measures);
}

void vv_label_options_init(vv_label_options *options, size_t size)
{
    const vv_label_options all = {.size = size};
    memcpy(options, &all, size < sizeof all ? size : sizeof all);
}

/* Slices that the box has no part in are not read. */
static vv_box slices_of(const vv_field *labels, const vv_box *box)
{
    vv_box out = vv_field_box(labels);
    if (box->n[2]) {
        out.lo[2] = box->lo[2];
        out.n[2] = box->n[2];
    }
    return out;
}

vv_status vv_measure_labels(vv_label_measures **out, size_t *n_out, const vv_field *labels,
                            const vv_label_options *options, vv_job *job)
{
    vv_label_options none;
    table all = {0};
    vv_label_options_init(&none, sizeof none);
    const vv_label_options *o = options ? options : &none;
    const vv_grid *grid = &vv_field_get_info(labels)->grid;
    shared s = {.labels = labels, .values = o->values, .component = o->component, .job = job, .all = &all};
    vv_status st = check(labels, o->values, o->component);
    *out = NULL;
    *n_out = 0;
    if (st != VV_OK || (st = vvi_region_init(&s.region, grid, &o->box, 0.5, o->planes, o->n_planes)) != VV_OK)
        return st;
    const vv_box box = slices_of(labels, &o->box);
    s.to_world = grid->index_to_world;
    s.no_areas = o->size >= sizeof *o && o->no_areas;
    s.slabs = vvi_slabs_of(&box, ITEM_SAMPLES);
    if ((st = first_look(&all, &s)) == VV_OK)
        st = collect(out, n_out, &s);
    if (st == VV_OK && (st = vv_field_health(labels)) == VV_OK && o->values)
        st = vv_field_health(o->values);
    if (st != VV_OK) {
        vv_label_measures_free(*out);
        *out = NULL;
    }
    vvi_label_medians_end(&s.medians);
    vvi_free(s.pattern);
    free_table(&all);
    return st;
}
