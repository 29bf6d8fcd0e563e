#include "core/installed.h"
#include "config.h"
#include <dlfcn.h>
#include <link.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char *modules_folder;

void vvi_installed_modules_at(const char *folder)
{
    modules_folder = folder;
}

static bool is_there(char *out, size_t room, const char *folder, const char *below, const char *name, int mode)
{
    return snprintf(out, room, "%s/%s%s", folder, below, name) < (int)room && access(out, mode) == 0;
}

/* "" when the path has none. */
static void cut_name(char *path)
{
    char *slash = strrchr(path, '/');
    *(slash ? slash : path) = 0;
}

static void folder_of_program(char *out, size_t room)
{
    const ssize_t n = readlink("/proc/self/exe", out, room - 1);
    out[n > 0 ? n : 0] = 0;
    cut_name(out);
}

/* "" when this code is in the program itself. */
static void folder_of_library(char *out, size_t room)
{
    static const char here;
    Dl_info info;
    void *map = NULL;
    *out = 0;
    if (dladdr1(&here, &info, &map, RTLD_DL_LINKMAP) != 0 && map)
        snprintf(out, room, "%s", ((const struct link_map *)map)->l_name);
    cut_name(out);
}

bool vvi_installed_find(char *out, size_t room, const char *name, int mode)
{
    /* lib/ARCHITECTURE is one folder deeper than bin; a build folder has its library one deeper than its programs */
    static const char *const of_program[] = {"", "../libexec/volvis/"};
    static const char *const of_library[] = {"", "../libexec/volvis/", "../../libexec/volvis/", "../"};
    char folder[4096];
    if (modules_folder && mode == R_OK && is_there(out, room, modules_folder, "", name, mode))
        return true;
    folder_of_program(folder, sizeof folder);
    for (size_t i = 0; *folder && i < sizeof of_program / sizeof *of_program; i++)
        if (is_there(out, room, folder, of_program[i], name, mode))
            return true;
    folder_of_library(folder, sizeof folder);
    for (size_t i = 0; *folder && i < sizeof of_library / sizeof *of_library; i++)
        if (is_there(out, room, folder, of_library[i], name, mode))
            return true;
    return is_there(out, room, VV_LIBEXEC, "", name, mode);
}
