/* Options of writing that the output has no use for are refused: formats' rows say what they have. */
#include "command.h"
#include "io/format.h"
#include "io/mesh_file.h"
#include "output.h"
#include "refusal.h"
#include <string.h>
#include <strings.h>

bool cli_option_is_typed(const cli_command *command, const char *name)
{
    for (size_t i = 0; i < command->args.n_given; i++)
        if (strcmp(command->args.given[i].row->name, name) == 0 && !command->args.given[i].place)
            return true;
    return false;
}

/* Whether a level of compression says anything to an encoding: "sharded-raw" is raw, too. */
static bool compresses(const char *encoding)
{
    static const char *const plain[] = {"raw", "ascii", "hex", "base64", "binary", "big-endian", "separate", "lzw"};
    const char *dash = strchr(encoding, '-');
    const char *name = dash && strcmp(dash, "-raw") == 0 ? dash + 1 : encoding;
    for (size_t i = 0; i < sizeof plain / sizeof *plain; i++)
        if (strcmp(name, plain[i]) == 0)
            return false;
    return true;
}

static vv_status fail_level(const char *format, const char *const *encodings, const char *chosen)
{
    vvi_text list = {0};
    for (size_t i = 0; encodings && encodings[i]; i++)
        if (compresses(encodings[i]))
            vvi_text_printf(&list, "%s%s", list.n ? ", " : "", encodings[i]);
    const vv_status st = vv_fail(VV_E_ARGUMENT, "--level does nothing to %s%s%s, which is not compressed: omit it%s%s",
                                 format, chosen ? " with encoding " : "", chosen ? chosen : "",
                                 list.n ? ", or give --encoding: " : "", list.n && !list.bad ? list.s : "");
    vvi_text_free(&list);
    return st;
}

static vv_status check_level(const cli_command *command, const char *output, const char *format,
                             const char *const *encodings)
{
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    const char *chosen = writing->encoding ? writing->encoding : encodings ? encodings[0] : NULL;
    size_t n;
    if (!cli_option_is_typed(command, "level") || vvi_path_coding(output, &n) != VVI_CODING_NONE ||
        (chosen && compresses(chosen)))
        return VV_OK;
    return fail_level(format, encodings, chosen);
}

/* Readers go by the suffix: what it says is what the file has to be. */
static vv_status fail_suffix(const char *output, const char *named, const char *meant)
{
    return vv_fail_at(VV_E_ARGUMENT, output, NULL,
                      "has the suffix of %s, and --output-format says %s: omit --output-format, or choose another name",
                      meant, named);
}

static const vv_format *volume_format_of(const char *path, size_t n, const vv_registry *registry)
{
    for (const vv_format *const *row = registry->formats; *row; row++)
        if ((*row)->write && vvi_format_has_suffix(*row, path, n))
            return *row;
    return NULL;
}

vv_status cli_output_check_volume_options(const cli_command *command, const char *output, const vv_format *format,
                                          bool named)
{
    size_t n;
    vvi_path_coding(output, &n);
    const vv_format *volume = volume_format_of(output, n, command->registry);
    const vv_mesh_format *mesh = vvi_mesh_format_of_path(output, command->registry);
    /* the bare samples of a pair have a name that its header goes by */
    const bool samples = strcmp(format->name, "raw") == 0 && n > 4 && strncasecmp(output + n - 4, ".img", 4) == 0;
    if (named && format->write && !samples && (volume || mesh) && !vvi_format_has_suffix(format, output, n))
        return cli_refused(command, "output-format",
                           fail_suffix(output, format->name, volume ? volume->name : mesh->name));
    return check_level(command, output, format->name, format->encodings);
}

vv_status cli_output_check_mesh_options(const cli_command *command, const char *output, const char *name)
{
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    size_t n;
    if (writing->stored)
        return cli_refused(command, "stored",
                           vv_fail(VV_E_ARGUMENT, "--stored does nothing to meshes: it is about samples of volumes"));
    vvi_path_coding(output, &n);
    const vv_mesh_format *suffix = vvi_mesh_format_of_path(output, command->registry);
    const vv_mesh_format *format = name ? vvi_mesh_format_find(name, command->registry) : suffix;
    const vv_format *volume = volume_format_of(output, n, command->registry);
    if (name && format && (suffix ? suffix != format : volume != NULL))
        return cli_refused(command, "output-format",
                           fail_suffix(output, format->name, suffix ? suffix->name : volume->name));
    return format ? check_level(command, output, format->name, format->encodings) : VV_OK;
}

vv_status cli_output_check_image_options(const cli_command *command, const char *output)
{
    const vv_image_format *const *row = command->registry->image_formats;
    for (; *row; row++) {
        const size_t n = strlen(output);
        for (size_t s = 0; (*row)->suffixes[s]; s++) {
            const size_t n_suffix = strlen((*row)->suffixes[s]);
            if (n < n_suffix || strcasecmp(output + n - n_suffix, (*row)->suffixes[s]) != 0)
                continue;
            if (!(*row)->lossy && cli_option_is_typed(command, "image_quality"))
                return vv_fail(VV_E_ARGUMENT,
                               "--image-quality does nothing to %s, which loses nothing: omit it, or "
                               "write JPEG or WebP",
                               (*row)->name);
            if (!(*row)->paper && cli_option_is_typed(command, "dpi"))
                return vv_fail(VV_E_ARGUMENT,
                               "--dpi does nothing to %s, which has no size on paper: omit it, or write "
                               "PNG, JPEG, TIFF or PDF",
                               (*row)->name);
            return VV_OK;
        }
    }
    return VV_OK;
}
