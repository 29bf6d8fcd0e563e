#include "filter/sigma.h"

#include <math.h>

enum { ROW_SIGMA, ROW_SIGMA_VOXELS };

static bool is_set(const vv_object *object, int row)
{
    return object->set >> row & 1;
}

vv_status vvi_sigma_check(const vv_object *params, const char *path)
{
    const vv_vec3 v = ((const vvi_sigma_params *)params)->sigma_voxels;
    if (is_set(params, ROW_SIGMA) && is_set(params, ROW_SIGMA_VOXELS))
        return vv_fail(VV_E_ARGUMENT, "%s: `sigma` and `sigma_voxels` set the same thing; give one of them",
                       params->cls->name);
    if (is_set(params, ROW_SIGMA_VOXELS) &&
        !(v.x >= 0 && v.y >= 0 && v.z >= 0 && isfinite(v.x) && isfinite(v.y) && isfinite(v.z)))
        return vv_fail_at(VV_E_ARGUMENT, NULL, path,
                          "sigma_voxels is [%g, %g, %g]; three numbers of at least 0 are "
                          "needed",
                          v.x, v.y, v.z);
    return VV_OK;
}

vv_status vvi_sigma_voxels(double sigma[3], const vv_field_info *info, const vv_object *params, const char *name,
                           double most)
{
    const vvi_sigma_params *p = (const vvi_sigma_params *)params;
    const double voxels[3] = {p->sigma_voxels.x, p->sigma_voxels.y, p->sigma_voxels.z};
    const vv_status st = vvi_sigma_check(params, NULL);
    if (st != VV_OK)
        return st;
    for (int a = 0; a < 3; a++) {
        sigma[a] = is_set(params, ROW_SIGMA_VOXELS) ? voxels[a]
                   : is_set(params, ROW_SIGMA)      ? p->sigma / vv_grid_spacing(&info->grid, a)
                                                    : 1;
        if (!(sigma[a] >= 0) || (sigma[a] > most && info->grid.dims[a] > 1))
            return vv_fail(VV_E_ARGUMENT, "%s: sigma is %g voxels along %c; it must be between 0 and %g", name,
                           sigma[a], "xyz"[a], most);
        if (info->grid.dims[a] == 1)
            sigma[a] = 0;
    }
    return VV_OK;
}
