"""The server with more connections than it can have, and what it writes down."""
import json
import os
import re
import resource
import select
import signal
import stat

import served
from harness import main, ok, says, write_ball
from page import Page, Server, run
from wire import answer, attacked, behaves, codes, connect, ends, head, upgrade, wait_for

try:
    import websockets
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")


def may_open(n):
    """As many files, of this program and of the server that it starts."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    assert most == resource.RLIM_INFINITY or most >= n, f"this system lets a program open {most} files"
    resource.setrlimit(resource.RLIMIT_NOFILE, (n, most))


# Connections --------------------------------------------------------------------------------------------------------

def test_a_thousand_slow_heads_keep_nobody_out():
    may_open(4000)
    with attacked() as server:
        slow = [connect(server) for _ in range(1000)]
        for sock in slow:
            sock.sendall(b"GET / HTTP/1.1\r\nHost: loc")
        run(behaves(server))
        for sock in slow[::10]:
            try:
                sock.sendall(b"a")
            except OSError:
                pass
        run(behaves(server))
        assert all(ends(sock) for sock in slow), "a head may take for ever"
        for sock in slow:
            sock.close()


def few_files(n):
    """A program that may open n files and is VolVis else."""
    with open("few", "w", encoding="ascii") as file:
        file.write(f'#!/bin/sh\nulimit -n {n}\nexec "{os.path.abspath(served.VOLVIS)}" "$@"\n')
    os.chmod("few", 0o755)
    return os.path.abspath("few")


def test_when_there_are_too_many_connections_others_are_asked_to_come_again():
    whole = served.VOLVIS
    served.VOLVIS = few_files(200) # 100 connections
    try:
        write_ball("ball.nrrd", 16)
        server = Server("ball.nrrd")
    finally:
        served.VOLVIS = whole
    with server:
        cookie = server.cookie()
        idle = [upgrade(server, cookie)[0] for _ in range(90)]
        code, headers, body = server.request("/")
        assert code == 503 and int(headers["retry-after"]) > 0 and b"too many connections" in body, (code, body)
        assert server.request("/session", b"{}")[0] == 503
        more = [connect(server) for _ in range(60)]
        assert select.select(more, [], [], 60)[0], "there is no limit"
        assert server.process.poll() is None
        for sock in idle + more:
            sock.close()

        def is_let_in():
            try:
                return server.request("/")[0] == 200
            except OSError:  # closed at once
                return False
        wait_for(is_let_in, "there is room again when the others have gone")
        run(behaves(server))


def test_one_more_than_may_look_is_told_so():
    with attacked("--root", ".", "--clients", 2, verb="serve") as server:
        async def three():
            async with Page(server, 16, 16), Page(server, 16, 16):
                try:
                    async with Page(server, 16, 16):
                        raise AssertionError("three look where two may")
                except websockets.exceptions.ConnectionClosed as closed:
                    assert closed.code == 1013 and "2 people" in closed.reason, closed
        run(three())


# What is written down -----------------------------------------------------------------------------------------------

def test_the_audit_says_who_opened_what_and_nothing_anywhere_tells_a_secret():
    write_ball("other.nrrd", 8)
    name = "<img src=x onerror=alert(1)>\n.nrrd"
    write_ball(name, 8)
    os.makedirs("outside", exist_ok=True)
    secret = "a-token-that-nobody-knows-0123456789"
    with open("token", "w", encoding="ascii") as file:
        file.write(secret + "\n")
    write_ball("ball.nrrd", 16)
    server = Server("ball.nrrd", "--root", ".", "--audit", "audit.jsonl", "--record", "record.txt", "--token-file", "token", "-v",
                    verb="serve")
    server.request("/session", json.dumps({"token": "x" * 30}).encode())
    cookie = server.cookie()

    async def work():
        async with Page(server, 64, 64) as one:
            await one.ask("open", path="other.nrrd")
            await one.ask("open", path=name)
            assert any(entry["name"] == name for entry in (await one.ask("browse", path=""))["entries"])
            assert await one.refused("open", path="/etc/passwd")
            assert await one.refused("edit", edits=[{"op": "set", "path": "datasets.x.path", "value": "/etc/shadow"}])
            await one.ask("save", path="scene.vv.json")
            await one.edit(("set", "title", "what people say is not written down"))
    run(work())
    assert server.request("/files/up.nrrd", b"abc", method="PUT", Cookie=cookie)[0] == 201
    code, said = server.end(signal.SIGINT)
    assert code in (0, 130), said

    with open("audit.jsonl", encoding="utf-8") as file:
        lines = [json.loads(line) for line in file]
    assert stat.S_IMODE(os.stat("audit.jsonl").st_mode) == 0o600
    assert all(line["address"] == "127.0.0.1" and re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", line["time"]) for line in lines)
    told = [(line["what"], line.get("object"), line.get("refused", False)) for line in lines]
    for expected in (("token", None, True), ("token", None, False), ("comes", None, False), ("open", "other.nrrd", False),
                     ("open", name, False), ("open", "/etc/passwd", True), ("edit", "/etc/shadow", True),
                     ("save", "scene.vv.json", False), ("upload", "up.nrrd", False), ("leaves", None, False)):
        assert expected in told, (expected, told)
    assert len({line["client"] for line in lines if "client" in line}) == 1

    written = {"stderr": said}
    for folder, _, names in os.walk("."):
        for one in names:
            path = os.path.join(folder, one)
            if one != "token" and os.path.getsize(path) < 1 << 20:
                with open(path, encoding="latin-1") as file:
                    written[path] = file.read()
    for path, text in written.items():
        assert secret not in text and cookie.split("=")[1] not in text and "x" * 30 not in text, path
    assert "what people say" not in written["./audit.jsonl"]


def test_an_audit_that_cannot_be_written_is_told_at_once():
    from harness import fails
    write_ball("ball.nrrd", 8)
    says(fails(5, "serve", "ball.nrrd", "--root", ".", "--audit", "/proc/nothing/audit"), "/proc/nothing/audit")


def test_a_name_of_a_file_is_never_part_of_a_page():
    name = "%3Cscript%3Ealert(1)%3C%2Fscript%3E"
    with attacked() as server:
        cookie = server.cookie()
        for path in (f"/{name}", f"/files/{name}", f"/files/1/{name}", f"/?{name}", f"/<script>alert(1)</script>"):
            got = answer(server, head(server, f"GET {path} HTTP/1.1", "Connection: close", cookie=cookie))
            parts = got.split(b"\r\n\r\n", 1)
            assert codes(got)[:1] != [302] and b"location:" not in parts[0].lower()
            assert b"alert(1)" not in got, got
            if codes(got)[:1] != [200]:
                assert b"text/html" not in parts[0].lower(), got
        got = answer(server, head(server, "PUT /files/%3Cimg%20src=x%20onerror=alert(1)%3E HTTP/1.1", "Content-Length: 1",
                                  cookie=cookie) + b"x")
        assert b"application/json" in got or 400 in codes(got), got


if __name__ == "__main__":
    main()
