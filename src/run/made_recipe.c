/* What a dataset that is made takes: its row, its inputs, its parameters; and whether that is sound. */
#include "core/cache.h"
#include "core/job.h"
#include "core/limits.h"
#include "core/property_impl.h"
#include "model/contents.h"
#include "model/context.h"
#include "run/made.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATH_ROOM = VVI_ID_MOST + 96, NAMES_MOST = 128 };

/* "datasets.smooth.inputs.volume"; name NULL: without it. */
static const char *place(char out[PATH_ROOM], const vvi_made *made, const char *property, const char *name)
{
    snprintf(out, PATH_ROOM, "datasets.%s.%s%s%.63s", made->id, property, name ? "." : "", name ? name : "");
    return out;
}

/* The operation --------------------------------------------------------------------------------------------------- */

static const vv_operation *row_named(const vv_registry *registry, const char *name)
{
    for (const vv_operation *const *row = registry->operations; row && *row; row++)
        if (!strcmp((*row)->name, name))
            return *row;
    return NULL;
}

static vv_status find_operation(vvi_made *made, vv_job *job)
{
    const char *names[NAMES_MOST], *name = made->dataset->operation;
    const vv_registry *registry = vvi_job_registry(job);
    char where[PATH_ROOM];
    size_t n = 0;
    made->operation = row_named(registry, name);
    if (made->operation)
        return VV_OK;
    for (const vv_operation *const *row = registry->operations; row && *row && n < NAMES_MOST; row++)
        names[n++] = (*row)->name;
    return vvi_fail_name(VV_E_NOT_FOUND, NULL, place(where, made, "operation", NULL), name,
                         &(vvi_known){names, n, "volvis operations", NULL}, "there is no operation '%.64s'", name);
}

/* Inputs ---------------------------------------------------------------------------------------------------------- */

static vv_status find_input(vvi_made *made, size_t index, const char *operand, const char *id)
{
    char where[PATH_ROOM];
    const char *names[NAMES_MOST];
    const vv_collection *all = made->world->datasets;
    const size_t at = vvi_collection_index(all, id);
    size_t n = 0;
    if (at < all->n) {
        made->input[index] = vvi_dataset_nth(made->world, at);
        made->input_id[index] = all->entry[at].id;
        return VV_OK;
    }
    for (; n < all->n && n < NAMES_MOST; n++)
        names[n] = all->entry[n].id;
    return vvi_fail_name(VV_E_NOT_FOUND, NULL, place(where, made, "inputs", operand), id,
                         &(vvi_known){names, n, NULL, NULL}, "there is no dataset '%.64s'", id);
}

static vv_status check_text(const vvi_made *made, const char *operand, const json_t *value)
{
    char where[PATH_ROOM], found[64];
    if (json_is_string(value))
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, NULL, place(where, made, "inputs", operand),
                      "expected the name of a dataset, found %s", vvi_found(found, value));
}

/* Of inputs that people name: all of them, in their order; the source alone is called a. */
static vv_status take_named(vvi_made *made, json_t *inputs)
{
    const vv_operand *operand = &made->operation->inputs[0];
    const char *name, *source = made->dataset->source;
    char where[PATH_ROOM];
    json_t *value;
    vvi_text names = {0};
    vv_status st = VV_OK;
    json_object_foreach(inputs, name, value)
    {
        if (st == VV_OK && made->n == operand->most)
            st = vv_fail_at(VV_E_LIMIT, NULL, place(where, made, "inputs", NULL), "%s takes at most %zu inputs",
                            made->operation->name, operand->most);
        if (st == VV_OK && (st = check_text(made, name, value)) == VV_OK)
            st = find_input(made, made->n, name, json_string_value(value));
        vvi_text_printf(&names, "%s%s", made->n ? "," : "", name);
        made->n += st == VV_OK;
    }
    if (st == VV_OK && made->n == 0 && source) {
        st = find_input(made, made->n++, "a", source);
        vvi_text_add(&names, "a");
    }
    if (st == VV_OK && made->n < operand->least)
        st = vv_fail_at(VV_E_ARGUMENT, NULL, place(where, made, "inputs", NULL), "%s needs inputs: %s",
                        made->operation->name, operand->doc);
    made->names = vvi_text_take(&names);
    return st;
}

static vv_status check_names(const vvi_made *made, json_t *inputs)
{
    char where[PATH_ROOM];
    const char *names[VVI_RUN_INPUTS], *name;
    size_t n = 0;
    json_t *value;
    for (const vv_operand *o = made->operation->inputs; o->name && n < VVI_RUN_INPUTS; o++)
        names[n++] = o->name;
    json_object_foreach(inputs, name, value)
    {
        if (vvi_name_find(name, names, n) == n)
            return vvi_fail_name(VV_E_NOT_FOUND, NULL, place(where, made, "inputs", name), name,
                                 &(vvi_known){names, n, NULL, NULL}, "%s has no input '%.64s'", made->operation->name,
                                 name);
    }
    return VV_OK;
}

/* One for each operand. */
static vv_status take_operands(vvi_made *made, json_t *inputs)
{
    const vv_operand *operands = made->operation->inputs;
    char where[PATH_ROOM];
    vv_status st = check_names(made, inputs);
    if (st == VV_OK && !operands[0].name && made->dataset->source)
        return vv_fail_at(VV_E_ARGUMENT, NULL, place(where, made, "source", NULL), "%s takes no inputs",
                          made->operation->name);
    for (size_t i = 0; operands[i].name && i < VVI_RUN_INPUTS && st == VV_OK; i++) {
        const json_t *value = json_object_get(inputs, operands[i].name);
        const char *id = value ? json_string_value(value) : i == 0 ? made->dataset->source : NULL;
        if (value && (st = check_text(made, operands[i].name, value)) != VV_OK)
            return st;
        if (!id && operands[i].least > 0)
            return vv_fail_at(VV_E_ARGUMENT, NULL, place(where, made, "inputs", operands[i].name),
                              "name a dataset: %s needs %s", made->operation->name, operands[i].doc);
        if (!id)
            continue;
        st = find_input(made, i, operands[i].name, id);
        made->n = i + 1;
    }
    return st;
}

vv_status vvi_made_open(vvi_made *out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vv_status st = vvi_made_open_as_is(out, world, dataset, job);
    for (size_t i = 0; i < out->n && st == VV_OK; i++)
        if (out->input[i])
            st = vvi_made_behind(&out->input[i], &out->input_id[i], world, job);
    return st;
}

vv_status vvi_made_open_as_is(vvi_made *out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    *out = (vvi_made){.world = world, .dataset = dataset, .id = vvi_dataset_id(world, dataset)};
    vv_status st = find_operation(out, job);
    if (st != VV_OK)
        return st;
    json_t *inputs = vvi_members_tree(&dataset->base, vv_class_find(&vv_dataset_class, "inputs"));
    if (!inputs)
        return vv_fail_memory(sizeof *out);
    st = out->operation->inputs[0].names ? take_named(out, inputs) : take_operands(out, inputs);
    json_decref(inputs);
    return st;
}

void vvi_made_close(vvi_made *made)
{
    free(made->names);
    made->names = NULL;
}

/* What it stands on ------------------------------------------------------------------------------------------------ */

typedef struct node {
    enum { NEW, OPEN, DONE } state;
    uint64_t content;
    uint64_t steps; /* that it takes with all that it stands on, each as often as it is asked for */
    size_t height;  /* of the longest chain */
} node;

typedef struct graph {
    const vv_world *world;
    node *nodes; /* one for each dataset */
    vv_job *job;
    const char *open[VVI_MADE_DEEPEST + 1]; /* datasets under way, by depth: each is made of the next */
} graph;

static vv_status visit(node *out, graph *g, const vv_dataset *dataset, size_t depth);

static uint64_t hash_text(const char *text, uint64_t seed)
{
    return vvi_hash(text ? text : "", text ? strlen(text) + 1 : 0, seed);
}

vv_status vvi_made_fail_ring(const vvi_made *made, const char *const *id, size_t n)
{
    enum { FIRST = 5, LAST = 3 };
    char where[PATH_ROOM];
    vvi_text ring = {0};
    for (size_t i = 0; i < n; i++)
        if (i < FIRST || i + LAST >= n)
            vvi_text_printf(&ring, "%.64s -> ", id[i]);
        else if (i == FIRST)
            vvi_text_printf(&ring, "(%zu more) -> ", n - FIRST - LAST);
    vvi_text_printf(&ring, "%.64s", made->id);
    char *text = vvi_text_take(&ring);
    const vv_status st = vv_fail_at(VV_E_ARGUMENT, NULL, place(where, made, "inputs", NULL),
                                    "it is made of itself (%s): one of the datasets that it is made of must be a file",
                                    text ? text : "");
    free(text);
    return st;
}

/* What is open comes again: from there on it is a ring. */
static vv_status fail_open(const graph *g, const vvi_made *made, size_t depth)
{
    size_t first = 0;
    while (first + 2 < depth && strcmp(g->open[first], made->id) != 0)
        first++;
    return vvi_made_fail_ring(made, g->open + first, depth - 1 - first);
}

static vv_status fail_deep(const vvi_made *made)
{
    char where[PATH_ROOM];
    return vv_fail_at(
        VV_E_LIMIT, NULL, place(where, made, "operation", NULL),
        "it is made by more than %d operations one after the other: write one of them to a file and go on "
        "from there",
        VVI_MADE_DEEPEST);
}

static vv_status fail_steps(const vvi_made *made)
{
    char where[PATH_ROOM];
    return vv_fail_at(VV_E_LIMIT, NULL, place(where, made, "operation", NULL),
                      "it is made by more than %d operations in all: write one of them to a file and go on from there",
                      VVI_MADE_MOST);
}

static vv_status visit_inputs(node *own, graph *g, const vvi_made *made, size_t depth)
{
    vv_status st = VV_OK;
    own->steps = 1;
    own->height = 1;
    own->content = hash_text(made->dataset->parameters, hash_text(made->dataset->operation, 2));
    own->content = hash_text(made->names, own->content);
    for (size_t i = 0; i < made->n && st == VV_OK; i++) {
        node input = {0};
        if (made->input[i])
            st = visit(&input, g, made->input[i], depth + 1);
        own->content = vvi_hash(&input.content, sizeof input.content, own->content);
        own->steps += input.steps;
        own->height = input.height + 1 > own->height ? input.height + 1 : own->height;
    }
    if (st == VV_OK && own->height > VVI_MADE_DEEPEST)
        return fail_deep(made);
    return st == VV_OK && own->steps > VVI_MADE_MOST ? fail_steps(made) : st;
}

static vv_status visit_made(node *own, graph *g, const vv_dataset *dataset, size_t depth)
{
    vvi_made made;
    vv_status st = vvi_made_open(&made, g->world, dataset, g->job);
    if (st == VV_OK && own->state == OPEN)
        st = fail_open(g, &made, depth);
    if (st == VV_OK && depth > VVI_MADE_DEEPEST)
        st = fail_deep(&made);
    own->state = OPEN;
    if (st == VV_OK)
        g->open[depth - 1] = made.id;
    if (st == VV_OK)
        st = visit_inputs(own, g, &made, depth);
    own->state = DONE;
    vvi_made_close(&made);
    return st;
}

static vv_status visit(node *out, graph *g, const vv_dataset *dataset, size_t depth)
{
    const vv_collection *all = g->world->datasets;
    node alone = {0}, *own = &alone;
    vv_status st = VV_OK;
    for (size_t i = 0; i < all->n; i++)
        own = all->entry[i].object == &dataset->base ? &g->nodes[i] : own;
    if (own->state != DONE && vv_dataset_is_made(dataset))
        st = visit_made(own, g, dataset, depth);
    else if (own->state != DONE)
        *own = (node){.state = DONE, .content = vvi_dataset_content(dataset)};
    *out = *own;
    return st;
}

vv_status vvi_made_content(uint64_t *out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    node found = {0};
    graph g = {world, vvi_calloc(world->datasets->n + 1, sizeof(node)), job, {NULL}};
    if (!g.nodes)
        return vv_fail_memory(world->datasets->n * sizeof(node));
    const char *id = "";
    vv_status st = vvi_made_behind(&dataset, &id, world, job);
    if (st == VV_OK)
        st = visit(&found, &g, dataset, 1);
    free(g.nodes);
    *out = found.content;
    return st;
}

/* Parameters ------------------------------------------------------------------------------------------------------- */

/* What lengths are measured with: the unit and the voxel of the first input. */
static vv_status lengths_of(vv_property_context *out, vv_field_info *info, const vvi_made *made, vv_job *job)
{
    vv_mesh *mesh = NULL;
    vv_status st = VV_OK;
    *out = vvi_registry_context(vvi_job_registry(job));
    *info = vv_field_info_default();
    if (made->n == 0 || !made->input[0])
        return VV_OK;
    if (vv_dataset_is_mesh(made->input[0], job)) {
        if ((st = vv_dataset_mesh(&mesh, made->world, made->input[0], job)) == VV_OK)
            snprintf(info->grid.unit, sizeof info->grid.unit, "%s", vv_mesh_get_info(mesh)->unit);
        vv_mesh_release(mesh);
    } else if ((st = vv_dataset_info(info, made->world, made->input[0], job)) == VV_OK) {
        out->voxel = vv_grid_voxel(&info->grid);
    }
    out->length_unit = info->grid.unit;
    return st;
}

static vv_status fail_param(const vvi_made *made, const char *name)
{
    const char *names[NAMES_MOST];
    char where[PATH_ROOM];
    size_t n = 0;
    for (const vv_property *row = made->operation->params->properties; row->name && n < NAMES_MOST; row++)
        names[n++] = row->name;
    return vvi_fail_name(VV_E_NOT_FOUND, NULL, place(where, made, "parameters", name), name,
                         &(vvi_known){names, n, NULL, NULL}, "%s has no parameter '%.64s'", made->operation->name,
                         name);
}

/* A number where a text is wanted, as "spacing" takes 2 and "1mm". NULL: no memory. */
static json_t *as_text(const json_t *number)
{
    vvi_json text = {0};
    vvi_json_tree(&text, number);
    char *s = vvi_text_take(&text.text);
    json_t *made = s ? json_string(s) : NULL;
    free(s);
    return made;
}

/* What people type after --set stands in texts: "1mm,2mm,3mm". */
static vv_status read_param(vv_object *params, const vvi_made *made, const char *name, const json_t *value,
                            const vvi_reading *reading, const vvi_place *up)
{
    const vvi_place at = {.up = up, .name = name};
    const vv_property *row = vv_class_find(params->cls, name);
    json_t *typed = NULL;
    vv_status st = VV_OK;
    if (!row)
        return fail_param(made, name);
    if (json_is_string(value) && !vvi_kind_is_text(row->kind))
        st = vvi_json_parse_typed(&typed, json_string_value(value), row->kind, &at);
    else if (json_is_number(value) && vvi_kind_is_text(row->kind) && !(typed = as_text(value)))
        st = vv_fail_memory(sizeof *row);
    if (st == VV_OK)
        st = vvi_property_read(params, row, typed ? typed : value, reading, &at);
    json_decref(typed);
    return st;
}

static vv_status read_params(vv_object *params, const vvi_made *made, const vv_property_context *context)
{
    char where[PATH_ROOM];
    const vvi_place up = {.name = place(where, made, "parameters", NULL)};
    const vvi_reading reading = {.context = context};
    const char *name, *names = made->operation->inputs[0].names;
    json_t *value, *tree = vvi_members_tree(&made->dataset->base, vv_class_find(&vv_dataset_class, "parameters"));
    vv_status st = tree ? VV_OK : vv_fail_memory(sizeof *made);
    json_object_foreach(tree, name, value)
    {
        if (st == VV_OK)
            st = read_param(params, made, name, value, &reading, &up);
    }
    const bool said = names && json_object_get(tree, names); /* as --names before files without a name */
    json_decref(tree);
    if (st == VV_OK && names && made->names && !said) {
        json_t *text = json_string(made->names);
        st = text ? read_param(params, made, names, text, &reading, &up) : vv_fail_memory(strlen(made->names));
        json_decref(text);
    }
    return st == VV_OK ? vvi_object_check(params, &up) : st;
}

vv_status vvi_made_params(vv_object **out, const vvi_made *made, vv_job *job)
{
    vv_property_context context;
    vv_field_info info;
    vv_object *params = NULL;
    *out = NULL;
    vv_status st = lengths_of(&context, &info, made, job);
    if (st == VV_OK && (st = vv_object_new(&params, made->operation->params, &context)) == VV_OK)
        st = read_params(params, made, &context);
    if (st == VV_OK)
        *out = params;
    else
        vv_object_release(params);
    return st;
}

bool vvi_made_is_named(const vvi_made *made, const vv_object *params)
{
    const char *names = made->operation->inputs[0].names;
    const vv_property *row = names ? vv_class_find(params->cls, names) : NULL;
    const char *called = row ? *(char *const *)(const void *)((const char *)params + row->offset) : NULL;
    return called && made->names && strcmp(called, made->names) == 0;
}

/* Planning --------------------------------------------------------------------------------------------------------- */

static const char *word_of(unsigned is)
{
    return is == VV_IS_MESH ? "a mesh" : is == VV_IS_FIELD ? "a volume" : "a volume or a mesh";
}

/* Data of the kinds that the row takes. */
static vv_status check_kinds(const vvi_made *made, vv_job *job)
{
    char where[PATH_ROOM];
    for (size_t i = 0; i < made->n; i++) {
        const vv_operand *operand = vv_operation_operand(made->operation, i);
        if (!made->input[i])
            continue;
        const unsigned is = vv_dataset_is_mesh(made->input[i], job) ? VV_IS_MESH : VV_IS_FIELD;
        if (!(is & operand->is))
            return vv_fail_at(VV_E_ARGUMENT, NULL, place(where, made, "inputs", operand->names ? NULL : operand->name),
                              "%s takes %s, and '%s' is %s", made->operation->name, word_of(operand->is),
                              made->input_id[i], word_of(is));
    }
    return VV_OK;
}

/* What a scene asks for is held to the limits of files. */
static vv_status check_size(const vvi_made *made, const vv_field_info *info, vv_job *job)
{
    const vv_limits *limits = vvi_job_limits(job);
    const int64_t *n = info->grid.dims;
    char where[PATH_ROOM];
    uint64_t voxels = 1;
    bool large = false;
    for (int a = 0; a < 3; a++)
        large |= (uint64_t)n[a] > limits->dim || __builtin_mul_overflow(voxels, (uint64_t)n[a], &voxels);
    if (!large && voxels <= limits->voxels)
        return VV_OK;
    return vv_fail_at(VV_E_LIMIT, NULL, place(where, made, "parameters", NULL),
                      "%s would make %" PRId64 " x %" PRId64 " x %" PRId64 " samples: at most %" PRIu64
                      " along an axis and %" PRIu64 " in all are allowed",
                      made->operation->name, n[0], n[1], n[2], limits->dim, limits->voxels);
}

vv_status vvi_made_fail(const vvi_made *made, const char *property, vv_status st)
{
    char where[PATH_ROOM];
    vvi_error_copy error;
    const vv_error *last = vv_error_last();
    const bool said = last->file || (last->where && !strncmp(last->where, "datasets.", 9));
    if (st == VV_OK || said || st == VV_E_CANCELLED || st == VV_E_MEMORY)
        return st;
    vvi_error_take(&error);
    snprintf(where, sizeof where, "datasets.%s%s%s", made->id, property ? "." : "", property ? property : "");
    st = vv_fail_at(st, NULL, where, "%s", error.message ? error.message : "");
    vvi_error_copy_free(&error);
    return st;
}

/* Of inputs that are series: each has as many time steps as the others, or one that goes with all of theirs. */
static vv_status plan_frames(vv_field_info *out, const vvi_made *made, const vv_field_info *infos)
{
    char where[PATH_ROOM];
    size_t longest = 0;
    if (made->n == 0) { /* made of nothing: one, as planned */
        out->n_frames = 1;
        return VV_OK;
    }
    for (size_t i = 0; i < made->n; i++) {
        const int64_t n = infos[i].n_frames, most = infos[longest].n_frames;
        if (!made->input[i] || vv_operation_operand(made->operation, i)->grid_only)
            continue;
        if (n > 1 && most > 1 && n != most)
            return vv_fail_at(VV_E_ARGUMENT, NULL, place(where, made, "inputs", NULL),
                              "'%s' has %" PRId64 " time steps but '%s' has %" PRId64, made->input_id[i], n,
                              made->input_id[longest], most);
        longest = n > most ? i : longest;
    }
    out->n_frames = infos[longest].n_frames;
    if (longest > 0) {
        out->frame_step = infos[longest].frame_step;
        memcpy(out->frame_unit, infos[longest].frame_unit, sizeof out->frame_unit);
    }
    return VV_OK;
}

/* Whether inputs have as many samples as the first: else it may be they that are at fault. */
static bool fit(const vvi_made *made, const vv_field_info *infos)
{
    bool same = true;
    for (size_t i = 1; i < made->n; i++)
        same =
            same && (!made->input[i] || memcmp(infos[i].grid.dims, infos[0].grid.dims, sizeof infos[0].grid.dims) == 0);
    return same;
}

vv_status vvi_made_plan(vv_field_info *out, const vvi_made *made, const vv_object *params, vv_job *job)
{
    vv_field_info infos[VVI_RUN_INPUTS] = {0};
    vv_status st = check_kinds(made, job);
    for (size_t i = 0; i < made->n && st == VV_OK; i++)
        if (made->input[i] && !vv_dataset_is_mesh(made->input[i], job))
            st = vv_dataset_info(&infos[i], made->world, made->input[i], job);
    if (st != VV_OK || vv_operation_makes(made->operation) == VV_IS_MESH)
        return st;
    if ((st = made->operation->plan(out, infos, made->n, params)) != VV_OK)
        return vvi_made_fail(made, fit(made, infos) ? "parameters" : NULL, st);
    if (!made->operation->joins && (st = plan_frames(out, made, infos)) != VV_OK)
        return st;
    out->frame = 0;
    return check_size(made, out, job);
}
