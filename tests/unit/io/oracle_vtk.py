"""VolVis reads what VTK writes, in every dialect of it, and VTK reads what VolVis writes.

Usage: oracle_vtk.py IO_TOOL. Exit 77 (skipped) without VTK's Python modules. Real files, where there are any, are
compared with what VTK's own readers make of them.
"""
import itertools
import json
import os
import sys

try:
    import numpy as np
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
except ImportError:
    print("numpy or VTK is missing: skipped")
    sys.exit(77)
from served import Tool, workplace

vtk.vtkObject.GlobalWarningDisplayOff()
tool = Tool(sys.argv[1])
failures = 0
checks = 0
rng = np.random.default_rng(1994)
TYPES = "u1 i1 u2 i2 u4 i4 u8 i8 f4 f8".split()


def expect(condition, what):
    global failures, checks
    checks += 1
    if not condition:
        failures += 1
        print("FAILED:", what)


def dump(path, part=None):
    """What VolVis reads: info, and samples as [z, y, x, c]."""
    info, values = tool.narrow(path, part or "")
    if info is None:
        expect(False, f"{path} is not read: {values}")
        return None, None
    return info, values.reshape(values.shape[1:])


def samples(shape, dtype):
    dtype = np.dtype(dtype)
    if dtype.kind == "f":
        return (rng.random(shape) * 2000 - 1000).astype(dtype)
    top = min(np.iinfo(dtype).max, 2**52)
    return rng.integers(max(np.iinfo(dtype).min, -(2**52)), top, shape, dtype="i8").astype(dtype)


def array(data, name):
    """data: [..., c]"""
    a = numpy_to_vtk(np.ascontiguousarray(data.reshape(-1, data.shape[-1])), deep=True)
    a.SetName(name)
    return a


def image(dims, dtype, components=1, first=(0, 0, 0), cells=False, direction=None):
    """A vtkImageData with one array 'a' of random samples, and these as [z, y, x, c]."""
    out = vtk.vtkImageData()
    out.SetExtent(*(v for f, n in zip(first, dims) for v in (f, f + n - 1)))
    out.SetSpacing(0.7, 1.1, 2.3)
    out.SetOrigin(10, -20, 30.5)
    if direction is not None:
        out.SetDirectionMatrix(*np.asarray(direction, "f8").ravel())
    n = [max(1, d - 1) for d in dims] if cells else dims
    data = samples((n[2], n[1], n[0], components), dtype)
    (out.GetCellData() if cells else out.GetPointData()).SetScalars(array(data, "a"))
    return out, data


def place_of(out, first, cells=False):
    """Position of the first sample and the steps, as VTK tells them."""
    index = np.array([f + (0.5 if cells else 0) for f in first], "f8")
    points = [out_point(out, index + step) for step in np.vstack([np.zeros(3), np.eye(3)])]
    return points[0], [p - points[0] for p in points[1:]]


def out_point(out, index):
    p = [0.0, 0.0, 0.0]
    out.TransformContinuousIndexToPhysicalPoint(index, p)
    return np.array(p)


def check(path, data, origin, steps, part=None):
    info, ours = dump(path, part)
    if info is None:
        return
    expect(ours.shape == data.shape and np.array_equal(ours, data, equal_nan=ours.dtype.kind == "f"), path + ": other samples")
    columns = np.array(info["columns"])
    expect(np.allclose(columns[3], origin, atol=1e-9), f"{path}: begins at {columns[3]}, not {origin}")
    expect(np.allclose(columns[:3], steps, atol=1e-9), f"{path}: has steps {columns[:3]}, not {steps}")


def write_xml(writer, data, path, mode, compressor, word, order, block=0, pieces=1):
    writer.SetFileName(path)
    writer.SetInputData(data)
    getattr(writer, "SetDataModeTo" + {"ascii": "Ascii", "binary": "Binary"}.get(mode, "Appended"))()
    writer.SetEncodeAppendedData(mode == "base64")
    getattr(writer, "SetCompressorTypeTo" + compressor)()
    getattr(writer, "SetHeaderTypeTo" + word)()
    writer.SetByteOrder(1 if order == "little" else 0)
    if block:
        writer.SetBlockSize(block)
    if pieces > 1:
        writer.SetNumberOfPieces(pieces)
    expect(writer.Write() == 1, "VTK writes " + path)


def check_images(folder):
    modes = itertools.product(("ascii", "binary", "raw", "base64"), ("None", "ZLib", "LZ4", "LZMA"), ("UInt32", "UInt64"),
                              ("little", "big"))
    for number, (mode, compressor, word, order) in enumerate(modes):
        for kind, dims in enumerate(((7, 5, 3), (1, 1, 1), (13, 2, 1), (31, 17, 11))):
            if (number + kind) % 2:
                continue
            dtype, components = TYPES[(number + 3 * kind) % 10], (1, 1, 3, 2)[(number // 2 + kind) % 4]
            first, cells = ((0, 0, 0), (5, -3, 2))[number % 2], (number + kind) % 3 == 0
            out, data = image(dims, dtype, components, first, cells and min(dims) > 1)
            path = os.path.join(folder, f"i{number:03d}{kind}.vti")
            write_xml(vtk.vtkXMLImageDataWriter(), out, path, mode, compressor, word, order, 512 if kind == 3 else 0)
            check(path, data, *place_of(out, first, cells and min(dims) > 1))


def check_types(folder):
    for dtype in TYPES:
        for mode in ("ascii", "binary", "raw"):
            out, data = image((5, 3, 2), dtype)
            path = os.path.join(folder, f"t{dtype}{mode}.vti")
            write_xml(vtk.vtkXMLImageDataWriter(), out, path, mode, "None", "UInt32", "little")
            check(path, data, *place_of(out, (0, 0, 0)))


def check_directions(folder):
    for number, order in enumerate(itertools.permutations(range(3))):
        for signs in itertools.product((1, -1), repeat=3):
            direction = np.zeros((3, 3))
            for a in range(3):
                direction[order[a], a] = signs[a]
            out, data = image((4, 3, 2), "i2", first=(1, 2, 3), direction=direction)
            path = os.path.join(folder, "d{}{}{}{}.vti".format(number, *signs))
            write_xml(vtk.vtkXMLImageDataWriter(), out, path, "raw", "None", "UInt64", "little")
            check(path, data, *place_of(out, (1, 2, 3)))


def check_pieces(folder):
    for number, (mode, compressor) in enumerate(itertools.product(("ascii", "raw", "binary"), ("None", "ZLib"))):
        for cells in (False, True):
            out, data = image((9, 8, 7), "f4", 1 + number % 2, (2, 0, -1), cells)
            path = os.path.join(folder, f"p{number}{cells}.vti")
            write_xml(vtk.vtkXMLImageDataWriter(), out, path, mode, compressor, "UInt32", "little", 256, 4)
            expect(open(path, "rb").read().count(b"<Piece") > 1, path + " has several pieces")
            check(path, data, *place_of(out, (2, 0, -1), cells))


def check_parts(folder):
    out, data = image((5, 4, 3), "i2")
    more, cells, colour = samples((3, 4, 5, 1), "f8"), samples((2, 3, 4, 1), "u2"), samples((3, 4, 5, 3), "u1")
    vector = samples((3, 4, 5, 3), "f4")
    out.GetPointData().AddArray(array(more, "more, or less"))
    out.GetPointData().AddArray(array(colour, "colour"))
    out.GetPointData().SetVectors(array(vector, "v"))
    out.GetCellData().AddArray(array(cells, "a"))
    times = array(np.array([[2.5]]), "TimeValue")
    out.GetFieldData().AddArray(times)
    path = os.path.join(folder, "parts.vti")
    write_xml(vtk.vtkXMLImageDataWriter(), out, path, "raw", "LZ4", "UInt32", "little")
    check(path, data, *place_of(out, (0, 0, 0)))
    check(path, more, *place_of(out, (0, 0, 0)), "more, or less")
    check(path, colour, *place_of(out, (0, 0, 0)), "colour")
    check(path, vector, *place_of(out, (0, 0, 0)), "v")
    check(path, cells, *place_of(out, (0, 0, 0), True), "cells/a")
    expect(dump(path, "colour")[0]["meaning"] == 1, "three bytes are a colour")
    expect(dump(path, "v")[0]["meaning"] == 3, "the active vectors are vectors")


def check_written(folder):
    code, listing, error = tool.ask("write-vti", folder)
    expect(code == 0, "io_tool write-vti: " + error)
    for line in listing.splitlines():
        path, text = line.split("\t")
        info = json.loads(text)
        x, y, z = info["dims"]
        ours = np.fromfile(path + ".f64", "<f8").reshape(z, y, x, info["components"])
        reader = vtk.vtkXMLImageDataReader()
        reader.SetFileName(path)
        reader.Update()
        out = reader.GetOutput()
        values = out.GetPointData().GetArray(0)
        expect(out.GetDimensions() == (x, y, z) and values is not None, path + ": VTK finds other dims, or no array")
        if values is None:
            continue
        theirs = vtk_to_numpy(values).reshape(ours.shape)
        expect(np.array_equal(theirs, ours), path + ": VTK reads other samples")
        origin, steps = place_of(out, (0, 0, 0))
        expect(np.allclose(origin, info["columns"][3]) and np.allclose(steps, info["columns"][:3], atol=1e-9),
               path + ": VTK finds another place")
        expect(out.GetFieldData().GetAbstractArray("volvis unit").GetValue(0) == "mm", path + ": the unit is not noted")
        info_back, back = dump(path)
        if info_back is not None:
            expect(np.array_equal(back, ours), path + ": VolVis reads other samples than it wrote")
            for key in ("unit", "space", "type", "components", "meaning"):
                expect(info_back[key] == info[key], f"{path}: {key} is {info_back[key]}, not {info[key]}")
            expect(np.allclose(info_back["columns"], info["columns"], atol=1e-12), path + ": the place differs")


def rectilinear(axes, kind, cells):
    out = vtk.vtkRectilinearGrid()
    out.SetDimensions(*(len(a) for a in axes))
    for a, name in zip(axes, "XYZ"):
        getattr(out, f"Set{name}Coordinates")(array(np.asarray(a, kind)[:, None], name))
    n = [max(1, len(a) - 1) for a in axes] if cells else [len(a) for a in axes]
    return out, n


def centres(a):
    a = np.asarray(a, "f8")
    return (a[1:] + a[:-1]) / 2 if len(a) > 1 else a


def interpolate(data, axes, at):
    """Linear interpolation of [z, y, x, c] at the products of three lists of places."""
    for axis, (a, x) in enumerate(zip(axes, at)):
        a, x = np.asarray(a, "f8"), np.asarray(x, "f8")
        if len(a) == 1:
            continue
        if a[0] > a[-1]:
            a, x, data = -a, -x, data
        k = np.clip(np.searchsorted(a, x, "right") - 1, 0, len(a) - 2)
        w = np.clip((x - a[k]) / (a[k + 1] - a[k]), 0, 1)
        data = np.moveaxis(data, 2 - axis, -1)
        data = data[..., k] * (1 - w) + data[..., k + 1] * w
        data = np.moveaxis(data, -1, 2 - axis)
    return data


def check_resampled(path, axes, data, part=None):
    """What VolVis makes of it is the linear interpolation of the data at the places that it says."""
    info, ours = dump(path, part)
    if info is None:
        return
    columns = np.array(info["columns"])
    at = [columns[3][a] + columns[a][a] * np.arange(n) for a, n in enumerate(info["dims"])]
    for a in range(3):
        expect(abs(at[a][0] - axes[a][0]) < 1e-6 and (len(axes[a]) == 1 or abs(at[a][-1] - axes[a][-1]) < 1e-5),
               f"{path}: spans {at[a][0]} to {at[a][-1]} along {'xyz'[a]}")
        expect(len(axes[a]) <= info["dims"][a] <= 4 * len(axes[a]), f"{path}: has {info['dims'][a]} samples")
    expect(np.prod(info["dims"]) <= 8.001 * np.prod([len(a) for a in axes]), f"{path}: has too many samples {info['dims']}")
    want = interpolate(data.astype("f8"), axes, at)
    scale = max(1e-30, np.abs(want).max())
    expect(want.shape == ours.shape and np.allclose(ours, want, atol=2e-6 * scale + 5e-4 * np.ptp(want)),
           f"{path}: differs from linear interpolation by {np.abs(want - ours).max() if want.shape == ours.shape else ours.shape}")


UNEVEN = ([0, 1, 1.5, 4, 4.25], [3, 2, 0, -5], [10, 10.5, 12, 13, 20, 20.1])
EVEN = ([1, 1.5, 2, 2.5], [-3, -2, -1], [5, 4])


def check_rectilinear(folder):
    number = 0
    for axes, cells, (mode, compressor) in itertools.product(
            (UNEVEN, EVEN, (UNEVEN[0], EVEN[1], EVEN[2]), ([1, 2, 5], [7], UNEVEN[2])), (False, True),
            (("ascii", "None"), ("binary", "ZLib"), ("raw", "LZ4"), ("raw", "None"))):
        dtype = ("f4", "f8", "u1", "i2", "i4")[number % 5]
        out, n = rectilinear(axes, ("f4", "f8")[number % 2], cells)
        data = samples((n[2], n[1], n[0], 1 + number % 3 % 2), dtype)
        (out.GetCellData() if cells else out.GetPointData()).SetScalars(array(data, "a"))
        path = os.path.join(folder, f"r{number:03d}.vtr")
        write_xml(vtk.vtkXMLRectilinearGridWriter(), out, path, mode, compressor, "UInt32", "little", 0, 1 + number % 2)
        number += 1
        check_resampled(path, [centres(a) for a in axes] if cells else axes, data)


def check_legacy(folder):
    for number, (dtype, binary, version, cells) in enumerate(itertools.product(TYPES, (False, True), (42, 51), (False, True))):
        first = ((0, 0, 0), (2, 1, -4))[number % 2]
        out, data = image((5, 4, 3), dtype, 1 + number // 2 % 4, (0, 0, 0), cells)
        out.SetOrigin(*first)
        more, vector = samples((3, 4, 5, 1), "i2"), samples((3, 4, 5, 3), "f4")
        out.GetPointData().AddArray(array(more, "more or less"))
        out.GetPointData().SetVectors(array(vector, "v"))
        vtk_array = (out.GetCellData() if cells else out.GetPointData()).GetArray("a")
        vtk_array.GetRange(-1)  # leaves information that is written as METADATA
        writer = vtk.vtkStructuredPointsWriter()
        writer.SetFileName(os.path.join(folder, f"l{number:03d}.vtk"))
        points = vtk.vtkStructuredPoints()
        points.ShallowCopy(out)
        writer.SetInputData(points)
        writer.SetFileVersion(version)
        getattr(writer, "SetFileTypeTo" + ("Binary" if binary else "ASCII"))()
        expect(writer.Write() == 1, "VTK writes a legacy file")
        path = writer.GetFileName()
        if not binary and dtype in ("f4", "f8"):  # as many digits as VTK writes
            reader = vtk.vtkStructuredPointsReader()
            reader.SetFileName(path)
            reader.ReadAllScalarsOn()
            reader.ReadAllVectorsOn()
            reader.ReadAllFieldsOn()
            reader.Update()
            where = reader.GetOutput().GetCellData() if cells else reader.GetOutput().GetPointData()
            data = vtk_to_numpy(where.GetArray("a")).reshape(data.shape)
            vector = vtk_to_numpy(reader.GetOutput().GetPointData().GetArray("v")).reshape(vector.shape)
        elif not binary:
            vector = None
        check(path, data, *place_of(out, (0, 0, 0), cells), "a")
        check(path, more, *place_of(out, (0, 0, 0)), "more or less")
        if vector is not None:
            check(path, vector, *place_of(out, (0, 0, 0)), "v")


def bits(data, name):
    """data: [..., c] of 0 and 1."""
    out = vtk.vtkBitArray()
    out.SetName(name)
    out.SetNumberOfComponents(data.shape[-1])
    out.SetNumberOfTuples(data.size // data.shape[-1])
    for i, v in enumerate(data.reshape(-1, data.shape[-1])):
        for c, bit in enumerate(v):
            out.SetComponent(i, c, int(bit))
    return out


def check_bits(folder):
    """Eight samples to a byte."""
    for number, (dims, components) in enumerate(itertools.product(((7, 5, 3), (1, 1, 1), (8, 2, 1), (31, 17, 11)), (1, 3))):
        data = rng.integers(0, 2, (dims[2], dims[1], dims[0], components), dtype="u1")
        points = vtk.vtkStructuredPoints()
        points.SetDimensions(*dims)
        points.GetPointData().SetScalars(bits(data, "b"))
        for binary in (False, True):
            writer = vtk.vtkStructuredPointsWriter()
            writer.SetFileName(os.path.join(folder, f"bits{number}{binary}.vtk"))
            writer.SetInputData(points)
            getattr(writer, "SetFileTypeTo" + ("Binary" if binary else "ASCII"))()
            expect(writer.Write() == 1, "VTK writes bits")
            if binary and components > 1:  # VTK writes only as many bits as there are tuples
                head = open(writer.GetFileName(), "rb").read().partition(b"LOOKUP_TABLE default\n")
                with open(writer.GetFileName(), "wb") as file:
                    file.write(head[0] + head[1] + np.packbits(data.ravel()).tobytes() + b"\n")
            check(writer.GetFileName(), data, (0, 0, 0), np.eye(3), "b")
        for mode, compressor in itertools.product(("ascii", "binary", "raw", "base64"), ("None", "ZLib", "LZ4")):
            path = os.path.join(folder, f"bits{number}{mode}{compressor}.vti")
            write_xml(vtk.vtkXMLImageDataWriter(), points, path, mode, compressor, "UInt32", "little", 256)
            check(path, data, (0, 0, 0), np.eye(3))


def check_legacy_colors(folder):
    path = os.path.join(folder, "colors.vtk")
    head = "# vtk DataFile Version 2.0\nt\n{}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 1\nASPECT_RATIO 1 2 3\n"
    head += "POINT_DATA 4\nCOLOR_SCALARS c 3\n"
    data = np.array([0, 51, 255, 102, 1, 254, 153, 204, 7, 9, 99, 128], "u1").reshape(1, 2, 2, 3)
    with open(path, "w") as file:
        file.write(head.format("ASCII") + " ".join(f"{v / 255:.6g}" for v in data.ravel()) + "\n")
    check(path, data, (0, 0, 0), np.diag((1, 2, 3)))
    with open(path, "wb") as file:
        file.write(head.format("BINARY").encode() + data.tobytes() + b"\nLOOKUP_TABLE t 2\n12345678\nFIELD f 1\nx 1 4 short\n"
                   + b"\0\1\0\2\0\3\0\4\n")
    check(path, data, (0, 0, 0), np.diag((1, 2, 3)))
    check(path, np.arange(1, 5).reshape(1, 2, 2, 1), (0, 0, 0), np.diag((1, 2, 3)), "x")


def check_legacy_rectilinear(folder):
    for number, (axes, binary, cells) in enumerate(itertools.product((UNEVEN, EVEN), (False, True), (False, True))):
        out, n = rectilinear(axes, "f8", cells)
        data = samples((n[2], n[1], n[0], 1), "i2")
        (out.GetCellData() if cells else out.GetPointData()).SetScalars(array(data, "a"))
        writer = vtk.vtkRectilinearGridWriter()
        writer.SetFileName(os.path.join(folder, f"lr{number}.vtk"))
        writer.SetInputData(out)
        getattr(writer, "SetFileTypeTo" + ("Binary" if binary else "ASCII"))()
        writer.Write()
        check_resampled(writer.GetFileName(), [centres(a) for a in axes] if cells else axes, data)


def check_real_legacy():
    for name in ("formats/vtk/heart.vtk", "formats/vtk/matrix.vtk", "volumes/carotid.vtk", "volumes/ironProt.vtk",
                 "irregular/RectGrid2.vtk"):
        if not os.path.exists(shared(name)):
            continue
        reader = vtk.vtkDataSetReader()
        reader.SetFileName(shared(name))
        reader.ReadAllVectorsOn()
        reader.Update()
        out = reader.GetOutput()
        for i in range(out.GetPointData().GetNumberOfArrays()):
            values = out.GetPointData().GetArray(i)
            x, y, z = out.GetDimensions()
            data = vtk_to_numpy(values).reshape(z, y, x, -1)
            if name.startswith("irregular"):
                check_resampled(shared(name), coordinates(out), data, values.GetName())
            else:
                check(shared(name), data, *place_of(out, (0, 0, 0)), values.GetName())


def shared(name):
    root = os.environ.get("VOLVIS_SHARED") or os.path.join(os.path.dirname(os.path.abspath(__file__)), *[".."] * 4, "shared")
    return os.path.join(root, "data", name)


def coordinates(out):
    return [vtk_to_numpy(getattr(out, f"Get{name}Coordinates")()).astype("f8") for name in "XYZ"]


def check_real_rectilinear():
    reader = vtk.vtkXMLRectilinearGridReader()
    name = shared("irregular/cth.vtr")
    if not os.path.exists(name):
        return
    reader.SetFileName(name)
    reader.Update()
    out = reader.GetOutput()
    axes = [centres(a) for a in coordinates(out)]
    for i in range(0, out.GetCellData().GetNumberOfArrays(), 3):
        values = out.GetCellData().GetArray(i)
        data = vtk_to_numpy(values).reshape(*[len(a) for a in axes[::-1]], -1)
        check_resampled(name, axes, data, values.GetName())


def check_real_images():
    names = ["formats/vti/060_density_060_064_2.0.vti", "formats/vti/heart.vti", "formats/vti/vase_1comp.vti",
             "formats/vti/vase_4comp.vti", "volumes/hydrogen.vti", "volumes/jet_vort-small.vti",
             "volumes/isabel/isabel_02.vti", "volumes/isabel/isabel_03.vti"]
    if not os.path.exists(shared(names[0])):
        print(f"{shared(names[0])} is not there: real files are skipped")
        return
    for name in names:
        reader = vtk.vtkXMLImageDataReader()
        reader.SetFileName(shared(name))
        reader.Update()
        out = reader.GetOutput()
        points = out.GetPointData()
        theirs = vtk_to_numpy(points.GetScalars() or points.GetArray(0))
        x, y, z = out.GetDimensions()
        check(shared(name), theirs.reshape(z, y, x, -1), *place_of(out, (0, 0, 0)))


with workplace() as folder:
    check_images(folder)
    check_types(folder)
    check_directions(folder)
    check_pieces(folder)
    check_parts(folder)
    check_written(folder)
    check_rectilinear(folder)
    check_real_images()
    check_real_rectilinear()
    check_legacy(folder)
    check_legacy_colors(folder)
    check_bits(folder)
    check_legacy_rectilinear(folder)
    check_real_legacy()
failures += not tool.end()
print(f"{checks} checks, {failures} failed")
sys.exit(1 if failures else 0)
