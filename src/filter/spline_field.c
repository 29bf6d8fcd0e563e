#include "filter/spline_field.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>

vvi_knot vvi_knot_at(double place, int64_t spans)
{
    const double at = place * (double)spans;
    vvi_knot k = {.first = at >= (double)spans ? (int32_t)spans - 1 : at > 0 ? (int32_t)at : 0};
    const double t = at - k.first, s = 1 - t;
    k.weight[0] = s * s * s / 6;
    k.weight[1] = (3 * t * t * t - 6 * t * t + 4) / 6;
    k.weight[2] = (3 * s * s * s - 6 * s * s + 4) / 6;
    k.weight[3] = t * t * t / 6;
    for (int i = 0; i < 4; i++)
        k.squares += k.weight[i] * k.weight[i];
    return k;
}

static int64_t knots(const vvi_lattice *l, int axis)
{
    return l->spans[axis] + 3;
}

size_t vvi_lattice_size(const vvi_lattice *l)
{
    return (size_t)(knots(l, 0) * knots(l, 1) * knots(l, 2));
}

void vvi_lattice_row(double *out, const vvi_lattice *l, const vvi_knot *y, const vvi_knot *z)
{
    const int64_t n = knots(l, 0);
    memset(out, 0, (size_t)n * sizeof *out);
    for (int b = 0; b < 4; b++)
        for (int a = 0; a < 4; a++) {
            const double *row = l->c + n * (y->first + a + knots(l, 1) * (z->first + b));
            const double w = y->weight[a] * z->weight[b];
            for (int64_t x = 0; x < n; x++)
                out[x] += w * row[x];
        }
}

/* Sums of a slice of samples: of what is asked of each knot, and of squared weights. */
typedef struct fit {
    const vvi_lattice *lattice;
    const vvi_spline_samples *samples;
    double *sums;
    size_t size;
    vv_job *job;
} fit;

static void add(double *sum, const fit *f, const vvi_knot *x, const vvi_knot *y, const vvi_knot *z, double v)
{
    const double ask = v / (x->squares * y->squares * z->squares);
    for (int c = 0; c < 4; c++)
        for (int b = 0; b < 4; b++) {
            const double w = z->weight[c] * y->weight[b];
            double *to = sum + 2 * (x->first + knots(f->lattice, 0) *
                                                   (y->first + b + knots(f->lattice, 1) * (int64_t)(z->first + c)));
            for (int a = 0; a < 4; a++) {
                const double weight = w * x->weight[a], squared = weight * weight;
                to[2 * a] += squared * weight * ask;
                to[2 * a + 1] += squared;
            }
        }
}

static vv_status slice_item(void *scratch, void *user, size_t index)
{
    const fit *f = user;
    const vvi_spline_samples *s = f->samples;
    const double *v = s->v + (int64_t)index * s->n[1] * s->n[0];
    for (int64_t j = 0; j < s->n[1]; j++)
        for (int64_t i = 0; i < s->n[0]; i++, v++)
            if (!isnan(*v))
                add(f->sums + index * 2 * f->size, f, &s->knot[0][i], &s->knot[1][j], &s->knot[2][index], *v);
    return vvi_job_poll(f->job);
}

vv_status vvi_lattice_fit(vvi_lattice *lattice, const vvi_spline_samples *samples, vv_job *job)
{
    static const vvi_work work = {.item = slice_item};
    const size_t items = (size_t)samples->n[2], size = vvi_lattice_size(lattice);
    size_t bytes;
    vv_status st = vvi_mul3_size(&bytes, items, size, 2 * sizeof(double));
    if (st != VV_OK)
        return st;
    fit f = {.lattice = lattice, .samples = samples, .size = size, .job = job};
    if (!(f.sums = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH)))
        return vv_fail_memory(bytes);
    st = vvi_parallel_for(job, &work, &f, items);
    for (size_t c = 0; c < size && st == VV_OK; c++) {
        double ask = 0, weight = 0;
        for (size_t i = 0; i < items; i++) {
            ask += f.sums[2 * (i * size + c)];
            weight += f.sums[2 * (i * size + c) + 1];
        }
        lattice->c[c] += weight > 0 ? ask / weight : 0;
    }
    vvi_free(f.sums);
    return st;
}
