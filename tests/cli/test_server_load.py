"""The server with pages that are slow: they cost a bounded amount, and nobody else waits for them."""
import asyncio
from contextlib import contextmanager
import json
import math
import os
import socket
import threading
import time

from harness import main, sanitized, write_nrrd
from page import Frame, Page, run
from wire import attacked, behaves, connect, frame, hello, parse, resident_kib, rounds, untaken, upgrade, wait_for


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


def messages(sock, until, seconds=60):
    """What comes, in turn: texts as objects, frames as their numbers; until one is wanted."""
    box, end, message = b"", time.monotonic() + seconds, None
    sock.settimeout(seconds)
    while piece := sock.recv(1 << 16):
        box += piece
        while (found := parse(box)) is not None:
            code, data, box = found
            if code > 8:  # whether we are there
                continue
            message = json.loads(data) if code == 1 else int.from_bytes(data[8:12], "little") if code == 2 else data
            yield message
            if until(message):
                return
        assert time.monotonic() < end, f"what is wanted did not come in {seconds} s; the last: {str(message)[:300]}"
    raise AssertionError("the server has ended the connection")


async def seconds_of_turning_pages(server, n_pages, n_frames):
    """Until each of them, which turn without pause, has got so many frames."""
    async def turn(page):
        await page.resting()
        began, page.frames = time.monotonic(), []

        async def move():
            passed = time.monotonic() - began
            await page.say("events", lines=f"{int(passed * 1e9)} mouse axis x {0.3 * math.sin(passed):.4f}\n")
        await page.say("events", lines="0 mouse axis x 0\n0 mouse axis y 0\n0 mouse button left down\n")
        await page.until(lambda: len(page.frames) >= n_frames, meanwhile=move)
        return time.monotonic() - began
    pages = [await Page(server, 256, 256).__aenter__() for _ in range(n_pages)]
    seconds = await asyncio.gather(*(turn(page) for page in pages))
    for page in pages:
        await page.socket.close()
    return max(seconds)


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


def check_waiting(server, reads, side):
    """Whether two who turn have their frames beside slow pages nearly as soon as alone."""
    alone = run(seconds_of_turning_pages(server, 2, 30))
    slow = [lazy_socket(server, server.cookie(), side, side) for _ in range(6)]
    run(behaves(server))  # what they see at first is rendered
    before = resident_kib(server)
    with restless(slow, reads):
        beside = run(seconds_of_turning_pages(server, 2, 30))
    grown = resident_kib(server) - before
    assert sanitized() or side > 256 or grown < 6 * 600 + 4000, f"{grown} KiB for six who read a byte a second"
    for sock in slow:
        sock.close()
    return alone, beside


def pictures_at(sock, rate, seconds):
    """Frames and when they came, to who reads so many bytes a second and confirms each."""
    box, began, budget, last = b"", time.monotonic(), 0, time.monotonic()
    sock.settimeout(1)
    while (now := time.monotonic()) < began + seconds:
        budget, last = min(budget + rate * (now - last), rate), now
        if budget >= 256:
            try:
                piece = sock.recv(min(int(budget), 1 << 16))
            except TimeoutError:
                continue
            assert piece, "the server has ended the connection"
            box, budget = box + piece, budget - len(piece)
        else:
            time.sleep(0.01)
        while (found := parse(box)) is not None:
            code, data, box = found
            if code == 2:
                picture = Frame(data)
                say(sock, type="ack", frame=picture.number)
                yield picture, time.monotonic() - began


def test_a_first_picture_that_the_line_does_not_carry_is_broken_off():
    """Of some 200 kB, at 10 kB a second: nobody waits for 20 seconds to see something."""
    write_nrrd("noise.nrrd", (32, 32, 32), lambda x, y, z: (x * 7919 + y * 104729 + z * 1299709) % 251)
    with attacked("noise.nrrd") as server:
        sock, broken, began = lazy_socket(server, server.cookie(), 640, 480), 0, 0
        for picture, seconds in pictures_at(sock, 10000, 60):
            broken += picture.broken
            if not picture.broken and picture.level == 2:
                break
            began = seconds
        assert not picture.broken and broken == 1, (broken, len(picture.data), seconds)
        assert len(picture.data) < 50000 and seconds - began < 15, (len(picture.data), began, seconds)
        # the line is mended: when a picture has shown that, the whole follows
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        say(sock, type="edit", id=1, edits=[{"op": "set", "path": "volumes.noise.visible", "value": True}])
        for picture, seconds in pictures_at(sock, 1e9, 100):
            assert not picture.broken
            if picture.final:
                break
        assert picture.final and len(picture.data) > 100000, (len(picture.data), seconds)


def test_pages_that_read_next_to_nothing_keep_nobody_waiting():
    with attacked("--spp", "1") as server:  # large pictures of many passes would be what is measured
        large = 512 if sanitized() else 1536  # the sanitizers take ten times as long
        for reads, side in ((0, large), (1, 256)):  # frames of the large ones would take nearly all of the time
            tried = []  # once it must be so: now and then the machine has other things to do
            while not tried or not (sanitized() or any(beside < 2 * alone for alone, beside in tried)):
                assert len(tried) < 10, f"seconds alone and beside those who read {reads} bytes a second: {tried}"
                tried.append(check_waiting(server, reads, side))


def text_in(world):
    return world["world"]["datasets"]["ball"].get("parameters", {}).get("text", "")


def test_who_comes_back_to_reading_sees_what_is_true_now():
    with attacked() as server:
        slow = lazy_socket(server, server.cookie(), 64, 64)
        run(behaves(server))

        async def edit():
            async with Page(server, 64, 64) as page:
                for n in range(60):  # who reads is told so many
                    last = f"text {n + 1}" + "x" * 3000
                    await page.edit(("set", "datasets.ball.parameters", {"text": last}), gesture="g")
                    await page.until(lambda: text_in(page.world) == last)
                return last
        last = run(edit())
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)  # it reads with both hands now
        texts = []
        for message in messages(slow, lambda m: isinstance(m, dict) and m["type"] == "world" and
                                text_in(m) == last):
            if isinstance(message, int):
                say(slow, type="ack", frame=message)
            elif message["type"] == "world":
                texts.append(text_in(message))
        assert len(texts) < 30, f"{len(texts)} Worlds for who did not look"
        slow.close()


def test_who_asks_and_does_not_read_is_not_listened_to_and_misses_no_answer():
    for i in range(400):
        open(f"a-file-with-a-rather-long-name-that-is-told-{i}.nrrd", "wb").close()
    with attacked("--root", ".", verb="serve") as server:
        sock = lazy_socket(server, server.cookie(), 64, 64, None)
        run(behaves(server))
        before, asked = resident_kib(server), 600
        writer = threading.Thread(target=lambda: [say(sock, type="browse", id=i + 1, path="") for i in range(asked)])
        writer.start() # 600 answers of 40 kB: 24 MB
        port, left = sock.getsockname()[1], [0]

        def is_left():
            """Some of it stays where it is, however often the server goes round."""
            rounds(server)
            left.append(untaken(server, port))
            return not writer.is_alive() and left[-1] == left[-2] > 0
        wait_for(is_left, "the server does not listen any more")
        run(behaves(server))
        grown = resident_kib(server) - before
        assert sanitized() or grown < 3000, f"{grown} KiB for one who does not read"
        ids = []
        for message in messages(sock, lambda m: isinstance(m, dict) and m.get("id") == asked):
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
