#include "grid/slice_axes.h"
#include "grid/field.h"

const vvi_slice_axes *vvi_slice_axes_of(vv_space space)
{
    static const vvi_slice_axes anatomical[] = {{2, 0, -1, 1, 1}, {1, 0, -1, 2, 1}, {0, 1, -1, 2, 1}};
    static const vvi_slice_axes plain[] = {{2, 0, 1, 1, -1}, {1, 0, 1, 2, 1}, {0, 1, 1, 2, 1}};
    return space == VV_SPACE_RAS ? anatomical : plain;
}

void vvi_grid_index_axes(int index_axis[3], int sign_out[3], const vv_grid *grid)
{
    int world_axis[3], sign[3];
    vvi_grid_main_axes(world_axis, sign, grid);
    for (int a = 0; a < 3; a++) {
        index_axis[world_axis[a]] = a;
        sign_out[world_axis[a]] = sign[a];
    }
}
