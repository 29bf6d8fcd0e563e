/** @file
 * The tables: what a format, an image format, an operation, a renderer and a data kind is, and where they are listed.
 * For people who add rows; kept within one minor version. Rows are `static const`, filled by designated initialisers;
 * a missing function means "cannot".
 */
#ifndef VOLVIS_SYS_REGISTRY_H
#define VOLVIS_SYS_REGISTRY_H
#include <volvis/field.h>
#include <volvis/file.h>
#include <volvis/image.h>
#include <volvis/mesh_file.h>
#include <volvis/operation.h>
#include <volvis/property.h>
#include <volvis/run.h>
#include <volvis/sys/io.h>
VV_BEGIN_DECLS

#define VV_FORMAT_API 1
#define VV_IMAGE_FORMAT_API 2
#define VV_MESH_FORMAT_API 1
#define VV_OPERATION_API 6
#define VV_RENDERER_API 5
#define VV_DATA_KIND_API 1

/* Formats ------------------------------------------------------------------------------------------------------- */

/** A volume file format. */
typedef struct vv_format {
    int api; /**< VV_FORMAT_API */
    const char *name, *doc;
    const char *const *suffixes;  /**< ".nrrd", ...; ends with NULL */
    const char *const *encodings; /**< that write knows, the default first; NULL: one way only */
    /** Looks at the first bytes, reads nothing else: 0 no, 1 maybe, 2 certainly. */
    int (*probe)(const uint8_t *head, size_t n, const char *path);
    /** Looks at a folder: the names in it, the first bytes of a file or two. 0, 1, 2 as above; NULL: no folders. */
    int (*probe_folder)(vv_source *folder, vv_job *job);
    /** Cheap: all of info and whatever read() will need, through plan_out; plan is freed by free_plan. */
    vv_status (*read_header)(vv_field_info *info_out, void **plan_out, vv_source *source,
                             const vv_read_options *options, vv_notes *notes, vv_job *job);
    void (*free_plan)(void *plan);
    /** Samples of one box of one frame; region NULL: all of it. */
    vv_status (*read)(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source, int64_t frame,
                      const vv_box *region, vv_job *job);
    /** Whether read() maps instead of reading; NULL: never. */
    bool (*mappable)(const vv_field_info *info, const void *plan);
    vv_status (*write)(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                       vv_job *job);
    /** Not NULL: write() makes a folder, as no row outside the library can yet. Whether a file by this name, below the
     * folder, belongs to such an output: 0 no, 1 yes, 2 it marks one when it stands at the top. Only folders of such
     * files are ever replaced.
     */
    int (*folder_file)(const char *name);
    /** Its library fails on damaged files in ways that no caller can catch: it is read by the import program where
     * there is one, unless vv_runtime_options.contain says no. */
    bool contained;
    /** Its readers honour a scale and an offset of values: write() keeps stored numbers with them. Others are given
     * fields of values, unless stored numbers are asked for (vv_write_options). */
    bool keeps_scale;
    /** It holds segmentations: whole numbers that are written to it are labels from then on, all layers of a file that
     * has several go into one, and write() looks at all samples before it writes any. */
    bool labels_only;
    /** The types that write() knows, a bit each (1u << vv_type), for values to be written in; 0: all. */
    unsigned types;
    /** write() takes from a file of this format what only its headers say (vv_write_options.origin): what is made of
     * such a file without a word on its format is best kept in the same one. */
    bool takes_origin;
    bool beside; /**< it may look for other files beside the one that is read */
    /** read() of a small region takes about as long as what is in it: nothing before it has to be decoded. */
    bool boxes;
} vv_format;

/** An image file format. */
typedef struct vv_image_format {
    int api; /**< VV_IMAGE_FORMAT_API */
    const char *name, *doc;
    const char *const *suffixes;
    int (*probe)(const uint8_t *head, size_t n, const char *path);
    vv_status (*write)(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job);
    /** The same of one that is never whole in memory. NULL: it has to be. */
    vv_status (*write_rows)(vv_sink *sink, const vv_image_rows *rows, const vv_image_options *options, vv_job *job);
    /** text_out and n_text_out may be NULL; text is for vv_text_free(). */
    vv_status (*read)(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
    vv_status (*read_text)(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
    const int *bits;   /**< a channel that write knows, the default first; ends with 0 */
    unsigned layers;   /**< that it holds; others are written beside it */
    int quality;       /**< that it has where none is asked for; 0: it has none, or nothing is lost then */
    int32_t side_most; /**< pixels that a side can have; 0: as many as images */
    bool lossy;        /**< a quality below 100 makes the file smaller */
    bool paper;        /**< it says how many pixels an inch has */
    /** Colours as the file has them, not multiplied by alpha: those of alpha 0 too, which images on triangles need.
     * NULL: the format has none but those that read() gives. */
    vv_status (*read_straight)(vv_image **out, vv_source *source, vv_job *job);
} vv_image_format;

/** What a mesh file can hold beside places and triangles; bits of a set. */
typedef enum vv_mesh_holds {
    VV_MESH_HOLDS_NORMALS = 1,
    VV_MESH_HOLDS_VALUES = 2,
    VV_MESH_HOLDS_COLORS = 4,       /**< of vertices */
    VV_MESH_HOLDS_PARTS = 8,        /**< with their names */
    VV_MESH_HOLDS_PART_COLORS = 16, /**< of parts */
    VV_MESH_HOLDS_UNIT = 32,
    VV_MESH_HOLDS_DOUBLES = 64,  /**< places in double precision */
    VV_MESH_HOLDS_TEXTURES = 128 /**< images, and where they lie on triangles */
} vv_mesh_holds;

/** A mesh file format. */
typedef struct vv_mesh_format {
    int api; /**< VV_MESH_FORMAT_API */
    const char *name, *doc;
    const char *const *suffixes;  /**< ".ply", ...; ends with NULL */
    const char *const *encodings; /**< that write knows, the default first; NULL: one way only */
    unsigned holds;               /**< any of vv_mesh_holds: the driver warns of what is lost */
    /** Looks at the first bytes, reads nothing else: 0 no, 1 maybe, 2 certainly. */
    int (*probe)(const uint8_t *head, size_t n, const char *path);
    /** options->unit is never NULL. */
    vv_status (*read)(vv_mesh **out, vv_source *source, const vv_mesh_read_options *options, vv_notes *notes,
                      vv_job *job);
    /** options->encoding is one of the row's; lengths are in options->unit already. */
    vv_status (*write)(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job);
    bool beside; /**< it may look for other files beside the one that is read */
    vv_up up;    /**< which axis points up where the file says nothing; z unless it is for pictures */
} vv_mesh_format;

/* Operations ---------------------------------------------------------------------------------------------------- */

struct vvi_surface_row; /* of the library alone, as is the next */
struct vvi_made_data;   /* src/model/made_data.h */

/** An input of an operation. */
typedef struct vv_operand {
    const char *name;   /**< "volume", "markers": NAME=FILE gives it out of its turn on the command line */
    unsigned is;        /**< of vv_data_is */
    size_t least, most; /**< how many: 1 and 1, unless it is optional or several. Only the last of a row is several */
    const char *doc;
    const char *names; /**< of several that people name as they like: the parameter of the names, as in "a,b" */
    bool names_labels; /**< labels that parameters name are those of its file; where no operand says so, of the first */
    bool grid_only;    /**< only where its samples lie is looked at: none is read, and any time step will do */
} vv_operand;

/** The commonest inputs: one volume, one mesh. */
#define VV_ONE_VOLUME ((const vv_operand[]){{"volume", VV_IS_FIELD, 1, 1, "the volume that it works on"}, {0}})
#define VV_ONE_MESH ((const vv_operand[]){{"mesh", VV_IS_MESH, 1, 1, "the mesh that it works on"}, {0}})

/** How an operation whose samples depend on all others streams: first passes over its inputs, from the first slice to
 * the last, then slices of the result from what they found. The same bytes as run. */
typedef struct vv_passes {
    /** All passes. What they find is *state_out, for drop(); NULL after a failure. */
    vv_status (*find)(void **state_out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                      vv_job *job);
    /** Whole slices of the result: box has all samples along x and y. */
    vv_status (*make)(vv_field **out, void *state, const vv_field *const *inputs, size_t n_inputs,
                      const vv_object *params, const vv_box *box, vv_job *job);
    void (*drop)(void *state); /**< NULL is fine */
    /** Bytes of a temporary file between the passes; NULL: none. */
    uint64_t (*scratch)(const vv_field_info *inputs, size_t n_inputs, const vv_object *params);
} vv_passes;

/** One thing that is done to data. Inputs come in the order of the row's operands, those of the last one one after the
 * other; one that is left out leaves a gap (NULL, or vv_data without data), unless no other follows it. */
struct vv_operation {
    int api; /**< VV_OPERATION_API */
    const char *name;
    const char *component; /**< the folder it lives in: "filter", ... */
    const char *doc;
    const char *example; /**< a command line; run by the tests */
    const vv_class *params;
    const vv_operand *inputs; /**< in the order of words; ends with one without a name */
    /** Fields from fields: new samples from old; same bytes for any thread count. params is of the class above. NULL:
     * run_box does it. Call it by vv_operation_run(). */
    vv_status (*run)(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                     vv_job *job);
    /** The samples of one box of the result alone, the same that run gives there: what streams volumes that no memory
     * holds. It asks the inputs for bricks of what it needs. NULL: only all at once. */
    vv_status (*run_box)(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job);
    /** What `out` will be, without doing it: for --dry-run and streaming. */
    vv_status (*plan)(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params);
    /** What the first input's file says beyond its info, as it holds for the result: channels that are picked, whether
     * values are new. vv_carry_values: all of it. NULL: all but what it says of values, as they are new. */
    vv_status (*carry)(vv_carry *carry, const vv_object *params);
    /** Whether samples decide what the parameters leave open, a window of values say; and the look at those of all time
     * steps that decides it for each of them. NULL: nothing is left open. */
    bool (*looks)(const vv_object *params);
    vv_status (*settle)(vv_object *params, const vv_field_series *frames, vv_job *job);
    /** run_box asks for each slice of its input once, in their order, unless it looks(): what comes by a pipe need not
     * be kept to be read again. */
    bool in_order;
    /** Whatever is no field, or is not made of fields alone: in the place of the three above. Call it by
     * vv_operation_make(). */
    vv_status (*make)(vv_data *out, const vv_data *inputs, size_t n_inputs, const vv_object *params, vv_job *job);
    vv_data_is makes; /**< what make() makes; 0: a field, by one of the others */
    /** How labels look in the parts that it makes of them when it runs with these parameters; borrowed. NULL: it makes
     * no parts of labels. */
    void (*take_looks)(vv_object *params, vv_label_look *look, void *user);
    /** Of operations that make surfaces of values: what there is to say of them, before and after. NULL: it does not.
     */
    const struct vvi_surface_row *surface;
    /** The time steps of its inputs follow each other in the result: plan sees all inputs, all others one time step of
     * one of them at a time. vv_run_new() runs it. */
    bool joins;
    const char *group; /**< where menus list it: "smoothing", "edges", ...; NULL: under its component */
    /** About how many bytes it holds beside its inputs and its result where it takes all samples at once; a row with
     * run_box that says more than 0 does so with these parameters, and does not stream. Where that hangs on the
     * samples, of parts as they are in pictures of bodies and cells. NULL: tiles. */
    uint64_t (*memory)(const vv_field_info *inputs, size_t n_inputs, const vv_object *params);
    const vv_passes *passes; /**< how it streams where there is no run_box; NULL: it does not */
};

/* Data kinds ---------------------------------------------------------------------------------------------------- */

/** A run of one ray: entry and exit distance, with the values there. */
typedef struct vv_segment {
    double t0, t1;        /**< distance along the ray, world units */
    float value0, value1; /**< interpolated values at both ends */
} vv_segment;

/** One way that samples fill space. */
typedef struct vv_data_kind {
    int api; /**< VV_DATA_KIND_API */
    const char *name, *doc;
    bool (*accepts)(const vv_field_info *info);
    /** World box. */
    vv_bounds (*bounds)(const vv_field_info *info);
    /**
     * The part of a ray inside the data, cell by cell, nearest first: the definition that fast paths are tested
     * against. Writes at most `max` segments, returns how many there are.
     */
    size_t (*segments)(vv_segment *out, size_t max, const vv_field *field, int component, vv_vec3 origin,
                       vv_vec3 direction, double t_min, double t_max);
} vv_data_kind;

/* Renderers ----------------------------------------------------------------------------------------------------- */

struct vv_scene;  /* a resolved snapshot of one View: <volvis/sys/scene.h> */
struct vvi_gfx;   /* a drawing on its way; of the library alone */
struct vv_actor;  /* one visible volume of it */
struct vv_volume; /* as the World has it: <volvis/model.h> */

/** Pixels [x0, x1) x [y0, y1). */
typedef struct vv_tile {
    int32_t x0, y0, x1, y1;
} vv_tile;

/**
 * Which rays fill an image: the one of its pixel (X, Y) goes through (X * stride + x, top + Y * stride + y), in pixels
 * of the scene's width x height with (0, 0) at the top left corner. One ray through each pixel's centre is {0.5, 0.5,
 * 1}. The image may have another size than the scene: fewer pixels where stride is above 1, some more along its sides
 * where x or y lie beyond the pixel, fewer rows where a picture is made part by part.
 */
typedef struct vv_pass {
    double x, y;
    int32_t stride;
    int32_t top;     /**< rows of the scene above the image */
    uint64_t number; /**< of the pass, from 0 */
    uint64_t seed;   /**< of what is random in it: of the scene's seed and the number */
} vv_pass;

/** What a frame cost; summed in tile order. */
typedef struct vv_render_counts {
    uint64_t rays, samples;
    uint64_t covered; /**< pixels in which something is seen; counted by the driver, not by renderers */
} vv_render_counts;

/** Which one value of each ray a picture shows. */
typedef enum vv_ray_value {
    VV_PROJECTS_NOTHING, /**< it does not */
    VV_PROJECTS_EXTREME, /**< one of the values on it */
    VV_PROJECTS_MEAN,    /**< their mean */
    VV_PROJECTS_SUM,     /**< their sum over the length of the volume's diagonal */
    VV_PROJECTS_SMALLEST /**< the smallest of them */
} vv_ray_value;

/** What of a World pictures may depend on, beside a method's own parameters. */
typedef enum vv_aspect {
    VV_ASPECT_TRANSFER,  /**< transfer functions of volumes, their ranges and maps */
    VV_ASPECT_THRESHOLD, /**< thresholds of volumes */
    VV_ASPECT_SHADING,   /**< shading and lights */
    VV_ASPECT_CUTS,      /**< cut planes */
    VV_ASPECT_WINDOW,    /**< how slices show volumes */
    VV_ASPECT_DIRECTION, /**< where the camera looks from, and its perspective */
    VV_ASPECT_CROSS_HAIR,
    VV_ASPECT_OPACITY, /**< how dense clouds are, how opaque slices */
    VV_ASPECT_COLOR    /**< the one colour of a volume: of solids and surfaces */
} vv_aspect;

/** What a view may show; bits. */
typedef enum vv_content {
    VV_CONTENT_SAMPLES = 1, /**< volumes: scene.actors */
    VV_CONTENT_MESHES = 2   /**< scene.mesh_actors */
} vv_content;

/** What of a picture not every method makes; bits. */
typedef enum vv_renderer_can {
    /** Normals are those that draw() writes to the image's layer, as of faces that do not follow the values. */
    VV_CAN_NORMALS = 1,
    /** Contents that it does not take are left out, which it says itself; without this, they are refused. */
    VV_CAN_LEAVE_OUT = 2,
    /** Normals, ids and values are those that render() writes to the image's layers, of the volumes that it meets;
     * without this, they are looked up in the data where the depths are. */
    VV_CAN_LAYERS = 4
} vv_renderer_can;

/** A rendering method. One frame = a resolved scene + this row. */
typedef struct vv_renderer {
    int api;                /**< VV_RENDERER_API */
    const char *name, *doc; /**< name: of files, options and paths */
    const char *label;      /**< in menus */
    const vv_class *params; /**< found under views.<view>.render.<name> */
    unsigned takes;    /**< of vv_content. In the layers normal and id, pixels of meshes are draw()'s; the id of mesh
                            i is n_actors + 1 + i */
    unsigned best_for; /**< of vv_content: the method of views that show just this and name none. Where no method is
                            best, it is the first that takes it */
    unsigned can;      /**< of vv_renderer_can */
    /** VV_OK, or VV_E_UNSUPPORTED and why not. */
    vv_status (*accepts)(const struct vv_scene *scene);
    /** Whatever does not depend on the pixel; derived data goes through the cache. *state_out goes to render(). */
    vv_status (*prepare)(void **state_out, const struct vv_scene *scene, vv_job *job);
    /** Fill a tile of the image, which was clear before: linear, premultiplied, without background. Any thread; tiles
     * are independent, and so are passes: a pixel's light depends on its ray and the pass's seed alone. */
    vv_status (*render)(void *state, const vv_pass *pass, const vv_tile *tile, vv_image *image,
                        vv_render_counts *counts, vv_job *job);
    void (*finish)(void *state);
    /** Whether these parameters show one value of each ray instead of light through a cloud: colours that nobody chose
     * are then greys, over all values or over what means of them come to, and opacity goes from 0 to 1 over the values
     * of the colours (of the smallest, from 1 to 0). NULL: never. */
    vv_ray_value (*projects)(const vv_object *params);
    /** Whether an actor is seen as a solid, and the values [lo, hi] that it has: what a legend says. NULL: where its
     * segmentation is a threshold. */
    bool (*solid)(double *lo_out, double *hi_out, const struct vv_scene *scene, const struct vv_actor *actor);
    /** Instead of render(), for methods that make a picture at once and not ray by ray: all of the image, which is of
     * the scene's size and was clear before, with about `samples` places looked at in each pixel, the first of them, if
     * there is but one, its centre. *samples_out: how many there were. NULL: render() does it. */
    vv_status (*draw)(void *state, vv_image *image, int64_t samples, int64_t *samples_out, vv_render_counts *counts,
                      vv_job *job);
    /** The same for a figure: triangles go to `gfx`, of which nothing is public yet, what is no triangle onto the image
     * under them, which is clear. NULL: the figure has the picture in it. */
    vv_status (*figure)(void *state, struct vvi_gfx *gfx, vv_image *under, vv_job *job);
    /** Of methods that show one plane, through the scene's cross-hair: the directions that are right and up in the
     * picture, length 1 and at right angles, which take the place of the camera's; where it looks at, and how much it
     * shows, stay its own. False: the camera's own plane. Such pictures are exact at once: they have no coarse ones
     * before them. NULL: others. */
    bool (*plane)(vv_vec3 *right_out, vv_vec3 *up_out, const struct vv_scene *scene);
    /** Whether pictures of volumes with these parameters depend on an aspect: options of others are refused. NULL: on
     * everything but windows and the cross-hair. */
    bool (*heeds)(const vv_object *params, vv_aspect aspect);
    /** About how many bytes prepare() makes of one volume at most, told before its samples are read. NULL: nothing
     * worth telling. */
    uint64_t (*memory)(const vv_object *params, const struct vv_volume *volume, const vv_field_info *info);
} vv_renderer;

/* The registry -------------------------------------------------------------------------------------------------- */

/** All tables. Each ends with NULL; order decides ties, best first. */
typedef struct vv_registry {
    const vv_format *const *formats;
    const vv_image_format *const *image_formats;
    const vv_mesh_format *const *mesh_formats;
    const vv_operation *const *operations;
    const vv_renderer *const *renderers;
    const vv_data_kind *const *data_kinds;
    const struct vvi_made_data *made_data; /**< how data are made of others; of the library alone */
} vv_registry;

/** Everything that is built in: src/registry.c. A program adds rows of its own by vv_runtime_options.more. */
VV_API const vv_registry *vv_registry_builtin(void);
/** That of the job's runtime; what is built in for NULL. */
VV_API const vv_registry *vv_job_registry(const vv_job *job);
/** By name; NULL, and an error with the nearest real name, when there is none. */
VV_API const vv_format *vv_registry_format(const vv_registry *registry, const char *name);
VV_API const vv_operation *vv_registry_operation(const vv_registry *registry, const char *name);
/** For vv_operation.carry: samples are moved, mixed or stored in another way, and mean what they meant. */
VV_API vv_status vv_carry_values(vv_carry *carry, const vv_object *params);
/** The operand that input `index` is of, in the order of operands; NULL: there are no more. */
VV_API const vv_operand *vv_operation_operand(const vv_operation *operation, size_t index);
VV_API const vv_renderer *vv_registry_renderer(const vv_registry *registry, const char *name);
/** The method of views that name none: the one that is best for these contents (bits of vv_content), or else the first
 * that takes them, or else the first. */
VV_API const vv_renderer *vv_registry_renderer_for(const vv_registry *registry, unsigned contents);
/** The first that shows planes (vv_renderer.plane); NULL: none. */
VV_API const vv_renderer *vv_registry_plane_renderer(const vv_registry *registry);

VV_END_DECLS
#endif
