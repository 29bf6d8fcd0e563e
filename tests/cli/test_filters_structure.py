"""Filters that look for structure, against NumPy, SciPy and scikit-image: odd sizes, all types, missing values."""
import heapq
import os
from harness import Skip, main, ok, volvis

try:
    import numpy as np
    from scipy import ndimage
except ImportError:
    np = None
try:
    from skimage import morphology, segmentation
except ImportError:
    segmentation = None

KINDS = "u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"


def need_scipy():
    if np is None:
        raise Skip("SciPy is not there")


def need_skimage():
    need_scipy()
    if segmentation is None:
        raise Skip("scikit-image is not there")


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


def watershed(data, *options, **inputs):
    np.save("a.npy", data)
    words = []
    for name, other in inputs.items():
        np.save(f"{name}.npy", other)
        words.append(f"{name}={name}.npy")
    ok("watershed", "a.npy", "-o", "b.npy", "--overwrite", *words, *options)
    return np.load("b.npy")


def reals(shape, seed=1):
    """Smooth, and no two alike."""
    return ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=shape), [1.2 if n > 1 else 0 for n in shape])


def minima(data, axes):
    """Labelled, in the order of their first voxels; of data without plateaus."""
    neighbours = ndimage.generate_binary_structure(3, axes)
    return ndimage.label(ndimage.minimum_filter(data, footprint=neighbours, mode="nearest") == data, neighbours)[0]


def largest_first(labels):
    sizes = np.bincount(labels.ravel())[1:]
    rank = np.zeros(sizes.size + 1, "u4")
    rank[1 + np.lexsort((np.arange(sizes.size), -sizes))] = np.arange(1, sizes.size + 1)
    return rank[labels]


def test_watershed_of_minima_is_that_of_scikit_image():
    need_skimage()
    for shape in (9, 14, 23), (1, 21, 40), (17, 1, 13):
        for axes, connectivity in (1, "6"), (2, "18"), (3, "26"):
            for lines in (), ("--lines",):
                data = reals(shape)
                structure = ndimage.generate_binary_structure(3, axes)
                want = segmentation.watershed(data, minima(data, axes), structure, watershed_line=bool(lines))
                got = watershed(data, "--connectivity", connectivity, *lines)
                assert got.dtype == "u4" and (got == largest_first(want)).all() and got.max() > 3, (shape, connectivity, lines)
                assert (watershed(-data, "--connectivity", connectivity, "--bright", *lines) == got).all()


def flooded(data, markers, axes, lines=False, mask=None):
    """By a queue of all voxels at once: by height, but not below the flood's, then in the order of arrival."""
    offsets = [o for differ in range(1, axes + 1) for o in np.ndindex(3, 3, 3) if sum(x != 1 for x in o) == differ]
    label = np.where(markers if mask is None else np.where(mask, markers, 0), markers, 0).astype("i8")
    if mask is not None:
        label[~mask] = -1
    queue, age = [], 0
    for at in zip(*np.nonzero(label > 0)):
        heapq.heappush(queue, (data[at], age, at))
        age += 1

    def around(at):
        for o in offsets:
            there = tuple(a + x - 1 for a, x in zip(at, o))
            if all(0 <= t < n for t, n in zip(there, data.shape)):
                yield there

    while queue:
        level, _, at = heapq.heappop(queue)
        if label[at] == -2:
            labels = {label[there] for there in around(at) if label[there] > 0}
            label[at] = labels.pop() if len(labels) == 1 else -3
        if label[at] == -3:
            continue
        for there in around(at):
            if label[there] == 0:
                label[there] = -2 if lines else label[at]
                heapq.heappush(queue, (max(level, data[there]), age, there))
                age += 1
    return np.where(label > 0, label, 0)


def test_watershed_from_markers_shares_plateaus_by_distance():
    need_scipy()
    shape = (6, 13, 17)
    random = np.random.default_rng(5)
    markers = np.where(random.random(shape) < 0.01, random.integers(1, 9, shape), 0)
    mask = random.random(shape) < 0.9
    for t, kind in enumerate(KINDS):
        data = (reals(shape) * 20 + 30).clip(0, 60).astype(kind)
        axes, connectivity = ((1, "6"), (2, "18"), (3, "26"))[t % 3]
        marked = markers.astype(("u1", "i2", "u4", "f4", "i8")[t % 5])
        got = watershed(data, "--connectivity", connectivity, markers=marked)
        assert (got == flooded(data, markers, axes)).all(), kind
        got = watershed(data, "--connectivity", connectivity, "--lines", markers=marked, mask=mask.astype("f4"))
        assert (got == flooded(data, markers, axes, True, mask)).all(), kind
    flat = np.zeros((1, 1, 9), "u1")
    ends = flat.copy()
    ends[0, 0, 0], ends[0, 0, 8] = 7, 4
    assert watershed(flat, markers=ends).ravel().tolist() == [7] * 5 + [4] * 4
    assert watershed(flat, "--lines", markers=ends).ravel().tolist() == [7] * 4 + [0] + [4] * 4


def test_shallow_basins_become_part_of_others():
    need_skimage()
    data = reals((12, 25, 27), 3)
    everything = watershed(data, "--connectivity", "26")
    for depth in 0.1, 0.3, 0.6:
        # what is left of minima when everything less deep is filled (Soille's h-minima), by reconstruction
        filled = morphology.reconstruction(data + depth, data, "erosion", np.ones((3, 3, 3)))
        left, n = ndimage.label(morphology.local_minima(filled, connectivity=3), np.ones((3, 3, 3)))
        got = watershed(data, "--connectivity", "26", "--depth", str(depth))
        assert got.max() == n < everything.max(), (depth, got.max(), n)
        for part in range(1, n + 1):  # each is in one basin, and no two in the same
            assert len(np.unique(got[left == part])) == 1
        assert len(np.unique([got[left == part][0] for part in range(1, n + 1)])) == n
        for basin in range(1, everything.max() + 1):  # basins are never cut
            assert len(np.unique(got[everything == basin])) == 1


def test_watershed_of_all_types_and_of_parts_is_the_same():
    need_scipy()
    shape = (8, 15, 22)
    whole = (reals(shape) * 20 + 40).clip(0, 100).round()
    want = watershed(whole.astype("u1"), "--depth", "3", "--range", "20..70")
    assert want.max() > 2 and ((want > 0) <= ((whole >= 20) & (whole <= 70))).all()
    for kind in KINDS[1:]:
        data = whole.astype(kind)
        if kind[0] == "f":
            data[data < 20] = np.nan
            data[data > 70] = np.nan
            data[data == 0] = -0.0
        assert (watershed(data, "--depth", "3", *(() if kind[0] == "f" else ("--range", "20..70"))) == want).all(), kind
    same_by_any_number_of_threads(whole, "watershed", "--lines", "--depth", "2")


def test_watershed_says_what_it_cannot_do():
    need_scipy()
    np.save("a.npy", np.zeros((4, 5, 6), "u1"))
    np.save("m.npy", np.full((4, 5, 6), -1, "i2"))
    np.save("n.npy", np.zeros((4, 5, 7), "u1"))
    for words, part in ((("markers=m.npy",), "whole numbers from 0"), (("markers=n.npy",), "markers"),
                        (("markers=a.npy",), "there is no basin"), (("mask=n.npy",), "mask"),
                        (("markers=a.npy", "--depth", "3"), "leave it out"), (("--range", "x"), "range")):
        result = volvis("watershed", "a.npy", "-o", "b.npy", "--overwrite", *words)
        assert result.code != 0 and part in result.message, (words, result.message)
    np.save("c.npy", np.zeros((200, 200, 200), "u1"))
    result = volvis("watershed", "c.npy", "-o", "b.npy", "--overwrite", "--memory", "60M")
    assert result.code != 0 and "memory" in result.message, result.message
    assert ok("watershed", "a.npy", "mask=a.npy", "-o", "b.npy", "--overwrite", "--json").json["basins"] == 0


def euler(mask):
    """Of closed cubes: corners - edges + faces - cubes."""
    total = 0
    wide = np.pad(mask, 1)
    for code in np.ndindex(2, 2, 2):  # 1: the cell spans the voxel along this axis, 0: it lies between two
        cells = wide
        for axis, spans in enumerate(code):
            if not spans:
                cells = np.delete(cells, 0, axis) | np.delete(cells, -1, axis)
        total += (-1) ** sum(code) * int(cells.sum())
    return total


def topology(mask):
    """Parts, cavities, tunnels."""
    parts = ndimage.label(mask, np.ones((3, 3, 3)))[1]
    cavities = ndimage.label(np.pad(~mask, 1, constant_values=True))[1] - 1
    return parts, cavities, parts + cavities - euler(mask)


def skeleton(data, *options):
    return filtered(data, "skeleton", *options)


def test_skeletons_hang_together_as_their_labels_do():
    need_scipy()
    for t, shape in enumerate(((19, 23, 31), (1, 40, 37), (16, 1, 29), (24, 24, 1), (1, 1, 20))):
        for level in -0.1, 0.0, 0.15:
            data = reals(shape, t) > level
            got = skeleton(data.astype(KINDS[(t * 3 + int(level * 20)) % 8]))
            assert (got <= data).all() and got.any() and got.sum() < 0.5 * data.sum() or 1 in shape, (shape, level)
            assert topology(got > 0) == topology(data), (shape, level, topology(got > 0), topology(data))
            assert (skeleton(got) == got).all(), (shape, level)


def test_skeletons_of_known_shapes_are_their_axes():
    need_scipy()
    z, y, x = np.mgrid[0:25, 0:41, 0:51].astype("f8")
    ball = (x - 25) ** 2 + (y - 20) ** 2 + (z - 12) ** 2 <= 100
    got = skeleton(ball.astype("u1"))
    assert got.sum() <= 3 and got[11:14, 19:22, 24:27].sum() == got.sum(), np.argwhere(got)
    ring = (np.hypot(x - 25, y - 20) - 14) ** 2 + (z - 12) ** 2 <= 16
    got = np.argwhere(skeleton(ring.astype("u1"))).astype("f8")
    away = np.hypot(np.hypot(got[:, 2] - 25, got[:, 1] - 20) - 14, got[:, 0] - 12)
    assert topology(skeleton(ring.astype("u1")) > 0) == (1, 0, 1) and away.max() < 1.6 and len(got) > 50, away.max()
    bar = (abs(z - 12) <= 2) & (abs(y - 20) <= 2) & (x > 4) & (x < 46)
    got = np.argwhere(skeleton(bar.astype("u1")))
    assert (abs(got[:, 0] - 12) <= 1).all() and (abs(got[:, 1] - 20) <= 1).all(), got
    assert len(got) >= 36 and len(set(got[:, 2])) == len(got)
    shell = (ball & ((x - 25) ** 2 + (y - 20) ** 2 + (z - 12) ** 2 > 64)).astype("u1")
    assert topology(skeleton(shell) > 0) == (1, 1, 0)


def test_each_label_is_thinned_by_itself():
    need_scipy()
    data = np.zeros((9, 12, 30), "i4")
    data[2:7, 3:8, 2:15] = 70000
    data[2:7, 3:8, 15:28] = -5
    got = skeleton(data)
    for label in 70000, -5:
        assert ((got == label) == (skeleton((data == label).astype("u1")) > 0)).all()
    assert set(np.unique(got)) == {0, 70000, -5}
    values = np.where(data, 2.5, np.nan).astype("f4")
    assert (skeleton(values, "--range", "2..3") == skeleton((data != 0).astype("u1"))).all()
    same_by_any_number_of_threads((reals((20, 30, 40)) > 0).astype("u2"), "skeleton")
    np.save("a.npy", values)
    result = volvis("skeleton", "a.npy", "-o", "b.npy", "--overwrite")
    assert result.code != 0 and "--range" in result.message, result.message


def test_skeletons_are_near_those_of_scikit_image():
    need_skimage()
    for seed in 1, 2:
        data = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=(30, 40, 50)), 2.5) > 0.02
        ours, theirs = skeleton(data.astype("u1")) > 0, morphology.skeletonize_3d(data) > 0
        assert 0.6 < ours.sum() / theirs.sum() < 1.6, (ours.sum(), theirs.sum())
        far = ndimage.distance_transform_edt(~theirs)[ours]
        assert np.mean(far <= 2) > 0.9, np.mean(far <= 2)


def gradients(values):
    return [np.gradient(values, axis=a) if values.shape[a] > 1 else np.zeros(values.shape) for a in range(3)]


def coherent(data, iterations, edge, step, sigma, rho, alpha):
    """Weickert 1999, with fluxes between neighbours, as the documentation says."""
    values = data.astype("f8")

    def smooth(v, s):
        return ndimage.gaussian_filter(v, [s if n > 1 else 0 for n in v.shape], mode="nearest", truncate=4)

    def shift(v, a, d):  # the neighbour along an axis; at the border the sample itself
        at = np.arange(v.shape[a]) + d
        return np.take(v, at.clip(0, v.shape[a] - 1), a)

    for _ in range(iterations):
        slopes = gradients(smooth(values, sigma))
        tensor = np.empty(values.shape + (3, 3))
        for a in range(3):
            for b in range(3):
                tensor[..., a, b] = smooth(slopes[a] * slopes[b], rho)
        flat = [a for a in range(3) if values.shape[a] == 1]
        for a in flat:  # the axis of one sample is none of the plane's
            tensor[..., a, a] = 1e9
        value, vector = np.linalg.eigh(tensor)
        kept = value[..., : 3 - len(flat)]
        k = sum((kept[..., i] - kept[..., j]) ** 2 for i in range(kept.shape[-1]) for j in range(i))
        with np.errstate(divide="ignore", over="ignore"):
            more = np.where(k > 0, (1 - alpha) * np.exp(-(edge**4) / k), 0)
        d = alpha * np.eye(3) + more[..., None, None] * vector[..., :, None, 0] * vector[..., None, :, 0]
        change = np.zeros(values.shape)
        central = [(shift(values, b, 1) - shift(values, b, -1)) / 2 for b in range(3)]
        for a in range(3):
            if values.shape[a] == 1:
                continue
            half = [(d[..., a, b] + shift(d[..., a, b], a, 1)) / 2 for b in range(3)]
            flux = half[a] * (shift(values, a, 1) - values)
            for b in range(3):
                if b != a:
                    flux += half[b] * (central[b] + shift(central[b], a, 1)) / 2
            flux[tuple(slice(-1, None) if i == a else slice(None) for i in range(3))] = 0
            before = np.roll(flux, 1, a)
            change += flux - before
        values = values + step * change
    return values


def test_diffusion_along_structures_is_that_of_numpy():
    need_scipy()
    for t, kind in enumerate(KINDS):
        shape = ((5, 9, 21), (1, 15, 17), (12, 1, 11))[t % 3]
        data = np.nan_to_num(blobs(kind, shape, t), nan=40).astype(kind)
        options = {"iterations": 4, "edge": 3.0, "step": 0.1, "sigma": 0.7, "rho": 1.4, "alpha": 0.01}
        words = [w for name, value in options.items() for w in ("--" + name, str(value))]
        got = filtered(data, "diffuse", "--method", "coherence", *words)
        want = coherent(data, **options)
        if got.dtype.kind != "f":  # other ends of types are not reached
            want = want.clip(0 if kind[0] == "u" else -128, 127 if kind == "i1" else 255)
        room = 2e-3 if got.dtype.kind == "f" else 0.502
        assert got.dtype == data.dtype and np.abs(got.astype("f8") - want).max() < room, (kind, np.abs(got - want).max())
        assert np.abs(want - data).max() > 2, kind
        if kind == "f8":
            assert abs(got.sum() - data.sum()) < 1e-6 * abs(data.sum())


def test_diffusion_along_structures_closes_gaps_and_leaves_what_is_missing():
    need_scipy()
    z, y, x = np.mgrid[0:1, 0:48, 0:48].astype("f8")
    lines = 100 * (np.sin((x + 2 * y) * 0.5) > 0.3)  # stripes that are broken in the middle
    broken = np.where(np.hypot(x - 24, y - 24) < 4, 50, lines).astype("f4")
    got = filtered(broken, "diffuse", "--method", "coherence", "--iterations", "40", "--edge", "1", "--sigma", "1", "--rho", "4")
    hole = (np.hypot(x - 24, y - 24) < 3).nonzero()
    assert np.corrcoef(got[hole], lines[hole])[0, 1] > 0.8
    data = blobs("f4", (7, 11, 13))
    got = filtered(data, "diffuse", "--method", "coherence", "--iterations", "2")
    assert (np.isnan(got) == np.isnan(data)).all() and not (got == data).all()
    same_by_any_number_of_threads(blobs("u2", (9, 21, 23)), "diffuse", "--method", "coherence", "--iterations", "3")
    result = volvis("diffuse", "a.npy", "-o", "b.npy", "--overwrite", "--method", "coherence", "--conductance", "rational")
    assert result.code != 0 and "conductance" in result.message, result.message
    result = volvis("diffuse", "a.npy", "-o", "b.npy", "--overwrite", "--rho", "2")
    assert result.code != 0 and "rho" in result.message, result.message
    np.save("c.npy", np.zeros((100, 100, 100), "f4"))
    result = volvis("diffuse", "c.npy", "-o", "b.npy", "--overwrite", "--method", "coherence", "--memory", "30M")
    assert result.code != 0 and "memory" in result.message, result.message


HEAD = "/usr/share/mricron/templates/ch2.nii.gz"


def smooth_field(shape, strength):
    """Brighter towards one corner and darker towards another; the mean of its logarithm is 0."""
    z, y, x = (np.linspace(-1, 1, n).reshape([-1 if i == a else 1 for i in range(3)]) for a, n in enumerate(shape))
    field = 0.6 * x - 0.4 * y * y + 0.3 * z + 0.3 * x * y
    return np.exp(strength * (field - field.mean()))


def phantom(shape, noise=2, seed=1):
    """Three tissues of 100, 160 and 220, and a background of 0 around."""
    data = np.digitize(reals(shape, seed) / reals(shape, seed).std(), [-0.4, 0.5]) * 60.0 + 100
    z, y, x = np.ogrid[0 : shape[0], 0 : shape[1], 0 : shape[2]]
    inside = sum((2 * c / (n - 1) - 1) ** 2 if n > 1 else 0 for c, n in zip((z, y, x), shape)) < 0.9
    return np.where(inside, data + np.random.default_rng(seed).normal(0, noise, shape), 0), inside


def spread(field, true, inside):
    """How far the logarithms of two fields differ, but for a factor."""
    return np.log(field / true)[inside].std()


def test_a_known_field_is_taken_off():
    need_scipy()
    for shape, kind in ((40, 50, 45), "f4"), ((33, 41, 37), "u2"), ((1, 120, 100), "f8"), ((36, 40, 44), "u1"):
        data, inside = phantom(shape)
        true = smooth_field(shape, 0.5)
        bright = np.where(inside, (data * true).clip(1, 255 if kind == "u1" else 1e9), 0).astype(kind)
        field = filtered(bright, "bias", "--levels", "3", "--output", "field")
        even = filtered(bright, "bias", "--levels", "3")
        before, after = np.log(true)[inside].std(), spread(field, true, inside)
        assert field.dtype == even.dtype == np.dtype("f4") and before > 0.1 and after < 0.2 * before, (shape, before, after)
        assert np.allclose(even * field, bright.astype("f8"), rtol=1e-5)
        assert abs(np.log(field[inside]).mean()) < 0.1
        middle = inside & (np.abs(data - 160) < 8)  # one tissue has one brightness again
        assert even[middle].std() / even[middle].mean() < 0.35 * (bright[middle].std() / bright[middle].mean())


def test_without_a_field_little_is_taken_off():
    need_scipy()
    data, inside = phantom((30, 36, 40))
    field = filtered(data.astype("f4"), "bias", "--levels", "2", "--output", "field")
    assert np.log(field[inside]).std() < 0.03, np.log(field[inside]).std()


def test_bias_is_found_where_the_mask_says_by_any_number_of_threads():
    need_scipy()
    data, inside = phantom((30, 36, 40))
    true = smooth_field(data.shape, 0.4)
    bright = (data * true).astype("f4")
    bright[:, :, -4:] = 9000  # an implant
    bright[3, 3, 3] = np.nan
    np.save("a.npy", bright)
    np.save("m.npy", (inside & (np.arange(40) < 36)).astype("u1"))
    ok("bias", "a.npy", "mask=m.npy", "-o", "b.npy", "--overwrite", "--output", "field")
    assert spread(np.load("b.npy"), true, np.load("m.npy") > 0) < 0.05
    ok("bias", "a.npy", "-o", "c.npy", "--overwrite", "--output", "field", "--range", "20..2000")
    assert spread(np.load("c.npy"), true, np.load("m.npy") > 0) < 0.05
    even = filtered(bright, "bias", "--range", "20..2000")
    assert np.isnan(even[3, 3, 3]) and np.isnan(even).sum() == 1
    same_by_any_number_of_threads(bright, "bias", "--levels", "2", "--range", "20..")
    for words, part in ((("--range", "-5..-1"), "needs 64 samples with values above 0, and there are 0 in the range: give a wider --range"), (("--distance", "0.01"), "fewer levels"), (("mask=b.npy", "--range", "x"), "range")):
        result = volvis("bias", "a.npy", "-o", "d.npy", "--overwrite", *words)
        assert result.code != 0 and part in result.message, (words, result.message)


def test_a_field_that_is_put_on_a_head_is_found():
    need_scipy()
    if not os.path.exists(HEAD):
        raise Skip("mricron-data is not there")
    for name, path in ("head", HEAD), ("brain", HEAD.replace("ch2", "ch2bet")):
        ok("convert", path, "-o", f"{name}.npy", "--overwrite")
    head, brain = np.load("head.npy").squeeze().astype("f4"), np.load("brain.npy").squeeze() > 0
    true = smooth_field(head.shape, 0.4)
    np.save("bright.npy", (head * true).astype("f4"))
    np.save("brain.npy", brain.astype("u1"))
    for words, share in (("mask=brain.npy",), 0.1), ((), 0.25):
        for name in "head", "bright":
            ok("bias", f"{name}.npy", *words, "-o", f"{name}-field.npy", "--overwrite", "--output", "field", "--every", "4")
        off = spread(np.load("bright-field.npy") / np.load("head-field.npy"), true, brain)
        assert off < share * np.log(true)[brain].std(), (words, off)



main()
