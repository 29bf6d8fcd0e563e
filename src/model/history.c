/* Commits, and how they are taken back and done again: path by path from the Worlds before and after. */
#include "model/history.h"
#include "core/job.h"
#include "core/limits.h"
#include "core/memory.h"
#include "core/property_size.h"
#include "model/model_impl.h"
#include <stdlib.h>
#include <string.h>

vv_status vvi_paths_reserve(vvi_paths *paths)
{
    if (paths->n < paths->room)
        return VV_OK;
    const size_t room = paths->room ? 2 * paths->room : 4;
    char **path = vvi_realloc(NULL, paths->path, room * sizeof *path, VVI_MEM_MODEL);
    if (!path)
        return vv_fail_memory(room * sizeof *path);
    paths->path = path;
    paths->room = room;
    return VV_OK;
}

void vvi_paths_add(vvi_paths *paths, char *path)
{
    vvi_check(paths->n < paths->room);
    paths->path[paths->n++] = path;
}

void vvi_paths_clear(vvi_paths *paths)
{
    for (size_t i = 0; i < paths->n; i++)
        free(paths->path[i]);
    vvi_free(paths->path);
    *paths = (vvi_paths){0};
}

static void clear_entry(vvi_history_entry *entry)
{
    free(entry->who);
    vvi_paths_clear(&entry->paths);
    vv_object_release(entry->before);
    vv_object_release(entry->after);
    *entry = (vvi_history_entry){0};
}

static void remove_entries(vv_model *model, size_t at, size_t n)
{
    if (n == 0)
        return;
    for (size_t i = at; i < at + n; i++) {
        model->history_bytes -= model->history[i].bytes;
        clear_entry(&model->history[i]);
    }
    memmove(&model->history[at], &model->history[at + n], (model->n_history - at - n) * sizeof *model->history);
    memset(&model->history[model->n_history - n], 0, n * sizeof *model->history);
    model->n_history -= n;
}

/* Room ---------------------------------------------------------------------------------------------------------- */

/* What an entry keeps of Worlds, which nothing else does once they are of the past. */
static void measure(vv_model *model, vvi_history_entry *entry)
{
    model->history_bytes -= entry->bytes;
    entry->bytes = sizeof *entry + vvi_object_apart(entry->before, entry->after);
    entry->bytes += vvi_object_apart(entry->after, entry->before);
    for (size_t i = 0; i < entry->paths.n; i++)
        entry->bytes += sizeof(char *) + 2 * strlen(entry->paths.path[i]); /* small texts cost more than they have */
    model->history_bytes += entry->bytes;
}

/* So many at least that no more than `most` remain, but never the newest. */
static size_t count_oldest(const vv_model *model, uint64_t most)
{
    uint64_t left = model->history_bytes;
    size_t n = 0;
    while (left > most && n + 1 < model->n_history)
        left -= model->history[n++].bytes;
    return n;
}

static void forget_oldest(vv_model *model, uint64_t most)
{
    const size_t n = count_oldest(model, most);
    remove_entries(model, 0, n);
    model->n_forgotten += n;
}

/* The oldest steps go where there are too many, or where the runtime has no more memory for them. Some more than must:
 * the rest are moved. */
static void settle(vv_model *model)
{
    const uint64_t most = model->history_most;
    if (model->history_bytes > most)
        forget_oldest(model, most - most / 8);
    vvi_memory_give_back(model->counted_in, model->counted, VVI_MEM_MODEL);
    model->counted_in = NULL;
    model->counted = model->history_bytes;
    while (vvi_memory_take(&model->counted_in, model->job, model->counted, VVI_MEM_MODEL) != VV_OK) {
        const size_t before = model->n_history;
        forget_oldest(model, model->history_bytes / 2);
        model->counted = model->n_history < before ? model->history_bytes : 0;
    }
}

vv_status vvi_history_init(vv_model *model)
{
    const vv_status st = vv_job_new(&model->job, model->runtime, NULL, NULL);
    if (st != VV_OK)
        return st;
    const uint64_t share = model->runtime ? vv_runtime_memory_limit(model->runtime) / 8 : UINT64_MAX;
    const uint64_t most = vvi_job_limits(model->job)->undo_bytes;
    model->history_most = most < share ? most : share;
    return VV_OK;
}

uint64_t vvi_model_forgotten(vv_model *model, uint64_t *bytes_out)
{
    *bytes_out = model->history_most;
    return model->n_forgotten;
}

void vvi_model_each_world(const vv_model *model, bool (*see)(void *user, const vv_object *world), void *user)
{
    if (!see(user, model->world))
        return;
    for (size_t i = 0; i < model->n_history; i++) {
        const vvi_history_entry *e = &model->history[i];
        if (!see(user, e->before) || !see(user, e->after))
            return;
    }
}

void vvi_history_clear(vv_model *model)
{
    remove_entries(model, 0, model->n_history);
    vvi_memory_give_back(model->counted_in, model->counted, VVI_MEM_MODEL);
    model->counted_in = NULL;
    model->counted = 0;
}

/* Commits ------------------------------------------------------------------------------------------------------- */

static void tell_watchers(vv_model *model, const char *who, const vvi_paths *paths)
{
    const vv_commit commit = {
        .number = ++model->n_commits,
        .who = who,
        .paths = (const char *const *)paths->path,
        .n_paths = paths->n,
    };
    vv_world *world = vv_model_snapshot(model);
    for (size_t i = 0; i < model->n_watchers; i++)
        model->watchers[i].fn(model->watchers[i].user, &commit, world);
    vv_object_release(&world->base);
}

static bool is_by(const vvi_history_entry *entry, const char *who)
{
    return !strcmp(entry->who, who);
}

/* Whoever commits anew can no longer do again what he took back. */
static void forget_undone(vv_model *model, const char *who)
{
    for (size_t i = model->n_history; i-- > 0;) {
        if (model->history[i].undone && is_by(&model->history[i], who))
            remove_entries(model, i, 1);
    }
}

static vv_status reserve_entry(vv_model *model)
{
    if (model->n_history < model->room_history)
        return VV_OK;
    const size_t room = model->room_history ? 2 * model->room_history : 64;
    vvi_history_entry *more = vvi_realloc(NULL, model->history, room * sizeof *more, VVI_MEM_MODEL);
    if (!more)
        return vv_fail_memory(room * sizeof *more);
    model->history = more;
    model->room_history = room;
    return VV_OK;
}

vv_status vvi_history_commit(vv_model *model, const char *who, vvi_paths *paths, const vv_object *before)
{
    vv_status st = reserve_entry(model);
    if (st != VV_OK)
        return st;
    char *name = vvi_strdup(who);
    if (!name)
        return vv_fail_memory(strlen(who) + 1);
    forget_undone(model, name);
    vvi_history_entry *entry = &model->history[model->n_history++];
    *entry = (vvi_history_entry){
        .who = name,
        .paths = *paths,
        .before = vv_object_retain(before),
        .after = vv_object_retain(model->world),
    };
    *paths = (vvi_paths){0};
    measure(model, entry);
    tell_watchers(model, name, &entry->paths);
    settle(model);
    return VV_OK;
}

static bool has_path(const vvi_paths *paths, const char *path)
{
    for (size_t i = 0; i < paths->n; i++)
        if (!strcmp(paths->path[i], path))
            return true;
    return false;
}

/* What was committed later, by another then, at the same path and still holds; NULL: nothing. */
static vvi_history_entry *find_over(vv_model *model, const vvi_history_entry *entry, const char *path)
{
    for (vvi_history_entry *later = &model->history[entry - model->history + 1];
         later < model->history + model->n_history; later++)
        if (!later->undone && has_path(&later->paths, path))
            return later;
    return NULL;
}

/* The current World with an entry's paths as they are in `source`: forwards, or backwards to take them back. What
 * another has set since stays as it is; he comes back to `source` when he takes that back. */
static vv_status copy_paths(vv_object **out, vv_model *model, const vvi_history_entry *entry, bool backwards)
{
    const vv_property_context context = vv_model_context(model);
    const vv_object *source = backwards ? entry->before : entry->after;
    const size_t n = entry->paths.n;
    vv_object *world = vv_object_retain(model->world);
    vv_status st = VV_OK;
    for (size_t i = 0; st == VV_OK && i < n; i++) {
        const char *path = entry->paths.path[backwards ? n - 1 - i : i];
        vvi_history_entry *over = find_over(model, entry, path);
        st = vv_path_copy(over ? &over->before : &world, source, path, &context);
        if (over)
            measure(model, over);
    }
    if (st != VV_OK) {
        vv_object_release(world);
        return st;
    }
    *out = world;
    return VV_OK;
}

static vv_status apply(vv_model *model, vvi_history_entry *entry, bool undo)
{
    vv_object *world = NULL;
    const vv_status st = copy_paths(&world, model, entry, undo);
    if (st != VV_OK)
        return vv_fail_in(st, undo ? "cannot undo" : "cannot redo");
    vvi_model_swap(model, world);
    entry->undone = undo;
    tell_watchers(model, entry->who, &entry->paths);
    return VV_OK;
}

/* The last commit before `from` that can be taken back, or the first behind it that was; NULL `from`: of all. */
static vvi_history_entry *find_entry(vv_model *model, const char *who, bool undo, const vvi_history_entry *from)
{
    size_t i = !from  ? 0
               : undo ? (size_t)(model->history + model->n_history - from)
                      : (size_t)(from - model->history) + 1;
    for (; i < model->n_history; i++) {
        vvi_history_entry *entry = &model->history[undo ? model->n_history - 1 - i : i];
        if (entry->undone != undo && is_by(entry, who))
            return entry;
    }
    return NULL;
}

/* A commit on what another has removed since is passed by: it waits until that is there again. */
static vv_status apply_next(vv_model *model, const char *who, bool undo)
{
    vvi_history_entry *entry = find_entry(model, who, undo, NULL);
    vvi_error_copy error = {0};
    if (!entry)
        return vv_fail(VV_E_NOT_FOUND, undo ? "there is nothing to undo" : "there is nothing to redo");
    vv_status st = apply(model, entry, undo);
    if (st == VV_OK)
        return VV_OK;
    vvi_error_take(&error);
    while (st != VV_OK && st != VV_E_MEMORY && (entry = find_entry(model, who, undo, entry)) != NULL)
        st = apply(model, entry, undo);
    if (st != VV_OK)
        return vvi_error_put(&error);
    vvi_error_copy_free(&error);
    return VV_OK;
}

static vv_status step(vv_model *model, const char *who, bool undo)
{
    vv_status st = vvi_model_lock(model);
    if (st != VV_OK)
        return st;
    if (model->open)
        st = vv_fail(VV_E_ARGUMENT, "a transaction of '%s' is open: end it first", model->open_who);
    else
        st = apply_next(model, who ? who : "", undo);
    settle(model);
    vvi_model_unlock(model);
    return st;
}

static vv_status move_paths(vvi_paths *to, vvi_paths *from)
{
    while (from->n > 0) {
        const vv_status st = vvi_paths_reserve(to);
        if (st != VV_OK)
            return st;
        vvi_paths_add(to, from->path[--from->n]);
    }
    return VV_OK;
}

static void drop_known(vvi_paths *paths, const vvi_paths *known)
{
    size_t n = 0;
    for (size_t i = 0; i < paths->n; i++) {
        if (has_path(known, paths->path[i]))
            free(paths->path[i]);
        else
            paths->path[n++] = paths->path[i];
    }
    paths->n = n;
}

/* The last two commits of `who` that are not taken back; -1 where there are none. */
static void last_two(ptrdiff_t out[2], const vv_model *model, const char *who)
{
    out[0] = out[1] = -1;
    for (size_t i = model->n_history; i-- > 0 && out[1] < 0;)
        if (!model->history[i].undone && is_by(&model->history[i], who))
            out[out[0] < 0 ? 0 : 1] = (ptrdiff_t)i;
}

vv_status vv_model_join(vv_model *model, const char *who)
{
    ptrdiff_t at[2];
    vv_status st = vvi_model_lock(model);
    if (st != VV_OK)
        return st;
    last_two(at, model, who ? who : "");
    if (at[1] >= 0) {
        vvi_history_entry *newer = &model->history[at[0]], *older = &model->history[at[1]];
        drop_known(&newer->paths, &older->paths);
        if ((st = move_paths(&older->paths, &newer->paths)) == VV_OK) {
            vv_object_release(older->after);
            older->after = vv_object_retain(newer->after);
            remove_entries(model, (size_t)at[0], 1);
            measure(model, older);
            settle(model);
        }
    }
    vvi_model_unlock(model);
    return st;
}

void vv_model_can(bool *undo_out, bool *redo_out, vv_model *model, const char *who)
{
    *undo_out = *redo_out = false;
    if (vvi_model_lock(model) != VV_OK)
        return;
    *undo_out = find_entry(model, who ? who : "", true, NULL) != NULL;
    *redo_out = find_entry(model, who ? who : "", false, NULL) != NULL;
    vvi_model_unlock(model);
}

vv_status vv_model_undo(vv_model *model, const char *who)
{
    return step(model, who, true);
}

vv_status vv_model_redo(vv_model *model, const char *who)
{
    return step(model, who, false);
}
