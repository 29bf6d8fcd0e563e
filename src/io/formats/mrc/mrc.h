/** @file
 * The header of MRC and CCP4 maps: https://www.ccpem.ac.uk/mrc_format/mrc2014.php, and what IMOD adds to it:
 * https://bio3d.colorado.edu/imod/doc/mrc_format.txt.
 */
#ifndef VVI_IO_FORMATS_MRC_H
#define VVI_IO_FORMATS_MRC_H
#include "io/layout.h"
#include "io/notes.h"

#define VVI_MRC_BYTES 1024
/** A label of our own: "VolVis: RAS, mm" or "VolVis: um", of the space and the unit that the volume had. */
#define VVI_MRC_OWN "VolVis: "

/** Numbers in the order of the file: columns, rows, sections; those of the cell along X, Y, Z. */
typedef struct vvi_mrc {
    bool big_endian;
    int32_t n[3], mode, start[3], m[3], map[3]; /* map: which of X 1, Y 2, Z 3 columns, rows, sections run along */
    float cell[3], angle[3], lowest, highest, mean, origin[3], rms;
    int32_t space_group, n_extended, imod_flags;
    char own[81];                /* the text of that label; "": there is none */
    bool has_map, imod, nibbles; /* nibbles: two numbers of 4 bits a byte */
    uint64_t offset;             /* of the samples */
    vvi_layout layout;
    bool mappable;
} vvi_mrc;

/* mrc_header.c */
vv_status vvi_mrc_read_header(vvi_mrc *mrc, vv_source *source, vv_notes *notes);
/** Whether these bytes make sense as a header. */
bool vvi_mrc_plausible(const uint8_t *head, bool big_endian);
/** Type, placement and frames to the info. */
vv_status vvi_mrc_describe(vv_field_info *info, vvi_mrc *mrc, const char *name, vv_notes *notes);

/* mrc_write.c */
vv_status vvi_mrc_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                        vv_job *job);
#endif
