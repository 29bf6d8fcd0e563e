#include "measure/triangle.h"

#include <math.h>
#include <stdbool.h>

/* What part of the way from a to b the place lies that is nearest to p. */
static double part_of_way(vv_vec3 p, vv_vec3 a, vv_vec3 b)
{
    const vv_vec3 way = vvi_sub(b, a);
    const double square = vvi_dot(way, way), t = square > 0 ? vvi_dot(vvi_sub(p, a), way) / square : 0;
    return t < 0 ? 0 : t > 1 ? 1 : t;
}

static void take_if_nearer(vv_vec3 *best, double *square, vv_vec3 p, const vvi_triangle *t, vv_vec3 weights)
{
    const vv_vec3 d = vvi_sub(p, vvi_triangle_at(t, weights));
    const double s = vvi_dot(d, d);
    if (s < *square) {
        *square = s;
        *best = weights;
    }
}

/* So narrow that rounding decides on which side of a side something lies; nothing is lost by its sides alone. */
static bool is_sliver(vv_vec3 ab, vv_vec3 ac)
{
    const vv_vec3 n = vvi_cross(ab, ac);
    return !(vvi_dot(n, n) > 1e-18 * vvi_dot(ab, ab) * vvi_dot(ac, ac));
}

/* Without an area: the nearest of the three sides. */
static vv_vec3 nearest_on_sides(vv_vec3 p, const vvi_triangle *t)
{
    vv_vec3 best = {1, 0, 0};
    double square = INFINITY;
    const double ab = part_of_way(p, t->a, t->b), bc = part_of_way(p, t->b, t->c), ca = part_of_way(p, t->c, t->a);
    take_if_nearer(&best, &square, p, t, (vv_vec3){1 - ab, ab, 0});
    take_if_nearer(&best, &square, p, t, (vv_vec3){0, 1 - bc, bc});
    take_if_nearer(&best, &square, p, t, (vv_vec3){ca, 0, 1 - ca});
    return best;
}

vv_vec3 vvi_nearest_weights(vv_vec3 p, const vvi_triangle *t)
{
    const vv_vec3 ab = vvi_sub(t->b, t->a), ac = vvi_sub(t->c, t->a), ap = vvi_sub(p, t->a);
    if (is_sliver(ab, ac))
        return nearest_on_sides(p, t);
    const double d1 = vvi_dot(ab, ap), d2 = vvi_dot(ac, ap);
    if (d1 <= 0 && d2 <= 0)
        return (vv_vec3){1, 0, 0};
    const vv_vec3 bp = vvi_sub(p, t->b);
    const double d3 = vvi_dot(ab, bp), d4 = vvi_dot(ac, bp);
    if (d3 >= 0 && d4 <= d3)
        return (vv_vec3){0, 1, 0};
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 - d3 > 0)
        return (vv_vec3){-d3 / (d1 - d3), d1 / (d1 - d3), 0};
    const vv_vec3 cp = vvi_sub(p, t->c);
    const double d5 = vvi_dot(ab, cp), d6 = vvi_dot(ac, cp);
    if (d6 >= 0 && d5 <= d6)
        return (vv_vec3){0, 0, 1};
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 - d6 > 0)
        return (vv_vec3){-d6 / (d2 - d6), 0, d2 / (d2 - d6)};
    const double va = d3 * d6 - d5 * d4, toward = d4 - d3, back = d5 - d6;
    if (va <= 0 && toward >= 0 && back >= 0 && toward + back > 0)
        return (vv_vec3){0, back / (toward + back), toward / (toward + back)};
    const double sum = va + vb + vc;
    if (!(va >= 0 && vb >= 0 && vc >= 0 && sum > 0))
        return nearest_on_sides(p, t);
    return (vv_vec3){va / sum, vb / sum, vc / sum};
}

vv_vec3 vvi_triangle_at(const vvi_triangle *t, vv_vec3 w)
{
    return vvi_add(vvi_add(vvi_scaled(t->a, w.x), vvi_scaled(t->b, w.y)), vvi_scaled(t->c, w.z));
}

double vvi_triangle_square(vv_vec3 p, const vvi_triangle *t)
{
    const vv_vec3 d = vvi_sub(p, vvi_triangle_at(t, vvi_nearest_weights(p, t)));
    return vvi_dot(d, d);
}

/* Two segments: squared distance and the nearest places. */
static double segments_square(vv_vec3 *on_p, vv_vec3 *on_q, vv_vec3 p0, vv_vec3 p1, vv_vec3 q0, vv_vec3 q1)
{
    const vv_vec3 d1 = vvi_sub(p1, p0), d2 = vvi_sub(q1, q0), r = vvi_sub(p0, q0);
    const double a = vvi_dot(d1, d1), e = vvi_dot(d2, d2), b = vvi_dot(d1, d2), c = vvi_dot(d1, r), f = vvi_dot(d2, r);
    const double denominator = a * e - b * b;
    double s = denominator > 1e-14 * a * e ? (b * f - c * e) / denominator : 0; /* parallel: any place will do */
    s = s < 0 ? 0 : s > 1 ? 1 : s;
    const double t = part_of_way(vvi_between(p0, p1, s), q0, q1);
    *on_q = vvi_between(q0, q1, t);
    *on_p = vvi_between(p0, p1, part_of_way(*on_q, p0, p1));
    const vv_vec3 d = vvi_sub(*on_p, *on_q);
    return vvi_dot(d, d);
}

/* Whether a segment goes through a triangle (Moller & Trumbore 1997), not in its plane, and where. */
static bool pierces(vv_vec3 *at, vv_vec3 p, vv_vec3 q, const vvi_triangle *t)
{
    const vv_vec3 way = vvi_sub(q, p), ab = vvi_sub(t->b, t->a), ac = vvi_sub(t->c, t->a), h = vvi_cross(way, ac);
    const double det = vvi_dot(ab, h), size = vvi_dot(way, way) * vvi_dot(ab, ab) * vvi_dot(ac, ac);
    if (!(det * det > 1e-20 * size)) /* what lies in the plane is near its sides */
        return false;
    const vv_vec3 s = vvi_sub(p, t->a), k = vvi_cross(s, ab);
    const double u = vvi_dot(s, h) / det, v = vvi_dot(way, k) / det, along = vvi_dot(ac, k) / det;
    *at = vvi_between(p, q, along);
    return u >= 0 && v >= 0 && u + v <= 1 && along >= 0 && along <= 1;
}

static bool crosses(vv_vec3 *at, const vv_vec3 s[3], const vvi_triangle *t)
{
    return pierces(at, s[0], s[1], t) || pierces(at, s[1], s[2], t) || pierces(at, s[2], s[0], t);
}

double vvi_triangles_square(vv_vec3 *on_s, vv_vec3 *on_t, const vvi_triangle *s, const vvi_triangle *t)
{
    const vv_vec3 p[3] = {s->a, s->b, s->c}, q[3] = {t->a, t->b, t->c};
    double best = INFINITY;
    if (crosses(on_s, p, t) || crosses(on_s, q, s)) {
        *on_t = *on_s;
        return 0;
    }
    for (int i = 0; i < 9; i++) {
        vv_vec3 x, y;
        const double square = segments_square(&x, &y, p[i / 3], p[(i / 3 + 1) % 3], q[i % 3], q[(i % 3 + 1) % 3]);
        if (square < best) {
            best = square;
            *on_s = x;
            *on_t = y;
        }
    }
    for (int i = 0; i < 6; i++) {
        const vv_vec3 corner = i < 3 ? p[i] : q[i - 3];
        const vvi_triangle *other = i < 3 ? t : s;
        const vv_vec3 foot = vvi_triangle_at(other, vvi_nearest_weights(corner, other)), d = vvi_sub(corner, foot);
        if (vvi_dot(d, d) < best) {
            best = vvi_dot(d, d);
            *on_s = i < 3 ? corner : foot;
            *on_t = i < 3 ? foot : corner;
        }
    }
    return best;
}
