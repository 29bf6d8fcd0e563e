/** @file
 * Triangles of meshes as areas of a figure, one colour each, furthest first (Newell, Newell & Sancha 1972, by depth
 * alone).
 */
#ifndef VVI_GFX_FACETS_H
#define VVI_GFX_FACETS_H
#include "gfx/shape.h"

typedef struct vvi_gfx_facet {
    const vvi_gfx_shape *shape;
    vv_color color; /**< lit */
    double near;    /**< mean of its corners */
    bool behind;    /**< the target's image, which hides it */
    size_t number;
} vvi_gfx_facet;

typedef struct vvi_gfx_facets {
    vvi_gfx_facet *facet;
    size_t n, room;
} vvi_gfx_facets;

/** What is seen of a mesh: triangles that the target's `hiding` shows to lie behind something, all of them, are left
 * out. Errors: VV_E_LIMIT (more than the target's `triangles`), VV_E_MEMORY, VV_E_CANCELLED. */
vv_status vvi_gfx_facets_add(vvi_gfx_facets *out, vvi_gfx *gfx, const vvi_gfx_surface *surface);
/** Furthest first; those of one depth as they came. */
void vvi_gfx_facets_sort(vvi_gfx_facets *facets);
void vvi_gfx_facets_free(vvi_gfx_facets *facets);
#endif
