/* Voxel counting, slice by slice: how many voxels, where, and how often each pattern of 2 x 2 x 2 occurs. Cells between
 * voxels reach one beyond the volume on each side: there stands outside (closed), or the last voxel again, so that the
 * surface just runs out of the volume; then the cells before the first voxels are left out, as those after the last
 * ones stand for them. */
#include "measure/sums.h"

#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"

#include <string.h>

typedef struct shared {
    const vvi_object *object;
    const vvi_region *region;
    bool closed;
    size_t words; /* of a row with a voxel more at each end, and one that is 0 */
    vvi_count_sums *part;
} shared;

/* Two slices of rows -1 .. ny, and room for one as it comes. */
typedef struct worker {
    uint64_t *slice[2], *raw;
} worker;

static vv_status start(void **scratch_out, void *user, int number)
{
    (void)number;
    const shared *s = user;
    const size_t padded = (size_t)(s->object->n[1] + 2) * s->words;
    const size_t raw = (size_t)s->object->n[1] * s->object->words;
    const size_t bytes = sizeof(worker) + (2 * padded + raw) * sizeof(uint64_t);
    worker *w = vvi_alloc(s->object->job, bytes, VVI_MEM_SCRATCH);
    *scratch_out = w;
    if (!w)
        return vv_fail_memory(bytes);
    w->slice[0] = (uint64_t *)(w + 1);
    w->slice[1] = w->slice[0] + padded;
    w->raw = w->slice[1] + padded;
    return VV_OK;
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

/* Where voxels are ------------------------------------------------------------------------------------------------ */

static void take_voxels(vvi_count_sums *t, const vvi_object *o, const uint64_t *row, int64_t j, int64_t k)
{
    const vv_affine *m = &vv_field_get_info(o->field)->grid.index_to_world;
    int64_t n = 0, first = -1, last = -1;
    for (int64_t w = 0; w < (int64_t)o->words; w++) {
        if (!row[w])
            continue;
        const int64_t here = __builtin_popcountll(row[w]);
        first = first < 0 ? 64 * w + __builtin_ctzll(row[w]) : first;
        last = 64 * w + 63 - __builtin_clzll(row[w]);
        t->index[0] += 64 * w * here + vvi_sum_of_places(row[w]);
        n += here;
    }
    if (!n)
        return;
    t->voxels += (uint64_t)n;
    t->cut |= first == 0 || last == o->n[0] - 1 || j == 0 || j == o->n[1] - 1 || k == 0 || k == o->n[2] - 1;
    t->index[1] += j * n;
    t->index[2] += k * n;
    vvi_bounds_add(&t->bounds, vv_affine_point(*m, vvi_vec((double)first, (double)j, (double)k)));
    vvi_bounds_add(&t->bounds, vv_affine_point(*m, vvi_vec((double)last, (double)j, (double)k)));
}

/* True: something was left out. */
static bool keep(uint64_t *row, size_t words, vvi_interval interval)
{
    uint64_t lost = 0;
    for (size_t w = 0; w < words; w++) {
        const uint64_t bits = vvi_interval_bits(interval, (int64_t)w);
        lost |= row[w] & ~bits;
        row[w] &= bits;
    }
    return lost != 0;
}

/* Rows with a voxel more at each end ------------------------------------------------------------------------------ */

static void pad_row(uint64_t *out, const uint64_t *row, const shared *s)
{
    const int64_t n = s->object->n[0];
    uint64_t carry = s->closed ? 0 : row[0] & 1;
    for (size_t w = 0; w < s->words; w++) {
        const uint64_t here = w < s->object->words ? row[w] : 0;
        out[w] = here << 1 | carry;
        carry = here >> 63;
    }
    if (!s->closed)
        out[(n + 1) >> 6] |= (row[(n - 1) >> 6] >> ((n - 1) & 63) & 1) << ((n + 1) & 63);
}

/* Slice k, of which -1 and nz are beyond the volume; its voxels are counted on the way where `counted`. */
static vv_status make_slice(uint64_t *out, worker *w, const shared *s, int64_t k, vvi_count_sums *counted)
{
    const vvi_object *o = s->object;
    const int64_t ny = o->n[1], nz = o->n[2], at = k < 0 ? 0 : k >= nz ? nz - 1 : k;
    if (at != k && s->closed) {
        memset(out, 0, (size_t)(ny + 2) * s->words * sizeof *out);
        return VV_OK;
    }
    const vv_status st = vvi_object_slice(w->raw, o, at);
    if (st != VV_OK)
        return st;
    for (int64_t j = 0; j < ny; j++) {
        uint64_t *row = w->raw + (size_t)j * o->words;
        const vvi_interval in = vvi_region_points(s->region, vvi_vec(0, 0, 0), j, at, 0, o->n[0]);
        bool cut = s->closed && keep(row, o->words, in);
        pad_row(out + (size_t)(j + 1) * s->words, row, s);
        cut |= keep(row, o->words, in);
        if (counted) {
            counted->cut |= cut;
            take_voxels(counted, o, row, j, k);
        }
    }
    for (int end = 0; end < 2; end++) {
        uint64_t *beyond = out + (end ? (size_t)(ny + 1) * s->words : 0);
        if (s->closed)
            memset(beyond, 0, s->words * sizeof *out);
        else
            memcpy(beyond, out + (size_t)(end ? ny : 1) * s->words, s->words * sizeof *out);
    }
    return VV_OK;
}

/* Patterns -------------------------------------------------------------------------------------------------------- */

static void take_cells(vvi_count_sums *t, const uint64_t *const row[4], size_t words, vvi_interval cells)
{
    for (int64_t w = 0; w + 1 < (int64_t)words; w++) {
        uint64_t c[8], any = 0, all = ~(uint64_t)0;
        for (int r = 0; r < 4; r++) {
            c[2 * r] = row[r][w];
            c[2 * r + 1] = row[r][w] >> 1 | row[r][w + 1] << 63;
            any |= c[2 * r] | c[2 * r + 1];
            all &= c[2 * r] & c[2 * r + 1];
        }
        const uint64_t mask = vvi_interval_bits(cells, w);
        t->pattern[255] += (uint64_t)__builtin_popcountll(all & mask);
        for (uint64_t active = any & ~all & mask; active; active &= active - 1) {
            const int b = __builtin_ctzll(active);
            unsigned p = 0;
            for (int i = 0; i < 8; i++)
                p |= (unsigned)(c[i] >> b & 1) << i;
            t->pattern[p]++;
        }
    }
}

/* Where the object is cut off ---------------------------------------------------------------------------------------
 */

/* Bits lo .. end - 1 that both rows have; in a padded row voxel i is bit i + 1. */
static uint64_t common(const uint64_t *a, const uint64_t *b, int64_t lo, int64_t end)
{
    const vvi_interval bits = {lo + 1, end + 1};
    uint64_t n = 0;
    for (int64_t w = bits.lo >> 6; lo < end && w <= bits.end >> 6; w++)
        n += (uint64_t)__builtin_popcountll(a[w] & b[w] & vvi_interval_bits(bits, w));
    return n;
}

/* Voxels of a row inside whose neighbours in another row go on outside. */
static uint64_t go_on(const uint64_t *row, vvi_interval in, const uint64_t *next, vvi_interval next_in)
{
    const int64_t before = in.end < next_in.lo ? in.end : next_in.lo, after = in.lo > next_in.end ? in.lo : next_in.end;
    return common(row, next, in.lo, before) + common(row, next, after > before ? after : before, in.end);
}

static vvi_interval inside(const shared *s, int64_t j, int64_t k)
{
    const int64_t *n = s->object->n;
    if (j < 0 || j >= n[1] || k < 0 || k >= n[2])
        return (vvi_interval){0, 0};
    return vvi_region_points(s->region, vvi_vec(0, 0, 0), j, k, 0, n[0]);
}

/* Across x and y in slice k, and across z to the slice above it. */
static void take_cuts(vvi_count_sums *t, const shared *s, uint64_t *const slice[2], int64_t k)
{
    for (int64_t j = 0; j < s->object->n[1]; j++) {
        const uint64_t *row = slice[0] + (size_t)(j + 1) * s->words, *above = slice[1] + (size_t)(j + 1) * s->words;
        const vvi_interval in = inside(s, j, k), up = inside(s, j, k + 1);
        t->cut_faces[2] += go_on(row, in, above, up) + go_on(above, up, row, in);
        if (in.lo >= in.end)
            continue;
        t->cut_faces[1] += go_on(row, in, row - s->words, inside(s, j - 1, k));
        t->cut_faces[1] += go_on(row, in, row + s->words, inside(s, j + 1, k));
        for (int end = 0; end < 2; end++) {
            const int64_t bit = end ? in.end : in.lo; /* the voxels on both sides of an end are this bit and the next */
            t->cut_faces[0] += row[bit >> 6] >> (bit & 63) & row[(bit + 1) >> 6] >> ((bit + 1) & 63) & 1;
        }
    }
}

/* Layer k of cells lies between slices k and k + 1; in a padded row cell i is bit i + 1. */
static void take_layer(vvi_count_sums *t, const shared *s, uint64_t *const slice[2], int64_t k)
{
    const int64_t nx = s->object->n[0];
    for (int64_t j = -1; j < s->object->n[1]; j++) {
        const uint64_t *const low = slice[0] + (size_t)(j + 1) * s->words;
        const uint64_t *const high = slice[1] + (size_t)(j + 1) * s->words;
        const uint64_t *const row[4] = {low, low + s->words, high, high + s->words};
        vvi_interval cells = {-1, nx};
        if (!s->closed && (j < 0 || k < 0))
            continue;
        if (!s->closed)
            cells =
                vvi_region_points(s->region, vvi_vec(VVI_CELL_MIDDLE, VVI_CELL_MIDDLE, VVI_CELL_MIDDLE), j, k, 0, nx);
        take_cells(t, row, s->words, (vvi_interval){cells.lo + 1, cells.end + 1});
    }
}

/* Layers -1 .. nz - 1; a slice is counted with the layer above it. */
static vv_status item(void *scratch, void *user, size_t index)
{
    worker *w = scratch;
    shared *s = user;
    vvi_count_sums *t = &s->part[index];
    const int64_t nz = s->object->n[2], first = (int64_t)index * VVI_MEASURE_LAYERS - 1;
    const int64_t end = first + VVI_MEASURE_LAYERS < nz ? first + VVI_MEASURE_LAYERS : nz;
    t->bounds = vvi_bounds_none();
    vv_status st = make_slice(w->slice[0], w, s, first, first >= 0 ? t : NULL);
    for (int64_t k = first; k < end && st == VV_OK; k++) {
        st = make_slice(w->slice[1], w, s, k + 1, k + 1 < end ? t : NULL);
        if (st == VV_OK)
            take_layer(t, s, w->slice, k);
        if (st == VV_OK && !s->closed)
            take_cuts(t, s, w->slice, k);
        uint64_t *const next = w->slice[0];
        w->slice[0] = w->slice[1];
        w->slice[1] = next;
    }
    return st;
}

static void join(vvi_count_sums *t, const vvi_count_sums *part)
{
    for (int p = 0; p < VVI_CONFIGURATIONS; p++)
        t->pattern[p] += part->pattern[p];
    t->voxels += part->voxels;
    t->cut |= part->cut;
    for (int a = 0; a < 3; a++) {
        t->index[a] += part->index[a];
        t->cut_faces[a] += part->cut_faces[a];
    }
    if (part->voxels) {
        vvi_bounds_add(&t->bounds, part->bounds.lo);
        vvi_bounds_add(&t->bounds, part->bounds.hi);
    }
}

vv_status vvi_count_object(vvi_count_sums *out, const vvi_object *object, const vvi_region *region, bool closed)
{
    static const vvi_work work = {.stage = "counting", .start = start, .item = item, .finish = finish};
    const size_t n = (size_t)object->n[2] / VVI_MEASURE_LAYERS + 1;
    shared s = {.object = object, .region = region, .closed = closed};
    s.words = (size_t)(object->n[0] + 2 + 63) / 64 + 1;
    s.part = vvi_alloc_zeroed(object->job, n * sizeof *s.part, VVI_MEM_SCRATCH);
    *out = (vvi_count_sums){.bounds = vvi_bounds_none()};
    if (!s.part)
        return vv_fail_memory(n * sizeof *s.part);
    const vv_status st = vvi_parallel_for(object->job, &work, &s, n);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        join(out, &s.part[i]);
    vvi_free(s.part);
    return st;
}
