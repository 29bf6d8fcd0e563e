/** @file
 * A NRRD header as its fields say it, and what VolVis makes of it. Parts: nrrd_header.c (text to struct), nrrd_place.c
 * (axes to roles and placement), nrrd_names.c and nrrd_tags.c (segments and channels), nrrd_data.c (samples),
 * nrrd_write.c, nrrd_segments.c (segments, written), nrrd_origin.c (what goes from NRRD to NRRD), nrrd.c (the row).
 * nrrd_seg.c is the row of segmentations, with nrrd_scan.c.
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
    char kind_text[32];       /* as it stands there */
    double thickness;         /* NaN: not given */
    char label[64];
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
    vv_code *codes; /* VV_LABEL_CODES of them, or NULL */
} vvi_nrrd_segment;

/** What of the header goes into another NRRD that is made of this one, beside its keys and comments. By role where it
 * is about axes. */
typedef struct vvi_nrrd_kept {
    bool has_frame;
    double frame[3][3]; /* the measurement frame: its vectors, in our space */
    double thickness[VVI_ROLES];
    int centering[VVI_ROLES];
    char label[VVI_ROLES][64];
    char component_kind[32];
    char old_min[40], old_max[40], content[256], sample_units[128];
} vvi_nrrd_kept;

/** Codes of vvi_notes_keep(): lines as they stand there, and the struct above. */
enum { VVI_NRRD_KEPT_KEY = 1, VVI_NRRD_KEPT_COMMENT, VVI_NRRD_KEPT_FIELDS };

/** Of a segmentation that is written. */
typedef struct vvi_nrrd_segmentation {
    const int64_t (*box)[6]; /* of each layer: first and last sample that has a label, along x, y, z */
} vvi_nrrd_segmentation;

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
    double value_scale, value_offset, frame_step; /* our own keys */
    char meaning[16], frame_unit[16];
    bool is_segmentation;  /* Slicer's keys, or suffix */
    bool is_fractional;    /* of segments that are amounts, from Slicer's extensions: no labels */
    vvi_nrrd_names *names; /* NULL: none */
    int n_layers, layer;   /* volumes of labels in the file, when there is more than one, and which is read */
    uint64_t layer_step;   /* elements from one layer to the next */
    uint64_t data_offset;  /* of attached data */
    vvi_nrrd_kept kept;
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
/** Takes the backslashes out of a key or a value. */
void vvi_nrrd_unescape(char *text);
/** Keeps what a key says of segments and channels. */
vv_status vvi_nrrd_name_key(vvi_nrrd *nrrd, const char *key, const char *value);
/** Notes the channels, or the labels of the layer that is read. */
vv_status vvi_nrrd_note_names(const vvi_nrrd *nrrd, const vv_field_info *info, vv_notes *notes);
vv_status vvi_nrrd_choose_layer(vvi_nrrd *nrrd, int n_layers, const char *part, vv_notes *notes);
void vvi_nrrd_names_free(vvi_nrrd_names *names);                                         /* NULL is fine */
const vvi_nrrd_segment *vvi_nrrd_get_segment(const vvi_nrrd_names *names, size_t index); /* NULL past the end */
/** "PREFIX12REST": the number, and where REST is; false when it is something else, or past all reason. */
bool vvi_nrrd_numbered(size_t *number_out, const char **rest_out, const char *key, const char *prefix);
/** The keys that say the same of channels. */
void vvi_nrrd_add_channels(vvi_text *out, const vv_field_info *info, const vv_write_options *options);
/** And of segments; seg NULL: labels in a plain NRRD. */
vv_status vvi_nrrd_add_segments(vvi_text *out, const vv_field_info *info, const vv_write_options *options,
                                const vvi_nrrd_segmentation *seg);
void vvi_nrrd_add_name(vvi_text *out, const char *name); /* as a value, with the line's end */
void vvi_nrrd_add_color(vvi_text *out, const char *key, vv_color color);
/** Codes in the tags of a segment; false where there are none. */
bool vvi_nrrd_parse_tags(vv_code out[VV_LABEL_CODES], const char *tags);
void vvi_nrrd_add_tags(vvi_text *out, const vv_code codes[VV_LABEL_CODES]);

/* From NRRD to NRRD: nrrd_origin.c */

/** Keeps a line of a key, or a comment. */
vv_status vvi_nrrd_keep_line(vv_notes *notes, const char *line);
/** How keys begin that have what a NIfTI header said, and its own name for it: "nifti sform_code:=4". */
#define VVI_NRRD_NIFTI "nifti "
/** What such keys say, once the info is known. */
vv_status vvi_nrrd_keep_nifti(vv_notes *notes, const vv_field_info *info);
/** Keeps the rest, when it is known what the axes are. */
vv_status vvi_nrrd_keep(vvi_nrrd *nrrd, const vvi_role role[VVI_NRRD_AXES], vv_notes *notes);
/** Whether the samples come from a NRRD. */
bool vvi_nrrd_has_origin(const vv_write_options *options);
bool vvi_nrrd_get_kept(vvi_nrrd_kept *out, const vv_write_options *options);
/** Fields that still hold, for axes of these roles. */
void vvi_nrrd_take_fields(vvi_text *out, const vv_field_info *info, const vv_write_options *options, const int *roles,
                          int n);
/** The kind of the components, where it still holds; NULL: say your own. */
const char *vvi_nrrd_take_kind(vvi_nrrd_kept *kept, const vv_field_info *info, const vv_write_options *options);
/** Lines that were kept with that code. */
void vvi_nrrd_take_lines(vvi_text *out, int32_t code, const vv_field_info *info, const vv_write_options *options);
bool vvi_nrrd_is_placed(const vv_grid *grid);

/* What both rows share: nrrd.c, nrrd_write.c */

vv_status vvi_nrrd_read_segmentation(vv_field_info *info, void **plan_out, vv_source *source,
                                     const vv_read_options *options, vv_notes *notes, vv_job *job);
void vvi_nrrd_free_plan(void *plan);
bool vvi_nrrd_mappable(const vv_field_info *info, const void *plan);
vv_status vvi_nrrd_write_all(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                             const vv_write_options *options, const vvi_nrrd_segmentation *seg, vv_job *job);
/** Whether all data files are there and long enough; decides whether the samples can be mapped. */
vv_status vvi_nrrd_check_data(vvi_nrrd *nrrd, vv_source *source, vv_job *job);
vv_status vvi_nrrd_read(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source, int64_t frame,
                        const vv_box *region, vv_job *job);
vv_status vvi_nrrd_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                         vv_job *job);
extern const char *const vvi_nrrd_encodings[]; /* as vvi_nrrd_encoding numbers them */
#endif
