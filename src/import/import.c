#include "import/import.h"
#include "core/job.h"
#include "core/limits.h"
#include "core/memory.h"
#include "grid/field.h"
#include "import/import_listen.h"
#include "import/import_room.h"
#include "io/format.h"
#include "io/layout.h"
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct vvi_import {
    vvi_import_process process;
    char *path; /* and how it is opened: for a second process after the first was stopped by cancel */
    char *format, *raw, *part;
    bool finest, any_part;
    vv_source *source; /* the same file, opened here; NULL: nothing of it is. Borrowed */
    bool mappable;     /* by what the import program says */
    bool repeatable;   /* what comes by a pipe is kept for a second time */
    unsigned follow;   /* VVI_FOLLOW_* */
};

static char *copy_or_null(const char *text, bool *lacks)
{
    char *copy = text ? vvi_strdup(text) : NULL;
    *lacks = *lacks || (text && !copy);
    return copy;
}

static vv_status import_new(vvi_import **out, const char *path, const vv_read_options *options)
{
    bool lacks = false;
    vvi_import *import = vvi_calloc(1, sizeof *import);
    *out = NULL;
    if (!import)
        return vv_fail_memory(sizeof *import);
    import->process.socket = import->process.input = -1;
    import->path = copy_or_null(path, &lacks);
    import->format = copy_or_null(options->format, &lacks);
    import->raw = copy_or_null(options->raw, &lacks);
    import->part = copy_or_null(options->part, &lacks);
    import->finest = options->finest;
    import->any_part = options->any_part;
    if (lacks) {
        vvi_import_close(import);
        return vv_fail_memory(strlen(path));
    }
    import->process.endless = strcmp(path, "-") == 0;
    import->process.name = import->process.endless ? "standard input" : import->path;
    *out = import;
    return VV_OK;
}

/* Whether it finds the same bytes under the path: of a stream some have been taken, and /proc and /dev/fd are its own.
 */
static bool can_open_itself(const char *path)
{
    struct stat about;
    return strncmp(path, "/dev/fd/", 8) != 0 && strncmp(path, "/dev/std", 8) != 0 && strncmp(path, "/proc/", 6) != 0 &&
           strcmp(path, "-") != 0 && stat(path, &about) == 0 && (S_ISREG(about.st_mode) || S_ISDIR(about.st_mode));
}

/* A stream that was looked at goes to a temporary file first, which the import program has as its standard input. */
static vv_status hand_over(vvi_import *import, vv_source *source, vv_job *job)
{
    vv_status st;
    import->source = source;
    if (can_open_itself(import->path))
        return VV_OK;
    if ((st = vvi_source_spool(source, job)) != VV_OK)
        return st;
    import->process.input = open(vvi_source_path(source), O_RDONLY | O_CLOEXEC);
    if (import->process.input < 0)
        return vv_fail_at(VV_E_READ, import->process.name, NULL, "cannot be opened again: %s", strerror(errno));
    free(import->path);
    import->path = vvi_strdup("-");
    import->process.name = "standard input";
    import->process.endless = false;
    return import->path ? VV_OK : vv_fail_memory(2);
}

void vvi_import_close(vvi_import *import)
{
    if (!import)
        return;
    vvi_import_stop(&import->process);
    if (import->process.input >= 0)
        close(import->process.input);
    free(import->path);
    free(import->format);
    free(import->raw);
    free(import->part);
    free(import);
}

/* Opening --------------------------------------------------------------------------------------------------------- */

static vv_status ask_to_open(vvi_import *import, vv_job *job)
{
    int fd;
    vvi_text body = {0};
    vv_status st = vvi_import_open_place(&fd, import->path, job);
    if (st != VV_OK)
        return st;
    vvi_import_put_file(&body, import->path, job);
    vvi_wire_put_text(&body, import->format);
    vvi_wire_put_text(&body, import->raw);
    vvi_wire_put_text(&body, import->part);
    vvi_wire_put_number(&body, import->finest);
    vvi_wire_put_number(&body, import->any_part);
    vvi_import_put_terms(&body, job);
    st = vvi_import_ask(&import->process, VVI_WIRE_OPEN, &body, fd);
    vvi_text_free(&body);
    if (fd >= 0)
        close(fd);
    return st;
}

/* As file.c does it with what a reader here has said. */
static vv_status take_opened(vv_field_info *info_out, const vv_format **format_out, vvi_import *import, vvi_wire_in *in,
                             vv_job *job)
{
    vvi_import_process *p = &import->process;
    const char *format = vvi_wire_take_text(in);
    vvi_wire_take(in, info_out, sizeof *info_out);
    import->mappable = vvi_wire_take_between(in, 0, 1) == 1;
    if (!vvi_wire_taken(in) || vvi_format_named(format_out, format, vvi_job_registry(job)) != VV_OK)
        return vvi_import_nonsense(p, "a format that does not exist");
    if (vv_field_info_check(info_out) != VV_OK)
        return vvi_import_nonsense(p, vv_error_last()->message);
    return VV_OK;
}

static vv_status start_and_open(vvi_import *import, vv_field_info *info_out, const vv_format **format_out,
                                vv_notes *notes, vv_job *job)
{
    vvi_wire_in in;
    vv_status st = vvi_import_start(&import->process, job);
    if (st != VV_OK || (st = ask_to_open(import, job)) != VV_OK ||
        (st = vvi_import_listen(&import->process, VVI_WIRE_OPENED, &in, notes, job)) != VV_OK)
        return st;
    return take_opened(info_out, format_out, import, &in, job);
}

vv_status vvi_import_open(vvi_import **out, vv_field_info *info_out, const vv_format **format_out, const char *path,
                          vv_source *source, const vv_read_options *options, vv_notes *notes, vv_job *job)
{
    vvi_import *import;
    *out = NULL;
    if (vvi_job_registry(job) != vv_registry_builtin() && !vvi_job_import_program(job))
        return vv_fail_at(VV_E_UNSUPPORTED, path, NULL, "the import program knows only the formats that are built in");
    vv_status st = import_new(&import, path, options);
    if (st != VV_OK)
        return st;
    if ((source && (st = hand_over(import, source, job)) != VV_OK) ||
        (st = start_and_open(import, info_out, format_out, notes, job)) != VV_OK) {
        vvi_import_close(import);
        return st;
    }
    *out = import;
    return VV_OK;
}

bool vvi_import_mappable(const vvi_import *import)
{
    return import->mappable && import->source && vvi_source_mappable(import->source, 0, 1);
}

void vvi_import_make_repeatable(vvi_import *import)
{
    import->repeatable = true;
}

void vvi_import_follow(vvi_import *import, unsigned follow)
{
    import->follow = follow;
}

/* Samples --------------------------------------------------------------------------------------------------------- */

static bool is_the_same_kind(const vv_field_info *a, const vv_field_info *b)
{
    return memcmp(a->grid.dims, b->grid.dims, sizeof a->grid.dims) == 0 && a->type == b->type &&
           a->components == b->components && a->meaning == b->meaning && a->n_frames == b->n_frames;
}

/* After a cancel the process is gone: the next read begins with a new one, if the file is still what it was. */
static vv_status start_again(vvi_import *import, const vv_field_info *info, vv_job *job)
{
    vv_field_info again;
    const vv_format *format;
    vv_notes *notes;
    if (import->process.socket >= 0)
        return VV_OK;
    if (import->process.endless)
        return vv_fail_at(VV_E_UNSUPPORTED, import->process.name, NULL,
                          "is a stream and cannot be read twice; save it to a file first");
    vv_status st = vvi_notes_new(&notes, job);
    if (st != VV_OK)
        return st;
    st = start_and_open(import, &again, &format, notes, job);
    vvi_notes_free(notes);
    if (st == VV_OK && !is_the_same_kind(&again, info)) {
        vvi_import_stop(&import->process);
        return vv_fail_at(VV_E_READ, import->process.name, NULL, "has changed since it was opened; open it again");
    }
    return st;
}

static vv_status ask_to_read(vvi_import *import, int64_t frame, const vv_box *box, int fd)
{
    vvi_text body = {0};
    vvi_wire_put_number(&body, import->repeatable);
    vvi_wire_put_number(&body, import->follow);
    vvi_wire_put_number(&body, vvi_import_mappable(import));
    vvi_wire_put_number(&body, frame);
    vvi_wire_put_number(&body, box != NULL);
    vvi_wire_put(&body, box ? box : &(vv_box){0}, sizeof *box);
    vv_status st = vvi_import_ask(&import->process, VVI_WIRE_READ, &body, fd);
    vvi_text_free(&body);
    return st;
}

/* What the field will be, as far as the rest relies on it. */
static vv_field_info expected_info(const vv_field_info *info, int64_t frame, const vv_box *region)
{
    vv_field_info want = *info;
    if (region)
        want.grid = vv_grid_crop(&info->grid, region);
    want.frame = frame;
    return want;
}

/* *offset_out: where the samples lie in the file; negative when they are in the memory that is shared. */
static vv_status take_done(vv_field_info *got, int64_t *offset_out, vvi_import_process *p, vvi_wire_in *in,
                           const vv_field_info *want, vv_job *job)
{
    vvi_wire_take(in, got, sizeof *got);
    const bool damaged = vvi_wire_take_between(in, 0, 1) == 1;
    *offset_out = vvi_wire_take_between(in, -1, INT64_MAX);
    if (!vvi_wire_taken(in) || !is_the_same_kind(got, want))
        return vvi_import_nonsense(p, "samples other than those that were asked for");
    if (vv_field_info_check(got) != VV_OK)
        return vvi_import_nonsense(p, vv_error_last()->message);
    if (damaged)
        vvi_job_mark_damaged(job);
    return VV_OK;
}

/* Samples that lie in the file as they are: mapped here as well, where the import program only said where. */
static vv_status map_here(vv_field **out, vvi_import *import, const vv_field_info *got, int64_t offset, vv_job *job)
{
    uint64_t bytes;
    vv_status st = vv_field_info_bytes(&bytes, got);
    if (st != VV_OK)
        return st;
    if (!vvi_import_mappable(import) || (uint64_t)offset % vv_type_bytes(got->type) != 0 ||
        !vvi_source_mappable(import->source, (uint64_t)offset, bytes))
        return vvi_import_nonsense(&import->process, "samples where there are none");
    return vvi_layout_map(out, got, import->source, (uint64_t)offset, bytes, job);
}

/* Into the memory or, where they can be used as they lie, from the file; *out is NULL for the first. */
static vv_status ask_for_samples(vv_field **out, vv_field_info *got, vvi_import *import, vvi_import_room *samples,
                                 int fd, const vv_field_info *want, const vv_box *region, vv_job *job)
{
    vvi_wire_in in;
    int64_t offset;
    vv_status st = vvi_import_mappable(import) ? VV_OK : vvi_import_room_count(samples, job);
    if (st != VV_OK || (st = ask_to_read(import, want->frame, region, fd)) != VV_OK ||
        (st = vvi_import_listen(&import->process, VVI_WIRE_DONE, &in, NULL, job)) != VV_OK ||
        (st = take_done(got, &offset, &import->process, &in, want, job)) != VV_OK)
        return st;
    if (offset >= 0)
        return map_here(out, import, got, offset, job);
    if ((st = vvi_import_room_count(samples, job)) == VV_OK && !vvi_import_room_seal(samples, fd))
        st = vvi_import_nonsense(&import->process, "samples that it still holds");
    return st;
}

vv_status vvi_import_read(vv_field **out, vvi_import *import, const vv_field_info *info, int64_t frame,
                          const vv_box *region, vv_job *job)
{
    const vv_field_info want = expected_info(info, frame, region);
    vv_field_info got;
    vvi_import_room *samples;
    uint64_t bytes;
    int fd;
    *out = NULL;
    vv_status st = vv_field_info_bytes(&bytes, &want);
    if (st != VV_OK || (st = start_again(import, info, job)) != VV_OK ||
        (st = vvi_import_room_new(&samples, &fd, bytes + VVI_FIELD_GUARD)) != VV_OK)
        return st;
    st = ask_for_samples(out, &got, import, samples, fd, &want, region, job);
    close(fd);
    if (st != VV_OK || *out) {
        vvi_import_room_free(samples);
        return st;
    }
    return vv_field_new(out, &got, samples->data, VVI_FIELD_GUARD, vvi_import_room_free, samples, job);
}
