#include "mesh_estimate.h"
#include "core/job.h"
#include "core/text.h"
#include "core/units.h"
#include "grid/field.h"
#include "run/sense_labels.h"
#include "surface/isosurface.h"
#include <math.h>
#include <string.h>

enum { LAYERS_MOST = 32 };

static int64_t frame_of(const cli_input *input)
{
    return input->frame < 0 ? 0 : input->frame;
}

/* Where nothing is known without reading everything. */
static vv_status find_reason(const char **out, cli_command *command, const cli_input *input, vv_object **params)
{
    bool sensed = false;
    const char *word = cli_command_word(command, 0);
    if (strcmp(word, "-") == 0)
        *out = "the samples come by a pipe";
    else if (cli_input_contents(command, word) != CLI_INPUT_DATA)
        *out = "a scene decides what is seen";
    else if (vv_object_is_set(*params, "label") || vv_file_info(input->file)->meaning == VV_MEANING_LABEL)
        *out = "borders of labels are found by reading all";
    if (*out)
        return VV_OK;
    const vv_status st = vvi_sense_labels_of_file(&sensed, params, input->file, frame_of(input), command->job);
    if (sensed)
        *out = "it looks like labels, a surface of each but 0, whose borders are found by reading all";
    return st;
}

/* The lower slice of layer number `index`, in the middle of its share of all layers. */
static int64_t slice_below(const cli_mesh_estimate *e, size_t index)
{
    return (int64_t)((2 * index + 1) * e->n_layers / (2 * e->n_examined));
}

static void copy_slices(char *to, const vv_brick *brick)
{
    const size_t bytes = vv_type_bytes(brick->type) * (size_t)brick->components;
    for (int64_t k = 0; k < brick->box.n[2]; k++)
        for (int64_t j = 0; j < brick->box.n[1]; j++) {
            const char *row = (const char *)brick->data + j * brick->stride[1] + k * brick->stride[2];
            for (int64_t i = 0; i < brick->box.n[0]; i++, to += bytes)
                memcpy(to, row + i * brick->stride[0], bytes);
        }
}

/* Two slices of the file are slices 2 `index` and the one after it of *all, which the first of them make. */
static vv_status add_layer(vv_field **all, char **samples, const vv_field *layer, size_t index, size_t n, vv_job *job)
{
    vv_field_info info = *vv_field_get_info(layer);
    const vv_box box = vv_field_box(layer);
    const size_t bytes = vv_type_bytes(info.type) * (size_t)(info.components * info.grid.dims[0] * info.grid.dims[1]);
    vv_brick brick;
    void *room;
    vv_status st = VV_OK;
    if (!*all) {
        info.grid.dims[2] = 2 * (int64_t)n;
        st = vv_field_new_empty(all, &room, &info, job);
        *samples = st == VV_OK ? room : NULL;
    }
    if (st != VV_OK || (st = vv_field_brick(&brick, layer, &box, job)) != VV_OK)
        return st;
    copy_slices(*samples + 2 * index * bytes, &brick);
    vv_brick_release(&brick);
    return VV_OK;
}

static vv_status read_layers(vv_field **out, const cli_mesh_estimate *e, const cli_input *input, vv_job *job)
{
    const int64_t *dims = vv_file_info(input->file)->grid.dims;
    char *samples = NULL;
    vv_status st = VV_OK;
    for (size_t i = 0; i < e->n_examined && st == VV_OK; i++) {
        const vv_box box = {{0, 0, slice_below(e, i)}, {dims[0], dims[1], 2}};
        vv_field *layer = NULL;
        st = vv_file_read(&layer, input->file, frame_of(input), &box, job);
        if (st == VV_OK)
            st = add_layer(out, &samples, layer, i, e->n_examined, job);
        vv_field_release(layer);
    }
    return st;
}

static double two_digits(double n)
{
    const double unit = n >= 100 ? pow(10, floor(log10(n)) - 1) : 1;
    return unit * round(n / unit);
}

/* Each layer stands for its share of all. */
static vv_status count(cli_mesh_estimate *e, const vvi_surface_row *surface, const vv_field *layers,
                       const vv_object *params, vv_job *job)
{
    size_t total = 0;
    vv_status st = VV_OK;
    for (size_t i = 0; i < e->n_examined && st == VV_OK; i++) {
        vv_field *layer = NULL;
        size_t n = 0;
        if ((st = vvi_field_slices(&layer, layers, 2 * (int64_t)i, 2, job)) == VV_OK)
            st = surface->count(&n, params, layer);
        vv_field_release(layer);
        total += n;
        if (st == VV_OK)
            st = vvi_job_poll(job);
    }
    e->triangles = two_digits((double)total * (double)e->n_layers / (double)e->n_examined);
    return st;
}

/* A vertex for two triangles; what finds them has about 24 bytes for each row of samples and value. */
static uint64_t mesh_bytes(const cli_mesh_estimate *e, const cli_command *command, const vvi_surface_row *surface,
                           const vv_object *params, const vv_grid *grid)
{
    size_t n_values;
    const double place = 3 * sizeof(float), normal = 3 * sizeof(float);
    const double value = command->args.n_words > 1 ? sizeof(float) : 0;
    surface->values(params, &n_values);
    return (uint64_t)(e->triangles * (3 * sizeof(uint32_t) + (place + normal + value) / 2) +
                      24.0 * (double)n_values * (double)grid->dims[1] * (double)grid->dims[2]);
}

vv_status cli_mesh_estimate_make(cli_mesh_estimate *out, cli_command *command, const cli_input *input,
                                 vv_object **params_in)
{
    const vvi_surface_row *surface = command->verb.operation->surface;
    const vv_grid *grid = &vv_file_info(input->file)->grid;
    vv_field *layers = NULL;
    *out = (cli_mesh_estimate){0};
    vv_status st = find_reason(&out->unknown, command, input, params_in);
    vv_object *params = *params_in;
    if (st != VV_OK || out->unknown || grid->dims[0] < 2 || grid->dims[1] < 2 || grid->dims[2] < 2)
        return st;
    out->n_layers = (size_t)grid->dims[2] - 1;
    out->n_examined = out->n_layers < LAYERS_MOST ? out->n_layers : LAYERS_MOST;
    st = read_layers(&layers, out, input, command->job);
    if (st == VV_OK)
        st = surface->settle_value(params, &out->found, layers, command->job);
    if (st == VV_OK)
        st = count(out, surface, layers, params, command->job);
    out->bytes = st == VV_OK ? mesh_bytes(out, command, surface, params, grid) : 0;
    vv_field_release(layers);
    return st;
}

/* Parameters that leave out pieces, or add faces: the estimate knows nothing of them. */
static const char *remark(const vv_object *params)
{
    const bool fewer =
        vv_object_is_set(params, "seed") || vv_object_is_set(params, "pieces") || vv_object_is_set(params, "least");
    return fewer ? ", less what is left out of it" : vv_object_is_set(params, "cap") ? ", and those of its caps" : "";
}

static void tell(cli_command *command, const cli_mesh_estimate *e, const vv_object *params, const char *unit)
{
    const vvi_surface_row *surface = command->verb.operation->surface;
    const char *output = command->common->output;
    vvi_text values = {0};
    size_t n = 0;
    const double *value = surface->values(params, &n);
    for (size_t i = 0; i < n; i++)
        vvi_text_printf(&values, "%s%s%g", i ? ", " : "", i || !e->found ? "" : "about ", value[i]);
    cli_command_line(command, "makes",
                     "%s: a mesh of about %.0f triangles%s: surface at %s%s%s; an estimate from %zu of %zu layers of "
                     "cells",
                     output, e->triangles, remark(params), values.s ? values.s : "no value", *unit ? " " : "", unit,
                     e->n_examined, e->n_layers);
    vvi_result_numbers(&command->json, "values", value, n);
    vvi_result_bool(&command->json, "value_found", e->found);
    vvi_result_number(&command->json, "triangles_estimate", e->triangles);
    vvi_result_unsigned(&command->json, "layers", e->n_layers);
    vvi_result_unsigned(&command->json, "layers_examined", e->n_examined);
    vvi_text_free(&values);
}

void cli_mesh_estimate_report(cli_command *command, const cli_mesh_estimate *e, const vv_object *params,
                              const char *value_unit, uint64_t samples_bytes)
{
    char needed[32];
    vvi_print_bytes(needed, samples_bytes + e->bytes);
    if (e->unknown) {
        cli_command_line(command, "makes", "%s: a mesh; its triangles are not estimated: %s", command->common->output,
                         e->unknown);
        cli_command_line(command, "needs", "%s for samples, and more for triangles", needed);
    } else {
        tell(command, e, params, value_unit);
        cli_command_line(command, "needs", "about %s for samples and triangles", needed);
    }
    vvi_result_unsigned(&command->json, "memory_bytes", samples_bytes + e->bytes);
}
