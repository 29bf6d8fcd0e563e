"""What bench/run and bench/compare share: volumes, scenes, runs of the program, rows."""
import json
import os
import statistics
import struct
import subprocess
import sys
import zlib

import cases


def build_tools(folder):
    """bench/limits and bench/volumes of a build folder, which are not built by default."""
    build = os.path.dirname(folder)
    subprocess.run(["ninja", "-C", build, "--quiet", "bench/limits", "bench/volumes"], check=True)


def volume(tools, folder, kind, n, dtype="u8"):
    """Path of a volume of bench/volumes.c; made when it is not there."""
    path = f"{folder}/{kind}_{n}_{dtype}.nrrd"
    if not os.path.exists(path):
        os.makedirs(folder, exist_ok=True)
        subprocess.run([f"{tools}/volumes", kind, str(n), dtype, path + ".part.nrrd"], check=True, stdout=subprocess.DEVNULL)
        os.replace(path + ".part.nrrd", path)
    return path


def write_scene(folder, case, data):
    os.makedirs(folder, exist_ok=True)
    path = f"{folder}/{cases.name(case).replace(':', '_')}.vv.json"
    with open(path, "w", encoding="utf-8") as file:
        json.dump(cases.scene(case, os.path.relpath(data, folder)), file, indent=1)
    return path


def render(program, scene, picture, threads, repeat=1):
    """One run: the JSON of `volvis render`; render_s is the median of `repeat` frames after a warm-up."""
    command = [program, "render", scene, "-o", picture, "--overwrite", "--json", "--progress", "none"]
    command += ["--threads", str(threads), "--repeat", str(repeat)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"bench: {' '.join(command)}\n{done.stdout}{done.stderr}")
    return json.loads(done.stdout)


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def row(name, program, seconds):
    return {
        "name": name,
        "program": program,
        "runs": len(seconds),
        "median_s": statistics.median(seconds),
        "p10_s": percentile(seconds, 0.1),
        "p90_s": percentile(seconds, 0.9),
    }


def picture_checksum(path):
    """CRC-32 of a PNG's unpacked pixel data, so that texts and compression do not count."""
    with open(path, "rb") as file:
        data = file.read()
    at, packed = 8, b""
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        if data[at + 4 : at + 8] == b"IDAT":
            packed += data[at + 8 : at + 8 + length]
        at += length + 12
    return f"{zlib.crc32(zlib.decompress(packed)):08x}"


def commit():
    done = subprocess.run(["git", "describe", "--always", "--dirty"], capture_output=True, text=True)
    return done.stdout.strip() or "unknown"
