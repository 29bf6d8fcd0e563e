#include "io/folder.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/file_beside.h"
#include "io/format.h"
#include "io/formats/slices.h"
#include "io/formats/steps.h"
#include "io/notes.h"
#include "registry.h"
#include <stdlib.h>
#include <string.h>

enum { HEADERS_MOST = 256 }; /* of a folder's files that are looked into, for a list */

/* Which files are data sets ---------------------------------------------------------------------------------------- */

typedef struct looking {
    vvi_folder *out;
    vv_source *folder;
    const vv_format *but; /* the format that the folder may be of, in part; NULL: none */
    vv_job *job;
} looking;

static int by_text(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* Whether a row of the table knows a file by its suffix, and it is no part of a volume of the format `but`. */
static bool is_volume(const looking *l, const char *name, const vvi_names *sorted)
{
    size_t n;
    bool known = false;
    vvi_path_coding(name, &n);
    for (const vv_format *const *f = vvi_job_registry(l->job)->formats; *f && !known; f++)
        known = vvi_format_has_suffix(*f, name, n);
    return known && !vvi_slices_is_picture(name) && !(l->but && vvi_format_has_suffix(l->but, name, n)) &&
           !vvi_steps_has_header(name, sorted);
}

/* Of many pictures none is looked into. */
static bool is_picture(const looking *l, const char *name, size_t looked)
{
    return l->but == &vvi_format_slices && vvi_slices_is_picture(name) &&
           (looked > VVI_SLICES_LOOKED || !vvi_slices_is_made(l->folder, name, l->job));
}

/* Takes the names of data sets out of the list. */
static void move_sets(looking *l, vvi_names *files, const vvi_names *sorted)
{
    vvi_names *sets = &l->out->sets;
    size_t looked = 0;
    for (int pictures = 0; pictures < 2; pictures++)
        for (size_t i = 0; i < files->n; i++) {
            char *name = files->name[i];
            looked += pictures && name && vvi_slices_is_picture(name);
            if (!name || !(pictures ? is_picture(l, name, looked) : is_volume(l, name, sorted)))
                continue;
            sets->name[sets->n++] = name;
            files->name[i] = NULL;
            l->out->n_volumes += !pictures;
        }
}

static vv_status find_sets(looking *l)
{
    vvi_names files, sorted = {0};
    const bool deep = l->but && l->but != &vvi_format_slices && l->but != &vvi_format_steps;
    if (vvi_source_list(&files, l->folder, "", deep, l->job) != VV_OK)
        return VV_OK;
    const size_t bytes = (files.n ? files.n : 1) * sizeof *files.name;
    l->out->sets.name = vvi_alloc_zeroed(l->job, bytes, VVI_MEM_SCRATCH);
    sorted.name = vvi_alloc(l->job, bytes, VVI_MEM_SCRATCH);
    if (l->out->sets.name && sorted.name) {
        sorted.n = files.n;
        for (size_t i = 0; i < files.n; i++)
            sorted.name[i] = files.name[i];
        qsort(sorted.name, sorted.n, sizeof *sorted.name, by_text);
        move_sets(l, &files, &sorted);
    }
    const bool memory = l->out->sets.name && sorted.name;
    vvi_free(sorted.name);
    vvi_names_free(&files);
    return memory ? VV_OK : vv_fail_memory(bytes);
}

/* What is said of them --------------------------------------------------------------------------------------------- */

/* Of files whose names differ in a number the pattern that says so. */
static void list_series(vvi_text *out, const vv_source *folder, vv_job *job)
{
    enum { SHOWN = 3 };
    vvi_steps_groups groups;
    size_t n = 0;
    if (vvi_steps_find(&groups, folder, NULL, job) == VV_OK)
        for (size_t i = 0; i < groups.n_groups && n < SHOWN; i++)
            if (groups.group[i].sure != VVI_STEPS_ALONE)
                vvi_text_printf(out, "%s%s:%.80s", n++ ? " or " : "; if they are time steps of one, say so, as ",
                                vvi_source_name(folder), groups.group[i].key);
    vvi_steps_groups_free(&groups);
}

static vv_status fail_several(const looking *l)
{
    enum { SHOWN = 6 };
    vvi_text files = {0}, series = {0};
    const vvi_folder *out = l->out;
    for (size_t i = 0; i < out->n_volumes && i < SHOWN; i++)
        vvi_text_printf(&files, "%s'%.80s'", i ? ", " : "", out->sets.name[i]);
    if (out->n_volumes > SHOWN)
        vvi_text_printf(&files, " and %zu more", out->n_volumes - SHOWN);
    list_series(&series, l->folder, l->job);
    const vv_status st = vv_fail_at(VV_E_FORMAT, vvi_source_name(l->folder), NULL,
                                    "is a folder that holds several data sets: %s; name one of them%s%s%s",
                                    files.s && !files.bad ? files.s : "", l->but ? ", or say --input-format " : "",
                                    l->but ? l->but->name : "", series.s && !series.bad ? series.s : "");
    vvi_text_free(&files);
    vvi_text_free(&series);
    return st;
}

/* A folder that cannot be listed, or holds too many files, is no folder without a volume. */
static vv_status fail_folder(const vv_source *folder, const char *tried, vv_job *job)
{
    vvi_names files;
    const vv_status st = vvi_source_list(&files, folder, "", true, job);
    if (st != VV_OK)
        return st;
    const size_t n = files.n;
    vvi_names_free(&files);
    if (n == 0)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(folder), NULL, "is a folder without files; name another one");
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(folder), NULL,
                      "is a folder without a volume in a known format (tried %s); name a file in it", tried);
}

/* The choice ------------------------------------------------------------------------------------------------------- */

/* "a.h5:grid/density": the file of that name, and what is asked of it. */
static bool find_named(vvi_folder *out, const char *part)
{
    for (size_t i = 0; part && i < out->sets.n; i++) {
        const size_t n = strlen(out->sets.name[i]);
        if (strncmp(part, out->sets.name[i], n) != 0 || (part[n] && part[n] != ':'))
            continue;
        out->chosen = i;
        out->part = part[n] ? part + n + 1 : NULL;
        return true;
    }
    return false;
}

static vv_status choose(const looking *l, const vv_read_options *options)
{
    vvi_folder *out = l->out;
    if (find_named(out, options->part))
        return VV_OK;
    out->part = options->part;
    const bool only = out->n_volumes == 1 && out->sets.n <= 2 && (!l->but || l->but == &vvi_format_slices);
    return only || (options->any_part && !options->part) ? VV_OK : fail_several(l);
}

/* The row that is most certain of the folder; `tried`: all that were asked. */
static int probe_all(const vv_format **out, vvi_text *tried, vv_source *folder, vv_job *job)
{
    int best = 0;
    for (const vv_format *const *f = vvi_job_registry(job)->formats; *f; f++) {
        if (!(*f)->probe_folder)
            continue;
        const int sure = (*f)->probe_folder(folder, job);
        if (sure > best) {
            best = sure;
            *out = *f;
        }
        vvi_text_printf(tried, "%s%s", tried->n ? ", " : "", (*f)->name);
    }
    return best;
}

vv_status vvi_folder_look(vvi_folder *out, vv_source *folder, const vv_read_options *options, vv_job *job)
{
    vvi_text tried = {0};
    size_t n_pattern;
    const char *inner;
    *out = (vvi_folder){0};
    if (options->part && vvi_steps_split(&n_pattern, &inner, folder, options->part, job)) {
        out->format = &vvi_format_steps;
        return VV_OK;
    }
    looking l = {.out = out, .folder = folder, .job = job};
    const bool is_one = probe_all(&l.but, &tried, folder, job) == 2;
    const bool may_name = options->part && l.but == &vvi_format_steps; /* a file that is a time step, by itself */
    vv_status st = !is_one || may_name ? find_sets(&l) : VV_OK;
    if (st == VV_OK && is_one)
        out->format = may_name && find_named(out, options->part) ? NULL : l.but;
    else if (st == VV_OK && out->n_volumes > 0)
        st = choose(&l, options);
    else if (st == VV_OK && !(out->format = l.but))
        st = fail_folder(folder, tried.s && !tried.bad ? tried.s : "none", job);
    vvi_text_free(&tried);
    return st;
}

void vvi_folder_finish(vvi_folder *sets)
{
    vvi_names_free(&sets->sets);
    *sets = (vvi_folder){0};
}

/* As parts --------------------------------------------------------------------------------------------------------- */

static void add_about(vvi_text *text, const vv_file *file)
{
    const vv_field_info *info = vv_file_info(file);
    const int64_t *n = info->grid.dims;
    vvi_text_printf(text, "%lld x %lld x %lld", (long long)n[0], (long long)n[1], (long long)n[2]);
    if (info->components > 1)
        vvi_text_printf(text, " x %d", info->components);
    vvi_text_printf(text, " %s", vv_type_name(info->type));
    if (info->n_frames > 1)
        vvi_text_printf(text, ", %lld time steps", (long long)info->n_frames);
    vvi_text_printf(text, ", %s", vv_file_format(file));
}

/* What a header says; of one that cannot be read nothing. */
static vv_status tell_one(const vvi_folder *sets, size_t i, const vv_source *folder, vv_notes *notes, vv_job *job)
{
    vv_file *file = NULL;
    vvi_text about = {0};
    vv_read_options options;
    vv_read_options_init(&options, sizeof options);
    options.any_part = true;
    vv_status st = VV_E_LIMIT;
    if (i < HEADERS_MOST)
        st = vvi_file_open_beside(&file, folder, sets->sets.name[i], &options, job);
    if (st == VV_E_CANCELLED || st == VV_E_MEMORY)
        return st;
    if (st == VV_OK)
        add_about(&about, file);
    vv_file_close(file);
    st = vvi_notes_part(notes, sets->sets.name[i], about.s && !about.bad ? about.s : "", i == sets->chosen);
    vvi_text_free(&about);
    return st;
}

vv_status vvi_folder_tell(const vvi_folder *sets, const vv_source *folder, const vv_read_options *options,
                          vv_notes *notes, vv_job *job)
{
    vv_status st = VV_OK;
    if (sets->sets.n < 2)
        return VV_OK;
    vvi_notes_forget_parts(notes);
    for (size_t i = 0; i < sets->sets.n && st == VV_OK; i++)
        st = tell_one(sets, i, folder, notes, job);
    if (st != VV_OK || sets->n_volumes < 2 || options->part)
        return st;
    vvi_text series = {0};
    list_series(&series, folder, job);
    st = vvi_notes_warn(notes,
                        "it is one of %zu data sets in the folder %s, and none is named; name one as '%s/%.80s'%s",
                        sets->sets.n, vvi_source_name(folder), vvi_source_name(folder), sets->sets.name[sets->chosen],
                        series.s && !series.bad ? series.s : "");
    vvi_text_free(&series);
    return st;
}
