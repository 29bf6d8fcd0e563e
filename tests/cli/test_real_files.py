"""Real files beside the checkout (../shared/data, or $VOLVIS_SHARED): what `volvis info --stats` says of each is compared
with what an independent reader makes of it. Skips what is not there.

To add a format: write a function that takes a path and returns a Volume, by a library that is not ours or a few lines of
numpy, and a row in FILES. Everything that the Volume says is compared; what it leaves at None is not.
"""
import bz2
import glob
import gzip
import os
import sys
import zlib
from harness import Skip, fails, main, ok, volvis

try:
    import numpy
except ImportError:
    numpy = None
try:
    import nibabel
except ImportError:
    nibabel = None

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(sys.argv[0]))))
DATA = os.path.join(os.environ.get("VOLVIS_SHARED", os.path.join(SOURCE, "..", "shared")), "data")


class Volume:
    """What a reader should find.

    frames   stored samples of each time step: arrays [x, y, z] or [x, y, z, component]
    affine   4 x 4, index to world in RAS millimetres (or the file's own space); or
    spacing  three lengths
    scale    (slope, intercept) from stored numbers to values
    """

    def __init__(self, frames, affine=None, spacing=None, scale=(1, 0), space=None, meaning=None):
        self.frames, self.affine, self.spacing = frames, affine, spacing
        self.scale, self.space, self.meaning = scale, space, meaning


# Readers -------------------------------------------------------------------------------------------------------------

NRRD_TYPES = {"signed char": "i1", "int8": "i1", "unsigned char": "u1", "uchar": "u1", "uint8": "u1", "short": "i2",
              "int16": "i2", "unsigned short": "u2", "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4",
              "uint": "u4", "float": "f4", "double": "f8"}


def nrrd_header(path):
    """Fields and keys, and what follows the header of an attached file."""
    with open(path, "rb") as file:
        data = file.read()
    ends = [data.find(e) + len(e) for e in (b"\n\n", b"\r\n\r\n") if e in data]
    end = min(ends) if ends else len(data)
    fields, names = {}, []
    for line in data[:end].decode("latin-1").splitlines()[1:]:
        if names or fields.get("data file", "").startswith("LIST"):
            names.append(line)
        elif not line.startswith("#") and ": " in line and ":=" not in line:
            key, value = line.split(": ", 1)
            fields[{"datafile": "data file"}.get(key, key)] = value.strip()
    return fields, data[end:]


def nrrd(path):
    fields, attached = nrrd_header(path)
    sizes = [int(n) for n in fields["sizes"].split()]
    order = ">" if fields.get("endian") == "big" else "<"
    kind = numpy.dtype(order + NRRD_TYPES[fields["type"]])
    encoding = fields["encoding"].lower()
    body = attached
    if "data file" in fields:
        with open(os.path.join(os.path.dirname(path), fields["data file"]), "rb") as file:
            body = file.read()
    if encoding in ("gzip", "gz"):
        body = gzip.decompress(body)
    elif encoding in ("bzip2", "bz2"):
        body = bz2.decompress(body)
    if encoding in ("ascii", "text", "txt"):
        samples = numpy.array(body.split(), float).astype(kind)
    else:
        samples = numpy.frombuffer(body, kind, int(numpy.prod(sizes)), int(fields.get("byte skip", 0)))
    samples = samples.reshape(sizes, order="F")
    kinds = [k.lower() for k in fields.get("kinds", "").split()] or ["???"] * len(sizes)
    domain = ("domain", "space", "???", "none")
    if "space directions" in fields: # an axis without a direction does not lie in space
        vectors = fields["space directions"].replace("(", " (").split()
        kinds = ["list" if v == "none" and k in domain else k for v, k in zip(vectors, kinds)]
    inner = [a for a, k in enumerate(kinds) if k not in domain]
    outer = [a for a in range(len(sizes)) if a not in inner]
    samples = numpy.transpose(samples, outer + inner)
    while samples.ndim < 3 + len(inner):
        samples = numpy.expand_dims(samples, samples.ndim - len(inner))
    spacing = None
    if "space directions" in fields:
        axes = [[float(x) for x in v.strip("()").split(",")] for v in vectors if v != "none"]
        spacing = [float(numpy.linalg.norm(v)) for v in axes]
    elif "spacings" in fields:
        spacing = [float(s) for a, s in enumerate(fields["spacings"].split()) if a in outer]
    frames = [samples] if samples.ndim - len(inner) == 3 else [samples[..., t] for t in range(samples.shape[-1])]
    return Volume(frames, spacing=spacing[:3] if spacing and len(spacing) >= 3 else None)


def nifti(path):
    if nibabel is None:
        raise Skip("needs nibabel")
    image = nibabel.load(path)
    samples = numpy.asarray(image.dataobj.get_unscaled())
    scale = (image.dataobj.slope, image.dataobj.inter)
    frames = [samples[..., t] for t in range(samples.shape[3])] if samples.ndim == 4 else [samples]
    meaning = "label" if int(image.header["intent_code"]) == 1002 else None
    return Volume(frames, affine=image.affine, scale=scale, space="RAS", meaning=meaning)


# path below shared/data (* and ** as in a shell), reader
FILES = [
    ("formats/nrrd/*.nrrd", nrrd),
    ("formats/nrrd/*.nhdr", nrrd),
    ("formats/nrrd/ball/*.nrrd", nrrd),
    ("formats/nrrd/ball/*.nhdr", nrrd),
    ("volumes/*.nhdr", nrrd),
    ("formats/nifti/*.nii*", nifti),
    ("formats/nifti/*.hdr", nifti),
    ("formats/nifti/*.img", nifti),
    ("volumes/*.nii.gz", nifti),
]

# files that no volume can be made of, and what is said of them
REFUSED = [
    ("formats/nrrd/mini-ten-mask.nrrd", "matrices"),
]


# Comparing -----------------------------------------------------------------------------------------------------------

def close(a, b, tolerance):
    return abs(a - b) <= tolerance * max(1e-30, abs(a), abs(b)) or (a != a and b != b)


def check_placement(said, volume, wrong):
    if volume.spacing is not None and not all(close(a, b, 1e-5) for a, b in zip(said["spacing"], volume.spacing)):
        wrong.append(f"spacing {said['spacing']}, not {volume.spacing}")
    if volume.affine is None:
        return
    ours = numpy.eye(4)
    for axis in range(3):
        ours[:3, axis] = numpy.array(said["directions"][axis]) * said["spacing"][axis]
    ours[:3, 3] = said["origin"]
    corner = numpy.array([n - 1 for n in said["dims"]] + [1.0])
    if not numpy.allclose(ours[:3, :3], volume.affine[:3, :3], rtol=1e-5, atol=1e-6) or \
            not numpy.allclose(ours @ corner, volume.affine @ corner, rtol=1e-5, atol=1e-3):
        wrong.append(f"placement\n{ours}\nnot\n{volume.affine}")


def check_samples(said, frame, scale, wrong):
    channels = frame[..., None] if frame.ndim == 3 else frame
    dims, components = list(channels.shape[:3]), channels.shape[3]
    if said["dims"] != dims or said["components"] != components:
        wrong.append(f"{said['dims']} with {said['components']} components, not {dims} with {components}")
        return
    for c in range(components):
        channel, column = said["channels"][c], channels[..., c].ravel(order="K").astype(float)
        if frame.dtype.kind == "f":
            column = column[numpy.isfinite(column)]
        column *= scale[0]
        column += scale[1]
        least, largest, mean, count = column.min(), column.max(), column.mean(), column.size
        column -= mean
        deviation = numpy.sqrt(column @ column / count)
        for name, value in (("min", least), ("max", largest), ("mean", mean), ("deviation", deviation)):
            scale_of_values = max(abs(least), abs(largest), 1e-30)
            if abs(channel[name] - value) > 1e-5 * scale_of_values:
                wrong.append(f"component {c}: {name} {channel[name]}, not {value}")
        if channel["count"] != count:
            wrong.append(f"component {c}: {channel['count']} samples, not {count}")
    stored = numpy.moveaxis(frame, -1, 0) if frame.ndim == 4 else frame
    checksum = f"crc32:{zlib.crc32(stored.astype(frame.dtype.newbyteorder('<')).tobytes(order='F')):08x}"
    if said["checksum"] != checksum:
        wrong.append(f"checksum {said['checksum']}, not {checksum}")


def check(path, reader):
    """All that is wrong, a line each."""
    try:
        volume, wrong = reader(path), []
    except (ValueError, KeyError, OSError) as why:
        raise AssertionError(f"{path}: the test's own reader fails: {why!r}") from why
    for number in sorted({0, len(volume.frames) - 1}):
        said = ok("info", f"{path}@{number}" if number else path, "--json", "--stats").json
        check_samples(said, volume.frames[number], volume.scale, wrong)
        check_placement(said, volume, wrong)
        if said["frames"] != len(volume.frames):
            wrong.append(f"{said['frames']} time steps, not {len(volume.frames)}")
        for name in ("space", "meaning"):
            if getattr(volume, name) is not None and said[name] != getattr(volume, name):
                wrong.append(f"{name} is {said[name]}, not {getattr(volume, name)}")
    return [f"{os.path.relpath(path, DATA)}: {line}" for line in wrong]


def need_data():
    if numpy is None:
        raise Skip("needs numpy")
    if not os.path.isdir(DATA):
        raise Skip(f"there is no {DATA}")


def test_every_file_is_what_an_independent_reader_makes_of_it():
    need_data()
    refused = {os.path.join(DATA, path) for path, _ in REFUSED}
    wrong, n = [], 0
    for pattern, reader in FILES:
        for path in sorted(glob.glob(os.path.join(DATA, pattern), recursive=True)):
            if path not in refused:
                wrong += check(path, reader)
                n += 1
    print(f"{n} files")
    assert not wrong, "\n".join(wrong)


def test_what_is_no_volume_is_refused_in_one_sentence():
    need_data()
    for path, words in REFUSED:
        if os.path.exists(os.path.join(DATA, path)):
            assert words in fails(3, "info", os.path.join(DATA, path)), path


def test_whatever_lies_there_is_opened_or_refused_in_one_sentence():
    need_data()
    for folder, _, names in os.walk(DATA):
        for name in sorted(names)[:6]:
            path = os.path.join(folder, name)
            result = volvis("info", path, "-q")
            lines = [line for line in result.message.splitlines() if not line.startswith("volvis: warning:")]
            assert result.code in (0, 2, 3, 7), f"{path}: {result.code}: {result.message}"
            assert result.code == 0 or len(lines) == 1 or (result.code == 7 and not lines), f"{path}: {result.message}"


main()
