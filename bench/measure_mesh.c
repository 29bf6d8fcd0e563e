/* Times measures and distances of the Marching Cubes surface of a file in memory: measure_mesh FILE VALUE [RUNS]; one
 * JSON line each.
 */
#include "core/job.h"
#include "surface/marching.h"
#include "surface/simplify.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <volvis/volvis.h>

enum { MOST = 100 };

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static vv_status time_mass(const vv_mesh *mesh, bool sampled, int runs, vv_job *job)
{
    double seconds[MOST], processor[MOST];
    vv_mesh_measures m = {0};
    vv_mesh_measure_options o;
    vv_mesh_measure_options_init(&o, sizeof o);
    o.sampled = sampled;
    o.open = true;
    for (int i = -1; i < runs; i++) {
        const double before = now();
        const clock_t used = clock();
        const vv_status st = vv_mesh_measure(&m, mesh, &o, job);
        if (st != VV_OK)
            return st;
        if (i >= 0) {
            seconds[i] = now() - before;
            processor[i] = (double)(clock() - used) / CLOCKS_PER_SEC;
        }
    }
    qsort(seconds, (size_t)runs, sizeof *seconds, compare);
    qsort(processor, (size_t)runs, sizeof *processor, compare);
    printf("{\"what\": \"area and volume%s\", \"triangles\": %zu, \"n\": %d, \"median_s\": %.5f, \"min_s\": %.5f, "
           "\"cpu_s\": %.5f, "
           "\"area\": %.1f, \"volume\": %.1f, \"open_edges\": %zu}\n",
           sampled ? " with the chords' errors" : "", m.n_triangles, runs, seconds[runs / 2], seconds[0],
           processor[runs / 2], m.area.value, m.volume.value, m.n_open_edges);
    return VV_OK;
}

/* The tree of a mesh, the distance of points around it, and that of the mesh from itself, simplified. */
static vv_status time_tree(const vv_mesh *mesh, vv_job *job)
{
    enum { POINTS = 200000 };
    vv_mesh_tree *tree;
    const double before = now();
    const vv_status st = vv_mesh_tree_new(&tree, mesh, NULL, job);
    if (st != VV_OK)
        return st;
    const double made = now();
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
           made - before, POINTS, now() - made, sum / POINTS);
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
    double at = now();
    vv_status st = vvi_mesh_simplify(&simple, &result, mesh, &options, job);
    if (st != VV_OK)
        return st;
    printf("{\"what\": \"simplify to a tenth\", \"triangles\": %zu, \"error\": %.4f, \"s\": %.3f}\n",
           result.n_triangles, result.error, now() - at);
    if ((st = vv_mesh_tree_new(&a, mesh, NULL, job)) == VV_OK &&
        (st = vv_mesh_tree_new(&b, simple, NULL, job)) == VV_OK) {
        at = now();
        st = vv_mesh_distance(&d, a, b, NULL, job);
    }
    if (st == VV_OK)
        printf(
            "{\"what\": \"distance of the simplified mesh, both ways\", \"mean\": %.5f, \"rms\": %.5f, \"hausdorff\": "
            "%.5f, \"error\": %.5f, \"s\": %.3f}\n",
            d.a_to_b.mean.value, d.a_to_b.rms.value, d.hausdorff.value, d.hausdorff.error, now() - at);
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
        const double before = now();
        const vv_status st = vv_mesh_geodesic(&path, mesh, from, to, NULL, job);
        if (st != VV_OK)
            printf("{\"what\": \"path\", \"none\": \"%s\", \"s\": %.3f}\n", vv_error_last()->message, now() - before);
        else
            printf("{\"what\": \"path\", \"length\": %.3f, \"error\": %.3g, \"shortest\": %s, \"s\": %.3f}\n",
                   path.length.value, path.length.error, path.shortest ? "true" : "false", now() - before);
        vv_mesh_path_finish(&path);
    }
    return VV_OK;
}

static vv_status run(const char *path, double value, int runs, vv_job *job)
{
    const vvi_marching_options options = {.value = value, .cap = true};
    vv_file *file;
    vv_field *field;
    vv_mesh *mesh;
    vv_status st;
    if ((st = vv_file_open(&file, path, NULL, job)) != VV_OK)
        return st;
    st = vv_file_read(&field, file, 0, NULL, job);
    vv_file_close(file);
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
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_job *job;
    if (argc < 3) {
        fprintf(stderr, "usage: measure_mesh FILE VALUE [RUNS]\n");
        return 2;
    }
    vv_runtime_options_init(&options, sizeof options);
    if (vv_runtime_new(&runtime, &options) != VV_OK || vv_job_new(&job, runtime, NULL, NULL) != VV_OK)
        return 1;
    const int runs = argc > 3 ? atoi(argv[3]) : 15;
    const vv_status st = run(argv[1], atof(argv[2]), runs < 1 ? 1 : runs < MOST ? runs : MOST, job);
    if (st != VV_OK)
        fprintf(stderr, "%s\n", vv_error_last()->message);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return st != VV_OK;
}
