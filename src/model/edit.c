/* Edits and transactions. */
#include "core/memory.h"
#include "core/property_impl.h"
#include "model/context.h"
#include "model/dataset.h"
#include "model/model_impl.h"
#include <string.h>

typedef enum edit_kind { EDIT_SET, EDIT_UNSET, EDIT_ADD, EDIT_REMOVE, EDIT_PUT, EDIT_REPLACE } edit_kind;

typedef struct edit {
    edit_kind kind;
    const char *path, *id, *json;
    vv_object *object;
} edit;

static vv_status apply(vv_object **world, const edit *e, const vv_property_context *context)
{
    switch (e->kind) {
    case EDIT_SET:
        return vv_path_set(world, e->path, e->json, context);
    case EDIT_UNSET:
        return vv_path_unset(world, e->path, context);
    case EDIT_ADD:
        return vv_path_add(world, e->path, e->id, e->json, context);
    case EDIT_REMOVE:
        return vv_path_remove(world, e->path, context);
    default:
        return vv_path_put(world, e->path, e->object, context);
    }
}

/* What changes: of lists the whole, since places move when entries come and go. */
static vv_status changed_path(char **out, const edit *e, const vv_object *world)
{
    vvi_trail trail;
    vv_status st = vvi_trail_find(&trail, world, e->path);
    if (st != VV_OK)
        return st;
    const vvi_hop *last = trail.n ? &trail.hop[trail.n - 1] : NULL;
    const size_t n = strlen(e->path);
    if (e->kind == EDIT_ADD && e->id)
        *out = vvi_asprintf("%s.%s", e->path, e->id);
    else if (last && last->entry && last->property->kind == VV_KIND_LIST)
        *out = vvi_asprintf("%.*s", (int)(strrchr(e->path, '.') - e->path), e->path);
    else
        *out = vvi_strdup(e->path);
    return *out ? VV_OK : vv_fail_memory(n + 1);
}

static vv_status check_turn(const vv_model *model, const char *who)
{
    if (model->open && strcmp(model->open_who, who) != 0)
        return vv_fail(VV_E_ARGUMENT, "a transaction of '%s' is open: nobody else can edit until it ends",
                       model->open_who);
    return VV_OK;
}

/* Adds the edit to the open transaction, or makes a commit of it. Takes path on success. */
static vv_status record(vv_model *model, const char *who, char *path, vv_object *world)
{
    vvi_paths alone = {0};
    vvi_paths *paths = model->open ? &model->open_paths : &alone;
    vv_status st = vvi_paths_reserve(paths);
    if (st != VV_OK)
        return st;
    vv_object *before = vv_object_retain(model->world);
    vvi_model_swap(model, vv_object_retain(world));
    vvi_paths_add(paths, path);
    if (!model->open && (st = vvi_history_commit(model, who, &alone, before)) != VV_OK) {
        vvi_model_swap(model, vv_object_retain(before));
        alone.n = 0; /* the caller has its path back */
        vvi_paths_clear(&alone);
    }
    vv_object_release(before);
    return st;
}

/* How large a voxel is is learned from a file, perhaps by another program: only where lengths are counted in voxels. */
static vv_property_context context_for(vv_model *model, const edit *e)
{
    if (e->json && strstr(e->json, "vox"))
        return vv_model_context(model);
    vv_property_context context = vvi_registry_context(model->runtime ? vv_runtime_registry(model->runtime) : NULL);
    context.length_unit = ((const vv_world *)(const void *)model->world)->unit;
    return context;
}

static vv_status edit_locked(vv_model *model, const char *who, const edit *e)
{
    char *path = NULL;
    vv_object *world = vv_object_retain(model->world);
    vv_status st = check_turn(model, who);
    if (st == VV_OK)
        st = changed_path(&path, e, world);
    if (st == VV_OK) {
        const vv_property_context context = context_for(model, e);
        st = apply(&world, e, &context);
    }
    if (st == VV_OK)
        st = record(model, who, path, world);
    if (st != VV_OK)
        free(path);
    vv_object_release(world);
    return st;
}

static vv_status edit_model(vv_model *model, const char *who, const edit *e)
{
    vv_status st = vvi_model_lock(model);
    if (st != VV_OK)
        return st;
    st = edit_locked(model, who ? who : "", e);
    vvi_model_unlock(model);
    return st;
}

vv_status vv_model_set(vv_model *model, const char *who, const char *path, const char *json)
{
    return edit_model(model, who, &(edit){.kind = EDIT_SET, .path = path, .json = json});
}

vv_status vv_model_unset(vv_model *model, const char *who, const char *path)
{
    return edit_model(model, who, &(edit){.kind = EDIT_UNSET, .path = path});
}

vv_status vv_model_add(vv_model *model, const char *who, const char *path, const char *id, const char *json)
{
    return edit_model(model, who, &(edit){.kind = EDIT_ADD, .path = path, .id = id, .json = json});
}

vv_status vv_model_remove(vv_model *model, const char *who, const char *path)
{
    return edit_model(model, who, &(edit){.kind = EDIT_REMOVE, .path = path});
}

vv_status vv_model_replace(vv_model *model, const char *who, vv_world *world)
{
    return edit_model(model, who, &(edit){.kind = EDIT_REPLACE, .path = "", .object = &world->base});
}

/* The dataset of that name, or a new one, with the field or the mesh attached. */
static vv_status make_attached(vv_object **out, const vv_model *model, const char *id, const vv_field *field,
                               const vv_mesh *mesh)
{
    const vv_object *old = vv_collection_find(((const vv_world *)model->world)->datasets, id);
    vv_status st = old ? vvi_object_copy(out, old) : vv_object_new(out, &vv_dataset_class, NULL);
    if (st == VV_OK && (st = mesh ? vvi_dataset_attach_mesh((vv_dataset *)*out, mesh)
                                  : vvi_dataset_attach((vv_dataset *)*out, field)) != VV_OK) {
        vv_object_release(*out);
        *out = NULL;
    }
    return st;
}

static vv_status attach_locked(vv_model *model, const char *who, const char *id, const vv_field *field,
                               const vv_mesh *mesh)
{
    vv_object *dataset = NULL;
    if (!vvi_id_valid(id))
        return vv_fail_at(VV_E_ARGUMENT, NULL, "datasets", "'%.80s' is not a valid name for a dataset", id);
    vv_status st = make_attached(&dataset, model, id, field, mesh);
    if (st != VV_OK)
        return st;
    char *path = vvi_asprintf("datasets.%s", id);
    st = path ? edit_locked(model, who, &(edit){.kind = EDIT_PUT, .path = path, .object = dataset})
              : vv_fail_memory(strlen(id) + 10);
    free(path);
    vv_object_release(dataset);
    return st;
}

static vv_status attach(vv_model *model, const char *who, const char *id, const vv_field *field, const vv_mesh *mesh)
{
    vv_status st = vvi_model_lock(model);
    if (st != VV_OK)
        return st;
    st = attach_locked(model, who ? who : "", id, field, mesh);
    vvi_model_unlock(model);
    return st;
}

vv_status vv_model_attach(vv_model *model, const char *who, const char *id, const vv_field *field)
{
    return attach(model, who, id, field, NULL);
}

vv_status vv_model_attach_mesh(vv_model *model, const char *who, const char *id, const vv_mesh *mesh)
{
    return attach(model, who, id, NULL, mesh);
}

/* Transactions -------------------------------------------------------------------------------------------------- */

static vv_status begin_locked(vv_model *model, const char *who)
{
    if (model->open)
        return vv_fail(VV_E_ARGUMENT, "a transaction of '%s' is open: end it first", model->open_who);
    if (!(model->open_who = vvi_strdup(who)))
        return vv_fail_memory(strlen(who) + 1);
    model->open_before = vv_object_retain(model->world);
    model->open = true;
    return VV_OK;
}

vv_status vv_model_begin(vv_model *model, const char *who)
{
    vv_status st = vvi_model_lock(model);
    if (st != VV_OK)
        return st;
    st = begin_locked(model, who ? who : "");
    vvi_model_unlock(model);
    return st;
}

static vv_status end_locked(vv_model *model, bool keep)
{
    vv_status st = VV_OK;
    if (!model->open)
        return vv_fail(VV_E_ARGUMENT, "there is no transaction to end");
    if (keep && model->open_paths.n) {
        model->open = false; /* watchers see a closed one */
        st = vvi_history_commit(model, model->open_who, &model->open_paths, model->open_before);
        if (st != VV_OK) {
            model->open = true;
            return st;
        }
    } else if (!keep) {
        vvi_model_swap(model, vv_object_retain(model->open_before));
    }
    model->open = false;
    vvi_paths_clear(&model->open_paths);
    free(model->open_who);
    model->open_who = NULL;
    vv_object_release(model->open_before);
    model->open_before = NULL;
    return VV_OK;
}

vv_status vv_model_end(vv_model *model, bool keep)
{
    vv_status st = vvi_model_lock(model);
    if (st != VV_OK)
        return st;
    st = end_locked(model, keep);
    vvi_model_unlock(model);
    return st;
}
