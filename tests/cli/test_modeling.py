"""Solids as volumes: what a wine bottle holds, scenes that keep how they were made."""
import math

from harness import fails, main, ok, says

GRID = ("--raw", "80x80x312,u8,spacing=1x1x1")
CAVITY = " | ".join((
    "voxelize --shape cylinder --radius 35 --height 173 --center 39.5,39.5,92.5",
    "voxelize --with union --shape ellipsoid --size 70,70,86 --center 39.5,39.5,179",
    "voxelize --with union --shape cylinder --radius 9.25 --height 121 --center 39.5,39.5,239.5",
    "voxelize --with difference --shape sphere --radius 33.6 --center 39.5,39.5,-9.6",
))


def grid(name, samples):
    with open(name, "wb") as file:
        file.truncate(samples)


def volume(name):
    return ok("measure", "volume", name, "--iso", "0.5", "--json").json["volume"]


def bottle_content():
    """Of a cylinder, the upper half of an ellipsoid, a neck where that ends, and less a dome of the floor."""
    t = math.sqrt(1 - (9.25 / 35) ** 2)
    cap = math.pi * 35 ** 2 * 43 * (2 / 3 - t + t ** 3 / 3)
    neck = math.pi * 9.25 ** 2 * (300 - 179 - 43 * t) - cap
    dome = math.pi * 18 ** 2 * (33.6 - 18 / 3)
    return math.pi * 35 ** 2 * 173 + 2 / 3 * math.pi * 35 ** 2 * 43 + neck - dome


def test_a_bottle_holds_what_its_formula_says():
    assert abs(bottle_content() / 769e3 - 1) < 1e-3
    grid("grid.raw", 80 * 80 * 312)
    ok("pipe", "grid.raw", *GRID, CAVITY, "-o", "cavity.nrrd")
    assert abs(volume("cavity.nrrd") / bottle_content() - 1) < 0.01, volume("cavity.nrrd")


def test_scenes_keep_how_solids_are_made():
    grid("grid.raw", 80 * 80 * 312)
    size = ("--size", "100", "--overwrite")
    ok("render", "grid.raw", *GRID, "--apply", CAVITY, "--iso", "0.5", "--save-scene", "made.vv.json", "-o", "made.png", *size)
    ok("render", "made.vv.json", "-o", "again.png", *size)
    with open("made.png", "rb") as made, open("again.png", "rb") as again:
        assert made.read() == again.read()
    ok("pipe", "grid.raw", *GRID, CAVITY, "-o", "cavity.nrrd", "--overwrite")
    ok("render", "cavity.nrrd", "--iso", "0.5", "-o", "file.png", *size)
    ok("compare", "made.png", "file.png", "--psnr", "60")


def test_what_cannot_be_is_refused_in_a_sentence():
    grid("cube.raw", 32 ** 3)
    words = ("voxelize", "cube.raw", "--raw", "32x32x32,u8", "-o", "x.nrrd")
    says(fails(2, *words, "--radius", "0"), "radius of a sphere is 0, and must be above 0")
    says(fails(2, *words, "--shape", "torus", "--tube", "20"), "a torus's tube is more than its radius")
    says(fails(2, *words, "--tube", "2"), "--tube does nothing with --shape sphere")
    says(fails(2, *words, "--shape", "spere"), "sphere")


main()
