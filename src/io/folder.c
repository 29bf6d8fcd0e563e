#include "io/folder.h"
#include "core/job.h"
#include "core/text.h"
#include "io/file_beside.h"
#include "io/format.h"
#include "io/formats/slices/slices.h"
#include "io/formats/steps/steps.h"
#include "io/notes.h"
#include "registry.h"
#include <string.h>

enum { HEADERS_MOST = 256 }; /* of a folder's files that are looked into, for a list */

/* The choice ------------------------------------------------------------------------------------------------------- */

/* "a.h5:grid/density", "dicom:3": the data set of that name, and what is asked of it. */
static bool find_named(vvi_folder *out, const char *part)
{
    for (size_t i = 0; part && i < out->n; i++) {
        const size_t n = strlen(out->set[i].name);
        if (strncmp(part, out->set[i].name, n) != 0 || (part[n] && part[n] != ':'))
            continue;
        out->chosen = i;
        out->format = out->set[i].format;
        out->part = part[n] ? part + n + 1 : NULL;
        return true;
    }
    return false;
}

/* A part that is none of the names may be one of what a format takes together: a series, or a pattern of pictures. A
 * name of a file is none. */
static bool find_within(vvi_folder *out, const char *part, const vv_registry *registry)
{
    const vv_format *found = NULL;
    size_t n;
    vvi_path_coding(part, &n);
    const bool picture = vvi_slices_is_picture(part);
    for (const vv_format *const *f = registry->formats; *f && !picture; f++)
        if ((*f)->read && vvi_format_has_suffix(*f, part, n))
            return false;
    for (size_t i = 0; i < out->n_told; i++)
        if (out->set[i].format && (!found || (picture && out->set[i].format == &vvi_format_slices))) {
            found = out->set[i].format;
            out->chosen = i;
        }
    out->format = found;
    return found != NULL;
}

static vv_status choose(vvi_folder *out, const vv_source *folder, const vv_read_options *options, vv_job *job)
{
    if (find_named(out, options->part))
        return VV_OK;
    if (out->n_choices == 1 || (options->any_part && !options->part)) {
        out->format = out->set[0].format;
        return VV_OK;
    }
    if (options->part && find_within(out, options->part, vvi_job_registry(job)))
        return VV_OK;
    return vvi_folder_fail_several(out, folder, job);
}

vv_status vvi_folder_look(vvi_folder *out, vv_source *folder, const vv_read_options *options, vv_job *job)
{
    vvi_text tried = {0};
    size_t n_pattern;
    const char *inner;
    const vv_format *rest;
    *out = (vvi_folder){.part = options->part, .apart = out->apart};
    if (options->part && vvi_steps_split(&n_pattern, &inner, folder, options->part, job)) {
        out->format = &vvi_format_steps;
        return VV_OK;
    }
    vv_status st = vvi_folder_find(out, &rest, &tried, folder, job);
    if (st == VV_OK && out->n_choices > 0)
        st = choose(out, folder, options, job);
    else if (st == VV_OK && !out->format && !(out->format = rest))
        st = vvi_folder_fail_none(folder, tried.s && !tried.bad ? tried.s : "none", job);
    vvi_text_free(&tried);
    return st;
}

/* As parts --------------------------------------------------------------------------------------------------------- */

static void add_about(vvi_text *text, const vv_field_info *info, const char *format)
{
    const int64_t *n = info->grid.dims;
    vvi_text_printf(text, "%lld x %lld x %lld", (long long)n[0], (long long)n[1], (long long)n[2]);
    if (info->components > 1)
        vvi_text_printf(text, " x %d", info->components);
    vvi_text_printf(text, " %s", vv_type_name(info->type));
    if (info->n_frames > 1)
        vvi_text_printf(text, ", %lld time steps", (long long)info->n_frames);
    vvi_text_printf(text, ", %s", format);
}

static vv_status add_part(const vvi_folder *sets, size_t i, const char *within, const vvi_text *about, bool chosen,
                          vv_notes *notes)
{
    vvi_text name = {0};
    vvi_text_printf(&name, "%s%s%s", sets->set[i].name, within ? ":" : "", within ? within : "");
    const vv_status st =
        name.bad ? vv_fail_memory(name.n)
                 : vvi_notes_part(notes, name.s, about->s && !about->bad ? about->s : "", chosen && i == sets->chosen);
    vvi_text_free(&name);
    return st;
}

/* What a header says; of one that cannot be read nothing. */
static vv_status tell_file(const vvi_folder *sets, size_t i, const vv_source *folder, vv_notes *notes, vv_job *job)
{
    vv_file *file = NULL;
    vvi_text about = {0};
    vv_read_options options;
    vv_read_options_init(&options, sizeof options);
    options.any_part = true;
    vv_status st = VV_E_LIMIT;
    if (i < HEADERS_MOST)
        st = vvi_file_open_beside(&file, folder, sets->set[i].name, &options, job);
    if (st == VV_E_CANCELLED || st == VV_E_MEMORY)
        return st;
    if (st == VV_OK)
        add_about(&about, vv_file_info(file), vv_file_format(file));
    vv_file_close(file);
    st = add_part(sets, i, NULL, &about, true, notes);
    vvi_text_free(&about);
    return st;
}

/* Series of the format: parts of a part. */
static vv_status tell_parts(const vvi_folder *sets, size_t i, const vv_notes *within, vv_notes *notes)
{
    vv_part part;
    vv_status st = VV_OK;
    for (size_t p = 0; st == VV_OK && vvi_notes_get_part(within, p, &part); p++) {
        vvi_text about = {0};
        vvi_text_printf(&about, "%s", part.about);
        st = add_part(sets, i, part.name, &about, part.chosen, notes);
        vvi_text_free(&about);
    }
    return st;
}

/* The same of what a format takes together. */
static vv_status tell_many(const vvi_folder *sets, size_t i, vv_source *folder, vv_notes *notes, vv_job *job)
{
    const vv_format *format = sets->set[i].format;
    vv_field_info info = vv_field_info_default();
    vv_notes *within = NULL;
    vv_part part;
    vvi_text about = {0};
    void *plan = NULL;
    vv_read_options options;
    vv_read_options_init(&options, sizeof options);
    options.any_part = true;
    vv_status st = vvi_notes_new(&within, job);
    if (st == VV_OK) {
        vvi_notes_hush(within);
        st = format->read_header(&info, &plan, folder, &options, within, job);
    }
    if (st == VV_OK)
        add_about(&about, &info, format->name);
    if (plan && format->free_plan)
        format->free_plan(plan);
    const bool told = st == VV_OK && vvi_notes_get_part(within, 1, &part);
    if (st != VV_E_CANCELLED && st != VV_E_MEMORY)
        st = told ? tell_parts(sets, i, within, notes) : add_part(sets, i, NULL, &about, true, notes);
    vvi_notes_free(within);
    vvi_text_free(&about);
    return st;
}

/* Of time steps the names say enough. */
static vv_status tell_one(const vvi_folder *sets, size_t i, vv_source *folder, vv_notes *notes, vv_job *job)
{
    const vvi_folder_set *set = &sets->set[i];
    vvi_text about = {0};
    if (!set->format)
        return tell_file(sets, i, folder, notes, job);
    if (set->format != &vvi_format_steps)
        return tell_many(sets, i, folder, notes, job);
    vvi_text_printf(&about, "%zu time steps", set->n_files);
    const vv_status st = add_part(sets, i, NULL, &about, true, notes);
    vvi_text_free(&about);
    return st;
}

static vv_status warn_unnamed(const vvi_folder *sets, const vv_source *folder, vv_notes *notes, vv_job *job)
{
    const vvi_folder_set *chosen = &sets->set[sets->chosen];
    const char *name = vvi_source_name(folder);
    vvi_text series = {0};
    vv_status st = VV_OK;
    if (!sets->apart)
        vvi_folder_add_series(&series, sets, folder, job);
    else
        st = vvi_notes_warn(notes, "its files are called as time steps are, and are listed by themselves: %s",
                            sets->apart);
    if (st == VV_OK)
        st = vvi_notes_warn(notes,
                            "it is one of %zu data sets in the folder %s, and none is named; name one as '%s%s%.80s'%s",
                            sets->n_choices, name, name, chosen->format ? ":" : "/", chosen->name,
                            series.s && !series.bad ? series.s : "");
    vvi_text_free(&series);
    return st;
}

/* What has parts of its own, and was named or is the only choice, keeps them; the rest is told behind them. */
vv_status vvi_folder_tell(const vvi_folder *sets, vv_source *folder, const vv_read_options *options, vv_notes *notes,
                          vv_job *job)
{
    vv_part part;
    vv_status st = VV_OK;
    const bool settled = sets->n_choices < 2 || options->part;
    const bool kept = settled && vvi_notes_get_part(notes, sets->format ? 0 : 1, &part);
    if (sets->n_told < 2 || (options->part && (kept || sets->format)))
        return VV_OK;
    if (!kept)
        vvi_notes_forget_parts(notes);
    for (size_t i = 0; i < sets->n_told && st == VV_OK; i++)
        if (!kept || i != sets->chosen)
            st = tell_one(sets, i, folder, notes, job);
    return st == VV_OK && !settled ? warn_unnamed(sets, folder, notes, job) : st;
}
