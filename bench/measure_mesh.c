/* Times measures and distances of the Marching Cubes surface of a file in memory: measure_mesh FILE VALUE [RUNS]; one
 * JSON line each.
 */
#include "bench.h"
#include "core/job.h"
#include "surface/marching.h"
#include "surface/simplify.h"

#include <stdio.h>
#include <stdlib.h>

static vv_status time_mass(const vv_mesh *mesh, bool sampled, int runs, vv_job *job)
{
    bench_times times = {0};
    vv_mesh_measures m = {0};
    vv_mesh_measure_options o;
    vv_mesh_measure_options_init(&o, sizeof o);
    o.sampled = sampled;
    o.open = true;
    for (int i = -1; i < runs; i++) {
        bench_begin(&times);
        const vv_status st = vv_mesh_measure(&m, mesh, &o, job);
        if (st != VV_OK)
            return st;
        bench_end(&times);
    }
    bench_sort(&times);
    printf("{\"what\": \"area and volume%s\", \"triangles\": %zu, \"n\": %d, \"median_s\": %.5f, \"min_s\": %.5f, "
           "\"cpu_s\": %.5f, "
           "\"area\": %.1f, \"volume\": %.1f, \"open_edges\": %zu}\n",
           sampled ? " with the chords' errors" : "", m.n_triangles, runs, times.seconds[runs / 2], times.seconds[0],
           times.processor[runs / 2], m.area.value, m.volume.value, m.n_open_edges);
    return VV_OK;
}

/* The tree of a mesh, the distance of points around it, and that of the mesh from itself, simplified. */
static vv_status time_tree(const vv_mesh *mesh, vv_job *job)
{
    enum { POINTS = 200000 };
    vv_mesh_tree *tree;
    const double before = bench_now();
    const vv_status st = vv_mesh_tree_new(&tree, mesh, NULL, job);
    if (st != VV_OK)
        return st;
    const double made = bench_now();
    const vv_bounds box = vv_mesh_bounds(mesh);
    uint64_t random = 1;
    double sum = 0;
    for (int i = 0; i < POINTS; i++) {
        vv_vec3 p;
        for (int a = 0; a < 3; a++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            const double lo = (&box.lo.x)[a], hi = (&box.hi.x)[a];
            (&p.x)[a] = lo + (hi - lo) * (double)(random >> 11) * 0x1p-53;
        }
        vv_mesh_foot foot;
        vv_mesh_tree_nearest(&foot, tree, p);
        sum += foot.signed_distance;
    }
    printf("{\"what\": \"tree\", \"s\": %.4f}\n{\"what\": \"points, one thread\", \"n\": %d, \"s\": %.4f, \"mean\": "
           "%.6f}\n",
           made - before, POINTS, bench_now() - made, sum / POINTS);
    vv_mesh_tree_release(tree);
    return VV_OK;
}

static vv_status time_distance(const vv_mesh *mesh, vv_job *job)
{
    const vvi_simplify_options options = {.triangles = vv_mesh_get_info(mesh)->n_triangles / 10};
    vvi_simplify_result result;
    vv_mesh *simple;
    vv_mesh_tree *a = NULL, *b = NULL;
    vv_mesh_distances d;
    double at = bench_now();
    vv_status st = vvi_mesh_simplify(&simple, &result, mesh, &options, job);
    if (st != VV_OK)
        return st;
    printf("{\"what\": \"simplify to a tenth\", \"triangles\": %zu, \"error\": %.4f, \"s\": %.3f}\n",
           result.n_triangles, result.error, bench_now() - at);
    if ((st = vv_mesh_tree_new(&a, mesh, NULL, job)) == VV_OK &&
        (st = vv_mesh_tree_new(&b, simple, NULL, job)) == VV_OK) {
        at = bench_now();
        st = vv_mesh_distance(&d, a, b, NULL, job);
    }
    if (st == VV_OK)
        printf(
            "{\"what\": \"distance of the simplified mesh, both ways\", \"mean\": %.5f, \"rms\": %.5f, \"hausdorff\": "
            "%.5f, \"error\": %.5f, \"s\": %.3f}\n",
            d.a_to_b.mean.value, d.a_to_b.rms.value, d.hausdorff.value, d.hausdorff.error, bench_now() - at);
    vv_mesh_tree_release(a);
    vv_mesh_tree_release(b);
    vv_mesh_release(simple);
    return st;
}

/* From the lowest corner of the box to the highest, and so on around. */
static vv_status time_paths(const vv_mesh *mesh, vv_job *job)
{
    const vv_bounds box = vv_mesh_bounds(mesh);
    for (int i = 0; i < 3; i++) {
        vv_vec3 from = box.lo, to = box.hi;
        vv_mesh_path path;
        (&from.x)[i] = (&box.hi.x)[i];
        (&to.x)[i] = (&box.lo.x)[i];
        const double before = bench_now();
        const vv_status st = vv_mesh_geodesic(&path, mesh, from, to, NULL, job);
        if (st != VV_OK)
            printf("{\"what\": \"path\", \"none\": \"%s\", \"s\": %.3f}\n", vv_error_last()->message,
                   bench_now() - before);
        else
            printf("{\"what\": \"path\", \"length\": %.3f, \"error\": %.3g, \"shortest\": %s, \"s\": %.3f}\n",
                   path.length.value, path.length.error, path.shortest ? "true" : "false", bench_now() - before);
        vv_mesh_path_finish(&path);
    }
    return VV_OK;
}

static vv_status run(int argc, char **argv, vv_job *job)
{
    const vvi_marching_options options = {.value = atof(argv[2]), .cap = true};
    const int runs = bench_runs(argc > 3 ? atoi(argv[3]) : 15);
    vv_field *field;
    vv_mesh *mesh;
    vv_status st = bench_read(&field, argv[1], job);
    if (st != VV_OK)
        return st;
    st = vvi_marching_cubes(&mesh, field, &options, job);
    vv_field_release(field);
    if (st != VV_OK)
        return st;
    if ((st = time_mass(mesh, false, runs, job)) == VV_OK)
        st = time_mass(mesh, true, runs, job);
    if (st == VV_OK && (st = time_tree(mesh, job)) == VV_OK && (st = time_distance(mesh, job)) == VV_OK)
        st = time_paths(mesh, job);
    vv_mesh_release(mesh);
    return st;
}

int main(int argc, char **argv)
{
    return bench_main(argc, argv, 2, "measure_mesh FILE VALUE [RUNS]", run);
}
