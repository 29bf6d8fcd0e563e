/* The plan of a folder of slices: which file, and which page of it, is which plane. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/slices/slices.h"
#include "registry.h"
#include <stdio.h>
#include <string.h>

typedef struct opening {
    vvi_tiff *tiff;
    vvi_slices slices;
    vv_source *folder;
    vv_notes *notes;
    vv_job *job;
    const vvi_series *series;
    vvi_slice_axis axes[3]; /* of files, by role */
    int64_t inner[3];       /* planes of one file, by role */
    uint32_t *order;        /* which of them a page is; NULL: one slice after another */
} opening;

/* Parts ----------------------------------------------------------------------------------------------------------- */

/* What was taken for what: "2 time steps, 10 slices". */
static void list_roles(char *out, size_t n_out, const opening *o)
{
    static const char *const what[3][2] = {{"channel", "channels"}, {"slice", "slices"}, {"time step", "time steps"}};
    static const int order[3] = {VVI_SLICE_T, VVI_SLICE_Z, VVI_SLICE_C};
    size_t n = 0;
    *out = 0;
    for (int i = 0; i < 3; i++) {
        const size_t places = o->axes[order[i]].n;
        if (o->series->counts[order[i]] && n < n_out)
            n += (size_t)snprintf(out + n, n_out - n, "%s%zu %s", n > 0 ? ", " : "", places,
                                  what[order[i]][places != 1]);
    }
}

static vv_status tell_parts(const opening *o, const char *part)
{
    const vvi_slices *s = &o->slices;
    char roles[128], text[400];
    vv_status st = VV_OK;
    list_roles(roles, sizeof roles, o);
    for (size_t i = 0; i < s->n_series && st == VV_OK; i++) {
        const bool chosen = &s->series[i] == o->series;
        snprintf(text, sizeof text, "%zu files%s%s", s->series[i].n, chosen && roles[0] ? ", " : "",
                 chosen ? roles : "");
        st = vvi_notes_part(o->notes, s->series[i].key, text, chosen);
    }
    if (st == VV_OK && s->n_series > 1)
        st = vvi_notes_warn(o->notes,
                            "%s %zu series of slices; %s is read, '%.80s'; name another as FOLDER:SERIES, or say what "
                            "numbers in the names count, as FOLDER:a{t}_{z}.tif",
                            part ? "what was named is" : "holds", s->n_series,
                            o->series == s->series ? "the first" : "the first of those with the most files",
                            o->series->key);
    snprintf(text, sizeof text, "%.250s: %s", o->series->key, roles);
    if (st == VV_OK)
        st = vvi_notes_add(o->notes, "file names", text);
    if (st == VV_OK && s->n_foreign > 0) {
        snprintf(text, sizeof text, "%zu", s->n_foreign);
        st = vvi_notes_add(o->notes, "other files in the folder", text);
    }
    return st;
}

/* With the series that there are. */
static vv_status fail_unknown(opening *o, const char *part)
{
    vvi_slices all = {0};
    vv_status st = vvi_slices_find(&all, o->folder, NULL, o->job);
    for (size_t i = 0; i < all.n_series && st == VV_OK; i++)
        st = vvi_notes_part(o->notes, all.series[i].key, "", false);
    vvi_slices_free(&all);
    return st == VV_OK ? vvi_notes_fail_part(o->notes, VV_E_ARGUMENT, vvi_source_name(o->folder), "series", part) : st;
}

static vv_status choose_series(opening *o, const char *part)
{
    const vvi_slices *s = &o->slices;
    const char *name = vvi_source_name(o->folder);
    if (s->n == 0 && s->n_pictures == 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "has no files .tif, .png or .jpg");
    if (s->n == 0)
        return fail_unknown(o, part ? part : "");
    o->series = s->series;
    for (size_t i = 1; i < s->n_series; i++)
        if (s->series[i].n > o->series->n)
            o->series = &s->series[i];
    if (!o->series->unclear)
        return VV_OK;
    const vvi_slice *first = &s->slice[o->series->first], *last = first + o->series->n - 1;
    return vv_fail_at(
        VV_E_ARGUMENT, name, NULL,
        "several numbers change in the names of its files ('%.80s' to '%.80s'), and no letters before them "
        "(z, c, t) say what they count; say it with a pattern, as '%.80s:%.80s', where {z} counts slices, "
        "{t} time steps, {c} channels, and * is any text",
        s->names.name[first->name], s->names.name[last->name], name, o->series->key);
}

/* Files ----------------------------------------------------------------------------------------------------------- */

static vv_status keep_name(opening *o, size_t file, const char *name)
{
    const size_t n = strlen(name) + 1;
    char *copy = vvi_alloc(o->job, n, VVI_MEM_MODEL);
    if (!copy)
        return vv_fail_memory(n);
    memcpy(copy, name, n);
    o->tiff->files[file] = copy;
    return VV_OK;
}

static vv_status keep_names(opening *o)
{
    vvi_tiff *t = o->tiff;
    const size_t n = o->series->n;
    vv_status st = VV_OK;
    t->files = vvi_alloc_zeroed(o->job, n * sizeof *t->files, VVI_MEM_MODEL);
    if (!t->files)
        return vv_fail_memory(n * sizeof *t->files);
    t->n_files = n;
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = keep_name(o, i, o->slices.names.name[o->slices.slice[o->series->first + i].name]);
    return st;
}

static vv_status load_file(opening *o, size_t file)
{
    vv_source *source;
    vv_status st = vvi_source_open_beside(&source, o->folder, o->tiff->files[file], o->job);
    if (st == VV_OK)
        st = vvi_slices_add(o->tiff, source, (uint32_t)file, o->job);
    vvi_source_close(source);
    return st;
}

/* Axes of the pages of one file, and their order, as its own header says; the pages are those of the same kind. */
static vv_status take_order(opening *o, const vvi_tiff *first)
{
    const size_t n = (size_t)(first->channels * first->slices * first->frames);
    const size_t pages = (size_t)o->inner[VVI_SLICE_Z];
    if (first->n_files > 1)
        return vvi_notes_warn(o->notes,
                              "its files are parts of one OME-TIFF; open one of them to have all of it placed "
                              "as it says");
    if (first->channels * first->frames == 1 && n <= pages)
        return VV_OK;
    if (n != pages)
        return vvi_notes_warn(o->notes,
                              "its first file tells of %lld channels x %lld slices x %lld time steps, but %zu pages "
                              "are there; they are read as slices",
                              (long long)first->channels, (long long)first->slices, (long long)first->frames, pages);
    o->order = vvi_alloc_zeroed(o->job, n * sizeof *o->order, VVI_MEM_SCRATCH);
    if (!o->order)
        return vv_fail_memory(n * sizeof *o->order);
    for (size_t i = 0; i < n; i++)
        if (first->planes[i] < n)
            o->order[first->planes[i]] = (uint32_t)i;
    o->inner[VVI_SLICE_C] = first->channels;
    o->inner[VVI_SLICE_Z] = first->slices;
    o->inner[VVI_SLICE_T] = first->frames;
    return VV_OK;
}

static vv_status copy_channels(const opening *o, const vv_notes *from)
{
    size_t n;
    vv_status st = VV_OK;
    const vv_channel *channels = vvi_notes_channels(from, &n);
    for (size_t i = 0; i < n && st == VV_OK && o->axes[VVI_SLICE_C].n == 1; i++)
        st = vvi_notes_channel(o->notes, &channels[i]);
    return st;
}

/* Spacing, axes and the like, where the first file is a TIFF that says them. */
static vv_status take_info(vv_field_info *info, opening *o)
{
    vv_notes *notes;
    void *plan = NULL;
    vv_source *source;
    vv_read_options options;
    vv_field_info first = vv_field_info_default();
    vv_read_options_init(&options, sizeof options);
    if (o->tiff->pages[0].compression == VVI_TIFF_PNG || o->tiff->pages[0].offsets.first == 0)
        return VV_OK;
    vv_status st = vvi_notes_new(&notes, o->job);
    if (st != VV_OK)
        return st;
    st = vvi_source_open_beside(&source, o->folder, o->tiff->files[0], o->job);
    if (st == VV_OK && vvi_format_tiff.read_header(&first, &plan, source, &options, notes, o->job) == VV_OK) {
        info->grid.index_to_world = first.grid.index_to_world; /* of ours, with directions and origin */
        info->grid.space = first.grid.space;
        memcpy(info->grid.unit, first.grid.unit, sizeof info->grid.unit);
        memcpy(info->frame_unit, first.frame_unit, sizeof info->frame_unit);
        info->frame_step = first.frame_step;
        info->value_scale = first.value_scale;
        info->value_offset = first.value_offset;
        if ((st = take_order(o, plan)) == VV_OK)
            st = copy_channels(o, notes);
    }
    vvi_tiff_free(plan);
    vvi_source_close(source);
    vvi_notes_free(notes);
    return st;
}

/* The grid ---------------------------------------------------------------------------------------------------------
 */

/* Files of several slices whose number has no letter are time steps; else names and pages count different things. */
static vv_status join_axes(opening *o)
{
    vvi_slice_axis *axes = o->axes;
    if (o->series->loose && o->inner[VVI_SLICE_Z] > 1 && o->inner[VVI_SLICE_T] == 1 && axes[VVI_SLICE_T].n == 1) {
        const vvi_slice_axis time = axes[VVI_SLICE_Z];
        axes[VVI_SLICE_Z] = axes[VVI_SLICE_T];
        axes[VVI_SLICE_T] = time;
        for (size_t i = 0; i < o->series->n; i++) {
            uint64_t *number = o->slices.slice[o->series->first + i].number;
            number[VVI_SLICE_T] = number[VVI_SLICE_Z];
            number[VVI_SLICE_Z] = 0;
        }
    }
    for (int role = VVI_SLICE_C; role <= VVI_SLICE_T; role++)
        if (axes[role].n > 1 && o->inner[role] > 1)
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(o->folder), NULL,
                              "the numbers in the names of its files ('%.80s') count %s, and so do the %lld pages of "
                              "each file; say what the numbers count, as FOLDER:a{t}.tif, or open one file",
                              o->series->key,
                              role == VVI_SLICE_C   ? "channels"
                              : role == VVI_SLICE_Z ? "slices"
                                                    : "time steps",
                              (long long)(o->inner[0] * o->inner[1] * o->inner[2]));
    return VV_OK;
}

static vv_status make_planes(opening *o)
{
    vvi_tiff *t = o->tiff;
    size_t n = 0;
    t->channels = (int64_t)o->axes[VVI_SLICE_C].n * o->inner[VVI_SLICE_C];
    t->slices = (int64_t)o->axes[VVI_SLICE_Z].n * o->inner[VVI_SLICE_Z];
    t->frames = (int64_t)o->axes[VVI_SLICE_T].n * o->inner[VVI_SLICE_T];
    vv_status st = vvi_mul3_size(&n, (size_t)(t->channels * t->slices), (size_t)t->frames, sizeof *t->planes);
    if (st != VV_OK)
        return st;
    t->planes = vvi_alloc(o->job, n, VVI_MEM_MODEL);
    if (!t->planes)
        return vv_fail_memory(n);
    for (size_t i = 0; i < n / sizeof *t->planes; i++)
        t->planes[i] = VVI_TIFF_NO_PAGE;
    return VV_OK;
}

/* The first file tells how many planes a file has. */
static vv_status begin(vv_field_info *info, opening *o)
{
    const vvi_tiff *t = o->tiff;
    size_t pages = 0;
    vv_status st = load_file(o, 0);
    while (st == VV_OK && pages < t->n_pages && vvi_tiff_same_kind(&t->pages[pages], &t->pages[0]))
        pages++;
    o->inner[VVI_SLICE_C] = o->inner[VVI_SLICE_T] = 1;
    o->inner[VVI_SLICE_Z] = (int64_t)pages;
    if (st != VV_OK || (st = take_info(info, o)) != VV_OK || (st = join_axes(o)) != VV_OK)
        return st;
    return make_planes(o);
}

/* The plane of page `page` of a file. */
static uint32_t *plane_of(const opening *o, const vvi_slice *slice, size_t page)
{
    const int64_t *n = o->inner;
    size_t at[3];
    const size_t k = o->order ? o->order[page] : page;
    const size_t in[3] = {k % (size_t)n[0], k / (size_t)n[0] % (size_t)n[1], k / (size_t)n[0] / (size_t)n[1]};
    for (int role = VVI_SLICE_C; role <= VVI_SLICE_T; role++)
        at[role] = in[role] + vvi_slices_place(&o->axes[role], slice->number[role]) * (size_t)n[role];
    const vvi_tiff *t = o->tiff;
    return &t->planes[at[0] + (size_t)t->channels * (at[1] + (size_t)t->slices * at[2])];
}

/* Pages of a file to its place; what is of another kind than the first is missing. */
static vv_status add_file(opening *o, size_t file)
{
    vvi_tiff *t = o->tiff;
    const vvi_slice *slice = &o->slices.slice[o->series->first + file];
    const size_t before = file == 0 ? 0 : t->n_pages, pages = (size_t)(o->inner[0] * o->inner[1] * o->inner[2]);
    size_t n = 0;
    vv_status st = file == 0 ? VV_OK : load_file(o, file);
    if (st == VV_E_CANCELLED || st == VV_E_MEMORY)
        return st;
    if (st != VV_OK)
        return vvi_notes_warn(o->notes, "a slice is missing: %s", vv_error_last()->message);
    for (size_t i = before; i < t->n_pages && n < pages; i++)
        if (vvi_tiff_same_kind(&t->pages[i], &t->pages[0]))
            *plane_of(o, slice, n++) = (uint32_t)i;
    if (n == pages)
        return VV_OK;
    const vvi_tiff_page *p = &t->pages[before], *q = &t->pages[0];
    return vvi_notes_warn(o->notes,
                          "%s is left out: it has %lu x %lu pixels of %d x %d bits, %lu x %lu of %d x %d were "
                          "expected",
                          t->files[file], (unsigned long)p->width, (unsigned long)p->height, p->samples, p->bits,
                          (unsigned long)q->width, (unsigned long)q->height, q->samples, q->bits);
}

static vv_status add_files(vv_field_info *info, opening *o)
{
    vv_status st = keep_names(o);
    if (st == VV_OK)
        st = begin(info, o);
    for (size_t i = 0; i < o->series->n && st == VV_OK; i++)
        if ((st = vvi_job_progress(o->job, "look", i, o->series->n)) == VV_OK)
            st = add_file(o, i);
    return st;
}

/* Files that the grid promises and that are not there, or cannot be used. */
static vv_status tell_missing(const opening *o)
{
    const vvi_tiff *t = o->tiff;
    const size_t n = (size_t)(t->channels * t->slices * t->frames),
                 each = (size_t)(o->inner[0] * o->inner[1] * o->inner[2]);
    size_t missing = 0, first = 0;
    for (size_t i = n; i-- > 0;)
        if (t->planes[i] == VVI_TIFF_NO_PAGE) {
            missing++;
            first = i;
        }
    if (missing == 0)
        return VV_OK;
    const size_t at[3] = {first % (size_t)t->channels / (size_t)o->inner[0],
                          first / (size_t)t->channels % (size_t)t->slices / (size_t)o->inner[1],
                          first / (size_t)(t->channels * t->slices) / (size_t)o->inner[2]};
    char text[128] = "";
    int n_text = 0, told = 0;
    for (int role = VVI_SLICE_C; role <= VVI_SLICE_T; role++)
        if (o->axes[role].n > 1)
            n_text += snprintf(text + n_text, sizeof text - (size_t)n_text, "%s%s %llu", told++ ? ", " : "",
                               role == VVI_SLICE_C   ? "channel"
                               : role == VVI_SLICE_Z ? "slice"
                                                     : "time step",
                               (unsigned long long)vvi_slices_value(&o->axes[role], at[role]));
    return vvi_notes_warn(
        o->notes,
        "%zu of %zu files are missing or left out, the first of them %s by the numbers in '%.80s'; they are filled",
        missing / each, n / each, text, o->series->key);
}

/* Channels of different files are called what the names of the files say. */
static vv_status name_channels(const opening *o)
{
    const vvi_slice_axis *axis = &o->axes[VVI_SLICE_C];
    const vvi_slice *slice = o->slices.slice + o->series->first;
    vv_status st = VV_OK;
    if (axis->n < 2 || o->tiff->pages[0].samples > 1)
        return VV_OK;
    for (size_t c = 0, i = 0; c < axis->n && st == VV_OK; c++) {
        vv_channel channel = {.name = ""};
        while (slice[i].number[VVI_SLICE_C] != axis->value[c]) /* the next file in most folders */
            i = i + 1 < o->series->n ? i + 1 : 0;
        snprintf(channel.name, sizeof channel.name, "%.*s", (int)(slice[i].n < 60 ? slice[i].n : 60),
                 o->slices.names.name[slice[i].name] + slice[i].at);
        vvi_text_clean(channel.name);
        st = vvi_notes_channel(o->notes, &channel);
    }
    return st;
}

static vv_status open_series(vv_field_info *info, opening *o, const char *part)
{
    vv_status st = vvi_slices_find(&o->slices, o->folder, part, o->job);
    if (st != VV_OK || (st = choose_series(o, part)) != VV_OK ||
        (st = vvi_slices_grid(o->axes, &o->slices, o->series, o->folder, o->notes, o->job)) != VV_OK ||
        (st = tell_parts(o, part)) != VV_OK || (st = add_files(info, o)) != VV_OK || (st = name_channels(o)) != VV_OK)
        return st;
    return tell_missing(o);
}

vv_status vvi_slices_open(vv_field_info *info, vvi_tiff *tiff, vv_source *folder, const char *part, vv_notes *notes,
                          vv_job *job)
{
    opening o = {.tiff = tiff, .folder = folder, .notes = notes, .job = job};
    vv_status st = open_series(info, &o, part);
    vvi_slices_free(&o.slices);
    for (int role = VVI_SLICE_C; role <= VVI_SLICE_T; role++)
        vvi_free(o.axes[role].value);
    vvi_free(o.order);
    return st == VV_OK ? vvi_tiff_describe(info, tiff, folder, notes, job) : st;
}
