/* The rows of glTF and GLB, and reading them: nodes with their maps, primitives of meshes, colours of materials. */
#include "io/meshes/gltf.h"
#include "core/job.h"
#include "core/limits.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/json.h"
#include "io/meshes/mesh_colors.h"
#include "io/meshes/mesh_texture.h"
#include "io/scan.h"
#include "registry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/image.h>

enum { DEPTH_MOST = 64, POINTS = 0, TRIANGLES = 4, STRIP = 5, FAN = 6 };

const vv_affine vvi_gltf_to_volvis = {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {0, 0, 0}};

/* What the vertices of a primitive are; the same for the next one of many files' parts. */
typedef struct attributes {
    size_t position, normal, color, value, coordinate;
    bool has_position, has_normal, has_color, has_value, has_coordinate;
    double factor[4];        /* of colours */
    vvi_texture_alpha alpha; /* what that of colours means */
    double cutoff;
    double to_image[2][3]; /* coordinates there to those here: rows */
} attributes;

/* What a primitive's triangles look like. */
typedef struct material {
    double factor[4], color[4];
    vvi_texture_alpha alpha;
    double cutoff; /* of MASK */
    bool colored;  /* color is there: the factor, or what our own writer noted of a part beside colours of vertices */
    int64_t coordinates; /* number of the attribute */
    double to_image[2][3];
    size_t texture; /* as in vv_mesh_part */
} material;

/* An image of the file that was read with an alpha and in a way of going on. */
typedef struct image_read {
    const json_t *image;
    vvi_texture_use use;
    size_t texture;
} image_read;

typedef struct reader {
    vvi_gltf g;
    vvi_mesh_builder b;
    vv_affine from_scene; /* to the mesh's axes and unit */
    bool *seen;           /* nodes */
    attributes last;
    vv_affine last_map;
    size_t first_vertex; /* of the last ones */
    size_t n_other;      /* primitives of points and lines */
    bool counting;       /* the first of two walks: nothing is made yet */
    bool any_colors;     /* some vertices have colours: all others have their material's */
    image_read *images;
    size_t n_images;
    uint64_t n_vertices, n_triangles, n_objects; /* counted */
    vv_notes *notes;
} reader;

/* Maps ------------------------------------------------------------------------------------------------------------ */

static bool numbers_at(double *out, size_t n, const json_t *object, const char *key)
{
    const json_t *list = json_object_get(object, key);
    if (json_array_size(list) != n)
        return false;
    for (size_t i = 0; i < n; i++)
        if (!vvi_json_real(&out[i], json_array_get(list, i)))
            return false;
    return true;
}

static vv_affine affine_of_parts(const double t[3], const double q[4], const double s[3])
{
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    return (vv_affine){{{s[0] * (1 - 2 * (y * y + z * z)), s[0] * 2 * (x * y + z * w), s[0] * 2 * (x * z - y * w)},
                        {s[1] * 2 * (x * y - z * w), s[1] * (1 - 2 * (x * x + z * z)), s[1] * 2 * (y * z + x * w)},
                        {s[2] * 2 * (x * z + y * w), s[2] * 2 * (y * z - x * w), s[2] * (1 - 2 * (x * x + y * y))}},
                       {t[0], t[1], t[2]}};
}

static vv_status map_of_node(vv_affine *out, const reader *r, const json_t *node)
{
    double m[16], t[3] = {0, 0, 0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    if (json_object_get(node, "matrix")) {
        if (!numbers_at(m, 16, node, "matrix"))
            return vvi_gltf_fail(&r->g, "a node's 'matrix' is not 16 finite numbers");
        *out = (vv_affine){{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}}, {m[12], m[13], m[14]}};
        return VV_OK;
    }
    if ((json_object_get(node, "translation") && !numbers_at(t, 3, node, "translation")) ||
        (json_object_get(node, "rotation") && !numbers_at(q, 4, node, "rotation")) ||
        (json_object_get(node, "scale") && !numbers_at(s, 3, node, "scale")))
        return vvi_gltf_fail(&r->g, "a node has an invalid translation, rotation or scale");
    *out = affine_of_parts(t, q, s);
    return VV_OK;
}

/* What our own writer turned is turned back without the last digit's error. */
static vv_affine tidy(vv_affine a)
{
    double *v = &a.axis[0].x;
    for (int i = 0; i < 9; i++)
        v[i] = fabs(v[i] - round(v[i])) < 1e-12 ? round(v[i]) : v[i];
    return a;
}

/* Vertices -------------------------------------------------------------------------------------------------------- */

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
static bool same_attributes(const reader *r, const attributes *a, const vv_affine *map)
{
    const attributes *l = &r->last;
    return l->has_position && a->has_position && l->position == a->position && l->has_normal == a->has_normal &&
           l->normal == a->normal && l->has_color == a->has_color && l->color == a->color &&
           l->has_value == a->has_value && l->value == a->value && l->has_coordinate == a->has_coordinate &&
           l->coordinate == a->coordinate &&
           (!r->any_colors ||
            (same_numbers(l->factor, a->factor, 4) && l->alpha == a->alpha && l->cutoff == a->cutoff)) &&
           same_numbers(l->to_image[0], a->to_image[0], 6) && same_map(&r->last_map, map);
}

static vv_status put_places(reader *r, const attributes *a, const vv_affine *map)
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

static vv_status put_normals(reader *r, const attributes *a, const vv_affine *map)
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

/* Opacity of what has this alpha. */
static double opacity_of(double alpha, vvi_texture_alpha means, double cutoff)
{
    return means == VVI_TEXTURE_BLEND ? alpha : means == VVI_TEXTURE_OPAQUE || alpha >= cutoff ? 1 : 0;
}

/* Linear there, sRGB here; times the material's. */
static vv_status put_colors(reader *r, const attributes *a)
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
        color.a = opacity_of(color.a, a->alpha, a->cutoff);
        vvi_mesh_bytes_of(r->b.arrays.colors + 4 * (r->first_vertex + i), &color);
    }
    vvi_free(n.v);
    return VV_OK;
}

static vv_status put_coordinates(reader *r, const attributes *a)
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

static vv_status put_values(reader *r, const attributes *a)
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

static vv_status put_vertices(reader *r, const attributes *a, const vv_affine *map)
{
    if (same_attributes(r, a, map))
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

static vv_status find_attributes(attributes *out, const reader *r, const json_t *primitive, const material *m)
{
    char coordinates[32];
    const json_t *list = json_object_get(primitive, "attributes");
    const size_t n = json_array_size(json_object_get(r->g.root, "accessors"));
    vv_status st;
    *out = (attributes){0};
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

/* Triangles ------------------------------------------------------------------------------------------------------- */

static vv_status put_one(reader *r, size_t a, size_t b, size_t c, bool mirrored)
{
    const uint32_t first = (uint32_t)r->first_vertex;
    const uint32_t t[3] = {first + (uint32_t)a, first + (uint32_t)(mirrored ? c : b),
                           first + (uint32_t)(mirrored ? b : c)};
    return vvi_mesh_builder_triangle(&r->b, t);
}

/* index NULL: vertices in their order. */
static vv_status put_triangles(reader *r, const double *index, size_t n, int64_t mode, bool mirrored)
{
    const size_t step = mode == TRIANGLES ? 3 : 1;
    const size_t n_vertices = r->b.info.n_vertices - r->first_vertex;
    vv_status st = VV_OK;
    for (size_t i = 0; i + 2 < n && st == VV_OK; i += step) {
        const size_t at[3] = {mode == FAN     ? 0
                              : mode == STRIP ? i + i % 2
                                              : i,
                              mode == STRIP ? i + 1 - i % 2 : i + 1, i + 2};
        size_t v[3];
        for (int k = 0; k < 3; k++) {
            v[k] = index ? (size_t)index[at[k]] : at[k];
            if (v[k] >= n_vertices)
                return vvi_gltf_fail(&r->g, "a triangle names vertex %zu, but there are %zu (counted from 0)", v[k],
                                     n_vertices);
        }
        if (mode == TRIANGLES || (v[0] != v[1] && v[1] != v[2] && v[2] != v[0]))
            st = put_one(r, v[0], v[1], v[2], mirrored);
    }
    return st;
}

/* Materials ------------------------------------------------------------------------------------------------------- */

static vvi_texture_use use_of(const reader *r, const material *m, const json_t *texture)
{
    enum { CLAMP = 33071, MIRROR = 33648 };
    static const char *const keys[2] = {"wrapS", "wrapT"};
    vvi_texture_use use = {.alpha = m->alpha, .cutoff = m->cutoff};
    int64_t at, code;
    const json_t *sampler = NULL;
    if (vvi_json_whole(&at, json_object_get(texture, "sampler")) && at >= 0)
        sampler = json_array_get(json_object_get(r->g.root, "samplers"), (size_t)at);
    for (int k = 0; k < 2; k++)
        if (vvi_json_whole(&code, json_object_get(sampler, keys[k])))
            use.wrap[k] = code == CLAMP ? VV_WRAP_CLAMP : code == MIRROR ? VV_WRAP_MIRROR : VV_WRAP_REPEAT;
    return use;
}

/* In the file or as text in it, or beside it. */
static vv_status open_image(size_t *texture, reader *r, const json_t *image, const vvi_texture_use *use)
{
    const char *uri = json_string_value(json_object_get(image, "uri"));
    vvi_gltf_bytes bytes;
    vv_source *source;
    char name[1024];
    if (uri && strncmp(uri, "data:", 5) != 0)
        return vvi_gltf_decode_uri(name, uri)
                   ? vvi_mesh_texture_find(texture, &r->b, name, use, r->notes)
                   : vvi_notes_warn(r->notes, "the image '%.100s' on its triangles is not a file next to it", uri);
    vv_status st = vvi_gltf_read_bytes(&bytes, &r->g, image);
    if (st != VV_OK)
        return st;
    st = vvi_source_memory(&source, bytes.at, bytes.n, r->g.file, r->g.job);
    if (st == VV_OK) {
        const char *said = json_string_value(json_object_get(image, "name"));
        st = vvi_mesh_texture_read(texture, &r->b, source, said ? said : "", use, r->notes);
        vvi_source_close(source);
    }
    vvi_free(bytes.owned);
    return st;
}

static bool is_same_use(const vvi_texture_use *a, const vvi_texture_use *b)
{
    return a->wrap[0] == b->wrap[0] && a->wrap[1] == b->wrap[1] && a->alpha == b->alpha && a->cutoff == b->cutoff;
}

/* Each once. */
static vv_status read_image(size_t *texture, reader *r, const json_t *image, const vvi_texture_use *use)
{
    for (size_t i = 0; i < r->n_images; i++)
        if (r->images[i].image == image && is_same_use(&r->images[i].use, use)) {
            *texture = r->images[i].texture;
            return VV_OK;
        }
    image_read *grown = vvi_realloc(r->g.job, r->images, (r->n_images + 1) * sizeof *grown, VVI_MEM_SCRATCH);
    if (!grown)
        return vv_fail_memory((r->n_images + 1) * sizeof *grown);
    r->images = grown;
    const vv_status st = open_image(texture, r, image, use);
    if (st == VV_OK)
        r->images[r->n_images++] = (image_read){image, *use, *texture};
    return st;
}

/* KHR_texture_transform: scale, then turn, then shift; and v runs upwards here. */
static void take_transform(material *m, const json_t *info)
{
    const json_t *t = json_object_get(json_object_get(info, "extensions"), "KHR_texture_transform");
    double scale[2] = {1, 1}, offset[2] = {0, 0}, turn = 0;
    int64_t set;
    double v[2];
    if (numbers_at(v, 2, t, "scale"))
        memcpy(scale, v, sizeof v);
    if (numbers_at(v, 2, t, "offset"))
        memcpy(offset, v, sizeof v);
    if (!vvi_json_real(&turn, json_object_get(t, "rotation")))
        turn = 0;
    if (vvi_json_whole(&set, json_object_get(t, "texCoord")) && set >= 0)
        m->coordinates = set;
    const double c = cos(turn), s = sin(turn);
    const double rows[2][3] = {{c * scale[0], s * scale[1], offset[0]}, {s * scale[0], -c * scale[1], 1 - offset[1]}};
    memcpy(m->to_image, rows, sizeof rows);
}

/* The texture of a material, and its image; NULL: none. */
static vv_status find_image(const json_t **texture, const json_t **image, const reader *r, const json_t *info)
{
    const json_t *textures = json_object_get(r->g.root, "textures"), *images = json_object_get(r->g.root, "images");
    size_t index;
    bool there;
    *image = NULL;
    vv_status st = vvi_gltf_index(&r->g, info, "index", json_array_size(textures), &index, &there);
    if (st != VV_OK || !there)
        return st;
    *texture = json_array_get(textures, index);
    st = vvi_gltf_index(&r->g, *texture, "source", json_array_size(images), &index, &there);
    if (st == VV_OK && there)
        *image = json_array_get(images, index);
    return st;
}

static vv_status read_texture(material *m, reader *r, size_t number, const json_t *info)
{
    const json_t *texture, *image;
    int64_t set;
    if (vvi_json_whole(&set, json_object_get(info, "texCoord")) && set >= 0)
        m->coordinates = set;
    take_transform(m, info);
    if (r->counting)
        return VV_OK;
    const vv_status st = find_image(&texture, &image, r, info);
    if (st == VV_E_FORMAT)
        return vvi_notes_warn(r->notes, "the image of material %zu (counted from 0) is left out: %.200s", number,
                              vv_error_last()->message);
    if (st != VV_OK || !image)
        return st;
    const vvi_texture_use use = use_of(r, m, texture);
    return read_image(&m->texture, r, image, &use);
}

static void take_alpha(material *m, const json_t *of)
{
    const char *mode = json_string_value(json_object_get(of, "alphaMode"));
    const json_t *cutoff = json_object_get(of, "alphaCutoff");
    m->alpha = VVI_TEXTURE_OPAQUE;
    if (mode && strcmp(mode, "BLEND") == 0)
        m->alpha = VVI_TEXTURE_BLEND;
    else if (mode && strcmp(mode, "MASK") == 0)
        m->alpha = VVI_TEXTURE_MASK;
    if (!cutoff || !vvi_json_real(&m->cutoff, cutoff) || !(m->cutoff >= 0))
        m->cutoff = 0.5;
}

/* An image of MASK is cut off together with the factor's alpha, which comes to cutting it off at another value. */
static void settle_alpha(material *m, bool image)
{
    double *a = &m->factor[3];
    if (m->alpha == VVI_TEXTURE_OPAQUE)
        *a = 1;
    if (m->alpha == VVI_TEXTURE_MASK && image) {
        m->cutoff = *a > 0 ? m->cutoff / *a : m->cutoff > 0 ? 2 : 0;
        *a = 1;
    }
    m->color[3] = image ? *a : opacity_of(*a, m->alpha, m->cutoff);
}

static vv_status find_material(material *out, reader *r, const json_t *primitive)
{
    const json_t *materials = json_object_get(r->g.root, "materials");
    size_t index;
    bool there;
    *out = (material){.factor = {1, 1, 1, 1}, .alpha = VVI_TEXTURE_OPAQUE, .to_image = {{1, 0, 0}, {0, -1, 1}}};
    const vv_status st = vvi_gltf_index(&r->g, primitive, "material", json_array_size(materials), &index, &there);
    if (st != VV_OK || !there)
        return st;
    const json_t *of = json_array_get(materials, index), *pbr = json_object_get(of, "pbrMetallicRoughness");
    double v[4];
    if (numbers_at(v, 4, pbr, "baseColorFactor"))
        memcpy(out->factor, v, sizeof v);
    const json_t *info = json_object_get(pbr, "baseColorTexture");
    out->colored = numbers_at(out->color, 4, pbr, "baseColorFactor");
    take_alpha(out, of);
    settle_alpha(out, info != NULL);
    out->colored |= numbers_at(out->color, 4, json_object_get(json_object_get(of, "extras"), "volvis"), "color");
    return info ? read_texture(out, r, index, info) : VV_OK;
}

static vv_status begin_part(reader *r, const material *m, const char *name)
{
    const vv_color color = {m->color[0], m->color[1], m->color[2], m->color[3]};
    return vvi_mesh_builder_part(&r->b, name, strlen(name), m->colored ? &color : NULL, m->texture);
}

/* Nodes may name one object many times: that costs no bytes of the file, so it is counted before room is taken, and an
 * object without triangles counts for the time that it takes. */
static vv_status check_counts(const reader *r)
{
    enum { OBJECT_BYTES = 64 };
    const vv_limits *limits = vvi_job_limits(r->g.job);
    const uint64_t bytes =
        3 * (r->n_vertices * sizeof(double) + r->n_triangles * sizeof(uint32_t)) + OBJECT_BYTES * r->n_objects;
    const uint64_t file = vvi_gltf_count_bytes(&r->g);
    if (bytes <= limits->expansion_after || bytes / limits->expansion_mesh <= file)
        return VV_OK;
    return vv_fail_at(
        VV_E_LIMIT, r->g.file, NULL,
        "its nodes name %llu objects%s, %llu triangles, which take more than %llu times its %llu bytes; if "
        "it is genuine, --limit expansion_mesh=N allows more",
        (unsigned long long)r->n_objects, r->counting ? " or more" : "", (unsigned long long)r->n_triangles,
        (unsigned long long)limits->expansion_mesh, (unsigned long long)file);
}

/* What a primitive will add. */
static vv_status count_primitive(reader *r, const json_t *primitive, const attributes *a, const vv_affine *map,
                                 int64_t mode)
{
    size_t index, n;
    bool there;
    vv_status st = vvi_gltf_count_accessor(&n, &r->g, a->position, 3, 3);
    if (st != VV_OK)
        return st;
    r->n_vertices += same_attributes(r, a, map) ? 0 : n;
    r->last = *a;
    r->last_map = *map;
    st = vvi_gltf_index(&r->g, primitive, "indices", json_array_size(json_object_get(r->g.root, "accessors")), &index,
                        &there);
    if (st == VV_OK && there)
        st = vvi_gltf_count_accessor(&n, &r->g, index, 1, 1);
    r->n_triangles += mode == TRIANGLES ? n / 3 : n > 2 ? n - 2 : 0;
    return st;
}

static vv_status read_primitive(reader *r, const json_t *primitive, const vv_affine *map, const char *name)
{
    const json_t *mode_at = json_object_get(primitive, "mode");
    int64_t mode = TRIANGLES;
    attributes a;
    material m;
    size_t index;
    bool there;
    vv_status st = VV_OK;
    if (r->counting && r->n_objects++ % 4096 == 0 && (st = check_counts(r)) != VV_OK)
        return st;
    if (mode_at && !vvi_json_whole(&mode, mode_at))
        return vvi_gltf_fail(&r->g, "a primitive has a 'mode' that is not a number");
    if (mode < TRIANGLES || mode > FAN) {
        r->n_other += !r->counting;
        return VV_OK;
    }
    if ((st = find_material(&m, r, primitive)) != VV_OK || (st = find_attributes(&a, r, primitive, &m)) != VV_OK ||
        !a.has_position)
        return st;
    r->any_colors |= a.has_color;
    if (r->counting)
        return count_primitive(r, primitive, &a, map, mode);
    if ((st = begin_part(r, &m, name)) != VV_OK || (st = put_vertices(r, &a, map)) != VV_OK ||
        (st = vvi_gltf_index(&r->g, primitive, "indices", json_array_size(json_object_get(r->g.root, "accessors")),
                             &index, &there)) != VV_OK)
        return st;
    const bool mirrored = vv_affine_determinant(*map) < 0;
    if (!there)
        return put_triangles(r, NULL, r->b.info.n_vertices - r->first_vertex, mode, mirrored);
    vvi_gltf_numbers n;
    if ((st = vvi_gltf_read_accessor(&n, &r->g, index, 1, 1)) != VV_OK)
        return st;
    for (size_t i = 0; i < n.n && st == VV_OK; i++)
        if (!(n.v[i] >= 0 && n.v[i] < UINT32_MAX))
            st = vvi_gltf_fail(&r->g, "an index is %g, which is not a vertex", n.v[i]);
    if (st == VV_OK)
        st = put_triangles(r, n.v, n.n, mode, mirrored);
    vvi_free(n.v);
    return st;
}

/* Nodes ----------------------------------------------------------------------------------------------------------- */

static const char *name_of(const json_t *object)
{
    const char *name = json_string_value(json_object_get(object, "name"));
    return name ? name : "";
}

static vv_status read_mesh(reader *r, const json_t *node, const vv_affine *map)
{
    const json_t *meshes = json_object_get(r->g.root, "meshes");
    size_t index;
    bool there;
    vv_status st = vvi_gltf_index(&r->g, node, "mesh", json_array_size(meshes), &index, &there);
    if (st != VV_OK || !there)
        return st;
    const json_t *mesh = json_array_get(meshes, index), *primitives = json_object_get(mesh, "primitives");
    const char *name = name_of(mesh)[0] ? name_of(mesh) : name_of(node);
    const vv_affine whole = tidy(vv_affine_compose(r->from_scene, *map));
    for (size_t i = 0; i < json_array_size(primitives) && st == VV_OK; i++)
        if ((st = vvi_job_poll(r->g.job)) == VV_OK)
            st = read_primitive(r, json_array_get(primitives, i), &whole, name);
    return st;
}

/* NOLINTNEXTLINE(misc-no-recursion): as deep as DEPTH_MOST */
static vv_status read_node(reader *r, const json_t *index, const vv_affine *above, int depth)
{
    const json_t *nodes = json_object_get(r->g.root, "nodes");
    int64_t n;
    vv_affine own;
    if (!vvi_json_whole(&n, index) || n < 0 || (size_t)n >= json_array_size(nodes))
        return vvi_gltf_fail(&r->g, "names a node that does not exist");
    if (depth > DEPTH_MOST || r->seen[n])
        return vvi_gltf_fail(&r->g, "node %lld has two parents, or is nested deeper than %d", (long long)n, DEPTH_MOST);
    r->seen[n] = true;
    const json_t *node = json_array_get(nodes, (size_t)n), *children = json_object_get(node, "children");
    vv_status st = map_of_node(&own, r, node);
    if (st != VV_OK)
        return st;
    const vv_affine map = vv_affine_compose(*above, own);
    st = read_mesh(r, node, &map);
    for (size_t i = 0; i < json_array_size(children) && st == VV_OK; i++)
        st = read_node(r, json_array_get(children, i), &map, depth + 1);
    return st;
}

static vv_status walk_scene(reader *r, const json_t *nodes, size_t n_nodes, bool counting)
{
    const vv_affine identity = vv_affine_identity();
    vv_status st = VV_OK;
    r->counting = counting;
    r->last = (attributes){0};
    memset(r->seen, 0, n_nodes + 1);
    for (size_t i = 0; i < json_array_size(nodes) && st == VV_OK; i++)
        st = read_node(r, json_array_get(nodes, i), &identity, 0);
    return st;
}

/* The scene that is to be shown, else the first. */
static vv_status read_scene(reader *r)
{
    const json_t *scenes = json_object_get(r->g.root, "scenes");
    const size_t n_nodes = json_array_size(json_object_get(r->g.root, "nodes"));
    size_t index = 0;
    bool there;
    vv_status st = vvi_gltf_index(&r->g, r->g.root, "scene", json_array_size(scenes), &index, &there);
    if (st != VV_OK)
        return st;
    const json_t *nodes = json_object_get(json_array_get(scenes, index), "nodes");
    r->seen = vvi_alloc_zeroed(r->g.job, n_nodes + 1, VVI_MEM_SCRATCH);
    if (!r->seen)
        return vv_fail_memory(n_nodes);
    if ((st = walk_scene(r, nodes, n_nodes, true)) != VV_OK)
        return st;
    r->counting = false;
    if ((st = check_counts(r)) == VV_OK &&
        (st = vvi_memory_plan(r->g.job, 36 * r->n_vertices + 16 * r->n_triangles, "a mesh")) == VV_OK &&
        (st = vvi_mesh_builder_reserve(&r->b, r->n_vertices, r->n_triangles)) == VV_OK)
        st = walk_scene(r, nodes, n_nodes, false);
    return st;
}

static void copy_text(char *out, size_t room, const json_t *value)
{
    const char *text = json_string_value(value);
    const size_t n = text ? vvi_utf8_cut(text, strlen(text), room - 1) : 0;
    if (n)
        memcpy(out, text, n);
    out[n] = 0;
}

/* Files of VolVis say what their lengths were before they became metres. */
static void choose_axes(reader *r)
{
    const json_t *extras = json_object_get(json_object_get(json_object_get(r->g.root, "asset"), "extras"), "volvis");
    const char *unit = json_string_value(json_object_get(extras, "unit"));
    const double metres = unit ? vvi_length_unit_metres(unit) : 0;
    static const vv_affine upright = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
    const char *up = json_string_value(json_object_get(extras, "up"));
    r->b.info.up = up && strcmp(up, "y") == 0 ? VV_UP_Y : VV_UP_Z;
    r->from_scene = r->b.info.up == VV_UP_Y ? upright : vvi_gltf_to_volvis;
    copy_text(r->b.info.unit, sizeof r->b.info.unit, json_object_get(extras, "unit"));
    if (!unit)
        strcpy(r->b.info.unit, "m");
    copy_text(r->b.info.value_name, sizeof r->b.info.value_name, json_object_get(extras, "value_name"));
    copy_text(r->b.info.value_unit, sizeof r->b.info.value_unit, json_object_get(extras, "value_unit"));
    const char *space = json_string_value(json_object_get(extras, "space"));
    r->b.info.space = space && strcmp(space, "RAS") == 0 ? VV_SPACE_RAS : VV_SPACE_PLAIN;
    for (int a = 0; a < 3 && metres > 0; a++) {
        vv_vec3 *axis = &r->from_scene.axis[a];
        *axis = (vv_vec3){axis->x / metres, axis->y / metres, axis->z / metres};
    }
}

static vv_status read_all(reader *r, vv_source *source, vv_job *job)
{
    vv_status st = vvi_gltf_open(&r->g, source, job);
    if (st != VV_OK)
        return st;
    choose_axes(r);
    if ((st = read_scene(r)) == VV_OK && r->n_other > 0)
        st = vvi_notes_warn(r->notes, "has %zu primitives of points and lines, which are left out", r->n_other);
    return st;
}

static vv_status read_gltf(vv_mesh **out, vv_source *source, const vv_mesh_read_options *options, vv_notes *notes,
                           vv_job *job)
{
    reader r = {.notes = notes};
    vvi_mesh_builder_begin(&r.b, source, options, true, job);
    vv_status st = read_all(&r, source, job);
    if (st == VV_OK)
        st = vvi_mesh_builder_finish(out, &r.b, notes);
    vvi_mesh_builder_free(&r.b);
    vvi_gltf_finish(&r.g);
    vvi_free(r.seen);
    vvi_free(r.images);
    return st;
}

/* The rows -------------------------------------------------------------------------------------------------------- */

static int probe_glb(const uint8_t *head, size_t n, const char *path)
{
    (void)path;
    return n >= 4 && memcmp(head, "glTF", 4) == 0 ? 2 : 0;
}

static int probe_gltf(const uint8_t *head, size_t n, const char *path)
{
    size_t at = 0;
    (void)path;
    while (at < n && strchr(" \t\r\n", head[at]) && head[at])
        at++;
    if (at == n || head[at] != '{')
        return 0;
    return memmem(head, n, "\"asset\"", 7) ? 2 : memmem(head, n, "\"accessors\"", 11) ? 1 : 0;
}

enum {
    HOLDS = VV_MESH_HOLDS_NORMALS | VV_MESH_HOLDS_VALUES | VV_MESH_HOLDS_COLORS | VV_MESH_HOLDS_PARTS |
            VV_MESH_HOLDS_PART_COLORS | VV_MESH_HOLDS_UNIT | VV_MESH_HOLDS_DOUBLES | VV_MESH_HOLDS_TEXTURES
};
static const char *const glb_suffixes[] = {".glb", NULL};
static const char *const gltf_suffixes[] = {".gltf", NULL};
static const char *const gltf_encodings[] = {"base64", "separate", NULL};

const vv_mesh_format vvi_mesh_format_glb = {
    .api = VV_MESH_FORMAT_API,
    .name = "glb",
    .doc =
        "binary glTF 2.0, for browsers and viewers: normals, values, colours, parts, images on triangles; metres, y up",
    .suffixes = glb_suffixes,
    .holds = HOLDS,
    .probe = probe_glb,
    .read = read_gltf,
    .write = vvi_glb_write,
};

const vv_mesh_format vvi_mesh_format_gltf = {
    .beside = true,
    .api = VV_MESH_FORMAT_API,
    .name = "gltf",
    .doc = "glTF 2.0 as text: the same as glb, with its numbers as base64 or in a .bin file next to it",
    .suffixes = gltf_suffixes,
    .encodings = gltf_encodings,
    .holds = HOLDS,
    .probe = probe_gltf,
    .read = read_gltf,
    .write = vvi_gltf_write,
};
