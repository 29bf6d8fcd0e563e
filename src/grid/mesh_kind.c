/* The data kind of triangles: no samples fill space, so fields are never of it. */
#include "registry.h"

static bool accepts(const vv_field_info *info)
{
    (void)info;
    return false;
}

const vv_data_kind vvi_data_kind_mesh = {
    .api = VV_DATA_KIND_API,
    .name = "mesh",
    .doc = "triangles of a mesh file; drawn by method surface",
    .accepts = accepts,
};
