/** @file
 * Files that are parts of a larger data set: each a volume of its own that any format of the table may read.
 */
#ifndef VVI_IO_FILE_BESIDE_H
#define VVI_IO_FILE_BESIDE_H
#include "io/source.h"

/** vv_file_open() of a file in a folder, or beside a header, by its name there; its warnings are kept and not logged.
 * VV_E_FORMAT where it is a collection of files itself. */
vv_status vvi_file_open_beside(vv_file **out, const vv_source *folder, const char *name, const vv_read_options *options,
                               vv_job *job);
#endif
