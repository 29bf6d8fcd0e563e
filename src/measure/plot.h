/** @file
 * Plots for papers: one curve or histogram with axes, drawn through the graphics library, so as an image and as SVG.
 */
#ifndef VVI_MEASURE_PLOT_H
#define VVI_MEASURE_PLOT_H
#include "gfx/gfx.h"

/** A vertical line with a name. */
typedef struct vvi_plot_mark {
    double x;
    const char *label;
    bool strong; /**< a threshold, not a percentile */
} vvi_plot_mark;

/** Counts in the plane of x and y: rows of n_x from y lo up. Their colours are a picture under the plot. */
typedef struct vvi_plot_density {
    const uint64_t *counts;
    size_t n_x, n_y;
    double x_lo, x_hi, y_lo, y_hi;
    const char *label; /**< of the scale of colours */
} vvi_plot_density;

typedef struct vvi_plot {
    const char *title, *x_label, *y_label; /**< UTF-8, with units */
    const char *subtitle;                  /**< a smaller line under the title; NULL or "": none */
    const double *x, *y; /**< n points of a curve, gaps where y is NaN; of steps n + 1 edges and n heights */
    size_t n;
    bool steps;                      /**< a histogram: y[i] from x[i] to x[i + 1], filled down to 0 */
    bool log_y;                      /**< of counts: what is 0 is below the axis */
    const vvi_plot_density *density; /**< instead of x and y */
    const vvi_plot_mark *marks;
    size_t n_marks;
    bool no_letters; /**< lines and areas alone, where there is no font */
} vvi_plot;

enum { VVI_PLOT_WIDTH = 960, VVI_PLOT_HEIGHT = 600 };

/** Words that may be any bytes, as names of files are, without what no letters are; NULL stays NULL. */
const char *vvi_plot_words(char *out, size_t room, const char *words);

/** Into a picture of that size that has begun; on white, or of a density on what vvi_plot_paint() made. Errors: those
 * of the calls that draw. */
vv_status vvi_plot_draw(vvi_gfx *gfx, const vvi_plot *plot, vv_job *job);
/** The picture under a density's plot: white, and colours by the logarithm of the counts. */
void vvi_plot_paint(vv_image *image, const vvi_plot *plot);

/** All of it as SVG. Free the text also when this fails. */
vv_status vvi_plot_svg(vvi_text *out, const vvi_plot *plot, vv_job *job);
/** As an image, yours to release also when this fails. *lettered_out: false: there is no font, and the thread's last
 * error says why; lines and areas are there. */
vv_status vvi_plot_image(vv_image **out, bool *lettered_out, const vvi_plot *plot, vv_job *job);
#endif
