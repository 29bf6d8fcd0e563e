/* PNG: what is written is read again; every kind of PNG is understood; damaged ones are refused. */
#include "core/memory.h"
#include "fail_alloc.h"
#include "fields.h"
#include "io/images/png.h"
#include "io/source.h"
#include "jobs.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[64];

static const char *path_of(const char *name)
{
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int make_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/volvis-png-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    unlink(path_of("a.png"));
    unlink(path_of("b.png"));
    return rmdir(folder);
}

/* Pixels that are sRGB codes of so many bits, so that they come back exactly. */
static vv_image *picture(int32_t width, int32_t height, int bits, bool alpha)
{
    vv_image *image;
    const double most = bits == 8 ? 255 : 65535;
    assert_int_equal(vv_image_new(&image, width, height, 0, NULL), VV_OK);
    for (size_t i = 0; i < (size_t)width * (size_t)height; i++) {
        const double a = alpha ? floor(test_random_unit(7, 4 * i + 3) * (most + 1)) / most : 1;
        for (size_t c = 0; c < 3; c++)
            image->rgba[4 * i + c] =
                (float)(vv_srgb_decode(floor(test_random_unit(7, 4 * i + c) * (most + 1)) / most) * a);
        image->rgba[4 * i + 3] = (float)a;
    }
    return image;
}

static void expect_near(const vv_image *a, const vv_image *b, double tolerance)
{
    assert_true(a->width == b->width && a->height == b->height);
    for (size_t i = 0; i < (size_t)a->width * (size_t)a->height * 4; i++)
        if (!(fabs((double)a->rgba[i] - (double)b->rgba[i]) <= tolerance))
            fail_msg("number %zu: %g is not %g", i, (double)b->rgba[i], (double)a->rgba[i]);
}

static vv_image *there_and_back(const vv_image *image, const vv_image_options *options, vv_job *job)
{
    vv_image *back = NULL;
    if (vv_image_write(path_of("a.png"), image, options, job) != VV_OK ||
        vv_image_read(&back, NULL, NULL, path_of("a.png"), job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return back;
}

static void opaque_and_transparent_pictures_come_back_in_both_depths(void **state)
{
    (void)state;
    static const int32_t sizes[][2] = {{1, 1}, {1, 7}, {7, 1}, {13, 11}, {64, 33}, {700, 301}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int bits = 8; bits <= 16; bits += 8)
            for (int alpha = 0; alpha < 2; alpha++) {
                vv_image_options options;
                vv_image_options_init(&options, sizeof options);
                options.bits = bits;
                vv_image *image = picture(sizes[s][0], sizes[s][1], bits, alpha);
                vv_image *back = there_and_back(image, &options, NULL);
                expect_near(image, back, 2e-7);
                vv_image_release(image);
                vv_image_release(back);
            }
}

static void an_image_said_to_be_opaque_is_written_over_black(void **state)
{
    (void)state;
    vv_image_options options;
    vv_image_options_init(&options, sizeof options);
    options.alpha = false;
    vv_image *image;
    assert_int_equal(vv_image_new(&image, 1, 1, 0, NULL), VV_OK);
    image->rgba[0] = 0.25f; /* half a white pixel of brightness 0.5 */
    image->rgba[3] = 0.5f;
    vv_image *back = there_and_back(image, &options, NULL);
    assert_true(back->rgba[3] == 1 && fabs((double)back->rgba[0] - 0.25) < 0.003);
    vv_image_release(image);
    vv_image_release(back);
}

static uint8_t *slurp(const char *path, size_t *n)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    uint8_t *data = malloc(1 << 22);
    *n = fread(data, 1, 1 << 22, file);
    fclose(file);
    return data;
}

static void thread_count_changes_no_byte(void **state)
{
    (void)state;
    vv_image *image = picture(513, 401, 8, true);
    size_t n, m;
    assert_int_equal(vv_image_write(path_of("a.png"), image, NULL, NULL), VV_OK);
    uint8_t *alone = slurp(path_of("a.png"), &n);
    for (int threads = 1; threads <= 3; threads++) {
        vv_job *job = test_job(threads, 0);
        assert_int_equal(vv_image_write(path_of("b.png"), image, NULL, job), VV_OK);
        uint8_t *data = slurp(path_of("b.png"), &m);
        assert_int_equal(m, n);
        assert_memory_equal(data, alone, n);
        free(data);
        vv_job_release(job);
    }
    free(alone);
    vv_image_release(image);
}

static void text_comes_back_with_and_without_pixels(void **state)
{
    (void)state;
    char *large = malloc(200001);
    for (int i = 0; i < 200000; i++)
        large[i] = "{\"scene\": [1, 2, 3]}\n"[i % 21];
    large[200000] = 0;
    vv_text text[] = {{"VolVis:Scene", large},
                      {"Software", "VolVis"},
                      {"Title", "Kopf \xc3\xbc"
                                "ber \xe2\x82\xac \xf0\x9f\x98\x80"},
                      {"Comment", ""},
                      {"VolVis:Tab", "a\tb\nc"}};
    vv_image_options options;
    vv_image_options_init(&options, sizeof options);
    options.text = text;
    options.n_text = 5;
    vv_image *image = picture(40, 30, 8, false), *back;
    assert_int_equal(vv_image_write(path_of("a.png"), image, &options, NULL), VV_OK);
    for (int way = 0; way < 2; way++) {
        vv_text *got;
        size_t n;
        back = NULL;
        assert_int_equal(way ? vv_image_read(&back, &got, &n, path_of("a.png"), NULL)
                             : vv_image_read_text(&got, &n, path_of("a.png"), NULL),
                         VV_OK);
        assert_int_equal(n, 5);
        for (size_t i = 0; i < n; i++) {
            assert_string_equal(got[i].key, text[i].key);
            assert_string_equal(got[i].value, text[i].value);
        }
        vv_text_free(got, n);
        vv_image_release(back);
    }
    vv_image_release(image);
    free(large);
}

static vv_status text_of_memory(const void *data, size_t n)
{
    vv_source *source;
    vv_text *text;
    size_t n_text;
    assert_int_equal(vvi_source_memory(&source, data, n, "test.png", NULL), VV_OK);
    const vv_status st = vvi_image_format_png.read_text(&text, &n_text, source, NULL);
    if (st != VV_OK)
        assert_null(text);
    vv_text_free(text, n_text);
    vvi_source_close(source);
    return st;
}

static void damaged_text_is_refused_and_never_crashes(void **state)
{
    (void)state;
    char *large = malloc(3001);
    memset(large, 'x', 3000);
    large[3000] = 0;
    vv_text text[] = {{"A", large}, {"B", "plain"}, {"C", "\xc3\xbc"}};
    vv_image_options options;
    vv_image_options_init(&options, sizeof options);
    options.text = text;
    options.n_text = 3;
    vv_image *image = picture(2, 2, 8, false);
    assert_int_equal(vv_image_write(path_of("a.png"), image, &options, NULL), VV_OK);
    size_t n;
    uint8_t *data = slurp(path_of("a.png"), &n);
    assert_int_equal(text_of_memory(data, n), VV_OK);
    for (size_t cut = 0; cut + 4 < n; cut++)
        assert_int_equal(text_of_memory(data, cut), VV_E_FORMAT);
    size_t refused = 0;
    for (size_t at = 0; at < n; at++)
        for (int bit = 0; bit < 8; bit++) {
            data[at] ^= (uint8_t)(1 << bit);
            refused += text_of_memory(data, n) != VV_OK;
            data[at] ^= (uint8_t)(1 << bit);
        }
    assert_true(refused > n);
    free(data);
    free(large);
    vv_image_release(image);
}

static void keys_that_png_does_not_allow_are_refused(void **state)
{
    (void)state;
    char endless[90];
    memset(endless, 'k', sizeof endless - 1);
    endless[89] = 0;
    char *const keys[] = {(char[]){""},     (char[]){" a"},       (char[]){"a "},
                          (char[]){"a  b"}, (char[]){"\xc3\xbc"}, endless};
    vv_image *image = picture(2, 2, 8, false);
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        vv_text text = {keys[i], (char[]){"v"}};
        vv_image_options options;
        vv_image_options_init(&options, sizeof options);
        options.text = &text;
        options.n_text = 1;
        assert_int_equal(vv_image_write(path_of("b.png"), image, &options, NULL), VV_E_ARGUMENT);
    }
    vv_image_release(image);
}

/* Any PNG, made by libpng itself ------------------------------------------------------------------------------- */

typedef struct memory_file {
    uint8_t data[65536];
    size_t n;
} memory_file;

static void to_memory(png_structp png, png_bytep data, size_t n)
{
    memory_file *m = png_get_io_ptr(png);
    assert_true(m->n + n <= sizeof m->data);
    memcpy(m->data + m->n, data, n);
    m->n += n;
}

static void no_flush(png_structp png)
{
    (void)png;
}

/* A 9 x 5 picture whose sample number s (in row order) has the lowest `bits` bits of 37 s + 11. */
static unsigned code(unsigned s, int bits)
{
    return (37 * s + 11) & ((1u << bits) - 1);
}

static void make_png(memory_file *m, int color, int bits, bool interlaced, bool keyed)
{
    static const int channels_of[7] = {1, 0, 3, 1, 2, 0, 4};
    const int channels = channels_of[color];
    uint8_t rows[5][80] = {{0}};
    png_bytep row[5];
    for (unsigned y = 0; y < 5; y++) {
        row[y] = rows[y];
        for (unsigned x = 0; x < 9 * (unsigned)channels; x++) {
            const unsigned v = code(y * 9 * (unsigned)channels + x, bits);
            if (bits == 16) {
                rows[y][2 * x] = (uint8_t)(v >> 8);
                rows[y][2 * x + 1] = (uint8_t)v;
            } else {
                rows[y][x * (unsigned)bits / 8] |= (uint8_t)(v << (8 - bits - x * (unsigned)bits % 8));
            }
        }
    }
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    if (setjmp(png_jmpbuf(png)))
        fail_msg("libpng could not write the test's picture");
    m->n = 0;
    png_set_write_fn(png, m, to_memory, no_flush);
    png_set_IHDR(png, info, 9, 5, bits, color, interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (color == PNG_COLOR_TYPE_PALETTE) {
        png_color palette[256];
        png_byte clear[1] = {0};
        for (int i = 0; i < 1 << bits; i++)
            palette[i] = (png_color){(png_byte)i, (png_byte)(255 - i), (png_byte)(i * 7)};
        png_set_PLTE(png, info, palette, 1 << bits);
        if (keyed)
            png_set_tRNS(png, info, clear, 1, NULL);
    } else if (keyed) {
        const png_color_16 key = {.gray = 11u & ((1u << bits) - 1),
                                  .red = (png_uint_16)code(0, bits),
                                  .green = (png_uint_16)code(1, bits),
                                  .blue = (png_uint_16)code(2, bits)};
        png_set_tRNS(png, info, NULL, 0, &key);
    }
    png_write_info(png, info);
    png_write_image(png, row);
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
}

static vv_status read_memory(vv_image **out, const void *data, size_t n)
{
    vv_source *source;
    assert_int_equal(vvi_source_memory(&source, data, n, "test.png", NULL), VV_OK);
    const vv_status st = vvi_image_format_png.read(out, NULL, NULL, source, NULL);
    vvi_source_close(source);
    return st;
}

/* The pixel that the PNG specification says, in codes 0..1. */
static void want_pixel(double out[4], unsigned i, int color, int bits, bool keyed)
{
    const double most = (1u << bits) - 1;
    const unsigned c[4] = {code(i * (color == 2   ? 3
                                     : color == 4 ? 2
                                     : color == 6 ? 4
                                                  : 1),
                                bits),
                           code(i * (color == 2   ? 3
                                     : color == 4 ? 2
                                                  : 4) +
                                    1,
                                bits),
                           code(i * (color == 2 ? 3 : 4) + 2, bits), code(i * 4 + 3, bits)};
    for (int k = 0; k < 3; k++)
        out[k] = color & 2 ? c[k] / most : c[0] / most;
    out[3] = color == 4 ? c[1] / most : color == 6 ? c[3] / most : 1;
    if (color == 3) {
        out[0] = c[0] / 255.0;
        out[1] = (255 - c[0]) / 255.0;
        out[2] = (c[0] * 7 & 255) / 255.0;
        out[3] = keyed && c[0] == 0 ? 0 : 1;
    } else if (keyed && color == 0) {
        out[3] = c[0] == (11u & ((1u << bits) - 1)) ? 0 : 1;
    } else if (keyed && color == 2) {
        out[3] = c[0] == code(0, bits) && c[1] == code(1, bits) && c[2] == code(2, bits) ? 0 : 1;
    }
}

static void every_kind_of_png_is_read(void **state)
{
    (void)state;
    static memory_file m;
    for (int color = 0; color <= 6; color++)
        for (int bits = 1; bits <= 16; bits *= 2)
            for (int way = 0; way < 4; way++) {
                const bool interlaced = way & 1, keyed = way & 2;
                const bool exists =
                    color == 0 || (color == 3 && bits <= 8) || ((color == 2 || color == 4 || color == 6) && bits >= 8);
                if (!exists || (keyed && color >= 4))
                    continue;
                make_png(&m, color, bits, interlaced, keyed);
                vv_image *image;
                if (read_memory(&image, m.data, m.n) != VV_OK)
                    fail_msg("colour type %d, %d bits: %s", color, bits, vv_error_last()->message);
                assert_true(image->width == 9 && image->height == 5);
                for (unsigned i = 0; i < 45; i++) {
                    double want[4];
                    want_pixel(want, i, color, bits, keyed);
                    for (int k = 0; k < 4; k++) {
                        const double v = k < 3 ? vv_srgb_decode(want[k]) * want[3] : want[3];
                        if (fabs((double)image->rgba[4 * i + (unsigned)k] - v) > 1e-6)
                            fail_msg("colour type %d, %d bits, pixel %u, channel %d", color, bits, i, k);
                    }
                }
                vv_image_release(image);
            }
}

static void every_truncation_is_refused(void **state)
{
    (void)state;
    static memory_file m;
    make_png(&m, 2, 8, true, false);
    for (size_t n = 0; n < m.n; n++) {
        vv_image *image;
        assert_int_equal(read_memory(&image, m.data, n), VV_E_FORMAT);
        assert_null(image);
    }
}

/* Chunks carry checksums, so nearly every flipped bit is found; what is read must at least be of a plausible size. */
static void flipped_bytes_never_crash(void **state)
{
    (void)state;
    static memory_file m;
    for (int color = 0; color <= 6; color += 2) {
        make_png(&m, color, 8, false, false);
        for (size_t at = 0; at < m.n; at++)
            for (int bit = 0; bit < 8; bit += 3) {
                m.data[at] ^= (uint8_t)(1 << bit);
                vv_image *image;
                const vv_status st = read_memory(&image, m.data, m.n);
                if (st == VV_OK)
                    assert_true(image->width <= 9 + 256 && image->height <= 5 + 256);
                vv_image_release(image);
                m.data[at] ^= (uint8_t)(1 << bit);
            }
    }
}

static uint32_t crc_of(const uint8_t *p, size_t n)
{
    uint32_t crc = ~0u;
    for (size_t i = 0; i < n; i++) {
        crc ^= p[i];
        for (int b = 0; b < 8; b++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static void a_small_file_that_claims_a_huge_picture_is_refused_at_once(void **state)
{
    (void)state;
    static memory_file m;
    make_png(&m, 2, 8, false, false);
    static const uint8_t sizes[][8] = {{0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff}, /* 65535 x 65535 */
                                       {0x7f, 0xff, 0xff, 0xff, 0, 0, 0, 1}, /* beyond the limit on sides */
                                       {0, 0, 0, 0, 0, 0, 0, 1}};            /* none at all */
    for (size_t s = 0; s < 3; s++) {
        memcpy(m.data + 16, sizes[s], 8);
        const uint32_t crc = crc_of(m.data + 12, 17);
        for (int b = 0; b < 4; b++)
            m.data[29 + b] = (uint8_t)(crc >> (24 - 8 * b));
        vv_image *image;
        assert_int_equal(read_memory(&image, m.data, m.n), VV_E_FORMAT);
        assert_null(image);
    }
}

static void files_that_are_no_images_and_suffixes_that_are_no_formats_are_told(void **state)
{
    (void)state;
    FILE *file = fopen(path_of("b.png"), "wb");
    assert_non_null(file);
    fputs("no picture", file);
    fclose(file);
    vv_image *image;
    assert_int_equal(vv_image_read(&image, NULL, NULL, path_of("b.png"), NULL), VV_E_FORMAT);
    assert_int_equal(vv_image_read(&image, NULL, NULL, path_of("none.png"), NULL), VV_E_READ);
    image = picture(2, 2, 8, false);
    assert_int_equal(vv_image_write(path_of("a.pgn"), image, NULL, NULL), VV_E_UNSUPPORTED);
    vv_image_options options;
    vv_image_options_init(&options, sizeof options);
    options.bits = 12;
    assert_int_equal(vv_image_write(path_of("a.png"), image, &options, NULL), VV_E_ARGUMENT);
    assert_int_equal(vv_image_write("/nonexistent-folder/a.png", image, NULL, NULL), VV_E_WRITE);
    vv_image_release(image);
}

static vv_status write_and_read(void *user)
{
    vv_image *back = NULL;
    vv_text *text = NULL;
    size_t n = 0;
    vv_image_options options;
    vv_text one = {(char[]){"Key"}, (char[]){"value"}};
    vv_image_options_init(&options, sizeof options);
    options.text = &one;
    options.n_text = 1;
    vv_status st = vv_image_write(path_of("a.png"), user, &options, NULL);
    if (st == VV_OK)
        st = vv_image_read(&back, &text, &n, path_of("a.png"), NULL);
    vv_image_release(back);
    vv_text_free(text, n);
    return st;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    vv_image *image = picture(20, 10, 8, true);
    assert_true(test_fail_each_alloc(write_and_read, image) > 8);
    vv_image_release(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(opaque_and_transparent_pictures_come_back_in_both_depths),
        cmocka_unit_test(an_image_said_to_be_opaque_is_written_over_black),
        cmocka_unit_test(thread_count_changes_no_byte),
        cmocka_unit_test(text_comes_back_with_and_without_pixels),
        cmocka_unit_test(damaged_text_is_refused_and_never_crashes),
        cmocka_unit_test(keys_that_png_does_not_allow_are_refused),
        cmocka_unit_test(every_kind_of_png_is_read),
        cmocka_unit_test(every_truncation_is_refused),
        cmocka_unit_test(flipped_bytes_never_crash),
        cmocka_unit_test(a_small_file_that_claims_a_huge_picture_is_refused_at_once),
        cmocka_unit_test(files_that_are_no_images_and_suffixes_that_are_no_formats_are_told),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
