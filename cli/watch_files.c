#include "watch_files.h"
#include "core/cache.h"
#include "input.h"
#include "output.h"
#include "value.h"
#include <dirent.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Never 0, which is for a file that is not there. A file that was replaced has another number; one that was written
 * anew another time. */
static cli_file_state state_of(const struct stat *about, cli_file_state before)
{
    const int64_t parts[] = {(int64_t)about->st_dev,           (int64_t)about->st_ino, (int64_t)about->st_size,
                             (int64_t)about->st_mode & S_IFMT, about->st_mtim.tv_sec,  about->st_mtim.tv_nsec};
    return vvi_hash(parts, sizeof parts, before) | 1;
}

/* Outputs of this folder, by name: they may not be there yet. */
static bool is_own(const cli_watch_files *files, const struct stat *folder, const char *name)
{
    for (size_t i = 0; i < files->n_own; i++) {
        struct stat about;
        if (strcmp(cli_base_of(files->own[i]), name) != 0)
            continue;
        char *path = cli_folder_of(files->own[i]);
        const bool same =
            path && stat(path, &about) == 0 && about.st_dev == folder->st_dev && about.st_ino == folder->st_ino;
        free(path);
        if (same)
            return true;
    }
    return false;
}

/* The files in it, in whatever order they are told; none of the folders below, whose files are read by name. */
static cli_file_state state_of_folder(const cli_watch_files *files, const char *path, const struct stat *folder)
{
    cli_file_state sum = vvi_hash(path, strlen(path), 0);
    DIR *list = opendir(path);
    for (struct dirent *entry; list && (entry = readdir(list));) {
        struct stat about;
        const char *name = entry->d_name;
        if (name[0] == '.' || cli_ends_with(name, ".part") || fstatat(dirfd(list), name, &about, 0) != 0 ||
            !S_ISREG(about.st_mode) || is_own(files, folder, name))
            continue;
        sum += state_of(&about, vvi_hash(name, strlen(name), 0));
    }
    if (list)
        closedir(list);
    return sum | 1;
}

cli_file_state cli_file_state_of(const cli_watch_files *files, const char *path)
{
    struct stat about;
    if (stat(path, &about) != 0)
        return 0;
    return S_ISDIR(about.st_mode) ? state_of_folder(files, path, &about) : state_of(&about, 0);
}

void cli_watch_files_own(cli_watch_files *files, const char *path)
{
    char **more = realloc(files->own, (files->n_own + 1) * sizeof *more);
    if (!more)
        return;
    files->own = more;
    if ((more[files->n_own] = strdup(path)))
        files->n_own++;
}

static size_t place_of(const cli_watch_files *files, const char *path)
{
    size_t lo = 0, hi = files->n;
    while (lo < hi) {
        const size_t middle = lo + (hi - lo) / 2;
        if (strcmp(files->file[middle].path, path) < 0)
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo;
}

static bool has_room(cli_watch_files *files)
{
    if (files->n < files->room)
        return true;
    const size_t room = files->room ? 2 * files->room : 16;
    cli_watched_file *more = realloc(files->file, room * sizeof *more);
    if (!more)
        return false;
    files->file = more;
    files->room = room;
    return true;
}

static bool is_output(const cli_watch_files *files, const char *path)
{
    for (size_t i = 0; i < files->n_own; i++)
        if (strcmp(cli_base_of(files->own[i]), cli_base_of(path)) == 0 && cli_output_is(files->own[i], path))
            return true;
    return false;
}

void cli_watch_files_add(cli_watch_files *files, const char *path)
{
    const size_t at = place_of(files, path);
    if (at < files->n && strcmp(files->file[at].path, path) == 0) {
        files->file[at].used = true;
        return;
    }
    if (strcmp(path, "-") == 0 || is_output(files, path))
        return;
    char *copy = has_room(files) ? strdup(path) : NULL;
    if (!copy) {
        files->incomplete = true;
        return;
    }
    memmove(files->file + at + 1, files->file + at, (files->n - at) * sizeof *files->file);
    files->file[at] =
        (cli_watched_file){.path = copy, .state = cli_file_state_of(files, path), .used = true, .folder = -1};
    files->n++;
}

void cli_watch_files_begin(cli_watch_files *files)
{
    for (size_t i = 0; i < files->n; i++) {
        cli_watched_file *file = &files->file[i];
        file->state = cli_file_state_of(files, file->path);
        file->used = file->writing = false;
    }
}

void cli_watch_files_end(cli_watch_files *files, bool failed)
{
    size_t n = 0;
    for (size_t i = 0; i < files->n; i++) {
        if (failed || files->file[i].used)
            files->file[n++] = files->file[i];
        else
            free(files->file[i].path);
    }
    files->n = n;
}

bool cli_watch_files_changed(const cli_watch_files *files, cli_file_state *now, bool *missing, bool *writing)
{
    bool changed = false;
    *now = 1;
    *missing = *writing = false;
    for (size_t i = 0; i < files->n; i++) {
        const cli_watched_file *file = &files->file[i];
        const cli_file_state state = cli_file_state_of(files, file->path);
        changed = changed || state != file->state;
        *missing = *missing || (state == 0 && file->state != 0);
        *writing = *writing || file->writing;
        *now = vvi_hash(&state, sizeof state, *now);
    }
    return changed;
}

void cli_watch_files_free(cli_watch_files *files)
{
    for (size_t i = 0; i < files->n; i++)
        free(files->file[i].path);
    for (size_t i = 0; i < files->n_own; i++)
        free(files->own[i]);
    free(files->file);
    free(files->own);
    *files = (cli_watch_files){0};
}
