/* Files as a page names them: from the root, with no way out of it. */
#include "core/memory.h"
#include "io/mesh_file.h"
#include "io/open_place.h"
#include "server/session_impl.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/magic.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

enum { ENTRIES_MOST = 5000 };

static bool is_below(const char *real, const char *folder)
{
    const size_t n = strlen(folder);
    return strncmp(real, folder, n) == 0 && (n == 1 || real[n] == '/' || !real[n]);
}

bool vvi_files_inside(const vvi_session *session, const char *real)
{
    return is_below(real, session->root) || (session->state && is_below(real, session->state));
}

bool vvi_files_plain(const char *real)
{
    static const unsigned long written_by_the_kernel[] = {PROC_SUPER_MAGIC, TRACEFS_MAGIC, DEBUGFS_MAGIC};
    struct stat info;
    struct statfs system;
    if (stat(real, &info) != 0 || !(S_ISREG(info.st_mode) || S_ISDIR(info.st_mode)) || statfs(real, &system) != 0)
        return false;
    for (size_t i = 0; i < sizeof written_by_the_kernel / sizeof *written_by_the_kernel; i++)
        if ((unsigned long)system.f_type == written_by_the_kernel[i])
            return false;
    return true;
}

/* A path from the root; one that is of the server's file system already and inside stays as it is. */
static char *joined(const vvi_session *session, const char *path)
{
    if (*path == '/' && vvi_files_inside(session, path))
        return vvi_strdup(path);
    while (*path == '/')
        path++;
    return vvi_asprintf("%s/%s", strcmp(session->root, "/") ? session->root : "", path);
}

static vv_status fail_missing(const char *path)
{
    return vv_fail_at(VV_E_NOT_FOUND, path, NULL, "there is no such file or folder here");
}

static vv_status resolve_fresh(char **out, const vvi_session *session, char *whole)
{
    char *slash = strrchr(whole, '/');
    const char *name = slash + 1;
    if (!*name || strcmp(name, ".") == 0 || strcmp(name, "..") == 0)
        return vv_fail(VV_E_ARGUMENT, "a file needs a name");
    for (const char *at = name; *at; at++)
        if (iscntrl((unsigned char)*at))
            return vv_fail(VV_E_ARGUMENT, "a file's name must not contain line breaks, tabs and the like here");
    *slash = 0;
    char *folder = realpath(*whole ? whole : "/", NULL);
    *slash = '/';
    if (!folder)
        return fail_missing(whole);
    *out = vvi_asprintf("%s/%s", strcmp(folder, "/") ? folder : "", name);
    free(folder);
    if (!*out)
        return vv_fail_memory(strlen(whole));
    struct stat info;
    char *real = realpath(*out, NULL); /* a link that is there already leads where it leads, or nowhere yet */
    const bool inside = real ? vvi_files_inside(session, real)
                             : lstat(*out, &info) != 0 && errno == ENOENT && vvi_files_inside(session, *out);
    const bool plain = !real || vvi_files_plain(real);
    free(real);
    if (inside && plain)
        return VV_OK;
    free(*out);
    *out = NULL;
    return inside ? vv_fail_at(VV_E_ARGUMENT, whole, NULL,
                               "is neither a file nor a folder with files; choose another name")
                  : fail_missing(whole);
}

vv_status vvi_files_resolve(char **out, const vvi_session *session, const char *path, bool fresh)
{
    *out = NULL;
    char *whole = joined(session, path);
    if (!whole)
        return vv_fail_memory(strlen(path));
    vv_status st;
    if (fresh) {
        st = resolve_fresh(out, session, whole);
    } else {
        *out = realpath(whole, NULL);
        st = *out && vvi_files_inside(session, *out) ? VV_OK : fail_missing(path);
        if (st == VV_OK && !vvi_files_plain(*out))
            st = vv_fail_at(VV_E_ARGUMENT, path, NULL, "is neither a file nor a folder with files");
    }
    free(whole);
    if (st != VV_OK) {
        free(*out);
        *out = NULL;
    }
    return st;
}

vv_status vvi_files_resolve_part(char **out, char **part_out, const vvi_session *session, const char *name)
{
    char *file = vvi_strdup(name);
    *out = *part_out = NULL;
    if (!file)
        return vv_fail_memory(strlen(name));
    vv_status st = vvi_files_resolve(out, session, file, false);
    for (char *colon; st == VV_E_NOT_FOUND && (colon = strrchr(file, ':')) != NULL;) {
        *colon = 0;
        const size_t n = (size_t)(colon - file);
        if (n == 0 || vvi_files_resolve(out, session, file, false) != VV_OK)
            continue;
        *part_out = vvi_strdup(name + n + 1);
        st = *part_out ? VV_OK : vv_fail_memory(strlen(name));
    }
    free(file);
    return st == VV_E_NOT_FOUND ? fail_missing(name) : st;
}

/* Of a file of the session: why the system does not find it, and what helps. */
static char *explain_gone(char *text)
{
    static const char end[] = ": No such file or directory";
    const size_t n = text ? strlen(text) : 0, m = sizeof end - 1;
    if (n < m || strcmp(text + n - m, end) != 0)
        return text;
    char *more =
        vvi_asprintf("%.*s: is not there: it was not uploaded beside what names it, or the files of this session were "
                     "removed; upload all that belongs together at once, or run the operation that made it again",
                     (int)(n - m), text);
    free(text);
    return more;
}

char *vvi_files_sentence(const vvi_session *session, const char *sentence)
{
    char *text = vvi_strdup(sentence);
    const size_t n = session->uploads ? strlen(session->uploads) : 0;
    bool own = false;
    for (char *at = text; at && n && (at = strstr(at, session->uploads)) != NULL;) {
        own = true;
        size_t skipped = at[n] == '/' ? n + 1 : 0;
        const size_t folder = strcspn(at + skipped, "/ :'");
        if (skipped && at[skipped + folder] == '/') /* the file's own, of which nobody has heard either */
            skipped += folder + 1;
        memmove(at, at + skipped, strlen(at + skipped) + 1);
        at += skipped ? 0 : n;
    }
    return own ? explain_gone(text) : text;
}

bool vvi_files_is_scene(const char *path)
{
    const size_t n = strlen(path);
    return n > 8 && strcmp(path + n - 8, ".vv.json") == 0;
}

void vvi_session_shows(vvi_session *session, const char *path)
{
    free(session->saved);
    session->saved = path && vvi_files_is_scene(path) ? realpath(path, NULL) : NULL;
}

/* Folders --------------------------------------------------------------------------------------------------------- */

typedef struct named {
    char *name;
    bool folder;
    int64_t bytes;
} named;

/* What a link stands for counts, where that may be opened at all. */
static bool look(struct stat *out, DIR *dir, const char *folder, const char *name, const vv_job *job)
{
    if (fstatat(dirfd(dir), name, out, AT_SYMLINK_NOFOLLOW) != 0)
        return false;
    if (!S_ISLNK(out->st_mode))
        return true;
    char *path = vvi_asprintf("%s/%s", folder, name);
    const int fd = path ? vvi_open_place(path, O_PATH, false, job) : -1;
    const bool seen = fd >= 0 && fstat(fd, out) == 0;
    if (fd >= 0)
        close(fd);
    free(path);
    return seen;
}

static bool has_suffix(const char *name, const char *const *suffixes)
{
    const size_t n = strlen(name);
    for (; suffixes && *suffixes; suffixes++) {
        const size_t m = strlen(*suffixes);
        if (n > m && strcasecmp(name + n - m, *suffixes) == 0)
            return true;
    }
    return false;
}

bool vvi_files_is_data_folder(const char *name, const vv_registry *registry)
{
    for (size_t i = 0; registry->formats[i]; i++)
        if (registry->formats[i]->probe_folder && has_suffix(name, registry->formats[i]->suffixes))
            return true;
    return false;
}

static const char *kind_of(const char *name, bool folder, const vv_registry *registry)
{
    static const char *const scene[] = {".vv.json", NULL}, *const packed[] = {".gz", ".zst", ".bz2", NULL};
    if (folder)
        return vvi_files_is_data_folder(name, registry) ? "volume" : NULL;
    if (has_suffix(name, scene))
        return "scene";
    for (size_t i = 0; registry->mesh_formats[i]; i++)
        if (has_suffix(name, registry->mesh_formats[i]->suffixes))
            return "mesh";
    for (size_t i = 0; registry->formats[i]; i++)
        if (has_suffix(name, registry->formats[i]->suffixes))
            return "volume";
    for (size_t i = 0; registry->image_formats[i]; i++)
        if (has_suffix(name, registry->image_formats[i]->suffixes))
            return "picture";
    return has_suffix(name, packed) ? "volume" : NULL;
}

static int by_name(const void *a, const void *b)
{
    const named *x = a, *y = b;
    if (x->folder != y->folder)
        return x->folder ? -1 : 1;
    return strcasecmp(x->name, y->name);
}

static vv_status list(named **out, size_t *n_out, const char *folder, const vv_job *job)
{
    const int fd = vvi_open_place(folder, O_RDONLY | O_DIRECTORY, false, job);
    DIR *dir = fd >= 0 ? fdopendir(fd) : NULL;
    if (!dir) {
        const vv_status st = vv_fail_at(VV_E_READ, folder, NULL, "cannot be listed: %s", strerror(errno));
        if (fd >= 0)
            close(fd);
        return st;
    }
    named *all = vvi_calloc(ENTRIES_MOST, sizeof *all);
    size_t n = 0;
    for (struct dirent *e; all && n < ENTRIES_MOST && (e = readdir(dir)) != NULL;) {
        struct stat info;
        if (e->d_name[0] == '.' || !look(&info, dir, folder, e->d_name, job) ||
            !(S_ISDIR(info.st_mode) || S_ISREG(info.st_mode)))
            continue;
        all[n] = (named){vvi_strdup(e->d_name), S_ISDIR(info.st_mode), (int64_t)info.st_size};
        n += all[n].name != NULL;
    }
    closedir(dir);
    if (!all)
        return vv_fail_memory(ENTRIES_MOST * sizeof *all);
    qsort(all, n, sizeof *all, by_name);
    *out = all;
    *n_out = n;
    return VV_OK;
}

const char *vvi_files_from_root(const vvi_session *session, const char *real)
{
    const size_t n = strlen(session->root);
    if (n == 1 || !is_below(real, session->root))
        return real;
    return real[n] ? real + n : "/";
}

vv_status vvi_files_browse(vvi_result *out, const vvi_session *session, const char *path)
{
    named *all = NULL;
    size_t n = 0;
    char *folder;
    vv_job *job = NULL;
    vv_status st = vvi_files_resolve(&folder, session, path, false);
    if (st != VV_OK)
        return st;
    if ((st = vv_job_new(&job, session->options.runtime, NULL, NULL)) == VV_OK)
        st = list(&all, &n, folder, job);
    if (st == VV_OK) {
        const vv_registry *registry = vv_runtime_registry(session->options.runtime);
        vvi_result_open(out, NULL, '{');
        vvi_result_string(out, "path", vvi_files_from_root(session, folder));
        vvi_result_open(out, "entries", '[');
        for (size_t i = 0; i < n; i++) {
            vvi_result_open(out, NULL, '{');
            vvi_result_string(out, "name", all[i].name);
            vvi_result_bool(out, "folder", all[i].folder);
            vvi_result_integer(out, "bytes", all[i].bytes);
            vvi_result_string(out, "kind", kind_of(all[i].name, all[i].folder, registry));
            vvi_result_close(out, '}');
            free(all[i].name);
        }
        vvi_result_close(out, ']');
        vvi_result_close(out, '}');
    }
    vv_job_release(job);
    free(all);
    free(folder);
    return st;
}
