/* Looks through the text headers of a folder, as long as there are few and short ones: this is a courtesy, no promise.
 */
#include "io/sink_headers.h"
#include "core/memory.h"
#include <ctype.h>
#include <dirent.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

enum { HEADERS_MOST = 256, HEADER_BYTES = 128 << 10 };

static bool ends_in(const char *name, size_t n, const char *suffix)
{
    const size_t m = strlen(suffix);
    return n > m && strncasecmp(name + n - m, suffix, m) == 0;
}

static bool is_header(const char *name)
{
    static const char *const suffixes[] = {".nhdr", ".mhd", ".vvh", ".dx", ".general", ".dat", ".xmf", ".ifh", ".gltf"};
    const size_t n = strlen(name);
    for (size_t i = 0; i < sizeof suffixes / sizeof *suffixes; i++)
        if (ends_in(name, n, suffixes[i]))
            return true;
    return false;
}

/* A pair of NIfTI says by their names alone that they belong together. */
static bool is_pair(const char *header, const char *file)
{
    const size_t n = strlen(header), m = strlen(file);
    const size_t gz = ends_in(header, n, ".gz") ? 3 : 0, file_gz = ends_in(file, m, ".gz") ? 3 : 0;
    return n - gz == m - file_gz && ends_in(header, n - gz, ".hdr") && ends_in(file, m - file_gz, ".img") &&
           strncmp(header, file, n - gz - 4) == 0;
}

/* What may stand before or after a name in a header. */
static bool is_border(char c)
{
    return c == 0 || isspace((unsigned char)c) || strchr("=:/\"',;<>", c) != NULL;
}

static bool says(const char *text, const char *name)
{
    const size_t n = strlen(name);
    for (const char *at = text; (at = strstr(at, name)) != NULL; at++)
        if ((at == text || is_border(at[-1])) && is_border(at[n]))
            return true;
    return false;
}

static bool names(int folder, const char *header, const char *file)
{
    const int fd = openat(folder, header, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    struct stat info;
    bool found = false;
    char *text = fd >= 0 && fstat(fd, &info) == 0 && S_ISREG(info.st_mode) ? malloc(HEADER_BYTES + 1) : NULL;
    if (text) {
        const ssize_t n = read(fd, text, HEADER_BYTES);
        for (ssize_t i = 0; i < n; i++) /* what lies behind the header may have zeros */
            text[i] = (char)(text[i] ? text[i] : ' ');
        text[n > 0 ? n : 0] = 0;
        found = says(text, file);
    }
    free(text);
    if (fd >= 0)
        close(fd);
    return found;
}

static bool is_same(int folder, const char *name, const char *path)
{
    struct stat a, b;
    return path && fstatat(folder, name, &a, 0) == 0 && stat(path, &b) == 0 && a.st_dev == b.st_dev &&
           a.st_ino == b.st_ino;
}

char *vvi_header_that_names(const char *path, const char *except)
{
    const char *slash = strrchr(path, '/'), *file = slash ? slash + 1 : path;
    char *folder = slash ? vvi_asprintf("%.*s", (int)(slash - path) + 1, path) : vvi_strdup("."), *found = NULL;
    DIR *list = folder ? opendir(folder) : NULL;
    const struct dirent *entry;
    int left = HEADERS_MOST;
    while (list && !found && left > 0 && (entry = readdir(list)) != NULL) {
        const bool pair = is_pair(entry->d_name, file);
        if (!pair && !is_header(entry->d_name))
            continue;
        left--;
        if (strcmp(entry->d_name, file) != 0 && !is_same(dirfd(list), entry->d_name, except) &&
            (pair || names(dirfd(list), entry->d_name, file)))
            found = vvi_strdup(entry->d_name);
    }
    if (list)
        closedir(list);
    free(folder);
    return found;
}
