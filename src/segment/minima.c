/* Regional minima: what has a lower neighbour is none, nor is what is as high and touches it. */
#include "segment/flood.h"

#define ITEM_VOXELS ((int64_t)1 << 14)
enum { VOXELS_BETWEEN_LOOKS = 1 << 16 };

#define SLOPE VVI_FLOOD_WAITS /* not a minimum */

typedef struct shared {
    uint32_t *label, *room;
    const vvi_heights *heights;
    const vvi_neighbours *around;
    int64_t n;
    vv_job *job;
} shared;

static bool has_lower(const shared *s, int64_t at)
{
    int64_t around[VVI_NEIGHBOURS_MOST];
    const int n = vvi_neighbours_at(around, s->around, at);
    const int64_t here = vvi_height_at(s->heights, at);
    for (int i = 0; i < n; i++)
        if (s->label[around[i]] != VVI_FLOOD_OUTSIDE && vvi_height_at(s->heights, around[i]) < here)
            return true;
    return false;
}

/* Written beside the labels, at which others look meanwhile. */
static vv_status slope_item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const int64_t first = (int64_t)index * ITEM_VOXELS, end = first + ITEM_VOXELS < s->n ? first + ITEM_VOXELS : s->n;
    for (int64_t v = first; v < end; v++)
        s->room[v] = s->label[v] == VVI_FLOOD_NONE && has_lower(s, v);
    return vvi_job_poll(s->job);
}

/* Every voxel that equal ones lead to from `at` and that has no label gets this one. */
static void spread(shared *s, int64_t at, uint32_t label)
{
    int64_t around[VVI_NEIGHBOURS_MOST], n_waiting = 0;
    const int64_t height = vvi_height_at(s->heights, at);
    s->room[n_waiting++] = (uint32_t)at;
    while (n_waiting > 0) {
        const int n = vvi_neighbours_at(around, s->around, s->room[--n_waiting]);
        for (int i = 0; i < n; i++)
            if (s->label[around[i]] == VVI_FLOOD_NONE && vvi_height_at(s->heights, around[i]) == height) {
                s->label[around[i]] = label;
                s->room[n_waiting++] = (uint32_t)around[i];
            }
    }
}

static vv_status look(const shared *s, int64_t v)
{
    return v % VOXELS_BETWEEN_LOOKS == 0 ? vvi_job_poll(s->job) : VV_OK;
}

vv_status vvi_minima_label(uint32_t *label, uint32_t *n_out, const vvi_heights *heights, const vvi_neighbours *around,
                           uint32_t *room, vv_job *job)
{
    static const vvi_work work = {.stage = "minima", .item = slope_item};
    shared s = {.label = label,
                .heights = heights,
                .around = around,
                .n = around->n[0] * around->n[1] * around->n[2],
                .job = job};
    s.room = room;
    vv_status st = vvi_parallel_for(job, &work, &s, (size_t)((s.n + ITEM_VOXELS - 1) / ITEM_VOXELS));
    *n_out = 0;
    for (int64_t v = 0; v < s.n && st == VV_OK; v++)
        if (room[v])
            label[v] = SLOPE;
    for (int64_t v = 0; v < s.n && (st == VV_OK) && (st = look(&s, v)) == VV_OK; v++)
        if (label[v] == SLOPE)
            spread(&s, v, SLOPE);
    for (int64_t v = 0; v < s.n && (st == VV_OK) && (st = look(&s, v)) == VV_OK; v++)
        if (label[v] == VVI_FLOOD_NONE) {
            label[v] = ++*n_out;
            spread(&s, v, label[v]);
        }
    for (int64_t v = 0; v < s.n && st == VV_OK; v++)
        if (label[v] == SLOPE)
            label[v] = VVI_FLOOD_NONE;
    return st;
}
