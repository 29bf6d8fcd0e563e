/** @file
 * What all threads of one Marching Cubes share, and what each of them has.
 */
#ifndef VVI_SURFACE_MARCHING_PLAN_H
#define VVI_SURFACE_MARCHING_PLAN_H
#include "grid/mesh.h"
#include "surface/marching.h"
#include "surface/marching_kernel.h"
#include <stdatomic.h>

#define VVI_MARCH_LAYERS 8 /* of cells, in one item of the parallel loops */

typedef struct vvi_march_count {
    size_t vertices, triangles; /* of an item; later: those before it */
    size_t unknown;             /* samples that are no numbers */
} vvi_march_count;

/* Crossed edges that begin in one row of samples. */
typedef struct vvi_march_row_count {
    uint32_t edges[3]; /* by axis */
} vvi_march_row_count;

typedef struct vvi_march {
    const vvi_march_kernels *kernels;
    vv_brick brick; /* the whole field, or its box */
    vv_grid grid;   /* of the brick */
    int component;
    vvi_march_type type;
    bool made;         /* samples are made floats, less the value of the surface, item by item */
    int64_t pad;       /* samples of the cap on each side */
    int64_t n[3];      /* samples, with those of the cap */
    size_t words;      /* of a row of bits, and one more */
    double stored;     /* the surface's value as it is stored */
    double ends[2];    /* of the stored samples, where they are made floats */
    double unit;       /* made samples are multiplied by it: a power of 2 */
    char threshold[8]; /* the least sample that is inside; inverted: that is not */
    bool falls;        /* stored numbers fall as values rise */
    bool inverted;     /* samples below the threshold are inside */
    bool mirrored;     /* the grid turns triangles over */
    bool decided;
    bool some;           /* there may be a surface */
    atomic_bool missing; /* a vertex has no normal */
    vvi_march_setup frame;
    size_t n_items;
    vvi_march_count *count;    /* n_items + 1 */
    uint32_t *interior;        /* vertices inside the cells of each layer */
    vvi_march_span *span;      /* of each row of each slice, once it is counted: words of bits that are not 0 */
    vvi_march_row_count *rows; /* the same */
    bool *passes;              /* of each row: edges begin here that are crossed, or the surface passes a cell whose
                                  lowest corners lie here */
    uint8_t *blocks;           /* a state for each word of each row of min-max blocks; NULL: every sample is read */
    int block_shift;
    int64_t n_blocks[2]; /* along y and z */
    vvi_mesh_arrays arrays;
    vv_job *job;
} vvi_march;

/* Surfaces of several values, whose samples, grid and options are the same. */
typedef struct vvi_marches {
    vvi_march *march;
    size_t n; /* at least 1 */
} vvi_marches;

/* The samples of one slice as bits, and the numbers of the vertices on its edges. */
typedef struct vvi_march_plane {
    uint64_t *inside, *known;
    bool all_known;
    uint32_t *x_first, *y_first; /* of each row */
    vvi_march_span *span;        /* of each row: what is not 0 */
} vvi_march_plane;

typedef struct vvi_march_worker {
    vvi_march_plane plane[2];
    uint32_t *z_first;
    uint64_t *bits;    /* a row */
    uint8_t *states;   /* of the words of a row */
    uint64_t *crossed; /* eight rows */
    vvi_march_queue queue;
    float *made;      /* slices, where they are made */
    const char *rows; /* row j of slice k lies at rows + j * row_bytes + k * slice_bytes */
    int64_t row_bytes, slice_bytes;
} vvi_march_worker;

vv_status vvi_march_worker_new(vvi_march_worker **out, const vvi_march *m);
void vvi_march_worker_free(vvi_march_worker *worker);
/** Brings the samples that an item looks at into `made`, where they are made. */
void vvi_march_make(vvi_march_worker *worker, const vvi_march *m, size_t item);
/** Row j of slice k, both with the cap's. */
static inline const void *vvi_march_row(const vvi_march_worker *worker, int64_t j, int64_t k)
{
    return worker->rows + j * worker->row_bytes + k * worker->slice_bytes;
}

/** Bytes that are read soon where no processor expects it. */
static inline void vvi_march_fetch(const char *from, size_t bytes)
{
    for (size_t at = 0; at < bytes; at += 64) /* a cache line */
        __builtin_prefetch(from + at, 0, 2);
}

/** A stored sample as a float of made rows: 0 is the surface, what is inside is not below; less than 2^32, and infinite
 * ones as if they were far from all others. */
static inline float vvi_march_float(const vvi_march *m, double stored)
{
    const double most = 1e14, v = (m->falls ? m->stored - stored : stored - m->stored) * m->unit;
    return (float)(v > most ? most : v < -most ? -most : v);
}

/** One sample as rows have it, made or as it lies; no worker is needed. */
double vvi_march_sample(const vvi_march *m, int64_t i, int64_t j, int64_t k);

/** Checks options, takes the brick, fills all but the items. The brick is to be released, also on failure. */
vv_status vvi_march_open(vvi_march *m, const vv_field *field, const vvi_marching_options *options, vv_job *job);
/** A mesh to fill with the places that the frame counts from; the frame writes into it. */
vv_status vvi_march_new_mesh(vv_mesh **out, vvi_march *m, vvi_march_count count, size_t n_parts, bool normals);
/** Counts the vertices and triangles of each item. */
vv_status vvi_march_count_all(vvi_marches *all);
/** Writes them, once the counts are those of all items before. */
vv_status vvi_march_fill_all(vvi_marches *all);
/** Triangles from `from` to before `to` face the other way. */
void vvi_march_turn_over(uint32_t *from, const uint32_t *to);
#endif
