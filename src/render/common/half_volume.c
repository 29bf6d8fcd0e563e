/* Rows of two rows and two slices are folded into one as floats, and then its samples by twos. */
#include "render/common/half_volume.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "grid/field.h"
#include "grid/lattice.h"
#include <math.h>

enum { FEWEST = 8, ROWS = 4 };
#define SHARE 0.125f /* of a sample in its mean, so that no sum of eight is infinite */

typedef struct folding {
    const vvi_lattice *from;
    int64_t n[3];   /* samples that are made */
    bool halved[3]; /* axes */
    void *to;
    vvi_halving halving;
} folding;

static bool is_halved(int64_t n)
{
    return n > FEWEST;
}

/* Rows ------------------------------------------------------------------------------------------------------------ */

#define READ(sample, ctype)                                                                                            \
    case sample:                                                                                                       \
        for (int64_t i = 0; i < n; i++)                                                                                \
            out[i] = (float)((const ctype *)g->data)[at + i];                                                          \
        break

static void read_row(float *restrict out, const vvi_lattice *g, int64_t j, int64_t k)
{
    const int64_t n = g->n[0], at = k * g->slice + j * g->row;
    switch (g->sample_type) {
        READ(VVI_SAMPLE_U8, uint8_t);
        READ(VVI_SAMPLE_U16, uint16_t);
        READ(VVI_SAMPLE_I16, int16_t);
        READ(VVI_SAMPLE_F32, float);
    }
}

#define WRITE(sample, ctype, value)                                                                                    \
    case sample:                                                                                                       \
        for (int64_t i = 0; i < n; i++)                                                                                \
            ((ctype *)f->to)[at + i] = (ctype)(value);                                                                 \
        break

static void write_row(const folding *f, const float *restrict row, int64_t j, int64_t k)
{
    const int64_t n = f->n[0], at = (k * f->n[1] + j) * n;
    switch (f->from->sample_type) {
        WRITE(VVI_SAMPLE_U8, uint8_t, row[i] + 0.5f);
        WRITE(VVI_SAMPLE_U16, uint16_t, row[i] + 0.5f);
        WRITE(VVI_SAMPLE_I16, int16_t, floorf(row[i] + 0.5f));
        WRITE(VVI_SAMPLE_F32, float, row[i]);
    }
}

/* Of a mean `seen` counts the numbers; what is no number is passed over by comparisons as well. */
static void fold(float *restrict to, float *restrict seen, const float *restrict row, int64_t n, vvi_halving halving)
{
    switch (halving) {
    case VVI_HALVE_MEAN:
        for (int64_t i = 0; i < n; i++) {
            const bool number = row[i] == row[i];
            to[i] += number ? SHARE * row[i] : 0;
            seen[i] += number ? SHARE : 0;
        }
        break;
    case VVI_HALVE_LARGEST:
        for (int64_t i = 0; i < n; i++) {
            to[i] = row[i] > to[i] ? row[i] : to[i];
            seen[i] = row[i] == row[i] ? 1 : seen[i];
        }
        break;
    case VVI_HALVE_SMALLEST:
        for (int64_t i = 0; i < n; i++) {
            to[i] = row[i] < to[i] ? row[i] : to[i];
            seen[i] = row[i] == row[i] ? 1 : seen[i];
        }
        break;
    }
}

static float of_two(float a, float b, vvi_halving halving)
{
    return halving == VVI_HALVE_MEAN ? a + b : halving == VVI_HALVE_LARGEST ? fmaxf(a, b) : fminf(a, b);
}

/* Samples by twos, in place; the last of an odd number stands alone. */
static void fold_along(float *to, const float *seen, const folding *f)
{
    const int64_t last = f->from->n[0] - 1;
    const bool mean = f->halving == VVI_HALVE_MEAN;
    for (int64_t i = 0; i < f->n[0]; i++) {
        const int64_t a = f->halved[0] ? 2 * i : i, b = f->halved[0] && a < last ? a + 1 : a;
        const float sum = a == b ? to[a] : of_two(to[a], to[b], f->halving);
        const float numbers = a == b ? seen[a] : seen[a] + seen[b];
        to[i] = numbers == 0 ? NAN : mean ? sum / numbers : sum;
    }
}

/* Slices ---------------------------------------------------------------------------------------------------------- */

typedef struct room {
    const folding *f;
    vv_job *job;
} room;

static vv_status start(void **scratch, void *user, int worker)
{
    const room *r = user;
    const size_t bytes = 3 * (size_t)r->f->from->n[0] * sizeof(float);
    (void)worker;
    *scratch = vvi_alloc(r->job, bytes, VVI_MEM_SCRATCH);
    return *scratch ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

/* The first and last sample of an axis that become number `at`. */
static void pair(int64_t out[2], const folding *f, int axis, int64_t at)
{
    const int64_t last = f->from->n[axis] - 1;
    out[0] = f->halved[axis] ? 2 * at : at;
    out[1] = f->halved[axis] && out[0] < last ? out[0] + 1 : out[0];
}

/* Item: one slice of what is made. */
static vv_status halve_slice(void *scratch, void *user, size_t k)
{
    const room *r = user;
    const folding *f = r->f;
    const int64_t n = f->from->n[0];
    const float none = f->halving == VVI_HALVE_MEAN ? 0 : f->halving == VVI_HALVE_LARGEST ? -INFINITY : INFINITY;
    float *to = scratch, *seen = to + n, *row = seen + n;
    int64_t slices[2], rows[2];
    pair(slices, f, 2, (int64_t)k);
    for (int64_t j = 0; j < f->n[1]; j++) {
        pair(rows, f, 1, j);
        for (int64_t i = 0; i < n; i++) {
            to[i] = none;
            seen[i] = 0;
        }
        for (int64_t z = slices[0]; z <= slices[1]; z++)
            for (int64_t y = rows[0]; y <= rows[1]; y++) {
                read_row(row, f->from, y, z);
                fold(to, seen, row, n, f->halving);
            }
        fold_along(to, seen, f);
        write_row(f, to, j, (int64_t)k);
    }
    return vvi_job_poll(r->job);
}

/* Fields ---------------------------------------------------------------------------------------------------------- */

static vv_type type_of(int sample_type)
{
    static const vv_type types[VVI_SAMPLE_TYPES] = {[VVI_SAMPLE_U8] = VV_TYPE_U8,
                                                    [VVI_SAMPLE_U16] = VV_TYPE_U16,
                                                    [VVI_SAMPLE_I16] = VV_TYPE_I16,
                                                    [VVI_SAMPLE_F32] = VV_TYPE_F32};
    return types[sample_type];
}

/* Number 0 of what is made lies between 0 and 1 of what was there. */
static vv_affine halved_place(vv_affine m, const bool halved[3])
{
    for (int a = 0; a < 3; a++)
        if (halved[a]) {
            m.origin = vvi_add(m.origin, vvi_scaled(m.axis[a], 0.5));
            m.axis[a] = vvi_scaled(m.axis[a], 2);
        }
    return m;
}

typedef struct making {
    const vv_field *field;
    int component;
    vvi_halving halving;
} making;

static vv_status fill(vv_field **out, uint64_t *bytes_out, const making *m, const vvi_lattice_hold *hold, vv_job *job)
{
    static const vvi_work work = {.stage = "reducing", .start = start, .item = halve_slice, .finish = finish};
    folding f = {.from = &hold->lattice, .halving = m->halving};
    vv_field_info info = *vv_field_get_info(m->field);
    for (int a = 0; a < 3; a++) {
        f.halved[a] = is_halved(info.grid.dims[a]);
        info.grid.dims[a] = f.n[a] = f.halved[a] ? (info.grid.dims[a] + 1) / 2 : info.grid.dims[a];
    }
    info.grid.index_to_world = halved_place(info.grid.index_to_world, f.halved);
    info.type = type_of(hold->lattice.sample_type);
    info.components = 1;
    info.meaning = VV_MEANING_SCALAR;
    info.value_scale = hold->value_scale;
    info.value_offset = hold->value_offset;
    vv_status st = vv_field_info_bytes(bytes_out, &info);
    if (st != VV_OK || (st = vv_field_new_empty(out, &f.to, &info, job)) != VV_OK)
        return st;
    st = vvi_parallel_for(job, &work, &(room){&f, job}, (size_t)f.n[2]);
    if (st != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const making *m = user;
    vvi_lattice_hold hold;
    vv_field *field = NULL;
    vv_status st = vvi_lattice_open(&hold, m->field, m->component, job);
    if (st != VV_OK)
        return st;
    st = fill(&field, bytes_out, m, &hold, job);
    vvi_lattice_close(&hold);
    *value_out = field;
    return st;
}

static void drop(void *value)
{
    vv_field_release(value);
}

static vv_status halve_field(vv_field **out, const making *m, vv_job *job)
{
    const uint64_t how = (uint64_t)m->component * 4 + (uint64_t)m->halving;
    const vvi_cache_key key = {"halved", vv_field_identity(m->field), how};
    vvi_cached *cached = NULL;
    making own = *m;
    const vv_status st = vvi_cache_get(&cached, &key, make, drop, &own, job);
    if (st != VV_OK)
        return st;
    *out = vv_field_retain(vvi_cached_value(cached));
    vvi_cache_release(cached);
    return VV_OK;
}

vv_status vvi_actor_halve(vv_actor *out, const vv_actor *actor, int times, vvi_halving halving, vv_job *job)
{
    vv_field *field = vv_field_retain(actor->field);
    vv_affine place = actor->index_to_world;
    int component = actor->component;
    for (int i = 0; i < times; i++) {
        const int64_t *n = vv_field_get_info(field)->grid.dims;
        const bool halved[3] = {is_halved(n[0]), is_halved(n[1]), is_halved(n[2])};
        vv_field *next = NULL;
        const vv_status st = halve_field(&next, &(making){field, component, halving}, job);
        vv_field_release(field);
        if (st != VV_OK)
            return st;
        place = halved_place(place, halved);
        field = next;
        component = 0;
    }
    *out = *actor;
    out->field = field;
    out->component = component;
    out->index_to_world = place;
    return VV_OK;
}

int vvi_halvings_to(const vv_field *field, int64_t most)
{
    const int64_t *dims = vv_field_get_info(field)->grid.dims;
    int64_t n[3] = {dims[0], dims[1], dims[2]};
    int times = 0;
    while ((double)n[0] * (double)n[1] * (double)n[2] > (double)most &&
           (is_halved(n[0]) || is_halved(n[1]) || is_halved(n[2]))) {
        for (int a = 0; a < 3; a++)
            n[a] = is_halved(n[a]) ? (n[a] + 1) / 2 : n[a];
        times++;
    }
    return times;
}
