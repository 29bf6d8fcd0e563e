"""tools/fuzz-whose: a library's own findings are told apart, and none of ours is taken for one."""
import os
import subprocess
import sys
import tempfile

TOOL = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tools", "fuzz-whose")

H5 = "(/lib/x86_64-linux-gnu/libhdf5_serial.so.103+0x1233e4) (BuildId: e9)"
MALLOC = "    #0 0x56 in malloc (/work/build-fuzz/tests/fuzz/fuzz_hdf5+0xfc09be)"
IN_LIBRARY = f"    #1 0x7f  {H5}"
IN_OURS = "    #1 0x55 in read_rows /work/src/io/formats/hdf5/hdf5_read.c:120:9"
CALLER = "    #2 0x55 in vvi_h5_read /work/src/io/formats/hdf5/hdf5.c:88:12"
COPY = "    #0 0x56 in __asan_memcpy (/work/build-fuzz/tests/fuzz/fuzz_hdf5+0xfc)"


def leak(*frames):
    return "\n".join(["Direct leak of 16 byte(s) in 1 object(s) allocated from:", MALLOC, *frames, ""])


def log(*parts):
    return "\n".join(["#20 NEW cov: 3153", *parts, "SUMMARY: ..."])


LEAKS = "==1==ERROR: LeakSanitizer: detected memory leaks\n"
OVERFLOW = "==1==ERROR: AddressSanitizer: heap-buffer-overflow on address 0x60\nWRITE of size 8 at 0x60 thread T0"
TIMEOUT = "==1== ERROR: libFuzzer: timeout after 10 seconds\n    #0 0x56 in __sanitizer_print_stack_trace (/work/fuzz_hdf5+0x1)"


def where(*frames):
    return "\n".join(["", "0x60 is located 0 bytes to the right of 16-byte region", "allocated by thread T0 here:", MALLOC, *frames, ""])


CASES = {
    "a leak of the library": (log(LEAKS, leak(IN_LIBRARY, CALLER)), True),
    "a leak of ours": (log(LEAKS, leak(IN_OURS)), False),
    "a leak of ours behind one of the library": (log(LEAKS, leak(IN_LIBRARY, CALLER), leak(IN_OURS)), False),
    "what the library's leak leads to": (log(LEAKS, leak(IN_LIBRARY), leak(IN_OURS).replace("Direct", "Indirect")), True),
    "the library writes beyond its own": (log(OVERFLOW, COPY, IN_LIBRARY, CALLER, where(IN_LIBRARY, CALLER)), True),
    "the library writes beyond what is ours": (log(OVERFLOW, COPY, IN_LIBRARY, CALLER, where(IN_OURS)), False),
    "we write beyond what is the library's": (log(OVERFLOW, COPY, IN_OURS, where(IN_LIBRARY)), False),
    "a wrong address in the library": (log("==1==ERROR: AddressSanitizer: SEGV on unknown address 0x0", f"    #0 0x7f  {H5}", CALLER), True),
    "the library does not end": (log(TIMEOUT, IN_LIBRARY, CALLER, leak(IN_OURS)), True),
    "we do not end": (log(TIMEOUT, IN_OURS), False),
    "undefined behaviour": (log("../src/io/a.c:1:1: runtime error: shift", IN_LIBRARY), False),
    "another library": (log(LEAKS, leak("    #1 0x7f  (/lib/libjansson.so.4+0x1)")), False),
    "a build that failed": ("ld: no such file", False),
    "a promise of ours that is broken": (log("==1== ERROR: libFuzzer: deadly signal\n    #0 0x56 in abort (/lib/libc.so.6+0x1)", IN_OURS,
                                            f"    #2 0x7f  {H5}"), False),
}

failed = 0
with tempfile.TemporaryDirectory() as folder:
    for name, (text, expected) in CASES.items():
        path = os.path.join(folder, "log")
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        is_library = subprocess.run([sys.executable, TOOL, path], stdout=subprocess.DEVNULL, check=False).returncode == 0
        print(f"[ RUN      ] {name}\n{'[       OK ]' if is_library == expected else '[  FAILED  ]'} {name}")
        failed += is_library != expected
sys.exit(1 if failed else 0)
