"""A small reader of OpenEXR, from the description of the file layout: the tests' oracle. Scan lines, no compression or
ZIP. https://openexr.com/en/latest/OpenEXRFileLayout.html
"""
import struct
import zlib
import numpy


def text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def channels_of(data):
    """Name and type, in file order."""
    found, at = [], 0
    while data[at]:
        name, at = text(data, at)
        kind, _linear, x, y = struct.unpack_from("<iIii", data, at)
        assert x == 1 and y == 1
        found.append((name, [numpy.uint32, numpy.float16, numpy.float32][kind]))
        at += 16
    return found


def unzip(block, size):
    if len(block) == size:
        return block
    coded = numpy.frombuffer(zlib.decompress(block), numpy.uint8).astype(numpy.int64)
    assert len(coded) == size
    coded[1:] -= 128
    plain = (numpy.cumsum(coded) & 255).astype(numpy.uint8)
    out = numpy.empty(size, numpy.uint8)
    half = (size + 1) // 2
    out[0::2], out[1::2] = plain[:half], plain[half:]
    return out.tobytes()


def read(path):
    """Attributes (type, bytes) by name, and one array a channel."""
    with open(path, "rb") as file:
        data = file.read()
    magic, version = struct.unpack_from("<II", data, 0)
    assert magic == 20000630 and version & 0xff == 2 and version & ~0x4ff == 0
    attributes, at = {}, 8
    while data[at]:
        name, at = text(data, at)
        kind, at = text(data, at)
        (n,) = struct.unpack_from("<i", data, at)
        attributes[name] = (kind, data[at + 4 : at + 4 + n])
        at += 4 + n
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"][1])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    rows = {0: 1, 2: 1, 3: 16}[attributes["compression"][1][0]]
    channels = channels_of(attributes["channels"][1])
    line = sum(numpy.dtype(kind).itemsize for _, kind in channels) * width
    planes = {name: numpy.empty((height, width), kind) for name, kind in channels}
    offsets = struct.unpack_from(f"<{(height + rows - 1) // rows}Q", data, at + 1)
    for offset in offsets:
        y, n = struct.unpack_from("<ii", data, offset)
        block = unzip(data[offset + 8 : offset + 8 + n], line * min(rows, y1 + 1 - y))
        put = 0
        for row in range(y - y0, min(y - y0 + rows, height)):
            for name, kind in channels:
                planes[name][row] = numpy.frombuffer(block, numpy.dtype(kind).newbyteorder("<"), width, put)
                put += numpy.dtype(kind).itemsize * width
    return attributes, planes
