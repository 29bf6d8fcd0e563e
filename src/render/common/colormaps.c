#include "render/common/colormaps.h"
#include "core/names.h"
#include "render/common/colormap_knots.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

#define COUNT (sizeof colormaps / sizeof colormaps[0])

void vvi_oklab_to_linear(double rgb[3], const double lab[3])
{
    static const double to_lms[3][3] = {
        {1, 0.3963377774, 0.2158037573}, {1, -0.1055613458, -0.0638541728}, {1, -0.0894841775, -1.2914855480}};
    static const double to_rgb[3][3] = {{4.0767416621, -3.3077115913, 0.2309699292},
                                        {-1.2684380046, 2.6097574011, -0.3413193965},
                                        {-0.0041960863, -0.7034186147, 1.7076147010}};
    double lms[3];
    for (int i = 0; i < 3; i++) {
        const double root = to_lms[i][0] * lab[0] + to_lms[i][1] * lab[1] + to_lms[i][2] * lab[2];
        lms[i] = root * root * root;
    }
    for (int i = 0; i < 3; i++)
        rgb[i] = fmin(fmax(to_rgb[i][0] * lms[0] + to_rgb[i][1] * lms[1] + to_rgb[i][2] * lms[2], 0), 1);
}

int vvi_colormap_find(const char *name)
{
    for (size_t i = 0; i < COUNT; i++)
        if (strcmp(colormaps[i].row.name, name) == 0 ||
            (colormaps[i].row.alias && strcmp(colormaps[i].row.alias, name) == 0))
            return (int)i;
    return -1;
}

vv_status vvi_colormap_fail(const char *where, const char *typed)
{
    const char *names[COUNT];
    for (size_t i = 0; i < COUNT; i++)
        names[i] = colormaps[i].row.name;
    return vvi_fail_name(VV_E_NOT_FOUND, NULL, where, typed, &(vvi_known){names, COUNT, "volvis presets", NULL},
                         "there is no colour map '%.100s'", typed);
}

const vv_preset *vvi_colormap_row(size_t index)
{
    return index < COUNT ? &colormaps[index].row : NULL;
}

/* Knot i, the curve going on straight beyond its ends. */
static double knot(const struct colormap *map, int i, int c)
{
    const int last = COLORMAP_KNOTS - 1;
    if (i < 0)
        return 2.0 * map->lab[0][c] - map->lab[1][c];
    if (i > last)
        return 2.0 * map->lab[last][c] - map->lab[last - 1][c];
    return map->lab[i][c];
}

void vvi_colormap_at(double rgb[3], int index, double at)
{
    const struct colormap *map = &colormaps[index];
    const double x = fmin(fmax(at, 0), 1) * (COLORMAP_KNOTS - 1); /* fmax also turns NaN into 0 */
    const int i = x < COLORMAP_KNOTS - 1 ? (int)x : COLORMAP_KNOTS - 2;
    const double t = x - i;
    double lab[3];
    for (int c = 0; c < 3; c++) { /* Catmull-Rom */
        const double p0 = knot(map, i - 1, c), p1 = knot(map, i, c), p2 = knot(map, i + 1, c), p3 = knot(map, i + 2, c);
        lab[c] = p1 + 0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)));
    }
    vvi_oklab_to_linear(rgb, lab);
}

/* "#rrggbb": from black to that colour in steps that look even. */
static bool ramp_at(vv_color *out, const char *name, double at)
{
    if (name[0] != '#' || strlen(name) != 7 || strspn(name + 1, "0123456789abcdefABCDEF") != 6)
        return false;
    const unsigned long code = strtoul(name + 1, NULL, 16);
    const double light = vv_srgb_decode(fmin(fmax(at, 0), 1)); /* fmax also turns NaN into 0 */
    out->r = light * vv_srgb_decode((double)(code >> 16 & 255) / 255);
    out->g = light * vv_srgb_decode((double)(code >> 8 & 255) / 255);
    out->b = light * vv_srgb_decode((double)(code & 255) / 255);
    out->a = 1;
    return true;
}

bool vv_colormap_sample(vv_color *out, const char *name, double at)
{
    double rgb[3];
    const int index = vvi_colormap_find(name);
    if (index < 0)
        return ramp_at(out, name, at);
    vvi_colormap_at(rgb, index, at);
    *out = (vv_color){rgb[0], rgb[1], rgb[2], 1};
    return true;
}
