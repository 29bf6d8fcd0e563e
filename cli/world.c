/* The World that verbs work on: the input's, edited by what the command line says. */
#include "edits.h"
#include "input.h"
#include <stdio.h>

static vv_status edited(vv_world **out, cli_recipe *recipe, cli_command *command, vv_world *world)
{
    cli_edits edits = {.command = command, .look = cli_command_options(command, &cli_look_class)};
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

vv_status cli_edited_world(vv_world **out, cli_recipe *recipe_out, cli_command *command)
{
    vv_world *world = NULL;
    vv_status st;
    *out = NULL;
    if ((st = cli_input_world(&world, recipe_out, command, command->args.words[0])) != VV_OK)
        return st;
    st = edited(out, recipe_out, command, world);
    vv_object_release(&world->base);
    if (st != VV_OK || vv_collection_find((*out)->views, recipe_out->view))
        return st;
    vv_object_release(&(*out)->base);
    *out = NULL;
    return vv_fail(VV_E_NOT_FOUND, "the World has no view '%s' any more: what was set took it away", recipe_out->view);
}
