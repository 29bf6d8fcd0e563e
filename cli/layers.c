#include "layers.h"
#include "io/format.h"
#include "output.h"
#include <stdlib.h>
#include <string.h>

bool cli_layers_wanted(const cli_command *command)
{
    const vv_format *format = NULL;
    vv_write_options options;
    cli_output_options(&options, command);
    const char *output = command->common->output;
    if (!output)
        return false;
    const vv_status st = options.format ? vvi_format_named(&format, options.format, command->registry)
                                        : vvi_format_of_output(&format, output, command->registry);
    return st == VV_OK && format->labels_only;
}

/* Letters before the number of a layer, "layer" or "9/layer"; 0 when it is none. */
static size_t layer_mark(const char *part)
{
    const char *word = strstr(part, "layer");
    const size_t digits = word ? strspn(word + 5, "0123456789") : 0;
    return digits > 0 && word[5 + digits] == 0 && (word == part || word[-1] == '/') ? (size_t)(word - part) + 5 : 0;
}

/* The part that is read. */
static const char *chosen_part(const vv_file *file)
{
    vv_part part;
    for (size_t i = 0; vv_file_part(file, i, &part); i++)
        if (part.chosen && layer_mark(part.name) > 0)
            return part.name;
    return NULL;
}

static vv_status open_layer(cli_layers *out, cli_command *command, const cli_input *input, const char *part)
{
    vv_read_options options;
    vv_read_options_init(&options, sizeof options);
    options.format = vv_file_format(input->file);
    options.part = part;
    options.finest = true;
    cli_input *grown = realloc(out->input, (out->n + 1) * sizeof *grown);
    if (!grown)
        return vv_fail_memory((out->n + 1) * sizeof *grown);
    out->input = grown;
    grown[out->n] = (cli_input){.path = strdup(input->path), .frame = -1};
    if (!grown[out->n++].path)
        return vv_fail_memory(strlen(input->path));
    return vv_file_open(&grown[out->n - 1].file, input->path, &options, command->job);
}

static vv_status gather_labels(cli_layers *out)
{
    size_t n, all = 0;
    for (size_t i = 0; i < out->n; i++) {
        vv_file_labels(out->input[i].file, &n);
        all += n;
    }
    out->labels = malloc((all + 1) * sizeof *out->labels);
    if (!out->labels)
        return vv_fail_memory(all * sizeof *out->labels);
    for (size_t i = 0; i < out->n; i++) {
        const vv_label *labels = vv_file_labels(out->input[i].file, &n);
        for (size_t l = 0; l < n; l++) {
            out->labels[out->n_labels] = labels[l];
            out->labels[out->n_labels++].layer = (int)i;
        }
    }
    return VV_OK;
}

vv_status cli_layers_open(cli_layers *out, cli_command *command, const cli_input *input)
{
    const char *chosen = chosen_part(input->file);
    vv_status st = VV_OK;
    vv_part part;
    *out = (cli_layers){0};
    if (!chosen || (input->part && layer_mark(input->part) > 0) || strcmp(input->path, "-") == 0)
        return VV_OK;
    const size_t n = layer_mark(chosen);
    for (size_t i = 0; st == VV_OK && vv_file_part(input->file, i, &part); i++)
        if (layer_mark(part.name) == n && strncmp(part.name, chosen, n) == 0)
            st = open_layer(out, command, input, part.name);
    if (st == VV_OK)
        st = gather_labels(out);
    if (st == VV_OK)
        cli_command_note(command, "%s: all %zu layers go into %s", input->path, out->n, command->common->output);
    else
        cli_layers_close(out);
    return st;
}

void cli_layers_close(cli_layers *layers)
{
    for (size_t i = 0; i < layers->n; i++)
        cli_input_close(&layers->input[i]);
    free(layers->input);
    free(layers->labels);
    *layers = (cli_layers){0};
}
