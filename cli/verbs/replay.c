#include "output.h"
#include "server/recording.h"
#include "serving.h"
#include "verbs.h"

#include <stdlib.h>
#include <string.h>

static vv_status put_world(cli_command *command, const vv_world *world)
{
    char *scene = NULL;
    const vv_status st = vv_scene_print(&scene, world, NULL);
    if (st == VV_OK) {
        cli_command_title(command, scene);
        command->verbatim = true;
    }
    free(scene);
    return st;
}

static vv_status run(cli_command *command)
{
    vv_world *world = NULL;
    vv_status st = cli_command_start(command);
    if (st != VV_OK)
        return st;
    const vvi_session_options options = {.runtime = command->runtime, .root = "/", .clients_most = 1000};
    char *state = NULL;
    if ((st = cli_state_root(&state)) != VV_OK)
        return st;
    const bool keeps = command->common->output && !command->common->dry_run;
    st = vvi_recording_play(&world, cli_command_word(command, 0), &options, state, keeps, command->job);
    free(state);
    if (st != VV_OK)
        return st;
    if (!command->common->output)
        st = put_world(command, world);
    else if (!command->common->dry_run)
        st = vv_scene_write(command->common->output, world, command->job);
    vv_object_release(&world->base);
    return st;
}

static const char *const examples[] = {"volvis replay session.jsonl -o scene.vv.json", NULL};

const cli_verb cli_verb_replay = {
    .name = "replay",
    .doc = "replay a recorded session of view: the scene that it leads to",
    .about = "RECORDING is a file written by 'volvis view --record' or 'volvis serve --record': what the pages sent, "
             "and when. The resulting World is the one at the end of the session; without -o it is printed. Samples "
             "that it shows are made again, in the folder of sessions; with -o those that the scene shows stay.",
    .words = "RECORDING",
    .choices = "files",
    .min_words = 1,
    .max_words = 1,
    .examples = examples,
    .makes_file = true,
    .run = run,
};
