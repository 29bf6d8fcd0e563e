#include "filter/window.h"
#include "core/status.h"

#include <math.h>

#define ROW_MOST 128 /* samples of a tile along x: long enough for vectors, short enough for the caches */

#define SIDE 16 /* of a wide tile along y and z, and twice the margin */

#define COLUMN_ROWS 16 /* at least: samples in the margin are worked on twice */
#define COLUMNS 4      /* at least, where there is room: no thread waits long for another */

enum { ROW_RADIUS, ROW_RADIUS_VOXELS };

static bool is_set(const vv_object *object, int row)
{
    return object->set >> row & 1;
}

static bool is_count(double v)
{
    return v >= 0 && v <= 1e6 && v == floor(v);
}

vv_status vvi_window_check(const vv_object *params, const char *path)
{
    const vv_vec3 v = ((const vvi_window_params *)params)->radius_voxels;
    if (is_set(params, ROW_RADIUS) && is_set(params, ROW_RADIUS_VOXELS))
        return vv_fail(VV_E_ARGUMENT, "%s: `radius` and `radius_voxels` set the same thing; give one of them",
                       params->cls->name);
    if (is_set(params, ROW_RADIUS_VOXELS) && !(is_count(v.x) && is_count(v.y) && is_count(v.z)))
        return vv_fail_at(VV_E_ARGUMENT, NULL, path,
                          "radius_voxels is [%g, %g, %g]; three whole numbers of at least 0 are needed", v.x, v.y, v.z);
    return VV_OK;
}

vv_status vvi_window_radius(int64_t radius[3], const vv_field_info *info, const vv_object *params, const char *name,
                            int64_t most)
{
    const vvi_window_params *p = (const vvi_window_params *)params;
    const double voxels[3] = {p->radius_voxels.x, p->radius_voxels.y, p->radius_voxels.z};
    const vv_status st = vvi_window_check(params, NULL);
    double samples = 1;
    if (st != VV_OK)
        return st;
    for (int a = 0; a < 3; a++) {
        double r = is_set(params, ROW_RADIUS_VOXELS) ? voxels[a]
                   : is_set(params, ROW_RADIUS)      ? floor(p->radius / vv_grid_spacing(&info->grid, a) + 0.5)
                                                     : 1;
        if (info->grid.dims[a] == 1)
            r = 0;
        samples *= 2 * r + 1;
        if (!(samples <= (double)most))
            return vv_fail(VV_E_ARGUMENT,
                           "%s: a window of %g voxels to each side along %c has too many samples; it may have %lld",
                           name, r, "xyz"[a], (long long)most);
        radius[a] = (int64_t)r;
    }
    return VV_OK;
}

vv_box vvi_window_reach(const vv_box *box, const int64_t radius[3], const int64_t dims[3])
{
    vv_box reach;
    for (int a = 0; a < 3; a++) {
        const int64_t end = box->lo[a] + box->n[a];
        reach.lo[a] = box->lo[a] > radius[a] ? box->lo[a] - radius[a] : 0;
        reach.n[a] = (end < dims[a] - radius[a] ? end + radius[a] : dims[a]) - reach.lo[a];
    }
    return reach;
}

static int64_t with_margin(const int64_t step[3], const int64_t radius[3])
{
    return (step[0] + 2 * radius[0]) * (step[1] + 2 * radius[1]) * (step[2] + 2 * radius[2]);
}

/* Along x first, then as square as it gets. */
vvi_slabs vvi_window_tiles(const vv_box *box, const int64_t radius[3], int64_t most)
{
    vvi_slabs s = {.box = *box, .step = {1, 1, 1}};
    if (box->n[0] < 1 || box->n[1] < 1 || box->n[2] < 1)
        return s;
    for (int64_t step = 2; step <= ROW_MOST && step <= box->n[0]; step++)
        if (with_margin((int64_t[3]){step, 1, 1}, radius) <= most)
            s.step[0] = step;
    for (bool grown = true; grown;) {
        grown = false;
        for (int a = 1; a < 3; a++) {
            s.step[a]++;
            if (s.step[a] <= box->n[a] && with_margin(s.step, radius) <= most)
                grown = true;
            else
                s.step[a]--;
        }
    }
    s.n = 1;
    for (int a = 0; a < 3; a++) {
        s.items[a] = (box->n[a] - 1) / s.step[a] + 1;
        s.n *= (size_t)s.items[a];
    }
    return s;
}

vvi_slabs vvi_window_wide_tiles(const vv_box *box, const int64_t radius[3])
{
    const int64_t side[2] = {SIDE + 4 * radius[1], SIDE + 4 * radius[2]};
    return vvi_window_tiles(box, radius, (ROW_MOST + 2 * radius[0]) * side[0] * side[1]);
}

static int64_t larger(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

static int64_t smaller(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

vvi_slabs vvi_window_columns(const vv_box *box, const int64_t radius[3], int64_t row, int64_t slice, int64_t rows_most)
{
    const int64_t *n = box->n;
    vvi_slabs s = {.box = *box};
    if (n[0] < 1 || n[1] < 1 || n[2] < 1)
        return s;
    s.step[0] = smaller(n[0], larger(1, row));
    const int64_t rows = smaller(larger(slice / s.step[0], radius[1]), rows_most);
    s.step[1] = larger(1, smaller(n[1], smaller(rows, larger((n[1] - 1) / COLUMNS + 1, COLUMN_ROWS))));
    s.items[0] = (n[0] - 1) / s.step[0] + 1;
    s.items[1] = (n[1] - 1) / s.step[1] + 1;
    const int64_t parts = (COLUMNS - 1) / (s.items[0] * s.items[1]) + 1;
    s.step[2] = smaller(n[2], larger((n[2] - 1) / parts + 1, 2 * radius[2] + 1));
    s.items[2] = (n[2] - 1) / s.step[2] + 1;
    s.n = (size_t)(s.items[0] * s.items[1] * s.items[2]);
    return s;
}
