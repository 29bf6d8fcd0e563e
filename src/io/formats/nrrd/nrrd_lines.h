/** @file
 * The lines of a NRRD header before they are understood.
 */
#ifndef VVI_IO_NRRD_LINES_H
#define VVI_IO_NRRD_LINES_H
#include "io/formats/nrrd/nrrd.h"

enum vvi_nrrd_field {
    F_DIMENSION,
    F_TYPE,
    F_BLOCK_SIZE,
    F_ENCODING,
    F_ENDIAN,
    F_CONTENT,
    F_OLD_MIN,
    F_OLD_MAX,
    F_DATA_FILE,
    F_LINE_SKIP,
    F_BYTE_SKIP,
    F_NUMBER,
    F_SAMPLE_UNITS,
    F_SPACE,
    F_SPACE_DIMENSION,
    F_SIZES,
    F_SPACINGS,
    F_THICKNESSES,
    F_AXIS_MINS,
    F_AXIS_MAXS,
    F_CENTERINGS,
    F_LABELS,
    F_UNITS,
    F_KINDS,
    F_SPACE_UNITS,
    F_SPACE_ORIGIN,
    F_SPACE_DIRECTIONS,
    F_MEASUREMENT_FRAME,
    F_COUNT
};

typedef struct vvi_nrrd_lines {
    const char *file;
    char *text[F_COUNT]; /* NULL: not there */
    int number[F_COUNT];
} vvi_nrrd_lines;

/** Everything up to the empty line, or to the end of a detached header. Keys go to the notes. */
vv_status vvi_nrrd_collect(vvi_nrrd *h, vvi_nrrd_lines *l, vv_source *source, vv_notes *notes);
void vvi_nrrd_lines_finish(vvi_nrrd_lines *l);
const char *vvi_nrrd_field_name(enum vvi_nrrd_field field);
/** VV_E_FORMAT at the line of a field: "file:line: 'field' ...". */
vv_status vvi_nrrd_fail_line(const vvi_nrrd_lines *l, enum vvi_nrrd_field field, const char *format, ...)
    VV_PRINTF(3, 4);
/** A field's whole number in lo .. hi. */
vv_status vvi_nrrd_parse_int(int64_t *out, const vvi_nrrd_lines *l, enum vvi_nrrd_field field, int64_t lo, int64_t hi);
/** Letters and digits in lower case, so that "RGB-color", "RGBcolor" and "rgb color" are one. */
void vvi_nrrd_plain_word(char *out, size_t room, const char *text, size_t n);
/** "(1,0,0)": n numbers. */
bool vvi_nrrd_scan_vector(double *out, int n, const char *at, const char **end);
/** Keeps what goes into another NRRD; nothing in it is wrong enough to fail. */
void vvi_nrrd_keep_fields(vvi_nrrd *h, const vvi_nrrd_lines *l);
/** Space, directions and origin; sizes are known. */
vv_status vvi_nrrd_parse_space(vvi_nrrd *h, const vvi_nrrd_lines *l);
/** Whether `data file` says that names follow, one a line. */
bool vvi_nrrd_is_list(const char *data_file);
/** One more data file. */
vv_status vvi_nrrd_keep_file(vvi_nrrd *h, const char *name);
#endif
