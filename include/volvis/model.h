/** @file
 * The abstract model: a World of datasets, volumes, lights and views.
 *
 * The World is a copy-on-write tree of property objects (<volvis/property.h>): read it freely from any thread, never
 * write to it. A vv_model owns the current World, takes edits one at a time and keeps their history; a snapshot is one
 * reference. Paths use ids ("volumes.head.segmentation.threshold.lo"); titles are free text.
 */
#ifndef VOLVIS_MODEL_H
#define VOLVIS_MODEL_H
#include <volvis/field.h>
#include <volvis/file.h>
#include <volvis/mesh.h>
#include <volvis/property.h>
VV_BEGIN_DECLS

/** A half-space that is kept: normal . p >= offset. Global ones in world space, a volume's own in its data's space. */
typedef struct vv_cut_plane {
    vv_object base;
    bool on;
    vv_vec3 normal; /**< any length but 0; made unit before use */
    double offset;  /**< along the unit normal, world units */
} vv_cut_plane;

typedef enum vv_shading_model { VV_SHADING_NONE, VV_SHADING_PHONG, VV_SHADING_BLINN } vv_shading_model;

/** Local illumination. A property unset in a volume is the World's; unset there too, its default. */
typedef struct vv_shading {
    vv_object base;
    int model;
    double ambient, diffuse, specular, shininess;
    bool two_sided;
    bool cap;
} vv_shading;

typedef enum vv_light_kind { VV_LIGHT_AMBIENT, VV_LIGHT_DIRECTIONAL, VV_LIGHT_POINT, VV_LIGHT_SPOT } vv_light_kind;
typedef enum vv_light_frame { VV_LIGHT_IN_WORLD, VV_LIGHT_ON_CAMERA } vv_light_frame;

typedef struct vv_light {
    vv_object base;
    char *title;
    bool on;
    int kind;
    int frame; /**< on the camera: position and direction are in camera axes (x right, y up, z towards the viewer) */
    vv_color color;
    double intensity;
    vv_vec3 position;  /**< point, spot */
    vv_vec3 direction; /**< directional, spot: the way the light travels */
    double cone;       /**< spot: full angle, radians */
    double softness;   /**< spot: share of the cone over which it fades, 0..1 */
    vv_vec3 falloff;   /**< point, spot: 1 / (x + y d + z d^2), d in world units */
} vv_light;

typedef enum vv_segmentation_kind {
    VV_SEGMENT_TRANSFER,
    VV_SEGMENT_THRESHOLD,
    VV_SEGMENT_LABELS,
    VV_SEGMENT_COLORS /**< the samples are colours; opacity by alpha or luminance, through the transfer's */
} vv_segmentation_kind;

/** A trapezoid in the plane of values and lengths of gradients (values per world length). */
typedef struct vv_transfer_region {
    vv_object base;
    double value_lo, value_hi, gradient_lo, gradient_hi, top_lo, top_hi;
    vv_color color;
    double opacity, edge;
} vv_transfer_region;

/** Values in [lo, hi], both inclusive, are the object: solid, with a surface. */
typedef struct vv_threshold {
    vv_object base;
    double lo, hi;
} vv_threshold;

/** Opacity and colour by value, piecewise linear in data values; two nodes at one value make a jump. */
typedef struct vv_transfer {
    vv_object base;
    char *preset;              /**< its nodes are used where opacity or color is unset */
    char *colormap;            /**< colours over `range` where color is unset and there is no preset */
    double range_lo, range_hi; /**< where normalised presets and colour maps are stretched to */
    vv_numbers *opacity;       /**< rows (value, opacity for one opacity_length) */
    vv_numbers *color;         /**< rows (value, r, g, b), linear */
    double opacity_length;     /**< world units */
    double opacity_scale;      /**< factor on extinction: >1 denser, <1 thinner */
    double gradient_power;     /**< extinction times (|gradient| / gradient_reference)^power, at most 1; 0: not */
    double gradient_reference; /**< values per world length */
    vv_collection *regions;    /**< vv_transfer_region: where there are some, opacity and color do not count */
} vv_transfer;

/** What a label names. */
typedef struct vv_label_name {
    vv_object base;
    int64_t label;
    char *name;
} vv_label_name;

/** Rows (label, r, g, b, opacity per opacity_length); labels without a row get a colour of their own. */
typedef struct vv_labels {
    vv_object base;
    vv_numbers *table;
    vv_collection *names; /**< vv_label_name, in any order */
    double opacity;       /**< of labels without a row; label 0 is clear */
} vv_labels;

typedef enum vv_color_encoding { VV_ENCODING_SRGB, VV_ENCODING_LINEAR } vv_color_encoding;

/** How the numbers of RGB and RGBA data are colours. */
typedef struct vv_color_data {
    vv_object base;
    int encoding;
} vv_color_data;

typedef struct vv_segmentation {
    vv_object base;
    int kind;
    vv_object *threshold, *transfer, *labels, *colors; /* kept side by side */
} vv_segmentation;

/** Places an object: p_world = matrix p, or position + rotation about z, y, x after scale. */
typedef struct vv_placement {
    vv_object base;
    vv_vec3 position;
    vv_vec3 rotation; /**< radians about x, then y, then z */
    vv_vec3 scale;
    vv_numbers *matrix; /**< 3 rows of 4: replaces the others when set */
} vv_placement;

typedef enum vv_interpolation { VV_INTERPOLATE_LINEAR, VV_INTERPOLATE_NEAREST, VV_INTERPOLATE_CUBIC } vv_interpolation;

/** Colours from the values of another dataset at the same place. */
typedef struct vv_volume_paint {
    vv_object base;
    char *data, *attribute;
    int64_t component, frame;
    char *colormap;
    double range_lo, range_hi;
    vv_numbers *color; /**< rows (value, r, g, b), linear */
} vv_volume_paint;

typedef enum vv_texture_kind {
    VV_TEXTURE_NONE,
    VV_TEXTURE_IMAGE,
    VV_TEXTURE_CHECKER,
    VV_TEXTURE_WOOD,
    VV_TEXTURE_MARBLE,
    VV_TEXTURE_NOISE
} vv_texture_kind;

typedef enum vv_texture_mapping { VV_MAP_PLANAR, VV_MAP_CYLINDRICAL, VV_MAP_SPHERICAL } vv_texture_mapping;
typedef enum vv_texture_apply { VV_APPLY_MODULATE, VV_APPLY_REPLACE } vv_texture_apply;

/** An image, or a pattern that fills space, on the colours of a volume. */
typedef struct vv_volume_texture {
    vv_object base;
    int kind;
    char *image; /**< file */
    int mapping, wrap, apply;
    double strength;
    vv_color color, second_color; /**< of patterns */
    double frequency;             /**< per world length, before the volume is placed */
    int64_t seed;
    vv_object *place; /**< vv_placement, from the middle of the volume */
} vv_volume_texture;

typedef enum vv_slice_colors { VV_SLICE_WINDOW, VV_SLICE_TRANSFER } vv_slice_colors;
typedef enum vv_slice_blend { VV_SLICE_OVER, VV_SLICE_ADD } vv_slice_blend;

/** How slices show a volume, in every view of them. */
typedef struct vv_volume_slices {
    vv_object base;
    int colors;
    double window_lo, window_hi;
    char *colormap;
    int blend;
    double opacity;
    bool clear_below;
} vv_volume_slices;

/** What is computed from the values along a ray. */
typedef enum vv_ray_mode {
    VV_RAY_COMPOSITE, /**< light through a cloud, or the surface of a threshold */
    VV_RAY_MAXIMUM,
    VV_RAY_MINIMUM,
    VV_RAY_MEAN,
    VV_RAY_SUM,
    VV_RAY_LOCAL_MAXIMUM,
    VV_RAY_ISOSURFACE
} vv_ray_mode;

/** How rays show a volume: what is set takes the place of the view's own parameter of that name. */
typedef struct vv_volume_rays {
    vv_object base;
    int mode;
    double iso, threshold; /**< value */
    double step;           /**< world length */
    int blend;             /**< vv_slice_blend; with the next, of modes that show one value of each ray */
    double opacity;
} vv_volume_rays;

/** What of which dataset is shown, where and how. */
typedef struct vv_volume {
    vv_object base;
    char *title;
    bool visible;
    char *data;      /**< id in datasets */
    char *attribute; /**< a field of the dataset; unset: its first */
    int64_t component, frame, level;
    vv_numbers *missing; /**< values that stand for none; unset: found from the samples */
    vv_object *place;    /**< vv_placement, after the dataset's own placement */
    vv_object *segmentation, *shading;
    int interpolation;
    vv_color color;     /**< of threshold and isosurface */
    vv_object *paint;   /**< vv_volume_paint */
    vv_object *texture; /**< vv_volume_texture */
    vv_collection *cut_planes;
    vv_object *slices; /**< vv_volume_slices */
    vv_object *rays;   /**< vv_volume_rays */
} vv_volume;

/** Fields that a dataset has in memory; filled by vv_dataset_attach() or on demand by loading. */
struct vv_dataset_fields;

/** Samples, or triangles, and where they come from. */
typedef struct vv_dataset {
    vv_object base;
    char *title;
    char *kind;       /**< row of the data kind table: "regular", "mesh" */
    char *path;       /**< unset: made of others, or in memory */
    char *format;     /**< unset: by content */
    char *part;       /**< which data set of the file, where it holds several */
    char *raw;        /**< layout of a headerless file */
    char *checksum;   /**< "crc32:89abcdef" of the samples of frame 0; checked when given */
    char *operation;  /**< without a path: it is worked out by this row of the operation table when it is needed */
    char *inputs;     /**< what the operation works on, datasets by operand: the text of a JSON object */
    char *parameters; /**< of the operation: the text of a JSON object */
    char *source;     /**< the first input, where `inputs` does not name it */
    struct vv_dataset_fields *fields; /* hidden; immutable once attached */
    bool on; /**< whether the operation is applied; off: what it makes is its first input, as it is */
} vv_dataset;

typedef enum vv_projection { VV_PERSPECTIVE, VV_PARALLEL } vv_projection;

/** What a camera that nobody placed has in its picture. */
typedef enum vv_camera_fit {
    VV_FIT_VISIBLE, /**< what is seen of volumes and meshes */
    VV_FIT_DATA     /**< all of their boxes: whatever is seen, the same for every time step */
} vv_camera_fit;

/** Where one looks from. Unset eye, at, up follow from the angles and fit the scene. */
typedef struct vv_camera {
    vv_object base;
    int projection;
    double azimuth, elevation, roll; /**< radians; 0, 0 is the front; azimuth about the World's up */
    vv_vec3 eye, at, up;
    double fov;    /**< full vertical field of view, radians */
    double height; /**< parallel: of the image, world units */
    double zoom;   /**< >1 nearer: divides the fitted image size */
    int fit;       /**< vv_camera_fit */
} vv_camera;

typedef enum vv_quality { VV_QUALITY_DRAFT, VV_QUALITY_NORMAL, VV_QUALITY_HIGH, VV_QUALITY_REFERENCE } vv_quality;

/** What the image is to hold beside its colours: vv_layer of <volvis/image.h>. */
typedef struct vv_layer_choice {
    vv_object base;
    bool depth, normal, id, samples, value;
} vv_layer_choice;

typedef struct vv_render_choice {
    vv_object base;
    char *method; /**< row of the renderer table; NULL: automatic */
    int quality;
    int64_t samples; /**< rays a pixel */
    double noise;    /**< share of the way from black to white */
    double budget;   /**< seconds */
    bool adaptive;
    vv_object *layers;      /**< vv_layer_choice */
    vv_collection *methods; /**< parameters of each renderer, by its name */
} vv_render_choice;

/** What is drawn over a picture. */
typedef struct vv_decorations {
    vv_object base;
    bool cube, axes, scale_bar, box, cut_planes, legend;
    char *title, *caption;
    vv_color color;
    double size; /**< factor */
    char *font;  /**< file */
    bool sides, cross_hair;
    bool measurements; /**< where they have places */
} vv_decorations;

typedef struct vv_view {
    vv_object base;
    char *title;
    int64_t width, height;
    vv_object *camera, *render, *decorations;
} vv_view;

typedef enum vv_measurement_kind {
    VV_MEASUREMENT_SUMMARY,
    VV_MEASUREMENT_AREA,
    VV_MEASUREMENT_VOLUME,
    VV_MEASUREMENT_BOX,
    VV_MEASUREMENT_STATISTICS,
    VV_MEASUREMENT_HISTOGRAM,
    VV_MEASUREMENT_PROFILE,
    VV_MEASUREMENT_DISTANCE,
    VV_MEASUREMENT_ANGLE,
    VV_MEASUREMENT_LABELS,
    VV_MEASUREMENT_GEODESIC,
    VV_MEASUREMENT_JOINT,
    VV_MEASUREMENT_POINT
} vv_measurement_kind;

typedef enum vv_measurement_space { VV_MEASURE_IN_INDEX, VV_MEASURE_IN_WORLD } vv_measurement_space;

/** One number that a measurement gave. */
typedef struct vv_measured_figure {
    vv_object base;
    char *name;
    double value, error; /**< unset: there is none, or it is not known */
    char *unit;
    vv_numbers *path; /**< of a length along a surface: rows of 3, in the measurement's `space`; NULL: it has none */
} vv_measured_figure;

/** Where something is measured, in a frame of its own: drawn in a slice, or in space. What the kinds need stands side
 * by side, so that another kind loses nothing. Coordinates are in the measurement's `space`. */
typedef struct vv_measured_region {
    vv_object base;
    int kind;            /**< vv_region_kind */
    vv_vec3 center;      /**< of all but polygons */
    vv_vec3 size;        /**< whole extents along `right`, up and `normal`; the last 0: one step of the samples */
    vv_vec3 normal;      /**< of its plane; unset: z, of a polygon that of its outline */
    vv_vec3 right;       /**< unset: x, or the axis that lies in the plane best */
    vv_numbers *outline; /**< of a polygon: rows of 3 */
    double thickness;    /**< of a polygon, as size's last number */
} vv_measured_region;

/** What was measured, how, and what came out. Unset arguments are left to the measurement, as on the command line. */
typedef struct vv_measurement {
    vv_object base;
    char *title;
    int what;
    char *file, *other; /**< unset: the scene's first visible volume; other: the second of two surfaces */
    double iso, other_iso;
    double threshold_lo, threshold_hi;
    int64_t label, other_label;
    char *mask;
    vv_vec3 seed;       /**< in `space` */
    vv_numbers *points; /**< rows of 3, in `space` */
    int space;
    char *box; /**< "10:60,:,5:20" */
    vv_collection *cut_planes;
    int64_t component;
    int method; /**< vv_measure_method */
    bool closed;
    int64_t bins, samples;
    vv_numbers *range; /**< one row (lo, hi) */
    char *values;
    vv_collection *figures; /**< vv_measured_figure: what came out last */
    char *input_unit;       /**< of mesh files that do not say it: "mm", "0.5mm" */
    char *volume;           /**< id of the scene's volume that it is of; unset: the first visible one */
    bool visible;           /**< pictures with measurements show it */
    vv_object *region;      /**< vv_measured_region, never NULL */
} vv_measurement;

typedef struct vv_world {
    vv_object base;
    int64_t schema; /**< version of the scene file's vocabulary */
    char *title;
    char *unit;          /**< of all lengths: "mm", ...; "voxels" when there is none */
    vv_color background; /**< alpha 0: transparent */
    vv_color ambient;    /**< light that comes from everywhere */
    int64_t seed;
    vv_object *shading;
    vv_collection *cut_planes;
    vv_collection *datasets, *volumes, *lights, *views;
    vv_collection *measurements; /**< vv_measurement */
    vv_vec3 cross_hair;          /**< where slices meet */
    int up;                      /**< vv_up */
} vv_world;

VV_API extern const vv_class vv_world_class;
VV_API extern const vv_class vv_dataset_class, vv_volume_class, vv_light_class, vv_view_class;
VV_API extern const vv_class vv_camera_class, vv_shading_class, vv_segmentation_class, vv_cut_plane_class;

/* The model ----------------------------------------------------------------------------------------------------- */

typedef struct vv_model vv_model;

VV_API vv_status vv_model_new(vv_model **out, vv_runtime *runtime);
VV_API vv_model *vv_model_retain(vv_model *model);
VV_API void vv_model_release(vv_model *model); /* NULL is fine */

/** The World as it is now, yours to release: a reference, whatever its size. */
VV_API vv_world *vv_model_snapshot(vv_model *model);
/** The engine's context for the current World: unit, voxel, renderers. Valid as long as the model. */
VV_API vv_property_context vv_model_context(vv_model *model);

/** One edit. All edits of one transaction (or a single one outside) become one commit. `who` may be NULL. */
VV_API vv_status vv_model_set(vv_model *model, const char *who, const char *path, const char *json);
VV_API vv_status vv_model_unset(vv_model *model, const char *who, const char *path);
VV_API vv_status vv_model_add(vv_model *model, const char *who, const char *path, const char *id, const char *json);
VV_API vv_status vv_model_remove(vv_model *model, const char *who, const char *path);
/** Attach samples to datasets.<id> (made if it does not exist): frame 0 of one attribute. Retains the field. */
VV_API vv_status vv_model_attach(vv_model *model, const char *who, const char *id, const vv_field *field);
/** The same for triangles. What the dataset had in memory is given up. */
VV_API vv_status vv_model_attach_mesh(vv_model *model, const char *who, const char *id, const vv_mesh *mesh);
/** Replace the whole World: opening a scene. */
VV_API vv_status vv_model_replace(vv_model *model, const char *who, vv_world *world);

/** Group edits. On vv_model_end(keep = false) the World is what it was at begin. One transaction at a time; while it is
 * open, snapshots show its edits, and edits, undo and redo by anybody else are VV_E_ARGUMENT. */
VV_API vv_status vv_model_begin(vv_model *model, const char *who);
VV_API vv_status vv_model_end(vv_model *model, bool keep);

/** Take back, or do again, the last commit of `who`, path by path, whatever others have committed since;
 * VV_E_NOT_FOUND when there is none. What another has set since at the same path stays, and taking that back comes to
 * what was before both. A commit on what another has removed is passed by, and the next one taken; where none can be,
 * the error is of the last commit. As many commits are kept as vv_limits.undo_bytes (and an eighth of the runtime's
 * memory) hold, the newest always. Adding to and removing from a list changes the
 * whole list: taking it back gives the list that was there before. */
VV_API vv_status vv_model_undo(vv_model *model, const char *who);
VV_API vv_status vv_model_redo(vv_model *model, const char *who);
/** The last two commits of `who` become one, for undo: pieces of one gesture, such as a drag. */
VV_API vv_status vv_model_join(vv_model *model, const char *who);
/** Whether `who` has something to take back, and something to do again. */
VV_API void vv_model_can(bool *undo_out, bool *redo_out, vv_model *model, const char *who);

/** A commit: which paths changed, who changed them, and the World after it. */
typedef struct vv_commit {
    uint64_t number;
    const char *who;
    const char *const *paths;
    size_t n_paths;
} vv_commit;
/** Called after each commit, in order, on the thread that made it. It may take snapshots; it cannot edit. */
typedef void vv_commit_fn(void *user, const vv_commit *commit, const vv_world *world);
VV_API vv_status vv_model_watch(vv_model *model, vv_commit_fn *fn, void *user);

/* Datasets ------------------------------------------------------------------------------------------------------
 * A dataset is a file, or in memory, or *made*: it has an operation and no path, and `world` is where the datasets are
 * that it is made of. What is asked for is read or worked out then and kept in the runtime's cache, by all that decides
 * it: path and date of a file; operation, parameters and inputs of what is made. Only the time step that is asked for
 * is made. Who asks for the same at once waits for the one who works on it.
 *
 * world   NULL: of files and of what is in memory
 * Errors  of what is made, beside those of its operation: VV_E_NOT_FOUND (no such operation, input, parameter),
 *         VV_E_ARGUMENT (of itself; data that the operation does not take), VV_E_LIMIT (too long a chain, too large);
 *         the error's place is the path of the property, "datasets.smooth.inputs.volume" */

/** Attribute `name` (NULL: the first) of frame `frame`. */
VV_API vv_status vv_dataset_field(vv_field **out, const vv_world *world, const vv_dataset *dataset, const char *name,
                                  int64_t frame, vv_job *job);
/** The info of the first attribute without its samples: of what is made, as planned. */
VV_API vv_status vv_dataset_info(vv_field_info *out, const vv_world *world, const vv_dataset *dataset, vv_job *job);

/** Whether it is made: worked out by an operation of other datasets. */
VV_API bool vv_dataset_is_made(const vv_dataset *dataset);
/** Whether a dataset is triangles: its kind says so, or, where that is unset, its operation, its format or its file. */
VV_API bool vv_dataset_is_mesh(const vv_dataset *dataset, vv_job *job);
/** The mesh of such a dataset. */
VV_API vv_status vv_dataset_mesh(vv_mesh **out, const vv_world *world, const vv_dataset *dataset, vv_job *job);

/* Scenes -------------------------------------------------------------------------------------------------------- */

#define VV_SCHEMA_VERSION 1

/** Read *.vv.json strictly; data paths become relative to the working directory. */
VV_API vv_status vv_scene_read(vv_world **out, const char *path, vv_job *job);
/** From memory; `folder` is what relative paths start from (NULL: as they are). `name` stands in errors. */
VV_API vv_status vv_scene_parse(vv_world **out, const char *json, size_t length, const char *name, const char *folder,
                                vv_job *job);
/** Never half a file. Data paths are written relative to the scene where they can be. */
VV_API vv_status vv_scene_write(const char *path, const vv_world *world, vv_job *job);
/** The same text in memory, yours to free(). folder NULL: paths as they are. */
VV_API vv_status vv_scene_print(char **json_out, const vv_world *world, const char *folder);
/** JSON Schema of scene files, yours to free(). */
VV_API vv_status vv_scene_schema(char **json_out, const struct vv_registry *registry);

/** A default World on one dataset: volume, key and fill light, one view that frames it. id from the file name. */
VV_API vv_status vv_world_for_file(vv_world **out, const char *path, const vv_read_options *options, vv_job *job);
VV_API vv_status vv_world_for_field(vv_world **out, const char *id, const vv_field *field, vv_job *job);
/** The same on a mesh in memory. Both retain their data. VV_E_ARGUMENT: the id is none. */
VV_API vv_status vv_world_for_mesh(vv_world **out, const char *id, const vv_mesh *mesh, vv_job *job);

VV_END_DECLS
#endif
