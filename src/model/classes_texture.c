/* The table of textures: an image or a pattern on the colours of a volume. */
#include "model/classes.h"
#include <stddef.h>

static const char *const kinds[] = {"none", "image", "checker", "wood", "marble", "noise", NULL};
static const char *const mappings[] = {"planar", "cylindrical", "spherical", NULL};
static const char *const wraps[] = {"repeat", "mirror", "clamp", NULL};
static const char *const ways[] = {"modulate", "replace", NULL};

static const vv_property texture[] = {
    {VV_PROP(vv_volume_texture, kind), .kind = VV_KIND_ENUM, .names = kinds,
     .automatic = "image where a file is named, else none",
     .doc = "an image, or a pattern that fills space and so is seen on cut faces too"},
    {VV_PROP(vv_volume_texture, image), .kind = VV_KIND_PATH, .automatic = "none",
     .doc = "image file, in any image format that is read; in a scene file, relative to that file"},
    {VV_PROP(vv_volume_texture, mapping), .kind = VV_KIND_ENUM, .names = mappings, .def = VV_MAP_PLANAR,
     .doc = "for images: projected like a slide from -y, wrapped around the z axis, or as on a globe"},
    {VV_PROP(vv_volume_texture, wrap), .kind = VV_KIND_ENUM, .names = wraps, .def = VV_WRAP_REPEAT,
     .doc = "for images: what lies beyond their borders"},
    {VV_PROP(vv_volume_texture, apply), .kind = VV_KIND_ENUM, .names = ways, .def = VV_APPLY_MODULATE,
     .doc = "modulate: the volume's colours times the texture's; replace: the texture's only"},
    {VV_PROP(vv_volume_texture, strength), .kind = VV_KIND_F64, .quantity = VV_Q_RATIO, .limited = true, .min = 0,
     .max = 1, .def = 1, .doc = "strength of the texture; 0: none"},
    {VV_PROP(vv_volume_texture, color), .kind = VV_KIND_COLOR, .automatic = "by kind",
     .doc = "for patterns: of even cells, pale wood, stone between veins, least noise"},
    {VV_PROP(vv_volume_texture, second_color), .kind = VV_KIND_COLOR, .automatic = "by kind",
     .doc = "for patterns: of odd cells, dark rings, veins, most noise"},
    {VV_PROP(vv_volume_texture, frequency), .kind = VV_KIND_F64, .limited = true, .min = 1e-12, .max = 1e12, .def = 1,
     .unit = "per length",
     .automatic = "an image spans the volume's longest side; 8 cells, 10 rings or 4 veins along it",
     .doc = "images, cells, rings or veins per length of the World, before the volume is placed"},
    {VV_PROP(vv_volume_texture, seed), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 4294967295.0,
     .doc = "for patterns: another seed gives another piece of wood"},
    {VV_PROP(vv_volume_texture, place), .kind = VV_KIND_OBJECT, .cls = &vvi_placement_class,
     .doc = "position in the volume's own space, from the middle of the volume"},
    {0},
};
const vv_class vvi_volume_texture_class = {
    .name = "texture",
    .doc = "an image or a pattern on the colours of a volume, lit with it; it moves with the volume",
    .size = sizeof(vv_volume_texture),
    .properties = texture,
};
