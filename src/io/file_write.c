#include "core/job.h"
#include "core/memory.h"
#include "grid/true_values.h"
#include "io/coding.h"
#include "io/format.h"
#include "io/formats/nifti/nifti.h"
#include "io/formats/slices/slices_write.h"
#include "io/sink.h"
#include "registry.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/property.h>

void vv_write_options_init(vv_write_options *options, size_t size)
{
    const vv_write_options defaults = {.size = size};
    memset(options, 0, size);
    memcpy(options, &defaults, size < sizeof defaults ? size : sizeof defaults);
}

/* Frames of one series share everything but their samples and number. */
static vv_status check_frames(const vv_field *const *frames, size_t n_frames)
{
    if (n_frames < 1)
        return vv_fail(VV_E_ARGUMENT, "there is no time step to write");
    const vv_field_info *first = vv_field_get_info(frames[0]);
    for (size_t i = 1; i < n_frames; i++) {
        const vv_field_info *other = vv_field_get_info(frames[i]);
        if (memcmp(first->grid.dims, other->grid.dims, sizeof first->grid.dims) != 0 || first->type != other->type ||
            first->components != other->components)
            return vv_fail(VV_E_ARGUMENT, "time step %zu has other dims, type or channels than time step 0", i);
        if (first->value_scale != other->value_scale || first->value_offset != other->value_offset)
            return vv_fail(VV_E_ARGUMENT, "time step %zu has another scale of values than time step 0", i);
    }
    return VV_OK;
}

static vv_status write_to(vv_sink *sink, const vv_format *format, const char *path, const vv_field *const *frames,
                          size_t n_frames, const vv_write_options *options, vv_job *job)
{
    size_t n;
    vv_status st = VV_OK;
    const vvi_coding coding = vvi_path_coding(path, &n);
    if (coding != VVI_CODING_NONE)
        st = vvi_sink_coding(sink, (int)coding, options->level);
    return st == VV_OK ? format->write(sink, frames, n_frames, options, job) : st;
}

/* Numbers of which other readers would take no scale: they are written as the values that they mean. */
static vv_status write_values(vv_sink *sink, const vv_format *format, const char *path, const vv_field *const *frames,
                              size_t n_frames, const vv_write_options *options, vv_job *job)
{
    size_t bytes;
    vv_status st = vvi_mul_size(&bytes, n_frames, sizeof(vv_field *));
    vv_field **values = st == VV_OK ? vvi_alloc(job, bytes, VVI_MEM_SCRATCH) : NULL;
    if (!values)
        return st == VV_OK ? vv_fail_memory(bytes) : st;
    if ((st = vvi_true_values(values, frames, n_frames, format->types, job)) == VV_OK) {
        if (options->written)
            *options->written = *vv_field_get_info(values[0]);
        st = write_to(sink, format, path, (const vv_field *const *)values, n_frames, options, job);
        for (size_t i = 0; i < n_frames; i++)
            vv_field_release(values[i]);
    }
    vvi_free(values);
    return st;
}

bool vvi_format_writes_values(const vv_format *format, const vv_field_info *info, bool stored)
{
    return !stored && !format->keeps_scale && vvi_has_scale(info);
}

/* "out/slice_%03d.png": the folder, and what its files are called. */
static vv_status open_pattern(vv_sink **out, vv_write_options *options, const vv_format *format, const char *path,
                              vv_job *job)
{
    const char *encoding;
    options->names = vvi_slices_pattern(path);
    vv_status st = vvi_slices_check_pattern(&encoding, options->names, options->encoding);
    if (st != VV_OK)
        return st;
    if (options->names == path)
        return vv_fail_at(VV_E_ARGUMENT, path, NULL, "slices get a folder of their own; name it too, as FOLDER/%.80s",
                          path);
    char *folder = vvi_asprintf("%.*s", (int)(options->names - path), path);
    st = folder ? vvi_sink_open_folder(out, folder, format->folder_file, job) : vv_fail_memory(strlen(path));
    free(folder);
    return st;
}

static vv_status open_output(vv_sink **out, vv_write_options *options, const vv_format *format, const char *path,
                             vv_job *job)
{
    if (!format->folder_file)
        return vvi_sink_open(out, path, job);
    if (format == &vvi_format_slices && !options->names && vvi_slices_pattern(path))
        return open_pattern(out, options, format, path, job);
    return vvi_sink_open_folder(out, path, format->folder_file, job);
}

vv_status vv_field_write(const char *path, const vv_field *const *frames, size_t n_frames,
                         const vv_write_options *options, vv_job *job)
{
    const vv_registry *registry = vvi_job_registry(job);
    vv_write_options known;
    const vv_format *format;
    vv_sink *sink;
    vv_write_options_init(&known, sizeof known);
    vvi_options_over(&known, sizeof known, options);
    vv_status st = check_frames(frames, n_frames);
    if (st != VV_OK)
        return st;
    st = known.format ? vvi_format_named(&format, known.format, registry)
                      : vvi_format_of_output(&format, path, registry);
    if (st != VV_OK)
        return st;
    if (!format->write)
        return vv_fail_at(VV_E_UNSUPPORTED, path, NULL,
                          "the format %s can only be read; 'volvis formats' shows what can be written", format->name);
    if (known.level < 0 || known.level > 9)
        return vv_fail(VV_E_ARGUMENT, "level is %d; expected 1 (fast) to 9 (small), or 0 for the default", known.level);
    if ((st = vvi_format_check_encoding(format, known.encoding)) != VV_OK ||
        (st = open_output(&sink, &known, format, path, job)) != VV_OK)
        return st;
    if (known.spare_inputs)
        vvi_sink_spare_inputs(sink);
    if (known.written)
        *known.written = *vv_field_get_info(frames[0]);
    st = vvi_format_writes_values(format, vv_field_get_info(frames[0]), known.stored)
             ? write_values(sink, format, path, frames, n_frames, &known, job)
             : write_to(sink, format, path, frames, n_frames, &known, job);
    for (size_t i = 0; i < n_frames && st == VV_OK; i++) /* before anything is where it shall be */
        st = vv_field_health(frames[i]);
    if (st != VV_OK) {
        vvi_sink_abandon(sink);
        return st;
    }
    vvi_nifti_log_lost(path, format->name, &known, job);
    return vvi_sink_commit(sink);
}
