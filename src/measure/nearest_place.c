/* The nearest place of a surface, and on which side of it a point is. */
#include "core/vec.h"
#include "measure/bvh.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* What the foot lies on: a corner, a side or the inside of a triangle, by the places of the corners that it needs. */
typedef struct feature {
    float corner[2][3];
    int n; /* corners: 0: the inside */
} feature;

static feature feature_of(const vv_mesh_tree *tree, size_t triangle, vv_vec3 weights)
{
    feature f = {.n = 0};
    int positive = 0;
    for (int k = 0; k < 3; k++)
        positive += (&weights.x)[k] > 0;
    if (positive == 3)
        return f;
    for (size_t k = 0; k < 3; k++)
        if ((&weights.x)[k] > 0)
            memcpy(f.corner[f.n++], tree->corners + 9 * triangle + 3 * k, sizeof f.corner[0]);
    return f;
}

static bool same_place(const float *p, const float *q)
{
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

static vv_vec3 unit_normal(const vvi_triangle *t)
{
    vv_vec3 n = vvi_cross(vvi_sub(t->b, t->a), vvi_sub(t->c, t->a));
    return vvi_unit(&n) ? n : vvi_vec(0, 0, 0);
}

/* The normal of a triangle at the feature, by its angle there; nothing when the triangle does not have the feature. */
static vv_vec3 normal_at(const vv_mesh_tree *tree, size_t triangle, const feature *f)
{
    const float *p = tree->corners + 9 * triangle;
    const vvi_triangle t = vvi_bvh_triangle(tree, triangle);
    const vv_vec3 corner[3] = {t.a, t.b, t.c};
    int found = 0, last = 0;
    for (int i = 0; i < f->n; i++)
        for (int k = 0; k < 3; k++)
            if (same_place(f->corner[i], p + 3 * (size_t)k)) {
                found++;
                last = k;
                break;
            }
    if (found < f->n)
        return vvi_vec(0, 0, 0);
    const double angle = f->n == 2 ? 1 : vv_angle_at(corner[(last + 1) % 3], corner[last], corner[(last + 2) % 3]);
    return vvi_scaled(unit_normal(&t), isfinite(angle) ? angle : 0);
}

/* All triangles that have the feature touch the foot. */
static vv_vec3 normal_around(const vv_mesh_tree *tree, const feature *f, vv_vec3 foot)
{
    struct {
        int level;
        size_t index;
    } stack[8 * VVI_BVH_LEVELS + 8];
    const double slack = 4 * (double)FLT_EPSILON * tree->radius;
    vv_vec3 sum = {0, 0, 0};
    int n = 1;
    stack[0].level = tree->n_levels - 1;
    stack[0].index = 0;
    while (n > 0) {
        n--;
        const int level = stack[n].level;
        const size_t index = stack[n].index;
        for (size_t i = index * VVI_BVH_LEAF; level < 0 && i < (index + 1) * VVI_BVH_LEAF && i < tree->n; i++)
            sum = vvi_add(sum, normal_at(tree, i, f));
        for (int c = 0; level >= 0 && c < 8; c++) {
            const vv_bounds b = vvi_bvh_child(&tree->level[level][index], c);
            if (foot.x >= b.lo.x - slack && foot.x <= b.hi.x + slack && foot.y >= b.lo.y - slack &&
                foot.y <= b.hi.y + slack && foot.z >= b.lo.z - slack && foot.z <= b.hi.z + slack) {
                stack[n].level = level - 1;
                stack[n++].index = 8 * index + (size_t)c;
            }
        }
    }
    return sum;
}

static bool is_inside(const vv_mesh_tree *tree, size_t triangle, vv_vec3 weights, vv_vec3 foot, vv_vec3 p)
{
    const feature f = feature_of(tree, triangle, weights);
    const vvi_triangle t = vvi_bvh_triangle(tree, triangle);
    const vv_vec3 normal = f.n ? normal_around(tree, &f, foot) : unit_normal(&t);
    return (vvi_dot(vvi_sub(p, foot), normal) < 0) != tree->inside_out;
}

void vv_mesh_tree_nearest(vv_mesh_foot *out, const vv_mesh_tree *tree, vv_vec3 point)
{
    const vv_vec3 p = vvi_sub(point, tree->origin);
    double square;
    const size_t i = vvi_bvh_nearest(&square, tree, p, 0);
    const vvi_triangle t = vvi_bvh_triangle(tree, i);
    const vv_vec3 weights = vvi_nearest_weights(p, &t), foot = vvi_triangle_at(&t, weights);
    *out = (vv_mesh_foot){.at = vvi_add(foot, tree->origin),
                          .distance = sqrt(square),
                          .signed_distance = NAN,
                          .triangle = tree->order[i],
                          .weights = {weights.x, weights.y, weights.z}};
    if (tree->closed)
        out->signed_distance = is_inside(tree, i, weights, foot, p) ? -out->distance : out->distance;
}
