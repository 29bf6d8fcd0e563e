"""HTTP and WebSockets by hand, for tests of what no page would send."""
import base64
from contextlib import contextmanager
import json
import os
import socket
import struct
import time

from harness import write_ball
from served import Server


@contextmanager
def attacked(*words, verb="view"):
    """A server that must be as good as ever afterwards: the page comes, and a World can be edited and seen."""
    from page import run
    write_ball("ball.nrrd", 16)
    with Server("ball.nrrd", *words, verb=verb) as server:
        yield server
        assert server.process.poll() is None, "the server has ended"
        run(behaves(server))


async def behaves(server):
    from page import Page
    assert server.request("/")[0] == 200
    async with Page(server, 64, 64) as page:
        await page.resting()
        title = f"alive {time.monotonic()}"
        await page.edit(("set", "title", title))
        await page.until(lambda: page.world["world"].get("title") == title)


def connect(server):
    return socket.create_connection(("127.0.0.1", server.port), timeout=60)


def rounds(server, n=3):
    """The server has gone round its loop so often: what came to it before has been looked at."""
    for _ in range(n):
        with connect(server) as sock:
            sock.sendall(head(server, "GET /nothing HTTP/1.1"))
            assert codes(one_answer(sock)) == [404], "the server does not answer others"


def untaken(server, port):
    """Bytes from this port of ours that the server has not read yet; 0: none, or the connection is gone."""
    with open("/proc/net/tcp", encoding="ascii") as file:
        rows = [line.split() for line in file][1:]
    ends = f":{server.port:04X}", f":{port:04X}"
    return sum(int(row[4].split(":")[1], 16) for row in rows if (row[1][8:], row[2][8:]) == ends)


def wait_for(what, told, seconds=60):
    """Until what() is true: an event that nobody tells us of. What it says; an AssertionError tells what did not come."""
    end = time.monotonic() + seconds
    while not (found := what()):
        assert time.monotonic() < end, f"{told}: waited for {seconds} s in vain"
        time.sleep(0.01)
    return found


def all_of(sock, got=b""):
    """What has come, and whether the other side has ended the connection."""
    sock.setblocking(False)
    try:
        while piece := sock.recv(65536):
            got += piece
        return got, True
    except BlockingIOError:
        return got, False
    except OSError:
        return got, True


def answer(server, bytes_):
    """All that comes back for these bytes: until the other side closes, or has read them, went round and says no more."""
    got, before, closed = b"", -1, False
    with connect(server) as sock:
        try:
            sock.sendall(bytes_)
        except OSError:
            pass
        port = sock.getsockname()[1]
        while not closed and len(got) > before:
            before = len(got)
            wait_for(lambda: not untaken(server, port), "the server reads all of a request")
            rounds(server)
            got, closed = all_of(sock, got)
    return got


def quick(server, bytes_):
    """The first answer alone, whole; nothing where the server just closes."""
    with connect(server) as sock:
        try:
            sock.sendall(bytes_)
        except OSError:
            pass
        return one_answer(sock, body=not bytes_.startswith(b"HEAD "))


def head(server, first, *more, cookie=None):
    lines = [first, f"Host: localhost:{server.port}", *([f"Cookie: {cookie}"] if cookie else []), *more]
    return ("\r\n".join(lines) + "\r\n\r\n").encode("latin-1")


def codes(got):
    """Codes of all answers in what came back."""
    return [int(part.split(b" ", 2)[0]) for part in got.split(b"HTTP/1.1 ")[1:]]


def one_answer(sock, body=True, seconds=60):
    """The next answer, whole, or what came of it until the other side closed; TimeoutError: neither."""
    got, left = b"", 1
    sock.settimeout(seconds)
    try:
        while b"\r\n\r\n" not in got and (piece := sock.recv(1)):
            got += piece
        lengths = [line.split(b":")[1] for line in got.lower().split(b"\r\n") if line.startswith(b"content-length:")]
        left = int(lengths[0]) if lengths and body else 0
        while left > 0 and (piece := sock.recv(left)):
            got += piece
            left -= len(piece)
    except socket.timeout:
        raise AssertionError(f"neither an answer nor an end of the connection in {seconds} s: {got[:200]}")
    except OSError:
        pass
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


def parse(box):
    """Opcode and payload of the first message of the server, and what is behind it; None: it is not whole."""
    parts, start, last = [], 0, False
    while not last:
        if len(box) < start + 2:
            return None
        n, at = box[start + 1] & 127, start + 2
        if n > 125:
            at += 2 if n == 126 else 8
            n = int.from_bytes(box[start + 2:at], "big")
        if len(box) < at + n:
            return None
        parts.append(box[at:at + n])
        last, start = box[start] & 128, at + n
    return box[0] & 15, b"".join(parts), box[start:]


def closes(sock, seconds=60):
    """Whether the other side ends the WebSocket; it waits some seconds for our part of the farewell, if that does not come."""
    box, end, told = b"", time.monotonic() + seconds, False
    try:
        while (left := end - time.monotonic()) > 0:
            sock.settimeout(left)
            if not (piece := sock.recv(65536)):
                return True
            box += piece
            while not told and (found := parse(box)) is not None:
                code, _, box = found
                if code == 8:
                    sock.sendall(frame(b"", opcode=8))
                    sock.shutdown(socket.SHUT_WR)  # where it takes our farewell for more of a message
                    told = True
    except socket.timeout:
        pass
    except OSError:
        return True
    return False


def pong(sock, seconds=60):
    """What the next pong echoes; an AssertionError: it does not come."""
    box, end = b"", time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        sock.settimeout(left)
        piece = sock.recv(65536)
        assert piece, "the server has ended the connection"
        box += piece
        while (found := parse(box)) is not None:
            code, data, box = found
            if code == 10:
                return data
    raise AssertionError(f"no pong in {seconds} s")


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
