#include "grid/turned_grid.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

#define SAME_LINE 1e-6 /* of 1 - |cosine|: files round directions to 32 bits */

/* 1 along, -1 against, 0 neither. */
static int runs(vv_vec3 a, vv_vec3 b)
{
    const double cosine = vvi_dot(a, b) / (vvi_length(a) * vvi_length(b));
    return fabs(cosine) < 1 - SAME_LINE ? 0 : cosine > 0 ? 1 : -1;
}

static bool find_turn(vvi_grid_fit *turn, const vv_grid *a, const vv_grid *b)
{
    for (int i = 0; i < 3; i++) {
        int sign = 0, from = -1;
        while (!sign && ++from < 3)
            sign = runs(a->index_to_world.axis[i], b->index_to_world.axis[from]);
        if (!sign)
            return false;
        turn->axis[i] = from;
        turn->sign[i] = sign;
        turn->first[i] = sign > 0 ? 0 : b->dims[from] - 1;
    }
    return true;
}

static bool is_turned(const vvi_grid_fit *turn)
{
    for (int i = 0; i < 3; i++)
        if (turn->axis[i] != i || turn->sign[i] < 0)
            return true;
    return false;
}

vvi_axes vvi_axes_compare(vvi_grid_fit *turn, const vv_grid *a, const vv_grid *b)
{
    static const vvi_grid_fit as_it_is = {.axis = {0, 1, 2}, .sign = {1, 1, 1}};
    char letters_a[16], letters_b[16];
    *turn = as_it_is;
    if (a->space != b->space)
        return VVI_AXES_SAME; /* nobody knows which goes with which */
    if (find_turn(turn, a, b))
        return is_turned(turn) ? VVI_AXES_TURNED : VVI_AXES_SAME;
    *turn = as_it_is;
    vv_grid_orientation(letters_a, a);
    vv_grid_orientation(letters_b, b);
    return strcmp(letters_a, letters_b) == 0 ? VVI_AXES_SAME : VVI_AXES_OTHER;
}

void vvi_turn_print(char out[8], const vvi_grid_fit *turn)
{
    for (int i = 0; i < 3; i++) {
        out[2 * i] = turn->sign[i] > 0 ? '+' : '-';
        out[2 * i + 1] = "xyz"[turn->axis[i]];
    }
    out[6] = 0;
}

vv_grid vvi_grid_turned(const vv_grid *grid, const vvi_grid_fit *turn)
{
    vv_grid turned = *grid;
    vv_vec3 first = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        turned.dims[i] = grid->dims[turn->axis[i]];
        turned.index_to_world.axis[i] = vvi_scaled(grid->index_to_world.axis[turn->axis[i]], turn->sign[i]);
        (&first.x)[turn->axis[i]] = (double)turn->first[i];
    }
    turned.index_to_world.origin = vv_affine_point(grid->index_to_world, first);
    return turned;
}
