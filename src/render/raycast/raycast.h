/** @file
 * Ray casting: the parameters, and what one frame prepares. Rows: vvi_renderer_raycast.
 */
#ifndef VVI_RENDER_RAYCAST_H
#define VVI_RENDER_RAYCAST_H
#include "grid/bricks.h"
#include "render/common/texture.h"
#include "render/common/transfer_plane.h"
#include "render/march/kernels.h"
#include "render/raycast/mesh_rays.h"
#include <volvis/model.h>

/** Whether a mode shows one value of each ray. */
static inline bool vvi_raycast_projects(int mode)
{
    return mode != VV_RAY_COMPOSITE && mode != VV_RAY_ISOSURFACE;
}

typedef enum vvi_raycast_lighting { VVI_LIGHTING_LOCAL, VVI_LIGHTING_CINEMATIC } vvi_raycast_lighting;

typedef enum vvi_raycast_gradient { VVI_GRADIENT_CENTRAL, VVI_GRADIENT_CELL } vvi_raycast_gradient;

/** views.<view>.render.raycast */
typedef struct vvi_raycast_params {
    vv_object base;
    int mode;    /**< vv_ray_mode */
    double iso;  /**< value */
    double step; /**< world length */
    double opaque;
    double threshold; /**< value */
    int gradient;
    bool jitter, skipping, parc, preintegrated;
    int64_t halvings;
    int lighting;
    bool shadows, ambient_occlusion;
    double occlusion_radius; /**< world length */
    double lamp_size;        /**< radians */
} vvi_raycast_params;

extern const vv_class vvi_raycast_class;

/** One volume of a frame: what kernels get, with what it holds on to. */
typedef struct vvi_raycast_volume {
    const vvi_raycast_params *params; /**< as they are for it */
    const vv_actor *actor;            /**< the scene's, or `halved` */
    vv_actor halved; /**< that with fewer samples, or with numbers for labels; its field is the volume's own. NULL
                          field: none */
    struct vvi_cached *ids; /**< which labels the numbers stand for; NULL: labels are as they are */
    vvi_march_volume ray;   /**< all that kernels get */
    vvi_ray_kernel *kernel; /**< of this volume alone; NULL where only that of several shows it */
    bool solid;             /**< seen as a surface */
    bool layer;             /**< shows one value of each ray, over all that does not */
    bool visible;           /**< some block of it may show something */
    vvi_lattice_hold hold;
    struct vvi_cached *minmax, *skip, *boxes;
    vvi_parc parc;
    float *alpha, *seen, *color;
    size_t n_rows;                          /**< of all three */
    struct vvi_transfer_integral *integral; /**< NULL: none */
    vvi_transfer_plane plane;
    struct vvi_cached *colors; /**< the volume's own, as a vv_field */
    vv_brick colors_brick;     /**< of them */
    vvi_lattice_hold paint;    /**< the values that colour it */
    float *paint_color;
    vvi_texture texture;
    double gradient_unit; /**< kernels' gradients are stored numbers per world length times this */
} vvi_raycast_volume;

/** A frame. Tests make one to compare kernels with the reference. Surfaces and meshes are found first, the nearest
 * along each ray; clouds are then in front of them, one by its own kernel, several blended.
 * Layers lie over the light of all these, one after the other in the order of volumes. */
typedef struct vvi_raycast_state {
    vvi_raycast_volume volume[VVI_BLEND_VOLUMES];
    size_t n_volumes;
    const vvi_ray_kernels *kernels;
    vvi_eye eye;       /**< of the view; which pass, says the pass */
    size_t n_surfaces; /**< volumes that are solid and visible */
    size_t n_layers;
    const vvi_raycast_volume *cloud; /**< the only cloud, if a kernel of one volume draws it */
    vvi_ray_meshes meshes;
    vvi_light_volume light;                /**< how much of it arrives where; cells NULL: all */
    struct vvi_cached *cells, *scattered;  /**< of it */
    vvi_blend_setup blend;                 /**< of the others; n_volumes 0: nothing to blend */
    vvi_bricks *bricks[VVI_BLEND_VOLUMES]; /**< of volumes that have some, each once, by their addresses */
    size_t n_bricks;
} vvi_raycast_state;

/** Whether more than the table decides what is seen: plain kernels have no more. */
bool vvi_raycast_needs_more(const vvi_raycast_volume *v);

/** Whether it is one cloud by a table of its values, or one solid. */
static inline bool vvi_raycast_is_plain(const vvi_raycast_state *s)
{
    const vvi_raycast_volume *v = &s->volume[0];
    return s->n_volumes == 1 && !v->layer && (v->solid || !vvi_raycast_needs_more(v));
}

/** Whether these parameters show a volume as a solid, and the values that it has. */
bool vvi_raycast_solid(double *lo_out, double *hi_out, const vvi_raycast_params *p, const vv_actor *actor);

/** What a lighting does besides. */
typedef struct vvi_lighting {
    bool shadows, ambient_occlusion;
    float ambient; /**< times the ambient light */
} vvi_lighting;
/** What these parameters ask for. */
vvi_lighting vvi_raycast_lighting_of(const vvi_raycast_params *params);

vv_status vvi_raycast_prepare(void **state_out, const vv_scene *scene, vv_job *job);
void vvi_raycast_finish(void *state); /* NULL is fine */

/** Brute force in double precision, one pixel, no skipping and no early end beyond the frame's own `opaque`: the
 * definition of the right answer. rgba premultiplied; *depth_out INFINITY where nothing is. */
void vvi_raycast_ref(double rgba_out[4], double *depth_out, const vv_scene *scene, const vvi_raycast_state *state,
                     int32_t x, int32_t y);
#endif
