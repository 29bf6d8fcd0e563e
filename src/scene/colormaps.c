#include "scene/colormaps.h"
#include "core/names.h"
#include "core/oklab.h"
#include "scene/colormap_knots.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

#define COUNT (sizeof colormaps / sizeof colormaps[0])

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
