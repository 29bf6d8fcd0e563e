/* Meshes in a folder, and folders that are volumes: they are no parts of what is read as a volume. */
#include "about/about.h"
#include "core/job.h"
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

static void list_folders(const vvi_about *about, const vvi_names *names, const char *path)
{
    vv_answer *a = about->answer;
    const char *slash = path[0] && path[strlen(path) - 1] == '/' ? "" : "/";
    vvi_tell_open(a, "folders", "[");
    for (size_t i = 0; i < names->n; i++) {
        vvi_tell_text(a, NULL, names->name[i]);
        if (i < vvi_about_lines(about))
            vvi_tell_line(a, i ? "" : "folders", "%s: a volume by its name; to read it: %s%s%s", names->name[i], path,
                          slash, names->name[i]);
    }
    vvi_about_more(about, names->n);
    vvi_tell_close(a, "]");
}

static void list_meshes(const vvi_about *about, const vvi_names *names)
{
    vv_answer *a = about->answer;
    vvi_tell_open(a, "meshes", "[");
    for (size_t i = 0; i < names->n; i++) {
        const char *format = vvi_mesh_format_of_path(names->name[i], vvi_job_registry(about->job))->name;
        vvi_tell_open(a, NULL, "{");
        vvi_tell_text(a, "name", names->name[i]);
        vvi_tell_text(a, "format", format);
        vvi_tell_close(a, "}");
        if (i < vvi_about_lines(about))
            vvi_tell_line(a, i ? "" : "meshes", "%s: %s", names->name[i], format);
    }
    vvi_about_more(about, names->n);
    vvi_tell_close(a, "]");
}

vv_status vv_about_folder(vv_answer **out, size_t *n_meshes_out, size_t *n_volumes_out, const char *path,
                          const vv_about_options *options, vv_job *job)
{
    vvi_about about;
    vvi_names meshes = {0}, folders = {0};
    const vv_status st = vvi_about_begin(&about, out, options, job);
    *n_meshes_out = *n_volumes_out = 0;
    if (st != VV_OK)
        return st;
    find(&meshes, &folders, path, job);
    if (meshes.n > 0)
        list_meshes(&about, &meshes);
    if (folders.n > 0)
        list_folders(&about, &folders, path);
    *n_meshes_out = meshes.n;
    *n_volumes_out = folders.n;
    vvi_names_free(&meshes);
    vvi_names_free(&folders);
    return vvi_about_end(about.answer, VV_OK);
}
