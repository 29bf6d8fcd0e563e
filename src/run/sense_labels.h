/** @file
 * Labels that nobody calls so, for operations that make surfaces.
 */
#ifndef VVI_RUN_SENSE_LABELS_H
#define VVI_RUN_SENSE_LABELS_H
#include <volvis/sys/registry.h>

/**
 * Whole numbers that pictures show as labels (grid/label_sense.h) are labels for an operation too, where its parameters
 * do not say of which value the surface is: then they become those of a surface for each label. Before a file's time
 * step is read: by the slices that would decide it alone.
 *
 * params   of the operation; one without the parameter `label` has no surfaces of labels
 * Errors   VV_E_CANCELLED, and those of reading; what is too large to be looked at whole is taken for amounts
 */
vv_status vvi_sense_labels_of_file(bool *sensed_out, vv_object **params, vv_file *file, int64_t frame, vv_job *job);
#endif
