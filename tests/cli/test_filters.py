"""Filters against SciPy's: an independent program's result on odd sizes and all types."""
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


def test_median_is_that_of_scipy():
    need_scipy()
    for kind in ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"):
        for shape, radius in (((7, 11, 131), (1, 1, 1)), ((5, 9, 13), (1, 2, 0)), ((1, 17, 19), (2, 2, 0))):
            data = samples(kind, shape)
            np.save("a.npy", data)
            ok("median", "a.npy", "-o", "b.npy", "--overwrite", "--radius-voxels", "%d,%d,%d" % radius)
            size = [2 * r + 1 if n > 1 else 1 for r, n in zip(radius[::-1], shape)]
            want = ndimage.median_filter(data, size, mode="nearest")
            got = np.load("b.npy")
            assert got.dtype == want.dtype and (got == want).all(), (kind, shape, radius)


def test_median_in_little_memory_is_the_same():
    need_scipy()
    np.save("a.npy", samples("f4", (120, 120, 120)))
    ok("median", "a.npy", "-o", "whole.npy", "--radius", "2")
    ok("median", "a.npy", "-o", "parts.npy", "--radius", "2", "--memory", "12M")
    assert open("whole.npy", "rb").read() == open("parts.npy", "rb").read()


main()
