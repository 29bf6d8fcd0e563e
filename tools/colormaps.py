#!/usr/bin/env python3
"""Makes src/scene/colormap_knots.h: perceptually uniform colour maps from a few control colours.

Each map is a smooth curve through its control colours in Oklab (Ottosson 2020), run through at constant speed as
CAM02-UCS measures it (Luo, Cui, Li 2006; sRGB viewing conditions), and stored as equally spaced Oklab knots. Turbo is
its published formula.
Usage: tools/colormaps.py > src/scene/colormap_knots.h
"""
import math

KNOTS = 65
FINE = 4096

# name, one line of doc, control colours (sRGB) from low to high
MAPS = [
    ("viridis", "dark violet over green to yellow", "#440154 #3b528b #21918c #5ec962 #fde725"),
    ("magma", "black over purple and salmon to cream", "#000004 #51127c #b73779 #fc8961 #fcfdbf"),
    ("inferno", "black over purple and orange to pale yellow", "#000004 #57106e #bc3754 #f98e09 #fcffa4"),
    ("plasma", "blue over magenta and orange to yellow", "#0d0887 #7e03a8 #cc4778 #f89540 #f0f921"),
    ("cividis", "blue to yellow, the same to people who see red as green", "#0a0a4f #3a3a70 #787878 #b4b463 #f4f43c"),
    ("gray", "black to white", "#000000 #ffffff"),
    ("bone", "black to white with a cool tinge, as of an X-ray film", "#000000 #3e3e56 #7c8c9c #b6c6c9 #ffffff"),
    ("hot", "glowing iron: black over red and yellow to white", "#000000 #7d0b00 #e34a00 #ffb52a #ffffff"),
    ("ice", "deep blue over cyan to white", "#03051a #2b3a7c #3f7fb4 #82c4cf #f2fdfd"),
    ("tissue", "dark red over skin to ivory", "#2a0608 #7a2a22 #c0705a #e8b694 #fff6e4"),
    ("coolwarm", "blue over light gray to red, for values about a middle", "#3b4cc0 #8aaef0 #dddddd #ee9678 #b40426"),
    ("turbo", "a rainbow of smooth lightness, for many shades; not uniform", None),
]

# Turbo (Mikhailov 2019): the published polynomials of sRGB in the place, from the constant term up
TURBO = [(0.13572138, 4.61539260, -42.66032258, 132.13108234, -152.94239396, 59.28637943),
         (0.09140261, 2.19418839, 4.84296658, -14.18503333, 4.27729857, 2.82956604),
         (0.10667330, 12.64194608, -60.58204836, 110.36276771, -89.90310912, 27.34824973)]

ALIASES = {"gray": "grey"}  # other spellings, which are read and not listed


def decode(v):
    return v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4


def linear_of(text):
    return [decode(int(text[i:i + 2], 16) / 255) for i in (1, 3, 5)]


def times(m, v):
    return [sum(a * b for a, b in zip(row, v)) for row in m]


TO_LMS = [(0.4122214708, 0.5363325363, 0.0514459929), (0.2119034982, 0.6806995451, 0.1073969566),
          (0.0883024619, 0.2817188376, 0.6299787005)]
TO_LAB = [(0.2104542553, 0.7936177850, -0.0040720468), (1.9779984951, -2.4285922050, 0.4505937099),
          (0.0259040371, 0.7827717662, -0.8086757660)]
FROM_LAB = [(1, 0.3963377774, 0.2158037573), (1, -0.1055613458, -0.0638541728), (1, -0.0894841775, -1.2914855480)]
FROM_LMS = [(4.0767416621, -3.3077115913, 0.2309699292), (-1.2684380046, 2.6097574011, -0.3413193965),
            (-0.0041960863, -0.7034186147, 1.7076147010)]


def oklab(rgb):
    return times(TO_LAB, [max(v, 0) ** (1 / 3) for v in times(TO_LMS, rgb)])


def linear(lab):
    return [min(max(v, 0), 1) for v in times(FROM_LMS, [v ** 3 for v in times(FROM_LAB, lab)])]


TO_XYZ = [(0.4124, 0.3576, 0.1805), (0.2126, 0.7152, 0.0722), (0.0193, 0.1192, 0.9505)]
CAT02 = [(0.7328, 0.4296, -0.1624), (-0.7036, 1.6975, 0.0061), (0.0030, 0.0136, 0.9834)]
HPE = [(0.38971, 0.68898, -0.07868), (-0.22981, 1.18340, 0.04641), (0, 0, 1)]
FROM_CAT02 = [(1.096124, -0.278869, 0.182745), (0.454369, 0.473533, 0.072098), (-0.009628, -0.005698, 1.015326)]


class Cam02:
    """CIECAM02 and its uniform space for an sRGB display: white D65, 64 lux, gray background of 20 %."""

    def __init__(self):
        la, self.c, self.nc, f, yb = 64 / math.pi / 5, 0.69, 1.0, 1.0, 20.0
        k = 1 / (5 * la + 1)
        self.fl = 0.2 * k ** 4 * 5 * la + 0.1 * (1 - k ** 4) ** 2 * (5 * la) ** (1 / 3)
        white = times(CAT02, [100 * v for v in times(TO_XYZ, [1, 1, 1])])
        d = f * (1 - math.exp((-la - 42) / 92) / 3.6)
        self.adapt = [100 * d / w + 1 - d for w in white]
        self.n = yb / 100
        self.nbb = 0.725 * (1 / self.n) ** 0.2
        self.z = 1.48 + math.sqrt(self.n)
        self.aw = self.achromatic(self.cones([1, 1, 1]))

    def cones(self, rgb):
        lms = times(CAT02, [100 * v for v in times(TO_XYZ, rgb)])
        hpe = times(HPE, times(FROM_CAT02, [a * v for a, v in zip(self.adapt, lms)]))
        t = [(self.fl * abs(v) / 100) ** 0.42 for v in hpe]
        return [math.copysign(400 * v / (v + 27.13), h) + 0.1 for v, h in zip(t, hpe)]

    def achromatic(self, r):
        return (2 * r[0] + r[1] + r[2] / 20 - 0.305) * self.nbb

    def ucs(self, rgb):
        r = self.cones(rgb)
        a = r[0] - 12 * r[1] / 11 + r[2] / 11
        b = (r[0] + r[1] - 2 * r[2]) / 9
        h = math.atan2(b, a)
        j = 100 * (max(self.achromatic(r), 0) / self.aw) ** (self.c * self.z)
        e = (math.cos(h + 2) + 3.8) / 4
        t = 50000 / 13 * self.nc * self.nbb * e * math.hypot(a, b) / (r[0] + r[1] + 21 * r[2] / 20)
        m = t ** 0.9 * math.sqrt(j / 100) * (1.64 - 0.29 ** self.n) ** 0.73 * self.fl ** 0.25
        mp = math.log1p(0.0228 * m) / 0.0228
        return [1.7 * j / (1 + 0.007 * j), mp * math.cos(h), mp * math.sin(h)]


def spline(points, s):
    """Catmull-Rom through points at whole s, ends extended straight."""
    ext = [[2 * a - b for a, b in zip(points[0], points[1])]] + points
    ext += [[2 * a - b for a, b in zip(points[-1], points[-2])]]
    i = min(int(s), len(points) - 2)
    t = s - i
    p = ext[i:i + 4]
    return [0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t + (3 * b - a - 3 * c + d) * t ** 3)
            for a, b, c, d in zip(*p)]


def turbo(at):
    return [decode(min(max(sum(c * at ** i for i, c in enumerate(row)), 0), 1)) for row in TURBO]


def knots(text):
    if text is None:
        return [oklab(turbo(k / (KNOTS - 1))) for k in range(KNOTS)]
    points = [oklab(linear_of(c)) for c in text.split()]
    curve = [linear(spline(points, (len(points) - 1) * i / FINE)) for i in range(FINE + 1)]
    cam = Cam02()
    ucs = [cam.ucs(c) for c in curve]
    length = [0.0]
    for a, b in zip(ucs, ucs[1:]):
        length.append(length[-1] + math.dist(a, b))
    out, i = [], 0
    for k in range(KNOTS):
        want = length[-1] * k / (KNOTS - 1)
        while i < FINE - 1 and length[i + 1] < want:
            i += 1
        t = (want - length[i]) / (length[i + 1] - length[i])
        out.append(oklab([a + t * (b - a) for a, b in zip(curve[i], curve[i + 1])]))
    return out


def main():
    print("/* Made by tools/colormaps.py; change the control colours there. */")
    print(f"#define COLORMAP_KNOTS {KNOTS}\n")
    print("static const struct colormap {\n    vv_preset row;\n    float lab[COLORMAP_KNOTS][3];\n} colormaps[] = {")
    for name, doc, text in MAPS:
        alias = f', "{ALIASES[name]}"' if name in ALIASES else ""
        print(f'    {{{{"{name}", "{doc}", "colormap", NULL{alias}}},\n     {{')
        for lab in knots(text):
            print("         {%.5ff, %.5ff, %.5ff}," % tuple(v + 0.0 for v in lab))
        print("     }},")
    print("};")


main()
