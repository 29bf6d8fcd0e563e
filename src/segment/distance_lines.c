#include "segment/distance_lines.h"
#include "core/job.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>

#define TILE 16  /* lines that are gathered at once: a line of the cache of each slice */
#define CHUNK 64 /* samples along x of an item of the envelopes */
#define ROWS 64  /* of an item along x */

typedef struct shared {
    float *out; /* squares until the last axis is done */
    int64_t n[3];
    double spacing[3];
    vvi_set_row *set;
    void *user;
    int axis;
    bool last;
    vv_job *job;
} shared;

/* Of a line: samples that are nearest to some place on it, and the line itself before and after. */
typedef struct scratch {
    double *square, *place, *lines;
    uint8_t *inside;
} scratch;

static void finish(void *scratch_in, void *user)
{
    scratch *s = scratch_in;
    (void)user;
    if (!s)
        return;
    vvi_free(s->square);
    vvi_free(s->place);
    vvi_free(s->lines);
    vvi_free(s->inside);
    vvi_free(s);
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t n = (size_t)s->n[s->axis], bytes = (n + 1) * sizeof(double);
    scratch *own = vvi_alloc_zeroed(s->job, sizeof *own, VVI_MEM_SCRATCH);
    (void)worker;
    if (!own)
        return vv_fail_memory(sizeof *own);
    own->square = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    own->place = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    own->lines = vvi_alloc(s->job, TILE * bytes, VVI_MEM_SCRATCH);
    own->inside = vvi_alloc(s->job, n + 1, VVI_MEM_SCRATCH);
    if (!own->square || !own->place || !own->lines || !own->inside) {
        finish(own, user);
        return vv_fail_memory((TILE + 2) * bytes);
    }
    *scratch_out = own;
    return VV_OK;
}

/* Along x --------------------------------------------------------------------------------------------------------- */

/* Steps to the nearest sample of the set, squared, in world units. */
static void square_row(float *out, const uint8_t *inside, int64_t n, double spacing, bool last)
{
    const int64_t none = INT64_MAX / 4;
    int64_t steps = none;
    for (int64_t i = 0; i < n; i++) {
        steps = inside[i] ? 0 : steps + 1;
        out[i] = steps >= none ? INFINITY : (float)steps;
    }
    steps = none;
    for (int64_t i = n - 1; i >= 0; i--) {
        steps = inside[i] ? 0 : steps + 1;
        const double nearest = steps < out[i] ? (double)steps : out[i], d = nearest * spacing;
        out[i] = (float)(last ? d : d * d);
    }
}

static vv_status rows_item(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    scratch *own = scratch_in;
    const size_t n = (size_t)s->n[0], n_rows = (size_t)(s->n[1] * s->n[2]);
    const size_t first = index * ROWS, end = first + ROWS < n_rows ? first + ROWS : n_rows;
    for (size_t row = first; row < end; row++) {
        float *out = s->out + row * n;
        s->set(own->inside, row, s->user);
        if (memchr(own->inside, 1, n))
            square_row(out, own->inside, (int64_t)n, s->spacing[0], s->last);
        else
            for (size_t i = 0; i < n; i++)
                out[i] = INFINITY;
    }
    return vvi_job_poll(s->job);
}

/* Envelopes ------------------------------------------------------------------------------------------------------- */

/* Parabolas square + (x - place)^2: whether the middle one of three, whose places rise, is nowhere below both others.
 */
static bool is_hidden(const double *square, const double *place, double next_square, double next_place)
{
    const double a = place[1] - place[0], b = next_place - place[1], c = a + b;
    return c * square[1] - b * square[0] - a * next_square - a * b * c > 0;
}

static void envelope(double *line, scratch *own, int64_t n, double spacing)
{
    double *square = own->square, *place = own->place;
    int64_t last = -1;
    for (int64_t i = 0; i < n; i++) {
        const double here = (double)i * spacing;
        if (line[i] == INFINITY)
            continue;
        while (last >= 1 && is_hidden(square + last - 1, place + last - 1, line[i], here))
            last--;
        square[++last] = line[i];
        place[last] = here;
    }
    if (last < 0)
        return;
    for (int64_t i = 0, at = 0; i < n; i++) {
        const double here = (double)i * spacing;
        double d = square[at] + (here - place[at]) * (here - place[at]);
        for (; at < last; at++) {
            const double next = square[at + 1] + (here - place[at + 1]) * (here - place[at + 1]);
            if (next > d)
                break;
            d = next;
        }
        line[i] = d;
    }
}

/* Lines from `first` on, `count` of them beside each other. */
static void tile(float *first, int64_t stride, int64_t count, const shared *s, scratch *own)
{
    const int64_t n = s->n[s->axis];
    for (int64_t i = 0; i < n; i++)
        for (int64_t l = 0; l < count; l++)
            own->lines[l * n + i] = (double)first[i * stride + l];
    for (int64_t l = 0; l < count; l++)
        envelope(own->lines + l * n, own, n, s->spacing[s->axis]);
    for (int64_t i = 0; i < n; i++)
        for (int64_t l = 0; l < count; l++) {
            const double d = own->lines[l * n + i];
            first[i * stride + l] = (float)(s->last ? sqrt(d) : d);
        }
}

static vv_status lines_item(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    const int64_t chunks = (s->n[0] - 1) / CHUNK + 1, other = (int64_t)index / chunks;
    const int64_t x = (int64_t)index % chunks * CHUNK, end = x + CHUNK < s->n[0] ? x + CHUNK : s->n[0];
    const int64_t across = s->n[0] * s->n[1];
    float *first = s->out + other * (s->axis == 1 ? across : s->n[0]);
    for (int64_t at = x; at < end; at += TILE)
        tile(first + at, s->axis == 1 ? s->n[0] : across, end - at < TILE ? end - at : TILE, s, scratch_in);
    return vvi_job_poll(s->job);
}

int vvi_distances_last(const int64_t n[3])
{
    return n[2] > 1 ? 2 : n[1] > 1 ? 1 : 0;
}

/* NOLINTNEXTLINE(readability-non-const-parameter): the items write there */
vv_status vvi_distances_along(float *out, const int64_t n[3], const double spacing[3], const int axes[2], int last,
                              vvi_set_row *set, void *user, vv_job *job)
{
    shared s = {.out = out, .set = set, .user = user, .axis = axes[0], .job = job};
    const size_t chunks = (size_t)((n[0] - 1) / CHUNK + 1);
    const size_t items[3] = {(size_t)((n[1] * n[2] - 1) / ROWS + 1), chunks * (size_t)n[2], chunks * (size_t)n[1]};
    size_t all = 0, done = 0;
    vv_status st = VV_OK;
    memcpy(s.n, n, sizeof s.n);
    memcpy(s.spacing, spacing, sizeof s.spacing);
    for (int a = axes[0]; a < axes[1]; a++)
        all += a == 0 || n[a] > 1 ? items[a] : 0;
    for (; s.axis < axes[1] && st == VV_OK; s.axis++) {
        if (s.axis > 0 && n[s.axis] == 1)
            continue;
        const vvi_work work = {.stage = "distance",
                               .start = start,
                               .item = s.axis ? lines_item : rows_item,
                               .finish = finish,
                               .n_before = done,
                               .n_after = all - done - items[s.axis]};
        s.last = s.axis == last;
        st = vvi_parallel_for(job, &work, &s, items[s.axis]);
        done += items[s.axis];
    }
    return st;
}

vv_status vvi_distances(float *out, const int64_t n[3], const double spacing[3], vvi_set_row *set, void *user,
                        vv_job *job)
{
    return vvi_distances_along(out, n, spacing, (const int[2]){0, 3}, vvi_distances_last(n), set, user, job);
}
