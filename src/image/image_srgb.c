/* Codes of the sRGB curve, which itself is in core/srgb.c: scene files need it too. */
#include "image/image_srgb.h"

#include <math.h>

/* Between two codes lies the linear value whose code is half way. */
void vvi_srgb_table_init(vvi_srgb_table *table)
{
    table->threshold[0] = 0;
    for (int code = 1; code < 256; code++)
        table->threshold[code] = (float)vv_srgb_decode((code - 0.5) / 255);
    table->threshold[256] = INFINITY;
    int code = 0;
    for (int step = 0; step <= VVI_SRGB_STEPS; step++) {
        while (code < 255 && (float)step / VVI_SRGB_STEPS >= table->threshold[code + 1])
            code++;
        table->guess[step] = (uint8_t)code;
    }
}

uint16_t vvi_srgb_code16(float linear)
{
    if (!(linear > 0))
        return 0;
    if (linear >= 1)
        return 65535;
    return (uint16_t)(vv_srgb_encode(linear) * 65535 + 0.5);
}
