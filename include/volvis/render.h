/** @file
 * One frame: a World snapshot, one of its views, the renderer that the view names.
 */
#ifndef VOLVIS_RENDER_H
#define VOLVIS_RENDER_H
#include <volvis/image.h>
#include <volvis/model.h>
VV_BEGIN_DECLS

/** What a frame took. */
typedef struct vv_render_report {
    const char *method;
    const char *isa;
    int threads;
    double load_s;    /**< opening and reading data */
    double prepare_s; /**< working out what was left open, derived data */
    double render_s;  /**< tiles */
    uint64_t rays, samples;
} vv_render_report;

/**
 * Render one view over the World's background.
 *
 * view     id in world.views; NULL: the first
 * Errors   VV_E_NOT_FOUND, VV_E_ARGUMENT, VV_E_UNSUPPORTED, VV_E_LIMIT, VV_E_CANCELLED, and those of reading
 * Owns     *out is new and yours; report may be NULL
 * Threads  any; same bytes for any thread count
 */
VV_API vv_status vv_render(vv_image **out, vv_render_report *report, vv_world *world, const char *view, vv_job *job);

/** A named transfer function or colour map. */
typedef struct vv_preset {
    const char *name, *doc;
    const char *kind;       /**< "transfer" or "colormap" */
    const char *value_unit; /**< "HU": nodes are such values; NULL: nodes are over 0..1 and stretched to the range */
} vv_preset;
/** By number; NULL past the end. */
VV_API const vv_preset *vv_preset_nth(size_t index);
/** Colour of a colour map at 0..1, linear; false when there is no map of that name. */
VV_API bool vv_colormap_sample(vv_color *out, const char *name, double at);

VV_END_DECLS
#endif
