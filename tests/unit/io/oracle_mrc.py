"""MRC as an independent program writes and reads it: mrcfile.

Usage: oracle_mrc.py IO_TOOL [SHARED_DATA]. Exit 77 (skipped) without mrcfile.
"""
import itertools
import os
import sys
import warnings

try:
    import mrcfile
    import numpy as np
except ImportError:
    print("numpy or mrcfile is missing: skipped")
    sys.exit(77)
from served import Tool, workplace

tool = Tool(sys.argv[1])
shared = sys.argv[2] if len(sys.argv) > 2 else ""
failures = 0
checks = 0
warnings.simplefilter("ignore")


def expect(condition, what):
    global failures, checks
    checks += 1
    if not condition:
        failures += 1
        print("FAILED:", what)


def formula(shape, dtype):
    dtype = np.dtype(dtype)
    rng = np.random.default_rng(7)
    if dtype.kind == "f":
        return rng.normal(size=shape).astype(dtype)
    info = np.iinfo(dtype)
    return rng.integers(info.min, info.max, size=shape, endpoint=True).astype(dtype)


def same(info, values, expected, what):
    if info is None:
        expect(False, f"{what}: {values}")
    else:
        expect(values.shape == expected.shape and np.array_equal(values, expected.astype("f8"), equal_nan=True),
               f"{what}: other samples, {values.shape} and {expected.shape}")


def swapped(path, out):
    """The same file in the other byte order."""
    with mrcfile.open(path) as m:
        header, data = m.header.copy(), m.data.copy()
    with open(out, "wb") as f:
        big = header.astype(header.dtype.newbyteorder(">"))
        big["machst"] = [0x11, 0x11, 0, 0]
        f.write(big.tobytes())
        f.write(data.astype(data.dtype.newbyteorder(">")).tobytes())


def check_read(folder):
    path, big = os.path.join(folder, "a.mrc"), os.path.join(folder, "b.map")
    for dtype, n in itertools.product(["i1", "i2", "u2", "f4", "f2"], [(1, 1, 1), (2, 3, 5), (7, 5, 3), (1, 13, 11)]):
        data = formula(n, dtype)
        with mrcfile.new(path, overwrite=True) as m:
            m.set_data(data)
            m.voxel_size = (1.5, 2.5, 3.5)
            m.header.origin = (1, -2, 3)
        what = f"{dtype} {n}"
        info, values = tool.read(path)
        same(info, values, data[None, ..., None], what)
        if info:
            steps = [info["columns"][i][i] for i in range(3)]
            expect(info["unit"] == "A" and np.allclose(steps, [1.5, 2.5, 3.5]), f"{what}: steps {steps}")
            expect(np.allclose(info["columns"][3], [1, -2, 3]), f"{what}: origin {info['columns'][3]}")
        swapped(path, big)
        same(*tool.read(big), data[None, ..., None], what + " big-endian")


def check_axes(folder):
    """All orders of axes: the cell's along X, Y, Z; what a place in the map is in space."""
    path = os.path.join(folder, "x.mrc")
    data = formula((3, 5, 7), "f4")
    for order in itertools.permutations((1, 2, 3)):
        with mrcfile.new(path, overwrite=True) as m:
            m.set_data(data)
            m.header.mapc, m.header.mapr, m.header.maps = order
            m.header.nxstart, m.header.nystart, m.header.nzstart = 2, -3, 4
            sizes = dict(zip(order, (7, 5, 3)))
            m.header.mx, m.header.my, m.header.mz = sizes[1], sizes[2], sizes[3]
            m.header.cella = (sizes[1] * 1.0, sizes[2] * 2.0, sizes[3] * 4.0)
        info, values = tool.read(path)
        same(info, values, data[None, ..., None], f"order {order}")
        columns = np.array(info["columns"])
        expected = np.zeros((4, 3))
        for i, start in enumerate((2, -3, 4)):
            expected[i, order[i] - 1] = (1.0, 2.0, 4.0)[order[i] - 1]
            expected[3] += start * expected[i]
        expect(np.allclose(columns, expected), f"order {order}: {columns}")


def check_nibbles(folder):
    """Mode 101, which mrcfile knows not: two numbers a byte, the low half first, rows of whole bytes."""
    whole, path = os.path.join(folder, "w.mrc"), os.path.join(folder, "n.mrc")
    for n in itertools.chain(itertools.product((1, 2, 3, 5, 7), repeat=3), [(2, 3, 8191), (3, 2, 8194), (1, 2, 30001)]):
        data = formula(n, "u1") & 15
        with mrcfile.new(whole, overwrite=True) as m:
            m.set_data(data.astype("i1"))
        with open(whole, "rb") as file:
            head = bytearray(file.read(1024))
        head[12:16] = (101).to_bytes(4, "little")
        even = np.concatenate([data, np.zeros((*n[:2], n[2] % 2), "u1")], axis=2)
        packed = even[..., ::2] | even[..., 1::2] << 4
        with open(path, "wb") as file:
            file.write(head + packed.tobytes())
        same(*tool.read(path), data[None, ..., None], f"4 bits {n}")
    lost = packed.size // 4
    with open(path, "wb") as file:
        file.write(head + packed.tobytes()[:-lost])
    info, values = tool.read(path)
    data[0, -1, n[2] - 2 * lost + n[2] % 2:] = 0
    same(info, values, data[None, ..., None], "4 bits cut short")
    with open(path, "wb") as file:
        file.write(head + packed.tobytes()[:packed.size // 3])
    expect(tool.read(path)[0] is None, "less than half of 4-bit samples is refused")


def check_others(folder):
    path = os.path.join(folder, "o.mrc")
    data = formula((2, 3, 5, 7), "i2")
    with mrcfile.new(path, overwrite=True) as m:
        m.set_data(data)
    same(*tool.read(path), data[..., None], "stack of volumes")
    with mrcfile.new(path, overwrite=True) as m:
        m.set_data(np.ones((2, 3), "c8"))
    info, error = tool.read(path)
    expect(info is None and "complex" in error, "complex is refused")
    data = formula((3, 4, 5), "u1")
    for stamp, flags, dtype in ((True, 0, "u1"), (True, 1, "i1"), (False, 0, "i1")):
        with mrcfile.new(path, overwrite=True) as m:
            m.set_data(data.view("i1"))
        if stamp:
            with open(path, "r+b") as f:
                f.seek(152)
                f.write(np.array([1146047817, flags], "<i4").tobytes())
        same(*tool.read(path), data.view(dtype)[None, ..., None], f"IMOD {stamp} {flags}")


def nrrd(path, data, columns, unit):
    """data: [t, z, y, x]."""
    kinds = {"u1": "uint8", "i1": "int8", "i2": "int16", "u2": "uint16", "f4": "float", "f8": "double"}
    t, z, y, x = data.shape
    vectors = ["(" + ",".join(repr(float(v)) for v in column) + ")" for column in columns]
    with open(path, "wb") as f:
        f.write(("NRRD0005\ntype: %s\ndimension: 4\nspace dimension: 3\nsizes: %d %d %d %d\nspace directions: %s none\n"
                 "space origin: %s\nspace units: \"%s\" \"%s\" \"%s\"\nkinds: domain domain domain time\n"
                 "encoding: raw\nendian: little\n\n" %
                 (kinds[data.dtype.str[1:]], x, y, z, t, " ".join(vectors[:3]), vectors[3], unit, unit, unit)).encode())
        f.write(data.astype(data.dtype.newbyteorder("<")).tobytes())


def check_written(folder):
    source, path = os.path.join(folder, "w.nrrd"), os.path.join(folder, "w.mrc")
    types = {"u1": "u2", "i1": "i1", "i2": "i2", "u2": "u2", "f4": "f4", "f8": "f4"}
    for number, (order, flips) in enumerate(itertools.product(itertools.permutations(range(3)),
                                                              itertools.product((1, -1), repeat=3))):
        dtype = list(types)[number % 6]
        frames = 2 if number % 7 == 3 and order[2] == 2 else 1
        data = formula((frames, 3, 5, 7), dtype)
        columns = np.zeros((4, 3))
        for i in range(3):
            columns[i, order[i]] = (0.5, 1.25, 2.0)[i] * flips[i]
        columns[3] = (10, -20, 30.5)
        nrrd(source, data, columns, "nm")
        code, _, error = tool.ask("copy", source, path, "", *(["big"] if number % 2 else []))
        what = f"written {order} {flips} {dtype}"
        expect(code == 0, what + ": " + error)
        expect(mrcfile.validate(path, print_file=open(os.devnull, "w")), what + ": mrcfile finds faults")
        with mrcfile.open(path) as m:
            theirs, header = m.data.reshape(frames, 3, 5, 7), m.header
            expect(theirs.dtype.newbyteorder("=") == np.dtype(types[dtype]), f"{what}: {theirs.dtype}")
            flipped = data[:, ::flips[2], ::flips[1], ::flips[0]]
            expect(np.array_equal(theirs, flipped.astype(types[dtype])), what + ": other samples")
            expect((header.mapc, header.mapr, header.maps) == tuple(a + 1 for a in order), what + ": axes")
            voxel = [float(m.voxel_size[k]) for k in "xyz"]
            expect(np.allclose([voxel[order[i]] for i in range(3)], [5, 12.5, 20]), f"{what}: voxel {voxel}")
            written = [float(header.origin[k]) for k in "xyz"]
        info, values = tool.read(path)
        same(info, values, flipped[..., None].astype(types[dtype]), what + " by us")
        first = columns[3] + sum(columns[i] * (n - 1) * (flips[i] < 0) for i, n in enumerate((7, 5, 3)))
        expect(np.allclose(written, first * 10), f"{what}: origin {written}, {first * 10}")
        expect(np.allclose(info["columns"][3], first), f"{what}: origin {info['columns'][3]}, {first}")
        expect(np.allclose(info["columns"][:3], np.abs(columns[:3])) and info["unit"] == "nm", f"{what}: columns")


def check_own_label(folder):
    """The space and the unit in a label of ours; no other label says anything."""
    source, path = os.path.join(folder, "l.nrrd"), os.path.join(folder, "l.mrc")
    nrrd(source, formula((1, 3, 5, 7), "i2"), np.array([[2, 0, 0], [0, 2, 0], [0, 0, 3], [1, 2, 3]]), "mm")
    expect(tool.ask("copy", source, path)[0] == 0, "a label of ours")
    for label, unit, step, space in (("VolVis: mm", "mm", 2, 0), ("VolVis: RAS, mm", "mm", 2, 1), ("VolVis: RAS, um", "um", 2e3, 1),
                                     ("VolVis: ", "A", 2e7, 0), ("VolVis: RAS, ", "A", 2e7, 0), ("VolVis: two words", "A", 2e7, 0),
                                     ("VolVis: voxels", "A", 2e7, 0), ("VolVis: " + "m" * 72, "A", 2e7, 0),
                                     ("volvis: RAS, mm", "A", 2e7, 0), ("RAS, mm", "A", 2e7, 0)):
        with open(path, "r+b") as f:
            f.seek(224 + 80)
            f.write(label.encode().ljust(80))
        info = tool.read(path)[0]
        expect(info is not None and info["unit"] == unit and info["space"] == space and
               np.isclose(info["columns"][0][0], step), f"label '{label}': {info}")


def check_written_bytes(folder):
    """Unsigned bytes: mode 0 holds those up to 127; else 16 bits, which is said."""
    source, path = os.path.join(folder, "b.nrrd"), os.path.join(folder, "b.mrc")
    for most, dtype in ((127, "i1"), (128, "u2"), (255, "u2")):
        data = formula((2, 3, 5, 7), "u1") % 120
        data[1, 2, 3, 4] = most
        nrrd(source, data, np.vstack([np.eye(3), np.zeros(3)]), "A")
        code, _, error = tool.ask("copy", source, path)
        expect(code == 0, f"bytes up to {most}: {error}")
        with mrcfile.open(path) as m:
            expect(m.data.dtype == np.dtype(dtype) and np.array_equal(m.data.reshape(data.shape), data), f"bytes up to {most}")
        same(*tool.read(path), data[..., None], f"bytes up to {most} by us")


def check_shared(folder):
    real = os.path.join(shared, "data", "formats", "mrc")
    if not shared or not os.path.isdir(real):
        print("no shared data: real files are left out")
        return
    for name in sorted(os.listdir(real)):
        path = os.path.join(real, name)
        info, values = tool.read(path)
        if name.endswith(".map"):
            with mrcfile.open(path) as m:
                same(info, values, m.data[None, ..., None], name)
        else:  # mrcfile refuses its sign of the extended header's size
            head = np.fromfile(path, ">i4" if "big" in name else "<i4", 256)
            offset = os.path.getsize(path) - int(head[0] * head[1] * head[2])
            data = np.fromfile(path, "u1", offset=offset).reshape(1, head[2], head[1], head[0], 1)
            same(info, values, data, name)


with workplace() as place:
    check_read(place)
    check_axes(place)
    check_nibbles(place)
    check_others(place)
    check_written(place)
    check_own_label(place)
    check_written_bytes(place)
    check_shared(place)
failures += not tool.end()
print(checks, "checks,", failures, "failed")
sys.exit(1 if failures else 0)
