/* FILE[:PART][@N] to its parts. */
#include "core/memory.h"
#include "input.h"
#include "io/mesh_file.h"
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Where "@N" starts; NULL when the word does not end so. */
static const char *frame_mark(const char *word)
{
    const char *mark = strrchr(word, '@');
    const size_t digits = mark ? strspn(mark + 1, "0123456789") : 0;
    if (!mark || mark == word || digits == 0 || digits > 15 || mark[1 + digits] != 0)
        return NULL;
    return mark;
}

/* FILE@WORD, where FILE is there: the word was meant as a time step. */
static vv_status check_frame_mark(const char *word)
{
    char path[4096];
    const char *mark = strrchr(word, '@');
    const size_t n = mark ? (size_t)(mark - word) : 0;
    if (n == 0 || n >= sizeof path || frame_mark(word))
        return VV_OK;
    memcpy(path, word, n);
    path[n] = 0;
    return access(path, F_OK) == 0
               ? vv_fail(VV_E_ARGUMENT, "%s: '%.40s' is not a time step; time steps are numbered from 0, as in %s@0",
                         word, mark + 1, path)
               : VV_OK;
}

/* Where ":PART" starts, before `end`: after the longest name of something that is there. */
static const char *part_mark(const char *word, size_t end)
{
    char path[4096];
    if (end >= sizeof path)
        return NULL;
    for (size_t n = end - (end > 0); n > 0; n--) {
        if (word[n] != ':')
            continue;
        memcpy(path, word, n);
        path[n] = 0;
        if (strcmp(path, "-") == 0 || access(path, F_OK) == 0)
            return word + n;
    }
    return NULL;
}

/* The folder of a pattern of names, "run/jet_{t}.vti": how long its name is; SIZE_MAX where the word is none. */
static size_t pattern_folder(const char *word, size_t end)
{
    char path[4096];
    size_t n = end;
    while (n > 0 && word[n - 1] != '/')
        n--;
    if (n >= sizeof path || strcspn(word + n, "*?#{") >= end - n)
        return SIZE_MAX;
    memcpy(path, word, n);
    path[n] = 0;
    return n == 0 || access(path, F_OK) == 0 ? n : SIZE_MAX;
}

/* Files of a folder, by a pattern of their names: its part by that name. */
static vv_status split_pattern(cli_input_name *out, const char *word, size_t n_folder, size_t end)
{
    out->path = n_folder > 0 ? strndup(word, n_folder) : strdup(".");
    out->part = strndup(word + n_folder, end - n_folder);
    if (out->path && out->part)
        return VV_OK;
    cli_input_name_free(out);
    return vv_fail_memory(end + 1);
}

/* FOLDER:skin.ply[:PART]: a mesh in a folder is a file as any, which no reader of volumes takes as a part. */
static vv_status join_mesh(cli_input_name *name)
{
    const char *part = name->part;
    for (size_t n = part ? strlen(part) : 0; n > 0; n--) {
        if (part[n] && part[n] != ':')
            continue;
        char *path = vvi_asprintf("%s/%.*s", name->path, (int)n, part);
        char *rest = part[n] ? strdup(part + n + 1) : NULL;
        if (!path || (part[n] && !rest)) {
            free(path);
            free(rest);
            return vv_fail_memory(strlen(name->path) + n);
        }
        if (vvi_mesh_format_of_path(path, vv_registry_builtin()) && access(path, F_OK) == 0) {
            free(name->path);
            free(name->part);
            name->path = path;
            name->part = rest;
            return VV_OK;
        }
        free(path);
        free(rest);
    }
    return VV_OK;
}

vv_status cli_input_split(cli_input_name *out, const char *word)
{
    *out = (cli_input_name){.frame = -1};
    if (!word[0])
        return vv_fail(VV_E_ARGUMENT, "the name of the input is empty; give a file, a folder, or - for standard input");
    const bool whole = access(word, F_OK) == 0;
    const vv_status st = whole ? VV_OK : check_frame_mark(word);
    if (st != VV_OK)
        return st;
    const char *frame = whole ? NULL : frame_mark(word);
    const size_t end = frame ? (size_t)(frame - word) : strlen(word);
    const char *part = whole ? NULL : part_mark(word, end);
    if (part && part + 1 == word + end)
        return vv_fail(VV_E_ARGUMENT, "%s: no part is named after ':'; name one, or leave ':' out", word);
    const size_t n = part ? (size_t)(part - word) : end;
    if (frame)
        out->frame = strtoll(frame + 1, NULL, 10);
    const size_t folder = whole || part ? SIZE_MAX : pattern_folder(word, end);
    if (folder != SIZE_MAX)
        return split_pattern(out, word, folder, end);
    out->path = strndup(word, n);
    if (part)
        out->part = strndup(part + 1, end - n - 1);
    if (out->path && (!part || out->part))
        return join_mesh(out);
    cli_input_name_free(out);
    return vv_fail_memory(end + 1);
}

void cli_input_name_free(cli_input_name *name)
{
    free(name->path);
    free(name->part);
    *name = (cli_input_name){.frame = -1};
}
