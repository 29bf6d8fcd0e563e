/* Where a volume's colours come from, if not from its classification. */
#include "core/cache.h"
#include "core/memory.h"
#include "render/raycast/prepare.h"
#include "scene/colors.h"
#include "scene/label_ids.h"
#include <math.h>
#include <string.h>

enum { ROWS = VVI_TRANSFER_ROWS, GUARD_FLOATS = 16 };
#define MOST_COLORS ((int64_t)1 << 30) /* offsets of 32 bits count words, two a sample */

static vv_status open_colors(vvi_raycast_volume *v, vv_job *job)
{
    const vv_actor *actor = v->actor;
    vvi_paint *paint = &v->ray.paint;
    vvi_lattice *g = &paint->lattice;
    *g = v->hold.lattice;
    if (g->slice * g->n[2] > MOST_COLORS)
        return vv_fail(VV_E_UNSUPPORTED, "volumes.%s: %d x %d x %d colours; ray casting takes at most 2^30, so crop",
                       actor->id, g->n[0], g->n[1], g->n[2]);
    vv_status st = vvi_colors_open(&v->colors, actor->colors, actor->colors_encoded, job);
    if (st != VV_OK)
        return st;
    const vv_field *field = vvi_cached_value(v->colors);
    const vv_box box = vv_field_box(field);
    if ((st = vv_field_brick(&v->colors_brick, field, &box, job)) != VV_OK)
        return st;
    g->data = v->colors_brick.data;
    paint->kind = VVI_PAINT_COLORS;
    paint->nearest = actor->nearest;
    return VV_OK;
}

static bool has_row(const vv_paint *paint, double value)
{
    for (size_t i = 0; i < paint->n_color; i++)
        if (paint->color[4 * i] == value)
            return true;
    return false;
}

/* Colours by value over those between which they change; of labels one for each, where 0 without a row has none: the
 * volume's own are left there. */
static vv_status make_map(vvi_raycast_volume *v, vv_job *job)
{
    const vv_paint *from = &v->actor->paint;
    const vv_classification classes = {.kind = VV_SEGMENT_TRANSFER, .color = from->color, .n_color = from->n_color};
    double lo = from->color[0], hi = from->color[4 * (from->n_color - 1)];
    const bool zero = from->nearest && !has_row(from, 0);
    const double first = floor(zero ? fmin(lo, 0) : lo), last = ceil(zero ? fmax(hi, 0) : hi);
    const bool labels = from->nearest && last - first < VVI_LABEL_IDS_MOST;
    const double most = fmax(fabs(lo - v->paint.value_offset), fabs(hi - v->paint.value_offset));
    if (labels)
        lo = first, hi = last;
    else
        vvi_transfer_around(&lo, &hi, ROWS, vvi_transfer_least_row(most, fabs(v->paint.value_scale)));
    const size_t n = labels ? (size_t)(hi - lo) + 1 : ROWS;
    const double scale = labels ? 1 : (ROWS - 1) / (hi - lo);
    vvi_paint *paint = &v->ray.paint;
    v->paint_color = vvi_alloc(job, (n * 4 + GUARD_FLOATS) * sizeof *v->paint_color, VVI_MEM_SCRATCH);
    if (!v->paint_color)
        return vv_fail_memory((n * 4 + GUARD_FLOATS) * sizeof *v->paint_color);
    for (size_t i = 0; i < n; i++) {
        double rgbk[4];
        vvi_transfer_evaluate(rgbk, &classes, labels ? lo + (double)i : lo + (hi - lo) * (double)i / (ROWS - 1));
        for (size_t c = 0; c < 3; c++)
            v->paint_color[4 * i + c] = (float)rgbk[c];
        v->paint_color[4 * i + 3] = labels && zero && lo + (double)i == 0 ? VVI_PAINT_LEAVES : 0;
    }
    paint->color = v->paint_color;
    paint->n_entries = (int32_t)n;
    paint->entry_scale = (float)(v->paint.value_scale * scale);
    paint->entry_shift = (float)((v->paint.value_offset - lo) * scale + 0.5);
    return VV_OK;
}

static vv_status open_map(vvi_raycast_volume *v, vv_job *job)
{
    const vv_paint *from = &v->actor->paint;
    vvi_paint *paint = &v->ray.paint;
    vv_affine inverse;
    if (!vv_affine_invert(&inverse, from->index_to_world))
        return vv_fail(VV_E_ARGUMENT, "volumes.%s.paint.data: its grid is flat: its matrix has no inverse",
                       v->actor->id);
    const vv_status st = vvi_lattice_open(&v->paint, from->field, from->component, job);
    if (st != VV_OK)
        return vv_fail_in(st, "volumes.%s.paint", v->actor->id);
    const vv_affine m = vv_affine_compose(inverse, v->actor->index_to_world);
    const double rows[3][4] = {{m.axis[0].x, m.axis[1].x, m.axis[2].x, m.origin.x},
                               {m.axis[0].y, m.axis[1].y, m.axis[2].y, m.origin.y},
                               {m.axis[0].z, m.axis[1].z, m.axis[2].z, m.origin.z}};
    paint->lattice = v->paint.lattice;
    for (int a = 0; a < 3; a++) {
        for (int b = 0; b < 4; b++)
            paint->from_index[a][b] = (float)rows[a][b];
        paint->lo[a] = -0.5f; /* a sample's own half voxel as well: maps seldom reach beyond what they are of */
        paint->hi[a] = (float)paint->lattice.n[a] - 0.5f;
    }
    paint->kind = VVI_PAINT_MAP;
    paint->nearest = from->nearest;
    return make_map(v, job);
}

vv_status vvi_raycast_find_paint(vvi_raycast_volume *v, vv_job *job)
{
    if (v->actor->paint.field)
        return open_map(v, job);
    return v->actor->colors ? open_colors(v, job) : VV_OK;
}
