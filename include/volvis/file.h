/** @file
 * Volume files: what is in them without reading the samples, their samples by frame and box, and writing.
 */
#ifndef VOLVIS_FILE_H
#define VOLVIS_FILE_H
#include <volvis/field.h>
VV_BEGIN_DECLS

/** Options of vv_file_open(). Fill with vv_read_options_init(), then change what you need. */
typedef struct vv_read_options {
    size_t size;        /**< set by init */
    const char *format; /**< a name from the format table; NULL: by content first and suffix second */
    const char *raw;    /**< headerless data: "256x256x128,u8[,spacing=1x1x1.4][,big][,skip=N]"; NULL: from the name */
    const char *part;   /**< which data set of a file or folder that holds several: an array's path, a series, a level;
                           vv_file_part() lists them. NULL: the reader's choice, or an error that lists them */
    bool finest;     /**< of several levels of detail the finest, whatever its size: for who reads it region by region.
                        Else the finest that memory has room for, with a warning when that is another */
    bool any_part;   /**< for who lists what is there: where the choice of a part would be an error, one is read all the
                        same, with a warning */
    bool any_length; /**< likewise: a file that ends before half of its samples is opened all the same, with a warning;
                        reading them is the error then */
} vv_read_options;

VV_API void vv_read_options_init(vv_read_options *options, size_t size);

typedef struct vv_file vv_file;

/** A data set inside a file. */
typedef struct vv_part {
    const char *name;  /**< for vv_read_options.part */
    const char *about; /**< dims, type: for people; "" when nothing is known */
    bool chosen;       /**< it is the one that is read */
} vv_part;

/** What a component of the samples is. */
typedef struct vv_channel {
    char name[64]; /**< "" when it has none */
    bool has_color;
    vv_color color; /**< linear */
    double lo, hi;  /**< values between which it should be shown; lo = hi: not said */
} vv_channel;

/** A concept as a coding scheme has it: the liver is "10200004" of "SCT", which is SNOMED's. Empty where not said. */
typedef struct vv_code {
    char scheme[20], value[68], meaning[68];
} vv_code;

/** What a segment is, as DICOM and 3D Slicer say it. */
typedef enum vv_label_code {
    VV_LABEL_CATEGORY, /**< an anatomical structure, a tissue, ... */
    VV_LABEL_TYPE,
    VV_LABEL_TYPE_MODIFIER, /**< left, right, ... */
    VV_LABEL_REGION,        /**< of the body, in which it lies */
    VV_LABEL_REGION_MODIFIER,
    VV_LABEL_CODES
} vv_label_code;

/** What a label of a segmentation names. */
typedef struct vv_label {
    vv_label_id value;
    char name[64]; /**< "" when it has none */
    bool has_color;
    vv_color color;       /**< linear; alpha is its opacity */
    const vv_code *codes; /**< VV_LABEL_CODES of them; NULL: none is known. They live as long as what gave the label */
    int layer;            /**< where segments overlap: the volume of labels that it is in, from 0 */
} vv_label;

/**
 * Look at a file: format, dims, type, placement. Reads the header only.
 *
 * path    a file or folder of any format of the table; "-" is standard input; .gz, .bz2 and .zst are read through;
 *         FILE@N and FILE:PART are not parsed here
 * Errors  VV_E_READ (cannot be opened), VV_E_FORMAT (place, expected, found), VV_E_UNSUPPORTED
 */
VV_API vv_status vv_file_open(vv_file **out, const char *path, const vv_read_options *options, vv_job *job);
VV_API void vv_file_close(vv_file *file); /* NULL is fine */
VV_API const vv_field_info *vv_file_info(const vv_file *file);
VV_API const char *vv_file_format(const vv_file *file);
/** What the header says beyond the info: key and value by number; false past the end. */
VV_API bool vv_file_metadata(const vv_file *file, size_t index, const char **key_out, const char **value_out);
/** What a careful user should know ("sform and qform disagree"), by number; NULL past the end. */
VV_API const char *vv_file_warning(const vv_file *file, size_t index);
/** The data sets of the file, by number; false past the end. A file that can hold only one has none. */
VV_API bool vv_file_part(const vv_file *file, size_t index, vv_part *out);
/** What the components are, one entry for each; NULL and 0 where the file does not say. Valid as long as the file. */
VV_API const vv_channel *vv_file_channels(const vv_file *file, size_t *n_out);
/** What the labels name; NULL and 0 where the file does not say. Valid as long as the file. */
VV_API const vv_label *vv_file_labels(const vv_file *file, size_t *n_out);
/** Whether the samples can be used where they lie, without reading: uncompressed, native byte order. */
VV_API bool vv_file_mappable(const vv_file *file);

/** Samples of one frame; region NULL: all. Uncompressed data is mapped, not read. A file that is cut short gives what
 * is there when that is at least half: the rest is NaN, or 0 for integers; a warning says so and vv_job_damaged() is
 * true from then on. */
VV_API vv_status vv_file_read(vv_field **out, vv_file *file, int64_t frame, const vv_box *region, vv_job *job);

/** Options of vv_field_write(). Fill with vv_write_options_init(), then change what you need. */
typedef struct vv_write_options {
    size_t size;          /**< set by init */
    const char *format;   /**< NULL: by the suffix of the path */
    const char *encoding; /**< "raw", "gzip", "bzip2", "ascii", "hex" where the format has it; NULL: its default */
    int level;            /**< of compression, 1..9; 0: the default */
    bool big_endian;
    const vv_channel *channels; /**< what the components are, if known; formats that cannot say it leave it out */
    size_t n_channels;
    const vv_label *labels; /**< what the labels name, if known */
    size_t n_labels;
    bool spare_inputs; /**< nothing that this job has read is replaced, nor a data file that another header (may) name:
                          VV_E_ARGUMENT instead */
    bool stored; /**< numbers as they are stored, with their scale and offset, which other programs may not know; else
                    values where the format has no scale that its readers honour: in the smallest type of integers that
                    holds them, else f32, or f64 where f32 could not tell two stored steps apart */
    vv_field_info *written; /**< not NULL: becomes what the frames are in the file: their type and scale */
    const vv_file *origin; /**< the file that the samples came from: what only its header says (codes of spaces, intent,
                              description, extensions) goes into a file of the same format. NULL: none is known */
    const char *names; /**< of the files of a folder of slices, with a place for each number: "slice_%03d.png"; NULL:
                          what a path "out/slice_%03d.png" says, else "z000.png" */
    bool new_values;   /**< samples no longer have the values of `origin`: what it says of those is left out */
    bool layers;       /**< the frames are no time steps but the layers of one segmentation, which may overlap:
                          vv_label.layer is a frame's number. Only where vv_format.labels_only is set */
    bool keep_order;   /**< anatomical slices of PNG are along the world's axes, as those of TIFF; else upright, as
                          radiologists see them: the patient's front at the top, right on the left */
} vv_write_options;

VV_API void vv_write_options_init(vv_write_options *options, size_t size);
/** Frames of one size and type, in order. Written beside the target, synced and renamed: never half a file. */
VV_API vv_status vv_field_write(const char *path, const vv_field *const *frames, size_t n_frames,
                                const vv_write_options *options, vv_job *job);

VV_END_DECLS
#endif
