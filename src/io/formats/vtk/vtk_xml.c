/* The tags of VTK's XML files. Data are not looked at: only where they lie is kept. */
#include "io/formats/vtk/vtk_xml.h"
#include "core/limits.h"
#include "core/memory.h"
#include "io/scan.h"
#include "io/xml.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct parse {
    vvi_vtk_file *file;
    const char *kind;
    vv_source *source;
    vv_job *job;
    vvi_vtk_section section;
    char *scalars, *vectors, *normals; /* names of the active arrays of the section */
    bool in_array, has_text, has_kind, has_grid;
    int array_depth;
    size_t piece_room;
    uint64_t appended; /* first byte after the tag; 0: there is none */
    bool appended_base64;
} parse;

static vv_status fail_tag(const parse *p, const vvi_xml *xml, vv_status status, const char *tag, const char *text,
                          const char *value)
{
    char line[32];
    snprintf(line, sizeof line, "%lu", vvi_xml_line(xml));
    return vv_fail_at(status, vvi_source_name(p->source), line, "<%s> %s '%.60s'", tag, text, value ? value : "");
}

static bool scan_reals(double *out, int n, const char *text)
{
    for (int i = 0; i < n; i++) {
        while (isspace((unsigned char)*text))
            text++;
        if (!vvi_scan_real(&out[i], text, &text) || !isfinite(out[i]))
            return false;
    }
    return true;
}

static bool scan_extent(int64_t out[6], const char *text)
{
    for (int i = 0; i < 6; i++) {
        while (isspace((unsigned char)*text))
            text++;
        if (!vvi_scan_int(&out[i], text, &text) || out[i] < INT32_MIN || out[i] > INT32_MAX)
            return false;
    }
    for (int a = 0; a < 3; a++)
        if (out[2 * a + 1] < out[2 * a])
            return false;
    return true;
}

/* <VTKFile> ------------------------------------------------------------------------------------------------------- */

static vvi_vtk_compressor compressor_of(const char *name)
{
    static const struct {
        const char *name;
        vvi_vtk_compressor compressor;
    } known[] = {{"vtkZLibDataCompressor", VVI_VTK_ZLIB},
                 {"vtkLZ4DataCompressor", VVI_VTK_LZ4},
                 {"vtkLZMADataCompressor", VVI_VTK_LZMA}};
    if (!name || !*name)
        return VVI_VTK_PLAIN;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(known[i].name, name) == 0)
            return known[i].compressor;
    return VVI_VTK_UNKNOWN;
}

static vv_status refuse_kind(const parse *p, const char *type)
{
    const char *name = vvi_source_name(p->source);
    if (type[0] == 'P' && isupper((unsigned char)type[1]) && strncmp(type, "PolyData", 8) != 0)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "names pieces that lie in other files (%.40s); open one of those, or write them as one .vti",
                          type);
    if (p->file->polygons)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "holds %.40s, not PolyData", type);
    return vv_fail_at(
        VV_E_UNSUPPORTED, name, NULL,
        "holds %.40s, which is not a regular grid; resample it to an image first (ParaView: Resample To Image)", type);
}

static vv_status open_file(parse *p, const vvi_xml *xml, const char *const *attributes)
{
    const char *type = vvi_xml_attribute(attributes, "type"), *order = vvi_xml_attribute(attributes, "byte_order");
    const char *word = vvi_xml_attribute(attributes, "header_type");
    const char *compressor = vvi_xml_attribute(attributes, "compressor");
    if (!type)
        return fail_tag(p, xml, VV_E_FORMAT, "VTKFile", "has no 'type'", NULL);
    if (strcmp(type, p->kind) != 0)
        return refuse_kind(p, type);
    p->has_kind = true;
    if (order && strcmp(order, "BigEndian") != 0 && strcmp(order, "LittleEndian") != 0)
        return fail_tag(p, xml, VV_E_FORMAT, "VTKFile", "has the unknown 'byte_order'", order);
    p->file->big_endian = order && strcmp(order, "BigEndian") == 0;
    if (word && strcmp(word, "UInt32") != 0 && strcmp(word, "UInt64") != 0)
        return fail_tag(p, xml, VV_E_FORMAT, "VTKFile", "has the unknown 'header_type'", word);
    p->file->word = word && strcmp(word, "UInt64") == 0 ? 8 : 4;
    p->file->compressor = compressor_of(compressor);
    if (p->file->compressor == VVI_VTK_UNKNOWN)
        return fail_tag(p, xml, VV_E_UNSUPPORTED, "VTKFile",
                        "is compressed by something other than zlib, LZ4 and LZMA:", compressor);
    return VV_OK;
}

/* <ImageData>, <RectilinearGrid>, <Piece> -------------------------------------------------------------------------- */

static vv_status open_grid(parse *p, const vvi_xml *xml, const char *tag, const char *const *attributes)
{
    const char *whole = vvi_xml_attribute(attributes, "WholeExtent"), *origin = vvi_xml_attribute(attributes, "Origin");
    const char *spacing = vvi_xml_attribute(attributes, "Spacing");
    const char *direction = vvi_xml_attribute(attributes, "Direction");
    if (p->has_grid)
        return fail_tag(p, xml, VV_E_FORMAT, tag, "appears twice", NULL);
    p->has_grid = true;
    if (p->file->polygons)
        return VV_OK;
    if (!whole || !scan_extent(p->file->whole, whole))
        return fail_tag(p, xml, VV_E_FORMAT, tag, "needs a 'WholeExtent' of six whole numbers, first to last; found",
                        whole);
    if (origin && !scan_reals(p->file->origin, 3, origin))
        return fail_tag(p, xml, VV_E_FORMAT, tag, "needs three finite numbers as 'Origin'; found", origin);
    if (spacing && !scan_reals(p->file->spacing, 3, spacing))
        return fail_tag(p, xml, VV_E_FORMAT, tag, "needs three finite numbers as 'Spacing'; found", spacing);
    if (direction && !scan_reals(p->file->direction, 9, direction))
        return fail_tag(p, xml, VV_E_FORMAT, tag, "needs nine finite numbers as 'Direction'; found", direction);
    p->file->has_spacing = spacing != NULL;
    return VV_OK;
}

/* Numbers of things in a piece of polygons; not there: none. */
static vv_status scan_counts(parse *p, const vvi_xml *xml, vvi_vtk_piece *piece, const char *const *attributes)
{
    static const char *const names[] = {"NumberOfPoints", "NumberOfVerts", "NumberOfLines", "NumberOfPolys",
                                        "NumberOfStrips"};
    int64_t n[5] = {0};
    for (int i = 0; i < 5; i++) {
        const char *text = vvi_xml_attribute(attributes, names[i]), *end;
        if (text && (!vvi_scan_int(&n[i], text, &end) || *end || n[i] < 0 || n[i] >= UINT32_MAX))
            return fail_tag(p, xml, VV_E_FORMAT, "Piece", names[i], text);
    }
    piece->n_points = n[0];
    piece->n_before = n[1] + n[2];
    piece->n_polys = n[3];
    piece->n_strips = n[4];
    return VV_OK;
}

static vv_status open_piece(parse *p, const vvi_xml *xml, const char *const *attributes)
{
    vvi_vtk_file *file = p->file;
    const char *extent = vvi_xml_attribute(attributes, "Extent");
    vv_status st = vvi_vtk_grow(&file->piece, file->n_pieces, &p->piece_room, sizeof *file->piece, p->job);
    if (st != VV_OK)
        return st;
    vvi_vtk_piece piece = {0};
    if ((st = scan_counts(p, xml, &piece, attributes)) != VV_OK)
        return st;
    memcpy(piece.extent, file->whole, sizeof piece.extent);
    if (extent && !scan_extent(piece.extent, extent))
        return fail_tag(p, xml, VV_E_FORMAT, "Piece", "needs an 'Extent' of six whole numbers, first to last; found",
                        extent);
    for (int a = 0; a < 3; a++)
        if (piece.extent[2 * a] < file->whole[2 * a] || piece.extent[2 * a + 1] > file->whole[2 * a + 1])
            return fail_tag(p, xml, VV_E_FORMAT, "Piece", "lies outside the WholeExtent:", extent);
    if (file->n_pieces >= vvi_job_limits(p->job)->files)
        return fail_tag(p, xml, VV_E_LIMIT, "Piece", "is one too many; --limit files=N allows more", NULL);
    file->piece[file->n_pieces++] = piece;
    return VV_OK;
}

static vv_status open_section(parse *p, vvi_vtk_section section, const char *const *attributes)
{
    p->section = section;
    vv_status st = vvi_vtk_copy_text(&p->scalars, vvi_xml_attribute(attributes, "Scalars"), p->job);
    if (st == VV_OK)
        st = vvi_vtk_copy_text(&p->vectors, vvi_xml_attribute(attributes, "Vectors"), p->job);
    if (st == VV_OK)
        st = vvi_vtk_copy_text(&p->normals, vvi_xml_attribute(attributes, "Normals"), p->job);
    return st;
}

/* <DataArray> ----------------------------------------------------------------------------------------------------- */

static bool type_of(vv_type *out, const char *name)
{
    static const struct {
        const char *name;
        vv_type type;
    } types[] = {{"UInt8", VV_TYPE_U8},    {"Int8", VV_TYPE_I8},     {"UInt16", VV_TYPE_U16}, {"Int16", VV_TYPE_I16},
                 {"UInt32", VV_TYPE_U32},  {"Int32", VV_TYPE_I32},   {"UInt64", VV_TYPE_U64}, {"Int64", VV_TYPE_I64},
                 {"Float32", VV_TYPE_F32}, {"Float64", VV_TYPE_F64}, {"Bit", VV_TYPE_U8}};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strcmp(types[i].name, name) == 0) {
            *out = types[i].type;
            return true;
        }
    return false;
}

static vv_status scan_form(const parse *p, vvi_vtk_array *a, const vvi_xml *xml, const char *const *attributes)
{
    const char *format = vvi_xml_attribute(attributes, "format"), *offset = vvi_xml_attribute(attributes, "offset");
    const char *end;
    if (!format || strcmp(format, "ascii") == 0) {
        a->form = VVI_VTK_TEXT;
    } else if (strcmp(format, "binary") == 0) {
        a->form = VVI_VTK_BASE64;
    } else if (strcmp(format, "appended") == 0) {
        a->appended = true;
        if (!offset || !vvi_scan_uint(&a->begin, offset, &end) || *end)
            return fail_tag(p, xml, VV_E_FORMAT, "DataArray",
                            "is appended but its 'offset' is not a whole number:", offset);
    } else {
        return fail_tag(p, xml, VV_E_FORMAT, "DataArray", "has the unknown 'format'", format);
    }
    return VV_OK;
}

static vv_status open_array(parse *p, vvi_xml *xml, const char *const *attributes)
{
    vvi_vtk_file *file = p->file;
    vvi_vtk_array a = {.section = p->section, .piece = file->n_pieces - (p->section != VVI_VTK_FIELD), .components = 1};
    const char *type = vvi_xml_attribute(attributes, "type"), *name = vvi_xml_attribute(attributes, "Name");
    const char *n = vvi_xml_attribute(attributes, "NumberOfComponents"), *end;
    const char *tuples = vvi_xml_attribute(attributes, "NumberOfTuples");
    int64_t components = 1;
    if (p->in_array)
        return fail_tag(p, xml, VV_E_FORMAT, "DataArray", "lies in another", NULL);
    if (!type)
        return fail_tag(p, xml, VV_E_FORMAT, "DataArray", "has no 'type'", NULL);
    if (n && (!vvi_scan_int(&components, n, &end) || *end || components < 0 || components > 4096))
        return fail_tag(p, xml, VV_E_FORMAT, "DataArray", "needs 'NumberOfComponents' from 1 to 4096; found", n);
    a.components = components > 0 ? (int)components : 1; /* some writers say 0 for one */
    if (tuples && (!vvi_scan_int(&a.tuples, tuples, &end) || *end || a.tuples < 0))
        return fail_tag(p, xml, VV_E_FORMAT, "DataArray", "needs a whole number as 'NumberOfTuples'; found", tuples);
    a.has_type = type_of(&a.type, type);
    a.bits = strcmp(type, "Bit") == 0;
    a.scalars = name && *name && strcmp(name, p->scalars) == 0;
    a.vectors = name && *name && (strcmp(name, p->vectors) == 0 || strcmp(name, p->normals) == 0);
    vv_status st = scan_form(p, &a, xml, attributes);
    if (st == VV_OK)
        st = vvi_vtk_add_array(file, &a, name, type, p->job);
    p->in_array = true;
    p->has_text = false;
    p->array_depth = vvi_xml_depth(xml);
    return st;
}

/* Data in place end where the next tag begins, be it the array's own end or information that stands in it. */
static void end_text(parse *p, const vvi_xml *xml)
{
    if (!p->in_array || p->file->array[p->file->n_arrays - 1].appended)
        return;
    vvi_vtk_array *a = &p->file->array[p->file->n_arrays - 1];
    if (p->has_text && a->end == 0)
        a->end = vvi_xml_begin(xml);
}

static vv_status on_text(void *user, vvi_xml *xml, const char *text, size_t n)
{
    parse *p = user;
    size_t blanks = 0;
    if (!p->in_array || p->has_text || vvi_xml_depth(xml) != p->array_depth)
        return VV_OK;
    vvi_vtk_array *a = &p->file->array[p->file->n_arrays - 1];
    while (blanks < n && isspace((unsigned char)text[blanks]))
        blanks++;
    if (blanks == n || a->appended)
        return VV_OK;
    p->has_text = true;
    a->begin = vvi_xml_begin(xml) + blanks;
    return VV_OK;
}

/* The document ------------------------------------------------------------------------------------------------------
 */

static vv_status open_appended(parse *p, vvi_xml *xml, const char *const *attributes)
{
    const char *encoding = vvi_xml_attribute(attributes, "encoding");
    if (!encoding || (strcmp(encoding, "raw") != 0 && strcmp(encoding, "base64") != 0))
        return fail_tag(p, xml, VV_E_FORMAT, "AppendedData", "has no 'encoding' that is raw or base64:", encoding);
    p->appended = vvi_xml_end(xml);
    p->appended_base64 = strcmp(encoding, "base64") == 0;
    vvi_xml_stop(xml); /* what follows may be no XML */
    return VV_OK;
}

static vvi_vtk_section polygon_section(const char *name)
{
    return strcmp(name, "Points") == 0   ? VVI_VTK_PLACES
           : strcmp(name, "Polys") == 0  ? VVI_VTK_POLYS
           : strcmp(name, "Strips") == 0 ? VVI_VTK_STRIPS
                                         : VVI_VTK_NOWHERE;
}

static vv_status on_open(void *user, vvi_xml *xml, const char *name, const char *const *attributes)
{
    parse *p = user;
    end_text(p, xml);
    if (!p->has_kind)
        return strcmp(name, "VTKFile") == 0
                   ? open_file(p, xml, attributes)
                   : fail_tag(p, xml, VV_E_FORMAT, name, "begins a file of another kind than VTK's", NULL);
    if (strcmp(name, p->kind) == 0)
        return open_grid(p, xml, name, attributes);
    if (strcmp(name, "FieldData") == 0)
        return open_section(p, VVI_VTK_FIELD, attributes);
    if (strcmp(name, "AppendedData") == 0)
        return open_appended(p, xml, attributes);
    if (strcmp(name, "Piece") == 0)
        return p->has_grid ? open_piece(p, xml, attributes)
                           : fail_tag(p, xml, VV_E_FORMAT, name, "lies outside the grid", NULL);
    if (p->file->n_pieces > 0 && strcmp(name, "PointData") == 0)
        return open_section(p, VVI_VTK_POINTS, attributes);
    if (p->file->n_pieces > 0 && strcmp(name, "CellData") == 0)
        return open_section(p, VVI_VTK_CELLS, attributes);
    if (p->file->n_pieces > 0 && strcmp(name, "Coordinates") == 0)
        return open_section(p, VVI_VTK_COORDINATES, attributes);
    if (p->file->n_pieces > 0 && p->file->polygons && polygon_section(name) != VVI_VTK_NOWHERE)
        return open_section(p, polygon_section(name), attributes);
    if ((strcmp(name, "DataArray") == 0 || strcmp(name, "Array") == 0) && p->section != VVI_VTK_NOWHERE)
        return open_array(p, xml, attributes);
    return VV_OK;
}

static vv_status on_close(void *user, vvi_xml *xml, const char *name)
{
    parse *p = user;
    end_text(p, xml);
    if (p->in_array && vvi_xml_depth(xml) == p->array_depth)
        p->in_array = false;
    else if (strcmp(name, "FieldData") == 0 || strcmp(name, "PointData") == 0 || strcmp(name, "CellData") == 0 ||
             strcmp(name, "Coordinates") == 0 || (p->file->polygons && polygon_section(name) != VVI_VTK_NOWHERE))
        p->section = VVI_VTK_NOWHERE;
    return VV_OK;
}

/* Where the data behind the mark '_' begin. */
static vv_status find_mark(uint64_t *out, const parse *p)
{
    vv_status st = vvi_source_seek(p->source, p->appended);
    char c = ' ';
    size_t n = 1;
    while (st == VV_OK && n == 1 && isspace((unsigned char)c))
        st = vvi_source_read_some(p->source, &c, 1, &n);
    if (st == VV_OK && (n == 0 || c != '_'))
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(p->source), NULL,
                          "has no mark '_' before its appended data; the file is cut short or its header wrong");
    *out = vvi_source_tell(p->source);
    return st;
}

/* Offsets of appended data count from the mark; data in place are cut with the file. */
static vv_status settle_arrays(parse *p)
{
    uint64_t mark = 0;
    bool exact;
    vv_status st = p->appended ? find_mark(&mark, p) : VV_OK;
    if (st != VV_OK)
        return st;
    const uint64_t all = vvi_source_tell(p->source) + vvi_source_left(p->source, &exact);
    for (size_t i = 0; i < p->file->n_arrays; i++) {
        vvi_vtk_array *a = &p->file->array[i];
        if (a->appended && (!p->appended || a->begin > all - mark))
            return vv_fail_at(VV_E_FORMAT, p->file->name, NULL, "its array '%.60s' lies at offset %llu, %s", a->name,
                              (unsigned long long)a->begin,
                              p->appended ? "past the end of the file" : "but nothing is appended");
        if (a->appended) {
            a->form = p->appended_base64 ? VVI_VTK_BASE64 : VVI_VTK_RAW;
            a->begin += mark;
            a->end = all;
        } else if (a->end == 0) {
            a->end = a->begin ? all : 0;
        }
    }
    return VV_OK;
}

static vv_status check_document(const parse *p)
{
    const char *name = vvi_source_name(p->source);
    if (!p->has_grid || p->file->n_pieces == 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "has no <%s> with a <Piece> in it", p->kind);
    if (p->file->cut && !p->in_array)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "is cut short: it ends before its data");
    return VV_OK;
}

vv_status vvi_vtk_parse(vvi_vtk_file *file, const char *kind, vv_source *source, vv_job *job)
{
    static const vvi_xml_events events = {on_open, on_close, on_text};
    *file = (vvi_vtk_file){
        .name = vvi_source_name(source), .word = 4, .spacing = {1, 1, 1}, .direction = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    parse p = {.file = file, .kind = kind, .source = source, .job = job, .section = VVI_VTK_NOWHERE};
    file->rectilinear = strcmp(kind, "RectilinearGrid") == 0;
    file->polygons = strcmp(kind, "PolyData") == 0;
    vv_status st = vvi_xml_parse(&file->cut, source, &events, &p, job);
    if (st == VV_OK)
        st = check_document(&p);
    if (st == VV_OK)
        st = settle_arrays(&p);
    vvi_free(p.scalars);
    vvi_free(p.vectors);
    vvi_free(p.normals);
    return st;
}
