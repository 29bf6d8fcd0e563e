/** @file
 * How two volumes differ, sample by sample.
 */
#ifndef CLI_VOLUME_DIFFERENCE_H
#define CLI_VOLUME_DIFFERENCE_H
#include <volvis/field.h>

typedef struct cli_volume_difference {
    double max_difference; /**< of values; INFINITY where one is a number and the other none */
    double rms;
    double psnr; /**< dB against the range of the first; INFINITY when nothing differs; NAN where it has no meaning: the
                  * first is the same everywhere, or somewhere only one of the two is a finite number */
    uint64_t n_different, n_samples;
} cli_volume_difference;

/** Fields of equal dims and components. The same numbers for any thread count. */
vv_status cli_volume_compare(cli_volume_difference *out, const vv_field *a, const vv_field *b, vv_job *job);
/** Largest difference of the places of the grid's corners, in world units. */
double cli_placement_difference(const vv_grid *a, const vv_grid *b);
#endif
