/** @file
 * Labels by their names on the command line.
 */
#ifndef CLI_LABEL_NAMES_H
#define CLI_LABEL_NAMES_H
#include "input.h"

/** What labels are called: by the file that they are read from, or by a scene. */
typedef struct cli_label_names {
    const vv_label *label;
    size_t n;
    bool is_unsigned;           /**< ids are the bits of uint64_t */
    const cli_command *command; /**< both NULL, or where other layers of the file are looked into */
    const cli_input *input;
} cli_label_names;

/** The names that an input has. */
cli_label_names cli_label_names_of(const cli_command *command, const cli_input *input);
/** The label that a word of `n` letters names, in whatever letter case, or is the number of. VV_E_ARGUMENT,
 * VV_E_NOT_FOUND with the nearest name; false in *known_out: it is no name, and no label has one, so that whoever asks
 * says what is expected. */
vv_status cli_label_find(vv_label_id *out, bool *known_out, const cli_label_names *names, const char *option,
                         const char *word, size_t n);
/** cli_args_object() for the parameters of an operation: its options that are labels take names too. */
vv_status cli_label_params(vv_object **out, const cli_args *args, const vv_class *cls,
                           const vv_property_context *context, const cli_label_names *names);
#endif
