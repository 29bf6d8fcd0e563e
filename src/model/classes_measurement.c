/* The table of measurements: what was asked, so that it can be asked again, and what came out. */
#include "model/classes.h"
#include <stddef.h>

#define MOST 1e308

static const vv_property figure[] = {
    {VV_PROP(vv_measured_figure, name), VVI_LINE, .doc = "which one, as named in the JSON of 'volvis measure'"},
    {VV_PROP(vv_measured_figure, value), .kind = VV_KIND_F64, .automatic = "none: there is nothing to measure",
     .doc = "what was measured"},
    {VV_PROP(vv_measured_figure, error), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = MOST,
     .automatic = "not known", .doc = "its error"},
    {VV_PROP(vv_measured_figure, unit), VVI_WORD, .doc = "of value and error"},
    {VV_PROP(vv_measured_figure, path), .kind = VV_KIND_NUMBERS, .columns = 3,
     .doc = "of a length along a surface: the path, in the measurement's space, thinned to what pictures show"},
    {0},
};
const vv_class vvi_measured_figure_class = {
    .name = "figure",
    .doc = "one number from a measurement",
    .size = sizeof(vv_measured_figure),
    .properties = figure,
};

static const char *const region_kinds[] = {"none", "box", "ellipse", "polygon", "ellipsoid", NULL};
static const char *const region_aliases[] = {"rectangle", "box",     "oval",   "ellipse",   "circle", "ellipse",
                                             "freehand",  "polygon", "sphere", "ellipsoid", NULL};

/* Also options of `volvis measure`. */
static const vv_property region[] = {
    {VV_PROP(vv_measured_region, kind), .kind = VV_KIND_ENUM, .option = "region", .names = region_kinds,
     .aliases = region_aliases,
     .doc = "only samples whose centres are in this: ellipse and polygon as thick as a slice, or as is said; a box as "
            "thin as that is a rectangle"},
    {VV_PROP(vv_measured_region, center), .kind = VV_KIND_VEC3, .automatic = "needed",
     .when = "kind=box|ellipse|ellipsoid", .doc = "the middle of the region, in --space as all places"},
    {VV_PROP(vv_measured_region, size), .kind = VV_KIND_VEC3, .automatic = "needed",
     .when = "kind=box|ellipse|ellipsoid",
     .doc = "the whole extents of the region along --right, upwards and along --normal; the last 0 is one slice"},
    {VV_PROP(vv_measured_region, normal), .kind = VV_KIND_VEC3, .when = "kind=box|ellipse|polygon|ellipsoid",
     .automatic = "z; of a polygon that of its outline", .doc = "across the plane of the region"},
    {VV_PROP(vv_measured_region, right), .kind = VV_KIND_VEC3, .when = "kind=box|ellipse|ellipsoid",
     .automatic = "x, or the axis that lies best in its plane", .doc = "along the first extent of the region"},
    {VV_PROP(vv_measured_region, outline), .kind = VV_KIND_NUMBERS, .columns = 3, .option = "vertex",
     .when = "kind=polygon", .automatic = "needed",
     .doc = "a corner of the polygon, in order; the last one and the first are joined"},
    {VV_PROP(vv_measured_region, thickness), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = MOST,
     .automatic = "one slice", .when = "kind=polygon", .doc = "of the polygon, along --normal"},
    {0},
};
const vv_class vvi_measured_region_class = {
    .name = "region",
    .doc = "where something is measured",
    .size = sizeof(vv_measured_region),
    .properties = region,
};

static const char *const kinds[] = {"summary",  "area",  "volume", "box",      "statistics", "histogram", "profile",
                                    "distance", "angle", "labels", "geodesic", "joint",      "point",     NULL};
static const char *const methods[] = {"auto", "cubes", "count", NULL};
static const char *const spaces[] = {"index", "world", NULL};

/* Also the options of `volvis measure`; files and figures are none. */
static const vv_property measurement[] = {
    {VV_PROP(vv_measurement, title), VVI_LINE, .option = "", .doc = "free text"},
    {VV_PROP(vv_measurement, what), .kind = VV_KIND_ENUM, .option = "", .names = kinds, .doc = "what is measured"},
    {VV_PROP(vv_measurement, file), .kind = VV_KIND_PATH, .option = "",
     .automatic = "the first visible volume of the scene",
     .doc = "a volume or mesh file; in a scene file, relative to that file"},
    {VV_PROP(vv_measurement, other), .kind = VV_KIND_PATH, .option = "", .automatic = "none",
     .doc = "for distances: the second surface's file, a mesh or a volume"},
    {VV_PROP(vv_measurement, iso), .kind = VV_KIND_F64, .unit = "value",
     .automatic = "the scene's threshold, else the value that best splits the histogram in two; for labels, all but 0",
     .doc = "the object is where samples have this value or more"},
    {VV_PROP(vv_measurement, other_iso), .kind = VV_KIND_F64, .unit = "value", .automatic = "as iso",
     .doc = "for the distance between two surfaces: the value of the second one"},
    {VV_PROP(vv_measurement, threshold_lo), .kind = VV_KIND_F64, .unit = "value", .option = "threshold", .ranged = true,
     .automatic = "no limit, or as iso", .doc = "smallest value of the object"},
    {VV_PROP(vv_measurement, threshold_hi), .kind = VV_KIND_F64, .unit = "value", .option = "",
     .automatic = "no limit, or as iso", .doc = "largest value of the object"},
    {VV_PROP(vv_measurement, label), .kind = VV_KIND_I64, .quantity = VV_Q_LABEL, .automatic = "as iso",
     .doc = "the object is what has this label"},
    {VV_PROP(vv_measurement, other_label), .kind = VV_KIND_I64, .quantity = VV_Q_LABEL, .automatic = "as label",
     .doc = "for the distance between two surfaces: the label of the second one"},
    {VV_PROP(vv_measurement, mask), .kind = VV_KIND_PATH, .automatic = "as iso",
     .doc = "the object is where this volume is not 0; its samples must be at the same positions as those that are "
            "measured, and may be of a part"},
    {VV_PROP(vv_measurement, seed), .kind = VV_KIND_VEC3, .automatic = "all of the object",
     .doc = "only the piece around this place: its voxels share faces"},
    {VV_PROP(vv_measurement, points), .kind = VV_KIND_NUMBERS, .columns = 3, .option = "point",
     .doc =
         "a place: of a distance (two, or more for the length from each to the next), an angle (three), a profile or a "
         "path along a surface (two), or alone"},
    {VV_PROP(vv_measurement, space), .kind = VV_KIND_ENUM, .names = spaces,
     .doc = "coordinates of places: sample indices, or lengths in the world"},
    {VV_PROP(vv_measurement, box), VVI_WORD, .unit = "X0..X1,Y0..Y1,Z0..Z1", .automatic = "everything",
     .doc = "only samples inside a box, as in 10..59,..,5..19: the first and the last sample along each axis, or .. "
            "for all of them"},
    {VV_PROP(vv_measurement, cut_planes), .kind = VV_KIND_LIST, .cls = &vv_cut_plane_class, .option = "",
     .doc = "cut planes in world space, in addition to those of the scene"},
    {VV_PROP(vv_measurement, component), .kind = VV_KIND_I64, .option = "channel", .limited = true, .min = 0,
     .max = 1e6, .automatic = "the volume's",
     .doc = "which channel, from 0; for a vector or colour, which of its numbers: 1 is y, or green"},
    {VV_PROP(vv_measurement, method), .kind = VV_KIND_ENUM, .names = methods,
     .doc = "for areas and volumes: cubes interpolates values (Marching Cubes), count counts voxels; auto counts "
            "labels and masks"},
    {VV_PROP(vv_measurement, closed), .kind = VV_KIND_BOOL,
     .doc = "the area includes the faces where the object is cut off"},
    {VV_PROP(vv_measurement, bins), .kind = VV_KIND_I64, .limited = true, .min = 2, .max = 65536, .def = 2,
     .automatic = "at most 1024; whole numbers one or equally many each", .doc = "for a histogram: the number of bins"},
    {VV_PROP(vv_measurement, samples), .kind = VV_KIND_I64, .limited = true, .min = 2, .max = 1e6, .def = 2,
     .automatic = "two per voxel", .doc = "for a profile: the number of values"},
    {VV_PROP(vv_measurement, range), .kind = VV_KIND_NUMBERS, .columns = 2, .lone = true,
     .automatic = "from the smallest to the largest value",
     .doc = "for a histogram: from the start of its first bin to the end of its last"},
    {VV_PROP(vv_measurement, values), .kind = VV_KIND_PATH, .automatic = "the labels alone",
     .doc = "for labels: a volume with samples at the same positions; its values are reported for each label"},
    {VV_PROP(vv_measurement, input_unit), VVI_WORD, .unit = "UNIT", .automatic = "none",
     .doc = "unit of lengths in a mesh file that gives none, or counts voxels: mm, or 0.5mm for each"},
    {VV_PROP(vv_measurement, figures), .kind = VV_KIND_LIST, .cls = &vvi_measured_figure_class, .option = "",
     .doc = "the results of the last measurement"},
    {VV_PROP(vv_measurement, volume), .kind = VV_KIND_REF, .ref_to = "volumes", .option = "",
     .automatic = "the first visible volume of the scene",
     .doc = "which volume of the scene, where it is not of a file"},
    {VV_PROP(vv_measurement, visible), .kind = VV_KIND_BOOL, .option = "", .def = 1,
     .doc = "pictures whose decorations include measurements show it where it is"},
    {VV_PROP(vv_measurement, region), .kind = VV_KIND_OBJECT, .cls = &vvi_measured_region_class, .option = "",
     .doc = "only samples whose centres are in a region"},
    {0},
};
const vv_class vvi_measurement_class = {
    .name = "measurement",
    .doc = "what was measured, how, and the results",
    .size = sizeof(vv_measurement),
    .properties = measurement,
};
