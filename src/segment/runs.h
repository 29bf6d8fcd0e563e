/** @file
 * Connected parts of a volume, by runs: stretches of a row whose samples are alike. Runs of neighbouring rows that
 * touch are united (union-find whose root is always the first run), blocks of rows at a time in parallel and then
 * across their borders (Wu, Otoo & Suzuki 2009; He, Chao & Suzuki 2008). Same numbers for any number of threads.
 */
#ifndef VVI_SEGMENT_RUNS_H
#define VVI_SEGMENT_RUNS_H
#include "segment/value_range.h"

/** What runs are made of: samples of a component with these keys, or, `other`, all that have a value and not these. */
typedef struct vvi_run_source {
    const vv_brick *brick; /**< of all samples, or of whole slices */
    vvi_key_range range;
    bool other; /**< those outside the range */
    bool each;  /**< a run has one value, and runs of different ones never touch */
} vvi_run_source;

/** How near runs touch: by how many axes neighbours differ at most. */
typedef struct vvi_touch {
    int axes;    /**< 1: faces, 2: edges too, 3: corners too */
    bool slices; /**< each slice along z by itself */
} vvi_touch;

/** Runs in x-fastest order. */
typedef struct vvi_runs {
    int64_t n[3];
    size_t n_rows, n_runs;
    uint32_t *first; /**< by row k n[1] + j: its first run; and one more */
    int32_t *lo, *end;
    int64_t *key;     /**< vvi_key_at() of its samples; NULL: not each value by itself */
    uint32_t *part;   /**< number of the part that it is in, in the order of their first samples */
    uint32_t n_parts; /**< how many there are */
} vvi_runs;

/** Errors: VV_E_LIMIT with what it takes, as `name`; VV_E_MEMORY; VV_E_CANCELLED. Owns: vvi_runs_finish(). */
vv_status vvi_runs_find(vvi_runs *out, const vvi_run_source *source, const vvi_touch *touch, const char *name,
                        vv_job *job);
/** About how much they take of a volume, beside what is made of them: two bits a voxel, and of each row six pieces. */
uint64_t vvi_runs_memory(const vv_field_info *info, bool keys);
void vvi_runs_finish(vvi_runs *runs); /* zeroed is fine */
/** Samples of each part; vvi_free(). */
vv_status vvi_runs_sizes(uint64_t **out, const vvi_runs *runs, vv_job *job);
/** The run that a sample is in; runs->n_runs: none. */
size_t vvi_runs_at(const vvi_runs *runs, const int64_t index[3]);
/** Writes the label of each part, of u8 or u32, to its samples, and 0 to all others, x fastest, packed. */
vv_status vvi_runs_paint(void *out, vv_type type, const vvi_runs *runs, const uint32_t *label_of_part, vv_job *job);
/** Rows of an item of loops over runs, and how many items there are. */
size_t vvi_runs_block(const vvi_runs *runs, size_t *n_blocks_out);
#endif
