/** @file
 * Volumes drawn as triangles. Rows: vvi_renderer_surface (Marching Cubes at full resolution), vvi_renderer_reduced and
 * vvi_renderer_boxes (the Navigator's two coarse representations). Meshes are kept in the runtime's cache, so that
 * another view of the same surface costs only the drawing.
 */
#ifndef VVI_RENDER_SURFACE_H
#define VVI_RENDER_SURFACE_H
#include "render/common/mesh_caps.h"
#include <volvis/mesh.h>
#include <volvis/sys/scene.h>

/** views.<view>.render.surface, .reduced, .boxes; each class has the rows that it needs. */
typedef struct vvi_surface_params {
    vv_object base;
    double iso;        /**< value */
    int64_t triangles; /**< at most, of each surface */
    int filter;        /**< vvi_reduced_filter: what becomes of samples that are left out */
    double memory;     /**< bytes of the mesh of each, at most; 0: no limit */
    bool merged;
    double smoothing; /**< of labels, voxels */
} vvi_surface_params;

extern const vv_class vvi_surface_class, vvi_reduced_class, vvi_boxes_class;

/** Which triangles stand for a surface. */
typedef struct vvi_surface_request {
    const vv_actor *actor;
    const vv_field *field;
    int component;
    double value;
    const vvi_surface_params *params;
} vvi_surface_request;
/** What stands for one side of a solid; the cache keeps it. */
typedef struct vvi_surface_model {
    vv_mesh *mesh;     /**< NULL: there are no triangles */
    vv_field *samples; /**< that tell inside from outside as the triangles do; NULL: the volume's own */
    bool blocks;  /**< each is of all places around it, and they reach where the volume does; else linear between */
    double least; /**< samples of the inside, where this is the lower side; */
    double most;  /**< where it is the upper one */
} vvi_surface_model;
/** That a mesh takes in memory. */
uint64_t vvi_surface_bytes(const vv_mesh_info *info);
/** Fills in a zeroed model; what is in it is freed also on failure. */
typedef vv_status vvi_surface_make_fn(vvi_surface_model *out, const vvi_surface_request *request, vv_job *job);

/** One volume of a frame: its solid's lower and upper side. */
typedef struct vvi_surface_volume {
    const vv_actor *actor;
    double lo, hi;               /**< values of the solid, both inclusive; hi may be infinite */
    struct vvi_cached *model[2]; /**< vvi_surface_model, NULL where no value lies beyond; of labels the first alone */
    bool labels;
    bool border; /**< the solid reaches the border of the data, or cuts go through it: it shows faces there */
} vvi_surface_volume;

typedef struct vvi_surface_state {
    const vv_scene *scene;
    vvi_surface_volume *volumes; /**< one for each actor */
    size_t n_volumes;
    vvi_mesh_caps caps;  /**< where meshes are cut */
    vv_mesh_info *shown; /**< of each mesh, and of each of their caps: what is drawn of it */
} vvi_surface_state;

/** The values that make an actor solid; false for labels. */
bool vvi_surface_solid(double *lo_out, double *hi_out, const vv_scene *scene, const vv_actor *actor);
/** The mesh of an actor's labels, a part for each in its colour; none where none is visible. */
vv_status vvi_surface_make_labels(vvi_surface_model *out, const vvi_surface_request *request, vv_job *job);
/** Of all that it depends on but the samples. */
uint64_t vvi_surface_hash_labels(const vvi_surface_request *request);

/** Not of labels, which have no surface of one value. */
vv_status vvi_surface_accepts(const vv_scene *scene);
/** `what`: a string literal, of the cache's key. */
vv_status vvi_surface_prepare(void **state_out, const vv_scene *scene, const char *what, vvi_surface_make_fn *make,
                              vv_job *job);
/** From where the samples of a field lie to where the volume was put. */
vv_status vvi_surface_place(vv_affine *out, const vv_actor *actor);
void vvi_surface_finish(void *state); /* NULL is fine */
vv_status vvi_surface_draw(void *state, vv_image *image, int64_t samples, int64_t *samples_out,
                           vv_render_counts *counts, vv_job *job);
/** All but transfer functions: a surface has the volume's colour. */
bool vvi_surface_heeds(const vv_object *params, vv_aspect aspect);
vv_status vvi_surface_figure(void *state, struct vvi_gfx *gfx, vv_image *under, vv_job *job);

/** The faces that solids show where they are cut or where the data end: for each ray whose first point in a volume lies
 * inside of its solid, exactly; of coarser surfaces the inside is that of their own samples or boxes. Onto a clear
 * image, `side` x `side` rays a pixel. */
vv_status vvi_surface_caps(vv_image *image, const vvi_surface_state *state, int side, vv_job *job);
#endif
