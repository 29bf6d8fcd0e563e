/* Writing OBJ, and its materials in a second file. */
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/meshes/mesh_colors.h"
#include "io/meshes/mesh_texture.h"
#include "io/meshes/mesh_write.h"
#include "io/meshes/obj.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* "folder/a.obj" and "a.obj.gz" -> "a.mtl"; blanks would end the name for some readers. */
static char *library_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *name = vvi_asprintf("%s.mtl", slash ? slash + 1 : path);
    if (!name)
        return NULL;
    for (char *at = name; *at; at++) {
        if (strncasecmp(at, ".obj", 4) == 0 && (at[4] == '.')) {
            strcpy(at, ".mtl");
            break;
        }
    }
    return name;
}

static bool has_texture(const vv_mesh_info *m, size_t part)
{
    return m->parts[part].texture && m->coordinates;
}

static bool has_material(const vv_mesh_info *m, size_t part)
{
    return m->parts[part].color.a >= 0 || has_texture(m, part);
}

static bool has_translucent(const vv_mesh_texture *t)
{
    bool some = false;
    for (size_t i = 0; i < (size_t)t->width * (size_t)t->height && !some; i++)
        some = t->pixels[4 * i + 3] < 255;
    return some;
}

static vv_status write_map(vv_sink *sink, const vv_sink *obj, const vv_mesh_info *m, size_t texture)
{
    const vv_mesh_texture *t = &m->textures[texture];
    char *name = vvi_mesh_texture_name(obj, texture);
    if (!name)
        return vv_fail_memory(64);
    const char *clamp = t->wrap[0] == VV_WRAP_CLAMP && t->wrap[1] == VV_WRAP_CLAMP ? "-clamp on " : "";
    vv_status st = vvi_sink_printf(sink, "map_Kd %s%s\n", clamp, name);
    if (st == VV_OK && has_translucent(t))
        st = vvi_sink_printf(sink, "map_d %s%s\n", clamp, name);
    free(name);
    return st;
}

/* Kd as sRGB, as other programs show it. */
static vv_status write_materials(vv_sink *sink, const vv_sink *obj, const vv_mesh_info *m)
{
    vv_status st = vvi_sink_printf(sink, "# written by VolVis\n");
    for (size_t i = 0; i < m->n_parts && st == VV_OK; i++) {
        uint8_t bytes[4];
        char number[4][32];
        const vv_color white = {1, 1, 1, 1}, *color = m->parts[i].color.a < 0 ? &white : &m->parts[i].color;
        if (!has_material(m, i))
            continue;
        vvi_mesh_bytes_of(bytes, color);
        for (int c = 0; c < 3; c++)
            vvi_print_number(number[c], (float)bytes[c] / 255.0F);
        vvi_print_number(number[3], color->a);
        st =
            vvi_sink_printf(sink, "newmtl part%zu\nKd %s %s %s\nd %s\n", i, number[0], number[1], number[2], number[3]);
        if (st == VV_OK && has_texture(m, i))
            st = write_map(sink, obj, m, m->parts[i].texture - 1);
    }
    return st;
}

/* *named: the header names the library. */
static vv_status write_library(vv_sink *sink, const vv_mesh_info *m, bool *named, vv_job *job)
{
    vv_sink *library = NULL; /* belongs to `sink` */
    *named = false;
    bool some = false;
    for (size_t i = 0; i < m->n_parts; i++)
        some |= has_material(m, i);
    if (!some)
        return VV_OK;
    if (strcmp(vvi_sink_name(sink), "standard output") == 0) {
        vvi_log(
            job, VV_LOG_WARNING, "io",
            "OBJ keeps part colours and images in other files, which standard output has no place for; they are left "
            "out");
        return VV_OK;
    }
    char *name = library_name(vvi_sink_name(sink));
    if (!name)
        return vv_fail_memory(strlen(vvi_sink_name(sink)));
    vv_status st = vvi_sink_beside_on_line(&library, sink, name);
    if (st == VV_OK && (st = write_materials(library, sink, m)) == VV_OK)
        st = vvi_sink_printf(sink, "mtllib %s\n", name);
    if (m->coordinates)
        vvi_mesh_texture_warn(sink, m, true, "OBJ", job);
    for (size_t i = 0; i < m->n_textures && st == VV_OK && m->coordinates; i++)
        st = vvi_mesh_texture_write(sink, m, i, job);
    *named = st == VV_OK;
    free(name);
    return st;
}

static void add_part(vvi_mesh_text *t, const vv_mesh_info *m, size_t part, bool named)
{
    char name[sizeof m->parts->name];
    vvi_mesh_line_of(name, m->parts[part].name);
    vvi_mesh_text_add(t, "o ");
    vvi_mesh_text_add(t, name);
    vvi_mesh_text_add(t, "\n");
    if (!named || !has_material(m, part))
        return;
    vvi_mesh_text_add(t, "usemtl part");
    t->in_line = false;
    vvi_mesh_text_uint(t, part);
    vvi_mesh_text_add(t, "\n");
}

static void add_vertex(vvi_mesh_text *t, const vv_mesh_info *m, size_t i, bool doubles)
{
    vvi_mesh_text_add(t, "v");
    vvi_mesh_text_place(t, m, i, doubles);
    for (size_t c = 0; c < 3 && m->colors; c++)
        vvi_mesh_text_float(t, (float)m->colors[4 * i + c] / 255);
    vvi_mesh_text_add(t, "\n");
}

static void add_face(vvi_mesh_text *t, const vv_mesh_info *m, size_t i)
{
    vvi_mesh_text_add(t, "f");
    for (size_t k = 0; k < 3; k++) {
        const uint64_t v = (uint64_t)m->triangles[3 * i + k] + 1;
        vvi_mesh_text_uint(t, v);
        if (m->coordinates || m->normals) {
            vvi_mesh_text_add(t, "/");
            t->in_line = false;
        }
        if (m->coordinates)
            vvi_mesh_text_uint(t, (uint64_t)(m->coordinate_of ? m->coordinate_of : m->triangles)[3 * i + k] + 1);
        if (!m->normals)
            continue;
        vvi_mesh_text_add(t, "/");
        t->in_line = false;
        vvi_mesh_text_uint(t, v);
    }
    vvi_mesh_text_add(t, "\n");
}

typedef struct obj_rows {
    const vv_mesh_info *m;
    bool doubles, named;
} obj_rows;

static void add_vertices(vvi_mesh_text *t, const void *user, size_t first, size_t end)
{
    const obj_rows *o = user;
    for (size_t i = first; i < end && t->status == VV_OK; i++)
        add_vertex(t, o->m, i, o->doubles);
}

static void add_normals(vvi_mesh_text *t, const void *user, size_t first, size_t end)
{
    const vv_mesh_info *m = ((const obj_rows *)user)->m;
    for (size_t i = first; i < end && t->status == VV_OK; i++) {
        vvi_mesh_text_add(t, "vn");
        for (size_t a = 0; a < 3; a++)
            vvi_mesh_text_float(t, m->normals[3 * i + a]);
        vvi_mesh_text_add(t, "\n");
    }
}

static void add_coordinates(vvi_mesh_text *t, const void *user, size_t first, size_t end)
{
    const vv_mesh_info *m = ((const obj_rows *)user)->m;
    for (size_t i = first; i < end && t->status == VV_OK; i++) {
        vvi_mesh_text_add(t, "vt");
        vvi_mesh_text_float(t, m->coordinates[2 * i]);
        vvi_mesh_text_float(t, m->coordinates[2 * i + 1]);
        vvi_mesh_text_add(t, "\n");
    }
}

static void add_faces(vvi_mesh_text *t, const void *user, size_t first, size_t end)
{
    const obj_rows *o = user;
    const vv_mesh_info *m = o->m;
    size_t part = 0;
    while (part < m->n_parts && m->parts[part].first_triangle < first)
        part++;
    for (size_t i = first; i < end && t->status == VV_OK; i++) {
        for (; part < m->n_parts && m->parts[part].first_triangle <= i; part++)
            if (m->parts[part].n_triangles)
                add_part(t, m, part, o->named);
        add_face(t, m, i);
    }
}

static vv_status write_lines(vv_sink *sink, const vv_mesh *mesh, bool named, vv_job *job)
{
    const obj_rows rows = {vv_mesh_get_info(mesh), vvi_mesh_needs_doubles(mesh), named};
    vvi_mesh_text t;
    const vv_status st = vvi_mesh_text_begin(&t, sink, job);
    if (st != VV_OK)
        return st;
    vvi_mesh_text_rows(&t, add_vertices, &rows, rows.m->n_vertices);
    if (rows.m->normals)
        vvi_mesh_text_rows(&t, add_normals, &rows, rows.m->n_vertices);
    if (rows.m->coordinates)
        vvi_mesh_text_rows(&t, add_coordinates, &rows, rows.m->n_coordinates);
    vvi_mesh_text_rows(&t, add_faces, &rows, rows.m->n_triangles);
    return vvi_mesh_text_end(&t);
}

vv_status vvi_obj_write(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    bool named = false;
    (void)options;
    vv_status st = vvi_sink_printf(sink, "# written by VolVis\n");
    if (st == VV_OK && m->unit[0])
        st = vvi_sink_printf(sink, "# unit: %s\n", m->unit);
    if (st == VV_OK && m->space == VV_SPACE_RAS)
        st = vvi_sink_printf(sink, "# space: RAS\n");
    if (st == VV_OK && m->up == VV_UP_Y)
        st = vvi_sink_printf(sink, "# up: y\n");
    if (st == VV_OK && (st = write_library(sink, m, &named, job)) == VV_OK)
        st = write_lines(sink, mesh, named, job);
    return st;
}
