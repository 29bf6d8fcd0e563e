/* What of a mesh is in a region: boxes and polygons are planes that cut it, ellipsoids have a closed form. */
#include "core/memory.h"
#include "core/vec.h"
#include "measuring/meshes.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The faces of the box around an ellipsoid, as a share of it away: they meet it nowhere. */
#define AROUND (1 + 1e-6)

static double wider(const vv_region_shape *r)
{
    return r->kind == VV_REGION_ELLIPSOID ? AROUND : 1;
}

/* An outline that is as thick along z as the region is: rows of x and y. */
typedef struct outline {
    const double *v;
    size_t n;
} outline;

/* Twice the area between the origin's corner, i and the one after it: above 0 where they turn left. */
static double turn(const outline *o, size_t at, size_t i, size_t j)
{
    const double *a = o->v + 2 * (at % o->n), *p = o->v + 2 * (i % o->n), *q = o->v + 2 * (j % o->n);
    return (p[0] - a[0]) * (q[1] - a[1]) - (p[1] - a[1]) * (q[0] - a[0]);
}

/* Of one that does not cross itself: it turns one way at all corners. */
static bool is_convex(const outline *o)
{
    bool left = false, right = false;
    for (size_t i = 0; i < o->n; i++) {
        left |= turn(o, i, i + 1, i + 2) > 0;
        right |= turn(o, i, i + 1, i + 2) < 0;
    }
    return !left || !right;
}

/* Of an ellipsoid that of the box around it: where the mesh is open farther away is of no matter. */
static outline outline_of(double box[8], const vv_region_shape *r)
{
    const double x = wider(r) * r->half[0], y = wider(r) * r->half[1], corners[8] = {-x, -y, x, -y, x, y, -x, y};
    memcpy(box, corners, sizeof corners);
    return r->kind == VV_REGION_POLYGON ? (outline){r->outline, r->n_outline} : (outline){box, 4};
}

/* Whether planes alone bound it, so that its box is found. */
static bool has_box(const vv_region_shape *r)
{
    double box[8];
    const outline o = outline_of(box, r);
    return r->kind == VV_REGION_NONE || (r->kind != VV_REGION_ELLIPSOID && is_convex(&o));
}

vv_status vvi_measuring_check_mesh_region(const vvi_measuring *m, const vv_region_shape *region)
{
    const bool polygon = region->kind == VV_REGION_POLYGON;
    if (has_box(region))
        return VV_OK;
    if (m->asked->closed)
        return vv_fail(VV_E_ARGUMENT,
                       "--closed: the faces where %s cuts a mesh are not measured: use a box or a convex "
                       "polygon",
                       polygon ? "a polygon with dents" : "an ellipsoid");
    if (!(m->what & VVI_BOX))
        return VV_OK;
    if (m->what == VVI_BOX)
        return vv_fail(VV_E_ARGUMENT,
                       "--region %s: of a mesh, area and volume in %s are measured, and its box and "
                       "centroid in a box or a convex polygon",
                       polygon ? "polygon" : "ellipsoid", polygon ? "one with dents" : "it");
    vvi_tell_note(m->answer, "box and centroid are not measured in %s, only area and volume",
                  polygon ? "a polygon with dents" : "an ellipsoid");
    return VV_OK;
}

/* Sides, lower and upper face of a convex prism, which keep what is inside. */
static size_t prism_planes(vv_plane *out, const vv_region_shape *r, const outline *o)
{
    const vv_affine *f = &r->frame;
    const bool left = turn(o, 0, 1, 2) > 0 || (o->n > 3 && turn(o, 1, 2, 3) > 0);
    size_t n = 0;
    for (size_t i = 0; i < o->n; i++) {
        const double *p = o->v + 2 * (left ? i : (i + 1) % o->n), *q = o->v + 2 * (left ? (i + 1) % o->n : i);
        vv_vec3 inwards = vvi_add(vvi_scaled(f->axis[0], p[1] - q[1]), vvi_scaled(f->axis[1], q[0] - p[0]));
        if (!(vvi_length(inwards) > 0))
            continue;
        vvi_unit(&inwards);
        out[n++] = (vv_plane){inwards, vvi_dot(inwards, vv_affine_point(*f, vvi_vec(p[0], p[1], 0)))};
    }
    const double middle = vvi_dot(f->axis[2], f->origin), half = wider(r) * r->half[2];
    out[n++] = (vv_plane){f->axis[2], middle - half};
    out[n++] = (vv_plane){vvi_scaled(f->axis[2], -1), -middle - half};
    return n;
}

/* Of what is in the prism: all, or what is in the ellipsoid. */
static vv_status measure_prism(vv_mesh_measures *out, const vv_measured_data *data, const vv_region_shape *r,
                               const outline *o, bool open, bool closed, vv_job *job)
{
    const vv_region_shape *ellipsoid = r->kind == VV_REGION_ELLIPSOID ? r : NULL;
    vv_measured_data within = *data;
    vv_plane *planes = calloc(data->n_planes + o->n + 2, sizeof *planes);
    if (!planes)
        return vv_fail_memory((data->n_planes + o->n + 2) * sizeof *planes);
    for (size_t i = 0; i < data->n_planes; i++)
        planes[i] = data->planes[i];
    within.planes = planes;
    within.n_planes = data->n_planes + prism_planes(planes + data->n_planes, r, o);
    const vv_status st = vvi_measure_cut_mesh(out, &within, ellipsoid, open, closed, job);
    free(planes);
    return st;
}

static void add_signed(vv_mesh_measures *sum, const vv_mesh_measures *part, double sign)
{
    sum->n_triangles += sign > 0 ? part->n_triangles : 0;
    sum->area.value += sign * part->area.value;
    sum->area.error += part->area.error;
    sum->volume.value += sign * part->volume.value;
    sum->volume.error += part->volume.error;
    sum->closed &= part->closed;
    sum->inside_out |= part->inside_out;
    sum->n_open_edges += part->n_open_edges;
    sum->n_turned_edges += part->n_turned_edges;
}

/* With dents: triangles from one corner, of which those that turn the other way are taken off again. */
static vv_status measure_dented(vv_mesh_measures *out, const vv_measured_data *data, const vv_region_shape *r,
                                const outline *o, bool open, vv_job *job)
{
    vv_mesh_measures part;
    vv_status st = VV_OK;
    double whole = 0;
    bool any = false;
    for (size_t i = 1; i + 1 < o->n; i++)
        whole += turn(o, 0, i, i + 1);
    for (size_t i = 1; i + 1 < o->n && st == VV_OK; i++) {
        const double *v = o->v, corners[6] = {v[0], v[1], v[2 * i], v[2 * i + 1], v[2 * i + 2], v[2 * i + 3]};
        const outline triangle = {corners, 3};
        const double sign = turn(o, 0, i, i + 1) * whole;
        if (sign == 0 || (st = measure_prism(&part, data, r, &triangle, open, false, job)) != VV_OK)
            continue;
        if (!any) {
            *out = part;
            out->n_triangles = out->n_open_edges = out->n_turned_edges = 0;
            out->area.value = out->area.error = out->volume.value = out->volume.error = 0;
        }
        any = true;
        add_signed(out, &part, sign > 0 ? 1 : -1);
    }
    if (st != VV_OK)
        return st;
    out->area.value = fmax(0, out->area.value);
    if (out->closed)
        out->volume.value = fmax(0, out->volume.value);
    vvi_mesh_measures_drop_box(out);
    return VV_OK;
}

vv_status vvi_measure_in_region(vv_mesh_measures *out, const vv_measured_data *data, const vv_region_shape *region,
                                bool open, bool closed, vv_job *job)
{
    double box[8];
    if (region->kind == VV_REGION_NONE)
        return vvi_measure_cut_mesh(out, data, NULL, open, closed, job);
    const outline o = outline_of(box, region);
    return is_convex(&o) ? measure_prism(out, data, region, &o, open, closed, job)
                         : measure_dented(out, data, region, &o, open, job);
}
