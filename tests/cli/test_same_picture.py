"""The same volume, written in every format and in every order of its axes, gives the same picture."""
import functools
import itertools
import math
import os
import sys

import numpy

from harness import main, ok, volvis

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "golden"))
import png

DIMS = (23, 19, 17)
SPACING = (1.0, 1.25, 1.5)
ORDERS = [
    "".join(("-" if signs >> a & 1 else "") + "xyz"[axis] for a, axis in enumerate(axes))
    for axes in itertools.permutations(range(3))
    for signs in range(8)
]
WHOLE = (".tif", ".ome.tif", ".mrc")
ENOUGH_DB = 48  # of 8-bit pictures: rounding of the placement, nothing more

# suffix, volume that it can hold whole, orders of axes
FORMATS = [
    (".nrrd", "anatomical", ORDERS),
    (".nhdr", "plain", ORDERS[::5]),
    (".nii", "anatomical", ORDERS),
    (".nii.gz", "anatomical", ORDERS[::7]),
    (".mha", "anatomical", ORDERS),
    (".mhd", "anatomical", ORDERS[::7]),
    (".vti", "plain", ORDERS),
    (".h5", "plain", ORDERS[::5]),
    (".vvh", "plain", ORDERS[::5]),
    (".tif", "straight", ORDERS[::7]),
    (".tif", "anatomical", ORDERS),
    (".ome.tif", "straight", ORDERS[::7]),
    (".ome.tif", "anatomical", ORDERS[::3]),
    (".ome.zarr", "straight", ORDERS[::5]),
    (".mrc", "angstrom", ORDERS[::5]),
    (".mrc", "upright", ORDERS[::3]),
    (".npy", "voxels", ["xyz"]),
    (".raw", "voxels", ["xyz"]),
]


def value(x, y, z):
    """No symmetry: a mirrored or turned picture is another one."""
    blobs = ((0.3, 0.4, 0.35, 0.16, 250), (0.75, 0.3, 0.6, 0.1, 190), (0.55, 0.8, 0.8, 0.12, 140), (0.2, 0.75, 0.2, 0.09, 220))
    sum_ = 0.0
    for cx, cy, cz, r, v in blobs:
        sum_ += v * math.exp(-((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2) / (r * r))
    return min(255, int(sum_))


def write_volumes():
    n, s = DIMS, SPACING
    samples = bytes(
        value((i + 0.5) / n[0], (j + 0.5) / n[1], (k + 0.5) / n[2])
        for k in range(n[2]) for j in range(n[1]) for i in range(n[0])
    )
    steps = " ".join(f"({','.join(str(s[a] if a == b else 0) for b in range(3))})" for a in range(3))
    head = f"NRRD0005\ntype: uint8\ndimension: 3\nsizes: {n[0]} {n[1]} {n[2]}\nencoding: raw\n"
    # millimetres, turned a little: no grid of the other axes can hide a wrong sign
    a, b = math.cos(0.3), math.sin(0.3)
    turned = f"({s[0] * a},{s[0] * b},0) ({-s[1] * b},{s[1] * a},0) (0,0,{s[2]})"
    heads = {
        "anatomical": f'space: RAS\nspace directions: {turned}\nspace origin: (-5,7,11)\nspace units: "mm" "mm" "mm"\n',
        "plain": f"space dimension: 3\nspace directions: {turned}\nspace origin: (3,-4,5)\n",
        "straight": f'space dimension: 3\nspace directions: {steps}\nspace units: "um" "um" "um"\n',
        # opacity is per unit of length, and MRC knows no other
        "angstrom": f'space dimension: 3\nspace directions: {steps}\nspace units: "A" "A" "A"\n',
        "upright": f'space: RAS\nspace directions: {steps}\nspace origin: (-5,7,11)\nspace units: "mm" "mm" "mm"\n',
        "voxels": "",
    }
    for name, text in heads.items():
        with open(f"{name}.nrrd", "wb") as file:
            file.write((head + text + "\n").encode() + samples)


def picture(path, out, whole):
    """The view and colours of the volume's kind where a format keeps that too."""
    chosen = () if whole else ("--tf", "0:0 60:0 255:0.6#ffd9a0", "--view", "25,20")
    ok("render", path, "-o", out, "--size", "96x96", "--set", "views.main.camera.fit=data", *chosen)


@functools.lru_cache(None)
def first_picture(path):
    return png.read(path)[0]


def alike(first, path):
    """Peak signal to noise in dB, over red, green and blue as they are stored: of the pixels, by numpy."""
    square = ((first_picture(first) - png.read(path)[0])[..., :3] ** 2).mean()
    return -10 * math.log10(square) if square else math.inf


def writable():
    suffixes = set()
    for row in ok("formats", "--json").json["formats"]:
        if row["writes"]:
            suffixes.update(row["suffixes"])
    return suffixes


@functools.lru_cache(None)
def source_of(volume, order):
    """The volume with its axes in this order: several formats have the same."""
    if order == "xyz":
        return f"{volume}.nrrd"
    ok("reorient", f"{volume}.nrrd", "-o", f"{volume}.{order}.nrrd", f"--order={order}")
    return f"{volume}.{order}.nrrd"


def check_format(suffix, volume, orders, suffixes):
    if not any(suffix.endswith(s) or suffix.removesuffix(".gz") == s for s in suffixes):
        print(f"(this build does not write {suffix})")
        return
    for order in orders:
        name = f"{volume}_{DIMS[0]}x{DIMS[1]}x{DIMS[2]}_u8{suffix}"
        ok("convert", source_of(volume, order), "-o", name, "--overwrite", "-q")
        whole = suffix in WHOLE
        picture(name, "written.png", whole)
        same = alike(f"{volume}{'_whole' if whole else ''}.png", "written.png")
        assert same >= ENOUGH_DB, f"{suffix}, {volume}, axes {order}: {same:.1f} dB"


def test_every_format_and_every_order_of_axes_gives_the_same_picture():
    write_volumes()
    suffixes = writable()
    for volume in ("anatomical", "plain", "straight", "angstrom", "upright", "voxels"):
        picture(f"{volume}.nrrd", f"{volume}.png", False)
        picture(f"{volume}.nrrd", f"{volume}_whole.png", True)
        assert os.path.getsize(f"{volume}.png") > 1000
    for suffix, volume, orders in FORMATS:
        check_format(suffix, volume, orders, suffixes)


def test_a_mirrored_volume_gives_another_picture():
    """Or the test above would show nothing."""
    write_volumes()
    picture("anatomical.nrrd", "straight.png", False)
    for axis in "xyz":
        ok("flip", "anatomical.nrrd", "-o", "mirrored.nrrd", "--axes", axis, "--mirror", "--overwrite")
        picture("mirrored.nrrd", "mirrored.png", False)
        assert volvis("compare", "straight.png", "mirrored.png", "--psnr", "35").code == 6
        assert alike("straight.png", "mirrored.png") < 35


FILLS = [("f4", -1e6), ("f4", -1e30), ("f4", -9.97e36), ("f4", -3.4e38), ("f8", -1e9), ("f8", -1e30), ("i4", -9999), ("i4", -2**31)]


def filled(kind, fill):
    """A ball of 0 to 30 whose one side holds a fill, and a sample far from it."""
    z, y, x = numpy.mgrid[:24, :24, :24]
    far = numpy.sqrt((x - 12) ** 2 + (y - 12) ** 2 + (z - 12) ** 2)
    values = numpy.floor(numpy.clip(31 * (1 - far / 13), 0, 30))
    values[:, :, :3] = fill
    values[2, 2, 20] = fill
    numpy.save("filled.npy", values.astype(kind))


def filled_picture(kind, fill, words):
    filled(kind, fill)
    ok("render", "filled.npy", "--tf", "0:0.02#00f 15:0.1#0f0 30:0.5#f00", "-o", "filled.png", "--overwrite",
       "--size", "64x48", "--view", "30,20", *words)
    return 255 * png.read("filled.png")[0]


def test_how_far_out_a_fill_lies_does_not_matter_where_the_nodes_lie_above_it():
    for words in (["--no-shading"], ["--no-shading", "--quality", "high"], [], ["--quality", "high"]):
        moderate = filled_picture("f4", -9999, words)
        assert len(numpy.unique(moderate)) > 50
        for kind, fill in FILLS:
            found = filled_picture(kind, fill, words)
            assert abs(found - moderate).max() < 1.5, (kind, fill, words, abs(found - moderate).max())


main()
