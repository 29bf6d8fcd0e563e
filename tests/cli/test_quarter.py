"""Every operation of the table on a volume four times as large as the memory it is given: the same bytes as in memory, or
one sentence before any work."""
import os
import signal
import subprocess

from harness import VOLVIS, Skip, environment, main, ok, sanitized, volvis

try:
    import numpy as np
except ImportError:
    np = None

SHAPE = (256, 80, 96)  # z, y, x
BYTES = 4 * SHAPE[0] * SHAPE[1] * SHAPE[2]  # of floats, and of labels: twice as many along x and y
MEMORY = str(BYTES // 4)
# Words of each operation that streams; @ is a volume of floats, # one of labels. More than one line where it has ways of its own.
STREAMS = {
    "channel": ["@ --channel 0"],
    "merge": ["@ @2"],
    "join": ["@ @2"],
    "crop": ["@ --z 3:"],
    "pad": ["@ --all 3"],
    "flip": ["@ --axes z"],
    "reorient": ["@ --order=-y,x,z"],
    "resample": ["@ --spacing 1.5vox"],
    "project": ["@ --slab 4"],
    "rescale": ["@ --to 0..1"],
    "clamp": ["@ --range 20..60"],
    "equalize": ["@", "@ --method adaptive --tile 40"],
    "match": ["# #2"],
    "gaussian": ["@ --sigma 1vox"],
    "median": ["@"],
    "mean": ["@"],
    "dilate": ["@ --radius 1vox"],
    "erode": ["@ --radius 1vox"],
    "open": ["@ --radius 1vox"],
    "close": ["@ --radius 1vox", "# --radius 1vox"],
    "top-hat": ["@ --radius 1vox"],
    "unsharp": ["@ --sigma 1vox"],
    "gradient": ["@"],
    "laplacian": ["@"],
    "vesselness": ["@ --sigma 0.5vox --sigma-most 0.5vox --c 3"],
    "threshold": ["@ --range 50..", "# --method otsu"],
    "components": ["# --connectivity corners", "@ --range 50.."],
    "calc": ["a-b @ @2"],
    "mask": ["@ @2"],
    "bilateral": ["@ --sigma 0.5vox"],
    "diffuse": ["@ --iterations 2", "@ --iterations 8 --conductance rational"],
    "denoise": ["@ --search-voxels 1,1,1"],
    "add-noise": ["@ --sigma 3"],
    "distance": ["#", "# --side both"],
}
# And of those that take all samples at once.
WHOLE = {
    "fill-holes": ["#"],
    "bias": ["@"],
    "grow": ["@ --seed 40,40,40 --range 20.."],
    "watershed": ["@"],
    "skeleton": ["#"],
    "diffuse": ["@ --method coherence"],
}


def write(name, data):
    kind = {"f4": "float", "u1": "uchar"}[data.dtype.str[1:]]
    sizes = " ".join(str(n) for n in data.shape[::-1])
    head = f"NRRD0005\ntype: {kind}\ndimension: 3\nsizes: {sizes}\nendian: little\nspace: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n\n"
    with open(name, "wb") as file:
        file.write(head.encode() + data.tobytes())


def make_values():
    if np is None or sanitized():
        raise Skip("NumPy is not there" if np is None else "sanitizers hold memory of their own")
    z, y, x = np.meshgrid(*(np.linspace(-3, 3, n, dtype="f4") for n in SHAPE), indexing="ij", sparse=True)
    noise = np.random.default_rng(7).standard_normal(SHAPE, "f4")
    values = 50 + 40 * np.sin(2 * x + y) * np.sin(3 * y) * np.sin(5 * z - x) + 2 * noise
    return np.round(4 * values) / 4  # few numbers, for tables of them to be small beside so small a volume


def write_labels(values):
    labels = np.repeat(np.repeat((values > 60).astype("u1") + (values > 80), 2, axis=1), 2, axis=2).astype("u1")
    write("labels.nrrd", labels)
    write("others_labels.nrrd", 3 * labels + 1)


def make_volumes():
    values = make_values()
    write("floats.nrrd", values.astype("<f4"))
    write("others.nrrd", (values * 0.5 + 3).astype("<f4"))
    write_labels(values)


def words_of(name, line):
    files = {"@": "floats.nrrd", "@2": "others.nrrd", "#": "labels.nrrd", "#2": "others_labels.nrrd"}
    return [name] + [files.get(word, word) for word in line.split()]


def same_in_a_quarter(words):
    ok(*words, "-o", "whole.nrrd", "--overwrite", "--threads", "2")
    part = ok(*words, "-o", "part.nrrd", "--overwrite", "--threads", "2", "--memory", MEMORY, "--json").json
    assert part["streamed"], f"{words} does not stream"
    with open("whole.nrrd", "rb") as whole, open("part.nrrd", "rb") as file:
        assert whole.read() == file.read(), f"{words}: other bytes in a quarter of the memory"
    return part


def test_every_operation_streams_in_a_quarter_or_says_what_it_needs():
    make_volumes()
    for row in ok("schema", "--tables").json["operations"]:
        name = row["name"]
        if row["gives"] != "volume":
            continue
        assert name in STREAMS or name in WHOLE, f"{name} is in neither table of this test"
        for line in STREAMS.get(name, []):
            same_in_a_quarter(words_of(name, line))
        for line in WHOLE.get(name, []):
            words = words_of(name, line)
            done = volvis(*words, "-o", "none.nrrd", "--memory", MEMORY)
            assert done.code == 4 and f"{name} needs" in done.message and "the limit is" in done.message, f"{words}: {done.message}"
            assert not os.path.exists("none.nrrd")


def test_nothing_is_left_of_distances_that_are_killed_or_have_no_room():
    write_labels(make_values())
    os.mkdir("tmp")
    env = environment(TMPDIR=os.path.abspath("tmp"))
    before = sorted(os.listdir("."))
    words = ["distance", "labels.nrrd", "-o", "none.nrrd", "--memory", MEMORY]
    assert ok(*words, "--dry-run", "--json").json["scratch_bytes"] == 4 * BYTES
    for sent in (signal.SIGKILL, signal.SIGTERM):
        with subprocess.Popen([VOLVIS, *words, "--progress", "json"], stderr=subprocess.PIPE, env=env) as child:
            child.stderr.readline()  # it is at work
            child.send_signal(sent)
        assert child.returncode != 0
        assert os.listdir("tmp") == [] and sorted(os.listdir(".")) == before
    done = volvis(*words, env={"TMPDIR": "/proc"})
    assert done.code != 0 and "temporary file" in done.message and "TMPDIR" in done.message, done.message
    assert sorted(os.listdir(".")) == before


main()
