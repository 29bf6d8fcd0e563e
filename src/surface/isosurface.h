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
} vvi_isosurface_more;

/** What an operation that makes surfaces of values says of them. params: of its class. */
typedef struct vvi_surface_row {
    /** `more` is used by the operation when it runs with these parameters; NULL: there is nothing. */
    void (*add)(vv_object *params, const vvi_isosurface_more *more);
    /** Values and labels that are given more than once are taken once, which a warning in the log says. Where no value
     * is given and the field is of no labels, the value that best splits the histogram in two becomes the one of the
     * parameters; *found: there was none. Errors: VV_E_ARGUMENT (no sample is a number), VV_E_MEMORY, VV_E_READ,
     * VV_E_CANCELLED. */
    vv_status (*settle)(vv_object *params, bool *found, const vv_field *field, vv_job *job);
    /** Why there is no surface with these parameters, which are settled: no cells, one value alone, none of the values
     * among the samples'. "" where that is not the reason. Errors: those of vv_field_statistics(). */
    vv_status (*why_empty)(char out[160], const vv_object *params, const vv_field *field, vv_job *job);
    /** *n_out: how many values whole numbers from 0 to 255 have that are made a surface of by a value, when they are 3
     * to 32: what segmentations have that do not say so; else 0. Errors: those of vv_field_statistics(). */
    vv_status (*like_labels)(size_t *n_out, const vv_object *params, const vv_field *field, vv_job *job);
    /** *n_out: the triangles that the values of the parameters, which are settled, have in a field, which is small: of
     * all pieces, without caps. On this thread. Errors: those of vvi_marching_values(). */
    vv_status (*count)(size_t *n_out, const vv_object *params, const vv_field *field);
    /** The values of the surface, which live as long as the parameters; NULL: there are none, or not yet. */
    const double *(*values)(const vv_object *params, size_t *n_out);
} vvi_surface_row;
#endif
