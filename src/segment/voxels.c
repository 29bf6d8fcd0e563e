#include "segment/voxels.h"
#include "core/units.h"
#include "core/vec.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

vv_status vvi_voxels_parse(double *out, const char *text, const vv_grid *grid, const char *place)
{
    const vv_property_context context = {.length_unit = grid->unit};
    const vv_affine *m = &grid->index_to_world;
    const char *unit;
    char length[40] = "1";
    double n, one = 1;
    *out = 0;
    if (!text || !*text)
        return VV_OK;
    const bool is_number = vvi_scan_number(&n, text, &unit) && n >= 0 && isfinite(n);
    size_t letters = strlen(unit);
    if (is_number && (!*unit || strcmp(unit, "vox") == 0)) {
        *out = n;
        return VV_OK;
    }
    const bool cubed = letters > 1 && unit[letters - 1] == '3';
    letters -= cubed ? 1 : 0;
    letters -= cubed && letters > 1 && unit[letters - 1] == '^' ? 1 : 0;
    if (!is_number || !cubed || letters > 16)
        return vv_fail(VV_E_ARGUMENT, "%s: expected a number of voxels, 100, or a volume, 2.5mm3; found '%s'", place,
                       text);
    /* the unit's length, of which the volume is the cube */
    snprintf(length + 1, sizeof length - 1, "%.*s", (int)letters, unit);
    const vv_status st = vvi_parse_quantity(&one, length, VV_Q_LENGTH, &context, place);
    *out = n * one * one * one / fabs(vvi_dot(m->axis[0], vvi_cross(m->axis[1], m->axis[2])));
    return st;
}
