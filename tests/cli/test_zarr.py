"""Zarr and OME-Zarr: what independent writers write is read, and what VolVis writes they read. Zarr 2 is asked of the
zarr package, Zarr 3 of zarr3.py beside this, which follows the specification."""
import base64
import itertools
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import zlib
import numpy
import zarr3
from harness import VOLVIS, Skip, environment, fails, main, ok, says, volvis

try:
    import numcodecs
    import zarr
except ImportError:
    zarr = None

TYPES = "b1 u1 i1 u2 i2 u4 i4 u8 i8 f2 f4 f8".split()


def need_zarr():
    if zarr is None:
        raise Skip("the zarr package of Python is missing: skipped")


def noise(shape, kind, seed=1994):
    rng = numpy.random.default_rng(seed)
    if kind in ("?", "b1"):
        return rng.integers(0, 2, shape).astype("?")
    return (rng.random(shape) * 100 - (0 if kind[0] == "u" else 50)).astype(kind)


def read(name, *more):
    """Samples as VolVis reads them, and what it says of them."""
    ok("convert", name, "-o", "out.npy", "--overwrite", *more)
    return numpy.load("out.npy")


def same(name, data, *more):
    ours = read(name, *more)
    want = data.astype("u1") if data.dtype.kind == "b" else data.astype("f4") if data.dtype == "f2" else data
    want = want.astype(want.dtype.newbyteorder("="))
    assert ours.dtype == want.dtype, f"{name}: {ours.dtype}, not {want.dtype}"
    assert ours.size == want.size, f"{name}: {ours.shape}, not {want.shape}"
    assert numpy.array_equal(ours.reshape(want.shape), want, equal_nan=want.dtype.kind == "f"), f"{name}: other samples"


def edit(path, **changes):
    meta = json.load(open(path))
    meta.update(changes)
    json.dump(meta, open(path, "w"))


# Zarr 2 ----------------------------------------------------------------------------------------------------------


def test_every_type_order_and_key_of_zarr_2_is_read():
    need_zarr()
    number = 0
    for kind, order, separator, endian in itertools.product(TYPES, "CF", "./", "<>"):
        data = noise((5, 7, 3), kind)
        kind = numpy.dtype(kind).newbyteorder(endian)
        name = f"a{number}.zarr"
        number += 1
        if number % 4 and kind.str[1:] not in ("i2", "f4"):
            continue
        zarr.array(data.astype(kind), store=zarr.DirectoryStore(name), chunks=((2, 3, 2), (5, 7, 3), (8, 8, 8))[number % 3],
                   order=order, dimension_separator=separator, overwrite=True)
        same(name, data)


def test_every_compression_of_zarr_2_is_read():
    need_zarr()
    names = [numcodecs.Zstd(3), numcodecs.GZip(6), numcodecs.Zlib(1), numcodecs.BZ2(9), numcodecs.LZ4(), numcodecs.LZMA(),
             numcodecs.LZMA(format=2), None]
    names += [numcodecs.Blosc(c, 5, s) for c in numcodecs.blosc.list_compressors() for s in (0, 1, 2)]
    data = (numpy.indices((30, 21, 17)).sum(0) * 3).astype("u2")
    for number, compressor in enumerate(names):
        if compressor is not None and getattr(compressor, "cname", "") == "snappy":
            continue  # not every library has it
        name = f"c{number}.zarr"
        zarr.array(data, store=zarr.DirectoryStore(name), chunks=(16, 16, 16), compressor=compressor)
        same(name, data)


def test_filters_of_zarr_2_are_undone():
    need_zarr()
    data = (numpy.indices((9, 8, 7)).sum(0) * 5 - 20).astype("i2")
    for number, filters in enumerate((
            [numcodecs.Delta("<i2")], [numcodecs.Delta("<i2", "<i4")], [numcodecs.Shuffle(2)],
            [numcodecs.Delta("<i2"), numcodecs.Shuffle(2)], [numcodecs.FixedScaleOffset(0, 1, "<i2", "<i4")],
            [numcodecs.Delta("<i2"), numcodecs.Zlib(1)])):
        for order in "CF":
            name = f"f{number}{order}.zarr"
            zarr.array(data, store=zarr.DirectoryStore(name), chunks=(4, 8, 3), filters=filters, order=order)
            same(name, zarr.open(name)[:])
    real = numpy.linspace(0, 20, 5 * 6 * 7).reshape(5, 6, 7)
    for number, filters in enumerate(([numcodecs.FixedScaleOffset(10, 50, "<f8", "u2")], [numcodecs.Quantize(2, "<f8")],
                                      [numcodecs.Delta("<f8")], [numcodecs.BitRound(10)])):
        name = f"r{number}.zarr"
        zarr.array(real, store=zarr.DirectoryStore(name), chunks=(4, 4, 4), filters=filters)
        same(name, zarr.open(name)[:])
    zarr.array(noise((3, 3, 3), "?"), store=zarr.DirectoryStore("bits.zarr"), filters=[numcodecs.PackBits()])
    says(fails(3, "info", "bits.zarr"), "packbits")


def test_missing_chunks_are_made_of_the_fill_value():
    need_zarr()
    for number, (kind, fill) in enumerate((("u1", 7), ("i2", -300), ("f4", float("nan")), ("f8", float("inf")),
                                           ("f4", -float("inf")), ("f2", 1.5), ("u8", 2 ** 64 - 1), ("i8", -2 ** 63),
                                           ("?", True), ("f8", 1e-300), ("i4", None))):
        name = f"m{number}.zarr"
        array = zarr.open(name, mode="w", shape=(4, 5, 6), chunks=(2, 5, 3), dtype=kind, fill_value=fill)
        array[0:2, :, 0:3] = noise((2, 5, 3), kind)
        want = array[:]
        if fill is None:
            want[2:] = want[:, :, 3:] = 0
        same(name, want)
    for fill, value in (("0x7fc00000", float("nan")), ("0x3fc00000", 1.5),
                        (base64.b64encode(struct.pack("<f", -2.5)).decode(), -2.5)):
        edit("m2.zarr/.zarray", fill_value=fill)
        ours = read("m2.zarr")
        assert numpy.array_equal(ours[3], numpy.full((5, 6), value, "f4"), equal_nan=True), fill
    edit("m2.zarr/.zarray", fill_value="red")
    says(fails(3, "info", "m2.zarr"), "fill_value")


def test_arrays_of_one_to_five_axes_have_their_places():
    need_zarr()
    for shape in ((7,), (5, 7), (3, 5, 7), (2, 3, 5, 7), (2, 3, 4, 5, 6), (1, 1, 2, 3, 4, 5), (5, 6, 3)):
        data = noise(shape, "u1")
        shutil.rmtree("n.zarr", ignore_errors=True)
        zarr.array(data, store=zarr.DirectoryStore("n.zarr"), chunks=tuple(2 for n in shape))
        info = ok("info", "n.zarr", "--json").json
        frames = shape[0] if len(shape) in (4, 5) else 1
        assert info["frames"] == frames, (shape, info["frames"])
        for frame in range(frames):
            want = data[frame] if frames > 1 else data
            want = want[0] if len(shape) == 6 else want
            if len(shape) >= 5:
                want = want.reshape(shape[-4:]).transpose(1, 2, 3, 0)
            same(f"n.zarr@{frame}", want)


def test_a_part_that_is_not_there_is_told_with_those_that_are():
    need_zarr()
    group = zarr.open_group("parts.zarr", mode="w")
    group["a/b"] = group["c"] = noise((3, 4, 5), "u1")
    says(fails(2, "info", "parts.zarr:nope"), "has no array or group 'nope'; there are a/b and c")


def test_boxes_are_read_without_the_rest():
    need_zarr()
    data = noise((11, 13, 17), "i2")
    zarr.array(data, store=zarr.DirectoryStore("b.zarr"), chunks=(4, 5, 6), order="F")
    os.remove("b.zarr/2.2.2")
    data[8:, 10:, 12:] = 0
    for lo, n in (((0, 0, 0), (1, 1, 1)), ((3, 4, 5), (7, 6, 3)), ((12, 9, 8), (5, 4, 1)), ((5, 0, 0), (2, 13, 8))):
        ok("crop", "b.zarr", "-o", "crop.npy", "--overwrite",
           *(word for a in range(3) for word in (f"--{'xyz'[a]}", f"{lo[a]}:{lo[a] + n[a]}")))
        want = data[lo[2]: lo[2] + n[2], lo[1]: lo[1] + n[1], lo[0]: lo[0] + n[0]]
        assert numpy.array_equal(numpy.load("crop.npy").reshape(want.shape), want), (lo, n)


# Zarr 3 ----------------------------------------------------------------------------------------------------------


def codec(name, **config):
    return {"name": name, "configuration": config}


LITTLE, BIG = codec("bytes", endian="little"), codec("bytes", endian="big")


def test_every_type_and_codec_of_zarr_3_is_read():
    number = 0
    packers = [[], [codec("gzip", level=5)], [codec("crc32c")], [codec("gzip", level=1), codec("crc32c")]]
    if zarr is not None:
        packers += [[codec("zstd", level=3, checksum=False)],
                    [codec("blosc", cname="lz4", clevel=5, shuffle="shuffle", typesize=2, blocksize=0)]]
    for kind, packer, endian in itertools.product(TYPES, packers, (LITTLE, BIG)):
        number += 1
        if number % 4 and kind not in ("i2", "f4"):
            continue
        data = noise((5, 6, 7), kind)
        turn = [[], [codec("transpose", order=[2, 0, 1])], [codec("transpose", order=[1, 2, 0]), codec("transpose", order=[2, 1, 0])]]
        keys = [None, codec("default", separator="."), codec("v2", separator="/"), codec("v2")][number % 4]
        zarr3.write_array(f"a{number}.zarr", data, (2, 4, 3), turn[number % 3] + [endian] + packer, keys)
        same(f"a{number}.zarr", data)


def test_transposes_of_the_draft_are_read():
    data = noise((5, 6, 7), "i2")
    for letter, order in (("C", [0, 1, 2]), ("F", [2, 1, 0])):
        zarr3.write_array("a.zarr", data, (2, 4, 3), [codec("transpose", order=order), LITTLE])
        edit("a.zarr/zarr.json", codecs=[codec("transpose", order=letter), LITTLE])
        same("a.zarr", data)
        shutil.rmtree("a.zarr")
    zarr3.write_array("a.zarr", data, (2, 4, 3), [codec("transpose", order=[0, 1, 2]), LITTLE])
    edit("a.zarr/zarr.json", codecs=[codec("transpose", order="A"), LITTLE])
    says(fails(3, "convert", "a.zarr", "-o", "b.npy"), "not an order of 3 axes")


def sharding(chunk, location="end", endian="little", crc=True, codecs=None):
    index = [codec("bytes", endian=endian)] + ([codec("crc32c")] if crc else [])
    return [codec("sharding_indexed", chunk_shape=chunk, codecs=codecs or [LITTLE, codec("gzip", level=1)],
                  index_codecs=index, index_location=location)]


def test_shards_are_read():
    data = noise((9, 10, 11), "i2")
    data[:4, :4, :] = 0
    number = 0
    for location, endian, crc in itertools.product(("end", "start"), ("little", "big"), (True, False)):
        for codecs in (None, [codec("transpose", order=[2, 1, 0]), BIG], [LITTLE, codec("crc32c")]):
            name = f"s{number}.zarr"
            number += 1
            zarr3.write_array(name, data, (8, 4, 12), sharding([2, 4, 3], location, endian, crc, codecs), skip=[(1, 2, 0)])
            want = data.copy()
            want[8:, 8:] = 0
            same(name, want)


def test_shards_that_lie_are_refused():
    data = noise((4, 4, 4), "i2")
    entry = struct.Struct("<2Q")

    def broken(change, crc=False):
        shutil.rmtree("s.zarr", ignore_errors=True)
        zarr3.write_array("s.zarr", data, (4, 4, 4), sharding([2, 2, 2], crc=crc))
        path = "s.zarr/c/0/0/0"
        blob = bytearray(open(path, "rb").read())
        blob = change(blob, len(blob) - 128 - 4 * crc)
        open(path, "wb").write(blob)
        return fails(3, "convert", "s.zarr", "-o", "out.npy")

    def put(at, offset, n):
        def change(blob, index):
            entry.pack_into(blob, index + 16 * at, offset, n)
            return blob
        return change

    says(broken(put(3, 10 ** 15, 10)), "places a chunk at bytes")
    says(broken(put(3, 0, 2 ** 64 - 1)), "places a chunk at bytes")
    says(broken(put(3, 5, 30)), "overlap")
    says(broken(lambda blob, index: put(7, index - 4, 20)(blob, index)), "overlap")
    says(broken(lambda blob, index: blob[:20]), "20 bytes")
    says(broken(put(3, 5, 30), crc=True), "checksum")


def test_damaged_chunks_are_filled_and_told_or_refused():
    data = noise((8, 8, 8), "f4")
    for name, good in (("c/0/0/0", True), ("c/1/0/1", True)):
        zarr3.write_array("d.zarr", data, (4, 4, 4), [LITTLE, codec("gzip", level=1), codec("crc32c")])
        blob = bytearray(open("d.zarr/" + name, "rb").read())
        blob[len(blob) // 2] ^= 1
        open("d.zarr/" + name, "wb").write(blob)
        done = volvis("convert", "d.zarr", "-o", "out.npy")
        assert done.code == 7, (done.code, done.message)
        says(done.message, "checksum crc32c is wrong", "1 of 8 chunks are damaged")
        ours = numpy.load("out.npy")
        want = data.copy()
        at = [4 * int(c) for c in name[2:].split("/")]
        want[at[0]: at[0] + 4, at[1]: at[1] + 4, at[2]: at[2] + 4] = numpy.nan
        assert numpy.array_equal(ours, want, equal_nan=True)
    for name in ("c/0/0/0", "c/0/0/1", "c/0/1/0", "c/1/1/1", "c/1/1/0"):
        open("d.zarr/" + name, "wb").write(b"short")
    says(fails(3, "convert", "d.zarr", "-o", "out.npy"), "more than half")


# Hierarchies -----------------------------------------------------------------------------------------------------


def test_arrays_of_groups_are_parts():
    need_zarr()
    group = zarr.open_group("g.zarr", mode="w")
    small, large = noise((3, 3, 3), "u1"), noise((4, 5, 6), "i2")
    group.create_dataset("a/b/small", data=small)
    group.create_dataset("c/large", data=large, chunks=(2, 2, 2), dimension_separator="/")
    group.create_dataset("text", data=numpy.array(["x", "y"], dtype="U1"))
    same("g.zarr", large)
    same("g.zarr:a/b/small", small)
    same("g.zarr:a", small)
    says(fails(2, "info", "g.zarr:c/small"), "c/small")
    says(fails(3, "info", "g.zarr:text"), "U1")
    zarr.consolidate_metadata("g.zarr")
    os.remove("g.zarr/c/large/.zarray")
    same("g.zarr:c/large", large)
    zarr3.write_group("h.zarr")
    zarr3.write_group("h.zarr/in")
    zarr3.write_array("h.zarr/in/volume", large, (4, 4, 4), [LITTLE])
    same("h.zarr", large)
    same("h.zarr:in/volume", large)


def test_names_never_lead_out_of_the_folder():
    data = noise((3, 3, 2), "u1")
    zarr3.write_array("secret.zarr", data, (3, 3, 2), [LITTLE])
    os.mkdir("x.zarr")
    for path in ("../secret.zarr", os.path.abspath("secret.zarr"), "a/../../secret.zarr"):
        zarr3.write_group("x.zarr", {"ome": {"version": "0.5", "multiscales": [{"datasets": [{"path": path}]}]}})
        assert volvis("info", "x.zarr").code != 0, path
        assert volvis("info", "x.zarr:" + path).code != 0, path
    zarr3.write_array("x.zarr/v", data, (3, 3, 2), [LITTLE])
    zarr3.write_group("x.zarr")
    shutil.move("x.zarr/v/c/0/0/0", "chunk")
    os.symlink(os.path.abspath("chunk"), "x.zarr/v/c/0/0/0")
    refused = fails(3, "convert", "x.zarr:v", "-o", "out.npy")
    says(refused, "v/c/0/0/0", "is a link that leads out", "--allow-outside")
    assert "damaged" not in refused, refused
    ok("convert", "x.zarr:v", "-o", "out.npy", "--allow-outside")
    assert numpy.array_equal(numpy.load("out.npy"), data)
    os.symlink(os.path.abspath("secret.zarr"), "x.zarr/link")
    says(fails(3, "info", "x.zarr:link"), "--allow-outside")
    zarr3.write_array("x.zarr/s", data, (3, 3, 2), sharding((3, 3, 2)))
    shutil.move("x.zarr/s/c/0/0/0", "shard")
    os.symlink(os.path.abspath("shard"), "x.zarr/s/c/0/0/0")
    refused = fails(3, "convert", "x.zarr:s", "-o", "out.npy", "--overwrite")
    says(refused, "s/c/0/0/0", "--allow-outside")
    assert "damaged" not in refused, refused
    os.symlink(".", "x.zarr/circle")
    ok("info", "x.zarr", "--json", "--allow-outside")


# OME-Zarr --------------------------------------------------------------------------------------------------------


def axes_of(letters):
    kinds = {"t": ("time", "second"), "c": ("channel", None)}
    out = []
    for letter in letters:
        kind, unit = kinds.get(letter, ("space", "micrometer"))
        out.append({"name": letter, "type": kind, **({"unit": unit} if unit else {})})
    return out


def image(letters, scale, translation, paths=("0",), **more):
    levels = []
    for number, path in enumerate(paths):
        scales = [scale[a] * (2 ** number if a in "xyz" else 1) for a in letters]
        levels.append({"path": path, "coordinateTransformations": [
            {"type": "scale", "scale": scales}, {"type": "translation", "translation": [translation[a] for a in letters]}]})
    return {"multiscales": [{"axes": axes_of(letters), "datasets": levels, "name": "picture", **more}]}


SCALE = {"t": 0.5, "c": 1, "z": 2.0, "y": 0.25, "x": 0.75}
SHIFT = {"t": 0, "c": 0, "z": 10, "y": -20, "x": 30}
SIZE = {"t": 2, "c": 3, "z": 4, "y": 5, "x": 6}


def test_ome_axes_in_any_order_have_their_places():
    for n in range(2, 6):
        for letters in itertools.permutations("tczyx", n):
            if not {"x", "y"} <= set(letters):
                continue
            if n >= 4 and hash_of(letters) % 8:
                continue
            shutil.rmtree("o.zarr", ignore_errors=True)
            zarr3.write_group("o.zarr", {"ome": {"version": "0.5", **image(letters, SCALE, SHIFT)}})
            data = noise([SIZE[a] for a in letters], "u2")
            zarr3.write_array("o.zarr/0", data, [3] * n, [LITTLE])
            info = ok("info", "o.zarr", "--json").json
            assert info["dims"] == [SIZE[a] if a in letters else 1 for a in "xyz"], letters
            assert info["frames"] == (2 if "t" in letters else 1) and info["unit"] == "um"
            assert info["spacing"][:2] == [0.75, 0.25] and info["origin"][:2] == [30, -20], (letters, info)
            assert "z" not in letters or (info["spacing"][2] == 2 and info["origin"][2] == 10)
            assert "t" not in letters or (info["frame_step"] == 0.5 and info["frame_unit"] == "s")
            order = [letters.index(a) for a in "tzyxc" if a in letters]
            want = data.transpose(order)
            for frame in range(info["frames"]):
                same(f"o.zarr@{frame}", want[frame] if "t" in letters else want)


def hash_of(letters):
    return sum((i + 1) * ord(a) for i, a in enumerate(letters))


def test_levels_are_parts_with_their_own_spacing():
    zarr3.write_group("o.zarr", {"ome": {"version": "0.5", **image("zyx", SCALE, SHIFT, ("0", "low/1"))}})
    full, half = noise((8, 8, 8), "u1"), noise((4, 4, 4), "u1")
    zarr3.write_array("o.zarr/0", full, (8, 8, 8), [LITTLE])
    zarr3.write_array("o.zarr/low/1", half, (4, 4, 4), [LITTLE])
    zarr3.write_group("o.zarr/low")
    same("o.zarr", full)
    same("o.zarr:low/1", half)
    assert ok("info", "o.zarr:low/1", "--json").json["spacing"] == [1.5, 0.5, 4]
    assert ok("info", "o.zarr", "--json").json["spacing"] == [0.75, 0.25, 2]


def test_pictures_take_the_finest_level_that_fits_and_everything_else_the_finest():
    zarr3.write_group("o.zarr", {"ome": {"version": "0.5", **image("zyx", SCALE, SHIFT, ("0", "1"))}})
    chunks = list(numpy.ndindex(4, 4, 4))
    zarr3.write_array("o.zarr/0", numpy.zeros((512, 512, 512), "u1"), (128, 128, 128), [LITTLE], skip=chunks[1:])
    zarr3.write_array("o.zarr/1", numpy.zeros((256, 256, 256), "u1"), (64, 64, 64), [LITTLE], skip=chunks)
    assert ok("info", "o.zarr", "--json", "--memory", "64M").json["dims"] == [512] * 3
    assert ok("convert", "o.zarr", "-o", "a.npy", "--memory", "64M", "--x", "0:7", "--json").json["dims"] == [7, 512, 512]
    words = ("render", "o.zarr", "-o", "a.png", "--size", "64x64", "--memory")
    says(ok(*words, "64M").message, "level 0 of 2 does not fit into memory", "'1'")
    assert "level" not in ok(*words, "2G").message


def test_what_is_larger_than_memory_is_drawn_from_its_bricks_in_all_modes():
    z, y, x = numpy.ogrid[0:224, 0:224, 0:224]
    data = (numpy.hypot(numpy.hypot(x - 111, y - 100), z - 120) < 90) * (100 + x // 4 + 0 * y * z)
    zarr3.write_array("a.zarr", data.astype("u1"), (32, 32, 32), [LITTLE])
    for words in (["--mode", "composite"], ["--iso", "90"], ["--mode", "maximum"], ["--mode", "mean"], ["--mode", "sum"]):
        look = ("render", "a.zarr", *words, "--size", "48x48", "--spp", "1", "--overwrite", "-o")
        ok(*look, "much.png", "--memory", "1G")
        ok(*look, "little.png", "--memory", "9M")
        plan = ok(*look, "little.png", "--memory", "9M", "--dry-run", "--json").json
        assert plan["memory_bytes"] == 9 << 20 and not plan["in_parts"], plan
        with open("much.png", "rb") as much, open("little.png", "rb") as little:
            assert much.read() == little.read(), words


def test_global_transformations_come_after_those_of_the_level():
    more = {"coordinateTransformations": [{"type": "scale", "scale": [10, 10, 10]},
                                          {"type": "translation", "translation": [1, 2, 3]}]}
    zarr3.write_group("o.zarr", {"ome": {"version": "0.5", **image("zyx", SCALE, SHIFT, **more)}})
    zarr3.write_array("o.zarr/0", noise((3, 4, 5), "u1"), (3, 4, 5), [LITTLE])
    info = ok("info", "o.zarr", "--json").json
    assert info["spacing"] == [7.5, 2.5, 20] and info["origin"] == [303, -198, 101], info


def test_versions_that_are_not_known_are_told():
    zarr3.write_array("o.zarr/0", noise((3, 4, 5), "u1"), (3, 4, 5), [LITTLE])
    for version in ("0.1", "0.3", "0.4", "0.5", "0.6.dev1", "0.6", "0.9", "1.0", "0.51", None):
        zarr3.write_group("o.zarr", {"ome": {**({"version": version} if version else {}), **image("zyx", SCALE, SHIFT)}})
        warnings = ok("info", "o.zarr", "--json").json["warnings"]
        told = [w for w in warnings if f"is written as OME-Zarr {version}; VolVis knows 0.1 to 0.5" in w]
        assert len(told) == (version not in ("0.1", "0.3", "0.4", "0.5", None)), (version, warnings)
        assert len(warnings) == len(told), warnings


def placed(steps, more=None):
    """What VolVis says of an image [z, y, x] under these transformations."""
    said = image("zyx", SCALE, SHIFT)
    said["multiscales"][0]["datasets"][0]["coordinateTransformations"] = steps
    said["multiscales"][0].update(more or {})
    zarr3.write_group("o.zarr", {"ome": {"version": "0.5", **said}})
    zarr3.write_array("o.zarr/0", noise((3, 4, 5), "u1"), (3, 4, 5), [LITTLE])
    return ok("info", "o.zarr", "--json").json


def world_of(matrix):
    """Directions and origin in x, y, z for a matrix of rows z, y, x with an offset behind."""
    matrix = numpy.array(matrix, float)
    return matrix[::-1, 2::-1].T, matrix[::-1, 3]


def test_every_affine_transformation_is_applied():
    turn, c, s = numpy.eye(3), math.cos(0.3), math.sin(0.3)
    turn[1:, 1:] = ((c, -s), (s, c))
    scale, shift = {"type": "scale", "scale": [4, 3, 2]}, {"type": "translation", "translation": [7, 8, 9]}
    affine = [[1, 0.5, 0, 10], [0, 2, 0.25, 20], [0.125, 0, 3, 30]]
    rotation = {"type": "rotation", "rotation": turn.tolist()}
    columns = numpy.diag([4.0, 3, 2])
    none = numpy.zeros((3, 1))
    for steps, want in (
            ([{"type": "identity"}], numpy.hstack((numpy.eye(3), none))),
            ([{"type": "affine", "affine": affine}], affine),
            ([rotation], numpy.hstack((turn, none))),
            ([scale, rotation], numpy.hstack((turn @ columns, none))),
            ([{"type": "sequence", "transformations": [scale, rotation, shift]}],
             numpy.hstack((turn @ columns, [[7], [8], [9]]))),
            ([{"type": "bijection", "forward": scale, "inverse": shift}], numpy.hstack((columns, none))),
            ([scale, {"type": "mapAxis", "mapAxis": [2, 0, 1]}], [[0, 0, 2, 0], [4, 0, 0, 0], [0, 3, 0, 0]])):
        info = placed(steps)
        directions, origin = world_of(want)
        spacing = numpy.array(info["spacing"])[:, None]
        assert numpy.allclose(numpy.array(info["directions"]) * spacing, directions), (steps, info)
        assert numpy.allclose(info["origin"], origin) and info["warnings"] == [], (steps, info)


def test_transformations_that_are_not_understood_are_told_and_left_out():
    scale = {"type": "scale", "scale": [4, 3, 2]}
    for unknown in ({"type": "displacements", "path": "field"}, {"type": "affine", "path": "matrix"}, {"type": "scale", "scale": [1, 2]},
                    {"type": "byDimension", "transformations": []}, {"type": "mapAxis", "mapAxis": [0, 1, 7]}):
        info = placed([scale], {"coordinateTransformations": [unknown]})
        assert info["spacing"] == [2, 3, 4], info
        assert any(f"'{unknown['type']}' is not understood" in w for w in info["warnings"]), (unknown, info)
        info = placed([unknown])
        assert info["spacing"] == [1, 1, 1] and any("is not understood" in w for w in info["warnings"]), (unknown, info)


def test_the_coordinate_system_of_the_levels_is_shown():
    def axes(unit):
        return [{**a, "unit": unit} for a in axes_of("zyx")]

    for order in ((0, 1), (1, 0)):
        systems = [{"name": "physical", "axes": axes("micrometer")}, {"name": "atlas", "axes": axes("millimeter")}]
        steps = [{"type": "scale", "scale": [4, 3, 2], "input": "0", "output": "physical"}]
        more = {"coordinateSystems": [systems[i] for i in order], "coordinateTransformations": [
            {"type": "scale", "scale": [9, 9, 9], "input": "physical", "output": "atlas"}]}
        info = placed(steps, more)
        assert info["spacing"] == [2, 3, 4] and info["unit"] == "um", info
        assert info["metadata"]["coordinate_system"] == "physical", info


def test_older_versions_have_axes_by_name_or_by_place():
    need_zarr()
    for version, axes, shape in (("0.2", None, (1, 2, 3, 4, 5)), ("0.3", ["z", "y", "x"], (3, 4, 5)),
                                 ("0.1", None, (1, 1, 3, 4, 5))):
        group = zarr.open_group("o.zarr", mode="w")
        group.create_dataset("0", data=noise(shape, "u1"))
        said = {"version": version, "datasets": [{"path": "0"}], **({"axes": axes} if axes else {})}
        group.attrs["multiscales"] = [said]
        info = ok("info", "o.zarr", "--json").json
        assert info["dims"] == [5, 4, 3] and info["components"] == (2 if version == "0.2" else 1), (version, info)


def test_channels_and_labels_are_known():
    need_zarr()
    group = zarr.open_group("o.zarr", mode="w")
    group.attrs.put({**image("czyx", SCALE, SHIFT), "omero": {"channels": [
        {"label": "DAPI", "color": "0000FF", "window": {"start": 10, "end": 200, "min": 0, "max": 255}},
        {"label": "GFP", "color": "00ff00"}, {"label": "RFP", "color": "FF0000"}]}})
    data, cells = noise((3, 4, 5, 6), "u1"), noise((4, 5, 6), "u2")
    group.create_dataset("0", data=data, chunks=(1, 2, 2, 2), dimension_separator="/")
    labels = group.create_group("labels")
    labels.attrs["labels"] = ["cells"]
    inside = labels.create_group("cells")
    inside.attrs.put({**image("zyx", SCALE, SHIFT), "image-label": {
        "version": "0.4", "colors": [{"label-value": 1, "rgba": [255, 0, 0, 255]}, {"label-value": 3, "rgba": [0, 0, 255, 128]}],
        "properties": [{"label-value": 3, "class": "nucleus"}, {"label-value": 4, "name": "wall"}]}})
    inside.create_dataset("0", data=cells)
    same("o.zarr", data.transpose(1, 2, 3, 0))
    same("o.zarr:labels/cells", cells)
    info = ok("info", "o.zarr:labels/cells", "--json").json
    assert info["meaning"] == "label", info
    assert ok("info", "o.zarr:labels/cells/0", "--json").json["meaning"] == "label"


def test_plates_and_series_are_parts():
    need_zarr()
    root = zarr.open_group("p.zarr", mode="w")
    root.attrs["plate"] = {"rows": [{"name": "A"}], "columns": [{"name": "1"}, {"name": "2"}],
                           "wells": [{"path": "A/1"}, {"path": "A/2"}]}
    for well, seed in (("A/1", 1), ("A/2", 2)):
        group = root.create_group(well)
        group.attrs["well"] = {"images": [{"path": "0"}]}
        field = group.create_group("0")
        field.attrs.put(image("zyx", SCALE, SHIFT))
        field.create_dataset("0", data=noise((3, 4, 5), "u1", seed))
    same("p.zarr", noise((3, 4, 5), "u1", 1))
    same("p.zarr:A/2/0", noise((3, 4, 5), "u1", 2))
    same("p.zarr:A/2", noise((3, 4, 5), "u1", 2))
    root = zarr.open_group("s.zarr", mode="w")
    root.attrs["bioformats2raw.layout"] = 3
    for series in ("0", "1"):
        group = root.create_group(series)
        group.attrs.put(image("zyx", SCALE, SHIFT))
        group.create_dataset("0", data=noise((3, 4, 5), "u1", int(series)))
    same("s.zarr", noise((3, 4, 5), "u1", 0))
    same("s.zarr:1", noise((3, 4, 5), "u1", 1))


def test_anatomical_axes_lead_to_ras():
    for towards, sign in (("left-to-right", 1), ("right-to-left", -1)):
        said = image("zyx", SCALE, SHIFT)
        for axis, value in zip(said["multiscales"][0]["axes"], ("inferior-to-superior", "anterior-to-posterior", towards)):
            axis["orientation"] = {"type": "anatomical", "value": value}
        zarr3.write_group("o.zarr", {"ome": {"version": "0.5", **said}})
        zarr3.write_array("o.zarr/0", noise((3, 4, 5), "u1"), (3, 4, 5), [LITTLE])
        info = ok("info", "o.zarr", "--json").json
        assert info["space"] == "RAS" and info["origin"] == [30 * sign, 20, 10], info
        assert info["orientation"] == ("R" if sign > 0 else "L") + "PS", info


# Writing ---------------------------------------------------------------------------------------------------------

FORMATS = ("ome-zarr", "ome-zarr-0.5")


def nrrd(path, data, directions=((1, 0, 0), (0, 1, 0), (0, 0, 1)), origin=(0, 0, 0), space="right-anterior-superior",
         unit="mm"):
    """data [z, y, x], or [z, y, x, c] with components."""
    kinds = {"u1": "uint8", "i1": "int8", "u2": "uint16", "i2": "int16", "u4": "uint32", "i4": "int32", "u8": "uint64",
             "i8": "int64", "f4": "float", "f8": "double"}
    places = [f"({','.join(repr(float(v)) for v in d)})" for d in directions]
    sizes = [str(n) for n in data.shape[::-1]]
    if data.ndim == 4:
        places = ["none"] + places
    header = (f"NRRD0004\ntype: {kinds[data.dtype.str[1:]]}\ndimension: {data.ndim}\nspace: {space}\n"
              f"sizes: {' '.join(sizes)}\nspace directions: {' '.join(places)}\n"
              f"space origin: ({','.join(repr(float(v)) for v in origin)})\n"
              f'space units: "{unit}" "{unit}" "{unit}"\nencoding: raw\nendian: little\n\n')
    with open(path, "wb") as file:
        file.write(header.encode() + data.astype(data.dtype.newbyteorder("<")).tobytes())


def written(path):
    """Levels and image as independent readers find them."""
    if os.path.exists(path + "/zarr.json"):
        meta = json.load(open(path + "/zarr.json"))
        assert meta["zarr_format"] == 3 and meta["node_type"] == "group"
        attributes = meta["attributes"]
        assert attributes["ome"]["version"] == "0.5"
        image = attributes["ome"]["multiscales"][0]
        return [zarr3.read_array(f"{path}/{level['path']}")[0] for level in image["datasets"]], image, attributes["ome"]
    need_zarr()
    group = zarr.open_group(path, mode="r")
    image = group.attrs["multiscales"][0]
    assert image["version"] == "0.4"
    return [group[level["path"]][:] for level in image["datasets"]], image, dict(group.attrs)


def halved(data, label):
    """The next level, axes longer than 64 halved: of whole numbers the mean, of labels the first of the most frequent."""
    step = [2 if n > 64 else 1 for n in data.shape]
    out = numpy.zeros([(n + s - 1) // s for n, s in zip(data.shape, step)], data.dtype)
    if not label:
        sums, counts = data.astype("f8"), numpy.ones(data.shape)
        for axis, (n, s) in enumerate(zip(data.shape, step)):
            sums, counts = (numpy.add.reduceat(a, range(0, n, s), axis) for a in (sums, counts))
        return numpy.rint(sums / counts).astype(data.dtype)
    for at in numpy.ndindex(*out.shape):
        block = data[tuple(slice(a * s, a * s + s) for a, s in zip(at, step))].ravel().tolist()
        out[at] = max(block, key=block.count)  # of equal ones max takes the first
    return out


def test_every_type_and_size_is_written_and_read_back():
    sizes = ((1, 1, 1), (2, 3, 5), (7, 1, 2), (1, 5, 7), (11, 13, 6), (65, 2, 5), (1, 130, 67))
    codings = ["gzip", "raw"] + (["blosc", "zstd"] if zarr is not None else [])
    number = 0
    for kind, form in itertools.product([k for k in TYPES if k not in ("b1", "f2")], FORMATS):
        for size in (sizes[number % len(sizes)],):
            data = noise(size, kind, number)
            numpy.save("in.npy", data)
            name = f"w{number}.zarr"
            ok("convert", "in.npy", "-o", name, "--output-format", form, "--encoding", codings[number % len(codings)],
               *(["--big-endian"] if number % 3 == 0 else []))
            levels, image, _ = written(name)
            assert numpy.array_equal(levels[0], data), (name, kind, size)
            same(name, data)
            assert [a["name"] for a in image["axes"]] == ["z", "y", "x"]
            number += 1


SHARDED = ("sharded-gzip", "sharded-raw") + (("sharded-blosc", "sharded-zstd") if zarr is not None else ())


def test_shards_hold_what_chunks_hold():
    """Of every type, with places past the end, chunks of zeros, channels and frames."""
    for number, kind in enumerate(k for k in TYPES if k not in ("b1", "f2")):
        data = noise((70, 140, 600 if number < 4 else 67), kind, number)  # the long ones: of few bytes, and of every coding
        data[:, :64, :64] = 0
        data[:64] *= number % 3 > 0  # and whole shards of zeros
        numpy.save("in.npy", data)
        name = f"s{number}.zarr"
        ok("convert", "in.npy", "-o", name, "--output-format", "ome-zarr-0.5", "--encoding", SHARDED[number % len(SHARDED)],
           *(["--big-endian"] if number % 3 == 0 else []))
        ok("convert", "in.npy", "-o", "chunks.zarr", "--output-format", "ome-zarr-0.5", "--encoding", "raw")
        levels, said, _ = written(name)
        others, other_said, _ = written("chunks.zarr")
        assert said == other_said and all(numpy.array_equal(a, b) for a, b in zip(levels, others, strict=True)), kind
        assert numpy.array_equal(levels[0], data), kind
        same(name, data)
        meta = json.load(open(name + "/0/zarr.json"))
        assert meta["codecs"][0]["name"] == "sharding_indexed", meta
        n_files = sum(len(files) for _, _, files in os.walk(name + "/0/c"))
        assert n_files <= 6, (kind, n_files)  # of 12 or 60 chunks
    data = noise((2, 3, 70, 66, 20), "u2")
    zarr3.write_group("in.zarr", {"ome": {"version": "0.5", **image("tczyx", SCALE, SHIFT)}})
    zarr3.write_array("in.zarr/0", data, (1, 1, 70, 66, 20), [LITTLE])
    ok("convert", "in.zarr", "-o", "frames.zarr", "--output-format", "ome-zarr-0.5")
    assert numpy.array_equal(written("frames.zarr")[0][0], data)


def files_of(folder):
    return {os.path.relpath(os.path.join(where, name), folder): open(os.path.join(where, name), "rb").read()
            for where, _, names in os.walk(folder) for name in names}


def test_the_same_is_written_whatever_memory_and_threads_there_are():
    data = noise((150, 130, 280), "u2")
    nrrd("in.nrrd", data)
    turned = ((0, 0, 1), (0, 1, 0), (-1, 0, 0))
    nrrd("turned.nrrd", data, turned)
    subprocess.run(["gzip", "-1k", "in.nrrd"], check=True)
    for source, form in itertools.product(("in.nrrd", "turned.nrrd", "in.nrrd.gz"), FORMATS):
        ok("convert", source, "-o", "much.zarr", "--output-format", form, "--memory", "1G", "--threads", "1", "--overwrite")
        ok("convert", source, "-o", "little.zarr", "--output-format", form, "--memory", "8M", "--threads", "3", "--overwrite")
        much, little = files_of("much.zarr"), files_of("little.zarr")
        assert much == little, (source, form, sorted(set(much) ^ set(little))[:3])
        assert not [name for name in os.listdir(".") if "part" in name], os.listdir(".")


def test_every_orientation_lies_where_it_lay():
    spacing, origin, number = (0.7, 1.1, 2.3), (10.5, -20, 30), 0
    data = noise((3, 5, 7), "i2")
    for order, signs in itertools.product(itertools.permutations(range(3)), itertools.product((1, -1), repeat=3)):
        directions = [[0, 0, 0] for _ in range(3)]
        for axis in range(3):
            directions[axis][order[axis]] = signs[axis] * spacing[axis]
        space = "right-anterior-superior" if number % 2 else "3D-right-handed"
        nrrd("in.nrrd", data, directions, origin, space, "mm" if number % 2 else "um")
        ok("convert", "in.nrrd", "-o", "out.zarr", "--output-format", FORMATS[number // 2 % 2])
        number += 1
        levels, image, _ = written("out.zarr")
        steps = image["datasets"][0]["coordinateTransformations"]
        scale, translation = steps[0]["scale"][::-1], steps[1]["translation"][::-1]
        turned = data.transpose([2 - order.index(w) for w in (2, 1, 0)])  # along the world's z, y, x
        for world in range(3):
            axis = order.index(world)
            first = origin[world]
            if signs[axis] < 0:
                turned = numpy.flip(turned, 2 - world)
                first -= spacing[axis] * (data.shape[2 - axis] - 1)
            assert abs(scale[world] - spacing[axis]) < 1e-9 and abs(translation[world] - first) < 1e-9, (order, signs)
        assert numpy.array_equal(levels[0], turned), (order, signs)
        same("out.zarr", turned)
        info = ok("info", "out.zarr", "--json").json
        assert info["space"] == ("RAS" if "anterior" in space else "plain") and info["unit"] in ("mm", "um")
        assert numpy.allclose(info["origin"], translation, atol=1e-9) and numpy.allclose(info["spacing"], scale, atol=1e-9)


def test_oblique_volumes_keep_their_place_for_volvis():
    c, s = math.cos(0.3), math.sin(0.3)
    nrrd("in.nrrd", noise((70, 5, 66), "u1"), ((2 * c, 2 * s, 0), (-s, c, 0), (0, 0, 3)), (1, 2, 3))
    for form in FORMATS:
        ok("convert", "in.nrrd", "-o", "out.zarr", "--output-format", form)
        ours, theirs = ok("info", "out.zarr", "--json").json, ok("info", "in.nrrd", "--json").json
        assert numpy.allclose(ours["directions"], theirs["directions"], atol=1e-12), (ours, theirs)
        assert numpy.allclose(ours["origin"], theirs["origin"], atol=1e-12) and ours["space"] == theirs["space"] == "RAS"
        low = ok("info", "out.zarr:1", "--json").json
        assert numpy.allclose(low["spacing"], (4, 1, 6))
        want = numpy.add(theirs["origin"], numpy.multiply((2 * c, 2 * s, 3), 0.5))
        assert numpy.allclose(low["origin"], want), (low["origin"], want)


def test_oblique_volumes_stand_upright_about_their_middle_for_others():
    data = noise((5, 6, 7), "i2")
    c, s = math.cos(0.3), math.sin(0.3)
    steps = numpy.array(((0, 0, -3), (-2 * c, -2 * s, 0), (s, -c, 0)))  # z downwards first, then x and y, both backwards
    origin = numpy.array((10, -20, 30))
    nrrd("in.nrrd", data, steps.tolist(), origin.tolist())
    middle = origin + numpy.array((3, 2.5, 2)) @ steps
    for form in FORMATS:
        says(ok("convert", "in.nrrd", "-o", "out.zarr", "--output-format", form).message, "no oblique axes", "about its middle")
        levels, image, _ = written("out.zarr")
        scale, translation = (t[k][::-1] for t, k in zip(image["datasets"][0]["coordinateTransformations"], ("scale", "translation")))
        assert numpy.allclose(scale, (2, 1, 3)), scale
        half = (numpy.array(levels[0].shape[::-1]) - 1) / 2
        assert numpy.allclose(numpy.add(translation, half * scale), middle), translation
        assert numpy.array_equal(levels[0], data.transpose(2, 0, 1)[::-1, ::-1, ::-1])
        ours = ok("info", "out.zarr", "--json").json
        assert numpy.allclose(ours["directions"], [-(steps[1] / 2), -steps[2], -(steps[0] / 3)], atol=1e-12), ours
        assert numpy.allclose(ours["origin"], origin + numpy.array((6, 5, 4)) @ steps, atol=1e-12), ours


def test_levels_are_means_and_of_labels_the_most_frequent():
    data = noise((70, 3, 133), "i2")
    for form in FORMATS:
        nrrd("in.nrrd", data)
        ok("convert", "in.nrrd", "-o", "out.zarr", "--output-format", form)
        levels, image, _ = written("out.zarr")
        assert len(levels) == 3 and image["type"] == "mean"
        for fine, coarse in zip(levels, levels[1:]):
            assert numpy.array_equal(halved(fine, False), coarse)
        cells = (data > 0).astype("u2") * (data % 5 + 5).astype("u2")
        nrrd("in.nrrd", cells)
        text = open("in.nrrd", "rb").read().replace(b"\n\n", b"\nvolvis meaning:=label\n\n", 1)
        open("in.nrrd", "wb").write(text)
        ok("convert", "in.nrrd", "-o", "out.zarr", "--output-format", form)
        levels, image, attributes = written("out.zarr")
        assert "image-label" in attributes and image["type"] == "mode"
        for fine, coarse in zip(levels, levels[1:]):
            assert numpy.array_equal(halved(fine, True), coarse)
        assert ok("info", "out.zarr", "--json").json["meaning"] == "label"


def test_frames_and_channels_have_axes_of_their_own():
    data = noise((2, 4, 5, 6, 3), "u2")
    for form in FORMATS:
        numpy.save("in.npy", data)
        ok("convert", "in.npy", "-o", "out.zarr", "--output-format", form)
        info = ok("info", "out.zarr", "--json").json
        levels, image, _ = written("out.zarr")
        letters = "".join(a["name"] for a in image["axes"])
        if levels[0].ndim == 5:
            assert letters == "tczyx" and numpy.array_equal(levels[0], data.transpose(0, 4, 1, 2, 3))
        else:
            assert letters == "czyx" and numpy.array_equal(levels[0], data[0].transpose(3, 0, 1, 2))
        assert info["components"] == 3
        colour = noise((4, 5, 6, 3), "u1")
        numpy.save("in.npy", colour)
        ok("convert", "in.npy", "-o", "out.zarr", "--output-format", form)
        assert ok("info", "out.zarr", "--json").json["meaning"].lower() == "rgb"
        same("out.zarr", colour)


def test_channels_without_a_colour_come_back_without():
    nrrd("in.nrrd", noise((4, 5, 6, 3), "i2"))
    keys = b"\nvolvis channel 0 name:=A\nvolvis channel 1 name:=B\nvolvis channel 1 color:=1 0 0\n" \
        b"volvis channel 2 name:=C\n\n"
    data = open("in.nrrd", "rb").read().replace(b"\n\n", keys, 1)
    open("in.nrrd", "wb").write(data)
    source = ok("info", "in.nrrd", "--json").json["channels"]
    for form in FORMATS:
        ok("convert", "in.nrrd", "-o", "out.zarr", "--output-format", form)
        channels = written("out.zarr")[2]["omero"]["channels"]
        assert [c["color"] for c in channels] == ["00FF00", "FF0000", "00FFFF"], channels  # the third default is cyan
        assert ok("info", "out.zarr", "--json").json["channels"] == source
        meta = "out.zarr/.zattrs" if form == FORMATS[0] else "out.zarr/zarr.json"
        text = open(meta).read().replace("00FFFF", "123456")
        open(meta, "w").write(text)
        changed = ok("info", "out.zarr", "--json").json["channels"]
        assert changed[:2] == source[:2] and changed[2] != source[2], changed  # another program's colour counts


def test_channels_and_labels_are_written():
    need_zarr()
    group = zarr.open_group("in.zarr", mode="w")
    group.attrs.put({**image("czyx", SCALE, SHIFT), "omero": {"channels": [
        {"label": "DAPI", "color": "0000FF", "window": {"start": 10, "end": 200, "min": 0, "max": 255}},
        {"label": "G \"P\"", "color": "12FF80"}]}})
    group.create_dataset("0", data=noise((2, 4, 5, 6), "u1"))
    inside = group.create_group("labels/cells")
    inside.attrs.put({**image("zyx", SCALE, SHIFT), "image-label": {
        "colors": [{"label-value": 1, "rgba": [255, 0, 0, 255]}, {"label-value": 3, "rgba": [0, 7, 255, 128]}],
        "properties": [{"label-value": 3, "class": "nucleus"}, {"label-value": 4, "name": "wall"}]}})
    inside.create_dataset("0", data=noise((4, 5, 6), "u2"))
    for form in FORMATS:
        ok("convert", "in.zarr", "-o", "out.zarr", "--output-format", form)
        channels = written("out.zarr")[2]["omero"]["channels"]
        assert [(c["label"], c["color"]) for c in channels] == [("DAPI", "0000FF"), ('G "P"', "12FF80")], channels
        assert channels[0]["window"] == {"min": 10, "start": 10, "end": 200, "max": 200}
        ok("convert", "in.zarr:labels/cells", "-o", "out.zarr", "--output-format", form)
        label = written("out.zarr")[2]["image-label"]
        assert [(c["label-value"], c["rgba"]) for c in label["colors"]] == [(1, [255, 0, 0, 255]), (3, [0, 7, 255, 128])]
        assert {p["label-value"]: p["name"] for p in label["properties"]} == {3: "nucleus", 4: "wall"}
        assert "source" not in label and label.get("version") == ("0.4" if form == FORMATS[0] else None)
        info = ok("info", "out.zarr", "--json").json
        assert info["meaning"] == "label" and info["warnings"] == [], info
        assert info["labels"] == ok("info", "in.zarr:labels/cells", "--json").json["labels"], info["labels"]
        assert [entry["name"] for entry in info["labels"]] == [None, "nucleus", "wall"], info["labels"]
    nrrd("in.nrrd", noise((4, 5, 6), "u1"))
    text = open("in.nrrd", "rb").read().replace(b"\n\n", b"\nvolvis meaning:=label\n\n", 1)
    open("in.nrrd", "wb").write(text)
    ok("convert", "in.nrrd", "-o", "plain.zarr")
    label = written("plain.zarr")[2]["image-label"]
    assert label == {"version": "0.4"}, label  # lists may not be empty


def test_only_empty_folders_and_zarrs_are_replaced():
    numpy.save("in.npy", noise((3, 4, 5), "u1"))
    os.mkdir("empty.zarr")
    ok("convert", "in.npy", "-o", "empty.zarr")
    ok("convert", "in.npy", "-o", "empty.zarr", "--output-format", "ome-zarr-0.5")
    assert not os.path.exists("empty.zarr/.zgroup") and os.path.exists("empty.zarr/zarr.json")
    os.makedirs("other.zarr/0")
    open("other.zarr/0/0", "w").write("precious")
    says(fails(5, "convert", "in.npy", "-o", "other.zarr"), "other contents")
    open("empty.zarr/0/notes.txt", "w").write("precious")
    says(fails(5, "convert", "in.npy", "-o", "empty.zarr"), "0/notes.txt")
    assert open("empty.zarr/0/notes.txt").read() == "precious"
    os.remove("empty.zarr/0/notes.txt")
    os.symlink("/etc/passwd", "empty.zarr/1")
    says(fails(5, "convert", "in.npy", "-o", "empty.zarr"), "'1'")
    open("file.zarr", "w").write("precious")
    says(fails(5, "convert", "in.npy", "-o", "file.zarr"), "is a file")
    assert open("file.zarr").read() == "precious"
    assert volvis("convert", "in.npy", "-o", "-", "--output-format", "ome-zarr").code != 0
    assert not [name for name in os.listdir(".") if "part" in name], os.listdir(".")


def test_zarrita_reads_what_is_written():
    """An independent reader in JavaScript, where node and the package are."""
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "zarrita.mjs")
    folder = os.environ.get("VOLVIS_NODE_MODULES") or os.path.join(
        os.path.dirname(script), "..", "..", "build", "node")
    if not shutil.which("node") or not os.path.isdir(os.path.join(folder, "node_modules", "zarrita")):
        raise Skip("node or its package zarrita is missing (tools/setup-node puts it there): skipped")
    codings = [(form, coding) for form in FORMATS for coding in ("gzip", "raw", "blosc", "zstd")]
    codings += [(FORMATS[1], coding) for coding in SHARDED]
    written_as = {}
    for kind, (form, coding) in itertools.product(("u1", "i2", "f4"), codings):
        data, name = noise((70, 5, 66), kind), f"{kind}-{form}-{coding}.zarr"
        numpy.save("in.npy", data)
        ok("convert", "in.npy", "-o", name, "--output-format", form, "--encoding", coding)
        written_as[os.path.abspath(name)] = data
    done = subprocess.run(["node", script, folder, "0", *written_as], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    for (name, data), line in zip(written_as.items(), done.stdout.splitlines(), strict=True):
        theirs = json.loads(line)
        assert theirs["shape"] == [70, 5, 66], (name, theirs)
        samples = numpy.fromfile(name + ".bin", data.dtype).reshape(theirs["shape"])
        assert numpy.array_equal(samples, data), name


# Real data -------------------------------------------------------------------------------------------------------


def shared(name):
    root = os.environ.get("VOLVIS_SHARED") or os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "shared")
    path = os.path.join(root, "data", "formats", "zarr", name)
    if not os.path.exists(path):
        raise Skip(f"{path} is not there: skipped")
    return path


def test_the_mri_stack_is_what_an_independent_reader_reads():
    path = shared("mri_stack_ome06.zarr")
    need_zarr()
    data, _ = zarr3.read_array(path + "/array")
    same(path, data)
    info = ok("info", path, "--json").json
    assert info["dims"] == [186, 226, 27] and info["spacing"] == [0.25, 0.5, 2] and info["unit"] == "um"


def test_the_small_arrays_are_what_the_zarr_package_reads():
    path = shared("data_v2.zarr")
    need_zarr()
    for name in ("3d.chunked.i2", "3d.chunked.mixed.i2.C", "3d.chunked.mixed.i2.F", "3d.contiguous.i2"):
        same(f"{path}:{name}", zarr.open(os.path.join(path, name), mode="r")[:])


# Large and little of it stored -----------------------------------------------------------------------------------

def write_large(name, shape, chunk, files=(), fill=0, **changes):
    os.makedirs(name)
    meta = {"zarr_format": 2, "shape": shape, "chunks": chunk, "dtype": "|u1", "compressor": {"id": "zlib", "level": 1},
            "fill_value": fill, "order": "C", "filters": None}
    with open(f"{name}/.zarray", "w", encoding="ascii") as file:
        json.dump({**meta, **changes}, file)
    for key, data in files:
        with open(f"{name}/{key}", "wb") as file:
            file.write(data)


def peak(*words):
    """What the program said, and the largest room that it took, MiB."""
    ran = subprocess.run(["/usr/bin/env", "python3", "-c", "import resource, subprocess, sys\n"
                          "code = subprocess.run(sys.argv[1:]).returncode\n"
                          "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss >> 10)\nsys.exit(code)",
                          VOLVIS, *words], capture_output=True, text=True, env=environment())
    return ran.returncode, ran.stderr, int(ran.stdout.split()[-1])


def test_chunks_that_cannot_be_right_take_no_memory():
    large, packed = [1000, 1000, 400], zlib.compress(bytes(4 << 20))
    write_large("short.zarr", large, large, [("0.0.0", packed)])
    write_large("plain.zarr", large, large, [("0.0.0", bytes(100))], compressor=None)
    write_large("empty.zarr", large, large)
    write_large("pieces.zarr", [2000, 2000, 2000], [1000, 1000, 400])
    for name, words in (("short", "no valid data has; --limit expansion_zstd=N"), ("plain", "it is cut short"),
                        ("empty", "asks for 400000000 bytes, none of which are stored; --limit expansion_after=1G"),
                        ("pieces", "none of which are stored")):
        code, said, took = peak("info", "--stats", f"{name}.zarr", "--memory", "12G")
        assert code == 3 and took < 100, (name, code, took, said)
        says(said, words)


def test_a_fill_value_between_few_chunks_is_read():
    chunk = [50, 600, 600]
    data = numpy.full(chunk, 7, "u1")
    write_large("few.zarr", [250, 600, 600], chunk, [("4.0.0", zlib.compress(data.tobytes()))], fill=3)
    want = numpy.full([250, 600, 600], 3, "u1")
    want[200:] = 7
    assert numpy.array_equal(read("few.zarr").reshape(want.shape), want)


if __name__ == "__main__":
    main()
