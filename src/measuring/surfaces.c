/* Distances to, between and along surfaces. A volume's is the mesh of Marching Cubes. */
#include "core/vec.h"
#include "measure/path_thin.h"
#include "measuring/meshes.h"
#include "surface/clip.h"
#include "surface/labels.h"
#include "surface/tracking.h"
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/measure_distance.h>
#include <volvis/measure_path.h>

typedef struct surface {
    vv_mesh *mesh;
    vvi_measuring m; /* its own: of a volume the choice, too */
    bool is_volume;
    double off;    /* how far it may be from the surface that it stands for: an estimate for a volume's, rounding of a
                      mesh file's */
    double spread; /* share of lengths along it that this makes */
} surface;

static const char *given(const vvi_measuring *m)
{
    return m->input->given ? m->input->given : m->input->name;
}

static void close_surface(surface *s)
{
    if (s->is_volume)
        vvi_measuring_close(&s->m);
    vv_mesh_release(s->mesh);
}

static const char *unit_of(const surface *s)
{
    return vv_mesh_get_info(s->mesh)->unit;
}

/* Opening -----------------------------------------------------------------------------------------------------------
 */

static vv_status make_mesh(vv_mesh **out, const surface *s, bool cap, vv_job *job)
{
    const vvi_measuring *m = &s->m;
    const vvi_marching_options options = {.value = m->choice.lo, .component = m->choice.component, .cap = cap};
    if (m->choice.object == VV_OBJECT_LABEL) {
        const vvi_labels_options borders = {.labels = &m->choice.label, .n_labels = 1, .smoothing = 1};
        return vvi_label_surfaces(out, m->field, m->choice.component, &borders, job);
    }
    if (!m->choice.seeded)
        return vvi_marching_cubes(out, m->field, &options, job);
    const vv_vec3 seed = {(double)m->choice.seed[0], (double)m->choice.seed[1], (double)m->choice.seed[2]};
    const vvi_tracking_options tracking = {
        .surface = options, .seed = vv_affine_point(vv_field_get_info(m->field)->grid.index_to_world, seed)};
    return vvi_track_surface(out, m->field, &tracking, job);
}

/* Labels end somewhere between two samples: anywhere in a step, so that a difference of two of them is triangularly
 * distributed and within sqrt(2) * 0.55 steps in 95 of 100 cases. Which way the surface lies is not known here. */
static double off_of_labels(const vvi_measuring *m)
{
    const vv_grid *grid = &vv_field_get_info(m->field)->grid;
    return 0.55 * fmax(fmax(vv_grid_spacing(grid, 0), vv_grid_spacing(grid, 1)), vv_grid_spacing(grid, 2));
}

/* What chords leave out of the volume, by the area, is how far they are off; of open surfaces with their border closed.
 */
static vv_status find_error(surface *s, vv_job *job)
{
    vv_mesh_measure_options o;
    vv_mesh_measures found;
    vv_mesh *closed = NULL;
    vv_mesh_measure_options_init(&o, sizeof o);
    o.sampled = o.open = true;
    vv_status st = vv_mesh_measure(&found, s->mesh, &o, job);
    if (st == VV_OK && !found.closed && (st = make_mesh(&closed, s, true, job)) == VV_OK)
        st = vv_mesh_measure(&found, closed, &o, job);
    vv_mesh_release(closed);
    s->off = found.closed && found.area.value > 0 ? found.volume.error / found.area.value : NAN;
    if (s->m.choice.object == VV_OBJECT_LABEL)
        s->off = hypot(s->off, off_of_labels(&s->m));
    s->spread = found.area.value > 0 ? found.area.error / found.area.value / 2 : NAN;
    return st;
}

static vv_status check_choice(const vvi_measuring *m)
{
    const bool labels = vv_field_get_info(m->field)->meaning == VV_MEANING_LABEL ||
                        (m->choice.object == VV_OBJECT_MASK && m->choice.mask == m->field);
    if (m->choice.object == VV_OBJECT_LABEL && m->choice.seeded)
        return vv_fail(VV_E_ARGUMENT, "%s: --seed follows the surface of a value, and %s has none: omit it", given(m),
                       m->object);
    if (m->choice.object == VV_OBJECT_LABEL)
        return VV_OK;
    if (labels || m->choice.object != VV_OBJECT_RANGE || m->choice.hi != INFINITY || !isfinite(m->choice.lo))
        return vv_fail(VV_E_ARGUMENT, "%s: %s: give --%s", given(m),
                       labels ? "labels have no values in between" : "a surface has one value",
                       labels ? "label N" : "iso VALUE");
    return VV_OK;
}

/* What box and planes keep of it. Its error is that of the whole. */
static vv_status cut(surface *s, vv_job *job)
{
    vv_plane planes[VVI_PLANES_MOST];
    vv_mesh *kept = NULL;
    const size_t n = vvi_measuring_planes(planes, &s->m);
    const vv_status st = n ? vvi_mesh_clip(&kept, s->mesh, planes, n, false, job) : VV_OK;
    if (st != VV_OK || !n)
        return st;
    vv_mesh_release(s->mesh);
    s->mesh = kept;
    return vv_mesh_get_info(kept)->n_triangles ? VV_OK
                                               : vv_fail(VV_E_ARGUMENT, "%s: nothing of the surface, %s, lies in %s",
                                                         given(&s->m), s->m.object, s->m.region);
}

/* The second surface of two may have a value or a label of its own. */
static vv_status choose_other(vvi_measuring *m)
{
    vv_measure_options *c = &m->choice;
    const bool iso = vvi_asks(m, "other_iso"), label = vvi_asks(m, "other_label");
    if (iso && label)
        return vv_fail(VV_E_ARGUMENT, "--other-iso and --other-label each name an object: give one of them");
    if (iso) {
        c->object = VV_OBJECT_RANGE;
        c->lo = m->asked->other_iso;
        c->hi = INFINITY;
        m->chosen = true;
        snprintf(m->object, sizeof m->object, "values of %.9g or more", c->lo);
    }
    if (label)
        vvi_measuring_take_label(m, m->asked->other_label, m->input->called);
    return VV_OK;
}

static vv_status open_volume(surface *out, bool second)
{
    vvi_measuring *m = &out->m;
    vv_job *job = m->job;
    vv_status st = vvi_measuring_open(m);
    if (st == VV_OK && second)
        st = choose_other(m);
    if (st != VV_OK || (st = vvi_measuring_choose(m)) != VV_OK)
        return st;
    vvi_measuring_take_surface(m);
    if ((st = check_choice(m)) != VV_OK || (st = make_mesh(&out->mesh, out, false, job)) != VV_OK)
        return st;
    if (vv_mesh_get_info(out->mesh)->n_triangles == 0)
        return vv_fail(VV_E_ARGUMENT, "%s has no surface at %g", given(m), m->choice.lo);
    st = find_error(out, job);
    return st == VV_OK ? cut(out, job) : st;
}

/* Of several that a scene shows the first. */
static vv_status open_mesh(surface *out)
{
    const vv_measured_data *input = out->m.input;
    const vv_status st = input->shown ? vvi_shown_mesh(&out->mesh, input, out->m.job) : VV_OK;
    if (st != VV_OK)
        return st;
    if (input->shown && out->m.inputs->n_inputs > 1)
        vvi_tell_note(out->m.answer, "of %zu meshes the first, %s, is measured", out->m.inputs->n_inputs, input->shown);
    if (!input->shown)
        out->mesh = vv_mesh_retain(input->mesh);
    const vv_mesh_info *info = vv_mesh_get_info(out->mesh);
    float largest = 0;
    for (size_t i = 0; i < 3 * info->n_vertices; i++)
        largest = fmaxf(largest, fabsf(info->positions[i]));
    out->off = 2 * (double)FLT_EPSILON * (double)largest;
    return VV_OK;
}

/* second: of two; what is asked of it alone holds. */
static vv_status open_surface(surface *out, const vvi_measuring *m, const vv_measured_data *data, bool second)
{
    *out = (surface){.m = {.asked = m->asked, .inputs = m->inputs, .input = data, .answer = m->answer, .job = m->job}};
    out->is_volume = data->field != NULL;
    return out->is_volume ? open_volume(out, second) : open_mesh(out);
}

static void put_surface(vv_answer *a, const surface *s, const char *key, const char *label)
{
    const char *what = s->is_volume ? s->m.object : "mesh";
    vvi_tell_text(a, key, what);
    const bool part = s->is_volume && strcmp(s->m.region, "all") != 0;
    const char *between = *a->object ? " and " : "";
    const size_t used = strlen(a->object), n = vv_mesh_get_info(s->mesh)->n_triangles;
    snprintf(a->object + used, sizeof a->object - used, "%s%s", between, what);
    snprintf(a->region, sizeof a->region, "%s", part ? s->m.region : "");
    vvi_tell_line(a, label, "%s%s%s; %zu %s", what, part ? " in " : "", part ? s->m.region : "", n,
                  vvi_plural(n, "triangle", "triangles"));
}

/* Places ------------------------------------------------------------------------------------------------------------
 */

/* --points in the world; *error: how well one is known along one direction. */
static vv_status find_points(vv_vec3 *out, double *error, size_t n, const surface *s, const char *what)
{
    const vv_numbers *points = s->m.asked->points;
    const size_t given = points ? points->n / 3 : 0;
    vv_status st = VV_OK;
    *error = 0;
    if (n == 1 && !given)
        return vv_fail(VV_E_ARGUMENT, "%s: distance to what? give --point X,Y,Z once, or a second surface", what);
    if (s->is_volume) {
        st = vvi_measuring_points(out, n, &s->m, what);
        *error = vvi_place_error(&s->m);
        for (size_t i = 0; i < n && st == VV_OK; i++)
            out[i] = vv_affine_point(vv_field_get_info(s->m.field)->grid.index_to_world, out[i]);
        return st;
    }
    if (given != n)
        return vv_fail(VV_E_ARGUMENT, "%s needs --point X,Y,Z %s; there are %zu",
                       n == 1 ? "the distance to a mesh" : what, n == 1 ? "once" : "twice", given);
    for (size_t i = 0; i < n; i++)
        out[i] = vvi_vec(points->v[3 * i], points->v[3 * i + 1], points->v[3 * i + 2]);
    return VV_OK;
}

/* error: as far as the place is known along each axis; NaN: it was given. */
static void put_place(vv_answer *a, const char *key, vv_vec3 p, double error, const char *more)
{
    char text[VVI_FIGURE_TEXT];
    const double v[3] = {p.x, p.y, p.z};
    vvi_place_print(text, v, (double[]){error, error, error});
    vvi_tell_numbers(a, key, v, 3);
    vvi_tell_line(a, key, "%s%s", text, more);
}

static vv_status to_surface(vv_answer *a, const surface *s)
{
    vv_mesh_tree *tree = NULL;
    vv_mesh_foot foot;
    vv_vec3 p;
    double known;
    vv_status st = find_points(&p, &known, 1, s, given(&s->m));
    if (st != VV_OK || (st = vv_mesh_tree_new(&tree, s->mesh, NULL, s->m.job)) != VV_OK)
        return st;
    vv_mesh_tree_nearest(&foot, tree, p);
    put_surface(a, s, "surface", "surface");
    vvi_tell_text(a, "unit", unit_of(s));
    put_place(a, "place", p, NAN, "");
    vvi_tell(a, "distance", "distance", foot.distance, hypot(known, s->off), unit_of(s));
    vvi_tell_number(a, "signed_distance", foot.signed_distance);
    put_place(a, "nearest", foot.at, hypot(known, s->off), foot.signed_distance < 0 ? ": the place is inside" : "");
    vv_mesh_tree_release(tree);
    return VV_OK;
}

/* What is asked of one surface. */
static vv_status with_surface(const vvi_measuring *m, vv_status (*measure)(vv_answer *a, const surface *s))
{
    surface s;
    vv_status st = open_surface(&s, m, m->input, false);
    if (st == VV_OK)
        st = measure(m->answer, &s);
    close_surface(&s);
    return st;
}

vv_status vvi_measure_point_to_surface(vvi_measuring *m)
{
    return with_surface(m, to_surface);
}

/* Along a surface ---------------------------------------------------------------------------------------------------
 */

#define SHOWN 0.0005 /* of its length: what a path may be moved by in pictures */

/* The path of a figure as scenes keep it; its points are changed. */
static vv_status put_thinned(vv_answer *a, const char *key, vv_mesh_path *path, const surface *s)
{
    vv_affine back;
    size_t n;
    const vv_status st = vvi_path_thin(&n, path->points, path->n_points, SHOWN * path->length.value);
    if (st != VV_OK)
        return st;
    if (s->is_volume && s->m.asked->space == VV_MEASURE_IN_INDEX &&
        vv_affine_invert(&back, vv_field_get_info(s->m.field)->grid.index_to_world))
        for (size_t i = 0; i < n; i++)
            path->points[i] = vv_affine_point(back, path->points[i]);
    vvi_tell_path(a, key, &path->points[0].x, n);
    return VV_OK;
}

static void put_path(vv_answer *a, const vv_mesh_path *path)
{
    vvi_tell_bool(a, "shortest", path->shortest);
    vvi_tell_rows(a, "path", &path->points[0].x, path->n_points, 3);
    if (!path->shortest)
        vvi_tell_note(a, "the search ended early: a path may be shorter by what the error says; on fewer triangles "
                         "(--clip, --box, or a mesh of simplify) it goes on to the end");
}

static vv_status along(vv_answer *a, const surface *s)
{
    vv_mesh_path path;
    vv_vec3 p[2];
    double known;
    vv_status st = find_points(p, &known, 2, s, "geodesic distance");
    if (st != VV_OK)
        return st;
    if ((st = vv_mesh_geodesic(&path, s->mesh, p[0], p[1], NULL, s->m.job)) == VV_OK) {
        const double length = path.length.value, surface_error = s->spread * length;
        const vv_vec3 from = path.points[0], to = path.points[path.n_points - 1];
        put_surface(a, s, "surface", "surface");
        vvi_tell_text(a, "unit", unit_of(s));
        put_place(a, "from", from, hypot(known, s->off), "");
        put_place(a, "to", to, hypot(known, s->off), "");
        vvi_tell(a, "geodesic", "geodesic", length,
                 path.length.error + hypot(hypot(sqrt(2) * known, surface_error), s->is_volume ? 0 : s->off),
                 unit_of(s));
        vvi_tell(a, "straight", "straight", vv_distance(from, to), hypot(sqrt(2) * known, sqrt(2) * s->off),
                 unit_of(s));
        put_path(a, &path);
        st = put_thinned(a, "geodesic", &path, s);
    }
    vv_mesh_path_finish(&path);
    return st;
}

vv_status vvi_measure_geodesic(vvi_measuring *m)
{
    return with_surface(m, along);
}

/* Two surfaces ------------------------------------------------------------------------------------------------------
 */

static void put_deviation(vv_answer *a, const char *key, const char *label, const vv_mesh_deviation *d,
                          const surface *s, double off)
{
    char name[48], line[32];
    const struct {
        const char *name;
        const vv_figure *figure;
    } figures[] = {{"mean", &d->mean}, {"rms", &d->rms}, {"max", &d->max}};
    for (int i = 0; i < 3; i++) {
        snprintf(name, sizeof name, "%s_%s", key, figures[i].name);
        snprintf(line, sizeof line, "%s %s", label, figures[i].name);
        vvi_tell(a, name, line, figures[i].figure->value, figures[i].figure->error + off, unit_of(s));
    }
}

static vv_status between(vv_answer *to, const surface *a, const surface *b)
{
    vv_job *job = a->m.job;
    vv_mesh_tree *tree_a = NULL, *tree_b = NULL;
    vv_mesh_foot on_a, on_b;
    vv_mesh_distances d;
    vv_status st = vv_mesh_tree_new(&tree_a, a->mesh, NULL, job);
    if (st == VV_OK && (st = vv_mesh_tree_new(&tree_b, b->mesh, NULL, job)) == VV_OK &&
        (st = vv_mesh_least_distance(&on_a, &on_b, tree_a, tree_b, job)) == VV_OK &&
        (st = vv_mesh_distance(&d, tree_a, tree_b, NULL, job)) == VV_OK) {
        const double off = hypot(a->off, b->off);
        put_surface(to, a, "surface_a", "A");
        put_surface(to, b, "surface_b", "B");
        vvi_tell_text(to, "unit", unit_of(a));
        vvi_tell(to, "distance", "least", on_a.distance, off, unit_of(a));
        put_deviation(to, "a_to_b", "A to B", &d.a_to_b, a, off);
        put_deviation(to, "b_to_a", "B to A", &d.b_to_a, a, off);
        vvi_tell(to, "hausdorff", "Hausdorff", d.hausdorff.value, d.hausdorff.error + off, unit_of(a));
    }
    vv_mesh_tree_release(tree_a);
    vv_mesh_tree_release(tree_b);
    return st;
}

vv_status vvi_measure_two_surfaces(vvi_measuring *m)
{
    surface a, b = {0};
    vv_status st = open_surface(&a, m, m->input, false);
    if (st == VV_OK && (st = open_surface(&b, m, m->inputs->other, true)) == VV_OK &&
        strcmp(unit_of(&a), unit_of(&b)) != 0)
        st = vv_fail(VV_E_ARGUMENT, "%s is in %s and %s in %s: convert one", given(&a.m), unit_of(&a), given(&b.m),
                     unit_of(&b));
    if (st == VV_OK)
        st = between(m->answer, &a, &b);
    close_surface(&a);
    close_surface(&b);
    return st;
}
