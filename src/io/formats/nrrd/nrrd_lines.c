/* The lines of a header, kept by field until all of them are there. */
#include "io/formats/nrrd/nrrd_lines.h"
#include "core/memory.h"
#include "core/names.h"
#include "core/units.h"
#include "io/data_files.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <volvis/property.h>

static const struct {
    const char *name;
    enum vvi_nrrd_field field;
} names[] = {
    {"dimension", F_DIMENSION},
    {"type", F_TYPE},
    {"block size", F_BLOCK_SIZE},
    {"blocksize", F_BLOCK_SIZE},
    {"encoding", F_ENCODING},
    {"endian", F_ENDIAN},
    {"content", F_CONTENT},
    {"old min", F_OLD_MIN},
    {"oldmin", F_OLD_MIN},
    {"old max", F_OLD_MAX},
    {"oldmax", F_OLD_MAX},
    {"min", F_OLD_MIN},
    {"max", F_OLD_MAX},
    {"data file", F_DATA_FILE},
    {"datafile", F_DATA_FILE},
    {"line skip", F_LINE_SKIP},
    {"lineskip", F_LINE_SKIP},
    {"byte skip", F_BYTE_SKIP},
    {"byteskip", F_BYTE_SKIP},
    {"number", F_NUMBER},
    {"sample units", F_SAMPLE_UNITS},
    {"sampleunits", F_SAMPLE_UNITS},
    {"space", F_SPACE},
    {"space dimension", F_SPACE_DIMENSION},
    {"spacedimension", F_SPACE_DIMENSION},
    {"sizes", F_SIZES},
    {"spacings", F_SPACINGS},
    {"thicknesses", F_THICKNESSES},
    {"axis mins", F_AXIS_MINS},
    {"axismins", F_AXIS_MINS},
    {"axis maxs", F_AXIS_MAXS},
    {"axismaxs", F_AXIS_MAXS},
    {"centers", F_CENTERINGS},
    {"centerings", F_CENTERINGS},
    {"labels", F_LABELS},
    {"units", F_UNITS},
    {"kinds", F_KINDS},
    {"space units", F_SPACE_UNITS},
    {"spaceunits", F_SPACE_UNITS},
    {"space origin", F_SPACE_ORIGIN},
    {"spaceorigin", F_SPACE_ORIGIN},
    {"space directions", F_SPACE_DIRECTIONS},
    {"spacedirections", F_SPACE_DIRECTIONS},
    {"measurement frame", F_MEASUREMENT_FRAME},
    {"measurementframe", F_MEASUREMENT_FRAME},
};
#define N_NAMES (sizeof names / sizeof *names)

const char *vvi_nrrd_field_name(enum vvi_nrrd_field field)
{
    for (size_t i = 0; i < N_NAMES; i++)
        if (names[i].field == field)
            return names[i].name;
    return "";
}

void vvi_nrrd_lines_finish(vvi_nrrd_lines *l)
{
    for (int i = 0; i < F_COUNT; i++)
        free(l->text[i]);
}

/* A failure at the line of a field. */
vv_status vvi_nrrd_fail_line(const vvi_nrrd_lines *l, enum vvi_nrrd_field field, const char *format, ...)
{
    char where[16], text[400];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    snprintf(where, sizeof where, "%d", l->number[field]);
    return vv_fail_at(VV_E_FORMAT, l->file, where, "'%s' %s", vvi_nrrd_field_name(field), text);
}

/* Collecting lines ----------------------------------------------------------------------------------------------- */

static vv_status keep_field(vvi_nrrd_lines *l, const char *line, size_t n_name, const char *value, int number)
{
    char where[16], typed[40];
    snprintf(where, sizeof where, "%d", number);
    snprintf(typed, sizeof typed, "%.*s", n_name < 32 ? (int)n_name : 32, line);
    for (size_t i = 0; i < N_NAMES; i++) {
        if (strlen(names[i].name) != n_name || strncasecmp(names[i].name, line, n_name) != 0)
            continue;
        const enum vvi_nrrd_field f = names[i].field;
        if (l->text[f])
            return vv_fail_at(VV_E_FORMAT, l->file, where, "'%s' appears twice; it was given in line %d", typed,
                              l->number[f]);
        l->number[f] = number;
        l->text[f] = vvi_strdup(value);
        return l->text[f] ? VV_OK : vv_fail_memory(strlen(value));
    }
    const char *known[N_NAMES];
    for (size_t i = 0; i < N_NAMES; i++)
        known[i] = names[i].name;
    return vvi_fail_name(VV_E_FORMAT, l->file, where, typed, &(vvi_known){known, N_NAMES, NULL, NULL},
                         "NRRD has no field '%s', and own keys are written 'key:=value'", typed);
}

void vvi_nrrd_unescape(char *text)
{
    char *to = text;
    for (const char *from = text; *from; from++) {
        if (from[0] == '\\' && (from[1] == 'n' || from[1] == '\\')) {
            from++;
            *to++ = *from == 'n' ? '\n' : '\\';
        } else {
            *to++ = *from;
        }
    }
    *to = 0;
}

/* Keys that mean something to us; all of them are metadata as well. */
static vv_status keep_key(vvi_nrrd *h, const char *key, const char *value, vv_notes *notes)
{
    double v;
    if (strcmp(key, "volvis value scale") == 0 && vvi_parse_number(&v, value) && isfinite(v) && v != 0)
        h->value_scale = v;
    else if (strcmp(key, "volvis value offset") == 0 && vvi_parse_number(&v, value) && isfinite(v))
        h->value_offset = v;
    else if (strcmp(key, "volvis frame step") == 0 && vvi_parse_number(&v, value) && isfinite(v))
        h->frame_step = v;
    else if (strcmp(key, "volvis frame unit") == 0)
        snprintf(h->frame_unit, sizeof h->frame_unit, "%s", value);
    else if (strcmp(key, "volvis meaning") == 0)
        snprintf(h->meaning, sizeof h->meaning, "%.15s", value);
    else if (strcmp(key, "Segmentation_SourceRepresentation") == 0 ||
             strcmp(key, "Segmentation_MasterRepresentation") == 0)
        h->is_fractional = strcmp(value, "Fractional labelmap") == 0;
    const vv_status st = vvi_nrrd_name_key(h, key, value);
    return st == VV_OK ? vvi_notes_add(notes, key, value) : st;
}

static vv_status keep_line(vvi_nrrd *h, vvi_nrrd_lines *l, const char *line, int number, vv_notes *notes)
{
    const char *equals = strstr(line, ":="), *colon = strstr(line, ": ");
    if (equals && (!colon || equals < colon)) {
        char *key = vvi_strdup(line);
        if (!key)
            return vv_fail_memory(strlen(line));
        key[equals - line] = 0;
        char *value = key + (equals - line) + 2;
        vvi_nrrd_unescape(key);
        vvi_nrrd_unescape(value);
        vv_status st = keep_key(h, key, value, notes);
        free(key);
        return st == VV_OK ? vvi_nrrd_keep_line(notes, line) : st;
    }
    if (!colon) {
        const size_t n = strlen(line);
        if (n > 0 && line[n - 1] == ':')
            return keep_field(l, line, n - 1, "", number);
        char where[16];
        snprintf(where, sizeof where, "%d", number);
        return vv_fail_at(VV_E_FORMAT, h->name, where,
                          "'%.40s' is neither 'field: value' nor 'key:=value' nor a comment", line);
    }
    const char *value = colon + 2;
    value += strspn(value, " \t");
    return keep_field(l, line, (size_t)(colon - line), value, number);
}

static vv_status check_magic(const char *line, bool end, const char *name)
{
    if (end || strncmp(line, "NRRD", 4) != 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "is not a NRRD file: its first line should be NRRD0001 .. NRRD0005");
    if (strncmp(line, "NRRD00.", 7) == 0) /* before the format had a version */
        return VV_OK;
    if (strlen(line) != 8 || strncmp(line, "NRRD000", 7) != 0 || line[7] < '1' || line[7] > '9')
        return vv_fail_at(VV_E_FORMAT, name, "1", "'%.20s' is not NRRD0001 .. NRRD0005", line);
    if (line[7] > '5')
        return vv_fail_at(VV_E_UNSUPPORTED, name, "1", "%s is newer than NRRD0005, the newest that is known", line);
    return VV_OK;
}

vv_status vvi_nrrd_keep_file(vvi_nrrd *h, const char *name)
{
    vvi_data_files files = {.header = h->name, .limits = h->limits, .name = h->file, .n = h->n_files};
    const vv_status st = vvi_data_files_add(&files, name);
    h->file = files.name;
    h->n_files = files.n;
    return st;
}

bool vvi_nrrd_is_list(const char *data_file)
{
    return data_file && strncmp(data_file, "LIST", 4) == 0 && (data_file[4] == 0 || data_file[4] == ' ');
}

/* Everything up to the empty line, or to the end of a detached header. */
vv_status vvi_nrrd_collect(vvi_nrrd *h, vvi_nrrd_lines *l, vv_source *source, vv_notes *notes)
{
    const char *line;
    bool end;
    vv_status st = vvi_source_line(source, &line, 64, &end);
    if (st == VV_E_FORMAT) /* a line that long is no mark */
        return check_magic("", false, h->name);
    if (st != VV_OK || (st = check_magic(line, end, h->name)) != VV_OK)
        return st;
    for (int number = 2; st == VV_OK; number++) {
        if (vvi_source_tell(source) > h->limits->header_bytes)
            return vv_fail_at(VV_E_FORMAT, h->name, NULL,
                              "its header has more than %llu bytes; --limit header_bytes=N allows more",
                              (unsigned long long)h->limits->header_bytes);
        const size_t most = (size_t)h->limits->string_bytes;
        if ((st = vvi_source_line(source, &line, most, &end)) != VV_OK || end || line[0] == 0)
            break;
        if (vvi_nrrd_is_list(l->text[F_DATA_FILE]))
            st = vvi_nrrd_keep_file(h, line);
        else
            st = line[0] == '#' ? vvi_nrrd_keep_line(notes, line) : keep_line(h, l, line, number, notes);
    }
    h->data_offset = vvi_source_tell(source);
    return st;
}
