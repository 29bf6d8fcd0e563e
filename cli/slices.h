/** @file
 * Three slices through the middle of a volume, as colours for a screen.
 */
#ifndef CLI_SLICES_H
#define CLI_SLICES_H
#include "input.h"

/** One slice; row 0 is the top. */
typedef struct cli_slice {
    int64_t n[2];   /**< samples across and down; of very many every k-th is taken */
    double step[2]; /**< world lengths between them */
    float *rgb;     /**< n[0] * n[1] * 3, as a screen has them, 0..1 */
    bool nearest;   /**< labels: never interpolated */
} cli_slice;

#define CLI_SLICES 3

/**
 * Axial, coronal and sagittal as a radiologist looks at them (from the feet, the front and the left) where the space is
 * anatomical, else xy, xz and yz; of flat data the one that there is. Scalars are grey from the 1st to the 99.8th
 * percentile of what is seen, or over their channel's window; channels add up in their colours; labels have theirs.
 *
 * Reads three slabs, or all samples of what is small, mapped, or can be read but once; field: all samples, where they
 * are there already, else NULL. pixels: the longer side of the picture that all of them are for. Finish the slices with
 * cli_slices_finish(), also after a failure.
 */
vv_status cli_slices_read(cli_slice out[CLI_SLICES], int *n_out, const cli_input *input, const vv_field *field,
                          int64_t frame, int pixels, vv_job *job);
void cli_slices_finish(cli_slice slices[CLI_SLICES]);
#endif
