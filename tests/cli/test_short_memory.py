"""What happens where the system gives less memory than is needed: a sentence, and no death; whatever is written is whole."""
import itertools
import os
import resource
import subprocess

from harness import VOLVIS, Skip, environment, main, sanitized, write_ball

MIB = 1 << 20


def within(limit, *words):
    """Code and sentence with so many bytes of address space."""
    result = subprocess.run([VOLVIS, *words], capture_output=True, env=environment(), timeout=60,
                            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
    return result.returncode, result.stderr.decode(errors="replace")


def test_a_command_ends_with_a_sentence_or_does_its_work():
    if sanitized():
        raise Skip("sanitizers take address space as they like")
    write_ball("ball.nrrd", 24)
    least = next(n for n in itertools.count(16 * MIB, 2 * MIB) if within(n, "version")[0] == 0)  # its libraries are there
    for words in (["convert", "ball.nrrd", "-o", "out.h5"], ["convert", "ball.nrrd", "-o", "out.zarr"], ["isosurface", "ball.nrrd", "--iso", "100", "-o", "out.glb"],
                  ["render", "ball.nrrd", "--size", "64x64", "-o", "out.png"], ["measure", "volume", "ball.nrrd", "--iso", "100"]):
        done = 0
        for limit in range(least, least + 24 * MIB, MIB // 2):
            code, said = within(limit, *words, "--threads", "1", "--overwrite") if "-o" in words else within(limit, *words)
            assert code in (0, 3, 4, 5) and (code == 0 or said.strip()), (words, limit / MIB, code, said)
            done += code == 0
            assert not [name for name in os.listdir() if name.endswith(".part")]
        assert done, f"{words} needs more than {least / MIB + 24} MiB"


main()
