/** @file
 * A NIfTI header, version 1 or 2, as one struct; and what VolVis makes of it. Parts: nifti_header.c (bytes to struct
 * and back), nifti_place.c (orientation), nifti_analyze.c (what Analyze has instead), nifti_extensions.c (what follows
 * it), nifti_origin.c (what a header says that the result has from it), nifti_words.c (the same for other formats),
 * nifti_labels.c (names in those), nifti_pair.c
 * (.hdr and .img), nifti.c (reading), nifti_write.c.
 */
#ifndef VVI_IO_NIFTI_H
#define VVI_IO_NIFTI_H
#include "core/text.h"
#include "io/layout.h"
#include "io/notes.h"

#define VVI_NIFTI1_BYTES 348
#define VVI_NIFTI2_BYTES 540

enum {
    VVI_NIFTI_INTENT_LABEL = 1002,
    VVI_NIFTI_INTENT_DISPLACEMENT = 1006,
    VVI_NIFTI_INTENT_VECTOR = 1007,
    VVI_NIFTI_INTENT_RGB = 2003,
    VVI_NIFTI_INTENT_RGBA = 2004
};

typedef struct vvi_nifti {
    int version;  /* 1 or 2 */
    bool swapped; /* its byte order is not the machine's */
    bool pair;    /* the samples lie in an .img file */
    int64_t dim[8];
    int datatype, bitpix;
    double pixdim[8];
    double vox_offset;
    double slope, intercept, cal_min, cal_max, toffset;
    int xyzt_units, intent_code, dim_info;
    double intent_p[3];
    double slice_start, slice_end, slice_duration;
    int slice_code;
    int qform_code, sform_code;
    double quatern[3], qoffset[3];
    double srow[3][4];
    char description[81], aux_file[25], intent_name[17];
    bool analyze; /* the format's ancestor, whose header says less: the next three, and no orientation */
    int orient;
    int origin[3];
    char unit[5];
    vvi_layout layout;
    uint64_t offset; /* of the samples */
    bool mappable;
} vvi_nifti;

/** 1 or 2; 0 when these first bytes are no NIfTI. */
int vvi_nifti_version(const uint8_t *head, size_t n, bool *swapped, bool *pair);
/** From VVI_NIFTI1_BYTES or VVI_NIFTI2_BYTES bytes; version, swapped and pair are set before. */
void vvi_nifti_unpack(vvi_nifti *h, const uint8_t *bytes);
/** Whether these first bytes are of Analyze 7.5; swapped as above. */
bool vvi_nifti_is_analyze(const uint8_t *head, size_t n, bool *swapped);
/** The same from its VVI_NIFTI1_BYTES. */
void vvi_nifti_unpack_analyze(vvi_nifti *h, const uint8_t *bytes);
vv_status vvi_nifti_place_analyze(vv_grid *grid, const vvi_nifti *h, const char *name, vv_notes *notes);
/** To as many bytes in the machine's order, or in the other when `swapped`. */
void vvi_nifti_pack(uint8_t *bytes, const vvi_nifti *h);
/** Where the qform, or the sform, puts voxels; false where it is not given or of no use. */
bool vvi_nifti_qform(vv_affine *out, const vvi_nifti *h);
bool vvi_nifti_sform(vv_affine *out, const vvi_nifti *h);
/** sform before qform before pixdim. */
vv_status vvi_nifti_place(vv_grid *grid, const vvi_nifti *h, const char *name, vv_notes *notes);
/** Extensions from behind the fixed header on: metadata, labels, and what ours says of the info. */
vv_status vvi_nifti_read_extensions(vv_field_info *info, const vvi_nifti *h, vv_source *source, vv_notes *notes);
/** A grid in one of the format's units, lengths and all; false when its unit is no length. */
bool vvi_nifti_file_grid(vv_grid *out, const vv_grid *grid);
/** What is kept of a header and of its extensions (vvi_notes_keep): the fixed header has this code, which no extension
 * has. */
#define VVI_NIFTI_KEPT_HEADER (-1)
/** The same of a file of another format, that was made of a NIfTI file: a header that vvi_nifti_keep_lines() made. */
#define VVI_NIFTI_KEPT_WORDS (-2)
/** The header of a file, but for where its samples lie. False: as of vvi_nifti_take_origin(). */
bool vvi_nifti_fill(vvi_nifti *h, const vv_field_info *info, size_t n_frames, const vv_write_options *options);
/** For files of other formats: what a NIfTI header would say of the samples by what their origin says, and does not say
 * by their info alone. A line for each, `before` the name and `between` it and the value. */
void vvi_nifti_add_words(vvi_text *out, const char *before, const char *between, const vv_field_info *info,
                         size_t n_frames, const vv_write_options *options);
/** And back, once the info is known: lines "name=value". */
vv_status vvi_nifti_keep_lines(vv_notes *notes, const char *lines, const vv_field_info *info);
/** Whether files of that format have these words. */
bool vvi_nifti_is_kept_by(const char *format);
/** What the header of the file says from which the samples come, where it still holds: into a header that says the
 * rest. False: when its slices were acquired cannot be said of the new ones. */
bool vvi_nifti_take_origin(vvi_nifti *h, const vv_field_info *info, const vv_write_options *options);
/** Warns of what that header says and a file of another format does not. */
void vvi_nifti_log_lost(const char *path, const char *format, const vv_write_options *options, vv_job *job);
/** The extensions of that file, as they were; *labels_out: the table of labels is among them. */
void vvi_nifti_take_extensions(vvi_text *out, const vvi_nifti *h, const vv_field_info *info,
                               const vv_write_options *options, bool *labels_out);
/** One extension as it lies in the file. */
void vvi_nifti_add_extension(vvi_text *out, const vvi_nifti *h, int32_t code, const void *bytes, size_t n);
/** The quaternion, offsets, pixdim and qfac of a placement; false when it has shear or axes of no length. */
bool vvi_nifti_set_qform(vvi_nifti *h, const vv_affine *placement);
vv_status vvi_nifti_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                          const vv_write_options *options, vv_job *job);
/* Pairs ------------------------------------------------------------------------------------------------------------ */

typedef struct vvi_nifti_opened {
    vv_source *outer, *inner; /* to be closed; NULL when not needed */
    vv_source *source;        /* to be read */
} vvi_nifti_opened;

void vvi_nifti_close(vvi_nifti_opened *opened); /* zeroed is fine */
/** Whether a source is the .img of a pair, by its name. */
bool vvi_nifti_is_image(const vv_source *source);
/** The other file of a pair, ".img" for ".hdr" or the reverse, decoded. */
vv_status vvi_nifti_open_other(vvi_nifti_opened *out, vv_source *source, const char *from, const char *to, vv_job *job);
/** Where the samples lie: in the source itself or in the other file. */
vv_status vvi_nifti_open_samples(vvi_nifti_opened *out, const vvi_nifti *h, vv_source *source, vv_job *job);

/** What NIfTI cannot say is written as a comment extension of lines "key=value" after this first line. */
#define VVI_NIFTI_EXTENSION "VolVis"
#endif
