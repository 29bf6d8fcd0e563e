/* Isosurface: the surface where samples have a value, as an operation. */
#include "surface/isosurface.h"
#include "core/findings.h"
#include "core/job.h"
#include "core/property_impl.h"
#include "core/text.h"
#include "grid/fill_value.h"
#include "grid/label_id.h"
#include "grid/label_sense.h"
#include "grid/mesh.h"
#include "registry.h"
#include "surface/clip.h"
#include "surface/joined_mesh.h"
#include "surface/labels.h"
#include "surface/pieces.h"
#include "surface/tracking.h"
#include "surface/values.h"

#include <stdio.h>

typedef struct isosurface_params {
    vv_object base;
    vv_numbers *iso;
    int64_t component;
    int topology;
    bool cap, normals;
    vv_vec3 seed;
    int space;
    int64_t pieces;
    int by;
    double least;
    vv_numbers *label, *missing;
    double smoothing;
    bool sensed;                     /* no properties: nobody says so, but the samples look like labels */
    bool found;                      /* the value, from the samples */
    const vvi_isosurface_more *more; /* see add() and take_looks() */
    vv_label_look *look;
    void *look_user;
} isosurface_params;

static const char *const topologies[] = {"decided", "apart", NULL};
static const char *const spaces[] = {"index", "world", NULL};
static const char *const sizes[] = {"area", "volume", NULL};

static const vv_property properties[] = {
    {VV_PROP(isosurface_params, iso), .kind = VV_KIND_NUMBERS, .columns = 1, .lone = true, .unit = "value",
     .automatic = "the value that best splits the histogram in two",
     .doc =
         "value of the surface: samples of this value or more are inside; several values give one part each: 300,1200"},
    {VV_PROP(isosurface_params, component), .option = "channel", .kind = VV_KIND_I64, .limited = true, .min = 0,
     .max = 1 << 20, .doc = "which channel, by number from 0; on the command line by name too"},
    {VV_PROP(isosurface_params, missing), .kind = VV_KIND_NUMBERS, .columns = 1, .lone = true, .unit = "value",
     .when = "data=values", .automatic = "one value far from all others that many samples have, such as -9999",
     .doc = "values that stand for none: no surface is between them and others; none: every value is one"},
    {VV_PROP(isosurface_params, topology), .kind = VV_KIND_ENUM, .names = topologies, .when = "data=values",
     .doc = "where a cell face is ambiguous: decided by its bilinear function, or the inside always kept apart"},
    {VV_PROP(isosurface_params, cap), .kind = VV_KIND_BOOL, .when = "data=values",
     .doc = "close the surface where it leaves the volume"},
    {VV_PROP(isosurface_params, normals), .kind = VV_KIND_BOOL, .def = 1,
     .doc = "at each vertex, the direction in which values fall"},
    {VV_PROP(isosurface_params, seed), .kind = VV_KIND_VEC3, .automatic = "the whole surface",
     .doc = "only the connected piece nearest to this point: X,Y,Z"},
    {VV_PROP(isosurface_params, space), .kind = VV_KIND_ENUM, .names = spaces, .when = "seed",
     .doc = "coordinates of the seed: sample indices, or lengths in the world"},
    {VV_PROP(isosurface_params, pieces), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = UINT32_MAX,
     .automatic = "all", .doc = "only this many connected pieces, the largest, each as a part"},
    {VV_PROP(isosurface_params, by), .kind = VV_KIND_ENUM, .names = sizes, .when = "pieces|least",
     .doc = "how pieces are compared; the volume is the one that they enclose"},
    {VV_PROP(isosurface_params, least), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 1e300,
     .automatic = "any size", .doc = "only pieces of at least this area or volume, in the unit squared or cubed"},
    {VV_PROP(isosurface_params, label), .kind = VV_KIND_NUMBERS, .columns = 1, .lone = true, .quantity = VV_Q_LABEL,
     .automatic = "all but 0, for labels",
     .doc = "for a segmentation: labels whose borders are extracted, each as a part; on the command line by name too"},
    {VV_PROP(isosurface_params, smoothing), .kind = VV_KIND_F64, .def = 1, .limited = true, .min = 0, .max = 8,
     .unit = "voxels", .when = "data=labels", .doc = "for the borders of labels; 0: none, borders stay stepped"},
    {0},
};

static const vv_class isosurface_class = {
    .name = "isosurface",
    .doc = "parameters of isosurface",
    .size = sizeof(isosurface_params),
    .properties = properties,
};

static bool of_labels(const isosurface_params *p, const vv_field *field)
{
    return p->sensed || vv_object_is_set(&p->base, "label") || vv_field_get_info(field)->meaning == VV_MEANING_LABEL;
}

/* A field of yours whose samples are values, all but those that stand for none; *component: which of its. */
static vv_status take_values(vv_field **out, int *component, const isosurface_params *p, const vv_field *field,
                             const char *who, vv_job *job)
{
    const vvi_missing missing = {.is_named = vv_object_is_set(&p->base, "missing"),
                                 .named = p->missing,
                                 .asked = p->iso ? p->iso->v : NULL,
                                 .n_asked = p->iso ? p->iso->n : 0,
                                 .keep = "; missing none keeps them"};
    *out = vv_field_retain((vv_field *)(uintptr_t)field);
    *component = (int)p->component;
    const vv_status st = of_labels(p, field) ? VV_OK : vvi_field_take_missing(out, component, &missing, who, job);
    if (st == VV_OK)
        return VV_OK;
    vv_field_release(*out);
    *out = NULL;
    return st;
}

static vv_status value_statistics(vv_statistics *out, const isosurface_params *p, const vv_field *field, vv_job *job)
{
    vv_field *values;
    int component;
    vv_status st = take_values(&values, &component, p, field, NULL, job);
    if (st == VV_OK)
        st = vv_field_statistics(out, values, component, job);
    vv_field_release(values);
    return st;
}

static vv_status automatic_value(double *out, const isosurface_params *p, const vv_field *field, vv_job *job)
{
    vv_statistics statistics;
    vvi_value_fit fit;
    const vv_status st = value_statistics(&statistics, p, field, job);
    if (st != VV_OK)
        return st;
    vvi_fit_values(&fit, &statistics, NULL);
    *out = fit.split;
    return fit.empty ? vv_fail(VV_E_ARGUMENT, "isosurface: no sample is a number: there is no surface") : VV_OK;
}

/* How often number i stands before index i as well. */
static size_t times_before(const vv_numbers *numbers, size_t i)
{
    size_t n = 0;
    for (size_t k = 0; k < i; k++)
        n += numbers->labels ? numbers->labels[k] == numbers->labels[i] : numbers->v[k] == numbers->v[i];
    return n;
}

static const char *print_one(char out[32], const vv_numbers *numbers, size_t i)
{
    if (numbers->labels)
        return vvi_label_print(out, numbers->labels[i], numbers->labels[i] < 0 && numbers->v[i] > 0);
    snprintf(out, 32, "%g", numbers->v[i]);
    return out;
}

/* Each number once, the first one: the same surface twice is more triangles and no more to see. */
static vv_status take_once(vv_numbers **numbers, const char *what, vv_job *job)
{
    const vv_numbers *all = *numbers;
    vv_numbers *once;
    size_t n = 0, n_more = 0;
    char text[32];
    for (size_t i = 0; all && i < all->n; i++)
        n_more += times_before(all, i) > 0;
    if (n_more == 0)
        return VV_OK;
    const vv_status st =
        all->labels ? vvi_numbers_new_labels(&once, all->n - n_more, 1) : vvi_numbers_new(&once, all->n - n_more);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < all->n; i++) {
        const size_t before = times_before(all, i);
        if (before == 0 && all->labels)
            vvi_numbers_set_label(once, n++, 1, all->labels[i], all->v[i]);
        else if (before == 0)
            once->v[n++] = all->v[i];
        else if (before == 1)
            vvi_log(job, VV_LOG_WARNING, "isosurface", "the %s %s is given more than once; it is used once", what,
                    print_one(text, all, i));
    }
    vvi_numbers_release(*numbers);
    *numbers = once;
    return VV_OK;
}

static vv_status take_all_once(isosurface_params *p, vv_job *job)
{
    const vv_status st = take_once(&p->iso, "value", job);
    return st == VV_OK ? take_once(&p->label, "label", job) : st;
}

static const double *values_of(const vv_object *params, size_t *n_out)
{
    const vv_numbers *iso = ((const isosurface_params *)params)->iso;
    *n_out = iso ? iso->n : 0;
    return *n_out ? iso->v : NULL;
}

static void add(vv_object *params, const vvi_isosurface_more *more)
{
    ((isosurface_params *)params)->more = more;
}

static void take_looks(vv_object *params, vv_label_look *look, void *user)
{
    isosurface_params *p = (isosurface_params *)params;
    p->look = look;
    p->look_user = user;
}

/* Whether the samples decide that they are labels: nothing is said of them, nor of what is wanted of them. */
static vv_status sense_labels(isosurface_params *p, const vv_field *field, vv_job *job)
{
    static const char *const said[] = {"iso", "label", "seed", "component"};
    const vv_field_info *info = vv_field_get_info(field);
    size_t n = 0;
    p->sensed = false;
    if (info->meaning != VV_MEANING_SCALAR || info->components > 1)
        return VV_OK;
    for (size_t i = 0; i < sizeof said / sizeof said[0]; i++)
        if (vv_object_is_set(&p->base, said[i]))
            return VV_OK;
    const vv_status st = vvi_label_sense(&n, field, 0, job);
    p->sensed = st == VV_OK && n > 0;
    if (p->sensed)
        vvi_find_note(job, "looks like labels: a surface of each but 0; 'label' chooses some of them, 'iso' makes one "
                           "of a value");
    return st == VV_E_LIMIT || st == VV_E_MEMORY ? VV_OK : st; /* what goes through in parts is not looked at whole */
}

static vv_status settle_value(isosurface_params *p, bool *found, const vv_field *field, vv_job *job)
{
    vv_numbers *iso = NULL;
    double value;
    size_t n;
    *found = !of_labels(p, field) && !values_of(&p->base, &n);
    if (!*found)
        return VV_OK;
    vv_status st = automatic_value(&value, p, field, job);
    if (st != VV_OK || (st = vvi_numbers_new(&iso, 1)) != VV_OK)
        return st;
    iso->v[0] = value;
    vvi_numbers_release(p->iso);
    p->iso = iso;
    return VV_OK;
}

static bool looks(const vv_object *params)
{
    return true;
}

/* Where no value is given and the samples are of no labels, the value that best splits the histogram in two becomes
 * that of the parameters. */
static vv_status settle(vv_object *params, const vv_field_series *fields, vv_job *job)
{
    isosurface_params *p = (isosurface_params *)params;
    vv_field *field = NULL;
    vv_status st = take_all_once(p, job);
    if (st == VV_OK && (st = fields->open(&field, fields->user, 0, job)) == VV_OK &&
        (st = sense_labels(p, field, job)) == VV_OK)
        st = settle_value(p, &p->found, field, job);
    vv_field_release(field);
    return st;
}

/* Triangles lie in cells between 2 x 2 x 2 samples. */
static bool has_cells(const vv_field *field)
{
    const int64_t *dims = vv_field_get_info(field)->grid.dims;
    return dims[0] > 1 && dims[1] > 1 && dims[2] > 1;
}

static vv_status why_empty(char out[160], const vv_object *params, const vv_field *field, vv_job *job)
{
    const isosurface_params *p = (const isosurface_params *)params;
    const vv_field_info *info = vv_field_get_info(field);
    vv_statistics s;
    bool outside = true;
    out[0] = 0;
    if (of_labels(p, field))
        return VV_OK;
    if (!has_cells(field)) {
        snprintf(out, 160, "%lld x %lld x %lld samples have no cells between them", (long long)info->grid.dims[0],
                 (long long)info->grid.dims[1], (long long)info->grid.dims[2]);
        return VV_OK;
    }
    const vv_status st = value_statistics(&s, p, field, job);
    if (st != VV_OK || s.infinite_count)
        return st;
    for (size_t i = 0; p->iso && i < p->iso->n; i++)
        outside &= !(p->iso->v[i] > s.min && p->iso->v[i] <= s.max);
    if (s.min == s.max)
        snprintf(out, 160, "all samples have the value %g", s.min);
    else if (outside)
        snprintf(out, 160, "the samples range from %g to %g, all on one side of the value", s.min, s.max);
    return VV_OK;
}

static vv_status like_labels(size_t *n_out, const vv_object *params, const vv_field *field, vv_job *job)
{
    enum { LEAST = 3, MOST = 32 };
    const isosurface_params *p = (const isosurface_params *)params;
    const vv_field_info *info = vv_field_get_info(field);
    vv_statistics s;
    size_t n = 0;
    *n_out = 0;
    if (info->type != VV_TYPE_U8 || info->components > 1 || of_labels(p, field))
        return VV_OK;
    const vv_status st = vv_field_statistics(&s, field, (int)p->component, job);
    for (int i = 0; st == VV_OK && i < s.n_bins; i++)
        n += s.histogram[i] > 0;
    *n_out = n >= LEAST && n <= MOST ? n : 0;
    return st;
}

static vvi_marching_options options_of(const isosurface_params *p)
{
    return (vvi_marching_options){.component = (int)p->component,
                                  .topology = (vvi_marching_topology)p->topology,
                                  .no_normals = !p->normals,
                                  .cap = p->cap};
}

/* The seed in the world. By numbers of samples it lies in the volume; in the world it may be a little beside it. */
static vv_status place_seed(vv_vec3 *out, const isosurface_params *p, const vv_grid *grid)
{
    const double at[3] = {p->seed.x, p->seed.y, p->seed.z};
    *out = p->seed;
    if (p->space)
        return VV_OK;
    for (int a = 0; a < 3; a++)
        if (!(at[a] >= -0.5 && at[a] <= (double)grid->dims[a] - 0.5))
            return vv_fail(VV_E_ARGUMENT,
                           "isosurface: the seed %g,%g,%g is outside the %lld x %lld x %lld samples; for lengths in "
                           "the world, set space world",
                           at[0], at[1], at[2], (long long)grid->dims[0], (long long)grid->dims[1],
                           (long long)grid->dims[2]);
    *out = vv_affine_point(grid->index_to_world, p->seed);
    return VV_OK;
}

static vv_status tracked(vv_mesh **out, const vv_field *field, const isosurface_params *p,
                         const vvi_marching_options *options, vv_job *job)
{
    vvi_tracking_options tracking = {.surface = *options};
    if (p->iso && p->iso->n > 1)
        return vv_fail(VV_E_ARGUMENT, "isosurface: a seed follows the surface of one value; %zu were given", p->iso->n);
    const vv_status st = place_seed(&tracking.seed, p, &vv_field_get_info(field)->grid);
    return st == VV_OK ? vvi_track_surface(out, field, &tracking, job) : st;
}

/* 2^63 and more are no labels of signed samples, nor are those below 0 of unsigned ones. */
static vv_status check_labels(const vv_numbers *labels, vv_type type)
{
    char text[32];
    for (size_t i = 0; i < labels->n; i++)
        if (labels->labels[i] < 0 && (labels->v[i] > 0) != vvi_label_is_unsigned(type))
            return vv_fail(VV_E_NOT_FOUND, "label %s is not in the volume, whose samples are %s",
                           print_one(text, labels, i), vv_type_name(type));
    return VV_OK;
}

/* A second label beside it has the same border, turned over. */
static vv_status borders(vv_mesh **out, const vv_field *field, const isosurface_params *p, vv_job *job)
{
    const vvi_labels_options options = {.labels = p->label && p->label->n ? p->label->labels : NULL,
                                        .n_labels = p->label ? p->label->n : 0,
                                        .smoothing = p->smoothing,
                                        .look = p->look,
                                        .look_user = p->look_user,
                                        .no_normals = !p->normals};
    if (vv_object_is_set(&p->base, "iso"))
        return vv_fail(VV_E_ARGUMENT, "isosurface: labels are names, with no values in between: give label or iso");
    if (vv_object_is_set(&p->base, "seed"))
        return vv_fail(VV_E_ARGUMENT, "isosurface: a seed follows the surface of a value; choose labels by --label");
    const vv_status st = p->label ? check_labels(p->label, vv_field_get_info(field)->type) : VV_OK;
    return st == VV_OK ? vvi_label_surfaces(out, field, (int)p->component, &options, job) : st;
}

/* What lies between two values: the surface of the upper one faces inwards. One part, so that a cut through it has the
 * hole that it should. */
static vv_status between(vv_mesh **out, const vv_field *field, const double ends[2],
                         const vvi_marching_options *options, vv_job *job)
{
    vv_mesh *sides[2] = {NULL, NULL};
    const vv_mesh_part none[2] = {{.color.a = -1}, {.color.a = -1}};
    vv_mesh_part *part;
    vvi_marching_options o = *options;
    vv_status st = VV_OK;
    for (int i = 0; i < 2 && st == VV_OK; i++) {
        o.value = ends[i];
        st = vvi_marching_cubes(&sides[i], field, &o, job);
    }
    if (st == VV_OK) {
        vvi_mesh_turn(sides[1]);
        st = vvi_mesh_join(out, sides, none, 2, job);
    }
    if (st == VV_OK && (st = vvi_mesh_add_parts(&part, *out, 1, job)) == VV_OK) {
        part->n_triangles = vv_mesh_get_info(*out)->n_triangles;
        snprintf(part->name, sizeof part->name, "%g..%g", ends[0], ends[1]);
    }
    vv_mesh_release(sides[0]);
    vv_mesh_release(sides[1]);
    return st;
}

static vv_status extract(vv_mesh **out, const vv_field *field, const isosurface_params *p, vv_job *job)
{
    vvi_marching_options options = options_of(p);
    vv_status st = VV_OK;
    options.cap = p->cap && has_cells(field);
    if (of_labels(p, field))
        return borders(out, field, p, job);
    if (!p->iso || p->iso->n == 0)
        st = automatic_value(&options.value, p, field, job);
    else
        options.value = p->iso->v[0];
    if (st != VV_OK)
        return st;
    if (vv_object_is_set(&p->base, "seed"))
        return tracked(out, field, p, &options, job);
    if (p->more && p->more->top && p->iso && p->iso->n == 1)
        return between(out, field, (double[2]){options.value, *p->more->top}, &options, job);
    if (p->iso && p->iso->n > 1)
        return vvi_marching_values(out, field, p->iso->v, p->iso->n, &options, job);
    return vvi_marching_cubes(out, field, &options, job);
}

static vv_status count(size_t *n_out, const vv_object *params, const vv_field *field)
{
    const isosurface_params *p = (const isosurface_params *)params;
    vvi_marching_options options = options_of(p);
    vv_mesh *mesh = NULL;
    *n_out = 0;
    options.cap = false;
    options.no_normals = true;
    const vv_status st =
        vvi_marching_values(&mesh, field, p->iso ? p->iso->v : NULL, p->iso ? p->iso->n : 0, &options, NULL);
    if (st == VV_OK)
        *n_out = vv_mesh_get_info(mesh)->n_triangles;
    vv_mesh_release(mesh);
    return st;
}

static vv_status cut(vv_mesh **mesh, const isosurface_params *p, vv_job *job)
{
    vv_mesh *kept = NULL;
    const vv_status st = vvi_mesh_clip(&kept, *mesh, p->more->planes, p->more->n_planes, p->cap, job);
    vv_mesh_release(*mesh);
    *mesh = kept;
    return st;
}

static vv_status choose_pieces(vv_mesh **mesh, const isosurface_params *p, vv_job *job)
{
    const vvi_pieces_options options = {.size = (vvi_piece_size)p->by, .most = (size_t)p->pieces, .least = p->least};
    vv_mesh *chosen = NULL;
    const vv_status st = vvi_mesh_pieces(&chosen, *mesh, &options, job);
    vv_mesh_release(*mesh);
    *mesh = chosen;
    return st;
}

static vv_status make(vv_mesh **out, const vv_field *const *inputs, size_t n_inputs, const isosurface_params *p,
                      vv_job *job)
{
    const vv_object *params = &p->base;
    if (vv_object_is_set(params, "pieces") && p->iso && p->iso->n > 1 && !of_labels(p, inputs[0]))
        return vv_fail(VV_E_ARGUMENT,
                       "isosurface: the largest pieces of %zu values together would leave out whole surfaces: give one "
                       "value with pieces",
                       p->iso->n);
    vv_status st = extract(out, inputs[0], p, job);
    if (st == VV_OK && p->more && p->more->n_planes)
        st = cut(out, p, job);
    if (st == VV_OK && (vv_object_is_set(params, "pieces") || vv_object_is_set(params, "least")))
        st = choose_pieces(out, p, job);
    if (st == VV_OK && n_inputs > 1)
        st = vvi_mesh_sample(*out, inputs[1], 0, job);
    if (st != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    return st;
}

/* "surface at 67.5 HU, which best splits the histogram in two" */
static void find_values(const isosurface_params *p, const char *unit, vv_job *job)
{
    size_t n = 0;
    vvi_text text = {0};
    const double *values = values_of(&p->base, &n);
    const char *why = p->more && p->more->why ? p->more->why
                      : p->found              ? ", which best splits the histogram in two"
                                              : "";
    if (!values)
        return;
    for (size_t i = 0; i < n; i++)
        vvi_text_printf(&text, "%s%g", i ? ", " : "", values[i]);
    if (p->more && p->more->top)
        vvi_text_printf(&text, " to %g", *p->more->top);
    if (!text.bad)
        vvi_find_phrase(job, "surface at %s%s%s%s", text.s, *unit ? " " : "", unit, why);
    vvi_find_numbers(job, "values", values, n);
    vvi_find_string(job, "value_unit", unit);
    vvi_find_bool(job, "value_found", p->found);
    vvi_text_free(&text);
}

/* What is made a surface of by a value, and may be meant otherwise. */
static vv_status find_doubts(const isosurface_params *p, const vv_field *field, vv_job *job)
{
    size_t n;
    const int components = vv_field_get_info(field)->components;
    const vv_status st = like_labels(&n, &p->base, field, job);
    if (st == VV_OK && n > 0)
        vvi_find_note(job, "has only %zu different values; if they are labels, 'label' makes a surface of each", n);
    if (components > 1 && !vv_object_is_set(&p->base, "component"))
        vvi_find_note(job, "has %d channels; the surface is that of channel 0, 'channel' chooses", components);
    return st;
}

/* What is empty is most often a mistake: why it is. */
static vv_status warn_empty(const isosurface_params *p, const vv_field *field, vv_job *job)
{
    char why[160] = "";
    const vv_status st = why_empty(why, &p->base, field, job);
    vvi_job_warn(job, "isosurface", "the mesh is empty: %s", *why ? why : "nothing of the input gives a triangle");
    return st;
}

static vv_status find(const isosurface_params *p, const vv_field *field, const vv_mesh *mesh, vv_job *job)
{
    const size_t n_planes = p->more ? p->more->n_planes : 0;
    find_values(p, vv_field_get_info(field)->value_unit, job);
    if (n_planes > 0)
        vvi_find_phrase(job, "cut by %zu plane%s", n_planes, n_planes > 1 ? "s" : "");
    vvi_find_count(job, "cut_planes", n_planes);
    const vv_status st = find_doubts(p, field, job);
    return st == VV_OK && vv_mesh_get_info(mesh)->n_triangles == 0 ? warn_empty(p, field, job) : st;
}

static vv_status make_mesh(vv_data *out, const vv_data *inputs, size_t n_inputs, const vv_object *params, vv_job *job)
{
    const vv_field *field = inputs[0].field;
    isosurface_params own = *(const isosurface_params *)params; /* with other numbers, perhaps */
    own.iso = vvi_numbers_retain(own.iso);
    own.label = vvi_numbers_retain(own.label);
    vv_field *values = NULL;
    int component = 0;
    vv_status st = take_all_once(&own, job);
    if (st == VV_OK)
        st = take_values(&values, &component, &own, field, "isosurface", job);
    own.component = component;
    if (st == VV_OK)
        st = make(&out->mesh, (const vv_field *[]){values, n_inputs > 1 ? inputs[1].field : NULL}, n_inputs, &own, job);
    own.component = ((const isosurface_params *)params)->component;
    if (st == VV_OK)
        st = find(&own, field, out->mesh, job);
    vv_field_release(values);
    vvi_numbers_release(own.iso);
    vvi_numbers_release(own.label);
    return st;
}

static vv_status settle_value_alone(vv_object *params, bool *found, const vv_field *field, vv_job *job)
{
    isosurface_params *p = (isosurface_params *)params;
    const vv_status st = take_all_once(p, job);
    return st == VV_OK ? settle_value(p, found, field, job) : st;
}

static bool of_labels_now(const vv_object *params, const vv_field *field)
{
    return of_labels((const isosurface_params *)params, field);
}

static const vvi_surface_row surface = {
    .add = add,
    .settle_value = settle_value_alone,
    .of_labels = of_labels_now,
    .count = count,
    .values = values_of,
};

static const vv_operand operands[] = {
    {"volume", VV_IS_FIELD, 1, 1, "the volume with the surface"},
    {"values", VV_IS_FIELD, 0, 1, "another volume, whose value at each vertex the mesh has"},
    {0},
};

const vv_operation vvi_operation_isosurface = {
    .api = VV_OPERATION_API,
    .name = "isosurface",
    .component = "surface",
    .group = "surfaces",
    .doc = "the surface at a value, as triangles (Marching Cubes); a second input gives values at the vertices",
    .example = "volvis isosurface head.nrrd -o skin.ply --iso 50",
    .params = &isosurface_class,
    .inputs = operands,
    .make = make_mesh,
    .makes = VV_IS_MESH,
    .looks = looks,
    .settle = settle,
    .take_looks = take_looks,
    .surface = &surface,
};
