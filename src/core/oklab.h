/** @file
 * Oklab (Ottosson 2020), a colour space in which equal distances look equal.
 */
#ifndef VVI_CORE_OKLAB_H
#define VVI_CORE_OKLAB_H

/** Lightness, green to red, blue to yellow; to linear sRGB, clipped to [0, 1]. */
void vvi_oklab_to_linear(double rgb_out[3], const double lab[3]);

#endif
