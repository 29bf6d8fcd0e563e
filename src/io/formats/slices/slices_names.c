/* Series of files by their names: those that differ in numbers of channels, slices and time steps alone. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/slices/slices.h"
#include "io/images/tiff_image.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

bool vvi_slices_is_picture(const char *name)
{
    static const char *const suffixes[] = {".tif", ".tiff", ".png", ".jpg", ".jpeg", NULL};
    const size_t n = strlen(name);
    for (const char *const *s = suffixes; *s; s++)
        if (n > strlen(*s) && strcasecmp(name + n - strlen(*s), *s) == 0 && name[0] != '.')
            return true;
    return false;
}

bool vvi_slices_is_made(const vv_source *folder, const char *name, vv_job *job)
{
    static const char key[] = "VolVis:Scene";
    static const uint8_t png[4] = {0x89, 'P', 'N', 'G'};
    vv_source *source = NULL;
    size_t n = 0;
    bool made = false;
    if (vvi_source_open_beside(&source, folder, name, job) == VV_OK) {
        const uint8_t *head = vvi_source_peek(source, 1 << 14, &n); /* texts stand before the picture */
        made = head && n > sizeof png &&
               ((memcmp(head, png, sizeof png) == 0 && memmem(head, n, key, sizeof key - 1)) ||
                vvi_tiff_image_probe(head, n, name) == 2);
    }
    vvi_source_close(source);
    return made;
}

size_t vvi_slices_count(size_t *any_out, const vvi_names *names, const vv_source *folder, vv_job *job)
{
    size_t n = 0, looked = 0, made = 0;
    for (size_t i = 0; i < names->n; i++) {
        if (strchr(names->name[i], '/') || !vvi_slices_is_picture(names->name[i]))
            continue;
        if (looked < VVI_SLICES_LOOKED) {
            looked++;
            if (vvi_slices_is_made(folder, names->name[i], job) ||
                vvi_slices_is_stack(names, names->name[i], folder, job)) {
                made++;
                continue;
            }
        }
        *any_out = i;
        n++;
    }
    if (n + made <= VVI_SLICES_LOOKED)
        return n;
    return made == looked ? 0 : n + made; /* those that were not looked into are of the same kind */
}

/* Keys --------------------------------------------------------------------------------------------------------------
 */

/* The name with marks for its numbers, by role; roles NULL: '/' for all, which no name has. Yours to vvi_free(). */
static char *key_of(const char *name, const vvi_slice_runs *runs, const vvi_slice_role *roles, vv_job *job)
{
    static const char *const marks[] = {"{c}", "{z}", "{t}", NULL, NULL, NULL, "*"};
    char *key = vvi_alloc(job, strlen(name) + 3 * VVI_SLICE_RUNS + 1, VVI_MEM_SCRATCH);
    size_t to = 0, i = 0;
    for (size_t r = 0; key && r < runs->n; r++) {
        const vvi_slice_run *run = &runs->run[r];
        const char *mark = roles ? marks[roles[r]] : "/";
        memcpy(key + to, name + i, run->at - i);
        to += run->at - i;
        i = run->at;
        if (mark) {
            for (const char *at = mark; *at; at++)
                key[to++] = *at;
            i += run->n;
        }
    }
    if (key)
        memcpy(key + to, name + i, strlen(name + i) + 1);
    return key;
}

typedef struct keyed {
    char *key;
    size_t slice;
} keyed;

static int by_key(const void *a, const void *b)
{
    const keyed *p = a, *q = b;
    const int order = strcmp(p->key, q->key);
    return order != 0 ? order : p->slice < q->slice ? -1 : 1;
}

static void forget_series(vvi_slices *s)
{
    for (size_t i = 0; i < s->n_series; i++)
        vvi_free(s->series[i].key);
    vvi_free(s->series);
    s->series = NULL;
    s->n_series = 0;
}

static int by_series(const void *a, const void *b)
{
    const vvi_slice *p = a, *q = b;
    if (p->series != q->series)
        return p->series < q->series ? -1 : 1;
    return p->name < q->name ? -1 : p->name > q->name;
}

static int by_numbers(const void *a, const void *b)
{
    const vvi_slice *p = a, *q = b;
    for (int role = VVI_SLICE_T; p->series == q->series && role >= 0; role--) {
        if (p->number[role] != q->number[role])
            return p->number[role] < q->number[role] ? -1 : 1;
    }
    return by_series(a, b);
}

/* Series of slices with the same key, in the order of the first of each. Takes the keys. */
static vv_status group(vvi_slices *s, keyed *keys, vv_job *job)
{
    size_t n = 0, *head = vvi_alloc(job, (s->n + 1) * sizeof *head, VVI_MEM_SCRATCH);
    qsort(keys, s->n, sizeof *keys, by_key);
    for (size_t i = 0; i < s->n && head; i++) {
        const bool same = i > 0 && strcmp(keys[i].key, keys[i - 1].key) == 0;
        head[keys[i].slice] = same ? head[keys[i - 1].slice] : keys[i].slice;
        n += !same;
    }
    s->series = head ? vvi_alloc_zeroed(job, n * sizeof *s->series, VVI_MEM_SCRATCH) : NULL;
    for (size_t i = 0; i < s->n && s->series; i++) {
        s->slice[i].series = head[i] == i ? (uint32_t)s->n_series++ : s->slice[head[i]].series;
        s->series[s->slice[i].series].n++;
    }
    for (size_t i = 0; i < s->n; i++)
        if (s->series && head[keys[i].slice] == keys[i].slice)
            s->series[s->slice[keys[i].slice].series].key = keys[i].key;
        else
            vvi_free(keys[i].key);
    vvi_free(head);
    if (!s->series)
        return vv_fail_memory((s->n + 1) * (sizeof *head + sizeof *s->series));
    for (size_t i = 0, at = 0; i < s->n_series; at += s->series[i++].n)
        s->series[i].first = at;
    qsort(s->slice, s->n, sizeof *s->slice, by_series);
    return VV_OK;
}

/* Shapes and series -------------------------------------------------------------------------------------------------
 */

static vv_status group_shapes(vvi_slices *s, keyed *keys, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < s->n; i++) {
        const char *name = s->names.name[s->slice[i].name];
        const vvi_slice_runs runs = vvi_slices_numbers(name);
        keys[i] = (keyed){st == VV_OK ? key_of(name, &runs, NULL, job) : NULL, i};
        if (!keys[i].key)
            st = vv_fail_memory(strlen(name) + 1);
    }
    for (size_t i = 0; i < s->n && st != VV_OK; i++)
        vvi_free(keys[i].key);
    return st == VV_OK ? group(s, keys, job) : st;
}

/* What a channel is called: letters that follow its number, or the number with the word before it. */
static void name_channel(vvi_slice *slice, const char *name, const vvi_slice_run *run)
{
    const size_t digits = strspn(name + run->at, "0123456789");
    const bool letters = run->n > digits;
    slice->at = letters ? run->at + digits : run->at - (run->role == VVI_SLICE_C ? run->n_word : 0);
    slice->n = run->at + run->n - slice->at;
}

static void take_numbers(vvi_slice *slice, vvi_series *series, const char *name, const vvi_slice_runs *runs,
                         const vvi_slice_role *roles)
{
    for (size_t r = 0; r < runs->n; r++) {
        const vvi_slice_role role = roles[r];
        if (role > VVI_SLICE_T)
            continue;
        slice->number[role] = runs->run[r].value;
        series->counts[role] = true;
        if (role == VVI_SLICE_C)
            name_channel(slice, name, &runs->run[r]);
    }
}

/* Keys of the slices of one shape, where its numbers count what `roles` says. */
static vv_status key_shape(keyed *keys, vvi_slices *s, const vvi_series *shape, vvi_series *about, vv_job *job)
{
    vvi_slice_role roles[VVI_SLICE_RUNS];
    vv_status st = vvi_slices_roles(roles, about, &s->names, s->slice + shape->first, shape->n, job);
    for (size_t i = shape->first; i < shape->first + shape->n; i++) {
        const char *name = s->names.name[s->slice[i].name];
        const vvi_slice_runs runs = vvi_slices_numbers(name);
        keys[i] = (keyed){st == VV_OK ? key_of(name, &runs, roles, job) : NULL, i};
        if (keys[i].key)
            take_numbers(&s->slice[i], about, name, &runs, roles);
        else if (st == VV_OK)
            st = vv_fail_memory(strlen(name) + 1);
    }
    return st;
}

/* From shapes to series: `about` says of each shape what its series are like. */
static vv_status split_shapes(vvi_slices *s, keyed *keys, vv_job *job)
{
    const size_t n_shapes = s->n_series;
    vv_status st = VV_OK;
    vvi_series *about = vvi_alloc_zeroed(job, n_shapes * sizeof *about, VVI_MEM_SCRATCH);
    uint32_t *shape_of = vvi_alloc(job, s->names.n * sizeof *shape_of, VVI_MEM_SCRATCH);
    if (!about || !shape_of)
        st = vv_fail_memory(n_shapes * sizeof *about + s->names.n * sizeof *shape_of);
    memset(keys, 0, s->n * sizeof *keys);
    for (size_t i = 0; i < n_shapes && st == VV_OK; i++)
        st = key_shape(keys, s, &s->series[i], &about[i], job);
    for (size_t i = 0; i < s->n && st == VV_OK; i++)
        shape_of[s->slice[i].name] = s->slice[i].series;
    forget_series(s);
    for (size_t i = 0; i < s->n && st != VV_OK; i++)
        vvi_free(keys[i].key);
    if (st == VV_OK)
        st = group(s, keys, job);
    for (size_t i = 0; i < s->n_series && st == VV_OK; i++) {
        const vvi_series *from = &about[shape_of[s->slice[s->series[i].first].name]];
        memcpy(s->series[i].counts, from->counts, sizeof from->counts);
        s->series[i].loose = from->loose;
        s->series[i].unclear = from->unclear;
    }
    vvi_free(shape_of);
    vvi_free(about);
    return st;
}

/* Patterns ----------------------------------------------------------------------------------------------------------
 */

/* The roles of a pattern's numbers: a number without a known word counts slices. */
static vv_status settle(vvi_slice_role roles[VVI_SLICE_RUNS], vvi_series *series, const vvi_slice_runs *runs,
                        const char *pattern)
{
    int n[3] = {0};
    for (size_t r = 0; r < runs->n; r++) {
        const bool unknown = runs->run[r].role > VVI_SLICE_T;
        roles[r] = unknown ? VVI_SLICE_Z : runs->run[r].role;
        series->loose = series->loose || unknown;
        if (++n[roles[r]] > 1)
            return vv_fail(VV_E_ARGUMENT,
                           "'%.100s' has two numbers that count %s; {z}, {c} and {t} say what one counts, and * stands "
                           "for numbers that count nothing",
                           pattern,
                           roles[r] == VVI_SLICE_C   ? "channels"
                           : roles[r] == VVI_SLICE_Z ? "slices"
                                                     : "time steps");
    }
    return VV_OK;
}

typedef struct word {
    const char *text;
    size_t n, slice;
} word;

static int by_text(const void *a, const void *b)
{
    const word *p = a, *q = b;
    const int order = strncmp(p->text, q->text, p->n < q->n ? p->n : q->n);
    return order != 0 ? order : p->n < q->n ? -1 : p->n > q->n;
}

/* Channels that have words instead of numbers are numbered as the words are sorted. */
static vv_status number_words(vvi_slices *s, vv_job *job)
{
    word *words = vvi_alloc(job, s->n * sizeof *words, VVI_MEM_SCRATCH);
    if (!words)
        return vv_fail_memory(s->n * sizeof *words);
    for (size_t i = 0; i < s->n; i++)
        words[i] = (word){s->names.name[s->slice[i].name] + s->slice[i].at, s->slice[i].n, i};
    qsort(words, s->n, sizeof *words, by_text);
    uint64_t number = 0;
    for (size_t i = 0; i < s->n; i++) {
        number += i > 0 && by_text(&words[i - 1], &words[i]) != 0;
        s->slice[words[i].slice].number[VVI_SLICE_C] = number;
    }
    vvi_free(words);
    return VV_OK;
}

/* One series of all files that fit; their numbers are where the pattern has them. */
static vv_status take_pattern(vvi_slices *s, const char *pattern, vv_job *job)
{
    const size_t n_key = strlen(pattern) + 1;
    vvi_slice_role roles[VVI_SLICE_RUNS];
    bool words = false;
    s->series = vvi_alloc_zeroed(job, sizeof *s->series, VVI_MEM_SCRATCH);
    char *key = s->series ? vvi_alloc(job, n_key, VVI_MEM_SCRATCH) : NULL;
    if (!key)
        return vv_fail_memory(n_key);
    memcpy(key, pattern, n_key);
    s->series[s->n_series++] = (vvi_series){.key = key, .n = s->n};
    for (size_t i = 0; i < s->n; i++) {
        vvi_slice_runs runs;
        const char *name = s->names.name[s->slice[i].name];
        vvi_slices_match(&runs, pattern, name);
        vv_status st = settle(roles, &s->series[0], &runs, pattern);
        if (st != VV_OK)
            return st;
        take_numbers(&s->slice[i], &s->series[0], name, &runs, roles);
        for (size_t r = 0; r < runs.n; r++)
            words = words || name[runs.run[r].at] < '0' || name[runs.run[r].at] > '9';
    }
    return words ? number_words(s, job) : VV_OK;
}

/* ------------------------------------------------------------------------------------------------------------------ */

/* Which of the folder's names are slices: a few pictures are looked into, of many a picture by VolVis is one series. */
static bool is_slice(const vvi_slices *s, size_t i, size_t n_pictures, const vv_source *folder, vv_job *job)
{
    return vvi_slices_is_picture(s->names.name[i]) &&
           (n_pictures > VVI_SLICES_LOOKED || !vvi_slices_is_made(folder, s->names.name[i], job));
}

static vv_status list(vvi_slices *s, vv_source *folder, const char *pattern, vv_job *job)
{
    vvi_slice_runs runs;
    vv_status st = vvi_source_list(&s->names, folder, NULL, false, job);
    if (st != VV_OK)
        return st;
    size_t n_pictures = 0;
    for (size_t i = 0; i < s->names.n; i++)
        n_pictures += vvi_slices_is_picture(s->names.name[i]);
    s->slice = vvi_alloc(job, (s->names.n + 1) * sizeof *s->slice, VVI_MEM_SCRATCH);
    if (!s->slice)
        return vv_fail_memory((s->names.n + 1) * sizeof *s->slice);
    for (size_t i = 0; i < s->names.n && st == VV_OK; i++) {
        const char *name = s->names.name[i];
        const bool picture =
            is_slice(s, i, n_pictures, folder, job) && (pattern || !vvi_slices_is_stack(&s->names, name, folder, job));
        s->n_pictures += picture;
        s->n_foreign += !picture && name[0] != '.';
        if (picture && (!pattern || vvi_slices_match(&runs, pattern, name)))
            s->slice[s->n++] = (vvi_slice){.name = i};
        if (i % 1024 == 0)
            st = vvi_job_poll(job);
    }
    return st;
}

vv_status vvi_slices_find(vvi_slices *s, vv_source *folder, const char *pattern, vv_job *job)
{
    vv_status st = list(s, folder, pattern, job);
    if (st != VV_OK || s->n == 0)
        return st;
    if (pattern && vvi_slices_counts(pattern)) {
        st = take_pattern(s, pattern, job);
    } else {
        keyed *keys = vvi_alloc(job, s->n * sizeof *keys, VVI_MEM_SCRATCH);
        if (!keys)
            return vv_fail_memory(s->n * sizeof *keys);
        if ((st = group_shapes(s, keys, job)) == VV_OK)
            st = split_shapes(s, keys, job);
        vvi_free(keys);
    }
    if (st == VV_OK)
        qsort(s->slice, s->n, sizeof *s->slice, by_numbers);
    return st;
}

void vvi_slices_free(vvi_slices *s)
{
    forget_series(s);
    vvi_free(s->slice);
    vvi_names_free(&s->names);
    *s = (vvi_slices){0};
}
