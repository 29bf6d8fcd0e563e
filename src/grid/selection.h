/** @file
 * Samples by their rank, exactly and however far out a few lie: samples are counted by the digits of an integer that
 * rises with them, 16 bits a pass from the highest on, so nothing depends on the range or on the number of threads.
 * After a pass a rank knows 16 bits more of its sample, and the next one counts only samples that begin with them.
 *
 * Passes are the caller's: 1 of 8 and 16 bits, 2 of 32, 4 of 64, over one field, several, or a part of one.
 */
#ifndef VVI_GRID_SELECTION_H
#define VVI_GRID_SELECTION_H
#include "grid/value_pass.h"

/** The most ranks that are asked for at once. */
#define VVI_RANKS_MOST 16
#define VVI_SELECTION_DIGITS 65536

/** Zeroed before vvi_selection_begin(). */
typedef struct vvi_selection {
    vv_type type;
    int shift;                                           /**< of the digit that the next pass counts */
    int n;                                               /**< ranks */
    uint64_t head[VVI_RANKS_MOST], rank[VVI_RANKS_MOST]; /**< of each sample's key; among samples with that head */
    uint64_t prefix[VVI_RANKS_MOST];                     /**< the different heads, rising */
    int n_prefixes;
    uint8_t *first;          /**< by the key's first digit: 0 nobody asks, else 1 and the first such prefix */
    _Atomic uint64_t *total; /**< VVI_SELECTION_DIGITS for each prefix */
} vvi_selection;

/** Gets ready for the first pass. End it also when it fails. */
vv_status vvi_selection_begin(vvi_selection *s, vv_type type, vv_job *job);
/** The pass that is due; more than one field may go through it. */
vvi_pass vvi_selection_pass(vvi_selection *s);
/** After the first pass: how many samples are finite. */
uint64_t vvi_selection_count(const vvi_selection *s);
/** After the first pass: ranks from 0, the least finite sample, below the count; in any order. */
void vvi_selection_set_ranks(vvi_selection *s, const uint64_t *ranks, int n);
/** After each pass, with ranks set. *done: no more of them is needed. Errors: VV_E_MEMORY, VV_E_READ. */
vv_status vvi_selection_descend(vvi_selection *s, bool *done, vv_job *job);
/** The stored number of rank `r` of those that were set, when done. */
double vvi_selection_number(const vvi_selection *s, int r);
/** Integers that rise with samples of a type; samples that are not finite have one that is not below any other. */
void vvi_selection_keys(uint64_t *keys, const double *v, size_t n, vv_type type);
/** The sample that has a key. */
double vvi_selection_value(uint64_t key, vv_type type);
void vvi_selection_end(vvi_selection *s);
#endif
