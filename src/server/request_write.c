/* Files that a page names: where they may be, and data of the World as such a file. */
#include "core/job.h"
#include "core/memory.h"
#include "run/made.h"
#include "server/request.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* The place ---------------------------------------------------------------------------------------------------------
 */

/* What the server writes goes when it ends. */
static vv_status check_place(const vvi_session *s, const char *path)
{
    const size_t n = s->uploads ? strlen(s->uploads) : 0;
    if (!n || strncmp(path, s->uploads, n) != 0 || path[n] != '/')
        return VV_OK;
    return vv_fail(
        VV_E_ARGUMENT,
        "nothing can be saved among the uploads and samples of this session, since they are deleted when the "
        "server ends; choose another folder");
}

/* Whether a dataset of the World is read from this folder. */
static const char *shown_from(const vv_world *world, const char *folder)
{
    struct stat here, source;
    for (size_t i = 0; i < world->datasets->n && stat(folder, &here) == 0; i++) {
        const vv_dataset *d = vvi_dataset_nth(world, i);
        if (d->path && stat(d->path, &source) == 0 && source.st_dev == here.st_dev && source.st_ino == here.st_ino)
            return world->datasets->entry[i].id;
    }
    return NULL;
}

/* What is put into a folder that is a volume would belong to it from then on, or make it none. A scene is no data: only
 * folders that belong to a format as a whole have no place for it. */
static vv_status check_folders(const vvi_request *r)
{
    char *folder = vvi_strdup(r->path);
    const char *root = r->session->options.root;
    const bool scene = vvi_files_is_scene(r->path);
    vv_status st = folder ? VV_OK : vv_fail_memory(strlen(r->path));
    for (char *slash; st == VV_OK && (slash = strrchr(folder, '/')) != NULL && slash != folder;) {
        *slash = 0;
        const char *name = strrchr(folder, '/'), *id = scene ? NULL : shown_from(r->world, folder);
        if (id)
            st = vv_fail(VV_E_ARGUMENT, "'%.200s' is the folder of the dataset '%.64s'; choose another one",
                         vvi_files_from_root(r->session, folder), id);
        else if (name && vvi_files_is_data_folder(name + 1, vv_runtime_registry(r->session->options.runtime)))
            st = vv_fail(VV_E_ARGUMENT, "'%.200s' is a volume, and no folder for other files; choose another one",
                         vvi_files_from_root(r->session, folder));
        if (strcmp(folder, root) == 0)
            break;
    }
    free(folder);
    return st;
}

/* A suffix behind nothing would be a name, and a hidden one. */
static vv_status check_name(const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    if (*name && strcmp(name, ".") != 0 && strcmp(name, "..") != 0)
        return VV_OK;
    return vv_fail(VV_E_ARGUMENT, "'%.200s' is a folder; expected the name of a file", path);
}

vv_status vvi_request_take_place(vvi_request *r, const char *said, const char *path)
{
    vv_status st = check_name(said);
    if (st == VV_OK)
        st = vvi_files_resolve(&r->path, r->session, path, true);
    if (st == VV_OK)
        st = check_place(r->session, r->path);
    return st == VV_OK ? check_folders(r) : st;
}

vv_status vvi_request_keep_existing(vvi_request *r, vv_job *job)
{
    struct stat info;
    if (r->replace)
        return VV_OK;
    vvi_job_keep_existing(job);
    r->exists = lstat(r->path, &info) == 0;
    return r->exists ? vv_fail(VV_E_WRITE, "%s already exists, and is left as it is", strrchr(r->path, '/') + 1)
                     : VV_OK;
}

vv_status vvi_request_note_exists(vvi_request *r, vv_status st)
{
    struct stat info;
    r->exists = st == VV_E_WRITE && !r->replace && lstat(r->path, &info) == 0;
    return st;
}

void vvi_request_tell_path(vvi_request *r)
{
    vvi_result_open(&r->value, NULL, '{');
    vvi_result_string(&r->value, "path", vvi_files_from_root(r->session, r->path));
    if (r->note)
        vvi_result_string(&r->value, "note", r->note);
    vvi_result_close(&r->value, '}');
}

/* Data ------------------------------------------------------------------------------------------------------------- */

/* What data are made of is not written over: they would be others from then on. Links lead to it too. */
static vv_status check_sources(const vvi_request *r)
{
    struct stat target, source;
    if (stat(r->path, &target) != 0)
        return VV_OK;
    for (size_t i = 0; i < r->world->datasets->n; i++) {
        const vv_dataset *d = vvi_dataset_nth(r->world, i);
        if (d->path && stat(d->path, &source) == 0 && source.st_dev == target.st_dev && source.st_ino == target.st_ino)
            return vv_fail(VV_E_ARGUMENT, "%s is the file of the dataset '%.64s'; choose another name",
                           strrchr(r->path, '/') + 1, r->world->datasets->entry[i].id);
    }
    return VV_OK;
}

static vv_status run(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const vv_dataset *dataset = vvi_dataset_named(r->world, r->dataset);
    if (!dataset)
        return vv_fail(VV_E_NOT_FOUND, "there is no dataset '%.64s'", r->dataset);
    vvi_disk_share share;
    vv_status st = check_sources(r);
    if (st == VV_OK)
        st = vvi_request_keep_existing(r, job);
    if (st == VV_OK && (st = vvi_disk_share_begin(&share, r->session, r->path, job)) == VV_OK)
        st = vvi_disk_share_end(&share, vvi_made_write(r->path, r->world, dataset, job), job);
    if (st != VV_OK)
        return vvi_request_note_exists(r, st);
    vvi_request_take_notes(r, job);
    vvi_request_tell_path(r);
    return VV_OK;
}

vv_status vvi_request_write(vvi_client *client, int64_t id, const json_t *message)
{
    const char *path = json_string_value(json_object_get(message, "path"));
    vvi_request *r;
    if (!json_is_string(json_object_get(message, "dataset")) || !path || !*path)
        return vv_fail(VV_E_ARGUMENT, "'write' needs a dataset and a path");
    vv_status st = vvi_request_new(&r, client, id, "write", run);
    if (st != VV_OK)
        return st;
    r->task.done = vvi_request_done_slowly;
    r->task.stays = true;
    r->replace = json_is_true(json_object_get(message, "replace"));
    if ((st = vvi_request_take_text(&r->dataset, message, "dataset")) == VV_OK)
        st = vvi_request_take_place(r, path, path);
    return vvi_request_add_slow(r, st);
}
