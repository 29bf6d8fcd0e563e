"""Attacks on a WebSocket that was let in: frames, texts and messages that no page sends."""
import json
import struct

from attack import Frames, short
from wire import frame

PROTOCOL, KIND, NO_TEXT, POLICY, TOO_LARGE = (1002,), (1003,), (1007,), (1008,), (1009,)
GOES_ON = (0,)


def text(value):
    return frame(value if isinstance(value, bytes) else value.encode())


def kinds(server):
    for kind in (3, 4, 5, 6, 7, 11, 12, 13, 14, 15):
        for final in (True, False):
            yield Frames(f"kind {kind}{'' if final else ', to go on'}", frame(b"x", opcode=kind, final=final), PROTOCOL)
    for bits in range(1, 8):
        for kind in (1, 2, 9):
            yield Frames(f"bits {bits} of kind {kind}", frame(b"{}", opcode=kind, reserved=bits), PROTOCOL)
    for kind in (0, 1, 8, 9, 10):
        for data in (b"", b"{}"):
            yield Frames(f"kind {kind} of {len(data)} bytes, not masked", frame(data, opcode=kind, masked=False), PROTOCOL)
    for data in (b"", b"\0" * 100, b"x" * 70000):
        yield Frames(f"binary, {len(data)} bytes", frame(data, opcode=2), KIND)
        yield Frames(f"binary in pieces, {len(data)} bytes", frame(data, opcode=2, final=False), KIND)


def long_form(kind, n, form):
    """A frame whose length is written in 2 or 8 bytes, whatever it is."""
    return bytes([0x80 | kind, 0x80 | (126 if form == 2 else 127)]) + (struct.pack(">H", n) if form == 2 else struct.pack(">Q", n)) + b"\0\0\0\0"


def lengths(server):
    for n in (0, 1, 125):
        for form in (2, 8):
            yield Frames(f"{n} bytes, said in {form}", long_form(1, n, form) + b"x" * n, PROTOCOL)
    yield Frames("65535 bytes, said in 8", long_form(1, 65535, 8) + b"x" * 65535, PROTOCOL)
    for n in (1 << 63, (1 << 64) - 1, (1 << 63) + 2):
        yield Frames(f"{n} bytes", long_form(1, n, 8), PROTOCOL)
    for n in ((1 << 63) - 1, 1 << 62, 1 << 40, 1 << 32, (1 << 20) + 1):
        yield Frames(f"{n} bytes", long_form(1, n, 8) + b"x" * 100, TOO_LARGE)
    for kind in (8, 9, 10):
        yield Frames(f"kind {kind} of 126 bytes", frame(b"x" * 126, opcode=kind), PROTOCOL)
        yield Frames(f"kind {kind} of 70000 bytes", frame(b"x" * 70000, opcode=kind), PROTOCOL)
        yield Frames(f"kind {kind} in pieces", frame(b"x", opcode=kind, final=False), PROTOCOL)


def pieces(server):
    yield Frames("a piece of nothing", frame(b"{}", opcode=0), PROTOCOL)
    yield Frames("a piece of nothing, to go on", frame(b"{}", opcode=0, final=False), PROTOCOL)
    yield Frames("a message within another", frame(b"{", final=False) + text("{}"), PROTOCOL)
    yield Frames("a message within another, to go on", frame(b"{", final=False) + frame(b"{", final=False), PROTOCOL)
    yield Frames("pieces without end", frame(b"", final=False) + frame(b"", opcode=0, final=False) * 5000, POLICY)
    yield Frames("pieces of more than a MiB", frame(b"[" * 60000, final=False) + frame(b"[" * 60000, opcode=0, final=False) * 20, TOO_LARGE)
    yield Frames("a piece of no message after one", text('{"type": "ack", "frame": 0}') + frame(b"", opcode=0), PROTOCOL)
    ack = b'{"type": "ack", "frame": 0}'
    yield Frames("an honest message in pieces", frame(ack[:5], final=False) + frame(ack[5:9], opcode=0, final=False) + frame(ack[9:], opcode=0), GOES_ON)
    yield Frames("an honest message with a ping within", frame(ack[:5], final=False) + frame(b"p", opcode=9) + frame(ack[5:], opcode=0), GOES_ON)
    yield Frames("honest pings and pongs", frame(b"", opcode=9) + frame(b"x" * 125, opcode=9) + frame(b"", opcode=10), GOES_ON)
    yield Frames("100 honest messages", text(ack) * 100, GOES_ON)


BROKEN = (b"\xff", b"\xc0\xaf", b"\xc1\x81", b"\x80", b"\xbf", b"\xed\xa0\x80", b"\xed\xbf\xbf", b"\xf4\x90\x80\x80", b"\xf5\x80\x80\x80", b"\xe0\x80\xaf",
          b"\xf0\x80\x80\xaf", b"\xc3", b"\xe2\x82", b"\xf0\x9f\x98", b"\xe2(\xa1", b"\xf8\x88\x80\x80\x80", b"\xfe\xfe", b"\xce\xba\xe1\xbd\xb9\xcf\x83\xed\xa0\x80")


def texts(server):
    for broken in BROKEN:
        yield Frames(f"text {short(broken)}", text(b'{"type": "' + broken + b'"}'), NO_TEXT)
        yield Frames(f"text in pieces {short(broken)}", frame(b'{"type": "' + broken[:1], final=False) + frame(broken[1:] + b'"}', opcode=0), NO_TEXT)


def farewells(server):
    for code in (0, 1, 999, 1004, 1005, 1006, 1015, 1016, 1100, 2000, 2999, 5000, 65535):
        yield Frames(f"farewell by {code}", frame(struct.pack(">H", code), opcode=8), PROTOCOL)
    yield Frames("a farewell of one byte", frame(b"\x03", opcode=8), PROTOCOL)
    for broken in BROKEN[:6]:
        yield Frames(f"farewell with {short(broken)}", frame(b"\x03\xe8" + broken, opcode=8), PROTOCOL)
    for code in (1000, 1001, 1011, 3000, 4999):
        yield Frames(f"an honest farewell by {code}", frame(struct.pack(">H", code) + b"bye", opcode=8) + text("{}"), (code,))
    yield Frames("an honest farewell by nothing", frame(b"", opcode=8), (1000,))


def floods(server):
    """They wait for their turn, and are answered; who goes on for ever is ended (patience.py)."""
    yield Frames("5000 pings", frame(b"ping", opcode=9) * 5000, GOES_ON)
    yield Frames("5000 pongs", frame(b"pong", opcode=10) * 5000, GOES_ON)
    yield Frames("5000 messages", text('{"type": "ack", "frame": 0}') * 5000, GOES_ON)


def messages(server):
    """None of them is a message: the connection ends."""
    for value in ("", "{", "}", "[]", "null", "true", "1", '"x"', "{}", '{"type": 1}', '{"type": null}', '{"type": []}', '{"type": "nothing"}', "NaN",
                  '{"type": "hello"}', '{"type": "ack"}', '{"type": "ack", "frame": "x"}', '{"type": "ack", "frame": 1.5}', '{"type": "events"}',
                  '{"type": "events", "lines": 1}', '{"type": "events", "lines": "x y"}', '{"type": "size", "width": 0, "height": 5}',
                  '{"type": "size", "width": 1e9, "height": 5}', '{"type": "size", "width": -1, "height": 5}', '{"type": "size"}',
                  '{"type": "edit", "id": 0, "edits": []}', '{"type": "edit", "id": 1}', '{"type": "edit", "id": "x", "edits": []}',
                  '{"type": "camera", "eye": 1}', '{"type": "browse", "id": 1}', '{"type": "browse"}', '{"type": "cancel", "id": 1}',
                  '{"type": "undo", "type": "redo"}', '{"type": "ack", "frame": 0,}', "{'type': 'ack', 'frame': 0}", '{"type": "ack", "frame": 0} x',
                  '{"type": "ack", "frame": 0}{"type": "ack", "frame": 0}', '\ufeff{"type": "ack", "frame": 0}',                  '{"type": "\\ud800", "frame": 0}', '{"type": "ack", "frame": 0x1}', '{"type": "ack", "frame": +1}', '{"type": "ack", "frame": Infinity}',
                  '/**/{"type": "ack", "frame": 0}', '{"type": "undo", "id": -1}', '{"type": "undo", "id": 1e3000}', "[" * 100000,
                  '{"type":' * 50000, "\0", '{"type": "ack", \0"frame": 0}', '{"type": "' + "a" * 1000000 + '"}', '{"TYPE": "undo", "id": 1}'):
        yield Frames(f"message {short(value)}", text(value), POLICY)


def questions(server):
    """Messages that are refused with a sentence, or do nothing: the connection goes on."""
    for kind, more in (("edit", {"edits": [{"op": "set", "path": "titel", "value": 1}]}), ("edit", {"edits": [{"op": "set", "path": "a" * 5000, "value": 1}]}),
                       ("edit", {"edits": [{"op": "no", "path": "title"}]}), ("edit", {"edits": [{"op": "set", "path": ".".join("a" * 500), "value": 1}]}),
                       ("open", {"path": "../x"}), ("open", {"path": "/etc/passwd"}), ("open", {"path": ""}), ("open", {"path": "/proc/self/mem"}),
                       ("open", {"path": "a" * 5000}), ("open", {"path": "x\x00y"}), ("save", {"path": "/etc/x.vv.json"}), ("save", {"path": "../x.vv.json"}),
                       ("save", {"path": "."}), ("write", {"dataset": "ball", "path": "/etc/x.nrrd"}),
                       ("write", {"dataset": "ball", "path": "../x.nrrd", "replace": True}), ("write", {"dataset": 5, "path": "x.nrrd"}), ("browse", {"path": "/"}), ("browse", {"path": "../.."}), ("browse", {"path": "a" * 5000}),
                       ("run", {"operation": "no", "dataset": "ball", "parameters": {}}), ("pick", {"x": 2, "y": -1}), ("histogram", {"volume": "no"}),
                       ("transfer", {"volume": 7}), ("info", {"dataset": "no"}), ("sample", {"name": "../x"}),
                       ("picture", {"width": 1 << 40, "height": 1, "name": "../x"}), ("undo", {}), ("redo", {}),
                       *(("world", {"since": value}) for value in (None, -1, 1.5, 1 << 62, "1", [], {})),
                       ("edit", {"edits": [{"op": "set", "path": "datasets.ball.path", "value": "/etc/shadow"}]})):
        yield Frames(f"{kind} {short(json.dumps(more))}", text(json.dumps({"type": kind, "id": 1, **more})), (0, 1008))


FAMILIES = (kinds, lengths, pieces, texts, farewells, floods, messages, questions)
