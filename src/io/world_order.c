#include "io/world_order.h"
#include "grid/field.h"
#include <math.h>

static vv_vec3 times(vv_vec3 v, double by)
{
    return (vv_vec3){v.x * by, v.y * by, v.z * by};
}

/* half_turn: x and y run against those of the world. */
static bool is_straight(const vv_grid *grid, bool half_turn, double stray)
{
    for (int a = 0; a < 3; a++) {
        const vv_vec3 v = grid->index_to_world.axis[a];
        const double along[3] = {v.x, v.y, v.z};
        for (int w = 0; w < 3; w++)
            if (w == a ? !(half_turn && w < 2 ? along[w] < 0 : along[w] > 0)
                       : !(fabs(along[w]) <= stray * fabs(along[a])))
                return false;
    }
    return true;
}

static vvi_turn turned(const vv_grid *grid, const int axis[3], const bool back[3], bool half_turn, double stray)
{
    vvi_turn t = {.grid = *grid};
    vv_vec3 first = {0, 0, 0};
    for (int a = 0; a < 3; a++) {
        const vv_vec3 step = grid->index_to_world.axis[axis[a]];
        t.axis[a] = axis[a];
        t.back[a] = back[a];
        t.grid.dims[a] = grid->dims[axis[a]];
        t.grid.index_to_world.axis[a] = back[a] ? times(step, -1) : step;
        const double last = back[a] ? (double)(t.grid.dims[a] - 1) : 0;
        (&first.x)[axis[a]] = last;
    }
    t.grid.index_to_world.origin = vv_affine_point(grid->index_to_world, first);
    t.straight = is_straight(&t.grid, half_turn, stray);
    t.mirrored = vv_affine_determinant(t.grid.index_to_world) < 0;
    return t;
}

vvi_turn vvi_turn_to_world(const vv_grid *grid, double stray)
{
    int world[3], sign[3], axis[3];
    bool back[3];
    vvi_grid_main_axes(world, sign, grid);
    for (int a = 0; a < 3; a++) {
        axis[world[a]] = a;
        back[world[a]] = sign[a] < 0;
    }
    return turned(grid, axis, back, false, stray);
}

vvi_turn vvi_turn_pages(const vv_grid *grid, double stray)
{
    static const int same[3] = {0, 1, 2};
    static const bool forward[3] = {false, false, false};
    const vvi_turn t = vvi_turn_to_world(grid, stray);
    if (grid->dims[2] == 1 && t.axis[2] != 2)
        return turned(grid, same, forward, false, stray);
    if (grid->space == VV_SPACE_RAS && t.axis[0] == 0 && t.axis[1] == 1 && t.back[0] && t.back[1])
        return turned(grid, same, (const bool[3]){false, false, t.back[2]}, true, stray);
    return t;
}

vvi_turn vvi_turn_upright(const vv_grid *grid, double stray)
{
    const vvi_turn t = vvi_turn_pages(grid, stray);
    const vv_vec3 right = t.grid.index_to_world.axis[0], down = t.grid.index_to_world.axis[1];
    const bool axial = t.axis[2] == 2 || grid->dims[2] > 1;
    if (grid->space != VV_SPACE_RAS || !axial || right.x < 0 || down.y < 0)
        return t;
    return turned(grid, t.axis, (const bool[3]){!t.back[0], !t.back[1], t.back[2]}, true, stray);
}

const uint8_t *vvi_turn_brick(int64_t step_out[3], const vvi_turn *turn, const vv_brick *brick)
{
    const uint8_t *first = brick->data;
    for (int a = 0; a < 3; a++) {
        const int64_t step = brick->stride[turn->axis[a]];
        step_out[a] = turn->back[a] ? -step : step;
        first += turn->back[a] ? (brick->box.n[turn->axis[a]] - 1) * step : 0;
    }
    return first;
}

vv_box vvi_turn_slices(const vvi_turn *turn, int64_t first, int64_t n)
{
    vv_box box = {{0, 0, 0}, {0, 0, 0}};
    for (int a = 0; a < 3; a++)
        box.n[turn->axis[a]] = turn->grid.dims[a];
    box.n[turn->axis[2]] = n;
    box.lo[turn->axis[2]] = turn->back[2] ? turn->grid.dims[2] - first - n : first;
    return box;
}
