/** @file
 * Rows between the rows of a classification's table, where it is too steep for them.
 *
 * A table has evenly spaced rows, and a value takes the nearest. Where colour or opacity change by more than can be
 * seen from one row to the next, or a node or a jump lies between two, the values of that row are shared among rows of
 * its own. They stand behind all others.
 */
#ifndef VVI_RENDER_TRANSFER_FINE_H
#define VVI_RENDER_TRANSFER_FINE_H
#include "scene/transfer.h"

typedef struct vvi_transfer_fine {
    uint32_t *first, *parts; /**< of each row of the table: its own rows from `first` on (at n or beyond); parts 0: it
                                has none. parts is odd: the middle of the middle one is the row's own value */
    float *rgbk;             /**< n_rows rows, of which the first is number n; NULL where no row is split */
    size_t n_rows;
} vvi_transfer_fine;

/** Colour, and opacity of a step this long, are within 3e-4 then but for a 243rd of a row beside a jump; unless that
 * took more than 2^18 rows, and within 1e-3 where no row is split. The table's `running` becomes that with its finer
 * rows. Not for labels. Errors: VV_E_MEMORY. Finish it with vvi_transfer_fine_finish(); zeroed on failure. */
vv_status vvi_transfer_fine_init(vvi_transfer_fine *out, vvi_transfer_table *table, const vv_classification *classes,
                                 double step, vv_job *job);
void vvi_transfer_fine_finish(vvi_transfer_fine *fine); /* zeroed is fine */

#endif
