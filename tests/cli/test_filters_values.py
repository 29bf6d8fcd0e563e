"""Filters of values, against NumPy and scikit-image: all types, missing values, scales, little memory."""
from harness import Skip, fails, main, ok, says, write_labels

try:
    import numpy as np
except ImportError:
    np = None

KINDS = ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8")
SHAPES = ((5, 7, 11), (1, 9, 1))


def need_numpy():
    if np is None:
        raise Skip("NumPy is not there")


def samples(kind, shape=(5, 7, 11), seed=3, holes=True):
    data = np.random.default_rng(seed).normal(60, 20, shape).clip(0, 127).astype(kind)
    if holes and data.dtype.kind == "f":
        data[0, shape[1] // 2, shape[2] // 3] = np.nan
    return data


def result(*words):
    """Of the verb on a.npy."""
    ok(words[0], "a.npy", "-o", "b.npy", "--overwrite", *words[1:])
    return np.load("b.npy")


def same(got, want, what):
    assert got.dtype == want.dtype and np.array_equal(got, want, equal_nan=got.dtype.kind == "f"), what


def test_clamping_is_that_of_numpy():
    need_numpy()
    for kind in KINDS:
        for shape in SHAPES:
            data = samples(kind, shape)
            np.save("a.npy", data)
            same(result("clamp", "--range", "40..70"), np.clip(data, np.array(40, kind), np.array(70, kind)), kind)
            same(result("clamp", "--range", "40.."), np.where(data < 40, np.array(40, kind), data), kind)
            want = np.where(data < 40, 1, np.where(data > 70, 99, data)).astype(kind)
            same(result("clamp", "--range", "40..70", "--below", "1", "--above", "99"), want, kind)


def test_clamping_keeps_all_digits_and_ends_inside_the_range():
    need_numpy()
    large = np.array([[[-5, 0, 2**62 + 1, 2**63 - 1]]], "i8")
    np.save("a.npy", large)
    same(result("clamp", "--range", "0.."), np.maximum(large, 0), "i8")
    np.save("a.npy", np.arange(9, dtype="u1").reshape(1, 1, 9))
    same(result("clamp", "--range", "1.2..6.7"), np.arange(9).clip(2, 6).astype("u1").reshape(1, 1, 9), "between")
    says(fails(2, "clamp", "a.npy", "-o", "x.npy", "--range", "300.."), "u8")
    says(fails(2, "clamp", "a.npy", "-o", "x.npy", "--range", "1..2", "--above", "300"), "0 to 255")
    says(fails(2, "clamp", "a.npy", "-o", "x.npy"), "range is needed")


def test_limits_of_floats_are_the_nearest_samples():
    """The shortest text of a sample is that sample, though its double lies beside it."""
    need_numpy()
    data = np.random.default_rng(5).normal(10, 9, (6, 7, 8)).astype("f4")
    np.save("a.npy", data)
    for lo, hi in zip(np.sort(data.ravel())[40:60], np.sort(data.ravel())[-60:-40]):
        same(result("clamp", "--range", f"{lo!s}..{hi!s}"), np.clip(data, lo, hi), (lo, hi))
    one = np.float32("12.17963")
    same(result("clamp", "--range", "12.17963..12.17963"), np.full_like(data, one), "one value")
    same(result("clamp", "--range", "-1e300..1e300"), data, "no float is so large")
    np.save("a.npy", data.astype("f8"))
    same(result("clamp", "--range", "12.17963.."), np.maximum(data.astype("f8"), 12.17963), "f8")


def test_windows_are_their_formula():
    need_numpy()
    for kind in KINDS:
        for shape in SHAPES:
            data = samples(kind, shape)
            np.save("a.npy", data)
            share = (np.clip(data.astype("f8"), 40, 70) - 40) / 30
            got = result("rescale", "--from", "40..70", "--to", "0..1", "--type", "f32")
            assert np.allclose(got, share, atol=1e-6, equal_nan=True), kind
            got = result("rescale", "--from", "40..70", "--type", "u8").astype("f8")
            assert np.abs(got - np.nan_to_num(255 * share)).max() <= 0.5 + 1e-4, kind


def write_scaled(path, data):
    """Stored numbers that mean 100 - 2 v."""
    with open(path, "wb") as file:
        file.write((f"NRRD0005\ntype: int16\ndimension: 3\nsizes: {data.shape[2]} {data.shape[1]} {data.shape[0]}\n"
                    "encoding: raw\nendian: little\nvolvis value scale:=-2\nvolvis value offset:=100\n\n").encode())
        file.write(data.tobytes())


def test_values_are_meant_and_not_stored_numbers():
    need_numpy()
    data = samples("i2")
    write_scaled("s.nrrd", data)
    if ok("info", "s.nrrd", "--json").json.get("value_scale") != -2:
        raise Skip("the scale is written otherwise")
    ok("clamp", "s.nrrd", "-o", "c.npy", "--overwrite", "--range", "-60..20")
    assert (np.load("c.npy") == (100 - 2.0 * data).clip(-60, 20)).all()
    mask = samples("u1", seed=5) > 60
    np.save("m.npy", mask.astype("u1"))
    ok("mask", "s.nrrd", "m.npy", "-o", "c.npy", "--overwrite", "--fill", "-40")
    assert (np.load("c.npy") == np.where(mask, 100 - 2.0 * data, -40)).all()


def test_masks_keep_what_they_mark():
    need_numpy()
    for kind in KINDS:
        for shape in SHAPES:
            data, mask = samples(kind, shape), (samples(kind, shape, 9) // 30).astype(kind)
            there = np.nan_to_num(mask.astype("f8")) != 0
            np.save("a.npy", data)
            np.save("m.npy", mask)
            same(result("mask", "mask=m.npy"), np.where(there, data, 0).astype(kind), kind)
            same(result("mask", "m.npy", "--invert", "--fill", "7"), np.where(there, 7, data).astype(kind), kind)
            two = np.isin(np.nan_to_num(mask), [1, 3])
            same(result("mask", "m.npy", "--label", "1,3"), np.where(two, data, 0).astype(kind), kind)


def test_masks_name_labels_as_their_file_does():
    need_numpy()
    write_labels("organs.seg.nrrd")
    ok("convert", "organs.seg.nrrd", "-o", "l.npy", "--overwrite")
    labels = np.load("l.npy")
    ok("calc", "100+i", "organs.seg.nrrd", "-o", "v.nrrd", "--overwrite")
    ok("mask", "v.nrrd", "mask=organs.seg.nrrd", "--label", "left kidney", "-o", "c.npy", "--overwrite")
    want = np.where(labels == 7, 100 + np.arange(24)[None, None, :], 0)
    assert (np.load("c.npy") == want).all()
    says(fails(2, "mask", "v.nrrd", "mask=organs.seg.nrrd", "--label", "left kidnei", "-o", "x.npy"), "left kidney")
    says(fails(2, "mask", "v.nrrd", "mask=organs.seg.nrrd", "--label", "300", "-o", "x.npy"), "no sample of the mask can be 300", "0 to 255")
    np.save("small.npy", samples("u1"))
    says(fails(2, "mask", "v.nrrd", "small.npy", "-o", "x.npy"), "resample it first")
    says(fails(2, "mask", "v.nrrd", "-o", "x.npy"), "one more input", "mask=FILE")


def in_little_memory(name, *words, kind="f4", memory="14M"):
    np.save("a.npy", samples(kind, (120, 120, 121)))
    np.save("m.npy", samples(kind, (120, 120, 121), 9) // 60)
    ok(name, "a.npy", "-o", "whole.npy", "--overwrite", *words)
    ok(name, "a.npy", "-o", "parts.npy", "--overwrite", "--memory", memory, *words)
    assert open("whole.npy", "rb").read() == open("parts.npy", "rb").read(), name


def test_clamp_and_mask_in_little_memory_are_the_same():
    need_numpy()
    in_little_memory("clamp", "--range", "40..70")
    in_little_memory("mask", "mask=m.npy")


def merged(*words):
    ok("merge", *words, "-o", "b.nrrd", "--overwrite")
    ok("convert", "b.nrrd", "-o", "b.npy", "--overwrite")
    return np.load("b.npy")


def test_merging_gives_the_channels_one_after_the_other():
    need_numpy()
    both = {("u1", "u1"): "u1", ("u1", "i1"): "i2", ("u2", "u1"): "u2", ("i4", "u4"): "i8", ("u8", "i8"): "f8", ("u2", "f4"): "f4",
            ("i4", "f4"): "f8", ("f8", "f8"): "f8"}
    for (a, b), kind in both.items():
        np.save("p.npy", samples(a))
        np.save("q.npy", samples(b, seed=5))
        for word in ("p", "q"):  # as volumes, which .npy files do not tell from others
            ok("convert", word + ".npy", "-o", word + ".nrrd", "--overwrite")
        got = merged("p.nrrd", "q.nrrd", "p.nrrd")
        want = np.stack([samples(a), samples(b, seed=5), samples(a)], -1).astype(kind)
        same(got.reshape(want.shape), want, (a, b))
    large = np.array([[[2**63 - 1, -(2**63), 2**60 + 1]]], "i8")
    np.save("p.npy", large)
    np.save("q.npy", np.array([[[2**32 - 1, 0, 5]]], "u4"))
    got = merged("p.npy", "q.npy").reshape(3, 2)
    assert (got[:, 0] == large.ravel()).all() and (got[:, 1] == [2**32 - 1, 0, 5]).all()


def test_merged_channels_have_the_names_that_inputs_were_given():
    need_numpy()
    np.save("p.npy", samples("u1"))
    merged("ct=p.npy", "pet=p.npy")
    said = ok("info", "b.nrrd", "--json").json
    assert [c["name"] for c in said["channels"]] == ["ct", "pet"], said
    assert ok("channel", "b.nrrd", "-o", "c.npy", "--overwrite", "--channel", "pet")
    says(fails(2, "merge", "p.npy", "p.npy", "--names", "a,b,c", "-o", "x.nrrd"), "expected 2")
    says(fails(2, "merge", "p.npy", "-o", "x.nrrd"), "merge")
    np.save("small.npy", samples("u1", (1, 2, 3)))
    says(fails(2, "merge", "p.npy", "small.npy", "-o", "x.nrrd"), "resample it first")


def test_merging_in_little_memory_is_the_same():
    need_numpy()
    in_little_memory("merge", "m.npy", memory="20M")


def noise_on(value, kind, *words, n=60):
    """A cube of one value with noise, flat."""
    np.save("a.npy", np.full((n, n, n), value, kind))
    return result("add-noise", *words).astype("f8").ravel()


def near(found, want, spread, n, what):
    """Within five standard deviations of a mean of n."""
    assert abs(found - want) <= 5 * spread / n**0.5, (what, found, want)


def test_noise_has_the_moments_of_its_kind():
    need_numpy()
    n = 60**3
    v = noise_on(100, "f4", "--sigma", "10")
    near(v.mean(), 100, 10, n, "gaussian")
    near(v.var(), 100, 100 * 2**0.5, n, "gaussian")
    near(((v - 100) ** 4).mean(), 3 * 10**4, 96**0.5 * 10**4, n, "gaussian")
    assert abs(np.corrcoef(v[:-1], v[1:])[0, 1]) < 5 / n**0.5
    for mean in (0.3, 4, 9.9, 10.1, 40, 3000):
        v = noise_on(mean, "f8", "--kind", "poisson")
        assert (v == np.floor(v)).all() and v.min() >= 0
        near(v.mean(), mean, mean**0.5, n, ("poisson", mean))
        near(((v - mean) ** 2).mean(), mean, (mean + 2 * mean**2) ** 0.5, n, ("poisson", mean))
        near(((v - mean) ** 3).mean(), mean, (15 * mean**3 + 30 * mean**2 + 10 * mean) ** 0.5 * 1.5 + 1, n, ("poisson", mean))
    v = noise_on(50, "f8", "--kind", "poisson", "--counts", "4")
    near(v.var(), 50 / 4, 50 / 4 * 2**0.5, n, "counts")
    v = noise_on(0, "f4", "--kind", "rician", "--sigma", "8")
    near(v.mean(), 8 * (np.pi / 2) ** 0.5, 8, n, "rician")
    v = noise_on(20, "f4", "--kind", "rician", "--sigma", "8")
    near((v**2).mean(), 20**2 + 2 * 8**2, 2 * 8 * (20**2 + 8**2) ** 0.5, n, "rician")


def test_counts_have_the_probabilities_of_poisson():
    need_numpy()
    try:
        from scipy import stats
    except ImportError as error:
        raise Skip("SciPy is not there") from error
    for mean in (0.7, 6, 14, 90):
        v = noise_on(mean, "f8", "--kind", "poisson")
        k = np.arange(int(stats.poisson.ppf(1e-3, mean)), int(stats.poisson.ppf(1 - 1e-3, mean)) + 1)
        found = np.array([(v == c).sum() for c in k])
        want = stats.poisson.pmf(k, mean) * v.size
        squares = ((found - want) ** 2 / want).sum()
        assert squares < stats.chi2.ppf(1 - 1e-6, len(k)), (mean, squares, len(k))


def test_salt_and_pepper_are_as_many_as_asked_for():
    need_numpy()
    n = 60**3
    for kind, ends in (("u1", (0, 255)), ("i2", (-32768, 32767)), ("f4", (0, 1))):
        v = noise_on(7, kind, "--kind", "salt-and-pepper", "--fraction", "20%")
        for end in ends:
            near((v == end).mean(), 0.1, 0.3, n, kind)
        assert ((v == 7) | (v == ends[0]) | (v == ends[1])).all()
    v = noise_on(7, "u2", "--kind", "salt-and-pepper", "--salt", "9", "--pepper", "3")
    assert set(np.unique(v)) == {3, 7, 9}
    says(fails(2, "add-noise", "a.npy", "-o", "x.npy", "--kind", "salt-and-pepper", "--salt", "-1"), "u16")


def test_noise_is_the_same_for_a_seed_and_of_each_step_its_own():
    need_numpy()
    steps = np.zeros((3, 5, 6, 7), "f4")
    steps[0, 1, 2, 3] = np.nan
    np.save("a.npy", steps)
    says(fails(2, "add-noise", "a.npy", "-o", "x.npy"), "all values are the same")
    first, again, other = (result("add-noise", "--sigma", 10, "--seed", seed) for seed in (4, 4, 5))
    assert np.array_equal(first, again, equal_nan=True) and (first != other).all()
    assert np.isnan(first[0, 1, 2, 3]) and np.isnan(first).sum() == 1
    assert len(np.unique(first[~np.isnan(first)])) == first.size - 1
    for kind in KINDS:
        np.save("a.npy", samples(kind, holes=False))
        got = result("add-noise", "--sigma", "3").astype("f8") - samples(kind, holes=False).astype("f8")
        assert 1.5 < got.std() < 4.5, (kind, got.std())


def test_noise_is_as_large_as_the_values_say_in_all_time_steps_alike():
    need_numpy()
    steps = np.linspace(-0.5, 0.5, 2 * 40**3).reshape(2, 40, 40, 40).astype("f4")
    steps[0, 0, 0, :3] = (9e9, -9e9, np.nan)  # few of them: no percentile
    np.save("a.npy", steps)
    low, high = (np.percentile(step[np.isfinite(step)], (0.1, 99.9)) for step in steps)
    sigma = 0.05 * max(low[1] - low[0], high[1] - high[0])
    got = result("add-noise").astype("f8") - steps
    for found in (got[0, 1:], got[1]):
        near(found.var(), sigma**2, sigma**2 * 2**0.5, found.size, "automatic")
    given = result("add-noise", "--sigma", repr(float(sigma)))
    assert np.allclose(given[1], steps[1] + got[1], atol=1e-5)


def test_noise_in_little_memory_is_the_same():
    need_numpy()
    for kind in ("gaussian", "poisson", "rician", "salt-and-pepper"):
        in_little_memory("add-noise", "--kind", kind)


def ranks(data, reference):
    """What share of the samples is no larger than each: skimage.exposure.match_histograms, by numpy."""
    _, place, counts = np.unique(data.ravel(), return_inverse=True, return_counts=True)
    values, others = np.unique(reference.ravel(), return_counts=True)
    return np.interp(np.cumsum(counts) / data.size, np.cumsum(others) / reference.size, values)[place].reshape(data.shape)


def test_matching_gives_the_histogram_of_the_other():
    need_numpy()
    for kind in KINDS:
        for other in ("u1", "i2", "f4"):
            data = samples(kind, (5, 7, 11), holes=False)
            reference = samples(other, (9, 8, 7), 4, holes=False) // 3 + 5
            np.save("a.npy", data)
            np.save("r.npy", reference)
            got, want = result("match", "r.npy"), ranks(data, reference)
            assert got.dtype == reference.dtype, (kind, other)
            # floats lie in bins, and so somewhere in the gap between two values of the other
            exact = data.dtype.kind != "f" and other != "f4"
            room = 0.5 + 1e-9 if exact else 1.5 if other != "f4" else 6
            assert np.abs(got.astype("f8") - want).max() <= room, (kind, other, np.abs(got.astype("f8") - want).max())
            order = np.argsort(data, axis=None)
            assert (np.diff(got.ravel()[order].astype("f8"))[np.diff(data.ravel()[order]) > 0] >= 0).all()


def test_matching_is_that_of_scikit_image():
    need_numpy()
    try:
        from skimage import exposure
    except ImportError as error:
        raise Skip("scikit-image is not there") from error
    data, reference = samples("u2", (9, 11, 13)), samples("u2", (8, 9, 10), 6) * 3
    np.save("a.npy", data)
    np.save("r.npy", reference)
    want = exposure.match_histograms(data.astype("f8"), reference.astype("f8"))
    assert np.abs(result("match", "r.npy") - want).max() <= 0.5 + 1e-9
    fails(2, "match", "a.npy", "-o", "x.npy")


def test_equalized_values_are_spread_by_their_ranks():
    need_numpy()
    for kind in KINDS:
        data = samples(kind, (9, 11, 13))
        np.save("a.npy", data)
        got = result("equalize")
        there = ~np.isnan(data.astype("f8"))
        assert got.dtype == data.dtype and (np.isnan(got.astype("f8")) == ~there).all()
        v = data[there].astype("f8")
        up_to = np.searchsorted(np.sort(v), v, side="right").astype("f8")
        first = (v == v.min()).sum() if data.dtype.kind != "f" else 0
        want = v.min() + (v.max() - v.min()) * (up_to - first) / (v.size - first)
        room = 0.5 + 1e-9 if data.dtype.kind != "f" else 3 * (v.max() - v.min()) / v.size
        assert np.abs(got[there] - want).max() <= room, (kind, np.abs(got[there] - want).max())
    np.save("a.npy", np.full((3, 4, 5), 7, "i2"))
    assert (result("equalize") == 7).all()


def adaptive(data, side, clip):
    """CLAHE in doubles, by the formula."""
    v, bins = data.astype("f8"), 256
    lo, hi = np.nanmin(v), np.nanmax(v)
    n = [(d + side // 2) // side if side < d else 1 for d in v.shape]
    ends = [[t * d // k for t in range(k + 1)] for k, d in zip(n, v.shape)]
    shares = np.zeros((*n, *v.shape))
    for tile in np.ndindex(*n):
        part = v[tuple(slice(e[t], e[t + 1]) for e, t in zip(ends, tile))]
        count = np.histogram(part[np.isfinite(part)], bins, (lo, hi))[0].astype("f8")
        most = clip * count.sum() / bins
        count = np.minimum(count, most) + np.maximum(count - most, 0).sum() / bins
        shares[tile] = np.interp((v - lo) / (hi - lo) * bins, np.arange(bins + 1), np.append(0, np.cumsum(count)) / count.sum())
    for axis in range(3):  # mixed along one axis after the other
        middles = [(a + b - 1) / 2 for a, b in zip(ends[axis], ends[axis][1:])]
        weights = np.array([np.interp(np.arange(v.shape[axis]), middles, np.eye(n[axis])[t]) for t in range(n[axis])])
        shape = [-1 if a == axis else 1 for a in range(3)]
        shares = sum(shares[t] * weights[t].reshape(shape) for t in range(n[axis]))
    return lo + (hi - lo) * shares


def test_adaptive_equalization_is_its_formula():
    need_numpy()
    for kind in KINDS:
        for shape, side, clip in (((9, 14, 23), 5, 3), ((1, 30, 31), 8, 1.5), ((3, 4, 5), 50, 1000)):
            data = samples(kind, shape)
            np.save("a.npy", data)
            got, want = result("equalize", "--method", "clahe", "--tile", side, "--clip", clip).astype("f8"), adaptive(data, side, clip)
            room = 0.5 + 1e-9 if data.dtype.kind != "f" else 1e-4
            assert np.nanmax(np.abs(got - want)) <= room and (np.isnan(got) == np.isnan(want)).all(), (kind, shape)


def test_histograms_in_little_memory_are_the_same():
    need_numpy()
    in_little_memory("equalize")
    in_little_memory("equalize", "--method", "adaptive", "--tile", "20", memory="24M")
    in_little_memory("match", "m.npy")


main()
