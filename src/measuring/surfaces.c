/* Distances to, between and along surfaces. A volume's is the mesh of Marching Cubes. */
#include "measuring/surfaces.h"
#include "core/units.h"
#include "core/vec.h"
#include "mesh.h"
#include "surface/clip.h"
#include "surface/labels.h"
#include "surface/tracking.h"
#include "value.h"
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/measure_distance.h>
#include <volvis/measure_path.h>
#include <volvis/mesh_file.h>

typedef struct surface {
    vv_mesh *mesh;
    cli_measuring m; /* of a volume, else zero */
    bool is_volume;
    double off;    /* how far it may be from the surface that it stands for: an estimate for a volume's, rounding of a
                      mesh file's */
    double spread; /* share of lengths along it that this makes */
} surface;

/* What is typed of the second of two surfaces; NULL: nothing. */
typedef struct second_choice {
    const char *iso, *label;
} second_choice;

static void close_surface(surface *s)
{
    if (s->is_volume)
        cli_measuring_close(&s->m);
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
    const cli_measuring *m = &s->m;
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
static double off_of_labels(const cli_measuring *m)
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

static vv_status check_choice(const cli_measuring *m, const char *file)
{
    const bool labels = vv_field_get_info(m->field)->meaning == VV_MEANING_LABEL ||
                        (m->choice.object == VV_OBJECT_MASK && m->choice.mask == m->field);
    if (m->choice.object == VV_OBJECT_LABEL && m->choice.seeded)
        return vv_fail(VV_E_ARGUMENT, "%s: --seed follows the surface of a value, and %s has none: omit it", file,
                       m->object);
    if (m->choice.object == VV_OBJECT_LABEL)
        return VV_OK;
    if (labels || m->choice.object != VV_OBJECT_RANGE || m->choice.hi != INFINITY || !isfinite(m->choice.lo))
        return vv_fail(VV_E_ARGUMENT, "%s: %s: give --%s", file,
                       labels ? "labels have no values in between" : "a surface has one value",
                       labels ? "label N" : "iso VALUE");
    return VV_OK;
}

/* What box and planes keep of it. Its error is that of the whole. */
static vv_status cut(surface *s, const char *file, vv_job *job)
{
    vv_plane planes[CLI_PLANES_MOST];
    vv_mesh *kept = NULL;
    const size_t n = cli_measuring_planes(planes, &s->m);
    const vv_status st = n ? vvi_mesh_clip(&kept, s->mesh, planes, n, false, job) : VV_OK;
    if (st != VV_OK || !n)
        return st;
    vv_mesh_release(s->mesh);
    s->mesh = kept;
    return vv_mesh_get_info(kept)->n_triangles
               ? VV_OK
               : vv_fail(VV_E_ARGUMENT, "%s: nothing of the surface, %s, lies in %s", file, s->m.object, s->m.region);
}

/* The second surface of two may have a value or a label of its own. */
static vv_status choose_other(surface *s, const second_choice *other)
{
    vv_measure_options *c = &s->m.choice;
    if (other->iso) {
        c->object = VV_OBJECT_RANGE;
        s->m.chosen = vvi_parse_number(&c->lo, other->iso);
        c->hi = INFINITY;
        snprintf(s->m.object, sizeof s->m.object, "values of %s or more", other->iso);
        if (!s->m.chosen)
            return vv_fail(VV_E_ARGUMENT, "--other-iso: expected a number, found '%s'", other->iso);
    }
    if (!other->label)
        return VV_OK;
    if (other->iso)
        return vv_fail(VV_E_ARGUMENT, "--other-iso and --other-label each name an object: give one of them");
    c->object = VV_OBJECT_LABEL;
    s->m.chosen = true;
    snprintf(s->m.object, sizeof s->m.object, "label %s", other->label);
    return cli_measuring_label(&c->label, &s->m, "other-label", other->label);
}

static vv_status open_volume(surface *out, cli_result *result, const char *file, const second_choice *other)
{
    vv_job *job = result->command->job;
    out->is_volume = true;
    vv_status st = cli_measuring_open(&out->m, result, file);
    if (st == VV_OK && other)
        st = choose_other(out, other);
    if (st != VV_OK || (st = cli_measuring_choose(&out->m)) != VV_OK)
        return st;
    cli_measuring_take_surface(&out->m);
    if ((st = check_choice(&out->m, file)) != VV_OK || (st = make_mesh(&out->mesh, out, false, job)) != VV_OK)
        return st;
    if (vv_mesh_get_info(out->mesh)->n_triangles == 0)
        return vv_fail(VV_E_ARGUMENT, "%s has no surface at %g", file, out->m.choice.lo);
    st = find_error(out, job);
    return st == VV_OK ? cut(out, file, job) : st;
}

static vv_status open_mesh(surface *out, cli_command *command, const char *file)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    const vv_status st = cli_mesh_read(&out->mesh, command, file, o->input_unit);
    const vv_mesh_info *info = st == VV_OK ? vv_mesh_get_info(out->mesh) : NULL;
    float largest = 0;
    for (size_t i = 0; info && i < 3 * info->n_vertices; i++)
        largest = fmaxf(largest, fabsf(info->positions[i]));
    out->off = 2 * (double)FLT_EPSILON * (double)largest;
    return st == VV_OK ? st : vv_fail_in(st, "%s", file);
}

/* other: NULL: the command's value or label, or the one that is chosen. */
static vv_status open_surface(surface *out, cli_result *result, const char *file, const second_choice *other)
{
    *out = (surface){0};
    return cli_mesh_is_input(result->command, file) ? open_mesh(out, result->command, file)
                                                    : open_volume(out, result, file, other);
}

static void put_surface(cli_result *result, const surface *s, const char *key, const char *label)
{
    vvi_result *json = &result->command->json;
    const char *what = s->is_volume ? s->m.object : "mesh";
    vvi_result_string(json, key, what);
    const bool part = s->is_volume && strcmp(s->m.region, "all") != 0;
    const char *between = *result->object ? " and " : "";
    const size_t used = strlen(result->object), n = vv_mesh_get_info(s->mesh)->n_triangles;
    snprintf(result->object + used, sizeof result->object - used, "%s%s", between, what);
    snprintf(result->region, sizeof result->region, "%s", part ? s->m.region : "");
    if (!result->csv)
        cli_command_line(result->command, label, "%s%s%s; %zu %s", what, part ? " in " : "", part ? s->m.region : "", n,
                         cli_plural(n, "triangle", "triangles"));
}

/* Places ------------------------------------------------------------------------------------------------------------
 */

/* --points in the world; *error: how well one is known along one direction. */
static vv_status find_points(vv_vec3 *out, double *error, size_t n, const surface *s, cli_result *result,
                             const char *what)
{
    const cli_measure_options *o = cli_command_options(result->command, &cli_measure_class);
    vv_status st = VV_OK;
    *error = 0;
    if (n == 1 && !(o->point && o->point->n))
        return vv_fail(VV_E_ARGUMENT, "%s: distance to what? give --point X,Y,Z once, or a second surface", what);
    if (s->is_volume) {
        st = cli_measuring_points(out, n, &s->m, what);
        *error = cli_place_error(&s->m);
        for (size_t i = 0; i < n && st == VV_OK; i++)
            out[i] = vv_affine_point(vv_field_get_info(s->m.field)->grid.index_to_world, out[i]);
        return st;
    }
    if ((o->point ? o->point->n : 0) != n)
        return vv_fail(VV_E_ARGUMENT, "%s needs --point X,Y,Z %s; there are %zu",
                       n == 1 ? "the distance to a mesh" : what, n == 1 ? "once" : "twice", o->point ? o->point->n : 0);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        double p[3];
        if ((st = cli_value_numbers(p, 3, cli_word_nth(o->point, i), false)) != VV_OK)
            st = vv_fail_in(st, "--point");
        out[i] = st == VV_OK ? vvi_vec(p[0], p[1], p[2]) : out[i];
    }
    return st;
}

static void put_length(cli_result *result, const char *key, const char *label, double value, double error,
                       const surface *s)
{
    cli_figure f = {.key = key, .label = label, .value = value, .error = error};
    snprintf(f.unit, sizeof f.unit, "%s", unit_of(s));
    cli_figure_put(result, &f);
}

/* error: as far as the place is known along each axis; NaN: it was given. */
static void put_place(cli_result *result, const char *key, vv_vec3 p, double error, const char *more)
{
    char text[CLI_FIGURE_TEXT];
    const double v[3] = {p.x, p.y, p.z};
    cli_place_print(text, v, (double[]){error, error, error});
    vvi_result_numbers(&result->command->json, key, v, 3);
    if (!result->csv)
        cli_command_line(result->command, key, "%s%s", text, more);
}

static vv_status to_surface(cli_result *result, const surface *s, const char *file)
{
    vv_mesh_tree *tree = NULL;
    vv_mesh_foot foot;
    vv_vec3 p;
    double known;
    vv_status st = find_points(&p, &known, 1, s, result, file);
    if (st != VV_OK || (st = vv_mesh_tree_new(&tree, s->mesh, NULL, result->command->job)) != VV_OK)
        return st;
    vv_mesh_tree_nearest(&foot, tree, p);
    put_surface(result, s, "surface", "surface");
    vvi_result_string(&result->command->json, "unit", unit_of(s));
    put_place(result, "place", p, NAN, "");
    put_length(result, "distance", "distance", foot.distance, hypot(known, s->off), s);
    vvi_result_number(&result->command->json, "signed_distance", foot.signed_distance);
    put_place(result, "nearest", foot.at, hypot(known, s->off),
              foot.signed_distance < 0 ? ": the place is inside" : "");
    vv_mesh_tree_release(tree);
    return VV_OK;
}

vv_status cli_measure_point_to_surface(cli_result *result, const char *file)
{
    surface s;
    vv_status st = open_surface(&s, result, file, NULL);
    if (st == VV_OK)
        st = to_surface(result, &s, file);
    close_surface(&s);
    return st;
}

/* Along a surface ---------------------------------------------------------------------------------------------------
 */

static void put_path(cli_result *result, const vv_mesh_path *path)
{
    vvi_result *json = &result->command->json;
    vvi_result_bool(json, "shortest", path->shortest);
    vvi_result_open(json, "path", '[');
    for (size_t i = 0; i < path->n_points; i++)
        vvi_result_numbers(json, NULL, &path->points[i].x, 3);
    vvi_result_close(json, ']');
    if (!path->shortest)
        cli_command_note(result->command,
                         "the search ended early: a path may be shorter by what the error says; on fewer triangles "
                         "(--clip, --box, or a mesh of simplify) it goes on to the end");
}

static vv_status along(cli_result *result, const surface *s)
{
    vv_mesh_path path;
    vv_vec3 p[2];
    double known;
    vv_status st = find_points(p, &known, 2, s, result, "geodesic distance");
    if (st != VV_OK)
        return st;
    if ((st = vv_mesh_geodesic(&path, s->mesh, p[0], p[1], NULL, result->command->job)) == VV_OK) {
        const double length = path.length.value, surface_error = s->spread * length;
        const vv_vec3 from = path.points[0], to = path.points[path.n_points - 1];
        put_surface(result, s, "surface", "surface");
        vvi_result_string(&result->command->json, "unit", unit_of(s));
        put_place(result, "from", from, hypot(known, s->off), "");
        put_place(result, "to", to, hypot(known, s->off), "");
        put_length(result, "geodesic", "geodesic", length,
                   path.length.error + hypot(hypot(sqrt(2) * known, surface_error), s->is_volume ? 0 : s->off), s);
        put_length(result, "straight", "straight", vv_distance(from, to), hypot(sqrt(2) * known, sqrt(2) * s->off), s);
        put_path(result, &path);
    }
    vv_mesh_path_finish(&path);
    return st;
}

vv_status cli_measure_geodesic(cli_result *result, const char *file)
{
    surface s;
    vv_status st = open_surface(&s, result, file, NULL);
    if (st == VV_OK)
        st = along(result, &s);
    close_surface(&s);
    return st;
}

/* Two surfaces ------------------------------------------------------------------------------------------------------
 */

static void put_deviation(cli_result *result, const char *from, const vv_mesh_deviation *d, const surface *s,
                          double off)
{
    char key[48], label[32];
    const struct {
        const char *name;
        const vv_figure *figure;
    } figures[] = {{"mean", &d->mean}, {"rms", &d->rms}, {"max", &d->max}};
    for (int i = 0; i < 3; i++) {
        snprintf(key, sizeof key, "%s_%s", from, figures[i].name);
        snprintf(label, sizeof label, "%s %s", strcmp(from, "a_to_b") == 0 ? "A to B" : "B to A", figures[i].name);
        put_length(result, key, label, figures[i].figure->value, figures[i].figure->error + off, s);
    }
}

static vv_status between(cli_result *result, const surface *a, const surface *b)
{
    vv_job *job = result->command->job;
    vv_mesh_tree *tree_a = NULL, *tree_b = NULL;
    vv_mesh_foot on_a, on_b;
    vv_mesh_distances d;
    vv_status st = vv_mesh_tree_new(&tree_a, a->mesh, NULL, job);
    if (st == VV_OK && (st = vv_mesh_tree_new(&tree_b, b->mesh, NULL, job)) == VV_OK &&
        (st = vv_mesh_least_distance(&on_a, &on_b, tree_a, tree_b, job)) == VV_OK &&
        (st = vv_mesh_distance(&d, tree_a, tree_b, NULL, job)) == VV_OK) {
        const double off = hypot(a->off, b->off);
        put_surface(result, a, "surface_a", "A");
        put_surface(result, b, "surface_b", "B");
        vvi_result_string(&result->command->json, "unit", unit_of(a));
        put_length(result, "distance", "least", on_a.distance, off, a);
        put_deviation(result, "a_to_b", &d.a_to_b, a, off);
        put_deviation(result, "b_to_a", &d.b_to_a, a, off);
        put_length(result, "hausdorff", "Hausdorff", d.hausdorff.value, d.hausdorff.error + off, a);
    }
    vv_mesh_tree_release(tree_a);
    vv_mesh_tree_release(tree_b);
    return st;
}

vv_status cli_measure_two_surfaces(cli_result *result, const char *file_a, const char *file_b)
{
    const cli_measure_options *o = cli_command_options(result->command, &cli_measure_class);
    const second_choice second = {o->other_iso, o->other_label};
    surface a, b = {0};
    vv_status st = open_surface(&a, result, file_a, NULL);
    if (st == VV_OK && (st = open_surface(&b, result, file_b, &second)) == VV_OK &&
        strcmp(unit_of(&a), unit_of(&b)) != 0)
        st = vv_fail(VV_E_ARGUMENT, "%s is in %s and %s in %s: convert one", file_a, unit_of(&a), file_b, unit_of(&b));
    if (st == VV_OK)
        st = between(result, &a, &b);
    close_surface(&a);
    close_surface(&b);
    return st;
}
