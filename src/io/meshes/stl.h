/** @file
 * STL: triangles whose corners are written out, in two forms. 3D Systems, StereoLithography Interface Specification
 * (1989); colours of VisCAM and Materialise in the 16 bits after each triangle.
 */
#ifndef VVI_IO_STL_H
#define VVI_IO_STL_H
#include "io/meshes/mesh_builder.h"

enum { VVI_STL_HEADER = 80, VVI_STL_FACET = 50 };

vv_status vvi_stl_read(vv_mesh **out, vv_source *source, const vv_mesh_read_options *options, vv_notes *notes,
                       vv_job *job);
vv_status vvi_stl_write(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job);
#endif
