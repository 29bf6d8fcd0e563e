"""Stopping: Ctrl-C, SIGTERM, closed pipes, full disks."""
import os
import signal
import subprocess
import time
from harness import VOLVIS, environment, main, says, volvis, write_ball, write_large


def hang_up_ends():
    """In the child: whoever runs the tests may be deaf to SIGHUP, as under nohup, and that is inherited."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def start(*words, preexec_fn=hang_up_ends, **options):
    return subprocess.Popen([VOLVIS, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            env=environment(), preexec_fn=preexec_fn, **options)


def wait_until_caught(process, sent):
    """Until the program has its handler: on a busy machine it takes a while to come up."""
    while process.poll() is None:
        with open(f"/proc/{process.pid}/status", encoding="ascii") as status:
            caught = next(int(line.split()[1], 16) for line in status if line.startswith("SigCgt:"))
        if caught >> (sent - 1) & 1:
            return
        time.sleep(0.01)


def interrupt(process, after_s, sent=signal.SIGINT):
    """Seconds until the program was gone, and what it said; it is stopped so long after it listens."""
    wait_until_caught(process, sent)
    time.sleep(after_s)
    assert process.poll() is None, f"it was done before it could be stopped: {process.communicate()}"
    began = time.monotonic()
    process.send_signal(sent)
    _, err = process.communicate(timeout=30)
    return time.monotonic() - began, err.decode()


def check_stopped(process, folder_before, sent=signal.SIGINT, after_s=0.4):
    took, said = interrupt(process, after_s, sent)
    assert process.returncode == 130, (process.returncode, said)
    assert took < 10, f"it took {took:.2f} s"  # a stop, not the work: sanitizers and busy machines are slow
    assert "Traceback" not in said and said.count("volvis:") <= 2, said
    assert set(os.listdir(".")) == folder_before, f"left behind: {set(os.listdir('.')) - folder_before}"


def test_ctrl_c_within_a_filter_keeps_nothing_half_made():
    write_large("a.nrrd", 256)
    before = set(os.listdir("."))
    check_stopped(start("gaussian", "a.nrrd", "-o", "b.nrrd", "--sigma", "40vox", "--threads", "1"), before)


def test_sigterm_stops_in_the_same_way():
    write_large("a.nrrd", 256)
    before = set(os.listdir("."))
    check_stopped(start("gaussian", "a.nrrd", "-o", "b.nrrd", "--sigma", "40vox", "--threads", "1"), before,
                  sent=signal.SIGTERM)


def test_a_closed_terminal_stops_in_the_same_way_but_not_under_nohup():
    write_large("a.nrrd", 256)
    before = set(os.listdir("."))
    check_stopped(start("gaussian", "a.nrrd", "-o", "b.nrrd", "--sigma", "40vox", "--threads", "1"), before,
                  sent=signal.SIGHUP)
    process = start("gaussian", "a.nrrd", "-o", "b.nrrd", "--sigma", "9vox",
                    preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    time.sleep(0.2)
    process.send_signal(signal.SIGHUP)
    process.communicate(timeout=100)
    assert process.returncode == 0 and os.path.exists("b.nrrd")


def test_ctrl_c_within_a_picture_keeps_nothing_half_made():
    write_large("a.nrrd", 128)
    before = set(os.listdir("."))
    check_stopped(start("render", "a.nrrd", "-o", "a.png", "--size", "8000x8000", "--tf", "0:0 255:0.001", "--threads", "1"),
                  before, after_s=1.0)


def test_ctrl_c_while_standard_input_is_awaited():
    for words in (["info", "-"], ["convert", "-", "-o", "a.nrrd"], ["render", "-", "-o", "a.png"]):
        process = start(*words, stdin=subprocess.PIPE)
        wait_until_caught(process, signal.SIGINT)
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        process.wait(timeout=10)
        assert process.returncode == 130, words
        process.stdin.close()


def test_the_old_output_stays_when_the_work_is_stopped():
    write_large("a.nrrd", 256)
    with open("b.nrrd", "wb") as file:
        file.write(b"what was there before")
    before = set(os.listdir("."))
    check_stopped(start("gaussian", "a.nrrd", "-o", "b.nrrd", "--sigma", "40vox", "--threads", "1"), before)
    with open("b.nrrd", "rb") as file:
        assert file.read() == b"what was there before"


def test_a_closed_pipe_is_no_complaint():
    process = start("help", "render")
    process.stdout.close()
    process.wait(timeout=10)
    assert process.stderr.read() == b"" and process.returncode in (0, 5)


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
