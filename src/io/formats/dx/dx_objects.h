/** @file
 * What is kept of a .dx file: objects that name each other, which are arrays (where their data lie), grids and fields.
 */
#ifndef VVI_IO_DX_OBJECTS_H
#define VVI_IO_DX_OBJECTS_H
#include "io/formats/dx/dx.h"

#define VVI_DX_WORD 256

typedef enum vvi_dx_kind { VVI_DX_OTHER, VVI_DX_ARRAY, VVI_DX_GRID, VVI_DX_FIELD } vvi_dx_kind;

typedef struct vvi_dx_object {
    char name[VVI_DX_WORD];
    char class_name[32];
    vvi_dx_kind kind;
    /* array */
    vv_type type;
    bool has_type, not_real, text, big_endian, cells, follows;
    int64_t items;
    int rank, components;
    char file[VVI_DX_WORD];
    uint64_t offset; /* of data that follow: in the file; else from where the data begin */
    vvi_dx_grid grid;
    char data[VVI_DX_WORD], positions[VVI_DX_WORD]; /* of a field: names of objects */
} vvi_dx_object;

typedef struct vvi_dx_objects {
    vv_source *source; /* stands behind the header */
    vvi_dx_object *object;
    size_t n_objects;
} vvi_dx_objects;

/** The objects are yours to vvi_free(), also on failure. */
vv_status vvi_dx_read_objects(vvi_dx_objects *out, vv_source *source, vv_job *job);
#endif
