#include "scene/two_sided.h"
#include <math.h>
#include <string.h>
#include <strings.h>

/* A unit whose zero is a mark on a scale. */
static bool has_scale(const char *unit)
{
    static const char *const units[] = {"HU",
                                        "C",
                                        "\u00b0C",
                                        "degC",
                                        "deg_C",
                                        "deg C",
                                        "celsius",
                                        "degree_celsius",
                                        "degrees_celsius",
                                        "degree_C",
                                        "degrees_C",
                                        "F",
                                        "\u00b0F",
                                        "degF",
                                        "fahrenheit"};
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (strcasecmp(unit, units[i]) == 0)
            return true;
    return false;
}

/* Scanners begin at air, or at a mark for what they have not seen; bone lies further from zero than air. */
static bool like_hounsfield(const vv_field_info *info, const vv_statistics *s)
{
    static const double starts[] = {-1000, -1024, -2000, -2048, -3024};
    const bool whole = floor(s->min) == s->min && floor(s->max) == s->max; /* as where a fill was taken out */
    if ((vv_type_is_float(info->type) && !whole) || info->value_unit[0])
        return false;
    for (size_t i = 0; i < sizeof starts / sizeof *starts; i++)
        if (s->min == starts[i] && s->max != -s->min)
            return true;
    return s->min >= -1100 && s->min <= -900 && s->max >= -1.3 * s->min;
}

bool vvi_two_sided(vvi_value_fit *out, const vv_field_info *info, const vv_statistics *s)
{
    return s->min < 0 && !has_scale(info->value_unit) && !like_hounsfield(info, s) && vvi_fit_two_sided(out, s);
}

double vvi_two_sided_end(const vvi_value_fit *fit, const vv_statistics *s)
{
    const double end = fmax(-s->percentile[0], s->percentile[4]);
    return end > 0 ? end : fit->hi; /* fewer than a thousandth are not zero */
}

bool vvi_two_sided_map(const char *name)
{
    return name && strcmp(name, VVI_TWO_SIDED_MAP) == 0;
}

bool vvi_about_zero(double lo, double hi)
{
    return hi > 0 && fabs(lo + hi) <= 0.01 * hi;
}
