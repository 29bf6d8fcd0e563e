"""VTK reads the MetaImages that VolVis writes, VolVis reads those that VTK writes and those of other programs.

Usage: oracle_metaimage.py IO_TOOL. Exit 77 (skipped) without numpy or VTK. VTK does not read directions, so those
are compared with the header itself: a row of the matrix is an axis, in millimetres to the left, back and top.
"""
import itertools
import os
import sys
import zlib

try:
    import numpy as np
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkIOImage import vtkMetaImageReader, vtkMetaImageWriter
except ImportError as missing:
    print(f"{missing}: skipped")
    sys.exit(77)
from served import Tool, workplace

tool = Tool(sys.argv[1])
SHARED = os.environ.get("VOLVIS_SHARED", os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../../shared"))
TYPES = {"u1": "uint8", "i1": "int8", "u2": "uint16", "i2": "int16", "u4": "uint32", "i4": "int32", "u8": "uint64",
         "i8": "int64", "f4": "float", "f8": "double"}
MET = {"u1": "UCHAR", "i1": "CHAR", "u2": "USHORT", "i2": "SHORT", "u4": "UINT", "i4": "INT", "u8": "ULONG_LONG",
       "i8": "LONG_LONG", "f4": "FLOAT", "f8": "DOUBLE"}
checks = failures = 0


def expect(condition, what):
    global checks, failures
    checks += 1
    if not condition:
        failures += 1
        print("FAILED:", what)


def dump(path, read=tool.read):
    """The info and the values as [t, z, y, x, c]."""
    info, values = read(path)
    if info is None:
        expect(False, f"{path}: {values}")
        return None, None
    return info, values


def affine_of(info):
    out = np.eye(4)
    out[:3, :] = np.array(info["columns"]).T
    return out


def by_vtk(path):
    reader = vtkMetaImageReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    x, y, z = image.GetDimensions()
    scalars = image.GetPointData().GetScalars()
    return vtk_to_numpy(scalars).reshape(1, z, y, x, scalars.GetNumberOfComponents()), image


def header_of(path):
    keys = {}
    with open(path, "rb") as file:
        for line in file:
            key, value = line.decode("latin-1").split("=", 1)
            keys[key.strip()] = value.strip()
            if key.strip() == "ElementDataFile":
                return keys, file.tell()


def affine_of_header(keys):
    n = int(keys["NDims"])
    matrix = np.array(keys["TransformMatrix"].split(), "f8").reshape(n, n)[:3, :3]
    spacing = np.array(keys["ElementSpacing"].split(), "f8")[:3]
    lps = np.eye(4)
    lps[:3, :3] = matrix.T * spacing
    lps[:3, 3] = np.array(keys["Offset"].split(), "f8")[:3]
    return np.diag((-1.0, -1, 1, 1)) @ lps


def orientations():
    for order, signs in itertools.product(itertools.permutations(range(3)), itertools.product((1, -1), repeat=3)):
        affine = np.zeros((4, 4))
        for a in range(3):
            affine[order[a], a] = signs[a] * (0.7, 1.1, 2.3)[a]
        affine[:, 3] = (10, -20, 30.5, 1)
        yield affine


def write_nrrd(path, data, affine):
    """data: [z, y, x] or [z, y, x, c]."""
    sizes = data.shape[::-1]
    columns = [f"({affine[0, a]!r},{affine[1, a]!r},{affine[2, a]!r})" for a in range(3)]
    if data.ndim == 4:
        columns.insert(0, "none")
    head = ["NRRD0005", "type: " + TYPES[data.dtype.str[1:]], f"dimension: {data.ndim}",
            "space: right-anterior-superior", "sizes: " + " ".join(map(str, sizes)),
            "space directions: " + " ".join(columns), "space origin: (%r,%r,%r)" % tuple(map(float, affine[:3, 3])),
            "kinds: " + ("list " if data.ndim == 4 else "") + "domain domain domain", "endian: little", "encoding: raw"]
    with open(path, "wb") as file:
        file.write(("\n".join(head) + "\n\n").encode() + data.tobytes())


def copy(*words):
    code, _, error = tool.ask("copy", *words)
    expect(code == 0, f"{words}: {error}")


def check_written(folder):
    """All types, encodings, byte orders, odd sizes and orientations."""
    rng = np.random.default_rng(1994)
    types, shapes = list(TYPES), [(7, 5, 3), (1, 1, 1), (2, 3, 5, 3), (1, 13, 2), (3, 2, 1, 2), (5, 1, 7, 4)]
    for number, affine in enumerate(orientations()):
        kind, shape = types[number % 10], shapes[number % 6]
        data = (rng.random(shape) * 100).astype(kind)
        source, path = os.path.join(folder, "s.nrrd"), os.path.join(folder, f"w{number:02d}" + (".mhd", ".mha")[number % 2])
        write_nrrd(source, data, affine)
        copy(source, path, ("raw", "zlib")[number // 2 % 2], *(["big"] if number % 3 == 0 else []))
        keys, _ = header_of(path)
        expect(np.allclose(affine_of_header(keys), affine), path + ": another place is written")
        expect(keys["ElementType"] == "MET_" + MET[kind], path + ": " + keys["ElementType"])
        if kind not in ("u8", "i8"):  # VTK 9.1 does not know them
            theirs, image = by_vtk(path)
            expect(theirs.dtype.str[1:] == kind, f"{path}: VTK reads {theirs.dtype}")
            expect(np.array_equal(theirs.reshape(shape), data), path + ": VTK reads other samples")
            expect(np.allclose(image.GetSpacing(), (0.7, 1.1, 2.3)), path + ": VTK finds another spacing")
        info, ours = dump(path)
        if info:
            expect(np.array_equal(ours.reshape(shape), data.astype("f8")), path + ": we read other samples")
            expect(np.allclose(affine_of(info), affine), path + ": we find another place")
            expect(info["unit"] == "mm" and info["space"] == 1, path + ": unit or space")


def check_by_vtk(folder):
    """What VTK writes: types that it knows, both files, compressed and not."""
    rng = np.random.default_rng(7)
    number = 0
    for kind, zipped, suffix, parts in itertools.product(("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"), (0, 1),
                                                         (".mhd", ".mha"), (1, 3)):
        data = (rng.random((3, 5, 7, parts)) * 100).astype(kind)
        image = vtkImageData()
        image.SetDimensions(7, 5, 3)
        image.SetSpacing(0.5, 1.5, 2)
        image.SetOrigin(1, -2, 3)
        image.GetPointData().SetScalars(numpy_to_vtk(data.reshape(-1, parts), deep=True))
        path = os.path.join(folder, f"v{number:03d}{suffix}")
        number += 1
        writer = vtkMetaImageWriter()
        writer.SetInputData(image)
        writer.SetFileName(path)
        if suffix == ".mhd":
            writer.SetRAWFileName(path[:-4] + (".zraw" if zipped else ".raw"))
        writer.SetCompression(zipped)
        writer.Write()
        info, ours = dump(path)
        if info:
            expect(np.array_equal(ours[0], data.astype("f8")), f"{path}: {kind} differs")
            expect(np.allclose(np.diag(affine_of(info))[:3], (0.5, 1.5, 2)) and info["space"] == 0, path + ": place")


def put(folder, name, lines, data=b""):
    path = os.path.join(folder, name)
    with open(path, "wb") as file:
        file.write("\n".join(lines).encode() + b"\n" + data)
    return path


def check_dialects(folder):
    """Lists, patterns, header sizes, text, compressed slices, spellings: one volume written in many ways."""
    data = (np.arange(2 * 3 * 4).reshape(4, 3, 2) * 7 - 30).astype(">i2")
    base = ["NDims = 3", "DimSize = 2 3 4", "ElementType = MET_SHORT"]
    little = data.astype("<i2")
    for k in range(4):
        with open(os.path.join(folder, f"s{k + 1:02d}.raw"), "wb") as file:
            file.write(b"12345" + data[k].tobytes())
        with open(os.path.join(folder, f"z{10 - 2 * k}.zraw"), "wb") as file:
            file.write(zlib.compress(little[k].tobytes()))
    for name, blob in (("all.raw", b"head" * 9 + data.tobytes()), ("all.zraw", zlib.compress(little.tobytes())),
                       ("two1.raw", little[:2].tobytes()), ("two2.raw", little[2:].tobytes())):
        with open(os.path.join(folder, name), "wb") as file:
            file.write(blob)
    text = " ".join(map(str, data.ravel())).encode()
    big = ["BinaryDataByteOrderMSB = True"]
    cases = [
        base + big + ["HeaderSize = 5", "ElementDataFile = LIST", "s01.raw", "s02.raw", "s03.raw", "s04.raw"],
        base + big + ["HeaderSize = 5", "ElementDataFile = LIST 2", "s01.raw", "s02.raw", "s03.raw", "s04.raw"],
        base + big + ["HeaderSize = -1", "ElementDataFile = s%02d.raw 1 4 1"],
        base + big + ["HeaderSize = -1", "ElementDataFile = s%02d.raw"],
        base + ["CompressedData = True", "ElementDataFile = z%d.zraw 10 4 -2"],
        base + ["CompressedData = True", "CompressedDataSize = 3", "ElementDataFile = all.zraw"],
        base + ["ElementByteOrderMSB = True", "HeaderSize = -1", "ElementDataFile = all.raw"],
        base + big + ["HeaderSize = 36", "ElementDataFile = all.raw"],
        ["NDims = 4", "DimSize = 2 3 2 2", "ElementType = MET_SHORT", "ElementDataFile = LIST 3", "two1.raw", "two2.raw"],
        ["ndims: 3", "dimsize : 2 3 4", "ElementType=MET_SHORT_ARRAY", "CompressedData=yes", "",
         "elementdatafile = all.zraw"],
    ]
    for number, lines in enumerate(cases):
        info, ours = dump(put(folder, f"d{number}.mhd", lines))
        if info:
            expect(np.array_equal(ours.reshape(4, 3, 2), data.astype("f8")), f"{lines}: other samples")
    for lines, tail in ((["BinaryData = False"], text), (["CompressedData = False"], little.tobytes()),
                        (["CompressedData = True"], zlib.compress(little.tobytes()) + b"behind it"), (big, data.tobytes())):
        info, ours = dump(put(folder, "l.mha", base + lines + ["ElementDataFile = LOCAL"], tail))
        if info:
            expect(np.array_equal(ours.reshape(4, 3, 2), data.astype("f8")), f"{lines}: other samples")


def check_shared():
    root = os.path.join(SHARED, "data")
    if not os.path.isdir(root):
        print(f"{root} is not there: its files are skipped")
        return
    meta = os.path.join(root, "formats/metaimage")
    for name in ("BigEndian.mhd", "BinarySquare3D.mhd", "HeadMRVolume.mhd", "HeadMRVolume.mha", "VHFColor.mhd",
                 "HeadMRVolumeCompressed.mha", "HeadMRVolumeWithDirection.mhd", "../../volumes/frogtissue.mhd"):
        path = os.path.join(meta, name)
        info, ours = dump(path, tool.narrow)
        theirs, image = by_vtk(path)
        if "frog" in name:  # its CompressedDataSize is too small: VTK leaves the last slices out
            with open(path[:-3] + "zraw", "rb") as file:
                theirs = np.frombuffer(zlib.decompress(file.read()), "u1").reshape(theirs.shape)
        if info:
            expect(np.array_equal(ours, theirs), name + ": VTK reads other samples")
            spacing = np.linalg.norm(affine_of(info)[:3, :3], axis=0)
            expect(np.allclose(spacing, image.GetSpacing()), name + ": spacing")
    info, ours = dump(os.path.join(meta, "SmallRampVolumeList.mhd"))
    expect(info and np.array_equal(ours.ravel(), np.arange(216)), "the list of slices is no ramp")
    turned, _ = dump(os.path.join(meta, "HeadMRVolumeWithDirection.mhd"))
    nrrd, _ = dump(os.path.join(root, "formats/nrrd/HeadMRVolumeWithDirection.nhdr"))
    expect(turned and nrrd and np.allclose(turned["columns"], nrrd["columns"], atol=1e-4), "the same head lies elsewhere")
    code, _, error = tool.ask("dump", os.path.join(meta, "MetaImageError.mhd"), os.devnull)
    expect(code == 1 and "Error.raw" in error, "MetaImageError.mhd: " + error)


with workplace() as folder:
    check_written(folder)
    check_by_vtk(folder)
    check_dialects(folder)
    check_shared()
failures += not tool.end()
print(f"{checks} checks, {failures} failed")
sys.exit(1 if failures else 0)
