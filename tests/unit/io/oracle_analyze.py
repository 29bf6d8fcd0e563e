"""nibabel and VolVis read the same from Analyze 7.5 pairs: values, places, both byte orders, SPM's scale and origin.

Usage: oracle_analyze.py IO_TOOL. Exit 77 (skipped) without numpy or nibabel.
"""
import itertools
import os
import sys

try:
    import nibabel as nib
    import numpy as np
except ImportError as missing:
    print(f"{missing}: skipped")
    sys.exit(77)
from served import Tool, workplace

tool = Tool(sys.argv[1])
checks = failures = 0


def expect(condition, what):
    global checks, failures
    checks += 1
    if not condition:
        failures += 1
        print("FAILED:", what)


def dump(path):
    """The info, its affine, and values as [t, z, y, x]."""
    info, values = tool.read(path)
    if info is None:
        expect(False, f"{path}: {values}")
        return None, None, None
    affine = np.eye(4)
    affine[:3, :] = np.array(info["columns"]).T
    return info, affine, values.reshape(values.shape[:-1])


def compare(path):
    theirs = nib.load(path)
    values = np.asanyarray(theirs.dataobj).astype("f8")
    values = values.reshape(values.shape + (1,) * (4 - values.ndim)).transpose(3, 2, 1, 0)
    for name in (path, path[:-4] + (".img" if path.endswith(".hdr") else ".hdr")):
        info, affine, ours = dump(name)
        if info is None:
            continue
        expect(ours.shape == values.shape and np.allclose(ours, values, rtol=1e-6), name + ": values differ")
        expect(np.allclose(affine, theirs.affine, atol=1e-4), f"{name}: the place differs: {affine} {theirs.affine}")
        expect(info["unit"] == "mm" and info["space"] == 1, name + ": unit or space")


def check_all(folder):
    rng = np.random.default_rng(1994)
    kinds = (nib.AnalyzeImage, nib.Spm99AnalyzeImage, nib.Spm2AnalyzeImage)
    shapes = ((7, 5, 3), (1, 1, 1), (2, 3, 5, 4), (13, 1, 2), (3, 2), (5, 7, 2, 1))
    number = 0
    origins = (None, (2, 1, 3), (900, -900, 1))
    for kind, order, dtype in itertools.product(kinds, "<>", ("u1", "i2", "i4", "f4", "f8", "u2", "u4")):
        origin = origins[number % 3]
        if dtype in ("u2", "u4") and kind is nib.AnalyzeImage:
            continue
        shape = shapes[number % 6]
        header = kind.header_class(endianness=order)
        try:
            header.set_data_dtype(dtype)
        except nib.spatialimages.HeaderDataError:
            continue
        header.set_data_shape(shape)
        header.set_zooms((0.7, 1.1, 2.3, 2.0)[: len(shape)])
        data = (rng.random(shape) * 100).astype(np.dtype(dtype).newbyteorder(order))
        raw = bytearray(header.binaryblock)
        number += 1
        if origin and kind is not nib.AnalyzeImage:
            raw[253:259] = np.array(origin, order + "i2").tobytes()
        if number % 2 and kind is not nib.AnalyzeImage:
            raw[112:116] = np.array([0.25], order + "f4").tobytes()
        if number % 4 == 1 and kind is nib.Spm2AnalyzeImage:
            raw[116:120] = np.array([-30], order + "f4").tobytes()
        if number % 4 == 2:
            raw[124:132] = np.array([50, 10], order + "f4").tobytes()
            raw[140:148] = np.array([200, 0], order + "i4").tobytes()
        path = os.path.join(folder, f"a{number:03d}.hdr")
        with open(path, "wb") as file:
            file.write(raw)
        with open(path[:-4] + ".img", "wb") as file:
            file.write(data.tobytes(order="F"))
        compare(path)


with workplace() as folder:
    check_all(folder)
failures += not tool.end()
print(f"{checks} checks, {failures} failed")
sys.exit(1 if failures else 0)
