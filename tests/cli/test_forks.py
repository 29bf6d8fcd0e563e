"""A forked run is as a start: what libforks does for the other tests must not be what they see."""
import os
import subprocess

import harness
from harness import VOLVIS, Skip, environment, main, volvis, write_ball, write_large


def both(*words, stdin=b"", env=None):
    """The forked run, which is compared with a start."""
    if not harness.runs():
        raise Skip("there is no libforks beside the program")
    forked = volvis(*words, stdin=stdin, env=env)
    started = subprocess.run([VOLVIS, *words], input=stdin, capture_output=True, env=environment(**(env or {})))
    assert (forked.code, forked.err) == (started.returncode, started.stderr), (words, forked.code, forked.err, started.returncode, started.stderr)
    assert forked.out == started.stdout, "standard output differs"
    return forked


def test_words_codes_and_sentences_are_those_of_a_start():
    assert both("version").code == 0
    assert both("help", "--json").out.startswith(b"{")
    assert both("info", "missing.nrrd").code != 0
    assert both("info", "a b  c\n\"'é.nrrd").code != 0
    assert both().code == volvis().code


def test_folder_and_environment_are_those_of_each_run():
    write_ball("head.nrrd", 8)
    os.mkdir("there")
    assert both("info", "head.nrrd").code == 0
    os.chdir("there")
    assert both("info", "head.nrrd").code != 0
    assert both("info", "../head.nrrd", env={"VOLVIS_THREADS": "nonsense"}).code == 2
    assert both("info", "../head.nrrd", env={"VOLVIS_CPU": "base"}).code == 0


def test_input_and_output_of_any_size_go_through():
    write_large("large.nrrd", 160)
    with open("large.nrrd", "rb") as file:
        data = file.read()
    words = ("convert", "-", "--input-format", "nrrd", "-o", "-", "--output-format", "raw", "-q")
    assert len(both(*words, stdin=data).out) == 160**3
    assert both(*words, stdin=data[:100]).code != 0
    assert both("version", stdin=data).code == 0, "input that nobody reads"


def test_a_run_that_does_not_end_is_ended():
    if not harness.runs():
        raise Skip("there is no libforks beside the program")
    os.mkfifo("waits.raw")
    try:
        volvis("info", "waits.raw", timeout=0.2)
    except subprocess.TimeoutExpired:
        pass
    assert volvis("version").code == 0, "the next run is as if nothing had been"


if __name__ == "__main__":
    main()
