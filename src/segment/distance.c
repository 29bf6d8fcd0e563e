/* Distance: how far each voxel is from the nearest one of a set, in the world. */
#include "core/findings.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "filter/sample_keys.h"
#include "grid/label_id.h"
#include "registry.h"
#include "segment/distance_lines.h"
#include "segment/label_result.h"
#include "segment/value_range.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define OBLIQUE 1e-4 /* cosine of axes that are at right angles but for what headers round */

typedef struct distance_params {
    vv_object object;
    vv_numbers *of;
    char *range;
    int side;
} distance_params;

enum { OUTSIDE, INSIDE, BOTH };
static const char *const side_names[] = {"outside", "inside", "both", NULL};
static const char *const side_aliases[] = {"signed", "both", NULL};

static const vv_property properties[] = {
    {VV_PROP(distance_params, of), .kind = VV_KIND_NUMBERS, .columns = 1, .lone = true, .quantity = VV_Q_LABEL,
     .automatic = "all that is not 0", .doc = "labels of the object, one or several: 3 or 3,5"},
    {VV_PROP(distance_params, range), .kind = VV_KIND_STRING, .automatic = "all that is not 0",
     .doc = "instead: values of the object, both ends included: 100..200, 100.. or ..200"},
    {VV_PROP(distance_params, side), .kind = VV_KIND_ENUM, .names = side_names, .aliases = side_aliases,
     .option = "side",
     .doc = "outside: from voxels around the object to it, 0 in it; inside: from its voxels to those around it, 0 "
            "there; both: outside positive, inside negative"},
    {0},
};

static bool given(const distance_params *p)
{
    return p->range && *p->range;
}

static vv_status check(const vv_object *object, const char *path)
{
    const distance_params *p = (const distance_params *)object;
    vvi_value_range range;
    (void)path;
    if (given(p) && p->of && p->of->n)
        return vv_fail(VV_E_ARGUMENT, "distance: `of` and `range` both say what the object is; give one of them");
    return given(p) ? vvi_value_range_parse(&range, p->range, "distance: range") : VV_OK;
}

static const vv_class distance_class = {
    .name = "distance",
    .doc = "parameters of distance",
    .size = sizeof(distance_params),
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

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
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

/* The object ------------------------------------------------------------------------------------------------------ */

typedef struct object {
    vv_brick brick;
    vvi_key_range *range;
    size_t n_ranges;
    bool other;      /* what is in none of the ranges */
    bool complement; /* what is not of the object is asked for */
    vvi_key_range all;
    _Atomic uint64_t n_inside;
} object;

/* The one key of a label, exactly where it is stored as it is. */
static vvi_key_range keys_of_label(vv_label_id id, double value, const vv_field_info *info)
{
    const vvi_value_range one = {value, value};
    char sample[8], key[8];
    memcpy(sample, &id, sizeof sample);
    if (vv_type_bytes(info->type) < 8 || vv_type_is_float(info->type))
        return vvi_key_range_of(&one, info);
    vvi_keys_of_samples(key, sample, 8, info->type, 1);
    return (vvi_key_range){vvi_key_at(key, 0, info->type), vvi_key_at(key, 0, info->type)};
}

static vv_status choose(object *o, const distance_params *p, const vv_field_info *info, vv_job *job)
{
    static const vvi_value_range nothing = {0, 0}, anything = {-INFINITY, INFINITY};
    const size_t n = p->of ? p->of->n : 0;
    vvi_value_range range;
    vv_status st = VV_OK;
    o->all = vvi_key_range_of(&anything, info);
    o->n_ranges = n ? n : 1;
    o->range = vvi_alloc(job, o->n_ranges * sizeof *o->range, VVI_MEM_SCRATCH);
    if (!o->range)
        return vv_fail_memory(o->n_ranges * sizeof *o->range);
    for (size_t i = 0; i < n; i++)
        o->range[i] = keys_of_label(p->of->labels ? p->of->labels[i] : (vv_label_id)p->of->v[i], p->of->v[i], info);
    if (given(p) && (st = vvi_value_range_parse(&range, p->range, "distance: range")) == VV_OK) {
        range = vvi_value_range_as_typed(&range, info);
        o->range[0] = vvi_key_range_of(&range, info);
    } else if (!n) {
        o->range[0] = vvi_key_range_of(&nothing, info);
        o->other = true;
    }
    return st;
}

#define PART 512

/* NaN is of no object. */
static void part_of_row(uint8_t *out, const object *o, const char *samples, int64_t n)
{
    uint8_t more[PART];
    const int64_t step = o->brick.stride[0];
    vvi_key_range_row(out, samples, step, o->brick.type, &o->range[0], n);
    for (size_t r = 1; r < o->n_ranges; r++) {
        vvi_key_range_row(more, samples, step, o->brick.type, &o->range[r], n);
        for (int64_t i = 0; i < n; i++)
            out[i] |= more[i];
    }
    if (o->other) {
        vvi_key_range_row(more, samples, step, o->brick.type, &o->all, n);
        for (int64_t i = 0; i < n; i++)
            out[i] = more[i] & (out[i] ^ 1);
    }
    for (int64_t i = 0; i < n && o->complement; i++)
        out[i] ^= 1;
}

static void set_row(uint8_t *out, size_t row, void *user)
{
    object *o = user;
    const int64_t *n = o->brick.box.n;
    const char *samples = (const char *)o->brick.data + (int64_t)row % n[1] * o->brick.stride[1] +
                          (int64_t)row / n[1] * o->brick.stride[2];
    uint64_t inside = 0;
    for (int64_t at = 0; at < n[0]; at += PART)
        part_of_row(out + at, o, samples + at * o->brick.stride[0], n[0] - at < PART ? n[0] - at : PART);
    for (int64_t i = 0; i < n[0]; i++)
        inside += out[i];
    atomic_fetch_add_explicit(&o->n_inside, inside, memory_order_relaxed);
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

static vv_status measure(float *out, object *o, int side, const double spacing[3], vv_job *job)
{
    static const vvi_work work = {.item = join_item};
    const int64_t *n = o->brick.box.n;
    joining j = {.out = out, .n = (size_t)(n[0] * n[1] * n[2])};
    float *inside = out;
    vv_status st = VV_OK;
    if (side != INSIDE)
        st = vvi_distances(out, n, spacing, set_row, o, job);
    if (st != VV_OK || side == OUTSIDE)
        return st;
    if (side == BOTH) {
        if ((st = vvi_memory_plan(job, j.n * sizeof *inside, "distance")) != VV_OK)
            return st;
        inside = vvi_alloc(job, j.n * sizeof *inside, VVI_MEM_SCRATCH);
        if (!inside)
            return vv_fail_memory(j.n * sizeof *inside);
    }
    o->complement = true;
    const uint64_t before = atomic_load(&o->n_inside);
    st = vvi_distances(inside, n, spacing, set_row, o, job);
    atomic_store(&o->n_inside, side == BOTH ? before : j.n - atomic_load(&o->n_inside));
    if (side == OUTSIDE || inside == out)
        return st;
    j.inside = inside;
    if (st == VV_OK)
        st = vvi_parallel_for(job, &work, &j, (j.n - 1) / JOINED + 1);
    vvi_free(inside);
    return st;
}

static void tell(const object *o, int side, vv_job *job)
{
    const int64_t *n = o->brick.box.n;
    const uint64_t inside = atomic_load(&o->n_inside), all = (uint64_t)(n[0] * n[1] * n[2]);
    vvi_find_count(job, "object_voxels", inside);
    vvi_find_phrase(job, "from an object of %llu voxels", (unsigned long long)inside);
    if (inside == 0 && side != INSIDE)
        vvi_find_note(job, "no voxel is of the object, so that all distances from it are infinite");
    if (inside == all && side != OUTSIDE)
        vvi_find_note(job, "all voxels are of the object, so that all distances to its outside are infinite");
}

static vv_status run(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                     vv_job *job)
{
    const distance_params *p = (const distance_params *)params;
    const vv_field_info *info = vv_field_get_info(inputs[0]);
    const vv_box all = vv_field_box(inputs[0]);
    const double spacing[3] = {vv_grid_spacing(&info->grid, 0), vv_grid_spacing(&info->grid, 1),
                               vv_grid_spacing(&info->grid, 2)};
    vv_field_info result;
    object o = {.n_ranges = 0};
    void *data;
    *out = NULL;
    vv_status st = plan(&result, info, n_inputs, params);
    if (st != VV_OK || (st = vv_field_brick(&o.brick, inputs[0], &all, job)) != VV_OK)
        return st;
    if ((st = choose(&o, p, info, job)) == VV_OK && (st = vv_field_new_empty(out, &data, &result, job)) == VV_OK)
        st = measure(data, &o, p->side, spacing, job);
    if (st == VV_OK)
        tell(&o, p->side, job);
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
    return ((const distance_params *)params)->side == BOTH ? (uint64_t)(n[0] * n[1] * n[2]) * sizeof(float) : 0;
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
    .plan = plan,
    .memory = memory,
};
