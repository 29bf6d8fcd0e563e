/* From words to what is measured: the object, the region, the method. */
#include "core/units.h"
#include "core/vec.h"
#include "filter/crop.h"
#include "grid/alike.h"
#include "grid/field.h"
#include "grid/label_id.h"
#include "grid/value_fit.h"
#include "measure.h"
#include "mesh_scene.h"
#include "model/frame.h"
#include "value.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NO_LIMIT 1e308 /* the largest value that scenes write */

enum { AUTOMATIC, CUBES, COUNT };
static const char *const methods[] = {"auto", "cubes", "count", NULL};
static const char *const spaces[] = {"index", "world", NULL};

static const vv_property rows[] = {
    {VV_PROP(cli_measure_options, iso), .kind = VV_KIND_STRING, .unit = "VALUE",
     .automatic = "the value that best splits the histogram in two; of labels all but 0",
     .doc = "the object is what has this value or more"},
    {VV_PROP(cli_measure_options, other_iso), .kind = VV_KIND_STRING, .unit = "VALUE", .automatic = "as --iso",
     .doc = "for the distance between two surfaces: the value of the second one"},
    {VV_PROP(cli_measure_options, other_label), .kind = VV_KIND_STRING, .unit = "N", .automatic = "as --label",
     .doc = "for the distance between two surfaces: the label of the second one"},
    {VV_PROP(cli_measure_options, threshold), .kind = VV_KIND_STRING, .unit = "LO..HI", .automatic = "as --iso",
     .doc = "the object has values from LO to HI; either may be left out: 90.. is 90 and more"},
    {VV_PROP(cli_measure_options, label), .kind = VV_KIND_STRING, .unit = "N", .automatic = "as --iso",
     .doc = "the object is what has this label"},
    {VV_PROP(cli_measure_options, mask), .kind = VV_KIND_PATH, .unit = "FILE", .automatic = "as --iso",
     .doc = "the object is where this volume is not 0; its samples must lie at the same places as those of INPUT"},
    {VV_PROP(cli_measure_options, seed), .kind = VV_KIND_STRING, .unit = "X,Y,Z", .automatic = "all of the object",
     .doc = "only the piece around this place: its voxels share faces"},
    {VV_PROP(cli_measure_options, box), .kind = VV_KIND_STRING, .unit = "X0..X1,Y0..Y1,Z0..Z1",
     .automatic = "everything",
     .doc = "only what lies in a box of samples, as in 10..59,..,5..19: the first and the last sample along each axis, "
            "or .. "
            "for all of them"},
    {VV_PROP(cli_measure_options, clip), .kind = VV_KIND_LIST, .cls = &cli_word_class, .unit = "CLIP",
     .doc = "only what x:10mm..60mm or 'plane(n=1,0,1 d=20mm)' keeps, as in 'volvis help render'; may be "
            "repeated; cut planes of a scene count too"},
    {VV_PROP(cli_measure_options, method), .kind = VV_KIND_ENUM, .names = methods,
     .doc = "of areas and volumes: cubes interpolates values (Marching Cubes), count counts voxels; auto counts labels "
            "and masks"},
    {VV_PROP(cli_measure_options, closed), .kind = VV_KIND_BOOL,
     .doc = "the area includes the faces where the object is cut off"},
    {VV_PROP(cli_measure_options, component), .option = "channel", .kind = VV_KIND_I64, .limited = true, .min = 0,
     .max = 1e6, .doc = "channel, from 0: of a vector or colour, which of its numbers"},
    {VV_PROP(cli_measure_options, point), .kind = VV_KIND_LIST, .cls = &cli_word_class, .unit = "X,Y,Z",
     .doc = "a place of a distance, an angle, a profile or a path along a surface; to be given once to three times"},
    {VV_PROP(cli_measure_options, space), .kind = VV_KIND_ENUM, .names = spaces,
     .doc = "how places are given: as sample numbers, or as lengths in the world"},
    {VV_PROP(cli_measure_options, samples), .kind = VV_KIND_I64, .limited = true, .min = 2, .max = 1e6, .def = 2,
     .automatic = "two a voxel", .doc = "of a profile: how many values"},
    {VV_PROP(cli_measure_options, bins), .kind = VV_KIND_I64, .limited = true, .min = 2, .max = 65536, .def = 2,
     .automatic = "at most 1024; whole numbers one or equally many each", .doc = "of a histogram"},
    {VV_PROP(cli_measure_options, range), .kind = VV_KIND_STRING, .unit = "LO..HI",
     .automatic = "from the least to the largest value",
     .doc = "of a histogram: from the start of its first bin to the end of its last"},
    {VV_PROP(cli_measure_options, log), .kind = VV_KIND_BOOL,
     .doc = "of a histogram's bars and plot: counts by their logarithm"},
    {VV_PROP(cli_measure_options, values), .kind = VV_KIND_PATH, .unit = "FILE", .automatic = "the labels alone",
     .doc = "for labels: a volume with samples at the same places; its values are reported for each label"},
    {VV_PROP(cli_measure_options, input_unit), .kind = VV_KIND_STRING, .unit = "UNIT", .automatic = "none",
     .doc = "of lengths in a mesh file that does not say it, or counts voxels: mm, or 0.5mm for each"},
    {VV_PROP(cli_measure_options, store), .kind = VV_KIND_STRING, .unit = "[SCENE.vv.json:]NAME",
     .automatic = "not kept",
     .doc = "keep what was asked and what came out in a scene, under this name: in the scene that is measured, or in "
            "SCENE.vv.json, which is made where there is none"},
    {VV_PROP(cli_measure_options, update), .kind = VV_KIND_BOOL,
     .doc = "of stored measurements: keep what comes out this time"},
    {VV_PROP(cli_measure_options, csv), .kind = VV_KIND_BOOL, .doc = "the result as a table of comma-separated values"},
    {0},
};

const vv_class cli_measure_class = {
    .name = "measure",
    .doc = "options of measure",
    .size = sizeof(cli_measure_options),
    .properties = rows,
};

/* Region ---------------------------------------------------------------------------------------------------------- */

static vv_status parse_box(vv_box *out, const char *typed, const vv_grid *grid)
{
    for (int a = 0; a < 3; a++) {
        char part[160];
        int64_t lo, end;
        const size_t n = strcspn(typed, ",");
        if (n >= sizeof part || (a < 2) != (typed[n] == ','))
            return vv_fail(VV_E_ARGUMENT,
                           "--box: expected three ranges with commas between them, as in 10..59,..,5..19");
        snprintf(part, sizeof part, "%.*s", (int)n, typed);
        const vv_status st =
            vvi_crop_range(&lo, &end, strcmp(part, ":") == 0 || strcmp(part, "..") == 0 ? "" : part, grid, a);
        if (st != VV_OK)
            return vv_fail_in(st, "--box");
        out->lo[a] = lo;
        out->n[a] = end - lo;
        typed += n + 1;
    }
    return VV_OK;
}

/* n . M q >= d, made unit again. */
vv_plane cli_plane_mapped(const vv_plane *p, const vv_affine *map)
{
    const vv_vec3 n = p->normal;
    const vv_vec3 turned = {vvi_dot(n, map->axis[0]), vvi_dot(n, map->axis[1]), vvi_dot(n, map->axis[2])};
    const double length = vvi_length(turned);
    return (vv_plane){vvi_scaled(turned, 1 / length), (p->offset - vvi_dot(n, map->origin)) / length};
}

/* Planes of the model's World and of its first visible volume, whose own are in its data's space. */
static void take_planes(cli_measuring *m, const vv_collection *planes, const vv_affine *place)
{
    for (size_t i = 0; planes && i < planes->n; i++) {
        const vv_cut_plane *p = (const vv_cut_plane *)(const void *)planes->entry[i].object;
        if (!p->on || m->n_planes == sizeof m->planes / sizeof *m->planes)
            continue;
        vv_vec3 n = p->normal;
        vvi_unit(&n);
        vv_plane *out = &m->planes[m->n_planes++];
        vv_affine inverse;
        *out = (vv_plane){n, p->offset};
        if (place && vv_affine_invert(&inverse, *place))
            *out = cli_plane_mapped(out, &inverse);
    }
}

size_t cli_measuring_planes(vv_plane out[CLI_PLANES_MOST], const cli_measuring *m)
{
    const vv_grid *grid = &vv_field_get_info(m->field)->grid;
    vv_affine inverse;
    memcpy(out, m->planes, m->n_planes * sizeof *out);
    size_t n = m->n_planes;
    for (int a = 0; m->o->box && a < 3 && vv_affine_invert(&inverse, grid->index_to_world); a++) {
        const double lo = (double)m->choice.box.lo[a], hi = lo + (double)m->choice.box.n[a] - 1;
        const vv_plane from = {vvi_vec(a == 0, a == 1, a == 2), lo}, to = {vvi_scaled(from.normal, -1), -hi};
        if (lo > 0)
            out[n++] = cli_plane_mapped(&from, &inverse);
        if (hi < (double)(grid->dims[a] - 1))
            out[n++] = cli_plane_mapped(&to, &inverse);
    }
    return n;
}

static const vv_volume *first_visible(const vv_world *world)
{
    for (size_t i = 0; i < world->volumes->n; i++) {
        const vv_volume *v = (const vv_volume *)(const void *)world->volumes->entry[i].object;
        if (v->visible)
            return v;
    }
    return NULL;
}

/* The same samples elsewhere in the world. */
static vv_status put_at(vv_field **field, const vv_affine *place)
{
    vv_field_info info = *vv_field_get_info(*field);
    vv_field *placed;
    info.grid.index_to_world = vv_affine_compose(*place, info.grid.index_to_world);
    const vv_status st = vvi_field_relabel(&placed, *field, &info);
    if (st != VV_OK)
        return st;
    vv_field_release(*field);
    *field = placed;
    return VV_OK;
}

/* What the scene does to its data: place, threshold, component, its own cut planes. */
static vv_status take_volume(cli_measuring *m, const vv_volume *v)
{
    const vv_affine place = vvi_frame_matrix((const vv_frame *)(const void *)v->place);
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)v->segmentation;
    const vv_threshold *threshold = (const vv_threshold *)(const void *)segmentation->threshold;
    const vv_status st = put_at(&m->field, &place);
    if (st != VV_OK)
        return st;
    m->place = place;
    take_planes(m, v->cut_planes, &place);
    m->chosen |= m->of_scene;
    if (!vv_object_is_set(&m->o->base, "component"))
        m->choice.component = (int)v->component;
    if (segmentation->kind == VV_SEGMENT_THRESHOLD && vv_object_is_set(&threshold->base, "lo") && !m->chosen) {
        m->chosen = m->of_scene = true;
        m->choice.lo = threshold->lo;
        const bool limited = vv_object_is_set(&threshold->base, "hi") && threshold->hi < NO_LIMIT;
        m->choice.hi = limited ? threshold->hi : INFINITY;
    }
    return VV_OK;
}

/* --clip adds planes to those of the World; which, is kept. */
static vv_status edit_clip(cli_measuring *m, cli_edits *edits)
{
    vvi_text *out = &m->result->planes;
    vv_world *world = vv_model_snapshot(edits->model);
    const size_t n_before = world->cut_planes->n;
    vv_object_release(&world->base);
    const vv_status st = cli_edit_clip(edits);
    world = vv_model_snapshot(edits->model);
    for (size_t i = n_before; i < world->cut_planes->n; i++) {
        char *json = NULL;
        if (vv_object_to_json(&json, world->cut_planes->entry[i].object, 0) == VV_OK)
            vvi_text_printf(out, "%s%s", out->n ? ", " : "", json);
        free(json);
    }
    vv_object_release(&world->base);
    return st;
}

/* A label between two others is none of the values between them. */
static bool shows_labels(const cli_measuring *m, const vv_volume *volume)
{
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume->segmentation;
    return vv_object_is_set(&segmentation->base, "kind") ? segmentation->kind == VV_SEGMENT_LABELS
                                                         : vv_field_get_info(m->field)->meaning == VV_MEANING_LABEL;
}

/* Unit, planes, place and threshold of the World; --clip adds to its planes. */
static vv_status take_world(cli_measuring *m, vv_model *model, const char *view)
{
    const cli_look look = {.clip = m->o->clip};
    cli_edits edits = {.command = m->command, .model = model, .look = &look};
    const vv_status st = edit_clip(m, &edits);
    if (st != VV_OK)
        return st;
    vv_world *world = vv_model_snapshot(model);
    take_planes(m, world->cut_planes, NULL);
    const vv_volume *volume = first_visible(world);
    if (volume && !shows_labels(m, volume) && cli_mesh_scene_iso(&m->choice.lo, world, view, m->command->job)) {
        m->of_scene = true;
        m->choice.hi = INFINITY;
    }
    const vv_status taken = volume ? take_volume(m, volume) : VV_OK;
    vv_object_release(&world->base);
    return taken;
}

/* Data alone: nothing but the unit. */
static vv_status open_data(cli_measuring *m, vv_model *model, const char *word)
{
    vvi_text unit = {0};
    vv_status st = cli_measuring_read(&m->field, &m->input, &m->stream, m->command, word);
    if (st != VV_OK)
        return st;
    vvi_text_json(&unit, vv_field_get_info(m->field)->grid.unit);
    st = unit.bad ? vv_fail_memory(unit.n) : vv_model_set(model, NULL, "unit", unit.s);
    vvi_text_free(&unit);
    return st;
}

vv_status cli_measuring_world(vv_model *model, vvi_recipe *recipe, cli_command *command, const char *word, bool edited)
{
    cli_edits edits = {.command = command, .model = model};
    vv_world *world = NULL;
    vv_status st = cli_input_world(&world, recipe, command, word);
    if (st == VV_OK && (st = vv_model_replace(model, NULL, world)) == VV_OK && edited)
        st = cli_edit_paths(&edits);
    vv_object_release(world ? &world->base : NULL);
    return st;
}

/* The samples are of the data that the World has then. */
static vv_status open_scene(cli_measuring *m, vv_model *model, vvi_recipe *recipe, const char *word, bool edited)
{
    vv_status st = cli_measuring_world(model, recipe, m->command, word, edited);
    if (st != VV_OK)
        return st;
    vv_world *world = vv_model_snapshot(model);
    if ((st = cli_input_open_in(&m->input, m->command, world, word)) == VV_OK)
        st = cli_stream_samples(&m->field, &m->stream, m->command, &m->input, m->input.frame < 0 ? 0 : m->input.frame);
    vv_object_release(&world->base);
    return st;
}

static vv_status open_samples(cli_measuring *m, const char *word)
{
    const vv_collection *set = m->command->common->set;
    const bool edited = set && set->n && m->result->edited && strcmp(word, m->result->edited) == 0;
    vv_model *model = NULL;
    vvi_recipe recipe = {0};
    vv_status st = vv_model_new(&model, m->command->runtime);
    if (st == VV_OK)
        st = edited || cli_input_contents(m->command, word) != CLI_INPUT_DATA
                 ? open_scene(m, model, &recipe, word, edited)
                 : open_data(m, model, word);
    if (st == VV_OK)
        st = take_world(m, model, recipe.view);
    const int64_t n_frames = st == VV_OK ? vv_file_info(m->input.file)->n_frames : 0;
    if (n_frames > 1 && m->input.frame < 0)
        cli_command_note(m->command, "%s: the first of %lld time steps is measured; choose another with FILE@N",
                         m->input.path, (long long)n_frames);
    vv_model_release(model);
    return st;
}

static vv_status choose_region(cli_measuring *m)
{
    const vv_status st = m->o->box ? parse_box(&m->choice.box, m->o->box, &vv_field_get_info(m->field)->grid) : VV_OK;
    m->choice.planes = m->planes;
    m->choice.n_planes = m->n_planes;
    snprintf(m->region, sizeof m->region, "%s%s%s", m->o->box ? "box of samples " : "", m->o->box ? m->o->box : "",
             m->n_planes && m->o->box     ? ", "
             : !m->n_planes && !m->o->box ? "all"
                                          : "");
    if (m->n_planes)
        snprintf(m->region + strlen(m->region), sizeof m->region - strlen(m->region), "%zu cut plane%s", m->n_planes,
                 m->n_planes > 1 ? "s" : "");
    return st;
}

/* Object ---------------------------------------------------------------------------------------------------------- */

vv_status cli_threshold_parse(double *lo, double *hi, const char *typed)
{
    const bool parted = strstr(typed, "..") || strpbrk(typed, ",:");
    char first[64], last[64];
    *lo = -INFINITY;
    *hi = INFINITY;
    if (!parted || !cli_value_split_range(first, last, typed) || (*first && !vvi_parse_number(lo, first)) ||
        (*last && !vvi_parse_number(hi, last)))
        return vv_fail(VV_E_ARGUMENT, "--threshold: expected LO..HI, as in 90..300 or 90.., found '%s'", typed);
    return *lo <= *hi ? VV_OK : vv_fail(VV_E_ARGUMENT, "--threshold: LO is above HI in '%s'; exchange them", typed);
}

vv_status cli_label_parse(vv_label_id *out, const char *option, const char *typed, vv_type type)
{
    if (vvi_label_parse(out, typed, vvi_label_is_unsigned(type)))
        return VV_OK;
    if (vvi_label_parse(out, typed, true))
        return vv_fail(VV_E_ARGUMENT, "--%s: no sample is %s: they are %s, which end at 2^63", option, typed,
                       vv_type_name(type));
    return vv_fail(VV_E_ARGUMENT, "--%s: expected a whole number%s, found '%s'", option,
                   strpbrk(typed, "eE.") ? ", with all of its digits" : "", typed);
}

static vv_status to_index(vv_vec3 *out, const cli_measuring *m, const char *option, const char *typed)
{
    double p[3];
    vv_affine inverse;
    if (cli_value_numbers(p, 3, typed, false) != VV_OK)
        return vv_fail(VV_E_ARGUMENT, "--%s: expected X,Y,Z, as in 80,90,60, found '%s'", option, typed);
    *out = vvi_vec(p[0], p[1], p[2]);
    if (m->o->space == CLI_SPACE_INDEX)
        return VV_OK;
    if (!vv_affine_invert(&inverse, vv_field_get_info(m->field)->grid.index_to_world))
        return vv_fail(VV_E_ARGUMENT, "--%s: the grid's axes lie in one plane; give numbers of samples", option);
    *out = vv_affine_point(inverse, *out);
    return VV_OK;
}

vv_status cli_measuring_points(vv_vec3 *out, size_t n, const cli_measuring *m, const char *what)
{
    vv_status st = VV_OK;
    const size_t given = m->o->point ? m->o->point->n : 0;
    if (given != n)
        return vv_fail(VV_E_ARGUMENT, "%s needs --point X,Y,Z %s; there are %zu", what,
                       n == 1   ? "once"
                       : n == 2 ? "twice"
                                : "three times",
                       given);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = to_index(&out[i], m, "point", cli_word_nth(m->o->point, i));
    return st;
}

static vv_status parse_seed(cli_measuring *m)
{
    vv_vec3 at;
    const vv_status st = to_index(&at, m, "seed", m->o->seed);
    if (st != VV_OK)
        return st;
    const double p[3] = {nearbyint(at.x), nearbyint(at.y), nearbyint(at.z)};
    for (int a = 0; a < 3; a++) {
        if (!(p[a] >= -0.5 && p[a] < (double)vv_field_get_info(m->field)->grid.dims[a]))
            return vv_fail(
                VV_E_ARGUMENT, "--seed: %s is outside the volume%s", m->o->seed,
                m->o->space == CLI_SPACE_INDEX ? ": numbers of samples are meant, or lengths with --space world" : "");
        m->choice.seed[a] = (int64_t)p[a];
    }
    m->choice.seeded = true;
    return VV_OK;
}

static void name_range(cli_measuring *m, const char *why)
{
    const vv_measure_options *c = &m->choice;
    const char *unit = vv_field_get_info(m->field)->value_unit;
    if (c->hi == INFINITY)
        snprintf(m->object, sizeof m->object, "values of %.9g%s%s or more%s", c->lo, *unit ? " " : "", unit, why);
    else
        snprintf(m->object, sizeof m->object, "values from %.9g to %.9g%s%s%s", c->lo, c->hi, *unit ? " " : "", unit,
                 why);
}

static vv_status choose_object(cli_measuring *m)
{
    const cli_measure_options *o = m->o;
    vv_measure_options *c = &m->choice;
    const int given = (o->iso != NULL) + (o->threshold != NULL) + (o->label != NULL) + (o->mask != NULL);
    vv_status st = VV_OK;
    if (given > 1)
        return vv_fail(VV_E_ARGUMENT, "--iso, --threshold, --label and --mask each name an object: give one of them");
    m->chosen |= given > 0;
    m->of_scene &= given == 0;
    if (given > 0)
        c->lo = -INFINITY; /* not the scene's */
    if (o->iso && !vvi_parse_number(&c->lo, o->iso))
        return vv_fail(VV_E_ARGUMENT, "--iso: expected a number, found '%s'", o->iso);
    if (o->iso)
        c->hi = INFINITY;
    if (o->threshold)
        st = cli_threshold_parse(&c->lo, &c->hi, o->threshold);
    if (m->chosen)
        name_range(m, m->of_scene ? ", as in the scene" : "");
    if (st == VV_OK && o->label) {
        c->object = VV_OBJECT_LABEL;
        st = cli_label_parse(&c->label, "label", o->label, vv_field_get_info(m->field)->type);
        snprintf(m->object, sizeof m->object, "label %s", o->label);
    }
    if (st == VV_OK && o->mask) {
        c->object = VV_OBJECT_MASK;
        st = cli_measuring_beside(&m->mask, m, &m->mask_input, &m->mask_stream, "mask", o->mask);
        c->mask = m->mask;
        snprintf(m->object, sizeof m->object, "where %.100s is not 0", o->mask);
    }
    return st;
}

static void choose_method(cli_measuring *m)
{
    const bool steps = m->choice.object != VV_OBJECT_RANGE;
    m->choice.method =
        m->o->method == COUNT || (m->o->method == AUTOMATIC && steps) ? VV_MEASURE_COUNT : VV_MEASURE_CUBES;
}

void cli_measuring_label_method(cli_measuring *m)
{
    m->choice.method = m->o->method == CUBES ? VV_MEASURE_CUBES : VV_MEASURE_COUNT;
}

bool cli_measuring_count_steps(cli_measuring *m)
{
    if (m->o->method != AUTOMATIC)
        return false;
    m->choice.method = VV_MEASURE_COUNT;
    return true;
}

vv_status cli_measuring_choose(cli_measuring *m)
{
    vv_statistics *s = NULL;
    vvi_value_fit fit;
    vv_status st = VV_OK;
    if (m->chosen)
        return VV_OK;
    m->chosen = true;
    if (vv_field_get_info(m->field)->meaning == VV_MEANING_LABEL) {
        m->choice.object = VV_OBJECT_MASK;
        m->choice.mask = m->field;
        snprintf(m->object, sizeof m->object, "all labels but 0");
        choose_method(m);
        return VV_OK;
    }
    s = malloc(sizeof *s);
    if (!s)
        return vv_fail_memory(sizeof *s);
    if ((st = vv_field_statistics(s, m->field, m->choice.component, m->command->job)) == VV_OK) {
        vvi_fit_values(&fit, s);
        m->automatic = true;
        m->choice.lo = fit.empty ? 0 : fit.constant ? s->min : fit.split;
        m->choice.hi = INFINITY;
        name_range(m, fit.empty      ? " (no sample is a number: nothing is separated)"
                      : fit.constant ? " (all samples are equal: nothing is separated; --iso sets another)"
                                     : " (chosen: it best splits the histogram in two; --iso sets another)");
    }
    free(s);
    return st;
}

/* Opening --------------------------------------------------------------------------------------------------------- */

vv_status cli_measuring_read(vv_field **out, cli_input *input, cli_stream *stream, cli_command *command,
                             const char *word)
{
    const vv_status st = cli_input_open(input, command, word);
    return st != VV_OK ? st : cli_stream_samples(out, stream, command, input, input->frame < 0 ? 0 : input->frame);
}

vv_status cli_measuring_beside(vv_field **out, const cli_measuring *m, cli_input *input, cli_stream *stream,
                               const char *name, const char *word)
{
    char about[192];
    vv_status st = cli_measuring_read(out, input, stream, m->command, word);
    snprintf(about, sizeof about, "%s %.160s", name, word);
    if (st == VV_OK && (st = put_at(out, &m->place)) == VV_OK)
        st = vvi_grid_alike(&vv_field_get_info(m->field)->grid, &vv_field_get_info(*out)->grid, about);
    return st;
}

vv_status cli_measuring_open(cli_measuring *out, cli_result *result, const char *word)
{
    cli_command *command = result->command;
    *out = (cli_measuring){.command = command,
                           .result = result,
                           .o = cli_command_options(command, &cli_measure_class),
                           .place = vv_affine_identity()};
    vv_measure_options_init(&out->choice, sizeof out->choice);
    out->choice.component = (int)out->o->component;
    out->choice.closed = out->o->closed;
    vv_status st = open_samples(out, word);
    if (st == VV_OK && (st = choose_region(out)) == VV_OK && (st = choose_object(out)) == VV_OK && out->o->seed)
        st = parse_seed(out);
    choose_method(out);
    return st;
}

void cli_measuring_close(cli_measuring *m)
{
    vv_field_release(m->field);
    vv_field_release(m->mask);
    cli_stream_free(&m->stream);
    cli_stream_free(&m->mask_stream);
    cli_stream_free(&m->values_stream);
    cli_input_close(&m->input);
    cli_input_close(&m->mask_input);
    cli_input_close(&m->values_input);
}
