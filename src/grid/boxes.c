#include "grid/boxes.h"
#include "core/job.h"
#include "core/memory.h"

typedef struct build {
    vvi_boxes *boxes;
    const vvi_minmax *minmax;
    vvi_visible_fn *visible;
    const void *user;
    uint8_t *occupied; /* by box */
    size_t *first;     /* by slice: kept boxes in it, then before it */
    size_t *faces;     /* by slice */
} build;

static size_t slice_boxes(const vvi_boxes *b)
{
    return (size_t)b->n[0] * (size_t)b->n[1];
}

/* Whether any of a box's blocks is visible. */
static bool box_visible(const build *b, const int32_t at[3])
{
    const vvi_minmax *m = b->minmax;
    const int up = b->boxes->shift - m->shift;
    int32_t lo[3], hi[3];
    for (int a = 0; a < 3; a++) {
        lo[a] = at[a] << up;
        hi[a] = (at[a] + 1) << up < m->n[a] ? (at[a] + 1) << up : m->n[a];
    }
    for (int32_t k = lo[2]; k < hi[2]; k++)
        for (int32_t j = lo[1]; j < hi[1]; j++)
            for (int32_t i = lo[0]; i < hi[0]; i++) {
                const size_t block = ((size_t)k * (size_t)m->n[1] + (size_t)j) * (size_t)m->n[0] + (size_t)i;
                if (m->lo[block] <= m->hi[block] && b->visible(b->user, m->lo[block], m->hi[block]))
                    return true;
            }
    return false;
}

/* Item: a slice of boxes. */
static vv_status find_occupied(void *scratch, void *shared, size_t k)
{
    const build *b = shared;
    const vvi_boxes *x = b->boxes;
    uint8_t *to = b->occupied + k * slice_boxes(x);
    size_t n = 0;
    (void)scratch;
    for (int32_t j = 0; j < x->n[1]; j++)
        for (int32_t i = 0; i < x->n[0]; i++) {
            const bool kept = box_visible(b, (const int32_t[3]){i, j, (int32_t)k});
            *to++ = kept;
            n += kept;
        }
    b->first[k] = n;
    return VV_OK;
}

/* Which faces of an occupied box have no other behind them. */
static uint8_t outer_faces(const build *b, size_t number, const int32_t at[3])
{
    const vvi_boxes *x = b->boxes;
    const size_t step[3] = {1, (size_t)x->n[0], slice_boxes(x)};
    unsigned bits = 0;
    for (int a = 0; a < 3; a++) {
        const bool below = at[a] > 0 && b->occupied[number - step[a]];
        const bool above = at[a] + 1 < x->n[a] && b->occupied[number + step[a]];
        bits |= (unsigned)!below << (2 * a) | (unsigned)!above << (2 * a + 1);
    }
    return (uint8_t)bits;
}

/* Item: the list of a slice, to where the slices before it end. */
static vv_status list_slice(void *scratch, void *shared, size_t k)
{
    const build *b = shared;
    const vvi_boxes *x = b->boxes;
    size_t number = k * slice_boxes(x), to = b->first[k], faces = 0;
    (void)scratch;
    for (int32_t j = 0; j < x->n[1]; j++)
        for (int32_t i = 0; i < x->n[0]; i++, number++) {
            if (!b->occupied[number])
                continue;
            const uint8_t outer = outer_faces(b, number, (const int32_t[3]){i, j, (int32_t)k});
            x->kept[to] = (uint32_t)number;
            x->outer[to++] = outer;
            faces += (size_t)__builtin_popcount(outer);
        }
    b->faces[k] = faces;
    return VV_OK;
}

static vv_status make_list(build *b, vv_job *job)
{
    vvi_boxes *x = b->boxes;
    const size_t slices = (size_t)x->n[2];
    const vvi_work find = {.item = find_occupied}, list = {.item = list_slice};
    vv_status st = vvi_parallel_for(job, &find, b, slices);
    if (st != VV_OK)
        return st;
    for (size_t k = 0; k < slices; k++) {
        const size_t n = b->first[k];
        b->first[k] = x->n_kept;
        x->n_kept += n;
    }
    if (!x->n_kept)
        return VV_OK;
    x->kept = vvi_alloc(job, x->n_kept * sizeof *x->kept, VVI_MEM_DERIVED);
    x->outer = vvi_alloc(job, x->n_kept * sizeof *x->outer, VVI_MEM_DERIVED);
    if (!x->kept || !x->outer)
        return vv_fail_memory(x->n_kept * (sizeof *x->kept + sizeof *x->outer));
    st = vvi_parallel_for(job, &list, b, slices);
    for (size_t k = 0; st == VV_OK && k < slices; k++)
        x->n_outer += b->faces[k];
    return st;
}

/* How many boxes there are; 32 bits number them. */
static vv_status size_boxes(size_t *total_out, vvi_boxes *x, const vvi_minmax *minmax)
{
    const int up = x->shift - minmax->shift;
    for (int a = 0; a < 3; a++)
        x->n[a] = (int32_t)(((int64_t)minmax->n[a] + ((int64_t)1 << up) - 1) >> up);
    const vv_status st = vvi_mul3_size(total_out, (size_t)x->n[0], (size_t)x->n[1], (size_t)x->n[2]);
    if (st == VV_OK && *total_out > UINT32_MAX)
        return vv_fail(VV_E_LIMIT, "%d x %d x %d boxes of %d voxels do not fit into 32 bits; use larger boxes", x->n[0],
                       x->n[1], x->n[2], 1 << x->shift);
    return st;
}

vv_status vvi_boxes_build(vvi_boxes **out, const vvi_minmax *minmax, int shift, vvi_visible_fn *visible,
                          const void *user, vv_job *job)
{
    *out = NULL;
    vvi_boxes *x = vvi_alloc_zeroed(job, sizeof *x, VVI_MEM_DERIVED);
    if (!x)
        return vv_fail_memory(sizeof *x);
    x->shift = shift;
    build b = {.boxes = x, .minmax = minmax, .visible = visible, .user = user};
    size_t total;
    vv_status st = size_boxes(&total, x, minmax);
    if (st == VV_OK) {
        const size_t slices = (size_t)x->n[2];
        b.occupied = vvi_alloc(job, total, VVI_MEM_SCRATCH);
        b.first = vvi_alloc(job, 2 * slices * sizeof *b.first, VVI_MEM_SCRATCH);
        b.faces = b.first ? b.first + slices : NULL;
        st = b.occupied && b.first ? make_list(&b, job) : vv_fail_memory(total + 2 * slices * sizeof *b.first);
    }
    vvi_free(b.occupied);
    vvi_free(b.first);
    if (st == VV_OK)
        *out = x;
    else
        vvi_boxes_free(x);
    return st;
}

bool vvi_boxes_has(const vvi_boxes *b, int64_t i, int64_t j, int64_t k)
{
    if (i < 0 || j < 0 || k < 0 || i >= b->n[0] || j >= b->n[1] || k >= b->n[2])
        return false;
    const uint64_t number = ((uint64_t)k * (uint64_t)b->n[1] + (uint64_t)j) * (uint64_t)b->n[0] + (uint64_t)i;
    size_t lo = 0, hi = b->n_kept;
    while (lo < hi) {
        const size_t mid = lo + (hi - lo) / 2;
        if (b->kept[mid] < number)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo < b->n_kept && b->kept[lo] == number;
}

void vvi_boxes_free(void *boxes)
{
    vvi_boxes *b = boxes;
    if (!b)
        return;
    vvi_free(b->kept);
    vvi_free(b->outer);
    vvi_free(b);
}
