"""Every operation of the table on volumes up to ten times as large as the memory it is given, of all types in turn: the
same bytes as in memory, or one sentence before any work."""
import os
import signal
import subprocess

from harness import VOLVIS, Skip, environment, main, ok, sanitized, volvis

try:
    import numpy as np
except ImportError:
    np = None

SHAPE = (257, 79, 97)  # z, y, x
BYTES = SHAPE[0] * SHAPE[1] * SHAPE[2]  # of samples of 8 bits
MEMORY = BYTES * 3 // 4
TYPES = ("u1", "f8", "u2", "f4", "i4", "i1", "i8", "i2", "u4", "u8")  # each operation is given the next one
KINDS = {"u1": "uint8", "i1": "int8", "u2": "uint16", "i2": "int16", "u4": "uint32", "i4": "int32", "u8": "uint64", "i8": "int64",
         "f4": "float", "f8": "double"}
# Words of each operation that streams; @ is a volume of amounts, # one of labels, ~ noise. More than one line where it has
# ways of its own.
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
    "gaussian": ["@ --sigma 1vox", "@ --sigma 5vox"],
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
    "vesselness": ["@ --sigma 0.7vox --sigma-most 0.7vox --c 3"],
    "voxelize": ["@", "@ --shape torus --with difference"],
    "threshold": ["@ --range 50..", "# --method otsu"],
    "components": ["# --connectivity corners", "@ --range 50..", "~"],
    "calc": ["a-b @ @2"],
    "mask": ["@ @2"],
    "bilateral": ["@ --sigma 0.5vox"],
    "diffuse": ["@ --iterations 2", "@ --iterations 12 --conductance rational"],
    "denoise": ["@ --search-voxels 1,1,1"],
    "add-noise": ["@ --sigma 3"],
    "distance": ["#", "# --side both"],
}
# Of these tables, or what is sorted, may be larger than so little memory: they need more of it, and say so.
TABLES = ("components", "equalize", "match", "median")
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
    sizes = " ".join(str(n) for n in data.shape[::-1])
    head = f"NRRD0005\ntype: {KINDS[data.dtype.str[1:]]}\ndimension: 3\nsizes: {sizes}\nendian: little\nspace: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n\n"
    with open(name, "wb") as file:
        file.write(head.encode() + data.tobytes())


def make_volumes(types):
    if np is None or sanitized():
        raise Skip("NumPy is not there" if np is None else "sanitizers hold memory of their own")
    z, y, x = np.meshgrid(*(np.linspace(-3, 3, n, dtype="f4") for n in SHAPE), indexing="ij")
    random = np.random.default_rng(7)
    amounts = 50 + 40 * np.sin(2 * x + y) * np.sin(3 * y) * np.sin(5 * z - x) + random.normal(0, 2, SHAPE)
    amounts = np.round(4 * amounts) / 4  # few numbers, for tables of them to be small beside so small a volume
    labels = (amounts > 60).astype("u1") + (amounts > 80)
    noise = random.integers(0, 2, SHAPE)
    for t in types:
        for name, data in (("@", amounts), ("@2", amounts // 2 + 3), ("#", labels), ("#2", 3 * labels + 1), ("~", noise)):
            write(f"{name}{t}.nrrd", data.astype("<" + t))


def words_of(name, line, kind):
    kinds = {"@": kind, "#": kind.replace("f", "u"), "~": kind.replace("f", "u")}  # labels are whole numbers
    return [name] + [f"{word}{kinds[word[0]]}.nrrd" if word[0] in kinds else word for word in line.split()]


def in_memory(words, memory):
    return volvis(*words, "-o", "part.nrrd", "--overwrite", "--threads", "2", "--encoding", "raw", "--memory", str(memory), "--json")


def same_in_part(words):
    """What cannot be done, as tables alone are larger, is refused before it begins."""
    ok(*words, "-o", "whole.nrrd", "--overwrite", "--threads", "2", "--encoding", "raw")
    part = in_memory(words, MEMORY)
    if part.code == 4:
        assert words[0] in TABLES, f"{words} does not stream: {part.message}"
        assert "more with --memory" in part.message and not os.path.exists("part.nrrd"), f"{words}: {part.message}"
        part = in_memory(words, 3 * MEMORY)
    assert part.code == 0 and part.json["streamed"], f"{words}: {part.message}"
    with open("whole.nrrd", "rb") as whole, open("part.nrrd", "rb") as file:
        assert whole.read() == file.read(), f"{words}: other bytes in little memory"
    os.remove("part.nrrd")


def test_every_operation_streams_in_little_memory_or_says_what_it_needs():
    make_volumes(TYPES)
    turn = 0
    for row in ok("schema", "--tables").json["operations"]:
        name = row["name"]
        if row["gives"] != "volume":
            continue
        assert name in STREAMS or name in WHOLE, f"{name} is in neither table of this test"
        for line in STREAMS.get(name, []):
            same_in_part(words_of(name, line, TYPES[turn % len(TYPES)]))
            turn += 1
        for line in WHOLE.get(name, []):
            words = words_of(name, line, "f4")
            done = volvis(*words, "-o", "none.nrrd", "--memory", str(MEMORY))
            assert done.code == 4 and f"{name} needs" in done.message and "the limit is" in done.message, f"{words}: {done.message}"
            assert not os.path.exists("none.nrrd")


def test_chains_of_five_make_the_same_bytes_of_all_types_and_time_steps():
    make_volumes(("u1", "i8", "u8", "f8", "f4"))
    ok("join", "@f4.nrrd", "@2f4.nrrd", "-o", "series.nrrd", "--encoding", "raw")
    for name, steps in (("@u1.nrrd", "gaussian --sigma 1vox | median | unsharp | clamp --range 10..80 | gradient"),
                        ("@i8.nrrd", "mean | dilate --radius 1vox | gradient --vector | channel --channel 1 | flip --axes z"),
                        ("@u8.nrrd", "median | components --range 60.. | close --radius 1vox | pad --all 2 | crop --z 3:"),
                        ("@f8.nrrd", "rescale --to 0..1 | gaussian --sigma 1vox | rescale --to 0..100 | laplacian | resample --spacing 1.5vox"),
                        ("series.nrrd", "gaussian --sigma 1vox | rescale --to 0..1 | erode --radius 1vox | clamp --range 0.1..0.9 | unsharp")):
        size = os.path.getsize(name)
        ok("pipe", name, steps, "-o", "whole.nrrd", "--overwrite", "--encoding", "raw")
        for share in (4, 8):
            words = ["pipe", name, steps]
            part = in_memory(words, size // share)
            if part.code == 4:  # tables of a fixed size may be too much for so little
                assert share == 8 or size < 8 * BYTES, part.message
                assert "needs" in part.message and "--memory" in part.message and not os.path.exists("part.nrrd"), part.message
                continue
            assert part.code == 0 and part.json["streamed"], f"{words}: {part.message}"
            with open("whole.nrrd", "rb") as whole, open("part.nrrd", "rb") as file:
                assert whole.read() == file.read(), f"{words}: other bytes in 1/{share} of the memory"
            os.remove("part.nrrd")


def test_what_goes_through_files_says_so_and_asks_for_room_before_it_begins():
    make_volumes(("f4",))
    words = ["pipe", "@f4.nrrd", "gaussian --sigma 1vox | median | gradient"]
    plan = in_memory(words + ["--dry-run"], BYTES)
    assert plan.code == 0 and plan.json["scratch_bytes"] == 2 * 4 * BYTES, plan.message
    done = volvis(*words, "-o", "part.nrrd", "--memory", str(BYTES), env={"TMPDIR": "/proc"})
    assert done.code != 0 and "temporary file" in done.message and "TMPDIR" in done.message, done.message
    assert not os.path.exists("part.nrrd")
    os.mkdir("tmp")
    before = sorted(os.listdir("."))
    with subprocess.Popen([VOLVIS, *words, "-o", "part.nrrd", "--memory", str(BYTES), "--progress", "json"], stderr=subprocess.PIPE,
                          env=environment(TMPDIR=os.path.abspath("tmp"))) as child:
        child.stderr.readline()  # it is at work
        child.send_signal(signal.SIGKILL)
    assert child.returncode != 0 and os.listdir("tmp") == []
    assert [name for name in sorted(os.listdir(".")) if not name.endswith(".part")] == before


def test_pieces_that_are_more_than_was_foretold_stream():
    if np is None or sanitized():
        raise Skip("NumPy is not there" if np is None else "sanitizers hold memory of their own")
    random = np.random.default_rng(3)
    for name, data in (("board", np.indices(SHAPE).sum(0) % 2), ("many", random.integers(0, 200, SHAPE))):  # a run, or a label, each voxel
        write(f"{name}.nrrd", data.astype("u1"))
        ok("components", f"{name}.nrrd", "-o", "whole.nrrd", "--overwrite", "--encoding", "raw")
        with open("whole.nrrd", "rb") as whole:
            want = whole.read()
        for memory in (11 * BYTES, 9 * BYTES, 6 * BYTES, 2 * BYTES):  # the first was to be in memory
            part = in_memory(["components", f"{name}.nrrd"], memory)
            assert part.code == 0 and part.json["streamed"], (name, memory // BYTES, part.message)
            with open("part.nrrd", "rb") as file:
                assert file.read() == want, (name, memory // BYTES)
    part = in_memory(["components", "many.nrrd"], BYTES // 4)
    assert part.code == 4 and "--memory" in part.message, part.message


def test_a_refusal_says_how_much_is_enough():
    make_volumes(("f4",))
    words = ["median", "@f4.nrrd", "--radius", "3vox"]
    for more in ([], ["--dry-run"]):
        done = in_memory(words + more, MEMORY)
        assert done.code == 4 and "median needs about" in done.message, done.message
    number, unit = done.message.split("needs about ")[1].split()[:2]
    assert in_memory(words, int(1.1 * float(number) * {"KiB": 1 << 10, "MiB": 1 << 20}[unit])).code == 0, done.message


def test_what_has_no_room_behind_passes_is_refused_before_they_begin():
    make_volumes(("f4",))
    words = ["pipe", "#f4.nrrd", "distance | median --radius 3vox"]
    for more in ([], ["--dry-run"]):  # passes would ask for a temporary file, of which there is none there
        done = volvis(*words, "-o", "part.nrrd", "--memory", str(MEMORY), *more, env={"TMPDIR": "/proc"})
        assert done.code == 4 and "needs about" in done.message, done.message
    number, unit = done.message.split("needs about ")[1].split()[:2]
    ok(*words, "-o", "whole.nrrd", "--threads", "2", "--encoding", "raw")
    part = in_memory(words, int(1.1 * float(number) * {"KiB": 1 << 10, "MiB": 1 << 20}[unit]))
    assert part.code == 0 and part.json["streamed"], part.message
    with open("whole.nrrd", "rb") as whole, open("part.nrrd", "rb") as file:
        assert whole.read() == file.read()


def test_nothing_is_left_of_distances_that_are_killed_or_have_no_room():
    make_volumes(("f4",))
    os.mkdir("tmp")
    env = environment(TMPDIR=os.path.abspath("tmp"))
    before = sorted(os.listdir("."))
    words = ["distance", "#f4.nrrd", "-o", "none.nrrd", "--memory", str(MEMORY)]
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
