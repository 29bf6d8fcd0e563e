/** @file
 * The opacity that a volume has before anybody has chosen one: from what its histogram says, one in which something is
 * to be seen.
 */
#ifndef VVI_SCENE_TRANSFER_FIT_H
#define VVI_SCENE_TRANSFER_FIT_H
#include "grid/value_fit.h"

/** Nodes of the automatic opacity. */
#define VVI_FIT_NODES 6

/**
 * Rows (value, opacity over `length`) that rise from 0 at lo to hi, at first slowly: what is faint stays translucent.
 * Of values that fall from their background they fall from lo to 0 at hi. The steepness follows the object's size: a
 * ray through the middle of an object of `share` of a box of `extent` (world lengths) is to meet the same optical
 * depth, whatever the sampling. Returns how many rows.
 */
size_t vvi_fit_opacity(double rows_out[2 * VVI_FIT_NODES], const vvi_value_fit *fit, double lo, double hi,
                       double extent, double length);
#endif
