"""What --dry-run says that operations need which take all samples at once, against what they held."""
import gzip

from harness import Skip, main, ok, sanitized
from test_hostile import run_alone

try:
    import numpy as np
except ImportError:
    np = None

SIDE = 128
WITHIN = 1.2  # how far off it may be, either way, and what threads and pieces of files take
SLACK = 1 << 20


def test_what_a_dry_run_says_is_what_is_held():
    if np is None or sanitized():
        raise Skip("NumPy is not there" if np is None else "sanitizers hold memory of their own")
    z, y, x = np.meshgrid(*(np.linspace(-1, 1, SIDE),) * 3, indexing="ij")
    values = 100 * np.exp(-3 * (x * x + y * y + z * z)) * (1 + 0.5 * np.sin(9 * x) * np.sin(8 * y) * np.sin(7 * z))
    blobs = np.sin(21 * x + 3 * y) * np.sin(18 * y) * np.sin(17 * z + 2 * x) > 0.1  # some six pieces a row, as in pictures
    for name, data in (("v", values.astype("<f4")), ("l", blobs.astype("u1")), ("tiny", blobs[:8, :8, :8].astype("u1"))):
        n = len(data)
        kind = "float" if name == "v" else "uchar"
        head = f"NRRD0005\ntype: {kind}\ndimension: 3\nsizes: {n} {n} {n}\nendian: little\nspace: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: gzip\n\n"
        with open(f"{name}.nrrd", "wb") as file:
            file.write(head.encode() + gzip.compress(data.tobytes(), 1, mtime=0))
    least = min(run_alone("components", "tiny.nrrd", "-o", "o.nrrd", "--overwrite")[2] for _ in range(3))  # pages of libraries come and go
    for words in (["components", "l.nrrd"], ["components", "v.nrrd", "--range", "60.."], ["fill-holes", "l.nrrd"], ["grow", "v.nrrd", "--seed", "64,64,64", "--range", "40.."],
                  ["distance", "l.nrrd"], ["distance", "l.nrrd", "--side", "both"], ["watershed", "v.nrrd", "--depth", "20"], ["skeleton", "l.nrrd"],
                  ["bias", "v.nrrd", "--iterations", "1"], ["diffuse", "v.nrrd", "--method", "coherence", "--iterations", "1"]):
        words += ["-o", "o.nrrd", "--overwrite"]
        plan = ok(*words, "--dry-run", "--json").json
        planned = plan["memory_bytes"]
        assert words[0] == "grow" or plan["seconds"] > 0, words  # its seed is not in the part that is tried
        runs = [run_alone(*words, "--threads", "2") for _ in range(3)]
        assert all(code == 0 for code, _, _ in runs), runs
        held = min(peak for _, _, peak in runs) - least  # as of the least: what comes and goes is nobody's need
        assert planned / WITHIN - SLACK < held < planned * WITHIN + SLACK, f"{' '.join(words)}: {planned / 2**20:.1f} MiB planned, {held / 2**20:.1f} held"


main()
