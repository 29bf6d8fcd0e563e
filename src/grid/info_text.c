#include "grid/info_text.h"
#include "core/units.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

void vvi_samples_print(char out[VVI_SAMPLES_TEXT], const vv_field_info *info, int64_t n_frames)
{
    char components[32] = "", frames[40] = "";
    if (info->components > 1)
        snprintf(components, sizeof components, ", %d channels", info->components);
    if (n_frames > 1)
        snprintf(frames, sizeof frames, ", %" PRId64 " time steps", n_frames);
    snprintf(out, VVI_SAMPLES_TEXT, "%" PRId64 " x %" PRId64 " x %" PRId64 " %s%s%s", info->grid.dims[0],
             info->grid.dims[1], info->grid.dims[2], vv_type_name(info->type), components, frames);
}

void vvi_scaled_print(char out[VVI_SCALED_TEXT], const char *stored, double scale, double offset)
{
    char times[32] = "", plus[32] = "";
    if (scale != 1)
        snprintf(times, sizeof times, " * %g", scale);
    if (offset != 0)
        snprintf(plus, sizeof plus, " %c %g", offset < 0 ? '-' : '+', fabs(offset));
    snprintf(out, VVI_SCALED_TEXT, "%.31s%s%s", stored, times, plus);
}

#define WHOLE_MOST 9007199254740992.0 /* 2^53: up to it doubles tell all whole numbers apart */

void vvi_value_print(char out[VVI_VALUE_TEXT], double value, double lo, double hi)
{
    const double span = hi - lo, most = fmax(fabs(lo), fabs(hi));
    if (value == nearbyint(value) && fabs(value) <= WHOLE_MOST) { /* 3000000000, not 3e+09 */
        snprintf(out, VVI_VALUE_TEXT, "%.0f", value == 0 ? 0 : value);
        return;
    }
    const int digits = span > 0 ? 6 + (int)fmin(ceil(log10(most / span)), 11) : 17;
    if (digits < 17)
        snprintf(out, VVI_VALUE_TEXT, "%.*g", digits < 6 ? 6 : digits, value == 0 ? 0 : value);
    else
        vvi_print_number(out, value);
}

void vvi_mesh_print(char out[VVI_MESH_TEXT], const vv_mesh_info *m)
{
    snprintf(out, VVI_MESH_TEXT, "%zu %s, %zu triangle%s%s%s%s%s", m->n_vertices,
             m->n_vertices == 1 ? "vertex" : "vertices", m->n_triangles, m->n_triangles == 1 ? "" : "s",
             m->normals ? ", normals" : "", m->values ? ", values" : "", m->colors ? ", colours" : "",
             m->coordinates ? ", texture coordinates" : "");
}
