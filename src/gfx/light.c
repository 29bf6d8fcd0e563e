/* Light of the fragments of a tile, by the mesh that they belong to. */
#include "gfx/software.h"
#include "gfx/texture.h"

static bool is_of(const vvi_gfx_draw *draw, uint32_t id)
{
    return id - draw->first < draw->surface.mesh->n_triangles;
}

const vvi_gfx_draw *vvi_gfx_draw_of(const vvi_gfx_software_picture *p, uint32_t id)
{
    for (size_t i = 0; i < p->commands.n; i++) {
        const vvi_gfx_draw *draw = ((const vvi_gfx_command *)p->commands.item[i])->draw;
        if (draw && is_of(draw, id))
            return draw;
    }
    return NULL;
}

/* Of what kernels do not know: one by one. */
static void look_up_colors(vvi_gfx_fragments *f, const vvi_gfx_draw *draw)
{
    for (size_t i = 0; i < f->n; i++) {
        double rgba[4];
        vvi_gfx_color_ref(rgba, draw, &draw->surface.textures->decode, f->triangle[i], (double)f->x[i],
                          (double)f->y[i]);
        for (int c = 0; c < 4; c++)
            f->rgba[c][i] = (float)rgba[c];
    }
}

/* Colours of the mesh or of its parts. */
static void base_colors(vvi_gfx_fragments *f, const vvi_gfx_draw *draw)
{
    if (draw->surface.textures) {
        look_up_colors(f, draw);
        return;
    }
    const vv_mesh_info *mesh = draw->surface.mesh;
    const vv_color one = draw->surface.color;
    size_t part = 0;
    for (size_t i = 0; i < f->n; i++) {
        vv_color c = one;
        if (mesh->parts && !draw->surface.one_color) {
            while (part && f->triangle[i] < mesh->parts[part].first_triangle)
                part--;
            while (part + 1 < mesh->n_parts && f->triangle[i] >= mesh->parts[part + 1].first_triangle)
                part++;
            if (mesh->parts[part].color.a >= 0) {
                c = mesh->parts[part].color;
                c.a *= one.a;
            }
        }
        f->rgba[0][i] = (float)c.r, f->rgba[1][i] = (float)c.g, f->rgba[2][i] = (float)c.b, f->rgba[3][i] = (float)c.a;
    }
}

static void copy_fragment(vvi_gfx_fragments *to, size_t t, const vvi_gfx_fragments *from, size_t f)
{
    for (int c = 0; c < 4; c++)
        to->rgba[c][t] = from->rgba[c][f];
    for (int c = 0; c < 3; c++)
        to->normal[c][t] = from->normal[c][f];
    to->depth[t] = from->depth[f];
}

static void light_some(vvi_gfx_tile_room *r, const vvi_gfx_draw *draw, const vvi_gfx_kernels *kernels)
{
    vvi_gfx_fragments *all = &r->fragments, *some = &r->some;
    some->n = 0;
    for (size_t i = 0; i < all->n; i++)
        if (is_of(draw, r->id[i])) {
            some->triangle[some->n] = r->id[i] - draw->first;
            some->x[some->n] = all->x[i];
            some->y[some->n++] = all->y[i];
        }
    base_colors(some, draw);
    kernels->shade(some, &draw->prepared->lighting);
    for (size_t i = 0, n = 0; i < all->n; i++)
        if (is_of(draw, r->id[i]))
            copy_fragment(all, i, some, n++);
}

void vvi_gfx_light(vvi_gfx_tile_room *r, const vvi_gfx_software_picture *p)
{
    vvi_gfx_fragments *all = &r->fragments;
    const vvi_gfx_draw *draw = all->n ? vvi_gfx_draw_of(p, r->id[0]) : NULL;
    bool one = true;
    for (size_t i = 0; i < all->n; i++)
        one &= is_of(draw, r->id[i]);
    if (!one) {
        for (size_t i = 0; i < p->commands.n; i++)
            if ((draw = ((const vvi_gfx_command *)p->commands.item[i])->draw))
                light_some(r, draw, p->kernels);
        return;
    }
    for (size_t i = 0; i < all->n; i++)
        all->triangle[i] = r->id[i] - draw->first;
    if (!all->n)
        return;
    base_colors(all, draw);
    p->kernels->shade(all, &draw->prepared->lighting);
}
