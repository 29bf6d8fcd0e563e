/** @file
 * How a scene is worked out: what lies behind a vv_scene, and the steps.
 */
#ifndef VVI_SCENE_RESOLVE_H
#define VVI_SCENE_RESOLVE_H
#include "scene/lens.h"
#include "scene/transfer_fit.h"
#include <volvis/sys/scene.h>

/** A scene and what only its maker needs. The scene stands first: the two have one address. */
typedef struct vvi_resolved {
    vv_scene scene;
    const vv_registry *registry;
    const char *view_id; /**< the World's */
    vvi_aim aim;
    bool planar;   /**< the directions of the aim are the method's own */
    double load_s; /**< reading data */
} vvi_resolved;

/** One volume being worked out; fields the later steps need. */
typedef struct vvi_cast {
    const vv_world *world;
    const vv_volume *volume;
    vv_actor *actor;
    const char *path; /**< "volumes.head" */
    vvi_value_fit fit;
    vvi_value_fit magnitude; /**< where two_sided */
    bool two_sided;          /**< zero is the background, and nobody chose a range */
    double voxel;            /**< smallest spacing in the World */
    vv_ray_value projects;
    bool amounts; /**< values are shown, or a surface of one: not labels that nobody calls so */
} vvi_cast;

/** Data, statistics, place, planes, shading, classification, for a method with its parameters in the view. What was
 * made is in the actor, on failure too. */
vv_status vvi_resolve_actor(vv_actor *actor, double *load_s, const vv_world *world, const char *id,
                            const vv_volume *volume, const vv_renderer *renderer, const vv_object *params, vv_job *job);
void vvi_actor_finish(vv_actor *actor);
/** Of an actor that has its field and statistics: samples that stand for no value become NaN. path: of the volume, for
 * the log; NULL: nothing is said. */
vv_status vvi_resolve_missing(vv_actor *actor, const vv_volume *volume, const char *path, vv_job *job);

/** A method's parameters for one volume: the view's (NULL: there are none), and what the volume's `rays` say instead.
 * Yours to release. */
vv_status vvi_volume_params(vv_object **out, const vv_object *params, const vv_volume *volume);
/** Whether a method with these parameters (NULL: none) shows one value of each ray. */
vv_ray_value vvi_renderer_projects(const vv_renderer *renderer, const vv_object *params);
/** Whether it does so of a volume; of all that the scene shows. */
bool vvi_actor_projects(const vv_scene *scene, const vv_actor *actor);
bool vvi_scene_projects(const vv_scene *scene);
vv_ray_layer vvi_ray_layer_of(const vv_volume *volume);
/** A channel: its colour map is one colour. */
bool vvi_is_channel(const vv_transfer *transfer);

/** Of a scene whose actors are worked out: amounts that nobody gave an opacity are a veil where labels are shown as
 * well. */
void vvi_veil_amounts(vv_scene *scene, vv_job *job);

/** Mesh, normals, place, planes, shading, colours. What was made is in the shape, on failure too. */
vv_status vvi_resolve_mesh_actor(vv_mesh_actor *shape, double *load_s, const vv_world *world, const char *id,
                                 const vv_volume *volume, vv_job *job);
/** Where surfaces of volumes, meshes and parts of meshes that nobody gave a colour are more than one, each gets its
 * own: those of labels; the first volume keeps that of one alone. */
vv_status vvi_tell_actors_apart(vv_scene *scene, vv_job *job);
void vvi_shape_finish(vv_mesh_actor *shape);

/** Of a scene that has its view, renderer and actors: its layers, how many rays per pixel gets, and when that is
 * enough. */
void vvi_resolve_sampling(vv_scene *scene);

/** What the World's visible volumes are: bits of vv_content. */
unsigned vvi_contents_of(const vv_world *world, vv_job *job);
/** The method of a view: what was chosen, else what can show the World's visible volumes. */
const char *vvi_method_of(const vv_world *world, const vv_view *view, vv_job *job);

/** Of a volume, and of a mesh: the dataset that it shows; planes and shading, which are in the actor then; the map from
 * the data's own lengths (`own`, in `unit`) to the World, and that of data in the World's unit. */
vv_status vvi_find_dataset(const vv_dataset **out, const vv_world *world, const vv_volume *volume, const char *path);
vv_status vvi_place_data(vv_affine *out, vv_affine *data_to_world_out, vv_affine own, const char *unit,
                         const vv_world *world, const vv_volume *volume, const char *path);
vv_status vvi_resolve_planes(vv_actor *actor, const vv_world *world, const vv_volume *volume,
                             const vv_affine *data_to_world, const char *path, vv_job *job);
void vvi_resolve_shading(vv_actor *actor, const vv_world *world, const vv_volume *volume);

/** Colours of values from lo to hi that have no samples, by the volume's transfer function: classes.color. */
vv_status vvi_resolve_value_colors(vvi_cast *cast, double lo, double hi, const char *unit, vv_job *job);

/** Smallest spacing of an actor's grid where it stands in the World; axes of one sample have none unless all do. */
double vvi_actor_voxel(const vv_actor *actor);

/** The eight corners of an actor's interpolation domain in the World. */
void vvi_actor_corners(vv_vec3 out[8], const vv_actor *actor);

/** The same of a mesh's box. */
void vvi_shape_corners(vv_vec3 out[8], const vv_mesh_actor *shape);
/** Of what is seen: of the first volume, else of the first mesh. */
vv_space vvi_scene_space(const vv_scene *scene);
/** The World's; left open, of the first mesh where no volume is seen. */
vv_up vvi_scene_up(const vv_scene *scene);

/** Nodes, colours, threshold or labels of a volume whose field and statistics are known. */
vv_status vvi_resolve_classes(vvi_cast *cast, vv_job *job);

/** Colours by the values of another field, which is loaded. */
vv_status vvi_resolve_paint(vvi_cast *cast, vv_job *job);
/** Of a loaded paint: whether its values are labels, which nobody says. */
vv_status vvi_sense_label_paint(const vvi_cast *cast, vv_job *job);
/** Colours of labels, where nobody gave other ones; out: whether they are. */
vv_status vvi_resolve_label_paint(bool *out, const vvi_cast *cast, const vv_dataset *dataset, vv_job *job);
/** The actor's paint, where its volume has one: another dataset that gives the colours, loaded, and placed as the
 * volume is. */
vv_status vvi_load_paint(vvi_cast *cast, const vv_affine *data_to_world, vv_job *job);

/** How slices show an actor. */
void vvi_resolve_slices(vv_scene *scene, size_t actor);

/** Whether a volume asks for a texture. */
bool vvi_has_texture(const vv_volume *volume);
/** The texture of a volume whose field is loaded and placed. */
vv_status vvi_resolve_texture(vvi_cast *cast, const vv_affine *data_to_world, vv_job *job);

/** Seconds of a clock that never goes back. */
double vvi_render_clock(void);

#endif
