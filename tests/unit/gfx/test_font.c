/* Letters: coverage against the area of outlines, which is another way to the same letters; lengths; broken text. */
#include "core/memory.h"
#include "gfx/font.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static vvi_font *font;

static int open_font(void **state)
{
    (void)state;
    if (vvi_font_open(&font, NULL) == VV_OK)
        return 0;
    print_message("%s\n", vv_error_last()->message);
    return 0;
}

static int close_font(void **state)
{
    (void)state;
    vvi_font_close(font);
    return 0;
}

/* Signed areas: holes go the other way round. */
static double area_of(const char *text, double size)
{
    vvi_font_outline o;
    double area = 0;
    size_t begin = 0;
    assert_int_equal(vvi_font_trace(&o, font, text, 1e-4, NULL), VV_OK);
    for (size_t c = 0; c < o.n_polygons; begin = o.ends[c++])
        for (size_t i = begin; i < o.ends[c]; i++) {
            const vv_vec3 p = o.points[i], q = o.points[i + 1 < o.ends[c] ? i + 1 : begin];
            area += (p.x * q.y - q.x * p.y) / 2;
        }
    vvi_font_outline_finish(&o);
    return fabs(area) * size * size;
}

static double coverage_of(const char *text, double size)
{
    vvi_gfx_coverage c;
    double sum = 0;
    assert_int_equal(vvi_font_draw(font, &c, text, size, NULL), VV_OK);
    for (size_t i = 0; i < (size_t)c.width * (size_t)c.height; i++)
        sum += c.coverage[i] / 255.0;
    vvi_free(c.coverage);
    return sum;
}

static void coverage_is_the_area_of_the_letters(void **state)
{
    /* 50 µm, −x ≥ 45: by bytes, and never a letter that a hexadecimal number might swallow */
    static const char *const texts[] = {"I", "O", "RAS", "50 \302\265m", "\342\210\222x \342\211\245 45"};
    (void)state;
    if (!font)
        skip();
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        for (double size = 31; size < 300; size *= 3) { /* heights are fitted to pixels: smaller ones differ more */
            const double area = area_of(texts[i], size);
            assert_true(area > 0);
            assert_true(fabs(coverage_of(texts[i], size) - area) < (size < 50 ? 0.08 : 0.03) * area);
        }
}

static void nothing_is_cut_off(void **state)
{
    (void)state;
    vvi_gfx_coverage c;
    if (!font)
        skip();
    for (double size = 7.3; size < 80; size *= 1.9) {
        assert_int_equal(vvi_font_draw(font, &c, "\xc3\x85jgQ|(f\xc3\x89", size, NULL), VV_OK);
        for (int32_t y = 0; y < c.height; y++)
            for (int32_t x = 0; x < c.width; x++)
                if (x == 0 || y == 0 || x == c.width - 1 || y == c.height - 1)
                    assert_int_equal(c.coverage[(size_t)y * (size_t)c.width + (size_t)x], 0);
        assert_true(c.top < 0 && c.top + c.height > 0 && c.left <= 0);
        vvi_free(c.coverage);
    }
}

static void lengths_grow_with_the_size_and_the_text(void **state)
{
    (void)state;
    vvi_gfx_coverage c;
    if (!font)
        skip();
    const double one = vvi_font_length(font, "scale bar", 1);
    assert_true(one > 2 && one < 6);
    assert_true(fabs(vvi_font_length(font, "scale bar", 37.5) - 37.5 * one) < 1e-9);
    assert_true(vvi_font_length(font, "", 20) == 0);
    assert_true(vvi_font_length(font, "AVAVAV", 20) < 6 * vvi_font_length(font, "A", 20)); /* kerning */
    assert_true(fabs(vvi_font_length(font, "12", 20) - 2 * vvi_font_length(font, "0", 20)) < 1e-9);
    assert_int_equal(vvi_font_draw(font, &c, "scale bar", 16, NULL), VV_OK);
    assert_true(fabs(c.advance - 16 * one) < 1e-9);
    vvi_free(c.coverage);
}

static void broken_and_unknown_characters_are_boxes(void **state)
{
    (void)state;
    if (!font)
        skip();
    const double box = vvi_font_length(font, "\xf4\x8f\xbf\xbd", 1); /* a private one */
    assert_true(box > 0.2);
    assert_true(vvi_font_length(font, "a\xff\xfe", 1) > vvi_font_length(font, "a", 1));
    assert_true(coverage_of("\xc3", 20) > 0);
}

static void sizes_and_lengths_beyond_measure_are_refused(void **state)
{
    (void)state;
    vvi_gfx_coverage c;
    char text[4000];
    if (!font)
        skip();
    memset(text, 'W', sizeof text - 1);
    text[sizeof text - 1] = 0;
    const double sizes[] = {0, -3, 0.5, 5000, INFINITY, NAN};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        assert_int_equal(vvi_font_draw(font, &c, "x", sizes[i], NULL), VV_E_ARGUMENT);
    assert_int_equal(vvi_font_draw(font, &c, text, 20, NULL), VV_E_ARGUMENT);
    assert_int_equal(vvi_font_draw(font, &c, "", 20, NULL), VV_OK);
    assert_true(c.width == 0 && !c.coverage && c.advance == 0);
}

static void files_that_are_no_fonts_are_refused(void **state)
{
    (void)state;
    vvi_font *none;
    if (!font)
        skip();
    assert_int_equal(vvi_font_open(&none, "/nowhere/font.ttf"), VV_E_NOT_FOUND);
    assert_null(none);
    assert_int_equal(vvi_font_open(&none, "/etc/passwd"), VV_E_FORMAT);
    assert_null(none);
    vvi_font_close(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coverage_is_the_area_of_the_letters),
        cmocka_unit_test(nothing_is_cut_off),
        cmocka_unit_test(lengths_grow_with_the_size_and_the_text),
        cmocka_unit_test(broken_and_unknown_characters_are_boxes),
        cmocka_unit_test(sizes_and_lengths_beyond_measure_are_refused),
        cmocka_unit_test(files_that_are_no_fonts_are_refused),
    };
    return cmocka_run_group_tests(tests, open_font, close_font);
}
