/* Where the samples of netCDF-4 are: coordinates along each axis. Samples of a field lie evenly; where coordinates do
 * not, a warning says so. */
#include "core/memory.h"
#include "core/units.h"
#include "io/formats/hdf5.h"
#include "io/place.h"
#include "io/scan.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COORDINATES_MOST ((hsize_t)1 << 20)
#define EVEN 1e-3 /* of a step */

typedef struct coordinates {
    bool known, even;
    double first, last;
    char unit[16];
} coordinates;

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
    if (vvi_netcdf_length(data) < 1 || vvi_netcdf_length(data) > COORDINATES_MOST ||
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

/* "degrees_north" and the like are all degrees; no unit and "1" are none. */
static void take_unit(char out[16], hid_t variable)
{
    char text[64];
    out[0] = 0;
    if (!vvi_h5_text(text, sizeof text, variable, "units") || strcmp(text, "1") == 0)
        return;
    if (strncmp(text, "degree", 6) == 0)
        snprintf(out, 16, "deg");
    else
        vvi_unit_name(out, text, strcspn(text, " "));
}

static bool check(coordinates *c, const double *at, size_t n, double precision)
{
    const double step = n > 1 ? (at[n - 1] - at[0]) / (double)(n - 1) : 1;
    const double near = EVEN * fabs(step) + 2 * precision * fmax(fabs(at[0]), fabs(at[n - 1]));
    c->first = at[0];
    c->last = at[n - 1];
    c->even = true;
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(at[i]) || (i > 0 && !((at[i] - at[i - 1]) * step > 0)))
            return false;
        c->even = c->even && fabs(at[i] - (at[0] + step * (double)i)) <= near;
    }
    return isfinite(step);
}

static vv_status read_coordinates(coordinates *c, vvi_h5 *h5, const char *path, hid_t variable, char role,
                                  vv_notes *notes)
{
    size_t n;
    double precision;
    *c = (coordinates){.known = false};
    double *at = read_line(&n, &precision, h5, path, variable);
    if (!at)
        return h5->st;
    take_unit(c->unit, variable);
    c->known = check(c, at, n, precision);
    free(at);
    return c->known ? VV_OK
                    : vvi_notes_warn(
                          notes,
                          "its coordinates along %c are neither ascending nor descending throughout; they are left out",
                          role);
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

static vv_status find_coordinates(coordinates *c, vvi_h5 *h5, const vvi_h5_plan *plan, const vvi_netcdf *axes,
                                  hid_t data, int axis, vv_notes *notes)
{
    char path[VVI_H5_PATH], unit[16] = "";
    const hsize_t n = plan->set.dims[axis];
    *c = (coordinates){.known = false};
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

/* The grid ----------------------------------------------------------------------------------------------------------
 */

static vv_status note_range(vv_notes *notes, const coordinates *c, char role)
{
    char key[32], value[96];
    snprintf(key, sizeof key, "coordinates of %c", role);
    snprintf(value, sizeof value, "%.7g .. %.7g%s%s", c->first, c->last, c->unit[0] ? " " : "", c->unit);
    const vv_status st = vvi_notes_add(notes, key, value);
    if (st != VV_OK || c->even)
        return st;
    return vvi_notes_warn(notes, "its coordinates along %c are uneven (%s); shown as if they were even", role, value);
}

static double step_of(const coordinates *c, int64_t n)
{
    return n > 1 ? (c->last - c->first) / (double)(n - 1) : 1;
}

static void take_frames(vv_field_info *info, const coordinates *c)
{
    if (!c->known || info->n_frames < 2)
        return;
    info->frame_step = step_of(c, info->n_frames);
    snprintf(info->frame_unit, sizeof info->frame_unit, "%.15s", c->unit);
}

/* Degrees along one axis and metres along another have no proportion. */
static bool units_differ(const coordinates c[3], const int64_t dims[3])
{
    const coordinates *first = NULL;
    for (int a = 0; a < 3; a++) {
        if (dims[a] < 2)
            continue;
        if (first && (strcmp(first->unit, c[a].unit) != 0 || first->known != c[a].known))
            return true;
        first = &c[a];
    }
    return false;
}

static vv_status place(vv_field_info *info, const coordinates c[3], vv_notes *notes)
{
    vv_affine *a = &info->grid.index_to_world;
    const char *unit = "";
    bool known = false;
    for (int i = 0; i < 3; i++)
        known = known || (c[i].known && info->grid.dims[i] > 1);
    if (!known)
        return VV_OK;
    if (units_differ(c, info->grid.dims))
        return vvi_notes_warn(notes, "its axes have different units (x: %s, y: %s, z: %s); shown in equal steps",
                              c[0].unit[0] ? c[0].unit : "none", c[1].unit[0] ? c[1].unit : "none",
                              c[2].unit[0] ? c[2].unit : "none");
    double shortest = INFINITY;
    for (int i = 0; i < 3; i++)
        if (info->grid.dims[i] > 1) {
            shortest = fmin(shortest, fabs(step_of(&c[i], info->grid.dims[i])));
            unit = c[i].unit;
        }
    double step[3], origin[3];
    for (int i = 0; i < 3; i++) { /* an axis of one sample is as thick as the thinnest */
        step[i] = info->grid.dims[i] > 1 ? step_of(&c[i], info->grid.dims[i]) : shortest;
        origin[i] = c[i].known && strcmp(c[i].unit, unit) == 0 ? c[i].first : 0;
    }
    *a = (vv_affine){{{step[0], 0, 0}, {0, step[1], 0}, {0, 0, step[2]}}, {origin[0], origin[1], origin[2]}};
    snprintf(info->grid.unit, sizeof info->grid.unit, "%.15s", unit[0] ? unit : "units");
    return VV_OK;
}

vv_status vvi_netcdf_place(vv_field_info *info, const vvi_h5_plan *plan, const vvi_netcdf *axes, vvi_h5 *h5, hid_t data,
                           vv_notes *notes)
{
    coordinates c[3] = {{.known = false}, {.known = false}, {.known = false}}, found;
    char text[64];
    vv_status st = VV_OK;
    for (int i = plan->set.rank - 1; i >= 0 && st == VV_OK; i--) {
        if (plan->roles[i] == 'c' || (st = find_coordinates(&found, h5, plan, axes, data, i, notes)) != VV_OK)
            continue;
        if (plan->roles[i] == 't')
            take_frames(info, &found);
        else
            c[plan->roles[i] - 'x'] = found;
        if (found.known)
            st = note_range(notes, &found, plan->roles[i]);
    }
    if (vvi_h5_text(text, sizeof text, data, "units"))
        vvi_unit_name(info->value_unit, text, strlen(text));
    return st == VV_OK ? place(info, c, notes) : st;
}
