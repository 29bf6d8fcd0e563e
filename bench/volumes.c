/* Writes the volumes that the benchmarks render: closed forms plus hashed noise, the same on every machine up to the
 * last bit of sinf, so that two programs can be measured on equal data without shipping any.
 *
 *   volumes KIND N TYPE FILE      KIND head | ml | neuron | noise, TYPE u8 | f32, FILE *.nrrd; prints the samples'
 * CRC-32
 *
 * All fields are taken at p = 2 i / (n - 1) - 1 in [-1, 1]^3, x fastest, on a scale of 0..255:
 *   head    air 4, skin, fat, bone with orbits, nose, spine and teeth, brain with folds; noise of sigma 3 everywhere
 *   ml      the Marschner-Lobb signal, fM = 6, alpha = 0.25, no noise
 *   neuron  a branching tree of Gaussian tubes and beads, noise of sigma 1.5; sparse
 *   noise   uniform bytes: the worst case of every structure that skips or packs
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

/* One slice z = k is filled at a time; what depends on one or two coordinates alone is in tables. */
typedef struct volume {
    int n;
    float *c;     /* n: coordinate of a sample */
    float *slice; /* n * n, x fastest */
    void *extra;  /* of the kind */
} volume;

typedef struct kind {
    const char *name;
    bool (*begin)(volume *v);
    void (*fill)(volume *v, int k);
    void (*end)(volume *v);
    float sigma;
    uint32_t seed;
} kind;

/* Noise --------------------------------------------------------------------------------------------------------- */

static uint32_t mix32(uint32_t v)
{
    v ^= v >> 16;
    v *= 0x7feb352du;
    v ^= v >> 15;
    v *= 0x846ca68bu;
    v ^= v >> 16;
    return v;
}

/* Sum of four bytes: nearly normal, mean 510, standard deviation 147.8. */
static float noise_at(uint32_t index, float scale, uint32_t seed)
{
    const uint32_t h = mix32(index + seed * 0x9e3779b9u);
    const uint32_t sum = (h & 255) + ((h >> 8) & 255) + ((h >> 16) & 255) + (h >> 24);
    return ((float)sum - 510.0f) * scale;
}

/* Head ---------------------------------------------------------------------------------------------------------- */

/* Tables over one coordinate, all of n floats, and the three of the folds over two. */
typedef struct head_tables {
    float *sin9x, *sin8y, *sin7z, *sin6x, *cos5y, *sin41x, *sin37y, *sin43z, *sin11z, *sin5x, *sin4z, *sin48z;
    float *fold_xy, *fold_yz, *fold_zx; /* [y n + x], [z n + y], [z n + x] */
    float *store;
    float h;
} head_tables;

typedef struct ellipsoid {
    float c[3], r[3], scale;
} ellipsoid;

static float sine(float factor, float x, float phase)
{
    return sinf(factor * x + phase);
}

/* 1 inside (d < 0), 0 outside, smooth over |d| < h. */
static float smooth_step(float d, float h2)
{
    float t = 0.5f - d / h2;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    return t * t * (3.0f - 2.0f * t);
}

/* Roughly the signed distance. */
static float ellipsoid_at(const ellipsoid *e, float x, float y, float z)
{
    const float u = (x - e->c[0]) / e->r[0], v = (y - e->c[1]) / e->r[1], w = (z - e->c[2]) / e->r[2];
    return (sqrtf(u * u + v * v + w * w) - 1.0f) * e->scale;
}

static ellipsoid ellipsoid_of(double x, double y, double z, double rx, double ry, double rz)
{
    const double least = fmin(rx, fmin(ry, rz));
    return (ellipsoid){{(float)x, (float)y, (float)z}, {(float)rx, (float)ry, (float)rz}, (float)least};
}

static void over(float *v, float d, float h2, float value)
{
    const float m = smooth_step(d, h2);
    *v = *v + m * (value - *v);
}

static void head_fill_tables(volume *v, head_tables *t)
{
    const int n = v->n;
    for (int i = 0; i < n; i++) {
        const float p = v->c[i];
        t->sin9x[i] = sine(9, p, 0), t->sin8y[i] = sine(8, p, 0), t->sin7z[i] = sine(7, p, 0);
        t->sin6x[i] = sine(6, p, 1), t->cos5y[i] = cosf(5 * p), t->sin41x[i] = sine(41, p, 0);
        t->sin37y[i] = sine(37, p, 0), t->sin43z[i] = sine(43, p, 0), t->sin11z[i] = sine(11, p, 0);
        t->sin5x[i] = sine(5, p, 0), t->sin4z[i] = sine(4, p, 1), t->sin48z[i] = sine(48, p, 0);
    }
    for (int b = 0; b < n; b++) {
        for (int a = 0; a < n; a++) {
            const size_t at = (size_t)b * (size_t)n + (size_t)a;
            t->fold_xy[at] = sinf(23 * v->c[a] + 4 * sinf(9 * v->c[b]));
            t->fold_yz[at] = sinf(21 * v->c[a] + 4 * sinf(8 * v->c[b]));
            t->fold_zx[at] = sinf(19 * v->c[b] + 3 * sinf(7 * v->c[a]));
        }
    }
}

static bool head_begin(volume *v)
{
    const size_t n = (size_t)v->n;
    head_tables *t = calloc(1, sizeof *t);
    if (!t)
        return false;
    v->extra = t;
    t->store = malloc((12 * n + 3 * n * n) * sizeof *t->store);
    if (!t->store)
        return false;
    float **const lines[] = {&t->sin9x,  &t->sin8y,  &t->sin7z,  &t->sin6x, &t->cos5y, &t->sin41x,
                             &t->sin37y, &t->sin43z, &t->sin11z, &t->sin5x, &t->sin4z, &t->sin48z};
    float *at = t->store;
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++, at += n)
        *lines[i] = at;
    t->fold_xy = at;
    t->fold_yz = at + n * n;
    t->fold_zx = at + 2 * n * n;
    t->h = (float)(2 * (1.5 / v->n * 2));
    head_fill_tables(v, t);
    return true;
}

static float skull_and_brain(const volume *v, const head_tables *t, int i, int j, int k, float value)
{
    const ellipsoid skull = ellipsoid_of(0, 0, 0.02, 0.62, 0.76, 0.80),
                    nose = ellipsoid_of(0, 0.72, -0.2, 0.08, 0.22, 0.14);
    const ellipsoid right = ellipsoid_of(-0.25, 0.66, 0.05, 0.16, 0.24, 0.14);
    const ellipsoid left = ellipsoid_of(0.25, 0.66, 0.05, 0.16, 0.24, 0.14);
    const size_t n = (size_t)v->n;
    const float x = v->c[i], y = v->c[j], z = v->c[k];
    const float bone = ellipsoid_at(&skull, x, y, z) + 0.010f * t->sin6x[i] * t->cos5y[j] * t->sin7z[k];
    const float orbit = fminf(ellipsoid_at(&right, x, y, z), ellipsoid_at(&left, x, y, z));
    const float texture = 202.0f + 18.0f * t->sin41x[i] * t->sin37y[j] * t->sin43z[k] + 14.0f * t->sin11z[k];
    over(&value, fmaxf(bone, -fminf(orbit, ellipsoid_at(&nose, x, y, z))), t->h, texture);
    const float thick = 0.075f + 0.02f * t->sin5x[i] * t->sin4z[k];
    const float folds = 108.0f + 9.0f * t->fold_xy[(size_t)j * n + (size_t)i] * t->fold_yz[(size_t)k * n + (size_t)j] *
                                     t->fold_zx[(size_t)k * n + (size_t)i];
    over(&value, bone + thick, t->h, folds);
    const ellipsoid ventricle[2] = {ellipsoid_of(-0.1, -0.05, 0.15, 0.06, 0.28, 0.10),
                                    ellipsoid_of(0.1, -0.05, 0.15, 0.06, 0.28, 0.10)};
    over(&value, fminf(ellipsoid_at(&ventricle[0], x, y, z), ellipsoid_at(&ventricle[1], x, y, z)), t->h, 92.0f);
    return value;
}

static float spine(const volume *v, const head_tables *t, int i, int j, int k, float value)
{
    const float x = v->c[i], yy = v->c[j] + 0.35f, z = v->c[k];
    const float axis = sqrtf(x * x + yy * yy);
    const float column = axis - (0.12f + 0.025f * t->sin48z[k]);
    over(&value, fmaxf(fmaxf(column, z + 0.45f), -z - 0.95f), t->h, 188.0f);
    over(&value, fmaxf(fmaxf(axis - 0.045f, z + 0.40f), -z - 0.96f), t->h, 98.0f);
    return value;
}

static float teeth_and_eyes(const head_tables *t, const ellipsoid *teeth, const ellipsoid *eyes, float x, float y,
                            float z, float value)
{
    for (int a = 0; a < 14; a++)
        over(&value, ellipsoid_at(&teeth[a], x, y, z), t->h, 235.0f);
    for (int e = 0; e < 2; e++)
        over(&value, ellipsoid_at(&eyes[e], x, y, z), t->h, 118.0f);
    return value;
}

static void head_fill(volume *v, int k)
{
    const head_tables *t = v->extra;
    const ellipsoid skin_shape = ellipsoid_of(0, 0, 0, 0.72, 0.86, 0.92);
    const ellipsoid eyes[2] = {ellipsoid_of(-0.25, 0.68, 0.05, 0.11, 0.11, 0.11),
                               ellipsoid_of(0.25, 0.68, 0.05, 0.11, 0.11, 0.11)};
    ellipsoid teeth[14];
    for (int a = 0; a < 14; a++) {
        const double angle = 3.141592653589793 * (0.15 + 0.70 * a / 13);
        teeth[a] = ellipsoid_of(0.30 * cos(angle), 0.34 + 0.30 * sin(angle), -0.48, 0.026, 0.026, 0.065);
    }
    float *out = v->slice;
    for (int j = 0; j < v->n; j++) {
        for (int i = 0; i < v->n; i++, out++) {
            const float x = v->c[i], y = v->c[j], z = v->c[k];
            const float skin = ellipsoid_at(&skin_shape, x, y, z) + 0.012f * (t->sin9x[i] * t->sin8y[j] * t->sin7z[k]);
            float value = 4.0f;
            over(&value, skin, t->h, 100.0f);
            over(&value, skin + 0.035f, t->h, 62.0f);
            value = skull_and_brain(v, t, i, j, k, value);
            value = spine(v, t, i, j, k, value);
            *out = teeth_and_eyes(t, teeth, eyes, x, y, z, value);
        }
    }
}

static void head_end(volume *v)
{
    head_tables *t = v->extra;
    if (t)
        free(t->store);
    free(t);
}

/* Marschner-Lobb ------------------------------------------------------------------------------------------------ */

static void ml_fill(volume *v, int k)
{
    const float half_pi = (float)(3.141592653589793 / 2), wave = (float)(2 * 3.141592653589793 * 6.0);
    const float base = 1.0f - sinf(half_pi * v->c[k]);
    for (int j = 0; j < v->n; j++) {
        for (int i = 0; i < v->n; i++) {
            const float r = sqrtf(v->c[i] * v->c[i] + v->c[j] * v->c[j]);
            const float rho = cosf(wave * cosf(half_pi * r));
            const float f = (base + 0.25f * (1.0f + rho)) / (float)(2 * (1 + 0.25));
            v->slice[(size_t)j * (size_t)v->n + (size_t)i] = 255.0f * f;
        }
    }
}

/* Neuron -------------------------------------------------------------------------------------------------------- */

typedef struct tube {
    double a[3], b[3], radius, peak;
} tube;

enum { MAX_TUBES = 2048 };

typedef struct tree {
    tube tubes[MAX_TUBES], beads[MAX_TUBES];
    int n_tubes, n_beads;
    uint32_t state;
} tree;

static double tree_random(tree *t)
{
    t->state = (uint32_t)(((uint64_t)t->state * 1103515245u + 12345u) & 0x7fffffffu);
    return t->state / (double)0x7fffffff;
}

static void unit(double d[3])
{
    const double m = pow(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], 0.5);
    for (int i = 0; i < 3; i++)
        d[i] /= m;
}

static void add_bead(tree *t, const double p[3], double radius, double peak)
{
    if (t->n_beads < MAX_TUBES)
        t->beads[t->n_beads++] = (tube){{p[0], p[1], p[2]}, {p[0], p[1], p[2]}, radius, peak};
}

static void grow(tree *t, const double from[3], const double towards[3], double length, double radius, int generation)
{
    double p[3] = {from[0], from[1], from[2]}, d[3] = {towards[0], towards[1], towards[2]};
    for (int piece = 0; piece < 5; piece++) {
        for (int i = 0; i < 3; i++)
            d[i] += 0.45 * (tree_random(t) - 0.5);
        unit(d);
        double q[3];
        for (int i = 0; i < 3; i++)
            q[i] = fmax(-0.95, fmin(0.95, p[i] + d[i] * length / 5));
        const double peak = 150 + 60 * tree_random(t);
        if (t->n_tubes < MAX_TUBES)
            t->tubes[t->n_tubes++] = (tube){{p[0], p[1], p[2]}, {q[0], q[1], q[2]}, radius, peak};
        memcpy(p, q, sizeof p);
        if (tree_random(t) < 0.25)
            add_bead(t, p, radius * 2.2, 220);
    }
    for (int s = 1; generation && s >= -1; s -= 2) {
        double turned[3];
        for (int i = 0; i < 3; i++)
            turned[i] = d[i] + s * 0.9 * (tree_random(t) - 0.2) * (i == generation % 3 ? 1 : 0.35);
        unit(turned);
        grow(t, p, turned, length * 0.78, radius * 0.8, generation - 1);
    }
}

static bool neuron_begin(volume *v)
{
    static const double somata[2][3] = {{-0.1, -0.15, -0.1}, {0.25, 0.3, 0.2}};
    tree *t = calloc(1, sizeof *t);
    if (!t)
        return false;
    v->extra = t;
    t->state = 12345;
    for (int s = 0; s < 2; s++) {
        add_bead(t, somata[s], 0.10, 240);
        for (int k = 0; k < 3; k++) {
            const double a = 2.1 * k + somata[s][0] * 7, d[3] = {cos(a), sin(a), 0.7 * (k - 1)};
            grow(t, somata[s], d, 0.42, 0.016, 4);
        }
    }
    return true;
}

/* The largest of all tubes' Gaussians, in slice k, within three radii of the tube. */
static void draw_tube(volume *v, int k, const tube *s)
{
    const double reach = 3 * s->radius;
    int lo[3], hi[3];
    for (int a = 0; a < 3; a++) {
        lo[a] = (int)fmax(0, floor((fmin(s->a[a], s->b[a]) - reach + 1) * (v->n - 1) / 2));
        hi[a] = (int)fmin(v->n, ceil((fmax(s->a[a], s->b[a]) + reach + 1) * (v->n - 1) / 2) + 1);
    }
    if (k < lo[2] || k >= hi[2])
        return;
    const double dx = s->b[0] - s->a[0], dy = s->b[1] - s->a[1], dz = s->b[2] - s->a[2];
    const double length2 = dx * dx + dy * dy + dz * dz;
    const float width = (float)(2 * (s->radius * 0.6) * (s->radius * 0.6)), z = v->c[k] - (float)s->a[2];
    const float over_length2 = (float)fmax(length2, 1e-12);
    for (int j = lo[1]; j < hi[1]; j++) {
        for (int i = lo[0]; i < hi[0]; i++) {
            const float x = v->c[i] - (float)s->a[0], y = v->c[j] - (float)s->a[1];
            float t = (x * (float)dx + y * (float)dy + z * (float)dz) / over_length2;
            t = t < 0 ? 0 : t > 1 ? 1 : t;
            const float px = x - t * (float)dx, py = y - t * (float)dy, pz = z - t * (float)dz;
            const float g = (float)s->peak * expf(-(px * px + py * py + pz * pz) / width);
            float *out = &v->slice[(size_t)j * (size_t)v->n + (size_t)i];
            *out = g > *out ? g : *out;
        }
    }
}

static void neuron_fill(volume *v, int k)
{
    const tree *t = v->extra;
    memset(v->slice, 0, (size_t)v->n * (size_t)v->n * sizeof *v->slice);
    for (int i = 0; i < t->n_tubes; i++)
        draw_tube(v, k, &t->tubes[i]);
    for (int i = 0; i < t->n_beads; i++)
        draw_tube(v, k, &t->beads[i]);
}

static void neuron_end(volume *v)
{
    free(v->extra);
}

/* Uniform bytes ------------------------------------------------------------------------------------------------- */

static void noise_fill(volume *v, int k)
{
    const uint32_t first = (uint32_t)((uint64_t)k * (uint64_t)v->n * (uint64_t)v->n);
    for (uint32_t i = 0; i < (uint32_t)v->n * (uint32_t)v->n; i++)
        v->slice[i] = (float)(mix32(first + i + 77u) >> 24);
}

/* Writing ------------------------------------------------------------------------------------------------------- */

static const kind kinds[] = {
    {"head", head_begin, head_fill, head_end, 3.0f, 1},
    {"ml", NULL, ml_fill, NULL, 0.0f, 0},
    {"neuron", neuron_begin, neuron_fill, neuron_end, 1.5f, 2},
    {"noise", NULL, noise_fill, NULL, 0.0f, 0},
};

/* Noise, the neuron's grey background, and the limits of the scale. */
static void finish_slice(volume *v, const kind *what, int k)
{
    const size_t n2 = (size_t)v->n * (size_t)v->n;
    const float scale = (float)((double)what->sigma / 147.8), floor_value = what->seed == 2 ? 5.0f : 0.0f;
    for (size_t i = 0; i < n2; i++) {
        float value = v->slice[i];
        if (what->seed)
            value = value + noise_at((uint32_t)((size_t)k * n2 + i), scale, what->seed) + floor_value;
        v->slice[i] = value < 0 ? 0 : value > 255 ? 255 : value;
    }
}

static bool write_slice(FILE *out, const volume *v, uint8_t *bytes, bool as_float, uint32_t *crc)
{
    const size_t n2 = (size_t)v->n * (size_t)v->n;
    const void *data = v->slice;
    size_t n_bytes = n2 * sizeof *v->slice;
    if (!as_float) {
        for (size_t i = 0; i < n2; i++)
            bytes[i] = (uint8_t)floorf(v->slice[i] + 0.5f);
        data = bytes;
        n_bytes = n2;
    }
    *crc = (uint32_t)crc32(*crc, data, (uInt)n_bytes);
    return fwrite(data, 1, n_bytes, out) == n_bytes;
}

static bool write_volume(FILE *out, volume *v, const kind *what, bool as_float)
{
    const size_t n2 = (size_t)v->n * (size_t)v->n;
    uint8_t *bytes = malloc(n2);
    bool good = bytes != NULL && (!what->begin || what->begin(v));
    uint32_t crc = (uint32_t)crc32(0, NULL, 0);
    fprintf(out, "NRRD0004\ntype: %s\ndimension: 3\nsizes: %d %d %d\nspacings: 1 1 1\n%sencoding: raw\n\n",
            as_float ? "float" : "uint8", v->n, v->n, v->n, as_float ? "endian: little\n" : "");
    for (int k = 0; good && k < v->n; k++) {
        what->fill(v, k);
        finish_slice(v, what, k);
        good = write_slice(out, v, bytes, as_float, &crc);
    }
    if (what->end)
        what->end(v);
    free(bytes);
    if (good)
        printf("%s_%d_%s crc32 %08x\n", what->name, v->n, as_float ? "f32" : "u8", crc);
    return good;
}

static int make(const kind *what, int n, bool as_float, const char *path)
{
    volume v = {.n = n};
    v.c = malloc((size_t)n * sizeof *v.c);
    v.slice = malloc((size_t)n * (size_t)n * sizeof *v.slice);
    FILE *out = fopen(path, "wb");
    bool good = v.c && v.slice && out;
    if (good) {
        const float step = (float)(2.0 / (n - 1));
        for (int i = 0; i < n; i++)
            v.c[i] = (float)i * step - 1.0f;
        good = write_volume(out, &v, what, as_float);
    }
    if (out && fclose(out) != 0)
        good = false;
    free(v.c);
    free(v.slice);
    if (!good) {
        perror(path);
        remove(path);
    }
    return good ? 0 : 1;
}

int main(int argc, char **argv)
{
    const long n = argc == 5 ? strtol(argv[2], NULL, 10) : 0;
    if (n < 2 || n > 2048) {
        fprintf(stderr, "usage: volumes head|ml|neuron|noise N u8|f32 FILE.nrrd     (N from 2 to 2048)\n");
        return 2;
    }
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(kinds[i].name, argv[1]) == 0)
            return make(&kinds[i], (int)n, strcmp(argv[3], "f32") == 0, argv[4]);
    fprintf(stderr, "volumes: there is no kind '%s'; there are head, ml, neuron and noise\n", argv[1]);
    return 2;
}
