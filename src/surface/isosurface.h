/** @file
 * The operation isosurface, for who runs it: what it found, and what a scene says beyond its parameters.
 */
#ifndef VVI_SURFACE_ISOSURFACE_H
#define VVI_SURFACE_ISOSURFACE_H
#include "core/status.h"
#include "surface/labels.h"
#include <volvis/field.h>
#include <volvis/mesh.h>
#include <volvis/property.h>
#include <volvis/sys/registry.h>

/** Beyond the parameters; borrowed, and zero where there is nothing of it. */
typedef struct vvi_isosurface_more {
    const vv_plane *planes; /**< n_planes, in the field's world: only what they keep */
    size_t n_planes;
    const double *top; /**< values above it are outside as well; of one value alone */
    const char *why;   /**< how the value was chosen, for people: ", as in the scene" */
} vvi_isosurface_more;

/** What an operation that makes surfaces of values says of them. params: of its class. */
typedef struct vvi_surface_row {
    /** `more` is used by the operation when it runs with these parameters; NULL: there is nothing. */
    void (*add)(vv_object *params, const vvi_isosurface_more *more);
    /** What vv_operation.settle does, without asking whether they are labels. *found: the value is from the samples. */
    vv_status (*settle_value)(vv_object *params, bool *found, const vv_field *field, vv_job *job);
    /** Whether it makes borders of labels; settled, where the samples decide. */
    bool (*of_labels)(const vv_object *params, const vv_field *field);
    /** *n_out: the triangles that the values of the parameters, which are settled, have in a field, which is small: of
     * all pieces, without caps. On this thread. Errors: those of vvi_marching_values(). */
    vv_status (*count)(size_t *n_out, const vv_object *params, const vv_field *field);
    /** The values of the surface, which live as long as the parameters; NULL: there are none, or not yet. */
    const double *(*values)(const vv_object *params, size_t *n_out);
} vvi_surface_row;
#endif
