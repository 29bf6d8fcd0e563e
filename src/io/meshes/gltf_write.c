/* Writing glTF and GLB: one buffer of places, normals, colours, values and indices; a node that turns and scales them
 * to metres with y up, and below it a node and a mesh for each part, which share the vertices. */
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "grid/field.h"
#include "grid/mesh.h"
#include "io/base64.h"
#include "io/meshes/gltf.h"
#include "io/meshes/mesh_column.h"
#include "io/meshes/mesh_texture.h"
#include "io/meshes/mesh_write.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <volvis/image.h>

enum { BLOCK = 4096, FLOAT = 5126, UNSIGNED_SHORT = 5123, UNSIGNED_INT = 5125, VERTICES = 34962, INDICES = 34963 };

/* A file of an image. */
typedef struct encoded {
    uint8_t *bytes;
    size_t n;
} encoded;

typedef struct writer {
    vv_sink *sink;
    vv_mesh *own;
    const vv_mesh *mesh; /* the same */
    const vv_mesh_info *m;
    vvi_text json;
    uint64_t n_bytes; /* of the buffer */
    int n_views;      /* and accessors, but for images, which have only views */
    encoded *images;  /* of each texture */
    bool base64;
    vvi_base64 coder;
    vv_job *job;
} writer;

/* JSON ------------------------------------------------------------------------------------------------------------ */

static void add_number(vvi_text *t, double v)
{
    char number[32];
    vvi_print_unsigned_zero(number, v);
    vvi_text_add(t, number);
}

static void add_numbers(vvi_text *t, const char *key, const double *v, int n)
{
    vvi_text_printf(t, "\"%s\":[", key);
    for (int i = 0; i < n; i++) {
        vvi_text_add(t, i ? "," : "");
        add_number(t, v[i]);
    }
    vvi_text_add(t, "]");
}

static void add_asset(writer *w)
{
    vvi_text *t = &w->json;
    vvi_text_add(t, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"VolVis\",\"extras\":{\"volvis\":{\"unit\":");
    vvi_text_json(t, w->m->unit);
    if (w->m->space == VV_SPACE_RAS)
        vvi_text_add(t, ",\"space\":\"RAS\"");
    if (w->m->up == VV_UP_Y)
        vvi_text_add(t, ",\"up\":\"y\"");
    if (w->m->values) {
        vvi_text_add(t, ",\"value_name\":");
        vvi_text_json(t, w->m->value_name);
        vvi_text_add(t, ",\"value_unit\":");
        vvi_text_json(t, w->m->value_unit);
    }
    vvi_text_add(t, "}}},\"scene\":0,");
}

/* To metres, x right, y up, z towards the viewer: the inverse of vvi_gltf_to_volvis, where y is not up already. */
static void add_root(writer *w, size_t n_children)
{
    const double metres = vvi_length_unit_metres(w->m->unit), s = metres > 0 ? metres : 1;
    const vv_vec3 o = w->m->origin;
    const double turned[16] = {s, 0, 0, 0, 0, 0, -s, 0, 0, s, 0, 0, o.x * s, o.z * s, -o.y * s, 1};
    const double straight[16] = {s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, o.x * s, o.y * s, o.z * s, 1};
    vvi_text_add(&w->json, "{\"name\":\"VolVis\",");
    add_numbers(&w->json, "matrix", w->m->up == VV_UP_Y ? straight : turned, 16);
    vvi_text_add(&w->json, ",\"children\":[");
    for (size_t i = 0; i < n_children; i++)
        vvi_text_printf(&w->json, "%s%zu", i ? "," : "", i + 1);
    vvi_text_add(&w->json, "]}");
}

static size_t n_meshes(const writer *w)
{
    return w->m->n_triangles == 0 ? 0 : w->m->n_parts ? w->m->n_parts : 1;
}

static void add_nodes(writer *w)
{
    const size_t n = n_meshes(w);
    if (n == 0) {
        vvi_text_add(&w->json, "\"scenes\":[{}]");
        return;
    }
    vvi_text_add(&w->json, "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[");
    add_root(w, n);
    for (size_t i = 0; i < n; i++) {
        vvi_text_add(&w->json, ",{\"name\":");
        vvi_text_json(&w->json, w->m->n_parts ? w->m->parts[i].name : "");
        vvi_text_printf(&w->json, ",\"mesh\":%zu}", i);
    }
    vvi_text_add(&w->json, "]");
}

/* An accessor and its view, one for one; as long as a multiple of four. */
static int add_view(writer *w, vvi_text *accessors, vvi_text *views, const char *about, size_t n, size_t each,
                    int target)
{
    vvi_text_printf(accessors, "%s{\"bufferView\":%d,\"count\":%zu,%s}", w->n_views ? "," : "", w->n_views, n, about);
    vvi_text_printf(views, "%s{\"buffer\":0,\"byteOffset\":%llu,\"byteLength\":%llu,\"target\":%d}",
                    w->n_views ? "," : "", (unsigned long long)w->n_bytes, (unsigned long long)n * each, target);
    w->n_bytes += (uint64_t)n * each;
    return w->n_views++;
}

/* The box of positions is required. */
static char *about_positions(const writer *w)
{
    vvi_text t = {0};
    const vv_bounds box = vv_mesh_bounds(w->mesh);
    const vv_vec3 o = w->m->origin;
    const double lo[3] = {(float)(box.lo.x - o.x), (float)(box.lo.y - o.y), (float)(box.lo.z - o.z)};
    const double hi[3] = {(float)(box.hi.x - o.x), (float)(box.hi.y - o.y), (float)(box.hi.z - o.z)};
    vvi_text_add(&t, "\"componentType\":5126,\"type\":\"VEC3\",");
    add_numbers(&t, "min", lo, 3);
    vvi_text_add(&t, ",");
    add_numbers(&t, "max", hi, 3);
    return vvi_text_take(&t);
}

static bool is_translucent(const vv_mesh_texture *t)
{
    bool some = false;
    for (size_t i = 0; i < (size_t)t->width * (size_t)t->height && !some; i++)
        some = t->pixels[4 * i + 3] < 255;
    return some;
}

/* Parts share their vertices, whose alpha is to mean the same in all. */
static bool blends_vertices(const vv_mesh_info *m)
{
    bool some = false;
    for (size_t i = 0; m->colors && i < m->n_vertices && !some; i++)
        some = m->colors[4 * i + 3] < 255;
    for (size_t i = 0; m->colors && i < m->n_textures && !some; i++)
        some = is_translucent(&m->textures[i]);
    return some;
}

static int wrap_code(int wrap)
{
    enum { REPEAT = 10497, CLAMP = 33071, MIRROR = 33648 };
    return wrap == VV_WRAP_CLAMP ? CLAMP : wrap == VV_WRAP_MIRROR ? MIRROR : REPEAT;
}

static void add_textures(writer *w, int first_view)
{
    const vv_mesh_info *m = w->m;
    vvi_text *t = &w->json;
    vvi_text_add(t, ",\"textures\":[");
    for (size_t i = 0; i < m->n_textures; i++)
        vvi_text_printf(t, "%s{\"sampler\":%zu,\"source\":%zu}", i ? "," : "", i, i);
    vvi_text_add(t, "],\"samplers\":[");
    for (size_t i = 0; i < m->n_textures; i++)
        vvi_text_printf(t, "%s{\"wrapS\":%d,\"wrapT\":%d}", i ? "," : "", wrap_code(m->textures[i].wrap[0]),
                        wrap_code(m->textures[i].wrap[1]));
    vvi_text_add(t, "],\"images\":[");
    for (size_t i = 0; i < m->n_textures; i++) {
        vvi_text_printf(t, "%s{\"bufferView\":%d,\"mimeType\":\"image/png\",\"name\":", i ? "," : "",
                        first_view + (int)i);
        vvi_text_json(t, m->textures[i].name);
        vvi_text_add(t, "}");
    }
    vvi_text_add(t, "]");
}

/* A view that no accessor has; as long as a multiple of four, with zeros behind the file. */
static void add_image_view(writer *w, vvi_text *views, size_t n)
{
    vvi_text_printf(views, ",{\"buffer\":0,\"byteOffset\":%llu,\"byteLength\":%zu}", (unsigned long long)w->n_bytes, n);
    w->n_bytes += (n + 3) / 4 * 4;
    w->n_views++;
}

static void add_meshes(writer *w, const char *attributes, int first_indices)
{
    vvi_text_add(&w->json, ",\"meshes\":[");
    for (size_t i = 0; i < n_meshes(w); i++) {
        vvi_text_printf(&w->json, "%s{\"name\":", i ? "," : "");
        vvi_text_json(&w->json, w->m->n_parts ? w->m->parts[i].name : "");
        vvi_text_printf(&w->json, ",\"primitives\":[{\"attributes\":{%s},\"indices\":%d,\"material\":%zu}]}",
                        attributes, first_indices + (int)i, i);
    }
    const bool all = blends_vertices(w->m);
    vvi_text_add(&w->json, "],\"materials\":[");
    for (size_t i = 0; i < n_meshes(w); i++) {
        const vv_color *c = w->m->n_parts ? &w->m->parts[i].color : NULL;
        vvi_text_printf(&w->json, "%s{\"doubleSided\":true,\"pbrMetallicRoughness\":{", i ? "," : "");
        const bool colored = c && c->a >= 0, noted = colored && w->m->colors; /* vertices' colours take its place */
        if (colored && !noted) {
            add_numbers(&w->json, "baseColorFactor", &c->r, 4);
            vvi_text_add(&w->json, ",");
        }
        const size_t texture = w->images && w->m->n_parts ? w->m->parts[i].texture : 0;
        if (texture)
            vvi_text_printf(&w->json, "\"baseColorTexture\":{\"index\":%zu},", texture - 1);
        const bool blend =
            all || (colored && !noted && c->a < 1) || (texture && is_translucent(&w->m->textures[texture - 1]));
        vvi_text_printf(&w->json, "\"metallicFactor\":0,\"roughnessFactor\":0.6}%s",
                        blend ? ",\"alphaMode\":\"BLEND\"" : "");
        if (noted) {
            vvi_text_add(&w->json, ",\"extras\":{\"volvis\":{");
            add_numbers(&w->json, "color", &c->r, 4);
            vvi_text_add(&w->json, "}}");
        }
        vvi_text_add(&w->json, "}");
    }
    vvi_text_add(&w->json, "]");
}

static void add_arrays(writer *w)
{
    const vv_mesh_info *m = w->m;
    vvi_text accessors = {0}, views = {0}, attributes = {0};
    char *positions = about_positions(w);
    if (!positions) {
        w->json.bad = true;
        return;
    }
    vvi_text_printf(&attributes, "\"POSITION\":%d",
                    add_view(w, &accessors, &views, positions, m->n_vertices, 12, VERTICES));
    free(positions);
    if (m->normals)
        vvi_text_printf(
            &attributes, ",\"NORMAL\":%d",
            add_view(w, &accessors, &views, "\"componentType\":5126,\"type\":\"VEC3\"", m->n_vertices, 12, VERTICES));
    if (m->colors)
        vvi_text_printf(&attributes, ",\"COLOR_0\":%d",
                        add_view(w, &accessors, &views, "\"componentType\":5123,\"normalized\":true,\"type\":\"VEC4\"",
                                 m->n_vertices, 8, VERTICES));
    if (m->values)
        vvi_text_printf(
            &attributes, ",\"_VALUE\":%d",
            add_view(w, &accessors, &views, "\"componentType\":5126,\"type\":\"SCALAR\"", m->n_vertices, 4, VERTICES));
    if (m->coordinates)
        vvi_text_printf(
            &attributes, ",\"TEXCOORD_0\":%d",
            add_view(w, &accessors, &views, "\"componentType\":5126,\"type\":\"VEC2\"", m->n_vertices, 8, VERTICES));
    const int first_indices = w->n_views;
    for (size_t i = 0; i < n_meshes(w); i++)
        add_view(w, &accessors, &views, "\"componentType\":5125,\"type\":\"SCALAR\"",
                 3 * (m->n_parts ? m->parts[i].n_triangles : m->n_triangles), 4, INDICES);
    add_meshes(w, attributes.s ? attributes.s : "", first_indices);
    if (w->images)
        add_textures(w, w->n_views);
    for (size_t i = 0; w->images && i < m->n_textures; i++)
        add_image_view(w, &views, w->images[i].n);
    vvi_text_printf(&w->json, ",\"accessors\":[%s],\"bufferViews\":[%s]", accessors.s ? accessors.s : "",
                    views.s ? views.s : "");
    w->json.bad = w->json.bad || accessors.bad || views.bad || attributes.bad;
    vvi_text_free(&accessors);
    vvi_text_free(&views);
    vvi_text_free(&attributes);
}

/* All but the buffer's own entry and the closing brace. */
static vv_status make_json(writer *w)
{
    add_asset(w);
    add_nodes(w);
    if (n_meshes(w))
        add_arrays(w);
    return w->json.bad ? vv_fail_memory(w->json.n) : VV_OK;
}

/* The buffer ------------------------------------------------------------------------------------------------------ */

/* Numbers of four or two bytes, the low one first. */
static vv_status put(writer *w, const void *data, size_t each, size_t n)
{
    vv_status st = VV_OK;
    uint8_t swapped[BLOCK * 4];
    const uint8_t *in = data;
    for (size_t i = 0; i < n && st == VV_OK; i += BLOCK) {
        const size_t some = n - i < BLOCK ? n - i : BLOCK;
        const uint8_t *from = in + i * each;
        if (vvi_machine_is_big()) {
            memcpy(swapped, from, some * each);
            vvi_swap_bytes(swapped, each, some);
            from = swapped;
        }
        st = w->base64 ? vvi_base64_write(&w->coder, w->sink, from, some * each)
                       : vvi_sink_write(w->sink, from, some * each);
        if (st == VV_OK)
            st = vvi_job_poll(w->job);
    }
    return st;
}

/* sRGB bytes to linear numbers of 16 bits; alpha as it is. */
static vv_status put_colors(writer *w)
{
    uint16_t linear[256], block[BLOCK];
    vv_status st = VV_OK;
    for (int i = 0; i < 256; i++)
        linear[i] = (uint16_t)(vv_srgb_decode(i / 255.0) * 65535 + 0.5);
    for (size_t i = 0; i < 4 * w->m->n_vertices && st == VV_OK; i += BLOCK) {
        const size_t some = 4 * w->m->n_vertices - i < BLOCK ? 4 * w->m->n_vertices - i : BLOCK;
        for (size_t k = 0; k < some; k++) {
            const uint8_t c = w->m->colors[i + k];
            block[k] = k % 4 == 3 ? (uint16_t)(c * 257) : linear[c];
        }
        st = put(w, block, 2, some);
    }
    return st;
}

/* v runs downwards there. */
static vv_status put_coordinates(writer *w)
{
    float block[BLOCK];
    vv_status st = VV_OK;
    for (size_t i = 0; i < 2 * w->m->n_vertices && st == VV_OK; i += BLOCK) {
        const size_t some = 2 * w->m->n_vertices - i < BLOCK ? 2 * w->m->n_vertices - i : BLOCK;
        for (size_t k = 0; k < some; k++)
            block[k] = k % 2 ? 1 - w->m->coordinates[i + k] : w->m->coordinates[i + k];
        st = put(w, block, 4, some);
    }
    return st;
}

static vv_status put_image(writer *w, const encoded *image)
{
    static const uint8_t zeros[4] = {0};
    const size_t more = (4 - image->n % 4) % 4;
    vv_status st = w->base64 ? vvi_base64_write(&w->coder, w->sink, image->bytes, image->n)
                             : vvi_sink_write(w->sink, image->bytes, image->n);
    if (st == VV_OK && more)
        st = w->base64 ? vvi_base64_write(&w->coder, w->sink, zeros, more) : vvi_sink_write(w->sink, zeros, more);
    return st;
}

static vv_status write_buffer(writer *w)
{
    const vv_mesh_info *m = w->m;
    if (w->n_bytes == 0)
        return VV_OK;
    vv_status st = put(w, m->positions, 4, 3 * m->n_vertices);
    if (st == VV_OK && m->normals)
        st = put(w, m->normals, 4, 3 * m->n_vertices);
    if (st == VV_OK && m->colors)
        st = put_colors(w);
    if (st == VV_OK && m->values)
        st = put(w, m->values, 4, m->n_vertices);
    if (st == VV_OK && m->coordinates)
        st = put_coordinates(w);
    if (st == VV_OK)
        st = put(w, m->triangles, 4, 3 * m->n_triangles);
    for (size_t i = 0; w->images && i < m->n_textures && st == VV_OK; i++)
        st = put_image(w, &w->images[i]);
    return st == VV_OK && w->base64 ? vvi_base64_end(&w->coder, w->sink) : st;
}

/* Files ----------------------------------------------------------------------------------------------------------- */

static vv_status encode_images(writer *w)
{
    const vv_mesh_info *m = w->m;
    const size_t bytes = m->n_textures * sizeof *w->images;
    vv_status st = VV_OK;
    if (!m->n_textures || !m->coordinates)
        return VV_OK;
    if (!(w->images = vvi_alloc_zeroed(w->job, bytes, VVI_MEM_SCRATCH)))
        return vv_fail_memory(bytes);
    for (size_t i = 0; i < m->n_textures && st == VV_OK; i++)
        st = vvi_mesh_texture_encode(&w->images[i].bytes, &w->images[i].n, &m->textures[i], w->job);
    return st;
}

static void finish(writer *w)
{
    for (size_t i = 0; w->images && i < w->m->n_textures; i++)
        vv_image_bytes_free(w->images[i].bytes);
    vvi_free(w->images);
    vvi_text_free(&w->json);
    vv_mesh_release(w->own);
}

/* Vertices have one place on images each. */
static vv_status begin(writer *out, vv_sink *sink, const vv_mesh *mesh, vv_job *job)
{
    *out = (writer){.sink = sink, .job = job};
    vv_status st = vvi_mesh_split_corners(&out->own, mesh, job);
    if (st != VV_OK)
        return st;
    out->mesh = out->own;
    out->m = vv_mesh_get_info(out->own);
    if ((st = encode_images(out)) != VV_OK)
        return st;
    if (out->m->values)
        for (size_t i = 0; i < out->m->n_vertices; i++)
            if (!isfinite(out->m->values[i])) {
                vvi_log(job, VV_LOG_INFO, "io", "%s: some values are not numbers, which glTF does not allow",
                        vvi_sink_name(sink));
                break;
            }
    if (!(vvi_length_unit_metres(out->m->unit) > 0))
        vvi_log(job, VV_LOG_INFO, "io", "%s: lengths in '%s' are shown as metres by other programs",
                vvi_sink_name(sink), out->m->unit);
    return make_json(out);
}

static vv_status put_u32(vv_sink *sink, const uint32_t *v, size_t n)
{
    uint8_t bytes[12];
    for (size_t i = 0; i < 4 * n; i++)
        bytes[i] = (uint8_t)(v[i / 4] >> 8 * (i % 4));
    return vvi_sink_write(sink, bytes, 4 * n);
}

static vv_status write_glb(writer *w)
{
    if (w->n_bytes)
        vvi_text_printf(&w->json, ",\"buffers\":[{\"byteLength\":%llu}]", (unsigned long long)w->n_bytes);
    vvi_text_add(&w->json, "}");
    while (w->json.n % 4 && !w->json.bad)
        vvi_text_add(&w->json, " ");
    const uint64_t all = 12 + 8 + w->json.n + (w->n_bytes ? 8 + w->n_bytes : 0);
    if (w->json.bad)
        return vv_fail_memory(w->json.n);
    if (all > UINT32_MAX)
        return vv_fail_at(VV_E_LIMIT, vvi_sink_name(w->sink), NULL,
                          "a GLB file has fewer than 2^32 bytes; write .ply, or simplify the mesh first");
    vv_status st = put_u32(w->sink, (const uint32_t[]){VVI_GLB_MAGIC, 2, (uint32_t)all}, 3);
    if (st == VV_OK && (st = put_u32(w->sink, (const uint32_t[]){(uint32_t)w->json.n, VVI_GLB_JSON}, 2)) == VV_OK)
        st = vvi_sink_write(w->sink, w->json.s, w->json.n);
    if (st == VV_OK && w->n_bytes &&
        (st = put_u32(w->sink, (const uint32_t[]){(uint32_t)w->n_bytes, VVI_GLB_BIN}, 2)) == VV_OK)
        st = write_buffer(w);
    return st;
}

vv_status vvi_glb_write(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job)
{
    writer w;
    (void)options;
    vv_status st = begin(&w, sink, mesh, job);
    if (st == VV_OK)
        st = write_glb(&w);
    finish(&w);
    return st;
}

/* "folder/a.gltf" -> "a.bin", without what a URI would have to escape. */
static char *buffer_name(const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const size_t n = strlen(name);
    char *out = vvi_asprintf("%.*s.bin", (int)(n > 5 && strcasecmp(name + n - 5, ".gltf") == 0 ? n - 5 : n), name);
    for (char *at = out; at && *at; at++)
        *at = (char)(strchr(" %#?\"\\", *at) || *at < ' ' ? '_' : *at);
    return out;
}

static vv_status write_beside(writer *w)
{
    vv_sink *main = w->sink, *beside = NULL;
    char *name = buffer_name(vvi_sink_name(main));
    if (!name)
        return vv_fail_memory(strlen(vvi_sink_name(main)));
    vv_status st = vvi_sink_beside(&beside, main, name);
    if (st == VV_OK) {
        w->sink = beside;
        st = write_buffer(w);
        w->sink = main;
    }
    if (st == VV_OK)
        st = vvi_sink_printf(main, "%s,\"buffers\":[{\"byteLength\":%llu,\"uri\":\"%s\"}]}\n", w->json.s,
                             (unsigned long long)w->n_bytes, name);
    free(name);
    return st;
}

static vv_status write_embedded(writer *w)
{
    vv_status st = vvi_sink_write(w->sink, w->json.s, w->json.n);
    if (st == VV_OK)
        st = vvi_sink_printf(w->sink,
                             ",\"buffers\":[{\"byteLength\":%llu,\"uri\":\"data:application/octet-stream;base64,",
                             (unsigned long long)w->n_bytes);
    w->base64 = true;
    if (st == VV_OK && (st = write_buffer(w)) == VV_OK)
        st = vvi_sink_printf(w->sink, "\"}]}\n");
    return st;
}

vv_status vvi_gltf_write(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job)
{
    writer w;
    vv_status st = begin(&w, sink, mesh, job);
    if (st == VV_OK && w.n_bytes == 0)
        st = vvi_sink_printf(sink, "%s}\n", w.json.s);
    else if (st == VV_OK)
        st = strcmp(options->encoding, "separate") == 0 ? write_beside(&w) : write_embedded(&w);
    finish(&w);
    return st;
}
