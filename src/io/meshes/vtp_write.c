/* Writing VTK's XML polygons: one piece; numbers as text, as base64, or appended raw. */
#include "core/job.h"
#include "core/text.h"
#include "io/base64.h"
#include "io/meshes/mesh_colors.h"
#include "io/meshes/mesh_column.h"
#include "io/meshes/mesh_write.h"
#include "io/meshes/vtp.h"
#include "io/numbers.h"

#include <stdio.h>
#include <string.h>

enum { BLOCK = 1024, ARRAYS_MOST = 8 };

typedef struct writer writer;

/* Numbers of the mesh, a few at a time. */
typedef struct array {
    const char *name;
    vv_type type;
    size_t components, n; /* records */
    void (*fill)(const writer *w, void *out, size_t first, size_t n);
    uint64_t offset; /* where it is appended */
} array;

struct writer {
    vv_sink *sink;
    const vv_mesh_info *m;
    bool ascii, base64, doubles;
    vv_type index_type;
    array list[ARRAYS_MOST];
    size_t n;
    vvi_base64 coder;
    vv_job *job;
};

/* What the arrays have ----------------------------------------------------------------------------------------------
 */

static void fill_places(const writer *w, void *out, size_t first, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        double p[3];
        vvi_mesh_place(p, w->m, first + i);
        for (size_t a = 0; a < 3; a++) {
            if (w->doubles)
                ((double *)out)[3 * i + a] = p[a];
            else
                ((float *)out)[3 * i + a] = (float)p[a];
        }
    }
}

static void fill_normals(const writer *w, void *out, size_t first, size_t n)
{
    memcpy(out, w->m->normals + 3 * first, 3 * n * sizeof(float));
}

static void fill_values(const writer *w, void *out, size_t first, size_t n)
{
    memcpy(out, w->m->values + first, n * sizeof(float));
}

static void fill_colors(const writer *w, void *out, size_t first, size_t n)
{
    memcpy(out, w->m->colors + 4 * first, 4 * n);
}

static void put_index(const writer *w, void *out, size_t at, uint64_t v)
{
    if (w->index_type == VV_TYPE_I32)
        ((int32_t *)out)[at] = (int32_t)v;
    else
        ((int64_t *)out)[at] = (int64_t)v;
}

static void fill_corners(const writer *w, void *out, size_t first, size_t n)
{
    for (size_t i = 0; i < n; i++)
        put_index(w, out, i, w->m->triangles[first + i]);
}

static void fill_ends(const writer *w, void *out, size_t first, size_t n)
{
    for (size_t i = 0; i < n; i++)
        put_index(w, out, i, 3 * ((uint64_t)first + i + 1));
}

static size_t part_of(const vv_mesh_info *m, size_t triangle)
{
    size_t lo = 0, hi = m->n_parts;
    while (hi - lo > 1) {
        const size_t middle = (lo + hi) / 2;
        *(m->parts[middle].first_triangle <= triangle ? &lo : &hi) = middle;
    }
    return lo;
}

static void fill_parts(const writer *w, void *out, size_t first, size_t n)
{
    for (size_t i = 0; i < n; i++)
        ((int32_t *)out)[i] = (int32_t)part_of(w->m, first + i);
}

static void fill_part_colors(const writer *w, void *out, size_t first, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const vv_mesh_part *part = &w->m->parts[part_of(w->m, first + i)];
        uint8_t bytes[4] = {255, 255, 255, 255};
        if (part->color.a >= 0)
            vvi_mesh_bytes_of(bytes, &part->color);
        memcpy((uint8_t *)out + 3 * i, bytes, 3);
    }
}

/* Numbers -----------------------------------------------------------------------------------------------------------
 */

static vv_status put_bytes(writer *w, const void *in, size_t n)
{
    return w->base64 ? vvi_base64_write(&w->coder, w->sink, in, n) : vvi_sink_write(w->sink, in, n);
}

static vv_status put_text(const writer *w, const array *a, const uint8_t *block, size_t n)
{
    const size_t bytes = vv_type_bytes(a->type);
    vv_status st = VV_OK;
    for (size_t i = 0; i < n * a->components && st == VV_OK; i++) {
        char number[32];
        vvi_sample_print(number, a->type, block + i * bytes);
        st = vvi_sink_printf(w->sink, "%s%s", number, (i + 1) % a->components ? " " : "\n");
    }
    return st;
}

static uint64_t bytes_of(const array *a)
{
    return (uint64_t)a->n * a->components * vv_type_bytes(a->type);
}

/* Binary arrays begin with their length. */
static vv_status put_array(writer *w, const array *a)
{
    uint64_t block[BLOCK * 3], bytes = bytes_of(a);
    vv_status st = w->ascii ? VV_OK : put_bytes(w, &bytes, sizeof bytes);
    for (size_t i = 0; i < a->n && st == VV_OK; i += BLOCK) {
        const size_t some = a->n - i < BLOCK ? a->n - i : BLOCK;
        a->fill(w, block, i, some);
        st = w->ascii ? put_text(w, a, (const uint8_t *)block, some)
                      : put_bytes(w, block, some * a->components * vv_type_bytes(a->type));
        if (st == VV_OK)
            st = vvi_job_poll(w->job);
    }
    return st == VV_OK && w->base64 ? vvi_base64_end(&w->coder, w->sink) : st;
}

/* Tags --------------------------------------------------------------------------------------------------------------
 */

static void add_escaped(vvi_text *t, const char *s)
{
    for (; *s; s++)
        if (strchr("&<\"", *s) || (unsigned char)*s < ' ')
            vvi_text_printf(t, "&#%d;", (unsigned char)*s < ' ' ? ' ' : *s);
        else
            vvi_text_add_n(t, s, 1);
}

/* A text as VTK keeps it: the numbers of its letters, and a 0. */
static void add_note(vvi_text *t, const char *name, const char *mark, const char *text)
{
    vvi_text_printf(t, "<Array type=\"String\" Name=\"%s\" NumberOfTuples=\"1\" format=\"ascii\">", name);
    for (; *mark; mark++)
        vvi_text_printf(t, "%d ", (unsigned char)*mark);
    for (; *text; text++)
        vvi_text_printf(t, "%d ", (unsigned char)*text);
    vvi_text_add(t, "0</Array>\n");
}

static void add_head(vvi_text *t, const writer *w)
{
    const vv_mesh_info *m = w->m;
    vvi_text_printf(t,
                    "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"%s\" "
                    "header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n",
                    vvi_machine_is_big() ? "BigEndian" : "LittleEndian");
    if (m->unit[0])
        add_note(t, "volvis unit", "", m->unit);
    if (m->space == VV_SPACE_RAS)
        add_note(t, "volvis space", "", "RAS");
    if (m->up == VV_UP_Y)
        add_note(t, "volvis up", "", "y");
    if (m->values && m->value_unit[0])
        add_note(t, "volvis value unit", "", m->value_unit);
    for (size_t i = 0; i < m->n_parts; i++) {
        char name[48]; /* of its own: VTK keeps one array of a name */
        snprintf(name, sizeof name, "volvis part %zu", i);
        add_note(t, name, "=", m->parts[i].name);
    }
    vvi_text_printf(t,
                    "</FieldData>\n<Piece NumberOfPoints=\"%zu\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
                    "NumberOfStrips=\"0\" NumberOfPolys=\"%zu\">\n",
                    m->n_vertices, m->n_triangles);
}

static vv_status put_tag(writer *w, const array *a)
{
    static const char *const types[VV_TYPE_COUNT] = {"UInt8", "Int8",   "UInt16", "Int16",   "UInt32",
                                                     "Int32", "UInt64", "Int64",  "Float32", "Float64"};
    vvi_text t = {0};
    vvi_text_printf(&t, "<DataArray type=\"%s\" Name=\"", types[a->type]);
    add_escaped(&t, a->name);
    vvi_text_printf(&t, "\" NumberOfComponents=\"%zu\" ", a->components);
    if (w->ascii || w->base64)
        vvi_text_printf(&t, "format=\"%s\">\n", w->ascii ? "ascii" : "binary");
    else
        vvi_text_printf(&t, "format=\"appended\" offset=\"%llu\"/>\n", (unsigned long long)a->offset);
    vv_status st = t.bad ? vv_fail_memory(t.n) : vvi_sink_write(w->sink, t.s, t.n);
    vvi_text_free(&t);
    if (st == VV_OK && (w->ascii || w->base64) && (st = put_array(w, a)) == VV_OK)
        st = vvi_sink_printf(w->sink, "\n</DataArray>\n");
    return st;
}

/* One after another; each section's tag stands around its own. */
static vv_status put_section(writer *w, const char *open, const char *close, size_t *at, size_t n)
{
    vv_status st = vvi_sink_printf(w->sink, "<%s>\n", open);
    for (; n > 0 && st == VV_OK; n--)
        st = put_tag(w, &w->list[(*at)++]);
    return st == VV_OK ? vvi_sink_printf(w->sink, "</%s>\n", close) : st;
}

static void add(writer *w, const char *name, vv_type type, size_t components, size_t n,
                void (*fill)(const writer *w, void *out, size_t first, size_t n))
{
    array *a = &w->list[w->n];
    *a = (array){.name = name, .type = type, .components = components, .n = n, .fill = fill};
    a->offset = w->n ? a[-1].offset + sizeof(uint64_t) + bytes_of(&a[-1]) : 0;
    w->n++;
}

static vv_status put_all(writer *w, const vvi_text *head)
{
    const vv_mesh_info *m = w->m;
    const size_t n_points = (m->normals != NULL) + (m->values != NULL) + (m->colors != NULL);
    size_t at = 0;
    vv_status st = vvi_sink_write(w->sink, head->s, head->n);
    if (st == VV_OK)
        st = put_section(w, m->normals ? "PointData Normals=\"Normals\"" : "PointData", "PointData", &at, n_points);
    if (st == VV_OK)
        st = put_section(w, "CellData", "CellData", &at, (m->n_parts ? 1 : 0) + (vvi_mesh_has_part_colors(m) ? 1 : 0));
    if (st == VV_OK && (st = put_section(w, "Points", "Points", &at, 1)) == VV_OK)
        st = put_section(w, "Polys", "Polys", &at, 2);
    if (st == VV_OK)
        st = vvi_sink_printf(w->sink, "</Piece>\n</PolyData>\n");
    if (st == VV_OK && !w->ascii && !w->base64) {
        st = vvi_sink_printf(w->sink, "<AppendedData encoding=\"raw\">\n_");
        for (size_t i = 0; i < w->n && st == VV_OK; i++)
            st = put_array(w, &w->list[i]);
        if (st == VV_OK)
            st = vvi_sink_printf(w->sink, "\n</AppendedData>\n");
    }
    return st == VV_OK ? vvi_sink_printf(w->sink, "</VTKFile>\n") : st;
}

vv_status vvi_vtp_write(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    writer w = {.sink = sink, .m = m, .doubles = vvi_mesh_needs_doubles(mesh), .job = job};
    vvi_text head = {0};
    w.ascii = strcmp(options->encoding, "ascii") == 0;
    w.base64 = strcmp(options->encoding, "base64") == 0;
    w.index_type = m->n_triangles < INT32_MAX / 3 && m->n_vertices < INT32_MAX ? VV_TYPE_I32 : VV_TYPE_I64;
    if (m->normals)
        add(&w, "Normals", VV_TYPE_F32, 3, m->n_vertices, fill_normals);
    if (m->values)
        add(&w, m->value_name[0] ? m->value_name : "values", VV_TYPE_F32, 1, m->n_vertices, fill_values);
    if (m->colors)
        add(&w, "RGBA", VV_TYPE_U8, 4, m->n_vertices, fill_colors);
    if (m->n_parts)
        add(&w, "part", VV_TYPE_I32, 1, m->n_triangles, fill_parts);
    if (vvi_mesh_has_part_colors(m))
        add(&w, "RGB", VV_TYPE_U8, 3, m->n_triangles, fill_part_colors);
    add(&w, "Points", w.doubles ? VV_TYPE_F64 : VV_TYPE_F32, 3, m->n_vertices, fill_places);
    add(&w, "connectivity", w.index_type, 1, 3 * m->n_triangles, fill_corners);
    add(&w, "offsets", w.index_type, 1, m->n_triangles, fill_ends);
    add_head(&head, &w);
    const vv_status st = head.bad ? vv_fail_memory(head.n) : put_all(&w, &head);
    vvi_text_free(&head);
    return st;
}
