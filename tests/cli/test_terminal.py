"""On a terminal: progress bars, colours, widths. The terminal is a pseudo-terminal of our own."""
import fcntl
import os
import pty
import struct
import subprocess
import termios
from harness import VOLVIS, environment, main, says, write_ball, write_large


def on_terminal(*words, columns=100, env=None):
    """What appears on a terminal that is both outputs, and the exit code."""
    near, far = pty.openpty()
    fcntl.ioctl(far, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
    process = subprocess.Popen([VOLVIS, *words], stdin=subprocess.DEVNULL, stdout=far, stderr=far,
                               env=environment(**{"TERM": "xterm", **(env or {})}))
    os.close(far)
    text = b""
    while True:
        try:
            piece = os.read(near, 65536)
        except OSError:
            break
        if not piece:
            break
        text += piece
    os.close(near)
    return text.decode(), process.wait(timeout=60)


def long_work():
    """What appears for work that is long here; the bar waits a third of a second for work to prove so."""
    for n in (128, 256, 512):  # a machine as quick as that is still to be made
        write_large("a.nrrd", n)
        text, code = on_terminal("gaussian", "a.nrrd", "-o", "b.nrrd", "--sigma", "40vox", "--threads", "1")
        assert code == 0, text
        if "[#" in text:
            break
    return text


def test_a_long_work_shows_a_bar_and_takes_it_away():
    text = long_work()
    says(text, "gaussian", "smooth", "[#", "%")
    assert text.rindex("\r\033[K") > text.rindex("] ") and "written" in text.split("\r\033[K")[-1]


def test_quiet_shows_no_bar():
    says(long_work(), "[#")
    text, code = on_terminal("gaussian", "a.nrrd", "-o", "c.nrrd", "--sigma", "40vox", "--threads", "1", "-q")
    assert code == 0 and "[#" not in text


def test_an_error_is_red_unless_no_color_is_wanted():
    text, code = on_terminal("rendr")
    assert code == 2 and "\033[1;31mvolvis:" in text
    for env in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
        text, code = on_terminal("rendr", env=env)
        assert code == 2 and "\033" not in text


def test_help_is_as_wide_as_the_terminal():
    wide, _ = on_terminal("help", columns=110)
    narrow, _ = on_terminal("help", columns=60)
    assert max(len(line) for line in wide.splitlines()) > 80
    assert max(len(line) for line in narrow.splitlines()) <= 60


def test_a_picture_is_not_thrown_at_a_terminal():
    write_ball()
    text, code = on_terminal("render", "head.nrrd", "-o", "-")
    assert code == 2 and "PNG" not in text
    says(text, "standard output is a terminal")


main()
