"""Independent readers read what VolVis writes, and VolVis reads what independent writers write: numpy and nibabel.

Usage: oracle.py IO_TOOL. Exit 77 (skipped) without numpy; the NIfTI half is left out, and said, without nibabel.
"""
import itertools
import json
import os
import sys
import zipfile

try:
    import numpy as np
except ImportError:
    print("numpy is missing: skipped")
    sys.exit(77)
try:
    import nibabel as nib
except ImportError:
    nib = None
    print("nibabel is missing: only numpy is asked")
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


def affine_of(info):
    out = np.eye(4)
    out[:3, :] = np.array(info["columns"]).T
    return out


def our_samples(path, info):
    """Values as [t, z, y, x, c]."""
    x, y, z = info["dims"]
    return np.fromfile(path, "<f8").reshape(info["frames"], z, y, x, info["components"])


def their_nifti(path):
    """Values as [t, z, y, x, c] and the affine, by nibabel."""
    image = nib.load(path)
    if image.get_data_dtype().fields:
        raw = np.asanyarray(image.dataobj)
        parts = np.stack([raw[n] for n in raw.dtype.names], axis=-1).astype("f8")  # x y z c
        data = parts.reshape(parts.shape[:3] + (1, parts.shape[-1]))
    else:
        data = np.asanyarray(image.dataobj).astype("f8")
        data = data.reshape(data.shape + (1,) * (5 - data.ndim))
    return data.transpose(3, 2, 1, 0, 4), image


def their_npy(path, info):
    data = np.load(path).astype("f8")
    x, y, z = info["dims"]
    return data.reshape(info["frames"], z, y, x, info["components"])


def check_written(folder):
    code, listing, error = tool.ask("write", folder)
    expect(code == 0, "io_tool write: " + error)
    for line in listing.splitlines():
        path, text = line.split("\t")
        info = json.loads(text)
        ours = our_samples(path + ".f64", info)
        if path.endswith(".npy"):
            theirs = their_npy(path, info)
            expect(np.array_equal(ours, theirs), path + ": numpy reads other samples")
            continue
        if nib is None:
            continue
        theirs, image = their_nifti(path)
        expect(theirs.shape == ours.shape, f"{path}: nibabel finds {theirs.shape}, not {ours.shape}")
        expect(np.allclose(ours, theirs, rtol=1e-12, atol=0), path + ": nibabel reads other values")
        expect(np.allclose(image.affine, affine_of(info), atol=1e-5), path + ": nibabel finds another place")
        expect(np.allclose(image.header.get_qform(), affine_of(info), atol=1e-4), path + ": the qform differs")
        expect(image.header.get_xyzt_units()[0] == "mm", path + ": the unit differs")


def dump(path):
    info, values = tool.read(path)
    if info is None:
        expect(False, f"{path}: {values}")
        return None, None
    return info, values


def check_numpy(folder):
    rng = np.random.default_rng(1994)
    types = "u1 i1 u2 i2 u4 i4 u8 i8 f2 f4 f8 ?".split()
    number = 0
    for name, order, fortran in itertools.product(types, "<>", (False, True)):
        for shape in ((6, 5), (4, 3, 5), (2, 3, 4, 5), (2, 2, 3, 5, 2)):
            data = (rng.random(shape) * 100).astype(np.dtype(name).newbyteorder(order))
            if fortran:
                data = np.asfortranarray(data)
            path = os.path.join(folder, f"n{number:04d}.npy")
            number += 1
            np.save(path, data)
            info, ours = dump(path)
            if info is None:
                continue
            axes = {2: (1, 1) + shape + (1,), 3: (1,) + shape + (1,), 4: shape + (1,), 5: shape}[len(shape)]
            expect(np.array_equal(ours, data.astype("f8").reshape(axes)), path + f": {data.dtype} {shape} differs")
    for shape, place in (((5, 6, 3), (1, 1, 5, 6, 3)), ((4, 5, 6, 4), (1, 4, 5, 6, 4))):
        path = os.path.join(folder, f"c{number:04d}.npy")
        number += 1
        data = rng.integers(0, 256, shape, dtype="u1")
        np.save(path, data)
        info, ours = dump(path)
        expect(info is not None and np.array_equal(ours, data.astype("f8").reshape(place)), path + ": colours differ")


def check_axes(folder):
    """A short last axis is one of components; a part says anything else."""
    rng = np.random.default_rng(1994)
    data = rng.random((6, 7, 5, 3)).astype("f4")
    path = os.path.join(folder, "axes.npy")
    np.save(path, data)
    for order in (None, "zyxc", "tzyx", "czyx", "xyzc", "xyzt"):
        info, ours = tool.read(path, order or "")
        expect(info is not None, f"{order}: {ours}")
        letters = order or "zyxc"
        want = data.transpose([letters.index(c) for c in "tzyxc" if c in letters])
        for axis, letter in enumerate("tzyxc"):
            want = want if letter in letters else np.expand_dims(want, axis)
        expect(info and np.array_equal(np.asarray(ours).ravel(), want.astype("f8").ravel()) and
               [info["frames"], *info["dims"][::-1], info["components"]] == list(want.shape), f"axes {order}: {info}")
    for bad in ("zyx", "zyxx", "zyxq", "zyxct"):
        info, error = tool.read(path, bad)
        expect(info is None and "a letter of t, z, y, x, c for each" in error, f"{bad}: {error}")
    for shape, frames in (((6, 7, 5, 4), 1), ((6, 7, 5, 5), 6), ((6, 3, 5, 3), 6), ((2, 5, 6, 2), 2), ((5, 6, 7, 1), 1)):
        np.save(path, np.zeros(shape, "i2"))
        info, _ = tool.read(path)
        expect(info and info["frames"] == frames, f"{shape}: {info}")


def check_npz(folder):
    """Archives of numpy, stored and deflated; arrays are parts."""
    rng = np.random.default_rng(1994)
    arrays = {"times": np.arange(4.0), "flow": rng.random((6, 7, 5, 3)).astype("f4"),
              "cells": np.asfortranarray(rng.integers(0, 9, (4, 5, 6)).astype(">i2")),
              "names": np.array(["a", "b"]), "in/side": rng.random((3, 200, 300)).astype("f8")}
    for save in (np.savez, np.savez_compressed):
        path = os.path.join(folder, "a.npz")
        save(path, **arrays)
        for part in (None, "flow", "cells", "times", "in/side", "flow,zyxc", "flow,czyx"):
            info, ours = tool.read(path, part or "")
            expect(info is not None, f"{save.__name__} {part}: {ours}")
            data = arrays[(part or "flow").split(",")[0]]
            want = data.transpose(1, 2, 3, 0) if part and part.endswith("czyx") else data
            expect(info and np.array_equal(np.asarray(ours).ravel(), want.astype("f8").ravel()), f"{save.__name__} {part}")
        for part, words in (("none", "has no array 'none'"), ("names", "of type 'U1'"), ("flow,zy", "a letter of")):
            info, error = tool.read(path, part)
            expect(info is None and words in error, f"{part}: {error}")
        with open(path, "rb") as file:
            whole = file.read()
        for cut in (10, 100, len(whole) // 2, len(whole) - 30):
            with open(path, "wb") as file:
                file.write(whole[:cut])
            info, error = tool.read(path)
            expect(info is None, f"{save.__name__}: read although cut at {cut}")


def check_npz_written(folder):
    """What numpy and its zipfile read of ours; damage is told, whichever byte of the samples it is in."""
    rng = np.random.default_rng(1994)
    paths = [os.path.join(folder, name) for name in ("from.npy", "to.npz", "back.npy")]
    for name, shape in itertools.product("u1 i1 u2 i2 u4 i4 u8 i8 f4 f8".split(), ((7, 11, 13), (2, 5, 7, 11), (2, 5, 7, 11, 3))):
        data = (rng.random(shape) * 100).astype(name)
        np.save(paths[0], data)
        for encoding, big in (("deflate", False), ("raw", True)):
            code, _, error = tool.ask("copy", *paths[:2], encoding, *["big"] * big)
            expect(code == 0, f"{name} {shape} {encoding}: {error}")
            theirs = np.load(paths[1])
            expect(theirs.files == ["data"] and theirs["data"].dtype == np.dtype(name).newbyteorder("<>"[big]) and
                   np.array_equal(theirs["data"], data), f"{name} {shape} {encoding}: numpy reads something else")
            entry = zipfile.ZipFile(paths[1]).infolist()[0]
            expect(entry.compress_type == (zipfile.ZIP_STORED if big else zipfile.ZIP_DEFLATED), f"{entry}")
            code, _, error = tool.ask("copy", *paths[1:])
            expect(code == 0 and np.array_equal(np.load(paths[2]), data), f"{name} {shape} {encoding}: {error}")
    with open(paths[1], "rb") as file:
        whole = file.read()
    start, size = whole.index(b"\n", whole.index(b"NUMPY")) + 1, data.nbytes
    expect(start % 64 == 0, f"samples begin at {start}: they cannot be mapped")
    for at in (start, start + size // 2, start + size - 1):
        with open(paths[1], "wb") as file:
            file.write(whole[:at] + bytes([whole[at] ^ 16]) + whole[at + 1:])
        code, _, error = tool.ask("copy", *paths[1:])
        expect(code != 0 and "array 'data'" in error and "CRC-32 is" in error and "damaged" in error, f"{at}: {error}")


def check_npz_damage(folder):
    """Archives of numpy whose CRC-32 is another: deflated, stored, stored in an order that is not the machine's."""
    path = os.path.join(folder, "damaged.npz")
    for save, order in ((np.savez_compressed, "<"), (np.savez, "<"), (np.savez, ">")):
        save(path, a=np.arange(7 * 11 * 13, dtype=order + "i2").reshape(7, 11, 13))
        with open(path, "rb") as file:
            whole = bytearray(file.read())
        whole[whole.rindex(b"PK\1\2") + 16] ^= 1
        with open(path, "wb") as file:
            file.write(whole)
        info, error = tool.read(path)
        expect(info is None and "CRC-32 is" in error and "the file says" in error, f"{save.__name__} {order}: {error}")


def check_nibabel(folder):
    rng = np.random.default_rng(1994)
    number = 0
    types = [np.dtype(t) for t in "u1 i1 u2 i2 u4 i4 u8 i8 f4 f8".split()]
    for order, signs in itertools.product(itertools.permutations(range(3)), itertools.product((1, -1), repeat=3)):
        for form in ("sform", "qform", "both"):
            affine = np.eye(4)
            affine[:3, :3] = 0
            for a in range(3):
                affine[order[a], a] = signs[a] * (0.7, 1.1, 2.3)[a]
            affine[:3, 3] = (10, -20, 30.5)
            shape = ((7, 5, 3), (7, 5, 3, 2), (7, 5, 3, 1, 3))[number % 3]
            dtype = types[number % len(types)]
            data = (rng.random(shape) * 100).astype(dtype)
            kind = (nib.Nifti1Image, nib.Nifti2Image)[number % 2]
            image = kind(data, affine, dtype=dtype)
            image.header.set_xyzt_units("mm", "sec")
            image.set_sform(affine, 1 if form != "qform" else 0)
            image.set_qform(affine, 1 if form != "sform" else 0)
            if number % 4 == 0:
                image = kind(data, affine, image.header.as_byteswapped(">"), dtype=dtype)
                image.set_sform(affine, 1)
            path = os.path.join(folder, f"b{number:04d}" + (".nii", ".nii.gz")[number % 2])
            number += 1
            nib.save(image, path)
            info, ours = dump(path)
            if info is None:
                continue
            theirs, again = their_nifti(path)
            expect(np.allclose(ours, theirs, rtol=1e-6), path + ": values differ")
            # nibabel takes the root of rounding errors in half turns of NIfTI-1; the format's own code does not, nor do we
            expect(np.allclose(affine_of(info), again.affine, atol=2e-3), path + ": the place differs")
            expect(np.allclose(affine_of(info), affine, atol=1e-4), path + ": the place is not what was asked for")


def check_pairs(folder):
    data = np.arange(105, dtype="i2").reshape(7, 5, 3)
    path = os.path.join(folder, "pair.hdr")
    nib.save(nib.Nifti1Pair(data, np.diag((2, 2, 3, 1))), path)
    for name in (path, path[:-3] + "img"):
        info, ours = dump(name)
        expect(info is not None and np.array_equal(ours[0, ..., 0].transpose(2, 1, 0), data), name + " differs")


with workplace() as folder:
    check_written(folder)
    check_numpy(folder)
    check_axes(folder)
    check_npz(folder)
    check_npz_written(folder)
    check_npz_damage(folder)
    if nib is not None:
        check_nibabel(folder)
        check_pairs(folder)
failures += not tool.end()
print(f"{checks} checks, {failures} failed")
sys.exit(1 if failures else 0)
