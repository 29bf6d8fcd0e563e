#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "gfx/texture.h"
#include "grid/field.h"
#include "grid/mesh.h"
#include "grid/probe.h"
#include "render/surface/surface.h"
#include "server/page_shape_impl.h"
#include "surface/boxes.h"
#include "surface/compact.h"
#include "surface/reduced.h"
#include "surface/simplify.h"
#include "surface/vertex_places.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    SHIFT_MOST = 16, /* of boxes */
    MESH_BYTES = 19, /* of one of a mesh: half a vertex, with its colour */
    TRIES = 6
};

typedef struct making {
    const vvi_page_shape_options *options;
    const vv_scene *scene;
    vvi_page_shape *shape;
    size_t bytes; /* of one file */
    vv_job *job;
    /* of one file: */
    const vv_actor *actor;
    const vv_mesh_actor *mesh; /* NULL: of a volume */
    double value;
    bool upper;
} making;

/* Volumes --------------------------------------------------------------------------------------------------------- */

static const vvi_surface_params *params_of(const making *m)
{
    return (const vvi_surface_params *)m->scene->params;
}

/* Which corners of the grid of a reduced surface are inside. */
static vv_status find_corners(unsigned *corners, const vvi_reduced *r, const making *m)
{
    const bool taken = r->samples != NULL;
    vvi_probe probe;
    *corners = 0;
    const vv_status st =
        vvi_probe_open(&probe, taken ? r->samples : m->actor->field, taken ? 0 : m->actor->component, true, m->job);
    if (st != VV_OK)
        return st;
    for (unsigned c = 0; c < 8; c++) {
        double p[3];
        for (int a = 0; a < 3; a++)
            p[a] = c >> a & 1 ? (double)(r->grid.dims[a] - 1) : 0;
        *corners |= (vvi_probe_value(&probe, p) >= (taken ? 0 : m->value)) << c;
    }
    vvi_probe_close(&probe);
    return VV_OK;
}

static vv_status reduce(vvi_compact *out, vvi_page_shape_file *file, size_t most, const making *m)
{
    const vvi_surface_params *p = params_of(m);
    const bool counted = vv_object_is_set(&p->base, "triangles");
    const vvi_reduced_options o = {.value = m->value,
                                   .component = m->actor->component,
                                   .max_triangles = counted ? (size_t)p->triangles : 0,
                                   .max_bytes = most,
                                   .filter = (vvi_reduced_filter)p->filter,
                                   .keep = true};
    unsigned corners = 0;
    vvi_reduced *r;
    vv_status st = vvi_reduced_make(&r, m->actor->field, &o, m->job);
    if (st == VV_OK)
        st = find_corners(&corners, r, m);
    if (st == VV_OK)
        st = vvi_compact_reduced(out, r, corners, !m->upper, m->job);
    if (st == VV_OK) {
        file->n_triangles = r->n_triangles;
        memcpy(file->step, r->step, sizeof file->step);
    }
    vvi_reduced_free(r);
    return st;
}

/* How many bytes bricks take beside their records is known afterwards. */
static vv_status make_reduced(vvi_compact *out, vvi_page_shape_file *file, const making *m)
{
    size_t most = m->bytes;
    int32_t before = 0;
    vv_status st = reduce(out, file, most, m);
    for (int i = 0; i < TRIES && st == VV_OK && out->n > m->bytes && file->step[0] > before; i++) {
        before = file->step[0];
        most = (size_t)(0.9 * (double)most * (double)m->bytes / (double)out->n);
        vvi_free(out->bytes);
        st = reduce(out, file, most ? most : 1, m);
    }
    return st;
}

/* Larger boxes until they fit. Of the upper side of a solid those that lie above it are none of it. */
static vv_status make_boxes(vvi_compact *out, vvi_page_shape_file *file, const making *m)
{
    const vvi_surface_params *p = params_of(m);
    vvi_surface_boxes_options o = {.value = m->value,
                                   .component = m->actor->component,
                                   .max_triangles = p->triangles > 0 ? (size_t)p->triangles : 0,
                                   .merged = true};
    vv_field *solid = NULL;
    vv_mesh *mesh = NULL;
    vv_status st = vvi_surface_boxes_solid(&mesh, &solid, m->actor->field, &o, m->job);
    for (o.shift = 3; st == VV_OK && vvi_compact_boxes_bytes(solid) > m->bytes && o.shift <= SHIFT_MOST; o.shift++) {
        vv_mesh_release(mesh);
        vv_field_release(solid);
        st = vvi_surface_boxes_solid(&mesh, &solid, m->actor->field, &o, m->job);
    }
    if (st == VV_OK)
        st = vvi_compact_boxes(out, &file->n_triangles, solid, &vv_field_get_info(m->actor->field)->grid,
                               m->upper ? 2 : 1, m->job);
    vv_mesh_release(mesh);
    vv_field_release(solid);
    return st;
}

/* Meshes ---------------------------------------------------------------------------------------------------------- */

static void put_color(uint8_t bytes[4], const double rgb[3])
{
    for (int k = 0; k < 3; k++)
        bytes[k] = (uint8_t)lround(255 * vv_srgb_encode(fmin(fmax(rgb[k], 0), 1)));
    bytes[3] = 255;
}

/* Where a triangle lies on its image; of one that does not say, anywhere and all of it. */
static void look_at_image(double at[3][2], double across[2][2], const vv_mesh_info *m, size_t triangle)
{
    const uint32_t *corner = m->coordinate_of ? m->coordinate_of : m->triangles;
    for (size_t k = 0; k < 3; k++)
        for (size_t c = 0; c < 2; c++)
            at[k][c] = m->coordinates ? (double)m->coordinates[2 * (size_t)corner[3 * triangle + k] + c] : 0.5;
    for (int i = 0; i < 2; i++)
        for (int c = 0; c < 2; c++)
            across[i][c] = m->coordinates ? at[i + 1][c] - at[0][c] : i == c;
}

/* At each vertex the mean of the image over a triangle around it. */
static void color_by_image(uint8_t *out, const vv_mesh_actor *shape, const vv_mesh_info *m, const vv_mesh_part *part,
                           size_t texture)
{
    const vv_color white = {1, 1, 1, 1}, *factor = part->color.a < 0 ? &white : &part->color;
    for (size_t t = part->first_triangle; t < part->first_triangle + part->n_triangles; t++) {
        double at[3][2], across[2][2];
        look_at_image(at, across, m, t);
        for (size_t k = 0; k < 3; k++) {
            double seen[4];
            vvi_gfx_texture_at(seen, vvi_cached_value(shape->textures), texture - 1, at[k], (const double(*)[2])across);
            const double rgb[3] = {seen[0] * factor->r, seen[1] * factor->g, seen[2] * factor->b};
            put_color(out + 4 * (size_t)m->triangles[3 * t + k], rgb);
        }
    }
}

/* Those of values, of the mesh itself or of its parts; NULL, and VV_OK: it has one colour. */
static vv_status find_colors(uint8_t **out, const vv_mesh_actor *shape, const vv_mesh_info *mesh, vv_job *job)
{
    const uint8_t *given = shape->colors ? shape->colors : mesh->colors;
    const vv_mesh_part *parts = shape->parts ? shape->parts : mesh->parts;
    const vv_mesh_info *own = vv_mesh_get_info(shape->mesh); /* a simplified one has lost its images */
    const vv_vec3 plain = {(double)shape->look.color[0], (double)shape->look.color[1], (double)shape->look.color[2]};
    *out = NULL;
    if (shape->one_color || (!given && !parts))
        return VV_OK;
    *out = vvi_alloc(job, 4 * mesh->n_vertices + 1, VVI_MEM_SCRATCH);
    if (!*out)
        return vv_fail_memory(4 * mesh->n_vertices);
    if (given) {
        memcpy(*out, given, 4 * mesh->n_vertices);
        return VV_OK;
    }
    for (size_t i = 0; i < mesh->n_parts; i++) {
        const vv_color *c = &parts[i].color;
        const double rgb[3] = {c->a < 0 ? plain.x : c->r, c->a < 0 ? plain.y : c->g, c->a < 0 ? plain.z : c->b};
        uint8_t bytes[4];
        const size_t texture = own->n_parts == mesh->n_parts && shape->textures ? own->parts[i].texture : 0;
        if (texture) {
            color_by_image(*out, shape, mesh, &parts[i], texture);
            continue;
        }
        put_color(bytes, rgb);
        for (size_t v = 3 * parts[i].first_triangle; v < 3 * (parts[i].first_triangle + parts[i].n_triangles); v++)
            memcpy(*out + 4 * (size_t)mesh->triangles[v], bytes, 4);
    }
    return VV_OK;
}

/* Of one colour only: what is by vertex goes with the vertices, which the simplified mesh has fewer of. */
static vv_status simplify(vv_mesh **out, const making *m)
{
    const vvi_simplify_options o = {.triangles = m->bytes / MESH_BYTES + 1};
    if (!vvi_can_simplify())
        return vv_fail(VV_E_LIMIT, "volumes.%s: has more triangles than the page asked for", m->actor->id);
    return vvi_mesh_simplify(out, NULL, m->mesh->mesh, &o, m->job);
}

/* Vertices at one place count as one. */
static vv_status find_closed(bool *closed, const vv_mesh_info *mesh, vv_job *job)
{
    uint32_t *place;
    vvi_mesh_edges edges = {0};
    vv_status st = vvi_number_places(&place, mesh->positions, mesh->n_vertices, job);
    if (st == VV_OK)
        st = vvi_mesh_count_edges(&edges, mesh, place, job);
    vvi_free(place);
    *closed = mesh->n_triangles && edges.open == 0 && edges.uneven == 0;
    return st;
}

static vv_status make_mesh(vvi_compact *out, vvi_page_shape_file *file, const making *m)
{
    const vv_mesh_info *mesh = vv_mesh_get_info(m->mesh->mesh);
    vv_mesh *fewer = NULL;
    uint8_t *colors = NULL;
    vv_status st = VV_OK;
    if (vvi_compact_mesh_bytes(mesh->n_vertices, mesh->n_triangles, true) > m->bytes &&
        (st = simplify(&fewer, m)) != VV_OK)
        return st;
    if (fewer)
        mesh = vv_mesh_get_info(fewer);
    vv_mesh_actor shape = *m->mesh;
    if (fewer) { /* vertices have other numbers now */
        shape.colors = NULL;
        shape.parts = NULL;
    }
    st = find_colors(&colors, &shape, mesh, m->job);
    if (st == VV_OK)
        st = find_closed(&file->closed, mesh, m->job);
    if (st == VV_OK)
        st = vvi_compact_mesh(out, mesh, colors, m->job);
    file->n_triangles = mesh->n_triangles;
    vvi_free(colors);
    vv_mesh_release(fewer);
    return st;
}

/* Made once ------------------------------------------------------------------------------------------------------- */

static vv_status make_file(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    making m = *(const making *)user;
    vvi_compact compact = {.n = 0};
    vvi_page_shape_file *file = vvi_calloc(1, sizeof *file);
    m.job = job;
    vv_status st = file ? VV_OK : vv_fail_memory(sizeof *file);
    if (st == VV_OK)
        st = m.mesh             ? make_mesh(&compact, file, &m)
             : m.options->boxes ? make_boxes(&compact, file, &m)
                                : make_reduced(&compact, file, &m);
    if (st == VV_OK)
        st = vvi_shape_file_write(file, &compact, m.options);
    vvi_free(compact.bytes);
    if (st != VV_OK) {
        if (file)
            vvi_shape_file_drop(file);
        return st;
    }
    *value_out = file;
    *bytes_out = sizeof *file + file->n_bytes;
    return VV_OK;
}

static uint64_t hash_of(const making *m)
{
    const vvi_surface_params *p = params_of(m);
    const double numbers[] = {m->value,         m->actor->component,
                              (double)m->bytes, m->upper,
                              p->filter,        (double)(vv_object_is_set(&p->base, "triangles") ? p->triangles : -1)};
    uint64_t hash = vvi_hash(numbers, sizeof numbers, (uint64_t)(uintptr_t)m->options->numbers); /* of this session */
    if (m->mesh) {
        const vv_mesh_info *info = vv_mesh_get_info(m->mesh->mesh);
        const vv_mesh_actor *s = m->mesh;
        const double mesh[] = {
            vv_mesh_checksum(s->mesh), (double)info->n_vertices, (double)info->n_triangles, s->one_color,
            (double)s->look.color[0],  (double)s->look.color[1], (double)s->look.color[2]};
        hash = vvi_hash(mesh, sizeof mesh, hash);
        if (s->colors)
            hash = vvi_hash(s->colors, 4 * info->n_vertices, hash);
        for (size_t i = 0; s->parts && i < info->n_parts; i++)
            hash = vvi_hash(&s->parts[i].color, sizeof s->parts[i].color, hash);
    }
    return hash;
}

/* The file of what is being made, pinned by the shape. */
static vv_status get_file(const vvi_page_shape_file **out, making *m)
{
    const char *what = m->mesh ? "page mesh" : m->options->boxes ? "page boxes" : "page reduced";
    const vvi_cache_key key = {what, m->mesh ? 0 : vv_field_identity(m->actor->field), hash_of(m)};
    vvi_cached **slot = &m->shape->files[m->shape->n];
    const vv_status st = vvi_cache_get(slot, &key, make_file, vvi_shape_file_drop, m, m->job);
    if (st == VV_OK) {
        *out = vvi_cached_value(*slot);
        m->shape->n++;
    }
    return st;
}

/* All of it ------------------------------------------------------------------------------------------------------- */

static vv_status add_side(making *m, double value, bool upper)
{
    const vvi_page_shape_file *file;
    vv_affine place;
    m->value = value;
    m->upper = upper;
    vv_status st = vvi_surface_place(&place, m->actor);
    if (st == VV_OK)
        st = get_file(&file, m);
    if (st == VV_OK)
        vvi_shape_tell_part(&m->shape->text, file, m->actor, m->value, &place);
    return st == VV_OK ? st : vv_fail_in(st, "volumes.%s", m->actor->id);
}

static vv_status add_volume(making *m, const vv_actor *actor)
{
    double lo, hi;
    m->actor = actor;
    m->mesh = NULL;
    if (!vvi_surface_solid(&lo, &hi, m->scene, actor))
        return VV_OK; /* labels: told of in vvi_shape_tell_left_out() */
    vv_status st = add_side(m, lo, false);
    if (st == VV_OK && isfinite(hi))
        st = add_side(m, hi, true);
    return st;
}

static vv_status add_mesh(making *m, const vv_mesh_actor *shape)
{
    const vvi_page_shape_file *file;
    m->actor = &shape->look;
    m->mesh = shape;
    if (!(shape->opacity > 0))
        return VV_OK;
    const vv_status st = get_file(&file, m);
    if (st == VV_OK)
        vvi_shape_tell_part(&m->shape->text, file, m->actor, (double)NAN, &shape->place);
    return st;
}

static vv_status make_all(making *m)
{
    const vv_scene *scene = m->scene;
    const size_t room = 2 * scene->n_actors + scene->n_mesh_actors, shown = scene->n_actors + scene->n_mesh_actors;
    vv_status st = VV_OK;
    m->bytes = m->options->bytes / (shown ? shown : 1);
    m->shape->files = vvi_calloc(room + 1, sizeof(vvi_cached *));
    if (!m->shape->files)
        return vv_fail_memory(room * sizeof(vvi_cached *));
    vvi_result_open(&m->shape->text, "parts", '[');
    for (size_t i = 0; i < scene->n_actors && st == VV_OK; i++)
        st = add_volume(m, &scene->actors[i]);
    for (size_t i = 0; i < scene->n_mesh_actors && st == VV_OK; i++)
        st = add_mesh(m, &scene->mesh_actors[i]);
    vvi_result_close(&m->shape->text, ']');
    if (st == VV_OK && shown && !m->shape->n)
        st =
            vv_fail(VV_E_UNSUPPORTED, "nothing that is shown has a surface that the page could draw: labels have none");
    return st;
}

/* The same World, with the method whose surfaces these are: values and filters are its parameters. */
static vv_status choose_method(vv_world **out, vv_world *world, const char *view, bool boxes)
{
    vv_object *root = vv_object_retain(&world->base);
    char *path = vvi_asprintf("views.%s.render.method", view);
    const vv_status st = path ? vv_path_set(&root, path, boxes ? "boxes" : "reduced", NULL) : vv_fail_memory(64);
    free(path);
    *out = (vv_world *)(void *)root;
    return st;
}

vv_status vvi_page_shape_make(vvi_page_shape *out, vv_world *world, const char *view,
                              const vvi_page_shape_options *options, vv_job *job)
{
    making m = {.options = options, .shape = out, .job = job};
    vv_world *chosen = NULL;
    vv_scene *scene = NULL;
    *out = (vvi_page_shape){.text = {.compact = true}};
    vv_status st = choose_method(&chosen, world, view, options->boxes);
    if (st == VV_OK)
        st = vv_scene_resolve(&scene, chosen, view, job);
    vvi_result_open(&out->text, NULL, '{');
    vvi_result_string(&out->text, "method", options->boxes ? "boxes" : "reduced");
    if (st == VV_OK) {
        m.scene = scene;
        st = make_all(&m);
        vvi_shape_tell_light(&out->text, scene);
        vvi_shape_tell_left_out(&out->text, scene);
    }
    vvi_result_close(&out->text, '}');
    vv_scene_release(scene);
    if (chosen)
        vv_object_release(&chosen->base);
    return st;
}

void vvi_page_shape_finish(vvi_page_shape *shape)
{
    for (size_t i = 0; i < shape->n; i++)
        vvi_cache_release(shape->files[i]);
    free(shape->files);
    vvi_text_free(&shape->text.text);
    *shape = (vvi_page_shape){.n = 0};
}
