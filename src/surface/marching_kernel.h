/** @file
 * The inner loops of Marching Cubes, built once per instruction set: which samples of a row are inside, the vertices on
 * the crossed edges of a row, and the triangles of a row of cells.
 */
#ifndef VVI_SURFACE_MARCHING_KERNEL_H
#define VVI_SURFACE_MARCHING_KERNEL_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Sample types that are read as they lie; others are made floats. */
typedef enum vvi_march_type {
    VVI_MARCH_U8,
    VVI_MARCH_U16,
    VVI_MARCH_I16,
    VVI_MARCH_F32,
    VVI_MARCH_TYPES
} vvi_march_type;

/** Words of a row of bits: [begin, end). */
typedef struct vvi_march_span {
    uint16_t begin, end;
} vvi_march_span;

/** What all vertices share. */
typedef struct vvi_march_setup {
    float iso;                /**< stored */
    float to_world[3][4];     /**< rows of the affine map of index coordinates */
    float to_normal[3][3];    /**< rows of the linear map from gradients along the axes to normals */
    float *position, *normal; /**< 3 numbers a vertex; normal may be NULL */
} vvi_march_setup;

/** Crossed edges of one row and one direction, and what their vertices are made of. */
typedef struct vvi_march_run {
    const uint64_t *bits; /**< bit x: the edge whose lower end is sample x is crossed */
    vvi_march_span span;  /**< words of them that are looked at */
    int32_t nx;           /**< samples of a row */
    int32_t axis;         /**< direction of the edges */
    float y, z;           /**< of the lower ends, as index coordinates */
    /** For the lower and the higher end of an edge: the row it lies in, and those one before and after along y and z.
     */
    const void *row[2][5];
    int32_t y_times[2], z_times[2]; /**< 2 where those rows are one sample apart and not two */
} vvi_march_run;

enum { VVI_MARCH_QUEUE = 128, VVI_MARCH_SLACK = 16 /* written past the last vertex */ };
#define VVI_MARCH_ROOM (VVI_MARCH_QUEUE + VVI_MARCH_SLACK)

/** Vertices with consecutive numbers, on their way: what they are made of, as int32 or, of float samples, as float. */
typedef struct vvi_march_queue {
    uint32_t first; /**< number of the first */
    int32_t n;
    bool missing;                           /**< of those that left it, some have no normal */
    int32_t end[2][VVI_MARCH_ROOM];         /**< samples at the ends of the edge */
    int32_t gradient[2][3][VVI_MARCH_ROOM]; /**< twice the gradients there */
    float place[3][VVI_MARCH_ROOM];         /**< of the lower end */
    int32_t axis[VVI_MARCH_ROOM];
} vvi_march_queue;

/** One row of cells. Its four rows of samples are those at (y, z), (y+1, z), (y, z+1), (y+1, z+1). */
typedef struct vvi_march_cells {
    const vvi_march_setup *frame;
    const uint64_t *inside[4], *active; /**< bit x; a word more than needed may be read */
    vvi_march_span span;
    float y, z;
    const void *samples[4]; /**< NULL: corners inside are always apart on faces with two meanings */
    uint32_t first[8]; /**< numbers of the next vertices on edges along x in the four rows, along y at z and at z + 1,
                          along z at y and at y + 1; brought up to date */
    /** Where some samples are not numbers, an edge may be crossed beside no active cell: then the crossed edges of each
     * of the eight sorts, and first[] stays. NULL otherwise. */
    const uint64_t *crossed[8];
    uint32_t first_interior;        /**< brought up to date */
    uint32_t *triangle, *end;       /**< 3 numbers each; brought up to date. Room until `end` */
    size_t n_triangles, n_interior; /**< grow where cells are counted */
    bool missing;                   /**< grows: an interior vertex has no normal */
} vvi_march_cells;

typedef struct vvi_march_kernels {
    uint32_t needs; /**< VVI_CPU_* */
    const char *isa;
    /** Bit x: row[x] >= threshold, of the row's own type, for a row of n samples; only the words of *span are written,
     * and what is no sample is 0. Then *span has shrunk to the words that are not 0. */
    void (*classify[VVI_MARCH_TYPES])(uint64_t *bits, const void *row, int64_t n, const void *threshold,
                                      vvi_march_span *span);
    /** Bit x: row[x] is a number. Whether all are. */
    bool (*known)(uint64_t *bits, const float *row, int64_t n);
    /** Bit x of out: samples x and x + 1 of a row of n are on different sides, both known. How many. Here and below
     * only the words of the span are looked at and written, and known may be NULL. */
    size_t (*along)(uint64_t *out, const uint64_t *row, const uint64_t *known, int64_t n, vvi_march_span span);
    /** Bit x of out: samples x of two rows are on different sides, both known. How many. */
    size_t (*between)(uint64_t *out, const uint64_t *const row[2], const uint64_t *const known[2], vvi_march_span span);
    /** Bit x of out: the cell from x to x + 1 between four rows is crossed, its corners all known. How many. */
    size_t (*active)(uint64_t *out, const uint64_t *const row[4], const uint64_t *const known[4], int64_t n,
                     vvi_march_span span);
    /** What along() and between() count of a row and those after it along y and z, where all samples are known. */
    void (*count)(uint32_t out[3], const uint64_t *row, const uint64_t *beyond_y, const uint64_t *beyond_z, int64_t n,
                  vvi_march_span span);
    /** Appends the vertices of a run; full queues are emptied into the mesh. */
    void (*queue[VVI_MARCH_TYPES])(vvi_march_queue *queue, const vvi_march_run *run, const vvi_march_setup *frame);
    /** Empties a queue; the next vertices follow those that were in it. */
    void (*empty[VVI_MARCH_TYPES])(vvi_march_queue *queue, const vvi_march_setup *frame);
    /** Counts what cells() would write. */
    void (*count_cells[VVI_MARCH_TYPES])(vvi_march_cells *cells);
    void (*cells[VVI_MARCH_TYPES])(vvi_march_cells *cells);
} vvi_march_kernels;

/** The fastest that a machine with these VVI_CPU_* bits runs. */
const vvi_march_kernels *vvi_march_kernels_for(uint32_t cpu);
/** All builds that this program has, best first; NULL past the last. */
const vvi_march_kernels *vvi_march_kernels_nth(size_t index);
#endif
