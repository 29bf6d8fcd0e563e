/* Which samples a view shows. */
#include "core/vec.h"
#include "server/preview.h"

#include <math.h>

/* THIN: as many samples as a slice through them needs, and what lies beside it. */
enum { THIN = 4 };

bool vvi_preview_seen(vv_box *out, const vv_scene *scene, vv_affine index_to_world, const int64_t dims[3], int margin)
{
    const vv_lens *lens = &scene->lens;
    const double distance = vvi_dot(vvi_sub(scene->cross_hair, lens->eye), lens->forward);
    const double reach = lens->parallel ? 1 : distance;
    double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
    vv_affine to_index;
    if (!vv_affine_invert(&to_index, index_to_world) || !(distance > 0))
        return false;
    for (int corner = 0; corner < 4; corner++) {
        const double x = (corner & 1 ? 1 : -1) * lens->half_width * reach,
                     y = (corner & 2 ? 1 : -1) * lens->half_height * reach;
        const vv_vec3 middle = vvi_add(lens->eye, vvi_scaled(lens->forward, distance));
        const vv_vec3 at = vvi_add(vvi_add(middle, vvi_scaled(lens->right, x)), vvi_scaled(lens->up, y));
        const vv_vec3 index = vv_affine_point(to_index, at);
        const double place[3] = {index.x, index.y, index.z};
        for (int a = 0; a < 3; a++) {
            lo[a] = fmin(lo[a], place[a]);
            hi[a] = fmax(hi[a], place[a]);
        }
    }
    for (int a = 0; a < 3; a++) {
        const double first = fmax(floor(lo[a]) - margin, 0), last = fmin(ceil(hi[a]) + margin, (double)dims[a] - 1);
        if (!(first <= last))
            return false;
        out->lo[a] = (int64_t)first;
        out->n[a] = (int64_t)last - out->lo[a] + 1;
    }
    return true;
}

vv_box vvi_preview_smaller(const vv_box *box, const double middle[3], double most)
{
    vv_box out = *box;
    double all = 1;
    int wide = 0;
    for (int a = 0; a < 3; a++) {
        all *= (double)box->n[a];
        wide += box->n[a] > THIN;
    }
    if (all <= most || !wide)
        return out;
    const double share = pow(most / all, 1.0 / wide);
    for (int a = 0; a < 3; a++) {
        if (box->n[a] <= THIN)
            continue;
        out.n[a] = (int64_t)fmax(floor((double)box->n[a] * share), 1);
        const double first = fmin(fmax(floor(middle[a] - (double)out.n[a] / 2), (double)box->lo[a]),
                                  (double)(box->lo[a] + box->n[a] - out.n[a]));
        out.lo[a] = (int64_t)first;
    }
    return out;
}
