/** @file
 * Exact Euclidean distances, axis by axis (Maurer, Qi & Raghavan 2003): along x from each sample to the nearest one of
 * a set in its row; along y and z the lower envelope of parabolas over what the axes before it have left.
 */
#ifndef VVI_SEGMENT_DISTANCE_LINES_H
#define VVI_SEGMENT_DISTANCE_LINES_H
#include "core/status.h"
#include <volvis/runtime.h>

/** Bytes of row `row`, 1 for each sample of the set: called by any thread. */
typedef void vvi_set_row(uint8_t *out, size_t row, void *user);

/** out: distance of each sample from the nearest of the set, x fastest; INFINITY where the set is empty. spacing: of
 * axes at right angles. */
vv_status vvi_distances(float *out, const int64_t n[3], const double spacing[3], vvi_set_row *set, void *user,
                        vv_job *job);
/** The axes from `first` up to, not with, `end` alone, of n samples of a volume: the squares of distances that the axes
 * before have left become those that these leave, and distances after axis `last`, the last of the volume that has
 * several samples. set is for axis 0. */
vv_status vvi_distances_along(float *out, const int64_t n[3], const double spacing[3], const int axes[2], int last,
                              vvi_set_row *set, void *user, vv_job *job);
int vvi_distances_last(const int64_t n[3]);
#endif
