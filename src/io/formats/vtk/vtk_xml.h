/** @file
 * VTK's files of grids as their headers say it. Parts: vtk_xml.c (the tags of .vti and .vtr), vtk_legacy.c (the lines
 * of .vtk), vtk_array.c (bytes and numbers of one array: plain, base64, text, compressed blocks), vtk_grid.c (arrays
 * and pieces to a field), vtk_samples.c (reading them), vtk_file.c (what is kept of a file), vtk_stream.c (bytes in
 * place or in base64), vtk_notes.c (metadata), vti_tags.c and vti_write.c; vti.c, vtr.c and vtk.c (the rows).
 * https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
 */
#ifndef VVI_IO_VTK_XML_H
#define VVI_IO_VTK_XML_H
#include "io/layout.h"
#include "io/notes.h"
#include "io/rectilinear.h"

typedef enum vvi_vtk_section {
    VVI_VTK_POINTS,
    VVI_VTK_CELLS,
    VVI_VTK_FIELD,       /* data of the whole set: times, names */
    VVI_VTK_COORDINATES, /* of a rectilinear grid: three arrays */
    VVI_VTK_PLACES,      /* of points, of polygons */
    VVI_VTK_POLYS,
    VVI_VTK_STRIPS,
    VVI_VTK_NOWHERE
} vvi_vtk_section;

typedef enum vvi_vtk_compressor {
    VVI_VTK_PLAIN,
    VVI_VTK_ZLIB,
    VVI_VTK_LZ4,
    VVI_VTK_LZMA,
    VVI_VTK_UNKNOWN
} vvi_vtk_compressor;

typedef enum vvi_vtk_form { VVI_VTK_RAW, VVI_VTK_BASE64, VVI_VTK_TEXT } vvi_vtk_form;

typedef struct vvi_vtk_array {
    char *name; /* "" when it has none */
    char *type_name;
    vvi_vtk_section section;
    size_t piece;
    bool has_type; /* else it is text */
    vv_type type;
    int components;
    int64_t tuples;        /* of field data; 0: not said */
    bool scalars, vectors; /* the active ones of its section */
    bool bits;             /* of type u8; bytes of the file have eight of them */
    bool fractions;        /* text has 0 to 1 for the bytes 0 to 255 */
    vvi_vtk_form form;
    bool appended;
    uint64_t begin, end; /* bytes of the file; begin of appended data counts from its mark until the parse is over */
} vvi_vtk_array;

typedef struct vvi_vtk_piece {
    int64_t extent[6]; /* first and last point along x, y, z */
    /* of polygons: points; cells of other kinds, which come before them; polygons; strips */
    int64_t n_points, n_before, n_polys, n_strips;
} vvi_vtk_piece;

typedef struct vvi_vtk_file {
    const char *name; /* of the source; in errors */
    bool rectilinear, polygons, big_endian, has_spacing, cut;
    size_t word; /* bytes of a number in the headers of arrays: 4 or 8; 0: they have none */
    vvi_vtk_compressor compressor;
    int64_t whole[6];
    double origin[3], spacing[3], direction[9]; /* direction: rows of a matrix */
    vvi_vtk_piece *piece;
    size_t n_pieces;
    vvi_vtk_array *array;
    size_t n_arrays, array_room;
} vvi_vtk_file;

/** `kind` is "ImageData", "RectilinearGrid" or "PolyData"; any other is refused. */
vv_status vvi_vtk_parse(vvi_vtk_file *out, const char *kind, vv_source *source, vv_job *job);
void vvi_vtk_finish(vvi_vtk_file *file); /* zeroed is fine */
/** One more array; the texts are copied. */
vv_status vvi_vtk_add_array(vvi_vtk_file *file, const vvi_vtk_array *array, const char *name, const char *type_name,
                            vv_job *job);

vv_status vvi_vtk_copy_text(char **out, const char *text, vv_job *job); /* frees what was there; NULL is "" */
/** Room for one more than n items of `size` bytes; `items` points to the array. */
vv_status vvi_vtk_grow(void *items, size_t n, size_t *room, size_t size, vv_job *job);

/* Arrays ---------------------------------------------------------------------------------------------------------- */

typedef struct vvi_vtk_reader vvi_vtk_reader;

/** Looks at the array's header: VV_E_FORMAT when it does not hold n numbers, or half of them cannot arrive. */
vv_status vvi_vtk_open(vvi_vtk_reader **out, const vvi_vtk_file *file, const vvi_vtk_array *array, uint64_t n,
                       vv_source *source, vv_job *job);
void vvi_vtk_close(vvi_vtk_reader *reader); /* NULL is fine */
/** Where its numbers lie as plain bytes of the file. False when they do not. */
bool vvi_vtk_plain(uint64_t *offset_out, const vvi_vtk_reader *reader);
/** Its numbers, in the byte order of the file (text: of the machine). */
vvi_elements vvi_vtk_elements(vvi_vtk_reader *reader);
/** VV_OK, or VV_E_FORMAT when more than half of what was read was damaged; less damages the job. */
vv_status vvi_vtk_check(const vvi_vtk_reader *reader);
/** Whether its elements have another byte order than the machine. */
bool vvi_vtk_swapped(const vvi_vtk_file *file, const vvi_vtk_array *array);
/** All of a small array as doubles, yours to vvi_free(). */
vv_status vvi_vtk_numbers(double **out, const vvi_vtk_file *file, const vvi_vtk_array *array, uint64_t n,
                          vv_source *source, vv_job *job);

/* Fields ---------------------------------------------------------------------------------------------------------- */

/** What is read of a file: one array, on points or at the centres of cells. */
typedef struct vvi_vtk_plan {
    vvi_vtk_file file;
    size_t chosen; /* an array of the first piece */
    bool mappable;
    double missing;       /* share of the grid that no piece has */
    vvi_layout layout;    /* of a file of one piece */
    vv_field_info stored; /* of the samples as they are in the file */
    vvi_axes *uneven;     /* of a rectilinear grid that is resampled; NULL: as it is */
} vvi_vtk_plan;

/** How many samples an extent of points has. */
void vvi_vtk_samples_of(int64_t out[3], const int64_t extent[6], bool cells);
/** The chosen array in a piece. */
vv_status vvi_vtk_find_in_piece(const vvi_vtk_array **out, const vvi_vtk_plan *plan, size_t piece);
void vvi_vtk_lay_out(vvi_layout *out, const vvi_vtk_file *file, const vvi_vtk_array *array, const int64_t extent[6]);

typedef vv_status vvi_vtk_parse_fn(vvi_vtk_file *out, vv_source *source, vv_notes *notes, vv_job *job);
/** Parses, chooses the array and fills info and plan: the whole of vv_format.read_header for a kind of file. */
vv_status vvi_vtk_read_header(vv_field_info *info, void **plan_out, vvi_vtk_parse_fn *parse, vv_source *source,
                              const vv_read_options *options, vv_notes *notes, vv_job *job);
void vvi_vtk_free_plan(void *plan);
bool vvi_vtk_mappable(const vv_field_info *info, const void *plan);
vv_status vvi_vtk_read(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source, int64_t frame,
                       const vv_box *region, vv_job *job);
/** What the field data say: metadata, and what our own writer noted there. */
vv_status vvi_vtk_read_notes(vv_field_info *info, const vvi_vtk_file *file, vv_source *source, vv_notes *notes,
                             vv_job *job);
#endif
