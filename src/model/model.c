/* A model's life, its snapshots, its context. */
#include "core/memory.h"
#include "core/status.h"
#include "model/context.h"
#include "model/model_impl.h"
#include <stdlib.h>
#include <string.h>

static void init_locks(vv_model *model)
{
    pthread_mutexattr_t knows_owner;
    pthread_mutexattr_init(&knows_owner);
    pthread_mutexattr_settype(&knows_owner, PTHREAD_MUTEX_ERRORCHECK);
    pthread_mutex_init(&model->edit, &knows_owner);
    pthread_mutex_init(&model->swap, NULL);
    pthread_mutexattr_destroy(&knows_owner);
}

vv_status vv_model_new(vv_model **out, vv_runtime *runtime)
{
    *out = NULL;
    vv_model *model = vvi_alloc_zeroed(NULL, sizeof *model, VVI_MEM_MODEL);
    if (!model)
        return vv_fail_memory(sizeof *model);
    model->refs = 1;
    model->runtime = runtime ? vv_runtime_retain(runtime) : NULL;
    const vv_property_context context = vvi_registry_context(runtime ? vv_runtime_registry(runtime) : NULL);
    init_locks(model);
    vv_status st = vvi_history_init(model);
    if (st == VV_OK)
        st = vv_object_new(&model->world, &vv_world_class, &context);
    if (st != VV_OK) {
        vv_model_release(model);
        return st;
    }
    *out = model;
    return VV_OK;
}

vv_model *vv_model_retain(vv_model *model)
{
    __atomic_add_fetch(&model->refs, 1, __ATOMIC_RELAXED);
    return model;
}

void vv_model_release(vv_model *model)
{
    if (!model || __atomic_sub_fetch(&model->refs, 1, __ATOMIC_ACQ_REL))
        return;
    vvi_history_clear(model);
    vvi_free(model->history);
    vv_job_release(model->job);
    vvi_paths_clear(&model->open_paths);
    free(model->open_who);
    vv_object_release(model->open_before);
    vvi_free(model->watchers);
    vv_object_release(model->world);
    vv_object_release(model->voxel_world);
    for (size_t i = 0; i < model->n_units; i++)
        free(model->units[i]);
    vvi_free(model->units);
    pthread_mutex_destroy(&model->edit);
    pthread_mutex_destroy(&model->swap);
    vv_runtime_release(model->runtime);
    vvi_free(model);
}

vv_world *vv_model_snapshot(vv_model *model)
{
    pthread_mutex_lock(&model->swap);
    vv_object *world = vv_object_retain(model->world);
    pthread_mutex_unlock(&model->swap);
    return (vv_world *)world;
}

void vvi_model_swap(vv_model *model, vv_object *world)
{
    pthread_mutex_lock(&model->swap);
    vv_object *old = model->world;
    model->world = world;
    pthread_mutex_unlock(&model->swap);
    vv_object_release(old); /* may be long: not under the lock */
}

/* The context --------------------------------------------------------------------------------------------------- */

/* The model's own copy of a unit's name; without memory the name is unknown. Under the swap lock. */
static const char *keep_unit(vv_model *model, const char *unit)
{
    for (size_t i = 0; i < model->n_units; i++) {
        if (!strcmp(model->units[i], unit))
            return model->units[i];
    }
    char *copy = vvi_strdup(unit);
    char **units = vvi_realloc(NULL, model->units, (model->n_units + 1) * sizeof *units, VVI_MEM_MODEL);
    if (units)
        model->units = units;
    if (!units || !copy) {
        free(copy);
        return NULL;
    }
    units[model->n_units++] = copy;
    return copy;
}

/* True and *out when the voxel of this World's datasets is known already. Under the swap lock. */
static bool known_voxel(double *out, const vv_model *model, const vv_world *world)
{
    const vv_world *known = (const vv_world *)model->voxel_world;
    *out = model->voxel;
    return known && known->datasets == world->datasets;
}

static double find_voxel(vv_model *model, const vv_world *world)
{
    vv_job *job = NULL;
    if (model->runtime && vv_job_new(&job, model->runtime, NULL, NULL) != VV_OK)
        return 0;
    const double voxel = vvi_world_context(world, job).voxel;
    vv_job_release(job);
    return voxel;
}

vv_property_context vv_model_context(vv_model *model)
{
    vv_world *world = vv_model_snapshot(model);
    double voxel = 0;
    pthread_mutex_lock(&model->swap);
    const bool known = known_voxel(&voxel, model, world);
    pthread_mutex_unlock(&model->swap);
    if (!known)
        voxel = find_voxel(model, world);

    vv_property_context context = vvi_registry_context(model->runtime ? vv_runtime_registry(model->runtime) : NULL);
    vv_object *forgotten = NULL;
    context.voxel = voxel;
    pthread_mutex_lock(&model->swap);
    context.length_unit = keep_unit(model, world->unit);
    if (!known) {
        forgotten = model->voxel_world;
        model->voxel_world = vv_object_retain(&world->base);
        model->voxel = voxel;
    }
    pthread_mutex_unlock(&model->swap);
    vv_object_release(forgotten);
    vv_object_release(&world->base);
    return context;
}

/* Locks and watchers -------------------------------------------------------------------------------------------- */

vv_status vvi_model_lock(vv_model *model)
{
    if (pthread_mutex_lock(&model->edit))
        return vv_fail(VV_E_ARGUMENT, "a model cannot be edited from inside a watcher of its commits");
    return VV_OK;
}

void vvi_model_unlock(vv_model *model)
{
    pthread_mutex_unlock(&model->edit);
}

vv_status vv_model_watch(vv_model *model, vv_commit_fn *fn, void *user)
{
    vv_status st = vvi_model_lock(model);
    if (st != VV_OK)
        return st;
    const size_t bytes = (model->n_watchers + 1) * sizeof *model->watchers;
    vvi_watcher *watchers = vvi_realloc(NULL, model->watchers, bytes, VVI_MEM_MODEL);
    if (watchers) {
        model->watchers = watchers;
        watchers[model->n_watchers++] = (vvi_watcher){fn, user};
    } else {
        st = vv_fail_memory(bytes);
    }
    vvi_model_unlock(model);
    return st;
}
