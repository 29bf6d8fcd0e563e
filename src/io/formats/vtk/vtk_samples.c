/* Samples of one piece or of several, all or those of a box. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/vtk/vtk_xml.h"
#include <string.h>

/* A box of one piece, counted from the piece's own first sample. */
static vv_status read_piece(vv_field **out, const vvi_vtk_plan *plan, size_t piece, vv_source *source,
                            const vv_box *region, vv_job *job)
{
    const vvi_vtk_array *a;
    vvi_vtk_reader *reader;
    vvi_layout layout;
    uint64_t n, offset;
    vv_field_info info = plan->stored;
    vv_status st = vvi_vtk_find_in_piece(&a, plan, piece);
    if (st != VV_OK)
        return st;
    vvi_vtk_lay_out(&layout, &plan->file, a, plan->file.piece[piece].extent);
    vvi_vtk_samples_of(info.grid.dims, plan->file.piece[piece].extent, a->section == VVI_VTK_CELLS);
    if ((st = vvi_layout_count(&n, &layout, plan->file.name)) != VV_OK ||
        (st = vvi_vtk_open(&reader, &plan->file, a, n, source, job)) != VV_OK)
        return st;
    if (vvi_vtk_plain(&offset, reader)) {
        st = vvi_layout_read_plain(out, &info, &layout, source, offset, 0, region, job);
    } else {
        const vvi_elements elements = vvi_vtk_elements(reader);
        st = vvi_layout_read(out, &info, &layout, &elements, 0, region, job);
        if (st == VV_OK && (st = vvi_vtk_check(reader)) != VV_OK) {
            vv_field_release(*out);
            *out = NULL;
        }
    }
    vvi_vtk_close(reader);
    return st;
}

/* The part of a box that a piece has, counted from the first sample of the whole. */
static bool intersect(vv_box *out, const vvi_vtk_plan *plan, size_t piece, const vv_box *box)
{
    const int64_t *extent = plan->file.piece[piece].extent, *whole = plan->file.whole;
    int64_t n[3];
    vvi_vtk_samples_of(n, extent, plan->file.array[plan->chosen].section == VVI_VTK_CELLS);
    for (int a = 0; a < 3; a++) {
        const int64_t lo = extent[2 * a] - whole[2 * a], hi = lo + n[a], end = box->lo[a] + box->n[a];
        out->lo[a] = lo > box->lo[a] ? lo : box->lo[a];
        out->n[a] = (hi < end ? hi : end) - out->lo[a];
        if (out->n[a] < 1)
            return false;
    }
    return true;
}

static vv_status copy_piece(uint8_t *out, const vv_box *box, const vv_box *common, const vv_field *field, size_t sample,
                            vv_job *job)
{
    const vv_box all = vv_field_box(field);
    vv_brick b;
    vv_status st = vv_field_brick(&b, field, &all, job);
    if (st != VV_OK)
        return st;
    for (int64_t k = 0; k < common->n[2]; k++)
        for (int64_t j = 0; j < common->n[1]; j++) {
            const int64_t z = common->lo[2] - box->lo[2] + k, y = common->lo[1] - box->lo[1] + j;
            const int64_t x = common->lo[0] - box->lo[0];
            memcpy(out + ((z * box->n[1] + y) * box->n[0] + x) * (int64_t)sample,
                   (const uint8_t *)b.data + k * b.stride[2] + j * b.stride[1], (size_t)common->n[0] * sample);
        }
    vv_brick_release(&b);
    return vv_field_health(field);
}

static vv_status fill_pieces(uint8_t *data, const vvi_vtk_plan *plan, vv_source *source, const vv_box *box, vv_job *job)
{
    const size_t sample = vv_type_bytes(plan->stored.type) * (size_t)plan->stored.components;
    vv_status st = VV_OK;
    for (size_t p = 0; p < plan->file.n_pieces && st == VV_OK; p++) {
        vv_box common, own;
        vv_field *field;
        if (!intersect(&common, plan, p, box))
            continue;
        own = common;
        for (int a = 0; a < 3; a++)
            own.lo[a] -= plan->file.piece[p].extent[2 * a] - plan->file.whole[2 * a];
        if ((st = read_piece(&field, plan, p, source, &own, job)) != VV_OK)
            return st;
        st = copy_piece(data, box, &common, field, sample, job);
        vv_field_release(field);
    }
    return st;
}

static vv_status read_pieces(vv_field **out, const vvi_vtk_plan *plan, vv_source *source, const vv_box *box,
                             vv_job *job)
{
    vv_field_info part = plan->stored;
    uint64_t bytes;
    void *data;
    vv_field *field;
    part.grid = vv_grid_crop(&plan->stored.grid, box);
    vv_status st = vv_field_info_bytes(&bytes, &part);
    if (st != VV_OK || (st = vvi_memory_plan(job, bytes, "volume")) != VV_OK ||
        (st = vv_field_new_empty(&field, &data, &part, job)) != VV_OK)
        return st;
    if (plan->missing > 1e-12) {
        memset(data, vv_type_is_float(part.type) ? 0xff : 0, (size_t)bytes);
        vvi_job_damage(job, "io", "%s: its pieces leave %.3g %% of its WholeExtent empty, which is %s", plan->file.name,
                       100 * plan->missing, vv_type_is_float(part.type) ? "NaN" : "0");
    }
    if ((st = fill_pieces(data, plan, source, box, job)) == VV_OK)
        *out = field;
    else
        vv_field_release(field);
    return st;
}

static vv_status read_stored(vv_field **out, const vvi_vtk_plan *plan, vv_source *source, const vv_box *region,
                             vv_job *job)
{
    const int64_t *n = plan->stored.grid.dims;
    const vv_box all = {{0, 0, 0}, {n[0], n[1], n[2]}};
    if (plan->file.n_pieces == 1 && plan->missing <= 1e-12)
        return read_piece(out, plan, 0, source, region, job);
    return read_pieces(out, plan, source, region ? region : &all, job);
}

vv_status vvi_vtk_read(vv_field **out, const vv_field_info *info, const void *memory, vv_source *source, int64_t frame,
                       const vv_box *region, vv_job *job)
{
    const vvi_vtk_plan *plan = memory;
    *out = NULL;
    if (!plan->uneven)
        return read_stored(out, plan, source, region, job);
    const vv_box needs = vvi_axes_needs(plan->uneven, region);
    vv_field *stored;
    vv_status st = read_stored(&stored, plan, source, &needs, job);
    if (st != VV_OK)
        return st;
    st = vvi_axes_sample(out, info, plan->uneven, region, stored, &needs, job);
    vv_field_release(stored);
    return st;
}
