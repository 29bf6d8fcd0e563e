"""What the oracle scripts share: one io_tool that answers for all files, and a folder in memory.

Starting io_tool costs more than reading a small file, so it is started once and asked line by line.
"""
import json
import os
import subprocess
import tempfile

try:
    import numpy as np
except ImportError:
    np = None  # the scripts say so

# in memory where the machine has such: what is written is synced
MEMORY = "/dev/shm" if os.path.isdir("/dev/shm") else None


def workplace():
    return tempfile.TemporaryDirectory(prefix="volvis-oracle-", dir=MEMORY)


class Tool:
    """io_tool serve. When it dies, what it was asked has failed with its last words, and another one is started."""

    def __init__(self, program, *words):
        self.command = [program, "serve", *words]
        self.process = None
        self.folder = workplace()  # never beside what is read
        self.out = os.path.join(self.folder.name, "samples")
        self.errors = open(os.path.join(self.folder.name, "errors"), "a+b")  # both ends write at its end

    def start(self):
        self.process = subprocess.Popen(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.errors,
                                        text=True)

    def ask(self, *words):
        """The exit code of io_tool with these words, and what it writes to its standard output and error."""
        if self.process is None:
            self.start()
        assert not any(c in word for word in words for c in "\t\n"), f"{words} are no words of a line"
        begin = self.errors.seek(0, os.SEEK_END)
        try:
            self.process.stdin.write("\t".join(words) + "\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            pass  # it has died; its exit code comes below
        lines = []
        for line in self.process.stdout:
            if line.startswith("done "):
                return int(line[5:]), "".join(lines), self.said_since(begin)
            lines.append(line)
        code, self.process = self.process.wait(), None
        return code, "".join(lines), f"io_tool {' '.join(words)} ended with {code}: " + self.said_since(begin)

    def said_since(self, begin):
        self.errors.seek(begin)
        return self.errors.read().decode("utf-8", "replace")

    def read(self, path, part=""):
        """The info, and values as [t, z, y, x, c] of float64. Or None and the error."""
        return self.written("dump", path, part)

    def samples(self, path, part=""):
        """The same as they are stored, without scale."""
        return self.written("stored", path, part)

    def narrow(self, path, part=""):
        """Values in the type of the samples, for large files, where no scale makes other numbers of them."""
        info, values = self.samples(path, part)
        if info and (info["scale"], info["offset"]) != (1, 0):
            values = values * info["scale"] + info["offset"]
        return info, values

    def written(self, verb, path, part):
        code, text, error = self.ask(verb, path, self.out, part)
        if code != 0:
            return None, error.strip()
        info = json.loads(text)
        x, y, z = info["dims"]
        kind = "f8" if verb == "dump" else info["type"][0] + str(int(info["type"][1:]) // 8)
        return info, np.fromfile(self.out, kind).reshape(info["frames"], z, y, x, info["components"])

    def end(self):
        """Whether it ended well: one that is built to find leaks tells them now."""
        code = 0
        if self.process is not None:
            self.process.stdin.close()
            code, self.process = self.process.wait(), None
        if code != 0:
            print(f"io_tool ended with {code}: {self.said_since(0)}")
        self.errors.close()
        self.folder.cleanup()
        return code == 0
