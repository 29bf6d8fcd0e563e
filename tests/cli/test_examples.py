"""Every example that the program's help shows is run as it stands."""
import os
import shlex
import shutil
import subprocess
from harness import VOLVIS, Result, ball_of, environment, main, ok, verbs, volvis, write_ball, write_cells, write_samples

BINDINGS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../examples/bindings.json")


def write_head():
    """A ball in the middle of 64 x 64 x 64 samples, which have places that examples name: small and hard, for distances."""
    ball, beside = ball_of(40), bytes(12)
    lines = [beside + ball[40 * i : 40 * i + 40] + beside for i in range(1600)]
    slices = [bytes(64 * 12) + b"".join(lines[40 * z : 40 * z + 40]) + bytes(64 * 12) for z in range(40)]
    write_samples("head.nrrd", (64, 64, 64), bytes(4096 * 12) + b"".join(slices) + bytes(4096 * 12))


def prepare():
    """The files that examples speak of."""
    write_head()
    write_ball("lobster.nrrd", 32)
    write_cells()
    for name in ("head.nii.gz", "t1.nii.gz", "act.nii.gz"):
        ok("convert", "head.nrrd", "-o", name)
    for name in ("pre.nrrd", "post.nrrd"):
        shutil.copy("lobster.nrrd", name)
    ok("join", "pre.nrrd", "post.nrrd", "-o", "series.nrrd")
    ok("threshold", "head.nrrd", "-o", "labels.nrrd", "--range", "100..")
    with open("session.jsonl", "w", encoding="ascii") as file:
        file.write('{"volvis session": 1, "world": {"schema": 1, "title": "empty"}}\n')
    shutil.copy(BINDINGS, "bindings.json")
    ok("isosurface", "head.nrrd", "-o", "skin.ply")
    ok("convert", "skin.ply", "-o", "copy.stl")
    ok("render", "head.nrrd", "-o", "a.png", "--size", "32x32")
    ok("render", "head.nrrd", "-o", "b.png", "--size", "32x32")
    ok("render", "a.png", "-o", "again.png")


def is_plain(example):
    """No shell is needed for words alone."""
    words = shlex.shlex(example, posix=True, punctuation_chars=True)
    words.whitespace_split = True
    return not any(set(word) <= set("();<>|&") for word in words) and not set(example) & set("$`*?~\\")


def run(example):
    if is_plain(example):
        return volvis(*shlex.split(example)[1:])
    line = example.replace("volvis ", shlex.quote(VOLVIS) + " ", 1)
    done = subprocess.run(["bash", "-c", line], capture_output=True, env=environment(), timeout=60)
    return Result(done.returncode, done.stdout, done.stderr)


def test_every_example_of_every_verb_runs():
    os.mkdir("files")
    os.chdir("files")
    prepare()
    tried = 0
    for verb in verbs():
        assert verb["examples"], f"{verb['name']} has no example"
        for example in verb["examples"]:
            shutil.copytree("../files", "../run", dirs_exist_ok=True)
            os.chdir("../run")
            assert example.startswith(f"volvis {verb['name']}"), example
            done = run(example)
            assert done.code == 0, f"{example}: exit {done.code}: {done.message}"
            os.chdir("../files")
            shutil.rmtree("../run")
            tried += 1
    assert tried >= 20, tried


def test_examples_of_the_manual_pages_are_the_same():
    for verb in verbs():
        page = ok("man", verb["name"]).text.replace("\\-", "-").replace("\\e", "\\")
        for example in verb["examples"]:
            assert example in page, example


main()
