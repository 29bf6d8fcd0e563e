/* First the labels of every slice, then all of them sorted, then the number of each voxel's. Labels come in runs, so
 * that each is looked for once a run. */
#include "surface/label_map.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"

enum { MOST_LABELS = UINT16_MAX };

typedef struct mapping {
    vvi_label_map *map;
    vv_brick brick;
    int component;
    vvi_label_set *sets; /* by slice */
} mapping;

/* Slices ---------------------------------------------------------------------------------------------------------- */

static void read_row(vv_label_id *out, const mapping *m, int64_t j, int64_t k)
{
    vvi_label_read(out, &m->brick, m->component, NULL, j, k);
}

static vv_status start(void **scratch, void *user, int worker)
{
    const mapping *m = user;
    (void)worker;
    *scratch = vvi_alloc(m->map->job, (size_t)m->map->n[0] * sizeof(vv_label_id), VVI_MEM_SCRATCH);
    return *scratch ? VV_OK : vv_fail_memory((size_t)m->map->n[0] * sizeof(vv_label_id));
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
    vv_label_id *row = scratch;
    vv_status st = VV_OK;
    for (int64_t j = 0; j < m->map->n[1] && st == VV_OK; j++) {
        read_row(row, m, j, (int64_t)k);
        for (int64_t i = 0; i < m->map->n[0] && st == VV_OK; i++)
            if (i == 0 || row[i] != row[i - 1])
                st = vvi_label_set_add(NULL, &m->sets[k], row[i], m->map->job);
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
    vv_label_id *row = scratch;
    uint16_t *to = map->index + (int64_t)k * map->n[1] * map->n[0];
    for (int64_t j = 0; j < map->n[1]; j++, to += map->n[0]) {
        read_row(row, m, j, (int64_t)k);
        for (int64_t i = 0, end; i < map->n[0]; i = end) {
            const size_t number = vvi_label_set_find(&map->set, row[i]);
            for (end = i; end < map->n[0] && row[end] == row[i]; end++)
                to[end] = (uint16_t)number;
            extend(&map->boxes[number], (const int32_t[3]){(int32_t)i, (int32_t)j, (int32_t)k},
                   (const int32_t[3]){(int32_t)end - 1, (int32_t)j, (int32_t)k});
        }
    }
    return vvi_job_poll(map->job);
}

/* The whole ------------------------------------------------------------------------------------------------------- */

static vv_status sort_labels(mapping *m)
{
    vvi_label_map *map = m->map;
    vv_status st = VV_OK;
    for (int64_t k = 0; k < map->n[2] && st == VV_OK; k++)
        st = vvi_label_set_join(&map->set, &m->sets[k], map->job);
    if (st == VV_OK && map->set.n > MOST_LABELS)
        st = vv_fail(VV_E_LIMIT, "%zu different labels; up to %d are possible: is this a segmentation?", map->set.n,
                     MOST_LABELS);
    if (st != VV_OK || (st = vvi_label_set_sort(&map->labels, &map->set, map->is_unsigned, map->job)) != VV_OK)
        return st;
    map->n_labels = map->set.n;
    map->boxes = vvi_alloc(map->job, map->n_labels * sizeof *map->boxes, VVI_MEM_SCRATCH);
    for (size_t i = 0; i < map->n_labels && map->boxes; i++)
        map->boxes[i] = (vvi_label_box){{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};
    return map->boxes ? VV_OK : vv_fail_memory(map->n_labels * sizeof *map->boxes);
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
        vvi_label_set_finish(&m->sets[k]);
    vvi_free(m->sets);
    return st;
}

vv_status vvi_label_map_init(vvi_label_map *out, const vv_field *field, int component, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    const vv_box all = vv_field_box(field);
    mapping m = {.map = out, .component = component};
    *out = (vvi_label_map){
        .n = {all.n[0], all.n[1], all.n[2]}, .is_unsigned = vvi_label_is_unsigned(info->type), .job = job};
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
    vvi_label_set_finish(&map->set);
    *map = (vvi_label_map){0};
}

size_t vvi_label_number(const vvi_label_map *map, vv_label_id label)
{
    const uint32_t number = vvi_label_set_find(&map->set, label);
    return number == VVI_NO_LABEL ? SIZE_MAX : number;
}
