/** @file
 * A resolved scene: one View of a World snapshot with every automatic value worked out, as renderers see it.
 */
#ifndef VOLVIS_SYS_SCENE_H
#define VOLVIS_SYS_SCENE_H
#include <volvis/mesh.h>
#include <volvis/model.h>
#include <volvis/sys/registry.h>
VV_BEGIN_DECLS

/** A camera ready for rays. Pixel (x, y) centre: ndc = ((x + 0.5) / w * 2 - 1, 1 - (y + 0.5) / h * 2). */
typedef struct vv_lens {
    vv_vec3 eye, right, up, forward; /**< unit axes; forward is where one looks */
    double half_width, half_height;  /**< perspective: tangents of half angles; parallel: world units */
    bool parallel;
} vv_lens;

/** A light in world space. */
typedef struct vv_lamp {
    int kind; /**< vv_light_kind, never ambient */
    vv_vec3 position, direction;
    float color[3]; /**< times intensity */
    double cos_outer, cos_inner;
    vv_vec3 falloff;
} vv_lamp;

/** A part of the plane of values and lengths of gradients: a trapezoid whose lower side is [value_lo, value_hi] at
 * gradient_lo, and its upper one [top_lo, top_hi] at gradient_hi. */
typedef struct vv_region {
    double value_lo, value_hi, top_lo, top_hi;
    double gradient_lo, gradient_hi; /**< values per world length; gradient_hi may be infinite */
    double color[3];                 /**< linear */
    double opacity;                  /**< in the middle, per opacity_length */
    double edge;                     /**< share of the half width over which it fades to 0; 0: hard */
} vv_region;

/** Piecewise linear classification of values, resolved: data units and world lengths. */
typedef struct vv_classification {
    int kind;              /**< vv_segmentation_kind */
    const double *opacity; /**< n_opacity rows (value, opacity per opacity_length), ascending */
    size_t n_opacity;
    const double *color; /**< n_color rows (value, r, g, b), ascending */
    size_t n_color;
    double opacity_length; /**< world units */
    double opacity_scale;
    double gradient_power;     /**< above 0: extinction times (|gradient| / gradient_reference)^power, at most 1 */
    double gradient_reference; /**< values per world length */
    const vv_region *regions;  /**< where there are some, they decide instead of opacity and color; they add up */
    size_t n_regions;
    double gradient_top;  /**< of regions: where infinite ones end, and all gradients beyond are taken for it */
    double lo, hi;        /**< threshold */
    const double *labels; /**< n_labels rows (label, r, g, b, opacity), ascending */
    size_t n_labels;
    double label_opacity;   /**< of labels without a row, per opacity_length; label 0 without a row is clear */
    const vv_label_id *ids; /**< labels: value i stands for the label ids[i]; NULL: values are labels */
    size_t n_ids;
    bool ids_unsigned;            /**< ids are the bits of uint64_t */
    const vv_label_id *label_ids; /**< the first column of `labels` with all of its digits; NULL: it has them itself */
} vv_classification;

/** Colours that a volume takes from the values of another field. */
typedef struct vv_paint {
    const vv_field *field; /**< NULL: none */
    int component;
    vv_affine index_to_world; /**< moves with the volume */
    bool nearest;
    const double *color; /**< n_color rows (value, r, g, b), ascending */
    size_t n_color;
} vv_paint;

/** An image or a pattern on colours. */
typedef struct vv_texture {
    int kind;             /**< vv_texture_kind */
    int mapping;          /**< vv_texture_mapping; of images, as are `wrap` and `image` */
    int wrap;             /**< vv_texture_wrap */
    int apply;            /**< vv_texture_apply */
    vv_image *image;      /**< NULL: none */
    vv_affine from_world; /**< to the texture's space: lengths are images, cells, rings or veins */
    double frequency;     /**< of those in one world length, before the volume is placed */
    double strength;
    double color[2][3]; /**< of patterns, linear */
    uint32_t seed;
} vv_texture;

/** How slices show a volume. */
typedef struct vv_slice_look {
    int colors;           /**< vv_slice_colors */
    double lo, hi;        /**< the window: values that have the ends of the colour map; the same: a step */
    const char *colormap; /**< a name, which may be of no map */
    int blend;            /**< vv_slice_blend */
    double opacity;
    bool clear_below;  /**< values below the window are clear: by themselves of overlays whose window somebody set */
    bool clear_middle; /**< the middle of the window is clear, and opacity grows away from it: of overlays about zero */
} vv_slice_look;

/** How one value of each ray through a volume lies over what else is drawn: as opaque as classes say for one
 * opacity_length. */
typedef struct vv_ray_layer {
    int blend;      /**< vv_slice_blend */
    double opacity; /**< factor */
} vv_ray_layer;

/** One visible volume of samples. */
typedef struct vv_actor {
    const char *id;
    const vv_field *field;
    int component;
    vv_affine index_to_world; /**< field grid, then the volume's own place */
    bool nearest;
    bool cubic; /**< interpolated by a cubic spline */
    /** Samples of RGB or RGBA that give the colours, NULL: there are none. `field` is then their alpha or luminance. */
    const vv_field *colors;
    bool colors_encoded; /**< sRGB, else linear */
    vv_paint paint;
    vv_texture texture;
    vv_classification classes;
    int shading_model;
    float ambient, diffuse, specular, shininess;
    bool two_sided;
    bool cap;         /**< faces of cuts are lit as faces */
    float color[3];   /**< of surfaces */
    double iso;       /**< of first-hit isosurface */
    vv_plane *planes; /**< global and own cut planes, world space, unit normals */
    size_t n_planes;
    vv_statistics *statistics; /**< of the component */
    vv_slice_look slices;
    const vv_object *params; /**< those of the scene, and what the volume's own `rays` say instead; NULL: the scene's */
    vv_ray_layer layer;
} vv_actor;

/** One visible mesh. */
typedef struct vv_mesh_actor {
    vv_actor look;         /**< id, shading, colour and cut planes; it has no field. classes.color: colours by value */
    vv_mesh *mesh;         /**< with normals of vertices: its own, or made ones */
    vv_affine place;       /**< from the mesh's space to the World */
    double opacity;        /**< factor */
    bool one_color;        /**< that of `look`, whatever the mesh says */
    const uint8_t *colors; /**< sRGB and alpha of each vertex, by its value; NULL: the mesh's own */
    const vv_mesh_part *parts;   /**< those of the mesh, with colours to tell them apart; NULL: the mesh's own */
    struct vvi_cached *textures; /**< the mesh's, made ready to be drawn; NULL: it has none */
} vv_mesh_actor;

typedef struct vv_scene {
    vv_world *world; /**< the snapshot */
    const vv_view *view;
    const vv_renderer *renderer;
    const vv_object *params; /**< of the renderer's class */
    int quality;
    int32_t width, height;
    int32_t top,
        rows;        /**< of the height those that are made now: all, or a part where a picture is made part by part */
    unsigned layers; /**< the image is to have: vv_layer, depth always */
    int64_t samples; /**< rays a pixel at most */
    double noise;    /**< no more rays for what is known as well as this; 0: the same for all */
    double budget_s; /**< no pass is begun that would end later; 0: all of them */
    bool adaptive;   /**< rays only where light changes from pixel to pixel */
    vv_lens lens;
    vv_actor *actors;
    size_t n_actors;
    vv_mesh_actor *mesh_actors;
    size_t n_mesh_actors;
    vv_lamp *lamps;
    size_t n_lamps;
    float ambient[3];
    float background[4]; /**< linear, premultiplied */
    uint64_t seed;
    vv_vec3 cross_hair; /**< where slices meet: the World's, else the middle sample of the first volume */
} vv_scene;

/** The renderer's parameters as they are for one volume. */
static inline const vv_object *vv_actor_params(const vv_scene *scene, const vv_actor *actor)
{
    return actor->params ? actor->params : scene->params;
}

/** Ray through a place in the picture, (0.5, 0.5) being the centre of the top left pixel; the direction has length 1.
 */
VV_API void vv_lens_ray(vv_vec3 *origin_out, vv_vec3 *direction_out, const vv_lens *lens, int32_t width, int32_t height,
                        double x, double y);
/** Load what the view shows and work out what was left open. Errors name the property path. */
VV_API vv_status vv_scene_resolve(vv_scene **out, vv_world *world, const char *view_id, vv_job *job);
VV_API void vv_scene_release(vv_scene *scene); /* NULL is fine */
/** Write what was worked out back as explicit properties, so that a saved scene shows it. */
VV_API vv_status vv_scene_fix(vv_world **out, const vv_scene *scene);

VV_END_DECLS
#endif
