"""The server with pages that are slow: they cost a bounded amount, and nobody else waits for them."""
import asyncio
from contextlib import contextmanager
import json
import math
import os
import socket
import threading
import time

from harness import main, sanitized
from page import Page, run
from wire import attacked, behaves, connect, frame, hello, resident_kib, upgrade


def say(sock, **message):
    sock.sendall(frame(json.dumps(message).encode()))


def lazy_socket(server, cookie, width=256, height=256, room=4096):
    """A page that has said hello and reads nothing of itself. room: bytes that its system keeps for it; None: as it likes."""
    sock = connect(server)
    if room:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, room)
    _, got = upgrade(server, cookie, sock=sock)
    assert b" 101 " in got, got
    sock.sendall(hello(width, height))
    return sock


def messages(sock, seconds=20, until=lambda message: False):
    """What comes, in turn: texts as objects, frames as their numbers; until one is wanted, or the time is over."""
    box, end = b"", time.monotonic() + seconds
    sock.settimeout(0.1)
    while time.monotonic() < end:
        try:
            piece = sock.recv(1 << 16)
        except socket.timeout:
            continue
        if not piece:
            return
        box += piece
        while (found := parse(box)) is not None:
            code, data, box = found
            message = json.loads(data) if code == 1 else int.from_bytes(data[8:12], "little") if code == 2 else data
            yield message
            if until(message):
                return


def parse(box):
    """Opcode and payload of the first frame of the server, and what is behind it; None: it is not whole."""
    if len(box) < 2:
        return None
    n, at = box[1] & 127, 2
    if n > 125:
        at = 4 if n == 126 else 10
        n = int.from_bytes(box[2:at], "big")
    return (box[0] & 15, box[at:at + n], box[at + n:]) if len(box) >= at + n else None


async def frames_of_turning_pages(server, n, seconds):
    """Frames that each of n pages gets which turn without pause."""
    async def turn(page):
        await page.resting()
        began, page.frames = time.monotonic(), []
        await page.say("events", lines="0 mouse axis x 0\n0 mouse axis y 0\n0 mouse button left down\n")
        while (passed := time.monotonic() - began) < seconds:
            await page.say("events", lines=f"{int(passed * 1e9)} mouse axis x {0.3 * math.sin(passed):.4f}\n")
            try:
                while True:
                    await page.take(0.02)
            except asyncio.TimeoutError:
                pass
        await page.say("events", lines=f"{int(seconds * 1e9)} mouse button left up\n")
        return len(page.frames)
    pages = [await Page(server, 256, 256).__aenter__() for _ in range(n)]
    counts = await asyncio.gather(*(turn(page) for page in pages))
    for page in pages:
        await page.socket.close()
    return counts


@contextmanager
def restless(sockets, reads):
    """They turn all the time; of what comes, they read as many bytes a second."""
    stop = threading.Event()

    def move():
        began = time.monotonic()
        for sock in sockets:
            say(sock, type="events", lines="0 mouse axis x 0\n0 mouse axis y 0\n0 mouse button left down\n")
        while not stop.wait(0.05):
            passed = time.monotonic() - began
            for sock in sockets:
                say(sock, type="events", lines=f"{int(passed * 1e9)} mouse axis x {0.3 * math.sin(passed):.4f}\n")
    def read():
        while reads and not stop.wait(1 / reads):
            for sock in sockets:
                sock.recv(1)
    threads = [threading.Thread(target=move), threading.Thread(target=read)]
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        stop.set()
        for thread in threads:
            thread.join()


def test_pages_that_read_next_to_nothing_keep_nobody_waiting():
    with attacked() as server:
        alone = run(frames_of_turning_pages(server, 2, 2))
        cookie = server.cookie()
        for reads, side in ((0, 1536), (1, 256)): # frames of the large ones would take nearly all of the time
            slow = [lazy_socket(server, cookie, side, side) for _ in range(6)]
            run(behaves(server)) # what they see at first is rendered
            before = resident_kib(server)
            with restless(slow, reads):
                beside = run(frames_of_turning_pages(server, 2, 2))
            grown = resident_kib(server) - before
            # the machine has other things to do
            assert sanitized() or min(beside) > 0.5 * min(alone), (reads, alone, beside)
            assert sanitized() or side > 256 or grown < 6 * 600 + 4000, f"{grown} KiB for six who read a byte a second"
            for sock in slow:
                sock.close()


def test_who_comes_back_to_reading_sees_what_is_true_now():
    with attacked() as server:
        slow = lazy_socket(server, server.cookie(), 64, 64)

        async def edit(n):
            async with Page(server, 64, 64) as page:
                for i in range(n):
                    await page.edit(("set", "title", f"title {i}" + "x" * 3000), gesture="g")
                    await asyncio.sleep(0.01)
                await page.until(lambda: page.world["world"]["title"].startswith(f"title {n - 1}x"))
        time.sleep(0.5)
        run(edit(300))
        titles = []
        for message in messages(slow, until=lambda m: isinstance(m, dict) and m["type"] == "world" and
                                m["world"].get("title", "").startswith("title 299x")):
            if isinstance(message, int):
                say(slow, type="ack", frame=message)
            elif message["type"] == "world":
                titles.append(message["world"].get("title", ""))
        assert titles and titles[-1].startswith("title 299x"), [t[:9] for t in titles]
        assert len(titles) < 30, f"{len(titles)} Worlds for who did not look"
        slow.close()


def test_who_asks_and_does_not_read_is_not_listened_to_and_misses_no_answer():
    for i in range(400):
        open(f"a-file-with-a-rather-long-name-that-is-told-{i}.nrrd", "wb").close()
    with attacked("--root", ".", verb="serve") as server:
        sock = lazy_socket(server, server.cookie(), 64, 64, None)
        time.sleep(0.5)
        before, asked = resident_kib(server), 600
        writer = threading.Thread(target=lambda: [say(sock, type="browse", id=i + 1, path="") for i in range(asked)])
        writer.start() # 600 answers of 40 kB: 24 MB
        time.sleep(1)
        run(behaves(server))
        grown = resident_kib(server) - before
        assert sanitized() or grown < 3000, f"{grown} KiB for one who does not read"
        ids = []
        for message in messages(sock, 60, until=lambda m: isinstance(m, dict) and m.get("id") == asked):
            if isinstance(message, int):
                say(sock, type="ack", frame=message)
            elif message["type"] == "answer":
                assert message["ok"], message
                ids.append(message["id"])
        writer.join()
        assert ids == list(range(1, asked + 1)), (len(ids), ids[-3:])
        sock.close()
    for name in os.listdir("."):
        if name.startswith("a-file-with"):
            os.remove(name)


if __name__ == "__main__":
    main()
