/* Room on the disk: what uploads, samples and pictures of a session, and files that its pages write elsewhere, may take
 * together. What would not fit is refused before it is made; files that nobody can see any more make room first. */
#include "core/job.h"
#include "core/memory.h"
#include "core/runtime.h"
#include "core/units.h"
#include "model/history.h"
#include "server/session_impl.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

/* NEW_SECONDS: what came lately may be about to be shown. */
enum { NEW_SECONDS = 600, CANDIDATES = 256 };
enum { DEEPEST = 16 }; /* folders in a folder that is a volume */
#define CLEAR_PAUSE (INT64_C(60) * 1000000000)
#define WEIGHED_LATELY INT64_C(1000000000)

typedef struct weight {
    uint64_t all, kept; /* bytes; kept: those that saved scenes name */
    time_t newest;
    size_t n;
} weight;

static uint64_t weight_of(uint64_t bytes)
{
    return bytes > VVI_FILE_LEAST ? bytes : VVI_FILE_LEAST;
}

static void weigh_folder(weight *out, int parent, const char *name)
{
    struct stat info;
    const int fd = openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    DIR *dir = fd >= 0 ? fdopendir(fd) : NULL;
    if (fd >= 0 && !dir)
        close(fd);
    if (dir && fstat(fd, &info) == 0 && info.st_mtime > out->newest)
        out->newest = info.st_mtime;
    for (const struct dirent *e; dir && (e = readdir(dir)) != NULL;) {
        if (fstatat(fd, e->d_name, &info, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISREG(info.st_mode))
            continue;
        out->n++;
        out->all += weight_of((uint64_t)info.st_size);
        out->kept += info.st_mode & S_IWUSR ? 0 : weight_of((uint64_t)info.st_size);
        out->newest = info.st_mtime > out->newest ? info.st_mtime : out->newest;
    }
    if (dir)
        closedir(dir);
}

/* Shapes are the cache's, which has a limit of its own. */
static bool counts(const char *name)
{
    return *name != '.' && strcmp(name, "shapes") != 0;
}

static weight weigh(const vvi_session *s)
{
    weight w = {.n = 0};
    DIR *dir = s->uploads ? opendir(s->uploads) : NULL;
    for (const struct dirent *e; dir && (e = readdir(dir)) != NULL;)
        if (counts(e->d_name))
            weigh_folder(&w, dirfd(dir), e->d_name);
    if (dir)
        closedir(dir);
    return w;
}

void vvi_session_begin_room(vvi_session *s)
{
    s->kept_before = weigh(s).kept;
}

/* What is there, and what comes. */
static uint64_t taken(const vvi_session *s)
{
    const uint64_t all = weigh(s).all;
    return (all > s->kept_before ? all - s->kept_before : 0) + atomic_load(&s->coming) + atomic_load(&s->written);
}

static uint64_t left_of(const vvi_session *s, uint64_t used)
{
    const uint64_t most = s->options.runtime->limits.session_bytes;
    return used < most ? most - used : 0;
}

static uint64_t room_on_disk(const char *path)
{
    struct statvfs about;
    if (!path || statvfs(path, &about) != 0)
        return UINT64_MAX;
    const uint64_t there = (uint64_t)about.f_bavail * about.f_frsize;
    return there - there / 8;
}

/* Whether `bytes` fit beside those that are there, and on the disk, which has some for them. */
static vv_status judge(const vvi_session *s, uint64_t bytes, uint64_t now, uint64_t disk)
{
    char wanted[32], used[32], most[32];
    vvi_print_bytes(wanted, bytes);
    vvi_print_bytes(used, now);
    vvi_print_bytes(most, s->options.runtime->limits.session_bytes);
    if (now > s->options.runtime->limits.session_bytes || bytes > left_of(s, now))
        return vv_fail(
            VV_E_LIMIT,
            "there is no room for %s more: uploads, samples, pictures and written files of this session take "
            "%s of %s; --limit session_bytes=N allows more, and a new session begins with none",
            wanted, used, most);
    vvi_print_bytes(most, disk);
    return bytes <= disk ? VV_OK
                         : vv_fail(VV_E_LIMIT, "there is no room for %s more on the server's disk, which has %s for it",
                                   wanted, most);
}

vv_status vvi_session_has_room(const vvi_session *s, uint64_t bytes)
{
    return judge(s, bytes, taken(s), room_on_disk(s->uploads));
}

bool vvi_session_disk_holds(const vvi_session *s, uint64_t bytes)
{
    return bytes <= room_on_disk(s->uploads);
}

/* What pages write ------------------------------------------------------------------------------------------------ */

/* Of a file, or of all files in a folder and those in it. */
static uint64_t weight_of_place(int parent, const char *name, int depth)
{
    struct stat info;
    uint64_t all = 0;
    if (fstatat(parent, name, &info, AT_SYMLINK_NOFOLLOW) != 0)
        return 0;
    if (S_ISREG(info.st_mode))
        return weight_of((uint64_t)info.st_size);
    const int fd = S_ISDIR(info.st_mode) ? openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC) : -1;
    DIR *dir = fd >= 0 ? fdopendir(fd) : NULL;
    if (fd >= 0 && !dir)
        close(fd);
    for (const struct dirent *e; dir && (e = readdir(dir)) != NULL;)
        if (strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0 && depth < DEEPEST)
            all += weight_of_place(fd, e->d_name, depth + 1);
    if (dir)
        closedir(dir);
    return all;
}

static vv_status count_write(void *user, uint64_t bytes)
{
    vvi_disk_share *share = user;
    vvi_session *s = share->session;
    const uint64_t own = atomic_fetch_add(&share->taken, bytes) + bytes,
                   all = share->others + atomic_load(&s->written) + atomic_fetch_add(&s->coming, bytes) + bytes,
                   beyond = own > share->replaced ? own - share->replaced : 0;
    return judge(s, beyond, all - own, share->disk);
}

vv_status vvi_disk_share_begin(vvi_disk_share *out, vvi_session *s, const char *path, vv_job *job)
{
    struct stat info;
    const char *slash = strrchr(path, '/');
    char *folder = vvi_asprintf("%.*s", slash && slash > path ? (int)(slash - path) : 1, slash ? path : ".");
    const uint64_t all = weigh(s).all;
    if (!folder)
        return vv_fail_memory(strlen(path));
    /* a folder that is no volume is not replaced, however much is in it */
    const bool may_be = stat(path, &info) != 0 || !S_ISDIR(info.st_mode) ||
                        vvi_files_is_data_folder(slash ? slash + 1 : path, vv_runtime_registry(s->options.runtime));
    *out = (vvi_disk_share){.session = s,
                            .others = all > s->kept_before ? all - s->kept_before : 0,
                            .disk = room_on_disk(folder),
                            .replaced = may_be ? weight_of_place(AT_FDCWD, path, 0) : 0};
    free(folder);
    vvi_job_count_writes(job, count_write, out);
    return vvi_session_has_room(s, out->replaced ? 0 : VVI_FILE_LEAST);
}

vv_status vvi_disk_share_end(vvi_disk_share *share, vv_status st, vv_job *job)
{
    vvi_session *s = share->session;
    const uint64_t own = atomic_load(&share->taken);
    vvi_job_count_writes(job, NULL, NULL);
    uint64_t before = atomic_load(&s->written), now;
    do
        now = before + own > share->replaced ? before + own - share->replaced : 0;
    while (st == VV_OK && !atomic_compare_exchange_weak(&s->written, &before, now));
    atomic_fetch_sub(&s->coming, own);
    return st;
}

/* What can be seen ------------------------------------------------------------------------------------------------ */

typedef struct candidate {
    char *path; /* of a folder */
    size_t n;
    bool named;
} candidate;

typedef struct candidates {
    candidate folder[CANDIDATES];
    size_t n;
} candidates;

static bool note_file(void *user, const char *path, const vv_property *row, const vv_object *owner)
{
    candidates *all = user;
    const char *file;
    (void)path;
    if (row->kind != VV_KIND_PATH)
        return true;
    memcpy(&file, (const char *)owner + row->offset, sizeof file);
    for (size_t i = 0; file && i < all->n; i++) {
        candidate *c = &all->folder[i];
        c->named |= strncmp(file, c->path, c->n) == 0 && file[c->n] == '/';
    }
    return true;
}

static bool note_files(void *user, const vv_object *world)
{
    vv_path_each(world, note_file, user);
    return true;
}

static void add_candidate(candidates *all, const vvi_session *s, int parent, const char *name)
{
    weight w = {.n = 0};
    if (strncmp(name, "result-", 7) != 0 && strncmp(name, "upload-", 7) != 0)
        return;
    weigh_folder(&w, parent, name);
    char *path = w.n && w.newest + NEW_SECONDS < time(NULL) ? vvi_asprintf("%s/%s", s->uploads, name) : NULL;
    if (path)
        all->folder[all->n++] = (candidate){.path = path, .n = strlen(path)};
}

static void remove_folder(const char *path)
{
    DIR *dir = opendir(path);
    for (const struct dirent *e; dir && (e = readdir(dir)) != NULL;) {
        struct stat info;
        if (fstatat(dirfd(dir), e->d_name, &info, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(info.st_mode) &&
            (info.st_mode & S_IWUSR))
            unlinkat(dirfd(dir), e->d_name, 0);
    }
    if (dir)
        closedir(dir);
    rmdir(path);
}

/* Uploads, and results of older versions, that neither the World names nor one that undo brings back. */
static void clear_unseen(const vvi_session *s)
{
    candidates all = {.n = 0};
    DIR *dir = s->uploads ? opendir(s->uploads) : NULL;
    for (const struct dirent *e; dir && all.n < CANDIDATES && (e = readdir(dir)) != NULL;)
        add_candidate(&all, s, dirfd(dir), e->d_name);
    if (dir)
        closedir(dir);
    if (all.n)
        vvi_model_each_world(s->model, note_files, &all);
    for (size_t i = 0; i < all.n; i++) {
        if (!all.folder[i].named)
            remove_folder(all.folder[i].path);
        free(all.folder[i].path);
    }
}

vv_status vvi_session_make_room(vvi_session *s, uint64_t bytes)
{
    const uint64_t most = s->options.runtime->limits.session_bytes;
    const int64_t now = vvi_now();
    if (taken(s) + bytes > most / 2 && (!s->cleared || now - s->cleared > CLEAR_PAUSE)) {
        s->cleared = now;
        clear_unseen(s);
    }
    return vvi_session_has_room(s, bytes);
}

/* Not every one of thousands of files looks at all that came before it. */
static bool fits_easily(const vvi_session *s, uint64_t bytes, int64_t now)
{
    const uint64_t most = s->options.runtime->limits.session_bytes / 2;
    const uint64_t used = s->weighed + s->named + atomic_load(&s->coming) + atomic_load(&s->written);
    return s->weighed_at && now - s->weighed_at < WEIGHED_LATELY && used < most && bytes < most - used &&
           bytes <= room_on_disk(s->uploads);
}

vv_status vvi_session_upload_room(vvi_session *s, uint64_t bytes)
{
    const int64_t now = vvi_now();
    if (fits_easily(s, bytes, now))
        return VV_OK;
    const vv_status st = vvi_session_make_room(s, bytes);
    s->weighed = weigh(s).all;
    s->named = 0;
    s->weighed_at = now;
    return st;
}

void vvi_session_upload_came(vvi_session *s, int64_t bytes, bool named)
{
    atomic_fetch_add(&s->coming, (uint64_t)bytes);
    if (named)
        s->named += weight_of((uint64_t)-bytes);
}
