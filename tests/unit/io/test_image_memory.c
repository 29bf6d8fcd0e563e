/* Pictures that are written and read where the system refuses memory, to whatever library asks for it: each single
 * request in turn. What is written then can be read, or a sentence says that it was not written. */
#include "config.h"
#include "io/source.h"
#include "jobs.h"
#include "registry.h"
#include <volvis/image.h>

#include <malloc.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* The allocator of the C library under its own names; these take its place for all libraries. */
extern void *__libc_malloc(size_t n);
extern void *__libc_calloc(size_t n, size_t size);
extern void *__libc_realloc(void *old, size_t n);
extern void *__libc_memalign(size_t boundary, size_t n);
extern void __libc_free(void *old);

static size_t held, most = SIZE_MAX;  /* bytes, and what there is of them */
static long asked, refused, refusals; /* requests; the one that is refused, 0: none; how many were */

static bool is_refused(size_t n)
{
    const bool is = ++asked == refused || n > most || held > most - n;
    refusals += is;
    return is;
}

static void *count(void *new)
{
    held += malloc_usable_size(new);
    return new;
}

void *malloc(size_t n)
{
    return is_refused(n) ? NULL : count(__libc_malloc(n));
}

void *calloc(size_t n, size_t size)
{
    return is_refused(n * size) ? NULL : count(__libc_calloc(n, size));
}

void *aligned_alloc(size_t boundary, size_t n)
{
    return is_refused(n) ? NULL : count(__libc_memalign(boundary, n));
}

void free(void *old)
{
    held -= malloc_usable_size(old);
    __libc_free(old);
}

void *realloc(void *old, size_t n)
{
    if (is_refused(n))
        return NULL;
    const size_t before = malloc_usable_size(old);
    void *new = count(__libc_realloc(old, n));
    held -= new || n == 0 ? before : 0;
    return new;
}

enum { WIDTH = 57, HEIGHT = 41 };

static vv_image *picture(bool opaque)
{
    vv_image *image;
    assert_int_equal(vv_image_new(&image, WIDTH, HEIGHT, 0, NULL), VV_OK);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const float a = opaque ? 1 : (float)(i % 7) / 6;
        const float rgba[4] = {a * (float)(i % WIDTH) / WIDTH, a * (float)i / (WIDTH * HEIGHT),
                               a * (float)(i % 13) / 13, a};
        memcpy(image->rgba + 4 * (size_t)i, rgba, sizeof rgba);
    }
    return image;
}

typedef struct way {
    const char *suffix;
    const vv_image_format *format;
    int quality; /* 0: the format's own */
    bool opaque, there;
    bool needs_all; /* its library is only called where all that it needs is there: no single request can fail alone */
} way;

static const way ways[] = {
    {".webp", &vvi_image_format_webp, 0, true, VV_HAVE_WEBP &&VV_HAVE_EXPAT, true},
    {".webp", &vvi_image_format_webp, 0, false, VV_HAVE_WEBP &&VV_HAVE_EXPAT, true},
    {".webp", &vvi_image_format_webp, 80, true, VV_HAVE_WEBP &&VV_HAVE_EXPAT, true},
    {".webp", &vvi_image_format_webp, 80, false, VV_HAVE_WEBP &&VV_HAVE_EXPAT, true},
    {".jpg", &vvi_image_format_jpeg, 0, true, VV_HAVE_JPEG, false},
    {".png", &vvi_image_format_png, 0, false, true, false},
};

/* Refuses the k-th request alone, or leaves a step more memory than last time. Whether it refused one says ended(). */
static void refuse(const way *w, long k)
{
    enum { STEP = 10007 };
    refusals = asked = 0;
    if (w->needs_all)
        most = held + (size_t)k * STEP;
    else
        refused = k;
}

static bool ended(void)
{
    refused = 0;
    most = SIZE_MAX;
    return refusals == 0;
}

static void expect_sentence(const way *w, long k, vv_status st)
{
    if (st != VV_E_MEMORY || strlen(vv_error_last()->message) < 10)
        fail_msg("%s, turn %ld: %d, %s", w->suffix, k, st, vv_error_last()->message);
}

static uint8_t *encode(const way *w, const vv_image *image, size_t *n, vv_status *st)
{
    static const vv_text text = {"VolVis:Scene", "{\"a\": 1}"};
    vv_image_options options;
    uint8_t *bytes = NULL;
    vv_image_options_init(&options, sizeof options);
    options.quality = w->quality;
    options.alpha = !w->opaque;
    options.text = &text;
    options.n_text = 1;
    *n = 0;
    *st = vv_image_encode(&bytes, n, w->suffix, image, &options, NULL);
    return bytes;
}

static vv_status decode(const way *w, const uint8_t *bytes, size_t n)
{
    vv_source *source;
    vv_image *image = NULL;
    vv_status st = vvi_source_memory(&source, bytes, n, "picture", NULL);
    if (st != VV_OK)
        return st;
    st = w->format->read(&image, NULL, NULL, source, NULL);
    assert_true((st == VV_OK) == (image != NULL));
    vv_image_release(image);
    vvi_source_close(source);
    return st;
}

static void what_is_written_without_memory_can_be_read_or_is_refused(void **state)
{
    (void)state;
    for (const way *w = ways; w < ways + sizeof ways / sizeof *ways; w++) {
        vv_image *image = picture(w->opaque);
        bool done = !w->there;
        for (long k = 1; !done; k++) {
            vv_status st;
            size_t n;
            refuse(w, k);
            uint8_t *bytes = encode(w, image, &n, &st);
            done = ended();
            if (st != VV_OK)
                expect_sentence(w, k, st);
            else if (decode(w, bytes, n) != VV_OK)
                fail_msg("%s, turn %ld: %s", w->suffix, k, vv_error_last()->message);
            vv_image_bytes_free(bytes);
        }
        vv_image_release(image);
    }
}

static void what_is_read_without_memory_is_not_called_damaged(void **state)
{
    (void)state;
    for (const way *w = ways; w < ways + sizeof ways / sizeof *ways; w++) {
        vv_image *image = picture(w->opaque);
        bool done = !w->there;
        vv_status st = VV_OK;
        size_t n = 0;
        uint8_t *bytes = done ? NULL : encode(w, image, &n, &st);
        assert_int_equal(st, VV_OK);
        for (long k = 1; !done; k++) {
            refuse(w, k);
            st = decode(w, bytes, n);
            done = ended();
            if (st != VV_OK)
                expect_sentence(w, k, st);
        }
        vv_image_bytes_free(bytes);
        vv_image_release(image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_written_without_memory_can_be_read_or_is_refused),
        cmocka_unit_test(what_is_read_without_memory_is_not_called_damaged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
