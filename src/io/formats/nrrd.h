/** @file
 * A NRRD header as its fields say it, and what VolVis makes of it. Parts: nrrd_header.c (text to struct), nrrd_place.c
 * (axes to roles and placement), nrrd_names.c (segments and channels), nrrd_data.c (samples), nrrd_write.c, nrrd.c (the
 * row).
 */
#ifndef VVI_IO_NRRD_H
#define VVI_IO_NRRD_H
#include "core/text.h"
#include "io/layout.h"
#include "io/notes.h"

#define VVI_NRRD_AXES 16 /* as the format says */

typedef enum vvi_nrrd_encoding {
    VVI_NRRD_RAW,
    VVI_NRRD_TEXT,
    VVI_NRRD_HEX,
    VVI_NRRD_GZIP,
    VVI_NRRD_BZIP2,
    VVI_NRRD_ZSTD /* an extension that some tools write */
} vvi_nrrd_encoding;

typedef struct vvi_nrrd_axis {
    int64_t size;
    double spacing, min, max; /* NaN: not given */
    int centering;            /* 'n' node, 'c' cell, 0 not given */
    char kind[32];            /* letters and digits in lower case: "rgbcolor"; "" not given */
    char unit[16];
    bool has_direction;
    double direction[4];
} vvi_nrrd_axis;

#define VVI_NRRD_NAMES_MOST 4096 /* segments, or channels, that are named */

/** A segment as 3D Slicer names it. */
typedef struct vvi_nrrd_segment {
    bool there;
    int layer;
    double opacity;
    vv_label label;
} vvi_nrrd_segment;

typedef struct vvi_nrrd_names vvi_nrrd_names; /* nrrd_names.c */

typedef struct vvi_nrrd {
    const char *name;        /* of the header's source; in errors */
    const vv_limits *limits; /* while the header is read */
    int dimension;
    vv_type type;
    vvi_nrrd_axis axis[VVI_NRRD_AXES];
    bool has_directions, has_origin;
    int space_dimension; /* 0: no space */
    bool anatomical;
    double flip[3]; /* from the file's space to ours */
    double origin[4];
    char space_unit[4][16];
    bool big_endian;
    vvi_nrrd_encoding encoding;
    int64_t line_skip, byte_skip;
    char **file; /* detached data; none: attached */
    size_t n_files;
    int sub_dimension; /* 0: not given */
    char content[64], sample_unit[16];
    bool has_measurement_frame;
    double value_scale, value_offset; /* our own keys */
    char meaning[16];
    bool is_segmentation;  /* Slicer's keys */
    vvi_nrrd_names *names; /* NULL: none */
    int n_layers, layer;   /* volumes of labels in the file, when there is more than one, and which is read */
    uint64_t layer_step;   /* elements from one layer to the next */
    uint64_t data_offset;  /* of attached data */
    /* what comes of it */
    vvi_layout layout;
    uint64_t per_file; /* elements in each data file */
    bool mappable;
} vvi_nrrd;

/** From the start of the source to the end of the header. */
vv_status vvi_nrrd_parse(vvi_nrrd *out, vv_source *source, vv_notes *notes, vv_job *job);
void vvi_nrrd_finish(vvi_nrrd *nrrd); /* zeroed is fine */
/** Roles of the axes, layout and info. part: which layer of a segmentation; NULL: the first. */
vv_status vvi_nrrd_place(vv_field_info *info_out, vvi_nrrd *nrrd, const char *part, vv_notes *notes);
/** Keeps what a key says of segments and channels. */
vv_status vvi_nrrd_name_key(vvi_nrrd *nrrd, const char *key, const char *value);
/** Notes the channels, or the labels of the layer that is read. */
vv_status vvi_nrrd_note_names(const vvi_nrrd *nrrd, const vv_field_info *info, vv_notes *notes);
vv_status vvi_nrrd_choose_layer(vvi_nrrd *nrrd, int n_layers, const char *part, vv_notes *notes);
void vvi_nrrd_names_free(vvi_nrrd_names *names); /* NULL is fine */
/** The keys that say the same. */
void vvi_nrrd_add_names(vvi_text *out, const vv_field_info *info, const vv_write_options *options);
/** Whether all data files are there and long enough; decides whether the samples can be mapped. */
vv_status vvi_nrrd_check_data(vvi_nrrd *nrrd, vv_source *source, vv_job *job);
vv_status vvi_nrrd_read(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source, int64_t frame,
                        const vv_box *region, vv_job *job);
vv_status vvi_nrrd_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                         vv_job *job);
extern const char *const vvi_nrrd_encodings[]; /* as vvi_nrrd_encoding numbers them */
#endif
