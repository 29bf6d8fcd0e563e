"""What an attack is, and how one is made on a server: bytes go out, and what comes back is held against what is expected."""
from dataclasses import dataclass
import json
import os
import re
import socket
import time

from wire import codes, connect, frame, head, parse, upgrade

PATIENCE = 20  # seconds for what should come at once: other things go on on this machine
HEADERS = (b"content-security-policy: default-src 'self'", b"x-content-type-options: nosniff", b"x-frame-options: deny",
           b"referrer-policy: no-referrer", b"cross-origin-opener-policy: same-origin", b"cache-control: no-store",
           b"cross-origin-resource-policy: same-origin", b"connection: close")
NEVER = (b"access-control", b"\nserver:", b"root:", b"volvis-secret", b"alert(1)")


@dataclass
class Attack:
    """Bytes on a connection of their own. expects: statuses of the one answer; 0: the connection ends without one."""
    name: str
    bytes: bytes
    expects: tuple


@dataclass
class Frames:
    """Bytes on a WebSocket that has said hello. expects: codes of its farewell; 0: it goes on and is answered."""
    name: str
    bytes: bytes
    expects: tuple


@dataclass
class Asks:
    """Messages (type, members, done) of a page, one after the other is answered or all together. done: whether it is done (True), refused
    with a sentence (False), or either (None). leaves: without a farewell, and without reading."""
    name: str
    messages: list
    together: bool = False
    leaves: bool = False


class Failed(Exception):
    pass


def expect(what, told):
    if not what:
        raise Failed(told)


def until_end(sock, seconds):
    """All that comes until the other side ends the connection."""
    got, end = b"", time.monotonic() + seconds
    try:
        while (left := end - time.monotonic()) > 0:
            sock.settimeout(left)
            if not (piece := sock.recv(65536)):
                return got
            got += piece
    except socket.timeout:
        pass
    except OSError:
        return got
    raise Failed(f"the connection does not end in {seconds} s; so far {got[:200]}")


def send(sock, data):
    try:
        sock.sendall(data)
    except OSError:  # it ended while we spoke: so it should
        pass


def check_answer(got):
    lower = got.lower()
    for word in NEVER:
        expect(word not in lower, f"{word} is in the answer {got[:400]}")
    if got and not got.startswith(b"HTTP/1.1 101"):
        for line in HEADERS:
            expect(line in lower.split(b"\r\n\r\n")[0], f"{line} is not in the head of {got[:400]}")


def attack_by_bytes(server, attack):
    with connect(server) as sock:
        send(sock, attack.bytes)
        got = until_end(sock, PATIENCE)
    check_answer(got)
    found = codes(got) or [0]
    expect(len(found) == 1, f"{len(found)} answers to one connection: {found}")
    expect(found[0] in attack.expects, f"the answer is {found[0]}, not one of {attack.expects}: {got[:300]}")


def farewell(sock, asked):
    """The code that a WebSocket ends by; 0: what was asked was answered, and it goes on."""
    box, end = b"", time.monotonic() + PATIENCE
    while (left := end - time.monotonic()) > 0:
        sock.settimeout(left)
        try:
            piece = sock.recv(65536)
        except socket.timeout:
            break
        except OSError:
            return 1006
        if not piece:
            return 1006
        box += piece
        while (found := parse(box)) is not None:
            kind, data, box = found
            if kind == 8:
                return int.from_bytes(data[:2], "big")
            if kind == 10 and data == asked:
                return 0
    raise Failed(f"it is neither ended nor answered in {PATIENCE} s")


def attack_by_frames(server, attack):
    sock, got = upgrade(server, server.own_cookie)
    with sock:
        expect(b" 101 " in got, f"no WebSocket: {got[:200]}")
        asked = os.urandom(8)
        send(sock, frame(json.dumps({"type": "hello", "width": 16, "height": 16}).encode()) + attack.bytes +
             frame(asked, opcode=9))
        code = farewell(sock, asked)
    expect(code in attack.expects, f"it ends by {code} (0: not at all), not by one of {attack.expects}")


class Asker:
    """A page that goes on from one attack to the next: an address may say hello only so often."""

    def __init__(self, server):
        self.sock, got = upgrade(server, server.own_cookie)
        expect(b" 101 " in got, f"no WebSocket: {got[:200]}")
        self.box, self.ids, self.open = b"", 0, {}
        send(self.sock, frame(json.dumps({"type": "hello", "width": 16, "height": 16}).encode()))

    def say(self, kind, more, done):
        self.ids += 1
        self.open[self.ids] = done
        send(self.sock, frame(json.dumps({"type": kind, "id": self.ids, **more}).encode()))

    def check(self, data):
        """A text of the server."""
        try:
            said = json.loads(data)
        except ValueError:
            raise Failed(f"no JSON: {data[:300]}") from None
        expect(b"/proc/self/fd" not in data, f"a place of the program's own: {data[:300]}")
        if said["type"] != "answer":
            return
        expect(said["id"] in self.open, f"answered twice, or not asked: {data[:300]}")
        done = self.open.pop(said["id"])
        expect(done in (None, said["ok"]), f"{'done' if said['ok'] else 'refused'}: {data[:300]}")
        expect(said["ok"] or (said["error"] and "\n" not in said["error"] and len(said["error"]) < 2000), f"no sentence: {data[:300]}")

    def until_answered(self):
        end = time.monotonic() + PATIENCE
        while self.open:
            self.sock.settimeout(max(end - time.monotonic(), 0.001))
            try:
                piece = self.sock.recv(65536)
            except socket.timeout:
                raise Failed(f"no answer in {PATIENCE} s") from None
            expect(piece, "ended without a farewell")
            self.box += piece
            while (found := parse(self.box)) is not None:
                kind, data, self.box = found
                expect(kind != 8, f"ended: {data[:200]}")
                if kind == 1:
                    self.check(data)
                if kind == 2:
                    send(self.sock, frame(json.dumps({"type": "ack", "frame": int.from_bytes(data[8:12], "little")}).encode()))


def attack_by_asking(server, attack):
    asker, server.asker = server.asker or Asker(server), None
    for kind, more, done in attack.messages:
        asker.say(kind, more, done)
        if not attack.together:
            asker.until_answered()
    if attack.leaves:
        return asker.sock.close()
    asker.until_answered()
    server.asker = asker
    return None


def serves(server):
    """Somebody else's page comes, and at once."""
    began = time.monotonic()
    with connect(server) as sock:
        sock.sendall(head(server, "GET /icon.svg HTTP/1.1"))
        got = until_end(sock, PATIENCE)
    expect(codes(got) == [200] or b"without its page" in got or codes(got) == [404], f"the page does not come: {got[:200]}")
    took = time.monotonic() - began
    expect(took < PATIENCE / 2, f"the page takes {took:.1f} s")


def make(server, attack):
    {Attack: attack_by_bytes, Frames: attack_by_frames, Asks: attack_by_asking}[type(attack)](server, attack)
    expect(server.process.poll() is None, "the server has ended")
    serves(server)


def short(data):
    """For names of attacks."""
    text = data.decode("latin-1") if isinstance(data, bytes) else str(data)
    text = re.sub(r"[^ -~]", lambda c: f"<{ord(c[0]):02x}>", text)
    return text if len(text) < 60 else f"{text[:50]}... ({len(text)})"
