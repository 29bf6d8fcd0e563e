/* What a mesh is: its size, its edges, its area and volume. */
#include "about/about.h"
#include "core/memory.h"
#include "grid/info_text.h"
#include <math.h>
#include <volvis/measure_mesh.h>

static void tell_part_keys(vv_answer *a, const vv_mesh_info *m)
{
    vvi_tell_open(a, "parts", "[");
    for (size_t i = 0; i < m->n_parts; i++) {
        const vv_mesh_part *part = &m->parts[i];
        vvi_tell_open(a, NULL, "{");
        vvi_tell_text(a, "name", part->name);
        vvi_tell_count(a, "triangles", part->n_triangles);
        if (part->color.a >= 0)
            vvi_tell_numbers(a, "color", &part->color.r, 4);
        vvi_tell_close(a, "}");
    }
    vvi_tell_close(a, "]");
}

static bool has_area(const vv_mesh_info *m, const vv_mesh_topology *t)
{
    return m->n_triangles > t->n_degenerate;
}

static void tell_keys(vv_answer *a, const vv_mesh_info *m, const vv_mesh_topology *t, const vv_mesh_measures *measures)
{
    vvi_tell_count(a, "vertices", m->n_vertices);
    vvi_tell_count(a, "triangles", m->n_triangles);
    vvi_tell_bool(a, "normals", m->normals != NULL);
    vvi_tell_bool(a, "values", m->values != NULL);
    vvi_tell_bool(a, "colors", m->colors != NULL);
    vvi_tell_bool(a, "coordinates", m->coordinates != NULL);
    vvi_tell_count(a, "textures", m->n_textures);
    vvi_tell_text(a, "value_name", m->value_name);
    vvi_tell_text(a, "value_unit", m->value_unit);
    tell_part_keys(a, m);
    vvi_tell_numbers(a, "lo", &measures->bounds.lo.x, 3);
    vvi_tell_numbers(a, "hi", &measures->bounds.hi.x, 3);
    vvi_tell_text(a, "unit", m->unit);
    vvi_tell_text(a, "space", m->space == VV_SPACE_RAS ? "RAS" : "plain");
    vvi_tell_bool(a, "closed", has_area(m, t) && t->n_open_edges + t->n_crowded_edges + t->n_turned_edges == 0);
    vvi_tell_count(a, "edges", t->n_edges);
    vvi_tell_count(a, "open_edges", t->n_open_edges);
    vvi_tell_count(a, "crowded_edges", t->n_crowded_edges);
    vvi_tell_count(a, "turned_edges", t->n_turned_edges);
    vvi_tell_count(a, "degenerate_triangles", t->n_degenerate);
    vvi_tell_count(a, "unused_vertices", t->n_unused);
    vvi_tell_count(a, "pieces", t->n_pieces);
    vvi_tell_number(a, "area", measures->area.value);
    vvi_tell_number(a, "volume", measures->volume.value);
    vvi_tell_bool(a, "inside_out", measures->inside_out);
}

static void tell_parts(vv_answer *a, const vv_mesh_info *m)
{
    enum { SHOWN = 20 };
    for (size_t i = 0; i < m->n_parts && i < SHOWN; i++)
        vvi_tell_line(a, i ? "" : "parts", "%s: %zu %s", m->parts[i].name[0] ? m->parts[i].name : "(no name)",
                      m->parts[i].n_triangles, vvi_plural(m->parts[i].n_triangles, "triangle", "triangles"));
    if (m->n_parts > SHOWN)
        vvi_tell_line(a, "", "and %zu more (--json lists them)", m->n_parts - SHOWN);
}

static void tell_textures(vv_answer *a, const vv_mesh_info *m)
{
    enum { SHOWN = 8 };
    for (size_t i = 0; i < m->n_textures && i < SHOWN; i++) {
        const vv_mesh_texture *t = &m->textures[i];
        vvi_tell_line(a, i ? "" : "images", "%s: %d x %d pixels", t->name[0] ? t->name : "(no name)", t->width,
                      t->height);
    }
    if (m->n_textures > SHOWN)
        vvi_tell_line(a, "", "and %zu more", m->n_textures - SHOWN);
}

/* Vertices of a seam are two at one place: the edges there are open, and yet nothing gapes. */
static void tell_closed(vv_answer *a, const vv_mesh_topology *t, bool has_area, bool no_gap)
{
    const char *ending = t->n_pieces == 1 ? "" : "s";
    if (!has_area)
        vvi_tell_line(a, "closed", "no: there is no triangle that has an area");
    else if (t->n_edges > 0 && t->n_open_edges + t->n_crowded_edges + t->n_turned_edges == 0)
        vvi_tell_line(a, "closed", "yes: every edge joins two triangles; %zu piece%s", t->n_pieces, ending);
    else if (t->n_edges > 0 && t->n_open_edges + t->n_crowded_edges == 0)
        vvi_tell_line(a, "closed", "no: there are no holes, but triangles that face the wrong way; %zu piece%s",
                      t->n_pieces, ending);
    else if (no_gap && t->n_open_edges == 0)
        vvi_tell_line(a, "closed", "yes, without a gap, but it touches itself; %zu piece%s", t->n_pieces, ending);
    else if (no_gap)
        vvi_tell_line(a, "closed",
                      "yes, without a gap, but in %zu piece%s that share no vertices: %zu edges lie along seams",
                      t->n_pieces, ending, t->n_open_edges);
    else if (t->n_open_edges == 0)
        vvi_tell_line(a, "closed", "no: %zu edge%s of three or more triangles; %zu piece%s", t->n_crowded_edges,
                      t->n_crowded_edges == 1 ? "" : "s", t->n_pieces, ending);
    else
        vvi_tell_line(a, "closed", "no: %zu edge%s of one triangle only, at holes or rims; %zu piece%s",
                      t->n_open_edges, t->n_open_edges == 1 ? "" : "s", t->n_pieces, ending);
}

static void tell_topology(vv_answer *a, const vv_mesh_topology *t, bool has_area, bool no_gap)
{
    tell_closed(a, t, has_area, no_gap);
    if (t->n_crowded_edges > 0)
        vvi_tell_line(a, "crowded",
                      "%zu %s where three or more triangles meet: the surface branches or "
                      "touches itself there",
                      t->n_crowded_edges, vvi_plural(t->n_crowded_edges, "edge", "edges"));
    if (t->n_turned_edges > 0)
        vvi_tell_line(a, "turned", "%zu %s between neighbours of which one shows its outside, one its inside",
                      t->n_turned_edges, vvi_plural(t->n_turned_edges, "edge", "edges"));
    if (t->n_degenerate > 0)
        vvi_tell_line(a, "degenerate", "%zu %s without area", t->n_degenerate,
                      vvi_plural(t->n_degenerate, "triangle", "triangles"));
    if (t->n_unused > 0)
        vvi_tell_line(a, "unused", "%zu %s of no triangle", t->n_unused, vvi_plural(t->n_unused, "vertex", "vertices"));
}

static void tell_mesh(vv_answer *a, const vv_mesh_info *m, const vv_mesh_topology *t, const vv_mesh_measures *measures)
{
    const vv_vec3 lo = measures->bounds.lo, hi = measures->bounds.hi;
    char about[VVI_MESH_TEXT];
    vvi_mesh_print(about, m);
    vvi_tell_line(a, "mesh", "%s", about);
    if (m->values && m->value_name[0])
        vvi_tell_line(a, "values", "%s %s", m->value_name, m->value_unit);
    tell_parts(a, m);
    tell_textures(a, m);
    if (m->n_vertices > 0) {
        vvi_tell_line(a, "bounds", "%g .. %g, %g .. %g, %g .. %g %s", lo.x, hi.x, lo.y, hi.y, lo.z, hi.z, m->unit);
        vvi_tell_line(a, "size", "%g x %g x %g %s", hi.x - lo.x, hi.y - lo.y, hi.z - lo.z, m->unit);
    }
    tell_topology(a, t, has_area(m, t), measures->closed);
    vvi_tell_line(a, "area", "%g %s", measures->area.value, measures->area.unit);
    if (!isnan(measures->volume.value))
        vvi_tell_line(a, "volume", "%g %s%s", measures->volume.value, measures->volume.unit,
                      measures->inside_out ? " (its triangles face inwards)" : "");
}

vv_status vv_about_mesh(vv_answer **out, const vv_mesh *mesh, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    vv_answer *a = *out = vvi_calloc(1, sizeof *a);
    vv_mesh_topology topology;
    vv_mesh_measures measures;
    vv_mesh_measure_options options;
    vv_status st;
    if (!a)
        return vv_fail_memory(sizeof *a);
    vv_mesh_measure_options_init(&options, sizeof options);
    options.open = true;
    if ((st = vv_mesh_count_topology(&topology, mesh, job)) != VV_OK ||
        (st = vv_mesh_measure(&measures, mesh, &options, job)) != VV_OK)
        return st;
    tell_keys(a, m, &topology, &measures);
    tell_mesh(a, m, &topology, &measures);
    return vvi_about_end(a, VV_OK);
}
