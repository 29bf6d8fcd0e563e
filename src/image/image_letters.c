/* Pictures as text that a terminal shows: sixels, half blocks in colours, or shades of letters. */
#include "core/status.h"
#include "core/text.h"
#include <math.h>
#include <stdlib.h>
#include <volvis/image.h>

/* As a screen has it: three floats a pixel, 0..1. */
typedef struct picture {
    int width, height;
    float *rgb;
} picture;

static const float *pixel(const picture *t, int x, int y)
{
    static const float black[3];
    return y < t->height ? t->rgb + 3 * ((size_t)y * (size_t)t->width + (size_t)x) : black;
}

static int level(float v, int most)
{
    return (int)lrintf((v > 0 ? v < 1 ? v : 1 : 0) * (float)most);
}

static double luma(const float rgb[3])
{
    return 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
}

/* The nearest of xterm's 6 x 6 x 6 colours and 24 greys; the cube's levels are 0, 95, 135, ... 255. */
static int xterm_color(const float rgb[3])
{
    int cube[3];
    double off_cube = 0, off_grey = 0;
    const int grey = (int)lrint(fmin(fmax((luma(rgb) * 255 - 8) / 10, 0), 23));
    for (int k = 0; k < 3; k++) {
        const double v = 255 * rgb[k];
        cube[k] = v < 47.5 ? 0 : v < 115 ? 1 : (int)lrint((v - 55) / 40);
        const double on_cube = cube[k] ? 55 + 40 * cube[k] : 0;
        off_cube += (v - on_cube) * (v - on_cube);
        off_grey += (v - 8 - 10 * grey) * (v - 8 - 10 * grey);
    }
    return off_grey < off_cube ? 232 + grey : 16 + 36 * cube[0] + 6 * cube[1] + cube[2];
}

static void add_color(vvi_text *out, int layer, const float rgb[3], vv_letters kind)
{
    if (kind == VV_LETTERS_BLOCKS8)
        vvi_text_printf(out, "\033[%d;5;%dm", layer, xterm_color(rgb));
    else
        vvi_text_printf(out, "\033[%d;2;%d;%d;%dm", layer, level(rgb[0], 255), level(rgb[1], 255), level(rgb[2], 255));
}

static bool same_color(const float *a, const float *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* The upper half of a cell in the letter's colour, the lower one in the background's. */
static void add_blocks(vvi_text *out, const picture *t, vv_letters kind)
{
    for (int y = 0; y < t->height; y += 2) {
        for (int x = 0; x < t->width; x++) {
            const float *upper = pixel(t, x, y), *lower = pixel(t, x, y + 1);
            if (x == 0 || !same_color(upper, pixel(t, x - 1, y)))
                add_color(out, 38, upper, kind);
            if (x == 0 || !same_color(lower, pixel(t, x - 1, y + 1)))
                add_color(out, 48, lower, kind);
            vvi_text_add(out, "\xe2\x96\x80");
        }
        vvi_text_add(out, "\033[0m\n");
    }
}

static void add_shades(vvi_text *out, const picture *t)
{
    static const char shades[] = " .:-=+*#%@";
    for (int y = 0; y < t->height; y++) {
        for (int x = 0; x < t->width; x++)
            vvi_text_add_n(out, &shades[level((float)luma(pixel(t, x, y)), (int)sizeof shades - 2)], 1);
        vvi_text_add(out, "\n");
    }
}

/* Sixels ---------------------------------------------------------------------------------------------------------- */

enum { GREYS = 101, RED = 6, GREEN = 8, BLUE = 5, COLORS = RED * GREEN * BLUE };

static bool is_grey(const picture *t)
{
    for (size_t p = 0; p < (size_t)t->width * (size_t)t->height; p++) {
        const float *c = t->rgb + 3 * p;
        if (fabsf(c[0] - c[1]) > 0.005f || fabsf(c[1] - c[2]) > 0.005f)
            return false;
    }
    return true;
}

/* Ordered dithering (Bayer 1973): an offset of less than one level, other at each pixel of a 4 x 4 square. */
static int dithered(float v, int levels, int x, int y)
{
    static const uint8_t order[4][4] = {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
    const float at = (v > 0 ? v < 1 ? v : 1 : 0) * (float)(levels - 1) + ((float)order[y & 3][x & 3] + 0.5f) / 16;
    const int n = (int)at;
    return n < levels ? n : levels - 1;
}

static int color_number(const float *c, int x, int y, bool grey)
{
    if (grey)
        return level(c[1], GREYS - 1);
    return (dithered(c[0], RED, x, y) * GREEN + dithered(c[1], GREEN, x, y)) * BLUE + dithered(c[2], BLUE, x, y);
}

static void add_palette(vvi_text *out, bool grey)
{
    for (int i = 0; grey && i < GREYS; i++)
        vvi_text_printf(out, "#%d;2;%d;%d;%d", i, i, i, i);
    for (int i = 0; !grey && i < COLORS; i++)
        vvi_text_printf(out, "#%d;2;%d;%d;%d", i, i / (GREEN * BLUE) * 100 / (RED - 1),
                        i / BLUE % GREEN * 100 / (GREEN - 1), i % BLUE * 100 / (BLUE - 1));
}

static void add_run(vvi_text *out, int bits, int n)
{
    const char letter = (char)(63 + bits);
    if (n > 3)
        vvi_text_printf(out, "!%d%c", n, letter);
    else
        for (int i = 0; i < n; i++)
            vvi_text_add_n(out, &letter, 1);
}

/* Six rows: for each colour in them one line over the others. */
static void add_band(vvi_text *out, const picture *t, int y0, bool grey, uint8_t *numbers)
{
    bool used[256] = {false};
    const int rows = t->height - y0 < 6 ? t->height - y0 : 6;
    for (int j = 0; j < rows; j++)
        for (int x = 0; x < t->width; x++) {
            const int number = color_number(pixel(t, x, y0 + j), x, y0 + j, grey);
            numbers[j * t->width + x] = (uint8_t)number;
            used[number] = true;
        }
    for (int c = 0; c < 256; c++) {
        if (!used[c])
            continue;
        vvi_text_printf(out, "#%d", c);
        int before = -1, run = 0;
        for (int x = 0; x < t->width; x++) {
            int bits = 0;
            for (int j = 0; j < rows; j++)
                bits |= (numbers[j * t->width + x] == c) << j;
            if (bits != before && run)
                add_run(out, before, run);
            run = bits == before ? run + 1 : 1;
            before = bits;
        }
        if (before > 0)
            add_run(out, before, run);
        vvi_text_add(out, "$");
    }
    vvi_text_add(out, "-");
}

static void add_sixels(vvi_text *out, const picture *t)
{
    const bool grey = is_grey(t);
    uint8_t *numbers = malloc((size_t)t->width * 6);
    if (!numbers) {
        out->bad = true;
        return;
    }
    vvi_text_printf(out, "\033P0;1;0q\"1;1;%d;%d", t->width, t->height);
    add_palette(out, grey);
    for (int y = 0; y < t->height; y += 6)
        add_band(out, t, y, grey, numbers);
    vvi_text_add(out, "\033\\\n");
    free(numbers);
}

/* Over black. */
static void encode(float *rgb, const vv_image *image)
{
    for (size_t p = 0; p < (size_t)image->width * (size_t)image->height; p++)
        for (size_t k = 0; k < 3; k++) {
            const float v = image->rgba[4 * p + k];
            rgb[3 * p + k] = (float)vv_srgb_encode(v > 0 ? v < 1 ? v : 1 : 0);
        }
}

vv_status vv_image_letters(char **text_out, const vv_image *image, vv_letters kind)
{
    picture t = {.width = image->width, .height = image->height};
    const size_t n = (size_t)t.width * (size_t)t.height;
    vvi_text text = {0};
    *text_out = NULL;
    if (!(t.rgb = calloc(n, 3 * sizeof *t.rgb)))
        return vv_fail_memory(n * 3 * sizeof *t.rgb);
    encode(t.rgb, image);
    if (kind == VV_LETTERS_SIXEL)
        add_sixels(&text, &t);
    else if (kind == VV_LETTERS_SHADES)
        add_shades(&text, &t);
    else
        add_blocks(&text, &t, kind);
    free(t.rgb);
    const vv_status st = text.bad ? vv_fail_memory(text.n) : VV_OK;
    *text_out = vvi_text_take(&text);
    return st;
}
