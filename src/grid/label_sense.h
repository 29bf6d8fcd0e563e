/** @file
 * Whether integers that nothing is said of are labels: from the samples alone.
 */
#ifndef VVI_GRID_LABEL_SENSE_H
#define VVI_GRID_LABEL_SENSE_H
#include "core/status.h"
#include <volvis/field.h>

/**
 * What sets labels apart from amounts, along rows of an even grid of at most 4096 of them, the most frequent value left
 * out as the background:
 *
 *   - regions are even: of neighbours 4 in 5 are equal, and less than 1 in 20 samples differ from both of theirs
 *     (in CT, MR, microscopy and simulations it is 1 in 3 to 1 in 1, in segmentations 1 in 250 or fewer);
 *   - nearly all values have regions, not only a few of them, as where a scan is clipped at both ends;
 *   - neighbouring regions have any two labels, and not, as steps of an amount have, mostly the next one;
 *   - there are at least 7 of them: a few levels are as often a mask, or a drawing. Two to six besides 0 are enough
 *     where two are beyond 2^24 (and not an end of the type, which is a mark) and no large number divides them all, as
 *     ids of atlases and connectomes are: levels are multiples of a step, and amounts begin near 0. Of so few any two
 *     are next to each other in value, which then says nothing.
 *
 * n_out    how many different labels those rows have; 0: these are amounts
 * Errors   VV_E_MEMORY, VV_E_CANCELLED, and those of reading
 * Cost     some hundredths of a second, once: kept in the job's cache
 */
vv_status vvi_label_sense(size_t *n_out, const vv_field *field, int component, vv_job *job);
/** False: whatever the samples are, they are amounts. */
bool vvi_label_sense_may(const vv_field_info *info);
/** Of n slices every so many are looked at, from the first on. */
int64_t vvi_label_sense_step(int64_t n);
#endif
