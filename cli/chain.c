#include "chain.h"
#include "channel_names.h"
#include "core/memory.h"
#include "core/units.h"
#include "mesh.h"
#include "model/context.h"
#include "model/dataset.h"
#include "model/merge.h"
#include "operands.h"
#include "scene/load.h"
#include "verbs.h"
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { ID_ROOM = 64, WORDS_MOST = 128, INPUTS_MOST = 64 };

/* One step under way. */
typedef struct step {
    cli_command *command;
    vv_world **world;
    const char *from; /* what is piped in */
    cli_verb verb;    /* its operation, with nothing but that one's options */
    cli_args args;
    char *argv[WORDS_MOST];
    int argc;
    char inputs[INPUTS_MOST][ID_ROOM]; /* datasets, in the order of operands */
} step;

/* Words ------------------------------------------------------------------------------------------------------------ */

/* The next word, made in place: quotes of both kinds keep what stands in them together. *text is behind it. NULL: there
 * is none. */
static char *take_word(char **text, bool *open_out)
{
    char *in = *text + strspn(*text, " \t\n"), *out = in, *word = in, quote = 0;
    if (!*in)
        return NULL;
    for (; *in && (quote || !strchr(" \t\n", *in)); in++) {
        if (quote ? *in == quote : *in == '"' || *in == '\'')
            quote = quote ? 0 : *in;
        else
            *out++ = *in;
    }
    *open_out = quote != 0;
    *text = *in ? in + 1 : in;
    *out = 0;
    return word;
}

/* Bytes of the first step of a chain: up to a bar outside of quotes. */
static size_t step_length(const char *chain)
{
    char quote = 0;
    size_t n = 0;
    for (; chain[n] && (quote || chain[n] != '|'); n++) {
        if (quote ? chain[n] == quote : chain[n] == '"' || chain[n] == '\'')
            quote = quote ? 0 : chain[n];
    }
    return n;
}

static vv_status split(step *s, char *text)
{
    bool open = false;
    for (char *word; !open && (word = take_word(&text, &open));) {
        if (s->argc == WORDS_MOST)
            return vv_fail(VV_E_LIMIT, "the step has more than %d words", WORDS_MOST);
        s->argv[s->argc++] = word;
    }
    if (open)
        return vv_fail(VV_E_ARGUMENT, "a quotation mark in '%s' is not closed", s->argv[s->argc - 1]);
    if (!s->argc)
        return vv_fail(VV_E_ARGUMENT, "an operation is missing: write them with a bar between two, as in "
                                      "'gaussian --sigma 1mm | threshold --range 80..'");
    return VV_OK;
}

static vv_status find_operation(step *s)
{
    const vv_operation *operation = vv_registry_operation(s->command->registry, s->argv[0]);
    if (!operation)
        return vv_error_last()->status;
    s->verb = (cli_verb){.name = operation->name,
                         .words = cli_operands_usage(operation),
                         .options = {operation->params},
                         .run = cli_verb_of_operation(operation).run};
    return VV_OK;
}

/* What is piped in stands before all other inputs, and behind a formula. */
static vv_status place_source(step *s, const vv_operation *operation)
{
    const vv_property *row = operation->params->properties;
    while (row->name && !row->positional)
        row++;
    bool formula = row->name != NULL;
    for (size_t i = 0; i < s->args.n_given; i++)
        formula = formula && s->args.given[i].row != row;
    if (formula && s->args.n_words == 0)
        return vv_fail(VV_E_ARGUMENT, "its %s is missing; write it in quotation marks behind '%s'", row->name,
                       operation->name);
    const size_t at = formula && s->args.n_words > 0 ? 1 : 0;
    const char **words = calloc(s->args.n_words + 2, sizeof *words);
    if (!words)
        return vv_fail_memory((s->args.n_words + 2) * sizeof *words);
    memcpy(words, s->args.words, at * sizeof *words);
    words[at] = s->from;
    memcpy(words + at + 1, s->args.words + at, (s->args.n_words - at) * sizeof *words);
    free(s->args.words);
    s->args.words = words;
    s->args.n_words++;
    return VV_OK;
}

/* Only what is the operation's own may be said in a step. */
static vv_status check_options(const step *s)
{
    char name[64];
    for (size_t i = 0; i < s->args.n_given; i++) {
        if (s->args.given[i].cls == s->verb.options[0])
            continue;
        cli_option_name(name, s->args.given[i].row);
        return vv_fail(VV_E_ARGUMENT, "--%s is not about the operation; write it outside of the chain", name);
    }
    return VV_OK;
}

static vv_status parse(step *s)
{
    const vv_operation *operation = vv_registry_operation(s->command->registry, s->argv[0]);
    vv_status st;
    if ((st = cli_args_parse(&s->args, &s->verb, s->argc - 1, s->argv + 1)) != VV_OK ||
        (st = check_options(s)) != VV_OK || (st = place_source(s, operation)) != VV_OK)
        return st;
    s->verb.operation = operation;
    if ((st = cli_operands_take(&s->args, &s->verb)) != VV_OK)
        return st;
    if (s->args.n_words <= vv_operation_most(operation) && s->args.n_words <= INPUTS_MOST)
        return VV_OK;
    const size_t most = vv_operation_most(operation) < INPUTS_MOST ? vv_operation_most(operation) : INPUTS_MOST;
    return vv_fail(VV_E_ARGUMENT, "takes %zu input%s at most, there are %zu; operations have a bar between them", most,
                   most == 1 ? "" : "s", s->args.n_words);
}

/* Inputs ----------------------------------------------------------------------------------------------------------- */

static bool same(const char *a, const char *b)
{
    return a == b || (a && b && strcmp(a, b) == 0);
}

/* A file that the World has already is not added again. */
static const char *dataset_of_file(const vv_world *world, const cli_input_name *name)
{
    for (size_t i = 0; i < world->datasets->n; i++) {
        const vv_dataset *dataset = vvi_dataset_nth(world, i);
        if (same(dataset->path, name->path) && same(dataset->part, name->part))
            return world->datasets->entry[i].id;
    }
    return NULL;
}

static vv_status add_file(step *s, char id_out[ID_ROOM], const cli_input_name *name)
{
    char id[ID_ROOM], path[ID_ROOM + 32];
    vv_object *root = &(*s->world)->base;
    const char *there = dataset_of_file(*s->world, name);
    if (name->frame >= 0)
        return vv_fail_at(VV_E_ARGUMENT, name->path, NULL,
                          "@%lld: in a chain a time step of a further input cannot be chosen; 'volvis convert' makes a "
                          "file of it",
                          (long long)name->frame);
    if (there) {
        snprintf(id_out, ID_ROOM, "%s", there);
        return VV_OK;
    }
    if (access(name->path, F_OK) != 0)
        return vv_fail_at(VV_E_READ, name->path, NULL, "there is no such file, nor a dataset of that name");
    vvi_world_id(id, name->path);
    vvi_world_free_id(id_out, (*s->world)->datasets, id);
    snprintf(path, sizeof path, "datasets.%s.path", id_out);
    vv_status st = vv_path_add(&root, "datasets", id_out, NULL, NULL);
    if (st == VV_OK)
        st = vv_path_set_text(&root, path, name->path, NULL);
    snprintf(path, sizeof path, "datasets.%s.part", id_out);
    if (st == VV_OK && name->part)
        st = vv_path_set_text(&root, path, name->part, NULL);
    *s->world = (vv_world *)(void *)root;
    return st;
}

static vv_status take_inputs(step *s)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < s->args.n_words && st == VV_OK; i++) {
        cli_input_name name;
        const char *word = s->args.words[i];
        if (word == s->from || (vv_collection_find((*s->world)->datasets, word) && access(word, F_OK) != 0)) {
            snprintf(s->inputs[i], ID_ROOM, "%s", word);
            continue;
        }
        if ((st = cli_input_split(&name, word)) != VV_OK)
            break;
        st = add_file(s, s->inputs[i], &name);
        cli_input_name_free(&name);
    }
    return st;
}

/* Parameters ------------------------------------------------------------------------------------------------------- */

static const vv_dataset *dataset_of(const step *s, const char *id)
{
    return vvi_dataset_named(*s->world, id);
}

/* What it is as an input: of a mesh its unit alone. */
static vv_status info_of(vv_field_info *out, const step *s, const vv_dataset *dataset)
{
    vv_job *job = s->command->job;
    vv_mesh *mesh = NULL;
    *out = vv_field_info_default();
    if (!vv_dataset_is_mesh(dataset, job))
        return vv_dataset_info(out, *s->world, dataset, job);
    const vv_status st = vv_dataset_mesh(&mesh, *s->world, dataset, job);
    if (st == VV_OK)
        memcpy(out->grid.unit, vv_mesh_get_info(mesh)->unit, sizeof out->grid.unit);
    vv_mesh_release(mesh);
    return st;
}

/* An input as a file, with its names; of standard input, which was read, and of meshes there is none. */
static vv_status open_input(cli_input *out, step *s, size_t i)
{
    const vv_dataset *dataset = dataset_of(s, s->inputs[i]);
    out->path = s->inputs[i];
    return dataset->fields || vv_dataset_is_mesh(dataset, s->command->job)
               ? VV_OK
               : vvi_dataset_open(&out->file, *s->world, dataset, s->command->job);
}

/* Those that are left out have places, too: "mask=m.nrrd" may be the third. */
static const vv_operand *operand_of(const step *s, size_t i)
{
    const vv_operation *operation = s->verb.operation;
    return vv_operation_operand(operation, operation->inputs[0].names ? i : s->args.place[i]);
}

/* As `volvis NAME` reads its options: lengths of the first input, channels and labels by its names, or labels by those
 * of the further input that the operation says. */
static vv_status make_params(vv_object **out, step *s)
{
    cli_input input = {0}, other = {0};
    vv_field_info info;
    vv_status st = info_of(&info, s, dataset_of(s, s->inputs[0]));
    if (st == VV_OK)
        st = open_input(&input, s, 0);
    for (size_t i = 1; i < s->args.n_words && st == VV_OK && !other.path; i++)
        if (operand_of(s, i)->names_labels)
            st = open_input(&other, s, i);
    const cli_label_names labels = cli_label_names_of(s->command, other.path ? &other : &input);
    if (st == VV_OK)
        st = cli_operation_params(out, s->command, &s->args, s->verb.options[0], &info, input.file ? &input : NULL,
                                  &labels);
    vv_file_close(other.file);
    vv_file_close(input.file);
    return st;
}

/* "a,b", of the names that were given, else of the alphabet: the name of input i. */
static void name_input(char out[ID_ROOM], const char *names, size_t i)
{
    for (size_t k = 0; names && k < i; k++) {
        names = strchr(names, ',');
        names = names ? names + 1 : NULL;
    }
    const size_t n = names ? strcspn(names, ",") : 0;
    if (n > 0)
        snprintf(out, ID_ROOM, "%.*s", (int)n, names);
    else
        snprintf(out, ID_ROOM, "%c", (char)('a' + i));
}

static void input_name(char out[ID_ROOM], const step *s, const char *names, size_t i)
{
    const vv_operation *operation = s->verb.operation;
    if (operation->inputs[0].names)
        name_input(out, names, i);
    else
        snprintf(out, ID_ROOM, "%s", operand_of(s, i)->name);
}

/* What is piped in has no name, and gets one of the alphabet. */
static vv_status check_names(const step *s, const char *names)
{
    char name[ID_ROOM], other[ID_ROOM];
    for (size_t i = 1; s->verb.operation->inputs[0].names && i < s->args.n_words; i++) {
        input_name(name, s, names, i);
        for (size_t k = 0; k < i; k++) {
            input_name(other, s, names, k);
            if (strcmp(name, other) == 0)
                return vv_fail(VV_E_ARGUMENT, "two inputs are called '%s'%s", name,
                               k == 0 ? ": what is piped in is 'a', so give the others other names" : "");
        }
    }
    return VV_OK;
}

static void add_inputs(vvi_text *json, const step *s, const char *names)
{
    for (size_t i = 0; i < s->args.n_words; i++) {
        char name[ID_ROOM];
        input_name(name, s, names, i);
        vvi_text_add(json, i ? ", " : "");
        vvi_text_json(json, name);
        vvi_text_printf(json, ": \"%s\"", s->inputs[i]);
    }
}

/* {"operation": "gaussian", "inputs": {"volume": "head"}, "parameters": {"sigma": 1}} */
static vv_status print_recipe(vvi_text *json, const step *s, vv_object **params)
{
    const vv_operation *operation = s->verb.operation;
    const char *row = operation->inputs[0].names, *names = NULL;
    char *own_names = NULL, *text = NULL;
    vv_status st = VV_OK;
    if (row && vv_object_is_set(*params, row)) {
        const vv_property *property = vv_class_find((*params)->cls, row);
        names = *(char *const *)(const void *)((const char *)*params + property->offset);
        own_names = vvi_strdup(names);
        st = own_names ? vv_path_unset(params, row, NULL) : vv_fail_memory(strlen(names));
    }
    if (st == VV_OK && (st = check_names(s, own_names)) == VV_OK)
        st = vv_object_to_json(&text, *params, 0);
    vvi_text_printf(json, "{\"operation\": \"%s\", \"inputs\": {", operation->name);
    add_inputs(json, s, own_names);
    vvi_text_add(json, "}");
    if (st == VV_OK && strcmp(text, "{}") != 0)
        vvi_text_printf(json, ", \"parameters\": %s", text);
    vvi_text_add(json, "}");
    free(text);
    free(own_names);
    return st == VV_OK && json->bad ? vv_fail_memory(json->n) : st;
}

/* Datasets --------------------------------------------------------------------------------------------------------- */

/* Whether it is what counts of an option, and a length with its unit. */
static bool is_measured(const step *s, size_t at)
{
    const cli_given *given = &s->args.given[at];
    double bare;
    for (size_t i = at + 1; i < s->args.n_given; i++)
        if (s->args.given[i].row == given->row)
            return false;
    return given->cls == s->verb.options[0] && given->row->quantity == VV_Q_LENGTH && given->row->kind == VV_KIND_F64 &&
           !vvi_parse_number(&bare, given->text);
}

/* "2mm" stays what it is, whatever the unit of other inputs. */
static vv_status keep_units(const step *s, vv_object **root, const char *id)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < s->args.n_given && st == VV_OK; i++) {
        char path[ID_ROOM + 96];
        snprintf(path, sizeof path, "datasets.%s.parameters.%s", id, s->args.given[i].row->name);
        if (is_measured(s, i))
            st = vv_path_set_text(root, path, s->args.given[i].text, NULL);
    }
    return st;
}

static vv_status add_dataset(step *s, char id_out[ID_ROOM])
{
    vv_object *params = NULL, *root = &(*s->world)->base;
    char name[ID_ROOM];
    vvi_text json = {0};
    vv_status st = make_params(&params, s);
    if (st != VV_OK)
        return st;
    vvi_world_id(name, s->verb.name);
    vvi_world_free_id(id_out, (*s->world)->datasets, name);
    if ((st = print_recipe(&json, s, &params)) == VV_OK)
        st = vv_path_add(&root, "datasets", id_out, json.s, NULL);
    if (st == VV_OK)
        st = keep_units(s, &root, id_out);
    *s->world = (vv_world *)(void *)root;
    vv_object_release(params);
    vvi_text_free(&json);
    return st;
}

/* Whether it can be made at all is known before anything is: its size, and that its inputs fit. */
static vv_status check(const step *s, const char *id)
{
    vv_field_info info;
    const vv_dataset *dataset = dataset_of(s, id);
    vv_job *job = s->command->job;
    return vv_dataset_is_mesh(dataset, job) ? VV_OK : vv_dataset_info(&info, *s->world, dataset, job);
}

static vv_status add_step(step *s, char id_out[ID_ROOM], char *text, const char *const *more, size_t n_more)
{
    vv_status st = split(s, text);
    for (size_t i = 0; i < n_more && st == VV_OK; i++) {
        if (s->argc == WORDS_MOST)
            return vv_fail(VV_E_LIMIT, "the step has more than %d words", WORDS_MOST);
        s->argv[s->argc++] = (char *)(uintptr_t)more[i];
    }
    if (st == VV_OK && (st = find_operation(s)) == VV_OK && (st = parse(s)) == VV_OK &&
        (st = take_inputs(s)) == VV_OK && (st = add_dataset(s, id_out)) == VV_OK)
        st = check(s, id_out);
    return st;
}

vv_status cli_chain_add(vv_world **world, char id_out[ID_ROOM], cli_command *command, const char *chain,
                        const char *from, const char *const *more, size_t n_more)
{
    char piped[ID_ROOM];
    vv_status st = VV_OK;
    size_t number = 1;
    snprintf(piped, sizeof piped, "%s", from);
    for (;; number++) {
        step s = {.command = command, .world = world, .from = piped};
        const size_t n = step_length(chain);
        char *text = strndup(chain, n);
        if (!text)
            return vv_fail_memory(n);
        st = add_step(&s, id_out, text, number == 1 ? more : NULL, number == 1 ? n_more : 0);
        if (st != VV_OK)
            st = vv_fail_in(st, "step %zu of the chain%s%s", number, s.argc ? ", " : "", s.argc ? s.argv[0] : "");
        cli_args_free(&s.args);
        free(text);
        if (st != VV_OK || !chain[n])
            return st;
        chain += n + 1;
        snprintf(piped, sizeof piped, "%s", id_out);
    }
}

const char *cli_chain_source(const vv_world *world, const char *input)
{
    for (size_t i = 0; i < world->volumes->n; i++) {
        const vv_volume *volume = vvi_volume_nth(world, i);
        if (volume->visible && vvi_volume_dataset(world, volume))
            return vvi_volume_dataset_id(world, volume);
    }
    vv_fail_at(VV_E_ARGUMENT, input, NULL, "shows no data that an operation could work on");
    return NULL;
}

/* The first volume, and all others that show the same, show the last of the chain. */
static vv_status show_in_place(vv_world **world, const char *from, const char *id)
{
    vv_object *root = vv_object_retain(&(*world)->base);
    const vv_collection *volumes = (*world)->volumes;
    vv_status st = VV_OK;
    for (size_t i = 0; i < volumes->n && st == VV_OK; i++) {
        const vv_volume *volume = vvi_volume_nth(*world, i);
        char path[ID_ROOM + 32];
        snprintf(path, sizeof path, "volumes.%s.data", volumes->entry[i].id);
        if (!volume->data || strcmp(volume->data, from) == 0)
            st = vv_path_set_text(&root, path, id, NULL);
    }
    vv_object_release(&(*world)->base);
    *world = (vv_world *)(void *)root;
    return st;
}

vv_status cli_chain_apply(vv_world **world, cli_command *command, const char *chain, const char *input)
{
    char from[ID_ROOM], id[ID_ROOM];
    vv_world *shown = NULL;
    const char *source = cli_chain_source(*world, input);
    if (!source)
        return VV_E_ARGUMENT;
    snprintf(from, sizeof from, "%s", source);
    vv_status st = cli_chain_add(world, id, command, chain, from, NULL, 0);
    if (st != VV_OK)
        return st;
    if (cli_input_contents(command, input) != CLI_INPUT_DATA)
        return show_in_place(world, from, id);
    if ((st = vvi_world_for_dataset(&shown, *world, id, command->job)) != VV_OK)
        return st;
    vv_object_release(&(*world)->base);
    *world = shown;
    return VV_OK;
}
