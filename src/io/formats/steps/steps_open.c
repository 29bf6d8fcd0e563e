/* Looking at time steps: the first file fully, of the others that they are of the same kind; and when they were. */
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "io/formats/steps/steps.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define TIMES_TOLD 64
#define SAME_STEP 1e-3 /* times are often written with few digits */

vv_status vvi_steps_open_file(vv_file **out, const vvi_steps *steps, size_t at, const vv_source *source, vv_job *job)
{
    vv_read_options options;
    vv_read_options_init(&options, sizeof options);
    options.format = steps->format;
    options.raw = steps->raw;
    options.part = steps->part;
    options.finest = steps->finest;
    return vvi_file_open_beside(out, source, steps->file[at].name, &options, job);
}

/* Times ----------------------------------------------------------------------------------------------------------- */

/* What a file says of when it is: a number, with a unit where it has one. */
static void take_time(vvi_steps *steps, size_t at, const vv_file *file)
{
    const char *key, *value, *end;
    double time;
    for (size_t i = 0; vv_file_metadata(file, i, &key, &value); i++) {
        if (strcmp(key, "time") != 0 || !vvi_scan_number(&time, value, &end) || end == value || !isfinite(time))
            continue;
        steps->file[at].time = time;
        steps->file[at].timed = true;
        end += strspn(end, " ");
        if (strlen(end) < sizeof steps->time_unit && !strpbrk(end, "0123456789 "))
            snprintf(steps->time_unit, sizeof steps->time_unit, "%s", end);
    }
}

/* The first may be at 0 and not say it. */
static bool are_timed(vvi_steps *steps)
{
    for (size_t i = 1; i < steps->n; i++)
        if (!steps->file[i].timed)
            return false;
    steps->file[0].timed = true;
    return steps->n > 1;
}

static vv_status note_times(const vvi_steps *steps, vv_notes *notes)
{
    vvi_text t = {0};
    char number[32];
    for (size_t i = 0; i < steps->n && i < TIMES_TOLD; i++) {
        vvi_print_unsigned_zero(number, steps->file[i].time);
        vvi_text_printf(&t, "%s%s", i ? ", " : "", number);
    }
    if (steps->n > TIMES_TOLD) {
        vvi_print_unsigned_zero(number, steps->file[steps->n - 1].time);
        vvi_text_printf(&t, ", ... to %s", number);
    }
    if (steps->time_unit[0])
        vvi_text_printf(&t, " %s", steps->time_unit);
    const vv_status st = t.bad ? vv_fail_memory(t.n) : vvi_notes_add(notes, "times", t.s);
    vvi_text_free(&t);
    return st;
}

static vv_status fill_times(vv_field_info *info, vvi_steps *steps, vv_notes *notes)
{
    if (!are_timed(steps))
        return VV_OK;
    const vvi_steps_file *f = steps->file;
    const double step = (f[steps->n - 1].time - f[0].time) / (double)(steps->n - 1);
    bool even = true;
    vv_status st = note_times(steps, notes);
    for (size_t i = 1; i < steps->n && st == VV_OK; i++) {
        if (!(f[i].time > f[i - 1].time))
            return vvi_notes_warn(notes,
                                  "'%.80s' is not later than '%.80s', as the times in them say (%g and %g); they are "
                                  "taken in the order of their names, without times",
                                  f[i].name, f[i - 1].name, f[i].time, f[i - 1].time);
        even = even && fabs(f[i].time - f[0].time - (double)i * step) <= SAME_STEP * step;
    }
    if (st != VV_OK || !even)
        return st == VV_OK ? vvi_notes_warn(notes,
                                            "its time steps are uneven, from %g to %g; they are shown one after "
                                            "another",
                                            f[0].time, f[steps->n - 1].time)
                           : st;
    info->frame_step = step;
    memcpy(info->frame_unit, steps->time_unit, sizeof info->frame_unit);
    return VV_OK;
}

/* Numbers that the names leave out; the first place is told. */
static vv_status tell_gaps(const vvi_steps *steps, vv_notes *notes)
{
    const vvi_steps_file *f = steps->file;
    uint64_t least = UINT64_MAX, missing = 0;
    size_t at = 0;
    for (size_t i = 1; i < steps->n; i++)
        least = f[i].number - f[i - 1].number < least ? f[i].number - f[i - 1].number : least;
    for (size_t i = steps->n; i-- > 1 && least > 0;) {
        const uint64_t grown = f[i].number - f[i - 1].number;
        missing += grown / least - 1;
        at = grown > least ? i : at;
    }
    if (missing == 0)
        return VV_OK;
    return vvi_notes_warn(notes,
                          "the numbers of its files have gaps: '%.80s' follows '%.80s', %" PRIu64
                          " in all seem to be missing; the %zu that are there are numbered from 0",
                          f[at].name, f[at - 1].name, missing, steps->n);
}

/* Files ----------------------------------------------------------------------------------------------------------- */

static vv_status copy_notes(vv_notes *to, const vv_file *file)
{
    const char *key, *value, *warning;
    const void *kept;
    size_t n;
    int32_t code;
    vv_part part;
    vv_status st = VV_OK;
    const vv_notes *from = vvi_file_notes(file);
    for (size_t i = 0; st == VV_OK && vvi_notes_get(from, i, &key, &value); i++)
        st = strcmp(key, "time") == 0 ? VV_OK : vvi_notes_add(to, key, value);
    for (size_t i = 0; st == VV_OK && (warning = vvi_notes_warning(from, i)) != NULL; i++)
        st = vvi_notes_warn(to, "%s", warning);
    for (size_t i = 0; st == VV_OK && vvi_notes_get_part(from, i, &part); i++)
        st = vvi_notes_part(to, part.name, part.about, part.chosen);
    const vv_channel *channels = vvi_notes_channels(from, &n);
    for (size_t i = 0; st == VV_OK && i < n; i++)
        st = vvi_notes_channel(to, &channels[i]);
    const vv_label *labels = vvi_notes_labels(from, &n);
    for (size_t i = 0; st == VV_OK && i < n; i++)
        st = vvi_notes_label(to, &labels[i]);
    for (size_t i = 0; st == VV_OK && (kept = vvi_notes_kept(from, i, &code, &n)) != NULL; i++)
        st = vvi_notes_keep(to, code, kept, n);
    return st;
}

/* The files are a part of their folder where they have none themselves. */
static vv_status note_files(const vvi_steps *steps, const vv_file *first, vv_notes *notes)
{
    char text[400];
    vv_part part;
    snprintf(text, sizeof text, "%.250s: %zu time steps, %s", steps->key, steps->n, vv_file_format(first));
    vv_status st = vvi_notes_add(notes, "files", text);
    if (st != VV_OK || vv_file_part(first, 0, &part))
        return st;
    snprintf(text, sizeof text, "%zu time steps", steps->n);
    return vvi_notes_part(notes, steps->key, text, true);
}

static vv_status look_at(vvi_steps *steps, size_t at, vv_source *source, vv_notes *notes, vv_job *job)
{
    vv_file *file;
    vv_status st = vvi_steps_open_file(&file, steps, at, source, job);
    if (st != VV_OK)
        return st;
    if (at == 0) {
        steps->info = *vv_file_info(file);
        steps->mappable = vv_file_mappable(file);
        if ((st = note_files(steps, file, notes)) == VV_OK)
            st = copy_notes(notes, file);
    }
    if (st == VV_OK)
        st = vvi_steps_check(vv_file_info(file), steps->file[at].name, &steps->info, steps->file[0].name, source);
    const vv_field_info *info = vv_file_info(file);
    steps->values |= info->value_scale != steps->info.value_scale || info->value_offset != steps->info.value_offset;
    if (!steps->file[at].timed)
        take_time(steps, at, file);
    vv_file_close(file);
    return st;
}

static vv_status check_numbers(const vvi_steps *steps, const vv_source *source)
{
    for (size_t i = 1; i < steps->n; i++)
        if (steps->file[i].number == steps->file[i - 1].number)
            return vv_fail_at(VV_E_ARGUMENT, vvi_source_name(source), NULL,
                              "'%.80s' and '%.80s' have the same number; choose files by a pattern of their names, as "
                              "FOLDER:a_*_{t}.vti",
                              steps->file[i - 1].name, steps->file[i].name);
    return VV_OK;
}

vv_status vvi_steps_open(vv_field_info *info, vvi_steps *steps, vv_source *source, vv_notes *notes, vv_job *job)
{
    vv_status st = check_numbers(steps, source);
    for (size_t i = 0; i < steps->n && st == VV_OK; i++)
        if ((st = vvi_job_progress(job, "look", i, steps->n)) == VV_OK)
            st = look_at(steps, i, source, notes, job);
    if (st != VV_OK || (st = tell_gaps(steps, notes)) != VV_OK)
        return st;
    *info = steps->info;
    info->n_frames = (int64_t)steps->n;
    if (steps->values) {
        info->type = info->type == VV_TYPE_F64 ? VV_TYPE_F64 : VV_TYPE_F32;
        info->value_scale = 1;
        info->value_offset = 0;
        steps->mappable = false;
        st = vvi_notes_add(notes, "values", "each file has a scale of its own: samples are what they mean");
    }
    if (st == VV_OK)
        st = fill_times(info, steps, notes);
    return st == VV_OK && !steps->part ? vvi_notes_warn_unnamed(notes, vvi_source_name(source), "parts in each file")
                                       : st;
}
