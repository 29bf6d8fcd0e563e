#include "gfx/mesh_look.h"
#include "core/vec.h"
#include <volvis/image.h>

vvi_gfx_surface vvi_gfx_surface_of(vv_mesh_info *shown, const vv_mesh_actor *actor)
{
    const float *c = actor->look.color;
    *shown = *vv_mesh_get_info(actor->mesh);
    if (actor->colors)
        shown->colors = actor->colors;
    if (actor->parts)
        shown->parts = actor->parts;
    return (vvi_gfx_surface){.mesh = shown,
                             .place = actor->place,
                             .color = {(double)c[0], (double)c[1], (double)c[2], actor->opacity},
                             .one_color = actor->one_color};
}

void vvi_gfx_decode_init(vvi_gfx_decode *out)
{
    for (int i = 0; i < 256; i++)
        out->light[i] = (float)vv_srgb_decode(i / 255.0);
}

static double light_of(uint8_t encoded, const vvi_gfx_decode *decode)
{
    return decode ? (double)decode->light[encoded] : vv_srgb_decode(encoded / 255.0);
}

void vvi_gfx_color_at(double out[4], const vvi_gfx_surface *surface, const vvi_gfx_decode *decode, uint32_t triangle,
                      const double share[3])
{
    const vv_mesh_info *mesh = surface->mesh;
    vv_color c = surface->color;
    const double opacity = c.a;
    if (!surface->one_color && mesh->colors) {
        c = (vv_color){0};
        for (int k = 0; k < 3; k++) {
            const uint8_t *v = mesh->colors + 4 * (size_t)mesh->triangles[3 * (size_t)triangle + (size_t)k];
            c.r += share[k] * light_of(v[0], decode);
            c.g += share[k] * light_of(v[1], decode);
            c.b += share[k] * light_of(v[2], decode);
            c.a += share[k] * v[3] / 255;
        }
        c.a *= opacity;
    } else if (!surface->one_color && mesh->parts) {
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
