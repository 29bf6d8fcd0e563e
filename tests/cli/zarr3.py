"""A small writer and reader of Zarr 3, after the specification and nothing else: what the tests compare with."""
import gzip
import itertools
import json
import math
import os
import struct
import subprocess

import numpy

NAMES = {"?": "bool", "i1": "int8", "u1": "uint8", "i2": "int16", "u2": "uint16", "i4": "int32", "u4": "uint32",
         "i8": "int64", "u8": "uint64", "f2": "float16", "f4": "float32", "f8": "float64"}


def remainder(byte):
    """Of a byte divided by the polynomial of CRC-32C, bits turned round."""
    for _ in range(8):
        byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
    return byte


REMAINDERS = [remainder(byte) for byte in range(256)]


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ REMAINDERS[(crc ^ byte) & 255]
    return struct.pack("<I", crc ^ 0xFFFFFFFF)


def pack(codec, data):
    name, config = codec["name"], codec.get("configuration", {})
    if name == "gzip":
        return gzip.compress(data)
    if name == "crc32c":
        return data + crc32c(data)
    import numcodecs
    if name == "zstd":
        return numcodecs.Zstd(config.get("level", 1)).encode(data)
    if name == "blosc":
        shuffle = {"noshuffle": 0, "shuffle": 1, "bitshuffle": 2}[config["shuffle"]]
        kind = numpy.dtype(f"V{config['typesize']}")
        return numcodecs.Blosc(config["cname"], config["clevel"], shuffle).encode(numpy.frombuffer(data, kind))
    raise ValueError(name)


def unpack(codec, data):
    name = codec["name"]
    if name == "gzip":
        return gzip.decompress(data)
    if name == "crc32c":
        assert crc32c(data[:-4]) == data[-4:], "checksum"
        return data[:-4]
    import numcodecs
    if name == "zstd":
        try:
            return numcodecs.Zstd().decode(data)
        except RuntimeError:  # it wants frames that say their size
            return subprocess.run(["zstd", "-dcq"], input=data, stdout=subprocess.PIPE, check=True).stdout
    if name == "blosc":
        return numcodecs.Blosc().decode(data)
    raise ValueError(name)


def encode(block, codecs):
    """The bytes of one chunk; None where shards store nothing."""
    for at, codec in enumerate(codecs):
        name, config = codec["name"], codec.get("configuration", {})
        if name == "transpose":
            block = block.transpose(config["order"])
        elif name == "bytes":
            order = ">" if config.get("endian") == "big" else "<"
            data = numpy.ascontiguousarray(block).astype(block.dtype.newbyteorder(order)).tobytes()
            for packer in codecs[at + 1:]:
                data = pack(packer, data)
            return data
        else:
            return shard(block, config)
    raise ValueError("no bytes")


def blocks(shape, chunk):
    return itertools.product(*(range(math.ceil(n / c)) for n, c in zip(shape, chunk)))


def shard(block, config):
    chunk = config["chunk_shape"]
    first = config.get("index_location", "end") == "start"
    order = ">" if config["index_codecs"][0]["configuration"]["endian"] == "big" else "<"
    n = math.prod(b // c for b, c in zip(block.shape, chunk))
    crc = len(config["index_codecs"]) > 1
    at = 16 * n + 4 * crc if first else 0
    parts, index = [], []
    for place in blocks(block.shape, chunk):
        piece = block[tuple(slice(p * c, p * c + c) for p, c in zip(place, chunk))]
        if not piece.any():
            index += [2 ** 64 - 1] * 2
            continue
        parts.append(encode(piece, config["codecs"]))
        index += [at, len(parts[-1])]
        at += len(parts[-1])
    table = struct.pack(f"{order}{2 * n}Q", *index)
    table += crc32c(table) if crc else b""
    return table + b"".join(parts) if first else b"".join(parts) + table


def key_of(keys, place):
    kind, config = keys["name"], keys.get("configuration", {})
    separator = config.get("separator", "/" if kind == "default" else ".")
    names = [str(p) for p in place]
    return separator.join(["c"] + names if kind == "default" else names)


DEFAULT_KEYS = {"name": "default", "configuration": {"separator": "/"}}


def write_array(path, data, chunk, codecs, keys=None, fill=0, attributes=None, skip=(), names=None):
    keys = keys or DEFAULT_KEYS
    meta = {"zarr_format": 3, "node_type": "array", "shape": list(data.shape),
            "data_type": NAMES[data.dtype.str[1:] if data.dtype.kind != "b" else "?"],
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": list(chunk)}},
            "chunk_key_encoding": keys, "fill_value": fill, "codecs": codecs, "attributes": attributes or {}}
    if names:
        meta["dimension_names"] = names
    os.makedirs(path, exist_ok=True)
    with open(os.path.join(path, "zarr.json"), "w") as file:
        json.dump(meta, file)
    for place in blocks(data.shape, chunk):
        if place in skip:
            continue
        piece = data[tuple(slice(p * c, p * c + c) for p, c in zip(place, chunk))]
        whole = numpy.zeros(chunk, data.dtype)
        whole[tuple(slice(0, n) for n in piece.shape)] = piece
        name = os.path.join(path, key_of(keys, place))
        os.makedirs(os.path.dirname(name), exist_ok=True)
        with open(name, "wb") as file:
            file.write(encode(whole, codecs))


def write_group(path, attributes=None):
    os.makedirs(path, exist_ok=True)
    with open(os.path.join(path, "zarr.json"), "w") as file:
        json.dump({"zarr_format": 3, "node_type": "group", "attributes": attributes or {}}, file)


def read_array(path):
    """Arrays as VolVis writes them: bytes and compressions, shards of those."""
    meta = json.load(open(os.path.join(path, "zarr.json")))
    assert meta["zarr_format"] == 3 and meta["node_type"] == "array"
    kind = {v: k for k, v in NAMES.items()}[meta["data_type"]]
    chunk = meta["chunk_grid"]["configuration"]["chunk_shape"]
    out = numpy.full(meta["shape"], meta["fill_value"], kind)
    for place in blocks(out.shape, chunk):
        name = os.path.join(path, key_of(meta["chunk_key_encoding"], place))
        if os.path.exists(name):
            piece = decode(open(name, "rb").read(), chunk, meta["codecs"], kind, meta["fill_value"])
            where = tuple(slice(p * c, min(p * c + c, n)) for p, c, n in zip(place, chunk, out.shape))
            out[where] = piece[tuple(slice(0, w.stop - w.start) for w in where)]
    return out, meta


def decode(data, chunk, codecs, kind, fill):
    config = codecs[0].get("configuration", {})
    if codecs[0]["name"] == "sharding_indexed":
        return unshard(data, chunk, config, kind, fill)
    for codec in reversed(codecs[1:]):
        data = unpack(codec, data)
    order = ">" if config.get("endian") == "big" else "<"
    return numpy.frombuffer(data, numpy.dtype(kind).newbyteorder(order)).reshape(chunk)


def unshard(data, chunk, config, kind, fill):
    inner = config["chunk_shape"]
    n = math.prod(b // c for b, c in zip(chunk, inner))
    crc = len(config["index_codecs"]) > 1
    size = 16 * n + 4 * crc
    table = data[:size] if config.get("index_location") == "start" else data[-size:]
    if crc:
        assert crc32c(table[:-4]) == table[-4:], "checksum of the index"
    index = struct.unpack(f"<{2 * n}Q", table[:16 * n])
    out = numpy.full(chunk, fill, kind)
    for i, place in enumerate(blocks(chunk, inner)):
        at, length = index[2 * i: 2 * i + 2]
        if at != 2 ** 64 - 1:
            where = tuple(slice(p * c, p * c + c) for p, c in zip(place, inner))
            out[where] = decode(data[at: at + length], inner, config["codecs"], kind, fill)
    return out
