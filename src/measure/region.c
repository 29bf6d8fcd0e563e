/* Convex regions of index space, row by row. */
#include "measure/region.h"

#include <math.h>
#include <string.h>

#define SLACK 1e-9 /* steps: a sample on a plane is inside, whatever rounding says */

static vv_status add(vvi_region *region, vv_vec3 normal, double offset)
{
    const double length = hypot(hypot(normal.x, normal.y), normal.z);
    if (!(length > 0) || !isfinite(length) || !isfinite(offset))
        return vv_fail(VV_E_ARGUMENT, "a cut plane's normal has no length, or its offset is not finite");
    region->plane[region->n++] = (vv_plane){{normal.x / length, normal.y / length, normal.z / length}, offset / length};
    return VV_OK;
}

/* n . (origin + M p) >= d is (M^T n) . p >= d - n . origin. The caller's normals are made unit first, as in scenes. */
static vv_status add_world(vvi_region *region, const vv_affine *m, const vv_plane *plane)
{
    const vv_vec3 n = plane->normal;
    const double length = hypot(hypot(n.x, n.y), n.z);
    vv_vec3 normal;
    double *const to[3] = {&normal.x, &normal.y, &normal.z};
    for (int a = 0; a < 3; a++)
        *to[a] = n.x * m->axis[a].x + n.y * m->axis[a].y + n.z * m->axis[a].z;
    const double at = n.x * m->origin.x + n.y * m->origin.y + n.z * m->origin.z;
    return add(region, normal, plane->offset * length - at);
}

static vv_status add_box(vvi_region *region, const vv_grid *grid, const vv_box *box, double margin)
{
    for (int a = 0; a < 3; a++) {
        const int64_t lo = box->lo[a], n = box->n[a];
        if (lo < 0 || n < 1 || lo > grid->dims[a] - n)
            return vv_fail(VV_E_ARGUMENT,
                           "the box has samples %lld to %lld along %c; there are 0 to %lld, and at least one is needed",
                           (long long)lo, (long long)(lo + n - 1), "xyz"[a], (long long)grid -> dims[a] - 1);
        const vv_vec3 up = {a == 0, a == 1, a == 2}, down = {-up.x, -up.y, -up.z};
        if (lo > 0)
            add(region, up, (double)lo - margin);
        if (lo + n < grid->dims[a])
            add(region, down, -((double)(lo + n - 1) + margin));
    }
    return VV_OK;
}

vv_status vvi_region_init(vvi_region *out, const vv_grid *grid, const vv_box *box, double margin,
                          const vv_plane *planes, size_t n_planes)
{
    vv_status st = VV_OK;
    out->n = 0;
    if (n_planes > VVI_REGION_PLANES - 6)
        return vv_fail(VV_E_ARGUMENT, "%zu cut planes are more than the %d that can be measured with", n_planes,
                       VVI_REGION_PLANES - 6);
    if (box->n[0] || box->n[1] || box->n[2])
        st = add_box(out, grid, box, margin);
    for (size_t i = 0; i < n_planes && st == VV_OK; i++)
        st = add_world(out, &grid->index_to_world, &planes[i]);
    return st;
}

/* a i >= b for the i of an interval. */
static void cut(vvi_interval *row, double a, double b)
{
    if (fabs(a) < 1e-14) {
        if (b > SLACK)
            row->end = row->lo;
        return;
    }
    const double at = b / a, slack = SLACK / fabs(a) < 0.25 ? SLACK / fabs(a) : 0.25;
    if (a > 0 && ceil(at - slack) > (double)row->lo)
        row->lo = at > (double)row->end ? row->end : (int64_t)ceil(at - slack);
    if (a < 0 && floor(at + slack) + 1 < (double)row->end)
        row->end = at < (double)row->lo - 1 ? row->lo : (int64_t)floor(at + slack) + 1;
}

static vvi_interval whole_row(int64_t lo, int64_t end)
{
    return (vvi_interval){lo, end > lo ? end : lo};
}

static void tidy(vvi_interval *row)
{
    if (row->end < row->lo)
        row->end = row->lo;
}

vvi_interval vvi_region_points(const vvi_region *region, vv_vec3 at, int64_t j, int64_t k, int64_t lo, int64_t end)
{
    vvi_interval row = whole_row(lo, end);
    for (int p = 0; p < region->n; p++) {
        const vv_vec3 n = region->plane[p].normal;
        cut(&row, n.x, region->plane[p].offset - n.x * at.x - n.y * ((double)j + at.y) - n.z * ((double)k + at.z));
        tidy(&row);
    }
    return row;
}

/* The corner of a cell that lies deepest below a plane, or farthest above it. */
static double extreme(double n, bool highest)
{
    return highest == (n > 0) ? n : 0;
}

vvi_interval vvi_region_cells(const vvi_region *region, bool touched, int64_t j, int64_t k, int64_t lo, int64_t end)
{
    vvi_interval row = whole_row(lo, end);
    for (int p = 0; p < region->n; p++) {
        const vv_vec3 n = region->plane[p].normal;
        const double corner = extreme(n.x, touched) + extreme(n.y, touched) + extreme(n.z, touched);
        const double offset = region->plane[p].offset + 3 * SLACK; /* cells beside a plane are cut by it, or outside */
        cut(&row, n.x, offset - corner - n.y * (double)j - n.z * (double)k);
        tidy(&row);
    }
    return row;
}

vvi_region vvi_region_coarse(const vvi_region *region, int64_t step)
{
    vvi_region coarse = *region;
    for (int p = 0; p < coarse.n; p++)
        coarse.plane[p].offset /= (double)step;
    return coarse;
}
