"""Means and slopes against SciPy's and NumPy's: independent programs' results on odd sizes and all types."""
from harness import Skip, main, ok

try:
    import numpy as np
    from scipy import ndimage
except ImportError:
    np = None


def need_scipy():
    if np is None:
        raise Skip("SciPy is not there")


def samples(kind, shape):
    random = np.random.default_rng(11)
    if np.dtype(kind).kind == "f":
        return random.normal(0, 100, shape).astype(kind)
    ends = np.iinfo(kind if np.dtype(kind).itemsize < 8 else kind[0] + "4")  # SciPy reckons in doubles
    return random.integers(ends.min, ends.max, shape, endpoint=True).astype(kind)


def run(verb, data, *words):
    np.save("a.npy", data)
    ok(verb, "a.npy", "-o", "b.npy", "--overwrite", *words)
    return np.load("b.npy")


def near(got, want, kind):
    share = 1e-12 if kind == "f8" else 1e-5
    return np.allclose(got, want, rtol=share, atol=share * 100)


def test_mean_is_that_of_scipy():
    need_scipy()
    for kind in ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"):
        for shape, radius in (((7, 11, 131), (1, 1, 1)), ((5, 9, 13), (6, 2, 0)), ((1, 17, 19), (2, 2, 0))):
            data = samples(kind, shape)
            got = run("mean", data, "--radius-voxels", "%d,%d,%d" % radius)
            size = [2 * r + 1 if n > 1 else 1 for r, n in zip(radius[::-1], shape)]
            want = ndimage.uniform_filter(data.astype("f8"), size, mode="nearest")
            if kind[0] != "f":
                want = np.rint(want)
            assert got.dtype == data.dtype and near(got, want, kind), (kind, shape, radius)


def test_in_little_memory_it_is_the_same():
    need_scipy()
    np.save("a.npy", samples("f4", (120, 120, 120)))
    for words in VERBS:
        ok(*words, "a.npy", "-o", "whole.npy", "--overwrite")
        ok(*words, "a.npy", "-o", "parts.npy", "--overwrite", "--memory", "16M")
        assert open("whole.npy", "rb").read() == open("parts.npy", "rb").read(), words


VERBS = [("mean",)]

main()
