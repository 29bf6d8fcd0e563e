/* What the numbers in names of one shape count: what the words before them say, or that one alone changes. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/slices/slices.h"
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define LONE_CHANNELS_MOST 16 /* "c001" to "c100" are slices of whatever c is */

typedef struct shape {
    const vvi_names *names;
    const vvi_slice *slice;
    size_t n;
    vvi_slice_runs runs; /* of the first name */
    bool varies[VVI_SLICE_RUNS];
    size_t n_varying;
    vvi_slice_role *role;
    vv_job *job;
} shape;

static void find_varying(shape *s)
{
    s->runs = vvi_slices_numbers(s->names->name[s->slice[0].name]);
    for (size_t i = 1; i < s->n; i++) {
        const vvi_slice_runs other = vvi_slices_numbers(s->names->name[s->slice[i].name]);
        for (size_t r = 0; r < s->runs.n && r < other.n; r++)
            s->varies[r] = s->varies[r] || other.run[r].value != s->runs.run[r].value;
    }
    for (size_t r = 0; r < s->runs.n; r++) {
        s->n_varying += s->varies[r];
        s->role[r] = s->varies[r] ? s->runs.run[r].role : VVI_SLICE_FIXED;
    }
}

static size_t count(const shape *s, vvi_slice_role role)
{
    size_t n = 0;
    for (size_t r = 0; r < s->runs.n; r++)
        n += s->varies[r] && s->role[r] == role;
    return n;
}

static void replace(shape *s, vvi_slice_role from, vvi_slice_role to)
{
    for (size_t r = 0; r < s->runs.n; r++)
        if (s->varies[r] && s->role[r] == from)
            s->role[r] = to;
}

/* One number alone, or none that changes: then it is that of the slice, else the last. */
static void set_lone(shape *s, vvi_series *series)
{
    size_t lone = SIZE_MAX;
    for (size_t r = 0; r < s->runs.n; r++)
        if (s->n_varying > 0 ? s->varies[r] : lone == SIZE_MAX || s->runs.run[lone].role != VVI_SLICE_Z)
            lone = r;
    if (lone == SIZE_MAX)
        return;
    const vvi_slice_run *run = &s->runs.run[lone];
    const bool known = s->n_varying > 0 && run->role <= VVI_SLICE_T && !run->weak &&
                       !(run->role == VVI_SLICE_C && run->n_word == 1 && s->n > LONE_CHANNELS_MOST);
    s->role[lone] = known ? run->role : VVI_SLICE_Z;
    series->loose = !known;
}

/* Of two numbers that say they count the same ("r1c02-ch1") the one with the longer word does, else the last. */
static void settle_doubles(shape *s)
{
    for (int role = VVI_SLICE_C; role <= VVI_SLICE_T; role++)
        for (size_t r = 0, best = SIZE_MAX; r < s->runs.n; r++) {
            if (!s->varies[r] || s->role[r] != (vvi_slice_role)role)
                continue;
            const bool better = best == SIZE_MAX || s->runs.run[r].n_word >= s->runs.run[best].n_word;
            if (better && best != SIZE_MAX)
                s->role[best] = VVI_SLICE_SERIES;
            else if (!better)
                s->role[r] = VVI_SLICE_SERIES;
            best = better ? r : best;
        }
}

static int by_value(const void *a, const void *b)
{
    const uint64_t p = *(const uint64_t *)a, q = *(const uint64_t *)b;
    return p < q ? -1 : p > q;
}

static vv_status is_distinct(bool *out, const shape *s, size_t run)
{
    uint64_t *value = vvi_alloc(s->job, s->n * sizeof *value, VVI_MEM_SCRATCH);
    if (!value)
        return vv_fail_memory(s->n * sizeof *value);
    for (size_t i = 0; i < s->n; i++) {
        const vvi_slice_runs runs = vvi_slices_numbers(s->names->name[s->slice[i].name]);
        value[i] = run < runs.n ? runs.run[run].value : 0;
    }
    qsort(value, s->n, sizeof *value, by_value);
    *out = true;
    for (size_t i = 1; i < s->n; i++)
        *out = *out && value[i] != value[i - 1];
    vvi_free(value);
    return VV_OK;
}

/* Several numbers without a known word, and none of slices: one that no two files share counts them (the others are
 * times of day or the like), else nobody can know. What is proposed then: the last counts slices, that before it time.
 */
static vv_status settle_unknown(shape *s, vvi_series *series)
{
    vv_status st = VV_OK;
    size_t counter = SIZE_MAX;
    for (size_t r = s->runs.n; r-- > 0 && counter == SIZE_MAX && st == VV_OK;) {
        bool distinct = false;
        if (s->varies[r] && s->role[r] == VVI_SLICE_UNKNOWN)
            st = is_distinct(&distinct, s, r);
        counter = distinct ? r : SIZE_MAX;
    }
    if (counter != SIZE_MAX) {
        replace(s, VVI_SLICE_UNKNOWN, VVI_SLICE_REST);
        replace(s, VVI_SLICE_SERIES, VVI_SLICE_REST);
        s->role[counter] = VVI_SLICE_Z;
        series->loose = true;
        return st;
    }
    bool time = count(s, VVI_SLICE_T) > 0, slices = false;
    for (size_t r = s->runs.n; r-- > 0;) {
        if (!s->varies[r] || s->role[r] != VVI_SLICE_UNKNOWN)
            continue;
        s->role[r] = !slices ? VVI_SLICE_Z : !time ? VVI_SLICE_T : VVI_SLICE_SERIES;
        time = time || slices;
        slices = true;
    }
    series->unclear = true;
    return st;
}

vv_status vvi_slices_roles(vvi_slice_role roles[VVI_SLICE_RUNS], vvi_series *series, const vvi_names *names,
                           const vvi_slice *slice, size_t n, vv_job *job)
{
    shape s = {.names = names, .slice = slice, .n = n, .job = job};
    s.role = roles;
    find_varying(&s);
    if (s.n_varying <= 1) {
        set_lone(&s, series);
        return VV_OK;
    }
    settle_doubles(&s);
    if (count(&s, VVI_SLICE_Z) > 0) {
        replace(&s, VVI_SLICE_UNKNOWN, VVI_SLICE_SERIES);
    } else if (count(&s, VVI_SLICE_UNKNOWN) == 1) {
        replace(&s, VVI_SLICE_UNKNOWN, VVI_SLICE_Z);
        series->loose = true;
    } else if (count(&s, VVI_SLICE_UNKNOWN) > 1) {
        return settle_unknown(&s, series);
    }
    return VV_OK;
}
