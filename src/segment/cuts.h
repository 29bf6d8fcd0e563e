/** @file
 * Values that divide samples into classes, found in their histogram: of integers that span at most 65536 numbers one
 * bin each, which is exact; else of 65536 equal bins over all finite samples.
 */
#ifndef VVI_SEGMENT_CUTS_H
#define VVI_SEGMENT_CUTS_H
#include "core/status.h"
#include <volvis/run.h>

#define VVI_CUTS_MOST 31

typedef enum vvi_cut_method {
    VVI_CUT_OTSU, /**< least variance within classes: Otsu 1979, of many classes Liao, Chen & Chung 2001, exactly */
    VVI_CUT_MEAN,
    VVI_CUT_LI /**< least cross-entropy: Li & Lee 1993, by the iteration of Li & Tam 1998 */
} vvi_cut_method;

/** Class c is of values from above[c - 1] on that are below above[c]. */
typedef struct vvi_cuts {
    int n;
    double above[VVI_CUTS_MOST]; /**< where the class above begins; of whole numbers between two of them */
    double told[VVI_CUTS_MOST];  /**< classes above have larger values than this: what people are told */
} vvi_cuts;

/** Of n_classes, 2 except for Otsu's method, over all fields of a series, which have one type and scale. Errors:
 * VV_E_ARGUMENT where there are fewer different values than classes; those of reading. */
vv_status vvi_cuts_find(vvi_cuts *out, vvi_cut_method method, int n_classes, const vv_field_series *series,
                        vv_job *job);
/** The same of one field, kept in the job's cache. */
vv_status vvi_cuts_of_field(vvi_cuts *out, vvi_cut_method method, int n_classes, const vv_field *field, vv_job *job);

/** Centres of the bins that are not empty, rising, and their counts. */
typedef struct vvi_histogram {
    size_t n;
    double *value, *count;
    double width;  /**< of a bin */
    bool is_exact; /**< a bin has samples of its centre alone */
} vvi_histogram;

/** The last bins of all classes but the highest. */
vv_status vvi_otsu(size_t *last_of_class, const vvi_histogram *h, int n_classes, vv_job *job);
/** Larger values than this are the upper class. */
double vvi_li(const vvi_histogram *h);
#endif
