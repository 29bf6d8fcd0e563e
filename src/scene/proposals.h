/** @file
 * Transfer functions that are worked out from the data. Each is a function from what is known of the values to nodes;
 * presets.c has a row for it.
 */
#ifndef VVI_SCENE_PROPOSALS_H
#define VVI_SCENE_PROPOSALS_H
#include "grid/value_fit.h"
#include "scene/value_profile.h"

enum { VVI_PROPOSAL_NODES = 40 };

/** What a proposal is made from. */
typedef struct vvi_proposal_data {
    const vvi_value_profile *profile;
    const vvi_value_fit *fit;
    double from, to; /**< values outside are left alone; infinite: all are looked at */
    double extent;   /**< of the volume, in world lengths */
    double length;   /**< that opacities are for */
} vvi_proposal_data;

typedef struct vvi_proposal {
    double opacity[VVI_PROPOSAL_NODES][2]; /**< (value, opacity over `length`), by rising value */
    double color[VVI_PROPOSAL_NODES][4];   /**< (value, r, g, b), linear */
    size_t n_opacity, n_color;             /**< n_color 0: a colour map does */
} vvi_proposal;

/** false: the data have nothing that this could be made from. */
typedef bool vvi_propose_fn(vvi_proposal *out, const vvi_proposal_data *data);

/**
 * Boundaries between materials opaque, what lies between them clear; the outer ones thinner. The mean |gradient| over
 * the values has a hill at each: at the middle value of one that was blurred by a Gaussian of width s it is
 * contrast / (s sqrt(2 pi)), and at a distance s from there exp(-1/2) of that. Nodes stand at these places.
 *
 * Source   Kindlmann & Durkin 1998. They tell the distance from the middle by the second derivative too; in values from
 *          a scanner, with noise and blur of one sample, its sign is less sure than the sides of the hill
 */
vvi_propose_fn vvi_propose_boundaries;
/** The outermost surface, closed: the lower threshold of three classes (Otsu 1979). */
vvi_propose_fn vvi_propose_outside;
/** What has the highest values solid, the rest a faint fog: the upper threshold of three classes. */
vvi_propose_fn vvi_propose_dense;
/** A colour for each hill of the histogram, from valley to valley; at most five, in colours that people with any colour
 * vision tell apart (Okabe & Ito 2008). */
vvi_propose_fn vvi_propose_bands;

/**
 * The two places (0 .. n, between bins: a place p parts bin p - 1 from bin p) at which three classes of counts differ
 * most: the sum over classes of weight times squared mean is largest. Between empty bins the middle. Classes are not
 * empty where three bins are not; of two bins both places are the same. false: all is in one bin.
 */
bool vvi_otsu_three(double place_out[2], const double *count, int n);
#endif
