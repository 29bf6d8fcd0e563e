"""usage: test_bench_scenes.py VOLVIS BENCH

Scenes of benchmarks say all that a quality level would choose: pictures of every level are the same.
"""
import json
import os
import subprocess
import sys
import tempfile
import zlib

VOLVIS, BENCH = sys.argv[1:3]
sys.path[:0] = [BENCH, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../golden")]
import cases
import png

N = 24


def write_volume(path):
    with open(path, "wb") as file:
        file.write(f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {N} {N} {N}\nencoding: raw\n\n".encode("ascii"))
        file.write(bytes((x * x + 3 * y + z * x) % 256 for z in range(N) for y in range(N) for x in range(N)))


def pixels(path):
    """Unpacked rows: notes beside them tell the quality."""
    with open(path, "rb") as file:
        return zlib.decompress(b"".join(body for kind, body in png.chunks(file.read()) if kind == b"IDAT"))


def draw(folder, case, quality):
    scene = cases.scene(case, "data.nrrd")
    scene["views"]["main"]["render"]["quality"] = quality
    path, picture = os.path.join(folder, "scene.vv.json"), os.path.join(folder, "a.png")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)
    subprocess.run([VOLVIS, "render", path, "-o", picture, "--size", "64x64", "--overwrite", "--progress", "none"], check=True)
    return pixels(picture)


def main():
    with tempfile.TemporaryDirectory() as folder:
        write_volume(os.path.join(folder, "data.nrrd"))
        for mode in cases.TRANSFER:
            for shaded in (False, True) if mode != "mip" else (False,):
                case = cases.Case("head", N, mode, shaded, 1.0)
                drawn = {quality: draw(folder, case, quality) for quality in ("draft", "normal", "high", "reference")}
                differ = [quality for quality in drawn if drawn[quality] != drawn["normal"]]
                if differ:
                    sys.exit(f"{cases.name(case)}: the picture depends on the quality: {', '.join(differ)} and normal differ")
                if len(set(drawn["normal"])) < 20:
                    sys.exit(f"{cases.name(case)}: an empty picture proves nothing")


main()
