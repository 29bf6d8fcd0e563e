/** @file
 * Writing OME-Zarr: zarr_write.c (levels), zarr_slabs.c (what is held of them), zarr_write_meta.c (metadata),
 * zarr_write_place.c (axes), zarr_halve.c (a level from the one before), zarr_pack.c (chunks), zarr_pack_shards.c
 * (shards).
 */
#ifndef VVI_IO_ZARR_WRITE_H
#define VVI_IO_ZARR_WRITE_H
#include "core/text.h"
#include "io/formats/zarr/zarr.h"
#include "io/sink.h"

typedef enum vvi_zarr_packing {
    VVI_ZARR_PACK_RAW,
    VVI_ZARR_PACK_GZIP,
    VVI_ZARR_PACK_ZSTD,
    VVI_ZARR_PACK_BLOSC
} vvi_zarr_packing;

/** One level: its slab is filled slice by slice, and written and passed on when it is as deep as a chunk. */
typedef struct vvi_zarr_level {
    int64_t dims[3], chunk[3];
    int64_t shard[2];  /* chunks in a shard along x and y; 0: chunks are files of their own */
    int64_t factor[3]; /* samples of level 0 for one of this */
    uint8_t *slab;     /* x fastest, components interleaved */
    size_t slab_bytes;
    int64_t at, n; /* its first slice, and how many there are */
} vvi_zarr_level;

typedef struct vvi_zarr_writing {
    vv_sink *sink;
    vv_job *job;
    const vv_write_options *options;
    const vv_field_info *info; /* of the frames */
    int64_t n_frames, frame;
    int version; /* of Zarr: 2 for OME-Zarr 0.4, 3 for 0.5 */
    vvi_zarr_packing packing;
    bool sharded, label;
    bool on_disk; /* the slabs, which memory has no room for */
    size_t type_bytes, sample_bytes;
    int source_axis[3]; /* of the field, for x, y, z of the image */
    bool flip[3];
    double spacing[3], origin[3]; /* of level 0, along x, y, z */
    bool oblique;                 /* the image's world is not the field's */
    vv_affine placement;          /* of the image's samples in the field's world */
    int n_levels;
    vvi_zarr_level level[VVI_ZARR_LEVELS];
} vvi_zarr_writing;

extern const char *const vvi_zarr_encodings[];
vv_status vvi_zarr_write_0_4(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                             const vv_write_options *options, vv_job *job);
/** vv_format.folder_file */
int vvi_zarr_folder_file(const char *name);

/** Axes of the image: those of the world that the field's are nearest to; a warning where it does not run along them.
 */
void vvi_zarr_write_place(vvi_zarr_writing *w);
/** The group's and the levels' metadata. */
vv_status vvi_zarr_write_meta(const vvi_zarr_writing *w);
/** Room for a slab of every level: memory, or a scratch file where that is too small. Free them in any case. */
vv_status vvi_zarr_make_slabs(vvi_zarr_writing *w);
void vvi_zarr_free_slabs(vvi_zarr_writing *w);
/** The slab of level 0 from slice `at` on, n slices, from the field. */
vv_status vvi_zarr_fill_slab(vvi_zarr_writing *w, const vv_field *field);
/** The slab of a level: all of its chunks. */
vv_status vvi_zarr_write_chunks(const vvi_zarr_writing *w, int level);
/** The same in shards. */
vv_status vvi_zarr_write_shards(const vvi_zarr_writing *w, int level);

/** Cutting chunks out of a level's slab. */
typedef struct vvi_zarr_cutting {
    const vvi_zarr_writing *w;
    const vvi_zarr_level *level;
    int number;
    int64_t n_x, n_y; /* chunks */
    size_t chunk_bytes;
} vvi_zarr_cutting;

vvi_zarr_cutting vvi_zarr_cut(const vvi_zarr_writing *w, int level);
/** A worker's scratch, for vvi_work; `shared` begins with a vvi_zarr_cutting. */
vv_status vvi_zarr_cut_start(void **scratch_out, void *shared, int worker);
void vvi_zarr_cut_finish(void *scratch, void *shared);
/** Chunk (x, y), packed, in the scratch; *n_out 0: it is all zeros and is not stored. */
vv_status vvi_zarr_cut_chunk(const uint8_t **out, size_t *n_out, void *scratch, const vvi_zarr_cutting *c, int64_t x,
                             int64_t y, int component);
/** Its file, or that of the shard (x, y). */
void vvi_zarr_cut_name(char out[160], const vvi_zarr_cutting *c, int64_t x, int64_t y, int component);
/** A level's slab, halved, to the end of the next one's. */
vv_status vvi_zarr_halve(vvi_zarr_writing *w, int level);
/** n bytes to out, which has room of vvi_zarr_pack_room(n); 0 when it fails. */
size_t vvi_zarr_pack(uint8_t *out, const uint8_t *in, size_t n, vvi_zarr_packing packing, int level, size_t type_bytes);
size_t vvi_zarr_pack_room(size_t n);
/** How strongly, where the user does not say. */
int vvi_zarr_pack_level(vvi_zarr_packing packing, int level);
#endif
