#include "gfx/lamp.h"
#include <volvis/model.h>

enum { MOST_WHOLE = 256 };

static void store(float out[3], vv_vec3 v)
{
    out[0] = (float)v.x, out[1] = (float)v.y, out[2] = (float)v.z;
}

vvi_lamp vvi_lamp_from(const vv_lamp *lamp, vv_vec3 origin)
{
    vvi_lamp l = {.kind = lamp->kind,
                  .color = {lamp->color[0], lamp->color[1], lamp->color[2]},
                  .cos_outer = (float)lamp->cos_outer,
                  .inverse_fade = (float)(1 / fmax(lamp->cos_inner - lamp->cos_outer, 1e-6))};
    store(l.to_light, vvi_scaled(lamp->direction, -1));
    store(l.position, vvi_sub(lamp->position, origin));
    store(l.falloff, lamp->falloff);
    return l;
}

vvi_gloss vvi_gloss_of(int model, float ambient, float diffuse, float specular, float shininess,
                       const float ambient_light[3])
{
    const bool whole = shininess <= MOST_WHOLE && shininess == floorf(shininess);
    vvi_gloss g = {.phong = model == VV_SHADING_PHONG,
                   .diffuse = diffuse,
                   .specular = specular,
                   .shininess = shininess,
                   .whole_shininess = whole ? (int32_t)shininess : 0,
                   .least_shine = whole ? exp2f(-60 / shininess) : 0};
    for (int c = 0; c < 3; c++)
        g.ambient[c] = ambient_light[c] * ambient;
    return g;
}

/* Hermite between the edges of the cone, so that the rim has no line. */
static double cone(const vv_lamp *lamp, vv_vec3 to_lamp)
{
    const double c = -vvi_dot(to_lamp, lamp->direction);
    if (c <= lamp->cos_outer)
        return 0;
    if (c >= lamp->cos_inner)
        return 1;
    const double t = (c - lamp->cos_outer) / (lamp->cos_inner - lamp->cos_outer);
    return t * t * (3 - 2 * t);
}

void vvi_lamp_at(vv_vec3 *to_lamp, double light[3], const vv_lamp *lamp, vv_vec3 position)
{
    double share = 1;
    if (lamp->kind == VV_LIGHT_DIRECTIONAL) {
        *to_lamp = vvi_scaled(lamp->direction, -1);
    } else {
        *to_lamp = vvi_sub(lamp->position, position);
        const double d = vvi_length(*to_lamp);
        *to_lamp = d > 0 ? vvi_scaled(*to_lamp, 1 / d) : vvi_vec(0, 0, 1);
        share = 1 / (lamp->falloff.x + d * (lamp->falloff.y + d * lamp->falloff.z));
        if (lamp->kind == VV_LIGHT_SPOT)
            share *= cone(lamp, *to_lamp);
    }
    for (int c = 0; c < 3; c++)
        light[c] = share * (double)lamp->color[c];
}

static double highlight(const vvi_gloss *g, const vvi_lit_point *p, vv_vec3 l, double n_l)
{
    double s = 0;
    if (g->phong) {
        s = vvi_dot(vvi_sub(vvi_scaled(p->normal, 2 * n_l), l), p->to_eye);
    } else {
        vv_vec3 h = vvi_add(l, p->to_eye);
        if (!vvi_unit(&h))
            return 0;
        s = vvi_dot(p->normal, h) * (n_l < 0 ? -1 : 1);
    }
    return s > 0 ? pow(s, (double)g->shininess) : 0;
}

void vvi_light_ref(double rgb[3], const vvi_lit_point *p, const vvi_gloss *g, const vv_lamp *lamps, size_t n_lamps)
{
    double diffuse[3] = {0}, specular[3] = {0};
    for (size_t i = 0; i < n_lamps; i++) {
        vv_vec3 l;
        double light[3];
        vvi_lamp_at(&l, light, &lamps[i], p->position);
        for (int c = 0; c < 3 && p->arrives && i + 1 < p->n_arrive; c++)
            light[c] *= p->arrives[i + 1];
        const double n_l = vvi_dot(p->normal, l);
        if (!p->two_sided && n_l <= 0)
            continue;
        const double s = p->surface ? highlight(g, p, l, n_l) : 0;
        for (int c = 0; c < 3; c++) {
            diffuse[c] += light[c] * fabs(n_l);
            specular[c] += light[c] * s;
        }
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = rgb[c] * ((double)g->ambient[c] * (p->arrives ? p->arrives[0] : 1) + (double)g->diffuse * diffuse[c]) +
                 (double)g->specular * specular[c];
}
