/** @file
 * Inside the model: the current World, the open transaction, the history.
 */
#ifndef VVI_MODEL_IMPL_H
#define VVI_MODEL_IMPL_H
#include <pthread.h>
#include <volvis/model.h>

/** Changed paths, in the order of the edits. */
typedef struct vvi_paths {
    char **path;
    size_t n, room;
} vvi_paths;

/** What undo and redo need of a commit. */
typedef struct vvi_history_entry {
    char *who;
    vvi_paths paths;
    vv_object *before, *after; /**< Worlds: shared, so each costs what changed */
    size_t bytes;              /**< that much */
    bool undone;
} vvi_history_entry;

typedef struct vvi_watcher {
    vv_commit_fn *fn;
    void *user;
} vvi_watcher;

/** `edit` is held for a whole edit with its watchers, `swap` only while a pointer is read or changed. `edit` comes
 * first. */
struct vv_model {
    uint32_t refs; /**< atomic */
    vv_runtime *runtime;
    pthread_mutex_t edit; /**< guards all of the second group; knows its owner, so that a watcher's edit fails */
    pthread_mutex_t swap; /**< guards all of the third group */

    uint64_t n_commits;
    vvi_history_entry *history; /**< oldest first */
    size_t n_history, room_history;
    size_t history_bytes;  /**< of all entries */
    uint64_t history_most; /**< then the oldest go */
    uint64_t n_forgotten;
    vv_job *job; /**< in whose runtime they are counted */
    vv_runtime *counted_in;
    size_t counted;
    bool open; /**< a transaction is */
    char *open_who;
    vv_object *open_before;
    vvi_paths open_paths;
    vvi_watcher *watchers;
    size_t n_watchers;

    vv_object *world;
    char **units; /**< every unit that a context was given: contexts outlive Worlds */
    size_t n_units;
    vv_object *voxel_world; /**< whose first grid `voxel` belongs to, while its datasets are the World's */
    double voxel;
};

/** Takes the edit lock; an error inside a watcher. */
vv_status vvi_model_lock(vv_model *model);
void vvi_model_unlock(vv_model *model);
/** Makes `world` (taken) the current one. */
void vvi_model_swap(vv_model *model, vv_object *world);

/** Room for one more path, so that nothing can fail once it is there. */
vv_status vvi_paths_reserve(vvi_paths *paths);
/** Adds a path to reserved room; takes it. */
void vvi_paths_add(vvi_paths *paths, char *path);
void vvi_paths_clear(vvi_paths *paths);

/** A commit from `before` to the current World: into the history, and to the watchers. Takes the paths on success. */
vv_status vvi_history_commit(vv_model *model, const char *who, vvi_paths *paths, const vv_object *before);
void vvi_history_clear(vv_model *model);
/** How much it may keep: by the limits of the model's runtime. */
vv_status vvi_history_init(vv_model *model);
#endif
