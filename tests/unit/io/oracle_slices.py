"""Folders of numbered slices that tifffile and Pillow wrote: order, gaps, series, axes by their names, foreign files.

Usage: oracle_slices.py IO_TOOL. Exit 77 (skipped) without Pillow or tifffile.
"""
import os
import shutil
import sys

try:
    import numpy as np
    import tifffile
    from PIL import Image
except ImportError:
    print("numpy, tifffile or Pillow is missing: skipped")
    sys.exit(77)
from served import Tool, workplace

tool = Tool(sys.argv[1])
failures = 0
checks = 0


def expect(condition, what):
    global failures, checks
    checks += 1
    if not condition:
        failures += 1
        print("FAILED:", what)


def warnings(path, *part):
    """All that vv_file_warning() says."""
    _, said, error = tool.ask("notes", path, *part)
    return said + error


def same(info, values, expected, what):
    if info is None:
        expect(False, f"{what}: {values}")
    else:
        expect(values.shape == expected.shape and np.array_equal(values, expected.astype("f8")),
               f"{what}: other samples, {values.shape} and {expected.shape}")


def formula(shape, dtype, seed=3):
    info = np.iinfo(dtype)
    return np.random.default_rng(seed).integers(info.min, info.max, size=shape, endpoint=True).astype(dtype)


def fresh(folder, name):
    path = os.path.join(folder, name)
    shutil.rmtree(path, ignore_errors=True)
    os.mkdir(path)
    return path


def check_kinds(work):
    for kind, dtype, colors in (("png", "u1", 1), ("png", "u2", 1), ("png", "u1", 3), ("png", "u1", 4), ("tif", "u1", 1),
                                ("tif", "u2", 1), ("tif", "f4", 1), ("tif", "u1", 3)):
        folder = fresh(work, "kinds")
        data = formula((12, 13, 17, colors), "u2").astype("f4") if dtype == "f4" else formula((12, 13, 17, colors), dtype)
        for i, page in enumerate(data):  # 1 .. 12: by number 2 comes before 10
            Image.fromarray(page if colors > 1 else page[..., 0]).save(os.path.join(folder, f"slice{i + 1}.{kind}"))
        info, values = tool.read(folder)
        same(info, values, data[None], f"{kind} {dtype} {colors}")
        expect(info is None or info["unit"] == "voxels", f"{kind}: unit")
        same(*tool.read(os.path.join(folder, f"slice3.{kind}")), data[None, 2:3], f"{kind} {dtype} {colors}: one slice")
    folder = fresh(work, "jpeg")
    smooth = np.add.outer(np.arange(40), np.arange(56)).astype("u1")
    for mode in ("L", "RGB"):
        for i in range(5):
            Image.fromarray(smooth + i * 20).convert(mode).save(os.path.join(folder, f"{i:03}.jpg"), quality=95)
        info, values = tool.read(folder)
        theirs = np.stack([np.array(Image.open(os.path.join(folder, f"{i:03}.jpg"))) for i in range(5)])
        theirs = theirs.reshape(1, 5, 40, 56, -1)
        expect(info is not None and values.shape == theirs.shape and np.abs(values - theirs).max() <= 2,
               f"JPEG {mode}: {values if info is None else values.shape}")
    path = os.path.join(folder, "002.jpg")
    os.truncate(path, os.path.getsize(path) * 3 // 4) # what a decoder would fill in is no sample
    info, values = tool.read(folder)
    expect(info is not None and not values[0, 2].any() and np.abs(values[0, [0, 1, 3, 4]] - theirs[0, [0, 1, 3, 4]]).max() <= 2,
           "a cut JPEG file is left out, the others are there")


def check_png_dialects(work):
    folder = fresh(work, "dialects")
    path = os.path.join(folder, "a.png")
    bits = formula((11, 13), "u1") > 99
    Image.fromarray(bits).save(path)
    same(*tool.read(path), bits[None, None, ..., None], "PNG of one bit")
    palette = Image.fromarray(formula((11, 13, 3), "u1")).quantize(16)
    palette.save(path)
    same(*tool.read(path), np.array(palette.convert("RGB"))[None, None], "PNG with a palette")


def check_series(work):
    folder = fresh(work, "series")
    data = formula((2, 6, 9, 8), "u2")
    for c, name in enumerate("ab"):
        for z in range(6 if c == 0 else 4):
            tifffile.imwrite(os.path.join(folder, f"t2_{name}_{z * 5:03}_x7.tif"), data[c, z], metadata=None,
                             photometric="minisblack", compression="deflate" if z % 2 else None)
    for name in ("Thumbs.db", "notes.txt", ".hidden.tif"):
        with open(os.path.join(folder, name), "w", encoding="ascii") as f:
            f.write("nothing")
    same(*tool.read(folder), data[:1, ..., None], "the longer series")
    same(*tool.read(folder, "t2_b_"), data[1:, :4, ..., None], "the other series")
    same(*tool.read(folder, "t2_b_#_x7.tif"), data[1:, :4, ..., None], "the other series by its key")
    info, error = tool.read(folder, "t3")
    expect(info is None and "no series 't3'" in error, "no such series")


def check_damage(work):
    folder = fresh(work, "gaps")
    data = formula((7, 9, 8), "u2")
    for z in range(7):
        tifffile.imwrite(os.path.join(folder, f"{z + 10}.tif"), data[z], metadata=None, photometric="minisblack")
    os.remove(os.path.join(folder, "13.tif"))  # a gap
    tifffile.imwrite(os.path.join(folder, "15.tif"), data[5, :4], metadata=None, photometric="minisblack")
    expected = data.copy()
    expected[[3, 5]] = 0
    same(*tool.read(folder), expected[None, ..., None], "a gap and another size")
    with open(os.path.join(folder, "16.tif"), "wb") as f:
        f.write(b"II*\\0")
    expected[6] = 0
    same(*tool.read(folder), expected[None, ..., None], "a broken file")


def check_stacks(work):
    folder = fresh(work, "time")
    data = formula((3, 4, 9, 8), "u1")
    for t in range(3):
        tifffile.imwrite(os.path.join(folder, f"t{t}.tif"), data[t], imagej=True, resolution=(2.0, 2.0),
                         metadata={"axes": "ZYX", "spacing": 1.5, "unit": "um"})
    info, values = tool.read(folder)
    same(info, values, data[..., None], "stacks are time steps")
    steps = [info["columns"][i][i] for i in range(3)]
    expect(info["unit"] == "um" and np.allclose(steps, [0.5, 0.5, 1.5]), f"steps {steps} {info['unit']}")


def grid(n_t, n_z, n_c, shape=(4, 5)):
    """Values that differ from plane to plane, as [t, z, c, y, x]."""
    return formula((n_t, n_z, n_c, *shape), "u2", n_t * 100 + n_z * 10 + n_c)


def write_grid(folder, name, data, first=(0, 0, 0), **keys):
    """A file for each plane; name(t, z, c) is what it is called."""
    for t, z, c in np.ndindex(data.shape[:3]):
        path = os.path.join(folder, name(t + first[0], z + first[1], c + first[2]))
        tifffile.imwrite(path, data[t, z, c], metadata=None, photometric="minisblack", **keys)


# how microscopes and their programs name files, by time step, slice and channel
NAMES = {
    "z and c": (1, 13, 3, lambda t, z, c: f"img_z{z:02}_c{c}.tif"),
    "Leica": (2, 11, 3, lambda t, z, c: f"img_t{t:03}_z{z:03}_ch{c:02}.tif"),
    "Leica, positions": (1, 5, 2, lambda t, z, c: f"Series001_s1_z{z:02}_ch{c:02}_RAW.tif"),
    "equals": (1, 12, 2, lambda t, z, c: f"img_C={c}_Z={z}.tif"),
    "Olympus": (2, 3, 2, lambda t, z, c: f"stack_T{t + 1:04}_Z{z + 1:03}_C{c + 1:02}.tif"),
    "together": (2, 3, 4, lambda t, z, c: f"Plate_A01_T{t:04}F001L01A01Z{z:02}C{c + 1:02}.tif"),
    "Micro-Manager": (3, 4, 2, lambda t, z, c: f"img_channel{c:03}_position000_time{t:09}_z{z:03}.tif"),
    "words": (2, 3, 2, lambda t, z, c: f"Channel {c} Time-{t} Slice_{z}.tif"),
    "one letter apart": (2, 3, 2, lambda t, z, c: f"a_t_{t:03}_z_{z:03}_c_{c}.tif"),
    "camel case": (2, 3, 2, lambda t, z, c: f"imgT{t}imgZ{z}imgC{c}.tif"),
    "MetaMorph": (2, 3, 2, lambda t, z, c: f"cells_w{c + 1}{('DAPI', 'Cy5')[c]}_s1_z{z + 1}_t{t + 1}.TIF"),
    "slices without a letter": (2, 12, 2, lambda t, z, c: f"2023-11-05 ch{c} t{t} {z + 9:03}.tif"),
    "channels alone": (1, 1, 3, lambda t, z, c: f"img_ch{c}.tif"),
    "time alone": (4, 1, 1, lambda t, z, c: f"img_t{t + 8}.tif"),
    "steps of two": (2, 4, 1, lambda t, z, c: f"t{t * 10}z{z * 2}.tif"),
    "a letter that is a name": (1, 12, 1, lambda t, z, c: f"left_c_{z}.tif"),
    "times of day": (1, 12, 1, lambda t, z, c: f"{z + 95:04}_{z * 7919 % 240000:06}.tif"),
}


def check_names(work):
    for what, (n_t, n_z, n_c, name) in NAMES.items():
        folder = fresh(work, "names")
        data = grid(n_t, n_z, n_c)
        write_grid(folder, name, data)
        info, values = tool.read(folder)
        same(info, values, data.transpose(0, 1, 3, 4, 2), what)
        expect("warning" not in warnings(folder), f"{what}: {warnings(folder)}")


def check_told(work):
    folder = fresh(work, "told")
    write_grid(folder, NAMES["Leica"][3], grid(2, 11, 3))
    said = warnings(folder)
    expect("img_t{t}_z{z}_ch{c}.tif: 2 time steps, 11 slices, 3 channels" in said, said)
    names = [c[0] for c in tool.read(folder)[0]["channels"]]
    expect(names == ["ch00", "ch01", "ch02"], names)
    folder = fresh(work, "told")
    write_grid(folder, NAMES["MetaMorph"][3], grid(1, 2, 2))
    names = [c[0] for c in tool.read(folder)[0]["channels"]]
    expect(names == ["DAPI", "Cy5"], names)


def check_positions(work):
    folder = fresh(work, "positions")
    data = [grid(2, 3, 2), grid(2, 3, 2) // 3]
    for p in range(2):
        write_grid(folder, lambda t, z, c, p=p: f"img_channel{c:03}_position{p:03}_time{t:09}_z{z:03}.tif", data[p])
    same(*tool.read(folder), data[0].transpose(0, 1, 3, 4, 2), "the first position")
    said = warnings(folder)
    expect("holds 2 series" in said and "_position000_" in said, said)
    for part in ("img_channel#_position001_time#_z#.tif", "img_channel{c}_position001_time{t}_z{z}.tif", "*_position001_*"):
        same(*tool.read(folder, part), data[1].transpose(0, 1, 3, 4, 2), "the other position, " + part)
    same(*tool.read(folder, "*_channel001_position001_*"), data[1][:, :, 1, ..., None], "a channel of a position")


def check_choices(work):
    """Numbers that no letter explains are never guessed; a pattern says what they count."""
    folder = fresh(work, "choices")
    data = grid(3, 12, 1)
    write_grid(folder, lambda t, z, c: f"scan{t + 1}_{z + 1:03}.tif", data)
    info, error = tool.read(folder)
    expect(info is None and "scan1_001.tif" in error and "scan{t}_{z}.tif" in error, f"two numbers: {error}")
    every = data[:, :, 0, ..., None]
    same(*tool.read(folder, "scan{t}_{z}.tif"), every, "time and slices")
    same(*tool.read(folder, "scan{z}_{t}.tif"), every.transpose(1, 0, 2, 3, 4), "slices and time")
    same(*tool.read(folder, "scan{c}_#.tif"), data[:, :, 0].transpose(1, 2, 3, 0)[None], "channels and slices")
    same(*tool.read(folder, "scan2_"), every[1:2], "one scan, by how it begins")
    same(*tool.read(folder, "scan3_*"), every[2:], "one scan, by a pattern")
    for bad, why in (("*{z}*", "same number"), ("scan{t}_{t}.tif", "two numbers that count time"), ("scan#_#.tif", "two numbers"),
                     ("x{z}", "no series"), ("*" * 40 + "#*#*#*#q", "no series")):
        info, error = tool.read(folder, bad)
        expect(info is None and why in error, f"{bad}: {error}")
    folder = fresh(work, "choices")
    data = grid(2, 3, 2)
    write_grid(folder, lambda t, z, c: f"img_{t:09}_{('GFP', 'DAPI 2')[c]}_{z:03}.tif", data)
    same(*tool.read(folder, "img_{t}_GFP_{z}.tif"), data[:, :, 0, ..., None], "one channel by its word")
    info, values = tool.read(folder, "img_{t}_{c}*_{z}.tif")
    same(info, values, data[:, :, ::-1].transpose(0, 1, 3, 4, 2), "channels by their words")
    expect(info is not None and [c[0] for c in info["channels"]] == ["DAPI", "GFP"], f"words: {info and info['channels']}")


def check_incomplete(work):
    folder = fresh(work, "incomplete")
    data = grid(2, 6, 2)
    write_grid(folder, NAMES["Leica"][3], data)
    for t, z, c in ((1, 2, 1), (0, 4, 0)):
        os.remove(os.path.join(folder, NAMES["Leica"][3](t, z, c)))
        data[t, z, c] = 0
    said = warnings(folder)
    expect("2 of 24 files" in said and "channel 0, slice 4, time step 0" in said, said)
    same(*tool.read(folder), data.transpose(0, 1, 3, 4, 2), "two files are missing")
    folder = fresh(work, "incomplete")
    for i in range(5):  # a diagonal
        tifffile.imwrite(os.path.join(folder, f"t{i}_z{i}.tif"), data[0, 0, 0], metadata=None, photometric="minisblack")
    info, error = tool.read(folder)
    expect(info is None and "5 time steps x 5 slices x 1 channels, but only 5" in error, error)
    folder = fresh(work, "twice")
    for name in ("a1.tif", "a01.tif"):
        tifffile.imwrite(os.path.join(folder, name), data[0, 0, 0], metadata=None, photometric="minisblack")
    info, error = tool.read(folder)
    expect(info is None and "'a01.tif' and 'a1.tif'" in error.replace("'a1.tif' and 'a01.tif'", "'a01.tif' and 'a1.tif'"), error)


def check_pages(work):
    """Files of several pages: what their own headers say, and what their names count, together."""
    data = formula((2, 3, 4, 2, 6, 7), "u2")  # t file z c y x
    folder = fresh(work, "pages")
    for t in range(2):
        tifffile.imwrite(os.path.join(folder, f"a_{t + 1}.tif"), data[t, 0], imagej=True, metadata={"axes": "ZCYX"})
    same(*tool.read(folder), data[:, 0].transpose(0, 1, 3, 4, 2), "hyperstacks are time steps")
    folder = fresh(work, "pages")
    for t in range(2):
        for c in range(2):
            tifffile.imwrite(os.path.join(folder, f"a_t{t}_ch{c}.tif"), data[t, 0, :, c], metadata=None, photometric="minisblack")
    same(*tool.read(folder), data[:, 0].transpose(0, 1, 3, 4, 2), "stacks by time and channel")
    folder = fresh(work, "pages")
    for z in range(4):
        tifffile.imwrite(os.path.join(folder, f"a_z{z}.tif"), data[:, 0, z], imagej=True, metadata={"axes": "TCYX"})
    same(*tool.read(folder), data[:, 0].transpose(0, 1, 3, 4, 2), "slices of time steps and channels")
    folder = fresh(work, "pages")
    for z in range(3):
        tifffile.imwrite(os.path.join(folder, f"a_z{z}.tif"), data[0, z, :, 0], metadata=None, photometric="minisblack")
    info, error = tool.read(folder)
    expect(info is None and "count slices, and so do the 4 pages" in error, f"slices twice: {error}")
    same(*tool.read(folder, "a_z{t}.tif"), data[0, :, :, 0, ..., None], "names count time after all")


with workplace() as place:
    check_kinds(place)
    check_png_dialects(place)
    check_series(place)
    check_damage(place)
    check_stacks(place)
    check_names(place)
    check_told(place)
    check_positions(place)
    check_choices(place)
    check_incomplete(place)
    check_pages(place)
failures += not tool.end()
print(checks, "checks,", failures, "failed")
sys.exit(1 if failures else 0)
