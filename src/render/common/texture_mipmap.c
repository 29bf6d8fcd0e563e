/* Opening a texture, and the pyramid of its image. */
#include "core/job.h"
#include "core/memory.h"
#include "render/common/texture.h"
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
static vv_status shrink(float *to, const vvi_texture_level *small, const vvi_texture_level *large, float *scratch,
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
static vv_status find_sizes(vvi_texture *t, size_t *floats_out, const vv_image *image)
{
    int32_t n[2] = {image->width, image->height};
    *floats_out = 0;
    for (t->n_levels = 0; t->n_levels < VVI_TEXTURE_LEVELS;) {
        size_t floats;
        t->level[t->n_levels].first = (int32_t)(*floats_out / 4);
        memcpy(t->level[t->n_levels++].n, n, sizeof n);
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

vv_status vvi_texture_build_levels(vvi_texture *t, const vv_image *image, vv_job *job)
{
    size_t floats;
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
    for (int32_t i = 1; i < t->n_levels && st == VV_OK; i++) {
        t->level[i].rgba = next;
        st = shrink(next, &t->level[i], &t->level[i - 1], scratch, job);
        next += (size_t)t->level[i].n[0] * (size_t)t->level[i].n[1] * 4;
    }
    vvi_free(scratch);
    return st;
}

/* The most lengths of the texture in one of the World. */
static double most_per_length(const vv_affine *m)
{
    const vv_vec3 *a = m->axis;
    const double x = a[0].x * a[0].x + a[1].x * a[1].x + a[2].x * a[2].x;
    const double y = a[0].y * a[0].y + a[1].y * a[1].y + a[2].y * a[2].y;
    const double z = a[0].z * a[0].z + a[1].z * a[1].z + a[2].z * a[2].z;
    return sqrt(fmax(x, fmax(y, z)));
}

vv_status vvi_texture_open(vvi_texture *out, const vv_actor *actor, const vv_scene *scene, vv_job *job)
{
    const vv_texture *from = &actor->texture;
    const vv_affine m = vv_affine_compose(from->from_world, actor->index_to_world);
    const double rows[3][4] = {{m.axis[0].x, m.axis[1].x, m.axis[2].x, m.origin.x},
                               {m.axis[0].y, m.axis[1].y, m.axis[2].y, m.origin.y},
                               {m.axis[0].z, m.axis[1].z, m.axis[2].z, m.origin.z}};
    *out = (vvi_texture){.kind = from->kind,
                         .mapping = from->mapping,
                         .wrap = from->wrap,
                         .replace = from->apply == VV_APPLY_REPLACE,
                         .parallel = scene->lens.parallel,
                         .strength = (float)from->strength,
                         .seed = from->seed};
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 4; b++)
            out->from_index[a][b] = (float)rows[a][b];
    for (int c = 0; c < 6; c++)
        out->color[c / 3][c % 3] = (float)from->color[c / 3][c % 3];
    out->pixel = (float)(2 * scene->lens.half_height / scene->height * most_per_length(&from->from_world));
    if (!from->image)
        return VV_OK;
    out->aspect = (float)from->image->width / (float)from->image->height;
    const vv_status st = vvi_texture_build_levels(out, from->image, job);
    return st == VV_OK ? VV_OK : vv_fail_in(st, "volumes.%s.texture", actor->id);
}

void vvi_texture_close(vvi_texture *t)
{
    vvi_free(t->texels);
    t->texels = NULL;
}
