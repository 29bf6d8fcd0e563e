/** @file
 * Fewer triangles, with a largest distance that is kept.
 */
#ifndef VVI_FILTER_SIMPLIFY_WITHIN_H
#define VVI_FILTER_SIMPLIFY_WITHIN_H
#include "filter/simplify.h"
#include <volvis/measure_distance.h>

/** Simplifies so that neither surface is farther than options->error, above 0, from the other. told->distance: at most
 * that, but where it cannot be kept. *out is the caller's; NULL on errors: those of vvi_mesh_simplify(). */
vv_status vvi_simplify_within(vv_mesh **out, vvi_simplify_told *told, const vv_mesh *mesh,
                              const vvi_simplify_options *options, vv_job *job);
/** The largest distance of either surface from the other, at vertices and between them. */
vv_status vvi_simplify_measure(vv_figure *out, const vv_mesh_tree *before, const vv_mesh_tree *after, vv_job *job);
#endif
