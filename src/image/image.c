/* Images: life, options, text. */
#include "core/memory.h"
#include "core/status.h"
#include "image/image_layer.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static const vvi_layer layers_there_are[VV_LAYER_COUNT] = {
    {.name = "depth", .channels = 1, .empty = INFINITY, .offset = offsetof(vv_image, depth)},
    {.name = "normal", .channels = 3, .offset = offsetof(vv_image, normal)},
    {.name = "id", .channels = 1, .whole = true, .offset = offsetof(vv_image, id)},
    {.name = "samples", .channels = 1, .whole = true, .offset = offsetof(vv_image, samples)},
    {.name = "value", .channels = 1, .empty = NAN, .offset = offsetof(vv_image, value)},
};

const vvi_layer *vvi_layer_nth(size_t index)
{
    return &layers_there_are[index];
}

void *vvi_image_layer(const vv_image *image, size_t index)
{
    void *layer;
    memcpy(&layer, (const char *)image + layers_there_are[index].offset, sizeof layer);
    return layer;
}

const char *vv_layer_name(size_t index)
{
    return index < VV_LAYER_COUNT ? layers_there_are[index].name : NULL;
}

unsigned vv_image_layers(const vv_image *image)
{
    unsigned layers = 0;
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        layers |= vvi_image_layer(image, i) ? 1u << i : 0;
    return layers;
}

size_t vvi_image_pixel_bytes(unsigned layers)
{
    size_t numbers = 4;
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        numbers += layers >> i & 1 ? layers_there_are[i].channels : 0;
    return numbers * sizeof(float);
}

/* Zeros, written before any thread reads one. A page that is read first is mapped to the system's page of zeros, and
 * the write that follows interrupts every processor that runs a thread of this process: ten times what all else takes
 * of a frame of triangles. */
static float *zeros(size_t n, vv_job *job)
{
    float *layer = vvi_alloc(job, n * sizeof *layer, VVI_MEM_IMAGE);
    return layer ? memset(layer, 0, n * sizeof *layer) : NULL;
}

static vv_status add_layer(vv_image *image, size_t index, size_t n_pixels, vv_job *job)
{
    const vvi_layer *row = &layers_there_are[index];
    const size_t n = n_pixels * row->channels;
    float *layer = zeros(n, job);
    if (!layer)
        return vv_fail_memory(n * sizeof *layer);
    for (size_t i = 0; row->empty != 0 && i < n; i++)
        layer[i] = row->empty;
    memcpy((char *)image + row->offset, &layer, sizeof layer);
    return VV_OK;
}

vv_status vv_image_new(vv_image **out, int32_t width, int32_t height, unsigned layers, vv_job *job)
{
    *out = NULL;
    if (width < 1 || height < 1 || width > VVI_IMAGE_SIDE_MOST || height > VVI_IMAGE_SIDE_MOST)
        return vv_fail(VV_E_ARGUMENT, "an image of %d x %d pixels; each side must be between 1 and %d", width, height,
                       VVI_IMAGE_SIDE_MOST);
    const size_t n = (size_t)width * (size_t)height;
    vv_status st = vvi_memory_plan(job, n * vvi_image_pixel_bytes(layers), "an image");
    if (st != VV_OK)
        return st;
    vv_image *image = vvi_alloc_zeroed(job, sizeof *image, VVI_MEM_IMAGE);
    if (!image)
        return vv_fail_memory(sizeof *image);
    *image = (vv_image){.refs = 1, .width = width, .height = height};
    image->rgba = zeros(4 * n, job);
    if (!image->rgba)
        st = vv_fail_memory(n * 4 * sizeof(float));
    for (size_t i = 0; i < VV_LAYER_COUNT && st == VV_OK; i++)
        st = layers >> i & 1 ? add_layer(image, i, n, job) : VV_OK;
    if (st == VV_OK)
        *out = image;
    else
        vv_image_release(image);
    return st;
}

bool vvi_image_transparent(const vv_image *image)
{
    const size_t n = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < n; i++)
        if (!(image->rgba[4 * i + 3] >= 1))
            return true;
    return false;
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
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        vvi_free(vvi_image_layer(image, i));
    vvi_free(image);
}

void vv_image_options_init(vv_image_options *options, size_t size)
{
    const vv_image_options all = {.size = size, .alpha = true};
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
