#include "io/store.h"
#include "core/job.h"
#include "core/memory.h"
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/openat2.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

void vvi_store_release(vvi_store *s)
{
    if (!s || --s->users > 0)
        return;
    if (s->fd >= 0)
        close(s->fd);
    vvi_free(s->path);
    vvi_free(s->name);
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

/* Takes the descriptor, also when it fails. */
static vv_status store_new(vvi_store **out, int fd, const char *path, const char *name, vv_job *job)
{
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
    if (!s->name || (path && !s->path)) {
        vv_status st = vv_fail_memory(strlen(name));
        vvi_store_release(s);
        return st;
    }
    *out = s;
    return VV_OK;
}

static vv_status look_at_file(vvi_store *s)
{
    struct stat info;
    if (fstat(s->fd, &info) != 0)
        return vv_fail_at(VV_E_READ, s->name, NULL, "%s", strerror(errno));
    if (S_ISDIR(info.st_mode))
        return vv_fail_at(VV_E_READ, s->name, NULL, "is a folder; name a file in it");
    s->seekable = S_ISREG(info.st_mode);
    s->size = s->seekable ? (uint64_t)info.st_size : UINT64_MAX;
    return VV_OK;
}

static vv_status open_standard_input(vvi_store **out, vv_job *job)
{
    const int fd = fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3);
    if (fd < 0)
        return vv_fail_at(VV_E_READ, "standard input", NULL, "%s", strerror(errno));
    vv_status st = store_new(out, fd, NULL, "standard input", job);
    if (st != VV_OK)
        return st;
    vvi_store *s = *out;
    st = look_at_file(s);
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
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY);
    if (fd < 0)
        return vv_fail_at(VV_E_READ, path, NULL, "%s", strerror(errno));
    vv_status st = store_new(out, fd, path, path, job);
    if (st == VV_OK && (st = look_at_file(*out)) != VV_OK) {
        vvi_store_release(*out);
        *out = NULL;
    }
    return st;
}

vv_status vvi_store_memory(vvi_store **out, const void *data, size_t n, const char *name, vv_job *job)
{
    vv_status st = store_new(out, -1, NULL, name, job);
    if (st != VV_OK)
        return st;
    (*out)->memory = data;
    (*out)->size = n;
    (*out)->seekable = true;
    return VV_OK;
}

/* Files that a header names: names inside files are data, never paths ------------------------------------------- */

static vv_status refuse(const vvi_store *header, const char *name, const char *why)
{
    return vv_fail_at(VV_E_READ, header->name, NULL, "data file '%.200s' %s; allow it with --allow-outside", name, why);
}

static bool has_dot_dot(const char *name)
{
    for (const char *at = name; *at;) {
        const size_t n = strcspn(at, "/");
        if (n == 2 && at[0] == '.' && at[1] == '.')
            return true;
        at += n + (at[n] == '/');
    }
    return false;
}

static vv_status check_name(const vvi_store *header, const char *name)
{
    if (name[0] == '/')
        return refuse(header, name, "is an absolute path");
    if (has_dot_dot(name))
        return refuse(header, name, "leads out of the header's folder");
    if (strstr(name, "://"))
        return vv_fail_at(VV_E_READ, header->name, NULL, "data file '%.200s' is an address, not a file; fetch it first",
                          name);
    return VV_OK;
}

/* Where the kernel cannot do it: component by component, no symbolic link at all. */
static int open_walking(int folder, const char *name)
{
    int at = fcntl(folder, F_DUPFD_CLOEXEC, 3);
    char part[NAME_MAX + 1];
    while (at >= 0) {
        name += strspn(name, "/");
        const size_t n = strcspn(name, "/");
        if (n > NAME_MAX) {
            close(at);
            errno = ENAMETOOLONG;
            return -1;
        }
        memcpy(part, name, n);
        part[n] = 0;
        name += n;
        const bool last = name[strspn(name, "/")] == 0;
        const int next = openat(at, part, O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK | O_NOCTTY | (last ? O_RDONLY : O_PATH));
        const int saved = errno;
        close(at);
        errno = saved;
        if (last)
            return next;
        at = next;
    }
    return -1;
}

static int open_beneath(int folder, const char *name)
{
    struct open_how how = {.flags = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY,
                           .resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS};
    const long fd = syscall(SYS_openat2, folder, name, &how, sizeof how);
    if (fd >= 0 || (errno != ENOSYS && errno != EPERM))
        return (int)fd;
    return open_walking(folder, name);
}

static int open_folder_of(const char *path)
{
    char folder[PATH_MAX];
    const char *slash = strrchr(path, '/');
    if (!slash)
        return open(".", O_PATH | O_DIRECTORY | O_CLOEXEC);
    const size_t n = (size_t)(slash - path) + 1;
    if (n >= sizeof folder) {
        errno = ENAMETOOLONG;
        return -1;
    }
    memcpy(folder, path, n);
    folder[n] = 0;
    return open(folder, O_PATH | O_DIRECTORY | O_CLOEXEC);
}

static vv_status fail_to_open(const vvi_store *header, const char *name, int error)
{
    if (error == EXDEV || error == ELOOP)
        return refuse(header, name, "is a link that leads out of the header's folder");
    return vv_fail_at(VV_E_READ, header->name, NULL, "data file '%.200s' cannot be opened: %s", name, strerror(error));
}

/* The name under which errors speak of it, and beside which nothing else is looked for. */
static vv_status beside_store(vvi_store **out, const vvi_store *header, const char *name, int fd, vv_job *job)
{
    const char *slash = strrchr(header->path, '/');
    const int n_folder = name[0] == '/' || !slash ? 0 : (int)(slash - header->path) + 1;
    char *path = vvi_asprintf("%.*s%s", n_folder, header->path, name);
    if (!path) {
        close(fd);
        return vv_fail_memory(strlen(name));
    }
    vv_status st = store_new(out, fd, path, path, job);
    if (st == VV_OK && (st = look_at_file(*out)) == VV_OK && !(*out)->seekable)
        st = vv_fail_at(VV_E_READ, header->name, NULL, "data file '%.200s' is not a regular file", name);
    if (st != VV_OK) {
        vvi_store_release(*out);
        *out = NULL;
    }
    free(path);
    return st;
}

vv_status vvi_store_beside(vvi_store **out, const vvi_store *header, const char *name, vv_job *job)
{
    *out = NULL;
    const bool anywhere = vvi_job_allow_outside(job);
    vv_status st = anywhere ? VV_OK : check_name(header, name);
    if (st != VV_OK)
        return st;
    if (!header->path)
        return vv_fail_at(VV_E_READ, header->name, NULL,
                          "names the data file '%.200s', but has no folder to look in; give the header as a file",
                          name);
    const int folder = open_folder_of(header->path);
    if (folder < 0)
        return vv_fail_at(VV_E_READ, header->name, NULL, "its folder cannot be opened: %s", strerror(errno));
    const int fd =
        anywhere ? openat(folder, name, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY) : open_beneath(folder, name);
    const int error = errno;
    close(folder);
    return fd < 0 ? fail_to_open(header, name, error) : beside_store(out, header, name, fd, job);
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

vv_status vvi_store_read(vvi_store *s, uint64_t offset, void *out, size_t n, size_t *n_read, const vv_job *job)
{
    vv_status st;
    *n_read = 0;
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
        if (!s->seekable)
            s->stream_at += (uint64_t)got;
    }
    return VV_OK;
}
