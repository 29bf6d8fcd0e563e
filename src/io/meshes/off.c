/* OFF of Geomview (Phillips, Levy, Munzner 1993): "[C][N]OFF", counts, vertices, faces; as text, or "BINARY" with the
 * high byte first. */
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "io/meshes/mesh_colors.h"
#include "io/meshes/mesh_column.h"
#include "io/meshes/mesh_words.h"
#include "io/meshes/mesh_write.h"
#include "io/scan.h"
#include "registry.h"

#include <string.h>

enum { CORNERS_MOST = 1 << 20, FACE_NUMBERS_MOST = 4 };

/* What the first word says. */
typedef struct keyword {
    bool texture, color, normal, four, any;
} keyword;

static bool read_keyword(keyword *out, const char *word, size_t n)
{
    const char *at = word, *end = word + n;
    *out = (keyword){0};
    if (end - at >= 2 && at[0] == 'S' && at[1] == 'T') {
        out->texture = true;
        at += 2;
    }
    for (; at < end && *at != 'O'; at++) {
        bool *flag = *at == 'C' ? &out->color : *at == 'N' ? &out->normal : *at == '4' ? &out->four : &out->any;
        if (*flag || !strchr("CN4n", *at))
            return false;
        *flag = true;
    }
    return end - at == 3 && memcmp(at, "OFF", 3) == 0;
}

static int probe(const uint8_t *head, size_t n, const char *path)
{
    keyword known;
    size_t end = 0;
    (void)path;
    while (end < n && end < 8 && head[end] > ' ')
        end++;
    return end < n && read_keyword(&known, (const char *)head, end) ? 2 : 0;
}

typedef struct reader {
    vv_source *source;
    vvi_words words;
    vvi_mesh_builder b;
    vvi_face_colors faces;
    keyword has;
    bool binary;
    bool vertices_flow, faces_flow; /* their lines say nothing: many stand on one */
    uint64_t n_vertices, n_faces;
    float *color;     /* of vertices, red green blue alpha as the file says them: 0 .. 1 or 0 .. 255 */
    float color_most; /* of them */
    uint32_t *corner;
    size_t room_corner;
    vv_job *job;
} reader;

/* Both forms in the same steps ------------------------------------------------------------------------------------ */

static vv_status read_floats(reader *r, float *out, size_t n, const char *what)
{
    vv_status st = VV_OK;
    if (r->binary) {
        const vvi_column column = {VV_TYPE_F32, !vvi_machine_is_big(), 0, 4};
        double v[16];
        if ((st = vvi_source_read(r->source, out, n * sizeof *out, what)) != VV_OK)
            return st;
        vvi_column_load(v, &column, out, n);
        for (size_t i = 0; i < n; i++)
            out[i] = (float)v[i];
        return VV_OK;
    }
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        double v;
        if ((st = vvi_words_real(&r->words, &v, what)) == VV_OK)
            out[i] = (float)v;
    }
    return st;
}

static vv_status read_int(reader *r, int64_t *out, int64_t lo, int64_t hi, const char *what)
{
    uint8_t b[4];
    if (!r->binary)
        return vvi_words_int(&r->words, out, lo, hi, what);
    const vv_status st = vvi_source_read(r->source, b, 4, what);
    if (st != VV_OK)
        return st;
    *out = (int32_t)((uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3]);
    if (*out < lo || *out > hi)
        return vv_fail_at(VV_E_FORMAT, r->b.file, NULL, "%s before byte %llu is %lld; it goes from %lld to %lld", what,
                          (unsigned long long)vvi_source_tell(r->source), (long long)*out, (long long)lo,
                          (long long)hi);
    return VV_OK;
}

/* Vertices -------------------------------------------------------------------------------------------------------- */

static void take_color(reader *r, size_t vertex, const float *color)
{
    memcpy(r->color + 4 * vertex, color, 4 * sizeof *color);
    for (int c = 0; c < 3; c++)
        r->color_most = color[c] > r->color_most ? color[c] : r->color_most;
}

/* Text has doubles. */
static vv_status read_place(reader *r, size_t vertex)
{
    float single[3];
    vv_status st = VV_OK;
    if (r->binary) {
        if ((st = read_floats(r, single, 3, "a vertex")) == VV_OK)
            for (size_t a = 0; a < 3; a++)
                r->b.places[3 * vertex + a] = single[a];
        return st;
    }
    for (size_t a = 0; a < 3 && st == VV_OK; a++)
        st = vvi_words_real(&r->words, &r->b.places[3 * vertex + a], "a coordinate");
    return st;
}

/* A colour as text may have three numbers or four; it ends the line. */
static vv_status read_color_words(reader *r, size_t vertex)
{
    float color[4] = {0, 0, 0, -1};
    size_t n = 0;
    for (int c = 0; c < 4; c++) {
        const char *end, *word = vvi_words_here(&r->words, &n);
        double v;
        if (!word && c == 3)
            break;
        if (!word || !vvi_words_number(&v, word, &end) || end != word + n)
            return vvi_words_fail(&r->words, "a vertex has no colour of three or four numbers");
        color[c] = (float)v;
    }
    take_color(r, vertex, color);
    return VV_OK;
}

static vv_status read_vertex(reader *r, size_t vertex)
{
    const bool counted = r->binary || r->vertices_flow; /* by what the keyword says, not by lines */
    float color[4], unused[2];
    vv_status st = read_place(r, vertex);
    if (st == VV_OK && r->has.normal)
        st = read_floats(r, r->b.arrays.normals + 3 * vertex, 3, "a normal");
    if (st == VV_OK && r->has.color && !counted)
        st = read_color_words(r, vertex);
    else if (st == VV_OK && r->has.color && (st = read_floats(r, color, 4, "a colour")) == VV_OK)
        take_color(r, vertex, color);
    if (st == VV_OK && r->has.texture && counted)
        st = read_floats(r, unused, 2, "a texture's place");
    if (!counted)
        r->words.at += strlen(r->words.at); /* textures, and colours that the keyword does not say */
    return st;
}

static vv_status read_vertices(reader *r)
{
    const size_t n = (size_t)r->n_vertices;
    vv_status st =
        vvi_mesh_builder_with(&r->b, (r->has.normal ? VVI_MESH_NORMALS : 0) | (r->has.color ? VVI_MESH_COLORS : 0));
    if (st == VV_OK)
        st = vvi_mesh_builder_reserve(&r->b, n, r->n_faces);
    if (st == VV_OK && (st = vvi_mesh_builder_vertices(&r->b, n)) == VV_OK && r->has.color) {
        if ((st = vvi_source_grow(r->source, n * 4 * sizeof *r->color)) != VV_OK)
            return st;
        r->color = vvi_alloc_zeroed(r->job, (n + 1) * 4 * sizeof *r->color, VVI_MEM_SCRATCH);
        st = r->color ? VV_OK : vv_fail_memory((n + 1) * 4 * sizeof *r->color);
    }
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = i % 4096 == 0 && vvi_job_poll(r->job) != VV_OK ? vv_error_last()->status : read_vertex(r, i);
    /* all of them between 0 and 1: parts of the whole; else bytes */
    const double whole = r->color_most <= 1 ? 1 : 255;
    for (size_t i = 0; i < 4 * n && r->color && st == VV_OK; i++)
        r->b.arrays.colors[i] = r->color[i] < 0 && i % 4 == 3 ? 255 : vvi_mesh_byte(r->color[i] / whole);
    return st;
}

/* Faces ----------------------------------------------------------------------------------------------------------- */

static vv_status room_for_corners(reader *r, size_t n)
{
    if (n <= r->room_corner)
        return VV_OK;
    const vv_status st = vvi_source_grow(r->source, 2 * n * sizeof *r->corner);
    if (st != VV_OK)
        return st;
    uint32_t *grown = vvi_realloc(r->job, r->corner, 2 * n * sizeof *grown, VVI_MEM_SCRATCH);
    if (!grown)
        return vv_fail_memory(2 * n * sizeof *grown);
    r->corner = grown;
    r->room_corner = 2 * n;
    return VV_OK;
}

/* Numbers after the corners: none, one (of a table that the file does not have), or a colour; as bytes when all are
 * whole and one is above 1. */
static vv_status use_color(reader *r, const double *v, size_t n, bool whole)
{
    uint8_t bytes[4] = {0, 0, 0, 255};
    for (size_t c = 0; c < n && n >= 3; c++)
        bytes[c] = vvi_mesh_byte(whole ? v[c] / 255 : v[c]);
    return n >= 3       ? vvi_face_colors_use(&r->faces, &r->b, bytes)
           : r->faces.n ? vvi_face_colors_use(&r->faces, &r->b, NULL)
                        : VV_OK;
}

static vv_status read_color_of_face(reader *r)
{
    double v[FACE_NUMBERS_MOST];
    float single[FACE_NUMBERS_MOST];
    int64_t n = 0;
    bool whole = true;
    if (r->binary) {
        vv_status st = read_int(r, &n, 0, FACE_NUMBERS_MOST, "the number of colour channels");
        if (st == VV_OK && n > 0)
            st = read_floats(r, single, (size_t)n, "a colour");
        for (int64_t i = 0; i < n && st == VV_OK; i++)
            v[i] = single[i];
        return st == VV_OK ? use_color(r, v, (size_t)n, false) : st;
    }
    if (r->faces_flow)
        return use_color(r, v, 0, false);
    for (size_t m; n < FACE_NUMBERS_MOST; n++) {
        const char *end, *word = vvi_words_here(&r->words, &m);
        if (!word)
            break;
        if (!vvi_words_number(&v[n], word, &end) || end != word + m)
            return vvi_words_fail(&r->words, "found '%.*s' where a number of a colour was expected",
                                  (int)(m < 40 ? m : 40), word);
        whole = whole && !memchr(word, '.', m);
    }
    r->words.at += strlen(r->words.at);
    return use_color(r, v, (size_t)n, whole);
}

static vv_status read_face(reader *r)
{
    int64_t n = 0, index = 0;
    vv_status st = read_int(r, &n, 0, CORNERS_MOST, "the number of corners");
    if (st == VV_OK && n < 3)
        return vv_fail_at(VV_E_FORMAT, r->b.file, NULL,
                          "a face before triangle %zu has %d corners; at least 3 were expected (counted from 0)",
                          r->b.info.n_triangles, (int)n);
    if (st == VV_OK)
        st = room_for_corners(r, (size_t)n);
    for (int64_t i = 0; i < n && st == VV_OK; i++)
        if ((st = read_int(r, &index, 0, (int64_t)r->n_vertices - 1, "a vertex of a face")) == VV_OK)
            r->corner[i] = (uint32_t)index;
    if (r->n_faces > 1 && r->b.info.n_triangles == 0 && !r->binary) /* more than a colour has */
        r->faces_flow |= vvi_words_left(&r->words, FACE_NUMBERS_MOST + 1) > FACE_NUMBERS_MOST;
    if (st == VV_OK && (st = read_color_of_face(r)) == VV_OK)
        st = vvi_mesh_builder_polygon(&r->b, r->corner, (size_t)n);
    return st;
}

/* The whole file -------------------------------------------------------------------------------------------------- */

static vv_status read_header(reader *r)
{
    const char *word;
    int64_t n_vertices = 0, n_faces = 0, n_edges;
    size_t n;
    r->b.info.up = vvi_mesh_format_off.up;
    vv_status st = vvi_words_next(&r->words, &word, &n);
    if (st != VV_OK)
        return st;
    if (n == 0 || !read_keyword(&r->has, word, n))
        return vvi_words_fail(&r->words, "the first word is not OFF, or COFF, NOFF and so on");
    if (r->has.four || r->has.any)
        return vv_fail_at(VV_E_UNSUPPORTED, r->b.file, "1", "has vertices of more than three dimensions");
    word = vvi_words_here(&r->words, &n);
    r->binary = word && n == 6 && memcmp(word, "BINARY", 6) == 0;
    if (word && !r->binary)
        r->words.at = word; /* counts on the first line */
    for (const char *line = "#"; !r->binary && !word && line && (*line == '#' || *line == 0);) {
        if ((st = vvi_words_line(&r->words, &line)) != VV_OK)
            return st;
        if (line && *line == '#')
            vvi_mesh_builder_comment(&r->b, line + 1); /* of VolVis, before the first line that counts */
    }
    if (r->binary) /* it has no place to say so, and comes back as it was written */
        r->b.info.up = VV_UP_Z;
    r->words.comment = '#';
    if ((st = read_int(r, &n_vertices, 0, INT32_MAX, "the number of vertices")) != VV_OK ||
        (st = read_int(r, &n_faces, 0, INT32_MAX, "the number of faces")) != VV_OK ||
        (st = read_int(r, &n_edges, INT32_MIN, INT32_MAX, "the number of edges")) != VV_OK)
        return st;
    r->n_vertices = (uint64_t)n_vertices;
    r->n_faces = (uint64_t)n_faces;
    return VV_OK;
}

/* Three numbers take 12 bytes or 6, a face 20 or 8. */
static vv_status check_sizes(const reader *r)
{
    bool exact;
    const uint64_t here = strlen(r->words.at) + 2, left = vvi_source_left(r->source, &exact) + here;
    const uint64_t need = r->n_vertices * (r->binary ? 12 : 6) + r->n_faces * (r->binary ? 20 : 8);
    vvi_source_need(r->source, need > here ? need - here : 0);
    if (need <= left)
        return VV_OK;
    return vv_fail_at(VV_E_FORMAT, r->b.file, "header",
                      "%llu vertices and %llu faces take at least %llu bytes, but at most %llu follow; the file is cut "
                      "short or its header wrong",
                      (unsigned long long)r->n_vertices, (unsigned long long)r->n_faces, (unsigned long long)need,
                      (unsigned long long)left);
}

/* Files of other programs have numbers behind vertices that the keyword does not say, to the ends of their lines. Where
 * vertices begin behind the counts, or all stand on a line, it is not so. */
static vv_status see_whether_vertices_flow(reader *r)
{
    const size_t each = 3 + (r->has.normal ? 3u : 0) + (r->has.color ? 4u : 0) + (r->has.texture ? 2u : 0);
    vv_status st = VV_OK;
    if (r->binary || r->n_vertices == 0)
        return VV_OK;
    r->vertices_flow = vvi_words_left(&r->words, 1) > 0;
    for (const char *line = ""; st == VV_OK && line && vvi_words_left(&r->words, 1) == 0;)
        st = vvi_words_line(&r->words, &line);
    const size_t all = (size_t)r->n_vertices * each; /* check_sizes() */
    r->vertices_flow |= st == VV_OK && r->n_vertices > 2 && vvi_words_left(&r->words, all) == all;
    return st;
}

static vv_status read_all(reader *r, vv_notes *notes)
{
    vv_status st = read_header(r);
    if (st != VV_OK || (st = check_sizes(r)) != VV_OK || (st = see_whether_vertices_flow(r)) != VV_OK ||
        (st = read_vertices(r)) != VV_OK)
        return st;
    r->faces_flow = r->vertices_flow && vvi_words_left(&r->words, 1) > 0;
    for (uint64_t i = 0; i < r->n_faces && st == VV_OK; i++)
        st = i % 4096 == 0 && vvi_job_poll(r->job) != VV_OK ? vv_error_last()->status : read_face(r);
    return st == VV_OK ? vvi_face_colors_finish(&r->faces, &r->b, notes) : st;
}

static vv_status read_off(vv_mesh **out, vv_source *source, const vv_mesh_read_options *options, vv_notes *notes,
                          vv_job *job)
{
    reader r = {.source = source, .job = job};
    vvi_words_begin(&r.words, source, 0, job);
    vvi_mesh_builder_begin(&r.b, source, options, true, job);
    vv_status st = read_all(&r, notes);
    if (st == VV_OK)
        st = vvi_mesh_builder_finish(out, &r.b, notes);
    vvi_mesh_builder_free(&r.b);
    vvi_face_colors_free(&r.faces);
    vvi_free(r.color);
    vvi_free(r.corner);
    return st;
}

/* Writing --------------------------------------------------------------------------------------------------------- */

typedef struct off_rows {
    const vv_mesh_info *m;
    bool doubles;
} off_rows;

static void text_vertices(vvi_mesh_text *t, const void *user, size_t first, size_t end)
{
    const off_rows *o = user;
    const vv_mesh_info *m = o->m;
    for (size_t i = first; i < end && t->status == VV_OK; i++) {
        vvi_mesh_text_place(t, m, i, o->doubles);
        for (size_t a = 0; a < 3 && m->normals; a++)
            vvi_mesh_text_float(t, m->normals[3 * i + a]);
        for (size_t c = 0; c < 4 && m->colors; c++)
            vvi_mesh_text_float(t, (float)m->colors[4 * i + c] / 255);
        vvi_mesh_text_add(t, "\n");
    }
}

static void text_faces(vvi_mesh_text *t, const void *user, size_t first, size_t end)
{
    const vv_mesh_info *m = ((const off_rows *)user)->m;
    size_t part = 0;
    for (size_t i = first; i < end && t->status == VV_OK; i++) {
        uint8_t color[4] = {0};
        const vv_mesh_part *p = vvi_mesh_part_at(m, i, &part);
        vvi_mesh_text_add(t, "3");
        for (size_t k = 0; k < 3; k++)
            vvi_mesh_text_uint(t, m->triangles[3 * i + k]);
        if (p && p->color.a >= 0)
            vvi_mesh_bytes_of(color, &p->color);
        for (int c = 0; c < 3 && p && p->color.a >= 0; c++)
            vvi_mesh_text_uint(t, color[c]);
        vvi_mesh_text_add(t, "\n");
    }
}

static vv_status write_text(vv_sink *sink, const vv_mesh *mesh, vv_job *job)
{
    const off_rows rows = {vv_mesh_get_info(mesh), vvi_mesh_needs_doubles(mesh)};
    vvi_mesh_text t;
    const vv_status st = vvi_mesh_text_begin(&t, sink, job);
    if (st != VV_OK)
        return st;
    vvi_mesh_text_rows(&t, text_vertices, &rows, rows.m->n_vertices);
    vvi_mesh_text_rows(&t, text_faces, &rows, rows.m->n_triangles);
    return vvi_mesh_text_end(&t);
}

/* What follows has its high bytes first. */
static vv_status put_floats(vv_sink *sink, const float *v, size_t n)
{
    uint8_t bytes[16 * 4];
    for (size_t i = 0; i < n; i++) {
        uint32_t bits;
        memcpy(&bits, v + i, sizeof bits);
        for (size_t b = 0; b < 4; b++)
            bytes[4 * i + b] = (uint8_t)(bits >> (24 - 8 * b));
    }
    return vvi_sink_write(sink, bytes, 4 * n);
}

static vv_status put_ints(vv_sink *sink, const uint32_t *v, size_t n)
{
    uint8_t bytes[16 * 4];
    for (size_t i = 0; i < 4 * n; i++)
        bytes[i] = (uint8_t)(v[i / 4] >> (24 - 8 * (i % 4)));
    return vvi_sink_write(sink, bytes, 4 * n);
}

static vv_status put_vertex(vv_sink *sink, const vv_mesh_info *m, size_t i)
{
    float v[10];
    double p[3];
    size_t n = 0;
    vvi_mesh_place(p, m, i);
    for (size_t a = 0; a < 3; a++)
        v[n++] = (float)p[a];
    for (size_t a = 0; a < 3 && m->normals; a++)
        v[n++] = m->normals[3 * i + a];
    for (size_t c = 0; c < 4 && m->colors; c++)
        v[n++] = (float)m->colors[4 * i + c] / 255;
    return put_floats(sink, v, n);
}

static vv_status put_face(vv_sink *sink, const vv_mesh_info *m, size_t t, const vv_mesh_part *part)
{
    const uint32_t *v = m->triangles + 3 * t;
    const bool colored = part && part->color.a >= 0;
    uint8_t bytes[4];
    vv_status st = put_ints(sink, (const uint32_t[]){3, v[0], v[1], v[2], colored ? 3 : 0}, 5);
    if (st != VV_OK || !colored)
        return st;
    vvi_mesh_bytes_of(bytes, &part->color);
    return put_floats(sink, (const float[]){bytes[0] / 255.0F, bytes[1] / 255.0F, bytes[2] / 255.0F}, 3);
}

static vv_status write_binary(vv_sink *sink, const vv_mesh_info *m, vv_job *job)
{
    size_t part = 0;
    vv_status st = put_ints(sink, (const uint32_t[]){(uint32_t)m->n_vertices, (uint32_t)m->n_triangles, 0}, 3);
    for (size_t i = 0; i < m->n_vertices && st == VV_OK; i++)
        st = i % 4096 == 0 && vvi_job_poll(job) != VV_OK ? vv_error_last()->status : put_vertex(sink, m, i);
    for (size_t i = 0; i < m->n_triangles && st == VV_OK; i++)
        st = i % 4096 == 0 && vvi_job_poll(job) != VV_OK ? vv_error_last()->status
                                                         : put_face(sink, m, i, vvi_mesh_part_at(m, i, &part));
    return st;
}

static vv_status write_off(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    const bool binary = strcmp(options->encoding, "binary") == 0;
    const bool loses_unit = binary && vvi_length_unit_metres(m->unit) > 0, loses_up = binary && m->up == VV_UP_Y;
    if (loses_unit || loses_up)
        vvi_log(job, VV_LOG_WARNING, "io", "%s: binary OFF does not store that %s%s%s%s; --encoding ascii does",
                vvi_sink_name(sink), loses_unit ? "lengths are in " : "", loses_unit ? m->unit : "",
                loses_unit && loses_up ? ", nor that " : "", loses_up ? "y points up" : "");
    vv_status st =
        vvi_sink_printf(sink, "%s%sOFF%s\n", m->colors ? "C" : "", m->normals ? "N" : "", binary ? " BINARY" : "");
    if (st != VV_OK || binary)
        return st == VV_OK ? write_binary(sink, m, job) : st;
    if (m->unit[0])
        st = vvi_sink_printf(sink, "# unit: %s\n", m->unit);
    if (st == VV_OK && m->space == VV_SPACE_RAS)
        st = vvi_sink_printf(sink, "# space: RAS\n");
    if (st == VV_OK)
        st = vvi_sink_printf(sink, "# up: %c\n", m->up == VV_UP_Y ? 'y' : 'z');
    if (st == VV_OK)
        st = vvi_sink_printf(sink, "%zu %zu 0\n", m->n_vertices, m->n_triangles);
    return st == VV_OK ? write_text(sink, mesh, job) : st;
}

static const char *const suffixes[] = {".off", NULL};
static const char *const encodings[] = {"ascii", "binary", NULL};

const vv_mesh_format vvi_mesh_format_off = {
    .up = VV_UP_Y, /* as Geomview looks at them */
    .api = VV_MESH_FORMAT_API,
    .name = "off",
    .doc = "OFF of Geomview: normals, colours of vertices and faces; the unit in a comment, as text",
    .suffixes = suffixes,
    .encodings = encodings,
    .holds = VV_MESH_HOLDS_NORMALS | VV_MESH_HOLDS_COLORS | VV_MESH_HOLDS_PART_COLORS | VV_MESH_HOLDS_DOUBLES |
             VV_MESH_HOLDS_UNIT,
    .probe = probe,
    .read = read_off,
    .write = write_off,
};
