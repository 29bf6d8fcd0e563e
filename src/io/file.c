#include "core/allowed_places.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "grid/fill_value.h"
#include "grid/true_values.h"
#include "import/import.h"
#include "import/import_process.h"
#include "io/data_file.h"
#include "io/file_beside.h"
#include "io/file_leaving.h"
#include "io/file_stream.h"
#include "io/folder.h"
#include "io/format.h"
#include "io/formats/steps/steps.h"
#include "io/notes.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct vv_file {
    const vv_format *format;
    vv_source *source; /* NULL when the import program reads */
    vvi_import *import;
    char *name;
    vv_notes *notes;
    unsigned follow; /* VVI_FOLLOW_* */
    vvi_lack lack;   /* where the file is only looked at */
    void *plan;
    vv_field_info info;
    vvi_leaving *left_out; /* NULL: all samples are what is stored */
    vv_file *origin;       /* of data that are made; NULL: none */
    bool new_values;       /* which have no longer its values */
};

void vv_read_options_init(vv_read_options *options, size_t size)
{
    const vv_read_options defaults = {.size = size};
    memset(options, 0, size);
    memcpy(options, &defaults, size < sizeof defaults ? size : sizeof defaults);
}

static vv_status choose_format(vv_file *file, const vv_read_options *options, vv_job *job)
{
    const vv_registry *registry = vvi_job_registry(job);
    const bool folder = vvi_source_is_folder(file->source);
    if (options->format)
        return vvi_format_named(&file->format, options->format, registry);
    if (options->raw)
        return vvi_format_named(&file->format, folder ? "steps" : "raw", registry);
    size_t n;
    const uint8_t *head = vvi_source_peek(file->source, 4096, &n);
    if (!head) {
        const vv_status st = vv_error_last()->status;
        return st == VV_OK ? VV_E_READ : st;
    }
    if (n == 0) { /* coded data, perhaps, of which nothing could be read */
        const vv_status st = vvi_source_check_end(file->source);
        if (st != VV_OK)
            return st;
    }
    return vvi_format_of_file(&file->format, head, n, vvi_source_name(file->source), registry);
}

/* What a reader has understood, against the limits of the job: the same for every format. */
static vv_status check_limits(const vv_field_info *info, const char *name, const vv_limits *limits)
{
    const int64_t *dims = info->grid.dims;
    const uint64_t factors[5] = {(uint64_t)dims[0], (uint64_t)dims[1], (uint64_t)dims[2], (uint64_t)info->components,
                                 (uint64_t)info->n_frames};
    uint64_t voxels = 1;
    for (int a = 0; a < 5; a++) {
        const uint64_t n = factors[a];
        if (a < 3 && n > limits->dim)
            return vv_fail_at(VV_E_FORMAT, name, NULL,
                              "has %llu samples along %c; at most %llu are allowed (--limit dim=N allows more)",
                              (unsigned long long)n, 'x' + a, (unsigned long long)limits->dim);
        if (voxels > limits->voxels / n)
            return vv_fail_at(VV_E_FORMAT, name, NULL,
                              "asks for more than %llu samples; its header is wrong, or --limit voxels=N allows more",
                              (unsigned long long)limits->voxels);
        voxels *= n;
    }
    return VV_OK;
}

/* Labels are the numbers that are stored: a scale is of amounts. */
static vv_status unscale_labels(vv_file *file)
{
    vv_field_info *info = &file->info;
    if (info->meaning != VV_MEANING_LABEL || !vvi_has_scale(info))
        return VV_OK;
    const vv_status st =
        vvi_notes_warn(file->notes,
                       "it has labels, and a scale (times %g, plus %g), which labels have not; they are "
                       "the numbers that are stored",
                       info->value_scale, info->value_offset);
    info->value_scale = 1;
    info->value_offset = 0;
    return st;
}

/* Then no ray counts its steps: render refuses the step that is right for the data. */
#define SPACINGS_APART 1048576.0

static vv_status warn_of_spacings(vv_file *file)
{
    const vv_grid *grid = &file->info.grid;
    const double s[3] = {vv_grid_spacing(grid, 0), vv_grid_spacing(grid, 1), vv_grid_spacing(grid, 2)};
    const double least = fmin(fmin(s[0], s[1]), s[2]), most = fmax(fmax(s[0], s[1]), s[2]);
    if (!(most / least > SPACINGS_APART))
        return VV_OK;
    return vvi_notes_warn(
        file->notes,
        "its spacings are %g x %g x %g, %.3g times as large along one axis as along another: pictures need "
        "a header that is right",
        s[0], s[1], s[2], most / least);
}

/* The sentence without the name, which warnings begin with. */
static const char *lack_of(const vv_file *file)
{
    const char *name = vvi_source_name(file->source), *sentence = file->lack.sentence;
    const size_t n = strlen(name);
    return strncmp(sentence, name, n) == 0 && strncmp(sentence + n, ": ", 2) == 0 ? sentence + n + 2 : sentence;
}

/* Units stand beside figures everywhere, also where nobody thinks of what a terminal obeys. */
static void clean_units(vv_field_info *info)
{
    vvi_text_clean(info->grid.unit);
    vvi_text_clean(info->value_unit);
    vvi_text_clean(info->frame_unit);
}

static vv_status read_header(vv_file *file, const vv_read_options *options, vv_job *job)
{
    file->info = vv_field_info_default();
    if (!file->format->read_header || !file->format->read)
        return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(file->source), NULL, "the format %s can only be written",
                          file->format->name);
    if (options->any_length)
        vvi_source_bear(file->source, &file->lack);
    vv_status st = file->format->read_header(&file->info, &file->plan, file->source, options, file->notes, job);
    if (st != VV_OK)
        return st;
    clean_units(&file->info);
    vv_part first;
    if (options->part && !vvi_notes_get_part(file->notes, 0, &first))
        return vv_fail_at(VV_E_NOT_FOUND, vvi_source_name(file->source), NULL,
                          "has no part '%.60s': it holds one data set, which is opened without a name", options->part);
    uint64_t bytes;
    if (file->lack.sentence[0] && (st = vvi_notes_warn(file->notes, "%s", lack_of(file))) != VV_OK)
        return st;
    if ((st = vv_field_info_check(&file->info)) == VV_OK && (st = unscale_labels(file)) == VV_OK &&
        (st = warn_of_spacings(file)) == VV_OK)
        st = vv_field_info_bytes(&bytes, &file->info);
    if (st == VV_OK)
        return check_limits(&file->info, vvi_source_name(file->source), vvi_job_limits(job));
    return vv_fail_in(st, "%s", vvi_source_name(file->source));
}

/* The first `told` of them were logged by the import program. */
static void log_warnings(const vv_file *file, size_t told, const vv_job *job)
{
    const char *text;
    for (size_t i = told; (text = vvi_notes_warning(file->notes, i)) != NULL; i++)
        vvi_log(job, VV_LOG_WARNING, "io", "%s: %s", file->name, text);
}

static vv_status open_by_import(vv_file *file, const char *path, const vv_read_options *options, vv_job *job)
{
    vv_status st =
        vvi_import_open(&file->import, &file->info, &file->format, path, file->source, options, file->notes, job);
    return st == VV_OK ? check_limits(&file->info, file->name, vvi_job_limits(job)) : st;
}

static bool is_contained(const vv_file *file, const vv_read_options *options, vv_job *job)
{
    if (!vvi_job_contains(job) || !(file->format->contained || (file->format->read == vvi_steps_read &&
                                                                vvi_steps_are_contained(file->source, options, job))))
        return false;
    if (vvi_job_registry(job) != vv_registry_builtin() && !vvi_job_import_program(job))
        return false;
    const bool there = vvi_import_is_there(job);
    if (!there)
        vvi_log(job, VV_LOG_INFO, "io", "%s: read in this process, since there is no import program", file->name);
    return there;
}

static vv_status open_as(vv_file *file, const char *path, const vv_read_options *options, vv_job *job)
{
    return is_contained(file, options, job) ? open_by_import(file, path, options, job)
                                            : read_header(file, options, job);
}

static vv_status take_name(vv_file *file)
{
    char *name = vvi_strdup(vvi_source_name(file->source));
    if (!name)
        return vv_fail_memory(256);
    free(file->name);
    file->name = name;
    return VV_OK;
}

/* A folder is one data set, or a file in it is what is meant: *folder_out is the folder then. */
static vv_status enter_folder(vv_source **folder_out, vvi_folder *sets, vv_file *file, vv_read_options *options,
                              vv_job *job)
{
    vv_status st = vvi_folder_look(sets, file->source, options, job);
    file->format = sets->format;
    options->part = sets->part;
    if (sets->format) /* who opens it again, the import program, does not look again */
        options->format = sets->format->name;
    if (st != VV_OK || sets->format)
        return st;
    *folder_out = file->source;
    file->source = NULL;
    st = vvi_source_open_input_beside(&file->source, *folder_out, sets->set[sets->chosen].name, job);
    return st == VV_OK ? take_name(file) : st;
}

static vv_status open_source(vv_file *file, vv_source **folder_out, vvi_folder *sets, size_t *told_out,
                             const char *path, const vv_read_options *options, vv_job *job)
{
    vv_read_options inner = *options;
    vv_status st = vvi_source_open_input(&file->source, path, job);
    if (st == VV_OK && vvi_source_is_folder(file->source) && !options->format && !options->raw)
        st = enter_folder(folder_out, sets, file, &inner, job);
    if (st == VV_OK && !file->format)
        st = choose_format(file, &inner, job);
    if (st != VV_OK || (st = open_as(file, *folder_out ? file->name : path, &inner, job)) != VV_OK)
        return st;
    while (file->import && vvi_notes_warning(file->notes, *told_out))
        (*told_out)++;
    vv_source *folder = *folder_out ? *folder_out : file->source;
    return vvi_folder_tell(sets, folder, options, file->notes, job);
}

/* Files that were taken for time steps, and are none: whoever takes any part gets the first of them, and a list. */
static vv_status open_apart(vv_file *file, vv_source **folder_out, vvi_folder *sets, size_t *told_out, const char *path,
                            const vv_read_options *options, vv_job *job)
{
    const vv_error why = *vv_error_last();
    const char *name = vvi_source_name(file->source);
    const size_t n = strlen(name);
    const bool named = strncmp(why.message, name, n) == 0 && strncmp(why.message + n, ": ", 2) == 0;
    vvi_folder_finish(sets);
    vvi_source_close(file->source);
    vvi_notes_free(file->notes);
    file->source = NULL;
    file->notes = NULL;
    file->format = NULL;
    const vv_status st = vvi_notes_new(&file->notes, job);
    sets->apart = why.message + (named ? n + 2 : 0);
    return st == VV_OK ? open_source(file, folder_out, sets, told_out, path, options, job) : st;
}

static vv_status open_here(vv_file *file, const char *path, const vv_read_options *options, vv_job *job)
{
    vvi_folder sets = {0};
    vv_source *folder = NULL;
    size_t told = 0;
    vv_status st = open_source(file, &folder, &sets, &told, path, options, job);
    if ((st == VV_E_FORMAT || st == VV_E_ARGUMENT) && options->any_part && !options->part && file->source &&
        sets.n > 0 && sets.format && sets.format->free_plan == vvi_steps_free)
        st = open_apart(file, &folder, &sets, &told, path, options, job);
    vvi_folder_finish(&sets);
    vvi_source_close(folder);
    if (st != VV_OK)
        return st;
    log_warnings(file, told, job);
    if (file->import)
        return VV_OK;
    vvi_log(job, VV_LOG_INFO, "io", "%s: read as %s", file->name, file->format->name);
    return VV_OK;
}

static vv_status file_new(vv_file **out, const char *name, vv_job *job)
{
    vv_file *file = *out = vvi_alloc_zeroed(job, sizeof *file, VVI_MEM_MODEL);
    if (!file)
        return vv_fail_memory(sizeof *file);
    file->name = vvi_strdup(name);
    return file->name ? vvi_notes_new(&file->notes, job) : vv_fail_memory(strlen(name));
}

vv_status vvi_file_of_plan(vv_file **out, const char *name, const vv_format *format, void *plan,
                           const vv_field_info *info, vv_notes *notes, vv_job *job)
{
    vv_file *file = NULL;
    const vv_status st = file_new(&file, name, job);
    *out = NULL;
    if (file) {
        vvi_notes_free(file->notes);
        file->notes = notes;
        file->format = format;
        file->plan = plan;
        file->info = *info;
    } else {
        vvi_notes_free(notes);
        format->free_plan(plan);
    }
    if (st == VV_OK)
        *out = file;
    else
        vv_file_close(file);
    return st;
}

void vvi_file_take_origin(vv_file *file, vv_file *origin, bool new_values)
{
    file->origin = origin;
    file->new_values = new_values;
}

const vv_file *vvi_file_origin(const vv_file *file, bool *new_values_out)
{
    *new_values_out = file->new_values;
    return file->origin ? file->origin : file;
}

/* Of a collection no file is one itself: it could name itself. */
static vv_status open_beside(vv_file *file, const vv_source *folder, const char *name, const vv_read_options *options,
                             vv_job *job)
{
    vv_status st = vvi_source_open_input_beside(&file->source, folder, name, job);
    if (st != VV_OK)
        return st;
    vvi_notes_hush(file->notes);
    if ((st = take_name(file)) != VV_OK || (st = choose_format(file, options, job)) != VV_OK)
        return st;
    if (file->format->free_plan == vvi_steps_free)
        return vv_fail_at(VV_E_FORMAT, file->name, NULL, "is a collection in another; name its files themselves");
    return open_as(file, file->name, options, job);
}

vv_status vvi_file_open_beside(vv_file **out, const vv_source *folder, const char *name, const vv_read_options *options,
                               vv_job *job)
{
    vv_file *file;
    *out = NULL;
    vv_status st = file_new(&file, name, job);
    if (st == VV_OK)
        st = open_beside(file, folder, name, options, job);
    if (st == VV_OK)
        *out = file;
    else
        vv_file_close(file);
    return st;
}

vv_status vv_file_open(vv_file **out, const char *path, const vv_read_options *options, vv_job *job)
{
    *out = NULL;
    vv_read_options known;
    vv_read_options_init(&known, sizeof known);
    vvi_options_over(&known, sizeof known, options);
    vv_file *file;
    vv_status st = file_new(&file, strcmp(path, "-") == 0 ? "standard input" : path, job);
    if (st == VV_OK)
        st = vvi_job_safe(job) || vvi_job_distrusts(job, path) ? open_by_import(file, path, &known, job)
                                                               : open_here(file, path, &known, job);
    if (st != VV_OK) {
        vv_file_close(file);
        return st;
    }
    *out = file;
    return VV_OK;
}

void vv_file_close(vv_file *file)
{
    if (!file)
        return;
    if (file->plan && file->format->free_plan)
        file->format->free_plan(file->plan);
    vvi_import_close(file->import); /* before the source, which it uses */
    vvi_notes_free(file->notes);
    vvi_source_close(file->source);
    free(file->name);
    free(file->left_out);
    vv_file_close(file->origin);
    vvi_free(file);
}

const vv_field_info *vv_file_info(const vv_file *file)
{
    return file->left_out ? &file->left_out->rest : &file->info;
}

bool vvi_file_has_boxes(const vv_file *file)
{
    return file->format->boxes && !file->left_out;
}

const char *vv_file_format(const vv_file *file)
{
    return file->format->name;
}

bool vv_file_metadata(const vv_file *file, size_t index, const char **key_out, const char **value_out)
{
    return vvi_notes_get(file->notes, index, key_out, value_out);
}

const char *vv_file_warning(const vv_file *file, size_t index)
{
    return vvi_notes_warning(file->notes, index);
}

bool vv_file_part(const vv_file *file, size_t index, vv_part *out)
{
    return vvi_notes_get_part(file->notes, index, out);
}

const vv_channel *vv_file_channels(const vv_file *file, size_t *n_out)
{
    return vvi_notes_channels(file->notes, n_out);
}

const vv_label *vv_file_labels(const vv_file *file, size_t *n_out)
{
    return vvi_notes_labels(file->notes, n_out);
}

const vv_notes *vvi_file_notes(const vv_file *file)
{
    return file->notes;
}

bool vv_file_mappable(const vv_file *file)
{
    if (file->left_out)
        return false;
    if (file->import)
        return vvi_import_mappable(file->import);
    return file->format->mappable && file->format->mappable(&file->info, file->plan);
}

bool vvi_file_lacks(const vv_file *file)
{
    return file->lack.sentence[0];
}

bool vvi_file_mapped_at(const vv_file *file, const void *data, uint64_t *offset_out)
{
    return file->source && vvi_source_mapped_at(file->source, data, offset_out);
}

static vv_status check_region(const vv_file *file, const vv_box *region)
{
    for (int a = 0; region && a < 3; a++) {
        const int64_t n = file->info.grid.dims[a];
        if (region->lo[a] < 0 || region->lo[a] >= n || region->n[a] < 1 || region->n[a] > n - region->lo[a])
            return vv_fail_at(VV_E_ARGUMENT, file->name, NULL, "the box %lld + %lld along %c is not inside 0 .. %lld",
                              (long long)region->lo[a], (long long)region->n[a], 'x' + a, (long long)(n - 1));
    }
    return VV_OK;
}

vv_status vvi_file_make_repeatable(vv_file *file, vv_job *job)
{
    if (file->import)
        vvi_import_make_repeatable(file->import);
    else if (file->source)
        return vvi_source_make_repeatable(file->source, job);
    return VV_OK;
}

void vvi_file_follow(vv_file *file, unsigned follow)
{
    file->follow |= follow;
    if (file->source)
        vvi_source_follow(file->source, file->follow);
    if (file->import)
        vvi_import_follow(file->import, file->follow);
}

void vvi_file_tell_unproven(vv_file *file, vv_job *job)
{
    if (file->source && !file->import)
        vvi_source_tell_unproven(file->source, job);
}

vv_status vvi_file_leave_out(vv_file *file, const double *values, size_t n)
{
    free(file->left_out);
    file->left_out = NULL;
    return n ? vvi_leaving_new(&file->left_out, &file->info, values, n, file->name, file->notes) : VV_OK;
}

bool vvi_file_padding(double out[2], const vv_file *file)
{
    return !file->left_out && !vv_type_is_float(file->info.type) && vvi_notes_padding(out, file->notes);
}

void vvi_file_tell_padding(const vv_file *file, vv_field *field)
{
    double padding[2];
    if (vvi_file_padding(padding, file))
        vvi_field_set_padding(field, padding[0], padding[1]);
}

static vv_status read_samples(vv_field **out, vv_file *file, int64_t frame, const vv_box *region, vv_job *job)
{
    if (file->import)
        return vvi_import_read(out, file->import, &file->info, frame, region, job);
    return file->format->read(out, &file->info, file->plan, file->source, frame, region, job);
}

vv_status vv_file_read(vv_field **out, vv_file *file, int64_t frame, const vv_box *region, vv_job *job)
{
    *out = NULL;
    if (frame < 0 || frame >= file->info.n_frames)
        return vv_fail_at(VV_E_ARGUMENT, file->name, NULL, "has no time step %lld; time steps are 0 to %lld",
                          (long long)frame, (long long)(file->info.n_frames - 1));
    vv_status st = check_region(file, region);
    if (st != VV_OK)
        return st;
    if (file->lack.sentence[0])
        return vv_fail(VV_E_FORMAT, "%s", file->lack.sentence);
    if (file->source) {
        vvi_source_use_job(file->source, job);
        vvi_source_begin_samples(file->source);
    }
    if (!file->left_out) {
        if ((st = read_samples(out, file, frame, region, job)) == VV_OK)
            vvi_file_tell_padding(file, *out);
        return st;
    }
    vv_field *all = NULL;
    if ((st = read_samples(&all, file, frame, region, job)) == VV_OK)
        st = vvi_field_all_without(out, all, file->left_out->value, file->left_out->n, job);
    vv_field_release(all);
    return st;
}
