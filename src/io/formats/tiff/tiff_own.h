/** @file
 * What VolVis keeps in a TIFF that neither ImageJ nor OME has a place for: texts by key. ImageJ's description has a
 * line "volvis_KEY=TEXT" for each, which ImageJ passes over and leaves out when it saves what it changed; OME-XML a map
 * annotation of the name space "volvis".
 */
#ifndef VVI_IO_FORMATS_TIFF_OWN_H
#define VVI_IO_FORMATS_TIFF_OWN_H
#include <volvis/field.h>

enum {
    VVI_TIFF_OWN_DIMS,      /* that the placement is of: it is nothing to a part of the file */
    VVI_TIFF_OWN_PLACEMENT, /* the steps along x, y, z, and where the first sample lies: 12 numbers */
    VVI_TIFF_OWN_SPACE,     /* "RAS" */
    VVI_TIFF_OWN_UNIT,
    VVI_TIFF_OWN_VALUE_SCALE,
    VVI_TIFF_OWN_VALUE_OFFSET,
    VVI_TIFF_OWN_VALUE_UNIT,
    VVI_TIFF_OWN_MEANING, /* "label", "vector" */
    VVI_TIFF_OWN_TIME_STEP,
    VVI_TIFF_OWN_TIME_UNIT,
    VVI_TIFF_OWN_KEYS
};

typedef struct vvi_tiff_own {
    char text[VVI_TIFF_OWN_KEYS][352]; /* "": not said */
    bool bad;                          /* a text is longer than any of ours */
} vvi_tiff_own;

extern const char *const vvi_tiff_own_keys[VVI_TIFF_OWN_KEYS];

/** The number of a key, -1 of others. */
int vvi_tiff_own_key(const char *name);
/** More of the text of a key. */
void vvi_tiff_own_add(vvi_tiff_own *own, int key, const char *text, size_t n);
/** To the info, which has all that the file says otherwise. What makes no sense is passed over. */
void vvi_tiff_own_apply(vv_field_info *info, const vvi_tiff_own *own);

/** What is to be kept of a volume whose samples lie on this grid in the file. */
void vvi_tiff_own_fill(vvi_tiff_own *own, const vv_field_info *info, const vv_grid *grid, size_t n_frames, bool ome);
#endif
