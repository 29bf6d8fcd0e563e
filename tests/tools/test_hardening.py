"""The built programs and the library are hardened: addresses that move, tables that stay as they were linked, checked copies."""
import platform
import re
import subprocess
import sys

READELF, FILES = sys.argv[1], sys.argv[2:]
ENDBR64 = b"\xf3\x0f\x1e\xfa"


def told(path, *words):
    return subprocess.run([READELF, "-W", *words, path], check=True, capture_output=True, text=True).stdout


def sections(path):
    """Name -> (address, offset, size)."""
    row = re.compile(r"\[\s*\d+\] (\S+)\s+\S+\s+([0-9a-f]+) ([0-9a-f]+) ([0-9a-f]+)")
    return {m[1]: tuple(int(x, 16) for x in m.groups()[1:]) for m in row.finditer(told(path, "-S"))}


def test_addresses_move(path):
    assert re.search(r"Type:\s+DYN", told(path, "-h")), "has fixed addresses (not PIE)"


def test_tables_are_read_only_after_the_start(path):
    assert "GNU_RELRO" in told(path, "-l"), "has no segment that becomes read-only"
    assert re.search(r"\(FLAGS_1\).*\bNOW\b|\(BIND_NOW\)|\(FLAGS\).*BIND_NOW", told(path, "-d")), "binds lazily: RELRO is partial"
    assert ".got.plt" not in sections(path), "has a table of functions that stays writable"


def test_neither_stack_nor_data_are_code(path):
    rows = re.findall(r"^\s+(GNU_STACK|LOAD)\s.*?0x\S+ 0x\S+ ([RWE ]{3}) 0x", told(path, "-l"), re.M)
    assert any(kind == "GNU_STACK" for kind, _ in rows), "says nothing of its stack"
    assert not any("W" in flags and "E" in flags for _, flags in rows), "has memory that is written and run"


def test_no_library_is_looked_for_where_it_is_started(path):
    found = re.search(r"\((RPATH|RUNPATH)\).*\[(.*)\]", told(path, "-d"))
    for folder in found[2].split(":") if found else []:
        assert folder.startswith(("$ORIGIN", "/")), f"looks for libraries in '{folder}'"


def test_copies_and_stacks_are_checked(path):
    symbols = told(path, "--dyn-syms")
    wanted = ("__stack_chk_fail", "__memcpy_chk", "__snprintf_chk")
    for name in wanted[:1] if path.endswith("-gdcm.so") else wanted:  # the module is one file, which prints nothing
        assert name in symbols, f"does not use {name}"


def test_calls_through_pointers_land_at_functions(path):
    """Functions begin with endbr64, for CET: those that tables of the file point at, and those that a library exports. The
    mark of the file itself, without which nothing enforces it, needs start files of a C library that were built so, too."""
    if platform.machine() != "x86_64":
        return
    address, offset, size = sections(path)[".text"]
    with open(path, "rb") as file:
        file.seek(offset)
        code = file.read(size)
    pointers = [int(at, 16) for at in re.findall(r"R_X86_64_RELATIVE\s+([0-9a-f]+)", told(path, "-r"))]
    functions = [at - address for at in pointers if address <= at < address + size]
    assert functions, "has no pointers to functions"
    for at in functions:
        assert code[at:at + 4] == ENDBR64, f"a table points at {at + address:#x}, which does not begin with endbr64"
    if not path.split("/")[-1].startswith("lib"):
        return
    rows = re.findall(r":\s+([0-9a-f]+)\s+\d+ FUNC\s+GLOBAL\s+DEFAULT\s+\d+ (vv_\w+)", told(path, "--dyn-syms"))
    assert len(rows) > 100, "exports next to nothing"
    for at, name in rows:
        at = int(at, 16) - address
        assert code[at:at + 4] == ENDBR64, f"{name} does not begin with endbr64"


failed = 0
for name, test in [(n, f) for n, f in globals().items() if n.startswith("test_")]:
    for file in FILES:
        try:
            test(file)
        except AssertionError as error:
            print(f"[  FAILED  ] {name[5:]}: {file}: {error}")
            failed += 1
            continue
        print(f"[       OK ] {name[5:]}: {file.split('/')[-1]}")
sys.exit(1 if failed else 0)
