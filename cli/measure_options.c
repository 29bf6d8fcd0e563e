/* The options of measure. */
#include "measure.h"
#include <stddef.h>

static const char *const methods[] = {"auto", "cubes", "count", NULL};
static const char *const spaces[] = {"index", "world", NULL};

static const vv_property rows[] = {
    {VV_PROP(cli_measure_options, iso), .kind = VV_KIND_STRING, .unit = "VALUE",
     .automatic = "the value that best splits the histogram in two; for labels, all but 0",
     .doc = "the object is where samples have this value or more"},
    {VV_PROP(cli_measure_options, other_iso), .kind = VV_KIND_STRING, .unit = "VALUE", .automatic = "as --iso",
     .doc = "for the distance between two surfaces: the value of the second one"},
    {VV_PROP(cli_measure_options, other_label), .kind = VV_KIND_STRING, .unit = "N|NAME", .automatic = "as --label",
     .doc = "for the distance between two surfaces: the label of the second one"},
    {VV_PROP(cli_measure_options, threshold), .kind = VV_KIND_STRING, .unit = "LO..HI", .automatic = "as --iso",
     .doc = "the object has values from LO to HI; either may be omitted: 90.. and 90 are 90 and more"},
    {VV_PROP(cli_measure_options, label), .kind = VV_KIND_STRING, .unit = "N|NAME", .automatic = "as --iso",
     .doc = "the object is what has this label, by number or as the file calls it"},
    {VV_PROP(cli_measure_options, mask), .kind = VV_KIND_PATH, .unit = "FILE", .automatic = "as --iso",
     .doc = "the object is where this volume is not 0; its samples must be at the same positions as those of INPUT, "
            "and may "
            "be of a part"},
    {VV_PROP(cli_measure_options, seed), .kind = VV_KIND_STRING, .unit = "X,Y,Z", .automatic = "all of the object",
     .doc = "only the piece around this place: its voxels share faces"},
    {VV_PROP(cli_measure_options, box), .kind = VV_KIND_STRING, .unit = "X0..X1,Y0..Y1,Z0..Z1",
     .automatic = "everything",
     .doc = "only samples inside a box, as in 10..59,..,5..19: the first and the last sample along each axis, or .. "
            "for all of them"},
    {VV_PROP(cli_measure_options, clip), .kind = VV_KIND_LIST, .cls = &cli_word_class, .unit = "CLIP",
     .doc = "only the part that x:10mm..60mm or 'plane(n=1,0,1 d=20mm)' keeps, as in 'volvis help render'; may be "
            "repeated; cut planes of a scene apply too"},
    {VV_PROP(cli_measure_options, method), .kind = VV_KIND_ENUM, .names = methods,
     .doc = "for areas and volumes: cubes interpolates values (Marching Cubes), count counts voxels; auto counts "
            "labels and masks"},
    {VV_PROP(cli_measure_options, closed), .kind = VV_KIND_BOOL,
     .doc = "the area includes the faces where the object is cut off"},
    {VV_PROP(cli_measure_options, component), .option = "channel", .kind = VV_KIND_STRING, .unit = "N|NAME",
     .automatic = "0",
     .doc = "channel, by number from 0 or by name; for a vector or colour, which of its numbers: 1, y or green"},
    {VV_PROP(cli_measure_options, point), .kind = VV_KIND_LIST, .cls = &cli_word_class, .unit = "X,Y,Z",
     .doc =
         "a place: of a distance (two, or more for the length from each to the next), an angle (three), a profile or a "
         "path along a surface (two), or alone"},
    {VV_PROP(cli_measure_options, space), .kind = VV_KIND_ENUM, .names = spaces,
     .doc = "coordinates of points: sample indices, or lengths in the world"},
    {VV_PROP(cli_measure_options, samples), .kind = VV_KIND_I64, .limited = true, .min = 2, .max = 1e6, .def = 2,
     .automatic = "two per voxel", .doc = "for a profile: the number of values"},
    {VV_PROP(cli_measure_options, bins), .kind = VV_KIND_I64, .limited = true, .min = 2, .max = 65536, .def = 2,
     .automatic = "at most 1024; whole numbers one or equally many each", .doc = "of a histogram"},
    {VV_PROP(cli_measure_options, range), .kind = VV_KIND_STRING, .unit = "LO..HI",
     .automatic = "from the smallest to the largest value",
     .doc = "for a histogram: from the start of its first bin to the end of its last"},
    {VV_PROP(cli_measure_options, log), .kind = VV_KIND_BOOL,
     .doc = "for a histogram's bars and plot: counts on a logarithmic scale"},
    {VV_PROP(cli_measure_options, values), .kind = VV_KIND_PATH, .unit = "FILE", .automatic = "the labels alone",
     .doc = "for labels: a volume with samples at the same positions; its values are reported for each label"},
    {VV_PROP(cli_measure_options, input_unit), .kind = VV_KIND_STRING, .unit = "UNIT", .automatic = "none",
     .doc = "unit of lengths in a mesh file that gives none, or counts voxels: mm, or 0.5mm for each"},
    {VV_PROP(cli_measure_options, store), .kind = VV_KIND_STRING, .unit = "[SCENE.vv.json:]NAME",
     .automatic = "not kept",
     .doc = "store the measurement and its results in a scene, under this name: in the scene that is measured, or in "
            "SCENE.vv.json, which is created if it does not exist"},
    {VV_PROP(cli_measure_options, update), .kind = VV_KIND_BOOL,
     .doc = "for stored measurements: store the new results"},
    {VV_PROP(cli_measure_options, csv), .kind = VV_KIND_BOOL, .doc = "the result as a table of comma-separated values"},
    {0},
};

const vv_class cli_measure_class = {
    .name = "measure",
    .doc = "options of measure",
    .size = sizeof(cli_measure_options),
    .properties = rows,
};
