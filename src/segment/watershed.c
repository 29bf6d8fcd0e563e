/* Watershed: each voxel to the basin that water would reach it from, from markers or from the minima of the values. */
#include "core/findings.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/sample_keys.h"
#include "grid/field.h"
#include "grid/same_grid.h"
#include "registry.h"
#include "segment/connectivity.h"
#include "segment/flood.h"
#include "segment/label_result.h"
#include "segment/part_sizes.h"
#include "segment/value_range.h"

#include <math.h>
#include <string.h>

#define VOXELS_MOST 0xfffffffdLL

typedef struct watershed_params {
    vv_object object;
    double depth;
    bool bright, lines;
    char *range;
    int connectivity;
} watershed_params;

enum { VOLUME, MARKERS, MASK, INPUTS };

static const vv_property properties[] = {
    {VV_PROP(watershed_params, depth), .kind = VV_KIND_F64, .unit = "value", .limited = true, .min = 0, .max = 1e300,
     .doc = "without markers: a basin less deep than this, from its lowest value to where it flows over, becomes part "
            "of the one it flows into"},
    {VV_PROP(watershed_params, bright), .kind = VV_KIND_BOOL,
     .doc = "basins are bright, around maxima, and borders dark"},
    {VV_PROP(watershed_params, lines), .kind = VV_KIND_BOOL, .doc = "leave 0 between basins that touch"},
    {VV_PROP(watershed_params, range), .kind = VV_KIND_STRING, .automatic = "all values",
     .doc = "values that are flooded, both ends included: 100..200, 100.. or ..200; others stay 0"},
    VVI_CONNECTIVITY_PROPERTY(watershed_params, connectivity, "a basin"),
    {0},
};

static bool given(const watershed_params *p)
{
    return p->range && *p->range;
}

static vv_status check(const vv_object *object, const char *path)
{
    const watershed_params *p = (const watershed_params *)object;
    vvi_value_range range;
    (void)path;
    return given(p) ? vvi_value_range_parse(&range, p->range, "watershed: range") : VV_OK;
}

static const vv_class watershed_class = {
    .name = "watershed",
    .doc = "parameters of watershed",
    .size = sizeof(watershed_params),
    .properties = properties,
    .check = check,
};

static vv_status check_other(const vv_field_info *volume, const vv_field_info *other, const char *name)
{
    if (other->components != 1)
        return vv_fail(VV_E_UNSUPPORTED,
                       "watershed: %s: expected one channel, found %d; pick one with `volvis channel`", name,
                       other->components);
    const vv_status st = vvi_grid_alike(&volume->grid, &other->grid, name);
    return st == VV_OK ? st : vv_fail_in(st, "watershed");
}

static bool is_there(const vv_field_info *inputs, size_t n_inputs, size_t index)
{
    return index < n_inputs && inputs[index].components > 0;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const watershed_params *p = (const watershed_params *)params;
    static const char *const names[INPUTS] = {"volume", "markers", "mask"};
    const int64_t *d = inputs[0].grid.dims;
    *out = vvi_label_result(&inputs[0], VV_TYPE_U32);
    vv_status st = vvi_label_need_one_component(&inputs[0], "watershed");
    if (st == VV_OK && inputs[0].meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "watershed: labels are names, not amounts, and have no basins; a `volvis "
                                         "distance --side inside` of them does");
    if (st == VV_OK && (double)d[0] * (double)d[1] * (double)d[2] > (double)VOXELS_MOST)
        return vv_fail(VV_E_LIMIT,
                       "watershed: %lldx%lldx%lld samples are more than it can number, %lld: crop or "
                       "resample the volume",
                       (long long)d[0], (long long)d[1], (long long)d[2], VOXELS_MOST);
    for (size_t i = MARKERS; i < INPUTS && st == VV_OK; i++)
        if (is_there(inputs, n_inputs, i))
            st = check_other(&inputs[0], &inputs[i], names[i]);
    if (st == VV_OK && is_there(inputs, n_inputs, MARKERS) && vv_object_is_set(params, "depth"))
        return vv_fail(VV_E_ARGUMENT, "watershed: with markers there is a basin for each of them, and `depth` does "
                                      "nothing: leave it out");
    return st == VV_OK ? check(&p->object, NULL) : st;
}

/* Heights --------------------------------------------------------------------------------------------------------- */

typedef struct shared {
    const watershed_params *p;
    const vv_field_info *info[INPUTS]; /* NULL: it is not there */
    vv_brick brick[INPUTS];
    int64_t n[3];
    bool down;                      /* the greatest stored number is the lowest height */
    vvi_key_range range, zero, any; /* of the volume; of the mask */
    uint32_t *label, *next;
    uint32_t *narrow;
    int64_t *wide;
    int64_t *slice_lo, *slice_hi; /* heights, by slice */
    vv_job *job;
} shared;

static size_t key_bytes(const shared *s)
{
    return vv_type_bytes(s->info[VOLUME]->type);
}

static bool is_wide(const shared *s)
{
    return key_bytes(s) == 8;
}

/* Keys begin at 0 there, so that the complement turns them round. */
static int64_t height_of_key(const shared *s, int64_t key)
{
    if (key == -1 && vv_type_is_float(s->info[VOLUME]->type))
        key = 0; /* -0 is as high as 0 */
    if (is_wide(s))
        return s->down ? ~key : key;
    const uint32_t up = (uint32_t)(key + (int64_t)0x80000000);
    return s->down ? ~up : up;
}

static int64_t key_of_height(const shared *s, int64_t height)
{
    if (is_wide(s))
        return s->down ? ~height : height;
    const uint32_t up = s->down ? ~(uint32_t)height : (uint32_t)height;
    return (int64_t)up - (int64_t)0x80000000;
}

static double value_of_height(const void *user, int64_t height)
{
    const shared *s = user;
    char sample[8];
    double v;
    vvi_sample_of_key(sample, key_of_height(s, height), s->info[VOLUME]->type);
    vvi_samples_to_f64(&v, sample, s->info[VOLUME]->type, 1);
    return (s->down ? -1 : 1) * v * fabs(s->info[VOLUME]->value_scale);
}

static const char *row_of(const shared *s, int input, int64_t j, int64_t k)
{
    const vv_brick *b = &s->brick[input];
    return (const char *)b->data + j * b->stride[1] + k * b->stride[2];
}

/* A row's room: keys, whether each voxel is flooded, whether the mask has 0, markers. */
typedef struct scratch {
    char *keys;
    uint8_t *inside, *other;
    double *marker;
} scratch;

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t n = (size_t)s->n[0], bytes = sizeof(scratch) + n * (8 + 8 + 2);
    scratch *own = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    (void)worker;
    if (!own)
        return vv_fail_memory(bytes);
    own->marker = (double *)(own + 1);
    own->keys = (char *)(own->marker + n);
    own->inside = (uint8_t *)own->keys + 8 * n;
    own->other = own->inside + n;
    *scratch_out = own;
    return VV_OK;
}

static void finish(void *scratch_in, void *user)
{
    (void)user;
    vvi_free(scratch_in);
}

static void find_inside(scratch *own, const shared *s, int64_t j, int64_t k)
{
    const vv_brick *v = &s->brick[VOLUME], *m = &s->brick[MASK];
    vvi_key_range_row(own->inside, row_of(s, VOLUME, j, k), v->stride[0], v->type, &s->range, s->n[0]);
    if (!s->info[MASK])
        return;
    vvi_key_range_row(own->other, row_of(s, MASK, j, k), m->stride[0], m->type, &s->any, s->n[0]);
    for (int64_t i = 0; i < s->n[0]; i++)
        own->inside[i] &= own->other[i];
    vvi_key_range_row(own->other, row_of(s, MASK, j, k), m->stride[0], m->type, &s->zero, s->n[0]);
    for (int64_t i = 0; i < s->n[0]; i++)
        own->inside[i] &= !own->other[i];
}

static vv_status take_markers(uint32_t *label, const scratch *own, const shared *s, int64_t j, int64_t k)
{
    const vv_brick *b = &s->brick[MARKERS];
    const vv_field_info *info = s->info[MARKERS];
    const char *row = row_of(s, MARKERS, j, k);
    for (int64_t i = 0; i < s->n[0]; i++) {
        double v;
        vvi_samples_to_f64(&v, row + i * b->stride[0], b->type, 1);
        v = v * info->value_scale + info->value_offset;
        if (!(v >= 0 && v < VVI_FLOOD_OUTSIDE && v == floor(v)))
            return vv_fail(VV_E_ARGUMENT,
                           "watershed: markers: expected labels, whole numbers from 0 to %u, found %.17g at sample "
                           "%lld, %lld, %lld",
                           VVI_FLOOD_OUTSIDE - 1, v, (long long)i, (long long)j, (long long)k);
        if (own->inside[i])
            label[i] = (uint32_t)v;
    }
    return VV_OK;
}

static void take_heights(int64_t at, scratch *own, shared *s, int64_t j, int64_t k)
{
    const vv_brick *b = &s->brick[VOLUME];
    int64_t lo = s->slice_lo[k], hi = s->slice_hi[k];
    vvi_keys_of_samples(own->keys, row_of(s, VOLUME, j, k), b->stride[0], b->type, s->n[0]);
    for (int64_t i = 0; i < s->n[0]; i++) {
        const int64_t height = height_of_key(s, vvi_key_at(own->keys, i, b->type));
        if (s->wide)
            s->wide[at + i] = height;
        else
            s->narrow[at + i] = (uint32_t)height;
        s->label[at + i] = own->inside[i] ? VVI_FLOOD_NONE : VVI_FLOOD_OUTSIDE;
        if (own->inside[i]) {
            lo = height < lo ? height : lo;
            hi = height > hi ? height : hi;
        }
    }
    s->slice_lo[k] = lo;
    s->slice_hi[k] = hi;
}

static vv_status slice_item(void *scratch_in, void *user, size_t index)
{
    shared *s = user;
    scratch *own = scratch_in;
    const int64_t k = (int64_t)index;
    vv_status st = VV_OK;
    s->slice_lo[k] = INT64_MAX;
    s->slice_hi[k] = INT64_MIN;
    for (int64_t j = 0; j < s->n[1] && st == VV_OK; j++) {
        const int64_t at = (k * s->n[1] + j) * s->n[0];
        find_inside(own, s, j, k);
        take_heights(at, own, s, j, k);
        if (s->info[MARKERS])
            st = take_markers(s->label + at, own, s, j, k);
        if (st == VV_OK)
            st = vvi_job_poll(s->job);
    }
    return st;
}

/* False where nothing is flooded. */
static bool find_ends(vvi_heights *out, const shared *s)
{
    *out = (vvi_heights){.narrow = s->narrow, .wide = s->wide, .lo = INT64_MAX, .hi = INT64_MIN};
    for (int64_t k = 0; k < s->n[2]; k++) {
        out->lo = s->slice_lo[k] < out->lo ? s->slice_lo[k] : out->lo;
        out->hi = s->slice_hi[k] > out->hi ? s->slice_hi[k] : out->hi;
    }
    return out->lo <= out->hi;
}

/* Basins of minima ------------------------------------------------------------------------------------------------ */

static int64_t voxels(const shared *s)
{
    return s->n[0] * s->n[1] * s->n[2];
}

static vv_status begin_basins(vvi_basins *b, const shared *s, const vvi_heights *heights)
{
    const size_t n = (size_t)b->n + 1;
    b->parent = vvi_alloc(s->job, n * sizeof *b->parent, VVI_MEM_SCRATCH);
    b->bottom = vvi_alloc(s->job, n * sizeof *b->bottom, VVI_MEM_SCRATCH);
    if (!b->parent || !b->bottom)
        return vv_fail_memory(n * (sizeof *b->parent + sizeof *b->bottom));
    for (uint32_t i = 0; i < n; i++)
        b->parent[i] = i;
    for (int64_t v = 0; v < voxels(s); v++)
        if (s->label[v] != VVI_FLOOD_NONE && s->label[v] < VVI_FLOOD_OUTSIDE)
            b->bottom[s->label[v]] = value_of_height(s, vvi_height_at(heights, v));
    return VV_OK;
}

/* The largest basin is 1; of equal ones that whose lowest voxels come first. Basins that became others have none. */
static vv_status number_basins(const shared *s, vvi_basins *b)
{
    const size_t bytes = ((size_t)b->n + 1) * sizeof(uint64_t);
    vvi_part_sizes sizes = {0};
    uint64_t *size = vvi_alloc_zeroed(s->job, bytes, VVI_MEM_SCRATCH);
    if (!size)
        return vv_fail_memory(bytes);
    for (int64_t v = 0; v < voxels(s); v++) {
        const uint32_t label = s->label[v];
        s->label[v] = label < VVI_FLOOD_OUTSIDE ? vvi_basins_root(b, label) : VVI_FLOOD_NONE;
        if (s->label[v] != VVI_FLOOD_NONE)
            size[s->label[v] - 1]++;
    }
    const vv_status st = vvi_part_sizes_rank(&sizes, size, b->n, 1, UINT32_MAX, s->job);
    for (int64_t v = 0; v < voxels(s) && st == VV_OK; v++)
        if (s->label[v] != VVI_FLOOD_NONE)
            s->label[v] = sizes.rank[s->label[v] - 1];
    if (st == VV_OK) {
        vvi_find_count(s->job, "minima", b->n);
        vvi_find_count(s->job, "basins", sizes.n_kept);
        vvi_find_phrase(s->job, "%u basin%s of %u minima", sizes.n_kept, sizes.n_kept == 1 ? "" : "s", b->n);
    }
    vvi_part_sizes_finish(&sizes);
    vvi_free(size);
    return st;
}

static vv_status flood_minima(shared *s, const vvi_heights *heights, const vvi_neighbours *around)
{
    vvi_basins b = {.depth = s->p->depth, .value = value_of_height, .user = s};
    vv_status st = vvi_minima_label(s->label, &b.n, heights, around, s->next, s->job);
    if (st == VV_OK && (st = begin_basins(&b, s, heights)) == VV_OK)
        st = vvi_flood(s->label, heights, around, s->p->lines, b.depth > 0 ? &b : NULL, s->next, s->job);
    if (st == VV_OK)
        st = number_basins(s, &b);
    vvi_free(b.parent);
    vvi_free(b.bottom);
    return st;
}

static vv_status flood_markers(shared *s, const vvi_heights *heights, const vvi_neighbours *around)
{
    uint64_t marked = 0, reached = 0;
    for (int64_t v = 0; v < voxels(s); v++)
        marked += s->label[v] != VVI_FLOOD_NONE && s->label[v] < VVI_FLOOD_OUTSIDE;
    if (marked == 0)
        return vv_fail(VV_E_ARGUMENT, "watershed: markers are 0 in all voxels that are flooded: there is no basin");
    const vv_status st = vvi_flood(s->label, heights, around, s->p->lines, NULL, s->next, s->job);
    for (int64_t v = 0; v < voxels(s); v++) {
        s->label[v] = s->label[v] < VVI_FLOOD_OUTSIDE ? s->label[v] : VVI_FLOOD_NONE;
        reached += s->label[v] != VVI_FLOOD_NONE;
    }
    vvi_find_count(s->job, "voxels", reached);
    vvi_find_phrase(s->job, "%llu voxels in basins", (unsigned long long)reached);
    return st;
}

/* The row --------------------------------------------------------------------------------------------------------- */

static vv_status set_ranges(shared *s)
{
    static const vvi_value_range anything = {-INFINITY, INFINITY}, nothing = {0, 0};
    vvi_value_range range = anything;
    vv_status st = VV_OK;
    if (given(s->p) && (st = vvi_value_range_parse(&range, s->p->range, "watershed: range")) == VV_OK)
        range = vvi_value_range_as_typed(&range, s->info[VOLUME]);
    s->range = vvi_key_range_of(&range, s->info[VOLUME]);
    if (s->info[MASK]) {
        s->any = vvi_key_range_of(&anything, s->info[MASK]);
        s->zero = vvi_key_range_of(&nothing, s->info[MASK]);
    }
    return st;
}

static vv_status flood(shared *s)
{
    static const vvi_work work = {.stage = "heights", .start = start, .item = slice_item, .finish = finish};
    const vvi_neighbours around = vvi_neighbours_of(s->n, s->p->connectivity + 1);
    vvi_heights heights;
    vv_status st = vvi_parallel_for(s->job, &work, s, (size_t)s->n[2]);
    if (st != VV_OK)
        return st;
    if (find_ends(&heights, s))
        return s->info[MARKERS] ? flood_markers(s, &heights, &around) : flood_minima(s, &heights, &around);
    memset(s->label, 0, (size_t)voxels(s) * sizeof *s->label);
    vvi_find_count(s->job, "basins", 0);
    vvi_find_phrase(s->job, "no basins: no voxel is flooded");
    return VV_OK;
}

static vv_status with_room(shared *s)
{
    const size_t n = (size_t)voxels(s), heights = n * (is_wide(s) ? 8 : 4), slices = (size_t)s->n[2] * sizeof(int64_t);
    vv_status st = vvi_memory_plan(s->job, (uint64_t)heights + n * sizeof *s->next + 2 * slices, "watershed");
    if (st != VV_OK)
        return st;
    void *room = vvi_alloc(s->job, heights, VVI_MEM_SCRATCH);
    s->next = vvi_alloc(s->job, n * sizeof *s->next, VVI_MEM_SCRATCH);
    s->slice_lo = vvi_alloc(s->job, 2 * slices, VVI_MEM_SCRATCH);
    s->slice_hi = s->slice_lo ? s->slice_lo + s->n[2] : NULL;
    if (is_wide(s))
        s->wide = room;
    else
        s->narrow = room;
    st = room && s->next && s->slice_lo ? flood(s) : vv_fail_memory(heights);
    vvi_free(room);
    vvi_free(s->next);
    vvi_free(s->slice_lo);
    return st;
}

static vv_status run(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                     vv_job *job)
{
    const vv_box all = vv_field_box(inputs[VOLUME]);
    vv_field_info infos[INPUTS] = {*vv_field_get_info(inputs[VOLUME])}, result;
    shared s = {.p = (const watershed_params *)params, .info = {&infos[VOLUME]}, .job = job};
    vv_field *field = NULL;
    void *data;
    *out = NULL;
    for (size_t i = MARKERS; i < n_inputs && i < INPUTS; i++)
        if (inputs[i]) {
            infos[i] = *vv_field_get_info(inputs[i]);
            s.info[i] = &infos[i];
        }
    vv_status st = plan(&result, infos, n_inputs, params);
    if (st != VV_OK || (st = set_ranges(&s)) != VV_OK ||
        (st = vv_field_new_empty(&field, &data, &result, job)) != VV_OK)
        return st;
    memcpy(s.n, result.grid.dims, sizeof s.n);
    s.label = data;
    s.down = s.p->bright != (infos[VOLUME].value_scale < 0);
    for (size_t i = 0; i < INPUTS && st == VV_OK; i++)
        if (s.info[i])
            st = vv_field_brick(&s.brick[i], inputs[i], &all, job);
    if (st == VV_OK)
        st = with_room(&s);
    for (size_t i = 0; i < INPUTS; i++)
        vv_brick_release(&s.brick[i]);
    if (st == VV_OK)
        *out = vv_field_retain(field);
    vv_field_release(field);
    return st;
}

static const vv_operand inputs_taken[] = {
    {"volume", VV_IS_FIELD, 1, 1, "the values, which are heights"},
    {"markers", VV_IS_FIELD, 0, 1,
     "labels from which basins are flooded, 0 elsewhere, on the same grid; without them each minimum is one"},
    {"mask", VV_IS_FIELD, 0, 1, "a volume on the same grid; where it is 0 nothing is flooded"},
    {0},
};

static uint64_t memory(const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const int64_t *n = inputs[0].grid.dims;
    const uint64_t all = (uint64_t)(n[0] * n[1] * n[2]);
    return all * (vv_type_bytes(inputs[0].type) == 8 ? 12 : 8);
}

const vv_operation vvi_operation_watershed = {
    .api = VV_OPERATION_API,
    .name = "watershed",
    .component = "segment",
    .group = "segmentation",
    .doc = "basins of the values: each voxel gets the label of the marker, or of the minimum, whose flood reaches it "
           "first (Meyer 1991)",
    .example = "volvis watershed head.nrrd -o basins.nrrd --bright --depth 100 --range 50..",
    .params = &watershed_class,
    .inputs = inputs_taken,
    .run = run,
    .plan = plan,
    .memory = memory,
};
