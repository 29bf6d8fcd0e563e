"""TIFF as an independent program writes and reads it: tifffile.

Usage: oracle_tiff.py IO_TOOL [SHARED_DATA]. Exit 77 (skipped) without tifffile.
"""
import itertools
import os
import sys
import zipfile
from xml.etree import ElementTree

try:
    import numpy as np
    import tifffile
except ImportError:
    print("numpy or tifffile is missing: skipped")
    sys.exit(77)
from served import Tool, workplace

tool = Tool(sys.argv[1])
shared = sys.argv[2] if len(sys.argv) > 2 else ""
# each size along each axis, beside each size along the next
SIZES = [(a, b, (1, 2, 3, 5, 7)[(i + j) % 5]) for i, a in enumerate((1, 2, 3, 5, 7))
         for j, b in enumerate((1, 2, 3, 5, 7))]
failures = 0
checks = 0


def expect(condition, what):
    global failures, checks
    checks += 1
    if not condition:
        failures += 1
        print("FAILED:", what)


def formula(shape, dtype, seed=1):
    dtype = np.dtype(dtype)
    rng = np.random.default_rng(seed)
    if dtype.kind == "f":
        return rng.normal(size=shape).astype(dtype)
    info = np.iinfo(dtype)
    low, high = max(info.min, -2**52), min(info.max, 2**52)
    return np.asarray(rng.integers(low, high, size=shape, endpoint=True), dtype=dtype)


def same(info, values, expected, what):
    """expected: [t, z, y, x, c]."""
    if info is None:
        expect(False, f"{what}: {values}")
        return
    expect(values.shape == expected.shape, f"{what}: {values.shape} instead of {expected.shape}")
    if values.shape == expected.shape:
        expect(np.array_equal(values, expected, equal_nan=values.dtype.kind == "f"), what + ": other samples")


def check_dialects(folder):
    """Types x byte orders x compressions x tiles or strips x BigTIFF: stacks of pages."""
    path = os.path.join(folder, "a.tif")
    types = ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f2", "f4", "f8"]
    codings = [("none", None), ("deflate", None), ("deflate", True), ("lzma", None)]
    layouts = [(None, None, False), (None, 5, True), ((16, 32), None, False)]
    for number, (dtype, order, (coding, predictor)) in enumerate(itertools.product(types, "<>", codings)):
        data = formula((3, 37, 53), dtype)
        for tile, rows, big in [layouts[number % 3]]:
            what = f"{dtype} {order} {coding} predictor {predictor} tile {tile} rows {rows} big {big}"
            if predictor and (data.dtype.itemsize == 8 or data.dtype.kind == "f"):
                continue  # not what tifffile writes by itself
            tifffile.imwrite(path, data, byteorder=order, compression=None if coding == "none" else coding,
                             predictor=predictor, tile=tile, rowsperstrip=rows, bigtiff=big,
                             photometric="minisblack", metadata=None)
            info, values = tool.read(path)
            same(info, values, data[None, ..., None], what)


def check_sizes(folder):
    path = os.path.join(folder, "s.tif")
    for n in SIZES:
        if n[2] == 1 and n[1] > 1:
            continue  # tifffile turns such pages
        data = formula(n, "u2")
        with tifffile.TiffWriter(path) as tif:  # else axes of one sample are left out
            for page in data:
                tif.write(page[None, ..., None], photometric="minisblack", metadata=None, contiguous=False)
        same(*tool.read(path), data[None, ..., None], f"size {n}")


def check_colors(folder):
    path = os.path.join(folder, "c.tif")
    for dtype, planar, tile, coding, order in itertools.product(
            ["u1", "u2"], ["contig", "separate"], [None, (16, 16)], [None, "deflate"], ">"):
        for n, meaning in ((3, 1), (4, 2)):
            shape = (2, 21, 35, n) if planar == "contig" else (2, n, 21, 35)
            data = formula(shape, dtype)
            tifffile.imwrite(path, data, photometric="rgb", planarconfig=planar, tile=tile, compression=coding,
                             byteorder=order, metadata=None, extrasamples=["unassalpha"] if n == 4 else None)
            info, values = tool.read(path)
            expected = data if planar == "contig" else data.transpose(0, 2, 3, 1)
            what = f"colours {n} {dtype} {planar} {tile} {coding} {order}"
            same(info, values, expected[None], what)
            expect(info is None or info["meaning"] == meaning, what + ": meaning")
    data = formula((2, 21, 35, 2), "u1")
    tifffile.imwrite(path, data, photometric="minisblack", planarconfig="contig", extrasamples=["unassalpha"],
                     metadata=None)
    same(*tool.read(path), data[None], "grey and alpha")


def check_bits(folder):
    """Bits packed, as Pillow and tifffile write them."""
    path = os.path.join(folder, "b.tif")
    bits = formula((3, 21, 35), "u1") > 100
    tifffile.imwrite(path, bits, photometric="minisblack", metadata=None)
    same(*tool.read(path), bits[None, ..., None], "one bit")
    try:
        from PIL import Image
    except ImportError:
        return
    for coding in ("group3", "group4", "tiff_ccitt", "packbits", "raw"):
        Image.fromarray(bits[0]).save(path, compression=coding)
        theirs = np.array(Image.open(path))
        same(*tool.read(path), theirs[None, None, ..., None], f"Pillow {coding}")


def check_pillow(folder):
    """The compressions of libtiff, through Pillow."""
    path = os.path.join(folder, "p.tif")
    try:
        from PIL import Image
    except ImportError:
        return
    for dtype, coding, predictor in itertools.product(
            ["u1", "u2", "i4", "f4"], ["tiff_lzw", "packbits", "tiff_adobe_deflate", "tiff_deflate", "zstd", "lzma"],
            [1, 2, 3]):
        if (predictor == 2 and dtype == "f4") or (predictor == 3 and dtype != "f4") or \
                (predictor > 1 and coding == "packbits"):
            continue
        data = formula((3, 37, 53), dtype)
        pages = [Image.fromarray(page) for page in data]
        pages[0].save(path, save_all=True, append_images=pages[1:], compression=coding, tiffinfo={317: predictor})
        same(*tool.read(path), data[None, ..., None], f"Pillow {dtype} {coding} predictor {predictor}")
    for mode in ("L", "RGB", "YCbCr", "CMYK"):
        smooth = np.add.outer(np.arange(40), np.arange(56)).astype("u1") * 2
        Image.fromarray(smooth).convert(mode).save(path, compression="jpeg", quality=90)
        info, values = tool.read(path)
        theirs = np.array(Image.open(path).convert("RGB" if mode == "YCbCr" else mode)).reshape(1, 1, 40, 56, -1)
        expect(info is not None and values.shape == theirs.shape and np.abs(values - theirs).max() <= 3,
               f"Pillow JPEG {mode}: {values if info is None else np.abs(values - theirs).max()}")


def check_imagej(folder):
    path = os.path.join(folder, "i.tif")
    for t, z, c in itertools.product((1, 2), (1, 3), (1, 2)):
        data = formula((t, z, c, 11, 13), "u2")
        tifffile.imwrite(path, data, imagej=True, resolution=(4.0, 5.0),
                         metadata={"axes": "TZCYX", "spacing": 0.75, "unit": "um", "finterval": 2.5})
        info, values = tool.read(path)
        same(info, values, data.transpose(0, 1, 3, 4, 2), f"ImageJ t {t} z {z} c {c}")
        if info:
            expect(info["unit"] == "um", "ImageJ: unit " + info["unit"])
            steps = [info["columns"][i][i] for i in range(3)]
            expect(np.allclose(steps, [0.25, 0.2, 0.75]), f"ImageJ: steps {steps}")


def lut(*last):
    """A ramp from black, as [3, 256]."""
    return np.stack([np.arange(256) * v // 255 for v in last]).astype("u1")


def check_imagej_extras(folder):
    """Tags 50838 and 50839: names of channels, colours, ranges and texts; lies about them leave the samples alone."""
    path = os.path.join(folder, "e.tif")
    data = formula((2, 3, 2, 11, 13), "u2")
    fire = np.stack([np.arange(256), np.arange(256)[::-1], np.zeros(256)]).astype("u1")
    extras = {"Labels": ["GFP", "Zellkern \u00df\u03bc"] * 6, "LUTs": [lut(0, 255, 0), lut(255, 0, 128)],
              "Ranges": (10.0, 1000.0, 0.5, 60000.25), "Info": "Objective = 40x\nOperator: me\nno key\n"}
    for order in "<>":
        tifffile.imwrite(path, data, imagej=True, byteorder=order, metadata={"axes": "TZCYX", **extras})
        info, values = tool.read(path)
        same(info, values, data.transpose(0, 1, 3, 4, 2), "extras " + order)
        green, pink = info["channels"]
        expect([green[0], pink[0]] == extras["Labels"][:2], f"extras: names {info['channels']}")
        expect(green[1:4] == [0, 1, 0] and np.allclose(pink[1:4], [1, 0, srgb(128)], atol=1e-5), f"colours {pink}")
        expect(green[4:] + pink[4:] == list(extras["Ranges"]), f"extras: ranges {green} {pink}")
        said = tool.ask("notes", path)[1]
        expect("Objective: 40x\n" in said and "Operator: me\n" in said, f"extras: info {said}")
    tifffile.imwrite(path, data, imagej=True, metadata={"axes": "TZCYX", "LUTs": [lut(99, 99, 99), fire]})
    expect(tool.read(path)[0]["channels"] == [], "grey and a table of colours are no colours of channels")
    tifffile.imwrite(path, data, imagej=True, metadata={"axes": "TZCYX", "Labels": [f"plane {i}" for i in range(12)]})
    said = tool.ask("notes", path)[1]
    expect("slice labels: plane 0; plane 1; " in said and tool.read(path)[0]["channels"] == [], f"labels {said}")
    tifffile.imwrite(path, data, imagej=True, metadata={"axes": "TZCYX", **extras})
    with tifffile.TiffFile(path) as tif:
        at = tif.pages[0].tags[50839].valueoffset
        lengths = tif.pages[0].tags[50838].valueoffset
    with open(path, "rb") as f:
        good = bytearray(f.read())
    for where in [*range(at, at + 40), *range(lengths, lengths + 24)]:
        for value in (0, 1, 127, 255):
            bad = bytearray(good)
            bad[where] = value
            with open(path, "wb") as f:
                f.write(bad)
            same(*tool.read(path), data.transpose(0, 1, 3, 4, 2), f"byte {where} of the extras is {value}")


def check_written_extras(folder):
    source, path, back = (os.path.join(folder, name) for name in ("e.tif", "f.tif", "g.ome.tif"))
    extras = {"Labels": ["GFP", "\u00df"] * 6, "LUTs": [lut(0, 255, 0), lut(255, 0, 128)], "Ranges": (10.0, 1000.0, 0.5, 6.25)}
    tifffile.imwrite(source, formula((2, 3, 2, 11, 13), "u2"), imagej=True, metadata={"axes": "TZCYX", **extras})
    for big, coding in itertools.product((False, True), ("raw", "deflate")):
        copy(source, path, coding, *(["big"] if big else []))
        with tifffile.TiffFile(path) as tif:
            theirs = tif.imagej_metadata
            expect(np.array_equal(tif.asarray(), tifffile.imread(source)), "written extras: samples")
        expect(theirs.get("Labels") == extras["Labels"] and theirs.get("Ranges") == extras["Ranges"], f"written: {theirs}")
        expect(np.abs(np.array(theirs["LUTs"]).astype(int) - extras["LUTs"]).max() <= 1, "written extras: colours")
        expect(tool.read(path)[0]["channels"] == tool.read(source)[0]["channels"], "written extras by us")
    copy(path, back)
    names = [c[0] for c in tool.read(back)[0]["channels"]]
    expect(names == ["GFP", "\u00df"], f"extras to OME {names}")


def check_written_time(folder):
    """A step keeps its time, and none is made up."""
    source = os.path.join(folder, "t.nrrd")
    data = formula((3, 2, 5, 7, 1), "u1")
    for unit, step, seconds in (("s", 2.5, 2.5), ("ms", 40, 0.04), ("us", 3, 3e-6), ("min", 2, 120), ("h", 1, 3600), ("", 1, 0),
                                ("", 2.5, 2.5), ("", 0, 0), ("Hz", 3, 3)):  # the last as our own texts
        with open(source, "wb") as f:
            f.write(("NRRD0005\ncontent: a name\ntype: uint8\ndimension: 4\nsizes: 7 5 2 3\nkinds: domain domain domain time\n" +
                     (f"spacings: nan nan nan {step}\n" if step else "") + (f'units: "" "" "" "{unit}"\n' if unit else "") +
                     "encoding: raw\n\n").encode() + data.tobytes())
        for name in ("t.tif", "t.ome.tif"):
            path = os.path.join(folder, name)
            copy(source, path)
            info = tool.read(path)[0]
            expect(info["name"] == "a name", f"{name}: name {info['name']}")
            scale = {"": 1, "s": 1, "ms": 1e-3, "us": 1e-6, "min": 60, "h": 3600, "Hz": 1}[info["step_unit"]]
            expect(unit != "Hz" or info["step_unit"] == unit, f"{name}: a step in {info['step_unit']}")
            expect(np.isclose(info["step"] * scale, seconds, rtol=1e-12) and (seconds > 0 or info["step_unit"] == ""),
                   f"{name}: {step} {unit} became {info['step']} {info['step_unit']}")


def srgb(code):
    code /= 255
    return code / 12.92 if code <= 0.04045 else ((code + 0.055) / 1.055) ** 2.4


def check_ome(folder):
    path = os.path.join(folder, "e.ome.tif")
    orders = ["TZCYX", "TCZYX", "ZTCYX", "ZCTYX", "CTZYX", "CZTYX"]
    for number, (axes, (t, z, c)) in enumerate(itertools.product(orders, ((1, 3, 2), (2, 3, 1), (2, 1, 3), (2, 3, 4)))):
        coding = "deflate" if number % 3 == 0 else None
        shape = {"T": t, "Z": z, "C": c, "Y": 11, "X": 13}
        data = formula([shape[a] for a in axes], "u2")
        names = [f"dye {i}" for i in range(c)]
        colors = [(255 << 24 | i * 40 << 16 | 7 << 8 | 255) - (1 << 32) for i in range(c)]
        tifffile.imwrite(path, data, compression=coding, photometric="minisblack", metadata={
            "axes": axes, "PhysicalSizeX": 0.25, "PhysicalSizeXUnit": "\u00b5m", "PhysicalSizeY": 300.0,
            "PhysicalSizeYUnit": "nm", "PhysicalSizeZ": 1.5, "TimeIncrement": 40.0, "TimeIncrementUnit": "ms",
            "SignificantBits": 12, "Channel": {"Name": names, "Color": colors}})
        what = f"OME {axes} {t} {z} {c} {coding}"
        info, values = tool.read(path)
        same(info, values, data.transpose([axes.index(a) for a in "TZYXC"]), what)
        if not info:
            continue
        expect(info["unit"] == "um", what + ": unit " + info["unit"])
        steps = [info["columns"][i][i] for i in range(3)]
        expect(np.allclose(steps, [0.25, 0.3, 1.5]), f"{what}: steps {steps}")
        if t > 1:
            expect(info["step"] == 40 and info["step_unit"] == "ms", f"{what}: {info['step']} {info['step_unit']}")
        expect([row[0] for row in info["channels"]] == names, f"{what}: {info['channels']}")
        for i, row in enumerate(info["channels"]):
            expect(np.allclose(row[1:4], [1, srgb(i * 40), srgb(7)], atol=1e-5), f"{what}: colour {row}")
    data = formula((3, 11, 13, 3), "u1")
    tifffile.imwrite(path, data, photometric="rgb", metadata={"axes": "ZYXS"}, ome=True)
    info, values = tool.read(path)
    same(info, values, data[None], "OME RGB")
    check_ome_images(folder)


def check_ome_images(folder):
    """Several images in one file; one image in several files."""
    path = os.path.join(folder, "p.ome.tif")
    first, second = formula((3, 11, 13), "u2"), formula((2, 4, 8, 9), "u1")
    with tifffile.TiffWriter(path, ome=True) as tif:
        tif.write(first, photometric="minisblack", metadata={"axes": "ZYX", "Name": "one"})
        tif.write(second, photometric="minisblack", metadata={"axes": "CZYX", "Name": "two"})
    same(*tool.read(path), first[None, ..., None], "first image")
    for part in ("two", "Image:1"):
        same(*tool.read(path, part), second.transpose(1, 2, 3, 0)[None], "second image")
    info, error = tool.read(path, "three")
    expect(info is None and "no image 'three'" in error, "third image")
    pixels = ('<Pixels ID="Pixels:0" DimensionOrder="XYZCT" Type="uint16" SizeX="13" SizeY="11" SizeZ="3" SizeC="2" '
              'SizeT="1"><Channel ID="Channel:0:0"/><Channel ID="Channel:0:1"/>')
    for c in range(2):
        pixels += f'<TiffData FirstC="{c}" IFD="0" PlaneCount="3"><UUID FileName="m{c}.ome.tif">urn:uuid:{c}</UUID></TiffData>'
    head = '<OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06" UUID="urn:uuid:%d">'
    data = formula((2, 3, 11, 13), "u2")
    for c in range(2):
        xml = head % c + '<Image ID="Image:0">' + pixels + "</Pixels></Image></OME>"
        tifffile.imwrite(os.path.join(folder, f"m{c}.ome.tif"), data[c], photometric="minisblack", description=xml,
                         metadata=None, compression="deflate" if c else None)
    for c in range(2):
        same(*tool.read(os.path.join(folder, f"m{c}.ome.tif")), data.transpose(1, 2, 3, 0)[None], f"file set {c}")
    xml = head % 7 + '<Image ID="Image:0">' + pixels + "</Pixels></Image></OME>"
    with open(os.path.join(folder, "set.companion.ome"), "w", encoding="utf-8") as f:
        f.write(xml)
    only = head % 0 + '<BinaryOnly MetadataFile="set.companion.ome" UUID="urn:uuid:7"/></OME>'
    tifffile.imwrite(os.path.join(folder, "m0.ome.tif"), data[0], photometric="minisblack", description=only,
                     metadata=None)
    same(*tool.read(os.path.join(folder, "m0.ome.tif")), data.transpose(1, 2, 3, 0)[None], "companion file")
    os.remove(os.path.join(folder, "m0.ome.tif"))
    info, values = tool.read(os.path.join(folder, "m1.ome.tif"))
    expect(info is not None and np.array_equal(values[0, ..., 1], data[1]) and not values[0, ..., 0].any(),
           "half of a file set")


def check_others(folder):
    path = os.path.join(folder, "o.tif")
    data = formula((4, 32, 32), "u1")
    with tifffile.TiffWriter(path) as tif:  # each page with a smaller copy, and one page of another size
        for page in data:
            tif.write(page, subifds=1, metadata=None, photometric="minisblack")
            tif.write(page[::2, ::2], subfiletype=1, metadata=None, photometric="minisblack")
        tif.write(page[:7], metadata=None, photometric="minisblack")
        tif.write(page[::4, ::4], subfiletype=1, metadata=None, photometric="minisblack")
    same(*tool.read(path), data[None, ..., None], "pyramid")


def check_shared(folder):
    """Every real file: samples and spacing."""
    real = os.path.join(shared, "data", "formats", "tiff")
    if not shared or not os.path.isdir(real):
        print("no shared data: real files are left out")
        return
    for name in sorted(os.listdir(real)):
        path = os.path.join(real, name)
        if name.endswith(".zip"):
            with zipfile.ZipFile(path) as z:
                member = next(m for m in z.namelist() if m.endswith(".tif") and not m.startswith("__"))
                path = z.extract(member, folder)
        elif not name.endswith(".tif"):
            continue
        with tifffile.TiffFile(path) as tif:
            series = tif.series[0]
            axes = {"Q": "Z", "I": "Z"}.get(series.axes[0], series.axes[0]) + series.axes[1:]
            data = series.asarray().reshape([dict(zip(axes, series.shape)).get(a, 1) for a in
                                             [c for c in axes if c in "TZC"] + ["Y", "X"]])
            order = [c for c in axes if c in "TZC"] + ["Y", "X"]
        for a in "TZC":
            if a not in order:
                data, order = data[None], [a] + order
        same(*tool.narrow(path), data.transpose([order.index(a) for a in "TZYXC"]), "shared " + name)


KINDS = {"u1": "uint8", "i1": "int8", "u2": "uint16", "i2": "int16", "u4": "uint32", "i4": "int32", "u8": "uint64",
         "i8": "int64", "f4": "float", "f8": "double"}


def nrrd(path, data, unit="", kind="list"):
    """data: [t, z, y, x, c]."""
    t, z, y, x, c = data.shape
    space = ("space dimension: 3\nspace directions: none (0.25,0,0) (0,0.3,0) (0,0,1.5) none\n"
             "space units: \"%s\" \"%s\" \"%s\"\n" % (unit, unit, unit)) if unit else ""
    steps = 'spacings: nan nan nan nan 2.5\nunits: "" "" "" "" "s"\n' if unit and t > 1 else ""
    with open(path, "wb") as f:
        f.write(("NRRD0005\ntype: %s\ndimension: 5\n%ssizes: %d %d %d %d %d\n%skinds: %s domain domain domain time\n"
                 "encoding: raw\nendian: little\n\n" %
                 (KINDS[data.dtype.str[1:]], space, c, x, y, z, t, steps, kind)).encode())
        f.write(data.astype(data.dtype.newbyteorder("<")).tobytes())


def copy(source, path, *words):
    code, _, error = tool.ask("copy", source, path, *words)
    expect(code == 0, f"copy to {path} {words}: {error}")
    return code == 0


def by_pillow(path, what, data):
    """data: [z, y, x]."""
    try:
        from PIL import Image
    except ImportError:
        return
    with Image.open(path) as image:
        for z, page in enumerate(data):
            image.seek(z)
            expect(np.array_equal(np.array(image), page), what + ": Pillow reads other samples")


def check_written(folder):
    source = os.path.join(folder, "w.nrrd")
    for number, (dtype, coding, big, ome) in enumerate(itertools.product(
            KINDS, ["raw", "deflate", "lzw", "zstd"], (False, True), (False, True))):
        if (ome and dtype in ("u8", "i8")) or (number % 3 and coding != "lzw"):
            continue
        path = os.path.join(folder, "w.ome.tif" if ome else "w.tif")
        t, z, c = [(1, 3, 1), (2, 3, 1), (1, 3, 2), (2, 1, 3), (2, 2, 2)][number % 5]
        y, x = (37, 53) if number % 5 else (151, 257)
        data = formula((t, z, y, x, c), dtype, number)
        if number % 2:
            data = np.sort(data, axis=3)  # repeats for the compressors
        nrrd(source, data, "um")
        what = f"written {dtype} {coding} big-endian {big} OME {ome} {t} {z} {c}"
        if not copy(source, path, coding, *(["big"] if big else [])):
            continue
        info, values = tool.read(path)
        same(info, values, data, what + " by us")
        if info:
            expect(info["type"] == {"u": "u", "i": "i", "f": "f"}[dtype[0]] + str(int(dtype[1]) * 8), what + ": type")
            steps = [info["columns"][i][i] for i in range(3)]
            expect(info["unit"] == "um" and np.allclose(steps, [0.25, 0.3, 1.5], rtol=1e-8), f"{what}: {steps}")
            expect(t == 1 or info["step"] == 2.5, f"{what}: time step {info['step']}")
        with tifffile.TiffFile(path) as tif:
            expect(tif.byteorder == (">" if big else "<"), what + ": byte order")
            expect(tif.is_ome if ome else tif.is_imagej, what + ": tifffile sees no dialect")
            series = tif.series[0]
            expected = data.transpose(0, 1, 4, 2, 3)
            if coding in ("raw", "deflate"):
                expect(np.array_equal(series.asarray().reshape(expected.shape), expected), what + ": tifffile")
            expect(series.axes.replace("Q", "") == "".join(a for a, n in zip("TZC", (t, z, c)) if n > 1) + "YX",
                   f"{what}: axes {series.axes}")
        if t * c == 1 and dtype in ("u1", "u2", "f4") and not (big and dtype == "f4"):
            by_pillow(path, what, data[0, ..., 0])


def check_written_sizes(folder):
    source, path = os.path.join(folder, "n.nrrd"), os.path.join(folder, "n.tif")
    for n in SIZES:
        data = formula((1, *n, 1), "u2", sum(n))
        nrrd(source, data)
        for coding in ("raw", "lzw")[n[0] % 2:][:1]:
            if copy(source, path, coding):
                info, values = tool.read(path)
                same(info, values, data, f"written size {n} {coding}")
                expect(info["unit"] == "voxels", f"written size {n}: {info['unit']}")
            if coding == "raw":
                expect(np.array_equal(tifffile.imread(path).reshape(data.shape), data), f"size {n} by tifffile")


def check_written_colors(folder):
    source = os.path.join(folder, "c.nrrd")
    for c, dtype, coding, name in itertools.product((3, 4), ("u1", "u2"), ("raw", "deflate"), ("c.tif", "c.ome.tif")):
        path = os.path.join(folder, name)
        data = formula((1, 3, 37, 53, c), dtype)
        nrrd(source, data, "", "RGB-color" if c == 3 else "RGBA-color")
        what = f"written colours {c} {dtype} {coding} {name}"
        if copy(source, path, coding):
            info, values = tool.read(path)
            same(info, values, data, what)
            expect(info is None or info["meaning"] == (1 if c == 3 else 2), what + ": meaning")
            expect(np.array_equal(tifffile.imread(path).reshape(data.shape), data), what + ": tifffile")


def write_placed(path, data, axes, origin, more=""):
    """data: [t, z, y, x, c]; axes: steps along x, y, z in RAS millimetres."""
    t, z, y, x, c = data.shape
    vectors = " ".join("(" + ",".join(repr(float(v)) for v in a) + ")" for a in axes)
    with open(path, "wb") as f:
        f.write((f"NRRD0005\ntype: uint16\ndimension: 5\nspace: RAS\nsizes: {c} {x} {y} {z} {t}\n"
                 f"kinds: {'vector' if c == 3 else 'list'} domain domain domain time\n"
                 f"space directions: none {vectors} none\nspace origin: ({','.join(repr(float(v)) for v in origin)})\n"
                 f'space units: "mm" "mm" "mm"\nendian: little\nencoding: raw\n{more}\n').encode())
        f.write(data.astype("<u2").tobytes())


def check_turned(folder):
    """All orders of axes: samples along the world's axes for other programs, the placement exact for us."""
    source = os.path.join(folder, "o.nrrd")
    a, b = np.cos(0.3), np.sin(0.3)
    worlds = (np.eye(3), np.array([[a, -b, 0], [b, a, 0], [0, 0, 1]]))
    spacing, corner = np.array((0.5, 0.7, 1.1)), np.array((-7.25, 3.1, 1e-3))
    shapes = ((1, 1), (2, 2), (1, 3))  # time steps, components
    for number, (order, signs) in enumerate(itertools.product(itertools.permutations(range(3)),
                                                              itertools.product((1, -1), repeat=3))):
        turn, (t, c) = worlds[number % 2], shapes[number % 3]
        data = formula((t, 3, 5, 7, c), "u2", number)  # along the world's axes
        stored = data.transpose(0, *[3 - order[2 - k] for k in range(3)], 4)
        stored = np.flip(stored, [3 - k for k in range(3) if signs[k] < 0])
        steps = turn * spacing  # columns
        axes = [steps[:, order[k]] * signs[k] for k in range(3)]
        last = [stored.shape[3 - k] - 1 for k in range(3)]
        origin = corner - sum(axes[k] * last[k] for k in range(3) if signs[k] < 0)
        write_placed(source, stored, axes, origin)
        for name in ("o.tif", "o.ome.tif"):
            path, what = os.path.join(folder, name), f"turned {order} {signs} oblique {number % 2} {t} {c} {name}"
            if not copy(source, path, "raw" if number % 4 else "deflate"):
                expect(False, what)
                continue
            # axial slices that run to the left and back stay as they are, all others run to the right and front
            back = order[:2] == (0, 1) and signs[:2] == (-1, -1)
            seen = data[:, :, ::-1, ::-1] if back else data
            along = steps * (-1, -1, 1) if back else steps
            begin = corner + (steps[:, 0] * 6 + steps[:, 1] * 4 if back else 0)
            info, values = tool.read(path)
            same(info, values, seen, what)
            if info:
                expect(np.allclose(np.array(info["columns"][:3]).T, along, rtol=0, atol=1e-15), f"{what}: {info['columns']}")
                expect(np.allclose(info["columns"][3], begin, rtol=0, atol=1e-14), f"{what}: {info['columns'][3]}")
                expect(info["space"] == 1 and info["unit"] == "mm", f"{what}: {info}")
            theirs = tifffile.imread(path).reshape(t, 3, c, 5, 7)
            expect(np.array_equal(theirs, seen.transpose(0, 1, 4, 2, 3)), what + ": tifffile reads another order")


def check_own(folder):
    """What we keep beside the dialects: there for us, harmless to others, and never believed when it lies."""
    source = os.path.join(folder, "v.nrrd")
    axes, lies = np.diag((0.5, 0.5, 2.0)), (b"nan 0 0 0 0.5 0 0 0 2 1 2 3", b"0.5 0 0 1.5 00 0 0 0 2 1 2 3",
                                            b"0.5 0 0 0 0.5 0 0 0 2 1 2 ,", b"0.5 0 0 0 0.5 0 0 0 2 1 2  ",
                                            b"1 0 0 0 1 0 0 0 1 1 2 3 4", b"1e999 0 0 0 1 0 0 0 2 1 2 3")
    write_placed(source, formula((1, 3, 5, 7, 1), "u2"), axes, (1, 2, 3),
                 "volvis value scale:=0.25\nvolvis value offset:=-3\nvolvis meaning:=label\n")
    write_placed(os.path.join(folder, "s.nrrd"), formula((1, 3, 5, 7, 1), "u2"), axes, (1, 2, 3),
                 "volvis value scale:=0.25\nvolvis value offset:=-3\n")
    for name in ("s.tif", "s.ome.tif"):
        path = os.path.join(folder, name)
        expect(copy(os.path.join(folder, "s.nrrd"), path, "raw"), f"own {name}")
        info, _ = tool.read(path)
        expect(info["scale"] == 0.25 and info["offset"] == -3 and info["meaning"] == 0, f"own {name}: {info}")
    for name in ("v.tif", "v.ome.tif"):
        path = os.path.join(folder, name)
        expect(copy(source, path, "raw"), f"own {name}")
        info, values = tool.read(path)
        expect(info["scale"] == 1 and info["offset"] == 0 and info["meaning"] == 4, f"labels are numbers {name}: {info}")
        with tifffile.TiffFile(path) as tif:
            if tif.is_ome:
                root = ElementTree.fromstring(tif.ome_metadata)
                space = "{http://www.openmicroscopy.org/Schemas/OME/2016-06}"
                texts = {m.get("K"): m.text for m in root.iter(space + "M")}
                expect([e.tag.removeprefix(space) for e in root] == ["Image", "StructuredAnnotations"], "own: order of OME")
                expect(texts["placement"] == "0.5 0 0 0 0.5 0 0 0 2 1 2 3" and texts["space"] == "RAS", f"own: {texts}")
            else:
                expect(tif.imagej_metadata["volvis_space"] == "RAS" and tif.imagej_metadata["slices"] == 3, "own: ImageJ")
        with open(path, "rb") as f:
            good = f.read()
        truth = b"0.5 0 0 0 0.5 0 0 0 2 1 2 3"
        changes = [(truth, lie) for lie in lies] + [(b"7 5 3", b"5 7 3"), (b"7 5 3", b"7 5 2"), (b"7 5 3", b"7 5 x")]
        for old, lie in changes:
            expect(good.count(old) == 1, f"own {name}: {old}")
            with open(path, "wb") as f:
                f.write(good.replace(old, lie.ljust(len(old))[:len(old)]))
            info, lied = tool.read(path)
            expect(info is not None and np.array_equal(lied, values) and info["space"] == 0 and
                   info["columns"][3] == [0, 0, 0] and np.allclose(np.diag(info["columns"][:3]), (0.5, 0.5, 2)),
                   f"own {name} {lie}: {info}")


with workplace() as place:
    check_turned(place)
    check_own(place)
    check_dialects(place)
    check_sizes(place)
    check_colors(place)
    check_bits(place)
    check_pillow(place)
    check_imagej(place)
    check_imagej_extras(place)
    check_written_extras(place)
    check_written_time(place)
    check_ome(place)
    check_others(place)
    check_shared(place)
    check_written(place)
    check_written_sizes(place)
    check_written_colors(place)
failures += not tool.end()
print(checks, "checks,", failures, "failed")
sys.exit(1 if failures else 0)
