#include "gfx/bin.h"
#include <string.h>

/* Right, up, forward. */
static vv_vec3 eye_place(const vvi_gfx_draw *draw, uint32_t vertex)
{
    const float *p = draw->surface.mesh->positions + 3 * (size_t)vertex;
    const vv_lens *lens = &draw->state.view->lens;
    const vv_vec3 w = vv_affine_point(draw->to_eye, vvi_vec((double)p[0], (double)p[1], (double)p[2]));
    return vvi_vec(vvi_dot(w, lens->right), vvi_dot(w, lens->up), vvi_dot(w, lens->forward));
}

/* Half-spaces that triangles are cut by, in the order of the bits of vvi_gfx_vertex.out from VVI_GFX_OUT_NEAR on: how
 * far inside a place is. */
static double inside(const vvi_gfx_draw *draw, size_t plane, vv_vec3 p)
{
    const vvi_gfx_view *view = draw->state.view;
    const double reach = view->lens.parallel ? VVI_GFX_REACH : VVI_GFX_REACH * p.z;
    if (plane == 0)
        return p.z - vvi_gfx_nearest(draw);
    if (plane <= 2)
        return plane == 1 ? reach + view->scale_x * p.x : reach - view->scale_x * p.x;
    if (plane <= 4)
        return plane == 3 ? reach - view->scale_y * p.y : reach + view->scale_y * p.y;
    const vv_plane *cut = &draw->state.cuts->planes[plane - 5];
    const vv_lens *lens = &view->lens;
    const vv_vec3 n = {vvi_dot(cut->normal, lens->right), vvi_dot(cut->normal, lens->up),
                       vvi_dot(cut->normal, lens->forward)};
    return vvi_dot(n, p) - (cut->offset - vvi_dot(cut->normal, lens->eye));
}

static size_t planes_of(const vvi_gfx_draw *draw)
{
    return 5 + draw->state.cuts->n_planes;
}

static uint32_t bit_of(size_t plane)
{
    return plane < 31 ? (uint32_t)VVI_GFX_OUT_NEAR << plane : 1u << 31;
}

static vvi_gfx_vertex on_picture(const vvi_gfx_draw *draw, vv_vec3 eye)
{
    const vvi_gfx_spot s = vvi_gfx_spot_of(draw->state.view, eye);
    return (vvi_gfx_vertex){.x = (int32_t)floor(s.x * VVI_GFX_STEPS + 0.5),
                            .y = (int32_t)floor(s.y * VVI_GFX_STEPS + 0.5),
                            .near = (float)s.near};
}

/* Cutting --------------------------------------------------------------------------------------------------------- */

typedef struct corner {
    vv_vec3 eye;
    vvi_gfx_vertex vertex;
    bool placed; /* the vertex is known */
} corner;

/* Between two corners on both sides of a plane, from the one inside to the one outside, so that the triangles on both
 * sides of an edge get the same place. */
static corner cross_plane(corner in, corner out, double d_in, double d_out)
{
    const vv_vec3 way = vvi_sub(out.eye, in.eye);
    return (corner){.eye = vvi_add(in.eye, vvi_scaled(way, d_in / (d_in - d_out)))};
}

static size_t cut_by(corner *to, const corner *from, size_t n, const vvi_gfx_draw *draw, size_t plane)
{
    size_t m = 0;
    for (size_t i = 0; i < n; i++) {
        const corner a = from[i], b = from[(i + 1) % n];
        const double da = inside(draw, plane, a.eye), db = inside(draw, plane, b.eye);
        if (da >= 0)
            to[m++] = a;
        if ((da < 0) != (db < 0))
            to[m++] = da < 0 ? cross_plane(b, a, db, da) : cross_plane(a, b, da, db);
    }
    return m;
}

static vv_status add_piece(vvi_gfx_bin *bin, const corner *a, const corner *b, const corner *c, uint32_t id,
                           vv_job *job)
{
    if (bin->n_pieces == bin->room) {
        const size_t room = bin->room ? 2 * bin->room : 64;
        vvi_gfx_triangle *more = vvi_realloc(job, bin->pieces, room * sizeof *more, VVI_MEM_SCRATCH);
        if (!more)
            return vv_fail_memory(room * sizeof *more);
        bin->pieces = more;
        bin->room = room;
    }
    const vvi_gfx_vertex v[3] = {a->vertex, b->vertex, c->vertex};
    vvi_gfx_triangle *t = &bin->pieces[bin->n_pieces++];
    *t = (vvi_gfx_triangle){.id = id};
    for (int k = 0; k < 3; k++) {
        t->x[k] = v[k].x;
        t->y[k] = v[k].y;
        t->near[k] = v[k].near;
    }
    return VV_OK;
}

/* The pieces of a triangle some of whose corners are out. room: two polygons. */
static vv_status cut_triangle(vvi_gfx_bin *bin, uint32_t triangle, uint32_t out, corner *room, vv_job *job)
{
    const vvi_gfx_draw *draw = bin->draw;
    const uint32_t *index = draw->surface.mesh->triangles + 3 * (size_t)triangle;
    const size_t n_planes = planes_of(draw);
    corner *from = room, *to = room + 3 + n_planes;
    size_t n = 3;
    vv_status st = VV_OK;
    if (out & VVI_GFX_OUT_NEAR) /* what is cut off near the eye may lie anywhere on the picture */
        out |= 15 * VVI_GFX_OUT_SIDES;
    for (int k = 0; k < 3; k++) {
        const vvi_gfx_vertex v = draw->vertices[index[k]];
        from[k] = (corner){.eye = eye_place(draw, index[k]), .vertex = v, .placed = !(v.out & (VVI_GFX_OUT_CUTS - 1))};
    }
    for (size_t p = 0; p < n_planes && n >= 3; p++) {
        if (!(out & bit_of(p)))
            continue;
        n = cut_by(to, from, n, draw, p);
        corner *swap = from;
        from = to;
        to = swap;
    }
    for (size_t k = 0; k < n; k++)
        if (!from[k].placed)
            from[k].vertex = on_picture(draw, from[k].eye);
    for (size_t k = 2; k < n && st == VV_OK; k++)
        st = add_piece(bin, &from[0], &from[k - 1], &from[k], draw->first + triangle, job);
    return st;
}

/* Sorting --------------------------------------------------------------------------------------------------------- */

typedef struct sorter {
    vvi_gfx_bin *bin;
    const vvi_gfx_tiling *tiling;
    vvi_gfx_area window;   /* pixels */
    vvi_gfx_sorted sorted; /* by the kernel: triangles that lie in one tile */
    uint32_t *code;        /* all others, and pieces, that are to be drawn */
    vvi_gfx_area *tiles;   /* and their tiles */
    size_t n, room;
    vv_job *job;
} sorter;

void vvi_gfx_bin_triangle(vvi_gfx_triangle *out, const vvi_gfx_bin *bin, uint32_t entry)
{
    if (entry & (uint32_t)VVI_GFX_CUT) {
        *out = bin->pieces[entry & ~(uint32_t)VVI_GFX_CUT];
        return;
    }
    const uint32_t *index = bin->draw->surface.mesh->triangles + 3 * (size_t)(bin->first + entry);
    out->id = bin->draw->first + bin->first + entry;
    for (int k = 0; k < 3; k++) {
        const vvi_gfx_vertex *v = &bin->draw->vertices[index[k]];
        out->x[k] = v->x;
        out->y[k] = v->y;
        out->near[k] = v->near;
    }
}

static int32_t least(const int32_t v[3])
{
    const int32_t a = v[0] < v[1] ? v[0] : v[1];
    return a < v[2] ? a : v[2];
}

static int32_t most(const int32_t v[3])
{
    const int32_t a = v[0] > v[1] ? v[0] : v[1];
    return a > v[2] ? a : v[2];
}

/* Whether the side that is seen is not wanted. The picture's y goes down: fronts have areas below 0 there. */
static bool culled(const vvi_gfx_draw *draw, int64_t area)
{
    const bool front = (area < 0) != draw->mirrored;
    return !area || (draw->surface.cull == VVI_GFX_NO_BACKS && !front) ||
           (draw->surface.cull == VVI_GFX_NO_FRONTS && front);
}

/* Takes down a triangle or a piece with the tiles that its box touches. */
static vv_status note(sorter *s, uint32_t code)
{
    vvi_gfx_triangle t;
    vvi_gfx_bin_triangle(&t, s->bin, code);
    const int64_t area =
        (int64_t)(t.x[1] - t.x[0]) * (t.y[2] - t.y[0]) - (int64_t)(t.y[1] - t.y[0]) * (t.x[2] - t.x[0]);
    vvi_gfx_area box = {least(t.x) >> 8, least(t.y) >> 8, most(t.x) >> 8, most(t.y) >> 8};
    if (culled(s->bin->draw, area) || box.x1 < s->window.x0 || box.y1 < s->window.y0 || box.x0 >= s->window.x1 ||
        box.y0 >= s->window.y1)
        return VV_OK;
    if (s->n == s->room) {
        const size_t room = s->room ? 2 * s->room : VVI_GFX_BIN;
        uint32_t *code_more = vvi_realloc(s->job, s->code, room * sizeof *code_more, VVI_MEM_SCRATCH);
        s->code = code_more ? code_more : s->code;
        vvi_gfx_area *more = vvi_realloc(s->job, s->tiles, room * sizeof *more, VVI_MEM_SCRATCH);
        s->tiles = more ? more : s->tiles;
        if (!more || !code_more)
            return vv_fail_memory(room * sizeof *more);
        s->room = room;
    }
    s->code[s->n] = code;
    s->tiles[s->n++] = (vvi_gfx_area){(box.x0 > s->window.x0 ? box.x0 : s->window.x0) / VVI_GFX_TILE,
                                      (box.y0 > s->window.y0 ? box.y0 : s->window.y0) / VVI_GFX_TILE,
                                      (box.x1 < s->window.x1 - 1 ? box.x1 : s->window.x1 - 1) / VVI_GFX_TILE,
                                      (box.y1 < s->window.y1 - 1 ? box.y1 : s->window.y1 - 1) / VVI_GFX_TILE};
    return VV_OK;
}

static vv_status note_cut(sorter *s, uint32_t triangle, uint32_t out, corner *room)
{
    const size_t before = s->bin->n_pieces;
    vv_status st = cut_triangle(s->bin, triangle, out, room, s->job);
    for (size_t i = before; i < s->bin->n_pieces && st == VV_OK; i++)
        st = note(s, (uint32_t)VVI_GFX_CUT | (uint32_t)i);
    return st;
}

/* Triangles that the kernel left. */
static vv_status note_others(sorter *s, corner *room)
{
    const vvi_gfx_bin *bin = s->bin;
    const vvi_gfx_vertex *vertices = bin->draw->vertices;
    vv_status st = VV_OK;
    for (size_t i = 0; i < s->sorted.n_other && st == VV_OK; i++) {
        const uint32_t t = (uint32_t)s->sorted.other[i];
        const uint32_t *index = bin->draw->surface.mesh->triangles + 3 * (size_t)(bin->first + t);
        const uint32_t any = vertices[index[0]].out | vertices[index[1]].out | vertices[index[2]].out;
        if (!(any & VVI_GFX_OUT_NAN))
            st = any ? note_cut(s, bin->first + t, any, room) : note(s, t);
    }
    return st;
}

/* Of the tiles of a triangle: how many entries each has, or, with `entry`, the next one. */
static void each_tile(const sorter *s, uint32_t *next, uint32_t *entry)
{
    const size_t ahead = entry ? 0 : 1;
    for (size_t i = 0; i < s->sorted.n_single; i++) {
        uint32_t *at = &next[(size_t)s->sorted.tile[i] + ahead];
        if (entry)
            entry[*at] = (uint32_t)s->sorted.single[i];
        ++*at;
    }
    for (size_t i = 0; i < s->n; i++)
        for (int32_t y = s->tiles[i].y0; y <= s->tiles[i].y1; y++)
            for (int32_t x = s->tiles[i].x0; x <= s->tiles[i].x1; x++) {
                uint32_t *at = &next[(size_t)y * (size_t)s->tiling->across + (size_t)x + ahead];
                if (entry)
                    entry[*at] = s->code[i];
                ++*at;
            }
}

/* Counting sort: what is in one tile stays in order. */
static vv_status sort(sorter *s)
{
    const size_t n_tiles = (size_t)s->tiling->across * (size_t)s->tiling->down;
    vvi_gfx_bin *bin = s->bin;
    uint64_t total = 0;
    bin->begin = vvi_alloc_zeroed(s->job, (n_tiles + 2) * sizeof *bin->begin, VVI_MEM_SCRATCH);
    if (!bin->begin)
        return vv_fail_memory((n_tiles + 2) * sizeof *bin->begin);
    uint32_t *next = bin->begin + 1; /* moves from a tile's begin to its end, which is the next one's begin */
    each_tile(s, next, NULL);
    for (size_t i = 0; i <= n_tiles; i++) {
        total += next[i];
        next[i] = (uint32_t)total;
    }
    if (total > UINT32_MAX)
        return vv_fail(VV_E_LIMIT, "%u triangles cover more tiles than can be counted", bin->n);
    bin->entry = vvi_alloc(s->job, ((size_t)total + 1) * sizeof *bin->entry, VVI_MEM_SCRATCH);
    if (!bin->entry)
        return vv_fail_memory(((size_t)total + 1) * sizeof *bin->entry);
    each_tile(s, next, bin->entry);
    return VV_OK;
}

static vv_status sort_by_kernel(sorter *s, int samples, const vvi_gfx_kernels *kernels)
{
    const vvi_gfx_draw *draw = s->bin->draw;
    const size_t each = VVI_GFX_BIN + VVI_GFX_SPARE;
    const bool no_fronts = draw->surface.cull == VVI_GFX_NO_FRONTS, no_backs = draw->surface.cull == VVI_GFX_NO_BACKS;
    const vvi_gfx_sorting sorting = {.triangles = draw->surface.mesh->triangles + 3 * (size_t)s->bin->first,
                                     .vertices = draw->vertices,
                                     .window = s->window,
                                     .across = s->tiling->across,
                                     .samples = samples,
                                     /* fronts go counter-clockwise in the mesh, and on the picture */
                                     .no_clockwise = draw->mirrored ? no_fronts : no_backs,
                                     .no_counterclockwise = draw->mirrored ? no_backs : no_fronts};
    s->sorted.single = vvi_alloc(s->job, 3 * each * sizeof *s->sorted.single, VVI_MEM_SCRATCH);
    if (!s->sorted.single)
        return vv_fail_memory(3 * each * sizeof *s->sorted.single);
    s->sorted.tile = s->sorted.single + each;
    s->sorted.other = s->sorted.tile + each;
    kernels->sort(&s->sorted, &sorting, s->bin->n);
    return VV_OK;
}

vv_status vvi_gfx_bin_fill(vvi_gfx_bin *bin, const vvi_gfx_tiling *tiling, int samples, const vvi_gfx_kernels *kernels,
                           vv_job *job)
{
    const double *w = bin->draw->state.window;
    sorter s = {.bin = bin,
                .tiling = tiling,
                .window = {(int32_t)floor(w[0]), (int32_t)floor(w[1]), (int32_t)ceil(w[2]), (int32_t)ceil(w[3])},
                .job = job};
    const size_t room_bytes = 2 * (3 + planes_of(bin->draw)) * sizeof(corner);
    corner *room = vvi_alloc(job, room_bytes, VVI_MEM_SCRATCH);
    vv_status st = room ? sort_by_kernel(&s, samples, kernels) : vv_fail_memory(room_bytes);
    if (st == VV_OK && (st = note_others(&s, room)) == VV_OK)
        st = sort(&s);
    vvi_free(room);
    vvi_free(s.sorted.single);
    vvi_free(s.code);
    vvi_free(s.tiles);
    return st;
}

void vvi_gfx_bin_free(vvi_gfx_bin *bin)
{
    vvi_free(bin->begin);
    vvi_free(bin->entry);
    vvi_free(bin->pieces);
}
