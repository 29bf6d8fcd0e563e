/* Writing STL. */
#include "core/job.h"
#include "core/units.h"
#include "io/meshes/mesh_colors.h"
#include "io/meshes/mesh_column.h"
#include "io/meshes/mesh_write.h"
#include "io/meshes/stl.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A triangle's normal, then its corners. */
static void facet_numbers(float out[12], const vv_mesh_info *m, size_t t)
{
    double p[3][3];
    for (size_t i = 0; i < 3; i++) {
        vvi_mesh_place(p[i], m, m->triangles[3 * t + i]);
        for (size_t a = 0; a < 3; a++)
            out[3 + 3 * i + a] = (float)p[i][a];
    }
    double n[3], square = 0;
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        n[a] = (p[1][b] - p[0][b]) * (p[2][c] - p[0][c]) - (p[1][c] - p[0][c]) * (p[2][b] - p[0][b]);
        square += n[a] * n[a];
    }
    for (int a = 0; a < 3; a++)
        out[a] = square > 0 ? (float)(n[a] / sqrt(square)) : 0;
}

static void put_facet(uint8_t *out, const vv_mesh_info *m, size_t t, const vv_mesh_part *part)
{
    float numbers[12];
    uint8_t color[4];
    unsigned bits = 0;
    facet_numbers(numbers, m, t);
    for (int i = 0; i < 12; i++) {
        uint32_t v;
        memcpy(&v, &numbers[i], sizeof v);
        for (int b = 0; b < 4; b++)
            *out++ = (uint8_t)(v >> 8 * b);
    }
    if (vvi_mesh_face_color(color, m, t, part))
        bits = 1u << 15 | (color[0] * 31u + 127) / 255 << 10 | (color[1] * 31u + 127) / 255 << 5 |
               (color[2] * 31u + 127) / 255;
    out[0] = (uint8_t)bits;
    out[1] = (uint8_t)(bits >> 8);
}

static vv_status write_header(vv_sink *sink, const vv_mesh_info *m)
{
    char header[VVI_STL_HEADER + 5] = {0};
    snprintf(header, VVI_STL_HEADER, "VolVis unit=%s%s", m->unit[0] ? m->unit : "units",
             m->up == VV_UP_Y ? " up=y" : "");
    for (int b = 0; b < 4; b++)
        header[VVI_STL_HEADER + b] = (char)(m->n_triangles >> 8 * b);
    return vvi_sink_write(sink, header, VVI_STL_HEADER + 4);
}

static void put_facets(vvi_mesh_text *text, const void *user, size_t first, size_t end)
{
    const vv_mesh_info *m = user;
    size_t part = 0;
    for (size_t t = first; t < end && text->status == VV_OK; t++) {
        uint8_t facet[VVI_STL_FACET];
        put_facet(facet, m, t, vvi_mesh_part_at(m, t, &part));
        vvi_mesh_text_bytes(text, facet, sizeof facet);
    }
}

static vv_status write_binary(vv_sink *sink, const vv_mesh_info *m, vv_job *job)
{
    vvi_mesh_text text;
    vv_status st = write_header(sink, m);
    if (st != VV_OK || (st = vvi_mesh_text_begin(&text, sink, job)) != VV_OK)
        return st;
    vvi_mesh_text_rows(&text, put_facets, m, m->n_triangles);
    return vvi_mesh_text_end(&text);
}

/* Text: a solid for each part. */
static void text_facet(vvi_mesh_text *text, const vv_mesh_info *m, size_t t)
{
    float v[12];
    facet_numbers(v, m, t);
    vvi_mesh_text_add(text, "facet normal");
    for (int i = 0; i < 3; i++)
        vvi_mesh_text_float(text, v[i]);
    vvi_mesh_text_add(text, "\n outer loop\n");
    for (int i = 3; i < 12; i++) {
        if (i % 3 == 0)
            vvi_mesh_text_add(text, "  vertex");
        vvi_mesh_text_float(text, v[i]);
        if (i % 3 == 2)
            vvi_mesh_text_add(text, "\n");
    }
    vvi_mesh_text_add(text, " endloop\nendfacet\n");
}

/* The triangles of one part. */
typedef struct solid_rows {
    const vv_mesh_info *m;
    size_t first;
} solid_rows;

static void text_facets(vvi_mesh_text *text, const void *user, size_t first, size_t end)
{
    const solid_rows *s = user;
    for (size_t t = first; t < end && text->status == VV_OK; t++)
        text_facet(text, s->m, s->first + t);
}

static void text_solid(vvi_mesh_text *text, const vv_mesh_info *m, const char *part, size_t first, size_t n)
{
    char name[64];
    vvi_mesh_line_of(name, part);
    vvi_mesh_text_add(text, "solid ");
    vvi_mesh_text_add(text, name);
    vvi_mesh_text_add(text, "\n");
    vvi_mesh_text_rows(text, text_facets, &(solid_rows){m, first}, n);
    vvi_mesh_text_add(text, "endsolid ");
    vvi_mesh_text_add(text, name);
    vvi_mesh_text_add(text, "\n");
}

static vv_status write_text(vv_sink *sink, const vv_mesh_info *m, vv_job *job)
{
    vvi_mesh_text text;
    const vv_status st = vvi_mesh_text_begin(&text, sink, job);
    if (st != VV_OK)
        return st;
    for (size_t p = 0; p < m->n_parts; p++)
        text_solid(&text, m, m->parts[p].name, m->parts[p].first_triangle, m->parts[p].n_triangles);
    if (m->n_parts == 0)
        text_solid(&text, m, "", 0, m->n_triangles);
    return vvi_mesh_text_end(&text);
}

/* The unit, and which axis points up. */
static void tell_conventions(const vv_sink *sink, const vv_mesh_info *m, bool text, vv_job *job)
{
    const bool has_unit = vvi_length_unit_metres(m->unit) > 0, has_up = m->up == VV_UP_Y;
    if (text && (has_unit || has_up))
        vvi_log(job, VV_LOG_WARNING, "io",
                "%s: STL as text does not store that %s%s%s%s; tell whoever reads it, VolVis by %s%s%s",
                vvi_sink_name(sink), has_unit ? "lengths are in " : "", has_unit ? m->unit : "",
                has_unit && has_up ? ", nor that " : "", has_up ? "y points up" : "", has_unit ? "--input-unit" : "",
                has_unit && has_up ? " and " : "", has_up ? "--set up=y" : "");
    if (!text && has_unit && strcmp(m->unit, "mm") != 0)
        vvi_log(job, VV_LOG_WARNING, "io",
                "%s: other programs take the lengths of STL for mm, and these are in %s; --unit mm converts them",
                vvi_sink_name(sink), m->unit);
}

vv_status vvi_stl_write(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    const bool text = strcmp(options->encoding, "ascii") == 0;
    if (text && (m->colors || vvi_mesh_has_part_colors(m)))
        vvi_log(job, VV_LOG_WARNING, "io", "%s: STL as text cannot hold colours; they are left out",
                vvi_sink_name(sink));
    tell_conventions(sink, m, text, job);
    bool named = false;
    for (size_t p = 0; p < m->n_parts; p++)
        named = named || m->parts[p].name[0];
    if (!text && named)
        vvi_log(job, VV_LOG_WARNING, "io", "%s: binary STL cannot hold part names; --encoding ascii keeps them",
                vvi_sink_name(sink));
    if (!text && (m->colors || vvi_mesh_has_part_colors(m)))
        vvi_log(job, VV_LOG_INFO, "io", "%s: STL keeps triangle colours in 15 bits", vvi_sink_name(sink));
    return text ? write_text(sink, m, job) : write_binary(sink, m, job);
}
