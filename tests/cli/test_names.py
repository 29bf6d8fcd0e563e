"""Channels and labels by name: in the scene of a data file, in what is picked, and through conversions."""
import json
import os
from harness import fails, main, ok, says, volvis, write_ball, write_cells, write_labels, write_named_cells


def scene_of(path):
    ok("render", path, "-o", "a.png", "--size", "16x16", "--save-scene", "a.vv.json")
    with open("a.vv.json", encoding="utf-8") as file:
        return json.load(file)


def test_names_do_nothing_to_a_terminal():
    for name in "a\x9b31m.nrrd", "\u202edrrn.nrrd", "\u2066a.nrrd", "n\nl.nrrd":
        write_cells(name)
        for words in (["info", name], ["convert", name, "-o", name + ".nrrd", "--dry-run"], ["convert", name, "-o", name + ".nrrd"],
                      ["render", name, "-o", "a.png", "--dry-run"],
                      ["info", name + "x"]):
            done = volvis(*words)
            said = done.text + done.message
            assert name not in said and "?" in said, said
            assert all(c == "\n" or c.isprintable() for c in said), ascii(said)


def test_names_of_files_may_be_any_bytes():
    small = ("--size", "24x24")
    odd, folder = "h\udce9ad.nrrd", "d\udcff"  # the bytes e9 and ff
    write_cells(odd)
    os.makedirs(folder)
    os.link(odd, f"{folder}/in.nrrd")
    for path in odd, f"{folder}/in.nrrd":
        ok("render", path, "-o", "a.pfm", *small)
        ok("render", path, "-o", f"{folder}/\udce9.png", "--title", "{file}", "--save-scene", f"{folder}/s.vv.json",
           "--overwrite", *small)
        for scene in f"{folder}/\udce9.png", f"{folder}/s.vv.json":  # with a path that is relative to it
            ok("render", scene, "-o", "b.pfm", "--set", "views.main.decorations.title=null", *small)
            ok("compare", "a.pfm", "b.pfm", "--max-difference", "0")
        ok("pick", f"{folder}/\udce9.png", "--pixel", "12,12")
    ok("convert", odd, "-o", "\udce9.npy")
    ok("isosurface", odd, "--channel", "0", "-o", "\udce9.stl")
    assert ok("info", "\udce9.stl", "--json").json["triangles"] > 0
    ok("render", "\udce9.stl", "-o", "c.png", *small)
    for done in volvis("info", odd), volvis("info", "no\udce9.nrrd"):
        said = done.text + done.message
        assert "?" in said and all(c == "\n" or c.isprintable() for c in said), ascii(said)


def test_names_are_masked_in_pictures_too():
    for name in "c\atl.nrrd", "h\udce9ad.nrrd":
        write_cells(name)
        ok("measure", "histogram", name, "--channel", "0", "-o", "t.svg", "--overwrite")
        with open("t.svg", encoding="utf-8") as file:
            says(file.read(), name[0] + "?" + name[2:])
        ok("render", name, "-o", "a.png", "--title", "{file}", "--size", "64x64", "--overwrite")
        ok("render", name, "-o", "b.png", "--title", name[0] + "?" + name[2:], "--size", "64x64", "--overwrite")
        ok("compare", "a.png", "b.png", "--max-difference", "0")


def test_channels_are_volumes_of_one_dataset_in_their_colours():
    write_named_cells()
    volumes = scene_of("cells.nrrd")["volumes"]
    assert list(volumes) == ["cells_0", "cells_1"]
    nuclei, membrane = volumes["cells_0"], volumes["cells_1"]
    assert nuclei["title"] == "nuclei" and membrane["title"] == "membrane" and membrane["component"] == 1
    transfer = nuclei["segmentation"]["transfer"]
    assert transfer["colormap"] == "#0000ff" and (transfer["range_lo"], transfer["range_hi"]) == (100, 900)
    assert membrane["segmentation"]["transfer"]["colormap"] == "#ff00ff"
    ok("render", "a.vv.json", "-o", "b.png", "--size", "16x16")
    ok("compare", "a.png", "b.png", "--max-difference", "0")


def test_each_channel_is_seen_in_its_own_colour():
    write_cells()
    ok("render", "cells.nrrd", "-o", "a.pfm", "--size", "32x32", "--no-shading")
    with open("a.pfm", "rb") as file:
        lines = file.read().split(b"\n", 3)
    import struct
    floats = struct.unpack("<%df" % (32 * 32 * 3), lines[3][: 32 * 32 * 12])
    r, g, b = (max(floats[i::3]) for i in range(3))
    assert g > 0.1 and r > 0.1 and abs(r - b) < 0.05


def test_one_value_is_the_surface_of_the_first_channel():
    write_named_cells()
    for words in (["--iso", "500"], ["--mode", "isosurface"]):
        says(ok("render", "cells.nrrd", "-o", "a.png", "--size", "16x16", *words).message, "cells_0", "nuclei")


def test_labels_have_the_names_and_colours_of_their_file():
    write_labels()
    labels = scene_of("organs.seg.nrrd")["volumes"]["organs"]["segmentation"]["labels"]
    assert {n["label"]: n["name"] for n in labels["names"]} == {7: "left kidney", 2: 'liver "lobe" \u00e9'}
    assert labels["table"][0][0] == 7 and labels["table"][0][1] == 1 and abs(labels["table"][0][2] - 0.214) < 0.001
    for path in ("organs.seg.nrrd", "a.vv.json", "a.png"):
        picked = ok("pick", path, "--view", "front", "--size", "64x64", "--pixel", "32,50", "--pixel", "32,14", "--json").json
        assert [p["label_name"] for p in picked["pixels"]] == ["left kidney", 'liver "lobe" \u00e9'], path
    says(ok("pick", "a.vv.json", "--view", "front", "--size", "64x64", "--pixel", "32,50").text, "7 left kidney")


def test_channels_are_picked_by_number_and_name():
    write_named_cells()
    for word, first in (("0", "nuclei"), ("membrane", "membrane"), ("Membrane,nuclei", "membrane"), ("1,0,1", "membrane")):
        ok("convert", "cells.nrrd", "-o", "b.nrrd", "--channel", word)
        info = ok("info", "b.nrrd", "--json").json
        assert info["components"] == len(word.split(",")) and info["channels"][0]["name"] == first
    whole = ok("info", "cells.nrrd", "--json", "--stats").json["channels"]
    ok("channel", "cells.nrrd", "-o", "b.nrrd", "--channel", "1")
    one = ok("info", "b.nrrd", "--json", "--stats").json["channels"][0]
    assert (one["mean"], one["max"]) == (whole[1]["mean"], whole[1]["max"])
    says(fails(2, "convert", "cells.nrrd", "-o", "b.nrrd", "--channel", "membrain"), "membrane")
    says(fails(2, "convert", "cells.nrrd", "-o", "b.nrrd", "--channel", "2"), "0 to 1")


def test_colours_and_vectors_have_names_of_channels_anyway():
    write_cells()
    samples = bytes(v for i in range(64) for v in (i, 100 + i, 200))
    for kind, names in ("RGB-color", ("red", "green", "blue")), ("3-vector", ("x", "y", "Z")):
        with open("c.nrrd", "wb") as file:
            file.write(f"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 4 4 4\nkinds: {kind} domain domain domain\n"
                       "encoding: raw\n\n".encode() + samples)
        for number, name in enumerate(names):
            for verb in "convert", "channel":
                ok(verb, "c.nrrd", "-o", "d.npy", "--channel", name, "--overwrite")
                with open("d.npy", "rb") as file:
                    assert file.read()[-64:] == samples[number::3], (verb, kind, name)
            told = [ok("measure", "statistics", "c.nrrd", "--channel", word, "--json").json for word in (name, number)]
            assert told[0] == told[1] and told[0]["min"] == min(samples[number::3])
        said = [fails(2, *verb, "--channel", "gren") for verb in
                (["convert", "c.nrrd", "-o", "e.npy"], ["channel", "c.nrrd", "-o", "e.npy"], ["measure", "statistics", "c.nrrd"])]
        assert said[0] == said[1] == said[2]
        says(said[0], "no channel 'gren'", "0 to 2")
    write_named_cells()
    first = ok("measure", "volume", "cells.nrrd", "--iso", "500", "--channel", "membrane", "--store", "named.vv.json:thick", "--json").json
    with open("named.vv.json", encoding="utf-8") as file:
        assert json.load(file)["measurements"]["thick"]["component"] == 1
    again = ok("measure", "named.vv.json", "--json").json["measurements"][0]
    assert again["volume"] == first["volume"] > 0 and not again["changed"]
    ok("isosurface", "cells.nrrd", "--channel", "membrane", "-o", "name.stl")
    ok("isosurface", "cells.nrrd", "--channel", "1", "-o", "number.stl")
    with open("name.stl", "rb") as a, open("number.stl", "rb") as b:
        assert a.read() == b.read()
    says(fails(2, "isosurface", "cells.nrrd", "--channel", "membrain", "-o", "e.stl"), "did you mean 'membrane'")


def test_names_survive_what_keeps_the_values():
    write_named_cells()
    ok("crop", "cells.nrrd", "-o", "b.nrrd", "--x", "2:9")
    assert ok("info", "b.nrrd", "--json").json["channels"][0] == {"name": "nuclei", "color": "#0000ff", "window": [100, 900]}
    ok("rescale", "cells.nrrd", "-o", "b.nrrd", "--type", "u8", "--from", "0,1000", "--to", "0,255")
    channel = ok("info", "b.nrrd", "--json").json["channels"][0]
    assert channel["name"] == "nuclei" and channel["window"] is None
    write_labels()
    ok("convert", "organs.seg.nrrd", "-o", "b.nii.gz", "--type", "i32")
    labels = ok("info", "b.nii.gz", "--json", "--stats").json
    assert labels["meaning"] == "label" and labels["volume_unit"] == "mm^3"
    named = {l["value"]: (l["name"], l["count"], l["volume"]) for l in labels["labels"]}
    assert named == {0: (None, 24**3 - 16**3, (24**3 - 16**3) / 8), 2: ('liver "lobe" \u00e9', 2048, 256.0),
                     7: ("left kidney", 2048, 256.0)}


def test_headers_name_no_file_that_they_cannot_name():
    write_ball("ball.nrrd", 9)
    for suffix in ("nhdr", "mhd", "vvh"):
        for name in ("a\nb", " a", "a\x1b"):
            says(fails(2, "convert", "ball.nrrd", "-o", f"{name}.{suffix}"), "choose another name")
            assert not os.path.exists(f"{name}.{suffix}")
        ok("convert", "ball.nrrd", "-o", f"a b's.{suffix}")
        ok("info", f"a b's.{suffix}", "--stats")
        os.remove("a b's.raw")
    ok("convert", "ball.nrrd", "-o", "a\nb.nrrd")  # one file, which nothing has to name


main()
