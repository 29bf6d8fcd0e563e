/* A folder is filled beside its target, under a name that nobody has, and takes the target's place at the end: by a
 * plain rename, or by exchanging the two where an older output stands there, which is removed afterwards. What is not
 * ours is never removed: every file in the old folder must be one that such an output has. */
#include "io/sink_folder.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/sink_impl.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#define DEPTH_MOST 64
#define PATH_MOST 4096

struct vvi_sink_folder {
    char *name;      /* as the caller gave it: stands in errors */
    char *path;      /* where it is going to be; links resolved */
    char *temporary; /* NULL once it is renamed */
    int fd;          /* of the temporary folder */
    int held;        /* that in which the target lies; -1: it is found by its path */
    int (*owns)(const char *name);
    atomic_bool failed;
    vv_job *job;
};

/* Of a path that is not for people. */
static const char *last_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static vv_status fail_writing(vvi_sink_folder *f, const char *doing, const char *name, int error)
{
    atomic_store(&f->failed, true);
    return vv_fail_at(VV_E_WRITE, f->name, NULL, "%s '%.200s' failed: %s; what was there before is unchanged", doing,
                      name, strerror(error));
}

/* Removing ------------------------------------------------------------------------------------------------------- */

enum { LISTED = 2048 }; /* bytes of a list of names */

static void remove_below(int fd, int depth);

static void remove_entry(int folder, const char *name, int depth)
{
    if (strcmp(name, ".") == 0 || strcmp(name, "..") == 0 || unlinkat(folder, name, 0) == 0)
        return;
    remove_below(openat(folder, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC), depth + 1);
    unlinkat(folder, name, AT_REMOVEDIR);
}

/* Everything in a folder; takes the descriptor. Without readdir(), which needs memory: where there is none left, what
 * was begun is removed all the same. */
static void remove_below(int fd, int depth)
{
    _Alignas(struct dirent64) char list[LISTED];
    if (fd < 0)
        return;
    for (ssize_t n; depth < DEPTH_MOST && (n = getdents64(fd, list, sizeof list)) > 0;)
        for (ssize_t at = 0; at < n;) {
            const struct dirent64 *entry = (const struct dirent64 *)(const void *)(list + at);
            remove_entry(fd, entry->d_name, depth);
            at += entry->d_reclen;
        }
    close(fd);
}

void vvi_sink_remove_folder(const char *path)
{
    remove_below(open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC), 0);
    rmdir(path);
}

void vvi_sink_folder_free(vvi_sink_folder *f)
{
    if (!f)
        return;
    if (f->fd >= 0)
        close(f->fd);
    if (f->temporary)
        vvi_sink_remove_folder(f->temporary);
    if (f->held >= 0)
        close(f->held);
    free(f->name);
    free(f->path);
    free(f->temporary);
    vvi_free(f);
}

/* What is there already ------------------------------------------------------------------------------------------ */

typedef struct look {
    vvi_sink_folder *f;
    bool marked; /* by a file at the top that such an output has */
    size_t n;
    char *list; /* of names that the mark gives, each between line ends; NULL: none */
} look;

#define LIST_MOST ((off_t)64 << 20)

/* What a mark says, where it is a list. */
static char *read_list(int at, const char *name)
{
    struct stat info;
    const int fd = openat(at, name, O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
    char *text = NULL;
    if (fd >= 0 && fstat(fd, &info) == 0 && S_ISREG(info.st_mode) && info.st_size <= LIST_MOST)
        text = vvi_calloc(1, (size_t)info.st_size + 1);
    const ssize_t n = text ? read(fd, text, (size_t)info.st_size) : -1;
    if (fd >= 0)
        close(fd);
    if (n < 0 || strncmp(text, VVI_FOLDER_LIST, sizeof VVI_FOLDER_LIST - 1) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

static void find_list(look *l, int at)
{
    const int fd = openat(at, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *folder = fd >= 0 ? fdopendir(fd) : NULL;
    if (!folder && fd >= 0)
        close(fd);
    for (struct dirent *entry; folder && !l->list && (entry = readdir(folder)) != NULL;)
        if (l->f->owns(entry->d_name) == 2)
            l->list = read_list(at, entry->d_name);
    if (folder)
        closedir(folder);
}

static bool is_listed(const look *l, const char *name)
{
    const size_t n = strlen(name);
    for (const char *at = l->list; at && (at = strstr(at, name)) != NULL; at++)
        if (at > l->list && at[-1] == '\n' && at[n] == '\n')
            return true;
    return false;
}

static vv_status look_below(look *l, int fd, const char *below, int depth);

static vv_status look_at(look *l, int at, const char *below, const char *name, int depth)
{
    char path[PATH_MOST];
    struct stat info;
    const int n = snprintf(path, sizeof path, "%s%s%s", below, *below ? "/" : "", name);
    const bool known = n > 0 && n < PATH_MOST && fstatat(at, name, &info, AT_SYMLINK_NOFOLLOW) == 0;
    l->n++;
    if (known && S_ISDIR(info.st_mode) && depth < DEPTH_MOST) {
        const int fd = openat(at, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
        if (fd >= 0)
            return look_below(l, fd, path, depth + 1);
    }
    const int owns = known && S_ISREG(info.st_mode) ? (is_listed(l, path) ? 1 : l->f->owns(path)) : 0;
    if (owns == 0)
        return vv_fail_at(VV_E_WRITE, l->f->name, NULL,
                          "is a folder that holds '%.200s' and is not replaced; name another, or remove it yourself",
                          path);
    l->marked = l->marked || (owns == 2 && !*below);
    return VV_OK;
}

/* Takes the descriptor. */
static vv_status look_below(look *l, int fd, const char *below, int depth)
{
    DIR *folder = fdopendir(fd);
    vv_status st = VV_OK;
    if (!folder) {
        close(fd);
        return vv_fail_at(VV_E_WRITE, l->f->name, NULL, "cannot be listed: %s", strerror(errno));
    }
    for (struct dirent *entry; st == VV_OK && (entry = readdir(folder)) != NULL;)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0 &&
            (st = vvi_job_poll(l->f->job)) == VV_OK)
            st = look_at(l, dirfd(folder), below, entry->d_name, depth);
    closedir(folder);
    return st;
}

/* Whether the target may be replaced; *empty_out: nothing is in it, or it is not there. */
static vv_status check_target(vvi_sink_folder *f, bool *empty_out)
{
    struct stat info;
    look l = {.f = f};
    *empty_out = true;
    if (stat(f->path, &info) != 0)
        return VV_OK;
    if (!S_ISDIR(info.st_mode))
        return vv_fail_at(VV_E_WRITE, f->name, NULL, "is a file, but the output is a folder; name another");
    const int fd = open(f->path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0)
        return vv_fail_at(VV_E_WRITE, f->name, NULL, "cannot be listed: %s", strerror(errno));
    find_list(&l, fd);
    vv_status st = look_below(&l, fd, "", 0);
    free(l.list);
    *empty_out = l.n == 0;
    if (st == VV_OK && l.n > 0 && !l.marked)
        st = vv_fail_at(VV_E_WRITE, f->name, NULL,
                        "is a folder with other contents and is not replaced; name another, or remove it yourself");
    return st;
}

/* Opening -------------------------------------------------------------------------------------------------------- */

/* A name that nobody has, and that says whose it is; a few tries with another number each. Locked as long as it is
 * written: whoever clears up sees it on other machines, too. */
static vv_status make_temporary(vvi_sink_folder *f)
{
    const char *slash = strrchr(f->path, '/');
    const int n_parent = slash ? (int)(slash - f->path) + 1 : 0;
    vvi_sink_clear_leftovers(f->path, f->job);
    for (unsigned attempt = 0; attempt < 1000; attempt++) {
        char *name = vvi_asprintf("%.*s.%.200s" VVI_SINK_OURS ".%ld-%u.part", n_parent, f->path, f->path + n_parent,
                                  (long)getpid(), attempt);
        if (!name)
            return vv_fail_memory(strlen(f->path));
        if (mkdir(name, 0777) == 0) {
            f->temporary = name;
            f->fd = open(name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
            if (f->fd >= 0)
                flock(f->fd, LOCK_EX | LOCK_NB);
            return f->fd >= 0 ? VV_OK : fail_writing(f, "opening", name, errno);
        }
        const int error = errno;
        free(name);
        errno = error;
        if (error != EEXIST)
            break;
    }
    return vv_fail_at(VV_E_WRITE, f->name, NULL, "cannot be created: %s", strerror(errno));
}

static vv_status open_folder(vvi_sink_folder *f, const char *path)
{
    bool empty;
    size_t n = strlen(path);
    while (n > 1 && path[n - 1] == '/')
        n--;
    f->name = vvi_strdup(path);
    /* Through a link to the folder it means, so that the link stays one. */
    f->path = realpath(path, NULL);
    if (!f->path)
        f->path = vvi_asprintf("%.*s", (int)n, path);
    if (!f->name || !f->path)
        return vv_fail_memory(n);
    vv_status st = vvi_sink_hold_folder(&f->held, &f->path, f->name, f->job);
    if (st == VV_OK)
        st = check_target(f, &empty);
    return st == VV_OK ? make_temporary(f) : st;
}

vv_status vvi_sink_folder_new(vvi_sink_folder **out, const char *path, int (*owns)(const char *name), vv_job *job)
{
    *out = NULL;
    if (strcmp(path, "-") == 0)
        return vv_fail(VV_E_ARGUMENT, "the output is a folder, which standard output cannot hold; give -o a name");
    vvi_sink_folder *f = vvi_alloc_zeroed(job, sizeof *f, VVI_MEM_SCRATCH);
    if (!f)
        return vv_fail_memory(sizeof *f);
    f->fd = f->held = -1;
    f->owns = owns;
    f->job = job;
    vv_status st = open_folder(f, path);
    if (st != VV_OK)
        vvi_sink_folder_free(f);
    else
        *out = f;
    return st;
}

/* Writing -------------------------------------------------------------------------------------------------------- */

/* The folders that a file lies in. */
static void make_parents(const vvi_sink_folder *f, const char *name)
{
    char path[PATH_MOST];
    if (strlen(name) >= sizeof path)
        return;
    strcpy(path, name);
    for (char *at = path; (at = strchr(at, '/')) != NULL; *at++ = '/') {
        *at = 0;
        mkdirat(f->fd, path, 0777); /* another thread may have been first; what is wrong shows when the file opens */
    }
}

static vv_status write_all(vvi_sink_folder *f, int fd, const char *name, const uint8_t *data, size_t n)
{
    const vv_status counted = vvi_job_count_write(f->job, n > VVI_FILE_LEAST ? n : VVI_FILE_LEAST);
    if (counted != VV_OK) {
        atomic_store(&f->failed, true);
        return counted;
    }
    while (n > 0) {
        const ssize_t done = write(fd, data, n < ((size_t)1 << 30) ? n : (size_t)1 << 30);
        vv_status st;
        if (done < 0 && errno != EINTR)
            return fail_writing(f, "writing", name, errno);
        if ((st = vvi_job_poll(f->job)) != VV_OK)
            return st;
        data += done > 0 ? done : 0;
        n -= done > 0 ? (size_t)done : 0;
    }
    return VV_OK;
}

static vv_status write_file(vvi_sink_folder *f, const char *name, int how, const void *data, size_t n)
{
    const int flags = O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC | how;
    int fd = openat(f->fd, name, flags, 0666);
    if (fd < 0 && errno == ENOENT) {
        make_parents(f, name);
        fd = openat(f->fd, name, flags, 0666);
    }
    if (fd < 0)
        return fail_writing(f, "creating", name, errno);
    vv_status st = write_all(f, fd, name, data, n);
    if (close(fd) != 0 && st == VV_OK)
        st = fail_writing(f, "closing", name, errno);
    return st;
}

vv_status vvi_sink_folder_put(vvi_sink_folder *f, const char *name, const void *data, size_t n)
{
    return write_file(f, name, O_EXCL, data, n);
}

bool vvi_sink_folder_room(const vvi_sink_folder *f, uint64_t *out)
{
    struct statvfs about;
    if (fstatvfs(f->fd, &about) != 0)
        return false;
    *out = (uint64_t)about.f_bavail * about.f_frsize;
    return true;
}

vv_status vvi_sink_folder_append(vvi_sink_folder *f, const char *name, const void *data, size_t n)
{
    return write_file(f, name, O_APPEND, data, n);
}

/* Scratch -------------------------------------------------------------------------------------------------------- */

/* Not every file system has files without a name: then it loses it at once. */
static int open_unnamed(const vvi_sink_folder *f)
{
    static const char name[] = ".scratch.part";
    const int fd = openat(f->fd, ".", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (fd >= 0)
        return fd;
    const int named = openat(f->fd, name, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (named >= 0)
        unlinkat(f->fd, name, 0);
    return named;
}

vv_status vvi_sink_folder_scratch(void **out, vvi_sink_folder *f, size_t n)
{
    *out = NULL;
    const int fd = open_unnamed(f);
    if (fd < 0)
        return fail_writing(f, "opening", "a scratch file", errno);
    /* every block now: a full disk would otherwise be met as SIGBUS, in the middle of the work */
    const int error = posix_fallocate(fd, 0, (off_t)n);
    void *data = error == 0 ? mmap(NULL, n, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0) : MAP_FAILED;
    const int why = error != 0 ? error : errno;
    close(fd);
    if (data == MAP_FAILED)
        return fail_writing(f, "making", "a scratch file", why);
    *out = data;
    return VV_OK;
}

/* Committing ----------------------------------------------------------------------------------------------------- */

void vvi_sink_sync_parent(const char *path)
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

/* The old folder steps aside first, where the file system cannot exchange two: to a name that can be seen, and that
 * nobody clears away. */
static vv_status replace_in_two_steps(vvi_sink_folder *f)
{
    char *aside = vvi_asprintf("%s.%ld.old", f->path, (long)getpid());
    if (!aside)
        return vv_fail_memory(strlen(f->path));
    vv_status st = VV_OK;
    if (rename(f->path, aside) != 0) {
        st = fail_writing(f, "moving", f->name, errno);
    } else if (rename(f->temporary, f->path) != 0) {
        st = fail_writing(f, "renaming", last_of(f->temporary), errno);
        rename(aside, f->path);
    } else {
        vvi_sink_remove_folder(aside);
        free(f->temporary);
        f->temporary = NULL;
    }
    free(aside);
    return st;
}

static vv_status put_in_place(vvi_sink_folder *f)
{
    bool empty;
    vv_status st = check_target(f, &empty); /* much may have happened since it was opened */
    if (st != VV_OK)
        return st;
    if (!empty && vvi_job_keeps_existing(f->job))
        return vvi_sink_fail_existing(f->name);
    if (empty && vvi_sink_rename(f->temporary, f->path, f->job) != 0)
        return errno == EEXIST ? vvi_sink_fail_existing(f->name)
                               : fail_writing(f, "renaming", last_of(f->temporary), errno);
    if (!empty && renameat2(AT_FDCWD, f->temporary, AT_FDCWD, f->path, RENAME_EXCHANGE) != 0)
        return errno == EINVAL || errno == ENOSYS ? replace_in_two_steps(f)
                                                  : fail_writing(f, "renaming", last_of(f->temporary), errno);
    if (!empty)
        vvi_sink_remove_folder(f->temporary);
    free(f->temporary);
    f->temporary = NULL;
    return VV_OK;
}

vv_status vvi_sink_folder_commit(vvi_sink_folder *f)
{
    if (atomic_load(&f->failed))
        return vv_fail_at(VV_E_WRITE, f->name, NULL, "is not written: an earlier write failed");
    /* one call for thousands of small files */
    if (syncfs(f->fd) != 0)
        return fail_writing(f, "syncing", last_of(f->temporary), errno);
    vv_status st = put_in_place(f);
    if (st == VV_OK)
        vvi_sink_sync_parent(f->path);
    return st;
}
