#include "run/layers.h"
#include "core/memory.h"
#include "core/status.h"
#include <stdlib.h>
#include <string.h>

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

static vv_status open_layer(vvi_layers *out, const vv_run_input *input, const char *part, vv_job *job)
{
    vv_read_options options;
    vv_read_options_init(&options, sizeof options);
    options.format = vv_file_format(input->file);
    options.part = part;
    options.finest = true;
    vv_file **grown = realloc(out->file, (out->n + 1) * sizeof(vv_file *));
    if (!grown)
        return vv_fail_memory((out->n + 1) * sizeof(vv_file *));
    out->file = grown;
    const vv_status st = vv_file_open(&grown[out->n], input->path, &options, job);
    out->n += st == VV_OK;
    return st;
}

static vv_status gather_labels(vvi_layers *out)
{
    size_t n, all = 0;
    for (size_t i = 0; i < out->n; i++) {
        vv_file_labels(out->file[i], &n);
        all += n;
    }
    out->labels = vvi_calloc(all + 1, sizeof *out->labels);
    if (!out->labels)
        return vv_fail_memory((all + 1) * sizeof *out->labels);
    for (size_t i = 0; i < out->n; i++) {
        const vv_label *labels = vv_file_labels(out->file[i], &n);
        for (size_t l = 0; l < n; l++) {
            out->labels[out->n_labels] = labels[l];
            out->labels[out->n_labels++].layer = (int)i;
        }
    }
    return VV_OK;
}

vv_status vvi_layers_open(vvi_layers *out, const vv_run_input *input, vv_job *job)
{
    *out = (vvi_layers){0};
    if (!input->file || input->field || !input->path || strcmp(input->path, "-") == 0 ||
        (input->part && layer_mark(input->part) > 0))
        return VV_OK;
    const char *chosen = chosen_part(input->file);
    const size_t n = chosen ? layer_mark(chosen) : 0;
    vv_status st = VV_OK;
    vv_part part;
    for (size_t i = 0; chosen && st == VV_OK && vv_file_part(input->file, i, &part); i++)
        if (layer_mark(part.name) == n && strncmp(part.name, chosen, n) == 0)
            st = open_layer(out, input, part.name, job);
    if (st == VV_OK)
        st = gather_labels(out);
    if (st != VV_OK)
        vvi_layers_close(out);
    return st;
}

void vvi_layers_close(vvi_layers *layers)
{
    for (size_t i = 0; i < layers->n; i++)
        vv_file_close(layers->file[i]);
    free(layers->file);
    free(layers->labels);
    *layers = (vvi_layers){0};
}
