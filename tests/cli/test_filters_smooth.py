"""Filters that smooth and keep edges, against the same in NumPy: odd sizes, all types, missing values."""
from harness import Skip, main, ok

try:
    import numpy as np
except ImportError:
    np = None

KINDS = ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8")


def need_numpy():
    if np is None:
        raise Skip("NumPy is not there")


def noisy_step(kind, shape, seed=1):
    """A step of 50 along x under noise, within the range of every type; floats have holes."""
    data = np.random.default_rng(seed).normal(25, 6, shape)
    data[..., shape[2] // 2:] += 50
    data = data.clip(0, 127).astype(kind)
    if data.dtype.kind == "f":
        data[0, shape[1] // 2, shape[2] // 3] = np.nan
    return data


def filtered(data, *words):
    np.save("a.npy", data)
    ok(words[0], "a.npy", "-o", "b.npy", "--overwrite", *words[1:])
    result = np.load("b.npy")
    assert result.shape == data.shape, (result.shape, data.shape)
    return result


def near(got, want, kind, what, tolerance=2e-5):
    assert got.dtype == np.dtype(kind), (got.dtype, kind)
    assert (np.isnan(got.astype("f8")) == np.isnan(want)).all(), what
    room = tolerance if got.dtype.kind == "f" else 0.5 + 1e-4
    worst = np.nanmax(np.abs(got.astype("f8") - want))
    assert worst <= room, (what, worst)


def shifted(padded, shape, reach, offset):
    return padded[tuple(slice(r + o, r + o + n) for r, o, n in zip(reach, offset, shape))]


def bilateral(data, sigma, value_sigma):
    values = data.astype("f8")
    reach = [int(3 * s) if n > 1 else 0 for s, n in zip(sigma, data.shape)]
    padded = np.pad(values, [(r, r) for r in reach], mode="edge")
    total, weights = np.zeros(data.shape), np.zeros(data.shape)
    for offset in np.ndindex(*(2 * r + 1 for r in reach)):
        offset = [o - r for o, r in zip(offset, reach)]
        far = sum((o / s) ** 2 for o, s in zip(offset, sigma))
        if far > 9:
            continue
        other = shifted(padded, data.shape, reach, offset)
        weight = np.exp(-far / 2 - (other - values) ** 2 / (2 * value_sigma**2))
        there = np.isfinite(other - values)
        total += np.where(there, weight * other, 0)
        weights += np.where(there, weight, 0)
    return np.where(np.isfinite(values), total / np.maximum(weights, 1e-300), values)


def test_bilateral_is_that_of_numpy():
    need_numpy()
    for kind in KINDS:
        for shape, sigma in (((5, 7, 37), (0.5, 0.8, 1.0)), ((1, 9, 11), (1.0, 1.0, 1.0))):
            data = noisy_step(kind, shape)
            got = filtered(data, "bilateral", "--sigma-voxels", "%g,%g,%g" % sigma[::-1], "--value-sigma", "15")
            near(got, bilateral(data, sigma, 15), kind, (kind, shape))


def diffused(data, iterations, edge, step, rational):
    values = data.astype("f8")
    for _ in range(iterations):
        change = np.zeros(values.shape)
        for axis in range(3):
            difference = np.diff(values, axis=axis)
            flux = difference / (1 + (difference / edge) ** 2) if rational else difference * np.exp(-((difference / edge) ** 2))
            flux = np.where(np.isfinite(flux), flux, 0)
            ends = [(0, 0)] * 3
            ends[axis] = (1, 1)
            change += np.diff(np.pad(flux, ends), axis=axis)
        values = values + step * change
    return values


def test_diffuse_is_that_of_numpy():
    need_numpy()
    for kind in KINDS:
        for shape in ((5, 7, 37), (1, 9, 11)):
            for name in ("exponential", "rational"):
                data = noisy_step(kind, shape)
                got = filtered(data, "diffuse", "--iterations", "7", "--edge", "15", "--step", "0.12", "--conductance", name)
                near(got, diffused(data, 7, 15, 0.12, name == "rational"), kind, (kind, shape, name))


def denoised(data, search, patch, noise, strength):
    values = data.astype("f8")
    search = [search if n > 1 else 0 for n in data.shape]
    patch = [patch if n > 1 else 0 for n in data.shape]
    reach = [s + p for s, p in zip(search, patch)]
    padded = np.pad(values, [(r, r) for r in reach], mode="edge")
    grown = [n + 2 * p for n, p in zip(data.shape, patch)]
    total, weights = np.zeros(data.shape), np.zeros(data.shape)
    for offset in np.ndindex(*(2 * s + 1 for s in search)):
        offset = [o - s for o, s in zip(offset, search)]
        squares = (shifted(padded, grown, search, offset) - shifted(padded, grown, search, (0, 0, 0))) ** 2
        squares = np.where(np.isfinite(squares), squares, 2 * noise**2)
        windows = [2 * p + 1 for p in patch]
        far = np.lib.stride_tricks.sliding_window_view(squares, windows).mean(axis=(3, 4, 5)) - 2 * noise**2
        other = shifted(padded, data.shape, reach, offset)
        weight = np.where(np.isfinite(other), np.exp(-np.maximum(far, 0) / (strength * noise) ** 2), 0)
        total += np.where(weight > 0, weight * other, 0)
        weights += weight
    return np.where(np.isfinite(values), total / np.maximum(weights, 1e-300), values)


def test_denoise_is_that_of_numpy():
    need_numpy()
    for kind in KINDS:
        for shape in ((5, 7, 37), (1, 9, 11)):
            data = noisy_step(kind, shape)
            got = filtered(data, "denoise", "--noise", "6", "--search", "2vox", "--patch", "1vox", "--strength", "1")
            near(got, denoised(data, 2, 1, 6, 1), kind, (kind, shape), 1e-4)


def in_little_memory(name, *words):
    np.save("c.npy", noisy_step("f4", (120, 120, 121)))
    ok(name, "c.npy", "-o", "whole.npy", "--overwrite", *words)
    ok(name, "c.npy", "-o", "parts.npy", "--overwrite", "--memory", "16M", *words)
    assert open("whole.npy", "rb").read() == open("parts.npy", "rb").read()


def test_bilateral_in_little_memory_is_the_same():
    need_numpy()
    in_little_memory("bilateral", "--sigma", "0.7")


def test_diffuse_in_little_memory_is_the_same():
    need_numpy()
    in_little_memory("diffuse", "--iterations", "4", "--edge", "10")


def test_denoise_in_little_memory_is_the_same():
    need_numpy()
    in_little_memory("denoise", "--search", "1")


main()
