/** @file
 * Axes by the CF conventions: what their names say, and where samples lie by the coordinates along each. Samples of a
 * field lie evenly; where coordinates do not, a warning says so.
 */
#ifndef VVI_IO_CF_AXES_H
#define VVI_IO_CF_AXES_H
#include "io/notes.h"

#define VVI_CF_LINE_MOST ((uint64_t)1 << 20)

/** The coordinates along one axis. */
typedef struct vvi_cf_line {
    bool known, even;
    double first, last;
    char unit[16];
} vvi_cf_line;

/** One letter (x, y, z, t, c) for an axis of this name; 0 when it says nothing. */
char vvi_cf_role_named(const char *name);
/** "degrees_north" and the like are all degrees; no unit (NULL) and "1" are none. */
void vvi_cf_axis_unit(char out[16], const char *units);
/** n coordinates, whose unit is set already; of numbers that are precise to this share of themselves. Their range goes
 * into the notes, and a warning where they are uneven, or neither ascend nor descend: then they are not known. */
vv_status vvi_cf_take_line(vvi_cf_line *line, const double *at, size_t n, double precision, char role, vv_notes *notes);
void vvi_cf_place_frames(vv_field_info *info, const vvi_cf_line *line);
/** Spacing, origin and unit by the coordinates along x, y and z; equal steps, with a warning, where units differ. */
vv_status vvi_cf_place(vv_field_info *info, const vvi_cf_line lines[3], vv_notes *notes);
#endif
