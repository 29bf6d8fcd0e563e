/* The samples of Marching Cubes: as they lie, or made floats slice by slice; and each thread's room. */
#include "core/memory.h"
#include "grid/field.h"
#include "surface/marching_plan.h"

#include <string.h>

#define OUTSIDE (-1e18f) /* of the cap: so far below that the surface lies at the border */

static size_t slices_made(void)
{
    return VVI_MARCH_LAYERS + 3; /* the slices of the layers, and one on each side for gradients */
}

/* Of what a plane has for each row, in bytes: words of bits follow it, and have to lie where words may. */
static size_t row_bytes(const vvi_march *m)
{
    const size_t bytes = (size_t)m->n[1] * (2 * sizeof(uint32_t) + sizeof(vvi_march_span));
    return (bytes + sizeof(uint64_t) - 1) & ~(sizeof(uint64_t) - 1);
}

static void lay_out_plane(vvi_march_plane *plane, const vvi_march *m, char **at)
{
    const size_t rows = (size_t)m->n[1], bits = (rows * m->words + 1) * sizeof(uint64_t);
    plane->inside = (void *)*at;
    *at += bits;
    plane->known = (void *)*at;
    *at += bits;
    plane->x_first = (void *)*at;
    plane->y_first = plane->x_first + rows;
    plane->span = (void *)(plane->y_first + rows);
    *at += row_bytes(m);
}

vv_status vvi_march_worker_new(vvi_march_worker **out, const vvi_march *m)
{
    const size_t rows = (size_t)m->n[1], row = m->words * sizeof(uint64_t), head = (sizeof **out + 63) & ~(size_t)63;
    const size_t plane = 2 * (rows * m->words + 1) * sizeof(uint64_t) + row_bytes(m);
    const size_t made = m->made ? slices_made() * rows * (size_t)m->n[0] * sizeof(float) : 0;
    const size_t bytes = head + 2 * plane + 9 * row + 4 * rows + made + m->words + 64;
    char *memory = vvi_alloc_zeroed(m->job, bytes, VVI_MEM_SCRATCH);
    *out = (void *)memory;
    if (!memory)
        return vv_fail_memory(bytes);
    vvi_march_worker *w = *out;
    memory += head;
    lay_out_plane(&w->plane[0], m, &memory);
    lay_out_plane(&w->plane[1], m, &memory);
    w->bits = (void *)memory;
    w->crossed = w->bits + m->words;
    w->z_first = (void *)(w->crossed + 8 * m->words);
    w->made = (void *)(w->z_first + rows);
    w->states = (void *)(memory + 9 * row + 4 * rows + made);
    w->rows = m->brick.data;
    w->row_bytes = m->brick.stride[1];
    w->slice_bytes = m->brick.stride[2];
    return VV_OK;
}

void vvi_march_worker_free(vvi_march_worker *worker)
{
    vvi_free(worker);
}

static void make_row(float *out, const vvi_march *m, const char *in)
{
    enum { RUN = 256 };
    const size_t bytes = vv_type_bytes(m->brick.type);
    const int64_t n = m->n[0] - 2 * m->pad;
    char packed[RUN * 8];
    double v[RUN];
    if (m->pad)
        out[0] = out[n + 1] = OUTSIDE;
    out += m->pad;
    for (int64_t at = 0; at < n; at += RUN) {
        const int64_t now = n - at < RUN ? n - at : RUN;
        for (int64_t i = 0; i < now; i++)
            memcpy(packed + (size_t)i * bytes, in + (at + i) * m->brick.stride[0], bytes);
        vvi_samples_to_f64(v, packed, m->brick.type, (size_t)now);
        for (int64_t i = 0; i < now; i++)
            out[at + i] = vvi_march_float(m, v[i]);
    }
}

static void make_slice(float *out, const vvi_march *m, int64_t k)
{
    const int64_t nx = m->n[0], ny = m->n[1];
    const bool all_outside = k < m->pad || k >= m->n[2] - m->pad;
    const char *slice = (const char *)m->brick.data + (size_t)m->component * vv_type_bytes(m->brick.type) +
                        (k - m->pad) * m->brick.stride[2];
    for (int64_t j = 0; j < ny; j++, out += nx)
        if (all_outside || j < m->pad || j >= ny - m->pad)
            for (int64_t i = 0; i < nx; i++)
                out[i] = OUTSIDE;
        else
            make_row(out, m, slice + (j - m->pad) * m->brick.stride[1]);
}

void vvi_march_make(vvi_march_worker *w, const vvi_march *m, size_t item)
{
    const int64_t first = (int64_t)item * VVI_MARCH_LAYERS, last = first + VVI_MARCH_LAYERS + 1;
    if (!m->made)
        return;
    const int64_t begin = first > 0 ? first - 1 : 0, slice = m->n[0] * m->n[1];
    for (int64_t k = begin; k <= last && k < m->n[2]; k++)
        make_slice(w->made + (k - begin) * slice, m, k);
    w->row_bytes = m->n[0] * (int64_t)sizeof *w->made;
    w->slice_bytes = slice * (int64_t)sizeof *w->made;
    w->rows = (const char *)w->made - begin * w->slice_bytes;
}

static const void *row_as_it_lies(const vvi_march *m, int64_t j, int64_t k)
{
    return (const char *)m->brick.data + j * m->brick.stride[1] + k * m->brick.stride[2];
}

#define AS_IT_LIES(march_type, ctype)                                                                                  \
    case march_type:                                                                                                   \
        return (double)((const ctype *)row_as_it_lies(m, j, k))[i]

double vvi_march_sample(const vvi_march *m, int64_t i, int64_t j, int64_t k)
{
    if (!m->made)
        switch (m->type) {
            AS_IT_LIES(VVI_MARCH_U8, uint8_t);
            AS_IT_LIES(VVI_MARCH_U16, uint16_t);
            AS_IT_LIES(VVI_MARCH_I16, int16_t);
        default:
            AS_IT_LIES(VVI_MARCH_F32, float);
        }
    const int64_t at[3] = {i - m->pad, j - m->pad, k - m->pad};
    const char *sample = (const char *)m->brick.data + (size_t)m->component * vv_type_bytes(m->brick.type);
    for (int a = 0; a < 3; a++) {
        if (at[a] < 0 || at[a] >= m->grid.dims[a])
            return OUTSIDE;
        sample += at[a] * m->brick.stride[a];
    }
    double v;
    vvi_samples_to_f64(&v, sample, m->brick.type, 1);
    return vvi_march_float(m, v);
}
