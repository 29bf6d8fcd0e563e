#include "segment/distance_object.h"
#include "core/findings.h"
#include "core/memory.h"
#include "filter/sample_keys.h"
#include "grid/label_id.h"

#include <math.h>
#include <string.h>

bool vvi_distance_given(const vvi_distance_params *p)
{
    return p->range && *p->range;
}

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

vv_status vvi_distance_choose(vvi_distance_object *o, const vvi_distance_params *p, const vv_field_info *info,
                              vv_job *job)
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
    if (vvi_distance_given(p) && (st = vvi_value_range_parse(&range, p->range, "distance: range")) == VV_OK) {
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
static void part_of_row(uint8_t *out, const vvi_distance_object *o, const char *samples, int64_t n)
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

void vvi_distance_set_row(uint8_t *out, size_t row, void *user)
{
    vvi_distance_object *o = user;
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

void vvi_distance_tell(const vvi_distance_object *o, int side, uint64_t n_voxels, vv_job *job)
{
    const uint64_t inside = atomic_load(&o->n_inside);
    vvi_find_count(job, "object_voxels", inside);
    vvi_find_phrase(job, "from an object of %llu voxels", (unsigned long long)inside);
    if (inside == 0 && side != VVI_DISTANCE_INSIDE)
        vvi_find_note(job, "no voxel is of the object, so that all distances from it are infinite");
    if (inside == n_voxels && side != VVI_DISTANCE_OUTSIDE)
        vvi_find_note(job, "all voxels are of the object, so that all distances to its outside are infinite");
}
