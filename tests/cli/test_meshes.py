"""Meshes on the command line: told, converted, through pipes, refused."""
import base64
import json
import os
import resource
import struct
import subprocess
from harness import VOLVIS, environment, fails, main, ok, says, volvis, write_ball, write_box


def meshes():
    """Name, suffix and encodings of every mesh format."""
    rows = ok("formats", "--json").json["meshes"]
    return [(row["name"], row["suffixes"][0], row["encodings"] or [None]) for row in rows]


def test_a_box_is_told_with_area_and_volume():
    write_box()
    told = ok("info", "box.ply", "--json").json
    assert (told["vertices"], told["triangles"], told["edges"], told["pieces"]) == (8, 12, 18, 1), told
    assert told["closed"] and told["unit"] == "mm" and told["hi"] == [1, 2, 3], told
    assert abs(told["area"] - 22) < 1e-9 and abs(told["volume"] - 6) < 1e-9, told
    says(ok("info", "box.ply").text, "12 triangles", "closed", "22 mm^2", "6 mm^3")


def test_an_open_mesh_has_no_volume():
    write_box()
    with open("box.ply", encoding="ascii") as file:
        text = file.read()
    with open("open.ply", "w", encoding="ascii") as file:
        file.write(text.replace("element face 6", "element face 5"))
    told = ok("info", "open.ply", "--json").json
    assert not told["closed"] and told["open_edges"] == 4 and told["volume"] is None, told
    says(ok("info", "open.ply").text, "no: 4 edges of one triangle only")


def test_what_is_not_closed_is_told_in_words():
    write_box()
    with open("box.ply", encoding="ascii") as file:
        text = file.read()
    with open("turned.ply", "w", encoding="ascii") as file:
        file.write(turn_last_face(text))
    told = ok("info", "turned.ply", "--json").json
    assert not told["closed"] and told["turned_edges"] == 4 and told["open_edges"] == 0, told
    says(ok("info", "turned.ply").text, "no holes", "wrong way", "4 edges between neighbours")
    says(ok("info", "box.ply").text, "yes: every edge joins two triangles")


def turn_last_face(text):
    lines = text.rstrip("\n").split("\n")
    count, *corners = lines[-1].split()
    return "\n".join(lines[:-1] + [" ".join([count, *reversed(corners)])]) + "\n"


def test_every_format_and_encoding_keeps_the_box():
    write_box()
    for name, suffix, encodings in meshes():
        for encoding in encodings:
            words = ["--encoding", encoding] if encoding else []
            ok("convert", "box.ply", "-o", "out" + suffix, "--overwrite", *words)
            told = ok("info", "out" + suffix, "--input-unit", "mm", "--json").json
            assert told["format"] == name and told["closed"] and abs(told["volume"] - 6) < 1e-5, (name, encoding, told)


def test_files_are_the_same_bytes_for_any_number_of_threads():
    write_ball("ball.nrrd", 40)
    ok("isosurface", "ball.nrrd", "-o", "ball.ply", "--iso", "20,60,200")
    for name, suffix, encodings in meshes():
        for encoding in encodings:
            words = ["--encoding", encoding] if encoding else []
            def made(threads):
                ok("convert", "ball.ply", "-o", "out" + suffix, "--overwrite", "--threads", threads, *words)
                with open("out" + suffix, "rb") as file:
                    return file.read()
            assert made(1) == made(2) == made(3), (name, encoding)
            told, whole = (ok("info", path, "--json").json for path in ("out" + suffix, "ball.ply"))
            assert told["triangles"] == whole["triangles"] > 10000, (name, encoding)
            assert abs(told["volume"] / whole["volume"] - 1) < 1e-5 and len(told["parts"]) in (0, 3), (name, encoding)


TWO = """o body
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 2 3 4
f 3 1 4
o wheel rim
v 5 5 5
v 6 5 5
v 5 6 5
f 5 6 7
"""


def test_a_part_of_a_mesh_is_a_mesh():
    """A tetrahedron of volume 1/6, and a triangle."""
    with open("two.obj", "w", encoding="ascii") as file:
        file.write(TWO)
    ok("convert", "two.obj", "-o", "two.glb")
    for name in "two.obj", "two.glb":
        for word in (name + ":body",), (name + ":0",), (name, "--part", "body"):
            told = ok("info", *word, "--json").json
            assert (told["vertices"], told["triangles"], told["closed"]) == (4, 4, True), told
            assert abs(told["volume"] - 1 / 6) < 1e-6 and told["parts"][0]["name"] == "body", told
        assert ok("info", f"{name}:wheel rim", "--json").json["lo"] == [5, 5, 5]
        ok("convert", name + ":1", "-o", "rim.ply", "--overwrite")
        assert ok("info", "rim.ply", "--json").json["triangles"] == 1
        assert abs(ok("measure", "volume", name + ":body", "--json").json["volume"] - 1 / 6) < 1e-6
        apart = ok("measure", "distance", name + ":body", name + ":1", "--json").json["distance"]
        assert abs(apart - 14 / 3 ** 0.5) < 1e-5, apart  # from the side x + y + z = 1 to the corner 5, 5, 5
        for verb in "simplify", "smooth":
            assert ok(verb, name + ":body", "-o", "less.ply", "--overwrite", "--json").json["triangles"] == 4
        ok("render", name + ":wheel rim", "-o", "rim.png", "--size", "32x32", "--overwrite", "--save-scene", "s.vv.json")
        assert ok("info", "s.vv.json", "--json").json and "wheel rim" in open("s.vv.json", encoding="utf-8").read()
        ok("render", "s.vv.json", "-o", "again.png", "--size", "32x32", "--overwrite")
        assert ok("compare", "rim.png", "again.png", "--json").json["identical"]


def test_a_part_that_is_not_there_is_named_with_those_that_are():
    write_box()
    with open("two.obj", "w", encoding="ascii") as file:
        file.write(TWO)
    with open("same.stl", "w", encoding="ascii") as file:
        for z in 0, 1, 2:
            file.write(f"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 {z}\nvertex 1 0 {z}\nvertex 0 1 {z}\n"
                       "endloop\nendfacet\nendsolid a\n")
    for verb in (["info"], ["convert", "-o", "a.ply"], ["render", "-o", "a.png"], ["measure", "volume"],
                 ["simplify", "-o", "a.ply"], ["smooth", "-o", "a.ply"]):
        says(fails(2, *verb, "two.obj:bodi"), "two.obj", "'bodi'", "did you mean 'body'")
        says(fails(2, *verb, "two.obj:2"), "'2'", "there are 2, 0 to 1: body, wheel rim")
        says(fails(2, *verb, "same.stl:a"), "3 parts of the name 'a'", "number", "the first is 0")
        says(fails(2, *verb, "box.ply:body"), "'body'", "one object without parts")
    assert ok("info", "same.stl:2", "--json").json["lo"] == [0, 0, 2]
    says(fails(2, "info", "two.obj@1"), "time steps", "'@1'")


def moved_box(path, by):
    with open("box.ply", encoding="ascii") as file:
        head, body = file.read().split("end_header\n")
    lines = body.split("\n")
    for i in range(8):
        x, y, z = map(float, lines[i].split()[:3])
        lines[i] = f"{x + by} {y} {z}"
    with open(path, "w", encoding="ascii") as file:
        file.write(head + "end_header\n" + "\n".join(lines))


def test_two_meshes_are_compared():
    """A box of 1 x 2 x 3 and the same one an eighth to the right: no place is farther away than that."""
    write_box()
    moved_box("moved.ply", 0.125)
    told = ok("compare", "box.ply", "moved.ply", "--json").json
    assert told["kind"] == "meshes" and told["same_topology"] and not told["same_places"], told
    assert told["a"]["triangles"] == told["b"]["triangles"] == 12 and told["a"]["pieces"] == 1 and told["a"]["closed"]
    assert abs(told["a"]["area"] - 22) < 1e-5 and abs(told["b"]["volume"] - 6) < 1e-5 and told["unit"] == "mm"
    assert told["a"]["hi"] == [1, 2, 3] and told["b"]["hi"] == [1.125, 2, 3] and told["bounds_difference"] == 0.125
    for key in "hausdorff", "a_to_b_max", "b_to_a_max", "max_difference":
        assert abs(told[key] - 0.125) < 1e-6, told
    # a side of 2 x 3 lies outside, strips of 10 x 0.125 beside it, and the other one inside, nearer to its own rim there
    strip = 10 * 0.125 ** 2 / 2
    mean = (6 * 0.125 + strip + 1.75 * 2.75 * 0.125 + strip - 8 * 0.125 ** 3 / 3) / 22
    assert abs(told["a_to_b_mean"] - mean) < 2 * told["a_to_b_mean_error"], (told, mean)
    assert told["distance"] == 0 and not told["identical"] and told["differs"], told
    assert volvis("compare", "box.ply", "moved.ply", "--max-difference", "0.1249").code == 6
    ok("compare", "box.ply", "moved.ply", "--max-difference", "0.1251")
    assert volvis("compare", "box.ply", "moved.ply", "--max-difference", "124.9um").code == 6
    ok("compare", "box.ply", "moved.ply", "--max-difference", "125.1um")
    says(fails(2, "compare", "box.ply", "moved.ply", "--max-difference", "1parsec"), "--max-difference: ", "unknown unit 'parsec'")
    says(ok("compare", "box.ply", "moved.ply").text, "8 vertices, 12 triangles, 1 piece", "22", "Hausdorff", "0.125 mm apart")
    measured = ok("measure", "distance", "box.ply", "moved.ply", "--json").json
    for key in "hausdorff", "a_to_b_mean", "a_to_b_rms", "b_to_a_mean", "distance":
        assert measured[key] == told[key], key


def test_meshes_that_are_the_same_are_told_so():
    write_box()
    told = ok("compare", "box.ply", "box.ply", "--max-difference", 0, "--json").json
    assert told["identical"] and told["hausdorff"] == told["a_to_b_mean"] == 0 and told["same_data"], told
    says(ok("compare", "box.ply", "box.ply").text, "same places", "the same, of the same vertices")
    ok("convert", "box.ply", "-o", "um.ply", "--unit", "um")
    told = ok("compare", "box.ply", "um.ply", "--max-difference", 1e-5, "--json").json
    assert not told["same_world"] and not told["identical"] and told["b"]["unit"] == "mm", told
    says(ok("compare", "box.ply", "um.ply").text, "mm, um")
    ok("convert", "box.ply", "-o", "box.stl")  # in another order, and without unit
    told = ok("compare", "box.ply", "box.stl", "--input-unit", "mm", "--max-difference", 0, "--json").json
    assert told["hausdorff"] < 1e-6 and told["bounds_difference"] == 0 and told["same_world"], told
    with open("two.obj", "w", encoding="ascii") as file:
        file.write(TWO)
    assert ok("compare", "two.obj:body", "two.obj:0", "--json").json["identical"]
    told = ok("compare", "two.obj:body", "two.obj:1", "--json").json
    assert abs(told["distance"] - 14 / 3 ** 0.5) < 1e-5 and told["b"]["volume"] is None, told


def test_what_cannot_be_compared_with_a_mesh_is_said():
    write_box()
    write_ball("ball.nrrd", 8)
    ok("render", "ball.nrrd", "-o", "a.png", "--size", "16x16")
    says(fails(2, "compare", "box.ply", "ball.nrrd"), "box.ply", "is a mesh", "'ball.nrrd' a volume", "isosurface")
    says(fails(2, "compare", "ball.nrrd", "box.ply"), "box.ply", "is a mesh", "'ball.nrrd' a volume")
    says(fails(2, "compare", "box.ply", "a.png"), "a.png", "picture", "'box.ply'")
    says(fails(2, "compare", "box.ply", "box.ply", "--psnr", 40), "--psnr", "--max-difference")
    ok("isosurface", "ball.nrrd", "-o", "empty.ply", "--iso", 1e6)
    told = volvis("compare", "box.ply", "empty.ply", "--json")
    assert told.code == 6 and told.json["differs"] and told.json["hausdorff"] is None, told.json
    assert ok("compare", "empty.ply", "empty.ply", "--json").json["identical"]


def test_meshes_are_read_safely_too():
    write_box()
    for words in (("info", "box.ply"), ("measure", "area", "box.ply"), ("info", "-")):
        with open("box.ply", "rb") as file:
            plain, safe = (ok(*words, *more, stdin=file.seek(0) or file.read()) for more in ((), ("--safe",)))
        assert (safe.out, safe.message) == (plain.out, plain.message) and safe.out
    ok("smooth", "box.ply", "-o", "plain.ply")
    ok("smooth", "box.ply", "-o", "safe.ply", "--safe")
    with open("plain.ply", "rb") as plain, open("safe.ply", "rb") as safe:
        assert plain.read() == safe.read()


def test_pipes_carry_meshes():
    write_box()
    for name, _, _ in meshes():
        with open("box.ply", "rb") as file:
            made = subprocess.run([VOLVIS, "convert", "-", "--input-format", "ply", "-o", "-", "--output-format", name],
                                  stdin=file, capture_output=True, env=environment(), timeout=60)
        assert made.returncode == 0, made.stderr
        cat = subprocess.Popen(["cat"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        told = subprocess.Popen([VOLVIS, "info", "-", "--input-format", name, "--json"], stdin=cat.stdout,
                                stdout=subprocess.PIPE, env=environment())
        cat.stdin.write(made.stdout)
        cat.stdin.close()
        assert b'"closed": true' in told.communicate(timeout=60)[0], name


def test_binary_stl_is_known_by_its_triangles():
    write_box()
    write_ball("ball.nrrd", 24)
    ok("isosurface", "ball.nrrd", "-o", "ball.ply", "--iso", 100)
    for name in "box", "ball":  # less and more than what is looked at first
        ok("convert", name + ".ply", "-o", "a.stl", "--overwrite")
        with open("a.stl", "rb") as file:
            data = file.read()
        # others write a header of words, and no normals
        bare = data[:84] + b"".join(bytes(12) + data[at + 12:at + 50] for at in range(84, len(data), 50))
        for text in data, bare, b"solid by others".ljust(80) + bare[80:]:
            cat = subprocess.Popen(["cat"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
            told = subprocess.Popen([VOLVIS, "info", "-", "--json"], stdin=cat.stdout, stdout=subprocess.PIPE,
                                    env=environment())
            cat.stdin.write(text)
            cat.stdin.close()
            said = told.communicate(timeout=60)[0]
            assert b'"format": "stl"' in said and b'"closed": true' in said, said
    with open("not.bin", "wb") as file:
        file.write(data[:84] + bytes(len(data) - 84))
    fails(2, "info", "not.bin")


def test_a_mesh_has_no_value_of_a_surface():
    write_box()
    write_ball("ball.nrrd", 16)
    small = ("--size", "16x16", "--overwrite", "-o", "a.png")
    says(fails(2, "render", "box.ply", "--iso", 5, *small), "--iso does nothing", "isosurface")
    assert "--iso" not in ok("render", "box.ply", *small).message
    assert "--iso" not in ok("render", "ball.nrrd", "box.ply", "--method", "surface", "--iso", 50, *small).message


def test_a_vertex_that_cannot_be_is_told_with_its_face():
    write_box()
    with open("box.ply", encoding="ascii") as file:
        lines = file.read().split("\n")
    lines[19] = "4 2 6 -2 3"
    with open("wrong.ply", "w", encoding="ascii") as file:
        file.write("\n".join(lines))
    says(fails(3, "info", "wrong.ply"), "wrong.ply", "face 1", " names vertex -2;", "there are 8 vertices, counted from 0")
    ok("convert", "box.ply", "-o", "good.ply")
    with open("good.ply", "rb") as file:
        data = file.read()
    for kind in b"uint", b"int":  # of what is written and what others write
        head = data.replace(b"list uchar int", b"list uchar " + kind)
        with open("wrong.ply", "wb") as file:
            file.write(head[:-4] + b"\xfe\xff\xff\xff")
        says(fails(3, "info", "wrong.ply"), "vertex -2;" if kind == b"int" else "vertex 4294967294")


def test_long_names_of_parts_are_not_cut_in_silence():
    write_box()
    ok("convert", "box.ply", "-o", "box.obj")
    with open("box.obj", encoding="utf-8") as file:
        lines = [line for line in file.read().split("\n") if not line.startswith(("g ", "o "))]
    first = next(i for i, line in enumerate(lines) if line.startswith("f "))
    for length, said in (63, False), (64, True):
        with open("named.obj", "w", encoding="utf-8") as file:
            file.write("\n".join([*lines[:first], "o " + length * "n", *lines[first:]]))
        told = ok("info", "named.obj", "--json")
        assert told.json["parts"][0]["name"] == 63 * "n", told.json
        assert ("more than 63 bytes" in told.message) == said, told.message


def test_long_names_of_parts_are_told_of_ply_and_gltf():
    write_box()
    ok("convert", "box.ply", "-o", "box.obj")
    with open("box.obj", encoding="utf-8") as file:
        text = file.read()
    first = text.index("\nf ") + 1
    with open("named.obj", "w", encoding="utf-8") as file:
        file.write(text[:first] + "o " + 63 * "n" + "\n" + text[first:])
    ok("convert", "named.obj", "-o", "named.ply")
    ok("convert", "named.obj", "-o", "named.gltf")
    for path in "named.ply", "named.gltf":
        with open(path, "rb") as file:
            data = file.read()
        assert "63 bytes" not in ok("info", path).message
        with open("long." + path, "wb") as file:
            file.write(data.replace(63 * b"n", 70 * b"n"))
        told = ok("info", "long." + path, "--json")
        assert told.json["parts"][0]["name"] == 63 * "n", told.json
        says(told.message, "more than 63 bytes")


def test_lengths_change_their_unit():
    write_box()
    ok("convert", "box.ply", "-o", "um.ply", "--unit", "um")
    told = ok("info", "um.ply", "--json").json
    assert told["unit"] == "um" and told["hi"] == [1000, 2000, 3000], told
    says(fails(2, "convert", "box.ply", "-o", "a.ply", "--unit", "furlong"), "furlong")


def test_meshes_of_voxels_get_their_lengths():
    write_box()
    with open("box.ply", encoding="ascii") as file:
        text = file.read()
    with open("voxels.ply", "w", encoding="ascii") as file:
        file.write(text.replace(" mm", " voxels"))
    assert ok("info", "voxels.ply", "--json").json["unit"] == "voxels"
    says(fails(2, "convert", "voxels.ply", "-o", "a.ply", "--unit", "mm"), "--input-unit 0.5mm")
    ok("convert", "voxels.ply", "-o", "cm.ply", "--input-unit", "0.5mm", "--unit", "cm")
    told = ok("info", "cm.ply", "--json").json
    assert told["unit"] == "cm" and abs(told["hi"][2] - 0.15) < 1e-7, told
    assert ok("info", "voxels.ply", "--input-unit", "um", "--json").json["unit"] == "um"
    says(volvis("info", "box.ply", "--input-unit", "um").message, "is kept")
    fails(2, "info", "voxels.ply", "--input-unit", "-1mm")


def test_a_unit_that_gets_lost_is_told_once():
    write_box()
    for name, words in ("a.stl", ["--encoding", "ascii"]), ("a.off", ["--encoding", "binary"]), ("cm.stl", ["--unit", "cm"]):
        said = ok("convert", "box.ply", "-o", name, *words).message
        assert said.count("warning") == 1 and ("mm" in said or "cm" in said), said
    for name in "b.stl", "b.off", "b.obj", "b.ply", "b.glb", "b.vtp":
        assert "warning" not in ok("convert", "box.ply", "-o", name).message, name


def test_which_axis_points_up_comes_back_or_its_loss_is_told():
    def up(name):
        """As a comment of OFF says it."""
        ok("convert", name, "-o", "up.off", "--overwrite")
        with open("up.off", encoding="ascii") as file:
            return next(line for line in file if line.startswith("# up: "))[6]
    with open("y.obj", "w", encoding="ascii") as file:
        file.write("# up: y\nv 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    for name in "a.stl", "a.off", "a.obj", "a.ply", "a.glb", "a.vtp":
        assert "warning" not in ok("convert", "y.obj", "-o", name).message, name
        assert up(name) == "y", name
    for name, encoding in ("b.off", "binary"), ("b.stl", "ascii"):
        said = ok("convert", "y.obj", "-o", name, "--encoding", encoding).message
        assert said.count("warning") == 1 and "y points up" in said, said
        assert up(name) == "z", name


def test_meshes_and_volumes_are_told_apart():
    write_box()
    write_ball("head.nrrd", 8)
    says(fails(2, "convert", "head.nrrd", "-o", "head.ply"), "isosurface")
    says(fails(2, "convert", "head.nrrd", "-o", "head.x", "--output-format", "stl"), "isosurface")
    says(fails(3, "convert", "box.ply", "-o", "box.nrrd"), "is a mesh")
    says(fails(2, "convert", "box.ply", "-o", "box.stl", "--type", "u8"), "--type")
    says(fails(2, "info", "box.ply", "--stats"), "--stats")
    says(fails(1, "render", "box.ply", "-o", "a.png", "--method", "raycast", "--mode", "maximum"), "mesh")
    says(fails(2, "convert", "box.ply", "-o", "box.ply"), "--overwrite")
    says(fails(2, "convert", "box.ply", "-o", "box.stl", "--encoding", "zlib"), "no encoding 'zlib'")


def test_colours_of_parts_lie_beside_an_obj():
    with open("two.obj", "w", encoding="ascii") as file:
        file.write("mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\no a\nusemtl red\nf 1 2 3\no b\nf 2 4 3\n")
    with open("two.mtl", "w", encoding="ascii") as file:
        file.write("newmtl red\nKd 1 0 0\n")
    told = ok("info", "two.obj", "--json").json
    assert [part["name"] for part in told["parts"]] == ["a", "b"], told
    assert told["parts"][0]["color"] == [1, 0, 0, 1], told
    ok("convert", "two.obj", "-o", "out.obj")
    assert os.path.exists("out.mtl")
    assert ok("info", "out.obj", "--json").json["parts"] == told["parts"]
    os.mkdir("inside")
    with open("inside/out.obj", "w", encoding="ascii") as file:
        file.write("mtllib ../two.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n")
    told = ok("info", "inside/out.obj", "--json").json
    assert "color" not in told["parts"][0] and "--allow-outside" in told["warnings"][0], told
    assert ok("info", "inside/out.obj", "--allow-outside", "--json").json["parts"][0]["color"] == [1, 0, 0, 1]


def test_an_unknown_file_is_called_so_whatever_is_to_be_made_of_it():
    with open("teapot.g", "w", encoding="ascii") as file:
        file.write("teapot of some other program\n1 2 3\n")
    said = fails(3, "convert", "teapot.g", "-o", "x.ply")
    says(said, "teapot.g", "known format")


def write_instances(path, n_triangles, n_nodes, n_primitives=1):
    """glTF of one object, triangles of their own three vertices each, that stands in n_nodes places side by side."""
    data = b"".join(struct.pack("<9f", i, 0, 0, i + 1, 0, 0, i, 1, 0) for i in range(n_triangles))
    uri = "data:;base64," + base64.b64encode(data).decode()
    tree = {"asset": {"version": "2.0"}, "buffers": [{"uri": uri, "byteLength": len(data)}],
            "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(data)}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3 * n_triangles, "type": "VEC3"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}] * n_primitives}],
            "nodes": [{"mesh": 0, "translation": [0, i, 0]} for i in range(n_nodes)],
            "scenes": [{"nodes": list(range(n_nodes))}], "scene": 0}
    with open(path, "w", encoding="ascii") as file:
        json.dump(tree, file)


def cost(*words):
    """Processor time of the program, seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = volvis(*words)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return result, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def test_objects_in_many_places_are_counted_before_they_are_made():
    write_instances("few.gltf", 5, 7)
    told = ok("info", "few.gltf", "--json").json
    assert (told["triangles"], told["vertices"]) == (35, 105), told
    write_instances("bomb.gltf", 2000, 3000)  # 6 million triangles of 0.3 MB
    for words in (), ("--safe",):
        said, seconds = cost("info", "bomb.gltf", *words)
        assert said.code == 3 and seconds < 2, (said.code, seconds)
        says(said.message, "bomb.gltf", "3000 objects", "6000000 triangles", "--limit expansion_mesh=N")
    write_instances("empty.gltf", 0, 3000, 3000)  # 9 million objects of nothing
    said, seconds = cost("info", "empty.gltf")
    assert said.code == 3 and seconds < 2, (said.code, seconds, said.message)
    write_instances("some.gltf", 2000, 40)
    assert ok("info", "some.gltf", "--json", "--limit", "expansion_mesh=1").json["triangles"] == 80000


def test_many_small_objects_cost_what_they_are():
    write_instances("small.gltf", 1, 60000)
    said, seconds = cost("info", "small.gltf", "--json")
    assert said.json["triangles"] == 60000
    assert seconds < 3, seconds  # 0.5 s on a quiet machine


main()
