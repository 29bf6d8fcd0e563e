/* Arrays of VTK's old files: the statements that begin them, and where their data end. */
#include "io/formats/vtk/vtk_legacy.h"
#include "core/memory.h"
#include "io/number_text.h"
#include "io/scan.h"
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#define LINE_MOST ((size_t)64 << 10)

static vv_status fail_here(const vvi_vtk_lines *p, vv_status status, const char *statement, const char *text)
{
    char where[32];
    snprintf(where, sizeof where, "byte %llu", (unsigned long long)vvi_source_tell(p->source));
    return vv_fail_at(status, p->file->name, where, "%.40s %s", statement, text);
}

vv_status vvi_vtk_words(vvi_vtk_lines *p, char **word, int most, int *n_words)
{
    const char *line;
    bool end = false;
    *n_words = 0;
    while (!end && *n_words == 0) {
        vv_status st = vvi_source_line(p->source, &line, LINE_MOST, &end);
        if (st != VV_OK)
            return st;
        char *at = (char *)(uintptr_t)line; /* the source's own buffer, ours until the next line */
        while (*n_words < most && *(at += strspn(at, " \t\r\f\v"))) {
            word[(*n_words)++] = at;
            at += strcspn(at, " \t\r\f\v");
            if (*at)
                *at++ = 0;
        }
    }
    return VV_OK;
}

/* Types -------------------------------------------------------------------------------------------------------------
 */

static bool type_of(vv_type *out, const char *name)
{
    static const struct {
        const char *name;
        vv_type type;
    } types[] = {{"unsigned_char", VV_TYPE_U8},
                 {"char", VV_TYPE_I8},
                 {"signed_char", VV_TYPE_I8},
                 {"unsigned_short", VV_TYPE_U16},
                 {"short", VV_TYPE_I16},
                 {"unsigned_int", VV_TYPE_U32},
                 {"int", VV_TYPE_I32},
                 {"vtkidtype", VV_TYPE_I32},
                 {"unsigned_long", VV_TYPE_U64},
                 {"long", VV_TYPE_I64},
                 {"vtktypeuint64", VV_TYPE_U64},
                 {"vtktypeint64", VV_TYPE_I64},
                 {"bit", VV_TYPE_U8},
                 {"float", VV_TYPE_F32},
                 {"double", VV_TYPE_F64}};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strcasecmp(types[i].name, name) == 0) {
            *out = types[i].type;
            return true;
        }
    return false;
}

/* "%20" is a blank: names have none in these files. */
static void decode_name(char *name)
{
    static const char digits[] = "0123456789abcdef";
    char *out = name;
    for (const char *at = name; *at; at++) {
        const char *hi = *at == '%' && at[1] ? strchr(digits, tolower((unsigned char)at[1])) : NULL;
        const char *lo = hi && at[2] ? strchr(digits, tolower((unsigned char)at[2])) : NULL;
        const int c = lo ? (int)(hi - digits) * 16 + (int)(lo - digits) : 0;
        *out++ = c >= 32 ? (char)c : *at;
        if (c >= 32)
            at += 2;
    }
    *out = 0;
}

/* Passing over data ------------------------------------------------------------------------------------------------ */

static vv_status skip_numbers(vvi_vtk_lines *p, vvi_vtk_array *a, uint64_t n)
{
    vvi_number_text *numbers;
    uint64_t got = 0;
    vv_status st = vvi_number_text_open(&numbers, p->source, a->begin, UINT64_MAX, VV_TYPE_F64, p->job);
    if (st != VV_OK)
        return st;
    st = vvi_number_text_skip(numbers, n, &got);
    a->end = vvi_number_text_tell(numbers);
    p->over = got < n;
    vvi_number_text_close(numbers);
    return st == VV_OK ? vvi_source_seek(p->source, a->end) : st;
}

static vv_status skip_bytes(vvi_vtk_lines *p, vvi_vtk_array *a, uint64_t n)
{
    bool exact;
    const uint64_t left = vvi_source_left(p->source, &exact);
    p->over = n > left;
    a->end = a->begin + (p->over ? left : n);
    return vvi_source_seek(p->source, a->end);
}

/* Texts: a line each, or bytes after their length, which the first two bits tell how to read. */
static vv_status skip_texts(vvi_vtk_lines *p, uint64_t n)
{
    vv_status st = VV_OK;
    for (uint64_t i = 0; i < n && st == VV_OK; i++) {
        const char *line;
        uint8_t head[8];
        if (!p->binary) {
            st = vvi_source_line(p->source, &line, LINE_MOST, &p->over);
        } else if ((st = vvi_source_read(p->source, head, 1, "a text")) == VV_OK) {
            const size_t more = ((size_t)1 << (3 - (head[0] >> 6))) - 1;
            uint64_t length = head[0] & 63;
            st = vvi_source_read(p->source, head, more, "a text");
            for (size_t b = 0; b < more; b++)
                length = length << 8 | head[b];
            if (st == VV_OK)
                st = vvi_source_skip(p->source, length);
        }
        if (p->over)
            break;
    }
    return st;
}

vv_status vvi_vtk_take_array(vvi_vtk_lines *p, vvi_vtk_array *a, const char *name, const char *type_name, uint64_t n)
{
    const uint64_t all = n * (uint64_t)a->components;
    a->section = a->section == VVI_VTK_NOWHERE ? p->section : a->section;
    a->form = p->binary ? VVI_VTK_RAW : VVI_VTK_TEXT;
    a->tuples = (int64_t)n;
    a->begin = vvi_source_tell(p->source);
    a->has_type = type_of(&a->type, type_name);
    a->bits = strcasecmp(type_name, "bit") == 0;
    vv_status st = vvi_vtk_add_array(p->file, a, name, type_name, p->job);
    if (st != VV_OK)
        return st;
    a = &p->file->array[p->file->n_arrays - 1];
    decode_name(a->name);
    if (strcasecmp(type_name, "string") == 0) {
        strcpy(a->type_name, "string");
        return skip_texts(p, all);
    }
    if (!a->has_type)
        return fail_here(p, VV_E_UNSUPPORTED, type_name, "is not a known type of numbers");
    if (!p->binary)
        return skip_numbers(p, a, all);
    return skip_bytes(p, a, a->bits ? (all + 7) / 8 : all * vv_type_bytes(a->type));
}

/* Statements --------------------------------------------------------------------------------------------------------
 */

static bool scan_count(int64_t *out, const char *word, int64_t least, int64_t most)
{
    const char *end;
    return word && vvi_scan_int(out, word, &end) && !*end && *out >= least && *out <= most;
}

static bool at_lookup_table(vv_source *source)
{
    size_t n;
    const uint8_t *head = vvi_source_peek(source, 12, &n);
    return head && n == 12 && strncasecmp((const char *)head, "LOOKUP_TABLE", 12) == 0;
}

/* SCALARS name type [components], then the name of a table. */
static vv_status take_scalars(vvi_vtk_lines *p, char **word, int n_words)
{
    vvi_vtk_array a = {.section = VVI_VTK_NOWHERE, .components = 1, .scalars = !p->scalars};
    int64_t components = 1;
    if (n_words < 3 || (n_words > 3 && !scan_count(&components, word[3], 1, 4096)))
        return fail_here(p, VV_E_FORMAT, word[0], "needs a name, a type and perhaps a number of components");
    char name[512], type[64];
    snprintf(name, sizeof name, "%s", word[1]);
    snprintf(type, sizeof type, "%s", word[2]);
    a.components = (int)components;
    if (at_lookup_table(p->source)) {
        char *table[4];
        int n_table;
        vv_status st = vvi_vtk_words(p, table, 4, &n_table);
        if (st != VV_OK)
            return st;
    }
    p->scalars = true;
    return vvi_vtk_take_array(p, &a, name, type, (uint64_t)p->n_here);
}

/* COLOR_SCALARS name components: bytes, or fractions of 1 as text. */
static vv_status take_colors(vvi_vtk_lines *p, char **word, int n_words)
{
    vvi_vtk_array a = {.section = VVI_VTK_NOWHERE, .scalars = !p->scalars, .fractions = !p->binary};
    int64_t components;
    if (n_words < 3 || !scan_count(&components, word[2], 1, 4096))
        return fail_here(p, VV_E_FORMAT, word[0], "needs a name and a number of components");
    a.components = (int)components;
    p->scalars = true;
    return vvi_vtk_take_array(p, &a, word[1], "unsigned_char", (uint64_t)p->n_here);
}

/* A table of colours: nothing that samples have. */
static vv_status pass_table(vvi_vtk_lines *p, char **word, int n_words)
{
    vvi_vtk_array none = {.begin = vvi_source_tell(p->source)};
    int64_t n;
    if (n_words < 3 || !scan_count(&n, word[2], 0, INT32_MAX))
        return fail_here(p, VV_E_FORMAT, word[0], "needs a name and a number of colours");
    return p->binary ? skip_bytes(p, &none, 4 * (uint64_t)n) : skip_numbers(p, &none, 4 * (uint64_t)n);
}

/* METADATA: lines up to a blank one. */
static vv_status pass_metadata(vvi_vtk_lines *p)
{
    const char *line;
    bool end = false;
    vv_status st = VV_OK;
    do
        st = vvi_source_line(p->source, &line, LINE_MOST, &end);
    while (st == VV_OK && !end && line[strspn(line, " \t")]);
    return st;
}

/* FIELD name n, then n times: name components tuples type, data. */
static vv_status take_fields(vvi_vtk_lines *p, char **word, int n_words)
{
    int64_t n, components, tuples;
    if (n_words < 3 || !scan_count(&n, word[2], 0, INT32_MAX))
        return fail_here(p, VV_E_FORMAT, word[0], "needs a name and a number of arrays");
    for (int64_t i = 0; i < n && !p->over;) {
        char *w[8];
        int n_w;
        vv_status st = vvi_vtk_words(p, w, 8, &n_w);
        if (st != VV_OK || n_w == 0)
            return st;
        if (strcasecmp(w[0], "METADATA") == 0) {
            if ((st = pass_metadata(p)) != VV_OK)
                return st;
            continue;
        }
        vvi_vtk_array a = {.section = VVI_VTK_NOWHERE};
        if (n_w < 4 || !scan_count(&components, w[1], 0, 4096) || !scan_count(&tuples, w[2], 0, INT64_C(1) << 40))
            return fail_here(p, VV_E_FORMAT, w[0], "needs a number of components, one of tuples, and a type");
        a.components = components > 0 ? (int)components : 1;
        if (p->section != VVI_VTK_FIELD && tuples != p->n_here)
            a.section = VVI_VTK_FIELD; /* as many as it likes, but not on the samples */
        if ((st = vvi_vtk_take_array(p, &a, w[0], w[3], components ? (uint64_t)tuples : 0)) != VV_OK)
            return st;
        i++;
    }
    return VV_OK;
}

/* NAME name type, with a fixed number of components. */
static vv_status take_fixed(vvi_vtk_lines *p, char **word, int n_words, int components, bool vectors)
{
    vvi_vtk_array a = {.section = VVI_VTK_NOWHERE, .components = components, .vectors = vectors && !p->vectors};
    if (n_words < 3)
        return fail_here(p, VV_E_FORMAT, word[0], "needs a name and a type");
    p->vectors = p->vectors || vectors;
    return vvi_vtk_take_array(p, &a, word[1], word[2], (uint64_t)p->n_here);
}

static vv_status take_coordinates(vvi_vtk_lines *p, char **word, int n_words)
{
    vvi_vtk_array a = {.section = VVI_VTK_NOWHERE};
    int64_t components;
    if (n_words < 4 || !scan_count(&components, word[2], 1, 3))
        return fail_here(p, VV_E_FORMAT, word[0], "needs a name, 1 to 3 components and a type");
    a.components = (int)components;
    return vvi_vtk_take_array(p, &a, word[1], word[3], (uint64_t)p->n_here);
}

vv_status vvi_vtk_attribute(vvi_vtk_lines *p, bool *known_out, char **word, int n_words)
{
    static const struct {
        const char *name;
        int components;
        bool vectors;
    } fixed[] = {{"VECTORS", 3, true},     {"NORMALS", 3, true},       {"TENSORS", 9, false},   {"TENSORS6", 6, false},
                 {"GLOBAL_IDS", 1, false}, {"PEDIGREE_IDS", 1, false}, {"EDGE_FLAGS", 1, false}};
    *known_out = true;
    if (strcasecmp(word[0], "METADATA") == 0)
        return pass_metadata(p);
    if (strcasecmp(word[0], "FIELD") == 0)
        return take_fields(p, word, n_words);
    if (strcasecmp(word[0], "LOOKUP_TABLE") == 0)
        return pass_table(p, word, n_words);
    *known_out = p->section == VVI_VTK_POINTS || p->section == VVI_VTK_CELLS;
    if (!*known_out)
        return VV_OK;
    if (strcasecmp(word[0], "SCALARS") == 0)
        return take_scalars(p, word, n_words);
    if (strcasecmp(word[0], "COLOR_SCALARS") == 0)
        return take_colors(p, word, n_words);
    if (strcasecmp(word[0], "TEXTURE_COORDINATES") == 0)
        return take_coordinates(p, word, n_words);
    for (size_t i = 0; i < sizeof fixed / sizeof *fixed; i++)
        if (strcasecmp(word[0], fixed[i].name) == 0)
            return take_fixed(p, word, n_words, fixed[i].components, fixed[i].vectors);
    *known_out = false;
    return VV_OK;
}
