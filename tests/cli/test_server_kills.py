"""The server is killed at random moments while people edit, save, render, upload and run operations. What was answered is
there after the next start, nothing is torn, nothing is left over, and the session goes on. VOLVIS_KILLS: how often (8)."""
import asyncio
import json
import os
import random
import signal
import struct
import time

from harness import main, ok, write_ball
from page import Page, Server, run

try:
    import websockets
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")

KILLS = int(os.environ.get("VOLVIS_KILLS", "8"))
DATA = bytes(range(256)) * 2000


class Round:
    """What one server was asked until it was killed."""

    def __init__(self, server, number):
        self.server, self.number, self.cookie = server, number, server.cookie()
        self.asked = self.answered = None  # titles
        self.uploads, self.done = [], {"edit": 0, "save": 0, "picture": 0, "run": 0, "upload": 0}

    async def edits(self, page):
        for i in range(100000):
            self.asked = f"{self.number} {i} " + "x" * 200
            await page.edit(("set", "title", self.asked))
            self.answered = self.asked
            self.done["edit"] += 1

    async def saves(self, page):
        for i in range(100000):
            await page.ask("save", path="scene.vv.json", replace=True)
            self.done["save"] += 1

    async def pictures(self, page):
        for i in range(100000):
            await page.ask("picture", width=300, height=200, name="picture.png")
            self.done["picture"] += 1

    async def operations(self, page):
        for i in range(100000):
            made = (await page.ask("run", operation="gaussian", dataset="ball", parameters={"sigma": "1vox"}))["dataset"]
            await page.ask("write", dataset=made, path=f"smooth{i % 3}.nrrd", replace=True)
            self.done["run"] += 1

    async def turns(self, page):
        await page.say("events", lines="0 mouse axis x 0\n0 mouse axis y 0\n0 mouse button left down\n")
        for i in range(100000):
            await page.say("events", lines=f"{i * 20000000} mouse axis x {0.3 * (i % 7):.2f}\n")
            await page.take(5)

    async def puts(self, _):
        for i in range(100000):
            reader, writer = await asyncio.open_connection("127.0.0.1", self.server.port)
            writer.write(f"PUT /files/{self.number}-{i}.bin HTTP/1.1\r\nHost: localhost:{self.server.port}\r\nCookie: {self.cookie}\r\n"
                         f"Content-Length: {len(DATA)}\r\n\r\n".encode() + DATA[:-1000])
            await asyncio.sleep(0.05)  # the server has some of it, when it is killed
            writer.write(DATA[-1000:])
            head, _, body = (await reader.read()).partition(b"\r\n\r\n")
            if b" 201 " in head and body.endswith(b"}"):  # all of the answer
                self.uploads.append(json.loads(body)["path"])
                self.done["upload"] += 1
            writer.close()

    async def until_killed(self, seconds):
        async def one(work, pages):
            try:
                if not pages:
                    return await work(None)
                async with Page(self.server, 64, 64) as page:
                    await work(page)
            except (OSError, AssertionError, websockets.exceptions.WebSocketException, asyncio.TimeoutError) as error:
                if self.server.process.poll() is None and not self.killed:
                    raise AssertionError(f"{work.__name__}: {error}") from error

        async def kill():
            await asyncio.sleep(seconds)
            self.killed = True
            self.server.process.send_signal(signal.SIGKILL)
        self.killed = False
        works = [(self.edits, True), (self.saves, True), (self.pictures, True), (self.operations, True), (self.turns, True), (self.puts, False)]
        await asyncio.gather(kill(), *(one(*work) for work in works))
        self.server.process.communicate()


def files(folder):
    return [os.path.join(at, name) for at, _, names in os.walk(folder) for name in names]


def check_files(uploads):
    """All that a name leads to is whole."""
    for path in files(".") + uploads:
        with open(path, "rb") as file:
            data = file.read()
        if path.endswith(".bin"):
            assert data == DATA, f"{path} has {len(data)} bytes"
        elif path.endswith(".vv.json"):
            assert isinstance(json.loads(data)["schema"], int), path
        elif path.endswith(".png"):
            assert data[:8] == b"\x89PNG\r\n\x1a\n" and data[-12:-8] == b"\0\0\0\0" and data[-8:-4] == b"IEND", path
            assert struct.unpack(">II", data[16:24]) == (300, 200), path
        elif path.endswith(".nrrd"):
            head, samples = data.split(b"\n\n", 1)
            assert b"encoding: raw" not in head or len(samples) in (24 ** 3, 2 * 24 ** 3, 4 * 24 ** 3), f"{path}: {len(samples)}"


async def goes_on(server, last):
    """The World is what it was told to be, and can be changed and seen."""
    async with Page(server, 64, 64) as page:
        title = page.world["world"].get("title")
        assert title in (last.answered, last.asked), f"it was {last.answered}, and is {title}"
        await page.edit(("set", "title", "goes on"))
        await page.until(lambda: page.frames)
        return "goes on"


def test_a_server_that_is_killed_at_any_moment_goes_on():
    write_ball("ball.nrrd", 24)
    chance, uploads, done, last = random.Random(time.time_ns()), [], {}, None
    print(f"{KILLS} kills", flush=True)
    for number in range(KILLS + 1):
        server = Server("ball.nrrd", "--root", ".", "--upload", "40MB", verb="serve")
        try:
            parts = [path for path in files(".") if path.endswith(".part")]
            assert not parts, f"after {number} kills there are {parts} of {server.process.pid}"
            check_files(uploads)
            if last:
                run(goes_on(server, last))
            if number == KILLS:
                break
            before, last = last, Round(server, number)
            last.asked = last.answered = "goes on" if before else None
            run(last.until_killed(0.15 + chance.random() * 0.8))
            uploads += last.uploads
            done = {kind: n + done.get(kind, 0) for kind, n in last.done.items()}
        except BaseException:
            server.process.kill()
            server.process.communicate()
            raise
    server.end(signal.SIGINT)
    print(f"{KILLS} kills among {done}", flush=True)
    assert done["edit"] and done["upload"], done
    assert ok("info", "scene.vv.json", "--json").json if os.path.exists("scene.vv.json") else True


if __name__ == "__main__":
    main()
