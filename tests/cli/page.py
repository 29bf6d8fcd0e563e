"""What a page does, for tests of the server: it shows the token, sends messages, acknowledges frames."""
import asyncio
import json
import struct
import time

import websockets

import worlds
from served import Server  # noqa: F401: of those who have pages

HEAD = struct.Struct("<4sHHIHHHHHHIf")
# Of src/server, and a little more; its clock is ours.
REST_SECONDS = 0.16  # VVI_REST: a view that has not moved for so long is at rest
TOLD_SECONDS = 0.04  # WORLD_PAUSE: the newest World is told after so long at the latest
STIRS = ("events", "action", "camera", "size")  # messages that may set a view in motion


class Frame:
    def __init__(self, data):
        (magic, self.kind, flags, self.number, self.width, self.height, self.full_width, self.full_height, self.level,
         self.passes, self.commit, self.age) = HEAD.unpack(data[:32])
        assert magic == b"VVF1"
        self.final, self.moving = bool(flags & 1), bool(flags & 2)
        self.data = data[32:]
        self.broken = not self.data.endswith((b"\xff\xd9", b"IEND\xaeB`\x82"))  # off, since the line is too thin


class Page:
    """One WebSocket, greeted. Use it as `async with`."""

    def __init__(self, server, width=320, height=240, acknowledges=True, plane=None):
        self.server, self.size, self.acknowledges = server, (width, height), acknowledges
        self.plane = {"plane": plane} if plane else {}
        self.frames, self.messages, self.ids, self.world, self.pose = [], [], 0, None, None
        self.wanted, self.stirred = "all", False

    async def __aenter__(self):
        self.socket = await websockets.connect(
            f"ws://localhost:{self.server.port}/ws", subprotocols=["volvis"], origin=self.server.base,
            extra_headers={"Cookie": self.server.cookie()}, max_size=None, compression=None)
        await self.say("hello", width=self.size[0], height=self.size[1], **self.plane)
        await self.until(lambda: self.world is not None)
        return self

    async def __aexit__(self, *_):
        await self.socket.close()

    async def say(self, kind, **members):
        self.stirred |= kind in STIRS or "gesture" in members
        self.wanted = members["wanted"] if kind == "frames" else self.wanted
        await self.socket.send(json.dumps({"type": kind, **members}))

    async def take(self, seconds):
        message = await asyncio.wait_for(self.socket.recv(), seconds)
        if isinstance(message, bytes):
            frame = Frame(message)
            if not frame.broken:
                self.frames.append(frame)
            if self.acknowledges:
                await self.say("ack", frame=frame.number)
            return frame
        n, message = len(message), json.loads(message)
        self.messages.append(message)
        if message["type"] == "world":
            self.world = worlds.take(self.world, message)
            self.told_bytes = n
        if message["type"] == "pose":
            self.pose = message
        return message

    async def until(self, wanted, seconds=60, meanwhile=None):
        """Takes messages until wanted() is true; returns what it says. meanwhile(): is done again every 20 ms."""
        end, due = time.monotonic() + seconds, 0
        while not (found := wanted()):
            left = end - time.monotonic()
            assert left > 0, f"it did not come in {seconds} s; the last: {[str(m)[:150] for m in self.messages[-5:]]}"
            if meanwhile and time.monotonic() >= due:
                await meanwhile()
                due = time.monotonic() + 0.02
            try:
                await self.take(max(0.001, due - time.monotonic()) if meanwhile else left)
            except asyncio.TimeoutError:
                pass
        return found

    async def answer(self, kind, seconds=60, **members):
        """The whole answer."""
        self.ids += 1
        number = self.ids
        await self.say(kind, id=number, **members)
        return await self.until(lambda: next((m for m in self.messages if m["type"] == "answer" and m["id"] == number),
                                             None), seconds)

    async def ask(self, kind, seconds=60, **members):
        """The value of the answer; an AssertionError with its sentence where it is refused."""
        answer = await self.answer(kind, seconds, **members)
        assert answer["ok"], answer["error"]
        return answer["value"]

    async def refused(self, kind, **members):
        """The sentence of a refusal."""
        try:
            value = await self.ask(kind, **members)
        except AssertionError as error:
            return str(error)
        raise AssertionError(f"{kind} was not refused: {value}")

    async def edit(self, *edits, **more):
        return await self.ask("edit", edits=[dict(zip(("op", "path", "value"), e)) for e in edits], **more)

    async def heard(self):
        """The server has done all that was said to it; what takes time goes on."""
        await self.ask("cancel", job=-1)

    async def told(self):
        """All has come that the server had to tell by now: it answers, and says nothing else before."""
        n = -1
        while len(self.messages) + len(self.frames) != n + 1:
            n = len(self.messages) + len(self.frames)
            await self.heard()

    async def resting(self, seconds=60):
        """The final frame of the view as it is when all that was said is done, and nothing moves any more.

        A final frame does not say whether it is the last one: an older one may be on its way for long. So we let the server
        come to rest, learn the number of the World as it is then, and wait for a final frame of no older one. Where the last
        commit changed nothing of this view, there will be none, unless it is asked for."""
        await self.heard()
        if self.stirred:
            await asyncio.sleep(REST_SECONDS)
            await self.heard()
        await asyncio.sleep(TOLD_SECONDS)
        await self.told()
        self.stirred, number, wanted = False, self.world["number"], self.wanted

        def last():
            return self.frames[-1] if self.frames and self.frames[-1].final and self.frames[-1].commit >= number else None
        if not last():
            await self.say("frames", wanted="none")
            await self.say("frames", wanted=wanted)
        frame = await self.until(last, seconds)
        await self.told()  # of where it stands too
        return frame


def run(coroutine):
    return asyncio.run(coroutine)
