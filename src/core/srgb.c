/* The sRGB curve (IEC 61966-2-1), for values 0..1. */
#include <math.h>
#include <volvis/image.h>

double vv_srgb_encode(double linear)
{
    if (!(linear > 0))
        return 0;
    if (linear >= 1)
        return 1;
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

double vv_srgb_decode(double encoded)
{
    if (!(encoded > 0))
        return 0;
    if (encoded >= 1)
        return 1;
    return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}
