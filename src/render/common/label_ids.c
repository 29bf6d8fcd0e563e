/* Labels come in runs, so that each is looked for once a run. */
#include "render/common/label_ids.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Distinct ids, in a hash table with open places. */
typedef struct id_set {
    int64_t *key;
    uint32_t *number; /* 1 + that of the key; 0: the place is free */
    size_t n, room;   /* room: a power of 2 */
} id_set;

typedef struct finding {
    const vv_field *field;
    vv_brick brick;
    int component;
    id_set set;
    void *to; /* numbers: u16, or f32 */
    bool wide;
    vv_job *job;
} finding;

/* Sets ------------------------------------------------------------------------------------------------------------ */

static size_t place_of(const id_set *s, int64_t id)
{
    uint64_t h = (uint64_t)id;
    h = (h ^ h >> 32) * 0x9e3779b97f4a7c15u;
    size_t i = (size_t)(h >> 24) & (s->room - 1);
    while (s->number[i] && s->key[i] != id)
        i = (i + 1) & (s->room - 1);
    return i;
}

static void free_set(id_set *s)
{
    vvi_free(s->key);
    vvi_free(s->number);
    *s = (id_set){0};
}

static vv_status grow(id_set *s, vv_job *job)
{
    id_set grown = {.n = s->n, .room = s->room ? 2 * s->room : 1024};
    grown.key = vvi_alloc(job, grown.room * sizeof *grown.key, VVI_MEM_SCRATCH);
    grown.number = vvi_alloc_zeroed(job, grown.room * sizeof *grown.number, VVI_MEM_SCRATCH);
    if (!grown.key || !grown.number) {
        free_set(&grown);
        return vv_fail_memory(grown.room * 12);
    }
    for (size_t i = 0; i < s->room; i++)
        if (s->number[i]) {
            const size_t at = place_of(&grown, s->key[i]);
            grown.key[at] = s->key[i];
            grown.number[at] = s->number[i];
        }
    free_set(s);
    *s = grown;
    return VV_OK;
}

static vv_status add(id_set *s, int64_t id, vv_job *job)
{
    const vv_status st = 2 * s->n >= s->room ? grow(s, job) : VV_OK;
    if (st != VV_OK)
        return st;
    const size_t at = place_of(s, id);
    if (s->number[at])
        return VV_OK;
    if (s->n == VVI_LABEL_IDS_MOST)
        return vv_fail(VV_E_LIMIT,
                       "more than %d different labels, the most that can be told apart; if these are not labels, "
                       "segmentation.kind=transfer shows them as amounts",
                       VVI_LABEL_IDS_MOST);
    s->key[at] = id;
    s->number[at] = (uint32_t)++s->n;
    return VV_OK;
}

/* Rows ------------------------------------------------------------------------------------------------------------ */

static int64_t rounded(const char *at, vv_type type, const vv_field_info *info)
{
    double v;
    vvi_samples_to_f64(&v, at, type, 1);
    v = round(v * info->value_scale + info->value_offset);
    return v > -0x1p62 && v < 0x1p62 ? (int64_t)v : 0;
}

void vvi_label_read(int64_t *out, const vv_brick *b, int component, const vv_field_info *info, int64_t j, int64_t k)
{
    const char *at =
        (const char *)b->data + (size_t)component * vv_type_bytes(b->type) + j * b->stride[1] + k * b->stride[2];
    const bool plain = info->value_scale == 1 && info->value_offset == 0;
#define READ(ctype)                                                                                                    \
    for (int64_t i = 0; i < b->box.n[0]; i++) {                                                                        \
        ctype v;                                                                                                       \
        memcpy(&v, at + i * b->stride[0], sizeof v);                                                                   \
        out[i] = (int64_t)v;                                                                                           \
    }                                                                                                                  \
    break
    switch (plain ? b->type : VV_TYPE_F64) {
    case VV_TYPE_U8:
        READ(uint8_t);
    case VV_TYPE_I8:
        READ(int8_t);
    case VV_TYPE_U16:
        READ(uint16_t);
    case VV_TYPE_I16:
        READ(int16_t);
    case VV_TYPE_U32:
        READ(uint32_t);
    case VV_TYPE_I32:
        READ(int32_t);
    case VV_TYPE_U64:
        READ(uint64_t);
    case VV_TYPE_I64:
        READ(int64_t);
    default:
        for (int64_t i = 0; i < b->box.n[0]; i++)
            out[i] = rounded(at + i * b->stride[0], b->type, info);
    }
#undef READ
}

static void read_row(int64_t *out, const finding *f, int64_t j, int64_t k)
{
    vvi_label_read(out, &f->brick, f->component, vv_field_get_info(f->field), j, k);
}

static vv_status find_all(finding *f)
{
    const int64_t *n = f->brick.box.n;
    vv_status st = VV_OK;
    int64_t *row = vvi_alloc(f->job, (size_t)n[0] * sizeof *row, VVI_MEM_SCRATCH);
    if (!row)
        return vv_fail_memory((size_t)n[0] * sizeof *row);
    for (int64_t k = 0; k < n[2] && st == VV_OK; k++) {
        for (int64_t j = 0; j < n[1] && st == VV_OK; j++) {
            read_row(row, f, j, k);
            for (int64_t i = 0; i < n[0] && st == VV_OK; i++)
                if (i == 0 || row[i] != row[i - 1])
                    st = add(&f->set, row[i], f->job);
        }
        st = st == VV_OK ? vvi_job_poll(f->job) : st;
    }
    vvi_free(row);
    return st;
}

/* Numbers --------------------------------------------------------------------------------------------------------- */

static int ascending(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

static int ascending_unsigned(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static vv_status sort_ids(vvi_label_ids *out, finding *f)
{
    id_set *s = &f->set;
    out->id = vvi_alloc(f->job, (s->n + 1) * sizeof *out->id, VVI_MEM_DERIVED);
    if (!out->id)
        return vv_fail_memory((s->n + 1) * sizeof *out->id);
    for (size_t i = 0; i < s->room; i++)
        if (s->number[i])
            out->id[out->n++] = s->key[i];
    qsort(out->id, out->n, sizeof *out->id, out->is_unsigned ? ascending_unsigned : ascending);
    for (size_t i = 0; i < out->n; i++)
        s->number[place_of(s, out->id[i])] = (uint32_t)i + 1;
    out->statistics = (vv_statistics){.count = 1, .max = (double)out->n - 1};
    return VV_OK;
}

static vv_status start(void **scratch, void *user, int worker)
{
    const finding *f = user;
    const size_t bytes = (size_t)f->brick.box.n[0] * sizeof(int64_t);
    (void)worker;
    *scratch = vvi_alloc(f->job, bytes, VVI_MEM_SCRATCH);
    return *scratch ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

/* Item: one slice. */
static vv_status number_slice(void *scratch, void *user, size_t k)
{
    const finding *f = user;
    const int64_t *n = f->brick.box.n;
    int64_t *row = scratch;
    for (int64_t j = 0; j < n[1]; j++) {
        const size_t first = (k * (size_t)n[1] + (size_t)j) * (size_t)n[0];
        read_row(row, f, j, (int64_t)k);
        uint32_t number = 0;
        for (int64_t i = 0; i < n[0]; i++) {
            if (i == 0 || row[i] != row[i - 1])
                number = f->set.number[place_of(&f->set, row[i])] - 1;
            if (f->wide)
                ((float *)f->to)[first + (size_t)i] = (float)number;
            else
                ((uint16_t *)f->to)[first + (size_t)i] = (uint16_t)number;
        }
    }
    return vvi_job_poll(f->job);
}

static vv_status number_all(vvi_label_ids *out, finding *f)
{
    static const vvi_work work = {.stage = "labels", .start = start, .item = number_slice, .finish = finish};
    vv_field_info info = *vv_field_get_info(f->field);
    f->wide = out->n > 65536;
    info.type = f->wide ? VV_TYPE_F32 : VV_TYPE_U16;
    info.components = 1;
    info.meaning = VV_MEANING_SCALAR;
    info.value_scale = 1;
    info.value_offset = 0;
    const vv_status st = vv_field_new_empty(&out->numbers, &f->to, &info, f->job);
    return st == VV_OK ? vvi_parallel_for(f->job, &work, f, (size_t)info.grid.dims[2]) : st;
}

/* The whole ------------------------------------------------------------------------------------------------------- */

static void drop(void *value)
{
    vvi_label_ids *ids = value;
    vv_field_release(ids->numbers);
    vvi_free(ids->id);
    vvi_free(ids);
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    finding *f = user;
    const vv_box all = vv_field_box(f->field);
    vvi_label_ids *ids = vvi_alloc_zeroed(job, sizeof *ids, VVI_MEM_DERIVED);
    if (!ids)
        return vv_fail_memory(sizeof *ids);
    ids->is_unsigned = vv_field_get_info(f->field)->type == VV_TYPE_U64;
    vv_status st = vv_field_brick(&f->brick, f->field, &all, job);
    if (st == VV_OK)
        st = find_all(f);
    if (st == VV_OK)
        st = sort_ids(ids, f);
    if (st == VV_OK)
        st = number_all(ids, f);
    vv_brick_release(&f->brick);
    free_set(&f->set);
    if (st != VV_OK) {
        drop(ids);
        return st;
    }
    *bytes_out =
        sizeof *ids + ids->n * sizeof *ids->id + (uint64_t)(all.n[0] * all.n[1] * all.n[2]) * (f->wide ? 4 : 2);
    *value_out = ids;
    return VV_OK;
}

bool vvi_label_ids_needed(const vv_field_info *info, const vv_statistics *s)
{
    const bool long_type = info->type == VV_TYPE_I64 || info->type == VV_TYPE_U64;
    return s->max - s->min >= VVI_LABEL_IDS_MOST || (long_type && fmax(fabs(s->min), fabs(s->max)) >= 0x1p53);
}

vv_status vvi_label_ids_get(vvi_cached **out, const vv_field *field, int component, vv_job *job)
{
    finding f = {.field = field, .component = component, .job = job};
    const vvi_cache_key key = {"label ids", vv_field_identity(field), (uint64_t)component};
    return vvi_cache_get(out, &key, make, drop, &f, job);
}

void vvi_label_ids_actor(vv_actor *out, const vv_actor *actor, const vvi_label_ids *ids)
{
    *out = *actor;
    out->field = vv_field_retain(ids->numbers);
    out->component = 0;
    out->statistics = (vv_statistics *)(uintptr_t)&ids->statistics;
    out->classes.ids = ids->id;
    out->classes.n_ids = ids->n;
    out->classes.ids_unsigned = ids->is_unsigned;
}
