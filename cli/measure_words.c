/* From words to a question: the words for kinds, and what is typed as options. */
#include "channel_names.h"
#include "core/names.h"
#include "core/units.h"
#include "grid/label_id.h"
#include "label_layers.h"
#include "label_names.h"
#include "measure.h"
#include "model/classes.h"
#include "value.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Kinds ----------------------------------------------------------------------------------------------------------- */

const char *cli_measure_word_nth(size_t index)
{
    size_t n = 0;
    while (vv_measure_kind_nth(n))
        n++;
    return index < n ? vv_measure_kind_nth(index)->name : index == n ? CLI_MEASURE_STORED : NULL;
}

const vv_measure_kind *cli_measure_kind(const char *word)
{
    return access(word, F_OK) != 0 ? vv_measure_kind_find(word) : NULL;
}

bool cli_measure_is_stored(const char *word)
{
    return strcmp(word, CLI_MEASURE_STORED) == 0 && access(word, F_OK) != 0;
}

const vv_measure_kind *cli_measure_default_kind(void)
{
    static const vv_measurement nothing = {.base = {.cls = &vvi_measurement_class}};
    return vv_measure_kind_of(&nothing);
}

size_t cli_measure_most_files(const vv_measure_kind *kind)
{
    for (const vv_measure_form *form = kind->forms; form->run; form++)
        if (form->other)
            return 2;
    return 1;
}

static bool has_word(const char *list, const char *word)
{
    const size_t n = strlen(word);
    for (const char *at = list; at && (at = strstr(at, word)) != NULL; at += n)
        if ((at == list || at[-1] == ' ') && (at[n] == ' ' || at[n] == 0))
            return true;
    return false;
}

/* Other words for them, and beginnings of them. */
static const char *nearest_kind(const char *word, const char *const *names, size_t n)
{
    for (size_t i = 0; vv_measure_kind_nth(i); i++)
        if (has_word(vv_measure_kind_nth(i)->also, word))
            return vv_measure_kind_nth(i)->name;
    for (size_t i = 0; i < n; i++)
        if (strlen(word) > 2 && strncmp(word, names[i], strlen(word)) == 0)
            return names[i];
    return vv_nearest_name(word, names, n);
}

vv_status cli_measure_fail_kind(const char *word)
{
    enum { MOST = 32 };
    const char *names[MOST];
    size_t n = 0;
    for (; n < MOST && cli_measure_word_nth(n); n++)
        names[n] = cli_measure_word_nth(n);
    const char *near = nearest_kind(word, names, n); /* as if it had been typed: other words are near to none */
    return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, near ? near : word, &(vvi_known){names, n, NULL, NULL},
                         "measure: no '%s' can be measured", word);
}

/* Names of labels and channels ------------------------------------------------------------------------------------ */

/* A name, or a number; one that is of another layer of the file than the one that is read is told. */
static vv_status find_label(vv_label_id *out, const cli_command *command, const cli_measured *in, const char *option,
                            const char *typed)
{
    const cli_label_names names = cli_label_names_of(command, &in->input);
    const vv_type type = vv_field_get_info(in->volume.field)->type;
    bool known;
    vv_status st = cli_label_find(out, &known, &names, option, typed, strlen(typed));
    vv_label_id number;
    if (st != VV_OK || (known && !vvi_label_parse(&number, typed, vvi_label_is_unsigned(type))))
        return st;
    if (vvi_label_parse(out, typed, vvi_label_is_unsigned(type)))
        return cli_label_layer_check(command, &in->input, *out);
    if (vvi_label_parse(out, typed, true))
        return vv_fail(VV_E_ARGUMENT, "--%s: no sample is %s: they are %s, which end at 2^63", option, typed,
                       vv_type_name(type));
    return vv_fail(VV_E_ARGUMENT, "--%s: expected a whole number%s, found '%s'", option,
                   strpbrk(typed, "eE.") && strchr("+-.0123456789", *typed) ? ", with all of its digits" : "", typed);
}

static void add_key(vvi_text *out, const char *name)
{
    vvi_text_printf(out, ", \"%s\": ", name);
}

static void add_label(vvi_text *out, const char *name, vv_label_id id)
{
    char digits[VVI_LABEL_DIGITS];
    add_key(out, name);
    vvi_text_printf(out, "\"%s\"", vvi_label_print(digits, id, false));
}

/* --label is of both of two surfaces, in each as its file calls labels. */
static vv_status add_labels(vvi_text *out, cli_command *command, const cli_measure_options *o, cli_measured_inputs *in)
{
    cli_measured *both[] = {&in->first, &in->second};
    vv_label_id found[2] = {0};
    bool some = false;
    for (int i = 0; i < 2; i++) {
        const bool other = i == 1 && o->other_label;
        const char *typed = other ? o->other_label : o->label;
        if (!both[i]->volume.field || !typed)
            continue;
        const vv_status st = find_label(&found[i], command, both[i], other ? "other-label" : "label", typed);
        if (st != VV_OK)
            return st;
        both[i]->volume.data.called = typed;
        if (other || (some && found[1] != found[0] && !o->other_iso))
            add_label(out, "other_label", found[i]);
        else if (!some)
            add_label(out, "label", found[i]);
        some = some || !other;
    }
    return VV_OK;
}

/* With --values the channel is one of theirs: what they are called is not known here. */
static vv_status add_channel(vvi_text *out, const cli_measure_options *o, const cli_measured_inputs *in)
{
    const cli_input *input = in->first.volume.field ? &in->first.input : &in->second.input;
    const char *typed = o->component;
    vvi_text number = {0};
    if (!typed)
        return VV_OK;
    const size_t digits = strspn(typed, "0123456789");
    if (strchr(typed, ',') || (o->values && (typed[digits] || digits > 8)))
        return vv_fail(VV_E_ARGUMENT, "--channel: expected one channel%s, found '%.60s'",
                       o->values ? " of --values, by its number" : "", typed);
    const vv_status st = o->values ? VV_OK : cli_channel_numbers(&number, input, typed);
    add_key(out, "component");
    vvi_text_printf(out, "%ld", strtol(number.s ? number.s : typed, NULL, 10));
    vvi_text_free(&number);
    return st;
}

/* Numbers --------------------------------------------------------------------------------------------------------- */

static vv_status add_number(vvi_text *out, const char *name, const char *option, const char *typed)
{
    char number[32];
    double v;
    if (!typed)
        return VV_OK;
    if (!vvi_parse_number(&v, typed))
        return vv_fail(VV_E_ARGUMENT, "--%s: expected a number, found '%s'", option, typed);
    vvi_print_number(number, v);
    add_key(out, name);
    vvi_text_add(out, number);
    return VV_OK;
}

static void add_numbers(vvi_text *out, const double *v, size_t n)
{
    for (size_t i = 0; i < n; i++)
        vvi_text_printf(out, "%s%.17g", i ? ", " : "[", v[i]);
    vvi_text_add(out, "]");
}

static vv_status add_point(vvi_text *out, const char *option, const char *typed)
{
    double p[3];
    if (cli_value_numbers(p, 3, typed, false) != VV_OK)
        return vv_fail(VV_E_ARGUMENT, "--%s: expected X,Y,Z, as in 80,90,60, found '%s'", option, typed);
    add_numbers(out, p, 3);
    return VV_OK;
}

static vv_status add_places(vvi_text *out, const cli_measure_options *o)
{
    vv_status st = VV_OK;
    if (o->seed) {
        add_key(out, "seed");
        st = add_point(out, "seed", o->seed);
    }
    if (!o->point || !o->point->n)
        return st;
    add_key(out, "points");
    for (size_t i = 0; i < o->point->n && st == VV_OK; i++) {
        vvi_text_add(out, i ? ", " : "[");
        st = add_point(out, "point", cli_word_nth(o->point, i));
    }
    vvi_text_add(out, "]");
    return st;
}

/* LO..HI; what is left out is unlimited. */
static vv_status add_threshold(vvi_text *out, const char *typed)
{
    char end[2][64];
    double v[2] = {-INFINITY, INFINITY};
    static const char *const names[] = {"threshold_lo", "threshold_hi"};
    if (!typed)
        return VV_OK;
    if (!cli_value_split_range(end[0], end[1], typed) || (*end[0] && !vvi_parse_number(&v[0], end[0])) ||
        (*end[1] && !vvi_parse_number(&v[1], end[1])))
        return vv_fail(VV_E_ARGUMENT, "--threshold: expected LO..HI, as in 90..300, 90.. or 90, found '%s'", typed);
    if (!(v[0] <= v[1]))
        return vv_fail(VV_E_ARGUMENT, "--threshold: LO is above HI in '%s'; exchange them", typed);
    for (int i = 0; i < 2; i++)
        add_number(out, names[i], "threshold", *end[i] ? end[i] : NULL);
    return VV_OK;
}

static vv_status add_range(vvi_text *out, const char *typed)
{
    double range[2];
    if (!typed)
        return VV_OK;
    if (cli_value_numbers(range, 2, typed, false) != VV_OK)
        return vv_fail(VV_E_ARGUMENT, "--range: expected LO..HI, as in 0..300, found '%s'", typed);
    add_key(out, "range");
    vvi_text_add(out, "[");
    add_numbers(out, range, 2);
    vvi_text_add(out, "]");
    return VV_OK;
}

/* Properties that both have, with the same name and of the same kind. */
static void add_same(vvi_text *out, const vv_object *options)
{
    for (const vv_property *p = options->cls->properties; p->name; p++) {
        const vv_property *same = vv_class_find(&vvi_measurement_class, p->name);
        char *json = NULL;
        if (!same || same->kind != p->kind || !vv_object_is_set(options, p->name) ||
            vv_path_get(&json, options, p->name) != VV_OK)
            continue;
        add_key(out, p->name);
        vvi_text_add(out, json);
        free(json);
    }
}

vv_status cli_measure_words(vv_measurement **out, cli_command *command, const cli_question *q, cli_measured_inputs *in)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    vv_object *asked = NULL;
    vvi_text json = {0};
    vv_status st;
    vvi_text_add(&json, "{\"what\": ");
    vvi_text_json(&json, q->kind->name);
    if ((st = add_channel(&json, o, in)) == VV_OK && (st = add_number(&json, "iso", "iso", o->iso)) == VV_OK &&
        (st = add_threshold(&json, o->threshold)) == VV_OK && (st = add_labels(&json, command, o, in)) == VV_OK &&
        (st = add_number(&json, "other_iso", "other-iso", o->other_iso)) == VV_OK &&
        (st = add_places(&json, o)) == VV_OK)
        st = add_range(&json, o->range);
    add_same(&json, &o->base);
    if (in->planes.n)
        vvi_text_printf(&json, ", \"cut_planes\": [%s]", in->planes.s);
    vvi_text_add(&json, "}");
    if (st == VV_OK && (json.bad || in->planes.bad))
        st = vv_fail_memory(json.n);
    if (st == VV_OK)
        st = vv_object_from_json(&asked, &vvi_measurement_class, json.s, json.n, NULL);
    vvi_text_free(&json);
    *out = (vv_measurement *)(void *)asked;
    return st;
}
