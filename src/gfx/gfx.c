/* What all back ends share: arguments are checked, state is kept. */
#include "gfx/gfx.h"
#include "core/job.h"
#include "gfx/backend.h"
#include <string.h>

static const vvi_gfx_backend *const backends[] = {&vvi_gfx_software, &vvi_gfx_svg};
enum { BACKENDS = sizeof backends / sizeof backends[0] };

const vvi_gfx_backend *vvi_gfx_backend_nth(size_t index)
{
    return index < BACKENDS ? backends[index] : NULL;
}

const char *vvi_gfx_backend_name(const vvi_gfx_backend *backend)
{
    return backend->name;
}

/* Kept memory ----------------------------------------------------------------------------------------------------- */

typedef struct vvi_gfx_kept {
    struct vvi_gfx_kept *before;
    double data[]; /* aligned for all that is kept */
} kept;

void *vvi_gfx_keep(vvi_gfx *gfx, size_t bytes)
{
    kept *k = vvi_alloc(gfx->job, sizeof *k + bytes, VVI_MEM_SCRATCH);
    if (!k)
        return NULL;
    k->before = gfx->kept;
    gfx->kept = k;
    return k->data;
}

vv_status vvi_gfx_list_add(vvi_gfx_list *list, void *item, vv_job *job)
{
    if (list->n == list->room) {
        const size_t room = list->room ? 2 * list->room : 16;
        void **more = vvi_realloc(job, list->item, room * sizeof *more, VVI_MEM_SCRATCH);
        if (!more)
            return vv_fail_memory(room * sizeof *more);
        list->item = more;
        list->room = room;
    }
    list->item[list->n++] = item;
    return VV_OK;
}

void vvi_gfx_list_free(vvi_gfx_list *list)
{
    vvi_free(list->item);
    *list = (vvi_gfx_list){0};
}

/* Begin and end --------------------------------------------------------------------------------------------------- */

static vv_status check_target(vvi_gfx_target *target, const vvi_gfx_backend *backend)
{
    const vv_image *image = target->image;
    if (image && !target->width && !target->height) {
        target->width = image->width;
        target->height = image->height;
    }
    if (target->width < 1 || target->height < 1 || target->width > VVI_GFX_SIZE_MOST ||
        target->height > VVI_GFX_SIZE_MOST)
        return vv_fail(VV_E_ARGUMENT, "a picture of %d x %d pixels cannot be drawn: expected 1 x 1 to %d x %d",
                       target->width, target->height, VVI_GFX_SIZE_MOST, VVI_GFX_SIZE_MOST);
    if (image && (image->width != target->width || image->height != target->height))
        return vv_fail(VV_E_ARGUMENT, "the image has %d x %d pixels and the picture %d x %d: they must be equal",
                       image->width, image->height, target->width, target->height);
    if (!target->samples)
        target->samples = 4;
    if (target->samples != 1 && target->samples != 4 && target->samples != 8)
        return vv_fail(VV_E_ARGUMENT, "%d samples per pixel: expected 1, 4 or 8", target->samples);
    if (!(backend == &vvi_gfx_software ? image != NULL : target->svg != NULL))
        return vv_fail(VV_E_ARGUMENT, "back end '%s' has nothing to draw on", backend->name);
    return VV_OK;
}

vvi_gfx_material vvi_gfx_material_default(void)
{
    return (vvi_gfx_material){
        .model = VV_SHADING_BLINN, .ambient = 0.15f, .diffuse = 0.75f, .specular = 0.25f, .shininess = 30};
}

vv_status vvi_gfx_begin(vvi_gfx **out, const vvi_gfx_backend *backend, const vvi_gfx_target *target, vv_job *job)
{
    static const vvi_gfx_light_set dark = {0};
    static const vvi_gfx_cut_set whole = {0};
    vvi_gfx_target checked = *target;
    *out = NULL;
    vv_status st = check_target(&checked, backend);
    if (st != VV_OK)
        return st;
    vvi_gfx *gfx = vvi_alloc_zeroed(job, sizeof *gfx, VVI_MEM_SCRATCH);
    if (!gfx)
        return vv_fail_memory(sizeof *gfx);
    gfx->backend = backend;
    gfx->job = job;
    gfx->target = checked;
    gfx->state = (vvi_gfx_state){.lights = &dark, .cuts = &whole, .depth = true, .id = 1};
    vvi_gfx_set_material(gfx, NULL);
    vvi_gfx_window(gfx, 0, 0, 0, 0);
    if ((st = backend->begin(gfx)) != VV_OK) {
        vvi_gfx_abandon(gfx);
        return st;
    }
    *out = gfx;
    return VV_OK;
}

void vvi_gfx_abandon(vvi_gfx *gfx)
{
    if (!gfx)
        return;
    gfx->backend->close(gfx);
    while (gfx->kept) {
        kept *k = gfx->kept;
        gfx->kept = k->before;
        vvi_free(k);
    }
    vvi_free(gfx);
}

static vv_status no_camera(const vvi_gfx *gfx)
{
    return vv_fail(gfx->failed, "there was no memory for the camera of a picture");
}

vv_status vvi_gfx_end(vvi_gfx *gfx)
{
    if (!gfx)
        return VV_OK;
    const vv_status st = gfx->failed == VV_OK ? gfx->backend->end(gfx) : no_camera(gfx);
    vvi_gfx_abandon(gfx);
    return st;
}

/* State ----------------------------------------------------------------------------------------------------------- */

vvi_gfx_view vvi_gfx_view_of(const vv_lens *lens, int32_t width, int32_t height)
{
    return (vvi_gfx_view){.lens = *lens,
                          .scale_x = 0.5 * width / lens->half_width,
                          .scale_y = 0.5 * height / lens->half_height,
                          .middle_x = 0.5 * width,
                          .middle_y = 0.5 * height};
}

void vvi_gfx_camera(vvi_gfx *gfx, const vv_lens *lens)
{
    gfx->state.view = NULL;
    if (!lens)
        return;
    vvi_gfx_view *view = vvi_gfx_keep(gfx, sizeof *view);
    if (!view) {
        gfx->failed = vv_fail_memory(sizeof *view);
        return;
    }
    *view = vvi_gfx_view_of(lens, gfx->target.width, gfx->target.height);
    view->middle_x += gfx->target.shift[0];
    view->middle_y += gfx->target.shift[1];
    gfx->state.view = view;
}

vv_status vvi_gfx_lights(vvi_gfx *gfx, const vv_lamp *lamps, size_t n_lamps, const float ambient[3])
{
    vvi_gfx_light_set *set = vvi_gfx_keep(gfx, sizeof *set + n_lamps * sizeof *lamps);
    if (!set)
        return vv_fail_memory(sizeof *set + n_lamps * sizeof *lamps);
    *set = (vvi_gfx_light_set){.lamps = (vv_lamp *)(set + 1), .n_lamps = n_lamps};
    if (n_lamps)
        memcpy(set->lamps, lamps, n_lamps * sizeof *lamps);
    if (ambient)
        memcpy(set->ambient, ambient, sizeof set->ambient);
    gfx->state.lights = set;
    return VV_OK;
}

void vvi_gfx_set_material(vvi_gfx *gfx, const vvi_gfx_material *material)
{
    gfx->state.material = material ? *material : vvi_gfx_material_default();
}

vv_status vvi_gfx_cuts(vvi_gfx *gfx, const vv_plane *planes, size_t n_planes)
{
    vvi_gfx_cut_set *set = vvi_gfx_keep(gfx, sizeof *set + n_planes * sizeof *planes);
    if (!set)
        return vv_fail_memory(sizeof *set + n_planes * sizeof *planes);
    *set = (vvi_gfx_cut_set){.planes = (vv_plane *)(set + 1), .n_planes = n_planes};
    if (n_planes)
        memcpy(set->planes, planes, n_planes * sizeof *planes);
    gfx->state.cuts = set;
    return VV_OK;
}

void vvi_gfx_window(vvi_gfx *gfx, double x0, double y0, double x1, double y1)
{
    double *w = gfx->state.window;
    const bool whole = x0 == 0 && y0 == 0 && x1 == 0 && y1 == 0;
    w[0] = fmax(x0, 0);
    w[1] = fmax(y0, 0);
    w[2] = whole ? gfx->target.width : fmin(x1, gfx->target.width);
    w[3] = whole ? gfx->target.height : fmin(y1, gfx->target.height);
}

void vvi_gfx_depth(vvi_gfx *gfx, bool test)
{
    gfx->state.depth = test;
}

void vvi_gfx_id(vvi_gfx *gfx, uint32_t id)
{
    gfx->state.id = id;
}

/* Drawing --------------------------------------------------------------------------------------------------------- */

static vv_status cannot(const vvi_gfx *gfx, const char *what)
{
    return vv_fail(VV_E_UNSUPPORTED, "back end '%s' cannot draw %s", gfx->backend->name, what);
}

vv_status vvi_gfx_mesh(vvi_gfx *gfx, const vvi_gfx_surface *surface)
{
    if (!gfx->backend->mesh)
        return cannot(gfx, "meshes");
    if (gfx->failed != VV_OK)
        return no_camera(gfx);
    if (!gfx->state.view)
        return vv_fail(VV_E_ARGUMENT, "a mesh cannot be drawn in pixels: set a camera first");
    vv_affine inverse;
    if (!vv_affine_invert(&inverse, surface->place))
        return vv_fail(VV_E_ARGUMENT, "a mesh is placed without thickness: give it three directions");
    return surface->mesh->n_triangles ? gfx->backend->mesh(gfx, surface) : VV_OK;
}

static vv_status check_points(const vv_vec3 *points, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!vvi_finite(points[i]))
            return vv_fail(VV_E_ARGUMENT, "point %zu of what is to be drawn is not finite", i);
    return VV_OK;
}

static vv_status check_length(double length, const char *what)
{
    if (length > 0 && isfinite(length))
        return VV_OK;
    return vv_fail(VV_E_ARGUMENT, "%s is %g pixels: it must be more than 0", what, length);
}

vv_status vvi_gfx_line(vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, vvi_gfx_join join,
                       const vvi_gfx_stroke *stroke)
{
    if (!gfx->backend->line)
        return cannot(gfx, "lines");
    vv_status st = check_length(stroke->width, "the width of a line");
    if (st == VV_OK && stroke->dash != 0 && (st = check_length(stroke->dash, "a dash")) == VV_OK)
        st = check_length(stroke->space, "the space between dashes");
    if (st != VV_OK || (st = check_points(points, n_points)) != VV_OK || n_points < 2)
        return st;
    return gfx->backend->line(gfx, points, n_points, join, stroke);
}

vv_status vvi_gfx_points(vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, double diameter, vv_color color)
{
    if (!gfx->backend->points)
        return cannot(gfx, "points");
    vv_status st = check_length(diameter, "the diameter of a point");
    if (st != VV_OK || (st = check_points(points, n_points)) != VV_OK || !n_points)
        return st;
    return gfx->backend->points(gfx, points, n_points, diameter, color);
}

vv_status vvi_gfx_polygon(vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, const vvi_gfx_fill *fill)
{
    if (!gfx->backend->polygon)
        return cannot(gfx, "polygons");
    const vv_status st = check_points(points, n_points);
    if (st != VV_OK || n_points < 3)
        return st;
    return gfx->backend->polygon(gfx, points, n_points, fill);
}

vv_status vvi_gfx_rectangle(vvi_gfx *gfx, double x0, double y0, double x1, double y1, const vvi_gfx_fill *fill)
{
    if (gfx->state.view)
        return vv_fail(VV_E_ARGUMENT, "a rectangle is drawn in pixels: set no camera, or draw a polygon");
    const vv_vec3 corners[4] = {{x0, y0, 0}, {x1, y0, 0}, {x1, y1, 0}, {x0, y1, 0}};
    return vvi_gfx_polygon(gfx, corners, 4, fill);
}

static vv_status check_text(const char *utf8)
{
    for (const char *s = utf8; *s;) {
        const size_t n = vvi_utf8_length(s);
        if (!n || (unsigned char)*s < 32 || *s == 127)
            return vv_fail(VV_E_ARGUMENT, "byte %zu of a text to be drawn is not part of a line of UTF-8",
                           (size_t)(s - utf8));
        s += n;
    }
    return VV_OK;
}

vv_status vvi_gfx_text(vvi_gfx *gfx, vv_vec3 at, const vvi_gfx_label *label, const char *utf8)
{
    if (!gfx->backend->text)
        return cannot(gfx, "text");
    vv_status st = check_text(utf8);
    if (st != VV_OK || (st = check_points(&at, 1)) != VV_OK ||
        (st = check_length(label->size, "the size of a text")) != VV_OK || !*utf8)
        return st;
    return gfx->backend->text(gfx, at, label, utf8);
}

vv_status vvi_gfx_pick(vvi_gfx_picked *out, vvi_gfx *gfx, double x, double y, double beyond)
{
    *out = (vvi_gfx_picked){.depth = INFINITY};
    if (!gfx->backend->pick)
        return vv_fail(VV_E_UNSUPPORTED, "back end '%s' cannot tell what is at a point", gfx->backend->name);
    return gfx->backend->pick(out, gfx, x, y, beyond);
}
