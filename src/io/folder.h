/** @file
 * What a folder holds: one data set of some format, or several, of files and of formats that take many files.
 */
#ifndef VVI_IO_FOLDER_H
#define VVI_IO_FOLDER_H
#include "core/text.h"
#include "io/source.h"

/** A data set of a folder. Its name is that of a part: FOLDER:NAME. */
typedef struct vvi_folder_set {
    char *name;              /**< of the file; of many files their format's, or a pattern of their names */
    const vv_format *format; /**< of many files; NULL: one file */
    size_t n_files;          /**< of pictures and time steps; 0: not counted */
} vvi_folder_set;

/** Zeroed is valid to finish. */
typedef struct vvi_folder {
    const vv_format *format; /**< the folder, or files of it together, is one data set of it; NULL: one file is read */
    const char *part;        /**< what the reader of that is asked for; NULL: nothing */
    vvi_folder_set *set;     /**< choices first; then what is told of beside them; then what is known by name alone */
    size_t n, n_choices, n_told;
    size_t chosen;
    const char *apart; /* why files that are called as time steps are none, and count by themselves; NULL: not known */
} vvi_folder;

/** Which of both the folder is, and which of its data sets is meant: the one that options->part names, or the only
 * one. A picture beside it, or pictures with a scene, are none. With options->any_part several are no error: the first
 * is chosen. VV_E_FORMAT lists them, or says what was tried. out->apart is the caller's. */
vv_status vvi_folder_look(vvi_folder *out, vv_source *folder, const vv_read_options *options, vv_job *job);
/** The data sets as parts of what was chosen, where there are several. */
vv_status vvi_folder_tell(const vvi_folder *sets, vv_source *folder, const vv_read_options *options, vv_notes *notes,
                          vv_job *job);
void vvi_folder_finish(vvi_folder *sets);

/* folder_sets.c */
/** Its data sets, or the format of which it is one as a whole. What else could take it, for want of a choice, is
 * *rest_out, or NULL. `tried`: the formats that were asked. */
vv_status vvi_folder_find(vvi_folder *out, const vv_format **rest_out, vvi_text *tried, vv_source *folder, vv_job *job);
/** Names of the meshes in a folder; of what cannot be listed, none. Free with vvi_names_free(). */
void vvi_folder_meshes(vvi_names *out, const vv_source *folder, vv_job *job);

/* folder_words.c */
/** Names of the folders in a folder that are called as volumes are (.zarr); of what cannot be listed, none. */
void vvi_folder_volumes(vvi_names *out, const vv_source *folder, vv_job *job);
/** Of files whose names differ in a number the pattern that says so: "; if they are time steps of one, say so, as ...",
 * or nothing. */
void vvi_folder_add_series(vvi_text *out, const vvi_folder *sets, const vv_source *folder, vv_job *job);
/** There are several, and none is named. */
vv_status vvi_folder_fail_several(const vvi_folder *sets, const vv_source *folder, vv_job *job);
/** There is none. */
vv_status vvi_folder_fail_none(const vv_source *folder, const char *tried, vv_job *job);
#endif
