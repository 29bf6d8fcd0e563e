/* Text to struct. The lines are collected first and understood in a fixed order afterwards, because the format lets
 * per-axis fields stand before those that they depend on. */
#include "io/data_files.h"
#include "io/formats/nrrd/nrrd_lines.h"
#include "io/scan.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Understanding fields ------------------------------------------------------------------------------------------- */

static vv_status need(const vvi_nrrd_lines *l, enum vvi_nrrd_field field)
{
    return l->text[field]
               ? VV_OK
               : vv_fail_at(VV_E_FORMAT, l->file, NULL, "its header has no field '%s'", vvi_nrrd_field_name(field));
}

vv_status vvi_nrrd_parse_int(int64_t *out, const vvi_nrrd_lines *l, enum vvi_nrrd_field field, int64_t lo, int64_t hi)
{
    const char *end;
    if (!vvi_scan_int(out, l->text[field], &end) || end[strspn(end, " \t")] != 0)
        return vvi_nrrd_fail_line(l, field, "is '%.40s', not a whole number", l->text[field]);
    if (*out < lo || *out > hi)
        return vvi_nrrd_fail_line(l, field, "is %lld; it goes from %lld to %lld", (long long)*out, (long long)lo,
                                  (long long)hi);
    return VV_OK;
}

static vv_status parse_type(vv_type *out, const vvi_nrrd_lines *l)
{
    static const struct {
        const char *name;
        vv_type type;
    } types[] = {
        {"signed char", VV_TYPE_I8},
        {"int8", VV_TYPE_I8},
        {"int8_t", VV_TYPE_I8},
        {"uchar", VV_TYPE_U8},
        {"unsigned char", VV_TYPE_U8},
        {"uint8", VV_TYPE_U8},
        {"uint8_t", VV_TYPE_U8},
        {"short", VV_TYPE_I16},
        {"short int", VV_TYPE_I16},
        {"signed short", VV_TYPE_I16},
        {"signed short int", VV_TYPE_I16},
        {"int16", VV_TYPE_I16},
        {"int16_t", VV_TYPE_I16},
        {"ushort", VV_TYPE_U16},
        {"unsigned short", VV_TYPE_U16},
        {"unsigned short int", VV_TYPE_U16},
        {"uint16", VV_TYPE_U16},
        {"uint16_t", VV_TYPE_U16},
        {"int", VV_TYPE_I32},
        {"signed int", VV_TYPE_I32},
        {"int32", VV_TYPE_I32},
        {"int32_t", VV_TYPE_I32},
        {"uint", VV_TYPE_U32},
        {"unsigned int", VV_TYPE_U32},
        {"uint32", VV_TYPE_U32},
        {"uint32_t", VV_TYPE_U32},
        {"longlong", VV_TYPE_I64},
        {"long long", VV_TYPE_I64},
        {"long long int", VV_TYPE_I64},
        {"signed long long", VV_TYPE_I64},
        {"signed long long int", VV_TYPE_I64},
        {"int64", VV_TYPE_I64},
        {"int64_t", VV_TYPE_I64},
        {"ulonglong", VV_TYPE_U64},
        {"unsigned long long", VV_TYPE_U64},
        {"unsigned long long int", VV_TYPE_U64},
        {"uint64", VV_TYPE_U64},
        {"uint64_t", VV_TYPE_U64},
        {"float", VV_TYPE_F32},
        {"double", VV_TYPE_F64},
    };
    vv_status st = need(l, F_TYPE);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strcasecmp(types[i].name, l->text[F_TYPE]) == 0) {
            *out = types[i].type;
            return VV_OK;
        }
    if (strcasecmp(l->text[F_TYPE], "block") == 0) {
        vvi_nrrd_fail_line(l, F_TYPE, "is 'block': samples that are not numbers; convert them to a numeric type first");
        return vv_fail_in(VV_E_UNSUPPORTED, "NRRD");
    }
    return vvi_nrrd_fail_line(l, F_TYPE,
                              "is '%.40s', which is not a sample type; write for example 'unsigned char' or 'float'",
                              l->text[F_TYPE]);
}

const char *const vvi_nrrd_encodings[] = {"raw", "ascii", "hex", "gzip", "bzip2", "zstd", NULL};

static vv_status parse_encoding(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    static const struct {
        const char *name;
        vvi_nrrd_encoding encoding;
    } known[] = {{"raw", VVI_NRRD_RAW},     {"txt", VVI_NRRD_TEXT}, {"text", VVI_NRRD_TEXT}, {"ascii", VVI_NRRD_TEXT},
                 {"hex", VVI_NRRD_HEX},     {"gz", VVI_NRRD_GZIP},  {"gzip", VVI_NRRD_GZIP}, {"bz2", VVI_NRRD_BZIP2},
                 {"bzip2", VVI_NRRD_BZIP2}, {"zstd", VVI_NRRD_ZSTD}};
    vv_status st = need(l, F_ENCODING);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcasecmp(known[i].name, l->text[F_ENCODING]) == 0) {
            h->encoding = known[i].encoding;
            return VV_OK;
        }
    return vvi_nrrd_fail_line(l, F_ENCODING, "is '%.40s'; raw, ascii, hex, gzip and bzip2 are known",
                              l->text[F_ENCODING]);
}

static vv_status parse_endian(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    const char *text = l->text[F_ENDIAN];
    if (text && strcasecmp(text, "big") == 0)
        h->big_endian = true;
    else if (text && strcasecmp(text, "little") != 0)
        return vvi_nrrd_fail_line(l, F_ENDIAN, "is '%.40s'; it is 'little' or 'big'", text);
    else if (!text && vv_type_bytes(h->type) > 1 && h->encoding != VVI_NRRD_TEXT)
        return vv_fail_at(VV_E_FORMAT, l->file, NULL,
                          "its header has no field 'endian', which samples of more than one byte need");
    return VV_OK;
}

/* One number for each axis into a double that lies `offset` bytes into the axis. */
static vv_status parse_axis_numbers(vvi_nrrd *h, const vvi_nrrd_lines *l, enum vvi_nrrd_field field, size_t offset)
{
    const char *at = l->text[field];
    for (int a = 0; at && a < h->dimension; a++) {
        double *to = (double *)(void *)((char *)&h->axis[a] + offset);
        if (!vvi_scan_real(to, at, &at))
            return vvi_nrrd_fail_line(l, field, "has %d numbers but 'dimension' is %d", a, h->dimension);
    }
    if (at && at[strspn(at, " \t")] != 0)
        return vvi_nrrd_fail_line(l, field, "has more than %d entries, but 'dimension' is %d", h->dimension,
                                  h->dimension);
    return VV_OK;
}

static vv_status parse_sizes(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    int n = 0;
    vv_status st = need(l, F_SIZES);
    if (st != VV_OK)
        return st;
    const char *at = l->text[F_SIZES];
    for (int64_t size; vvi_scan_int(&size, at, &at); n++) {
        if (size < 1 || (uint64_t)size > h->limits->dim)
            return vvi_nrrd_fail_line(l, F_SIZES, "has %lld; 1 to %llu are possible (--limit dim=N allows more)",
                                      (long long)size, (unsigned long long)h->limits->dim);
        if (n < h->dimension)
            h->axis[n].size = size;
    }
    if (n != h->dimension)
        return vvi_nrrd_fail_line(l, F_SIZES, "has %d numbers but 'dimension' is %d", n, h->dimension);
    if (at[strspn(at, " \t")] != 0)
        return vvi_nrrd_fail_line(l, F_SIZES, "has '%.40s' where a size was expected", at);
    return VV_OK;
}

void vvi_nrrd_plain_word(char *out, size_t room, const char *text, size_t n)
{
    size_t used = 0;
    for (size_t i = 0; i < n && used + 1 < room; i++)
        if (isalnum((unsigned char)text[i]))
            out[used++] = (char)tolower((unsigned char)text[i]);
    out[used] = 0;
}

static vv_status parse_kinds(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    const char *at = l->text[F_KINDS];
    for (int a = 0; at && a < h->dimension; a++) {
        at += strspn(at, " \t");
        const size_t n = strcspn(at, " \t");
        if (n == 0)
            return vvi_nrrd_fail_line(l, F_KINDS, "has %d words but 'dimension' is %d", a, h->dimension);
        vvi_nrrd_plain_word(h->axis[a].kind, sizeof h->axis[a].kind, at, n);
        if (n < sizeof h->axis[a].kind_text)
            snprintf(h->axis[a].kind_text, sizeof h->axis[a].kind_text, "%.*s", (int)n, at);
        at += n;
    }
    return VV_OK;
}

static vv_status parse_centerings(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    const char *at = l->text[F_CENTERINGS];
    for (int a = 0; at && a < h->dimension; a++) {
        at += strspn(at, " \t");
        const size_t n = strcspn(at, " \t");
        if (n == 0)
            return vvi_nrrd_fail_line(l, F_CENTERINGS, "has %d words but 'dimension' is %d", a, h->dimension);
        h->axis[a].centering = n == 4 && strncasecmp(at, "node", 4) == 0   ? 'n'
                               : n == 4 && strncasecmp(at, "cell", 4) == 0 ? 'c'
                                                                           : 0;
        at += n;
    }
    return VV_OK;
}

/* "mm" "mm" "s": in quotes. */
static vv_status parse_quoted(char out[][16], size_t stride, int n, const vvi_nrrd_lines *l, enum vvi_nrrd_field field)
{
    const char *at = l->text[field];
    for (int a = 0; at && a < n; a++) {
        at += strspn(at, " \t");
        const char *close = *at == '"' ? strchr(at + 1, '"') : NULL;
        if (!close)
            return vvi_nrrd_fail_line(l, field, "needs %d words in \"quotes\"; number %d is missing", n, a + 1);
        vvi_unit_name((char *)out + (size_t)a * stride, at + 1, (size_t)(close - at - 1));
        at = close + 1;
    }
    return VV_OK;
}

static vv_status expand_pattern(vvi_nrrd *h, const vvi_nrrd_lines *l, const char *pattern, size_t n,
                                const int64_t *range)
{
    vvi_data_files files = {.header = h->name, .limits = h->limits, .name = h->file, .n = h->n_files};
    bool memory;
    const char *wrong = vvi_data_files_expand(&files, pattern, n, range, &memory);
    h->file = files.name;
    h->n_files = files.n;
    if (!wrong)
        return VV_OK;
    return memory ? vv_fail_memory(n)
                  : vvi_nrrd_fail_line(l, F_DATA_FILE, "has the pattern '%.*s', which %s", n < 60 ? (int)n : 60,
                                       pattern, wrong);
}

/* PATTERN min max step [subdim]; the pattern may hold spaces, so the numbers are looked for from the end. */
static vv_status parse_data_file(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    const char *text = l->text[F_DATA_FILE], *end;
    int64_t number[4];
    if (!text)
        return VV_OK;
    if (vvi_nrrd_is_list(text)) {
        if (text[4] && (!vvi_scan_int(&number[0], text + 4, &end) || number[0] < 1 || number[0] > h->dimension))
            return vvi_nrrd_fail_line(l, F_DATA_FILE, "has '%.40s' where a dimension from 1 to %d was expected",
                                      text + 5, h->dimension);
        h->sub_dimension = text[4] ? (int)number[0] : 0;
        return h->n_files > 0 ? VV_OK : vvi_nrrd_fail_line(l, F_DATA_FILE, "is LIST, but no file name follows");
    }
    if (text[0] == 0)
        return vvi_nrrd_fail_line(l, F_DATA_FILE, "names no file");
    const char *percent = strchr(text, '%');
    const size_t n = percent ? (size_t)(percent - text) + strcspn(percent, " \t") : 0;
    int count = 0;
    for (const char *at = text + n; percent && count < 4 && vvi_scan_int(&number[count], at, &at);)
        count++;
    if (count < 3)
        return vvi_nrrd_keep_file(h, text);
    if (count == 4 && (number[3] < 1 || number[3] > h->dimension))
        return vvi_nrrd_fail_line(l, F_DATA_FILE, "has the dimension %lld; it goes from 1 to %d", (long long)number[3],
                                  h->dimension);
    h->sub_dimension = count == 4 ? (int)number[3] : 0;
    return expand_pattern(h, l, text, n, number);
}

static vv_status parse_skips(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    vv_status st = VV_OK;
    if (l->text[F_LINE_SKIP])
        st = vvi_nrrd_parse_int(&h->line_skip, l, F_LINE_SKIP, 0, 1 << 20);
    if (st == VV_OK && l->text[F_BYTE_SKIP])
        st = vvi_nrrd_parse_int(&h->byte_skip, l, F_BYTE_SKIP, -1, INT64_C(1) << 50);
    if (st == VV_OK && h->byte_skip == -1 && h->encoding != VVI_NRRD_RAW)
        st = vvi_nrrd_fail_line(l, F_BYTE_SKIP, "is -1 (the data end the file), which only raw data can be");
    return st;
}

static vv_status parse_axes(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    vv_status st;
    for (int a = 0; a < VVI_NRRD_AXES; a++)
        h->axis[a].spacing = h->axis[a].min = h->axis[a].max = NAN;
    if ((st = parse_sizes(h, l)) != VV_OK ||
        (st = parse_axis_numbers(h, l, F_SPACINGS, offsetof(vvi_nrrd_axis, spacing))) != VV_OK ||
        (st = parse_axis_numbers(h, l, F_AXIS_MINS, offsetof(vvi_nrrd_axis, min))) != VV_OK ||
        (st = parse_axis_numbers(h, l, F_AXIS_MAXS, offsetof(vvi_nrrd_axis, max))) != VV_OK ||
        (st = parse_centerings(h, l)) != VV_OK || (st = parse_kinds(h, l)) != VV_OK ||
        (st = parse_quoted(&h->axis[0].unit, sizeof h->axis[0], h->dimension, l, F_UNITS)) != VV_OK)
        return st;
    if ((st = vvi_nrrd_parse_space(h, l)) != VV_OK)
        return st;
    return parse_quoted(h->space_unit, sizeof h->space_unit[0], h->space_dimension, l, F_SPACE_UNITS);
}

static vv_status keep_the_rest(vvi_nrrd *h, const vvi_nrrd_lines *l, vv_notes *notes)
{
    static const enum vvi_nrrd_field as_metadata[] = {F_CONTENT, F_OLD_MIN,     F_OLD_MAX,
                                                      F_LABELS,  F_THICKNESSES, F_MEASUREMENT_FRAME};
    vv_status st = VV_OK;
    if (l->text[F_CONTENT])
        snprintf(h->content, sizeof h->content, "%s", l->text[F_CONTENT]);
    if (l->text[F_SAMPLE_UNITS]) {
        const char *text = l->text[F_SAMPLE_UNITS];
        const size_t n = strlen(text);
        const bool quoted = n >= 2 && text[0] == '"' && text[n - 1] == '"';
        snprintf(h->sample_unit, sizeof h->sample_unit, "%.*s", (int)(quoted ? n - 2 : n < 16 ? n : 16), text + quoted);
    }
    h->has_measurement_frame = l->text[F_MEASUREMENT_FRAME] != NULL;
    for (size_t i = 0; i < sizeof as_metadata / sizeof *as_metadata && st == VV_OK; i++)
        if (l->text[as_metadata[i]])
            st = vvi_notes_add(notes, vvi_nrrd_field_name(as_metadata[i]), l->text[as_metadata[i]]);
    return st;
}

static vv_status understand(vvi_nrrd *h, const vvi_nrrd_lines *l, vv_notes *notes)
{
    int64_t dimension;
    vv_status st = need(l, F_DIMENSION);
    if (st != VV_OK || (st = vvi_nrrd_parse_int(&dimension, l, F_DIMENSION, 1, VVI_NRRD_AXES)) != VV_OK)
        return st;
    h->dimension = (int)dimension;
    if ((st = parse_type(&h->type, l)) != VV_OK || (st = parse_encoding(h, l)) != VV_OK ||
        (st = parse_endian(h, l)) != VV_OK || (st = parse_axes(h, l)) != VV_OK || (st = parse_skips(h, l)) != VV_OK ||
        (st = parse_data_file(h, l)) != VV_OK)
        return st;
    vvi_nrrd_keep_fields(h, l);
    return keep_the_rest(h, l, notes);
}

vv_status vvi_nrrd_parse(vvi_nrrd *h, vv_source *source, vv_notes *notes, vv_job *job)
{
    vvi_nrrd_lines l = {.file = vvi_source_name(source)};
    h->name = l.file;
    h->limits = vvi_job_limits(job);
    h->value_scale = 1;
    vv_status st = vvi_nrrd_collect(h, &l, source, notes);
    if (st == VV_OK)
        st = understand(h, &l, notes);
    vvi_nrrd_lines_finish(&l);
    return st;
}

void vvi_nrrd_finish(vvi_nrrd *h)
{
    for (size_t i = 0; i < h->n_files; i++)
        free(h->file[i]);
    free(h->file);
    h->file = NULL;
    h->n_files = 0;
    vvi_nrrd_names_free(h->names);
    h->names = NULL;
}
