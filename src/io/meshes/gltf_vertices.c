/* Vertices of glTF: accessors of numbers to the mesh's arrays, each once where primitives share them. */
#include "core/memory.h"
#include "io/meshes/gltf_reader.h"
#include "io/meshes/mesh_colors.h"

#include <stdio.h>
#include <string.h>

static bool same_numbers(const double *p, const double *q, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (p[i] != q[i])
            return false;
    return true;
}

static bool same_map(const vv_affine *a, const vv_affine *b)
{
    return same_numbers(&a->axis[0].x, &b->axis[0].x, sizeof *a / sizeof a->axis[0].x);
}

/* Of an attribute that is not there the number is 0. */
bool vvi_gltf_same_attributes(const vvi_gltf_reader *r, const vvi_gltf_attributes *a, const vv_affine *map)
{
    const vvi_gltf_attributes *l = &r->last;
    return l->has_position && a->has_position && l->position == a->position && l->has_normal == a->has_normal &&
           l->normal == a->normal && l->has_color == a->has_color && l->color == a->color &&
           l->has_value == a->has_value && l->value == a->value && l->has_coordinate == a->has_coordinate &&
           l->coordinate == a->coordinate &&
           (!r->any_colors ||
            (same_numbers(l->factor, a->factor, 4) && l->alpha == a->alpha && l->cutoff == a->cutoff)) &&
           same_numbers(l->to_image[0], a->to_image[0], 6) && same_map(&r->last_map, map);
}

static vv_status put_places(vvi_gltf_reader *r, const vvi_gltf_attributes *a, const vv_affine *map)
{
    vvi_gltf_numbers p;
    vv_status st = vvi_gltf_read_accessor(&p, &r->g, a->position, 3, 3);
    if (st != VV_OK)
        return st;
    r->first_vertex = r->b.info.n_vertices;
    st = vvi_mesh_builder_vertices(&r->b, p.n);
    for (size_t i = 0; i < p.n && st == VV_OK; i++) {
        const vv_vec3 at = vv_affine_point(*map, (vv_vec3){p.v[3 * i], p.v[3 * i + 1], p.v[3 * i + 2]});
        memcpy(r->b.places + 3 * (r->first_vertex + i), &at.x, 3 * sizeof at.x);
    }
    vvi_free(p.v);
    return st;
}

/* By the transposed inverse, which keeps them upright on what is stretched. */
static void turn_normal(float out[3], const double n[3], const vv_affine *inverse)
{
    for (int a = 0; a < 3; a++)
        out[a] = (float)(n[0] * (&inverse->axis[a].x)[0] + n[1] * (&inverse->axis[a].x)[1] +
                         n[2] * (&inverse->axis[a].x)[2]);
}

static vv_status put_normals(vvi_gltf_reader *r, const vvi_gltf_attributes *a, const vv_affine *map)
{
    vvi_gltf_numbers n;
    vv_affine inverse;
    vv_status st = vvi_mesh_builder_with(&r->b, VVI_MESH_NORMALS);
    if (st != VV_OK || !vv_affine_invert(&inverse, *map) ||
        (st = vvi_gltf_read_accessor(&n, &r->g, a->normal, 3, 3)) != VV_OK)
        return st;
    for (size_t i = 0; i < n.n && r->first_vertex + i < r->b.info.n_vertices; i++)
        turn_normal(r->b.arrays.normals + 3 * (r->first_vertex + i), n.v + 3 * i, &inverse);
    vvi_free(n.v);
    return VV_OK;
}

/* Linear there, sRGB here; times the material's. */
static vv_status put_colors(vvi_gltf_reader *r, const vvi_gltf_attributes *a)
{
    vvi_gltf_numbers n = {0};
    const double *f = a->factor;
    vv_status st = vvi_mesh_builder_with(&r->b, VVI_MESH_COLORS);
    if (st == VV_OK && a->has_color)
        st = vvi_gltf_read_accessor(&n, &r->g, a->color, 3, 4);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; r->first_vertex + i < r->b.info.n_vertices; i++) {
        const double *v = i < n.n ? n.v + i * (size_t)n.components : NULL;
        vv_color color = {f[0], f[1], f[2], f[3]};
        if (v)
            color = (vv_color){f[0] * v[0], f[1] * v[1], f[2] * v[2], n.components == 4 ? f[3] * v[3] : f[3]};
        color.a = vvi_gltf_opacity(color.a, a->alpha, a->cutoff);
        vvi_mesh_bytes_of(r->b.arrays.colors + 4 * (r->first_vertex + i), &color);
    }
    vvi_free(n.v);
    return VV_OK;
}

static vv_status put_coordinates(vvi_gltf_reader *r, const vvi_gltf_attributes *a)
{
    vvi_gltf_numbers n;
    vv_status st = vvi_mesh_builder_with(&r->b, VVI_MESH_COORDINATES);
    if (st != VV_OK || (st = vvi_gltf_read_accessor(&n, &r->g, a->coordinate, 2, 2)) != VV_OK)
        return st;
    for (size_t i = 0; i < n.n && r->first_vertex + i < r->b.info.n_vertices; i++)
        for (size_t k = 0; k < 2; k++) {
            const double *row = a->to_image[k];
            r->b.arrays.coordinates[2 * (r->first_vertex + i) + k] =
                (float)(row[0] * n.v[2 * i] + row[1] * n.v[2 * i + 1] + row[2]);
        }
    vvi_free(n.v);
    return VV_OK;
}

static vv_status put_values(vvi_gltf_reader *r, const vvi_gltf_attributes *a)
{
    vvi_gltf_numbers n;
    vv_status st = vvi_mesh_builder_with(&r->b, VVI_MESH_VALUES);
    if (st != VV_OK || (st = vvi_gltf_read_accessor(&n, &r->g, a->value, 1, 1)) != VV_OK)
        return st;
    for (size_t i = 0; i < n.n && r->first_vertex + i < r->b.info.n_vertices; i++)
        r->b.arrays.values[r->first_vertex + i] = (float)n.v[i];
    vvi_free(n.v);
    return VV_OK;
}

vv_status vvi_gltf_put_vertices(vvi_gltf_reader *r, const vvi_gltf_attributes *a, const vv_affine *map)
{
    if (vvi_gltf_same_attributes(r, a, map))
        return VV_OK;
    vv_status st = put_places(r, a, map);
    if (st == VV_OK && a->has_normal)
        st = put_normals(r, a, map);
    if (st == VV_OK && r->any_colors)
        st = put_colors(r, a);
    if (st == VV_OK && a->has_coordinate)
        st = put_coordinates(r, a);
    if (st == VV_OK && a->has_value)
        st = put_values(r, a);
    r->last = *a;
    r->last_map = *map;
    return st;
}

vv_status vvi_gltf_find_attributes(vvi_gltf_attributes *out, const vvi_gltf_reader *r, const json_t *primitive,
                                   const vvi_gltf_material *m)
{
    char coordinates[32];
    const json_t *list = json_object_get(primitive, "attributes");
    const size_t n = json_array_size(json_object_get(r->g.root, "accessors"));
    vv_status st;
    *out = (vvi_gltf_attributes){0};
    memcpy(out->factor, m->factor, sizeof out->factor);
    out->alpha = m->alpha;
    out->cutoff = m->cutoff;
    memcpy(out->to_image, m->to_image, sizeof out->to_image);
    snprintf(coordinates, sizeof coordinates, "TEXCOORD_%lld", (long long)m->coordinates);
    if ((st = vvi_gltf_index(&r->g, list, "POSITION", n, &out->position, &out->has_position)) == VV_OK &&
        (st = vvi_gltf_index(&r->g, list, "NORMAL", n, &out->normal, &out->has_normal)) == VV_OK &&
        (st = vvi_gltf_index(&r->g, list, "COLOR_0", n, &out->color, &out->has_color)) == VV_OK &&
        (st = vvi_gltf_index(&r->g, list, coordinates, n, &out->coordinate, &out->has_coordinate)) == VV_OK)
        st = vvi_gltf_index(&r->g, list, "_VALUE", n, &out->value, &out->has_value);
    return st;
}
