"""Who says nothing, or takes for ever: begun before all other attacks, and ended by the server within half a minute."""
import json
import os
import socket
import threading
import time

from attack import send
from harness import sanitized
from wire import connect, ends, frame, head, hello, parse, upgrade

SECONDS = 45  # half a minute, and what the machine has to do besides: so many times that as it has more to do than it can
ASKING = 39


def silent(server):
    return connect(server), None


def half_a_head(server):
    sock = connect(server)
    send(sock, b"GET / HTTP/1.1\r\nHost: loc")
    return sock, None


def head_by_bytes(server):
    return connect(server), iter(head(server, "GET / HTTP/1.1", "X: " + "y" * 1000))


def token_by_bytes(server):
    sock = connect(server)
    send(sock, head(server, "POST /session HTTP/1.1", "Content-Length: 4000"))
    return sock, iter(b"x" * 4000)


def upload_that_does_not_come(server):
    sock = connect(server)
    send(sock, head(server, "PUT /files/promised HTTP/1.1", "Content-Length: 1000000", cookie=server.own_cookie))
    return sock, None


def upload_by_bytes(server):
    sock = connect(server)
    send(sock, head(server, "PUT /files/trickle HTTP/1.1", "Content-Length: 1000000", cookie=server.own_cookie))
    return sock, iter(b"x" * 4000)


def upload_that_trickles(server):
    """Seven kB a second."""
    sock = connect(server)
    send(sock, head(server, "PUT /files/trickle HTTP/1.1", "Content-Length: 1000000", cookie=server.own_cookie))
    return sock, iter([b"x" * 7000] * 140)


def answer_unread(server):
    """What it sends besides is passed over."""
    sock = socket.socket()
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
    sock.connect(("127.0.0.1", server.port))
    send(sock, head(server, "GET /app.js HTTP/1.1"))
    return sock, b"\r"


def no_hello(server):
    return upgrade(server, server.own_cookie)[0], None


def no_hello_but_pings(server):
    return upgrade(server, server.own_cookie)[0], iter([frame(b"", opcode=9)] * 1000)


def pings_when_answered(server):
    """Each time it is held up by what its address may cost, it waits anew."""
    sock, _ = upgrade(server, server.own_cookie)

    def ping():
        try:
            send(sock, frame(b"", opcode=9))
            while sock.recv(65536):
                sock.sendall(frame(b"", opcode=9) * 50)
        except OSError:
            pass
    threading.Thread(target=ping, daemon=True).start()
    return sock, b""


def half_a_message(server):
    sock, _ = upgrade(server, server.own_cookie)
    send(sock, frame(b"{", final=False))
    return sock, iter([frame(b" ", opcode=0, final=False)] * 1000)


def reads_nothing(server):
    """It says that it is there, too."""
    sock = socket.socket()
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
    sock.connect(("127.0.0.1", server.port))
    upgrade(server, server.own_cookie, sock=sock)
    ask = frame(json.dumps({"type": "describe", "id": 1}).encode())
    send(sock, hello(1000, 1000) + ask * 500)
    return sock, frame(b"", opcode=10)


def floods_for_ever(server):
    """More than the server takes, whenever the system takes it. It reads, so that it is nothing but too much."""
    sock, _ = upgrade(server, server.own_cookie)
    send(sock, hello(16, 16))
    many = frame(json.dumps({"type": "cancel", "id": 1, "job": -1}).encode()) * 1000

    def flood():
        try:
            while True:
                sock.sendall(many)
        except OSError:
            pass

    def read():
        try:
            while sock.recv(1 << 16):
                pass
        except OSError:
            pass
    for work in (flood, read):
        threading.Thread(target=work, daemon=True).start()
    return sock, b""


# Letters of a question. With sanitizers each costs several times as much: then they would be most of what the address may cost,
# and who floods it would be held up by them, and not by what it sends.
LONG = 10000 if sanitized() else 60000


class Asker:
    """No attack: it asks long questions, each when the one before was answered, for as long as the others are patient."""

    def __init__(self, server):
        self.sock, _ = upgrade(server, server.own_cookie)
        self.answers, self.ended = 0, None
        send(self.sock, hello(16, 16))
        send(self.sock, frame(json.dumps({"type": "frames", "wanted": "none"}).encode()))
        threading.Thread(target=self.ask, daemon=True).start()

    def ask(self):
        box = b""
        try:
            while True:
                edit = {"op": "set", "path": "datasets.ball.parameters", "value": {"text": f"{self.answers}" + "x" * LONG}}
                send(self.sock, frame(json.dumps({"type": "edit", "id": self.answers + 1, "edits": [edit]}).encode()))
                answered = False
                while not answered:
                    found = parse(box)
                    if found is None:
                        piece = self.sock.recv(1 << 16)
                        if not piece:
                            raise OSError("it was ended")
                        box += piece
                        continue
                    kind, data, box = found
                    if kind == 8:
                        raise OSError(data[2:].decode())
                    if kind == 2:  # made before it was heard that none is wanted
                        send(self.sock, frame(json.dumps({"type": "ack", "frame": int.from_bytes(data[8:12], "little")}).encode()))
                    answered = kind == 1 and b'"answer"' in data[:60]
                self.answers += 1
        except OSError as error:
            self.ended = str(error)

    def failures(self, left):
        time.sleep(max(0, left))
        told = [f"who asks and waits was ended after {self.answers} answers: {self.ended}"] if self.ended else []
        self.sock.close()
        return told


PATIENT = (silent, half_a_head, head_by_bytes, token_by_bytes, *[upload_that_does_not_come] * 4, upload_by_bytes,
           upload_that_trickles, answer_unread, no_hello,
           no_hello_but_pings, *[pings_when_answered] * 5, half_a_message, reads_nothing, floods_for_ever)


class Patient:
    """They wait beside the other attacks."""

    def __init__(self, server):
        self.server, self.began = server, time.monotonic()
        self.asker = Asker(server)
        self.all = [(attack.__name__.replace("_", " "), *attack(server)) for attack in PATIENT]
        self.stop = threading.Event()
        self.thread = threading.Thread(target=self.trickle)
        self.thread.start()

    def trickle(self):
        while not self.stop.wait(1):
            for _, sock, more in self.all:
                piece = next(more, None) if more and not isinstance(more, bytes) else None
                if piece is not None:
                    send(sock, bytes([piece]) if isinstance(piece, int) else piece)

    def is_ended(self, sock, more):
        """Whether the server has ended it."""
        if not isinstance(more, bytes):
            return ends(sock, max(0.01, self.left()))
        while self.left() > 0 and not closed_by_peer(sock):  # what is unread stands before its end: so it is asked for
            send(sock, more)
            time.sleep(0.1)
        return closed_by_peer(sock)

    def seconds(self):
        return SECONDS * max(1, os.getloadavg()[0] / os.cpu_count())

    def left(self):
        return self.began + self.seconds() - time.monotonic()

    def check(self):
        """Sentences of those that were not ended."""
        failures = [f"{name}: not ended within {self.seconds():.0f} s" for name, sock, more in self.all if not self.is_ended(sock, more)]
        self.stop.set()
        self.thread.join()
        for _, sock, _ in self.all:
            sock.close()
        return failures + self.asker.failures(self.began + ASKING - time.monotonic()) + self.given_back()

    def given_back(self):
        """Room for uploads that was promised to those who did not bring them is there for others, and takes what it was told."""
        for i in range(4):
            code, _, body = self.server.request(f"/files/taken-{i}", b"x" * 900000, method="PUT", Cookie=self.server.own_cookie)
            if code != 201:
                return [f"upload {i} after broken ones: {code} {body}"]
        return []


def closed_by_peer(sock):
    """In the words of the kernel: TCP_INFO's first byte is the state; 1: established."""
    return sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 1)[0] != 1
