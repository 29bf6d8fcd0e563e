/* From words to what is measured: the object, the region, the method. */
#include "channel_names.h"
#include "core/units.h"
#include "core/vec.h"
#include "filter/crop.h"
#include "grid/fill_value.h"
#include "grid/label_id.h"
#include "grid/label_sense.h"
#include "label_layers.h"
#include "label_names.h"
#include "measure.h"
#include "refusal.h"
#include "value.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

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
        snprintf(m->region + strlen(m->region), sizeof m->region - strlen(m->region), "%zu %s", m->n_planes,
                 cli_plural(m->n_planes, "cut plane", "cut planes"));
    return st;
}

/* Object ---------------------------------------------------------------------------------------------------------- */

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
    else if (c->lo == -INFINITY)
        snprintf(m->object, sizeof m->object, "values of %.9g%s%s or less%s", c->hi, *unit ? " " : "", unit, why);
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
        return cli_refused(
            m->command, "iso,threshold,label,mask",
            vv_fail(VV_E_ARGUMENT, "--iso, --threshold, --label and --mask each name an object: give one of them"));
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
        st = cli_measuring_label(&c->label, m, "label", o->label);
        snprintf(m->object, sizeof m->object, "label %s", o->label);
    }
    if (st == VV_OK && o->mask) {
        c->object = VV_OBJECT_MASK;
        st = cli_measuring_beside(&m->mask, m, &m->mask_input, &m->mask_stream, true, o->mask);
        c->mask = m->mask;
        snprintf(m->object, sizeof m->object, "where %.100s is not 0", o->mask);
    }
    return st;
}

vv_status cli_measuring_label(vv_label_id *out, const cli_measuring *m, const char *option, const char *typed)
{
    const cli_label_names names = cli_label_names_of(m->command, &m->input);
    const bool is_unsigned = vvi_label_is_unsigned(vv_field_get_info(m->field)->type);
    const bool other = strcmp(option, "label") != 0;
    bool known;
    vv_status st = cli_label_find(out, &known, &names, option, typed, strlen(typed));
    if (st != VV_OK)
        return st;
    vvi_label_print(m->result->label[other], *out, is_unsigned);
    if (!vvi_label_parse(out, typed, is_unsigned) && known) /* a name: it is in this layer */
        return vvi_label_parse(out, m->result->label[other], is_unsigned) ? VV_OK : VV_E_INTERNAL;
    m->result->label[other][0] = 0;
    st = cli_label_parse(out, option, typed, vv_field_get_info(m->field)->type);
    return st == VV_OK ? cli_label_layer_check(m->command, &m->input, *out) : st;
}

static void choose_method(cli_measuring *m)
{
    const bool steps = m->choice.object != VV_OBJECT_RANGE;
    m->choice.method = m->o->method == CLI_METHOD_COUNT || (m->o->method == CLI_METHOD_AUTO && steps)
                           ? VV_MEASURE_COUNT
                           : VV_MEASURE_CUBES;
}

void cli_measuring_label_method(cli_measuring *m)
{
    m->choice.method = m->o->method == CLI_METHOD_CUBES ? VV_MEASURE_CUBES : VV_MEASURE_COUNT;
}

bool cli_measuring_count_steps(cli_measuring *m)
{
    if (m->o->method != CLI_METHOD_AUTO)
        return false;
    m->choice.method = VV_MEASURE_COUNT;
    return true;
}

/* The file says it, or pictures show these whole numbers as labels. */
static vv_status of_labels(bool *out, bool *sensed, const cli_measuring *m)
{
    const vv_field_info *info = vv_field_get_info(m->field);
    size_t n = 0;
    vv_status st = VV_OK;
    if (info->meaning == VV_MEANING_SCALAR && info->components == 1)
        st = vvi_label_sense(&n, m->field, m->choice.component, m->command->job);
    if (st == VV_E_LIMIT || st == VV_E_MEMORY) { /* what goes through slab by slab is not looked at whole */
        cli_command_note(m->command,
                         "too large for the memory limit to tell whether these are labels; taken for values");
        st = VV_OK;
    }
    *sensed = n > 0;
    *out = *sensed || info->meaning == VV_MEANING_LABEL;
    return st;
}

/* Above the value that splits the histogram, or below it where what lies above surrounds the object; a fill is no part
 * of it. */
static vv_status choose_values(cli_measuring *m, const vv_statistics *s)
{
    vv_job *job = m->command->job;
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

void cli_measuring_take_surface(cli_measuring *m)
{
    if (!m->automatic || m->choice.lo != -INFINITY)
        return;
    m->choice.lo = m->choice.hi;
    m->choice.hi = INFINITY;
    name_range(m, " (chosen: it best splits the histogram in two; --iso sets another)");
}

/* Surfaces between a fill and values are none, and no object is of it. */
static vv_status take_missing(cli_measuring *m)
{
    const double asked[2] = {m->choice.lo, m->choice.hi};
    const vvi_missing missing = {.asked = asked, .n_asked = m->chosen ? 2 : 0, .keep = "; --missing none keeps them"};
    if (m->took_missing || m->choice.object != VV_OBJECT_RANGE)
        return VV_OK;
    m->took_missing = true;
    return vvi_field_take_missing(&m->field, &m->choice.component, &missing, "measure", m->command->job);
}

vv_status cli_measuring_choose(cli_measuring *m)
{
    bool labels = false, sensed = false;
    vv_statistics *s = NULL;
    vv_status st = VV_OK;
    if (m->chosen)
        return take_missing(m);
    if ((st = of_labels(&labels, &sensed, m)) != VV_OK)
        return st;
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
    if ((st = vv_field_statistics(s, m->field, m->choice.component, m->command->job)) == VV_OK)
        st = choose_values(m, s);
    free(s);
    return st;
}

void cli_measuring_put_seed(cli_measuring *m)
{
    const int64_t *at = m->choice.seed;
    if (!m->choice.seeded || m->told_seed)
        return;
    m->told_seed = true;
    vvi_result_numbers(&m->command->json, "seed", (double[]){(double)at[0], (double)at[1], (double)at[2]}, 3);
}

void cli_measuring_note_empty(cli_measuring *m)
{
    if (m->told_empty)
        return;
    m->told_empty = true;
    const char *where = strcmp(m->region, "all") ? " in " : "";
    const char *region = *where ? m->region : "";
    if (m->choice.object == VV_OBJECT_LABEL)
        cli_command_note(m->command, "there is no %s%s%s: the object is empty", m->object, where, region);
    else
        cli_command_note(m->command, "the object, %s%s%s, is empty", m->object, where, region);
}

/* With --values the channel is one of theirs: what they are called is not known here. */
static vv_status choose_channel(cli_measuring *m)
{
    const char *typed = m->o->component;
    vvi_text number = {0};
    if (!typed)
        return VV_OK;
    const size_t digits = strspn(typed, "0123456789");
    if (strchr(typed, ',') || (m->o->values && (typed[digits] || digits > 8)))
        return vv_fail(VV_E_ARGUMENT, "--channel: expected one channel%s, found '%.60s'",
                       m->o->values ? " of --values, by its number" : "", typed);
    const vv_status st = m->o->values ? VV_OK : cli_channel_numbers(&number, &m->input, typed);
    m->choice.component = (int)strtol(number.s ? number.s : typed, NULL, 10);
    m->result->component = m->choice.component;
    vvi_text_free(&number);
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
    out->choice.closed = out->o->closed;
    vv_status st = cli_measuring_open_samples(out, word);
    if (st == VV_OK && (st = choose_channel(out)) == VV_OK && (st = choose_region(out)) == VV_OK &&
        (st = choose_object(out)) == VV_OK && out->o->seed)
        st = parse_seed(out);
    choose_method(out);
    return st;
}

void cli_measuring_close(cli_measuring *m)
{
    vv_field_release(m->field);
    vv_field_release(m->mask);
    vvi_stream_free(&m->stream);
    vvi_stream_free(&m->mask_stream);
    vvi_stream_free(&m->values_stream);
    cli_input_close(&m->input);
    cli_input_close(&m->mask_input);
    cli_input_close(&m->values_input);
}
