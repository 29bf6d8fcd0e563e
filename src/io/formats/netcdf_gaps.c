/* Values that stand for none, by the CF conventions: _FillValue, missing_value, and what is outside valid_range. There
 * is no such number among integers: those that have one are unpacked to floats as they are read. */
#include "grid/field.h"
#include "grid/true_values.h"
#include "io/formats/hdf5.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

void vvi_netcdf_packing(double *scale, double *offset, hid_t data)
{
    double value;
    if (vvi_h5_numbers(&value, 1, data, "scale_factor") == 1 && isfinite(value) && value != 0)
        *scale = value;
    if (vvi_h5_numbers(&value, 1, data, "add_offset") == 1 && isfinite(value))
        *offset = value;
}

/* What is said of them ---------------------------------------------------------------------------------------------
 */

static void take_none(vvi_h5_gaps *gaps, const vvi_h5_set *set, hid_t data)
{
    static const char *const names[] = {"_FillValue", "missing_value"};
    for (int i = 0; i < 2; i++) {
        double value[VVI_H5_MISSING / 2];
        const int n = vvi_h5_numbers(value, VVI_H5_MISSING / 2, data, names[i]);
        for (int k = 0; k < n; k++) {
            const double v = set->type == VV_TYPE_F32 ? (double)(float)value[k] : value[k];
            bool known = isnan(v);
            for (int m = 0; m < gaps->n; m++)
                known = known || gaps->none[m] == v;
            if (!known)
                gaps->none[gaps->n++] = v;
        }
    }
}

static bool is_float(hid_t data, const char *name)
{
    const hid_t id = H5Aopen(data, name, H5P_DEFAULT), type = id >= 0 ? H5Aget_type(id) : -1;
    const bool found = type >= 0 && H5Tget_class(type) == H5T_FLOAT;
    if (type >= 0)
        H5Tclose(type);
    if (id >= 0)
        H5Aclose(id);
    return found;
}

/* An end of the range as a stored number. Floats are about the values of packed integers, whatever CF would like. */
static double stored_end(double end, bool unpacked, const vvi_h5_gaps *gaps)
{
    const double almost = 1e-6; /* of a step: ends are rounded themselves */
    if (!unpacked)
        return end;
    const double stored = (end - gaps->offset) / gaps->scale, whole = round(stored);
    return fabs(stored - whole) < almost ? whole : stored;
}

static void take_range(vvi_h5_gaps *gaps, const vvi_h5_set *set, hid_t data)
{
    double range[2] = {-INFINITY, INFINITY}, end[2];
    const bool packed = !vv_type_is_float(set->type) && (gaps->scale != 1 || gaps->offset != 0);
    const bool pair = vvi_h5_numbers(range, 2, data, "valid_range") == 2;
    if (!pair) {
        range[0] = -INFINITY;
        vvi_h5_numbers(&range[0], 1, data, "valid_min");
        vvi_h5_numbers(&range[1], 1, data, "valid_max");
    }
    for (int i = 0; i < 2; i++)
        end[i] = stored_end(range[i],
                            packed && is_float(data, pair ? "valid_range"
                                                     : i  ? "valid_max"
                                                          : "valid_min"),
                            gaps);
    const bool turned = packed && gaps->scale < 0 && end[0] > end[1];
    gaps->lo = end[turned ? 1 : 0];
    gaps->hi = end[turned ? 0 : 1];
    if (!(gaps->lo <= gaps->hi)) { /* that leaves nothing, as of integers that another attribute makes unsigned */
        gaps->lo = -INFINITY;
        gaps->hi = INFINITY;
    }
}

/* Numbers that are names, or colours; and 0 for none is as good as any label of nothing. */
static bool stays(const vvi_h5_plan *plan, hid_t data)
{
    static const char *const flags[] = {"flag_values", "flag_masks", "flag_meanings"};
    const vvi_h5_set *set = &plan->set;
    const vvi_h5_gaps *gaps = &plan->gaps;
    char meaning[16];
    bool label = set->names || set->truth ||
                 (vvi_h5_text(meaning, sizeof meaning, data, "meaning") && strcmp(meaning, "scalar") != 0);
    for (int i = 0; i < 3; i++)
        label = label || H5Aexists(data, flags[i]) > 0;
    const char *c = strchr(plan->roles, 'c');
    const int64_t n = c ? plan->dims[c - plan->roles] : 1;
    const bool colour = set->type == VV_TYPE_U8 && (n == 3 || n == 4);
    const bool nothing = gaps->n == 1 && gaps->none[0] == 0;
    return gaps->scale == 1 && gaps->offset == 0 && (label || colour || nothing);
}

/* Bytes of the data set that become NaN. */
static void take_lost(vvi_h5_plan *plan, hid_t data)
{
    static const char *const names[] = {"_FillValue", "missing_value"};
    double value;
    memcpy(plan->gaps.lost, plan->set.lost, sizeof plan->gaps.lost);
    for (int i = 1; i >= 0 && !vv_type_is_float(plan->set.type); i--) {
        uint8_t bytes[16] = {0};
        if (vvi_h5_numbers(&value, 1, data, names[i]) != 1)
            continue;
        const hid_t id = H5Aopen(data, names[i], H5P_DEFAULT), type = H5Dget_type(data);
        const hid_t space = id >= 0 ? H5Aget_space(id) : -1;
        if (space >= 0 && H5Sget_simple_extent_npoints(space) == 1 && H5Tget_size(type) <= sizeof bytes &&
            H5Aread(id, type, bytes) >= 0)
            memcpy(plan->gaps.lost, bytes, sizeof bytes);
        if (space >= 0)
            H5Sclose(space);
        if (type >= 0)
            H5Tclose(type);
        if (id >= 0)
            H5Aclose(id);
    }
}

/* Taking and marking them ------------------------------------------------------------------------------------------
 */

static vv_type float_for(const vvi_h5_gaps *gaps, vv_type stored)
{
    const vv_field_info info = {.type = stored, .value_scale = gaps->scale, .value_offset = gaps->offset};
    const double a = vvi_type_min(stored) * gaps->scale + gaps->offset;
    const double b = vvi_type_max(stored) * gaps->scale + gaps->offset;
    return vvi_true_values_type(&info, fmin(a, b), fmax(a, b), 1u << VV_TYPE_F32);
}

static vv_status note_unpacking(vv_notes *notes, const vvi_h5_gaps *gaps, vv_type stored)
{
    char text[512];
    int at = snprintf(text, sizeof text, "stored as %s, read as %s: ", vv_type_name(stored), vv_type_name(gaps->type));
    for (int i = 0; i < gaps->n; i++)
        at += snprintf(text + at, sizeof text - (size_t)at, "%s%.9g", i ? ", " : "", gaps->none[i]);
    if (isfinite(gaps->lo) || isfinite(gaps->hi))
        at += snprintf(text + at, sizeof text - (size_t)at, "%sall outside %.9g to %.9g", gaps->n ? " and " : "",
                       gaps->lo, gaps->hi);
    snprintf(text + at, sizeof text - (size_t)at, " as stored %s NaN",
             gaps->n == 1 && !isfinite(gaps->lo) ? "is" : "are");
    return vvi_notes_add(notes, "missing values", text);
}

vv_status vvi_netcdf_take_gaps(vvi_h5_plan *plan, hid_t data, vv_notes *notes)
{
    vvi_h5_gaps gaps = {.scale = 1};
    const vv_type stored = plan->set.type;
    const bool whole = !vv_type_is_float(stored);
    if (whole)
        vvi_netcdf_packing(&gaps.scale, &gaps.offset, data);
    take_none(&gaps, &plan->set, data);
    take_range(&gaps, &plan->set, data);
    const bool cut = whole ? gaps.lo > vvi_type_min(stored) || gaps.hi < vvi_type_max(stored)
                           : gaps.lo > -INFINITY || gaps.hi < INFINITY;
    plan->gaps = gaps;
    if ((gaps.n == 0 && !cut) || (whole && stays(plan, data))) {
        plan->gaps = (vvi_h5_gaps){0};
        return VV_OK;
    }
    plan->gaps.any = true;
    plan->gaps.type = whole ? float_for(&gaps, stored) : stored;
    if (!whole)
        plan->gaps.scale = 0; /* as in the info */
    take_lost(plan, data);
    vvi_h5_adapt(plan, &plan->set);
    return whole ? note_unpacking(notes, &plan->gaps, stored) : VV_OK;
}

static bool is_none(const vvi_h5_gaps *gaps, double v)
{
    for (int i = 0; i < gaps->n; i++)
        if (v == gaps->none[i])
            return true;
    return v < gaps->lo || v > gaps->hi;
}

void vvi_netcdf_mark_gaps(const vvi_h5_gaps *gaps, void *numbers, size_t n)
{
    const bool unpack = gaps->scale != 0;
    float *f = numbers;
    double *d = numbers;
    if (gaps->type == VV_TYPE_F32) {
        for (size_t i = 0; i < n; i++)
            if (is_none(gaps, (double)f[i]))
                f[i] = NAN;
            else if (unpack)
                f[i] = (float)((double)f[i] * gaps->scale + gaps->offset);
        return;
    }
    for (size_t i = 0; i < n; i++)
        if (is_none(gaps, d[i]))
            d[i] = NAN;
        else if (unpack)
            d[i] = d[i] * gaps->scale + gaps->offset;
}
