"""Folders of slices that are written, checked by Pillow and tifffile, and read back."""
import os
import numpy
from harness import Skip, fails, main, ok, says, volvis, write_ball, write_cells, write_samples

CODES = {"u1": "uint8", "u2": "uint16", "i2": "int16", "u4": "uint32", "i4": "int32", "f4": "float", "f8": "double"}


def image():
    try:
        from PIL import Image
    except ImportError:
        raise Skip("no python3-pil") from None
    return Image


def tifffile():
    try:
        import tifffile as module
    except ImportError:
        raise Skip("no python3-tifffile") from None
    return module


def volume(path, shape, code, **options):
    """z, y, x of random numbers over half of the type's range; a file that says the same."""
    random = numpy.random.default_rng(sum(shape))
    top = 1000 if code[0] == "f" else numpy.iinfo(code).max
    low = 0 if code[0] == "u" else -top // 2
    values = random.integers(low, top, shape).astype("<" + code)
    write_samples(path, shape[::-1], values.tobytes(), kind=CODES[code], **options)
    return values


def slices(source, folder, *words):
    return ok("convert", source, "-o", folder, "--output-format", "slices", *words)


def seen(folder):
    return sorted(name for name in os.listdir(folder) if name[0] != ".")


def test_u8_and_u16_are_png_of_the_same_numbers():
    for code in ("u1", "u2"):
        for number, shape in enumerate([(11, 7, 13), (1, 5, 3), (3, 1, 1), (1, 1, 1)]):
            values = volume("a.nrrd", shape, code)
            folder = f"{code}_{number}"
            says(slices("a.nrrd", folder, "--order", "RAS").message, "PNG", "spacing", ".nrrd")
            width = len(str(shape[0] - 1))
            assert seen(folder) == [f"z{z:0{width}d}.png" for z in range(shape[0])]
            for z, name in enumerate(seen(folder)):
                with image().open(f"{folder}/{name}") as picture:
                    assert (numpy.asarray(picture) == values[z]).all() and picture.size == shape[:0:-1]
            ok("compare", "a.nrrd", folder, "--max-difference", "0")


def test_all_types_are_tiff_with_their_spacing():
    for code in CODES:
        values = volume("a.nrrd", (5, 7, 3), code, spacing=(0.5, 0.7, 2))
        says(slices("a.nrrd", code, "--encoding", "tiff").message, "TIFF", "origin")
        for z, name in enumerate(seen(code)):
            found = tifffile().imread(f"{code}/{name}")
            assert found.dtype == values.dtype and (found == values[z]).all(), (code, name)
        info = ok("info", code, "--json").json
        assert info["dims"] == [3, 7, 5] and numpy.allclose(info["spacing"], [0.5, 0.7, 2]) and info["unit"] == "mm"
        ok("compare", "a.nrrd", code, "--max-difference", "0")


def anatomical(path, letters, values):
    """z, y, x of u16 with a scale; axes that run along these letters."""
    x, y, z = (1 if c in "RAS" else -1 for c in letters)
    header = (f"NRRD0005\ntype: uint16\ndimension: 3\nspace: right-anterior-superior\n"
              f"sizes: {' '.join(str(n) for n in values.shape[::-1])}\nspace directions: ({x},0,0) (0,{y},0) (0,0,{2 * z})\n"
              "space origin: (3,4,5)\nspace units: \"mm\" \"mm\" \"mm\"\nendian: little\nencoding: raw\n"
              "volvis value scale:=2\nvolvis value offset:=-1024\n\n")
    with open(path, "wb") as file:
        file.write(header.encode() + values.astype("<u2").tobytes())


def expect(folder, wanted):
    for z, name in enumerate(seen(folder)):
        if name.endswith(".tif"):
            assert (tifffile().imread(f"{folder}/{name}") == wanted[z]).all(), (folder, name)
            continue
        with image().open(f"{folder}/{name}") as picture:
            assert (numpy.asarray(picture) == wanted[z]).all(), (folder, name)


def test_axial_slices_are_upright_in_png_and_along_the_axes_in_tiff():
    values = numpy.random.default_rng(5).integers(0, 1000, (3, 4, 5), "u2")
    for letters, along in {"LPS": values, "RAS": values, "LAS": values[:, :, ::-1], "LPI": values[::-1],
                           "RAI": values[::-1]}.items():
        anatomical("a.nrrd", letters, values)
        upright = {"LPS": values, "RAS": values[:, ::-1, ::-1], "LAS": values[:, ::-1], "LPI": values[::-1],
                   "RAI": values[::-1, ::-1, ::-1]}[letters]
        said = slices("a.nrrd", letters, "--stored").message
        assert ("upright" in said and "--order RAS" in said) == (letters[:2] != "LP"), said
        expect(letters, upright)
        slices("a.nrrd", letters + "_up", "--stored", "--order", "LPS")
        expect(letters + "_up", values if letters == "LPS" else upright)
        said = slices("a.nrrd", letters + "_ras", "--stored", "--order", "RAS").message
        assert "upright" not in said, said
        expect(letters + "_ras", {"LPS": values[:, ::-1, ::-1], "LPI": values[::-1, ::-1, ::-1]}.get(letters, along))
        said = slices("a.nrrd", letters + "_tif", "--stored", "--encoding", "tiff").message
        assert ("--order LPS" in said) == (letters[:2] != "LP"), said
        expect(letters + "_tif", along)
        ok("convert", "a.nrrd", "-o", "a.tif", "--stored", "--overwrite")
        assert (tifffile().imread("a.tif") == along).all(), letters
        says(ok("compare", "a.nrrd", "a.tif", "--max-difference", "0").text, "placement     the same")


def test_upright_slices_are_what_render_shows():
    values = numpy.zeros((1, 8, 8), "u1")
    values[0, 6:, :3] = 255  # the front, and the side where x begins
    for letters in ("RAS", "LAS", "LPS", "RPS"):
        anatomical("a.nrrd", letters, values)
        slices("a.nrrd", letters + "_p", "--stored")
        ok("render", "a.nrrd", "-o", "a.png", "--slice", "axial", "--size", "64", "--overwrite")
        with image().open("a.png") as shown, image().open(f"{letters}_p/z0.png") as written:
            light = numpy.asarray(shown.convert("L")).astype(float)
            part = numpy.asarray(written).astype(float)
        def quadrant(p):
            rows, columns = numpy.nonzero(p > p.max() / 2)
            return rows.mean() < (p.shape[0] - 1) / 2, columns.mean() < (p.shape[1] - 1) / 2
        assert quadrant(light) == quadrant(part), letters


def test_a_scale_that_is_lost_is_told():
    anatomical("scaled.nrrd", "LPS", numpy.arange(24).reshape(2, 3, 4))
    says(slices("scaled.nrrd", "png", "--stored").message, "do not keep spacing", "scale of values (stored * 2 - 1024)")
    assert "scale" not in slices("scaled.nrrd", "tif", "--stored", "--encoding", "tiff").message
    assert ok("info", "tif", "--json").json["value_offset"] == -1024


def test_what_png_cannot_hold_is_tiff_or_refused():
    volume("a.nrrd", (2, 3, 4), "i2")
    ok("convert", "a.nrrd", "-o", "auto/")
    assert seen("auto") == ["z0.tif", "z1.tif"]
    said = fails(2, "convert", "a.nrrd", "-o", "png", "--output-format", "slices", "--encoding", "png")
    says(said, "i16", "--encoding png", "--type u16")
    assert not os.path.exists("png") and not [name for name in os.listdir(".") if ".part" in name]
    slices("a.nrrd", "png", "--encoding", "png", "--type", "u16", "--range", "-20000..20000")
    assert seen("png") == ["z0.png", "z1.png"]


def test_channels_and_time_steps_are_files_of_their_own():
    write_cells()
    slices("cells.nrrd", "cells")
    assert seen("cells")[0] == "ch0_z00.png" and len(seen("cells")) == 32
    ok("compare", "cells.nrrd", "cells", "--max-difference", "0")
    values = numpy.arange(3 * 4 * 5 * 6, dtype="u1").reshape(3, 4, 5, 6)
    with open("time.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 6 5 4 3\nkinds: space space space time\nencoding: raw\n\n"
                   + values.tobytes())
    assert ok("info", "time.nrrd", "--json").json["frames"] == 3
    slices("time.nrrd", "time")
    assert seen("time") == [f"t{t}_z{z}.png" for t in range(3) for z in range(4)]
    for t in range(3):
        ok("compare", f"time.nrrd@{t}", f"time@{t}", "--max-difference", "0")
        with image().open(f"time/t{t}_z2.png") as picture:
            assert (numpy.asarray(picture) == values[t, 2]).all()


def test_colours_are_colours():
    values = numpy.random.default_rng(3).integers(0, 256, (4, 5, 6, 3), "u1")
    with open("rgb.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 6 5 4\nkinds: RGB-color space space space\nencoding: raw\n\n"
                   + values.tobytes())
    slices("rgb.nrrd", "rgb")
    for z, name in enumerate(seen("rgb")):
        with image().open(f"rgb/{name}") as picture:
            assert picture.mode == "RGB" and (numpy.asarray(picture) == values[z]).all()
    ok("compare", "rgb.nrrd", "rgb", "--max-difference", "0")


def test_only_folders_of_slices_by_volvis_are_replaced():
    write_ball("a.nrrd", 8)
    write_ball("b.nrrd", 4)
    slices("a.nrrd", "out")
    slices("b.nrrd", "out", "--overwrite")
    assert seen("out") == ["z0.png", "z1.png", "z2.png", "z3.png"]
    for name in ("mine/z0.png", "mine/notes.txt"):
        os.makedirs("mine", exist_ok=True)
        with open(name, "wb") as file:
            file.write(b"mine")
        says(fails(5, "convert", "a.nrrd", "-o", "mine", "--output-format", "slices", "--overwrite"), "mine", "is not replaced")
    with open("out/notes.txt", "wb") as file:
        file.write(b"mine")
    fails(5, "convert", "a.nrrd", "-o", "out", "--output-format", "slices", "--overwrite")
    assert seen("mine") == ["notes.txt", "z0.png"] and len(seen("out")) == 5
    says(volvis("convert", "a.nrrd", "-o", "a.png").message, "-o FOLDER/")


def test_names_of_slices_are_a_pattern():
    values = volume("a.nrrd", (11, 7, 13), "u1")
    ok("convert", "a.nrrd", "-o", "pattern/slice_%03d.png", "--order", "RAS")
    assert seen("pattern") == [f"slice_{z:03d}.png" for z in range(11)]
    for z, name in enumerate(seen("pattern")):
        with image().open(f"pattern/{name}") as picture:
            assert (numpy.asarray(picture) == values[z]).all()
    ok("compare", "a.nrrd", "pattern", "--max-difference", "0")
    ok("convert", "a.nrrd", "-o", "pattern/s%d.tif", "--overwrite", "--z", "0..2")
    assert seen("pattern") == ["s0.tif", "s1.tif", "s2.tif"]  # nothing older is left
    assert (tifffile().imread("pattern/s2.tif") == values[2]).all()
    ok("convert", "a.nrrd", "-o", "{stem}_%02d/{stem}_%02d.png".replace("_%02d/", "_all/"))
    assert seen("a_all")[-1] == "a_10.png"
    write_cells()
    ok("convert", "cells.nrrd", "-o", "cells_p/c%d_z%02d.png")
    assert seen("cells_p")[0] == "c0_z00.png" and len(seen("cells_p")) == 32
    ok("compare", "cells.nrrd", "cells_p", "--max-difference", "0")


def test_patterns_that_name_no_slices_are_refused():
    volume("a.nrrd", (3, 4, 5), "i2")
    write_cells()
    for name, words in (("p/a%d_%d.png", ("2 places for numbers", "1 is needed", "3 slices")),
                        ("p/a.png", ("-o FOLDER/", "slice_%03d.png")),
                        ("p/a%d.jpg", (".png or .tif",)),
                        ("p/a%d%s.png", ("'%s.p' is no place for a number",)),
                        ("p/a%3d.png", ("no place for a number", "%03d")),
                        ("a%d.png", ("a folder of their own",)),
                        ("p/a%d.png", ("i16", ".tif"))):
        says(fails(2, "convert", "a.nrrd", "-o", name), *words)
        assert not os.path.exists("p"), name
    says(fails(2, "convert", "cells.nrrd", "-o", "p/a%d.png"), "1 place", "2 are needed, in this order: 2 channels, 16 slices")
    says(fails(2, "convert", "a.nrrd", "-o", "p/a%d.tif", "--encoding", "png"), "--encoding says png")


def test_a_place_for_a_number_is_two_letters_of_a_name_where_no_slices_are_written():
    values = volume("a.nrrd", (3, 4, 5), "u1")
    os.mkdir("100%done")
    for name in ("100%d.nrrd", "a%03d_b.nii.gz", "a%d.npy", "a%d.zarr", "100%done/a.mhd", "a%d.h5"):
        ok("convert", "a.nrrd", "-o", name)
        assert os.path.exists(name)
        ok("compare", "a.nrrd", name, "--max-difference", "0")
    assert (numpy.load("a%d.npy") == values).all()
    ok("convert", "a.nrrd", "-o", "a%d.tif", "--output-format", "tiff")  # one file: it is asked for
    assert os.path.isfile("a%d.tif")
    ok("isosurface", "a.nrrd", "--iso", "5", "-o", "a%d.ply")
    says(fails(2, "convert", "a.nrrd", "-o", "p/a%d.ply"), "mesh")


def test_slices_that_are_there_are_replaced_only_when_that_is_asked_for():
    write_ball("a.nrrd", 8)
    for name in ("again/", "again_p/s%d.png"):
        ok("convert", "a.nrrd", "-o", name)
        says(fails(2, "convert", "a.nrrd", "-o", name), "is there already", "--overwrite")
        ok("convert", "a.nrrd", "-o", name, "--overwrite")
    with open("again_p/s99.png", "wb") as file:
        file.write(b"mine")  # a name like the others, that VolVis never wrote
    says(fails(5, "convert", "a.nrrd", "-o", "again_p/s%d.png", "--overwrite"), "'s99.png'", "is not replaced")
    os.mkdir("empty")
    ok("convert", "a.nrrd", "-o", "empty/s%d.png")


def test_a_disk_without_room_is_told_before_the_first_slice():
    about = os.statvfs(".")
    slices = 5 * about.f_bavail * about.f_frsize // 16384**2 + 1
    with open("huge.raw", "wb") as file:
        try:
            file.truncate(slices * 16384**2)
        except OSError:
            raise Skip("no sparse files as large as the disk") from None
    words = ["--raw", f"16384x16384x{slices},u8", "--limit", "voxels=1e18", "--limit", "dim=1e9"]
    said = volvis("convert", "huge.raw", "-o", "huge/", *words)
    os.remove("huge.raw")
    assert said.code == 5, (said.code, said.message)
    says(said.message, "huge/: its disk has", "free", "make room")
    assert not os.path.exists("huge") and not [name for name in os.listdir(".") if ".part" in name]


main()
