/* Area, volume and box of meshes. */
#include "measuring/meshes.h"
#include <math.h>

static void put_place(vv_answer *a, const vv_mesh_measures *m, const char *unit)
{
    const bool empty = m->bounds.lo.x > m->bounds.hi.x;
    const vv_vec3 none = {NAN, NAN, NAN}, lo = empty ? none : m->bounds.lo, hi = empty ? none : m->bounds.hi;
    const double centre[3] = {m->centroid[0].value, m->centroid[1].value, m->centroid[2].value};
    const double size[3] = {hi.x - lo.x, hi.y - lo.y, hi.z - lo.z};
    const double error[3] = {m->centroid[0].error, m->centroid[1].error, m->centroid[2].error};
    vvi_tell_place(a, "centroid", centre, error, unit);
    vvi_tell_numbers(a, "centroid_error", error, 3);
    vvi_tell_place(a, "box_lo", (double[]){lo.x, lo.y, lo.z}, NULL, unit);
    vvi_tell_place(a, "box_hi", (double[]){hi.x, hi.y, hi.z}, NULL, unit);
    vvi_tell_place(a, "box_size", size, NULL, unit);
    char text[VVI_FIGURE_TEXT];
    vvi_place_print(text, centre, error);
    if (!isnan(centre[0]))
        vvi_tell_line(a, "centroid", "%s %s", text, unit);
    if (empty) {
        vvi_tell_line(a, "box", "empty");
        return;
    }
    vvi_tell_line(a, "box", "%.6g .. %.6g, %.6g .. %.6g, %.6g .. %.6g %s", lo.x, hi.x, lo.y, hi.y, lo.z, hi.z, unit);
    vvi_tell_line(a, "", "%.6g x %.6g x %.6g %s", size[0], size[1], size[2], unit);
}

void vvi_mesh_measures_put(vv_answer *a, unsigned what, const vv_mesh_measures *m, const char *unit)
{
    vvi_tell_text(a, "unit", unit);
    vvi_tell_text(a, "method", "triangles");
    vvi_tell_count(a, "triangles", m->n_triangles);
    vvi_tell_bool(a, "closed", m->closed);
    vvi_tell_count(a, "turned_edges", m->n_turned_edges);
    if (what == VVI_EXTENT)
        vvi_tell_line(a, "mesh", "%zu %s, %s", m->n_triangles, vvi_plural(m->n_triangles, "triangle", "triangles"),
                      !m->n_triangles                        ? "empty"
                      : m->closed                            ? "closed"
                      : m->n_turned_edges == m->n_open_edges ? "no holes, but turned triangles: it has no volume"
                                                             : "open: it has no volume");
    if (what & VVI_AREA)
        vvi_tell(a, "area", "area", m->area.value, m->area.error, m->area.unit);
    if ((what & VVI_VOLUME) && (m->closed || what != VVI_EXTENT))
        vvi_tell(a, "volume", "volume", m->volume.value, m->volume.error, m->volume.unit);
    if ((what & VVI_BOX) && !isnan(m->bounds.lo.x))
        put_place(a, m, unit);
    if (m->inside_out)
        vvi_tell_note(a, "the triangles face inwards; the volume is given as if they faced outwards");
}

void vvi_mesh_measures_drop_box(vv_mesh_measures *measures)
{
    const vv_vec3 none = {NAN, NAN, NAN};
    measures->bounds = (vv_bounds){none, none};
    for (int a = 0; a < 3; a++)
        measures->centroid[a].value = measures->centroid[a].error = NAN;
}

void vvi_measuring_note_no_triangles(vvi_measuring *m, const vv_mesh_measures *found)
{
    if (found->n_triangles == 0 && !(found->volume.value > 0))
        vvi_tell_note(m->answer, "nothing of the mesh %s: the object is empty",
                      vvi_measurement_has_region(m->asked) ? "lies in the region" : "is left");
}

vv_status vvi_measure_mesh(vvi_measuring *m)
{
    vv_measured_data own = *m->input;
    vv_mesh_measures found;
    vv_region_shape region;
    own.place = vv_affine_identity();
    own.unit = vv_mesh_get_info(own.mesh)->unit;
    own.n_planes = 0;
    vv_status st = vvi_measuring_mesh_region(&region, &m->outline, m);
    if (st == VV_OK && (st = vvi_measuring_check_mesh_region(m, &region)) == VV_OK)
        st = vvi_measure_in_region(&found, &own, &region, m->what != VVI_VOLUME, false, m->job);
    if (st != VV_OK)
        return st;
    vvi_mesh_measures_put(m->answer, m->what, &found, own.unit);
    vvi_measuring_note_no_triangles(m, &found);
    return VV_OK;
}
