/* Which data sets a folder holds: files of volumes, and what formats take of many files. */
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/folder.h"
#include "io/format.h"
#include "io/formats/slices/slices.h"
#include "io/formats/steps/steps.h"
#include "io/mesh_file.h"
#include "registry.h"
#include <stdlib.h>
#include <string.h>
#include <strings.h>

typedef struct finding {
    vvi_folder *out;
    vv_source *folder;
    vv_job *job;
    vvi_names files, sorted;          /* sorted: the same names, in the order of strcmp() */
    int dicom, slices;                /* how sure the formats are */
    bool steps;                       /* its volumes are called as time steps are */
    size_t room, n_pictures, picture; /* picture: one of them */
} finding;

static int by_text(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static vv_status add(finding *f, const char *name, const vv_format *format, size_t n_files)
{
    vvi_folder *out = f->out;
    const size_t n_name = strlen(name) + 1;
    if (out->n == f->room) {
        const size_t room = f->room ? 2 * f->room : 16;
        vvi_folder_set *grown = vvi_realloc(f->job, out->set, room * sizeof *grown, VVI_MEM_SCRATCH);
        if (!grown)
            return vv_fail_memory(room * sizeof *grown);
        out->set = grown;
        f->room = room;
    }
    char *copy = vvi_alloc(f->job, n_name, VVI_MEM_SCRATCH);
    if (!copy)
        return vv_fail_memory(n_name);
    memcpy(copy, name, n_name);
    out->set[out->n++] = (vvi_folder_set){copy, format, n_files};
    return VV_OK;
}

/* Files ------------------------------------------------------------------------------------------------------------ */

static const char *last_name(const char *name)
{
    const char *slash = strrchr(name, '/');
    return slash ? slash + 1 : name;
}

/* Suffixes that many programs use: such a file is a volume where its first bytes say so. */
static bool is_common(const char *name, size_t n)
{
    static const char *const suffixes[] = {".dat", ".xml", ".map", ".rec", ".st", ".ali", NULL};
    for (const char *const *s = suffixes; *s; s++)
        if (n > strlen(*s) && strncasecmp(name + n - strlen(*s), *s, strlen(*s)) == 0)
            return true;
    return false;
}

/* What the first bytes are; NULL: of no known format, or not to be read. */
static const vv_format *format_inside(const finding *f, const char *name)
{
    vv_source *source;
    const vv_format *format = NULL;
    size_t n;
    if (vvi_source_open_input_beside(&source, f->folder, name, f->job) != VV_OK)
        return NULL;
    const uint8_t *head = vvi_source_peek(source, 4096, &n);
    if (!head || vvi_format_of_file(&format, head, n, name, vvi_job_registry(f->job)) != VV_OK ||
        (format->probe && format->probe(head, n, name) == 0)) /* a suffix says nothing of what is inside */
        format = NULL;
    vvi_source_close(source);
    return format;
}

static bool is_slice(const finding *f, const char *name)
{
    return vvi_slices_is_picture(last_name(name)) && !vvi_slices_is_stack(&f->files, name, f->folder, f->job);
}

/* By its suffix; a DICOM file of any name is one of the series. */
static bool is_volume(const finding *f, const char *name)
{
    size_t n;
    bool known = false;
    vvi_path_coding(name, &n);
    if (last_name(name)[0] == '.' || is_slice(f, name) || vvi_steps_has_header(name, &f->sorted) ||
        (f->dicom && vvi_format_has_suffix(&vvi_format_dicom, name, n)))
        return false;
    for (const vv_format *const *row = vvi_job_registry(f->job)->formats; *row && !known; row++)
        known = (*row)->read && vvi_format_has_suffix(*row, name, n);
    if (!known || (!f->dicom && !is_common(name, n)))
        return known;
    const vv_format *inside = format_inside(f, name);
    return inside ? inside != &vvi_format_dicom : !is_common(name, n);
}

/* The volumes of the folder itself are time steps: one data set. */
static vv_status add_steps(finding *f)
{
    vvi_steps_groups groups;
    vv_status st = vvi_steps_find(&groups, f->folder, NULL, f->job);
    if (st == VV_OK && groups.n_groups == 1 && groups.group[0].sure == VVI_STEPS_SURE &&
        is_volume(f, groups.names.name[groups.entry[0].name]))
        st = add(f, groups.group[0].key, &vvi_format_steps, groups.group[0].n);
    f->steps = st == VV_OK && f->out->n > 0;
    vvi_steps_groups_free(&groups);
    return st;
}

/* choices: those that are data sets by themselves; else those that are steps of one. */
static vv_status add_files(finding *f, bool choices)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < f->files.n && st == VV_OK; i++) {
        const char *name = f->files.name[i];
        const bool step = f->steps && !strchr(name, '/');
        if (step != choices && is_volume(f, name))
            st = add(f, name, NULL, 1);
    }
    return st;
}

/* ------------------------------------------------------------------------------------------------------------------ */

/* A picture is a data set where nothing else is one; a stack of them, beside DICOM files or time steps, where it is
 * most of what there is. */
static vv_status add_sets(finding *f)
{
    vvi_folder *out = f->out;
    const bool stack = f->n_pictures >= 2;
    const bool chosen = stack && (f->slices == 2 || (f->dicom < 2 && !f->steps));
    vv_status st = add_files(f, true);
    if (st == VV_OK && f->dicom)
        st = add(f, vvi_format_dicom.name, &vvi_format_dicom, 0);
    if (st == VV_OK && chosen)
        st = add(f, vvi_format_slices.name, &vvi_format_slices, f->n_pictures);
    out->n_choices = out->n;
    if (st == VV_OK && stack && !chosen)
        st = add(f, vvi_format_slices.name, &vvi_format_slices, f->n_pictures);
    else if (st == VV_OK && f->n_pictures == 1 && out->n_choices > 0)
        st = add(f, f->files.name[f->picture], NULL, 1);
    out->n_told = out->n;
    return st == VV_OK && f->steps ? add_files(f, false) : st;
}

static vv_status list_files(finding *f)
{
    vv_status st = vvi_source_list(&f->files, f->folder, "", f->dicom > 0, f->job);
    if (st != VV_OK)
        return st;
    const size_t bytes = (f->files.n ? f->files.n : 1) * sizeof *f->sorted.name;
    if (!(f->sorted.name = vvi_alloc(f->job, bytes, VVI_MEM_SCRATCH)))
        return vv_fail_memory(bytes);
    f->sorted.n = f->files.n;
    for (size_t i = 0; i < f->files.n; i++)
        f->sorted.name[i] = f->files.name[i];
    qsort(f->sorted.name, f->sorted.n, sizeof *f->sorted.name, by_text);
    return VV_OK;
}

vv_status vvi_folder_find(vvi_folder *out, const vv_format **rest_out, vvi_text *tried, vv_source *folder, vv_job *job)
{
    finding f = {.out = out, .folder = folder, .job = job};
    int best = 0;
    *rest_out = NULL;
    for (const vv_format *const *row = vvi_job_registry(job)->formats; *row; row++) {
        const bool files = *row == &vvi_format_dicom || *row == &vvi_format_slices || *row == &vvi_format_steps;
        if (!(*row)->probe_folder || (out->apart && *row == &vvi_format_steps))
            continue;
        const int sure = (*row)->probe_folder(folder, job);
        if (sure == 2 && !files) { /* the folder itself is the format's */
            out->format = *row;
            return VV_OK;
        }
        if (sure > best)
            *rest_out = *row;
        best = sure > best ? sure : best;
        f.dicom = *row == &vvi_format_dicom ? sure : f.dicom;
        f.slices = *row == &vvi_format_slices ? sure : f.slices;
        f.steps = f.steps || (*row == &vvi_format_steps && sure == 2);
        vvi_text_printf(tried, "%s%s", tried->n ? ", " : "", (*row)->name);
    }
    vv_status st = list_files(&f);
    if (st == VV_OK)
        f.n_pictures = vvi_slices_count(&f.picture, &f.files, folder, job);
    if (st == VV_OK && f.steps)
        st = add_steps(&f);
    if (st == VV_OK)
        st = add_sets(&f);
    vvi_free(f.sorted.name);
    vvi_names_free(&f.files);
    return st;
}

void vvi_folder_finish(vvi_folder *sets)
{
    for (size_t i = 0; i < sets->n; i++)
        vvi_free(sets->set[i].name);
    vvi_free(sets->set);
    *sets = (vvi_folder){0};
}

void vvi_folder_meshes(vvi_names *out, const vv_source *folder, vv_job *job)
{
    size_t n = 0;
    if (vvi_source_list(out, folder, "", false, job) != VV_OK)
        return;
    for (size_t i = 0; i < out->n; i++)
        if (out->name[i][0] != '.' && vvi_mesh_format_of_path(out->name[i], vvi_job_registry(job)))
            out->name[n++] = out->name[i];
        else
            vvi_free(out->name[i]);
    out->n = n;
}
