#include "input.h"
#include "model/context.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Where "@N" starts; NULL when the word does not end so. */
static const char *frame_mark(const char *word)
{
    const char *mark = strrchr(word, '@');
    const size_t digits = mark ? strspn(mark + 1, "0123456789") : 0;
    if (!mark || mark == word || digits == 0 || digits > 15 || mark[1 + digits] != 0)
        return NULL;
    return mark;
}

vv_status cli_input_split(char **path_out, int64_t *frame_out, const char *word)
{
    const char *mark = access(word, F_OK) == 0 ? NULL : frame_mark(word);
    const size_t n = mark ? (size_t)(mark - word) : strlen(word);
    *frame_out = mark ? strtoll(mark + 1, NULL, 10) : -1;
    *path_out = strndup(word, n);
    return *path_out ? VV_OK : vv_fail_memory(n + 1);
}

static bool ends_with(const char *text, const char *end)
{
    const size_t n = strlen(text), n_end = strlen(end);
    return n >= n_end && strcmp(text + n - n_end, end) == 0;
}

cli_input_kind cli_input_guess(const char *path)
{
    static const unsigned char png[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    unsigned char head[8] = {0};
    if (ends_with(path, ".vv.json"))
        return CLI_INPUT_SCENE;
    if (strcmp(path, "-") == 0)
        return CLI_INPUT_DATA;
    FILE *file = fopen(path, "rbe");
    const size_t n = file ? fread(head, 1, sizeof head, file) : 0;
    if (file)
        fclose(file);
    return n == sizeof head && memcmp(head, png, sizeof png) == 0 ? CLI_INPUT_PICTURE : CLI_INPUT_DATA;
}

static void read_options(vv_read_options *out, const cli_command *command)
{
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    vv_read_options_init(out, sizeof *out);
    out->raw = reading->raw;
    out->format = reading->input_format;
}

/* The frame of FILE@N, else of --frame, else -1. */
static int64_t chosen_frame(const cli_command *command, int64_t frame)
{
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    if (frame >= 0)
        return frame;
    return vv_object_is_set(&reading->base, "frame") ? reading->frame : -1;
}

static vv_status check_frame(const cli_input *input)
{
    const int64_t n = vv_file_info(input->file)->n_frames;
    if (input->frame < n)
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, input->path, NULL,
                      "there is no time step %" PRId64 ": the file has %" PRId64 ", counted from 0", input->frame, n);
}

vv_status cli_input_open(cli_input *out, cli_command *command, const char *word)
{
    vv_read_options options;
    vv_status st;
    *out = (cli_input){0};
    read_options(&options, command);
    if ((st = cli_input_split(&out->path, &out->frame, word)) != VV_OK)
        return st;
    out->frame = chosen_frame(command, out->frame);
    if ((st = vv_file_open(&out->file, out->path, &options, command->job)) != VV_OK ||
        (st = check_frame(out)) != VV_OK) {
        cli_input_close(out);
        return st;
    }
    return VV_OK;
}

void cli_input_close(cli_input *input)
{
    vv_file_close(input->file);
    free(input->path);
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

/* The time step in every volume of the World. */
static vv_status set_frame(vv_world **world, int64_t frame)
{
    vv_object *root = &(*world)->base;
    vv_status st = VV_OK;
    const size_t n = (*world)->volumes->n;
    for (size_t i = 0; i < n && st == VV_OK && frame >= 0; i++) {
        char path[160], value[32];
        const vv_world *now = (const vv_world *)(const void *)root;
        snprintf(path, sizeof path, "volumes.%s.frame", now->volumes->entry[i].id);
        snprintf(value, sizeof value, "%" PRId64, frame);
        st = vv_path_set(&root, path, value, NULL);
    }
    *world = (vv_world *)(void *)root;
    return st;
}

vv_status cli_input_world(vv_world **out, cli_recipe *recipe_out, cli_command *command, const char *word)
{
    vv_read_options options;
    char *path = NULL;
    int64_t frame = -1;
    vv_status st;
    *out = NULL;
    *recipe_out = (cli_recipe){0};
    read_options(&options, command);
    if ((st = cli_input_split(&path, &frame, word)) != VV_OK)
        return st;
    switch (cli_input_guess(path)) {
    case CLI_INPUT_SCENE:
        st = vv_scene_read(out, path, command->job);
        break;
    case CLI_INPUT_PICTURE:
        st = cli_recipe_read(out, recipe_out, path, command->job);
        break;
    case CLI_INPUT_DATA:
        st = vv_world_for_file(out, path, &options, command->job);
        break;
    }
    if (st == VV_OK && (st = set_frame(out, chosen_frame(command, frame))) != VV_OK) {
        vv_object_release(&(*out)->base);
        *out = NULL;
    }
    free(path);
    return st;
}
