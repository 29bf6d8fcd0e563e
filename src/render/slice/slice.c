/* The row of slices: one plane, through the cross-hair. */
#include "render/slice/slice.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "grid/slice_axes.h"
#include "registry.h"
#include "scene/lens.h"
#include "scene/resolve.h"
#include <math.h>
#include <volvis/render.h>

/* Places that a pixel is the mean of, along each of its sides, where it is larger than samples: close enough that each
 * sample takes part. Between places linear interpolation reaches two samples far, of nearest ones each has its own. */
enum { MOST_PLACES = 16 };
#define FAR_LINEAR 1.5 /* samples */
#define FAR_NEAREST 1.0
#define NEARLY 1e-6 /* a pixel as large as a sample is one place, whatever its rounding */

/* Parameters ------------------------------------------------------------------------------------------------------ */

static const char *const orientations[] = {"axial", "coronal", "sagittal", "camera", NULL};
static const char *const frames[] = {"world", "samples", NULL};
static const vv_property properties[] = {
    {VV_PROP(vvi_slice_params, orientation), .kind = VV_KIND_ENUM, .names = orientations, .def = VVI_SLICE_AXIAL,
     .doc = "orientation of the plane: across z, seen from below; across y, from the front; across x, from the left; "
            "or at right angles to the camera's line of sight"},
    {VV_PROP(vvi_slice_params, axes), .kind = VV_KIND_ENUM, .names = frames, .def = VVI_SLICE_OF_WORLD,
     .doc = "which x, y and z: the World's (anatomical ones), or the sample axes of the first volume that are nearest "
            "to them"},
    {0},
};
static const vv_class slice_class = {
    .name = "slice",
    .doc = "parameters of slice",
    .size = sizeof(vvi_slice_params),
    .properties = properties,
};

/* The plane ------------------------------------------------------------------------------------------------------- */

static vv_vec3 unit_axis(int axis, int sign)
{
    return vvi_vec(axis == 0 ? sign : 0, axis == 1 ? sign : 0, axis == 2 ? sign : 0);
}

/* The directions of samples, where they are not sheared; of others a picture without shear all the same. */
static void take_samples(vv_vec3 *right, vv_vec3 *up, const vv_actor *actor, const vvi_slice_axes *way)
{
    vv_grid grid = vv_field_get_info(actor->field)->grid;
    int axis[3], sign[3];
    grid.index_to_world = actor->index_to_world;
    vvi_grid_index_axes(axis, sign, &grid);
    vv_vec3 x = vvi_scaled(grid.index_to_world.axis[axis[way->right]], sign[way->right] * way->right_sign);
    vv_vec3 y = vvi_scaled(grid.index_to_world.axis[axis[way->up]], sign[way->up] * way->up_sign);
    if (!vvi_unit(&x))
        return;
    y = vvi_sub(y, vvi_scaled(x, vvi_dot(x, y)));
    if (!vvi_unit(&y))
        return;
    *right = x;
    *up = y;
}

static bool plane(vv_vec3 *right, vv_vec3 *up, const vv_scene *scene)
{
    const vvi_slice_params *p = (const vvi_slice_params *)(const void *)scene->params;
    if (p->orientation == VVI_SLICE_CAMERA)
        return false;
    const vvi_slice_axes *way = &vvi_slice_axes_of(vvi_scene_space(scene))[p->orientation];
    *right = unit_axis(way->right, way->right_sign);
    *up = unit_axis(way->up, way->up_sign);
    if (p->axes == VVI_SLICE_OF_SAMPLES && scene->n_actors)
        take_samples(right, up, &scene->actors[0], way);
    return true;
}

static vv_status accepts(const vv_scene *scene)
{
    vv_color color;
    for (size_t i = 0; i < scene->n_actors; i++) {
        const vv_actor *actor = &scene->actors[i];
        if (!vv_colormap_sample(&color, actor->slices.colormap, 0))
            return vv_fail(VV_E_NOT_FOUND,
                           "volumes.%s.slices.colormap: there is no colour map '%.100s'; 'volvis presets' lists them",
                           actor->id, actor->slices.colormap);
    }
    return VV_OK;
}

/* Preparing ------------------------------------------------------------------------------------------------------- */

typedef struct layer {
    const vv_actor *actor;
    vvi_slice_samples samples;
    vvi_slice_colors colors;
    bool ids;                             /* vvi_slice_has_ids() */
    double middle[3], across[3], down[3]; /* index coordinates of the picture's middle; of a pixel's sides */
    int places[2];                        /* along these */
} layer;

typedef struct slice_state {
    const vv_scene *scene;
    double distance; /* of the plane from the eye, along the line of sight */
    layer *layers;
    size_t n;
} slice_state;

static void finish(void *state)
{
    slice_state *s = state;
    if (!s)
        return;
    for (size_t i = 0; i < s->n; i++) {
        vvi_slice_samples_close(&s->layers[i].samples);
        vvi_slice_colors_finish(&s->layers[i].colors);
    }
    vvi_free(s->layers);
    vvi_free(s);
}

static void put(double out[3], vv_vec3 v)
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static int places_along(const double side[3], double far)
{
    const double most = fmax(fmax(fabs(side[0]), fabs(side[1])), fabs(side[2]));
    return (int)fmin(fmax(ceil(most / far - NEARLY), 1), MOST_PLACES);
}

static vv_status place(layer *l, const slice_state *s)
{
    const vv_lens *lens = &s->scene->lens;
    const double reach = lens->parallel ? 1 : s->distance, far = l->actor->nearest ? FAR_NEAREST : FAR_LINEAR;
    vv_affine to_index;
    if (!vv_affine_invert(&to_index, l->actor->index_to_world))
        return vv_fail(VV_E_UNSUPPORTED, "volumes.%s: has no thickness", l->actor->id);
    put(l->middle, vv_affine_point(to_index, vvi_add(lens->eye, vvi_scaled(lens->forward, s->distance))));
    put(l->across, vv_affine_vector(to_index, vvi_scaled(lens->right, 2 * lens->half_width * reach / s->scene->width)));
    put(l->down, vv_affine_vector(to_index, vvi_scaled(lens->up, -2 * lens->half_height * reach / s->scene->height)));
    l->places[0] = places_along(l->across, far);
    l->places[1] = places_along(l->down, far);
    return VV_OK;
}

static void warn(const vv_scene *scene, vv_job *job)
{
    if (scene->n_mesh_actors)
        vvi_log(job, VV_LOG_WARNING, "slice", "volumes.%s: is a mesh, which slices do not show",
                scene->mesh_actors[0].look.id);
    for (size_t i = 0; i < scene->n_actors; i++)
        if (scene->actors[i].paint.field || scene->actors[i].texture.kind != VV_TEXTURE_NONE)
            vvi_log(job, VV_LOG_WARNING, "slice", "volumes.%s: slices show neither paint nor texture",
                    scene->actors[i].id);
}

static vv_status prepare(void **state_out, const vv_scene *scene, vv_job *job)
{
    const size_t bytes = (scene->n_actors + 1) * sizeof(layer);
    slice_state *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_SCRATCH);
    *state_out = NULL;
    if (!s)
        return vv_fail_memory(sizeof *s);
    s->scene = scene;
    s->distance = vvi_dot(vvi_sub(scene->cross_hair, scene->lens.eye), scene->lens.forward);
    s->layers = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    vv_status st = s->layers ? VV_OK : vv_fail_memory(bytes);
    warn(scene, job);
    while (st == VV_OK && s->n < scene->n_actors) {
        layer *l = &s->layers[s->n++];
        l->actor = &scene->actors[s->n - 1];
        l->ids = vvi_slice_has_ids(l->actor);
        if ((st = vvi_slice_samples_open(&l->samples, l->actor, job)) == VV_OK)
            st = vvi_slice_colors_init(&l->colors, l->actor, job);
        st = st == VV_OK ? place(l, s) : vv_fail_in(st, "volumes.%s", l->actor->id);
    }
    if (st != VV_OK) {
        finish(s);
        return st;
    }
    *state_out = s;
    return VV_OK;
}

/* Pixels ---------------------------------------------------------------------------------------------------------- */

static void add_place(float sum[4], const layer *l, double x, double y)
{
    double p[3], sample[4];
    vv_label_id label;
    float rgba[4];
    for (int a = 0; a < 3; a++)
        p[a] = l->middle[a] + x * l->across[a] + y * l->down[a];
    if (l->ids ? !vvi_slice_label(&label, &l->samples, p) : !vvi_slice_sample(sample, &l->samples, p))
        return;
    if (l->ids)
        vvi_slice_label_color(rgba, &l->colors, label);
    else
        vvi_slice_color(rgba, &l->colors, sample);
    for (int c = 0; c < 4; c++)
        sum[c] += rgba[c];
}

/* The mean of the light in a pixel whose middle is (x, y) from that of the picture; how many places it has. */
static uint64_t light_of(float out[4], const layer *l, double x, double y)
{
    const int nx = l->places[0], ny = l->places[1];
    float sum[4] = {0};
    for (int k = 0; k < ny; k++)
        for (int i = 0; i < nx; i++)
            add_place(sum, l, x + (i + 0.5) / nx - 0.5, y + (k + 0.5) / ny - 0.5);
    for (int c = 0; c < 4; c++)
        out[c] = sum[c] / (float)(nx * ny);
    return (uint64_t)nx * (uint64_t)ny;
}

static void blend(float pixel[4], const float light[4], int how)
{
    const float through = how == VV_SLICE_ADD ? 1 : 1 - light[3];
    for (int c = 0; c < 3; c++)
        pixel[c] = light[c] + through * pixel[c];
    pixel[3] = light[3] + (1 - light[3]) * pixel[3];
}

/* Distance from the eye, which is not along the line of sight in perspective. */
static double depth_at(const slice_state *s, double px, double py)
{
    vv_vec3 origin, direction;
    vvi_lens_ray(&origin, &direction, &s->scene->lens, s->scene->width, s->scene->height, px, py);
    return s->distance / vvi_dot(direction, s->scene->lens.forward);
}

static void draw_pixel(const slice_state *s, vv_image *image, size_t at, double px, double py, vv_render_counts *counts)
{
    const double x = px - 0.5 * s->scene->width, y = py - 0.5 * s->scene->height;
    float *pixel = image->rgba + 4 * at;
    for (size_t i = 0; i < s->n; i++) {
        float light[4];
        counts->samples += light_of(light, &s->layers[i], x, y);
        blend(pixel, light, s->layers[i].actor->slices.blend);
    }
    counts->rays++;
    if (image->depth && pixel[3] > 0)
        image->depth[at] = (float)depth_at(s, px, py);
}

static vv_status render(void *state, const vv_pass *pass, const vv_tile *tile, vv_image *image,
                        vv_render_counts *counts, vv_job *job)
{
    const slice_state *s = state;
    if (!(s->distance > 0)) /* behind the eye */
        return VV_OK;
    for (int32_t y = tile->y0; y < tile->y1; y++) {
        for (int32_t x = tile->x0; x < tile->x1; x++)
            draw_pixel(s, image, (size_t)y * (size_t)image->width + (size_t)x, (double)x * pass->stride + pass->x,
                       (double)y * pass->stride + pass->top + pass->y, counts);
        const vv_status st = vvi_job_poll(job);
        if (st != VV_OK)
            return st;
    }
    return VV_OK;
}

/* A threshold is no surface here. */
/* NOLINTNEXTLINE(readability-non-const-parameter): the table has one type for all renderers */
static bool solid(double *lo, double *hi, const vv_scene *scene, const vv_actor *actor)
{
    (void)lo;
    (void)hi;
    (void)scene;
    (void)actor;
    return false;
}

/* Transfer functions where a volume's slices ask for their colours. */
static bool heeds(const vv_object *params, vv_aspect aspect)
{
    const int way = ((const vvi_slice_params *)params)->orientation;
    return aspect == VV_ASPECT_WINDOW || aspect == VV_ASPECT_CROSS_HAIR || aspect == VV_ASPECT_TRANSFER ||
           aspect == VV_ASPECT_OPACITY || aspect == VV_ASPECT_COLOR ||
           (aspect == VV_ASPECT_DIRECTION && way == VVI_SLICE_CAMERA);
}

const vv_renderer vvi_renderer_slice = {
    .api = VV_RENDERER_API,
    .name = "slice",
    .label = "Slice",
    .doc = "a plane through the cross-hair: its values over a window, its labels and colours, as slice viewers show "
           "them; axial, coronal, sagittal or at any angle",
    .params = &slice_class,
    .takes = VV_CONTENT_SAMPLES,
    .accepts = accepts,
    .prepare = prepare,
    .render = render,
    .finish = finish,
    .solid = solid,
    .can = VV_CAN_LEAVE_OUT,
    .plane = plane,
    .heeds = heeds,
};
