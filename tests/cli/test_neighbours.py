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


VERBS = [("mean",), ("unsharp", "--sigma", "2"), ("gradient",), ("gradient", "--sigma", "1.5"), ("gradient", "--vector"),
         ("laplacian", "--sigma", "1")]


def smoothed(data, sigma):
    return ndimage.gaussian_filter(data.astype("f8"), [sigma if n > 1 else 0 for n in data.shape], mode="nearest", truncate=4)


def test_gaussian_is_that_of_scipy():
    need_scipy()
    for kind in ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"):
        for shape, sigma in (((7, 11, 131), (1, 1, 1)), ((5, 9, 13), (0.6, 2.5, 1.2)), ((1, 17, 19), (1, 0.8, 2)), ((6, 1, 1), (2, 1, 1))):
            data = samples(kind, shape)
            there = np.ones(shape, "f8")
            if kind[0] == "f" and min(shape) > 1:
                data[2, 4:6, 3] = np.nan
                there[2, 4:6, 3] = 0
            sigmas = [s if n > 1 else 0 for s, n in zip(sigma, shape)]
            top, below = (ndimage.gaussian_filter(v, sigmas, mode="nearest", truncate=4)
                          for v in (np.where(there, data, 0).astype("f8"), there))
            got = run("gaussian", data, "--sigma-voxels", "%g,%g,%g" % sigma[::-1])
            room = (0.51 if kind[0] != "f" else 0) + 3e-6 * np.abs(top).max()
            assert got.dtype == data.dtype and (np.isnan(got.astype("f8")) == (there == 0)).all(), (kind, shape)
            assert np.nanmax(np.abs(got - np.where(there, top / below, np.nan))) <= room, (kind, shape)


def test_missing_samples_do_not_count_for_their_neighbours():
    need_scipy()
    data = samples("f4", (7, 9, 11))
    data[3, 4:6, 5] = data[0, 0, :2] = np.nan
    there = np.isfinite(data)
    top, below = (ndimage.uniform_filter(v.astype("f8"), 3, mode="nearest") for v in (np.where(there, data, 0), there))
    assert np.allclose(run("mean", data), np.where(there, top / below, np.nan), rtol=1e-5, atol=1e-4, equal_nan=True)
    inside = np.pad(data, 1, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(inside, (3, 3, 3)).reshape(*data.shape, 27)
    got = run("median", data)
    assert (np.isnan(got) == ~there).all()
    odd = there & (np.isfinite(windows).sum(-1) % 2 == 1)
    assert (got[odd] == np.nanmedian(windows, -1)[odd]).all() and odd.sum() > 600


def slopes(data):
    """Along z, y, x; 0 along axes of one sample."""
    return [np.gradient(data.astype("f8"), axis=a) if n > 1 else 0 * data.astype("f8") for a, n in enumerate(data.shape)]


def test_gradient_is_that_of_numpy():
    need_scipy()
    for kind in ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"):
        for shape in ((7, 11, 131), (5, 9, 13), (1, 17, 19)):
            data = samples(kind, shape)
            want = slopes(data)
            assert near(run("gradient", data), sum(w**2 for w in want) ** 0.5, "f4"), (kind, shape)
            got = run("gradient", data, "--vector")
            assert near(got, np.stack(want[::-1], -1), "f4"), (kind, shape)


def test_gradient_and_laplacian_of_smoothed_samples():
    need_scipy()
    for kind in ("u1", "i2", "f4", "f8"):
        data = samples(kind, (15, 21, 33))
        size = np.abs(data.astype("f8")).max()
        smooth = smoothed(data, 1.5)
        want = sum(w**2 for w in slopes(smooth)) ** 0.5
        assert np.abs(run("gradient", data, "--sigma", "1.5") - want).max() < 2e-6 * size, kind
        want = ndimage.laplace(smooth, mode="nearest")
        assert np.abs(run("laplacian", data, "--sigma", "1.5") - want).max() < 1e-5 * size, kind


def test_laplacian_is_that_of_scipy():
    need_scipy()
    for kind in ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"):
        for shape in ((7, 11, 131), (5, 9, 13), (1, 17, 19)):
            data = samples(kind, shape)
            want = ndimage.laplace(data.astype("f8"), mode="nearest")
            got = run("laplacian", data)
            assert np.abs(got - want).max() <= 1e-6 * np.abs(want).max(), (kind, shape)


def test_unsharp_is_its_formula_with_scipys_gaussian():
    need_scipy()
    for kind in ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"):
        data = samples(kind, (9, 14, 33))
        value = data.astype("f8")
        difference = value - smoothed(data, 2)
        small = np.percentile(np.abs(difference), 30)
        want = value + np.where(np.abs(difference) >= small, 0.75 * difference, 0)
        got = run("unsharp", data, "--sigma", "2", "--amount", "0.75", "--threshold", repr(float(small)))
        size = np.abs(value).max()
        if kind[0] != "f":
            want = np.clip(np.rint(want), np.iinfo(kind).min, np.iinfo(kind).max)
        far = np.abs(got - want) > (1 if kind[0] != "f" else 0) + 2e-6 * size
        assert got.dtype == data.dtype and far.mean() < 1e-3, kind  # one or two lie at the threshold


main()
