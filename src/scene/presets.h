/** @file
 * Named transfer functions.
 */
#ifndef VVI_SCENE_PRESETS_H
#define VVI_SCENE_PRESETS_H
#include "core/status.h"
#include "scene/proposals.h"
#include <volvis/render.h>

/** Opacities are for one sample spacing, the smallest: a preset looks alike at any resolution of one object, and the
 * resolver writes that length beside it. Colours are linear. */
typedef struct vvi_preset {
    vv_preset head;
    const double (*opacity)[2]; /**< (value, opacity) */
    size_t n_opacity;
    const double (*color)[4]; /**< (value, r, g, b); NULL: colormap over 0..1 */
    size_t n_color;
    const char *colormap;
    vvi_propose_fn *propose; /**< of the kind "proposal"; NULL there: what is taken when nothing is chosen */
} vvi_preset;

/** NULL, and VV_E_NOT_FOUND with the nearest real name (`path` in front), when there is none of that name. */
const vvi_preset *vvi_preset_find(const char *name, const char *path);

/** How a preset's values become the data's: data = value * scale + offset. */
typedef struct vvi_preset_map {
    double scale, offset;
    bool guessed; /**< the preset is in a unit that the data do not have: to be told to people */
} vvi_preset_map;

/**
 * Normalised presets: 0..1 to [lo, hi]. Presets in HU: as they are when the data are in HU (they say so, or have values
 * below -200 and say nothing), 1024 higher for raw CT numbers (16 bits, from 0, tissue near 1040); for any other data
 * [-1000, 1500] HU is stretched over [lo, hi] and `guessed` is set.
 */
vvi_preset_map vvi_preset_place(const vvi_preset *preset, const vv_field_info *info, const vv_statistics *statistics,
                                double lo, double hi);
#endif
