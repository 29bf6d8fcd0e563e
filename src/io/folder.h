/** @file
 * What a folder holds: one data set of some format, or files that are data sets of their own.
 */
#ifndef VVI_IO_FOLDER_H
#define VVI_IO_FOLDER_H
#include "io/source.h"

/** Zeroed is valid to finish. */
typedef struct vvi_folder {
    const vv_format *format; /**< the folder is one data set of it; NULL: one of its files is read */
    vvi_names sets;          /**< then its data sets: volumes first, pictures after them */
    size_t n_volumes, chosen;
    const char *part; /**< what the reader of the file is asked for; NULL: nothing */
} vvi_folder;

/** Which of both the folder is, and which file is meant: the one that options->part names, or the only volume. What
 * lies beside it as one picture, or pictures with a scene, is none. With options->any_part several volumes are no
 * error: the first is chosen. VV_E_FORMAT lists them, or says what was tried. */
vv_status vvi_folder_look(vvi_folder *out, vv_source *folder, const vv_read_options *options, vv_job *job);
/** The data sets as parts of the file that was chosen, where there are several. */
vv_status vvi_folder_tell(const vvi_folder *sets, const vv_source *folder, const vv_read_options *options,
                          vv_notes *notes, vv_job *job);
void vvi_folder_finish(vvi_folder *sets);
#endif
