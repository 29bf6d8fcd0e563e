/* Writing PLY. */
#include "core/job.h"
#include "core/memory.h"
#include "io/meshes/mesh_colors.h"
#include "io/meshes/mesh_column.h"
#include "io/meshes/mesh_texture.h"
#include "io/meshes/mesh_write.h"
#include "io/meshes/ply.h"

#include <stdlib.h>
#include <string.h>

enum { BLOCK = VVI_COLUMN_MOST, RECORD_MOST = 64 };

typedef struct writer {
    vv_sink *sink;
    const vv_mesh_info *mesh;
    bool ascii, swapped, doubles, parted, face_colors;
    bool numbered; /* faces say which image they have */
    vv_job *job;
} writer;

static vv_status write_header(const writer *w, const char *encoding)
{
    const vv_mesh_info *m = w->mesh;
    const char *format = w->ascii                              ? "ascii"
                         : strcmp(encoding, "big-endian") == 0 ? "binary_big_endian"
                                                               : "binary_little_endian";
    const char *real = w->doubles ? "double" : "float";
    vv_status st = vvi_sink_printf(w->sink, "ply\nformat %s 1.0\ncomment made by VolVis\n", format);
    if (st == VV_OK && m->unit[0])
        st = vvi_sink_printf(w->sink, "comment unit: %s\n", m->unit);
    if (st == VV_OK && m->space == VV_SPACE_RAS)
        st = vvi_sink_printf(w->sink, "comment space: RAS\n");
    if (st == VV_OK && m->up == VV_UP_Y)
        st = vvi_sink_printf(w->sink, "comment up: y\n");
    if (st == VV_OK && m->values && m->value_name[0])
        st = vvi_sink_printf(w->sink, "comment value_name: %s\n", m->value_name);
    if (st == VV_OK && m->values && m->value_unit[0])
        st = vvi_sink_printf(w->sink, "comment value_unit: %s\n", m->value_unit);
    for (size_t i = 0; i < m->n_parts && st == VV_OK; i++) {
        char name[sizeof m->parts->name];
        vvi_mesh_line_of(name, m->parts[i].name);
        st = vvi_sink_printf(w->sink, "comment part: %s\n", name);
    }
    for (size_t i = 0; w->numbered && i < m->n_textures && st == VV_OK; i++) {
        char *name = vvi_mesh_texture_name(w->sink, i);
        st = name ? vvi_sink_printf(w->sink, "comment TextureFile %s\n", name) : vv_fail_memory(64);
        free(name);
    }
    if (st == VV_OK)
        st = vvi_sink_printf(w->sink, "element vertex %zu\nproperty %s x\nproperty %s y\nproperty %s z\n",
                             m->n_vertices, real, real, real);
    if (st == VV_OK && m->normals)
        st = vvi_sink_printf(w->sink, "property float nx\nproperty float ny\nproperty float nz\n");
    if (st == VV_OK && m->values)
        st = vvi_sink_printf(w->sink, "property float quality\n");
    if (st == VV_OK && m->colors)
        st = vvi_sink_printf(w->sink, "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                                      "property uchar alpha\n");
    if (st == VV_OK && m->coordinates && !m->coordinate_of)
        st = vvi_sink_printf(w->sink, "property float s\nproperty float t\n");
    if (st == VV_OK)
        st = vvi_sink_printf(w->sink, "element face %zu\nproperty list uchar int vertex_indices\n", m->n_triangles);
    if (st == VV_OK && w->face_colors)
        st = vvi_sink_printf(w->sink, "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                                      "property uchar alpha\n");
    if (st == VV_OK && m->coordinate_of)
        st = vvi_sink_printf(w->sink, "property list uchar float texcoord\n");
    if (st == VV_OK && w->numbered)
        st = vvi_sink_printf(w->sink, "property int texnumber\n");
    if (st == VV_OK && w->parted)
        st = vvi_sink_printf(w->sink, "property int part\n");
    return st == VV_OK ? vvi_sink_printf(w->sink, "end_header\n") : st;
}

/* Binary ---------------------------------------------------------------------------------------------------------- */

static uint8_t *put(uint8_t *out, const void *value, size_t bytes, bool swapped)
{
    const uint8_t *in = value;
    for (size_t i = 0; i < bytes; i++)
        out[i] = in[swapped ? bytes - 1 - i : i];
    return out + bytes;
}

static uint8_t *put_floats(uint8_t *out, const float *v, size_t n, bool swapped)
{
    if (!swapped)
        memcpy(out, v, n * sizeof *v);
    for (size_t i = 0; i < n && swapped; i++)
        put(out + i * sizeof *v, v + i, sizeof *v, true);
    return out + n * sizeof *v;
}

static uint8_t *put_vertex(uint8_t *out, const writer *w, size_t i)
{
    const vv_mesh_info *m = w->mesh;
    double p[3];
    vvi_mesh_place(p, m, i);
    const float single[3] = {(float)p[0], (float)p[1], (float)p[2]};
    if (!w->doubles)
        out = put_floats(out, single, 3, w->swapped);
    for (int a = 0; a < 3 && w->doubles; a++)
        out = put(out, &p[a], sizeof p[a], w->swapped);
    if (m->normals)
        out = put_floats(out, m->normals + 3 * i, 3, w->swapped);
    if (m->values)
        out = put_floats(out, m->values + i, 1, w->swapped);
    if (m->colors) {
        memcpy(out, m->colors + 4 * i, 4);
        out += 4;
    }
    return m->coordinates && !m->coordinate_of ? put_floats(out, m->coordinates + 2 * i, 2, w->swapped) : out;
}

static const float *place_of(const vv_mesh_info *m, size_t t, size_t corner)
{
    return m->coordinates + 2 * (size_t)m->coordinate_of[3 * t + corner];
}

static int32_t texture_of(const vv_mesh_part *part)
{
    return part ? (int32_t)part->texture - 1 : -1;
}

static uint8_t *put_face(uint8_t *out, const writer *w, size_t t, size_t *part)
{
    const uint32_t *v = w->mesh->triangles + 3 * t;
    *out++ = 3;
    if (!w->swapped)
        memcpy(out, v, 12);
    for (int i = 0; i < 3 && w->swapped; i++)
        put(out + 4 * i, v + i, 4, true);
    out += 12;
    const vv_mesh_part *p = vvi_mesh_part_at(w->mesh, t, part);
    uint8_t color[4] = {255, 255, 255, 255};
    if (p && p->color.a >= 0)
        vvi_mesh_bytes_of(color, &p->color);
    if (w->face_colors)
        out = put(out, color, 4, false);
    if (w->mesh->coordinate_of)
        *out++ = 6;
    for (size_t i = 0; i < 3 && w->mesh->coordinate_of; i++)
        out = put_floats(out, place_of(w->mesh, t, i), 2, w->swapped);
    const int32_t number = (int32_t)*part, texture = texture_of(p);
    if (w->numbered)
        out = put(out, &texture, 4, w->swapped);
    return w->parted ? put(out, &number, 4, w->swapped) : out;
}

static vv_status write_binary(const writer *w)
{
    const vv_mesh_info *m = w->mesh;
    uint8_t *room = vvi_alloc(w->job, (size_t)BLOCK * RECORD_MOST, VVI_MEM_SCRATCH), *end = room;
    vv_status st = room ? VV_OK : vv_fail_memory((size_t)BLOCK * RECORD_MOST);
    size_t part = 0;
    for (size_t i = 0; i < m->n_vertices + m->n_triangles && st == VV_OK; i++) {
        end = i < m->n_vertices ? put_vertex(end, w, i) : put_face(end, w, i - m->n_vertices, &part);
        if ((i + 1) % BLOCK != 0 && i + 1 < m->n_vertices + m->n_triangles)
            continue;
        if ((st = vvi_sink_write(w->sink, room, (size_t)(end - room))) == VV_OK)
            st = vvi_job_progress(w->job, "write", i + 1, m->n_vertices + m->n_triangles);
        end = room;
    }
    vvi_free(room);
    return st;
}

/* Text ------------------------------------------------------------------------------------------------------------ */

static void text_vertex(vvi_mesh_text *t, const writer *w, size_t i)
{
    const vv_mesh_info *m = w->mesh;
    vvi_mesh_text_place(t, m, i, w->doubles);
    for (size_t a = 0; a < 3 && m->normals; a++)
        vvi_mesh_text_float(t, m->normals[3 * i + a]);
    if (m->values)
        vvi_mesh_text_float(t, m->values[i]);
    for (size_t c = 0; c < 4 && m->colors; c++)
        vvi_mesh_text_uint(t, m->colors[4 * i + c]);
    for (size_t c = 0; c < 2 && m->coordinates && !m->coordinate_of; c++)
        vvi_mesh_text_float(t, m->coordinates[2 * i + c]);
    vvi_mesh_text_add(t, "\n");
}

static void text_face(vvi_mesh_text *t, const writer *w, size_t i, size_t *part)
{
    vvi_mesh_text_add(t, "3");
    for (size_t k = 0; k < 3; k++)
        vvi_mesh_text_uint(t, w->mesh->triangles[3 * i + k]);
    const vv_mesh_part *p = vvi_mesh_part_at(w->mesh, i, part);
    uint8_t color[4] = {255, 255, 255, 255};
    if (p && p->color.a >= 0)
        vvi_mesh_bytes_of(color, &p->color);
    for (int c = 0; c < 4 && w->face_colors; c++)
        vvi_mesh_text_uint(t, color[c]);
    if (w->mesh->coordinate_of)
        vvi_mesh_text_add(t, " 6");
    for (size_t c = 0; c < 6 && w->mesh->coordinate_of; c++)
        vvi_mesh_text_float(t, place_of(w->mesh, i, c / 2)[c % 2]);
    if (w->numbered)
        vvi_mesh_text_double(t, texture_of(p));
    if (w->parted)
        vvi_mesh_text_uint(t, *part);
    vvi_mesh_text_add(t, "\n");
}

static void text_vertices(vvi_mesh_text *t, const void *user, size_t first, size_t end)
{
    for (size_t i = first; i < end && t->status == VV_OK; i++)
        text_vertex(t, user, i);
}

static void text_faces(vvi_mesh_text *t, const void *user, size_t first, size_t end)
{
    size_t part = 0;
    for (size_t i = first; i < end && t->status == VV_OK; i++)
        text_face(t, user, i, &part);
}

static vv_status write_text(const writer *w)
{
    vvi_mesh_text t;
    const vv_status st = vvi_mesh_text_begin(&t, w->sink, w->job);
    if (st != VV_OK)
        return st;
    vvi_mesh_text_rows(&t, text_vertices, w, w->mesh->n_vertices);
    vvi_mesh_text_rows(&t, text_faces, w, w->mesh->n_triangles);
    return vvi_mesh_text_end(&t);
}

vv_status vvi_ply_write(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    const bool alone = strcmp(vvi_sink_name(sink), "standard output") == 0;
    if (alone && m->n_textures)
        vvi_log(job, VV_LOG_WARNING, "io",
                "PLY keeps images in other files, which standard output has no place for; they are left out");
    const writer w = {
        .sink = sink,
        .mesh = m,
        .ascii = strcmp(options->encoding, "ascii") == 0,
        .swapped = (strcmp(options->encoding, "big-endian") == 0) != vvi_machine_is_big(),
        .doubles = vvi_mesh_needs_doubles(mesh),
        .parted = m->n_parts > 0,
        .face_colors = vvi_mesh_has_part_colors(m),
        .numbered = m->n_textures && m->coordinates && !alone,
        .job = job,
    };
    if (w.numbered)
        vvi_mesh_texture_warn(sink, m, false, "PLY", job);
    vv_status st = write_header(&w, options->encoding);
    for (size_t i = 0; i < m->n_textures && w.numbered && st == VV_OK; i++)
        st = vvi_mesh_texture_write(sink, m, i, job);
    if (st != VV_OK)
        return st;
    return w.ascii ? write_text(&w) : write_binary(&w);
}
