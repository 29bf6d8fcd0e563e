#include "model/file_path.h"
#include "core/memory.h"
#include "core/text.h"
#include <limits.h>
#include <stdlib.h>
#include <string.h>

char *vvi_folder_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    if (!slash)
        return vvi_strdup(".");
    return slash == path ? vvi_strdup("/") : vvi_asprintf("%.*s", (int)(slash - path), path);
}

/* Where a file's folder really is; false when it is not there. */
static bool real_folder(char out[PATH_MAX], const char *path)
{
    char *folder = vvi_folder_of(path);
    const bool found = folder && realpath(folder, out);
    free(folder);
    return found;
}

static bool is_part(const char *at, size_t n, const char *part)
{
    return strlen(part) == n && !strncmp(at, part, n);
}

/* Takes out "." and pairs of a name and "..", as text. */
static char *clean(const char *path)
{
    vvi_text text = {0};
    size_t n_names = 0; /* at the end of the text that ".." can take back */
    const bool absolute = path[0] == '/';
    vvi_text_add(&text, absolute ? "/" : "");
    while (*path) {
        const size_t n = strcspn(path, "/");
        if (is_part(path, n, "..") && n_names && !text.bad) {
            while (text.n && text.s[text.n - 1] != '/')
                text.n--;
            text.n -= text.n > (absolute ? 1U : 0U);
            text.s[text.n] = 0;
            n_names--;
        } else if (n && !is_part(path, n, ".")) {
            vvi_text_add(&text, text.n && text.s[text.n - 1] != '/' ? "/" : "");
            vvi_text_add_n(&text, path, n);
            n_names += !is_part(path, n, "..");
        }
        path += n + (path[n] == '/');
    }
    return vvi_text_take(&text);
}

/* clean(), unless a symbolic link makes that another file. */
static char *tidy(char *path)
{
    char before[PATH_MAX], after[PATH_MAX];
    char *cleaned = path ? clean(path) : NULL;
    if (!cleaned)
        return path;
    const bool same = !strstr(path, "..") ||
                      (real_folder(before, path) ? real_folder(after, cleaned) && !strcmp(before, after) : false);
    free(same ? path : cleaned);
    return same ? cleaned : path;
}

static bool is_here(const char *folder)
{
    return !folder || !*folder || !strcmp(folder, ".");
}

char *vvi_path_from_folder(const char *folder, const char *path)
{
    if (is_here(folder) || path[0] == '/' || !*path || !strcmp(path, "-"))
        return vvi_strdup(path);
    return tidy(vvi_asprintf("%s/%s", folder, path));
}

/* What of an absolute path follows an absolute folder; NULL when it is not below it. */
static const char *below(const char *folder, const char *path)
{
    const size_t n = strlen(folder);
    if (!strcmp(folder, "/"))
        return path[1] ? path + 1 : NULL;
    return !strncmp(path, folder, n) && path[n] == '/' && path[n + 1] ? path + n + 1 : NULL;
}

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* The steps from one absolute folder to another: "../../b/", "" when they are one. */
static char *steps(const char *from, const char *to, const char *name)
{
    vvi_text text = {0};
    size_t common = 0, i = 0;
    for (; from[i] && from[i] == to[i]; i++)
        common = from[i] == '/' ? i : common;
    if ((!from[i] || from[i] == '/') && (!to[i] || to[i] == '/'))
        common = i;
    for (const char *rest = from + common; *rest; rest++) {
        if (*rest == '/' && rest[1])
            vvi_text_add(&text, "../");
    }
    const char *down = to + common + (to[common] == '/');
    vvi_text_printf(&text, "%s%s%s", down, *down ? "/" : "", name);
    return vvi_text_take(&text);
}

char *vvi_path_to_folder(const char *folder, const char *path)
{
    char real[PATH_MAX], data[PATH_MAX];
    if (is_here(folder) || !*path || !strcmp(path, "-") || !realpath(folder, real))
        return vvi_strdup(path);
    if (path[0] == '/') {
        const char *rest = below(real, path);
        return vvi_strdup(rest ? rest : path);
    }
    char *own = vvi_folder_of(path);
    if (!own)
        return NULL;
    const bool is_there = realpath(own, data) != NULL;
    free(own);
    if (!is_there)
        return vvi_strdup(path);
    char *whole = steps("/", data, base_name(path)); /* without its first slash */
    if (folder[0] != '/' || !whole) {
        free(whole);
        return steps(real, data, base_name(path));
    }
    char *absolute = vvi_asprintf("/%s", whole);
    free(whole);
    const char *rest = absolute ? below(real, absolute) : NULL;
    char *out = rest ? vvi_strdup(rest) : absolute;
    if (rest)
        free(absolute);
    return out;
}
