/** @file
 * Asking an import program, and listening to it.
 */
#ifndef VVI_IMPORT_LISTEN_H
#define VVI_IMPORT_LISTEN_H
#include "import/import_process.h"
#include "io/notes.h"

/** The file or folder that a path means, opened here: what the import program may read (-1: it opens that itself, as a
 * stream). Where files are read in some places alone, VV_E_READ for others. */
vv_status vvi_import_open_place(int *fd_out, const char *path, const vv_job *job);
/** What each question that opens a file begins with: versions and the path. */
void vvi_import_put_file(vvi_text *out, const char *path, const vv_job *job);
/** And ends with: threads, memory, limits. */
void vvi_import_put_terms(vvi_text *out, const vv_job *job);
/** Takes log lines, progress, notes (NULL: there may be none) and errors, up to the message of kind `last`, which is
 * left to be taken. */
vv_status vvi_import_listen(vvi_import_process *process, vvi_wire_kind last, vvi_wire_in *in, vv_notes *notes,
                            vv_job *job);
#endif
