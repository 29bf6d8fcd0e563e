/* Which axis of an HDF5 data set is which, and where its samples are. HDF5 itself does not say; programs leave
 * attributes, of which these are known, the first that says all wins:
 *   axistags (vigra, ilastik), axes, DIMENSION_LABELS, dimension scales (netCDF-4), MATLAB_class, CLASS = IMAGE, else a
 *   rule of shapes (docs/formats.md)
 *   directions with origin (ours), element_size_um, element_size, spacing, resolution, voxel_size,
 * pixel_size Numbers of spacing are in the order of the data set's axes: z, y, x. */
#include "core/json_text.h"
#include "core/text.h"
#include "core/units.h"
#include "io/cf_axes.h"
#include "io/formats/hdf5/hdf5.h"
#include "io/placement.h"
#include "io/scan.h"
#include <ctype.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Roles ----------------------------------------------------------------------------------------------------------- */

/* Each role once, all known, and two at least in the plane. */
static bool roles_are_whole(const char *roles, int rank)
{
    if ((int)strlen(roles) != rank || strspn(roles, "tczyx") != (size_t)rank)
        return false;
    for (const char *r = roles; *r; r++)
        if (strchr(r + 1, *r))
            return false;
    return strchr(roles, 'x') != NULL;
}

static vv_status roles_of_tags(char *roles, hid_t data)
{
    char text[4096];
    vvi_json_flaw flaw;
    if (!vvi_h5_text(text, sizeof text, data, "axistags"))
        return VV_OK;
    json_t *tags = vvi_json_decode(text, strlen(text), 0, &flaw);
    if (!tags && flaw.fault == VVI_JSON_MEMORY)
        return vv_fail_memory(strlen(text));
    json_t *axes = json_object_get(tags, "axes");
    for (size_t i = 0; i < json_array_size(axes) && i < VVI_H5_RANK; i++) {
        const char *key = json_string_value(json_object_get(json_array_get(axes, i), "key"));
        roles[i] = key ? vvi_cf_role_named(key) : 0;
        roles[i + 1] = 0;
    }
    json_decref(tags);
    return VV_OK;
}

/* "tzyxc", "t,z,y,x,c", "time,lat,lon", any case. */
static void roles_of_names(char *roles, hid_t data, const char *attribute)
{
    char text[VVI_H5_TEXT], *rest = text, *word;
    int n = 0;
    if (!vvi_h5_text(text, sizeof text, data, attribute))
        return;
    for (char *c = text; *c; c++)
        *c = (char)tolower((unsigned char)*c);
    if (strlen(text) <= VVI_H5_RANK && strspn(text, "tczyx") == strlen(text)) {
        snprintf(roles, VVI_H5_RANK + 1, "%s", text);
        return;
    }
    while ((word = strsep(&rest, ", ;")) != NULL && n < VVI_H5_RANK)
        if (word[0])
            roles[n++] = vvi_cf_role_named(word);
    roles[n] = 0;
}

/* MATLAB keeps its arrays (row, column, slice) turned round: slice, column, row. */
static void roles_of_matlab(char *roles, int rank, hid_t data)
{
    static const char *const orders[] = {"xy", "zxy", "tzxy"};
    char text[64];
    if (rank <= 4 && vvi_h5_text(text, sizeof text, data, "MATLAB_class"))
        snprintf(roles, VVI_H5_RANK + 1, "%s", orders[rank - 2]);
}

static void roles_of_image(char *roles, const vvi_h5_set *set, hid_t data)
{
    char text[64];
    if (set->rank != 3 || !vvi_h5_text(text, sizeof text, data, "CLASS") || strcmp(text, "IMAGE") != 0)
        return;
    vvi_h5_text(text, sizeof text, data, "INTERLACE_MODE");
    const bool planes = strcmp(text, "INTERLACE_PLANE") == 0;
    if (set->dims[planes ? 0 : 2] <= 4)
        snprintf(roles, VVI_H5_RANK + 1, "%s", planes ? "cyx" : "yxc");
}

static const char *roles_of_shape(const vvi_h5_set *set)
{
    const hsize_t last = set->dims[set->rank - 1];
    const bool colour = set->type == VV_TYPE_U8 && !set->truth && (last == 3 || last == 4);
    bool few = last <= 4;
    for (int a = 0; a + 1 < set->rank; a++)
        few = few && (set->dims[a] > 4 || set->dims[a] == 1);
    switch (set->rank) {
    case 2:
        return "yx";
    case 3:
        return colour ? "yxc" : "zyx";
    case 4:
        return colour || few || last == 1 ? "zyxc" : "tzyx";
    default:
        return last <= 4 || set->dims[1] > 16 ? "tzyxc" : "tczyx";
    }
}

static vv_status choose_roles(vvi_h5_plan *plan, const vvi_netcdf *axes, hid_t data, vv_notes *notes)
{
    static const char *const attributes[] = {"axes", "DIMENSION_LABELS", "dimension_labels"};
    const int rank = plan->set.rank;
    char roles[VVI_H5_RANK + 1] = "";
    bool said = false;
    if (roles_of_tags(roles, data) != VV_OK)
        return vv_error_last()->status;
    for (int i = 0; i < 3 && !roles_are_whole(roles, rank); i++) {
        said = said || roles[0];
        roles[0] = 0;
        roles_of_names(roles, data, attributes[i]);
    }
    if (!roles_are_whole(roles, rank) && axes->roles[0])
        memcpy(roles, axes->roles, sizeof roles);
    if (!roles_are_whole(roles, rank)) {
        said = said || roles[0];
        roles[0] = 0;
        roles_of_matlab(roles, rank, data);
    }
    if (!roles[0])
        roles_of_image(roles, &plan->set, data);
    const bool guessed = !roles_are_whole(roles, rank);
    if (guessed)
        snprintf(roles, sizeof roles, "%s", roles_of_shape(&plan->set));
    memcpy(plan->roles, roles, sizeof roles);
    if (guessed && said)
        return vvi_notes_warn(notes, "its axes have names that are not understood; they are taken as %s", roles);
    return guessed && rank > 3 ? vvi_notes_warn(notes, "its axes have no names; they are taken as %s", roles) : VV_OK;
}

/* Placement ------------------------------------------------------------------------------------------------------- */

/* Numbers for the axes of space, in the order of the data set, to x, y, z. A number for every axis will do as well. */
static bool take_axes(double out[3], const vvi_h5_plan *plan, const double *value, int n)
{
    int n_space = 0, at = 0;
    for (const char *r = plan->roles; *r; r++)
        n_space += *r != 't' && *r != 'c';
    if (n == 1 && n_space > 0) {
        out[0] = out[1] = out[2] = value[0];
        return true;
    }
    const bool all = n == plan->set.rank;
    if (!all && n < n_space)
        return false;
    if (!all)
        at = n - n_space; /* (z, y, x) of a flat set */
    for (const char *r = plan->roles; *r; r++) {
        const bool space = *r != 't' && *r != 'c';
        if (space)
            out[*r - 'x'] = value[at];
        at += space || all;
    }
    return true;
}

/* Of the data set, of the groups that it is in, of the file. */
static int numbers_around(double *out, int most, const vvi_h5 *h5, const vvi_h5_plan *plan, const char *name)
{
    char path[VVI_H5_PATH];
    snprintf(path, sizeof path, "%s", plan->set.path);
    for (;;) {
        const hid_t object = vvi_h5_object(h5, path);
        const int n = object >= 0 ? vvi_h5_numbers(out, most, object, name) : 0;
        if (object >= 0)
            H5Oclose(object);
        char *slash = strrchr(path, '/');
        if (n > 0 || !slash)
            return n;
        *slash = 0;
    }
}

static void set_diagonal(vv_affine *a, const double step[3])
{
    a->axis[0] = (vv_vec3){step[0], 0, 0};
    a->axis[1] = (vv_vec3){0, step[1], 0};
    a->axis[2] = (vv_vec3){0, 0, step[2]};
}

static void place_by_spacing(vv_field_info *info, vvi_h5 *h5, const vvi_h5_plan *plan)
{
    static const char *const names[] = {"element_size_um", "element_size", "spacing",
                                        "resolution",      "voxel_size",   "pixel_size"};
    double value[VVI_H5_RANK], step[3] = {1, 1, 1}, origin[3] = {0, 0, 0};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const int n = numbers_around(value, VVI_H5_RANK, h5, plan, names[i]);
        if (n == 0 || !take_axes(step, plan, value, n))
            continue;
        snprintf(info->grid.unit, sizeof info->grid.unit, "%s", i == 0 ? "um" : "units");
        set_diagonal(&info->grid.index_to_world, step);
        break;
    }
    int n = numbers_around(value, VVI_H5_RANK, h5, plan, "offset");
    if (n == 0)
        n = numbers_around(value, VVI_H5_RANK, h5, plan, "origin");
    if (n > 1 && take_axes(origin, plan, value, n))
        info->grid.index_to_world.origin = (vv_vec3){origin[0], origin[1], origin[2]};
}

/* Ours: steps of x, y, z as rows of world x, y, z. */
static bool place_by_directions(vv_field_info *info, hid_t data)
{
    double d[9], origin[3] = {0, 0, 0};
    if (vvi_h5_numbers(d, 9, data, "directions") != 9)
        return false;
    vvi_h5_numbers(origin, 3, data, "origin");
    info->grid.index_to_world =
        (vv_affine){{{d[0], d[1], d[2]}, {d[3], d[4], d[5]}, {d[6], d[7], d[8]}}, {origin[0], origin[1], origin[2]}};
    snprintf(info->grid.unit, sizeof info->grid.unit, "units");
    return true;
}

static vv_status check_placement(vv_field_info *info, const vvi_h5 *h5, const char *path)
{
    const vv_affine *a = &info->grid.index_to_world;
    bool good = vvi_affine_finite(a);
    for (int i = 0; i < 3; i++)
        good = good && vvi_length(a->axis[i]) > 0;
    return good ? VV_OK
                : vv_fail_at(VV_E_FORMAT, h5->name, path, "its spacing or origin is not a finite number or is 0");
}

/* The unit of lengths, if an attribute has one that is a length or no unit of spacing is known otherwise. */
static void take_units(vv_field_info *info, hid_t data)
{
    char text[64], unit[16];
    const bool placed = strcmp(info->grid.unit, "voxels") != 0;
    if (vvi_h5_text(text, sizeof text, data, "unit") || vvi_h5_text(text, sizeof text, data, "units")) {
        vvi_unit_name(unit, text, strlen(text));
        if (placed && strcmp(info->grid.unit, "um") != 0 &&
            (vvi_length_unit_metres(unit) > 0 || strcmp(unit, "voxels") == 0))
            memcpy(info->grid.unit, unit, sizeof unit);
        else if (strcmp(unit, info->grid.unit) != 0)
            memcpy(info->value_unit, unit, sizeof unit);
    }
}

/* What we write besides: see hdf5_write.c. */
static void take_ours(vv_field_info *info, hid_t data)
{
    char text[64];
    double value[2];
    if (vvi_h5_text(text, sizeof text, data, "unit"))
        vvi_unit_name(info->grid.unit, text, strlen(text));
    if (vvi_h5_text(text, sizeof text, data, "space") && strcmp(text, "RAS") == 0)
        info->grid.space = VV_SPACE_RAS;
    if (vvi_h5_text(text, sizeof text, data, "value_unit"))
        snprintf(info->value_unit, sizeof info->value_unit, "%.15s", text);
    if (vvi_h5_text(text, sizeof text, data, "name"))
        snprintf(info->name, sizeof info->name, "%.63s", text);
    if (vvi_h5_numbers(value, 2, data, "frame_step") == 1 && isfinite(value[0]))
        info->frame_step = value[0];
    if (vvi_h5_text(text, sizeof text, data, "frame_unit"))
        snprintf(info->frame_unit, sizeof info->frame_unit, "%.15s", text);
    static const char *const meanings[] = {"scalar", "rgb", "rgba", "vector", "label"};
    if (vvi_h5_text(text, sizeof text, data, "meaning"))
        for (int m = 0; m < 5; m++)
            if (strcmp(text, meanings[m]) == 0)
                info->meaning = (vv_meaning)m;
}

static void take_meaning(vv_field_info *info, const vvi_h5_set *set)
{
    if (set->type == VV_TYPE_U8 && !set->truth && info->components == 3)
        info->meaning = VV_MEANING_RGB;
    if (set->type == VV_TYPE_U8 && !set->truth && info->components == 4)
        info->meaning = VV_MEANING_RGBA;
    if (set->names && info->components == 1)
        info->meaning = VV_MEANING_LABEL;
}

/* A meaning that does not fit the components is none. */
static void check_meaning(vv_field_info *info)
{
    const int n = info->components;
    const bool fits = info->meaning == VV_MEANING_RGB      ? n == 3
                      : info->meaning == VV_MEANING_RGBA   ? n == 4
                      : info->meaning == VV_MEANING_VECTOR ? n >= 2
                      : info->meaning == VV_MEANING_LABEL  ? n == 1 && !vv_type_is_float(info->type)
                                                           : true;
    if (!fits)
        info->meaning = VV_MEANING_SCALAR;
}

vv_status vvi_h5_axes(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, hid_t data, vv_notes *notes)
{
    vvi_netcdf axes;
    vvi_netcdf_find(&axes, h5, &plan->set, data);
    vv_status st = choose_roles(plan, &axes, data, notes);
    for (int a = 0; a < plan->set.rank; a++)
        plan->dims[a] = (int64_t)plan->set.dims[a];
    if (st == VV_OK)
        st = vvi_netcdf_take_gaps(plan, data, notes);
    if (st != VV_OK || (st = vvi_h5_lay_out(info, plan, h5->name)) != VV_OK)
        return st;
    const char *last = strrchr(plan->set.path, '/');
    snprintf(info->name, sizeof info->name, "%.63s", last ? last + 1 : plan->set.path);
    take_meaning(info, &plan->set);
    if (plan->gaps.scale == 0) /* else they are unpacked as they are read */
        vvi_netcdf_packing(&info->value_scale, &info->value_offset, data);
    if (place_by_directions(info, data)) {
        take_ours(info, data);
    } else if (axes.roles[0]) {
        st = vvi_netcdf_place(info, plan, &axes, h5, data, notes);
    } else {
        place_by_spacing(info, h5, plan);
        take_units(info, data);
    }
    check_meaning(info);
    return st == VV_OK ? check_placement(info, h5, plan->set.path) : st;
}
