/* From a question to what is measured: the object, the region, the method. */
#include "core/units.h"
#include "core/vec.h"
#include "filter/crop.h"
#include "grid/fill_value.h"
#include "grid/label_id.h"
#include "grid/label_sense.h"
#include "measure/object.h"
#include "measuring/figure_changes.h"
#include "measuring/measuring.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Region ---------------------------------------------------------------------------------------------------------- */

vv_status vvi_measuring_box(vv_box *out, const char *typed, const vv_grid *grid)
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

size_t vvi_measuring_planes(vv_plane out[VVI_PLANES_MOST], const vvi_measuring *m)
{
    const vv_grid *grid = &vv_field_get_info(m->field)->grid;
    vv_affine inverse;
    memcpy(out, m->planes, m->n_planes * sizeof *out);
    size_t n = m->n_planes;
    for (int a = 0; m->asked->box && a < 3 && vv_affine_invert(&inverse, grid->index_to_world); a++) {
        const double lo = (double)m->choice.box.lo[a], hi = lo + (double)m->choice.box.n[a] - 1;
        const vv_plane from = {vvi_vec(a == 0, a == 1, a == 2), lo}, to = {vvi_scaled(from.normal, -1), -hi};
        if (lo > 0)
            out[n++] = vvi_plane_mapped(&from, &inverse);
        if (hi < (double)(grid->dims[a] - 1))
            out[n++] = vvi_plane_mapped(&to, &inverse);
    }
    return n;
}

/* Those of the scene, and those that are asked for. */
static void take_planes(vvi_measuring *m)
{
    const size_t most = sizeof m->planes / sizeof *m->planes;
    const vv_collection *asked = m->asked->cut_planes;
    for (size_t i = 0; i < m->input->n_planes && m->n_planes < most; i++)
        m->planes[m->n_planes++] = m->input->planes[i];
    for (size_t i = 0; asked && i < asked->n && m->n_planes < most; i++) {
        const vv_cut_plane *p = (const vv_cut_plane *)(const void *)asked->entry[i].object;
        vv_vec3 n = p->normal;
        vvi_unit(&n);
        if (p->on)
            m->planes[m->n_planes++] = (vv_plane){n, p->offset};
    }
}

/* "polygon of 5 corners, box of samples .., 2 cut planes" */
static void name_region(vvi_measuring *m)
{
    const char *box = m->asked->box;
    char part[3][64] = {"", "", ""};
    vvi_measuring_name_region(part[0], m);
    snprintf(part[1], sizeof part[1], "%s%s", box ? "box of samples " : "", box ? box : "");
    if (m->n_planes)
        snprintf(part[2], sizeof part[2], "%zu %s", m->n_planes, vvi_plural(m->n_planes, "cut plane", "cut planes"));
    *m->region = 0;
    for (size_t i = 0, n = 0; i < 3; i++, n = strlen(m->region))
        snprintf(m->region + n, sizeof m->region - n, "%s%s", n && *part[i] ? ", " : "", part[i]);
    if (!*m->region)
        snprintf(m->region, sizeof m->region, "all");
}

static vv_status choose_region(vvi_measuring *m)
{
    const char *box = m->asked->box;
    vv_status st = box ? vvi_measuring_box(&m->choice.box, box, &vv_field_get_info(m->field)->grid) : VV_OK;
    if (st == VV_OK)
        st = vvi_measuring_take_region(m);
    take_planes(m);
    m->choice.planes = m->planes;
    m->choice.n_planes = m->n_planes;
    name_region(m);
    return st;
}

bool vvi_measuring_is_part(const vvi_measuring *m)
{
    return strcmp(m->region, "all") != 0;
}

const char *vvi_measuring_in(const vvi_measuring *m, const char **region_out)
{
    *region_out = vvi_measuring_is_part(m) ? m->region : "";
    return vvi_measuring_is_part(m) ? " in " : "";
}

/* Object ---------------------------------------------------------------------------------------------------------- */

static vv_status to_index(vv_vec3 *out, const vvi_measuring *m, const char *option, vv_vec3 asked)
{
    vv_affine inverse;
    *out = asked;
    if (m->asked->space == VV_MEASURE_IN_INDEX || !m->field) /* of a mesh: in its own space */
        return VV_OK;
    if (!vv_affine_invert(&inverse, vv_field_get_info(m->field)->grid.index_to_world))
        return vv_fail(VV_E_ARGUMENT, "--%s: the grid's axes lie in one plane; give numbers of samples", option);
    *out = vv_affine_point(inverse, asked);
    return VV_OK;
}

vv_status vvi_measuring_points(vv_vec3 *out, size_t n, const vvi_measuring *m, const char *what)
{
    const vv_numbers *points = m->asked->points;
    const size_t given = points ? points->n / 3 : 0;
    vv_status st = VV_OK;
    if (given != n)
        return vv_fail(VV_E_ARGUMENT, "%s needs --point X,Y,Z %s; there are %zu", what,
                       n == 1   ? "once"
                       : n == 2 ? "twice"
                                : "three times",
                       given);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = to_index(&out[i], m, "point", vvi_vec(points->v[3 * i], points->v[3 * i + 1], points->v[3 * i + 2]));
    return st;
}

const char *vvi_point_print(char out[VVI_POINT_TEXT], vv_vec3 p)
{
    char number[3][32];
    vvi_print_number(number[0], p.x);
    vvi_print_number(number[1], p.y);
    vvi_print_number(number[2], p.z);
    snprintf(out, VVI_POINT_TEXT, "%s,%s,%s", number[0], number[1], number[2]);
    return out;
}

static vv_status take_seed(vvi_measuring *m)
{
    vv_vec3 at;
    const vv_status st = to_index(&at, m, "seed", m->asked->seed);
    if (st != VV_OK)
        return st;
    const double p[3] = {nearbyint(at.x), nearbyint(at.y), nearbyint(at.z)};
    for (int a = 0; a < 3; a++) {
        char text[VVI_POINT_TEXT];
        if (!(p[a] >= -0.5 && p[a] < (double)vv_field_get_info(m->field)->grid.dims[a]))
            return vv_fail(VV_E_ARGUMENT, "--seed: %s is outside the volume%s", vvi_point_print(text, m->asked->seed),
                           m->asked->space == VV_MEASURE_IN_INDEX
                               ? ": numbers of samples are meant, or lengths with --space world"
                               : "");
        m->choice.seed[a] = (int64_t)p[a];
    }
    m->choice.seeded = true;
    return VV_OK;
}

static void name_range(vvi_measuring *m, const char *why)
{
    const vv_measure_options *c = &m->choice;
    const char *unit = vv_field_get_info(m->field)->value_unit;
    if (c->hi == INFINITY)
        snprintf(m->object, sizeof m->object, "values of %.9g%s%s or more%s", c->lo, *unit ? " " : "", unit, why);
    else if (c->lo == -INFINITY)
        snprintf(m->object, sizeof m->object, "values of %.9g%s%s or less%s", c->hi, *unit ? " " : "", unit, why);
    else
        snprintf(m->object, sizeof m->object, "values from %.9g to %.9g%s%s%s", c->lo, c->hi, *unit ? " " : "", unit,
                 why);
}

void vvi_measuring_take_label(vvi_measuring *m, vv_label_id label, const char *called)
{
    char digits[VVI_LABEL_DIGITS];
    m->choice.object = VV_OBJECT_LABEL;
    m->choice.label = label;
    m->chosen = true;
    vvi_label_print(digits, label, vvi_label_is_unsigned(vv_field_get_info(m->field)->type));
    snprintf(m->object, sizeof m->object, "label %s", called ? called : digits);
}

static vv_status take_mask(vvi_measuring *m)
{
    m->choice.object = VV_OBJECT_MASK;
    const vv_status st = vvi_measuring_beside(&m->mask, m, m->inputs->mask, true);
    m->choice.mask = m->mask;
    snprintf(m->object, sizeof m->object, "where %.100s is not 0", m->asked->mask);
    return st;
}

/* What the scene shows, where nothing else is asked for. */
static void take_shown(vvi_measuring *m)
{
    m->chosen = m->of_scene = m->input->ranged && !m->choice.region;
    if (m->of_scene) {
        m->choice.lo = m->input->lo;
        m->choice.hi = m->input->hi;
    }
}

static vv_status choose_object(vvi_measuring *m)
{
    const vv_measurement *asked = m->asked;
    vv_measure_options *c = &m->choice;
    const bool iso = vvi_asks(m, "iso"), label = vvi_asks(m, "label");
    const bool from = vvi_asks(m, "threshold_lo"), to = vvi_asks(m, "threshold_hi");
    const int given = iso + (from || to) + label + (asked->mask != NULL);
    if (given > 1)
        return vv_fail(VV_E_ARGUMENT, "--iso, --threshold, --label and --mask each name an object: give one of them");
    if (given == 0)
        take_shown(m);
    m->chosen |= given > 0;
    if (iso || from)
        c->lo = iso ? asked->iso : asked->threshold_lo;
    if (to)
        c->hi = asked->threshold_hi;
    if (m->chosen)
        name_range(m, m->of_scene ? ", as in the scene" : "");
    if (label)
        vvi_measuring_take_label(m, asked->label, m->input->called);
    return asked->mask ? take_mask(m) : VV_OK;
}

static void choose_method(vvi_measuring *m)
{
    const bool counted = m->choice.region && m->asked->method == VV_MEASURE_AUTO;
    m->choice.method =
        counted ? VV_MEASURE_COUNT : vvi_object_method(m->choice.object, (vv_measure_method)m->asked->method);
}

void vvi_measuring_label_method(vvi_measuring *m)
{
    m->choice.method = m->asked->method == VV_MEASURE_CUBES ? VV_MEASURE_CUBES : VV_MEASURE_COUNT;
}

bool vvi_measuring_count_steps(vvi_measuring *m)
{
    if (m->asked->method != VV_MEASURE_AUTO)
        return false;
    m->choice.method = VV_MEASURE_COUNT;
    return true;
}

vv_status vvi_measuring_of_labels(bool *out, bool *sensed, bool *untold, const vvi_measuring *m)
{
    const vv_field_info *info = vv_field_get_info(m->field);
    const int says = m->input->says_labels;
    size_t n = 0;
    vv_status st = VV_OK;
    if (says == 0 && info->meaning == VV_MEANING_SCALAR && info->components == 1)
        st = vvi_label_sense(&n, m->field, m->choice.component, m->job);
    *untold = st == VV_E_LIMIT || st == VV_E_MEMORY; /* what goes through slab by slab is not looked at whole */
    *sensed = n > 0;
    *out = *sensed || says > 0 || (says == 0 && info->meaning == VV_MEANING_LABEL);
    return *untold ? VV_OK : st;
}

/* Above the value that splits the histogram, or below it where what lies above surrounds the object; a fill is no part
 * of it. */
static vv_status choose_values(vvi_measuring *m, const vv_statistics *s)
{
    vv_job *job = m->job;
    vvi_value_fit fit;
    vvi_fills fills;
    vv_status st = vvi_fit_without_fill(&fit, &fills, m->field, m->choice.component, s, "measure", job);
    if (st == VV_OK && fills.n == 0)
        st = vvi_fit_field(&fit, m->field, m->choice.component, s, job);
    if (st != VV_OK)
        return st;
    m->automatic = true;
    m->choice.lo = fit.empty ? 0 : fit.constant ? s->min : fit.falls ? -INFINITY : fit.split;
    m->choice.hi = fit.falls && !fit.empty && !fit.constant ? fit.split : vvi_fills_above(&fills) ? fills.hi : INFINITY;
    name_range(m, fit.empty      ? " (no sample is a number: nothing is separated)"
                  : fit.constant ? " (all samples are equal: nothing is separated; --iso sets another)"
                  : fit.falls ? " (chosen: it best splits the histogram in two, and larger values surround the object; "
                                "--iso sets another)"
                              : " (chosen: it best splits the histogram in two; --iso sets another)");
    return VV_OK;
}

void vvi_measuring_take_surface(vvi_measuring *m)
{
    if (!m->automatic || m->choice.lo != -INFINITY)
        return;
    m->choice.lo = m->choice.hi;
    m->choice.hi = INFINITY;
    name_range(m, " (chosen: it best splits the histogram in two; --iso sets another)");
}

/* Surfaces between a fill and values are none, and no object is of it. */
static vv_status take_missing(vvi_measuring *m)
{
    const double asked[2] = {m->choice.lo, m->choice.hi};
    const vvi_missing missing = {.asked = asked, .n_asked = m->chosen ? 2 : 0, .keep = "; --missing none keeps them"};
    if (m->took_missing || m->choice.object != VV_OBJECT_RANGE)
        return VV_OK;
    m->took_missing = true;
    return vvi_field_take_missing(&m->field, &m->choice.component, &missing, "measure", m->job);
}

vv_status vvi_measuring_choose(vvi_measuring *m)
{
    bool labels = false, sensed = false, untold = false;
    vv_statistics *s = NULL;
    vv_status st = VV_OK;
    if (m->chosen)
        return take_missing(m);
    if (m->choice.region) {
        snprintf(m->object, sizeof m->object, "all samples");
        return VV_OK;
    }
    if ((st = vvi_measuring_of_labels(&labels, &sensed, &untold, m)) != VV_OK)
        return st;
    if (untold)
        vvi_tell_note(m->answer, "too large for the memory limit to tell whether these are labels; taken for values");
    if (!labels && (st = take_missing(m)) != VV_OK)
        return st;
    m->chosen = true;
    if (labels) {
        m->choice.object = VV_OBJECT_MASK;
        m->choice.mask = m->field;
        snprintf(m->object, sizeof m->object, "all labels but 0%s",
                 sensed ? " (values look like labels; --iso sets a value)" : "");
        choose_method(m);
        return VV_OK;
    }
    s = malloc(sizeof *s);
    if (!s)
        return vv_fail_memory(sizeof *s);
    if ((st = vv_field_statistics(s, m->field, m->choice.component, m->job)) == VV_OK)
        st = choose_values(m, s);
    free(s);
    return st;
}

void vvi_measuring_put_seed(vvi_measuring *m)
{
    const int64_t *at = m->choice.seed;
    if (!m->choice.seeded || m->told_seed)
        return;
    m->told_seed = true;
    vvi_tell_numbers(m->answer, "seed", (double[]){(double)at[0], (double)at[1], (double)at[2]}, 3);
}

void vvi_measuring_note_empty(vvi_measuring *m)
{
    if (m->told_empty)
        return;
    m->told_empty = true;
    const char *region, *where = vvi_measuring_in(m, &region);
    if (m->choice.object == VV_OBJECT_LABEL)
        vvi_tell_note(m->answer, "there is no %s%s%s: the object is empty", m->object, where, region);
    else
        vvi_tell_note(m->answer, "the object, %s%s%s, is empty", m->object, where, region);
}

vv_status vvi_measuring_open(vvi_measuring *m)
{
    const vv_measured_data *input = m->input;
    vv_status st;
    vv_measure_options_init(&m->choice, sizeof m->choice);
    m->field = vv_field_retain(input->field);
    m->choice.closed = m->asked->closed;
    m->choice.component = vvi_asks(m, "component") ? (int)m->asked->component : input->component;
    if ((st = choose_region(m)) == VV_OK && (st = choose_object(m)) == VV_OK && vvi_asks(m, "seed"))
        st = take_seed(m);
    choose_method(m);
    return st;
}

void vvi_measuring_close(vvi_measuring *m)
{
    vv_field_release(m->field);
    vv_field_release(m->mask);
    m->field = m->mask = NULL;
    free(m->outline);
    m->outline = NULL;
}

void vvi_measuring_put_step(vvi_measuring *m)
{
    const vv_measured_data *input = m->inputs->input;
    const vv_field_info *info = input->field ? vv_field_get_info(input->field) : NULL;
    if (!info || input->n_frames < 2)
        return;
    char at[64] = "";
    if (info->frame_step > 0)
        snprintf(at, sizeof at, ", at %.6g %s", (double)input->frame * info->frame_step, info->frame_unit);
    vvi_tell_line(m->answer, "time step", "%lld of 0 to %lld%s", (long long)input->frame,
                  (long long)input->n_frames - 1, at);
    vvi_tell_count(m->answer, VVI_TIME_STEP, (uint64_t)input->frame);
    vvi_tell_figure_for(m->answer, &(vvi_figure){VVI_TIME_STEP, "", (double)input->frame, NAN, ""},
                        VV_FOR_TABLES | VV_FOR_SCENES);
}

/* Plots ----------------------------------------------------------------------------------------------------------- */

/* Cut between letters, with an ellipsis, where it is too long. */
static void shorten(char *text, size_t room)
{
    size_t end = room - 4;
    if (strlen(text) < room)
        return;
    while (end && ((unsigned char)text[end] & 0xc0) == 0x80)
        end--;
    memcpy(text + end, "\xe2\x80\xa6", 4);
}

const char *vvi_measuring_subset(const vvi_measuring *m, bool object)
{
    char all[sizeof m->object + sizeof m->region + 64];
    const char *region, *in = vvi_measuring_in(m, &region);
    snprintf(all, sizeof all, "%s%s%s%s", object ? m->object : "",
             m->choice.seeded ? "; the piece around the seed" : "",
             object && *in ? "; in "
             : *in         ? "in "
                           : "",
             region);
    shorten(all, 110);
    return vvi_answer_copy(m->answer, all);
}

const char *vvi_measuring_title(const vvi_measuring *m)
{
    const char *slash = strrchr(m->input->name, '/');
    return slash ? slash + 1 : m->input->name;
}
