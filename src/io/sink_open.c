/* Where a sink writes: to a file of its own beside the target, without a name where that can be, else to a stream, to
 * memory, or to files of a folder. Files that belong together hang as a list on the first. */
#include "core/allowed_places.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/sink_impl.h"
#include "io/store_impl.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static vv_status sink_new(vv_sink **out, const char *name, vv_job *job)
{
    vv_sink *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_SCRATCH);
    if (!s)
        return vv_fail_memory(sizeof *s);
    s->fd = s->library = s->held = s->lock = -1;
    s->job = job;
    s->name = vvi_strdup(name);
    s->plain = vvi_alloc(job, VVI_SINK_ROOM, VVI_MEM_SCRATCH);
    if (!s->name || !s->plain) {
        vv_status st = vv_fail_memory(VVI_SINK_ROOM);
        vvi_sink_free(s);
        return st;
    }
    *out = s;
    return VV_OK;
}

/* Locked for as long as it has the name: what nobody has locked was left (sink_leftovers.c). */
static void lock_temporary(vv_sink *s, int fd)
{
    if (s->lock < 0 && flock(fd, LOCK_EX | LOCK_NB) == 0)
        s->lock = fcntl(fd, F_DUPFD_CLOEXEC, 3);
}

static int make_name(vv_sink *s, const char *name, mode_t mode)
{
    char own[32];
    if (s->fd < 0) {
        const int fd = open(name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
        if (fd >= 0)
            lock_temporary(s, fd);
        return fd;
    }
    lock_temporary(s, s->fd);
    snprintf(own, sizeof own, "/proc/self/fd/%d", s->fd);
    return linkat(AT_FDCWD, own, AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0 ? s->fd : -1;
}

/* A name that nobody has, for a new file or for one that has none; a few tries with another number each. */
vv_status vvi_sink_name_temporary(vv_sink *s, mode_t mode)
{
    const char *slash = strrchr(s->path, '/');
    const int n_folder = slash ? (int)(slash - s->path) + 1 : 0;
    for (unsigned attempt = 0; attempt < 1000; attempt++) {
        char *name =
            vvi_asprintf("%.*s.%.200s.%ld-%u.part", n_folder, s->path, s->path + n_folder, (long)getpid(), attempt);
        if (!name)
            return vv_fail_memory(strlen(s->path));
        const int fd = make_name(s, name, mode);
        if (fd >= 0) {
            s->fd = fd;
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

/* Without a name, so that nothing is left of it when the program is killed; where the file system or a missing /proc
 * has no such files, with one. */
static vv_status open_temporary(vv_sink *s, mode_t mode)
{
    const char *slash = strrchr(s->path, '/');
    char *folder = slash ? vvi_asprintf("%.*s", (int)(slash - s->path) + 1, s->path) : vvi_strdup(".");
    if (!folder)
        return vv_fail_memory(strlen(s->path));
    vvi_sink_clear_leftovers(s->path, s->job);
    s->fd = access("/proc/self/fd", X_OK) == 0 ? open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, mode) : -1;
    free(folder);
    return s->fd >= 0 ? VV_OK : vvi_sink_name_temporary(s, mode);
}

static vv_status open_straight(vv_sink *s, const char *path)
{
    s->fd =
        strcmp(path, "-") == 0 ? fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3) : open(path, O_WRONLY | O_CLOEXEC | O_NOCTTY);
    return s->fd >= 0 ? VV_OK : vv_fail_at(VV_E_WRITE, s->name, NULL, "cannot be opened: %s", strerror(errno));
}

vv_status vvi_sink_hold_folder(int *held, char **path, const char *name, vv_job *job)
{
    char *slash = strrchr(*path, '/');
    char *folder = slash ? vvi_asprintf("%.*s", (int)(slash - *path) + 1, *path) : vvi_strdup(".");
    if (!vvi_job_confined(job) || !folder) {
        free(folder);
        return folder ? VV_OK : vv_fail_memory(strlen(*path));
    }
    *held = vvi_open_place(folder, O_PATH | O_DIRECTORY, false, job);
    const int error = errno;
    free(folder);
    if (*held < 0 && error == EXDEV)
        return vv_fail_at(VV_E_WRITE, name, NULL, "lies outside the folder that may be written to");
    if (*held < 0)
        return vv_fail_at(VV_E_WRITE, name, NULL, "cannot be created: %s", strerror(error));
    char *by_number = vvi_asprintf("/proc/self/fd/%d/%s", *held, slash ? slash + 1 : *path);
    if (!by_number)
        return vv_fail_memory(strlen(*path));
    free(*path);
    *path = by_number;
    return VV_OK;
}

static vv_status open_target(vv_sink *s, const char *path)
{
    struct stat info;
    const bool there = strcmp(path, "-") != 0 && stat(path, &info) == 0;
    if (there && vvi_job_keeps_existing(s->job))
        return vvi_sink_fail_existing(s->name);
    if (there && S_ISDIR(info.st_mode))
        return vv_fail_at(VV_E_WRITE, s->name, NULL, "is a folder; name a file in it");
    if (there && !S_ISREG(info.st_mode) && vvi_job_confined(s->job)) /* nobody may read a pipe */
        return vv_fail_at(VV_E_WRITE, s->name, NULL, "is no file; choose another name");
    if (strcmp(path, "-") == 0 || (there && !S_ISREG(info.st_mode)))
        return open_straight(s, path);
    /* Through a link to the file it means, so that the link stays one. */
    char *real = there ? realpath(path, NULL) : NULL;
    s->path = real ? real : vvi_strdup(path);
    if (!s->path)
        return vv_fail_memory(strlen(path));
    vv_status st = vvi_sink_hold_folder(&s->held, &s->path, s->name, s->job);
    if (st == VV_OK)
        st = open_temporary(s, 0666);
    if (st == VV_OK && there && fchmod(s->fd, info.st_mode & 07777) != 0)
        vvi_log(s->job, VV_LOG_WARNING, "io", "%s: its permissions are not kept: %s", s->name, strerror(errno));
    return st;
}

static vv_status open_called(vv_sink **out, const char *path, const char *name, vv_job *job)
{
    vv_sink *s = NULL;
    *out = NULL;
    vv_status st = sink_new(&s, name, job);
    if (st != VV_OK)
        return st;
    if ((st = open_target(s, path)) != VV_OK) {
        vvi_sink_free(s);
        return st;
    }
    *out = s;
    return VV_OK;
}

vv_status vvi_sink_open(vv_sink **out, const char *path, vv_job *job)
{
    return open_called(out, path, strcmp(path, "-") == 0 ? "standard output" : path, job);
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
        vvi_sink_free(s);
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

/* Files that belong together -------------------------------------------------------------------------------------- */

/* Data without the header that they are written for belong to another one. */
static vv_status spare_data(const vv_sink *first, const char *path, const char *name)
{
    struct stat info;
    if (!first->spares_inputs || stat(path, &info) != 0 || stat(first->path, &info) == 0)
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, name, NULL,
                      "already exists, and may be the data of another header; choose another name%s",
                      vvi_job_or_overwrite(first->job));
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
    slash = strrchr(s->name, '/'); /* as people know the place: a path that is held is by a number */
    char *said = vvi_asprintf("%.*s%s", slash ? (int)(slash - s->name) + 1 : 0, s->name, name);
    vv_status st = path && said ? spare_data(s, path, said) : vv_fail_memory(strlen(name));
    if (st == VV_OK)
        st = open_called(out, path, said, s->job);
    free(path);
    free(said);
    if (st == VV_OK) {
        (*out)->spares_inputs = s->spares_inputs;
        (*out)->next = s->beside;
        s->beside = *out;
    }
    return st;
}

vv_status vvi_sink_beside_on_line(vv_sink **out, vv_sink *s, const char *name)
{
    bool plain = *name != ' ';
    *out = NULL;
    for (const char *c = name; *c; c++)
        plain &= (unsigned char)*c >= ' ' && *c != 0x7f;
    if (!plain)
        return vv_fail_at(VV_E_ARGUMENT, s->name, NULL,
                          "the header would name a second file that begins with a blank or has a line break or a "
                          "control character in its name, and nobody could read it; choose another name");
    return vvi_sink_beside(out, s, name);
}
