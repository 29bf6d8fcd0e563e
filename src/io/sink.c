/* A sink writes to a file of its own beside the target. Committing syncs and renames it, so a crash leaves the old file
 * or the new one. Files that belong together hang as a list on the first; they are all synced before any is renamed,
 * and the first is renamed last, so that a header never names data that is not there. */
#include "io/sink.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/coding.h"
#include "io/sink_folder.h"
#include "io/sink_headers.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define ROOM ((size_t)256 << 10)

struct vv_sink {
    int fd;
    int library; /* what vvi_sink_file() gave out; -1: nothing */
    char *name;  /* as the caller gave it: stands in errors */
    char *path;  /* where it is going to be; links resolved. NULL: a stream that is written straight away */
    char *temporary;
    vv_job *job;    /* outlives the sink */
    uint8_t *plain; /* not yet coded or written */
    size_t n_plain;
    vvi_encoder *encoder;
    uint8_t *coded;
    uint64_t written;
    bool failed, spares_inputs;
    vv_sink *beside, *next;
    vvi_sink_folder *folder; /* NULL: it is a file */
    bool in_memory;
    uint8_t *memory; /* `written` bytes and room for more */
    size_t n_room;
};

static vv_status fail_writing(vv_sink *s, const char *doing, int error)
{
    s->failed = true;
    return vv_fail_at(VV_E_WRITE, s->name, NULL, "%s failed after %llu bytes: %s%s", doing,
                      (unsigned long long)s->written, strerror(error),
                      s->path ? "; the old file, if any, is unchanged" : "");
}

static void sink_free(vv_sink *s)
{
    if (s->library >= 0 && s->library != s->fd)
        close(s->library);
    if (s->fd >= 0)
        close(s->fd);
    if (s->temporary)
        unlink(s->temporary);
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
        sink_free(b);
    }
    sink_free(s);
}

/* Opening ------------------------------------------------------------------------------------------------------- */

static vv_status sink_new(vv_sink **out, const char *name, vv_job *job)
{
    vv_sink *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_SCRATCH);
    if (!s)
        return vv_fail_memory(sizeof *s);
    s->fd = s->library = -1;
    s->job = job;
    s->name = vvi_strdup(name);
    s->plain = vvi_alloc(job, ROOM, VVI_MEM_SCRATCH);
    if (!s->name || !s->plain) {
        vv_status st = vv_fail_memory(ROOM);
        sink_free(s);
        return st;
    }
    *out = s;
    return VV_OK;
}

/* A name that nobody has; a few tries with another number each. */
static vv_status open_temporary(vv_sink *s, mode_t mode)
{
    const char *slash = strrchr(s->path, '/');
    const int n_folder = slash ? (int)(slash - s->path) + 1 : 0;
    for (unsigned attempt = 0; attempt < 1000; attempt++) {
        char *name =
            vvi_asprintf("%.*s.%.200s.%ld-%u.part", n_folder, s->path, s->path + n_folder, (long)getpid(), attempt);
        if (!name)
            return vv_fail_memory(strlen(s->path));
        s->fd = open(name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
        if (s->fd >= 0) {
            s->temporary = name;
            return VV_OK;
        }
        const int error = errno;
        free(name);
        errno = error;
        if (error != EEXIST)
            break;
    }
    return vv_fail_at(VV_E_WRITE, s->name, NULL, "cannot be created: %s", strerror(errno));
}

static vv_status open_straight(vv_sink *s, const char *path)
{
    s->fd =
        strcmp(path, "-") == 0 ? fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3) : open(path, O_WRONLY | O_CLOEXEC | O_NOCTTY);
    return s->fd >= 0 ? VV_OK : vv_fail_at(VV_E_WRITE, s->name, NULL, "cannot be opened: %s", strerror(errno));
}

static vv_status open_target(vv_sink *s, const char *path)
{
    struct stat info;
    const bool there = strcmp(path, "-") != 0 && stat(path, &info) == 0;
    if (there && S_ISDIR(info.st_mode))
        return vv_fail_at(VV_E_WRITE, path, NULL, "is a folder; name a file in it");
    if (strcmp(path, "-") == 0 || (there && !S_ISREG(info.st_mode)))
        return open_straight(s, path);
    /* Through a link to the file it means, so that the link stays one. */
    char *real = there ? realpath(path, NULL) : NULL;
    s->path = real ? real : vvi_strdup(path);
    if (!s->path)
        return vv_fail_memory(strlen(path));
    vv_status st = open_temporary(s, 0666);
    if (st == VV_OK && there && fchmod(s->fd, info.st_mode & 07777) != 0)
        vvi_log(s->job, VV_LOG_WARNING, "io", "%s: its permissions are not kept: %s", s->name, strerror(errno));
    return st;
}

vv_status vvi_sink_open(vv_sink **out, const char *path, vv_job *job)
{
    vv_sink *s = NULL;
    *out = NULL;
    vv_status st = sink_new(&s, strcmp(path, "-") == 0 ? "standard output" : path, job);
    if (st != VV_OK)
        return st;
    if ((st = open_target(s, path)) != VV_OK) {
        sink_free(s);
        return st;
    }
    *out = s;
    return VV_OK;
}

vv_status vvi_sink_open_memory(vv_sink **out, const char *name, vv_job *job)
{
    *out = NULL;
    const vv_status st = sink_new(out, name, job);
    if (st == VV_OK)
        (*out)->in_memory = true;
    return st;
}

vv_status vvi_sink_open_folder(vv_sink **out, const char *path, int (*owns)(const char *name), vv_job *job)
{
    vv_sink *s = NULL;
    *out = NULL;
    vv_status st = sink_new(&s, path, job);
    if (st == VV_OK && (st = vvi_sink_folder_new(&s->folder, path, owns, job)) != VV_OK)
        sink_free(s);
    else if (st == VV_OK)
        *out = s;
    return st;
}

bool vvi_sink_room(const vv_sink *s, uint64_t *out)
{
    return s->folder && vvi_sink_folder_room(s->folder, out);
}

vv_status vvi_sink_put(vv_sink *s, const char *name, const void *data, size_t n)
{
    vvi_check(s->folder);
    return vvi_sink_folder_put(s->folder, name, data, n);
}

vv_status vvi_sink_append(vv_sink *s, const char *name, const void *data, size_t n)
{
    vvi_check(s->folder);
    return vvi_sink_folder_append(s->folder, name, data, n);
}

vv_status vvi_sink_scratch(void **out, vv_sink *s, size_t n)
{
    vvi_check(s->folder);
    return vvi_sink_folder_scratch(out, s->folder, n);
}

void vvi_sink_spare_inputs(vv_sink *sink)
{
    sink->spares_inputs = true;
}

/* Whether a file that is there may be replaced. */
static vv_status spare_input(const vv_sink *s)
{
    struct stat info;
    if (!s->spares_inputs || !s->path || stat(s->path, &info) != 0 ||
        !vvi_job_has_read(s->job, (uint64_t)info.st_dev, (uint64_t)info.st_ino))
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, s->name, NULL,
                      "would be replaced, and samples were read from it; choose another name, or give --overwrite");
}

/* Nor is what a header other than its own (NULL: it has none) names as its data. */
static vv_status spare_header(const vv_sink *s, const char *own)
{
    struct stat info;
    if (!s->spares_inputs || !s->path || stat(s->path, &info) != 0)
        return VV_OK;
    char *header = vvi_header_that_names(s->path, own);
    if (!header)
        return VV_OK;
    const vv_status st = vv_fail_at(VV_E_ARGUMENT, s->name, NULL,
                                    "would be replaced, and '%.200s' beside it names it as its data; choose another "
                                    "name, or give --overwrite",
                                    header);
    free(header);
    return st;
}

/* Data without the header that they are written for belong to another one. */
static vv_status spare_data(const vv_sink *first, const char *path)
{
    struct stat info;
    if (!first->spares_inputs || stat(path, &info) != 0 || stat(first->path, &info) == 0)
        return VV_OK;
    return vv_fail_at(
        VV_E_ARGUMENT, path, NULL,
        "already exists, and may be the data of another header; choose another name, or give --overwrite");
}

vv_status vvi_sink_beside(vv_sink **out, vv_sink *s, const char *name)
{
    *out = NULL;
    if (!s->path)
        return vv_fail_at(
            VV_E_WRITE, s->name, NULL,
            "the output has a second file, its header or its samples, and a stream has no place for it; choose "
            "a format that is one file, or give a file's name");
    const char *slash = strrchr(s->path, '/');
    char *path = vvi_asprintf("%.*s%s", slash ? (int)(slash - s->path) + 1 : 0, s->path, name);
    if (!path)
        return vv_fail_memory(strlen(name));
    vv_status st = spare_data(s, path);
    if (st == VV_OK)
        st = vvi_sink_open(out, path, s->job);
    free(path);
    if (st == VV_OK) {
        (*out)->spares_inputs = s->spares_inputs;
        (*out)->next = s->beside;
        s->beside = *out;
    }
    return st;
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

static vv_status write_out(vv_sink *s, const uint8_t *data, size_t n)
{
    if (s->in_memory)
        return n ? keep(s, data, n) : VV_OK;
    while (n > 0) {
        const ssize_t done = write(s->fd, data, n < ((size_t)1 << 30) ? n : (size_t)1 << 30);
        if (done < 0 && errno == EINTR) {
            vv_status st = vvi_job_poll(s->job);
            if (st != VV_OK)
                return st;
            continue;
        }
        if (done < 0)
            return fail_writing(s, "writing", errno);
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
        step.n_out = ROOM;
        if (!vvi_encoder_run(s->encoder, &step, finish, &done)) {
            s->failed = true;
            return vv_fail_at(VV_E_WRITE, s->name, NULL, "cannot be compressed after %llu bytes",
                              (unsigned long long)s->written);
        }
        st = write_out(s, s->coded, ROOM - step.n_out);
    }
    return st;
}

static vv_status put(vv_sink *s, const uint8_t *data, size_t n)
{
    return s->encoder ? encode(s, data, n, false) : write_out(s, data, n);
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
    if (n > ROOM - s->n_plain && (st = flush_plain(s)) != VV_OK)
        return st;
    if (n >= ROOM) {
        /* in pieces, so that compressing a large run can be cancelled */
        for (size_t at = 0; at < n && st == VV_OK; at += ROOM)
            st = put(s, (const uint8_t *)data + at, n - at < ROOM ? n - at : ROOM);
        return st;
    }
    if (n > 0)
        memcpy(s->plain + s->n_plain, data, n);
    s->n_plain += n;
    return VV_OK;
}

vv_status vvi_sink_printf(vv_sink *s, const char *format, ...)
{
    char *text = NULL;
    va_list args;
    va_start(args, format);
    const int n = vasprintf(&text, format, args);
    va_end(args);
    if (n < 0)
        return vv_fail_memory(strlen(format));
    vv_status st = vvi_sink_write(s, text, (size_t)n);
    free(text);
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
    if (!s->coded && !(s->coded = vvi_alloc(s->job, ROOM, VVI_MEM_SCRATCH)))
        return vv_fail_memory(ROOM);
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
static vv_status copy_library_file(vv_sink *s)
{
    vv_status st = VV_OK;
    if (s->library < 0 || s->library == s->fd)
        return VV_OK;
    for (off_t at = 0; st == VV_OK;) {
        const ssize_t n = pread(s->library, s->plain, ROOM, at);
        if (n < 0 && errno != EINTR)
            return fail_writing(s, "copying", errno);
        if (n == 0)
            break;
        if (n > 0)
            st = write_out(s, s->plain, (size_t)n);
        at += n > 0 ? n : 0;
    }
    return st;
}

/* Committing ----------------------------------------------------------------------------------------------------- */

static vv_status settle(vv_sink *s)
{
    vv_status st = vvi_sink_coding(s, VVI_CODING_NONE, 0);
    if (st != VV_OK)
        return st;
    if (s->failed)
        return vv_fail_at(VV_E_WRITE, s->name, NULL, "is not written: an earlier write failed");
    if ((st = copy_library_file(s)) != VV_OK)
        return st;
    if (s->path && fsync(s->fd) != 0)
        return fail_writing(s, "syncing", errno);
    const int fd = s->fd;
    s->fd = -1;
    return close(fd) == 0 ? VV_OK : fail_writing(s, "closing", errno);
}

vv_status vvi_sink_take(uint8_t **data_out, size_t *n_out, vv_sink *s)
{
    *data_out = NULL;
    *n_out = 0;
    vvi_check(s->in_memory);
    vv_status st = vvi_sink_coding(s, VVI_CODING_NONE, 0);
    if (st == VV_OK && s->failed)
        st = vv_fail_at(VV_E_WRITE, s->name, NULL, "is incomplete: an earlier write failed");
    if (st == VV_OK)
        st = copy_library_file(s);
    if (st == VV_OK) {
        *data_out = s->memory;
        *n_out = (size_t)s->written;
        s->memory = NULL;
    }
    sink_free(s);
    return st;
}

/* The rename itself lasts only when the folder is on the disk too. Some file systems cannot sync folders: then there is
 * nothing to be done, and the file is whole. */
static void sync_folder(const char *path)
{
    char *folder = vvi_strdup(path);
    if (!folder)
        return;
    char *slash = strrchr(folder, '/');
    if (slash)
        slash[1] = 0;
    const int fd = open(slash ? folder : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0) {
        fsync(fd);
        close(fd);
    }
    free(folder);
}

static vv_status put_in_place(vv_sink *s)
{
    if (!s->path)
        return VV_OK;
    if (rename(s->temporary, s->path) != 0)
        return fail_writing(s, "renaming", errno);
    free(s->temporary);
    s->temporary = NULL;
    sync_folder(s->path);
    return VV_OK;
}

vv_status vvi_sink_commit(vv_sink *s)
{
    vv_status st = s->folder ? vvi_sink_folder_commit(s->folder) : VV_OK;
    if (s->folder) {
        vvi_sink_abandon(s);
        return st;
    }
    for (vv_sink *b = s->beside; b && st == VV_OK; b = b->next)
        st = settle(b);
    if (st == VV_OK)
        st = settle(s);
    for (vv_sink *b = s->beside; b && st == VV_OK; b = b->next)
        if ((st = spare_input(b)) == VV_OK)
            st = spare_header(b, s->path);
    if (st == VV_OK && (st = spare_input(s)) == VV_OK)
        st = spare_header(s, NULL);
    for (vv_sink *b = s->beside; b && st == VV_OK; b = b->next)
        st = put_in_place(b);
    if (st == VV_OK)
        st = put_in_place(s);
    vvi_sink_abandon(s);
    return st;
}
