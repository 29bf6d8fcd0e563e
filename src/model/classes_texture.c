/* The table of textures: an image or a pattern on the colours of a volume. */
#include "model/classes.h"
#include <stddef.h>

static const char *const kinds[] = {"none", "image", "checker", "wood", "marble", "noise", NULL};
static const char *const mappings[] = {"planar", "cylindrical", "spherical", NULL};
static const char *const wraps[] = {"repeat", "mirror", "clamp", NULL};
static const char *const ways[] = {"modulate", "replace", NULL};

static const vv_property texture[] = {
    {VV_PROP(vv_volume_texture, kind), .kind = VV_KIND_ENUM, .names = kinds,
     .automatic = "image where there is one, else none",
     .doc = "an image, or a pattern that fills space: what is cut open shows it too"},
    {VV_PROP(vv_volume_texture, image), .kind = VV_KIND_PATH, .automatic = "none",
     .doc = "file of the image, in any format that images are read in; in a scene file relative to it"},
    {VV_PROP(vv_volume_texture, mapping), .kind = VV_KIND_ENUM, .names = mappings, .def = VV_MAP_PLANAR,
     .doc = "of images: as a slide from -y, around the z axis, or as a globe"},
    {VV_PROP(vv_volume_texture, wrap), .kind = VV_KIND_ENUM, .names = wraps, .def = VV_WRAP_REPEAT,
     .doc = "of images: what lies beyond their borders"},
    {VV_PROP(vv_volume_texture, apply), .kind = VV_KIND_ENUM, .names = ways, .def = VV_APPLY_MODULATE,
     .doc = "modulate: the volume's colours times the texture's; replace: the texture's alone"},
    {VV_PROP(vv_volume_texture, strength), .kind = VV_KIND_F64, .quantity = VV_Q_RATIO, .limited = true, .min = 0,
     .max = 1, .def = 1, .doc = "how much of it there is; 0: none"},
    {VV_PROP(vv_volume_texture, color), .kind = VV_KIND_COLOR, .automatic = "by kind",
     .doc = "of patterns: of even cells, pale wood, stone between veins, least noise"},
    {VV_PROP(vv_volume_texture, second_color), .kind = VV_KIND_COLOR, .automatic = "by kind",
     .doc = "of patterns: of odd cells, dark rings, veins, most noise"},
    {VV_PROP(vv_volume_texture, frequency), .kind = VV_KIND_F64, .limited = true, .min = 1e-12, .max = 1e12, .def = 1,
     .unit = "per length", .automatic = "an image spans the volume's longest side; 8 cells, 10 rings, 4 veins along it",
     .doc = "images, cells, rings or veins in one length of the World, before the volume is placed"},
    {VV_PROP(vv_volume_texture, seed), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 4294967295.0,
     .doc = "of patterns: another number, another piece of wood"},
    {VV_PROP(vv_volume_texture, place), .kind = VV_KIND_OBJECT, .cls = &vvi_frame_class,
     .doc = "where it stands in the volume's own space, from the middle of the volume"},
    {0},
};
const vv_class vvi_volume_texture_class = {
    .name = "texture",
    .doc = "an image or a pattern on the colours of a volume, under its light; it moves with the volume",
    .size = sizeof(vv_volume_texture),
    .properties = texture,
};
