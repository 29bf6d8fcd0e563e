/* Occupancy of blocks, and the Chebyshev distance to the nearest occupied and the nearest empty one: in that metric all
 * 26 neighbours are one apart, so one forward and one backward pass over the 13 neighbours on each side gives exact
 * distances (Rosenfeld and Pfaltz 1966). */
#include "render/march/skip.h"
#include "core/job.h"
#include "core/memory.h"
#include <string.h>

enum { FARTHEST = VVI_SKIP_DISTANCE, GUARD = 64 };

static size_t row_at(const vvi_skip *s, int32_t j, int32_t k)
{
    return ((size_t)k * (size_t)s->n[1] + (size_t)j) * (size_t)s->n[0];
}

typedef struct occupancy {
    vvi_skip *skip;
    const vvi_minmax *minmax;
    vvi_visible_fn *visible;
    const void *user;
} occupancy;

/* Item: a slice of blocks. */
static vv_status find_occupied(void *scratch, void *shared, size_t index)
{
    const occupancy *o = shared;
    const size_t n = (size_t)o->skip->n[0] * (size_t)o->skip->n[1];
    (void)scratch;
    for (size_t i = index * n; i < (index + 1) * n; i++) {
        const float lo = o->minmax->lo[i], hi = o->minmax->hi[i];
        o->skip->reach[i] = lo <= hi && o->visible(o->user, lo, hi) ? VVI_SKIP_OCCUPIED : 0;
    }
    return VV_OK;
}

/* row = min(row, 1 + smallest of three neighbours along x in `from`), saturating. */
static void relax_row(uint8_t *restrict row, const uint8_t *restrict from, int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        uint8_t near = from[i];
        if (i > 0 && from[i - 1] < near)
            near = from[i - 1];
        if (i + 1 < n && from[i + 1] < near)
            near = from[i + 1];
        const uint8_t d = near == FARTHEST ? FARTHEST : (uint8_t)(near + 1);
        row[i] = d < row[i] ? d : row[i];
    }
}

/* A row from its four (of eight) finished neighbour rows on one side, then along itself. side: -1 forward, 1 backward.
 */
static void relax_from_side(uint8_t *distance, const vvi_skip *s, int32_t j, int32_t k, int32_t side)
{
    uint8_t *row = distance + row_at(s, j, k);
    for (int32_t dj = -1; dj <= 1; dj++) {
        const int32_t jj = j + dj, kk = k + side;
        if (kk >= 0 && kk < s->n[2] && jj >= 0 && jj < s->n[1])
            relax_row(row, distance + row_at(s, jj, kk), s->n[0]);
    }
    if (j + side >= 0 && j + side < s->n[1])
        relax_row(row, distance + row_at(s, j + side, k), s->n[0]);
    if (side < 0) {
        for (int32_t i = 1; i < s->n[0]; i++)
            row[i] = row[i - 1] + 1 < row[i] ? (uint8_t)(row[i - 1] + 1) : row[i];
    } else {
        for (int32_t i = s->n[0] - 2; i >= 0; i--)
            row[i] = row[i + 1] + 1 < row[i] ? (uint8_t)(row[i + 1] + 1) : row[i];
    }
}

static void find_distances(uint8_t *distance, const vvi_skip *s)
{
    for (int32_t k = 0; k < s->n[2]; k++)
        for (int32_t j = 0; j < s->n[1]; j++)
            relax_from_side(distance, s, j, k, -1);
    for (int32_t k = s->n[2] - 1; k >= 0; k--)
        for (int32_t j = s->n[1] - 1; j >= 0; j--)
            relax_from_side(distance, s, j, k, 1);
}

typedef struct reaching {
    vvi_skip *skip;
    uint8_t *distance[2]; /* of empty blocks to occupied ones, and the other way round */
    size_t n;
} reaching;

static uint8_t sort_of(const reaching *r, size_t block)
{
    return r->skip->reach[block] & VVI_SKIP_OCCUPIED;
}

/* Item: to every block of one sort, its distance to the other. */
static vv_status find_one_reach(void *scratch, void *shared, size_t index)
{
    const reaching *r = shared;
    const uint8_t sort = index ? VVI_SKIP_OCCUPIED : 0;
    (void)scratch;
    for (size_t i = 0; i < r->n; i++)
        r->distance[index][i] = sort_of(r, i) == sort ? FARTHEST : 0;
    find_distances(r->distance[index], r->skip);
    return VV_OK;
}

static vv_status find_reach(vvi_skip *s, size_t n, vv_job *job)
{
    static const vvi_work work = {.item = find_one_reach};
    uint8_t *both = vvi_alloc(job, 2 * n, VVI_MEM_SCRATCH);
    if (!both)
        return vv_fail_memory(2 * n);
    reaching r = {s, {both, both + n}, n};
    const vv_status st = vvi_parallel_for(job, &work, &r, 2);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        s->reach[i] |= r.distance[sort_of(&r, i) != 0][i];
    vvi_free(both);
    return st;
}

vv_status vvi_skip_build(vvi_skip **out, const vvi_minmax *minmax, vvi_visible_fn *visible, const void *user,
                         vv_job *job)
{
    *out = NULL;
    vvi_skip *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_DERIVED);
    if (!s)
        return vv_fail_memory(sizeof *s);
    memcpy(s->n, minmax->n, sizeof s->n);
    s->shift = minmax->shift;
    const size_t slice = (size_t)s->n[0] * (size_t)s->n[1], n = slice * (size_t)s->n[2];
    s->reach = vvi_alloc_zeroed(job, n + GUARD, VVI_MEM_DERIVED);
    if (!s->reach) {
        vvi_skip_free(s);
        return vv_fail_memory(n + GUARD);
    }
    occupancy o = {.skip = s, .minmax = minmax, .visible = visible, .user = user};
    const vvi_work work = {.item = find_occupied};
    vv_status st = vvi_parallel_for(job, &work, &o, (size_t)s->n[2]);
    for (size_t i = 0; i < n; i++)
        s->n_occupied += s->reach[i] != 0;
    if (st == VV_OK)
        st = find_reach(s, n, job);
    if (st != VV_OK) {
        vvi_skip_free(s);
        return st;
    }
    *out = s;
    return VV_OK;
}

void vvi_skip_free(void *skip)
{
    vvi_skip *s = skip;
    if (!s)
        return;
    vvi_free(s->reach);
    vvi_free(s);
}
