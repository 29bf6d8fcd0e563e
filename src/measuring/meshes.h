/** @file
 * What is told of a mesh, or of several together.
 */
#ifndef VVI_MEASURING_MESHES_H
#define VVI_MEASURING_MESHES_H
#include "measuring/measuring.h"
#include <volvis/measure_mesh.h>

enum { VVI_MESH_AREA = 1, VVI_MESH_VOLUME = 2, VVI_MESH_BOX = 4, VVI_MESH_ALL = 7 };

/** Some of these figures. */
void vvi_mesh_measures_put(vv_answer *answer, unsigned what, const vv_mesh_measures *measures, const char *unit);
#endif
