#include "grid/label_color.h"
#include "core/oklab.h"
#include <math.h>

/* Turns of the hue and steps of the lightness from one id to the next, as fractions of 2^64: whole turns fall off at
 * the top, so that ids of 64 bits have as many colours as small ones. Found by a search for steps that keep the first
 * forty ids, and those of any twelve that follow each other, far apart: with hues alone, or with golden steps, every
 * 21st or 34th is nearly the same. */
#define HUE_STEP UINT64_C(0x94816f0068db8800)
#define LIGHTNESS_STEP UINT64_C(0xf5dcc63f14120800)
#define FIRST_HUE 0.7245
#define DARKEST 0.58
#define LIGHTNESS_RANGE 0.234

static double fraction(vv_label_id label, uint64_t step)
{
    return (double)((uint64_t)label * step >> 11) * 0x1p-53;
}

/* What all hues of a lightness have within sRGB: the most at 0.75. */
static double chroma_of(double lightness)
{
    return fmin(0.168 * lightness, 0.1235 - 0.53 * (lightness - 0.755));
}

void vvi_label_color(double rgb_out[3], vv_label_id label)
{
    const double hue = 2 * M_PI * (FIRST_HUE + fraction(label, HUE_STEP));
    const double lightness = DARKEST + LIGHTNESS_RANGE * fraction(label, LIGHTNESS_STEP);
    const double chroma = chroma_of(lightness);
    const double lab[3] = {lightness, chroma * cos(hue), chroma * sin(hue)};
    vvi_oklab_to_linear(rgb_out, lab);
}
