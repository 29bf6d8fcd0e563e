"""The cases of the ray casting benchmark, the same for VolVis and for the programs beside it.

One case is a volume of bench/volumes.c, a mode and a step in voxels. The camera looks at the middle of the volume from
a distance of R / sin(15 deg), R the half diagonal, with a full field of view of 20 degrees, turned by an azimuth of 30
and an elevation of 20 degrees from +z with +y up. Pictures have 1024 x 1024 pixels. Lengths are voxels.
"""
import collections
import math

Case = collections.namedtuple("Case", "kind n mode shaded step")

SIZE = 1024
FOV_DEG = 20.0
AZIMUTH_DEG, ELEVATION_DEG = 30.0, 20.0
# ambient, diffuse, specular, shininess of the shaded cases; the light comes from the camera
SHADING = (0.1, 0.7, 0.2, 10.0)

# (value, r, g, b) as a screen shows them, and (value, opacity of one voxel)
BONE = (
    ((0, 0, 0, 0), (140, 0.8, 0.5, 0.3), (200, 1, 0.95, 0.85), (255, 1, 1, 1)),
    ((0, 0), (140, 0), (180, 0.5), (255, 0.9)),
)
FOG = (
    ((0, 0, 0, 0), (60, 0.2, 0.3, 0.9), (110, 0.9, 0.5, 0.2), (200, 1, 1, 0.9), (255, 1, 1, 1)),
    ((0, 0), (15, 0), (60, 0.004), (110, 0.008), (255, 0.03)),
)
# What quality would choose is written out, here and for every scene of a benchmark: one plain ray a pixel, as the others have
CAST = {
    "samples": 1,
    "adaptive": False,
    "raycast": {
        "opaque": 1 / 512,
        "gradient": "central",
        "jitter": False,
        "halvings": 0,
        "preintegrated": False,
        "shadows": False,
        "ambient_occlusion": False,
    },
}
GREY = (((0, 0, 0, 0), (255, 1, 1, 1)), ((0, 0), (255, 1)))
# one colour, and an edge between two values: for bench/beside
TAN = (0.88, 0.69, 0.5)
EDGE = (((0, *TAN), (255, *TAN)), ((0, 0), (127, 0), (128, 0.98), (255, 0.98)))
TRANSFER = {"bone": BONE, "fog": FOG, "mip": GREY, "edge": EDGE}


def name(case):
    return f"{case.kind}_{case.n}:{case.mode}{'-shaded' if case.shaded else ''}:{case.step:g}"


def cases(which):
    """quick: 256, step 1; full: 256 and 512, steps 1 and 0.5; else: those whose name holds one of the words."""
    modes = (("bone", False), ("bone", True), ("fog", False), ("fog", True), ("mip", False))
    every = [Case("head", n, mode, shaded, step) for n in (256, 512) for mode, shaded in modes for step in (1.0, 0.5)]
    if which == "full":
        return every
    if which == "quick":
        return [case for case in every if case.n == 256 and case.step == 1.0]
    return [case for case in every if any(word in name(case) for word in which.split(","))]


def camera(n):
    """(eye, at, up) for a volume of n^3 voxels."""
    middle = (n - 1) / 2
    distance = middle * math.sqrt(3) / math.sin(math.radians(15))
    azimuth, elevation = math.radians(AZIMUTH_DEG), math.radians(ELEVATION_DEG)
    towards = (
        math.sin(azimuth) * math.cos(elevation),
        math.sin(elevation),
        math.cos(azimuth) * math.cos(elevation),
    )
    return tuple(middle + distance * t for t in towards), (middle,) * 3, (0.0, 1.0, 0.0)


def linear(encoded):
    """The sRGB curve backwards: what a screen shows to light."""
    return encoded / 12.92 if encoded <= 0.04045 else ((encoded + 0.055) / 1.055) ** 2.4


def scene(case, path):
    """The case as a scene of VolVis on the data file `path` (relative to the scene)."""
    color, opacity = TRANSFER[case.mode]
    ambient, diffuse, specular, shininess = SHADING
    eye, at, up = camera(case.n)
    return {
        "schema": 1,
        "background": [0, 0, 0, 1],
        "datasets": {"data": {"kind": "regular", "path": path}},
        "volumes": {
            "data": {
                "data": "data",
                "segmentation": {
                    "kind": "transfer",
                    "transfer": {
                        "opacity": [list(row) for row in opacity],
                        "color": [[row[0]] + [linear(part) for part in row[1:]] for row in color],
                        "opacity_length": 1,
                    },
                },
                "shading": {
                    "model": "phong" if case.shaded else "none",
                    "ambient": ambient,
                    "diffuse": diffuse,
                    "specular": specular,
                    "shininess": shininess,
                    "two_sided": True,
                },
            }
        },
        "lights": {"head": {"kind": "directional", "frame": "camera", "direction": [0, 0, -1]}},
        "views": {
            "main": {
                "width": SIZE,
                "height": SIZE,
                "camera": {"eye": list(eye), "at": list(at), "up": list(up), "fov": FOV_DEG},
                "render": {
                    **CAST,
                    "method": "raycast",
                    "raycast": {**CAST["raycast"], "mode": "maximum" if case.mode == "mip" else "composite", "step": case.step},
                },
            }
        },
    }
