/* Faces are gathered direction by direction and layer by layer; merged ones grow along their first axis, then along the
 * second (greedy meshing). */
#include "surface/boxes.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/mesh.h"

#include <math.h>
#include <string.h>

enum { SHIFT_LEAST = 2, SHIFT_MOST = 16 };

/* A rectangle of box faces: those from lo to before hi along the two axes across. */
typedef struct face {
    int32_t layer, lo[2], hi[2];
} face;

typedef struct gathering {
    const vvi_boxes *boxes;
    uint8_t *outer; /* by box; a face that is gathered is taken away */
    face *faces;
    size_t n, first[VVI_BOX_FACES + 1]; /* of each direction */
    size_t room;
    vv_job *job;
} gathering;

/* Faces ----------------------------------------------------------------------------------------------------------- */

static size_t box_at(const vvi_boxes *b, int axis, int32_t layer, int32_t u, int32_t v)
{
    int32_t at[3];
    at[axis] = layer;
    at[(axis + 1) % 3] = u;
    at[(axis + 2) % 3] = v;
    return ((size_t)at[2] * (size_t)b->n[1] + (size_t)at[1]) * (size_t)b->n[0] + (size_t)at[0];
}

/* Whether all faces from u0 to before u1 in row v are there. */
static bool row_is_there(const gathering *g, int direction, int32_t layer, int32_t u0, int32_t u1, int32_t v)
{
    for (int32_t u = u0; u < u1; u++)
        if (!(g->outer[box_at(g->boxes, direction / 2, layer, u, v)] >> direction & 1))
            return false;
    return true;
}

static void take_away(gathering *g, int direction, const face *f)
{
    for (int32_t v = f->lo[1]; v < f->hi[1]; v++)
        for (int32_t u = f->lo[0]; u < f->hi[0]; u++)
            g->outer[box_at(g->boxes, direction / 2, f->layer, u, v)] &= (uint8_t) ~(1u << direction);
}

static face grow_face(gathering *g, int direction, int32_t layer, int32_t u, int32_t v)
{
    const int axis = direction / 2;
    const int32_t nu = g->boxes->n[(axis + 1) % 3], nv = g->boxes->n[(axis + 2) % 3];
    face f = {layer, {u, v}, {u + 1, v + 1}};
    while (f.hi[0] < nu && row_is_there(g, direction, layer, f.hi[0], f.hi[0] + 1, v))
        f.hi[0]++;
    while (f.hi[1] < nv && row_is_there(g, direction, layer, u, f.hi[0], f.hi[1]))
        f.hi[1]++;
    take_away(g, direction, &f);
    return f;
}

static vv_status gather_merged(gathering *g, int direction)
{
    const int axis = direction / 2;
    const int32_t *n = g->boxes->n;
    for (int32_t layer = 0; layer < n[axis]; layer++) {
        for (int32_t v = 0; v < n[(axis + 2) % 3]; v++)
            for (int32_t u = 0; u < n[(axis + 1) % 3]; u++)
                if (g->outer[box_at(g->boxes, axis, layer, u, v)] >> direction & 1)
                    g->faces[g->n++] = grow_face(g, direction, layer, u, v);
        const vv_status st = vvi_job_poll(g->job);
        if (st != VV_OK)
            return st;
    }
    return VV_OK;
}

static void gather_all(gathering *g, int direction)
{
    const int axis = direction / 2;
    for (size_t i = 0; i < g->boxes->n_kept; i++) {
        int32_t at[3];
        if (!(g->boxes->outer[i] >> direction & 1))
            continue;
        vvi_box_place(at, g->boxes, g->boxes->kept[i]);
        const int32_t u = at[(axis + 1) % 3], v = at[(axis + 2) % 3];
        g->faces[g->n++] = (face){at[axis], {u, v}, {u + 1, v + 1}};
    }
}

static vv_status gather(gathering *g, bool merged)
{
    const vvi_boxes *b = g->boxes;
    const size_t total = (size_t)b->n[0] * (size_t)b->n[1] * (size_t)b->n[2], bytes = b->n_outer * sizeof *g->faces;
    g->faces = vvi_alloc(g->job, bytes + 1, VVI_MEM_SCRATCH);
    if (merged && g->faces)
        g->outer = vvi_alloc_zeroed(g->job, total, VVI_MEM_SCRATCH);
    if (!g->faces || (merged && !g->outer))
        return vv_fail_memory(bytes + (merged ? total : 0));
    for (size_t i = 0; i < b->n_kept && merged; i++)
        g->outer[b->kept[i]] = b->outer[i];
    vv_status st = VV_OK;
    for (int d = 0; d < VVI_BOX_FACES && st == VV_OK; d++) {
        g->first[d] = g->n;
        if (merged)
            st = gather_merged(g, d);
        else
            gather_all(g, d);
    }
    g->first[VVI_BOX_FACES] = g->n;
    return st;
}

/* Mesh ------------------------------------------------------------------------------------------------------------ */

typedef struct placing {
    const vvi_boxes *boxes;
    const vv_grid *grid;
    float normal[3][3]; /* world normal of each axis, of length 1 */
    bool mirrored;
} placing;

static vv_status open_placing(placing *p, const vvi_boxes *boxes, const vv_grid *grid)
{
    vv_affine inverse;
    *p = (placing){.boxes = boxes, .grid = grid};
    if (!vv_affine_invert(&inverse, grid->index_to_world))
        return vv_fail(VV_E_ARGUMENT, "the grid's axes lie in one plane: there are no boxes");
    p->mirrored = vv_affine_determinant(grid->index_to_world) < 0;
    for (int a = 0; a < 3; a++) {
        double length = 0, row[3];
        for (int i = 0; i < 3; i++) {
            row[i] = (&inverse.axis[i].x)[a];
            length = hypot(length, row[i]);
        }
        for (int i = 0; i < 3; i++)
            p->normal[a][i] = (float)(row[i] / length);
    }
    return VV_OK;
}

/* Where boxes begin along an axis; those at the border end at the last sample. */
static double side_of(const placing *p, int axis, int32_t box)
{
    return fmin((double)((int64_t)box << p->boxes->shift), (double)(p->grid->dims[axis] - 1));
}

static void put_face(const vvi_mesh_arrays *to, size_t number, const placing *p, int direction, const face *f)
{
    static const int corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const int axis = direction / 2, u = (axis + 1) % 3, v = (axis + 2) % 3, outwards = direction & 1 ? 1 : -1;
    const vv_vec3 *step = p->grid->index_to_world.axis;
    for (size_t c = 0; c < 4; c++) {
        double at[3];
        at[axis] = side_of(p, axis, f->layer + (direction & 1));
        at[u] = side_of(p, u, corner[c][0] ? f->hi[0] : f->lo[0]);
        at[v] = side_of(p, v, corner[c][1] ? f->hi[1] : f->lo[1]);
        for (int i = 0; i < 3; i++) {
            const size_t out = 3 * (4 * number + c) + (size_t)i;
            to->positions[out] = (float)(at[0] * (&step[0].x)[i] + at[1] * (&step[1].x)[i] + at[2] * (&step[2].x)[i]);
            to->normals[out] = (float)outwards * p->normal[axis][i];
        }
    }
    const bool turned = (outwards < 0) != p->mirrored;
    const uint32_t first = (uint32_t)(4 * number);
    const uint32_t triangles[2][6] = {{0, 1, 2, 0, 2, 3}, {0, 2, 1, 0, 3, 2}};
    for (size_t i = 0; i < 6; i++)
        to->triangles[6 * number + i] = first + triangles[turned][i];
}

static vv_status place_faces(vv_mesh **out, const gathering *g, const vv_grid *grid)
{
    placing p;
    vvi_mesh_arrays arrays;
    vv_mesh_info info = {
        .n_vertices = 4 * g->n, .n_triangles = 2 * g->n, .origin = grid->index_to_world.origin, .space = grid->space};
    memcpy(info.unit, grid->unit, sizeof info.unit);
    vv_status st = open_placing(&p, g->boxes, grid);
    if (st == VV_OK)
        st = vvi_mesh_new(out, &arrays, &info, VVI_MESH_NORMALS, g->job);
    if (st != VV_OK)
        return st;
    for (int d = 0; d < VVI_BOX_FACES; d++)
        for (size_t i = g->first[d]; i < g->first[d + 1]; i++)
            put_face(&arrays, i, &p, d, &g->faces[i]);
    return VV_OK;
}

vv_status vvi_boxes_mesh(vv_mesh **out, const vvi_boxes *boxes, const vv_grid *grid, bool merged, vv_job *job)
{
    gathering g = {.boxes = boxes, .job = job};
    *out = NULL;
    vv_status st = gather(&g, merged);
    if (st == VV_OK)
        st = place_faces(out, &g, grid);
    vvi_free(g.outer);
    vvi_free(g.faces);
    return st;
}

/* Boxes ----------------------------------------------------------------------------------------------------------- */

static bool holds(const void *user, float lo, float hi)
{
    const double *stored = user;
    return lo <= *stored && hi >= *stored;
}

static vv_status check(const vv_field *field, const vvi_surface_boxes_options *o)
{
    const vv_field_info *info = vv_field_get_info(field);
    if (!isfinite(o->value))
        return vv_fail(VV_E_ARGUMENT, "a surface needs a finite value; this is %g", o->value);
    if (o->component < 0 || o->component >= info->components)
        return vv_fail(VV_E_ARGUMENT, "channel %d does not exist; there are 0 to %d", o->component,
                       info->components - 1);
    if (o->shift && (o->shift < SHIFT_LEAST || o->shift > SHIFT_MOST))
        return vv_fail(VV_E_ARGUMENT, "boxes of 2^%d cells; %d to %d are possible", o->shift, SHIFT_LEAST, SHIFT_MOST);
    return VV_OK;
}

/* Whether larger boxes are still of use. */
static bool can_grow(const vvi_boxes *b, const vvi_surface_boxes_options *o)
{
    return !o->shift && b->shift < SHIFT_MOST && (b->n[0] > 1 || b->n[1] > 1 || b->n[2] > 1);
}

/* 0, 1, 2 in the middle of each box. Of a box that holds no surface, all blocks are on one side: they share samples. */
static vv_status make_solid(vv_field **out, const vvi_boxes *b, const vvi_minmax *m, const vv_field_info *of,
                            double stored, vv_job *job)
{
    vv_field_info info = vv_field_info_default();
    const double side = (double)(UINT64_C(1) << b->shift), middle = side / 2;
    void *data;
    info.grid = of->grid;
    info.grid.index_to_world.origin = vv_affine_point(of->grid.index_to_world, (vv_vec3){middle, middle, middle});
    for (int a = 0; a < 3; a++) {
        vv_vec3 *axis = &info.grid.index_to_world.axis[a];
        *axis = (vv_vec3){side * axis->x, side * axis->y, side * axis->z};
        info.grid.dims[a] = b->n[a];
    }
    const vv_status st = vv_field_new_empty(out, &data, &info, job);
    if (st != VV_OK)
        return st;
    uint8_t *to = data;
    for (int32_t k = 0; k < b->n[2]; k++)
        for (int32_t j = 0; j < b->n[1]; j++)
            for (int32_t i = 0; i < b->n[0]; i++) {
                const int up = b->shift - m->shift;
                const size_t block =
                    ((size_t)(k << up) * (size_t)m->n[1] + (size_t)(j << up)) * (size_t)m->n[0] + (size_t)(i << up);
                const double lo = (double)m->lo[block], hi = (double)m->hi[block];
                *to++ = lo <= hi && (of->value_scale > 0 ? lo > stored : hi < stored) ? 2 : 0;
            }
    to = data;
    for (size_t i = 0; i < b->n_kept; i++)
        to[b->kept[i]] = 1;
    return VV_OK;
}

/* Boxes and their mesh within the budget. */
static vv_status fit(vv_mesh **out, vv_field **solid_out, const vvi_minmax *m, const vv_field_info *info,
                     const double *stored, const vvi_surface_boxes_options *o, vv_job *job)
{
    vv_status st = VV_OK;
    for (int shift = o->shift ? o->shift : SHIFT_LEAST; st == VV_OK && !*out; shift++) {
        vvi_boxes *boxes = NULL;
        if ((st = vvi_boxes_build(&boxes, m, shift, holds, stored, job)) != VV_OK)
            return st;
        /* merging leaves no more than all, and hardly less than a twentieth */
        const size_t least = 2 * boxes->n_outer / (o->merged ? 20 : 1), most = o->max_triangles;
        const bool more = most && can_grow(boxes, o);
        if (!more || least <= most)
            st = vvi_boxes_mesh(out, boxes, &info->grid, o->merged, job);
        if (st == VV_OK && *out && more && vv_mesh_get_info(*out)->n_triangles > most) {
            vv_mesh_release(*out);
            *out = NULL;
        }
        if (st == VV_OK && *out && solid_out)
            st = make_solid(solid_out, boxes, m, info, *stored, job);
        vvi_boxes_free(boxes);
    }
    return st;
}

vv_status vvi_surface_boxes(vv_mesh **out, const vv_field *field, const vvi_surface_boxes_options *o, vv_job *job)
{
    return vvi_surface_boxes_solid(out, NULL, field, o, job);
}

vv_status vvi_surface_boxes_solid(vv_mesh **out, vv_field **solid_out, const vv_field *field,
                                  const vvi_surface_boxes_options *o, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    const vv_box all = vv_field_box(field);
    vvi_cached *minmax = NULL;
    vv_brick brick;
    *out = NULL;
    if (solid_out)
        *solid_out = NULL;
    vv_status st = check(field, o);
    if (st != VV_OK || (st = vv_field_brick(&brick, field, &all, job)) != VV_OK)
        return st;
    const bool wide = vv_type_bytes(info->type) > 2 && info->type != VV_TYPE_F32;
    const vvi_cache_key key = vvi_minmax_key(wide ? "minmax wide" : "minmax", field, o->component, SHIFT_LEAST);
    const double stored = (o->value - info->value_offset) / info->value_scale;
    if ((st = vvi_minmax_get(&minmax, &key, &brick, o->component, SHIFT_LEAST, job)) == VV_OK)
        st = fit(out, solid_out, vvi_cached_value(minmax), info, &stored, o, job);
    vvi_cache_release(minmax);
    vv_brick_release(&brick);
    if (st == VV_OK)
        st = vv_field_health(field);
    if (st != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
        vv_field_release(solid_out ? *solid_out : NULL);
        if (solid_out)
            *solid_out = NULL;
    }
    return st;
}
