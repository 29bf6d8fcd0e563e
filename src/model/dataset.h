/** @file
 * What datasets have in memory.
 */
#ifndef VVI_MODEL_DATASET_H
#define VVI_MODEL_DATASET_H
#include "model/classes.h"
#include <volvis/field.h>
#include <volvis/mesh.h>

/** Frame 0 of each attribute, or a mesh; never changes once attached. */
struct vv_dataset_fields {
    uint32_t refs; /**< atomic */
    vv_mesh *mesh; /**< NULL: none */
    size_t n;
    vv_field *field[];
};

/** One field for a dataset that nobody shares yet; retains it. What was attached is given back. */
vv_status vvi_dataset_attach(vv_dataset *dataset, const vv_field *field);
/** The same for a mesh. */
vv_status vvi_dataset_attach_mesh(vv_dataset *dataset, const vv_mesh *mesh);
/** The attached field of that attribute (NULL: the first), borrowed; NULL when there is none. */
const vv_field *vvi_dataset_attached(const vv_dataset *dataset, const char *name);
#endif
