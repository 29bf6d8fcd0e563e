#include "grid/rounding.h"
#include "core/job.h"

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
