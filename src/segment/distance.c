/* Distance: how far each voxel is from the nearest one of a set, in the world. */
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "registry.h"
#include "segment/distance_lines.h"
#include "segment/distance_object.h"
#include "segment/label_result.h"

#include <math.h>
#include <string.h>

#define OBLIQUE 1e-4 /* cosine of axes that are at right angles but for what headers round */

static const char *const side_names[] = {"outside", "inside", "both", NULL};
static const char *const side_aliases[] = {"signed", "both", NULL};

static const vv_property properties[] = {
    {VV_PROP(vvi_distance_params, of), .kind = VV_KIND_NUMBERS, .columns = 1, .lone = true, .quantity = VV_Q_LABEL,
     .automatic = "all that is not 0", .doc = "labels of the object, one or several: 3 or 3,5"},
    {VV_PROP(vvi_distance_params, range), .kind = VV_KIND_STRING, .automatic = "all that is not 0",
     .doc = "instead: values of the object, both ends included: 100..200, 100.. or ..200"},
    {VV_PROP(vvi_distance_params, side), .kind = VV_KIND_ENUM, .names = side_names, .aliases = side_aliases,
     .option = "side",
     .doc = "outside: from voxels around the object to it, 0 in it; inside: from its voxels to those around it, 0 "
            "there; both: outside positive, inside negative"},
    {0},
};

static vv_status check(const vv_object *object, const char *path)
{
    const vvi_distance_params *p = (const vvi_distance_params *)object;
    vvi_value_range range;
    (void)path;
    if (vvi_distance_given(p) && p->of && p->of->n)
        return vv_fail(VV_E_ARGUMENT, "distance: `of` and `range` both say what the object is; give one of them");
    return vvi_distance_given(p) ? vvi_value_range_parse(&range, p->range, "distance: range") : VV_OK;
}

static const vv_class distance_class = {
    .name = "distance",
    .doc = "parameters of distance",
    .size = sizeof(vvi_distance_params),
    .properties = properties,
    .check = check,
};

static vv_status check_axes(const vv_grid *grid)
{
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3;
        const vv_vec3 u = grid->index_to_world.axis[a], v = grid->index_to_world.axis[b];
        if (grid->dims[a] > 1 && grid->dims[b] > 1 && fabs(vvi_dot(u, v)) > OBLIQUE * vvi_length(u) * vvi_length(v))
            return vv_fail(VV_E_UNSUPPORTED,
                           "distance: the axes %c and %c of the volume are not at right angles; bring "
                           "it onto a grid whose axes are",
                           "xyz"[a], "xyz"[b]);
    }
    return VV_OK;
}

vv_status vvi_distance_plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    (void)n_inputs;
    *out = inputs[0];
    out->type = VV_TYPE_F32;
    out->meaning = VV_MEANING_SCALAR;
    out->value_scale = 1;
    out->value_offset = 0;
    memset(out->name, 0, sizeof out->name);
    memcpy(out->value_unit, inputs[0].grid.unit, sizeof out->value_unit);
    vv_status st = vvi_label_need_one_component(&inputs[0], "distance");
    if (st == VV_OK && (st = check(params, NULL)) == VV_OK)
        st = check_axes(&inputs[0].grid);
    return st;
}

/* Distances ------------------------------------------------------------------------------------------------------- */

typedef struct joining {
    float *out;
    const float *inside;
    size_t n;
} joining;

#define JOINED ((size_t)1 << 18) /* samples of an item */

static vv_status join_item(void *scratch, void *user, size_t index)
{
    const joining *j = user;
    const size_t end = (index + 1) * JOINED < j->n ? (index + 1) * JOINED : j->n;
    (void)scratch;
    for (size_t i = index * JOINED; i < end; i++)
        j->out[i] = j->inside[i] > 0 ? -j->inside[i] : j->out[i];
    return VV_OK;
}

static vv_status measure(float *out, vvi_distance_object *o, int side, const double spacing[3], vv_job *job)
{
    static const vvi_work work = {.item = join_item};
    const int64_t *n = o->brick.box.n;
    joining j = {.out = out, .n = (size_t)(n[0] * n[1] * n[2])};
    float *inside = out;
    vv_status st = VV_OK;
    if (side != VVI_DISTANCE_INSIDE)
        st = vvi_distances(out, n, spacing, vvi_distance_set_row, o, job);
    if (st != VV_OK || side == VVI_DISTANCE_OUTSIDE)
        return st;
    if (side == VVI_DISTANCE_BOTH) {
        if ((st = vvi_memory_plan(job, j.n * sizeof *inside, "distance")) != VV_OK)
            return st;
        inside = vvi_alloc(job, j.n * sizeof *inside, VVI_MEM_SCRATCH);
        if (!inside)
            return vv_fail_memory(j.n * sizeof *inside);
    }
    o->complement = true;
    const uint64_t before = atomic_load(&o->n_inside);
    st = vvi_distances(inside, n, spacing, vvi_distance_set_row, o, job);
    atomic_store(&o->n_inside, side == VVI_DISTANCE_BOTH ? before : j.n - atomic_load(&o->n_inside));
    if (side == VVI_DISTANCE_OUTSIDE || inside == out)
        return st;
    j.inside = inside;
    if (st == VV_OK)
        st = vvi_parallel_for(job, &work, &j, (j.n - 1) / JOINED + 1);
    vvi_free(inside);
    return st;
}

static vv_status run(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                     vv_job *job)
{
    const vvi_distance_params *p = (const vvi_distance_params *)params;
    const vv_field_info *info = vv_field_get_info(inputs[0]);
    const vv_box all = vv_field_box(inputs[0]);
    const double spacing[3] = {vv_grid_spacing(&info->grid, 0), vv_grid_spacing(&info->grid, 1),
                               vv_grid_spacing(&info->grid, 2)};
    vv_field_info result;
    vvi_distance_object o = {.n_ranges = 0};
    void *data;
    *out = NULL;
    vv_status st = vvi_distance_plan(&result, info, n_inputs, params);
    if (st != VV_OK || (st = vv_field_brick(&o.brick, inputs[0], &all, job)) != VV_OK)
        return st;
    if ((st = vvi_distance_choose(&o, p, info, job)) == VV_OK &&
        (st = vv_field_new_empty(out, &data, &result, job)) == VV_OK)
        st = measure(data, &o, p->side, spacing, job);
    if (st == VV_OK)
        vvi_distance_tell(&o, p->side, (uint64_t)(all.n[0] * all.n[1] * all.n[2]), job);
    vv_brick_release(&o.brick);
    vvi_free(o.range);
    if (st != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}

static uint64_t memory(const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const int64_t *n = inputs[0].grid.dims;
    return ((const vvi_distance_params *)params)->side == VVI_DISTANCE_BOTH
               ? (uint64_t)(n[0] * n[1] * n[2]) * sizeof(float)
               : 0;
}

const vv_operation vvi_operation_distance = {
    .api = VV_OPERATION_API,
    .name = "distance",
    .component = "segment",
    .group = "morphology",
    .doc =
        "distance of each voxel from the nearest one of an object, between their centres, in the world: exact, however "
        "uneven the spacing",
    .example = "volvis distance head.nrrd -o far.nrrd --range 150.. --side both",
    .params = &distance_class,
    .inputs = VV_ONE_VOLUME,
    .run = run,
    .plan = vvi_distance_plan,
    .memory = memory,
    .passes = &vvi_distance_passes,
};
