/* HDF5: the rows of the table, and which data set of a file is read. */
#include "config.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/formats/netcdf/netcdf.h"
#include "registry.h"
#include <stdio.h>
#include <string.h>
#if VV_HAVE_HDF5
#include "io/formats/hdf5/hdf5.h"
#include "io/formats/nifti/nifti.h"

/* Which one ------------------------------------------------------------------------------------------------------- */

static bool is_named(const vvi_h5_set *set, const char *part)
{
    return strcmp(set->path, part) == 0 || strcmp(set->path + 1, part) == 0;
}

/* Names that programs give to what matters, when there are several volumes. */
static const vvi_h5_set *find_preferred(const vvi_h5_list *list)
{
    static const char *const names[] = {"volume", "raw", "exported_data", "volumes/raw"};
    for (size_t n = 0; n < sizeof names / sizeof *names; n++)
        for (size_t i = 0; i < list->n; i++)
            if (is_named(&list->set[i], names[n]))
                return &list->set[i];
    return NULL;
}

static const vvi_h5_set *find_only(const vvi_h5_list *list, int least_rank)
{
    const vvi_h5_set *found = NULL;
    for (size_t i = 0; i < list->n; i++)
        if (list->set[i].rank >= least_rank) {
            if (found)
                return NULL;
            found = &list->set[i];
        }
    return found;
}

static vv_status fail_choice(const vvi_h5 *h5, const vvi_h5_list *list, const char *part)
{
    vvi_text t = {0};
    for (size_t i = 0; i < list->n && i < 12; i++)
        vvi_text_printf(&t, "%s%s", i ? ", " : "", list->set[i].path);
    if (list->n > 12)
        vvi_text_printf(&t, " and %zu more", list->n - 12);
    const char *names = t.s && !t.bad ? t.s : "none";
    vv_status st;
    if (part)
        st = vv_fail_at(VV_E_ARGUMENT, h5->name, NULL,
                        "has no data set '%.100s' of numbers with 2 to 5 axes; there are %s", part, names);
    else if (list->n == 0)
        st = vv_fail_at(VV_E_UNSUPPORTED, h5->name, NULL,
                        "holds no data set of numbers with 2 to 5 axes that is within the limits (--limit dim=N and "
                        "--limit voxels=N allow more)");
    else
        st = vv_fail_at(VV_E_ARGUMENT, h5->name, NULL, "holds %zu data sets; choose one as %s:NAME: %s", list->n,
                        h5->name, names);
    vvi_text_free(&t);
    return st;
}

/* When there is nothing but meshes, none of them need be chosen to hear it. */
static const vvi_h5_set *find_mesh(const vvi_h5 *h5, const vvi_h5_list *list)
{
    const vvi_h5_set *mesh = NULL;
    for (size_t i = 0; i < list->n; i++) {
        const hid_t data = list->set[i].rank >= 3 ? vvi_h5_object(h5, list->set[i].path) : -1;
        if (data < 0)
            continue;
        const bool on_mesh = vvi_netcdf_on_mesh(h5, &list->set[i], data);
        H5Oclose(data);
        if (!on_mesh)
            return NULL;
        mesh = &list->set[i];
    }
    return mesh;
}

/* A volume, where there is one. */
static const vvi_h5_set *find_any(const vvi_h5_list *list)
{
    for (size_t i = 0; i < list->n; i++)
        if (list->set[i].rank >= 3)
            return &list->set[i];
    return list->n > 0 ? list->set : NULL;
}

static vv_status warn_of_choice(const vvi_h5 *h5, const vvi_h5_list *list, const vvi_h5_set *chosen, vv_notes *notes)
{
    return vvi_notes_warn(notes,
                          "holds %zu data sets, and none is named; this is %.200s. Elsewhere one must be named, as "
                          "%.200s:%.200s",
                          list->n, chosen->path, h5->name, chosen->path);
}

/* By the name that programs give to what matters: as the formats say it that take the first. */
static vv_status warn_of_name(const vvi_h5_list *list, const vvi_h5_set *chosen, vv_notes *notes)
{
    return vvi_notes_warn(notes, "holds %zu data sets; '%.200s' is read; name another with FILE:NAME", list->n,
                          chosen->path);
}

static vv_status choose_set(vvi_h5_set *out, const vvi_h5 *h5, const vvi_h5_list *list, const char *part,
                            vv_notes *notes)
{
    const vvi_h5_set *found = NULL, *named = NULL;
    for (size_t i = 0; part && i < list->n && !found; i++)
        if (is_named(&list->set[i], part))
            found = &list->set[i];
    if (!part) {
        found = find_only(list, 2);
        if (!found)
            found = find_only(list, 3);
        if (!found)
            named = found = find_preferred(list);
    }
    const vvi_h5_set *mesh = found || part ? NULL : find_mesh(h5, list);
    if (mesh)
        return vvi_netcdf_fail_mesh(h5, mesh);
    const bool any = !found && !part && h5->any_part;
    if (any)
        found = find_any(list);
    if (!found)
        return fail_choice(h5, list, part);
    *out = *found;
    return any ? warn_of_choice(h5, list, found, notes) : named ? warn_of_name(list, named, notes) : VV_OK;
}

static vv_status note_parts(vv_notes *notes, const vvi_h5_list *list, const vvi_h5_set *chosen)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < list->n && st == VV_OK; i++) {
        char about[256];
        vvi_h5_about(about, sizeof about, &list->set[i]);
        st = vvi_notes_part(notes, list->set[i].path, about, strcmp(list->set[i].path, chosen->path) == 0);
    }
    if (st == VV_OK && list->full)
        st = vvi_notes_warn(notes, "holds more data sets than are listed");
    return st;
}

/* The header ------------------------------------------------------------------------------------------------------ */

static vv_status read_set(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, vv_notes *notes)
{
    const hid_t data = vvi_h5_object(h5, plan->set.path);
    if (data < 0)
        return vvi_h5_fail(h5, plan->set.path, "cannot be opened");
    vv_status st = vvi_h5_check(&plan->set, h5, data);
    if (st == VV_OK && vvi_netcdf_on_mesh(h5, &plan->set, data))
        st = vvi_netcdf_fail_mesh(h5, &plan->set);
    if (st == VV_OK)
        st = vvi_h5_axes(info, plan, h5, data, notes);
    if (st == VV_OK)
        st = vvi_h5_note_attributes(notes, data);
    char lines[2048];
    if (st == VV_OK && vvi_h5_text(lines, sizeof lines, data, VVI_H5_NIFTI))
        st = vvi_nifti_keep_lines(notes, lines, info);
    if (st == VV_OK)
        st = plan->set.names ? vvi_h5_note_members(notes, data) : vvi_h5_note_names(notes, data, info->components);
    H5Oclose(data);
    return st;
}

static vv_status read_plain(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, const char *part, vv_notes *notes)
{
    vvi_h5_list list;
    vv_status st = vvi_h5_list_sets(&list, h5);
    if (st != VV_OK)
        return st;
    plan->n_sets = 1;
    st = choose_set(&plan->set, h5, &list, part, notes);
    if (st == VV_OK && list.n > 1)
        st = note_parts(notes, &list, &plan->set);
    vvi_h5_list_free(&list);
    return st == VV_OK ? read_set(info, plan, h5, notes) : st;
}

static vv_status read_locked(vv_field_info *info, vvi_h5_plan *plan, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    vvi_h5 h5;
    const char *part = options->part;
    vv_status st = vvi_h5_open(&h5, source, job);
    h5.finest = options->finest;
    h5.any_part = options->any_part;
    const bool any = !part || part[0] != '/'; /* the path of a data set is one of any file's */
    if (st == VV_OK && !part && vvi_minc_is(&h5))
        st = vvi_minc_header(info, plan, &h5, notes);
    else if (st == VV_OK && any && vvi_imaris_is(&h5))
        st = vvi_imaris_header(info, plan, &h5, part, notes);
    else if (st == VV_OK && any && vvi_bdv_is(&h5))
        st = vvi_bdv_header(info, plan, &h5, NULL, part, notes);
    else if (st == VV_OK)
        st = read_plain(info, plan, &h5, part, notes);
    if (st == VV_OK)
        st = h5.st;
    vvi_h5_close(&h5);
    return st;
}

static void free_plan(void *user)
{
    vvi_h5_plan *plan = user;
    vvi_free(plan->slice_ends);
    vvi_free(plan);
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    size_t n;
    *plan_out = NULL;
    const uint8_t *head = vvi_source_peek(source, 8, &n);
    if (head && vvi_netcdf3_magic(head, n))
        return vvi_netcdf3_refuse(source);
    vv_status st = vvi_source_spool(source, job);
    if (st != VV_OK)
        return st;
    vvi_h5_plan *plan = vvi_alloc_zeroed(job, sizeof *plan, VVI_MEM_MODEL);
    if (!plan)
        return vv_fail_memory(sizeof *plan);
    vvi_h5_lock();
    st = read_locked(info, plan, source, options, notes, job);
    vvi_h5_unlock();
    if (st != VV_OK) {
        free_plan(plan);
        return st;
    }
    *plan_out = plan;
    return VV_OK;
}

/* The .xml of BigDataViewer names the file of the samples ---------------------------------------------------------- */

static int probe_views(const uint8_t *head, size_t n, const char *path)
{
    (void)path;
    return memmem(head, n, "<SpimData", 9) ? 2 : 0;
}

static vv_status read_data_of_views(vv_field_info *info, vvi_h5_plan *plan, vv_source *xml, const vvi_bdv_views *views,
                                    const vv_read_options *options, vv_notes *notes, vv_job *job)
{
    vvi_h5 h5;
    vv_source *data;
    if (!views->file[0])
        return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(xml), NULL,
                          "names no HDF5 file with samples; its image loader is '%s'", views->loader);
    memcpy(plan->beside, views->file, sizeof plan->beside);
    vv_status st = vvi_source_open_beside(&data, xml, plan->beside, job);
    if (st != VV_OK)
        return st;
    vvi_h5_lock();
    st = vvi_h5_open(&h5, data, job);
    h5.finest = options->finest;
    h5.any_part = options->any_part;
    if (st == VV_OK)
        st = vvi_bdv_header(info, plan, &h5, views, options->part, notes);
    vvi_h5_close(&h5);
    vvi_h5_unlock();
    vvi_source_close(data);
    return st;
}

static vv_status read_views(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                            vv_notes *notes, vv_job *job)
{
    *plan_out = NULL;
    vvi_bdv_views *views = vvi_alloc(job, sizeof *views, VVI_MEM_SCRATCH);
    vvi_h5_plan *plan = vvi_alloc_zeroed(job, sizeof *plan, VVI_MEM_MODEL);
    vv_status st = views && plan ? vvi_bdv_read_views(views, source, job) : vv_fail_memory(sizeof *views);
    if (st == VV_OK)
        st = read_data_of_views(info, plan, source, views, options, notes, job);
    vvi_free(views);
    if (st != VV_OK) {
        vvi_free(plan);
        return st;
    }
    *plan_out = plan;
    return VV_OK;
}

static bool mappable(const vv_field_info *info, const void *user)
{
    const vvi_h5_plan *plan = user;
    (void)info;
    return plan->plain && vvi_layout_mappable(&plan->layout, plan->set.offset);
}

static int probe(const uint8_t *head, size_t n, const char *path)
{
    (void)path;
    return vvi_h5_magic(head, n) || vvi_netcdf3_magic(head, n) ? 2 : 0;
}
#else
#include "io/sink.h"
#include "io/source.h"

/* Looked for here so that the sentence is the right one. */
static int probe(const uint8_t *head, size_t n, const char *path)
{
    (void)path;
    return (n >= 8 && memcmp(head, "\x89HDF\r\n\x1a\n", 8) == 0) || vvi_netcdf3_magic(head, n) ? 2 : 0;
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    (void)info;
    (void)options;
    (void)notes;
    (void)job;
    size_t n;
    *plan_out = NULL;
    const uint8_t *head = vvi_source_peek(source, 8, &n);
    if (head && vvi_netcdf3_magic(head, n))
        return vvi_netcdf3_refuse(source);
    return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(source), NULL,
                      "is an HDF5 file; this build has no HDF5 library");
}

static vv_status vvi_h5_read(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                             int64_t frame, const vv_box *region, vv_job *job)
{
    (void)info;
    (void)plan;
    (void)frame;
    (void)region;
    (void)job;
    *out = NULL;
    return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(source), NULL, "this build has no HDF5 library");
}
static vv_status vvi_h5_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                              const vv_write_options *options, vv_job *job)
{
    (void)frames;
    (void)n_frames;
    (void)options;
    (void)job;
    return vv_fail_at(VV_E_UNSUPPORTED, vvi_sink_name(sink), NULL, "cannot be written: this build has no HDF5 library");
}

static void free_plan(void *user)
{
    (void)user;
}

static bool mappable(const vv_field_info *info, const void *user)
{
    (void)info;
    (void)user;
    return false;
}

static int probe_views(const uint8_t *head, size_t n, const char *path)
{
    (void)head;
    (void)n;
    (void)path;
    return 0;
}
#define read_views read_header
#endif

static const char *const suffixes[] = {".h5", ".hdf5", ".hdf", ".he5", NULL};
static const char *const encodings[] = {"gzip", "raw", NULL};
static const char *const netcdf_suffixes[] = {".nc", ".nc4", ".cdf", NULL};
static const char *const minc_suffixes[] = {".mnc", NULL};
static const char *const imaris_suffixes[] = {".ims", NULL};
static const char *const bdv_suffixes[] = {".xml", NULL};

const vv_format vvi_format_hdf5 = {
    .api = VV_FORMAT_API,
    .name = "hdf5",
    .doc = "HDF5 data sets of 2 to 5 axes, any chunks",
    .suffixes = suffixes,
    .encodings = encodings,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = vvi_h5_read,
    .mappable = mappable,
    .write = vvi_h5_write,
    .contained = VV_HAVE_HDF5,
    .boxes = true,
    .beside = true, /* the .xml of BigDataViewer */
};

const vv_format vvi_format_netcdf = {
    .api = VV_FORMAT_API,
    .name = "netcdf",
    .doc = "netCDF-4 variables of 2 to 5 axes",
    .suffixes = netcdf_suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = vvi_h5_read,
    .mappable = mappable,
    .contained = VV_HAVE_HDF5,
    .boxes = true,
};

const vv_format vvi_format_minc = {
    .api = VV_FORMAT_API,
    .name = "minc",
    .doc = "MINC 2, volumes of the brain",
    .suffixes = minc_suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = vvi_h5_read,
    .contained = VV_HAVE_HDF5,
    .boxes = true,
};

const vv_format vvi_format_imaris = {
    .api = VV_FORMAT_API,
    .name = "imaris",
    .doc = "Imaris 5.5 and newer: levels, channels, times",
    .suffixes = imaris_suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = vvi_h5_read,
    .contained = VV_HAVE_HDF5,
    .boxes = true,
};

const vv_format vvi_format_bdv = {
    .beside = true,
    .api = VV_FORMAT_API,
    .name = "bdv",
    .doc = "BigDataViewer's .xml with its .h5, which can be opened too",
    .suffixes = bdv_suffixes,
    .probe = probe_views,
    .read_header = read_views,
    .free_plan = free_plan,
    .read = vvi_h5_read,
    .contained = VV_HAVE_HDF5,
    .boxes = true,
};
