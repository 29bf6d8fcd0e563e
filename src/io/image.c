/* Images: life, options, text. */
#include "core/memory.h"
#include "core/status.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

#define SIDE_MOST 65536

vv_status vv_image_new(vv_image **out, int32_t width, int32_t height, bool depth, vv_job *job)
{
    *out = NULL;
    if (width < 1 || height < 1 || width > SIDE_MOST || height > SIDE_MOST)
        return vv_fail(VV_E_ARGUMENT, "an image of %d x %d pixels; each side must be between 1 and %d", width, height,
                       SIDE_MOST);
    const size_t n = (size_t)width * (size_t)height;
    vv_status st = vvi_memory_plan(job, n * (4 + depth) * sizeof(float), "an image");
    if (st != VV_OK)
        return st;
    vv_image *image = vvi_alloc_zeroed(job, sizeof *image, VVI_MEM_IMAGE);
    if (!image)
        return vv_fail_memory(sizeof *image);
    *image = (vv_image){.refs = 1, .width = width, .height = height};
    image->rgba = vvi_alloc_zeroed(job, n * 4 * sizeof(float), VVI_MEM_IMAGE);
    if (!image->rgba) {
        st = vv_fail_memory(n * 4 * sizeof(float));
        goto fail;
    }
    if (depth && !(image->depth = vvi_alloc(job, n * sizeof(float), VVI_MEM_IMAGE))) {
        st = vv_fail_memory(n * sizeof(float));
        goto fail;
    }
    for (size_t i = 0; depth && i < n; i++)
        image->depth[i] = INFINITY;
    *out = image;
    return VV_OK;
fail:
    vv_image_release(image);
    return st;
}

vv_image *vv_image_retain(vv_image *image)
{
    __atomic_fetch_add(&image->refs, 1, __ATOMIC_RELAXED);
    return image;
}

void vv_image_release(vv_image *image)
{
    if (!image || __atomic_fetch_sub(&image->refs, 1, __ATOMIC_ACQ_REL) != 1)
        return;
    vvi_free(image->rgba);
    vvi_free(image->depth);
    vvi_free(image);
}

void vv_image_options_init(vv_image_options *options, size_t size)
{
    const vv_image_options all = {.size = size, .bits = 8, .alpha = true};
    memcpy(options, &all, size < sizeof all ? size : sizeof all);
}

void vv_text_free(vv_text *text, size_t n)
{
    for (size_t i = 0; text && i < n; i++) {
        free(text[i].key);
        free(text[i].value);
    }
    free(text);
}
