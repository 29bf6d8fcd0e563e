#include "filter/corner_set.h"
#include "core/memory.h"

#include <string.h>

/* Where a triangle is, or would be. */
static uint32_t *place_of(const vvi_corner_set *s, const uint32_t c[3])
{
    size_t at = (c[0] * 0x9e3779b1u ^ c[1] * 0x85ebca6bu ^ c[2] * 0xc2b2ae35u) & (s->room - 1);
    while (s->at[3 * at] != UINT32_MAX && memcmp(s->at + 3 * at, c, 3 * sizeof *c) != 0)
        at = (at + 1) & (s->room - 1);
    return s->at + 3 * at;
}

vv_status vvi_corner_set_init(vvi_corner_set *set, size_t n_triangles, vv_job *job)
{
    for (set->room = 64; set->room < 2 * n_triangles; set->room *= 2)
        ;
    set->at = vvi_alloc(job, 3 * set->room * sizeof *set->at, VVI_MEM_SCRATCH);
    if (!set->at)
        return vv_fail_memory(3 * set->room * sizeof *set->at);
    vvi_corner_set_clear(set);
    return VV_OK;
}

void vvi_corner_set_finish(vvi_corner_set *set)
{
    vvi_free(set->at);
    *set = (vvi_corner_set){0};
}

void vvi_corner_set_clear(vvi_corner_set *set)
{
    memset(set->at, 0xff, 3 * set->room * sizeof *set->at);
    set->n = 0;
}

void vvi_corner_set_add(vvi_corner_set *set, const uint32_t corner[3])
{
    uint32_t *place = place_of(set, corner);
    if (set->n >= set->room / 2 || *place != UINT32_MAX)
        return;
    memcpy(place, corner, 3 * sizeof *place);
    set->n++;
}

bool vvi_corner_set_has(const vvi_corner_set *set, const uint32_t corner[3])
{
    return *place_of(set, corner) != UINT32_MAX;
}
