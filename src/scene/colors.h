/** @file
 * Fields of colours (RGB, RGBA) as renderers take them: how much there is of them, and the colours themselves, linear.
 */
#ifndef VVI_SCENE_COLORS_H
#define VVI_SCENE_COLORS_H
#include "core/status.h"
#include <volvis/field.h>

struct vvi_cached;

/** Whether a field's samples are colours. */
static inline bool vvi_field_has_colors(const vv_field_info *info)
{
    return (info->meaning == VV_MEANING_RGB && info->components == 3) ||
           (info->meaning == VV_MEANING_RGBA && info->components == 4);
}

/**
 * One number of each sample, 0 to 1, to look opacity up with: alpha, or where there is none luminance (Rec. 709, of
 * linear light). Integers have their type's largest number for 1.
 *
 * Range    encoded: red, green and blue are sRGB; else linear
 * Errors   VV_E_MEMORY, VV_E_CANCELLED
 * Owns     *out is a reference of yours; made once and kept in the cache
 */
vv_status vvi_colors_scalar(vv_field **out, const vv_field *colors, bool encoded, vv_job *job);

/** Four 16-bit numbers a sample: linear red, green and blue times alpha, and alpha; 65535 is 1, what is beyond is cut
 * off. The value is a vv_field of 4 components, kept in the cache until vvi_cache_release(*out). */
vv_status vvi_colors_open(struct vvi_cached **out, const vv_field *colors, bool encoded, vv_job *job);

#endif
