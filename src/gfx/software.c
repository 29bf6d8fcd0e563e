/* The software back end: calls are taken down, and at the end drawn tile by tile. */
#include "gfx/software.h"
#include "core/cpu.h"
#include "core/job.h"
#include "gfx/texture.h"

static vv_status begin(vvi_gfx *gfx)
{
    vvi_gfx_software_picture *p = vvi_gfx_keep(gfx, sizeof *p);
    if (!p)
        return vv_fail_memory(sizeof *p);
    *p = (vvi_gfx_software_picture){.tiling = {.width = gfx->target.width,
                                               .height = gfx->target.height,
                                               .across = (gfx->target.width + VVI_GFX_TILE - 1) / VVI_GFX_TILE,
                                               .down = (gfx->target.height + VVI_GFX_TILE - 1) / VVI_GFX_TILE}};
    p->kernels = vvi_gfx_kernels_for(vvi_job_cpu(gfx->job));
    gfx->own = p;
    return VV_OK;
}

/* Taking down ----------------------------------------------------------------------------------------------------- */

static vv_status add(vvi_gfx *gfx, vvi_gfx_draw *draw, vvi_gfx_flat *shape)
{
    vvi_gfx_software_picture *p = gfx->own;
    vvi_gfx_command *c = vvi_gfx_keep(gfx, sizeof *c);
    if (!c)
        return vv_fail_memory(sizeof *c);
    *c = (vvi_gfx_command){.draw = draw, .shape = shape};
    return vvi_gfx_list_add(&p->commands, c, gfx->job);
}

enum { RUN = 65536 }; /* triangles or vertices that one item of a loop takes */

static size_t runs_of(size_t n, size_t length)
{
    return (n + length - 1) / length;
}

static vv_status check_run(void *scratch, void *shared, size_t index)
{
    const vv_mesh_info *mesh = shared;
    const size_t all = 3 * mesh->n_triangles, begin = index * RUN, end = all - begin < RUN ? all : begin + RUN;
    const int32_t n = (int32_t)mesh->n_vertices; /* below 2^27 */
    int32_t bad = 0;
    (void)scratch;
    for (size_t i = begin; i < end; i++)
        bad |= ((int32_t)mesh->triangles[i] >= n) | ((int32_t)mesh->triangles[i] < 0);
    for (size_t i = begin; i < end && bad; i++)
        if (mesh->triangles[i] >= mesh->n_vertices)
            return vv_fail(VV_E_ARGUMENT, "triangle %zu uses vertex %u of a mesh of %zu vertices", i / 3,
                           mesh->triangles[i], mesh->n_vertices);
    return VV_OK;
}

static vv_status check_indices(const vv_mesh_info *mesh, vv_job *job)
{
    static const vvi_work work = {.item = check_run};
    return vvi_parallel_for(job, &work, (void *)mesh, runs_of(3 * mesh->n_triangles, RUN));
}

bool vvi_gfx_is_translucent(const vvi_gfx_surface *s)
{
    bool some = s->color.a < 1;
    for (size_t i = 0; i < s->mesh->n_parts && s->mesh->parts && !s->one_color; i++)
        some |= s->mesh->parts[i].color.a >= 0 && s->mesh->parts[i].color.a < 1;
    for (size_t i = 0; i < s->mesh->n_vertices && s->mesh->colors && !s->one_color && !some; i++)
        some = s->mesh->colors[4 * i + 3] < 255;
    for (size_t i = 0; s->textures && i < s->textures->n && !some; i++)
        some = s->textures->texture[i].translucent;
    return some;
}

/* From positions to directions from the eye: the origin is taken off in double precision. */
static vv_affine to_eye(const vvi_gfx_surface *s, const vv_lens *lens)
{
    vv_affine a = s->place;
    a.origin = vvi_sub(vv_affine_point(s->place, s->mesh->origin), lens->eye);
    return a;
}

/* Of some vertices, which tells how large the numbers are. */
static double reach_of(const vvi_gfx_draw *draw)
{
    const vv_mesh_info *mesh = draw->surface.mesh;
    const size_t step = 1 + mesh->n_vertices / 1024;
    double most = 0;
    for (size_t i = 0; i < mesh->n_vertices; i += step) {
        const float *p = mesh->positions + 3 * i;
        const double length =
            vvi_length(vv_affine_point(draw->to_eye, vvi_vec((double)p[0], (double)p[1], (double)p[2])));
        most = isfinite(length) && length > most ? length : most;
    }
    return most;
}

/* Kernels count bytes and numbers in 31 bits: 16 bytes a vertex, 3 numbers a triangle. */
#define MOST_VERTICES ((1u << 27) - 1)
#define MOST_TRIANGLES (UINT32_C(0x7fffffff) / 3)

static vv_status mesh(vvi_gfx *gfx, const vvi_gfx_surface *surface)
{
    vvi_gfx_software_picture *p = gfx->own;
    if (surface->mesh->n_triangles > MOST_TRIANGLES - p->n_ids || surface->mesh->n_vertices > MOST_VERTICES)
        return vv_fail(VV_E_LIMIT,
                       "a mesh of %zu triangles and %zu vertices is too large: a picture can have %u triangles, and a "
                       "mesh %u vertices",
                       surface->mesh->n_triangles, surface->mesh->n_vertices, MOST_TRIANGLES, MOST_VERTICES);
    vv_status st = check_indices(surface->mesh, gfx->job);
    if (st != VV_OK)
        return st;
    const size_t bytes = (surface->mesh->n_vertices + 1) * sizeof(vvi_gfx_vertex);
    vvi_gfx_draw *draw = vvi_gfx_keep(gfx, sizeof *draw);
    if (!draw)
        return vv_fail_memory(sizeof *draw);
    *draw = (vvi_gfx_draw){.state = gfx->state,
                           .surface = *surface,
                           .translucent = vvi_gfx_is_translucent(surface),
                           .mirrored = vv_affine_determinant(surface->place) < 0,
                           .first = 1 + p->n_ids,
                           .to_eye = to_eye(surface, &gfx->state.view->lens),
                           .vertices = vvi_gfx_keep(gfx, bytes)};
    if (!draw->vertices)
        return vv_fail_memory(bytes);
    draw->reach = reach_of(draw);
    vvi_gfx_prepared *prepared;
    if ((st = vvi_gfx_prepare(&prepared, gfx, draw)) != VV_OK)
        return st;
    draw->prepared = prepared;
    if ((st = add(gfx, draw, NULL)) == VV_OK)
        p->n_ids += (uint32_t)surface->mesh->n_triangles;
    p->translucent |= draw->translucent;
    return st;
}

static vv_status add_shape(vvi_gfx *gfx, vvi_gfx_flat *shape, vv_status st)
{
    return st == VV_OK && shape ? add(gfx, NULL, shape) : st;
}

static vv_status line(vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, vvi_gfx_join join,
                      const vvi_gfx_stroke *stroke)
{
    vvi_gfx_flat *shape;
    const vv_status st = vvi_gfx_flat_line(&shape, gfx, points, n_points, join, stroke, false);
    return add_shape(gfx, shape, st);
}

static vv_status points(vvi_gfx *gfx, const vv_vec3 *places, size_t n_points, double diameter, vv_color color)
{
    vvi_gfx_flat *shape;
    const vv_status st = vvi_gfx_flat_points(&shape, gfx, places, n_points, diameter, color);
    return add_shape(gfx, shape, st);
}

static vv_status polygon(vvi_gfx *gfx, const vv_vec3 *places, size_t n_points, const vvi_gfx_fill *fill)
{
    vvi_gfx_flat *shape;
    const vv_status st = vvi_gfx_flat_polygon(&shape, gfx, places, n_points, fill);
    return add_shape(gfx, shape, st);
}

static vv_status text(vvi_gfx *gfx, vv_vec3 at, const vvi_gfx_label *label, const char *utf8)
{
    vvi_gfx_flat *shape[2];
    vv_status st = vvi_gfx_flat_text(shape, gfx, at, label, utf8);
    for (int i = 0; i < 2; i++)
        st = add_shape(gfx, shape[i], st);
    return st;
}

/* Drawing --------------------------------------------------------------------------------------------------------- */

typedef struct run {
    vvi_gfx_draw *draw;
    uint32_t begin, end;
    const vvi_gfx_kernels *kernels;
    const vv_job *job;
} run;

static vv_status project_item(void *scratch, void *shared, size_t index)
{
    const run *r = (const run *)shared + index;
    (void)scratch;
    r->kernels->project(r->draw->vertices + r->begin, r->draw->surface.mesh->positions + 3 * (size_t)r->begin,
                        r->end - r->begin, &r->draw->prepared->projection);
    return vvi_job_poll(r->job);
}

static vvi_gfx_draw *draw_of(const vvi_gfx_software_picture *p, size_t i)
{
    return ((const vvi_gfx_command *)p->commands.item[i])->draw;
}

static vv_status project(vvi_gfx *gfx)
{
    static const vvi_work work = {.item = project_item};
    const vvi_gfx_software_picture *p = gfx->own;
    size_t n = 0, i = 0;
    for (size_t c = 0; c < p->commands.n; c++)
        n += draw_of(p, c) ? runs_of(draw_of(p, c)->surface.mesh->n_vertices, RUN) : 0;
    run *runs = vvi_alloc(gfx->job, (n + 1) * sizeof *runs, VVI_MEM_SCRATCH);
    if (!runs)
        return vv_fail_memory((n + 1) * sizeof *runs);
    for (size_t c = 0; c < p->commands.n; c++) {
        vvi_gfx_draw *draw = draw_of(p, c);
        const size_t all = draw ? draw->surface.mesh->n_vertices : 0;
        for (size_t v = 0; v < all; v += RUN)
            runs[i++] = (run){draw, (uint32_t)v, (uint32_t)(all - v > RUN ? v + RUN : all), p->kernels, gfx->job};
    }
    const vv_status st = vvi_parallel_for(gfx->job, &work, runs, n);
    vvi_free(runs);
    return st;
}

static vv_status bin_item(void *scratch, void *shared, size_t index)
{
    vvi_gfx *gfx = shared;
    vvi_gfx_software_picture *p = gfx->own;
    (void)scratch;
    const vv_status st = vvi_gfx_bin_fill(&p->bins[index], &p->tiling, gfx->target.samples, p->kernels, gfx->job);
    return st == VV_OK ? vvi_job_poll(gfx->job) : st;
}

static vv_status bin(vvi_gfx *gfx)
{
    static const vvi_work work = {.item = bin_item};
    vvi_gfx_software_picture *p = gfx->own;
    size_t n = 0;
    for (size_t c = 0; c < p->commands.n; c++)
        n += draw_of(p, c) ? runs_of(draw_of(p, c)->surface.mesh->n_triangles, VVI_GFX_BIN) : 0;
    p->bins = vvi_alloc_zeroed(gfx->job, (n + 1) * sizeof *p->bins, VVI_MEM_SCRATCH);
    if (!p->bins)
        return vv_fail_memory((n + 1) * sizeof *p->bins);
    for (size_t c = 0; c < p->commands.n; c++) {
        const vvi_gfx_draw *draw = draw_of(p, c);
        const size_t all = draw ? draw->surface.mesh->n_triangles : 0;
        for (size_t t = 0; t < all; t += VVI_GFX_BIN)
            p->bins[p->n_bins++] = (vvi_gfx_bin){
                .draw = draw, .first = (uint32_t)t, .n = (uint32_t)(all - t > VVI_GFX_BIN ? VVI_GFX_BIN : all - t)};
    }
    return vvi_parallel_for(gfx->job, &work, gfx, n);
}

static vv_status tile_start(void **scratch_out, void *shared, int worker)
{
    vvi_gfx_tile_room *room = NULL;
    (void)worker;
    const vv_status st = vvi_gfx_tile_room_new(&room, shared);
    *scratch_out = room;
    return st;
}

static void tile_finish(void *scratch, void *shared)
{
    (void)shared;
    vvi_gfx_tile_room_free(scratch);
}

static vv_status tile_item(void *scratch, void *shared, size_t index)
{
    return vvi_gfx_tile_draw(shared, scratch, index);
}

static vv_status end(vvi_gfx *gfx)
{
    static const vvi_work work = {.start = tile_start, .item = tile_item, .finish = tile_finish};
    const vvi_gfx_software_picture *p = gfx->own;
    vv_status st = project(gfx);
    if (st != VV_OK || (st = bin(gfx)) != VV_OK)
        return st;
    return vvi_parallel_for(gfx->job, &work, gfx, (size_t)p->tiling.across * (size_t)p->tiling.down);
}

static void close_picture(vvi_gfx *gfx)
{
    vvi_gfx_software_picture *p = gfx->own;
    if (!p)
        return;
    for (size_t i = 0; i < p->n_bins; i++)
        vvi_gfx_bin_free(&p->bins[i]);
    vvi_free(p->bins);
    vvi_gfx_list_free(&p->commands);
}

const vvi_gfx_backend vvi_gfx_software = {
    .name = "software",
    .doc = "an image, drawn by the processor's cores",
    .begin = begin,
    .mesh = mesh,
    .line = line,
    .points = points,
    .polygon = polygon,
    .text = text,
    .pick = vvi_gfx_software_pick,
    .end = end,
    .close = close_picture,
};
