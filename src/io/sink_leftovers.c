/* Temporary files of programs that were killed: their names hold the number of the process that made them. */
#include "core/job.h"
#include "core/memory.h"
#include "io/sink_folder.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define OLD_SECONDS 3600 /* another machine may write to the same disk, whose processes are not ours */

/* The process in "NAME.PID-N.part"; 0: it is no such name. */
static long process_of(const char *name, size_t *n_out)
{
    const size_t n = strlen(name);
    if (n < 8 || strcmp(name + n - 5, ".part") != 0)
        return 0;
    size_t at = n - 5;
    while (at > 0 && name[at - 1] >= '0' && name[at - 1] <= '9')
        at--;
    if (at == n - 5 || at == 0 || name[at - 1] != '-')
        return 0;
    const size_t end = --at;
    while (at > 0 && name[at - 1] >= '0' && name[at - 1] <= '9')
        at--;
    if (at == end || end - at > 10 || at < 2 || name[at - 1] != '.')
        return 0;
    *n_out = at - 1;
    return strtol(name + at, NULL, 10);
}

static bool is_left(const struct stat *info, long process)
{
    return info->st_uid == geteuid() && kill((pid_t)process, 0) != 0 && errno == ESRCH;
}

/* What says that it is ours. */
static bool is_our_folder(const char *name, size_t n)
{
    const size_t m = strlen(VVI_SINK_OURS);
    return name[0] == '.' && n > m + 1 && memcmp(name + n - m, VVI_SINK_OURS, m) == 0;
}

/* Of this target, as older versions named them, which did not lock them. */
static bool is_old_folder(const char *name, size_t n, const char *target, bool old)
{
    return old && strlen(target) == n && strncmp(name, target, n) == 0;
}

typedef enum state { FREE, LOCKED, UNKNOWN } state;

/* Locked: a program on another machine, or in another container, writes it still. Not every file system can say so. */
static state lock_of(int folder, const char *name, int flags)
{
    const int fd = openat(folder, name, flags | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    const state found = fd < 0                              ? UNKNOWN
                        : flock(fd, LOCK_EX | LOCK_NB) == 0 ? FREE
                        : errno == EWOULDBLOCK              ? LOCKED
                                                            : UNKNOWN;
    if (fd >= 0)
        close(fd);
    return found;
}

static bool is_free(state lock, bool old)
{
    return lock == FREE || (lock == UNKNOWN && old);
}

/* Hidden files, and folders of ours. */
static void clear_one(int folder, const char *name, const char *target, const char *path, time_t now)
{
    struct stat info;
    size_t n;
    const long process = process_of(name, &n);
    if (process <= 0 || fstatat(folder, name, &info, AT_SYMLINK_NOFOLLOW) != 0 || !is_left(&info, process))
        return;
    const bool old = info.st_mtime < now - OLD_SECONDS;
    if (name[0] == '.' && S_ISREG(info.st_mode)) {
        if (is_free(lock_of(folder, name, O_RDWR), old))
            unlinkat(folder, name, 0);
    } else if (S_ISDIR(info.st_mode) && (is_our_folder(name, n) || is_old_folder(name, n, target, old)) &&
               is_free(lock_of(folder, name, O_RDONLY | O_DIRECTORY), old)) {
        const char *slash = strrchr(path, '/');
        char *whole = vvi_asprintf("%.*s%s", slash ? (int)(slash - path) + 1 : 0, path, name);
        if (whole)
            vvi_sink_remove_folder(whole);
        free(whole);
    }
}

void vvi_sink_clear_leftovers(const char *path, vv_job *job)
{
    const char *slash = strrchr(path, '/'), *target = slash ? slash + 1 : path;
    char *folder = slash ? vvi_asprintf("%.*s", (int)(slash - path) + 1, path) : vvi_strdup(".");
    DIR *dir = folder && !vvi_job_has_cleared(job, folder) ? opendir(folder) : NULL;
    const time_t now = time(NULL);
    for (const struct dirent *e; dir && (e = readdir(dir)) != NULL;)
        clear_one(dirfd(dir), e->d_name, target, path, now);
    if (dir)
        closedir(dir);
    free(folder);
}
