/** @file
 * The output of a command line, checked before the work is done.
 */
#ifndef CLI_OUTPUT_H
#define CLI_OUTPUT_H
#include "command.h"
#include <volvis/file.h>
#include <volvis/mesh_file.h>

typedef enum cli_output_kind { CLI_OUTPUT_VOLUME, CLI_OUTPUT_IMAGE, CLI_OUTPUT_MESH, CLI_OUTPUT_TEXT } cli_output_kind;

/**
 * Whether `output` can be made: its suffix is one that is written, its folder is there, it is none of the command's
 * words (nor `format` something unknown; NULL: by suffix).
 *
 * Errors  VV_E_ARGUMENT with the nearest real suffix, VV_E_WRITE
 */
vv_status cli_output_check(const cli_command *command, const char *output, cli_output_kind kind, const char *format);
/** The format of volumes of that name, or by the suffix; name NULL: by suffix. */
vv_status cli_output_format(const vv_format **out, const cli_command *command, const char *output, const char *name);
/** VV_E_ARGUMENT where text would go into a file whose suffix is that of a volume, a mesh, a picture or a scene. */
vv_status cli_output_check_text(const cli_command *command, const char *output);
/** Whether an option, by the name of its property, stands on the command line, not in the file of defaults. */
bool cli_option_is_typed(const cli_command *command, const char *name);
/** VV_E_ARGUMENT for options that were typed, and that such a file has no use for. named: by --output-format. */
vv_status cli_output_check_volume_options(const cli_command *command, const char *output, const vv_format *format,
                                          bool named);
/** The same; name: of the format; NULL: by suffix. */
vv_status cli_output_check_mesh_options(const cli_command *command, const char *output, const char *name);
vv_status cli_output_check_image_options(const cli_command *command, const char *output);
/** The suffix of a format of pictures by its name, or by one of its suffixes: what standard output is to hold. */
vv_status cli_output_suffix(char *out, size_t n_out, const cli_command *command, const char *output, const char *name);
/** The format of pictures by the suffix; NULL: it is none. */
const vv_image_format *cli_output_picture(const vv_registry *registry, const char *output);
/** Whether it is to be an SVG figure. */
bool cli_output_is_figure(const char *output);
/** The command's -o; VV_E_ARGUMENT says what it is for when there is none. */
vv_status cli_output_need(const char **out, const cli_command *command, const char *what);
/** Options of writing that were given. */
void cli_output_options(vv_write_options *out, const cli_command *command);
void cli_output_mesh_options(vv_mesh_write_options *out, const cli_command *command);
/** Whether both names are of one file, which may have to be made yet. output NULL: no. */
bool cli_output_is(const char *output, const char *path);
/** VV_E_ARGUMENT where the output is that input, unless it may be replaced. output NULL: none. */
vv_status cli_output_spare(const cli_command *command, const char *output, const char *input);
#endif
