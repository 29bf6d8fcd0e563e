/* Writing to a sink, whole or compressed, and giving its file to libraries. Where it goes is in sink_open.c, how it
 * becomes the target in sink_commit.c. */
#include "io/sink.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/sink_impl.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

vv_status vvi_sink_fail(vv_sink *s, const char *doing, int error)
{
    s->failed = true;
    return vv_fail_at(VV_E_WRITE, s->name, NULL, "%s failed after %llu bytes: %s%s", doing,
                      (unsigned long long)s->written, strerror(error),
                      s->path ? "; the old file, if any, is unchanged" : "");
}

void vvi_sink_free(vv_sink *s)
{
    if (s->library >= 0 && s->library != s->fd)
        close(s->library);
    if (s->fd >= 0)
        close(s->fd);
    if (s->temporary)
        unlink(s->temporary);
    if (s->lock >= 0)
        close(s->lock);
    if (s->held >= 0)
        close(s->held);
    vvi_sink_folder_free(s->folder);
    vvi_encoder_free(s->encoder);
    free(s->name);
    free(s->path);
    free(s->temporary);
    vvi_free(s->plain);
    vvi_free(s->coded);
    vvi_free(s->memory);
    vvi_free(s);
}

void vvi_sink_abandon(vv_sink *s)
{
    if (!s)
        return;
    for (vv_sink *b = s->beside, *next; b; b = next) {
        next = b->next;
        vvi_sink_free(b);
    }
    vvi_sink_free(s);
}

void vvi_sink_spare_inputs(vv_sink *sink)
{
    sink->spares_inputs = true;
}

const char *vvi_sink_name(const vv_sink *sink)
{
    return sink->name;
}

/* Writing ------------------------------------------------------------------------------------------------------- */

static vv_status keep(vv_sink *s, const uint8_t *data, size_t n)
{
    if (n > s->n_room - s->written) {
        const size_t room = s->written + n > 2 * s->n_room ? s->written + n : 2 * s->n_room;
        uint8_t *more = vvi_realloc(s->job, s->memory, room, VVI_MEM_SCRATCH);
        s->failed |= !more;
        if (!more)
            return vv_fail_memory(room);
        s->memory = more;
        s->n_room = room;
    }
    memcpy(s->memory + s->written, data, n);
    s->written += n;
    return VV_OK;
}

vv_status vvi_sink_count(vv_sink *s, uint64_t bytes)
{
    const uint64_t all = bytes > VVI_FILE_LEAST ? bytes : VVI_FILE_LEAST;
    if (!s->path || all <= s->counted)
        return VV_OK;
    const vv_status st = vvi_job_count_write(s->job, all - s->counted);
    s->counted = all;
    s->failed |= st != VV_OK;
    return st;
}

vv_status vvi_sink_out(vv_sink *s, const uint8_t *data, size_t n)
{
    if (s->in_memory)
        return n ? keep(s, data, n) : VV_OK;
    const vv_status counted = vvi_sink_count(s, s->written + n);
    if (counted != VV_OK)
        return counted;
    while (n > 0) {
        const ssize_t done = write(s->fd, data, n < ((size_t)1 << 30) ? n : (size_t)1 << 30);
        if (done < 0 && errno == EINTR) {
            vv_status st = vvi_job_poll(s->job);
            if (st != VV_OK)
                return st;
            continue;
        }
        if (done < 0)
            return vvi_sink_fail(s, "writing", errno);
        data += done;
        n -= (size_t)done;
        s->written += (uint64_t)done;
    }
    return VV_OK;
}

static vv_status encode(vv_sink *s, const uint8_t *data, size_t n, bool finish)
{
    vv_status st = vvi_job_poll(s->job);
    bool done = false;
    vvi_coding_step step = {.in = data, .n_in = n};
    while (st == VV_OK && (step.n_in > 0 || (finish && !done))) {
        step.out = s->coded;
        step.n_out = VVI_SINK_ROOM;
        if (!vvi_encoder_run(s->encoder, &step, finish, &done)) {
            s->failed = true;
            return vv_fail_at(VV_E_WRITE, s->name, NULL, "cannot be compressed after %llu bytes",
                              (unsigned long long)s->written);
        }
        st = vvi_sink_out(s, s->coded, VVI_SINK_ROOM - step.n_out);
    }
    return st;
}

static vv_status put(vv_sink *s, const uint8_t *data, size_t n)
{
    return s->encoder ? encode(s, data, n, false) : vvi_sink_out(s, data, n);
}

static vv_status flush_plain(vv_sink *s)
{
    const size_t n = s->n_plain;
    s->n_plain = 0;
    return n > 0 ? put(s, s->plain, n) : VV_OK;
}

vv_status vvi_sink_write(vv_sink *s, const void *data, size_t n)
{
    vv_status st = VV_OK;
    if (n > VVI_SINK_ROOM - s->n_plain && (st = flush_plain(s)) != VV_OK)
        return st;
    if (n >= VVI_SINK_ROOM) {
        /* in pieces, so that compressing a large run can be cancelled */
        for (size_t at = 0; at < n && st == VV_OK; at += VVI_SINK_ROOM)
            st = put(s, (const uint8_t *)data + at, n - at < VVI_SINK_ROOM ? n - at : VVI_SINK_ROOM);
        return st;
    }
    if (n > 0)
        memcpy(s->plain + s->n_plain, data, n);
    s->n_plain += n;
    return VV_OK;
}

vv_status vvi_sink_vprintf(vv_sink *s, const char *format, va_list args)
{
    char *text = NULL;
    const int n = vasprintf(&text, format, args);
    if (n < 0)
        return vv_fail_memory(strlen(format));
    const vv_status st = vvi_sink_write(s, text, (size_t)n);
    free(text);
    return st;
}

vv_status vvi_sink_printf(vv_sink *s, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    const vv_status st = vvi_sink_vprintf(s, format, args);
    va_end(args);
    return st;
}

vv_status vvi_sink_coding(vv_sink *s, int coding, int level)
{
    if (s->folder)
        return vv_fail_at(VV_E_ARGUMENT, s->name, NULL, "is a folder, which cannot be compressed as a whole");
    vv_status st = flush_plain(s);
    if (st == VV_OK && s->encoder && coding != VVI_CODING_NONE)
        return vv_fail_at(VV_E_ARGUMENT, s->name, NULL,
                          "is compressed as a whole, as its suffix says; leave the encoding at raw");
    if (st == VV_OK && s->encoder)
        st = encode(s, NULL, 0, true);
    vvi_encoder_free(s->encoder);
    s->encoder = NULL;
    if (st != VV_OK || coding == VVI_CODING_NONE)
        return st;
    if (!s->coded && !(s->coded = vvi_alloc(s->job, VVI_SINK_ROOM, VVI_MEM_SCRATCH)))
        return vv_fail_memory(VVI_SINK_ROOM);
    return vvi_encoder_new(&s->encoder, (vvi_coding)coding, level, s->job);
}

uint64_t vvi_sink_tell(const vv_sink *s)
{
    return s->written + (s->encoder ? 0 : s->n_plain);
}

/* Files of libraries --------------------------------------------------------------------------------------------- */

vv_status vvi_sink_file(int *fd_out, vv_sink *s)
{
    if (s->encoder)
        return vv_fail_at(VV_E_ARGUMENT, s->name, NULL,
                          "cannot be compressed as a whole: this format is written in several places at once");
    if (s->library < 0 && s->path) {
        s->library = s->fd;
    } else if (s->library < 0) {
        const char *folder = getenv("TMPDIR");
        folder = folder && *folder ? folder : "/tmp";
        s->library = open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
        if (s->library < 0)
            return vv_fail_at(VV_E_WRITE, s->name, NULL, "needs a temporary file in %.200s: %s; set TMPDIR", folder,
                              strerror(errno));
    }
    *fd_out = s->library;
    return VV_OK;
}

/* What a library wrote to a temporary file goes to the stream. */
vv_status vvi_sink_copy_library(vv_sink *s)
{
    vv_status st = VV_OK;
    if (s->library < 0 || s->library == s->fd)
        return VV_OK;
    for (off_t at = 0; st == VV_OK;) {
        const ssize_t n = pread(s->library, s->plain, VVI_SINK_ROOM, at);
        if (n < 0 && errno != EINTR)
            return vvi_sink_fail(s, "copying", errno);
        if (n == 0)
            break;
        if (n > 0)
            st = vvi_sink_out(s, s->plain, (size_t)n);
        at += n > 0 ? n : 0;
    }
    return st;
}
