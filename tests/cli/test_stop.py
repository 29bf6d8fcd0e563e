"""Stopping: Ctrl-C, SIGTERM, closed pipes, full disks."""
from contextlib import contextmanager
import fcntl
import os
import select
import signal
import struct
import subprocess
import termios
import time
from harness import VOLVIS, environment, main, ok, says, volvis, write_ball, write_large

PATIENCE = 60  # seconds for what must come: nobody is so slow


def hang_up_ends():
    """In the child: whoever runs the tests may be deaf to SIGHUP, as under nohup, and that is inherited."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@contextmanager
def started(*words, preexec_fn=hang_up_ends, **options):
    """The program; it ends with the test, however that goes."""
    process = subprocess.Popen([VOLVIS, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, bufsize=0,
                               env=environment(), preexec_fn=preexec_fn, **options)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def wait_until(what, process, told):
    end = time.monotonic() + PATIENCE
    while not what():
        assert process.poll() is None, f"it has ended before {told}: {process.communicate()}"
        assert time.monotonic() < end, f"waited for {PATIENCE} s until {told}"
        time.sleep(0.005)


def wait_until_it_works_on(process, stage):
    """Until the program, which tells its progress as JSON, is in the midst of this."""
    said, end = b"", time.monotonic() + PATIENCE
    while f'"stage": "{stage}'.encode() not in said:
        assert select.select([process.stderr], [], [], max(0, end - time.monotonic()))[0], f"no {stage} for {PATIENCE} s: {said}"
        piece = os.read(process.stderr.fileno(), 65536)
        assert piece, f"it has ended before it came to {stage}: {said}"
        said += piece


def has_handler(process, sent):
    with open(f"/proc/{process.pid}/status", encoding="ascii") as status:
        caught = next(int(line.split()[1], 16) for line in status if line.startswith("SigCgt:"))
    return caught >> (sent - 1) & 1


def awaits_more(process):
    """It has read what was written to it, and sleeps."""
    (left,) = struct.unpack("i", fcntl.ioctl(process.stdin, termios.FIONREAD, b"\0" * 4))
    with open(f"/proc/{process.pid}/stat", encoding="ascii") as stat:
        return left == 0 and stat.read().rsplit(")", 1)[1].split()[0] == "S"


def check_stopped(stage, *words, sent=signal.SIGINT):
    """Stopped in the midst of a stage, it ends with 130 and leaves nothing. The work would take long: it is not done here."""
    before = set(os.listdir("."))
    with started(*words, "--threads", "1", "--progress", "json") as process:
        wait_until_it_works_on(process, stage)
        process.send_signal(sent)
        said = process.communicate(timeout=PATIENCE)[1].decode()
        assert process.returncode == 130, (process.returncode, said)
    assert said.count("volvis:") <= 2, said
    assert set(os.listdir(".")) == before, f"left behind: {set(os.listdir('.')) - before}"


def check_filter_stopped(sent=signal.SIGINT):
    check_stopped("smooth", "gaussian", "a.nrrd", "-o", "b.nrrd", "--sigma", "40vox", sent=sent)


def test_ctrl_c_within_a_filter_keeps_nothing_half_made():
    write_large("a.nrrd", 256)
    check_filter_stopped()


def test_sigterm_stops_in_the_same_way():
    write_large("a.nrrd", 256)
    check_filter_stopped(signal.SIGTERM)


def test_a_closed_terminal_stops_in_the_same_way_but_not_under_nohup():
    write_large("a.nrrd", 256)
    check_filter_stopped(signal.SIGHUP)
    write_ball()
    with started("gaussian", "-", "-o", "b.nrrd", "--sigma", "9vox", stdin=subprocess.PIPE,
                 preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)) as process:
        with open("head.nrrd", "rb") as file:
            ball = file.read()
        process.stdin.write(ball[:100])
        wait_until(lambda: has_handler(process, signal.SIGINT) and awaits_more(process), process, "it reads")
        process.send_signal(signal.SIGHUP)
        said = process.communicate(ball[100:], timeout=PATIENCE)
        assert process.returncode == 0 and os.path.exists("b.nrrd"), said


def test_ctrl_c_within_a_picture_keeps_nothing_half_made():
    write_large("a.nrrd", 128)
    check_stopped("render", "render", "a.nrrd", "-o", "a.png", "--size", "8000x8000", "--tf", "0:0 255:0.001")


def test_ctrl_c_keeps_the_whole_passes_of_a_picture():
    write_ball()
    with started("render", "head.nrrd", "-o", "a.png", "--size", "100", "--budget", "60s") as process:
        wait_until(lambda: has_handler(process, signal.SIGINT), process, "it renders")
        time.sleep(0.7)
        process.send_signal(signal.SIGINT)
        out, said = process.communicate(timeout=PATIENCE)
        assert process.returncode == 130, (out, said)
        assert b"interrupted: the picture of" in said and b"was written" in said, said
    ok("render", "a.png", "-o", "b.png")  # it is repeated by its number of passes
    assert ok("compare", "a.png", "b.png", "--json").json["identical"]


LONG = ("render", "head.nrrd", "-o", "a.png", "--size", "400", "--spp", "40")


def stop_with_checkpoint(*words):
    with started(*words, "--progress", "json") as process:
        wait_until_it_works_on(process, "render")
        process.send_signal(signal.SIGINT)
        out, said = process.communicate(timeout=PATIENCE)
        assert process.returncode == 75, (process.returncode, out, said)
        return out.decode()


def test_a_stopped_picture_goes_on_with_the_same_bytes():
    write_ball()
    says(stop_with_checkpoint(*LONG, "--resume", "a.part"), "a.part: stopped with", "goes on from there")
    assert not os.path.exists("a.png")
    with open("a.part", "rb") as file:
        kept = file.read()
    says(volvis(*LONG, "--resume", "a.part", "--view", "left").message, "a.part", "another picture")
    with open("a.part", "wb") as file:
        file.write(kept[:len(kept) // 2])
    says(volvis(*LONG, "--resume", "a.part").message, "a.part", "cut")
    with open("a.part", "wb") as file:
        file.write(kept)
    assert ok(*LONG, "--resume", "a.part", "--threads", "1", "--json").json["resumed"]
    assert not os.path.exists("a.part")
    ok(*LONG[:3], "b.png", *LONG[4:])
    with open("a.png", "rb") as one, open("b.png", "rb") as other:
        assert one.read() == other.read()


def test_a_picture_killed_while_its_checkpoint_is_written_leaves_the_last_one():
    write_ball()
    stop_with_checkpoint(*LONG, "--resume", "a.part")
    for wait in (0, 0.002, 0.01, 0.03):
        with started(*LONG, "--resume", "a.part", "--progress", "json") as process:
            wait_until_it_works_on(process, "render")
            process.send_signal(signal.SIGINT)  # it saves
            time.sleep(wait)
            process.kill()
            process.wait(timeout=PATIENCE)
        assert ok(*LONG[:2], "-o", "c.png", *LONG[4:], "--resume", "a.part", "--dry-run").code == 0
        assert os.path.exists("a.part")
    assert ok(*LONG, "--resume", "a.part", "--json").json["resumed"]


def test_the_first_checkpoint_comes_soon():
    write_ball()
    with started(*LONG[:-1], "4000", "--resume", "a.part", "--progress", "json") as process:
        wait_until_it_works_on(process, "render")
        began = time.monotonic()
        wait_until(lambda: os.path.exists("a.part"), process, "it has saved")
        assert time.monotonic() - began < 4, "it comes after a second"
        process.kill()
        process.wait(timeout=PATIENCE)
    with started(*LONG[:-1], "4000", "--resume", "a.part", "--progress", "json") as process:
        wait_until_it_works_on(process, "render")
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=PATIENCE)
        assert process.returncode == 75, said


def test_what_cannot_be_resumed_is_said_first():
    write_ball()
    for words, said in ((["--repeat", "2"], "--repeat"), (["-o", "a.svg"], "SVG")):
        says(volvis("render", "head.nrrd", "-o", "a.png", "--resume", "a.part", *words).message, said)
    says(volvis("render", "head.nrrd", "head.nrrd", "-o", "{stem}.png", "--resume", "a.part").message, "{stem}")
    says(volvis("render", "head.nrrd", "-o", "a.png", "--resume", "head.nrrd").message, "head.nrrd", "no checkpoint")
    ok("render", "head.nrrd", "-o", "{stem}.png", "--size", "50", "--resume", "{stem}.part")


def test_ctrl_c_while_standard_input_is_awaited():
    for words in (["info", "-"], ["convert", "-", "-o", "a.nrrd"], ["render", "-", "-o", "a.png"]):
        for first in (b"", b"NRRD0004\n"):
            with started(*words, stdin=subprocess.PIPE) as process:
                process.stdin.write(first)
                wait_until(lambda: has_handler(process, signal.SIGINT) and awaits_more(process), process, "it reads")
                process.send_signal(signal.SIGINT)
                process.wait(timeout=PATIENCE)
                assert process.returncode == 130, (words, first)


def test_the_old_output_stays_when_the_work_is_stopped():
    write_large("a.nrrd", 256)
    with open("b.nrrd", "wb") as file:
        file.write(b"what was there before")
    check_filter_stopped()
    with open("b.nrrd", "rb") as file:
        assert file.read() == b"what was there before"


def test_whoever_closes_the_pipe_ends_it_as_it_ends_others():
    for words in (("help", "render"), ("schema",), ("info", "head.nrrd", "--json"), ("measure", "statistics", "head.nrrd")):
        write_ball()
        reader, writer = os.pipe()
        os.close(reader)  # before it begins, so that what it writes is read by nobody
        done = subprocess.run([VOLVIS, *words], stdout=writer, stderr=subprocess.PIPE, env=environment())
        os.close(writer)
        assert done.stderr == b"" and done.returncode == 141, words


def test_a_full_disk_is_said_and_ends_with_five():
    if not os.path.exists("/dev/full"):
        return
    write_ball()
    with open("/dev/full", "wb") as full:
        done = subprocess.run([VOLVIS, "info", "head.nrrd"], stdout=full, stderr=subprocess.PIPE, env=environment())
    assert done.returncode == 5
    says(done.stderr.decode(), "standard output")


def test_a_folder_that_cannot_be_written_is_said_first():
    if os.geteuid() == 0:
        os.mkdir("sealed")
        result = volvis("convert", "absent.nrrd", "-o", "sealed/../none/a.nrrd")
        assert result.code == 5
        return
    write_ball()
    os.mkdir("sealed", 0o500)
    result = volvis("convert", "head.nrrd", "-o", "sealed/a.nrrd")
    assert result.code == 5
    says(result.message, "sealed")


main()
