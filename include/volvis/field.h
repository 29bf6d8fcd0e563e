/** @file
 * Fields: immutable, reference-counted samples on a grid, read by bricks.
 *
 * How samples are stored (an array, a mapped file, later blocks or codes) does not concern a reader: it asks for the
 * brick that covers a box and gets a pointer and strides. Share fields freely between threads.
 *
 * Samples lie at integer index coordinates; smooth interpolation lives on [0, n-1], nearest on [-0.5, n-0.5].
 * Value = stored * value_scale + value_offset, in value_unit; renderers work in values, files keep what is stored.
 */
#ifndef VOLVIS_FIELD_H
#define VOLVIS_FIELD_H
#include <volvis/runtime.h>
#include <volvis/vec.h>
VV_BEGIN_DECLS

typedef enum vv_type {
    VV_TYPE_U8,
    VV_TYPE_I8,
    VV_TYPE_U16,
    VV_TYPE_I16,
    VV_TYPE_U32,
    VV_TYPE_I32,
    VV_TYPE_U64,
    VV_TYPE_I64,
    VV_TYPE_F32,
    VV_TYPE_F64
} vv_type;
#define VV_TYPE_COUNT 10

/** The number of a label: all 64 bits of it, for ids that doubles take for one another. Of u64 samples those of
 * uint64_t, so that 2^63 and more are negative here; of other integers their value. */
typedef int64_t vv_label_id;

VV_API size_t vv_type_bytes(vv_type type);
VV_API const char *vv_type_name(vv_type type); /* "u8" ... "f64" */
/** Understands u8, uint8, uchar, "unsigned char", int16, float, double, ...: true and *out when it is a type. */
VV_API bool vv_type_parse(vv_type *out, const char *text);
VV_API bool vv_type_is_float(vv_type type);

/** What the world axes of a grid mean. */
typedef enum vv_space {
    VV_SPACE_PLAIN, /**< the file's own axes */
    VV_SPACE_RAS    /**< anatomical: x to the right, y to the front, z up, of the subject */
} vv_space;

/** Which axis points up where nothing else says so: z of volumes and of most programs for engineers, y of files that
 * programs for pictures make. */
typedef enum vv_up { VV_UP_Z, VV_UP_Y } vv_up;

/** What the components of a sample mean. */
typedef enum vv_meaning {
    VV_MEANING_SCALAR, /**< independent numbers; one unless `components` says more */
    VV_MEANING_RGB,    /**< 3 components; integers are sRGB */
    VV_MEANING_RGBA,   /**< 4 components, alpha last, not premultiplied */
    VV_MEANING_VECTOR, /**< components of one vector in world axes */
    VV_MEANING_LABEL   /**< integers that name things: never interpolated */
} vv_meaning;

/** A regular grid placed by an affine map. */
typedef struct vv_grid {
    int64_t dims[3];          /**< samples along x, y, z; each at least 1 */
    vv_affine index_to_world; /**< columns are the steps from one sample to the next */
    vv_space space;
    char unit[16]; /**< of world lengths: "mm", "um", ...; "units": spacing without a unit; "voxels": no spacing */
} vv_grid;

/** All that is known of a field without its samples. Plain data; copy it freely. */
typedef struct vv_field_info {
    vv_grid grid;
    vv_type type;
    int components; /**< at least 1; interleaved, component fastest */
    vv_meaning meaning;
    double value_scale, value_offset; /**< 1 and 0 when stored is meant; scale is never 0 or non-finite */
    char value_unit[16];              /**< "" when not known */
    char name[64];                    /**< of the attribute; "" when it has none */
    int64_t n_frames;                 /**< time steps in the source; at least 1 */
    int64_t frame;                    /**< which of them this is */
    double frame_step;                /**< between frames, in frame_unit; 0 when not known */
    char frame_unit[16];
} vv_field_info;

/** What a component is called by its meaning alone: "red", "green", "blue", "alpha"; "x", "y", "z" of vectors. NULL: it
 * has no name of its own. */
VV_API const char *vv_component_name(const vv_field_info *info, int component);

/** u8 1 x 1 x 1 scalar, identity placement, "voxels": fill what differs. */
VV_API vv_field_info vv_field_info_default(void);
/** Length of one step along index axis 0..2. */
VV_API double vv_grid_spacing(const vv_grid *grid, int axis);
/** Smallest of the three, ignoring axes of one sample unless all are. */
VV_API double vv_grid_voxel(const vv_grid *grid);
/** World box of the domain that smooth interpolation lives on: sample centres, [0, n-1]. */
VV_API vv_bounds vv_grid_bounds(const vv_grid *grid);
/** For each index axis the world direction it runs along, as letters: "RAS", "LPI", ...; "xyz" signs ("+x-y+z")
 * for plain space. */
VV_API void vv_grid_orientation(char out[16], const vv_grid *grid);
/** The part of a grid that a box covers: dims and origin of the crop. */
VV_API vv_grid vv_grid_crop(const vv_grid *grid, const vv_box *box);
/** Samples times components times bytes; VV_E_LIMIT when a size is absurd or the product overflows. */
VV_API vv_status vv_field_info_bytes(uint64_t *bytes_out, const vv_field_info *info);
/** Everything finite and in range, matrix regular: VV_E_FORMAT names what is not. */
VV_API vv_status vv_field_info_check(const vv_field_info *info);

typedef struct vv_field vv_field;

typedef void vv_free_fn(void *user);

/**
 * A field over memory that you have: x fastest, then y, then z; components interleaved; native byte order.
 *
 * guard_bytes  how many bytes after the last sample may be read as well (they are never looked at, but a vector load
 *              may touch them); give 0 when there are none.
 * Owns         calls release(user) once, when the last reference goes, and also when this fails; NULL: the memory
 *              outlives the field.
 * Errors       VV_E_ARGUMENT, VV_E_LIMIT, VV_E_FORMAT, VV_E_MEMORY
 */
VV_API vv_status vv_field_new(vv_field **out, const vv_field_info *info, const void *data, size_t guard_bytes,
                              vv_free_fn *release, void *user, vv_job *job);
/** Uninitialised samples (with guard bytes) to fill through *data_out before the field is shared. */
VV_API vv_status vv_field_new_empty(vv_field **out, void **data_out, const vv_field_info *info, vv_job *job);
VV_API vv_field *vv_field_retain(const vv_field *field);
VV_API void vv_field_release(vv_field *field); /* NULL is fine */

VV_API const vv_field_info *vv_field_get_info(const vv_field *field);
/** A number no other field of this process has: the key of derived data. */
VV_API uint64_t vv_field_identity(const vv_field *field);
/** CRC-32 of the stored samples in x-fastest order, little-endian bytes; computed once. */
VV_API vv_status vv_field_checksum(uint32_t *out, const vv_field *field, vv_job *job);
/** VV_E_READ when the file behind the samples failed or shrank after it was opened (its samples then read as 0). */
VV_API vv_status vv_field_health(const vv_field *field);

/** Samples of one box. Address of component c at (i, j, k), counted from box.lo:
 *  (const char *)data + i * stride[0] + j * stride[1] + k * stride[2] + c * vv_type_bytes(type). */
typedef struct vv_brick {
    const void *data;
    int64_t stride[3]; /**< bytes */
    vv_box box;        /**< what is covered: the box asked for */
    vv_type type;
    int components;
    size_t guard_bytes; /**< readable after the last sample */
    void *owner;        /**< given back by vv_brick_release(); NULL when nothing was copied */
} vv_brick;

/** Errors: VV_E_ARGUMENT (box outside the field), VV_E_MEMORY, VV_E_READ, VV_E_CANCELLED. */
VV_API vv_status vv_field_brick(vv_brick *out, const vv_field *field, const vv_box *box, vv_job *job);
VV_API void vv_brick_release(vv_brick *brick);
/** The box of all samples. */
VV_API vv_box vv_field_box(const vv_field *field);
/** One value (scale and offset applied) at an index, clamped to the grid; for tests, probes and small loops. */
VV_API double vv_field_value(const vv_field *field, int64_t i, int64_t j, int64_t k, int component);

/** What a look at every sample tells. Values, not stored numbers. */
typedef struct vv_statistics {
    uint64_t count; /**< finite samples */
    uint64_t nan_count, infinite_count;
    double min, max, mean, deviation; /**< of finite samples; 0 when there are none */
    double percentile[5];             /**< 0.1, 1, 50, 99, 99.9 %, as in vv_values; of types of more than 16 bits
                                         within a hundredth of what lies between the ends */
    double histogram_lo, histogram_hi;
    uint64_t histogram[1024]; /**< finite samples, equal bins over [lo, hi]; integer types of few values: one a bin.
                                   Samples so far out that all others would share a few bins are in the end bins */
    int n_bins;
} vv_statistics;

/** Of one component; kept in the job's cache. Same numbers for any thread count. */
VV_API vv_status vv_field_statistics(vv_statistics *out, const vv_field *field, int component, vv_job *job);

VV_END_DECLS
#endif
