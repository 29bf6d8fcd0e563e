/* Pictures that are larger than memory: part by part, from the top down, and each part into the file when it is done.
 */
#include "core/job.h"
#include "core/memory.h"
#include "core/status.h"
#include "image/image_layer.h"
#include "model/contents.h"
#include "render/picture.h"
#include "scene/resolve.h"
#include <stdlib.h>

/* Beside the image: the colours of a pass and, to tell the noise, the mean of half of them; or the coarse picture,
 * which is like the image. Once these are gone, what decorations need, and then the file. The threads' own. */
enum { PASS_BYTES = 16, NOISE_BYTES = 16, AFTER_BYTES = 8, THREADS_BYTES = 4 << 20 };

/* Of what memory has left a part takes so much, since what is made of data is not counted yet. */
#define SHARE 0.5

static uint64_t pixel_bytes(const vv_scene *scene)
{
    const uint64_t image = vvi_image_pixel_bytes(scene->layers);
    uint64_t beside = 0;
    if (!scene->renderer->draw && scene->samples > 1)
        beside = PASS_BYTES + (scene->noise > 0 ? NOISE_BYTES : 0);
    else if (scene->adaptive)
        beside = image;
    return image + (beside > AFTER_BYTES ? beside : AFTER_BYTES);
}

static uint64_t memory_left(vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    const uint64_t limit = vv_runtime_memory_limit(runtime), used = vv_runtime_memory_used(runtime);
    return limit > used ? limit - used : 0;
}

vv_status vv_render_memory(uint64_t *bytes_out, bool *at_once_out, const vv_world *world, const char *view_id,
                           vv_job *job)
{
    const vv_view *view = vvi_view_named(world, view_id);
    if (!view)
        return vv_fail_at(VV_E_NOT_FOUND, NULL, "views", "there is no view '%s'", view_id);
    vv_scene scene = {.view = view};
    scene.renderer = vv_registry_renderer(vvi_job_registry(job), vvi_method_of(world, view, job));
    if (!scene.renderer)
        return vv_error_last()->status;
    vvi_resolve_sampling(&scene);
    *bytes_out = (uint64_t)view->width * (uint64_t)view->height * pixel_bytes(&scene) + THREADS_BYTES;
    *at_once_out = *bytes_out <= memory_left(job);
    return VV_OK;
}

typedef struct parts {
    vv_world *world;
    const char *view;
    int32_t at, rows; /* of the next part, and of each but the last */
    int32_t height;
    vv_image *image; /* of the last one */
    uint64_t covered;
    vv_render_report report;
} parts;

static void add(vv_render_report *sum, const vv_render_report *part)
{
    const vv_render_report before = *sum;
    *sum = *part;
    sum->load_s += before.load_s;
    sum->prepare_s += before.prepare_s;
    sum->render_s += before.render_s;
    sum->rays += before.rays;
    sum->samples += before.samples;
    sum->passes = part->passes > before.passes ? part->passes : before.passes;
}

static vv_status next(void *user, const vv_image **out, vv_job *job)
{
    parts *p = user;
    vv_picture *picture;
    const int32_t rows = p->rows < p->height - p->at ? p->rows : p->height - p->at;
    vv_image_release(p->image);
    p->image = NULL;
    vv_status st = vvi_picture_new_rows(&picture, p->world, p->view, p->at, rows, job);
    if (st != VV_OK)
        return st;
    if ((st = vv_picture_step(picture, NULL, job)) == VV_OK &&
        (st = vvi_picture_take(&p->image, NULL, picture, job)) == VV_OK) {
        vv_render_report report;
        vv_picture_report(&report, picture);
        add(&p->report, &report);
        p->covered += picture->got.counts.covered;
    }
    vv_picture_free(picture);
    p->at += rows;
    *out = p->image;
    return st;
}

/* Whole tiles, and at least one. */
static int32_t rows_at_once(const vv_scene *scene, vv_job *job)
{
    const double row = (double)scene->width * (double)pixel_bytes(scene);
    const double rows = SHARE * ((double)memory_left(job) - THREADS_BYTES) / row;
    const int32_t most = scene->height - scene->height % VVI_TILE + VVI_TILE;
    return rows >= most ? most : rows > VVI_TILE ? (int32_t)rows / VVI_TILE * VVI_TILE : VVI_TILE;
}

vv_status vv_render_to_file(vv_render_report *report, const char *path, vv_world *world, const char *view,
                            const vv_image_options *options, vv_job *job)
{
    vv_scene *scene;
    vv_status st = vv_scene_resolve(&scene, world, view, job);
    if (st != VV_OK)
        return st;
    parts p = {.world = world, .view = view, .height = scene->height, .rows = rows_at_once(scene, job)};
    const vv_image_rows rows = {.width = scene->width,
                                .height = scene->height,
                                .transparent = scene->background[3] < 1,
                                .next = next,
                                .user = &p};
    if ((st = vvi_has_parts(scene)) == VV_OK)
        st = vv_image_write_rows(path, &rows, options, job);
    if (st == VV_OK)
        vvi_warn_of_nothing(scene, p.covered, job);
    vv_scene_release(scene);
    vv_image_release(p.image);
    if (st == VV_OK && report)
        *report = p.report;
    return st;
}
