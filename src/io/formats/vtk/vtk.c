/* VTK's old files, .vtk: structured points and rectilinear grids, as text or big-endian bytes, versions 1 to 5. */
#include "core/limits.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/formats/vtk/vtk_legacy.h"
#include "io/scan.h"
#include "registry.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#define WORDS_MOST 12

static const char magic[] = "# vtk DataFile Version";

static int probe(const uint8_t *head, size_t n, const char *path)
{
    return n >= sizeof magic - 1 && strncasecmp((const char *)head, magic, sizeof magic - 1) == 0 ? 2 : 0;
}

/* Three lines that every file has, and the kind of its grid. */
static vv_status read_start(vvi_vtk_lines *p, vv_notes *notes)
{
    const char *line;
    bool end;
    char *word[WORDS_MOST];
    int n;
    vv_status st = vvi_source_line(p->source, &line, 1024, &end);
    if (st == VV_OK && strncasecmp(line, magic, sizeof magic - 1) != 0)
        st = vv_fail_at(VV_E_FORMAT, p->file->name, "1", "expected '%s'", magic);
    if (st == VV_OK)
        st = vvi_source_line(p->source, &line, 64 << 10, &end);
    if (st == VV_OK && line[strspn(line, " \t")])
        st = vvi_notes_add(notes, "title", line);
    if (st != VV_OK || (st = vvi_vtk_words(p, word, WORDS_MOST, &n)) != VV_OK)
        return st;
    p->binary = n > 0 && strcasecmp(word[0], "BINARY") == 0;
    if (!p->binary && (n == 0 || strcasecmp(word[0], "ASCII") != 0))
        return vv_fail_at(VV_E_FORMAT, p->file->name, "3", "expected ASCII or BINARY, found '%.40s'", n ? word[0] : "");
    if ((st = vvi_vtk_words(p, word, WORDS_MOST, &n)) != VV_OK)
        return st;
    if (n < 2 || strcasecmp(word[0], "DATASET") != 0)
        return vv_fail_at(VV_E_FORMAT, p->file->name, "4", "expected DATASET and its kind, found '%.40s'",
                          n ? word[0] : "");
    p->file->rectilinear = strcasecmp(word[1], "RECTILINEAR_GRID") == 0;
    if (p->file->rectilinear || strcasecmp(word[1], "STRUCTURED_POINTS") == 0)
        return VV_OK;
    if (strcasecmp(word[1], "POLYDATA") == 0)
        return vv_fail_at(VV_E_UNSUPPORTED, p->file->name, NULL,
                          "holds POLYDATA, a mesh, which is not read from .vtk; save it as .vtp or .ply "
                          "(ParaView: File, Save Data)");
    return vv_fail_at(
        VV_E_UNSUPPORTED, p->file->name, NULL,
        "holds %.40s, which is not a regular grid; resample it to an image first (ParaView: Resample To Image)",
        word[1]);
}

static vv_status fail_line(const vvi_vtk_lines *p, const char *word, const char *text)
{
    return vv_fail_at(VV_E_FORMAT, p->file->name, NULL, "%.40s %s", word, text);
}

static vv_status read_dimensions(vvi_vtk_lines *p, char **word, int n)
{
    vvi_vtk_file *file = p->file;
    p->n[0] = p->n[1] = 1;
    for (int a = 0; a < 3; a++) {
        int64_t size;
        const char *end;
        if (n < 4 || !vvi_scan_int(&size, word[a + 1], &end) || *end || size < 1 || size > INT32_MAX ||
            p->n[0] > (INT64_C(1) << 60) / size)
            return fail_line(p, word[0], "needs three whole numbers, at least 1 each");
        file->whole[2 * a] = 0;
        file->whole[2 * a + 1] = size - 1;
        p->n[0] *= size;
        p->n[1] *= size > 1 ? size - 1 : 1;
    }
    if (file->n_pieces > 0)
        return fail_line(p, word[0], "appears twice");
    file->piece = vvi_alloc(p->job, sizeof *file->piece, VVI_MEM_MODEL);
    if (!file->piece)
        return vv_fail_memory(sizeof *file->piece);
    memcpy(file->piece->extent, file->whole, sizeof file->whole);
    file->n_pieces = 1;
    return VV_OK;
}

static vv_status read_three(const vvi_vtk_lines *p, double out[3], char **word, int n)
{
    for (int a = 0; a < 3; a++) {
        const char *end;
        if (n < 4 || !vvi_scan_real(&out[a], word[a + 1], &end) || *end || !isfinite(out[a]))
            return fail_line(p, word[0], "needs three finite numbers");
    }
    return VV_OK;
}

static vv_status read_coordinates(vvi_vtk_lines *p, char **word, int n_words)
{
    vvi_vtk_array a = {.section = VVI_VTK_COORDINATES, .components = 1};
    const int axis = word[0][0] == 'X' || word[0][0] == 'x' ? 0 : word[0][0] == 'Y' || word[0][0] == 'y' ? 1 : 2;
    int64_t n;
    int before = 0;
    const char *end;
    for (size_t i = 0; i < p->file->n_arrays; i++)
        before += p->file->array[i].section == VVI_VTK_COORDINATES;
    if (before != axis || p->file->n_pieces == 0)
        return fail_line(p, word[0], "stands out of order; DIMENSIONS, X_, Y_ and Z_COORDINATES follow each other");
    if (n_words < 3 || !vvi_scan_int(&n, word[1], &end) || *end || n != p->file->whole[2 * axis + 1] + 1)
        return fail_line(p, word[0], "needs as many coordinates as the DIMENSIONS say, and a type");
    return vvi_vtk_take_array(p, &a, word[0], word[2], (uint64_t)n);
}

static vv_status begin_section(vvi_vtk_lines *p, char **word, int n_words)
{
    const bool cells = strcasecmp(word[0], "CELL_DATA") == 0;
    int64_t n;
    const char *end;
    if (p->file->n_pieces == 0)
        return fail_line(p, word[0], "comes before DIMENSIONS");
    if (n_words < 2 || !vvi_scan_int(&n, word[1], &end) || *end || n != p->n[cells])
        return vv_fail_at(VV_E_FORMAT, p->file->name, NULL, "%.40s is %.40s but the grid has %lld", word[0],
                          n_words > 1 ? word[1] : "nothing", (long long)p->n[cells]);
    p->section = cells ? VVI_VTK_CELLS : VVI_VTK_POINTS;
    p->n_here = n;
    p->scalars = p->vectors = false;
    return VV_OK;
}

static vv_status read_statement(vvi_vtk_lines *p, bool *known, char **word, int n)
{
    *known = true;
    if (strcasecmp(word[0], "POINT_DATA") == 0 || strcasecmp(word[0], "CELL_DATA") == 0)
        return begin_section(p, word, n);
    if (strcasecmp(word[0], "DIMENSIONS") == 0)
        return read_dimensions(p, word, n);
    if (!p->file->rectilinear && strcasecmp(word[0], "ORIGIN") == 0)
        return read_three(p, p->file->origin, word, n);
    if (!p->file->rectilinear && (strcasecmp(word[0], "SPACING") == 0 || strcasecmp(word[0], "ASPECT_RATIO") == 0)) {
        p->file->has_spacing = true;
        return read_three(p, p->file->spacing, word, n);
    }
    if (p->file->rectilinear && strlen(word[0]) == 13 && strcasecmp(word[0] + 1, "_COORDINATES") == 0)
        return read_coordinates(p, word, n);
    return vvi_vtk_attribute(p, known, word, n);
}

/* What stands behind something that is not understood is not looked for: data might look like anything. */
static vv_status read_statements(vvi_vtk_lines *p, vv_notes *notes)
{
    char *word[WORDS_MOST];
    int n;
    bool known = true;
    vv_status st = VV_OK;
    while (st == VV_OK && !p->over && (st = vvi_vtk_words(p, word, WORDS_MOST, &n)) == VV_OK && n > 0) {
        char first[64];
        snprintf(first, sizeof first, "%s", word[0]);
        vvi_text_clean(first);
        st = read_statement(p, &known, word, n);
        if (st == VV_OK && !known)
            return p->n_here > 0 ? vvi_notes_warn(notes, "'%.40s' is not understood; what follows is left out", first)
                                 : fail_line(p, first, "is not a known statement of a VTK file");
    }
    return st;
}

static vv_status parse(vvi_vtk_file *file, vv_source *source, vv_notes *notes, vv_job *job)
{
    *file = (vvi_vtk_file){.name = vvi_source_name(source),
                           .big_endian = true,
                           .spacing = {1, 1, 1},
                           .direction = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    vvi_vtk_lines p = {.source = source, .job = job, .file = file, .section = VVI_VTK_FIELD};
    vv_status st = read_start(&p, notes);
    if (st == VV_OK)
        st = read_statements(&p, notes);
    if (st == VV_OK && file->n_pieces == 0)
        st = vv_fail_at(VV_E_FORMAT, file->name, NULL, "has no DIMENSIONS; the file is cut short or its header wrong");
    return st;
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    return vvi_vtk_read_header(info, plan_out, parse, source, options, notes, job);
}

static const char *const suffixes[] = {".vtk", NULL};

const vv_format vvi_format_vtk = {
    .api = VV_FORMAT_API,
    .name = "vtk",
    .doc = "VTK's old files: structured points and rectilinear grids, text or binary; arrays are parts",
    .suffixes = suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = vvi_vtk_free_plan,
    .read = vvi_vtk_read,
    .mappable = vvi_vtk_mappable,
};
