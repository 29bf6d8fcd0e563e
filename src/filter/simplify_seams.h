/** @file
 * Where blocks of a mesh that were simplified by themselves meet.
 */
#ifndef VVI_FILTER_SIMPLIFY_SEAMS_H
#define VVI_FILTER_SIMPLIFY_SEAMS_H
#include "filter/simplify_attempts.h"
#include "surface/chosen_triangles.h"

/** Simplifies what is around seams, within how->error of how->before, which all of it is within already. seam: of each
 * vertex of the mesh: 1: it is on a seam; 0: it is not. Surfaces that touch are cut apart; the edges that more than two
 * triangles still share are counted. Nothing changes where the error cannot be kept. Errors: those of
 * vvi_mesh_simplify(). */
vv_status vvi_simplify_seams(vvi_chosen *chosen, size_t *n_crowded_out, const uint8_t *seam, const vvi_attempts *how,
                             vv_job *job);
#endif
