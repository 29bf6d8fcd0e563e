/* Which axis of an array is which of a field, and where its samples lie. */
#include "core/units.h"
#include "io/cf_axes.h"
#include "io/formats/zarr/zarr.h"
#include "io/placement.h"
#include "io/scan.h"
#include <math.h>
#include <string.h>

/* By position where no names say it: as Python programs index volumes, and as OME-Zarr does with five axes. */
static const char *default_roles(const vvi_zarr_array *a)
{
    const int64_t last = a->shape[a->n_axes - 1];
    const bool colour = a->type.type == VV_TYPE_U8 && (last == 3 || last == 4);
    switch (a->n_axes) {
    case 1:
        return "x";
    case 2:
        return "yx";
    case 3:
        return colour ? "yxc" : "zyx";
    case 4:
        return colour ? "zyxc" : "tzyx";
    default:
        return "tczyx";
    }
}

static int role_of_letter(char letter)
{
    static const char letters[] = "cxyzt"; /* as vvi_role counts */
    const char *at = letter ? strchr(letters, letter) : NULL;
    return at ? (int)(at - letters) : -1;
}

/* Names as arrays carry them: all of them must be known and different. */
static bool roles_by_name(int *role, const vvi_zarr_array *a)
{
    unsigned taken = 0;
    for (int i = 0; i < a->n_axes; i++) {
        role[i] = role_of_letter(vvi_cf_role_named(a->axis_name[i]));
        if (role[i] < 0 || taken >> role[i] & 1)
            return false;
        taken |= 1u << role[i];
    }
    return true;
}

static void roles_by_position(int *role, const vvi_zarr_array *a)
{
    const char *letters = default_roles(a);
    const int n = (int)strlen(letters), extra = a->n_axes - n;
    for (int i = 0; i < a->n_axes; i++)
        role[i] = i < extra ? -1 : role_of_letter(letters[i - extra]);
}

static vv_status use_roles(vv_field_info *info, vvi_zarr_axes *axes, const vvi_zarr_array *a, const int *role,
                           const char *name)
{
    for (int r = 0; r < VVI_ROLES; r++)
        axes->role[r] = -1;
    for (int i = 0; i < a->n_axes; i++) {
        if (role[i] < 0 && a->shape[i] > 1)
            return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                              "axis %d of %d ('%s', %lld entries) is not x, y, z, channels or time", i + 1, a->n_axes,
                              a->axis_name[i], (long long)a->shape[i]);
        if (role[i] < 0)
            continue;
        axes->role[role[i]] = i;
        if (role[i] == VVI_ROLE_COMPONENT && a->shape[i] > 65536)
            return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has %lld channels; at most 65536 can be read",
                              (long long)a->shape[i]);
        if (role[i] == VVI_ROLE_COMPONENT)
            info->components = (int)a->shape[i];
        else if (role[i] == VVI_ROLE_FRAME)
            info->n_frames = a->shape[i];
        else
            info->grid.dims[role[i] - VVI_ROLE_X] = a->shape[i];
    }
    info->type = a->type.type;
    return VV_OK;
}

/* World ---------------------------------------------------------------------------------------------------------- */

/* The factor that brings an axis' unit to that of the world. */
static double in_unit(const char *unit, const char *world)
{
    const double from = vvi_length_unit_metres(unit), to = vvi_length_unit_metres(world);
    return from > 0 && to > 0 ? from / to : 1;
}

/* Anatomical axes in any order and direction to those of RAS. */
static bool to_ras(vv_affine *placement, const vvi_zarr_image *image, const int *axis_of)
{
    static const char *const towards[3] = {"RL", "AP", "SI"};
    double m[4][3] = {{0}};
    const vv_vec3 from[4] = {placement->axis[0], placement->axis[1], placement->axis[2], placement->origin};
    unsigned taken = 0;
    for (int a = 0; a < 3; a++) {
        const char to = axis_of[a] >= 0 ? image->axis[axis_of[a]].towards : 0;
        int world = -1;
        for (int w = 0; w < 3 && to; w++)
            if (strchr(towards[w], to))
                world = w;
        if (world < 0 || taken >> world & 1)
            return false;
        taken |= 1u << world;
        for (int k = 0; k < 4; k++) {
            const double v[3] = {from[k].x, from[k].y, from[k].z};
            m[k][world] = to == towards[world][0] ? v[a] : -v[a];
        }
    }
    for (int k = 0; k < 3; k++)
        placement->axis[k] = (vv_vec3){m[k][0], m[k][1], m[k][2]};
    placement->origin = (vv_vec3){m[3][0], m[3][1], m[3][2]};
    return true;
}

static void place_in_space(vv_field_info *info, const vvi_zarr_image *image, const int *axis_of,
                           const double map[VVI_ZARR_AXES][VVI_ZARR_AXES + 1])
{
    vv_affine p = info->grid.index_to_world;
    const char *unit = "";
    for (int a = 0; a < 3 && !*unit; a++)
        unit = axis_of[a] >= 0 ? image->axis[axis_of[a]].unit : "";
    for (int k = 0; k < 4; k++) {
        double v[3] = {k == 0, k == 1, k == 2};
        const int column = k < 3 ? axis_of[k] : VVI_ZARR_AXES;
        for (int w = 0; w < 3 && column >= 0; w++)
            v[w] = axis_of[w] >= 0 ? map[axis_of[w]][column] * in_unit(image->axis[axis_of[w]].unit, unit) : 0;
        *(k < 3 ? &p.axis[k] : &p.origin) = (vv_vec3){v[0], v[1], v[2]};
    }
    if (axis_of[2] < 0)
        vvi_complete_axes(&p, axis_of[1] < 0 ? 1 : 2);
    info->grid.index_to_world = p;
    snprintf(info->grid.unit, sizeof info->grid.unit, "%s", *unit ? unit : "units");
    if (to_ras(&info->grid.index_to_world, image, axis_of))
        info->grid.space = VV_SPACE_RAS;
}

/* A length of 0 on an axis of one sample is no mistake that matters. */
static void mend_single(vv_field_info *info)
{
    vv_vec3 *axis = info->grid.index_to_world.axis;
    for (int a = 0; a < 3; a++)
        if (info->grid.dims[a] == 1 && vvi_length(axis[a]) == 0) {
            axis[a] = (vv_vec3){a == 0, a == 1, a == 2};
        }
}

static vv_status place_image(vv_field_info *info, const vvi_zarr_axes *axes, const vvi_zarr_image *image, int level,
                             vv_notes *notes)
{
    const int axis_of[3] = {axes->role[VVI_ROLE_X], axes->role[VVI_ROLE_Y], axes->role[VVI_ROLE_Z]};
    const int time = axes->role[VVI_ROLE_FRAME];
    const vv_affine index = info->grid.index_to_world;
    if (!image->level[level].placed)
        return VV_OK;
    place_in_space(info, image, axis_of, image->level[level].map);
    mend_single(info);
    const double step = time >= 0 ? image->level[level].map[time][time] : 0;
    if (step > 0 && (step != 1 || image->axis[time].unit[0])) { /* 1 without a unit: nothing is known */
        info->frame_step = step;
        memcpy(info->frame_unit, image->axis[time].unit, sizeof info->frame_unit);
    }
    if (vv_field_info_check(info) == VV_OK)
        return VV_OK;
    info->grid.index_to_world = index;
    snprintf(info->grid.unit, sizeof info->grid.unit, "voxels");
    info->grid.space = VV_SPACE_PLAIN;
    info->frame_step = 0;
    return vvi_notes_warn(notes, "its coordinate transformations give no volume; samples are placed at their index");
}

vv_status vvi_zarr_place(vv_field_info *info, vvi_zarr_axes *axes, const vvi_zarr_array *a, const vvi_zarr_image *image,
                         int level, vv_notes *notes, const char *name)
{
    int role[VVI_ZARR_AXES];
    if (image && image->n_axes > 0 && image->n_axes != a->n_axes)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its image has %d axes but the array '%.200s' has %d", image->n_axes,
                          image->level[level].path, a->n_axes);
    for (int i = 0; image && i < image->n_axes; i++)
        role[i] = image->axis[i].role;
    if (!image || image->n_axes == 0) {
        if (!roles_by_name(role, a))
            roles_by_position(role, a);
    }
    vv_status st = use_roles(info, axes, a, role, name);
    if (st != VV_OK)
        return st;
    if (!image && info->type == VV_TYPE_U8 && axes->role[VVI_ROLE_COMPONENT] == a->n_axes - 1 &&
        (info->components == 3 || info->components == 4))
        info->meaning = info->components == 3 ? VV_MEANING_RGB : VV_MEANING_RGBA;
    return image ? place_image(info, axes, image, level, notes) : VV_OK;
}
