/* Project: one slice of many along an axis, or of each slab of them. */
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/amounts.h"
#include "filter/project_kernel.h"
#include "grid/field.h"
#include "grid/slabs.h"
#include "registry.h"

#include <math.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 16)
#define PIECE_SAMPLES ((int64_t)1 << 12) /* of a slice: their states stay in the caches */
#define TOGETHER 8                       /* rows that are read side by side: what hardware foresees */
#define CHUNK_BYTES ((int64_t)1 << 26)   /* of the input that are held at once, where they are read bit by bit */

typedef struct project_params {
    vv_object object;
    int axis, method;
    char *slab;
    bool sliding;
} project_params;

enum { MAXIMUM, MINIMUM, MEAN, SUM, DEVIATION, MEDIAN };

static const char *const axis_names[] = {"x", "y", "z", NULL};
static const char *const method_names[] = {"maximum", "minimum", "mean", "sum", "deviation", "median", NULL};
static const char *const method_aliases[] = {"max",  "maximum", "min",       "minimum", "average",
                                             "mean", "std",     "deviation", NULL};

static const vv_property properties[] = {
    {VV_PROP(project_params, axis), .kind = VV_KIND_ENUM, .names = axis_names, .def = 2,
     .doc = "axis of the grid that it looks along"},
    {VV_PROP(project_params, method), .kind = VV_KIND_ENUM, .names = method_names, .aliases = method_aliases,
     .doc = "what becomes of the samples one behind the other; NaN do not count; deviation: the standard deviation, of "
            "all "
            "of them (divided by n)"},
    {VV_PROP(project_params, slab), .kind = VV_KIND_STRING, .automatic = "all",
     .doc = "how many of them go together, or a length: 10, 5mm; there is one slice for each slab, the last may be "
            "thinner"},
    {VV_PROP(project_params, sliding), .kind = VV_KIND_BOOL,
     .doc = "a slab around every slice (of an even number of slices one more lies before it), cut off at the border"},
    {0},
};

static const vv_class project_class = {
    .name = "project",
    .doc = "parameters of project",
    .size = sizeof(project_params),
    .properties = properties,
};

/* Slice k of the result is made of input slices lo(k) to lo(k) + thick, where there are such. */
typedef struct slabs {
    int axis, method;
    int64_t n_in, n_out, thick;
    bool sliding;
} slabs;

static void slab_of(int64_t *lo, int64_t *n, const slabs *s, int64_t k)
{
    const int64_t first = s->sliding ? k - s->thick / 2 : k * s->thick, end = first + s->thick;
    *lo = first < 0 ? 0 : first;
    *n = (end < s->n_in ? end : s->n_in) - *lo;
}

static vv_status find_slabs(slabs *out, const vv_field_info *info, const vv_object *params)
{
    const project_params *p = (const project_params *)params;
    vv_status st = VV_OK;
    *out = (slabs){.axis = p->axis, .method = p->method, .sliding = p->sliding, .n_in = info->grid.dims[p->axis]};
    out->thick = out->n_in;
    if (p->sliding && !(p->slab && *p->slab))
        return vv_fail(VV_E_ARGUMENT, "project: `sliding` needs a slab: --slab 10, or a length");
    if (p->slab && *p->slab)
        st = vvi_parse_samples(&out->thick, p->slab, &info->grid, p->axis, "project: slab");
    if (st == VV_OK && out->thick < 1)
        return vv_fail(VV_E_ARGUMENT, "project: slab '%s' is less than one slice", p->slab);
    if (out->thick > out->n_in && !out->sliding)
        out->thick = out->n_in;
    out->n_out = out->sliding ? out->n_in : (out->n_in + out->thick - 1) / (out->thick ? out->thick : 1);
    if (st == VV_OK && info->meaning == VV_MEANING_LABEL && p->method != MAXIMUM && p->method != MINIMUM)
        return vv_fail(VV_E_UNSUPPORTED,
                       "project: labels are names, not amounts: they have a maximum and a minimum alone");
    return st;
}

static bool keeps_type(int method)
{
    return method == MAXIMUM || method == MINIMUM || method == MEDIAN;
}

static vv_field_info projected(const vv_field_info *info, const slabs *s)
{
    vv_field_info out = *info;
    vv_affine *m = &out.grid.index_to_world;
    out.grid.dims[s->axis] = s->n_out;
    if (!s->sliding) { /* in the middle of its slab, and as thick */
        const vv_vec3 step = m->axis[s->axis];
        const double half = 0.5 * (double)(s->thick - 1), thick = (double)s->thick;
        m->origin = (vv_vec3){m->origin.x + half * step.x, m->origin.y + half * step.y, m->origin.z + half * step.z};
        m->axis[s->axis] = (vv_vec3){step.x * thick, step.y * thick, step.z * thick};
    }
    if (keeps_type(s->method))
        return out;
    const bool wide = info->type != VV_TYPE_F32 && vv_type_bytes(info->type) > 2;
    out.type = wide || s->method == SUM ? VV_TYPE_F64 : VV_TYPE_F32;
    out.value_scale = 1;
    out.value_offset = 0;
    return out;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    slabs s;
    const vv_status st = find_slabs(&s, &inputs[0], params);
    if (st == VV_OK)
        *out = projected(&inputs[0], &s);
    return st;
}

/* What samples one behind the other have come to so far, an array each: the extreme of them, in their own type in a, or
 * sums (vvi_project_sums). */
typedef struct state {
    double *a, *b, *count;
} state;

/* A part of the result, and the input slices from `from` to `to` along the axis, which are added to it now. */
typedef struct shared {
    slabs slabs;
    const vv_field_info *in, *info;
    vv_box part;    /* of the result */
    vv_brick brick; /* of the input */
    int64_t from, to;
    bool first, last; /* whether it begins with these slices, and ends */
    vvi_slabs items;
    char *out; /* of the box that is asked for */
    vv_box box;
    double *kept; /* states of the part, between passes; NULL: there is but one */
    const vvi_project_loops *loops;
    char nothing[8]; /* what extremes begin with */
    vv_job *job;
} shared;

static bool is_extreme(const shared *s)
{
    return s->slabs.method == MAXIMUM || s->slabs.method == MINIMUM;
}

/* The largest value is the smallest stored number where the scale is negative. */
static bool seeks_largest(const shared *s)
{
    return (s->slabs.method == MAXIMUM) == (s->in->value_scale > 0);
}

static void begin(const state *st, const shared *s, size_t n)
{
    if (is_extreme(s)) {
        vvi_fill_numbers((char *)st->a, s->nothing, vv_type_bytes(s->in->type), (int64_t)n);
        return;
    }
    for (size_t i = 0; i < n; i++)
        st->a[i] = st->b[i] = st->count[i] = 0;
}

/* Rows that are `step` bytes apart. */
static void add_rows(const state *st, const char *row, int64_t rows, int64_t step, const shared *s, size_t n)
{
    const vvi_project_sums sums = {st->a, st->b, st->count};
    const bool added = !is_extreme(s) && s->slabs.method != DEVIATION;
    const int64_t most = added ? TOGETHER : 1;
    for (int64_t r = 0; r < rows; r += most, row += most * step)
        if (added)
            s->loops->sum(&sums, row, rows - r < most ? rows - r : most, step, (int64_t)n);
        else if (is_extreme(s))
            s->loops->extreme[seeks_largest(s)](st->a, row, (int64_t)n);
        else
            s->loops->square(&sums, row, (int64_t)n);
}

/* What is written: values, or stored numbers where the type is kept. */
static void end_row(double *a, const state *st, const shared *s, size_t n)
{
    const double scale = s->in->value_scale, offset = s->in->value_offset;
    for (size_t i = 0; i < n; i++) {
        const double count = st->count[i];
        if (s->slabs.method == MEAN)
            a[i] = st->a[i] / count * scale + offset;
        else if (s->slabs.method == SUM)
            a[i] = count > 0 ? st->a[i] * scale + count * offset : (double)NAN;
        else if (s->slabs.method == DEVIATION)
            a[i] = sqrt(st->b[i] / count) * fabs(scale);
    }
}

static size_t row_numbers(const shared *s)
{
    return (size_t)s->brick.box.n[0] * (size_t)s->in->components;
}

/* Row (y, z) of the input. */
static const char *row_at(const shared *s, int64_t y, int64_t z)
{
    const vv_brick *b = &s->brick;
    return (const char *)b->data + (y - b->box.lo[1]) * b->stride[1] + (z - b->box.lo[2]) * b->stride[2];
}

static void read_row(double *row, const shared *s, int64_t y, int64_t z)
{
    vvi_samples_to_f64(row, row_at(s, y, z), s->in->type, row_numbers(s));
}

static double largest_of(const double *v, size_t n)
{
    double most = v[0];
    for (size_t i = 1; i < n; i++)
        most = v[i] > most ? v[i] : most;
    return most;
}

/* The number of rank k comes to its place, smaller ones before it: Hoare's selection. */
static double select_rank(double *v, size_t n, size_t k)
{
    size_t lo = 0, hi = n - 1;
    while (lo < hi) {
        const double pivot = v[lo + (hi - lo) / 2];
        size_t i = lo, j = hi;
        for (;;) {
            while (v[i] < pivot)
                i++;
            while (v[j] > pivot)
                j--;
            if (i >= j)
                break;
            const double t = v[i];
            v[i++] = v[j];
            v[j--] = t;
        }
        if (k <= j)
            hi = j;
        else
            lo = j + 1;
    }
    return v[k];
}

/* Of the numbers that there are; of an even number of them the mean of the middle two. */
static double median_of(double *v, size_t n)
{
    size_t there = 0;
    for (size_t i = 0; i < n; i++)
        if (!isnan(v[i]))
            v[there++] = v[i];
    if (there == 0)
        return (double)NAN;
    const double upper = select_rank(v, there, there / 2);
    return there % 2 ? upper : 0.5 * largest_of(v, there / 2) + 0.5 * upper;
}

/* A worker's own: a row of the input, a state and a row of the result, one channel of a slab of a row, and for medians
 * the rows of a slab. */
typedef struct scratch {
    double *row, *out, *slab, *column;
    state state;
} scratch;

static size_t out_numbers(const shared *s)
{
    return (size_t)s->part.n[0] * (size_t)s->in->components;
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t in = row_numbers(s), out = out_numbers(s);
    const size_t thick = (size_t)(s->slabs.thick < s->slabs.n_in ? s->slabs.thick : s->slabs.n_in);
    const size_t slab = s->slabs.axis && s->slabs.method == MEDIAN ? thick * in : 0;
    const size_t bytes = sizeof(scratch) + (in + 4 * out + slab + thick) * sizeof(double);
    scratch *own = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    if (!own)
        return vv_fail_memory(bytes);
    own->row = (double *)(void *)(own + 1);
    own->out = own->row + in;
    own->state = (state){own->out + out, own->out + 2 * out, own->out + 3 * out};
    own->slab = own->out + 4 * out;
    own->column = own->slab + slab;
    *scratch_out = own;
    return VV_OK;
}

static void finish(void *own, void *user)
{
    vvi_free(own);
}

/* n samples along x of one channel, `step` of them apart, into state i. */
static void fold_samples(scratch *own, const state *st, size_t i, const char *at, const shared *s, int64_t n)
{
    const size_t each = vv_type_bytes(s->in->type), step = (size_t)s->in->components;
    const vvi_project_sums sums = {&st->a[i], &st->b[i], &st->count[i]};
    if (step > 1) {
        char *column = (char *)own->column;
        for (size_t t = 0; t < (size_t)n; t++)
            memcpy(column + t * each, at + t * step * each, each);
        at = column;
    }
    if (is_extreme(s))
        s->loops->extreme_of[seeks_largest(s)]((char *)st->a + i * each, at, n);
    else
        (s->slabs.method == DEVIATION ? s->loops->square_of : s->loops->sum_of)(&sums, at, n);
}

static double median_of_samples(scratch *own, const double *at, size_t step, int64_t n)
{
    for (int64_t t = 0; t < n; t++)
        own->column[t] = at[(size_t)t * step];
    return median_of(own->column, (size_t)n);
}

/* Along x a row has all that goes together. */
static void fold_along_row(scratch *own, const state *st, const shared *s, int64_t j, int64_t k)
{
    const size_t components = (size_t)s->in->components, each = vv_type_bytes(s->in->type);
    const char *row = row_at(s, j, k);
    if (s->slabs.method == MEDIAN)
        read_row(own->row, s, j, k);
    for (int64_t i = 0; i < s->part.n[0]; i++) {
        int64_t lo, n;
        slab_of(&lo, &n, &s->slabs, s->part.lo[0] + i);
        for (size_t c = 0; c < components; c++) {
            const size_t from = (size_t)(lo - s->brick.box.lo[0]) * components + c, to = (size_t)i * components + c;
            if (s->slabs.method == MEDIAN)
                st->a[to] = median_of_samples(own, own->row + from, components, n);
            else
                fold_samples(own, st, to, row + from * each, s, n);
        }
    }
}

static void medians_of_rows(scratch *own, const state *st, const shared *s, int64_t rows)
{
    const size_t n = row_numbers(s);
    for (size_t i = 0; i < n; i++) {
        for (int64_t t = 0; t < rows; t++)
            own->column[t] = own->slab[(size_t)t * n + i];
        st->a[i] = median_of(own->column, (size_t)rows);
    }
}

/* Along y and z it is rows that go together. */
static void fold_rows(scratch *own, const state *st, const shared *s, int64_t j, int64_t k)
{
    int64_t lo, n;
    const bool along_y = s->slabs.axis == 1;
    slab_of(&lo, &n, &s->slabs, along_y ? j : k);
    const int64_t first = lo > s->from ? lo : s->from, end = lo + n < s->to ? lo + n : s->to, rows = end - first;
    if (s->slabs.method != MEDIAN && rows > 0)
        add_rows(st, along_y ? row_at(s, first, k) : row_at(s, j, first), rows, s->brick.stride[along_y ? 1 : 2], s,
                 row_numbers(s));
    if (s->slabs.method != MEDIAN)
        return;
    for (int64_t t = 0; t < rows; t++)
        read_row(own->slab + (size_t)t * row_numbers(s), s, along_y ? first + t : j, along_y ? k : first + t);
    medians_of_rows(own, st, s, rows > 0 ? rows : 0);
}

/* Of sums, whose states have how many were missing. */
static void count_there(const state *st, const shared *s, size_t n, int64_t j, int64_t k)
{
    for (size_t i = 0; i < n; i++) {
        const int64_t x = s->part.lo[0] + (int64_t)i / s->in->components;
        int64_t lo, all;
        slab_of(&lo, &all, &s->slabs, s->slabs.axis == 0 ? x : s->slabs.axis == 1 ? j : k);
        st->count[i] = (double)all - st->count[i];
    }
}

static void write_row(scratch *own, const state *st, const shared *s, int64_t j, int64_t k)
{
    const size_t n = out_numbers(s), each = vv_type_bytes(s->info->type);
    const int64_t at =
        ((k - s->box.lo[2]) * s->box.n[1] + j - s->box.lo[1]) * s->box.n[0] + s->part.lo[0] - s->box.lo[0];
    char *out = s->out + (size_t)(at * s->in->components) * each;
    if (is_extreme(s)) {
        memcpy(out, st->a, n * each);
        return;
    }
    if (s->slabs.method == MEAN || s->slabs.method == SUM)
        count_there(st, s, n, j, k);
    memcpy(own->out, st->a, n * sizeof *own->out);
    end_row(own->out, st, s, n);
    vvi_samples_from_f64(out, own->out, s->info->type, n);
}

static void make_row(scratch *own, const shared *s, int64_t j, int64_t k)
{
    const state *st = &own->state;
    begin(st, s, out_numbers(s));
    if (s->slabs.axis > 0)
        fold_rows(own, st, s, j, k);
    else
        fold_along_row(own, st, s, j, k);
    write_row(own, st, s, j, k);
}

/* From row j on: those of one row stand behind those of the one before. */
static state kept_state(const shared *s, int64_t j)
{
    const size_t n = out_numbers(s), all = n * (size_t)s->part.n[1], row = n * (size_t)(j - s->part.lo[1]);
    const size_t each = is_extreme(s) ? vv_type_bytes(s->in->type) : sizeof(double);
    return (state){(double *)(void *)((char *)s->kept + row * each), s->kept + all + row, s->kept + 2 * all + row};
}

/* Some rows of all slices that there are now, slice by slice: a piece of each is read in one go. */
static void add_slices(scratch *own, const shared *s, const vv_box *box)
{
    const int64_t k = box->lo[2], first = box->lo[1], end = first + box->n[1];
    const size_t n = row_numbers(s);
    const bool joined = s->brick.stride[1] == (int64_t)(n * vv_type_bytes(s->in->type)); /* rows are one long row */
    const int64_t rows = joined ? box->n[1] : 1;
    const state all = kept_state(s, first);
    if (s->first)
        begin(&all, s, n * (size_t)box->n[1]);
    for (int64_t t = s->from; t < s->to; t += TOGETHER)
        for (int64_t j = first; j < end; j += rows) {
            const state st = kept_state(s, j);
            add_rows(&st, row_at(s, j, t), s->to - t < TOGETHER ? s->to - t : TOGETHER, s->brick.stride[2], s,
                     n * (size_t)rows);
        }
    for (int64_t j = first; j < end && s->last; j++) {
        const state st = kept_state(s, j);
        write_row(own, &st, s, j, k);
    }
}

static vv_status item(void *own, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->items, index);
    if (s->kept)
        add_slices(own, s, &box);
    for (int64_t k = box.lo[2]; k < box.lo[2] + box.n[2] && !s->kept; k++)
        for (int64_t j = box.lo[1]; j < box.lo[1] + box.n[1]; j++)
            make_row(own, s, j, k);
    return vvi_job_poll(s->job);
}

static vv_status run_pass(shared *s, const vv_field *in, const vv_box *needed)
{
    static const vvi_work work = {.stage = "project", .start = start, .item = item, .finish = finish};
    const int64_t row = needed->n[0] * (s->kept || s->slabs.axis == 0 ? 1 : needed->n[s->slabs.axis]);
    const int64_t rows = 1 + (s->kept ? PIECE_SAMPLES : ITEM_SAMPLES) / row;
    vv_status st = vv_field_brick(&s->brick, in, needed, s->job);
    s->items = vvi_slabs_of(&s->part, rows * s->part.n[0]);
    if (st == VV_OK)
        st = vvi_parallel_for(s->job, &work, s, s->items.n);
    vv_brick_release(&s->brick);
    return st;
}

/* Slices that go to one, some of them after the others: what is read in order need not be held. */
static vv_status add_up_slices(shared *s, const vv_field *in, const vv_box *needed)
{
    const size_t numbers = out_numbers(s) * (size_t)s->part.n[1];
    const int64_t slice = needed->n[0] * needed->n[1] * s->in->components * (int64_t)vv_type_bytes(s->in->type);
    const int64_t step = 1 + CHUNK_BYTES / slice, end = needed->lo[2] + needed->n[2];
    vv_status st = VV_OK;
    s->kept = vvi_alloc(s->job, 3 * numbers * sizeof(double), VVI_MEM_SCRATCH);
    if (!s->kept)
        return vv_fail_memory(3 * numbers * sizeof(double));
    for (int64_t z = needed->lo[2]; z < end && st == VV_OK; z += step) {
        vv_box some = *needed;
        some.lo[2] = s->from = z;
        some.n[2] = end - z < step ? end - z : step;
        s->to = z + some.n[2];
        s->first = z == needed->lo[2];
        s->last = s->to == end;
        st = run_pass(s, in, &some);
    }
    vvi_free(s->kept);
    s->kept = NULL;
    return st;
}

/* All that a part needs along the axis. */
static vv_box box_needed(const shared *s)
{
    const int a = s->slabs.axis;
    vv_box needed = s->part;
    int64_t lo, n, last_lo, last_n;
    slab_of(&lo, &n, &s->slabs, s->part.lo[a]);
    slab_of(&last_lo, &last_n, &s->slabs, s->part.lo[a] + s->part.n[a] - 1);
    needed.lo[a] = lo;
    needed.n[a] = last_lo + last_n - lo;
    return needed;
}

static vv_status run_part(shared *s, const vv_field *in)
{
    const vv_box needed = box_needed(s);
    s->from = needed.lo[s->slabs.axis];
    s->to = s->from + needed.n[s->slabs.axis];
    s->first = s->last = true;
    return s->slabs.axis == 2 && s->slabs.method != MEDIAN ? add_up_slices(s, in, &needed) : run_pass(s, in, &needed);
}

/* Along z, slice after slice; of medians as many rows at once as may be held. */
static vv_status run_parts(shared *s, const vv_field *in)
{
    const int64_t row = s->box.n[0] * s->slabs.thick * s->in->components * (int64_t)vv_type_bytes(s->in->type);
    const int64_t rows = s->slabs.method == MEDIAN && row > 0 ? 1 + 4 * CHUNK_BYTES / row : s->box.n[1];
    vv_status st = VV_OK;
    s->part = s->box;
    if (s->slabs.axis != 2)
        return run_part(s, in);
    for (int64_t k = 0; k < s->box.n[2]; k++)
        for (int64_t j = 0; j < s->box.n[1] && st == VV_OK; j += rows) {
            s->part.lo[2] = s->box.lo[2] + k;
            s->part.n[2] = 1;
            s->part.lo[1] = s->box.lo[1] + j;
            s->part.n[1] = s->box.n[1] - j < rows ? s->box.n[1] - j : rows;
            st = run_part(s, in);
        }
    return st;
}

/* Of floats NaN, which any number replaces; else what none lies beyond. */
static void find_nothing(shared *s)
{
    const vv_type type = s->in->type;
    const double end = seeks_largest(s) ? vvi_type_min(type) : vvi_type_max(type);
    const double nothing = vv_type_is_float(type) ? (double)NAN : end;
    vvi_samples_from_f64(s->nothing, &nothing, type, 1);
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    shared s = {.in = vv_field_get_info(inputs[0]), .box = *box, .job = job};
    vv_field *field;
    void *data;
    *out = NULL;
    vv_status st = find_slabs(&s.slabs, s.in, params);
    if (st != VV_OK)
        return st;
    const vv_field_info info = projected(s.in, &s.slabs);
    vv_field_info part = info;
    part.grid = vv_grid_crop(&info.grid, box);
    if ((st = vv_field_new_empty(&field, &data, &part, job)) != VV_OK)
        return st;
    s.info = &info;
    s.out = data;
    s.loops = &vvi_project_kernels_for(vvi_job_cpu(job))->of[s.in->type];
    find_nothing(&s);
    if ((st = run_parts(&s, inputs[0])) == VV_OK)
        st = vv_field_health(inputs[0]);
    if (st == VV_OK)
        *out = field;
    else
        vv_field_release(field);
    return st;
}

/* Means and sums are in the unit, but no longer what a window was chosen for. */
static vv_status carry(vv_carry *carried, const vv_object *params)
{
    carried->new_values |= !keeps_type(((const project_params *)params)->method);
    return VV_OK;
}

const vv_operation vvi_operation_project = {
    .api = VV_OPERATION_API,
    .name = "project",
    .component = "filter",
    .group = "geometry",
    .doc = "make one slice of all along an axis, or of each slab of them: their maximum, minimum, mean, sum, standard "
           "deviation or median",
    .example = "volvis project head.nrrd -o mip.nrrd --axis z --method maximum --slab 20mm",
    .params = &project_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = carry,
};
