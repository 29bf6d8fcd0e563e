#include "mesh_pipeline.h"
#include "channel_names.h"
#include "filter/simplify.h"
#include "grid/label_id.h"
#include "label_layers.h"
#include "label_names.h"
#include "mesh.h"
#include "mesh_estimate.h"
#include "mesh_scene.h"
#include "output.h"
#include "pipeline.h"
#include "refusal.h"
#include "run/sense_labels.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct pipeline {
    cli_command *command;
    const vv_operation *operation;
    const char *output;
    vv_object *params;
    size_t n;
    cli_input *inputs; /* n, of operations on fields */
    vv_field **fields;
    vv_mesh **meshes; /* n, of operations on meshes */
    vv_mesh *result;
    cli_mesh_scene scene;
    vvi_simplify_told simplified;
    bool found; /* the value of the surface, from the samples */
    double load_s, run_s, write_s;
} pipeline;

static vv_status reserve(pipeline *p)
{
    p->inputs = calloc(p->n, sizeof *p->inputs);
    p->fields = calloc(p->n, sizeof(vv_field *));
    p->meshes = calloc(p->n, sizeof(vv_mesh *));
    return p->inputs && p->fields && p->meshes ? VV_OK : vv_fail_memory(p->n * sizeof *p->inputs);
}

static void clear(pipeline *p)
{
    for (size_t i = 0; i < p->n; i++) {
        if (p->fields)
            vv_field_release(p->fields[i]);
        if (p->meshes)
            vv_mesh_release(p->meshes[i]);
        if (p->inputs)
            cli_input_close(&p->inputs[i]);
    }
    free(p->inputs);
    free(p->fields);
    free(p->meshes);
    vv_mesh_release(p->result);
    vv_object_release(p->params);
    cli_mesh_scene_close(&p->scene);
}

/* names: of labels, in options of the operation. */
static vv_status make_params(pipeline *p, const vv_field_info *info, const cli_label_names *names)
{
    const vv_property_context context = cli_input_context(info, p->command->registry);
    return cli_label_params(&p->params, &p->command->args, p->operation->params, &context, names);
}

/* A scene says more than where the samples are. */
static bool is_of_scene(const pipeline *p)
{
    return p->operation->surface && !p->command->common->dry_run &&
           cli_input_contents(p->command, cli_command_word(p->command, 0)) != CLI_INPUT_DATA;
}

static vv_status open_scene(pipeline *p)
{
    const vv_status st = cli_mesh_scene_open(&p->scene, &p->fields[0], p->command, cli_command_word(p->command, 0));
    if (st != VV_OK)
        return st;
    const vv_field_info *info = vv_field_get_info(p->fields[0]);
    size_t n = 0;
    vv_label *labels = NULL;
    const vv_status listed = cli_mesh_scene_labels(&labels, &n, &p->scene);
    if (listed != VV_OK)
        return listed;
    const cli_label_names names = {.label = labels, .n = n, .is_unsigned = vvi_label_is_unsigned(info->type)};
    const vv_status made = make_params(p, info, &names);
    free(labels);
    return made;
}

static vv_status open_fields(pipeline *p)
{
    const bool of_scene = is_of_scene(p);
    vv_status st = of_scene ? open_scene(p) : VV_OK;
    for (size_t i = of_scene ? 1 : 0; i < p->n && st == VV_OK; i++) {
        cli_input *in = &p->inputs[i];
        if ((st = cli_input_open(in, p->command, cli_command_word(p->command, i))) != VV_OK)
            break;
        const long long steps = vv_file_info(in->file)->n_frames;
        if (in->frame < 0 && steps > 1)
            cli_command_note(p->command, "%s: the first of %lld time steps; choose another with FILE@N", in->path,
                             steps);
    }
    if (st != VV_OK || of_scene)
        return st;
    cli_mesh_scene_of_file(&p->scene, &p->inputs[0]);
    return cli_channel_params(&p->params, p->command, &p->inputs[0], p->operation->params);
}

static vv_status read_fields(pipeline *p)
{
    vv_status st = VV_OK;
    for (size_t i = p->fields[0] ? 1 : 0; i < p->n && st == VV_OK; i++) {
        const cli_input *in = &p->inputs[i];
        st = vv_file_read(&p->fields[i], in->file, in->frame < 0 ? 0 : in->frame, NULL, p->command->job);
    }
    return st;
}

static vv_status read_meshes(pipeline *p)
{
    vv_field_info info = vv_field_info_default(); /* lengths of parameters are in the mesh's unit */
    vv_status st = VV_OK;
    for (size_t i = 0; i < p->n && st == VV_OK; i++)
        st = cli_mesh_read(&p->meshes[i], p->command, cli_command_word(p->command, i), NULL);
    if (st != VV_OK)
        return st;
    memcpy(info.grid.unit, vv_mesh_get_info(p->meshes[0])->unit, sizeof info.grid.unit);
    return make_params(p, &info, &(cli_label_names){0});
}

static vv_status sense_labels(pipeline *p)
{
    bool sensed;
    const vv_status st = vvi_sense_labels(&sensed, &p->params, p->fields[0], p->command->job);
    if (sensed)
        cli_command_note(p->command,
                         "%s: looks like labels: a surface of each but 0; --label 1,2 chooses, --iso VALUE makes "
                         "one of a value",
                         cli_command_word(p->command, 0));
    return st;
}

/* Cuts of a scene are closed, those of labels too. */
static vv_status check_idle(const pipeline *p)
{
    const bool labels =
        vv_object_is_set(p->params, "label") || vv_field_get_info(p->fields[0])->meaning == VV_MEANING_LABEL;
    return cli_refuse_idle(p->command, p->params, p->scene.more.n_planes ? NULL : labels ? "labels" : "values");
}

static vv_status check_layers(const pipeline *p)
{
    const vv_property *row = vv_class_find(p->params->cls, "label");
    vv_status st = VV_OK;
    if (!row || row->kind != VV_KIND_NUMBERS || !vv_object_is_set(p->params, "label"))
        return VV_OK;
    const vv_numbers *labels = *(vv_numbers *const *)(const void *)((const char *)p->params + row->offset);
    for (size_t i = 0; labels && labels->labels && i < labels->n && st == VV_OK; i++)
        st = cli_label_layer_check(p->command, &p->inputs[0], labels->labels[i]);
    return st;
}

/* What the samples decide is decided before the work: so it can be told. */
static vv_status settle(pipeline *p)
{
    p->simplified = (vvi_simplify_told){.distance.value = NAN};
    if (p->operation->tell_change)
        p->operation->tell_change(p->params, &p->simplified);
    if (p->operation->take_looks && p->scene.look)
        p->operation->take_looks(p->params, p->scene.look, p->scene.look_user);
    if (!p->operation->surface)
        return VV_OK;
    vv_status st = cli_mesh_scene_apply(&p->scene, p->operation->surface, &p->params);
    if (st == VV_OK)
        st = check_layers(p);
    if (st == VV_OK)
        st = sense_labels(p);
    if (st == VV_OK)
        st = check_idle(p);
    return st == VV_OK ? p->operation->surface->settle(p->params, &p->found, p->fields[0], p->command->job) : st;
}

/* What is made a surface of by a value, and may be meant otherwise. */
static vv_status hint(pipeline *p)
{
    size_t n;
    if (!p->operation->surface)
        return VV_OK;
    const vv_field_info *info = vv_field_get_info(p->fields[0]);
    const vv_status st = p->operation->surface->like_labels(&n, p->params, p->fields[0], p->command->job);
    if (st == VV_OK && n > 0)
        cli_command_note(p->command,
                         "%s: has only %zu different values; if they are labels, --label 1,2 makes a surface of each",
                         cli_command_word(p->command, 0), n);
    if (st == VV_OK && info->components > 1 && !vv_object_is_set(p->params, "component"))
        cli_command_note(p->command, "%s: has %d channels; the surface is that of channel 0, --channel chooses",
                         cli_command_word(p->command, 0), info->components);
    return st;
}

static vv_status run_operation(pipeline *p)
{
    vv_job *job = p->command->job;
    if (p->operation->mesh_of_fields)
        return vv_operation_mesh_of_fields(&p->result, p->operation, (const vv_field *const *)p->fields, p->n,
                                           p->params, job);
    return vv_operation_mesh_of_meshes(&p->result, p->operation, (const vv_mesh *const *)p->meshes, p->n, p->params,
                                       job);
}

static int shorter(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The same again, so many times; run_s becomes the median. */
static vv_status repeat(pipeline *p, size_t n)
{
    vv_status st = VV_OK;
    double *seconds = calloc(n, sizeof *seconds);
    if (!seconds)
        return vv_fail_memory(n * sizeof *seconds);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        vv_mesh_release(p->result);
        p->result = NULL;
        const double start_s = cli_now_s();
        st = run_operation(p);
        seconds[i] = cli_now_s() - start_s;
    }
    qsort(seconds, n, sizeof *seconds, shorter);
    p->run_s = seconds[n / 2];
    free(seconds);
    return st;
}

static vv_status write_result(pipeline *p)
{
    vv_mesh_write_options options;
    cli_output_mesh_options(&options, p->command);
    return vv_mesh_write(p->output, p->result, &options, p->command->job);
}

/* " surface at 67.5 HU, which best splits the histogram in two" */
static void tell_values(pipeline *p, const double *values, size_t n)
{
    const char *unit = vv_field_get_info(p->fields[0])->value_unit;
    const char *why = p->scene.chosen ? p->scene.chosen : p->found ? ", which best splits the histogram in two" : "";
    vvi_text *text = &p->command->text;
    for (size_t i = 0; i < n; i++)
        vvi_text_printf(text, "%s%g", i ? ", " : " surface at ", values[i]);
    if (p->scene.more.top)
        vvi_text_printf(text, " to %g", *p->scene.more.top);
    vvi_text_printf(text, "%s%s%s", *unit ? " " : "", unit, why);
    vvi_result_numbers(&p->command->json, "values", values, n);
    vvi_result_string(&p->command->json, "value_unit", unit);
    vvi_result_bool(&p->command->json, "value_found", p->found);
}

/* Which surface it is, before how many triangles it has. */
static void tell_surface(pipeline *p)
{
    size_t n = 0;
    const size_t n_planes = p->scene.more.n_planes;
    const double *values = p->operation->surface->values(p->params, &n);
    vvi_text *text = &p->command->text;
    if (values)
        tell_values(p, values, n);
    if (n_planes > 0)
        vvi_text_printf(text, "%s cut by %zu plane%s", values ? "," : "", n_planes, n_planes > 1 ? "s" : "");
    if (values || n_planes > 0)
        vvi_text_add(text, ";");
    vvi_result_unsigned(&p->command->json, "cut_planes", n_planes);
}

/* How far the surface is from what it was, and what has vanished. */
static void tell_simplified(pipeline *p)
{
    const vvi_simplify_result *r = &p->simplified.result;
    const vv_figure distance = p->simplified.distance;
    const char *unit = vv_mesh_get_info(p->result)->unit;
    vvi_text *text = &p->command->text;
    vvi_result *json = &p->command->json;
    if (!isnan(distance.value)) /* of an empty mesh nothing is near */
        vvi_text_printf(text, " at most %.4g %s from what it was", distance.value + distance.error, unit);
    if (r->n_dropped || r->n_pieces_left != r->n_pieces)
        vvi_text_printf(text, "%s %zu piece%s became %zu, %zu vanished", isnan(distance.value) ? "" : ",", r->n_pieces,
                        r->n_pieces == 1 ? "" : "s", r->n_pieces_left, r->n_dropped);
    vvi_text_add(text, ";");
    vvi_result_number(json, "error_estimate", r->error);
    vvi_result_number(json, "distance", distance.value);
    vvi_result_number(json, "distance_error", isnan(distance.value) ? NAN : distance.error);
    vvi_result_unsigned(json, "pieces_before", r->n_pieces);
    vvi_result_unsigned(json, "pieces_after", r->n_pieces_left);
    vvi_result_unsigned(json, "pieces_dropped", r->n_dropped);
}

/* What is empty is most often a mistake: why it is. */
static vv_status tell_empty(pipeline *p)
{
    char why[160] = "";
    vv_status st = VV_OK;
    const bool empty = vv_mesh_get_info(p->result)->n_triangles == 0;
    if (empty && p->operation->surface)
        st = p->operation->surface->why_empty(why, p->params, p->fields[0], p->command->job);
    vvi_result_open(&p->command->json, "warnings", '[');
    if (empty) {
        const char *reason = *why ? why : "nothing of the input gives a triangle";
        char text[200];
        snprintf(text, sizeof text, "the mesh is empty: %s", reason);
        cli_command_note(p->command, "warning: %s", text);
        vvi_result_string(&p->command->json, NULL, text);
    }
    vvi_result_close(&p->command->json, ']');
    return st;
}

static void report(pipeline *p)
{
    cli_command *command = p->command;
    vvi_result *json = &command->json;
    const vv_mesh_info *info = vv_mesh_get_info(p->result);
    vvi_result_string(json, "output", p->output);
    vvi_text_add_clean(&command->text, p->output);
    vvi_text_add(&command->text, ":");
    if (p->operation->surface)
        tell_surface(p);
    if (p->operation->tell_change)
        tell_simplified(p);
    vvi_result_unsigned(json, "vertices", info->n_vertices);
    vvi_result_unsigned(json, "triangles", info->n_triangles);
    vvi_result_unsigned(json, "parts", info->parts ? info->n_parts : 1);
    vvi_result_string(json, "unit", info->unit);
    vvi_result_number(json, "load_s", p->load_s);
    vvi_result_number(json, p->operation->mesh_of_fields ? "extract_s" : "run_s", p->run_s);
    vvi_result_number(json, "write_s", p->write_s);
    vvi_result_unsigned(json, "peak_bytes", vv_runtime_memory_peak(command->runtime));
    vvi_result_integer(json, "threads", vv_runtime_threads(command->runtime));
    vvi_text_printf(&command->text, " %zu vertices, %zu triangles; read %.2f s, %s %.2f s, written %.2f s\n",
                    info->n_vertices, info->n_triangles, p->load_s, command->verb.name, p->run_s, p->write_s);
}

/* Of volumes: what their samples take, which lie in the file where they are mapped. */
static vv_status tell_inputs(pipeline *p, uint64_t *bytes)
{
    vv_status st = VV_OK;
    *bytes = 0;
    for (size_t i = 0; i < p->n && st == VV_OK; i++) {
        const vv_file *file = p->inputs[i].file;
        uint64_t samples = 0;
        char about[128] = "a mesh";
        if (file) {
            cli_describe_info(about, vv_file_info(file), vv_file_info(file)->n_frames);
            st = vv_field_info_bytes(&samples, vv_file_info(file));
        }
        cli_command_line(p->command, "reads", "%s: %s", cli_command_word(p->command, i), about);
        *bytes += file && !vv_file_mappable(file) ? samples : 0;
    }
    return st;
}

static vv_status dry_run(pipeline *p)
{
    cli_mesh_estimate estimate;
    uint64_t bytes;
    vv_status st = tell_inputs(p, &bytes);
    vvi_result_string(&p->command->json, "output", p->output);
    vvi_result_bool(&p->command->json, "dry_run", true);
    if (!p->operation->surface) {
        cli_command_line(p->command, "makes", "%s: a mesh", p->output);
        return st;
    }
    vv_object *params = p->params;
    if (st == VV_OK && (st = cli_mesh_estimate_make(&estimate, p->command, &p->inputs[0], &params)) == VV_OK)
        cli_mesh_estimate_report(p->command, &estimate, params, vv_file_info(p->inputs[0].file)->value_unit, bytes);
    p->params = params;
    return st;
}

/* The other kind of input is not read, and which verb takes it is said. */
static vv_status check_inputs(const pipeline *p)
{
    const bool of_fields = p->operation->mesh_of_fields != NULL;
    for (size_t i = 0; i < p->n; i++) {
        const char *word = cli_command_word(p->command, i), *name = strcmp(word, "-") == 0 ? "standard input" : word;
        if (of_fields && cli_mesh_is_input(p->command, word))
            return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                              "is a mesh already, and %s makes one of a volume; 'volvis simplify' and 'volvis smooth' "
                              "change a mesh, 'volvis convert' writes it in another format",
                              p->operation->name);
        if (!of_fields && cli_mesh_is_volume(p->command, word))
            return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                              "is a volume, and %s takes a mesh; make one of it first: volvis isosurface %s -o "
                              "surface.ply",
                              p->operation->name, word);
    }
    return VV_OK;
}

static vv_status run(pipeline *p)
{
    vv_status st;
    const bool of_fields = p->operation->mesh_of_fields != NULL;
    if ((st = check_inputs(p)) != VV_OK || (st = reserve(p)) != VV_OK || (of_fields && (st = open_fields(p)) != VV_OK))
        return st;
    if (p->command->common->dry_run)
        return dry_run(p);
    const double start_s = cli_now_s();
    if ((st = of_fields ? read_fields(p) : read_meshes(p)) != VV_OK)
        return st;
    const double read_s = cli_now_s();
    if ((st = settle(p)) != VV_OK || (st = run_operation(p)) != VV_OK || (st = hint(p)) != VV_OK)
        return st;
    p->load_s = read_s - start_s;
    p->run_s = cli_now_s() - read_s;
    const cli_timing *timing = cli_command_options(p->command, &cli_timing_class);
    if (timing->repeat > 0 && (st = repeat(p, (size_t)timing->repeat)) != VV_OK)
        return st;
    const double ran_s = cli_now_s();
    if ((st = write_result(p)) != VV_OK)
        return st;
    p->write_s = cli_now_s() - ran_s;
    report(p);
    return tell_empty(p);
}

vv_status cli_mesh_pipeline_run(cli_command *command)
{
    pipeline p = {.command = command, .operation = command->verb.operation, .n = command->args.n_words};
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    vv_status st;
    if ((st = cli_output_need(&p.output, command, "the mesh")) != VV_OK ||
        (st = cli_output_check(command, p.output, CLI_OUTPUT_MESH, writing->output_format)) != VV_OK ||
        (st = cli_command_start(command)) != VV_OK)
        return st;
    st = run(&p);
    if (st == VV_E_ARGUMENT)
        cli_refused_class(command, p.operation->params, st);
    clear(&p);
    return st;
}
