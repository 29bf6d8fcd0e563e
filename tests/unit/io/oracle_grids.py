"""OpenDX and Gaussian cube files, written here in every dialect by numpy, read by VolVis; and real ones beside the checkout.

Usage: oracle_grids.py IO_TOOL. Exit 77 (skipped) without numpy.
"""
import itertools
import os
import sys

try:
    import numpy as np
except ImportError:
    print("numpy is missing: skipped")
    sys.exit(77)
from served import Tool, workplace

tool = Tool(sys.argv[1])
failures = 0
checks = 0
rng = np.random.default_rng(1994)
BOHR = 0.529177210903


def expect(condition, what):
    global failures, checks
    checks += 1
    if not condition:
        failures += 1
        print("FAILED:", what)


def dump(path, part=None):
    info, values = tool.read(path, part or "")
    if info is None:
        expect(False, f"{path} is not read: {values}")
        return None, None
    return info, values.reshape(values.shape[1:])


def check(path, data, origin, steps, unit, part=None, tolerance=0):
    """data: [x, y, z, c], as these formats index it"""
    info, ours = dump(path, part)
    if info is None:
        return
    want = data.transpose(2, 1, 0, 3).astype("f8")
    expect(ours.shape == want.shape and np.allclose(ours, want, rtol=tolerance, atol=0), path + ": other samples")
    expect(np.allclose(info["columns"], [*steps, origin], atol=1e-9), f"{path}: lies at {info['columns']}")
    expect(info["unit"] == unit, f"{path}: unit {info['unit']}")


DX_TYPES = {"byte": "u1", "signed byte": "i1", "short": "i2", "unsigned short": "u2", "int": "i4", "unsigned int": "u4",
            "float": "f4", "double": "f8"}


def make(shape, dtype):
    return (rng.random(shape) * 120).astype(dtype)


def write_dx(path, data, mode, where, kind, cells):
    """One array on a skewed grid; mode: msb, lsb or text; where: behind (the header), follows or beside."""
    counts = [n + cells for n in data.shape[:3]]
    body = data.astype(data.dtype.newbyteorder(">" if mode == "msb" else "<")).tobytes()
    if mode == "text":
        body = " ".join(repr(float(v)) if data.dtype.kind == "f" else str(v) for v in data.ravel()).encode() + b"\n"
    place = {"behind": "data 0", "follows": "data follows", "beside": "data file other.bin 4"}[where]
    rank = f"rank 1 shape {data.shape[3]}" if data.shape[3] > 1 else "rank 0"
    head = f"# a comment\nobject 1 class array type {kind} {rank} items {np.prod(data.shape[:3])} "
    head += {"msb": "msb ieee ", "lsb": "lsb ieee ", "text": "text "}[mode] + place + "\n"
    dep = "connections" if cells else "positions"
    rest = f'\nattribute "dep" string "{dep}"\n#\nobject 2 class gridpositions counts {counts[0]} {counts[1]} {counts[2]}\n'
    rest += " origin 1 2.5 -3\n delta 0 0.5 0\ndelta -2 0 0\n delta 0 1 4\nobject 3 class gridconnections counts 2 2 2\n"
    rest += 'object "first field" class field\ncomponent "data" value 1\ncomponent "positions" value 2\n'
    rest += 'component "connections" value 3\nobject "none" class field\ncomponent "data" value 9\nend\n'
    with open(path, "wb") as file:
        file.write(head.encode() + (body if where == "follows" else b"") + rest.encode() + (body if where == "behind" else b""))
    with open(os.path.join(os.path.dirname(path), "other.bin"), "wb") as file:
        file.write(b"skip" + body)


def check_dx(folder):
    steps = np.array([[0, 0.5, 0], [-2, 0, 0], [0, 1, 4]], "f8")
    dialects = itertools.product(DX_TYPES.items(), ("msb", "lsb", "text"), ("behind", "follows", "beside"))
    for number, ((kind, dtype), mode, where) in enumerate(dialects):
        shape = ((5, 3, 2), (2, 3, 7), (13, 1, 2))[number % 3] + ((1, 3)[number // 2 % 2],)
        cells = number % 4 == 3
        data = make(shape, dtype)
        path = os.path.join(folder, f"d{number:03d}.dx")
        write_dx(path, data, mode, where, kind, cells)
        origin = np.array([1, 2.5, -3]) + (steps.sum(0) / 2 if cells else 0)
        check(path, data, origin, steps, "units", "first field" if number % 2 else None)


def check_dx_defaults(folder):
    """The manual's: type float, category real, rank 0."""
    steps = np.array([[0, 0.5, 0], [-2, 0, 0], [0, 1, 4]], "f8")
    data = make((5, 3, 2, 1), "f4")
    for said in ("", "category real ", "rank 0 ", "type float "):
        path = os.path.join(folder, "default.dx")
        write_dx(path, data, "text", "follows", "float", False)
        with open(path, encoding="ascii") as file:
            text = file.read().replace("type float rank 0 ", said)
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        check(path, data, np.array([1, 2.5, -3]), steps, "units")
    with open(path, "w", encoding="ascii") as file:
        file.write(text.replace("type float", "type float category complex"))
    info, error = tool.read(path)
    expect(info is None and "has a type that is not supported" in error, f"complex numbers: {error}")


def check_general(folder):
    for number, ((kind, dtype), form, majority) in enumerate(
            itertools.product(DX_TYPES.items(), ("msb binary", "lsb ieee", "ascii"), ("row", "column"))):
        data = make((5, 3, 2, 1 + number // 2 % 3), dtype)
        more = make((5, 3, 2, 1), "f4")
        order = ">" if form.startswith("msb") else "<"
        layout = (0, 1, 2, 3) if majority == "row" else (2, 1, 0, 3)
        several = form != "ascii" and number % 2 == 0
        with open(os.path.join(folder, "g.bin"), "wb") as file:
            file.write(b"1234567")
            if form == "ascii":
                file.write(" ".join(repr(float(v)) if data.dtype.kind == "f" else str(v)
                                    for v in data.transpose(layout).ravel()).encode())
            else:
                file.write(data.transpose(layout).astype(data.dtype.newbyteorder(order)).tobytes())
            if several:
                file.write(more.transpose(layout).astype(order + "f4").tobytes())
        structure = "scalar" if data.shape[3] == 1 else f"{data.shape[3]}-vector"
        text = f"file = g.bin\ngrid = 5 x 3 x 2\nformat = {form}\nmajority = {majority}\nheader = bytes 7\n"
        text += "interleaving = record\n" + ("field = a, b\n" if several else "field = a\n")
        text += f"structure = {structure}, scalar\n" if several else f"structure = {structure}\n"
        text += f"type = {kind}, float\n" if several else f"type = {kind}\n"
        text += "dependency = positions\npositions = regular, regular, regular, 1, 0.5, 2, 1.5, -3, 2\n\nend\n"
        path = os.path.join(folder, f"g{number}.general")
        with open(path, "w") as file:
            file.write(text)
        check(path, data, (1, 2, -3), np.diag((0.5, 1.5, 2)), "units")
        if several:
            check(path, more, (1, 2, -3), np.diag((0.5, 1.5, 2)), "units", "b")


def check_cube(folder):
    steps = np.array([[0.2, 0.4, -0.3], [0.1, 0.3, 0.5], [0.5, -0.2, 0]])
    for number, (angstrom, orbitals, shape) in enumerate(
            itertools.product((False, True), (0, 1, 3), ((5, 3, 2), (1, 1, 1), (2, 7, 13)))):
        data = (rng.random(shape + (max(1, orbitals),)) * 2 - 1).astype("f4")
        path = os.path.join(folder, f"c{number}.cube")
        with open(path, "w") as file:
            file.write(f"title\nsecond line\n{-2 if orbitals else 2:5d} -1.5 2.25 0.125\n")
            for n, step in zip(shape, steps):
                file.write(f"{-n if angstrom else n:5d} {step[0]:.6f} {step[1]:.6f} {step[2]:.6f}\n")
            file.write("6 6.0 1 2 3\n1 1.0 -1 -2 -3\n")
            if orbitals:
                file.write(f"{orbitals:5d} " + " ".join(str(7 + i) for i in range(orbitals)) + "\n")
            for row in data.reshape(-1, shape[2] * data.shape[3]):
                for i in range(0, len(row), 6):
                    file.write(" ".join(f"{v:.8E}" for v in row[i : i + 6]) + "\n")
        unit = 1 if angstrom else BOHR
        check(path, data, np.array((-1.5, 2.25, 0.125)) * unit, steps * unit, "A", tolerance=1e-6)


def fortran(value, digits):
    """As Fortran writes it: 0.123D-03, and without the letter where the exponent has three digits."""
    mantissa, exponent = f"{value:.{digits}e}".split("e")
    sign, number = exponent[0], abs(int(exponent))
    return f"{mantissa}D{sign}{number:02d}" if number < 100 else f"{mantissa}{sign}{number:03d}"


def check_cube_of_fortran(folder):
    data = (rng.random((5, 3, 4, 1)) * 2 - 1).astype("f4")
    data.ravel()[:6] = (0, 1e-38, -2.5e-30, 3e38, -1, 7)
    data.ravel()[7] = 0  # what is too small for f32
    path = os.path.join(folder, "fortran.cube")
    with open(path, "w") as file:
        file.write("solid state\nof Fortran\n    1 -1.5D+00 2.25d0 0.125D0\n")
        for n, step in zip((5, 3, 4), np.diag((2.5, 1, 0.5))):
            file.write(f"{n:5d} " + " ".join(fortran(v, 6) for v in step) + "\n")
        file.write("6 6.0D0 1 2 3\n")
        values = [fortran(float(v), 8) for v in data.ravel()]
        values[7] = "0.123-104"
        for i in range(0, len(values), 4):
            file.write(" ".join(values[i : i + 4]) + "\n")
    check(path, data, np.array((-1.5, 2.25, 0.125)) * BOHR, np.diag((2.5, 1, 0.5)) * BOHR, "A", tolerance=1e-6)


def shared(name):
    root = os.environ.get("VOLVIS_SHARED") or os.path.join(os.path.dirname(os.path.abspath(__file__)), *[".."] * 4, "shared")
    return os.path.join(root, "data", "formats", name)


def check_real():
    if not os.path.exists(shared("dx/MRI.data")):
        print(f"{shared('dx/MRI.data')} is not there: real files are skipped")
        return
    mri = np.fromfile(shared("dx/MRI.data"), ">u2").reshape(128, 128, 16, 1)
    check(shared("dx/mri.general"), mri, (0, 0, 0), np.diag((1.773153, 1.773153, 2.066667)), "units")
    with open(shared("dx/imide_potential.dx"), "rb") as file:
        whole = file.read()
    body = whole[whole.index(b"\nend\n") + 5 :]
    imide = np.frombuffer(body[: 4 * 47472], ">f4").reshape(23, 43, 48, 1)
    check(shared("dx/imide_potential.dx"), imide, (9.427, 8.383, 4.3), np.eye(3) * 0.4, "units")
    with open(shared("cube/m4_TotalDensity.cube")) as file:
        lines = file.read().split("\n")
    box = [[float(v) for v in line.split()] for line in lines[2:6]]
    dims = [int(row[0]) for row in box[1:]]
    values = np.array(" ".join(lines[6 + int(box[0][0]) :]).split(), "f4").reshape(*dims, 1)
    check(shared("cube/m4_TotalDensity.cube"), values, np.array(box[0][1:]) * BOHR,
          np.array([row[1:] for row in box[1:]]) * BOHR, "A")


with workplace() as folder:
    check_dx(folder)
    check_dx_defaults(folder)
    check_general(folder)
    check_cube(folder)
    check_cube_of_fortran(folder)
    check_real()
failures += not tool.end()
print(f"{checks} checks, {failures} failed")
sys.exit(1 if failures else 0)
