/* Image files: by the registry's image formats. */
#include "core/allowed_places.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "import/import_image.h"
#include "io/format.h"
#include "io/image_source.h"
#include "io/images/pfm.h"
#include "io/open_place.h"
#include "io/sink.h"
#include "io/source.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define DPI_MOST 100000
#define HEAD_BYTES 256

static bool ends_with(const char *path, const char *suffix)
{
    const size_t n = strlen(path), m = strlen(suffix);
    if (m >= n)
        return false;
    for (size_t i = 0; i < m; i++)
        if (tolower((unsigned char)path[n - m + i]) != tolower((unsigned char)suffix[i]))
            return false;
    return true;
}

/* Standard output has no suffix: the first format that writes, which is PNG. */
static const vv_image_format *format_of_path(const char *path, const vv_job *job)
{
    const vv_image_format *const *formats = vvi_job_registry(job)->image_formats;
    for (size_t f = 0; formats[f]; f++) {
        if (strcmp(path, "-") == 0 && formats[f]->write)
            return formats[f];
        for (const char *const *suffix = formats[f]->suffixes; *suffix; suffix++)
            if (ends_with(path, *suffix))
                return formats[f];
    }
    return NULL;
}

/* What the format is told: `given` with its defaults filled in. */
static vv_status take_options(vv_image_options *out, const vv_image_options *given, const vv_image_format *format)
{
    vvi_text names = {0};
    bool known = false;
    vv_image_options_init(out, sizeof *out);
    vvi_options_over(out, sizeof *out, given);
    if (out->quality == 0)
        out->quality = format->quality;
    if (out->bits == 0)
        out->bits = format->bits ? format->bits[0] : 8;
    for (size_t i = 0; format->bits && format->bits[i]; i++) {
        known = known || format->bits[i] == out->bits;
        vvi_text_printf(&names, "%s%d", i ? " or " : "", format->bits[i]);
    }
    vv_status st = VV_OK;
    if (format->bits && !known)
        st = vv_fail(VV_E_ARGUMENT, "images of format %s have %s bits per channel, not %d", format->name,
                     names.bad ? "other" : names.s, out->bits);
    else if (out->quality < 0 || out->quality > 100)
        st = vv_fail(VV_E_ARGUMENT, "the quality of an image is 1 to 100, not %d", out->quality);
    else if (!(out->dpi >= 0 && out->dpi <= DPI_MOST))
        st = vv_fail(VV_E_ARGUMENT, "an image has up to %d pixels per inch, not %g", DPI_MOST, out->dpi);
    vvi_text_free(&names);
    for (size_t i = 0; i < out->n_text && st == VV_OK; i++)
        if (!out->text[i].key || !*out->text[i].key || !out->text[i].value)
            st = vv_fail(VV_E_ARGUMENT, "text %zu of the image has no key or no value", i);
    return st;
}

static vv_status choose(const vv_image_format **format_out, vv_image_options *out, const char *path,
                        const vv_image_options *given, const vv_job *job)
{
    const vv_image_format *format = format_of_path(path, job);
    *format_out = format;
    if (format && !format->write)
        return vv_fail_at(VV_E_UNSUPPORTED, path, NULL, "%s images cannot be written: %s", format->name, format->doc);
    if (!format)
        return vv_fail_at(VV_E_UNSUPPORTED, path, NULL,
                          "no image format has this suffix and can be written; give one that `volvis formats` lists, "
                          "such as .png");
    const vv_status st = take_options(out, given, format);
    if (st == VV_OK && (out->layers & ~format->layers) && strcmp(path, "-") == 0)
        return vv_fail(VV_E_ARGUMENT,
                       "layers are files next to the image, which standard output has no place for; give a file name");
    return st;
}

vv_status vv_image_check(const char *path, const vv_image_options *options, vv_job *job)
{
    vv_image_options full;
    const vv_image_format *format;
    return choose(&format, &full, path, options, job);
}

static vv_status check_side(const char *path, const vv_image_format *format, int32_t width, int32_t height)
{
    const int32_t most = format->side_most;
    if (most == 0 || (width <= most && height <= most))
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, path, NULL,
                      "%s images have at most %d pixels per side, not %d x %d; make it smaller, or write PNG or TIFF",
                      format->name, most, width, height);
}

vv_status vv_image_check_size(const char *path, int32_t width, int32_t height, vv_job *job)
{
    vv_image_options full;
    const vv_image_format *format;
    const vv_status st = choose(&format, &full, path, NULL, job);
    return st == VV_OK ? check_side(path, format, width, height) : st;
}

/* Layers beside --------------------------------------------------------------------------------------------------- */

/* "a.png" -> "a.depth.pfm": without the suffix by which the format was found. */
static char *beside(const char *path, const char *layer, const vv_image_format *format)
{
    size_t n = strlen(path);
    for (const char *const *suffix = format->suffixes; *suffix; suffix++) {
        if (ends_with(path, *suffix)) {
            n -= strlen(*suffix);
            break;
        }
    }
    return vvi_asprintf("%.*s.%s.pfm", (int)n, path, layer);
}

char *vv_image_layer_path(const char *path, size_t index, vv_job *job)
{
    const vv_image_format *format = format_of_path(path, job);
    return !format || (format->layers >> index & 1) ? vvi_strdup(path) : beside(path, vv_layer_name(index), format);
}

static vv_status write_beside(vv_sink *sink, const char *path, const vv_image *image, size_t index,
                              const vv_image_format *format, vv_job *job)
{
    vv_sink *layer = NULL; /* belongs to `sink` */
    const char *slash = strrchr(path, '/');
    char *name = beside(slash ? slash + 1 : path, vv_layer_name(index), format);
    if (!name)
        return vv_fail_memory(strlen(path));
    vv_status st = vvi_sink_beside(&layer, sink, name);
    free(name);
    return st == VV_OK ? vvi_pfm_write_layer(layer, image, index, job) : st;
}

static vv_status check_layers(const vv_image *image, unsigned layers)
{
    const unsigned missing = layers & ~vv_image_layers(image);
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        if (missing >> i & 1)
            return vv_fail(VV_E_ARGUMENT, "the image has no layer '%s' to write", vv_layer_name(i));
    return VV_OK;
}

static vv_status write_all(vv_sink *sink, const char *path, const vv_image *image, const vv_image_options *options,
                           const vv_image_format *format, vv_job *job)
{
    const unsigned apart = options->layers & ~format->layers;
    vv_status st = format->write(sink, image, options, job);
    for (size_t i = 0; i < VV_LAYER_COUNT && st == VV_OK; i++)
        if (apart >> i & 1)
            st = write_beside(sink, path, image, i, format, job);
    return st;
}

vv_status vv_image_write(const char *path, const vv_image *image, const vv_image_options *options, vv_job *job)
{
    vv_image_options full;
    const vv_image_format *format;
    vv_sink *sink;
    vv_status st;
    if ((st = choose(&format, &full, path, options, job)) != VV_OK ||
        (st = check_side(path, format, image->width, image->height)) != VV_OK ||
        (st = check_layers(image, full.layers)) != VV_OK || (st = vvi_sink_open(&sink, path, job)) != VV_OK)
        return st;
    if ((st = write_all(sink, path, image, &full, format, job)) != VV_OK) {
        vvi_sink_abandon(sink);
        return st;
    }
    return vvi_sink_commit(sink);
}

/* The format of an image that is written row by row. */
static vv_status choose_for_rows(const vv_image_format **format_out, vv_image_options *out, const char *path,
                                 const vv_image_rows *rows, const vv_image_options *options, vv_job *job)
{
    vv_status st = choose(format_out, out, path, options, job);
    if (st == VV_OK)
        st = check_side(path, *format_out, rows->width, rows->height);
    if (st == VV_OK && (!(*format_out)->write_rows || out->layers))
        st = vv_fail_at(VV_E_UNSUPPORTED, path, NULL,
                        "an image of %d x %d pixels is more than the memory limit allows at once, and %s", rows->width,
                        rows->height,
                        out->layers ? "layers need all of it; omit them"
                                    : "this format needs all of it; write PNG, which is written row by row");
    return st;
}

vv_status vv_image_check_rows(const char *path, int32_t width, int32_t height, const vv_image_options *options,
                              vv_job *job)
{
    vv_image_options full;
    const vv_image_format *format;
    return choose_for_rows(&format, &full, path, &(vv_image_rows){.width = width, .height = height}, options, job);
}

vv_status vv_image_write_rows(const char *path, const vv_image_rows *rows, const vv_image_options *options, vv_job *job)
{
    vv_image_options full;
    const vv_image_format *format;
    vv_sink *sink;
    vv_status st = choose_for_rows(&format, &full, path, rows, options, job);
    if (st != VV_OK || (st = vvi_sink_open(&sink, path, job)) != VV_OK)
        return st;
    if ((st = format->write_rows(sink, rows, &full, job)) == VV_OK)
        return vvi_sink_commit(sink);
    vvi_sink_abandon(sink);
    return st;
}

vv_status vv_image_encode(uint8_t **out, size_t *n_out, const char *suffix, const vv_image *image,
                          const vv_image_options *options, vv_job *job)
{
    vv_image_options full;
    const vv_image_format *format;
    vv_sink *sink;
    char name[64];
    vv_status st;
    *out = NULL;
    *n_out = 0;
    snprintf(name, sizeof name, "image%s", suffix);
    if ((st = choose(&format, &full, name, options, job)) != VV_OK)
        return st;
    if ((st = check_side(name, format, image->width, image->height)) != VV_OK)
        return st;
    if (full.layers)
        return vv_fail(VV_E_ARGUMENT, "layers cannot be written to memory");
    if ((st = vvi_sink_open_memory(&sink, name, job)) != VV_OK)
        return st;
    if ((st = format->write(sink, image, &full, job)) == VV_OK)
        return vvi_sink_take(out, n_out, sink);
    vvi_sink_abandon(sink);
    return st;
}

void vv_image_bytes_free(uint8_t *bytes)
{
    vvi_free(bytes);
}

static vv_status fail_unknown(const char *path)
{
    return vv_fail_at(VV_E_FORMAT, path, NULL, "is not an image in a known format; 'volvis formats' lists them");
}

/* By content; the suffix is not asked, since it tells nothing that the content does not. NULL: of none. */
static const vv_image_format *format_of(const uint8_t *head, size_t n, const char *path, const vv_job *job)
{
    const vv_image_format *const *formats = vvi_job_registry(job)->image_formats, *found = NULL;
    int best = 0;
    for (size_t f = 0; formats[f]; f++) {
        const int sure = formats[f]->probe && head ? formats[f]->probe(head, n, path) : 0;
        if (sure > best) {
            best = sure;
            found = formats[f];
        }
    }
    return found;
}

static const vv_image_format *format_of_source(vv_source *source, const vv_job *job)
{
    size_t n = 0;
    const uint8_t *head = vvi_source_peek(source, HEAD_BYTES, &n);
    return format_of(head, n, vvi_source_name(source), job);
}

static vv_status read_source(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source,
                             const vv_image_format *format, vv_job *job)
{
    if (!format->read)
        return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(source), NULL, "images in format %s can only be written",
                          format->name);
    return format->read(out, text_out, n_text_out, source, job);
}

/* Where alpha is 0 there is no colour. */
static void divide_alpha(vv_image *image)
{
    const size_t n = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < 4 * n; i += 4)
        for (size_t c = 0; c < 3 && image->rgba[i + 3] > 0; c++)
            image->rgba[i + c] /= image->rgba[i + 3];
}

vv_status vvi_image_read_straight(vv_image **out, vv_source *source, vv_job *job)
{
    const vv_image_format *format = format_of_source(source, job);
    *out = NULL;
    if (format && format->read_straight)
        return format->read_straight(out, source, job);
    const vv_status st =
        format ? read_source(out, NULL, NULL, source, format, job) : fail_unknown(vvi_source_name(source));
    if (st == VV_OK)
        divide_alpha(*out);
    return st;
}

static vv_status open_image(vv_source **source_out, const vv_image_format **format_out, const char *path, vv_job *job)
{
    *format_out = NULL;
    const vv_status st = vvi_source_open(source_out, path, job);
    if (st != VV_OK)
        return st;
    *format_out = format_of_source(*source_out, job);
    if (*format_out)
        return VV_OK;
    vvi_source_close(*source_out);
    *source_out = NULL;
    return fail_unknown(path);
}

/* Whether it is read by the import program: of streams some bytes have been taken then. */
static bool is_apart(const char *path, const vv_job *job)
{
    struct stat about;
    return (vvi_job_safe(job) || vvi_job_distrusts(job, path)) && strcmp(path, "-") != 0 && stat(path, &about) == 0 &&
           S_ISREG(about.st_mode);
}

/* No more than its first bytes are looked at here: most files that are opened are no images. */
static vv_status read_text_apart(vv_text **text_out, size_t *n_text_out, const char *path, vv_job *job)
{
    uint8_t head[HEAD_BYTES];
    const int fd = vvi_open_place(path, O_RDONLY, false, job);
    if (fd < 0)
        return vv_fail_at(VV_E_READ, path, NULL, "cannot be opened: %s", strerror(errno));
    const ssize_t n = pread(fd, head, sizeof head, 0);
    close(fd);
    const vv_image_format *format = n > 0 ? format_of(head, (size_t)n, path, job) : NULL;
    if (!format)
        return fail_unknown(path);
    return format->read_text ? vvi_import_image_text(text_out, n_text_out, path, job) : VV_OK;
}

vv_status vv_image_read_text(vv_text **text_out, size_t *n_text_out, const char *path, vv_job *job)
{
    vv_source *source;
    const vv_image_format *format;
    *text_out = NULL;
    *n_text_out = 0;
    if (is_apart(path, job))
        return read_text_apart(text_out, n_text_out, path, job);
    vv_status st = open_image(&source, &format, path, job);
    if (st != VV_OK)
        return st;
    if (format->read_text)
        st = format->read_text(text_out, n_text_out, source, job);
    vvi_source_close(source);
    return st;
}

static vv_status read_apart(vv_image **out, vv_text **text_out, size_t *n_text_out, const char *path, vv_job *job)
{
    vv_text *text = NULL;
    size_t n = 0;
    vv_status st = vvi_import_image(out, path, job);
    if (st != VV_OK || !text_out)
        return st;
    if ((st = vvi_import_image_text(&text, &n, path, job)) != VV_OK) {
        vv_image_release(*out);
        *out = NULL;
        return st;
    }
    *text_out = text;
    if (n_text_out)
        *n_text_out = n;
    return VV_OK;
}

vv_status vv_image_read(vv_image **out, vv_text **text_out, size_t *n_text_out, const char *path, vv_job *job)
{
    vv_source *source;
    const vv_image_format *format;
    *out = NULL;
    if (text_out)
        *text_out = NULL;
    if (n_text_out)
        *n_text_out = 0;
    if (is_apart(path, job))
        return read_apart(out, text_out, n_text_out, path, job);
    vv_status st = open_image(&source, &format, path, job);
    if (st != VV_OK || !format)
        return st;
    st = read_source(out, text_out, n_text_out, source, format, job);
    vvi_source_close(source);
    return st;
}
