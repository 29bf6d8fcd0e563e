#include "filter/amounts.h"
#include "core/units.h"
#include "grid/field.h"

#include <math.h>
#include <string.h>

#define SAMPLES_MOST 0x1p30

vv_status vvi_stored_bytes(char out[8], const vv_field_info *info, double value, const char *place)
{
    const double stored = (value - info->value_offset) / info->value_scale, scale = info->value_scale;
    memset(out, 0, 8);
    if (!vv_type_is_float(info->type)) {
        const double lo = vvi_type_min(info->type), hi = vvi_type_max(info->type), whole = nearbyint(stored);
        if (!(whole >= lo && whole <= hi))
            return vv_fail(VV_E_ARGUMENT, "%s: %s samples of this volume hold values from %.9g to %.9g, found %g",
                           place, vv_type_name(info->type), fmin(lo * scale, hi * scale) + info->value_offset,
                           fmax(lo * scale, hi * scale) + info->value_offset, value);
    }
    vvi_samples_from_f64(out, &stored, info->type, 1);
    return VV_OK;
}

void vvi_fill_numbers(char *out, const char bytes[8], size_t each, int64_t n)
{
    for (int64_t i = 0; i < n; i++)
        memcpy(out + (size_t)i * each, bytes, each);
}

vv_status vvi_parse_samples(int64_t *out, const char *text, const vv_grid *grid, int axis, const char *place)
{
    const vv_property_context context = {.length_unit = grid->unit, .voxel = vv_grid_spacing(grid, axis)};
    double n;
    *out = 0;
    if (!vvi_parse_number(&n, text)) {
        const vv_status st = vvi_parse_quantity(&n, text, VV_Q_LENGTH, &context, place);
        if (st != VV_OK)
            return st;
        n = floor(n / context.voxel + 0.5);
    }
    if (!(n >= 0 && n <= SAMPLES_MOST && n == floor(n)))
        return vv_fail(VV_E_ARGUMENT,
                       "%s: '%s' is no number of samples; give a whole number of at least 0 or a length, "
                       "as in 10mm",
                       place, text);
    *out = (int64_t)n;
    return VV_OK;
}
