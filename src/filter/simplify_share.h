/** @file
 * How much quadric error to allow so that a distance is kept with few triangles.
 */
#ifndef VVI_FILTER_SIMPLIFY_SHARE_H
#define VVI_FILTER_SIMPLIFY_SHARE_H
#include "surface/simplify.h"
#include <volvis/measure_distance.h>

/** The share of options->error, as the error of vvi_mesh_simplify(), with which the fewest triangles are likely to be
 * left when all that has moved farther than the error is put back as it was. Of large meshes some patches tell: seconds
 * less, and the share is a guess in any case. Errors: those of vvi_mesh_simplify(). */
vv_status vvi_simplify_find_share(double *out, const vv_mesh_tree *mesh, const vvi_simplify_options *options,
                                  vv_job *job);
/** Some of a mesh: n triangles at most, in so many patches of neighbours. *out is the caller's. Errors: VV_E_MEMORY. */
vv_status vvi_mesh_patches(vv_mesh **out, const vv_mesh_tree *tree, size_t n, size_t n_patches, vv_job *job);
#endif
