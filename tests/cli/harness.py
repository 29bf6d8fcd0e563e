"""What the tests of the program share: running it, small volumes, and a report in the words of cmocka.

A test file ends with harness.main(). Its tests are the functions that begin with test_; their names are sentences.
"""
import functools
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import traceback
import zlib

import forks

VOLVIS = os.path.abspath(sys.argv[1])
HEAD_MRI = "/usr/share/mricron/templates/ch2.nii.gz"


class Skip(Exception):
    pass


class Result:
    def __init__(self, code, out, err):
        self.code, self.out, self.err = code, out, err

    @property
    def text(self):
        return self.out.decode("utf-8")

    @property
    def message(self):
        return self.err.decode("utf-8")

    @property
    def json(self):
        return json.loads(self.text, parse_constant=refuse_constant)


def sanitized():
    """Whether the program is built with a sanitizer, of addresses or of threads: it is slow, and takes memory as it likes."""
    with open(VOLVIS, "rb") as program:
        code = program.read()
    return b"__asan_init" in code or b"__tsan_init" in code


def refuse_constant(name):
    raise AssertionError(f"{name} is no JSON")


def environment(**more):
    env = {k: v for k, v in os.environ.items() if not k.startswith("VOLVIS_") and k not in ("COLUMNS", "NO_COLOR")}
    env["VOLVIS_DEFAULTS"] = "none"  # whoever runs the tests may have a file of their own
    env.update(more)
    return env


@functools.cache
def runs():
    """The program ready to be run, or None: then every run is a start of its own."""
    library = os.path.join(os.path.dirname(VOLVIS), "tests", "cli", "libforks.so")
    if not os.path.exists(library) or os.environ.get("VOLVIS_STARTS") == "each":
        return None
    return forks.Runs(VOLVIS, library, environment())


def volvis(*words, stdin=b"", env=None, timeout=60):
    """Run the program; every word is given as it is."""
    words = [str(word) for word in words]
    env = environment(**(env or {}))
    if runs():
        return Result(*runs().run(words, stdin, env, timeout))
    done = subprocess.run([VOLVIS, *words], input=stdin, capture_output=True, timeout=timeout, env=env)
    return Result(done.returncode, done.stdout, done.stderr)


def ok(*words, **options):
    result = volvis(*words, **options)
    assert result.code == 0, f"volvis {' '.join(map(str, words))}: exit {result.code}: {result.message}"
    return result


def fails(code, *words, **options):
    """The program ends with this code and one sentence."""
    result = volvis(*words, **options)
    said = result.message.strip()
    assert result.code == code, f"volvis {' '.join(map(str, words))}: exit {result.code}, not {code}: {said}"
    assert said.startswith("volvis: ") and "\n" not in said, f"not one sentence: {said!r}"
    return said


def says(text, *parts):
    for part in parts:
        assert part in text, f"{part!r} is not in {text!r}"


def write_nrrd(path, dims, value, spacing=(1, 1, 1), kind="uint8", code="B", unit="mm"):
    """A volume of value(x, y, z), x fastest."""
    nx, ny, nz = dims
    samples = [value(x, y, z) for z in range(nz) for y in range(ny) for x in range(nx)]
    write_samples(path, dims, struct.pack(f"<{len(samples)}{code}", *samples), spacing, kind, unit)


def write_samples(path, dims, data, spacing=(1, 1, 1), kind="uint8", unit="mm"):
    """A volume of these bytes."""
    nx, ny, nz = dims
    header = (f"NRRD0004\ntype: {kind}\ndimension: 3\nspace: right-anterior-superior\nsizes: {nx} {ny} {nz}\n"
              f"space directions: ({spacing[0]},0,0) (0,{spacing[1]},0) (0,0,{spacing[2]})\nspace origin: (0,0,0)\n"
              f'space units: "{unit}" "{unit}" "{unit}"\nencoding: raw\nendian: little\n\n')
    with open(path, "wb") as file:
        file.write(header.encode() + data)


@functools.lru_cache(None)
def ball_of(n):
    """An eighth is worked out, and mirrored."""
    away = [(n - 1) / 2 - i for i in range((n + 1) // 2)]

    def whole(part):
        return part + part[: n // 2][::-1]

    def value(x, y, z):
        return max(0, min(255, int(320 - 320 * math.dist((x, y, z), (0, 0, 0)) / (n / 2))))

    return b"".join(whole([b"".join(whole([bytes(whole([value(x, y, z) for x in away])) for y in away])) for z in away]))


def write_ball(path="head.nrrd", n=32, **options):
    """A ball of 255 in the middle that falls off to 0 at the border."""
    write_samples(path, (n, n, n), ball_of(n), **options)


def write_blocks(path="blocks.nrrd"):
    """27 blocks of 6 x 6 x 6 samples that touch, in 0: ids of 32 bits, of which nothing says that they are."""
    def block(x, y, z):
        inside = all(3 <= v < 21 for v in (x, y, z))
        at = (x - 3) // 6 + 3 * ((y - 3) // 6) + 9 * ((z - 3) // 6)
        return 1000 * (7 * at % 27 + 1) if inside else 0
    write_nrrd(path, (24, 24, 24), block, kind="uint32", code="I")


def write_cells(path="cells.nrrd", n=16):
    """Two channels of u16: a ball in each, in opposite corners."""
    header = (f"NRRD0004\ntype: uint16\ndimension: 4\nsizes: 2 {n} {n} {n}\nkinds: list domain domain domain\n"
              "encoding: raw\nendian: little\n\n")
    def ball(x, y, z, middle):
        return max(0, min(1000, int(1500 - 3000 * math.dist((x, y, z), (middle,) * 3) / (n / 2))))
    samples = [ball(x, y, z, m) for z in range(n) for y in range(n) for x in range(n) for m in (n * 0.35, n * 0.65)]
    with open(path, "wb") as file:
        file.write(header.encode() + struct.pack(f"<{len(samples)}H", *samples))


def write_named_cells(path="cells.nrrd"):
    """The same with names, a colour and a window."""
    write_cells(path)
    with open(path, "rb") as file:
        data = file.read()
    keys = (b"volvis channel 0 name:=nuclei\nvolvis channel 0 color:=0 0 1\nvolvis channel 0 window:=100 900\n"
            b"volvis channel 1 name:=membrane\n")
    with open(path, "wb") as file:
        file.write(data.replace(b"\n\n", b"\n" + keys + b"\n", 1))


LABELS = """NRRD0004
type: uint8
dimension: 3
space: right-anterior-superior
sizes: 24 24 24
space directions: (0.5,0,0) (0,0.5,0) (0,0,0.5)
space origin: (0,0,0)
encoding: raw
Segment0_ID:=a
Segment0_LabelValue:=7
Segment0_Name:=left kidney
Segment0_Color:=1 0.5 0
Segment1_ID:=b
Segment1_LabelValue:=2
Segment1_Name:=liver "lobe" \u00e9

"""


def write_labels(path="organs.seg.nrrd", n=24):
    """Label 7 fills the lower half of a cube with a margin, label 2 the upper half."""
    def label(x, y, z):
        return 0 if min(x, y, z) < 4 or max(x, y, z) >= n - 4 else 7 if z < n // 2 else 2
    with open(path, "wb") as file:
        file.write(LABELS.encode())
        file.write(bytes(label(x, y, z) for z in range(n) for y in range(n) for x in range(n)))


def write_box(path="box.ply", unit="mm"):
    """The surface of the box from 0 to 1, 2, 3 as a text PLY of quadrangles."""
    corners = [(x, 2 * y, 3 * z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    with open(path, "w", encoding="ascii") as file:
        file.write(f"ply\nformat ascii 1.0\ncomment unit: {unit}\nelement vertex 8\nproperty float x\n"
                   "property float y\nproperty float z\nelement face 6\n"
                   "property list uchar int vertex_indices\nend_header\n")
        file.writelines("%g %g %g\n" % corner for corner in corners)
        file.writelines("4 %d %d %d %d\n" % face for face in faces)


def write_large(path, n=256):
    """Many samples at once: noise that is quick to make."""
    header = f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {n} {n} {n}\nencoding: raw\n\n"
    with open(path, "wb") as file:
        file.write(header.encode())
        slice_bytes = bytes((x * 7 + y * 13) % 251 for y in range(n) for x in range(n))
        for z in range(n):
            file.write(slice_bytes[z:] + slice_bytes[:z])


def png_chunks(path):
    with open(path, "rb") as file:
        data = file.read()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is no PNG"
    at = 8
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        body = data[at + 8 : at + 8 + length]
        assert zlib.crc32(data[at + 4 : at + 8 + length]) == struct.unpack(">I", data[at + 8 + length : at + 12 + length])[0]
        yield data[at + 4 : at + 8].decode(), body
        at += length + 12


def png_pixels(path):
    """The picture's bytes, unpacked, whatever the texts around them say."""
    return zlib.decompress(b"".join(body for kind, body in png_chunks(path) if kind == "IDAT"))


def png_text(path):
    texts = {}
    for kind, body in png_chunks(path):
        if kind == "tEXt":
            key, value = body.split(b"\0", 1)
            texts[key.decode("latin-1")] = value.decode("latin-1")
        elif kind == "zTXt":
            key, value = body.split(b"\0", 1)
            texts[key.decode("latin-1")] = zlib.decompress(value[1:]).decode("latin-1")
        elif kind == "iTXt":
            key, rest = body.split(b"\0", 1)
            packed, _, rest = rest[0], rest[1], rest[2:]
            _, _, value = rest.split(b"\0", 2)
            texts[key.decode("latin-1")] = (zlib.decompress(value) if packed else value).decode("utf-8")
    return texts


def verbs():
    return json.loads(ok("help", "--json").text)["verbs"]


def run_one(name, test):
    """A test works in a folder of its own."""
    folder = tempfile.mkdtemp(prefix="volvis-cli-")
    os.chdir(folder)
    print(f"[ RUN      ] {name}", flush=True)
    try:
        test()
        print(f"[       OK ] {name}", flush=True)
        return True
    except Skip as why:
        print(f"{why}\n[  SKIPPED ] {name}", flush=True)
        return True
    except Exception:
        traceback.print_exc(file=sys.stdout)
        print(f"[  FAILED  ] {name}", flush=True)
        return False
    finally:
        os.chdir("/")
        shutil.rmtree(folder, ignore_errors=True)


def main():
    tests = vars(sys.modules["__main__"])
    wanted = sys.argv[2:]
    names = [n for n in tests if n.startswith("test_") and (not wanted or n in wanted)]
    passed = [run_one(name, tests[name]) for name in names]
    sys.exit(0 if passed and all(passed) else 1)
