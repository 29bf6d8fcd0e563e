/* Light of one fragment, in double precision. */
#include "gfx/lighting.h"
#include <volvis/image.h>

/* The way to a lamp (length 1) and its colour at a place; both from the eye. */
static void lamp_at(vv_vec3 *to_lamp, double light[3], const vv_lamp *lamp, vv_vec3 place)
{
    double share = 1;
    *to_lamp = vvi_scaled(lamp->direction, -1);
    if (lamp->kind != VV_LIGHT_DIRECTIONAL) {
        *to_lamp = vvi_sub(lamp->position, place);
        const double d = vvi_length(*to_lamp);
        *to_lamp = d > 0 ? vvi_scaled(*to_lamp, 1 / d) : vvi_vec(0, 0, 1);
        share = 1 / (lamp->falloff.x + d * (lamp->falloff.y + d * lamp->falloff.z));
    }
    if (lamp->kind == VV_LIGHT_SPOT) {
        const double c = -vvi_dot(*to_lamp, lamp->direction);
        const double fade = (c - lamp->cos_outer) / fmax(lamp->cos_inner - lamp->cos_outer, 1e-9);
        const double t = fmin(1, fmax(0, fade));
        share *= t * t * (3 - 2 * t);
    }
    for (int c = 0; c < 3; c++)
        light[c] = share * (double)lamp->color[c];
}

static double highlight(const vvi_gfx_material *m, vv_vec3 n, vv_vec3 l, vv_vec3 v, double n_l)
{
    double s;
    if (m->model == VV_SHADING_PHONG) {
        s = vvi_dot(vvi_sub(vvi_scaled(n, 2 * n_l), l), v);
    } else {
        vv_vec3 h = vvi_add(l, v);
        s = vvi_unit(&h) ? vvi_dot(n, h) * (n_l < 0 ? -1 : 1) : 0;
    }
    return s > 0 ? pow(s, (double)m->shininess) : 0;
}

/* As vvi_shade_ref(). */
static void light(double rgb[3], const vvi_gfx_state *state, vv_vec3 place, vv_vec3 n, bool known, vv_vec3 to_eye)
{
    const vvi_gfx_material *m = &state->material;
    double diffuse[3] = {0}, specular[3] = {0};
    if (m->model == VV_SHADING_NONE)
        return;
    for (size_t i = 0; i < state->lights->n_lamps; i++) {
        vv_vec3 l;
        double color[3];
        lamp_at(&l, color, &state->lights->lamps[i], place);
        const double n_l = vvi_dot(n, l);
        if (m->sides != VVI_GFX_BOTH && n_l <= 0)
            continue;
        const double s = known ? highlight(m, n, l, to_eye, n_l) : 0;
        for (int c = 0; c < 3; c++) {
            diffuse[c] += color[c] * fabs(n_l);
            specular[c] += color[c] * s;
        }
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = rgb[c] * ((double)m->ambient * (double)state->lights->ambient[c] + (double)m->diffuse * diffuse[c]) +
                 (double)m->specular * specular[c];
}

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

/* Linear, not premultiplied. */
static void color_of(double out[4], const vvi_gfx_draw *draw, uint32_t triangle, const uint32_t index[3],
                     const double share[3])
{
    const vv_mesh_info *mesh = draw->surface.mesh;
    vv_color c = draw->surface.color;
    const double opacity = c.a;
    if (!draw->surface.one_color && mesh->colors) {
        c = (vv_color){0};
        for (int k = 0; k < 3; k++) {
            const uint8_t *v = mesh->colors + 4 * (size_t)index[k];
            c.r += share[k] * vv_srgb_decode(v[0] / 255.0);
            c.g += share[k] * vv_srgb_decode(v[1] / 255.0);
            c.b += share[k] * vv_srgb_decode(v[2] / 255.0);
            c.a += share[k] * v[3] / 255;
        }
        c.a *= opacity;
    } else if (!draw->surface.one_color && mesh->parts) {
        size_t i = 0;
        while (i + 1 < mesh->n_parts && triangle >= mesh->parts[i].first_triangle + mesh->parts[i].n_triangles)
            i++;
        if (mesh->parts[i].color.a >= 0) {
            c = mesh->parts[i].color;
            c.a *= opacity;
        }
    }
    out[0] = c.r, out[1] = c.g, out[2] = c.b, out[3] = c.a;
}

/* The gradient's way of turning under an affine map: cofactors, right up to a positive factor. */
static vv_vec3 turned_normal(const vv_affine *a, vv_vec3 n, bool mirrored)
{
    const vv_vec3 x = vvi_cross(a->axis[1], a->axis[2]), y = vvi_cross(a->axis[2], a->axis[0]),
                  z = vvi_cross(a->axis[0], a->axis[1]);
    return vvi_scaled(vvi_add(vvi_add(vvi_scaled(x, n.x), vvi_scaled(y, n.y)), vvi_scaled(z, n.z)), mirrored ? -1 : 1);
}

void vvi_gfx_shade_ref(vvi_gfx_fragment *f, const vvi_gfx_draw *draw)
{
    const vvi_gfx_view *view = draw->state.view;
    const vv_mesh_info *mesh = draw->surface.mesh;
    const uint32_t *index = mesh->triangles + 3 * (size_t)f->triangle;
    const vv_vec3 across = vvi_add(vvi_scaled(view->lens.right, ((double)f->x - view->middle_x) / view->scale_x),
                                   vvi_scaled(view->lens.up, (view->middle_y - (double)f->y) / view->scale_y));
    vv_vec3 way = view->lens.parallel ? view->lens.forward : vvi_add(view->lens.forward, across);
    const vv_vec3 start = view->lens.parallel ? across : vvi_vec(0, 0, 0);
    vv_vec3 corner[3], normal[3];
    double share[3], rgba[4];
    vvi_unit(&way);
    for (int k = 0; k < 3; k++)
        corner[k] = vv_affine_point(draw->to_eye, vector_at(mesh->positions, index[k]));
    shares(share, start, way, corner);
    const vv_vec3 place = mean(corner, share), to_eye = vvi_scaled(way, -1);
    vv_vec3 n = vvi_cross(vvi_sub(corner[1], corner[0]), vvi_sub(corner[2], corner[0]));
    bool known = vvi_unit(&n);
    n = vvi_scaled(n, draw->mirrored ? -1 : 1);
    if (mesh->normals && !draw->state.material.flat) {
        for (int k = 0; k < 3; k++)
            normal[k] = vector_at(mesh->normals, index[k]);
        vv_vec3 smooth = turned_normal(&draw->to_eye, mean(normal, share), draw->mirrored);
        if (vvi_unit(&smooth)) {
            n = smooth;
            known = true;
        }
    }
    if (!known)
        n = to_eye;
    if (draw->state.material.sides == VVI_GFX_FACING && vvi_dot(n, to_eye) < 0)
        n = vvi_scaled(n, -1);
    color_of(rgba, draw, f->triangle, index, share);
    light(rgba, &draw->state, vvi_add(place, view->lens.eye), n, known, to_eye);
    for (int c = 0; c < 4; c++)
        f->rgba[c] = (float)rgba[c];
    f->depth = (float)fmax(vvi_dot(vvi_sub(place, start), way), vvi_gfx_nearest(draw));
    f->normal[0] = (float)n.x, f->normal[1] = (float)n.y, f->normal[2] = (float)n.z;
}
