/* Planes and their separable filters. */
#include "image/image_planes.h"

#include "core/job.h"
#include "core/memory.h"
#include "image/image_srgb.h"

#include <string.h>

vv_status vvi_plane_new(vvi_plane *out, int32_t width, int32_t height, vv_job *job)
{
    const size_t bytes = (size_t)width * (size_t)height * sizeof *out->v;
    *out = (vvi_plane){width, height, vvi_alloc(job, bytes, VVI_MEM_SCRATCH)};
    return out->v ? VV_OK : vv_fail_memory(bytes);
}

void vvi_plane_free(vvi_plane *plane)
{
    vvi_free(plane->v);
    plane->v = NULL;
}

typedef struct pass {
    const vvi_plane *in;
    vvi_plane *out;
    const vvi_kernel *kernel;
} pass;

static int32_t clamp(int32_t i, int32_t n)
{
    return i < 0 ? 0 : i >= n ? n - 1 : i;
}

static vv_status along_row(void *scratch, void *user, size_t y)
{
    (void)scratch;
    const pass *p = user;
    const int32_t n = p->in->width, radius = p->kernel->radius;
    const double *in = p->in->v + y * (size_t)n;
    double *out = p->out->v + y * (size_t)n;
    for (int32_t x = 0; x < n; x++) {
        double sum = 0;
        for (int32_t r = -radius; r <= radius; r++)
            sum += p->kernel->w[radius + r] * in[clamp(x + r, n)];
        out[x] = sum;
    }
    return VV_OK;
}

static vv_status along_columns(void *scratch, void *user, size_t y)
{
    (void)scratch;
    const pass *p = user;
    const size_t n = (size_t)p->in->width;
    const int32_t radius = p->kernel->radius;
    double *out = p->out->v + y * n;
    memset(out, 0, n * sizeof *out);
    for (int32_t r = -radius; r <= radius; r++) {
        const double *in = p->in->v + (size_t)clamp((int32_t)y + r, p->in->height) * n;
        for (size_t x = 0; x < n; x++)
            out[x] += p->kernel->w[radius + r] * in[x];
    }
    return VV_OK;
}

vv_status vvi_plane_filter(vvi_plane *out, const vvi_plane *in, const vvi_kernel *x, const vvi_kernel *y, vv_job *job)
{
    static const vvi_work rows = {.item = along_row}, columns = {.item = along_columns};
    vvi_plane between;
    vv_status st = vvi_plane_new(&between, in->width, in->height, job);
    if (st != VV_OK)
        return st;
    pass first = {in, &between, x}, second = {&between, out, y};
    if ((st = vvi_parallel_for(job, &rows, &first, (size_t)in->height)) == VV_OK)
        st = vvi_parallel_for(job, &columns, &second, (size_t)in->height);
    vvi_plane_free(&between);
    return st;
}

vv_status vvi_image_codes(uint8_t **out, const vv_image *image, vv_job *job)
{
    vvi_srgb_table table;
    const size_t n = (size_t)image->width * (size_t)image->height;
    *out = vvi_alloc(job, 3 * n, VVI_MEM_SCRATCH);
    if (!*out)
        return vv_fail_memory(3 * n);
    vvi_srgb_table_init(&table);
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++)
            (*out)[3 * i + c] = vvi_srgb_code(&table, image->rgba[4 * i + c]);
    return VV_OK;
}
