#include "server/shape.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "grid/field.h"
#include "grid/probe.h"
#include "render/surface/surface.h"
#include "server/memory_file.h"
#include "surface/boxes.h"
#include "surface/compact.h"
#include "surface/reduced.h"
#include "surface/simplify.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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
    const vv_shape *mesh; /* NULL: of a volume */
    double value;
    bool upper;
} making;

/* Files ----------------------------------------------------------------------------------------------------------- */

static void drop_file(void *value)
{
    vvi_page_shape_file *file = value;
    if (file->path)
        unlink(file->path);
    if (file->fd > 0)
        close(file->fd);
    free(file->path);
    free(file->name);
    free(file);
}

static vv_status write_all(int fd, const uint8_t *bytes, size_t n, const char *path)
{
    while (n > 0) {
        const ssize_t done = write(fd, bytes, n);
        if (done < 0 && errno != EINTR)
            return vv_fail_at(VV_E_WRITE, path, NULL, "cannot be written: %s", strerror(errno));
        bytes += done > 0 ? done : 0;
        n -= done > 0 ? (size_t)done : 0;
    }
    return VV_OK;
}

static vv_status write_file(vvi_page_shape_file *file, const vvi_compact *compact, const vvi_page_shape_options *o)
{
    file->number = ++*o->numbers;
    file->n_bytes = compact->n;
    file->name = vvi_asprintf("shape-%" PRId64 ".vvs", file->number);
    if (file->name && !o->folder)
        return vvi_memory_file_new(&file->fd, compact->bytes, compact->n);
    file->path = file->name ? vvi_asprintf("%s/%s", o->folder, file->name) : NULL;
    if (!file->path)
        return vv_fail_memory(256);
    const int fd = open(file->path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (fd < 0)
        return vv_fail_at(VV_E_WRITE, file->path, NULL, "cannot be written: %s", strerror(errno));
    const vv_status st = write_all(fd, compact->bytes, compact->n, file->path);
    close(fd);
    return st;
}

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

/* Those of values, of the mesh itself or of its parts; NULL, and VV_OK: it has one colour. */
static vv_status find_colors(uint8_t **out, const vv_shape *shape, const vv_mesh_info *mesh, vv_job *job)
{
    const uint8_t *given = shape->colors ? shape->colors : mesh->colors;
    const vv_mesh_part *parts = shape->parts ? shape->parts : mesh->parts;
    const vv_vec3 own = {(double)shape->look.color[0], (double)shape->look.color[1], (double)shape->look.color[2]};
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
        const double rgb[3] = {c->a < 0 ? own.x : c->r, c->a < 0 ? own.y : c->g, c->a < 0 ? own.z : c->b};
        uint8_t bytes[4] = {0, 0, 0, 255};
        for (int k = 0; k < 3; k++)
            bytes[k] = (uint8_t)lround(255 * vv_srgb_encode(fmin(fmax(rgb[k], 0), 1)));
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
    vv_shape shape = *m->mesh;
    if (fewer) { /* vertices have other numbers now */
        shape.colors = NULL;
        shape.parts = NULL;
    }
    st = find_colors(&colors, &shape, mesh, m->job);
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
        st = write_file(file, &compact, m.options);
    vvi_free(compact.bytes);
    if (st != VV_OK) {
        if (file)
            drop_file(file);
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
        const vv_shape *s = m->mesh;
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
    const vv_status st = vvi_cache_get(slot, &key, make_file, drop_file, m, m->job);
    if (st == VV_OK) {
        *out = vvi_cached_value(*slot);
        m->shape->n++;
    }
    return st;
}

/* What is told of it ---------------------------------------------------------------------------------------------- */

static void tell_vector(vvi_result *out, const char *key, vv_vec3 v)
{
    vvi_result_numbers(out, key, (double[3]){v.x, v.y, v.z}, 3);
}

static void tell_floats(vvi_result *out, const char *key, const float *values, size_t n)
{
    double numbers[4];
    for (size_t i = 0; i < n; i++)
        numbers[i] = (double)values[i];
    vvi_result_numbers(out, key, numbers, n);
}

static void tell_look(vvi_result *out, const vv_actor *a, const vv_affine *place)
{
    static const char *const models[] = {"none", "phong", "blinn"};
    const vv_vec3 columns[4] = {place->axis[0], place->axis[1], place->axis[2], place->origin};
    double numbers[12];
    for (size_t i = 0; i < 12; i++)
        numbers[i] = (&columns[i / 3].x)[i % 3];
    vvi_result_numbers(out, "place", numbers, 12);
    tell_floats(out, "color", a->color, 3);
    vvi_result_string(out, "shading", models[a->shading_model]);
    tell_floats(out, "light", (float[4]){a->ambient, a->diffuse, a->specular, a->shininess}, 4);
    vvi_result_open(out, "planes", '[');
    for (size_t i = 0; i < a->n_planes; i++) {
        const vv_plane *p = &a->planes[i];
        vvi_result_numbers(out, NULL, (double[4]){p->normal.x, p->normal.y, p->normal.z, p->offset}, 4);
    }
    vvi_result_close(out, ']');
}

static void tell_part(making *m, const vvi_page_shape_file *file, const vv_affine *place)
{
    vvi_result *out = &m->shape->text;
    char url[128];
    snprintf(url, sizeof url, "/files/%" PRId64 "/%.64s", file->number, file->name);
    vvi_result_open(out, NULL, '{');
    vvi_result_string(out, "volume", m->actor->id);
    vvi_result_string(out, "url", url);
    vvi_result_unsigned(out, "bytes", file->n_bytes);
    vvi_result_unsigned(out, "triangles", file->n_triangles);
    vvi_result_numbers(out, "step", (double[3]){file->step[0], file->step[1], file->step[2]}, 3);
    vvi_result_number(out, "value", m->mesh ? (double)NAN : m->value);
    vvi_result_bool(out, "solid", !m->mesh);
    tell_look(out, m->actor, place);
    vvi_result_close(out, '}');
}

static bool is_on_camera(const vv_scene *scene, size_t lamp)
{
    const vv_collection *lights = scene->world->lights;
    size_t n = 0;
    for (size_t i = 0; i < lights->n; i++) {
        const vv_light *light = (const vv_light *)(const void *)lights->entry[i].object;
        if (light->on && light->kind != VV_LIGHT_AMBIENT && n++ == lamp)
            return light->frame == VV_LIGHT_ON_CAMERA;
    }
    return true; /* where there are none, those of the camera shine */
}

/* Camera axes: x right, y up, z towards the viewer. */
static vv_vec3 to_camera(const vv_lens *lens, vv_vec3 v)
{
    return vvi_vec(vvi_dot(v, lens->right), vvi_dot(v, lens->up), -vvi_dot(v, lens->forward));
}

static void tell_lamp(vvi_result *out, const vv_scene *scene, size_t i)
{
    static const char *const kinds[] = {
        [VV_LIGHT_DIRECTIONAL] = "directional", [VV_LIGHT_POINT] = "point", [VV_LIGHT_SPOT] = "spot"};
    const vv_lamp *lamp = &scene->lamps[i];
    const vv_lens *lens = &scene->lens;
    const bool camera = is_on_camera(scene, i);
    vvi_result_open(out, NULL, '{');
    vvi_result_string(out, "kind", kinds[lamp->kind]);
    vvi_result_string(out, "frame", camera ? "camera" : "world");
    tell_floats(out, "color", lamp->color, 3);
    tell_vector(out, "position", camera ? to_camera(lens, vvi_sub(lamp->position, lens->eye)) : lamp->position);
    tell_vector(out, "direction", camera ? to_camera(lens, lamp->direction) : lamp->direction);
    vvi_result_numbers(out, "cone", (double[2]){lamp->cos_outer, lamp->cos_inner}, 2);
    tell_vector(out, "falloff", lamp->falloff);
    vvi_result_close(out, '}');
}

static void tell_light(vvi_result *out, const vv_scene *scene)
{
    vvi_result_open(out, "lights", '[');
    for (size_t i = 0; i < scene->n_lamps; i++)
        tell_lamp(out, scene, i);
    vvi_result_close(out, ']');
    tell_floats(out, "ambient", scene->ambient, 3);
    tell_floats(out, "background", scene->background, 4);
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
        tell_part(m, file, &place);
    return st == VV_OK ? st : vv_fail_in(st, "volumes.%s", m->actor->id);
}

static vv_status add_volume(making *m, const vv_actor *actor)
{
    double lo, hi;
    m->actor = actor;
    m->mesh = NULL;
    if (!vvi_surface_solid(&lo, &hi, m->scene, actor))
        return VV_OK; /* labels: told of in tell_left_out() */
    vv_status st = add_side(m, lo, false);
    if (st == VV_OK && isfinite(hi))
        st = add_side(m, hi, true);
    return st;
}

static vv_status add_mesh(making *m, const vv_shape *shape)
{
    const vvi_page_shape_file *file;
    m->actor = &shape->look;
    m->mesh = shape;
    if (!(shape->opacity > 0))
        return VV_OK;
    const vv_status st = get_file(&file, m);
    if (st == VV_OK)
        tell_part(m, file, &shape->place);
    return st;
}

static void tell_left_out(vvi_result *out, const vv_scene *scene)
{
    vvi_result_open(out, "left_out", '[');
    for (size_t i = 0; i < scene->n_actors; i++) {
        char text[160];
        if (scene->actors[i].classes.kind != VV_SEGMENT_LABELS)
            continue;
        snprintf(text, sizeof text, "%.64s has labels, and so no value whose surface the page could draw.",
                 scene->actors[i].id);
        vvi_result_string(out, NULL, text);
    }
    vvi_result_close(out, ']');
}

static vv_status make_all(making *m)
{
    const vv_scene *scene = m->scene;
    const size_t room = 2 * scene->n_actors + scene->n_shapes, shown = scene->n_actors + scene->n_shapes;
    vv_status st = VV_OK;
    m->bytes = m->options->bytes / (shown ? shown : 1);
    m->shape->files = vvi_calloc(room + 1, sizeof(vvi_cached *));
    if (!m->shape->files)
        return vv_fail_memory(room * sizeof(vvi_cached *));
    vvi_result_open(&m->shape->text, "parts", '[');
    for (size_t i = 0; i < scene->n_actors && st == VV_OK; i++)
        st = add_volume(m, &scene->actors[i]);
    for (size_t i = 0; i < scene->n_shapes && st == VV_OK; i++)
        st = add_mesh(m, &scene->shapes[i]);
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
        tell_light(&out->text, scene);
        tell_left_out(&out->text, scene);
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
