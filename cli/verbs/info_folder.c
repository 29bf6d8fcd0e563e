#include "info_folder.h"
#include "info_names.h"
#include "input.h"
#include "io/folder.h"
#include "io/mesh_file.h"
#include <string.h>
#include <sys/stat.h>

/* Of what is no folder, or cannot be listed, none. */
static void find(vvi_names *meshes, vvi_names *folders, const char *path, vv_job *job)
{
    struct stat about;
    vv_source *folder;
    if (stat(path, &about) != 0 || !S_ISDIR(about.st_mode)) /* a stream that is opened once more loses bytes */
        return;
    if (vvi_source_open_input(&folder, path, job) != VV_OK)
        return;
    vvi_folder_meshes(meshes, folder, job);
    vvi_folder_volumes(folders, folder, job);
    vvi_source_close(folder);
}

static void list_folders(cli_command *command, const vvi_names *names, const char *path)
{
    const char *slash = path[0] && path[strlen(path) - 1] == '/' ? "" : "/";
    vvi_result_open(&command->json, "folders", '[');
    for (size_t i = 0; i < names->n; i++) {
        vvi_result_string(&command->json, NULL, names->name[i]);
        if (i < cli_info_lines(command))
            cli_command_line(command, i ? "" : "folders", "%s: a volume by its name; to read it: %s%s%s",
                             names->name[i], path, slash, names->name[i]);
    }
    cli_info_more(command, names->n);
    vvi_result_close(&command->json, ']');
}

static void list_meshes(cli_command *command, const vvi_names *names)
{
    vvi_result_open(&command->json, "meshes", '[');
    for (size_t i = 0; i < names->n; i++) {
        const char *format = vvi_mesh_format_of_path(names->name[i], command->registry)->name;
        vvi_result_open(&command->json, NULL, '{');
        vvi_result_string(&command->json, "name", names->name[i]);
        vvi_result_string(&command->json, "format", format);
        vvi_result_close(&command->json, '}');
        if (i < cli_info_lines(command))
            cli_command_line(command, i ? "" : "meshes", "%s: %s", names->name[i], format);
    }
    cli_info_more(command, names->n);
    vvi_result_close(&command->json, ']');
}

bool cli_info_folder(cli_command *command, const char *word, bool alone)
{
    cli_input_name name;
    vvi_names meshes = {0}, folders = {0};
    if (cli_input_split(&name, word) != VV_OK)
        return false;
    if (!name.part)
        find(&meshes, &folders, name.path, command->job);
    const bool any = meshes.n > 0 || folders.n > 0;
    if (any && alone) {
        cli_command_title(command, name.path);
        vvi_result_string(&command->json, "file", name.path);
        vvi_result_string(&command->json, "format", "folder");
        cli_command_line(command, "format", "folder of %s%s%s", meshes.n ? "meshes" : "",
                         meshes.n && folders.n ? " and " : "", folders.n ? "volumes that are folders" : "");
    }
    if (meshes.n > 0)
        list_meshes(command, &meshes);
    if (folders.n > 0)
        list_folders(command, &folders, name.path);
    vvi_names_free(&meshes);
    vvi_names_free(&folders);
    cli_input_name_free(&name);
    return any;
}
