"""Filters that look for structure, against NumPy, SciPy and scikit-image: odd sizes, all types, missing values."""
from harness import Skip, main, ok, volvis

try:
    import numpy as np
    from scipy import ndimage
except ImportError:
    np = None

KINDS = "u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"


def need_scipy():
    if np is None:
        raise Skip("SciPy is not there")


def blobs(kind, shape, seed=1):
    """Smooth values within the range of every type; floats have holes."""
    data = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=shape), [1.5 if n > 1 else 0 for n in shape])
    data = (60 + 30 * data / data.std()).clip(0, 127).astype(kind)
    if data.dtype.kind == "f":
        data[shape[0] // 2, shape[1] // 2, shape[2] // 3] = np.nan
    return data


def filtered(data, *words):
    np.save("a.npy", data)
    ok(words[0], "a.npy", "-o", "b.npy", "--overwrite", *words[1:])
    return np.load("b.npy")


def same_by_any_number_of_threads(data, *words):
    np.save("c.npy", data)
    for threads in "1", "3":
        ok(words[0], "c.npy", "-o", f"threads{threads}.npy", "--overwrite", "--threads", threads, *words[1:])
    assert open("threads1.npy", "rb").read() == open("threads3.npy", "rb").read()


def same_in_little_memory(data, memory, *words):
    np.save("c.npy", data)
    ok(words[0], "c.npy", "-o", "whole.npy", "--overwrite", *words[1:])
    ok(words[0], "c.npy", "-o", "parts.npy", "--overwrite", "--memory", memory, *words[1:])
    assert open("whole.npy", "rb").read() == open("parts.npy", "rb").read()


def smoothed(data, sigma):
    """Missing samples have no weight, and stay."""
    there = np.isfinite(data)
    sigmas = [sigma if n > 1 else 0 for n in data.shape]
    top = ndimage.gaussian_filter(np.where(there, data, 0), sigmas, mode="nearest", truncate=4)
    below = ndimage.gaussian_filter(there.astype("f8"), sigmas, mode="nearest", truncate=4)
    return np.where(there, top / np.maximum(below, 1e-300), np.nan)


def hessians(data, sigma):
    """Of each sample, times sigma squared, by differences."""
    values = smoothed(data.astype("f8"), sigma)
    wide = np.pad(values, 1, mode="edge")

    def at(*offset):
        return wide[tuple(slice(1 + o, 1 + o + n) for o, n in zip(offset, data.shape))]

    def or_here(v):
        return np.where(np.isnan(v), values, v)

    matrix = np.zeros(data.shape + (3, 3))
    unit = np.eye(3, dtype=int)
    for a in range(3):
        matrix[..., a, a] = or_here(at(*unit[a])) - 2 * values + or_here(at(*-unit[a]))
        for b in range(a):
            mixed = at(*(unit[a] + unit[b])) - at(*(unit[a] - unit[b])) - at(*(unit[b] - unit[a])) + at(*(-unit[a] - unit[b]))
            matrix[..., a, b] = matrix[..., b, a] = np.where(np.isnan(mixed), 0, mixed / 4)
    return matrix * sigma**2


def by_size(data, sigma):
    values = np.linalg.eigvalsh(np.nan_to_num(hessians(data, sigma)))
    return np.take_along_axis(values, np.argsort(np.abs(values), axis=-1), -1)


def frangi(data, sigmas, alpha=0.5, beta=0.5, c=None, dark=False):
    """Frangi, Niessen, Vincken & Viergever 1998, equations 13 and 15."""
    all_values = [by_size(data, s) for s in sigmas]
    norms = [np.where(np.isfinite(data), (v**2).sum(-1), 0) for v in all_values]
    c = c or 0.5 * np.sqrt(max(n.max() for n in norms))
    best = np.zeros(data.shape)
    for values, norm in zip(all_values, norms):
        one, two, three = np.moveaxis(values if not dark else -values, -1, 0)
        with np.errstate(divide="ignore", invalid="ignore"):
            result = 1 - np.exp(-norm / (2 * c * c))
            if 1 in data.shape:
                vessel = three < 0
                result *= np.exp(-((two / three) ** 2) / (2 * beta**2))
            else:
                vessel = (two < 0) & (three < 0)
                result *= 1 - np.exp(-((two / three) ** 2) / (2 * alpha**2))
                result *= np.exp(-(one**2 / np.abs(two * three)) / (2 * beta**2))
        best = np.maximum(best, np.where(vessel, result, 0))
    return np.where(np.isfinite(data), best, np.nan)


def test_vesselness_is_that_of_numpy():
    need_scipy()
    for kind in KINDS:
        for shape in ((9, 11, 37), (1, 19, 21)):
            for words, options in (((), {}), (("--dark", "--alpha", "0.7", "--beta", "1", "--c", "9"),
                                              {"dark": True, "alpha": 0.7, "beta": 1, "c": 9})):
                data = blobs(kind, shape)
                got = filtered(data, "vesselness", "--sigma", "1", "--sigma-most", "2.25", "--scales", "3", *words)
                want = frangi(data, (1, 1.5, 2.25), **options)
                assert got.dtype == "f4" and (np.isnan(got) == np.isnan(want)).all(), (kind, shape)
                assert np.nanmax(want) > 0.2 and np.nanmax(np.abs(got - want)) < 2e-4, (kind, shape, np.nanmax(np.abs(got - want)))


def test_eigenvalues_are_those_of_numpy():
    need_scipy()
    for kind in "u1", "i2", "f8":
        data = blobs(kind, (9, 11, 37))
        got = filtered(data, "vesselness", "--output", "eigenvalues", "--sigma", "1.3")
        want, there = by_size(data, 1.3), np.isfinite(data.astype("f8"))
        assert np.abs(np.sort(got[0][there], -1) - np.sort(want[there], -1)).max() < 2e-4
        assert np.isnan(got[0][~there]).all()


def test_vesselness_of_parts_and_by_any_number_of_threads_is_the_same():
    need_scipy()
    data = blobs("u2", (90, 100, 101))
    same_in_little_memory(data, "16M", "vesselness", "--sigma", "1", "--sigma-most", "2", "--scales", "2")
    same_by_any_number_of_threads(blobs("f4", (31, 17, 45)), "vesselness", "--output", "scale")


main()
