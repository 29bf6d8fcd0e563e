/* What is said of a folder that holds several data sets, or none. */
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/folder.h"
#include "io/format.h"
#include "io/formats/slices/slices.h"
#include "io/formats/steps/steps.h"
#include "registry.h"
#include <string.h>

void vvi_folder_add_series(vvi_text *out, const vvi_folder *sets, const vv_source *folder, vv_job *job)
{
    enum { SHOWN = 3 };
    vvi_steps_groups groups;
    size_t n = 0, files = 0;
    for (size_t i = 0; i < sets->n_choices; i++)
        files += !sets->set[i].format;
    if (files < 2)
        return;
    if (vvi_steps_find(&groups, folder, NULL, job) == VV_OK)
        for (size_t i = 0; i < groups.n_groups && n < SHOWN; i++)
            if (groups.group[i].sure != VVI_STEPS_ALONE)
                vvi_text_printf(out, "%s%s:%.80s", n++ ? " or " : "; if they are time steps of one, say so, as ",
                                vvi_source_name(folder), groups.group[i].key);
    vvi_steps_groups_free(&groups);
}

static void add_set(vvi_text *out, const vvi_folder_set *set)
{
    vvi_text_printf(out, "'%.80s'", set->name);
    if (set->format == &vvi_format_slices)
        vvi_text_printf(out, " (%zu pictures)", set->n_files);
    else if (set->format == &vvi_format_steps)
        vvi_text_printf(out, " (%zu time steps)", set->n_files);
    else if (set->format)
        vvi_text_printf(out, " (DICOM files)");
}

/* Files first, of which some are named; all that formats take together. */
static void list_choices(vvi_text *out, const vvi_folder *sets)
{
    enum { SHOWN = 6 };
    size_t files = 0, shown = 0;
    for (size_t i = 0; i < sets->n_choices; i++) {
        const vvi_folder_set *set = &sets->set[i];
        files += !set->format;
        if (!set->format && files > SHOWN)
            continue;
        vvi_text_add(out, shown++ ? ", " : "");
        add_set(out, set);
    }
    if (files > SHOWN)
        vvi_text_printf(out, " and %zu more files", files - SHOWN);
}

vv_status vvi_folder_fail_several(const vvi_folder *sets, const vv_source *folder, vv_job *job)
{
    const char *name = vvi_source_name(folder);
    const vvi_folder_set *last = &sets->set[sets->n_choices - 1];
    vvi_text files = {0}, series = {0};
    list_choices(&files, sets);
    vvi_folder_add_series(&series, sets, folder, job);
    const vv_status st =
        vv_fail_at(VV_E_FORMAT, name, NULL,
                   "is a folder that holds several data sets: %s; name one of them, as %s:%.80s%s%s%s%s%s",
                   files.s && !files.bad ? files.s : "", name, sets->set[0].name, last->format ? " or " : "",
                   last->format ? name : "", last->format ? ":" : "", last->format ? last->name : "",
                   series.s && !series.bad ? series.s : "");
    vvi_text_free(&files);
    vvi_text_free(&series);
    return st;
}

/* ------------------------------------------------------------------------------------------------------------------ */

static bool has_volume_suffix(const char *name, const vv_registry *registry)
{
    size_t n;
    const char *slash = strrchr(name, '/');
    vvi_path_coding(name, &n);
    for (const vv_format *const *f = registry->formats; *f && (slash ? slash[1] : name[0]) != '.'; f++)
        if ((*f)->read && vvi_format_has_suffix(*f, name, n))
            return true;
    return false;
}

void vvi_folder_volumes(vvi_names *out, const vv_source *folder, vv_job *job)
{
    size_t n = 0;
    if (vvi_source_list_folders(out, folder, "", job) != VV_OK)
        return;
    for (size_t i = 0; i < out->n; i++)
        if (has_volume_suffix(out->name[i], vvi_job_registry(job)))
            out->name[n++] = out->name[i];
        else
            vvi_free(out->name[i]);
    out->n = n;
}

/* What a folder without volumes holds that can be named: meshes, folders that are volumes, volumes in its folders. */
static void add_others(vvi_text *out, const vv_source *folder, const vvi_names *deep, vv_job *job)
{
    const vv_registry *registry = vvi_job_registry(job);
    vvi_names names;
    vvi_folder_meshes(&names, folder, job);
    if (names.n > 0)
        vvi_text_printf(out, "it holds %s: name one, as %s/%.80s", names.n > 1 ? "meshes" : "a mesh",
                        vvi_source_name(folder), names.name[0]);
    vvi_names_free(&names);
    if (out->n)
        return;
    vvi_folder_volumes(&names, folder, job);
    if (names.n > 0)
        vvi_text_printf(out, "a folder in it may be one: name it, as %s/%.80s", vvi_source_name(folder), names.name[0]);
    vvi_names_free(&names);
    for (size_t i = 0; i < deep->n && !out->n; i++)
        if (strchr(deep->name[i], '/') && has_volume_suffix(deep->name[i], registry))
            vvi_text_printf(out, "its folders hold some: name one, as %s/%.200s", vvi_source_name(folder),
                            deep->name[i]);
}

/* A folder that cannot be listed, or holds too many files, is no folder without a volume. */
vv_status vvi_folder_fail_none(const vv_source *folder, const char *tried, vv_job *job)
{
    vvi_names files;
    vvi_text others = {0};
    const char *name = vvi_source_name(folder);
    vv_status st = vvi_source_list(&files, folder, "", true, job);
    if (st != VV_OK)
        return st;
    add_others(&others, folder, &files, job);
    if (files.n == 0)
        st = vv_fail_at(VV_E_FORMAT, name, NULL, "is a folder without files; name another one");
    else if (others.n && !others.bad)
        st = vv_fail_at(VV_E_FORMAT, name, NULL, "is a folder without a volume; %s", others.s);
    else
        st = vv_fail_at(VV_E_FORMAT, name, NULL,
                        "is a folder without a volume in a known format (tried %s); name a file in it", tried);
    vvi_text_free(&others);
    vvi_names_free(&files);
    return st;
}
