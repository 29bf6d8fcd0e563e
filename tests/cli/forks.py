"""A program that is started once and run many times, through libforks (forks.c): a run costs a fork in the place of the
40 ms that loading 75 libraries takes. Where there is no libforks beside the program's tests, and with VOLVIS_STARTS=each,
every run is a start of its own.
"""
import array
import atexit
import os
import selectors
import signal
import socket
import struct
import subprocess
import time

ANSWER = struct.Struct("=qq")


class Runs:
    """One program, ready to be run; not for several threads at once."""

    def __init__(self, program, library, environment):
        self.program = program
        self.socket, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        preload = {**environment, "LD_PRELOAD": library, "LIBFORKS_SOCKET": str(far.fileno())}
        self.process = subprocess.Popen([program], env=preload, stdin=subprocess.DEVNULL, pass_fds=[far.fileno()])
        far.close()
        atexit.register(self.end)

    def end(self):
        self.socket.close()
        self.process.wait()

    def run(self, words, stdin, env, timeout):
        """Returns code, output and errors, as subprocess.run() tells them."""
        pipes = [os.pipe() for _ in range(3)]
        theirs = [pipes[0][0], pipes[1][1], pipes[2][1]]
        ours = [pipes[0][1], pipes[1][0], pipes[2][0]]
        try:
            self.ask(words, env, theirs)
        finally:
            for fd in theirs:
                os.close(fd)
        pid = self.answer()[0]
        try:
            out, err = talk(*ours, stdin, time.monotonic() + timeout)
        except TimeoutError:
            os.kill(pid, signal.SIGKILL)
            self.answer()
            raise subprocess.TimeoutExpired([self.program, *words], timeout) from None
        finally:
            for fd in ours[1:]:
                os.close(fd)
        return os.waitstatus_to_exitcode(self.answer()[1]), out, err

    def ask(self, words, env, descriptors):
        texts = [os.getcwd(), str(len(words) + 1), self.program, *words, *(f"{name}={value}" for name, value in env.items())]
        if any("\0" in text for text in texts):
            raise ValueError("embedded null byte")
        message = b"".join(os.fsencode(text) + b"\0" for text in texts)
        rights = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", descriptors))]
        self.socket.sendmsg([struct.pack("=I", len(message))], rights)
        self.socket.sendall(message)

    def answer(self):
        got = b""
        while len(got) < ANSWER.size:
            piece = self.socket.recv(ANSWER.size - len(got))
            assert piece, f"{self.program} with libforks ended with {self.process.wait()}"
            got += piece
        return ANSWER.unpack(got)


def talk(into, out, err, data, deadline):
    """Write and read until the other end has closed what is read; closes `into`."""
    texts = {out: [], err: []}
    data = memoryview(data)
    os.set_blocking(into, False)
    with selectors.DefaultSelector() as waiting, open(into, "wb", 0) as writing:
        for fd in texts:
            waiting.register(fd, selectors.EVENT_READ)
        if data:
            waiting.register(into, selectors.EVENT_WRITE)
        else:
            writing.close()
        while waiting.get_map():
            if time.monotonic() > deadline:
                raise TimeoutError
            for key, _ in waiting.select(max(0, deadline - time.monotonic())):
                if key.fd == into:
                    data = write_some(into, data)
                    if not data:
                        waiting.unregister(into)
                        writing.close()
                elif piece := os.read(key.fd, 1 << 18):
                    texts[key.fd].append(piece)
                else:
                    waiting.unregister(key.fd)
    return b"".join(texts[out]), b"".join(texts[err])


def write_some(fd, data):
    try:
        return data[os.write(fd, data):]
    except BlockingIOError:
        return data
    except BrokenPipeError:
        return b""
