"""PNG files without a library, so that the comparison does not rest on the code that it tests."""
import struct
import zlib

import numpy as np

CHANNELS = {0: 1, 2: 3, 4: 2, 6: 4}


def chunks(data):
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError("no PNG signature")
    at = 8
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        (crc,) = struct.unpack(">I", data[at + 8 + length : at + 12 + length])
        if zlib.crc32(kind + body) != crc:
            raise ValueError(f"chunk {kind.decode()}: wrong checksum")
        yield kind, body
        at += length + 12


def bare(data):
    """The same picture without its texts: they name the folder it was made in."""
    kept = [(kind, body) for kind, body in chunks(data) if kind in (b"IHDR", b"IDAT", b"IEND", b"sRGB", b"gAMA")]
    packed = (struct.pack(">I", len(b)) + k + b + struct.pack(">I", zlib.crc32(k + b)) for k, b in kept)
    return data[:8] + b"".join(packed)


def undo_average(line, above, step):
    for channel in range(step):
        left = 0
        for i in range(channel, len(line), step):
            line[i] = left = line[i] + (left + above[i]) // 2 & 255


def undo_paeth(line, above, step):
    """The guess is what is nearest to left + over - corner. Most of the time of reading a picture goes by here."""
    for channel in range(step):
        left = corner = 0
        for i in range(channel, len(line), step):
            over = above[i]
            to_left, to_over = over - corner, left - corner
            to_corner = abs(to_left + to_over)
            to_left, to_over = abs(to_left), abs(to_over)
            guess = left if to_left <= to_over and to_left <= to_corner else over if to_over <= to_corner else corner
            line[i] = left = line[i] + guess & 255
            corner = over


def unfilter(kind, line, above, step):
    """One scan line, bytes; `step` bytes a pixel."""
    if kind == 1:
        columns = np.frombuffer(line, np.uint8).reshape(-1, step)
        return columns.cumsum(axis=0, dtype=np.uint8).tobytes()
    if kind == 2:
        return (np.frombuffer(line, np.uint8) + np.frombuffer(above, np.uint8)).tobytes()
    if kind == 3:
        undo_average(line, above, step)
    elif kind == 4:
        undo_paeth(line, above, step)
    elif kind:
        raise ValueError(f"filter {kind}: expected 0 to 4")
    return bytes(line)


def read(path):
    """(height, width, 4) floats 0..1 as they are stored (sRGB, alpha straight) and the texts, by key."""
    with open(path, "rb") as file:
        parts = list(chunks(file.read()))
    width, height, depth, color, _, _, interlace = struct.unpack(">IIBBBBB", parts[0][1])
    if depth not in (8, 16) or color not in CHANNELS or interlace:
        raise ValueError(f"{path}: expected 8 or 16 bits, not interlaced, without a palette")
    packed = zlib.decompress(b"".join(body for kind, body in parts if kind == b"IDAT"))
    step = CHANNELS[color] * depth // 8
    above, rows = bytes(width * step), []
    for y in range(height):
        start = y * (width * step + 1)
        above = unfilter(packed[start], bytearray(packed[start + 1 : start + 1 + width * step]), above, step)
        rows.append(above)
    samples = np.frombuffer(b"".join(rows), ">u2" if depth == 16 else np.uint8).astype(np.float64) / (2**depth - 1)
    samples = samples.reshape(height, width, CHANNELS[color])
    if color in (0, 4):
        samples = np.concatenate([samples[:, :, :1]] * 3 + [samples[:, :, 1:]], axis=2)
    if samples.shape[2] == 3:
        samples = np.concatenate([samples, np.ones((height, width, 1))], axis=2)
    texts = dict(body.split(b"\0", 1) for kind, body in parts if kind == b"tEXt")
    return samples, {key.decode("latin-1"): value.decode("latin-1") for key, value in texts.items()}


def write(path, rgb):
    """(height, width, 3) floats 0..1 as they are to be stored, 8 bits."""
    data = np.clip(np.rint(rgb * 255), 0, 255).astype(np.uint8)
    height, width, _ = data.shape
    raw = b"".join(b"\0" + row.tobytes() for row in data)

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)))
        file.write(chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b""))


def linear(stored):
    """Light, premultiplied by alpha, of stored samples."""
    color = stored[:, :, :3]
    light = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
    return np.concatenate([light * stored[:, :, 3:], stored[:, :, 3:]], axis=2)
