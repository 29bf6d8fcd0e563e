/** @file
 * What a back end is, and what all of them share: the state, kept copies, places on the picture.
 */
#ifndef VVI_GFX_BACKEND_H
#define VVI_GFX_BACKEND_H
#include "core/memory.h"
#include "core/vec.h"
#include "gfx/gfx.h"

enum { VVI_GFX_SIZE_MOST = 16384 };

typedef struct vvi_gfx_light_set {
    vv_lamp *lamps;
    size_t n_lamps;
    float ambient[3];
} vvi_gfx_light_set;

typedef struct vvi_gfx_cut_set {
    vv_plane *planes;
    size_t n_planes;
} vvi_gfx_cut_set;

/** A camera and a picture: how the world becomes pixels. */
typedef struct vvi_gfx_view {
    vv_lens lens;
    double scale_x, scale_y; /**< pixels a unit of (right, up) / forward, or of (right, up) where it is parallel */
    double middle_x, middle_y;
} vvi_gfx_view;

/** What drawing calls see; the sets and the view are kept copies, shared by all that was drawn with them. */
typedef struct vvi_gfx_state {
    const vvi_gfx_view *view; /**< NULL: pixels */
    const vvi_gfx_light_set *lights;
    const vvi_gfx_cut_set *cuts;
    vvi_gfx_material material;
    double window[4]; /**< x0, y0, x1, y1, within the picture */
    bool depth;
    uint32_t id;
} vvi_gfx_state;

struct vvi_gfx {
    const vvi_gfx_backend *backend;
    vv_job *job;
    vvi_gfx_target target; /**< with no size or number of samples left open */
    vvi_gfx_state state;
    struct vvi_gfx_kept *kept; /**< copies, given back at the end */
    vv_status failed;          /**< a copy that state needs could not be made: what vvi_gfx_end() fails with */
    void *own;                 /**< the back end's */
};

/** One row: a kind of output. Arguments have been checked; state is in gfx->state. NULL: it cannot. */
struct vvi_gfx_backend {
    const char *name, *doc;
    vv_status (*begin)(vvi_gfx *gfx);
    vv_status (*mesh)(vvi_gfx *gfx, const vvi_gfx_surface *surface);
    vv_status (*line)(vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, vvi_gfx_join join,
                      const vvi_gfx_stroke *stroke);
    vv_status (*points)(vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, double diameter, vv_color color);
    vv_status (*polygon)(vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, const vvi_gfx_fill *fill);
    vv_status (*text)(vvi_gfx *gfx, vv_vec3 at, const vvi_gfx_label *label, const char *utf8);
    vv_status (*pick)(vvi_gfx_picked *out, vvi_gfx *gfx, double x, double y, double beyond);
    vv_status (*end)(vvi_gfx *gfx);
    void (*close)(vvi_gfx *gfx); /**< after end, or without it; gfx->own may be NULL */
};

/** Memory that lives as long as the picture. NULL when refused. */
void *vvi_gfx_keep(vvi_gfx *gfx, size_t bytes);

/** Back ends: a growing array of pointers to what was drawn. */
typedef struct vvi_gfx_list {
    void **item;
    size_t n, room;
} vvi_gfx_list;
vv_status vvi_gfx_list_add(vvi_gfx_list *list, void *item, vv_job *job);
void vvi_gfx_list_free(vvi_gfx_list *list);

vvi_gfx_view vvi_gfx_view_of(const vv_lens *lens, int32_t width, int32_t height);
/** Along right, up and forward from the eye. */
static inline vv_vec3 vvi_gfx_to_eye(const vvi_gfx_view *view, vv_vec3 world)
{
    const vv_vec3 p = vvi_sub(world, view->lens.eye);
    return vvi_vec(vvi_dot(p, view->lens.right), vvi_dot(p, view->lens.up), vvi_dot(p, view->lens.forward));
}

/** A place on the picture. near: 1 / forward, or - forward where the lens is parallel; linear along what is straight in
 * the world, and larger is nearer. */
typedef struct vvi_gfx_spot {
    double x, y, near;
} vvi_gfx_spot;

/** Of a place before the eye, (right, up, forward). */
static inline vvi_gfx_spot vvi_gfx_spot_of(const vvi_gfx_view *view, vv_vec3 eye)
{
    const double w = view->lens.parallel ? 1 : 1 / eye.z;
    return (vvi_gfx_spot){view->middle_x + view->scale_x * eye.x * w, view->middle_y - view->scale_y * eye.y * w,
                          view->lens.parallel ? -eye.z : w};
}
/** Length of the ray through a pixel place from the eye to the plane at forward 1. */
static inline double vvi_gfx_slant(const vvi_gfx_view *view, double x, double y)
{
    const double a = (x - view->middle_x) / view->scale_x, b = (y - view->middle_y) / view->scale_y;
    return view->lens.parallel ? 1 : sqrt(1 + a * a + b * b);
}
/** Depth as of images. */
static inline double vvi_gfx_depth_of(const vvi_gfx_view *view, double x, double y, double near)
{
    return view->lens.parallel ? -near : vvi_gfx_slant(view, x, y) / near;
}
/** The reverse; of INFINITY what is below every place. */
static inline double vvi_gfx_near_of(const vvi_gfx_view *view, double x, double y, double depth)
{
    return view->lens.parallel ? -depth : vvi_gfx_slant(view, x, y) / depth;
}
#endif
