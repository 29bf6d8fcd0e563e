"""volvis render and pick of mesh files: alone, several, beside volumes, in scenes; against closed forms."""
import itertools
import json
import math
import shutil
import subprocess
from xml.etree import ElementTree
import exr
import numpy
from PIL import Image
from harness import Skip, fails, main, ok, png_pixels, png_text, says, write_ball, write_box, write_nrrd


def write_ply(path, places, triangles, extra=(), rows=None, unit="mm"):
    """ASCII; extra: lines of properties of vertices after x y z, rows: their numbers as text."""
    with open(path, "w") as file:
        file.write(f"ply\nformat ascii 1.0\ncomment unit: {unit}\ncomment up: z\nelement vertex {len(places)}\n")
        file.write("".join(f"property {p}\n" for p in ("float x", "float y", "float z", *extra)))
        file.write(f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
        file.writelines(f"{p[0]} {p[1]} {p[2]} {row}\n" for p, row in zip(places, rows or itertools.repeat("")))
        file.writelines("3 %d %d %d\n" % tuple(t) for t in triangles)


def sphere(radius, n=96, middle=(0, 0, 0)):
    """Rings of vertices on a sphere."""
    places, triangles = [(0, 0, radius), (0, 0, -radius)], []
    for i in range(1, n // 2):
        t = math.pi * i / (n // 2)
        for j in range(n):
            f = 2 * math.pi * j / n
            places.append((radius * math.sin(t) * math.cos(f), radius * math.sin(t) * math.sin(f), radius * math.cos(t)))
    at = lambda i, j: 2 + (i - 1) * n + j % n
    for j in range(n):
        triangles += [(0, at(1, j), at(1, j + 1)), (1, at(n // 2 - 1, j + 1), at(n // 2 - 1, j))]
        for i in range(1, n // 2 - 1):
            triangles += [(at(i, j), at(i + 1, j), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i, j + 1))]
    return [tuple(a + b for a, b in zip(p, middle)) for p in places], triangles


def square(size=1.0, z=0.0):
    return [(0, 0, z), (size, 0, z), (size, size, z), (0, size, z)], [(0, 1, 2), (0, 2, 3)]


FLAT = ["--no-shading", "--size", "64x64", "--view", "top", "--parallel", "2"]


def render(*words):
    return ok("render", *words, "-o", "out.png", "--overwrite")


def picture(path="out.png"):
    image = Image.open(path).convert("RGB")
    return lambda x, y: image.getpixel((x, y))


def pixels(image):
    """[y, x, channel]: of a file or of an image."""
    image = Image.open(image) if isinstance(image, str) else image
    return numpy.asarray(image.convert("RGB")).astype(int)


def lit(path="out.png"):
    return pixels(path).max(axis=2) > 0


def test_a_sphere_has_the_silhouette_of_a_disc():
    write_ply("ball.ply", *sphere(5, 200))
    write_nrrd("ball.nrrd", (33, 33, 33), lambda x, y, z: 5 - math.dist((x / 2, y / 2, z / 2), (8, 8, 8)),
               spacing=(0.5, 0.5, 0.5), kind="float", code="f")
    look = ["--size", "200x200", "--parallel", "20", "--view", "30,20", "--spp", 1]
    render("ball.ply", *look)
    seen = lit()
    assert abs(seen.sum() / (math.pi * 50 * 50) - 1) < 0.005, seen.sum()
    y, x = numpy.indices(seen.shape)
    away = numpy.hypot(x - 99.5, y - 99.5)
    assert (seen == (away < 50))[abs(away - 50) > 1.5].all()
    render("ball.nrrd", "--method", "raycast", "--iso", 0, *look)
    other = (seen != lit()).sum()
    assert other < 100, other


def test_the_method_is_surface_and_others_say_why_not():
    write_box("box.ply")
    says(render("box.ply").text, "surface")
    for method in ("boxes", "reduced"):
        says(fails(1, "render", "box.ply", "-o", "no.png", "--method", method), "volumes.box", "mesh", "method=surface")
    says(fails(1, "render", "box.ply", "-o", "no.png", "--method", "raycast", "--mode", "mean"), "volumes.box", "mesh", "mode=composite")
    write_ball("head.nrrd")
    look = ("--method", "raycast", "--mode", "maximum", "--size", "64x64", "--spp", "1")
    render("head.nrrd", *look)  # beside a volume, its maxima are a layer over the mesh
    alone = pixels("out.png").astype(int)
    render("head.nrrd", "box.ply", *look)
    assert (abs(pixels("out.png").astype(int) - alone).max(axis=2) > 8).mean() > 0.01


def test_rays_and_triangles_make_the_same_picture_of_a_mesh():
    places, triangles = sphere(5, 120)
    write_ply("ball.ply", places, triangles, ("uchar red", "uchar green", "uchar blue"),
              [f"{int(120 + 20 * x)} {int(120 + 20 * y)} {int(120 + 20 * z)}" for x, y, z in places])
    for look in (["--view", "30,20", "--clip", "plane(n=1,1,1 d=1)"], ["--view", "top", "--parallel", "12"], ["--view", "10,5", "--fov", "80deg"]):
        made = []
        for method in ("surface", "raycast"):
            render("ball.ply", "--method", method, "--spp", "1", "--size", "120x120", *look)
            made.append(pixels("out.png").astype(int))
        away = abs(made[0] - made[1]).max(axis=2)
        assert (away > 2).mean() < 0.004, ((away > 2).mean(), look)


def test_a_mesh_in_a_cloud_is_seen_through_it_and_picked():
    write_nrrd("fog.nrrd", (16, 16, 16), lambda x, y, z: 100)
    write_ply("ball.ply", *sphere(4, 60, (7.5, 7.5, 7.5)))
    look = ["--view", "top", "--parallel", "20", "--size", "60x60", "--tf", "fog=0:0 50:0.01#0000ff 200:0.01"]
    report = ok("render", "fog.nrrd", "ball.ply", *look, "--spp", "1", "-o", "out.png", "--overwrite", "--json").json
    assert report["method"] == "raycast"
    red = pixels("out.png")[..., 0] > 20
    assert abs(red.sum() / (math.pi * 12 * 12) - 1) < 0.05, red.sum()
    general = [word.replace("fog=", "") for word in look]
    told = ok("render", "fog.nrrd", "ball.ply", *general, "--spp", "1", "-o", "general.png")
    assert "no values" not in told.message and (pixels("general.png") == pixels("out.png")).all(), told.message
    there, away = ok("pick", "fog.nrrd", "ball.ply", *look, "--pixel", "30,30", "--pixel", "12,12", "--json").json["pixels"]
    assert there["volume"] == "ball" and abs(there["world"][2] - 11.5) < 0.1, there
    assert not away["hit"], away
    ok("render", "fog.nrrd", "ball.ply", *look, "-o", "a.exr", "--aov", "id,depth,normal", "--overwrite")
    layers = next(part for part in exr.read("a.exr") if isinstance(part, dict) and "id" in part)
    assert layers["id"][30, 30] == 2 and layers["id"][12, 12] == 0 and layers["normal.Z"][30, 30] > 0.98


def test_pictures_and_scenes_repeat_themselves():
    write_box("box.ply")
    render("box.ply", "--size", "80x80", "--clip", "x:..0.4", "--save-scene", "box.vv.json")
    first = png_pixels("out.png")
    scene = json.load(open("box.vv.json"))
    assert scene["datasets"]["box"]["kind"] == "mesh" and "checksum" in scene["datasets"]["box"]
    ok("render", "box.vv.json", "-o", "again.png", "--overwrite")
    assert png_pixels("again.png") == first
    ok("render", "out.png", "-o", "again.png", "--overwrite")
    assert png_pixels("again.png") == first
    del scene["datasets"]["box"]["kind"]
    scene["datasets"]["box"]["checksum"] = "crc32:00000000"
    json.dump(scene, open("box.vv.json", "w"))
    says(fails(3, "render", "box.vv.json", "-o", "again.png", "--overwrite"), "box.ply", "checksum")


def test_colours_are_the_volumes_the_vertices_or_of_the_values():
    places, triangles = square()
    write_ply("plain.ply", places, triangles)
    write_ply("red.ply", places, triangles, ("uchar red", "uchar green", "uchar blue"), ["200 10 20"] * 4)
    write_ply("value.ply", places, triangles, ("float quality",), ["0", "1", "1", "0"])
    render("plain.ply", *FLAT, "--set", "volumes.plain.color=#102030")
    assert picture()(32, 32) == (16, 32, 48)
    render("red.ply", *FLAT)
    assert picture()(32, 32) == (200, 10, 20)
    render("red.ply", *FLAT, "--set", "volumes.red.color=#102030")
    assert picture()(32, 32) == (16, 32, 48)
    render("value.ply", *FLAT, "--tf", "gray", "--range", "0,2")
    at = picture()
    row = [at(x, 32)[0] for x in range(64)]
    seen = [v for v in row if v]
    assert sorted(seen) in (seen, seen[::-1]) and 110 < max(seen) < 200, seen
    render("value.ply", *FLAT)
    at = picture()
    assert len({at(x, 32) for x in range(64)}) > 10
    says(fails(2, "render", "plain.ply", *FLAT, "--tf", "gray", "-o", "no.png"), "no values")


def test_values_have_their_colours_between_vertices_too():
    """Of two vertices 0 and 1 whose colours are red and blue the middle is green where the map has green there."""
    write_ply("value.ply", *square(), ("float quality",), ["0", "1", "1", "0"])
    decode = lambda v: numpy.where(v <= 10.31475, v / 3294.6, ((v / 255 + 0.055) / 1.055) ** 2.4)
    for method in ("surface", "raycast"):
        render("value.ply", *FLAT, "--size", "151x151", "--spp", 1, "--method", method, "--tf", "0:1#ff0000 0.5:1#00ff00 1:1#0000ff")
        row = decode(pixels("out.png")[75].astype(float))
        x = numpy.nonzero(row.max(axis=1))[0]
        value = (x + 0.5 - 75.5) / 75.5 + 0.5
        value = value if row[x[0], 0] > 0.5 else 1 - value
        want = numpy.stack([numpy.maximum(1 - 2 * value, 0), 1 - abs(2 * value - 1), numpy.maximum(2 * value - 1, 0)], axis=1)
        assert len(x) > 60 and abs(row[x] - want).max() < 0.012, (method, abs(row[x] - want).max())


def test_meshes_are_painted_by_another_dataset():
    """Values x / 8 of a volume on a sphere about (4, 4, 4): red, green, blue from left to right, by the formula of the map."""
    write_nrrd("ramp.nrrd", (17, 9, 9), lambda x, y, z: x / 16, spacing=(0.5, 1, 1), kind="float", code="f")
    write_ply("ball.ply", *sphere(3, 80, (4, 4, 4)))
    paint = 'volumes.ball.paint={"data": "ramp", "color": [[0, 1, 0, 0], [0.5, 0, 1, 0], [1, 0, 0, 1]]}'
    look = ["--view", "top", "--parallel", 8, "--size", "151x151", "--set", 'datasets.ramp={"path": "ramp.nrrd"}', "--set", paint]
    for method in ("surface", "raycast"):
        render("ball.ply", "--no-shading", "--spp", 1, "--method", method, *look)
        row = pixels("out.png")[75]
        x = numpy.nonzero(row.max(axis=1))[0]
        value = (4 + (x - 75) * 8 / 151) / 8
        light = numpy.stack([numpy.maximum(1 - 2 * value, 0), 1 - abs(2 * value - 1), numpy.maximum(2 * value - 1, 0)], axis=1)
        want = 255 * numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * numpy.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)
        assert len(x) > 100 and abs(row[x] - want).max() <= 12 and abs(row[x] - want).mean() < 1.5, (method, abs(row[x] - want).max())
    at = ok("pick", "ball.ply", *look, "--pixel", "105,75", "--json").json["pixels"][0]
    assert abs(at["value"] - at["world"][0] / 8) < 0.003, at
    write_nrrd("half.nrrd", (9, 9, 9), lambda x, y, z: 1, spacing=(0.5, 1, 1), kind="float", code="f")
    render("ball.ply", "--no-shading", "--spp", 1, *look, "--set", 'datasets.ramp={"path": "half.nrrd"}', "--set", "volumes.ball.color=#808080")
    row = pixels("out.png")[75]
    assert tuple(row[40]) == (0, 0, 255) and tuple(row[110]) == (128, 128, 128), "its own colour where there are no samples"
    says(fails(2, "render", "ball.ply", "-o", "no.png", "--set", 'volumes.ball.paint={"data": "none"}'), "volumes.ball.paint.data", "none")


def test_values_that_most_vertices_share_give_no_colours():
    places, triangles = sphere(1)
    def colors(values, *words):
        write_ply("scan.ply", places, triangles, ("float intensity",), [str(v) for v in values])
        render("scan.ply", "--no-shading", "--size", "64x64", "--spp", "1", *words)
        return {tuple(p) for p in pixels("out.png").reshape(-1, 3)} - {(0, 0, 0)}
    belt = lambda value: [0.9 if abs(p[2]) < 0.1 else value for p in places]
    assert len(colors([0.5] * len(places))) == 1
    assert len(colors(belt(0.5))) == 1
    assert len(colors(belt(0.5), "--tf", "gray")) > 1, "asked for"
    assert len(colors(belt(0))) > 1, "what stands out from nothing is seen"
    assert ok("info", "scan.ply", "--json").json["value_name"] == "intensity"


def test_a_mesh_stands_beside_a_volume_and_other_meshes():
    write_ball("head.nrrd", 16)
    write_ply("a.ply", *square(4, 30))
    write_ply("b.ply", *square(4, -30))
    report = ok("render", "head.nrrd", "a.ply", "b.ply", "a.ply", "-o", "all.png", "--json").json
    assert report["method"] == "raycast"
    scene = json.loads(png_text("all.png")["VolVis:Scene"])
    assert list(scene["volumes"]) == ["head", "a", "b", "a_2"]
    assert [v["data"] for v in scene["volumes"].values()] == ["head", "a", "b", "a_2"]
    says(fails(2, "render", "a.ply", "all.png", "-o", "no.png"), "all.png", "first")


def test_picking_says_where_and_which_part():
    with open("parts.obj", "w") as file:
        file.write("# up: z\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\n")
        file.write("g low\nf 1 2 3 4\ng high\nf 5 6 7\n")
    look = ["--view", "top", "--parallel", "2", "--size", "100x100", "--json"]
    high, low, none = ok("pick", "parts.obj", *look, "--pixel", "60,60", "--pixel", "40,40", "--pixel", "2,2").json["pixels"]
    parts = {high["part"], low["part"]}
    assert parts == {"low", "high"}, parts
    assert not none["hit"]
    for p in (high, low):
        assert p["volume"] == "parts" and abs(p["world"][2] - (p["part"] == "high")) < 1e-6
        assert abs(abs(p["normal"][2]) - 1) < 1e-6
    write_ply("value.ply", *square(), ("float quality",), ["3", "5", "5", "3"])
    at = ok("pick", "value.ply", *look, "--pixel", "60,45").json["pixels"][0]
    assert abs(at["value"] - (3 + 2 * at["world"][0])) < 1e-5, at


def test_surfaces_that_meet_have_different_colours():
    write_ball("head.nrrd", 24)
    write_ball("other.nrrd", 24)
    write_ply("ball.ply", *sphere(5, 32, (50, 12, 12)))
    look = ["--no-shading", "--view", "front", "--size", "120x60", "--spp", 1, "--overwrite", "--background", "black"]
    beside = ["--set", "volumes.other.place.position=[40,0,0]"]
    def colors(*words):
        ok("render", *words, *look, "-o", "a.png")
        ok("render", "a.png", "-o", "b.png", "--overwrite")
        assert png_pixels("a.png") == png_pixels("b.png")
        seen, n = numpy.unique(numpy.asarray(Image.open("a.png").convert("RGB")).reshape(-1, 3), axis=0, return_counts=True)
        return {"#%02x%02x%02x" % tuple(c) for c, k in zip(seen, n) if k > 60} - {"#000000"}
    beige = "#e6dcc8"
    for shown in (["--iso", 60], ["--threshold", "60.."], ["--iso", 60, "--method", "surface"], ["--threshold", "60..", "--method", "surface"]):
        for one in (["head.nrrd"], ["ball.ply"]):
            assert colors(*one, *(shown if one == ["head.nrrd"] else [])) == {beige}, one
        for two in (["head.nrrd", "ball.ply"], ["head.nrrd", "other.nrrd", *beside]):
            several = colors(*two, *shown)
            assert len(several) == 2 and beige in several, (two, shown, several)
        three = colors("head.nrrd", "other.nrrd", "ball.ply", *shown, *beside, "--set", "volumes.ball.place.position=[40,0,0]")
        assert len(three) == 3, (shown, three)
        given = colors("head.nrrd", "ball.ply", *shown, "--color", "ball=#e6dcc8")
        assert given == {beige}, given


def test_normals_of_meshes_that_are_picked_are_those_of_the_layer():
    """Of the sphere itself, that the vertices are on, and not of its triangles; sharp edges are between flat faces."""
    write_ply("ball.ply", *sphere(5, 24))
    write_box("box.ply")
    places = [(x, y) for x in range(2, 60, 7) for y in range(2, 60, 7)]
    for name, method in itertools.product(("ball", "box"), ("surface", "raycast")):
        look = [f"{name}.ply", "--size", "60x60", "--spp", "1", "--method", method, "--view", "30,20"]
        ok("render", *look, "--aov", "normal", "-o", "a.exr", "--overwrite")
        layer = exr.read("a.exr")[1]
        look = [word for word in look if word not in ("--spp", "1")]
        told = ok("pick", *look, *(word for p in places for word in ("--pixel", f"{p[0]},{p[1]}")), "--json").json["pixels"]
        hits = 0
        for (x, y), p in zip(places, told):
            if p["hit"]:
                seen = numpy.array([layer["normal." + axis][y, x] for axis in "XYZ"])
                assert abs(seen - p["normal"]).max() < 2e-3, (name, method, x, y, seen, p["normal"])
                hits += 1
                if name == "ball":
                    assert numpy.dot(p["normal"], p["world"]) / numpy.linalg.norm(p["world"]) > 0.9995
        assert hits > 15


def test_picking_meets_translucent_meshes_where_half_of_the_light_is_gone():
    files = [f"{name}.ply" for name in ("top", "middle", "bottom")]
    for file, z in zip(files, (3, 2, 1)):
        write_ply(file, *square(1, z))

    def height(*alphas):
        colours = [f"--set=volumes.{f[:-4]}.color=#808080{round(255 * a):02x}" for f, a in zip(files, alphas)]
        at = ok("pick", *files[:len(alphas)], *colours, "--view", "top", "--parallel", "2", "--size", "40x40",
                "--pixel", "22,18", "--json").json["pixels"][0]
        assert at["hit"] and at["volume"] == files[3 - round(at["world"][2])][:-4], at
        return round(at["world"][2])

    assert height(0.4) == 3, "the first where half never goes"
    assert height(0.4, 0.4) == 2 and height(0.2, 0.2) == 3
    assert height(0.4, 0.1, 1) == 1 and height(0.6, 1, 1) == 3
    write_nrrd("cube.nrrd", (9, 9, 9), lambda x, y, z: 100 if min(x, y, z) >= 2 and max(x, y, z) <= 6 else 0)
    write_ply("over.ply", *square(8, 8))
    look = ["--view", "top", "--size", "40x40", "--iso", 50, "--pixel", "20,20", "--json"]
    for alpha, what in (("40", "cube"), ("c0", "over")):
        at = ok("pick", "cube.nrrd", "over.ply", f"--set=volumes.over.color=#808080{alpha}", *look).json["pixels"][0]
        assert at["volume"] == what, at


def test_layers_tell_meshes_from_volumes():
    write_ball("head.nrrd", 17)
    write_ply("ball.ply", *sphere(3, 64, (8, 8, 24)))
    render_to = ["-o", "a.exr", "--overwrite", "--size", "60x60", "--iso", 60, "--view", "front", "--aov", "id,normal,value"]
    ok("render", "head.nrrd", "ball.ply", *render_to)
    layers = next(part for part in exr.read("a.exr") if isinstance(part, dict) and "id" in part)
    ids, values = layers["id"], layers["value"]
    normals = numpy.stack([layers["normal." + axis] for axis in "XYZ"])
    assert set(ids.ravel()) == {0, 1, 2}
    assert (ids[:30] == 2).sum() > 50 and (ids[40:] == 2).sum() == 0, "the mesh is above"
    assert abs(numpy.linalg.norm(normals[:, ids > 0], axis=0) - 1).max() < 1e-3
    assert numpy.isnan(values[ids == 2]).all() and abs(values[ids == 1] - 60).max() < 30


def test_layers_tell_what_is_behind_translucent_meshes_and_that_is_told():
    write_ply("over.ply", *square(8, 8))
    write_ply("under.ply", *square(8, 4))
    look = ["-o", "a.exr", "--overwrite", "--size", "40x40", "--view", "top"]
    for alpha, there, said in (("60", 2, True), ("ff", 1, False)):
        color = f"--set=volumes.over.color=#808080{alpha}"
        told = ok("render", "over.ply", "under.ply", *look, color, "--aov", "id,depth")
        layers = next(part for part in exr.read("a.exr") if isinstance(part, dict) and "id" in part)
        assert layers["id"][20, 20] == there, layers["id"][20, 20]
        assert told.message.count("volumes.over: is a translucent mesh") == said, told.message
        assert "translucent" not in ok("render", "over.ply", "under.ply", *look, color, "--aov", "samples").message
        assert "translucent" not in ok("render", "over.ply", "under.ply", *look, color).message


def test_units_bring_meshes_to_where_volumes_are():
    write_nrrd("cube.nrrd", (9, 9, 9), lambda x, y, z: 100 if 2 <= x <= 6 and 2 <= y <= 6 and 2 <= z <= 6 else 0)
    ok("isosurface", "cube.nrrd", "-o", "mm.ply", "--iso", 50)
    ok("convert", "mm.ply", "-o", "cm.ply", "--unit", "cm")
    look = ["--parallel", "12", "--size", "64x64", "--pixel", "32,32", "--json"]
    a = ok("pick", "cube.nrrd", "mm.ply", *look, "--set", "volumes.cube.visible=false").json["pixels"][0]
    b = ok("pick", "cube.nrrd", "cm.ply", *look, "--set", "volumes.cube.visible=false").json["pixels"][0]
    assert all(abs(x - y) < 1e-4 for x, y in zip(a["world"], b["world"])), (a, b)


def test_meshes_come_by_a_pipe():
    write_box("box.ply")
    ok("render", "-", "-o", "piped.png", stdin=open("box.ply", "rb").read())
    ok("render", "box.ply", "-o", "named.png")
    assert png_pixels("piped.png") == png_pixels("named.png")


def layers_of(*words):
    """Of a picture with nothing but these meshes, in which a pixel is a tenth of a length, seen from above."""
    told = ok("render", *words, "--view", "top", "--parallel", "15.1", "--size", "151x151", "--spp", 1, "--aov", "id,depth,normal", "-o", "a.exr", "--overwrite")
    return told, next(part for part in exr.read("a.exr") if isinstance(part, dict) and "id" in part)


def test_closed_meshes_show_a_face_where_they_are_cut():
    write_ply("ball.ply", *sphere(5, 200))
    for method in ("surface", "raycast"):
        for words, away, clipped in ((["--clip", "z:..3"], 4, 0), (["--clip", "z:..3", "--clip", "x:0.."], 4, 0.5)):
            told, layers = layers_of("ball.ply", "--method", method, *words)
            face = (layers["id"] == 1) & (layers["normal.Z"] > 0.99999) & (abs(layers["Z"] - numpy.median(layers["Z"][layers["id"] == 1])) < 1e-3)
            y, x = numpy.indices(face.shape) - 75.0
            disc = (numpy.hypot(x, y) < 10 * away) & ((x > 0) | (clipped == 0))
            assert (face != disc)[abs(numpy.hypot(x, y) - 10 * away) > 1][:].mean() < 0.006, (method, words)
            assert abs(face.sum() / (math.pi * 1600 * (1 - clipped)) - 1) < 0.02, (method, words, face.sum())
            assert "hollow" not in told.message, told.message
        told, layers = layers_of("ball.ply", "--method", method, "--clip", "z:..3", "--set", "shading.cap=false")
        assert (layers["normal.Z"] > 0.99999).sum() < 100 and "hollow" not in told.message, "one looks inside"
        at, beside = ok("pick", "ball.ply", "--method", method, "--clip", "z:..3", "--view", "top", "--parallel", 15.1, "--size", 151,
                        "--pixel", "75,75", "--pixel", "75,30", "--json").json["pixels"]
        assert at["cut"] and "triangle" not in at and at["volume"] == "ball" and abs(at["world"][2] - 3) < 1e-5, at
        assert at["normal"] == [0, 0, 1] and not beside["cut"] and beside["triangle"] > 0, (at, beside)


def test_faces_of_cuts_have_the_colours_of_parts_and_open_meshes_are_hollow():
    with open("two.obj", "w") as file, open("two.mtl", "w") as library:
        file.write("# up: z\nmtllib two.mtl\n")
        first = 1
        for name, at, kd in (("left", -2.5, "1 0 0"), ("right", 2.5, "0 0 1")):
            library.write(f"newmtl {name}\nKd {kd}\n")
            places, triangles = sphere(2, 60, (at, 0, 0))
            file.writelines("v %r %r %r\n" % p for p in places)
            file.write(f"g {name}\nusemtl {name}\n")
            file.writelines("f %d %d %d\n" % tuple(first + v for v in t) for t in triangles)
            first += len(places)
    look = ["--no-shading", "--view", "top", "--parallel", "15.1", "--size", "151x151", "--spp", 1, "--background", "black"]
    for method in ("surface", "raycast"):
        render("two.obj", *look, "--method", method, "--clip", "z:..0")
        at = picture()
        assert at(50, 75) == (255, 0, 0) and at(100, 75) == (0, 0, 255) and at(75, 75) == (0, 0, 0)
    places, triangles = sphere(5, 60)
    write_ply("bowl.ply", places, [t for t in triangles if max(places[v][2] for v in t) < 1])
    said = ok("render", "bowl.ply", *look, "--clip", "x:..1", "-o", "a.png").message
    says(said, "volumes.bowl", "open", "hollow")
    assert "hollow" not in ok("render", "bowl.ply", *look, "--clip", "z:-2..", "-o", "b.png").message


def test_open_meshes_that_are_cut_all_round_are_said_to_be_open():
    places, triangles = sphere(5, 60)
    write_ply("bowl.ply", places, [t for t in triangles if max(places[v][2] for v in t) < 1])
    write_ply("ball.ply", places, triangles)
    for method in ("surface", "raycast"):
        said = ok("render", "bowl.ply", "--size", "60x60", "--method", method, "--clip", "z:-2..", "-o", "a.png", "--overwrite").message
        says(said, "volumes.bowl", "is open (", "edges belong to one triangle only", "shading.cap=false")
        for words in (["ball.ply", "--clip", "z:-2.."], ["bowl.ply"], ["bowl.ply", "--clip", "z:-2..", "--set", "shading.cap=false"]):
            assert "open" not in ok("render", *words, "--size", "60x60", "--method", method, "-o", "a.png", "--overwrite").message, words


def test_meshes_larger_than_single_precision_can_light_are_refused_by_all_methods():
    for size, fine in ((1e-3, True), (5e8, True), (2e9, False), (1e30, False)):
        write_ply("large.ply", [(x * size, y * size, z * size) for x, y, z in sphere(0.5, 20)[0]], sphere(0.5, 20)[1])
        for method in ("surface", "raycast"):
            words = ("render", "large.ply", "--size", "60x60", "--method", method, "-o", "a.png", "--overwrite")
            if fine:
                ok(*words)
                assert picture("a.png")(30, 30) > (60, 60, 60), (size, method, picture("a.png")(30, 30))
            else:
                says(fails(2, *words), "volumes.large", "drawn up to 1e+09", "volumes.large.place.scale")
    ok("render", "large.ply", "--set", "volumes.large.place.scale=[1e-30, 1e-30, 1e-30]", "--size", "60x60", "-o", "a.png", "--overwrite")


def test_rays_of_meshes_and_of_methods_without_rays_are_noted():
    write_ply("ball.ply", *sphere(5, 20))
    says(ok("render", "ball.ply", "--set", "volumes.ball.rays.mode=maximum", "--size", "40x40", "-o", "a.png", "--overwrite").message,
         "volumes.ball.rays.mode does nothing", "is a mesh")
    write_ball("head.nrrd", 16)
    small = ["--size", "40x40", "-o", "a.png", "--overwrite"]
    told = ok("render", "head.nrrd", *small, "--set", "volumes.head.rays.blend=add", "--set", "volumes.head.rays.opacity=0.5",
              "--set", "volumes.head.rays.iso=60").message
    says(told, *(f"volumes.head.rays.{name} does nothing in mode composite" for name in ("blend", "opacity", "iso")))
    for words in (["--mode", "maximum", "--set", "volumes.head.rays.opacity=0.5"], ["--set", "volumes.head.rays.step=1vox"]):
        assert "does nothing" not in ok("render", "head.nrrd", *small, *words).message, words


def test_textures_without_effect_are_said():
    write_ply("ball.ply", *sphere(5, 20))
    write_ball("head.nrrd", 16)
    small = ["--size", "40x40", "--overwrite", "-o"]
    ok("render", "ball.ply", *small, "image.png")
    for method in ("surface", "raycast"):
        for texture in ("kind=marble", "image=image.png"):
            said = ok("render", "ball.ply", "--method", method, "--set", f"volumes.ball.texture.{texture}", *small, "a.png").message
            says(said, "volumes.ball.texture is not drawn on meshes")
    wood, image = ["--set", "volumes.head.texture.kind=wood"], ["--set", "volumes.head.texture.image=image.png"]
    says(ok("render", "head.nrrd", "--iso", 60, *wood, *image, *small, "a.png").message, "volumes.head.texture.image is not used", "pattern")
    ok("render", "head.nrrd", "--iso", 60, *wood, *small, "b.png")
    assert png_pixels("a.png") == png_pixels("b.png")
    assert "not used" not in ok("render", "head.nrrd", "--iso", 60, *image, *small, "a.png").message


def test_shadows_of_meshes_alone_choose_the_method_that_has_them():
    write_ply("ball.ply", *sphere(5, 20))
    small = ["--size", "40x40", "-o", "a.png", "--overwrite", "--json"]
    assert ok("render", "ball.ply", *small).json["method"] == "surface"
    for words in (["--lighting", "cinematic"], ["--shadows"], ["--ambient-occlusion"]):
        assert ok("render", "ball.ply", *words, *small).json["method"] == "raycast", words
        said = fails(2, "render", "ball.ply", *words, "--method", "surface", *small)
        says(said, f"{words[0]} does nothing with method surface", "composite and isosurface of method raycast")


def rasterised(path, size):
    """What another program makes of a figure."""
    if not shutil.which("rsvg-convert"):
        raise Skip("rsvg-convert is not installed (apt-get install librsvg2-bin)")
    subprocess.run(["rsvg-convert", "-w", str(size), "-h", str(size), path, "-o", "figure.png"], check=True)
    return Image.open("figure.png").convert("RGB")


def difference(a, b):
    """Mean of the channels' differences, and the share of pixels that differ by more than a fourth of the way."""
    each = abs(pixels(a) - pixels(b)).max(axis=2)
    return each.mean(), (each > 64).mean()


def test_figures_look_like_their_pictures():
    write_ply("ball.ply", *sphere(5, 64))
    write_ball("head.nrrd", 24)
    for words in (["ball.ply", "--spp", 8, "--background", "white"], ["ball.ply", "--spp", 8, "--clip", "x:..1"],
                  ["head.nrrd", "--method", "surface", "--spp", 8, "--clip", "y:..12"],
                  ["head.nrrd", "--method", "boxes", "--spp", 8, "--background", "white"],
                  ["head.nrrd", "ball.ply", "--spp", 8], ["head.nrrd", "--iso", 60], ["head.nrrd", "--background", "white"]):
        look = [*words, "--size", "200x200", "--set", "views.main.camera.fit=data", "--overwrite"]
        ok("render", *look, "-o", "a.png")
        ok("render", *look, "-o", "a.svg")
        mean, far = difference("a.png", rasterised("a.svg", 200))
        assert mean < 2 and far < 0.012, (words, mean, far)


def posts_on_a_floor():
    """Large triangles before, behind and through each other: places, triangles, rows of colours."""
    places, triangles, rows = [], [], []
    def quad(corners, color):
        n = len(places)
        places.extend(corners)
        triangles.extend([(n, n + 1, n + 2), (n, n + 2, n + 3)])
        rows.extend([color] * 4)
    quad([(-10, -10, 0), (10, -10, 0), (10, 10, 0), (-10, 10, 0)], "180 180 180")
    for k in range(30):
        x, y, h = 9 * math.sin(7 * k), 9 * math.cos(4 * k), 1 + k % 7
        color = f"{40 + 7 * k} {250 - 7 * k} {40 + 53 * k % 200}"
        p = [(x - 0.4, y - 0.4), (x + 0.4, y - 0.4), (x + 0.4, y + 0.4), (x - 0.4, y + 0.4)]
        for i in range(4):
            a, b = p[i], p[(i + 1) % 4]
            quad([(*a, -1), (*b, -1), (*b, h), (*a, h)], color)
        quad([(*c, h) for c in p], color)
    return places, triangles, rows


def test_figures_of_large_triangles_look_like_their_pictures():
    colors = ("uchar red", "uchar green", "uchar blue")
    places, triangles, rows = posts_on_a_floor()
    write_ply("posts.ply", places, triangles, colors, rows)
    write_ply("colours.ply", *square(8), colors, ["255 0 0", "0 255 0", "0 0 255", "255 255 0"])
    write_ply("ball.ply", *sphere(4, 12, (0, 0, 1)))
    for words, most in ((["posts.ply", "--view", "35,25"], 0.007), (["posts.ply", "--view", "20,-30"], 0.007),
                        (["posts.ply", "ball.ply", "--view", "35,25"], 0.007), (["colours.ply", "--view", "top"], 0.01)):
        words = [*words, "--spp", 8, "--size", "400x400", "--overwrite"]
        ok("render", *words, "-o", "a.png")
        said = ok("render", *words, "-o", "a.svg").message
        assert "wrong order" not in said, said
        mean, far = difference("a.png", rasterised("a.svg", 400))
        assert mean < 4.5 and far < most, (words, mean, far)


def test_cut_planes_leave_the_decorations_of_figures_whole():
    write_ball("head.nrrd", 24)
    write_ply("ball.ply", *sphere(5, 32))
    for words in (["head.nrrd", "--method", "surface", "--clip", "x:6..14"], ["ball.ply", "--clip", "x:-1..2"]):
        words += ["--spp", 8, "--decorate", "box,cut-planes", "--view", "40,40", "--size", "300x300"]
        ok("render", *words, "-o", "a.png", "--overwrite")
        ok("render", *words, "-o", "a.svg", "--overwrite")
        drawn, figure = (pixels(image).sum(axis=2) for image in ("a.png", rasterised("a.svg", 300)))
        assert abs(figure.mean() / drawn.mean() - 1) < 0.1, (words, figure.mean(), drawn.mean())
        lit = [numpy.argwhere(image > 100) for image in (drawn, figure)]
        assert all(abs(a - b) <= 2 for f in (numpy.min, numpy.max) for a, b in zip(*(f(p, axis=0) for p in lit))), words


def test_figures_have_vectors_and_letters():
    write_ply("ball.ply", *sphere(5, 32))
    write_ball("head.nrrd", 16)
    ok("render", "ball.ply", "-o", "a.svg", "--decorate", "axes", "--title", "a < b & c")
    root = ElementTree.parse("a.svg").getroot()
    tags = [e.tag.split("}")[1] for e in root.iter()]
    assert tags.count("path") > 300 and "image" not in tags and "rect" in tags
    assert "a < b & c" in [e.text for e in root.iter()]
    ok("render", "head.nrrd", "-o", "b.svg", "--decorate", "legend")
    tags = [e.tag.split("}")[1] for e in ElementTree.parse("b.svg").getroot().iter()]
    assert tags.count("image") == 1 and "text" in tags
    says(fails(2, "render", "head.nrrd", "-o", "c.svg", "--aov", "depth"), "--aov")
    says(fails(2, "render", "head.nrrd", "-o", "c.svg", "--bits", 16), "SVG")


def test_figures_of_too_many_triangles_say_what_to_do():
    n = 330
    places = [(x, y, 0) for y in range(n) for x in range(n)]
    at = lambda x, y: y * n + x
    triangles = [t for y in range(n - 1) for x in range(n - 1)
                 for t in ((at(x, y), at(x + 1, y), at(x, y + 1)), (at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)))]
    write_ply("sheet.ply", places, triangles)
    said = fails(4, "render", "sheet.ply", "-o", "a.svg", "--view", "top", "--size", "1000x1000")
    says(said, "216482 triangles", "100000", "simplify", "PNG")


def legend_of(path):
    """Texts of a figure of no other letters; the colours of its swatches are in its paths."""
    root = ElementTree.parse(path).getroot()
    return [e.text for e in root.iter() if e.tag.endswith("text") and e.get("stroke") is None]


def test_meshes_of_programs_for_pictures_stand_upright():
    tall = "v 0 0 0\nv 1 0 0\nv 0 9 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    for head, words, upright in (("", (), True), ("# written by VolVis\n", (), False), ("", ("--set", "up=z"), False),
                                 ("# up: z\n", ("--set", "up=y"), True)):
        with open("tall.obj", "w") as file:
            file.write(head + tall)
        ok("render", "tall.obj", "-o", "a.png", "--size", "60", "--background", "black", "--overwrite", *words)
        seen = numpy.asarray(Image.open("a.png").convert("L")) > 0
        rows, columns = (numpy.ptp(numpy.nonzero(seen.any(axis=a))[0]) for a in (1, 0))
        assert (rows > 2 * columns) == upright, (head, words, rows, columns)


def test_meshes_and_their_parts_are_told_apart():
    with open("parts.obj", "w") as file:
        file.write("# up: z\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n")
        file.write("g left\nf 1 2 3\ng right\nf 1 3 4\n")
    for name, z in (("a", 0), ("b", 1)):
        write_ply(f"{name}.ply", *[[((x + z) / 2, y, 0) for x, y, _ in square()[0]], square()[1]])
    beige = []
    for files, rows in ((["parts.obj"], ["parts", "left", "right"]), (["a.ply", "b.ply"], ["a", "b"]), (["a.ply"], ["a"])):
        ok("render", *files, *FLAT, "--size", "400x400", "--decorate", "legend", "-o", "a.svg", "--overwrite")
        assert legend_of("a.svg") == rows, legend_of("a.svg")
        fills = [e.get("fill") for e in ElementTree.parse("a.svg").getroot().iter() if e.tag.endswith("path")]
        render(*files, *FLAT)
        colours = {Image.open("out.png").convert("RGB").getpixel(p) for p in ((26, 20), (38, 44))} - {(0, 0, 0)}
        colours |= {Image.open("out.png").convert("RGB").getpixel(p) for p in ((38, 20), (26, 44))} - {(0, 0, 0)}
        assert len(colours) == (1 if files == ["a.ply"] else 2), (files, colours)
        for c in colours:
            assert fills.count("#%02x%02x%02x" % c) >= 2, ("in the picture and in the legend", c, fills)
        beige.append(colours)
    assert not beige[2] & (beige[0] | beige[1]), "one mesh alone keeps the colour that all have"
    ok("render", "a.ply", "b.ply", *FLAT, "--set", "volumes.a.color=#102030", "-o", "out.png", "--overwrite")
    assert (16, 32, 48) in Image.open("out.png").convert("RGB").getdata()


def test_edges_are_smooth_where_nobody_says_how_good_a_picture_is():
    write_ply("ball.ply", *sphere(5, 64))
    look = ["ball.ply", "--no-shading", "--size", "64x64", "--json", "-o", "a.png", "--overwrite"]
    for quality, rays in ("draft", 1), ("normal", 4), ("high", 8), ("reference", 16):
        assert ok("render", *look, "--quality", quality).json["passes"] == rays, quality
    assert ok("render", *look).json["passes"] == 4
    shades = len(numpy.unique(pixels("a.png").reshape(-1, pixels("a.png").shape[-1]), axis=0))
    assert shades >= 4, shades  # of the ball, of what is behind it, and of parts of pixels
    assert ok("render", *look, "--spp", 1).json["passes"] == 1
    assert len(numpy.unique(pixels("a.png").reshape(-1, pixels("a.png").shape[-1]), axis=0)) == 2


def test_many_samples_come_to_the_mean_of_a_large_picture():
    write_ply("ball.ply", *sphere(5, 24))
    look = ["ball.ply", "--view", "33,21", "--no-shading", "-o"]

    def light(path, *words):
        ok("render", *look, path, *words, "--overwrite")
        with open(path, "rb") as file:
            assert file.readline() == b"PF\n"
            width, height = map(int, file.readline().split())
            assert float(file.readline()) < 0
            return numpy.frombuffer(file.read(), "<f4").reshape(height, width, 3)
    large = light("large.pfm", "--size", "5120x5120", "--spp", "1")
    mean = large.reshape(80, 64, 80 * 64, 3).sum(axis=1, dtype=float).reshape(80, 80, 64, 3).sum(axis=2) / 4096
    error = {n: math.sqrt(((light("small.pfm", "--size", "80x80", "--spp", str(n)) - mean) ** 2).mean()) for n in (8, 64, 4096)}
    assert error[64] < error[8] / 2.5 and error[4096] < error[64] / 3, error
    report = ok("render", *look, "a.png", "--spp", "60", "--size", "32x32", "--json").json
    assert report["passes"] == 64, report
    many = ok("render", *look, "a.png", "--spp", "24", "--size", "33x57", "--threads", "1", "--overwrite")
    one = open("a.png", "rb").read()
    ok("render", *look, "a.png", "--spp", "24", "--size", "33x57", "--threads", "2", "--overwrite")
    assert png_pixels("a.png") and many.code == 0 and one == open("a.png", "rb").read()


def test_what_triangles_do_not_get_is_said():
    write_ball("head.nrrd", 12)
    for words, said in ((["--noise", "1%"], "noise"),
                        (["--set", "volumes.head.interpolation=cubic"], "cubic"),
                        (["--set", "volumes.head.interpolation=nearest"], "nearest")):
        says(render("head.nrrd", "--method", "surface", "--size", "32x32", *words).message, said)


def test_a_budget_of_triangles_that_cannot_be_met_is_said():
    write_ball("head.nrrd", 24)
    for method in ("reduced", "boxes"):
        words = ["head.nrrd", "--method", method, "--iso", 60, "--size", "32x32"]
        said = render(*words, "--set", f"views.main.render.{method}.triangles=3").message
        says(said, "at most 3 triangles", "at least")
        assert "at least" not in render(*words).message


def test_thin_things_stay_where_the_highest_sample_is_kept():
    write_nrrd("wire.nrrd", (64, 64, 64), lambda x, y, z: 200 if (y, z) == (31, 33) and 8 <= x < 56 else 0)
    look = ["wire.nrrd", "--method", "reduced", "--iso", 100, "--view", "front", "--background", "#000000", "--size", "96x96",
            "--spp", 1, "--set", "views.main.camera.fit=data"]
    seen = {}
    for name, more in (("all", ["reduced.triangles=0"]), ("smooth", ["reduced.triangles=100"]),
                       ("high", ["reduced.triangles=100", "reduced.filter=high"])):
        result = render(*look, *[w for m in more for w in ("--set", f"views.main.render.{m}")])
        image = numpy.asarray(Image.open("out.png").convert("L"))
        seen[name] = set(numpy.nonzero(image.max(axis=0) > 30)[0])
        assert ("thinner parts are lost" in result.message) == (name == "smooth"), (name, result.message)
    assert not seen["smooth"] and seen["all"] <= seen["high"], seen


def test_a_budget_of_memory_is_met_or_told():
    write_ball("head.nrrd", 48)
    for method in ("reduced", "boxes"):
        budget = f"views.main.render.{method}.memory="
        seen = []
        for memory in ("0", "200k", "20k"):
            render("head.nrrd", "--method", method, "--size", "64x64", "--set", budget + memory, "-v")
            seen.append(png_pixels("out.png"))
        assert seen[0] != seen[2], "nothing was left out"
        assert "bytes of triangles" not in render("head.nrrd", "--method", method, "--set", budget + "60k").message
        says(render("head.nrrd", "--method", method, "--set", budget + "1").message, "volumes.head: at most 1 bytes", "at least")
        says(fails(2, "render", "head.nrrd", "-o", "a.png", "--method", method, "--set", budget + "-1"), "memory")


def test_a_mesh_is_no_volume():
    write_box("box.ply")
    ok("render", "box.ply", "-o", "a.png", "--dry-run")
    says(fails(3, "isosurface", "box.ply", "-o", "x.ply"), "box.ply", "mesh")


def write_globe(path, seam):
    """A sphere of 12 meridians, as a map of the Earth is wrapped around it: with `seam`, vertices of the first are there twice."""
    across, down = 12, 6
    columns = across + seam
    points = [(math.sin(math.pi * j / down) * math.cos(2 * math.pi * (i % across) / across),
               math.sin(math.pi * j / down) * math.sin(2 * math.pi * (i % across) / across), math.cos(math.pi * j / down))
              for j in range(1, down) for i in range(columns)]
    at = lambda i, j: (j - 1) * columns + i % columns
    north, south, faces = len(points), len(points) + 1, []
    for i in range(across):
        faces += [(north, at(i, 1), at(i + 1, 1)), (south, at(i + 1, down - 1), at(i, down - 1))]
        for j in range(1, down - 1):
            faces += [(at(i, j), at(i, j + 1), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i + 1, j))]
    points += [(0, 0, 1), (0, 0, -1)]
    with open(path, "w", encoding="ascii") as file:
        file.write(f"OFF\n{len(points)} {len(faces)} 0\n")
        file.writelines("%.7g %.7g %.7g\n" % p for p in points)
        file.writelines("3 %d %d %d\n" % f for f in faces)


def test_the_seam_of_a_mesh_is_no_crease():
    write_globe("whole.off", False)
    write_globe("seam.off", True)
    for name in ("whole", "seam"):
        ok("render", f"{name}.off", "-o", f"{name}.png", "--size", "200", "--view", "+x")
    ok("compare", "whole.png", "seam.png", "--max-difference", "0.02")


def write_cube(path, n=5):
    """From 0 to 1, of n x n quads a face, whose vertices the faces share."""
    places, triangles = {}, []
    for a, end in itertools.product(range(3), (0, n)):
        for i, j in itertools.product(range(n), repeat=2):
            corners = [tuple(numpy.roll((end, i + x, j + y), a)) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
            q = [places.setdefault(c, len(places)) for c in (corners if end else corners[::-1])]
            triangles += [(q[0], q[1], q[2]), (q[0], q[2], q[3])]
    write_ply(path, [tuple(x / n for x in p) for p in places], triangles)


def test_a_cube_of_vertices_that_its_faces_share_has_flat_faces():
    """Normals are those of the faces to the pixel, and each face has one colour, from far away."""
    write_cube("cube.ply")
    for method in ("surface", "raycast"):
        look = ["cube.ply", "--size", "120x120", "--spp", "1", "--method", method, "--view", "30,25", "--parallel", "3"]
        ok("render", *look, "--aov", "normal", "-o", "a.exr", "--overwrite")
        parts = exr.read("a.exr")
        layer = next(part for part in parts if isinstance(part, dict) and "normal.X" in part)
        normal = numpy.stack([layer["normal." + axis] for axis in "XYZ"], -1)
        faces = [abs(normal - numpy.eye(3)[a] * s).max(axis=2) < 1e-3 for a, s in itertools.product(range(3), (-1, 1))]
        seen = numpy.abs(normal).max(axis=2) > 0
        assert sorted(f.sum() > 300 for f in faces) == [False] * 3 + [True] * 3
        assert (sum(f.astype(int) for f in faces) == seen).all()
        render(*look)
        colours = pixels("out.png")
        for face in faces:
            if face.any():
                assert numpy.ptp(colours[face], axis=0).max() <= 1, (method, numpy.ptp(colours[face], axis=0))


main()
