/** @file
 * What labels there are in samples, and where.
 */
#ifndef VVI_IO_NRRD_SCAN_H
#define VVI_IO_NRRD_SCAN_H
#include "io/formats/nrrd/nrrd.h"

typedef struct vvi_nrrd_scan {
    vv_label_id *value; /* that occur, but 0; ascending */
    size_t n_values;
    bool many;                    /* there are more */
    int64_t box[6];               /* first and last sample of all of them along x, y, z; 0 -1 without any */
    uint64_t n_labelled, n_alone; /* samples that are not 0; of these, other than both neighbours along x */
} vvi_nrrd_scan;

/** Of a field of whole numbers with one component. To be finished, also after a failure. */
vv_status vvi_nrrd_scan_labels(vvi_nrrd_scan *out, const vv_field *field, vv_job *job);
void vvi_nrrd_scan_finish(vvi_nrrd_scan *scan); /* zeroed is fine */
#endif
