/* What a session writes: uploads, samples and pictures, each in a folder of its own, so that none is written
 * over another, and a reader that looks beside its file sees what came with it and nothing else. */
#include "core/memory.h"
#include "server/session_impl.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FOLDERS_MOST = 1000000 };

/* Folders --------------------------------------------------------------------------------------------------------- */

vv_status vvi_files_make_path(const char *path)
{
    char *part = vvi_strdup(path);
    if (!part)
        return vv_fail_memory(strlen(path));
    for (char *at = strchr(part + 1, '/');; at = strchr(at + 1, '/')) {
        if (at)
            *at = 0;
        mkdir(part, 0700);
        if (!at)
            break;
        *at = '/';
    }
    free(part);
    struct stat info;
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        return VV_OK;
    return vv_fail_at(VV_E_WRITE, path, NULL, "cannot create a folder for the session: %s", strerror(errno));
}

vv_status vvi_files_make_folder(char **out, const vvi_session *session, const char *kind, int64_t *number)
{
    int error = EEXIST;
    *out = NULL;
    while (error == EEXIST && *number < FOLDERS_MOST) {
        char *path = vvi_asprintf("%s/%s-%" PRId64, session->uploads, kind, ++*number);
        if (!path)
            return vv_fail_memory(strlen(session->uploads));
        error = mkdir(path, 0700) == 0 ? 0 : errno; /* it makes a new one, or none */
        if (error == 0) {
            *out = path;
            return VV_OK;
        }
        free(path);
    }
    const vv_status st =
        vv_fail_at(VV_E_WRITE, session->uploads, NULL, "cannot make a folder for a file: %s", strerror(error));
    errno = error;
    return st;
}

vv_status vvi_files_own_folder(char **out, const vvi_session *session, const char *kind)
{
    struct stat info;
    char *path = vvi_asprintf("%s/%s", session->uploads, kind);
    *out = NULL;
    if (!path)
        return vv_fail_memory(strlen(session->uploads));
    mkdir(path, 0700);
    if (lstat(path, &info) == 0 && S_ISDIR(info.st_mode)) {
        *out = path;
        return VV_OK;
    }
    const vv_status st = vv_fail_at(VV_E_WRITE, path, NULL, "cannot make a folder: %s", strerror(errno));
    free(path);
    return st;
}

/* Of what is sent together: a page names it by the same word, which others do not know. */
vv_status vvi_session_upload_folder(char **out, vvi_session *session, const char *batch)
{
    vvi_batch *found = NULL;
    for (size_t i = 0; *batch && i < VVI_BATCHES && !found; i++)
        if (strcmp(session->batches[i].name, batch) == 0)
            found = &session->batches[i];
    int64_t number = found ? found->folder : session->upload_folders;
    if (found) {
        *out = vvi_asprintf("%s/upload-%" PRId64, session->uploads, number);
        if (*out)
            mkdir(*out, 0700); /* it goes where the first file was broken off */
        return *out ? VV_OK : vv_fail_memory(strlen(session->uploads));
    }
    const vv_status st = vvi_files_make_folder(out, session, "upload", &session->upload_folders);
    if (st != VV_OK || !*batch)
        return st;
    found = &session->batches[session->n_batches++ % VVI_BATCHES];
    found->folder = session->upload_folders;
    snprintf(found->name, sizeof found->name, "%s", batch);
    return VV_OK;
}

/* What stays ------------------------------------------------------------------------------------------------------ */

/* Of each file in a folder that is no link. */
static void each_file(const char *folder, void (*act)(int folder, const char *name, mode_t mode))
{
    DIR *dir = opendir(folder);
    for (const struct dirent *e; dir && (e = readdir(dir)) != NULL;) {
        struct stat info;
        if (fstatat(dirfd(dir), e->d_name, &info, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(info.st_mode))
            act(dirfd(dir), e->d_name, info.st_mode);
    }
    if (dir)
        closedir(dir);
}

static void keep(int folder, const char *name, mode_t mode)
{
    if ((mode & 0777) != S_IRUSR && fchmodat(folder, name, S_IRUSR, 0) != 0)
        return; /* it goes with the session then, as others do */
}

static void clear(int folder, const char *name, mode_t mode)
{
    if (mode & S_IWUSR)
        unlinkat(folder, name, 0);
}

/* A file that is named, with what came with it, and it may need. */
static bool keep_file(void *user, const char *path, const vv_property *row, const vv_object *owner)
{
    const char *uploads = user, *file;
    const size_t n = strlen(uploads);
    (void)path;
    if (row->kind != VV_KIND_PATH)
        return true;
    memcpy(&file, (const char *)owner + row->offset, sizeof file);
    char *real = file ? realpath(file, NULL) : NULL;
    if (real && strncmp(real, uploads, n) == 0 && real[n] == '/') {
        char *slash = strchr(real + n + 1, '/');
        struct stat info;
        if (slash)
            *slash = 0;
        if (stat(real, &info) == 0 && S_ISDIR(info.st_mode))
            each_file(real, keep);
        else
            chmod(real, S_IRUSR); /* as older versions left it */
    }
    free(real);
    return true;
}

void vvi_files_keep(const vvi_session *session, const vv_world *world)
{
    if (session->uploads)
        vv_path_each(&world->base, keep_file, session->uploads);
}

void vvi_files_clear(const vvi_session *session)
{
    DIR *dir = session->uploads ? opendir(session->uploads) : NULL;
    for (const struct dirent *e; dir && (e = readdir(dir)) != NULL;) {
        struct stat info;
        if (*e->d_name == '.' || fstatat(dirfd(dir), e->d_name, &info, AT_SYMLINK_NOFOLLOW) != 0 ||
            !S_ISDIR(info.st_mode))
            continue;
        char *path = vvi_asprintf("%s/%s", session->uploads, e->d_name);
        if (path) {
            each_file(path, clear);
            rmdir(path); /* unless something stays in it */
        }
        free(path);
    }
    if (dir)
        closedir(dir);
    if (session->uploads)
        each_file(session->uploads, clear); /* of older versions */
}

void vvi_files_remove_empty(const char *path)
{
    char *folder = vvi_strdup(path), *slash = folder ? strrchr(folder, '/') : NULL;
    if (slash)
        *slash = 0;
    if (slash)
        rmdir(folder);
    free(folder);
}

void vvi_files_remove(const char *path)
{
    struct stat info;
    if (lstat(path, &info) == 0 && (info.st_mode & S_IWUSR))
        unlink(path);
    vvi_files_remove_empty(path);
}
