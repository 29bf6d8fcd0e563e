/* Rows of pixels as codes. */
#include "io/images/image_codes.h"

size_t vvi_codes_row_bytes(const vvi_codes *c)
{
    return (size_t)c->image->width * (size_t)c->channels * (size_t)(c->bits / 8);
}

/* Alpha is the last of a pixel's four. */
static int first_of(const vvi_codes *c)
{
    return c->channels == 1 ? 3 : 0;
}

static float alpha_of(const float *rgba)
{
    return rgba[3] > 0 ? rgba[3] < 1 ? rgba[3] : 1 : 0;
}

static void straight_pixel(uint8_t out[4], const vvi_codes *c, const float *rgba)
{
    if (!c->apart) {
        vvi_srgb_pixel(out, c->table, rgba);
        return;
    }
    for (int k = 0; k < 3; k++)
        out[k] = vvi_srgb_code(c->table, rgba[k]);
    out[3] = (uint8_t)(alpha_of(rgba) * 255 + 0.5f);
}

static void codes_8(uint8_t *out, const vvi_codes *c, const float *rgba)
{
    const bool straight = c->straight || c->channels != 3;
    const int first = first_of(c);
    for (int32_t x = 0; x < c->image->width; x++, rgba += 4, out += c->channels) {
        uint8_t pixel[4];
        if (straight)
            straight_pixel(pixel, c, rgba);
        for (int k = 0; k < c->channels; k++)
            out[k] = straight ? pixel[first + k] : vvi_srgb_code(c->table, rgba[k]);
    }
}

static void codes_16(uint8_t *out, const vvi_codes *c, const float *rgba)
{
    const bool opaque = c->channels == 3 && !c->straight;
    const int first = first_of(c);
    for (int32_t x = 0; x < c->image->width; x++, rgba += 4) {
        const float a = opaque ? 1 : alpha_of(rgba), by = c->apart ? 1 : a;
        for (int k = first; k < first + c->channels; k++) {
            const uint16_t v = k == 3 ? (uint16_t)(a * 65535 + 0.5f) : by > 0 ? vvi_srgb_code16(rgba[k] / by) : 0;
            *out++ = (uint8_t)(v >> 8);
            *out++ = (uint8_t)v;
        }
    }
}

void vvi_codes_row(uint8_t *out, const vvi_codes *c, int32_t y)
{
    const float *rgba = c->image->rgba + (size_t)y * (size_t)c->image->width * 4;
    if (c->bits == 16)
        codes_16(out, c, rgba);
    else
        codes_8(out, c, rgba);
}
