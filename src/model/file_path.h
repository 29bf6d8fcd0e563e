/** @file
 * Paths of data files: relative to the working directory in memory, relative to the scene in scene files.
 */
#ifndef VVI_MODEL_FILE_PATH_H
#define VVI_MODEL_FILE_PATH_H
#include <volvis/base.h>

/** Folder of a file: "." when its path names none. Yours to free(); NULL without memory. */
char *vvi_folder_of(const char *path);
/** From a scene's folder to the working directory. Yours to free(); NULL without memory. */
char *vvi_path_from_folder(const char *folder, const char *path);
/** From the working directory to a scene's folder, where reading it from there finds the same file again: relative
 * paths stay relative unless the folder is absolute, absolute ones become relative below the folder only. */
char *vvi_path_to_folder(const char *folder, const char *path);
#endif
