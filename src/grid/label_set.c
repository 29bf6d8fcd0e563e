#include "grid/label_set.h"
#include "core/memory.h"

#include <stdlib.h>

#define MOST ((size_t)1 << 31)

static size_t place_of(const vvi_label_set *s, vv_label_id id)
{
    uint64_t h = (uint64_t)id;
    h = (h ^ h >> 32) * 0x9e3779b97f4a7c15u;
    size_t i = (size_t)(h >> 24) & (s->room - 1);
    while (s->number[i] && s->key[i] != id)
        i = (i + 1) & (s->room - 1);
    return i;
}

void vvi_label_set_finish(vvi_label_set *set)
{
    vvi_free(set->key);
    vvi_free(set->number);
    *set = (vvi_label_set){0};
}

static vv_status grow(vvi_label_set *s, vv_job *job)
{
    vvi_label_set grown = {.n = s->n, .room = s->room ? 2 * s->room : 64};
    grown.key = vvi_alloc(job, grown.room * sizeof *grown.key, VVI_MEM_SCRATCH);
    grown.number = vvi_alloc_zeroed(job, grown.room * sizeof *grown.number, VVI_MEM_SCRATCH);
    if (!grown.key || !grown.number) {
        const size_t room = grown.room;
        vvi_label_set_finish(&grown);
        return vv_fail_memory(room * (sizeof *s->key + sizeof *s->number));
    }
    for (size_t i = 0; i < s->room; i++)
        if (s->number[i]) {
            const size_t at = place_of(&grown, s->key[i]);
            grown.key[at] = s->key[i];
            grown.number[at] = s->number[i];
        }
    vvi_label_set_finish(s);
    *s = grown;
    return VV_OK;
}

vv_status vvi_label_set_add(uint32_t *number_out, vvi_label_set *set, vv_label_id id, vv_job *job)
{
    const vv_status st = 2 * set->n >= set->room ? grow(set, job) : VV_OK;
    if (st != VV_OK)
        return st;
    const size_t at = place_of(set, id);
    if (!set->number[at] && set->n >= MOST)
        return vv_fail(VV_E_LIMIT, "there are more than %zu different labels: is this a segmentation?", MOST);
    if (!set->number[at]) {
        set->key[at] = id;
        set->number[at] = (uint32_t)++set->n;
    }
    if (number_out)
        *number_out = set->number[at] - 1;
    return VV_OK;
}

vv_status vvi_label_set_join(vvi_label_set *set, const vvi_label_set *other, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < other->room && st == VV_OK; i++)
        if (other->number[i])
            st = vvi_label_set_add(NULL, set, other->key[i], job);
    return st;
}

uint32_t vvi_label_set_find(const vvi_label_set *set, vv_label_id id)
{
    return set->n ? set->number[place_of(set, id)] - 1 : VVI_NO_LABEL; /* of free places 0 - 1, which is that */
}

static int ascending(const void *a, const void *b)
{
    return vvi_label_compare(*(const vv_label_id *)a, *(const vv_label_id *)b, false);
}

static int ascending_unsigned(const void *a, const void *b)
{
    return vvi_label_compare(*(const vv_label_id *)a, *(const vv_label_id *)b, true);
}

vv_status vvi_label_set_sort(vv_label_id **ids_out, vvi_label_set *set, bool is_unsigned, vv_job *job)
{
    vv_label_id *ids = *ids_out = vvi_alloc(job, (set->n + 1) * sizeof *ids, VVI_MEM_DERIVED);
    size_t n = 0;
    if (!ids)
        return vv_fail_memory((set->n + 1) * sizeof *ids);
    for (size_t i = 0; i < set->room; i++)
        if (set->number[i])
            ids[n++] = set->key[i];
    qsort(ids, n, sizeof *ids, is_unsigned ? ascending_unsigned : ascending);
    for (size_t i = 0; i < n; i++)
        set->number[place_of(set, ids[i])] = (uint32_t)i + 1;
    return VV_OK;
}
