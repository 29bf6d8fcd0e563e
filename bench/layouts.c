/* Which layout of 8-bit samples, and which way to gradients, is the fastest for packets of neighbouring rays; what
 * docs/decisions/0008-layout-and-gradients.md rests on.
 *
 *   layouts_avx512 [--quick] [N ...]      (or layouts_avx2) one JSON line a result, of volumes of N^3: 256 and 512;
 *                                         --quick: 256 and one thread; bench/layouts makes a table
 *
 * Values are trilinear, from the lattice as it lies in the file, from a copy with rows and slices a little further
 * apart, or from a copy in bricks of 8^3 or 16^3 cells, each with the samples of its upper faces (an apron of one).
 * Gradients come with the value: central differences interpolated between samples, the derivative of the trilinear
 * cell, or a field of words made beforehand, a sample's value and central differences in 4 x 16 bits. Bricks for
 * central differences have one more sample on every side.
 *
 * Rates are sums over the threads of samples by CPU time, the best of five runs; the ways take turns, so that a
 * neighbour's work falls on all of them alike, and none finds its samples in a cache that the others left alone.
 * Every way is compared with double precision before anything is timed.
 */
#include "layouts_ways.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#if VV_WIDTH == 16
enum { PACKET_W = 4, PACKET_H = 4 };
#else
enum { PACKET_W = 4, PACKET_H = VV_WIDTH / 4 };
#endif
enum { RUNS = 5, MAX_THREADS = 2, TILE = 32, PICTURE = 192, MARGIN = 2 };

static double cpu_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Rays ------------------------------------------------------------------------------------------------------------ */

/* Parallel rays: each lane's own origin, one direction, the steps of one voxel that all of them can take. */
typedef struct packet {
    float origin[3][VV_WIDTH], dir[3];
    int steps;
} packet;

VV_INLINE vf3 packet_point(const packet *p, int step)
{
    const vf t = vf_set1((float)step);
    return vf3_set(vf_fma(t, vf_set1(p->dir[0]), vf_load(p->origin[0])),
                   vf_fma(t, vf_set1(p->dir[1]), vf_load(p->origin[1])),
                   vf_fma(t, vf_set1(p->dir[2]), vf_load(p->origin[2])));
}

VV_INLINE float march(const volume *v, const packet *p, way w)
{
    vf sum = vf_set1(0.0f);
    for (int step = 0; step < p->steps; step++) {
        const sample s = take_sample(v, w, packet_point(p, step));
        sum = sum + s.value + s.gradient.x + s.gradient.y + s.gradient.z;
    }
    float lanes[VV_WIDTH], total = 0;
    vf_store(lanes, sum);
    for (int l = 0; l < VV_WIDTH; l++)
        total += lanes[l];
    return total;
}

/* The same sample out of line, for the comparison. */
static void store_sample(float out[4][VV_WIDTH], const sample *s)
{
    vf_store(out[0], s->value);
    vf_store(out[1], s->gradient.x);
    vf_store(out[2], s->gradient.y);
    vf_store(out[3], s->gradient.z);
}

typedef struct way_functions {
    float (*march)(const volume *v, const packet *p);
    void (*sample)(float out[4][VV_WIDTH], const volume *v, const packet *p, int step);
} way_functions;

#define WAY(w)                                                                                                         \
    static float march_##w(const volume *v, const packet *p)                                                           \
    {                                                                                                                  \
        return march(v, p, w);                                                                                         \
    }                                                                                                                  \
    static void sample_##w(float out[4][VV_WIDTH], const volume *v, const packet *p, int step)                         \
    {                                                                                                                  \
        const sample s = take_sample(v, w, packet_point(p, step));                                                     \
        store_sample(out, &s);                                                                                         \
    }
WAY(VALUE_LINEAR)
WAY(VALUE_PADDED)
WAY(VALUE_BRICKS_8)
WAY(VALUE_BRICKS_16)
WAY(GRADIENT_CENTRAL)
WAY(GRADIENT_PADDED)
WAY(GRADIENT_BRICKS)
WAY(GRADIENT_CELL)
WAY(BOTH_CENTRAL)
WAY(BOTH_CELL)
WAY(BOTH_WORDS)
#define ROW(w) [w] = {march_##w, sample_##w}
static const way_functions ways[WAYS] = {ROW(VALUE_LINEAR),    ROW(VALUE_PADDED),     ROW(VALUE_BRICKS_8),
                                         ROW(VALUE_BRICKS_16), ROW(GRADIENT_CENTRAL), ROW(GRADIENT_PADDED),
                                         ROW(GRADIENT_BRICKS), ROW(GRADIENT_CELL),    ROW(BOTH_CENTRAL),
                                         ROW(BOTH_CELL),       ROW(BOTH_WORDS)};

/* Moves the origins to where the last ray has entered the grid less its margin, and counts steps until the first
 * leaves it. */
static void clip_packet(packet *p, int n)
{
    const float lo = MARGIN, hi = (float)(n - 1 - MARGIN) - 0.01f;
    float t0 = -INFINITY, t1 = INFINITY;
    for (int a = 0; a < 3; a++)
        for (int l = 0; l < VV_WIDTH && fabsf(p->dir[a]) > 1e-6f; l++) {
            const float u = (lo - p->origin[a][l]) / p->dir[a], v = (hi - p->origin[a][l]) / p->dir[a];
            t0 = fmaxf(t0, fminf(u, v));
            t1 = fminf(t1, fmaxf(u, v));
        }
    p->steps = t1 > t0 ? (int)(t1 - t0) : 0;
    for (int a = 0; a < 3; a++)
        for (int l = 0; l < VV_WIDTH; l++)
            p->origin[a][l] += t0 * p->dir[a];
}

enum { TILE_PACKETS = TILE / PACKET_W * (TILE / PACKET_H), TILES = PICTURE / TILE * (PICTURE / TILE) };

/* The middle of a picture, in tiles as the ray caster takes them; `dir` has length 1. */
static void make_packets(packet *packets, int n, const float dir[3], float pitch)
{
    const bool along_z = fabsf(dir[2]) > 0.9f;
    const float across[3] = {along_z ? 1 : -dir[1], along_z ? 0 : dir[0], 0};
    const float length = hypotf(across[0], across[1]), e1[3] = {across[0] / length, across[1] / length, 0};
    const float e2[3] = {dir[1] * e1[2] - dir[2] * e1[1], dir[2] * e1[0] - dir[0] * e1[2],
                         dir[0] * e1[1] - dir[1] * e1[0]};
    for (int i = 0; i < TILES * TILE_PACKETS; i++) {
        const int tile = i / TILE_PACKETS, in_tile = i % TILE_PACKETS, per_row = TILE / PACKET_W;
        const int x = tile % (PICTURE / TILE) * TILE + in_tile % per_row * PACKET_W;
        const int y = tile / (PICTURE / TILE) * TILE + in_tile / per_row * PACKET_H;
        packet *p = &packets[i];
        *p = (packet){.dir = {dir[0], dir[1], dir[2]}};
        for (int l = 0; l < VV_WIDTH; l++) {
            const int column = x + l % PACKET_W - PICTURE / 2, row = y + l / PACKET_W - PICTURE / 2;
            const float u = ((float)column + 0.5f) * pitch, v = ((float)row + 0.5f) * pitch;
            for (int a = 0; a < 3; a++)
                p->origin[a][l] = 0.5f * (float)(n - 1) + u * e1[a] + v * e2[a];
        }
        clip_packet(p, n);
    }
}

/* Against double precision ---------------------------------------------------------------------------------------- */

static double stored(const vvi_lattice *g, int32_t i, int32_t j, int32_t k)
{
    return ((const uint8_t *)g->data)[k * g->slice + j * g->row + i];
}

/* Trilinear at p: of the samples (axis < 0), or of their central differences along an axis, inside the grid. */
static double trilinear(const vvi_lattice *g, const double p[3], int axis)
{
    const int32_t i = (int32_t)p[0], j = (int32_t)p[1], k = (int32_t)p[2];
    const int32_t di = axis == 0, dj = axis == 1, dk = axis == 2;
    double sum = 0;
    for (int corner = 0; corner < 8; corner++) {
        const int32_t x = i + (corner & 1), y = j + (corner >> 1 & 1), z = k + (corner >> 2);
        const double weight = (1 - fabs(p[0] - x)) * (1 - fabs(p[1] - y)) * (1 - fabs(p[2] - z));
        sum += weight * (axis < 0 ? stored(g, x, y, z)
                                  : 0.5 * (stored(g, x + di, y + dj, z + dk) - stored(g, x - di, y - dj, z - dk)));
    }
    return sum;
}

/* The trilinear field is linear along an axis within a cell: the difference over the cell is its derivative there. */
static double cell_derivative(const vvi_lattice *g, const double p[3], int axis)
{
    double low[3] = {p[0], p[1], p[2]}, high[3] = {p[0], p[1], p[2]};
    low[axis] = floor(p[axis]);
    high[axis] = low[axis] + 1;
    return trilinear(g, high, -1) - trilinear(g, low, -1);
}

static double way_error(const volume *v, way w, const packet *p, int step)
{
    float got[4][VV_WIDTH], at[3][VV_WIDTH];
    const vf3 point = packet_point(p, step);
    ways[w].sample(got, v, p, step);
    vf_store(at[0], point.x);
    vf_store(at[1], point.y);
    vf_store(at[2], point.z);
    double worst = 0;
    for (int l = 0; l < VV_WIDTH; l++) {
        const double place[3] = {at[0][l], at[1][l], at[2][l]};
        if (w < GRADIENT_CENTRAL || w > GRADIENT_CELL)
            worst = fmax(worst, fabs(got[0][l] - trilinear(&v->lattice, place, -1)));
        for (int a = 0; a < 3 && w >= GRADIENT_CENTRAL; a++) {
            const double want = w == BOTH_CELL || w == GRADIENT_CELL ? cell_derivative(&v->lattice, place, a)
                                                                     : trilinear(&v->lattice, place, a);
            worst = fmax(worst, fabs(got[a + 1][l] - want));
        }
    }
    return worst;
}

/* Fractions along x count in 1/16384, values to 255: 0.01 of a value is rounding, a wrong neighbour is not. */
static void check_ways(const volume *v, const packet *packets)
{
    for (way w = 0; w < WAYS; w++) {
        double worst = 0;
        for (int i = 0; i < TILES * TILE_PACKETS; i += 37)
            for (int step = i % 5; step < packets[i].steps; step += 5)
                worst = fmax(worst, way_error(v, w, &packets[i], step));
        if (worst > 0.02) {
            fprintf(stderr, "layouts: %s is off by %g\n", way_name[w], worst);
            exit(1);
        }
    }
}

/* Timing ---------------------------------------------------------------------------------------------------------- */

typedef struct share {
    const volume *volume;
    const packet *packets;
    float (*march)(const volume *v, const packet *p);
    int index, count;
    double rate, sum; /* out: samples a second of CPU time; the sum keeps the work alive */
} share;

static void *run_share(void *user)
{
    share *s = user;
    double samples = 0;
    const double start = cpu_s();
    for (int i = 0; i < TILES * TILE_PACKETS; i++) {
        if (i / TILE_PACKETS % s->count != s->index)
            continue;
        s->sum += (double)s->march(s->volume, &s->packets[i]);
        samples += (double)s->packets[i].steps * VV_WIDTH;
    }
    s->rate = samples / (cpu_s() - start);
    return NULL;
}

static double run_once(const volume *v, const packet *packets, way w, int threads, double *sum_out)
{
    pthread_t ids[MAX_THREADS];
    share shares[MAX_THREADS];
    double rate = 0;
    for (int i = 0; i < threads; i++) {
        shares[i] = (share){v, packets, ways[w].march, i, threads, 0, 0};
        if (pthread_create(&ids[i], NULL, run_share, &shares[i]) != 0)
            exit(1);
    }
    *sum_out = 0;
    for (int i = 0; i < threads; i++) {
        pthread_join(ids[i], NULL);
        rate += shares[i].rate;
        *sum_out += shares[i].sum;
    }
    return rate;
}

typedef struct view {
    const char *name;
    float dir[3];
} view;

static void measure_view(const volume *v, packet *packets, const view *along, float pitch, int max_threads)
{
    make_packets(packets, v->lattice.n[0], along->dir, pitch);
    check_ways(v, packets);
    for (int threads = 1; threads <= max_threads; threads++) {
        double best[WAYS] = {0}, sum[WAYS];
        for (int run = 0; run < RUNS; run++)
            for (way w = 0; w < WAYS; w++)
                best[w] = fmax(best[w], run_once(v, packets, w, threads, &sum[w]));
        for (way w = 0; w < WAYS; w++)
            printf("{\"name\": \"%s\", \"isa\": \"%s\", \"n\": %d, \"view\": \"%s\", \"pitch\": %g, \"threads\": %d, "
                   "\"unit\": \"Msamples/s of CPU time\", \"best\": %.4g, \"runs\": %d, \"checksum\": %.7g}\n",
                   way_name[w], VV_ISA_NAME, v->lattice.n[0], along->name, (double)pitch, threads, best[w] * 1e-6, RUNS,
                   sum[w]);
        fflush(stdout);
    }
}

static void print_copy(const char *name, int n, double seconds, size_t bytes)
{
    printf("{\"name\": \"make_%s\", \"isa\": \"%s\", \"n\": %d, \"threads\": 1, \"unit\": \"s of CPU time\", "
           "\"time\": %.4g, \"bytes\": %zu}\n",
           name, VV_ISA_NAME, n, seconds, bytes);
    fflush(stdout);
}

/* Times hold the first touch of the memory, as they would in a renderer. */
static void make_copies(volume *v)
{
    const int n = v->lattice.n[0];
    const double t0 = cpu_s();
    v->small = make_bricks(&v->lattice, &small_shape);
    const double t1 = cpu_s();
    v->large = make_bricks(&v->lattice, &large_shape);
    const double t2 = cpu_s();
    v->wide = make_bricks(&v->lattice, &wide_shape);
    const double t3 = cpu_s();
    v->words = make_words(&v->lattice);
    const double t4 = cpu_s();
    print_copy("bricks_8", n, t1 - t0, v->small.bytes);
    print_copy("bricks_16", n, t2 - t1, v->large.bytes);
    print_copy("bricks_16_wide", n, t3 - t2, v->wide.bytes);
    const double t5 = cpu_s();
    v->padded = make_padded(&v->lattice);
    print_copy("padded", n, cpu_s() - t5, (size_t)(v->padded.slice * n));
    print_copy("words", n, t4 - t3, words_bytes(n));
}

static void measure_size(int n, int max_threads)
{
    static const view views[] = {{"x", {1, 0, 0}}, {"z", {0, 0, 1}}, {"oblique", {0.48f, 0.60f, 0.64f}}};
    static const float pitches[] = {0.3f, 0.6f};
    uint8_t *data = make_samples(n);
    packet *packets = take_memory(TILES * TILE_PACKETS * sizeof *packets);
    volume v = {.lattice = {data, VVI_SAMPLE_U8, {n, n, n}, n, (int64_t)n * n, false}};
    make_copies(&v);
    for (size_t i = 0; i < sizeof views / sizeof *views; i++)
        for (size_t j = 0; j < sizeof pitches / sizeof *pitches; j++)
            measure_view(&v, packets, &views[i], pitches[j], max_threads);
    free((void *)v.padded.data);
    free(v.words);
    free(v.wide.data);
    free(v.large.data);
    free(v.small.data);
    free(packets);
    free(data);
}

int main(int argc, char **argv)
{
    const bool quick = argc > 1 && strcmp(argv[1], "--quick") == 0;
    const int first = quick ? 2 : 1, max_threads = quick ? 1 : MAX_THREADS;
    for (int i = first; i < argc; i++)
        if (atoi(argv[i]) < 128 || atoi(argv[i]) > 640) {
            fprintf(stderr, "usage: layouts_%s [--quick] [N ...]    N from 128 to 640\n", VV_ISA_NAME);
            return 2;
        }
    for (int i = first; i < argc; i++)
        measure_size(atoi(argv[i]), max_threads);
    if (argc == first)
        measure_size(256, max_threads);
    if (argc == first && !quick)
        measure_size(512, max_threads);
    return 0;
}
