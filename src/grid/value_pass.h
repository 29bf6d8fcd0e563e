/** @file
 * One pass over a component of a field: its samples as short runs of doubles, slab by slab in parallel.
 */
#ifndef VVI_GRID_VALUE_PASS_H
#define VVI_GRID_VALUE_PASS_H
#include "grid/field.h"
#include "grid/slabs.h"

/** The longest run that take() gets. */
#define VVI_PASS_RUN 1024

typedef struct vvi_pass {
    const char *stage;    /**< of the progress */
    size_t scratch_bytes; /**< of each worker, zeroed before its first run; 0: scratch is NULL */
    /** Stored samples of item `item`, in x-fastest order; items come in any order, one thread for each. */
    void (*take)(void *user, void *scratch, size_t item, const double *values, size_t n);
    /** Once for each worker, several at a time; NULL: nothing to do. */
    void (*finish)(void *user, void *scratch);
    void *user;
} vvi_pass;

/** The most passes that are made as one. */
#define VVI_PASSES_MOST 4

/** Passes over the same samples at once: each run goes to all of them, in order. */
typedef struct vvi_pass_group {
    vvi_pass pass[VVI_PASSES_MOST];
    int n;
} vvi_pass_group;

/** The group as one pass, which it outlives. Scratch of each begins on a line of the cache. */
vvi_pass vvi_pass_of_group(const vvi_pass_group *group);

/** How a field is cut into the items of a pass: the same for any number of threads. */
vvi_slabs vvi_pass_slabs(const vv_field *field);
vv_status vvi_pass_run(const vvi_pass *pass, const vv_field *field, int component, vv_job *job);
#endif
