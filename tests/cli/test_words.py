"""Words of the command line: verbs, options, help, exit codes, JSON."""
import json
import os
import re
import struct
import subprocess
import zlib
from harness import (VOLVIS, environment, fails, main, ok, png_pixels, says, verbs, volvis, write_ball, write_box, write_cells,
                     write_labels)


def test_every_verb_of_the_list_has_help_with_usage_and_an_example():
    for verb in verbs():
        text = ok(verb["name"], "--help").text
        says(text, f"usage: volvis {verb['name']}", "Options of every verb", "--threads N", "Examples", "volvis ")
        assert ok("help", verb["name"]).text == text


def test_help_fits_the_terminal():
    for columns in (40, 72, 100):
        for verb in verbs():
            for line in ok("help", verb["name"], env={"COLUMNS": str(columns)}).text.splitlines():
                words = line.strip().split(" ")
                assert len(line) <= columns or len(words) == 1 or line.startswith("  ") or "usage:" in line, line


def test_help_names_all_inputs_of_operations_that_take_several():
    wide, reference = {"COLUMNS": "300"}, ok("reference").text
    several = [o for o in ok("operations", "--json").json["operations"] if o["max_inputs"] > 1]
    assert len(several) >= 8
    for operation in several:
        name, inputs = operation["name"], operation["inputs"]
        text, man = ok("help", name, env=wide).text, ok("man", name).text
        part, about = reference.split(f"### volvis {name}\n")[1].split("\n### ")[0], ok("operations", name, env=wide).text
        usage = text.split("usage: ")[1].splitlines()[0]
        for number, given in enumerate(inputs):
            word = f"{given['name']}=FILE" if number else "INPUT"
            says(usage, word if given["least"] else f"[{word}]")
            for shown in text.split("Inputs\n")[1], about, part:
                says(" ".join(shown.split()), word, given["doc"])
            says(man.replace("\\-", "-"), word, given["doc"])
    assert "Inputs" not in ok("help", "gaussian").text


def test_help_of_switches_that_are_on_says_what_is_taken_away():
    for verb, option in (("rescale", "clamp"), ("isosurface", "normals"), ("info", "defaults")):
        said = " ".join(ok("help", verb, env={"COLUMNS": "300"}).text.split())
        says(said, f"--no-{option} turn off: ")
        assert "default on" not in said
    says(fails(2, "info", "a.nrrd", env={"VOLVIS_DEFAULTS": defaults_of("--size 100")}), "--size", "render --size ...")


def defaults_of(line):
    with open("defaults", "w", encoding="ascii") as file:
        file.write(line + "\n")
    return os.path.abspath("defaults")


def test_help_without_a_word_lists_every_verb():
    text = ok("help").text
    for verb in verbs():
        says(text, f"  {verb['name']}")
    assert ok("--help").text == text == ok().text


def test_help_and_docs_write_ranges_as_lo_to_hi():
    rescale = ok("help", "rescale").text
    for option in ("from", "to", "percentile"):
        says(rescale, f"--{option} LO..HI ")
    says(ok("help", "resample").text, "--size N,N,...")
    says(ok("help", "isosurface").text, "--iso N,N,...")
    texts = ok("reference").text
    folder = os.path.join(os.path.dirname(__file__), "..", "..", "docs")
    for name in (n for n in os.listdir(folder) if n.endswith(".md")):
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            texts += file.read()
    old = re.compile(r"--(?:threshold|range|percentile|window|from|to) -?[0-9.]+,[0-9.]+|--[xyz] [0-9a-z.]*:|--clip [xyz]:[0-9a-z]+:")
    assert not old.findall(texts), old.findall(texts)


def test_help_knows_property_paths():
    says(ok("help", "lights.key.intensity").text, "lights.key.intensity", "default 1")
    says(ok("help", "volumes.head").text, "volumes.head.visible=true|false")
    says(ok("help", "lights").text, "lights.ID.color=COLOUR")
    says(ok("help", "views.main.render.raycast").text, "views.main.render.raycast.mode=")
    says(fails(2, "help", "lights.key.intensitty"), "did you mean 'intensity'?")


def test_version_is_an_option_too():
    says(ok("--version").text, "volvis ", "kernels", "libraries")
    answer = ok("version", "--json").json
    assert re.fullmatch(r"\d+\.\d+\.\d+", answer["version"])
    assert answer["isa"] in answer["isas"]


def test_misspelt_words_get_the_nearest_real_ones():
    write_ball()
    says(fails(2, "rendr", "head.nrrd"), "no verb or file 'rendr'", "did you mean 'render'?")
    says(fails(2, "help", "rendr"), "no verb or property 'rendr'", "did you mean 'render'?")
    says(fails(2, "isosurface", "head.nrrd", "-o", "a.ply", "--iso", "abc"), "--iso: expected a number, or several as in 1,2,3")
    says(fails(2, "channel", "head.nrrd", "-o", "a.nrrd", "--channel", "7"), "'7' is not the channel that there is, which is 0")
    says(fails(2, "convert", "head.nrrd", "-o", "a.xyz"), "FOLDER/")
    says(fails(2, "info", "head.nrrd", "--stat"), "did you mean --stats?")
    says(fails(2, "info", "head.nrrd", "--thread", "2"), "did you mean --threads?")
    says(fails(2, "info", "head.nrrd", "--progress", "brr"), "did you mean 'bar'?")
    says(fails(2, "formats", "nrd"), "did you mean 'nrrd'?")
    says(fails(2, "methods", "raycats"), "did you mean 'raycast'?")
    says(fails(2, "operations", "gausian"), "did you mean 'gaussian'?")
    says(fails(2, "completions", "bsh"), "did you mean 'bash'?", "bash, zsh and fish")
    says(fails(2, "info", "head.nrrd", "--input-format", "nrd"), "nrrd")
    says(fails(2, "convert", "head.nrrd", "-o", "a.nrd"), ".nrrd")
    says(fails(2, "convert", "head.nrrd", "-o", "a.nrrd", "--encoding", "gzp"), "gzip")
    says(fails(2, "convert", "head.nrrd", "-o", "a.nrrd", "--type", "f332"), "did you mean 'f32'?", "u8, i8")


def test_what_is_near_to_nothing_gets_the_whole_list():
    write_ball(n=8)
    render = ["render", "head.nrrd", "-o", "a.png", "--size", "8"]
    maps = "viridis, magma, inferno, plasma, cividis, gray"
    for words, want in (([*render, "--tf", "qqq"], f"bone, skin, lungs"), (["presets", "qqq"], maps), (["qqq"], "view, serve"),
                        ([*render, "--set", "volumes.head.segmentation.transfer.colormap=qqq"], maps),
                        (["operations", "qqq"], "crop, pad, flip"), (["methods", "qqq"], "raycast, surface"), (["formats", "qqq"], "pfm and svg"),
                        ([*render, "--mode", "qqq"], "composite, maximum (or mip)"), ([*render, "--view", "qqq"], "front (or anterior), back"),
                        ([*render, "--quality", "qqq"], "draft, normal"), (["measure", "qqq", "head.nrrd"], "area, volume, box"),
                        (["render", "head.nrrd", "-o", "a.qqq"], ".pfm and .svg"), (["convert", "head.nrrd", "-o", "a.qqq"], ".nrrd, .nhdr"),
                        (["isosurface", "head.nrrd", "-o", "a.qqq"], ".ply, .stl"), ([*render, "--decorate", "qqq"], "cube, axes"),
                        ([*render, "--aov", "qqq"], "depth, normal")):
        says(fails(2, *words), "qqq", "there are", want)
    says(fails(2, "render", "head.nrrd", "-o", "a.ppm"), "did you mean '.pfm'? There are .png, .jpg")
    says(fails(2, *render, "--color", "qqq"), "qqq", "#ff8800", "a name of CSS such as orange")
    says(fails(2, *render, "--color", "oranje"), "did you mean 'orange'?")
    says(fails(2, *render, "--tf", "viridus"), "did you mean 'viridis'? There are", maps)


def test_words_of_tables_are_taken_in_any_letter_case():
    write_ball(n=8)
    def picture(*words):
        ok("render", "head.nrrd", "-o", "a.png", "--size", "8", "--overwrite", *words)
        return open("a.png", "rb").read()
    for lower in (["--mode", "mip"], ["--mode", "maximum"], ["--view", "anterior"], ["--view", "iso"], ["--tf", "viridis"], ["--tf", "head=bone"],
                  ["--method", "boxes", "--iso", "100"], ["--quality", "draft"], ["--slice", "sagittal"], ["--aov", "depth,normal"],
                  ["--decorate", "box,sides"], ["--decorate", "none"], ["--color", "red", "--iso", "100"]):
        assert picture(*lower) == picture(lower[0], lower[1].title().replace("Head=", "head="), *lower[2:]), lower
    for word, plain in ((["--noise", "NONE"], []), (["--budget", "None"], []), (["--decorate", "NONE"], []), (["--aov", "None"], []),
                        (["--no-shading=TRUE"], ["--no-shading"]), (["--set", "volumes.head.visible=True"], ["--set", "volumes.head.visible=true"]),
                        (["--background", "DarkOrange"], ["--background", "#ff8c00"])):
        assert picture(*word) == picture(*plain), word
    path = "volumes.head.segmentation.transfer.colormap="
    assert picture("--set", path + "viridis") == picture("--set", path + "Viridis")
    assert picture("--set", path + "gray") == picture("--set", path + "GREY")
    assert ok("presets", "bone").text == ok("presets", "Bone").text
    assert ok("formats", "nrrd").text == ok("formats", "NRRD").text
    ok("convert", "head.nrrd", "-o", "b.nrrd", "--type", "F32", "--encoding", "GZIP")
    ok("resample", "head.nrrd", "-o", "c.nrrd", "--dims", "4,4,4", "--interpolation", "Cubic")
    says(ok("info", "head.nrrd", "--progress", "None").text, "head.nrrd")
    assert picture("--clip", "x:2..5") == picture("--clip", "X:2..5")
    for verb, option, word in (("flip", "--axes", "xz"), ("reorient", "--order", "-zyx")):
        ok(verb, "head.nrrd", "-o", "d.nrrd", "--overwrite", option, word)
        ok(verb, "head.nrrd", "-o", "e.nrrd", "--overwrite", option, word.upper())
        assert ok("compare", "d.nrrd", "e.nrrd", "--json").json["identical"], verb
    ok("render", "head.nrrd", "-o", "a.png", "--size", "8", "--overwrite", "--save-scene", "s.vv.json", "--slice", "Axial")
    with open("s.vv.json", encoding="utf-8") as file:
        text = file.read()
    assert '"axial"' in text and '"Axial"' not in text
    with open("s.vv.json", "w", encoding="utf-8") as file:
        file.write(text.replace('"axial"', '"Axial"'))  # nobody types a scene file: it is as strict as its schema
    says(fails(3, "render", "s.vv.json", "-o", "b.png"), "unknown orientation 'Axial'; did you mean 'axial'?")


def test_aliases_are_told_where_names_are():
    says(" ".join(ok("methods", "raycast").text.split()), "also mip for maximum, minip for minimum")
    mode = next(p for p in ok("methods", "raycast", "--json").json["methods"][0]["parameters"] if p["name"] == "mode")
    assert mode["aliases"]["mip"] == "maximum" and set(mode["aliases"].values()) <= set(mode["values"])
    says(" ".join(ok("help", "render").text.split()), "anterior, posterior, superior, inferior, isometric, +x, -x, +y, -y, +z and -z")


def test_words_in_braces_are_placeholders():
    write_ball(n=8)
    for verb, *more in (["render", "--size", "8"], ["convert"], ["info"]):
        says(fails(2, verb, "head.nrrd", *more, "-o", "{name}.png"), "no placeholder {name}", "there is stem")
        says(fails(2, verb, "head.nrrd", *more, "-o", "{stem.png"), "{stem has no closing brace")
    says(fails(2, "measure", "area", "head.nrrd", "--iso", "100", "-o", "{stem}.txt"), "measure makes one result of all its inputs")
    ok("render", "head.nrrd", "--size", "8", "-o", "{a, b}.png")
    assert os.path.exists("{a, b}.png") and not os.path.exists("{name}.png")
    for option in ("--title", "--caption"):
        says(fails(2, "render", "head.nrrd", "--size", "8", "-o", "a.png", option, "of {file"), "'{file' has no closing brace", "{{ gives a brace")


def test_colours_have_the_names_of_css():
    try:
        from PIL import ImageColor
    except ImportError:
        return
    write_ball(n=8)
    ok("render", "head.nrrd", "-o", "a.png", "--size", "8", "--save-scene", "one.vv.json")
    with open("one.vv.json", encoding="utf-8") as file:
        scene = json.load(file)
    scene["lights"] = {name: {"color": name.title() if i % 2 else name, "on": False} for i, name in enumerate(ImageColor.colormap)}
    with open("many.vv.json", "w", encoding="utf-8") as file:
        json.dump(scene, file)
    ok("render", "many.vv.json", "-o", "b.png", "--size", "8", "--save-scene", "all.vv.json")
    with open("all.vv.json", encoding="utf-8") as file:
        told = json.load(file)["lights"]
    assert len(told) == 148 and all(told[name]["color"] == code.lower() for name, code in ImageColor.colormap.items())


def test_formats_has_every_format_that_is_written():
    text = ok("formats").text
    lists = ok("formats", "--json").json
    for suffix in (".svg", ".pdf", ".png", ".pfm", ".exr", ".jpg", ".tif", ".webp", ".nrrd", ".ply", ".vtp", ".glb", ".zarr"):
        says(text, suffix)
        says(ok("formats", suffix).text, suffix)
    assert {"name": "svg", "writes": True, "reads": False}.items() <= lists["images"][-1].items()
    assert ok("formats", "tiff", "--json").json["formats"] and ok("formats", "tiff", "--json").json["images"]


def test_misspelt_properties_presets_and_modes_get_the_nearest_real_ones():
    write_ball()
    render = ["render", "head.nrrd", "-o", "a.png"]
    says(fails(2, *render, "--set", "lights.key.intensitty=2"), "lights.key.intensitty", "did you mean 'intensity'?")
    says(fails(2, *render, "--set", "light.key.intensity=2"), "did you mean 'lights'?")
    says(fails(2, *render, "--set", "lights.key"), "PATH=VALUE")
    says(fails(2, *render, "--tf", "viridus"), "did you mean 'viridis'?")
    says(fails(2, *render, "--mode", "maximun"), "--mode", "maximum")
    says(fails(2, *render, "--method", "raycasst"), "--method", "did you mean 'raycast'?")
    says(fails(2, *render, "--view", "frontt"), "--view", "did you mean 'front'?")
    says(fails(2, *render, "--quality", "hihg"), "--quality", "high")
    says(fails(2, *render, "--clip", "w:1..2"), "--clip", "x:10mm..60mm")
    says(fails(2, *render, "--size", "large"), "--size", "WIDTHxHEIGHT")
    says(fails(2, *render, "--bits", "12"), "8 or 16")
    says(fails(2, *render, "--tf", "0:0 10:2"), "--tf", "10:2")
    says(fails(2, *render, "--threshold", "twelve"), "--threshold")
    says(fails(2, *render, "--threshold", ".."), "--threshold", "LO..HI")
    says(fails(2, *render, "--range", "9,3"), "--range", "rising")


def test_options_that_would_do_nothing_are_refused_with_who_takes_them():
    write_ball()
    nothing = (["--mode", "maximum", "--iso", "70"], ["--slice", "axial", "--mode", "maximum"],
               ["--slice", "axial", "--iso", "9"], ["--slice", "axial", "--step", "1vox"],
               ["--slice", "axial", "--threshold", "9,"], ["--slice", "axial", "--clip", "x:2..9"],
               ["--slice", "axial", "--view", "30,20"], ["--slice", "coronal", "--fov", "9"],
               ["--method", "slice", "--no-shading"], ["--method", "slice", "--iso", "70"],
               ["--method", "surface", "--mode", "maximum"], ["--method", "surface", "--step", "1vox"],
               ["--method", "boxes", "--tf", "hot"], ["--iso", "70", "--tf", "hot"], ["--iso", "70", "--range", "1,9"],
               ["--iso", "70", "--step", "1vox"], ["--mode", "maximum", "--threshold", "9,"],
               ["--mode", "mean", "--no-shading"], ["--mode", "maximum", "--opacity", "0.5"], ["--iso", "9", "--opacity", "0.5"],
               ["--mode", "sum", "--color", "red"], ["--window", "3,9"], ["--cross-hair", "3,4,5"])
    for words in nothing:
        said = fails(2, "render", "head.nrrd", "-o", "a.png", *words)
        says(said, "does nothing", "it is of ", "method")
        assert any(word in said for word in words if word.startswith("--")), said
    says(fails(2, "render", "head.nrrd", "-o", "a.png", "--mode", "maximum", "--iso", "70"),
         "--iso does nothing in mode maximum of method raycast: it is of mode isosurface of method raycast, and of "
         "methods surface, reduced and boxes")
    says(fails(2, "render", "head.nrrd", "-o", "a.png", "--iso", "70", "--tf", "hot"), "all modes but isosurface")
    says(fails(2, "render", "head.nrrd", "-o", "a.png", "--slice", "axial", "--view", "1,2"), "orientation camera")
    says(fails(2, "render", "head.nrrd", "-o", "a.png", "--color", "red"), "--color does nothing to clouds", "--iso")
    for words in (["--range", "1..9"], ["--opacity", "0.5"], ["--tf", "hot"]):
        says(fails(2, "render", "head.nrrd", "-o", "a.png", "--threshold", "9..", *words), words[0], "--threshold")
    says(fails(2, "render", "head.nrrd", "-o", "a.png", "--view", "left", "--eye", "90,0,0"), "--view left", "--eye")
    says(fails(2, "render", "head.nrrd", "-o", "a.png", "--iso", "70", "--threshold", "60..80"), "--iso", "--threshold")
    for option in ("--noise", "--budget"):
        says(fails(2, "render", "head.nrrd", "-o", "a.png", option, "0"), option, "no limit", "none")


def write_rgb(path, n=8):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    rows = b"".join(b"\0" + bytes(v for x in range(n) for v in (30 * x, 30 * y, 90)) for y in range(n))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", n, n, 8, 2, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def test_options_that_do_nothing_to_what_is_seen_are_refused():
    write_ball(n=16)
    write_labels()
    write_box()
    write_rgb("rgb.png")
    nodes = "0:0#000 200:0.1#fff"
    for words, why in ((("head.nrrd", "--tf", nodes, "--range", "0..100"), "given by value"),
                       (("head.nrrd", "--tf", nodes, "--percentile", "1..99"), "given by value"),
                       (("head.nrrd", "--slice", "axial", "--tf", nodes, "--window", "1..9"), "--range stretches"),
                       (("head.nrrd", "--slice", "axial", "--window", "1..9", "--range", "1..20"), "give one of them"),
                       (("organs.seg.nrrd", "--range", "0..1"), "by their numbers"),
                       (("organs.seg.nrrd", "--slice", "axial", "--window", "0..1"), "by their numbers"),
                       (("rgb.png", "--window", "0..10"), "samples are colours"), (("rgb.png", "--range", "0..10"), "samples are colours"),
                       (("box.ply", "--threshold", "1.."), "already"), (("box.ply", "--iso", "3"), "no iso-value"),
                       (("box.ply", "--tf", "bone"), "no values"), (("box.ply", "--range", "1..2"), "no values"),
                       (("box.ply", "--percentile", "1..2"), "is a mesh"), (("box.ply", "--slice", "axial"), "do not show meshes"),
                       (("head.nrrd", "box.ply", "--method", "surface", "--tf", "head=hot"), "one colour"), (("box.ply", "--method", "slice"), "do not show meshes"), (("box.ply", "--frame", "3"), "no time steps")):
        says(fails(2, "render", *words, "-o", "a.png", "--size", 16), why, words[-2][2:])
    for words, why in ((("--iso", "70", "--smoothing", "2"), "labels"), (("--iso", "70", "--by", "volume"), "--pieces or --least"),
                       (("--iso", "70", "--space", "world"), "--seed"), (("--iso", "70", "--stored"), "samples")):
        says(fails(2, "isosurface", "head.nrrd", "-o", "a.ply", *words), why, "does nothing")
    for words in (("--cap",), ("--topology", "apart")):
        says(fails(2, "isosurface", "organs.seg.nrrd", "-o", "a.ply", *words), words[0], "values")
    for verb in ("convert", "smooth", "simplify"):
        says(fails(2, verb, "box.ply", "-o", "a.ply", "--stored"), "--stored does nothing to meshes")
    says(fails(2, "info", "head.nrrd", "--input-unit", "mm"), "--input-unit is about meshes")
    for words in (("--aov", "depth"), ("--decorate", "cube"), ("--background", "red")):
        says(fails(2, "pick", "head.nrrd", "--pixel", "3,3", *words), f"{words[0]} does nothing")
    assert sorted(os.listdir(".")) == ["box.ply", "head.nrrd", "organs.seg.nrrd", "rgb.png"]


def test_options_of_operations_that_another_option_makes_idle_are_refused():
    write_ball()
    threshold = ["threshold", "head.nrrd", "-o", "a.nrrd", "--overwrite"]
    says(fails(2, *threshold, "--method", "otsu", "--range", "3..5"), "--range does nothing with --method otsu", "for range or hysteresis")
    says(fails(2, *threshold, "--range", "3..5", "--classes", "4"), "--classes does nothing with --method range", "for multi-otsu")
    says(fails(2, *threshold, "--range", "3..5", "--strong", "4.."), "--strong does nothing with --method range")
    says(fails(2, *threshold, "--method", "li", "--connectivity", "18"), "--connectivity does nothing with --method li")
    ok(*threshold, "--method", "multi-otsu", "--classes", "4")
    ok(*threshold, "--method", "hysteresis", "--range", "3..", "--strong", "9..", "--connectivity", "18")
    grow = ["grow", "head.nrrd", "-o", "a.nrrd", "--overwrite", "--seed", "16,16,16"]
    for words in (["--radius", "2"], ["--deviations", "2"], ["--iterations", "2"]):
        says(fails(2, *grow, "--range", "50..", *words), "a range needs no")
        ok(*grow, *words)


def test_the_same_options_are_taken_where_they_do_something():
    """Each gives another picture than without it."""
    write_ball(n=16)
    write_labels()
    write_box()
    for words, option in ((("head.nrrd", "--tf", "hot"), ("--range", "50..100")), (("head.nrrd",), ("--range", "50..100")),
                          (("head.nrrd", "--tf", "0:0 200:0.1"), ("--range", "20..30")),
                          (("head.nrrd", "--slice", "axial"), ("--range", "50..100")), (("head.nrrd", "--slice", "axial"), ("--window", "50..100")),
                          (("head.nrrd", "--slice", "axial"), ("--percentile", "60..99")), (("head.nrrd", "--mode", "mip"), ("--range", "50..100")),
                          (("organs.seg.nrrd", "--tf", "hot"), ("--range", "5..9")), (("head.nrrd", "box.ply"), ("--threshold", "90.."))):
        for n, more in enumerate(((), option)):
            ok("render", *words, *more, "-o", f"{n}.png", "--size", 24, "--overwrite")
        assert png_pixels("0.png") != png_pixels("1.png"), (words, option)
    ok("isosurface", "head.nrrd", "-o", "a.ply", "--iso", 70, "--by", "volume", "--pieces", 1, "--cap", "--topology", "apart")
    ok("isosurface", "organs.seg.nrrd", "-o", "b.ply", "--smoothing", 2)
    ok("info", "head.nrrd", "box.ply", "--input-unit", "mm")


def test_options_of_writing_that_would_do_nothing_are_refused():
    write_ball(n=8)
    for words, said in ((("-o", "a.png", "--image-quality", "50"), "JPEG or WebP"), (("-o", "a.tif", "--image-quality", "50"), "JPEG"),
                        (("-o", "a.exr", "--dpi", "300"), "PNG, JPEG, TIFF or PDF"), (("-o", "a.pfm", "--dpi", "300"), "PDF"),
                        (("-o", "a.webp", "--dpi", "300"), "PDF")):
        says(fails(2, "render", "head.nrrd", "--size", "8", *words), f"{words[2]} does nothing", said)
    for words in (("-o", "a.nii"), ("-o", "a.npy"), ("-o", "a.nrrd"), ("-o", "a.nrrd", "--encoding", "raw")):
        says(fails(2, "convert", "head.nrrd", "--level", "9", *words), "--level does nothing", "omit it")
    says(fails(2, "isosurface", "head.nrrd", "-o", "a.ply", "--iso", "9", "--level", "9"), "--level does nothing")
    says(fails(2, "convert", "head.nrrd", "-o", "a.nrrd", "--type", "i16", "--stored"), "--stored", "--type")
    for name, form in (("d.npy", "nrrd"), ("d.stl", "nrrd"), ("d.nii.gz", "nrrd")):
        says(fails(2, "convert", "head.nrrd", "-o", name, "--output-format", form), "suffix of", f"--output-format says {form}")
    says(fails(2, "isosurface", "head.nrrd", "-o", "d.stl", "--iso", "9", "--output-format", "ply"), "suffix of stl")
    assert os.listdir(".") == ["head.nrrd"]
    ok("convert", "head.nrrd", "-o", "a.nii.gz", "--level", "9")
    ok("convert", "head.nrrd", "-o", "a.nrrd", "--level", "9", "--encoding", "gzip")
    ok("convert", "head.nrrd", "-o", "plain", "--output-format", "nrrd")
    with open("defaults", "w", encoding="ascii") as file:
        file.write("render --dpi 300\n")  # for the pictures that it is of use for
    ok("render", "head.nrrd", "-o", "a.webp", "--size", "8", env={"VOLVIS_DEFAULTS": os.path.abspath("defaults")})


def test_options_that_do_something_are_taken():
    write_ball()
    small = ["-o", "a.png", "--size", "16x16", "--overwrite"]
    for words in (["--slice", "camera", "--view", "30,20"], ["--mode", "isosurface", "--iso", "70", "--no-shading"],
                  ["--cross-hair", "3,4,5", "--decorate", "cross-hair"], ["--mode", "mip", "--tf", "hot"],
                  ["--mode", "minip"], ["--mode", "xray"], ["--budget", "none"], ["--noise", "none"]):
        ok("render", "head.nrrd", *small, *words)
    ok("render", "head.nrrd", *small, "--mode", "mip", "--save-scene", "a.vv.json")
    with open("a.vv.json", encoding="utf-8") as file:
        says(file.read(), '"mode": "maximum"')
    ok("view", "head.nrrd", "--window", "3,9", "--dry-run")  # the page shows slices too


def scene_of(*words):
    """The World that render makes of these words."""
    ok("render", *words, "-o", "scene.png", "--overwrite", "--save-scene", "scene.vv.json",
       *([] if "--size" in words else ["--size", "16"]))
    with open("scene.vv.json", encoding="utf-8") as file:
        return json.load(file)


def test_sizes_and_zoom_have_short_forms():
    write_ball()
    def size(typed):
        view = scene_of("head.nrrd", "--size", typed)["views"]["main"]
        return view["width"], view["height"]
    assert size("24") == (24, 24) and size("32X16") == (32, 16) and size("32x16") == (32, 16)
    assert scene_of("head.nrrd", "--zoom", "1.5")["views"]["main"]["camera"]["zoom"] == 1.5
    says(fails(2, "render", "head.nrrd", "-o", "a.png", "--zoom", "big"), "--zoom")


def test_views_have_the_names_of_anatomy_and_of_axes():
    def camera(path, view):
        c = scene_of(path, "--view", view)["views"]["main"]["camera"]
        return c.get("azimuth", 0), round(c.get("elevation", 0), 3)
    write_ball()  # anatomical
    for word, alias in (("front", "anterior"), ("back", "posterior"), ("top", "superior"), ("bottom", "inferior"),
                        ("right", "+x"), ("left", "-x"), ("front", "+y"), ("back", "-y"), ("top", "+z"), ("bottom", "-z")):
        assert camera("head.nrrd", word) == camera("head.nrrd", alias), alias
    assert camera("head.nrrd", "iso")[1] == 35.264
    with open("d_8x8x8_uint8.raw", "wb") as file:
        file.write(bytes(range(256)) * 2)
    assert camera("d_8x8x8_uint8.raw", "-y") == camera("d_8x8x8_uint8.raw", "front")
    assert camera("d_8x8x8_uint8.raw", "+x") == camera("d_8x8x8_uint8.raw", "right")


def test_ranges_are_written_with_dots_everywhere():
    write_ball()
    def transfer(*words):
        return scene_of("head.nrrd", *words)["volumes"]["head"]["segmentation"]
    for typed in ("10..200.5", "10,200.5"):
        found = transfer("--tf", "hot", "--range", typed)["transfer"]
        assert (found["range_lo"], found["range_hi"]) == (10, 200.5), typed
    assert transfer("--tf", "hot", "--percentile", "1..99") == transfer("--tf", "hot", "--percentile", "1,99")
    for typed, lo, hi in (("80", 80, 1e308), ("80..", 80, 1e308), ("80,", 80, 1e308), ("..80", -1e308, 80), ("80..90", 80, 90)):
        found = transfer("--threshold", typed)["threshold"]
        assert (found["lo"], found["hi"]) == (lo, hi), typed
    for new, old in ((["crop", "--x", "3..5"], ["crop", "--x", "3:6"]), (["crop", "--x", "-4.."], ["crop", "--x", "-4:"]),
                     (["crop", "--z", "2mm..5mm"], ["crop", "--z", "2mm:5mm"]), (["rescale", "--from", "9..90"], ["rescale", "--from", "9,90"]),
                     (["convert", "--type", "u8", "--range", "9..90"], ["convert", "--type", "u8", "--range", "9,90"])):
        ok(new[0], "head.nrrd", *new[1:], "-o", "new.nrrd", "--overwrite")
        ok(old[0], "head.nrrd", *old[1:], "-o", "old.nrrd", "--overwrite")
        assert ok("compare", "new.nrrd", "old.nrrd", "--json").json["identical"], new
    assert ok("info", "old.nrrd", "--json").json["dims"] == [32, 32, 32]
    says(fails(2, "crop", "head.nrrd", "-o", "a.nrrd", "--x", "20..10"), "contains no sample")
    says(fails(2, "crop", "head.nrrd", "-o", "a.nrrd", "--x", "20..40"), "samples 0 to 31")
    for new, old in ((("volume", "--threshold", "9..90"), ("volume", "--threshold", "9,90")),
                     (("volume", "--threshold", "9.."), ("volume", "--threshold", "9,")),
                     (("volume", "--iso", "9", "--box", "3..5,..,..6"), ("volume", "--iso", "9", "--box", "3:6,:,:7")),
                     (("histogram", "--range", "9..90"), ("histogram", "--range", "9,90"))):
        results = [ok("measure", words[0], "head.nrrd", *words[1:], "--json").json for words in (new, old)]
        for result in results:
            result.pop("region", None)
        assert results[0] == results[1], new
    for verb in ("render", "crop", "convert", "rescale", "measure"):
        text = ok("help", verb).text
        assert ".." in text and not re.search(r"\bLO,HI\b|\bFIRST:END\b", text), verb


def test_numbers_are_read_in_one_way_and_a_range_is_no_list():
    write_ball(n=8)
    for option in "--iso", "--label":
        says(fails(2, "isosurface", "head.nrrd", "-o", "a.ply", option, "10..20"), "a range is not a list", "10,20")
    for typed, values in ((".5", "0.5"), ("+0.5", "0.5"), ("10,20.", "10, 20"), (".5,+20,1e2", "0.5, 20, 100")):
        says(ok("isosurface", "head.nrrd", "-o", "a.ply", "--iso", typed).text, f"surface at {values};")
    for typed, plain in ((".1...6", "0.1,0.6"), ("-.5..+60.", "-0.5,60")):
        ok("rescale", "head.nrrd", "-o", "a.nrrd", "--from", typed, "--type", "f32")
        ok("rescale", "head.nrrd", "-o", "b.nrrd", "--from", plain, "--type", "f32")
        assert open("a.nrrd", "rb").read() == open("b.nrrd", "rb").read(), typed


def test_a_component_is_a_channel_in_every_verb():
    write_cells()
    for word in ("--channel", "--components"):
        ok("channel", "cells.nrrd", "-o", "c.nrrd", word, "1", "--overwrite")
        ok("convert", "cells.nrrd", "-o", "d.nrrd", "--channel", "1", "--overwrite")
        assert ok("compare", "c.nrrd", "d.nrrd", "--json").json["identical"]
    for word in ("--channel", "--component"):
        ok("isosurface", "cells.nrrd", "-o", "s.ply", "--iso", "500", word, "1", "--overwrite")
        ok("measure", "statistics", "cells.nrrd", word, "1")
    for verb in ("channel", "isosurface", "measure"):
        says(ok("help", verb).text, "--channel ")


def test_a_preset_of_two_kinds_is_offered_once():
    script = ok("completions", "bash").text
    line = next(line for line in script.splitlines() if " viridis" in line and " vessels" in line)
    assert len(re.findall(r"\bbone\b", line)) == 1, line


def test_options_about_values_are_for_each_of_many_pictures():
    write_ball("t1.nrrd")
    write_ball("act.nrrd")
    def pictures(*words):
        ok("render", *words, "-o", "{stem}.png", "--size", "32", "--overwrite")
        return [png_pixels(name + ".png") for name in ("t1", "act")]
    def one(*words):
        ok("render", "t1.nrrd", "-o", "one.png", "--size", "32", *words)
        return png_pixels("one.png")
    bone, hot, plain = one("--tf", "bone"), one("--tf", "hot"), one()
    assert len({bone, hot, plain}) == 3
    assert pictures("t1.nrrd", "--tf", "bone", "act.nrrd", "--tf", "hot") == [bone, hot]
    assert pictures("t1.nrrd", "act.nrrd", "--tf", "hot") == [hot, hot]
    assert pictures("--tf", "bone", "t1.nrrd", "act.nrrd") == [bone, bone]
    assert pictures("t1.nrrd", "--tf", "bone", "act.nrrd") == [bone, plain]
    assert pictures("t1.nrrd", "--background", "white", "act.nrrd") == [one("--background", "white")] * 2


def test_options_about_values_are_for_each_input():
    write_ball("t1.nrrd")
    write_ball("act.nrrd", n=16)
    def maps(*words):
        volumes = scene_of(*words)["volumes"]
        return [volumes[id]["segmentation"]["transfer"].get("colormap") for id in ("t1", "act")]
    assert maps("t1.nrrd", "--tf", "grey", "act.nrrd", "--tf", "hot") == ["gray", "hot"]
    assert maps("t1.nrrd", "act.nrrd", "--tf", "hot") == ["hot", "hot"]
    shown = scene_of("t1.nrrd", "--tf", "gray", "act.nrrd", "--tf", "hot", "--range", "60..90", "--slice", "axial")["volumes"]
    assert shown["act"]["slices"]["window_hi"] == 90 and shown["t1"]["slices"].get("window_hi") != 90, shown
    assert maps("--tf", "ice", "t1.nrrd", "act.nrrd", "--tf", "act=hot") == ["ice", "hot"]
    assert maps("t1.nrrd", "--tf", "ice", "act.nrrd", "--tf", "map:bone")[1] == "bone"
    says(fails(2, "render", "t1.nrrd", "act.nrrd", "-o", "a.png", "--tf", "axt=hot"), "no volume 'axt'", "'act'")
    world = scene_of("t1.nrrd", "act.nrrd", "--slice", "axial", "--tf", "act=hot", "--range", "act=60..255", "--opacity", "act=80%")
    shown = world["volumes"]["act"]["slices"]
    assert (shown["colormap"], shown["window_lo"], shown["window_hi"], shown["opacity"]) == ("hot", 60, 255, 0.8)
    assert world["volumes"]["t1"]["slices"]["window_hi"] != 255 or "colormap" not in world["volumes"]["t1"]["slices"]
    colors = scene_of("t1.nrrd", "--color", "red", "act.nrrd", "--color", "#0000ff", "--iso", "90")["volumes"]
    assert [colors[id]["color"] for id in ("t1", "act")] == ["#ff0000", "#0000ff"], colors
    slices = scene_of("t1.nrrd", "--slice", "axial", "--color", "lime")["volumes"]["t1"]["slices"]
    assert slices["colormap"] == "#00ff00", slices
    says(fails(2, "render", "t1.nrrd", "-o", "a.png", "--opacity", "3"), "--opacity", "from 0 to 1")


def test_each_class_of_failure_has_its_exit_code():
    write_ball()
    with open("text.nrrd", "w", encoding="utf-8") as file:
        file.write("this is no volume at all\n")
    fails(2, "info")
    fails(2, "convert", "head.nrrd", "also.nrrd", "third.nrrd")
    fails(2, "info", "head.nrrd@7")
    fails(2, "info", "head.nrrd", "--threads", "0")
    fails(2, "info", "head.nrrd", "--memory", "8Q")
    fails(2, "info", "head.nrrd", "--set", "lights.key.intensity=1")
    fails(2, "gaussian", "head.nrrd")
    fails(3, "info", "absent.nrrd")
    fails(3, "info", "text.nrrd")
    fails(3, "render", "absent.nrrd", "-o", "a.png")
    fails(5, "convert", "head.nrrd", "-o", "absent/a.nrrd")
    fails(5, "render", "head.nrrd", "-o", "absent/a.png")


def test_a_file_alone_is_looked_at():
    write_ball()
    says(ok("head.nrrd", "--dry-run").text, "serves", "a World of 1 volume on this machine alone")


def test_errors_in_json_say_code_message_file_and_place():
    for words, code, name in ((["info", "absent.nrrd"], 3, "read"), (["rendr", "x"], 2, "argument"),
                              (["info", "--bogus"], 2, "argument")):
        result = volvis(*words, "--json")
        assert result.code == code
        error = result.json["error"]
        assert sorted(error) == ["code", "file", "message", "where"], error
        assert error["code"] == name and error["message"], error
    assert volvis("info", "absent.nrrd", "--json").json["error"]["file"] == "absent.nrrd"


def test_json_of_every_list_is_valid_and_has_its_rows():
    assert "nrrd" in [f["name"] for f in ok("formats", "--json").json["formats"]]
    assert "raycast" in [m["name"] for m in ok("methods", "--json").json["methods"]]
    assert {"crop", "flip", "rescale", "gaussian"} <= {o["name"] for o in ok("operations", "--json").json["operations"]}
    assert "viridis" in [p["name"] for p in ok("presets", "--json").json["presets"]]
    assert ok("schema", "--json").json["$schema"].startswith("https://json-schema.org/")
    tables = ok("schema", "--tables", "--json").json
    assert {"classes", "operations", "renderers", "presets", "colormaps", "methods", "bindings"} <= set(tables)
    assert "operation.crop" in tables["classes"] and "turn" in tables["bindings"]["bindings"]
    checks = {check["check"]: check["ok"] for check in ok("doctor", "--json").json["checks"]}
    assert checks["rendering"] and "import" in checks and "seccomp" in checks and "landlock" in checks
    assert ok("doctor", "--limits", "--json").json["limits"]["dim"] > 0


def test_the_environment_stands_in_for_threads_and_memory():
    says(ok("doctor", env={"VOLVIS_THREADS": "1"}).text, "threads       1")
    says(ok("doctor", "--threads", "2", env={"VOLVIS_THREADS": "1"}).text, "threads       2")
    says(fails(2, "doctor", env={"VOLVIS_MEMORY": "many"}), "VOLVIS_MEMORY=many")


def test_limits_are_listed_and_can_be_changed():
    listed = ok("doctor", "--limits", "--limit", "dim=77", "--limit", "header_bytes=32M", env={"VOLVIS_LIMITS": "files=3,dim=5"})
    lines = {line.split()[0]: line for line in listed.text.splitlines()}
    says(lines["dim"], " 77 ", "(changed; the default is 1048576)")
    says(lines["header_bytes"], " 32.0 MiB ", "changed; the default is 16.0 MiB")
    says(lines["files"], " 3 ", "changed")
    assert "changed" not in lines["voxels"] and set(lines) == set(ok("doctor", "--limits", "--json").json["limits"])
    says(fails(2, "doctor", "--limit", "voxel=7"), "did you mean 'voxels'?")
    says(fails(2, "doctor", "--limit", "dim=0"), "a whole number from 1 to")
    says(fails(2, "doctor", "--limit", "dim"), "NAME=VALUE")
    says(fails(2, "doctor", env={"VOLVIS_LIMITS": "dim=many"}), "VOLVIS_LIMITS", "'many'")


def test_counts_and_bytes_take_suffixes():
    words = ["--limit=dim=2K", "--limit=voxels=1.5M", "--limit=files=70000", "--limit=string_bytes=2K"]
    limits = ok("doctor", "--limits", "--json", *words).json["limits"]
    assert (limits["dim"], limits["voxels"], limits["files"], limits["string_bytes"]) == (2000, 1500000, 70000, 2048)
    for text in ("1Q", "1KK", "K", "1.5", "1K ", "1KB", "-1K", "1e40T"):
        says(fails(2, "doctor", "--limits", "--limit", "dim=" + text), "a whole number from 1 to", "2K")


def test_limits_hold_for_what_is_read():
    write_ball()
    ok("info", "head.nrrd", "--limit", "dim=32", "--limit", "voxels=32768")
    says(fails(3, "info", "head.nrrd", "--limit", "dim=31"), "head.nrrd", "31")
    says(fails(3, "info", "head.nrrd", "--limit", "voxels=32767"), "head.nrrd", "--limit voxels=N")
    says(fails(3, "info", "head.nrrd", env={"VOLVIS_LIMITS": "voxels=32767"}), "32767")


def test_options_may_be_spelt_in_every_usual_way():
    write_ball()
    ok("convert", "-oa.nrrd", "head.nrrd")
    ok("convert", "--output=b.nrrd", "head.nrrd")
    ok("convert", "-q", "-o", "c.nrrd", "--", "head.nrrd")
    ok("convert", "-qo", "d.nrrd", "--encoding=gzip", "--level", "9", "head.nrrd")
    says(fails(2, "convert", "head.nrrd", "-o"), "--output needs a value")
    says(fails(2, "convert", "head.nrrd", "-Z"), "no option -Z")


def test_text_results_go_where_output_says():
    ok("schema", "-o", "schema.json")
    with open("schema.json", "rb") as file:
        assert file.read() == ok("schema").out
    write_ball()
    ok("info", "head.nrrd", "--json", "-o", "info.json")
    with open("info.json", "rb") as file:
        assert file.read() == ok("info", "head.nrrd", "--json").out


def test_completion_scripts_are_valid_and_know_verbs_options_and_names():
    script = ok("completions", "bash").text
    says(script, "render", "--background", "viridis", "raycast", "lights.ID.intensity=", "nrrd", "composite")
    done = subprocess.run(["bash", "-n"], input=script.encode(), capture_output=True)
    assert done.returncode == 0, done.stderr
    says(ok("completions", "zsh").text, "#compdef volvis", "--background", "viridis")
    says(ok("completions", "fish").text, "complete -c volvis", "-l background", "viridis")


def complete(line):
    words = line.split(" ")
    script = ok("completions", "bash").text + f"""
COMP_WORDS=({' '.join("'" + w + "'" for w in words)}); COMP_CWORD={len(words) - 1}
compopt() {{ :; }}
_volvis; printf '%s\\n' "${{COMPREPLY[@]}}"
"""
    return subprocess.run(["bash", "-c", script], capture_output=True, env=environment()).stdout.decode().split()


def test_completion_offers_decorations_as_they_are_typed():
    for shell in ("bash", "zsh", "fish"):
        text = ok("completions", shell).text
        says(text, "scale-bar", "cut-planes")
    says(ok("completions", "bash").text, "words='cube axes scale-bar box cut-planes legend sides cross-hair measurements all none'")
    write_ball("a.nrrd")
    says(fails(2, "render", "a.nrrd", "-o", "a.png", "--decorate", "scale_baz"), "did you mean 'scale-bar'")


def test_bash_completes_verbs_options_values_and_paths():
    assert "render" in complete("volvis re")
    assert "--background" in complete("volvis render head.nrrd --ba")
    assert complete("volvis render head.nrrd --tf virid") == ["viridis"]
    assert complete("volvis info head.nrrd --progress js") == ["json"]
    assert complete("volvis render head.nrrd --set lights.ID.inten") == ["lights.ID.intensity="]
    assert complete("volvis completions z") == ["zsh"]
    write_ball("hello.nrrd")
    assert complete("volvis measure h") == ["hello.nrrd", "histogram"] or complete("volvis measure h") == ["histogram", "hello.nrrd"]
    assert "area" in complete("volvis measure ") and "hello.nrrd" in complete("volvis measure area he")
    assert complete("volvis measure hello.nrrd area") == ["area"]
    for line in ("volvis measure a.nrrd --mask ar", "volvis measure a.nrrd --values ar", "volvis measure a.nrrd -o ar"):
        assert complete(line) == [], line  # bash goes on with files
    assert complete("volvis measure a.nrrd --method co") == ["count"]
    says(ok("completions", "fish").text, "__fish_seen_subcommand_from measure' -a 'area volume",
         "__fish_seen_subcommand_from measure' -l mask -r")
    says(ok("completions", "zsh").text, '{_alternative "words:word:(area volume', "--mask=[", "file:_files")


def test_lists_are_taken_where_they_mean_something():
    write_ball("ball.nrrd", 16)
    ok("crop", "ball.nrrd", "-o", "dots.nrrd", "--x", "2..9")
    ok("crop", "ball.nrrd", "-o", "comma.nrrd", "--x", "2,9")
    assert open("dots.nrrd", "rb").read() == open("comma.nrrd", "rb").read()
    says(fails(2, "crop", "ball.nrrd", "-o", "x.nrrd", "--x", "2,9,10"), "is not a range")
    says(fails(2, "gaussian", "ball.nrrd", "-o", "x.nrrd", "--sigma", "2mm,1mm,0"), "is a list", "one value")
    ok("render", "ball.nrrd", "-o", "one.png", "--clip", "x:0mm..9mm,y:3..", "--size", "32")
    ok("render", "ball.nrrd", "-o", "two.png", "--clip", "x:0mm..9mm", "--clip", "y:3..", "--size", "32")
    assert open("one.png", "rb").read() == open("two.png", "rb").read()
    says(fails(2, "render", "ball.nrrd", "-o", "x.png", "--clip", "x:0mm..9mm,3.."), "expected x:10mm..60mm")
    says(fails(2, "info", "ball.nrrd", "--axes", "zyx"), "no part 'zyx'")  # of NumPy's arrays alone


def test_man_pages_exist_for_the_program_and_every_verb():
    says(ok("man").text, ".TH volvis 1", "volvis\\-render", "VOLVIS_THREADS")
    ok("man", "--into", "man1")
    for verb in verbs():
        name = verb["name"].replace("-", "\\-")
        with open(f"man1/volvis-{verb['name']}.1", encoding="utf-8") as file:
            says(file.read(), f".SH NAME\nvolvis\\-{name}", ".SH SYNOPSIS", ".SH EXAMPLES", ".SH EXIT STATUS")


def test_the_reference_has_every_verb_and_property():
    text = ok("reference").text
    for verb in verbs():
        says(text, f"### volvis {verb['name']}\n")
    says(text, "| `views.ID.camera.azimuth` |", "| `lights.ID.intensity` |", "| `cut_planes.0.offset` |")


def test_text_goes_into_no_file_that_its_name_says_is_data():
    write_ball(n=8)
    ok("convert", "head.nrrd", "-o", "a.nii.gz")
    ok("render", "head.nrrd", "-o", "a.png", "--size", "8")
    ok("render", "head.nrrd", "-o", "b.png", "--size", "8", "--save-scene", "s.vv.json")
    before = {path: open(path, "rb").read() for path in os.listdir(".")}
    for words, kind in ((("info", "head.nrrd", "-o", "a.nii.gz"), "volume"), (("info", "head.nrrd", "-o", "x.stl"), "mesh"),
                        (("info", "head.nrrd", "-o", "x.ome.zarr"), "volume"), (("info", "head.nrrd", "-o", "a.png"), "picture"),
                        (("pick", "a.png", "--at", "4,4", "-o", "x.nrrd"), "volume"), (("formats", "-o", "a.png"), "picture"),
                        (("compare", "a.png", "b.png", "-o", "a.png"), "picture"), (("doctor", "-o", "d.svg"), "picture"),
                        (("measure", "statistics", "head.nrrd", "-o", "s.vv.json"), "scene")):
        says(fails(2, *words), f"suffix of a {kind}", words[0], ".txt, .json or .csv")
    ok("render", "head.nrrd", "-o", "a.png", "--help")  # is printed
    assert before == {path: open(path, "rb").read() for path in os.listdir(".")}
    for path in "x.txt", "x.json", "x.csv", "x":
        ok("info", "head.nrrd", "-o", path)


def test_no_color_code_leaves_the_program_unasked():
    for words in (["help"], ["rendr"], ["doctor"]):
        result = volvis(*words)
        assert b"\033" not in result.out + result.err


main()
