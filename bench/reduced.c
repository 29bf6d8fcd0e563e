/* The reduced representations of a surface beside the whole one: reduced FILE VALUE; a line of JSON for each. The
 * distance is that of every place of one to the other, in voxels. */
#include "surface/reduced.h"
#include "bench.h"
#include "surface/boxes.h"
#include "surface/marching.h"
#include "surface/tracking.h"

#include <stdio.h>
#include <stdlib.h>

static size_t mesh_bytes(const vv_mesh *mesh)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    return 24 * m->n_vertices + 12 * m->n_triangles;
}

static vv_status tell_distance(const vv_mesh *mesh, const vv_mesh_tree *whole, double voxel, vv_job *job)
{
    vv_mesh_tree *tree;
    vv_mesh_distances d;
    vv_mesh_distance_options options;
    vv_mesh_distance_options_init(&options, sizeof options);
    vv_status st = vv_mesh_tree_new(&tree, mesh, NULL, job);
    if (st != VV_OK)
        return st;
    if ((st = vv_mesh_distance(&d, tree, whole, &options, job)) == VV_OK)
        printf(", \"mean\": %.4f, \"rms\": %.4f, \"most\": %.3f, \"mean_back\": %.4f, \"most_back\": %.3f",
               d.a_to_b.mean.value / voxel, d.a_to_b.rms.value / voxel, d.a_to_b.max.value / voxel,
               d.b_to_a.mean.value / voxel, d.b_to_a.max.value / voxel);
    vv_mesh_tree_release(tree);
    return st;
}

static vv_status try_reduced(const vv_field *field, double value, int step, vvi_reduced_filter filter,
                             const vv_mesh_tree *whole, double voxel, vv_job *job)
{
    const vvi_reduced_options o = {.value = value, .step = step, .filter = filter};
    vvi_reduced *r;
    vv_mesh *mesh;
    const double begin = bench_now();
    vv_status st = vvi_reduced_make(&r, field, &o, job);
    if (st != VV_OK)
        return st;
    const double made = bench_now();
    if ((st = vvi_reduced_mesh(&mesh, r, job)) == VV_OK) {
        printf(
            "{\"what\": \"reduced %d%s\", \"bytes\": %zu, \"mesh_bytes\": %zu, \"triangles\": %zu, \"make_s\": %.4f, "
            "\"mesh_s\": %.4f",
            step, filter == VVI_REDUCED_KEEP_HIGH ? " keep" : "", vvi_reduced_bytes(r), mesh_bytes(mesh),
            r->n_triangles, made - begin, bench_now() - made);
        if (r->n_triangles)
            st = tell_distance(mesh, whole, voxel, job);
        printf("}\n");
        vv_mesh_release(mesh);
    }
    vvi_reduced_free(r);
    return st;
}

static vv_status try_boxes(const vv_field *field, double value, int shift, vv_job *job)
{
    for (int merged = 0; merged < 2; merged++) {
        const vvi_surface_boxes_options o = {.value = value, .shift = shift, .merged = merged};
        vv_mesh *mesh;
        const double begin = bench_now();
        const vv_status st = vvi_surface_boxes(&mesh, field, &o, job);
        if (st != VV_OK)
            return st;
        printf("{\"what\": \"boxes %d%s\", \"mesh_bytes\": %zu, \"triangles\": %zu, \"make_s\": %.4f}\n", 1 << shift,
               merged ? " merged" : "", mesh_bytes(mesh), vv_mesh_get_info(mesh)->n_triangles, bench_now() - begin);
        vv_mesh_release(mesh);
    }
    return VV_OK;
}

static vv_status try_all(const vv_field *field, double value, vv_job *job)
{
    const double voxel = vv_grid_voxel(&vv_field_get_info(field)->grid);
    const vvi_marching_options o = {.value = value};
    vv_mesh *mesh;
    vv_mesh_tree *whole = NULL;
    double begin = bench_now();
    vv_status st = vvi_marching_cubes(&mesh, field, &o, job);
    if (st != VV_OK)
        return st;
    printf("{\"what\": \"whole\", \"bytes\": %zu, \"triangles\": %zu, \"make_s\": %.4f}\n", mesh_bytes(mesh),
           vv_mesh_get_info(mesh)->n_triangles, bench_now() - begin);
    if (vv_mesh_get_info(mesh)->n_vertices) {
        const vv_mesh_info *m = vv_mesh_get_info(mesh);
        const float *p = m->positions + 3 * (m->n_vertices / 2);
        const vvi_tracking_options t = {
            .surface = o, .seed = {m->origin.x + (double)p[0], m->origin.y + (double)p[1], m->origin.z + (double)p[2]}};
        vv_mesh *piece;
        begin = bench_now();
        if ((st = vvi_track_surface(&piece, field, &t, job)) == VV_OK) {
            printf("{\"what\": \"tracked\", \"triangles\": %zu, \"make_s\": %.4f}\n",
                   vv_mesh_get_info(piece)->n_triangles, bench_now() - begin);
            vv_mesh_release(piece);
        }
    }
    for (int shift = 2; shift <= 4 && st == VV_OK; shift++)
        st = try_boxes(field, value, shift, job);
    if (st == VV_OK)
        st = vv_mesh_tree_new(&whole, mesh, NULL, job);
    vv_mesh_release(mesh);
    for (int step = 1; step <= 8 && st == VV_OK; step *= 2)
        for (int keep = 0; keep < (step > 1 ? 2 : 1) && st == VV_OK; keep++)
            st = try_reduced(field, value, step, keep ? VVI_REDUCED_KEEP_HIGH : VVI_REDUCED_SMOOTH, whole, voxel, job);
    vv_mesh_tree_release(whole);
    return st;
}

static vv_status run(int argc, char **argv, vv_job *job)
{
    vv_field *field;
    vv_status st = bench_read(&field, argv[1], job);
    if (st == VV_OK)
        st = try_all(field, atof(argv[2]), job);
    vv_field_release(field);
    return st;
}

int main(int argc, char **argv)
{
    return bench_main(argc, argv, 2, "reduced FILE VALUE", run);
}
