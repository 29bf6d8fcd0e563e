/** @file
 * Histograms without what a smooth field has blurred them with.
 */
#ifndef VVI_FILTER_SHARPEN_H
#define VVI_FILTER_SHARPEN_H
#include <stdbool.h>
#include <stddef.h>

enum { VVI_SHARPEN_BINS = 200 };

/** What each bin's value is expected to have been. */
typedef struct vvi_sharpened {
    double lo, width; /**< centre of the first bin; from one to the next */
    double expected[VVI_SHARPEN_BINS];
} vvi_sharpened;

/** Of n numbers, of which NaN do not count: their histogram is divided by a Gaussian of full width `blur` at half of
 * its height, with Wiener's filter for `noise` (Sled, Zijdenbos & Evans 1998). False: there are not two different ones.
 */
bool vvi_sharpen(vvi_sharpened *out, const double *v, size_t n, double blur, double noise);
double vvi_sharpened_value(const vvi_sharpened *s, double v);
#endif
