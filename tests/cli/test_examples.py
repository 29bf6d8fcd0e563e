"""Every example that the program's help shows is run as it stands."""
import os
import shlex
import shutil
import subprocess
from harness import VOLVIS, environment, main, ok, verbs, write_ball, write_cells

BINDINGS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../examples/bindings.json")


def prepare():
    """The files that examples speak of."""
    write_ball("head.nrrd", 64)
    write_ball("lobster.nrrd", 32)
    write_cells()
    ok("convert", "head.nrrd", "-o", "head.nii.gz")
    with open("session.jsonl", "w", encoding="ascii") as file:
        file.write('{"volvis session": 1, "world": {"schema": 1, "title": "empty"}}\n')
    shutil.copy(BINDINGS, "bindings.json")
    ok("isosurface", "head.nrrd", "-o", "skin.ply")
    ok("render", "head.nrrd", "-o", "a.png", "--size", "32x32")
    ok("render", "head.nrrd", "-o", "b.png", "--size", "32x32")
    ok("render", "a.png", "-o", "again.png")


def run(example):
    line = example.replace("volvis ", shlex.quote(VOLVIS) + " ", 1)
    return subprocess.run(["bash", "-c", line], capture_output=True, env=environment(), timeout=60)


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
            assert done.returncode == 0, f"{example}: exit {done.returncode}: {done.stderr.decode()}"
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
