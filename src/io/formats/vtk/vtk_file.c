/* What is kept of a file of VTK while it is parsed. */
#include "core/limits.h"
#include "core/memory.h"
#include "io/formats/vtk/vtk_xml.h"
#include <string.h>

vv_status vvi_vtk_copy_text(char **out, const char *text, vv_job *job)
{
    const size_t n = strlen(text ? text : "") + 1;
    vvi_free(*out);
    *out = vvi_alloc(job, n, VVI_MEM_MODEL);
    if (!*out)
        return vv_fail_memory(n);
    memcpy(*out, text ? text : "", n);
    return VV_OK;
}

vv_status vvi_vtk_grow(void *items, size_t n, size_t *room, size_t size, vv_job *job)
{
    void **array = items;
    if (n < *room)
        return VV_OK;
    const size_t more = *room ? *room * 2 : 16;
    void *bigger = vvi_realloc(job, *array, more * size, VVI_MEM_MODEL);
    if (!bigger)
        return vv_fail_memory(more * size);
    *array = bigger;
    *room = more;
    return VV_OK;
}

vv_status vvi_vtk_add_array(vvi_vtk_file *file, const vvi_vtk_array *array, const char *name, const char *type_name,
                            vv_job *job)
{
    if (file->n_arrays >= vvi_job_limits(job)->metadata_keys)
        return vv_fail_at(VV_E_LIMIT, file->name, NULL, "has more than %zu arrays; --limit metadata_keys=N allows more",
                          file->n_arrays);
    vv_status st = vvi_vtk_grow(&file->array, file->n_arrays, &file->array_room, sizeof *file->array, job);
    if (st != VV_OK)
        return st;
    vvi_vtk_array *kept = &file->array[file->n_arrays++];
    *kept = *array;
    kept->name = kept->type_name = NULL;
    if ((st = vvi_vtk_copy_text(&kept->name, name, job)) == VV_OK)
        st = vvi_vtk_copy_text(&kept->type_name, type_name, job);
    return st;
}

void vvi_vtk_finish(vvi_vtk_file *file)
{
    for (size_t i = 0; i < file->n_arrays; i++) {
        vvi_free(file->array[i].name);
        vvi_free(file->array[i].type_name);
    }
    vvi_free(file->array);
    vvi_free(file->piece);
}
