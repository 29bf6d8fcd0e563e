/* Light of one fragment, in double precision. */
#include "gfx/lighting.h"
#include "gfx/mesh_look.h"
#include <volvis/image.h>

static vv_vec3 vector_at(const float *numbers, uint32_t i)
{
    return vvi_vec((double)numbers[3 * (size_t)i], (double)numbers[3 * (size_t)i + 1],
                   (double)numbers[3 * (size_t)i + 2]);
}

/* Shares of the three corners where the ray meets the triangle's plane, none below 0 (Moeller & Trumbore 1997). */
static void shares(double out[3], vv_vec3 start, vv_vec3 way, const vv_vec3 corner[3])
{
    const vv_vec3 e1 = vvi_sub(corner[1], corner[0]), e2 = vvi_sub(corner[2], corner[0]), p = vvi_cross(way, e2),
                  from = vvi_sub(start, corner[0]);
    const double det = vvi_dot(e1, p), inverse = det != 0 ? 1 / det : 0;
    const double u = vvi_dot(from, p) * inverse, v = vvi_dot(way, vvi_cross(from, e1)) * inverse;
    out[0] = fmax(0, 1 - u - v);
    out[1] = fmax(0, u);
    out[2] = fmax(0, v);
    const double sum = out[0] + out[1] + out[2];
    for (int i = 0; i < 3; i++)
        out[i] = isfinite(sum) && sum > 0 ? out[i] / sum : 1.0 / 3;
}

static vv_vec3 mean(const vv_vec3 v[3], const double share[3])
{
    return vvi_add(vvi_add(vvi_scaled(v[0], share[0]), vvi_scaled(v[1], share[1])), vvi_scaled(v[2], share[2]));
}

void vvi_gfx_shade_ref(vvi_gfx_fragment *f, const vvi_gfx_draw *draw)
{
    const vvi_gfx_view *view = draw->state.view;
    const vvi_gfx_material *m = &draw->state.material;
    const vv_mesh_info *mesh = draw->surface.mesh;
    const uint32_t *index = mesh->triangles + 3 * (size_t)f->triangle;
    const vv_vec3 across = vvi_add(vvi_scaled(view->lens.right, ((double)f->x - view->middle_x) / view->scale_x),
                                   vvi_scaled(view->lens.up, (view->middle_y - (double)f->y) / view->scale_y));
    vv_vec3 way = view->lens.parallel ? view->lens.forward : vvi_add(view->lens.forward, across);
    const vv_vec3 start = view->lens.parallel ? across : vvi_vec(0, 0, 0);
    vv_vec3 corner[3];
    double share[3], rgba[4];
    vvi_unit(&way);
    for (int k = 0; k < 3; k++)
        corner[k] = vv_affine_point(draw->to_eye, vector_at(mesh->positions, index[k]));
    shares(share, start, way, corner);
    const vv_vec3 place = mean(corner, share), to_eye = vvi_scaled(way, -1);
    vv_vec3 n;
    const bool known = vvi_gfx_normal_at(&n, mesh, &draw->to_eye, f->triangle, share, m->flat);
    if (!known)
        n = to_eye;
    if (m->sides == VVI_GFX_FACING && vvi_dot(n, to_eye) < 0)
        n = vvi_scaled(n, -1);
    vvi_gfx_color_at(rgba, &draw->surface, NULL, f->triangle, share);
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
