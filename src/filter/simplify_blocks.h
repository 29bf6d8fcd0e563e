/** @file
 * Large meshes in blocks of neighbours, side by side.
 */
#ifndef VVI_FILTER_SIMPLIFY_BLOCKS_H
#define VVI_FILTER_SIMPLIFY_BLOCKS_H
#include "filter/simplify_attempts.h"

/** Whether a mesh of n triangles is worth it. */
bool vvi_simplify_is_large(size_t n);
/** The same as vvi_simplify_attempts() of a mesh and its own tree, without a budget. Blocks are simplified by
 * themselves, each within the error of its own part of the surface, which is more than is asked for; edges between them
 * stay until all are done, and then what is around them is simplified once more. Open edges stay. A block whose error
 * cannot be kept stays as it was. Same result for any thread count. attempts->after stays NULL, and nothing is seen of
 * the distances; corners are by the mesh's numbers. */
vv_status vvi_simplify_in_blocks(vvi_attempts *attempts, vv_job *job);
#endif
