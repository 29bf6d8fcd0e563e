/* Files that a header names, or that lie in a folder: names inside files are data, never paths. */
#include "core/allowed_places.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/store_impl.h"
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/openat2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#define LINKS_MOST 16
#define DEPTH_MOST 64

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

/* The folders on the way, the outermost first: what `..` in a link leads back to. */
typedef struct walk {
    int at[DEPTH_MOST];
    int depth, links;
    char rest[PATH_MAX]; /* of the name */
} walk;

static int fail_with(int error)
{
    errno = error;
    return -1;
}

/* What a link says, before the rest of the name. */
static int follow(walk *w, const char *target, const char *name)
{
    char whole[PATH_MAX];
    const int n = snprintf(whole, sizeof whole, "%s/%s", target, name);
    if (target[0] == '/')
        return fail_with(EXDEV);
    if (n >= (int)sizeof whole || ++w->links > LINKS_MOST)
        return fail_with(n >= (int)sizeof whole ? ENAMETOOLONG : ELOOP);
    memcpy(w->rest, whole, (size_t)n + 1);
    return 0;
}

/* One part of the name into or out of a folder. Positive: the descriptor that was looked for; 0: there is more. */
static int step(walk *w, const char *part, const char *name, int flags)
{
    char target[PATH_MAX];
    if (strcmp(part, "..") == 0) {
        if (w->depth == 1)
            return fail_with(EXDEV);
        close(w->at[--w->depth]);
        memmove(w->rest, name, strlen(name) + 1);
        return 0;
    }
    const ssize_t n = readlinkat(w->at[w->depth - 1], part, target, sizeof target - 1);
    target[n > 0 ? n : 0] = 0;
    if (n > 0)
        return follow(w, target, name);
    /* not followed if it has become a link meanwhile */
    const bool last = name[strspn(name, "/")] == 0;
    const int next = openat(w->at[w->depth - 1], part,
                            O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK | O_NOCTTY | (last ? flags : O_PATH | O_DIRECTORY));
    if (next < 0 || last)
        return next;
    if (w->depth == DEPTH_MOST) {
        close(next);
        return fail_with(ENAMETOOLONG);
    }
    w->at[w->depth++] = next;
    memmove(w->rest, name, strlen(name) + 1);
    return 0;
}

/* Where the kernel cannot do it: part by part, links by what they say, as long as that does not lead out. */
static int open_walking(int folder, const char *name, int flags)
{
    walk w = {.depth = 1};
    char part[NAME_MAX + 1];
    int found = 0;
    if (strlen(name) >= sizeof w.rest)
        return fail_with(ENAMETOOLONG);
    w.at[0] = fcntl(folder, F_DUPFD_CLOEXEC, 3);
    if (w.at[0] < 0)
        return -1;
    memcpy(w.rest, name, strlen(name) + 1);
    while (found == 0) {
        const char *at = w.rest + strspn(w.rest, "/");
        const size_t n = strcspn(at, "/");
        if (n == 0 || n > NAME_MAX) {
            found = fail_with(n == 0 ? EISDIR : ENAMETOOLONG);
            break;
        }
        memcpy(part, at, n);
        part[n] = 0;
        found = step(&w, part, at + n, flags);
    }
    const int saved = errno;
    while (w.depth > 0)
        close(w.at[--w.depth]);
    errno = saved;
    return found;
}

int vvi_open_beneath(int folder, const char *name, int flags)
{
    const unsigned harmless = flags & O_PATH ? 0 : O_NONBLOCK | O_NOCTTY; /* which say nothing of a mere place */
    struct open_how how = {.flags = (unsigned)flags | O_CLOEXEC | harmless,
                           .resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS};
    const long fd = syscall(SYS_openat2, folder, name, &how, sizeof how);
    if (fd >= 0 || (errno != ENOSYS && errno != EPERM))
        return (int)fd;
    return open_walking(folder, name, flags);
}

/* A file of its own at its own place; of a pipe there is but one. */
static int open_again(int descriptor, int flags)
{
    char path[32];
    struct stat about;
    if (fstat(descriptor, &about) == 0 && !S_ISREG(about.st_mode) && !S_ISDIR(about.st_mode))
        return fcntl(descriptor, F_DUPFD_CLOEXEC, 3);
    snprintf(path, sizeof path, "/proc/self/fd/%d", descriptor);
    const int fd = open(path, flags | O_CLOEXEC | O_NOCTTY);
    return fd >= 0 ? fd : fcntl(descriptor, F_DUPFD_CLOEXEC, 3);
}

int vvi_open_place(const char *path, int flags, bool beside, const vv_job *job)
{
    const int lent = beside ? -1 : vvi_job_lent_file(job, path);
    if (lent >= 0)
        return open_again(lent, flags);
    if (!vvi_job_confined(job))
        return open(path, flags | O_CLOEXEC | O_NOCTTY);
    const char *rest = ".";
    char *real = realpath(path, NULL);
    if (!real)
        return -1;
    const int folder = vvi_job_place(job, real, beside, &rest);
    const int fd = folder == -2   ? fail_with(EXDEV)
                   : folder == -1 ? open(real, flags | O_NOFOLLOW | O_CLOEXEC | O_NOCTTY)
                                  : vvi_open_beneath(folder, rest, flags);
    const int saved = errno;
    free(real);
    errno = saved;
    return fd;
}

static int open_folder_of(const vvi_store *header, const vv_job *job)
{
    char folder[PATH_MAX];
    const char *path = header->path;
    if (header->folder)
        return fcntl(header->fd, F_DUPFD_CLOEXEC, 3);
    const int lent = vvi_job_lent_folder(job, path);
    if (lent >= 0)
        return fcntl(lent, F_DUPFD_CLOEXEC, 3);
    const char *slash = strrchr(path, '/');
    if (!slash)
        return vvi_open_place(".", O_PATH | O_DIRECTORY, true, job);
    const size_t n = (size_t)(slash - path) + 1;
    if (n >= sizeof folder) {
        errno = ENAMETOOLONG;
        return -1;
    }
    memcpy(folder, path, n);
    folder[n] = 0;
    return vvi_open_place(folder, O_PATH | O_DIRECTORY, true, job);
}

static vv_status fail_to_open(const vvi_store *header, const char *name, int error)
{
    if (error == EXDEV || error == ELOOP)
        return refuse(header, name, "is a link that leads out of the header's folder");
    if (error == ENOENT && !header->folder)
        return vv_fail_at(VV_E_READ, header->name, NULL,
                          "names the data file '%.200s', which is not there; copy it beside this file, or correct the "
                          "name in it",
                          name);
    return vv_fail_at(VV_E_READ, header->name, NULL, "data file '%.200s' cannot be opened: %s", name, strerror(error));
}

/* The name under which errors speak of it, and beside which nothing else is looked for. */
static char *beside_path(const vvi_store *header, const char *name)
{
    const char *slash = strrchr(header->path, '/');
    const int n_folder = name[0] == '/'   ? 0
                         : header->folder ? (int)strlen(header->path)
                         : slash          ? (int)(slash - header->path) + 1
                                          : 0;
    const bool joined = header->folder && n_folder > 0 && header->path[n_folder - 1] != '/';
    return vvi_asprintf("%.*s%s%s", n_folder, header->path, joined ? "/" : "", name);
}

static vv_status beside_store(vvi_store **out, const vvi_store *header, const char *name, const char *path, int fd,
                              vv_job *job)
{
    vv_status st = vvi_store_new(out, fd, path, path, job);
    if (st == VV_OK && (st = vvi_store_measure(*out)) == VV_OK && ((*out)->folder || !(*out)->seekable))
        st = vv_fail_at(VV_E_READ, header->name, NULL, "data file '%.200s' is not a regular file", name);
    if (st != VV_OK) {
        vvi_store_release(*out);
        *out = NULL;
    }
    return st;
}

static vv_status open_beside(vvi_store **out, const vvi_store *header, const char *name, bool may_lack, vv_job *job)
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
    const int folder = open_folder_of(header, job);
    if (folder < 0)
        return vv_fail_at(VV_E_READ, header->name, NULL, "its folder cannot be opened: %s", strerror(errno));
    char *path = beside_path(header, name);
    if (!path) {
        close(folder);
        return vv_fail_memory(strlen(name));
    }
    vvi_job_tell_read(job, path);
    const int fd = anywhere ? openat(folder, name, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)
                            : vvi_open_beneath(folder, name, O_RDONLY);
    const int error = errno;
    close(folder);
    if (fd >= 0)
        st = beside_store(out, header, name, path, fd, job);
    else if (!may_lack || (error != ENOENT && error != ENOTDIR))
        st = fail_to_open(header, name, error);
    free(path);
    return st;
}

vv_status vvi_store_beside(vvi_store **out, const vvi_store *header, const char *name, vv_job *job)
{
    return open_beside(out, header, name, false, job);
}

vv_status vvi_store_find_beside(vvi_store **out, const vvi_store *header, const char *name, vv_job *job)
{
    return open_beside(out, header, name, true, job);
}

vv_status vvi_store_folder_of(vvi_store **out, const vvi_store *file, vv_job *job)
{
    *out = NULL;
    if (!file->path)
        return VV_OK;
    const int beneath = open_folder_of(file, job);
    const int fd = beneath < 0 ? -1 : vvi_open_beneath(beneath, ".", O_RDONLY | O_DIRECTORY);
    if (beneath >= 0)
        close(beneath);
    if (fd < 0)
        return VV_OK;
    const char *slash = strrchr(file->path, '/');
    char *path = slash ? vvi_asprintf("%.*s", (int)(slash - file->path) + 1, file->path) : vvi_strdup(".");
    if (!path) {
        close(fd);
        return vv_fail_memory(2);
    }
    vv_status st = vvi_store_new(out, fd, path, path, job);
    free(path);
    if (st == VV_OK && (st = vvi_store_measure(*out)) != VV_OK) {
        vvi_store_release(*out);
        *out = NULL;
    }
    return st;
}
