/** @file
 * Smoothing a mesh without shrinking it.
 */
#ifndef VVI_SURFACE_SMOOTH_H
#define VVI_SURFACE_SMOOTH_H
#include "core/status.h"
#include <volvis/mesh.h>

/** Fill with vvi_smooth_options_default(), then change what you need. */
typedef struct vvi_smooth_options {
    int iterations; /**< pairs of steps, 0 .. 1000; default 20. Hundreds begin to amplify what is in the pass band */
    double
        pass_band; /**< waves up to this frequency stay, 0 < it < 1/lambda; 0.1, the default, is about 15 edges long */
    double lambda; /**< of the steps that smooth, 0 < it <= 1; default 0.5 */
    bool fix_border; /**< vertices at open edges stay; else they are smoothed along the border alone */
} vvi_smooth_options;

vvi_smooth_options vvi_smooth_options_default(void);

/**
 * A smoother mesh: each vertex moves towards the mean of its neighbours by lambda, then all move back by
 * -mu = lambda / (1 - pass_band lambda), which keeps what is long-waved, and so the volume.
 *
 * Triangles, values, colours and parts are the same; normals, where there were any, are made anew. Vertices at the same
 * place stay together.
 *
 * Errors   VV_E_ARGUMENT (an option out of its range), VV_E_MEMORY, VV_E_LIMIT, VV_E_CANCELLED
 * Owns     *out is the caller's
 * Threads  any; same bytes for any thread count
 * Source   Taubin 1995, "A signal processing approach to fair surface design"
 */
vv_status vvi_mesh_smooth(vv_mesh **out, const vv_mesh *mesh, const vvi_smooth_options *options, vv_job *job);
#endif
