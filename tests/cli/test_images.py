"""Image formats and layers, checked by readers of others: Pillow, numpy, and the one of exr.py."""
import json
import math
import os
import struct
import numpy
from PIL import Image
import exr
from harness import Skip, fails, main, ok, png_pixels, png_text, says, volvis, write_ball, write_cells, write_nrrd

SMALL = ["--size", "65x33"]


def has(name):
    for row in ok("formats", "--json").json["images"]:
        if row["name"] == name:
            return row["writes"]
    return False


def need(name):
    if not has(name):
        raise Skip(f"built without {name}")


def pfm(path):
    with open(path, "rb") as file:
        kind, size, scale, data = file.read().split(b"\n", 3)
    width, height = map(int, size.split())
    assert float(scale) < 0
    shape = (height, width, 3) if kind == b"PF" else (height, width)
    return numpy.frombuffer(data, "<f4").reshape(shape)[::-1]


def srgb(linear):
    v = numpy.clip(linear, 0, 1)
    return numpy.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)


def test_a_jpeg_shows_what_the_png_shows():
    need("jpeg")
    try:
        from PIL import Image
    except ImportError:
        raise Skip("no python3-pil") from None
    write_ball()
    ok("render", "head.nrrd", "-o", "a.pfm", *SMALL)
    ok("render", "head.nrrd", "-o", "a.jpg", *SMALL, "--image-quality", "100")
    with Image.open("a.jpg") as image:
        assert image.size == (65, 33) and image.mode == "RGB"
        assert [layer[1:3] for layer in image.layer] == [(1, 1)] * 3, "colours are not at full resolution"
        pixels = numpy.asarray(image, float)
    differences = numpy.abs(pixels - 255 * srgb(pfm("a.pfm")))
    assert differences.mean() < 0.5 and differences.max() < 6, "more than what YCbCr and a DCT in whole numbers take"
    ok("render", "head.nrrd", "-o", "b.jpeg", *SMALL, "--image-quality", "20")
    assert os.path.getsize("b.jpeg") < os.path.getsize("a.jpg")


def test_an_exr_is_linear_and_holds_layers():
    need("exr")
    write_ball()
    ok("render", "head.nrrd", "-o", "a.pfm", *SMALL, "--background", "#203040", "--spp", "1")
    answer = ok("render", "head.nrrd", "-o", "a.exr", *SMALL, "--background", "#203040", "--bits", "32", "--aov",
                "depth,normal,id,samples,value", "--json").json
    assert answer["layers"] == {name: "a.exr" for name in ("depth", "normal", "id", "samples", "value")}
    attributes, planes = exr.read("a.exr")
    assert attributes["compression"] == ("compression", b"\x03") and attributes["VolVis:Scene"][0] == "string"
    assert json.loads(attributes["VolVis:Scene"][1])["views"]
    for c, name in enumerate("RGB"):
        assert planes[name].dtype == numpy.float32 and (planes[name] == pfm("a.pfm")[:, :, c]).all()
    assert (planes["A"] == 1).all() and (planes["samples"] == 1).all() and planes["id"].dtype == numpy.uint32
    hit = numpy.isfinite(planes["Z"])
    assert 100 < hit.sum() < hit.size
    ok("render", "head.nrrd", "-o", "half.exr", *SMALL)
    half = exr.read("half.exr")[1]
    assert sorted(half) == ["A", "B", "G", "R"] and half["R"].dtype == numpy.float16


def test_transparency_is_kept_by_png_and_exr_and_told_by_the_others():
    write_ball()
    clear = [*SMALL, "--background", "transparent"]
    if has("exr"):
        ok("render", "head.nrrd", "-o", "a.exr", *clear)
        alpha = exr.read("a.exr")[1]["A"]
        assert alpha.min() == 0 and alpha.max() > 0.5
        assert all((exr.read("a.exr")[1][c][alpha == 0] == 0).all() for c in "RGB")
    for name in ["a.pfm"] + (["a.jpg"] if has("jpeg") else []):
        says(ok("render", "head.nrrd", "-o", name, *clear).message, "no transparency", "black")


def test_every_picture_with_text_repeats_itself():
    write_ball()
    for suffix in [s for f, s in (("jpeg", "jpg"), ("exr", "exr")) if has(f)]:
        ok("render", "head.nrrd", "-o", "a.png", *SMALL, "--tf", "viridis", "--view", "30,20", "--background", "#204060")
        ok("render", "a.png", "-o", f"a.{suffix}")
        ok("render", f"a.{suffix}", "-o", "b.png")
        assert png_pixels("a.png") == png_pixels("b.png"), suffix
        a, b = png_text("a.png"), png_text("b.png")
        assert a["VolVis:Scene"] == b["VolVis:Scene"]
        ok("compare", "a.png", f"a.{suffix}", "--psnr", "30")


def test_layers_lie_beside_a_picture_that_cannot_hold_them():
    write_ball()
    answer = ok("render", "head.nrrd", "-o", "a.png", *SMALL, "--aov", "depth,id", "--json").json
    assert answer["layers"] == {"depth": "a.depth.pfm", "id": "a.id.pfm"}
    assert pfm("a.depth.pfm").shape == (33, 65)
    ok("render", "a.png", "-o", "b.png")
    assert os.path.exists("b.depth.pfm") and os.path.exists("b.id.pfm")
    ok("render", "a.png", "-o", "c.png", "--aov", "none")
    assert not os.path.exists("c.depth.pfm")
    ok("render", "head.nrrd", "-o", "d.png", *SMALL, "--set", "views.main.render.layers.samples=true")
    assert (pfm("d.samples.pfm") == 1).all()


def test_odd_sizes_are_written():
    write_ball()
    for size in ("1x1", "1x7", "7x1"):
        for suffix in ["png", "pfm"] + [s for f, s in (("jpeg", "jpg"), ("exr", "exr")) if has(f)]:
            ok("render", "head.nrrd", "-o", f"a.{suffix}", "--size", size, "--aov", "depth,normal")
            ok("compare", f"a.{suffix}", f"a.{suffix}", "--max-difference", "0")


def test_wrong_words_about_pictures_are_told():
    write_ball()
    says(fails(2, "render", "head.nrrd", "-o", "a.png", "--aov", "deph"), "depth")
    says(fails(2, "render", "head.nrrd", "-o", "a.png", "--bits", "32"), "8 or 16")
    says(fails(2, "render", "head.nrrd", "-o", "a.pfm", "--bits", "16"), "32")
    fails(2, "render", "head.nrrd", "-o", "a.jpg", "--image-quality", "0")
    assert not os.path.exists("a.png") and not os.path.exists("a.pfm")


def test_picking_finds_the_ball():
    write_ball()
    view = ["--iso", "100", "--view", "front", "--size", "65x33"]
    answer = ok("pick", "head.nrrd", *view, "--pixel", "32,16", "--pixel", "0,0", "--json").json
    ball, nothing = answer["pixels"]
    assert ball["hit"] and ball["volume"] == "head" and ball["id"] == 1 and abs(ball["value"] - 100) < 1
    assert ball["normal"][1] > 0.99 and abs(ball["world"][0] - 15.5) < 1 and answer["unit"] == "mm"
    assert nothing == {"x": 0, "y": 0, "hit": False}
    says(ok("pick", "head.nrrd", *view, "--pixel", "32,16", "--pixel", "0,0").text, "head", "nothing there")
    ok("render", "head.nrrd", "-o", "a.png", *view, "--aov", "depth,normal,id,value")
    assert ok("pick", "a.png", "--pixel", "32,16", "--json").json["pixels"][0] == ball
    assert abs(pfm("a.depth.pfm")[16, 32] - ball["depth"]) < 1e-4 and pfm("a.id.pfm")[16, 32] == 1
    assert abs(pfm("a.normal.pfm")[16, 32] - ball["normal"]).max() < 1e-6
    says(fails(2, "pick", "head.nrrd", *view, "--pixel", "65,0"), "65 x 33")
    says(fails(2, "pick", "head.nrrd", "--pixel", "here"), "X,Y")
    says(fails(2, "pick", "head.nrrd"), "--pixel")


def test_decorations_are_drawn_kept_in_the_scene_and_taken_away():
    write_ball()
    size = ["--iso", "100", "--size", "128x96"]
    ok("render", "head.nrrd", "-o", "plain.png", *size)
    ok("render", "head.nrrd", "-o", "a.png", *size, "--decorate", "cube,scale-bar,legend", "--title", "A ball of {unit}", "--caption", "{dims}")
    plain, drawn = png_pixels("plain.png"), png_pixels("a.png")
    assert plain != drawn
    ok("render", "a.png", "-o", "again.png")
    assert png_pixels("again.png") == drawn
    ok("render", "a.png", "-o", "none.png", "--decorate", "none")
    assert png_pixels("none.png") == plain
    ok("render", "head.nrrd", "-o", "all.png", *size, "--decorate", "all", "--aov", "depth")
    says(fails(2, "render", "head.nrrd", "-o", "b.png", "--decorate", "cubes"), "cubes", "cube")
    says(fails(2, "render", "head.nrrd", "-o", "b.png", "--decorate", "cube,,box"), "--decorate")
    for words, alone in (("none,cube", "none"), ("cube,all", "all")):
        says(fails(2, "render", "head.nrrd", "-o", "b.png", "--decorate", words), "--decorate", f"'{alone}' stands alone")
    for factor in ("0.1", "10"):
        ok("render", "head.nrrd", "-o", "sizes.png", *size, "--decorate", "all", "--title", "A ball", "--set", f"views.main.decorations.size={factor}")
    says(fails(2, "render", "head.nrrd", "-o", "b.png", "--set", "views.main.decorations.size=0.05"), "decorations.size", "0.1")
    ok("render", "head.nrrd", "-o", "lines.png", *size, "--caption", "one line\nand\ttwo\r\n\nthree\n")
    ok("render", "head.nrrd", "-o", "blanks.png", *size, "--caption", "one line\nand two \n\nthree")
    assert png_pixels("lines.png") == png_pixels("blanks.png") != plain
    says(fails(2, "render", "head.nrrd", "-o", "b.png", "--caption", "{dimz}"), "{dimz}", "'dims'", "views.main.decorations.caption")
    assert not os.path.exists("b.png")


def test_a_dry_run_with_decorations_tells_enough_memory():
    write_ball()
    for size in ("64x64", "900x700"):
        command = ["render", "head.nrrd", "-o", "much.png", "--iso", "100", "--size", size, "--decorate", "all", "--title", "A ball", "--json"]
        assert ok(*command, "--dry-run").json["memory_bytes"] >= ok(*command).json["peak_bytes"]


def test_volumes_have_modes_of_their_own():
    write_ball("ct.nrrd")
    write_ball("pet.nrrd", n=20)
    look = ("render", "ct.nrrd", "pet.nrrd", "--tf", "pet=inferno", "--range", "pet=40..250", "--size", "64", "--spp", "1", "--overwrite")
    ok(*look, "-o", "clouds.png")
    ok(*look, "-o", "fused.png", "--set", "volumes.pet.rays.mode=maximum")
    ok("render", "ct.nrrd", "--size", "64", "--spp", "1", "-o", "alone.png")
    assert len({png_pixels(f"{name}.png") for name in ("clouds", "fused", "alone")}) == 3
    ok(*look, "-o", "maxima.png", "--mode", "maximum")
    ok(*look, "-o", "by_each.png", "--set", "volumes.ct.rays.mode=mip", "--set", "volumes.pet.rays.mode=maximum")
    assert png_pixels("maxima.png") == png_pixels("by_each.png") != png_pixels("fused.png")
    says(fails(2, *look, "-o", "b.png", "--set", "volumes.pet.rays.mode=maximal"), "volumes.pet.rays.mode", "'maximum'")
    told = ok(*look, "-o", "scene.png", "--set", "volumes.pet.rays.mode=maximum", "--set", "volumes.pet.rays.step=0.5vox").message
    assert "does nothing" not in told, told
    told = ok("render", "ct.nrrd", "--method", "surface", "--size", "64", "-o", "s.png", "--set", "volumes.ct.rays.step=1vox").message
    says(told, "volumes.ct.rays.step does nothing", "surface casts no rays", "--method raycast")
    of_pet = ("--set", "volumes.pet.rays.mode=isosurface", "--set", "volumes.pet.rays.iso=90")
    colored = {}
    for by, words in (("volume", of_pet), ("view", ("--set", "views.main.render.raycast.mode=isosurface")), ("option", ("--mode", "isosurface"))):
        ok(*look[:3], *look[-5:], *words, "-o", "beige.png")
        ok(*look[:3], *look[-5:], *words, "--color", "pet=lightblue", "-o", "blue.png")
        colored[by] = png_pixels("blue.png")
        assert colored[by] != png_pixels("beige.png"), by
    assert colored["view"] == colored["option"] != colored["volume"]
    says(fails(2, *look[:3], "-o", "b.png", "--color", "pet=lightblue"), "--color does nothing to clouds")
    says(fails(2, *look[:3], "-o", "b.png", "--mode", "isosurface", "--iso", "70", "--set", "views.main.render.raycast.mode=maximum"),
         "--iso does nothing in mode maximum")
    says(fails(2, "render", "ct.nrrd", "pet.nrrd", "-o", "b.png", "--iso", "pet=90"), "--iso takes one value", "volumes.pet.rays.mode=isosurface",
         "volumes.pet.rays.iso=90")


def write_colors(path, channels, n=24):
    """A ball whose colour is its place; alpha falls at its skin."""
    z, y, x = numpy.mgrid[:n, :n, :n]
    alpha = numpy.clip((0.4 * n - numpy.sqrt(sum((c - (n - 1) / 2) ** 2 for c in (x, y, z)))) / 3 + 0.5, 0, 1)
    rgb = numpy.stack([60 + 195 * c / (n - 1) for c in (x, y, z)], -1)
    samples = numpy.concatenate([rgb, 255 * alpha[..., None]], -1) if channels == 4 else rgb * alpha[..., None]
    with open(path, "wb") as file:
        file.write((f"NRRD0004\ntype: uint8\ndimension: 4\nspace dimension: 3\nsizes: {channels} {n} {n} {n}\nkinds: "
                    f"{'RGBA' if channels == 4 else 'RGB'}-color domain domain domain\n"
                    "space directions: none (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n\n").encode() + samples.astype(numpy.uint8).tobytes())


def test_solids_of_colours_are_what_isosurfaces_of_them_are():
    size = ["--size", "80", "--spp", "1", "--overwrite"]
    def seen(path, *words):
        ok("render", path, *words, *size, "-o", "a.png")
        return numpy.asarray(Image.open("a.png").convert("RGB"), float)
    for channels in (3, 4):
        write_colors("rgb.nrrd", channels)
        surface, solid = seen("rgb.nrrd", "--iso", "0.2"), seen("rgb.nrrd", "--threshold", "0.2..")
        shown = (surface.sum(axis=2) > 0) & (solid.sum(axis=2) > 0)
        assert shown.sum() > 1000 and abs(surface - solid)[shown].mean() < 4, (channels, abs(surface - solid)[shown].mean())
        assert (solid.max(axis=2) - solid.min(axis=2))[shown].mean() > 25, "one colour"
        ok("render", "rgb.nrrd", "--threshold", "0.2..", *size, "-o", "first.png")
        ok("render", "first.png", "--overwrite", "-o", "again.png")
        assert png_pixels("first.png") == png_pixels("again.png")
        says(ok("render", "rgb.nrrd", "--threshold", "100..", *size, "-o", "a.png").message, "nothing is seen")
        says(ok("render", "rgb.nrrd", "--iso", "0.2", "--method", "surface", *size, "-o", "a.png").message,
             "volumes.rgb: the colours of samples are not drawn", "raycast")
        ok("render", "rgb.nrrd", "--set", "volumes.rgb.component=0", "--threshold", "100..", *size, "-o", "a.png")


def test_paint_by_labels_has_the_colours_of_the_labels():
    """Those that the labels are shown in, from their own table or without one; label 0 leaves the volume's own."""
    label = lambda x, y, z: (x // 6 * 7 + y // 6 * 13 + z // 6 * 5) % 16
    write_ball("head.nrrd", 24)
    write_nrrd("parts.nrrd", (24, 24, 24), label)
    look = ["--no-shading", "--size", "90", "--spp", 1, "--overwrite", "--view", "30,20", "-o", "a.png"]
    def colors(*words):
        ok("render", *words, *look)
        seen, n = numpy.unique(numpy.asarray(Image.open("a.png").convert("RGB")).reshape(-1, 3), axis=0, return_counts=True)
        return {tuple(c) for c, k in zip(seen.tolist(), n) if k > 3} - {(0, 0, 0)}
    beige, red = (0xe6, 0xdc, 0xc8), (255, 0, 0)
    paint = ["--set", 'datasets.parts={"path": "parts.nrrd"}', "--set", 'volumes.head.paint={"data": "parts"}']
    table = ["--set", "volumes.parts.segmentation.labels.table=[[3, 1, 0, 0, 1], [7, 1, 0, 0, 1]]"]
    labels = colors("parts.nrrd", "--set", "volumes.parts.segmentation.labels.opacity=1")
    assert len(labels) > 10, labels
    for surface in (["--iso", 60], ["--threshold", "60.."]):
        painted = colors("head.nrrd", *surface, *paint)
        assert beige in painted and len(painted) > 8 and painted - {beige} <= labels, (painted, labels)
        ok("render", "head.nrrd", *surface, *paint, *look)
        ok("render", "a.png", "-o", "b.png", "--overwrite")
        assert png_pixels("a.png") == png_pixels("b.png")
        both = colors("head.nrrd", "parts.nrrd", *(surface if surface[0] == "--iso" else ["--threshold", "head=60.."]), *table,
                      "--set", 'volumes.head.paint={"data": "parts"}', "--set", "volumes.parts.visible=false")
        assert red in both and beige in both and both - {red} < painted, both
    assert not colors("head.nrrd", "--iso", 60, *paint, "--set", "volumes.head.paint.colormap=gray") & (labels - {beige})


def test_means_of_something_small_are_seen_at_once():
    """Seven voxels among eight million, beside the lines by which the brightness is found first."""
    n = 200
    data = bytearray(n ** 3)
    for dx, dy, dz in ((0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)):
        data[((56 + dz) * n + 134 + dy) * n + 73 + dx] = 200
    with open("speck.nrrd", "wb") as file:
        file.write(f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {n} {n} {n}\nencoding: raw\n\n".encode() + data)
    write_ball("ct.nrrd")
    for words in (["--mode", "mean"], ["--mode", "sum"], ["--set", "volumes.speck.rays.mode=mean"]):
        ok("render", "speck.nrrd", *words, "--view", "front", "--parallel", n, "--size", "300", "-o", "a.png", "--overwrite")
        assert max(Image.open("a.png").convert("L").tobytes()) > 100, words


def test_a_layer_is_picked_where_it_hides_half():
    write_ball("ct.nrrd")
    write_ball("pet.nrrd")
    look = ("pick", "ct.nrrd", "pet.nrrd", "--range", "pet=40..250", "--size", "64", "--pixel", "32,32", "--json")
    for opacity, volume in ((1, "pet"), (0.3, "ct")):
        picked = ok(*look, "--set", f'volumes.pet.rays={{"mode": "maximum", "opacity": {opacity}}}').json
        assert [hit["volume"] for hit in picked["pixels"]] == [volume], picked


def test_all_channels_are_seen_as_maxima():
    write_cells()
    look = ("render", "cells.nrrd", "--size", "64", "--spp", "1", "--overwrite")
    ok(*look, "--mode", "maximum", "-o", "both.png")
    says(ok(*look, "--iso", "500", "-o", "iso.png").message, "no surface of all channels")
    for hidden in ("volumes.cells_0", "volumes.cells_1"):
        ok(*look, "--mode", "maximum", "-o", "one.png", "--set", f"{hidden}.visible=false")
        assert png_pixels("one.png") != png_pixels("both.png"), hidden


def test_a_dry_run_counts_the_light_volume():
    write_ball()
    command = ("render", "head.nrrd", "-o", "a.png", "--overwrite", "--size", "64", "--json")
    plain = ok(*command, "--dry-run").json["memory_bytes"]
    assert ok(*command, "--mode", "maximum", "--dry-run").json["memory_bytes"] == plain
    for lighting in (["--lighting", "cinematic"], ["--shadows"], ["--ambient-occlusion"]):
        planned, taken = ok(*command, *lighting, "--dry-run").json["memory_bytes"], ok(*command, *lighting).json["peak_bytes"]
        assert planned > plain and planned >= taken, (lighting, planned, taken)


def test_a_dry_run_tells_about_what_a_picture_takes():
    write_ball(n=8)
    for words in ([], ["--quality", "draft"], ["--slice", "axial"], ["--noise", "1%"], ["--iso", "100", "--method", "surface"],
                  ["--aov", "depth,normal", "--quality", "high"]):
        command = ["render", "head.nrrd", "-o", "much.png", "--overwrite", "--size", "800", "--json", *words]
        planned, taken = ok(*command, "--dry-run").json["memory_bytes"], ok(*command).json["peak_bytes"]
        assert taken <= planned <= 1.3 * taken + (7 << 20), (words, planned, taken)
        if not words:  # colour and depth, and the colours of a pass
            assert taken < 800 * 800 * 37 + (4 << 20), taken


def test_methods_of_triangles_show_the_ball():
    write_ball()
    size = ["--iso", "100", "--size", "65x33", "--view", "front"]
    rays = ok("pick", "head.nrrd", *size, "--pixel", "32,16", "--json").json["pixels"][0]
    for method in ("surface", "reduced", "boxes"):
        found = ok("pick", "head.nrrd", *size, "--method", method, "--pixel", "32,16", "--pixel", "0,0", "--json").json["pixels"]
        assert found[0]["hit"] and not found[1]["hit"] and found[0]["volume"] == "head"
        assert abs(found[0]["depth"] - rays["depth"]) < (0.1 if method == "surface" else 8)
        ok("render", "head.nrrd", "-o", method + ".png", *size, "--method", method, "--spp", "8", "--background", "transparent")


def test_a_transfer_function_that_is_one_jump_parts_values_of_any_type():
    """A sphere of radius 10.5 in a ramp; all nodes at one value, up and down, and the same with nodes further out."""
    z, y, x = numpy.mgrid[:32, :32, :32] - 15.5
    ramp = numpy.clip(1 - numpy.sqrt(x * x + y * y + z * z) / 21, 0, 1)
    inside = "{0}:0#f80 {0}:0.4#08f", "0:0#f80 {0}:0#f80 {0}:0.4#08f {1}:0.4#08f"
    outside = "{0}:0.4#f80 {0}:0#08f", "0:0.4#f80 {0}:0.4#f80 {0}:0#08f {1}:0#08f"
    size = ("--size", "32x32", "--overwrite", "--set", "views.main.camera.fit=data")
    for kind, top in (("f4", 1), ("f8", 1), ("i4", 10**6), ("u4", 3 * 10**9), ("u2", 40000), ("u1", 200)):
        numpy.save("ramp.npy", (ramp * top).astype(kind))
        for nodes in (inside, outside):
            for more in (["--quality", "normal"], ["--quality", "high"], ["--mode", "maximum"], ["--slice", "axial"],
                         ["--quality", "draft"]):
                pictures = []
                if more[0] == "--slice":
                    more = [*more, "--set", "volumes.ramp.slices.colors=transfer"]
                for tf in nodes:
                    lit = ["--no-shading"] if more[0] == "--quality" else []
                    ok("render", "ramp.npy", "-o", "a.exr", "--bits", "32", "--background", "transparent", *lit, "--tf",
                       tf.format(top // 2 if top > 1 else 0.5, top), *size, *more)
                    pictures.append(numpy.stack([exr.read("a.exr")[1][c] for c in "RGBA"]))
                one, other = pictures
                assert numpy.abs(one - other).max() < 0.02, (kind, nodes[0], more, numpy.abs(one - other).max())
                assert one[3].max() > 0.9 and (more[0] != "--quality" or (one[3] == 0).mean() > 0.2), (kind, nodes[0], more)


def test_paint_may_be_one_jump():
    numpy.save("fog.npy", numpy.full((9, 9, 9), 1, "f4"))
    numpy.save("ramp.npy", numpy.broadcast_to(numpy.arange(9, dtype="f4") / 8, (9, 9, 9)).copy())
    ok("render", "fog.npy", "-o", "a.exr", "--bits", "32", "--background", "black", "--no-shading", "--size", "32x32",
       "--tf", "0:0.9 1:0.9", "--view", "front", "--set", 'datasets.ramp={"path": "ramp.npy"}', "--set",
       'volumes.fog.paint={"data": "ramp", "color": [[0.5, 1, 0, 0], [0.5, 0, 0, 1]]}')
    picture = exr.read("a.exr")[1]
    for column, seen, unseen in ((12, "R", "B"), (20, "B", "R")):
        assert picture[seen][16, column] > 0.99 and picture[unseen][16, column] < 1e-6, column


def octants(ids, kind, path):
    """A ball of eight labels, 0 around it."""
    z, y, x = numpy.mgrid[:20, :20, :20]
    cell = (z > 9) * 4 + (y > 9) * 2 + (x > 9)
    ball = (x - 9.5) ** 2 + (y - 9.5) ** 2 + (z - 9.5) ** 2 < 81
    numpy.save(path, numpy.where(ball, numpy.array(ids, kind)[cell], numpy.array(0, kind)))


def test_labels_may_have_ids_of_any_size():
    small = list(range(1, 9))
    far = [3, 500, 10**6, 127201621, 10**10, 2**40 + 1, 2**53 - 1, 2**53 + 2]
    octants(small, "u2", "small.npy")
    octants(far, "u8", "far.npy")
    for more in (["--set", "volumes.{}.interpolation=linear"], [], ["--slice", "axial"]):
        pictures = []
        for name, ids in (("small", small), ("far", far)):
            table = [[label, i / 8, 1 - i / 8, i % 2, 1] for i, label in enumerate(ids)]
            ok("render", name + ".npy", "-o", "a.png", "--size", "48x48", "--overwrite", "--set",
               f"volumes.{name}.segmentation.kind=labels", "--set", f"volumes.{name}.segmentation.labels.table={json.dumps(table)}",
               *[word.format(name) for word in more])
            pictures.append(png_pixels("a.png"))
        assert pictures[0] == pictures[1] and len(set(pictures[0])) > 8, more


def test_too_many_labels_are_said_with_their_file():
    numpy.save("many.npy", numpy.arange(2**21, dtype="u4").reshape(2, 1024, 1024))
    answer = fails(3, "render", "many.npy", "-o", "a.png", "--set", "volumes.many.segmentation.kind=labels")
    says(answer, "many.npy:volumes.many: more than 1048576 different labels", "kind=transfer")


def test_integers_that_are_labels_are_shown_as_labels():
    octants([5, 90, 2, 60, 31, 7, 44, 18], "u1", "cells.npy")
    z, y, x = numpy.mgrid[:20, :20, :20] - 9.5
    numpy.save("scan.npy", (255 * numpy.clip(1 - numpy.sqrt(x * x + y * y + z * z) / 10, 0, 1)).astype("u1"))
    word = "is shown as labels, of which 9"

    def said(path, *more):
        return ok("render", path, "-o", "a.png", "--size", "48x48", "--overwrite", "-v", *more).message

    assert word in said("cells.npy") and word in said("cells.npy", "--slice", "axial")
    for more in (["--tf", "viridis"], ["--iso", "20"], ["--mode", "maximum"], ["--threshold", "20,"],
                 ["--set", "volumes.cells.segmentation.kind=transfer"], ["--set", "volumes.cells.interpolation=cubic"]):
        assert "shown as labels" not in said("cells.npy", *more), more
    assert "shown as labels" not in said("scan.npy")


def test_a_label_that_is_picked_is_the_id_of_the_file():
    far = [2**60 + 3 * i + 1 for i in range(8)]
    octants(far, "u8", "far.npy")
    for more in ([], ["--set", "volumes.far.interpolation=linear"]):
        answer = ok("pick", "far.npy", "--pixel", "24,24", "--size", "48x48", "--json", "--set",
                    "volumes.far.segmentation.kind=labels", *more).json
        assert any(f"{i}," in json.dumps(answer) or f"{i}}}" in json.dumps(answer) for i in far), answer


def test_other_words_for_a_colour_map_are_saved_by_its_name():
    octants(range(1, 9), "f4", "cells.npy")
    ok("render", "cells.npy", "-o", "a.png", "--size", "16x16", "--overwrite", "--save-scene", "grey.vv.json", "--set",
       "volumes.cells.segmentation.transfer.colormap=grey", "--set", "volumes.cells.slices.colormap=grey")
    with open("grey.vv.json") as file:
        volume = json.load(file)["volumes"]["cells"]
    assert [volume["segmentation"]["transfer"]["colormap"], volume["slices"]["colormap"]] == ["gray", "gray"]


def test_a_steep_part_among_many_values_is_seen_exactly_at_every_quality():
    """From 2000 to 2001 of 4000 values: 10 lengths of one value have the opacity 1 - (1 - o)^10. Values run across the picture."""
    column = [0, 0, 2000, 2001, 4000, 4000]
    x = 2.5 + (numpy.arange(600) + 0.5 - 300) / 100
    steep = (x > 2.02) & (x < 2.98)
    want = 1 - (1 - 0.5 * (x - 2)) ** 10
    for kind in ("i2", "u2", "i4", "f4"):
        numpy.save("steep.npy", numpy.tile(numpy.array(column, kind), (5, 11, 1)))
        for quality in ("normal", "high", "reference"):
            ok("render", "steep.npy", "-o", "steep.exr", "--overwrite", "--bits", "32", "--size", "600x12", "--spp", "1", "--no-shading",
               "--background", "transparent", "--quality", quality, "--view", "front", "--at", "2.5,5,2", "--parallel", "0.12",
               "--tf", "0:0#000 2000:0#f00 2001:0.5#0f0 4000:0.5#00f")
            alpha = exr.read("steep.exr")[1]["A"][6]
            assert numpy.abs(alpha - want)[steep].max() < 5e-3, (kind, quality, numpy.abs(alpha - want)[steep].max())


main()
