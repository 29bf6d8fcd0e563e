/* Slices that are three around every second one become one, then their rows, then the samples of a row. */
#include "surface/subsample.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"

#include <math.h>
#include <string.h>

enum { FEWEST = 8 };

typedef struct halving {
    const vvi_march *m;
    const vvi_lattice_samples *from;
    int64_t n[3];   /* samples that are taken */
    bool halved[3]; /* axes */
    float *to;
    int kind; /* 0: mean, 1: the largest, -1: the smallest */
} halving;

/* Rows ------------------------------------------------------------------------------------------------------------ */

#define READ(march_type, ctype)                                                                                        \
    case march_type:                                                                                                   \
        for (int64_t i = 0; i < n; i++)                                                                                \
            out[i] = sign * ((float)((const ctype *)row)[i] - iso);                                                    \
        break

/* Row j of slice k of the lattice, less the value of the surface, rising as values do. */
static void read_row(float *out, const vvi_lattice_samples *from, int64_t j, int64_t k)
{
    const char *row = from->data + j * from->stride[1] + k * from->stride[2];
    const int64_t n = from->n[0];
    const float sign = from->inverted ? -1 : 1, iso = from->iso;
    switch (from->type) {
        READ(VVI_MARCH_U8, uint8_t);
        READ(VVI_MARCH_U16, uint16_t);
        READ(VVI_MARCH_I16, int16_t);
    default:
        for (int64_t i = 0; i < n; i++)
            out[i] = sign * (((const float *)row)[i] - iso);
    }
}

static void fold(float *restrict to, const float *restrict row, int64_t n, float weight, int kind)
{
    if (kind == 0)
        for (int64_t i = 0; i < n; i++)
            to[i] += weight * row[i];
    else if (kind > 0)
        for (int64_t i = 0; i < n; i++)
            to[i] = row[i] > to[i] ? row[i] : to[i];
    else
        for (int64_t i = 0; i < n; i++)
            to[i] = row[i] < to[i] ? row[i] : to[i];
}

static void begin_row(float *to, int64_t n, int kind)
{
    const float first = kind == 0 ? 0 : kind > 0 ? -INFINITY : INFINITY;
    for (int64_t i = 0; i < n; i++)
        to[i] = first;
}

/* Which samples along an axis go into number `at`, and how many times: three for a mean, around every second one; two
 * for the largest or smallest, so that each goes into one alone and little grows. Ends count for those beyond them. */
static int around(int64_t index[3], float weight[3], const halving *h, int axis, int64_t at)
{
    static const float weights[3] = {0.25f, 0.5f, 0.25f};
    const int n = h->kind == 0 ? 3 : 2;
    if (!h->halved[axis]) {
        index[0] = at;
        weight[0] = 1;
        return 1;
    }
    for (int i = 0; i < n; i++) {
        const int64_t p = 2 * at + i - (h->kind == 0), last = h->from->n[axis] - 1;
        index[i] = p < 0 ? 0 : p > last ? last : p;
        weight[i] = weights[i];
    }
    return n;
}

static void fold_along_row(float *out, const float *row, const halving *h)
{
    for (int64_t i = 0; i < h->n[0]; i++) {
        int64_t index[3];
        float weight[3];
        const int n = around(index, weight, h, 0, i);
        out[i] = row[index[0]];
        if (n == 3)
            out[i] = 0.25f * (row[index[0]] + row[index[2]]) + 0.5f * row[index[1]];
        else if (n == 2)
            out[i] = h->kind > 0 ? fmaxf(row[index[0]], row[index[1]]) : fminf(row[index[0]], row[index[1]]);
    }
}

/* Slices ---------------------------------------------------------------------------------------------------------- */

static vv_status start(void **scratch, void *user, int worker)
{
    const halving *h = user;
    const size_t bytes = (size_t)(h->from->n[1] + 2) * (size_t)h->from->n[0] * sizeof(float);
    (void)worker;
    *scratch = vvi_alloc(h->m->job, bytes, VVI_MEM_SCRATCH);
    return *scratch ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

/* Item: one slice of what is taken. */
static vv_status halve_slice(void *scratch, void *user, size_t k)
{
    const halving *h = user;
    const vvi_lattice_samples *from = h->from;
    const int64_t nx = from->n[0], ny = from->n[1];
    float *slice = scratch, *one = slice + nx * ny, *row = one + nx, weight[3];
    int64_t index[3];
    const int nz = around(index, weight, h, 2, (int64_t)k);
    for (int64_t j = 0; j < ny; j++) {
        begin_row(slice + j * nx, nx, h->kind);
        for (int i = 0; i < nz; i++) {
            read_row(one, from, j, index[i]);
            fold(slice + j * nx, one, nx, weight[i], h->kind);
        }
    }
    for (int64_t j = 0; j < h->n[1]; j++) {
        const int n = around(index, weight, h, 1, j);
        begin_row(row, nx, h->kind);
        for (int i = 0; i < n; i++)
            fold(row, slice + index[i] * nx, nx, weight[i], h->kind);
        fold_along_row(h->to + ((int64_t)k * h->n[1] + j) * h->n[0], row, h);
    }
    return vvi_job_poll(h->m->job);
}

/* Item: one slice of samples that are made floats. */
static vv_status make_slice(void *scratch, void *user, size_t k)
{
    const halving *h = user;
    const vvi_march *m = h->m;
    const size_t bytes = vv_type_bytes(m->brick.type);
    float *out = h->to + (int64_t)k * h->n[0] * h->n[1];
    (void)scratch;
    for (int64_t j = 0; j < h->n[1]; j++) {
        const char *row = (const char *)m->brick.data + (size_t)m->component * bytes + j * m->brick.stride[1] +
                          (int64_t)k * m->brick.stride[2];
        for (int64_t i = 0; i < h->n[0]; i++, out++) {
            double v;
            vvi_samples_to_f64(&v, row + i * m->brick.stride[0], m->brick.type, 1);
            *out = vvi_march_float(m, v);
        }
    }
    return vvi_job_poll(m->job);
}

static vv_status take_floats(float **out, const int64_t n[3], vv_job *job)
{
    size_t samples, bytes = 0;
    vv_status st = vvi_mul3_size(&samples, (size_t)n[0], (size_t)n[1], (size_t)n[2]);
    if (st == VV_OK)
        st = vvi_mul_size(&bytes, samples, sizeof(float));
    *out = st == VV_OK ? vvi_alloc(job, bytes + 64, VVI_MEM_SCRATCH) : NULL;
    return st == VV_OK && !*out ? vv_fail_memory(bytes) : st;
}

static void set_made(vvi_lattice_samples *l, float *made, const int64_t n[3])
{
    const float zero = 0;
    l->data = (const char *)made;
    l->made = made;
    l->type = VVI_MARCH_F32;
    memcpy(l->threshold, &zero, sizeof zero);
    l->inverted = false;
    l->iso = 0;
    for (int a = 0; a < 3; a++)
        l->n[a] = n[a];
    l->stride[0] = sizeof(float);
    l->stride[1] = n[0] * (int64_t)sizeof(float);
    l->stride[2] = l->stride[1] * n[1];
}

vv_status vvi_lattice_begin(vvi_lattice_samples *l, const vvi_march *m)
{
    static const vvi_work work = {.stage = "samples", .item = make_slice};
    *l = (vvi_lattice_samples){
        .data = m->brick.data, .type = m->type, .inverted = m->inverted, .iso = m->frame.iso, .step = {1, 1, 1}};
    memcpy(l->threshold, m->threshold, sizeof l->threshold);
    for (int a = 0; a < 3; a++) {
        l->n[a] = m->grid.dims[a];
        l->stride[a] = m->brick.stride[a];
    }
    if (!m->made)
        return VV_OK;
    float *made;
    vv_status st = take_floats(&made, l->n, m->job);
    if (st != VV_OK)
        return st;
    halving h = {.m = m, .n = {l->n[0], l->n[1], l->n[2]}, .to = made};
    set_made(l, made, h.n);
    if ((st = vvi_parallel_for(m->job, &work, &h, (size_t)h.n[2])) != VV_OK)
        vvi_lattice_finish(l);
    return st;
}

vv_status vvi_lattice_halve(vvi_lattice_samples *l, bool *more_out, const vvi_march *m, vvi_reduced_filter filter)
{
    static const vvi_work work = {.stage = "reducing", .start = start, .item = halve_slice, .finish = finish};
    static const int kinds[] = {[VVI_REDUCED_SMOOTH] = 0, [VVI_REDUCED_KEEP_HIGH] = 1, [VVI_REDUCED_KEEP_LOW] = -1};
    halving h = {.m = m, .from = l, .kind = kinds[filter]};
    *more_out = false;
    for (int a = 0; a < 3; a++) {
        h.halved[a] = l->n[a] > FEWEST;
        h.n[a] = !h.halved[a] ? l->n[a] : h.kind == 0 ? l->n[a] / 2 + 1 : (l->n[a] + 1) / 2;
        *more_out |= h.halved[a];
    }
    if (!*more_out)
        return VV_OK;
    vv_status st = take_floats(&h.to, h.n, m->job);
    if (st == VV_OK)
        st = vvi_parallel_for(m->job, &work, &h, (size_t)h.n[2]);
    vvi_free(l->made);
    l->made = NULL;
    if (st != VV_OK) {
        vvi_free(h.to);
        return st;
    }
    set_made(l, h.to, h.n);
    for (int a = 0; a < 3; a++) {
        l->offset[a] += h.halved[a] && h.kind ? 0.5 * l->step[a] : 0; /* between the two */
        l->step[a] *= h.halved[a] ? 2 : 1;
    }
    return VV_OK;
}

void vvi_lattice_finish(vvi_lattice_samples *l)
{
    vvi_free(l->made);
    l->made = NULL;
}
