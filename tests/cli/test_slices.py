"""Slices from outside: short forms, scenes, and pixels that a formula tells."""
import json
import math
import struct
from PIL import Image
from harness import fails, main, ok, png_pixels, says, write_ball, write_nrrd

SMALL = ["--size", "64x48"]


def write_ramp(path="ramp.nrrd"):
    """Values 2 x + 3 y + 5 z on 9 x 7 x 5 samples, 2, 1 and 3 mm apart."""
    write_nrrd(path, (9, 7, 5), lambda x, y, z: 2 * x + 3 * y + 5 * z, spacing=(2, 1, 3))


def contents(path):
    with open(path, "rb") as file:
        return file.read()


def test_a_slice_is_a_picture_that_repeats_itself():
    write_ball(spacing=(1, 1, 1.5))
    for extra in (["--slice", "axial"], ["--slice", "coronal", "--window", "10,200"], ["--method", "slice"],
                  ["--slice", "sagittal", "--cross-hair", "1cm,12mm,7", "--decorate", "sides,cross-hair,scale-bar,legend"],
                  ["--slice", "camera", "--view", "30,20", "--parallel", "60mm"], ["--slice", "axial", "--spp", "4"]):
        ok("render", "head.nrrd", "-o", "a.png", *SMALL, *extra)
        ok("render", "a.png", "-o", "b.png", "--overwrite")
        assert contents("a.png") == contents("b.png"), extra


def test_what_lies_below_the_window_of_an_overlay_is_clear():
    write_nrrd("under.nrrd", (8, 8, 8), lambda x, y, z: 100)
    write_nrrd("over.nrrd", (8, 8, 8), lambda x, y, z: 200 if x < 4 else 3)
    small = ["--size", "8x8", "--slice", "axial", "--overwrite", "-o", "a.pfm", "--set", "views.main.camera.height=7"]
    ok("render", "under.nrrd", "over.nrrd", *small, "--window", "under=0..200", "--tf", "over=hot", "--window", "over=50..200")
    both = open("a.pfm", "rb").read()
    ok("render", "under.nrrd", *small, "--window", "0..200")
    alone = open("a.pfm", "rb").read()
    pixels = [[data[-8 * 8 * 12 :][i * 12 : i * 12 + 12] for i in range(64)] for data in (both, alone)]
    same = [a == b for a, b in zip(*pixels)]
    assert all(same[8 * y + x] == (x < 4) for y in range(8) for x in range(8)), same  # x runs to the left


def test_an_overlay_is_the_same_picture_again():
    """Its window is worked out, with values below it: they are not clear in the picture's scene either."""
    write_nrrd("under.nrrd", (8, 8, 8), lambda x, y, z: 100 + x)
    write_nrrd("over.nrrd", (20, 20, 20), lambda x, y, z: 1 if 8 < x < 12 and 8 < y < 12 and z == 10 else 100 + x + 3 * y)
    for extra in ([], ["--tf", "over=hot"], ["--range", "over=50..200"], ["--set", "volumes.over.slices.clear_below=true"]):
        ok("render", "under.nrrd", "over.nrrd", "-o", "a.png", "--overwrite", *SMALL, "--slice", "axial", *extra)
        ok("render", "a.png", "-o", "b.png", "--overwrite")
        assert contents("a.png") == contents("b.png"), extra


def pixel_of(*words):
    """The light of a picture of one pixel."""
    ok("render", *words, "-o", "one.pfm", "--overwrite", "--size", "1", "--slice", "axial", "--set", "views.main.camera.height=1")
    with open("one.pfm", "rb") as file:
        return struct.unpack("<3f", file.read()[-12:])


def test_a_map_of_activity_has_its_own_colours():
    """Where what is weak is clear, what is strong is seen whole; what covers everything lets half through."""
    write_nrrd("under.nrrd", (8, 8, 8), lambda x, y, z: 200)
    write_nrrd("over.nrrd", (8, 8, 8), lambda x, y, z: 6)
    write_nrrd("signed.nrrd", (8, 8, 8), lambda x, y, z: 6, kind="int16", code="h")
    red = pixel_of("over.nrrd", "--tf", "hot", "--range", "2..8")
    seen = pixel_of("under.nrrd", "over.nrrd", "--window", "under=0..200", "--tf", "over=hot", "--range", "over=2..8")
    assert max(abs(a - b) for a, b in zip(red, seen)) < 1e-6, (red, seen)
    blue = pixel_of("signed.nrrd", "--tf", "coolwarm", "--range=-8..8")
    seen = pixel_of("under.nrrd", "signed.nrrd", "--window", "under=0..200", "--tf", "signed=coolwarm", "--range", "signed=-8..8")
    assert max(abs(a - b) for a, b in zip(blue, seen)) < 1e-6, (blue, seen)
    write_nrrd("plain.nrrd", (8, 8, 8), lambda x, y, z: 200 if x > 1 else 0)
    half = pixel_of("under.nrrd", "plain.nrrd", "--window", "under=200..400")
    assert all(abs(c - 0.5) < 1e-6 for c in half), half  # white over black
    quarter = pixel_of("under.nrrd", "over.nrrd", "--window", "under=0..200", "--tf", "over=hot", "--range", "over=2..8", "--opacity", "over=25%")
    assert all(abs(q - 0.75 - r / 4) < 1e-6 for q, r in zip(quarter, red)), quarter


def write_image(path, n):
    header = b"{'descr': '<f4', 'fortran_order': False, 'shape': (%d, %d), }" % (n, n)
    header += b" " * (117 - len(header)) + b"\n"
    with open(path, "wb") as file:
        file.write(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header)
        file.write(struct.pack(f"<{n * n}f", *[i % n for i in range(n * n)]))


def test_an_image_is_shown_as_it_is():
    """A 2-D file, however few its samples: no light, its values over its window, in every row alike."""
    for n in (2, 3, 5, 16):
        write_image("d2.npy", n)
        seen = ok("render", "d2.npy", "-o", "d2.pfm", "--overwrite", "--size", f"{n}x{n}", "--set", f"views.main.camera.height={n}",
                  "--window", f"0..{n - 1}", "--json").json
        assert seen["method"] == "slice", n
        with open("d2.pfm", "rb") as file:
            data = file.read()[-n * n * 12 :]
        for y in range(n):
            for x in range(n):
                light = struct.unpack_from("<3f", data, 12 * (n * y + x))
                v = x / (n - 1)
                linear = v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4
                assert all(abs(c - linear) < 2e-3 for c in light), (n, x, y, light, linear)
    ok("render", "d2.npy", "-o", "a.png", "--size", "16", "--method", "raycast")


def test_a_thick_slice_is_an_image_too():
    for dims, spacing, plane in (((6, 4, 1), (1, 1, 9), "axial"), ((4, 1, 6), (1, 9, 1), "coronal"), ((1, 6, 4), (9, 1, 1), "sagittal")):
        write_nrrd("thick.nrrd", dims, lambda x, y, z: x + y + z, spacing=spacing)
        ok("render", "thick.nrrd", "-o", "a.png", "--overwrite", "--size", "16", "--save-scene", "a.vv.json")
        with open("a.vv.json") as file:
            render = json.load(file)["views"]["main"]["render"]
        assert render["method"] == "slice" and render["slice"]["orientation"] == plane, (dims, render)
    write_nrrd("row.nrrd", (6, 1, 1), lambda x, y, z: x)  # a row is no image
    assert ok("render", "row.nrrd", "-o", "a.png", "--overwrite", "--size", "16", "--json").json["method"] == "raycast"


def test_the_scene_has_cross_hair_and_window():
    write_ramp()
    ok("render", "ramp.nrrd", "-o", "a.png", *SMALL, "--slice", "coronal", "--save-scene", "a.vv.json")
    with open("a.vv.json") as file:
        scene = json.load(file)
    assert scene["cross_hair"] == [8, 3, 6], scene["cross_hair"]
    assert scene["views"]["main"]["render"]["method"] == "slice"
    assert scene["views"]["main"]["render"]["slice"]["orientation"] == "coronal"
    window = scene["volumes"]["ramp"]["slices"]
    # 1 and 99.9 % of 315 samples: at places 3.14 and 313.686 of 0, 2, 3, 4, 5, ... 52, 54
    assert abs(window["window_lo"] - 4.14) < 1e-9 and abs(window["window_hi"] - 53.372) < 1e-9, window
    ok("render", "a.vv.json", "-o", "b.png")
    assert png_pixels("a.png") == png_pixels("b.png")


def write_signed(path="signed.nrrd", ratio=1.0):
    """sin sin sin, of which the positive part is `ratio` times as large."""
    def value(x, y, z):
        v = math.sin(x * 0.4 + 0.1) * math.sin(y * 0.4 + 0.1) * math.sin(z * 0.4 + 0.1)
        return 1000 * v * (ratio if v > 0 else 1)
    write_nrrd(path, (32, 32, 32), lambda x, y, z: round(value(x, y, z)), kind="int16", code="h")


def slices_of(path):
    with open(path) as file:
        return next(iter(json.load(file)["volumes"].values()))["slices"]


def test_values_about_zero_are_seen_about_zero():
    write_signed()
    ok("render", "signed.nrrd", "-o", "a.png", *SMALL, "--slice", "axial", "--save-scene", "a.vv.json")
    look = slices_of("a.vv.json")
    assert look["colormap"] == "coolwarm" and look["window_lo"] == -look["window_hi"], look
    assert 800 < look["window_hi"] <= 1000, look
    ok("render", "a.vv.json", "-o", "b.png")
    assert png_pixels("a.png") == png_pixels("b.png")
    ok("render", "signed.nrrd", "-o", "c.png", *SMALL, "--slice", "axial", "--window", "-500..900", "--save-scene", "c.vv.json")
    assert "colormap" not in slices_of("c.vv.json")


def test_a_map_with_a_middle_has_zero_there():
    write_signed("lopsided.nrrd", 7)
    ok("render", "lopsided.nrrd", "-o", "a.png", *SMALL, "--slice", "axial", "--tf", "coolwarm", "--save-scene", "a.vv.json")
    look = slices_of("a.vv.json")
    assert look["window_lo"] == -look["window_hi"] and look["window_hi"] > 4000, look
    write_ramp()
    ok("render", "ramp.nrrd", "-o", "b.png", *SMALL, "--slice", "axial", "--tf", "coolwarm", "--save-scene", "b.vv.json")
    assert slices_of("b.vv.json")["window_lo"] > 0  # nothing lies below zero


def test_lengths_of_the_cross_hair_have_units():
    write_ramp()
    made = []
    for words in (["--cross-hair", "4,2,6"], ["--cross-hair", "0.4cm,2mm,6mm"], ["--set", "cross_hair=4,2,6"]):
        ok("render", "ramp.nrrd", "-o", "a.png", "--overwrite", *SMALL, "--slice", "axial", *words)
        made.append(png_pixels("a.png"))
    assert made[0] == made[1] == made[2]
    ok("render", "ramp.nrrd", "-o", "a.png", "--overwrite", *SMALL, "--slice", "axial", "--cross-hair", "4,2,9")
    assert png_pixels("a.png") != made[0]


def test_a_pixel_of_a_slice_has_its_value():
    write_ramp()
    middle = ["--slice", "axial", "--size", "31x31", "--window", "0,54"]
    hit = ok("pick", "ramp.nrrd", *middle, "--pixel", "15,15", "--json").json["pixels"][0]
    assert abs(hit["value"] - (2 * 4 + 3 * 3 + 5 * 2)) < 1e-5, hit
    ok("render", "ramp.nrrd", "-o", "a.png", *middle)
    assert Image.open("a.png").convert("RGB").getpixel((15, 15)) in ((127,) * 3, (128,) * 3)  # 27 of 54
    ok("render", "ramp.nrrd", "-o", "b.png", *middle, "--cross-hair", "0,0,0")  # 17: five less for each of two slices
    assert Image.open("b.png").convert("RGB").getpixel((15, 15)) == (round(255 * 17 / 54),) * 3


def test_what_does_not_go_together_is_said():
    write_ramp()
    says(fails(2, "render", "ramp.nrrd", "-o", "a.png", "--slice", "axal"), "--slice", "axial")
    says(fails(2, "render", "ramp.nrrd", "-o", "a.png", "--slice", "axial", "--method", "raycast"), "--slice", "raycast")
    says(fails(2, "render", "ramp.nrrd", "-o", "a.png", "--slice", "axial", "--window", "5,5"), "--window", "LO..HI")
    says(fails(2, "render", "ramp.nrrd", "-o", "a.png", "--slice", "axial", "--cross-hair", "here"), "--cross-hair")
    says(ok("methods", "slice").text, "axial|coronal|sagittal|camera", "world|samples")



main()
