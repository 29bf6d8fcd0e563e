/* The World's measurements where they are: points with lines between them, regions and boxes, the seed of a piece,
 * and what came out. In a slice what lies in it; elsewhere over everything, since a line from surface to surface is
 * inside. */
#include "core/memory.h"
#include "core/status.h"
#include "core/text.h"
#include "core/vec.h"
#include "measuring/figure_changes.h"
#include "measuring/measuring.h"
#include "measuring/world_data.h"
#include "model/contents.h"
#include "render/decorate/region_lines.h"
#include "render/decorate/round_numbers.h"
#include "render/decorate/sheet.h"
#include "scene/resolve.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDE 1.5  /* of lines, in those of other decorations */
#define DISC 0.42 /* ems */
#define CROSS 0.6
#define AWAY 0.9              /* from a place to its letters */
#define IN_SLICE (0.5 + 1e-6) /* of a step of samples: what belongs to one slice alone */
enum { CORNERS = 8, EDGES = 12, RINGS = 3 };

static const vv_measurement *nth(const vv_scene *scene, size_t i)
{
    return vvi_measurement_nth(scene->world, i);
}

/* Those of other files are of no place in this World. */
static bool is_here(const vv_scene *scene, const vv_measurement *m)
{
    const vv_collection *all = scene->world->datasets;
    bool here = !m->file;
    for (size_t i = 0; i < all->n && !here; i++) {
        const vv_dataset *d = vvi_dataset_nth(scene->world, i);
        here = d->path && strcmp(d->path, m->file) == 0;
    }
    return here;
}

static bool has_place(const vv_scene *scene, const vv_measurement *m)
{
    const bool placed = (m->points && m->points->n >= 3) || m->box || vvi_measurement_has_region(m) ||
                        vv_object_is_set(&m->base, "seed");
    return m->visible && placed && is_here(scene, m);
}

bool vvi_sheet_has_measurements(const vv_scene *scene)
{
    for (size_t i = 0; i < scene->world->measurements->n; i++)
        if (has_place(scene, nth(scene, i)))
            return true;
    return false;
}

/* Where it is --------------------------------------------------------------------------------------------------- */

/* The volume that it is of; NULL: none of samples that is seen. */
static const vv_actor *actor_of(const vvi_sheet *s, const vv_measurement *m)
{
    for (size_t i = 0; i < s->scene->n_actors; i++)
        if (!m->volume || strcmp(m->volume, s->scene->actors[i].id) == 0)
            return &s->scene->actors[i];
    return NULL;
}

/* From the space that it is told in. Meshes are measured in their own. */
static bool find_space(vv_affine *out, const vvi_sheet *s, const vv_measurement *m)
{
    const vv_actor *actor = actor_of(s, m);
    *out = vv_affine_identity();
    if (m->space == VV_MEASURE_IN_WORLD)
        return true;
    for (size_t i = 0; !actor && i < s->scene->n_mesh_actors; i++)
        if (!m->volume || strcmp(m->volume, s->scene->mesh_actors[i].look.id) == 0) {
            *out = s->scene->mesh_actors[i].place;
            return true;
        }
    if (actor)
        *out = actor->index_to_world;
    return actor != NULL;
}

/* The plane of a slice, and how far what lies in it may be from it. */
typedef struct slice {
    bool there;
    vv_plane plane;
    double half;
} slice;

static slice slice_of(const vvi_sheet *s)
{
    const vv_vec3 n = s->scene->lens.forward;
    slice out = {s->scene->renderer->plane != NULL, {n, vvi_dot(n, s->scene->cross_hair)}, 0};
    vv_affine inverse;
    if (!out.there || !s->scene->n_actors || !vv_affine_invert(&inverse, s->scene->actors[0].index_to_world))
        return out;
    const vv_vec3 steps = vvi_sub(vv_affine_point(inverse, n), vv_affine_point(inverse, vvi_vec(0, 0, 0)));
    out.half = IN_SLICE / fmax(fmax(fabs(steps.x), fabs(steps.y)), fabs(steps.z));
    return out;
}

static double beside(const slice *in, vv_vec3 p)
{
    return vvi_dot(in->plane.normal, p) - in->plane.offset;
}

static bool is_in(const slice *in, vv_vec3 p)
{
    return !in->there || fabs(beside(in, p)) <= in->half;
}

/* The part of a line that lies in the slice; false: none. */
static bool keep_part(vv_vec3 end[2], const slice *in)
{
    const vv_vec3 p = end[0], q = end[1];
    const double a = beside(in, p), b = beside(in, q);
    double from = 0, to = 1;
    if (!in->there)
        return true;
    if (a == b)
        return fabs(a) <= in->half;
    const double t[2] = {(-in->half - a) / (b - a), (in->half - a) / (b - a)};
    from = fmax(from, fmin(t[0], t[1]));
    to = fmin(to, fmax(t[0], t[1]));
    end[0] = vvi_add(p, vvi_scaled(vvi_sub(q, p), from));
    end[1] = vvi_add(p, vvi_scaled(vvi_sub(q, p), to));
    return from <= to;
}

/* The figure that stands for its kind; NULL: nothing came out. */
static const vv_measured_figure *main_figure(const vv_measurement *m)
{
    const char *name = vv_measure_kind_of(m)->main;
    const vv_measured_figure *first = NULL;
    for (size_t i = 0; i < m->figures->n; i++) {
        const vv_measured_figure *f = (const vv_measured_figure *)(const void *)m->figures->entry[i].object;
        if (name && f->name && strcmp(f->name, name) == 0)
            return f;
        first = first ? first : f;
    }
    return first;
}

/* What its line follows: the path that came out, else from point to point. NULL: it has none. */
static const vv_numbers *line_of(const vv_measurement *m)
{
    const vv_measured_figure *f = main_figure(m);
    return f && f->path && f->path->n >= 6 ? f->path : m->points;
}

static vv_vec3 nth_of(const vv_numbers *points, const vv_affine *space, size_t i)
{
    const double *v = points->v + 3 * i;
    return vv_affine_point(*space, vvi_vec(v[0], v[1], v[2]));
}

static size_t n_of(const vv_numbers *points)
{
    return points ? points->n / 3 : 0;
}

/* Corner k of the samples' box, whose outermost ones are half a step inside; false: no volume has it. */
static bool find_box(vv_vec3 out[CORNERS], const vvi_sheet *s, const vv_measurement *m)
{
    const vv_actor *actor = m->box ? actor_of(s, m) : NULL;
    vv_box box;
    if (!actor || vvi_measuring_box(&box, m->box, &vv_field_get_info(actor->field)->grid) != VV_OK)
        return false;
    for (int k = 0; k < CORNERS; k++) {
        double at[3];
        for (int a = 0; a < 3; a++)
            at[a] = (double)box.lo[a] - 0.5 + (k >> a & 1 ? (double)box.n[a] : 0);
        out[k] = vv_affine_point(actor->index_to_world, vvi_vec(at[0], at[1], at[2]));
    }
    return true;
}

/* What a slice cuts out of a region, elsewhere its edges; of none, or one that makes no sense, nothing. Regions of
 * meshes are in the World. */
static vv_status put_region(const vvi_sheet *s, const slice *in, const vv_measurement *m, vvi_region_line *line,
                            void *user)
{
    const vv_affine world = vv_affine_identity();
    const vv_actor *actor = actor_of(s, m);
    vv_region_shape shape;
    double *outline = NULL;
    vv_status st = VV_OK;
    if (vvi_measurement_has_region(m) && (actor || s->scene->n_mesh_actors) &&
        vvi_measurement_shape(&shape, &outline, m, actor ? &actor->index_to_world : &world) == VV_OK)
        st = in->there ? vvi_region_cut(&shape, &in->plane, line, user) : vvi_region_edges(&shape, line, user);
    free(outline);
    return st;
}

/* The uppermost of some places. */
typedef struct top {
    const vvi_sheet *sheet;
    vv_vec3 at;
    double y; /* INFINITY: none */
} top;

static void take_top(top *t, vv_vec3 p)
{
    double x, y, depth;
    if (vvi_sheet_project(&x, &y, &depth, t->sheet, p) && y < t->y) {
        t->y = y;
        t->at = p;
    }
}

static vv_status take_line(void *user, vv_vec3 p, vv_vec3 q)
{
    take_top(user, p);
    take_top(user, q);
    return VV_OK;
}

/* Where its letters are: the middle one of its points, or the middle of its middle line; a seed; the top of a
 * region or a box. */
static bool find_anchor(vv_vec3 *out, const vvi_sheet *s, const slice *in, const vv_measurement *m)
{
    top t = {s, {0, 0, 0}, INFINITY};
    vv_vec3 corner[CORNERS];
    vv_affine space;
    const vv_numbers *line = line_of(m);
    const size_t n = n_of(line);
    if (find_space(&space, s, m) && n) {
        *out = n % 2 ? nth_of(line, &space, n / 2)
                     : vvi_scaled(vvi_add(nth_of(line, &space, n / 2 - 1), nth_of(line, &space, n / 2)), 0.5);
        return true;
    }
    if (vv_object_is_set(&m->base, "seed") && find_space(&space, s, m)) {
        *out = vv_affine_point(space, m->seed);
        return true;
    }
    put_region(s, in, m, take_line, &t);
    for (int k = 0; !isfinite(t.y) && k < CORNERS && find_box(corner, s, m); k++)
        take_top(&t, corner[k]);
    *out = t.at;
    return isfinite(t.y);
}

/* Letters ------------------------------------------------------------------------------------------------------- */

/* "mm^2" with its sign, "deg" as that of angles. */
static void print_unit(char *out, size_t bytes, const char *unit)
{
    static const char *const powers[] = {"\xc2\xb2", "\xc2\xb3"};
    const size_t n = strcspn(unit, "^");
    const int power = unit[n] ? unit[n + 1] - '2' : -1;
    char base[32];
    snprintf(base, sizeof base, "%.*s", (int)(n < 31 ? n : 31), unit);
    if (strcmp(base, "deg") == 0)
        snprintf(out, bytes, "\xc2\xb0");
    else
        snprintf(out, bytes, "%s%s%s", *base ? " " : "", vvi_unit_sign(base),
                 power == 0 || power == 1 ? powers[power] : "");
}

/* " (step 3)" where what came out is of another time step than the one that is seen. */
static void print_step(char out[32], const vvi_sheet *s, const vv_measurement *m)
{
    const char *id = vvi_measured_volume_id(s->scene->world, m->volume);
    const vv_volume *volume = id ? vvi_volume_named(s->scene->world, id) : NULL;
    *out = 0;
    for (size_t i = 0; i < m->figures->n; i++) {
        const vv_measured_figure *f = (const vv_measured_figure *)(const void *)m->figures->entry[i].object;
        if (f->name && strcmp(f->name, VVI_TIME_STEP) == 0 && volume && f->value != (double)volume->frame)
            snprintf(out, 32, " (step %.0f)", f->value);
    }
}

/* Its title, and what came out last. */
static void print(char out[64], const vvi_sheet *s, const vv_measurement *m)
{
    const vv_measured_figure *f = main_figure(m);
    char number[40] = "", unit[48] = "", step[32] = "";
    if (f && vv_object_is_set(&f->base, "value") && isfinite(f->value)) {
        vvi_print_value(number, f->value);
        print_unit(unit, sizeof unit, f->unit ? f->unit : "");
        print_step(step, s, m);
    }
    const bool titled = m->title && *m->title;
    snprintf(out, 64, "%.24s%s%s%s%s", titled ? m->title : "", titled && *number ? ": " : "", number, unit, step);
    vvi_text_clean(out);
}

/* Above the place, below, to its right, to its left; farther away where others stand there. */
static void place_label(vvi_sheet_axis_label *out, vvi_sheet *s, double x, double y)
{
    const double wide = vvi_sheet_length(s, out->text, s->em) / 2, high = 0.5 * s->em, away = AWAY * s->em;
    const double way[4][2] = {{0, -1}, {0, 1}, {1, 0}, {-1, 0}};
    for (int i = 0; i < 4 * RINGS && !out->there; i++) {
        const int ring = i / 4;
        const double farther = away + 1.6 * s->em * ring;
        out->x = x + way[i % 4][0] * (farther + wide);
        out->y = y + way[i % 4][1] * (farther + high);
        out->box = (vvi_box){out->x - wide, out->y - high, out->x + wide, out->y + high};
        out->there = vvi_layout_take(&s->layout, out->box);
    }
}

void vvi_sheet_measurements_place(vvi_sheet_measurements *out, vvi_sheet *s)
{
    const slice in = slice_of(s);
    const vv_collection *all = s->scene->world->measurements;
    for (size_t i = 0; i < all->n && out->n < VVI_SHEET_MEASUREMENTS; i++) {
        const vv_measurement *m = nth(s->scene, i);
        vvi_sheet_axis_label *label = &out->shown[out->n].label;
        vv_vec3 at;
        double x, y, depth;
        if (!has_place(s->scene, m))
            continue;
        out->shown[out->n++].of = m;
        print(label->text, s, m);
        if (!*label->text || !find_anchor(&at, s, &in, m) ||
            (!is_in(&in, at) && !m->box && !vvi_measurement_has_region(m)) ||
            !vvi_sheet_project(&x, &y, &depth, s, at) || x < 0 || y < 0 || x > s->width || y > s->height)
            continue;
        place_label(label, s, x, y);
        if (!label->there)
            vvi_sheet_left_out(s, "what was measured");
    }
}

/* Lines have a colour of their own, as pages draw them, unless the scene gives one for all: white is that of bones. */
static vv_color ink_of(const vvi_sheet *s)
{
    const bool dark = s->ink.r > 0.5;
    if (vv_object_is_set(&s->wanted->base, "color"))
        return s->ink;
    return dark ? (vv_color){1, 0.665, 0.068, 1} : (vv_color){0.42, 0.08, 0, 1};
}

/* Drawing ------------------------------------------------------------------------------------------------------- */

/* On the picture, a line of the World as far as it is in the slice and before the eye; false: nothing is. */
static bool find_line(vv_vec3 out[2], const vvi_sheet *s, const slice *in, vv_vec3 p, vv_vec3 q)
{
    vv_vec3 end[2] = {p, q};
    double depth;
    if (!keep_part(end, in))
        return false;
    for (int i = 0; i < 2; i++) {
        out[i] = vvi_vec(0, 0, 0);
        if (!vvi_sheet_project(&out[i].x, &out[i].y, &depth, s, end[i]))
            return false;
    }
    return true;
}

static vv_status draw_line(const vvi_sheet *s, const slice *in, vv_vec3 p, vv_vec3 q)
{
    vv_vec3 end[2];
    return find_line(end, s, in, p, q) ? vvi_sheet_line(s, end, 2, WIDE * s->line) : VV_OK;
}

/* At once: the edges of one line would lie on the next. */
static vv_status draw_lines(const vvi_sheet *s, const slice *in, const vv_numbers *points, const vv_affine *space)
{
    size_t n = 0;
    vv_vec3 *end = vvi_calloc(2 * n_of(points) + 1, sizeof *end);
    if (!end)
        return vv_fail_memory((2 * n_of(points) + 1) * sizeof *end);
    for (size_t i = 0; i + 1 < n_of(points); i++)
        if (find_line(end + n, s, in, nth_of(points, space, i), nth_of(points, space, i + 1)))
            n += 2;
    const vv_status st = vvi_sheet_line(s, end, n, WIDE * s->line);
    free(end);
    return st;
}

static vv_status draw_disc(const vvi_sheet *s, const slice *in, vv_vec3 p)
{
    vv_vec3 at = {0, 0, 0};
    double depth;
    const double wide = fmax(DISC * s->em, 3 * s->line);
    if (!is_in(in, p) || !vvi_sheet_project(&at.x, &at.y, &depth, s, p))
        return VV_OK;
    const vv_status st = vvi_gfx_points(s->gfx, &at, 1, wide + 1.6 * s->line, vvi_faded(s->paper, 0.9));
    return st == VV_OK ? vvi_gfx_points(s->gfx, &at, 1, wide, s->ink) : st;
}

static vv_status draw_points(const vvi_sheet *s, const slice *in, const vv_measurement *m)
{
    vv_affine space;
    if (!find_space(&space, s, m))
        return VV_OK;
    vv_status st = draw_lines(s, in, line_of(m), &space);
    for (size_t i = 0; i < n_of(m->points) && st == VV_OK; i++)
        st = draw_disc(s, in, nth_of(m->points, &space, i));
    return st;
}

static vv_status draw_seed(const vvi_sheet *s, const slice *in, const vv_measurement *m)
{
    vv_affine space;
    double x, y, depth;
    const double arm = CROSS * s->em;
    if (!vv_object_is_set(&m->base, "seed") || !find_space(&space, s, m))
        return VV_OK;
    const vv_vec3 at = vv_affine_point(space, m->seed);
    if (!is_in(in, at) || !vvi_sheet_project(&x, &y, &depth, s, at))
        return VV_OK;
    const vv_vec3 lines[4] = {{x - arm, y, 0}, {x + arm, y, 0}, {x, y - arm, 0}, {x, y + arm, 0}};
    return vvi_sheet_line(s, lines, 4, WIDE * s->line);
}

/* In a slice the polygon that it cuts out. */
static vv_status draw_box(const vvi_sheet *s, const slice *in, const vv_measurement *m)
{
    static const slice everywhere = {0};
    vv_vec3 corner[CORNERS], outline[VVI_CUT_CORNERS];
    vv_status st = VV_OK;
    if (!find_box(corner, s, m))
        return VV_OK;
    const size_t n = in->there ? vvi_cut_outline(outline, corner, &in->plane, NULL, 0) : 0;
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = draw_line(s, &everywhere, outline[i], outline[(i + 1) % n]);
    for (int k = 0; !in->there && k < EDGES && st == VV_OK; k++) {
        const int along = k / 4, across = (along + 1) % 3, up = (along + 2) % 3;
        const int from = (k & 1) << across | (k >> 1 & 1) << up;
        st = draw_line(s, in, corner[from], corner[from | 1 << along]);
    }
    return st;
}

typedef struct drawing {
    const vvi_sheet *sheet;
    const slice *in;
} drawing;

static vv_status draw_edge(void *user, vv_vec3 p, vv_vec3 q)
{
    const drawing *d = user;
    return draw_line(d->sheet, d->in, p, q);
}

vv_status vvi_sheet_measurements_draw(const vvi_sheet_measurements *all, const vvi_sheet *s)
{
    const vvi_gfx_label letters = {.size = s->em, .anchor = VVI_GFX_MIDDLE, .level = VVI_GFX_CENTRE};
    const slice in = slice_of(s);
    static const slice everywhere = {0};
    vvi_sheet lines = *s;
    drawing edges = {&lines, &everywhere};
    vv_status st = VV_OK;
    lines.ink = ink_of(s);
    for (size_t i = 0; i < all->n && st == VV_OK; i++) {
        st = draw_box(&lines, &in, all->shown[i].of);
        if (st == VV_OK)
            st = put_region(&lines, &in, all->shown[i].of, draw_edge, &edges);
        if (st == VV_OK)
            st = draw_points(&lines, &in, all->shown[i].of);
        if (st == VV_OK)
            st = draw_seed(&lines, &in, all->shown[i].of);
    }
    for (size_t i = 0; i < all->n && st == VV_OK; i++) {
        const vvi_sheet_axis_label *l = &all->shown[i].label;
        st = l->there ? vvi_sheet_label(s, l->x, l->y, &letters, l->text) : VV_OK;
    }
    return st;
}
