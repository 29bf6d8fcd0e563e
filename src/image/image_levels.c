#include "image/image_levels.h"
#include "core/job.h"
#include "core/memory.h"
#include <math.h>
#include <string.h>

/* The next smaller level of one number of texels. */
static int32_t half(int32_t n)
{
    return n > 1 ? n / 2 : 1;
}

/* Texels of `to` are means of those of `from` that they cover along one axis, parts of them counted in part: an odd
 * number halves with none left out. `stride` floats lie from one to the next. */
static void shrink_line(float *to, int32_t n_to, const float *from, int32_t n_from, size_t to_stride,
                        size_t from_stride)
{
    const double width = (double)n_from / n_to;
    for (int32_t i = 0; i < n_to; i++) {
        const double lo = i * width, hi = i + 1 < n_to ? (i + 1) * width : n_from;
        double sum[4] = {0};
        for (int32_t j = (int32_t)lo; j < n_from && j < hi; j++) {
            const double share = fmin(j + 1, hi) - fmax(j, lo);
            for (size_t c = 0; c < 4; c++)
                sum[c] += share * (double)from[(size_t)j * from_stride + c];
        }
        for (size_t c = 0; c < 4; c++)
            to[(size_t)i * to_stride + c] = (float)(sum[c] / (hi - lo));
    }
}

/* Along x into scratch, then along y. */
static vv_status shrink(float *to, const vvi_image_level *small, const vvi_image_level *large, float *scratch,
                        vv_job *job)
{
    const size_t row = (size_t)small->n[0] * 4;
    for (int32_t y = 0; y < large->n[1]; y++) {
        const float *from = large->rgba + (size_t)y * (size_t)large->n[0] * 4;
        shrink_line(scratch + (size_t)y * row, small->n[0], from, large->n[0], 4, 4);
        const vv_status st = vvi_job_poll(job);
        if (st != VV_OK)
            return st;
    }
    for (int32_t x = 0; x < small->n[0]; x++)
        shrink_line(to + (size_t)x * 4, small->n[1], scratch + (size_t)x * 4, large->n[1], row, row);
    return VV_OK;
}

/* Sizes of all levels, and how many floats they have together. */
static vv_status find_sizes(vvi_image_levels *t, size_t *floats_out, const vv_image *image)
{
    int32_t n[2] = {image->width, image->height};
    *floats_out = 0;
    for (t->n = 0; t->n < VVI_IMAGE_LEVELS;) {
        size_t floats;
        t->level[t->n].first = (int32_t)(*floats_out / 4);
        memcpy(t->level[t->n++].n, n, sizeof n);
        const vv_status st = vvi_mul3_size(&floats, (size_t)n[0], (size_t)n[1], 4 * sizeof(float));
        if (st != VV_OK)
            return st;
        *floats_out += floats / sizeof(float);
        if (*floats_out > INT32_MAX) /* kernels find texels by numbers of 32 bits */
            return vv_fail(VV_E_LIMIT,
                           "an image of %d x %d pixels: expected at most 536870911 with all levels; make it smaller",
                           (int)image->width, (int)image->height);
        if (n[0] == 1 && n[1] == 1)
            break;
        n[0] = half(n[0]);
        n[1] = half(n[1]);
    }
    return VV_OK;
}

vv_status vvi_image_levels_build(vvi_image_levels *t, const vv_image *image, vv_job *job)
{
    size_t floats;
    *t = (vvi_image_levels){0};
    vv_status st = find_sizes(t, &floats, image);
    if (st != VV_OK)
        return st;
    const size_t whole = (size_t)image->width * (size_t)image->height * 4;
    const size_t most = (size_t)half(image->width) * (size_t)image->height * 4;
    t->texels = vvi_alloc(job, floats * sizeof *t->texels, VVI_MEM_DERIVED);
    float *scratch = vvi_alloc(job, most * sizeof *scratch, VVI_MEM_SCRATCH);
    if (!t->texels || !scratch) {
        vvi_free(scratch);
        return vv_fail_memory((t->texels ? most : floats) * sizeof *scratch);
    }
    memcpy(t->texels, image->rgba, whole * sizeof *t->texels);
    float *next = t->texels + whole;
    t->level[0].rgba = t->texels;
    for (int32_t i = 1; i < t->n && st == VV_OK; i++) {
        t->level[i].rgba = next;
        st = shrink(next, &t->level[i], &t->level[i - 1], scratch, job);
        next += (size_t)t->level[i].n[0] * (size_t)t->level[i].n[1] * 4;
    }
    vvi_free(scratch);
    return st;
}

void vvi_image_levels_free(vvi_image_levels *levels)
{
    vvi_free(levels->texels);
    *levels = (vvi_image_levels){0};
}
