"""Which files a server reads, and where: below its root whenever they are opened, and by the import program."""
import json
import os
import shutil
import subprocess
import urllib.parse

import harness
from harness import main, ok, write_ball, write_box
from page import Page, Server, run

try:
    import websockets  # noqa: F401
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")


def test_a_file_that_becomes_a_link_outside_is_not_read_at_the_next_frame():
    os.makedirs("a/sub")
    os.makedirs("elsewhere")
    write_ball("a/sub/ball.nrrd", 16)
    write_ball("elsewhere/ball.nrrd", 24)
    write_box("elsewhere/box.ply")
    write_box("a/box.ply")

    async def work(server, exchange, back):
        async with Page(server) as page:
            await page.ask("open", path="sub/ball.nrrd")
            await page.resting()
            name = next(iter(page.world["world"]["datasets"]))
            assert (await page.ask("info", dataset=name))["dims"] == [16, 16, 16]
            exchange()
            said = await page.refused("info", dataset=name)
            assert "outside" in said and "24" not in said, said
            await page.say("size", width=200, height=100)  # a frame, without a commit
            await page.until(lambda: [m for m in page.messages if m["type"] in ("notice", "failed") and "outside" in m["text"]])
            await page.refused("open", path="sub/ball.nrrd")
            back()
            assert (await page.ask("info", dataset=name))["dims"] == [16, 16, 16]

    def link_file():
        os.rename("a/sub/ball.nrrd", "a/sub/real.nrrd")
        os.symlink(os.path.abspath("elsewhere/ball.nrrd"), "a/sub/ball.nrrd")

    def unlink_file():
        os.rename("a/sub/real.nrrd", "a/sub/ball.nrrd")

    def link_folder():
        os.rename("a/sub", "a/real")
        os.symlink(os.path.abspath("elsewhere"), "a/sub")

    def unlink_folder():
        os.unlink("a/sub")
        os.rename("a/real", "a/sub")
    for words in ((), ("--no-safe",)):
        for exchange, back in ((link_file, unlink_file), (link_folder, unlink_folder)):
            with Server("--root", "a", *words, verb="serve") as server:
                run(work(server, exchange, back))


def test_what_is_not_there_does_not_lead_back():
    os.makedirs("a")
    write_ball("a/ball.nrrd", 16)
    write_ball("outside.nrrd", 24)

    async def work(server):
        async with Page(server) as page:
            root = os.path.abspath("a")
            for path in (f"{root}/later/../../outside.nrrd", f"{root}/later/../later.nrrd", f"{root}/later/.."):
                said = await page.refused("edit", edits=[
                    {"op": "add", "path": "datasets", "id": "x", "value": {"path": path}}])
                assert "outside" in said, said
            await page.edit(("set", "title", "alive"))
    with Server("ball.nrrd" if os.path.exists("ball.nrrd") else "a/ball.nrrd", "--root", "a", verb="serve") as server:
        run(work(server))


def test_files_that_were_given_may_lie_anywhere_with_their_data():
    os.makedirs("a")
    os.makedirs("given")
    with open("given/d.nhdr", "w", encoding="ascii") as file:
        file.write("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 8\nencoding: raw\ndata file: d.raw\n\n")
    with open("given/d.raw", "wb") as file:
        file.write(bytes(range(256)) * 2)
    write_box("given/box.ply")
    for name in ("d.nhdr", "d.raw"):
        shutil.copy(os.path.join("given", name), "a")
    for words in ((), ("--no-safe",)):
        with Server("given/d.nhdr", "given/box.ply", "--root", "a", *words, verb="serve") as server:
            async def work():
                async with Page(server) as page:
                    await page.resting()
                    assert (await page.ask("info", dataset="d"))["dims"] == [8, 8, 8]
                    await page.ask("open", path="d.nhdr")  # and below the root just so
                    assert (await page.ask("info", dataset="d"))["dims"] == [8, 8, 8]
                    await page.resting()
                    saved = await page.ask("save", path="kept", replace=True)
                    assert saved["path"] == "/kept.vv.json", "it tells where the root is"
                    assert os.path.exists("a/kept.vv.json")
                    assert not errors(page)
            run(work())


def test_a_scene_of_a_newer_schema_is_told_to_the_page_as_in_a_terminal():
    os.makedirs("a")
    write_ball("a/ball.nrrd", 16)
    for name, schema in (("newer", 99), ("ours", 1)):
        with open(f"a/{name}.vv.json", "w", encoding="ascii") as file:
            json.dump({"schema": schema, "datasets": {"ball": {"path": "ball.nrrd"}}, "volumes": {"ball": {"data": "ball"}}}, file)
    sentence = "newer.vv.json: schema version 99 is newer than 1: unknown properties are kept but have no effect"
    assert sentence in ok("render", "a/newer.vv.json", "-o", "a.png", "--size", "16x16").message

    async def work(server):
        async with Page(server) as page:
            for add in (False, True):
                page.messages.clear()
                await page.ask("open", path="newer.vv.json", add=add)
                await page.until(lambda: [m for m in page.messages if m["type"] == "notice" and m["text"] == sentence])
            page.messages.clear()
            await page.ask("open", path="ours.vv.json")
            assert not [m for m in page.messages if m["type"] == "notice" and "schema" in m["text"]], page.messages
    with Server("a/ball.nrrd", "--root", "a", verb="serve") as server:
        run(work(server))


def test_what_lies_behind_a_link_outside_is_not_listed():
    os.makedirs("a/sub")
    os.makedirs("elsewhere/deep")
    for name in ("a/ball.nrrd", "elsewhere/ball.nrrd"):
        write_ball(name, 16)
    links = {"out.nrrd": "../elsewhere/ball.nrrd", "far.nrrd": os.path.abspath("elsewhere/ball.nrrd"), "folder": "../elsewhere",
             "passwd": "/etc/passwd", "self": "/proc/self", "nowhere": "not there", "round": "round", "twice": "out.nrrd",
             "in.nrrd": "ball.nrrd", "back.nrrd": os.path.abspath("a/ball.nrrd"), "sub/up.nrrd": "../ball.nrrd"}
    for name, target in links.items():
        os.symlink(target, os.path.join("a", name))
    size = os.path.getsize("a/ball.nrrd")

    async def work(server):
        async with Page(server) as page:
            top = (await page.ask("browse", path=""))["entries"]
            assert [e["name"] for e in top] == ["sub", "back.nrrd", "ball.nrrd", "in.nrrd"], top
            assert [(e["bytes"], e["kind"]) for e in top[1:]] == [(size, "volume")] * 3, top
            assert [e["name"] for e in (await page.ask("browse", path="sub"))["entries"]] == ["up.nrrd"]
            assert await page.refused("browse", path="folder")
    with Server("--root", "a", verb="serve") as server:
        run(work(server))
    with Server("a/ball.nrrd") as server:  # a root that is all of the system
        async def everywhere():
            async with Page(server) as page:
                names = [e["name"] for e in (await page.ask("browse", path=os.path.abspath("a")))["entries"]]
                assert set(links) - {"nowhere", "round", "sub/up.nrrd"} < set(names), names
        run(everywhere())


def test_a_folder_that_is_a_volume_is_listed_as_one_and_opened():
    os.makedirs("a/scans")
    write_ball("ball.nrrd", 16)
    ok("convert", "ball.nrrd", "-o", "a/scans/ball.ome.zarr")

    async def work(server):
        async with Page(server) as page:
            assert [(e["name"], e["folder"], e["kind"]) for e in (await page.ask("browse", path=""))["entries"]] == [
                ("scans", True, None)]
            assert [(e["name"], e["folder"], e["kind"]) for e in (await page.ask("browse", path="scans"))["entries"]] == [
                ("ball.ome.zarr", True, "volume")]
            await page.ask("open", path="scans/ball.ome.zarr")
            await page.until(lambda: page.world["world"].get("datasets"))
            [name] = page.world["world"]["datasets"]
            assert (await page.ask("info", dataset=name))["dims"] == [16, 16, 16]
            await page.resting()
            assert not errors(page)
    with Server("--root", "a", verb="serve") as server:
        run(work(server))


def alone(name="alone"):
    """The program without its import program: what that would read is not read at all."""
    os.makedirs(name)
    shutil.copy(harness.VOLVIS, name)
    program = os.path.abspath(os.path.join(name, os.path.basename(harness.VOLVIS)))
    if subprocess.run([program, "info", "--safe", "ball.nrrd"], capture_output=True).returncode == 0:
        raise harness.Skip("an import program is installed")
    return program


def write_plate(folder):
    """Wells as images of one group, which are told apart by how many samples they have."""
    for i, well in enumerate(("A/1", "B/3")):
        write_ball("ball.nrrd", 10 + i)
        ok("convert", "ball.nrrd", "-o", f"{well[0]}.ome.zarr")
        shutil.copytree(f"{well[0]}.ome.zarr", f"{folder}/{well}/0")
    groups = {"A": {}, "B": {}, "A/1": {"well": {"version": "0.4", "images": [{"path": "0"}]}}, "": {"plate": {
        "version": "0.4", "rows": [{"name": "A"}, {"name": "B"}], "columns": [{"name": "1"}, {"name": "3"}],
        "wells": [{"path": "A/1", "rowIndex": 0, "columnIndex": 0}, {"path": "B/3", "rowIndex": 1, "columnIndex": 1}]}}}
    for group, attributes in {**groups, "B/3": groups["A/1"]}.items():
        for name, value in {".zgroup": {"zarr_format": 2}, ".zattrs": attributes}.items():
            with open(os.path.join(folder, group, name), "w", encoding="utf-8") as file:
                json.dump(value, file)


def test_parts_of_a_folder_are_opened_by_name():
    write_plate("a/plate.zarr")
    write_ball("secret.nrrd", 20)
    ok("convert", "secret.nrrd", "-o", "secret.ome.zarr")

    async def work(server):
        async with Page(server) as page:
            for name, n in (("plate.zarr", 10), ("plate.zarr:B/3/0", 11), ("plate.zarr:A/1", 10)):
                await page.ask("open", path=name)
                await page.until(lambda: page.world["world"].get("datasets"))
                [dataset] = page.world["world"]["datasets"]
                assert (await page.ask("info", dataset=dataset))["dims"] == [n] * 3, name
                await page.resting()
            for name in ("plate.zarr:C/1/0", "plate.zarr:../../secret.ome.zarr", "no.zarr:B/3/0", ":", "plate.zarr:B:3",
                         "../secret.ome.zarr:0"):
                assert await page.refused("open", path=name), name
            assert not errors(page)
    with Server("--root", "a", verb="serve") as server:
        run(work(server))


PICTURES = ("png", "jpg", "tif", "webp", "exr", "pdf")


def test_scenes_of_pictures_are_read_by_the_import_program_and_are_what_they_were():
    os.makedirs("a")
    write_ball("a/ball.nrrd", 16)
    for i, suffix in enumerate(PICTURES):
        ok("render", "a/ball.nrrd", "--size", "16", "--background", f"#00000{i + 1}", "-o", f"a/pic.{suffix}")

    async def work(server):
        async with Page(server) as page:
            for i, suffix in enumerate(PICTURES):
                await page.ask("open", path=f"pic.{suffix}")
                await page.until(lambda: page.world["world"].get("background") == f"#00000{i + 1}")
            with open("a/pic.png", "rb") as file:
                whole = file.read()
            for n in (30, 100, len(whole) // 2):  # cut short, they are no scenes, and nothing ends
                with open("a/cut.png", "wb") as file:
                    file.write(whole[:n])
                await page.answer("open", path="cut.png")
            await page.ask("open", path="ball.nrrd")
    with Server("--root", "a", verb="serve") as server:
        run(work(server))


def test_serve_reads_all_and_view_reads_uploads_in_the_import_program():
    os.makedirs("a")
    write_ball("ball.nrrd", 16)
    write_ball("a/ball.nrrd", 16)
    write_box("a/box.ply")
    for suffix in PICTURES:
        ok("render", "a/ball.nrrd", "--size", "16", "-o", f"a/pic.{suffix}")
    with open("a/ball.nrrd", "rb") as file:
        ball = file.read()
    with open("a/pic.png", "rb") as file:
        picture = file.read()
    with open("a/box.ply", "rb") as file:
        box = file.read()
    whole, harness.VOLVIS = harness.VOLVIS, alone()
    import served as pages
    pages.VOLVIS = harness.VOLVIS
    try:
        with Server("--root", "a", verb="serve") as server:
            async def served():
                async with Page(server) as page:
                    for name in ("ball.nrrd", "box.ply", *(f"pic.{suffix}" for suffix in PICTURES)):
                        assert "import program" in await page.refused("open", path=name)
            run(served())
        with Server("ball.nrrd") as server:
            async def viewed():
                async with Page(server) as page:
                    await page.resting()  # its own files are read in the program
                    for name, data in (("up.nrrd", ball), ("up.ply", box), ("up.png", picture)):
                        server.request(f"/files/{urllib.parse.quote(name)}", data, method="PUT", Cookie=server.cookie())
                        [path] = [os.path.join(at, name) for at, _, names in os.walk("state") if name in names]
                        assert "import program" in await page.refused("open", path=os.path.abspath(path))
                    await page.edit(("set", "volumes.ball.texture", {"kind": "image", "image": os.path.abspath("a/pic.png")}))
                    await page.resting()
                    assert not errors(page)
                    await page.edit(("set", "volumes.ball.texture.image", os.path.abspath(path)))  # the picture that was uploaded
                    await page.until(lambda: errors(page))
                    assert "import program" in errors(page)[0], errors(page)
            run(viewed())
    finally:
        harness.VOLVIS = pages.VOLVIS = whole


def errors(page, level="error"):
    """Notices of a level; of errors also what a frame failed by."""
    return [m["text"] for m in page.messages if (m["type"] == "notice" and m["level"] == level) or (m["type"] == "failed" and level == "error")]


def test_pictures_on_volumes_are_read_by_the_import_program_and_are_what_they_were():
    os.makedirs("a")
    write_ball("a/ball.nrrd", 16)
    for suffix in PICTURES[:-1]:
        ok("render", "a/ball.nrrd", "--size", "16", "--background", "#804020", "-o", f"a/pic.{suffix}")

    async def drawn(server):
        found = {}
        async with Page(server, 64, 64) as page:
            for suffix in PICTURES[:-1]:
                await page.edit(("set", "volumes.ball.texture", {"kind": "image", "image": os.path.abspath(f"a/pic.{suffix}")}))
                found[suffix] = (await page.resting()).data
            assert not errors(page), errors(page)
        return found
    with Server("a/ball.nrrd", "--root", "a", verb="serve") as server, Server("a/ball.nrrd", state="other") as own:
        assert run(drawn(server)) == run(drawn(own))


def test_a_font_below_the_root_is_read_only_where_it_was_given():
    os.makedirs("a")
    write_ball("a/ball.nrrd", 16)
    font = next((os.path.join(at, name) for at, _, names in os.walk("/usr/share/fonts") for name in sorted(names)
                 if name.endswith(".ttf") and ("Bold" in name or "Black" in name)), None)
    if not font:
        raise harness.Skip("there is no other font")
    shutil.copy(font, "a/font.ttf")

    async def drawn(server, path, given):
        async with Page(server, 200, 100) as page:
            await page.edit(("set", "views.main.decorations.caption", "mmmm iiii"))
            before = (await page.resting()).data
            await page.edit(("set", "views.main.decorations.font", path))
            after = (await page.resting()).data
            if not given:
                await page.until(lambda: errors(page, "warning"))  # it may come behind the picture
            return after != before, errors(page), errors(page, "warning")
    with open("a/stranger.vv.json", "w", encoding="utf-8") as file:
        json.dump({"schema": 1, "datasets": {"ball": {"path": "ball.nrrd"}}, "volumes": {"ball": {"data": "ball"}},
                   "views": {"main": {"decorations": {"font": "font.ttf", "caption": "mmmm iiii"}}}}, file)
    for shown, words, given in (("ball.nrrd", (), False), ("stranger.vv.json", (), False),
                                ("ball.nrrd", ("--set", f"views.main.decorations.font={os.path.abspath('a/font.ttf')}"), True)):
        with Server(f"a/{shown}", "--root", "a", *words, state=f"state{given}{shown}", verb="serve") as server:
            changed, failed, warned = run(drawn(server, os.path.abspath("a/font.ttf"), given))
            assert not failed, failed
            assert bool(warned) != given and (given or (not changed and "a font is read here only" in warned[0])), (changed, warned)
    # with --safe a scene's font is not read by the program either, and what the command line names is
    for words, warned in (((), False), (("--safe",), True), (("--safe", "--set", "views.main.decorations.font=a/font.ttf"), False)):
        run_ = harness.volvis("render", "a/stranger.vv.json", "--size", "200x100", "-o", "o.png", "--overwrite", *words)
        assert run_.code == 0 and ("a font is read here only" in run_.message) == warned, (words, run_.message)


def test_images_on_meshes_are_read_below_the_root_and_shown():
    from PIL import Image
    import io
    import struct
    import urllib.request
    os.makedirs("a")
    Image.new("RGB", (5, 3), (200, 40, 10)).save("a/red.png")
    Image.new("RGB", (5, 3), (10, 40, 200)).save("outside.png")
    for name, image in (("in", "red.png"), ("out", "../outside.png"), ("link", "link.png")):
        with open(f"a/{name}.mtl", "w") as file:
            file.write(f"newmtl m\nKd 1 1 1\nmap_Kd {image}\n")
        with open(f"a/{name}.obj", "w") as file:
            file.write(f"# up: z\nmtllib {name}.mtl\n" + "".join(f"v {i % 2} {i // 2 % 2} {i // 4}\n" for i in range(8)))
            file.write("vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\n")
            for face in ((1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)):
                file.write("f " + " ".join(f"{v}/{k + 1}" for k, v in enumerate(face)) + "\n")
    os.symlink("../outside.png", "a/link.png")

    async def work(server):
        async with Page(server, 64, 64) as page:
            for name, seen in (("in.obj", True), ("out.obj", False), ("link.obj", False)):
                await page.ask("open", path=name)
                await page.edit(("set", "shading.model", "none"), ("set", "cut_planes", [{"normal": [1, 1, 1], "offset": 1}]))
                image = Image.open(io.BytesIO((await page.resting()).data)).convert("RGB")
                colors = {c for n, c in image.getcolors(4096)}
                near = [c for c in colors if max(abs(a - b) for a, b in zip(c, (200, 40, 10))) < 12]
                assert bool(near) == seen and not [c for c in colors if c[2] > c[0] + 60], (name, colors)
                shape = await page.ask("shape", method="reduced")
                part = shape["parts"][0]
                assert part["solid"] and len(part["planes"]) == 1, part
                request = urllib.request.Request(server.base + part["url"], headers={"Cookie": server.cookie()})
                data = urllib.request.urlopen(request).read()
                vertices, triangles = struct.unpack("<II", data[104:112])
                assert vertices == 6 * 4 and struct.unpack("<H", data[6:8])[0] & 1  # faces are flat up to their edges
                found = data[112 + 12 * triangles:][:4]
                assert (max(abs(a - b) for a, b in zip(found, (200, 40, 10))) <= 1) == seen, (name, tuple(found))
    with Server("a/in.obj", "--root", "a", verb="serve") as server:
        run(work(server))


if __name__ == "__main__":
    main()
