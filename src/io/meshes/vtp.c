/* VTK's XML polygons, .vtp: points, polygons, strips, and data of points and cells in the arrays of VTK's XML files. */
#include "io/meshes/vtp.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/vtk/vtk_xml.h"
#include "io/meshes/mesh_colors.h"
#include "io/scan.h"
#include "registry.h"

#include <string.h>

typedef struct reader {
    vvi_vtk_file file;
    vvi_mesh_builder b;
    vvi_face_colors colors;
    vv_source *source;
    vv_notes *notes;
    size_t n_named; /* parts that the file names */
    uint32_t *corner;
    size_t room_corner;
    size_t first_vertex; /* of the piece */
    vv_job *job;
} reader;

/* An array of a piece's section, by name; name NULL: the first with so many components. */
static const vvi_vtk_array *find(const reader *r, size_t piece, vvi_vtk_section section, const char *name,
                                 int components)
{
    for (size_t i = 0; i < r->file.n_arrays; i++) {
        const vvi_vtk_array *a = &r->file.array[i];
        if (a->piece == piece && a->section == section && a->has_type && (!name || strcmp(a->name, name) == 0) &&
            (components == 0 || a->components == components))
            return a;
    }
    return NULL;
}

static vv_status numbers(double **out, reader *r, const vvi_vtk_array *a, uint64_t n)
{
    *out = NULL;
    const vv_status st = vvi_source_grow(r->source, n > UINT64_MAX / 16 ? UINT64_MAX : 16 * n); /* as stored, and so */
    return st == VV_OK && n ? vvi_vtk_numbers(out, &r->file, a, n, r->source, r->job) : st;
}

/* Points ---------------------------------------------------------------------------------------------------------- */

static vv_status put_normals(reader *r, const vvi_vtk_array *a, size_t n)
{
    double *v;
    vv_status st = vvi_mesh_builder_with(&r->b, VVI_MESH_NORMALS);
    if (st != VV_OK || (st = numbers(&v, r, a, 3 * (uint64_t)n)) != VV_OK)
        return st;
    for (size_t i = 0; i < 3 * n; i++)
        r->b.arrays.normals[3 * r->first_vertex + i] = (float)v[i];
    vvi_free(v);
    return VV_OK;
}

static vv_status put_values(reader *r, const vvi_vtk_array *a, size_t n)
{
    double *v;
    vv_status st = vvi_mesh_builder_with(&r->b, VVI_MESH_VALUES);
    if (st != VV_OK || (st = numbers(&v, r, a, n)) != VV_OK)
        return st;
    for (size_t i = 0; i < n; i++)
        r->b.arrays.values[r->first_vertex + i] = (float)v[i];
    vvi_free(v);
    const size_t length = vvi_utf8_cut(a->name, strlen(a->name), sizeof r->b.info.value_name - 1);
    memcpy(r->b.info.value_name, a->name, length);
    r->b.info.value_name[length] = 0;
    return VV_OK;
}

static vv_status put_colors(reader *r, const vvi_vtk_array *a, size_t n)
{
    double *v;
    const size_t c = (size_t)a->components;
    vv_status st = vvi_mesh_builder_with(&r->b, VVI_MESH_COLORS);
    if (st != VV_OK || (st = numbers(&v, r, a, (uint64_t)n * c)) != VV_OK)
        return st;
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < c; k++)
            r->b.arrays.colors[4 * (r->first_vertex + i) + k] = (uint8_t)v[i * c + k];
    vvi_free(v);
    return VV_OK;
}

static bool is_color(const vvi_vtk_array *a)
{
    return a->type == VV_TYPE_U8 && !a->bits && (a->components == 3 || a->components == 4);
}

/* Of each kind the first: normals by their name or as the active ones, bytes of three or four as colours, single
 * numbers as values, the active ones before others. */
static vv_status put_point_data(reader *r, size_t piece, size_t n)
{
    const vvi_vtk_array *normals = NULL, *colors = NULL, *values = NULL;
    vv_status st = VV_OK;
    for (size_t i = 0; i < r->file.n_arrays; i++) {
        const vvi_vtk_array *a = &r->file.array[i];
        if (a->piece != piece || a->section != VVI_VTK_POINTS || !a->has_type)
            continue;
        if (is_color(a))
            colors = colors ? colors : a;
        else if (a->components == 3 && (strcmp(a->name, "Normals") == 0 || (a->vectors && !normals)))
            normals = a;
        else if (a->components == 1 && (!values || a->scalars))
            values = a;
    }
    if (normals)
        st = put_normals(r, normals, n);
    if (st == VV_OK && colors)
        st = put_colors(r, colors, n);
    return st == VV_OK && values ? put_values(r, values, n) : st;
}

static vv_status put_points(reader *r, size_t piece, size_t n)
{
    const vvi_vtk_array *places = find(r, piece, VVI_VTK_PLACES, NULL, 3);
    double *v;
    if (!places)
        return vv_fail_at(VV_E_FORMAT, r->file.name, NULL, "has a piece of %zu points without coordinates", n);
    vv_status st = numbers(&v, r, places, 3 * (uint64_t)n);
    if (st != VV_OK)
        return st;
    r->first_vertex = r->b.info.n_vertices;
    if ((st = vvi_mesh_builder_vertices(&r->b, n)) == VV_OK && v)
        memcpy(r->b.places + 3 * r->first_vertex, v, 3 * n * sizeof *v);
    vvi_free(v);
    return st == VV_OK ? put_point_data(r, piece, n) : st;
}

/* Cells ----------------------------------------------------------------------------------------------------------- */

/* What the cells of a piece say of their part: verts and lines come before polygons and strips. */
typedef struct cells {
    double *part, *color;
    size_t components, at;
} cells;

static vv_status open_cells(cells *out, reader *r, size_t piece)
{
    const vvi_vtk_piece *p = &r->file.piece[piece];
    const uint64_t n = (uint64_t)p->n_before + (uint64_t)p->n_polys + (uint64_t)p->n_strips;
    const vvi_vtk_array *part = r->n_named ? find(r, piece, VVI_VTK_CELLS, "part", 1) : NULL, *color = NULL;
    *out = (cells){.at = (size_t)p->n_before};
    for (size_t i = 0; i < r->file.n_arrays && !color; i++) {
        const vvi_vtk_array *a = &r->file.array[i];
        color = a->piece == piece && a->section == VVI_VTK_CELLS && a->has_type && is_color(a) ? a : NULL;
    }
    vv_status st = part ? numbers(&out->part, r, part, n) : VV_OK;
    if (st == VV_OK && color) {
        out->components = (size_t)color->components;
        st = numbers(&out->color, r, color, n * out->components);
    }
    return st;
}

static vv_status use_cell(cells *c, reader *r)
{
    const size_t at = c->at++;
    uint8_t bytes[4] = {0, 0, 0, 255};
    for (size_t k = 0; k < c->components && c->color; k++)
        bytes[k] = (uint8_t)c->color[at * c->components + k];
    if (!c->part)
        return c->color ? vvi_face_colors_use(&r->colors, &r->b, bytes) : VV_OK;
    r->b.part = c->part[at] >= 0 && c->part[at] < (double)r->b.info.n_parts ? (uint32_t)c->part[at] : 0;
    if (c->color && r->b.arrays.parts[r->b.part].color.a < 0)
        r->b.arrays.parts[r->b.part].color = vvi_mesh_color_of(bytes);
    return VV_OK;
}

static vv_status put_cell(reader *r, const double *index, size_t n, bool strip)
{
    if (n > r->room_corner) {
        const vv_status st = vvi_source_grow(r->source, 2 * n * sizeof *r->corner);
        uint32_t *grown = st == VV_OK ? vvi_realloc(r->job, r->corner, 2 * n * sizeof *grown, VVI_MEM_SCRATCH) : NULL;
        if (!grown)
            return st != VV_OK ? st : vv_fail_memory(2 * n * sizeof *grown);
        r->corner = grown;
        r->room_corner = 2 * n;
    }
    for (size_t i = 0; i < n && index; i++) { /* NULL: of no corners */
        const double v = index[i] + (double)r->first_vertex;
        r->corner[i] = index[i] >= 0 && v < UINT32_MAX ? (uint32_t)v : UINT32_MAX;
    }
    if (n < 3)
        return vv_fail_at(VV_E_FORMAT, r->file.name, NULL,
                          "a polygon before triangle %zu has %zu corners; at least 3 were expected (counted from 0)",
                          r->b.info.n_triangles, n);
    return strip ? vvi_mesh_builder_strip(&r->b, r->corner, n) : vvi_mesh_builder_polygon(&r->b, r->corner, n);
}

static vv_status put_lists(reader *r, cells *c, const double *offset, const vvi_vtk_array *connectivity, size_t n,
                           bool strip)
{
    double *index;
    const double all = offset[n - 1];
    for (size_t i = 0; i < n; i++)
        if (!(offset[i] >= (i ? offset[i - 1] : 0)))
            return vv_fail_at(VV_E_FORMAT, r->file.name, NULL, "its polygon offsets decrease at %zu", i);
    if (!(all < (double)UINT32_MAX * 4))
        return vv_fail_at(VV_E_FORMAT, r->file.name, NULL, "its polygons have too many corners");
    vv_status st = numbers(&index, r, connectivity, (uint64_t)all);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        const size_t begin = i ? (size_t)offset[i - 1] : 0;
        if (i % 4096 == 0)
            st = vvi_job_poll(r->job);
        if (st == VV_OK && (st = use_cell(c, r)) == VV_OK)
            st = put_cell(r, index ? index + begin : NULL, (size_t)offset[i] - begin, strip);
    }
    vvi_free(index);
    return st;
}

static vv_status put_section(reader *r, cells *c, size_t piece, vvi_vtk_section section, int64_t n)
{
    const vvi_vtk_array *connectivity = find(r, piece, section, "connectivity", 1);
    const vvi_vtk_array *offsets = find(r, piece, section, "offsets", 1);
    double *offset;
    if (n == 0)
        return VV_OK;
    if (!connectivity || !offsets)
        return vv_fail_at(VV_E_FORMAT, r->file.name, NULL, "has polygons without 'connectivity' and 'offsets'");
    vv_status st = numbers(&offset, r, offsets, (uint64_t)n);
    if (st == VV_OK)
        st = put_lists(r, c, offset, connectivity, (size_t)n, section == VVI_VTK_STRIPS);
    vvi_free(offset);
    return st;
}

static vv_status read_piece(reader *r, size_t piece)
{
    const vvi_vtk_piece *p = &r->file.piece[piece];
    cells c;
    if (p->n_points == 0)
        return VV_OK;
    vv_status st = put_points(r, piece, (size_t)p->n_points);
    if (st != VV_OK)
        return st;
    if ((st = open_cells(&c, r, piece)) == VV_OK &&
        (st = put_section(r, &c, piece, VVI_VTK_POLYS, p->n_polys)) == VV_OK)
        st = put_section(r, &c, piece, VVI_VTK_STRIPS, p->n_strips);
    vvi_free(c.part);
    vvi_free(c.color);
    return st;
}

/* What our own writer noted: unit, space, names of parts. */
static vv_status take_notes(reader *r)
{
    vv_field_info info = vv_field_info_default();
    vv_notes *own;
    const char *key, *value;
    info.grid.unit[0] = 0;
    vv_status st = vvi_notes_new(&own, r->job);
    if (st != VV_OK)
        return st;
    st = vvi_vtk_read_notes(&info, &r->file, r->source, own, r->job);
    if (info.grid.unit[0])
        memcpy(r->b.info.unit, info.grid.unit, sizeof r->b.info.unit);
    memcpy(r->b.info.value_unit, info.value_unit, sizeof r->b.info.value_unit);
    r->b.info.space = info.grid.space;
    for (size_t i = 0; st == VV_OK && vvi_notes_get(own, i, &key, &value); i++) {
        if (strncmp(key, "volvis part ", 12) == 0) {
            /* the first letter keeps names that are empty */
            st = vvi_mesh_builder_new_part(&r->b, value + 1, strlen(value) - 1, NULL, 0);
            r->n_named++;
        } else if (strcmp(key, "volvis up") == 0) {
            r->b.info.up = strcmp(value, "y") == 0 ? VV_UP_Y : VV_UP_Z;
        } else {
            st = vvi_notes_add(r->notes, key, value);
        }
    }
    vvi_notes_free(own);
    return st;
}

static vv_status read_vtp(vv_mesh **out, vv_source *source, const vv_mesh_read_options *options, vv_notes *notes,
                          vv_job *job)
{
    reader r = {.source = source, .notes = notes, .job = job};
    vvi_mesh_builder_begin(&r.b, source, options, true, job);
    vv_status st = vvi_vtk_parse(&r.file, "PolyData", source, job);
    if (st == VV_OK)
        st = take_notes(&r);
    for (size_t p = 0; p < r.file.n_pieces && st == VV_OK; p++)
        st = read_piece(&r, p);
    if (st == VV_OK && (st = vvi_face_colors_finish(&r.colors, &r.b, notes)) == VV_OK)
        st = vvi_mesh_builder_finish(out, &r.b, notes);
    vvi_mesh_builder_free(&r.b);
    vvi_face_colors_free(&r.colors);
    vvi_vtk_finish(&r.file);
    vvi_free(r.corner);
    return st;
}

static int probe(const uint8_t *head, size_t n, const char *path)
{
    (void)path;
    return memmem(head, n, "<VTKFile", 8) && memmem(head, n, "\"PolyData\"", 10) ? 2 : 0;
}

static const char *const suffixes[] = {".vtp", NULL};
static const char *const encodings[] = {"raw", "base64", "ascii", NULL};

const vv_mesh_format vvi_mesh_format_vtp = {
    .api = VV_MESH_FORMAT_API,
    .name = "vtp",
    .doc = "VTK XML polygons: normals, values, colours, parts; text, base64 or raw; zlib, LZ4 and LZMA are read",
    .suffixes = suffixes,
    .encodings = encodings,
    .holds = VV_MESH_HOLDS_NORMALS | VV_MESH_HOLDS_VALUES | VV_MESH_HOLDS_COLORS | VV_MESH_HOLDS_PARTS |
             VV_MESH_HOLDS_PART_COLORS | VV_MESH_HOLDS_UNIT | VV_MESH_HOLDS_DOUBLES,
    .probe = probe,
    .read = read_vtp,
    .write = vvi_vtp_write,
};
