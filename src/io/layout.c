#include "io/layout.h"
#include "core/job.h"
#include "core/memory.h"
#include <string.h>

/* What can be counted without overflow; what is too much is said by the limits of the job, of all formats alike. */
#define AXIS_MOST (UINT64_C(1) << 31)
#define ELEMENTS_MOST (UINT64_C(1) << 60)
#define PIECE_BYTES ((size_t)4 << 20)
#define SCATTER_ELEMENTS ((size_t)16384)

size_t vvi_layout_element_bytes(const vvi_layout *layout)
{
    return layout->half ? 2 : vv_type_bytes(layout->type);
}

vv_status vvi_layout_count(uint64_t *out, const vvi_layout *layout, const char *name)
{
    uint64_t n = 1;
    for (int a = 0; a < layout->n_axes; a++) {
        const int64_t size = layout->axis[a].n;
        if (size < 1 || (uint64_t)size > AXIS_MOST)
            return vv_fail_at(VV_E_FORMAT, name, NULL, "axis %d has %lld samples; 1 to %llu are allowed", a + 1,
                              (long long)size, (unsigned long long)AXIS_MOST);
        if (n > ELEMENTS_MOST / (uint64_t)size)
            return vv_fail_at(VV_E_FORMAT, name, NULL, "asks for more than %llu samples; its header is wrong",
                              (unsigned long long)ELEMENTS_MOST);
        n *= (uint64_t)size;
    }
    *out = n;
    return VV_OK;
}

vv_status vvi_source_expect(vv_source *source, uint64_t offset, uint64_t bytes, const char *what)
{
    bool exact;
    const uint64_t left = vvi_source_left(source, &exact), at = vvi_source_tell(source);
    const uint64_t all = left > UINT64_MAX - at ? UINT64_MAX : left + at;
    if (offset <= all && bytes <= all - offset)
        return VV_OK;
    if (exact)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                          "ends after %llu bytes; %llu were expected for %s; the file is cut short or its header wrong",
                          (unsigned long long)all, (unsigned long long)(offset + bytes), what);
    const char *limit = vvi_source_expansion(source);
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                      "can hold at most %llu bytes; %llu were expected for %s; the file is cut short or its header "
                      "wrong%s%s%s",
                      (unsigned long long)all, (unsigned long long)(offset + bytes), what, limit ? ", or --limit " : "",
                      limit ? limit : "", limit ? "=N allows more" : "");
}

vv_status vvi_source_expect_half(vv_source *source, uint64_t offset, uint64_t bytes, const char *what)
{
    bool exact;
    const uint64_t left = vvi_source_left(source, &exact), at = vvi_source_tell(source);
    const uint64_t all = left > UINT64_MAX - at ? UINT64_MAX : left + at;
    if (exact && offset < all && bytes - bytes / 2 <= all - offset)
        return VV_OK;
    return vvi_source_lacks(source, vvi_source_expect(source, offset, bytes, what));
}

/* The walk over a file's axes ------------------------------------------------------------------------------------ */

typedef struct walk_axis {
    int64_t n, lo, hi; /* [lo, hi) of n is wanted */
    int64_t step;      /* elements of the output from one to the next */
} walk_axis;

typedef struct walk {
    const vvi_layout *layout;
    const vvi_elements *elements;
    vv_job *job;
    int n_axes;
    walk_axis axis[VVI_ROLES];
    uint8_t *out;
    size_t in_bytes, out_bytes; /* of an element */
    uint8_t *row;               /* SCATTER_ELEMENTS elements */
    uint64_t done, total;
    int64_t frame;
    uint64_t end;      /* elements of the file that are there, where it is cut short; else UINT64_MAX */
    bool half_checked; /* of data of which it was known where they end, before they were read to there */
} walk;

/* Two neighbouring axes are one when the lower is wanted whole and the output goes on evenly, or when of the upper only
 * one is wanted. A plain volume ends as a single run. */
static void merge_axes(walk *w)
{
    for (int a = 0; a + 1 < w->n_axes;) {
        walk_axis *p = &w->axis[a], *q = &w->axis[a + 1];
        const bool whole = p->lo == 0 && p->hi == p->n;
        if (!whole || (q->hi - q->lo != 1 && q->step != p->step * p->n && p->n != 1)) {
            a++;
            continue;
        }
        *p = (walk_axis){p->n * q->n, q->lo * p->n, q->hi * p->n, p->n == 1 ? q->step : p->step};
        memmove(q, q + 1, sizeof *q * (size_t)(w->n_axes - a - 2));
        w->n_axes--;
    }
}

static void plan_walk(walk *w, const vvi_layout *layout, int components, int64_t frame, const vv_box *box)
{
    const int64_t step_x = components, step_y = step_x * box->n[0], step_z = step_y * box->n[1];
    const walk_axis roles[VVI_ROLES] = {
        {0, 0, components, 1},
        {0, box->lo[0], box->lo[0] + box->n[0], step_x},
        {0, box->lo[1], box->lo[1] + box->n[1], step_y},
        {0, box->lo[2], box->lo[2] + box->n[2], step_z},
        {0, frame, frame + 1, 0},
    };
    *w = (walk){.layout = layout, .n_axes = layout->n_axes, .frame = frame, .end = UINT64_MAX};
    for (int a = 0; a < layout->n_axes; a++) {
        w->axis[a] = roles[layout->axis[a].role];
        w->axis[a].n = layout->axis[a].n;
    }
    w->in_bytes = vvi_layout_element_bytes(layout);
    w->out_bytes = vv_type_bytes(layout->type);
    merge_axes(w);
}

static bool is_one_run(const walk *w)
{
    const vvi_layout *layout = w->layout;
    return w->n_axes == 1 && (w->axis[0].step == 1 || w->axis[0].hi - w->axis[0].lo == 1) && !layout->swap &&
           !layout->half && !layout->negate;
}

float vvi_half_to_float(uint16_t h)
{
    const uint32_t sign = (uint32_t)(h & 0x8000) << 16, exponent = (h >> 10) & 31, mantissa = h & 1023;
    union {
        uint32_t u;
        float f;
    } out;
    if (exponent == 31) {
        out.u = sign | 0x7f800000u | mantissa << 13;
    } else if (exponent > 0) {
        out.u = sign | (exponent + 112) << 23 | mantissa << 13;
    } else {
        out.f = (float)mantissa * 0x1p-24f;
        out.u |= sign;
    }
    return out.f;
}

#define SCATTER(T)                                                                                                     \
    do {                                                                                                               \
        T *to = (T *)(void *)out;                                                                                      \
        const T *from = (const T *)(const void *)row;                                                                  \
        for (size_t i = 0; i < n; i++)                                                                                 \
            to[(int64_t)i * step] = from[i];                                                                           \
    } while (0)

static void scatter(uint8_t *out, const uint8_t *row, size_t n, int64_t step, size_t bytes)
{
    switch (bytes) {
    case 1:
        SCATTER(uint8_t);
        break;
    case 2:
        SCATTER(uint16_t);
        break;
    case 4:
        SCATTER(uint32_t);
        break;
    default:
        SCATTER(uint64_t);
    }
}

static void scatter_half(uint8_t *out, const uint8_t *row, size_t n, int64_t step)
{
    float *to = (float *)(void *)out;
    const uint16_t *from = (const uint16_t *)(const void *)row;
    for (size_t i = 0; i < n; i++)
        to[(int64_t)i * step] = vvi_half_to_float(from[i]);
}

/* Elements of a frame among the first `end` of the file. */
static uint64_t count_in_frame(const vvi_layout *layout, int64_t frame, uint64_t end)
{
    uint64_t total = 1, count = 0, all = 1, wanted = 1; /* below an axis: elements of all frames, of this one */
    for (int a = 0; a < layout->n_axes; a++)
        total *= (uint64_t)layout->axis[a].n;
    if (end > total)
        end = total;
    for (int a = 0; a < layout->n_axes; a++) {
        const vvi_layout_axis *axis = &layout->axis[a];
        const uint64_t n = (uint64_t)axis->n, digit = a + 1 < layout->n_axes ? end / all % n : end / all;
        const bool is_frame = axis->role == VVI_ROLE_FRAME;
        if (!is_frame)
            count += digit * wanted;
        else if (digit > (uint64_t)frame)
            count = wanted;
        else if (digit < (uint64_t)frame)
            count = 0;
        all *= n;
        wanted *= is_frame ? 1 : n;
    }
    return count;
}

/* The rule of the half is about the whole volume, and so are the numbers, whichever box of it is read. */
static vv_status check_half(const walk *w, uint64_t end)
{
    const unsigned long long there = count_in_frame(w->layout, w->frame, end),
                             total = count_in_frame(w->layout, w->frame, UINT64_MAX);
    if (there >= total - total / 2)
        return VV_OK;
    return vv_fail_at(VV_E_FORMAT, w->elements->name, NULL,
                      "is cut short: %llu of the %llu numbers that its header promises are there, less than half; "
                      "get a complete copy",
                      there, total);
}

/* Before elements are written up to `to_end`: no page of the output beyond it has been touched, whatever the order. */
static vv_status hold(walk *w, const uint8_t *to_end)
{
    bool seen = false;
    if (!w->elements->source)
        return VV_OK;
    const vv_status st = vvi_source_hold(w->elements->source, (uint64_t)(to_end - w->out), &seen);
    if (st != VV_OK || !seen || w->half_checked || !w->elements->end_by_bytes)
        return st;
    w->half_checked = true;
    return check_half(w, w->elements->end(w->elements->user));
}

/* Elements into `to`; those that the file does not have any more are not there: NaN, or 0. Where too few are there,
 * this is found before memory is touched for those that are not. */
static vv_status read_elements(walk *w, uint8_t *to, uint64_t first, size_t n)
{
    size_t got = n;
    if (!w->elements->read_some)
        return w->elements->read(w->elements->user, to, first, n);
    vv_status st = w->elements->read_some(w->elements->user, to, first, n, &got);
    if (st == VV_OK && got < n) {
        const uint64_t end = w->elements->end ? w->elements->end(w->elements->user) : first + got;
        if (end < w->end)
            w->end = end;
        if ((st = check_half(w, w->end)) != VV_OK)
            return st;
        memset(to + got * w->in_bytes, vv_type_is_float(w->layout->type) ? 0xff : 0, (n - got) * w->in_bytes);
    }
    return st;
}

/* Elements [first, first + n) of the file to every step-th of the output. */
static vv_status read_run(walk *w, uint64_t first, uint64_t n, uint8_t *out, int64_t step)
{
    vv_status st = VV_OK;
    const bool direct = step == 1 && !w->layout->half;
    const size_t piece = direct ? PIECE_BYTES / w->in_bytes : SCATTER_ELEMENTS;
    while (n > 0 && st == VV_OK) {
        const size_t m = n < piece ? (size_t)n : piece;
        uint8_t *to = direct ? out : w->row;
        const int64_t last = (int64_t)((m - 1) * w->out_bytes) * step;
        if ((st = hold(w, out + last + w->out_bytes)) != VV_OK || (st = read_elements(w, to, first, m)) != VV_OK)
            return st;
        if (w->layout->swap)
            vvi_swap_bytes(to, w->in_bytes, m);
        if (w->layout->half)
            scatter_half(out, w->row, m, step);
        else if (!direct)
            scatter(out, w->row, m, step, w->out_bytes);
        first += m;
        n -= m;
        out += (int64_t)(m * w->out_bytes) * step;
        w->done += m;
        st = vvi_job_progress(w->job, "read", w->done, w->total);
    }
    return st;
}

/* Slowest axis first, so that a stream is only ever read forwards. `first` is the file's element that the lower axes
 * start at. */
static vv_status walk_axes(walk *w, int level, uint64_t first, uint8_t *out)
{
    const walk_axis *a = &w->axis[level];
    if (level == 0)
        return read_run(w, first + (uint64_t)a->lo, (uint64_t)(a->hi - a->lo), out, a->step);
    uint64_t below = 1;
    for (int b = 0; b < level; b++)
        below *= (uint64_t)w->axis[b].n;
    vv_status st = VV_OK;
    for (int64_t i = a->lo; i < a->hi && st == VV_OK; i++)
        st = walk_axes(w, level - 1, first + (uint64_t)i * below, out + (i - a->lo) * a->step * (int64_t)w->out_bytes);
    return st;
}

static bool reaches_end(const walk *w)
{
    for (int a = 0; a < w->n_axes; a++)
        if (w->axis[a].hi != w->axis[a].n)
            return false;
    return true;
}

/* Behind the last element of the box: whether a time step ends there, and how many bytes the file goes on. */
static vv_status check_rest(const walk *w, const vv_field_info *info, const vv_box *box)
{
    uint64_t all = 1, last = 0;
    bool frame_ends = true;
    for (int a = 0; a < w->n_axes; a++) {
        last += (uint64_t)(w->axis[a].hi - 1) * all;
        all *= (uint64_t)w->axis[a].n;
    }
    for (int a = 0; a < 3; a++)
        frame_ends &= box->lo[a] + box->n[a] == info->grid.dims[a];
    return vvi_source_check_rest(w->elements->source, frame_ends, (all - last - 1) * w->in_bytes);
}

static vv_status check_checksums(const walk *w, const vv_field_info *info, const vv_box *box)
{
    if (w->elements->check_end && reaches_end(w))
        return w->elements->check_end(w->elements->user);
    return w->elements->source && !reaches_end(w) ? check_rest(w, info, box) : VV_OK;
}

/* Signed types only: vectors of unsigned numbers have no negatives. Doubles hold every i32; of i64 the low bits of huge
 * components round, which no direction needs. */
static void negate_components(void *data, const vv_field_info *info, unsigned mask, uint64_t n_samples)
{
    const size_t bytes = vv_type_bytes(info->type), sample = bytes * (size_t)info->components;
    for (uint64_t i = 0; i < n_samples; i++)
        for (int c = 0; c < info->components; c++) {
            double v;
            uint8_t *at = (uint8_t *)data + i * sample + (size_t)c * bytes;
            if (!(mask >> c & 1))
                continue;
            vvi_samples_to_f64(&v, at, info->type, 1);
            v = -v;
            vvi_samples_from_f64(at, &v, info->type, 1);
        }
}

static vv_field_info info_of_part(const vv_field_info *info, int64_t frame, const vv_box *box)
{
    vv_field_info part = *info;
    part.grid = vv_grid_crop(&info->grid, box);
    part.frame = frame;
    return part;
}

static vv_box box_of(const vv_field_info *info, const vv_box *region)
{
    if (region)
        return *region;
    return (vv_box){{0, 0, 0}, {info->grid.dims[0], info->grid.dims[1], info->grid.dims[2]}};
}

bool vvi_layout_mappable(const vvi_layout *layout, uint64_t offset)
{
    walk w;
    int64_t n[VVI_ROLES] = {1, 1, 1, 1, 1};
    for (int a = 0; a < layout->n_axes; a++)
        n[layout->axis[a].role] = layout->axis[a].n;
    const vv_box all = {{0, 0, 0}, {n[VVI_ROLE_X], n[VVI_ROLE_Y], n[VVI_ROLE_Z]}};
    plan_walk(&w, layout, (int)n[VVI_ROLE_COMPONENT], 0, &all);
    return is_one_run(&w) && offset % vv_type_bytes(layout->type) == 0;
}

/* Boxes of a volume that is streamed say the same, which is told once. */
static vv_status tell_missing(const walk *w)
{
    const vv_status st = check_half(w, w->end);
    if (st == VV_OK)
        vvi_job_damage(w->job, "io", "%s: is cut short: %llu of %llu numbers are there, the rest is %s",
                       w->elements->name, (unsigned long long)count_in_frame(w->layout, w->frame, w->end),
                       (unsigned long long)count_in_frame(w->layout, w->frame, UINT64_MAX),
                       vv_type_is_float(w->layout->type) ? "NaN" : "0");
    return st;
}

static vv_status fill(walk *w, const vv_field_info *part, const vv_field_info *info, const vv_box *box, void *data)
{
    w->out = data;
    w->total = (uint64_t)(part->grid.dims[0] * part->grid.dims[1] * part->grid.dims[2]) * (uint64_t)part->components;
    if (w->layout->half || w->axis[0].step != 1) {
        w->row = vvi_alloc(w->job, SCATTER_ELEMENTS * 8, VVI_MEM_SCRATCH);
        if (!w->row)
            return vv_fail_memory(SCATTER_ELEMENTS * 8);
    }
    vv_status st = walk_axes(w, w->n_axes - 1, 0, w->out);
    if (st == VV_OK && w->end != UINT64_MAX)
        st = tell_missing(w);
    else if (st == VV_OK)
        st = check_checksums(w, info, box);
    if (st == VV_OK && w->layout->negate)
        negate_components(data, part, w->layout->negate, w->total / (uint64_t)part->components);
    vvi_free(w->row);
    return st;
}

vv_status vvi_layout_read(vv_field **out, const vv_field_info *info, const vvi_layout *layout,
                          const vvi_elements *elements, int64_t frame, const vv_box *region, vv_job *job)
{
    walk w;
    uint64_t bytes;
    void *data;
    *out = NULL;
    const vv_box box = box_of(info, region);
    const vv_field_info part = info_of_part(info, frame, &box);
    vv_status st = vv_field_info_bytes(&bytes, &part);
    if (st != VV_OK || (st = vvi_memory_plan(job, bytes, "volume")) != VV_OK)
        return st;
    plan_walk(&w, layout, info->components, frame, &box);
    w.elements = elements;
    w.job = job;
    vv_field *field;
    if ((st = vv_field_new_empty(&field, &data, &part, job)) != VV_OK)
        return st;
    if ((st = fill(&w, &part, info, &box, data)) != VV_OK) {
        vv_field_release(field);
        return st;
    }
    *out = field;
    return VV_OK;
}

/* Plain bytes ---------------------------------------------------------------------------------------------------- */

typedef struct plain {
    vv_source *source;
    uint64_t offset;
    size_t element_bytes;
} plain;

static vv_status read_plain(void *user, void *out, uint64_t first, size_t n, size_t *n_got)
{
    const plain *p = user;
    size_t bytes = 0;
    vv_status st = vvi_source_seek(p->source, p->offset + first * p->element_bytes);
    if (st == VV_OK)
        st = vvi_source_read_whole(p->source, out, n * p->element_bytes, &bytes);
    *n_got = bytes / p->element_bytes;
    return st;
}

static uint64_t end_of_plain(const void *user)
{
    const plain *p = user;
    const uint64_t end = vvi_source_end(p->source);
    return end > p->offset ? (end - p->offset) / p->element_bytes : 0;
}

static vv_status check_plain_end(void *user)
{
    return vvi_source_check_tail(((plain *)user)->source);
}

static bool is_damaged(const void *user)
{
    return vvi_mapping_damaged(user);
}

vv_status vvi_layout_map(vv_field **out, const vv_field_info *part, vv_source *source, uint64_t offset, uint64_t bytes,
                         vv_job *job)
{
    *out = NULL;
    vvi_mapping *mapping;
    const void *data;
    size_t guard;
    vv_status st = vvi_source_map(&mapping, &data, &guard, source, offset, bytes);
    if (st != VV_OK)
        return st;
    return vvi_field_new_watched(out, part, data, guard, vvi_mapping_free, is_damaged, mapping, job);
}

vv_status vvi_layout_read_plain(vv_field **out, const vv_field_info *info, const vvi_layout *layout, vv_source *source,
                                uint64_t offset, int64_t frame, const vv_box *region, vv_job *job)
{
    walk w;
    *out = NULL;
    const vv_box box = box_of(info, region);
    const size_t element = vvi_layout_element_bytes(layout);
    plan_walk(&w, layout, info->components, frame, &box);
    if (is_one_run(&w)) {
        const uint64_t from = offset + (uint64_t)w.axis[0].lo * element;
        const uint64_t bytes = (uint64_t)(w.axis[0].hi - w.axis[0].lo) * element;
        const vv_field_info part = info_of_part(info, frame, &box);
        if (from % element == 0 && vvi_source_mappable(source, from, bytes))
            return vvi_layout_map(out, &part, source, from, bytes, job);
    }
    plain p = {source, offset, element};
    const vvi_elements elements = {.user = &p,
                                   .read_some = read_plain,
                                   .end = end_of_plain,
                                   .end_by_bytes = true,
                                   .name = vvi_source_name(source),
                                   .check_end = check_plain_end,
                                   .source = source};
    return vvi_layout_read(out, info, layout, &elements, frame, region, job);
}
