/* Channels of a data file where one value is the surface of all. */
#include "edits.h"
#include "input.h"
#include <string.h>

static bool is_data(const cli_command *command)
{
    cli_input_name name;
    if (cli_input_split(&name, cli_command_word(command, 0)) != VV_OK)
        return false;
    const bool data = cli_input_contents(command, name.path) == CLI_INPUT_DATA;
    cli_input_name_free(&name);
    return data;
}

/* Whether a volume shows the data that the first shows; others are of other files. */
static bool is_channel(const vv_world *world, size_t i)
{
    const char *first = vvi_volume_nth(world, 0)->data, *data = vvi_volume_nth(world, i)->data;
    return first && data && strcmp(first, data) == 0;
}

static bool has_channels(const vv_world *world)
{
    size_t n = 0;
    for (size_t i = 0; i < world->volumes->n; i++)
        n += is_channel(world, i);
    return n > 1;
}

vv_status cli_edit_channels(cli_edits *edits)
{
    const cli_look *o = edits->look;
    const bool alone = o->iso || (o->mode && strcmp(o->mode, "isosurface") == 0);
    vv_world *world = vv_model_snapshot(edits->model);
    const vv_collection *volumes = world->volumes;
    vv_status st = VV_OK;
    if (alone && has_channels(world) && is_data(edits->command)) {
        const vv_volume *first = vvi_volume_nth(world, 0);
        for (size_t i = 1; i < volumes->n && st == VV_OK; i++)
            if (is_channel(world, i))
                st = cli_edit_set(edits, "mode", "false", "volumes.%s.visible", volumes->entry[i].id);
        cli_command_note(edits->command,
                         "one value is no surface of all channels: this is of '%s'%s%s; make others visible with "
                         "--set volumes.ID.visible=true, each with its own volumes.ID.rays.iso",
                         volumes->entry[0].id, first->title ? ", " : "", first->title ? first->title : "");
    }
    vv_object_release(&world->base);
    return st;
}
