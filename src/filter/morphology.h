/** @file
 * Morphology of fields: the least or the greatest sample within an element around each, one after the other.
 */
#ifndef VVI_FILTER_MORPHOLOGY_H
#define VVI_FILTER_MORPHOLOGY_H
#include "core/job.h"
#include "filter/element.h"
#include "grid/field.h"

/** Dilations and erosions in their order. */
typedef struct vvi_morphology {
    const char *name; /**< of the filter */
    vvi_element element;
    int n_steps; /**< 1 or 2 */
    bool erodes[2];
} vvi_morphology;

/** A box of what becomes of amounts. Beyond the border nothing counts, nor do NaN, which stay. */
vv_status vvi_morphology_of_values(vv_field **out, const vv_field *in, const vv_box *box, const vvi_morphology *m,
                                   vv_job *job);
/** Of labels: each by itself, and 0 is none. What grows takes only what has no label; if several come there, the
 * nearest has it, of equally near ones and after closing the one with the lowest id. only: NULL, or the one that
 * changes. */
vv_status vvi_morphology_of_labels(vv_field **out, const vv_field *in, const vv_box *box, const vvi_morphology *m,
                                   const vv_label_id *only, vv_job *job);
#endif
