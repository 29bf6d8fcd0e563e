/** @file
 * Marching Cubes (Lorensen & Cline 1987): the surface where a field has a value, as triangles.
 *
 * Inside is where the value is not below. Vertices lie on the edges between samples, are shared by all triangles around
 * them, and never coincide with a sample, so that the surface of a field whose border is outside is a closed
 * 2-manifold. Rows are classified and counted first and filled in at known places then, as in Flying Edges (Schroeder
 * et al. 2015).
 */
#ifndef VVI_SURFACE_MARCHING_H
#define VVI_SURFACE_MARCHING_H
#include "core/status.h"
#include <volvis/mesh.h>

/** Where a face of a cell has two meanings. */
typedef enum vvi_marching_topology {
    VVI_MARCHING_DECIDED, /**< as the bilinear function on the face says (Nielson & Hamann 1991) */
    VVI_MARCHING_APART    /**< what is inside is always apart: a little faster, and as in most other programs */
} vvi_marching_topology;

typedef struct vvi_marching_options {
    double value; /**< of the surface, in the field's values */
    int component;
    vvi_marching_topology topology;
    bool no_normals;
    bool cap;    /**< closes the surface at the border of the volume, or of the box */
    bool blocks; /**< only blocks of cells are read that hold the value: their least and greatest samples come from the
                    cache, or are made for it, which pays from the second value on */
    vv_box box;  /**< samples that are looked at; n[0] = 0: all. Normals at its border are one-sided */
} vvi_marching_options;

/** Same bytes for any thread count and instruction set but for rounding of fused multiplications. Cells with a sample
 * that is no number are left out; infinite samples are as very large ones.
 * Memory: the mesh, and rows of bits for each thread. The caller releases *out. Errors: VV_E_ARGUMENT (no such
 * component, value not finite, box outside the field), VV_E_UNSUPPORTED (labels), VV_E_LIMIT, VV_E_MEMORY, VV_E_READ,
 * VV_E_CANCELLED. */
vv_status vvi_marching_cubes(vv_mesh **out, const vv_field *field, const vvi_marching_options *options, vv_job *job);
/**
 * vvi_marching_cubes() for each of n values (that of the options is not looked at), as a mesh with a part for each,
 * named after it: "300". The samples are read once, and every piece of
 * them is searched for all values in turn.
 *
 * Errors   those of vvi_marching_cubes(); VV_E_ARGUMENT for no values
 * Owns     *out is the caller's
 */
vv_status vvi_marching_values(vv_mesh **out, const vv_field *field, const double *values, size_t n,
                              const vvi_marching_options *options, vv_job *job);
#endif
