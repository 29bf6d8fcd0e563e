/** @file
 * Values that stand for none: found where nobody says it, and taken out of a field.
 */
#ifndef VVI_GRID_FILL_VALUE_H
#define VVI_GRID_FILL_VALUE_H
#include "grid/value_fit.h"
#include <volvis/property.h>

enum { VVI_FILLS_MOST = 4, VVI_FILL_TEXT = 320 };

/** One of them: an exact value, or the range that a file says padding has. */
typedef struct vvi_fill {
    double lo, hi; /**< as they are stored */
    double value;  /**< of lo */
    double share;  /**< of all finite samples */
    bool declared; /**< the file says that it is padding */
} vvi_fill;

typedef struct vvi_fills {
    int n;
    vvi_fill fill[VVI_FILLS_MOST];
    double lo, hi; /**< values of all other samples */
} vvi_fills;

/**
 * Exact values at the ends of all others, with nothing in the gap between:
 *
 *   - a number that is written for nothing (-999, -9999, 1e20, 9.96921e36, the least or largest of a type, ...), if it
 *     is a thousandth of the samples and the gap is twice as wide as all others are; eight times at the upper end of a
 *     type of integers, where saturated samples are as well. There may be several, at one end or both;
 *   - any other, if it is a twentieth of the samples and the gap a thousand times as wide;
 *   - padding, as the file says (vvi_field_set_padding()), however few samples, if the gap is a fiftieth as wide.
 *
 * Never 0 that nobody declares, and never beside fewer than 16 different other values: those are masks and levels. Air
 * and padding of CT (-1000, -1024, -2000, ...) that is not declared is among neither.
 *
 * Errors   those of reading
 * Cost     none where the histogram rules it out; else a look at all samples, kept in the job's cache
 */
vv_status vvi_fills_find(vvi_fills *out, const vv_field *field, int component, const vv_statistics *statistics,
                         vv_job *job);

/** The same where statistics are not at hand; of labels none, and none where memory is too
 * short to look. */
vv_status vvi_fills_of(vvi_fills *out, const vv_field *field, int component, vv_job *job);

/** Those that lie between two values stay samples. */
void vvi_fills_keep(vvi_fills *fills, double lo, double hi);
/** Whether one of them lies above the others. */
bool vvi_fills_above(const vvi_fills *fills);
/** Whether a stored number is one of them. */
bool vvi_fills_have(const vvi_fills *fills, double stored);
/** "12 % of the samples are -9999 and 3 % are 9999, far from all others (1 to 300)" */
void vvi_fills_print(char out[VVI_FILL_TEXT], const vvi_fills *fills);
/** vvi_field_without() all of them. */
vv_status vvi_field_without_fills(vv_field **out, const vv_field *field, int component, const vvi_fills *fills,
                                  vv_job *job);

/** A component of a field as floats (doubles where those are too short) that are NaN where it is one of `values`; kept
 * in the job's cache. */
vv_status vvi_field_without(vv_field **out, const vv_field *field, int component, const double *values, size_t n,
                            vv_job *job);

/** The same of all components, for whoever reads them: nothing is kept. */
vv_status vvi_field_all_without(vv_field **out, const vv_field *field, const double *values, size_t n, vv_job *job);
/** The type that their samples have then. */
vv_type vvi_type_without(vv_type type);

typedef struct vvi_missing {
    bool is_named;
    const vv_numbers *named; /**< NULL: none */
    const double *asked;     /**< n_asked values, such as those of surfaces: a fill stays where one asks for it */
    size_t n_asked;
    const char *keep; /**< ends the sentence in the log with what keeps a fill; NULL: nothing */
} vvi_missing;

/** Puts vvi_field_without() in the place of *field, and of its component, which is kept in *component: without the
 * values that are named, or else without a fill that is found, which is said in the log as `who`; NULL: it is not.
 * Labels stay what they are, and so does a fill that memory is too short for. */
vv_status vvi_field_take_missing(vv_field **field, int *component, const vvi_missing *missing, const char *who,
                                 vv_job *job);

/** vvi_fit_values() without a fill, which is said in the log: as `who`, for whom the values are fitted. */
vv_status vvi_fit_without_fill(vvi_value_fit *out, vvi_fills *fills, const vv_field *field, int component,
                               const vv_statistics *statistics, const char *who, vv_job *job);
#endif
