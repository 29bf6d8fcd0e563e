/* The files that are measured, with what their scenes say of them. */
#include "grid/field.h"
#include "measure.h"
#include "mesh.h"
#include "model/classes.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

vv_status cli_measure_world(vv_model *model, vvi_recipe *recipe, cli_command *command, const char *word, bool edited)
{
    cli_edits edits = {.command = command, .model = model};
    vv_world *world = NULL;
    vv_status st = cli_input_world(&world, recipe, command, word);
    if (st == VV_OK && (st = vv_model_replace(model, NULL, world)) == VV_OK && edited)
        st = cli_edit_paths(&edits);
    vv_object_release(world ? &world->base : NULL);
    return st;
}

/* A stored measurement may name its volume: for this time the others of the scene are not seen. */
static vv_status show_only(vv_model *model, const cli_question *q)
{
    const char *only = q && q->asked && !q->asked->file ? q->asked->volume : NULL;
    vv_world *world = vv_model_snapshot(model);
    const vv_collection *all = world->volumes;
    vv_status st = only && !vv_collection_find(all, only)
                       ? vv_fail(VV_E_NOT_FOUND, "volume: the scene has no volume '%.64s'", only)
                       : VV_OK;
    for (size_t i = 0; only && i < all->n && st == VV_OK; i++) {
        char path[128];
        snprintf(path, sizeof path, "volumes.%.96s.visible", all->entry[i].id);
        st = vv_model_set(model, NULL, path, strcmp(all->entry[i].id, only) == 0 ? "true" : "false");
    }
    vv_object_release(&world->base);
    return st;
}

static bool is_edited(const cli_command *command, const char *edited, const char *word)
{
    const vv_collection *set = command->common->set;
    return set && set->n && edited && strcmp(word, edited) == 0;
}

vv_world *cli_measure_mesh_world(cli_command *command, const cli_question *q)
{
    const char *edited = q->edited, *file = q->file[0];
    vv_model *model = NULL;
    vv_world *world = NULL;
    vvi_recipe recipe = {0};
    if (strcmp(file, "-") == 0 || cli_mesh_is_input(command, file) ||
        cli_input_contents(command, file) == CLI_INPUT_DATA)
        return NULL;
    if (vv_model_new(&model, command->runtime) == VV_OK &&
        cli_measure_world(model, &recipe, command, file, is_edited(command, edited, file)) == VV_OK &&
        show_only(model, q) == VV_OK)
        world = vv_model_snapshot(model);
    vv_model_release(model);
    if (world && vvi_world_shows_meshes(world, command->job))
        return world;
    vv_object_release(world ? &world->base : NULL);
    return NULL;
}

/* Volumes --------------------------------------------------------------------------------------------------------- */

/* Data alone: nothing but the unit. */
static vv_status open_data(cli_input *input, vv_model *model, cli_command *command, const char *word)
{
    vvi_text unit = {0};
    vv_status st = cli_input_open(input, command, word);
    if (st != VV_OK)
        return st;
    vvi_text_json(&unit, vv_file_info(input->file)->grid.unit);
    st = unit.bad ? vv_fail_memory(unit.n) : vv_model_set(model, NULL, "unit", unit.s);
    vvi_text_free(&unit);
    return st;
}

/* The samples are of the data that the World has then. */
static vv_status open_scene(cli_input *input, vv_model *model, vvi_recipe *recipe, cli_command *command,
                            const char *word, const cli_question *q)
{
    vv_status st = cli_measure_world(model, recipe, command, word, is_edited(command, q->edited, word));
    if (st != VV_OK || (st = show_only(model, q)) != VV_OK)
        return st;
    vv_world *world = vv_model_snapshot(model);
    st = cli_input_open_in(input, command, world, word);
    vv_object_release(&world->base);
    return st;
}

/* Figures of other samples than those that the scene was made of are told as such: a picture of them is refused. The
 * checksum is that of the first time step. */
static vv_status note_changed(cli_command *command, const cli_input *input, const vv_field *field,
                              const vv_world *world, const char *word)
{
    const vv_volume *volume = vvi_first_visible(world);
    const vv_dataset *dataset = volume ? vvi_volume_dataset(world, volume) : NULL;
    uint32_t expected = 0, found = 0;
    if (!dataset || !dataset->checksum || input->frame > 0 || !vvi_checksum_parse(&expected, dataset->checksum))
        return VV_OK;
    const vv_status st = vv_field_checksum(&found, field, command->job);
    if (st == VV_OK && found != expected)
        cli_command_note(command,
                         "%s: was made from samples of %s, and those of '%s' are others now, crc32:%08" PRIx32
                         ": these are measured",
                         word, dataset->checksum, dataset->path, found);
    return st;
}

/* --clip as planes of a World in whose unit lengths are, and which has no others any longer. */
static vv_status take_clip(char **out, cli_command *command, vv_model *model)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    const cli_look look = {.clip = o->cut_planes};
    cli_edits edits = {.command = command, .model = model, .look = &look};
    vv_status st = vv_model_set(model, NULL, "cut_planes", "[]");
    if (st == VV_OK && (st = cli_edit_clip(&edits)) == VV_OK) {
        vv_world *world = vv_model_snapshot(model);
        st = vv_path_get(out, &world->base, "cut_planes");
        vv_object_release(&world->base);
    }
    return st;
}

static vv_status take_volume(vvi_measured *out, const cli_input *input, cli_command *command, vv_model *model,
                             const char *view, const char *word)
{
    const int64_t n_frames = vv_file_info(input->file)->n_frames;
    vv_world *world = vv_model_snapshot(model);
    vv_status st = vvi_measured_file(out, input->file, input->frame < 0 ? 0 : input->frame, input->path, world,
                                     vvi_first_visible(world), view, command->job);
    out->volume.data.given = word;
    if (st == VV_OK)
        st = note_changed(command, input, out->volume.field, world, word);
    vv_object_release(&world->base);
    if (n_frames > 1 && input->frame < 0)
        cli_command_note(command, "%s: the first of %lld time steps is measured; choose another with FILE@N",
                         input->path, (long long)n_frames);
    return st;
}

/* planes: takes --clip; NULL: there is none. */
static vv_status open_volume(vvi_measured *out, cli_input *input, cli_command *command, const cli_question *q,
                             const char *word, char **planes)
{
    const bool edit = is_edited(command, q->edited, word);
    vv_model *model = NULL;
    vvi_recipe recipe = {0};
    vv_status st = vv_model_new(&model, command->runtime);
    if (st == VV_OK)
        st = edit || cli_input_contents(command, word) != CLI_INPUT_DATA
                 ? open_scene(input, model, &recipe, command, word, q)
                 : open_data(input, model, command, word);
    if (st == VV_OK)
        st = take_volume(out, input, command, model, recipe.view, word);
    if (st == VV_OK && planes)
        st = take_clip(planes, command, model);
    vv_model_release(model);
    return st;
}

/* All ------------------------------------------------------------------------------------------------------------- */

static vv_status open_one(cli_measured *all, size_t i, cli_command *command, const cli_question *q)
{
    vvi_measured *out = i ? &all->of.other : &all->of.input;
    const char *word = q->file[i];
    vv_mesh *mesh = NULL;
    *(i ? &all->of.inputs.other : &all->of.inputs.input) = &out->volume.data;
    if (!cli_mesh_is_input(command, word))
        return open_volume(out, &all->file[i], command, q, word, q->typed && !all->planes ? &all->planes : NULL);
    const vv_status st = cli_mesh_read(&mesh, command, word, q->asked->input_unit);
    vvi_measured_mesh(out, mesh, word);
    return st;
}

vv_status cli_measured_open(cli_measured *out, cli_command *command, const cli_question *q)
{
    vv_measured_inputs *inputs = &out->of.inputs;
    *inputs = (vv_measured_inputs){.size = sizeof *inputs, .n_inputs = 1};
    if ((out->world = cli_measure_mesh_world(command, q))) {
        vvi_measured_meshes *shown = &out->of.shown;
        const vv_status st = vvi_measured_meshes_take(shown, out->world, NULL, q->file[0], command->job);
        inputs->input = shown->data;
        inputs->n_inputs = shown->n;
        return st;
    }
    const vv_status st = open_one(out, 0, command, q);
    return st == VV_OK && q->file[1] ? open_one(out, 1, command, q) : st;
}

/* Nothing is said of it but its samples. */
static vv_status open_beside(vvi_measured *out, const vv_measured_data **data, cli_input *input, cli_command *command,
                             const char *word)
{
    const vv_status st = word ? cli_input_open(input, command, word) : VV_OK;
    if (!word || st != VV_OK)
        return st;
    *data = &out->volume.data;
    return vvi_measured_file(out, input->file, input->frame < 0 ? 0 : input->frame, word, NULL, NULL, "", command->job);
}

vv_status cli_measured_open_beside(cli_measured *out, cli_command *command, const vv_measurement *asked)
{
    vvi_measured_all *of = &out->of;
    const vv_status st = open_beside(&of->mask, &of->inputs.mask, &out->mask, command, asked->mask);
    return st == VV_OK ? open_beside(&of->values, &of->inputs.values, &out->values, command, asked->values) : st;
}

void cli_measured_close(cli_measured *in)
{
    vvi_measured_close(&in->of);
    cli_input_close(&in->file[0]);
    cli_input_close(&in->file[1]);
    cli_input_close(&in->mask);
    cli_input_close(&in->values);
    vv_object_release(in->world ? &in->world->base : NULL);
    free(in->planes);
}
