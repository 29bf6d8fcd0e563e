/* The least distance of two surfaces: pairs of boxes, the nearest first. */
#include "core/job.h"
#include "core/vec.h"
#include "measure/bvh.h"

#include <math.h>

/* A box of one tree: node `index` of a level, or leaf at level -1. Places are from the origin of tree b. */
typedef struct part {
    int level;
    size_t index;
    vv_bounds box;
} part;

typedef struct pair {
    double square;
    part a, b;
} pair;

typedef struct search {
    const vv_mesh_tree *a, *b;
    vv_vec3 shift; /* from the origin of a to that of b */
    double square;
    vv_vec3 on_a, on_b;
    size_t triangle_a, triangle_b; /* in the order of the trees */
    pair stack[16 * VVI_BVH_LEVELS + 16];
    int n;
} search;

static vv_bounds moved(vv_bounds b, vv_vec3 by)
{
    return (vv_bounds){vvi_add(b.lo, by), vvi_add(b.hi, by)};
}

static double gap(double lo_a, double hi_a, double lo_b, double hi_b)
{
    return lo_a > hi_b ? lo_a - hi_b : lo_b > hi_a ? lo_b - hi_a : 0;
}

static double boxes_square(const vv_bounds *a, const vv_bounds *b)
{
    const double x = gap(a->lo.x, a->hi.x, b->lo.x, b->hi.x), y = gap(a->lo.y, a->hi.y, b->lo.y, b->hi.y),
                 z = gap(a->lo.z, a->hi.z, b->lo.z, b->hi.z);
    return x * x + y * y + z * z;
}

static vvi_triangle triangle_of_a(const search *s, size_t index)
{
    const vvi_triangle t = vvi_bvh_triangle(s->a, index);
    return (vvi_triangle){vvi_add(t.a, s->shift), vvi_add(t.b, s->shift), vvi_add(t.c, s->shift)};
}

static void try_triangles(search *s, size_t i, size_t j)
{
    const vvi_triangle t = triangle_of_a(s, i), u = vvi_bvh_triangle(s->b, j);
    vv_vec3 p, q;
    const double square = vvi_triangles_square(&p, &q, &t, &u);
    if (square >= s->square)
        return;
    s->square = square;
    s->on_a = p;
    s->on_b = q;
    s->triangle_a = i;
    s->triangle_b = j;
}

static void try_leaves(search *s, size_t a, size_t b)
{
    for (size_t i = a * VVI_BVH_LEAF; i < (a + 1) * VVI_BVH_LEAF && i < s->a->n; i++)
        for (size_t j = b * VVI_BVH_LEAF; j < (b + 1) * VVI_BVH_LEAF && j < s->b->n; j++)
            try_triangles(s, i, j);
}

/* Pairs of the children of one side with the other, the nearest on top. */
static void split(search *s, const pair *p, bool split_a)
{
    const part *from = split_a ? &p->a : &p->b;
    const vvi_bvh_node *node = &(split_a ? s->a : s->b)->level[from->level][from->index];
    const int base = s->n;
    for (int c = 0; c < 8; c++) {
        if (node->lo[0][c] > node->hi[0][c])
            continue;
        pair q = *p;
        const vv_bounds box = vvi_bvh_child(node, c);
        *(split_a ? &q.a : &q.b) =
            (part){from->level - 1, 8 * from->index + (size_t)c, split_a ? moved(box, s->shift) : box};
        q.square = boxes_square(&q.a.box, &q.b.box);
        if (q.square >= s->square)
            continue;
        int at = s->n++;
        for (; at > base && s->stack[at - 1].square < q.square; at--)
            s->stack[at] = s->stack[at - 1];
        s->stack[at] = q;
    }
}

/* From somewhere to the nearest of the other surface and back, a few times: a good first guess. */
static void guess(search *s)
{
    size_t i = 0, j = 0;
    vv_vec3 p = triangle_of_a(s, 0).a;
    double square;
    for (int k = 0; k < 8; k++) {
        j = vvi_bvh_nearest(&square, s->b, p, j);
        vvi_triangle t = vvi_bvh_triangle(s->b, j);
        p = vvi_triangle_at(&t, vvi_nearest_weights(p, &t));
        i = vvi_bvh_nearest(&square, s->a, vvi_sub(p, s->shift), i);
        t = triangle_of_a(s, i);
        p = vvi_triangle_at(&t, vvi_nearest_weights(p, &t));
    }
    try_triangles(s, i, j);
}

static vv_status find(search *s, vv_job *job)
{
    enum { OFTEN = 4096 };
    const vv_bounds a = moved(s->a->box, s->shift), b = s->b->box;
    s->stack[0] = (pair){0, {s->a->n_levels - 1, 0, a}, {s->b->n_levels - 1, 0, b}};
    s->n = 1;
    for (size_t turn = 0; s->n > 0 && s->square > 0; turn++) {
        const pair p = s->stack[--s->n];
        if (p.square >= s->square)
            continue;
        if (p.a.level < 0 && p.b.level < 0)
            try_leaves(s, p.a.index, p.b.index);
        else
            split(s, &p, p.a.level > p.b.level || (p.a.level == p.b.level && turn % 2));
        if (turn % OFTEN == 0) {
            const vv_status st = vvi_job_poll(job);
            if (st != VV_OK)
                return st;
        }
    }
    return VV_OK;
}

static vv_mesh_foot foot_of(const vv_mesh_tree *tree, size_t triangle, vv_vec3 at, double distance)
{
    const vvi_triangle t = vvi_bvh_triangle(tree, triangle);
    const vv_vec3 w = vvi_nearest_weights(at, &t);
    return (vv_mesh_foot){.at = vvi_add(at, tree->origin),
                          .distance = distance,
                          .signed_distance = NAN,
                          .triangle = tree->order[triangle],
                          .weights = {w.x, w.y, w.z}};
}

vv_status vv_mesh_least_distance(vv_mesh_foot *on_a_out, vv_mesh_foot *on_b_out, const vv_mesh_tree *a,
                                 const vv_mesh_tree *b, vv_job *job)
{
    search s = {.a = a, .b = b, .shift = vvi_sub(a->origin, b->origin), .square = INFINITY};
    guess(&s);
    const vv_status st = find(&s, job);
    if (st != VV_OK)
        return st;
    *on_a_out = foot_of(a, s.triangle_a, vvi_sub(s.on_a, s.shift), sqrt(s.square));
    *on_b_out = foot_of(b, s.triangle_b, s.on_b, sqrt(s.square));
    return VV_OK;
}
