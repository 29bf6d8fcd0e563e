"""What a hostile neighbour does to a server while others look: each begins with the server, and gives back what ends it."""
import itertools
import json
import math
import multiprocessing
import os
import select
import socket
import threading
import time
import urllib.error
import urllib.request

from pages import message


def _repeat(work):
    """In a thread, until it is ended."""
    stop = threading.Event()

    def run():
        while not stop.is_set():
            try:
                work()
            except OSError:
                stop.wait(0.01)
    thread = threading.Thread(target=run)
    thread.start()

    def end():
        stop.set()
        thread.join()
    return end


def slow_heads(server, _):
    """A thousand connections that give a byte of a head now and then, and come again when they are thrown out."""
    sockets = []

    def work():
        while len(sockets) < 1000:
            sock = socket.create_connection(("127.0.0.1", server.port))
            sock.sendall(b"GET / HTTP/1.1\r\nHost: loc")
            sockets.append(sock)
        time.sleep(0.2)
        for sock in list(sockets):
            try:
                sock.sendall(b"a")
            except OSError:
                sock.close()
                sockets.remove(sock)
    stop = _repeat(work)

    def end():
        stop()
        for sock in sockets:
            sock.close()
    return end


class Flooder:
    """A WebSocket that says hello and then sends the same bytes for ever, as fast as they are taken, and reads what comes."""

    def __init__(self, server, size=(64, 64)):
        self.sock = socket.create_connection(("127.0.0.1", server.port))
        lines = ("GET /ws HTTP/1.1", f"Host: localhost:{server.port}", "Upgrade: websocket", "Connection: Upgrade",
                 "Sec-WebSocket-Version: 13", f"Origin: {server.base}", "Sec-WebSocket-Protocol: volvis",
                 f"Cookie: {server.cookie}", "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==")
        self.sock.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        self.sock.sendall(message(json.dumps({"type": "hello", "width": size[0], "height": size[1]})))
        self.sock.setblocking(False)
        self.left, self.box, self.sent = b"", bytearray(), 0

    def take(self):
        """Frames are acknowledged: else none would follow."""
        self.box += self.sock.recv(1 << 18) or _gone()
        acks = b""
        while len(self.box) >= 2:
            n, head = self.box[1] & 127, 2
            if n > 125:
                head = 4 if n == 126 else 10
                n = int.from_bytes(self.box[2:head], "big")
            if len(self.box) < head + n:
                break
            if self.box[0] & 15 == 2:
                acks += message(f'{{"type":"ack","frame":{int.from_bytes(self.box[head + 8:head + 12], "little")}}}')
            del self.box[:head + n]
        return acks

    def step(self, data, seconds):
        wants = [self.sock] if self.left or data else []
        readable, writable, _ = select.select([self.sock], wants, [], seconds)
        acks = self.take() if readable else b""
        if writable and not self.left:
            self.left = data
        if acks and not self.left:
            self.left = acks  # between two messages of the flood
        if self.left:
            try:
                n = self.sock.send(self.left)
            except BlockingIOError:
                n = 0
            self.left, self.sent = self.left[n:], self.sent + n


def _gone():
    raise ConnectionError("ended by the server")


def _apart(work, n=1):
    """In processes of their own, again and again, until they are ended."""
    def run():
        os.nice(5)
        while True:
            try:
                work()
            except OSError:
                time.sleep(0.05)
    children = [multiprocessing.get_context("fork").Process(target=run, daemon=True) for _ in range(n)]
    for child in children:
        child.start()

    def end():
        for child in children:
            child.kill()
            child.join()
    return end


def _flood(server, data, size=(64, 64), n=1, pause=0):
    def work():
        flooder = Flooder(server, size)
        while True:
            flooder.step(data, 1)
            if pause:
                time.sleep(pause)
    return _apart(work, n)


def _edit(value):
    return message(f'{{"type": "edit", "id": 1, "edits": [{{"op": "set", "path": "volumes.nobody.name", "value": {value}}}]}}')


def small_messages(server, _):
    """Two pages that ask what is quickly answered, without end."""
    return _flood(server, message('{"type": "cancel", "id": 1, "job": -1}') * 100, n=2)


def pings(server, _):
    return _flood(server, b"\x89\x84\0\0\0\0ping" * 1000)


def long_messages(server, _):
    """Edits of 900 kB that are refused when all of them is read."""
    return _flood(server, _edit("[" + ",".join(["[1, 2.5]"] * 100000) + "]"))


def long_flawed_messages(server, _):
    """The same with a number that no computer has at their end, by two."""
    return _flood(server, _edit("[" + "1.5," * 220000 + "1e400]"), n=2)


def long_events(server, _):
    return _flood(server, message(json.dumps({"type": "events", "lines": "0 mouse axis x 0.3\n" * 40000})))


def titles(server, _):
    """A page that sets another title of 4 kB as often as it may."""
    return _flood(server, b"".join(message(json.dumps({"type": "edit", "id": i + 1, "gesture": "g", "edits": [
        {"op": "set", "path": "title", "value": f"{i}" + "x" * 4000}]})) for i in range(20)))


def previews(server, _):
    """Four pages that ask for previews of slow filters, each with another parameter, without waiting for any."""
    return _flood(server, b"".join(message(json.dumps({"type": "preview", "id": i + 1, "operation": operation, "dataset": "ball-0", "whole": True,
                                                       "parameters": {name: f"{1 + i / 10}vox"}}))
                                   for i, (operation, name) in enumerate((("denoise", "search"), ("bilateral", "sigma"), ("vesselness", "sigma")) * 4)),
                  (512, 512), n=4)


def sizes(server, _):
    """A page whose window changes its size all the time, between nothing and 8192 x 8192."""
    return _flood(server, b"".join(message(f'{{"type": "size", "width": {w}, "height": {h}}}') for w, h in
                                   ((8192, 8192), (1, 1), (64, 8192), (1000, 1000), (8191, 8190))), pause=0.002)


def turning(server, _):
    """One that turns a picture of 8192 x 8192: no attack, but what it may cost."""
    def work():
        flooder = Flooder(server, (8192, 8192))
        flooder.step(message(json.dumps({"type": "events", "lines": "0 mouse axis x 0\n0 mouse axis y 0\n0 mouse button left down\n"})), 1)
        for i in itertools.count():
            flooder.step(message(json.dumps({"type": "events", "lines": f"{i * 50000000} mouse axis x {0.3 * math.sin(i):.3f}\n"})), 0.05)
            time.sleep(0.05)
    return _apart(work)


def trickling_uploads(server, _):
    """Fifty files that come byte by byte."""
    def work():
        sockets = []
        for i in range(50):
            sock = socket.create_connection(("127.0.0.1", server.port))
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            sock.sendall(f"PUT /files/trickle-{i} HTTP/1.1\r\nHost: localhost:{server.port}\r\nCookie: {server.cookie}\r\n"
                         f"Content-Length: 1000000\r\n\r\n".encode())
            sock.setblocking(False)
            sockets.append(sock)
        while sockets:
            for sock in list(sockets):
                try:
                    sock.send(b"x")
                except BlockingIOError:
                    pass
                except OSError:
                    sockets.remove(sock)
            time.sleep(0.002)
    return _apart(work)


def coming_and_going(server, _):
    """Pages that say hello and leave, one after the other."""
    def work():
        flooder = Flooder(server, (512, 512))
        flooder.step(b"", 1)
        flooder.sock.close()
    return _apart(work, 2)


def silent_ones(server, _):
    """A thousand upgrades that never say hello, again and again."""
    def work():
        sockets = []
        for _ in range(1000):
            sock = socket.create_connection(("127.0.0.1", server.port))
            sock.sendall((f"GET /ws HTTP/1.1\r\nHost: localhost:{server.port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                          f"Sec-WebSocket-Version: 13\r\nOrigin: {server.base}\r\nSec-WebSocket-Protocol: volvis\r\n"
                          f"Cookie: {server.cookie}\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n").encode())
            sockets.append(sock)
            time.sleep(0.005)
        for sock in sockets:
            sock.close()
    return _apart(work)


def refused_requests(server, _):
    """Requests under a foreign name, with wrong tokens and to wrong places, one after the other."""
    def work():
        for path, data, host in (("/", None, "evil.example"), ("/session", b'{"token": "x"}', f"localhost:{server.port}"),
                                 ("/../../etc/passwd", None, f"localhost:{server.port}")):
            request = urllib.request.Request(f"http://127.0.0.1:{server.port}{path}", data=data, headers={"Host": host})
            try:
                urllib.request.urlopen(request, timeout=5).close()
            except urllib.error.HTTPError as error:
                error.close()
    return _apart(work)  # not a thread of the pages that are counted


attacks = {"1000 slow heads": slow_heads, "small messages": small_messages, "pings": pings, "long messages": long_messages,
           "long flawed messages": long_flawed_messages, "long events": long_events, "titles": titles, "previews": previews, "sizes": sizes,
           "one turns 8192 x 8192": turning, "uploads that trickle": trickling_uploads, "coming and going": coming_and_going,
           "upgrades without hello": silent_ones, "refused requests": refused_requests}
