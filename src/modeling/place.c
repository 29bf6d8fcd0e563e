/* A primitive among the samples of a grid. */
#include "modeling/place.h"
#include "core/vec.h"

/* Half of the longest diagonal of a box's samples. */
static double half_diagonal(const vvi_placed *p, const vv_box *box)
{
    const vv_vec3 x = vvi_scaled(p->to_own.axis[0], (double)(box->n[0] - 1) / 2);
    const vv_vec3 y = vvi_scaled(p->to_own.axis[1], (double)(box->n[1] - 1) / 2);
    const vv_vec3 z = vvi_scaled(p->to_own.axis[2], (double)(box->n[2] - 1) / 2);
    double most = 0;
    for (int i = 0; i < 4; i++) {
        const vv_vec3 xy = vvi_add(x, vvi_scaled(y, i & 1 ? 1 : -1)), all = vvi_add(xy, vvi_scaled(z, i & 2 ? 1 : -1));
        most = fmax(most, vvi_length(all));
    }
    return most;
}

static double middle_distance(const vvi_placed *p, const vv_box *box)
{
    double middle[3], d;
    for (int a = 0; a < 3; a++)
        middle[a] = (double)box->lo[a] + (double)(box->n[a] - 1) / 2;
    const vv_vec3 at = vv_affine_point(p->to_own, vvi_vec(middle[0], middle[1], middle[2]));
    p->primitive->distances(&d, &(vvi_places){&at.x, &at.y, &at.z, 1}, &p->lengths);
    return d;
}

static void row_densities(float *out, const vvi_placed *p, const vv_box *box, int64_t j, int64_t k)
{
    double x[VVI_PLACED_BRICK], y[VVI_PLACED_BRICK], z[VVI_PLACED_BRICK], d[VVI_PLACED_BRICK];
    const size_t n = (size_t)box->n[0];
    const vv_vec3 first =
        vv_affine_point(p->to_own, vvi_vec((double)box->lo[0], (double)(box->lo[1] + j), (double)(box->lo[2] + k)));
    for (size_t i = 0; i < n; i++) {
        x[i] = first.x + (double)i * p->to_own.axis[0].x;
        y[i] = first.y + (double)i * p->to_own.axis[0].y;
        z[i] = first.z + (double)i * p->to_own.axis[0].z;
    }
    p->primitive->distances(d, &(vvi_places){x, y, z, n}, &p->lengths);
    vvi_profile_densities(out, d, n, p->profile);
}

bool vvi_placed_densities(float *out, const vvi_placed *p, const vv_box *box)
{
    const double d = middle_distance(p, box), reach = half_diagonal(p, box) + p->profile->width;
    const int64_t n = box->n[0] * box->n[1] * box->n[2];
    if (fabs(d) > reach * (1 + 1e-9)) { /* no place of the box is nearer to the surface than the profile reaches */
        for (int64_t i = 0; i < n; i++)
            out[i] = d < 0;
        return false;
    }
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            row_densities(out + (k * box->n[1] + j) * box->n[0], p, box, j, k);
    return true;
}
