"""The server from outside: who is let in, what a page can do, and what survives."""
import asyncio
import base64
from concurrent.futures import ThreadPoolExecutor
import difflib
import http.client
import io
import itertools
import json
import os
import re
import signal
import socket
import stat
import struct

import numpy as np
from PIL import Image

from harness import Skip, fails, main, ok, says, write_cells
from page import Page, Server, run
from wire import wait_for

try:
    import websockets
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")


def write_ball(path="ball.nrrd", n=40):
    axis = np.arange(n) - (n - 1) / 2
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    values = np.clip(255 * (1.2 - np.sqrt(x * x + y * y + 0.5 * z * z) / (n / 2)), 0, 255).astype(np.uint8)
    with open(path, "wb") as file:
        file.write(f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {n} {n} {n}\nspacings: 1 1 1.5\nencoding: raw\n\n"
                   .encode())
        file.write(values.tobytes())


def pixels(data):
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(float)


def psnr(a, b):
    assert a.shape == b.shape, (a.shape, b.shape)
    error = np.mean((a - b) ** 2)
    return float("inf") if error == 0 else 10 * np.log10(255 ** 2 / error)


def drag(points, seconds=0.0):
    """Lines of a left drag over these places."""
    lines = [f"0 mouse axis x {points[0][0]}", f"0 mouse axis y {points[0][1]}", "0 mouse button left down"]
    for i, (x, y) in enumerate(points[1:], 1):
        lines += [f"{i * 8000000} mouse axis x {x}", f"{i * 8000000} mouse axis y {y}"]
    return "\n".join(lines + [f"{len(points) * 8000000} mouse button left up"]) + "\n"


# Who is let in ------------------------------------------------------------------------------------------------------

def test_the_page_comes_with_strict_headers_and_only_under_the_servers_own_name():
    write_ball()
    with Server("ball.nrrd") as server:
        code, headers, body = server.request("/")
        assert code == 200
        assert "default-src 'self'" in headers["content-security-policy"]
        assert "unsafe" not in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff" and headers["referrer-policy"] == "no-referrer"
        assert not any(name.lower().startswith("access-control") for name in headers)
        for host in ("evil.example", f"evil.example:{server.port}", "localhost", f"localhost:{server.port + 1}", "[::2]"):
            assert server.request("/", Host=host)[0] == 403, host
        for origin in ("http://evil.example", "null", f"http://localhost:{server.port + 1}", "file://"):
            assert server.request("/", Origin=origin)[0] == 403, origin
        assert server.request("/", Sec_Fetch_Site="cross-site")[0] == 403
        for path in ("/../etc/passwd", "/%2e%2e/etc/passwd", "/files/../../etc/passwd", "/files/1/x", "/nothing"):
            assert server.request(path)[0] in (403, 404), path


def test_only_who_has_the_token_talks_and_guesses_are_slowed_down():
    write_ball()
    with Server("ball.nrrd") as server:
        def guess(_):
            return server.request("/session", json.dumps({"token": "0" * 64}).encode())[0]
        def guesses():
            with ThreadPoolExecutor(16) as together:
                codes = list(together.map(guess, range(64)))
            assert set(codes) <= {403, 429} and 403 in codes, codes
            return 429 in codes  # not where the machine takes a second for five
        wait_for(guesses, "64 guesses at once are slowed down")
        for body in (b"", b"{", b"[]", b'{"token": 1}'):
            assert server.request("/session", body)[0] in (403, 429)
        assert server.request("/files/x.nrrd", b"1", method="PUT")[0] == 403

        async def without_cookie():
            for headers, origin in (({}, server.base), ({"Cookie": f"volvis-{server.port}=" + "0" * 64}, server.base)):
                try:
                    await websockets.connect(f"ws://localhost:{server.port}/ws", subprotocols=["volvis"], origin=origin,
                                             extra_headers=headers)
                except (websockets.exceptions.WebSocketException, ConnectionError, OSError):
                    continue
                raise AssertionError("let in without the cookie")
        run(without_cookie())


def test_a_foreign_page_with_the_cookie_is_not_let_in():
    write_ball()
    with Server("ball.nrrd") as server:
        cookie = server.cookie()

        async def foreign():
            try:
                await websockets.connect(f"ws://localhost:{server.port}/ws", subprotocols=["volvis"],
                                         origin="http://evil.example", extra_headers={"Cookie": cookie})
            except (websockets.exceptions.WebSocketException, ConnectionError, OSError):
                return
            raise AssertionError("a foreign page was let in")
        run(foreign())


def test_the_page_comes_by_https_with_a_certificate():
    import shutil
    import ssl
    import subprocess
    import urllib.request
    write_ball()
    if not shutil.which("openssl"):
        raise Skip("openssl is missing: no certificate to serve with")
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", "key.pem", "-out", "cert.pem",
                    "-days", "2", "-subj", "/CN=localhost"], check=True, capture_output=True)
    context = ssl.create_default_context(cafile="cert.pem")
    with Server("ball.nrrd", "--tls-cert", "cert.pem", "--tls-key", "key.pem", verb="serve") as server:
        assert server.base.startswith("https://localhost:")
        request = urllib.request.Request(server.base + "/session", data=json.dumps({"token": server.token}).encode())
        with urllib.request.urlopen(request, context=context) as answer:
            cookie = answer.headers["set-cookie"]
        assert "Secure" in cookie and "HttpOnly" in cookie and "SameSite=Strict" in cookie

        async def look():
            async with websockets.connect(server.base.replace("https", "wss") + "/ws", subprotocols=["volvis"], ssl=context,
                                          origin=server.base, extra_headers={"Cookie": cookie.split(";")[0]}) as socket:
                await socket.send(json.dumps({"type": "hello", "width": 64, "height": 64}))
                while not isinstance(await socket.recv(), bytes):
                    pass
        run(look())
    from harness import fails
    says(fails(2, "serve", "--tls-cert", "ball.nrrd"), "certificate")


# Pictures -----------------------------------------------------------------------------------------------------------

def test_the_picture_at_rest_is_that_of_render():
    write_ball()
    with Server("ball.nrrd") as server:
        async def look():
            async with Page(server) as page:
                await page.resting()
                await page.say("events", lines=drag([(0, 0), (0.1, 0.05), (0.3, 0.2), (0.4, 0.3)]))
                frame = await page.resting()
                saved = await page.ask("save", path=os.path.abspath("turned.vv.json"))
                assert os.path.samefile(saved["path"], "turned.vv.json")
                return frame
        frame = run(look())
        assert frame.kind == 2 and (frame.width, frame.height) == (320, 240)
        ok("render", "turned.vv.json", "-o", "turned.png")
        with open("turned.png", "rb") as file:
            assert psnr(pixels(frame.data), pixels(file.read())) >= 40


def test_frames_that_move_are_quick_and_the_last_is_without_loss():
    write_ball()
    with Server("ball.nrrd") as server:
        async def turn():
            async with Page(server, 640, 480) as page:
                first = await page.resting()
                await page.say("events", lines="0 mouse axis x 0\n0 mouse button left down\n")
                steps = itertools.count(1)

                async def moves():
                    i = next(steps)
                    await page.say("events", lines=f"{i * 8000000} mouse axis x {0.4 * i / (i + 10)}\n")
                await page.until(lambda: sum(f.moving for f in page.frames) > 5, meanwhile=moves)
                last = await page.resting()
                moving = [f for f in page.frames if f.moving]
                return first, last, moving, page.world["world"]
        first, last, moving, world = run(turn())
        assert moving and all(f.kind == 1 for f in moving)
        assert last.kind == 2 and last.level == 2
        assert psnr(pixels(first.data), pixels(last.data)) < 60, "nothing has turned"
        assert "eye" in world["views"]["main"]["camera"]


def test_a_client_that_does_not_acknowledge_gets_one_frame():
    write_ball()
    with Server("ball.nrrd") as server:
        async def silent():
            async with Page(server, acknowledges=False) as page:
                await page.until(lambda: page.frames)
                for n in range(1, 100):
                    for name in ("left", "front"):
                        await page.say("action", name=name)
                        async with Page(server) as other:  # its picture is made by the same thread, in turn
                            await other.resting()
                    await page.told()
                    assert len(page.frames) == n, [f.number for f in page.frames]
                    await page.say("ack", frame=page.frames[-1].number)
                    await page.until(lambda: len(page.frames) > n)
                    if page.frames[-1].number > page.frames[-2].number + 1:  # one was never sent: a newer took its place
                        return
                raise AssertionError("each frame was sent that was made")
        run(silent())


# The World ----------------------------------------------------------------------------------------------------------

def test_edits_are_seen_by_all_and_each_takes_back_its_own():
    write_ball()
    with Server("ball.nrrd") as server:
        async def edit():
            async with Page(server) as ann, Page(server) as bob:
                assert ann.world and bob.world
                await ann.edit(("set", "title", "Ann's"))
                await bob.edit(("set", "unit", "mm"), ("set", "background", "#102030"))
                await bob.until(lambda: bob.world["world"].get("title") == "Ann's")
                await ann.until(lambda: ann.world["world"].get("background") == "#102030")
                await ann.ask("undo")
                await bob.until(lambda: "title" not in bob.world["world"])
                assert bob.world["world"]["unit"] == "mm"
                assert "nothing to undo" in await ann.refused("undo")
                await ann.ask("redo")
                await bob.until(lambda: bob.world["world"].get("title") == "Ann's")
                said = await ann.refused("edit", edits=[{"op": "set", "path": "titel", "value": "x"}])
                assert "did you mean 'title'" in said, said
                said = await ann.refused("edit", edits=[{"op": "set", "path": "seed", "value": 3},
                                                        {"op": "set", "path": "seed", "value": "x"}])
                assert "seed" not in ann.world["world"], "half of a commit"
        run(edit())


def test_a_gesture_is_one_step_for_undo():
    write_ball()
    with Server("ball.nrrd") as server:
        async def gesture():
            async with Page(server) as page:
                path = "volumes.ball.segmentation.transfer.opacity_scale"
                for i in range(30):
                    await page.edit(("set", path, 1 + i / 10), gesture="g1")
                await page.until(lambda: page.world["undo"])
                await page.ask("undo")
                await page.until(lambda: page.world["redo"])
                assert not page.world["undo"]
                assert "opacity_scale" not in json.dumps(page.world["world"])
        run(gesture())


def test_questions_are_answered():
    write_ball()
    with Server("ball.nrrd") as server:
        async def ask():
            async with Page(server) as page:
                await page.resting()
                hit = await page.ask("pick", x=0.5, y=0.5)
                assert hit["hit"] and hit["volume"] == "ball" and len(hit["position"]) == 3, hit
                assert not (await page.ask("pick", x=0, y=0))["hit"]
                histogram = await page.ask("histogram", volume="ball")
                assert sum(histogram["counts"]) == 40 ** 3 == histogram["n"]
                transfer = await page.ask("transfer", volume="ball")
                assert len(transfer["opacity"]) >= 2 and len(transfer["color"][0]) == 4
                info = await page.ask("info", dataset="ball")
                assert info["dims"] == [40, 40, 40] and info["spacing"] == [1, 1, 1.5]
                says((await page.ask("describe"))["text"], "ball", "40 by 40 by 40")
                await page.edit(("set", "background", "#ff0000"))
                command = (await page.ask("command"))["text"]
                says(command, "volvis render", "ball.nrrd", "background")
                for kind, more in (("pick", {"x": 2, "y": 0}), ("histogram", {"volume": "no"}), ("info", {"dataset": "no"}),
                                   ("open", {}), ("save", {})):
                    assert await page.refused(kind, **more)
        run(ask())


def test_proposals_are_worked_out_and_thumbnails_show_them():
    write_ball()
    with Server("ball.nrrd") as server:
        async def look():
            async with Page(server) as page:
                await page.resting()
                before = page.world
                found = await page.ask("proposals", volume="ball")
                assert [row["name"] for row in found] == ["fitted", "boundaries", "outside", "dense", "bands"]
                for row in found:
                    values = [node[0] for node in row["opacity"]]
                    assert row["doc"] and values == sorted(values) and row["opacity_length"] > 0
                    assert all(0 <= node[1] <= 1 for node in row["opacity"]) and len(row["color"]) > 1
                pictures = {}
                for name in ("fitted", "outside", "dense", "bands", "fog", "viridis"):
                    url = (await page.ask("thumbnail", volume="ball", preset=name))["picture"]
                    assert url.startswith("data:image/jpeg;base64,")
                    pictures[name] = pixels(base64.b64decode(url.split(",")[1]))
                    assert pictures[name].shape == (96, 128, 3) and pictures[name].max() > 20
                assert psnr(pictures["outside"], pictures["fog"]) < 40
                small = await page.ask("thumbnail", preset="fog", width=32, height=16)
                assert pixels(base64.b64decode(small["picture"].split(",")[1])).shape == (16, 32, 3)
                assert "'foggy'" in await page.refused("thumbnail", preset="foggy")
                assert "'x'" in await page.refused("thumbnail", preset="fog", volume="x")
                assert "'x'" in await page.refused("proposals", volume="x")
                assert "512" in await page.refused("thumbnail", preset="fog", width=5000)
                assert page.world["world"] == before["world"]  # it was only looked at
                # what was proposed is what is shown when it is chosen
                await page.edit(("set", "volumes.ball.segmentation.transfer.preset", "dense"))
                shown = await page.ask("transfer", volume="ball")
                assert shown == {key: found[3][key] for key in ("opacity", "color", "opacity_length")}
        run(look())


def run_lines(lines):
    import shlex
    for line in lines.split("\n"):
        words = shlex.split(line)
        assert words[0] == "volvis", line
        ok(*words[1:])
    with open("picture.png", "rb") as file:
        return pixels(file.read())


def test_a_command_line_makes_the_same_picture():
    write_ball()
    with Server("ball.nrrd") as server:
        async def ask():
            async with Page(server) as page:
                await page.resting()
                await page.edit(("set", "background", "#203040"),
                                ("set", "volumes.ball.cut_planes", [{"normal": [1, 0, 0], "offset": 18}]))
                await page.say("events", lines=drag([(0, 0), (0.2, 0.1)]))
                frame = await page.resting()
                return frame, (await page.ask("command"))["text"]
        frame, command = run(ask())
    assert command.startswith("volvis render ")
    assert psnr(run_lines(command), pixels(frame.data)) >= 40, command


def test_operations_make_data_that_can_be_taken_back():
    write_ball()
    with Server("ball.nrrd") as server:
        async def smooth():
            async with Page(server) as page:
                before = await page.resting()
                made = await page.ask("run", operation="gaussian", dataset="ball", parameters={"sigma": "3vox"})
                await page.until(lambda: page.world["world"]["volumes"]["ball"]["data"] == made["dataset"])
                assert any(m["type"] == "job" and m["state"] == "done" for m in page.messages)
                after = await page.resting()
                assert psnr(pixels(before.data), pixels(after.data)) < 45
                await page.ask("undo")
                await page.until(lambda: page.world["world"]["volumes"]["ball"]["data"] == "ball")
                assert "sigma" in await page.refused("run", operation="gaussian", dataset="ball",
                                                     parameters={"sigma": "x"})
                said = await page.refused("run", operation="gausian", dataset="ball", parameters={})
                assert "gaussian" in said, said
        run(smooth())


def test_a_surface_is_made_simplified_and_smoothed_in_its_place():
    write_ball(n=64)
    with Server("ball.nrrd") as server:
        async def work():
            async with Page(server) as page:
                before = await page.resting()
                surface = (await page.ask("run", operation="isosurface", dataset="ball", parameters={"iso": 150}))["dataset"]
                await page.until(lambda: page.world["world"]["volumes"]["ball"]["data"] == surface)
                assert page.world["world"]["datasets"][surface] == {"operation": "isosurface", "inputs": {"volume": "ball"},
                                                                   "parameters": {"iso": 150}}
                shown = await page.resting()
                few = (await page.ask("run", operation="simplify", dataset=surface, parameters={"share": 0.1}))["dataset"]
                smooth = (await page.ask("run", operation="smooth", dataset=few, parameters={}))["dataset"]
                await page.until(lambda: page.world["world"]["volumes"]["ball"]["data"] == smooth)
                said = [await page.refused("run", operation="smooth", dataset="ball", parameters={}),
                        await page.refused("run", operation="gaussian", dataset=few, parameters={}),
                        await page.refused("run", operation="isosurface", dataset="ball", parameters={"iso": 1000})]
                says_all = zip(said, ("takes a mesh, and 'ball' is a volume", "takes a volume", "no triangles"))
                assert all(words in sentence for sentence, words in says_all), said
                made = await page.resting()
                await page.ask("save", path=os.path.abspath("mesh.vv.json"))
                commands = (await page.ask("command"))["text"]
                for data in (few, surface):
                    await page.ask("undo")
                    await page.until(lambda: page.world["world"]["volumes"]["ball"]["data"] == data)
                back = await page.resting()
                await page.ask("undo")
                last = await page.resting()
                return commands, [pixels(frame.data) for frame in (before, shown, made, back, last)]
        commands, (before, shown, made, back, last) = run(work())
    assert psnr(before, shown) < 40 and psnr(shown, back) >= 40 and psnr(before, last) >= 40
    assert [line.split()[1] for line in commands.split("\n")] == ["pipe", "render"], commands  # files between would round places
    says(commands, "'isosurface --iso=150 | simplify --share=0.1 | smooth'")
    assert psnr(run_lines(commands), made) >= 40, commands
    with open("mesh.vv.json", encoding="utf-8") as scene:
        datasets = json.load(scene)["datasets"]
    assert [name for name, row in datasets.items() if "path" in row] == ["ball"], datasets
    ok("pipe", "ball.nrrd", "isosurface --iso=150", "-o", "ball-isosurface.ply")
    ok("pipe", "ball.nrrd", "isosurface --iso=150 | simplify --share=0.1", "-o", "ball-isosurface-simplify.ply")
    few, many = (ok("info", path, "--json").json["triangles"] for path in ("ball-isosurface-simplify.ply", "ball-isosurface.ply"))
    assert 0.05 * many <= few <= 0.15 * many, (few, many)
    ok("render", "mesh.vv.json", "-o", "mesh.png")
    with open("mesh.png", "rb") as file:
        assert psnr(pixels(file.read()), made) >= 40


def test_command_lines_make_the_data_and_then_the_picture():
    write_ball()
    sharp = {"dataset": "ball", "operation": "gaussian", "parameters": {"sigma": "2vox"}}
    with Server("ball.nrrd") as server:
        async def work():
            async with Page(server) as page, Page(server) as other:
                await page.edit(("set", "volumes.ball.segmentation.transfer.preset", "dense"))
                alone = (await page.ask("command", **sharp))["text"]
                said = await page.refused("command", **{**sharp, "operation": "gausian"})
                assert "gaussian" in said, said
                assert "sigma" in await page.refused("command", **{**sharp, "parameters": {"sigma": "x"}})
                assert "formula" in await page.refused("command", **{**sharp, "operation": "calc", "parameters": {}})
                plain = await page.refused("command", **{**sharp, "operation": "threshold", "parameters": {}})
                assert "Method otsu" in plain and "--" not in plain, plain  # the page has no options
                first = (await page.ask("run", **sharp))["dataset"]
                crop = {"x": "5:35", "z": "8:"}
                second = (await page.ask("run", operation="crop", dataset=first, parameters=crop))["dataset"]
                await page.until(lambda: page.world["world"]["volumes"]["ball"]["data"] == second)
                made = page.world["world"]["datasets"][second]
                assert made == {"operation": "crop", "inputs": {"volume": first}, "parameters": crop}
                await page.say("events", lines=drag([(0, 0), (0.2, 0.1)]))
                frame = await page.resting()
                await page.ask("save", path=os.path.abspath("scene.vv.json"))
                beside = await other.resting()
                return alone, frame, (await page.ask("command"))["text"], beside, (await other.ask("command"))["text"]
        alone, frame, lines, beside, others = run(work())
    words = alone.split()
    assert words[:2] == ["volvis", "gaussian"] and "--sigma=2" in alone.replace("'", "") and words[-2] == "-o", alone
    assert [line.split()[1] for line in lines.split("\n")] == ["gaussian", "crop", "render"], lines
    assert psnr(run_lines(lines), pixels(frame.data)) >= 40, lines
    assert psnr(run_lines(others), pixels(beside.data)) >= 40, others


def test_a_view_that_was_never_moved_is_saved_as_it_is_seen():
    write_ball()
    with Server("ball.nrrd") as server:
        async def look():
            async with Page(server, width=400, height=150) as page:
                await page.resting()
                made = await page.ask("run", operation="crop", dataset="ball", parameters={"z": "20:"})
                await page.until(lambda: page.world["world"]["volumes"]["ball"]["data"] == made["dataset"])
                frame = await page.resting()  # of what would fit nearer now
                await page.ask("save", path=os.path.abspath("scene.vv.json"))
                return frame
        frame = run(look())
    ok("render", "scene.vv.json", "-o", "scene.png")
    with open("scene.png", "rb") as file:
        assert psnr(pixels(frame.data), pixels(file.read())) >= 40


def test_command_lines_of_what_one_line_cannot_say():
    write_ball()
    with Server("ball.nrrd") as server:
        async def work():
            async with Page(server) as page:
                await page.edit(("set", "volumes.ball.data", "ball"))
                await page.ask("edit", edits=[
                    {"op": "add", "path": "datasets", "id": "two", "value": {"path": os.path.abspath("ball.nrrd")}},
                    {"op": "add", "path": "volumes", "id": "two", "value": {"data": "two"}}])
                assert (await page.ask("command"))["text"].startswith("volvis render scene.vv.json")
                # a ring of datasets, as a hostile scene may have it, ends
                await page.edit(("remove", "volumes.two"), ("set", "datasets.ball.source", "two"),
                                ("set", "datasets.ball.operation", "gaussian"), ("set", "datasets.two.source", "ball"),
                                ("set", "datasets.two.operation", "gaussian"))
                assert "more than" in await page.refused("command")
                # what is no operation is never typed
                await page.edit(("set", "datasets.ball.operation", "info; rm -rf /"))
                assert "rm" not in (await page.ask("command"))["text"]
        run(work())


def test_who_has_no_file_tries_a_sample():
    with Server() as server:
        async def look():
            async with Page(server) as page:
                welcome = next(m for m in page.messages if m["type"] == "welcome")
                assert len(welcome["samples"]) == 3 and os.path.samefile(welcome["folder"], ".")
                for sample in welcome["samples"]:
                    await page.ask("sample", name=sample["name"])
                    await page.until(lambda: sample["name"] in page.world["world"].get("volumes", {}))
                    frame = await page.resting()
                    assert pixels(frame.data).std() > 5, "nothing is seen"
                assert "no sample" in await page.refused("sample", name="no")
        run(look())


def test_pictures_of_any_size_have_their_recipe():
    write_ball()
    with Server("ball.nrrd") as server:
        async def picture():
            async with Page(server) as page:
                await page.resting()
                for kind, members in (("camera", {"eye": [50, 0, 0], "at": [8, 8, 8], "up": [0, 0, 1]}), ("size", {"width": 300, "height": 200}),
                                      ("events", {"lines": ""}), ("frames", {"wanted": "all"}), ("world", {})):
                    assert await page.ask(kind, **members) is None  # a message with an id has an answer, whichever it is
                return await page.ask("picture", width=500, height=300, name="../my ball.png")
        url = run(picture())["url"]
        for number in ("+1", "01", "1e0", " 1", "1.0", "0x1", "2", "0", ""):
            assert server.request(url.replace("/1/", f"/{number}/").replace(" ", "%20"), Cookie=server.cookie())[0] == 404, number
        for place in ("/files/1", "/files/1/", "/files/1/other.png", f"{url}x", url[:-1], f"{url}/x"):
            assert server.request(place, Cookie=server.cookie())[0] == 404, place
        code, _, data = server.request(url, Cookie=server.cookie())
        assert code == 200 and pixels(data).shape == (300, 500, 3), (code, data[:100])
        assert server.request(url)[0] == 403
        with open("again.png", "wb") as file:
            file.write(data)
        ok("render", "again.png", "-o", "made.png")
        with open("made.png", "rb") as file:
            assert psnr(pixels(data), pixels(file.read())) >= 60


# What pages draw themselves -----------------------------------------------------------------------------------------

def head_of(data):
    magic, kind, flags = struct.unpack_from("<4sHH", data)
    assert magic == b"VVS1", data[:8]
    return kind, flags, np.frombuffer(data, "<f8", 12, 8), struct.unpack_from("<7I", data, 104)


def test_pages_draw_what_files_of_shapes_say_and_all_get_the_same_ones():
    write_ball()
    with Server("ball.nrrd") as server:
        async def shapes():
            async with Page(server) as page, Page(server) as other:
                await page.resting()
                first = await page.ask("shape", method="reduced")
                again = await other.ask("shape", method="reduced", bytes=4 << 20)
                assert first["parts"] == again["parts"] and first["method"] == "reduced"
                (volume,) = page.world["world"]["volumes"]
                await page.edit(("set", f"volumes.{volume}.place.position", [10, 0, 0]),
                                ("set", f"volumes.{volume}.color", "#ff0000"))
                moved = await page.ask("shape", method="reduced")
                assert moved["parts"][0]["url"] == first["parts"][0]["url"]
                assert moved["parts"][0]["place"][9:] == [10, 0, 0] and moved["parts"][0]["color"] == [1, 0, 0]
                small = await page.ask("shape", method="reduced", bytes=16384)
                boxes = await page.ask("shape", method="boxes")
                assert "reduced" in await page.refused("shape", method="voxels")
                assert "bytes" in await page.refused("shape", method="reduced", bytes=1 << 30)
                return first["parts"][0], small["parts"][0], boxes["parts"][0], first
        large, small, boxes, whole = run(shapes())
        assert [light["frame"] for light in whole["lights"]] == ["camera", "camera"] and not whole["left_out"]
        for part, wanted, most in ((large, 1, 4 << 20), (small, 1, 16384), (boxes, 3, 4 << 20)):
            assert server.request(part["url"])[0] == 403
            code, _, data = server.request(part["url"], Cookie=server.cookie())
            kind, flags, place, counts = head_of(data)
            assert code == 200 and kind == wanted and len(data) == part["bytes"] <= most, (part, len(data))
            if kind == 1:
                assert flags == 256 and counts[5] == part["triangles"] and place[8] == 1.5 * part["step"][2], (part, place)
            else:
                assert flags == 0 and struct.unpack_from("<I", data, 132)[0] == part["triangles"] > 0
        assert large["step"] == [1, 1, 1] and small["step"][0] > 1


def test_a_page_that_draws_itself_gets_no_frames_while_it_turns():
    write_ball()
    with Server("ball.nrrd") as server:
        async def turn():
            async with Page(server) as page:
                await page.resting()
                await page.say("frames", wanted="resting")
                n, pose = len(page.frames), page.pose
                steps = itertools.count()

                async def moves():
                    i = next(steps)
                    await page.say("events", lines=drag([(0.02 * i, 0), (0.02 * i + 0.02, 0)]))
                await page.until(lambda: sum(m["type"] == "pose" and m["moving"] for m in page.messages) > 10, meanwhile=moves)
                await page.resting()
                assert page.frames[n:] and not any(frame.moving for frame in page.frames[n:])
                await page.until(lambda: page.pose["eye"] != pose["eye"] and not page.pose["moving"])
                await page.say("frames", wanted="none")
                n, pose = len(page.frames), page.pose
                await page.say("action", name="front")
                await page.until(lambda: page.pose["eye"] != pose["eye"] and not page.pose["moving"])
                (volume,) = page.world["world"]["volumes"]
                number = page.world["number"]
                await page.edit(("set", f"volumes.{volume}.color", "#00ff00"))
                await page.until(lambda: any(m["type"] == "resolved" and m["number"] > number for m in page.messages))
                assert len(page.frames) == n
                await page.say("frames", wanted="all")
                await page.until(lambda: len(page.frames) > n)
        run(turn())


# Files --------------------------------------------------------------------------------------------------------------

def test_files_come_from_the_page_and_from_the_root_alone():
    write_ball()
    os.makedirs("inside/deep", exist_ok=True)
    write_ball("inside/deep/other.nrrd", 20)
    os.symlink(os.path.abspath("ball.nrrd"), "inside/link.nrrd")
    os.symlink("deep/other.nrrd", "inside/other.nrrd")
    with Server("--root", "inside", verb="serve") as server:
        async def files():
            async with Page(server) as page:
                top = await page.ask("browse", path="")
                assert [e["name"] for e in top["entries"]] == ["deep", "other.nrrd"], top
                assert top["entries"][1]["kind"] == "volume"
                await page.ask("open", path="deep/other.nrrd")
                await page.until(lambda: "other" in page.world["world"].get("volumes", {}))
                await page.resting()
                for path in ("../ball.nrrd", "/../ball.nrrd", "link.nrrd", "/etc/passwd", os.path.abspath("ball.nrrd"),
                             "deep/../../ball.nrrd"):
                    said = await page.refused("open", path=path)
                    assert "no such file" in said, said
                for path in ("..", "/..", "deep/../.."):
                    assert await page.refused("browse", path=path)
                for path in ("../out.vv.json", "/tmp/out.vv.json", "nowhere/out.vv.json", ""):
                    assert await page.refused("save", path=path), path
                await page.ask("save", path="deep/kept")
                assert os.path.exists("inside/deep/kept.vv.json")
                assert "line breaks" in await page.refused("save", path="deep/a\nb")
                said = await page.refused("edit", edits=[{"op": "set", "path": "datasets.other.path",
                                                          "value": os.path.abspath("ball.nrrd")}])
                assert "outside" in said, said
                with open("ball.nrrd", "rb") as file:
                    data = file.read()
                code, _, body = server.request("/files/dropped.nrrd", data, method="PUT", Cookie=server.cookie())
                assert code == 201, (code, body)
                await page.ask("open", path=json.loads(body)["path"], add=True)
                await page.until(lambda: set(page.world["world"]["volumes"]) == {"other", "dropped"})
                code, _, body = server.request("/files/Sch%C3%A4del.nrrd", data, method="PUT", Cookie=server.cookie())
                await page.ask("open", path=json.loads(body)["path"], add=True)
                await page.until(lambda: any(d.get("title") == "Sch\u00e4del" for d in page.world["world"]["datasets"].values()))
                code, _, body = server.request("/files/bad.nrrd", b"NRRD0004\nsizes: x\n\n", method="PUT", Cookie=server.cookie())
                said = await page.refused("open", path=json.loads(body)["path"])
                assert code == 201 and said.startswith("bad.nrrd:"), said
                for name in ("..", "a%2fb", ".hidden", ""):
                    assert server.request(f"/files/{name}", b"x", method="PUT", Cookie=server.cookie())[0] >= 400, name
        run(files())
    assert not os.path.exists("out.vv.json")


def test_who_looks_goes_on_looking_at_a_scene_without_that_view():
    write_ball("ball.nrrd", 16)
    data = {"datasets": {"ball": {"path": "ball.nrrd"}}, "volumes": {"ball": {"data": "ball"}}}
    scenes = {"none.vv.json": {}, "other.vv.json": {"left": {"camera": {"azimuth": 80}}}}
    with Server("ball.nrrd", "--root", ".", verb="serve") as server:
        async def work():
            async with Page(server, 64, 64) as page, Page(server, 64, 64) as second:
                await page.resting()
                await page.ask("save", path="kept.vv.json")
                with open("kept.vv.json", encoding="utf-8") as file:
                    kept = json.load(file)
                for name, views in scenes.items():
                    with open(name, "w", encoding="utf-8") as file:
                        json.dump({**kept, **data, "views": views}, file)
                    await page.ask("open", path=name)
                    for who in (page, second):
                        await who.resting()
                        assert who.world["world"]["views"][next(m["view"] for m in who.messages if m["type"] == "welcome")] == views.get("left", {}), who.world
                    # the camera that comes to rest is the World's
                    await page.say("events", lines="0 mouse axis x 0\n0 mouse button left down\n1 mouse axis x 0.3\n")
                    await page.until(lambda: "eye" in page.world["world"]["views"]["main"].get("camera", {}))
                    await page.ask("save", path="again.vv.json", replace=True)
                    said = [m["text"] for who in (page, second) for m in who.messages if m["type"] == "notice"]
                    assert not said, said
                    ok("render", "again.vv.json", "-o", "again.png")
        run(work())


def test_a_file_that_is_there_is_saved_over_only_where_that_is_said():
    write_ball()
    with open("mine.vv.json", "w", encoding="ascii") as file:
        file.write("precious")
    with Server("ball.nrrd", "--root", ".", verb="serve") as server:
        async def save():
            def mine():
                with open("mine.vv.json", encoding="utf-8") as file:
                    return file.read()
            async with Page(server) as page:
                answer = await page.answer("save", path="mine")
                assert not answer["ok"] and answer["reason"] == "exists" and "mine.vv.json already exists" in answer["error"], answer
                assert mine() == "precious"
                await page.ask("save", path="mine", replace=True)
                assert "datasets" in mine()
                await page.edit(("set", "title", "once more"))
                await page.ask("save", path="mine")  # its own
                assert "once more" in mine()
                await page.ask("save", path="other")
                assert (await page.answer("save", path="mine"))["reason"] == "exists"
                await page.ask("open", path="mine.vv.json")
                await page.ask("save", path="mine")  # what was opened
                await page.ask("new")
                assert (await page.answer("save", path="mine"))["reason"] == "exists"
        run(save())
    with Server("mine.vv.json", "--root", ".", verb="serve") as server:
        async def again():
            async with Page(server) as page:
                await page.resting()
                await page.ask("save", path="mine")
        run(again())


def test_a_server_that_only_shows_changes_nothing():
    write_ball()
    with Server("ball.nrrd", "--read-only", "--root", ".", verb="serve") as server:
        async def look():
            async with Page(server) as page:
                await page.resting()
                await page.say("events", lines=drag([(0, 0), (0.3, 0)]))
                await page.resting()
                for kind, more in (("edit", {"edits": [{"op": "set", "path": "title", "value": "x"}]}), ("undo", {}),
                                   ("save", {"path": "x"}), ("open", {"path": "ball.nrrd"})):
                    assert "only be looked at" in await page.refused(kind, **more), kind
                assert server.request("/files/a", b"x", method="PUT", Cookie=server.cookie())[0] == 403
        run(look())
    assert not os.path.exists("x.vv.json")


# What goes wrong ----------------------------------------------------------------------------------------------------

def test_a_message_that_is_none_ends_its_connection_alone():
    write_ball()
    bad = ["", "{", "[]", "null", '"x"', "{}", '{"type": 1}', '{"type": "nothing"}', '{"type": "hello"}',
           '{"type": "ack"}', '{"type": "ack", "frame": "x"}', '{"type": "events"}', '{"type": "events", "lines": "x y"}',
           '{"type": "size", "width": 0, "height": 5}', '{"type": "size", "width": 1e9, "height": 5}',
           '{"type": "edit", "id": 0, "edits": []}', '{"type": "edit", "id": 1}', '{"type": "camera", "eye": 1}',
           '{"type": "browse", "id": 1}', '{"type": "cancel", "id": 1}', '{"type": "undo", "type": "redo"}',
           "[" * 100000, b"\x00\x01binary", '{"type": "events", "lines": "' + "x" * (1 << 20) + '"}']
    with Server("ball.nrrd") as server:
        async def talk():
            async with Page(server) as good:
                for text in bad:
                    async with Page(server, 32, 32) as page:
                        await page.socket.send(text)
                        try:
                            while True:
                                await page.take(60)
                        except websockets.exceptions.ConnectionClosed as closed:
                            assert closed.code in (1008, 1006, 1002, 1003, 1009), (text, closed)
                await good.edit(("set", "title", "alive"))
        run(talk())
        assert server.process.poll() is None


def test_after_a_crash_the_session_goes_on_with_its_history():
    write_ball()
    server = Server("ball.nrrd")

    async def work():
        async with Page(server) as page:
            await page.resting()
            await page.edit(("set", "title", "first"))
            await page.edit(("set", "title", "second"))
            await page.say("events", lines=drag([(0, 0), (0.2, 0.1)]))
            await page.resting()
            await page.until(lambda: "camera" in page.world["world"]["views"]["main"])
            return page.world["world"]
    before = run(work())
    assert server.end(signal.SIGKILL)[0] == -signal.SIGKILL
    with open(next(os.path.join(folder, "journal.jsonl") for folder, _, names in os.walk("state")
                   if "journal.jsonl" in names), "ab") as journal:
        journal.write(b'{"who": "main", "edi')  # cut off in the middle of a line
    with Server("ball.nrrd") as again:
        async def check():
            async with Page(again) as page:
                assert page.world["world"] == before
                await page.ask("undo")
                await page.until(lambda: page.world["world"].get("title") == "first")
                await page.ask("undo")
                await page.until(lambda: "title" not in page.world["world"])
        run(check())
    with Server("ball.nrrd") as fresh:
        async def anew():
            async with Page(fresh) as page:
                assert "title" not in page.world["world"], "a session that ended is not restored"
        run(anew())


class Through(http.client.HTTPConnection):
    """HTTP through a Unix socket."""

    def __init__(self, path):
        super().__init__("localhost", 8080)
        self.path = path

    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.connect(self.path)


def test_one_goes_back_to_where_one_stood():
    write_ball()
    with Server("ball.nrrd") as server:
        async def look():
            async with Page(server) as page:
                first = await page.resting()
                await page.say("events", lines=drag([(0, 0), (0.2, 0.1)]))
                turned = await page.resting()
                await page.say("action", name="top")
                top = await page.resting()
                assert psnr(pixels(first.data), pixels(turned.data)) < 40 > psnr(pixels(turned.data), pixels(top.data))
                for name, there in (("back", turned), ("back", first), ("forward", turned), ("forward", top)):
                    await page.say("action", name=f"view-{name}")
                    assert psnr(pixels((await page.resting()).data), pixels(there.data)) >= 40, name
                await page.say("action", name="view-forward")
                await page.until(lambda: any(m["type"] == "notice" and "no view after" in m["text"] for m in page.messages))
        run(look())


def test_the_page_looks_from_where_the_program_does():
    """By the names that both have, at data whose front is seen along y and at anatomical ones."""
    for file, space in (("plain.nrrd", "space dimension: 3"), ("head.nrrd", "space: right-anterior-superior")):
        with open(file, "wb") as out:
            out.write(f"NRRD0004\ntype: uint8\ndimension: 3\n{space}\nsizes: 8 8 8\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
                      "encoding: raw\n\n".encode() + bytes(range(256)) * 2)
        with Server(file) as server:
            async def look():
                async with Page(server) as page:
                    await page.resting()
                    for name in ("top", "back", "left", "right", "bottom", "isometric", "front"):
                        await page.say("action", name=name)
                        await page.resting()
                        ok("render", file, "--view", name, "--size", "8", "-o", "a.png", "--overwrite", "--save-scene", "a.vv.json")
                        camera = json.load(open("a.vv.json"))["views"]["main"]["camera"]
                        ways = [np.subtract(c["eye"], c["at"]) for c in (page.pose, camera)]
                        ways = [way / np.linalg.norm(way) for way in ways]
                        assert np.allclose(*ways, atol=1e-6), (file, name, ways)
            run(look())


def test_a_unix_socket_is_for_its_owner_alone():
    write_ball()
    with Server("ball.nrrd", "--socket", "here.sock") as server:
        assert server.port == 8080 and stat.S_IMODE(os.stat("here.sock").st_mode) == 0o600
        way = Through("here.sock")
        way.request("POST", "/session", json.dumps({"token": server.token}))
        cookie = way.getresponse().headers["set-cookie"].split(";")[0]
        way.close()
        says(fails(2, "view", "ball.nrrd", "--no-browser", "--socket", "here.sock"), "another server listens there")

        async def look():
            async with websockets.unix_connect("here.sock", "ws://localhost:8080/ws", subprotocols=["volvis"],
                                               origin=server.base, extra_headers={"Cookie": cookie}, max_size=None) as page:
                await page.send(json.dumps({"type": "hello", "width": 64, "height": 48}))
                while isinstance(await asyncio.wait_for(page.recv(), 60), str):
                    pass
        run(look())
    assert not os.path.exists("here.sock")
    server = Server("ball.nrrd", "--socket", "here.sock")
    server.end(signal.SIGKILL)
    assert os.path.exists("here.sock")
    with Server("ball.nrrd", "--socket", "here.sock", "--port", 9000) as server:
        assert server.port == 9000
    with open("file", "w") as file:
        file.write("kept")
    says(fails(2, "view", "ball.nrrd", "--no-browser", "--socket", "file"), "file: exists and is not a socket")
    assert open("file").read() == "kept"
    says(fails(2, "view", "ball.nrrd", "--no-browser", "--socket", "x" * 200), "at most 107 bytes")
    says(fails(2, "serve", "ball.nrrd", "--listen", "127.0.0.1", "--socket", "y"), "give one of them")


def test_a_recorded_session_replays_to_the_same_world_byte_for_byte():
    write_ball()
    write_ball("other.nrrd", 20)
    with Server("ball.nrrd", "--record", "session.jsonl") as server:
        async def work():
            async with Page(server) as page, Page(server, 200, 300) as tall, Page(server, 90, 60) as still:
                await page.resting()
                await tall.resting()
                await still.ask("command")
                await page.say("events", lines=drag([(0, 0), (0.2, 0.1), (0.3, -0.1)]))
                await tall.say("events", lines="0 mouse axis wheel-y 2\n")
                for i in range(5):
                    await page.edit(("set", "volumes.ball.segmentation.transfer.opacity_scale", 1 + i), gesture="g")
                await page.say("action", name="fit")
                await page.resting()
                await page.say("action", name="projection")
                await tall.edit(("set", "title", "taken back"))
                await tall.ask("undo")
                await page.ask("open", path=os.path.abspath("other.nrrd"), add=True)
                await page.ask("pick", x=0.5, y=0.5)
                await page.say("events", lines=drag([(0.5, 0), (0.5, 0.3)]))
                await page.ask("new")
                await page.until(lambda: not page.world["world"].get("volumes"))
                await page.ask("undo")
                await page.ask("picture", width=40, height=30)
                for sigma in ("2vox", "1vox"):
                    await page.ask("run", operation="gaussian", dataset="ball", parameters={"sigma": sigma})
                await page.ask("run", operation="isosurface", dataset="ball", parameters={"iso": 150})
                await page.ask("undo")
                await page.say("size", width=333, height=222)
                await page.resting()
                await page.ask("save", path=os.path.abspath("live.vv.json"))
        run(work())
    ok("replay", "session.jsonl", "-o", os.path.abspath("played.vv.json"), env={"XDG_STATE_HOME": os.path.abspath("state")})
    with open("live.vv.json") as live, open("played.vv.json") as played:
        texts = [file.read().splitlines(True) for file in (live, played)]
    difference = list(difflib.unified_diff(*texts, "live", "played"))
    assert not difference, "".join(difference)
    elsewhere = {"XDG_STATE_HOME": os.path.abspath("elsewhere")}
    ok("replay", "session.jsonl", "-o", os.path.abspath("moved.vv.json"), env=elsewhere)
    ok("render", "moved.vv.json", "-o", "moved.png")
    ok("render", "live.vv.json", "-o", "live.png")
    with open("moved.png", "rb") as moved, open("live.png", "rb") as live:
        assert (pixels(moved.read()) == pixels(live.read())).all()
    os.rename("other.nrrd", "away.nrrd")
    says(fails(3, "replay", "session.jsonl", env=elsewhere), "a job that was done in the recording is not done now")
    with open("session.jsonl", "rb") as file:
        lines = file.read().splitlines(keepends=True)
    for name, text in (("empty", b""), ("cut", b"".join(lines[:4]) + lines[4][:-9]), ("early", b"".join(lines[2:])),
                       ("other", b"volvis input 1\n"),
                       ("nowhere", b"".join(line.replace(b'"eye":', b'"eyes":') for line in lines))):
        with open(f"{name}.jsonl", "wb") as file:
            file.write(text)
        says(fails(3, "replay", f"{name}.jsonl"), f"{name}.jsonl:line")


def test_ctrl_c_ends_the_server_at_once_and_leaves_no_journal():
    write_ball()
    server = Server("ball.nrrd")

    async def work():
        async with Page(server) as page:
            await page.edit(("set", "title", "x"))
    run(work())
    code, said = server.end(signal.SIGINT)
    assert code in (0, 130), (code, said)
    assert not any("journal.jsonl" in names for _, _, names in os.walk("state"))


def test_bad_options_are_one_sentence():
    from harness import fails
    says(fails(2, "serve", "--token", "short"), "16")
    says(fails(2, "serve", "--token", "x" * 20, "--token-file", "y"), "one of them")
    says(fails(3, "serve", "--token-file", "nothing"), "nothing")
    says(fails(3, "view", "nothing.nrrd", "--no-browser"), "nothing.nrrd")
    fails(3, "serve", "--root", "nowhere")


def test_names_that_nothing_has_are_refused_with_the_nearest():
    write_ball()
    with open("newer.vv.json", "w", encoding="ascii") as scene:
        json.dump({"schema": 1, "datasets": {"ball": {"path": "ball.nrrd"}}, "volumes": {
            "ball": {"data": "ball"}, "newer": {"data": "ball", "visible": False, "segmentation": {"transfer": {
                "preset": "of-a-newer-volvis"}}}}}, scene)
    transfer = "volumes.ball.segmentation.transfer."
    async def work(server):
        async with Page(server) as page:
            for path, value, nearest in ((transfer + "preset", "heda", "head"), (transfer + "preset", "/etc/passwd", "there are bone"),
                                         (transfer + "colormap", "virids", "viridis"), (transfer + "colormap", "#12", "there are viridis"),
                                         ("volumes.ball.slices.colormap", "graey", "gray"),
                                         ("volumes.ball.paint.colormap", "magna", "magma"),
                                         ("views.main.render.method", "raycat", "raycast"), ("datasets.ball.format", "nrd", "nrrd"),
                                         ("volumes.newer.segmentation.transfer.preset", "of-no-volvis", "there are bone")):
                said = await page.refused("edit", edits=[{"op": "set", "path": path, "value": value}])
                assert nearest in said, (path, said)
            welcome = next(m for m in page.messages if m["type"] == "welcome")
            for preset in welcome["presets"]:
                await page.edit(("set", transfer + "preset", preset["name"])) if preset["kind"] != "colormap" else None
            for name in [*welcome["colormaps"], "#12ab34"]:
                await page.edit(("set", transfer + "colormap", name))
            await page.edit(("set", "title", "a scene with a name from elsewhere is edited"))
    with Server("newer.vv.json") as server:
        run(work(server))


def test_what_cannot_be_served_is_said_and_dry_runs_say_the_same():
    for more in ((), ("--dry-run",)):
        for code, words, sentence in ((5, ("--socket", "/nonexistent/x"), "cannot make a socket in the folder /nonexistent"),
                                (3, ("--tls-cert", "nope.pem"), "the certificate cannot be read"),
                                (2, ("--token", "short"), "a token is 16")):
            said = fails(code, "serve", *words, *more)
            assert sentence in said and "taken" not in said, said


def test_one_document_is_printed_and_changes_that_a_damaged_journal_loses_are_told():
    write_ball()
    for how in (signal.SIGTERM, signal.SIGINT):
        server = Server("ball.nrrd")
        server.process.send_signal(how)
        assert server.process.communicate(timeout=60)[0] == b"", "more than the link"
    async def edits(server):
        async with Page(server) as page:
            for i in range(5):
                await page.edit(("set", "title", f"{i}"))
    with Server("ball.nrrd") as server:
        run(edits(server))
        server.process.kill()
        server.process.communicate()
    path = next(os.path.join(folder, "journal.jsonl") for folder, _, names in os.walk("state") if "journal.jsonl" in names)
    with open(path, "rb") as journal:
        lines = journal.read().split(b"\n")
    assert len(lines) >= 7 and not lines[-1], lines
    with open(path, "wb") as journal:
        journal.write(b"\n".join([*lines[:3], lines[3][:10] + b"\xff" + lines[3][11:], *lines[4:]]))
    lost = len(lines) - 1 - 3

    async def told(server):
        async with Page(server) as page:
            await page.until(lambda: [m for m in page.messages if m["type"] == "notice" and f"{lost} later" in m["text"]])
    with Server("ball.nrrd") as server:
        run(told(server))
        said = server.end(signal.SIGINT)[1]
    assert f"{lost} later changes are lost" in said, said


def test_the_last_change_of_a_journal_that_was_cut_off_is_told():
    write_ball()
    async def edits(server):
        async with Page(server) as page:
            for i in range(3):
                await page.edit(("set", "title", f"{i}"))
    with Server("ball.nrrd") as server:
        run(edits(server))
        server.process.kill()
        server.process.communicate()
    path = next(os.path.join(folder, "journal.jsonl") for folder, _, names in os.walk("state") if "journal.jsonl" in names)
    os.truncate(path, os.path.getsize(path) - 3)

    async def told(server):
        async with Page(server) as page:
            assert page.world["world"]["title"] == "1"
            await page.until(lambda: [m for m in page.messages if m["type"] == "notice" and "was cut off" in m["text"]])
    with Server("ball.nrrd") as server:
        run(told(server))
        said = server.end(signal.SIGINT)[1]
    assert "was cut off when the session broke off" in said and "are lost" not in said, said


def test_pictures_are_as_large_as_views_may_be_and_memory_suffices_for():
    write_ball(n=8)
    async def work(server):
        async with Page(server) as page:
            value = await page.ask("picture", width=32768, height=2, name="wide.png")
            code, _, data = server.request(value["url"], Cookie=server.cookie())
            assert code == 200 and struct.unpack(">II", data[16:24]) == (32768, 2)
            assert "32768" in await page.refused("picture", width=32769, height=2, name="wider.png")
            assert "memory" in await page.refused("picture", width=32768, height=32768, name="huge.png")
    with Server("ball.nrrd", "--memory", "300M") as server:
        run(work(server))


if __name__ == "__main__":
    main()
