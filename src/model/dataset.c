/* Fields that datasets have in memory: shared by every copy of the dataset. */
#include "model/dataset.h"
#include "core/memory.h"
#include "core/status.h"
#include <string.h>

static void release_fields(struct vv_dataset_fields *fields)
{
    if (!fields || __atomic_sub_fetch(&fields->refs, 1, __ATOMIC_ACQ_REL))
        return;
    for (size_t i = 0; i < fields->n; i++)
        vv_field_release(fields->field[i]);
    vv_mesh_release(fields->mesh);
    vvi_free(fields);
}

void vvi_dataset_copy_fields(vv_object *copy, const vv_object *from)
{
    struct vv_dataset_fields *fields = ((const vv_dataset *)from)->fields;
    if (fields)
        __atomic_add_fetch(&fields->refs, 1, __ATOMIC_RELAXED);
    ((vv_dataset *)copy)->fields = fields;
}

void vvi_dataset_drop_fields(vv_object *object)
{
    vv_dataset *dataset = (vv_dataset *)object;
    release_fields(dataset->fields);
    dataset->fields = NULL;
}

/* Room for n fields, in the place of what was attached. NULL, and the thread's error, without memory. */
static struct vv_dataset_fields *new_fields(vv_dataset *dataset, size_t n)
{
    const size_t bytes = sizeof(struct vv_dataset_fields) + n * sizeof(vv_field *);
    struct vv_dataset_fields *fields = vvi_alloc_zeroed(NULL, bytes, VVI_MEM_MODEL);
    if (!fields) {
        vv_fail_memory(bytes);
        return NULL;
    }
    fields->refs = 1;
    fields->n = n;
    release_fields(dataset->fields);
    dataset->fields = fields;
    return fields;
}

vv_status vvi_dataset_attach(vv_dataset *dataset, const vv_field *field)
{
    vv_field *kept = vv_field_retain(field); /* it may be the one that goes */
    struct vv_dataset_fields *fields = new_fields(dataset, 1);
    if (!fields) {
        vv_field_release(kept);
        return vv_error_last()->status;
    }
    fields->field[0] = kept;
    return VV_OK;
}

vv_status vvi_dataset_attach_mesh(vv_dataset *dataset, const vv_mesh *mesh)
{
    vv_mesh *kept = vv_mesh_retain(mesh);
    struct vv_dataset_fields *fields = new_fields(dataset, 0);
    if (!fields) {
        vv_mesh_release(kept);
        return vv_error_last()->status;
    }
    fields->mesh = kept;
    return VV_OK;
}

const vv_field *vvi_dataset_attached(const vv_dataset *dataset, const char *name)
{
    const struct vv_dataset_fields *fields = dataset->fields;
    for (size_t i = 0; fields && i < fields->n; i++) {
        if (!name || !strcmp(vv_field_get_info(fields->field[i])->name, name))
            return fields->field[i];
    }
    return NULL;
}
