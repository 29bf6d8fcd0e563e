"""Data in and out: info, convert, operations, compare."""
import bz2
import gzip
import itertools
import json
import os
import subprocess
import re
import struct
import zlib
from harness import HEAD_MRI, Skip, fails, main, ok, says, volvis, write_ball, write_large, write_nrrd

INFO_KEYS = {"format", "dims", "type", "components", "frames", "spacing", "origin", "directions", "unit", "space",
             "memory_bytes"}


def test_info_has_the_keys_that_scripts_rely_on():
    write_ball(spacing=(1, 1, 2))
    answer = ok("info", "head.nrrd", "--json").json
    assert INFO_KEYS <= set(answer), INFO_KEYS - set(answer)
    assert answer["dims"] == [32, 32, 32] and answer["type"] == "u8" and answer["spacing"] == [1, 1, 2]
    assert answer["directions"] == [[1, 0, 0], [0, 1, 0], [0, 0, 1]] and answer["unit"] == "mm"
    assert answer["space"] == "RAS" and answer["memory_bytes"] == 32**3 and "min" not in answer


def test_info_with_stats_looks_at_every_sample():
    write_nrrd("a.nrrd", (4, 3, 2), lambda x, y, z: x + 10 * y + 100 * z, kind="int16", code="h")
    answer = ok("info", "a.nrrd", "--stats", "--json").json
    assert answer["min"] == 0 and answer["max"] == 123 and answer["nan_count"] == 0
    assert abs(answer["mean"] - (1.5 + 10 + 50)) < 1e-9
    assert sum(answer["histogram"]["counts"]) == 24
    assert answer["checksum"].startswith("crc32:")


def test_info_counts_what_is_no_number():
    nan = float("nan")
    write_nrrd("a.nrrd", (4, 4, 4), lambda x, y, z: nan if x == 0 else x, kind="float", code="f")
    answer = ok("info", "a.nrrd", "--stats", "--json").json
    assert answer["nan_count"] == 16 and answer["min"] == 1 and answer["max"] == 3


def test_info_of_data_without_a_finite_sample_has_no_range():
    write_nrrd("a.nrrd", (4, 4, 4), lambda x, y, z: float("nan") if x else float("inf"), kind="float", code="f")
    answer = ok("info", "a.nrrd", "--stats", "--json").json
    assert answer["count"] == 0 and answer["nan_count"] == 48 and answer["infinite_count"] == 16
    for key in ("min", "max", "mean", "deviation"):
        assert answer[key] is None, key
    assert set(answer["percentiles"].values()) == {None}
    says(ok("info", "a.nrrd", "--stats").text, "none", "48 NaN, 16 infinite")


def test_info_tells_large_values_apart():
    write_nrrd("a.nrrd", (4, 4, 4), lambda x, y, z: 1000000000 + 5 * x, kind="int32", code="i")
    says(ok("info", "a.nrrd", "--stats").text, "range         1000000000 to 1000000015", "mean          1000000007.5")
    write_nrrd("b.nrrd", (4, 4, 4), lambda x, y, z: 1000000015, kind="int32", code="i")
    says(ok("info", "b.nrrd", "--stats").text, "range         1000000015 to 1000000015")
    write_nrrd("c.nrrd", (4, 4, 4), lambda x, y, z: 0.1 * x, kind="float", code="f")
    says(ok("info", "c.nrrd", "--stats").text, "range         0 to 0.3", "mean          0.15")


def test_zero_has_no_sign_in_json():
    with open("a.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\n"
                   b"space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n" + bytes(8))
    assert "-0" not in ok("info", "a.nrrd", "--json").text
    says(ok("info", "a.nrrd").text, "origin        0, 0, 0")


def test_a_warning_is_said_once():
    with open("a.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: float\ndimension: 3\nsizes: 8 8 8\nencoding: raw\nendian: little\n\n"
                   + struct.pack("<f", float("nan")) * 512)
    for words in (["info", "a.nrrd"], ["convert", "a.nrrd", "-o", "b.nrrd"],
                  ["render", "a.nrrd", "-o", "a.png", "--size", "16x16", "--save-scene", "a.vv.json"]):
        said = [line for line in ok(*words).message.splitlines() if "warning" in line]
        assert len(said) == len(set(said)), said
        facts = [line.split(": ", 3)[-1] for line in said]
        assert len(facts) == len(set(facts)), said
    assert "no sample is a number" in " ".join(said)
    assert ok(*words, "-q").message == ""


def test_quiet_says_nothing_of_a_success():
    write_ball()
    for words in (["convert", "head.nrrd", "-o", "a.nrrd"], ["gaussian", "head.nrrd", "-o", "a.nrrd"],
                  ["render", "head.nrrd", "-o", "a.png", "--size", "16x16"]):
        assert ok(*words).text != ""
        result = ok(*words, "-q")
        assert result.text == "" and result.message == ""
        assert ok(*words, "-q", "--json").json["output"] == words[3]
    says(ok("convert", "head.nrrd", "-o", "b.nrrd", "-q", "--dry-run").text, "makes")
    says(ok("info", "head.nrrd", "-q").text, "32 x 32 x 32")


def test_info_for_people_explains_the_orientation():
    write_ball()
    says(ok("info", "head.nrrd", "--stats").text, "letter = direction of increase", "histogram", "32 x 32 x 32 u8",
         "spacing", "range", "memory")


def test_a_head_of_a_real_person_is_understood():
    if not os.path.exists(HEAD_MRI):
        raise Skip("mricron-data is not installed")
    answer = ok("info", HEAD_MRI, "--stats", "--json").json
    assert answer["format"] == "nifti" and answer["dims"] == [181, 217, 181] and answer["unit"] == "mm"


def test_formats_keep_samples_and_placement():
    write_ball(spacing=(1, 1.5, 2))
    for suffix in ("nrrd", "nhdr", "nii", "nii.gz"):
        ok("convert", "head.nrrd", "-o", f"a.{suffix}")
        answer = ok("compare", "head.nrrd", f"a.{suffix}", "--max-difference", "0", "--json").json
        assert answer["identical"] and answer["placement_difference"] < 1e-5 and answer["same_world"], (suffix, answer)


def test_units_are_known_however_they_are_spelled():
    for i, (said, meant) in enumerate((("\u00c5", "A"), ("\u212b", "A"), ("\u00b5m", "um"), ("\u03bcm", "um"), ("Angstrom", "A"))):
        write_nrrd("said.nrrd", (3, 3, 3), lambda x, y, z: x, spacing=(0.5, 0.5, 0.5), unit=said)
        assert ok("info", "said.nrrd", "--json").json["unit"] == meant, said
        for name in (f"said{i}.ome.zarr", f"said{i}.ome.tif"):
            ok("convert", "said.nrrd", "-o", name)
            found = ok("info", name, "--json").json
            assert (found["unit"], found["spacing"]) == (meant, [0.5, 0.5, 0.5]), (said, name, found)


def test_convert_keeps_numbers_or_says_that_it_cannot():
    write_nrrd("a.nrrd", (4, 4, 4), lambda x, y, z: 100 * x - 50, kind="int16", code="h")
    ok("convert", "a.nrrd", "-o", "b.nrrd", "--type", "f32")
    assert ok("compare", "a.nrrd", "b.nrrd", "--json").json["identical"]
    says(fails(2, "convert", "a.nrrd", "-o", "c.nrrd", "--type", "u8"), "-50 to 250", "--range -50..250")
    ok("convert", "a.nrrd", "-o", "c.nrrd", "--type", "u8", "--range", "-50,250")
    answer = ok("info", "c.nrrd", "--stats", "--json").json
    assert answer["type"] == "u8" and answer["min"] == 0 and answer["max"] == 255


def test_convert_crops():
    write_ball()
    ok("convert", "head.nrrd", "-o", "a.nrrd", "--x", "4:12", "--z", "-8:")
    answer = ok("info", "a.nrrd", "--json").json
    assert answer["dims"] == [8, 32, 8] and answer["origin"] == [4, 0, 24]


def test_a_dry_run_says_what_would_be_and_makes_nothing():
    write_ball()
    answer = ok("gaussian", "head.nrrd", "-o", "a.nrrd", "--dry-run", "--json").json
    assert answer["dry_run"] and answer["dims"] == [32, 32, 32] and answer["memory_bytes"] >= 32**3
    says(ok("crop", "head.nrrd", "-o", "a.nrrd", "--x", "1:3", "--dry-run").text, "reads", "makes", "2 x 32 x 32", "needs")
    assert not os.path.exists("a.nrrd")


def test_a_dry_run_counts_packed_samples_that_must_be_held():
    write_ball()
    ok("convert", "head.nrrd", "-o", "packed.nii.gz")
    assert ok("convert", "packed.nii.gz", "-o", "a.nrrd", "--dry-run", "--json").json["memory_bytes"] == 32**3
    assert ok("convert", "head.nrrd", "-o", "a.nrrd", "--dry-run", "--json").json["memory_bytes"] == 0
    answer = ok("gaussian", "packed.nii.gz", "-o", "a.nrrd", "--dry-run", "--json").json
    assert answer["memory_bytes"] >= 2 * 32**3


def test_lengths_have_units_of_the_input():
    write_ball(spacing=(2, 2, 2))
    ok("gaussian", "head.nrrd", "-o", "a.nrrd", "--sigma", "3mm")
    ok("gaussian", "head.nrrd", "-o", "b.nrrd", "--sigma", "1.5vox")
    assert ok("compare", "a.nrrd", "b.nrrd", "--json").json["identical"]
    says(fails(2, "gaussian", "head.nrrd", "-o", "c.nrrd", "--sigma", "3furlong"), "--sigma", "furlong", "mm")


def test_standard_input_and_output_are_files_too():
    write_ball()
    with open("head.nrrd", "rb") as file:
        head = file.read()
    piped = ok("convert", "-", "-o", "-", "--output-format", "nrrd", stdin=head)
    answer = ok("info", "-", "--json", stdin=piped.out).json
    assert answer["dims"] == [32, 32, 32] and answer["spacing"] == [1, 1, 1]
    says(piped.message, "32 x 32 x 32")
    says(fails(2, "convert", "head.nrrd", "-o", "-"), "--output-format")
    says(fails(2, "convert", "head.nrrd", "-o", "-", "--output-format", "nrrd", "--json"), "standard output")


def test_safely_read_is_the_same():
    write_ball()
    plain = ok("convert", "head.nrrd", "-o", "-", "--output-format", "nifti").out
    assert ok("convert", "head.nrrd", "-o", "-", "--output-format", "nifti", "--safe").out == plain
    packed = gzip.compress(open("head.nrrd", "rb").read())
    assert ok("convert", "-", "-o", "-", "--output-format", "nifti", "--safe", stdin=packed).out == plain
    os.mkfifo("pipe")
    with subprocess.Popen(["sh", "-c", "cat head.nrrd > pipe"]):
        assert ok("convert", "pipe", "-o", "-", "--output-format", "nifti", "--safe").out == plain
    safe, told = (ok("info", "head.nrrd", "--stats", "--json", *words).json for words in (["--safe"], []))
    assert [key for key in told if safe[key] != told[key]] in ([], ["mappable"]), (safe, told)
    ok("render", "head.nrrd", "-o", "a.png", "--safe", "--set", "views.main.width=64", "--set", "views.main.height=64")
    for name, data in {"short.nrrd": b"NRRD0004\n", "none.bin": b"nothing of anything"}.items():
        with open(name, "wb") as file:
            file.write(data)
        code = 3 if "nrrd" in name else 2
        assert fails(code, "info", name, "--safe") == fails(code, "info", name)
    with open("head.nrrd", "rb") as file, open("cut.nrrd", "wb") as cut:
        cut.write(file.read()[:-5000])
    assert volvis("info", "--stats", "cut.nrrd", "--safe").code == 7


def test_a_text_without_a_last_line_end_is_doubted():
    head = "NRRD0004\ntype: int\ndimension: 3\nsizes: 2 1 1\nencoding: ascii\n\n100 20"
    for end, doubted in {"": True, "\n": False, " 7": False}.items():
        with open("text.nrrd", "w") as file:
            file.write(head + end)
        done = ok("info", "--stats", "text.nrrd")
        assert ("after its last number, 20," in done.message) == doubted, done.message


def test_headerless_data_is_read_by_name_or_layout():
    with open("ramp_4x3x2_uint16.raw", "wb") as file:
        file.write(struct.pack("<24H", *range(24)))
    assert ok("info", "ramp_4x3x2_uint16.raw", "--json").json["dims"] == [4, 3, 2]
    os.rename("ramp_4x3x2_uint16.raw", "data.bin")
    answer = ok("info", "data.bin", "--raw", "4x3x2,u16,spacing=1x1x1.5", "--stats", "--json").json
    assert answer["spacing"][2] == 1.5 and answer["max"] == 23


def test_an_input_is_not_overwritten_unasked():
    write_ball()
    with open("head.nrrd", "rb") as file:
        before = file.read()
    says(fails(2, "gaussian", "head.nrrd", "-o", "head.nrrd"), "--overwrite")
    os.symlink("head.nrrd", "link.nrrd")
    says(fails(2, "gaussian", "link.nrrd", "-o", "./head.nrrd"), "--overwrite")
    with open("head.nrrd", "rb") as file:
        assert file.read() == before
    ok("gaussian", "head.nrrd", "-o", "head.nrrd", "--overwrite", "--sigma", "2vox")
    with open("head.nrrd", "rb") as file:
        assert file.read() != before


def samples(path):
    with open(path, "rb") as file:
        return file.read()


def test_the_data_of_an_input_are_not_replaced():
    write_ball()
    ok("convert", "head.nrrd", "-o", "a.mhd")
    data = samples("a.raw")
    says(fails(2, "convert", "a.mhd", "-o", "a.nhdr", "--type", "f32"), "a.raw", "--overwrite")
    says(fails(2, "convert", "a.mhd", "-o", "a.raw", "--flip", "x", "-q"), "a.raw", "--overwrite")
    says(fails(2, "convert", "head.nrrd", "-o", "a.nhdr"), "a.raw", "another header")
    assert samples("a.raw") == data and not os.path.exists("a.nhdr")
    ok("convert", "a.mhd", "-o", "b.nhdr")
    ok("convert", "a.mhd", "-o", "b.nhdr", "--flip", "x")
    ok("convert", "a.mhd", "-o", "a.nhdr", "--overwrite")


def test_the_data_of_headers_that_are_there_are_not_replaced():
    write_ball(n=4)
    for header in ("a.nhdr", "b.mhd", "c.vvh"):
        data = header[0] + ".raw"
        ok("convert", "head.nrrd", "-o", header)
        before = samples(data)
        says(fails(2, "convert", "head.nrrd", "-o", data, "-q"), data, header, "--overwrite")
        assert samples(data) == before
        ok("convert", "head.nrrd", "-o", header)  # its own header
        ok("convert", "head.nrrd", "-o", data, "--overwrite", "-q")
    ok("convert", "head.nrrd", "-o", "p.hdr")
    says(fails(2, "convert", "head.nrrd", "-o", "p.img", "--output-format", "raw", "-q"), "p.img", "p.hdr")
    with open("d.nhdr", "w", encoding="ascii") as file:
        file.write(open("a.nhdr", encoding="ascii").read().replace("data file: a.raw", "data file: LIST\nxa.raw\na.raw.gz"))
    os.remove("a.nhdr")
    ok("convert", "head.nrrd", "-o", "a.raw", "-q")  # longer names are others


def test_the_data_of_a_gltf_are_not_replaced():
    write_ball(n=8)
    ok("isosurface", "head.nrrd", "-o", "m.gltf", "--iso", "100", "--encoding", "separate")
    before = samples("m.bin")
    says(fails(2, "convert", "head.nrrd", "-o", "m.bin", "--output-format", "raw", "-q"), "m.gltf", "--overwrite")
    assert samples("m.bin") == before
    ok("isosurface", "head.nrrd", "-o", "m.gltf", "--iso", "90", "--encoding", "separate")  # its own header


def test_too_little_memory_is_said_before_the_work():
    write_large("a.nrrd", 128)
    ok("convert", "a.nrrd", "-o", "packed.nrrd", "--encoding", "gzip", "--level", "1")
    said = fails(4, "render", "packed.nrrd", "-o", "b.png", "--memory", "1M")
    says(said, "give more with --memory")
    assert "--memory, or" in said
    assert not os.path.exists("b.png")
    answer = volvis("render", "packed.nrrd", "-o", "b.png", "--memory", "1M", "--json")
    assert answer.code == 4 and answer.json["error"]["code"] == "limit"


def test_what_does_not_fit_in_memory_goes_from_file_to_file_in_slabs():
    write_large("a.nrrd", 160)
    ok("convert", "a.nrrd", "-o", "packed.nrrd", "--encoding", "gzip", "--level", "1")
    work = ("packed.nrrd", "--type", "f32", "--range", "0,255", "--x", "3:120", "--flip", "z", "--order", "zxy",
            "--spacing", "1.5")
    whole = ok("convert", *work, "-o", "whole.nrrd", "--json").json
    slabs = ok("convert", *work, "-o", "slabs.nrrd", "--memory", "20M", "--json").json
    assert slabs["streamed"] and not whole["streamed"] and slabs["peak_bytes"] <= 20 << 20
    with open("whole.nrrd", "rb") as a, open("slabs.nrrd", "rb") as b:
        assert a.read() == b.read()
    one = ok("info", "packed.nrrd", "--stats", "--json").json
    assert ok("info", "packed.nrrd", "--stats", "--json", "--memory", "9M").json == one


def test_a_pipe_larger_than_memory_can_be_gone_through_more_than_once():
    write_large("a.nrrd", 160)
    with open("a.nrrd", "rb") as file:
        plain = file.read()
    little = ("--memory", "7M")
    inputs = list(itertools.product((plain, gzip.compress(plain, 1)), ((), ("--safe",))))
    for work in ((), ("--type", "f32", "--range", "0,255"), ("--percentile", "1,99"), ("--order", "zyx")):
        ok("convert", "a.nrrd", *work, "-o", "whole.nrrd", "--overwrite")
        for stdin, way in inputs:
            result = ok("convert", "-", *work, *little, *way, "-o", "slabs.nrrd", "--overwrite", "--json", stdin=stdin)
            assert result.json["streamed"]
            assert samples("whole.nrrd") == samples("slabs.nrrd"), (work, way)
    one = ok("info", "a.nrrd", "--stats", "--json").json
    for stdin, way in inputs:
        said = ok("info", "-", "--stats", "--json", *little, *way, stdin=stdin).json
        assert all(said[key] == one[key] for key in ("min", "max", "mean"))
    nowhere = {"TMPDIR": "/nonexistent"}  # no temporary file for a header or for one pass
    ok("info", "-", *little, stdin=plain, env=nowhere)
    ok("convert", "-", "--type", "f32", "--range", "0,255", *little, "-o", "b.nrrd", stdin=plain, env=nowhere)
    says(fails(3, "convert", "-", "--order", "zyx", *little, "-o", "c.nrrd", stdin=plain, env=nowhere), "TMPDIR")
    limit = ("--limit", "import_spool=1000000")
    says(fails(3, "convert", "-", "--order", "zyx", *little, *limit, "-o", "c.nrrd", stdin=plain), "import_spool")


def packed_volumes(n):
    """The same n^3 bytes in every kind of packing."""
    samples = (bytes((i * 7 + i // 5) % 251 for i in range(5 * 251)) * (n**3 // 1255 + 1))[: n**3]
    nrrd = f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {n} {n} {n}\nencoding: %s\n\n"
    packed = zlib.compress(samples, 1)
    mha = (f"ObjectType = Image\nNDims = 3\nDimSize = {n} {n} {n}\nElementType = MET_UCHAR\nCompressedData = True\n"
           f"CompressedDataSize = {len(packed)}\nElementDataFile = LOCAL\n")
    yield "a.nrrd", (nrrd % "gzip").encode(), gzip.compress(samples, 1), samples
    yield "b.nrrd", (nrrd % "bzip2").encode(), bz2.compress(samples, 1), samples
    yield "c.mha", mha.encode(), packed, samples
    yield "d.nrrd.gz", b"", gzip.compress((nrrd % "raw").encode() + samples, 1), samples
    yield "e.nrrd.bz2", b"", bz2.compress((nrrd % "raw").encode() + samples, 1), samples


def test_packed_data_that_are_cut_short_give_what_is_there_whole_or_in_slabs():
    n = 120
    for name, header, packed, samples in packed_volumes(n):
        with open(name, "wb") as file:
            file.write(header + packed[: len(packed) * 7 // 10])
        seen = set()
        for memory in ((), ("--memory", "3M"), ("--memory", "3M", "--safe"), ("--memory", "3M", "--flip", "x")):
            result = volvis("convert", name, *memory, "-o", "out.nrrd", "--overwrite")
            assert result.code == 7, (name, memory, result.message)
            assert result.message.count("\n") == 1, result.message
            found = re.search(r"(\d+) of (\d+) numbers are there, the rest is 0", result.message)
            assert found and int(found[2]) == n**3, result.message
            seen.add(int(found[1]))
            if "--flip" in memory:
                continue
            with open("out.nrrd", "rb") as file:
                got = file.read()[-(n**3) :]
            there = int(found[1])
            assert got[:there] == samples[:there] and not any(got[there:]), (name, memory)
        assert len(seen) == 1 and n**3 / 2 <= min(seen) < n**3 * 0.8, (name, seen)
        with open(name, "wb") as file:
            file.write(header + packed[: len(packed) * 2 // 10])
        for memory in ((), ("--memory", "3M")):
            said = fails(3, "convert", name, *memory, "-o", "less.nrrd")
            assert "less than half" in said or "the file is cut short" in said, said
            assert not os.path.exists("less.nrrd")
        assert volvis("info", name).code == volvis("info", name, "--stats").code == 3, name
        with open(name, "wb") as file:
            file.write(header + packed[:-2])
        result = volvis("convert", name, "-o", "out.nrrd", "--overwrite")
        assert result.code == 7 and "checksum" in result.message, (name, result.message)


def test_a_hostile_input_is_bad_input_not_a_lack_of_memory():
    cases = {
        "dims.nrrd": b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1048576 1048576 1048576\nencoding: raw\n\n",
        "axis.nrrd": b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 0 4 4\nencoding: raw\n\n",
        "line.nrrd": b"NRRD0004\n# " + b"x" * (1 << 21) + b"\n",
        "deep.vv.json": b'{"a":' * 1000,
    }
    for name, content in cases.items():
        with open(name, "wb") as file:
            file.write(content)
        fails(3, "info", name)
        fails(3, "render", name, "-o", "a.png")


def test_compare_turns_axes_that_run_along_the_same_lines():
    write_nrrd("a.nrrd", (5, 6, 7), lambda x, y, z: x + 5 * y + 30 * z, spacing=(1, 1.5, 2))
    for i, to in enumerate(("zyx", "-x,y,z", "LPI", "z,-x,y")):
        ok("reorient", "a.nrrd", "-o", f"turned{i}.nrrd", "--to", to)
        answer = ok("compare", "a.nrrd", f"turned{i}.nrrd", "--max-difference", "0", "--json").json
        assert answer["identical"] and not answer["differs"] and not answer["same_axes"], (to, answer)
        assert answer["same_dims"] and answer["placement_difference"] < 1e-9 and answer["reoriented"], (to, answer)
    ok("flip", "a.nrrd", "-o", "flipped.nrrd", "--axes", "x")
    answer = ok("compare", "a.nrrd", "flipped.nrrd", "--json").json
    assert answer["differs"] != answer["identical"], answer


def test_compare_ends_with_six_where_a_limit_is_not_kept():
    write_ball("a.nrrd")
    ok("gaussian", "a.nrrd", "-o", "b.nrrd", "--sigma", "1vox")
    assert volvis("compare", "a.nrrd", "b.nrrd", "--max-difference", "0").code == 6
    assert volvis("compare", "a.nrrd", "b.nrrd", "--psnr", "90").code == 6
    answer = volvis("compare", "a.nrrd", "b.nrrd", "--psnr", "90", "--json")
    assert answer.code == 6 and answer.json["differs"] and answer.json["psnr"] < 90
    ok("compare", "a.nrrd", "b.nrrd", "--psnr", "10")
    ok("crop", "a.nrrd", "-o", "c.nrrd", "--x", "0:8")
    assert volvis("compare", "a.nrrd", "c.nrrd").code == 6


def test_compare_says_where_decibels_have_no_meaning():
    def save(name, *values):
        with open(name, "wb") as file:
            head = f"NRRD0004\ntype: float\ndimension: 3\nsizes: {len(values)} 1 1\nendian: little\nencoding: raw\n\n"
            file.write(head.encode() + struct.pack(f"<{len(values)}f", *values))

    nan, inf = float("nan"), float("inf")
    save("a.nrrd", 1, 2, 3), save("nan.nrrd", 1, 2, nan), save("inf.nrrd", 1, 2, inf)
    save("two.nrrd", 2, 2, 2), save("three.nrrd", 3, 3, 3)
    for a, b, why in (("a", "nan", "finite number"), ("nan", "a", "finite number"), ("inf", "a", "finite number"),
                      ("two", "three", "all values of A are the same")):
        answer = ok("compare", f"{a}.nrrd", f"{b}.nrrd")
        assert "not defined" in answer.text and why in answer.text and "nothing differs" not in answer.text, answer.text
        found = ok("compare", f"{a}.nrrd", f"{b}.nrrd", "--json").json
        assert found["psnr"] is None and not found["identical"] and found["differs"]
        limited = volvis("compare", f"{a}.nrrd", f"{b}.nrrd", "--psnr", "10")
        assert limited.code == 6 and "PSNR is not defined" in limited.text, limited.text
    for same in ("nan", "inf", "two"):
        answer = ok("compare", f"{same}.nrrd", f"{same}.nrrd")
        assert "infinite: nothing differs" in answer.text
        assert ok("compare", f"{same}.nrrd", f"{same}.nrrd", "--json").json["identical"]


def test_two_words_are_input_and_output():
    write_ball()
    for verb in (["convert"], ["gaussian", "--sigma", "1vox"], ["crop", "--x", "1..9"]):
        ok(verb[0], "head.nrrd", "out.nrrd", *verb[1:])
        ok(verb[0], "head.nrrd", "-o", "same.nrrd", *verb[1:], "--overwrite")
        assert ok("compare", "out.nrrd", "same.nrrd", "--json").json["identical"]
        says(fails(2, verb[0], "head.nrrd", "out.nrrd", *verb[1:]), "out.nrrd", "already exists", "--overwrite")
        ok(verb[0], "head.nrrd", "out.nrrd", *verb[1:], "--overwrite")
        os.remove("out.nrrd")
    fails(2, "render", "head.nrrd", "a.png")


def test_many_inputs_have_an_output_each():
    os.mkdir("d")
    write_ball("a.nrrd")
    write_ball("d/b.nrrd", n=16)
    ok("convert", "a.nrrd", "-o", "c.x.nii.gz")
    ok("convert", "a.nrrd", "d/b.nrrd", "-o", "{stem}.npy")
    ok("gaussian", "a.nrrd", "d/b.nrrd", "c.x.nii.gz", "--sigma", "1vox", "-o", "d/{stem}_soft.nrrd")
    answers = ok("render", "a.nrrd", "d/b.nrrd", "-o", "{stem}.png", "--size", "16", "--json").json
    assert [a["output"] for a in answers] == ["a.png", "b.png"]
    ok("isosurface", "a.nrrd", "d/b.nrrd", "-o", "{stem}.stl")
    ok("info", "a.nrrd", "d/b.nrrd", "-o", "{stem}.txt")
    with open("a.txt", encoding="utf-8") as a, open("b.txt", encoding="utf-8") as b:
        assert a.read().startswith("a.nrrd\n") and b.read().startswith("d/b.nrrd\n")
    ok("isosurface", "a.nrrd", "out.stl")
    says(fails(2, "isosurface", "a.nrrd", "out.stl"), "out.stl", "already exists; to replace it, give --overwrite or name it with -o")
    ok("isosurface", "a.nrrd", "a.nrrd", "out.stl", "--overwrite")  # the second one gives values
    for name in ("a.stl", "b.stl", "a.npy", "b.npy", "d/a_soft.nrrd", "d/b_soft.nrrd", "d/c.x_soft.nrrd", "a.png", "b.png"):
        assert os.path.exists(name), name
    write_ball("b.nrrd")
    says(fails(2, "convert", "b.nrrd", "d/b.nrrd", "-o", "{stem}.mha"), "'b.mha' for both", "'d/b.nrrd'")
    fails(3, "convert", "absent.nrrd", "a.nrrd", "-o", "{stem}.mha")
    for words in (("measure", "volume", "b.nrrd"), ("compare", "b.nrrd", "d/b.nrrd")):
        says(fails(2, *words, "-o", "{stem}.json"), "{stem}.json", words[0], "makes one result of all its inputs")
    assert os.path.exists("a.mha")  # the others go on


def test_a_picture_is_not_compared_with_a_volume():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", "--size", "16x16")
    says(fails(2, "compare", "a.png", "head.nrrd"), "a.png", "picture", "'head.nrrd'")
    says(fails(2, "compare", "head.nrrd", "a.png"), "a.png", "picture")
    ok("compare", "a.png", "a.png")


def test_a_folder_of_several_data_sets_asks_which():
    os.mkdir("f")
    write_ball("f/head.nrrd")
    ok("render", "f/head.nrrd", "-o", "f/a.png", "--size", "16x16")
    assert ok("info", "f", "--json").json["dims"] == [32, 32, 32]
    write_ball("f/other.nrrd")
    says(fails(3, "render", "f", "-o", "b.png"), "f: ", "'head.nrrd', 'other.nrrd'", "name one")
    os.remove("f/other.nrrd")
    os.remove("f/head.nrrd")
    fails(3, "info", "f")  # a picture that VolVis made is nobody's slice
    for i in range(3):
        with open(f"f/s{i}.png", "wb") as file:
            file.write(grey_png(7, 5, i))
    assert ok("info", "f", "--json").json["dims"] == [7, 5, 3]
    write_ball("f/head.nrrd")
    says(fails(3, "render", "f", "-o", "b.png"), "'head.nrrd', 'slices' (3 pictures)", "name one")
    assert ok("info", "f:slices", "--json").json["dims"] == [7, 5, 3]


def grey_png(width, height, value):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    rows = (b"\0" + bytes([value]) * width) * height
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def test_threads_do_not_change_a_result():
    write_ball()
    for n in (1, 2, 3):
        ok("gaussian", "head.nrrd", "-o", f"{n}.nrrd", "--sigma", "2vox", "--threads", n)
    contents = []
    for n in (1, 2, 3):
        with open(f"{n}.nrrd", "rb") as file:
            contents.append(file.read())
    assert contents[0] == contents[1] == contents[2]


def test_time_steps_are_chosen_or_all_kept():
    header = ("NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 4 4 3\nkinds: domain domain domain time\n"
              "encoding: raw\n\n")
    with open("film.nrrd", "wb") as file:
        file.write(header.encode() + bytes(t * 10 for t in range(3) for _ in range(64)))
    assert ok("info", "film.nrrd", "--json").json["frames"] == 3
    assert ok("info", "film.nrrd@2", "--stats", "--json").json["max"] == 20
    assert ok("info", "film.nrrd", "--frame", "1", "--stats", "--json").json["max"] == 10
    assert ok("convert", "film.nrrd", "-o", "all.nrrd", "--json").json["frames"] == 3
    assert ok("convert", "film.nrrd@1", "-o", "one.nrrd", "--json").json["frames"] == 1
    assert ok("info", "all.nrrd@2", "--stats", "--json").json["max"] == 20
    says(fails(2, "info", "film.nrrd@3"), "3", "numbered from 0")


def test_labels_keep_their_numbers():
    with open("a.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\nvolvis meaning:=label\n\n")
        file.write(bytes(range(64)))
    ok("convert", "a.nrrd", "-o", "b.nrrd", "--type", "u16")
    assert ok("info", "b.nrrd", "--json").json["meaning"] == "label"
    assert ok("compare", "a.nrrd", "b.nrrd", "--json").json["identical"]
    fails(1, "rescale", "a.nrrd", "-o", "c.nrrd", "--type", "u16")


def test_progress_for_programs_is_one_json_object_a_line():
    write_large("a.nrrd", 160)
    result = ok("components", "a.nrrd", "-o", "b.nrrd", "--range", "50..", "--progress", "json")
    reports = [json.loads(line) for line in result.message.splitlines() if line.startswith("{")]
    assert reports and all({"stage", "done", "total", "elapsed_s", "eta_s"} <= set(r) for r in reports)
    ends = [r for r, after in zip(reports, reports[1:] + [None]) if not after or after["stage"] != r["stage"]]
    assert len(ends) > 1 and all(r["done"] == r["total"] for r in ends), ends
    for r, after in zip(reports, reports[1:]):
        assert after["stage"] != r["stage"] or after["done"] == after["total"] or after["elapsed_s"] >= r["elapsed_s"] + 0.249, (r, after)
    assert ok("gaussian", "a.nrrd", "-o", "b.nrrd", "--progress", "none").message == ""


def test_no_zero_of_a_text_header_has_a_sign():
    write_ball("head.nrrd", 8)
    for flip in ("x", "y", "z", "xyz"):
        for name in ("out.nrrd", "out.mha", "out.vti"):
            ok("convert", "head.nrrd", "--flip", flip, "-o", name)
            with open(name, "rb") as file:
                header = file.read(600)
            for ending in b" ,)\n\"":
                assert b"-0" + bytes([ending]) not in header and b"-0.0" + bytes([ending]) not in header, header
            os.remove(name)


def test_the_order_of_an_arrays_axes_is_given_by_its_letters():
    with open("v.npy", "wb") as file:  # 3 x 4 x 5 x 2 bytes
        head = b"{'descr': '|u1', 'fortran_order': False, 'shape': (3, 4, 5, 2), }"
        file.write(b"\x93NUMPY\x01\x00" + struct.pack("<H", 118) + head.ljust(117) + b"\n" + bytes(120))
    for words in (("v.npy", "--axes", "czyx"), ("v.npy", "--part", "czyx"), ("v.npy:czyx",)):
        said = ok("info", *words, "--json").json
        assert said["dims"] == [2, 5, 4] and said["components"] == 3, said
    says(fails(2, "info", "v.npy", "--axes", "cxx"), "no part 'cxx'", "a letter of t, z, y, x, c")
    ok("flip", "v.npy", "-o", "f.npy", "--axes", "x")  # its own


main()
