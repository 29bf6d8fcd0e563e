"""Pictures: render, scenes, and pictures that repeat themselves."""
import json
import os
import re
import shutil
import subprocess
from harness import HEAD_MRI, Skip, VOLVIS, environment, fails, main, ok, png_chunks, png_pixels, png_text, says, volvis, write_ball

RENDER_KEYS = {"output", "width", "height", "method", "load_s", "prepare_s", "first_s", "render_s", "write_s",
               "peak_bytes", "samples", "rays", "passes", "ended_by", "isa", "threads"}
SMALL = ["--size", "64x48"]


def contents(path):
    with open(path, "rb") as file:
        return file.read()


def test_render_has_the_keys_that_scripts_rely_on():
    write_ball()
    answer = ok("render", "head.nrrd", "-o", "a.png", *SMALL, "--json").json
    assert RENDER_KEYS <= set(answer), RENDER_KEYS - set(answer)
    assert answer["width"] == 64 and answer["height"] == 48 and answer["method"] == "raycast"
    assert 2 * 64 * 48 < answer["rays"] < 2.1 * 64 * 48 and answer["samples"] > 0
    header = dict(png_chunks("a.png"))["IHDR"]
    assert header[:8] == bytes([0, 0, 0, 64, 0, 0, 0, 48]) and header[8] == 8


def test_something_is_to_be_seen_without_any_option():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", *SMALL)
    assert len(set(png_pixels("a.png"))) > 16


def test_a_picture_of_nothing_says_so():
    write_ball()
    for words in (("--iso", "1e9"), ("--clip", "x:1000.."), ("--set", "volumes.head.visible=false"), ("--iso", "1e9", "--spp", "4")):
        says(ok("render", "head.nrrd", "-o", "nothing.png", "--overwrite", *words).message, "warning", "nothing is seen")
    seen = ok("render", "head.nrrd", "-o", "a.png", "--iso", "50")
    assert "nothing is seen" not in seen.message, seen.message


def test_a_picture_repeats_itself():
    write_ball(spacing=(1, 1, 1.5))
    for extra in ([], ["--tf", "viridis", "--view", "30,20"], ["--mode", "maximum", "--background", "transparent"],
                  ["--iso", "100", "--clip", "x:10..20"], ["--bits", "16", "--quality", "high"],
                  ["--quality", "draft"], ["--noise", "1%"], ["--spp", "3", "--mode", "maximum"],
                  ["--parallel", "60mm", "--tf", "0:0 100:0.1#e0b090 200:0.9#fff"], ["--threshold", "90,"]):
        ok("render", "head.nrrd", "-o", "a.png", *SMALL, *extra)
        ok("render", "a.png", "-o", "b.png")
        assert contents("a.png") == contents("b.png"), extra


def test_what_no_memory_holds_is_drawn_from_the_parts_that_are_seen():
    write_ball()
    ok("resample", "head.nrrd", "-o", "large.zarr", "--size", "250,250,250")
    whole, parts = ["large.zarr:0", "-o", "whole.png", *SMALL], ["large.zarr:0", "-o", "parts.png", *SMALL, "--memory", "13M"]
    for words in ([], ["--iso", "90"], ["--mode", "maximum"], ["--tf", "0:0 100:0.1#e0b090 200:0.9#fff", "--clip", "z:..20"]):
        ok("render", *whole, "--overwrite", *words)
        answer = ok("render", *parts, "--overwrite", "--json", *words).json
        assert answer["peak_bytes"] < 13 << 20 and png_pixels("parts.png") == png_pixels("whole.png"), words
    ok("convert", "large.zarr:0", "-o", "large.nrrd", "--encoding", "gzip")
    fails(4, "render", "large.nrrd", "-o", "x.png", *SMALL, "--memory", "13M")  # whose parts cannot be read alone


def test_many_rays_a_pixel_are_a_number_a_noise_or_a_time():
    write_ball()
    one = ok("render", "head.nrrd", "-o", "one.png", *SMALL, "--spp", "1", "--json").json
    assert one["passes"] == 1 and one["ended_by"] == "samples"
    assert png_text("one.png")["VolVis:Rays"] == "1 ray per pixel"
    four = ok("render", "head.nrrd", "-o", "four.png", *SMALL, "--spp", "4", "--json").json
    assert four["passes"] == 4 and 4 * 64 * 48 < four["rays"] < 4.2 * 64 * 48
    high = ok("render", "head.nrrd", "-o", "high.png", *SMALL, "--quality", "high", "--json").json
    assert high["passes"] == 4
    noise = ok("render", "head.nrrd", "-o", "noise.png", *SMALL, "--noise", "2%", "--json").json
    assert noise["ended_by"] == "noise" and noise["passes"] > 1 and noise["rays"] < noise["passes"] * 64 * 48
    says(png_text("noise.png")["VolVis:Rays"], "at most", "on average", "ended by noise")
    says(ok("render", "head.nrrd", "-o", "x.png", *SMALL, "--spp", "3").text, "3 rays per pixel")
    says(fails(2, "render", "head.nrrd", "-o", "x.png", "--spp", "0"), "--spp", "expected 1 to 65536")
    says(fails(2, "render", "head.nrrd", "-o", "x.png", "--budget", "10mm"), "--budget")


def test_a_picture_that_time_ended_is_made_again_by_its_number_of_rays():
    write_ball()
    made = ok("render", "head.nrrd", "-o", "a.png", *SMALL, "--budget", "50ms", "--json").json
    assert made["ended_by"] in ("budget", "samples")
    again = ok("render", "a.png", "-o", "b.png", "--json").json
    assert again["passes"] == made["passes"] and again["ended_by"] == "samples"
    assert png_pixels("a.png") == png_pixels("b.png")
    none = ok("render", "head.nrrd", "-o", "c.png", *SMALL, "--budget", "0.000001s", "--json").json
    assert none["passes"] == 1 and none["ended_by"] == "budget"


def test_a_picture_carries_scene_version_seed_and_checksums():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", *SMALL, "--set", "seed=7")
    text = png_text("a.png")
    assert text["Software"].startswith("VolVis ")
    assert text["VolVis:Seed"] == "7" and "crc32:" in text["VolVis:Data"]
    scene = json.loads(text["VolVis:Scene"])
    assert scene["seed"] == 7
    (dataset,) = scene["datasets"].values()
    assert dataset["path"] == "head.nrrd" and dataset["checksum"].startswith("crc32:")
    (volume,) = scene["volumes"].values()
    assert volume["segmentation"]["transfer"]["opacity"]
    says(ok("info", "a.png").text, "picture with a scene")


def test_changed_data_is_noticed_when_a_picture_is_repeated():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", *SMALL)
    with open("head.nrrd", "r+b") as file:
        file.seek(-1, os.SEEK_END)
        file.write(b"\x77")
    said = fails(3, "render", "a.png", "-o", "b.png")
    says(said, "crc32", "head.nrrd")
    assert not os.path.exists("b.png")


def test_data_that_moved_or_changed_are_said_with_what_to_do():
    write_ball("a.nrrd", 8)
    write_ball("c.nrrd", 9)
    ok("render", "a.nrrd", "-o", "moved.png", "--size", "16x16")
    os.rename("a.nrrd", "b.nrrd")
    picked = ["pick", "moved.png", "--pixel", "8,8"]
    statistics = ["measure", "statistics", "moved.png"]
    for words in picked, statistics, ["render", "moved.png", "-o", "x.png"]:
        says(fails(3, *words), "moved.png: was made from 'a.nrrd', crc32:", "not there any more", "--set datasets.a.path=FILE")
        if words[0] != "render":
            ok(*words, "--set", "datasets.a.path=b.nrrd")
        says(fails(3, *words, "--set", "datasets.a.path=d.nrrd"), "moved.png: --set datasets.a.path: there is no 'd.nrrd'")
    for words in ["isosurface", "moved.png", "-o", "x.stl"], ["gaussian", "moved.png", "-o", "x.nrrd", "--sigma", "1mm"]:
        said = fails(3, *words)
        says(said, "'a.nrrd'", "name the file itself, where it is now")
        assert "--set" not in said
    said = ok("info", "moved.png").message
    says(said, "moved.png: was made from 'a.nrrd', crc32:", "not there any more", "--set datasets.a.path=FILE")
    os.rename("c.nrrd", "a.nrrd")
    assert "not there" not in ok("info", "moved.png").message
    for words in picked, ["render", "moved.png", "-o", "x.png"]:
        says(fails(3, *words), "samples of crc32:", "those of 'a.nrrd' are others now", "--set datasets.a.checksum=null")
        ok(*words, "--set", "datasets.a.checksum=null")
    says(fails(3, "isosurface", "moved.png", "-o", "x.stl"), "others now", "name the file itself")


def test_a_picture_of_another_program_is_a_slice():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", *SMALL)
    data = contents("a.png")
    with open("plain.png", "wb") as file:
        file.write(data[:8])
        at = 8
        while at < len(data):
            length = int.from_bytes(data[at : at + 4], "big")
            if data[at + 4 : at + 8] in (b"IHDR", b"IDAT", b"IEND"):
                file.write(data[at : at + length + 12])
            at += length + 12
    info = ok("info", "plain.png", "--json").json
    assert info["format"] == "slices" and info["dims"][2] == 1 and info["components"] >= 3, info
    ok("render", "plain.png", "-o", "b.png", *SMALL)
    ok("convert", "plain.png", "-o", "b.nrrd")
    assert ok("info", "b.png", "--json").json["format"] != "slices"  # what VolVis made of it is a scene
    with open("plain.png", "rb") as file:
        says(volvis("info", "-", stdin=file.read()).message, "it was not made by VolVis")
    with open("cut.png", "wb") as file:
        file.write(contents("plain.png")[:100])
    says(fails(3, "info", "cut.png"), "cut short")
    with open("plain.pfm", "wb") as file:
        file.write(b"Pf\n2 2\n-1.0\n" + bytes(16))
    says(fails(3, "render", "plain.pfm", "-o", "b.png"), "it was not made by VolVis")
    ok("compare", "a.png", "plain.png")  # pictures are still compared as pictures


def test_few_slices_are_seen_face_on():
    faces = (("right", "front", "bottom"), ("left", "front", "bottom"))
    for space, views in zip(("", "space: right-anterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"), faces):
        for axis, view in enumerate(views):
            sizes = [4 if a == axis else 40 + 5 * a for a in range(3)]
            header = f"NRRD0004\ntype: uint8\ndimension: 3\n{space}sizes: {' '.join(map(str, sizes))}\nencoding: raw\n\n"
            with open("flat.nrrd", "wb") as file:
                file.write(header.encode())
                file.write(bytes(i * i // 7 % 256 for i in range(sizes[0] * sizes[1] * sizes[2])))
            ok("render", "flat.nrrd", "-o", "a.png", *SMALL)
            ok("render", "flat.nrrd", "-o", "b.png", "--view", view, *SMALL)
            assert png_pixels("a.png") == png_pixels("b.png"), (space, view)
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", *SMALL)
    ok("render", "head.nrrd", "-o", "b.png", "--view", "30,15", *SMALL)
    assert png_pixels("a.png") == png_pixels("b.png")


def test_a_saved_scene_gives_the_same_picture():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", *SMALL, "--tf", "magma", "--view", "top", "--save-scene", "a.vv.json")
    ok("render", "a.vv.json", "-o", "b.png")
    assert png_pixels("a.png") == png_pixels("b.png")
    ok("render", "a.vv.json", "-o", "c.png", "--save-scene", "b.vv.json")
    assert contents("a.vv.json") == contents("b.vv.json")


def test_scene_and_data_move_together():
    os.mkdir("one")
    write_ball("one/head.nrrd")
    ok("render", "one/head.nrrd", "-o", "one/a.png", *SMALL, "--save-scene", "one/a.vv.json")
    shutil.move("one", "two")
    ok("render", "two/a.vv.json", "-o", "b.png")
    ok("render", "two/a.png", "-o", "c.png")
    assert png_pixels("two/a.png") == png_pixels("b.png") == png_pixels("c.png")


def test_a_scene_or_picture_stands_for_its_data():
    write_ball()
    os.mkdir("c")
    ok("render", "head.nrrd", "-o", "c/c.png", *SMALL, "--save-scene", "c/c.vv.json")
    for name in ("c/c.png", "c/c.vv.json"):
        ok("convert", name, "-o", "x.nrrd")
        assert ok("compare", "head.nrrd", "x.nrrd", "--json").json["identical"], name
        ok("gaussian", name, "-o", "y.nrrd")
        ok("gaussian", "head.nrrd", "-o", "z.nrrd")
        assert ok("compare", "y.nrrd", "z.nrrd", "--json").json["identical"], name
        says(fails(2, "convert", name, "-o", "head.nrrd"), "--overwrite")
    with open("plain.vv.json", "w", encoding="utf-8") as file:
        json.dump({"schema": 1}, file)
    says(fails(3, "convert", "plain.vv.json", "-o", "x.nrrd"), "no data from a file")


def test_pixels_of_a_picture_are_taken_when_that_is_said():
    write_ball("head.nrrd", 8)
    for name, word in ("a.png", "slices"), ("a.tif", "tiff"):
        ok("render", "head.nrrd", "-o", name, "--size", "30x20")
        said = ok("convert", name, "-o", "x.npy", "--overwrite").message
        says(said, f"{name}: taken are the data of the scene in this picture, head.nrrd", f"--input-format {word}")
        assert "taken are" not in ok("gaussian", name, "-o", "y.npy", "--overwrite", "--quiet").message
        assert "taken are" not in ok("measure", "statistics", name).message
        assert "taken are" not in ok("convert", name, "-o", "x.nrrd", "--overwrite", "--input-format", word).message
        assert ok("info", "x.nrrd", "--json").json["dims"] == [30, 20, 1]
    assert "taken are" not in ok("convert", "head.nrrd", "-o", "x.npy", "--overwrite").message


def test_a_picture_stands_for_the_time_step_and_layout_that_it_shows():
    with open("film.raw", "wb") as file:
        file.write(bytes(i % 251 for i in range(8 * 8 * 8)))
    ok("render", "film.raw", "--raw", "8x8x8,u8", "-o", "c.png", *SMALL)
    ok("convert", "c.png", "-o", "x.nrrd")
    assert ok("info", "x.nrrd", "--json").json["dims"] == [8, 8, 8]
    header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 4 4 3\nkinds: domain domain domain time\nencoding: raw\n\n"
    with open("film.nrrd", "wb") as file:
        file.write(header.encode() + bytes(t * 10 + i % 3 for t in range(3) for i in range(64)))
    ok("render", "film.nrrd@2", "-o", "c.png", *SMALL)
    ok("convert", "c.png", "-o", "x.nrrd")
    ok("convert", "c.png@1", "-o", "y.nrrd")
    assert ok("info", "x.nrrd", "--stats", "--json").json["max"] == 22
    assert ok("info", "y.nrrd", "--stats", "--json").json["max"] == 12


def test_scenes_and_pictures_come_by_standard_input_too():
    write_ball()
    ok("render", "head.nrrd", "-o", "c.png", *SMALL, "--tf", "magma", "--save-scene", "c.vv.json")
    for name in ("c.png", "c.vv.json"):
        ok("render", "-", "-o", "x.png", stdin=contents(name))
        assert png_pixels("x.png") == png_pixels("c.png"), name
        ok("convert", "-", "-o", "x.nrrd", stdin=contents(name))
        assert ok("compare", "head.nrrd", "x.nrrd", "--json").json["identical"], name
        with open(name, "rb") as file:
            done = subprocess.run([VOLVIS, "convert", "-", "-o", "y.nrrd"], stdin=file, env=environment(), check=False)
        assert done.returncode == 0 and ok("compare", "head.nrrd", "y.nrrd", "--json").json["identical"], name
    ok("convert", "-", "-o", "x.nrrd", "--raw", "4x4x4,u8", stdin=b"{" * 64)


def test_every_property_can_be_set():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", "--size", "16x16", "--save-scene", "a.vv.json")
    world = json.loads(contents("a.vv.json"))
    volume, light, view = (next(iter(world[k])) for k in ("volumes", "lights", "views"))
    paths = [line.split("`")[1] for line in ok("reference").text.split("## Properties of a World")[1].splitlines()
             if line.startswith("| `")]
    names = {"volumes": volume, "lights": light, "views": view, "datasets": next(iter(world["datasets"]))}
    tried = 0
    for path in paths:
        parts = path.split(".")
        parts = [names.get(parts[i - 1], "x") if p == "ID" else p for i, p in enumerate(parts)]
        real = ".".join(parts)
        if real.endswith(".path"):
            continue  # without it there is no data to show
        result = volvis("render", "head.nrrd", "-o", "b.png", "--dry-run", "--size", "16", "--set", f"{real}=null")
        assert result.code == 0 or ("cut_planes" in real and "counted from 0" in result.message) or (
            real == "views" and "no longer has a view" in result.message) or (
            real == "datasets" and "there is no dataset" in result.message), (real, result.message)
        tried += 1
    assert tried > 60, tried


def test_values_are_set_by_path():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", *SMALL, "--save-scene", "a.vv.json", "--set", "background=#102030", "--set",
       "title=two words", "--set", "views.main.camera.fov=33deg", "--set", "lights.key.color=[1, 0.5, 0]", "--set",
       "views.main.camera.eye=100,20,30")
    scene = json.loads(contents("a.vv.json"))
    assert scene["background"] == "#102030" and scene["title"] == "two words"
    assert abs(scene["views"]["main"]["camera"]["fov"] - 33) < 1e-9
    assert scene["views"]["main"]["camera"]["eye"] == [100, 20, 30]


def test_short_forms_change_the_picture():
    write_ball()
    ok("render", "head.nrrd", "-o", "plain.png", *SMALL)
    plain = png_pixels("plain.png")
    for extra in (["--mode", "maximum"], ["--iso", "128"], ["--threshold", "100,200"], ["--tf", "inferno"],
                  ["--tf", "0:0 100:0.5#ff0000"], ["--range", "100,200", "--tf", "fog"],
                  ["--percentile", "50,99", "--tf", "fog"], ["--clip", "x:16.."],
                  ["--clip", "plane(n=1,1,0 d=22mm)"], ["--view", "top", "--clip", "z:..12"],
                  ["--background", "#fff"], ["--no-shading"], ["--fov", "40deg", "--eye", "90,20,20", "--at", "16,16,16"],
                  ["--parallel", "20"], ["--view", "30,20,10"], ["--set", "lights.key.intensity=3"]):
        ok("render", "head.nrrd", "-o", "a.png", *SMALL, *extra)
        assert png_pixels("a.png") != plain, extra


def test_the_short_form_of_a_property_is_the_property():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", *SMALL, "--mode", "maximum", "--fov", "30", "--background", "red")
    ok("render", "head.nrrd", "-o", "b.png", "--set", "views.main.width=64", "--set", "views.main.height=48", "--set",
       "views.main.render.raycast.mode=maximum", "--set", "views.main.camera.fov=30", "--set", "background=red")
    assert png_pixels("a.png") == png_pixels("b.png")


def test_opacity_by_length_is_the_same_at_any_step():
    write_ball()
    for step, name in (("1vox", "a.png"), ("0.25vox", "b.png")):
        ok("render", "head.nrrd", "-o", name, *SMALL, "--tf", "0:0 255:0.2#fff", "--no-shading", "--step", step)
    assert volvis("compare", "a.png", "b.png", "--psnr", "40").code == 0


def test_a_transfer_function_may_be_a_file():
    write_ball()
    with open("tf.json", "w", encoding="utf-8") as file:
        json.dump({"opacity": [[0, 0], [255, 0.5]], "color": [[0, 1, 0, 0], [255, 1, 1, 1]], "opacity_length": 1}, file)
    ok("render", "head.nrrd", "-o", "a.png", *SMALL, "--tf", "tf.json")
    with open("bad.json", "w", encoding="utf-8") as file:
        file.write('{"opacty": []}')
    says(fails(3, "render", "head.nrrd", "-o", "b.png", "--tf", "bad.json"), "bad.json", "opacity")


def test_sixteen_bits_and_transparency_are_in_the_file():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", *SMALL, "--bits", "16", "--background", "transparent")
    header = dict(png_chunks("a.png"))["IHDR"]
    assert header[8] == 16 and header[9] == 6


def test_a_picture_may_go_to_standard_output():
    write_ball()
    result = ok("render", "head.nrrd", "-o", "-", *SMALL)
    with open("a.png", "wb") as file:
        file.write(result.out)
    ok("render", "head.nrrd", "-o", "b.png", *SMALL)
    assert png_pixels("a.png") == png_pixels("b.png")
    fails(2, "render", "head.nrrd", "-o", "-", "--json")


def test_threads_do_not_change_a_picture():
    write_ball()
    for n in (1, 2, 3):
        ok("render", "head.nrrd", "-o", f"{n}.png", *SMALL, "--threads", n)
    assert contents("1.png") == contents("2.png") == contents("3.png")


def test_repeating_reports_a_median_and_the_same_picture():
    write_ball()
    answer = ok("render", "head.nrrd", "-o", "a.png", *SMALL, "--repeat", "3", "--json").json
    ok("render", "head.nrrd", "-o", "b.png", *SMALL)
    assert answer["render_s"] > 0 and contents("a.png") == contents("b.png")


def test_compare_measures_pictures():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", *SMALL)
    ok("render", "head.nrrd", "-o", "b.png", *SMALL, "--set", "lights.key.intensity=0.5")
    ok("render", "head.nrrd", "-o", "c.png", "--size", "32x32")
    answer = ok("compare", "a.png", "b.png", "--json").json
    assert {"psnr", "ssim", "flip_mean", "max_difference"} <= set(answer) and answer["psnr"] > 15
    assert ok("compare", "a.png", "a.png", "--json").json["identical"]
    assert volvis("compare", "a.png", "b.png", "--psnr", "99").code == 6
    assert volvis("compare", "a.png", "b.png", "--max-difference", "0").code == 6
    assert volvis("compare", "a.png", "c.png").code == 6
    ok("compare", "a.png", "b.png", "--flip", "0.5", "--ssim", "0.1")


def test_a_dry_run_makes_nothing_and_tells_memory_and_time():
    write_ball()
    answer = ok("render", "head.nrrd", "-o", "a.png", "--dry-run", "--json").json
    assert answer["width"] == 800 and answer["memory_bytes"] >= 800 * 800 * 20 + 32**3 + 2**21 and not os.path.exists("a.png")
    assert 0 < answer["estimated_render_s"] < answer["estimated_s"]
    for words in (["--quality", "draft"], ["--iso", "90", "--method", "surface"], ["--budget", "0.01s"]):
        assert 0 < ok("render", "head.nrrd", "-o", "a.png", "--dry-run", "--json", *words).json["estimated_s"], words


def test_a_picture_larger_than_memory_is_made_part_by_part():
    write_ball()
    large = ("render", "head.nrrd", "--size", "700x900")
    at_once = ok(*large, "-o", "once.png", "--json").json
    parts = ok(*large, "-o", "parts.png", "--memory", "20M", "--json").json
    assert parts["in_parts"] and not at_once["in_parts"] and parts["passes"] == at_once["passes"], (parts, at_once)
    assert parts["peak_bytes"] < 20 << 20 < at_once["peak_bytes"], (parts, at_once)
    assert ok("compare", "once.png", "parts.png", "--json").json["identical"]
    ok("render", "parts.png", "-o", "again.png")  # its recipe stands before its pixels
    assert ok("compare", "parts.png", "again.png", "--json").json["identical"]
    assert ok(*large, "-o", "a.png", "--memory", "20M", "--dry-run", "--json").json["in_parts"]
    for word, *options in (["PNG", "-o", "a.jpg"], ["decorations", "-o", "a.png", "--decorate", "axes"], ["noise", "-o", "a.png", "--noise", "1%"]):
        for more in ([], ["--dry-run"]):  # which says it, too
            says(fails(4, *large, "--memory", "20M", *options, *more), word, "--memory")


def test_what_needs_all_of_a_picture_that_is_too_large_says_what_to_do():
    write_ball()
    with open("box.ply", "w", encoding="ascii") as file:
        file.write("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\n"
                   "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n")
    for said, *words in (["--resume", "head.nrrd", "-o", "a.png", "--resume", "a.part"], ["--repeat", "head.nrrd", "-o", "a.png", "--repeat", "2"],
                         ["PNG", "head.nrrd", "-o", "a.svg"], ["a file", "head.nrrd", "-o", "-", "--output-format", "png"],
                         ["decorations", "head.nrrd", "-o", "a.png", "--decorate", "axes"], ["noise", "head.nrrd", "-o", "a.png", "--noise", "1%"],
                         ["PNG", "head.nrrd", "-o", "a.exr"], ["layers", "head.nrrd", "-o", "a.png", "--aov", "depth"],
                         ["method raycast", "box.ply", "-o", "a.png"]):
        for more in ([], ["--dry-run"]):
            says(fails(4, "render", *words, "--size", "2000", "--memory", "40M", *more), said, "give more with --memory")
    ok("render", "box.ply", "-o", "a.png", "--size", "2000", "--memory", "40M", "--method", "raycast")


def test_a_dry_run_tells_times_as_people_do():
    write_ball()
    for options, unit in (["--size", "1000", "--spp", "4096", "--quality", "high"], "min"), (["--size", "8"], "s"):
        said = ok("render", "head.nrrd", "-o", "a.png", "--dry-run", *options).text.split("takes", 1)[1]
        assert "e+" not in said and re.match(r"\s*about [0-9.]+ " + unit + r" on ", said), said


def test_too_little_memory_for_a_picture_is_said():
    write_ball()
    says(fails(4, "render", "head.nrrd", "-o", "a.png", "--size", "30000x4000", "--memory", "10M"), "--memory")
    assert not os.path.exists("a.png")


def test_a_head_of_a_real_person_is_seen():
    if not os.path.exists(HEAD_MRI):
        raise Skip("mricron-data is not installed")
    ok("render", HEAD_MRI, "-o", "a.png", "--size", "128x128")
    ok("render", HEAD_MRI, "-o", "back.png", "--size", "128x128", "--view", "back")
    assert len(set(png_pixels("a.png"))) > 32 and png_pixels("a.png") != png_pixels("back.png")


main()
