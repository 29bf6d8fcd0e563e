#include "measure/bvh.h"
#include "core/job.h"
#include "core/memory.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { BLOCK = 1 << 13, KEY_BITS = 10, DIGIT = 1 << KEY_BITS };

/* A tree that is being made. */
typedef struct maker {
    vv_mesh_tree *tree;
    const vv_mesh_info *mesh;
    vv_job *job;
    uint32_t *key[2], *index[2]; /* of triangles, by key in the end */
    int to;                      /* level that is being filled */
} maker;

static size_t ceil_div(size_t a, size_t b)
{
    return a / b + (a % b != 0);
}

/* Places ------------------------------------------------------------------------------------------------------------
 */

/* From the origin. */
static void place_of(float out[3], const vv_mesh_tree *t, const vv_mesh_info *m, size_t vertex)
{
    const float *p = m->positions + 3 * vertex;
    if (t->kept_places) {
        memcpy(out, p, 3 * sizeof *out);
        return;
    }
    const vv_vec3 w = vv_affine_point(t->map, vvi_vec((double)p[0], (double)p[1], (double)p[2]));
    out[0] = (float)(w.x - t->origin.x);
    out[1] = (float)(w.y - t->origin.y);
    out[2] = (float)(w.z - t->origin.z);
}

vv_vec3 vvi_bvh_vertex(const vv_mesh_tree *tree, size_t v)
{
    float p[3];
    place_of(p, tree, vv_mesh_get_info(tree->mesh), v);
    return vvi_vec((double)p[0], (double)p[1], (double)p[2]);
}

vvi_triangle vvi_bvh_triangle(const vv_mesh_tree *tree, size_t index)
{
    const float *p = tree->corners + 9 * index;
    return (vvi_triangle){{(double)p[0], (double)p[1], (double)p[2]},
                          {(double)p[3], (double)p[4], (double)p[5]},
                          {(double)p[6], (double)p[7], (double)p[8]}};
}

/* Order along the curve ---------------------------------------------------------------------------------------------
 */

/* Skilling 2004: place on the Hilbert curve through 2^10 cells an axis. */
static uint32_t hilbert(uint32_t x[3])
{
    const uint32_t top = 1u << (KEY_BITS - 1);
    for (uint32_t q = top; q > 1; q >>= 1)
        for (int i = 0; i < 3; i++) {
            const uint32_t t = (x[0] ^ x[i]) & (q - 1);
            if (x[i] & q) {
                x[0] ^= q - 1;
            } else {
                x[0] ^= t;
                x[i] ^= t;
            }
        }
    x[1] ^= x[0];
    x[2] ^= x[1];
    uint32_t t = 0, key = 0;
    for (uint32_t q = top; q > 1; q >>= 1)
        t ^= x[2] & q ? q - 1 : 0;
    for (int bit = KEY_BITS - 1; bit >= 0; bit--)
        for (int i = 0; i < 3; i++)
            key = key << 1 | ((x[i] ^ t) >> bit & 1);
    return key;
}

static vv_status key_item(void *scratch, void *shared, size_t item)
{
    (void)scratch;
    const maker *m = shared;
    const vv_bounds *box = &m->tree->box;
    const size_t end = (item + 1) * BLOCK < m->tree->n ? (item + 1) * BLOCK : m->tree->n;
    for (size_t i = item * BLOCK; i < end; i++) {
        float p[3][3];
        uint32_t x[3];
        for (size_t c = 0; c < 3; c++)
            place_of(p[c], m->tree, m->mesh, m->mesh->triangles[3 * i + c]);
        for (int a = 0; a < 3; a++) {
            const double lo = (&box->lo.x)[a], size = (&box->hi.x)[a] - lo;
            const double middle = ((double)p[0][a] + (double)p[1][a] + (double)p[2][a]) / 3;
            const double cell = size > 0 ? (middle - lo) / size * DIGIT : 0;
            x[a] = cell < 0 ? 0 : cell < DIGIT ? (uint32_t)cell : DIGIT - 1;
        }
        m->key[0][i] = hilbert(x);
        m->index[0][i] = (uint32_t)i;
    }
    return VV_OK;
}

/* By 10 bits of the keys at a time, least first: stable. The result is in [1]. */
static void sort_by_key(maker *m)
{
    for (int pass = 0; pass < 3; pass++) {
        const uint32_t *key = m->key[pass % 2], *index = m->index[pass % 2];
        uint32_t *key_to = m->key[1 - pass % 2], *index_to = m->index[1 - pass % 2];
        const int shift = KEY_BITS * pass;
        size_t at[DIGIT + 1] = {0};
        for (size_t i = 0; i < m->tree->n; i++)
            at[(key[i] >> shift & (DIGIT - 1)) + 1]++;
        for (int d = 0; d < DIGIT; d++)
            at[d + 1] += at[d];
        for (size_t i = 0; i < m->tree->n; i++) {
            const size_t to = at[key[i] >> shift & (DIGIT - 1)]++;
            key_to[to] = key[i];
            index_to[to] = index[i];
        }
    }
}

/* Nodes -------------------------------------------------------------------------------------------------------------
 */

static void clear_child(vvi_bvh_node *node, int c)
{
    for (int a = 0; a < 3; a++) {
        node->lo[a][c] = INFINITY;
        node->hi[a][c] = -INFINITY;
    }
}

static void widen_child(vvi_bvh_node *node, int c, const float lo[3], const float hi[3])
{
    for (int a = 0; a < 3; a++) {
        node->lo[a][c] = lo[a] < node->lo[a][c] ? lo[a] : node->lo[a][c];
        node->hi[a][c] = hi[a] > node->hi[a][c] ? hi[a] : node->hi[a][c];
    }
}

static void fill_leaf(const maker *m, vvi_bvh_node *node, int c, size_t leaf)
{
    vv_mesh_tree *t = m->tree;
    for (size_t i = leaf * VVI_BVH_LEAF; i < (leaf + 1) * VVI_BVH_LEAF && i < t->n; i++) {
        t->order[i] = m->index[1][i];
        for (size_t k = 0; k < 3; k++) {
            float *p = t->corners + 9 * i + 3 * k;
            place_of(p, t, m->mesh, m->mesh->triangles[3 * (size_t)t->order[i] + k]);
            widen_child(node, c, p, p);
        }
    }
}

static void fill_from_below(vvi_bvh_node *node, int c, const vvi_bvh_node *child)
{
    for (int k = 0; k < 8; k++) {
        const float lo[3] = {child->lo[0][k], child->lo[1][k], child->lo[2][k]};
        const float hi[3] = {child->hi[0][k], child->hi[1][k], child->hi[2][k]};
        widen_child(node, c, lo, hi);
    }
}

enum { NODES = 256 }; /* to an item */

static vv_status node_item(void *scratch, void *shared, size_t item)
{
    (void)scratch;
    const maker *m = shared;
    vv_mesh_tree *t = m->tree;
    const size_t n = t->n_nodes[m->to], end = (item + 1) * NODES < n ? (item + 1) * NODES : n;
    for (size_t i = item * NODES; i < end; i++)
        for (int c = 0; c < 8; c++) {
            const size_t child = 8 * i + (size_t)c;
            clear_child(&t->level[m->to][i], c);
            if (m->to == 0)
                fill_leaf(m, &t->level[0][i], c, child);
            else if (child < t->n_nodes[m->to - 1])
                fill_from_below(&t->level[m->to][i], c, &t->level[m->to - 1][child]);
        }
    return VV_OK;
}

static vv_status make_levels(maker *m)
{
    const vvi_work work = {.item = node_item};
    vv_mesh_tree *t = m->tree;
    vv_status st = VV_OK;
    size_t children = ceil_div(t->n, VVI_BVH_LEAF);
    do {
        const size_t n = ceil_div(children, 8);
        m->to = t->n_levels;
        t->level[m->to] = vvi_alloc(m->job, n * sizeof *t->level[0], VVI_MEM_DERIVED);
        if (!t->level[m->to])
            return vv_fail_memory(n * sizeof *t->level[0]);
        t->n_nodes[m->to] = n;
        t->n_levels++;
        st = vvi_parallel_for(m->job, &work, m, ceil_div(n, NODES));
        children = n;
    } while (children > 1 && st == VV_OK);
    return st;
}

/* Life --------------------------------------------------------------------------------------------------------------
 */

/* Places that need no rounding are kept. */
static void settle(vv_mesh_tree *t, vv_affine to_world, vv_bounds b)
{
    const vv_mesh_info *m = vv_mesh_get_info(t->mesh);
    const vv_affine placed = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .origin = m->origin};
    t->map = vv_affine_compose(to_world, placed);
    t->n = m->n_triangles;
    t->kept_places = true;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            t->kept_places &= (&t->map.axis[i].x)[j] == (i == j);
    t->origin = t->kept_places ? t->map.origin : vvi_between(b.lo, b.hi, .5);
    t->box = (vv_bounds){vvi_sub(b.lo, t->origin), vvi_sub(b.hi, t->origin)};
    t->radius = fmax(vvi_length(t->box.lo), vvi_length(t->box.hi));
}

static vv_status fail_empty(void)
{
    return vv_fail(VV_E_ARGUMENT, "the mesh has no triangles; there are no distances to it");
}

/* Box, area and whether it is closed. */
static vv_status look_at(vv_mesh_tree *t, const vv_affine *to_world, vv_job *job)
{
    vv_mesh_measures measures;
    vv_mesh_measure_options o;
    vv_mesh_measure_options_init(&o, sizeof o);
    o.open = true;
    if (to_world)
        o.to_world = *to_world;
    const vv_status st = vv_mesh_measure(&measures, t->mesh, &o, job);
    if (st != VV_OK)
        return st;
    if (vv_mesh_get_info(t->mesh)->n_triangles == 0)
        return fail_empty();
    settle(t, o.to_world, measures.bounds);
    t->closed = measures.closed;
    t->inside_out = measures.inside_out != (vv_affine_determinant(t->map) < 0);
    t->area = measures.area.value;
    return VV_OK;
}

/* The same where it counts as open. */
static vv_status glance_at(vv_mesh_tree *t)
{
    const vv_affine as_it_is = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    const vv_mesh_info *m = vv_mesh_get_info(t->mesh);
    double known = 0;
    for (size_t i = 0; i < 3 * m->n_vertices; i++)
        known += (double)m->positions[i] * 0;
    if (known != 0) /* infinities and what is no number times 0 */
        return vv_fail(VV_E_ARGUMENT, "a vertex of the mesh is not finite; it has no distances");
    if (m->n_triangles == 0)
        return fail_empty();
    settle(t, as_it_is, vv_mesh_bounds(t->mesh));
    for (size_t i = 0; i < 3 * t->n; i += 3) {
        const vv_vec3 a = vvi_bvh_vertex(t, m->triangles[i]);
        const vv_vec3 ab = vvi_sub(vvi_bvh_vertex(t, m->triangles[i + 1]), a),
                      ac = vvi_sub(vvi_bvh_vertex(t, m->triangles[i + 2]), a), n = vvi_cross(ab, ac);
        t->area += sqrt(vvi_dot(n, n)) / 2;
    }
    return VV_OK;
}

static vv_status make(maker *m)
{
    const vvi_work work = {.stage = "tree", .item = key_item};
    vv_mesh_tree *t = m->tree;
    bool all = true;
    for (int i = 0; i < 2; i++) {
        m->key[i] = vvi_alloc(m->job, t->n * sizeof *m->key[i], VVI_MEM_SCRATCH);
        m->index[i] = vvi_alloc(m->job, t->n * sizeof *m->index[i], VVI_MEM_SCRATCH);
        all &= m->key[i] && m->index[i];
    }
    t->corners = vvi_alloc(m->job, 9 * t->n * sizeof *t->corners, VVI_MEM_DERIVED);
    t->order = vvi_alloc(m->job, t->n * sizeof *t->order, VVI_MEM_DERIVED);
    if (!all || !t->corners || !t->order)
        return vv_fail_memory(9 * t->n * sizeof *t->corners);
    const vv_status st = vvi_parallel_for(m->job, &work, m, ceil_div(t->n, BLOCK));
    if (st != VV_OK)
        return st;
    sort_by_key(m);
    return make_levels(m);
}

/* `signs`: it will be asked on which side of it something lies. */
static vv_status new_tree(vv_mesh_tree **out, const vv_mesh *mesh, const vv_affine *to_world, bool signs, vv_job *job)
{
    *out = NULL;
    vv_mesh_tree *t = vvi_alloc_zeroed(job, sizeof *t, VVI_MEM_DERIVED);
    if (!t)
        return vv_fail_memory(sizeof *t);
    maker m = {.tree = t, .mesh = vv_mesh_get_info(mesh), .job = job};
    atomic_init(&t->references, 1);
    t->mesh = vv_mesh_retain(mesh);
    vv_status st = signs ? look_at(t, to_world, job) : glance_at(t);
    if (st == VV_OK)
        st = make(&m);
    for (int i = 0; i < 2; i++) {
        vvi_free(m.key[i]);
        vvi_free(m.index[i]);
    }
    if (st == VV_OK)
        *out = t;
    else
        vv_mesh_tree_release(t);
    return st;
}

vv_status vv_mesh_tree_new(vv_mesh_tree **out, const vv_mesh *mesh, const vv_affine *to_world, vv_job *job)
{
    return new_tree(out, mesh, to_world, true, job);
}

vv_status vvi_bvh_new(vv_mesh_tree **out, const vv_mesh *mesh, vv_job *job)
{
    return new_tree(out, mesh, NULL, false, job);
}

vv_mesh_tree *vv_mesh_tree_retain(const vv_mesh_tree *tree)
{
    vv_mesh_tree *t = (vv_mesh_tree *)tree; /* only the count changes */
    atomic_fetch_add_explicit(&t->references, 1, memory_order_relaxed);
    return t;
}

void vv_mesh_tree_release(vv_mesh_tree *t)
{
    if (!t || atomic_fetch_sub_explicit(&t->references, 1, memory_order_acq_rel) != 1)
        return;
    for (int i = 0; i < t->n_levels; i++)
        vvi_free(t->level[i]);
    vvi_free(t->corners);
    vvi_free(t->order);
    vv_mesh_release(t->mesh);
    vvi_free(t);
}

bool vv_mesh_tree_closed(const vv_mesh_tree *tree)
{
    return tree->closed;
}

/* Asking ------------------------------------------------------------------------------------------------------------
 */

vv_bounds vvi_bvh_child(const vvi_bvh_node *n, int c)
{
    return (vv_bounds){vvi_vec((double)n->lo[0][c], (double)n->lo[1][c], (double)n->lo[2][c]),
                       vvi_vec((double)n->hi[0][c], (double)n->hi[1][c], (double)n->hi[2][c])};
}

/* A node that may hold something nearer. */
typedef struct visit {
    float square;
    int level; /* -1: a leaf */
    size_t index;
} visit;

typedef float four __attribute__((vector_size(16)));
typedef int32_t four_masks __attribute__((vector_size(16)));

static four load_four(const float *p)
{
    four v;
    memcpy(&v, p, sizeof v);
    return v;
}

static four positive(four v)
{
    return (four)((four_masks)v & (v > 0));
}

/* No place is beyond both ends of a box but of an empty one, which is infinitely far from either. */
static void box_squares(float out[8], const vvi_bvh_node *n, const float p[3])
{
    for (int half = 0; half < 8; half += 4) {
        four sum = {0};
        for (int a = 0; a < 3; a++) {
            const four d = positive(load_four(n->lo[a] + half) - p[a]) + positive(p[a] - load_four(n->hi[a] + half));
            sum += d * d;
        }
        memcpy(out + half, &sum, sizeof sum);
    }
}

/* Boxes are compared in floats: they count as that much nearer than they seem. */
static float limit_of(double square, double slack)
{
    const double d = sqrt(square) + slack;
    return (float)(d * d * (1 + 4 * (double)FLT_EPSILON));
}

/* Children of a node that are near enough, the nearest last. */
static int push_children(visit *stack, int n, const vvi_bvh_node *node, const float p[3], float limit, int level,
                         size_t first)
{
    float square[8];
    const int base = n;
    box_squares(square, node, p);
    for (int c = 0; c < 8; c++) {
        if (!(square[c] <= limit))
            continue;
        int at = n++;
        for (; at > base && stack[at - 1].square < square[c]; at--)
            stack[at] = stack[at - 1];
        stack[at] = (visit){square[c], level, first + (size_t)c};
    }
    return n;
}

size_t vvi_bvh_within(double *square_out, const vv_mesh_tree *tree, vv_vec3 p, double enough, size_t hint)
{
    const float f[3] = {(float)p.x, (float)p.y, (float)p.z};
    const double slack = 4 * (double)FLT_EPSILON * (sqrt(vvi_dot(p, p)) + tree->radius);
    visit stack[8 * VVI_BVH_LEVELS + 8];
    int n = 1;
    size_t best = hint;
    vvi_triangle t = vvi_bvh_triangle(tree, hint);
    double square = vvi_triangle_square(p, &t);
    float limit = limit_of(square, slack);
    stack[0] = (visit){0, tree->n_levels - 1, 0};
    while (n > 0 && square > enough) {
        const visit v = stack[--n];
        if (v.square > limit)
            continue;
        if (v.level >= 0) {
            n = push_children(stack, n, &tree->level[v.level][v.index], f, limit, v.level - 1, 8 * v.index);
            continue;
        }
        for (size_t i = v.index * VVI_BVH_LEAF; i < (v.index + 1) * VVI_BVH_LEAF && i < tree->n; i++) {
            t = vvi_bvh_triangle(tree, i);
            const double s = vvi_triangle_square(p, &t);
            if (s < square) {
                square = s;
                best = i;
                limit = limit_of(square, slack);
            }
        }
    }
    *square_out = square;
    return best;
}

size_t vvi_bvh_nearest(double *square_out, const vv_mesh_tree *tree, vv_vec3 p, size_t hint)
{
    return vvi_bvh_within(square_out, tree, p, 0, hint);
}
