/** @file
 * What is told of a mesh, or of several together.
 */
#ifndef VVI_MEASURING_MESHES_H
#define VVI_MEASURING_MESHES_H
#include "measuring/measuring.h"
#include <volvis/measure_mesh.h>

/** The figures that `what` asks for. */
void vvi_mesh_measures_put(vv_answer *answer, unsigned what, const vv_mesh_measures *measures, const char *unit);
#endif
