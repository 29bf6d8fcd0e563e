/* The World that verbs work on: the input's, edited by what the command line says. */
#include "chain.h"
#include "edits.h"
#include "input.h"
#include "model/merge.h"
#include "refusal.h"
#include <stdio.h>
#include <stdlib.h>

static vv_status edited(vv_world **out, vvi_recipe *recipe, cli_command *command, vv_world *world, const size_t *ends)
{
    cli_edits edits = {.command = command,
                       .look = cli_command_options(command, &cli_look_class),
                       .ends = command->args.n_words > 1 ? ends : NULL,
                       .n_inputs = command->args.n_words};
    vv_status st;
    snprintf(edits.view, sizeof edits.view, "%s", recipe->view);
    if ((st = vv_model_new(&edits.model, command->runtime)) == VV_OK &&
        (st = vv_model_replace(edits.model, NULL, world)) == VV_OK && (st = cli_edits_apply(&edits)) == VV_OK) {
        *out = vv_model_snapshot(edits.model);
        snprintf(recipe->view, sizeof recipe->view, "%s", edits.view);
    }
    vv_model_release(edits.model);
    return st;
}

/* Further inputs stand beside the first: their data alone, since there is one view and one light. */
static vv_status add_input(vv_world **world, cli_command *command, const char *word)
{
    vv_world *more;
    vvi_recipe recipe;
    vv_status st = cli_input_world(&more, &recipe, command, word);
    if (st == VV_OK && cli_input_contents(command, word) != CLI_INPUT_DATA)
        st = vv_fail_at(VV_E_ARGUMENT, word, NULL, "is a scene, which only the first input can be; name its data");
    if (st == VV_OK)
        st = vvi_world_merge(world, more, command->registry);
    vv_object_release(more ? &more->base : NULL);
    return st;
}

/* ends_out: volumes up to each input. */
static vv_status read_inputs(vv_world **out, vvi_recipe *recipe_out, cli_command *command, size_t *ends_out)
{
    const cli_look *look = cli_command_options(command, &cli_look_class);
    vv_status st = cli_input_world(out, recipe_out, command, command->args.words[0]);
    if (st == VV_OK && look->apply)
        st = cli_chain_apply(out, command, look->apply, command->args.words[0]);
    for (size_t i = 0; i < command->args.n_words && st == VV_OK; i++) {
        if (i > 0)
            st = add_input(out, command, command->args.words[i]);
        ends_out[i] = st == VV_OK ? (*out)->volumes->n : 0;
    }
    return st;
}

vv_status cli_edited_world(vv_world **out, vvi_recipe *recipe_out, cli_command *command)
{
    vv_world *world = NULL;
    size_t *ends = calloc(command->args.n_words + 1, sizeof *ends);
    vv_status st = ends ? VV_OK : vv_fail_memory(command->args.n_words * sizeof *ends);
    *out = NULL;
    if (st == VV_OK && command->defaults.taken.n &&
        cli_input_contents(command, command->args.words[0]) != CLI_INPUT_DATA)
        st = cli_command_drop_looks(command, &cli_look_class);
    if (st == VV_OK && (st = read_inputs(&world, recipe_out, command, ends)) == VV_OK)
        do
            st = edited(out, recipe_out, command, world, ends);
        while (st != VV_OK && cli_refusal_gives_way(command));
    free(ends);
    vv_object_release(world ? &world->base : NULL);
    if (st != VV_OK || vv_collection_find((*out)->views, recipe_out->view))
        return st;
    vv_object_release(&(*out)->base);
    *out = NULL;
    return vv_fail(VV_E_NOT_FOUND, "the World no longer has a view '%s': a --set removed it", recipe_out->view);
}
