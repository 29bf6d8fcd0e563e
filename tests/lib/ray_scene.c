#include "ray_scene.h"
#include "core/cpu.h"
#include "core/job.h"
#include "fields.h"
#include "jobs.h"
#include "scene/lens.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

extern const vv_renderer vvi_renderer_raycast;

void test_ray_scene_init(test_ray_scene *s, const vv_field *field, double height)
{
    memset(s, 0, sizeof *s);
    vv_object *params = NULL;
    assert_int_equal(vv_object_new(&params, &vvi_raycast_class, NULL), VV_OK);
    s->params = (vvi_raycast_params *)params;
    assert_int_equal(vv_path_set(&params, "step", "1", NULL), VV_OK);
    assert_int_equal(vv_path_set(&params, "opaque", "0", NULL), VV_OK);
    s->params = (vvi_raycast_params *)params;
    s->scene = (vv_scene){.renderer = &vvi_renderer_raycast,
                          .params = params,
                          .quality = VV_QUALITY_NORMAL,
                          .width = 64,
                          .height = 64,
                          .actors = &s->actor,
                          .n_actors = 1,
                          .lamps = s->lamps};
    const vv_grid *grid = &vv_field_get_info(field)->grid;
    s->actor = (vv_actor){.id = "test",
                          .field = field,
                          .index_to_world = grid->index_to_world,
                          .planes = s->planes,
                          .statistics = &s->statistics,
                          .ambient = 0.2f,
                          .diffuse = 0.7f,
                          .specular = 0.3f,
                          .shininess = 12,
                          .two_sided = true,
                          .color = {0.9f, 0.6f, 0.3f},
                          .layer = {.opacity = 1}};
    assert_int_equal(vv_field_statistics(&s->statistics, field, 0, NULL), VV_OK);
    s->actor.classes.opacity = s->opacity;
    s->actor.classes.color = s->color;
    s->actor.classes.opacity_length = 1;
    s->actor.classes.opacity_scale = 1;
    test_ray_scene_opacity(s, (const double[]){0, 0}, 1);
    test_ray_scene_color(s, (const double[]){0, 1, 1, 1}, 1);
    const vv_bounds b = vv_grid_bounds(grid);
    const vv_vec3 at = {(b.lo.x + b.hi.x) / 2, (b.lo.y + b.hi.y) / 2, (b.lo.z + b.hi.z) / 2};
    test_ray_scene_look(s, (vv_vec3){at.x, at.y, b.hi.z + 10}, at, 0, height);
}

void test_ray_scene_finish(test_ray_scene *s)
{
    vv_object_release(&s->params->base);
}

void test_ray_scene_set(test_ray_scene *s, const char *path, const char *json)
{
    vv_object *params = &s->params->base;
    assert_int_equal(vv_path_set(&params, path, json, NULL), VV_OK);
    s->params = (vvi_raycast_params *)params;
    s->scene.params = params;
}

void test_ray_scene_opacity(test_ray_scene *s, const double *rows, size_t n)
{
    memcpy(s->opacity, rows, n * 2 * sizeof *rows);
    s->actor.classes.n_opacity = n;
}

void test_ray_scene_color(test_ray_scene *s, const double *rows, size_t n)
{
    memcpy(s->color, rows, n * 4 * sizeof *rows);
    s->actor.classes.n_color = n;
}

void test_ray_scene_look(test_ray_scene *s, vv_vec3 eye, vv_vec3 at, double fov, double height)
{
    vv_lens *l = &s->scene.lens;
    l->eye = eye;
    l->forward = vvi_sub(at, eye);
    assert_true(vvi_unit(&l->forward));
    l->right = vvi_cross(l->forward, fabs(l->forward.z) > 0.99 ? vvi_vec(0, 1, 0) : vvi_vec(0, 0, 1));
    assert_true(vvi_unit(&l->right));
    l->up = vvi_cross(l->right, l->forward);
    l->parallel = fov == 0;
    l->half_height = l->parallel ? height / 2 : tan(fov / 2);
    l->half_width = l->half_height * s->scene.width / s->scene.height;
}

void test_ray_scene_light(test_ray_scene *s)
{
    const vv_lens *l = &s->scene.lens;
    s->actor.shading_model = VV_SHADING_BLINN;
    s->scene.n_lamps = 2;
    s->lamps[0] = (vv_lamp){.kind = VV_LIGHT_DIRECTIONAL, .color = {0.8f, 0.8f, 0.7f}};
    s->lamps[0].direction =
        vvi_sub(vvi_scaled(l->forward, 1), vvi_add(vvi_scaled(l->up, 0.8), vvi_scaled(l->right, -0.5)));
    assert_true(vvi_unit(&s->lamps[0].direction));
    s->lamps[1] = (vv_lamp){.kind = VV_LIGHT_POINT, .color = {0.2f, 0.2f, 0.3f}, .falloff = {1, 0, 0}};
    s->lamps[1].position = vvi_add(l->eye, vvi_scaled(l->right, 3));
    for (int c = 0; c < 3; c++)
        s->scene.ambient[c] = 0.9f;
}

static const vv_pass centres = {.x = 0.5, .y = 0.5, .stride = 1};

/* Item: one tile of 16 x 16. */
typedef struct picture {
    void *state;
    vv_image *image;
    int32_t across;
} picture;

static vv_status render_tile(void *scratch, void *shared, size_t index)
{
    const picture *p = shared;
    vv_tile t = {.x0 = (int32_t)index % p->across * 16, .y0 = (int32_t)index / p->across * 16};
    t.x1 = t.x0 + 16 < p->image->width ? t.x0 + 16 : p->image->width;
    t.y1 = t.y0 + 16 < p->image->height ? t.y0 + 16 : p->image->height;
    vv_render_counts counts = {0};
    (void)scratch;
    return vvi_renderer_raycast.render(p->state, &centres, &t, p->image, &counts, NULL);
}

/* The kernel in the place that `chosen` has in the best table. */
static vvi_ray_kernel *same_kernel(const vvi_ray_kernels *in, vvi_ray_kernel *chosen)
{
    const vvi_ray_kernels *best = vvi_ray_kernels_for(vvi_job_cpu(NULL));
    for (int kind = 0; kind < VVI_RAY_KERNELS; kind++)
        for (int type = 0; type < VVI_SAMPLE_KERNELS; type++)
            if (best->of[kind][type] == chosen)
                return in->of[kind][type];
    if (best->surface_cubic == chosen)
        return in->surface_cubic;
    assert_ptr_equal(best->composite_cubic, chosen);
    return in->composite_cubic;
}

vv_image *test_ray_picture_by(const test_ray_scene *s, const vvi_ray_kernels *kernels)
{
    void *prepared = NULL;
    vv_image *image = NULL;
    vv_render_counts counts = {0};
    const vv_tile all = {0, 0, s->scene.width, s->scene.height};
    assert_int_equal(vv_image_new(&image, s->scene.width, s->scene.height, VV_LAYER_DEPTH, NULL), VV_OK);
    assert_int_equal(vvi_raycast_prepare(&prepared, &s->scene, NULL), VV_OK);
    vvi_raycast_state *state = prepared;
    for (size_t i = 0; i < state->n_volumes; i++)
        state->volume[i].kernel = same_kernel(kernels, state->volume[i].kernel);
    state->kernels = kernels;
    assert_int_equal(vvi_renderer_raycast.render(state, &centres, &all, image, &counts, NULL), VV_OK);
    vvi_raycast_finish(state);
    return image;
}

vv_image *test_ray_picture(const test_ray_scene *s, const char *cpu, int threads)
{
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.cpu = cpu;
    options.threads = threads;
    vv_runtime *runtime = NULL;
    vv_job *job = NULL;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    picture p = {.across = (s->scene.width + 15) / 16};
    assert_int_equal(vv_image_new(&p.image, s->scene.width, s->scene.height, VV_LAYER_DEPTH, job), VV_OK);
    for (size_t i = 0; i < (size_t)s->scene.width * (size_t)s->scene.height; i++) {
        p.image->depth[i] = INFINITY;
        memset(p.image->rgba + 4 * i, 0, 4 * sizeof *p.image->rgba);
    }
    if (vvi_raycast_prepare(&p.state, &s->scene, job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    const vvi_work work = {.item = render_tile};
    const size_t tiles = (size_t)p.across * (size_t)((s->scene.height + 15) / 16);
    assert_int_equal(vvi_parallel_for(job, &work, &p, tiles), VV_OK);
    vvi_raycast_finish(p.state);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return p.image;
}

double *test_ray_reference(const test_ray_scene *s)
{
    double *out = malloc((size_t)s->scene.width * (size_t)s->scene.height * 5 * sizeof *out), *p = out;
    assert_non_null(out);
    void *state = NULL;
    assert_int_equal(vvi_raycast_prepare(&state, &s->scene, NULL), VV_OK);
    for (int32_t y = 0; y < s->scene.height; y++)
        for (int32_t x = 0; x < s->scene.width; x++, p += 5)
            vvi_raycast_ref(p, p + 4, &s->scene, state, x, y);
    vvi_raycast_finish(state);
    return out;
}

const char *const *test_ray_cpus(void)
{
    static const char *const all[] = {"avx512", "avx2", "base", NULL};
    for (const char *const *cpu = all;; cpu++) {
        vv_runtime_options options;
        vv_runtime_options_init(&options, sizeof options);
        options.cpu = *cpu;
        vv_runtime *runtime = NULL;
        if (vv_runtime_new(&runtime, &options) == VV_OK) {
            vv_runtime_release(runtime);
            return cpu;
        }
    }
}
