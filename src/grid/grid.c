/* Where a regular grid lies: spacing, bounds, orientation, crops. */
#include "grid/field.h"

#include <math.h>
#include <string.h>

static double length(vv_vec3 v)
{
    return hypot(hypot(v.x, v.y), v.z);
}

double vv_grid_spacing(const vv_grid *grid, int axis)
{
    return length(grid->index_to_world.axis[axis]);
}

double vv_grid_voxel(const vv_grid *grid)
{
    double smallest = INFINITY, smallest_of_all = INFINITY;
    for (int a = 0; a < 3; a++) {
        const double s = vv_grid_spacing(grid, a);
        smallest_of_all = fmin(smallest_of_all, s);
        if (grid->dims[a] > 1)
            smallest = fmin(smallest, s);
    }
    return isfinite(smallest) ? smallest : smallest_of_all;
}

vv_bounds vvi_grid_box_bounds(const vv_grid *grid, const double lo[3], const double hi[3])
{
    vv_bounds b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int corner = 0; corner < 8; corner++) {
        const vv_vec3 index = {corner & 1 ? hi[0] : lo[0], corner & 2 ? hi[1] : lo[1], corner & 4 ? hi[2] : lo[2]};
        const vv_vec3 p = vv_affine_point(grid->index_to_world, index);
        b.lo = (vv_vec3){fmin(b.lo.x, p.x), fmin(b.lo.y, p.y), fmin(b.lo.z, p.z)};
        b.hi = (vv_vec3){fmax(b.hi.x, p.x), fmax(b.hi.y, p.y), fmax(b.hi.z, p.z)};
    }
    return b;
}

vv_bounds vv_grid_bounds(const vv_grid *grid)
{
    const double lo[3] = {0, 0, 0};
    const double hi[3] = {(double)(grid->dims[0] - 1), (double)(grid->dims[1] - 1), (double)(grid->dims[2] - 1)};
    return vvi_grid_box_bounds(grid, lo, hi);
}

/* The permutation with the largest sum of |cosines|. */
void vvi_grid_main_axes(int world_axis[3], int sign[3], const vv_grid *grid)
{
    static const int permutations[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    double cosine[3][3];
    for (int a = 0; a < 3; a++) {
        const vv_vec3 v = grid->index_to_world.axis[a];
        const double s = length(v);
        const double row[3] = {v.x, v.y, v.z};
        for (int w = 0; w < 3; w++)
            cosine[a][w] = s > 0 ? row[w] / s : 0;
    }
    double best = -1;
    for (int p = 0; p < 6; p++) {
        const int *q = permutations[p];
        const double sum = fabs(cosine[0][q[0]]) + fabs(cosine[1][q[1]]) + fabs(cosine[2][q[2]]);
        if (sum > best + 1e-9) { /* of equals the first, whatever the rounding */
            best = sum;
            memcpy(world_axis, q, 3 * sizeof *q);
        }
    }
    for (int a = 0; a < 3; a++)
        sign[a] = cosine[a][world_axis[a]] < 0 ? -1 : 1;
}

void vv_grid_orientation(char out[16], const vv_grid *grid)
{
    int world_axis[3], sign[3];
    vvi_grid_main_axes(world_axis, sign, grid);
    char *p = out;
    for (int a = 0; a < 3; a++) {
        const bool forward = sign[a] > 0;
        if (grid->space == VV_SPACE_RAS) {
            *p++ = (forward ? "RAS" : "LPI")[world_axis[a]];
        } else {
            *p++ = forward ? '+' : '-';
            *p++ = "xyz"[world_axis[a]];
        }
    }
    *p = 0;
}

vv_grid vv_grid_crop(const vv_grid *grid, const vv_box *box)
{
    vv_grid part = *grid;
    const vv_vec3 corner = {(double)box->lo[0], (double)box->lo[1], (double)box->lo[2]};
    part.index_to_world.origin = vv_affine_point(grid->index_to_world, corner);
    memcpy(part.dims, box->n, sizeof part.dims);
    return part;
}
