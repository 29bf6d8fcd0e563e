/* The row of the renderer table: ray casting. */
#include "render/raycast/raycast.h"
#include "core/job.h"
#include "registry.h"

static vv_status accepts(const vv_scene *scene)
{
    if (scene->n_actors > 1)
        return vv_fail(VV_E_UNSUPPORTED,
                       "volumes.%s: ray casting shows one volume at a time and %zu are visible; set visible=false on "
                       "the others",
                       scene->actors[1].id, scene->n_actors);
    return VV_OK;
}

static bool projects(const vv_object *params)
{
    return ((const vvi_raycast_params *)params)->mode == VVI_RAYCAST_MAXIMUM;
}

static vv_status render(void *state, const vv_pass *pass, const vv_tile *tile, vv_image *image,
                        vv_render_counts *counts, vv_job *job)
{
    const vvi_raycast_state *s = state;
    if (!s->kernel) {
        counts->rays += (uint64_t)(tile->x1 - tile->x0) * (uint64_t)(tile->y1 - tile->y0);
        return VV_OK; /* the image begins clear */
    }
    vvi_ray_frame frame = s->frame;
    frame.pixel_x = pass->x;
    frame.pixel_y = pass->y;
    frame.stride = pass->stride;
    frame.row = image->width;
    frame.jitter_seed = pass->seed;
    frame.rgba = image->rgba;
    frame.depth = image->depth;
    /* rays of very many steps: pieces of a tile that take some milliseconds, so that a stop is heard */
    const int32_t size = frame.steps > 16384 ? 4 : frame.steps > 2048 ? 16 : INT16_MAX;
    for (int32_t y = tile->y0; y < tile->y1; y += size)
        for (int32_t x = tile->x0; x < tile->x1; x += size) {
            const vv_tile piece = {x, y, x + size < tile->x1 ? x + size : tile->x1,
                                   y + size < tile->y1 ? y + size : tile->y1};
            const vv_status st = vvi_job_poll(job);
            if (st != VV_OK)
                return st;
            s->kernel(&frame, &piece, counts);
        }
    return VV_OK;
}

const vv_renderer vvi_renderer_raycast = {
    .api = VV_RENDERER_API,
    .name = "raycast",
    .doc = "ray casting with space skipping: composite, maximum and isosurface, with local illumination",
    .params = &vvi_raycast_class,
    .accepts = accepts,
    .prepare = vvi_raycast_prepare,
    .render = render,
    .finish = vvi_raycast_finish,
    .projects = projects,
};
