/* Regions of a question: from the property that scenes keep to a shape on the grid, and what is told of it. */
#include "core/memory.h"
#include "core/vec.h"
#include "measure/region_samples.h"
#include "measuring/measuring.h"
#include "model/classes.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const vv_measured_region *region_of(const vv_measurement *m)
{
    return (const vv_measured_region *)(const void *)m->region;
}

bool vvi_measurement_has_region(const vv_measurement *m)
{
    return region_of(m)->kind != VV_REGION_NONE;
}

static const char *kind_name(const vv_measured_region *r)
{
    return vv_class_find(&vvi_measured_region_class, "kind")->names[r->kind];
}

static bool is_set(const vv_measured_region *r, const char *name)
{
    return vv_object_is_set(&r->base, name);
}

static vv_vec3 vertex(const vv_measured_region *r, size_t i)
{
    const double *v = r->outline->v + 3 * (i % (r->outline->n / 3));
    return vvi_vec(v[0], v[1], v[2]);
}

static size_t n_vertices(const vv_measured_region *r)
{
    return r->kind == VV_REGION_POLYGON && r->outline ? r->outline->n / 3 : 0;
}

/* Newell 1972, from the first corner: half of its length is the area. */
static vv_vec3 outline_normal(const vv_measured_region *r)
{
    vv_vec3 n = {0, 0, 0};
    for (size_t i = 1; i + 1 < n_vertices(r); i++)
        n = vvi_add(n, vvi_cross(vvi_sub(vertex(r, i), vertex(r, 0)), vvi_sub(vertex(r, i + 1), vertex(r, 0))));
    return n;
}

static vv_vec3 middle_of(const vv_measured_region *r)
{
    const size_t n = n_vertices(r);
    vv_vec3 sum = {0, 0, 0};
    for (size_t i = 0; i < n; i++)
        sum = vvi_add(sum, vvi_scaled(vertex(r, i), 1 / (double)n));
    return n ? sum : r->center;
}

static bool make_unit(vv_vec3 *v)
{
    const double length = vvi_length(*v);
    *v = vvi_scaled(*v, 1 / length);
    return length > 0 && isfinite(length);
}

/* Axes of length 1: right, up and normal. */
static vv_status find_axes(vv_affine *out, const vv_measured_region *r)
{
    vv_vec3 n = is_set(r, "normal") ? r->normal : n_vertices(r) ? outline_normal(r) : vvi_vec(0, 0, 1);
    if (!make_unit(&n))
        return is_set(r, "normal")
                   ? vv_fail(VV_E_ARGUMENT, "--normal: a direction is needed, and 0,0,0 is none")
                   : vv_fail(VV_E_ARGUMENT, "--vertex: the corners lie on one line; a polygon has an area");
    vv_vec3 right = fabs(n.x) <= fmax(fabs(n.y), fabs(n.z)) ? vvi_vec(1, 0, 0) : vvi_vec(0, 1, 0);
    right = is_set(r, "right") ? r->right : right;
    right = vvi_sub(right, vvi_scaled(n, vvi_dot(n, right)));
    if (!make_unit(&right))
        return vv_fail(VV_E_ARGUMENT, "--right: it points along --normal; it must lie in the plane of the region");
    *out = (vv_affine){.axis = {right, vvi_cross(n, right), n}, .origin = middle_of(r)};
    return VV_OK;
}

/* How thick a slice across n is: of each row of samples along the axis that is most across it, one is inside. */
static double one_step(const vv_affine *m, vv_vec3 n)
{
    return fmax(fmax(fabs(vvi_dot(m->axis[0], n)), fabs(vvi_dot(m->axis[1], n))), fabs(vvi_dot(m->axis[2], n)));
}

/* What is missing, or says nothing. */
static vv_status check(const vv_measured_region *r)
{
    const bool polygon = r->kind == VV_REGION_POLYGON, round = r->kind == VV_REGION_ELLIPSOID;
    if (polygon && n_vertices(r) < 3)
        return vv_fail(VV_E_ARGUMENT, "a polygon needs --vertex X,Y,Z three times or more; there are %zu",
                       n_vertices(r));
    if (!polygon && (!is_set(r, "center") || !is_set(r, "size")))
        return vv_fail(VV_E_ARGUMENT, "--region %s needs %s", kind_name(r),
                       is_set(r, "center") ? "--size X,Y,Z" : "--center X,Y,Z and --size X,Y,Z");
    if (!polygon && !(r->size.x > 0 && r->size.y > 0 && (r->size.z > 0 || (!round && r->size.z == 0))))
        return vv_fail(VV_E_ARGUMENT, "--size: expected three extents above 0%s, found %g,%g,%g",
                       round ? "" : ", of which the last may be 0, for one slice", r->size.x, r->size.y, r->size.z);
    return VV_OK;
}

static vv_status take_outline(double **out, vv_region_shape *shape, const vv_measured_region *r)
{
    const size_t n = n_vertices(r);
    double *v = *out = vvi_calloc(2 * n + 1, sizeof *v);
    for (size_t i = 0; v && i < n; i++) {
        const vv_vec3 p = vvi_sub(vertex(r, i), shape->frame.origin);
        v[2 * i] = vvi_dot(p, shape->frame.axis[0]);
        v[2 * i + 1] = vvi_dot(p, shape->frame.axis[1]);
    }
    shape->outline = v;
    shape->n_outline = n;
    return v ? VV_OK : vv_fail_memory(2 * n * sizeof *v);
}

vv_status vvi_measurement_shape(vv_region_shape *out, double **outline, const vv_measurement *m, const vv_affine *place)
{
    const vv_measured_region *r = region_of(m);
    const bool in_world = m->space == VV_MEASURE_IN_WORLD;
    const vv_affine steps = in_world ? *place : vv_affine_identity();
    *out = (vv_region_shape){.kind = (vv_region_kind)r->kind};
    vv_status st = check(r);
    if (st != VV_OK || (st = find_axes(&out->frame, r)) != VV_OK || (st = take_outline(outline, out, r)) != VV_OK)
        return st;
    const double depth = r->kind == VV_REGION_POLYGON ? r->thickness : r->size.z;
    out->half[0] = r->size.x / 2;
    out->half[1] = r->size.y / 2;
    out->half[2] = (depth > 0 ? depth : one_step(&steps, out->frame.axis[2])) / 2;
    if (!in_world)
        out->frame = vv_affine_compose(*place, out->frame);
    return VV_OK;
}

/* Telling --------------------------------------------------------------------------------------------------------- */

static void put(vvi_measuring *m, const char *key, double value, int power)
{
    vvi_figure f = {.key = key, .label = "", .value = value, .error = NAN};
    if (power)
        vvi_power_unit(f.unit, vv_field_get_info(m->field)->grid.unit, power);
    vvi_tell_figure_for(m->answer, &f, VV_FOR_ALL & ~VV_FOR_PEOPLE);
}

/* For people. area NaN: there is none, or none is known. */
static void tell_size(vvi_measuring *m, uint64_t n, double counted, double exact, double area)
{
    const char *unit = vv_field_get_info(m->field)->grid.unit;
    char text[VVI_FIGURE_TEXT], cube[32], square[32];
    vvi_power_unit(cube, unit, 3);
    vvi_power_unit(square, unit, 2);
    vvi_figure_print(text, counted, NAN, 0, cube);
    vvi_tell_line(m->answer, "region size", "%" PRIu64 " %s, %s", n, vvi_plural(n, "voxel", "voxels"), text);
    if (isnan(exact))
        return;
    vvi_figure_print(text, exact, NAN, 0, cube);
    vvi_tell_line(m->answer, "", "exactly %s", text);
    if (isnan(area))
        return;
    vvi_figure_print(text, area, NAN, 0, square);
    vvi_tell_line(m->answer, "", "outline %s", text);
}

vv_status vvi_measuring_take_region(vvi_measuring *m)
{
    if (!vvi_measurement_has_region(m->asked) || !vvi_measure_has_word(m->uses, "region"))
        return VV_OK;
    m->choice.region = &m->shape;
    return vvi_measurement_shape(&m->shape, &m->outline, m->asked, &vv_field_get_info(m->field)->grid.index_to_world);
}

void vvi_measuring_name_region(char out[64], const vvi_measuring *m)
{
    const vv_measured_region *r = region_of(m->asked);
    const char *name = m->choice.region ? kind_name(r) : "";
    if (r->kind == VV_REGION_POLYGON)
        snprintf(out, 64, "%s of %zu corners", name, n_vertices(r));
    else
        snprintf(out, 64, "%s", name);
}

vv_status vvi_measuring_put_region(vvi_measuring *m)
{
    const vv_grid *grid = &vv_field_get_info(m->field)->grid;
    vvi_region_samples shape;
    if (!m->choice.region)
        return VV_OK;
    const vv_status st = vvi_region_samples_init(&shape, grid, &m->shape);
    if (st != VV_OK)
        return st;
    const uint64_t n = vvi_region_samples_count(&shape);
    const double area = vv_region_shape_area(&m->shape);
    const double counted = (double)n * fabs(vv_affine_determinant(grid->index_to_world));
    const double exact = vv_region_shape_volume(&m->shape);
    put(m, "region_voxels", (double)n, 0);
    put(m, "region_volume", counted, 3);
    put(m, "region_volume_exact", exact, 3);
    if (m->shape.kind != VV_REGION_ELLIPSOID)
        put(m, "region_area_exact", area, 2);
    tell_size(m, n, counted, exact, area);
    if (m->shape.kind == VV_REGION_POLYGON && isnan(area))
        vvi_tell_note(m->answer,
                      "the polygon crosses itself: samples are inside that an odd number of its sides separates "
                      "from outside, and its exact area is not known");
    if (shape.beyond)
        vvi_tell_note(m->answer, "the region is partly outside the volume: only samples of the volume are counted");
    if (!n)
        vvi_tell_note(m->answer, "no voxel has its centre in the region");
    return VV_OK;
}

/* Meshes ---------------------------------------------------------------------------------------------------------- */

static vv_status check_of_mesh(const vv_measured_region *r)
{
    const bool polygon = r->kind == VV_REGION_POLYGON;
    const double depth = polygon ? r->thickness : r->size.z;
    if (r->kind == VV_REGION_ELLIPSE)
        return vv_fail(VV_E_ARGUMENT,
                       "--region %s: of a mesh, what lies in a box, a polygon or an ellipsoid is "
                       "measured: give one of them",
                       kind_name(r));
    if ((polygon || is_set(r, "size")) && !(depth > 0))
        return vv_fail(VV_E_ARGUMENT, "%s: a mesh has no slices, so that %s above 0; found %g",
                       polygon ? "--thickness" : "--size", polygon ? "it is" : "all three extents are", depth);
    return VV_OK;
}

static void tell_shape(vv_answer *a, const vv_measured_region *r, const vv_region_shape *shape, const char *unit)
{
    vvi_figure f = {.key = "region_volume_exact", .label = "", .value = vv_region_shape_volume(shape), .error = NAN};
    vvi_power_unit(f.unit, unit, 3);
    snprintf(a->region, sizeof a->region, "%s", kind_name(r));
    vvi_tell_text(a, "region", a->region);
    if (r->kind == VV_REGION_POLYGON)
        vvi_tell_line(a, "region", "polygon of %zu corners, %.6g %s thick", n_vertices(r), r->thickness, unit);
    else
        vvi_tell_line(a, "region", "%s of %.6g x %.6g x %.6g %s", kind_name(r), r->size.x, r->size.y, r->size.z, unit);
    vvi_tell_figure_for(a, &f, VV_FOR_ALL & ~VV_FOR_PEOPLE);
}

vv_status vvi_measuring_mesh_region(vv_region_shape *out, double **outline, const vvi_measuring *m)
{
    const vv_measured_region *r = region_of(m->asked);
    const vv_affine world = vv_affine_identity();
    *out = (vv_region_shape){.kind = VV_REGION_NONE};
    *outline = NULL;
    if (!vvi_measurement_has_region(m->asked))
        return VV_OK;
    vv_status st = check_of_mesh(r);
    if (st == VV_OK)
        st = vvi_measurement_shape(out, outline, m->asked, &world);
    if (st == VV_OK && isnan(vv_region_shape_volume(out)))
        st = vv_fail(VV_E_ARGUMENT, "--vertex: the polygon crosses itself: of a mesh what lies in one that does not is "
                                    "measured");
    if (st == VV_OK)
        tell_shape(m->answer, r, out,
                   m->input->mesh && !m->input->shown ? vv_mesh_get_info(m->input->mesh)->unit : m->input->unit);
    return st;
}
