"""h5py and nibabel write HDF5 files in many dialects; VolVis reads the same numbers at the same places.

Usage: hdf5_oracle.py VOLVIS IO_TOOL [--no-safe] [TEST...]: read by the import program, or in the program itself. Exit 77
(skipped) without numpy or h5py. Real files are tested where they are there.

Samples and places are what io_tool reads; what the program says of a file, and how it ends, is the program's.
"""
import itertools
import json
import os
import subprocess
import sys

try:
    import h5py
    import numpy as np
except ImportError:
    print("numpy or h5py is missing: skipped")
    sys.exit(77)
try:
    import nibabel as nib
except ImportError:
    nib = None
    print("nibabel is missing: MINC is left out")

sys.path.insert(1, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../cli"))
from harness import VOLVIS, volvis
from served import Tool, workplace

how = [word for word in sys.argv[3:] if word.startswith("--")]
tool = Tool(sys.argv[2], *([] if how else [os.path.join(os.path.dirname(VOLVIS), "volvis-import")]))
rng = np.random.default_rng(1994)
failures = 0
checks = 0
files = 0
folder = None


def expect(condition, what):
    global failures, checks
    checks += 1
    if not condition:
        failures += 1
        print("FAILED:", what)


def run(*words):
    return volvis(*words, *how)


def info(path):
    done = run("info", path, "--json")
    expect(done.code == 0, path + ": " + done.message)
    return done.json if done.code == 0 else None


def read(path):
    """Info and stored numbers as [t, z, y, x, c] of FILE or FILE:PART."""
    global files
    files += 1
    file, _, part = path.partition(":")
    said, data = tool.samples(file, part)
    expect(said is not None, f"{path}: {data}")
    return said, data if said else np.zeros((1, 1, 1, 1, 1))


def same(path, expected, what, axes=True):
    """The info. Without axes nobody asks what the program takes the axes for."""
    said, got = read(path)
    if not axes and got.size == expected.size:
        got = got.reshape(expected.shape)
    good = got.shape == expected.shape and np.array_equal(got, expected, equal_nan=got.dtype.kind == "f")
    expect(good, f"{path}: {what}: {got.shape} {got.dtype}, expected {expected.shape} {expected.dtype}")
    return said


def steps_of(said):
    """World steps along x, y and z, in rows, as long as the spacing."""
    return np.array(said["columns"][:3])


def spacing_of(said):
    return np.linalg.norm(steps_of(said), axis=1)


def origin_of(said):
    return np.array(said["columns"][3])


def refused(path, *words):
    done = run("convert", path, "-o", path_of("refused.npy"), "--overwrite")
    text = done.message
    expect(done.code > 0 and done.code not in (139, 134), f"{path} is not refused: {done.code}")
    expect(all(word in text for word in words), f"{path}: '{text.strip()}' lacks {words}")
    expect(text.count("\n") <= 2, f"{path}: more than a sentence: {text}")


def path_of(name):
    return os.path.join(folder, name)


def random(shape, dtype):
    dtype = np.dtype(dtype)
    if dtype.kind == "b":
        return rng.integers(0, 2, shape).astype("?")
    if dtype.kind == "f":
        return rng.normal(0, 100, shape).astype(dtype)
    limits = np.iinfo(dtype)
    return rng.integers(limits.min, limits.max, shape, dtype=dtype.newbyteorder("="), endpoint=True).astype(dtype)


def five(data, roles):
    """An array with these axes as [t, z, y, x, c]."""
    for role in "tzyxc":
        if role not in roles:
            data = data[..., np.newaxis]
            roles += role
    return data.transpose([roles.index(role) for role in "tzyxc"])


STORAGES = [{}, {"chunks": True}, {"chunks": True, "compression": "gzip"}, {"compression": "gzip", "shuffle": True},
            {"chunks": True, "compression": "gzip", "shuffle": True, "fletcher32": True},
            {"chunks": True, "compression": "szip"}, {"chunks": True, "compression": "lzf"}]


def test_every_type_in_every_storage():
    types = "u1 i1 u2 i2 u4 i4 u8 i8 f2 f4 f8 ?".split()
    for number, (name, order, storage) in enumerate(itertools.product(types, "<>", STORAGES)):
        shape = [(6, 5), (7, 3, 5), (1, 1, 1), (2, 13, 11)][number % 4]
        data = random(shape, np.dtype(name).newbyteorder(order))
        if number % 3 and name not in ("u2", "f4"):
            continue
        if storage.get("compression") == "szip" and (name == "?" or data.size < 32):
            continue
        path = path_of("type.h5")
        with h5py.File(path, "w", libver=("earliest", "latest")[number % 2]) as file:
            file.create_dataset("data", data=data, **storage)
        axes = "yx" if len(shape) == 2 else "zyx"
        if name == "f2":
            data = data.astype("f4")
        same(path, five(data.astype(data.dtype.newbyteorder("=")), axes), f"{name} {order} {shape} {storage}", False)


def test_chunks_of_any_shape():
    data = random((11, 17, 23), "<u2")
    for chunks in ((1, 17, 23), (11, 1, 1), (2, 3, 5), (11, 17, 23), (4, 16, 16), (1, 1, 23), (7, 7, 7)):
        for storage in ({}, {"compression": "gzip"}, {"compression": "gzip", "shuffle": True}):
            with h5py.File(path_of("chunks.h5"), "w") as file:
                file.create_dataset("a/b/data", data=data, chunks=chunks, **storage)
            same(path_of("chunks.h5"), five(data, "zyx"), f"chunks {chunks} {storage}", False)


def test_filters_of_others():
    try:
        import numcodecs
    except ImportError:
        print("numcodecs is missing: Zstandard, Blosc and LZ4 are left out")
        return

    def lz4(data):
        packed = numcodecs.LZ4().encode(data)[4:]
        return len(data).to_bytes(8, "big") + len(data).to_bytes(4, "big") + len(packed).to_bytes(4, "big") + packed

    data = np.arange(8 * 6 * 10, dtype="<i4").reshape(8, 6, 10) // 3
    for number, pack in ((32015, lambda d: numcodecs.Zstd().encode(d)), (32001, lambda d: numcodecs.Blosc().encode(d)),
                         (32004, lz4)):
        with h5py.File(path_of("filter.h5"), "w") as file:
            creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            creation.set_chunk((4, 6, 5))
            creation.set_filter(number, h5py.h5z.FLAG_OPTIONAL, ())
            space = h5py.h5s.create_simple(data.shape)
            place = h5py.h5d.create(file.id, b"data", h5py.h5t.STD_I32LE, space, creation)
            for z, x in itertools.product((0, 4), (0, 5)):
                chunk = np.ascontiguousarray(data[z:z + 4, :, x:x + 5]).tobytes()
                if (z, x) == (4, 5):  # one that was left as it is
                    place.write_direct_chunk((z, 0, x), chunk, filter_mask=1)
                else:
                    place.write_direct_chunk((z, 0, x), bytes(pack(chunk)))
        same(path_of("filter.h5"), five(data, "zyx"), f"filter {number}")
    with h5py.File(path_of("filter.h5"), "w") as file:
        creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        creation.set_chunk((4, 6, 5))
        creation.set_filter(32013, h5py.h5z.FLAG_OPTIONAL, ())
        h5py.h5d.create(file.id, b"data", h5py.h5t.STD_I32LE, h5py.h5s.create_simple(data.shape), creation)
    refused(path_of("filter.h5"), "32013", "zfp")


def test_axes_by_every_convention():
    extents = {"t": 2, "z": 3, "y": 4, "x": 5, "c": 2}

    def tags(roles):
        return json.dumps({"axes": [{"key": r, "typeFlags": 2} for r in roles]})

    for roles in ("zyx", "xyz", "tzyx", "zyxc", "czyx", "tzyxc", "tczyx", "zctxy", "yxc", "yxt"):
        data = random([extents[r] for r in roles], "<i2")
        for convention in ("axes", "names", "list", "axistags", "labels", "scales"):
            with h5py.File(path_of("axes.h5"), "w") as file:
                place = file.create_dataset("exported_data", data=data, chunks=True)
                if convention == "axes":
                    place.attrs["axes"] = roles.upper()
                elif convention == "names":
                    words = {"t": "time", "c": "channel"}
                    place.attrs["axes"] = ",".join(words.get(r, r) for r in roles)
                elif convention == "list":
                    place.attrs["axes"] = list(roles)
                elif convention == "axistags":
                    place.attrs["axistags"] = tags(roles)
                else:
                    for i, r in enumerate(roles):
                        if convention == "labels":
                            place.dims[i].label = r
                        else:
                            name = {"t": "time", "x": "lon", "y": "lat", "z": "lev", "c": "channel"}[r]
                            scale = file.create_dataset(name, data=np.arange(extents[r], dtype="f8"))
                            scale.make_scale(name)
                            place.dims[i].attach_scale(scale)
            same(path_of("axes.h5"), five(data, roles), f"{roles} by {convention}")


MINC_ORDER = []


def test_axes_by_shape():
    cases = [((6, 7), "yx", "f4"), ((5, 6, 7), "zyx", "u1"), ((5, 6, 3), "yxc", "u1"), ((5, 6, 3), "zyx", "u2"),
             ((5, 6, 7, 4), "zyxc", "u1"), ((5, 6, 7, 2), "zyxc", "f4"), ((5, 6, 7, 8), "tzyx", "f4"),
             ((2, 5, 6, 7, 3), "tzyxc", "f4"), ((2, 3, 5, 6, 7), "tczyx", "f4")]
    for shape, roles, name in cases:
        data = random(shape, name)
        with h5py.File(path_of("shape.h5"), "w") as file:
            file["data"] = data
        same(path_of("shape.h5"), five(data, roles), f"{shape} {name}")
        said = info(path_of("shape.h5"))
        if name == "u1" and "c" in roles:
            expect(said["meaning"] in ("rgb", "rgba", "RGB", "RGBA"), f"{shape}: meaning {said['meaning']}")


def test_spacing_by_every_convention():
    data = random((4, 5, 6), "u1")
    cases = [({"element_size_um": [3.0, 2.0, 1.0]}, [1, 2, 3], [0, 0, 0], "um"),
             ({"element_size_um": np.array([3, 2, 1], "f4")}, [1, 2, 3], [0, 0, 0], "um"),
             ({"resolution": [40, 4, 4.5], "offset": [400, 8, 9], "unit": "nm"}, [4.5, 4, 40], [9, 8, 400], "nm"),
             ({"spacing": "3 2 1", "origin": [30.0, 20, 10], "units": "millimeters"}, [1, 2, 3], [10, 20, 30], "mm"),
             ({"voxel_size": 2.5}, [2.5, 2.5, 2.5], [0, 0, 0], "units"),
             ({}, [1, 1, 1], [0, 0, 0], "voxels")]
    for attributes, spacing, origin, unit in cases:
        for where in ("data", "group", "file"):
            with h5py.File(path_of("spacing.h5"), "w") as file:
                place = file.create_dataset("group/data", data=data)
                on = {"data": place, "group": file["group"], "file": file}[where]
                if where != "data" and ("unit" in attributes or "units" in attributes):
                    continue
                for key, value in attributes.items():
                    on.attrs[key] = value
            said = info(path_of("spacing.h5"))
            expect(np.allclose(said["spacing"], spacing), f"{attributes} on {where}: spacing {said['spacing']}")
            expect(np.allclose(said["origin"], origin), f"{attributes} on {where}: origin {said['origin']}")
            expect(said["unit"] == unit, f"{attributes} on {where}: unit {said['unit']}")


def test_which_data_set_is_read():
    a, b = random((3, 4, 5), "u2"), random((6, 5, 4), "f4")
    with h5py.File(path_of("parts.h5"), "w") as file:
        file["density"] = a
        file["group/speed"] = b
        file["numbers"] = np.arange(10)
        file["words"] = [b"a", b"b"]
        file["pairs"] = np.zeros((3, 3, 3), [("a", "f4"), ("b", "i4")])
        file["soft"] = h5py.SoftLink("/density")
        file["away"] = h5py.ExternalLink("/etc/passwd", "/density")
    refused(path_of("parts.h5"), "2 data sets", "/density", "/group/speed")
    same(path_of("parts.h5") + ":/density", five(a, "zyx"), "part")
    same(path_of("parts.h5") + ":group/speed", five(b, "zyx"), "part")
    refused(path_of("parts.h5") + ":/pairs", "/density")
    refused(path_of("parts.h5") + ":/away", "/density")
    with h5py.File(path_of("parts.h5"), "a") as file:
        file["raw"] = a
    same(path_of("parts.h5"), five(a, "zyx"), "raw is preferred")
    with h5py.File(path_of("none.h5"), "w") as file:
        file["words"] = [b"a", b"b"]
    refused(path_of("none.h5"), "no data set")


def test_fill_values_and_what_is_not_written():
    with h5py.File(path_of("fill.h5"), "w") as file:
        place = file.create_dataset("data", (20, 20, 20), "<i4", chunks=(5, 6, 7), fillvalue=-7, compression="gzip")
        place[3:6, 3:9, 4:5] = 11
        expected = place[...]
    same(path_of("fill.h5"), five(expected, "zyx"), "fill values")
    with h5py.File(path_of("fill.h5"), "w") as file:
        file.create_dataset("data", (9, 8, 7), "<f4", fillvalue=2.5)
    same(path_of("fill.h5"), np.full((1, 9, 8, 7, 1), 2.5, "f4"), "nothing written")


def test_odd_integers_and_enumerations():
    data = rng.integers(0, 4095, (4, 5, 6)).astype("<u2")
    with h5py.File(path_of("odd.h5"), "w") as file:
        kind = h5py.h5t.STD_U16LE.copy()
        kind.set_precision(12)
        space = h5py.h5s.create_simple(data.shape)
        h5py.h5d.create(file.id, b"data", kind, space).write(h5py.h5s.ALL, h5py.h5s.ALL, data)
    same(path_of("odd.h5"), five(data, "zyx"), "12 bits in 16")
    with h5py.File(path_of("odd.h5"), "w") as file:
        kind = h5py.enum_dtype({"air": 0, "bone": 5, "skin": 9}, basetype="u1")
        file.create_dataset("data", data=(data % 3).astype("u1"), dtype=kind)
    same(path_of("odd.h5"), five((data % 3).astype("u1"), "zyx"), "enumeration")
    expect(info(path_of("odd.h5"))["meaning"] == "label", "an enumeration is a label")
    with h5py.File(path_of("odd.h5"), "w") as file:
        long = data.astype("f16")
        file["data"] = long
    same(path_of("odd.h5"), five(long.astype("f8"), "zyx"), "long double")


def test_blocks_before_the_file_and_packed_files():
    data = random((3, 4, 5), "<f4")
    with h5py.File(path_of("block.h5"), "w", userblock_size=1024) as file:
        file["data"] = data
    same(path_of("block.h5"), five(data, "zyx"), "a block of the user's before")
    subprocess.run(["gzip", "-kf", path_of("block.h5")], check=True)
    same(path_of("block.h5.gz"), five(data, "zyx"), "gzip around")


def test_matlab_arrays_are_turned():
    data = random((4, 6, 5), "<f8")
    with h5py.File(path_of("m.mat"), "w", userblock_size=512) as file:
        file.create_dataset("V", data=data).attrs["MATLAB_class"] = np.bytes_("double")
    same(path_of("m.mat"), five(data, "zxy"), "MATLAB")


def test_what_lies_elsewhere_is_refused():
    with h5py.File(path_of("virtual.h5"), "w", libver="latest") as file:
        layout = h5py.VirtualLayout(shape=(4, 4, 4), dtype="u1")
        layout[0] = h5py.VirtualSource(path_of("fill.h5"), "data", shape=(9, 8, 7))[0, :4, :4]
        file.create_virtual_dataset("data", layout)
    refused(path_of("virtual.h5"), "other files")
    with h5py.File(path_of("external.h5"), "w") as file:
        file.create_dataset("data", (4, 4, 4), "u1", external=[("/etc/passwd", 0, 64)])
    refused(path_of("external.h5"), "other files")


def test_a_damaged_chunk_is_filled_and_said():
    data = random((16, 16, 16), "<f4")
    with h5py.File(path_of("damage.h5"), "w") as file:
        place = file.create_dataset("data", data=data, chunks=(4, 16, 16), compression="gzip")
        at = place.id.get_chunk_info(2)
    with open(path_of("damage.h5"), "r+b") as file:
        file.seek(at.byte_offset)
        file.write(b"\xff" * 100)
    done = run("convert", path_of("damage.h5"), "-o", path_of("damage.npy"))
    expect(done.code == 7, f"exit code {done.code}: {done.message}")
    expect("3072 of 4096 numbers" in done.message, done.message)
    got = np.load(path_of("damage.npy"))
    lo = at.chunk_offset[0]
    expect(np.isnan(got[lo:lo + 4]).all(), "the chunk is not NaN")
    got[lo:lo + 4] = data[lo:lo + 4]
    expect(np.array_equal(got, data), "the others differ")


def test_a_file_that_is_cut_short():
    data = random((32, 16, 16), "<f4")
    for chunks in (None, (4, 16, 16)):
        with h5py.File(path_of("whole.h5"), "w") as file:
            file.create_dataset("data", data=data, chunks=chunks)
        whole = open(path_of("whole.h5"), "rb").read()
        for share in (0.3, 0.7, 0.9):
            with open(path_of("cut.h5"), "wb") as file:
                file.write(whole[:int(len(whole) * share)])
            done = run("convert", path_of("cut.h5"), "-o", path_of("cut.npy"))
            expect(done.code in ((7,) if share > 0.5 else (3, 4, 5, 6)), f"{share} {chunks}: {done.code} {done.message}")
            if done.code == 7:
                got = np.load(path_of("cut.npy"))
                there = ~np.isnan(got)
                expect(there.mean() > share - 0.2 and np.array_equal(got[there], data[there]), f"{share} {chunks}")


def shared(name):
    root = os.environ.get("VOLVIS_SHARED") or os.path.join(os.path.dirname(__file__), "../../../../shared")
    path = os.path.join(root, "data", name)
    if not os.path.exists(path):
        print(path, "is not there: left out")
        return None
    return path


def write(source, path, *words):
    code, _, error = tool.ask("copy", source, path, *words)
    expect(code == 0, f"{source} is not written: {error}")


def test_what_we_write_by_h5py():
    for number, name in enumerate("u1 i1 u2 i2 u4 i4 u8 i8 f4 f8".split()):
        for shape in ((1, 1, 1), (2, 3, 5), (7, 5, 11), (40, 3, 130)):
            data = random(shape, name)
            np.save(path_of("in.npy"), data)
            words = [(), ("raw",)][number % 2]
            write(path_of("in.npy"), path_of("w.h5"), *words)
            with h5py.File(path_of("w.h5")) as file:
                place = file["volume"]
                expect(np.array_equal(place[...], data) and place.dtype == data.dtype, f"{name} {shape}")
                axes = place.attrs["axes"]
                expect((axes.decode() if isinstance(axes, bytes) else axes) == "zyx", f"axes {axes}")
                expect(place.compression == (None if words else "gzip"), "compression")
            same(path_of("w.h5"), five(data, "zyx"), f"written {name} {shape}", False)
    data = random((2, 3, 4, 5, 6), "f4")
    with h5py.File(path_of("in.h5"), "w") as file:
        place = file.create_dataset("data", data=data)
        place.attrs["axes"] = "tczyx"
        place.attrs["element_size_um"] = [3.0, 2.0, 1.5]
    write(path_of("in.h5"), path_of("w.h5"))
    with h5py.File(path_of("w.h5")) as file:
        place = file["volume"]
        expect(np.array_equal(place[...], data.transpose(0, 2, 3, 4, 1)), "tzyxc")
        expect(np.allclose(place.attrs["element_size_um"], [3, 2, 1.5]), "element_size_um")
        expect(np.allclose(place.attrs["directions"], np.diag([1.5, 2, 3])), "directions")


def test_real_plant_ovule():
    path = shared("formats/hdf5/sample_ovule.h5")
    if not path:
        return
    with h5py.File(path) as file:
        same(path, five(file["raw"][...], "zyx"), "raw")
        same(path + ":label", five(file["label"][...], "zyx"), "label")
    said = info(path)
    expect(np.allclose(said["spacing"], [0.15, 0.15, 0.235]) and said["unit"] == "um", str(said))


def check_minc(path, what):
    """Values and places as nibabel has them: its axes are those of the file, ours x, y, z."""
    image = nib.load(path)
    order = MINC_ORDER
    data = np.asanyarray(image.dataobj)
    said, stored = read(path)
    expect(said["space"] == 1 and said["unit"] == "mm", what + ": space")
    roles = [{"time": "t"}.get(n, n[0]) for n in order]
    theirs = five(data, roles)
    ours = stored.astype("f8") * said["scale"] + said["offset"]
    expect(ours.shape == theirs.shape and np.allclose(ours, theirs, rtol=2e-6, atol=2e-5), what + ": values")
    space = [r for r in roles if r != "t"]
    affine = image.affine
    for axis, role in enumerate("xyz"):
        column = affine[:3, space.index(role)]
        step = steps_of(said)[axis]
        expect(np.allclose(step, column, atol=1e-9), f"{what}: {role} runs along {step}, not {column}")
    expect(np.allclose(origin_of(said), affine[:3, 3], atol=1e-9), f"{what}: origin {origin_of(said)}")


def write_minc(path, data, order, steps, starts, cosines, low=None, high=None, valid=None):
    with h5py.File(path, "w") as file:
        top = file.create_group("minc-2.0")
        for name in order:
            place = top.create_dataset("dimensions/" + name, data=0.0)
            place.attrs["spacing"] = np.bytes_("regular__")
            place.attrs["step"] = steps.get(name, 1.0)
            place.attrs["start"] = starts.get(name, 0.0)
            place.attrs["units"] = np.bytes_("mm" if name != "time" else "s")
            if name in cosines:
                place.attrs["direction_cosines"] = cosines[name]
        image = top.create_dataset("image/0/image", data=data, compression="gzip")
        image.attrs["dimorder"] = np.bytes_(",".join(order))
        if valid is not None:
            image.attrs["valid_range"] = np.array(valid, "f8")
        for name, value in (("min", low), ("max", high)):
            value = np.asarray(value if value is not None else (0.0, 1.0)[name == "max"], "f8")
            ends = top.create_dataset("image/0/image-" + name, data=value)
            ends.attrs["dimorder"] = np.bytes_(",".join(order[:value.ndim]))


def test_minc_in_every_order():
    global MINC_ORDER
    if nib is None:
        return
    turn = np.array([[0.8, 0.6, 0], [-0.6, 0.8, 0], [0, 0, 1]])
    names = ("xspace", "yspace", "zspace")
    number = 0
    for order in itertools.permutations(names):
        for signs in itertools.product((1, -1), repeat=3):
            for time in (number % 2 == 0,):
                number += 1
                dims = {"xspace": 5, "yspace": 3, "zspace": 4, "time": 2}
                MINC_ORDER = (["time"] if time else []) + list(order)
                shape = [dims[n] for n in MINC_ORDER]
                data = random(shape, ("u1", "i1", "u2", "i2", "i4")[number % 5])
                scaling = number % 4
                ends = {0: ((), ()), 1: shape[:1], 2: shape[:2], 3: shape[:1]}[scaling]
                low = -rng.random(ends if scaling else ()) * 10
                high = rng.random(ends if scaling else ()) * 50 + 1
                steps = {n: s * v for n, s, v in zip(names, signs, (1, 1.5, 2.25))}
                path = path_of("a.mnc")
                write_minc(path, data, MINC_ORDER, steps, {"xspace": 10, "yspace": -20.5, "zspace": 3},
                           {n: turn[i] for i, n in enumerate(names)}, low, high)
                check_minc(path, f"{MINC_ORDER} {signs} {data.dtype} {scaling}")
    expect(number == 48, "48 orientations")


def test_minc_of_floats_and_of_lies():
    global MINC_ORDER
    MINC_ORDER = ["zspace", "yspace", "xspace"]
    data = random((3, 4, 5), "f4")
    write_minc(path_of("f.mnc"), data, MINC_ORDER, {}, {}, {})
    same(path_of("f.mnc"), five(data, "zyx"), "floats")
    expect(info(path_of("f.mnc"))["format"] == "minc", "the format's name")
    with h5py.File(path_of("f.mnc"), "a") as file:
        file["minc-2.0/dimensions/zspace"].attrs["step"] = 0.0
    refused(path_of("f.mnc"), "step")
    write_minc(path_of("f.mnc"), data, ["zspace", "yspace", "xspace"], {}, {}, {})
    with h5py.File(path_of("f.mnc"), "a") as file:
        file["minc-2.0/image/0/image"].attrs["dimorder"] = np.bytes_("zspace,xfrequency,xspace")
    refused(path_of("f.mnc"), "xfrequency")


def letters(text):
    return np.frombuffer(str(text).encode(), "S1")


def write_imaris(path, data, extents, unit="um", padding=(0, 0, 0), levels=1):
    """data as [t, c, z, y, x]; coarser levels take every second sample."""
    with h5py.File(path, "w") as file:
        image = file.create_group("DataSetInfo/Image")
        for axis, n in zip("ZYX", data.shape[2:]):
            image.attrs[axis] = letters(n)
        for axis in range(3):
            image.attrs[f"ExtMin{axis}"] = letters(extents[axis][0])
            image.attrs[f"ExtMax{axis}"] = letters(extents[axis][1])
        image.attrs["Unit"] = letters(unit)
        image.attrs["Name"] = letters("a cell")
        for c in range(data.shape[1]):
            channel = file.create_group(f"DataSetInfo/Channel {c}")
            channel.attrs["Name"] = letters(f"stain {c}")
            channel.attrs["Color"] = letters("1.000 0.500 0.000")
            channel.attrs["ColorRange"] = letters("10.000 200.000")
        times = file.create_group("DataSetInfo/TimeInfo")
        for t in range(data.shape[0]):
            times.attrs[f"TimePoint{t + 1}"] = letters(f"2021-03-04 05:06:{7 + 2.5 * t:06.3f}")
        for level in range(levels):
            for t, c in np.ndindex(data.shape[:2]):
                part = data[t, c, ::2**level, ::2**level, ::2**level]
                group = file.create_group(f"DataSet/ResolutionLevel {level}/TimePoint {t}/Channel {c}")
                for axis, n in zip("ZYX", part.shape):
                    group.attrs["ImageSize" + axis] = letters(n)
                filled = np.pad(part, [(0, p) for p in padding], constant_values=99)
                group.create_dataset("Data", data=filled, chunks=tuple(min(4, n) for n in filled.shape),
                                     compression="gzip")


def test_imaris():
    extents = [(10, 16), (-5, 0), (0, 8)]
    for number, name in enumerate(("u1", "u2", "f4")):
        for t, c in ((1, 1), (1, 2), (3, 1), (2, 4)):
            data = random((t, c, 8, 5, 12), name)
            path = path_of("a.ims")
            write_imaris(path, data, extents, padding=((0, 0, 0), (2, 3, 4))[number % 2], levels=2)
            said = same(path, data.transpose(0, 2, 3, 4, 1), f"{name} {t} {c}")
            expect(said["format"] == "imaris" and said["unit"] == "um", str(said["format"]))
            expect(np.allclose(spacing_of(said), [0.5, 1, 1]), f"spacing {spacing_of(said)}")
            expect(np.allclose(origin_of(said), [10.25, -4.5, 0.5]), f"origin {origin_of(said)}")
            if t > 1:
                expect(said["step"] == 2.5 and said["step_unit"] == "s", "time step")
            coarse = same(path + ":level1", data[:, :, ::2, ::2, ::2].transpose(0, 2, 3, 4, 1), f"{name} {t} {c} level 1")
            expect(np.allclose(spacing_of(coarse), [1, 5 / 3, 2]), f"spacing of level 1 {spacing_of(coarse)}")
    refused(path + ":level7", "level0 to level1")
    done = run("convert", path, "-o", path_of("out.npy"), "--memory", "0.001M")
    write_imaris(path, random((1, 1, 64, 64, 64), "f8"), extents, levels=3)
    done = run("info", path, "--json", "--memory", "1M")
    said = done.json if done.code == 0 else {}
    expect(said.get("dims") == [64, 64, 64], f"the finest level: {done.message}")
    done = run("render", path, "-o", path_of("level.png"), "--size", "32x32", "--memory", "2500K")
    expect(done.code == 0 and "level 1" in done.message, f"a picture of a level that fits: {done.message}")


def write_bdv(path, data, levels, channels=True, xml=True, stain="0"):
    """data as [t, s, z, y, x]."""
    n_times, n_setups = data.shape[:2]
    with h5py.File(path, "w") as file:
        for s in range(n_setups):
            file[f"s{s:02d}/resolutions"] = np.array([[2.0**n, 2.0**n, 1] for n in range(levels)])
            file[f"s{s:02d}/subdivisions"] = np.full((levels, 3), 4, "i4")
            for t in range(n_times):
                for level in range(levels):
                    part = data[t, s, :, ::2**level, ::2**level]
                    file.create_dataset(f"t{t:05d}/s{s:02d}/{level}/cells", data=part.view("<i2"), chunks=(4, 3, 4),
                                        compression="gzip")
    if xml:
        setups = "".join(f"""<ViewSetup><id>{s}</id><name>stain {s}</name><size>1 1 1</size>
            <voxelSize><unit>micrometer</unit><size>0.5 0.5 2.0</size></voxelSize>
            <attributes><illumination>0</illumination><channel>{s if channels else 0}</channel>
            <angle>{0 if channels else s}</angle></attributes></ViewSetup>""" for s in range(n_setups))
        with open(path[:-3] + ".xml", "w") as file:
            file.write(f"""<?xml version="1.0" encoding="UTF-8"?><SpimData version="0.2">
              <BasePath type="relative">.</BasePath><SequenceDescription><ImageLoader format="bdv.hdf5">
              <hdf5 type="relative">{os.path.basename(path)}</hdf5></ImageLoader><ViewSetups>{setups}
              <Attributes name="channel"><Channel><id>0</id><name>{stain}</name></Channel></Attributes></ViewSetups>
              <Timepoints type="range"><first>0</first><last>{n_times - 1}</last></Timepoints></SequenceDescription>
              <ViewRegistrations/></SpimData>""")


def test_bigdataviewer():
    for t, s in ((1, 1), (2, 1), (1, 3), (2, 2)):
        data = random((t, s, 5, 6, 8), "<u2")
        path = path_of("view.h5")
        write_bdv(path, data, 2)
        for name in (path, path[:-3] + ".xml"):
            said = same(name, data.transpose(0, 2, 3, 4, 1), f"{t} {s}")
            expect(np.allclose(spacing_of(said), [0.5, 0.5, 2]) and said["unit"] == "um", f"{name}: {spacing_of(said)}")
            coarse = same(name + ":s00/1", data[:, :1, :, ::2, ::2].transpose(0, 2, 3, 4, 1), "level 1")
            expect(np.allclose(spacing_of(coarse), [1, 1, 2]), f"{name}: spacing {spacing_of(coarse)}")
            expect(np.allclose(origin_of(coarse), [0.25, 0.25, 0]), f"{name}: origin {origin_of(coarse)}")
            same(name + f":s{s - 1:02d}", data[:, s - 1:].transpose(0, 2, 3, 4, 1), "the last setup")
        same(path + ":/t00000/s00/1/cells", five(data[0, 0, :, ::2, ::2].view("<i2"), "zyx"), "by its path")
    write_bdv(path, data, 1)
    named = [channel["name"] for channel in info(path)["channels"]]
    expect(named == ["stain 0", "stain 1"], f"a channel's number names nothing: {named}")
    write_bdv(path, data, 1, stain="GFP")
    named = [channel["name"] for channel in info(path)["channels"]]
    expect(named == ["GFP", "stain 1"], f"channels are named by the list of channels: {named}")
    write_bdv(path, data, 1, channels=False)
    same(path, data[:, :1].transpose(0, 2, 3, 4, 1), "angles are not put together")
    os.remove(path[:-3] + ".xml")
    same(path, data[:, :1].transpose(0, 2, 3, 4, 1), "without .xml")
    expect(info(path)["unit"] == "voxels", "no spacing without .xml")
    refused(path + ":s07/0", "s00/0")
    with open(path_of("bad.xml"), "w") as file:
        file.write('<SpimData><SequenceDescription><ImageLoader format="bdv.n5"/></SequenceDescription></SpimData>')
    refused(path_of("bad.xml"), "bdv.n5")
    with open(path_of("bad.xml"), "w") as file:
        file.write('<!DOCTYPE a [<!ENTITY b "ccccc">]><SpimData>&b;</SpimData>')
    refused(path_of("bad.xml"), "line 1")
    with open(path_of("bad.xml"), "w") as file:
        file.write('<SpimData><SequenceDescription><ImageLoader><hdf5>/etc/passwd</hdf5></ImageLoader>')
        file.write("</SequenceDescription></SpimData>")
    refused(path_of("bad.xml"), "--allow-outside")


def write_netcdf(path, data, coordinates, aux=None):
    """coordinates: (name, numbers or None, attributes) of each axis."""
    with h5py.File(path, "w") as file:
        place = file.create_dataset("v", data=data)
        for axis, (name, numbers, attributes) in enumerate(coordinates):
            scale = file.create_dataset(name, data=np.zeros(data.shape[axis], "f4") if numbers is None else numbers)
            scale.make_scale("This is a netCDF dimension but not a netCDF variable." if numbers is None else name)
            place.dims[axis].attach_scale(scale)
            for key, value in attributes.items():
                scale.attrs[key] = value
        for name, numbers, attributes in aux or []:
            file[name] = numbers
            for key, value in attributes.items():
                file[name].attrs[key] = value
        if aux:
            place.attrs["coordinates"] = " ".join(name for name, _, _ in aux)


def told(path):
    done = run("info", path, "--json")
    expect(done.code == 0, path + ": " + done.message)
    return done.json, done.message


def test_netcdf_coordinates():
    data = random((3, 4, 5, 6), "f4")
    path = path_of("c.nc")
    metres = {"units": "m"}
    z, y, x = ("height", 100 + 25 * np.arange(4), metres), ("y", 50 - 10 * np.arange(5.0), metres), \
        ("x", (0.1 + 0.1 * np.arange(6)).astype("f4"), metres)
    time = ("time", [0, 6, 12], {"units": "hours since 1970-01-01 00:00:00"})
    write_netcdf(path, data, [time, z, y, x])
    same(path, five(data, "tzyx"), "netCDF")
    said, warned = told(path)
    expect(said["format"] == "netcdf" and said["unit"] == "m" and not warned, f"{said['unit']} {warned}")
    expect(np.allclose(said["spacing"], [0.1, 10, 25]), f"spacing {said['spacing']}")
    expect(np.allclose(said["origin"], [0.1, 50, 100]), f"origin {said['origin']}")
    expect(np.allclose(said["directions"][1], [0, -1, 0]), f"y falls: {said['directions']}")
    expect(said["frame_step"] == 6 and said["frame_unit"] == "h", f"{said['frame_step']} {said['frame_unit']}")
    write_netcdf(path, data, [time, ("height", [5, 20, 50, 845], metres), y, x])
    said, warned = told(path)
    expect("its coordinates along z are uneven (5 .. 845 m); shown as if they were even" in warned, warned)
    expect(np.allclose(said["spacing"], [0.1, 10, 280]), f"spacing {said['spacing']}")
    degrees = [time, ("n", None, {}), ("a", np.arange(5.0), {"units": "degrees_north"}),
               ("b", 2 * np.arange(6.0), {"units": "degrees_east"})]
    write_netcdf(path, data, degrees)
    said, warned = told(path)
    expect("different units" in warned and said["unit"] == "voxels", f"{said['unit']} {warned}")
    write_netcdf(path, data, degrees, [("h", [0.0, 2, 4, 6], {"units": "km", "positive": "up"})])
    expect("z: km" in told(path)[1], told(path)[1])
    flat = random((5, 6), "f4")
    write_netcdf(path, flat, degrees[2:])
    said, warned = told(path)
    expect(said["unit"] == "deg" and np.allclose(said["spacing"][:2], [2, 1]) and not warned, f"{said} {warned}")
    write_netcdf(path, flat, [("lat", [0, 1, np.nan, 3, 4], {}), ("lon", [3, 1, 2, 4, 5, 6], {})])
    expect(told(path)[1].count("neither ascending nor descending") == 2, told(path)[1])


def test_netcdf_axes_in_any_order():
    for roles in ("zyx", "xyz", "txyz", "yxzt", "xzty"):
        data = random([dict(zip("tzyx", (2, 3, 4, 5)))[r] for r in roles], "i2")
        words = [(f"n{r}", np.arange(data.shape[i], dtype="f8"), {"axis": r.upper()}) for i, r in enumerate(roles)]
        write_netcdf(path_of("o.nc"), data, words)
        same(path_of("o.nc"), five(data, roles), f"netCDF {roles}")


def test_netcdf_missing_values():
    for name, order, compression in itertools.product(("f4", "f8"), "<>", (None, "gzip")):
        data = random((3, 4, 5), order + name)
        data[0, 1, 2], data[2, 3, 4] = -999, 1e20
        with h5py.File(path_of("m.nc"), "w") as file:
            place = file.create_dataset("v", data=data, compression=compression)
            place.attrs["_FillValue"] = np.array([-999], data.dtype)
            place.attrs["missing_value"] = data[2, 3, 4]
        data[0, 1, 2] = data[2, 3, 4] = np.nan
        same(path_of("m.nc"), five(data.astype(name), "zyx"), f"missing values {name} {order} {compression}")


def write_values(data, compression=None, **attributes):
    with h5py.File(path_of("m.nc"), "w") as file:
        place = file.create_dataset("v", data=data, compression=compression, chunks=(2, 3, 4) if compression else None)
        for key, value in attributes.items():
            place.attrs[key] = value


def test_netcdf_integers_with_missing_values():
    """By hand, as CF says it: what stands for none is NaN, the rest is unpacked in doubles."""
    for name, order, compression in itertools.product(("u1", "i1", "u2", "i2", "i4", "u4", "i8"), "<>", (None, "gzip")):
        data = rng.integers(0, 100, (5, 6, 7)).astype(order + name)
        fill = data.dtype.type(np.iinfo(name).max)
        data[0, 1, 2], data[4, 3, 4] = fill, 101
        told_as = np.float32 if int(name[1]) < 4 else np.float64
        for scale, offset in ((0.01, 5.0), (-2.0, 0.0), (1.0, 0.0)):
            attributes = {} if scale == 1 else {"scale_factor": scale, "add_offset": offset}
            write_values(data, compression, _FillValue=np.array([fill], data.dtype), missing_value=data.dtype.type(101), **attributes)
            expected = np.where((data == fill) | (data == 101), np.nan, data.astype("f8") * scale + offset).astype(told_as)
            same(path_of("m.nc"), five(expected, "zyx"), f"missing integers {name} {order} {compression} {scale}")
    values = info(path_of("m.nc"))
    expect("stored as i64, read as f64" in json.dumps(values["metadata"]), values["metadata"])
    expect(values["value_scale"] == 1 and values["value_offset"] == 0, values)


def test_netcdf_integers_that_stay():
    data = random((3, 4, 5), "i2")
    for attributes in ({"_FillValue": np.int16(0)}, {"_FillValue": data[0, 0, 0], "flag_meanings": "land sea ice"},
                       {"valid_range": np.array([-32768, 32767], "i2")}, {"scale_factor": 0.5}):
        write_values(data, **attributes)
        said = same(path_of("m.nc"), five(data, "zyx"), f"integers stay {attributes}")
        expect(said is not None, attributes)


def test_netcdf_valid_range():
    for name in ("<f2", "<f4", ">f4", ">f8"):
        data = random((3, 4, 5), "f4").astype(name)
        lo, hi = np.quantile(data.astype("f8"), (0.2, 0.7)).astype(name)
        for attributes in ({"valid_range": np.array([lo, hi])}, {"valid_min": lo}, {"valid_max": hi}):
            write_values(data, "gzip" if name == "<f4" else None, **attributes)
            out = (data < (lo if "valid_max" not in attributes else -np.inf)) | (data > (hi if "valid_min" not in attributes else np.inf))
            expected = np.where(out, np.nan, data).astype("f8" if "8" in name else "f4")
            same(path_of("m.nc"), five(expected, "zyx"), f"valid range {name} {attributes}")
    data = np.arange(60, dtype="i2").reshape(3, 4, 5)
    whole = np.where((data < 10) | (data > 50), np.nan, data * 0.1 + 2).astype("f4")
    for ends in (np.array([10, 50], "i2"), np.array([3.0, 7.0])): # of what is stored, or of what it stands for
        write_values(data, scale_factor=0.1, add_offset=2.0, valid_range=ends)
        same(path_of("m.nc"), five(whole, "zyx"), f"valid range of packed integers {ends}")
    write_values(data, scale_factor=-0.1, valid_range=np.array([-5.0, -1.0]))
    same(path_of("m.nc"), five(np.where((data < 10) | (data > 50), np.nan, data * -0.1).astype("f4"), "zyx"), "turned range")
    write_values(data, scale_factor=0.1, valid_range=np.array([0, -6], "i2"))
    same(path_of("m.nc"), five(data, "zyx"), "a range of nothing is none")


def test_netcdf_meshes_are_refused():
    data = random((1, 4, 30), "f8")
    places = [("px", np.arange(30.0), {"standard_name": "longitude"}), ("py", np.arange(30.0), {"standard_name": "latitude"})]
    write_netcdf(path_of("u.nc"), data, [("time", [0.0], {}), ("lev", np.arange(4.0), {}), ("face", None, {})], places)
    refused(path_of("u.nc"), "unstructured mesh", "/v")
    with h5py.File(path_of("u.nc"), "a") as file:
        file["w"] = data
        for key in ("coordinates", "DIMENSION_LIST"):
            file["w"].attrs.create(key, file["v"].attrs[key], dtype=file["v"].attrs.get_id(key).dtype)
    refused(path_of("u.nc"), "unstructured mesh")


def test_classic_netcdf_is_refused():
    for content, words in ((b"CDF\1" + bytes(60), ("nccopy",)), (b"CDF\2" + bytes(60), ("nccopy",)),
                           (b"CDF\1" + bytes(8) + b"xspace" + bytes(60), ("mincconvert",)),
                           (b"CDF\1" + bytes(8) + b"num_nodes" + bytes(60), ("Exodus", "mesh"))):
        for name in ("old.nc", "old.mnc", "old"):
            with open(path_of(name), "wb") as file:
                file.write(content)
            refused(path_of(name), *words)


def test_a_text_that_is_longer_than_it_says():
    """The length beside an attribute is believed by the library; the heap's own says more."""
    data = random((3, 4, 5), "u1")
    with h5py.File(path_of("long.h5"), "w") as file:
        file["a"] = data
        file["a"].attrs["words"] = "x" * 60000
    content = bytearray(open(path_of("long.h5"), "rb").read())
    at = content.find((60000).to_bytes(4, "little"))
    content[at:at + 4] = (4).to_bytes(4, "little")
    with open(path_of("long.h5"), "wb") as file:
        file.write(content)
    same(path_of("long.h5"), five(data, "zyx"), "a text that lies")


def test_real_netcdf():
    path = shared("irregular/hybrid_height.nc")
    if path:
        with h5py.File(path) as file:
            same(path, five(file["air_potential_temperature"][...], "zyx"), "hybrid_height")
        expect("along z are uneven (5 .. 845 m); shown as if they were even" in told(path)[1], told(path)[1])
    for name, word in (("lfric_theta.nc", "mesh"), ("theta_nodal_xios.nc", "mesh"), ("disk_out_ref.ex2", "Exodus II"),
                       ("rectilinear_grid_3D.nc", "nccopy -k nc4")):
        path = shared("irregular/" + name)
        if path:
            refused(path, word)


def test_real_minc():
    global MINC_ORDER
    path = shared("formats/minc/t1_short_cor.mnc")
    if path and nib is not None:
        MINC_ORDER = ["yspace", "zspace", "xspace"]
        check_minc(path, "t1_short_cor")


if __name__ == "__main__":
    only = [word for word in sys.argv[3:] if word not in how]
    with workplace() as folder:
        for name, test in list(globals().items()):
            if name.startswith("test_") and (not only or name in only):
                before = failures
                test()
                if only or failures > before:
                    print(name, "failed" if failures > before else "passed")
    failures += not tool.end()
    print(files, "reads compared,", checks, "checks,", failures, "failures")
    sys.exit(1 if failures else 0)
