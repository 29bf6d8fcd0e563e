/** @file
 * Classification: from data values to linear colour and extinction.
 *
 * A vv_classification (<volvis/sys/scene.h>) is exact: nodes in data values. Renderers look values up in a table made
 * from it once per frame; empty-space skipping asks the same table, so that no sample is lost between the two.
 *
 * Nodes ascend in value; two nodes at one value make a jump, and the later one holds at the value itself. Values
 * outside take the end nodes. Colour and opacity have nodes of their own.
 */
#ifndef VVI_SCENE_TRANSFER_H
#define VVI_SCENE_TRANSFER_H
#include "core/status.h"
#include <volvis/sys/scene.h>

/** Extinction of what a threshold makes solid: large, yet finite, so that 0 times it is 0 and not NaN. */
#define VVI_KAPPA_SOLID 1e18

/** Rows of a table for values that do not come in 65536 or fewer steps. */
#define VVI_TRANSFER_ROWS 4096

/** Extinction per world length of opacity `alpha` over a length: -ln(1 - alpha) / length, alpha at most 1 - 2^-24. */
double vvi_transfer_kappa(double alpha, double length);

/** What a value is, straight from the nodes: rgbk_out = linear r, g, b, extinction per world length. NaN is clear. */
void vvi_transfer_evaluate(double rgbk_out[4], const vv_classification *classes, double value);

/** The first and the last node, or the ends of a threshold; false: there are none. */
bool vvi_transfer_nodes(double *first_out, double *last_out, const vv_classification *classes);
/** The largest opacity over opacity_length that a value of [a, b] (a <= b) has by the nodes of a transfer function; 0
 * without nodes. */
double vvi_transfer_most_opaque(const vv_classification *classes, double a, double b);
/** Whether any value of [a, b] (a <= b) has extinction above 0; exact. */
bool vvi_transfer_visible(const vv_classification *classes, double a, double b);

/** vvi_transfer_evaluate() of a label. */
void vvi_transfer_label(double rgbk_out[4], const vv_classification *classes, vv_label_id label, bool is_unsigned);

/** A classification at n evenly spaced values. A value's place in it: row = value * scale + offset, clamped to
 * [0, n - 1]; rows between are interpolated or rounded as the reader likes. */
typedef struct vvi_transfer_table {
    float *rgbk;       /**< n rows of r, g, b (linear), extinction per world length; 64-byte aligned */
    uint32_t *running; /**< n + 1: how many of the first i rows have extinction above 0 */
    size_t n;          /**< at least 2 */
    double lo, hi;     /**< values of the first and the last row; the same when all values are one */
    double scale, offset;
} vvi_transfer_table;

/** Which values a table should hold for a field: those between which the classification changes, one row for each
 * stored value where 8 and 16 bit integers (or others that use no more than 65536 of theirs) are shown, else
 * VVI_TRANSFER_ROWS; one for each label. VV_E_LIMIT: labels too far apart. */
vv_status vvi_transfer_domain(double *lo_out, double *hi_out, size_t *n_out, const vv_classification *classes,
                              const vv_field_info *info, const vv_statistics *statistics);

/** How many rows that table has for interpolated samples: rows between the stored values as well, each of which lies on
 * one, until there are VVI_TRANSFER_ROWS; or as many between two as a float still counts exactly. */
size_t vvi_transfer_finer(size_t n, double lo, double hi, const vv_field_info *info);

/** Widens the interval from the first to the last node for a table of n_rows (more than 5), so that the first two rows
 * and the last two lie wholly outside: an end node may be a jump, and beyond the table its outer rows go on. least_row:
 * rows are at least this far apart; above 0 where lo may be hi. */
void vvi_transfer_around(double *lo, double *hi, size_t n_rows, double least_row);

/** How far apart rows must be at a value that lies this far from the one whose lattice number is 0 (lattice.h), of data
 * of this range: closer than floats tell values apart they would only be noise. A range of any size, such as that of
 * data with a fill of 1e30, leaves them close; above 0 where range is. */
double vvi_transfer_least_row(double from_zero, double range);

/** Errors: VV_E_MEMORY, VV_E_LIMIT. Owns: finish it with vvi_transfer_table_finish(); zeroed on failure. */
vv_status vvi_transfer_table_init(vvi_transfer_table *out, const vv_classification *classes, double lo, double hi,
                                  size_t n, vv_job *job);
void vvi_transfer_table_finish(vvi_transfer_table *table); /* zeroed is fine */

/** Whether any of the rows first .. last (clamped, inclusive) is visible: two look-ups. */
static inline bool vvi_transfer_occupied(const vvi_transfer_table *table, int64_t first, int64_t last)
{
    const int64_t top = (int64_t)table->n - 1;
    first = first < 0 ? 0 : first > top ? top : first;
    last = last < 0 ? 0 : last > top ? top : last;
    return table->running[last + 1] != table->running[first];
}

/** The same for values a <= b: every row that linear interpolation at a place between them touches. Exact in double: a
 * reader that finds its places in float, and may land just beyond a row, widens a and b itself. */
bool vvi_transfer_occupancy(const vvi_transfer_table *table, double a, double b);

#endif
