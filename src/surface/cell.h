/** @file
 * One cell of Marching Cubes by itself: what the inner loops do with a row of cells, with the same roundings.
 */
#ifndef VVI_SURFACE_CELL_H
#define VVI_SURFACE_CELL_H
#include "surface/cases.h"
#include "surface/marching_kernel.h"
#include <float.h>
#include <math.h>

/** The axes across an axis, the lower one first. */
static inline int vvi_across(int axis, int which)
{
    return which == 0 ? (axis == 0 ? 1 : 0) : (axis == 2 ? 1 : 2);
}

/** A corner less the value of the surface, where samples may be infinite: so large that the surface lies at the other
 * end of an edge, and differences are no less than numbers. */
static inline float vvi_cell_corner(float v)
{
    const float most = FLT_MAX / 4;
    return v > most ? most : v < -most ? -most : v;
}

/** Bit i: on the i-th face with two meanings the corners inside are joined (v: corners, less the value of the surface).
 * Both cells beside a face find the same: the products are the same numbers, and exact zero joins. */
static inline unsigned vvi_cell_decide(const float v[8], unsigned pattern)
{
    unsigned decision = 0, bit = 0;
    for (int f = 0; f < 6; f++) {
        const uint8_t *k = vvi_face_corners[f];
        if (!(vvi_case_ambiguous[pattern] >> f & 1))
            continue;
        const float even = v[k[0]] * v[k[2]], odd = v[k[1]] * v[k[3]];
        decision |= (unsigned)(pattern >> k[0] & 1 ? even >= odd : odd >= even) << bit++;
    }
    return decision;
}

/** The mean of the crossings of the edges `around`, in the cell. */
static inline void vvi_cell_interior_place(float p[3], const float v[8], unsigned around)
{
    const float n = (float)__builtin_popcount(around);
    p[0] = p[1] = p[2] = 0;
    for (unsigned e = 0; e < 12; e++) {
        if (!(around >> e & 1))
            continue;
        const unsigned axis = e / 4, b = (unsigned)vvi_across((int)axis, 0), c = (unsigned)vvi_across((int)axis, 1);
        const unsigned low = (e & 1) << b | (e >> 1 & 1) << c, high = low | 1u << axis;
        p[axis] += v[low] / (v[low] - v[high]) / n;
        p[b] += (float)(e & 1) / n;
        p[c] += (float)(e >> 1 & 1) / n;
    }
}

/** The gradient of the trilinear function at a place in the cell. */
static inline void vvi_cell_gradient(float g[3], const float v[8], const float p[3])
{
    for (unsigned a = 0; a < 3; a++) {
        const unsigned b = (a + 1) % 3, c = (a + 2) % 3;
        g[a] = 0;
        for (unsigned i = 0; i < 4; i++) {
            const unsigned low = (i & 1) << b | (i >> 1) << c;
            g[a] += (i & 1 ? p[b] : 1 - p[b]) * (i >> 1 ? p[c] : 1 - p[c]) * (v[low | 1u << a] - v[low]);
        }
    }
}

/** Writes an interior vertex of the cell at (x, y, z) as number `vertex` of the frame's arrays. False: there is no
 * gradient, the normal is 0. */
static inline bool vvi_cell_put_interior(const vvi_march_setup *f, size_t vertex, const float v[8], unsigned around,
                                         const float cell[3])
{
    float p[3], g[3], n[3], square = 0;
    vvi_cell_interior_place(p, v, around);
    vvi_cell_gradient(g, v, p);
    const float at[3] = {cell[0] + p[0], cell[1] + p[1], cell[2] + p[2]};
    for (size_t a = 0; a < 3; a++) {
        const float *m = f->to_world[a], *t = f->to_normal[a];
        f->position[3 * vertex + a] = m[0] * at[0] + m[1] * at[1] + m[2] * at[2] + m[3];
        n[a] = t[0] * g[0] + t[1] * g[1] + t[2] * g[2];
        square += n[a] * n[a];
    }
    const float scale = square > 1e-30f && square < 1e37f ? 1 / sqrtf(square) : 0;
    for (size_t a = 0; a < 3 && f->normal; a++)
        f->normal[3 * vertex + a] = scale > 0 ? n[a] * scale : 0;
    return scale > 0;
}
#endif
