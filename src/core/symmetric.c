#include "core/symmetric.h"
#include "core/vec.h"

/* What the middle one of the steps finds: an eigenvector, and two more directions that make a frame with it. */
typedef struct frame {
    vv_vec3 w, u, v;
    bool largest; /* it is the vector of the largest eigenvalue, else of the least */
} frame;

static vv_vec3 times(const double m[VVI_SYMMETRIC], vv_vec3 p)
{
    return vvi_vec(m[VVI_XX] * p.x + m[VVI_XY] * p.y + m[VVI_XZ] * p.z,
                   m[VVI_XY] * p.x + m[VVI_YY] * p.y + m[VVI_YZ] * p.z,
                   m[VVI_XZ] * p.x + m[VVI_YZ] * p.y + m[VVI_ZZ] * p.z);
}

/* Rows of m - value lie in the plane at right angles to the vector: the longest product of two is the surest. */
static vv_vec3 vector_of(const double m[VVI_SYMMETRIC], double value)
{
    const vv_vec3 rows[3] = {{m[VVI_XX] - value, m[VVI_XY], m[VVI_XZ]},
                             {m[VVI_XY], m[VVI_YY] - value, m[VVI_YZ]},
                             {m[VVI_XZ], m[VVI_YZ], m[VVI_ZZ] - value}};
    vv_vec3 best = vvi_cross(rows[0], rows[1]);
    for (int a = 1; a < 3; a++) {
        const vv_vec3 c = vvi_cross(rows[a], rows[(a + 1) % 3]);
        if (vvi_dot(c, c) > vvi_dot(best, best))
            best = c;
    }
    const double squared = vvi_dot(best, best);
    return squared > 0 ? vvi_scaled(best, 1 / sqrt(squared)) : vvi_vec(1, 0, 0);
}

/* Two directions at right angles to w, which has length 1. */
static void complete(frame *f)
{
    const vv_vec3 w = f->w;
    f->u = fabs(w.x) > fabs(w.y) ? vvi_vec(-w.z, 0, w.x) : vvi_vec(0, w.z, -w.y);
    f->u = vvi_scaled(f->u, 1 / sqrt(vvi_dot(f->u, f->u)));
    f->v = vvi_cross(w, f->u);
}

/* Of a matrix whose largest entry is 1. */
static frame find_frame(const double m[VVI_SYMMETRIC])
{
    const double q = (m[VVI_XX] + m[VVI_YY] + m[VVI_ZZ]) / 3;
    const double a = m[VVI_XX] - q, b = m[VVI_YY] - q, c = m[VVI_ZZ] - q;
    const double xy = m[VVI_XY], xz = m[VVI_XZ], yz = m[VVI_YZ];
    const double p = sqrt((a * a + b * b + c * c + 2 * (xy * xy + xz * xz + yz * yz)) / 6);
    const double det = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
    frame f = {.w = {1, 0, 0}, .largest = det >= 0};
    if (p > 0) {
        const double r = fmin(fabs(det) / (2 * p * p * p), 1), far = 2 * p * cos(acos(r) / 3);
        f.w = vector_of(m, f.largest ? q + far : q - far);
    }
    complete(&f);
    return f;
}

/* The eigenvalues in the plane of u and v, ascending, and the direction of the larger one. */
static void solve_plane(double two[2], double *along_u, double *along_v, const frame *f, const double m[VVI_SYMMETRIC])
{
    const vv_vec3 mu = times(m, f->u), mv = times(m, f->v);
    const double a = vvi_dot(f->u, mu), b = vvi_dot(f->v, mu), c = vvi_dot(f->v, mv);
    const double middle = 0.5 * (a + c), half = 0.5 * (a - c), reach = sqrt(half * half + b * b);
    two[0] = middle - reach;
    two[1] = middle + reach;
    if (!along_u)
        return;
    /* (half + reach, b) and (b, reach - half) are the same direction: that without cancellation is taken */
    *along_u = half > 0 ? half + reach : b;
    *along_v = half > 0 ? b : reach - half;
    const double length = sqrt(*along_u * *along_u + *along_v * *along_v);
    *along_u = length > 0 ? *along_u / length : 1;
    *along_v = length > 0 ? *along_v / length : 0;
}

static double largest_entry(const double m[VVI_SYMMETRIC])
{
    double most = 0;
    for (int i = 0; i < VVI_SYMMETRIC; i++) {
        if (!isfinite(m[i]))
            return NAN;
        most = fmax(most, fabs(m[i]));
    }
    return most;
}

static void solve(double value[3], vv_vec3 *vector, const double in[VVI_SYMMETRIC])
{
    const double scale = largest_entry(in);
    double m[VVI_SYMMETRIC], along_u = 1, along_v = 0, two[2];
    for (int i = 0; i < VVI_SYMMETRIC; i++)
        m[i] = scale > 0 ? in[i] / scale : scale;
    const frame f = find_frame(m);
    const double one = vvi_dot(f.w, times(m, f.w));
    solve_plane(two, vector ? &along_u : NULL, &along_v, &f, m);
    value[0] = scale * (f.largest ? two[0] : one);
    value[1] = scale * (f.largest ? two[1] : two[0]);
    value[2] = scale * (f.largest ? one : two[1]);
    if (!vector)
        return;
    const vv_vec3 more = vvi_add(vvi_scaled(f.u, along_u), vvi_scaled(f.v, along_v));
    const vv_vec3 less = vvi_cross(f.w, more);
    vector[0] = f.largest ? less : f.w;
    vector[1] = f.largest ? more : less;
    vector[2] = f.largest ? f.w : more;
}

void vvi_symmetric_values(double value[3], const double m[VVI_SYMMETRIC])
{
    solve(value, NULL, m);
}

void vvi_symmetric_eigen(double value[3], vv_vec3 vector[3], const double m[VVI_SYMMETRIC])
{
    solve(value, vector, m);
}
