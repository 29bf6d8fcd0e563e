/** @file
 * What meshoptimizer does for us.
 */
#ifndef VVI_SURFACE_SIMPLIFY_LIBRARY_H
#define VVI_SURFACE_SIMPLIFY_LIBRARY_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef struct vvi_simplify_call {
    uint32_t *out; /**< room for n_indices */
    const uint32_t *indices;
    size_t n_indices;
    const float *positions; /**< three a vertex */
    size_t n_vertices;
    size_t target_indices;
    double error; /**< most, as a length; INFINITY: any */
    bool fix_border;
    size_t n_out;     /**< set */
    double error_out; /**< set: as a length */
} vvi_simplify_call;

/** False: not enough memory. Any thread. */
bool vvi_simplify_with_library(vvi_simplify_call *call);
/** "0.18" */
const char *vvi_meshoptimizer_version(void);

#ifdef __cplusplus
}
#endif
#endif
