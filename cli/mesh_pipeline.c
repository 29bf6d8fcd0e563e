#include "mesh_pipeline.h"
#include "channel_names.h"
#include "findings.h"
#include "grid/label_id.h"
#include "label_layers.h"
#include "mesh.h"
#include "mesh_estimate.h"
#include "mesh_scene.h"
#include "output.h"
#include "pipeline.h"
#include "refusal.h"
#include "value.h"
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
    vv_mesh **meshes;         /* n, of operations on meshes */
    vv_run_input *run_inputs; /* n */
    vv_mesh_write_options options;
    vv_run *run;
    cli_mesh_scene scene;
    double load_s; /* of meshes and scenes, which are read here */
} pipeline;

static vv_status reserve(pipeline *p)
{
    p->inputs = calloc(p->n, sizeof *p->inputs);
    p->fields = calloc(p->n, sizeof(vv_field *));
    p->meshes = calloc(p->n, sizeof(vv_mesh *));
    p->run_inputs = calloc(p->n, sizeof *p->run_inputs);
    return p->inputs && p->fields && p->meshes && p->run_inputs ? VV_OK : vv_fail_memory(p->n * sizeof *p->inputs);
}

static void clear(pipeline *p)
{
    vv_run_release(p->run);
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
    free(p->run_inputs);
    vv_object_release(p->params);
    cli_mesh_scene_close(&p->scene);
}

/* channels: whose names they have; NULL: none. */
static vv_status make_params(pipeline *p, const vv_field_info *info, const cli_input *channels,
                             const cli_label_names *labels)
{
    return cli_operation_params(&p->params, p->command, &p->command->args, p->operation->params, info, channels,
                                labels);
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
    const vv_status made = make_params(p, info, NULL, &names);
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
    }
    if (st != VV_OK || of_scene)
        return st;
    cli_mesh_scene_of_file(&p->scene, &p->inputs[0]);
    const cli_label_names labels = cli_label_names_of(p->command, &p->inputs[0]);
    return make_params(p, vv_file_info(p->inputs[0].file), &p->inputs[0], &labels);
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
    return make_params(p, &info, NULL, &(cli_label_names){0});
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

/* Cuts of a scene are closed, those of labels too. */
static vv_status check_idle(const pipeline *p, const vv_field *field)
{
    const vvi_surface_row *surface = p->operation->surface;
    const bool labels = surface && surface->of_labels(p->params, field);
    return cli_refuse_idle(p->command, p->params, p->scene.more.n_planes ? NULL : labels ? "labels" : "values");
}

/* Once samples have decided what the parameters leave open. */
static vv_status check_settled(void *user, const vv_step *step, const vv_data *input)
{
    const pipeline *p = user;
    const vv_status st = check_layers(p);
    return st == VV_OK && input->field ? check_idle(p, input->field) : st;
}

static vv_status plan(pipeline *p)
{
    const vv_run_output output = {
        .path = p->output, .mesh_options = &p->options, .check = check_settled, .check_user = p};
    vv_status st = VV_OK;
    cli_output_mesh_options(&p->options, p->command);
    if (p->operation->surface && (st = cli_mesh_scene_apply(&p->scene, p->operation->surface, &p->params)) != VV_OK)
        return st;
    for (size_t i = 0; i < p->n; i++) {
        const cli_input *in = &p->inputs[i];
        p->run_inputs[i] = (vv_run_input){.file = in->file,
                                          .frame = in->file ? in->frame : 0,
                                          .field = p->fields[i],
                                          .mesh = p->meshes[i],
                                          .name = cli_command_word(p->command, i)};
    }
    p->run_inputs[0].look = p->scene.scene ? p->scene.look : NULL;
    p->run_inputs[0].look_user = p->scene.look_user;
    const vv_step step = {p->operation, p->params};
    return vv_run_new(&p->run, p->run_inputs, p->n, &step, 1, &output, p->operation->name, p->command->job);
}

/* So many times again; *run_s becomes the median of those. */
static vv_status repeat(pipeline *p, double *run_s, size_t n)
{
    vv_status st = VV_OK;
    double *seconds = calloc(n, sizeof *seconds);
    if (!seconds)
        return vv_fail_memory(n * sizeof *seconds);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        vv_run_release(p->run);
        p->run = NULL;
        if ((st = plan(p)) == VV_OK && (st = vv_run_make(p->run)) == VV_OK)
            seconds[i] = vv_run_get_about(p->run)->run_s;
    }
    *run_s = cli_value_median(seconds, n);
    free(seconds);
    return st;
}

static void report(pipeline *p, double run_s)
{
    cli_command *command = p->command;
    vvi_result *json = &command->json;
    const vv_run_about *about = vv_run_get_about(p->run);
    const vv_mesh_info *info = vv_mesh_get_info(vv_run_mesh(p->run));
    const double load_s = p->load_s + about->load_s;
    vvi_result_string(json, "output", p->output);
    vvi_text_add_clean(&command->text, p->output);
    vvi_text_add(&command->text, ":");
    cli_findings_report(command);
    vvi_result_unsigned(json, "vertices", info->n_vertices);
    vvi_result_unsigned(json, "triangles", info->n_triangles);
    vvi_result_unsigned(json, "parts", info->parts ? info->n_parts : 1);
    vvi_result_string(json, "unit", info->unit);
    vvi_result_number(json, "load_s", load_s);
    vvi_result_number(json, "run_s", run_s);
    vvi_result_number(json, "write_s", about->write_s);
    vvi_result_unsigned(json, "peak_bytes", vv_runtime_memory_peak(command->runtime));
    vvi_result_integer(json, "threads", vv_runtime_threads(command->runtime));
    cli_findings_warnings(command);
    vvi_text_printf(&command->text, " %zu vertices, %zu triangles; read %.2f s, %s %.2f s, written %.2f s\n",
                    info->n_vertices, info->n_triangles, load_s, command->verb.name, run_s, about->write_s);
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
            vvi_samples_print(about, vv_file_info(file), vv_file_info(file)->n_frames);
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
    const bool of_fields = p->operation->inputs[0].is == VV_IS_FIELD;
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
    const bool of_fields = p->operation->inputs[0].is == VV_IS_FIELD;
    const cli_timing *timing = cli_command_options(p->command, &cli_timing_class);
    const double start_s = cli_now_s();
    if ((st = check_inputs(p)) != VV_OK || (st = reserve(p)) != VV_OK || (of_fields && (st = open_fields(p)) != VV_OK))
        return st;
    if (p->command->common->dry_run)
        return dry_run(p);
    if (!of_fields && (st = read_meshes(p)) != VV_OK)
        return st;
    p->load_s = cli_now_s() - start_s;
    if ((st = plan(p)) != VV_OK || (st = vv_run_make(p->run)) != VV_OK)
        return st;
    double run_s = vv_run_get_about(p->run)->run_s;
    if (timing->repeat > 0 && (st = repeat(p, &run_s, (size_t)timing->repeat)) != VV_OK)
        return st;
    if ((st = vv_run_write(p->run)) == VV_OK)
        report(p, run_s);
    return st;
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
