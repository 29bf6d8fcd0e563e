/* Marching Cubes in one cell, in double precision and with the parts of its faces. */
#include "measure/cell.h"

static vv_vec3 corner_point(unsigned c)
{
    return vvi_vec(c & 1, c >> 1 & 1, c >> 2);
}

/* Between two corners that an edge joins; found alike from both cells beside the edge. */
static vv_vec3 crossing(const double depth[8], unsigned a, unsigned b)
{
    const unsigned low = a < b ? a : b, high = a < b ? b : a;
    const double t = depth[low] / (depth[low] - depth[high]);
    return vvi_add(corner_point(low), vvi_scaled(vvi_sub(corner_point(high), corner_point(low)), t));
}

/* Whether the corners inside are joined on a face with two meanings (Nielson & Hamann 1991): as in the mesh. */
static bool joined(const double depth[8], unsigned pattern, int face)
{
    const uint8_t *k = vvi_face_corners[face];
    const double even = depth[k[0]] * depth[k[2]], odd = depth[k[1]] * depth[k[3]];
    return pattern >> k[0] & 1 ? even >= odd : odd >= even;
}

static const vvi_case *find_case(const double depth[8], unsigned pattern)
{
    unsigned decision = 0, bit = 0;
    for (int f = 0; f < 6; f++)
        if (vvi_case_ambiguous[pattern] >> f & 1)
            decision |= (unsigned)joined(depth, pattern, f) << bit++;
    return &vvi_cases[vvi_case_first[pattern] + decision];
}

static vv_vec3 mean(const vv_vec3 *point, unsigned around)
{
    vv_vec3 sum = {0, 0, 0};
    for (int e = 0; e < 12; e++)
        if (around >> e & 1)
            sum = vvi_add(sum, point[e]);
    return vvi_scaled(sum, 1.0 / __builtin_popcount(around));
}

void vvi_cell_triangles(vvi_cell *out, const double depth[8], unsigned pattern)
{
    const vvi_case *c = find_case(depth, pattern);
    out->points = c->edges;
    for (unsigned e = 0; e < 12; e++) {
        if (!(c->edges >> e & 1))
            continue;
        const unsigned axis = e / 4, b = axis == 0 ? 1 : 0, d = axis == 2 ? 1 : 2;
        const unsigned low = (e & 1) << b | (e >> 1 & 1) << d;
        out->point[e] = crossing(depth, low, low | 1u << axis);
    }
    for (int i = 0; i < c->n_interior; i++) {
        out->point[12 + i] = mean(out->point, c->around[i]);
        out->points |= 1u << (12 + i);
    }
    out->n = c->n_triangles;
    out->triangle = c->triangle;
}

/* The inside of a face, as seen from outside of the cell: up to two convex polygons, `split` the end of the first. */
static int face_polygon(vv_vec3 p[8], int *split, const double depth[8], unsigned pattern, int face)
{
    const uint8_t *k = vvi_face_corners[face]; /* clockwise */
    int n = 0;
    *split = 0;
    if (vvi_case_ambiguous[pattern] >> face & 1 && !joined(depth, pattern, face)) {
        for (int i = 3; i >= 0; i--) {
            if (!(pattern >> k[i] & 1))
                continue;
            *split = n;
            p[n++] = crossing(depth, k[(i + 1) & 3], k[i]);
            p[n++] = corner_point(k[i]);
            p[n++] = crossing(depth, k[i], k[(i + 3) & 3]);
        }
        return n;
    }
    for (int i = 3; i >= 0; i--) {
        const unsigned here = k[i], next = k[(i + 3) & 3];
        if (pattern >> here & 1)
            p[n++] = corner_point(here);
        if ((pattern >> here ^ pattern >> next) & 1)
            p[n++] = crossing(depth, here, next);
    }
    *split = n;
    return n;
}

void vvi_cell_face(vvi_chain *chain, vvi_chain_part part, const double depth[8], unsigned pattern, int face)
{
    vv_vec3 p[8];
    int split;
    const int n = face_polygon(p, &split, depth, pattern, face);
    for (int i = 1; i + 1 < split; i++)
        vvi_chain_add(chain, part, p[0], p[i], p[i + 1]);
    for (int i = split + 1; i + 1 < n; i++)
        vvi_chain_add(chain, part, p[split], p[i], p[i + 1]);
}

static double fan_area(const vv_vec3 *p, int n)
{
    double area = 0;
    for (int i = 1; i + 1 < n; i++)
        area += vvi_length(vvi_cross(vvi_sub(p[i], p[0]), vvi_sub(p[i + 1], p[0])));
    return area / 2;
}

double vvi_cell_face_area(const double depth[8], unsigned pattern, int face)
{
    vv_vec3 p[8];
    int split;
    const int n = face_polygon(p, &split, depth, pattern, face);
    return fan_area(p, split) + fan_area(p + split, n - split);
}
