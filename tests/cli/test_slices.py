"""Slices from outside: short forms, scenes, and pixels that a formula tells."""
import json
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


def test_the_scene_has_cross_hair_and_window():
    write_ramp()
    ok("render", "ramp.nrrd", "-o", "a.png", *SMALL, "--slice", "coronal", "--save-scene", "a.vv.json")
    with open("a.vv.json") as file:
        scene = json.load(file)
    assert scene["cross_hair"] == [8, 3, 6], scene["cross_hair"]
    assert scene["views"]["main"]["render"]["method"] == "slice"
    assert scene["views"]["main"]["render"]["slice"]["orientation"] == "coronal"
    window = scene["volumes"]["ramp"]["slices"]
    assert 0 <= window["window_lo"] <= 4 and 48 < window["window_hi"] <= 54, window
    ok("render", "a.vv.json", "-o", "b.png")
    assert png_pixels("a.png") == png_pixels("b.png")


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
    says(fails(2, "render", "ramp.nrrd", "-o", "a.png", "--slice", "axial", "--window", "5,5"), "--window", "LO,HI")
    says(fails(2, "render", "ramp.nrrd", "-o", "a.png", "--slice", "axial", "--cross-hair", "here"), "--cross-hair")
    says(ok("methods", "slice").text, "axial|coronal|sagittal|camera", "world|samples")



main()
