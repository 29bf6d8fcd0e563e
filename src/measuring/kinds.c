/* The rows: what can be measured, of what, and with which properties. */
#include "core/memory.h"
#include "core/status.h"
#include "core/text.h"
#include "measuring/measuring.h"
#include "model/classes.h"
#include <stdio.h>
#include <string.h>

#define OBJECT "iso threshold_lo threshold_hi label mask seed space box cut_planes component region "
#define SURFACE "iso label component box cut_planes "
#define VOLUME VV_MEASURED_VOLUME
#define MESH VV_MEASURED_MESH
#define SHOWN VV_MEASURED_SHOWN
#define FORMS(...) ((const vv_measure_form[]){__VA_ARGS__, {0}})
#define OF_VOLUME(uses, run) FORMS({VOLUME, 0, 0, uses, 0, run})
/* Of objects in volumes, of meshes, and of those that a scene shows. */
#define EXTENT(uses, uses_shown, what, run, more)                                                                      \
    FORMS({VOLUME, 0, 0, OBJECT uses, (what) | (more), run},                                                           \
          {MESH, 0, 0, "input_unit region", what, vvi_measure_mesh},                                                   \
          {SHOWN, 0, 0, "region " uses_shown, what, vvi_measure_shown})

static const vv_measure_kind kinds[] = {
    {.name = "area",
     .doc = "how large the surface of an object is",
     .main = "area",
     .also = "surface",
     .forms = EXTENT("method closed", "closed", VVI_AREA, vvi_measure_object, VVI_DETAILS)},
    {.name = "volume",
     .doc = "how much an object holds",
     .main = "volume",
     .forms = EXTENT("method", "", VVI_VOLUME, vvi_measure_object, 0)},
    {.name = "box",
     .doc = "where an object lies: its centroid and its bounding box",
     .also = "centroid",
     .forms = EXTENT("method", "", VVI_BOX, vvi_measure_object, 0)},
    {.name = "statistics",
     .doc = "mean, deviation, percentiles and other figures of values",
     .main = "mean",
     .also = "stats mean deviation percentiles",
     .forms = OF_VOLUME(OBJECT, vvi_measure_statistics)},
    {.name = "histogram",
     .doc = "how often values occur",
     .main = "mean",
     .plot = true,
     .marks = true,
     .logarithmic = true,
     .forms = OF_VOLUME(OBJECT "bins range", vvi_measure_histogram)},
    {.name = "profile",
     .doc = "values along a line",
     .main = "length",
     .also = "line",
     .plot = true,
     .least_points = 2,
     .most_points = 2,
     .forms = OF_VOLUME("points space samples component", vvi_measure_profile)},
    {.name = "distance",
     .doc = "between points, along several, from a point to a surface, or between two surfaces",
     .main = "distance",
     .also = "hausdorff length polyline",
     .least_points = 2,
     .most_points = SIZE_MAX,
     .forms = FORMS({MESH, MESH, 0, "input_unit", VVI_SURFACE, vvi_measure_two_surfaces},
                    {VOLUME, VOLUME, 0, SURFACE "other_iso other_label", VVI_SURFACE, vvi_measure_two_surfaces},
                    {VOLUME | MESH, VOLUME | MESH, 0, SURFACE "other_iso other_label input_unit", VVI_SURFACE,
                     vvi_measure_two_surfaces},
                    {MESH, 0, 0, "points input_unit", VVI_SURFACE, vvi_measure_mesh_distance},
                    {SHOWN, 0, 0, "points", VVI_SURFACE, vvi_measure_mesh_distance},
                    {VOLUME, 0, 1, SURFACE "points space seed", VVI_SURFACE, vvi_measure_point_to_surface},
                    {VOLUME, 0, 0, "points space", 0, vvi_measure_distance})},
    {.name = "angle",
     .doc = "at the second of three points",
     .main = "angle",
     .least_points = 3,
     .most_points = 3,
     .forms =
         FORMS({VOLUME, 0, 0, "points space", 0, vvi_measure_angle},
               {MESH, 0, 0, "points input_unit", 0, vvi_measure_angle}, {SHOWN, 0, 0, "points", 0, vvi_measure_angle})},
    {.name = "labels",
     .doc = "count, volume, area and place of every label",
     .main = "labels",
     .forms = OF_VOLUME("values component method box cut_planes", vvi_measure_label_table)},
    {.name = "geodesic",
     .doc = "the path between two points along a surface",
     .main = "geodesic",
     .also = "path",
     .least_points = 2,
     .most_points = 2,
     .forms = FORMS({VOLUME, 0, 0, SURFACE "points space seed", VVI_SURFACE, vvi_measure_geodesic},
                    {MESH, 0, 0, "points input_unit", VVI_SURFACE, vvi_measure_geodesic},
                    {SHOWN, 0, 0, "points", VVI_SURFACE, vvi_measure_geodesic})},
    {.name = "summary",
     .doc = "statistics, area, volume and box",
     .main = "volume",
     .covers = "statistics, area, volume, box",
     .forms = EXTENT("method closed", "closed", VVI_EXTENT, vvi_measure_summary, 0)},
    {.name = "joint",
     .doc = "how often values occur with lengths of the gradient",
     .main = "gradient_mean",
     .plot = true,
     .forms = OF_VOLUME(OBJECT "bins range", vvi_measure_joint_histogram)},
    {.name = "point",
     .doc = "the value at a place",
     .main = "value",
     .also = "value pick",
     .least_points = 1,
     .most_points = 1,
     .forms = OF_VOLUME("points space component", vvi_measure_point)},
};
enum { N_KINDS = sizeof kinds / sizeof *kinds };

const vv_measure_kind *vv_measure_kind_nth(size_t index)
{
    return index < N_KINDS ? &kinds[index] : NULL;
}

const vv_measure_kind *vv_measure_kind_find(const char *name)
{
    for (size_t i = 0; i < N_KINDS; i++)
        if (strcmp(name, kinds[i].name) == 0)
            return &kinds[i];
    return NULL;
}

const vv_measure_kind *vv_measure_kind_of(const vv_measurement *question)
{
    return vv_measure_kind_find(vv_class_find(&vvi_measurement_class, "what")->names[question->what]);
}

static bool has_points(const vv_measure_form *form, size_t n)
{
    return form->n_points == 0 || form->n_points == n;
}

const vv_measure_form *vv_measure_form_of(const vv_measure_kind *kind, unsigned input, unsigned other, size_t n_points)
{
    for (const vv_measure_form *form = kind->forms; form->run; form++)
        if ((form->input & input) && (other ? form->other & other : !form->other) && has_points(form, n_points))
            return form;
    return NULL;
}

/* "area, volume and box": kinds that have a form of such data. */
static void list_kinds(vvi_text *out, unsigned input)
{
    const char *names[N_KINDS];
    size_t n = 0;
    for (size_t i = 0; i < N_KINDS; i++) {
        unsigned of = 0;
        for (const vv_measure_form *form = kinds[i].forms; form->run; form++)
            of |= form->input;
        if ((of & input) && !kinds[i].covers)
            names[n++] = kinds[i].name;
    }
    for (size_t i = 0; i < n; i++)
        vvi_text_printf(out, "%s%s", i == 0 ? "" : i + 1 < n ? ", " : " and ", names[i]);
}

vv_status vvi_measure_refuse(const vv_measure_kind *kind, unsigned input, const char *name)
{
    vvi_text shown = {0}, mesh = {0};
    vv_status st = VV_E_ARGUMENT;
    list_kinds(&shown, SHOWN);
    list_kinds(&mesh, MESH);
    if (shown.bad || mesh.bad)
        st = vv_fail_memory(shown.n + mesh.n);
    else if (input == SHOWN)
        vv_fail(st, "%s shows meshes, of which %s are measured where it places them, and no %s", name, shown.s,
                kind->name);
    else if (input == MESH)
        vv_fail(st, "%s is a mesh, which has %s; no %s", name, mesh.s, kind->name);
    else
        vv_fail(st, "%s: no %s is measured of such data", name, kind->name);
    vvi_text_free(&shown);
    vvi_text_free(&mesh);
    return st;
}

/* Running --------------------------------------------------------------------------------------------------------- */

bool vvi_asks(const vvi_measuring *m, const char *property)
{
    return vv_object_is_set(&m->asked->base, property);
}

static unsigned is_what(const vv_measured_data *data)
{
    return !data ? 0 : data->field ? VOLUME : data->shown ? SHOWN : MESH;
}

/* Words of data, for sentences. */
static const char *sort_of(const vvi_measuring *m)
{
    const unsigned is = is_what(m->inputs->input);
    return m->inputs->other ? "and a second surface"
           : is == MESH     ? "a mesh"
           : is == SHOWN    ? "a mesh of a scene"
                            : "a volume";
}

/* Whether a property asks for something: others name the measurement, its data, or what came out of it. */
static bool asks_of(const vvi_measuring *m, const char *name)
{
    const vv_measurement *q = m->asked;
    if (!vvi_asks(m, name) || vvi_measure_has_word("title what file other figures volume visible", name))
        return false;
    if (strcmp(name, "region") == 0)
        return vvi_measurement_has_region(q);
    if (strcmp(name, "cut_planes") == 0)
        return q->cut_planes->n > 0;
    if (strcmp(name, "points") == 0)
        return q->points && q->points->n > 0;
    /* how places are told, of which there are none; those on a mesh are in its own space anyway */
    if (strcmp(name, "space") == 0)
        return q->space != VV_MEASURE_IN_WORLD &&
               (vvi_measure_has_word(m->uses, "points") || vvi_measurement_has_region(q));
    return true;
}

/* A part or an object that would be ignored is the answer to another question. */
static vv_status refuse_unused(const vvi_measuring *m)
{
    for (const vv_property *row = vvi_measurement_class.properties; row->name; row++)
        if (asks_of(m, row->name) && !vvi_measure_has_word(m->uses, row->name))
            return vv_fail(VV_E_ARGUMENT, "'%s' has no effect on the %s of %s, %s: leave it out", row->name,
                           vv_measure_kind_of(m->asked)->name, m->inputs->input->name, sort_of(m));
    return VV_OK;
}

/* A volume is opened before, unless a surface of it is meant. */
static vv_status run_form(vvi_measuring *m, const vv_measure_form *form)
{
    vv_answer *answer = m->answer;
    m->uses = form->uses;
    const bool opened = m->input->field && !(form->what & VVI_SURFACE);
    vv_status st = refuse_unused(m);
    if (st == VV_OK && opened)
        st = vvi_measuring_open(m);
    m->what = form->what;
    if (st == VV_OK && opened)
        vvi_tell_text(answer, "region", m->region);
    if (st == VV_OK && (st = form->run(m)) == VV_OK && opened && (st = vvi_measuring_put_region(m)) == VV_OK) {
        snprintf(answer->object, sizeof answer->object, "%s", m->object);
        snprintf(answer->region, sizeof answer->region, "%s", vvi_measuring_is_part(m) ? m->region : "");
    }
    if (st == VV_OK)
        vvi_measuring_put_step(m);
    vvi_measuring_close(m);
    return st;
}

vv_status vv_measure_run(vv_answer **out, const vv_measurement *question, const vv_measured_inputs *inputs, vv_job *job)
{
    const vv_measure_kind *kind = vv_measure_kind_of(question);
    vv_answer *answer = *out = vvi_calloc(1, sizeof *answer);
    if (!answer)
        return vv_fail_memory(sizeof *answer);
    if (!inputs->n_inputs)
        return vv_fail(VV_E_ARGUMENT, "%s: there is nothing to measure", kind->name);
    const size_t n_points = question->points ? question->points->n / 3 : 0;
    const unsigned is = is_what(inputs->input);
    const vv_measure_form *form = vv_measure_form_of(kind, is, is_what(inputs->other), n_points);
    vvi_measuring m = {.asked = question, .inputs = inputs, .input = inputs->input, .answer = answer, .job = job};
    const vv_status st = form ? run_form(&m, form) : vvi_measure_refuse(kind, is, inputs->input->name);
    return st == VV_OK && answer->bad ? vv_fail_memory(answer->n * sizeof *answer->item) : st;
}

bool vvi_measure_has_word(const char *list, const char *word)
{
    const size_t n = strlen(word);
    for (const char *at = list; at && (at = strstr(at, word)) != NULL; at += n)
        if ((at == list || at[-1] == ' ') && (at[n] == ' ' || at[n] == 0))
            return true;
    return false;
}
