#include "core/job.h"
#include "core/memory.h"
#include "io/format.h"
#include "io/notes.h"
#include <string.h>

struct vv_file {
    const vv_format *format;
    vv_source *source;
    vv_notes *notes;
    void *plan;
    vv_field_info info;
};

void vv_read_options_init(vv_read_options *options, size_t size)
{
    const vv_read_options defaults = {.size = size};
    memset(options, 0, size);
    memcpy(options, &defaults, size < sizeof defaults ? size : sizeof defaults);
}

/* What the caller's struct does not have yet stays at its default. */
static vv_read_options known_options(const vv_read_options *options)
{
    vv_read_options known;
    vv_read_options_init(&known, sizeof known);
    if (options)
        memcpy(&known, options, options->size < sizeof known ? options->size : sizeof known);
    known.size = sizeof known;
    return known;
}

static vv_status choose_format(vv_file *file, const vv_read_options *options, vv_job *job)
{
    const vv_registry *registry = vvi_job_registry(job);
    if (options->format)
        return vvi_format_named(&file->format, options->format, registry);
    if (options->raw)
        return vvi_format_named(&file->format, "raw", registry);
    size_t n;
    const uint8_t *head = vvi_source_peek(file->source, 4096, &n);
    if (!head)
        return vv_error_last()->status;
    return vvi_format_of_file(&file->format, head, n, vvi_source_name(file->source), registry);
}

static vv_status read_header(vv_file *file, const vv_read_options *options, vv_job *job)
{
    file->info = vv_field_info_default();
    if (!file->format->read_header || !file->format->read)
        return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(file->source), NULL, "the format %s can only be written",
                          file->format->name);
    vv_status st = file->format->read_header(&file->info, &file->plan, file->source, options, file->notes, job);
    if (st != VV_OK)
        return st;
    uint64_t bytes;
    if ((st = vv_field_info_check(&file->info)) == VV_OK)
        st = vv_field_info_bytes(&bytes, &file->info);
    return st == VV_OK ? VV_OK : vv_fail_in(st, "%s", vvi_source_name(file->source));
}

static void log_warnings(const vv_file *file, const vv_job *job)
{
    const char *text;
    for (size_t i = 0; (text = vvi_notes_warning(file->notes, i)) != NULL; i++)
        vvi_log(job, VV_LOG_WARNING, "io", "%s: %s", vvi_source_name(file->source), text);
}

vv_status vv_file_open(vv_file **out, const char *path, const vv_read_options *options, vv_job *job)
{
    *out = NULL;
    const vv_read_options known = known_options(options);
    vv_file *file = vvi_alloc_zeroed(job, sizeof *file, VVI_MEM_MODEL);
    if (!file)
        return vv_fail_memory(sizeof *file);
    vv_status st = vvi_source_open(&file->source, path, job);
    if (st == VV_OK)
        st = vvi_notes_new(&file->notes, job);
    if (st == VV_OK)
        st = choose_format(file, &known, job);
    if (st == VV_OK)
        st = read_header(file, &known, job);
    if (st != VV_OK) {
        vv_file_close(file);
        return st;
    }
    log_warnings(file, job);
    vvi_log(job, VV_LOG_INFO, "io", "%s: read as %s", vvi_source_name(file->source), file->format->name);
    *out = file;
    return VV_OK;
}

void vv_file_close(vv_file *file)
{
    if (!file)
        return;
    if (file->plan && file->format->free_plan)
        file->format->free_plan(file->plan);
    vvi_notes_free(file->notes);
    vvi_source_close(file->source);
    vvi_free(file);
}

const vv_field_info *vv_file_info(const vv_file *file)
{
    return &file->info;
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

bool vv_file_mappable(const vv_file *file)
{
    return file->format->mappable && file->format->mappable(&file->info, file->plan);
}

static vv_status check_region(const vv_file *file, const vv_box *region)
{
    for (int a = 0; region && a < 3; a++) {
        const int64_t n = file->info.grid.dims[a];
        if (region->lo[a] < 0 || region->lo[a] >= n || region->n[a] < 1 || region->n[a] > n - region->lo[a])
            return vv_fail_at(VV_E_ARGUMENT, vvi_source_name(file->source), NULL,
                              "the box %lld + %lld along %c is not inside 0 .. %lld", (long long)region->lo[a],
                              (long long)region->n[a], 'x' + a, (long long)(n - 1));
    }
    return VV_OK;
}

vv_status vv_file_read(vv_field **out, vv_file *file, int64_t frame, const vv_box *region, vv_job *job)
{
    *out = NULL;
    if (frame < 0 || frame >= file->info.n_frames)
        return vv_fail_at(VV_E_ARGUMENT, vvi_source_name(file->source), NULL, "has no frame %lld; frames are 0 to %lld",
                          (long long)frame, (long long)(file->info.n_frames - 1));
    vv_status st = check_region(file, region);
    if (st != VV_OK)
        return st;
    vvi_source_use_job(file->source, job);
    return file->format->read(out, &file->info, file->plan, file->source, frame, region, job);
}
