/** @file
 * A file of lines that is added to while people work: each line is there whole or not at all, whenever the program ends
 * and however full the disk is.
 */
#ifndef VVI_SERVER_LINE_FILE_H
#define VVI_SERVER_LINE_FILE_H
#include <stdbool.h>

typedef struct vvi_line_file {
    int fd;
    bool torn; /**< part of a line is the last that was written */
    int error; /**< errno of the last line that could not be written */
} vvi_line_file;

/** Adds a line; takes the text (NULL: there was no memory for it), which has no line break. False: it is not there. */
bool vvi_line_file_put(vvi_line_file *file, char *text);
#endif
