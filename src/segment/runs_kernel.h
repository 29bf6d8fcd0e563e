/** @file
 * The inner loops of connected parts, built once per instruction set: rows of keys to bits, and bits to runs and to
 * pairs of runs that touch.
 */
#ifndef VVI_SEGMENT_RUNS_KERNEL_H
#define VVI_SEGMENT_RUNS_KERNEL_H
#include <stddef.h>
#include <stdint.h>

/** Bytes after a row of keys that are read. */
#define VVI_RUNS_GUARD 512

/** One row as bits of `words` words: samples inside, and those of them that begin a run. */
typedef struct vvi_run_bits {
    const uint64_t *inside, *starts;
    uint32_t first; /**< number of its first run */
} vvi_run_bits;

/** Runs of two rows, each pair once. Room for 2 n + 64 pairs. */
typedef struct vvi_run_pairs {
    uint32_t *a, *b;
} vvi_run_pairs;

typedef struct vvi_runs_kernels {
    uint32_t needs; /**< VVI_CPU_* */
    const char *isa;
    /** By bytes of a key, 1, 2, 4, 8: bit x: lo <= keys[x] <= hi. Bits of a whole number of words are written, 0
     * beyond n. Keys of 1 byte are unsigned, others signed. */
    void (*inside[4])(uint64_t *bits, const void *keys, int64_t n, int64_t lo, int64_t hi);
    /** Bit x: keys[x] is another one than keys[x - 1]; of the first it is set. */
    void (*differ[4])(uint64_t *bits, const void *keys, int64_t n);
    /** Those of the samples inside that begin a run: where differs is NULL, after one outside. How many. */
    uint32_t (*starts)(uint64_t *starts, const uint64_t *inside, const uint64_t *differs, size_t words);
    /** First samples of runs, and those behind their last ones. n: samples of the row. */
    void (*ends)(int32_t *lo, int32_t *end, const uint64_t *inside, const uint64_t *starts, int64_t n);
    /** Runs of rows a and b that have a sample at the same place, or, with corners, beside it. How many. */
    size_t (*touch[2])(const vvi_run_pairs *out, const vvi_run_bits *a, const vvi_run_bits *b, size_t words);
} vvi_runs_kernels;

/** The fastest that a machine with these VVI_CPU_* bits runs. */
const vvi_runs_kernels *vvi_runs_kernels_for(uint32_t cpu);
/** All builds that this program has, best first; NULL past the last. */
const vvi_runs_kernels *vvi_runs_kernels_nth(size_t index);
#endif
