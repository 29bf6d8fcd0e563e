/* JPEG, EXR and PFM: what is written is read again, with its layers and its text; damaged files are refused. PNG has
 * a test of its own. */
#include "config.h"
#include "core/memory.h"
#include "fail_alloc.h"
#include "fields.h"
#include "image/image_layer.h"
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

enum { ALL_LAYERS = (1 << VV_LAYER_COUNT) - 1 };
static const int32_t sizes[][2] = {{1, 1}, {1, 7}, {7, 1}, {13, 11}, {33, 64}, {211, 50}};
enum { N_SIZES = sizeof sizes / sizeof *sizes };

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
    strcpy(folder, "/tmp/volvis-images-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    static const char *const names[] = {"a.jpg",    "a.exr",         "a.pfm",       "a.tif",
                                        "a.webp",   "a.png",         "a.depth.pfm", "a.normal.pfm",
                                        "a.id.pfm", "a.samples.pfm", "a.value.pfm"};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        unlink(path_of(names[i]));
    return rmdir(folder);
}

static void skip_without(bool have)
{
    if (!have)
        skip();
}

/* Random pixels, some above 1, with the layers asked for; alpha 1 everywhere where it is opaque. */
static vv_image *picture(int32_t width, int32_t height, bool opaque, unsigned layers)
{
    vv_image *image;
    const size_t n = (size_t)width * (size_t)height;
    assert_int_equal(vv_image_new(&image, width, height, layers, NULL), VV_OK);
    for (size_t i = 0; i < n; i++) {
        const double a = opaque ? 1 : test_random_unit(3, 4 * i + 3);
        for (size_t c = 0; c < 3; c++)
            image->rgba[4 * i + c] = (float)(1.2 * a * test_random_unit(3, 4 * i + c));
        image->rgba[4 * i + 3] = (float)a;
    }
    for (size_t l = 0; l < VV_LAYER_COUNT; l++) {
        const vvi_layer *row = vvi_layer_nth(l);
        void *numbers = vvi_image_layer(image, l);
        for (size_t i = 0; numbers && i < n * row->channels; i++) {
            if (row->whole)
                ((uint32_t *)numbers)[i] = (uint32_t)(test_random(l, i) >> 41);
            else if (i % 3)
                ((float *)numbers)[i] = (float)(2000 * test_random_unit(l, i) - 1000);
        }
    }
    return image;
}

static void write_as(const char *name, const vv_image *image, const vv_image_options *options)
{
    if (vv_image_write(path_of(name), image, options, NULL) != VV_OK)
        fail_msg("%s: %s", name, vv_error_last()->message);
}

static vv_image *read_from(const char *name)
{
    vv_image *back;
    if (vv_image_read(&back, NULL, NULL, path_of(name), NULL) != VV_OK)
        fail_msg("%s: %s", name, vv_error_last()->message);
    return back;
}

static vv_image_options options_of(int bits, unsigned layers)
{
    vv_image_options options;
    vv_image_options_init(&options, sizeof options);
    options.bits = bits;
    options.layers = layers;
    return options;
}

static bool same_bits(const void *a, const void *b, size_t n)
{
    return memcmp(a, b, n * 4) == 0;
}

/* EXR ------------------------------------------------------------------------------------------------------------- */

static void exr_brings_every_float_and_layer_back(void **state)
{
    (void)state;
    skip_without(VV_HAVE_EXR);
    for (size_t s = 0; s < N_SIZES; s++) {
        const unsigned layers = s == 2 ? VV_LAYER_ID | VV_LAYER_DEPTH : ALL_LAYERS;
        const vv_image_options options = options_of(32, layers);
        const size_t n = (size_t)sizes[s][0] * (size_t)sizes[s][1];
        vv_image *image = picture(sizes[s][0], sizes[s][1], s % 2, ALL_LAYERS);
        write_as("a.exr", image, &options);
        vv_image *back = read_from("a.exr");
        assert_true(back->width == sizes[s][0] && back->height == sizes[s][1]);
        assert_int_equal(vv_image_layers(back), layers);
        assert_true(same_bits(image->rgba, back->rgba, 4 * n));
        for (size_t l = 0; l < VV_LAYER_COUNT; l++)
            if (layers >> l & 1)
                assert_true(
                    same_bits(vvi_image_layer(image, l), vvi_image_layer(back, l), n * vvi_layer_nth(l)->channels));
        vv_image_release(image);
        vv_image_release(back);
    }
}

/* A half has 11 bits: half a unit in the last place is 2^-11 of the value, and 2^-25 near 0. */
static void exr_halves_are_the_nearest(void **state)
{
    (void)state;
    skip_without(VV_HAVE_EXR);
    vv_image *image = picture(64, 33, false, 0);
    write_as("a.exr", image, NULL);
    vv_image *back = read_from("a.exr");
    for (size_t i = 0; i < 4 * 64 * 33; i++) {
        const double a = (double)image->rgba[i], b = (double)back->rgba[i];
        if (!(fabs(a - b) <= fmax(fabs(a) * 0x1p-11, 0x1p-25)))
            fail_msg("number %zu: %g is %g", i, a, b);
    }
    vv_image_release(image);
    vv_image_release(back);
}

/* PFM and layers beside ------------------------------------------------------------------------------------------- */

static void pfm_brings_every_float_back(void **state)
{
    (void)state;
    for (size_t s = 0; s < N_SIZES; s++) {
        vv_image *image = picture(sizes[s][0], sizes[s][1], true, 0);
        write_as("a.pfm", image, NULL);
        vv_image *back = read_from("a.pfm");
        assert_true(back->width == sizes[s][0] && back->height == sizes[s][1]);
        assert_true(same_bits(image->rgba, back->rgba, 4 * (size_t)sizes[s][0] * (size_t)sizes[s][1]));
        vv_image_release(image);
        vv_image_release(back);
    }
}

static vv_status read_memory(vv_image **out, const vv_image_format *format, const void *data, size_t n, vv_job *job)
{
    vv_source *source;
    vv_text *text = NULL;
    size_t n_text = 0;
    assert_int_equal(vvi_source_memory(&source, data, n, "test.image", job), VV_OK);
    const vv_status st = format->read(out, &text, &n_text, source, job);
    if (st == VV_OK)
        vv_text_free(text, n_text);
    else
        assert_null(*out);
    vvi_source_close(source);
    return st;
}

static void pfm_of_both_byte_orders_is_read_from_the_bottom_up(void **state)
{
    (void)state;
    static const char little[] = "Pf\n1 2\n-1.0\n\0\0\0\x40\0\0\x80\x3f", big[] = "Pf 1\n2 1e0\n\x40\0\0\0\x3f\x80\0\0";
    const struct {
        const char *data;
        size_t n;
    } files[] = {{little, sizeof little - 1}, {big, sizeof big - 1}};
    for (int i = 0; i < 2; i++) {
        vv_image *image;
        assert_int_equal(read_memory(&image, &vvi_image_format_pfm, files[i].data, files[i].n, NULL), VV_OK);
        assert_true(image->rgba[0] == 1 && image->rgba[2] == 1 && image->rgba[3] == 1 && image->rgba[4] == 2);
        vv_image_release(image);
    }
}

static void pfm_headers_that_are_wrong_are_refused(void **state)
{
    (void)state;
    static const char *const wrong[] = {"PF\n0 1\n-1\n0000",
                                        "PF\n1 1\n0\n000000000000",
                                        "PF\n1.5 1\n-1\n000000000000",
                                        "PF\nx 1\n-1\n",
                                        "PG\n1 1\n-1\n",
                                        "PF\n70000 1\n-1\n",
                                        "PF\n60000 60000\n-1\n",
                                        "Pf\n1 1\n-1\n000",
                                        "PF\n1 nan\n-1\n",
                                        "PF\n1 1\n-1",
                                        "PF\n99999999999999999999999999999999999999999 1\n-1\n"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        vv_image *image;
        if (read_memory(&image, &vvi_image_format_pfm, wrong[i], strlen(wrong[i]), NULL) != VV_E_FORMAT)
            fail_msg("'%s' is taken", wrong[i]);
    }
}

static void layers_that_a_format_cannot_hold_are_files_beside(void **state)
{
    (void)state;
    const vv_image_options options = options_of(0, ALL_LAYERS);
    vv_image *image = picture(13, 11, true, ALL_LAYERS);
    write_as("a.png", image, &options);
    for (size_t l = 0; l < VV_LAYER_COUNT; l++) {
        const vvi_layer *row = vvi_layer_nth(l);
        char name[32];
        snprintf(name, sizeof name, "a.%s.pfm", row->name);
        char *path = vv_image_layer_path(path_of("a.png"), l, NULL);
        assert_string_equal(path, path_of(name));
        free(path);
        vv_image *back = read_from(name);
        for (size_t i = 0; i < 13 * 11; i++)
            for (size_t c = 0; c < 3; c++) {
                const size_t at = i * row->channels + (row->channels == 3 ? c : 0);
                const float want = row->whole ? (float)((const uint32_t *)vvi_image_layer(image, l))[at]
                                              : ((const float *)vvi_image_layer(image, l))[at];
                assert_true(same_bits(&back->rgba[4 * i + c], &want, 1));
            }
        vv_image_release(back);
    }
    vv_image_release(image);
}

static void what_cannot_be_written_is_said_before_the_work(void **state)
{
    (void)state;
    const vv_image_options no = options_of(12, 0), halves = options_of(16, 0), layers = options_of(0, VV_LAYER_ID);
    assert_int_equal(vv_image_check(path_of("a.png"), &no, NULL), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "8 or 16"));
    assert_int_equal(vv_image_check(path_of("a.pfm"), &halves, NULL), VV_E_ARGUMENT);
    assert_int_equal(vv_image_check(path_of("a.bmp"), NULL, NULL), VV_E_UNSUPPORTED);
    assert_int_equal(vv_image_check("-", &layers, NULL), VV_E_ARGUMENT);
    assert_int_equal(vv_image_check(path_of("a.png"), &halves, NULL), VV_OK);
    vv_image *image = picture(2, 2, true, 0);
    assert_int_equal(vv_image_write(path_of("a.png"), image, &layers, NULL), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "'id'"));
    vv_image_release(image);
}

/* JPEG ------------------------------------------------------------------------------------------------------------ */

/* A smooth picture: at quality 100 with full colour resolution only rounding is left, three codes at most. */
static void jpeg_is_srgb_with_colours_at_full_resolution(void **state)
{
    (void)state;
    skip_without(VV_HAVE_JPEG);
    for (size_t s = 0; s < N_SIZES; s++) {
        vv_image_options options = options_of(0, 0);
        options.quality = 100;
        const int32_t width = sizes[s][0], height = sizes[s][1];
        vv_image *image = picture(width, height, true, 0);
        for (int32_t y = 0; y < height; y++)
            for (int32_t x = 0; x < width; x++) {
                float *p = image->rgba + 4 * (size_t)(y * width + x);
                p[0] = (float)vv_srgb_decode((double)(x % 2)); /* columns red and blue: half the colours would be mud */
                p[1] = (float)vv_srgb_decode((y + 0.5) / height);
                p[2] = 1 - p[0];
            }
        write_as("a.jpg", image, &options);
        vv_image *back = read_from("a.jpg");
        assert_true(back->width == width && back->height == height);
        for (size_t i = 0; i < (size_t)(width * height); i++) {
            for (size_t c = 0; c < 3; c++) {
                const double a = vv_srgb_encode((double)image->rgba[4 * i + c]);
                assert_true(fabs(a - vv_srgb_encode((double)back->rgba[4 * i + c])) < 3.5 / 255);
            }
            assert_true(back->rgba[4 * i + 3] == 1);
        }
        vv_image_release(image);
        vv_image_release(back);
    }
}

static size_t bytes_of(const char *name)
{
    FILE *file = fopen(path_of(name), "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    const long n = ftell(file);
    fclose(file);
    return (size_t)n;
}

static void jpeg_quality_is_size(void **state)
{
    (void)state;
    skip_without(VV_HAVE_JPEG);
    vv_image *image = picture(100, 90, true, 0);
    size_t last = 0;
    for (int quality = 1; quality <= 100; quality += 33) {
        vv_image_options options = options_of(0, 0);
        options.quality = quality;
        write_as("a.jpg", image, &options);
        assert_true(bytes_of("a.jpg") > last);
        last = bytes_of("a.jpg");
    }
    vv_image_options options = options_of(0, 0);
    options.quality = 101;
    assert_int_equal(vv_image_write(path_of("a.jpg"), image, &options, NULL), VV_E_ARGUMENT);
    vv_image_release(image);
}

/* Text and damage, any format ------------------------------------------------------------------------------------- */

static void text_comes_back_with_and_without_pixels(void **state)
{
    (void)state;
    char *large = malloc(200001);
    for (int i = 0; i < 200000; i++)
        large[i] = "{\"\xc3\xbc\": [1, 2, 3]}\n"[i % 18];
    large[200000] = 0;
    vv_text text[] = {{"VolVis:Scene", large}, {"Software", "VolVis"}, {"Title", "\xe2\x82\xac = +1"}, {"Empty", ""}};
    vv_image_options options = options_of(0, 0);
    options.text = text;
    options.n_text = 4;
    vv_image *image = picture(40, 30, true, 0);
    static const struct {
        const char *name;
        bool there;
    } with_text[] = {{"a.jpg", VV_HAVE_JPEG},
                     {"a.exr", VV_HAVE_EXR},
                     {"a.tif", VV_HAVE_TIFF && VV_HAVE_EXPAT},
                     {"a.webp", VV_HAVE_WEBP && VV_HAVE_EXPAT}};
    for (size_t f = 0; f < sizeof with_text / sizeof *with_text; f++) {
        const char *name = with_text[f].name;
        if (!with_text[f].there)
            continue;
        write_as(name, image, &options);
        for (int way = 0; way < 2; way++) {
            vv_text *got;
            size_t n;
            vv_image *back = NULL;
            assert_int_equal(way ? vv_image_read(&back, &got, &n, path_of(name), NULL)
                                 : vv_image_read_text(&got, &n, path_of(name), NULL),
                             VV_OK);
            size_t found = 0;
            for (size_t i = 0; i < n; i++)
                for (size_t j = 0; j < 4; j++)
                    found += strcmp(got[i].key, text[j].key) == 0 && strcmp(got[i].value, text[j].value) == 0;
            assert_int_equal(found, 4);
            vv_text_free(got, n);
            vv_image_release(back);
        }
    }
    vv_image_release(image);
    free(large);
}

static uint8_t *slurp(const char *name, size_t *n)
{
    FILE *file = fopen(path_of(name), "rb");
    assert_non_null(file);
    uint8_t *data = malloc(1 << 20);
    *n = fread(data, 1, 1 << 20, file);
    fclose(file);
    return data;
}

static const struct {
    const char *name;
    const vv_image_format *format;
    bool there;
    size_t tail; /* bytes at the end without which the picture is whole all the same */
    bool partly; /* what there is of it is read, and the job is damaged */
} formats[] = {
    {"a.jpg", &vvi_image_format_jpeg, VV_HAVE_JPEG, 2, false}, /* the mark of the end */
    {"a.exr", &vvi_image_format_exr, VV_HAVE_EXR, 0, false},
    {"a.tif", &vvi_image_format_tiff, VV_HAVE_TIFF, 0, true},
    {"a.webp", &vvi_image_format_webp, VV_HAVE_WEBP, 0, false},
    {"a.pfm", &vvi_image_format_pfm, true, 0, false},
};

enum { N_FORMATS = sizeof formats / sizeof *formats };

static void every_truncation_is_refused_with_a_sentence(void **state)
{
    (void)state;
    vv_text text = {"VolVis:Scene", "{}"};
    for (size_t f = 0; f < N_FORMATS; f++) {
        vv_image_options options = options_of(0, 0);
        size_t n;
        if (!formats[f].there || formats[f].partly)
            continue;
        options.text = &text;
        options.n_text = 1;
        vv_image *image = picture(21, 20, true, 0);
        write_as(formats[f].name, image, &options);
        uint8_t *data = slurp(formats[f].name, &n);
        for (size_t cut = 0; cut + formats[f].tail < n; cut++) {
            vv_image *back;
            if (read_memory(&back, formats[f].format, data, cut, NULL) != VV_E_FORMAT)
                fail_msg("%s of %zu bytes is taken at %zu", formats[f].name, n, cut);
            assert_true(strlen(vv_error_last()->message) > 10);
        }
        free(data);
        vv_image_release(image);
    }
}

static void flipped_bits_never_crash(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 64 << 20);
    for (size_t f = 0; f < N_FORMATS; f++) {
        size_t n;
        if (!formats[f].there)
            continue;
        vv_image *image = picture(9, 5, true, 0);
        write_as(formats[f].name, image, NULL);
        uint8_t *data = slurp(formats[f].name, &n);
        for (size_t at = 0; at < n; at++)
            for (int bit = 0; bit < 8; bit += 3) {
                vv_image *back;
                data[at] ^= (uint8_t)(1 << bit);
                if (read_memory(&back, formats[f].format, data, n, job) == VV_OK)
                    vv_image_release(back);
                data[at] ^= (uint8_t)(1 << bit);
            }
        free(data);
        vv_image_release(image);
    }
    vv_job_release(job);
}

typedef struct act {
    const char *name;
    const vv_image *image;
} act;

static vv_status write_and_read(void *user)
{
    const act *a = user;
    vv_text text = {"VolVis:Scene", "{}"}, *got = NULL;
    size_t n = 0;
    vv_image_options options = options_of(0, VV_LAYER_DEPTH | VV_LAYER_ID);
    vv_image *back = NULL;
    options.text = &text;
    options.n_text = 1;
    vv_status st = vv_image_write(path_of(a->name), a->image, &options, NULL);
    if (st == VV_OK && (st = vv_image_read(&back, &got, &n, path_of(a->name), NULL)) == VV_OK) {
        vv_text_free(got, n);
        vv_image_release(back);
    }
    return st;
}

static void memory_that_is_refused_is_a_sentence(void **state)
{
    (void)state;
    vv_image *image = picture(17, 19, true, ALL_LAYERS);
    for (size_t f = 0; f < N_FORMATS; f++) {
        act a = {formats[f].name, image};
        if (formats[f].there)
            assert_true(test_fail_each_alloc(write_and_read, &a) > 3);
    }
    vv_image_release(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exr_brings_every_float_and_layer_back),
        cmocka_unit_test(exr_halves_are_the_nearest),
        cmocka_unit_test(pfm_brings_every_float_back),
        cmocka_unit_test(pfm_of_both_byte_orders_is_read_from_the_bottom_up),
        cmocka_unit_test(pfm_headers_that_are_wrong_are_refused),
        cmocka_unit_test(layers_that_a_format_cannot_hold_are_files_beside),
        cmocka_unit_test(what_cannot_be_written_is_said_before_the_work),
        cmocka_unit_test(jpeg_is_srgb_with_colours_at_full_resolution),
        cmocka_unit_test(jpeg_quality_is_size),
        cmocka_unit_test(text_comes_back_with_and_without_pixels),
        cmocka_unit_test(every_truncation_is_refused_with_a_sentence),
        cmocka_unit_test(flipped_bits_never_crash),
        cmocka_unit_test(memory_that_is_refused_is_a_sentence),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
