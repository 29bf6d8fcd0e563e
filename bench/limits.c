/* What this machine can do at most, for the benchmarks to be measured against: memory bandwidth, and trilinear
 * interpolations of 8-bit voxels a second, scalar and in the shape of the fastest kernels (a packet of neighbouring
 * rays that advance together, four 32-bit gathers a sample).
 *
 *   limits [--quick]      one JSON line a result
 *
 * Rays cover the whole volume, one every second voxel, and take a sample every voxel; packets are 4 x 4 rays. "x",
 * "z" and "oblique" are their directions; along z every sample of a ray is on another memory page.
 */
#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

enum { MAX_THREADS = 64, PACKET = 16, RUNS = 7 };

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Work on several threads at once ------------------------------------------------------------------------------- */

/* One thread's share: part `index` of `count`; the result keeps the compiler from dropping the work. */
typedef struct part {
    void (*run)(struct part *part);
    const void *task;
    int index, count;
    double result;
} part;

static void *run_part(void *user)
{
    part *p = user;
    p->run(p);
    return NULL;
}

/* Seconds that `threads` threads took; *sum_out: their results together. */
static double run_threads(void (*run)(part *), const void *task, int threads, double *sum_out)
{
    pthread_t ids[MAX_THREADS];
    part parts[MAX_THREADS];
    const double start = now_s();
    for (int i = 0; i < threads; i++) {
        parts[i] = (part){run, task, i, threads, 0};
        if (i > 0 && pthread_create(&ids[i], NULL, run_part, &parts[i]) != 0)
            exit(1);
    }
    run_part(&parts[0]);
    for (int i = 1; i < threads; i++)
        pthread_join(ids[i], NULL);
    const double seconds = now_s() - start;
    *sum_out = 0;
    for (int i = 0; i < threads; i++)
        *sum_out += parts[i].result;
    return seconds;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* One warm-up, then RUNS runs; amount / seconds of the median, the slowest and the fastest tenth. */
static void measure(const char *name, const char *isa, int threads, void (*run)(part *), const void *task,
                    double amount, const char *unit)
{
    double seconds[RUNS], sum = 0;
    run_threads(run, task, threads, &sum);
    for (int i = 0; i < RUNS; i++)
        seconds[i] = run_threads(run, task, threads, &sum);
    qsort(seconds, RUNS, sizeof *seconds, by_value);
    printf("{\"name\": \"%s\", \"isa\": \"%s\", \"threads\": %d, \"unit\": \"%s\", \"median\": %.4g, \"p10\": %.4g, "
           "\"p90\": %.4g, \"runs\": %d, \"checksum\": %.9g}\n",
           name, isa, threads, unit, amount / seconds[RUNS / 2], amount / seconds[RUNS - 1], amount / seconds[0], RUNS,
           sum);
    fflush(stdout);
}

/* Memory -------------------------------------------------------------------------------------------------------- */

typedef struct memory_task {
    uint64_t *from, *to;
    size_t n;
} memory_task;

static void read_memory(part *p)
{
    const memory_task *t = p->task;
    const size_t first = t->n * (size_t)p->index / (size_t)p->count,
                 end = t->n * (size_t)(p->index + 1) / (size_t)p->count;
    uint64_t sum[8] = {0};
    for (size_t i = first; i + 8 <= end; i += 8)
        for (size_t j = 0; j < 8; j++)
            sum[j] += t->from[i + j];
    for (size_t j = 0; j < 8; j++)
        p->result += (double)sum[j];
}

static void copy_memory(part *p)
{
    const memory_task *t = p->task;
    const size_t first = t->n * (size_t)p->index / (size_t)p->count,
                 end = t->n * (size_t)(p->index + 1) / (size_t)p->count;
    memcpy(t->to + first, t->from + first, (end - first) * sizeof *t->to);
    p->result = (double)t->to[first];
}

static void measure_memory(int threads, size_t bytes)
{
    memory_task t = {.n = bytes / sizeof(uint64_t)};
    t.from = malloc(bytes);
    t.to = malloc(bytes);
    if (!t.from || !t.to)
        exit(1);
    memset(t.from, 1, bytes);
    memset(t.to, 2, bytes);
    measure("memory_read", "", threads, read_memory, &t, (double)bytes * 1e-9, "GB/s");
    measure("memory_copy", "", threads, copy_memory, &t, 2 * (double)bytes * 1e-9, "GB/s");
    free(t.from);
    free(t.to);
}

/* Trilinear samples --------------------------------------------------------------------------------------------- */

/* A packet of rays inside the grid: origins, one direction, how many steps of one voxel all of them can take. */
typedef struct packet {
    float ox[PACKET], oy[PACKET], oz[PACKET], d[3];
    int steps;
} packet;

typedef struct sample_task {
    const uint8_t *voxels;
    int n;
    packet *packets;
    size_t n_packets;
    float (*march)(const uint8_t *voxels, int n, const packet *p);
} sample_task;

static void march_all(part *p)
{
    const sample_task *t = p->task;
    for (size_t i = (size_t)p->index; i < t->n_packets; i += (size_t)p->count)
        p->result += (double)t->march(t->voxels, t->n, &t->packets[i]);
}

static inline float lerp(float a, float b, float t)
{
    return a + t * (b - a);
}

static float march_scalar(const uint8_t *voxels, int n, const packet *p)
{
    const ptrdiff_t row = n, slice = (ptrdiff_t)n * n;
    float sum = 0;
    for (int s = 0; s < p->steps; s++) {
        for (int r = 0; r < PACKET; r++) {
            const float t = (float)s;
            const float x = p->ox[r] + t * p->d[0], y = p->oy[r] + t * p->d[1], z = p->oz[r] + t * p->d[2];
            const int i = (int)x, j = (int)y, k = (int)z;
            const float fx = x - (float)i, fy = y - (float)j, fz = z - (float)k;
            const uint8_t *v = voxels + k * slice + j * row + i;
            const float a = lerp(v[0], v[1], fx), b = lerp(v[row], v[row + 1], fx);
            const float c = lerp(v[slice], v[slice + 1], fx), d = lerp(v[slice + row], v[slice + row + 1], fx);
            sum += lerp(lerp(a, b, fy), lerp(c, d, fy), fz);
        }
    }
    return sum;
}

#if defined(__x86_64__)
/* One gather of 32 bits holds v[x] and v[x + 1]: interpolated along x from its two lowest bytes. */
__attribute__((target("avx2,fma"))) static inline __m256 edge_avx2(const uint8_t *v, __m256i at, __m256 fx)
{
    const __m256i pair = _mm256_i32gather_epi32((const int *)(const void *)v, at, 1), byte = _mm256_set1_epi32(255);
    const __m256 a = _mm256_cvtepi32_ps(_mm256_and_si256(pair, byte));
    const __m256 b = _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srli_epi32(pair, 8), byte));
    return _mm256_fmadd_ps(fx, _mm256_sub_ps(b, a), a);
}

__attribute__((target("avx2,fma"))) static inline __m256 sample_avx2(const uint8_t *v, int n, __m256 x, __m256 y,
                                                                     __m256 z)
{
    const __m256i i = _mm256_cvttps_epi32(x), j = _mm256_cvttps_epi32(y), k = _mm256_cvttps_epi32(z);
    const __m256 fx = _mm256_sub_ps(x, _mm256_cvtepi32_ps(i)), fy = _mm256_sub_ps(y, _mm256_cvtepi32_ps(j));
    const __m256 fz = _mm256_sub_ps(z, _mm256_cvtepi32_ps(k));
    const __m256i line = _mm256_add_epi32(_mm256_mullo_epi32(k, _mm256_set1_epi32(n)), j);
    const __m256i at = _mm256_add_epi32(_mm256_mullo_epi32(line, _mm256_set1_epi32(n)), i);
    const uint8_t *above = v + (ptrdiff_t)n * n;
    const __m256 a = edge_avx2(v, at, fx), b = edge_avx2(v + n, at, fx);
    const __m256 c = edge_avx2(above, at, fx), d = edge_avx2(above + n, at, fx);
    const __m256 low = _mm256_fmadd_ps(fy, _mm256_sub_ps(b, a), a), high = _mm256_fmadd_ps(fy, _mm256_sub_ps(d, c), c);
    return _mm256_fmadd_ps(fz, _mm256_sub_ps(high, low), low);
}

__attribute__((target("avx2,fma"))) static float march_avx2(const uint8_t *voxels, int n, const packet *p)
{
    const __m256 dx = _mm256_set1_ps(p->d[0]), dy = _mm256_set1_ps(p->d[1]), dz = _mm256_set1_ps(p->d[2]);
    __m256 sum = _mm256_setzero_ps();
    for (int s = 0; s < p->steps; s++) {
        const __m256 t = _mm256_set1_ps((float)s);
        for (int r = 0; r < PACKET; r += 8) {
            const __m256 x = _mm256_fmadd_ps(t, dx, _mm256_loadu_ps(p->ox + r));
            const __m256 y = _mm256_fmadd_ps(t, dy, _mm256_loadu_ps(p->oy + r));
            const __m256 z = _mm256_fmadd_ps(t, dz, _mm256_loadu_ps(p->oz + r));
            sum = _mm256_add_ps(sum, sample_avx2(voxels, n, x, y, z));
        }
    }
    float lanes[8], total = 0;
    _mm256_storeu_ps(lanes, sum);
    for (int i = 0; i < 8; i++)
        total += lanes[i];
    return total;
}

__attribute__((target("avx512f"))) static inline __m512 edge_avx512(const uint8_t *v, __m512i at, __m512 fx)
{
    const __m512i pair = _mm512_i32gather_epi32(at, v, 1), byte = _mm512_set1_epi32(255);
    const __m512 a = _mm512_cvtepi32_ps(_mm512_and_si512(pair, byte));
    const __m512 b = _mm512_cvtepi32_ps(_mm512_and_si512(_mm512_srli_epi32(pair, 8), byte));
    return _mm512_fmadd_ps(fx, _mm512_sub_ps(b, a), a);
}

__attribute__((target("avx512f"))) static inline __m512 sample_avx512(const uint8_t *v, int n, __m512 x, __m512 y,
                                                                      __m512 z)
{
    const __m512i i = _mm512_cvttps_epi32(x), j = _mm512_cvttps_epi32(y), k = _mm512_cvttps_epi32(z);
    const __m512 fx = _mm512_sub_ps(x, _mm512_cvtepi32_ps(i)), fy = _mm512_sub_ps(y, _mm512_cvtepi32_ps(j));
    const __m512 fz = _mm512_sub_ps(z, _mm512_cvtepi32_ps(k));
    const __m512i line = _mm512_add_epi32(_mm512_mullo_epi32(k, _mm512_set1_epi32(n)), j);
    const __m512i at = _mm512_add_epi32(_mm512_mullo_epi32(line, _mm512_set1_epi32(n)), i);
    const uint8_t *above = v + (ptrdiff_t)n * n;
    const __m512 a = edge_avx512(v, at, fx), b = edge_avx512(v + n, at, fx);
    const __m512 c = edge_avx512(above, at, fx), d = edge_avx512(above + n, at, fx);
    const __m512 low = _mm512_fmadd_ps(fy, _mm512_sub_ps(b, a), a), high = _mm512_fmadd_ps(fy, _mm512_sub_ps(d, c), c);
    return _mm512_fmadd_ps(fz, _mm512_sub_ps(high, low), low);
}

__attribute__((target("avx512f"))) static float march_avx512(const uint8_t *voxels, int n, const packet *p)
{
    const __m512 ox = _mm512_loadu_ps(p->ox), oy = _mm512_loadu_ps(p->oy), oz = _mm512_loadu_ps(p->oz);
    __m512 sum = _mm512_setzero_ps();
    for (int s = 0; s < p->steps; s++) {
        const __m512 t = _mm512_set1_ps((float)s);
        const __m512 x = _mm512_fmadd_ps(t, _mm512_set1_ps(p->d[0]), ox);
        const __m512 y = _mm512_fmadd_ps(t, _mm512_set1_ps(p->d[1]), oy);
        const __m512 z = _mm512_fmadd_ps(t, _mm512_set1_ps(p->d[2]), oz);
        sum = _mm512_add_ps(sum, sample_avx512(voxels, n, x, y, z));
    }
    return _mm512_reduce_add_ps(sum);
}
#endif

/* Rays ---------------------------------------------------------------------------------------------------------- */

/* Where a packet enters and leaves the cube [0, n - 1)^3: the narrowest of its rays' intervals. */
static void clip(const packet *p, int n, float *t0, float *t1)
{
    const float hi = (float)n - 1.01f;
    for (int r = 0; r < PACKET; r++) {
        const float o[3] = {p->ox[r], p->oy[r], p->oz[r]};
        for (int a = 0; a < 3; a++) {
            if (fabsf(p->d[a]) < 1e-6f) {
                if (o[a] < 0 || o[a] > hi)
                    *t1 = -INFINITY;
                continue;
            }
            const float u = -o[a] / p->d[a], v = (hi - o[a]) / p->d[a];
            *t0 = fmaxf(*t0, fminf(u, v));
            *t1 = fminf(*t1, fmaxf(u, v));
        }
    }
}

/* Packets over the plane through the middle of the volume across the direction; returns how many samples they take. */
static double make_packets(sample_task *t, const float d[3])
{
    const float u[3] = {fabsf(d[2]) > 0.9f ? 1 : -d[1], fabsf(d[2]) > 0.9f ? 0 : d[0], 0};
    const float um = sqrtf(u[0] * u[0] + u[1] * u[1]), e1[3] = {u[0] / um, u[1] / um, 0};
    const float e2[3] = {d[1] * e1[2] - d[2] * e1[1], d[2] * e1[0] - d[0] * e1[2], d[0] * e1[1] - d[1] * e1[0]};
    const int side = t->n / 8 * 2;
    const float middle = (float)(t->n - 1) / 2;
    double samples = 0;
    t->n_packets = 0;
    for (int b = -side / 2; b < side / 2; b++) {
        for (int a = -side / 2; a < side / 2; a++) {
            packet p = {.d = {d[0], d[1], d[2]}};
            for (int r = 0; r < PACKET; r++) {
                const int across = a * 4 + r % 4, down = b * 4 + r / 4;
                const float pa = ((float)across + 0.5f) * 2.0f, pb = ((float)down + 0.5f) * 2.0f;
                p.ox[r] = middle + pa * e1[0] + pb * e2[0];
                p.oy[r] = middle + pa * e1[1] + pb * e2[1];
                p.oz[r] = middle + pa * e1[2] + pb * e2[2];
            }
            float t0 = -2.0f * (float)t->n, t1 = 2.0f * (float)t->n;
            clip(&p, t->n, &t0, &t1);
            p.steps = t1 > t0 ? (int)(t1 - t0) : 0;
            for (int r = 0; r < PACKET; r++) {
                p.ox[r] += t0 * d[0];
                p.oy[r] += t0 * d[1];
                p.oz[r] += t0 * d[2];
            }
            if (p.steps < 1)
                continue;
            t->packets[t->n_packets++] = p;
            samples += (double)p.steps * PACKET;
        }
    }
    return samples;
}

static void measure_direction(sample_task *t, int threads, const char *direction, const float d[3])
{
    char name[64];
    const double samples = make_packets(t, d);
    snprintf(name, sizeof name, "trilinear_u8_%d_%s", t->n, direction);
    t->march = march_scalar;
    measure(name, "scalar", threads, march_all, t, samples * 1e-6, "Msamples/s");
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
        t->march = march_avx2;
        measure(name, "avx2", threads, march_all, t, samples * 1e-6, "Msamples/s");
    }
    if (__builtin_cpu_supports("avx512f")) {
        t->march = march_avx512;
        measure(name, "avx512", threads, march_all, t, samples * 1e-6, "Msamples/s");
    }
#endif
}

static void measure_samples(int n, int threads)
{
    static const float x[3] = {1, 0, 0}, z[3] = {0, 0, 1};
    const float oblique[3] = {0.48f, 0.60f, 0.64f}; /* of length 1 */
    const size_t voxels = (size_t)n * (size_t)n * (size_t)n, side = (size_t)n / 8 * 2;
    uint8_t *data = malloc(voxels + 8); /* a gather reads up to two bytes past the last voxel */
    sample_task t = {.n = n, .packets = malloc(side * side * sizeof *t.packets)};
    if (!data || !t.packets)
        exit(1);
    for (size_t i = 0; i < voxels + 8; i++)
        data[i] = (uint8_t)(i * 2654435761u >> 24);
    t.voxels = data;
    measure_direction(&t, threads, "x", x);
    measure_direction(&t, threads, "z", z);
    measure_direction(&t, threads, "oblique", oblique);
    free(t.packets);
    free(data);
}

int main(int argc, char **argv)
{
    const bool quick = argc == 2 && strcmp(argv[1], "--quick") == 0;
    if (argc > 1 && !quick) {
        fprintf(stderr, "usage: limits [--quick]\n");
        return 2;
    }
    for (int threads = 1; threads <= 2; threads++) {
        measure_memory(threads, (size_t)(quick ? 256 : 1024) << 20);
        measure_samples(64, threads);
        measure_samples(256, threads);
        if (!quick)
            measure_samples(512, threads);
    }
    return 0;
}
