"""Hostile files: one sentence, at once, in little memory; and with --safe the same.

Each file of hostile_files.py is given to the program, every tenth again with --safe. Measured are the processor time and the
most memory that it held beyond what `volvis version` holds: how busy the machine is does not matter. VOLVIS_TABLE=1 prints a
line for each file, VOLVIS_ALL=1 tries all with --safe.
"""
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import zlib

import hostile_files
from harness import VOLVIS, Skip, environment, fails, main, sanitized

MOST_BEYOND = 64 << 20
MOST_SECONDS = 1.0  # of processor time, where pace() is 1
MOST_SECONDS_READ = 10.0  # what holds what it says takes its time
MOST_SECONDS_OF_WAITING = 120

SECONDS_OF_ZEROS = 0.25  # see pace()

# Honest but large: unpacked whole before it is known to be damaged. --memory and the limits bound it.
LARGE = {"chunk of 256 MiB from 256 KiB.h5"}


def pace():
    """How much slower than that of the figures this machine is, at least 1: by the time in which it unpacks 64 MiB of zeros."""
    packed, times = zlib.compress(bytes(1 << 24)), []
    for _ in range(3):
        begin = time.process_time()
        for _ in range(4):
            zlib.decompress(packed)
        times.append(time.process_time() - begin)
    return max(1, min(times) / SECONDS_OF_ZEROS)


def run_measured(*words):
    """Exit code, standard output and error, processor seconds, peak bytes, of the program and those that it waited for."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as said:
        process = subprocess.Popen([VOLVIS, *words], stdin=subprocess.DEVNULL, stdout=out, stderr=said, env=environment())
        resource.prlimit(process.pid, resource.RLIMIT_CPU, (30, 30))
        signal.signal(signal.SIGALRM, lambda *_: process.kill())
        signal.alarm(MOST_SECONDS_OF_WAITING)
        _, status, usage = os.wait4(process.pid, 0)
        signal.alarm(0)
        process.returncode = 0
        out.seek(0)
        said.seek(0)
        text, message = out.read().decode("utf-8", "replace"), said.read().decode("utf-8", "replace").strip()
    return os.waitstatus_to_exitcode(status), text, message, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024


# A process counts the memory of the one that it was forked from: here of a small one.
ALONE = """import os, subprocess, sys
process = subprocess.Popen(sys.argv[1:], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
_, status, usage = os.wait4(process.pid, 0)
process.returncode = 0
print(os.waitstatus_to_exitcode(status), usage.ru_maxrss * 1024)"""


def run_alone(*words):
    """Exit code, standard error, peak bytes, whatever this process holds itself."""
    done = subprocess.run([sys.executable, "-S", "-E", "-c", ALONE, VOLVIS, *words], env=environment(), capture_output=True, text=True, check=True)
    code, peak = map(int, done.stdout.split())
    return code, done.stderr.strip(), peak


def judge_refusal(code, message):
    lines = message.splitlines()
    if code not in (2, 3, 4):
        return [f"exit {code}: {message[-300:]!r}"]
    if not lines or not lines[-1].startswith("volvis: ") or any("warning" not in line for line in lines[:-1]):
        return [f"not one sentence: {message[:300]!r}"]
    return []


def judge_reading(name, code, text):
    """Read, whole (0) or in part (7): only what holds what it says, with the sizes that it has."""
    wanted = hostile_files.sizes_when_read(name)
    dims = tuple(json.loads(text)["dims"])
    if dims != wanted:
        return [f"is read as {dims} with exit {code}, not {wanted or 'refused'}"]
    return []


def is_long(code, seconds, slow=1):
    return seconds > slow * (MOST_SECONDS_READ if code in (0, 7) else MOST_SECONDS)


def judge(name, code, text, message, seconds, beyond, size, slow=1):
    """What is wrong with how a file was taken; an empty list is right."""
    read = code in (0, 7)
    wrong = judge_reading(name, code, text) if read else judge_refusal(code, message)
    if is_long(code, seconds, slow):
        wrong.append(f"{seconds:.2f} s of processor time")
    if beyond > MOST_BEYOND + 2 * size and name not in LARGE:
        wrong.append(f"{beyond / 2**20:.0f} MiB beyond the program itself, for {size} bytes")
    return wrong


def size_of(name):
    """Of a folder: all that is in it."""
    if os.path.isdir(name):
        return sum(os.path.getsize(os.path.join(at, file)) for at, _, files in os.walk(name) for file in files)
    return os.path.getsize(name)


def try_all(names, words):
    failed, slowest, largest, slow = [], 0, 0, pace()
    baseline = run_measured("version")[4]
    for name in names:
        size = size_of(name)
        code, text, message, seconds, peak = run_measured("info", "--stats", "--json", "--threads", "2", name, *words)
        beyond = max(0, peak - baseline)
        for _ in range(2):  # a busy machine counts more seconds than it works: what is long by itself is so three times
            if is_long(code, seconds, slow):
                seconds = min(seconds, run_measured("info", "--stats", "--json", "--threads", "2", name, *words)[3])
        wrong = judge(name, code, text, message, seconds, beyond, size, slow)
        if os.environ.get("VOLVIS_TABLE"):
            print(f"{size:10} {code:>3} {seconds:6.3f} s {beyond / 2**20:6.1f} MiB  {name}: {message[:150]}")
        failed += [f"{name}: {'; '.join(wrong)}"] if wrong else []
        if name not in LARGE:
            slowest, largest = max(slowest, seconds), max(largest, beyond)
    print(f"{len(names)} files {' '.join(words)}: slowest {slowest:.2f} s of processor time, most {largest / 2**20:.1f} MiB beyond the program itself")
    assert not failed, "\n".join(failed)


def test_hostile_files_are_refused_at_once_in_little_memory():
    if sanitized():
        raise Skip("times and memory are promised of builds without sanitizers")
    maker = os.path.join(os.path.dirname(os.path.abspath(__file__)), "hostile_files.py")
    os.mkdir("files")
    subprocess.run([sys.executable, maker, "files"], check=True)
    os.chdir("files")
    names = sorted(os.listdir("."))
    assert len(names) >= 300
    try_all(names, [])
    try_all(names[::1 if os.environ.get("VOLVIS_ALL") else 10], ["--safe"])


def test_what_is_unpacked_to_disk_is_limited():
    """Formats that are read here and there want a temporary file of what is packed."""
    with open("bomb.tif.gz", "wb") as file:
        file.write(hostile_files.zeros_deflate(b"II*\0\x08\0\0\0\0\0", 512, 31))
    for words in ([], ["--safe"]):
        said = fails(3, "info", "bomb.tif.gz", "--limit", "import_spool=64M", *words)
        assert "--limit import_spool=N" in said, said


def test_what_would_be_wrong_is_seen():
    """The judge itself: each thing that a file must not do."""
    sentence, small = "volvis: it is damaged", 1 << 20
    good, other = '{"dims": [4, 4, 4]}', '{"dims": [4, 4, 5]}'
    assert not judge("x", 3, "", sentence, 0.1, small, 6)
    assert not judge("data file is itself.nrrd", 0, good, "", 0.1, small, 6)
    for wrong in (judge("x", -11, "", "", 0.1, small, 6), judge("x", 3, "", "", 0.1, small, 6),
                  judge("x", 3, "", "more\n" + sentence, 0.1, small, 6), judge("x", 3, "", sentence, 1.1, small, 6),
                  judge("x", 3, "", sentence, 0.1, 65 << 20, 6), judge("x", 0, good, "", 0.1, small, 6),
                  judge("data file is itself.nrrd", 7, other, "", 0.1, small, 6)):
        assert len(wrong) == 1, wrong


if __name__ == "__main__":
    main()
