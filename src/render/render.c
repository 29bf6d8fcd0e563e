/* The frame driver: one view, one renderer, tiles on all workers. */
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "render/common/resolve.h"
#include <volvis/render.h>

/* Pixels along the side of a tile: large enough for packets of rays and one item of 0.1 to 10 ms, small enough that the
 * last worker is not waited for. */
#define TILE 32

typedef struct frame {
    const vv_scene *scene;
    void *state; /* the renderer's */
    vv_image *image;
    vv_job *job;
    vv_render_counts *counts; /* by tile: summed in their order */
    int32_t n_across;
} frame;

static vv_tile tile_at(const frame *f, size_t index)
{
    const int32_t x = (int32_t)(index % (size_t)f->n_across) * TILE, y = (int32_t)(index / (size_t)f->n_across) * TILE;
    const int32_t right = x + TILE, bottom = y + TILE;
    return (vv_tile){x, y, right < f->image->width ? right : f->image->width,
                     bottom < f->image->height ? bottom : f->image->height};
}

static float *pixel(const vv_image *image, int32_t x, int32_t y)
{
    return image->rgba + 4 * ((size_t)y * (size_t)image->width + (size_t)x);
}

/* Over the background, premultiplied and linear; a transparent one changes nothing. */
static void composite(const vv_image *image, const vv_tile *tile, const float background[4])
{
    for (int32_t y = tile->y0; y < tile->y1; y++) {
        for (int32_t x = tile->x0; x < tile->x1; x++) {
            float *p = pixel(image, x, y);
            const float through = 1 - p[3];
            for (int c = 0; c < 4; c++)
                p[c] += through * background[c];
        }
    }
}

/* One ray through the middle of every pixel. */
static void count_samples(const vv_image *image, const vv_tile *tile)
{
    for (int32_t y = tile->y0; y < tile->y1; y++)
        for (int32_t x = tile->x0; x < tile->x1; x++)
            image->samples[(size_t)y * (size_t)image->width + (size_t)x] = 1;
}

static vv_status render_tile(void *scratch, void *shared, size_t index)
{
    frame *f = shared;
    const vv_tile tile = tile_at(f, index);
    const vv_pass pass = {.x = 0.5, .y = 0.5, .stride = 1, .seed = f->scene->seed};
    (void)scratch;
    const vv_status st = f->scene->renderer->render(f->state, &pass, &tile, f->image, &f->counts[index], f->job);
    if (st != VV_OK)
        return st;
    composite(f->image, &tile, f->scene->background);
    if (f->image->samples)
        count_samples(f->image, &tile);
    return VV_OK;
}

static vv_status render_tiles(frame *f, vv_render_report *report)
{
    static const vvi_work work = {.stage = "render", .item = render_tile};
    const vv_image *image = f->image;
    f->n_across = (image->width + TILE - 1) / TILE;
    const size_t n = (size_t)f->n_across * (size_t)((image->height + TILE - 1) / TILE);
    f->counts = vvi_alloc_zeroed(f->job, n * sizeof *f->counts, VVI_MEM_SCRATCH);
    if (!f->counts)
        return vv_fail_memory(n * sizeof *f->counts);
    const vv_status st = vvi_parallel_for(f->job, &work, f, n);
    for (size_t i = 0; i < n; i++) {
        report->rays += f->counts[i].rays;
        report->samples += f->counts[i].samples;
    }
    vvi_free(f->counts);
    return st;
}

static vv_status render_scene(vv_image **out, vv_render_report *report, const vv_scene *scene, vv_job *job)
{
    const vv_renderer *renderer = scene->renderer;
    frame f = {.scene = scene, .job = job};
    vv_status st = VV_OK;
    const double start = vvi_render_clock();
    if (!renderer->render)
        return vv_fail(VV_E_UNSUPPORTED, "method '%s' draws nothing", renderer->name);
    if (renderer->accepts && (st = renderer->accepts(scene)) != VV_OK)
        return st;
    if ((st = vv_image_new(&f.image, scene->width, scene->height, scene->layers, job)) != VV_OK)
        return st;
    if (renderer->prepare && (st = renderer->prepare(&f.state, scene, job)) != VV_OK)
        goto fail;
    const double prepared = vvi_render_clock();
    report->prepare_s += prepared - start;
    st = render_tiles(&f, report);
    report->render_s = vvi_render_clock() - prepared;
    if (renderer->finish)
        renderer->finish(f.state);
    if (st != VV_OK)
        goto fail;
    *out = f.image;
    return VV_OK;
fail:
    vv_image_release(f.image);
    return st;
}

static const char *isa_name(const vv_job *job)
{
    const uint32_t cpu = vvi_job_cpu(job);
    return cpu & VVI_CPU_AVX512 ? "avx512" : cpu & VVI_CPU_AVX2 ? "avx2" : cpu & VVI_CPU_NEON ? "neon" : "base";
}

vv_status vv_render(vv_image **out, vv_render_report *report, vv_world *world, const char *view, vv_job *job)
{
    vv_scene *scene = NULL;
    vv_render_report mine = {.isa = isa_name(job), .threads = vvi_job_threads(job)};
    const double start = vvi_render_clock();
    *out = NULL;
    vv_status st = vv_scene_resolve(&scene, world, view, job);
    if (st != VV_OK)
        return st;
    mine.method = scene->renderer->name;
    mine.load_s = ((const vvi_resolved *)scene)->load_s;
    mine.prepare_s = vvi_render_clock() - start - mine.load_s;
    st = render_scene(out, &mine, scene, job);
    vv_scene_release(scene);
    if (report)
        *report = mine;
    return st;
}
