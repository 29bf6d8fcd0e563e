/* Opening inputs: data files, and the data of scenes and pictures. */
#include "input.h"
#include "mesh.h"
#include "missing.h"
#include "model/context.h"
#include "model/dataset.h"
#include "model/merge.h"
#include "output.h"
#include "picture_notes.h"
#include "scene/load.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Looking ahead ends with a signal: a read that began after it would wait again. */
static vv_status check_stopped(const cli_command *command)
{
    return vv_job_cancelled(command->job) ? vv_fail(VV_E_CANCELLED, "interrupted: nothing was written") : VV_OK;
}

static void read_options(vv_read_options *out, const cli_command *command, const char *part)
{
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    vv_read_options_init(out, sizeof *out);
    out->raw = reading->raw;
    out->format = reading->input_format;
    out->part = part ? part : reading->part;
    out->any_part = out->any_length = command->any_part;
}

/* The frame of FILE@N, else of --frame, else -1. */
static int64_t chosen_frame(const cli_command *command, int64_t frame)
{
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    if (frame >= 0)
        return frame;
    return vv_object_is_set(&reading->base, "frame") ? reading->frame : -1;
}

static vv_status check_one_frame(const cli_command *command, const cli_input_name *name)
{
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    if (name->frame < 0 || !vv_object_is_set(&reading->base, "frame") || reading->frame == name->frame)
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, name->path, NULL,
                      "@%" PRId64 " and --frame %" PRId64 " name two time steps; give one of them", name->frame,
                      reading->frame);
}

static vv_status split(cli_input_name *out, const cli_command *command, const char *word)
{
    vv_status st = cli_input_split(out, word);
    if (st == VV_OK && (st = check_one_frame(command, out)) != VV_OK)
        cli_input_name_free(out);
    return st;
}

static vv_status check_frame(const cli_input *input)
{
    const int64_t n = vv_file_info(input->file)->n_frames;
    if (input->frame < n)
        return VV_OK;
    if (n == 1)
        return vv_fail_at(VV_E_ARGUMENT, input->path, NULL,
                          "there is no time step %" PRId64 ": it holds one volume, without time steps", input->frame);
    return vv_fail_at(VV_E_ARGUMENT, input->path, NULL,
                      "there is no time step %" PRId64 "; the file has %" PRId64 ", numbered from 0", input->frame, n);
}

void cli_input_close(cli_input *input)
{
    vv_file_close(input->file);
    free(input->path);
    free(input->part);
    *input = (cli_input){0};
}

vv_property_context cli_input_context(const vv_field_info *info, const vv_registry *registry)
{
    vv_property_context context = vvi_registry_context(registry);
    context.length_unit = info->grid.unit;
    context.voxel = vv_grid_voxel(&info->grid);
    return context;
}

char *cli_folder_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    if (!slash)
        return strdup(".");
    return strndup(path, slash == path ? 1 : (size_t)(slash - path));
}

vv_status cli_world_set_frame(vv_world **world, int64_t frame)
{
    vv_object *root = &(*world)->base;
    vv_status st = VV_OK;
    const size_t n = (*world)->volumes->n;
    for (size_t i = 0; i < n && st == VV_OK && frame >= 0; i++) {
        char path[160];
        const vv_world *now = (const vv_world *)(const void *)root;
        snprintf(path, sizeof path, "volumes.%s.frame", now->volumes->entry[i].id);
        st = vv_path_set_integer(&root, path, frame, NULL);
    }
    *world = (vv_world *)(void *)root;
    return st;
}

static vv_status read_world(vv_world **out, vvi_recipe *recipe_out, cli_command *command, const cli_input_name *name)
{
    const char *path = name->path;
    vv_read_options options;
    *out = NULL;
    *recipe_out = (vvi_recipe){0};
    const cli_input_kind kind = cli_input_contents(command, path);
    const vv_status st = check_stopped(command);
    if (st != VV_OK)
        return st;
    switch (kind) {
    case CLI_INPUT_SCENE:
        return vv_scene_read(out, path, command->job);
    case CLI_INPUT_PICTURE:
        return vvi_recipe_read(out, recipe_out, path, command->job);
    case CLI_INPUT_DATA:
        break;
    }
    read_options(&options, command, name->part);
    const bool mesh = cli_mesh_is_input(command, path);
    if (mesh && command->args.n_words == 1) { /* beside volumes the time step is theirs */
        const vv_status timeless = cli_mesh_check_frame(command, name);
        if (timeless != VV_OK)
            return timeless;
    }
    if (mesh)
        return vvi_world_for_mesh(out, path, options.format, options.part, command->job);
    return vv_world_for_file(out, path, &options, command->job);
}

vv_status cli_input_world(vv_world **out, vvi_recipe *recipe_out, cli_command *command, const char *word)
{
    cli_input_name name;
    vv_status st;
    *out = NULL;
    if ((st = split(&name, command, word)) != VV_OK)
        return st;
    st = read_world(out, recipe_out, command, &name);
    if (st == VV_OK && ((st = cli_world_set_frame(out, chosen_frame(command, name.frame))) != VV_OK ||
                        (st = cli_missing_set(out, command)) != VV_OK)) {
        vv_object_release(&(*out)->base);
        *out = NULL;
    }
    cli_input_name_free(&name);
    return st;
}

/* A file's path, layout and time step take the place of the World's own file. */
static vv_status take_data(cli_input *out, vv_read_options *options, const vv_volume *volume, const vv_dataset *dataset)
{
    char *path = strdup(dataset->path);
    if (!path)
        return vv_fail_memory(strlen(dataset->path) + 1);
    free(out->path);
    out->path = path;
    out->frame = out->frame >= 0 ? out->frame : volume->frame;
    options->format = dataset->format;
    options->part = options->part ? options->part : dataset->part;
    options->raw = dataset->raw;
    return VV_OK;
}

vv_status cli_input_take(cli_input *out, cli_command *command, const vv_volume *volume)
{
    const vv_status st = check_frame(out);
    return st == VV_OK ? cli_missing_take(out, command, volume) : st;
}

static vv_status open_data(cli_input *out, cli_command *command, const vv_read_options *options,
                           const vv_volume *volume)
{
    vv_status st;
    if ((st = check_stopped(command)) != VV_OK)
        return st;
    if ((st = vv_file_open(&out->file, out->path, options, command->job)) != VV_OK)
        return st;
    if (options->part && !(out->part = strdup(options->part)))
        return vv_fail_memory(strlen(options->part));
    return cli_input_take(out, command, volume);
}

/* Nothing is written over what the data are made of. */
static vv_status spare_files(cli_command *command, const vv_world *world)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < world->datasets->n && st == VV_OK; i++) {
        const vv_dataset *dataset = vvi_dataset_nth(world, i);
        if (dataset->path)
            st = cli_output_spare(command, command->common->output, dataset->path);
    }
    return st;
}

static vv_status open_made(cli_input *out, cli_command *command, const vv_world *world, const vv_volume *volume,
                           const vv_dataset *dataset)
{
    vv_status st = spare_files(command, world);
    out->frame = out->frame >= 0 ? out->frame : volume->frame;
    if (st == VV_OK)
        st = vvi_dataset_open(&out->file, world, dataset, command->job);
    return st == VV_OK ? cli_input_take(out, command, volume) : st;
}

/* `convert picture.png`: the data that the picture shows. */
static vv_status open_data_of_world(cli_input *out, cli_command *command, const cli_input_name *name,
                                    const vv_world *world)
{
    vv_read_options options;
    const vv_volume *volume = vvi_first_visible(world);
    const vv_dataset *dataset = volume ? vvi_volume_dataset(world, volume) : NULL;
    vv_status st;
    if (dataset && vv_dataset_is_made(dataset))
        return open_made(out, command, world, volume, dataset);
    if (!dataset || !dataset->path)
        return vv_fail_at(VV_E_FORMAT, out->path, NULL, "is a scene that shows no data from a file");
    vv_read_options_init(&options, sizeof options);
    options.part = name->part;
    if ((st = take_data(out, &options, volume, dataset)) == VV_OK &&
        (st = cli_output_spare(command, command->common->output, out->path)) == VV_OK &&
        (st = open_data(out, command, &options, volume)) != VV_OK)
        st = cli_fail_data(command, world, name->path, st);
    return st;
}

/* Who turns a picture into a volume may have meant either. */
static void tell_data_of_picture(cli_command *command, const char *picture, const char *data)
{
    const char *pixels = cli_input_pixels(command, picture);
    if (!command->verb.makes_file || command->verb.world || cli_input_guess(command, picture) != CLI_INPUT_PICTURE)
        return;
    cli_command_note(command, "%s: taken are the data of the scene in this picture, %s%s%s", picture, data,
                     pixels ? "; for its pixels, give --input-format " : "", pixels ? pixels : "");
}

static vv_status open_data_of_scene(cli_input *out, cli_command *command, const cli_input_name *name)
{
    vvi_recipe recipe;
    vv_world *world = NULL;
    vv_status st = read_world(&world, &recipe, command, name);
    if (st == VV_OK && (st = open_data_of_world(out, command, name, world)) == VV_OK)
        tell_data_of_picture(command, name->path, out->path);
    vv_object_release(world ? &world->base : NULL);
    return st;
}

/* world: NULL where the word says it. */
static vv_status open_input(cli_input *out, cli_command *command, const vv_world *world, const char *word)
{
    vv_read_options options;
    vv_status st;
    cli_input_name name;
    *out = (cli_input){0};
    if ((st = split(&name, command, word)) != VV_OK)
        return st;
    if (!(out->path = strdup(name.path))) {
        cli_input_name_free(&name);
        return vv_fail_memory(strlen(word));
    }
    out->frame = chosen_frame(command, name.frame);
    read_options(&options, command, name.part);
    options.finest = true; /* what is done to data does not depend on the memory of a machine; pictures may */
    st = world                                                      ? open_data_of_world(out, command, &name, world)
         : cli_input_contents(command, out->path) == CLI_INPUT_DATA ? open_data(out, command, &options, NULL)
                                                                    : open_data_of_scene(out, command, &name);
    cli_input_name_free(&name);
    if (st != VV_OK)
        cli_input_close(out);
    return st;
}

vv_status cli_input_open(cli_input *out, cli_command *command, const char *word)
{
    return open_input(out, command, NULL, word);
}

vv_status cli_input_open_in(cli_input *out, cli_command *command, const vv_world *world, const char *word)
{
    return open_input(out, command, world, word);
}
