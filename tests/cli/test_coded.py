"""Packed data of which a part is read: whether it is what was written is said at its end, and must be known all the same."""
import bz2
import gzip
import json
import os
import re
import struct
import subprocess
import zlib

import hostile_files
import numpy
import tifffile
from harness import VOLVIS, environment, fails, main, ok, sanitized, says, volvis
from test_hostile import run_alone

DIMS = (20, 18, 16, 6)


def steps():
    """Six time steps, x first."""
    x, y, z, t = numpy.meshgrid(*(numpy.arange(n) for n in DIMS), indexing="ij")
    noise = numpy.random.default_rng(1).integers(0, 20, DIMS)
    return (1000 * numpy.exp(-((x - 10.0)**2 + (y - 9)**2 + (z - 8)**2) / (20 + 5 * t)) + noise).astype("<i2").transpose().tobytes()


def nifti(data):
    return hostile_files.nifti1([4, *DIMS], datatype=4, bits=16, n=352) + data


def packed(data):
    """A gzip stream, and the same with a bit flipped in the first step that shows nowhere but in the samples and the sum."""
    good = gzip.compress(data, mtime=0)
    truth = zlib.decompressobj(-15).decompress(good[10:])
    for at in range(2000, 4000):
        bad = bytearray(good)
        bad[at] ^= 1
        try:
            got = zlib.decompressobj(-15).decompress(bytes(bad[10:]))
        except zlib.error:
            continue
        if len(got) == len(truth) and got[:352] == truth[:352] and got != truth:
            return good, bytes(bad)
    raise AssertionError("no bit that would do")


def nrrd(coded, name=None):
    header = f"NRRD0004\ntype: short\ndimension: 4\nsizes: {' '.join(map(str, DIMS))}\nkinds: domain domain domain time\nendian: little\n"
    return (header + "encoding: gzip\n\n").encode() + coded if name is None else (header + f"encoding: gzip\ndata file: {name}\n\n").encode()


def mha(coded):
    return (f"ObjectType = Image\nNDims = 4\nDimSize = {' '.join(map(str, DIMS))}\nElementType = MET_SHORT\nCompressedData = True\n"
            f"CompressedDataSize = {len(coded)}\nElementDataFile = LOCAL\n").encode() + coded


def write(name, data):
    with open(name, "wb") as file:
        file.write(data)


def makers():
    whole = packed(nifti(steps()))
    part = packed(steps())
    yield "t.nii.gz", whole
    yield "t.nrrd", [nrrd(coded) for coded in part]
    yield "t.mha", [mha(coded) for coded in part]
    for coded, name in zip(part, ("good.gz", "bad.gz")):
        write(name, coded)
    yield "t.nhdr", [nrrd(None, name) for name in ("good.gz", "bad.gz")]


def test_a_time_step_of_damaged_data_is_refused_wherever_the_damage_is_told():
    first = numpy.frombuffer(steps(), "<i2")[:20 * 18 * 16]
    for name, (good, bad) in makers():
        for words in ([], ["--safe"]):
            write(name, good)
            said = ok("info", "--stats", "--json", name, *words).json
            assert (said["min"], said["max"]) == (first.min(), first.max()), (name, said)
            write(name, bad)
            for verb in (["info", "--stats", name], ["info", "--stats", f"{name}@2"], ["measure", "statistics", f"{name}@0"],
                         ["render", name, "-o", "o.png", "--size", "16x16", "--overwrite"], ["gaussian", f"{name}@1", "-o", "o.nrrd", "--sigma", "1", "--overwrite"],
                         ["convert", name, "-o", "o.nrrd", "--overwrite"]):
                said = fails(3, *verb, "--quiet", *words)
                assert re.search(r"after \d+ bytes of (gzip|zlib) data", said), (name, verb, said)


def test_a_time_step_that_is_there_is_read_of_what_is_cut_and_the_missing_sum_told():
    whole = gzip.compress(nifti(steps()), mtime=0)
    write("cut.nii.gz", whole[:len(whole) // 2])
    first = numpy.frombuffer(steps(), "<i2")[:20 * 18 * 16]
    for words in ([], ["--safe"]):
        run = volvis("info", "--stats", "--json", "cut.nii.gz", *words)
        assert run.code == 7 and "not the checksum" in run.message, run.message
        said = run.json
        assert (said["min"], said["max"]) == (first.min(), first.max()), said


def test_what_would_take_long_to_reach_is_told_instead():
    write("long.nii.gz", hostile_files.zeros_deflate(hostile_files.nifti1([4, 64, 64, 64, 2400], datatype=2, bits=8, n=352), 600, 31))
    for words in ([], ["--safe"]):
        run = volvis("info", "--stats", "long.nii.gz", *words)
        assert run.code == 0 and "of its gzip data; the checksum comes later" in run.message, run.message
        assert run.message.count("checksum") == 1, run.message


def test_what_a_crop_of_more_than_memory_leaves_unread_is_told():
    write("large.nii.gz", hostile_files.zeros_deflate(hostile_files.nifti1([3, 512, 512, 300], datatype=2, bits=8, n=352), 75, 31))
    for words, told in ((("--z", "10..20"), True), (("--x", "5..20", "--y", "5..20"), False)):
        run = volvis("crop", "large.nii.gz", *words, "-o", "o.nrrd", "--overwrite", "--memory", "40M")
        assert run.code == 0 and ("the checksum comes later" in run.message) == told, (words, run.message)


def test_each_of_several_files_is_read_to_its_checksum():
    data, per = steps(), 20 * 18 * 16 * 2
    for i in range(DIMS[3]):
        write(f"{i}.gz", gzip.compress(data[i * per:(i + 1) * per], mtime=0))
    pieces = nrrd(None, "LIST\n" + "\n".join(f"{i}.gz" for i in range(DIMS[3]))).rstrip(b"\n") + b"\n"
    write("list.nhdr", pieces)
    sized = ["list.nhdr"]
    header = (f"ObjectType = Image\nNDims = 4\nDimSize = 20 18 16 6\nElementType = MET_SHORT\nElementDataFile = LIST 3\n" + "".join(f"{i}.gz\n" for i in range(6)))
    write("list.mhd", header.encode())
    sized.append("list.mhd")
    for name in sized:
        ok("convert", name, "-o", "o.nrrd", "--overwrite")
    with open("2.gz", "r+b") as file:
        file.seek(-8, os.SEEK_END)
        file.write(struct.pack("<I", 1994))
    for name in sized:
        fails(3, "convert", name, "-o", "o.nrrd", "--overwrite")


NOISE = numpy.random.default_rng(2).integers(0, 256, 50 << 10, "u1").tobytes()
MIB = 160


def deflated(head, wrong, members=1):
    """Gzip: a head and 160 MiB in 8 MB, no two MiB alike nearby; members of it. And what is in it behind the head."""
    squeeze = zlib.compressobj(6, zlib.DEFLATED, -15)
    start = squeeze.compress(head) + squeeze.flush(zlib.Z_FULL_FLUSH)
    plain = [bytes([i]) + NOISE + bytes((1 << 20) - len(NOISE) - 1) for i in range(20)]
    pieces = [squeeze.compress(one) + squeeze.flush(zlib.Z_FULL_FLUSH) for one in plain]
    end, out, each = squeeze.flush(), [], MIB // members
    for m in range(members):
        mine = [i % 20 for i in range(m * each, (m + 1) * each)]
        crc = zlib.crc32(head if m == 0 else b"")
        for i in mine:
            crc = zlib.crc32(plain[i], crc)
        last = m + 1 == members
        tail = struct.pack("<II", crc ^ (wrong and last), (len(head) * (m == 0) + (each << 20)) & 0xffffffff)
        out += [b"\x1f\x8b\x08" + bytes(6) + b"\xff", start if m == 0 else b""] + [pieces[i] for i in mine] + [end, tail]
    return b"".join(out), plain


def test_damaged_data_cost_no_more_than_64_mib_and_twice_the_file_before_they_are_refused():
    if sanitized():
        return
    head = hostile_files.nifti1([3, 1024, 1024, MIB], datatype=2, bits=8, n=352)
    wrong, least = deflated(head, True)[0], {}
    bare = deflated(b"", True)[0]
    zipped = b"\x78\x01" + bare[10:-8] + bytes(4)
    write("x.nii.gz", wrong)
    write("two.nii.gz", deflated(head, True, 2)[0])
    write("less.nii.gz", wrong[:len(wrong) * 45 // 100])
    write("twice.nrrd.gz", gzip.compress(b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1024 1024 160\nencoding: gzip\n\n" + bare, 1, mtime=0))
    write("z.mha", (f"ObjectType = Image\nNDims = 3\nDimSize = 1024 1024 160\nElementType = MET_UCHAR\nCompressedData = True\n"
                    f"CompressedDataSize = {len(zipped)}\nElementDataFile = LOCAL\n").encode() + zipped)
    # every sample of the first row goes to a place of its own in memory: nothing may be written before it is proven
    write("planes.nrrd", b"NRRD0004\ntype: uchar\ndimension: 4\nsizes: 1024 1024 20 8\nkinds: domain domain domain vector\nencoding: gzip\n\n" + bare)
    write("tiny.nii.gz", gzip.compress(hostile_files.nifti1([3, 8, 8, 8], datatype=2, bits=8, n=352) + bytes(512), mtime=0))
    render = ["render", "--size", "16x16", "-o", "o.png", "--overwrite"]
    tried = [(name, ["info", "--stats"]) for name in ("x.nii.gz", "two.nii.gz", "less.nii.gz", "twice.nrrd.gz", "z.mha", "planes.nrrd")]
    for name, words in tried + [("x.nii.gz", ["info", "--stats", "--safe"]), ("twice.nrrd.gz", ["info", "--stats", "--safe"]), ("x.nii.gz", render)]:
        size = os.path.getsize(name)
        assert 15 < (160 << 20) / size < 50
        code, message, peak = run_alone(*words, name)
        assert code == 3 and ("less than half" if name == "less.nii.gz" else "data check") in message, message
        if str(words) not in least:
            least[str(words)] = run_alone(*words, "tiny.nii.gz")[2]
        beyond = peak - least[str(words)]
        assert beyond < (64 << 20) + 2 * size, f"{words[0]} {name}: {beyond / 2**20:.0f} MiB for {size} bytes"


def glb(count):
    bulk = bytes(12 * count) + numpy.tile(numpy.arange(3, dtype="<u4"), count).tobytes()
    views = [{"buffer": 0, "byteOffset": i * 12 * count, "byteLength": 12 * count} for i in range(2)]
    accessors = [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}, {"bufferView": 1, "componentType": 5125, "count": 3 * count, "type": "SCALAR"}]
    text = json.dumps({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "buffers": [{"byteLength": len(bulk)}],
                       "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}], "bufferViews": views, "accessors": accessors}).encode()
    text += b" " * (-len(text) % 4)
    return b"glTF" + struct.pack("<IIII", 2, 28 + len(text) + len(bulk), len(text), 0x4e4f534a) + text + struct.pack("<II", len(bulk), 0x4e4942) + bulk


def vtp(count):
    data = [bytes(12 * count), numpy.tile(numpy.arange(3, dtype="<i4"), count).tobytes(), (3 * numpy.arange(1, count + 1)).astype("<i4").tobytes()]
    at = [0, 4 + len(data[0]), 8 + len(data[0]) + len(data[1])]
    arrays = [f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{n}" format="appended" offset="{offset}"/>'
              for kind, name, n, offset in zip(("Float32", "Int32", "Int32"), ("Points", "connectivity", "offsets"), (3, 1, 1), at)]
    return (f'<?xml version="1.0"?><VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"><PolyData><Piece NumberOfPoints="{count}" NumberOfVerts="0" '
            f'NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{count}"><Points>{arrays[0]}</Points><Polys>{arrays[1]}{arrays[2]}</Polys></Piece></PolyData>'
            '<AppendedData encoding="raw">_').encode() + b"".join(struct.pack("<I", len(one)) + one for one in data) + b"</AppendedData></VTKFile>"


def large_meshes():
    """Each of some 50 MB that takes more than 64 MiB of memory: places of their own, or polygons that become several triangles."""
    facets = numpy.zeros(10**6, [("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("bits", "<u2")])
    facets["corner"][:, :, 0] = numpy.arange(len(facets))[:, None]
    facets["corner"][:, 1, 1] = facets["corner"][:, 2, 2] = 1
    yield "a.stl", bytes(80) + struct.pack("<I", len(facets)) + facets.tobytes()
    squares = numpy.zeros(3 * 10**6, [("n", "u1"), ("corner", "<i4", 4)])
    squares["n"], squares["corner"] = 4, [0, 1, 2, 3]
    yield "a.ply", (b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                    b"element face 3000000\nproperty list uchar int vertex_indices\nend_header\n") + bytes(48) + squares.tobytes()
    yield "a.obj", b"v 0 0 0\n" * 4 * 10**6 + b"f 1 2 3\n" * 10**6
    yield "a.off", b"OFF\n3000000 3000000 0\n" + b"0 0 0\n" * 3 * 10**6 + b"3 0 1 2\n" * 3 * 10**6
    yield "a.vtp", vtp(2 * 10**6)
    yield "a.glb", glb(2 * 10**6)


def test_damaged_meshes_cost_no_more_either():
    if sanitized():
        return
    write("tiny.stl.gz", gzip.compress(bytes(80) + struct.pack("<I", 1) + struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0), mtime=0))
    least = {words: run_alone("info", "tiny.stl.gz", *words)[2] for words in ((), ("--safe",))}
    for name, data in large_meshes():
        name, whole = f"{name}.gz", gzip.compress(data, 1, mtime=0)
        for damaged, said, words in ((whole[:-8] + b"oops" + whole[-4:], "data check", ()), (whole[:-len(whole) // 16], "is cut short", ("--safe",))):
            write(name, damaged)
            code, message, peak = run_alone("info", name, *words)
            assert code == 3 and said in message, (name, message)
            beyond = peak - least[words]
            assert beyond < (64 << 20) + 2 * len(damaged), f"{name} {words}: {beyond / 2**20:.0f} MiB for {len(damaged)} bytes"
        os.remove(name)


def test_damaged_strips_of_tiff_are_missing():
    """libtiff stops at the last number, whatever comes then."""
    tifffile.imwrite("a.tif", numpy.frombuffer(NOISE[:1 << 14], "u1").reshape(4, 64, 64), photometric="minisblack", compression="zlib", rowsperstrip=64)
    with tifffile.TiffFile("a.tif") as tif:
        at, n = tif.pages[2].dataoffsets[0], tif.pages[2].databytecounts[0]
    assert volvis("info", "--stats", "a.tif").code == 0
    with open("a.tif", "r+b") as file:
        file.seek(at + n - 4)  # the checksum of the third page
        file.write(b"oops")
    run = volvis("info", "--stats", "a.tif")
    assert run.code == 7 and "12288 of 16384 numbers are there" in run.message, run.message


def test_what_strangers_pack_may_not_look_back_far():
    """What a decoder of zstd looks back at is memory, too: a window of 128 MiB, then of 8 MiB."""
    data = b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 16 16 16\nencoding: raw\n\n" + bytes(4096)
    for log, words, code in ((27, (), 0), (27, ("--safe",), 3), (23, ("--safe",), 0)):
        write("a.nrrd.zst", b"\x28\xb5\x2f\xfd\0" + bytes([(log - 10) << 3]) + (len(data) << 3 | 1).to_bytes(3, "little") + data)
        run = volvis("info", "--stats", "a.nrrd.zst", *words)
        assert run.code == code and ("looks back further" in run.message) == (code == 3), run.message


def test_what_is_promised_and_not_there_costs_nothing():
    if sanitized():
        return
    write("tiny.nii.gz", gzip.compress(hostile_files.nifti1([3, 8, 8, 8], datatype=2, bits=8, n=352) + bytes(512), mtime=0))
    least = run_alone("info", "--stats", "tiny.nii.gz")[2]
    plain, facets = NOISE * 20 + bytes(120 << 20), numpy.zeros(10**6, [("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("bits", "<u2")])
    facets["corner"][:, 0, 0] = facets["corner"][:, 1, 1] = facets["corner"][:, 2, 2] = 1 + numpy.arange(len(facets))
    # streams that are whole, and shorter than what is said of them
    for encoding, coded in (("gzip", gzip.compress(plain, 6, mtime=0)), ("bzip2", bz2.compress(plain, 1))):
        write(f"{encoding}.nrrd", f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1024 1024 1000\nencoding: {encoding}\n\n".encode() + coded)
    write("short.stl.gz", gzip.compress(bytes(80) + struct.pack("<I", 14 * 10**6) + facets.tobytes(), 1, mtime=0))
    write("short.ply.gz", gzip.compress(b"ply\nformat binary_little_endian 1.0\nelement vertex 14000000\nproperty float x\nproperty float y\nproperty float z\n"
                                        b"element face 1\nproperty list uchar int vertex_indices\nend_header\n" + bytes(100 << 20), 1, mtime=0))
    write("short.off.gz", gzip.compress(b"OFF\n14000000 1 0\n" + b"0 0 0\n" * 6 * 10**6, 6, mtime=0))
    for name, said in (("gzip.nrrd", "less than half"), ("bzip2.nrrd", "less than half"), ("short.stl.gz", "cut short"), ("short.ply.gz", "cut short"),
                       ("short.off.gz", "cut short")):
        for words in ([], ["--safe"])[:1 if name == "bzip2.nrrd" else 2]:
            code, message, peak = run_alone("info", *(["--stats"] if "nrrd" in name else []), *words, name)
            assert code == 3 and said in message, message
            beyond = peak - least
            assert beyond < (64 << 20) + 2 * os.path.getsize(name), f"{name} {words}: {beyond / 2**20:.0f} MiB"


def test_what_is_proven_half_way_is_read_on_from_there():
    if sanitized():
        return
    head = hostile_files.nifti1([3, 1024, 1024, MIB], datatype=2, bits=8, n=352)
    coded, truth = deflated(head, False, 2)  # the second begins behind the place from where they are proven
    write("x.nii.gz", coded)
    ok("convert", "x.nii.gz", "-o", "x.npy", "--quiet")
    got = numpy.load("x.npy", mmap_mode="r").ravel()
    for i in range(MIB):
        assert got[i << 20:(i + 1) << 20].tobytes() == truth[i % 20], i


if __name__ == "__main__":
    main()
