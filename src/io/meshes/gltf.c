/* The rows of glTF and GLB, and reading them: nodes with their maps, and primitives of meshes. */
#include "core/job.h"
#include "core/limits.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/json.h"
#include "io/meshes/gltf_reader.h"
#include "io/scan.h"
#include "registry.h"

#include <math.h>
#include <string.h>

enum { DEPTH_MOST = 64, TRIANGLES = 4, STRIP = 5, FAN = 6 };

const vv_affine vvi_gltf_to_volvis = {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {0, 0, 0}};

/* Maps ------------------------------------------------------------------------------------------------------------ */

static vv_affine affine_of_parts(const double t[3], const double q[4], const double s[3])
{
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    return (vv_affine){{{s[0] * (1 - 2 * (y * y + z * z)), s[0] * 2 * (x * y + z * w), s[0] * 2 * (x * z - y * w)},
                        {s[1] * 2 * (x * y - z * w), s[1] * (1 - 2 * (x * x + z * z)), s[1] * 2 * (y * z + x * w)},
                        {s[2] * 2 * (x * z + y * w), s[2] * 2 * (y * z - x * w), s[2] * (1 - 2 * (x * x + y * y))}},
                       {t[0], t[1], t[2]}};
}

static vv_status map_of_node(vv_affine *out, const vvi_gltf_reader *r, const json_t *node)
{
    double m[16], t[3] = {0, 0, 0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    if (json_object_get(node, "matrix")) {
        if (!vvi_gltf_numbers_at(m, 16, node, "matrix"))
            return vvi_gltf_fail(&r->g, "a node's 'matrix' is not 16 finite numbers");
        *out = (vv_affine){{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}}, {m[12], m[13], m[14]}};
        return VV_OK;
    }
    if ((json_object_get(node, "translation") && !vvi_gltf_numbers_at(t, 3, node, "translation")) ||
        (json_object_get(node, "rotation") && !vvi_gltf_numbers_at(q, 4, node, "rotation")) ||
        (json_object_get(node, "scale") && !vvi_gltf_numbers_at(s, 3, node, "scale")))
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

/* Triangles ------------------------------------------------------------------------------------------------------- */

static vv_status put_one(vvi_gltf_reader *r, size_t a, size_t b, size_t c, bool mirrored)
{
    const uint32_t first = (uint32_t)r->first_vertex;
    const uint32_t t[3] = {first + (uint32_t)a, first + (uint32_t)(mirrored ? c : b),
                           first + (uint32_t)(mirrored ? b : c)};
    return vvi_mesh_builder_triangle(&r->b, t);
}

/* index NULL: vertices in their order. */
static vv_status put_triangles(vvi_gltf_reader *r, const double *index, size_t n, int64_t mode, bool mirrored)
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

static vv_status begin_part(vvi_gltf_reader *r, const vvi_gltf_material *m, const char *name)
{
    const vv_color color = {m->color[0], m->color[1], m->color[2], m->color[3]};
    return vvi_mesh_builder_part(&r->b, name, strlen(name), m->colored ? &color : NULL, m->texture);
}

/* Nodes may name one object many times: that costs no bytes of the file, so it is counted before room is taken, and an
 * object without triangles counts for the time that it takes. */
static vv_status check_counts(const vvi_gltf_reader *r)
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
static vv_status count_primitive(vvi_gltf_reader *r, const json_t *primitive, const vvi_gltf_attributes *a,
                                 const vv_affine *map, int64_t mode)
{
    size_t index, n;
    bool there;
    vv_status st = vvi_gltf_count_accessor(&n, &r->g, a->position, 3, 3);
    if (st != VV_OK)
        return st;
    r->n_vertices += vvi_gltf_same_attributes(r, a, map) ? 0 : n;
    r->last = *a;
    r->last_map = *map;
    st = vvi_gltf_index(&r->g, primitive, "indices", json_array_size(json_object_get(r->g.root, "accessors")), &index,
                        &there);
    if (st == VV_OK && there)
        st = vvi_gltf_count_accessor(&n, &r->g, index, 1, 1);
    r->n_triangles += mode == TRIANGLES ? n / 3 : n > 2 ? n - 2 : 0;
    return st;
}

static vv_status read_primitive(vvi_gltf_reader *r, const json_t *primitive, const vv_affine *map, const char *name)
{
    const json_t *mode_at = json_object_get(primitive, "mode");
    int64_t mode = TRIANGLES;
    vvi_gltf_attributes a;
    vvi_gltf_material m;
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
    if ((st = vvi_gltf_find_material(&m, r, primitive)) != VV_OK ||
        (st = vvi_gltf_find_attributes(&a, r, primitive, &m)) != VV_OK || !a.has_position)
        return st;
    r->any_colors |= a.has_color;
    if (r->counting)
        return count_primitive(r, primitive, &a, map, mode);
    if ((st = begin_part(r, &m, name)) != VV_OK || (st = vvi_gltf_put_vertices(r, &a, map)) != VV_OK ||
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

static vv_status read_mesh(vvi_gltf_reader *r, const json_t *node, const vv_affine *map)
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
static vv_status read_node(vvi_gltf_reader *r, const json_t *index, const vv_affine *above, int depth)
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

static vv_status walk_scene(vvi_gltf_reader *r, const json_t *nodes, size_t n_nodes, bool counting)
{
    const vv_affine identity = vv_affine_identity();
    vv_status st = VV_OK;
    r->counting = counting;
    r->last = (vvi_gltf_attributes){0};
    memset(r->seen, 0, n_nodes + 1);
    for (size_t i = 0; i < json_array_size(nodes) && st == VV_OK; i++)
        st = read_node(r, json_array_get(nodes, i), &identity, 0);
    return st;
}

/* The scene that is to be shown, else the first. */
static vv_status read_scene(vvi_gltf_reader *r)
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
static void choose_axes(vvi_gltf_reader *r)
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

static vv_status read_all(vvi_gltf_reader *r, vv_source *source, vv_job *job)
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
    vvi_gltf_reader r = {.notes = notes};
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
