#include "server/demos.h"
#include "core/job.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* |psi|^2 of hydrogen's 3d (m = 0), without constants: R ~ r^2 exp(-r / 3), Y ~ 3 cos^2 - 1; lengths in Bohr radii. */
static double orbital(double x, double y, double z)
{
    const double scale = 20, r2 = (x * x + y * y + z * z) * scale * scale;
    const double psi = (3 * z * z * scale * scale - r2) * exp(-sqrt(r2) / 3);
    return psi * psi / 100;
}

/* A sheet that ripples as the test signal of Marschner & Lobb (1994) does, finer and finer outwards. */
static double ripples(double x, double y, double z)
{
    const double frequency = 2, r = sqrt(x * x + y * y);
    const double away = z - 0.12 * cos(2 * M_PI * frequency * cos(M_PI * fmin(r, 1) / 2));
    return r < 1 ? 100 * exp(-away * away / 0.004) : 0;
}

/* A gyroid (Schoen 1970) in a ball: a labyrinth with one wall. */
static double gyroid(double x, double y, double z)
{
    const double k = 3 * M_PI, r = sqrt(x * x + y * y + z * z);
    const double g = sin(k * x) * cos(k * y) + sin(k * y) * cos(k * z) + sin(k * z) * cos(k * x);
    const double wall = 1.2 - fabs(g), ball = fmin(fmax((0.95 - r) * 12, 0), 1);
    return 100 * fmax(wall, 0) * ball;
}

static const vvi_demo samples[] = {
    {"orbital", "where the electron of a hydrogen atom is found in its 3d state", orbital},
    {"gyroid", "a labyrinth surface with one wall, inside a ball", gyroid},
    {"ripples", "a thin wavy sheet, after the test signal of Marschner and Lobb", ripples},
};
enum { N_SAMPLES = sizeof samples / sizeof *samples };

const vvi_demo *vvi_demo_nth(size_t index)
{
    return index < N_SAMPLES ? &samples[index] : NULL;
}

const vvi_demo *vvi_demo_find(const char *name)
{
    for (size_t i = 0; i < N_SAMPLES; i++)
        if (name && strcmp(samples[i].name, name) == 0)
            return &samples[i];
    return NULL;
}

typedef struct filling {
    const vvi_demo *sample;
    float *data;
    int64_t n;
} filling;

static vv_status fill_slice(void *scratch, void *user, size_t k)
{
    const filling *f = user;
    const double step = 2.0 / (double)(f->n - 1), z = -1 + (double)k * step;
    float *out = f->data + (int64_t)k * f->n * f->n;
    (void)scratch;
    for (int64_t j = 0; j < f->n; j++)
        for (int64_t i = 0; i < f->n; i++)
            *out++ = (float)f->sample->value(-1 + (double)i * step, -1 + (double)j * step, z);
    return VV_OK;
}

vv_status vvi_demo_make(vv_field **out, const vvi_demo *sample, int64_t n, vv_job *job)
{
    static const vvi_work work = {.stage = "make", .item = fill_slice};
    vv_field_info info = vv_field_info_default();
    filling f = {.sample = sample, .n = n};
    void *data;
    info.type = VV_TYPE_F32;
    info.components = 1;
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = n;
    snprintf(info.name, sizeof info.name, "%s", sample->name);
    vv_status st = vv_field_new_empty(out, &data, &info, job);
    if (st != VV_OK)
        return st;
    f.data = data;
    if ((st = vvi_parallel_for(job, &work, &f, (size_t)n)) != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}
