/* What lies in a folder. */
#include "core/job.h"
#include "core/memory.h"
#include "io/store_impl.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define DEPTH_MOST 32

typedef struct listing {
    vvi_names *names;
    size_t room;
    const vvi_store *folder;
    bool deep, folders; /* folders instead of files */
    vv_job *job;
} listing;

void vvi_names_free(vvi_names *names)
{
    for (size_t i = 0; i < names->n; i++)
        vvi_free(names->name[i]);
    vvi_free(names->name);
    *names = (vvi_names){0};
}

static vv_status add(listing *l, const char *below, const char *name)
{
    vvi_names *names = l->names;
    if (names->n >= vvi_job_limits(l->job)->files)
        return vv_fail_at(VV_E_LIMIT, l->folder->name, NULL,
                          "has more than %llu %s; name one of its folders, or --limit files=N allows more",
                          (unsigned long long)vvi_job_limits(l->job)->files, l->folders ? "folders" : "files");
    if (names->n == l->room) {
        const size_t room = l->room ? l->room * 2 : 64;
        char **grown = vvi_realloc(l->job, names->name, room * sizeof *grown, VVI_MEM_SCRATCH);
        if (!grown)
            return vv_fail_memory(room * sizeof *grown);
        names->name = grown;
        l->room = room;
    }
    const size_t n_below = strlen(below), n = n_below + strlen(name) + 2;
    char *whole = vvi_alloc(l->job, n, VVI_MEM_SCRATCH);
    if (!whole)
        return vv_fail_memory(n);
    snprintf(whole, n, "%s%s%s", below, n_below ? "/" : "", name);
    names->name[names->n++] = whole;
    return VV_OK;
}

static vv_status list_folder(listing *l, int at, const char *below, int depth);

static vv_status list_entry(listing *l, int at, const char *below, const char *name, int depth)
{
    struct stat info;
    if (strcmp(name, ".") == 0 || strcmp(name, "..") == 0 ||
        fstatat(at, name, &info, l->folders ? AT_SYMLINK_NOFOLLOW : 0) != 0)
        return VV_OK; /* a link to nowhere is no file */
    if (l->folders ? S_ISDIR(info.st_mode) : S_ISREG(info.st_mode))
        return add(l, below, name);
    if (!S_ISDIR(info.st_mode) || !l->deep || depth >= DEPTH_MOST)
        return VV_OK;
    /* folders behind links are left out: they may lead in circles */
    const int next = openat(at, name, O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
    if (next < 0)
        return VV_OK;
    char *path = vvi_asprintf("%s%s%s", below, *below ? "/" : "", name);
    if (!path) {
        close(next);
        return vv_fail_memory(strlen(below));
    }
    const vv_status st = list_folder(l, next, path, depth + 1);
    free(path);
    return st;
}

/* Takes the descriptor. */
static vv_status list_folder(listing *l, int at, const char *below, int depth)
{
    DIR *folder = fdopendir(at);
    vv_status st = VV_OK;
    if (!folder) {
        close(at);
        return vv_fail_at(VV_E_READ, l->folder->name, NULL, "cannot be listed: %s", strerror(errno));
    }
    for (struct dirent *entry; st == VV_OK && (entry = readdir(folder)) != NULL;)
        if ((st = vvi_job_poll(l->job)) == VV_OK)
            st = list_entry(l, dirfd(folder), below, entry->d_name, depth);
    closedir(folder);
    return st;
}

static int by_number(const void *a, const void *b)
{
    return strverscmp(*(char *const *)a, *(char *const *)b);
}

static vv_status run(listing *l, const char *below)
{
    if (!l->folder->folder)
        return vv_fail_at(VV_E_ARGUMENT, l->folder->name, NULL, "is a file, not a folder");
    const int fd = vvi_open_beneath(l->folder->fd, below && *below ? below : ".", O_RDONLY | O_DIRECTORY);
    if (fd < 0 && l->folders && (errno == ENOENT || errno == ENOTDIR))
        return VV_OK;
    if (fd < 0)
        return vv_fail_at(VV_E_READ, l->folder->name, NULL, "its folder '%.200s' cannot be listed: %s",
                          below ? below : ".", strerror(errno));
    const vv_status st = list_folder(l, fd, below ? below : "", 0);
    if (st != VV_OK)
        vvi_names_free(l->names);
    else if (l->names->n > 1)
        qsort(l->names->name, l->names->n, sizeof *l->names->name, by_number);
    return st;
}

vv_status vvi_store_list(vvi_names *out, const vvi_store *folder, const char *below, bool deep, vv_job *job)
{
    listing l = {.names = out, .folder = folder, .deep = deep, .job = job};
    *out = (vvi_names){0};
    return run(&l, below);
}

vv_status vvi_store_list_folders(vvi_names *out, const vvi_store *folder, const char *below, vv_job *job)
{
    listing l = {.names = out, .folder = folder, .folders = true, .job = job};
    *out = (vvi_names){0};
    return run(&l, below);
}
