/** @file
 * Figures of a measurement then and now.
 */
#ifndef VVI_MEASURING_FIGURE_CHANGES_H
#define VVI_MEASURING_FIGURE_CHANGES_H
#include <volvis/model.h>

/** The figure that says which time step of a series was measured; scenes of older versions do not have it. */
#define VVI_TIME_STEP "time_step"

typedef struct vvi_change {
    const vv_measured_figure *was, *now; /**< NULL: there is none; never both */
    bool changed;                        /**< by more than another processor may make of the last digits */
} vvi_change;

/** Borrows the figures. */
typedef struct vvi_changes {
    vvi_change *change; /**< those of now in their order, then those that are gone */
    size_t n, n_changed;
    bool compared; /**< there were figures before: without them nothing has changed */
} vvi_changes;

/** then, now: of vv_measured_figure. Free it with vvi_changes_free(). */
vv_status vvi_changes_find(vvi_changes *out, const vv_collection *then, const vv_collection *now);
void vvi_changes_free(vvi_changes *changes);
const char *vvi_change_name(const vvi_change *change);
/** NaN: there is none, none is known; of no figure too. */
double vvi_measured_value(const vv_measured_figure *figure);
double vvi_measured_error(const vv_measured_figure *figure);
/** Never NULL. */
const char *vvi_measured_unit(const vv_measured_figure *figure);
#endif
