/** @file
 * What a histogram says of an object before anybody has said anything: where the background ends, where the object's
 * values lie, and which value splits the two.
 */
#ifndef VVI_GRID_VALUE_FIT_H
#define VVI_GRID_VALUE_FIT_H
#include <volvis/field.h>

/** Share of the object's samples below its upper end. */
#define VVI_OBJECT_TOP 0.995

/** Values and shares, read off a histogram. */
typedef struct vvi_value_fit {
    bool empty;     /**< no finite sample */
    bool constant;  /**< one value only */
    bool falls;     /**< the background lies above the object: hi is its lower end, and lo the object's far end */
    bool high_peak; /**< there is no background below, but what lies in the fullest bins may be one: see vvi_border */
    bool wide;      /**< the background is a hill of values that vary themselves */
    double lo, hi;  /**< from the end of the background to where the object's values thin out (99.5 %) */
    double share;   /**< of the samples that are the object, in (0, 1] */
    double median;  /**< of the samples that are the object */
    double split;   /**< between the two classes of values that differ most (Otsu 1979) */
} vvi_value_fit;

/** Samples on the six faces of a field, in the bins of its histogram. */
typedef struct vvi_border {
    uint64_t count[1024]; /**< of finite ones */
    uint64_t n;           /**< all */
} vvi_border;

/**
 * The background is the highest peak of the histogram, if it lies in the lower half of the values (up to 99.9 %, so
 * that one hot sample does not count): air, or what was masked out. It ends where the peak has sunk to a fiftieth;
 * of a wide hill, to a tenth; and where it sinks late, in the valley before the next hill.
 * A peak anywhere else is the background if it is what the object stands in: three quarters of the samples of the
 * `border` lie in it, and clearly more than of all samples. The object is then the larger part of the rest, above or
 * below. Where there is no such peak every value is the object.
 *
 * At most a thousandth of the samples that lie further below all others than these reach are no values of the object:
 * dead pixels, padding.
 *
 * border   NULL: nothing is known of it
 */
void vvi_fit_values(vvi_value_fit *out, const vv_statistics *statistics, const vvi_border *border);
/** The same, with a look at the border where it is needed. */
vv_status vvi_fit_field(vvi_value_fit *out, const vv_field *field, int component, const vv_statistics *statistics,
                        vv_job *job);
/** The largest value worth a bin: up to 99.9 %. Where nearly everything is one value the rest is the object, however
 * little it is. */
double vvi_fit_top(const vv_statistics *statistics);
/** The lowest: that of the histogram, but of padding. */
double vvi_fit_bottom(const vv_statistics *statistics);
/** Width of a bin. */
double vvi_bin_width(const vv_statistics *statistics);
/** Value below which `share` of `total` samples lie, from bin `from` on. */
double vvi_quantile_from(const vv_statistics *statistics, int from, double share, double total);
#endif
