/* A field's samples in bricks, as kernels take them. */
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/bricks.h"
#include "grid/lattice.h"
#include "grid/store.h"

typedef struct source {
    const vv_field *field; /* the cache forgets the bricks before it goes */
    vvi_lattice_numbers numbers;
} source;

static vv_status fill(char *to, size_t row, size_t slice, void *user, const vv_box *box, vv_job *job)
{
    const source *s = user;
    vv_brick brick;
    const vv_status st = vv_field_brick(&brick, s->field, box, job);
    if (st != VV_OK)
        return st;
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            vvi_lattice_convert_row(to + (size_t)j * row + (size_t)k * slice, &s->numbers,
                                    (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2],
                                    brick.stride[0], (size_t)box->n[0]);
    vv_brick_release(&brick);
    return VV_OK;
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const vvi_lattice_hold *h = user;
    vvi_bricks *bricks;
    source *s = vvi_alloc(job, sizeof *s, VVI_MEM_DERIVED);
    if (!s)
        return vv_fail_memory(sizeof *s);
    *s = (source){h->field, h->numbers};
    const vvi_brick_source from = {fill, vvi_free, s};
    const vv_status st =
        vvi_bricks_new(&bricks, vv_field_get_info(h->field)->grid.dims, vv_type_bytes(h->numbers.to), &from, job);
    if (st != VV_OK)
        return st;
    *bytes_out = (uint64_t)bricks->n[0] * (uint64_t)bricks->n[1] * (uint64_t)bricks->n[2] * sizeof *bricks->page;
    *value_out = bricks;
    return VV_OK;
}

vv_status vvi_lattice_open_bricks(vvi_lattice_hold *out, const vv_field *field, int component, vv_job *job)
{
    vv_status st = vvi_lattice_hold_begin(out, field, component, job);
    const vvi_cache_key key = {"lattice bricks", vv_field_identity(field), (uint64_t)component};
    if (st == VV_OK)
        st = vvi_cache_get(&out->cached, &key, make, vvi_bricks_free, out, job);
    if (st != VV_OK) {
        vvi_lattice_close(out);
        return st;
    }
    const vvi_bricks *bricks = vvi_cached_value(out->cached);
    vvi_lattice *g = &out->lattice;
    g->data = bricks->data;
    g->sample_type = vvi_lattice_type(out->numbers.to);
    g->fetch = VVI_FETCH_BRICKS;
    g->bricks = bricks;
    for (int a = 0; a < 3; a++)
        g->n[a] = (int32_t)vv_field_get_info(field)->grid.dims[a];
    g->row = bricks->side[0];
    g->slice = (int64_t)bricks->side[0] * bricks->side[1];
    return VV_OK;
}

vv_status vvi_lattice_open_somehow(vvi_lattice_hold *out, const vv_field *field, int component, vv_job *job)
{
    return vvi_field_is_lazy(field) ? vvi_lattice_open_bricks(out, field, component, job)
                                    : vvi_lattice_open(out, field, component, job);
}

double vvi_lattice_number(const vvi_lattice *g, int64_t i, int64_t j, int64_t k)
{
    int64_t at = k * g->slice + j * g->row + i;
    if (g->fetch == VVI_FETCH_BRICKS) {
        const int64_t in[3] = {i % VVI_BRICK_CELLS, j % VVI_BRICK_CELLS, k % VVI_BRICK_CELLS};
        const int32_t *b = g->bricks->n;
        const int64_t brick = (k / VVI_BRICK_CELLS * b[1] + j / VVI_BRICK_CELLS) * b[0] + i / VVI_BRICK_CELLS;
        at = vvi_bricks_bring(g->bricks, (int32_t)brick) + (in[2] + VVI_BRICK_BEFORE) * g->slice +
             (in[1] + VVI_BRICK_BEFORE) * g->row + in[0] + VVI_BRICK_BEFORE;
    }
    switch (g->sample_type) {
    case VVI_SAMPLE_U8:
        return ((const uint8_t *)g->data)[at];
    case VVI_SAMPLE_U16:
        return ((const uint16_t *)g->data)[at];
    case VVI_SAMPLE_I16:
        return ((const int16_t *)g->data)[at];
    default:
        return (double)((const float *)g->data)[at];
    }
}
