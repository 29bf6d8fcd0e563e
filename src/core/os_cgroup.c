#include "core/os.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Control groups, version 1: a folder tree for each controller; version 2: one tree. A limit holds for everything below
 * it, so the folders from the process's own up to the root are all asked. In a container the path of the process may
 * not be visible, but the root is then its own group. */

enum { PATH_ROOM = 4096, LINE_ROOM = 4096 };

/* The first line of root/path/name; false when there is none. */
static bool read_line(char line[LINE_ROOM], const char *root, const char *path, const char *name)
{
    char file[PATH_ROOM];
    if (snprintf(file, sizeof file, "%s%s/%s", root, path, name) >= (int)sizeof file)
        return false;
    FILE *f = fopen(file, "re");
    if (!f)
        return false;
    const bool found = fgets(line, LINE_ROOM, f) != NULL;
    fclose(f);
    return found;
}

/* "max" and, in version 1, a huge number mean no limit. */
static void limit_memory(vvi_cgroup_limits *limits, const char *line)
{
    char *end;
    const unsigned long long bytes = strtoull(line, &end, 10);
    if (end != line && bytes < limits->memory_bytes)
        limits->memory_bytes = bytes;
}

static void limit_cores(vvi_cgroup_limits *limits, long long quota_us, long long period_us)
{
    if (quota_us <= 0 || period_us <= 0)
        return;
    const double cores = (double)quota_us / (double)period_us;
    if (cores < limits->cores)
        limits->cores = cores;
}

static void read_folder_v1(vvi_cgroup_limits *limits, const char *root, const char *path)
{
    char line[LINE_ROOM];
    if (read_line(line, root, path, "memory.limit_in_bytes"))
        limit_memory(limits, line);
    if (!read_line(line, root, path, "cpu.cfs_quota_us"))
        return;
    const long long quota_us = strtoll(line, NULL, 10); /* -1: no limit */
    if (read_line(line, root, path, "cpu.cfs_period_us"))
        limit_cores(limits, quota_us, strtoll(line, NULL, 10));
}

static void read_folder_v2(vvi_cgroup_limits *limits, const char *root, const char *path)
{
    char line[LINE_ROOM];
    if (read_line(line, root, path, "memory.max"))
        limit_memory(limits, line);
    if (read_line(line, root, path, "memory.high"))
        limit_memory(limits, line);
    if (read_line(line, root, path, "cpu.max")) {
        char *end;
        const long long quota_us = strtoll(line, &end, 10); /* "max 100000": no number, no limit */
        limit_cores(limits, quota_us, strtoll(end, NULL, 10));
    }
}

/* All folders of a path, the deepest first. */
static void read_tree(vvi_cgroup_limits *limits, const char *root, char *path,
                      void (*read_folder)(vvi_cgroup_limits *limits, const char *root, const char *path))
{
    for (;;) {
        char *slash = strrchr(path, '/');
        if (slash && !slash[1])
            *slash = 0; /* "/" is the root itself */
        read_folder(limits, root, path);
        slash = strrchr(path, '/');
        if (!slash)
            return;
        *slash = 0;
    }
}

static bool has_word(const char *list, const char *word)
{
    const size_t n = strlen(word);
    for (const char *at = list; (at = strstr(at, word)); at += n)
        if ((at == list || at[-1] == ',') && (at[n] == 0 || at[n] == ','))
            return true;
    return false;
}

/* "4:memory:/a/b" of version 1, "0::/a/b" of version 2. Mixed systems mount version 2 at "unified". */
static void read_membership(vvi_cgroup_limits *limits, const char *root, char *line)
{
    char folder[PATH_ROOM];
    char *controllers = strchr(line, ':');
    char *path = controllers ? strchr(controllers + 1, ':') : NULL;
    if (!path)
        return;
    *controllers++ = 0;
    *path++ = 0;
    path[strcspn(path, "\n")] = 0;
    if (!*controllers) {
        snprintf(folder, sizeof folder, "%s/unified", root);
        char again[LINE_ROOM];
        snprintf(again, sizeof again, "%s", path);
        read_tree(limits, root, path, read_folder_v2);
        read_tree(limits, folder, again, read_folder_v2);
    } else if (has_word(controllers, "memory") || has_word(controllers, "cpu")) {
        snprintf(folder, sizeof folder, "%s/%s", root, controllers);
        read_tree(limits, folder, path, read_folder_v1);
    }
}

vvi_cgroup_limits vvi_cgroup_read(const char *membership, const char *root)
{
    vvi_cgroup_limits limits = {.memory_bytes = UINT64_MAX, .cores = INFINITY};
    char line[LINE_ROOM];
    FILE *f = fopen(membership, "re");
    if (!f)
        return limits;
    while (fgets(line, sizeof line, f))
        read_membership(&limits, root, line);
    fclose(f);
    return limits;
}
