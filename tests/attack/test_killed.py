"""Programs that are killed at any moment: what they write is the old file or the new one, whole.

    python3 tests/attack/test_killed.py build/volvis [TIMES]        TIMES: how often each is killed (10)
"""
import os
import random
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

from harness import VOLVIS, environment, main, ok, write_ball  # noqa: E402

TIMES = int(sys.argv[2]) if len(sys.argv) > 2 else 10
del sys.argv[2:]
DICE = random.Random(time.time_ns())


def all_of(path):
    """The bytes of a file; of a folder, of all that is in it."""
    if not os.path.isdir(path):
        with open(path, "rb") as file:
            return file.read()
    return {os.path.relpath(os.path.join(at, name), path): all_of(os.path.join(at, name)) for at, _, names in os.walk(path) for name in names}


def killed_while(words, out):
    """How often the old was there, the new, and what should not be."""
    def begin():
        return subprocess.Popen([VOLVIS, *words, "-o", out, "--overwrite"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment())
    ok(*old_words(words), "-o", out, "--overwrite")
    old = all_of(out)
    keep = shutil.copytree if os.path.isdir(out) else shutil.copy
    keep(out, "old")
    began = time.monotonic()
    assert begin().wait() == 0
    took, new = time.monotonic() - began, all_of(out)
    assert old != new
    found = {"old": 0, "new": 0}
    for _ in range(TIMES):
        (shutil.rmtree if os.path.isdir(out) else os.remove)(out)
        keep("old", out)
        process = begin()
        time.sleep(DICE.random() * took * 1.1)
        process.send_signal(signal.SIGKILL)
        process.wait()
        there = all_of(out)
        assert there in (old, new), f"{words}: {out} is torn"
        found["old" if there == old else "new"] += 1
    (shutil.rmtree if os.path.isdir("old") else os.remove)("old")
    left = [name for name in os.listdir(".") if name.endswith(".part")]
    for name in left:
        shutil.rmtree(name) if os.path.isdir(name) else os.remove(name)
    print(f"{' '.join(words)}: {TIMES} times killed: {found['old']} old, {found['new']} new, 0 torn, {len(left)} temporary left")


def old_words(words):
    return [word.replace("big.nrrd", "small.nrrd") for word in words]


def inputs():
    write_ball("small.nrrd", 16)
    write_ball("ball.nrrd", 48)
    ok("resample", "ball.nrrd", "--dims", "144,144,144", "-o", "big.nrrd")


def test_files_are_old_or_new():
    inputs()
    for words, out in ((["convert", "big.nrrd"], "out.nii.gz"), (["gaussian", "big.nrrd", "--sigma", "2"], "out.nrrd"), (["isosurface", "big.nrrd"], "out.ply"),
                       (["render", "big.nrrd", "--size", "300x300"], "out.png"), (["convert", "big.nrrd"], "out.ome.zarr")):
        killed_while(words, out)


if __name__ == "__main__":
    main()
