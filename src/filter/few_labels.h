/** @file
 * Advice for labels that nobody calls so.
 */
#ifndef VVI_FILTER_FEW_LABELS_H
#define VVI_FILTER_FEW_LABELS_H
#include "core/job.h"
#include "grid/field.h"

/**
 * Tells the job, once, where samples that a filter takes as amounts may be labels: those that are sensed as such
 * (grid/label_sense.h), and 2 to 6 numbers below 256 beside 0, alike with four in five of their neighbours, which sense
 * takes for levels.
 *
 * Errors   VV_E_CANCELLED, and those of reading; what is too large to be looked at whole is not
 * Cost     as sensing them, some hundredths of a second
 */
vv_status vvi_advise_labels(const vv_field *field, vv_job *job);
#endif
