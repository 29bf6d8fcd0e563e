/** @file
 * Triangles of meshes as areas of a figure, one colour each, in the order in which they are painted.
 *
 * What cannot be seen is left out, and triangles in which colours differ are cut into smaller ones. The order is exact:
 * of two areas that overlap the nearer is painted later (the tests of Newell, Newell & Sancha 1972, each pair on the
 * picture), and those that go through each other or cover each other in a circle are cut until there is an order.
 */
#ifndef VVI_GFX_FACETS_H
#define VVI_GFX_FACETS_H
#include "gfx/facet.h"

typedef struct vvi_gfx_facets {
    vvi_gfx_facet *facet;
    size_t n, room;
} vvi_gfx_facets;

/** What is seen of a mesh, whose arrays live until the picture's end: triangles that the target's `hiding` shows to lie
 * behind something, all of them, are left out. Errors: VV_E_ARGUMENT (an index past the vertices), VV_E_LIMIT (more
 * than the target's `triangles`; known before any is made), VV_E_MEMORY, VV_E_CANCELLED. */
vv_status vvi_gfx_facets_add(vvi_gfx_facets *out, vvi_gfx *gfx, const vvi_gfx_surface *surface);
/** When all are there: cut where colours differ, and put in order. Warns where `triangles` does not allow that. */
vv_status vvi_gfx_facets_finish(vvi_gfx_facets *facets, vvi_gfx *gfx);
void vvi_gfx_facets_free(vvi_gfx_facets *facets);

/** Room for n more. */
vv_status vvi_gfx_facets_grow(vvi_gfx_facets *facets, size_t n, vv_job *job);
/** Furthest first, cut where there is no order, up to `most` in all. *whole_out: there was none that could not be cut
 * further. */
vv_status vvi_gfx_facets_order(bool *whole_out, vvi_gfx_facets *facets, size_t most, vv_job *job);
#endif
