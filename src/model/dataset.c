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

vv_status vvi_dataset_attach(vv_dataset *dataset, const vv_field *field)
{
    const size_t bytes = sizeof(struct vv_dataset_fields) + sizeof(vv_field *);
    struct vv_dataset_fields *fields = vvi_alloc_zeroed(NULL, bytes, VVI_MEM_MODEL);
    if (!fields)
        return vv_fail_memory(bytes);
    fields->refs = 1;
    fields->n = 1;
    fields->field[0] = vv_field_retain(field);
    release_fields(dataset->fields);
    dataset->fields = fields;
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
