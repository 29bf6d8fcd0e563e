"""The server under attack: it answers or closes, stays alive, and serves who behaves."""
import asyncio
import json
import os
import socket
import struct

from harness import main, sanitized, write_ball
from page import Page, Server, run
from wire import answer, attacked, behaves, closes, codes, connect, frame, head, hello, one_answer, quick, resident_kib, upgrade, wait_for

try:
    import websockets
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")


# HTTP ---------------------------------------------------------------------------------------------------------------

def test_heads_that_are_too_large_or_none_are_refused():
    with attacked() as server:
        for bytes_ in (head(server, "GET /" + "a" * 100000 + " HTTP/1.1"), head(server, "GET / HTTP/1.1", "X: " + "y" * 100000),
                       head(server, "GET / HTTP/1.1", *(f"X{i}: y" for i in range(20000))),
                       head(server, "GET / HTTP/1.1", cookie="a=" + "b" * 20000)):
            assert codes(answer(server, bytes_))[:1] not in ([200], [204]), bytes_[:40]
        for bytes_ in (b"\x00" * 5000, b"\r\n" * 5000, b"\xff\xfe\x16\x03\x01" * 100, b"GET\r\n\r\n", b"GET /\r\n\r\n",
                       b"GET / HTTP/9.9\r\n\r\n", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", b"GET / HTTP/1.1\r\n: x\r\n\r\n",
                       b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03"):
            assert codes(answer(server, bytes_))[:1] not in ([200], [204]), bytes_[:40]


def test_a_body_has_one_length():
    with attacked() as server:
        cookie = server.cookie()
        body = json.dumps({"token": server.token}).encode()
        hidden = head(server, "GET /app.js HTTP/1.1")
        for more in (("Content-Length: 5", "Transfer-Encoding: chunked"), ("Transfer-Encoding: chunked",),
                     ("Transfer-Encoding: xchunked", f"Content-Length: {len(body)}"),
                     ("Transfer-Encoding: identity", f"Content-Length: {len(body)}")):
            got = answer(server, head(server, "POST /session HTTP/1.1", *more) + b"0\r\n\r\n" + hidden)
            assert codes(got) in ([400], [411], []), (more, got)
            got = answer(server, head(server, "PUT /files/smuggled.nrrd HTTP/1.1", *more, cookie=cookie) + b"0\r\n\r\n" + hidden)
            assert codes(got) in ([400], [411], []), (more, got)
        for length in ("-1", "99999999999999999999", "x", "5, 6", ""):
            got = answer(server, head(server, "POST /session HTTP/1.1", f"Content-Length: {length}") + b"{}")
            assert 204 not in codes(got), (length, got)
            got = answer(server, head(server, "PUT /files/length.nrrd HTTP/1.1", f"Content-Length: {length}", cookie=cookie)
                         + b"{}")
            assert 201 not in codes(got) or length in ("x", "5, 6", ""), (length, got)
    assert not uploads("smuggled")


def test_requests_one_after_the_other_on_one_connection_are_apart():
    with attacked() as server:
        wrong, right = (json.dumps({"token": token}).encode() for token in ("0" * 64, server.token))
        cookie = server.cookie()

        def post(body):
            return head(server, "POST /session HTTP/1.1", f"Content-Length: {len(body)}") + body

        def put(name):
            return head(server, f"PUT /files/{name} HTTP/1.1", "Content-Length: 3", cookie=cookie) + b"abc"
        get, refused = head(server, "GET /nothing HTTP/1.1"), head(server, "GET / HTTP/1.1").replace(b"localhost", b"evil")
        for requests, expected in (((get, post(right)), [404, 204]), ((post(wrong), post(right), get), [403, 204, 404]),
                                   ((put("a"), put("b"), post(right)), [201, 201, 204]),
                                   ((refused, get), [403, 404])):
            with connect(server) as sock:
                got = []
                for request in requests:
                    sock.sendall(request)
                    got += codes(one_answer(sock))
                assert got == expected, (requests, got)
        assert len(uploads("")) >= 2


def test_wrong_methods_and_places_are_refused():
    with attacked() as server:
        cookie = server.cookie()
        for method in ("DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT", "HEAD", "POST", "PUT", "BREW"):
            for path in ("/", "/ws", "/nothing", "*", "http://evil.example/"):
                got = quick(server, head(server, f"{method} {path} HTTP/1.1", "Content-Length: 0", cookie=cookie))
                assert not [c for c in codes(got) if c < 300] or method == "HEAD", (method, path, got)
                assert b"access-control" not in got.lower()


def test_no_spelling_of_a_path_leads_out():
    with open("/etc/hostname", "rb") as file:
        secret = file.read().strip() or b"root:"
    spellings = ("..", "%2e%2e", "%2E%2e", ".%2e", "..%00", "%252e%252e", "..%5c..", "..\\..", "%c0%ae%c0%ae", "%u002e%u002e",
                 "....//", "..;", "\xc0\xae\xc0\xae", "..%2f..", "%2f..")
    with attacked() as server:
        cookie = server.cookie()
        for spelling in spellings:
            for start in ("/", "/files/", "/files/1/", "//", "/app.js/"):
                for target in ("/etc/hostname", "%2fetc%2fhostname"):
                    got = quick(server, head(server, f"GET {start}{'/'.join([spelling] * 8)}{target} HTTP/1.1", cookie=cookie))
                    assert secret not in got, (start, spelling)
                    assert not [c for c in codes(got) if c == 200] or b"<!doctype html" in got.lower(), (start, spelling, got)
            got = quick(server, head(server, f"PUT /files/{spelling}/{spelling}/evil HTTP/1.1", "Content-Length: 1",
                                     cookie=cookie) + b"x")
            assert spelling.startswith("%25") or 201 not in codes(got) or uploads("evil"), (spelling, got)
    everywhere = [os.path.join(folder, name) for folder, _, names in os.walk(".") for name in names if "evil" in name]
    assert not everywhere, everywhere


def test_names_that_only_look_like_this_server_are_refused():
    with attacked() as server:
        port = server.port
        for host in (f"evil.example:{port}", f"localhost.evil.example:{port}", f"127.0.0.1.evil.example:{port}",
                     f"evil.example#localhost:{port}", f"localhost:{port}@evil.example", f"localhost:{port}.evil.example",
                     f"127.1:{port}", f"0.0.0.0:{port}", f"2130706433:{port}", f"localhost.:{port}", "localhost:0",
                     f"localhost:{port}, evil.example", ""):
            bytes_ = f"GET / HTTP/1.1\r\nHost: {host}\r\n\r\n".encode()
            assert 200 not in codes(quick(server, bytes_)), host
        assert 200 not in codes(quick(server, b"GET / HTTP/1.1\r\n\r\n"))
        two = f"GET / HTTP/1.1\r\nHost: localhost:{port}\r\nHost: evil.example\r\n\r\n".encode()
        assert 200 not in codes(quick(server, two))
        cookie = server.cookie()
        for origin in ("http://evil.example", "null", "", f"https://localhost:{port}", f"http://localhost:{port}.evil.example",
                       f"http://localhost:{port + 1}", f"ws://localhost:{port}"):
            sock, got = upgrade(server, cookie, Origin=origin)
            assert b" 101 " not in got or not origin, (origin, got)
            sock.close()


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
            if os.path.basename(folder) == "files" and part in name]


def test_an_upload_that_breaks_off_leaves_nothing():
    with attacked() as server:
        cookie = server.cookie()
        for promised, sent in ((1000, 10), (10 ** 6, 300000)):
            with connect(server) as sock:
                sock.sendall(head(server, "PUT /files/broken.nrrd HTTP/1.1", f"Content-Length: {promised}", cookie=cookie)
                             + b"x" * sent)
                wait_for(lambda: uploads("broken"), "a file is there that is being written")
            wait_for(lambda: not uploads("broken"), "the part of a file is taken away")
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

def test_an_upgrade_is_for_the_protocol_alone():
    with attacked() as server:
        cookie = server.cookie()
        for protocol in (None, "http", "chat", "volvis2"):
            sock, got = upgrade(server, cookie, protocol)
            assert b" 101 " not in got, (protocol, got)
            sock.close()
        sock, got = upgrade(server, None)
        assert b" 101 " not in got
        sock.close()


def test_bad_frames_end_their_connection_alone():
    welcome = hello()
    bad = {
        "not masked, and no message": frame(b'{"type": 1}', masked=False),
        "a length of 2^63": frame(b"x", length=1 << 63),
        "a length of 2^40": frame(b"x" * 100, length=1 << 40),
        "a long ping": frame(b"p" * 200, opcode=9),
        "a ping in pieces": frame(b"p", opcode=9, final=False),
        "an unknown code": frame(b"x", opcode=3),
        "reserved bits": frame(b"{}", reserved=4),
        "a piece of nothing": frame(b"{}", opcode=0),
        "a message within another": frame(b"{", final=False) + frame(b"{}"),
        "no text": frame(b"\xff\xfe\xfd"),
        "binary": frame(b"\x00" * 100, opcode=2),
        "2 MiB": frame(b"\x00" * (2 << 20), length=2 << 20),
        "pieces without end": b"".join([frame(b"[" * 60000, final=False)] + [frame(b"[" * 60000, opcode=0, final=False)] * 20),
    }
    with attacked() as server:
        cookie = server.cookie()
        sockets = {}
        for name, bytes_ in bad.items():
            sockets[name], got = upgrade(server, cookie)
            assert b" 101 " in got, got
            try:
                sockets[name].sendall(welcome + bytes_)
            except OSError:
                pass
        for name, sock in sockets.items():
            assert closes(sock), name
            sock.close()
        assert server.process.poll() is None


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
        assert closes(other), "20000 messages at once were taken"
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
                    await page.edit(("set", "title", f"{i} " + "x" * 20000), gesture="g")
                for sock in silent:
                    sock.sendall(frame(json.dumps({"type": "events", "lines": f"{n} mouse axis x 0.5"}).encode()))
                return resident_kib(server)
        run(work(200, []))
        silent = []
        for _ in range(8):
            sock, got = upgrade(server, cookie)
            assert b" 101 " in got
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            sock.sendall(hello(256, 256))
            silent.append(sock)
        run(behaves(server))
        before = run(work(50, silent))
        after = run(work(400, silent))
        assert sanitized() or after - before < 8 * 1100, f"{after - before} KiB more for 8 who never read"
        for sock in silent:
            sock.close()


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
