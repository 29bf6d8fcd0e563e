/* Coordinates of a plain array, as xarray writes them: arrays of one axis in the same group, or in one around it, each
 * of the name of the axis that it is for. */
#include "core/memory.h"
#include "grid/field.h"
#include "io/cf_axes.h"
#include "io/formats/zarr/zarr.h"
#include <string.h>

/* "a/b/v" and "x" to "a/b/x", then "a/x", then "x". */
static bool path_beside(char out[VVI_ZARR_PATH], char group[VVI_ZARR_PATH], const char *axis)
{
    char *slash = strrchr(group, '/');
    if (!*group)
        return false;
    if (slash)
        *slash = 0;
    else
        *group = 0;
    return !strchr(axis, '/') && vvi_zarr_join(out, group, axis) == VV_OK;
}

/* Values of an array of one axis, yours to vvi_free(); NULL where they cannot be had, which is not said: coordinates
 * that cannot be read are none. */
static double *read_values(const vvi_zarr_array *array, const vv_field_info *info, const vvi_zarr_tree *tree,
                           const char *path)
{
    const size_t n = (size_t)array->shape[0];
    vvi_zarr_axes axes;
    vv_field *field = NULL;
    for (int r = 0; r < VVI_ROLES; r++)
        axes.role[r] = r == VVI_ROLE_X ? 0 : -1;
    if (vvi_zarr_read(&field, info, array, &axes, tree->folder, path, 0, NULL, tree->job) != VV_OK)
        return NULL;
    double *at = vvi_alloc(tree->job, n * sizeof *at, VVI_MEM_SCRATCH);
    for (size_t i = 0; at && i < n; i++)
        at[i] = vv_field_value(field, (int64_t)i, 0, 0, 0);
    vv_field_release(field);
    return at;
}

static vv_status take_array(vvi_cf_line *line, const vvi_zarr_node *node, int64_t n, char role,
                            const vvi_zarr_tree *tree, vv_notes *notes)
{
    vvi_zarr_array array;
    vv_field_info info = vv_field_info_default();
    if (vvi_zarr_array_of(&array, node, tree) != VV_OK || array.n_axes != 1 || array.shape[0] != n ||
        (uint64_t)n > VVI_CF_LINE_MOST)
        return VV_OK;
    info.type = array.type.type;
    info.grid.dims[0] = n;
    vv_notes *own = NULL; /* what is said of these numbers is none of the samples */
    vv_status st = vvi_notes_new(&own, tree->job);
    if (st == VV_OK)
        st = vvi_zarr_take_cf(&info, &array, node, own);
    vvi_notes_free(own);
    double *at = st == VV_OK ? read_values(&array, &info, tree, node->path) : NULL;
    if (!at)
        return st;
    vvi_cf_axis_unit(line->unit, vvi_json_text(node->attributes, "units"));
    st = vvi_cf_take_line(line, at, (size_t)n, info.type == VV_TYPE_F32 ? 1.2e-7 : 0, role, notes);
    vvi_free(at);
    return st;
}

static vv_status take_axis(vvi_cf_line *line, const vvi_zarr_array *a, int axis, char role, const vvi_zarr_tree *tree,
                           const char *path, vv_notes *notes)
{
    char group[VVI_ZARR_PATH], beside[VVI_ZARR_PATH];
    vv_status st = VV_OK;
    bool there = false;
    *line = (vvi_cf_line){.known = false};
    snprintf(group, sizeof group, "%s", path);
    while (st == VV_OK && !there && a->axis_name[axis][0] && path_beside(beside, group, a->axis_name[axis])) {
        vvi_zarr_node node = {0};
        if (strcmp(beside, path) != 0 && vvi_zarr_node_open(&node, tree, beside) == VV_OK &&
            node.kind == VVI_ZARR_ARRAY) {
            there = true;
            st = take_array(line, &node, a->shape[axis], role, tree, notes);
        }
        vvi_zarr_node_close(&node);
    }
    return st;
}

vv_status vvi_zarr_lines(vv_field_info *info, const vvi_zarr_array *a, const vvi_zarr_axes *axes,
                         const vvi_zarr_tree *tree, const char *path, vv_notes *notes)
{
    vvi_cf_line lines[3] = {{.known = false}, {.known = false}, {.known = false}}, time;
    vv_status st = VV_OK;
    for (int i = 0; i < 3 && st == VV_OK; i++)
        if (axes->role[VVI_ROLE_X + i] >= 0)
            st = take_axis(&lines[i], a, axes->role[VVI_ROLE_X + i], (char)('x' + i), tree, path, notes);
    if (st == VV_OK && axes->role[VVI_ROLE_FRAME] >= 0 &&
        (st = take_axis(&time, a, axes->role[VVI_ROLE_FRAME], 't', tree, path, notes)) == VV_OK)
        vvi_cf_place_frames(info, &time);
    return st == VV_OK ? vvi_cf_place(info, lines, notes) : st;
}
