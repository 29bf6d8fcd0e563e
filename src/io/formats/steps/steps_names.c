/* Which files of a folder are called as time steps of one data set are: their names differ in one number. */
#include "core/job.h"
#include "core/memory.h"
#include "io/format.h"
#include "io/formats/slices/slices.h"
#include "io/formats/steps/steps.h"
#include "registry.h"
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define RUNS_MOST 16

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* A run of digits. */
typedef struct run {
    size_t at, n;
    uint64_t value;
} run;

static size_t find_runs(run runs[RUNS_MOST], const char *name)
{
    size_t n = 0;
    for (size_t i = 0; name[i] && n < RUNS_MOST; i++) {
        if (!is_digit(name[i]))
            continue;
        run *r = &runs[n++];
        *r = (run){.at = i};
        for (; is_digit(name[i]); i++, r->n++)
            r->value = r->value < UINT64_MAX / 16 ? r->value * 10 + (uint64_t)(name[i] - '0') : r->value;
        i--;
    }
    return n;
}

/* Which files are volumes ------------------------------------------------------------------------------------------ */

static bool is_volume(const char *name, const vv_registry *registry)
{
    size_t n;
    vvi_path_coding(name, &n);
    if (name[0] == '.' || vvi_slices_is_picture(name) || vvi_format_has_suffix(&vvi_format_pvd, name, n))
        return false;
    for (const vv_format *const *f = registry->formats; *f; f++)
        if ((*f)->read && vvi_format_has_suffix(*f, name, n))
            return true;
    return false;
}

static int by_text(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

bool vvi_steps_has_header(const char *name, const vvi_names *sorted)
{
    static const char *const samples[] = {".raw", ".img", ".h5", NULL};
    static const char *const headers[] = {".nhdr", ".mhd", ".hdr", ".vvh", ".dat", ".xml", ".hdr.gz", NULL};
    char header[512];
    size_t n;
    vvi_path_coding(name, &n);
    bool data = false;
    for (const char *const *s = samples; *s && !data; s++) {
        const size_t m = strlen(*s);
        data = n > m && n - m + 8 < sizeof header && strncasecmp(name + n - m, *s, m) == 0;
        n -= data ? m : 0;
    }
    for (const char *const *h = headers; data && *h; h++) {
        memcpy(header, name, n);
        memcpy(header + n, *h, strlen(*h) + 1);
        const char *key = header;
        if (bsearch(&key, sorted->name, sorted->n, sizeof *sorted->name, by_text))
            return true;
    }
    return false;
}

/* The number that counts, of a name that fits the pattern. */
static bool fits(vvi_steps_entry *entry, const char *pattern, const char *name)
{
    vvi_slice_runs runs = {.n = 0};
    if (!pattern)
        return true;
    if (!vvi_slices_match(&runs, pattern, name) || (vvi_slices_counts(pattern) && runs.n != 1))
        return false;
    if (runs.n == 1)
        entry->number = runs.run[0].value;
    return runs.n == 0 || runs.run[0].role == VVI_SLICE_T || runs.run[0].role == VVI_SLICE_UNKNOWN;
}

static vv_status choose_files(vvi_steps_groups *g, const char *pattern, vv_job *job)
{
    vvi_names sorted = {.n = g->names.n};
    if (g->names.n == 0)
        return VV_OK;
    g->entry = vvi_alloc_zeroed(job, g->names.n * sizeof *g->entry, VVI_MEM_SCRATCH);
    sorted.name = vvi_alloc(job, g->names.n * sizeof *sorted.name, VVI_MEM_SCRATCH);
    if (!g->entry || !sorted.name) {
        vvi_free(sorted.name);
        return vv_fail_memory(g->names.n * sizeof *g->entry);
    }
    memcpy(sorted.name, g->names.name, g->names.n * sizeof *sorted.name);
    qsort(sorted.name, sorted.n, sizeof *sorted.name, by_text);
    for (size_t i = 0; i < g->names.n; i++) {
        vvi_steps_entry entry = {.name = i};
        const char *name = g->names.name[i];
        if (is_volume(name, vvi_job_registry(job)) && !vvi_steps_has_header(name, &sorted) &&
            fits(&entry, pattern, name))
            g->entry[g->n++] = entry;
    }
    vvi_free(sorted.name);
    return VV_OK;
}

/* Groups ------------------------------------------------------------------------------------------------------------
 */

/* Whether names differ in the numbers of some runs alone; varies is set for each. */
static bool same_shape(bool varies[RUNS_MOST], const char *a, const char *b)
{
    run of_a[RUNS_MOST], of_b[RUNS_MOST];
    const size_t n = find_runs(of_a, a);
    size_t at_a = 0, at_b = 0;
    if (n != find_runs(of_b, b))
        return false;
    for (size_t r = 0; r < n; r++) {
        if (of_a[r].at - at_a != of_b[r].at - at_b || memcmp(a + at_a, b + at_b, of_a[r].at - at_a) != 0)
            return false;
        at_a = of_a[r].at + of_a[r].n;
        at_b = of_b[r].at + of_b[r].n;
    }
    if (strcmp(a + at_a, b + at_b) != 0)
        return false;
    for (size_t r = 0; r < n; r++)
        varies[r] = varies[r] || of_a[r].value != of_b[r].value;
    return true;
}

/* Digits compare as one letter: names of one shape come together. */
static int by_shape(const char *a, const char *b)
{
    while (*a && *b) {
        const char p = is_digit(*a) ? '0' : *a, q = is_digit(*b) ? '0' : *b;
        if (p != q)
            return (unsigned char)p < (unsigned char)q ? -1 : 1;
        for (a++; p == '0' && is_digit(*a);)
            a++;
        for (b++; q == '0' && is_digit(*b);)
            b++;
    }
    return (unsigned char)*a - (unsigned char)*b;
}

typedef struct named {
    const char *name;
    vvi_steps_entry entry;
} named;

static int by_shape_and_place(const void *a, const void *b)
{
    const named *p = a, *q = b;
    const int order = by_shape(p->name, q->name);
    return order ? order : p->entry.name < q->entry.name ? -1 : 1;
}

static int by_number(const void *a, const void *b)
{
    const vvi_steps_entry *p = a, *q = b;
    return p->number != q->number ? (p->number < q->number ? -1 : 1) : p->name < q->name ? -1 : 1;
}

/* What words before numbers say of them that are no time steps: people, and what microscopes number. */
static bool counts_others(const char *name, const run *r)
{
    static const char *const words[] = {"sub", "subj", "subject", "pat", "patient", "case", "ses", "session", NULL};
    const vvi_slice_run slice = vvi_slices_number(name, r->at);
    size_t begin, end = r->at;
    if (!slice.weak && slice.role != VVI_SLICE_UNKNOWN && slice.role != VVI_SLICE_T)
        return true;
    if (end > 0 && strchr("_- =", name[end - 1]))
        end--;
    for (begin = end; begin > 0 && strchr("_- =.", name[begin - 1]) == NULL && !is_digit(name[begin - 1]);)
        begin--;
    for (const char *const *w = words; *w; w++)
        if (strlen(*w) == end - begin && strncasecmp(*w, name + begin, end - begin) == 0)
            return true;
    return false;
}

/* The name with {t} for the number that counts, the last that changes, and * for others that change. */
static vv_status name_group(vvi_steps_group *group, const char *name, const bool varies[RUNS_MOST], size_t counter,
                            vv_job *job)
{
    run runs[RUNS_MOST];
    const size_t n = find_runs(runs, name), room = strlen(name) + 3 * (size_t)RUNS_MOST + 1;
    size_t from = 0, to = 0;
    char *key = group->key = vvi_alloc(job, room, VVI_MEM_SCRATCH);
    if (!key)
        return vv_fail_memory(room);
    for (size_t r = 0; r < n; r++) {
        if (!varies[r])
            continue;
        memcpy(key + to, name + from, runs[r].at - from);
        to += runs[r].at - from;
        memcpy(key + to, r == counter ? "{t}" : "*", r == counter ? 3 : 1);
        to += r == counter ? 3 : 1;
        from = runs[r].at + runs[r].n;
    }
    memcpy(key + to, name + from, strlen(name + from) + 1);
    return VV_OK;
}

/* Entries [first, first + n), all of one shape. */
static vv_status add_group(vvi_steps_groups *g, size_t first, size_t n, const bool varies[RUNS_MOST], vv_job *job)
{
    vvi_steps_group *group = &g->group[g->n_groups++];
    const char *name = g->names.name[g->entry[first].name];
    run runs[RUNS_MOST];
    size_t varying = 0, counter = RUNS_MOST;
    for (size_t r = 0; r < RUNS_MOST; r++)
        if (varies[r]) {
            varying++;
            counter = r;
        }
    *group = (vvi_steps_group){.first = first, .n = n};
    for (size_t i = first; i < first + n && varying > 0; i++)
        if (find_runs(runs, g->names.name[g->entry[i].name]) > counter)
            g->entry[i].number = runs[counter].value;
    qsort(g->entry + first, n, sizeof *g->entry, by_number);
    find_runs(runs, name);
    if (varying > 0)
        group->sure = varying > 1 || counts_others(name, &runs[counter]) ? VVI_STEPS_UNCLEAR : VVI_STEPS_SURE;
    return name_group(group, name, varies, counter, job);
}

static vv_status group_files(vvi_steps_groups *g, vv_job *job)
{
    named *list = vvi_alloc(job, g->n * sizeof *list, VVI_MEM_SCRATCH);
    vv_status st = VV_OK;
    if (!list)
        return vv_fail_memory(g->n * sizeof *list);
    for (size_t i = 0; i < g->n; i++)
        list[i] = (named){g->names.name[g->entry[i].name], g->entry[i]};
    qsort(list, g->n, sizeof *list, by_shape_and_place);
    for (size_t i = 0; i < g->n; i++)
        g->entry[i] = list[i].entry;
    for (size_t i = 0, n; i < g->n && st == VV_OK; i += n) {
        bool varies[RUNS_MOST] = {false};
        for (n = 1; i + n < g->n && same_shape(varies, list[i].name, list[i + n].name);)
            n++;
        st = add_group(g, i, n, varies, job);
    }
    vvi_free(list);
    return st;
}

/* All that fit are one group: the pattern says so. */
static vv_status take_all(vvi_steps_groups *g, const char *pattern, vv_job *job)
{
    const size_t n = strlen(pattern) + 1;
    g->n_groups = 1;
    g->group[0] = (vvi_steps_group){.n = g->n, .sure = VVI_STEPS_SURE, .key = vvi_alloc(job, n, VVI_MEM_SCRATCH)};
    if (!g->group[0].key)
        return vv_fail_memory(n);
    memcpy(g->group[0].key, pattern, n);
    qsort(g->entry, g->n, sizeof *g->entry, by_number);
    return VV_OK;
}

vv_status vvi_steps_find(vvi_steps_groups *out, const vv_source *folder, const char *pattern, vv_job *job)
{
    *out = (vvi_steps_groups){0};
    vv_status st = vvi_source_list(&out->names, folder, NULL, false, job);
    if (st != VV_OK || (st = choose_files(out, pattern, job)) != VV_OK || out->n == 0)
        return st;
    out->group = vvi_alloc_zeroed(job, out->n * sizeof *out->group, VVI_MEM_SCRATCH);
    if (!out->group)
        return vv_fail_memory(out->n * sizeof *out->group);
    return pattern && vvi_slices_counts(pattern) ? take_all(out, pattern, job) : group_files(out, job);
}

void vvi_steps_groups_free(vvi_steps_groups *groups)
{
    vvi_names_free(&groups->names);
    for (size_t i = 0; i < groups->n_groups; i++)
        vvi_free(groups->group[i].key);
    vvi_free(groups->group);
    vvi_free(groups->entry);
    *groups = (vvi_steps_groups){0};
}

bool vvi_steps_split(size_t *n_out, const char **inner_out, const vv_source *folder, const char *part, vv_job *job)
{
    char pattern[512];
    for (size_t n = strlen(part); n > 0; n--) {
        vvi_steps_groups groups;
        if ((part[n] && part[n] != ':') || n >= sizeof pattern)
            continue;
        memcpy(pattern, part, n);
        pattern[n] = 0;
        if (!vvi_slices_counts(pattern) && !strpbrk(pattern, "*?"))
            return false;
        const bool found = vvi_steps_find(&groups, folder, pattern, job) == VV_OK && groups.n > 0;
        vvi_steps_groups_free(&groups);
        *n_out = n;
        *inner_out = part[n] ? part + n + 1 : NULL;
        if (found)
            return true;
    }
    return false;
}
