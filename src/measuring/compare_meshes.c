/* Two meshes: what each is, and how far their surfaces lie from each other. */
#include "measure/mesh_difference.h"
#include "measuring/comparing.h"
#include <math.h>
#include <stdio.h>

static void tell_mesh(vv_answer *a, const char *key, const char *label, const vvi_mesh_about *about,
                      const vv_mesh_info *m)
{
    const vv_mesh_measures *f = &about->measures;
    const size_t n_pieces = about->topology.n_pieces;
    char area[VVI_FIGURE_TEXT], volume[VVI_FIGURE_TEXT] = "no volume";
    vvi_tell_open(a, key, "{");
    vvi_tell_count(a, "vertices", m->n_vertices);
    vvi_tell_count(a, "triangles", m->n_triangles);
    vvi_tell_count(a, "pieces", n_pieces);
    vvi_tell_bool(a, "closed", f->closed && m->n_triangles > 0);
    vvi_tell_number(a, "area", f->area.value);
    vvi_tell_number(a, "area_error", f->area.error);
    vvi_tell_number(a, "volume", f->volume.value);
    vvi_tell_number(a, "volume_error", f->volume.error);
    vvi_tell_numbers(a, "lo", &f->bounds.lo.x, 3);
    vvi_tell_numbers(a, "hi", &f->bounds.hi.x, 3);
    vvi_tell_text(a, "unit", m->unit);
    vvi_tell_close(a, "}");
    vvi_figure_print(area, f->area.value, f->area.error, 0, f->area.unit);
    if (!isnan(f->volume.value))
        vvi_figure_print(volume, f->volume.value, f->volume.error, 0, f->volume.unit);
    vvi_tell_line(a, label, "%zu %s, %zu %s, %zu %s; area %s, %s%s", m->n_vertices,
                  vvi_plural(m->n_vertices, "vertex", "vertices"), m->n_triangles,
                  vvi_plural(m->n_triangles, "triangle", "triangles"), n_pieces,
                  vvi_plural(n_pieces, "piece", "pieces"), area, isnan(f->volume.value) ? "" : "volume ", volume);
}

static void tell_length(vv_answer *a, const char *key, const char *label, const vv_figure *length, const char *unit)
{
    char text[VVI_FIGURE_TEXT], error[48];
    vvi_figure_print(text, length->value, length->error, 0, unit);
    snprintf(error, sizeof error, "%s_error", key);
    vvi_tell_number(a, key, length->value);
    vvi_tell_number(a, error, length->error);
    vvi_tell_line(a, label, "%s", text);
}

static void tell_distances(vv_answer *a, const vvi_mesh_difference *d, const char *unit)
{
    const vv_mesh_distances *far = &d->distance;
    tell_length(a, "distance", "least", &d->least, unit);
    tell_length(a, "a_to_b_mean", "A to B mean", &far->a_to_b.mean, unit);
    tell_length(a, "a_to_b_rms", "A to B rms", &far->a_to_b.rms, unit);
    tell_length(a, "a_to_b_max", "A to B max", &far->a_to_b.max, unit);
    tell_length(a, "b_to_a_mean", "B to A mean", &far->b_to_a.mean, unit);
    tell_length(a, "b_to_a_rms", "B to A rms", &far->b_to_a.rms, unit);
    tell_length(a, "b_to_a_max", "B to A max", &far->b_to_a.max, unit);
    tell_length(a, "hausdorff", "Hausdorff", &far->hausdorff, unit);
}

static void tell_sameness(vv_answer *a, const vvi_mesh_difference *d)
{
    vvi_tell_bool(a, "same_world", d->same_world);
    vvi_tell_bool(a, "same_topology", d->same_topology);
    vvi_tell_bool(a, "same_places", d->same_places);
    vvi_tell_bool(a, "same_data", d->same_data);
    vvi_tell_line(a, "vertices", d->same_places ? "at the same places, in the same order" : "differ");
    vvi_tell_line(a, "triangles", d->same_topology ? "the same, of the same vertices" : "differ");
    if (d->same_topology && !d->same_data)
        vvi_tell_line(a, "data", "normals, values or colours differ");
}

static void tell(vv_answer *a, const vvi_mesh_difference *d, const vv_mesh_info *m)
{
    const vv_mesh_info *other = vv_mesh_get_info(d->b);
    tell_mesh(a, "a", "A", &d->about[0], m);
    tell_mesh(a, "b", "B", &d->about[1], other);
    if (!d->same_world)
        vvi_tell_line(a, "world", "%s%s, %s%s", d->unit[0], m->space == VV_SPACE_RAS ? " RAS" : "", d->unit[1],
                      other->space == VV_SPACE_RAS ? " RAS" : "");
    tell_sameness(a, d);
    vvi_tell_number(a, "bounds_difference", d->bounds_difference);
    vvi_tell_line(a, "bounds", d->bounds_difference > 0 ? "corners are up to %g %s apart" : "the same",
                  d->bounds_difference, m->unit);
    tell_distances(a, d, m->unit);
    vvi_tell_number(a, "max_difference", d->distance.hausdorff.value);
    vvi_tell_text(a, "unit", m->unit);
}

/* The largest distance is found from below: what it leaves open is looked at once more. */
static vv_status judge(vvi_comparing *c, const vvi_mesh_difference *d, const vv_mesh *a)
{
    const vv_figure far = d->distance.hausdorff;
    const double limit = c->limits.max_difference;
    bool within = true;
    if (isnan(limit) || d->apart)
        return VV_OK;
    const vv_status st = vvi_mesh_within(&within, d, a, limit, c->job);
    if (st != VV_OK || within)
        return st;
    c->exceeded = true;
    vvi_tell_line(c->answer, "differs", "the largest distance is %g %s%s, the limit is at most %g",
                  far.value > limit ? far.value : far.value + far.error, vv_mesh_get_info(a)->unit,
                  far.value > limit ? "" : " at most", limit);
    return VV_OK;
}

vv_status vv_compare_meshes(vv_answer **out, bool *exceeded_out, const vv_mesh *a, const vv_mesh *b,
                            const vv_compare_limits *limits, vv_job *job)
{
    vvi_comparing c;
    vvi_mesh_difference d;
    vv_status st = vvi_comparing_begin(&c, out, limits, job);
    if (st != VV_OK)
        return st;
    if ((st = vvi_mesh_compare(&d, a, b, job)) == VV_OK) {
        vvi_tell_text(c.answer, "kind", "meshes");
        tell(c.answer, &d, vv_mesh_get_info(a));
        c.exceeded = d.apart;
        if (d.apart)
            vvi_tell_line(c.answer, "differs", "one has no triangles");
        st = judge(&c, &d, a);
    }
    if (st == VV_OK)
        vvi_comparing_verdict(&c, d.same_world && d.same_topology && d.same_places && d.same_data);
    vv_mesh_release(d.b);
    return vvi_comparing_end(&c, exceeded_out, st);
}
