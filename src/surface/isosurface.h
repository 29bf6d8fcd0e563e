/** @file
 * The operation isosurface, for who runs it: what it found, and what a scene says beyond its parameters.
 */
#ifndef VVI_SURFACE_ISOSURFACE_H
#define VVI_SURFACE_ISOSURFACE_H
#include "core/status.h"
#include <volvis/field.h>
#include <volvis/property.h>

/** Where no value is given and the field is of no labels, the value that best splits the histogram in two becomes the
 * one of the parameters; *found: there was none. Errors: VV_E_ARGUMENT (no sample is a number), VV_E_MEMORY, VV_E_READ,
 * VV_E_CANCELLED. */
vv_status vvi_isosurface_settle(vv_object *params, bool *found, const vv_field *field, vv_job *job);
/** The values of the surface, which live as long as the parameters; NULL: there are none, or not yet. */
const double *vvi_isosurface_values(const vv_object *params, size_t *n_out);
#endif
