/* The quadric error of a collapse is an average over planes, and the distance mostly less than that; sometimes it is
 * more. With all of the error many places have to be put back as they were, with little of it many triangles stay. */
#include "filter/simplify_share.h"
#include "core/memory.h"
#include "grid/mesh.h"
#include "measure/far_triangles.h"

#include <math.h>
#include <string.h>

typedef struct trial {
    vv_mesh_tree *before;
    vvi_simplify_options options;
    double error;
    uint32_t *beyond; /* of each triangle */
    vv_job *job;
} trial;

/* Patches -----------------------------------------------------------------------------------------------------------
 */

/* Triangle k of the patches: neighbours follow one another in the order of the tree. */
static const uint32_t *triangle_of(const vv_mesh_tree *tree, size_t k, size_t each, size_t n_patches)
{
    const size_t first = n_patches > 1 ? (k / each) * ((tree->n - each) / (n_patches - 1)) : 0;
    return vv_mesh_get_info(tree->mesh)->triangles + 3 * (size_t)tree->order[first + k % each];
}

vv_status vvi_mesh_patches(vv_mesh **out, const vv_mesh_tree *tree, size_t n, size_t n_patches, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(tree->mesh);
    const size_t each = (n < tree->n ? n : tree->n) / n_patches;
    vv_mesh_info info = {.n_triangles = each * n_patches, .origin = m->origin};
    vvi_mesh_arrays a;
    uint32_t *number = vvi_alloc(job, (m->n_vertices + 1) * sizeof *number, VVI_MEM_SCRATCH);
    *out = NULL;
    if (!number)
        return vv_fail_memory(m->n_vertices * sizeof *number);
    memset(number, 0xff, m->n_vertices * sizeof *number);
    for (size_t k = 0; k < 3 * info.n_triangles; k++) {
        const uint32_t v = triangle_of(tree, k / 3, each, n_patches)[k % 3];
        if (number[v] == UINT32_MAX)
            number[v] = (uint32_t)info.n_vertices++;
    }
    const vv_status st = vvi_mesh_new(out, &a, &info, 0, job);
    for (size_t k = 0; st == VV_OK && k < 3 * info.n_triangles; k++) {
        const uint32_t v = triangle_of(tree, k / 3, each, n_patches)[k % 3];
        a.triangles[k] = number[v];
        memcpy(a.positions + 3 * (size_t)number[v], m->positions + 3 * (size_t)v, 3 * sizeof *a.positions);
    }
    vvi_free(number);
    return st;
}

/* Trials ------------------------------------------------------------------------------------------------------------
 */

static vv_status add_beyond(size_t *n, const trial *t, const vv_mesh_tree *a, const vv_mesh_tree *b)
{
    enum { ENOUGH = 8192 };
    vvi_beyond beyond = {.of = t->beyond, .step = t->before->n / ENOUGH + 1};
    const vv_status st = vvi_mesh_beyond(&beyond, a, b, t->error, t->job);
    *n += beyond.n * beyond.step;
    return st;
}

/* How many triangles there would be in the end, about: what is put back is as fine as it was, and what is around it has
 * to become as coarse as the rest. */
static double foresee(const trial *t, size_t n, size_t n_beyond)
{
    const double ratio = (double)t->before->n / (double)n;
    return (double)n + fmax(4, ratio / 2) * (double)n_beyond;
}

/* Of many triangles, some tell how many have moved too far. */
static vv_status try_share(double *n_out, trial *t, double share)
{
    vvi_simplify_result result;
    vv_mesh *mesh = NULL;
    vv_mesh_tree *after = NULL;
    size_t n_beyond = 0;
    t->options.error = share * t->error;
    vv_status st = vvi_mesh_simplify(&mesh, &result, t->before->mesh, &t->options, t->job);
    if (st == VV_OK && result.n_triangles > 0 && (st = vvi_bvh_new(&after, mesh, t->job)) == VV_OK &&
        (st = add_beyond(&n_beyond, t, t->before, after)) == VV_OK &&
        (st = add_beyond(&n_beyond, t, after, t->before)) == VV_OK)
        *n_out = foresee(t, result.n_triangles, n_beyond);
    vv_mesh_tree_release(after);
    vv_mesh_release(mesh);
    return st;
}

/* Less or more of it, as long as that leaves fewer triangles. */
static vv_status go(double *share, double *least, trial *t, double factor)
{
    vv_status st = VV_OK;
    double n = INFINITY;
    for (double next = *share * factor; next > 0.1 && next < 1.01; next *= factor) {
        if ((st = try_share(&n, t, next)) != VV_OK || n >= *least)
            break;
        *share = next;
        *least = n;
    }
    return st;
}

static vv_status find(double *share, trial *t)
{
    const double less = 0.7, first = less * less;
    double least = INFINITY;
    *share = first;
    vv_status st = try_share(&least, t, first);
    if (st == VV_OK && (st = go(share, &least, t, less)) == VV_OK && *share == first)
        st = go(share, &least, t, 1 / less);
    return st;
}

vv_status vvi_simplify_find_share(double *out, const vv_mesh_tree *mesh, const vvi_simplify_options *options,
                                  vv_job *job)
{
    enum { MANY = 1 << 16, PATCHES = 8 };
    trial t = {.before = vv_mesh_tree_retain(mesh), .options = *options, .error = options->error, .job = job};
    vv_mesh *patches = NULL;
    vv_status st = VV_OK;
    t.options.corners = NULL;
    t.options.still = NULL;
    if (mesh->n > 2 * MANY && (st = vvi_mesh_patches(&patches, mesh, MANY, PATCHES, job)) == VV_OK) {
        vv_mesh_tree_release(t.before);
        st = vvi_bvh_new(&t.before, patches, job);
        t.options.fix_border = true;
        t.options.triangles = options->triangles * MANY / mesh->n;
    }
    if (st == VV_OK && !(t.beyond = vvi_alloc(job, t.before->n * sizeof *t.beyond, VVI_MEM_SCRATCH)))
        st = vv_fail_memory(t.before->n * sizeof *t.beyond);
    if (st == VV_OK)
        st = find(out, &t);
    vvi_free(t.beyond);
    vv_mesh_tree_release(t.before);
    vv_mesh_release(patches);
    return st;
}
