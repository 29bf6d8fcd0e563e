/** @file
 * DICOM, shared by the files of its reader: dicom_stream.c walks elements, dicom_syntax.c
 * knows how they are written, dicom_header.c makes an image's description
 * of them, dicom_series.c sorts images into stacks, dicom_stack.c a stack into slices and frames (dicom_layers.c one of
 * segments, which dicom_segments.c knows), dicom_places.c finds what shares a place, dicom_place.c places the whole,
 * dicom_pixels.c gets one slice, dicom_read.c a volume. Structure sets are segmentations whose frames are drawn from
 * contours: dicom_contours.h.
 */
#ifndef VVI_IO_DICOM_H
#define VVI_IO_DICOM_H
#include "core/text.h"
#include "io/source.h"

/* Elements ------------------------------------------------------------------------------------------------------- */

#define VVI_DICOM_UNDEFINED UINT32_MAX /* a length that ends with a delimiter */

#define VVI_DICOM_VR(a, b) ((uint16_t)((a) << 8 | (b)))
#define VVI_DICOM_ITEM 0xfffee000u
#define VVI_DICOM_ITEM_END 0xfffee00du
#define VVI_DICOM_SEQUENCE_END 0xfffee0ddu
#define VVI_DICOM_SHARED_GROUPS 0x52009229u
#define VVI_DICOM_FRAME_GROUPS 0x52009230u
#define VVI_DICOM_SEGMENTS 0x00620002u
#define VVI_DICOM_ROIS 0x30060020u
#define VVI_DICOM_ROI_CONTOURS 0x30060039u
#define VVI_DICOM_ROI_OBSERVATIONS 0x30060080u
#define VVI_DICOM_PIXEL_DATA 0x7fe00010u
#define VVI_DICOM_PIXEL_F32 0x7fe00008u
#define VVI_DICOM_PIXEL_F64 0x7fe00009u

typedef struct vvi_dicom_element {
    uint32_t tag;    /* group in the high half */
    uint16_t vr;     /* 0 where the syntax does not say */
    uint32_t length; /* of the value */
    uint64_t at;     /* where the value begins */
    uint64_t item;   /* where the item of a sequence begins in which it lies; 0: in none */
} vvi_dicom_element;

/** Bytes of a file, read in small pieces: headers only. */
typedef struct vvi_dicom_stream {
    vv_source *source;
    vv_job *job;
    uint64_t size, at;
    bool implicit, big; /* how elements are written */
    bool contours;      /* those of a structure set are wanted as well */
    uint8_t *piece;     /* bytes [piece_at, piece_at + n_piece) */
    uint64_t piece_at;
    size_t n_piece;
    uint64_t n_elements;
} vvi_dicom_stream;

/** Where an element lies: beside the image's own, in the groups of all frames or of one, in what a structure set refers
 * to, in the description of a segment or in one of its codes; in that of a region of interest, in its contours or one
 * of them, in what was observed of one or in its code. */
typedef enum vvi_dicom_where {
    VVI_DICOM_TOP,
    VVI_DICOM_SHARED,
    VVI_DICOM_FRAME,
    VVI_DICOM_REFERENCE,
    VVI_DICOM_SEGMENT,
    VVI_DICOM_SEGMENT_CATEGORY, /* its codes, in the order of vv_label_code */
    VVI_DICOM_SEGMENT_TYPE,
    VVI_DICOM_SEGMENT_TYPE_MODIFIER,
    VVI_DICOM_SEGMENT_REGION,
    VVI_DICOM_SEGMENT_REGION_MODIFIER,
    VVI_DICOM_ROI,
    VVI_DICOM_IN_ROI_CONTOURS,
    VVI_DICOM_CONTOUR,
    VVI_DICOM_OBSERVATION,
    VVI_DICOM_OBSERVATION_CODE,
    VVI_DICOM_ELSEWHERE
} vvi_dicom_where;

/** Called for each value; it may read it through vvi_dicom_value(). frame: the number of the frame, segment, region or
 * observation that it is of. */
typedef vv_status vvi_dicom_visit(void *user, vvi_dicom_stream *s, const vvi_dicom_element *e, vvi_dicom_where where,
                                  int64_t frame);

vv_status vvi_dicom_stream_init(vvi_dicom_stream *s, vv_source *source, vv_job *job);
void vvi_dicom_stream_finish(vvi_dicom_stream *s);
/** n bytes at an offset, less only at the end of the file. */
vv_status vvi_dicom_bytes(vvi_dicom_stream *s, uint64_t at, void *out, size_t n, size_t *n_got);
vv_status vvi_dicom_next(vvi_dicom_stream *s, vvi_dicom_element *out);
/** Elements from s->at on, until the pixel data, which becomes *pixels_out (tag 0: there is none). */
vv_status vvi_dicom_walk(vvi_dicom_stream *s, vvi_dicom_element *pixels_out, vvi_dicom_visit *visit, void *user);
/** The first `most` - 1 bytes of a value as a text without padding. */
vv_status vvi_dicom_value(vvi_dicom_stream *s, const vvi_dicom_element *e, char *out, size_t most);
/** Numbers of a value, at most n; those that are not there or no numbers stay as they are. vr: where the file does not
 * say. */
vv_status vvi_dicom_numbers(vvi_dicom_stream *s, const vvi_dicom_element *e, uint16_t vr, double *out, size_t n);
/** All numbers of a text of them, however long, NAN where one is none: new memory for vvi_free(). None: NULL. */
vv_status vvi_dicom_list(double **out, size_t *n_out, vvi_dicom_stream *s, const vvi_dicom_element *e);

/* Images --------------------------------------------------------------------------------------------------------- */

/** What may tell images at one place apart, in the order in which it is tried. */
typedef enum vvi_dicom_key {
    VVI_DICOM_KEY_TEMPORAL,
    VVI_DICOM_KEY_TRIGGER,
    VVI_DICOM_KEY_SEGMENT,
    VVI_DICOM_KEY_B_VALUE,
    VVI_DICOM_KEY_ECHO,
    VVI_DICOM_KEY_ACQUISITION,
    VVI_DICOM_KEY_ACQUISITION_TIME,
    VVI_DICOM_KEY_CONTENT_TIME,
    VVI_DICOM_KEY_INSTANCE
} vvi_dicom_key;
#define VVI_DICOM_KEYS 9

/** What may differ from frame to frame; NAN where the file does not say. */
typedef struct vvi_dicom_values {
    double position[3], row[3], column[3]; /* mm, LPS as in the file; directions of growing column, row index */
    double spacing[2];                     /* between rows, between columns */
    double thickness, between;             /* of slices */
    double slope, intercept;
    double key[VVI_DICOM_KEYS];
} vvi_dicom_values;

typedef enum vvi_dicom_number {
    VVI_DICOM_ROWS,
    VVI_DICOM_COLUMNS,
    VVI_DICOM_SAMPLES,
    VVI_DICOM_PLANAR,
    VVI_DICOM_ALLOCATED,
    VVI_DICOM_STORED,
    VVI_DICOM_HIGH,
    VVI_DICOM_SIGNED,
    VVI_DICOM_FRAMES,
    VVI_DICOM_PADDING,
    VVI_DICOM_PADDING_LIMIT,
    VVI_DICOM_SERIES,
    VVI_DICOM_WINDOW_CENTER,
    VVI_DICOM_WINDOW_WIDTH,
    VVI_DICOM_FRAME_TIME,
    VVI_DICOM_TEMPORAL_RESOLUTION,
    VVI_DICOM_DOSE_SCALING,
    VVI_DICOM_FRACTION_MOST,
    VVI_DICOM_DETECTOR_SPACING, /* two */
    VVI_DICOM_NUMBERS = VVI_DICOM_DETECTOR_SPACING + 2
} vvi_dicom_number;

typedef enum vvi_dicom_text {
    VVI_DICOM_SYNTAX,
    VVI_DICOM_SERIES_UID,
    VVI_DICOM_PLACE_UID,        /* FrameOfReferenceUID: images with the same one share their places */
    VVI_DICOM_DRAWN_SERIES_UID, /* of a structure set: the first series on which it was drawn, and its places */
    VVI_DICOM_DRAWN_PLACE_UID,
    VVI_DICOM_IMAGE_UID,
    VVI_DICOM_DESCRIPTION,
    VVI_DICOM_PHOTOMETRIC,
    VVI_DICOM_MODALITY,
    VVI_DICOM_RESCALE_TYPE,
    VVI_DICOM_UNITS,
    VVI_DICOM_DOSE_UNITS,
    VVI_DICOM_SEGMENTATION_TYPE, /* "": no segmentation */
    VVI_DICOM_TEXTS
} vvi_dicom_text;
#define VVI_DICOM_TEXT_BYTES 68

typedef enum vvi_dicom_coding {
    VVI_DICOM_PLAIN,
    VVI_DICOM_RLE,
    VVI_DICOM_JPEG,
    VVI_DICOM_JPEG_LS,
    VVI_DICOM_JPEG_2000,
    VVI_DICOM_UNKNOWN
} vvi_dicom_coding;

/** What contours are: as ContourGeometricType has it, or of another kind. */
#define VVI_DICOM_OUTLINES 6
extern const char *const vvi_dicom_outlines[VVI_DICOM_OUTLINES]; /* the first VVI_DICOM_CLOSED of them are closed */
#define VVI_DICOM_CLOSED 2

/** A segment as its item of the SegmentSequence tells it, or a region of interest of a structure set; NAN and "" where
 * the file does not. */
typedef struct vvi_dicom_segment {
    double number, lab[3]; /* the colour: CIELab, in 16 bits each as in the file */
    double rgb[3];         /* or sRGB, to 255 */
    char label[VVI_DICOM_TEXT_BYTES], algorithm[20];
    char kind[20]; /* RTROIInterpretedType */
    vv_code code[VV_LABEL_CODES];
    uint32_t n_contours[VVI_DICOM_OUTLINES];
} vvi_dicom_segment;

struct vvi_dicom_structures;

typedef struct vvi_dicom_image {
    const char *name; /* of the file in its folder; NULL: the source itself */
    vvi_dicom_values values;
    vvi_dicom_values *frame; /* n_frame of them; NULL: all are as `values` */
    double *offset;          /* GridFrameOffsetVector, n_offset of them, or NULL */
    vvi_dicom_segment *segment;
    struct vvi_dicom_structures *structures; /* contours of a structure set, once they are wanted; frames are drawn */
    size_t n_frame, n_offset, n_segments;
    double number[VVI_DICOM_NUMBERS];
    char text[VVI_DICOM_TEXTS][VVI_DICOM_TEXT_BYTES];
    bool big, deflated;
    vvi_dicom_coding coding;
    vvi_dicom_element pixels;
    uint64_t size;      /* bytes of the file, inflated where it is deflated */
    uint64_t *fragment; /* where each frame's fragments begin, and the end; for several frames that are packed */
    int64_t n_frames;
    vv_type type; /* of stored samples */
    int components;
    char *problem; /* why it is left out; NULL: it is an image */
    bool foreign;  /* no DICOM at all */
} vvi_dicom_image;

/** A file that may be deflated: `source` is what to read. */
typedef struct vvi_dicom_file {
    vv_source *source;
    void *inflated;
    bool owned;
} vvi_dicom_file;

/** 0 no, 1 maybe, 2 certainly. */
int vvi_dicom_probe(const uint8_t *head, size_t n);
/** The description of what a source holds. */
vv_status vvi_dicom_image_read(vvi_dicom_image *out, vv_source *source, vv_job *job);
void vvi_dicom_image_finish(vvi_dicom_image *image);
/** Opens an image's file for reading: one of a folder, or a second view of the source. */
vv_status vvi_dicom_open(vvi_dicom_file *out, const vvi_dicom_image *image, vv_source *source, vv_job *job);
void vvi_dicom_close(vvi_dicom_file *file);

/* Deflated elements: dicom_deflate.c */

typedef struct vvi_dicom_inflater vvi_dicom_inflater;
/** From byte `at` on, behind the meta group. */
vv_status vvi_dicom_inflater_new(vvi_dicom_inflater **out, vv_source *source, uint64_t at, vv_job *job);
void vvi_dicom_inflater_free(vvi_dicom_inflater *inflater); /* NULL is fine */
/** The first `most` bytes become memory, which stands for the file from then on. */
vv_status vvi_dicom_inflate(vvi_dicom_file *file, vvi_dicom_inflater *inflater, uint64_t most);
/** Goes on to byte `end` and keeps nothing: how many bytes there are up to there. */
vv_status vvi_dicom_inflate_on(uint64_t *size_out, vvi_dicom_inflater *inflater, uint64_t end);
/** Whether nothing follows. */
bool vvi_dicom_inflated_all(const vvi_dicom_inflater *inflater);

/** At the first element after the preamble and the meta group, with the syntax set. */
vv_status vvi_dicom_begin(vvi_dicom_stream *s, vvi_dicom_image *image);
const vvi_dicom_values *vvi_dicom_frame_values(const vvi_dicom_image *image, int64_t frame);
/** Fills `fragment`. */
vv_status vvi_dicom_find_frames(vvi_dicom_image *image, vvi_dicom_stream *s);
/** Bytes of one frame when it is not packed; bits when samples are single bits. */
uint64_t vvi_dicom_frame_bytes(const vvi_dicom_image *image);

/* Segments: dicom_segments.c */

/** BINARY: a frame says where one segment is; FRACTIONAL: how much of it; LABELMAP: samples are numbers of segments. */
typedef enum vvi_dicom_segmentation {
    VVI_DICOM_NO_SEGMENTS,
    VVI_DICOM_BINARY,
    VVI_DICOM_FRACTIONAL,
    VVI_DICOM_LABELMAP
} vvi_dicom_segmentation;

vvi_dicom_segmentation vvi_dicom_segmentation_of(const vvi_dicom_image *image);
/** Keeps an element of the description of a segment. */
vv_status vvi_dicom_segment_element(vvi_dicom_image *image, vvi_dicom_stream *s, const vvi_dicom_element *e,
                                    vvi_dicom_where where, int64_t index);
/** The same of one whose element it is. */
vv_status vvi_dicom_code_element(vv_code *code, vvi_dicom_stream *s, const vvi_dicom_element *e);
/** Contours instead of samples. */
bool vvi_dicom_is_structure_set(const vvi_dicom_image *image);
/** What its parts are called. */
const char *vvi_dicom_word(const vvi_dicom_image *image);
/** Name and colour; segment NULL: the file does not describe it. */
vv_label vvi_dicom_segment_label(const vvi_dicom_segment *segment, uint16_t number);
/** All regions of a structure set, also those that are in other parts; nothing of other images. */
vv_status vvi_dicom_note_regions(const vvi_dicom_image *image, vv_notes *notes);
/** What the codes of a segment mean, as metadata. word: vvi_dicom_word(). */
vv_status vvi_dicom_note_segment(const vvi_dicom_segment *segment, const char *word, vv_notes *notes);

/* Series --------------------------------------------------------------------------------------------------------- */

/** One frame of one image. */
typedef struct vvi_dicom_slice {
    int32_t image, frame; /* image -1: missing */
    double depth;         /* along the normal */
} vvi_dicom_slice;

/** Images that one volume, or one for each time step, is made of. */
typedef struct vvi_dicom_stack {
    vvi_dicom_slice *slice;
    size_t n, room;
    char name[VVI_DICOM_TEXT_BYTES + 16];
} vvi_dicom_stack;

/** A frame of a segmentation, and the label that its samples become. */
typedef struct vvi_dicom_painted {
    int32_t frame;
    uint16_t label;
} vvi_dicom_painted;

typedef struct vvi_dicom_plan {
    vvi_names names;
    vvi_dicom_image *image;
    size_t n_images;
    vvi_dicom_stack *stack;
    size_t n_stacks;
    vvi_dicom_slice *slice;     /* of the volume that is read: n_frames times dims[2] */
    vvi_dicom_painted *painted; /* of a segmentation: what is seen in slice k are [first_painted[k], ...[k + 1]) */
    size_t *first_painted;      /* NULL: no segmentation */
    bool own_scale;             /* each slice has its own slope: samples become f32 */
    bool straight;              /* one file whose plain samples lie as they are read */
} vvi_dicom_plan;

/** All images that a folder holds, and those in its folders (deep); files that are none are noted. */
vv_status vvi_dicom_gather(vvi_dicom_plan *plan, vv_source *folder, bool deep, vv_notes *notes, vv_job *job);
/** Sorts images into stacks that can be one volume each, and names these. */
vv_status vvi_dicom_sort_images(vvi_dicom_plan *plan, const char *name, vv_job *job);
/** "40 images of 512 x 512, i16, CT, Thorax" */
void vvi_dicom_describe(char *out, size_t n, const vvi_dicom_plan *plan, const vvi_dicom_stack *stack);
void vvi_dicom_plan_finish(vvi_dicom_plan *plan);
/** Sorts what is there into stacks and chooses one: *chosen_out. *layer_out: the rest of `part`, which says what of a
 * segmentation is meant, or NULL. */
vv_status vvi_dicom_choose(vvi_dicom_plan *plan, size_t *chosen_out, const char **layer_out,
                           const vv_read_options *options, const char *name, vv_notes *notes, vv_job *job);
bool vvi_dicom_is_placed(const vvi_dicom_values *v);
/** By depth, if wanted, then by a key (-1: none), then as they came. */
vv_status vvi_dicom_sort(const vvi_dicom_plan *plan, vvi_dicom_slice *slice, size_t n, bool depth, int key,
                         vv_job *job);
/** Sorts n slices along the normal of the first: place_out[p] is where the p-th place begins in them, with n behind the
 * last; vvi_free() it. */
vv_status vvi_dicom_find_places(size_t **place_out, size_t *n_places_out, const vvi_dicom_plan *plan,
                                vvi_dicom_slice *slice, size_t n, vv_job *job);
/** Orders a stack: plan->slice, and dims[2] and n_frames of the info. */
vv_status vvi_dicom_arrange(vv_field_info *info, vvi_dicom_plan *plan, vvi_dicom_stack *stack, const char *name,
                            vv_notes *notes, vv_job *job);
/** The same of a segmentation: segments that do not overlap become labels of one volume, others parts; also the type,
 * the meaning and the scale of the info. layer: the part, or NULL. */
vv_status vvi_dicom_arrange_segments(vv_field_info *info, vvi_dicom_plan *plan, vvi_dicom_stack *stack,
                                     const char *layer, vv_source *source, vv_notes *notes, vv_job *job);
/** Placement of the arranged stack. */
vv_status vvi_dicom_place(vv_field_info *info, const vvi_dicom_plan *plan, const char *name, vv_notes *notes);
/** Metadata of the image behind an open source, and how its values should be shown. */
vv_status vvi_dicom_note(const vvi_dicom_image *image, const vv_field_info *info, vv_source *source, vv_notes *notes,
                         vv_job *job);
/** The first image of the arranged stack. */
const vvi_dicom_image *vvi_dicom_first(const vvi_dicom_plan *plan, size_t *index_out);

/* Samples -------------------------------------------------------------------------------------------------------- */

/** Memory that grows as needed and is used again for the next slice. */
typedef struct vvi_dicom_room {
    uint8_t *data;
    size_t n;
} vvi_dicom_room;

typedef struct vvi_dicom_scratch {
    vvi_dicom_room packed, clean, plain, whole;
} vvi_dicom_scratch;

vv_status vvi_dicom_make_room(vvi_dicom_room *room, size_t n, vv_job *job);
void vvi_dicom_scratch_finish(vvi_dicom_scratch *scratch);
/** Stored samples of one frame, in the machine's order, interleaved, colours as RGB. *n_missing: bytes at the end that
 * the file does not have any more, 0 in `out`. */
vv_status vvi_dicom_pixels(uint8_t *out, const vvi_dicom_image *image, int64_t frame, vv_source *source,
                           vvi_dicom_scratch *scratch, size_t *n_missing, vv_job *job);
/** Colours: planes to interleaved samples, YBR to RGB; `out` may not be `in`. */
void vvi_dicom_interleave(uint8_t *out, const uint8_t *in, size_t n, int components, size_t bytes);
void vvi_dicom_ybr_to_rgb(uint8_t *samples, size_t n);
void vvi_dicom_ybr422_to_rgb(uint8_t *out, const uint8_t *in, size_t n);
/** What a packed picture says of itself. */
typedef struct vvi_dicom_picture {
    uint32_t columns, rows, components, bits;
    uint8_t process; /* the marker of its frame */
} vvi_dicom_picture;
#define VVI_DICOM_LOSSLESS 0xc3

/** A JPEG or JPEG-LS picture without what decoders stumble over: comments, application data, bytes between segments,
 * a second frame. Returns its bytes, at most n; 0 when it is damaged. */
size_t vvi_dicom_clean_jpeg(uint8_t *out, vvi_dicom_picture *picture, const uint8_t *in, size_t n);
bool vvi_dicom_size_of_jpeg_2000(vvi_dicom_picture *out, const uint8_t *in, size_t n);
/** A cleaned lossless picture; `rows` is room for two rows of 16-bit samples. False when it is damaged. */
bool vvi_dicom_unpack_lossless(uint8_t *out, size_t bytes, const vvi_dicom_picture *picture, void *rows,
                               const uint8_t *in, size_t n);
/** One RLE frame; false when it is no such. `planes` segments of n bytes make samples of `bytes` bytes. */
bool vvi_dicom_unpack_rle(uint8_t *out, size_t n, int components, size_t bytes, const uint8_t *in, size_t n_in);

/** Whether the arranged volume is one run of plain samples of one file. */
bool vvi_dicom_is_straight(const vv_field_info *info, const vvi_dicom_plan *plan);
vv_status vvi_dicom_read(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source, int64_t frame,
                         const vv_box *region, vv_job *job);
#endif
