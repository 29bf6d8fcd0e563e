/* From words to a question: the words for kinds, and what is typed as options. */
#include "channel_names.h"
#include "core/names.h"
#include "grid/label_id.h"
#include "label_layers.h"
#include "label_names.h"
#include "measure.h"
#include "model/classes.h"
#include "refusal.h"
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const vv_property rows[] = {
    {VV_PROP(cli_measure_options, cut_planes), .option = "clip", .kind = VV_KIND_LIST, .cls = &cli_word_class,
     .unit = "CLIP",
     .doc = "only the part that x:10mm..60mm or 'plane(n=1,0,1 d=20mm)' keeps, as in 'volvis help render'; may be "
            "repeated; cut planes of a scene apply too"},
    {VV_PROP(cli_measure_options, log), .kind = VV_KIND_BOOL,
     .doc = "for a histogram's bars and plot: counts on a logarithmic scale"},
    {VV_PROP(cli_measure_options, store), .kind = VV_KIND_STRING, .unit = "[SCENE.vv.json:]NAME",
     .automatic = "not kept",
     .doc = "store the measurement and its results in a scene, under this name: in the scene that is measured, or in "
            "SCENE.vv.json, which is created if it does not exist"},
    {VV_PROP(cli_measure_options, update), .kind = VV_KIND_BOOL,
     .doc = "for stored measurements: store the new results"},
    {VV_PROP(cli_measure_options, csv), .kind = VV_KIND_BOOL, .doc = "the result as a table of comma-separated values"},
    {0},
};

const vv_class cli_measure_class = {
    .name = "measure",
    .doc = "options of measure beside the properties of a measurement",
    .size = sizeof(cli_measure_options),
    .properties = rows,
};

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

/* Other words for them, and beginnings of them. */
static const char *nearest_kind(const char *word, const char *const *names, size_t n)
{
    for (size_t i = 0; vv_measure_kind_nth(i); i++)
        if (vvi_measure_has_word(vv_measure_kind_nth(i)->also, word))
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

/* Options --------------------------------------------------------------------------------------------------------- */

const char *cli_measure_typed(const cli_command *command, const char *property)
{
    const char *typed = NULL;
    for (size_t i = 0; i < command->args.n_given; i++) {
        const cli_given *given = &command->args.given[i];
        if (given->cls == &vvi_measurement_class && strcmp(given->row->name, property) == 0)
            typed = given->text;
    }
    return typed;
}

/* What is typed of the region; what says nothing of its kind is refused. */
static vv_status take_region(vv_object **asked, const cli_command *command)
{
    vv_object *region = NULL;
    vv_status st = cli_args_object(&region, &command->args, &vvi_measured_region_class, NULL);
    if (st == VV_OK && (st = cli_refuse_idle(command, region, "")) == VV_OK)
        st = vv_path_put(asked, "region", region, NULL);
    vv_object_release(region);
    return st;
}

vv_status cli_measure_take(vv_measurement **out, const cli_command *command, const vv_measure_kind *kind)
{
    vv_object *asked = NULL;
    cli_args own = command->args;
    own.n_given = 0;
    own.given = calloc(command->args.n_given + 1, sizeof *own.given);
    if (!own.given)
        return vv_fail_memory(command->args.n_given * sizeof *own.given);
    for (size_t i = 0; i < command->args.n_given; i++)
        if (!cli_option_is_named(command->args.given[i].row))
            own.given[own.n_given++] = command->args.given[i];
    vv_status st = cli_args_object(&asked, &own, &vvi_measurement_class, NULL);
    free(own.given);
    if (st == VV_OK)
        st = take_region(&asked, command);
    if (st == VV_OK && kind)
        st = vv_path_set(&asked, "what", kind->name, NULL);
    *out = (vv_measurement *)(void *)asked;
    return st;
}

/* Names of labels and channels ------------------------------------------------------------------------------------ */

/* A name, or a number; one that is of another layer of the file than the one that is read is told. */
static vv_status find_label(vv_label_id *out, const cli_command *command, const cli_input *input, vv_type type,
                            const char *option, const char *typed)
{
    const cli_label_names names = cli_label_names_of(command, input);
    bool known;
    vv_status st = cli_label_find(out, &known, &names, option, typed, strlen(typed));
    vv_label_id number;
    if (st != VV_OK || (known && !vvi_label_parse(&number, typed, vvi_label_is_unsigned(type))))
        return st;
    if (vvi_label_parse(out, typed, vvi_label_is_unsigned(type)))
        return cli_label_layer_check(command, input, *out);
    if (vvi_label_parse(out, typed, true))
        return vv_fail(VV_E_ARGUMENT, "--%s: no sample is %s: they are %s, which end at 2^63", option, typed,
                       vv_type_name(type));
    return vv_fail(VV_E_ARGUMENT, "--%s: expected a whole number%s, found '%s'", option,
                   strpbrk(typed, "eE.") && strchr("+-.0123456789", *typed) ? ", with all of its digits" : "", typed);
}

/* --label is of both of two surfaces, in each as its file calls labels. */
static vv_status take_labels(vv_object **asked, cli_command *command, cli_measured *in)
{
    vvi_measured_volume *both[] = {&in->of.input.volume, &in->of.other.volume};
    const char *label = cli_measure_typed(command, "label"), *other = cli_measure_typed(command, "other_label");
    vv_label_id found[2] = {0};
    bool some = false;
    vv_status st = VV_OK;
    for (int i = 0; i < 2 && st == VV_OK; i++) {
        const bool is_other = i == 1 && other;
        const char *typed = is_other ? other : label;
        if (!both[i]->field || !typed)
            continue;
        if ((st = find_label(&found[i], command, &in->file[i], vv_field_get_info(both[i]->field)->type,
                             is_other ? "other-label" : "label", typed)) != VV_OK)
            return st;
        both[i]->data.called = typed;
        if (is_other || (some && found[1] != found[0] && !vv_object_is_set(*asked, "other_iso")))
            st = vv_path_set_integer(asked, "other_label", found[i], NULL);
        else if (!some)
            st = vv_path_set_integer(asked, "label", found[i], NULL);
        some = some || !is_other;
    }
    return st;
}

/* With --values the channel is one of theirs: what they are called is not known here. */
static vv_status take_channel(vv_object **asked, const cli_command *command, const cli_measured *in)
{
    const cli_input *input = &in->file[in->of.input.volume.field ? 0 : 1];
    const char *typed = cli_measure_typed(command, "component");
    const bool of_values = cli_measure_typed(command, "values") != NULL;
    vvi_text number = {0};
    if (!typed)
        return VV_OK;
    const size_t digits = strspn(typed, "0123456789");
    if (strchr(typed, ',') || (of_values && (typed[digits] || digits > 8)))
        return vv_fail(VV_E_ARGUMENT, "--channel: expected one channel%s, found '%.60s'",
                       of_values ? " of --values, by its number" : "", typed);
    vv_status st = of_values ? VV_OK : cli_channel_numbers(&number, input, typed);
    if (st == VV_OK)
        st = vv_path_set_integer(asked, "component", strtol(number.s ? number.s : typed, NULL, 10), NULL);
    vvi_text_free(&number);
    return st;
}

vv_status cli_measure_names(vv_measurement **asked, cli_command *command, cli_measured *in)
{
    vv_object *object = &(*asked)->base;
    vv_status st = take_channel(&object, command, in);
    if (st == VV_OK)
        st = take_labels(&object, command, in);
    if (st == VV_OK && in->planes)
        st = vv_path_set(&object, "cut_planes", in->planes, NULL);
    *asked = (vv_measurement *)(void *)object;
    return st;
}
