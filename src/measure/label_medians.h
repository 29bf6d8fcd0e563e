/** @file
 * The medians of many labels at once, exactly and however far out a few samples lie: each label counts its samples in
 * bins of the integers that rise with them (grid/selection.h), first over its range, then within the bin that holds the
 * middle, until a bin is one number. Passes are the caller's.
 */
#ifndef VVI_MEASURE_LABEL_MEDIANS_H
#define VVI_MEASURE_LABEL_MEDIANS_H
#include "grid/field.h"

#include <stddef.h>
#include <stdint.h>

/** Where the search for one label is. */
typedef struct vvi_label_middle vvi_label_middle;

typedef struct vvi_label_medians {
    vv_type type;
    size_t n;         /**< labels */
    size_t first, in; /**< those that are counted now: as many as there is memory for */
    vvi_label_middle *middle;
    _Atomic uint64_t *bins;
} vvi_label_medians;

/** For `n` labels of samples of a type. End it also when it fails. */
vv_status vvi_label_medians_begin(vvi_label_medians *m, size_t n, vv_type type, vv_job *job);
/** Label `at` has `count` finite samples, from min to max; labels that are not set have none. */
void vvi_label_medians_set(vvi_label_medians *m, size_t at, uint64_t count, double min, double max);
/** Whether another pass is needed; it goes over all samples with vvi_label_medians_take(). */
bool vvi_label_medians_next(vvi_label_medians *m);
/** Samples of label `at`; from any thread. */
void vvi_label_medians_take(vvi_label_medians *m, size_t at, const char *samples, int64_t stride, int64_t n);
/** The stored number, when no other pass is needed; of an even number of samples the mean of the two in the middle. */
double vvi_label_medians_get(const vvi_label_medians *m, size_t at);
void vvi_label_medians_end(vvi_label_medians *m);
#endif
