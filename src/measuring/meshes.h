/** @file
 * What is told of a mesh, or of several together.
 */
#ifndef VVI_MEASURING_MESHES_H
#define VVI_MEASURING_MESHES_H
#include "measuring/measuring.h"
#include <volvis/measure_mesh.h>

/** The figures that `what` asks for. */
void vvi_mesh_measures_put(vv_answer *answer, unsigned what, const vv_mesh_measures *measures, const char *unit);
/** Says so where nothing of it is left. */
void vvi_measuring_note_no_triangles(vvi_measuring *m, const vv_mesh_measures *found);
/** Those of what is in a region of n planes, closed with flat faces that are no part of the area. */
vv_status vvi_measure_mesh_within(vv_mesh_measures *out, const vvi_measuring *m, const vv_plane *region, size_t n);
/** What a scene shows of a mesh, in its World: where it is placed, and what planes leave of it. */
vv_status vvi_shown_mesh(vv_mesh **out, const vv_measured_data *shown, vv_job *job);
#endif
