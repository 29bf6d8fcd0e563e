"""Pages for load: raw sockets and one loop, so that hundreds of them take little of the machine that they share with the server."""
import base64
import json
import math
import os
import random
import select
import socket
import struct
import subprocess
import sys
import time
import urllib.request

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "tests", "cli"))
import worlds  # noqa: E402: of the tests' pages

HEAD = struct.Struct("<4sHHIHHHHHHIf")
MOTIONS = 20 # a second, of a page that moves


def percentile(values, percent):
    ordered = sorted(values)
    return ordered[min(int(percent / 100 * len(ordered)), len(ordered) - 1)] if ordered else float("nan")


def write_volume(path, n, seed=0):
    """A ball with a texture, n^3 bytes."""
    middle, values = (n - 1) / 2, bytearray()
    wave = [0.15 * math.sin((i + 7 * seed) * 0.7) for i in range(n)]
    squares = [((i - middle) / (n / 2)) ** 2 for i in range(n)]
    for z in range(n):
        for y in range(n):
            plane, w = squares[z] + squares[y], wave[z] + wave[y]
            values.extend(max(0, min(255, int(255 * (1.1 - math.sqrt(plane + x) + w)))) for x in squares)
    with open(path, "wb") as file:
        file.write(f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {n} {n} {n}\nencoding: raw\n\n".encode() + values)


class Server:
    """The program, with a state folder of its own below the current one."""

    def __init__(self, *words):
        self.state = os.path.abspath("state")
        self.process = subprocess.Popen([*words, "--json"], stdout=subprocess.PIPE, env={**os.environ, "XDG_STATE_HOME": self.state})
        self.link = json.loads(self.process.stdout.readline())["link"]
        self.base, self.token = self.link.split("/#")
        self.port = int(self.base.rsplit(":", 1)[1])
        request = urllib.request.Request(self.base + "/session", data=json.dumps({"token": self.token}).encode())
        with urllib.request.urlopen(request) as answer:
            self.cookie = answer.headers["set-cookie"].split(";")[0]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()

    def end(self, how):
        self.process.send_signal(how)
        return self.process.wait(60)

    def resident(self):
        """KiB."""
        with open(f"/proc/{self.process.pid}/status", encoding="ascii") as file:
            return next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))

    def mapped(self):
        """KiB of files among what is resident: the system takes it back when it needs it."""
        with open(f"/proc/{self.process.pid}/status", encoding="ascii") as file:
            return next(int(line.split()[1]) for line in file if line.startswith("RssFile"))

    def processor(self):
        """Seconds of processor time."""
        with open(f"/proc/{self.process.pid}/stat", encoding="ascii") as file:
            words = file.read().rsplit(")", 1)[1].split()
        return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")

    def threads(self):
        """Seconds of processor time of threads, by their names."""
        told, folder = {}, f"/proc/{self.process.pid}/task"
        for thread in os.listdir(folder):
            with open(f"{folder}/{thread}/comm", encoding="utf-8") as comm, open(f"{folder}/{thread}/schedstat", encoding="ascii") as stat:
                name = "loop" if int(thread) == self.process.pid else comm.read().strip().rstrip("0123456789")
                told[name] = told.get(name, 0) + int(stat.read().split()[0]) * 1e-9
        return told

    def open_files(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def journal(self):
        """Bytes."""
        return sum(os.path.getsize(os.path.join(folder, name)) for folder, _, names in os.walk(self.state) for name in names
                   if name == "journal.jsonl")


def message(text):
    """A text frame with a mask of zeros."""
    data = text.encode()
    n = len(data)
    size = bytes([0x80 | n]) if n < 126 else b"\xfe" + struct.pack(">H", n) if n < 65536 else b"\xff" + struct.pack(">Q", n)
    return b"\x81" + size + b"\0\0\0\0" + data


class Page:
    def __init__(self, crowd, number, size, greets):
        self.crowd, self.number, self.born, self.first = crowd, number, time.monotonic(), None
        self.random = random.Random(number)
        self.counts = self.keeps_texts = self.closed = self.final = False
        self.world, self.memory, self.answers = None, 0, {}
        self.share, self.period, self.offset, self.was_moving = 0, 8, 0, False
        self.waits_since, self.next_motion, self.angle = None, 0, 0
        self.inbox, self.parts, self.outbox = bytearray(), bytearray(), b""
        self.rate, self.budget, self.asked, self.began = None, 0, time.monotonic(), 0
        self.forget()
        server = crowd.server
        self.socket = socket.socket()
        if self.rate is None and crowd.receive_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, crowd.receive_buffer)
        self.socket.settimeout(30)
        self.socket.connect(("127.0.0.1", server.port))
        lines = ("GET /ws HTTP/1.1", f"Host: localhost:{server.port}", "Upgrade: websocket", "Connection: Upgrade",
                 "Sec-WebSocket-Version: 13", f"Origin: {server.base}", "Sec-WebSocket-Protocol: volvis", f"Cookie: {server.cookie}",
                 "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode())
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        got = b""
        while b"\r\n\r\n" not in got and (piece := self.socket.recv(1)):
            got += piece
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.setblocking(False)
        if b" 101 " not in got[:20]:
            self.fail(f"no upgrade: {bytes(got[:80])!r}")
        elif greets:
            self.say("hello", width=size[0], height=size[1], **({"plane": greets} if isinstance(greets, str) else {}))

    def forget(self):
        """Begins to count anew."""
        self.arrivals, self.previews, self.ages, self.sizes, self.staleness = [], [], [], [], []

    def fail(self, why):
        if not self.closed:
            if self.rate != 0:  # one that reads nothing is to be ended
                self.crowd.errors.append(f"page {self.number}: {why}")
            self.closed = True
            self.crowd.drop(self)

    def say(self, kind, **members):
        self.send(message(json.dumps({"type": kind, **members})))

    def send(self, data):
        self.outbox += data
        try:
            self.outbox = self.outbox[self.socket.send(self.outbox):]
        except BlockingIOError:
            pass
        except OSError as error:
            self.fail(error)

    # Hands

    def moves(self, share, period, offset=0):
        """It moves for this share of each period."""
        self.share, self.period, self.offset = share, period, offset
        self.next_motion = 0

    def hand(self, now):
        phase = ((now + self.offset) % self.period) / self.period
        moving = phase < self.share
        if moving and now >= self.next_motion:
            if not self.was_moving:
                self.waits_since = self.began = now
                self.kind = self.random.choice(("turn", "turn", "turn", "zoom"))
                self.say("events", lines="0 mouse axis x 0.3\n0 mouse axis y 0\n0 mouse button left down\n")
            self.angle += 0.1
            stamp = int(now * 1e9)
            if self.kind == "turn":
                lines = (f"{stamp} mouse axis x {0.3 * math.cos(self.angle):.4f}\n"
                         f"{stamp} mouse axis y {0.3 * math.sin(self.angle):.4f}\n")
            else:
                lines = f"{stamp} mouse axis wheel-y {1 if int(self.angle) % 2 else -1}\n"
            self.say("events", lines=lines)
            self.next_motion = max(self.next_motion + 1 / MOTIONS, now)
        elif self.was_moving and not moving:
            self.say("events", lines=f"{int(now * 1e9)} mouse button left up\n")
            self.waits_since = None
        self.was_moving = moving

    # What comes

    def take(self):
        most = 1 << 18 if self.rate is None else min(int(self.budget), 4096)
        if most < 1:
            return
        try:
            data = self.socket.recv(most)
        except BlockingIOError:
            return
        except OSError as error:
            self.fail(error)
            return
        if not data:
            self.fail("closed by the server")
            return
        self.budget -= len(data)
        self.inbox += data
        while self.take_message():
            pass

    def take_message(self):
        box = self.inbox
        if len(box) < 2:
            return False
        n, head = box[1] & 127, 2
        if n == 126:
            if len(box) < 4:
                return False
            n, head = struct.unpack_from(">H", box, 2)[0], 4
        elif n == 127:
            if len(box) < 10:
                return False
            n, head = struct.unpack_from(">Q", box, 2)[0], 10
        if len(box) < head + n:
            return False
        code, last, data = box[0] & 15, box[0] & 128, bytes(box[head:head + n])
        del box[:head + n]
        if code == 2 or code == 0:
            self.parts += data
            if last:
                data, self.parts = bytes(self.parts), bytearray()
                self.take_frame(data)
        elif code == 1:
            self.take_text(data)
        elif code == 9:
            self.send(bytes([0x8a, 0x80 | n]) + b"\0\0\0\0" + data)
        elif code == 8:
            self.fail(f"closed: {data[2:]!r}")
        return True

    def take_frame(self, data):
        now = time.monotonic()
        head = HEAD.unpack_from(data)
        self.send(message(f'{{"type":"ack","frame":{head[3]}}}'))
        if not data.endswith((b"\xff\xd9", b"IEND\xaeB`\x82")): # it was broken off: one that this line carries follows
            self.asked = now
            return
        if head[2] & 2: # it left after the one before was acknowledged, and after the hand began: it is at most so old
            self.staleness.append(now - max(self.asked, self.began) + head[11] / 1000)
        self.asked = now
        self.first = self.first or now - self.born
        self.final = bool(head[2] & 1)
        self.arrivals.append(now)
        self.sizes.append(len(data))
        if head[2] & 2:
            self.ages.append(head[11])
            if self.waits_since is not None:
                self.previews.append(now - self.waits_since)
                self.waits_since = None

    def take_text(self, data):
        start = data[:60]
        if (b'"notice"' in start and b'"error"' in start) or b'"failed"' in start:
            self.crowd.errors.append(f"page {self.number}: {data[:200].decode()}")
        if not self.keeps_texts:
            return
        told = json.loads(data)
        if told["type"] == "answer":
            self.answers[told["id"]] = told
        elif told["type"] == "world":
            self.world = worlds.take(self.world, told)
        elif told["type"] == "status":
            self.memory = told["memory"]


class Crowd:
    """All pages, and the loop that serves them."""

    def __init__(self, server):
        self.server, self.pages, self.errors, self.receive_buffer = server, [], [], None
        self.poll, self.by_file = select.epoll(), {}

    def add(self, size, greets=True):
        """greets: it says hello; the name of a plane: and asks for that."""
        page = Page(self, len(self.pages), size, greets)
        self.pages.append(page)
        if not page.closed:
            self.by_file[page.socket.fileno()] = page
            self.poll.register(page.socket.fileno(), select.EPOLLIN)
        return page

    def join(self, n, size, greets=True):
        for i in range(n):
            self.add(size, greets).counts = True
            if i % 8 == 7:
                self.run(0)

    def join_slowly(self, size, rate):
        """One that reads so many bytes a second."""
        self.receive_buffer = 4096
        page = self.add(size)
        self.receive_buffer = None
        self.poll.unregister(page.socket.fileno()) # it reads by the clock
        page.rate = rate
        return page

    def join_silently(self, size):
        """One that says hello, and reads nothing from then on."""
        self.receive_buffer = 4096
        page = self.add(size)
        self.receive_buffer = None
        self.poll.unregister(page.socket.fileno())
        page.rate = 0
        return page

    def drop(self, page):
        if self.by_file.pop(page.socket.fileno(), None) and page.rate is None:
            self.poll.unregister(page.socket.fileno())
        page.socket.close()

    def move_some(self, share, period):
        for i, page in enumerate(self.pages):
            page.moves(share, period, period * i / len(self.pages))

    def forget(self):
        for page in self.pages:
            page.forget()

    def run(self, seconds, until=None):
        end = time.monotonic() + seconds
        last = time.monotonic()
        while True:
            for number, _ in self.poll.poll(0.004):
                if number in self.by_file:
                    self.by_file[number].take()
            now = time.monotonic()
            for page in self.pages:
                if page.closed:
                    continue
                if page.share or page.was_moving:
                    page.hand(now)
                if page.rate is not None:
                    page.budget = min(page.budget + page.rate * (now - last), page.rate)
                    page.take()
                if page.outbox:
                    page.send(b"")
            last = now
            if now >= end or (until and until()):
                return

    def leave(self):
        for page in self.pages:
            if not page.closed:
                page.closed = True
                self.drop(page)
