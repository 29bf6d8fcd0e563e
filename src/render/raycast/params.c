/* The ray caster's parameters, as rows. */
#include "model/classes.h"
#include "render/raycast/raycast.h"

static const char *const gradient_names[] = {"central", "cell", NULL};

static const char *const lighting_names[] = {"local", "cinematic", NULL};
#define LIT "mode=composite|isosurface"

static const vv_property properties[] = {
    {VV_PROP(vvi_raycast_params, mode), .kind = VV_KIND_ENUM, .names = vvi_ray_modes, .aliases = vvi_ray_mode_aliases,
     .def = VV_RAY_COMPOSITE,
     .doc = "what is computed from the values along a ray: light through a cloud; their maximum, minimum or mean; "
            "their sum relative to the length of the volume's diagonal, as in an X-ray; the first local maximum above "
            "the threshold; or the first surface. A volume may have its own (rays.mode)"},
    {VV_PROP(vvi_raycast_params, iso), .kind = VV_KIND_F64, .unit = "value",
     .automatic = "a valley of the histogram between the background and the object", .when = "mode=isosurface",
     .doc = "value of the surface in isosurface mode"},
    {VV_PROP(vvi_raycast_params, threshold), .kind = VV_KIND_F64, .unit = "value", .automatic = "like iso",
     .when = "mode=local-maximum", .doc = "local maxima below this value are ignored"},
    {VV_PROP(vvi_raycast_params, step), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true, .min = 1e-9,
     .max = 1e12, .automatic = "by quality: 2, 1, 0.5 or 0.125 of a volume's own voxels",
     .when = "mode=composite|maximum|minimum|mean|sum|local-maximum",
     .doc =
         "distance between samples along a ray (0.5vox, 1mm); opacity is per length, so it changes only the accuracy"},
    {VV_PROP(vvi_raycast_params, opaque), .label = "end of rays", .kind = VV_KIND_F64, .quantity = VV_Q_RATIO,
     .limited = true, .min = 0, .max = 0.5, .automatic = "by quality: 1/64, 1/512, 1/4096 or 0",
     .doc = "a ray ends when less than this share of light still passes"},
    {VV_PROP(vvi_raycast_params, gradient), .kind = VV_KIND_ENUM, .names = gradient_names, .def = VVI_GRADIENT_CENTRAL,
     .automatic = "cell for quality draft, else central",
     .doc = "gradient used for shading: central differences over two voxels, interpolated; or the derivative inside a "
            "cell, faster, with facets; cubic interpolation has its own"},
    {VV_PROP(vvi_raycast_params, jitter), .kind = VV_KIND_BOOL, .def = 0,
     .automatic = "on from two rays per pixel, except at quality reference",
     .doc = "vary the position of samples from ray to ray: fine grain instead of rings, which several passes average "
            "out; for light through clouds, mean and sum"},
    {VV_PROP(vvi_raycast_params, skipping), .label = "skip empty blocks", .kind = VV_KIND_BOOL, .def = 1,
     .doc = "skip blocks in which nothing is visible, or that a projection knows without their samples; the picture is "
            "the same without it, for surfaces, means and sums to rounding"},
    {VV_PROP(vvi_raycast_params, parc), .label = "skip empty ends", .kind = VV_KIND_BOOL, .def = 1,
     .doc = "follow rays only between the nearest and the farthest box in which something is visible; the picture is "
            "the same without it, to rounding; for light through clouds and for surfaces"},
    {VV_PROP(vvi_raycast_params, halvings), .label = "halve data, times", .kind = VV_KIND_I64, .limited = true,
     .min = 0, .max = 8, .automatic = "0; at quality draft as many as leave 2^25 samples, about 320 x 320 x 320",
     .doc = "how many times the samples of each axis are halved before rays are cast, to the mean of two or to what a "
            "projection looks for; for large volumes in motion. Labels, colours and nearest samples are not reduced"},
    {VV_PROP(vvi_raycast_params, preintegrated), .kind = VV_KIND_BOOL, .def = 0,
     .automatic = "on at quality reference, and at normal and high where opacity has a narrow peak (a ninth of the "
                  "values), where values are interpolated",
     .doc = "for composite: integrate colour and opacity over all values between two samples of a ray, so that thin "
            "peaks of a transfer function are not missed"},
    {VV_PROP(vvi_raycast_params, lighting), .kind = VV_KIND_ENUM, .names = lighting_names, .def = VVI_LIGHTING_LOCAL,
     .when = LIT,
     .doc = "local: every place is lit as if it were alone; cinematic: with shadows and ambient occlusion, and three "
            "times the ambient light, which these take away"},
    {VV_PROP(vvi_raycast_params, shadows), .kind = VV_KIND_BOOL, .automatic = "on with lighting cinematic", .when = LIT,
     .doc = "clouds, surfaces and meshes take light from what lies behind them as seen from each lamp"},
    {VV_PROP(vvi_raycast_params, ambient_occlusion), .kind = VV_KIND_BOOL, .automatic = "on with lighting cinematic",
     .when = LIT, .doc = "less ambient light arrives in hollows and between what is close together"},
    {VV_PROP(vvi_raycast_params, occlusion_radius), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true,
     .min = 1e-9, .max = 1e12, .automatic = "a twentieth of the diagonal of all that is drawn", .when = LIT,
     .doc = "how far away ambient light comes from in the mean: what is farther hides less of it"},
    {VV_PROP(vvi_raycast_params, lamp_size), .kind = VV_KIND_F64, .quantity = VV_Q_ANGLE, .limited = true, .min = 0,
     .max = 60, .def = 10, .when = LIT,
     .doc = "how large directional lamps look from everywhere: the larger, the softer the shadows"},
    {0},
};

const vv_class vvi_raycast_class = {
    .name = "raycast",
    .doc = "ray casting: light through clouds, one value per ray, or first surfaces",
    .size = sizeof(vvi_raycast_params),
    .properties = properties,
};
