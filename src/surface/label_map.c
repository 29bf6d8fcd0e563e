/* First the labels of every slice, then all of them sorted, then the number of each voxel's. Labels come in runs, so
 * that each is looked for once a run. */
#include "surface/label_map.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_LABELS = UINT16_MAX };

/* Distinct labels, in a hash table with open places (keys of place i count where used[i]). */
typedef struct label_set {
    double *key;
    uint8_t *used;
    size_t n, room; /* a power of 2 */
} label_set;

typedef struct mapping {
    vvi_label_map *map;
    vv_brick brick;
    int component;
    label_set *sets; /* by slice */
} mapping;

/* Sets ------------------------------------------------------------------------------------------------------------ */

static size_t place_of(const label_set *s, double label)
{
    uint64_t h;
    memcpy(&h, &label, sizeof h);
    h = (h ^ h >> 32) * 0x9e3779b97f4a7c15u;
    size_t i = (size_t)(h >> 20) & (s->room - 1);
    while (s->used[i] && s->key[i] != label)
        i = (i + 1) & (s->room - 1);
    return i;
}

static void free_set(label_set *s)
{
    vvi_free(s->key);
    vvi_free(s->used);
}

static vv_status grow(label_set *s, vv_job *job)
{
    const label_set old = *s;
    label_set grown = {.n = old.n, .room = old.room ? 2 * old.room : 64};
    grown.key = vvi_alloc(job, grown.room * sizeof *grown.key, VVI_MEM_SCRATCH);
    grown.used = vvi_alloc_zeroed(job, grown.room, VVI_MEM_SCRATCH);
    if (!grown.key || !grown.used) {
        free_set(&grown);
        return vv_fail_memory(grown.room * (sizeof *grown.key + 1));
    }
    for (size_t i = 0; i < old.room; i++)
        if (old.used[i]) {
            const size_t at = place_of(&grown, old.key[i]);
            grown.key[at] = old.key[i];
            grown.used[at] = 1;
        }
    free_set(s);
    *s = grown;
    return VV_OK;
}

static vv_status add(label_set *s, double label, vv_job *job)
{
    const vv_status st = 2 * s->n >= s->room ? grow(s, job) : VV_OK;
    if (st != VV_OK)
        return st;
    const size_t at = place_of(s, label);
    s->n += !s->used[at];
    s->key[at] = label;
    s->used[at] = 1;
    return VV_OK;
}

/* Slices ---------------------------------------------------------------------------------------------------------- */

static void read_row(double *out, const mapping *m, int64_t j, int64_t k)
{
    const vv_brick *b = &m->brick;
    const size_t bytes = vv_type_bytes(b->type);
    const char *row = (const char *)b->data + (size_t)m->component * bytes + j * b->stride[1] + k * b->stride[2];
    if (b->stride[0] == (int64_t)bytes) {
        vvi_samples_to_f64(out, row, b->type, (size_t)m->map->n[0]);
        return;
    }
    for (int64_t i = 0; i < m->map->n[0]; i++)
        vvi_samples_to_f64(out + i, row + i * b->stride[0], b->type, 1);
}

static vv_status start(void **scratch, void *user, int worker)
{
    const mapping *m = user;
    (void)worker;
    *scratch = vvi_alloc(m->map->job, (size_t)m->map->n[0] * sizeof(double), VVI_MEM_SCRATCH);
    return *scratch ? VV_OK : vv_fail_memory((size_t)m->map->n[0] * sizeof(double));
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

/* Item: the labels of one slice. */
static vv_status find_in_slice(void *scratch, void *user, size_t k)
{
    const mapping *m = user;
    double *row = scratch;
    vv_status st = VV_OK;
    for (int64_t j = 0; j < m->map->n[1] && st == VV_OK; j++) {
        read_row(row, m, j, (int64_t)k);
        for (int64_t i = 0; i < m->map->n[0] && st == VV_OK; i++)
            if (i == 0 || row[i] != row[i - 1])
                st = add(&m->sets[k], row[i], m->map->job);
    }
    return st == VV_OK ? vvi_job_poll(m->map->job) : st;
}

/* NOLINTNEXTLINE(readability-non-const-parameter): written as a whole, whoever else does */
static void lower(int32_t *to, int32_t v)
{
    int32_t was = __atomic_load_n(to, __ATOMIC_RELAXED);
    while (v < was && !__atomic_compare_exchange_n(to, &was, v, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
        continue;
}

/* NOLINTNEXTLINE(readability-non-const-parameter) */
static void raise_to(int32_t *to, int32_t v)
{
    int32_t was = __atomic_load_n(to, __ATOMIC_RELAXED);
    while (v > was && !__atomic_compare_exchange_n(to, &was, v, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
        continue;
}

static void extend(vvi_label_box *b, const int32_t lo[3], const int32_t hi[3])
{
    for (int a = 0; a < 3; a++) {
        lower(&b->lo[a], lo[a]);
        raise_to(&b->hi[a], hi[a]);
    }
}

/* Item: the numbers of one slice's labels; their boxes grow, in whatever order. */
static vv_status number_slice(void *scratch, void *user, size_t k)
{
    const mapping *m = user;
    const vvi_label_map *map = m->map;
    double *row = scratch;
    uint16_t *to = map->index + (int64_t)k * map->n[1] * map->n[0];
    for (int64_t j = 0; j < map->n[1]; j++, to += map->n[0]) {
        read_row(row, m, j, (int64_t)k);
        for (int64_t i = 0, end; i < map->n[0]; i = end) {
            const size_t number = vvi_label_number(map, row[i]);
            for (end = i; end < map->n[0] && row[end] == row[i]; end++)
                to[end] = (uint16_t)number;
            extend(&map->boxes[number], (const int32_t[3]){(int32_t)i, (int32_t)j, (int32_t)k},
                   (const int32_t[3]){(int32_t)end - 1, (int32_t)j, (int32_t)k});
        }
    }
    return vvi_job_poll(map->job);
}

/* The whole ------------------------------------------------------------------------------------------------------- */

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static vv_status sort_labels(mapping *m)
{
    vvi_label_map *map = m->map;
    label_set all = {0};
    vv_status st = VV_OK;
    for (int64_t k = 0; k < map->n[2]; k++)
        for (size_t i = 0; i < m->sets[k].room && st == VV_OK; i++)
            if (m->sets[k].used[i])
                st = add(&all, m->sets[k].key[i], map->job);
    if (st == VV_OK && all.n > MOST_LABELS)
        st = vv_fail(VV_E_LIMIT, "%zu different labels; up to %d are possible: is this a segmentation?", all.n,
                     MOST_LABELS);
    if (st == VV_OK) {
        map->labels = vvi_alloc(map->job, all.n * sizeof *map->labels, VVI_MEM_SCRATCH);
        map->boxes = vvi_alloc(map->job, all.n * sizeof *map->boxes, VVI_MEM_SCRATCH);
        st = map->labels && map->boxes ? VV_OK : vv_fail_memory(all.n * sizeof *map->boxes);
    }
    for (size_t i = 0; i < all.room && st == VV_OK; i++)
        if (all.used[i]) {
            map->boxes[map->n_labels] =
                (vvi_label_box){{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};
            map->labels[map->n_labels++] = all.key[i];
        }
    free_set(&all);
    if (st == VV_OK)
        qsort(map->labels, map->n_labels, sizeof *map->labels, ascending);
    return st;
}

static vv_status fill(mapping *m)
{
    static const vvi_work find = {.stage = "labels", .start = start, .item = find_in_slice, .finish = finish};
    static const vvi_work number = {.stage = "labels", .start = start, .item = number_slice, .finish = finish};
    vvi_label_map *map = m->map;
    const size_t n = (size_t)map->n[2];
    size_t voxels;
    vv_status st = vvi_mul3_size(&voxels, (size_t)map->n[0], (size_t)map->n[1], n);
    if (st == VV_OK)
        st = vvi_mul_size(&voxels, voxels, sizeof *map->index);
    if (st != VV_OK)
        return st;
    m->sets = vvi_alloc_zeroed(map->job, n * sizeof *m->sets, VVI_MEM_SCRATCH);
    map->index = vvi_alloc(map->job, voxels, VVI_MEM_SCRATCH);
    st = m->sets && map->index ? VV_OK : vv_fail_memory(voxels);
    if (st == VV_OK)
        st = vvi_parallel_for(map->job, &find, m, n);
    if (st == VV_OK)
        st = sort_labels(m);
    if (st == VV_OK)
        st = vvi_parallel_for(map->job, &number, m, n);
    for (size_t k = 0; k < n && m->sets; k++)
        free_set(&m->sets[k]);
    vvi_free(m->sets);
    return st;
}

vv_status vvi_label_map_init(vvi_label_map *out, const vv_field *field, int component, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    const vv_box all = vv_field_box(field);
    mapping m = {.map = out, .component = component};
    *out = (vvi_label_map){.n = {all.n[0], all.n[1], all.n[2]}, .job = job};
    if (component < 0 || component >= info->components)
        return vv_fail(VV_E_ARGUMENT, "channel %d does not exist; there are 0 to %d", component, info->components - 1);
    if (vv_type_is_float(info->type))
        return vv_fail(VV_E_UNSUPPORTED, "labels are integers; these samples are %s", vv_type_name(info->type));
    vv_status st = vv_field_brick(&m.brick, field, &all, job);
    if (st != VV_OK)
        return st;
    st = fill(&m);
    vv_brick_release(&m.brick);
    if (st != VV_OK)
        vvi_label_map_finish(out);
    return st;
}

void vvi_label_map_finish(vvi_label_map *map)
{
    vvi_free(map->index);
    vvi_free(map->labels);
    vvi_free(map->boxes);
    *map = (vvi_label_map){0};
}

size_t vvi_label_number(const vvi_label_map *map, double label)
{
    size_t lo = 0, hi = map->n_labels;
    while (lo < hi) {
        const size_t mid = lo + (hi - lo) / 2;
        if (map->labels[mid] < label)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo < map->n_labels && map->labels[lo] == label ? lo : SIZE_MAX;
}
