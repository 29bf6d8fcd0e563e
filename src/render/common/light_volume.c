/* Shares of light by cell: how they are stored, and read back. */
#include "render/common/light_volume.h"
#include "core/vec.h"
#include <math.h>

/* A quarter of each neighbour and a half of itself; ends keep what they have, and if asked, what is brighter than its
 * neighbours. */
static void smooth_line(float *cells, size_t stride, int32_t n, bool only_brighter)
{
    float before = cells[0];
    for (int32_t i = 1; i + 1 < n; i++) {
        float *c = cells + (size_t)i * stride;
        const float own = *c, mean = 0.25f * (before + c[stride]) + 0.5f * own;
        *c = only_brighter && own > mean ? own : mean;
        before = own;
    }
}

void vvi_light_smooth(float *cells, const int32_t n[3], bool only_brighter)
{
    const size_t stride[3] = {1, (size_t)n[0], (size_t)n[0] * (size_t)n[1]};
    for (int a = 0; a < 3; a++) {
        const int u = a == 0 ? 1 : 0, v = a == 2 ? 1 : 2;
        for (int32_t j = 0; j < n[v]; j++)
            for (int32_t i = 0; i < n[u]; i++)
                smooth_line(cells + (size_t)j * stride[v] + (size_t)i * stride[u], stride[a], n[a], only_brighter);
    }
}

void vvi_light_pack(uint32_t *cells, const float *const shares[], int n, size_t n_cells)
{
    const int n_words = (n + 3) / 4;
    for (size_t c = 0; c < n_cells; c++)
        for (int w = 0; w < n_words; w++) {
            uint32_t word = 0;
            for (int b = 0; b < 4; b++) {
                const float *of = 4 * w + b < n ? shares[4 * w + b] : NULL;
                const float share = of ? fminf(fmaxf(of[c], 0), 1) : 1;
                word |= (uint32_t)(sqrtf(share) * 255 + 0.5f) << (8 * b);
            }
            cells[c * (size_t)n_words + (size_t)w] = word;
        }
}

/* Of one cell. */
static float sum_of_shares(const vvi_light_volume *v, const uint32_t *words)
{
    float sum = v->scatter_rest;
    for (int i = 0; i < v->n_shares; i++) {
        const float root = (float)(words[i / 4] >> (i % 4 * 8) & 255) * (1.0f / 255);
        sum += v->scatter[i] * (i == 0 ? v->ambient : 1) * root * root;
    }
    return fminf(sum, 1);
}

void vvi_light_pack_scattered(uint32_t *out, const vvi_light_volume *v)
{
    const size_t row = (size_t)v->n[0], slice = row * (size_t)v->n[1], n_cells = slice * (size_t)v->n[2];
    for (size_t c = 0; c < n_cells; c++)
        out[c] = (uint32_t)(sqrtf(sum_of_shares(v, v->cells + c * (size_t)v->n_words)) * 255 + 0.5f);
    /* the next ones' bytes beside their own; the last cells of an axis are none's first */
    for (int a = 1; a < 3; a++) {
        const size_t next = a == 1 ? row : slice;
        for (size_t c = 0; c + next < n_cells; c++)
            out[c] |= (out[c + next] & (a == 1 ? 0xffu : 0xffffu)) << (8 * a);
    }
}

/* Eight cells around a place, or where there is a normal, around the one ahead of it: the first one's number, and how
 * far it is to the next on each axis. */
static size_t find_cells(double f[3], const vvi_light_volume *v, vv_vec3 position, vv_vec3 normal)
{
    double width = 0;
    for (int a = 0; a < 3; a++)
        width += fabs(vvi_dot(normal, v->ahead[a]));
    const vv_vec3 p = vvi_add(position, vvi_scaled(normal, width));
    size_t at = 0, stride = 1;
    for (int a = 0; a < 3; a++) {
        const double *m = v->world_to_cell[a];
        const double q = fmin(fmax(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], 0), v->n[a] - 1.001);
        at += (size_t)q * stride;
        stride *= (size_t)v->n[a];
        f[a] = q - floor(q);
    }
    return at;
}

void vvi_light_volume_at(double out[VVI_LIGHT_SHARES], const vvi_light_volume *v, vv_vec3 position, vv_vec3 normal)
{
    const size_t row = (size_t)v->n[0], slice = row * (size_t)v->n[1];
    double f[3], root[VVI_LIGHT_SHARES] = {0};
    const size_t at = find_cells(f, v, position, normal);
    for (int b = 0; b < 8; b++) {
        const double w = (b & 1 ? f[0] : 1 - f[0]) * (b & 2 ? f[1] : 1 - f[1]) * (b & 4 ? f[2] : 1 - f[2]);
        const size_t cell = at + (b & 1 ? 1 : 0) + (b & 2 ? row : 0) + (b & 4 ? slice : 0);
        for (int i = 0; i < v->n_shares; i++)
            root[i] += w * (v->cells[cell * (size_t)v->n_words + (size_t)i / 4] >> (i % 4 * 8) & 255);
    }
    for (int i = 0; i < VVI_LIGHT_SHARES; i++)
        out[i] = i < v->n_shares ? root[i] * root[i] / (255 * 255) : 1;
    out[0] *= (double)v->ambient;
}

double vvi_light_scattered(const vvi_light_volume *v, vv_vec3 position, vv_vec3 normal)
{
    double f[3], root = 0;
    const size_t at = find_cells(f, v, position, normal);
    for (int b = 0; b < 8; b++) {
        const double w = (b & 1 ? f[0] : 1 - f[0]) * (b & 2 ? f[1] : 1 - f[1]) * (b & 4 ? f[2] : 1 - f[2]);
        root += w * (v->scattered[at + (b & 1)] >> (b / 2 * 8) & 255);
    }
    return root * root / (255 * 255);
}
