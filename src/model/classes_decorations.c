/* The table of decorations: what is drawn over a picture, so that it tells place, size and values. */
#include "model/classes.h"
#include <stddef.h>

static const vv_property decorations[] = {
    {VV_PROP(vv_decorations, cube), .kind = VV_KIND_BOOL,
     .doc = "a small cube in a corner that shows the orientation of the World: R L A P S I for anatomical data, else x "
            "y z"},
    {VV_PROP(vv_decorations, axes), .kind = VV_KIND_BOOL,
     .doc = "coordinates along three edges of the box around everything that is shown"},
    {VV_PROP(vv_decorations, scale_bar), .kind = VV_KIND_BOOL,
     .doc = "a bar of a round length at the lower right; in perspective it holds at the depth of the middle of the "
            "data, and says so"},
    {VV_PROP(vv_decorations, box), .kind = VV_KIND_BOOL,
     .doc = "the edges of every volume, hidden by what is in front of them; over projections, except for edges at the "
            "back"},
    {VV_PROP(vv_decorations, cut_planes), .kind = VV_KIND_BOOL,
     .doc = "where cut planes intersect the box of a volume"},
    {VV_PROP(vv_decorations, legend), .kind = VV_KIND_BOOL,
     .doc = "colour and opacity by value for every volume, the names or numbers of labels, or the values of surfaces"},
    {VV_PROP(vv_decorations, sides), .kind = VV_KIND_BOOL,
     .doc = "letters at the borders that name the directions: R L A P S I for anatomical data, else x y z; only for "
            "directions that lie almost in the image plane"},
    {VV_PROP(vv_decorations, cross_hair), .kind = VV_KIND_BOOL,
     .doc = "thin lines through the World's cross-hair, where the slices meet"},
    {VV_PROP(vv_decorations, measurements), .kind = VV_KIND_BOOL, .def = 1,
     .doc = "the World's measurements where they are: points, lines, boxes and what came out; in a slice those in it"},
    {VV_PROP(vv_decorations, title), VVI_LINE, .automatic = "none",
     .doc = "a line at the upper left; placeholders as in caption"},
    {VV_PROP(vv_decorations, caption), VVI_TEXT(4096), .automatic = "none",
     .doc = "text below the title, wrapped; {file} {title} {dims} {spacing} {unit} {range} {method} {iso} {view} "
            "{azimuth} {elevation} {version} are replaced by what they name; {{ gives a brace"},
    {VV_PROP(vv_decorations, color), .kind = VV_KIND_COLOR,
     .automatic = "white on dark backgrounds, black on bright ones", .doc = "of lines and letters"},
    {VV_PROP(vv_decorations, size), .kind = VV_KIND_F64, .limited = true, .min = 0.1, .max = 10, .def = 1,
     .doc = "factor applied to letters and lines, which scale with the shorter side of the image; letters have at "
            "least 6 pixels"},
    {VV_PROP(vv_decorations, font), .kind = VV_KIND_PATH, .automatic = "Liberation Sans or a similar font",
     .doc = "font file (.ttf, .otf); in a scene file, relative to that file"},
    {0},
};
const vv_class vvi_decorations_class = {
    .name = "decorations",
    .doc = "what is drawn on top of the image: directions, sizes, values, text",
    .size = sizeof(vv_decorations),
    .properties = decorations,
};
