/* What is held of a volume while it is written: a slab of every level, as deep as a chunk. Chunks are the same whatever
 * memory there is: slabs that do not fit into it lie in a scratch file beside the output, which the system keeps in
 * memory as far as that goes. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/zarr/zarr_write.h"
#include <string.h>
#include <sys/mman.h>

#define PIECE_BYTES ((uint64_t)8 << 20) /* of the field that are asked for at once, at most */

static vv_status measure(vvi_zarr_writing *w, uint64_t *all)
{
    vv_status st = VV_OK;
    *all = 0;
    for (int i = 0; i < w->n_levels && st == VV_OK; i++) {
        vvi_zarr_level *l = &w->level[i];
        st = vvi_mul3_size(&l->slab_bytes, (size_t)l->dims[0], (size_t)l->dims[1], (size_t)l->chunk[2]);
        if (st == VV_OK)
            st = vvi_mul_size(&l->slab_bytes, l->slab_bytes, w->sample_bytes);
        *all += l->slab_bytes;
    }
    return st;
}

vv_status vvi_zarr_make_slabs(vvi_zarr_writing *w)
{
    uint64_t all;
    vv_status st = measure(w, &all);
    /* as much again for those who make the field's samples and pack them */
    w->on_disk = st == VV_OK && vvi_memory_plan(w->job, 2 * all, "slabs") != VV_OK;
    for (int i = 0; i < w->n_levels && st == VV_OK; i++) {
        vvi_zarr_level *l = &w->level[i];
        void *data;
        if (w->on_disk) {
            st = vvi_sink_scratch(&data, w->sink, l->slab_bytes);
        } else {
            data = vvi_alloc(w->job, l->slab_bytes, VVI_MEM_SCRATCH);
            st = data ? VV_OK : vv_fail_memory(l->slab_bytes);
        }
        l->slab = data;
    }
    return st;
}

void vvi_zarr_free_slabs(vvi_zarr_writing *w)
{
    for (int i = 0; i < w->n_levels; i++)
        if (!w->on_disk)
            vvi_free(w->level[i].slab);
        else if (w->level[i].slab)
            munmap(w->level[i].slab, w->level[i].slab_bytes);
}

/* From the field ------------------------------------------------------------------------------------------------- */

/* The box of the field that holds the slices of the slab. */
static vv_box box_of_slab(const vvi_zarr_writing *w)
{
    const vvi_zarr_level *l = w->level;
    const int64_t *dims = w->info->grid.dims;
    const int axis = w->source_axis[2];
    vv_box box = {{0, 0, 0}, {dims[0], dims[1], dims[2]}};
    box.lo[axis] = w->flip[2] ? dims[axis] - l->at - l->n : l->at;
    box.n[axis] = l->n;
    return box;
}

static void copy_samples(uint8_t *to, const uint8_t *from, int64_t n, int64_t step, size_t sample)
{
    if (step == (int64_t)sample) {
        memcpy(to, from, (size_t)n * sample);
        return;
    }
    for (int64_t i = 0; i < n; i++, to += sample)
        memcpy(to, from + i * step, sample);
}

/* Samples of a brick to their places in the slab, in the order of the image. */
static void place_brick(const vvi_zarr_writing *w, const vv_brick *brick)
{
    const vvi_zarr_level *l = w->level;
    const uint8_t *from = brick->data;
    int64_t step[3], n[3], lo[3];
    for (int a = 0; a < 3; a++) {
        const int axis = w->source_axis[a];
        n[a] = brick->box.n[axis];
        step[a] = brick->stride[axis];
        lo[a] = brick->box.lo[axis];
        if (w->flip[a]) {
            from += (n[a] - 1) * step[a];
            step[a] = -step[a];
            lo[a] = w->info->grid.dims[axis] - lo[a] - n[a];
        }
    }
    lo[2] -= l->at;
    for (int64_t k = 0; k < n[2]; k++)
        for (int64_t j = 0; j < n[1]; j++) {
            const size_t at = (size_t)(((lo[2] + k) * l->dims[1] + lo[1] + j) * l->dims[0] + lo[0]) * w->sample_bytes;
            copy_samples(l->slab + at, from + k * step[2] + j * step[1], n[0], step[0], w->sample_bytes);
        }
}

/* Piece by piece along the field's own z: those who make its samples while they are asked for go forwards by slices. */
vv_status vvi_zarr_fill_slab(vvi_zarr_writing *w, const vv_field *field)
{
    const vv_box all = box_of_slab(w);
    const uint64_t slice = (uint64_t)(all.n[0] * all.n[1]) * w->sample_bytes;
    int64_t most = slice < PIECE_BYTES ? (int64_t)(PIECE_BYTES / slice) : 1;
    vv_status st = VV_OK;
    while (most > 1 && vvi_memory_plan(w->job, 4 * slice * (uint64_t)most, "slices") != VV_OK)
        most /= 2;
    for (int64_t k = 0; k < all.n[2] && st == VV_OK; k += most) {
        vv_brick brick;
        vv_box piece = all;
        piece.lo[2] += k;
        piece.n[2] = all.n[2] - k < most ? all.n[2] - k : most;
        if ((st = vv_field_brick(&brick, field, &piece, w->job)) != VV_OK)
            return st;
        place_brick(w, &brick);
        vv_brick_release(&brick);
        st = vvi_job_poll(w->job);
    }
    return st;
}
