/* Images in memory, the sRGB curve, and what image comparison says of pairs whose answer is known. */
#include "core/memory.h"
#include "fields.h"
#include "image/image_srgb.h"
#include "jobs.h"
#include <volvis/image.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_image *flat(int32_t width, int32_t height, double r, double g, double b)
{
    vv_image *image;
    assert_int_equal(vv_image_new(&image, width, height, 0, NULL), VV_OK);
    for (size_t i = 0; i < (size_t)width * (size_t)height; i++) {
        image->rgba[4 * i] = (float)vv_srgb_decode(r);
        image->rgba[4 * i + 1] = (float)vv_srgb_decode(g);
        image->rgba[4 * i + 2] = (float)vv_srgb_decode(b);
        image->rgba[4 * i + 3] = 1;
    }
    return image;
}

/* A smooth picture with structure in all channels, plus noise of an amplitude (in sRGB units). */
static vv_image *picture(int32_t width, int32_t height, double noise, uint64_t seed)
{
    vv_image *image = flat(width, height, 0, 0, 0);
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++)
            for (int c = 0; c < 3; c++) {
                const size_t i = ((size_t)y * (size_t)width + (size_t)x) * 4 + (size_t)c;
                const double v =
                    0.5 + 0.25 * sin(0.2 * x + c) * cos(0.13 * y) + noise * (test_random_unit(seed, i) - 0.5);
                image->rgba[i] = (float)vv_srgb_decode(v);
            }
    return image;
}

static vv_image_difference compare(const vv_image *a, const vv_image *b, vv_job *job)
{
    vv_image_difference d;
    assert_int_equal(vv_image_compare(&d, a, b, job), VV_OK);
    return d;
}

static void the_srgb_curve_meets_its_fixed_points_and_inverts_itself(void **state)
{
    (void)state;
    assert_true(vv_srgb_encode(0) == 0 && fabs(vv_srgb_encode(1) - 1) < 1e-15);
    assert_true(fabs(vv_srgb_decode(0.5) - 0.21404114048223255) < 1e-12);
    assert_true(fabs(vv_srgb_encode(0.0031308) - 0.0404499) < 1e-6);
    for (int i = 0; i <= 1000; i++)
        assert_true(fabs(vv_srgb_encode(vv_srgb_decode(i / 1000.0)) - i / 1000.0) < 1e-7);
}

static void the_table_gives_the_same_code_as_the_formula(void **state)
{
    (void)state;
    vvi_srgb_table table;
    vvi_srgb_table_init(&table);
    for (int i = -100; i < 300000; i++) {
        const float v = (float)i / 250000;
        const double exact = fmin(fmax(255 * vv_srgb_encode(fmax(v, 0)), 0), 255);
        assert_true(fabs(vvi_srgb_code(&table, v) - exact) <= 0.50001);
    }
    assert_int_equal(vvi_srgb_code(&table, NAN), 0);
    assert_int_equal(vvi_srgb_code(&table, INFINITY), 255);
    assert_int_equal(vvi_srgb_code(&table, -INFINITY), 0);
    for (int code = 0; code < 256; code++)
        assert_int_equal(vvi_srgb_code(&table, (float)vv_srgb_decode(code / 255.0)), code);
    for (int code = 0; code < 65536; code += 13)
        assert_int_equal(vvi_srgb_code16((float)vv_srgb_decode(code / 65535.0)), code);
}

static void a_new_image_is_clear_and_infinitely_far(void **state)
{
    (void)state;
    vv_image *image;
    assert_int_equal(vv_image_new(&image, 3, 2, VV_LAYER_DEPTH, NULL), VV_OK);
    for (int i = 0; i < 6; i++)
        assert_true(image->rgba[4 * i + 3] == 0 && isinf(image->depth[i]));
    vv_image *again = vv_image_retain(image);
    vv_image_release(image);
    assert_int_equal(again->width, 3);
    vv_image_release(again);
    vv_image_release(NULL);
    assert_int_equal(vv_image_new(&image, 0, 2, VV_LAYER_DEPTH, NULL), VV_E_ARGUMENT);
    assert_null(image);
    assert_int_equal(vv_image_new(&image, 2, 70000, VV_LAYER_DEPTH, NULL), VV_E_ARGUMENT);
}

static void layers_begin_where_nothing_is(void **state)
{
    (void)state;
    vv_image *image;
    const unsigned all = (1u << VV_LAYER_COUNT) - 1;
    assert_int_equal(vv_image_new(&image, 1, 7, all, NULL), VV_OK);
    assert_int_equal(vv_image_layers(image), all);
    for (int i = 0; i < 7; i++) {
        assert_true(isinf(image->depth[i]) && isnan(image->value[i]));
        assert_true(image->id[i] == 0 && image->samples[i] == 0);
        for (int k = 0; k < 3; k++)
            assert_true(image->normal[3 * i + k] == 0);
    }
    vv_image_release(image);
    assert_int_equal(vv_image_new(&image, 7, 1, VV_LAYER_ID | VV_LAYER_SAMPLES, NULL), VV_OK);
    assert_int_equal(vv_image_layers(image), VV_LAYER_ID | VV_LAYER_SAMPLES);
    assert_string_equal(vv_layer_name(2), "id");
    assert_null(vv_layer_name(VV_LAYER_COUNT));
    vv_image_release(image);
}

static void equal_images_do_not_differ(void **state)
{
    (void)state;
    vv_image *a = picture(37, 23, 0.3, 1);
    const vv_image_difference d = compare(a, a, NULL);
    assert_true(isinf(d.psnr) && d.psnr > 0);
    assert_true(fabs(d.ssim - 1) < 1e-12);
    assert_true(d.flip_mean == 0);
    assert_true(d.max_difference == 0 && d.n_different == 0);
    vv_image_release(a);
}

static void difference_is_symmetric(void **state)
{
    (void)state;
    vv_image *a = picture(40, 31, 0.1, 1), *b = picture(40, 31, 0.4, 2);
    const vv_image_difference ab = compare(a, b, NULL), ba = compare(b, a, NULL);
    assert_true(ab.psnr == ba.psnr);
    assert_true(fabs(ab.ssim - ba.ssim) < 1e-14);
    assert_true(fabs(ab.flip_mean - ba.flip_mean) < 1e-14);
    vv_image_release(a);
    vv_image_release(b);
}

static void psnr_of_a_constant_step_is_its_formula(void **state)
{
    (void)state;
    vv_image *a = flat(20, 20, 100 / 255.0, 100 / 255.0, 100 / 255.0);
    vv_image *b = flat(20, 20, 110 / 255.0, 110 / 255.0, 110 / 255.0);
    const vv_image_difference d = compare(a, b, NULL);
    assert_true(fabs(d.psnr - 20 * log10(255.0 / 10)) < 1e-9);
    assert_true(fabs(d.max_difference - 10 / 255.0) < 1e-12);
    assert_int_equal(d.n_different, 400);
    /* without structure SSIM is its luminance term alone */
    const double c1 = 6.5025;
    assert_true(fabs(d.ssim - (2 * 100 * 110 + c1) / (100 * 100 + 110 * 110 + c1)) < 1e-9);
    vv_image_release(a);
    vv_image_release(b);
}

static void a_single_different_pixel_is_counted(void **state)
{
    (void)state;
    vv_image *a = flat(10, 10, 0.2, 0.2, 0.2), *b = flat(10, 10, 0.2, 0.2, 0.2);
    b->rgba[4 * 57 + 1] = 1;
    const vv_image_difference d = compare(a, b, NULL);
    assert_int_equal(d.n_different, 1);
    assert_true(fabs(d.max_difference - (255 - 51) / 255.0) < 1e-12);
    vv_image_release(a);
    vv_image_release(b);
}

/* Flat pictures have no features and pass the filters unchanged: FLIP is its colour term. Black and white lie 100
 * apart; the largest distance is that between green and blue in Hunt-adjusted CIELAB, about 308.15. */
static void flip_between_black_and_white_is_its_closed_form(void **state)
{
    (void)state;
    vv_image *a = flat(33, 35, 0, 0, 0), *b = flat(33, 35, 1, 1, 1);
    const vv_image_difference d = compare(a, b, NULL);
    /* CIELAB of the primaries: green (87.74, -86.18, 83.18), blue (32.30, 79.20, -107.86), D65 */
    const double g[3] = {87.737, -86.185 * 0.87737, 83.181 * 0.87737};
    const double u[3] = {32.303, 79.197 * 0.32303, -107.864 * 0.32303};
    const double most = pow(fabs(g[0] - u[0]) + hypot(g[1] - u[1], g[2] - u[2]), 0.7);
    const double error = pow(100, 0.7);
    const double want = 0.95 + (error - 0.4 * most) / (most - 0.4 * most) * 0.05;
    assert_true(fabs(d.flip_mean - want) < 2e-4);
    assert_true(d.flip_mean > 0.95 && d.flip_mean < 1);
    vv_image_release(a);
    vv_image_release(b);
}

static void flip_between_green_and_blue_is_one(void **state)
{
    (void)state;
    vv_image *a = flat(9, 12, 0, 1, 0), *b = flat(9, 12, 0, 0, 1);
    assert_true(fabs(compare(a, b, NULL).flip_mean - 1) < 1e-9);
    vv_image_release(a);
    vv_image_release(b);
}

static void a_fine_checkerboard_looks_nearly_like_its_mean(void **state)
{
    (void)state;
    /* Alternating pixels cannot be told apart at 67 pixels a degree: far less than two flat greys that far apart. */
    vv_image *fine = flat(64, 64, 0.5, 0.5, 0.5), *mean = flat(64, 64, 0.5, 0.5, 0.5),
             *off = flat(64, 64, 0.6, 0.6, 0.6);
    for (int y = 0; y < 64; y++)
        for (int x = 0; x < 64; x++)
            for (int c = 0; c < 3; c++)
                fine->rgba[(y * 64 + x) * 4 + c] *= (x + y) % 2 ? 1.2f : 0.8f;
    assert_true(compare(fine, mean, NULL).flip_mean < 0.7 * compare(off, mean, NULL).flip_mean);
    vv_image_release(fine);
    vv_image_release(mean);
    vv_image_release(off);
}

static void all_measures_worsen_with_noise(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    vv_image *clean = picture(64, 48, 0, seed);
    vv_image_difference before = compare(clean, clean, NULL);
    for (int level = 1; level <= 5; level++) {
        vv_image *noisy = picture(64, 48, 0.08 * level, seed);
        const vv_image_difference d = compare(clean, noisy, NULL);
        assert_true(d.psnr < before.psnr);
        assert_true(d.ssim < before.ssim);
        assert_true(d.flip_mean > before.flip_mean);
        before = d;
        vv_image_release(noisy);
    }
    vv_image_release(clean);
}

static void thread_count_changes_nothing(void **state)
{
    (void)state;
    vv_image *a = picture(61, 47, 0.1, 1), *b = picture(61, 47, 0.3, 2);
    const vv_image_difference alone = compare(a, b, NULL);
    for (int threads = 1; threads <= 3; threads++) {
        vv_job *job = test_job(threads, 0);
        const vv_image_difference d = compare(a, b, job);
        assert_true(d.psnr == alone.psnr && d.ssim == alone.ssim && d.flip_mean == alone.flip_mean);
        vv_job_release(job);
    }
    vv_image_release(a);
    vv_image_release(b);
}

static void tiny_images_can_be_compared(void **state)
{
    (void)state;
    for (int32_t w = 1; w < 13; w += 3)
        for (int32_t h = 1; h < 13; h += 5) {
            vv_image *a = picture(w, h, 0, 1), *b = picture(w, h, 0.5, 1);
            const vv_image_difference d = compare(a, b, NULL);
            assert_true(isfinite(d.ssim) && d.ssim <= 1 && d.flip_mean >= 0 && d.flip_mean <= 1);
            assert_true(fabs(compare(a, a, NULL).ssim - 1) < 1e-12);
            vv_image_release(a);
            vv_image_release(b);
        }
}

static void images_of_other_sizes_are_refused(void **state)
{
    (void)state;
    vv_image *a = flat(3, 4, 0, 0, 0), *b = flat(4, 3, 0, 0, 0);
    vv_image_difference d;
    assert_int_equal(vv_image_compare(&d, a, b, NULL), VV_E_ARGUMENT);
    vv_image_release(a);
    vv_image_release(b);
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    vv_image *a = picture(12, 12, 0, 1), *b = picture(12, 12, 0.1, 1);
    for (int n = 1; n < 200; n++) {
        vv_image_difference d;
        vvi_alloc_fail_after(n);
        const vv_status st = vv_image_compare(&d, a, b, NULL);
        vvi_alloc_fail_after(0);
        if (st == VV_OK) {
            assert_true(n > 10);
            break;
        }
        assert_int_equal(st, VV_E_MEMORY);
    }
    vv_image_release(a);
    vv_image_release(b);
}

/* White, black, red and half of the light, two a row. */
static void an_image_is_letters_in_a_terminal(void **state)
{
    static const float rgba[4][4] = {{1, 1, 1, 1}, {0, 0, 0, 1}, {1, 0, 0, 1}, {0.5f, 0.5f, 0.5f, 1}};
    static const char blocks[] = "\033[38;2;255;255;255m\033[48;2;255;0;0m\xe2\x96\x80"
                                 "\033[38;2;0;0;0m\033[48;2;188;188;188m\xe2\x96\x80\033[0m\n";
    vv_image *image;
    char *text;
    assert_int_equal(vv_image_new(&image, 2, 2, 0, NULL), VV_OK);
    memcpy(image->rgba, rgba, sizeof rgba);
    assert_int_equal(vv_image_letters(&text, image, VV_LETTERS_SHADES), VV_OK);
    assert_string_equal(text, "@ \n-#\n");
    free(text);
    assert_int_equal(vv_image_letters(&text, image, VV_LETTERS_BLOCKS), VV_OK);
    assert_string_equal(text, blocks);
    free(text);
    vv_image_release(image);
    (void)state;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_srgb_curve_meets_its_fixed_points_and_inverts_itself),
        cmocka_unit_test(the_table_gives_the_same_code_as_the_formula),
        cmocka_unit_test(a_new_image_is_clear_and_infinitely_far),
        cmocka_unit_test(layers_begin_where_nothing_is),
        cmocka_unit_test(equal_images_do_not_differ),
        cmocka_unit_test(difference_is_symmetric),
        cmocka_unit_test(psnr_of_a_constant_step_is_its_formula),
        cmocka_unit_test(a_single_different_pixel_is_counted),
        cmocka_unit_test(flip_between_black_and_white_is_its_closed_form),
        cmocka_unit_test(flip_between_green_and_blue_is_one),
        cmocka_unit_test(a_fine_checkerboard_looks_nearly_like_its_mean),
        cmocka_unit_test(all_measures_worsen_with_noise),
        cmocka_unit_test(thread_count_changes_nothing),
        cmocka_unit_test(tiny_images_can_be_compared),
        cmocka_unit_test(images_of_other_sizes_are_refused),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(an_image_is_letters_in_a_terminal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
