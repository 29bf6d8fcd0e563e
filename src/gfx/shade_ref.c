/* Light of one fragment, in double precision. */
#include "gfx/lighting.h"
#include "gfx/mesh_look.h"
#include <volvis/image.h>

static vv_vec3 vector_at(const float *numbers, uint32_t i)
{
    return vvi_vec((double)numbers[3 * (size_t)i], (double)numbers[3 * (size_t)i + 1],
                   (double)numbers[3 * (size_t)i + 2]);
}

static vv_vec3 mean(const vv_vec3 v[3], const double share[3])
{
    return vvi_add(vvi_add(vvi_scaled(v[0], share[0]), vvi_scaled(v[1], share[1])), vvi_scaled(v[2], share[2]));
}

/* From the eye; the way has any length. */
static void meet(vv_vec3 *start, vv_vec3 *way, vv_vec3 corner[3], const vvi_gfx_draw *draw, uint32_t triangle, double x,
                 double y)
{
    const vvi_gfx_view *view = draw->state.view;
    const vv_mesh_info *mesh = draw->surface.mesh;
    const vv_vec3 across = vvi_add(vvi_scaled(view->lens.right, (x - view->middle_x) / view->scale_x),
                                   vvi_scaled(view->lens.up, (view->middle_y - y) / view->scale_y));
    *way = view->lens.parallel ? view->lens.forward : vvi_add(view->lens.forward, across);
    *start = view->lens.parallel ? across : vvi_vec(0, 0, 0);
    for (size_t k = 0; k < 3; k++)
        corner[k] =
            vv_affine_point(draw->to_eye, vector_at(mesh->positions, mesh->triangles[3 * (size_t)triangle + k]));
}

void vvi_gfx_color_ref(double rgba[4], const vvi_gfx_draw *draw, const vvi_gfx_decode *decode, uint32_t triangle,
                       double x, double y)
{
    vv_vec3 start, way, corner[3];
    double share[3], slope[2][3];
    meet(&start, &way, corner, draw, triangle, x, y);
    vvi_gfx_shares(share, start, way, corner);
    if (draw->surface.textures)
        vvi_gfx_share_slopes(slope, draw->state.view, start, way, corner);
    vvi_gfx_color_at(rgba, &draw->surface, decode, triangle, share,
                     draw->surface.textures ? (const double(*)[3])slope : NULL);
}

void vvi_gfx_shade_ref(vvi_gfx_fragment *f, const vvi_gfx_draw *draw)
{
    const vvi_gfx_view *view = draw->state.view;
    const vvi_gfx_material *m = &draw->state.material;
    vv_vec3 start, way, corner[3], n;
    double share[3], rgba[4];
    meet(&start, &way, corner, draw, f->triangle, (double)f->x, (double)f->y);
    vvi_unit(&way);
    vvi_gfx_shares(share, start, way, corner);
    const vv_vec3 place = mean(corner, share), to_eye = vvi_scaled(way, -1);
    const bool known = vvi_gfx_normal_at(&n, draw->surface.mesh, &draw->to_eye, f->triangle, share, m->flat);
    if (!known)
        n = to_eye;
    if (m->sides == VVI_GFX_FACING && vvi_dot(n, to_eye) < 0)
        n = vvi_scaled(n, -1);
    vvi_gfx_color_ref(rgba, draw, NULL, f->triangle, (double)f->x, (double)f->y);
    const vvi_gloss gloss =
        vvi_gloss_of(m->model, m->ambient, m->diffuse, m->specular, m->shininess, draw->state.lights->ambient);
    const vvi_lit_point point = {.position = vvi_add(place, view->lens.eye),
                                 .normal = n,
                                 .to_eye = to_eye,
                                 .surface = known,
                                 .two_sided = m->sides == VVI_GFX_BOTH};
    if (m->model != VV_SHADING_NONE)
        vvi_light_ref(rgba, &point, &gloss, draw->state.lights->lamps, draw->state.lights->n_lamps);
    for (int c = 0; c < 4; c++)
        f->rgba[c] = (float)rgba[c];
    f->depth = (float)fmax(vvi_dot(vvi_sub(place, start), way), vvi_gfx_nearest(draw));
    f->normal[0] = (float)n.x, f->normal[1] = (float)n.y, f->normal[2] = (float)n.z;
}
