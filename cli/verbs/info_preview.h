/** @file
 * `info --preview`: slices as a thumbnail in the terminal, or as an image file.
 */
#ifndef CLI_INFO_PREVIEW_H
#define CLI_INFO_PREVIEW_H
#include "input.h"

typedef enum cli_preview_kind {
    CLI_PREVIEW_NONE,
    CLI_PREVIEW_AUTO,
    CLI_PREVIEW_SIXEL,
    CLI_PREVIEW_BLOCKS
} cli_preview_kind;

/** With -o the picture is written there, else it follows the text. size: "WIDTHxHEIGHT" or NULL; field: all samples,
 * or NULL. */
vv_status cli_info_preview(cli_command *command, const cli_input *input, const vv_field *field, cli_preview_kind kind,
                           const char *size);
#endif
