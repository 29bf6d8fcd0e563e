"""Real files of small formats, against readers that are not ours: VTK for .slc, numpy for raw samples, a few lines of
Python for the packed PVM.

Usage: oracle_small.py IO_TOOL. Exit 77 (skipped) without numpy, or without the real files, which are no part of this
repository.
"""
import gzip
import os
import sys

try:
    import numpy as np
except ImportError as missing:
    print(f"{missing}: skipped")
    sys.exit(77)
try:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOImage import vtkSLCReader
except ImportError as missing:
    vtkSLCReader = None
    print(f"{missing}: .slc is not compared")
from served import Tool, workplace

tool = Tool(sys.argv[1])
SHARED = os.environ.get("VOLVIS_SHARED", os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../../shared"))
DATA = os.path.join(SHARED, "data")
checks = failures = 0


def expect(condition, what):
    global checks, failures
    checks += 1
    if not condition:
        failures += 1
        print("FAILED:", what)


def dump(path):
    """The info and values as [z, y, x]."""
    info, values = tool.read(path)
    if info is None:
        expect(False, f"{path}: {values}")
        return {}, np.zeros(1)
    return info, values.reshape(info["dims"][::-1])


def compare(path, theirs, spacing, unit):
    info, ours = dump(path)
    expect(ours.shape == theirs.shape and np.array_equal(ours, theirs), path + ": other samples")
    expect(info and np.allclose(np.diag(np.array(info["columns"])[:3]), spacing), path + ": other spacing")
    expect(info and info["unit"] == unit, path + ": another unit")


def unpack_dds(data):
    """The bits as text: slow, and as plain as the description of the code."""
    bits, at, out = "".join(f"{byte:08b}" for byte in data[8:]), 0, bytearray()

    def take(n):
        nonlocal at
        at += n
        return int(bits[at - n : at], 2) if n else 0

    assert take(2) == 0, "one byte a sample"
    row = take(16) + 1
    while count := take(7):
        code = take(3)
        width = code + 1 if code else 0
        for _ in range(count):
            value = take(width) - ((1 << width) >> 1) + (out[-1] if out else 0)
            if len(out) > row > 1:
                value += out[-row] - out[-row - 1]
            out.append(value & 255)
    return bytes(out)


def check_slc():
    for name, unit in (("formats/slc/bolt.slc", "um"), ("formats/slc/neghip.slc", "mm"), ("volumes/embryo.slc", "um")):
        reader = vtkSLCReader()
        reader.SetFileName(os.path.join(DATA, name))
        reader.Update()
        image = reader.GetOutput()
        samples = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions()[::-1])
        samples = np.array(samples)
        if "embryo" in name:  # the code of each of its slices ends a voxel early; VTK leaves that as memory was
            samples[:, -1, -1] = 0
        compare(os.path.join(DATA, name), samples, image.GetSpacing(), unit)


def check_headers(folder):
    with gzip.open(os.path.join(DATA, "formats/inr/liver.inr.gz")) as file:
        samples = np.frombuffer(file.read()[256:], "u1").reshape(165, 353, 438)
    compare(os.path.join(DATA, "formats/inr/liver.inr.gz"), samples, (0.617188, 0.617188, 1.33333), "units")
    raw = os.path.join(DATA, "volumes/manix128_128x128x115_u8.raw")
    with open(raw, "rb") as file, open(os.path.join(folder, "manix128.raw"), "wb") as copy:
        copy.write(file.read())
    with open(os.path.join(DATA, "volumes/manix128.dat")) as file, open(os.path.join(folder, "m.dat"), "w") as copy:
        copy.write(file.read())
    compare(os.path.join(folder, "m.dat"), np.fromfile(raw, "u1").reshape(115, 128, 128), (0.49, 0.49, 0.67), "units")


def check_head_of_93_files(folder):
    slices = []
    for k in range(1, 94):
        with open(os.path.join(DATA, f"volumes/headsq/quarter.{k}"), "rb") as file:
            data = file.read()
        slices.append(np.frombuffer(data, "<u2").reshape(64, 64))
        with open(os.path.join(folder, f"quarter.{k}"), "wb") as file:
            file.write(data)
    path = os.path.join(folder, "head.vvh")
    with open(path, "w") as file:
        file.write("# CT of a head\ndims: 64 64 93\ntype: u16\nspacing: 3.2 3.2 1.5\nunit: mm\ndata: quarter.%d 1 93\n")
    compare(path, np.stack(slices), (3.2, 3.2, 1.5), "mm")


def check_pvm():
    path = os.path.join(DATA, "formats/pvm/Bucky.pvm")
    with open(path, "rb") as file:
        stream = unpack_dds(file.read())
    expect(stream.startswith(b"PVM3\n32 32 32\n1 1 1\n1\n"), "Bucky.pvm: another header")
    samples = np.frombuffer(stream[22 : 22 + 32**3], "u1").reshape(32, 32, 32)
    expect(np.abs(np.diff(samples.astype(int), axis=0)).mean() < 20, "Bucky.pvm is not smooth")
    compare(path, samples, (1, 1, 1), "units")


if not os.path.isdir(DATA):
    print(f"{DATA} is not there: skipped")
    sys.exit(77)
with workplace() as folder:
    if vtkSLCReader:
        check_slc()
    check_headers(folder)
    check_head_of_93_files(folder)
    check_pvm()
failures += not tool.end()
print(f"{checks} checks, {failures} failed")
sys.exit(1 if failures else 0)
