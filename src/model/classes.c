/* The tables: every field of every struct of <volvis/model.h>, its name, range, default and one line of doc. */
#include "model/classes.h"
#include <stddef.h>

#define MOST 1e308 /* no upper limit */
#define TINY 1e-12 /* more than 0 */
#define END                                                                                                            \
    {                                                                                                                  \
        0                                                                                                              \
    }

/* Cut planes ---------------------------------------------------------------------------------------------------- */

/* Words of people for names of the table "colormaps". */
static const char *const colormap_aliases[] = {"grey", "gray", NULL};

static const vv_property cut_plane[] = {
    {VV_PROP(vv_cut_plane, on), .kind = VV_KIND_BOOL, .def = 1, .doc = "whether it cuts"},
    {VV_PROP(vv_cut_plane, normal), .kind = VV_KIND_VEC3, .def_text = "[0, 0, 1]",
     .doc = "points towards the side that is kept; any length but 0"},
    {VV_PROP(vv_cut_plane, offset), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH,
     .doc = "distance from the origin along the unit normal"},
    END,
};
const vv_class vv_cut_plane_class = {
    .name = "cut_plane",
    .doc = "the half-space that is kept: normal . p >= offset",
    .size = sizeof(vv_cut_plane),
    .properties = cut_plane,
    .check = vvi_check_cut_plane,
};

/* Shading ------------------------------------------------------------------------------------------------------- */

static const char *const shading_models[] = {"none", "phong", "blinn", NULL};
static const vv_property shading[] = {
    {VV_PROP(vv_shading, model), .kind = VV_KIND_ENUM, .names = shading_models, .def = VV_SHADING_BLINN,
     .doc = "local illumination; none shows colours unlit"},
    {VV_PROP(vv_shading, ambient), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 10, .def = 0.15,
     .doc = "share of the ambient light that is reflected"},
    {VV_PROP(vv_shading, diffuse), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 10, .def = 0.75,
     .doc = "share of the light that is reflected diffusely"},
    {VV_PROP(vv_shading, specular), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 10, .def = 0.25,
     .doc = "strength of specular highlights"},
    {VV_PROP(vv_shading, shininess), .kind = VV_KIND_F64, .limited = true, .min = 1, .max = 10000, .def = 30,
     .doc = "exponent of specular highlights: the larger, the smaller and sharper they are"},
    {VV_PROP(vv_shading, two_sided), .kind = VV_KIND_BOOL, .def = 1,
     .doc = "light both sides of a surface, whichever faces the viewer"},
    {VV_PROP(vv_shading, cap), .kind = VV_KIND_BOOL, .def = 1,
     .doc = "fill the cuts of closed meshes, and light the cut faces of clouds as flat faces instead of by the "
            "gradient of "
            "the data there"},
    END,
};
const vv_class vv_shading_class = {
    .name = "shading",
    .doc = "local illumination; what is unset for a volume is taken from the World",
    .size = sizeof(vv_shading),
    .properties = shading,
};

/* Lights -------------------------------------------------------------------------------------------------------- */

static const char *const light_kinds[] = {"ambient", "directional", "point", "spot", NULL};
static const char *const light_frames[] = {"world", "camera", NULL};
static const vv_property light[] = {
    {VV_PROP(vv_light, title), VVI_LINE, .doc = "free text"},
    {VV_PROP(vv_light, on), .kind = VV_KIND_BOOL, .def = 1, .doc = "whether it shines"},
    {VV_PROP(vv_light, kind), .kind = VV_KIND_ENUM, .names = light_kinds, .def = VV_LIGHT_DIRECTIONAL,
     .doc = "kind of light source"},
    {VV_PROP(vv_light, frame), .kind = VV_KIND_ENUM, .names = light_frames, .def = VV_LIGHT_IN_WORLD,
     .doc = "coordinate system of position and direction; camera: x right, y up, z towards the viewer"},
    {VV_PROP(vv_light, color), .kind = VV_KIND_COLOR, .doc = "colour at intensity 1"},
    {VV_PROP(vv_light, intensity), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 1e9, .def = 1,
     .doc = "factor applied to the colour"},
    {VV_PROP(vv_light, position), .kind = VV_KIND_VEC3, .quantity = VV_Q_LENGTH, .doc = "of point and spot lights"},
    {VV_PROP(vv_light, direction), .kind = VV_KIND_VEC3, .def_text = "[0, 0, -1]",
     .doc = "direction in which the light of directional and spot lights travels"},
    {VV_PROP(vv_light, cone), .kind = VV_KIND_F64, .quantity = VV_Q_ANGLE, .limited = true, .min = 0, .max = 180,
     .def = 40, .doc = "full cone angle of a spot light"},
    {VV_PROP(vv_light, softness), .kind = VV_KIND_F64, .quantity = VV_Q_RATIO, .limited = true, .min = 0, .max = 1,
     .def = 0.2, .doc = "share of a spot light's cone over which it fades"},
    {VV_PROP(vv_light, falloff), .kind = VV_KIND_VEC3, .def_text = "[1, 0, 0]", .limited = true, .min = 0, .max = MOST,
     .doc = "of point and spot lights: 1 / (x + y d + z d^2) at distance d"},
    END,
};
const vv_class vv_light_class = {
    .name = "light",
    .doc = "a light source",
    .size = sizeof(vv_light),
    .properties = light,
};

/* Segmentation -------------------------------------------------------------------------------------------------- */

static const vv_property threshold[] = {
    {VV_PROP(vv_threshold, lo), .kind = VV_KIND_F64, .unit = "value",
     .automatic = "the value that best splits the histogram in two", .doc = "smallest value of the object"},
    {VV_PROP(vv_threshold, hi), .kind = VV_KIND_F64, .unit = "value", .automatic = "the largest value",
     .doc = "largest value of the object"},
    END,
};
const vv_class vvi_threshold_class = {
    .name = "threshold",
    .doc = "values from lo to hi are the object: solid, with a surface",
    .size = sizeof(vv_threshold),
    .properties = threshold,
};

static const vv_property region[] = {
    {VV_PROP(vv_transfer_region, value_lo), .kind = VV_KIND_F64, .unit = "value",
     .doc = "smallest value at gradient_lo"},
    {VV_PROP(vv_transfer_region, value_hi), .kind = VV_KIND_F64, .unit = "value", .def = 1,
     .doc = "largest value at gradient_lo"},
    {VV_PROP(vv_transfer_region, gradient_lo), .kind = VV_KIND_F64, .unit = "value per length", .limited = true,
     .min = 0, .max = MOST, .doc = "smallest gradient magnitude"},
    {VV_PROP(vv_transfer_region, gradient_hi), .kind = VV_KIND_F64, .unit = "value per length", .limited = true,
     .min = 0, .max = MOST, .automatic = "no limit", .doc = "longest gradient"},
    {VV_PROP(vv_transfer_region, top_lo), .kind = VV_KIND_F64, .unit = "largest gradient magnitude",
     .automatic = "value_lo", .doc = "smallest value at gradient_hi"},
    {VV_PROP(vv_transfer_region, top_hi), .kind = VV_KIND_F64, .unit = "value", .automatic = "value_hi",
     .doc = "largest value at gradient_hi"},
    {VV_PROP(vv_transfer_region, color), .kind = VV_KIND_COLOR, .doc = "colour inside the region"},
    {VV_PROP(vv_transfer_region, opacity), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 1, .def = 0.5,
     .doc = "opacity in its middle, per opacity_length"},
    {VV_PROP(vv_transfer_region, edge), .kind = VV_KIND_F64, .quantity = VV_Q_RATIO, .limited = true, .min = 0,
     .max = 1, .def = 0.5, .doc = "share of its half width over which opacity falls to 0; 0: a hard edge"},
    END,
};
const vv_class vvi_transfer_region_class = {
    .name = "region",
    .doc = "a trapezoid of values and gradients: a rectangle where the top is unset, a triangle where one side shrinks "
           "to a point",
    .size = sizeof(vv_transfer_region),
    .properties = region,
};

static const vv_property transfer[] = {
    {VV_PROP(vv_transfer, preset), VVI_WORD, .table = "presets",
     .automatic = "none: opacity is fitted to the histogram",
     .doc = "a named transfer function, used where opacity or color is unset"},
    {VV_PROP(vv_transfer, colormap), VVI_WORD, .table = "colormaps", .aliases = colormap_aliases,
     .automatic = "the preset's, else tissue for anatomical data, viridis for other data",
     .doc = "a named colour map over the range, used where color is unset"},
    {VV_PROP(vv_transfer, range_lo), .kind = VV_KIND_F64, .unit = "value", .automatic = "from the histogram",
     .doc = "value at which normalised presets and colour maps begin"},
    {VV_PROP(vv_transfer, range_hi), .kind = VV_KIND_F64, .unit = "value", .automatic = "from the histogram",
     .doc = "value at which normalised presets and colour maps end"},
    {VV_PROP(vv_transfer, opacity), .kind = VV_KIND_NUMBERS, .columns = 2,
     .automatic = "the preset's, else fitted to the histogram",
     .doc = "rows (value, opacity per opacity_length), in ascending order of value"},
    {VV_PROP(vv_transfer, color), .kind = VV_KIND_NUMBERS, .columns = 4,
     .automatic = "the preset's, else the colour map over the range",
     .doc = "rows (value, red, green, blue), linear, in ascending order of value"},
    {VV_PROP(vv_transfer, opacity_length), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true, .min = TINY,
     .max = MOST, .def = 1, .automatic = "1 where opacity is given, else the smallest spacing",
     .doc = "length to which opacities refer"},
    {VV_PROP(vv_transfer, opacity_scale), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 1e6, .def = 1,
     .doc = "factor applied to extinction: above 1 denser, below 1 thinner"},
    {VV_PROP(vv_transfer, gradient_power), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 100,
     .doc = "above 0 only boundaries are seen: opacity fades with (gradient / gradient_reference)^gradient_power"},
    {VV_PROP(vv_transfer, gradient_reference), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = MOST,
     .unit = "value per length", .automatic = "the 99th percentile of the gradients",
     .doc = "gradient magnitude from which opacity is applied in full"},
    {VV_PROP(vv_transfer, regions), .kind = VV_KIND_LIST, .cls = &vvi_transfer_region_class,
     .doc = "a two-dimensional transfer function: opacity and colour by value and gradient, used instead of opacity "
            "and color"},
    END,
};
const vv_class vvi_transfer_class = {
    .name = "transfer",
    .doc = "opacity and colour by value, piecewise linear; two nodes at the same value make a step",
    .size = sizeof(vv_transfer),
    .properties = transfer,
    .check = vvi_check_transfer,
};

static const vv_property label_name[] = {
    {VV_PROP(vv_label_name, label), .kind = VV_KIND_I64, .quantity = VV_Q_LABEL, .doc = "its number in the samples"},
    {VV_PROP(vv_label_name, name), VVI_LINE, .doc = "its name: free text"},
    END,
};
const vv_class vvi_label_name_class = {
    .name = "label_name",
    .doc = "the name of a label",
    .size = sizeof(vv_label_name),
    .properties = label_name,
};

static const vv_property labels[] = {
    {VV_PROP(vv_labels, table), .kind = VV_KIND_NUMBERS, .columns = 5, .quantity = VV_Q_LABEL,
     .automatic = "a different colour for each label",
     .doc = "rows (label, red, green, blue, opacity per opacity length), in ascending order of label"},
    {VV_PROP(vv_labels, names), .kind = VV_KIND_LIST, .cls = &vvi_label_name_class, .doc = "names of the labels"},
    {VV_PROP(vv_labels, opacity), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 1, .def = 0.5,
     .doc = "of labels without a row; label 0 is transparent"},
    END,
};
const vv_class vvi_labels_class = {
    .name = "labels",
    .doc = "colour and opacity of each label",
    .size = sizeof(vv_labels),
    .properties = labels,
    .check = vvi_check_labels,
};

static const char *const encodings[] = {"srgb", "linear", NULL};
static const vv_property color_data[] = {
    {VV_PROP(vv_color_data, encoding), .kind = VV_KIND_ENUM, .names = encodings, .def = VV_ENCODING_SRGB,
     .automatic = "srgb for integers, linear for floating-point numbers", .doc = "colour space of red, green and blue"},
    END,
};
const vv_class vvi_color_data_class = {
    .name = "colors",
    .doc = "data whose samples are colours: RGB or RGBA",
    .size = sizeof(vv_color_data),
    .properties = color_data,
};

static const char *const segmentation_kinds[] = {"transfer", "threshold", "labels", "colors", NULL};
static const vv_property segmentation[] = {
    {VV_PROP(vv_segmentation, kind), .kind = VV_KIND_ENUM, .names = segmentation_kinds, .def = VV_SEGMENT_TRANSFER,
     .automatic = "labels for label data, and for integers that look like labels where nothing else is set; colors for "
                  "RGB and RGBA unless a channel is named; else transfer",
     .doc = "which of the ways below decides what is seen"},
    {VV_PROP(vv_segmentation, threshold), .kind = VV_KIND_OBJECT, .cls = &vvi_threshold_class,
     .doc = "values between two limits are solid; of RGB and RGBA luminance and alpha, 0 to 1, as for surfaces"},
    {VV_PROP(vv_segmentation, transfer), .kind = VV_KIND_OBJECT, .cls = &vvi_transfer_class,
     .doc = "opacity and colour by value"},
    {VV_PROP(vv_segmentation, labels), .kind = VV_KIND_OBJECT, .cls = &vvi_labels_class,
     .doc = "opacity and colour by label"},
    {VV_PROP(vv_segmentation, colors), .kind = VV_KIND_OBJECT, .cls = &vvi_color_data_class,
     .doc = "the data's own colours; opacity from alpha or luminance, 0 to 1, by transfer.opacity"},
    END,
};
const vv_class vv_segmentation_class = {
    .name = "segmentation",
    .doc = "which values are seen, and in which colour; the settings of all ways are kept side by side",
    .size = sizeof(vv_segmentation),
    .properties = segmentation,
};

/* Volumes ------------------------------------------------------------------------------------------------------- */

static const vv_property placement[] = {
    {VV_PROP(vv_placement, position), .kind = VV_KIND_VEC3, .quantity = VV_Q_LENGTH, .doc = "position of its origin"},
    {VV_PROP(vv_placement, rotation), .kind = VV_KIND_VEC3, .quantity = VV_Q_ANGLE,
     .doc = "rotation about x, then y, then z"},
    {VV_PROP(vv_placement, scale), .kind = VV_KIND_VEC3, .def_text = "[1, 1, 1]",
     .doc = "factors along its own axes, applied before rotation; must not be 0"},
    {VV_PROP(vv_placement, matrix), .kind = VV_KIND_NUMBERS, .columns = 4,
     .automatic = "from position, rotation and scale",
     .doc = "3 rows of 4 numbers, used instead of the others: world = matrix [x, y, z, 1]"},
    END,
};
const vv_class vvi_placement_class = {
    .name = "placement",
    .doc = "places an object in the World",
    .size = sizeof(vv_placement),
    .properties = placement,
    .check = vvi_check_placement,
};

static const vv_property paint[] = {
    {VV_PROP(vv_volume_paint, data), .kind = VV_KIND_REF, .ref_to = "datasets", .automatic = "none: its own colours",
     .doc = "name of the dataset whose values colour the volume, at the same positions"},
    {VV_PROP(vv_volume_paint, attribute), VVI_LINE, .automatic = "the first", .doc = "which field of the dataset"},
    {VV_PROP(vv_volume_paint, component), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 65535,
     .doc = "which channel of a sample, from 0"},
    {VV_PROP(vv_volume_paint, frame), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 1e9,
     .doc = "which time step, from 0"},
    {VV_PROP(vv_volume_paint, colormap), VVI_WORD, .table = "colormaps", .aliases = colormap_aliases,
     .automatic = "viridis; of labels their own colours",
     .doc = "a named colour map over the range, used where color is unset"},
    {VV_PROP(vv_volume_paint, range_lo), .kind = VV_KIND_F64, .unit = "value", .automatic = "the smallest value",
     .doc = "value at which the colour map begins"},
    {VV_PROP(vv_volume_paint, range_hi), .kind = VV_KIND_F64, .unit = "value", .automatic = "the largest value",
     .doc = "value at which the colour map ends"},
    {VV_PROP(vv_volume_paint, color), .kind = VV_KIND_NUMBERS, .columns = 4,
     .automatic = "the colour map over the range",
     .doc = "rows (value, red, green, blue), linear, in ascending order of value"},
    END,
};
const vv_class vvi_volume_paint_class = {
    .name = "paint",
    .doc = "colours from another dataset, such as a functional map on anatomy; opacity stays the volume's own",
    .size = sizeof(vv_volume_paint),
    .properties = paint,
    .check = vvi_check_paint,
};

static const char *const slice_colors[] = {"window", "transfer", NULL};
static const char *const slice_blends[] = {"over", "add", NULL};
static const vv_property slices[] = {
    {VV_PROP(vv_volume_slices, colors), .kind = VV_KIND_ENUM, .names = slice_colors, .def = VV_SLICE_WINDOW,
     .doc = "a colour map over a window of values, or the colours of the transfer function; labels and colour data "
            "keep their own colours"},
    {VV_PROP(vv_volume_slices, window_lo), .kind = VV_KIND_F64, .unit = "value",
     .automatic = "what the file says, else the 1st percentile; of coolwarm as far from 0 as the other end",
     .doc = "value at which the colour map begins: black"},
    {VV_PROP(vv_volume_slices, window_hi), .kind = VV_KIND_F64, .unit = "value",
     .automatic = "what the file says, else the 99.9th percentile; of coolwarm as far from 0 as the other end",
     .doc = "value at which the colour map ends: white"},
    {VV_PROP(vv_volume_slices, colormap), VVI_WORD, .table = "colormaps", .aliases = colormap_aliases,
     .automatic = "from black to the channel's colour, or to white (#ffffff); coolwarm for values about zero",
     .doc = "a named colour map, or #rrggbb: from black to that colour"},
    {VV_PROP(vv_volume_slices, blend), .kind = VV_KIND_ENUM, .names = slice_blends, .def = VV_SLICE_OVER,
     .automatic = "add for channels, else over", .doc = "how it is blended with the volumes before it"},
    {VV_PROP(vv_volume_slices, opacity), .kind = VV_KIND_F64, .quantity = VV_Q_RATIO, .limited = true, .min = 0,
     .max = 1, .def = 1, .automatic = "1; 50% over other volumes if nothing of it is clear",
     .doc = "of its slices; what is transparent stays transparent"},
    {VV_PROP(vv_volume_slices, clear_below), .kind = VV_KIND_BOOL,
     .automatic = "over other volumes if window_lo is set", .doc = "whether values below the window are transparent"},
    END,
};
const vv_class vvi_volume_slices_class = {
    .name = "slices",
    .doc = "how slices show it",
    .size = sizeof(vv_volume_slices),
    .properties = slices,
};

const char *const vvi_ray_modes[] = {"composite", "maximum",       "minimum",    "mean",
                                     "sum",       "local-maximum", "isosurface", NULL};
const char *const vvi_ray_mode_aliases[] = {"mip", "maximum", "minip", "minimum", "xray",       "sum", "x-ray",
                                            "sum", "average", "mean",  "iso",     "isosurface", NULL};
static const vv_property rays[] = {
    {VV_PROP(vv_volume_rays, mode), .kind = VV_KIND_ENUM, .names = vvi_ray_modes, .aliases = vvi_ray_mode_aliases,
     .def = VV_RAY_COMPOSITE, .automatic = "the view's",
     .doc =
         "what is computed from its values along a ray; modes of one value (maximum, mean, ...) are layers over what "
         "else is drawn, in the order of volumes"},
    {VV_PROP(vv_volume_rays, iso), .kind = VV_KIND_F64, .unit = "value", .automatic = "the view's",
     .doc = "value of its surface in mode isosurface"},
    {VV_PROP(vv_volume_rays, threshold), .kind = VV_KIND_F64, .unit = "value", .automatic = "the view's",
     .doc = "in mode local-maximum: local maxima below this value are ignored"},
    {VV_PROP(vv_volume_rays, step), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true, .min = 1e-9,
     .max = 1e12, .automatic = "the view's, which follows the volume's own voxels",
     .doc = "distance between samples inside it"},
    {VV_PROP(vv_volume_rays, blend), .kind = VV_KIND_ENUM, .names = slice_blends, .def = VV_SLICE_OVER,
     .automatic = "add for channels, else over", .doc = "as a layer: over what lies below, or its light added to that"},
    {VV_PROP(vv_volume_rays, opacity), .kind = VV_KIND_F64, .quantity = VV_Q_RATIO, .limited = true, .min = 0, .max = 1,
     .def = 1,
     .doc =
         "as a layer: factor on its opacity, which is the transfer function's for one opacity_length; by itself that "
         "grows from the first to the last of the colours"},
    END,
};
const vv_class vvi_volume_rays_class = {
    .name = "rays",
    .doc = "how rays show it, where that is not as the view says",
    .size = sizeof(vv_volume_rays),
    .properties = rays,
};

static const char *const interpolations[] = {"linear", "nearest", "cubic", NULL};
static const vv_property volume[] = {
    {VV_PROP(vv_volume, title), VVI_LINE, .doc = "free text"},
    {VV_PROP(vv_volume, visible), .kind = VV_KIND_BOOL, .def = 1, .doc = "whether it is shown"},
    {VV_PROP(vv_volume, data), .kind = VV_KIND_REF, .ref_to = "datasets", .automatic = "the only dataset",
     .doc = "name of the dataset that it shows"},
    {VV_PROP(vv_volume, attribute), VVI_LINE, .automatic = "the first", .doc = "which field of the dataset"},
    {VV_PROP(vv_volume, component), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 65535,
     .doc = "which channel of a sample, from 0"},
    {VV_PROP(vv_volume, frame), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 1e9,
     .doc = "which time step, from 0"},
    {VV_PROP(vv_volume, level), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 0,
     .doc = "which level of detail, from 0, the finest"},
    {VV_PROP(vv_volume, missing), .kind = VV_KIND_NUMBERS, .columns = 1, .lone = true,
     .automatic = "one value far from all others that many samples have, such as -9999",
     .doc = "values that stand for none, and are not seen; []: every value is one"},
    {VV_PROP(vv_volume, place), .kind = VV_KIND_OBJECT, .cls = &vvi_placement_class,
     .doc = "position, applied after the placement that its data gives"},
    {VV_PROP(vv_volume, segmentation), .kind = VV_KIND_OBJECT, .cls = &vv_segmentation_class,
     .doc = "which of its values are seen"},
    {VV_PROP(vv_volume, shading), .kind = VV_KIND_OBJECT, .cls = &vv_shading_class,
     .doc = "its own illumination; what is unset is taken from the World"},
    {VV_PROP(vv_volume, interpolation), .kind = VV_KIND_ENUM, .names = interpolations, .def = VV_INTERPOLATE_LINEAR,
     .automatic = "linear; nearest for labels and for single slices",
     .doc = "values between samples; cubic: a smooth curve through them; linear for labels: smooth borders"},
    {VV_PROP(vv_volume, color), .kind = VV_KIND_COLOR, .def_text = "\"#e6dcc8\"",
     .doc = "of surfaces: threshold, isosurface, mesh; where several have none set they get different ones"},
    {VV_PROP(vv_volume, paint), .kind = VV_KIND_OBJECT, .cls = &vvi_volume_paint_class,
     .doc = "colours from the values of another dataset"},
    {VV_PROP(vv_volume, texture), .kind = VV_KIND_OBJECT, .cls = &vvi_volume_texture_class,
     .doc = "an image or a pattern applied to its colours"},
    {VV_PROP(vv_volume, cut_planes), .kind = VV_KIND_LIST, .cls = &vv_cut_plane_class,
     .doc = "its own cut planes, in the space of its data"},
    {VV_PROP(vv_volume, slices), .kind = VV_KIND_OBJECT, .cls = &vvi_volume_slices_class, .doc = "how slices show it"},
    {VV_PROP(vv_volume, rays), .kind = VV_KIND_OBJECT, .cls = &vvi_volume_rays_class,
     .doc = "how rays show it, where that is not as the view says"},
    END,
};
const vv_class vv_volume_class = {
    .name = "volume",
    .doc = "which dataset is shown, where and how",
    .size = sizeof(vv_volume),
    .properties = volume,
};

/* Datasets ------------------------------------------------------------------------------------------------------ */

static const vv_property dataset[] = {
    {VV_PROP(vv_dataset, title), VVI_LINE, .doc = "free text"},
    {VV_PROP(vv_dataset, kind), VVI_WORD, .table = "data_kinds",
     .automatic = "from the file: mesh for meshes, else regular", .doc = "how the samples fill space; mesh: triangles"},
    {VV_PROP(vv_dataset, path), .kind = VV_KIND_PATH, .automatic = "none: made in memory",
     .doc = "the file; in a scene file, relative to that file"},
    {VV_PROP(vv_dataset, format), VVI_WORD, .table = "formats", .automatic = "from the contents, then from the suffix",
     .doc = "file format"},
    {VV_PROP(vv_dataset, part), VVI_TEXT(4096), .automatic = "chosen by the reader",
     .doc = "which data set of a file or folder that holds several: an array's path, a series, a level"},
    {VV_PROP(vv_dataset, raw), VVI_LINE, .automatic = "from the header, or from the file's name",
     .doc = "layout of a headerless file: 256x256x128,u8[,spacing=1x1x1.4][,big][,skip=N]"},
    {VV_PROP(vv_dataset, checksum), VVI_WORD, .automatic = "not checked",
     .doc = "crc32:89abcdef of the samples of time step 0; checked when they are read"},
    {VV_PROP(vv_dataset, operation), VVI_WORD, .automatic = "none: it was not made of others",
     .doc = "the operation that makes it of other datasets, as listed by 'volvis operations'; with a path: that made "
            "the file"},
    {VV_PROP(vv_dataset, inputs), .kind = VV_KIND_MEMBERS, .limited = true, .max = 4096,
     .automatic = "none: source alone",
     .doc = "names of the datasets that the operation works on, by input: {\"volume\": \"ct\"}"},
    {VV_PROP(vv_dataset, parameters), .kind = VV_KIND_MEMBERS, .limited = true, .max = 65536,
     .automatic = "none: the operation's defaults",
     .doc = "parameters of the operation, by name: {\"sigma\": \"1mm\"}; 'volvis help OPERATION' lists them"},
    {VV_PROP(vv_dataset, source), VVI_WORD, .automatic = "none: inputs name them all",
     .doc = "the first input of the operation, where inputs does not name it"},
    {VV_PROP(vv_dataset, on), .kind = VV_KIND_BOOL, .def = 1,
     .doc = "whether the operation is applied; off: the first input stands for what it would make"},
    END,
};
const vv_class vv_dataset_class = {
    .name = "dataset",
    .doc = "samples and where they come from",
    .size = sizeof(vv_dataset),
    .properties = dataset,
    .copy_hidden = vvi_dataset_copy_fields,
    .drop_hidden = vvi_dataset_drop_fields,
    .check = vvi_check_dataset,
};

/* Views --------------------------------------------------------------------------------------------------------- */

static const char *const fits[] = {"visible", "data", NULL};
static const char *const projections[] = {"perspective", "parallel", NULL};
static const vv_property camera[] = {
    {VV_PROP(vv_camera, projection), .kind = VV_KIND_ENUM, .names = projections, .def = VV_PERSPECTIVE,
     .doc = "how depth is shown"},
    {VV_PROP(vv_camera, azimuth), .kind = VV_KIND_F64, .quantity = VV_Q_ANGLE,
     .doc = "rotation about the World's up axis, from the front"},
    {VV_PROP(vv_camera, elevation), .kind = VV_KIND_F64, .quantity = VV_Q_ANGLE, .doc = "angle above the horizon"},
    {VV_PROP(vv_camera, roll), .kind = VV_KIND_F64, .quantity = VV_Q_ANGLE, .doc = "rotation about the line of sight"},
    {VV_PROP(vv_camera, eye), .kind = VV_KIND_VEC3, .quantity = VV_Q_LENGTH,
     .automatic = "from the angles, far enough away to see everything", .doc = "position of the viewer"},
    {VV_PROP(vv_camera, at), .kind = VV_KIND_VEC3, .quantity = VV_Q_LENGTH,
     .automatic = "the middle of what is visible", .doc = "point that the viewer looks at"},
    {VV_PROP(vv_camera, up), .kind = VV_KIND_VEC3, .def_text = "[0, 0, 1]", .automatic = "from the angles",
     .doc = "direction that is up in the image"},
    {VV_PROP(vv_camera, fov), .kind = VV_KIND_F64, .quantity = VV_Q_ANGLE, .limited = true, .min = 0.01, .max = 170,
     .def = 20, .doc = "perspective: full vertical field of view"},
    {VV_PROP(vv_camera, height), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true, .min = TINY,
     .max = MOST, .def = 1, .automatic = "everything fits", .doc = "parallel: height of the image in the World"},
    {VV_PROP(vv_camera, zoom), .kind = VV_KIND_F64, .limited = true, .min = 1e-6, .max = 1e6, .def = 1,
     .doc = "magnification: above 1, the image shows a smaller part, larger"},
    {VV_PROP(vv_camera, fit), .kind = VV_KIND_ENUM, .names = fits, .def = VV_FIT_VISIBLE,
     .doc = "what to fit into the image where no eye is set: the visible parts of volumes and meshes, or their whole "
            "boxes; boxes and axes that are drawn fit in too"},
    END,
};
const vv_class vv_camera_class = {
    .name = "camera",
    .doc = "where the image is seen from",
    .size = sizeof(vv_camera),
    .properties = camera,
};

static const vv_property layer_choice[] = {
    {VV_PROP(vv_layer_choice, depth), .kind = VV_KIND_BOOL,
     .doc = "distance from the eye; infinite where nothing is seen"},
    {VV_PROP(vv_layer_choice, normal), .kind = VV_KIND_BOOL,
     .doc = "normal of the visible surface in world space; 0 where nothing is seen"},
    {VV_PROP(vv_layer_choice, id), .kind = VV_KIND_BOOL,
     .doc = "1 + number of the volume among the visible ones; 0 where nothing is seen"},
    {VV_PROP(vv_layer_choice, samples), .kind = VV_KIND_BOOL, .doc = "rays cast for the pixel"},
    {VV_PROP(vv_layer_choice, value), .kind = VV_KIND_BOOL,
     .doc = "value of the data at the depth; NaN where nothing is seen"},
    END,
};
const vv_class vvi_layer_choice_class = {
    .name = "layers",
    .doc = "layers that the image holds in addition to its colours",
    .size = sizeof(vv_layer_choice),
    .properties = layer_choice,
};

static const char *const qualities[] = {"draft", "normal", "high", "reference", NULL};
static const vv_property render_choice[] = {
    {VV_PROP(vv_render_choice, method), VVI_WORD, .table = "renderers",
     .automatic = "raycast; surface where a mesh is shown", .doc = "the rendering method"},
    {VV_PROP(vv_render_choice, quality), .kind = VV_KIND_ENUM, .names = qualities, .def = VV_QUALITY_NORMAL,
     .doc = "from fast and rough to slow and accurate: sets the parameters of the method that are unset"},
    {VV_PROP(vv_render_choice, samples), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = 65536, .def = 1,
     .automatic = "by quality: 1, 2, 4 or 16; where more than clouds are seen 1, 4, 8 or 16; for slices and where "
                  "layers are asked for 1, 1, 4 or 16; 1 where adaptive is set; 1024 where noise or budget is set",
     .doc = "rays per pixel, at most"},
    {VV_PROP(vv_render_choice, noise), .kind = VV_KIND_F64, .quantity = VV_Q_RATIO, .limited = true, .min = 0, .max = 1,
     .automatic = "not estimated: all pixels get the same number of rays",
     .doc = "more rays only for pixels whose estimated error is above this share of the range from black to white: 1%"},
    {VV_PROP(vv_render_choice, budget), .kind = VV_KIND_F64, .quantity = VV_Q_TIME, .limited = true, .min = 0,
     .max = 1e9, .automatic = "no limit",
     .doc = "more rays until this time has passed, as in 10s; every pixel gets one, however long that takes"},
    {VV_PROP(vv_render_choice, adaptive), .kind = VV_KIND_BOOL, .automatic = "at draft quality",
     .doc = "one ray for 4 x 4 pixels where the light hardly changes, one ray per pixel elsewhere; only with one ray "
            "per pixel and no layers but depth"},
    {VV_PROP(vv_render_choice, layers), .kind = VV_KIND_OBJECT, .cls = &vvi_layer_choice_class,
     .doc = "what the image holds in addition to its colours, pixel by pixel"},
    {VV_PROP(vv_render_choice, methods), .kind = VV_KIND_VARIANTS, .table = "renderers",
     .doc = "parameters of each method, by method name"},
    END,
};
const vv_class vvi_render_choice_class = {
    .name = "render",
    .doc = "the rendering method, its quality and its parameters",
    .size = sizeof(vv_render_choice),
    .properties = render_choice,
};

static const vv_property view[] = {
    {VV_PROP(vv_view, title), VVI_LINE, .doc = "free text"},
    {VV_PROP(vv_view, width), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = 32768, .def = 800,
     .unit = "pixels", .doc = "of the image"},
    {VV_PROP(vv_view, height), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = 32768, .def = 800,
     .unit = "pixels", .doc = "of the image"},
    {VV_PROP(vv_view, camera), .kind = VV_KIND_OBJECT, .cls = &vv_camera_class, .doc = "where the image is seen from"},
    {VV_PROP(vv_view, render), .kind = VV_KIND_OBJECT, .cls = &vvi_render_choice_class, .doc = "how the image is made"},
    {VV_PROP(vv_view, decorations), .kind = VV_KIND_OBJECT, .cls = &vvi_decorations_class,
     .doc = "what is drawn on top of the image"},
    END,
};
const vv_class vv_view_class = {
    .name = "view",
    .doc = "an image of the World: camera, size, rendering method",
    .size = sizeof(vv_view),
    .properties = view,
};

/* The World ----------------------------------------------------------------------------------------------------- */

static const char *const ups[] = {"z", "y", NULL};
static const vv_property world[] = {
    {VV_PROP(vv_world, schema), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = 1e9, .def = VV_SCHEMA_VERSION,
     .doc = "version of the scene file's vocabulary"},
    {VV_PROP(vv_world, title), VVI_LINE, .doc = "free text"},
    {VV_PROP(vv_world, unit), VVI_WORD, .def_text = "\"voxels\"",
     .doc = "of all lengths: mm, um, m, ...; units: spacing without a unit; voxels: no spacing"},
    {VV_PROP(vv_world, background), .kind = VV_KIND_COLOR, .def_text = "\"#000000\"",
     .doc = "colour behind everything; transparent keeps the image's alpha"},
    {VV_PROP(vv_world, ambient), .kind = VV_KIND_COLOR, .def_text = "\"#ffffff\"",
     .doc = "light that comes from everywhere"},
    {VV_PROP(vv_world, seed), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 9007199254740991,
     .doc = "for everything random: the same seed gives the same image"},
    {VV_PROP(vv_world, shading), .kind = VV_KIND_OBJECT, .cls = &vv_shading_class,
     .doc = "illumination of every volume that does not set its own"},
    {VV_PROP(vv_world, cut_planes), .kind = VV_KIND_LIST, .cls = &vv_cut_plane_class,
     .doc = "cut planes through everything, in world space"},
    {VV_PROP(vv_world, datasets), .kind = VV_KIND_MAP, .cls = &vv_dataset_class, .doc = "samples, by name"},
    {VV_PROP(vv_world, volumes), .kind = VV_KIND_MAP, .cls = &vv_volume_class, .doc = "what is shown, by name"},
    {VV_PROP(vv_world, lights), .kind = VV_KIND_MAP, .cls = &vv_light_class, .doc = "light sources, by name"},
    {VV_PROP(vv_world, views), .kind = VV_KIND_MAP, .cls = &vv_view_class, .doc = "images, by name"},
    {VV_PROP(vv_world, measurements), .kind = VV_KIND_MAP, .cls = &vvi_measurement_class,
     .doc = "what was measured and the results, by name"},
    {VV_PROP(vv_world, cross_hair), .kind = VV_KIND_VEC3, .quantity = VV_Q_LENGTH,
     .automatic = "the middle sample of the first volume", .doc = "where the slices meet, in world space"},
    {VV_PROP(vv_world, up), .kind = VV_KIND_ENUM, .names = ups, .def = VV_UP_Z,
     .automatic = "y for meshes of OBJ, PLY and OFF that do not say otherwise, else z",
     .doc = "the axis that points up: cameras stand by it, and turn about it"},
    END,
};
const vv_class vv_world_class = {
    .name = "world",
    .doc = "a scene of VolVis: datasets, volumes, lights and views",
    .size = sizeof(vv_world),
    .properties = world,
};
