/** @file
 * What the files of the HDF5 family share: the library behind one lock, data sets and what is said about them, and the
 * way from there to a field. HDF5 itself, netCDF-4, Imaris, BigDataViewer and MINC 2 are this with other conventions.
 *
 * The library is not safe for threads and keeps its errors to itself: whoever calls it holds vvi_h5_lock().
 */
#ifndef VVI_IO_FORMATS_HDF5_H
#define VVI_IO_FORMATS_HDF5_H
#define H5_USE_110_API
#include "io/cf.h"
#include "io/formats/bdv/bdv.h"
#include "io/layout.h"
#include "io/notes.h"
#include <hdf5.h>

#define VVI_H5_RANK 5
#define VVI_H5_PATH 512
#define VVI_H5_TEXT 256
#define VVI_H5_CHANNELS 64

/* Files as the library sees them: hdf5_driver.c ---------------------------------------------------------------------
 */

typedef struct vvi_h5_io {
    void *user;
    haddr_t (*end)(void *user); /* bytes of the file */
    bool (*read)(void *user, haddr_t address, size_t n, void *out);
    bool (*write)(void *user, haddr_t address, size_t n, const void *data); /* NULL: for reading only */
    bool (*truncate)(void *user, haddr_t n);                                /* may be NULL */
} vvi_h5_io;
/** Settings to open or create a file with; they are copied. Close them. The lock is held. */
hid_t vvi_h5_access(const vvi_h5_io *io);

/* The library and its files: hdf5_file.c ------------------------------------------------------------------------- */

typedef struct vvi_h5 {
    hid_t file;
    vv_source *source;
    vv_job *job;
    const char *name;    /* stands in errors */
    bool finest;         /* level, whatever its size (vv_read_options) */
    bool any_part;       /* rather than none where there is a choice (vv_read_options) */
    uint64_t n_bytes;    /* that are there */
    uint64_t n_expected; /* that the file says it has; more when it is cut short */
    vv_status st;        /* of the source, when reading it failed */
    const void *room;    /* while a chunk is read: where to, and how much of it there may be; the file says more */
    size_t n_room;
    bool long_lengths; /* of 8 bytes */
} vvi_h5;

/** The library crashes, or ends the program, where it is refused memory: VV_E_MEMORY where there is not as much as it
 * needs by far, and `more` for its samples. Before it is called to write; what is read is read by another process. */
vv_status vvi_h5_reserve(size_t more);
void vvi_h5_lock(void);
void vvi_h5_unlock(void);
/** The file for reading, through the source; the lock is held. */
vv_status vvi_h5_open(vvi_h5 *out, vv_source *source, vv_job *job);
void vvi_h5_close(vvi_h5 *h5); /* a zeroed one is fine */
/** One sentence of ours and what the library said; a failure of the source instead, if that was it. */
vv_status vvi_h5_fail(vvi_h5 *h5, const char *where, const char *what);
/** Whether the bytes begin an HDF5 file, perhaps after a block of the user's. */
bool vvi_h5_magic(const uint8_t *head, size_t n);
/** Opens a group or data set by its path through hard links alone: others may lead out of the file. Negative when
 * there is none. */
hid_t vvi_h5_object(const vvi_h5 *h5, const char *path);
bool vvi_h5_has(const vvi_h5 *h5, const char *path);

/* Attributes: hdf5_attribute.c ----------------------------------------------------------------------------------- */

/** Text of an attribute: one, or several put together, with commas between those that are longer than a letter. */
bool vvi_h5_text(char *out, size_t room, hid_t object, const char *name);
/** Up to `most` numbers; how many there are, 0 when it has none. Numbers in a text count too. */
int vvi_h5_numbers(double *out, int most, hid_t object, const char *name);
/** Integers of 64 bits, those of uint64_t as their bits: how many, at most that; 0 where it is no such attribute. */
int vvi_h5_label_ids(vv_label_id *out, int most, hid_t object, const char *name);
/** All n numbers of a small data set beside the samples; false when it has not as many, or not in this file. */
bool vvi_h5_table(double *out, size_t n, hid_t data);
/** All attributes that are short texts or few numbers, as metadata. */
vv_status vvi_h5_note_attributes(vv_notes *notes, hid_t object);

/** Names and colours of components and labels as we write them; hdf5_names.c. */
vv_status vvi_h5_note_names(vv_notes *notes, hid_t data, int components);
/** The names of an enumeration as labels. */
vv_status vvi_h5_note_members(vv_notes *notes, hid_t data);

/** Whether its bits lie inside its bytes: the library converts numbers without looking. */
bool vvi_h5_number_is_whole(hid_t type);

/* Data sets: hdf5_set.c ------------------------------------------------------------------------------------------ */

typedef struct vvi_h5_set {
    char path[VVI_H5_PATH];
    int rank;
    hsize_t dims[VVI_H5_RANK], chunk[VVI_H5_RANK];
    bool chunked, half, swap, truth; /* truth: an enumeration of false and true */
    bool convert;                    /* the library makes numbers of the machine; else the file's bytes are used */
    bool names;                      /* an enumeration: values have names */
    bool dimension_scale;
    vv_type type;
    uint64_t offset; /* of its samples when they lie as one run; UINT64_MAX when not */
    uint64_t stored; /* bytes */
    size_t bytes;    /* of an element in the file */
    uint8_t fill[16];
    uint8_t lost[16]; /* an element, as in the file, in place of what cannot be decoded: NaN where there is such */
    bool by_chunks;   /* chunks, and no filter but those that we undo ourselves */
    int n_filters;
    struct {
        H5Z_filter_t id;
        unsigned parameter;
        char name[24];
        bool known;
    } filter[8];
} vvi_h5_set;

/** What the data set is; VV_E_UNSUPPORTED when it holds no numbers. `set` has no path yet. */
vv_status vvi_h5_describe(vvi_h5_set *set, vvi_h5 *h5, hid_t data);
/** The same of one with a single axis. */
vv_status vvi_h5_describe_line(vvi_h5_set *set, vvi_h5 *h5, hid_t data);
/** Whether what is made so lies in this file: external files and virtual data sets would be opened by the library
 * itself, wherever they are. */
bool vvi_h5_is_inside(hid_t creation);
/** Whether its samples can be read: filters, external files, sizes. */
vv_status vvi_h5_check(const vvi_h5_set *set, vvi_h5 *h5, hid_t data);
/** For people: "(32, 128, 128) u16, chunks (8, 32, 32), gzip". */
void vvi_h5_about(char *out, size_t room, const vvi_h5_set *set);
/** The type to read with; close it. */
hid_t vvi_h5_memory_type(const vvi_h5_set *set, hid_t data);
uint64_t vvi_h5_count(const vvi_h5_set *set);

/* Chunks: hdf5_chunks.c, hdf5_filters.c ---------------------------------------------------------------------------- */

#define VVI_H5_UNPACK_SLACK ((size_t)64) /* what a checksum may add */

/** Part of a data set, [start, start + count), as elements of the file. */
typedef struct vvi_h5_slab {
    const vvi_h5_set *set;
    const hsize_t *start, *count;
    uint8_t *data;
    size_t element; /* bytes */
} vvi_h5_slab;

bool vvi_h5_filter_is_ours(H5Z_filter_t id);
/** A chunk as it lies in the file to its n_out bytes, in `in` or a scratch buffer; each has room for n_out and
 * VVI_H5_UNPACK_SLACK. NULL: it is damaged. mask: filters that were left out, from the chunk. */
const uint8_t *vvi_h5_unpack(const vvi_h5_set *set, const uint8_t *in, size_t n, unsigned mask, size_t n_out,
                             uint8_t *const scratch[2]);
/** The lock is not held. Damaged chunks become NaN, or 0, and are counted in samples. */
vv_status vvi_h5_read_chunks(const vvi_h5_slab *slab, vvi_h5 *h5, hid_t data, uint64_t *missing, vv_job *job);

/** All numeric data sets of rank 2 to 5, in the order of their names. */
typedef struct vvi_h5_list {
    vvi_h5_set *set;
    size_t n, room;
    bool full; /* there are more */
} vvi_h5_list;
vv_status vvi_h5_list_sets(vvi_h5_list *out, vvi_h5 *h5);
void vvi_h5_list_free(vvi_h5_list *list);

/* What a reader knows: the plan ---------------------------------------------------------------------------------- */

typedef enum vvi_h5_kind { VVI_H5_PLAIN, VVI_H5_IMARIS, VVI_H5_BDV, VVI_H5_MINC } vvi_h5_kind;

typedef struct vvi_h5_plan {
    vvi_h5_kind kind;
    vvi_h5_set set;              /* the data set, or the first of many that are alike */
    char roles[VVI_H5_RANK + 1]; /* of its axes, slowest first: of "tczyx", each at most once */
    int64_t dims[VVI_H5_RANK];   /* used of each axis: at most what the set has */
    int n_sets;                  /* data sets a frame, one a component; 1: components are an axis, or one */
    int level;                   /* of what has such */
    int setups[VVI_H5_CHANNELS]; /* BigDataViewer: of each component */
    int64_t first_frame;         /* number of frame 0 in the paths */
    bool plain;                  /* samples lie as one run in the file's order */
    vvi_cf_gaps gaps;
    uint8_t gap[16];       /* an element, as in the file, that becomes NaN by them */
    double valid_range[2]; /* MINC: stored numbers are cut to these, which stand for the ends of their slice */
    double *slice_ends;    /* two for each slice, when they differ: the reader makes f32 of them; else NULL */
    int n_slice_axes;      /* 1 or 2, slowest first */
    char beside[256];      /* the file of the samples, when it is another than the one that was opened */
    vvi_layout layout;     /* of the whole, frames included */
} vvi_h5_plan;

/** The path of the data set of one frame and component. */
void vvi_h5_path_of(char out[VVI_H5_PATH], const vvi_h5_plan *plan, int64_t frame, int component);
/** Sizes of info and the layout from set, roles and dims of the plan. */
vv_status vvi_h5_lay_out(vv_field_info *info, vvi_h5_plan *plan, const char *name);
/** A new file on a descriptor; negative when it fails. */
hid_t vvi_h5_create_file(int fd);
/** The attribute with what a NIfTI header said, in lines "sform_code=4". */
#define VVI_H5_NIFTI "nifti_header"
void vvi_h5_write_attributes(hid_t data, const char *axes, const vv_field_info *info, size_t n_frames,
                             const vv_write_options *options);
vv_status vvi_h5_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                       vv_job *job);
vv_status vvi_h5_read(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source, int64_t frame,
                      const vv_box *region, vv_job *job);

/** Roles of the axes, and where the samples are, from the attributes of a data set and of the groups that it is in. */
vv_status vvi_h5_axes(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, hid_t data, vv_notes *notes);

/* netCDF-4: netcdf.c, netcdf_place.c ------------------------------------------------------------------------------- */

typedef struct vvi_netcdf {
    char scale[VVI_H5_RANK][VVI_H5_PATH]; /* of each axis, "": none */
    char roles[VVI_H5_RANK + 1];          /* "": nothing is known of any */
} vvi_netcdf;

/** The dimension scales of a data set, looked for in its group and those around it. */
void vvi_netcdf_find(vvi_netcdf *out, const vvi_h5 *h5, const vvi_h5_set *set, hid_t data);
/** The letter of a variable with coordinates by the CF conventions; 0 when it says nothing. */
char vvi_netcdf_role(hid_t variable, const char *path);
/** A variable that an attribute of the data set names; its path. Negative when there is none. */
hid_t vvi_netcdf_variable(char path[VVI_H5_PATH], const vvi_h5 *h5, const vvi_h5_set *set, const char *name);
/** Samples of a data set of one axis; 0: it is no such. */
hsize_t vvi_netcdf_length(hid_t variable);
bool vvi_netcdf_on_mesh(const vvi_h5 *h5, const vvi_h5_set *set, hid_t data);
vv_status vvi_netcdf_fail_mesh(const vvi_h5 *h5, const vvi_h5_set *set);
/** Spacing, origin, time and unit from the coordinates along the axes. */
vv_status vvi_netcdf_place(vv_field_info *info, const vvi_h5_plan *plan, const vvi_netcdf *axes, vvi_h5 *h5, hid_t data,
                           vv_notes *notes);
/** Numbers equal to _FillValue or missing_value and those outside the valid range become NaN, and integers with such
 * floats of their true values; labels stay. After the roles, before vvi_h5_lay_out(); netcdf_gaps.c. */
vv_status vvi_netcdf_take_gaps(vvi_h5_plan *plan, hid_t data, vv_notes *notes);
/** Scale and offset of packed numbers; what is not there is left alone. */
void vvi_netcdf_packing(double *scale, double *offset, hid_t data);

/* Conventions ------------------------------------------------------------------------------------------------------ */

/** Makes info and the plan those of a level of a pyramid; 0 is the finest. */
typedef vv_status (*vvi_h5_take_level)(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, int level);
/** The finest level that fits the memory, with a warning when it is not the finest of all; hdf5_levels.c. */
vv_status vvi_h5_choose_level(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, int n_levels, vvi_h5_take_level take,
                              vv_notes *notes);

/** What a convention makes of a data set: another type. */
void vvi_h5_adapt(const vvi_h5_plan *plan, vvi_h5_set *set);

bool vvi_imaris_is(const vvi_h5 *h5);
void vvi_imaris_path(char out[VVI_H5_PATH], int level, int64_t frame, int channel);
vv_status vvi_imaris_header(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, const char *part, vv_notes *notes);

bool vvi_bdv_is(const vvi_h5 *h5);
void vvi_bdv_path(char out[VVI_H5_PATH], int64_t frame, int setup, int level);
/** views NULL: those of the .xml beside, if there is one. */
vv_status vvi_bdv_header(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, const vvi_bdv_views *views,
                         const char *part, vv_notes *notes);

bool vvi_minc_is(const vvi_h5 *h5);
vv_status vvi_minc_header(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, vv_notes *notes);
/** Numbers of a slab [start, start + count) as they were stored, to values. */
void vvi_minc_scale(const vvi_h5_plan *plan, float *slab, const hsize_t *start, const hsize_t *count);
#endif
