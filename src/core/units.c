#include "core/units.h"
#include "core/status.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* How many of what a property stores one unit is. */
typedef struct unit {
    const char *name;
    double factor;
} unit;

static const unit lengths[] = {
    {"m", 1},       {"cm", 1e-2},   {"mm", 1e-3}, {"um", 1e-6},        {"\xc2\xb5m", 1e-6},     {"\xce\xbcm", 1e-6},
    {"nm", 1e-9},   {"pm", 1e-12},  {"A", 1e-10}, {"\xc3\x85", 1e-10}, {"\xe2\x84\xab", 1e-10}, {"km", 1e3},
    {"in", 0.0254}, {"ft", 0.3048}, {NULL, 0},
};
static const unit angles[] = {
    {"deg", M_PI / 180}, {"\xc2\xb0", M_PI / 180}, {"rad", 1}, {"turn", 2 * M_PI}, {NULL, 0},
};
static const unit times[] = {
    {"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"\xc2\xb5s", 1e-6}, {"\xce\xbcs", 1e-6}, {"min", 60}, {"h", 3600}, {NULL, 0},
};
#define BINARY(power) ((double)(UINT64_C(1) << (power)))
static const unit byte_sizes[] = {
    {"B", 1},          {"K", BINARY(10)},   {"KiB", BINARY(10)}, {"kB", 1e3},       {"KB", 1e3},
    {"M", BINARY(20)}, {"MiB", BINARY(20)}, {"MB", 1e6},         {"G", BINARY(30)}, {"GiB", BINARY(30)},
    {"GB", 1e9},       {"T", BINARY(40)},   {"TiB", BINARY(40)}, {"TB", 1e12},      {"k", BINARY(10)},
    {"m", BINARY(20)}, {"g", BINARY(30)},   {"t", BINARY(40)},   {NULL, 0},
};
static const unit ratios[] = {{"%", 0.01}, {NULL, 0}};

static const struct quantity {
    const char *noun, *known;
    const unit *units;
    double bare; /* factor of a number without a unit */
} quantities[] = {
    [VV_Q_NONE] = {"a number", "no unit", NULL, 1},
    [VV_Q_LENGTH] = {"a length", "m, cm, mm, um, nm, pm, A, km, in, ft, vox", lengths, 1},
    [VV_Q_ANGLE] = {"an angle", "deg, rad, turn", angles, M_PI / 180},
    [VV_Q_TIME] = {"a time", "s, ms, us, min, h", times, 1},
    [VV_Q_BYTES] = {"a size", "B, K, M, G, T, KiB, MiB, GiB, TiB, kB, MB, GB, TB", byte_sizes, 1},
    [VV_Q_RATIO] = {"a ratio", "%", ratios, 1},
    [VV_Q_LABEL] = {"a label", "no unit", NULL, 1},
};

static double factor_of(const unit *units, const char *name)
{
    for (; units && units->name; units++)
        if (strcmp(units->name, name) == 0)
            return units->factor;
    return 0;
}

double vvi_length_unit_metres(const char *name)
{
    return name ? factor_of(lengths, name) : 0;
}

static bool is_voxel(const char *name)
{
    return strcmp(name, "vox") == 0 || strcmp(name, "voxel") == 0 || strcmp(name, "voxels") == 0;
}

static vv_status length_factor(double *out, const char *name, const char *text, const vv_property_context *context,
                               const char *place)
{
    const char *stored = context && context->length_unit ? context->length_unit : "voxel";
    const double metres = vvi_length_unit_metres(name), stored_metres = vvi_length_unit_metres(stored);
    if (is_voxel(name)) {
        *out = context ? context->voxel : 0;
        return *out > 0
                   ? VV_OK
                   : vv_fail(VV_E_ARGUMENT, "%s: '%s' is in voxels, but there is no grid here to say how long one is",
                             place, text);
    }
    if (metres > 0 && stored_metres == 0)
        return vv_fail(VV_E_ARGUMENT,
                       "%s: '%s' has a physical unit, but lengths here are in %s; give a bare number or vox", place,
                       text, is_voxel(stored) ? "voxels" : stored);
    *out = metres > 0 ? metres / stored_metres : 0;
    return VV_OK;
}

/* What one `name` is in the property's unit. */
static vv_status unit_factor(double *out, const char *name, const char *text, vv_quantity quantity,
                             const vv_property_context *context, const char *place)
{
    const struct quantity *q = &quantities[quantity];
    vv_status st = VV_OK;
    if (quantity == VV_Q_LENGTH)
        st = length_factor(out, name, text, context, place);
    else
        *out = factor_of(q->units, name);
    if (st == VV_OK && *out == 0)
        st = vv_fail(VV_E_ARGUMENT, "%s: '%s' has the unknown unit '%s'; %s takes %s", place, text, name, q->noun,
                     q->known);
    return st;
}

vv_status vvi_parse_quantity(double *out, const char *text, vv_quantity quantity, const vv_property_context *context,
                             const char *place)
{
    const struct quantity *q = &quantities[quantity];
    const char *name;
    double number, factor = q->bare;
    if (!place)
        place = "value";
    if (!vvi_scan_number(&number, text, &name) || !isfinite(number))
        return vv_fail(VV_E_ARGUMENT, "%s: '%s' is not %s; write a number with %s", place, text, q->noun, q->known);
    while (*name == ' ')
        name++;
    if (strchr(name, ','))
        return vv_fail(VV_E_ARGUMENT,
                       "%s: '%s' is a list; expected one value, %s; decimals follow a point, not a comma", place, text,
                       q->noun);
    if (*name) {
        const vv_status st = unit_factor(&factor, name, text, quantity, context, place);
        if (st != VV_OK)
            return st;
    }
    if (!isfinite(number * factor))
        return vv_fail(VV_E_ARGUMENT, "%s: '%s' is too large for a number", place, text);
    if (quantity == VV_Q_BYTES && number < 0)
        return vv_fail(VV_E_ARGUMENT, "%s: '%s' is negative; a size cannot be", place, text);
    *out = number * factor;
    return VV_OK;
}

void vvi_print_bytes(char out[32], uint64_t bytes)
{
    static const char *const names[] = {"KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
    double value = (double)bytes / 1024;
    size_t i = 0;
    if (bytes < 1024) {
        snprintf(out, 32, "%d byte%s", (int)bytes, bytes == 1 ? "" : "s");
        return;
    }
    while (value >= 1023.95 && i + 1 < sizeof names / sizeof *names) {
        value /= 1024;
        i++;
    }
    const long long tenths = llround(value * 10); /* without the locale's comma */
    snprintf(out, 32, "%lld.%lld %s", tenths / 10, tenths % 10, names[i]);
}
