/** @file
 * The sRGB curve for whole images: exact codes from linear floats without a power a pixel.
 */
#ifndef VVI_IMAGE_IMAGE_SRGB_H
#define VVI_IMAGE_IMAGE_SRGB_H
#include <volvis/image.h>

/** Steps of the first guess; the curve is flat enough that at most a few codes share one. */
#define VVI_SRGB_STEPS 4096

typedef struct vvi_srgb_table {
    float threshold[257]; /**< the linear value from which a code begins; the last is above every value */
    uint8_t guess[VVI_SRGB_STEPS + 1];
} vvi_srgb_table;

void vvi_srgb_table_init(vvi_srgb_table *table);
/** round(255 * encode(linear)), clamped; NaN is 0. */
static inline uint8_t vvi_srgb_code(const vvi_srgb_table *table, float linear)
{
    if (!(linear > 0))
        return 0;
    if (linear >= 1)
        return 255;
    unsigned code = table->guess[(int)(linear * VVI_SRGB_STEPS)];
    while (linear >= table->threshold[code + 1])
        code++;
    return (uint8_t)code;
}
/** round(65535 * encode(linear)), clamped; NaN is 0. */
uint16_t vvi_srgb_code16(float linear);
/** The pixel as four 8-bit codes, colour not premultiplied; black where alpha is 0. */
static inline void vvi_srgb_pixel(uint8_t out[4], const vvi_srgb_table *table, const float rgba[4])
{
    const float a = rgba[3] > 0 ? rgba[3] < 1 ? rgba[3] : 1 : 0;
    for (int c = 0; c < 3; c++)
        out[c] = a == 1 ? vvi_srgb_code(table, rgba[c]) : a > 0 ? vvi_srgb_code(table, rgba[c] / a) : 0;
    out[3] = (uint8_t)(a * 255 + 0.5f);
}
#endif
