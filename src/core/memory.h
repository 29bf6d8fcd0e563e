/** @file
 * Memory that is counted. Every allocation of size names a job, whose runtime's limit it is counted against; small
 * structs may use it too. A job NULL counts against nothing but half of the machine's memory for one allocation.
 */
#ifndef VVI_CORE_MEMORY_H
#define VVI_CORE_MEMORY_H
#include <volvis/runtime.h>

typedef enum vvi_memory_tag {
    VVI_MEM_MODEL,   /**< objects, text */
    VVI_MEM_VOXELS,  /**< samples that somebody asked for */
    VVI_MEM_DERIVED, /**< min-max cells, gradients, tables: can be made again */
    VVI_MEM_IMAGE,
    VVI_MEM_SCRATCH,
    VVI_MEM_TAGS
} vvi_memory_tag;

/** Without a runtime the limit is a share of the machine, which is read from files: less than this is not worth it. */
enum { VVI_ASK_MACHINE_FROM_BYTES = 16 << 20 };

/** 64-byte aligned, not cleared. NULL when refused; then vv_fail_memory() tells why. Over the limit, the runtime's
 * cache is shed first. The runtime lives until its last allocation is freed. */
void *vvi_alloc(vv_job *job, size_t bytes, vvi_memory_tag tag);
void *vvi_alloc_zeroed(vv_job *job, size_t bytes, vvi_memory_tag tag);
/** On failure the old memory is untouched. */
void *vvi_realloc(vv_job *job, void *memory, size_t bytes, vvi_memory_tag tag);
void vvi_free(void *memory); /* NULL is fine */
/** Whether `bytes` more would fit, shedding the cache; else VV_E_LIMIT with a sentence that says what `what` needs,
 * what the limit is and how to raise it. Ask before long work, not before each allocation. */
vv_status vvi_memory_plan(vv_job *job, uint64_t bytes, const char *what);
/** Counts memory that was not allocated here (shared with another process) as if it were; refused like vvi_alloc().
 * *counted_in is for vvi_memory_give_back(): the runtime, which lives until then, or NULL. */
vv_status vvi_memory_take(vv_runtime **counted_in, vv_job *job, size_t bytes, vvi_memory_tag tag);
void vvi_memory_give_back(vv_runtime *counted_in, size_t bytes, vvi_memory_tag tag);
uint64_t vvi_memory_by_tag(const vv_runtime *runtime, vvi_memory_tag tag);

/** product of n factors, VV_E_LIMIT on overflow. */
vv_status vvi_mul_size(size_t *out, size_t a, size_t b);
vv_status vvi_mul3_size(size_t *out, size_t a, size_t b, size_t c);

/** Small uncounted memory, given back with free(): calloc and realloc that obey vvi_alloc_fail_after(). */
void *vvi_calloc(size_t n, size_t size);
void *vvi_realloc_plain(void *memory, size_t bytes);
/** VV_E_MEMORY where the system has not as much: before a library is called that crashes, or writes what cannot be
 * read, where it is refused memory. Nothing is taken; another thread may take it meanwhile. */
vv_status vvi_memory_is_there(size_t bytes);

/** Small text helpers on malloc memory (NULL when there is none). */
char *vvi_strdup(const char *text);
char *vvi_asprintf(const char *format, ...) VV_PRINTF(1, 2);

/** Tests: every allocation of the process from the n-th on fails (0: none). */
void vvi_alloc_fail_after(int64_t n);
/** Tests: the n-th alone fails. */
void vvi_alloc_fail_once(int64_t n);
/** Tests: whether one has failed since then. */
bool vvi_alloc_has_failed(void);
/** For functions that take memory by other ways than those above: counts one allocation; whether it must fail. */
bool vvi_alloc_fails(void);
#endif
