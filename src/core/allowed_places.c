#include "core/allowed_places.h"
#include "core/memory.h"
#include "core/runtime.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

vv_status vvi_places_init(vvi_places *places)
{
    *places = (vvi_places){0};
    return pthread_mutex_init(&places->lock, NULL) == 0 ? VV_OK : vv_fail_memory(sizeof *places);
}

void vvi_places_finish(vvi_places *places)
{
    for (size_t i = 0; i < places->n; i++) {
        free(places->place[i].path);
        if (places->place[i].folder >= 0)
            close(places->place[i].folder);
    }
    free(places->place);
    free(places->strange);
    pthread_mutex_destroy(&places->lock);
}

/* Takes the descriptor, also when it fails. */
static vv_status add(vv_runtime *runtime, const char *path, int folder, bool trusted)
{
    vvi_places *places = &runtime->places;
    char *copy = vvi_strdup(path);
    pthread_mutex_lock(&places->lock);
    vvi_allowed_place *more = copy ? vvi_realloc_plain(places->place, (places->n + 1) * sizeof *more) : NULL;
    if (more) {
        places->place = more;
        more[places->n++] = (vvi_allowed_place){copy, strlen(copy), folder, trusted};
        places->confined |= folder >= 0;
    }
    pthread_mutex_unlock(&places->lock);
    if (more)
        return VV_OK;
    free(copy);
    if (folder >= 0)
        close(folder);
    return vv_fail_memory(strlen(path));
}

vv_status vvi_runtime_confine(vv_runtime *runtime, const char *folder)
{
    const int fd = open(folder, O_PATH | O_DIRECTORY | O_CLOEXEC);
    return fd >= 0 ? add(runtime, folder, fd, false) : vv_fail_at(VV_E_READ, folder, NULL, "%s", strerror(errno));
}

vv_status vvi_runtime_give(vv_runtime *runtime, const char *file)
{
    return add(runtime, file, -1, false);
}

vv_status vvi_runtime_trust(vv_runtime *runtime, const char *file)
{
    return add(runtime, file, -1, true);
}

vv_status vvi_runtime_distrust(vv_runtime *runtime, const char *folder)
{
    char *copy = vvi_strdup(folder);
    if (!copy)
        return vv_fail_memory(strlen(folder));
    pthread_mutex_lock(&runtime->places.lock);
    free(runtime->places.strange);
    runtime->places.strange = copy;
    pthread_mutex_unlock(&runtime->places.lock);
    return VV_OK;
}

void vvi_runtime_distrust_all(vv_runtime *runtime)
{
    runtime->places.all_strange = true;
}

bool vvi_job_distrusts_all(const vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    return runtime && runtime->places.all_strange;
}

bool vvi_job_confined(const vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    return runtime && runtime->places.confined;
}

static bool is_below(const char *real, const char *folder, size_t n)
{
    return strncmp(real, folder, n) == 0 && (real[n] == '/' || !real[n]);
}

/* Whether a folder is that of a file. */
static bool is_folder_of(const char *folder, const vvi_allowed_place *file)
{
    const char *slash = strrchr(file->path, '/');
    const size_t n = (size_t)(slash - file->path);
    return strncmp(folder, file->path, n) == 0 && (!folder[n] || (n == 0 && strcmp(folder, "/") == 0));
}

int vvi_job_place(const vv_job *job, const char *real, bool beside, const char **rest)
{
    vvi_places *places = &vv_job_runtime(job)->places;
    int found = -2;
    pthread_mutex_lock(&places->lock);
    for (size_t i = 0; i < places->n && found == -2; i++) {
        const vvi_allowed_place *p = &places->place[i];
        if (p->folder < 0 && (strcmp(real, p->path) == 0 || (beside && is_folder_of(real, p)))) {
            found = -1;
        } else if (p->folder >= 0 && is_below(real, p->path, p->n)) {
            found = p->folder;
            *rest = real[p->n] ? real + p->n + 1 : ".";
        }
    }
    pthread_mutex_unlock(&places->lock);
    return found;
}

bool vvi_job_trusts(const vv_job *job, const char *real)
{
    vv_runtime *runtime = vv_job_runtime(job);
    bool found = false;
    if (!runtime)
        return false;
    pthread_mutex_lock(&runtime->places.lock);
    for (size_t i = 0; i < runtime->places.n && !found; i++)
        found = runtime->places.place[i].trusted && strcmp(runtime->places.place[i].path, real) == 0;
    pthread_mutex_unlock(&runtime->places.lock);
    return found;
}

bool vvi_job_distrusts(const vv_job *job, const char *path)
{
    vv_runtime *runtime = vv_job_runtime(job);
    if (!runtime || !runtime->places.strange)
        return false;
    char *real = realpath(path, NULL);
    pthread_mutex_lock(&runtime->places.lock);
    const bool below = real && is_below(real, runtime->places.strange, strlen(runtime->places.strange));
    pthread_mutex_unlock(&runtime->places.lock);
    free(real);
    return below;
}
