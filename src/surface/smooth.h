/** @file
 * Smoothing a mesh without shrinking it.
 */
#ifndef VVI_SURFACE_SMOOTH_H
#define VVI_SURFACE_SMOOTH_H
#include "core/status.h"
#include <volvis/mesh.h>

/** Fill with vvi_smooth_options_default(), then change what you need. */
typedef struct vvi_smooth_options {
    int iterations;   /**< pairs of steps, 0 .. 1000; default 20: the more, the more sharply long waves are told from
                         short   ones */
    double pass_band; /**< waves up to this frequency stay, 0 < it < 2; 0.1, the default, is about 15 edges long */
    bool fix_border;  /**< vertices at open edges stay; else they are smoothed along the border alone */
} vvi_smooth_options;

vvi_smooth_options vvi_smooth_options_default(void);

/**
 * A smoother mesh, by a filter that takes out what is short-waved and never amplifies: vvi_smooth_filter_make().
 *
 * Then each closed piece gets its volume back: all its vertices move along their normals by one and the same distance.
 * Where the filter has changed the volume by more than a twentieth, which only a piece of few waves suffers, the piece
 * is filtered again with twice the pass band, and so on, in the end not at all.
 *
 * Triangles, values, colours and parts are the same; normals, where there were any, are made anew. Vertices at the same
 * place stay together.
 *
 * Errors   VV_E_ARGUMENT (an option out of its range), VV_E_MEMORY, VV_E_LIMIT, VV_E_CANCELLED
 * Owns     *out is the caller's
 * Threads  any; same bytes for any thread count
 * Source   Taubin 1995, "A signal processing approach to fair surface design", for surfaces as signals; Taubin, Zhang &
 *          Golub 1996, "Optimal surface smoothing as filter design", for Chebyshev polynomials
 */
vv_status vvi_mesh_smooth(vv_mesh **out, const vv_mesh *mesh, const vvi_smooth_options *options, vv_job *job);
#endif
