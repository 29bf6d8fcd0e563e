/** @file
 * What a step makes, kept for the next one in a temporary file where memory does not hold it: made once, from the first
 * slice to the last, and then read in boxes as small as they are asked for.
 */
#ifndef VVI_RUN_SPOOL_H
#define VVI_RUN_SPOOL_H
#include "grid/lazy.h"

/** A file for the samples of one field at a time. Counted references. */
typedef struct vvi_spool vvi_spool;

vv_status vvi_spool_new(vvi_spool **out, vv_job *job);
vvi_spool *vvi_spool_retain(vvi_spool *spool);
void vvi_spool_release(vvi_spool *spool); /* NULL is fine */
/** So much room on the disk, before any work; VV_E_WRITE where there is less. `name` stands in errors. */
vv_status vvi_spool_reserve(vvi_spool *spool, uint64_t bytes, const char *name, vv_job *job);
/** Bytes that were read of it so far. */
uint64_t vvi_spool_read(const vvi_spool *spool);

/** What is kept. */
typedef struct vvi_spool_of {
    vv_field *field;
    vvi_lazy_pool *pool; /**< has its slabs until all are in the file */
    const char *name;    /**< of who makes the samples, in progress; it outlives the field */
    uint64_t key;        /**< fields with the same one have the same samples; others take turns in the file */
    bool rehearses; /**< nothing is made but a slab, which shows what memory that takes; zeros stand for the rest */
} vvi_spool_of;

/** Its samples, by the file. Retains what they come from. Threads: any; one of them reads or writes at a time. */
vv_status vvi_spool_field(vv_field **out, vvi_spool *spool, const vvi_spool_of *of, vv_job *job);
#endif
