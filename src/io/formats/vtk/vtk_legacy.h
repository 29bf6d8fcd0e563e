/** @file
 * VTK's old files, .vtk, as lines of text with data between them.
 */
#ifndef VVI_IO_VTK_LEGACY_H
#define VVI_IO_VTK_LEGACY_H
#include "io/formats/vtk/vtk_xml.h"

typedef struct vvi_vtk_lines {
    vv_source *source;
    vv_job *job;
    vvi_vtk_file *file;
    vvi_vtk_section section;
    bool binary;
    bool over;             /* the file ends inside of data */
    int64_t n[2];          /* points and cells of the grid */
    int64_t n_here;        /* of the section */
    bool scalars, vectors; /* the section has active ones */
} vvi_vtk_lines;

/** One of the statements that begin arrays of points, cells or fields, its words split; *known_out: it was one. Its
 * data are passed over. */
vv_status vvi_vtk_attribute(vvi_vtk_lines *p, bool *known_out, char **word, int n_words);
/** An array of n samples, whose data begin where the source stands; passes over them. */
vv_status vvi_vtk_take_array(vvi_vtk_lines *p, vvi_vtk_array *array, const char *name, const char *type_name,
                             uint64_t n);
/** The next line that is not blank, split at white space; *n_words is 0 at the end. The words stay until the next call.
 */
vv_status vvi_vtk_words(vvi_vtk_lines *p, char **word, int most, int *n_words);
#endif
