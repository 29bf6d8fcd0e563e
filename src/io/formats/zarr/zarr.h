/** @file
 * Zarr, versions 2 and 3, and OME-Zarr in it. A hierarchy is a folder with groups and arrays; a node's metadata is JSON
 * beside it. Parts: zarr_tree.c (nodes of a folder), zarr_v2.c and zarr_v3.c
 * (an array's metadata), zarr_codecs.c (how chunks are coded), zarr_filters.c and zarr_blocks.c (decoding one),
 * zarr_chunks.c (a box of an array), zarr_copy.c (its samples), zarr_shards.c (chunks that lie together in a file),
 * zarr_ome.c (axes and placement), zarr_cf.c (what numbers mean by the CF conventions), zarr_labels.c (channels and
 * labels), zarr_parts.c (what a hierarchy holds), zarr.c (the reader's row).
 */
#ifndef VVI_IO_ZARR_H
#define VVI_IO_ZARR_H
#include "io/cf.h"
#include "io/json.h"
#include "io/layout.h"
#include "io/notes.h"

#define VVI_ZARR_AXES 8
#define VVI_ZARR_CODECS 8
#define VVI_ZARR_LEVELS 32
#define VVI_ZARR_PATH 1024

/* Nodes --------------------------------------------------------------------------------------------------------- */

typedef struct vvi_zarr_tree {
    vv_source *folder;
    json_t *v2, *v3; /* consolidated metadata by path; NULL where there is none */
    vv_job *job;
    bool finest; /* level, whatever its size (vv_read_options) */
} vvi_zarr_tree;

typedef enum vvi_zarr_kind { VVI_ZARR_NOTHING, VVI_ZARR_GROUP, VVI_ZARR_ARRAY } vvi_zarr_kind;

typedef struct vvi_zarr_node {
    char path[VVI_ZARR_PATH]; /* below the folder; "" is the folder itself */
    vvi_zarr_kind kind;
    int version;
    json_t *meta, *attributes; /* attributes may be NULL */
} vvi_zarr_node;

vv_status vvi_zarr_tree_open(vvi_zarr_tree *out, vv_source *folder, vv_job *job);
void vvi_zarr_tree_close(vvi_zarr_tree *tree); /* a zeroed one is fine */
/** VVI_ZARR_NOTHING when there is none at the path. Close it in any case. */
vv_status vvi_zarr_node_open(vvi_zarr_node *out, const vvi_zarr_tree *tree, const char *path);
void vvi_zarr_node_close(vvi_zarr_node *node); /* a zeroed one is fine */
/** Paths of the folders in a group, which may be nodes. */
vv_status vvi_zarr_children(vvi_names *out, const vvi_zarr_tree *tree, const char *path);
/** out = a/b, "." and empty parts left out. */
vv_status vvi_zarr_join(char out[VVI_ZARR_PATH], const char *a, const char *b);
/** What OME-Zarr says of a node: attributes, or "ome" in them; NULL when there are none. Borrowed. */
const json_t *vvi_zarr_ome(const vvi_zarr_node *node);

/* Arrays -------------------------------------------------------------------------------------------------------- */

typedef struct vvi_zarr_type {
    vv_type type;
    bool half, swap; /* 16-bit floats, made f32; the other byte order than the machine's */
    size_t bytes;    /* of an element in the file */
} vvi_zarr_type;

typedef enum vvi_zarr_code {
    VVI_ZARR_SHUFFLE,
    VVI_ZARR_DELTA,
    VVI_ZARR_FIXED, /* FixedScaleOffset */
    VVI_ZARR_CRC32C,
    VVI_ZARR_GZIP, /* and zlib */
    VVI_ZARR_ZSTD,
    VVI_ZARR_BZIP2,
    VVI_ZARR_LZ4,
    VVI_ZARR_LZMA,
    VVI_ZARR_BLOSC
} vvi_zarr_code;

typedef struct vvi_zarr_codec {
    vvi_zarr_code code;
    size_t element_bytes;        /* shuffle */
    vvi_zarr_type plain, stored; /* delta, fixed */
    double scale, offset;        /* fixed */
} vvi_zarr_codec;

/** Codecs of bytes, in the order in which they were applied. */
typedef struct vvi_zarr_chain {
    vvi_zarr_codec codec[VVI_ZARR_CODECS];
    int n;
} vvi_zarr_chain;

typedef struct vvi_zarr_array {
    int n_axes; /* slowest first, as in its shape */
    int64_t shape[VVI_ZARR_AXES], chunk[VVI_ZARR_AXES];
    char axis_name[VVI_ZARR_AXES][64]; /* "" when not said */
    int order[VVI_ZARR_AXES];          /* axes of a chunk as they lie, slowest first */
    vvi_zarr_type type;
    uint64_t fill; /* the element's bytes, as in a field */
    vvi_zarr_chain chain;
    uint64_t chunk_bytes; /* decoded */
    char separator;
    bool key_c; /* keys begin with c */
    bool sharded;
    int64_t shard[VVI_ZARR_AXES]; /* chunks lie in files of this shape, a multiple of chunk */
    bool index_first, index_swap, index_crc;
    vvi_cf_gaps gaps; /* none, until vvi_zarr_take_cf() looks */
} vvi_zarr_array;

/** From a node's metadata; `name` stands in errors. */
vv_status vvi_zarr_array_v2(vvi_zarr_array *out, const json_t *meta, const char *name);
vv_status vvi_zarr_array_v3(vvi_zarr_array *out, const json_t *meta, const char *name);
vv_status vvi_zarr_array_of(vvi_zarr_array *out, const vvi_zarr_node *node, const vvi_zarr_tree *tree);

/** What both versions need. */
vv_status vvi_zarr_sizes(int64_t *out, int *n_out, const json_t *list, const char *key, const char *name);
vv_status vvi_zarr_check_array(vvi_zarr_array *array, const char *name);
/** "<i2" and the like. */
bool vvi_zarr_type_v2(vvi_zarr_type *out, const char *text);
vv_status vvi_zarr_fill(uint64_t *out, const json_t *value, const vvi_zarr_type *type, const char *name);
/** One codec or filter by its name in either version, "numcodecs." before it or not; VV_E_UNSUPPORTED names it.
 * config may be NULL. */
vv_status vvi_zarr_codec_named(vvi_zarr_chain *chain, const char *codec, const json_t *config,
                               const vvi_zarr_array *array, const char *name);

/* Chunks -------------------------------------------------------------------------------------------------------- */

/** Bytes that may be in a buffer of vvi_alloc(). */
typedef struct vvi_zarr_bytes {
    uint8_t *data;
    size_t n;
} vvi_zarr_bytes;

/** A decoded chunk in the machine's order to values, where numbers stand for none. */
vv_status vvi_zarr_values(vvi_zarr_bytes *chunk, const vvi_zarr_array *array, vv_job *job);
/** The bytes of what is not stored, as in the field. */
uint64_t vvi_zarr_fill_value(const vvi_zarr_array *array);
/** Decodes in place; afterwards there are exactly `expected` bytes, or it is an error. `name` stands in it. */
vv_status vvi_zarr_decode(vvi_zarr_bytes *bytes, const vvi_zarr_chain *chain, size_t expected, const char *name,
                          vv_job *job);
/** Before memory is taken for it: whether so many bytes can be those of a chunk that has been packed. */
vv_status vvi_zarr_check_packed(const vvi_zarr_chain *chain, uint64_t packed, uint64_t expected, const char *name,
                                vv_job *job);
/** One codec that changes the number of bytes: at most `room` of them, or NULL and why not. */
const char *vvi_zarr_unpack(vvi_zarr_code code, const uint8_t *in, size_t n_in, uint8_t *out, size_t room,
                            size_t *n_out);
/** One that keeps their number, or changes it as types say; out has room for that. */
void vvi_zarr_unfilter(const vvi_zarr_codec *codec, const uint8_t *in, size_t n_in, uint8_t *out);
uint32_t vvi_crc32c(const uint8_t *data, size_t n);

/** Which axis of an array is which of a field; -1: there is none. */
typedef struct vvi_zarr_axes {
    int role[VVI_ROLES];
} vvi_zarr_axes;

/** A box from a chunk, axes slowest first as they lie in it. */
typedef struct vvi_zarr_copying {
    int n_axes;
    int64_t n[VVI_ZARR_AXES];
    int64_t from_step[VVI_ZARR_AXES], to_step[VVI_ZARR_AXES]; /* bytes */
    size_t bytes;
    bool half;
} vvi_zarr_copying;
void vvi_zarr_copy_box(const vvi_zarr_copying *copying, const uint8_t *from, uint8_t *to);

/** A box of one frame. */
vv_status vvi_zarr_read(vv_field **out, const vv_field_info *info, const vvi_zarr_array *array,
                        const vvi_zarr_axes *axes, const vv_source *folder, const char *path, int64_t frame,
                        const vv_box *region, vv_job *job);

/** Where the chunks of a shard lie. */
typedef struct vvi_zarr_shard {
    bool there;
    bool damaged, refused; /* refused: its file may not be opened */
    uint64_t *entry;       /* offset and length of each chunk; UINT64_MAX twice: not stored */
} vvi_zarr_shard;

/** The index of one shard's file; what is wrong with it is an error. */
vv_status vvi_zarr_shard_open(vvi_zarr_shard *out, const vvi_zarr_array *array, const vv_source *folder,
                              const char *key, vv_job *job);
void vvi_zarr_shard_close(vvi_zarr_shard *shard);
/** Chunks in a shard. */
uint64_t vvi_zarr_per_shard(const vvi_zarr_array *array);
/** The name of a chunk's or shard's file by its place in their grid. */
vv_status vvi_zarr_key(char out[VVI_ZARR_PATH], const vvi_zarr_array *array, const char *path, const int64_t *place);

/* OME-Zarr ------------------------------------------------------------------------------------------------------ */

typedef struct vvi_zarr_axis {
    char name[16], unit[16];
    char towards; /* of an anatomical axis: R L A P S I; 0: not said */
    int role;     /* vvi_role; -1: none */
} vvi_zarr_axis;

/** A multiscale image. */
typedef struct vvi_zarr_image {
    int n_axes; /* 0: not known, as in version 0.2 and before */
    vvi_zarr_axis axis[VVI_ZARR_AXES];
    int n_levels;
    struct {
        char path[VVI_ZARR_PATH];                     /* below the tree's folder */
        bool placed;                                  /* there is a scale */
        double map[VVI_ZARR_AXES][VVI_ZARR_AXES + 1]; /* index to world, both in the order of axes */
    } level[VVI_ZARR_LEVELS];
    char name[64];
} vvi_zarr_image;

bool vvi_zarr_is_image(const vvi_zarr_node *node);
/** Image may be large: keep it on the heap. */
vv_status vvi_zarr_image_of(vvi_zarr_image *out, const vvi_zarr_node *node, vv_notes *notes, const char *name);
/** Roles of an array's axes and the field that they make; image NULL: a plain array. */
vv_status vvi_zarr_place(vv_field_info *info, vvi_zarr_axes *axes, const vvi_zarr_array *array,
                         const vvi_zarr_image *image, int level, vv_notes *notes, const char *name);
/** Channels, labels, and what VolVis itself wrote about values. */
vv_status vvi_zarr_describe(vv_field_info *info, const vvi_zarr_node *node, vv_notes *notes, vv_job *job);

/** Places of a plain array by the coordinates that arrays of its group have for its axes, each named as an axis. */
vv_status vvi_zarr_lines(vv_field_info *info, const vvi_zarr_array *array, const vvi_zarr_axes *axes,
                         const vvi_zarr_tree *tree, const char *path, vv_notes *notes);

/** Unit, scale, sign and missing values as the attributes of an array say: after its axes and meaning. */
vv_status vvi_zarr_take_cf(vv_field_info *info, vvi_zarr_array *array, const vvi_zarr_node *node, vv_notes *notes);

/* Parts --------------------------------------------------------------------------------------------------------- */

/** What is read: an array, and the image that it is a level of. */
typedef struct vvi_zarr_choice {
    vvi_zarr_node array_node, image_node;
    vvi_zarr_array array;
    vvi_zarr_image *image; /* NULL: a plain array; vvi_free() */
    int level;
} vvi_zarr_choice;

vv_status vvi_zarr_choose(vvi_zarr_choice *out, const vvi_zarr_tree *tree, const char *part, vv_notes *notes);
void vvi_zarr_choice_close(vvi_zarr_choice *choice);
#endif
