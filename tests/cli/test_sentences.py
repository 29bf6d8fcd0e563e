"""Sentences of refusals: what was typed or found, what was expected, and what to do about it."""
import bz2
import errno
import gzip
import json
import os
import shutil
import subprocess
import zipfile
from harness import VOLVIS, Skip, environment, fails, main, ok, sanitized, says, volvis, write_ball, write_blocks, write_box, write_cells, write_nrrd


def refused(words, *parts, code=2):
    """No sentence speaks of what only programmers know."""
    said = fails(code, *words)
    says(said, *parts)
    for inner in ("JSON", "array", "`", "(null)", "VV_", "from:"):
        assert inner not in said, said
    return said


def convert(*words):
    return ["convert", "head.nrrd", "-o", "out.nrrd", *words]


def test_windows_of_values_are_refused_in_the_words_that_were_typed():
    write_ball()
    for typed in ("5", "a,b", "1,2,3", "nan,1", "1e400,2", "1mm,2mm", "5,", ",5", "1:2", "--"):
        refused(convert("--range", typed), "--range: expected two numbers LO..HI", f"found '{typed}'")
        refused(convert("--percentile", typed), "--percentile: expected two numbers LO..HI", f"found '{typed}'")
    refused(convert("--range", "3,3"), "--range: LO and HI of '3,3' are the same")
    for typed in ("99,3", "3,3", "-5,50", "1,150"):
        refused(convert("--percentile", typed), "between 0 and 100", f"'{typed}'")
    ok(*convert("--range", "9,3", "--type", "u8"))


def test_points_are_refused_in_the_words_that_were_typed():
    write_ball()
    for option, typed in (("--eye", "1,2"), ("--at", "1,2,3,4"), ("--up", "y"), ("--cross-hair", "5")):
        more = ["--slice", "axial"] if option == "--cross-hair" else []
        refused(["render", "head.nrrd", "-o", "a.png", option, typed, *more], f"{option}: expected three numbers X,Y,Z, found '{typed}'")
    ok("render", "head.nrrd", "-o", "a.png", "--size", "8", "--eye", "1mm,-9cm,2", "--up", "0,0,1")


def test_lengths_that_are_none_are_refused_by_all_verbs():
    with open("far.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspacings: 1e308 1 1\nencoding: raw\n\n" + bytes(8))
    for words in (("info", "far.nrrd"), ("convert", "far.nrrd", "-o", "a.mha"), ("render", "far.nrrd", "-o", "a.png")):
        says(fails(3, *words), "far.nrrd", "long along x", "1e+308")


def test_an_empty_value_is_refused_and_not_taken_for_the_default():
    write_ball()
    for option in ("--range", "--percentile", "--type", "--x", "--flip", "--order", "--spacing", "--channel", "--encoding",
                   "--level", "--output", "--output-format", "--input-format", "--part", "--raw", "--frame", "--memory",
                   "--threads", "--progress"):
        refused(convert(option, ""), f"{option}: needs a value, found an empty one")
    refused(["info", ""], "the name of the input is empty")
    refused(["render", "", "-o", "a.png"], "the name of the input is empty")


def test_numbers_of_operations_are_asked_for_in_their_own_form():
    write_ball()
    resample = ["resample", "head.nrrd", "-o", "out.nrrd"]
    for typed in ("5", "a,b,c", "10x10x10", "10mm,1,1", "nan,1,1"):
        refused([*resample, "--size", typed], "--size: expected", "as in 1,2,3", typed)
    for typed in ("5:5", "9:3", "-5:10", "3:100"):
        refused(["crop", "head.nrrd", "-o", "out.nrrd", "--y", typed], f"'{typed}'", "0 to 31")
    refused(convert("--spacing", "1furlong"), "'furlong'", "mm")
    refused([*resample, "--spacing", "1e-30"], "give a larger spacing", code=4)


def test_types_and_encodings_are_listed_when_none_is_near():
    write_ball()
    refused(convert("--type", "f33"), "did you mean 'f32'?")
    refused(convert("--type", "tiny"), "u8, i8")
    refused(convert("--encoding", "lzw"), "nrrd", "'lzw'", "raw, ascii, hex, gzip, bzip2 and zstd")
    refused(convert("--encoding", "gzp"), "did you mean 'gzip'?")


def test_formats_go_by_their_suffixes_too():
    write_ball()
    for name, made in (("nii", "nifti"), ("h5", "hdf5"), ("tif", "tiff"), ("mha", "metaimage"), (".mrc", "mrc"), ("NRRD", "nrrd")):
        file = f"out-{made}"
        done = volvis("convert", "head.nrrd", "-o", file, "--output-format", name)
        if "there is no format" in done.message:
            continue  # this build lacks a library
        assert done.code == 0, done.message
        assert ok("info", file, "--json").json["format"] == made
    refused(convert("--output-format", "png"), "picture format", "volvis render")
    refused(["convert", "head.nrrd", "-o", "out.png"], "suffix of a picture", "volvis render")
    says(fails(5, *convert("--output-format", "vtk")), "can only be read", "volvis formats")


def test_outputs_without_o_are_told_from_inputs():
    write_ball("a.nrrd", 8)
    write_ball("b.nrrd", 8)
    ok("isosurface", "a.nrrd", "new.ply")
    write("old.ply", b"ply\n")
    write("old.png", b"")
    says(fails(2, "isosurface", "a.nrrd", "old.ply"), "old.ply", "already exists", "--overwrite or name it with -o")
    says(fails(2, "render", "a.nrrd", "old.png"), "old.png is taken for an input")
    assert "b.nrrd" not in fails(2, "render", "a.nrrd", "b.nrrd")
    for words in (("b.nrrd",), ("b.nrrd", "new.nrrd")):
        said = volvis("gaussian", "a.nrrd", *words, "new.nrrd").message
        says(said, "'b.nrrd' follows", "{stem}")
        assert "-o b.nrrd" not in said, "it would replace an input"


def test_words_that_stand_where_an_option_was_meant():
    write_ball()
    refused(["convert", "head.nrrd", "a.nrrd", "b.nrrd"], "did you mean -o a.nrrd?")
    refused(["info", "head.nrrd", "--preview", "auto"], "did you mean --preview=auto?")
    refused(["info", "head.nrrd@a"], "'a' is not a time step", "head.nrrd@0")
    says(fails(3, "info", "https://example.org/head.nrrd"), "is an address, not a file", "download")


def test_layouts_are_refused_by_the_names_of_their_axes():
    write_ball()
    for layout, part in (("0x7x11,u8", "0 samples along x"), ("7x0x11,u8", "0 samples along y"), ("7x11x0,u8", "0 samples along z"),
                         ("7x11x13x0,u8", "0 time steps"), ("7x11x13", "no type"), ("7x11", "does not begin with"),
                         ("a,b", "does not begin with"), ("7x11x13,q9", "'q9'"), ("7x11x13,u8,bog", "'bog'")):
        refused(["info", "head.nrrd", "--raw", layout], part, "write it as 256x256x128,u8")
    says(fails(3, "info", "head.nrrd", "--raw", "99999999999x1x1,u8"), "samples along x", "--limit dim=N")


def write(name, data):
    with open(name, "wb") as file:
        file.write(data)


def test_files_that_are_no_volumes_are_called_what_they_are():
    with zipfile.ZipFile("a.zip", "w") as archive:
        archive.writestr("head.nrrd", b"x")
    with zipfile.ZipFile("a.docx", "w") as archive:
        archive.writestr("[Content_Types].xml", b"<x/>")
    kinds = {
        "a.zip": "a ZIP archive: unpack it", "a.docx": "an Office document", "a.pdf": "a PDF document", "a.mp4": "a film",
        "a.html": "a web page", "a.txt": "a text", "a.nrrd": "a pointer of Git LFS", "a.xz": "xz -d",
        "a.mat": "-v7.3", "a.fits": "a FITS file", "a.json": "scene's name ends in .vv.json", "empty": "is empty", "text.gz": "a text",
    }
    write("a.pdf", b"%PDF-1.4\n")
    write("a.mp4", b"\0\0\0\x18ftypmp42" + bytes(64))
    write("a.html", b"\n <!DOCTYPE HTML>\n<html></html>")
    write("a.txt", "größer\n".encode())
    write("a.nrrd", b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 5\n")
    write("a.xz", b"\xfd7zXZ\0" + bytes(64))
    write("a.stl", b"solid cube\n")
    write("a.mat", b"MATLAB 5.0 MAT-file, Platform" + bytes(200))
    write("a.fits", b"SIMPLE  =                    T" + b" " * 100)
    write("a.json", b'{"a": 1}')
    write("empty", b"")
    write("text.gz", gzip.compress(b"some words\n"))
    for name, kind in kinds.items():
        said = fails(3, "info", name)
        says(said, name, kind)
        assert len(said) < 200, said
    says(fails(3, "isosurface", "a.stl", "-o", "a.ply"), "a mesh")
    os.mkdir("nothing")
    says(fails(3, "info", "nothing"), "a folder without files")
    write("binary", bytes(range(256)) * 4)
    says(fails(3, "info", "binary"), "of no known format", "volvis formats", "--raw 256x256x128,u8")


def test_the_other_file_of_a_pair_is_named_with_the_real_reason():
    write_ball()
    ok("convert", "head.nrrd", "-o", "pair.hdr")
    os.mkdir("here")
    os.rename("pair.hdr", "here/pair.hdr")
    says(fails(3, "info", "here/pair.hdr"), "'pair.img', with or without .gz, is not beside it")
    os.symlink("../pair.img", "here/pair.img")
    says(fails(3, "info", "here/pair.hdr"), "'pair.img' is a link that leads out", "--allow-outside")
    ok("info", "here/pair.hdr", "--allow-outside")


def test_too_little_memory_is_said_in_amounts():
    write_ball()
    says(fails(4, "info", "head.nrrd", "--memory", "1k"), "of the limit of 1.0 KiB are in use", "--memory")


def test_channels_that_are_not_there_are_listed():
    write_cells()
    for typed in ("9", "-1", "a", "0,9", "0,"):
        refused(["convert", "cells.nrrd", "-o", "o.nrrd", "--channel", typed], "there is no channel", "0 to 1")


def nrrd(name, more=b"", n=4, encoding=b"raw", data=None):
    sizes = b"%d %d %d" % (n, n, n)
    write(name, b"NRRD0005\ntype: uint8\ndimension: 3\nsizes: " + sizes + b"\nencoding: " + encoding + b"\n" + more + b"\n"
          + (bytes(n**3) if data is None else data))


def limited(limit, *words, code=3):
    """Refused with the name of the limit and how to raise it."""
    name = limit.split("=")[0]
    says(fails(code, *words, "--limit", limit), f"--limit {name}=N")


def test_every_limit_of_a_reader_names_itself_and_how_it_is_raised():
    nrrd("a.nrrd")
    limited("dim=3", "info", "a.nrrd")
    limited("voxels=63", "info", "a.nrrd")
    nrrd("long.nrrd", b"".join(b"# %s\n" % (b"x" * 90) for _ in range(60)))
    limited("header_bytes=4096", "info", "long.nrrd")
    nrrd("word.nrrd", b"content: " + b"x" * 400 + b"\n")
    limited("string_bytes=256", "info", "word.nrrd")
    nrrd("keys.nrrd", b"a:=1\nb:=2\nc:=3\n")
    says(volvis("info", "keys.nrrd", "--limit", "metadata_keys=2").message, "'c'", "--limit metadata_keys=N")
    for z in range(4):
        write(f"s{z}.raw", bytes(16))
    for names in (b"LIST\ns0.raw\ns1.raw\ns2.raw\ns3.raw", b"s%d.raw 0 3 1"):
        write("list.nhdr", b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\ndata file: " + names + b"\n")
        limited("files=2", "info", "list.nhdr")
    os.mkdir("folder")
    for z in range(4):
        write(f"folder/s{z}.tif", b"II*\0")
    limited("files=2", "info", "folder")
    nrrd("packed.nrrd", n=128, encoding=b"gzip", data=gzip.compress(bytes(128**3)))
    limited("expansion_gzip=2", "info", "packed.nrrd")
    ok("info", "packed.nrrd", "--limit", "expansion_gzip=2000")
    nrrd("squeezed.nrrd", n=128, encoding=b"bzip2", data=bz2.compress(bytes(128**3)))
    says(fails(3, "info", "squeezed.nrrd", "--limit", "expansion_zstd=2", "--limit", "expansion_after=1M"), "--limit expansion_zstd=N")
    ok("info", "squeezed.nrrd", "--limit", "expansion_zstd=2")


def test_a_time_step_is_named_once():
    write_ball()
    refused(["info", "head.nrrd@0", "--frame", "1"], "head.nrrd", "@0 and --frame 1 name two time steps")
    ok("info", "head.nrrd@0", "--frame", "0")


def test_a_folder_that_cannot_be_written_is_refused_with_the_real_reason():
    write_ball()
    os.mkdir("locked", 0o555)
    mounted = os.geteuid() == 0
    if mounted and subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "tmpfs", "locked"], capture_output=True).returncode:
        raise Skip("needs a file system that can be mounted read-only, or a user who is not root")
    try:
        for name in ("x.nrrd", "x.zarr", "x.h5"):
            refused(["convert", "head.nrrd", "-o", "locked/" + name], "'locked' cannot be written to: " +
                    os.strerror(errno.EROFS if mounted else errno.EACCES), code=5)
    finally:
        if mounted:
            subprocess.run(["umount", "locked"], check=True)


def test_a_stream_that_cannot_be_written_has_a_sentence_but_for_a_reader_that_left():
    write_ball("head.nrrd", 64)
    words = [VOLVIS, "convert", "head.nrrd", "-o", "-", "--output-format", "nrrd"]
    with open("/dev/full", "wb") as full:
        done = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True, env=environment())
    assert done.returncode == 5
    says(done.stderr, os.strerror(errno.ENOSPC))
    end, begin = os.pipe()
    os.close(end)
    done = subprocess.run(words, stdout=begin, stderr=subprocess.PIPE, text=True, env=environment())
    os.close(begin)
    assert (done.returncode, done.stderr) == (141, "")


def test_fill_values_past_the_limits_are_refused():
    try:
        import h5py
    except ImportError:
        raise Skip("needs h5py")
    with h5py.File("empty.h5", "w") as file:
        file.create_dataset("v", (5000, 5000, 5000), "u1", chunks=(500, 500, 500), fillvalue=3)
    if "hdf5" not in [f["name"] for f in ok("formats", "--json").json["formats"]]:
        raise Skip("built without HDF5")
    refused(["info", "empty.h5", "--stats"], "125000000000 bytes", "--limit expansion_after=117G", code=3)
    ok("info", "empty.h5", "--limit", "expansion_after=117G")


def test_metadata_of_zarr_is_as_deep_as_the_limit_allows():
    write_ball()
    ok("convert", "head.nrrd", "-o", "a.zarr")
    for folder, _, names in os.walk("a.zarr"):
        for name in [n for n in names if n in ("zarr.json", ".zattrs")]:
            path = os.path.join(folder, name)
            with open(path) as file:
                meta = json.load(file)
            (meta["attributes"] if name == "zarr.json" else meta)["deep"] = json.loads("[" * 40 + "]" * 40)
            with open(path, "w") as file:
                json.dump(meta, file)
    refused(["info", "a.zarr"], "nested deeper than 32 levels; --limit nesting=N allows more", code=3)
    ok("info", "a.zarr", "--limit", "nesting=64")


def test_json_of_very_many_values_is_refused_before_it_is_parsed():
    """2 million empty objects are 6 MB of text and half a gigabyte of tree."""
    many = "[" + "{}," * 2_000_000 + "{}]"
    write_ball()
    ok("convert", "head.nrrd", "-o", "many.zarr")
    path = next(os.path.join(folder, name) for folder, _, names in os.walk("many.zarr") for name in names if name in ("zarr.json", ".zattrs"))
    with open(path) as file:
        meta = file.read()
    with open(path, "w") as file:
        file.write('{"many": ' + many + "," + meta[meta.index("{") + 1:])
    refused(["info", "many.zarr"], "so many values that they would take", "--limit header_bytes=N", code=3)
    with open("many.vv.json", "w") as file:
        file.write('{"schema": 1, "many": ' + many + "}")
    refused(["info", "many.vv.json"], "so many values that they would take", code=3)


def test_limits_of_the_import_program_name_themselves():
    if volvis("info", "absent", "--safe").message.find("import program") >= 0:
        raise Skip("this build has no import program")
    write_ball()
    if volvis("convert", "head.nrrd", "-o", "a.tif").code == 0:
        with open("a.tif", "rb") as file:
            write("a.tif.gz", gzip.compress(file.read()))
        limited("import_spool=0", "info", "a.tif.gz", "--safe")
        limited("import_spool=0", "info", "a.tif.gz")
        ok("info", "a.tif.gz", "--safe")
    if sanitized():
        raise Skip("limits of address space are not set in builds with sanitizers")
    nrrd("large.nrrd", n=512, encoding=b"gzip", data=gzip.compress(bytes(512**3), 1))
    limited("import_bytes=64M", "info", "large.nrrd", "--stats", "--safe", code=4)


def test_limits_of_every_text_format_name_themselves():
    write_nrrd("a.nrrd", (5, 4, 3), lambda x, y, z: x)
    for name in ("a.npy", "a.nii", "a.mha", "a.mrc", "a.vti", "a.tif", "a.vvh", "a.h5"):
        if volvis("convert", "a.nrrd", "-o", name).code == 0:
            limited("dim=4", "info", name)
            limited("voxels=59", "info", name)
    limited("dim=4", "info", "a.nrrd", "--raw", "5x4x3,u8")


def test_parts_of_meshes_are_not_said_to_be_no_volumes():
    write_box()
    said = fails(2, "render", "box.ply:body", "-o", "a.png")
    says(said, "box.ply", "has no part", "'body'")
    assert "'volvis render'" not in said


def test_a_picture_whose_data_moved_says_where_they_were():
    os.mkdir("old")
    write_ball("old/nut.nrrd")
    ok("render", "old/nut.nrrd", "-o", "old/a.png", "--size", "16")
    os.rename("old/nut.nrrd", "old/new.nrrd")
    said = fails(3, "render", "old/a.png", "-o", "b.png")
    says(said, "old/a.png", "nut.nrrd", "crc32:", "--set datasets.nut.path=FILE")
    ok("render", "old/a.png", "-o", "b.png", "--set", "datasets.nut.path=old/new.nrrd")


def test_what_there_is_is_listed_where_nothing_is_near():
    write_ball()
    says(fails(2, "render", "head.nrrd", "-o", "a.xyz"), ".png", ".jpg", ".tif", ".exr", ".svg")
    says(fails(2, "render", "head.nrrd", "-o", "a.png", "--method", "iso"), "raycast, surface, reduced, boxes and slice")
    says(fails(2, "render", "head.nrrd", "-o", "a.png", "--caption", "{foo}"), "file, title, dims", "version")
    says(ok("help", "render").text.replace("\n", " "), "cross-hair", "{elevation}")
    says(ok("presets", "bone").text, "Transfer functions: ", "bones in CT", "\n\nColour maps ", "X-ray")
    assert ok("presets", "grey").text.startswith("Colour maps") and "gray" in ok("presets", "grey").text
    says(fails(2, "presets", "bnoe"), "did you mean 'bone'?")
    says(fails(2, "render", "head.nrrd", "-o", "a.png", "--set", "volumes.head.segmentation.transfer.preset=hot"),
         "colour map", "colormap=hot")


def test_junk_with_the_suffix_of_nrrd_is_not_nrrd():
    with open("junk.nrrd", "wb") as file:
        file.write(bytes(i * 7 % 255 + 11 for i in range(20, 24)) * 200)
    says(fails(3, "info", "junk.nrrd"), "is not a NRRD file", "NRRD0001")
    os.rename("junk.nrrd", "junk.vti")
    says(fails(3, "info", "junk.vti"), "junk.vti:1: is not XML: ")


def test_what_is_to_blame_is_named():
    write_ball()
    says(fails(4, "render", "head.nrrd", "-o", "a.png", "--resume", "a.part", "--size", "32768", "--memory", "1G"), "make it smaller")
    says(fails(4, "info", "head.nrrd", "--memory", "10"), "bytes of memory, and the limit is 10 bytes")
    if os.path.exists("/dev/full"):
        done = subprocess.run([VOLVIS, "convert", "head.nrrd", "-o", "-", "--output-format", "nrrd"], env=environment(),
                              stdout=open("/dev/full", "wb"), stderr=subprocess.PIPE)
        assert done.returncode == 5 and b"old file" not in done.stderr, done.stderr


def test_verbose_tells_what_was_chosen():
    write_ball()
    said = ok("render", "head.nrrd", "-o", "a.png", "--size", "16", "-v").message
    says(said, "views.main.camera.eye = ", "volumes.head.segmentation.transfer.opacity = ",
         'views.main.render.method = "raycast"', 'views.main.render.raycast.mode = "composite"')
    said = ok("render", "head.nrrd", "-o", "a.png", "--overwrite", "--size", "16", "-v", "--slice", "axial").message
    says(said, "volumes.head.slices.window_lo = ", 'views.main.render.method = "slice"', 'slice.orientation = "axial"')


def test_verbose_names_the_colour_map_and_rounds_numbers():
    write_ball()
    def told(*words):
        lines = ok("render", "head.nrrd", "-o", "a.png", "--overwrite", "--size", "16", "-v", *words).message.splitlines()
        assert max(len(number) for line in lines if " = [" in line for number in line.split(" = ")[1].split()) < 20, lines
        return next(line.split("transfer.color")[1] for line in lines if "transfer.color" in line)
    assert told("--tf", "fitted").startswith(": tissue, from ")
    assert told("--mode", "mip").startswith(": gray, from ")
    assert told("--tf", "hot") == 'map = "hot"'
    assert told("--tf", "10:0#ff0000 200:1#ffffff") == " = [[10, 1, 0, 0], [200, 1, 1, 1]]"


def test_rescale_says_what_its_type_cannot_hold():
    write_nrrd("r.nrrd", (8, 8, 8), lambda x, y, z: 2 * x + 3 * y + 10 * z)  # 0 to 105
    words = ("rescale", "r.nrrd", "-o", "a.nrrd", "--overwrite")
    says(fails(2, *words, "--no-clamp", "--from", "50,100", "--to", "0,255"), "-255", "u8 holds 0 to 255", "clamp")
    says(fails(2, *words, "--to", "0,300"), "0,300", "more than u8 holds", "0 to 255")
    says(fails(2, *words, "--to", "0,300", "--dry-run"), "more than u8 holds")
    assert not os.path.exists("a.nrrd")
    ok(*words, "--no-clamp", "--from", "0,50", "--to", "0,100")
    ok(*words, "--no-clamp", "--from", "50,100", "--to", "0,255", "--type", "i16")
    ok(*words, "--from", "50,100", "--to", "0,255")


def test_one_word_for_borders_that_stay():
    write_ball()
    ok("isosurface", "head.nrrd", "-o", "a.ply", "--iso", "100")
    ok("simplify", "a.ply", "-o", "b.ply", "--share", "30%", "--fix-border")
    said = ok("simplify", "a.ply", "-o", "c.ply", "--share", "30%", "--lock-border").message
    says(said, "lock_border is called fix_border now")
    assert open("b.ply", "rb").read() == open("c.ply", "rb").read()
    for verb in "simplify", "smooth":
        says(ok("help", verb).text, "--fix-border")
    for words in (("help", "simplify"), ("man", "simplify"), ("completions", "bash"), ("completions", "fish"), ("completions", "zsh"), ("reference",)):
        assert "lock" + "-border" not in ok(*words).text and "lock" + "_border" not in ok(*words).text, words


def test_labels_stay_whole_numbers_and_lost_windows_are_told():
    write_ball()
    write_blocks()
    ok("convert", "blocks.nrrd", "-o", "head.seg.nrrd")
    for verb in ("convert",), ("rescale",):
        says(fails(2, *verb, "head.seg.nrrd", "--type", "f32", "-o", "a.nrrd"), "f32", "whole numbers", "u16")
    ok("convert", "head.seg.nrrd", "--type", "u16", "-o", "a.nrrd")  # 27000 at most
    with open("head.nrrd", "rb") as file:
        header, samples = file.read().split(b"\n\n", 1)
    with open("window.nrrd", "wb") as file:
        file.write(header + b"\nvolvis channel 0 window:=10 90\n\n" + samples)
    assert ok("info", "window.nrrd", "--json").json["channels"][0]["window"] == [10, 90]
    says(ok("convert", "window.nrrd", "-o", "a.mrc").message, "a.mrc", "cannot keep the range of values to be shown")


def test_axes_are_put_in_order_by_one_word():
    write_ball()
    for word in "--order", "--to":
        ok("reorient", "head.nrrd", word, "zyx", "-o", f"{word}.nrrd")
        ok("convert", "head.nrrd", "--order", "zyx", "-o", "c.nrrd", "--overwrite")
        assert ok("compare", "c.nrrd", f"./{word}.nrrd", "--json").json["identical"]
    assert "--to" not in ok("help", "reorient").text


def test_progress_for_programs_ends():
    write_ball()
    lines = ok("gaussian", "head.nrrd", "-o", "a.nrrd", "--sigma", "2vox", "--progress", "json").message.splitlines()
    last = json.loads(lines[-1])
    assert last["done"] == last["total"], last


def test_a_copied_tree_finds_its_import_program():
    os.makedirs("tree/bin")
    os.makedirs("tree/libexec/volvis")
    beside = os.path.join(os.path.dirname(VOLVIS), "volvis-import")
    shutil.copy(VOLVIS, "tree/bin/volvis")
    shutil.copy(beside, "tree/libexec/volvis/volvis-import")
    write_ball()
    done = subprocess.run(["tree/bin/volvis", "info", "head.nrrd", "--safe"], env=environment(), capture_output=True)
    assert done.returncode == 0, done.stderr


main()
