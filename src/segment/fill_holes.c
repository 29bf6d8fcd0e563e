/* Fill holes: background that no border of the volume is reached from becomes the label around it. */
#include "core/findings.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/sample_keys.h"
#include "grid/label_set.h"
#include "grid/slice_axes.h"
#include "registry.h"
#include "segment/connectivity.h"
#include "segment/label_result.h"
#include "segment/runs.h"
#include "segment/voxels.h"

#include <string.h>

typedef struct fill_holes_params {
    vv_object object;
    int connectivity, slices;
    char *max_size;
} fill_holes_params;

static const char *const slice_names[] = {"none", "axial", "coronal", "sagittal", NULL};
static const char *const slice_aliases[] = {"z", "axial", "y", "coronal", "x", "sagittal", NULL};

static const vv_property properties[] = {
    VVI_CONNECTIVITY_PROPERTY(fill_holes_params, connectivity, "the background"),
    {VV_PROP(fill_holes_params, slices), .kind = VV_KIND_ENUM, .names = slice_names, .aliases = slice_aliases,
     .doc = "each slice by itself, across the axis of the volume that follows z, y or x of the world most: what is "
            "open along it alone is a hole too"},
    {VV_PROP(fill_holes_params, max_size), .kind = VV_KIND_STRING, .automatic = "any size",
     .doc = "larger holes stay: 100 (voxels), or a volume, 2.5mm3"},
    {0},
};

static const vv_class fill_holes_class = {
    .name = "fill-holes",
    .doc = "parameters of fill-holes",
    .size = sizeof(fill_holes_params),
    .properties = properties,
};

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const fill_holes_params *p = (const fill_holes_params *)params;
    double most;
    (void)n_inputs;
    *out = inputs[0];
    const vv_status st = vvi_label_need_one_component(&inputs[0], "fill-holes");
    if (st == VV_OK && vv_type_is_float(inputs[0].type))
        return vv_fail(VV_E_UNSUPPORTED, "fill-holes: the values are real numbers, and holes are in labels; make some "
                                         "with `volvis threshold`");
    return st == VV_OK ? vvi_voxels_parse(&most, p->max_size, &inputs[0].grid, "fill-holes: max_size") : st;
}

typedef struct filling {
    vv_brick brick; /* its axes in the order that slices need: those across are the last */
    bool slices;
    vvi_runs runs; /* of the background */
    vvi_key_range zero;
    uint8_t *open;               /* by part: it reaches the border, or is too large */
    int64_t *key_of;             /* by part: the label that was met first, in the end the one that it becomes */
    uint64_t *faces_of;          /* by part: at how many faces it touches that one */
    vvi_label_set labels, pairs; /* of the others: by key; hole << 32 | number of the label */
    uint64_t *faces;             /* by number of the pair: at how many faces they touch */
    size_t room;
    vv_job *job;
} filling;

/* Slices across an index axis: it becomes the last. */
static void turn(vv_brick *b, int axis)
{
    const int order[3] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2, axis};
    const vv_brick old = *b;
    for (int a = 0; a < 3; a++) {
        b->stride[a] = old.stride[order[a]];
        b->box.n[a] = old.box.n[order[a]];
        b->box.lo[a] = 0;
    }
}

static int slicing_axis(const fill_holes_params *p, const vv_grid *grid)
{
    int index_axis[3], sign[3];
    if (p->slices == 0)
        return -1;
    vvi_grid_index_axes(index_axis, sign, grid);
    return index_axis[vvi_slice_axes_of(grid->space)[p->slices - 1].normal];
}

/* Which parts are no holes ---------------------------------------------------------------------------------------- */

static bool at_border(const filling *f, size_t row)
{
    const int64_t *n = f->runs.n, j = (int64_t)row % n[1], k = (int64_t)row / n[1];
    return (n[1] > 1 && (j == 0 || j == n[1] - 1)) || (!f->slices && n[2] > 1 && (k == 0 || k == n[2] - 1));
}

static vv_status find_open(filling *f, double most)
{
    const vvi_runs *r = &f->runs;
    uint64_t *size = NULL;
    const vv_status st = vvi_runs_sizes(&size, r, f->job);
    const size_t n = (size_t)r->n_parts + 1;
    f->open = vvi_alloc_zeroed(f->job, n, VVI_MEM_SCRATCH);
    f->key_of = vvi_alloc(f->job, n * sizeof *f->key_of, VVI_MEM_SCRATCH);
    f->faces_of = vvi_alloc_zeroed(f->job, n * sizeof *f->faces_of, VVI_MEM_SCRATCH);
    if (st != VV_OK || !f->open || !f->key_of || !f->faces_of) {
        vvi_free(size);
        return st != VV_OK ? st : vv_fail_memory(n * sizeof *f->key_of);
    }
    for (uint32_t part = 0; part < r->n_parts; part++)
        f->open[part] = most > 0 && (double)size[part] > most;
    vvi_free(size);
    for (size_t row = 0; row < r->n_rows; row++)
        for (uint32_t i = r->first[row]; i < r->first[row + 1]; i++)
            if (at_border(f, row) || (r->n[0] > 1 && (r->lo[i] == 0 || r->end[i] == r->n[0])))
                f->open[r->part[i]] = 1;
    return VV_OK;
}

/* What is around holes -------------------------------------------------------------------------------------------- */

static vv_status add_face(filling *f, uint32_t hole, const char *sample)
{
    char room[8];
    uint32_t label, pair;
    vvi_keys_of_samples(room, sample, 8, f->brick.type, 1);
    const int64_t key = vvi_key_at(room, 0, f->brick.type);
    if (key >= f->zero.lo && key <= f->zero.hi)
        return VV_OK;
    if (f->faces_of[hole] == 0 || f->key_of[hole] == key) { /* most holes touch one label */
        f->key_of[hole] = key;
        f->faces_of[hole]++;
        return VV_OK;
    }
    vv_status st = vvi_label_set_add(&label, &f->labels, key, f->job);
    if (st == VV_OK)
        st = vvi_label_set_add(&pair, &f->pairs, (int64_t)((uint64_t)hole << 32 | label), f->job);
    if (st != VV_OK)
        return st;
    if (pair >= f->room) {
        const size_t old = f->room, larger = old ? 2 * old : 1024;
        uint64_t *faces = vvi_realloc(f->job, f->faces, larger * sizeof *faces, VVI_MEM_SCRATCH);
        if (!faces)
            return vv_fail_memory(larger * sizeof *faces);
        memset(faces + old, 0, (larger - old) * sizeof *faces);
        f->faces = faces;
        f->room = larger;
    }
    f->faces[pair]++;
    return VV_OK;
}

/* Faces of a run with the row at (j, k), if there is one. */
static vv_status add_faces(filling *f, uint32_t run, int64_t j, int64_t k)
{
    const vvi_runs *r = &f->runs;
    const vv_brick *b = &f->brick;
    vv_status st = VV_OK;
    if (j < 0 || j >= r->n[1] || k < 0 || k >= r->n[2])
        return VV_OK;
    const char *row = (const char *)b->data + j * b->stride[1] + k * b->stride[2];
    for (int32_t x = r->lo[run]; x < r->end[run] && st == VV_OK; x++)
        st = add_face(f, r->part[run], row + x * b->stride[0]);
    return st;
}

static vv_status look_around(filling *f, uint32_t run, int64_t j, int64_t k)
{
    const vvi_runs *r = &f->runs;
    const vv_brick *b = &f->brick;
    const char *row = (const char *)b->data + j * b->stride[1] + k * b->stride[2];
    vv_status st = VV_OK;
    if (r->lo[run] > 0)
        st = add_face(f, r->part[run], row + (r->lo[run] - 1) * b->stride[0]);
    if (st == VV_OK && r->end[run] < r->n[0])
        st = add_face(f, r->part[run], row + r->end[run] * b->stride[0]);
    for (int64_t side = -1; side < 2 && st == VV_OK; side += 2) {
        st = add_faces(f, run, j + side, k);
        if (st == VV_OK && !f->slices)
            st = add_faces(f, run, j, k + side);
    }
    return st;
}

static vv_status look_around_all(filling *f)
{
    const vvi_runs *r = &f->runs;
    vv_status st = VV_OK;
    for (size_t row = 0; row < r->n_rows && st == VV_OK; row++) {
        for (uint32_t i = r->first[row]; i < r->first[row + 1] && st == VV_OK; i++)
            if (!f->open[r->part[i]])
                st = look_around(f, i, (int64_t)row % r->n[1], (int64_t)row / r->n[1]);
        if (st == VV_OK && row % 64 == 0)
            st = vvi_job_progress(f->job, "fill-holes", row, r->n_rows);
    }
    return st;
}

/* Filling --------------------------------------------------------------------------------------------------------- */

/* The label that a hole touches at most faces; of several the least. Holes that touch none stay. */
static void choose(filling *f, int64_t *key_of_label)
{
    const vvi_label_set *pairs = &f->pairs, *labels = &f->labels;
    for (size_t at = 0; at < labels->room; at++)
        if (labels->number[at])
            key_of_label[labels->number[at] - 1] = labels->key[at];
    for (size_t at = 0; at < pairs->room; at++) {
        if (!pairs->number[at])
            continue;
        const uint64_t pair = (uint64_t)pairs->key[at], faces = f->faces[pairs->number[at] - 1];
        const uint32_t hole = (uint32_t)(pair >> 32);
        const int64_t key = key_of_label[(uint32_t)pair];
        if (faces > f->faces_of[hole] || (faces == f->faces_of[hole] && key < f->key_of[hole])) {
            f->faces_of[hole] = faces;
            f->key_of[hole] = key;
        }
    }
}

/* `out` has the strides of the turned brick. */
static void write_holes(char *out, const int64_t stride[3], const filling *f)
{
    const vvi_runs *r = &f->runs;
    const size_t each = vv_type_bytes(f->brick.type);
    char sample[8];
    for (size_t row = 0; row < r->n_rows; row++)
        for (uint32_t i = r->first[row]; i < r->first[row + 1]; i++) {
            const uint32_t part = r->part[i];
            if (f->open[part] || !f->faces_of[part])
                continue;
            char *at = out + (int64_t)row % r->n[1] * stride[1] + (int64_t)row / r->n[1] * stride[2];
            vvi_sample_of_key(sample, f->key_of[part], f->brick.type);
            for (int32_t x = r->lo[i]; x < r->end[i]; x++)
                memcpy(at + x * stride[0], sample, each);
        }
}

static void tell(const filling *f)
{
    uint64_t holes = 0, voxels = 0;
    for (uint32_t part = 0; part < f->runs.n_parts; part++)
        holes += f->faces_of[part] > 0;
    for (size_t i = 0; i < f->runs.n_runs; i++)
        if (f->faces_of[f->runs.part[i]])
            voxels += (uint64_t)(f->runs.end[i] - f->runs.lo[i]);
    vvi_find_count(f->job, "holes", holes);
    vvi_find_count(f->job, "filled_voxels", voxels);
    vvi_find_phrase(f->job, "%llu hole%s of %llu voxels filled", (unsigned long long)holes, holes == 1 ? "" : "s",
                    (unsigned long long)voxels);
}

static vv_status fill(char *out, const int64_t stride[3], filling *f)
{
    const size_t bytes = ((size_t)f->labels.n + 1) * sizeof(int64_t);
    int64_t *key_of_label = vvi_alloc(f->job, bytes, VVI_MEM_SCRATCH);
    if (!key_of_label)
        return vv_fail_memory(bytes);
    choose(f, key_of_label);
    vvi_free(key_of_label);
    write_holes(out, stride, f);
    tell(f);
    return VV_OK;
}

static void copy_rows(char *out, const vv_brick *b)
{
    const size_t each = vv_type_bytes(b->type);
    const int64_t *n = b->box.n;
    for (int64_t k = 0; k < n[2]; k++)
        for (int64_t j = 0; j < n[1]; j++) {
            const char *row = (const char *)b->data + j * b->stride[1] + k * b->stride[2];
            char *to = out + (size_t)((k * n[1] + j) * n[0]) * each;
            if (b->stride[0] == (int64_t)each)
                memcpy(to, row, (size_t)n[0] * each);
            else
                for (int64_t i = 0; i < n[0]; i++)
                    memcpy(to + (size_t)i * each, row + i * b->stride[0], each);
        }
}

static vv_status find_holes(filling *f, const fill_holes_params *p, const vv_field_info *info)
{
    static const vvi_value_range nothing = {0, 0};
    const vvi_touch touch = {.axes = p->connectivity + 1, .slices = f->slices};
    double most;
    f->zero = vvi_key_range_of(&nothing, info);
    const vvi_run_source source = {.brick = &f->brick, .range = f->zero};
    vv_status st = vvi_voxels_parse(&most, p->max_size, &info->grid, "fill-holes: max_size");
    if (st == VV_OK && (st = vvi_runs_find(&f->runs, &source, &touch, "fill-holes", f->job)) == VV_OK &&
        (st = find_open(f, most)) == VV_OK)
        st = look_around_all(f);
    return st;
}

static vv_status run(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                     vv_job *job)
{
    const fill_holes_params *p = (const fill_holes_params *)params;
    const vv_field_info *info = vv_field_get_info(inputs[0]);
    const vv_box all = vv_field_box(inputs[0]);
    const int axis = slicing_axis(p, &info->grid);
    filling f = {.slices = axis >= 0, .job = job};
    vv_field_info planned;
    vv_brick packed;
    void *data;
    *out = NULL;
    vv_status st = plan(&planned, info, n_inputs, params);
    if (st != VV_OK || (st = vv_field_brick(&f.brick, inputs[0], &all, job)) != VV_OK)
        return st;
    if ((st = vv_field_new_empty(out, &data, &planned, job)) == VV_OK) {
        const int64_t each = (int64_t)vv_type_bytes(info->type), *n = all.n;
        copy_rows(data, &f.brick);
        packed = (vv_brick){.stride = {each, each * n[0], each * n[0] * n[1]}, .box = all};
        if (axis >= 0)
            turn(&f.brick, axis), turn(&packed, axis);
        if ((st = find_holes(&f, p, info)) == VV_OK)
            st = fill(data, packed.stride, &f);
    }
    vv_brick_release(&f.brick);
    vvi_runs_finish(&f.runs);
    vvi_label_set_finish(&f.labels);
    vvi_label_set_finish(&f.pairs);
    vvi_free(f.open);
    vvi_free(f.key_of);
    vvi_free(f.faces_of);
    vvi_free(f.faces);
    if (st != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}

static uint64_t memory(const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    return vvi_runs_memory(&inputs[0], false);
}

const vv_operation vvi_operation_fill_holes = {
    .api = VV_OPERATION_API,
    .name = "fill-holes",
    .component = "segment",
    .group = "morphology",
    .doc =
        "background inside labels becomes the label that it touches most; background is 0, and a hole what no border "
        "of the volume is reached from",
    .example = "volvis fill-holes head.nrrd -o solid.nrrd --slices axial",
    .params = &fill_holes_class,
    .inputs = VV_ONE_VOLUME,
    .run = run,
    .plan = plan,
    .memory = memory,
    .carry = vv_carry_values,
};
