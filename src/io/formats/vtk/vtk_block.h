/** @file
 * One compressed block of VTK's XML files.
 */
#ifndef VVI_IO_VTK_BLOCK_H
#define VVI_IO_VTK_BLOCK_H
#include "io/formats/vtk/vtk_xml.h"

/** False when the block is damaged: it does not give exactly n_out bytes. */
bool vvi_vtk_unpack(vvi_vtk_compressor compressor, void *out, size_t n_out, const void *in, size_t n_in);
/** Whether packed bytes claim to become more than the limits allow. */
bool vvi_vtk_is_bomb(vvi_vtk_compressor compressor, uint64_t bytes, uint64_t packed, const vv_job *job);
/** The limit that says so: "expansion_gzip". */
const char *vvi_vtk_expansion_limit(vvi_vtk_compressor compressor);
/** VV_E_UNSUPPORTED when this build has no such library. */
vv_status vvi_vtk_compressor_available(vvi_vtk_compressor compressor, const char *name);
#endif
