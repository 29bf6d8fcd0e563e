#include "input.h"
#include "mesh.h"
#include "model/context.h"
#include "model/merge.h"
#include "output.h"
#include <fcntl.h>
#include <inttypes.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
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

/* FILE@WORD, where FILE is there: the word was meant as a time step. */
static vv_status check_frame_mark(const char *word)
{
    char path[4096];
    const char *mark = strrchr(word, '@');
    const size_t n = mark ? (size_t)(mark - word) : 0;
    if (n == 0 || n >= sizeof path || frame_mark(word))
        return VV_OK;
    memcpy(path, word, n);
    path[n] = 0;
    return access(path, F_OK) == 0
               ? vv_fail(VV_E_ARGUMENT, "%s: '%.40s' is not a time step; time steps are numbered from 0, as in %s@0",
                         word, mark + 1, path)
               : VV_OK;
}

/* Where ":PART" starts, before `end`: after the longest name of something that is there. */
static const char *part_mark(const char *word, size_t end)
{
    char path[4096];
    if (end >= sizeof path)
        return NULL;
    for (size_t n = end - (end > 0); n > 0; n--) {
        if (word[n] != ':')
            continue;
        memcpy(path, word, n);
        path[n] = 0;
        if (strcmp(path, "-") == 0 || access(path, F_OK) == 0)
            return word + n;
    }
    return NULL;
}

/* The folder of a pattern of names, "run/jet_{t}.vti": how long its name is; SIZE_MAX where the word is none. */
static size_t pattern_folder(const char *word, size_t end)
{
    char path[4096];
    size_t n = end;
    while (n > 0 && word[n - 1] != '/')
        n--;
    if (n >= sizeof path || strcspn(word + n, "*?#{") >= end - n)
        return SIZE_MAX;
    memcpy(path, word, n);
    path[n] = 0;
    return n == 0 || access(path, F_OK) == 0 ? n : SIZE_MAX;
}

/* Files of a folder, by a pattern of their names: its part by that name. */
static vv_status split_pattern(cli_input_name *out, const char *word, size_t n_folder, size_t end)
{
    out->path = n_folder > 0 ? strndup(word, n_folder) : strdup(".");
    out->part = strndup(word + n_folder, end - n_folder);
    if (out->path && out->part)
        return VV_OK;
    cli_input_name_free(out);
    return vv_fail_memory(end + 1);
}

vv_status cli_input_split(cli_input_name *out, const char *word)
{
    *out = (cli_input_name){.frame = -1};
    if (!word[0])
        return vv_fail(VV_E_ARGUMENT, "the name of the input is empty; give a file, a folder, or - for standard input");
    const bool whole = access(word, F_OK) == 0;
    const vv_status st = whole ? VV_OK : check_frame_mark(word);
    if (st != VV_OK)
        return st;
    const char *frame = whole ? NULL : frame_mark(word);
    const size_t end = frame ? (size_t)(frame - word) : strlen(word);
    const char *part = whole ? NULL : part_mark(word, end);
    const size_t n = part ? (size_t)(part - word) : end;
    if (frame)
        out->frame = strtoll(frame + 1, NULL, 10);
    const size_t folder = whole || part ? SIZE_MAX : pattern_folder(word, end);
    if (folder != SIZE_MAX)
        return split_pattern(out, word, folder, end);
    out->path = strndup(word, n);
    if (part)
        out->part = strndup(part + 1, end - n - 1);
    if (out->path && (!part || out->part))
        return VV_OK;
    cli_input_name_free(out);
    return vv_fail_memory(end + 1);
}

void cli_input_name_free(cli_input_name *name)
{
    free(name->path);
    free(name->part);
    *name = (cli_input_name){.frame = -1};
}

static bool ends_with(const char *text, const char *end)
{
    const size_t n = strlen(text), n_end = strlen(end);
    return n >= n_end && strcmp(text + n - n_end, end) == 0;
}

/* The first bytes of standard input, which stay there to be read; 0 where the system cannot look ahead. */
static size_t peek_standard_input(unsigned char *out, size_t n)
{
    const off_t at = lseek(STDIN_FILENO, 0, SEEK_CUR);
    ssize_t got = at >= 0 ? pread(STDIN_FILENO, out, n, at) : 0;
#ifdef __linux__
    int copy[2];
    struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN};
    /* poll ends with a signal, tee goes on waiting */
    if (at < 0 && poll(&input, 1, -1) == 1 && pipe2(copy, O_CLOEXEC) == 0) {
        if (tee(STDIN_FILENO, copy[1], n, SPLICE_F_NONBLOCK) > 0)
            got = read(copy[0], out, n);
        close(copy[0]);
        close(copy[1]);
    }
#endif
    return got > 0 ? (size_t)got : 0;
}

static size_t peek_file(unsigned char *out, size_t n, const char *path)
{
    struct stat about;
    if (stat(path, &about) != 0 || !S_ISREG(about.st_mode))
        return 0; /* what a stream gives is gone once it is read */
    FILE *file = fopen(path, "rbe");
    const size_t got = file ? fread(out, 1, n, file) : 0;
    if (file)
        fclose(file);
    return got;
}

size_t cli_input_peek(unsigned char *out, size_t n, const char *path)
{
    return strcmp(path, "-") == 0 ? peek_standard_input(out, n) : peek_file(out, n, path);
}

/* What a format of volumes is certain of: a TIFF, where VolVis did not make a picture of it. */
static bool is_volume(const vv_registry *registry, const unsigned char *head, size_t n, const char *path)
{
    for (const vv_format *const *row = registry->formats; *row; row++)
        if ((*row)->probe && (*row)->probe(head, n, path) == 2)
            return true;
    return false;
}

/* By content; what it leaves in doubt the suffix decides. */
static bool is_picture(const vv_registry *registry, const unsigned char *head, size_t n, const char *path)
{
    for (const vv_image_format *const *row = registry->image_formats; *row; row++) {
        const int sure = n > 0 && (*row)->probe ? (*row)->probe(head, n, path) : 0;
        if (sure == 2)
            return true;
        for (size_t s = 0; sure == 1 && !is_volume(registry, head, n, path) && (*row)->suffixes[s]; s++)
            if (ends_with(path, (*row)->suffixes[s]))
                return true;
    }
    return false;
}

cli_input_kind cli_input_guess(const cli_command *command, const char *path)
{
    static const unsigned char png[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    const bool standard = strcmp(path, "-") == 0;
    unsigned char head[64] = {0};
    size_t blank = 0;
    if (reading->raw || reading->input_format || vv_job_cancelled(command->job))
        return CLI_INPUT_DATA;
    if (ends_with(path, ".vv.json"))
        return CLI_INPUT_SCENE;
    const size_t n = cli_input_peek(head, sizeof head, path);
    while (blank < n && strchr(" \t\r\n", head[blank]))
        blank++;
    if (standard && blank < n && head[blank] == '{')
        return CLI_INPUT_SCENE;
    /* a pipe may give less than the whole mark at first: no data begins with a part of it */
    const bool picture = (n > 0 && memcmp(head, png, n < sizeof png ? n : sizeof png) == 0) ||
                         is_picture(command->registry, head, n, path);
    return picture ? CLI_INPUT_PICTURE : CLI_INPUT_DATA;
}

/* Whether a picture may be a slice: a format of volumes knows PNG and JPEG. What a stream gave is gone once it was
 * looked into. */
static bool may_be_slice(const cli_command *command, const char *path)
{
    unsigned char head[64];
    const size_t n = peek_file(head, sizeof head, path);
    for (const vv_format *const *row = command->registry->formats; n > 0 && *row; row++)
        if ((*row)->probe && (*row)->probe(head, n, path) > 0)
            return true;
    return false;
}

cli_input_kind cli_input_contents(const cli_command *command, const char *path)
{
    const cli_input_kind kind = cli_input_guess(command, path);
    const bool slice = kind == CLI_INPUT_PICTURE && strcmp(path, "-") != 0 && may_be_slice(command, path) &&
                       vvi_recipe_is_missing(path, command->job);
    return slice ? CLI_INPUT_DATA : kind;
}

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
    out->any_part = command->any_part;
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
    return vv_fail_at(VV_E_ARGUMENT, input->path, NULL,
                      "there is no time step %" PRId64 "; the file has %" PRId64 ", numbered from 0", input->frame, n);
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
    if (st == VV_OK && (st = set_frame(out, chosen_frame(command, name.frame))) != VV_OK) {
        vv_object_release(&(*out)->base);
        *out = NULL;
    }
    cli_input_name_free(&name);
    return st;
}

const vv_dataset *cli_input_dataset(const vv_world *world, const vv_volume *volume)
{
    const vv_collection *datasets = world->datasets;
    const vv_object *found = volume->data  ? vv_collection_find(datasets, volume->data)
                             : datasets->n ? datasets->entry[0].object
                                           : NULL;
    return (const vv_dataset *)(const void *)found;
}

/* The data that a World shows first: its path, layout and time step take the place of the World's own file. */
static vv_status take_data(cli_input *out, vv_read_options *options, const vv_world *world)
{
    const vv_volume *volume = NULL;
    for (size_t i = 0; i < world->volumes->n && !volume; i++) {
        const vv_volume *one = (const vv_volume *)(const void *)world->volumes->entry[i].object;
        volume = one->visible ? one : NULL;
    }
    const vv_dataset *dataset = volume ? cli_input_dataset(world, volume) : NULL;
    if (!dataset || !dataset->path)
        return vv_fail_at(VV_E_FORMAT, out->path, NULL, "is a scene that shows no data from a file");
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

static vv_status open_data(cli_input *out, cli_command *command, const vv_read_options *options)
{
    vv_status st;
    if ((st = check_stopped(command)) != VV_OK)
        return st;
    if ((st = vv_file_open(&out->file, out->path, options, command->job)) != VV_OK)
        return st;
    return check_frame(out);
}

/* `convert picture.png`: the data that the picture shows. */
static vv_status open_data_of_world(cli_input *out, cli_command *command, const cli_input_name *name,
                                    const vv_world *world)
{
    vv_read_options options;
    vv_status st;
    vv_read_options_init(&options, sizeof options);
    options.part = name->part;
    if ((st = take_data(out, &options, world)) == VV_OK &&
        (st = cli_output_spare(command, command->common->output, out->path)) == VV_OK)
        st = open_data(out, command, &options);
    return st;
}

static vv_status open_data_of_scene(cli_input *out, cli_command *command, const cli_input_name *name)
{
    vvi_recipe recipe;
    vv_world *world = NULL;
    vv_status st = read_world(&world, &recipe, command, name);
    if (st == VV_OK)
        st = open_data_of_world(out, command, name, world);
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
         : cli_input_contents(command, out->path) == CLI_INPUT_DATA ? open_data(out, command, &options)
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
