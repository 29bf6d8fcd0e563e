/* What is said to every import program, and what may come from it at any time. */
#include "import/import_listen.h"
#include "core/allowed_places.h"
#include "core/job.h"
#include "core/limits.h"
#include "core/memory.h"
#include "io/store_impl.h"
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <volvis/version.h>

vv_status vvi_import_open_place(int *fd_out, const char *path, const vv_job *job)
{
    struct stat about;
    *fd_out = -1;
    if (strcmp(path, "-") == 0)
        return VV_OK;
    const bool plain = stat(path, &about) == 0 && (S_ISREG(about.st_mode) || S_ISDIR(about.st_mode));
    if (plain)
        *fd_out = vvi_open_place(path, O_RDONLY, false, job);
    if (*fd_out < 0 && errno == EXDEV && vvi_job_confined(job))
        return vv_fail_at(VV_E_READ, path, NULL, "lies outside the folder that may be read");
    if (*fd_out < 0 && vvi_job_confined(job))
        return vv_fail_at(VV_E_READ, path, NULL, "%s", plain || errno ? strerror(errno) : "is neither file nor folder");
    return VV_OK;
}

/* Where files are read in some places alone, its real path: links in it are then none that were there. */
void vvi_import_put_file(vvi_text *out, const char *path, const vv_job *job)
{
    char *real = vvi_job_confined(job) && strcmp(path, "-") != 0 ? realpath(path, NULL) : NULL;
    vvi_wire_put_number(out, VVI_WIRE_VERSION);
    vvi_wire_put_text(out, vv_version());
    vvi_wire_put_text(out, real ? real : path);
    free(real);
}

/* Memory: what is still free here, since what is read will be here as well. */
void vvi_import_put_terms(vvi_text *out, const vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    const uint64_t limit = vv_runtime_memory_limit(runtime), used = vv_runtime_memory_used(runtime);
    vvi_wire_put_number(out, vv_runtime_threads(runtime));
    vvi_wire_put_number(out, (int64_t)(used < limit ? limit - used : 1));
    vvi_wire_put_number(out, vvi_job_allow_outside(job));
    vvi_wire_put_number(out, vvi_job_log_level(job));
    vvi_wire_put_number(out, gettid() == getpid()); /* this thread ends when the process does, no sooner */
    vvi_wire_put_number(out, vvi_job_confined(job));
    vvi_wire_put(out, vvi_job_limits(job), sizeof(vv_limits));
}

static void take_log(vvi_wire_in *in, const vv_notes *notes, vv_job *job)
{
    const vv_log_level level = (vv_log_level)vvi_wire_take_between(in, VV_LOG_ERROR, VV_LOG_DEBUG);
    const char *text = vvi_wire_take_text(in);
    if (!in->bad && !(notes && vvi_notes_are_hushed(notes)))
        vvi_log(job, level, "io", "%s", text);
}

/* The error that ended what was asked for becomes this thread's. */
static vv_status take_failure(vvi_import_process *p, vvi_wire_in *in)
{
    const int64_t status = vvi_wire_take_between(in, VV_E_INTERNAL, VV_E_ARGUMENT);
    const char *message = vvi_wire_take_text(in), *file = vvi_wire_take_text_or_null(in),
               *where = vvi_wire_take_text_or_null(in);
    if (!vvi_wire_taken(in))
        return vvi_import_nonsense(p, "an error that cannot be read");
    vvi_error_copy copy = {
        .status = (vv_status)status,
        /* it has its own share of the memory: --memory would not help */
        .message = status == VV_E_MEMORY && !strstr(message, "--limit ")
                       ? vvi_asprintf("%s; --limit import_bytes=N gives the import program more", message)
                       : vvi_strdup(message),
        .file = file ? vvi_strdup(file) : NULL,
        .where = where ? vvi_strdup(where) : NULL,
    };
    return vvi_error_put(&copy);
}

static vv_status take_note(vv_notes *notes, vvi_wire_kind kind, vvi_wire_in *in)
{
    if (kind == VVI_WIRE_CHANNEL) {
        const vv_channel channel = vvi_wire_take_channel(in);
        return vvi_notes_channel(notes, &channel);
    }
    if (kind == VVI_WIRE_LABEL) {
        vv_code codes[VV_LABEL_CODES];
        const vv_label label = vvi_wire_take_label(in, codes);
        return vvi_notes_label(notes, &label);
    }
    if (kind == VVI_WIRE_KEPT) {
        const int32_t code = (int32_t)vvi_wire_take_between(in, INT32_MIN, INT32_MAX);
        const size_t n = (size_t)vvi_wire_take_between(in, 0, INT64_MAX);
        const void *bytes = vvi_wire_take_bytes(in, n);
        return bytes ? vvi_notes_keep(notes, code, bytes, n) : VV_OK; /* what is missing is told by who asked */
    }
    const char *first = vvi_wire_take_text(in);
    if (kind == VVI_WIRE_WARNING)
        return vvi_notes_warn(notes, "%s", first);
    const char *second = vvi_wire_take_text(in);
    if (kind == VVI_WIRE_METADATA)
        return vvi_notes_add(notes, first, second);
    return vvi_notes_part(notes, first, second, vvi_wire_take_between(in, 0, 1) == 1);
}

vv_status vvi_import_listen(vvi_import_process *p, vvi_wire_kind last, vvi_wire_in *in, vv_notes *notes, vv_job *job)
{
    vvi_wire_kind kind;
    for (;;) {
        vv_status st = vvi_import_receive(p, &kind, in, job);
        if (st != VV_OK || kind == last)
            return st;
        if (kind == VVI_WIRE_FAILED)
            return take_failure(p, in);
        if (kind == VVI_WIRE_LOG) {
            take_log(in, notes, job);
        } else if (kind == VVI_WIRE_PROGRESS) {
            const int64_t done = vvi_wire_take_between(in, 0, INT64_MAX);
            vvi_job_progress(job, "read", (uint64_t)done, (uint64_t)vvi_wire_take_between(in, done, INT64_MAX));
        } else if (kind < VVI_WIRE_OPENED && notes) {
            st = take_note(notes, kind, in);
        } else {
            return vvi_import_nonsense(p, "an answer to another question");
        }
        if (st != VV_OK)
            return st;
        if (!vvi_wire_taken(in))
            return vvi_import_nonsense(p, "a message that does not hold what it should");
    }
}
