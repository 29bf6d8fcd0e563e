/* Values that stand for none, by the CF conventions: _FillValue, missing_value, and what is outside valid_range. There
 * is no such number among integers: those that have one are unpacked to floats as they are read. */
#include "io/cf.h"
#include "grid/field.h"
#include "grid/true_values.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* The type of the same bits that _Unsigned asks for; the same where it says nothing. */
static vv_type meant_type(vv_type stored, const vvi_cf_attributes *of)
{
    char text[16];
    if (vv_type_is_float(stored) || !of->text(text, sizeof text, of->user, "_Unsigned"))
        return stored;
    const bool has_sign = vvi_type_min(stored) < 0;
    if (has_sign && strcasecmp(text, "true") == 0)
        return (vv_type)(stored - 1); /* vv_type has them in pairs, that without a sign first */
    return !has_sign && strcasecmp(text, "false") == 0 ? (vv_type)(stored + 1) : stored;
}

void vvi_cf_packing(double *scale, double *offset, const vvi_cf_attributes *of)
{
    double value;
    if (of->numbers(&value, 1, of->user, "scale_factor") == 1 && isfinite(value) && value != 0)
        *scale = value;
    if (of->numbers(&value, 1, of->user, "add_offset") == 1 && isfinite(value))
        *offset = value;
}

/* What is said of them ---------------------------------------------------------------------------------------------
 */

/* Numbers that the file has with another sign than is meant, in its attributes and in its samples. */
typedef struct turning {
    double lo, hi, all; /* all: how many numbers there are */
} turning;

static turning turning_of(const vvi_cf_gaps *gaps)
{
    if (!gaps->turned)
        return (turning){-INFINITY, INFINITY, 0};
    return (turning){vvi_type_min(gaps->stored), vvi_type_max(gaps->stored),
                     ldexp(1, 8 * (int)vv_type_bytes(gaps->stored))};
}

static inline double turn(double v, const turning *t)
{
    return v < t->lo ? v + t->all : v > t->hi ? v - t->all : v;
}

static void take_none(vvi_cf_gaps *gaps, const vvi_cf_attributes *of)
{
    static const char *const names[] = {"_FillValue", "missing_value"};
    const turning sign = turning_of(gaps);
    for (int i = 0; i < 2; i++) {
        double value[VVI_CF_NONE / 2];
        const int n = of->numbers(value, VVI_CF_NONE / 2, of->user, names[i]);
        for (int k = 0; k < n; k++) {
            const double whole = turn(value[k], &sign);
            const double v = gaps->stored == VV_TYPE_F32 ? (double)(float)whole : whole;
            bool known = isnan(v);
            for (int m = 0; m < gaps->n; m++)
                known = known || gaps->none[m] == v;
            if (!known)
                gaps->none[gaps->n++] = v;
        }
    }
}

/* An end of the range as a stored number. Floats are about the values of packed integers, whatever CF would like. */
static double stored_end(double end, bool unpacked, const vvi_cf_gaps *gaps)
{
    const double almost = 1e-6; /* of a step: ends are rounded themselves */
    const turning sign = turning_of(gaps);
    if (!unpacked)
        return isfinite(end) ? turn(end, &sign) : end;
    const double stored = (end - gaps->offset) / gaps->scale, whole = round(stored);
    return fabs(stored - whole) < almost ? whole : stored;
}

static void take_range(vvi_cf_gaps *gaps, const vvi_cf_attributes *of)
{
    double range[2] = {-INFINITY, INFINITY}, end[2];
    const bool packed = !vv_type_is_float(gaps->stored) && (gaps->scale != 1 || gaps->offset != 0);
    const bool pair = of->numbers(range, 2, of->user, "valid_range") == 2;
    if (!pair) {
        range[0] = -INFINITY;
        of->numbers(&range[0], 1, of->user, "valid_min");
        of->numbers(&range[1], 1, of->user, "valid_max");
    }
    for (int i = 0; i < 2; i++)
        end[i] = stored_end(range[i],
                            packed && of->is_float(of->user, pair ? "valid_range"
                                                             : i  ? "valid_max"
                                                                  : "valid_min"),
                            gaps);
    const bool turned = packed && gaps->scale < 0 && end[0] > end[1];
    gaps->lo = end[turned ? 1 : 0];
    gaps->hi = end[turned ? 0 : 1];
    if (!(gaps->lo <= gaps->hi)) { /* that leaves nothing */
        gaps->lo = -INFINITY;
        gaps->hi = INFINITY;
    }
}

/* Numbers that are names, or colours; and 0 for none is as good as any label of nothing. */
static bool stays(const vvi_cf_gaps *gaps, bool labels, const vvi_cf_attributes *of)
{
    static const char *const flags[] = {"flag_values", "flag_masks", "flag_meanings"};
    double number;
    char text[16];
    for (int i = 0; i < 3; i++)
        labels = labels || of->numbers(&number, 1, of->user, flags[i]) > 0 ||
                 of->text(text, sizeof text, of->user, flags[i]);
    const bool nothing = gaps->n == 1 && gaps->none[0] == 0;
    return gaps->scale == 1 && gaps->offset == 0 && (labels || nothing);
}

static vv_type float_for(const vvi_cf_gaps *gaps)
{
    const vv_field_info info = {.type = gaps->stored, .value_scale = gaps->scale, .value_offset = gaps->offset};
    const double a = vvi_type_min(gaps->stored) * gaps->scale + gaps->offset;
    const double b = vvi_type_max(gaps->stored) * gaps->scale + gaps->offset;
    return vvi_true_values_type(&info, fmin(a, b), fmax(a, b), 1u << VV_TYPE_F32);
}

void vvi_cf_take_gaps(vvi_cf_gaps *out, vv_type in_file, bool labels, const vvi_cf_attributes *of)
{
    const vv_type stored = meant_type(in_file, of);
    vvi_cf_gaps gaps = {.turned = stored != in_file, .stored = stored, .scale = 1};
    const bool whole = !vv_type_is_float(stored);
    *out = (vvi_cf_gaps){.turned = gaps.turned, .stored = stored};
    if (whole)
        vvi_cf_packing(&gaps.scale, &gaps.offset, of);
    take_none(&gaps, of);
    take_range(&gaps, of);
    const bool cut = whole ? gaps.lo > vvi_type_min(stored) || gaps.hi < vvi_type_max(stored)
                           : gaps.lo > -INFINITY || gaps.hi < INFINITY;
    if ((gaps.n == 0 && !cut) || (whole && stays(&gaps, labels, of)))
        return;
    gaps.any = true;
    gaps.type = whole ? float_for(&gaps) : stored;
    if (!whole)
        gaps.scale = 0; /* as in the info */
    *out = gaps;
}

vv_status vvi_cf_note_gaps(const vvi_cf_gaps *gaps, vv_notes *notes)
{
    char text[512];
    if (!gaps->any || vv_type_is_float(gaps->stored))
        return VV_OK;
    int at =
        snprintf(text, sizeof text, "stored as %s, read as %s: ", vv_type_name(gaps->stored), vv_type_name(gaps->type));
    for (int i = 0; i < gaps->n; i++)
        at += snprintf(text + at, sizeof text - (size_t)at, "%s%.9g", i ? ", " : "", gaps->none[i]);
    if (isfinite(gaps->lo) || isfinite(gaps->hi))
        at += snprintf(text + at, sizeof text - (size_t)at, "%sall outside %.9g to %.9g", gaps->n ? " and " : "",
                       gaps->lo, gaps->hi);
    snprintf(text + at, sizeof text - (size_t)at, " as stored %s NaN",
             gaps->n == 1 && !isfinite(gaps->lo) ? "is" : "are");
    return vvi_notes_add(notes, "missing values", text);
}

/* Taking them out ----------------------------------------------------------------------------------------------------
 */

static bool is_none(const vvi_cf_gaps *gaps, double v)
{
    for (int i = 0; i < gaps->n; i++)
        if (v == gaps->none[i])
            return true;
    return v < gaps->lo || v > gaps->hi;
}

static inline double value_of(const vvi_cf_gaps *gaps, const turning *sign, double stored)
{
    const double v = turn(stored, sign);
    return is_none(gaps, v) ? (double)NAN : gaps->scale != 0 ? v * gaps->scale + gaps->offset : v;
}

void vvi_cf_mark_gaps(const vvi_cf_gaps *gaps, void *numbers, size_t n)
{
    const turning sign = turning_of(gaps);
    float *f = numbers;
    double *d = numbers;
    if (gaps->type == VV_TYPE_F32)
        for (size_t i = 0; i < n; i++)
            f[i] = (float)value_of(gaps, &sign, (double)f[i]);
    else
        for (size_t i = 0; i < n; i++)
            d[i] = value_of(gaps, &sign, d[i]);
}
