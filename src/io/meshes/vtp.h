/** @file
 * VTK's XML polygons. https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
 */
#ifndef VVI_IO_VTP_H
#define VVI_IO_VTP_H
#include "io/meshes/mesh_builder.h"

vv_status vvi_vtp_write(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job);
#endif
