/* Image files: by the registry's image formats. */
#include "core/job.h"
#include "io/sink.h"
#include "io/source.h"

#include <ctype.h>
#include <string.h>

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

static vv_status check_options(const vv_image_options *options)
{
    if (options->bits != 8 && options->bits != 16)
        return vv_fail(VV_E_ARGUMENT, "images have 8 or 16 bits a channel, not %d", options->bits);
    for (size_t i = 0; i < options->n_text; i++)
        if (!options->text[i].key || !options->text[i].value)
            return vv_fail(VV_E_ARGUMENT, "text %zu of the image has no key or no value", i);
    return VV_OK;
}

vv_status vv_image_write(const char *path, const vv_image *image, const vv_image_options *options, vv_job *job)
{
    vv_image_options full;
    vv_image_options_init(&full, sizeof full);
    if (options)
        memcpy(&full, options, options->size < sizeof full ? options->size : sizeof full);
    vv_status st = check_options(&full);
    if (st != VV_OK)
        return st;
    const vv_image_format *format = format_of_path(path, job);
    if (!format || !format->write)
        return vv_fail_at(VV_E_UNSUPPORTED, path, NULL,
                          "no image format has this suffix and can be written; give one that `volvis formats` lists, "
                          "such as .png");
    vv_sink *sink;
    if ((st = vvi_sink_open(&sink, path, job)) != VV_OK)
        return st;
    if ((st = format->write(sink, image, &full, job)) != VV_OK) {
        vvi_sink_abandon(sink);
        return st;
    }
    return vvi_sink_commit(sink);
}

/* By content; the suffix is not asked, since it tells nothing that the content does not. */
static vv_status open_image(vv_source **source_out, const vv_image_format **format_out, const char *path, vv_job *job)
{
    const vv_status st = vvi_source_open(source_out, path, job);
    if (st != VV_OK)
        return st;
    size_t n = 0;
    const uint8_t *head = vvi_source_peek(*source_out, 256, &n);
    const vv_image_format *const *formats = vvi_job_registry(job)->image_formats;
    int best = 0;
    *format_out = NULL;
    for (size_t f = 0; formats[f]; f++) {
        const int sure = formats[f]->probe && head ? formats[f]->probe(head, n, path) : 0;
        if (sure > best) {
            best = sure;
            *format_out = formats[f];
        }
    }
    if (*format_out)
        return VV_OK;
    vvi_source_close(*source_out);
    *source_out = NULL;
    return vv_fail_at(VV_E_FORMAT, path, NULL, "this is no image of a known format; `volvis formats` lists them");
}

vv_status vv_image_read_text(vv_text **text_out, size_t *n_text_out, const char *path, vv_job *job)
{
    vv_source *source;
    const vv_image_format *format;
    *text_out = NULL;
    *n_text_out = 0;
    vv_status st = open_image(&source, &format, path, job);
    if (st != VV_OK)
        return st;
    if (format->read_text)
        st = format->read_text(text_out, n_text_out, source, job);
    vvi_source_close(source);
    return st;
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
    vv_status st = open_image(&source, &format, path, job);
    if (st != VV_OK || !format)
        return st;
    if (!format->read)
        st = vv_fail_at(VV_E_UNSUPPORTED, path, NULL, "images of format %s can only be written", format->name);
    else
        st = format->read(out, text_out, n_text_out, source, job);
    vvi_source_close(source);
    return st;
}
