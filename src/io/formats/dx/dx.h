/** @file
 * OpenDX (IBM Visualization Data Explorer): regular grids. Parts: dx.c (the row), dx_native.c (.dx files of objects),
 * dx_general.c (import headers). https://www.opendx.org, "Data Explorer File Format", "General Array Importer"
 */
#ifndef VVI_IO_DX_H
#define VVI_IO_DX_H
#include "io/data_files.h"
#include "io/notes.h"

/** What both kinds of headers say of the samples. */
typedef struct vvi_dx_grid {
    int n_axes; /* 1 .. 3, the first named is x */
    int64_t n[3];
    double origin[3], delta[3][3];
    bool cells; /* samples at the centres */
} vvi_dx_grid;

/** "unsigned short", "byte", ...: false when it is no type of numbers. */
bool vvi_dx_type(vv_type *out, const char *text);
/** Fills info, and the layout of the samples: the last axis fastest, or the first. */
void vvi_dx_place(vv_field_info *info, vvi_layout *layout, const vvi_dx_grid *grid, bool first_fastest);

vv_status vvi_dx_read_native(vv_field_info *info, vvi_data_files *files, vv_source *source,
                             const vv_read_options *options, vv_notes *notes, vv_job *job);
vv_status vvi_dx_read_general(vv_field_info *info, vvi_data_files *files, vv_source *source,
                              const vv_read_options *options, vv_notes *notes, vv_job *job);
#endif
