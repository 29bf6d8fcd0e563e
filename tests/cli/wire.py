"""HTTP and WebSockets by hand, for tests of what no page would send."""
import base64
from contextlib import contextmanager
import json
import os
import socket
import struct
import time

from harness import write_ball
from page import Page, Server, run


@contextmanager
def attacked(*words, verb="view"):
    """A server that must be as good as ever afterwards: the page comes, and a World can be edited and seen."""
    write_ball("ball.nrrd", 16)
    with Server("ball.nrrd", *words, verb=verb) as server:
        yield server
        assert server.process.poll() is None, "the server has ended"
        run(behaves(server))


async def behaves(server):
    assert server.request("/")[0] == 200
    async with Page(server, 64, 64) as page:
        await page.resting()
        title = f"alive {time.monotonic()}"
        await page.edit(("set", "title", title))
        await page.until(lambda: page.world["world"].get("title") == title)


def connect(server):
    return socket.create_connection(("127.0.0.1", server.port), timeout=30)


def answer(server, bytes_):
    """What comes back for these bytes until the other side closes or is silent for a while."""
    got = b""
    with connect(server) as sock:
        try:
            sock.settimeout(1)
            sock.sendall(bytes_)
            while piece := sock.recv(65536):
                got += piece
        except OSError:
            pass
    return got


def quick(server, bytes_):
    """The first answer alone."""
    with connect(server) as sock:
        sock.settimeout(10)
        try:
            sock.sendall(bytes_)
            return sock.recv(65536)
        except OSError:
            return b""


def head(server, first, *more, cookie=None):
    lines = [first, f"Host: localhost:{server.port}", *([f"Cookie: {cookie}"] if cookie else []), *more]
    return ("\r\n".join(lines) + "\r\n\r\n").encode("latin-1")


def codes(got):
    """Codes of all answers in what came back."""
    return [int(part.split(b" ", 2)[0]) for part in got.split(b"HTTP/1.1 ")[1:]]


def one_answer(sock):
    """The next answer, whole."""
    got = b""
    while b"\r\n\r\n" not in got and (piece := sock.recv(1)):
        got += piece
    lengths = [line.split(b":")[1] for line in got.lower().split(b"\r\n") if line.startswith(b"content-length:")]
    left = int(lengths[0]) if lengths else 0
    while left > 0 and (piece := sock.recv(left)):
        left -= len(piece)
    return got


def ends(sock, seconds=60):
    """Whether the other side ends the connection."""
    sock.settimeout(seconds)
    try:
        while sock.recv(65536):
            pass
        return True
    except socket.timeout:
        return False
    except OSError:
        return True


# WebSockets by hand -------------------------------------------------------------------------------------------------

def frame(payload, opcode=1, final=True, masked=True, length=None, reserved=0):
    n = len(payload) if length is None else length
    first = (0x80 if final else 0) | reserved << 4 | opcode
    mask = 0x80 if masked else 0
    size = bytes([mask | n]) if n < 126 else bytes([mask | 126]) + struct.pack(">H", n) if n < 65536 else \
        bytes([mask | 127]) + struct.pack(">Q", n)
    key = b"\x01\x02\x03\x04" if masked else b""
    body = bytes(c ^ key[i % 4] for i, c in enumerate(payload)) if masked and len(payload) < 100000 else payload
    return bytes([first]) + size + key + body


def upgrade(server, cookie, protocol="volvis", sock=None, path="/ws", **more):
    """A socket after the handshake, and what the server said."""
    sock = sock or connect(server)
    named = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13", "Origin": server.base,
             "Sec-WebSocket-Key": base64.b64encode(os.urandom(16)).decode(), **more}
    if protocol:
        named["Sec-WebSocket-Protocol"] = protocol
    sock.sendall(head(server, f"GET {path} HTTP/1.1", *(f"{k}: {v}" for k, v in named.items()), cookie=cookie))
    got = b""
    try:
        while b"\r\n\r\n" not in got and (piece := sock.recv(1)):
            got += piece
    except OSError:
        pass
    return sock, got


def hello(width=64, height=64):
    return frame(json.dumps({"type": "hello", "width": width, "height": height}).encode())


def resident_kib(server):
    with open(f"/proc/{server.process.pid}/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))
