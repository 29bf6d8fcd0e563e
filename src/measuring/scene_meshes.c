/* Meshes of a scene, where it places them and cut as it cuts them. */
#include "core/memory.h"
#include "core/vec.h"
#include "measure/mesh_ellipsoid.h"
#include "measuring/meshes.h"
#include "surface/clip.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What the planes keep, in the mesh's own space. */
static vv_status cut(vv_mesh **out, const vv_measured_data *s, bool cap, vv_job *job)
{
    const size_t n = s->n_planes;
    vv_plane *planes = calloc(n + 1, sizeof *planes);
    if (!planes)
        return vv_fail_memory((n + 1) * sizeof *planes);
    for (size_t i = 0; i < n; i++)
        planes[i] = vvi_plane_mapped(&s->planes[i], &s->place);
    const vv_status st = vvi_mesh_clip(out, s->mesh, planes, n, cap, job);
    free(planes);
    return st;
}

/* Of the whole mesh known: what is in the ellipsoid, with errors that are enough for the whole. */
static vv_status keep_inside(vv_mesh_measures *out, const vv_mesh *mesh, const vv_measured_data *s,
                             const vv_region_shape *ellipsoid, vv_job *job)
{
    vvi_mesh_inside inside;
    const vv_status st = vvi_mesh_in_ellipsoid(&inside, mesh, &s->place, ellipsoid, job);
    if (st != VV_OK)
        return st;
    out->n_triangles = inside.n_triangles;
    out->area.value = inside.area;
    if (out->closed)
        out->volume.value = fmax(0, out->inside_out ? -inside.volume : inside.volume);
    vvi_mesh_measures_drop_box(out);
    return VV_OK;
}

static vv_status measure_cut(vv_mesh_measures *out, const vv_measured_data *s, const vv_region_shape *ellipsoid,
                             bool cap, bool open, vv_job *job)
{
    vv_mesh_measure_options o;
    vv_mesh *kept = NULL;
    vv_mesh_measure_options_init(&o, sizeof o);
    o.to_world = s->place;
    o.open = open;
    snprintf(o.unit, sizeof o.unit, "%s", s->unit);
    vv_status st = cut(&kept, s, cap, job);
    if (st == VV_OK && (st = vv_mesh_measure(out, kept, &o, job)) != VV_OK)
        st = s->shown ? vv_fail_in(st, "volumes.%s", s->shown) : vv_fail_in(st, "%s", s->name);
    if (st == VV_OK && ellipsoid)
        st = keep_inside(out, kept, s, ellipsoid, job);
    vv_mesh_release(kept);
    return st;
}

vv_status vvi_measure_cut_mesh(vv_mesh_measures *out, const vv_measured_data *data, const vv_region_shape *ellipsoid,
                               bool open, bool closed, vv_job *job)
{
    vv_mesh_measures without;
    vv_status st = measure_cut(out, data, ellipsoid, true, open, job);
    if (st == VV_OK && data->n_planes && !closed &&
        (st = measure_cut(&without, data, ellipsoid, false, true, job)) == VV_OK)
        out->area = without.area;
    return st;
}

/* Places, and triangles that still face outwards where it is mirrored. */
static vv_status move(vv_mesh **out, const vv_mesh *mesh, const vv_measured_data *s, vv_job *job)
{
    vv_mesh_info info = *vv_mesh_get_info(mesh);
    vv_affine linear = s->place;
    linear.origin = vvi_vec(0, 0, 0); /* positions are told from the mesh's origin, which moves in double precision */
    float *positions = vvi_calloc(3 * info.n_vertices + 1, sizeof *positions);
    uint32_t *triangles = vvi_calloc(3 * info.n_triangles + 1, sizeof *triangles);
    vv_status st = positions && triangles ? VV_OK : vv_fail_memory(3 * info.n_vertices * sizeof *positions);
    for (size_t i = 0; st == VV_OK && i < info.n_vertices; i++) {
        const float *p = info.positions + 3 * i;
        const vv_vec3 q = vv_affine_point(linear, vvi_vec(p[0], p[1], p[2]));
        positions[3 * i] = (float)q.x;
        positions[3 * i + 1] = (float)q.y;
        positions[3 * i + 2] = (float)q.z;
    }
    const bool mirrored = vv_affine_determinant(s->place) < 0;
    for (size_t i = 0; st == VV_OK && i < 3 * info.n_triangles; i++)
        triangles[i] = info.triangles[mirrored ? i - i % 3 + 2 - i % 3 : i];
    info.origin = vv_affine_point(s->place, info.origin);
    info.positions = positions;
    info.triangles = triangles;
    info.normals = NULL;
    snprintf(info.unit, sizeof info.unit, "%s", s->unit);
    if (st == VV_OK)
        st = vv_mesh_new(out, &info, job);
    free(positions);
    free(triangles);
    return st;
}

vv_status vvi_shown_mesh(vv_mesh **out, const vv_measured_data *shown, vv_job *job)
{
    vv_mesh *kept = NULL;
    *out = NULL;
    vv_status st = cut(&kept, shown, false, job);
    if (st == VV_OK && vv_mesh_get_info(kept)->n_triangles == 0)
        st = vv_fail(VV_E_ARGUMENT, "volumes.%s: planes leave nothing of the mesh", shown->shown);
    if (st == VV_OK)
        st = move(out, kept, shown, job);
    vv_mesh_release(kept);
    return st;
}

/* All ------------------------------------------------------------------------------------------------------------- */

typedef struct found {
    vv_mesh_measures *each, total;
} found;

/* Centroids by volume, errors added up. */
static void add(vv_mesh_measures *total, const vv_mesh_measures *m, bool first)
{
    if (first) {
        *total = *m;
        return;
    }
    const double v = total->volume.value, w = m->volume.value;
    for (int a = 0; a < 3; a++) {
        total->centroid[a].value = (v * total->centroid[a].value + w * m->centroid[a].value) / (v + w);
        total->centroid[a].error = (v * total->centroid[a].error + w * m->centroid[a].error) / (v + w);
    }
    total->n_triangles += m->n_triangles;
    total->area.value += m->area.value;
    total->area.error += m->area.error;
    total->volume.value += w;
    total->volume.error += m->volume.error;
    total->bounds.lo = vvi_vec(fmin(total->bounds.lo.x, m->bounds.lo.x), fmin(total->bounds.lo.y, m->bounds.lo.y),
                               fmin(total->bounds.lo.z, m->bounds.lo.z));
    total->bounds.hi = vvi_vec(fmax(total->bounds.hi.x, m->bounds.hi.x), fmax(total->bounds.hi.y, m->bounds.hi.y),
                               fmax(total->bounds.hi.z, m->bounds.hi.z));
    total->closed &= m->closed;
    total->inside_out = false;
    total->n_open_edges += m->n_open_edges;
    total->n_turned_edges += m->n_turned_edges;
}

static vv_status measure_all(found *f, const vvi_measuring *m, const vv_region_shape *region, bool open)
{
    const vv_measured_data *all = m->inputs->input;
    vv_status st = vvi_measuring_check_mesh_region(m, region);
    for (size_t i = 0; i < m->inputs->n_inputs && st == VV_OK; i++) {
        if (strcmp(all[i].unit, all[0].unit) != 0)
            st = vv_fail(VV_E_ARGUMENT, "volumes.%s is in %s and volumes.%s in %s: convert one, or hide one with --set",
                         all[0].shown, all[0].unit, all[i].shown, all[i].unit);
        if (st == VV_OK &&
            (st = vvi_measure_in_region(&f->each[i], &all[i], region, open, m->asked->closed, m->job)) == VV_OK)
            add(&f->total, &f->each[i], i == 0);
    }
    return st;
}

static void put_each(const vvi_measuring *m, const found *f)
{
    vv_answer *a = m->answer;
    vvi_tell_open(a, "meshes", "[");
    for (size_t i = 0; i < m->inputs->n_inputs; i++) {
        const vv_measured_data *s = &m->inputs->input[i];
        a->part = s->shown;
        vvi_tell_open(a, NULL, "{");
        vvi_tell_text(a, "name", s->shown);
        vvi_tell_line(a, "shown", "%s", s->shown);
        vvi_mesh_measures_put(a, m->what, &f->each[i], s->unit);
        vvi_tell_close(a, "}");
    }
    vvi_tell_close(a, "]");
    a->part = NULL;
}

/* Several are told one by one before all of them together. */
static void put_all(const vvi_measuring *m, const found *f)
{
    vv_answer *a = m->answer;
    const size_t n = m->inputs->n_inputs;
    const bool several = n > 1;
    if (several)
        put_each(m, f);
    else
        vvi_tell_text(a, "mesh", m->input->shown);
    snprintf(a->object, sizeof a->object, "%zu mesh%s of the scene", n, several ? "es" : "");
    vvi_tell_line(a, several ? "together" : "shown", "%s, where the scene places %s%s",
                  several ? a->object : m->input->shown, several ? "them" : "it",
                  several ? "; what overlaps counts twice" : "");
    vvi_mesh_measures_put(a, m->what, &f->total, m->input->unit);
}

vv_status vvi_measure_shown(vvi_measuring *m)
{
    vv_region_shape region;
    found f = {.each = calloc(m->inputs->n_inputs, sizeof *f.each)};
    vv_status st = vvi_measuring_mesh_region(&region, &m->outline, m);
    if (st == VV_OK)
        st = f.each ? measure_all(&f, m, &region, m->what != VVI_VOLUME)
                    : vv_fail_memory(m->inputs->n_inputs * sizeof *f.each);
    if (st == VV_OK) {
        put_all(m, &f);
        vvi_measuring_note_no_triangles(m, &f.total);
    }
    free(f.each);
    return st;
}
