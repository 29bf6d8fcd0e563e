/* Materials of glTF: colours, what alpha means, and images with how they lie on triangles. */
#include "core/memory.h"
#include "io/json.h"
#include "io/meshes/gltf_reader.h"

#include <math.h>
#include <string.h>

double vvi_gltf_opacity(double alpha, vvi_texture_alpha means, double cutoff)
{
    return means == VVI_TEXTURE_BLEND ? alpha : means == VVI_TEXTURE_OPAQUE || alpha >= cutoff ? 1 : 0;
}

static vvi_texture_use use_of(const vvi_gltf_reader *r, const vvi_gltf_material *m, const json_t *texture)
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
static vv_status open_image(size_t *texture, vvi_gltf_reader *r, const json_t *image, const vvi_texture_use *use)
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
static vv_status read_image(size_t *texture, vvi_gltf_reader *r, const json_t *image, const vvi_texture_use *use)
{
    for (size_t i = 0; i < r->n_images; i++)
        if (r->images[i].image == image && is_same_use(&r->images[i].use, use)) {
            *texture = r->images[i].texture;
            return VV_OK;
        }
    vvi_gltf_image *grown = vvi_realloc(r->g.job, r->images, (r->n_images + 1) * sizeof *grown, VVI_MEM_SCRATCH);
    if (!grown)
        return vv_fail_memory((r->n_images + 1) * sizeof *grown);
    r->images = grown;
    const vv_status st = open_image(texture, r, image, use);
    if (st == VV_OK)
        r->images[r->n_images++] = (vvi_gltf_image){image, *use, *texture};
    return st;
}

/* KHR_texture_transform: scale, then turn, then shift; and v runs upwards here. */
static void take_transform(vvi_gltf_material *m, const json_t *info)
{
    const json_t *t = json_object_get(json_object_get(info, "extensions"), "KHR_texture_transform");
    double scale[2] = {1, 1}, offset[2] = {0, 0}, turn = 0;
    int64_t set;
    double v[2];
    if (vvi_gltf_numbers_at(v, 2, t, "scale"))
        memcpy(scale, v, sizeof v);
    if (vvi_gltf_numbers_at(v, 2, t, "offset"))
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
static vv_status find_image(const json_t **texture, const json_t **image, const vvi_gltf_reader *r, const json_t *info)
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

static vv_status read_texture(vvi_gltf_material *m, vvi_gltf_reader *r, size_t number, const json_t *info)
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

static void take_alpha(vvi_gltf_material *m, const json_t *of)
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
static void settle_alpha(vvi_gltf_material *m, bool image)
{
    double *a = &m->factor[3];
    if (m->alpha == VVI_TEXTURE_OPAQUE)
        *a = 1;
    if (m->alpha == VVI_TEXTURE_MASK && image) {
        m->cutoff = *a > 0 ? m->cutoff / *a : m->cutoff > 0 ? 2 : 0;
        *a = 1;
    }
    m->color[3] = image ? *a : vvi_gltf_opacity(*a, m->alpha, m->cutoff);
}

vv_status vvi_gltf_find_material(vvi_gltf_material *out, vvi_gltf_reader *r, const json_t *primitive)
{
    const json_t *materials = json_object_get(r->g.root, "materials");
    size_t index;
    bool there;
    *out =
        (vvi_gltf_material){.factor = {1, 1, 1, 1}, .alpha = VVI_TEXTURE_OPAQUE, .to_image = {{1, 0, 0}, {0, -1, 1}}};
    const vv_status st = vvi_gltf_index(&r->g, primitive, "material", json_array_size(materials), &index, &there);
    if (st != VV_OK || !there)
        return st;
    const json_t *of = json_array_get(materials, index), *pbr = json_object_get(of, "pbrMetallicRoughness");
    double v[4];
    if (vvi_gltf_numbers_at(v, 4, pbr, "baseColorFactor"))
        memcpy(out->factor, v, sizeof v);
    const json_t *info = json_object_get(pbr, "baseColorTexture");
    out->colored = vvi_gltf_numbers_at(out->color, 4, pbr, "baseColorFactor");
    take_alpha(out, of);
    settle_alpha(out, info != NULL);
    out->colored |=
        vvi_gltf_numbers_at(out->color, 4, json_object_get(json_object_get(of, "extras"), "volvis"), "color");
    return info ? read_texture(out, r, index, info) : VV_OK;
}
