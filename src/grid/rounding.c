#include "grid/rounding.h"
#include "core/memory.h"
#include <math.h>

enum { FEW = 128 };     /* numbers: more than a tenth of the bins of a histogram */
#define LEAST_SHARE 0.1 /* of the values that there were */

int vvi_values_apart(const vv_statistics *s)
{
    int n = 0;
    for (int i = 0; i < s->n_bins; i++)
        n += s->histogram[i] > 0;
    return n;
}

void vvi_tell_rounding(vv_job *job, double lo, double hi, int n_apart, double n_left, vv_type type)
{
    if (n_left > 0 && n_left < LEAST_SHARE * n_apart)
        vvi_job_warn(job, "rescale",
                     "values from %g to %g are rounded to %g of the numbers of %s, where %d or more were different; "
                     "--range %g..%g spreads them over all of %s (rescale: --from)",
                     lo, hi, n_left, vv_type_name(type), n_apart, lo, hi, vv_type_name(type));
}

/* Of the values of a component. */
static double numbers_left(const vv_statistics *s, const vv_field_info *info, const vvi_sample_map *map)
{
    const double value[2] = {s->min, s->max};
    double at[2];
    for (int i = 0; i < 2; i++) {
        const double stored = (value[i] - info->value_offset) / info->value_scale;
        at[i] = nearbyint(fmin(fmax(stored * map->gain + map->shift, map->lo), map->hi));
    }
    return fabs(at[1] - at[0]) + 1;
}

vv_status vvi_tell_rounded(const vv_field *out, const vv_field *in, const vvi_sample_map *map, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(in);
    const vv_type type = vv_field_get_info(out)->type;
    vv_status st = VV_OK;
    vv_statistics *s;
    if (vv_type_is_float(type) || vv_type_bytes(type) > 2)
        return VV_OK;
    if (!(s = vvi_alloc(job, sizeof *s, VVI_MEM_SCRATCH)))
        return vv_fail_memory(sizeof *s);
    for (int c = 0; c < info->components && st == VV_OK; c++) {
        if ((st = vv_field_statistics(s, out, c, job)) != VV_OK || vvi_values_apart(s) > FEW ||
            (st = vv_field_statistics(s, in, c, job)) != VV_OK || s->count == 0)
            continue;
        vvi_tell_rounding(job, s->min, s->max, vvi_values_apart(s), numbers_left(s, info, map), type);
    }
    vvi_free(s);
    return st;
}
