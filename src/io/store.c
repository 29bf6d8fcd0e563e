#include "core/allowed_places.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/store_impl.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

void vvi_store_release(vvi_store *s)
{
    if (!s || --s->users > 0)
        return;
    if (s->fd >= 0)
        close(s->fd);
    vvi_free(s->path);
    vvi_free(s->open_path);
    vvi_free(s->name);
    vvi_free(s->head);
    vvi_free(s);
}

vvi_store *vvi_store_retain(vvi_store *store)
{
    store->users++;
    return store;
}

static char *copy_text(const char *text, vv_job *job)
{
    const size_t n = strlen(text) + 1;
    char *copy = vvi_alloc(job, n, VVI_MEM_MODEL);
    if (copy)
        memcpy(copy, text, n);
    return copy;
}

vv_status vvi_store_new(vvi_store **out, int fd, const char *path, const char *name, vv_job *job)
{
    char open_path[32];
    struct stat info;
    *out = NULL;
    vvi_store *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_SCRATCH);
    if (!s) {
        vv_status st = vv_fail_memory(sizeof *s);
        if (fd >= 0)
            close(fd);
        return st;
    }
    s->users = 1;
    s->fd = fd;
    s->name = copy_text(name, job);
    s->path = path ? copy_text(path, job) : NULL;
    snprintf(open_path, sizeof open_path, "/proc/self/fd/%d", fd);
    s->open_path = fd >= 0 ? copy_text(open_path, job) : NULL;
    if (!s->name || (path && !s->path) || (fd >= 0 && !s->open_path)) {
        vv_status st = vv_fail_memory(strlen(name));
        vvi_store_release(s);
        return st;
    }
    if (fd >= 0 && path && fstat(fd, &info) == 0 && S_ISREG(info.st_mode))
        vvi_job_note_read(job, (uint64_t)info.st_dev, (uint64_t)info.st_ino);
    *out = s;
    return VV_OK;
}

vv_status vvi_store_measure(vvi_store *s)
{
    struct stat info;
    if (fstat(s->fd, &info) != 0)
        return vv_fail_at(VV_E_READ, s->name, NULL, "%s", strerror(errno));
    s->folder = S_ISDIR(info.st_mode);
    s->seekable = S_ISREG(info.st_mode) || s->folder;
    s->size = s->folder ? 0 : s->seekable ? (uint64_t)info.st_size : UINT64_MAX;
    return VV_OK;
}

static vv_status open_standard_input(vvi_store **out, vv_job *job)
{
    const int fd = fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3);
    if (fd < 0)
        return vv_fail_at(VV_E_READ, "standard input", NULL, "%s", strerror(errno));
    vv_status st = vvi_store_new(out, fd, NULL, "standard input", job);
    if (st != VV_OK)
        return st;
    vvi_store *s = *out;
    st = vvi_store_measure(s);
    /* A file that was redirected may stand anywhere: it is then read on from there, as a pipe is. */
    if (st == VV_OK && lseek(fd, 0, SEEK_CUR) != 0) {
        s->seekable = false;
        s->size = UINT64_MAX;
    }
    if (st != VV_OK) {
        vvi_store_release(s);
        *out = NULL;
    }
    return st;
}

vv_status vvi_store_open(vvi_store **out, const char *path, vv_job *job)
{
    *out = NULL;
    if (strcmp(path, "-") == 0)
        return open_standard_input(out, job);
    vvi_job_tell_read(job, path);
    const int fd = vvi_open_place(path, O_RDONLY, false, job);
    if (fd < 0 && errno == EXDEV && vvi_job_confined(job))
        return vv_fail_at(VV_E_READ, path, NULL, "lies outside the folder that may be read");
    if (fd < 0 && errno == ENOENT && strstr(path, "://"))
        return vv_fail_at(VV_E_READ, path, NULL, "is an address, not a file; download it first");
    if (fd < 0)
        return vv_fail_at(VV_E_READ, path, NULL, "%s", strerror(errno));
    vv_status st = vvi_store_new(out, fd, path, path, job);
    if (st == VV_OK && (st = vvi_store_measure(*out)) != VV_OK) {
        vvi_store_release(*out);
        *out = NULL;
    }
    return st;
}

vv_status vvi_store_temporary(vvi_store **out, const char *name, vv_job *job)
{
    const char *folder = getenv("TMPDIR");
    folder = folder && *folder ? folder : "/tmp";
    *out = NULL;
    int fd = vvi_job_take_spare(job);
    if (fd < 0)
        fd = open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (fd < 0)
        return vv_fail_at(VV_E_READ, name, NULL, "cannot be kept in a temporary file in %.200s: %s; set TMPDIR", folder,
                          strerror(errno));
    return vvi_store_new(out, fd, NULL, name, job);
}

vv_status vvi_store_memory(vvi_store **out, const void *data, size_t n, const char *name, vv_job *job)
{
    vv_status st = vvi_store_new(out, -1, NULL, name, job);
    if (st != VV_OK)
        return st;
    (*out)->memory = data;
    (*out)->size = n;
    (*out)->seekable = true;
    return VV_OK;
}

/* Reading ------------------------------------------------------------------------------------------------------- */

static vv_status read_memory(const vvi_store *s, uint64_t offset, void *out, size_t n, size_t *n_read)
{
    const uint64_t left = offset < s->size ? s->size - offset : 0;
    *n_read = left < n ? (size_t)left : n;
    if (*n_read > 0)
        memcpy(out, s->memory + offset, *n_read);
    return VV_OK;
}

vv_status vvi_store_read(vvi_store *s, uint64_t offset, void *out, size_t n, size_t *n_read, vv_job *job)
{
    vv_status st;
    *n_read = 0;
    if (s->folder)
        return VV_OK;
    if (s->fd < 0)
        return read_memory(s, offset, out, n, n_read);
    if (!s->seekable && offset != s->stream_at)
        return vv_fail_at(VV_E_UNSUPPORTED, s->name, NULL,
                          "is a stream and cannot be read twice; save it to a file first");
    while (*n_read < n) {
        size_t want = n - *n_read;
        if (want > (size_t)1 << 30)
            want = (size_t)1 << 30; /* the kernel takes no more at once */
        char *to = (char *)out + *n_read;
        const ssize_t got = s->seekable ? pread(s->fd, to, want, (off_t)(offset + *n_read)) : read(s->fd, to, want);
        if (got < 0 && errno == EINTR) {
            if ((st = vvi_job_poll(job)) != VV_OK)
                return st;
            continue;
        }
        if (got < 0)
            return vv_fail_at(VV_E_READ, s->name, NULL, "at byte %llu: %s", (unsigned long long)(offset + *n_read),
                              strerror(errno));
        if (got == 0)
            break;
        *n_read += (size_t)got;
        if (!s->seekable) {
            vvi_store_keep_head(s, to, (size_t)got, job);
            s->stream_at += (uint64_t)got;
        }
    }
    return VV_OK;
}
