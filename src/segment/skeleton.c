/* Skeleton: labels thinned to curves in their middle that hang together as they do (Lee, Kashyap & Chu 1994). Layers
 * are taken off from one side after the other. What may go is found for all voxels of a side at once; then it goes
 * voxel by voxel, where it still may: so nothing depends on the number of threads. */
#include "core/findings.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "registry.h"
#include "segment/label_result.h"
#include "segment/simple_points.h"
#include "segment/value_range.h"

#include <stdlib.h>
#include <string.h>

enum { ITEM = 2048, VOXELS_BETWEEN_LOOKS = 1 << 14, SIDES = 6 };

typedef struct skeleton_params {
    vv_object object;
    char *range;
} skeleton_params;

static const vv_property properties[] = {
    {VV_PROP(skeleton_params, range), .kind = VV_KIND_STRING, .automatic = "each label by itself",
     .doc = "values of the one object that is thinned, both ends included: 100..200, 100.. or ..200"},
    {0},
};

static bool given(const skeleton_params *p)
{
    return p->range && *p->range;
}

static vv_status check(const vv_object *object, const char *path)
{
    const skeleton_params *p = (const skeleton_params *)object;
    vvi_value_range range;
    (void)path;
    return given(p) ? vvi_value_range_parse(&range, p->range, "skeleton: range") : VV_OK;
}

static const vv_class skeleton_class = {
    .name = "skeleton",
    .doc = "parameters of skeleton",
    .size = sizeof(skeleton_params),
    .properties = properties,
    .check = check,
};

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const skeleton_params *p = (const skeleton_params *)params;
    (void)n_inputs;
    if (given(p))
        *out = vvi_label_result(&inputs[0], VV_TYPE_U8);
    else
        *out = inputs[0];
    const vv_status st = vvi_label_need_one_component(&inputs[0], "skeleton");
    if (st == VV_OK && !given(p) && vv_type_is_float(inputs[0].type))
        return vv_fail(VV_E_UNSUPPORTED, "skeleton: the values are real numbers, and no labels; give those inside with "
                                         "--range LO..HI");
    if (st == VV_OK && !given(p) && inputs[0].value_offset != 0)
        return vv_fail(VV_E_UNSUPPORTED,
                       "skeleton: values have an offset, %g, and are no labels; give those inside with "
                       "--range LO..HI",
                       inputs[0].value_offset);
    return st == VV_OK ? check(params, NULL) : st;
}

/* A list of voxels, ascending. */
typedef struct list {
    int64_t *v;
    size_t n, room;
} list;

typedef struct thinning {
    char *label; /* of the result */
    size_t each;
    int64_t n[3], offset[VVI_AROUND];
    uint8_t *listed; /* a bit a voxel: it is in one of the lists */
    list border, fresh, merged;
    uint8_t *goes; /* by number in the border */
    size_t goes_room;
    int side;
    uint64_t n_object, n_gone;
    vv_job *job;
} thinning;

static uint64_t label_at(const thinning *t, int64_t at)
{
    switch (t->each) {
    case 1:
        return ((const uint8_t *)t->label)[at];
    case 2:
        return ((const uint16_t *)(const void *)t->label)[at];
    case 4:
        return ((const uint32_t *)(const void *)t->label)[at];
    default:
        return ((const uint64_t *)(const void *)t->label)[at];
    }
}

#define BITS_OF(type)                                                                                                  \
    do {                                                                                                               \
        const type *own = (const type *)(const void *)t->label + at, label = *own;                                     \
        for (int b = 0; b < VVI_AROUND; b++)                                                                           \
            bits |= (uint32_t)(own[t->offset[b]] == label) << b;                                                       \
    } while (0)

/* Of a voxel whose neighbours are all in the volume. */
static uint32_t object_inside(const thinning *t, int64_t at)
{
    uint32_t bits = 0;
    if (t->each == 1)
        BITS_OF(uint8_t);
    else if (t->each == 2)
        BITS_OF(uint16_t);
    else if (t->each == 4)
        BITS_OF(uint32_t);
    else
        BITS_OF(uint64_t);
    return bits;
}

/* Beyond the border of the volume there is nothing. */
static uint32_t object_around(const thinning *t, int64_t at)
{
    const int64_t *n = t->n, row = at / n[0], p[3] = {at - row * n[0], row % n[1], row / n[1]};
    const uint64_t label = label_at(t, at);
    uint32_t bits = 0;
    if (p[0] > 0 && p[0] < n[0] - 1 && p[1] > 0 && p[1] < n[1] - 1 && p[2] > 0 && p[2] < n[2] - 1)
        return object_inside(t, at);
    for (int b = 0; b < VVI_AROUND; b++) {
        const int64_t x = p[0] + b % 3 - 1, y = p[1] + b / 3 % 3 - 1, z = p[2] + b / 9 - 1;
        if (x >= 0 && x < n[0] && y >= 0 && y < n[1] && z >= 0 && z < n[2])
            bits |= (uint32_t)(label_at(t, at + t->offset[b]) == label) << b;
    }
    return bits;
}

/* Bits of the neighbours at faces, two for each axis. */
static const int side_bit[SIDES] = {4, 22, 10, 16, 12, 14};

/* Whether the neighbour at the face that is worked on is there, and of the same label. */
static bool is_covered(const thinning *t, int64_t at)
{
    const int axis = 2 - t->side / 2;
    const int64_t stride = axis == 0 ? 1 : axis == 1 ? t->n[0] : t->n[0] * t->n[1], place = at / stride % t->n[axis];
    const bool inside = t->side % 2 == 0 ? place > 0 : place + 1 < t->n[axis];
    return inside && label_at(t, at + t->offset[side_bit[t->side]]) == label_at(t, at);
}

static bool may_go(const thinning *t, int64_t at)
{
    if (is_covered(t, at))
        return false;
    const uint32_t object = object_around(t, at), others = object & ~(1u << VVI_AROUND_OWN);
    const bool is_end = (others & (others - 1)) == 0; /* of a curve: one neighbour, or none */
    return !is_end && vvi_is_simple(object);
}

static vv_status look_item(void *scratch, void *user, size_t index)
{
    const thinning *t = user;
    const size_t first = index * ITEM, end = first + ITEM < t->border.n ? first + ITEM : t->border.n;
    for (size_t i = first; i < end; i++)
        t->goes[i] = may_go(t, t->border.v[i]);
    return vvi_job_poll(t->job);
}

/* Lists ----------------------------------------------------------------------------------------------------------- */

static vv_status make_room(list *l, size_t n, vv_job *job)
{
    if (n <= l->room)
        return VV_OK;
    const size_t room = n + n / 2 + 1024;
    int64_t *more = vvi_realloc(job, l->v, room * sizeof *more, VVI_MEM_SCRATCH);
    if (!more)
        return vv_fail_memory(room * sizeof *more);
    l->v = more;
    l->room = room;
    return VV_OK;
}

static vv_status append(thinning *t, list *l, int64_t at)
{
    const vv_status st = make_room(l, l->n + 1, t->job);
    if (st != VV_OK)
        return st;
    l->v[l->n++] = at;
    t->listed[at / 8] |= (uint8_t)(1u << at % 8);
    return VV_OK;
}

static int ascending(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

/* What is gone leaves the border, and what lay behind it comes. */
static vv_status renew_border(thinning *t)
{
    list *b = &t->border, *f = &t->fresh, *m = &t->merged;
    const vv_status st = make_room(m, b->n + f->n, t->job);
    size_t i = 0, j = 0;
    if (st != VV_OK)
        return st;
    if (f->n > 1)
        qsort(f->v, f->n, sizeof *f->v, ascending);
    m->n = 0;
    while (i < b->n || j < f->n) {
        const int64_t at = j >= f->n || (i < b->n && b->v[i] < f->v[j]) ? b->v[i++] : f->v[j++];
        if (label_at(t, at) != 0)
            m->v[m->n++] = at;
    }
    const list old = *b;
    *b = *m;
    *m = old;
    f->n = 0;
    return VV_OK;
}

static vv_status find_border(thinning *t)
{
    const int64_t all = t->n[0] * t->n[1] * t->n[2];
    vv_status st = VV_OK;
    for (int64_t at = 0; at < all && st == VV_OK; at++) {
        if (at % VOXELS_BETWEEN_LOOKS == 0 && (st = vvi_job_poll(t->job)) != VV_OK)
            return st;
        if (label_at(t, at) == 0)
            continue;
        t->n_object++;
        if (VVI_AROUND_BESIDE & ~object_around(t, at))
            st = append(t, &t->border, at);
    }
    return st;
}

/* Thinning -------------------------------------------------------------------------------------------------------- */

static vv_status remove_voxel(thinning *t, int64_t at)
{
    const uint32_t object = object_around(t, at);
    vv_status st = VV_OK;
    memset(t->label + (size_t)at * t->each, 0, t->each);
    t->n_gone++;
    for (int s = 0; s < SIDES && st == VV_OK; s++) {
        const int64_t next = at + t->offset[side_bit[s]];
        if (object >> side_bit[s] & 1 && !(t->listed[next / 8] >> next % 8 & 1))
            st = append(t, &t->fresh, next);
    }
    return st;
}

static vv_status thin_side(bool *changed, thinning *t)
{
    static const vvi_work work = {.item = look_item};
    const size_t n = t->border.n;
    if (n > t->goes_room) {
        vvi_free(t->goes);
        t->goes_room = n + n / 2;
        if (!(t->goes = vvi_alloc(t->job, t->goes_room, VVI_MEM_SCRATCH)))
            return vv_fail_memory(t->goes_room);
    }
    vv_status st = vvi_parallel_for(t->job, &work, t, (n + ITEM - 1) / ITEM);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        if (i % VOXELS_BETWEEN_LOOKS == 0)
            st = vvi_job_progress(t->job, "thin", t->n_gone, t->n_object);
        if (st != VV_OK || !t->goes[i] || !vvi_is_simple(object_around(t, t->border.v[i])))
            continue;
        st = remove_voxel(t, t->border.v[i]);
        *changed = true;
    }
    return st == VV_OK ? renew_border(t) : st;
}

/* Along axes of one sample there are no layers. */
static vv_status thin(thinning *t)
{
    vv_status st = find_border(t);
    for (bool changed = true; changed && st == VV_OK;) {
        changed = false;
        for (t->side = 0; t->side < SIDES && st == VV_OK; t->side++)
            if (t->n[2 - t->side / 2] > 1)
                st = thin_side(&changed, t);
    }
    if (st != VV_OK)
        return st;
    vvi_find_count(t->job, "voxels", t->n_object - t->n_gone);
    vvi_find_phrase(t->job, "%llu of %llu voxels are left", (unsigned long long)(t->n_object - t->n_gone),
                    (unsigned long long)t->n_object);
    return vvi_job_progress(t->job, "thin", t->n_object, t->n_object);
}

static vv_status thin_labels(void *data, const vv_field_info *info, vv_job *job)
{
    thinning t = {.label = data, .each = vv_type_bytes(info->type), .job = job};
    memcpy(t.n, info->grid.dims, sizeof t.n);
    for (int b = 0; b < VVI_AROUND; b++)
        t.offset[b] = b % 3 - 1 + t.n[0] * (b / 3 % 3 - 1 + t.n[1] * (b / 9 - 1));
    const size_t bytes = (size_t)(t.n[0] * t.n[1] * t.n[2]) / 8 + 1;
    vv_status st = vvi_memory_plan(job, bytes, "skeleton");
    if (st == VV_OK && !(t.listed = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH)))
        st = vv_fail_memory(bytes);
    if (st == VV_OK)
        st = thin(&t);
    vvi_free(t.listed);
    vvi_free(t.border.v);
    vvi_free(t.fresh.v);
    vvi_free(t.merged.v);
    vvi_free(t.goes);
    return st;
}

/* The row --------------------------------------------------------------------------------------------------------- */

typedef struct shared {
    vv_brick brick;
    bool by_range;
    vvi_key_range range;
    char *out;
    vv_job *job;
} shared;

static vv_status load_item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_brick *b = &s->brick;
    const int64_t *n = b->box.n, k = (int64_t)index;
    const size_t each = s->by_range ? 1 : vv_type_bytes(b->type);
    for (int64_t j = 0; j < n[1]; j++) {
        const char *row = (const char *)b->data + j * b->stride[1] + k * b->stride[2];
        char *out = s->out + (size_t)((k * n[1] + j) * n[0]) * each;
        if (s->by_range)
            vvi_key_range_row((uint8_t *)out, row, b->stride[0], b->type, &s->range, n[0]);
        else
            for (int64_t i = 0; i < n[0]; i++)
                memcpy(out + (size_t)i * each, row + i * b->stride[0], each);
    }
    return vvi_job_poll(s->job);
}

static vv_status load(void *data, const vv_field *in, const skeleton_params *p, vv_job *job)
{
    static const vvi_work work = {.stage = "load", .item = load_item};
    const vv_field_info *info = vv_field_get_info(in);
    const vv_box all = vv_field_box(in);
    shared s = {.by_range = given(p), .out = data, .job = job};
    vvi_value_range range;
    vv_status st = VV_OK;
    if (s.by_range && (st = vvi_value_range_parse(&range, p->range, "skeleton: range")) == VV_OK) {
        range = vvi_value_range_as_typed(&range, info);
        s.range = vvi_key_range_of(&range, info);
    }
    if (st == VV_OK && (st = vv_field_brick(&s.brick, in, &all, job)) == VV_OK)
        st = vvi_parallel_for(job, &work, &s, (size_t)all.n[2]);
    vv_brick_release(&s.brick);
    return st;
}

static vv_status run(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                     vv_job *job)
{
    vv_field_info info;
    vv_field *field = NULL;
    void *data;
    *out = NULL;
    vv_status st = plan(&info, vv_field_get_info(inputs[0]), n_inputs, params);
    if (st != VV_OK || (st = vv_field_new_empty(&field, &data, &info, job)) != VV_OK)
        return st;
    if ((st = load(data, inputs[0], (const skeleton_params *)params, job)) == VV_OK &&
        (st = thin_labels(data, &info, job)) == VV_OK)
        *out = vv_field_retain(field);
    vv_field_release(field);
    return st;
}

/* Labels keep their names; what values are thinned to is a new one. */
static vv_status carry(vv_carry *carried, const vv_object *params)
{
    carried->new_values |= given((const skeleton_params *)params);
    return VV_OK;
}

static uint64_t memory(const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const int64_t *n = inputs[0].grid.dims;
    const uint64_t voxels = (uint64_t)(n[0] * n[1] * n[2]);
    return voxels / 8 +
           voxels * 5 / 2; /* a bit of each, and places of those at borders: some sixth of them, in two lists */
}

const vv_operation vvi_operation_skeleton = {
    .api = VV_OPERATION_API,
    .name = "skeleton",
    .component = "segment",
    .group = "morphology",
    .doc = "thin labels to curves along their middle, one voxel thick, that hang together as the labels do; each label "
           "separately (Lee, Kashyap & Chu 1994)",
    .example = "volvis skeleton head.nrrd -o curves.nrrd --range 150..",
    .params = &skeleton_class,
    .inputs = VV_ONE_VOLUME,
    .run = run,
    .plan = plan,
    .memory = memory,
    .carry = carry,
};
