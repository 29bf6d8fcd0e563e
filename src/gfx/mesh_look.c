#include "gfx/mesh_look.h"
#include "core/vec.h"
#include <volvis/image.h>

vvi_gfx_surface vvi_gfx_surface_of(vv_mesh_info *shown, const vv_mesh_actor *actor)
{
    const float *c = actor->look.color;
    const bool plain = actor->textures && !actor->one_color && !actor->colors;
    const bool by_value = actor->colors && !actor->one_color && actor->look.classes.n_color &&
                          !actor->look.paint.nearest; /* between two labels there is no third */
    *shown = *vv_mesh_get_info(actor->mesh);
    if (actor->colors)
        shown->colors = actor->colors;
    if (actor->parts)
        shown->parts = actor->parts;
    return (vvi_gfx_surface){.mesh = shown,
                             .place = actor->place,
                             .color = {(double)c[0], (double)c[1], (double)c[2], actor->opacity},
                             .one_color = actor->one_color,
                             .ramp = by_value ? actor->look.classes.color : NULL,
                             .n_ramp = by_value ? actor->look.classes.n_color : 0,
                             .textures = plain ? vvi_cached_value(actor->textures) : NULL};
}

static double light_of(uint8_t encoded, const vvi_gfx_decode *decode)
{
    return decode ? (double)decode->light[encoded] : vv_srgb_decode(encoded / 255.0);
}

void vvi_gfx_shares(double out[3], vv_vec3 start, vv_vec3 way, const vv_vec3 corner[3])
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

/* The shares are quotients of what is linear in the ray: in its way, which ends on the plane forward 1 where there is
 * an eye, or else in its start. */
void vvi_gfx_share_slopes(double out[2][3], const vvi_gfx_view *view, vv_vec3 start, vv_vec3 way,
                          const vv_vec3 corner[3])
{
    const vv_vec3 across[2] = {vvi_scaled(view->lens.right, 1 / view->scale_x),
                               vvi_scaled(view->lens.up, -1 / view->scale_y)};
    const vv_vec3 e1 = vvi_sub(corner[1], corner[0]), e2 = vvi_sub(corner[2], corner[0]),
                  from = vvi_sub(start, corner[0]);
    const bool parallel = view->lens.parallel;
    const vv_vec3 w = parallel ? way : vvi_scaled(way, 1 / vvi_dot(way, view->lens.forward));
    const vv_vec3 turned = vvi_cross(e2, e1), by_u = parallel ? vvi_cross(w, e2) : vvi_cross(e2, from),
                  by_v = parallel ? vvi_cross(e1, w) : vvi_cross(from, e1);
    const double det = vvi_dot(w, turned);
    const double u = vvi_dot(from, vvi_cross(w, e2)) / det, v = vvi_dot(w, vvi_cross(from, e1)) / det;
    for (int i = 0; i < 2; i++) {
        const double more = parallel ? 0 : vvi_dot(across[i], turned);
        out[i][1] = (vvi_dot(across[i], by_u) - u * more) / det;
        out[i][2] = (vvi_dot(across[i], by_v) - v * more) / det;
        out[i][0] = -out[i][1] - out[i][2];
    }
}

static const vv_mesh_part *part_at(const vv_mesh_info *m, uint32_t triangle)
{
    size_t lo = 0, hi = m->n_parts; /* it is one of lo .. hi - 1 */
    while (hi - lo > 1) {
        const size_t middle = (lo + hi) / 2;
        if (m->parts[middle].first_triangle <= triangle)
            lo = middle;
        else
            hi = middle;
    }
    return &m->parts[lo];
}

static vv_color vertex_color(const vv_mesh_info *mesh, const vvi_gfx_decode *decode, uint32_t triangle,
                             const double share[3])
{
    vv_color c = {0};
    for (int k = 0; k < 3; k++) {
        const uint8_t *v = mesh->colors + 4 * (size_t)mesh->triangles[3 * (size_t)triangle + (size_t)k];
        c.r += share[k] * light_of(v[0], decode);
        c.g += share[k] * light_of(v[1], decode);
        c.b += share[k] * light_of(v[2], decode);
        c.a += share[k] * v[3] / 255;
    }
    return c;
}

void vvi_gfx_ramp_color(double rgb[3], const vvi_gfx_surface *surface, double value)
{
    const double *rows = surface->ramp;
    size_t lo = 0, hi = surface->n_ramp; /* the first row above the value is one of lo .. hi */
    while (lo < hi) {
        const size_t middle = (lo + hi) / 2;
        if (rows[4 * middle] > value)
            hi = middle;
        else
            lo = middle + 1;
    }
    const double *after = rows + 4 * (lo < surface->n_ramp ? lo : surface->n_ramp - 1),
                 *before = rows + 4 * (lo > 0 ? lo - 1 : 0);
    const double share = after[0] > before[0] ? (value - before[0]) / (after[0] - before[0]) : 0;
    for (int c = 0; c < 3; c++)
        rgb[c] = before[1 + c] + share * (after[1 + c] - before[1 + c]);
}

static double value_at(const vv_mesh_info *m, uint32_t triangle, const double share[3])
{
    double sum = 0;
    for (size_t k = 0; k < 3; k++)
        sum += share[k] * (double)m->values[m->triangles[3 * (size_t)triangle + k]];
    return sum;
}

static void texture_color(double rgba[4], const vvi_gfx_surface *surface, size_t texture, uint32_t triangle,
                          const double share[3], const double slope[2][3])
{
    const vv_mesh_info *m = surface->mesh;
    const uint32_t *corner = (m->coordinate_of ? m->coordinate_of : m->triangles) + 3 * (size_t)triangle;
    double at[2] = {0}, across[2][2] = {{0}};
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 2; c++) {
            const double coordinate = (double)m->coordinates[2 * (size_t)corner[k] + (size_t)c];
            at[c] += share[k] * coordinate;
            for (int i = 0; i < 2 && slope; i++)
                across[i][c] += slope[i][k] * coordinate;
        }
    vvi_gfx_texture_at(rgba, surface->textures, texture, at, (const double(*)[2])across);
}

void vvi_gfx_color_at(double out[4], const vvi_gfx_surface *surface, const vvi_gfx_decode *decode, uint32_t triangle,
                      const double share[3], const double slope[2][3])
{
    const vv_mesh_info *mesh = surface->mesh;
    const vv_mesh_part *part = mesh->parts && !surface->one_color ? part_at(mesh, triangle) : NULL;
    const size_t texture = part && surface->textures ? part->texture : 0;
    vv_color c = surface->color;
    const double opacity = c.a, value = surface->ramp ? value_at(mesh, triangle, share) : NAN;
    if (surface->ramp && isfinite(value)) {
        double rgb[3];
        vvi_gfx_ramp_color(rgb, surface, value);
        c = (vv_color){rgb[0], rgb[1], rgb[2], 1};
    } else if (!surface->one_color && mesh->colors)
        c = vertex_color(mesh, decode, triangle, share);
    else if (part && part->color.a >= 0)
        c = part->color;
    else if (texture)
        c = (vv_color){1, 1, 1, 1};
    else
        c.a = 1;
    out[0] = c.r, out[1] = c.g, out[2] = c.b, out[3] = c.a * opacity;
    if (texture) {
        double seen[4];
        texture_color(seen, surface, texture - 1, triangle, share, slope);
        for (int k = 0; k < 4; k++)
            out[k] *= seen[k];
    }
}

static vv_vec3 vector_at(const float *numbers, uint32_t i)
{
    const float *v = numbers + 3 * (size_t)i;
    return vvi_vec((double)v[0], (double)v[1], (double)v[2]);
}

/* The gradient's way of turning under an affine map: cofactors, right up to a factor, which is positive but in mirrors.
 */
static vv_vec3 turned(const vv_affine *a, vv_vec3 n)
{
    const vv_vec3 x = vvi_cross(a->axis[1], a->axis[2]), y = vvi_cross(a->axis[2], a->axis[0]),
                  z = vvi_cross(a->axis[0], a->axis[1]);
    const double side = vv_affine_determinant(*a) < 0 ? -1 : 1;
    return vvi_scaled(vvi_add(vvi_add(vvi_scaled(x, n.x), vvi_scaled(y, n.y)), vvi_scaled(z, n.z)), side);
}

bool vvi_gfx_normal_at(vv_vec3 *out, const vv_mesh_info *mesh, const vv_affine *place, uint32_t triangle,
                       const double share[3], bool flat)
{
    const uint32_t *index = mesh->triangles + 3 * (size_t)triangle;
    vv_vec3 corner[3], n = {0, 0, 0};
    for (int k = 0; k < 3 && mesh->normals && !flat; k++)
        n = vvi_add(n, vvi_scaled(vector_at(mesh->normals, index[k]), share[k]));
    *out = turned(place, n);
    if (vvi_unit(out))
        return true;
    for (int k = 0; k < 3; k++)
        corner[k] = vector_at(mesh->positions, index[k]);
    *out = turned(place, vvi_cross(vvi_sub(corner[1], corner[0]), vvi_sub(corner[2], corner[0])));
    return vvi_unit(out);
}
