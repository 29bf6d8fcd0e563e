#!/usr/bin/env python3
"""The shared library exports what the public headers mark with VV_API, and nothing else.

    test_exports.py LIBRARY INCLUDE_FOLDER...
"""
import os
import re
import subprocess
import sys

DECLARATION = re.compile(r"^VV_API\b([^;{]*);", re.M)


def declared(folders):
    """Names of functions and data that the headers promise."""
    names = set()
    for path, _, files in (step for folder in folders for step in os.walk(folder)):
        for name in files:
            if not name.endswith(".h"):
                continue
            with open(os.path.join(path, name), encoding="utf-8") as file:
                text = re.sub(r"/\*.*?\*/", "", file.read(), flags=re.S)
            for body in DECLARATION.findall(text):
                function = re.search(r"\b(vv_\w+)\s*\(", body)
                names.update([function[1]] if function else re.findall(r"\b(vv_\w+)\s*(?:,|$)", body.strip()))
    return names


def exported(library):
    done = subprocess.run(["nm", "-D", "--defined-only", library], check=True, capture_output=True, text=True)
    return {line.split()[-1].split("@")[0] for line in done.stdout.splitlines()}


def main(library, *folders):
    promised, found = declared(folders), exported(library)
    # a sanitizer's runtime puts names of its own into the library
    extra = {name for name in found - promised if not re.match(r"_|__|asan|lsan|ubsan|tsan", name)}
    for name in sorted(promised - found):
        print(f"{name} is declared with VV_API but the library does not export it")
    for name in sorted(extra):
        print(f"{name} is exported but no public header declares it")
    print(f"{len(promised)} declared, {len(found)} exported")
    return 1 if promised - found or extra or not promised else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
