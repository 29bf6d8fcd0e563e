/** @file
 * The graphics function library: everything that is drawn and is not a volume goes through these few functions, so that
 * a new kind of output means one new table of functions (vvi_gfx_backend) and nothing else.
 *
 * A picture is drawn between vvi_gfx_begin() and vvi_gfx_end(). In between there is a state (camera, lights, material,
 * cuts, ...) that is set when it changes, and calls that draw with the state of that moment. Nothing is seen before
 * vvi_gfx_end(), which does the work on all threads of the job; arrays that a call names (of meshes only; all else is
 * copied) live until then.
 *
 *   vvi_gfx *gfx;
 *   vvi_gfx_begin(&gfx, &vvi_gfx_software, &(vvi_gfx_target){.image = image}, job);
 *   vvi_gfx_camera(gfx, &scene->lens);
 *   vvi_gfx_lights(gfx, scene->lamps, scene->n_lamps, scene->ambient);
 *   vvi_gfx_mesh(gfx, &(vvi_gfx_surface){.mesh = vv_mesh_get_info(mesh), .place = vv_affine_identity(), .color = c});
 *   vvi_gfx_camera(gfx, NULL);                                   // from here on in pixels, over everything
 *   vvi_gfx_line(gfx, (vv_vec3[]){{10, 10, 0}, {110, 10, 0}}, 2, VVI_GFX_STRIP, &(vvi_gfx_stroke){white, 2});
 *   status = vvi_gfx_end(gfx);
 *
 * Order    Opaque triangles cover each other by depth, in whatever order they come; then translucent ones are blended,
 *          sorted by depth; then lines, points, polygons and text in the order of the calls. Translucent triangles hide
 *          nothing and change no layer.
 * Depth    is that of vv_image: distance from the eye along the pixel's ray, world units. What the image already has
 *          takes part: geometry in front of a pixel's depth covers it, geometry behind it shows through as far as the
 *          pixel is transparent. So a volume's picture, drawn before, and geometry hide each other; put the background
 *          under the picture afterwards.
 * Places   With a camera: world space. Without: pixels, x to the right and y down from the picture's upper left corner,
 *          (0.5, 0.5) being the middle of the first pixel; z is not looked at, and nothing is hidden.
 * Colours  vv_color: linear, not premultiplied.
 * Errors   A call that fails leaves the picture as if it had not been made. vvi_gfx_end() releases in any case.
 * Threads  One picture is drawn by one thread at a time, on those of the job; same bytes for any number of them.
 */
#ifndef VVI_GFX_GFX_H
#define VVI_GFX_GFX_H
#include "core/status.h"
#include "core/text.h"
#include <volvis/image.h>
#include <volvis/mesh.h>
#include <volvis/sys/scene.h>

typedef struct vvi_gfx vvi_gfx;
typedef struct vvi_gfx_backend vvi_gfx_backend;

/** An image: tiles, all threads, anti-aliased. */
extern const vvi_gfx_backend vvi_gfx_software;
/** A figure of lines, areas and text; meshes are areas, or a picture inside it. */
extern const vvi_gfx_backend vvi_gfx_svg;

/** Back ends by number; NULL past the last. */
const vvi_gfx_backend *vvi_gfx_backend_nth(size_t index);
/** "software", "svg". */
const char *vvi_gfx_backend_name(const vvi_gfx_backend *backend);

/* Text ------------------------------------------------------------------------------------------------------------ */

/** One line of text as coverage, 255 being all of a pixel. Pixel (x, y) of it is pixel (left + x, top + y) of a picture
 * whose pixel (0, 0) begins where the text does on its base line; y down, so `top` is normally negative. */
typedef struct vvi_gfx_coverage {
    int32_t width, height, left, top;
    double advance;    /**< from the begin of the text to its end, pixels */
    uint8_t *coverage; /**< width * height; NULL where that is 0; of vvi_alloc() */
} vvi_gfx_coverage;

/** Where coverage comes from. `size`: pixels an em. `draw` may be called by any one thread at a time. */
typedef struct vvi_gfx_font {
    vv_status (*draw)(void *user, vvi_gfx_coverage *out, const char *utf8, double size, vv_job *job);
    void *user;
} vvi_gfx_font;

/* A picture ------------------------------------------------------------------------------------------------------- */

/** What is drawn on. */
typedef struct vvi_gfx_target {
    /** Drawn over; the layers that it has are brought up to date. `svg`: put under the drawing; NULL: nothing is. */
    vv_image *image;
    int32_t width, height;    /**< of the picture in pixels, 1 .. 16384; 0: the image's */
    const vvi_gfx_font *font; /**< NULL: text cannot be drawn (`svg` needs none) */
    int samples;              /**< a pixel, of triangles: 1, 4 or 8; 0: 4 */
    int turn;                 /**< of the places of 8 samples: 0 .. 7 look at 64 places of a pixel together */
    double shift[2];        /**< of all that a camera sees, pixels: below a sixteenth it moves samples in their part */
    vvi_text *svg;          /**< `svg`: the document is added here */
    const vv_image *hiding; /**< `svg`: whose depths hide; NULL: those of `image` */
    size_t triangles;       /**< `svg`: meshes are areas, so many at most; 0: a picture */
    vv_color paper;         /**< `svg`: under everything; a 0: nothing is */
    double dpi;             /**< `svg`: pixels an inch, for the size on paper; 0: 96 */
    const char *title;      /**< `svg`: of the document; NULL: none */
} vvi_gfx_target;

/** State at first: pixels, no lights, the material of vvi_gfx_material_default(), no cuts, the whole picture, id 1.
 * Errors: VV_E_ARGUMENT (no such size, nothing to draw on), VV_E_LIMIT, VV_E_MEMORY. */
vv_status vvi_gfx_begin(vvi_gfx **out, const vvi_gfx_backend *backend, const vvi_gfx_target *target, vv_job *job);
/** Draws what was asked for since vvi_gfx_begin(), and releases `gfx` in any case (NULL is fine: VV_OK). Errors:
 * VV_E_MEMORY, VV_E_CANCELLED: the image then has some tiles drawn and others not. */
vv_status vvi_gfx_end(vvi_gfx *gfx);
/** Releases without drawing. NULL is fine. */
void vvi_gfx_abandon(vvi_gfx *gfx);

/* State ----------------------------------------------------------------------------------------------------------- */

/** Places from now on are in the world that this lens sees; NULL: in pixels. */
void vvi_gfx_camera(vvi_gfx *gfx, const vv_lens *lens);
/** Copied. ambient NULL: none. */
vv_status vvi_gfx_lights(vvi_gfx *gfx, const vv_lamp *lamps, size_t n_lamps, const float ambient[3]);

/** Which sides of a surface lamps light. */
typedef enum vvi_gfx_sides {
    VVI_GFX_FACING, /**< the one that is seen: normals are turned to the eye. As of first-hit isosurfaces */
    VVI_GFX_BOTH,   /**< |n.l|: a lamp behind lights as one before. Property shading.two_sided */
    VVI_GFX_FRONT   /**< max(n.l, 0): the back is dark */
} vvi_gfx_sides;

/** How a surface returns light; the formulas and the names are those of lamp.h. */
typedef struct vvi_gfx_material {
    int model; /**< vv_shading_model */
    float ambient, diffuse, specular, shininess;
    int sides; /**< vvi_gfx_sides */
    bool flat; /**< normals of triangles instead of those of vertices; so too where a mesh has none */
} vvi_gfx_material;

/** The defaults of the shading properties, facing the eye. */
vvi_gfx_material vvi_gfx_material_default(void);
/** NULL: the default. */
void vvi_gfx_set_material(vvi_gfx *gfx, const vvi_gfx_material *material);

/** Only what lies in all of these half-spaces of the world is drawn, as long as there is a camera. Copied. */
vv_status vvi_gfx_cuts(vvi_gfx *gfx, const vv_plane *planes, size_t n_planes);
/** Only what lies in these pixels is drawn: [x0, x1) x [y0, y1); of meshes, pixels that have a part there. All 0: the
 * whole picture. */
void vvi_gfx_window(vvi_gfx *gfx, double x0, double y0, double x1, double y1);
/** False: what is drawn in the world is not hidden, hides nothing and changes no layer. Not of opaque triangles. */
void vvi_gfx_depth(vvi_gfx *gfx, bool test);
/** What the id layer and picking say of what is drawn from now on. */
void vvi_gfx_id(vvi_gfx *gfx, uint32_t id);

/* Drawing --------------------------------------------------------------------------------------------------------- */

typedef enum vvi_gfx_cull { VVI_GFX_ALL, VVI_GFX_NO_BACKS, VVI_GFX_NO_FRONTS } vvi_gfx_cull;

/** Triangles. Needs a camera. */
typedef struct vvi_gfx_surface {
    const vv_mesh_info *mesh; /**< it and its arrays live until vvi_gfx_end() */
    vv_affine place;          /**< from the mesh's space to the world; not singular */
    vv_color color; /**< where neither the part nor the vertices have one. a: times the opacity of all colours */
    bool one_color; /**< colours of vertices and parts are not looked at */
    const double
        *ramp; /**< n_ramp rows (value, r, g, b), ascending: colours by the mesh's values between vertices; where a
                  corner has none, those of vertices count. NULL: no colours by value. Live until then, too */
    size_t n_ramp;
    const struct vvi_gfx_textures *textures; /**< of parts; NULL: they are drawn without. Live until vvi_gfx_end() */
    int cull; /**< vvi_gfx_cull; a triangle's front is where its vertices go round counter-clockwise */
} vvi_gfx_surface;

/** Errors: VV_E_ARGUMENT (no camera, singular place, an index past the vertices), VV_E_LIMIT (2^32 triangles in all).
 * Triangles with a vertex that is not finite are left out. */
vv_status vvi_gfx_mesh(vvi_gfx *gfx, const vvi_gfx_surface *surface);
/** Whether one can look through some of it. */
bool vvi_gfx_is_translucent(const vvi_gfx_surface *surface);

typedef struct vvi_gfx_stroke {
    vv_color color;
    double width;       /**< pixels, above 0, everywhere the same */
    double dash, space; /**< lengths in pixels of what is drawn and what is left out; dash 0: no dashes */
} vvi_gfx_stroke;

typedef enum vvi_gfx_join {
    VVI_GFX_STRIP, /**< each point to the next */
    VVI_GFX_LOOP,  /**< and the last to the first */
    VVI_GFX_PAIRS  /**< the first to the second, the third to the fourth, ...; a last one alone is left out */
} vvi_gfx_join;

/** Anti-aliased, with round ends and joins; a translucent line does not cover itself twice. */
vv_status vvi_gfx_line(vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, vvi_gfx_join join,
                       const vvi_gfx_stroke *stroke);
/** Discs. diameter: pixels. */
vv_status vvi_gfx_points(vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, double diameter, vv_color color);

/** A colour somewhere along a gradient. */
typedef struct vvi_gfx_stop {
    double at; /**< 0 .. 1, ascending */
    vv_color color;
} vvi_gfx_stop;

typedef struct vvi_gfx_fill {
    vv_color color;
    const vvi_gfx_stop *stops; /**< instead of `color`: linear from `from` to `to`, premultiplied; copied */
    size_t n_stops;
    vv_vec3 from, to; /**< places, as the points are */
} vvi_gfx_fill;

/** One flat area, not lit; its inside is where a line to it crosses the outline an odd number of times. */
vv_status vvi_gfx_polygon(vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, const vvi_gfx_fill *fill);
/** The same with four corners; pixels only. */
vv_status vvi_gfx_rectangle(vvi_gfx *gfx, double x0, double y0, double x1, double y1, const vvi_gfx_fill *fill);

typedef enum vvi_gfx_anchor { VVI_GFX_BEGIN, VVI_GFX_MIDDLE, VVI_GFX_END } vvi_gfx_anchor;
typedef enum vvi_gfx_level { VVI_GFX_BASE_LINE, VVI_GFX_CENTRE, VVI_GFX_TOP, VVI_GFX_BOTTOM } vvi_gfx_level;

typedef struct vvi_gfx_label {
    double size;  /**< pixels an em */
    int anchor;   /**< vvi_gfx_anchor: which part of the text is at the place, along it */
    int level;    /**< vvi_gfx_level: and across it; capitals are 0.72 em high, and go 0.22 em below the base line */
    int quarters; /**< turned counter-clockwise by as many times 90 degrees */
    vv_color color;
    vv_color halo; /**< around the letters, so that they can be read on anything; a 0: none */
} vvi_gfx_label;

/** One line of UTF-8. In the world the place is projected, and one depth is that of all letters. Errors: VV_E_ARGUMENT
 * (no UTF-8, control characters), VV_E_UNSUPPORTED (no font). */
vv_status vvi_gfx_text(vvi_gfx *gfx, vv_vec3 at, const vvi_gfx_label *label, const char *utf8);

/* Picking --------------------------------------------------------------------------------------------------------- */

typedef struct vvi_gfx_picked {
    bool hit;
    uint32_t id;        /**< vvi_gfx_id() when it was drawn */
    uint32_t primitive; /**< number of the triangle in its mesh */
    double depth;       /**< as of images */
    vv_vec3 world;
    vv_vec3 normal; /**< of the triangle, its front's, length 1 */
    double opacity; /**< of what is drawn there, 0 to 1 */
} vvi_gfx_picked;

/** The nearest triangle on the ray through (x, y) and further than `beyond` (0: any), among those drawn since
 * vvi_gfx_begin(); exactly, not the picture's samples. A ray between two triangles with a common edge meets one of
 * them. Errors: VV_E_UNSUPPORTED (the back end cannot), VV_E_CANCELLED. */
vv_status vvi_gfx_pick(vvi_gfx_picked *out, vvi_gfx *gfx, double x, double y, double beyond);
#endif
