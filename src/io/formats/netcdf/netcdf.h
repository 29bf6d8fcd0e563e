/** @file
 * netCDF: version 4 is HDF5 whose axes have names and coordinates, the dimension scales; older files are refused here.
 */
#ifndef VVI_IO_FORMATS_NETCDF_H
#define VVI_IO_FORMATS_NETCDF_H
#include "core/status.h"
#include "io/source.h"

/** Whether the bytes begin a file of netCDF-3, which MINC 1 and Exodus II are too. */
bool vvi_netcdf3_magic(const uint8_t *head, size_t n);
/** VV_E_UNSUPPORTED: says what it is and which program converts it. */
vv_status vvi_netcdf3_refuse(vv_source *source);
#endif
