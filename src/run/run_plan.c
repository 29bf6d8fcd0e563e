/* Runs planned from headers: time steps, what each step will make, and the memory that it takes. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "grid/true_values.h"
#include "io/file_stream.h"
#include "io/format.h"
#include "run/run_impl.h"
#include <inttypes.h>
#include <string.h>

static bool is_gap(const vv_run_input *in)
{
    return !in->file && !in->field && !in->mesh;
}

/* Of what comes from a file, and not from memory, where there is one. */
static bool is_of_file(const vv_run_input *in)
{
    return in->file && !in->field && !in->mesh;
}

static int64_t frames_of_file(const vv_run_input *in)
{
    return is_of_file(in) ? vv_file_info(in->file)->n_frames : 1;
}

int vvi_run_last(const vv_run *r)
{
    return r->n_steps ? VVI_RUN_INPUTS + (int)r->n_steps - 1 : 0;
}

static bool makes_mesh(const vv_run *r)
{
    return r->n_steps > 0 && vv_operation_makes(r->steps[r->n_steps - 1].operation) == VV_IS_MESH;
}

static const char *name_of(const vv_run *r, int node)
{
    return node < VVI_RUN_INPUTS ? r->inputs[node].name : r->steps[node - VVI_RUN_INPUTS].operation->name;
}

/* Who takes what -------------------------------------------------------------------------------------------------- */

/* Inputs that are joined come one after the other, and share what is kept of them. */
static void count_uses(vv_run *r)
{
    for (size_t i = 0; i < r->n_inputs; i++)
        r->nodes[i] = (vvi_run_node){.n_frames = 1, .pool = i, .read = r->n_steps == 0};
    for (size_t s = 0; s < r->n_steps; s++) {
        const vvi_run_takes *takes = &r->takes[s];
        const vv_operation *o = r->steps[s].operation;
        for (size_t i = 0; i < takes->n; i++) {
            if (takes->from[i] == VVI_RUN_GAP)
                continue;
            vvi_run_node *node = &r->nodes[takes->from[i]];
            node->n_uses++;
            node->last_use = s;
            node->read |= !vv_operation_operand(o, i)->grid_only;
            if (o->joins && takes->from[i] < VVI_RUN_INPUTS && takes->from[0] >= 0)
                node->pool = (size_t)takes->from[0] % VVI_RUN_INPUTS;
        }
    }
}

size_t vvi_run_joined(const vv_run *r, size_t s, int64_t *index)
{
    const vvi_run_takes *takes = &r->takes[s];
    size_t i = 0;
    for (; i + 1 < takes->n && *index >= r->nodes[takes->from[i]].n_frames; i++)
        *index -= r->nodes[takes->from[i]].n_frames;
    return i;
}

/* Time steps ------------------------------------------------------------------------------------------------------ */

/* Where a time step of the first input was chosen, it is the one that is taken of other series. */
static vv_status choose_inputs(vv_run *r)
{
    const bool joined = r->n_steps > 0 && r->steps[0].operation->joins;
    r->chosen = joined || r->about.makes == VV_IS_MESH || r->n_inputs == 0 ? -1 : r->inputs[0].frame;
    for (size_t i = 0; i < r->n_inputs; i++) {
        const vv_run_input *in = &r->inputs[i];
        const int64_t n = frames_of_file(in);
        r->nodes[i].n_frames = in->frame >= 0 || r->chosen >= 0 || r->about.makes == VV_IS_MESH ? 1 : n;
        if (r->chosen >= n && n > 1 && in->frame < 0 && r->nodes[i].read)
            return vv_fail_at(VV_E_ARGUMENT, in->name, NULL,
                              "has %" PRId64 " time steps, and of %s number %" PRId64
                              " is taken: choose one with FILE@N",
                              n, r->inputs[0].name, r->chosen);
    }
    return VV_OK;
}

/* Each has as many as the others, or one that goes with all of theirs. */
static vv_status step_frames(vv_run *r, size_t s, const vvi_run_node **longest_out)
{
    const vvi_run_takes *takes = &r->takes[s];
    const vv_operation *o = r->steps[s].operation;
    int first = takes->from[0];
    int64_t all = 0;
    if (takes->n == 0) { /* what is made of nothing has no series to follow */
        r->nodes[VVI_RUN_INPUTS + s].n_frames = 1;
        *longest_out = &r->nodes[VVI_RUN_INPUTS + s];
        return VV_OK;
    }
    for (size_t i = 0; i < takes->n; i++) {
        const int from = takes->from[i];
        if (o->joins && from == VVI_RUN_GAP)
            return vv_fail(VV_E_ARGUMENT, "%s: input number %zu is missing", o->name, i + 1);
        if (from == VVI_RUN_GAP || (!o->joins && vv_operation_operand(o, i)->grid_only))
            continue;
        const int64_t n = r->nodes[from].n_frames, most = r->nodes[first].n_frames;
        all += n;
        if (!o->joins && n > 1 && most > 1 && n != most)
            return vv_fail_at(VV_E_ARGUMENT, name_of(r, from), NULL,
                              "has %" PRId64 " time steps but %s has %" PRId64 ": choose one with FILE@N", n,
                              name_of(r, first), most);
        first = n > most ? from : first;
    }
    *longest_out = &r->nodes[first];
    r->nodes[VVI_RUN_INPUTS + s].n_frames = o->joins ? all : r->nodes[first].n_frames;
    return VV_OK;
}

static void follow_frames(const vv_run *r)
{
    for (size_t i = 0; i < r->n_inputs && r->n_results > 1; i++)
        if (is_of_file(&r->inputs[i]) && r->nodes[i].n_frames > 1)
            vvi_file_follow(r->inputs[i].file, VVI_FOLLOW_FRAMES);
}

/* What the steps make --------------------------------------------------------------------------------------------- */

/* Before steps ask what they are; with a scale they are amounts. */
static bool becomes_label(const vv_run *r, const vv_field_info *info)
{
    return r->format && r->format->labels_only && info->meaning == VV_MEANING_SCALAR && info->components == 1 &&
           !vv_type_is_float(info->type) && !vvi_has_scale(info);
}

void vvi_run_declare_label(vv_field_info *info, const vv_run *r)
{
    if (becomes_label(r, info))
        info->meaning = VV_MEANING_LABEL;
}

static vv_status plan_step(vv_run *r, size_t s)
{
    const vv_step *step = &r->steps[s];
    const vvi_run_takes *takes = &r->takes[s];
    const vv_operation *o = step->operation;
    vvi_run_node *node = &r->nodes[VVI_RUN_INPUTS + s];
    const vvi_run_node *longest = node;
    vv_field_info infos[VVI_RUN_INPUTS] = {0};
    uint64_t bytes = 0;
    vv_status st = step_frames(r, s, &longest);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < takes->n; i++)
        if (takes->from[i] != VVI_RUN_GAP)
            infos[i] = r->nodes[takes->from[i]].info;
    if (!o->plan)
        return vv_fail(VV_E_ARGUMENT, "%s: makes no samples of samples", o->name);
    if ((st = o->plan(&node->info, infos, takes->n, step->params)) != VV_OK ||
        (st = vv_field_info_bytes(&bytes, &node->info)) != VV_OK)
        return st;
    if (!o->joins && takes->n > 0 && longest->n_frames > infos[0].n_frames) { /* its time is that of the series */
        node->info.n_frames = longest->info.n_frames;
        node->info.frame_step = longest->info.frame_step;
        memcpy(node->info.frame_unit, longest->info.frame_unit, sizeof node->info.frame_unit);
    }
    const uint64_t working = o->memory ? o->memory(infos, o->joins ? 1 : takes->n, step->params) : 0;
    r->about.working = working > r->about.working ? working : r->about.working;
    r->whole |= o->run_box ? working > 0 : !o->passes;
    if (o->passes && o->passes->scratch && !r->whole)
        r->passes_scratch += o->passes->scratch(infos, o->joins ? 1 : takes->n, step->params);
    r->ways[s].bytes = bytes;
    r->about.bytes += bytes * (uint64_t)(s + 1 == r->n_steps ? r->n_results : 1);
    return VV_OK;
}

/* What the result will be, and what it takes on the way. */
static vv_status plan_steps(vv_run *r)
{
    vv_status st = VV_OK;
    for (size_t s = 0; s < r->n_steps && st == VV_OK; s++)
        st = plan_step(r, s);
    if (st != VV_OK)
        return st;
    vv_field_info info = r->nodes[vvi_run_last(r)].info;
    vvi_run_declare_label(&info, r);
    r->about.finds_type = r->format && vvi_format_writes_values(r->format, &info, r->options.stored);
    r->about.info = r->about.result = r->about.written = info;
    return VV_OK;
}

static void take_infos(vv_run *r)
{
    for (size_t i = 0; i < r->n_inputs; i++) {
        const vv_run_input *in = &r->inputs[i];
        if (in->field || in->file)
            r->nodes[i].info = in->field ? *vv_field_get_info(in->field) : *vv_file_info(in->file);
    }
    vvi_run_declare_label(&r->nodes[0].info, r);
}

/* Memory ---------------------------------------------------------------------------------------------------------- */

/* What reading holds: the samples of a time step, unless they are used where they lie. Without steps what was read is
 * the result, and every time step stays. */
static vv_status plan_reading(vv_run *r)
{
    for (size_t i = 0; i < r->n_inputs; i++) {
        const vv_run_input *in = &r->inputs[i];
        uint64_t bytes = 0;
        if (!r->nodes[i].read || r->nodes[i].pool != i || !is_of_file(in) || vv_file_mappable(in->file))
            continue;
        const vv_status st = vv_field_info_bytes(&bytes, vv_file_info(in->file));
        if (st != VV_OK)
            return st;
        r->about.bytes += bytes * (uint64_t)(r->n_steps ? 1 : r->n_results);
    }
    return VV_OK;
}

/* Whether a step asks for each slice once, in their order. */
static bool goes_in_order(const vv_step *step)
{
    const vv_operation *o = step->operation;
    return o->in_order && !(o->looks && o->looks(step->params));
}

static bool spools(const vv_run *r, size_t s)
{
    const int node = VVI_RUN_INPUTS + (int)s;
    bool in_order = r->steps[s].operation->in_order && r->nodes[node].n_uses < 2;
    for (size_t t = s + 1; t < r->n_steps; t++)
        for (size_t i = 0; i < r->takes[t].n; i++)
            in_order = in_order && (r->takes[t].from[i] != node || goes_in_order(&r->steps[t]));
    return r->nodes[node].read && !in_order;
}

/* What goes through slice by slice is made as it is asked for. Whoever looks around a sample asks for slices more often
 * than once, and so does whoever makes them: in a chain that would be more with every step, so that a file comes in
 * between. Two are enough where each is made of the one before alone. */
static void choose_ways(vv_run *r)
{
    bool plain = true;
    for (size_t s = 1; s < r->n_steps; s++)
        plain = plain && r->nodes[VVI_RUN_INPUTS + s - 1].last_use == s;
    for (size_t s = 0, n = 0; s + 1 < r->n_steps; s++) {
        vvi_stream_way *way = &r->ways[s];
        way->spooled = spools(r, s);
        if (way->spooled)
            way->file = plain ? n++ % 2 : n++;
    }
}

/* Bytes of the temporary files. */
static uint64_t spooled_bytes(const vv_run *r)
{
    uint64_t all = 0;
    for (size_t s = 0; s < r->n_steps; s++) {
        bool most = r->ways[s].spooled; /* the largest of its file counts, the first of equal ones */
        for (size_t t = 0; t < r->n_steps; t++)
            if (t != s && r->ways[t].spooled && r->ways[t].file == r->ways[s].file)
                most = most && (t < s ? r->ways[t].bytes < r->ways[s].bytes : r->ways[t].bytes <= r->ways[s].bytes);
        all += most ? r->ways[s].bytes : 0;
    }
    return all;
}

vv_status vvi_run_plan_streamed(vv_run *r)
{
    size_t place[VVI_RUN_INPUTS] = {0}, n = 0;
    for (size_t i = 0; i < r->n_inputs; i++) { /* the first that has a pool comes first */
        place[i] = r->nodes[i].pool == i ? n++ : place[r->nodes[i].pool];
        r->nodes[i].pool = place[i];
    }
    choose_ways(r);
    const vv_status st = vvi_stream_init(&r->stream, n, r->ways, r->n_steps, r->job);
    if (st != VV_OK)
        return st;
    r->about.scratch = r->passes_scratch + spooled_bytes(r);
    r->about.bytes = r->stream.bytes;
    r->about.working = 0;
    r->about.streamed = true;
    return VV_OK;
}

/* More than fits, with what steps hold beside it, is streamed, unless a step cannot: then what it takes is said before
 * the work. */
static vv_status plan_memory(vv_run *r)
{
    const vv_runtime *runtime = r->job ? vv_job_runtime(r->job) : NULL;
    const uint64_t limit = runtime ? vv_runtime_memory_limit(runtime) : UINT64_MAX;
    const bool fits = r->about.bytes <= limit && r->about.working <= limit - r->about.bytes;
    return (vvi_stream_needed(r->about.bytes, r->job) || !fits) && !r->whole ? vvi_run_plan_streamed(r) : VV_OK;
}

/* The whole ------------------------------------------------------------------------------------------------------- */

static vv_status choose_format(vv_run *r, const vv_run_output *output)
{
    const vv_registry *registry = vvi_job_registry(r->job);
    vv_write_options_init(&r->options, sizeof r->options);
    vvi_options_over(&r->options, sizeof r->options, output->options);
    if (!r->path)
        return VV_OK;
    return r->options.format ? vvi_format_named(&r->format, r->options.format, registry)
                             : vvi_format_of_output(&r->format, r->path, registry);
}

static vv_status choose_frames(vv_run *r)
{
    const vvi_run_node *unused;
    vv_status st = choose_inputs(r);
    for (size_t s = 0; s < r->n_steps && st == VV_OK; s++)
        st = step_frames(r, s, &unused);
    r->about.n_frames = r->n_results = r->nodes[vvi_run_last(r)].n_frames;
    if (st == VV_OK)
        follow_frames(r);
    return st;
}

/* Layers of a segmentation in the place of time steps, where the output holds them. */
static vv_status choose_layers(vv_run *r)
{
    if (!r->format || !r->format->labels_only || r->n_inputs != 1 || r->about.n_frames > 1)
        return VV_OK;
    const vv_status st = vvi_layers_open(&r->layers, &r->inputs[0], r->job);
    r->about.n_layers = r->layers.n;
    if (r->layers.n > 0)
        r->n_results = (int64_t)r->layers.n;
    return st;
}

static vv_status plan_fields(vv_run *r, const vv_run_output *output)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < r->n_inputs; i++)
        if (r->inputs[i].mesh)
            return vv_fail(VV_E_ARGUMENT, "%s: takes a volume, and '%s' is a mesh", r->name, r->inputs[i].name);
    if (r->n_inputs > 0 && is_gap(&r->inputs[0]))
        return vv_fail(VV_E_ARGUMENT, "%s: input number 1 is missing", r->name);
    if ((st = choose_format(r, output)) == VV_OK && (st = choose_frames(r)) == VV_OK &&
        (st = choose_layers(r)) == VV_OK) {
        take_infos(r);
        if ((st = plan_steps(r)) == VV_OK && (st = plan_reading(r)) == VV_OK)
            st = plan_memory(r);
    }
    return st;
}

/* Of one time step, whole in memory: what triangles will take nobody knows. */
static vv_status plan_mesh(vv_run *r)
{
    const vv_status st = choose_inputs(r);
    r->about.n_frames = r->n_results = 1;
    take_infos(r);
    return st == VV_OK ? plan_reading(r) : st;
}

vv_status vvi_run_plan_all(vv_run *r, const vv_run_output *output)
{
    r->about.makes = makes_mesh(r) ? VV_IS_MESH : VV_IS_FIELD;
    count_uses(r);
    return r->about.makes == VV_IS_MESH ? plan_mesh(r) : plan_fields(r, output);
}
