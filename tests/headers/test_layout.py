#!/usr/bin/env python3
"""Where the members of public structs lie, as docs/decisions says they may change: compared with layout.txt.

    test_layout.py INCLUDE_FOLDER... -- COMPILER...          1 when they differ, and which changes break programs
    test_layout.py --write INCLUDE_FOLDER... -- COMPILER...  update layout.txt

A line is: struct member offset size; `=` stands for the whole struct.
"""
import os
import re
import subprocess
import sys
import tempfile

LIST = os.path.join(os.path.dirname(os.path.abspath(__file__)), "layout.txt")
STRUCT = re.compile(r"^(?:typedef )?struct (vv_\w+) \{\n(.*?)^\}", re.S | re.M)


def structs(folder):
    """(header, struct, members) of all headers; members in their order."""
    base = os.path.join(folder, "volvis")
    for path, _, files in sorted(os.walk(base)):
        for name in sorted(files):
            if name.endswith(".h"):
                with open(os.path.join(path, name), encoding="utf-8") as file:
                    text = re.sub(r"/\*.*?\*/", "", file.read(), flags=re.S)
                for struct, body in STRUCT.findall(text):
                    yield os.path.relpath(os.path.join(path, name), folder), struct, list(members(body))


def members(body):
    for declaration in body.split(";"):
        pointer = re.search(r"\(\*(\w+)\)", declaration)
        if pointer:
            yield pointer[1]
            continue
        for part in declaration.split(",") if declaration.strip() else []:
            name = re.search(r"(\w+)\s*(\[[^\]]*\]\s*)*$", part)
            yield name[1] + ("[]" if part.rstrip().endswith("[]") else "")


def program(found):
    lines = ["#include <stddef.h>", "#include <stdio.h>"]
    lines += [f"#include <{header}>" for header in dict.fromkeys(header for header, _, _ in found)]
    lines.append("int main(void)\n{")
    for _, struct, names in found:
        lines.append(f'printf("{struct} = 0 %zu\\n", sizeof(struct {struct}));')
        for name in names:
            plain = name.removesuffix("[]")
            size = "(size_t)0" if plain != name else f"sizeof(((struct {struct} *)0)->{plain})"
            lines.append(f'printf("{struct} {plain} %zu %zu\\n", offsetof(struct {struct}, {plain}), {size});')
    return "\n".join(lines) + "\n}\n"


def layout(folders, compiler):
    found = [row for folder in folders for row in structs(folder)]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "layout")
        includes = [word for name in folders for word in ("-I", name)]
        subprocess.run([*compiler, "-std=c17", *includes, "-x", "c", "-", "-o", path], input=program(found), check=True, text=True)
        lines = subprocess.run([path], check=True, capture_output=True, text=True).stdout.splitlines()
    return lines


def rows(lines):
    """By struct: its size, and its members in their order as (name, offset, size)."""
    out = {}
    for line in lines:
        struct, name, offset, size = line.split()
        if name == "=":
            out[struct] = (int(size), [])
        else:
            out[struct][1].append((name, int(offset), int(size)))
    return out


def grows(found):
    """Structs that say their size, or begin with an object: only the library takes memory for them."""
    return found[1][0][0] in ("size", "base")


def changes(old, new):
    """(struct, what, whether programs that exist would break)."""
    for struct in sorted(old.keys() | new.keys()):
        if struct not in old or struct not in new:
            yield struct, "is new" if struct in new else "is gone", struct in old
        elif old[struct] != new[struct]:
            kept = old[struct][1] == new[struct][1][: len(old[struct][1])]
            yield struct, "has more members at its end" if kept else "has members elsewhere", not (kept and grows(old[struct]))


def main(*words):
    write = words[0] == "--write"
    words = words[write:]
    split = words.index("--")
    lines = layout(words[:split], words[split + 1 :])
    if write:
        with open(LIST, "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
        print(f"{LIST}: {len(rows(lines))} structs")
        return 0
    with open(LIST, encoding="utf-8") as file:
        found = list(changes(rows(file.read().splitlines()), rows(lines)))
    for struct, what, breaks in found:
        print(f"{struct} {what}{': programs that were built before break' if breaks else ''}")
    if found:
        print("Is each of these meant (docs/decisions/0024-growing-structs.md)? Then update the list:")
        print(f"  python3 {os.path.relpath(__file__)} --write {' '.join(words)}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
