/** @file
 * How samples lie in a file, and the way from there to a field: any order of axes, any byte order, any box.
 */
#ifndef VVI_IO_LAYOUT_H
#define VVI_IO_LAYOUT_H
#include "grid/field.h"
#include "io/source.h"

typedef enum vvi_role { VVI_ROLE_COMPONENT, VVI_ROLE_X, VVI_ROLE_Y, VVI_ROLE_Z, VVI_ROLE_FRAME } vvi_role;
#define VVI_ROLES 5

typedef struct vvi_layout_axis {
    int64_t n;
    vvi_role role; /* each at most once */
} vvi_layout_axis;

typedef struct vvi_layout {
    int n_axes;                      /* 1 .. VVI_ROLES */
    vvi_layout_axis axis[VVI_ROLES]; /* fastest first */
    vv_type type;                    /* of the field; the file's too, unless half */
    bool half;                       /* 16-bit floats in the file, made f32 */
    bool swap;                       /* the file's byte order is not the machine's */
    unsigned negate;                 /* bit c: component c changes its sign (vectors of a space with flipped axes) */
} vvi_layout;

/** Where elements come from, numbered in the order of the file. */
typedef struct vvi_elements {
    void *user;
    /** n elements from number `first` on, as bytes of the file. */
    vv_status (*read)(void *user, void *out, uint64_t first, size_t n);
    /** The same where the file may be cut short: *n_got less than n only at its end. Instead of read. */
    vv_status (*read_some)(void *user, void *out, uint64_t first, size_t n, size_t *n_got);
    /** How many elements there are, once read_some gave less. NULL: those before that. */
    uint64_t (*end)(const void *user);
    bool end_by_bytes; /* and as soon as it is known how many bytes `source` has */
    const char *name;  /* stands in what is said of a file that is cut short; needed with read_some */
    /** The last element was read: whatever guards it is checked. May be NULL. */
    vv_status (*check_end)(void *user);
    vv_source *source; /* where the elements are unpacked from, as one stream; NULL: several, or none */
} vvi_elements;

/** A 16-bit float of IEEE 754. */
float vvi_half_to_float(uint16_t h);
size_t vvi_layout_element_bytes(const vvi_layout *layout);
/** Elements of all frames; VV_E_FORMAT when an axis or the product is absurd. `name` stands in the error. */
vv_status vvi_layout_count(uint64_t *out, const vvi_layout *layout, const char *name);
/** Whether whole frames can be used where they lie, when they begin at this offset of a plain file. */
bool vvi_layout_mappable(const vvi_layout *layout, uint64_t offset);

vv_status vvi_layout_read(vv_field **out, const vv_field_info *info, const vvi_layout *layout,
                          const vvi_elements *elements, int64_t frame, const vv_box *region, vv_job *job);
/** Samples of plain bytes from `offset` on: mapped when the box is one run of them, else read. Where the source ends
 * too early the rest is missing: NaN, or 0 in integers, and the job is damaged; with less than half it is VV_E_FORMAT.
 */
vv_status vvi_layout_read_plain(vv_field **out, const vv_field_info *info, const vvi_layout *layout, vv_source *source,
                                uint64_t offset, int64_t frame, const vv_box *region, vv_job *job);
/** A field whose samples are `bytes` of a plain file as they lie, mapped: vvi_source_mappable() says whether they can.
 */
vv_status vvi_layout_map(vv_field **out, const vv_field_info *info, vv_source *source, uint64_t offset, uint64_t bytes,
                         vv_job *job);
/** VV_OK when `bytes` can still arrive from `offset` on, else VV_E_FORMAT that says how many were expected and are
 * there. */
vv_status vvi_source_expect(vv_source *source, uint64_t offset, uint64_t bytes, const char *what);
/** The same for samples that vvi_layout_read_plain() reads: half of them are enough, see there. */
vv_status vvi_source_expect_half(vv_source *source, uint64_t offset, uint64_t bytes, const char *what);
#endif
