/** @file
 * Files that are none: samples that come from elsewhere, for whoever works on files.
 */
#ifndef VVI_IO_DATA_FILE_H
#define VVI_IO_DATA_FILE_H
#include "io/notes.h"

/** Where the samples come from. */
typedef struct vvi_data_source {
    vv_status (*read)(vv_field **out, void *user, int64_t frame, vv_job *job); /**< all samples of a time step */
    void (*drop)(void *user);
    void *user;
} vvi_data_source;

/** A file of such samples; its format is called "made". Takes notes and source, also when it fails. name: in errors. */
vv_status vvi_file_of_data(vv_file **out, const char *name, const vv_field_info *info, vv_notes *notes,
                           const vvi_data_source *source, vv_job *job);
/** The samples come from another file, of which headers know more than notes say; it is closed with this one.
 * new_values: they no longer have its values. */
void vvi_file_take_origin(vv_file *file, vv_file *origin, bool new_values);
/** That file; the file itself, where it comes from no other. */
const vv_file *vvi_file_origin(const vv_file *file, bool *new_values_out);
/** What it is built from (file.c); takes plan and notes, also when it fails. */
vv_status vvi_file_of_plan(vv_file **out, const char *name, const vv_format *format, void *plan,
                           const vv_field_info *info, vv_notes *notes, vv_job *job);
#endif
