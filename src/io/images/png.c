/* PNG: the row of the table, and how libpng's jumps are caught. */
#include "io/images/png.h"

#include "core/memory.h"
#include "registry.h"

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void fail(png_structp png, png_const_charp message)
{
    vvi_png_error *error = png_get_error_ptr(png);
    if (error->refused && error->status == VV_OK)
        error->status = vv_fail_memory(error->refused);
    snprintf(error->text, sizeof error->text, "%s", message);
    png_longjmp(png, 1);
}

/* What libpng only warns of (an odd profile, a time stamp) does not change the picture. */
static void warn(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

static png_voidp take_memory(png_structp png, png_alloc_size_t n)
{
    vvi_png_error *error = png_get_mem_ptr(png);
    void *memory = vvi_realloc_plain(NULL, n);
    if (!memory)
        error->refused = n;
    return memory;
}

static void give_memory(png_structp png, png_voidp memory)
{
    (void)png;
    free(memory);
}

png_structp vvi_png_begin_write(vvi_png_error *error)
{
    return png_create_write_struct_2(PNG_LIBPNG_VER_STRING, error, fail, warn, error, take_memory, give_memory);
}

png_structp vvi_png_begin_read(vvi_png_error *error)
{
    return png_create_read_struct_2(PNG_LIBPNG_VER_STRING, error, fail, warn, error, take_memory, give_memory);
}

bool vvi_png_guard(png_structp png, void (*step)(void *user), void *user)
{
    if (setjmp(png_jmpbuf(png)))
        return false;
    step(user);
    return true;
}

static int probe(const uint8_t *head, size_t n, const char *path)
{
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    (void)path;
    return n >= sizeof signature && memcmp(head, signature, sizeof signature) == 0 ? 2 : 0;
}

static const char *const suffixes[] = {".png", NULL};
static const int bits[] = {8, 16, 0};

const vv_image_format vvi_image_format_png = {
    .api = VV_IMAGE_FORMAT_API,
    .name = "png",
    .doc = "PNG with 8 or 16 bits per channel, transparency and text; sRGB",
    .suffixes = suffixes,
    .probe = probe,
    .write = vvi_png_write,
    .write_rows = vvi_png_write_rows,
    .read = vvi_png_read,
    .read_straight = vvi_png_read_straight,
    .read_text = vvi_png_read_text,
    .bits = bits,
    .paper = true,
};
