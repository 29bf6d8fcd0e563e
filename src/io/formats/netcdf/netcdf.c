/* Axes of netCDF-4: dimension scales are data sets of one axis with the coordinates along an axis of others. A scale
 * lists what it belongs to (REFERENCE_LIST); what data sets say themselves (DIMENSION_LIST) is of any length, which
 * HDF5 1.10 reads without looking. What scales mean is told by the CF conventions, https://cfconventions.org. */
#include "core/limits.h"
#include "core/memory.h"
#include "io/cf_axes.h"
#include "io/formats/hdf5/hdf5.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define REFERENCES_MOST 65536

/* Scales ---------------------------------------------------------------------------------------------------------- */

typedef struct reference {
    hobj_ref_t set;
    int axis;
} reference;

static hid_t reference_type(void)
{
    const hid_t type = H5Tcreate(H5T_COMPOUND, sizeof(reference));
    H5Tinsert(type, "dataset", HOFFSET(reference, set), H5T_STD_REF_OBJ);
    H5Tinsert(type, "dimension", HOFFSET(reference, axis), H5T_NATIVE_INT);
    return type;
}

/* Pairs of a data set and the number of an axis. */
static bool is_reference_list(hid_t type)
{
    if (H5Tget_class(type) != H5T_COMPOUND || H5Tget_nmembers(type) != 2 || H5Tget_member_class(type, 1) != H5T_INTEGER)
        return false;
    const hid_t first = H5Tget_member_type(type, 0);
    const bool good = H5Tequal(first, H5T_STD_REF_OBJ) > 0;
    H5Tclose(first);
    return good;
}

/* The axes of the data set at `address` that have this scale, as bits. */
static unsigned axes_of_scale(hid_t scale, haddr_t address)
{
    unsigned axes = 0;
    const hid_t id = H5Aexists(scale, "REFERENCE_LIST") > 0 ? H5Aopen(scale, "REFERENCE_LIST", H5P_DEFAULT) : -1;
    if (id < 0)
        return 0;
    const hid_t stored = H5Aget_type(id), space = H5Aget_space(id), type = reference_type();
    const hssize_t n = space >= 0 ? H5Sget_simple_extent_npoints(space) : 0;
    reference *list = n >= 1 && n <= REFERENCES_MOST ? vvi_calloc((size_t)n, sizeof *list) : NULL;
    if (list && is_reference_list(stored) && H5Aread(id, type, list) >= 0)
        for (hssize_t i = 0; i < n; i++)
            if (list[i].set == address && list[i].axis >= 0 && list[i].axis < VVI_H5_RANK)
                axes |= 1u << list[i].axis;
    free(list);
    H5Tclose(type);
    if (stored >= 0)
        H5Tclose(stored);
    if (space >= 0)
        H5Sclose(space);
    H5Aclose(id);
    return axes;
}

static void take_scale(vvi_netcdf *out, const char *path, hid_t scale, haddr_t address)
{
    char class[32];
    if (H5Iget_type(scale) != H5I_DATASET || !vvi_h5_text(class, sizeof class, scale, "CLASS") ||
        strcmp(class, "DIMENSION_SCALE") != 0)
        return;
    const unsigned axes = axes_of_scale(scale, address);
    for (int a = 0; a < VVI_H5_RANK; a++)
        if (axes >> a & 1 && !out->scale[a][0])
            memcpy(out->scale[a], path, VVI_H5_PATH);
}

static void look_for_scales(vvi_netcdf *out, const vvi_h5 *h5, const char *group, haddr_t address)
{
    H5G_info_t info;
    const hid_t at = vvi_h5_object(h5, group);
    if (at >= 0 && H5Iget_type(at) == H5I_GROUP && H5Gget_info(at, &info) >= 0 &&
        info.nlinks <= vvi_job_limits(h5->job)->files)
        for (hsize_t i = 0; i < info.nlinks; i++) {
            char name[VVI_H5_TEXT], path[VVI_H5_PATH];
            const ssize_t n =
                H5Lget_name_by_idx(at, ".", H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof name, H5P_DEFAULT);
            if (n < 1 || n >= (ssize_t)sizeof name || strlen(group) + strlen(name) + 2 > sizeof path)
                continue;
            snprintf(path, sizeof path, "%.250s/%s", group, name);
            const hid_t scale = vvi_h5_object(h5, path);
            if (scale >= 0) {
                take_scale(out, path, scale, address);
                H5Oclose(scale);
            }
        }
    if (at >= 0)
        H5Oclose(at);
}

/* Roles ----------------------------------------------------------------------------------------------------------- */

char vvi_netcdf_role(hid_t variable, const char *path)
{
    char text[VVI_H5_TEXT];
    const char *name = strrchr(path, '/');
    if (vvi_h5_text(text, sizeof text, variable, "axis") && strlen(text) == 1 && vvi_cf_role_named(text))
        return vvi_cf_role_named(text);
    if (vvi_h5_text(text, sizeof text, variable, "units")) {
        if (strncmp(text, "degree", 6) == 0 && (strstr(text, "_east") || strstr(text, "_E")))
            return 'x';
        if (strncmp(text, "degree", 6) == 0 && (strstr(text, "_north") || strstr(text, "_N")))
            return 'y';
        if (strstr(text, " since "))
            return 't';
    }
    if (vvi_h5_text(text, sizeof text, variable, "positive"))
        return 'z';
    if (vvi_h5_text(text, sizeof text, variable, "standard_name") && vvi_cf_role_named(text))
        return vvi_cf_role_named(text);
    return vvi_cf_role_named(name ? name + 1 : path);
}

/* What the conventions leave open gets what is left, the last axis first: x, y, z, time, components. */
static void fill_roles(char *roles, int rank)
{
    for (int a = rank - 1; a >= 0; a--)
        for (const char *r = "xyztc"; *r && roles[a] == '?'; r++)
            if (!memchr(roles, *r, (size_t)rank))
                roles[a] = *r;
}

static void choose_roles(vvi_netcdf *out, const vvi_h5 *h5, int rank)
{
    bool known = false;
    memset(out->roles, '?', (size_t)rank);
    out->roles[rank] = 0;
    for (int a = rank - 1; a >= 0; a--) {
        const hid_t scale = out->scale[a][0] ? vvi_h5_object(h5, out->scale[a]) : -1;
        const char role = scale >= 0 ? vvi_netcdf_role(scale, out->scale[a]) : 0;
        if (scale >= 0)
            H5Oclose(scale);
        if (role && !strchr(out->roles, role)) {
            out->roles[a] = role;
            known = true;
        }
    }
    if (known)
        fill_roles(out->roles, rank);
    else
        out->roles[0] = 0;
}

void vvi_netcdf_find(vvi_netcdf *out, const vvi_h5 *h5, const vvi_h5_set *set, hid_t data)
{
    H5O_info_t info;
    char group[VVI_H5_PATH], *slash;
    *out = (vvi_netcdf){.roles = ""};
    if (H5Aexists(data, "DIMENSION_LIST") <= 0 || H5Oget_info2(data, &info, H5O_INFO_BASIC) < 0)
        return;
    memcpy(group, set->path, sizeof group);
    while ((slash = strrchr(group, '/')) != NULL) { /* the group of the data set, and those around it */
        *slash = 0;
        look_for_scales(out, h5, group, info.addr);
    }
    choose_roles(out, h5, set->rank);
}

/* Meshes ---------------------------------------------------------------------------------------------------------- */

hid_t vvi_netcdf_variable(char path[VVI_H5_PATH], const vvi_h5 *h5, const vvi_h5_set *set, const char *name)
{
    char group[VVI_H5_PATH], *slash;
    memcpy(group, set->path, sizeof group);
    while ((slash = strrchr(group, '/')) != NULL) {
        *slash = 0;
        if (strlen(group) + strlen(name) + 2 > VVI_H5_PATH)
            continue;
        snprintf(path, VVI_H5_PATH, "%.250s/%.250s", group, name);
        const hid_t variable = vvi_h5_object(h5, path);
        if (variable >= 0)
            return variable;
    }
    return -1;
}

/* How many samples a data set of one axis has; 0: it is no such. */
hsize_t vvi_netcdf_length(hid_t variable)
{
    hsize_t n = 0;
    const hid_t space = H5Iget_type(variable) == H5I_DATASET ? H5Dget_space(variable) : -1;
    if (space >= 0 && H5Sget_simple_extent_ndims(space) == 1)
        H5Sget_simple_extent_dims(space, &n, NULL);
    if (space >= 0)
        H5Sclose(space);
    return n;
}

/* x and y of places one by one: both as long as one and the same axis. */
static int find_axis_of_places(const vvi_h5 *h5, const vvi_h5_set *set, hid_t data)
{
    char text[1024], path[VVI_H5_PATH], *rest = text, *word;
    hsize_t n_x = 0, n_y = 0;
    int found = -1;
    if (!vvi_h5_text(text, sizeof text, data, "coordinates"))
        return -1;
    while ((word = strsep(&rest, " ")) != NULL) {
        const hid_t variable = word[0] ? vvi_netcdf_variable(path, h5, set, word) : -1;
        if (variable < 0)
            continue;
        const char role = vvi_netcdf_role(variable, path);
        if (role == 'x')
            n_x = vvi_netcdf_length(variable);
        if (role == 'y')
            n_y = vvi_netcdf_length(variable);
        H5Oclose(variable);
    }
    for (int a = 0; a < set->rank && n_x > 0 && n_x == n_y; a++)
        if (set->dims[a] == n_x) {
            if (found >= 0)
                return -1; /* two axes as long: x and y of a square */
            found = a;
        }
    return found;
}

bool vvi_netcdf_on_mesh(const vvi_h5 *h5, const vvi_h5_set *set, hid_t data)
{
    char text[VVI_H5_TEXT];
    if (H5Aexists(data, "DIMENSION_LIST") <= 0)
        return false;
    return (vvi_h5_text(text, sizeof text, data, "mesh") && vvi_h5_text(text, sizeof text, data, "location")) ||
           (vvi_h5_text(text, sizeof text, data, "cf_role") && strstr(text, "connectivity")) ||
           find_axis_of_places(h5, set, data) >= 0;
}

vv_status vvi_netcdf_fail_mesh(const vvi_h5 *h5, const vvi_h5_set *set)
{
    return vv_fail_at(VV_E_UNSUPPORTED, h5->name, set->path,
                      "is on an unstructured mesh of single points, not a grid; regrid it to longitude and latitude "
                      "first ('cdo remapbil,r360x180 IN.nc OUT.nc')");
}
