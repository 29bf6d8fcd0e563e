"""The server under attack by who was let in: it stays alive, and serves who behaves. tests/attack has all that bytes can do."""
import asyncio
import json
import os
import socket
import struct

from harness import main, sanitized, write_ball
from page import Page, Server, run
from wire import answer, attacked, behaves, codes, connect, frame, head, hello, one_answer, pong, resident_kib, upgrade, wait_for

try:
    import websockets
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")


# Cookies ------------------------------------------------------------------------------------------------------------

def test_two_servers_of_one_host_leave_each_others_cookies_alone():
    with attacked() as one, Server("ball.nrrd") as two:
        cookies = [one.cookie(), two.cookie()]
        assert cookies[0].split("=")[0] != cookies[1].split("=")[0], "a browser would keep one of them"
        both = "; ".join(cookies)
        for server, foreign in ((one, cookies[1]), (two, cookies[0])):
            renamed = cookies[0 if server is one else 1].split("=")[0] + "=" + foreign.split("=")[1]
            for cookie, fine in ((both, True), (foreign, False), (renamed, False)):
                sock, got = upgrade(server, cookie)
                assert (b" 101 " in got) == fine, (cookie, got)
                sock.close()


# Uploads ------------------------------------------------------------------------------------------------------------

def uploads(part):
    return [name for folder, _, names in os.walk("state") for name in names
            if "/files/" in folder + "/" and part in name]


def written(server):
    """Files that have no name yet."""
    folder, found = f"/proc/{server.process.pid}/fd", []
    for fd in os.listdir(folder):
        try:
            found.append(os.readlink(f"{folder}/{fd}"))
        except FileNotFoundError:
            pass
    return [path for path in found if "/files/" in path and path.endswith("(deleted)")]


def test_an_upload_that_breaks_off_leaves_nothing():
    with attacked() as server:
        cookie = server.cookie()
        for promised, sent in ((1000, 10), (10 ** 6, 300000)):
            with connect(server) as sock:
                sock.sendall(head(server, "PUT /files/broken.nrrd HTTP/1.1", f"Content-Length: {promised}", cookie=cookie)
                             + b"x" * sent)
                wait_for(lambda: written(server), "a file is being written")
                assert not uploads("broken"), "a part of a file has a name"
            wait_for(lambda: not written(server), "the part of a file is taken away")
        got = answer(server, head(server, "PUT /files/more.nrrd HTTP/1.1", "Content-Length: 3", cookie=cookie) + b"abc"
                     + b"y" * 1000)
        assert codes(got)[0] == 201 and 200 not in codes(got), got
        assert [os.path.getsize(os.path.join(folder, name)) for folder, _, names in os.walk("state") for name in names
                if name == "more.nrrd"] == [3]


def test_uploads_have_a_limit_each_and_together():
    with attacked("--root", ".", "--upload", "1000B", verb="serve") as server:
        cookie = server.cookie()
        def put(n):
            return server.request("/files/a.bin", b"x" * n, method="PUT", Cookie=cookie)[0]
        assert put(1001) == 413
        assert [put(1000) for _ in range(4)] == [201] * 4
        assert put(1) == 413
        assert len(uploads("a.bin")) == 4
    assert not uploads("a.bin"), "uploads that no scene names are taken away at the end"


def test_files_without_bytes_have_an_end():
    with attacked("--root", ".", "--upload", "1K", verb="serve") as server:
        cookie = server.cookie()
        got = [server.request("/files/z", b"", method="PUT", Cookie=cookie) for _ in range(6)]
        assert [code for code, _, _ in got] == [201] * 4 + [413] * 2, got
        assert b"as many files as it may" in got[-1][2], got
        assert len(uploads("z")) == 4


def test_what_is_announced_holds_nothing():
    with attacked("--root", ".", "--upload", "1M", verb="serve") as server:
        cookie = server.cookie()

        def begin(n, sent):
            sock = connect(server)
            sock.sendall(head(server, "PUT /files/p HTTP/1.1", f"Content-Length: {n}", cookie=cookie) + b"x" * sent)
            return sock
        slow = [begin(1 << 20, 4000) for _ in range(4)]
        wait_for(lambda: len(written(server)) == 4, "files are being written")
        code, _, said = server.request("/files/z", b"abc", method="PUT", Cookie=cookie)
        assert code == 201, (code, said)
        for sock in slow:  # together they are too much, and the last one hears so
            sock.sendall(b"x" * ((1 << 20) - 4000))
        assert sorted(codes(one_answer(sock))[0] for sock in slow) == [201, 201, 201, 413]
        for sock in slow:
            sock.close()
        assert server.request("/files/z", b"x" * 900000, method="PUT", Cookie=cookie)[0] == 201, "what came of it counts"


def test_who_sends_all_of_a_refused_file_before_it_listens_hears_why():
    with attacked("--root", ".", "--upload", "1M", verb="serve") as server:
        code, _, said = server.request("/files/large", b"x" * (8 << 20), method="PUT", Cookie=server.cookie())
        assert code == 413 and b"larger than this server accepts" in said, (code, said)


def test_what_a_saved_scene_names_stays():
    with attacked() as server:
        with open("ball.nrrd", "rb") as file:
            data = file.read()
        paths = [json.loads(server.request(f"/files/{name}.nrrd", data, method="PUT", Cookie=server.cookie())[2])["path"]
                 for name in ("kept", "lost")]

        async def work():
            async with Page(server, 64, 64) as page:
                await page.ask("open", path=paths[0])
                await page.ask("save", path=os.path.abspath("scene.vv.json"))
        run(work())
    assert os.path.exists(paths[0]) and not os.path.exists(paths[1])
    with Server("scene.vv.json"):
        pass
    assert os.path.exists(paths[0])


# WebSockets ---------------------------------------------------------------------------------------------------------

def test_floods_of_pings_and_messages_do_not_keep_others_waiting():
    with attacked() as server:
        cookie = server.cookie()
        sock, got = upgrade(server, cookie)
        assert b" 101 " in got
        sock.settimeout(60)
        try:
            sock.sendall(hello() + frame(b"ping", opcode=9) * 20000)
        except OSError:
            pass
        run(behaves(server))
        other, got = upgrade(server, cookie)
        try:
            other.sendall(hello() + frame(b'{"type": "ack", "frame": 0}') * 20000) # quickly done
        except OSError:
            pass
        run(behaves(server))
        other.sendall(frame(b"all", opcode=9))
        assert pong(other) == b"all", "who sends too much waits, and is heard in the end"
        before = resident_kib(server)
        third, _ = upgrade(server, cookie)
        try:
            third.sendall(frame(b"", final=False) + frame(b"", opcode=0, final=False) * 50000)
        except OSError:
            pass
        run(behaves(server))
        assert sanitized() or resident_kib(server) - before < 30000
        for s in (sock, other, third):
            s.close()


def test_who_never_reads_costs_a_bounded_amount():
    with attacked() as server:
        cookie = server.cookie()

        async def work(n, silent):
            async with Page(server, 64, 64) as page:
                for i in range(n):
                    await page.edit(("set", "datasets.ball.parameters", {"text": f"{i} " + "x" * 20000}), gesture="g")
                for sock in silent:
                    try:
                        sock.sendall(frame(json.dumps({"type": "events", "lines": f"{n} mouse axis x 0.5"}).encode()))
                    except OSError:
                        pass  # who has read nothing for 25 seconds is ended: on a slow machine that is now
                return resident_kib(server)
        run(work(60, []))
        silent = []
        for _ in range(8):
            sock, got = upgrade(server, cookie)
            assert b" 101 " in got
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            sock.sendall(hello(256, 256))
            silent.append(sock)
        run(behaves(server))
        before = run(work(20, silent))
        after = run(work(150, silent))
        assert sanitized() or after - before < 8 * 1100, f"{after - before} KiB more for 8 who never read"
        for sock in silent:
            sock.close()


def test_a_large_world_ends_nobody_who_reads():
    async def work(server):
        async with Page(server, 64, 64) as page, Page(server, 64, 64) as other:
            said = await page.refused("edit", edits=[{"op": "set", "path": "title", "value": "x" * 900000}])
            assert said == "title: the text is 900000 bytes long: at most 1024 are allowed", said
            def put(name, n):
                return [{"op": "set", "path": f"datasets.{name}{i}", "value": {"parameters": {"text": "x" * 60000}}}
                        for i in range(n)]
            await page.ask("edit", edits=put("d", 14))
            for n in range(8):  # quickly one after the other, and both read all of it
                await page.edit(("set", "background", f"#00000{n}"))
                await other.edit(("set", "seed", n))
            await other.until(lambda: other.world["world"].get("background") == "#000007")
            assert len(json.dumps(other.world["world"])) > 800000
    with attacked() as server:
        run(work(server))


def test_what_is_set_again_and_again_is_one_step_and_undo_has_its_bytes():
    async def work(server):
        async with Page(server, 64, 64) as page:
            async def burst(n, *values):
                for value in values:
                    await page.say("edit", id=n, edits=[{"op": "set", "path": "title", "value": value}])
                await page.until(lambda: page.world["world"].get("title") == values[-1])
            await page.edit(("set", "title", "first"))
            await asyncio.sleep(0.15)
            await burst(1000, *map(str, range(50)))
            steps = 0
            while page.world["world"].get("title") != "first":
                number = page.world["number"]
                await page.ask("undo")
                await page.until(lambda: page.world["number"] > number)
                steps += 1
            assert 2 <= steps < 25, steps  # two, but where the machine is so slow that 100 ms lie between some of them
            for n in range(60):  # not the same again
                await page.edit(("set", "datasets.ball.parameters", {"text": f"{n} " + "x" * 60000}), ("set", "seed", n))
                await page.edit(("set", "volumes.ball.title", f"{n}"))
            told = [m for m in page.messages if m["type"] == "notice" and "can no longer be undone" in m["text"]]
            assert len(told) == 1 and "1.0 MiB" in told[0]["text"] and "undo_bytes" in told[0]["text"], told
            undone = 0
            while (await page.answer("undo"))["ok"]:
                undone += 1
            assert 4 < undone < 60, undone
            assert page.world["world"]["title"] == "first"
    with attacked("--limit", "undo_bytes=1M") as server:
        run(work(server))


def test_two_hundred_look_at_once_and_no_more():
    async def crowd(server):
        cookie = server.cookie()
        async def one(i):
            return await websockets.connect(f"ws://localhost:{server.port}/ws", subprotocols=["volvis"], origin=server.base,
                                            extra_headers={"Cookie": cookie}, max_size=None, compression=None,
                                            open_timeout=120)
        sockets = [await one(i) for i in range(200)]
        for s in sockets:
            await s.send('{"type": "hello", "width": 16, "height": 16}')

        async def frames(s):
            while True:
                message = await asyncio.wait_for(s.recv(), 240)
                if isinstance(message, bytes):
                    (number,) = struct.unpack("<I", message[8:12])
                    await s.send(json.dumps({"type": "ack", "frame": number}))
                    return
        await asyncio.gather(*(frames(s) for s in sockets))
        late = await one(200)
        await late.send('{"type": "hello", "width": 16, "height": 16}')
        try:
            await asyncio.wait_for(late.recv(), 60)
            raise AssertionError("201 look")
        except websockets.exceptions.ConnectionClosed as closed:
            assert "200 people" in closed.reason, closed
        await asyncio.gather(*(s.close() for s in sockets))
    with attacked() as server:
        run(crowd(server))


def test_who_leaves_in_the_middle_of_anything_leaves_nothing():
    with attacked() as server:
        cookie = server.cookie()
        asks = [{"type": "picture", "id": 1, "width": 600, "height": 600, "name": "x.png"},
                {"type": "pick", "id": 2, "x": 0.5, "y": 0.5}, {"type": "histogram", "id": 3},
                {"type": "run", "id": 4, "operation": "gaussian", "dataset": "ball", "parameters": {"sigma": "2vox"}}]
        for i in range(24):
            sock, got = upgrade(server, cookie)
            assert b" 101 " in got
            sock.sendall(hello() + b"".join(frame(json.dumps(ask).encode()) for ask in asks[: i % 5]))
            if i % 3 == 0:
                sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            sock.close()


def test_inputs_from_outside_the_root_can_be_edited_but_no_others_opened():
    os.makedirs("root", exist_ok=True)
    with attacked("--root", "root", verb="serve") as server:
        async def work():
            async with Page(server, 64, 64) as page:
                await page.edit(("set", "title", "mine"))
                write_ball("secret.nrrd", 8)
                for path in ("secret.nrrd", "later.nrrd", "-", "nowhere/../secret.nrrd", "/etc/later", "root/../secret.nrrd"):
                    said = await page.refused("edit", edits=[{"op": "set", "path": "datasets.ball.path", "value": path}])
                    assert "outside" in said, (path, said)
                os.symlink(os.path.abspath("later"), "root/link.vv.json")
                assert await page.refused("save", path="link.vv.json")
        run(work())
    assert not os.path.exists("later")


def test_what_could_be_waited_for_for_ever_is_not_opened():
    os.makedirs("pipes", exist_ok=True)
    os.mkfifo("pipes/fifo.nii")
    os.symlink("fifo.nii", "pipes/link.nii")
    os.symlink("/dev/zero", "pipes/zero.nrrd")
    with open("pipes/scene.vv.json", "w", encoding="ascii") as file:
        json.dump({"schema": 1, "datasets": {"a": {"path": "fifo.nii"}}, "volumes": {"a": {"data": "a"}}}, file)
    write_ball("pipes/ball.nrrd", 8)
    with attacked("--root", "/", verb="serve") as server:
        async def work():
            async with Page(server, 64, 64) as page:
                for name in ("fifo.nii", "link.nii", "zero.nrrd", "scene.vv.json", "/proc/kmsg", "/proc/self/mem", "/dev/tty"):
                    path = name if name[0] == "/" else os.path.abspath("pipes/" + name)
                    for more in ({}, {"add": True}):
                        said = await page.refused("open", path=path, **more)
                        assert "neither a file nor a folder" in said, (path, said)
                    said = await page.refused("edit", edits=[
                        {"op": "add", "path": "datasets", "id": "z", "value": {"path": path}},
                        {"op": "add", "path": "volumes", "id": "z", "value": {"data": "z"}}]) if ".json" not in path else "neither"
                    assert "neither" in said, (path, said)
                await page.ask("open", path=os.path.abspath("pipes/ball.nrrd"))
                await page.resting()
        run(work())


def test_numbers_and_texts_beyond_measure_are_answered():
    with attacked() as server:
        async def work():
            async with Page(server, 64, 64) as page:
                async def said(value, path="lights.sun.intensity"):
                    page.ids += 1
                    await page.socket.send('{"type": "edit", "id": %d, "edits": [{"op": "set", "path": "%s", "value": %s}]}'
                                           % (page.ids, path, value))
                    return await page.until(lambda: next((m for m in page.messages if m["type"] == "answer"
                                                          and m["id"] == page.ids), None))
                await page.ask("edit", edits=[{"op": "add", "path": "lights", "id": "sun"}])
                for value, sentence in (("9223372036854775808", "intensity"), ("-99999999999999999999999", "intensity"),
                                        ("1e999", "too large to compute"), ("[1, -1e999, 9223372036854775808]", "too large to compute"),
                                        ("9" * 400, "too large to compute"), ('"a\\u0000b"', "U+0000")):
                    got = await said(value)
                    assert not got["ok"] and sentence in got["error"], (value, got)
                assert not (await said('"1e999 \\" 5\\u0000"', "title"))["ok"]
                assert (await said("9223372036854775808", "volumes.ball.segmentation.transfer.range_hi"))["ok"]
                transfer = await page.until(lambda: page.world["world"]["volumes"]["ball"].get("segmentation"))
                assert transfer["transfer"]["range_hi"] == 2 ** 63
        run(work())


if __name__ == "__main__":
    main()
