/* Colours in text: sRGB bytes where they say it exactly, linear numbers where they do not. */
#include "core/color_names.h"
#include "core/property_impl.h"
#include "core/units.h"
#include <math.h>
#include <string.h>
#include <volvis/image.h>

static double decode_byte(uint32_t byte)
{
    return vv_srgb_decode((double)(byte & 0xff) / 255);
}

static vv_color from_bytes(uint32_t rgba)
{
    return (vv_color){decode_byte(rgba >> 24), decode_byte(rgba >> 16), decode_byte(rgba >> 8),
                      (double)(rgba & 0xff) / 255};
}

/* #rrggbb, #rrggbbaa, and of one digit each #rgb, #rgba, as in CSS. */
static bool parse_hex(uint32_t *out, const char *text)
{
    const size_t n = strlen(text);
    if ((n != 4 && n != 5 && n != 7 && n != 9) || text[0] != '#' || strspn(text + 1, "0123456789abcdefABCDEF") != n - 1)
        return false;
    uint32_t value = (uint32_t)strtoul(text + 1, NULL, 16);
    if (n < 7) /* 0x1234 becomes 0x11223344 */
        value = 0x11 * ((value & 0xf000) << 12 | (value & 0xf00) << 8 | (value & 0xf0) << 4 | (value & 0xf));
    *out = n == 4 || n == 7 ? value << 8 | 0xff : value;
    return true;
}

static vv_status read_text(vv_color *out, const char *text, const vvi_place *place)
{
    const char *names[VVI_COLOR_NAMES];
    uint32_t rgba = 0;
    if (parse_hex(&rgba, text) || vvi_color_of_name(&rgba, text)) {
        *out = from_bytes(rgba);
        return VV_OK;
    }
    for (size_t i = 0; i < VVI_COLOR_NAMES; i++)
        names[i] = vvi_color_name(i);
    const char *near = vv_nearest_name(text, names, VVI_COLOR_NAMES);
    return vvi_fail_place(place, VV_E_ARGUMENT,
                          "expected a colour such as #ff8800, #ff880080, [1, 0.5, 0] or a name of CSS such as orange, "
                          "found '%.40s'%s%s%s",
                          text, near ? "; did you mean '" : "", near ? near : "", near ? "'?" : "");
}

vv_status vvi_color_read(vv_color *out, const json_t *json, const vvi_place *place)
{
    char found[64];
    double v[4] = {0, 0, 0, 1};
    if (json_is_string(json))
        return read_text(out, json_string_value(json), place);
    const size_t n = json_array_size(json);
    if (n != 3 && n != 4)
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected a colour, \"#rrggbb\" or [r, g, b(, a)], found %s",
                              vvi_found(found, json));
    for (size_t i = 0; i < n; i++) {
        const json_t *item = json_array_get(json, i);
        v[i] = json_number_value(item);
        if (!json_is_number(item) || !(v[i] >= 0) || (i == 3 && v[i] > 1))
            return vvi_fail_place(&(vvi_place){.up = place, .index = i}, VV_E_ARGUMENT,
                                  i == 3 ? "expected an alpha from 0 to 1, found %s"
                                         : "expected a linear colour value of at least 0, found %s",
                                  vvi_found(found, item));
    }
    *out = (vv_color){v[0], v[1], v[2], v[3]};
    return VV_OK;
}

/* The byte that decodes to exactly this value, or -1. */
static int exact_byte(double linear)
{
    if (!(linear >= 0 && linear <= 1) || signbit(linear))
        return -1;
    const long byte = lround(vv_srgb_encode(linear) * 255);
    return byte >= 0 && byte <= 255 && decode_byte((uint32_t)byte) == linear ? (int)byte : -1;
}

static int exact_alpha(double alpha)
{
    const long byte = lround(alpha * 255);
    return byte >= 0 && byte <= 255 && !signbit(alpha) && (double)byte / 255 == alpha ? (int)byte : -1;
}

void vvi_color_print(vvi_text *text, const vv_color *color)
{
    const int r = exact_byte(color->r), g = exact_byte(color->g), b = exact_byte(color->b), a = exact_alpha(color->a);
    if (r >= 0 && g >= 0 && b >= 0 && a >= 0) {
        if (a == 255)
            vvi_text_printf(text, "\"#%02x%02x%02x\"", (unsigned)r, (unsigned)g, (unsigned)b);
        else
            vvi_text_printf(text, "\"#%02x%02x%02x%02x\"", (unsigned)r, (unsigned)g, (unsigned)b, (unsigned)a);
        return;
    }
    const double v[4] = {color->r, color->g, color->b, color->a};
    const int n = color->a == 1 ? 3 : 4;
    for (int i = 0; i < n; i++) {
        char number[32];
        vvi_print_number(number, v[i]);
        vvi_text_printf(text, "%s%s", i ? ", " : "[", number);
    }
    vvi_text_add(text, "]");
}
