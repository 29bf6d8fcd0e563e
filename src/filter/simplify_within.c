#include "filter/simplify_within.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/simplify_attempts.h"
#include "filter/simplify_blocks.h"
#include "filter/simplify_share.h"
#include "measure/bvh.h"
#include "measure/far_triangles.h"

#include <math.h>

vv_status vvi_simplify_measure(vv_figure *out, const vv_mesh_tree *before, const vv_mesh_tree *after, vv_job *job)
{
    vv_mesh_distances distances;
    vv_mesh_distance_options options;
    vv_mesh_distance_options_init(&options, sizeof options);
    options.density = 1e-30; /* no samples: vertices, and the search for the bound between them */
    const vv_status st = vv_mesh_distance(&distances, before, after, &options, job);
    if (st == VV_OK)
        *out = distances.hausdorff;
    return st;
}

/* Distances of more than half the error are seen as they are: of one way, at some triangles. */
static vv_status sample_largest(vvi_attempts *a, const vv_mesh_tree *from, const vv_mesh_tree *to, vv_job *job)
{
    enum { ENOUGH = 8192 };
    vvi_beyond beyond = {.step = from->n / ENOUGH + 1};
    beyond.of = vvi_alloc(job, from->n * sizeof *beyond.of, VVI_MEM_SCRATCH);
    if (!beyond.of)
        return vv_fail_memory(from->n * sizeof *beyond.of);
    const vv_status st = vvi_mesh_beyond(&beyond, from, to, a->error, job);
    a->largest = fmax(a->largest, beyond.largest);
    vvi_free(beyond.of);
    return st;
}

/* Where all are less than half of it, they are measured. */
static vv_status measure(vv_figure *distance, vvi_attempts *a, vv_job *job)
{
    vv_status st = VV_OK;
    if (a->kept && a->largest <= 0 && (st = sample_largest(a, a->before, a->after, job)) == VV_OK)
        st = sample_largest(a, a->after, a->before, job);
    if (a->kept && a->largest > 0) {
        *distance = (vv_figure){.value = a->largest, .error = a->error - a->largest};
        return st;
    }
    if (st == VV_OK)
        st = vvi_simplify_measure(distance, a->before, a->after, job);
    if (st == VV_OK && a->kept)
        distance->error = fmin(distance->error, a->error - distance->value);
    return st;
}

static vv_status simplify(vvi_attempts *a, vv_job *job)
{
    double share = 1;
    vv_status st = vvi_simplify_find_share(&share, a->before, &a->options, job);
    if (st != VV_OK)
        return st;
    a->options.error *= share;
    a->options.uncounted = true;
    if (!vvi_simplify_is_large(a->before->n) || a->options.triangles)
        return vvi_simplify_attempts(a, job);
    st = vvi_simplify_in_blocks(a, job);
    return st == VV_OK && a->result.n_triangles > 0 ? vvi_bvh_new(&a->after, a->out, job) : st;
}

static vv_status tell(vvi_simplify_told *told, vvi_attempts *a, vv_job *job)
{
    told->distance = (vv_figure){.value = INFINITY, .error = 0};
    vv_status st =
        vvi_simplify_count_pieces(&a->result, vv_mesh_get_info(a->mesh), vv_mesh_get_info(a->out), a->corners, job);
    told->result = a->result;
    if (st == VV_OK && a->after)
        st = measure(&told->distance, a, job);
    return st;
}

vv_status vvi_simplify_within(vv_mesh **out, vvi_simplify_told *told, const vv_mesh *mesh,
                              const vvi_simplify_options *options, vv_job *job)
{
    vvi_attempts a = {.mesh = mesh, .options = *options, .error = options->error};
    vv_mesh_tree *before = NULL;
    vv_status st = vvi_bvh_new(&before, mesh, job);
    a.before = before;
    *out = NULL;
    if (st == VV_OK && (st = simplify(&a, job)) == VV_OK && (st = tell(told, &a, job)) == VV_OK) {
        *out = a.out;
        a.out = NULL;
    }
    vvi_attempts_finish(&a);
    vv_mesh_tree_release(before);
    return st;
}
