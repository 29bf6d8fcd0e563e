/* "film": what X-rays would leave on a film: light where they met matter. Cell by cell, so it works on any data kind.
 */
#include "renderer_film.h"
#include <math.h>
#include <stdlib.h>
#include <volvis/sys/scene.h>
#include <volvis/sys/work.h>

enum { MAX_SEGMENTS = 1024 };

typedef struct film_params {
    vv_object base;
    double strength;
} film_params;

static const vv_property film_rows[] = {
    {VV_PROP(film_params, strength), .kind = VV_KIND_F64, .def = 4, .limited = true, .min = 0, .max = 1000,
     .doc = "optical depth of the largest value over the diagonal of the data"},
    {0},
};

static const vv_class film_class = {
    .name = "film",
    .doc = "parameters of film",
    .size = sizeof(film_params),
    .properties = film_rows,
};

typedef struct film {
    const vv_scene *scene;
    const vv_data_kind *kind;
    double per_length;  /* optical depth of one unit of length at the largest value */
    vv_affine to_field; /* from where the volume was put to where its samples lie */
} film;

/* VV_OK, or why this scene cannot be drawn by this method: said before any work is done. */
static vv_status accepts(const vv_scene *scene)
{
    if (scene->n_actors != 1)
        return vv_fail(VV_E_UNSUPPORTED, "film shows one volume; this view has %zu", scene->n_actors);
    return VV_OK;
}

static const vv_data_kind *kind_of(const vv_field_info *info, const vv_job *job)
{
    const vv_data_kind *const *kinds = vv_job_registry(job)->data_kinds;
    while (*kinds && !(*kinds)->accepts(info))
        kinds++;
    return *kinds;
}

static vv_status prepare(void **state_out, const vv_scene *scene, vv_job *job)
{
    const vv_actor *actor = &scene->actors[0];
    const vv_field_info *info = vv_field_get_info(actor->field);
    film f = {.scene = scene, .kind = kind_of(info, job)};
    vv_affine world_to_index;
    if (!f.kind || !vv_affine_invert(&world_to_index, actor->index_to_world))
        return vv_fail(VV_E_UNSUPPORTED, "volume '%s': film has no way through samples of this kind", actor->id);
    f.to_field = vv_affine_compose(info->grid.index_to_world, world_to_index);
    const vv_bounds box = f.kind->bounds(info);
    const double x = box.hi.x - box.lo.x, y = box.hi.y - box.lo.y, z = box.hi.z - box.lo.z;
    f.per_length = ((const film_params *)scene->params)->strength / sqrt(x * x + y * y + z * z);
    film *state = malloc(sizeof *state);
    if (!state)
        return vv_fail_memory(sizeof *state);
    *state = f;
    *state_out = state;
    return VV_OK;
}

/* The integral of (value - min) / (max - min) along a ray: exact for values that are linear between a cell's ends. */
static double depth_along(const film *f, vv_vec3 origin, vv_vec3 direction)
{
    vv_segment segment[MAX_SEGMENTS];
    const vv_actor *actor = &f->scene->actors[0];
    const vv_statistics *s = actor->statistics;
    const double scale = s->max > s->min ? 1 / (s->max - s->min) : 0;
    double sum = 0, from = 0;
    for (size_t n = MAX_SEGMENTS; n == MAX_SEGMENTS;) { /* long rays come in pieces */
        n = f->kind->segments(segment, MAX_SEGMENTS, actor->field, actor->component, origin, direction, from, INFINITY);
        for (size_t i = 0; i < n; i++)
            sum += ((segment[i].value0 + segment[i].value1) / 2 - s->min) * scale * (segment[i].t1 - segment[i].t0);
        from = n ? segment[n - 1].t1 : 0;
    }
    return sum;
}

static vv_status render(void *state, const vv_pass *pass, const vv_tile *tile, vv_image *image,
                        vv_render_counts *counts, vv_job *job)
{
    const film *f = state;
    const vv_scene *scene = f->scene;
    for (int32_t y = tile->y0; y < tile->y1; y++) {
        for (int32_t x = tile->x0; x < tile->x1; x++) {
            vv_vec3 origin, direction;
            vv_lens_ray(&origin, &direction, &scene->lens, scene->width, scene->height,
                        (double)x * pass->stride + pass->x, (double)y * pass->stride + pass->top + pass->y);
            origin = vv_affine_point(f->to_field, origin);
            direction = vv_affine_vector(f->to_field, direction);
            const float light = (float)(1 - exp(-f->per_length * depth_along(f, origin, direction)));
            float *pixel = image->rgba + 4 * ((size_t)y * (size_t)image->width + (size_t)x);
            pixel[0] = pixel[1] = pixel[2] = pixel[3] = light;
            counts->rays++;
        }
        const vv_status st = vv_job_poll(job);
        if (st != VV_OK)
            return st;
    }
    return VV_OK;
}

const vv_renderer renderer_film = {
    .api = VV_RENDERER_API,
    .name = "film",
    .label = "X-ray film",
    .doc = "an X-ray film, an example",
    .params = &film_class,
    .takes = VV_CONTENT_SAMPLES,
    .accepts = accepts,
    .prepare = prepare,
    .render = render,
    .finish = free,
};
