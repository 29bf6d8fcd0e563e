/* The nearest place of an ellipsoid (Eberly, "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid",
 * 2013): on it x[a] = e[a]^2 p[a] / (t + e[a]^2), where t is the largest root of
 * F(t) = sum (e[a] p[a] / (t + e[a]^2))^2 - 1. */
#include "modeling/primitives.h"

#include <math.h>

/* In units of the shortest half-axis: r[a] = (e[a] / e[least])^2, z[a] = p[a] / e[a], u = t / e[least]^2 + 1. */
typedef struct scaled {
    double r[3], z[3];
} scaled;

/* F, and how steeply it falls. */
static double level(double *fall, const scaled *q, double u)
{
    double sum = -1;
    *fall = 0;
    for (int a = 0; a < 3; a++)
        if (q->z[a] > 0) {
            const double below = u + (q->r[a] - 1), part = q->r[a] * q->z[a] / below;
            sum += part * part;
            *fall += 2 * part * part / below;
        }
    return sum;
}

/* F is convex and falls where u > 0: from a place before its root Newton's steps come to it and never pass it. Where
 * one of the parts is 1, F is not below 0; without such a place above 0 the root is at 0, if there is one. */
static double root(const scaled *q)
{
    double u = 0;
    for (int a = 0; a < 3; a++) {
        const double one = q->r[a] * q->z[a] - (q->r[a] - 1);
        u = one > u ? one : u;
    }
    for (int i = 0; i < 100; i++) {
        double fall;
        const double f = level(&fall, q, u), next = u + f / fall;
        if (!(f > 0) || !(next > u))
            break;
        u = next;
    }
    return u;
}

static double distance(const double p[3], const double e[3], int least)
{
    scaled q;
    double x[3], ways = 0, on = 0, size = 0;
    for (int a = 0; a < 3; a++) {
        q.r[a] = e[a] / e[least] * (e[a] / e[least]);
        q.z[a] = p[a] / e[a];
        size += q.z[a] * q.z[a];
    }
    const double u = root(&q);
    for (int a = 0; a < 3; a++) {
        x[a] = q.z[a] > 0 ? q.r[a] * p[a] / (u + (q.r[a] - 1)) : 0;
        if (a != least)
            on += x[a] / e[a] * (x[a] / e[a]);
    }
    if (!(q.z[least] > 0) && on < 1) /* near the middle of a plane of symmetry the nearest place is not in that plane */
        x[least] = e[least] * sqrt(1 - on);
    for (int a = 0; a < 3; a++)
        ways += (x[a] - p[a]) * (x[a] - p[a]);
    return size < 1 ? -sqrt(ways) : sqrt(ways);
}

void vvi_ellipsoid_distances(double *out, const vvi_places *places, const vvi_lengths *l)
{
    const double e[3] = {l->size[0] / 2, l->size[1] / 2, l->size[2] / 2};
    const int xy = e[1] < e[0] ? 1 : 0, least = e[2] < e[xy] ? 2 : xy;
    for (size_t i = 0; i < places->n; i++)
        out[i] = distance((const double[3]){fabs(places->x[i]), fabs(places->y[i]), fabs(places->z[i])}, e, least);
}
