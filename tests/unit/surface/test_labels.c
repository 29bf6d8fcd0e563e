/* Surfaces of labels: closed, smooth, with the volume that their voxels have, and nothing between neighbours. */
#include "fail_alloc.h"
#include "fields.h"
#include "grid/field.h"
#include "jobs.h"
#include "meshes.h"
#include "surface/labels.h"
#include "surface/pieces.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <volvis/file.h>

#include <cmocka.h>

static void assert_within(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("%.6g is not within %g of %.6g", found, tolerance, expected);
}

typedef double label_fn(int64_t i, int64_t j, int64_t k);

static vv_field *labels_of(label_fn *label, int64_t nx, int64_t ny, int64_t nz, vv_type type)
{
    vv_field_info info = vv_field_info_default();
    vv_field *f;
    void *samples;
    info.grid.dims[0] = nx, info.grid.dims[1] = ny, info.grid.dims[2] = nz;
    info.type = type;
    info.meaning = vv_type_is_float(type) ? VV_MEANING_SCALAR : VV_MEANING_LABEL;
    assert_int_equal(vv_field_new_empty(&f, &samples, &info, NULL), VV_OK);
    for (int64_t k = 0, at = 0; k < nz; k++)
        for (int64_t j = 0; j < ny; j++)
            for (int64_t i = 0; i < nx; i++, at++) {
                const double v = label(i, j, k);
                vvi_samples_from_f64((char *)samples + (size_t)at * vv_type_bytes(type), &v, type, 1);
            }
    return f;
}

/* The mesh of one part. */
static double part_volume(const vv_mesh *mesh, size_t part)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    double sum = 0;
    for (size_t t = m->parts[part].first_triangle; t < m->parts[part].first_triangle + m->parts[part].n_triangles;
         t++) {
        vv_vec3 p[3];
        for (size_t i = 0; i < 3; i++)
            p[i] = test_mesh_vertex(mesh, m->triangles[3 * t + i]);
        sum += (p[0].x * (p[1].y * p[2].z - p[1].z * p[2].y) + p[0].y * (p[1].z * p[2].x - p[1].x * p[2].z) +
                p[0].z * (p[1].x * p[2].y - p[1].y * p[2].x)) /
               6;
    }
    return sum;
}

static double ball_radius;

static double balls(int64_t i, int64_t j, int64_t k)
{
    const double c = ball_radius + 3, x = (double)i - c - .2, y = (double)j - c + .3, z = (double)k - c - .1;
    const double r = sqrt(x * x + y * y + z * z);
    return r <= ball_radius ? 300 : 0;
}

static void a_ball_is_smooth_and_as_large_as_its_voxels(void **state)
{
    (void)state;
    static const double table[][3] = {
        {4, 3.5, 4.5}, {8, 1.5, 2}, {16, .5, 1.5}}; /* radius; most percent of volume, of area */
    for (int i = 0; i < 3; i++) {
        ball_radius = table[i][0];
        const int64_t n = 2 * (int64_t)ball_radius + 7;
        vv_field *f = labels_of(balls, n, n, n, VV_TYPE_U16);
        size_t voxels = 0;
        for (int64_t v = 0; v < n * n * n; v++)
            voxels += balls(v % n, v / n % n, v / n / n) != 0;
        const vvi_labels_options o = {.smoothing = 1}, steps = {.smoothing = 0};
        vv_mesh *mesh, *rough;
        assert_int_equal(vvi_label_surfaces(&mesh, f, 0, &o, NULL), VV_OK);
        assert_int_equal(vvi_label_surfaces(&rough, f, 0, &steps, NULL), VV_OK);
        const vv_mesh_info *m = vv_mesh_get_info(mesh);
        const double volume = test_mesh_volume(mesh), area = 4 * M_PI * ball_radius * ball_radius;
        print_message("R=%g: volume %+.2f %% of the voxels', area %+.2f %% (in steps %+.2f %%)\n", ball_radius,
                      100 * (volume / (double)voxels - 1), 100 * (test_mesh_area(mesh) / area - 1),
                      100 * (test_mesh_area(rough) / area - 1));
        assert_int_equal(m->n_parts, 1);
        assert_string_equal(m->parts[0].name, "label 300");
        assert_int_equal(test_mesh_bad_edges(mesh), 0);
        assert_int_equal(test_mesh_euler(mesh), 2);
        assert_within(100 * (volume / (double)voxels - 1), 0, table[i][1]);
        assert_within(100 * (test_mesh_area(mesh) / area - 1), 0, table[i][2]);
        assert_true(test_mesh_area(rough) > 1.02 * test_mesh_area(mesh));
        vv_mesh_release(mesh);
        vv_mesh_release(rough);
        vv_field_release(f);
    }
}

enum { SEEDS = 14, SIDE = 33 };

static double voronoi(int64_t i, int64_t j, int64_t k)
{
    double least = INFINITY;
    int best = 0;
    for (int s = 0; s < SEEDS; s++) {
        double d = 0;
        const double at[3] = {(double)i, (double)j, (double)k};
        for (int a = 0; a < 3; a++) {
            const double to = at[a] - (SIDE - 1) * test_random_unit(5, (uint64_t)(3 * s + a));
            d += to * to;
        }
        best = d < least ? s : best;
        least = fmin(d, least);
    }
    return 1000 - 7 * best;
}

/* Vertices of other parts at the same place. */
static size_t count_lonely(const vv_mesh *mesh)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    size_t lonely = 0, looked_at = 0;
    for (size_t v = 0; v < m->n_vertices; v += 7) {
        const vv_vec3 p = test_mesh_vertex(mesh, v);
        if (fmin(fmin(p.x, p.y), p.z) < 0 || fmax(fmax(p.x, p.y), p.z) > SIDE - 1)
            continue;
        size_t same = 0;
        for (size_t u = 0; u < m->n_vertices; u++) {
            const float *a = m->positions + 3 * v, *b = m->positions + 3 * u;
            same += u != v && fabsf(a[0] - b[0]) + fabsf(a[1] - b[1]) + fabsf(a[2] - b[2]) < 1e-4f;
        }
        looked_at++;
        lonely += same == 0;
    }
    assert_true(looked_at > 500);
    return looked_at ? 100 * lonely / looked_at : 0;
}

static double nothing_else(int64_t i, int64_t j, int64_t k)
{
    (void)i;
    (void)j;
    (void)k;
    return 5;
}

static void neighbours_share_their_border(void **state)
{
    (void)state;
    vv_field *f = labels_of(voronoi, SIDE, SIDE, SIDE, VV_TYPE_I32),
             *one = labels_of(nothing_else, SIDE, SIDE, SIDE, VV_TYPE_U8);
    const vvi_labels_options o = {.smoothing = 1};
    vv_mesh *mesh, *whole;
    double sum = 0;
    assert_int_equal(vvi_label_surfaces(&mesh, f, 0, &o, NULL), VV_OK);
    assert_int_equal(vvi_label_surfaces(&whole, one, 0, &o, NULL), VV_OK);
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    assert_int_equal(m->n_parts, SEEDS);
    assert_int_equal(test_mesh_bad_edges(mesh), 0);
    size_t counts[SEEDS] = {0};
    for (int64_t v = 0; v < SIDE * SIDE * SIDE; v++)
        counts[(1000 - (int)voronoi(v % SIDE, v / SIDE % SIDE, v / SIDE / SIDE)) / 7]++;
    for (size_t p = 0; p < m->n_parts; p++) {
        const double volume = part_volume(mesh, p), voxels = (double)counts[SEEDS - 1 - p];
        print_message("%s: %.0f voxels, volume %+.2f %%\n", m->parts[p].name, voxels, 100 * (volume / voxels - 1));
        assert_within(volume / voxels, 1, .1);
        sum += volume;
    }
    print_message("all: %+.3f %% of the whole; %zu %% of vertices without partner\n",
                  100 * (sum / test_mesh_volume(whole) - 1), count_lonely(mesh));
    assert_within(sum / test_mesh_volume(whole), 1, .01); /* a little is missing along the lines where three meet */
    assert_true(count_lonely(mesh) < 12);                 /* there too */
    vv_mesh_release(mesh);
    vv_mesh_release(whole);
    vv_field_release(f);
    vv_field_release(one);
}

static void chosen_labels_have_their_names(void **state)
{
    (void)state;
    vv_field *f = labels_of(voronoi, SIDE, SIDE, SIDE, VV_TYPE_U16);
    static const vv_label_id chosen[] = {1000, 979, 993}, missing[] = {979, 3};
    static const vv_mesh_part parts[] = {
        {.name = "liver", .color = {1, 0, 0, 1}}, {.name = ""}, {.name = "spleen", .color.a = -1}};
    vvi_labels_options o = {.labels = chosen, .parts = parts, .n_labels = 3, .smoothing = 1, .no_normals = true};
    vv_mesh *mesh, *first = NULL;
    for (int threads = 1; threads < 9; threads *= 2) {
        vv_job *job = test_job(threads, 0);
        assert_int_equal(vvi_label_surfaces(&mesh, f, 0, &o, job), VV_OK);
        vv_job_release(job);
        const vv_mesh_info *m = vv_mesh_get_info(mesh);
        assert_int_equal(m->n_parts, 3);
        assert_string_equal(m->parts[0].name, "liver");
        assert_true(m->parts[0].color.r == 1);
        assert_string_equal(m->parts[1].name, "label 979");
        assert_string_equal(m->parts[2].name, "spleen");
        assert_null(m->normals);
        if (first) {
            const vv_mesh_info *n = vv_mesh_get_info(first);
            assert_int_equal(m->n_vertices, n->n_vertices);
            assert_memory_equal(m->positions, n->positions, 12 * n->n_vertices);
            assert_memory_equal(m->triangles, n->triangles, 12 * n->n_triangles);
            vv_mesh_release(mesh);
        } else {
            first = mesh;
        }
    }
    vv_mesh_release(first);
    o.labels = missing;
    o.n_labels = 2;
    assert_int_equal(vvi_label_surfaces(&mesh, f, 0, &o, NULL), VV_E_NOT_FOUND);
    assert_null(mesh);
    const vvi_labels_options rough = {.smoothing = 9}, none = {.smoothing = NAN},
                             plain = {.smoothing = 1, .background = 5};
    assert_int_equal(vvi_label_surfaces(&mesh, f, 0, &rough, NULL), VV_E_ARGUMENT);
    assert_int_equal(vvi_label_surfaces(&mesh, f, 0, &none, NULL), VV_E_ARGUMENT);
    assert_int_equal(vvi_label_surfaces(&mesh, f, 1, &plain, NULL), VV_E_ARGUMENT);
    vv_field_release(f);
    f = labels_of(nothing_else, 4, 5, 6, VV_TYPE_U8);
    assert_int_equal(vvi_label_surfaces(&mesh, f, 0, &plain, NULL), VV_E_NOT_FOUND);
    vv_field_release(f);
    f = labels_of(nothing_else, 4, 5, 6, VV_TYPE_F32);
    assert_int_equal(vvi_label_surfaces(&mesh, f, 0, &plain, NULL), VV_E_UNSUPPORTED);
    vv_field_release(f);
}

/* Sizes 1 and odd ones, every type, every voxel its own label. */
static double all_different(int64_t i, int64_t j, int64_t k)
{
    return (double)((i * 7 + j * 11 + k * 13) % 100);
}

static void small_and_crowded_volumes_do_no_harm(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{1, 1, 1}, {2, 1, 3}, {67, 3, 2}, {1, 64, 5}, {9, 11, 13}};
    for (int type = 0; type < VV_TYPE_F32; type++)
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
            for (int smooth = 0; smooth < 3; smooth++) {
                vv_field *f = labels_of(all_different, sizes[s][0], sizes[s][1], sizes[s][2], (vv_type)type);
                const vvi_labels_options o = {.smoothing = smooth, .background = -1};
                vv_mesh *mesh;
                assert_int_equal(vvi_label_surfaces(&mesh, f, 0, &o, NULL), VV_OK);
                assert_int_equal(test_mesh_bad_edges(mesh), 0);
                vv_mesh_release(mesh);
                vv_field_release(f);
            }
}

/* Real segmentations: each label against the number of its voxels. What is thinner than the smoothing loses most. */
static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median_error(const vv_field *f, vv_job *job)
{
    const vvi_labels_options o = {.smoothing = 1, .no_normals = true};
    const vv_field_info *info = vv_field_get_info(f);
    const vv_affine m = info->grid.index_to_world;
    static double counts[65536], errors[65536];
    vv_mesh *mesh;
    assert_int_equal(vvi_label_surfaces(&mesh, f, 0, &o, job), VV_OK);
    memset(counts, 0, sizeof counts);
    for (int64_t k = 0; k < info->grid.dims[2]; k++)
        for (int64_t j = 0; j < info->grid.dims[1]; j++)
            for (int64_t i = 0; i < info->grid.dims[0]; i++)
                counts[(uint16_t)vv_field_value(f, i, j, k, 0)]++;
    double all = 0, voxels = 0;
    const vv_mesh_info *mi = vv_mesh_get_info(mesh);
    for (size_t p = 0; p < mi->n_parts; p++) {
        const double count = counts[(uint16_t)atoi(mi->parts[p].name + strlen("label "))];
        const double volume = part_volume(mesh, p) / fabs(vv_affine_determinant(m));
        errors[p] = fabs(volume / count - 1);
        all += volume;
        voxels += count;
    }
    qsort(errors, mi->n_parts, sizeof *errors, by_size);
    print_message(
        "%zu labels, %zu triangles: volumes differ by %.2f %% (median), %.1f %% (most); all together %+.2f %%\n",
        mi->n_parts, mi->n_triangles, 100 * errors[mi->n_parts / 2], 100 * errors[mi->n_parts - 1],
        100 * (all / voxels - 1));
    const double median = errors[mi->n_parts / 2];
    vv_mesh_release(mesh);
    return median;
}

static void real_segmentations_keep_their_volumes(void **state)
{
    (void)state;
    static const char *const files[] = {"/usr/share/mricron/templates/aal.nii.gz", "formats/tiff/nuclei_mask3d.tif"};
    const char *root = getenv("VOLVIS_SHARED");
    size_t found = 0;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[4096];
        if (*files[i] == '/')
            snprintf(path, sizeof path, "%s", files[i]);
        else
            snprintf(path, sizeof path, "%s/data/%s", root ? root : VOLVIS_SHARED_DIR, files[i]);
        vv_job *job = test_job(0, 0);
        vv_file *file;
        vv_field *f;
        if (access(path, R_OK) == 0 && vv_file_open(&file, path, NULL, job) == VV_OK) {
            assert_int_equal(vv_file_read(&f, file, 0, NULL, job), VV_OK);
            print_message("%s: ", path);
            assert_true(median_error(f, job) < .08);
            vv_file_close(file);
            vv_field_release(f);
            found++;
        } else {
            print_message("%s is not there: skipped\n", path);
        }
        vv_job_release(job);
    }
    if (!found)
        skip();
}

static vv_status make_once(void *user)
{
    const vvi_labels_options o = {.smoothing = 1};
    vv_mesh *mesh;
    const vv_status st = vvi_label_surfaces(&mesh, user, 0, &o, NULL);
    vv_mesh_release(mesh);
    return st;
}

static void without_memory_it_fails_cleanly(void **state)
{
    (void)state;
    ball_radius = 3;
    vv_field *f = labels_of(balls, 13, 13, 13, VV_TYPE_U16);
    assert_true(test_fail_each_alloc(make_once, f) > 30);
    vv_field_release(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ball_is_smooth_and_as_large_as_its_voxels),
        cmocka_unit_test(neighbours_share_their_border),
        cmocka_unit_test(chosen_labels_have_their_names),
        cmocka_unit_test(small_and_crowded_volumes_do_no_harm),
        cmocka_unit_test(real_segmentations_keep_their_volumes),
        cmocka_unit_test(without_memory_it_fails_cleanly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
