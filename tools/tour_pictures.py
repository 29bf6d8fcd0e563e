"""What `make run` shows: sections of pictures, each a name, a title, words about it and the words for `volvis render`."""
import collections
import os

FOLDER = os.environ.get("VOLVIS_TOUR_DATA", "/usr/share/mricron/templates")
HEAD, BRAIN, ATLAS = (f"{FOLDER}/{name}.nii.gz" for name in ("ch2", "ch2bet", "aal"))

Picture = collections.namedtuple("Picture", "name title about data words clear size")


def picture(name, title, about, data, *words, clear=False, size="640x640"):
    return Picture(name, title, about, data, list(words), clear, size)


SKIN = "0:0 35:0 60:0.12#d8a07e 110:0.35#f1d3b8 160:0.6#ffffff"
VEIL = "0:0 25:0 60:0.006#5577cc 90:0.02#e08a50 130:0.08#fff0d8"
TISSUE = "0:0 45:0 70:0.05#7a3b2e 95:0.15#c98a6a 125:0.45#f6e6cf"
LAYERS = "0:0 44:0 44:0.9#d8a07e 48:0.9#d8a07e 48:0 120:0 120:0.5#ffffff 140:0.5#ffffff 140:0"
SHADE = "0:0 35:0 60:0.02#d8a07e 110:0.04#f1d3b8 160:0.06#ffffff"
VIEW = ["--view", "35,15"]

SECTIONS = [
    (
        "Ways along a ray",
        "What a ray makes of the samples that it meets: light and shade in order, the first surface, or the largest value.",
        [
            picture("composite-shaded", "Composite, shaded", "Every sample absorbs and glows by its value, lit by the gradient.", HEAD, *VIEW, "--tf", SKIN),
            picture("composite-unshaded", "Composite, unshaded", "The same without lighting: colour and opacity alone.", HEAD, *VIEW, "--tf", VEIL, "--no-shading"),
            picture("maximum", "Maximum", "The largest value along each ray; no order, no light.", HEAD, *VIEW, "--mode", "maximum"),
            picture("minimum", "Minimum", "The smallest value along each ray through a block of the brain: what is hollow shows.", HEAD, *VIEW, "--mode", "minimum", "--clip", "x:-30..30", "--clip", "y:-50..30", "--clip", "z:-5..35", "--set", "views.main.camera.zoom=2.2"),
            picture("mean", "Mean", "The mean value along each ray, however long it is.", HEAD, *VIEW, "--mode", "mean"),
            picture("sum", "Sum", "The values added up, as film adds up X-rays: short ways are dark.", HEAD, *VIEW, "--mode", "sum"),
            picture("local-maximum", "Local maximum", "The first peak of each ray above 90: what lies before the brightest stays in sight.", HEAD, *VIEW, "--mode", "local-maximum", "--set", "views.main.render.raycast.threshold=90"),
            picture("isosurface-shaded", "Isosurface, shaded", "Where the value first passes 45: the skin.", HEAD, *VIEW, "--iso", "45"),
            picture("isosurface-unshaded", "Isosurface, unshaded", "The same surface without light is a silhouette.", HEAD, *VIEW, "--iso", "45", "--no-shading"),
            picture("threshold", "Threshold", "Values from 60 to 255 are solid, everything else is clear.", BRAIN, *VIEW, "--threshold", "60,255"),
            picture("stepped-over", "A thin layer, stepped over", "Only values from 44 to 48 and from 120 to 140 are opaque: most steps miss them.", HEAD, *VIEW, "--tf", LAYERS),
            picture("preintegrated", "The same, integrated", "Every value between two samples of a ray counts: the layers are whole at the same step.", HEAD, *VIEW, "--tf", LAYERS, "--set", "views.main.render.raycast.preintegrated=true"),
            picture("boundaries", "Boundaries alone", "Opacity fades where the gradient is short: flat tissue clears, its borders stay.", HEAD, *VIEW, "--tf", SKIN, "--set", "volumes.ch2.segmentation.transfer.gradient_power=1.5", "--set", "volumes.ch2.segmentation.transfer.opacity_scale=0.3"),
            picture("regions", "By value and gradient", "A two-dimensional transfer function: what is even inside is blue, what has steep borders is skin or white.", HEAD, *VIEW, "--set", 'volumes.ch2.segmentation.transfer.regions=[{"value_lo": 20, "value_hi": 90, "gradient_lo": 12, "color": "#d8a07e", "opacity": 0.05}, {"value_lo": 100, "value_hi": 160, "gradient_hi": 8, "color": "#60a0ff", "opacity": 0.3}, {"value_lo": 70, "value_hi": 130, "gradient_lo": 15, "opacity": 0.1}]'),
            picture("painted", "Coloured by other data", "The brain's shape and opacity, coloured by the regions of an atlas at the same place.", BRAIN, *VIEW, "--tf", "0:0 60:0 90:0.3 120:0.6", "--set", 'datasets.atlas={"path": "' + ATLAS + '"}', "--set", "volumes.ch2bet.data=ch2bet", "--set", 'volumes.ch2bet.paint={"data": "atlas", "colormap": "plasma"}'),
            picture("marble", "Carved in marble", "A pattern that fills space, on the skin: veins run through the head.", HEAD, *VIEW, "--iso", "45", "--set", "volumes.ch2.texture.kind=marble"),
            picture("wood", "Turned from wood", "Rings about a tilted axis; where the head is cut they go on inside.", HEAD, "--view", "35,30", "--iso", "45", "--clip", "plane(n=0,0,-1 d=-60mm)", "--set", 'volumes.ch2.texture={"kind": "wood", "place": {"rotation": [25, 10, 0]}}'),
            picture("checker", "A checker in a cloud", "The texture times the colours of the transfer function: both can be read.", HEAD, *VIEW, "--tf", SKIN, "--set", "volumes.ch2.texture.kind=checker"),
            picture("several-volumes", "Two volumes in one place", "The head, thin, and the brain that was cut out of it, in one picture: along a ray both absorb.", HEAD, *VIEW, "--tf", SHADE, "--set", 'datasets.brain={"path": "' + BRAIN + '"}', "--set", 'volumes.brain={"data": "brain", "segmentation": {"transfer": {"opacity": [[40, 0], [80, 0.3], [120, 0.6]], "color": [[40, 0.6, 0.2, 0.15], [120, 1, 0.75, 0.6]]}}}'),
            picture("mesh-in-cloud", "A mesh in a cloud", "The brain as triangles, made when they are needed, inside the head as a cloud: what lies before them dims them.", HEAD, *VIEW, "--tf", "ch2=" + SHADE, "--set", 'datasets.brain={"path": "' + BRAIN + '"}', "--set", 'datasets.cortex={"operation": "isosurface", "inputs": {"volume": "brain"}, "parameters": {"iso": [60]}}', "--set", "volumes.ch2.data=ch2", "--set", 'volumes.cortex={"data": "cortex", "color": "#d06a4a"}'),
            picture("labels", "Label map", "An atlas of the brain: every sample is the number of a region, each with a colour of its own.", ATLAS, *VIEW, "--set", "volumes.aal.segmentation.kind=labels"),
        ],
    ),
    (
        "Cameras and cuts",
        "Where one looks from, how lines run together, and what is cut away.",
        [
            picture("perspective", "Perspective", "A full vertical angle of 40 degrees: near things are larger.", HEAD, *VIEW, "--iso", "45", "--fov", "40deg"),
            picture("parallel", "Parallel", "No perspective: lengths can be measured in the picture.", HEAD, *VIEW, "--iso", "45", "--parallel", "260mm"),
            picture("cut-plane", "A cut plane", "Half of the head is cut away; the cut shows the values inside.", HEAD, "--view", "60,20", "--tf", TISSUE, "--clip", "plane(n=1,0,0 d=0mm)"),
            picture("cut-box", "Cut by coordinates", "A slab between two coordinates, front to back.", HEAD, "--view", "90,0", "--tf", TISSUE, "--clip", "x:-10mm..10mm"),
            picture("from-above", "From above", "The same data along another axis.", BRAIN, "--view", "top", "--iso", "60"),
        ],
    ),
    (
        "Triangles, and figures",
        "The three representations of the Navigator of 1994, and what a figure needs: directions, sizes, values, words.",
        [
            picture("surface", "Surface", "The triangles of Marching Cubes, drawn: the same picture as of rays.", HEAD, *VIEW, "--method", "surface", "--iso", "45", "--spp", "8", "--decorate", "cube,scale-bar,legend,box"),
            picture("reduced", "Reduced surface", "Four places an edge, and as many samples as 30000 triangles allow.", HEAD, *VIEW, "--method", "reduced", "--iso", "45", "--spp", "8", "--set", "views.main.render.reduced.triangles=30000", "--decorate", "cube,scale-bar,legend,box"),
            picture("boxes", "Boxes", "The outer faces of the boxes that hold the surface.", HEAD, *VIEW, "--method", "boxes", "--iso", "45", "--spp", "8", "--decorate", "cube,scale-bar,legend,box"),
            picture("surface-cut", "A surface, cut open", "Faces of cuts are exact, and their outlines can be shown.", BRAIN, "--view", "60,20", "--method", "surface", "--iso", "60", "--spp", "8", "--clip", "plane(n=1,0,0 d=0mm)", "--decorate", "cube,cut-planes,legend", "--background", "white"),
            picture("surface-labels", "Surfaces of labels", "Every region of an atlas as a smooth surface; neighbours share their borders.", ATLAS, *VIEW, "--method", "surface", "--spp", "8", "--set", "volumes.aal.segmentation.kind=labels", "--decorate", "cube,scale-bar"),
            picture("figure", "A figure", "Axes with round numbers, a title, and a caption that fills itself in.", HEAD, *VIEW, "--tf", SKIN, "--clip", "plane(n=1,0,0 d=0mm)", "--decorate", "all", "--title", "A head in MRI", "--caption", "{file}: {dims} voxels of {spacing}"),
            picture("figure-print", "For print", "The same on white, in parallel projection: the scale bar holds everywhere.", HEAD, *VIEW, "--tf", SKIN, "--parallel", "390mm", "--background", "white", "--decorate", "cube,scale-bar,legend,box", "--title", "A head in MRI"),
        ],
    ),
    (
        "Samples and steps",
        "How values between the samples are made.",
        [
            picture("trilinear", "Trilinear", "Values are interpolated between the eight samples around a point.", BRAIN, "--view", "20,10", "--iso", "60", "--set", "views.main.camera.zoom=4"),
            picture("nearest", "Nearest", "The nearest sample decides: voxels show as blocks.", BRAIN, "--view", "20,10", "--iso", "60", "--set", "views.main.camera.zoom=4", "--set", "volumes.ch2bet.interpolation=nearest"),
            picture("smooth-labels", "Labels with smooth borders", "Of the labels around a point the one with most weight: borders run between the voxels.", ATLAS, "--view", "35,15", "--set", "volumes.aal.segmentation.kind=labels", "--set", "volumes.aal.interpolation=linear", "--set", "volumes.aal.segmentation.labels.opacity=0.9", "--set", "views.main.camera.zoom=3"),
            picture("coarse-step", "A coarse step", "One sample every four voxels: opacity is per millimetre, so it stays what it is, but detail goes and rings appear.", HEAD, *VIEW, "--tf", SKIN, "--step", "4vox"),
            picture("quality-draft", "Quality: draft", "Steps of two voxels, and one ray for 16 pixels where little changes.", HEAD, *VIEW, "--tf", SKIN, "--quality", "draft", size="400x400"),
            picture("quality-normal", "Quality: normal", "Steps of one voxel, four rays a pixel, their samples shifted by chance.", HEAD, *VIEW, "--tf", SKIN, "--quality", "normal", size="400x400"),
            picture("quality-high", "Quality: high", "Steps of half a voxel, each integrated over its values; four rays a pixel.", HEAD, *VIEW, "--tf", SKIN, "--quality", "high", size="400x400"),
            picture("quality-reference", "Quality: reference", "Steps of an eighth of a voxel, 16 rays a pixel: what the others are measured against.", HEAD, *VIEW, "--tf", SKIN, "--quality", "reference", size="400x400"),
        ],
    ),
    (
        "Light",
        "Several lights, each with its kind, place and colour.",
        [
            picture("cinematic", "Shadows and ambient occlusion", "Furrows are dark and folds stand out: less light arrives where surroundings are close.", BRAIN, *VIEW, "--threshold", "60,255", "--lighting", "cinematic"),
            picture("two-lights", "Key and fill", "What one gets without asking: a key light and a weaker fill.", BRAIN, *VIEW, "--iso", "60"),
            picture("coloured-lights", "Three coloured lights", "A warm key, a blue fill, and a third light from below.", BRAIN, *VIEW, "--iso", "60", "--set", "lights.key.color=#ffb070", "--set", "lights.fill.color=#4070ff", "--set", "lights.fill.intensity=0.8", "--set", "lights.below={\"kind\": \"directional\", \"direction\": [0, 0, 1], \"color\": \"#30c060\"}"),
            picture("point-light", "A point light", "Close to the brain: it falls off with the distance.", BRAIN, *VIEW, "--iso", "60", "--set", "lights.fill.on=false", "--set", "lights.key={\"kind\": \"point\", \"frame\": \"world\", \"position\": [-70, 120, 60], \"falloff\": [0.2, 0, 0.0002]}"),
        ],
    ),
    (
        "Colour",
        "Presets, colour maps and backgrounds; none needs to be tuned before something is seen.",
        [
            picture("automatic", "Nothing said", "A transfer function fitted to the histogram, a camera that frames the head.", HEAD),
            picture("colormap-viridis", "Colour map: viridis", "A perceptually uniform map over the values.", BRAIN, *VIEW, "--tf", "viridis"),
            picture("colormap-magma", "Colour map: magma", "The maximum along each ray through a map.", HEAD, *VIEW, "--mode", "maximum", "--tf", "magma"),
            picture("transparent", "Transparent background", "The picture's alpha says how much light passes; the page's checks shine through.", HEAD, *VIEW, "--tf", VEIL, "--no-shading", "--background", "transparent", clear=True),
            picture("white", "White background", "For print.", BRAIN, *VIEW, "--iso", "60", "--background", "white"),
        ],
    ),
]
