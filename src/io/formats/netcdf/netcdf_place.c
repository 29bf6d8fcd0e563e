/* Where the samples of netCDF-4 are: coordinates along each axis. Samples of a field lie evenly; where coordinates do
 * not, a warning says so. */
#include "core/memory.h"
#include "core/units.h"
#include "io/cf_axes.h"
#include "io/formats/hdf5/hdf5.h"
#include "io/placement.h"
#include "io/scan.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Numbers of one axis --------------------------------------------------------------------------------------------- */

/* Bytes as they are in the file; the lock is held. */
static bool read_bytes(void *out, const vvi_h5_set *set, vvi_h5 *h5, hid_t data, hid_t type)
{
    if (!set->by_chunks)
        return H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, out) >= 0;
    const hsize_t start[VVI_H5_RANK] = {0}, count[VVI_H5_RANK] = {set->dims[0]};
    const vvi_h5_slab slab = {set, start, count, out, set->bytes};
    uint64_t missing = 0;
    vvi_h5_unlock(); /* chunks are unpacked without it */
    const vv_status st = vvi_h5_read_chunks(&slab, h5, data, &missing, h5->job);
    vvi_h5_lock();
    return st == VV_OK && missing == 0;
}

/* The numbers of a data set of one axis, yours to free(); NULL when it has none. precision: of its type. */
static double *read_line(size_t *n, double *precision, vvi_h5 *h5, const char *path, hid_t data)
{
    vvi_h5_set set = {0};
    snprintf(set.path, sizeof set.path, "%s", path);
    if (vvi_netcdf_length(data) < 1 || vvi_netcdf_length(data) > VVI_CF_LINE_MOST ||
        vvi_h5_describe_line(&set, h5, data) != VV_OK || vvi_h5_check(&set, h5, data) != VV_OK)
        return NULL;
    const hid_t type = H5Dget_type(data);
    *n = (size_t)set.dims[0];
    *precision = set.type == VV_TYPE_F32 ? 1.2e-7 : 0;
    double *out = vvi_calloc(*n, set.bytes > sizeof *out ? set.bytes : sizeof *out);
    if (out && (!read_bytes(out, &set, h5, data, type) ||
                H5Tconvert(type, H5T_NATIVE_DOUBLE, *n, out, NULL, H5P_DEFAULT) < 0)) {
        free(out);
        out = NULL;
    }
    H5Tclose(type);
    return out;
}

static void take_unit(char out[16], hid_t variable)
{
    char text[64];
    vvi_cf_axis_unit(out, vvi_h5_text(text, sizeof text, variable, "units") ? text : NULL);
}

static vv_status read_coordinates(vvi_cf_line *c, vvi_h5 *h5, const char *path, hid_t variable, char role,
                                  vv_notes *notes)
{
    size_t n;
    double precision;
    *c = (vvi_cf_line){.known = false};
    double *at = read_line(&n, &precision, h5, path, variable);
    if (!at)
        return h5->st;
    take_unit(c->unit, variable);
    const vv_status st = vvi_cf_take_line(c, at, n, precision, role, notes);
    free(at);
    return st;
}

/* Which variable ----------------------------------------------------------------------------------------------------
 */

/* netCDF makes such for axes that have names and no coordinates. */
static bool has_no_coordinates(hid_t scale)
{
    char text[VVI_H5_TEXT];
    return vvi_h5_text(text, sizeof text, scale, "NAME") &&
           strncmp(text, "This is a netCDF dimension but not", 34) == 0;
}

/* Levels that are numbered have their heights in a variable of their own, named by `coordinates`. */
static hid_t find_lengths(char path[VVI_H5_PATH], const vvi_h5 *h5, const vvi_h5_set *set, hid_t data, char role,
                          hsize_t n)
{
    char text[1024], unit[16], *rest = text, *word;
    if (!vvi_h5_text(text, sizeof text, data, "coordinates"))
        return -1;
    while ((word = strsep(&rest, " ")) != NULL) {
        const hid_t variable = word[0] ? vvi_netcdf_variable(path, h5, set, word) : -1;
        if (variable < 0)
            continue;
        take_unit(unit, variable);
        if (vvi_netcdf_length(variable) == n && vvi_netcdf_role(variable, path) == role &&
            vvi_length_unit_metres(unit) > 0)
            return variable;
        H5Oclose(variable);
    }
    return -1;
}

static vv_status find_coordinates(vvi_cf_line *c, vvi_h5 *h5, const vvi_h5_plan *plan, const vvi_netcdf *axes,
                                  hid_t data, int axis, vv_notes *notes)
{
    char path[VVI_H5_PATH], unit[16] = "";
    const hsize_t n = plan->set.dims[axis];
    *c = (vvi_cf_line){.known = false};
    snprintf(path, sizeof path, "%s", axes->scale[axis]);
    hid_t variable = path[0] ? vvi_h5_object(h5, path) : -1;
    const bool none = variable < 0 || has_no_coordinates(variable) || vvi_netcdf_length(variable) != n;
    if (!none)
        take_unit(unit, variable);
    if (none || !unit[0]) {
        char other[VVI_H5_PATH];
        const hid_t lengths = find_lengths(other, h5, &plan->set, data, plan->roles[axis], n);
        if (variable >= 0 && (none || lengths >= 0)) {
            H5Oclose(variable);
            variable = -1;
        }
        if (lengths >= 0) {
            variable = lengths;
            memcpy(path, other, sizeof path);
        }
    }
    if (variable < 0)
        return VV_OK;
    const vv_status st = read_coordinates(c, h5, path, variable, plan->roles[axis], notes);
    H5Oclose(variable);
    return st;
}

vv_status vvi_netcdf_place(vv_field_info *info, const vvi_h5_plan *plan, const vvi_netcdf *axes, vvi_h5 *h5, hid_t data,
                           vv_notes *notes)
{
    vvi_cf_line c[3] = {{.known = false}, {.known = false}, {.known = false}}, found;
    char text[64];
    vv_status st = VV_OK;
    for (int i = plan->set.rank - 1; i >= 0 && st == VV_OK; i--) {
        if (plan->roles[i] == 'c' || (st = find_coordinates(&found, h5, plan, axes, data, i, notes)) != VV_OK)
            continue;
        if (plan->roles[i] == 't')
            vvi_cf_place_frames(info, &found);
        else
            c[plan->roles[i] - 'x'] = found;
    }
    if (vvi_h5_text(text, sizeof text, data, "units"))
        vvi_unit_name(info->value_unit, text, strlen(text));
    return st == VV_OK ? vvi_cf_place(info, c, notes) : st;
}
