#include "label_layers.h"
#include "grid/label_id.h"
#include "value.h"
#include <string.h>
#include <strings.h>

/* name: of the label, instead of its id; NULL: none. */
static const vv_label *find(const vv_file *file, vv_label_id label, const char *name)
{
    size_t n;
    const vv_label *labels = vv_file_labels(file, &n);
    for (size_t i = 0; i < n; i++)
        if (name ? strcasecmp(labels[i].name, name) == 0 : labels[i].value == label)
            return &labels[i];
    return NULL;
}

/* "layer1", and "5/layer1" of the fifth series. */
static bool is_layer(const char *part)
{
    return strncmp(cli_base_of(part), "layer", 5) == 0;
}

static vv_status look(const cli_command *command, const cli_input *input, const char *part, vv_label_id label,
                      const char *name)
{
    vv_read_options options;
    vv_file *file = NULL;
    char digits[VVI_LABEL_DIGITS];
    vv_read_options_init(&options, sizeof options);
    options.format = vv_file_format(input->file);
    options.part = part;
    vv_status st = vv_file_open(&file, input->path, &options, command->job);
    const vv_label *there = st == VV_OK ? find(file, label, name) : NULL;
    if (there)
        st = vv_fail_at(VV_E_NOT_FOUND, input->path, NULL,
                        "the label %s%s%s%s lies in another layer than the one that is read: give %s:%s",
                        vvi_label_print(digits, there->value, vvi_label_is_unsigned(vv_file_info(file)->type)),
                        *there->name ? " (" : "", there->name, *there->name ? ")" : "", input->path, part);
    vv_file_close(file);
    return st;
}

static vv_status check(const cli_command *command, const cli_input *input, vv_label_id label, const char *name)
{
    vv_part part;
    vv_status st = VV_OK;
    if (!input->file || find(input->file, label, name))
        return VV_OK;
    for (size_t i = 0; st == VV_OK && vv_file_part(input->file, i, &part); i++)
        if (!part.chosen && is_layer(part.name))
            st = look(command, input, part.name, label, name);
    return st;
}

vv_status cli_label_layer_check(const cli_command *command, const cli_input *input, vv_label_id label)
{
    return check(command, input, label, NULL);
}

vv_status cli_label_layer_check_name(const cli_command *command, const cli_input *input, const char *name)
{
    return check(command, input, 0, name);
}
