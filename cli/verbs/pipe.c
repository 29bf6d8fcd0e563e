/* Operations one after the other: their result as a file, or a scene that remembers how it is made. */
#include "chain.h"
#include "command.h"
#include "findings.h"
#include "mesh.h"
#include "model/context.h"
#include "model/dataset.h"
#include "output.h"
#include "pipeline.h"
#include "run/made.h"
#include "value.h"
#include "verbs.h"
#include "watch.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { INPUTS_MOST = 16 };

typedef struct piping {
    cli_command *command;
    const char *output, *chain;
    const char *input[INPUTS_MOST]; /* n of them */
    size_t n;
    vv_world *world;
    char last[64];    /* dataset of the World */
    int64_t frame;    /* of the first input; -1: none was chosen */
    bool from_stream; /* which has been read */
} piping;

/* What no file is called, and begins with an operation or looks as if it were meant to. */
static bool is_chain(const cli_command *command, const char *word)
{
    char name[64];
    word += strspn(word, " ");
    snprintf(name, sizeof name, "%.*s", (int)strcspn(word, " |"), word);
    for (const vv_operation *const *row = command->registry->operations; *row; row++)
        if (strcmp((*row)->name, name) == 0)
            return access(word, F_OK) != 0;
    return (strchr(word, '|') || strstr(word, " -")) && access(word, F_OK) != 0;
}

/* A word that is no file may be an operation that is misspelt. */
static vv_status fail_chain(const piping *p)
{
    for (size_t i = 0; i < p->n; i++)
        if (p->n > 1 && !strpbrk(p->input[i], "./@:") && access(p->input[i], F_OK) != 0)
            return vv_registry_operation(p->command->registry, p->input[i]) ? VV_E_ARGUMENT : vv_error_last()->status;
    return vv_fail(VV_E_ARGUMENT, "no word is a chain of operations; quote it, as in 'gaussian --sigma 1mm | "
                                  "threshold --range 80..', and 'volvis operations' lists what there is");
}

static vv_status take_words(piping *p)
{
    for (size_t i = 0; i < p->command->args.n_words; i++) {
        const char *word = p->command->args.words[i];
        if (!p->chain && is_chain(p->command, word))
            p->chain = word;
        else if (p->n < INPUTS_MOST)
            p->input[p->n++] = word;
    }
    if (!p->chain)
        return fail_chain(p);
    return p->n > 0 ? VV_OK : vv_fail(VV_E_ARGUMENT, "an input is missing: the file that the first operation works on");
}

static const vv_dataset *result(const piping *p)
{
    return vvi_dataset_named(p->world, p->last);
}

/* The World of the input, with what is made of it. */
static vv_status make_world(piping *p)
{
    vvi_recipe recipe;
    vv_status st = cli_input_world(&p->world, &recipe, p->command, p->input[0]);
    const char *source = st == VV_OK ? cli_chain_source(p->world, p->input[0]) : NULL;
    if (!source)
        return st == VV_OK ? VV_E_ARGUMENT : st;
    const vv_dataset *from = vvi_dataset_named(p->world, source);
    p->from_stream = from->fields != NULL;
    p->frame = -1;
    for (size_t i = 0; i < p->world->volumes->n; i++) {
        const vv_volume *volume = vvi_volume_nth(p->world, i);
        if (vv_object_is_set(&volume->base, "frame"))
            p->frame = volume->frame;
    }
    return cli_chain_add(&p->world, p->last, p->command, p->chain, source, p->input + 1, p->n - 1);
}

/* A scene ------------------------------------------------------------------------------------------------------- */

static vv_status write_scene(piping *p)
{
    cli_command *command = p->command;
    vv_world *shown = NULL;
    if (p->from_stream)
        return vv_fail_at(VV_E_ARGUMENT, "standard input", NULL,
                          "cannot be named by a scene; write it to a file first, or write the result with -o FILE");
    vv_status st = vvi_world_for_dataset(&shown, p->world, p->last, command->job);
    if (st == VV_OK && (st = cli_world_set_frame(&shown, p->frame)) == VV_OK && !command->common->dry_run)
        st = vv_scene_write(p->output, shown, command->job);
    if (st == VV_OK) {
        vvi_result_string(&command->json, "output", p->output);
        vvi_result_string(&command->json, "dataset", p->last);
        vvi_result_bool(&command->json, "dry_run", command->common->dry_run);
        vvi_text_add_clean(&command->text, p->output);
        vvi_text_printf(&command->text, ": a scene that shows '%s', made of %s when it is needed\n", p->last,
                        p->input[0]);
    }
    vv_object_release(shown ? &shown->base : NULL);
    return st;
}

/* A mesh -------------------------------------------------------------------------------------------------------- */

static vv_status write_mesh(piping *p)
{
    cli_command *command = p->command;
    vv_mesh_write_options options;
    vv_mesh *mesh = NULL;
    vvi_result_string(&command->json, "output", p->output);
    vvi_result_bool(&command->json, "dry_run", command->common->dry_run);
    if (command->common->dry_run) {
        cli_command_line(command, "makes", "%s: a mesh", p->output);
        return VV_OK;
    }
    vv_status st = vv_dataset_mesh(&mesh, p->world, result(p), command->job);
    cli_output_mesh_options(&options, command);
    if (st == VV_OK && (st = vv_mesh_write(p->output, mesh, &options, command->job)) == VV_OK) {
        const vv_mesh_info *info = vv_mesh_get_info(mesh);
        vvi_text_add_clean(&command->text, p->output);
        vvi_text_printf(&command->text, ": %zu vertices, %zu triangles\n", info->n_vertices, info->n_triangles);
        vvi_result_unsigned(&command->json, "vertices", info->n_vertices);
        vvi_result_unsigned(&command->json, "triangles", info->n_triangles);
    }
    vv_mesh_release(mesh);
    return st;
}

/* Samples ------------------------------------------------------------------------------------------------------- */

/* What was said of how the first file is read. */
static vv_status take_reading(piping *p, vv_run_input *first)
{
    cli_input input = {.file = first->file, .frame = p->frame, .path = (char *)(uintptr_t)first->name};
    first->frame = p->frame;
    return first->file ? cli_input_take(&input, p->command, NULL) : VV_OK;
}

static vv_status write_samples(piping *p)
{
    vvi_made_run all;
    vv_status st = vvi_made_run_open(&all, p->world, result(p), -1, p->command->job);
    const vvi_run_plan plan = vvi_made_run_plan(&all, p->command->verb.name);
    if (st == VV_OK && (st = take_reading(p, &all.input[0])) == VV_OK)
        st = cli_pipeline_run_plan(p->command, &plan);
    vvi_made_run_close(&all);
    return st;
}

/* The whole ----------------------------------------------------------------------------------------------------- */

static vv_status check_output(piping *p, bool *scene_out)
{
    cli_command *command = p->command;
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    const vv_status st = cli_output_need(&p->output, command, "the scene or the result");
    if (st != VV_OK)
        return st;
    *scene_out = cli_ends_with(p->output, ".vv.json");
    if (*scene_out)
        return cli_output_check(command, p->output, CLI_OUTPUT_TEXT, NULL);
    const bool mesh = cli_mesh_is_output(command, p->output, writing->output_format);
    return cli_output_check(command, p->output, mesh ? CLI_OUTPUT_MESH : CLI_OUTPUT_VOLUME, writing->output_format);
}

/* A result goes into a file of its own kind. */
static vv_status check_kind(const piping *p, bool mesh)
{
    const cli_writing *writing = cli_command_options(p->command, &cli_writing_class);
    return cli_output_check(p->command, p->output, mesh ? CLI_OUTPUT_MESH : CLI_OUTPUT_VOLUME, writing->output_format);
}

static vv_status run(cli_command *command)
{
    piping p = {.command = command};
    bool scene = false;
    vv_status st;
    if ((st = take_words(&p)) != VV_OK || (st = check_output(&p, &scene)) != VV_OK ||
        (st = cli_command_start(command)) != VV_OK)
        return st;
    if ((st = make_world(&p)) == VV_OK) {
        const bool mesh = vv_dataset_is_mesh(result(&p), command->job);
        if (scene)
            st = write_scene(&p);
        else if ((st = check_kind(&p, mesh)) == VV_OK)
            st = mesh ? write_mesh(&p) : write_samples(&p);
    }
    vv_object_release(p.world ? &p.world->base : NULL);
    return st;
}

static const char *const examples[] = {
    "volvis pipe head.nii.gz 'gaussian --sigma 1mm | threshold --range 80..' -o mask.nii.gz",
    "volvis pipe head.nii.gz 'median | isosurface --iso 90 | simplify --share 0.2' -o skin.ply",
    "volvis pipe head.nii.gz 'gaussian --sigma 1mm' -o smooth.vv.json",
    NULL,
};

const cli_verb cli_verb_pipe = {
    .name = "pipe",
    .doc = "operations one after the other; a scene as the output remembers how the result is made",
    .about =
        "CHAIN is one word: operations with their options and a bar between two, as in 'gaussian --sigma 1mm | "
        "threshold --range 80..'. The first works on INPUT, each of the others on the result of the one before it; "
        "further inputs stand behind the operation that takes them: 'calc \"a - b\" b=mean.nii.gz'. The result is "
        "what the operations give one by one. If OUTPUT is a scene (*.vv.json) nothing is worked out: the scene "
        "says how, and the data are made when a picture or a measurement needs them. --set changes a step: "
        "'volvis render scene.vv.json --set datasets.gaussian.parameters.sigma=2mm'.",
    .words = "INPUT CHAIN",
    .choices = "files",
    .min_words = 2,
    .max_words = INPUTS_MOST,
    .options = {NULL, &cli_reading_rest_class, &cli_writing_class, &cli_watching_class},
    .examples = examples,
    .makes_file = true,
    .run = run,
};
