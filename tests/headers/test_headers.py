#!/usr/bin/env python3
"""Each public header compiles alone, without a warning.

    test_headers.py LANGUAGE STANDARD INCLUDE_FOLDER... -- COMPILER...
"""
import os
import subprocess
import sys


def headers(folder):
    for path, _, files in sorted(os.walk(folder)):
        for name in sorted(files):
            if name.endswith(".h") and os.path.basename(path) in ("volvis", "sys"):
                yield os.path.relpath(os.path.join(path, name), folder)


def main(language, standard, *rest):
    split = rest.index("--")
    folders, compiler = rest[:split], rest[split + 1 :]
    includes = [word for folder in folders for word in ("-I", folder)]
    flags = ["-fsyntax-only", "-Wall", "-Wextra", "-Werror"]
    if language == "c":
        flags.append("-Wpedantic")  # C++ has arrays of open length only as an extension
    failures, count = 0, 0
    for header in sorted({name for folder in folders for name in headers(folder)}):
        command = [*compiler, standard, *includes, "-x", language, *flags, "-"]
        done = subprocess.run(command, input=f"#include <{header}>\n", capture_output=True, text=True)
        count += 1
        failures += done.returncode != 0
        name = f"{header}_alone_as_{language}"
        print(f"[  FAILED  ] {name}\n{done.stderr}" if done.returncode else f"[       OK ] {name}", flush=True)
    return 1 if failures or not count else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
