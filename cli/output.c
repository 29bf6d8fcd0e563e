#include "output.h"
#include "core/names.h"
#include "input.h"
#include "io/format.h"
#include "io/formats/slices/slices_write.h"
#include "io/mesh_file.h"
#include "refusal.h"
#include "registry.h"
#include "value.h"
#include "watch.h"
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAX_SUFFIXES = 128 };

void cli_output_options(vv_write_options *out, const cli_command *command)
{
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    vv_write_options_init(out, sizeof *out);
    out->format = writing->output_format;
    out->encoding = writing->encoding;
    out->level = vv_object_is_set(&writing->base, "level") ? (int)writing->level : 0;
    out->big_endian = writing->big_endian;
    out->stored = writing->stored;
    out->keep_order = cli_option_is_typed(command, "order");
    out->spare_inputs = !command->common->overwrite;
}

void cli_output_mesh_options(vv_mesh_write_options *out, const cli_command *command)
{
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    vv_mesh_write_options_init(out, sizeof *out);
    out->format = writing->output_format;
    out->encoding = writing->encoding ? writing->encoding : writing->big_endian ? "big-endian" : NULL;
    out->level = vv_object_is_set(&writing->base, "level") ? (int)writing->level : 0;
    out->spare_inputs = !command->common->overwrite;
}

bool cli_output_is_figure(const char *output)
{
    return cli_ends_with(output, ".svg");
}

static vv_status fail_suffix(const char *output, const vv_registry *registry)
{
    const char *names[MAX_SUFFIXES];
    size_t n = 0;
    for (const vv_image_format *const *row = registry->image_formats; *row; row++)
        for (const char *const *s = (*row)->suffixes; (*row)->write && *s && n + 1 < MAX_SUFFIXES; s++)
            names[n++] = *s;
    names[n++] = ".svg";
    return vvi_fail_name(VV_E_ARGUMENT, output, NULL, cli_suffix_of(output), &(vvi_known){names, n, NULL, NULL},
                         "has no suffix that an image format writes");
}

vv_status cli_output_suffix(char *out, size_t n_out, const cli_command *command, const char *output, const char *name)
{
    const char *names[MAX_SUFFIXES] = {"svg"};
    size_t n = 1;
    if (strcmp(output, "-") != 0)
        return cli_refused(
            command, "output-format",
            vv_fail_at(
                VV_E_ARGUMENT, output, NULL,
                "--output-format is for standard output (-o -); a file's suffix says its format: leave one out"));
    name += name[0] == '.';
    for (const vv_image_format *const *row = command->registry->image_formats; *row; row++) {
        bool same = strcasecmp((*row)->name, name) == 0;
        for (const char *const *s = (*row)->suffixes; *s && !same; s++)
            same = strcasecmp(*s + 1, name) == 0;
        if (same) {
            snprintf(out, n_out, "%s", (*row)->suffixes[0]);
            return VV_OK;
        }
        if ((*row)->write && n < MAX_SUFFIXES)
            names[n++] = (*row)->name;
    }
    if (strcasecmp(name, names[0]) == 0) {
        snprintf(out, n_out, ".svg");
        return VV_OK;
    }
    return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, name, &(vvi_known){names, n, NULL, NULL},
                         "there is no format of pictures '%.60s'", name);
}

const vv_image_format *cli_output_picture(const vv_registry *registry, const char *output)
{
    for (const vv_image_format *const *row = registry->image_formats; *row; row++)
        for (size_t s = 0; (*row)->suffixes[s]; s++)
            if (cli_ends_with(output, (*row)->suffixes[s]))
                return *row;
    return NULL;
}

static vv_status check_image(const vv_registry *registry, const char *output)
{
    const vv_image_format *format = cli_output_picture(registry, output);
    if (!format)
        return fail_suffix(output, registry);
    return format->write ? VV_OK
                         : vv_fail_at(VV_E_UNSUPPORTED, output, NULL, "%s images cannot be written: %s", format->name,
                                      format->doc);
}

vv_status cli_output_format(const vv_format **out, const cli_command *command, const char *output, const char *name)
{
    return name ? vvi_format_named(out, name, command->registry) : vvi_format_of_output(out, output, command->registry);
}

static vv_status check_volume(const cli_command *command, const char *output, const char *name)
{
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    const vv_format *format;
    vv_status st = cli_output_format(&format, command, output, name);
    if (st != VV_OK ||
        (st = cli_refused(command, "encoding", vvi_format_check_encoding(format, writing->encoding))) != VV_OK)
        return st;
    return cli_output_check_volume_options(command, output, format, name != NULL);
}

static vv_status check_mesh(const cli_command *command, const char *output)
{
    vv_mesh_write_options options;
    cli_output_mesh_options(&options, command);
    const vv_status st = cli_refused(command, "encoding,big-endian", vv_mesh_check(output, &options, NULL));
    return st == VV_OK ? cli_output_check_mesh_options(command, output, options.format) : st;
}

/* The format where the output is a folder itself; else NULL. */
static const vv_format *format_of_folder(const cli_command *command, const char *output, const char *name)
{
    const vv_format *format;
    const vv_status st = cli_output_format(&format, command, output, name);
    return st == VV_OK && format->folder_file ? format : NULL;
}

static bool holds_files(const char *folder)
{
    DIR *open = opendir(folder);
    bool any = false;
    for (struct dirent *entry; open && !any && (entry = readdir(open)) != NULL;)
        any = strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    if (open)
        closedir(open);
    return any;
}

/* Slices of an older run are replaced when that is asked for, or when this one made them and watches what they are of.
 */
static vv_status check_slices(const cli_command *command, const char *output, const char *name)
{
    const vv_format *format;
    const bool ours = command->common->overwrite || (command->watch && command->watch->n_runs > 0);
    const vv_status st = cli_output_format(&format, command, output, name);
    if (st != VV_OK || ours || format->folder_file != vvi_format_slices.folder_file)
        return st;
    const char *names = vvi_slices_pattern(output);
    char *folder = strndup(output, names ? (size_t)(names - output) : strlen(output));
    const bool there = folder && holds_files(folder);
    free(folder);
    return there ? vv_fail_at(VV_E_ARGUMENT, output, NULL,
                              "is there already, with files in it; name another folder, or give --overwrite, which "
                              "replaces all slices that VolVis wrote there")
                 : VV_OK;
}

/* format: that of a folder, or NULL: the output is a file. */
static vv_status check_folder(const char *output, const vv_format *format)
{
    const bool is_folder = format != NULL;
    struct stat about;
    size_t n = strlen(output);
    int error = 0;
    vv_status st = VV_OK;
    const bool slices = is_folder && format->folder_file == vvi_format_slices.folder_file;
    const char *names = slices ? vvi_slices_pattern(output) : NULL;
    if (names && names > output)
        n = (size_t)(names - output);
    while (is_folder && n > 1 && output[n - 1] == '/')
        n--;
    char *path = strndup(output, n), *folder = path ? cli_folder_of(path) : NULL;
    free(path);
    if (!folder)
        return vv_fail_memory(strlen(output));
    if (!is_folder && stat(output, &about) == 0 && S_ISDIR(about.st_mode))
        st = vv_fail_at(VV_E_WRITE, output, NULL, "is a folder: give a file's name");
    else if (stat(folder, &about) != 0)
        st = vv_fail_at(VV_E_WRITE, output, NULL, "the folder '%s' cannot be used: %s", folder, strerror(errno));
    else if (!S_ISDIR(about.st_mode))
        st = vv_fail_at(VV_E_WRITE, output, NULL, "'%s' is not a folder", folder);
    else if (access(folder, W_OK) != 0 && (error = errno, access(output, W_OK) != 0))
        st = vv_fail_at(VV_E_WRITE, output, NULL, "the folder '%s' cannot be written to: %s", folder, strerror(error));
    free(folder);
    return st;
}

bool cli_output_is(const char *output, const char *path)
{
    struct stat out, in;
    if (!output || stat(output, &out) == 0)
        return output && stat(path, &in) == 0 && in.st_dev == out.st_dev && in.st_ino == out.st_ino;
    char *folder_out = cli_folder_of(output), *folder_in = cli_folder_of(path);
    const bool same = folder_out && folder_in && strcmp(cli_base_of(output), cli_base_of(path)) == 0 &&
                      stat(folder_out, &out) == 0 && stat(folder_in, &in) == 0 && in.st_dev == out.st_dev &&
                      in.st_ino == out.st_ino;
    free(folder_out);
    free(folder_in);
    return same;
}

vv_status cli_output_spare(const cli_command *command, const char *output, const char *input)
{
    if (command->common->overwrite || !cli_output_is(output, input) || access(input, F_OK) != 0)
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, output, NULL, "is also an input of this command; give --overwrite to replace it");
}

static vv_status check_inputs(const cli_command *command, const char *output)
{
    const char *word;
    vv_status st = VV_OK;
    for (size_t i = 0; (word = cli_command_word(command, i)) && st == VV_OK; i++) {
        cli_input_name name;
        if ((st = cli_input_split(&name, word)) != VV_OK)
            return st;
        st = cli_output_spare(command, output, name.path);
        cli_input_name_free(&name);
    }
    return st;
}

/* What a suffix makes people and programs expect in a file; NULL: nothing that text would not be. */
static const char *contents_by_suffix(const char *output, const vv_registry *registry)
{
    size_t n;
    vvi_path_coding(output, &n);
    if (cli_ends_with(output, ".vv.json"))
        return "scene";
    if (vvi_mesh_format_of_path(output, registry))
        return "mesh";
    if (cli_output_picture(registry, output))
        return "picture";
    for (const vv_format *const *row = registry->formats; *row; row++)
        if (vvi_format_has_suffix(*row, output, n))
            return "volume";
    return cli_output_is_figure(output) ? "picture" : NULL;
}

vv_status cli_output_need(const char **out, const cli_command *command, const char *what)
{
    *out = command->common->output;
    if (*out && **out)
        return VV_OK;
    const char *last = command->args.n_words > 1 ? command->args.words[command->args.n_words - 1] : NULL;
    if (last && access(last, F_OK) != 0)
        return vv_fail(VV_E_ARGUMENT, "%s needs -o FILE: where %s goes; did you mean -o %s?", command->verb.name, what,
                       last);
    const char *contents = last ? contents_by_suffix(last, command->registry) : NULL;
    if (contents && strstr(what, contents))
        return vv_fail(VV_E_ARGUMENT,
                       "%s needs -o FILE: where %s goes; %s is taken for an input, and -o %s would replace it",
                       command->verb.name, what, last, last);
    return vv_fail(VV_E_ARGUMENT, "%s needs -o FILE: where %s goes ('-' is standard output)", command->verb.name, what);
}

vv_status cli_output_check_text(const cli_command *command, const char *output)
{
    const char *contents = contents_by_suffix(output, command->registry), *draws = command->verb.draws;
    const bool picture = contents && strcmp(contents, "picture") == 0;
    if (!contents || strcmp(output, "-") == 0)
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, output, NULL,
                      "has the suffix of a %s, but %s writes text: %s%sname a file such as .txt, .json or .csv",
                      contents, command->verb.name, picture && draws ? draws : "", picture && draws ? ", or " : "");
}

static vv_status check_standard_output(cli_output_kind kind, const char *format)
{
    if ((kind == CLI_OUTPUT_VOLUME || kind == CLI_OUTPUT_MESH) && !format)
        return vv_fail(VV_E_ARGUMENT, "-o -: standard output has no suffix; say the format with --output-format %s",
                       kind == CLI_OUTPUT_MESH ? "ply" : "nrrd");
    if (isatty(STDOUT_FILENO))
        return vv_fail(VV_E_ARGUMENT, "-o -: standard output is a terminal; redirect it to a file or another program");
    return VV_OK;
}

vv_status cli_output_check(const cli_command *command, const char *output, cli_output_kind kind, const char *format)
{
    const bool standard = strcmp(output, "-") == 0;
    vv_status st = standard ? check_standard_output(kind, format) : VV_OK;
    if (st == VV_OK && kind == CLI_OUTPUT_VOLUME)
        st = check_volume(command, output, format);
    if (st == VV_OK && kind == CLI_OUTPUT_MESH)
        st = check_mesh(command, output);
    if (st != VV_OK || standard)
        return st;
    if ((kind == CLI_OUTPUT_IMAGE && (st = check_image(command->registry, output)) != VV_OK) ||
        (st = check_inputs(command, output)) != VV_OK ||
        (kind == CLI_OUTPUT_VOLUME && (st = check_slices(command, output, format)) != VV_OK))
        return st;
    return check_folder(output, kind == CLI_OUTPUT_VOLUME ? format_of_folder(command, output, format) : NULL);
}
